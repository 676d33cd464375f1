//! Workflow commands, which GitHub shows as annotations beside the lines they name. GitHub keeps
//! ten annotations a level and step, so the most severe come first and the last one counts the
//! rest.

use std::path::Path;

use super::findings::{Class, Finding, findings};
use super::operation::{CheckedOperation, operations};
use super::sentences;
use crate::notes::{Note, Severity};
use crate::report::{paths, words};
use crate::risk::Verdict;
use crate::study::check::CheckedJob;
use crate::wording::{printable, visible};

/// GitHub keeps so many annotations of a level in a step.
const MAX_ANNOTATIONS: usize = 10;

/// At most so many jobs are named in the last line.
const MAX_NAMED: usize = 10;

/// The results of `detune check` as workflow commands, `error` for resonance and what is
/// unchecked, `warning` for uncertain, `notice` for accepted, and a last line for the log. Files
/// below `root` (an absolute path, the folder that the command ran in) are named relative to it.
pub fn check(jobs: &[CheckedJob], root: &Path) -> String {
    let operations: Vec<_> = jobs.iter().flat_map(operations).collect();
    let found: Vec<_> = operations
        .iter()
        .flat_map(|operation| {
            findings(operation).into_iter().map(move |finding| (operation, finding))
        })
        .collect();
    let mut text = String::new();
    let warnings = jobs.iter().flat_map(|job| &job.risk.warnings);
    for warning in warnings.filter(|w| w.counts()) {
        let fails = warning.is_open_breach() || warning.best_verdict() == Verdict::Unchecked;
        let level = match (fails, warning.leaves_doubt()) {
            (true, _) => "error",
            (false, true) => "warning",
            (false, false) => "notice",
        };
        let command = note_command(level, &warning.note, &sentences::doubt(warning), root);
        if !text.contains(&command) {
            text.push_str(&command);
            text.push('\n');
        }
    }
    // What the policy looks away from is told, as a line there makes no verdict.
    for operation in operations.iter().filter(|own| !own.risk.left_out.lines.is_empty()) {
        let what = sentences::left_out(operation).unwrap_or_default();
        let name = printable(&operation.risk.name);
        let file = visible(&paths::slashed(&paths::within(root, &operation.job.file)));
        let text_of = data(&format!("{name}: left out {what}"));
        text.push_str(&format!("::notice file={}::{text_of}\n", property(&file)));
    }
    for level in LEVELS {
        let of_level: Vec<_> =
            found.iter().filter(|(_, finding)| level_of(finding) == level).collect();
        for (index, (operation, finding)) in of_level.iter().take(MAX_ANNOTATIONS).enumerate() {
            let beyond = if index + 1 == MAX_ANNOTATIONS { of_level.len() - index - 1 } else { 0 };
            text.push_str(&command(operation, finding, beyond, root));
            text.push('\n');
        }
    }
    text.push_str(&summary(jobs));
    text.push('\n');
    text
}

/// An error or warning as a workflow command, in place where it has a file (named relative to
/// `root` where it lies below it) and a line.
pub fn note_annotation(note: &Note, root: &Path) -> String {
    let level = match note.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    note_command(level, note, &printable(&note.message()), root)
}

fn note_command(level: &str, note: &Note, text: &str, root: &Path) -> String {
    let file = note.place.file.as_ref();
    let file = file.map(|file| visible(&paths::slashed(&paths::within(root, file))));
    let place = match (file, note.place.line) {
        (Some(file), Some(line)) => format!(" file={},line={line}", property(&file)),
        (Some(file), None) => format!(" file={}", property(&file)),
        (None, _) => String::new(),
    };
    format!("::{level}{place}::{}", data(text))
}

/// Levels of annotations, and how each calls a finding.
const LEVELS: [(&str, &str); 3] =
    [("error", "resonance"), ("warning", "possible resonance"), ("notice", "accepted")];

fn level_of(finding: &Finding<'_>) -> (&'static str, &'static str) {
    match finding.class() {
        Class::Resonance => LEVELS[0],
        Class::Uncertain => LEVELS[1],
        Class::Accepted => LEVELS[2],
    }
}

fn command(
    operation: &CheckedOperation<'_>,
    finding: &Finding<'_>,
    beyond: usize,
    root: &Path,
) -> String {
    let (level, title) = level_of(finding);
    let crossing = finding.worst.crossing;
    let (from, to) = (crossing.from_line, crossing.to_line);
    let file = visible(&paths::slashed(&paths::within(root, &operation.lines_file())));
    let mut message = sentences::finding(operation, finding);
    if beyond > 0 {
        message.push_str(&format!(
            "\n… and {beyond} more like this; --format json or sarif lists all"
        ));
    }
    format!(
        "::{level} file={},line={from},endLine={to},title={}::{}",
        property(&file),
        property(&format!("detune: {title} in '{}'", visible(&operation.risk.name))),
        data(&message)
    )
}

fn summary(jobs: &[CheckedJob]) -> String {
    let shown = |job: &CheckedJob| {
        let file = printable(&paths::slashed(&job.file));
        let settings = job.settings.as_ref();
        let settings = settings.map(|own| format!(" ({})", words::settings(own)));
        let overrides = words::overrides(&job.overrides).map(|own| format!(" ({own})"));
        let both = settings.into_iter().chain(overrides).collect::<String>();
        format!("{file} {}{both}", words::spelled(job.risk.verdict))
    };
    let text = if jobs.len() <= MAX_NAMED {
        jobs.iter().map(shown).collect::<Vec<_>>().join(", ")
    } else {
        let worst = sentences::worst_jobs(jobs);
        let mut text = sentences::counts(jobs.iter().map(|job| job.risk.verdict), false);
        text = format!("{} jobs: {text}", jobs.len());
        let named: Vec<_> = worst.iter().take(MAX_NAMED).map(|job| shown(job)).collect();
        if !named.is_empty() {
            text.push_str(&format!("; {}", named.join(", ")));
        }
        if let more @ 1.. = worst.len() - named.len() {
            text.push_str(&format!(", … and {more} more"));
        }
        text
    };
    data(&format!("detune check: {text}"))
}

/// Escapes a message.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// Escapes a property's value.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notes::{Code, Place};

    #[test]
    fn notes_stand_at_their_lines() {
        let at = |place: Place| {
            note_annotation(&Note::error(Code::Value, place, "50 %"), Path::new("/here"))
        };
        assert_eq!(at(Place::line("/here/a,b.yaml", 3)), "::error file=a%2Cb.yaml,line=3::50 %25");
        assert_eq!(at(Place::file("a.yaml")), "::error file=a.yaml::50 %25");
        assert_eq!(at(Place::default()), "::error::50 %25");
    }

    #[test]
    fn properties_and_messages_are_escaped() {
        assert_eq!(data("50 %, a:b\r\n"), "50 %25, a:b%0D%0A");
        assert_eq!(property("50 %, a:b\r\n"), "50 %25%2C a%3Ab%0D%0A");
    }
}
