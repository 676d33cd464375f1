//! Parameters of G-code: what the program has set, and the locals of its calls.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap, HashSet};

use super::assumed::{DIAMETER, Given, may_be_assumed};
use super::predefined::{Predefined, PredefinedName, name_of};
use super::words::is_r_parameter;
use crate::program::span::{Held, Span};
use crate::program::unread::read_of_lost;

/// Parameters that a program may set in all.
const MAX_PARAMETERS: usize = 100_000;

/// What the program has set.
#[derive(Debug, Default, Clone)]
pub(super) struct Parameters {
    numbered: HashMap<i64, Held>,
    /// By name in lower case; Sinumerik's R parameters as `r1`.
    named: HashMap<String, Held>,
    /// By name, what those that are not real numbers make of a value whenever they are set.
    rounded: HashMap<String, fn(f64) -> f64>,
    /// Of Sinumerik's, in which R parameters and what the job declares are known to all programs.
    is_sinumerik: bool,
    /// Calls that are open; of a macro (G65), locals that were not given are vacant.
    are_macros: Vec<bool>,
    /// By name as in the job, those that a refused block would have set.
    lost: HashSet<String>,
    /// Names of variables that are declared as texts, whose values are not read.
    texts: HashSet<String>,
    /// What the job assumes of those that the program has not set.
    pub(super) given: Given,
    /// The diameter of the tool in the spindle, or why it is not known.
    pub(super) diameter: Option<Result<f64, String>>,
    pub(super) predefined: Predefined,
    /// Of Sinumerik's main program, while a subprogram runs.
    of_main: HashMap<String, Held>,
    /// Those of them that a subprogram has read, until it is told.
    read_of_main: RefCell<BTreeSet<String>>,
}

/// What belongs to one call: #1 to #33, and names that do not begin with an underscore.
#[derive(Debug, Default)]
pub(super) struct Locals {
    numbered: HashMap<i64, Held>,
    named: HashMap<String, Held>,
    /// By name, what those that are not real numbers make of a value.
    rounded: HashMap<String, fn(f64) -> f64>,
    lost: HashSet<String>,
    /// Names of variables that are declared as texts.
    texts: HashSet<String>,
}

/// A parameter, its value, and where the number stands.
pub(super) type Set = (Key, f64, Option<Span>);

/// A parameter as the text names it.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Key {
    Number(i64),
    Name(String),
    /// A variable that is declared as a whole number.
    Whole(String),
    /// A variable that is declared as true or false: any value but 0 is true, which is 1.
    Truth(String),
}

impl Key {
    /// Whether it is rounded or not.
    pub(super) fn name(&self) -> Result<&str, i64> {
        match self {
            Self::Number(number) => Err(*number),
            Self::Name(name) | Self::Whole(name) | Self::Truth(name) => Ok(name),
        }
    }

    /// As the job names it, in lower case.
    fn in_job(&self) -> Cow<'_, str> {
        match self.name() {
            Ok(name) => Cow::Borrowed(name),
            Err(number) => Cow::Owned(format!("#{number}")),
        }
    }
}

impl Parameters {
    pub(super) fn new(is_sinumerik: bool, given: Given) -> Self {
        Self { is_sinumerik, given, ..Self::default() }
    }

    pub(super) fn is_sinumerik(&self) -> bool {
        self.is_sinumerik
    }

    pub(super) fn set(&mut self, key: Key, value: f64, span: Option<Span>) -> Result<(), String> {
        if !self.lost.is_empty() {
            self.lost.remove(&*key.in_job());
        }
        // Behind a value the job's has no effect, and behind none, either. Where a call of
        // Sinumerik's has a value that another does not know, the job is not asked for one.
        if value.is_nan() || self.is_sinumerik || !self.given.is_empty() {
            self.given.close(&key.in_job());
        }
        if value.is_nan() {
            match key {
                Key::Number(number) => self.numbered.remove(&number),
                Key::Name(name) | Key::Whole(name) | Key::Truth(name) => self.named.remove(&name),
            };
            return Ok(());
        }
        if !value.is_finite() {
            return Err(format!("{} would not be a finite number", self.shown(&key)));
        }
        if self.numbered.len() + self.named.len() >= MAX_PARAMETERS {
            return Err("the program sets too many parameters".to_owned());
        }
        let held = Held { value, span };
        let rounded = |round: fn(f64) -> f64| Held::worked_out(round(value));
        match key {
            Key::Number(0) => return Err("#0 cannot be set".to_owned()),
            Key::Number(number) => self.numbered.insert(number, held),
            Key::Name(name) => {
                let held = self.rounded.get(&name).map_or(held, |round| rounded(*round));
                self.named.insert(name, held)
            }
            Key::Whole(name) => {
                self.rounded.insert(name.clone(), f64::round);
                self.named.insert(name, rounded(f64::round))
            }
            Key::Truth(name) => {
                self.rounded.insert(name.clone(), truth);
                self.named.insert(name, rounded(truth))
            }
        };
        Ok(())
    }

    /// A block that would set it is refused: what it is behind that is not known.
    pub(super) fn lose(&mut self, key: Key) {
        let name = key.in_job().into_owned();
        // No value takes it away, which is no error.
        let _ = self.set(key, f64::NAN, None);
        self.lost.insert(name);
    }

    /// Not a number where the parameter is vacant, as #0 always is.
    pub(super) fn get(&self, key: &Key) -> Result<f64, String> {
        if self.lost.contains(&*key.in_job()) {
            return Err(read_of_lost(&self.shown(key)));
        }
        let is_vacant = match key {
            Key::Number(0) => true,
            Key::Number(1..=33) => self.are_macros.last() == Some(&true),
            _ => false,
        };
        let found = self.held(key).map(|held| held.value).or(is_vacant.then_some(f64::NAN));
        if let (Some(_), Ok(name)) = (found, key.name()) {
            self.given.read_of_program(name);
        }
        if *key == Key::Number(DIAMETER) {
            let found = found.map(Ok).or_else(|| self.diameter.clone());
            return found.unwrap_or_else(|| {
                Err(format!(
                    "#{DIAMETER} is the diameter of the tool in the spindle (LinuxCNC), which \
                     tool.diameter_mm in the job gives of the first tool, and that of its number \
                     under tools of each"
                ))
            });
        }
        if found.is_none() && !self.is_sinumerik {
            let own = key.name().map(PredefinedName::of);
            if let Ok(Some(own)) = own {
                let own = self.predefined.get(own);
                return own.map_err(|missing| format!("{} is {missing}", self.shown(key)));
            }
            if let Some(name) = own.err().and_then(name_of) {
                return Err(format!(
                    "{} is the place of the tool on LinuxCNC, and on others it is not (Haas: a \
                     timer): write #<{name}> if it is meant",
                    self.shown(key)
                ));
            }
        }
        let found = found.or_else(|| self.given.read(&key.in_job()));
        if self.is_text(key) {
            return Err(format!("{} is a text (STRING), which is not read", self.shown(key)));
        }
        found.or_else(|| self.of_main(key)).ok_or_else(|| {
            let (name, shown) = (key.in_job(), self.shown(key));
            let may_be = may_be_assumed(&name, self.is_sinumerik) && !self.given.is_closed(&name);
            let settles = match may_be {
                true => format!("; assume: {{\"{name}\": …}} in the job gives its value"),
                false => String::new(),
            };
            format!("{shown} {NOT_SET}{settles}")
        })
    }

    /// A variable is declared as a text.
    pub(super) fn declare_text(&mut self, name: String) {
        self.texts.insert(name);
    }

    /// Whether a variable is a text.
    pub(super) fn is_text(&self, key: &Key) -> bool {
        self.held(key).is_none() && key.name().is_ok_and(|name| self.texts.contains(name))
    }

    /// What the main program has in a variable that a subprogram does not declare.
    fn of_main(&self, key: &Key) -> Option<f64> {
        let name = key.name().ok()?;
        let held = self.of_main.get(name)?;
        self.read_of_main.borrow_mut().insert(name.to_owned());
        Some(held.value)
    }

    /// Variables of the main program that a subprogram has read since this was asked.
    pub(super) fn take_read_of_main(&self) -> BTreeSet<String> {
        std::mem::take(&mut self.read_of_main.borrow_mut())
    }

    /// Whether the program has set it, or the job says what it is.
    pub(super) fn knows(&self, key: &Key) -> bool {
        self.held(key).is_some() || self.given.has(&key.in_job())
    }

    /// Whether a variable may be set: the program declares it or has set it before, or the job
    /// declares it.
    pub(super) fn may_set(&self, key: &Key) -> bool {
        self.held(key).is_some() || self.given.declares(&key.in_job())
    }

    /// How the job may declare a variable that nothing declares.
    pub(super) fn declared_by_job(&self, key: &Key) -> String {
        let name = key.in_job();
        if self.of_main.contains_key(&*name) {
            return ": the main program declares it, and that a subprogram sets it is not read; \
                    have it handed over by PROC, or declared by DEF here"
                .to_owned();
        }
        if self.given.has(&name) && !self.given.declares(&name) {
            return "; the job assumes it, and the program or a file under path.program.files has \
                    a DEF or PROC with this name: which of them is meant is not followed; give \
                    one another name"
                .to_owned();
        }
        let is_given = self.given.has(&name) || self.given.is_closed(&name);
        match may_be_assumed(&name, self.is_sinumerik) && !is_given {
            true => format!(
                "; if it is a variable of the control's own definitions (GUD), declare it by \
                 assume: {{\"{name}\": …}} in the job"
            ),
            false => String::new(),
        }
    }

    /// Whether a name is that of an R parameter, or of a variable that has a value.
    pub(super) fn is_variable(&self, key: &Key) -> bool {
        key.name().is_ok_and(is_r_parameter) || self.knows(key)
    }

    /// As messages name it.
    pub(super) fn shown(&self, key: &Key) -> String {
        match key {
            Key::Number(number) => format!("#{number}"),
            Key::Name(name) if is_r_parameter(name) => name.to_uppercase(),
            Key::Name(name) if name.starts_with('_') => format!("'{name}'"),
            Key::Name(name) | Key::Whole(name) | Key::Truth(name) => match self.is_sinumerik {
                true => format!("'{name}'"),
                false => format!("#<{name}>"),
            },
        }
    }

    /// The number of the text that a parameter is, if it is one.
    pub(super) fn place(&self, key: &Key) -> Option<Span> {
        self.held(key).and_then(|held| held.span)
    }

    /// Where the program has set it.
    pub(super) fn held(&self, key: &Key) -> Option<&Held> {
        match key {
            Key::Number(number) => self.numbered.get(number),
            Key::Name(name) | Key::Whole(name) | Key::Truth(name) => self.named.get(name),
        }
    }

    /// The numbered locals of a call: given, with the locals of the caller in return.
    pub(super) fn enter(&mut self, given: HashMap<i64, f64>, is_macro: bool) -> Locals {
        let kept = self.take_locals();
        if self.is_sinumerik && self.are_macros.is_empty() {
            self.of_main.clone_from(&kept.named);
        }
        let held = |(number, value)| (number, Held::worked_out(value));
        self.numbered.extend(given.into_iter().map(held));
        self.are_macros.push(is_macro);
        kept
    }

    /// Back in the caller.
    pub(super) fn leave(&mut self, kept: Locals) {
        self.are_macros.pop();
        if self.are_macros.is_empty() {
            self.of_main.clear();
        }
        self.take_locals();
        self.numbered.extend(kept.numbered);
        self.named.extend(kept.named);
        self.rounded = kept.rounded;
        self.texts = kept.texts;
        self.lost.extend(kept.lost);
    }

    fn take_locals(&mut self) -> Locals {
        let (is_sinumerik, given) = (self.is_sinumerik, &self.given);
        let is_local = |name: &str| match is_sinumerik {
            true => !is_r_parameter(name) && !given.declares(name),
            false => !name.starts_with('_'),
        };
        let is_lost_here = |name: &String| match name.strip_prefix('#') {
            Some(number) => number.parse().is_ok_and(|number| (1..=33).contains(&number)),
            None => is_local(name),
        };
        Locals {
            lost: self.lost.extract_if(is_lost_here).collect(),
            numbered: self.numbered.extract_if(|number, _| (1..=33).contains(number)).collect(),
            named: self.named.extract_if(|name, _| is_local(name)).collect(),
            rounded: std::mem::take(&mut self.rounded),
            texts: std::mem::take(&mut self.texts),
        }
    }
}

/// A value as true or false (Siemens, SINUMERIK 840D sl/828D Job Planning, "Type conversion").
fn truth(value: f64) -> f64 {
    f64::from(value != 0.0)
}

/// What is wrong with a parameter that the program has not set.
pub(super) const NOT_SET: &str = "is read, and the program has not set it";
