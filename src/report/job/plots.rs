//! The plots of an operation.

use crate::excitation::ExcitationLine;
use crate::process::LimitAt;
use crate::report::check::findings::stretches;
use crate::report::drawing::{
    Axis, CERTAIN, Canvas, Entry, Frame, GREY, INK, Label, POSSIBLE, Panel, Scale, Stroke, Swatch,
    bounds, curve_style, height_beside, labels_beside, row,
};
use crate::report::words;
use crate::risk::{Certainty, Crossing, OperationRisk, TipAt};
use crate::study::arm::Place;
use crate::units::{deg_from_rad, mm_from_m, um_from_m, um_per_n_from_m_per_n};

const WIDTH: f64 = 980.0;
const LEFT: f64 = 85.0;
const PANEL_WIDTH: f64 = 690.0;
const TOP: f64 = 36.0;
const BELOW: f64 = 54.0;

/// Wider ranges of frequencies are drawn on a logarithmic scale.
const MAX_LINEAR_RATIO: f64 = 4.0;

/// Modes up to so many times the highest line of excitation are drawn.
const ABOVE_LINES: f64 = 2.5;

/// How strong the colour of an interval is.
const INTERVAL_OPACITY: f64 = 0.16;

const MODE: f64 = 2.0;
const EXCITATION: Stroke = Stroke { colour: INK, width: 1.4, dashes: "7 4" };
const BAR: Stroke = Stroke { colour: INK, width: 1.6, dashes: "" };
const CROSSING_PX: f64 = 11.0;

/// Stretches that are no further apart are drawn as one, px.
const TOGETHER_PX: f64 = 2.0;

/// At most so many crossings of an operation are marked and listed, the most severe.
pub(super) const LISTED: usize = 24;

fn along() -> Axis {
    Axis::new("share of the operation's time, s", Scale::linear(0.0, 1.0))
}

fn panel(height: f64, x: Axis, y: Axis) -> (Canvas, Panel) {
    let frame = Frame { left: LEFT, top: TOP, width: PANEL_WIDTH, height };
    (Canvas::new(WIDTH, TOP + height + BELOW), Panel { frame, x, y })
}

/// The lowest modes, up to well above the highest line: what lies above meets nothing.
pub(super) fn drawn_modes(risk: &OperationRisk) -> usize {
    let Some(highest) = highest_line_hz(risk) else { return risk.uncertainty_by_mode.len() };
    let is_near = |r: &usize| {
        let lows = risk.samples.iter().map(|sample| sample.natural_frequencies_ci95_hz[*r][0]);
        bounds(lows).0 <= ABOVE_LINES * highest
    };
    (0..risk.uncertainty_by_mode.len()).take_while(is_near).count().max(1)
}

fn highest_line_hz(risk: &OperationRisk) -> Option<f64> {
    let lines = risk.lines.iter().flat_map(|line| excitation(risk, line));
    let (_, high) = bounds(lines.map(|(_, hz)| hz));
    high.is_finite().then_some(high)
}

/// Modes with their intervals, lines of excitation, and where they meet.
pub(in crate::report) fn frequencies(risk: &OperationRisk) -> Canvas {
    let modes = drawn_modes(risk);
    let of_mode = |r: usize| risk.samples.iter().map(move |sample| (sample.s, sample, r));
    let all = (0..modes).flat_map(of_mode);
    let ends = all.flat_map(|(_, sample, r)| sample.natural_frequencies_ci95_hz[r]);
    let (low, high) = bounds(ends.chain(highest_line_hz(risk)));
    let (low, high) = (0.88 * low, 1.1 * high);
    let hz = if high > MAX_LINEAR_RATIO * low {
        Scale::logarithmic(low, high)
    } else {
        Scale::linear(low, high)
    };
    let height = height_beside(modes + risk.lines.len()).max(400.0);
    let (mut canvas, panel) = panel(height, along(), Axis::new("frequency [Hz]", hz));
    panel.axes(&mut canvas, true);
    let mut labels: Vec<Label> = Vec::new();
    for r in 0..modes {
        let (colour, _) = curve_style(r);
        let end = |side: usize| {
            let points =
                of_mode(r).map(|(s, sample, r)| (s, sample.natural_frequencies_ci95_hz[r][side]));
            panel.thinned(&points.collect::<Vec<_>>())
        };
        let outline = end(1).into_iter().chain(end(0).into_iter().rev());
        panel.area(&mut canvas, outline, colour, INTERVAL_OPACITY);
    }
    underlays(&mut canvas, &panel, risk);
    for r in 0..modes {
        let (colour, dashes) = curve_style(r);
        let curve = of_mode(r).map(|(s, sample, r)| (s, sample.natural_frequencies_hz[r]));
        let curve = panel.thinned(&curve.collect::<Vec<_>>());
        panel.curve(&mut canvas, &curve, Stroke { colour, width: MODE, dashes });
        let last = curve.last().map(|(_, hz)| *hz);
        labels.extend(last.map(|at| Label { at, colour, text: format!("mode {}", r + 1) }));
    }
    for line in &risk.lines {
        let curve = excitation(risk, line);
        panel.curve(&mut canvas, &panel.thinned(&curve), EXCITATION);
        let mut seen = curve.iter().rev().map(|(_, hz)| *hz);
        let seen = seen.find(|hz| (0.0..=1.0).contains(&panel.y.scale.share(*hz)));
        labels.extend(seen.map(|at| Label { at, colour: INK, text: words::line(line) }));
    }
    for crossing in stretches(&risk.crossings).iter().take(LISTED).map(|found| found.crossing) {
        let at = (crossing.closest_s, crossing.natural_frequency_hz);
        panel.dot(&mut canvas, at, 3.5, INK);
    }
    canvas.border(panel.frame);
    labels_beside(&mut canvas, &panel, &labels);
    let entries = [
        Entry::new(Swatch::Line(EXCITATION), "line of excitation"),
        Entry::new(Swatch::Area(CERTAIN, 1.0), "resonance"),
        Entry::new(Swatch::Area(POSSIBLE, 1.0), "possible resonance"),
        Entry::new(Swatch::Dot(INK), "closest"),
    ];
    row(&mut canvas, (panel.frame.right(), 16.0), &entries);
    panel.sense(&mut canvas, "data-along");
    canvas
}

/// Broad lines along the modes where a line of excitation lies in their bands, the certain ones
/// above the others. Stretches of a mode that nobody could tell apart are drawn as one.
fn underlays(canvas: &mut Canvas, panel: &Panel, risk: &OperationRisk) {
    let mut crossings: Vec<&Crossing> = risk.crossings.iter().collect();
    crossings.sort_by(|a, b| {
        let order = a.certainty.cmp(&b.certainty).then(a.mode.cmp(&b.mode));
        order.then(a.from_s.total_cmp(&b.from_s))
    });
    let same = |a: &Crossing, b: &Crossing| (a.mode, a.certainty) == (b.mode, b.certainty);
    for of_mode in crossings.chunk_by(|a, b| same(a, b)) {
        let mut open: Option<(f64, f64)> = None;
        for crossing in of_mode {
            open = match open {
                Some((from, to)) if panel.px(crossing.from_s) - panel.px(to) < TOGETHER_PX => {
                    Some((from, to.max(crossing.to_s)))
                }
                other => {
                    other.iter().for_each(|ends| underlay(canvas, panel, risk, crossing, *ends));
                    Some((crossing.from_s, crossing.to_s))
                }
            };
        }
        if let (Some(ends), Some(any)) = (open, of_mode.first()) {
            underlay(canvas, panel, risk, any, ends);
        }
    }
}

/// A broad line along the mode of a crossing between two places.
fn underlay(
    canvas: &mut Canvas,
    panel: &Panel,
    risk: &OperationRisk,
    crossing: &Crossing,
    (from, to): (f64, f64),
) {
    let inside = risk.samples.iter().filter(|sample| (from..=to).contains(&sample.s));
    let mut points: Vec<(f64, f64)> = inside
        .filter_map(|sample| {
            Some((sample.s, *sample.natural_frequencies_hz.get(crossing.mode - 1)?))
        })
        .collect();
    if points.is_empty() {
        points.push((crossing.closest_s.clamp(from, to), crossing.natural_frequency_hz));
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    // A stretch between two samples is drawn, too.
    if let (Some(&(_, first)), Some(&(_, last))) = (points.first(), points.last()) {
        points.insert(0, (from, first));
        points.push((to, last));
    }
    let colour = match crossing.certainty {
        Certainty::Certain => CERTAIN,
        Certainty::Uncertain => POSSIBLE,
    };
    panel.curve(canvas, &panel.thinned(&points), Stroke { colour, width: CROSSING_PX, dashes: "" });
}

/// A line's frequency over s, where the spindle turns.
fn excitation(risk: &OperationRisk, line: &ExcitationLine) -> Vec<(f64, f64)> {
    let at = |sample: &crate::risk::Sample| {
        let turns = sample.rpm > 0.0;
        (sample.s, if turns { line.frequency_hz(sample.rpm) } else { f64::NAN })
    };
    risk.samples.iter().map(at).collect()
}

/// β2 over s, where the robot defines it.
pub(in crate::report) fn beta2(risk: &OperationRisk) -> Option<Canvas> {
    let angle = |sample: &crate::risk::Sample| Some((sample.s, deg_from_rad(sample.beta2_rad?)));
    let points: Option<Vec<(f64, f64)>> = risk.samples.iter().map(angle).collect();
    let points = points.filter(|points| !points.is_empty())?;
    let (low, high) = bounds(points.iter().map(|p| p.1));
    let (mut canvas, panel) = panel(150.0, along(), Axis::new("β2 [°]", Scale::linear(low, high)));
    panel.axes(&mut canvas, true);
    let (colour, dashes) = curve_style(0);
    panel.curve(&mut canvas, &panel.thinned(&points), Stroke { colour, width: MODE, dashes });
    canvas.border(panel.frame);
    panel.sense(&mut canvas, "data-along");
    Some(canvas)
}

/// The limit of depth over s, with the interval of the smallest and the depth of the cut; `None`
/// where there is no limit.
pub(in crate::report) fn limit_of_depth(risk: &OperationRisk) -> Option<Canvas> {
    let chatter = risk.stability.as_ref()?;
    let limit_mm = |at: &LimitAt| (at.s, at.depth_m.map_or(f64::NAN, mm_from_m));
    let points: Vec<(f64, f64)> = chatter.along.iter().map(limit_mm).collect();
    let depth_mm = mm_from_m(chatter.depth_m);
    let smallest = limit_mm(chatter.smallest.as_ref()?);
    let ends = chatter.smallest_ci95_m.map(|end| end.map(mm_from_m));
    let limits = points.iter().map(|point| point.1).filter(|mm| mm.is_finite());
    let scale = of_size(limits.chain(ends.into_iter().flatten()).chain([depth_mm]));
    let limit_of = chatter.limit_of.name();
    let axis = format!("{limit_of} [mm]");
    let own = format!("{limit_of} that is cut");
    let (mut canvas, panel) = panel(220.0, along(), Axis::new(&axis, scale));
    panel.axes(&mut canvas, true);
    let (colour, _) = curve_style(0);
    let limit = Stroke { colour, width: MODE, dashes: "" };
    panel.curve(&mut canvas, &points, limit);
    if let [Some(low), high] = ends {
        let high = high.unwrap_or_else(|| panel.y.scale.high());
        panel.curve(&mut canvas, &[(smallest.0, low), (smallest.0, high)], BAR);
    }
    panel.dot(&mut canvas, smallest, 3.5, INK);
    panel.curve(&mut canvas, &[(0.0, depth_mm), (1.0, depth_mm)], EXCITATION);
    canvas.border(panel.frame);
    let entries = [
        Entry::new(Swatch::Line(limit), "the cut chatters above"),
        Entry::new(Swatch::Line(EXCITATION), &own),
        Entry::new(Swatch::Dot(INK), "smallest, with its interval"),
    ];
    row(&mut canvas, (panel.frame.right(), 16.0), &entries);
    panel.sense(&mut canvas, "data-along");
    Some(canvas)
}

/// How far the tool tip moves over s, and what that may come to; `None` where no force is known.
pub(in crate::report) fn tool_tip(risk: &OperationRisk) -> Option<Canvas> {
    let tip = risk.tool_tip.as_ref()?;
    let curve = |of: fn(&TipAt) -> [f64; 2]| -> Vec<(f64, [f64; 2])> {
        tip.along.iter().map(|at| (at.s, of(at).map(um_from_m))).collect()
    };
    let curves = [
        ("under the mean force", curve(|at| at.deflection_m)),
        ("vibration", curve(|at| at.vibration_m)),
    ];
    let all = curves.iter().flat_map(|(_, points)| points).flat_map(|(_, um)| *um);
    let scale = of_size(all.filter(|um| *um > 0.0));
    let lowest = scale.low();
    let (mut canvas, panel) = panel(260.0, along(), Axis::new("tool tip [µm]", scale));
    panel.axes(&mut canvas, true);
    let mut entries = Vec::new();
    for (index, (name, points)) in curves.into_iter().enumerate() {
        let (colour, dashes) = curve_style(index);
        let end = |side: usize| points.iter().map(move |(s, um)| (*s, um[side].max(lowest)));
        let outline = end(1).chain(end(0).rev());
        panel.area(&mut canvas, outline, colour, INTERVAL_OPACITY);
        let stroke = Stroke { colour, width: MODE, dashes };
        panel.curve(&mut canvas, &panel.thinned(&end(0).collect::<Vec<_>>()), stroke);
        entries.push(Entry::new(Swatch::Line(stroke), name));
    }
    canvas.border(panel.frame);
    entries.push(Entry::new(Swatch::Area(GREY, INTERVAL_OPACITY), "what it may come to"));
    row(&mut canvas, (panel.frame.right(), 16.0), &entries);
    panel.sense(&mut canvas, "data-along");
    Some(canvas)
}

/// From zero, or logarithmic where the values differ much.
fn of_size(values: impl Iterator<Item = f64>) -> Scale {
    let (low, high) = bounds(values);
    if high > MAX_LINEAR_RATIO * low && low > 0.0 {
        Scale::logarithmic(0.8 * low, 1.25 * high)
    } else {
        Scale::linear(0.0, 1.1 * high)
    }
}

/// The frame in which a page draws the receptance of the tool tip at the place that is chosen.
pub(super) fn receptance(risk: &OperationRisk, places: &[Place]) -> Option<Canvas> {
    let frequencies = places.iter().flat_map(|place| &place.sample.natural_frequencies_hz);
    let (low, high) = bounds(frequencies.copied());
    let peaks = places.iter().flat_map(|place| &place.sample.tip_response_m_per_n);
    let (_, peak) = bounds(peaks.map(|tip| um_per_n_from_m_per_n(*tip)));
    if !(low > 0.0 && high.is_finite() && peak > 0.0) || risk.samples.is_empty() {
        return None;
    }
    let x = Axis::new("frequency [Hz]", Scale::logarithmic(0.5 * low, 1.5 * high));
    let y = Axis::new("receptance [µm/N]", Scale::logarithmic(2e-4 * peak, 2.0 * peak));
    let (mut canvas, panel) = panel(300.0, x, y);
    panel.axes(&mut canvas, true);
    canvas.border(panel.frame);
    let entry = |(index, name): (usize, &&str)| {
        let (colour, _) = curve_style(index);
        let dashes = ["", "9 4", "2 4"][index];
        Entry::new(Swatch::Line(Stroke { colour, width: 1.8, dashes }), *name)
    };
    let entries: Vec<Entry> = ["x", "y", "z"].iter().enumerate().map(entry).collect();
    row(&mut canvas, (panel.frame.right(), 16.0), &entries);
    panel.sense(&mut canvas, "data-receptance");
    Some(canvas)
}
