//! The `detune` command.

fn main() {}
