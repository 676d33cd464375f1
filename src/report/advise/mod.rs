//! Advice as text, JSON and a picture.

pub mod json;
pub mod svg;
pub mod text;
pub(super) mod words;
