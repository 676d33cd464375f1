//! Names that the files give to outputs, `SIGNAL SPIN $ANOUT[1]`, `SIGNAL SPEED $OUT[1] TO
//! $OUT[16]`: an output and all its names are one to the job.

use std::collections::HashMap;

use super::lexer::Kind;
use crate::program::cell::all;
use crate::program::{Setter, Settings};

/// More outputs than make one number.
const LONGEST: u32 = 64;

/// One output, or a row of them that are set as one number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Outputs {
    /// `$anout`, in lower case.
    list: String,
    first: u32,
    last: u32,
}

impl Outputs {
    /// `SIGNAL` with the name, and what it stands for.
    pub(super) fn named(tokens: &[Kind]) -> Option<(String, Self)> {
        let at = tokens.iter().position(|token| *token == Kind::Word("signal".to_owned()))?;
        let [Kind::Word(name), rest @ ..] = tokens.get(at + 1..)? else { return None };
        let (list, first, rest) = element(rest)?;
        let last = match rest {
            [] => first,
            [Kind::Word(to), rest @ ..] if to == "to" => {
                element(rest).filter(|(other, ..)| *other == list)?.1
            }
            _ => return None,
        };
        let is_row = first <= last && last - first < LONGEST;
        is_row.then(|| (name.clone(), Self { list: list.to_owned(), first, last }))
    }

    /// `$anout[1]`.
    fn of_key(key: &str) -> Option<Self> {
        let (list, index) = key.strip_suffix(']')?.split_once('[')?;
        let number = index.parse().ok().filter(|_| list.starts_with('$'))?;
        Some(Self { list: list.to_owned(), first: number, last: number })
    }

    fn key(&self) -> String {
        let Self { list, first, last } = self;
        if first == last { format!("{list}[{first}]") } else { format!("{list}[{first}..{last}]") }
    }

    /// Each by itself.
    fn elements(&self) -> impl Iterator<Item = String> {
        let list = self.list.clone();
        (self.first..=self.last).map(move |number| format!("{list}[{number}]"))
    }

    fn share(&self, other: &Self) -> bool {
        self.list == other.list && self.first <= other.last && other.first <= self.last
    }
}

/// `$OUT[1]` and what follows.
fn element(tokens: &[Kind]) -> Option<(&str, u32, &[Kind])> {
    let [
        Kind::Word(list),
        Kind::Symbol("["),
        Kind::Number(number, ..),
        Kind::Symbol("]"),
        rest @ ..,
    ] = tokens
    else {
        return None;
    };
    (list.starts_with('$') && number.fract() == 0.0).then_some((list, *number as u32, rest))
}

/// What the files say that names stand for, all in lower case.
#[derive(Debug, Default)]
pub(super) struct Signals {
    by_name: HashMap<String, Vec<Outputs>>,
    /// By the key of outputs.
    names: HashMap<String, Vec<String>>,
}

impl Signals {
    pub(super) fn add(&mut self, name: String, outputs: Outputs) {
        let known = self.by_name.entry(name.clone()).or_default();
        if !known.contains(&outputs) {
            self.names.entry(outputs.key()).or_default().push(name);
            known.push(outputs);
        }
    }

    /// The key of the outputs that a name stands for; the name itself where it is none, or of
    /// several.
    pub(super) fn key(&self, name: String) -> String {
        match self.by_name.get(&name).map(Vec::as_slice) {
            Some([outputs]) => outputs.key(),
            _ => name,
        }
    }

    /// Whether a file says what a name stands for.
    pub(super) fn knows(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// The names of what has this key.
    pub(super) fn names_of(&self, key: &str) -> &[String] {
        self.names.get(key).map_or(&[], Vec::as_slice)
    }

    /// Keys of other outputs and rows of them that share one with these.
    pub(super) fn shared_with(&self, key: &str) -> Vec<String> {
        let named =
            || self.names_of(key).iter().filter_map(|name| self.by_name.get(name)).flatten();
        let row = || named().find(|known| known.key() == key).cloned();
        let Some(own) = Outputs::of_key(key).or_else(row) else { return Vec::new() };
        let rows = self.by_name.values().flatten();
        let rows = rows.filter(|other| **other != own && other.share(&own)).map(Outputs::key);
        let is_row = own.first < own.last;
        let single = own.elements().filter(|_| is_row);
        rows.chain(single).collect()
    }

    /// Other names of what the job reads the spindle or the tool from.
    pub(super) fn further_names(&self, settings: &Settings) -> Vec<String> {
        let given: Vec<String> = named_by(settings).collect();
        let others = |own: &String| -> Vec<String> {
            let key = self.key(own.clone());
            let names = self.names_of(&key).iter().cloned();
            names.chain([key.clone()]).filter(|name| name != own).collect()
        };
        given.iter().flat_map(others).collect()
    }
}

/// The signals that the job names, in lower case.
pub(super) fn named_by(settings: &Settings) -> impl Iterator<Item = String> {
    all(settings).filter_map(|(_, by)| match &by.what {
        Setter::Signal(name) => Some(name.to_lowercase()),
        _ => None,
    })
}
