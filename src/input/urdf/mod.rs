//! URDF → links and joints of a description, each with its line.
//!
//! urdf-rs reads every number that the model takes, but cannot tell missing from zero, drops what
//! is not a number, gives no lines, and overflows the stack on deep nesting. So an audit of the XML
//! comes first ([`audit`]): it reports every fault with its line and hands on a plain copy of links
//! and joints, with harmless values in place of faulty ones. It judges and keeps no number; urdf-rs
//! reads the copy ([`read`]).

mod audit;
mod read;
mod text;

pub(super) use read::{Urdf, read_urdf};
