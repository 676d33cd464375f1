//! The lines of a program, and behind them those of the files that the job names beside it.

use std::ops::Range;
use std::path::Path;

use crate::program::Companion;

/// Lines without their ends, each with where it begins; an empty one stands behind each file.
pub(super) struct Files<'t> {
    pub(super) lines: Vec<(usize, &'t str)>,
    /// Where each file ends: the empty line.
    ends: Vec<usize>,
    companions: &'t [Companion],
}

impl<'t> Files<'t> {
    pub(super) fn new(text: &'t str, companions: &'t [Companion]) -> Self {
        let (mut lines, mut ends) = (Vec::new(), Vec::new());
        for text in std::iter::once(text).chain(companions.iter().map(|own| own.text.as_str())) {
            let mut start = 0;
            lines.extend(text.split_inclusive('\n').map(|whole| {
                let at = start;
                start += whole.len();
                (at, whole.trim_end_matches(['\n', '\r']))
            }));
            ends.push(lines.len());
            lines.push((0, ""));
        }
        Self { lines, ends, companions }
    }

    /// The lines of the program itself.
    pub(super) fn main(&self) -> &[(usize, &'t str)] {
        self.lines.get(..self.ends[0]).unwrap_or_default()
    }

    /// The file of a line, the program's own first.
    fn file(&self, line: usize) -> usize {
        self.ends.partition_point(|end| *end < line)
    }

    fn first(&self, file: usize) -> usize {
        file.checked_sub(1).and_then(|before| self.ends.get(before)).map_or(0, |end| end + 1)
    }

    /// All lines of the file that this one is of.
    pub(super) fn around(&self, line: usize) -> Range<usize> {
        let file = self.file(line);
        self.first(file)..self.ends.get(file).copied().unwrap_or(self.lines.len())
    }

    /// Whether a file ends here.
    pub(super) fn is_end(&self, line: usize) -> bool {
        self.ends.binary_search(&line).is_ok()
    }

    /// `SUB.SPF:3: ` of a line beside the program.
    pub(super) fn beside(&self, line: usize) -> Option<String> {
        let file = self.file(line);
        let companion = self.companions.get(file.checked_sub(1)?)?;
        Some(format!("{}:{}: ", companion.name, line - self.first(file) + 1))
    }

    /// The first line of a file by its name, without extension.
    pub(super) fn named(&self, name: &str) -> Option<usize> {
        let is = |own: &Companion| {
            let stem = Path::new(&own.name).file_stem().and_then(|stem| stem.to_str());
            stem.is_some_and(|stem| stem.eq_ignore_ascii_case(name))
        };
        self.companions.iter().position(is).map(|index| self.first(index + 1))
    }
}
