//! What a user must know beside the numbers: errors that stop the work and warnings that do not.
//! One type for all rooms, so that every renderer shows them alike.

mod code;
mod collector;
mod note;

pub use code::{Class, Code};
pub use collector::Notes;
pub use note::{Note, Part, Place, Severity};
