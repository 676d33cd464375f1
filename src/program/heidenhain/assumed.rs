//! What the job assumes of Q parameters, and the tool's radius (HEIDENHAIN, TNC 640 Conversational
//! Programming, "Preassigned Q parameters").

use std::collections::{BTreeMap, BTreeSet};

use super::Reader;
use super::block::{Parameters, Text};
use super::formula::RADIUS;
use crate::program::Assumed;
use crate::program::span::Held;
use crate::program::unread::{names, tell_unheeded};

/// Parameters below this are the program's own.
const FIRST_OF_CONTROL: u32 = 100;

/// The job's `assume`.
pub(super) struct Given<'a> {
    all: &'a BTreeMap<String, Assumed>,
    /// Those whose value is still the job's, and those that have been read.
    open: BTreeSet<u32>,
    read: BTreeSet<u32>,
    /// Q108, up to a change to another tool.
    radius: Option<f64>,
    has_loaded: bool,
    /// DR of the last TOOL CALL, which is a part of Q108.
    dr: Option<f64>,
}

impl<'a> Given<'a> {
    /// What the job gives, and the parameters that it sets.
    pub(super) fn new(all: &'a BTreeMap<String, Assumed>) -> (Self, Parameters) {
        let parameters: Parameters = all.iter().filter_map(parameter).collect();
        let open = parameters.keys().copied().collect();
        let radius = parameters.get(&RADIUS).map(|held| held.value);
        let read = BTreeSet::new();
        (Self { all, open, read, radius, has_loaded: false, dr: None }, parameters)
    }

    /// Whether a tool has been called.
    pub(super) fn has_loaded(&self) -> bool {
        self.has_loaded
    }

    /// TOOL CALL has another DR than the one before.
    pub(super) fn changes_dr(&mut self, dr: f64) -> bool {
        self.dr.replace(dr).is_some_and(|before| before != dr)
    }

    /// The program has another value, or none.
    pub(super) fn close(&mut self, number: u32) {
        self.open.remove(&number);
    }

    /// A block is run: what it reads counts.
    pub(super) fn heed(&mut self, text: &str) {
        let read = self.open.iter().copied().filter(|number| reads(text, *number));
        self.read.extend(read);
    }
}

/// A parameter of the program's own or the tool's radius, and its value.
fn parameter((key, value): (&String, &Assumed)) -> Option<(u32, Held)> {
    let number = key.strip_prefix('q')?.parse().ok()?;
    match value {
        Assumed::Number(value) if number < FIRST_OF_CONTROL || number == RADIUS => {
            Some((number, Held::worked_out(*value)))
        }
        _ => None,
    }
}

/// Whether a parameter stands in a text other than before `=`.
fn reads(text: &str, number: u32) -> bool {
    let name = format!("Q{number}");
    text.split(&name).skip(1).any(|rest| {
        !rest.starts_with(|c: char| c.is_ascii_digit()) && !rest.trim_start().starts_with('=')
    })
}

impl Reader<'_, '_> {
    /// TOOL CALL sets Q108: the job may say what it is for one tool.
    pub(super) fn measure(&mut self, is_other: bool) {
        self.given.has_loaded = true;
        if is_other {
            self.given.radius = None;
        }
        match self.given.radius {
            Some(radius) => {
                self.parameters.insert(RADIUS, Held::worked_out(radius));
                self.given.open.insert(RADIUS);
            }
            None => {
                self.parameters.remove(&RADIUS);
                self.given.open.remove(&RADIUS);
            }
        }
    }

    /// Tells of what the job assumes in vain, where it stands in this program: another one of the
    /// job may have the rest.
    pub(super) fn tell_unheeded(&mut self) {
        for own in self.given.all {
            let number = parameter(own).map(|(number, _)| number);
            if number.is_some_and(|number| self.given.read.contains(&number)) {
                continue;
            }
            let has = |text: &&Text<'_>| text.parts.iter().any(|part| names(part.1, own.0));
            let Some(text) = self.blocks.iter().find(has) else { continue };
            let may_be = "Q parameters from 0 to 99 and Q108, the tool's radius, may be assumed";
            let other = number.is_none().then_some(may_be);
            tell_unheeded(self.cutter.log, text.line, &own.0.to_uppercase(), other);
        }
    }
}
