//! The programs of a cell, each a listing: the one that is checked, and those that it may CALL, in
//! its own file or in others.

use super::text::{Source, parse};
use crate::program::Companion;

/// All that is read; the program that is checked comes first.
#[derive(Debug)]
pub(super) struct Programs {
    main: Source,
    others: Vec<Source>,
}

impl Programs {
    /// Of the text that is checked, and of further files.
    pub(super) fn of(text: &str, companions: &[Companion]) -> Self {
        let mut own = listings(text);
        let main =
            own.next().map_or_else(Source::default, |(lines, at, text)| parse(text, lines, at));
        let mut others: Vec<Source> = own.map(|(lines, at, text)| parse(text, lines, at)).collect();
        for companion in companions {
            others.extend(
                listings(&companion.text)
                    .map(|(lines, at, text)| parse(text, lines, at).of_file(&companion.name)),
            );
        }
        for (index, other) in others.iter_mut().enumerate() {
            other.index = index + 1;
        }
        Self { main, others }
    }

    pub(super) fn main(&self) -> &Source {
        &self.main
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &Source> {
        std::iter::once(&self.main).chain(&self.others)
    }

    /// The program of a name, if one is read.
    pub(super) fn named(&self, name: &str) -> Result<Option<&Source>, String> {
        let mut found = self.all().filter(|own| own.name.eq_ignore_ascii_case(name));
        match (found.next(), found.next()) {
            (Some(first), Some(second)) => Err(format!(
                "CALL {name}: {} and {} have that name; leave one out of files",
                first.shown_file(),
                second.shown_file()
            )),
            (own, _) => Ok(own),
        }
    }
}

/// The listings in a text, from a /PROG behind an /END to the next: how many lines and bytes stand
/// before each, and its text.
fn listings(text: &str) -> impl Iterator<Item = (usize, usize, &str)> {
    let is = |line: &str, word: &str| {
        let start = line.trim_start().get(..word.len());
        start.is_some_and(|start| start.eq_ignore_ascii_case(word))
    };
    let (mut starts, mut at, mut has_ended) = (vec![(0, 0)], 0, false);
    for (index, line) in text.split_inclusive('\n').enumerate() {
        if has_ended && is(line, "/PROG") {
            starts.push((index, at));
        }
        has_ended = (has_ended || is(line, "/END")) && !is(line, "/PROG");
        at += line.len();
    }
    let ends: Vec<usize> = starts.iter().skip(1).map(|(_, at)| *at).chain([text.len()]).collect();
    starts
        .into_iter()
        .zip(ends)
        .map(|((lines, at), end)| (lines, at, text.get(at..end).unwrap_or("")))
}
