//! What a code of a message, a verdict or a cause means, and what to do about it. The texts of
//! messages and verdicts are the guide's own.

use crate::diagnosis::cause_text;
use crate::model::Cause;
use crate::notes::{Class, Code, Note};
use crate::wording::hint;

/// The page of the guide with a table of every code and verdict.
const PAGE: &str = include_str!("../guide/messages.md");

/// A name that outputs use, and what it means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Explanation {
    /// As outputs spell it.
    pub name: &'static str,
    /// Of what it is the name.
    pub kind: Kind,
    /// What it means.
    pub meaning: &'static str,
    /// What to do, or, of a cause, the test that tells it from others.
    pub what_to_do: &'static str,
    /// Of a cause, what has similar effects.
    pub confounded_with: Option<&'static str>,
}

/// Of what something is the name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// An error or a warning.
    Message(Class),
    /// A verdict of check or diagnose, a status of advise, or what a job may accept.
    Verdict,
    /// What a diagnosis can find wrong in a model.
    Cause,
}

/// Everything that can be explained: messages and verdicts in the order of the guide, then causes.
pub fn all() -> Vec<Explanation> {
    let rows = PAGE.lines().filter_map(row);
    let of_page = rows.map(|[name, meaning, what_to_do]| {
        let kind = Code::named(name).map_or(Kind::Verdict, |code| Kind::Message(code.class()));
        Explanation { name, kind, meaning, what_to_do, confounded_with: None }
    });
    let causes = Cause::ALL.into_iter().map(|cause| {
        let text = cause_text(cause);
        Explanation {
            name: cause.name(),
            kind: Kind::Cause,
            meaning: text.description,
            what_to_do: text.test,
            confounded_with: Some(text.confounded_with),
        }
    });
    of_page.chain(causes).collect()
}

/// What a name means, in whatever spelling: `payload-unknown`, `PAYLOAD_UNKNOWN`.
///
/// # Errors
/// A name that no output uses.
pub fn explain(name: &str) -> Result<Explanation, Note> {
    let spelled = name.trim().to_lowercase().replace(['-', ' '], "_");
    let all = all();
    let names: Vec<&str> = all.iter().map(|one| one.name).collect();
    all.iter().find(|one| one.name == spelled).cloned().ok_or_else(|| {
        let hint = hint(&spelled, names);
        Note::usage(format!(
            "'{name}' is no code, verdict or cause{hint}; detune explain lists all"
        ))
    })
}

/// ``| `name` | meaning | what to do |``.
fn row(line: &'static str) -> Option<[&'static str; 3]> {
    let (name, rest) = line.strip_prefix("| `")?.split_once("` |")?;
    let (meaning, rest) = rest.split_once('|')?;
    Some([name, meaning.trim(), rest.trim().trim_end_matches('|').trim()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_explained_once_and_in_full() {
        let all = all();
        let mut names: Vec<&str> = all.iter().map(|one| one.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len());
        for code in Code::ALL {
            let found = explain(code.name()).unwrap();
            assert_eq!((found.meaning, found.kind), (code.meaning(), Kind::Message(code.class())));
        }
        for one in &all {
            assert!(!one.meaning.is_empty() && !one.what_to_do.is_empty(), "{one:?}");
        }
        assert_eq!(explain(" Payload-Unknown").unwrap().name, "payload_unknown");
        assert!(explain("payload_unknwon").unwrap_err().what.contains("'payload_unknown'"));
        assert_eq!(explain("joint_coupling").unwrap().kind, Kind::Cause);
        assert_eq!(explain("resonance").unwrap().kind, Kind::Verdict);
    }
}
