//! Why something is not known, and what helps.

use std::collections::HashSet;
use std::fmt;
use std::ops::Deref;
use std::rc::Rc;

use super::number::WRITE;
use crate::program::single::COUNT;

/// What helps where `assume` cannot.
pub(super) const COPY: &str = "write the value into a copy of the program";

/// What helps where a declaration is missed.
pub(super) const FILE: &str = "path.program.files in the job can name the file that declares it";

/// Why a value is not known.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Why {
    text: Rc<str>,
    /// What it is, if another file declares it or gives it its value: `tools{2}`.
    elsewhere: Option<Rc<str>>,
}

impl Why {
    /// Of a datum, or a part of one, of which another file says what it is.
    pub(super) fn elsewhere(text: impl Into<String>, shown: &str) -> Self {
        Self { elsewhere: Some(Rc::from(shown)), ..Self::from(text.into()) }
    }

    /// What it is, if another file says so.
    pub(super) fn of_other_file(&self) -> Option<&str> {
        self.elsewhere.as_deref()
    }

    /// Whether it is another than those before, for which the job's word has stood, too.
    pub(super) fn is_another(&self, before: &mut HashSet<String>) -> bool {
        before.insert(self.of_other_file().unwrap_or(self).to_lowercase());
        before.len() > 1
    }

    /// The same of a part.
    pub(super) fn part(&self, steps: &str) -> Self {
        let elsewhere = self.elsewhere.as_ref().map(|own| Rc::from(format!("{own}{steps}")));
        Self { elsewhere, ..self.clone() }
    }

    /// What helps, where the reason does not tell it.
    pub(super) fn help(&self) -> String {
        match &self.elsewhere {
            Some(_) if self.contains("path.program.files") => String::new(),
            Some(_) => format!("; {FILE}"),
            None => hint(self).to_owned(),
        }
    }
}

impl Deref for Why {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl From<String> for Why {
    fn from(text: String) -> Self {
        Self { text: Rc::from(text), elsewhere: None }
    }
}

impl From<Why> for String {
    fn from(why: Why) -> Self {
        why.to_string()
    }
}

/// What settles a number or a truth value that is not known, unless the reason tells what helps, as
/// it does where the name of a signal is read; strings `assume` does not give.
pub(super) fn hint(why: &str) -> &'static str {
    let told = ["assume: {", COUNT, COPY, FILE, WRITE];
    let is_told = told.iter().any(|own| why.contains(own));
    if is_told { "" } else { "; assume: in the job can settle it" }
}
