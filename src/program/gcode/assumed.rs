//! What the job assumes of parameters that a program reads and does not set: `#100` to `#999`, and
//! of Sinumerik's R parameters, variables and machine data.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::ops::RangeInclusive;

use crate::notes::Code;
use crate::program::Assumed;
use crate::program::log::Log;
use crate::program::unread::{names, tell_unheeded};

/// LinuxCNC: of the tool that is in the spindle.
pub(super) const DIAMETER: i64 = 5410;

/// Those of Fanuc's that hold for all programs.
const COMMON: RangeInclusive<u32> = 100..=999;

/// Sinumerik's operators, and words of its blocks, which are no variables: in lower case.
const WORDS: [&str; 36] = [
    "not", "and", "or", "xor", "b_not", "b_and", "b_or", "b_xor", "div", "mod", "if", "else",
    "endif", "for", "to", "endfor", "while", "endwhile", "loop", "endloop", "repeat", "repeatb",
    "until", "goto", "gotof", "gotob", "gotoc", "gotos", "case", "of", "default", "def", "proc",
    "endproc", "ret", "call",
];

/// Whether a name in lower case is one of them.
pub(super) fn is_word(name: &str) -> bool {
    WORDS.contains(&name)
}

/// Values by the parameter's name in lower case, up to where the program sets it.
#[derive(Debug, Default, Clone)]
pub(super) struct Given {
    open: HashMap<String, f64>,
    /// Those that the program sets, where the job gives any or they become vacant.
    closed: HashSet<String>,
    /// Those that were read.
    read: RefCell<BTreeSet<String>>,
}

impl Given {
    pub(super) fn new(all: &BTreeMap<String, Assumed>, is_sinumerik: bool) -> Self {
        let may_be = all.iter().filter(|(name, _)| may_be_assumed(name, is_sinumerik));
        let open = may_be.map(|(name, value)| match value {
            Assumed::Number(value) => (name.clone(), *value),
            Assumed::Truth(value) => (name.clone(), f64::from(*value)),
        });
        Self { open: open.collect(), ..Self::default() }
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
            false => "#100 to #999 may be assumed",
            true => "R parameters, variables and machine data ($M…) may be assumed",
        };
        for key in all.keys().filter(|key| !self.read.borrow().contains(*key)) {
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
}

/// Whether the job may say what a parameter is, by its name in lower case.
pub(super) fn may_be_assumed(name: &str, is_sinumerik: bool) -> bool {
    let is_number = |digits: &str| digits.bytes().all(|byte| byte.is_ascii_digit());
    if !is_sinumerik {
        let number = name.strip_prefix('#').filter(|digits| is_number(digits));
        return number.and_then(|digits| digits.parse().ok()).is_some_and(|n| COMMON.contains(&n));
    }
    let head = name.split('[').next().unwrap_or(name);
    if head.strip_prefix('r').is_some_and(|digits| !digits.is_empty() && is_number(digits)) {
        return head == name;
    }
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    if is_word(head) {
        return false;
    }
    let begins = head.bytes().take(2).filter(|byte| !byte.is_ascii_digit()).count() == 2;
    begins && head.strip_prefix("$m").unwrap_or(head).bytes().all(is_part)
}
