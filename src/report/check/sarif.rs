//! SARIF 2.1.0, as code scanners and editors read it. One result for all that one mode and one line
//! do in one operation: the worst stretch is its location, the others are related locations. An
//! uncertain stretch that flanks a certain one is part of that result and no result of its own.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::findings::{Finding, Stretch, findings};
use super::operation::{CheckedOperation, operations};
use super::sentences;
use crate::notes::Note;
use crate::report::{paths, words};
use crate::risk::Certainty;
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
/// that the command ran in) are named relative to it.
///
/// # Errors
/// Never in practice: the log holds text and counts alone.
pub fn check(jobs: &[CheckedJob], root: &Path) -> Result<String, serde_json::Error> {
    let mut artifacts = Artifacts { root, uris: Vec::new() };
    let mut results = Vec::new();
    for job in jobs {
        artifacts.index_of(&job.file);
        for operation in operations(job) {
            let found = findings(&operation);
            results.extend(found.iter().map(|finding| artifacts.result(&operation, finding)));
        }
    }
    let left_out = results.len().saturating_sub(MAX_RESULTS);
    if left_out > 0 {
        results.sort_by_key(|result| result.rule_index);
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
                    rules: [Certainty::Certain, Certainty::Uncertain].map(rule),
                },
            },
            invocations: [Invocation {
                execution_successful: true,
                tool_execution_notifications: (left_out > 0)
                    .then(|| {
                        format!("{left_out} findings omitted: a run holds at most {MAX_RESULTS}")
                    })
                    .into_iter()
                    .chain(
                        jobs.iter().flat_map(|job| job.risk.warnings.iter().map(Note::to_string)),
                    )
                    .map(|text| Notification { level: "warning", message: Message { text } })
                    .collect(),
            }],
            artifacts: artifacts.listed(),
            results,
            column_kind: "unicodeCodePoints",
        }],
    };
    let mut text = serde_json::to_string_pretty(&log)?;
    text.push('\n');
    Ok(text)
}

fn rule_id(certainty: Certainty) -> &'static str {
    match certainty {
        Certainty::Certain => "resonance",
        Certainty::Uncertain => "uncertain",
    }
}

fn level(certainty: Certainty) -> &'static str {
    match certainty {
        Certainty::Certain => "error",
        Certainty::Uncertain => "warning",
    }
}

fn rule(certainty: Certainty) -> Rule {
    let (name, short, full, help) = match certainty {
        Certainty::Certain => (
            "Resonance",
            "An excitation line lies inside a mode's band",
            "A multiple of the tooth-passing or spindle frequency lies closer to a natural frequency of \
             the robot arm than the separation that the job's policy requires.",
            "Use another spindle speed or arm pose on this stretch, then check again.",
        ),
        Certainty::Uncertain => (
            "Uncertain",
            "An excitation line lies within the model uncertainty of a mode's band",
            "A multiple of the tooth-passing or spindle frequency lies outside a mode's band, but within \
             the uncertainty of the robot model.",
            "Keep more distance, or reduce the model uncertainty by calibrating with measured frequencies \
             of this arm.",
        ),
    };
    let text = |text: &str| Message { text: text.to_owned() };
    Rule {
        id: rule_id(certainty),
        name,
        short_description: text(short),
        full_description: text(full),
        help: text(help),
        default_configuration: Configuration { level: level(certainty) },
    }
}

/// The files that results point into, in the order in which they came.
struct Artifacts<'a> {
    root: &'a Path,
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
        let identity = [
            rule_id(finding.certainty).to_owned(),
            self.uri_of(&operation.job.file),
            printable(&operation.risk.name),
            format!("mode {}", finding.mode),
            format!("{} {}", words::spelled(finding.line.source), finding.line.harmonic),
        ]
        .join("|");
        ResultObject {
            rule_id: rule_id(finding.certainty),
            rule_index: match finding.certainty {
                Certainty::Certain => 0,
                Certainty::Uncertain => 1,
            },
            level: level(finding.certainty),
            message: Message { text: sentences::finding(operation, finding) },
            locations: [self.location(operation, &finding.worst, None)],
            related_locations: others
                .iter()
                .enumerate()
                .map(|(index, stretch)| self.location(operation, stretch, Some(index + 1)))
                .collect(),
            partial_fingerprints: BTreeMap::from([
                ("detuneFinding/v1", identity.clone()),
                // GitHub follows a finding by this key alone, and would make it of the text of the
                // line.
                ("primaryLocationLineHash", format!("{:016x}:1", fnv_1a(identity.as_bytes()))),
            ]),
        }
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
            logical_locations: [LogicalLocation {
                name: printable(&operation.risk.name),
                fully_qualified_name: printable(&format!(
                    "{}/{}",
                    operation.job.name, operation.risk.name
                )),
            }],
            message: related.map(|_| Message {
                text: sentences::stretch(operation.risk, crossing.from_s, crossing.to_s),
            }),
        }
    }
}

fn located(uri: String, index: Option<usize>) -> ArtifactLocation {
    let relative = !uri.starts_with("file:");
    ArtifactLocation { uri, uri_base_id: relative.then_some(ROOT), index }
}

/// FNV-1a with 64 bits (Fowler, Noll, Vo): short, the same on every machine and in every version.
fn fnv_1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
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
    rules: [Rule; 2],
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
