//! Names that look like the spindle's: of signals, data, procedures and comments of robot programs,
//! which have no words of their own for it.

use std::collections::HashMap;

use super::cell::all;
use super::log::Log;
use super::{Setter, Settings};
use crate::notes::Code;
use crate::wording::plain;

/// What stands beside `rpm` in names that are written in one.
const BESIDE_RPM: [&str; 24] = [
    "act", "cmd", "cur", "drive", "go", "ist", "max", "min", "mot", "motor", "new", "nom", "old",
    "out", "ref", "set", "soll", "spd", "speed", "std", "tgt", "tool", "val", "value",
];

/// Whether a name looks like the spindle's.
pub(super) fn is_spindles(name: &str) -> bool {
    let lower = name.to_lowercase();
    ["spind", "spndl", "spdl"].iter().any(|own| lower.contains(own))
        || lower.contains("drehzahl")
        || lower.contains("rpm")
            && name
                .split(|c: char| !c.is_alphabetic())
                .any(|part| is_rpm(part) || words(part).into_iter().any(is_rpm))
}

/// `RPM`, `nrpm`, `rpmSoll`, `maxrpm`; not `interpm` or `carpman`.
fn is_rpm(word: &str) -> bool {
    let word = word.to_lowercase();
    let Some((before, behind)) = word.split_once("rpm") else { return false };
    // A letter or two say of what type a datum is.
    (before.chars().count() <= 2 || BESIDE_RPM.contains(&before))
        && (before.is_empty() || behind.is_empty() || BESIDE_RPM.contains(&behind))
}

/// `nMaxRpm` is `n`, `Max`, `Rpm`.
fn words(part: &str) -> Vec<&str> {
    let (mut found, mut start, mut was_small) = (Vec::new(), 0, false);
    for (at, c) in part.char_indices() {
        if was_small && c.is_uppercase() {
            found.extend(part.get(start..at));
            start = at;
        }
        was_small = c.is_lowercase();
    }
    found.extend(part.get(start..));
    found
}

/// Tells of a command that is not read. Where the job names what is set, but nothing of it is
/// read, that is told of the line.
pub(super) fn doubt(settings: &Settings, log: &mut Log, line: usize, name: &str) {
    let is_name = |own: &String| own.eq_ignore_ascii_case(name);
    let is_of_job = all(settings).any(|(_, by)| match &by.what {
        Setter::Signal(own) | Setter::Procedure(own, _) => is_name(own),
        Setter::Comment(_) => false,
    });
    if !is_of_job {
        let help = match settings.spindle_from {
            None => "path.program.spindle_from in the job can say what it sets",
            Some(_) => {
                "path.program.spindle_from in the job names another, and what this does is not \
                 read; accept that, where it only starts and stops the spindle"
            }
        };
        let what = format!("'{name}' looks like a command to the spindle; {help}");
        log.warning(Code::SpindleCommand, line, what);
    }
}

/// What a program sets its analog outputs to, by their names. One that is set to two values may be
/// the spindle's, and so may one that is set to a value as speeds have, which the job does not
/// state. Any other that is set to a single value, and to zero, has no other speed to be checked
/// than the job's.
#[derive(Debug, Default)]
pub(super) struct Analog {
    /// `None` of those that have been told of; NaN is a value that only the run knows.
    set: HashMap<String, Option<f64>>,
}

impl Analog {
    /// An output, in lower case, is set; `None` where the value is not known.
    pub(super) fn set(
        &mut self,
        settings: &Settings,
        log: &mut Log,
        line: usize,
        name: &str,
        value: Option<f64>,
    ) {
        // The job knows what sets the spindle; a telling name is told of.
        if settings.spindle_from.is_some() || is_spindles(name) || value == Some(0.0) {
            return;
        }
        /// Voltages, shares and per cent lie below, rev/min above.
        const LEAST_RPM: f64 = 101.0;
        let value = value.unwrap_or(f64::NAN);
        let before = match self.set.get(name) {
            None if value >= LEAST_RPM
                && settings.spindle_rpm.is_some_and(|rpm| (rpm - value).abs() > 0.5) =>
            {
                self.set.insert(name.to_owned(), None);
                let what = format!(
                    "the analog output '{name}' is set to {}, and the job's spindle_rpm is {}: it \
                     may be the spindle's speed; path.program.spindle_from in the job can say what \
                     sets it, accept that this is not it",
                    plain(value),
                    plain(settings.spindle_rpm.unwrap_or_default())
                );
                log.warning(Code::SpindleCommand, line, what);
                return;
            }
            None => {
                self.set.insert(name.to_owned(), Some(value));
                return;
            }
            Some(Some(before)) if *before != value => *before,
            Some(_) => return,
        };
        self.set.insert(name.to_owned(), None);
        let shown = |value: f64| match value.is_nan() {
            true => "what only the run knows".to_owned(),
            false => plain(value),
        };
        let what = format!(
            "the analog output '{name}' is set to {} and then to {}: it may be the spindle's \
             speed; path.program.spindle_from in the job can say what sets it, accept that this \
             is not it",
            shown(before),
            shown(value)
        );
        log.warning(Code::SpindleCommand, line, what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_spindle_and_others() {
        for name in [
            "aoSpindle",
            "SPINDLE_RPM",
            "DO Spindel ein",
            "DREHZAHL",
            "nRPM",
            "nrpm",
            "rpm",
            "aorpm",
            "nMaxRpm",
            "maxrpm",
            "RPM_1",
            "rpmSoll",
            "rpm1000",
            "aoRpmSet",
            "aoSpndl",
            "SPDL_SPEED",
            "SOLLRPM",
        ] {
            assert!(is_spindles(name), "{name}");
        }
        for name in
            ["interpm", "nInterPM", "carpman", "Carpman", "feed", "tpm", "turpmode", "rp_m", ""]
        {
            assert!(!is_spindles(name), "{name}");
        }
    }
}
