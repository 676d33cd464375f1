//! The `detune` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    detune::cli::main()
}
