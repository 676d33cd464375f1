//! The faults of one file as they are found.

use std::path::{Path, PathBuf};

use super::Fault;

/// More faults than this in one file help nobody; the rest are counted.
const MOST_FAULTS: usize = 200;

/// Faults of one file, in the order found.
#[derive(Debug)]
pub(super) struct Faults {
    file: PathBuf,
    list: Vec<Fault>,
    further: usize,
}

impl Faults {
    pub(super) fn of(file: &Path) -> Self {
        Self { file: file.to_owned(), list: Vec::new(), further: 0 }
    }

    /// A fault without keeping it: for notices, and for what ends the reading.
    pub(super) fn make(&self, line: impl Into<Option<usize>>, what: impl Into<String>) -> Fault {
        Fault { file: Some(self.file.clone()), line: line.into(), what: what.into() }
    }

    pub(super) fn add(&mut self, line: impl Into<Option<usize>>, what: impl Into<String>) {
        if self.list.len() < MOST_FAULTS {
            let fault = self.make(line, what);
            self.list.push(fault);
        } else {
            self.further += 1;
        }
    }

    pub(super) fn count(&self) -> usize {
        self.list.len() + self.further
    }

    /// Whether further faults are counted only.
    pub(super) fn is_full(&self) -> bool {
        self.list.len() >= MOST_FAULTS
    }

    /// With the fault that ended the reading.
    pub(super) fn finish_with(mut self, last: Fault) -> Vec<Fault> {
        self.list.push(last);
        self.finish()
    }

    /// By line, each once, with a last entry for those that were not kept.
    pub(super) fn finish(mut self) -> Vec<Fault> {
        self.list.sort_by_key(|fault| fault.line);
        self.list.dedup();
        if self.further > 0 {
            let what = format!("and {} more", self.further);
            self.list.push(self.make(None, what));
        }
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_come_by_line_and_the_flood_is_counted() {
        let mut faults = Faults::of(Path::new("x.yaml"));
        faults.add(7, "second");
        faults.add(3, "first");
        faults.add(7, "second");
        let told: Vec<String> = faults.finish().iter().map(Fault::to_string).collect();
        assert_eq!(told, ["x.yaml:3: first", "x.yaml:7: second"]);

        let mut flood = Faults::of(Path::new("x.yaml"));
        for line in 1..=MOST_FAULTS + 5 {
            flood.add(line, "bad");
        }
        let told = flood.finish();
        assert_eq!(told.len(), MOST_FAULTS + 1);
        assert_eq!(told[MOST_FAULTS].to_string(), "x.yaml: and 5 more");
    }
}
