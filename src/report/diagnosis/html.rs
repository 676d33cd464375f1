//! A diagnosis as a page with plots, in one file that needs nothing else.

use std::fmt::Write;

use super::text;
use crate::diagnosis::{Diagnosis, ResidualRow, Shape};
use crate::report::drawing::{
    Axis, Canvas, Entry, Frame, GREY, Panel, Scale, Stroke, Swatch, bounds, curve_style, escaped,
    row,
};
use crate::study::diagnose::Diagnosed;
use crate::units::{deg_from_rad, mm_from_m, percent_from_ratio};
use crate::wording::printable;

const PANEL: Frame = Frame { left: 85.0, top: 35.0, width: 515.0, height: 245.0 };

/// The page: the text, measured against predicted before and after, residuals over what they follow
/// and over all else, the ranking.
pub fn diagnosis(diagnosed: &Diagnosed) -> String {
    let d = &diagnosed.diagnosis;
    let mut out = String::new();
    let title = escaped(&format!("Diagnosis of {}", diagnosed.robot));
    // Writing to a string does not fail.
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\n<style>\
         body{{font:15px/1.5 system-ui,sans-serif;max-width:80em;margin:2em auto;padding:0 1em}}\
         pre{{background:#f5f5f5;padding:1em;overflow:auto}}svg{{background:#fff;max-width:100%}}\
         figure{{display:inline-block;margin:0 1em 1em 0}}td,th{{padding:.1em 1em;text-align:left}}\
         </style></head><body>\n<h1>{title}</h1>\n<pre>{}</pre>\n",
        escaped(&text::diagnosis(diagnosed))
    );
    for (caption, of) in [
        ("Measured against predicted: the model as it is", predicted_before as Of),
        ("Measured against predicted: with the findings", predicted_after as Of),
    ] {
        let axes = ["predicted [Hz]", "measured [Hz]"];
        figure(&mut out, caption, axes, &points(d, of), true);
    }
    let covariates = covariates(d);
    let followed = d.structure_before.as_ref().and_then(|structure| followed(&structure.shape, d));
    let chosen = followed.or_else(|| covariates.iter().position(|c| *c == Covariate::Row));
    if let Some(covariate) = chosen.map(|i| covariates[i]) {
        let (name, axis) = (covariate.name(d), covariate.axis(d));
        for (caption, after) in [("the model as it is", false), ("with the findings", true)] {
            let caption = format!("Residual over {name}: {caption}");
            let axes = [&*axis, RESIDUAL];
            figure(&mut out, &caption, axes, &residuals(d, covariate, after), false);
        }
    }
    out.push_str("<details><summary>Residuals over the other columns of the table</summary>\n");
    for (i, covariate) in covariates.iter().enumerate().filter(|(i, _)| Some(*i) != chosen) {
        let caption = format!("Residual over {}: the model as it is", covariate.name(d));
        let axes = [&*covariate.axis(d), RESIDUAL];
        figure(&mut out, &caption, axes, &residuals(d, covariates[i], false), false);
    }
    out.push_str("</details>\n");
    if !d.ranking.is_empty() {
        out.push_str(
            "<h2>Single causes</h2>\n<table><tr><th>cause</th><th>ΔBIC to the best</th></tr>\n",
        );
        for suspect in &d.ranking {
            let label = escaped(&suspect.label());
            let _ = writeln!(out, "<tr><td>{label}</td><td>{:.1}</td></tr>", suspect.behind_bic);
        }
        out.push_str("</table>\n");
    }
    out.push_str("</body></html>\n");
    out
}

type Of = fn(&ResidualRow) -> Option<(f64, f64)>;

fn predicted_before(r: &ResidualRow) -> Option<(f64, f64)> {
    Some((r.before_hz?, r.measured_hz))
}

fn predicted_after(r: &ResidualRow) -> Option<(f64, f64)> {
    Some((r.after_hz?, r.measured_hz))
}

/// The axis of residuals.
const RESIDUAL: &str = "residual [%]";

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
            Self::Joint(joint) => d.joints.get(joint).map_or_else(String::new, |(n, _)| n.clone()),
            Self::Temperature => "temperature".to_owned(),
            Self::Amplitude => "level of excitation".to_owned(),
            Self::Frequency => "measured frequency".to_owned(),
        }
    }

    /// Name of the axis.
    fn axis(self, d: &Diagnosis) -> String {
        let unit = match self {
            Self::Row => return "row".to_owned(),
            Self::Joint(joint) => match d.joints.get(joint) {
                Some((_, true)) => "mm",
                _ => "°",
            },
            Self::Temperature => "°C",
            Self::Amplitude => "N·m",
            Self::Frequency => "Hz",
        };
        format!("{} [{unit}]", self.name(d))
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

/// A plot of points by mode; `equal` gives both axes the same range and draws the diagonal.
fn figure(
    out: &mut String,
    caption: &str,
    [x, y]: [&str; 2],
    points: &[(usize, f64, f64)],
    equal: bool,
) {
    if points.is_empty() {
        return;
    }
    let (mut left, mut right) = bounds(points.iter().map(|p| p.1));
    let (mut low, mut high) = bounds(points.iter().map(|p| p.2));
    if equal {
        (left, right) = (left.min(low), right.max(high));
        (low, high) = (left, right);
    } else {
        (low, high) = (low.min(0.0), high.max(0.0));
    }
    let panel = Panel {
        frame: PANEL,
        x: Axis::new(x, Scale::linear(left, right)),
        y: Axis::new(y, Scale::linear(low, high)),
    };
    let mut canvas = Canvas::new(620.0, 340.0);
    panel.axes(&mut canvas, true);
    let ends = if equal { [(left, left), (right, right)] } else { [(left, 0.0), (right, 0.0)] };
    panel.curve(&mut canvas, &ends, Stroke { colour: GREY, width: 1.5, dashes: "" });
    for (mode, x, y) in points {
        panel.dot(&mut canvas, (*x, *y), 3.0, curve_style(*mode).0);
    }
    canvas.border(PANEL);
    let modes = points.iter().map(|(mode, ..)| mode + 1).max().unwrap_or(0);
    let entry = |mode| Entry::new(Swatch::Dot(curve_style(mode).0), format!("mode {}", mode + 1));
    row(&mut canvas, (PANEL.right(), 18.0), &(0..modes).map(entry).collect::<Vec<_>>());
    let caption = escaped(&printable(caption));
    let drawing = canvas.finish();
    let _ = writeln!(out, "<figure><figcaption>{caption}</figcaption>{drawing}</figure>");
}
