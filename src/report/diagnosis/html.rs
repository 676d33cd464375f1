//! A diagnosis as a page with plots, in one file that needs nothing else.

use std::fmt::Write;
use std::path::Path;

use super::text;
use crate::diagnosis::{Diagnosis, ResidualRow, Shape};
use crate::units::{deg_from_rad, mm_from_m, percent_from_ratio};

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 300.0;
const MARGIN: f64 = 48.0;

/// One colour a mode, told apart by the colour-blind (Okabe & Ito, 2008).
const COLOURS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#444444"];

/// The page: the text, measured against predicted before and after, residuals over what they follow and
/// over all else, the ranking.
pub fn diagnosis(d: &Diagnosis, robot: &str, table: &Path) -> String {
    let mut out = String::new();
    let title = escaped(&format!("Diagnosis of {robot}"));
    // Writing to a string does not fail.
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\n<style>\
         body{{font:15px/1.5 system-ui,sans-serif;max-width:80em;margin:2em auto;padding:0 1em}}\
         pre{{background:#f5f5f5;padding:1em;overflow:auto}}svg{{background:#fff;max-width:100%}}\
         figure{{display:inline-block;margin:0 1em 1em 0}}td,th{{padding:.1em 1em;text-align:left}}\
         </style></head><body>\n<h1>{title}</h1>\n<pre>{}</pre>\n",
        escaped(&text::diagnosis(d, robot, table))
    );
    for (caption, of) in [
        ("Measured against predicted, Hz: the model as it is", predicted_before as Of),
        ("Measured against predicted, Hz: with the findings", predicted_after as Of),
    ] {
        figure(&mut out, caption, &points(d, of), true);
    }
    let covariates = covariates(d);
    let followed = d.structure_before.as_ref().and_then(|structure| followed(&structure.shape, d));
    let chosen = followed.or_else(|| covariates.iter().position(|c| *c == Covariate::Row));
    if let Some(covariate) = chosen.map(|i| covariates[i]) {
        let name = covariate.name(d);
        for (caption, after) in [("the model as it is", false), ("with the findings", true)] {
            let caption = format!("Residual over {name}, %: {caption}");
            figure(&mut out, &caption, &residuals(d, covariate, after), false);
        }
    }
    out.push_str(
        "<details><summary>Residuals over everything else that the table tells</summary>\n",
    );
    for (i, covariate) in covariates.iter().enumerate().filter(|(i, _)| Some(*i) != chosen) {
        let caption = format!("Residual over {}, %: the model as it is", covariate.name(d));
        figure(&mut out, &caption, &residuals(d, covariates[i], false), false);
    }
    out.push_str("</details>\n");
    if !d.ranking.is_empty() {
        out.push_str("<h2>Causes one by one</h2>\n<table><tr><th>cause</th><th>behind the best, BIC</th></tr>\n");
        for suspect in &d.ranking {
            let label = escaped(&suspect.label());
            let _ = writeln!(out, "<tr><td>{label}</td><td>{:.1}</td></tr>", suspect.behind);
        }
        out.push_str("</table>\n");
    }
    let modes = d.baseline.per_mode_rms_percent.len();
    let legend: Vec<String> = (0..modes)
        .map(|mode| {
            format!(
                "<span style=\"color:{}\">● mode {}</span>",
                COLOURS[mode % COLOURS.len()],
                mode + 1
            )
        })
        .collect();
    let _ = writeln!(out, "<p>{}</p>\n</body></html>", legend.join(" "));
    out
}

type Of = fn(&ResidualRow) -> Option<(f64, f64)>;

fn predicted_before(r: &ResidualRow) -> Option<(f64, f64)> {
    Some((r.before_hz?, r.measured_hz))
}

fn predicted_after(r: &ResidualRow) -> Option<(f64, f64)> {
    Some((r.after_hz?, r.measured_hz))
}

/// What a residual may follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Covariate {
    Row,
    Joint(usize),
    Temperature,
    Amplitude,
    Frequency,
}

impl Covariate {
    fn name(self, d: &Diagnosis) -> String {
        match self {
            Self::Row => "the rows of the table".to_owned(),
            Self::Joint(joint) => d.joints.get(joint).map_or_else(String::new, |(name, slides)| {
                format!("{name}, {}", if *slides { "mm" } else { "°" })
            }),
            Self::Temperature => "temperature, °C".to_owned(),
            Self::Amplitude => "level of excitation, N·m".to_owned(),
            Self::Frequency => "measured frequency, Hz".to_owned(),
        }
    }

    fn of(self, r: &ResidualRow, d: &Diagnosis) -> Option<f64> {
        match self {
            Self::Row => Some((r.row + 1) as f64),
            Self::Joint(joint) => {
                let (q, (_, slides)) = (r.joints.get(joint)?, d.joints.get(joint)?);
                Some(if *slides { mm_from_m(*q) } else { deg_from_rad(*q) })
            }
            Self::Temperature => r.temperature_c,
            Self::Amplitude => r.amplitude_nm,
            Self::Frequency => Some(r.measured_hz),
        }
    }
}

/// Those that vary over the table.
fn covariates(d: &Diagnosis) -> Vec<Covariate> {
    let joints = (0..d.joints.len()).map(Covariate::Joint);
    let others =
        [Covariate::Temperature, Covariate::Amplitude, Covariate::Frequency, Covariate::Row];
    joints
        .chain(others)
        .filter(|covariate| {
            let mut values = d.residuals.iter().filter_map(|r| covariate.of(r, d));
            values.next().is_some_and(|first| values.any(|value| value != first))
        })
        .collect()
}

/// The covariate that a shape is about.
fn followed(shape: &Shape, d: &Diagnosis) -> Option<usize> {
    let covariate = match *shape {
        Shape::Joint { joint }
        | Shape::ModeOverJoint { joint, .. }
        | Shape::SpringOverJoint { joint, .. } => Covariate::Joint(joint),
        Shape::Temperature => Covariate::Temperature,
        Shape::Amplitude => Covariate::Amplitude,
        Shape::Frequency | Shape::ModeByMode => Covariate::Frequency,
        Shape::ModeOverPose { .. }
        | Shape::SpringByPose { .. }
        | Shape::InertiaByPose { .. }
        | Shape::PoseByPose
        | Shape::Order => Covariate::Row,
    };
    covariates(d).iter().position(|c| *c == covariate)
}

/// (measured − predicted) / predicted over a covariate, %.
fn residuals(d: &Diagnosis, covariate: Covariate, after: bool) -> Vec<(usize, f64, f64)> {
    let point = |r: &ResidualRow| {
        let predicted_hz = if after { r.after_hz } else { r.before_hz }?;
        let percent = percent_from_ratio(r.measured_hz / predicted_hz - 1.0);
        Some((r.mode, covariate.of(r, d)?, percent))
    };
    d.residuals.iter().filter_map(point).collect()
}

fn points(d: &Diagnosis, of: Of) -> Vec<(usize, f64, f64)> {
    d.residuals.iter().filter_map(|r| of(r).map(|(x, y)| (r.mode, x, y))).collect()
}

/// A plot of points; `equal` gives both axes the same range and draws the diagonal.
fn figure(out: &mut String, caption: &str, points: &[(usize, f64, f64)], equal: bool) {
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low < high { [low, high] } else { [low - 1.0, low + 1.0] }
    };
    if points.is_empty() {
        return;
    }
    let mut x = range(&mut points.iter().map(|p| p.1));
    let mut y = range(&mut points.iter().map(|p| p.2));
    if equal {
        x = [x[0].min(y[0]), x[1].max(y[1])];
        y = x;
    } else {
        y = [y[0].min(0.0), y[1].max(0.0)];
    }
    let px = |v: f64| MARGIN + (v - x[0]) / (x[1] - x[0]) * (WIDTH - 2.0 * MARGIN);
    let py = |v: f64| HEIGHT - MARGIN - (v - y[0]) / (y[1] - y[0]) * (HEIGHT - 2.0 * MARGIN);
    let _ = write!(
        out,
        "<figure><figcaption>{}</figcaption><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
         role=\"img\">",
        escaped(caption)
    );
    let line = if equal {
        [px(x[0]), py(x[0]), px(x[1]), py(x[1])]
    } else {
        [px(x[0]), py(0.0), px(x[1]), py(0.0)]
    };
    let [x1, y1, x2, y2] = line;
    let _ = write!(
        out,
        "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"#aaa\"/>"
    );
    for (value, at) in [(x[0], px(x[0])), (x[1], px(x[1]))] {
        let below = HEIGHT - 0.4 * MARGIN;
        let _ = write!(
            out,
            "<text x=\"{at:.1}\" y=\"{below:.1}\" font-size=\"11\" text-anchor=\"middle\">{value:.1}</text>"
        );
    }
    for (value, at) in [(y[0], py(y[0])), (y[1], py(y[1]))] {
        let left = 0.9 * MARGIN;
        let _ = write!(
            out,
            "<text x=\"{left:.1}\" y=\"{at:.1}\" font-size=\"11\" text-anchor=\"end\">{value:.1}</text>"
        );
    }
    for (mode, vx, vy) in points {
        let colour = COLOURS[mode % COLOURS.len()];
        let _ = write!(
            out,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{colour}\" fill-opacity=\"0.8\"/>",
            px(*vx),
            py(*vy)
        );
    }
    out.push_str("</svg></figure>\n");
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
