//! The command line: one file a verb. The only place that names clap, prints, writes files and
//! shows progress.

mod advise;
mod affected;
mod check;
mod completions;
mod cutting;
mod deflection;
mod diagnose;
mod doctor;
mod explain;
mod identify;
mod init;
mod lobes;
mod man;
mod map;
mod merge;
mod output;
mod plots;
mod report;
mod repository;
mod schema;
mod staged;
mod started;
mod stiffness;
mod trace;
mod warnings;

use std::any::Any;
use std::cell::Cell;
use std::ffi::OsString;
use std::io::{self, BufWriter, Write};
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

use clap::{Parser, Subcommand, ValueEnum};

use self::warnings::Warnings;
use crate::notes::{Note, Severity};

const ABOUT: &str = "Predicts whether a milling, drilling or deburring job will excite a \
resonance of the robot arm that runs it: where along the path, in which mode, and at which \
spindle speeds it will not.";

const AFTER_HELP: &str = "\
Examples:
  detune check jobs/pocket.yaml
  detune check --format sarif --output detune.sarif jobs/*.yaml
  detune advise jobs/pocket.yaml --write jobs/pocket-quiet.yaml
  detune schema job > job.schema.json

Exit codes:
  0  the job passes (an uncertain verdict warns and passes, see check --fail-on)
  1  the job fails its policy, or no safe speed exists; with --deny-warnings, on any warning
  2  a file or the command line is wrong
  3  an internal error";

/// The command line.
#[derive(Debug, Parser)]
#[command(name = "detune", version, about = ABOUT, after_help = AFTER_HELP, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
    /// Exit with code 1 where there are warnings that the job does not accept; the output is
    /// written all the same.
    #[arg(long, global = true)]
    deny_warnings: bool,
    /// Write nothing but errors to standard error: no warnings, no progress. Output and exit code
    /// stay as they are.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// How many poses of each operation `check --format json` lists.
    #[arg(long, global = true, value_enum, value_name = "HOW_MANY", default_value_t = Samples::All)]
    samples: Samples,
}

/// Scripts read every pose of check/1, so all are listed unless somebody wants fewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Samples {
    /// None: some hundred jobs in a few MB.
    None,
    /// Every hundredth of the path, and those about crossings.
    Thin,
    /// Every pose that was looked at.
    All,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Check(check::CheckArgs),
    Advise(advise::AdviseArgs),
    Report(report::ReportArgs),
    Lobes(lobes::LobesArgs),
    Deflection(deflection::DeflectionArgs),
    Cutting(cutting::CuttingArgs),
    Map(Box<map::MapArgs>),
    Merge(merge::MergeArgs),
    Identify(identify::IdentifyArgs),
    Trace(trace::TraceArgs),
    Diagnose(diagnose::DiagnoseArgs),
    Stiffness(stiffness::StiffnessArgs),
    Init(init::InitArgs),
    Doctor(doctor::DoctorArgs),
    Explain(explain::ExplainArgs),
    Affected(affected::AffectedArgs),
    Schema(schema::SchemaArgs),
    Completions(completions::CompletionsArgs),
    Man(man::ManArgs),
}

/// How a verb ended, if nothing was wrong with what it was given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Pass,
    /// Exit code 1: the job fails its policy, no safe speed exists, or warnings are denied.
    Fail,
}

/// Why a verb could not do its work.
#[derive(Debug)]
pub enum Failure {
    /// Exit code 2: files or command line are wrong.
    Input(Vec<Note>),
    /// Exit code 2: an output could not be written (a closed pipe on standard output ends quietly).
    Output(io::Error),
    /// Exit code 3: an internal error.
    Internal(String),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

impl From<Vec<Note>> for Failure {
    fn from(faults: Vec<Note>) -> Self {
        Self::Input(faults)
    }
}

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    staged::clear_on_signals();
    ExitCode::from(run_with(std::env::args_os()))
}

/// Runs the command with these arguments, the first of which is its name; its exit code.
pub fn run_with(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    if asks_for_build(&arguments) {
        return told(|| io::stdout().write_all(build().as_bytes()));
    }
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        // Help and version.
        Err(error) if !error.use_stderr() => return told(|| error.print()),
        Err(error) => {
            // If standard error is closed, nobody reads it.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    let written = Cell::new(0);
    let ended = guarded(|| {
        let mut out =
            Counted { inner: BufWriter::new(Standard(io::stdout().lock())), bytes: &written };
        let warnings = Warnings::new(cli.quiet);
        let outcome = run(&cli, &mut out, &warnings)?;
        unless_closed(out.flush())?;
        Ok(if cli.deny_warnings { warnings.denied(outcome) } else { outcome })
    });
    let wrote = written.get() > 0;
    exit_code(ended, wrote, &mut io::stderr().lock())
}

/// Prints what is no verb's output; the exit code.
fn told(print: impl FnOnce() -> io::Result<()>) -> u8 {
    let printed = refuse_closed().and_then(|()| print()).and_then(|()| io::stdout().flush());
    exit_code(printed.map(|()| Outcome::Pass).map_err(Failure::from), false, &mut io::stderr())
}

/// An error where standard output was closed from the start. One that its reader closes is no
/// failure.
fn refuse_closed() -> io::Result<()> {
    match started::without_output() {
        true => Err(io::Error::other("standard output is closed")),
        false => Ok(()),
    }
}

/// Standard output.
struct Standard<W>(W);

impl<W: Write> Write for Standard<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        refuse_closed()?;
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// `--version --verbose`, in any order.
fn asks_for_build(arguments: &[OsString]) -> bool {
    let given = arguments.get(1..).unwrap_or_default();
    let has = |words: [&str; 2]| given.iter().any(|word| words.iter().any(|own| word == own));
    given.len() == 2 && has(["--version", "-V"]) && has(["--verbose", "-v"])
}

/// What a report of a fault should say of the program.
fn build() -> String {
    let arrow = if cfg!(feature = "arrow") { "yes" } else { "no" };
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    format!(
        "detune {}\ntarget: {} {}\ninstructions: {}\napache arrow: {arrow}\nbuild: {profile}\n",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::ARCH,
        std::env::consts::OS,
        crate::study::map::instructions(),
    )
}

/// Counts what is on its way to standard output.
struct Counted<'a, W> {
    inner: W,
    bytes: &'a Cell<usize>,
}

impl<W: Write> Write for Counted<'_, W> {
    fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(buf)?;
        self.bytes.set(self.bytes.get() + count);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

fn run(cli: &Cli, out: &mut dyn Write, warnings: &Warnings) -> Result<Outcome, Failure> {
    match &cli.verb {
        Verb::Check(args) => check::run(args, cli.samples, out, warnings),
        Verb::Advise(args) => advise::run(args, out, warnings),
        Verb::Cutting(args) => cutting::run(args, out, warnings),
        Verb::Deflection(args) => deflection::run(args, out, warnings),
        Verb::Diagnose(args) => diagnose::run(args, out, warnings),
        Verb::Map(args) => map::run(args, out, warnings),
        Verb::Merge(args) => merge::run(args, out, warnings),
        Verb::Stiffness(args) => stiffness::run(args, out, warnings),
        Verb::Trace(args) => trace::run(args, out, warnings),
        Verb::Identify(args) => identify::run(args, out, warnings),
        Verb::Lobes(args) => lobes::run(args, out, warnings),
        Verb::Report(args) => report::run(args, out, warnings),
        Verb::Affected(args) => affected::run(args, cli.samples, out, warnings),
        Verb::Init(args) => init::run(args, out, warnings),
        Verb::Doctor(args) => doctor::run(args, out, warnings),
        Verb::Schema(args) => schema::run(args, out),
        Verb::Explain(args) => explain::run(args, out),
        Verb::Man(args) => man::run(args, out),
        Verb::Completions(args) => completions::run(args, out),
    }
}

/// A fault of a request at the option that asked for it: the key of the request is its name.
fn of_option(mut fault: Note) -> Note {
    match std::mem::take(&mut fault.place.key) {
        "" => {}
        key => fault.what = format!("--{key}: {}", fault.what),
    }
    fault
}

/// A folder stands for the robot.yaml in it.
fn robot_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("robot.yaml") } else { path.to_owned() }
}

/// The reader of a pipe may leave when it has seen enough: that is no failure.
fn unless_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Exit code of how a verb ended; writes why it failed.
fn exit_code(ended: Result<Outcome, Failure>, wrote: bool, err: &mut dyn Write) -> u8 {
    let (code, lines) = match ended {
        Ok(Outcome::Pass) => (0, Vec::new()),
        Ok(Outcome::Fail) => (1, Vec::new()),
        Err(Failure::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => (0, Vec::new()),
        Err(Failure::Output(error)) => {
            (2, vec![format!("error: output cannot be written: {error}")])
        }
        Err(Failure::Input(faults)) => (2, error_lines(&faults, wrote)),
        Err(Failure::Internal(what)) => {
            (3, vec![format!("internal error in detune, please report it: {}", one_line(&what))])
        }
    };
    for line in lines {
        // If standard error is closed, nobody reads it.
        let _ = writeln!(err, "{line}");
    }
    code
}

/// One line per fault, each once, and what to do next; `wrote` where some of the output is out
/// already.
fn error_lines(faults: &[Note], wrote: bool) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for fault in faults {
        let line = match fault.severity {
            Severity::Error => format!("error: {fault}"),
            Severity::Warning => format!("warning: {fault}"),
        };
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    let done = if wrote { "the output is incomplete" } else { "nothing was done" };
    // Without their number: a long list is cut, and says itself how many more there are.
    let what = if lines.len() == 1 { "this" } else { "these errors" };
    lines.push(format!("{done}: fix {what} and run the command again"));
    lines
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs a piece of the program; a panic in it, on whatever thread, is an internal error.
fn guarded(work: impl FnOnce() -> Result<Outcome, Failure>) -> Result<Outcome, Failure> {
    static FIRST_PANIC: Mutex<Option<String>> = Mutex::new(None);
    panic::set_hook(Box::new(|info| {
        let what = message(info.payload());
        let place =
            info.location().map_or(String::new(), |at| format!(" ({}:{})", at.file(), at.line()));
        FIRST_PANIC
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get_or_insert(format!("{what}{place}"));
    }));
    let ended = panic::catch_unwind(AssertUnwindSafe(work));
    drop(panic::take_hook());
    ended.unwrap_or_else(|payload| {
        let first = FIRST_PANIC.lock().unwrap_or_else(PoisonError::into_inner).take();
        Err(Failure::Internal(first.unwrap_or_else(|| message(payload.as_ref()))))
    })
}

fn message(payload: &(dyn Any + Send)) -> String {
    match (payload.downcast_ref::<&str>(), payload.downcast_ref::<String>()) {
        (Some(text), _) => (*text).to_owned(),
        (_, Some(text)) => text.clone(),
        (None, None) => "unknown".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use rayon::iter::{IntoParallelIterator, ParallelIterator};

    use super::*;
    use crate::notes::{Code, Place};

    fn reported(ended: Result<Outcome, Failure>) -> (u8, String) {
        let mut err = Vec::new();
        let code = exit_code(ended, false, &mut err);
        (code, String::from_utf8(err).unwrap())
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn outcomes_have_their_exit_codes() {
        let closed = io::Error::from(io::ErrorKind::BrokenPipe);
        let full = io::Error::from(io::ErrorKind::StorageFull);
        assert_eq!(reported(Ok(Outcome::Pass)), (0, String::new()));
        assert_eq!(reported(Ok(Outcome::Fail)), (1, String::new()));
        assert_eq!(reported(Err(Failure::Output(closed))), (0, String::new()));
        assert_eq!(reported(Err(Failure::Output(full))).0, 2);
        assert_eq!(reported(Err(Failure::Input(Vec::new()))).0, 2);
        assert_eq!(
            reported(Err(Failure::Internal("two\n lines".into()))),
            (3, "internal error in detune, please report it: two lines\n".into())
        );
    }

    #[test]
    fn each_fault_is_reported_once() {
        let fault =
            |line: Option<usize>| Note::error(Code::Value, Place::line("a.yaml", line), "bad");
        let (code, text) =
            reported(Err(Failure::Input(vec![fault(Some(3)), fault(None), fault(Some(3))])));
        assert_eq!(code, 2);
        assert_eq!(
            text,
            "error: a.yaml:3: bad\nerror: a.yaml: bad\n\
             nothing was done: fix these errors and run the command again\n"
        );
    }

    /// One test for all panics: the hook is the process's.
    #[test]
    fn a_panic_on_any_thread_is_a_fault_of_the_program() {
        let (code, text) = reported(guarded(|| panic!("out of {}", "range")));
        assert_eq!(code, 3);
        assert!(text.contains("out of range (src/cli/mod.rs:"), "{text}");
        assert_eq!(text.lines().count(), 1);
        let (code, text) = reported(guarded(|| {
            (0..8).into_par_iter().for_each(|i| assert!(i != 5, "five"));
            Ok(Outcome::Pass)
        }));
        assert_eq!(code, 3);
        assert!(text.contains("five"), "{text}");
        assert_eq!(reported(guarded(|| Ok(Outcome::Fail))).0, 1);
    }
}
