//! Runs `detune map` on the paper's arm.

use std::io::Write;
use std::process::{Command, Output, Stdio};

use crate::program::{self, repository};

/// The command, not yet started; `line` follows `detune map`.
pub(crate) fn command(line: &str) -> Command {
    let arguments: Vec<&str> = ["map"].into_iter().chain(line.split_whitespace()).collect();
    program::command_of(&program::built(), repository(), &arguments)
}

/// Standard output, or the lines that say why there is none.
pub(crate) fn result(output: Output) -> Result<Vec<u8>, Vec<String>> {
    let text = String::from_utf8(output.stderr).unwrap();
    match output.status.code() {
        Some(0) => Ok(output.stdout),
        Some(2) => Err(text.lines().map(str::to_owned).collect()),
        other => panic!("exit code {other:?}: {text}"),
    }
}

pub(crate) fn map(line: &str) -> Result<String, Vec<String>> {
    result(command(line).output().unwrap()).map(|bytes| String::from_utf8(bytes).unwrap())
}

pub(crate) fn bytes(line: &str) -> Result<Vec<u8>, Vec<String>> {
    result(command(line).output().unwrap())
}

/// The same with `input` on standard input.
pub(crate) fn fed(line: &str, input: &[u8]) -> Result<Vec<u8>, Vec<String>> {
    let mut child = command(line)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_vec();
    // A command that refuses its input does not read it to the end.
    let feeder = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    result(output)
}

pub(crate) fn data(name: &str) -> Vec<u8> {
    let folder = repository().join("tests/data/npy");
    std::fs::read(folder.join(name)).unwrap()
}
