//! Programs read as a planner's tools write them: exact poses, lines, refusals.
//!
//! Expected poses are worked out by hand from the frames in the programs, never by the reader.

mod apt;
mod beside;
mod blocks;
mod carried;
mod cells;
mod controllers;
mod field;
mod filled;
mod fuzz;
mod gaps;
mod gcode;
mod heidenhain;
mod holes;
mod krl;
mod krl_open;
mod lengths;
mod others;
mod outputs;
mod patterns;
mod public;
mod rapid;
mod rapid_decided;
mod rapid_numbers;
mod rapid_others;
mod refusals;
mod robots;
mod sampled;
mod siemens;
mod signals;
mod silent;
mod stated;
mod stopped;
mod support;
mod synced;
mod tangents;
mod tool_tip;
mod tp;
mod tp_lines;
mod tp_waits;
mod turned;
mod unsaid;
mod variables;
mod whole;
mod written;
