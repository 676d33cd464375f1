//! SARIF 2.1.0, as code scanners and editors read it. One result for all that one mode and one line
//! do in one operation: the worst stretch is its location, the others are related locations. An
//! uncertain stretch that flanks a certain one is part of that result and no result of its own.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::findings::{Finding, Stretch, findings};
use super::identity::{self, digest};
use super::operation::{CheckedOperation, operations};
use super::sentences;
use crate::job::Accepted;
use crate::notes::Code;
use crate::report::json::{WHOLE, notices, spread};
use crate::report::{paths, words};
use crate::risk::{Certainty, Warning};
use crate::study::check::CheckedJob;
use crate::wording::printable;

/// Where the standard's own schema stands.
const SCHEMA_URI: &str =
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

/// GitHub refuses a run with more results.
const MAX_RESULTS: usize = 25_000;

/// GitHub reads no more locations of a result.
const MAX_LOCATIONS: usize = 1_000;

/// What relative URIs are relative to: the folder that the command ran in.
const ROOT: &str = "%SRCROOT%";

/// The results of `detune check` as a SARIF log. Files below `root` (an absolute path, the folder
/// that the command ran in) are named relative to it; `home` names a job for its findings'
/// fingerprints, the same wherever the command runs.
///
/// # Errors
/// Never in practice: the log holds text and counts alone.
pub fn check(
    jobs: &[CheckedJob],
    root: &Path,
    home: &dyn Fn(&Path) -> PathBuf,
) -> Result<String, serde_json::Error> {
    let mut artifacts = Artifacts { root, home, uris: Vec::new() };
    let mut results = Vec::new();
    for job in jobs {
        artifacts.index_of(&job.file);
        let doubts = job.risk.warnings.iter().filter(|w| w.counts());
        results.extend(doubts.map(|warning| artifacts.doubt(job, warning)));
        for operation in operations(job) {
            let found = findings(&operation);
            results.extend(found.iter().map(|finding| artifacts.result(&operation, finding)));
        }
    }
    let left_out = results.len().saturating_sub(MAX_RESULTS);
    if left_out > 0 {
        results.sort_by_key(|result| (result.level, result.rule_index));
        results.truncate(MAX_RESULTS);
    }
    let log = Log {
        schema: SCHEMA_URI,
        version: "2.1.0",
        runs: [Run {
            tool: Tool {
                driver: Driver {
                    name: "detune",
                    version: env!("CARGO_PKG_VERSION"),
                    semantic_version: env!("CARGO_PKG_VERSION"),
                    rules: RuleOf::ALL.map(RuleOf::rule),
                },
            },
            invocations: [Invocation {
                execution_successful: true,
                tool_execution_notifications: (left_out > 0)
                    .then(|| {
                        format!("{left_out} findings omitted: a run holds at most {MAX_RESULTS}")
                    })
                    .into_iter()
                    .chain(jobs.iter().flat_map(|job| notices(&job.risk.warnings)))
                    .map(|text| Notification { level: "warning", message: Message { text } })
                    .chain(jobs.iter().filter_map(settings))
                    .chain(jobs.iter().filter_map(overrides))
                    .collect(),
            }],
            artifacts: artifacts.listed(),
            results,
            column_kind: "unicodeCodePoints",
        }],
    };
    spread(&log, WHOLE)
}

/// What comes from the settings that jobs share.
fn settings(job: &CheckedJob) -> Option<Notification> {
    let text = words::settings(job.settings.as_ref()?);
    let text = format!("{}: {text}", printable(&paths::slashed(&job.file)));
    Some(Notification { level: "note", message: Message { text } })
}

/// What the run sets of the policy.
fn overrides(job: &CheckedJob) -> Option<Notification> {
    let text = words::overrides(&job.overrides)?;
    let text = format!("{}: {text}", printable(&paths::slashed(&job.file)));
    Some(Notification { level: "note", message: Message { text } })
}

/// What a result says; the rules stand in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum RuleOf {
    Resonance,
    Uncertain,
    Unchecked,
    Doubt,
    Limit,
}

impl RuleOf {
    const ALL: [Self; 5] =
        [Self::Resonance, Self::Uncertain, Self::Unchecked, Self::Doubt, Self::Limit];

    fn crossing(certainty: Certainty) -> Self {
        match certainty {
            Certainty::Certain => Self::Resonance,
            Certainty::Uncertain => Self::Uncertain,
        }
    }

    fn id(self) -> &'static str {
        match self {
            Self::Resonance => "resonance",
            Self::Uncertain => "uncertain",
            Self::Unchecked => "unchecked",
            Self::Doubt => "doubt",
            Self::Limit => "limit",
        }
    }

    fn level(self) -> &'static str {
        match self {
            Self::Resonance | Self::Unchecked | Self::Limit => "error",
            Self::Uncertain | Self::Doubt => "warning",
        }
    }

    fn rule(self) -> Rule {
        let [name, short, full, help] = match self {
            Self::Resonance => [
                "Resonance",
                "An excitation line lies inside a mode's band",
                "A multiple of the tooth-passing or spindle frequency lies closer to a natural \
                 frequency of the robot arm than the separation that the job's policy requires.",
                "Use another spindle speed or arm pose on this stretch, then check again.",
            ],
            Self::Uncertain => [
                "Uncertain",
                "An excitation line lies within the model uncertainty of a mode's band",
                "A multiple of the tooth-passing or spindle frequency lies outside a mode's band, \
                 but within the uncertainty of the robot model.",
                "Keep more distance, or reduce the model uncertainty by calibrating with measured \
                 frequencies of this arm.",
            ],
            Self::Unchecked => [
                "Unchecked",
                "Nothing, or nothing that counts, was checked",
                "No excitation line or no mode counts on the whole path, or the spindle stands \
                 still.",
                "Check the job's policy and the spindle commands of the program.",
            ],
            Self::Doubt => [
                "Doubt",
                "A resonance may hide in what was left out or assumed",
                "Something was left out of the check or assumed for it, so the verdict is at best \
                 uncertain.",
                "State what is missing, or accept it in the job with a reason.",
            ],
            Self::Limit => [
                "Limit",
                "The cutting force moves the tool tip farther than the policy allows",
                "The static deflection under the mean cutting force, or the vibration under its \
                 harmonics, exceeds a limit of the job's policy.",
                "Cut less deep, use another speed, feed or arm pose, then check again.",
            ],
        };
        let text = |text: &str| Message { text: text.to_owned() };
        Rule {
            id: self.id(),
            name,
            short_description: text(short),
            full_description: text(full),
            help: text(help),
            default_configuration: Configuration { level: self.level() },
        }
    }
}

/// The files that results point into, in the order in which they came.
struct Artifacts<'a> {
    root: &'a Path,
    home: &'a dyn Fn(&Path) -> PathBuf,
    uris: Vec<String>,
}

impl Artifacts<'_> {
    fn uri_of(&self, file: &Path) -> String {
        paths::uri(&paths::within(self.root, file))
    }

    fn index_of(&mut self, file: &Path) -> usize {
        let uri = self.uri_of(file);
        self.uris.iter().position(|known| *known == uri).unwrap_or_else(|| {
            self.uris.push(uri);
            self.uris.len() - 1
        })
    }

    fn listed(self) -> Vec<Artifact> {
        self.uris.into_iter().map(|uri| Artifact { location: located(uri, None) }).collect()
    }

    fn result(&mut self, operation: &CheckedOperation<'_>, finding: &Finding<'_>) -> ResultObject {
        let others = &finding.others[..finding.others.len().min(MAX_LOCATIONS - 1)];
        let rule = RuleOf::crossing(finding.certainty);
        let identity = identity::of_finding(operation, finding, self.home);
        let location = self.location(operation, &finding.worst, None);
        let related = others.iter().enumerate();
        let related = related
            .map(|(index, stretch)| self.location(operation, stretch, Some(index + 1)))
            .collect();
        let text = sentences::finding(operation, finding);
        let terms = finding.worst.crossing.accepted.as_ref();
        ResultObject { related_locations: related, ..result(rule, text, location, identity, terms) }
    }

    fn doubt(&mut self, job: &CheckedJob, warning: &Warning) -> ResultObject {
        let rule = match warning.note.code {
            Code::NothingChecked => RuleOf::Unchecked,
            Code::LimitExceeded => RuleOf::Limit,
            _ => RuleOf::Doubt,
        };
        let place = &warning.note.place;
        let file = place.file.as_ref().unwrap_or(&job.file);
        let identity = identity::of_doubt(job, warning, self.home);
        let index = self.index_of(file);
        let line = place.line.unwrap_or(1);
        let location = Location {
            id: None,
            physical_location: PhysicalLocation {
                artifact_location: located(self.uri_of(file), Some(index)),
                region: Region { start_line: line, end_line: line },
            },
            logical_locations: [logical(job, warning.operation.as_deref())],
            message: None,
        };
        result(rule, sentences::doubt(warning), location, identity, warning.accepted.as_ref())
    }

    fn location(
        &mut self,
        operation: &CheckedOperation<'_>,
        stretch: &Stretch<'_>,
        related: Option<usize>,
    ) -> Location {
        let file = operation.lines_file();
        let index = self.index_of(&file);
        let crossing = stretch.crossing;
        Location {
            id: related,
            physical_location: PhysicalLocation {
                artifact_location: located(self.uri_of(&file), Some(index)),
                region: Region { start_line: crossing.from_line, end_line: crossing.to_line },
            },
            logical_locations: [logical(operation.job, Some(&operation.risk.name))],
            message: related.map(|_| Message {
                text: sentences::stretch(operation.risk, crossing.from_s, crossing.to_s),
            }),
        }
    }
}

fn result(
    rule: RuleOf,
    text: String,
    location: Location,
    identity: String,
    terms: Option<&Accepted>,
) -> ResultObject {
    ResultObject {
        rule_id: rule.id(),
        rule_index: rule as usize,
        level: rule.level(),
        message: Message { text },
        locations: [location],
        related_locations: Vec::new(),
        // GitHub follows a finding by this key alone, and would make it of the text of the line.
        partial_fingerprints: BTreeMap::from([
            ("primaryLocationLineHash", digest(&identity) + ":1"),
            ("detuneFinding/v1", identity),
        ]),
        suppressions: terms
            .map(|terms| Suppression {
                kind: "external",
                status: "accepted",
                justification: printable(&terms.to_string()),
            })
            .into_iter()
            .collect(),
    }
}

/// An operation of a job, or the job.
fn logical(job: &CheckedJob, operation: Option<&str>) -> LogicalLocation {
    LogicalLocation {
        name: printable(operation.unwrap_or(&job.name)),
        fully_qualified_name: printable(
            &operation.map_or_else(|| job.name.clone(), |name| format!("{}/{name}", job.name)),
        ),
    }
}

fn located(uri: String, index: Option<usize>) -> ArtifactLocation {
    let relative = !uri.starts_with("file:");
    ArtifactLocation { uri, uri_base_id: relative.then_some(ROOT), index }
}

#[derive(Serialize)]
struct Log {
    #[serde(rename = "$schema")]
    schema: &'static str,
    version: &'static str,
    runs: [Run; 1],
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Run {
    tool: Tool,
    invocations: [Invocation; 1],
    artifacts: Vec<Artifact>,
    results: Vec<ResultObject>,
    column_kind: &'static str,
}

#[derive(Serialize)]
struct Tool {
    driver: Driver,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Driver {
    name: &'static str,
    version: &'static str,
    semantic_version: &'static str,
    rules: [Rule; RuleOf::ALL.len()],
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Rule {
    id: &'static str,
    name: &'static str,
    short_description: Message,
    full_description: Message,
    help: Message,
    default_configuration: Configuration,
}

#[derive(Serialize)]
struct Configuration {
    level: &'static str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Invocation {
    execution_successful: bool,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tool_execution_notifications: Vec<Notification>,
}

#[derive(Serialize)]
struct Notification {
    level: &'static str,
    message: Message,
}

#[derive(Serialize)]
struct Artifact {
    location: ArtifactLocation,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct ArtifactLocation {
    uri: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    uri_base_id: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    index: Option<usize>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct ResultObject {
    rule_id: &'static str,
    rule_index: usize,
    level: &'static str,
    message: Message,
    locations: [Location; 1],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    related_locations: Vec<Location>,
    partial_fingerprints: BTreeMap<&'static str, String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    suppressions: Vec<Suppression>,
}

#[derive(Serialize)]
struct Suppression {
    kind: &'static str,
    status: &'static str,
    justification: String,
}

#[derive(Serialize)]
struct Message {
    text: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Location {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<usize>,
    physical_location: PhysicalLocation,
    logical_locations: [LogicalLocation; 1],
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<Message>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct PhysicalLocation {
    artifact_location: ArtifactLocation,
    region: Region,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Region {
    start_line: usize,
    end_line: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct LogicalLocation {
    name: String,
    fully_qualified_name: String,
}
