//! URDF → links and joints of a description, each with its line.
//!
//! urdf-rs reads the types, but cannot tell missing from zero, drops what is not a number, gives no
//! lines, and overflows the stack on deep nesting. So an audit of the XML comes first ([`audit`]):
//! it tells every fault with its line and hands on a plain copy of what concerns us, with harmless
//! stand-ins for what was faulty; urdf-rs reads that copy ([`read`]).

mod audit;
mod read;

pub(super) use read::{Urdf, read_urdf};
