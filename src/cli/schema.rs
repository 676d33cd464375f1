//! `detune schema`: JSON Schemas of the files that are read and written.

use std::io::Write;

use clap::{Args, ValueEnum};

use super::output::Sink;
use super::{Failure, Outcome};
use crate::notes::Note;
use crate::report;
use crate::study::input_schema;

const AFTER_HELP: &str = "\
Editors check a file that starts with
  # yaml-language-server: $schema=job.schema.json
against the schema written by
  detune schema job > job.schema.json";

/// Write the JSON Schema of a file that detune reads or writes.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct SchemaArgs {
    /// The file or output to describe.
    #[arg(value_enum)]
    of: Subject,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Subject {
    /// robot.yaml
    Robot,
    /// job.yaml
    Job,
    /// session.yaml
    Session,
    /// detune.toml
    Settings,
    /// marks.yaml
    Marks,
    /// A file of modes for `lobes`
    Modes,
    /// The output of `check --format json`
    Check,
    /// The output of `advise --format json`
    Advice,
    /// The output of `identify --format json`
    Identification,
    /// The output of `diagnose --format json`
    Diagnosis,
    /// The output of `cutting --format json`
    Cutting,
    /// The output of `deflection --format json`
    Deflection,
    /// The output of `lobes --format json`
    Lobes,
    #[value(hide = true)]
    Map,
    #[value(hide = true)]
    Stiffness,
}

/// Writes one schema.
pub(super) fn run(args: &SchemaArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let schema = match args.of {
        Subject::Robot => input_schema::robot(),
        Subject::Job => input_schema::job(),
        Subject::Session => input_schema::session(),
        Subject::Settings => input_schema::settings(),
        Subject::Marks => input_schema::marks(),
        Subject::Modes => input_schema::modes(),
        Subject::Check => report::schema::check(),
        Subject::Advice => report::schema::advice(),
        Subject::Identification => report::schema::identification(),
        Subject::Diagnosis => report::schema::diagnosis(),
        Subject::Cutting => report::schema::cutting(),
        Subject::Deflection => report::schema::deflection(),
        Subject::Lobes => report::schema::lobes(),
        Subject::Map => return Err(no_schema("map")),
        Subject::Stiffness => return Err(no_schema("stiffness")),
    };
    Sink::Standard.write(&format!("{schema:#}\n"), out)?;
    Ok(Outcome::Pass)
}

fn no_schema(verb: &str) -> Failure {
    let all = Subject::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    let described: Vec<String> =
        all.filter(|value| !value.is_hide_set()).map(|v| v.get_name().to_owned()).collect();
    let what =
        format!("the output of {verb} has no schema; there is one of {}", described.join(", "));
    vec![Note::usage(what)].into()
}
