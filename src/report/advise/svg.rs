//! The speed map: path against spindle speed, bands as areas, programmed and advised speeds as lines.

use crate::advice::{OperationAdvice, Remedy};
use crate::report::svg::{Anchor, Axis, Frame, Panel, Sheet, Stroke, curve_style};
use crate::study::advise::AdvisedJob;

const TITLE: &str = "font-size=\"16\" font-weight=\"bold\"";
const PANEL_TITLE: &str = "font-size=\"14\" font-weight=\"bold\"";
const WIDTH: f64 = 900.0;
const PANEL_HEIGHT: f64 = 360.0;
const INK: &str = "#000000";

/// Draws one panel an operation.
pub fn advice(job: &AdvisedJob) -> String {
    let operations = &job.advice.operations;
    let height = 70.0 + operations.len() as f64 * (PANEL_HEIGHT + 95.0);
    let mut sheet = Sheet::new(WIDTH, height);
    sheet.text(80.0, 30.0, Anchor::Start, TITLE, &format!("Spindle speeds: {}", job.name));
    for (index, operation) in operations.iter().enumerate() {
        let top = 85.0 + index as f64 * (PANEL_HEIGHT + 95.0);
        panel(&mut sheet, job, operation, top);
    }
    sheet.finish()
}

fn panel(sheet: &mut Sheet, job: &AdvisedJob, operation: &OperationAdvice, top: f64) {
    let frame = Frame { left: 80.0, top, width: WIDTH - 220.0, height: PANEL_HEIGHT };
    let (mut low, mut high) = (job.spindle.min_rpm, job.spindle.max_rpm);
    if low >= high {
        (low, high) = (0.9 * low, 1.1 * high);
    }
    let axis = |label: &str, low: f64, high: f64| Axis {
        label: label.to_owned(),
        low,
        high,
        is_logarithmic: false,
    };
    let speeds =
        Axis { is_logarithmic: high > 8.0 * low, ..axis("spindle speed [rpm]", low, high) };
    let panel = Panel { frame, x: axis("s [1]", 0.0, 1.0), y: speeds };
    sheet.text(frame.left, top - 10.0, Anchor::Start, PANEL_TITLE, &operation.name);
    sheet.axes(&panel, true);
    let clamped = |rpm: f64| rpm.clamp(low, high);
    let mut legend: Vec<usize> = Vec::new();
    for ribbon in operation.map.ribbons(&operation.lines) {
        let is_seen = ribbon.edges.iter().any(|(_, e)| e.high_rpm > low && e.low_rpm < high);
        if !is_seen {
            continue;
        }
        let above = ribbon.edges.iter().map(|(s, e)| (*s, clamped(e.high_rpm)));
        let below = ribbon.edges.iter().rev().map(|(s, e)| (*s, clamped(e.low_rpm)));
        let outline: Vec<(f64, f64)> = above.chain(below).collect();
        sheet.area(&panel, &outline, curve_style(ribbon.mode - 1).0, 0.35);
        if !legend.contains(&ribbon.mode) {
            legend.push(ribbon.mode);
        }
    }
    let stroke = |width, dashes| Stroke { colour: INK, width, dashes };
    let programmed = clamped(operation.programmed_rpm);
    sheet.curve(&panel, &[(0.0, programmed), (1.0, programmed)], stroke(1.8, "7 5"));
    let advised: Vec<(f64, f64)> = match &operation.remedy {
        Remedy::Constant(constant) => vec![(0.0, constant.rpm), (1.0, constant.rpm)],
        Remedy::Scheduled(plan) => plan.points.clone(),
        Remedy::Kept(kept) => kept.points.clone(),
        Remedy::Infeasible => Vec::new(),
    };
    if !advised.is_empty() {
        sheet.curve(&panel, &advised, stroke(2.4, ""));
    }
    sheet.border(frame);
    let left = frame.left + frame.width + 12.0;
    let mut y = top + 12.0;
    let mut entry = |text: &str, colour: &str| {
        let style = format!("font-weight=\"bold\" style=\"fill:{colour}\"");
        sheet.text(left, y, Anchor::Start, &style, text);
        y += 18.0;
    };
    entry("- - programmed", INK);
    entry(if advised.is_empty() { "none is safe" } else { "— advised" }, INK);
    legend.sort_unstable();
    for mode in legend {
        entry(&format!("bands of mode {mode}"), curve_style(mode - 1).0);
    }
}
