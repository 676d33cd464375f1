//! Warnings on standard error, and whether there were any.

use std::cell::Cell;
use std::collections::HashSet;
use std::io::{self, Write};

use super::Outcome;
use indicatif::{ProgressBar, ProgressDrawTarget};

use crate::notes::Note;
use crate::study::check::Warning;
use crate::wording::printable;

/// What a run has warned of so far.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    any: Cell<bool>,
    /// Nothing but errors is shown.
    quiet: bool,
}

impl Warnings {
    /// None so far; with `quiet` they are counted and not shown.
    pub(super) fn new(quiet: bool) -> Self {
        Self { any: Cell::new(false), quiet }
    }

    /// A progress bar, as far as anything but errors is shown.
    pub(super) fn bar(&self, bar: ProgressBar) -> ProgressBar {
        if self.quiet {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        bar
    }

    /// Shows warnings, each once.
    pub(super) fn show<'n>(&self, warnings: impl IntoIterator<Item = &'n Note>) {
        let mut seen = HashSet::new();
        for note in warnings.into_iter().filter(|note| seen.insert(*note)) {
            self.any.set(true);
            self.line(&format!("warning: {note}"));
        }
    }

    /// Takes note of warnings that the output shows.
    pub(super) fn shown_elsewhere(&self, warnings: &[Note]) {
        self.any.set(self.any.get() || !warnings.is_empty());
    }

    /// Shows warnings on jobs; those that the job accepts as such.
    pub(super) fn show_of_jobs(&self, warnings: &[Warning]) {
        let (open, accepted): (Vec<_>, Vec<_>) =
            warnings.iter().partition(|warning| warning.accepted.is_none());
        self.show(open.into_iter().map(|warning| &warning.note));
        let mut seen = HashSet::new();
        for Warning { note, accepted, .. } in accepted {
            if let Some(terms) = accepted.as_ref().filter(|terms| seen.insert((note, *terms))) {
                self.line(&format!("accepted: {note} ({})", printable(&terms.to_string())));
            }
        }
    }

    fn line(&self, text: &str) {
        if !self.quiet {
            line(text);
        }
    }

    /// How a run ends that fails where there were warnings.
    pub(super) fn denied(&self, outcome: Outcome) -> Outcome {
        match outcome {
            Outcome::Pass if self.any.get() => {
                line("failed: there were warnings (--deny-warnings)");
                Outcome::Fail
            }
            other => other,
        }
    }
}

/// If standard error is closed, nobody reads it.
fn line(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}
