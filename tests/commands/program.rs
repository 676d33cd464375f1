//! Runs the program as a user does.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

pub(crate) fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The program as it was built with these tests, and so with their features.
pub(crate) fn built() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_detune"))
}

/// The program under test: another build of it where `DETUNE_PROGRAM` names one.
pub(crate) fn tested() -> PathBuf {
    std::env::var_os("DETUNE_PROGRAM").map_or_else(built, PathBuf::from)
}

/// The command in a folder, not yet started; nothing on standard input, no wishes about colour.
pub(crate) fn command(folder: &Path, arguments: &[&str]) -> Command {
    command_of(&tested(), folder, arguments)
}

/// The same of a certain build.
pub(crate) fn command_of(program: &Path, folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
    command
}

/// Every format of `detune check`.
pub(crate) const FORMATS: [&str; 8] =
    ["text", "json", "sarif", "junit", "github", "html", "gitlab", "plot"];

pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

pub(crate) fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

pub(crate) fn out(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

/// Standard output with one blank between words.
pub(crate) fn flat(output: &Output) -> String {
    out(output).split_whitespace().collect::<Vec<_>>().join(" ")
}

pub(crate) fn err(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap()
}

pub(crate) fn json(output: &Output) -> Value {
    serde_json::from_str(out(output)).unwrap_or_else(|error| panic!("{error}: {}", err(output)))
}

/// A table of the two-link arm without its remarks.
fn rows_of(table: &str) -> (String, Vec<String>) {
    let whole = std::fs::read_to_string(repository().join("robots/two-link").join(table)).unwrap();
    let mut rows =
        whole.lines().filter(|line| !line.starts_with('#')).map(|row| format!("{row}\n"));
    (rows.next().unwrap(), rows.collect())
}

/// Every other row of a table of the two-link arm, where all of them would tell a test no more.
pub(crate) fn every_other_row(table: &str) -> String {
    let (header, rows) = rows_of(table);
    std::iter::once(header).chain(rows.into_iter().step_by(2)).collect()
}

/// The first rows of such a table, where it matters little what a diagnosis finds.
pub(crate) fn first_rows(table: &str, count: usize) -> String {
    let (header, rows) = rows_of(table);
    std::iter::once(header).chain(rows.into_iter().take(count)).collect()
}
