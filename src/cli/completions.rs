//! `detune completions`: what a shell needs to complete the command line.

use std::io::Write;

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use super::output::Sink;
use super::{Cli, Failure, Outcome};

/// Write a completion script for a shell.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  detune completions bash > \
                  ~/.local/share/bash-completion/completions/detune")]
pub(super) struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Writes one script.
pub(super) fn run(args: &CompletionsArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "detune", &mut script);
    Sink::Standard.write(&String::from_utf8_lossy(&script), out)?;
    Ok(Outcome::Pass)
}
