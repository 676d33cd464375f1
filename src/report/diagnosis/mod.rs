//! A diagnosis, for people and for programs.

pub mod html;
pub mod json;
pub mod text;
mod words;
