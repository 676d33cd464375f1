//! A diagnosis, for people and for programs.

pub mod html;
pub mod json;
mod plots;
pub mod text;
mod words;
