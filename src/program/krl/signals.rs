//! Names that the files give to outputs, `SIGNAL SPIN $ANOUT[1]`, `SIGNAL SPEED $OUT[1] TO
//! $OUT[16]`: an output and all its names are one to the job.

use std::collections::{BTreeSet, HashMap, HashSet};

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

    /// `$anout[1]`, `$out[1..16]`.
    fn of_key(key: &str) -> Option<Self> {
        let (list, index) = key.strip_suffix(']')?.split_once('[')?;
        let (first, last) = index.split_once("..").unwrap_or((index, index));
        let [first, last] = [first, last].map(str::parse);
        let (first, last) = (first.ok()?, last.ok()?);
        list.starts_with('$').then(|| Self { list: list.to_owned(), first, last })
    }

    fn key(&self) -> String {
        let Self { list, first, last } = self;
        if self.is_row() { format!("{list}[{first}..{last}]") } else { format!("{list}[{first}]") }
    }

    fn is_row(&self) -> bool {
        self.first < self.last
    }

    /// The keys of each by itself.
    fn elements(&self) -> impl Iterator<Item = String> {
        let list = self.list.clone();
        (self.first..=self.last).map(move |number| format!("{list}[{number}]"))
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
    /// `None` of a name that stands for several.
    by_name: HashMap<String, Option<Outputs>>,
    /// By the key of outputs.
    names: HashMap<String, Vec<String>>,
    /// By the key of an output: the rows that it belongs to.
    rows: HashMap<String, Vec<String>>,
    seen: HashSet<[String; 2]>,
}

impl Signals {
    pub(super) fn add(&mut self, name: String, outputs: Outputs) {
        let key = outputs.key();
        if !self.seen.insert([name.clone(), key.clone()]) {
            return;
        }
        let names = self.names.entry(key.clone()).or_default();
        if names.is_empty() && outputs.is_row() {
            for element in outputs.elements() {
                self.rows.entry(element).or_default().push(key.clone());
            }
        }
        names.push(name.clone());
        let known = self.by_name.entry(name).or_insert_with(|| Some(outputs.clone()));
        if known.as_ref() != Some(&outputs) {
            *known = None;
        }
    }

    /// The key of the outputs that a name stands for; the name itself where it is none, or of
    /// several.
    pub(super) fn key(&self, name: String) -> String {
        match self.by_name.get(&name) {
            Some(Some(outputs)) => outputs.key(),
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
    pub(super) fn shared_with(&self, key: &str) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        if self.rows.is_empty() {
            return found;
        }
        let Some(own) = Outputs::of_key(key) else { return found };
        let is_row = own.is_row() && own.last - own.first < LONGEST;
        for element in own.elements().take(LONGEST as usize) {
            found.extend(self.rows.get(&element).into_iter().flatten().cloned());
            found.extend(is_row.then_some(element));
        }
        found.remove(key);
        found
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
