//! Many jobs on one page: how many there are of each verdict, and the worst with what is found in
//! them.

use super::findings::stretches;
use super::operation::{CheckedOperation, operations};
use super::sentences;
use crate::report::{layout, style, words};
use crate::risk::Verdict;
use crate::study::check::CheckedJob;
use crate::wording::printable;

/// Up to so many jobs are shown in full unless somebody asks for the page.
pub const MAX_IN_FULL: usize = 8;

/// At most so many jobs that are not clear are listed.
const MAX_LISTED: usize = 20;

/// The results of `detune check` as one page; with colours for a terminal if `colour`.
pub fn page(jobs: &[CheckedJob], colour: bool) -> String {
    let counts = sentences::counts(jobs.iter().map(|job| job.risk.verdict), colour);
    let s = if jobs.len() == 1 { "" } else { "s" };
    let mut text = format!("{} job{s}: {counts}\n", jobs.len());
    let accepted: usize = jobs.iter().map(sentences::accepted_count).sum();
    if accepted > 0 {
        text.push_str(&format!("  {accepted} findings are accepted\n"));
    }
    let worst = sentences::worst_jobs(jobs);
    for job in worst.iter().take(MAX_LISTED) {
        let word = words::spelled(job.risk.verdict).to_uppercase();
        let word = style::paint(style::of(job.risk.verdict), word, colour);
        text.push_str(&format!("  {word}  {}\n", words::path(&job.file)));
        if let Some(why) = why(job) {
            layout::push_fact(4, "why", &why, &mut text);
        }
    }
    if let more @ 1.. = worst.len().saturating_sub(MAX_LISTED) {
        text.push_str(&format!("  … and {more} more; --format json lists all\n"));
    }
    let overrides = jobs.first().and_then(|job| words::overrides(&job.overrides));
    if let Some(overrides) = overrides {
        layout::push_fact(2, "policy", &overrides, &mut text);
    }
    if !worst.is_empty() {
        let next = "check a job alone, or with --summary=never, to see where and by what";
        layout::push_fact(2, "next", next, &mut text);
    }
    text
}

/// The worst that was found in a job, or else what leaves it in doubt.
fn why(job: &CheckedJob) -> Option<String> {
    let all: Vec<CheckedOperation<'_>> = operations(job).collect();
    let worst = all.iter().find(|operation| operation.risk.verdict == job.risk.verdict)?;
    let of_operation = || {
        let name = printable(&worst.risk.name);
        if let Some(stretch) = stretches(&worst.risk.crossings).first()
            && job.risk.verdict != Verdict::Unchecked
            && stretch.crossing.accepted.is_none()
        {
            let crossing = stretch.crossing;
            return Some(format!(
                "{name}: {} meets {}, {} apart",
                words::mode(crossing.mode, crossing.natural_frequency_hz),
                words::line_at(&crossing.line, crossing.excitation_hz),
                words::apart(crossing.separation),
            ));
        }
        let limits = sentences::breaches(worst).into_iter();
        limits.chain(sentences::doubts(worst)).next().map(|doubt| format!("{name}: {doubt}"))
    };
    of_operation()
        .or_else(|| sentences::doubts_of_job(job).into_iter().next())
        .map(|w| printable(&w))
}
