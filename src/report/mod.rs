//! Pure functions from results to text: one renderer a file. Nothing here computes an engineering
//! quantity, reads a file, prints, or knows the model; the same results give the same bytes.

pub mod advise;
pub mod check;
pub mod cutting;
pub mod deflection;
pub mod diagnosis;
pub mod doctor;
mod drawing;
pub mod explain;
pub mod identify;
pub mod init;
pub mod job;
mod json;
mod layout;
pub mod lobes;
pub mod map;
mod page;
mod paths;
pub mod schema;
pub mod stiffness;
mod style;
pub mod trace;
mod words;

pub use drawing::Canvas;

/// A drawing and what it is called.
pub type Plot = (String, Canvas);
