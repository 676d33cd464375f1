//! The plots of a diagnosis: measured and predicted over what the table varies, against each other,
//! and what is left over.

use crate::diagnosis::{Diagnosis, ResidualRow, Shape};
use crate::report::Plot;
use crate::report::drawing::{
    Axis, CLOSED, Canvas, Entry, Frame, GREY, INK, Panel, Scale, Stroke, Swatch, bounds,
    curve_style, row,
};
use crate::units::{deg_from_rad, mm_from_m, percent_from_ratio, ratio_from_percent};

const PANEL: Frame = Frame { left: 85.0, top: 35.0, width: 790.0, height: 265.0 };
const WIDTH: f64 = 980.0;
const HEIGHT: f64 = 360.0;

/// Error bars and bands reach so many standard deviations: 95 % of a normal distribution.
const SIGMAS: f64 = 1.96;

/// Wider ranges of frequencies are drawn on a logarithmic scale.
const MAX_LINEAR_RATIO: f64 = 4.0;

/// Measured frequencies with error bars over what the table varies most, with the model before and
/// after the findings: one plot a mode. `None` where the table varies nothing.
pub(super) fn over_pose(d: &Diagnosis) -> Vec<Plot> {
    let Some((name, axis, values)) = abscissa(d) else { return Vec::new() };
    let modes = d.residuals.iter().map(|r| r.mode + 1).max().unwrap_or(0);
    let one = |mode: usize| {
        let mut rows: Vec<(f64, &ResidualRow)> = d
            .residuals
            .iter()
            .enumerate()
            .filter(|(_, r)| r.mode == mode)
            .filter_map(|(i, r)| Some((values[i]?, r)))
            .collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        let svg = frequencies(d, mode, &axis, &rows)?;
        Some((
            format!("Mode {} over {name}: measured, and the model before and after", mode + 1),
            svg,
        ))
    };
    (0..modes).filter_map(one).collect()
}

/// The name of what the table varies, its axis, and its value per residual.
type Abscissa = (String, String, Vec<Option<f64>>);

/// The joint with the widest range, else what else varies.
fn abscissa(d: &Diagnosis) -> Option<Abscissa> {
    let varied = covariates(d);
    let width = |c: &Covariate| {
        let (low, high) = bounds(d.residuals.iter().filter_map(|r| c.of(r, d)));
        high - low
    };
    let joints = varied.iter().filter(|c| matches!(c, Covariate::Joint(_)));
    let widest = joints.max_by(|a, b| width(a).total_cmp(&width(b)));
    let other = varied.iter().find(|c| !matches!(c, Covariate::Frequency));
    let chosen = *widest.or(other)?;
    let values = d.residuals.iter().map(|r| chosen.of(r, d)).collect();
    Some((chosen.name(d), chosen.axis(d), values))
}

fn frequencies(
    d: &Diagnosis,
    mode: usize,
    axis: &str,
    rows: &[(f64, &ResidualRow)],
) -> Option<Canvas> {
    let noise = d.noise.per_mode_percent.get(mode).copied().unwrap_or(0.0);
    let noise = SIGMAS * ratio_from_percent(noise.hypot(d.noise.common_percent));
    let doubt = SIGMAS * ratio_from_percent(d.extended.model_error_percent);
    let all = rows.iter().flat_map(|(_, r)| {
        let after = r.after_hz.unwrap_or(f64::NAN);
        let measured = r.measured_hz;
        [
            measured * (1.0 - noise),
            measured * (1.0 + noise),
            r.before_hz.unwrap_or(f64::NAN),
            after * (1.0 - doubt),
            after * (1.0 + doubt),
        ]
    });
    let (low, high) = bounds(all);
    let (left, right) = bounds(rows.iter().map(|(x, _)| *x));
    if !(low < high && left <= right) {
        return None;
    }
    let free = 0.05 * (high - low);
    let scale = if low > 0.0 && high > MAX_LINEAR_RATIO * low {
        Scale::logarithmic(0.95 * low, 1.05 * high)
    } else {
        Scale::linear(low - free, high + free)
    };
    let beside = 0.02 * (right - left);
    let panel = Panel {
        frame: PANEL,
        x: Axis::new(axis, Scale::linear(left - beside, right + beside)),
        y: Axis::new("frequency [Hz]", scale),
    };
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let curve = |of: fn(&ResidualRow) -> Option<f64>, by: f64| {
        let points = rows.iter().filter_map(move |(x, r)| Some((*x, of(r)? * by)));
        points.collect::<Vec<(f64, f64)>>()
    };
    let outline = curve(|r| r.after_hz, 1.0 + doubt).into_iter();
    let outline = outline.chain(curve(|r| r.after_hz, 1.0 - doubt).into_iter().rev());
    panel.area(&mut canvas, outline, CLOSED, 0.7);
    panel.axes(&mut canvas, true);
    let [before, after] = [MODEL, FINDINGS];
    panel.curve(&mut canvas, &curve(|r| r.before_hz, 1.0), before);
    panel.curve(&mut canvas, &curve(|r| r.after_hz, 1.0), after);
    let stroke = Stroke { colour: INK, width: 1.3, dashes: "" };
    for (x, r) in rows {
        let ends = [1.0 - noise, 1.0 + noise].map(|by| (*x, r.measured_hz * by));
        panel.curve(&mut canvas, &ends, stroke);
        panel.dot(&mut canvas, (*x, r.measured_hz), 3.2, INK);
    }
    canvas.border(PANEL);
    let entries = [
        Entry::new(Swatch::Dot(INK), "measured, 95 %"),
        Entry::new(Swatch::Line(MODEL), "the model as it is"),
        Entry::new(Swatch::Line(FINDINGS), "with the findings"),
        Entry::new(Swatch::Area(CLOSED, 0.7), "its error, 95 %"),
    ];
    row(&mut canvas, (PANEL.right(), 18.0), &entries);
    Some(canvas)
}

const MODEL: Stroke = Stroke { colour: "#d55e00", width: 1.8, dashes: "7 4" };
const FINDINGS: Stroke = Stroke { colour: "#0072b2", width: 2.0, dashes: "" };

/// Measured against predicted, before and after.
pub(super) fn measured_against_predicted(d: &Diagnosis) -> Vec<Plot> {
    let both = [
        ("Measured against predicted: the model as it is", predicted_before as Of),
        ("Measured against predicted: with the findings", predicted_after as Of),
    ];
    let one =
        |(caption, of)| figure(caption, ["predicted [Hz]", "measured [Hz]"], &points(d, of), true);
    both.into_iter().filter_map(one).collect()
}

/// Residuals over what they follow, before and after; then over all else that varies, before.
pub(super) fn residuals(d: &Diagnosis) -> [Vec<Plot>; 2] {
    let covariates = covariates(d);
    let followed = d.structure_before.as_ref().and_then(|structure| followed(&structure.shape, d));
    let chosen = followed.or_else(|| covariates.iter().position(|c| *c == Covariate::Row));
    let plot = |covariate: Covariate, after: bool| {
        let model = if after { "with the findings" } else { "the model as it is" };
        let caption = format!("Residual over {}: {model}", covariate.name(d));
        let axes = [&*covariate.axis(d), RESIDUAL];
        figure(&caption, axes, &residuals_over(d, covariate, after), false)
    };
    let main = chosen.map(|i| covariates[i]);
    let first = main.into_iter().flat_map(|c| [plot(c, false), plot(c, true)]).flatten();
    let others = covariates.iter().filter(|c| Some(**c) != main);
    [first.collect(), others.filter_map(|c| plot(*c, false)).collect()]
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
        | Shape::Load
        | Shape::Order => Covariate::Row,
    };
    covariates(d).iter().position(|c| *c == covariate)
}

/// (measured − predicted) / predicted over a covariate, %.
fn residuals_over(d: &Diagnosis, covariate: Covariate, after: bool) -> Vec<(usize, f64, f64)> {
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
    caption: &str,
    [x, y]: [&str; 2],
    points: &[(usize, f64, f64)],
    equal: bool,
) -> Option<Plot> {
    if points.is_empty() {
        return None;
    }
    let (mut left, mut right) = bounds(points.iter().map(|p| p.1));
    let (mut low, mut high) = bounds(points.iter().map(|p| p.2));
    if equal {
        (left, right) = (left.min(low), right.max(high));
        (low, high) = (left, right);
    } else {
        (low, high) = (low.min(0.0), high.max(0.0));
    }
    // No dot lies on the frame.
    let wider = |low: f64, high: f64| (low - 0.03 * (high - low), high + 0.03 * (high - low));
    ((left, right), (low, high)) = (wider(left, right), wider(low, high));
    let panel = Panel {
        frame: PANEL,
        x: Axis::new(x, Scale::linear(left, right)),
        y: Axis::new(y, Scale::linear(low, high)),
    };
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
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
    Some((caption.to_owned(), canvas))
}
