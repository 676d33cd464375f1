//! Workflow commands, which GitHub shows as annotations beside the lines they name. GitHub keeps ten
//! annotations a level and step, so the most severe come first and the last one counts the rest.

use std::path::Path;

use super::findings::{Finding, findings};
use super::operation::{CheckedOperation, operations};
use super::sentences;
use crate::report::{CheckedJob, paths, words};
use crate::risk::Certainty;
use crate::wording::printable;

/// GitHub keeps so many annotations of a level in a step.
const MOST_ANNOTATIONS: usize = 10;

/// At most so many jobs are named in the last line.
const MOST_NAMED: usize = 10;

/// The results of `detune check` as workflow commands, `error` for resonance and `warning` for uncertain,
/// and a last line for the log. Files below `root` (an absolute path, the folder that the command ran in)
/// are named relative to it.
pub fn check(jobs: &[CheckedJob], root: &Path) -> String {
    let operations: Vec<_> = jobs.iter().flat_map(operations).collect();
    let found: Vec<_> = operations
        .iter()
        .flat_map(|operation| {
            findings(operation).into_iter().map(move |finding| (operation, finding))
        })
        .collect();
    let mut text = String::new();
    for certainty in [Certainty::Certain, Certainty::Uncertain] {
        let of_level: Vec<_> =
            found.iter().filter(|(_, finding)| finding.certainty == certainty).collect();
        for (index, (operation, finding)) in of_level.iter().take(MOST_ANNOTATIONS).enumerate() {
            let beyond = if index + 1 == MOST_ANNOTATIONS { of_level.len() - index - 1 } else { 0 };
            text.push_str(&command(operation, finding, beyond, root));
            text.push('\n');
        }
    }
    text.push_str(&summary(jobs));
    text.push('\n');
    text
}

/// How grave a line for the log is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Stops the work.
    Error,
    /// Does not.
    Warning,
}

/// A fault or remark as a workflow command, in place where it has a file (named relative to `root` where it
/// lies below it) and a line.
pub fn annotation(
    level: Level,
    file: Option<&Path>,
    line: Option<usize>,
    what: &str,
    root: &Path,
) -> String {
    let level = match level {
        Level::Error => "error",
        Level::Warning => "warning",
    };
    let file = file.map(|file| paths::slashed(&paths::within(root, file)));
    let place = match (file, line) {
        (Some(file), Some(line)) => format!(" file={},line={line}", property(&file)),
        (Some(file), None) => format!(" file={}", property(&file)),
        (None, _) => String::new(),
    };
    format!("::{level}{place}::{}", data(what))
}

fn command(
    operation: &CheckedOperation<'_>,
    finding: &Finding<'_>,
    beyond: usize,
    root: &Path,
) -> String {
    let (level, title) = match finding.certainty {
        Certainty::Certain => ("error", "resonance"),
        Certainty::Uncertain => ("warning", "perhaps a resonance"),
    };
    let crossing = finding.worst.crossing;
    let (from, to) = (crossing.from_line, crossing.to_line);
    let file = printable(&paths::slashed(&paths::within(root, &operation.lines_file())));
    let mut message = sentences::sentence(operation, &finding.worst);
    match finding.others.len() {
        0 => {}
        1 => message.push_str("; the same on one more stretch"),
        more => message.push_str(&format!("; the same on {more} more stretches")),
    }
    if beyond > 0 {
        message.push_str(&format!(
            "\n… and {beyond} more like this; --format json or sarif lists all"
        ));
    }
    format!(
        "::{level} file={},line={from},endLine={to},title={}::{}",
        property(&file),
        property(&format!("detune: {title} in '{}'", printable(&operation.risk.name))),
        data(&message)
    )
}

fn summary(jobs: &[CheckedJob]) -> String {
    let told = |job: &CheckedJob| {
        let file = printable(&paths::slashed(&job.file));
        format!("{file} {}", words::verdict(job.risk.verdict))
    };
    let text = if jobs.len() <= MOST_NAMED {
        jobs.iter().map(told).collect::<Vec<_>>().join(", ")
    } else {
        let worst = sentences::worst_jobs(jobs);
        let mut text = sentences::counts(jobs.iter().map(|job| job.risk.verdict), false);
        text = format!("{} jobs: {text}", jobs.len());
        let named: Vec<_> = worst.iter().take(MOST_NAMED).map(|job| told(job)).collect();
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

    #[test]
    fn faults_stand_at_their_lines() {
        let at = |file: Option<&str>, line| {
            annotation(Level::Error, file.map(Path::new), line, "50 %\n", Path::new("/here"))
        };
        assert_eq!(
            at(Some("/here/a,b.yaml"), Some(3)),
            "::error file=a%2Cb.yaml,line=3::50 %25%0A"
        );
        assert_eq!(at(Some("a.yaml"), None), "::error file=a.yaml::50 %25%0A");
        assert_eq!(at(None, None), "::error::50 %25%0A");
    }

    #[test]
    fn properties_and_messages_are_escaped() {
        assert_eq!(data("50 %, a:b\r\n"), "50 %25, a:b%0D%0A");
        assert_eq!(property("50 %, a:b\r\n"), "50 %25%2C a%3Ab%0D%0A");
    }
}
