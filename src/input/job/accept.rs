//! The findings that a job accepts.

use super::Reader;
use crate::formats::yaml::Step;
use crate::job::{Acceptable, Acceptance, Accepted};
use crate::notes::{Class, Code};
use crate::units::Date;
use crate::wording::hint;

impl Reader<'_> {
    /// What is accepted; entries with faults are left out.
    pub(super) fn acceptances(&mut self) -> Vec<Acceptance> {
        let raw = self.raw;
        let entries = raw.accept.iter().flatten().enumerate();
        entries.filter_map(|(index, _)| self.acceptance(index)).collect()
    }

    fn acceptance(&mut self, index: usize) -> Option<Acceptance> {
        let raw = self.raw.accept.as_ref()?.get(index)?;
        let at = |key| [Step::Key("accept"), Step::Index(index), Step::Key(key)];
        let kind = raw.code.as_deref().and_then(|code| self.acceptable(code, raw.mode, index));
        let operations = self.raw.operations.iter().flatten();
        let names: Vec<&str> = operations.filter_map(|raw| raw.name.as_deref()).collect();
        if let Some(name) = raw.operation.as_deref().filter(|name| !names.contains(name)) {
            let hint = hint(name, names);
            let what = format!("accept[{index}].operation is '{name}', which does not exist{hint}");
            self.error(Code::Reference, &at("operation"), what);
        }
        let reason = raw.reason.clone()?;
        if reason.trim().is_empty() {
            let what = format!("accept[{index}].reason is empty, must say why");
            self.error(Code::Value, &at("reason"), what);
        }
        let until = raw.until.as_deref()?;
        let Some(until) = Date::read(until) else {
            let what = format!("accept[{index}].until is '{until}', must be a day as YYYY-MM-DD");
            self.error(Code::Value, &at("until"), what);
            return None;
        };
        Some(Acceptance {
            kind: kind?,
            operation: raw.operation.clone(),
            terms: Accepted { reason, until },
            line: self.tree.line_at(&[Step::Key("accept"), Step::Index(index)]),
        })
    }

    fn acceptable(&mut self, code: &str, mode: Option<u32>, index: usize) -> Option<Acceptable> {
        let at = |key| [Step::Key("accept"), Step::Index(index), Step::Key(key)];
        if code == Acceptable::CROSSING {
            return Some(Acceptable::Crossing { mode: mode.map(|mode| mode as usize) });
        }
        let found = Code::named(code).filter(|code| code.class() != Class::Error);
        if found.is_none() {
            let all = Code::ALL.iter().filter(|code| code.class() != Class::Error);
            let names = all.map(|code| code.name()).chain([Acceptable::CROSSING]);
            let hint = hint(code, names);
            let what = format!(
                "accept[{index}].code is '{code}', must be crossing or the code of a warning{hint}"
            );
            self.error(Code::Reference, &at("code"), what);
        } else if mode.is_some() {
            let what = format!("accept[{index}].mode has no effect on warnings");
            self.error(Code::Unused, &at("mode"), what);
        }
        found.map(Acceptable::Warning)
    }
}
