//! `detune man`: pages of the manual.

use std::io::Write;

use clap::{Args, CommandFactory};
use clap_mangen::Man;

use super::output::Sink;
use super::{Cli, Failure, Outcome};
use crate::notes::Note;
use crate::wording::hint;

/// Write the manual page of the program or of one of its commands, for `man`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  detune man check > ~/.local/share/man/man1/detune-check.1")]
pub(super) struct ManArgs {
    /// The command; the program as a whole if not given.
    #[arg(value_name = "COMMAND")]
    command: Option<String>,
}

/// Writes one page.
pub(super) fn run(args: &ManArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut whole = Cli::command();
    whole.build();
    let page = match &args.command {
        None => Man::new(whole),
        Some(name) => match whole.find_subcommand(name) {
            Some(command) => Man::new(command.clone()),
            None => {
                let names = whole.get_subcommands().map(clap::Command::get_name);
                let what = format!("there is no command '{name}'{}", hint(name, names));
                return Err(vec![Note::usage(what)].into());
            }
        },
    };
    let mut text = Vec::new();
    page.render(&mut text)?;
    Sink::Standard.write_bytes(&text, out)?;
    Ok(Outcome::Pass)
}
