//! The natural frequencies along a path and the excitation lines, drawn with characters (Braille dots,
//! two by four a character).

use super::{style, words};
use crate::excitation::{ExcitationLine, Source};
use crate::risk::{Certainty, Crossing, OperationRisk};

/// Width of the drawing, characters.
const COLUMNS: usize = 60;

/// Height of the drawing, characters.
const ROWS: usize = 16;

const DOTS_PER_COLUMN: usize = 2;
const DOTS_PER_ROW: usize = 4;

/// Every so many rows a frequency stands at the axis.
const ROWS_PER_TICK: usize = 5;

/// Width of the frequencies at the axis, characters.
const TICK_WIDTH: usize = 8;

/// Curves near those that matter are shown as long as the highest frequency of the drawing is at most so
/// many times the lowest.
const WIDEST_RATIO: f64 = 3.0;

/// What is left free above and below, as a share of the drawing.
const FREE_SHARE: f64 = 0.06;

/// The drawing spans at least this share of its highest frequency.
const LEAST_SPAN: f64 = 0.1;

/// Code point of the Braille character without dots.
const NO_DOTS: u32 = 0x2800;

/// Bits of the dots of a Braille character, column by column, from top to bottom.
const DOT_BITS: [[u8; DOTS_PER_ROW]; DOTS_PER_COLUMN] =
    [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// A frequency over s.
struct Curve {
    label: String,
    dashed: bool,
    /// (s, Hz), ascending in s, finite; at least one.
    points: Vec<(f64, f64)>,
    low: f64,
    high: f64,
}

/// Draws an operation so that the modes and lines of `focus` (mode counted from 1) are well visible, with
/// those near them; all of them if `focus` is empty. Empty where there is nothing to draw.
///
/// Modes are solid, lines are dashed; marks below the axis tell where a crossing is certain (`█`) or
/// uncertain (`░`).
pub fn frequencies(
    operation: &OperationRisk,
    focus: &[(usize, ExcitationLine)],
    colour: bool,
) -> String {
    let modes = operation.samples.iter().map(|s| s.natural_frequencies_hz.len()).max().unwrap_or(0);
    let mut in_focus = Vec::new();
    let mut others = Vec::new();
    for mode in 1..=modes {
        let wanted = focus.is_empty() || focus.iter().any(|&(m, _)| m == mode);
        let kept = if wanted { &mut in_focus } else { &mut others };
        kept.extend(mode_curve(operation, mode));
    }
    for line in &operation.lines {
        let wanted = focus.is_empty() || focus.iter().any(|(_, l)| l == line);
        let kept = if wanted { &mut in_focus } else { &mut others };
        kept.extend(line_curve(operation, line));
    }
    let Some([low, high]) = window(&in_focus, &mut others) else { return String::new() };
    let mut drawing = Drawing::new(low, high);
    let curves: Vec<Curve> = in_focus.into_iter().chain(others).collect();
    for curve in &curves {
        drawing.draw(curve);
    }
    drawing.text(&curves, &operation.crossings, colour)
}

fn mode_curve(operation: &OperationRisk, mode: usize) -> Option<Curve> {
    let points = operation.samples.iter().filter_map(|sample| {
        sample.natural_frequencies_hz.get(mode - 1).map(|&frequency| (sample.s, frequency))
    });
    Curve::new(format!("f{mode}"), false, points)
}

fn line_curve(operation: &OperationRisk, line: &ExcitationLine) -> Option<Curve> {
    let source = match line.source {
        Source::ToothPassing => "tooth",
        Source::Spindle => "spindle",
    };
    let turning = operation.samples.iter().filter(|s| s.rpm > 0.0);
    let points = turning.map(|s| (s.s, line.frequency_hz(s.rpm)));
    Curve::new(format!("{source} ×{}", line.harmonic), true, points)
}

impl Curve {
    fn new(label: String, dashed: bool, points: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let points: Vec<_> =
            points.filter(|(s, frequency)| s.is_finite() && frequency.is_finite()).collect();
        let low = points.iter().map(|p| p.1).reduce(f64::min)?;
        let high = points.iter().map(|p| p.1).reduce(f64::max)?;
        Some(Self { label, dashed, points, low, high })
    }

    /// Linear between points, constant beyond the ends.
    fn at(&self, s: f64) -> f64 {
        let after = self.points.partition_point(|p| p.0 <= s);
        match (after.checked_sub(1).and_then(|i| self.points.get(i)), self.points.get(after)) {
            (Some(&(s0, f0)), Some(&(s1, f1))) => f0 + (f1 - f0) * ((s - s0) / (s1 - s0)),
            (Some(&(_, frequency)), None) | (None, Some(&(_, frequency))) => frequency,
            (None, None) => 0.0,
        }
    }

    /// Lowest and highest frequency from `from` to `to`.
    fn span(&self, from: f64, to: f64) -> [f64; 2] {
        let inside =
            self.points.partition_point(|p| p.0 <= from)..self.points.partition_point(|p| p.0 < to);
        let inner = self.points.get(inside).unwrap_or(&[]).iter().map(|p| p.1);
        inner
            .chain([self.at(from), self.at(to)])
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], frequency| {
                [low.min(frequency), high.max(frequency)]
            })
    }
}

/// Frequencies at the lower and upper edge: those that matter, and of the others the nearest for as long as
/// the window does not get too wide.
fn window(in_focus: &[Curve], others: &mut [Curve]) -> Option<[f64; 2]> {
    let mut low = in_focus.iter().map(|c| c.low).reduce(f64::min)?;
    let mut high = in_focus.iter().map(|c| c.high).reduce(f64::max)?;
    let (focus_low, focus_high) = (low, high);
    let gap = |curve: &Curve| (curve.low - focus_high).max(focus_low - curve.high).max(0.0);
    others.sort_by(|a, b| gap(a).total_cmp(&gap(b)));
    for curve in others {
        let (wider_low, wider_high) = (low.min(curve.low), high.max(curve.high));
        if wider_high <= WIDEST_RATIO * wider_low {
            (low, high) = (wider_low, wider_high);
        }
    }
    let missing = (high.abs().max(f64::MIN_POSITIVE) * LEAST_SPAN - (high - low)).max(0.0);
    let free = FREE_SHARE * (high - low) + missing / 2.0;
    let window = [low - free, high + free];
    let span = window[1] - window[0];
    (span.is_finite() && span > 0.0).then_some(window)
}

/// Dots of modes and of lines, character by character.
struct Drawing {
    low: f64,
    high: f64,
    solid: Vec<[u8; COLUMNS]>,
    dashed: Vec<[u8; COLUMNS]>,
}

impl Drawing {
    fn new(low: f64, high: f64) -> Self {
        Self { low, high, solid: vec![[0; COLUMNS]; ROWS], dashed: vec![[0; COLUMNS]; ROWS] }
    }

    /// Height of a frequency in dots from the top; may lie outside.
    fn height(&self, frequency: f64) -> f64 {
        (self.high - frequency) / (self.high - self.low) * (ROWS * DOTS_PER_ROW) as f64
    }

    fn draw(&mut self, curve: &Curve) {
        let width = COLUMNS * DOTS_PER_COLUMN;
        for x in 0..width {
            if curve.dashed && x % (2 * DOTS_PER_COLUMN) >= DOTS_PER_COLUMN {
                continue;
            }
            let [low, high] = curve.span(x as f64 / width as f64, (x + 1) as f64 / width as f64);
            let (top, bottom) = (self.height(high).floor(), self.height(low).floor());
            let last = (ROWS * DOTS_PER_ROW) as f64 - 1.0;
            if bottom < 0.0 || top > last {
                continue;
            }
            for y in top.max(0.0) as usize..=bottom.min(last) as usize {
                let dots = if curve.dashed { &mut self.dashed } else { &mut self.solid };
                dots[y / DOTS_PER_ROW][x / DOTS_PER_COLUMN] |=
                    DOT_BITS[x % DOTS_PER_COLUMN][y % DOTS_PER_ROW];
            }
        }
    }

    fn text(&self, curves: &[Curve], crossings: &[Crossing], colour: bool) -> String {
        let labels = self.labels(curves);
        let mut text = format!("{:>TICK_WIDTH$}\n", "Hz");
        for (row, label) in labels.iter().enumerate() {
            if row % ROWS_PER_TICK == 0 {
                let share = (row as f64 + 0.5) / ROWS as f64;
                let frequency = self.high - share * (self.high - self.low);
                text.push_str(&format!("{:>TICK_WIDTH$} ┤", words::hz(frequency)));
            } else {
                text.push_str(&format!("{:TICK_WIDTH$} │", ""));
            }
            self.push_row(row, colour, &mut text);
            let end = text.trim_end().len();
            if label.is_empty() {
                text.truncate(end);
            } else {
                text.push_str(&format!(" {}", label.join(", ")));
            }
            text.push('\n');
        }
        text.push_str(&format!("{:TICK_WIDTH$} └{}\n", "", "─".repeat(COLUMNS)));
        if !crossings.is_empty() {
            text.push_str(&format!("{:TICK_WIDTH$}  {}\n", "", marks(crossings, colour)));
        }
        let middle = "s, percent of the operation's time";
        let [left, right] = ["0", "100"];
        let free = COLUMNS - left.len() - right.len();
        text.push_str(&format!("{:TICK_WIDTH$}  {left}{middle:^free$}{right}\n", ""));
        text.push_str(&format!(
            "{:TICK_WIDTH$}  solid: natural frequencies; dashed: excitation",
            ""
        ));
        if !crossings.is_empty() {
            text.push_str("; █ resonance ░ uncertain");
        }
        text.push('\n');
        text
    }

    fn push_row(&self, row: usize, colour: bool, text: &mut String) {
        for (&solid, &dashed) in self.solid[row].iter().zip(&self.dashed[row]) {
            let dots = solid | dashed;
            let shown = match char::from_u32(NO_DOTS + u32::from(dots)) {
                Some(shown) if dots != 0 => shown,
                _ => ' ',
            };
            if solid == 0 && dashed != 0 {
                text.push_str(&style::paint(style::LINE, shown, colour));
            } else {
                text.push(shown);
            }
        }
    }

    /// For each row, the names of the curves that end there; an arrow where a visible curve has left the
    /// drawing.
    fn labels(&self, curves: &[Curve]) -> Vec<Vec<String>> {
        let mut labels = vec![Vec::new(); ROWS];
        for curve in curves {
            if curve.high < self.low || curve.low > self.high {
                continue;
            }
            let row = (self.height(curve.at(1.0)) / DOTS_PER_ROW as f64).floor();
            let (row, label) = if row < 0.0 {
                (0, format!("{} ↑", curve.label))
            } else if row >= ROWS as f64 {
                (ROWS - 1, format!("{} ↓", curve.label))
            } else {
                (row as usize, curve.label.clone())
            };
            labels[row].push(label);
        }
        labels
    }
}

/// Where the crossings are, column by column.
fn marks(crossings: &[Crossing], colour: bool) -> String {
    let mut marks: [Option<Certainty>; COLUMNS] = [None; COLUMNS];
    let column = |s: f64| ((s * COLUMNS as f64).max(0.0) as usize).min(COLUMNS - 1);
    for crossing in crossings {
        let (from, to) = (column(crossing.from_s), column(crossing.to_s));
        for mark in &mut marks[from..=to.max(from)] {
            *mark = (*mark).max(Some(crossing.certainty));
        }
    }
    let shown: Vec<String> = marks
        .iter()
        .map(|mark| match mark {
            Some(Certainty::Certain) => style::paint(style::RESONANCE, '█', colour),
            Some(Certainty::Uncertain) => style::paint(style::UNCERTAIN, '░', colour),
            None => " ".to_owned(),
        })
        .collect();
    shown.concat().trim_end().to_owned()
}
