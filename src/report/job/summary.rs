//! The first screen: verdicts, the worst crossing of each operation in a sentence, what to run
//! instead, and how far the model is to be trusted.

use super::JobPage;
use crate::report::advise::{text as advise_text, words as advise_words};
use crate::report::check::findings::findings;
use crate::report::check::operation::{CheckedOperation, operations};
use crate::report::check::{cut, sentences, text as check_text};
use crate::report::page::{self, Table, text};
use crate::report::words;
use crate::risk::Verdict;
use crate::units::percent_from_ratio;

/// A list of jobs, the worst first.
pub(super) fn jobs(jobs: &[JobPage]) -> String {
    let counts = sentences::counts(jobs.iter().map(|job| job.checked.risk.verdict), false);
    let mut table =
        Table::new("jobs", &[("job", true), ("verdict", true), ("probability %", false)]);
    for job in jobs {
        let probability = percent_from_ratio(job.checked.risk.probability.probability);
        table.row(&[
            (words::path(&job.checked.file), None),
            (words::spelled(job.checked.risk.verdict), None),
            (words::trimmed(probability, 1), Some(probability)),
        ]);
    }
    format!("<h1>{} jobs: {}</h1>\n{}", jobs.len(), text(&counts), table.finish())
}

/// What is to be known of a job before all else.
pub(super) fn job(job: &JobPage, drawn: &[usize]) -> String {
    let checked = job.checked;
    let mut html = format!(
        "<header><h1>{} {}</h1>\n<p class=\"soft\">{}</p></header>\n",
        text(&checked.name),
        badge(checked.risk.verdict),
        text(&words::path(&checked.file))
    );
    let doubts = sentences::doubts_of_job(checked);
    for (index, operation) in operations(checked).enumerate() {
        if drawn.contains(&index) {
            html.push_str(&card(job, index, &operation));
        }
    }
    let all = checked.risk.operations.len();
    if all > drawn.len() {
        let omitted = (0..all).filter(|index| !drawn.contains(index));
        let verdicts = omitted.map(|index| checked.risk.operations[index].verdict);
        let counts = sentences::counts(verdicts, false);
        let more = all - drawn.len();
        html.push_str(&format!("<p>… and {more} more operations: {}</p>\n", text(&counts)));
    }
    let mut facts: Vec<(&str, String)> = doubts.into_iter().map(|fact| ("doubt", fact)).collect();
    facts.extend(sentences::accepted(checked).into_iter().map(|fact| ("accepted", fact)));
    facts.push(("model", sentences::model(checked)));
    facts.push(("payload", words::carried(checked.risk.payload)));
    facts.extend(checked.settings.as_ref().map(|own| ("settings", words::settings(own))));
    facts.extend(words::overrides(&checked.overrides).map(|own| ("policy", own)));
    facts.push(("next", check_text::next(checked).to_owned()));
    html + &page::facts(&facts)
}

fn badge(verdict: Verdict) -> String {
    let word = words::spelled(verdict);
    format!("<span class=\"verdict {word}\">{}</span>", word.to_uppercase())
}

/// An operation: what is wrong, and what to do.
fn card(job: &JobPage, index: usize, operation: &CheckedOperation<'_>) -> String {
    let risk = operation.risk;
    let limits = sentences::breaches(operation).into_iter();
    let mut facts: Vec<(&str, String)> = limits.map(|breach| ("limit", breach)).collect();
    match findings(operation).first() {
        Some(worst) => {
            let crossing = worst.worst.crossing;
            facts.push(("worst", sentences::finding(operation, worst)));
            facts.extend(sentences::probability(crossing).map(|text| ("probability", text)));
            let file = operation.lines_file();
            let file = file.to_string_lossy();
            facts.push(("lines", words::lines(&file, crossing.from_line, crossing.to_line)));
            facts.push(("interval", sentences::interval(operation, crossing)));
        }
        None => {
            let closest = risk.closest.as_ref().map_or_else(
                || "no excitation line or no mode counts".to_owned(),
                |approach| {
                    let at = sentences::point(risk, approach.s);
                    format!("{}, at {at}", sentences::closest(approach))
                },
            );
            facts.push(("closest", closest));
        }
    }
    facts.extend(sentences::doubts(operation).into_iter().map(|doubt| ("because", doubt)));
    facts.extend(sentences::left_out(operation).map(|what| ("left out", what)));
    facts.extend(cut::facts(risk));
    let advised = job.advised.and_then(|job| Some((job, job.advice.operations.get(index)?)));
    if let Some((of_job, advice)) = advised {
        let (word, _, head) = advise_text::head(advice);
        facts.push(("advice", format!("{}: {head}", word.to_lowercase())));
        facts.extend(advise_words::reasons(of_job, advice));
    }
    let verdict = words::spelled(risk.verdict);
    format!(
        "<article class=\"card {verdict}\"><h3>{} {}</h3>\n<p class=\"soft\">{}, {} s</p>\n\
         {}</article>\n",
        text(&risk.name),
        badge(risk.verdict),
        text(&sentences::speed(operation)),
        words::trimmed(risk.duration_s, 1),
        page::facts(&facts)
    )
}
