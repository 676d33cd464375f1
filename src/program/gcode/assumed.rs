//! What the job assumes of parameters that a program reads and does not set: `#100` to `#999`,
//! LinuxCNC's `#<_name>`, and of Sinumerik's R parameters, variables and machine data.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::ops::RangeInclusive;

use super::files::Files;
use super::predefined::PredefinedName;
use super::structure::{code, stripped};
use super::words::{is_r_parameter, is_word};
use crate::notes::Code;
use crate::program::Assumed;
use crate::program::log::Log;
use crate::program::unread::{names, tell_unheeded};

/// LinuxCNC: of the tool that is in the spindle.
pub(super) const DIAMETER: i64 = 5410;

/// Those of Fanuc's that hold for all programs.
const COMMON: RangeInclusive<u32> = 100..=999;

/// Values by the parameter's name in lower case, up to where the program sets it.
#[derive(Debug, Default, Clone)]
pub(super) struct Given {
    open: HashMap<String, f64>,
    /// Variables that the job declares, as the control's own definitions (GUD) do: they hold in all
    /// programs.
    declared: HashSet<String>,
    /// Those that the program sets, where the job gives any or they become vacant.
    closed: HashSet<String>,
    /// Those that were read.
    read: RefCell<BTreeSet<String>>,
}

impl Given {
    pub(super) fn new(
        all: &BTreeMap<String, Assumed>,
        is_sinumerik: bool,
        lines: &[(usize, &str)],
    ) -> Self {
        let may_be = all.iter().filter(|(name, _)| may_be_assumed(name, is_sinumerik));
        let open = may_be.map(|(name, value)| match value {
            Assumed::Number(value) => (name.clone(), *value),
            Assumed::Truth(value) => (name.clone(), f64::from(*value)),
        });
        let open: HashMap<String, f64> = open.collect();
        let may_declare =
            |name: &&String| is_sinumerik && !is_r_parameter(name) && !name.starts_with('$');
        let declared = open.keys().filter(may_declare).filter(|name| {
            let head = name.split('[').next().unwrap_or(name);
            !lines.iter().any(|(_, line)| defines(line, head))
        });
        Self { declared: declared.cloned().collect(), open, ..Self::default() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.open.is_empty()
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.open.contains_key(name)
    }

    pub(super) fn read(&self, name: &str) -> Option<f64> {
        let value = self.open.get(name).copied()?;
        self.read.borrow_mut().insert(name.to_owned());
        Some(value)
    }

    /// Whether the job declares a variable, which the program may set then.
    pub(super) fn declares(&self, name: &str) -> bool {
        self.declared.contains(name)
    }

    /// What the program has set is read.
    pub(super) fn read_of_program(&self, name: &str) {
        if self.declares(name) {
            self.read.borrow_mut().insert(name.to_owned());
        }
    }

    /// The program sets it.
    pub(super) fn close(&mut self, name: &str) {
        self.open.remove(name);
        if !self.closed.contains(name) {
            self.closed.insert(name.to_owned());
        }
    }

    /// Whether the program has set it, so that the job's value comes too late.
    pub(super) fn is_closed(&self, name: &str) -> bool {
        self.closed.contains(name)
    }

    /// Tells of what the job assumes in vain, where it stands in this program.
    pub(super) fn tell_unheeded(
        &self,
        all: &BTreeMap<String, Assumed>,
        is_sinumerik: bool,
        lines: &[(usize, &str)],
        log: &mut Log,
    ) {
        let may_be = match is_sinumerik {
            false => {
                "#100 to #999 may be assumed, and #<_name> but for what the program itself \
                 settles (#<_x>, #<_y>, #<_z>, #<_feed>, #<_rpm>, units, G90 and G91)"
            }
            true => "R parameters, variables and machine data ($M…) may be assumed",
        };
        let is_told = |key: &String| self.read.borrow().contains(key) || self.is_only_set(key);
        for key in all.keys().filter(|key| !is_told(key)) {
            let Some(line) = lines.iter().position(|(_, line)| names(line, key)) else { continue };
            if !is_sinumerik && *key == format!("#{DIAMETER}") {
                let what = format!(
                    "{key} is the tool's diameter, which tool.diameter_mm in the job states: leave \
                     it out of assume"
                );
                log.error(Code::Conflict, line + 1, what);
                continue;
            }
            let other = (!may_be_assumed(key, is_sinumerik)).then_some(may_be);
            tell_unheeded(log, line + 1, key, other);
        }
    }

    /// Whether the job declares it, and the program sets it and never reads it; no word of the
    /// control begins with an underscore.
    fn is_only_set(&self, name: &str) -> bool {
        let is_set = self.declares(name) && self.is_closed(name);
        is_set && !name.starts_with('_') && !self.read.borrow().contains(name)
    }

    /// What is set and never read may be a word of the control, and no variable.
    pub(super) fn tell_unread(&self, files: &Files<'_>, log: &mut Log) {
        let mut unread: Vec<&String> =
            self.declared.iter().filter(|name| self.is_only_set(name)).collect();
        unread.sort();
        for name in unread {
            let head = name.split('[').next().unwrap_or(name);
            let index = files.lines.iter().position(|(_, line)| names(line, head)).unwrap_or(0);
            let beside = files.beside(index);
            let line = if beside.is_some() { 1 } else { index + 1 };
            let what = format!(
                "'{}' is set and never read: the job declares it as a variable, and if it is a \
                 word of the control, what it does is not read; leave it out if it changes no \
                 motion, speed or tool",
                name.to_uppercase()
            );
            log.within(beside.unwrap_or_default());
            log.warning(Code::MotionLeftOut, line, what);
        }
        log.within(String::new());
    }
}

/// Whether a line declares a variable of the program's own.
fn defines(line: &str, name: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words = code(stripped(line)).split(|c| !is_part(c)).filter(|word| !word.is_empty());
    let mut words = words.map(str::to_ascii_lowercase);
    // `DEF CHAN REAL …` is one of the control's own definitions.
    matches!(words.next().as_deref(), Some("def" | "proc"))
        && !matches!(words.next().as_deref(), Some("nck" | "chan"))
        && words.any(|word| word == name)
}

/// Whether the job may say what a parameter is, by its name in lower case.
pub(super) fn may_be_assumed(name: &str, is_sinumerik: bool) -> bool {
    let is_number = |digits: &str| digits.bytes().all(|byte| byte.is_ascii_digit());
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    if !is_sinumerik && name.starts_with('_') {
        // What a call gives back is the program's own.
        let is_predefined = PredefinedName::of(name).is_some();
        let is_own = is_predefined || matches!(name, "_value" | "_value_returned");
        return name.len() > 1 && name.bytes().all(is_part) && !is_own;
    }
    if !is_sinumerik {
        let number = name.strip_prefix('#').filter(|digits| is_number(digits));
        return number.and_then(|digits| digits.parse().ok()).is_some_and(|n| COMMON.contains(&n));
    }
    let head = name.split('[').next().unwrap_or(name);
    if is_r_parameter(head) {
        return head == name;
    }
    if is_word(head) {
        return false;
    }
    let begins = head.bytes().take(2).filter(|byte| !byte.is_ascii_digit()).count() == 2;
    begins && head.strip_prefix("$m").unwrap_or(head).bytes().all(is_part)
}
