//! The report of GitLab's code quality widget: a finding is an entry, with a fingerprint by which
//! it is the same finding in the next run. The format has no other place than entries, so what the
//! run sets of the policy is one, at the first job.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::findings::{Class, findings};
use super::identity::{self, digest};
use super::operation::operations;
use super::sentences;
use crate::notes::Code;
use crate::report::json::{WHOLE, spread};
use crate::report::{paths, words};
use crate::study::check::CheckedJob;

/// The results of `detune check` as GitLab's code quality report. `home` names a file as the
/// repository does.
///
/// # Errors
/// Never in practice: the report holds text and counts alone.
pub fn check(
    jobs: &[CheckedJob],
    home: &dyn Fn(&Path) -> PathBuf,
) -> Result<String, serde_json::Error> {
    let path = |file: &Path| paths::slashed(&home(file));
    let mut entries = Vec::new();
    for job in jobs {
        let doubts = job.risk.warnings.iter().filter(|w| w.counts());
        for warning in doubts {
            let is_unchecked = warning.note.code == Code::NothingChecked;
            let place = &warning.note.place;
            entries.push(Entry {
                description: sentences::doubt(warning),
                check_name: match (is_unchecked, warning.is_open_breach()) {
                    (true, _) => "unchecked",
                    (false, true) => "limit",
                    (false, false) => "doubt",
                },
                fingerprint: digest(&identity::of_doubt(job, warning, home)),
                severity: match (&warning.accepted, is_unchecked) {
                    (Some(_), _) => "info",
                    (None, true) => "critical",
                    (None, false) if warning.is_open_breach() => "critical",
                    (None, false) => "minor",
                },
                location: Location {
                    path: path(place.file.as_ref().unwrap_or(&job.file)),
                    lines: Lines { begin: place.line.unwrap_or(1) },
                },
            });
        }
        for operation in operations(job) {
            for finding in findings(&operation) {
                let crossing = finding.worst.crossing;
                entries.push(Entry {
                    description: sentences::finding(&operation, &finding),
                    check_name: finding.rule(),
                    fingerprint: digest(&identity::of_finding(&operation, &finding, home)),
                    severity: match finding.class() {
                        Class::Resonance => "critical",
                        Class::Uncertain => "minor",
                        Class::Accepted => "info",
                    },
                    location: Location {
                        path: path(&operation.lines_file()),
                        lines: Lines { begin: crossing.from_line },
                    },
                });
            }
        }
    }
    let policy = jobs.iter().find_map(|job| Some((job, words::overrides(&job.overrides)?)));
    entries.extend(policy.map(|(job, description)| Entry {
        description,
        check_name: "policy",
        fingerprint: digest(&identity::of_policy(job, home)),
        severity: "info",
        location: Location { path: path(&job.file), lines: Lines { begin: 1 } },
    }));
    spread(&entries, WHOLE)
}

#[derive(Serialize)]
struct Entry {
    description: String,
    check_name: &'static str,
    fingerprint: String,
    severity: &'static str,
    location: Location,
}

#[derive(Serialize)]
struct Location {
    path: String,
    lines: Lines,
}

#[derive(Serialize)]
struct Lines {
    begin: usize,
}
