//! A diagnosis as a page: what was found, measured against predicted, what is left over, what else
//! it could be, what to measure next.

use serde_json::json;

use super::plots;
use super::{text, words};
use crate::diagnosis::{Diagnosis, Finding, Verdict};
use crate::report::Plot;
use crate::report::json::NotFinite;
use crate::report::page::{self, Table, figure};
use crate::report::words::path;
use crate::study::diagnose::Diagnosed;
use crate::units::percent_from_ratio;

/// The page of a diagnosis.
///
/// # Errors
/// If a number is not finite, which would be a fault of the program.
pub fn diagnosis(diagnosed: &Diagnosed) -> Result<String, NotFinite> {
    let d = &diagnosed.diagnosis;
    let title = format!("Diagnosis of {}", diagnosed.robot);
    let (word, class) = match d.verdict {
        Verdict::Explained => ("EXPLAINED", "clear"),
        Verdict::PartlyExplained => ("PARTLY EXPLAINED", "uncertain"),
        Verdict::Consistent => ("CONSISTENT", "clear"),
        Verdict::Unexplained => ("UNEXPLAINED", "resonance"),
    };
    let mut body = format!(
        "<header><h1>{} <span class=\"verdict {class}\">{word}</span></h1>\n\
         <p class=\"soft\">{}: {} frequencies at {} poses</p>\n<p>{}</p></header>\n",
        page::text(&title),
        page::text(&path(&diagnosed.table)),
        d.residuals.len(),
        d.poses,
        page::text(&words::verdict(d))
    );
    for what in words::notices(diagnosed) {
        body.push_str(&format!("<p>But {}.</p>\n", page::text(what)));
    }
    d.findings.iter().for_each(|found| body.push_str(&card(found)));
    body.push_str(&errors(d));
    let show = |body: &mut String, plots: Vec<Plot>| {
        plots.iter().for_each(|(caption, svg)| body.push_str(&figure(caption, svg)));
    };
    body.push_str("<h2>Measured and predicted</h2>\n");
    show(&mut body, plots::over_pose(d));
    show(&mut body, plots::measured_against_predicted(d));
    body.push_str("<h2>Residuals</h2>\n");
    let [first, others] = plots::residuals(d);
    show(&mut body, first);
    if !others.is_empty() {
        body.push_str("<details><summary>Over the other columns of the table</summary>\n");
        show(&mut body, others);
        body.push_str("</details>\n");
    }
    body.push_str(&residuals(d));
    body.push_str(&ranking(d));
    body.push_str(&next(d));
    body.push_str("<details><summary>All of it as text</summary>\n<pre>");
    body.push_str(&page::text_lines(&text::diagnosis(diagnosed)));
    body.push_str("</pre></details>\n");
    page::page(&title, &body, &json!({ "jobs": [] }))
}

/// The plots of the page, each with a name.
pub fn plots(d: &Diagnosis) -> Vec<Plot> {
    let [first, others] = plots::residuals(d);
    let all = plots::over_pose(d).into_iter().chain(plots::measured_against_predicted(d));
    let all = all.chain(first).chain(others).enumerate();
    all.map(|(index, (caption, svg))| (format!("{:02} {caption}", index + 1), svg)).collect()
}

fn card(found: &Finding) -> String {
    let mut facts: Vec<(&str, String)> =
        found.parameters.iter().map(|parameter| ("value", words::estimate(parameter))).collect();
    facts.extend(words::motion(found).map(|motion| ("motion", motion)));
    let evidence = &found.evidence;
    facts.push((
        "evidence",
        format!("p-value {}, ΔBIC {:+.1}", words::p_value(evidence.p_value), evidence.delta_bic),
    ));
    facts.extend(words::alternatives(found).map(|all| ("or", all)));
    facts.push(("test", found.text.test.to_owned()));
    let heading = page::text(&words::finding(found));
    format!("<article class=\"card clear\"><h3>{heading}</h3>\n{}</article>\n", page::facts(&facts))
}

fn rounded(value: f64, decimals: usize) -> (String, Option<f64>) {
    (format!("{value:.decimals$}"), Some(value))
}

fn errors(d: &Diagnosis) -> String {
    let columns =
        [("error, % (rms)", true), ("the model as it is", false), ("with the findings", false)];
    let mut table = Table::new("errors", &columns);
    let (before, after) = (&d.baseline, &d.extended);
    let mut row = |name: String, [a, b]: [f64; 2]| {
        table.row(&[(name, None), rounded(a, 2), rounded(b, 2)]);
    };
    row("all modes".to_owned(), [before.rms_percent, after.rms_percent]);
    let modes = before.per_mode_rms_percent.iter().zip(&after.per_mode_rms_percent);
    modes.enumerate().for_each(|(i, (a, b))| row(format!("mode {}", i + 1), [*a, *b]));
    let [held_out, alone] = [
        [before.heldout_rms_percent, after.heldout_rms_percent],
        [before.model_error_percent, after.model_error_percent],
    ];
    row("held-out poses".to_owned(), held_out);
    row("model alone, without noise".to_owned(), alone);
    row("noise floor".to_owned(), [d.noise_floor_percent; 2]);
    table.finish()
}

fn residuals(d: &Diagnosis) -> String {
    let columns = [
        ("row", false),
        ("mode", false),
        ("measured Hz", false),
        ("model Hz", false),
        ("residual %", false),
        ("with findings Hz", false),
        ("residual %", false),
    ];
    let mut table = Table::new("residuals", &columns);
    for r in &d.residuals {
        let predicted = |hz: Option<f64>| {
            let none = || ("–".to_owned(), None);
            let off = |hz: f64| percent_from_ratio(r.measured_hz / hz - 1.0);
            [
                hz.map_or_else(none, |hz| rounded(hz, 2)),
                hz.map_or_else(none, |hz| rounded(off(hz), 2)),
            ]
        };
        let ([model, before], [extended, after]) = (predicted(r.before_hz), predicted(r.after_hz));
        table.row(&[
            ((r.row + 1).to_string(), None),
            ((r.mode + 1).to_string(), None),
            rounded(r.measured_hz, 2),
            model,
            before,
            extended,
            after,
        ]);
    }
    format!("<details><summary>Every measured frequency</summary>\n{}</details>\n", table.finish())
}

fn ranking(d: &Diagnosis) -> String {
    if d.ranking.is_empty() {
        return String::new();
    }
    let mut table = Table::new("ranking", &[("cause", true), ("ΔBIC to the best", false)]);
    for suspect in &d.ranking {
        table.row(&[(suspect.label(), None), rounded(suspect.behind_bic, 1)]);
    }
    format!("<h2>Single causes</h2>\n{}", table.finish())
}

fn next(d: &Diagnosis) -> String {
    let mut html = String::new();
    if !d.next_poses.is_empty() {
        let mut columns: Vec<(&str, bool)> =
            d.joints.iter().map(|(name, _)| (name.as_str(), false)).collect();
        columns.extend([("separates", true), ("from", true), ("apart, σ", false)]);
        let mut table = Table::new("next-poses", &columns);
        for pose in &d.next_poses {
            let mut cells: Vec<(String, Option<f64>)> = pose
                .joints
                .iter()
                .zip(&d.joints)
                .map(|(q, (_, slides))| (words::position(*q, *slides), Some(*q)))
                .collect();
            cells.extend(pose.separates.iter().map(|cause| (cause.clone(), None)));
            cells.push(rounded(pose.apart_sigmas, 1));
            table.row(&cells);
        }
        html.push_str(&format!("<h2>Poses to measure next</h2>\n{}", table.finish()));
    }
    if !d.next_tests.is_empty() {
        let columns = [("cause", true), ("or", true), ("test", true)];
        let mut table = Table::new("next-tests", &columns);
        for next in &d.next_tests {
            let [one, other] = next.separates.clone();
            table.row(&[(one, None), (other, None), (next.test.clone(), None)]);
        }
        html.push_str(&format!("<h2>What no pose separates</h2>\n{}", table.finish()));
    }
    html
}
