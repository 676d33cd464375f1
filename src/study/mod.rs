//! One module a verb: from valid inputs to a result that holds everything that any renderer shows, and what is to
//! be written back. What a command line, a Python module or a server needs of detune, and nothing of how it is shown.

pub mod map;
