//! `detune explain`: what a code, a verdict or a cause means.

use std::io::Write;

use clap::Args;

use super::output::Sink;
use super::{Failure, Outcome};
use crate::report::explain as report;
use crate::study::explain::{all, explain};

/// Explain codes of errors and warnings, verdicts, and causes of a diagnosis.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  detune explain payload_unknown\n  detune explain")]
pub(super) struct ExplainArgs {
    /// As outputs spell it; all are listed if none is given.
    #[arg(value_name = "CODE")]
    names: Vec<String>,
}

/// Writes the explanations; if a name is unknown, reports all that are and writes nothing.
pub(super) fn run(args: &ExplainArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let (mut texts, mut errors) = (Vec::new(), Vec::new());
    for name in &args.names {
        match explain(name) {
            Ok(found) => texts.push(report::explanation(&found)),
            Err(error) => errors.push(error),
        }
    }
    if !errors.is_empty() {
        return Err(errors.into());
    }
    let text = if args.names.is_empty() { report::list(&all()) } else { texts.join("\n") };
    Sink::Standard.write(&text, out)?;
    Ok(Outcome::Pass)
}
