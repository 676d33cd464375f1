//! What a reader goes along: the arm, the plots of an operation, its crossings.

use super::{JobPage, plots};
use crate::report::advise::svg;
use crate::report::check::findings::stretches;
use crate::report::check::operation::operations;
use crate::report::check::sentences;
use crate::report::page::{Table, figure, text};
use crate::report::words;
use crate::risk::Crossing;
use crate::units::{percent_from_ratio, um_per_n_from_m_per_n};

/// Plots and crossings of an operation.
pub(super) fn operation(job: &JobPage, index: usize) -> String {
    let Some(operation) = operations(job.checked).nth(index) else { return String::new() };
    let risk = operation.risk;
    let places = job.moving.places.get(index).map_or(&[][..], Vec::as_slice);
    let name = &risk.name;
    let confidence = words::round_percent(operation.job.policy.confidence);
    let mut html = format!("<h2>{}</h2>\n", text(name));
    let (drawn, modes) = (plots::drawn_modes(risk), risk.uncertainty_by_mode.len());
    let above = match modes - drawn {
        0 => String::new(),
        1 => format!("; mode {modes} lies above"),
        _ => format!("; modes {} to {modes} lie above", drawn + 1),
    };
    html.push_str(&figure(
        &format!(
            "Natural frequencies with their {confidence} % intervals and lines of excitation along \
             the path{above}"
        ),
        &plots::frequencies(risk),
    ));
    let advised = job.advised.and_then(|of| Some((of, of.advice.operations.get(index)?)));
    if let Some((of_job, advice)) = advised {
        html.push_str(&figure(
            "Spindle speeds: closed by a mode and a line of excitation, safe, programmed, advised",
            &svg::operation(of_job, advice),
        ));
    }
    if let Some(svg) = plots::receptance(risk, places) {
        let caption =
            "Receptance of the tool tip at the chosen place, along x, y and z of the base";
        html.push_str(&figure(caption, &svg));
    }
    let limit_of = risk.stability.as_ref().map_or("", |chatter| chatter.limit_of.name());
    let stability = format!(
        "The {limit_of} at which the cut chatters along the path, the smallest with its \
         {confidence} % interval"
    );
    for (caption, drawn) in [
        ("How far the cutting force moves the tool tip along the path", plots::tool_tip(risk)),
        (&stability, plots::limit_of_depth(risk)),
        ("β2 along the path", plots::beta2(risk)),
    ] {
        html.push_str(&drawn.map_or_else(String::new, |drawn| figure(caption, &drawn)));
    }
    if !risk.crossings.is_empty() {
        html.push_str(&crossings(&risk.crossings));
    }
    html
}

/// The most severe crossings, in the order of the path.
fn crossings(all: &[Crossing]) -> String {
    let severe = stretches(all);
    let mut crossings: Vec<&Crossing> = if all.len() <= plots::LISTED {
        all.iter().collect()
    } else {
        severe.iter().take(plots::LISTED).map(|found| found.crossing).collect()
    };
    if all.len() > plots::LISTED {
        crossings.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    }
    let more = match all.len() - crossings.len() {
        0 => String::new(),
        more => format!(
            "<p>The most severe of {}; <code>detune check --format json</code> has the other \
             {more}.</p>\n",
            all.len()
        ),
    };
    let columns = [
        ("mode", false),
        ("Hz", false),
        ("interval Hz", false),
        ("line", true),
        ("Hz", false),
        ("apart %", false),
        ("probability %", false),
        ("from %", false),
        ("to %", false),
        ("lines", false),
        ("tip µm/N", false),
        ("moves", true),
        ("certainty", true),
    ];
    let mut table = Table::new("crossings", &columns);
    for c in crossings {
        let percent = |ratio: f64| {
            let percent = percent_from_ratio(ratio);
            (words::trimmed(percent, 2), Some(percent))
        };
        let [low, high] = c.natural_frequency_ci95_hz;
        let certainty = match c.accepted {
            Some(_) => "accepted".to_owned(),
            None => words::spelled(c.certainty),
        };
        table.row(&[
            (c.mode.to_string(), None),
            (words::hz(c.natural_frequency_hz), Some(c.natural_frequency_hz)),
            (format!("{}–{}", words::hz(low), words::hz(high)), None),
            (words::line(&c.line), None),
            (words::hz(c.excitation_hz), Some(c.excitation_hz)),
            (words::apart_in_column(c.separation), Some(percent_from_ratio(c.separation))),
            c.probability.map_or_else(|| ("–".to_owned(), None), percent),
            percent(c.from_s),
            percent(c.to_s),
            (words::line_range(c.from_line, c.to_line), None),
            (
                words::um_per_n(c.tip_response_m_per_n),
                Some(um_per_n_from_m_per_n(c.tip_response_m_per_n)),
            ),
            (sentences::moves(c), None),
            (certainty, None),
        ]);
    }
    format!("<h3>Crossings</h3>\n{more}{}", table.finish())
}
