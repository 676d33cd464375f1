//! Keys of the policy that a run sets for all its jobs.

use super::raw::job::Policy;
use super::schema;
use crate::formats::yaml::{Node, Step, document};
use crate::notes::{Code, Note, Notes, Place};

/// Keys of the policy with values that win over those of jobs and of detune.toml.
#[derive(Debug, Clone, Default)]
pub struct PolicyOverrides {
    pub(super) raw: Policy,
    /// Each as it was given: `separation_percent=8`.
    pub(super) given: Vec<String>,
}

impl PolicyOverrides {
    /// Reads entries `KEY=VALUE`, each key and value as `policy` of a job has them.
    ///
    /// # Errors
    /// Entries that are none, keys and values that a policy does not take.
    pub fn parse(entries: &[String]) -> Result<Self, Vec<Note>> {
        let (mut text, mut errors) = (String::new(), Vec::new());
        for entry in entries {
            match entry.split_once('=').filter(|_| !entry.contains(char::is_control)) {
                Some((key, value)) => text += &format!("{}: {}\n", key.trim(), value.trim()),
                None => {
                    let what =
                        format!("--policy: '{entry}' must be KEY=VALUE, e.g. separation_percent=8");
                    errors.push(Note::usage(what));
                }
            }
        }
        if !errors.is_empty() || entries.is_empty() {
            return if errors.is_empty() { Ok(Self::default()) } else { Err(errors) };
        }
        let mut notes = Notes::about(Place::default());
        let read = document::<Policy>(&text, &schema::of::<Policy>(), &mut notes);
        if let Some((tree, raw)) = &read {
            check_bands(Some(raw), tree, &[], &mut notes);
        }
        let (errors, _) = notes.finish();
        match read {
            Some((_, raw)) if errors.is_empty() => Ok(Self { raw, given: entries.to_vec() }),
            _ => Err(errors.iter().map(|error| at_entry(error, entries)).collect()),
        }
    }
}

impl PolicyOverrides {
    /// Whether it sets a key.
    pub(super) fn sets(&self, key: &str) -> bool {
        let keys = self.given.iter().filter_map(|entry| entry.split_once('='));
        keys.into_iter().any(|(own, _)| own.trim() == key)
    }
}

/// An error in the entry that stands on its line.
fn at_entry(error: &Note, entries: &[String]) -> Note {
    let entry = error.place.line.and_then(|line| entries.get(line.checked_sub(1)?));
    let entry = entry.map_or_else(String::new, |entry| format!(" {entry}"));
    Note::usage(format!("--policy{entry}: {}", error.what))
}

/// Bands that do not ascend; `at` is where the policy stands in the tree.
pub(super) fn check_bands(
    policy: Option<&Policy>,
    tree: &Node,
    at: &[Step<'_>],
    notes: &mut Notes,
) {
    let bands = policy.and_then(|policy| policy.ignore_hz.as_ref());
    for (index, [from, to]) in bands.into_iter().flatten().enumerate() {
        if !(*from >= 0.0 && to >= from) {
            let what = format!(
                "policy.ignore_hz[{index}] is [{from}, {to}], must be ascending and not negative"
            );
            let mut steps = at.to_vec();
            steps.extend([Step::Key("ignore_hz"), Step::Index(index)]);
            notes.error(Code::Value, tree.line_at(&steps), what);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(entries: &[&str]) -> Result<PolicyOverrides, Vec<String>> {
        let entries: Vec<String> = entries.iter().map(|&entry| entry.to_owned()).collect();
        PolicyOverrides::parse(&entries)
            .map_err(|errors| errors.iter().map(Note::to_string).collect())
    }

    #[test]
    fn keys_and_values_are_those_of_a_policy() {
        let read = parsed(&["separation_percent=8", "ignore_hz=[[49, 51]]"]).unwrap();
        assert_eq!(read.raw.separation_percent, Some(8.0));
        assert_eq!(read.raw.ignore_hz, Some(vec![[49.0, 51.0]]));
        assert_eq!(read.given.len(), 2);
        for (entries, told) in [
            (vec!["separation_percent"], "must be KEY=VALUE"),
            (vec!["separation_percent=8\nx: 1"], "must be KEY=VALUE"),
            (vec!["separation_percent=8", "seperation_percent=9"], "did you mean"),
            (vec!["separation_percent=0"], "--policy separation_percent=0: "),
            (vec!["separation_percent=8", "separation_percent=9"], "separation_percent"),
            (vec!["ignore_hz=[[51, 49]]"], "must be ascending"),
        ] {
            let errors = parsed(&entries).unwrap_err();
            assert!(errors[0].contains(told), "{entries:?}: {errors:?}");
        }
        assert!(parsed(&[]).unwrap().given.is_empty());
    }
}
