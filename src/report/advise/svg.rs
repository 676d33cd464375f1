//! The speed map: path against spindle speed. Grey: closed by a mode and a line, with the speed at
//! which they coincide; green: safe constant speeds, with their ends; black: programmed and
//! advised.

use super::words::pair;
use crate::advice::{OperationAdvice, Remedy, Ribbon, Speeds};
use crate::report::Plot;
use crate::report::drawing::{
    Anchor, Axis, CLOSED, Canvas, Entry, Face, Frame, INK, Label, Panel, SAFE, Scale, Stroke,
    Swatch, curve_style, height_beside, labels_beside, row,
};
use crate::report::words::{round_percent, trimmed};
use crate::study::advise::AdvisedJob;

const LEFT: f64 = 85.0;
const PANEL_WIDTH: f64 = 690.0;
const MIN_PANEL_HEIGHT: f64 = 360.0;

/// Above each panel, and below it.
const OVER: f64 = 35.0;
const UNDER: f64 = 60.0;

/// A wider range of speeds is drawn on a logarithmic scale.
const MAX_LINEAR_RATIO: f64 = 8.0;

const PROGRAMMED: Stroke = Stroke { colour: INK, width: 1.8, dashes: "7 5" };
const ADVISED: Stroke = Stroke { colour: INK, width: 2.6, dashes: "" };
const SAFE_OPACITY: f64 = 0.25;

/// A safe stretch that is lower is not named, px.
const MIN_NAMED_PX: f64 = 15.0;

/// Draws one panel an operation.
pub fn advice(job: &AdvisedJob) -> Canvas {
    drawing(job, &job.advice.operations, &format!("Spindle speeds: {}", job.name), false)
}

/// One operation, for a page whose script answers to the pointer.
pub(in crate::report) fn operation(job: &AdvisedJob, operation: &OperationAdvice) -> Canvas {
    drawing(job, std::slice::from_ref(operation), "", true)
}

/// The map of each operation, with its name.
pub fn plots(job: &AdvisedJob) -> Vec<Plot> {
    let one = |(index, of): (usize, &OperationAdvice)| {
        (format!("{}-{}-speeds", index + 1, of.name), operation(job, of))
    };
    job.advice.operations.iter().enumerate().map(one).collect()
}

fn drawing(job: &AdvisedJob, operations: &[OperationAdvice], title: &str, senses: bool) -> Canvas {
    let (mut low, mut high) = (job.spindle.min_rpm, job.spindle.max_rpm);
    if low >= high {
        (low, high) = (0.9 * low, 1.1 * high);
    }
    let speeds = if high > MAX_LINEAR_RATIO * low {
        Scale::logarithmic(low, high)
    } else {
        Scale::linear(low, high)
    };
    let operations: Vec<(&OperationAdvice, Vec<&Ribbon>)> =
        operations.iter().map(|of| (of, ribbons(of, &speeds))).collect();
    let panel_height = |of: &[&Ribbon]| height_beside(of.len()).max(MIN_PANEL_HEIGHT);
    let head = if title.is_empty() { 25.0 } else { 70.0 };
    let heights = operations.iter().map(|(_, of)| OVER + panel_height(of) + UNDER);
    let mut canvas = Canvas::new(980.0, head + heights.sum::<f64>());
    canvas.text((LEFT, 30.0), Anchor::Start, Face::Title, title);
    legend(&mut canvas, job, head - 12.0);
    let mut top = head;
    for (operation, ribbons) in &operations {
        top += OVER;
        let height = panel_height(ribbons);
        let frame = Frame { left: LEFT, top, width: PANEL_WIDTH, height };
        let panel = Panel {
            frame,
            x: Axis::new("share of the operation's time, s", Scale::linear(0.0, 1.0)),
            y: Axis::new("spindle speed [rpm]", speeds.clone()),
        };
        draw(&mut canvas, &panel, operation, ribbons);
        if senses {
            panel.sense(&mut canvas, "data-along");
        }
        top += height + UNDER;
    }
    canvas
}

fn legend(canvas: &mut Canvas, job: &AdvisedJob, middle: f64) {
    let half_width = round_percent(job.advice.separation + job.advice.model_uncertainty());
    let entries = [
        Entry::new(Swatch::Line(PROGRAMMED), "programmed"),
        Entry::new(Swatch::Line(ADVISED), "advised"),
        Entry::new(Swatch::Area(SAFE, SAFE_OPACITY), "safe constant speeds"),
        Entry::new(Swatch::Area(CLOSED, 1.0), format!("a line within ±{half_width} % of a mode")),
    ];
    row(canvas, (LEFT + PANEL_WIDTH, middle), &entries);
}

/// The ribbons that reach into the spindle's range.
fn ribbons<'a>(operation: &'a OperationAdvice, speeds: &Scale) -> Vec<&'a Ribbon> {
    let is_seen = |ribbon: &&Ribbon| {
        let edges = &mut ribbon.edges.iter();
        edges.any(|(_, e)| e.high_rpm > speeds.low() && e.low_rpm < speeds.high())
    };
    operation.ribbons.iter().filter(is_seen).collect()
}

fn draw(canvas: &mut Canvas, panel: &Panel, operation: &OperationAdvice, ribbons: &[&Ribbon]) {
    let speeds = &panel.y.scale;
    let clamped = |rpm: f64| rpm.clamp(speeds.low(), speeds.high());
    for gap in &operation.set.safe {
        let [low, high] = [gap.low_rpm, gap.high_rpm].map(clamped);
        let outline = [(0.0, low), (1.0, low), (1.0, high), (0.0, high)];
        panel.area(canvas, outline.into_iter(), SAFE, SAFE_OPACITY);
    }
    for Ribbon { edges, .. } in ribbons {
        let end = |of: fn(&Speeds) -> f64| {
            panel.thinned(&edges.iter().map(|(s, e)| (*s, clamped(of(e)))).collect::<Vec<_>>())
        };
        let (above, below) = (end(|e| e.high_rpm), end(|e| e.low_rpm));
        panel.area(canvas, above.into_iter().chain(below.into_iter().rev()), CLOSED, 1.0);
    }
    panel.axes(canvas, true);
    let advised = advised(&operation.remedy);
    let starts = advised.iter().flatten().take(1).map(|(_, rpm)| *rpm);
    let told: Vec<f64> = starts.chain([operation.programmed_rpm]).collect();
    for gap in &operation.set.safe {
        let [low, high] = [gap.low_rpm, gap.high_rpm].map(clamped);
        if panel.py(low) - panel.py(high) >= MIN_NAMED_PX {
            let name = format!("{}–{} rpm", trimmed(gap.low_rpm, 1), trimmed(gap.high_rpm, 1));
            // In the widest part that no line of a speed runs through.
            let taken = told.iter().copied().filter(|rpm| (low..high).contains(rpm));
            let mut ends: Vec<f64> =
                taken.chain([low, high]).map(|rpm| speeds.share(rpm)).collect();
            ends.sort_by(f64::total_cmp);
            let widest = ends.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
            let middle = widest.map_or(0.5, |part| 0.5 * (part[0] + part[1]));
            panel.note(canvas, (0.0, speeds.value(middle)), &name);
        }
    }
    let mut labels: Vec<Label> = Vec::new();
    for ribbon in ribbons {
        let (colour, dashes) = curve_style(ribbon.mode - 1);
        let coincident: Vec<(f64, f64)> =
            ribbon.edges.iter().map(|(s, e)| (*s, 0.5 * (e.low_rpm + e.high_rpm))).collect();
        let curve = panel.thinned(&coincident);
        panel.curve(canvas, &curve, Stroke { colour, width: 1.6, dashes });
        let at = coincident.last().map_or(speeds.low(), |(_, rpm)| clamped(*rpm));
        let text = pair(ribbon.mode, &ribbon.line);
        // A mode that counts here and there has several ribbons: the last one is named.
        labels.retain(|label| label.text != text);
        labels.push(Label { at, colour, text });
    }
    let programmed = clamped(operation.programmed_rpm);
    panel.curve(canvas, &[(0.0, programmed), (1.0, programmed)], PROGRAMMED);
    let title = match advised {
        Some(advised) => {
            panel.curve(canvas, &advised, ADVISED);
            operation.name.clone()
        }
        None => format!("{}: no safe speed", operation.name),
    };
    panel.title(canvas, &title);
    canvas.border(panel.frame);
    labels_beside(canvas, panel, &labels);
}

/// The advised speeds over s; `None` where there is none.
fn advised(remedy: &Remedy) -> Option<Vec<(f64, f64)>> {
    match remedy {
        Remedy::Constant(constant) => Some(vec![(0.0, constant.rpm), (1.0, constant.rpm)]),
        Remedy::Scheduled(plan) => Some(plan.points.clone()),
        Remedy::Kept(kept) => Some(kept.points.clone()),
        Remedy::Infeasible => None,
    }
}
