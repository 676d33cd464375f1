//! JUnit XML, as build servers read it: a suite for each job, a case for each operation. It holds
//! no times and no random names: a case is an operation, not a run.

use quick_junit::{NonSuccessKind, Property, Report, TestCase, TestCaseStatus, TestSuite};

use super::findings::findings;
use super::operation::{CheckedOperation, operations};
use super::sentences;
use crate::report::{paths, words};
use crate::risk::OperationRisk;
use crate::study::check::{CheckedJob, Gate};
use crate::wording::{counted, printable};

/// At most so many findings of an operation are written out.
const MAX_FINDINGS: usize = 100;

/// The results of `detune check` as JUnit XML. An operation that does not pass the gate is a
/// failure; any other passes and lists what was found in `system-out`.
///
/// # Errors
/// Never in practice: text is all that is written.
pub fn check(jobs: &[CheckedJob], gate: Gate) -> Result<String, quick_junit::SerializeError> {
    let mut report = Report::new("detune check");
    for job in jobs {
        let file = printable(&paths::slashed(&job.file));
        let mut suite = TestSuite::new(file.as_str());
        suite.add_property(Property::new("job", printable(&job.name)));
        suite.add_property(Property::new("calibrated", job.risk.calibrated.to_string()));
        suite.add_property(Property::new(
            "model_uncertainty_percent",
            words::round_percent(job.risk.model_uncertainty),
        ));
        if let Some(settings) = &job.settings {
            suite.add_property(Property::new("settings", words::settings(settings)));
        }
        if let Some(overrides) = words::overrides(&job.overrides) {
            suite.add_property(Property::new("policy", overrides));
        }
        for operation in operations(job) {
            suite.add_test_case(case(&operation, &file, gate));
        }
        report.add_test_suite(suite);
    }
    report.to_string()
}

fn case(operation: &CheckedOperation<'_>, job_file: &str, gate: Gate) -> TestCase {
    let risk = operation.risk;
    let exceeds = !sentences::breaches(operation).is_empty();
    let fails = gate.fails(risk.verdict, risk.probability, exceeds);
    let found = described(operation);
    let left_out = sentences::left_out(operation).map(|what| format!("left out: {what}"));
    let whole = joined(&found).into_iter().chain(left_out).collect::<Vec<_>>().join("\n");
    let mut case = if fails {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
        status.set_type(words::spelled(risk.verdict));
        status.set_message(headline(risk, found.len()));
        status.set_description(whole);
        TestCase::new(printable(&risk.name), status)
    } else {
        let mut case = TestCase::new(printable(&risk.name), TestCaseStatus::success());
        if !whole.is_empty() {
            case.set_system_out(format!("{}: {whole}", words::spelled(risk.verdict)));
        }
        case
    };
    case.set_classname(job_file);
    case
}

fn headline(risk: &OperationRisk, findings: usize) -> String {
    let findings = counted(findings, "finding");
    format!("operation '{}': {} ({findings})", printable(&risk.name), words::spelled(risk.verdict))
}

/// Each finding in one line, with its place.
fn described(operation: &CheckedOperation<'_>) -> Vec<String> {
    let file = paths::slashed(&operation.lines_file());
    let doubts = operation.job.risk.warnings.iter();
    let doubts = doubts.filter(|w| w.counts() && w.is_about(&operation.risk.name));
    let doubts = doubts.map(|warning| {
        let place = printable(&warning.note.place.to_string());
        format!("{place}: {}", sentences::doubt(warning))
    });
    let findings = findings(operation);
    let findings = findings.iter().map(|finding| {
        let crossing = finding.worst.crossing;
        let place = words::lines(&file, crossing.from_line, crossing.to_line);
        format!("{place}: {}", sentences::sentence(operation, &finding.worst))
    });
    doubts.chain(findings).collect()
}

fn joined(found: &[String]) -> Option<String> {
    let mut text = found[..found.len().min(MAX_FINDINGS)].join("\n");
    if found.len() > MAX_FINDINGS {
        text.push_str(&format!("\n… and {} more", found.len() - MAX_FINDINGS));
    }
    (!text.is_empty()).then_some(text)
}
