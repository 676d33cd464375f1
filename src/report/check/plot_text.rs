//! The natural frequencies along a path and the excitation lines, drawn with characters (Braille
//! dots, two by four a character).

use crate::excitation::{ExcitationLine, Source};
use crate::report::{style, words};
use crate::risk::{Certainty, Crossing, OperationRisk};

/// Width of the drawing, characters.
const COLUMNS: usize = 60;

/// Height of the drawing, characters.
const ROWS: usize = 16;

const DOTS_PER_COLUMN: usize = 2;
const DOTS_PER_ROW: usize = 4;

/// Width of the frequencies at the axis, characters.
const TICK_WIDTH: usize = 8;

/// Curves near those that matter are shown as long as the highest frequency of the drawing is at
/// most so many times the lowest.
const MAX_RATIO: f64 = 3.0;

/// What is left free above and below, as a share of the drawing.
const FREE_SHARE: f64 = 0.06;

/// The drawing spans at least this share of its highest frequency.
const MIN_SPAN: f64 = 0.1;

/// At most so many excitation lines are drawn.
const MAX_LINES: usize = 8;

/// Code point of the Braille character without dots.
const NO_DOTS: u32 = 0x2800;

/// Bits of the dots of a Braille character, column by column, from top to bottom.
const DOT_BITS: [[u8; DOTS_PER_ROW]; DOTS_PER_COLUMN] =
    [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// What a curve is: a mode or a line's source, and its number.
type Name = (&'static str, u32);

/// A frequency over s.
struct Curve {
    name: Name,
    dashed: bool,
    /// (s, Hz), ascending in s, finite; at least one.
    points: Vec<(f64, f64)>,
    low: f64,
    high: f64,
}

/// Draws an operation so that the modes of `focus` (counted from 1) are well visible where its
/// lines meet them, with what lies near; all of them if `focus` is empty. Empty where there is
/// nothing to draw.
///
/// Modes are solid, lines are dashed; marks below the axis show where a crossing is certain (`█`)
/// or uncertain (`░`). The axis spans the modes in focus and the places where lines come nearest to
/// them, and of all else what is near; it does not go below zero. Lines leave the drawing where
/// they leave the axis.
pub fn frequencies(
    operation: &OperationRisk,
    focus: &[(usize, ExcitationLine)],
    colour: bool,
) -> String {
    let count = operation.samples.iter().map(|s| s.natural_frequencies_hz.len()).max().unwrap_or(0);
    let modes: Vec<Curve> = (1..=count).filter_map(|mode| mode_curve(operation, mode)).collect();
    let is_wanted = |curve: &&Curve| {
        focus.is_empty() || focus.iter().any(|&(mode, _)| curve.name == mode_name(mode))
    };
    let in_focus = modes.iter().filter(is_wanted).map(|curve| [curve.low, curve.high]);
    let nearest = focus.iter().filter_map(|(mode, line)| nearest_hz(operation, *mode, line));
    let must: Vec<[f64; 2]> = in_focus.chain(nearest.map(|hz| [hz, hz])).collect();

    let lines: Vec<Curve> =
        ordered(&operation.lines, focus).filter_map(|line| line_curve(operation, line)).collect();
    let Some([low, high]) = window(&must, modes.iter().chain(&lines)) else {
        return String::new();
    };
    let is_seen = |curve: &&Curve| curve.high >= low && curve.low <= high;
    let seen = lines.iter().filter(is_seen);
    let curves: Vec<&Curve> =
        modes.iter().filter(is_seen).chain(seen.clone().take(MAX_LINES)).collect();
    let mut drawing = Drawing::new(low, high);
    for curve in &curves {
        drawing.draw(curve);
    }
    let left_out = seen.count().saturating_sub(MAX_LINES);
    drawing.text(&curves, left_out, &operation.crossings, colour)
}

fn mode_name(mode: usize) -> Name {
    ("f", u32::try_from(mode).unwrap_or(u32::MAX))
}

/// The lines of the focus, the most frequent first, then the others as they are.
fn ordered<'a>(
    lines: &'a [ExcitationLine],
    focus: &[(usize, ExcitationLine)],
) -> impl Iterator<Item = &'a ExcitationLine> {
    let times = |line: &ExcitationLine| focus.iter().filter(|(_, l)| l == line).count();
    let mut ordered: Vec<_> = lines.iter().collect();
    ordered.sort_by_cached_key(|line| std::cmp::Reverse(times(line)));
    ordered.into_iter()
}

fn mode_curve(operation: &OperationRisk, mode: usize) -> Option<Curve> {
    let points = operation.samples.iter().filter_map(|sample| {
        sample.natural_frequencies_hz.get(mode - 1).map(|&frequency| (sample.s, frequency))
    });
    Curve::new(mode_name(mode), false, points)
}

fn line_curve(operation: &OperationRisk, line: &ExcitationLine) -> Option<Curve> {
    let source = match line.source {
        Source::ToothPassing => "tooth ×",
        Source::Spindle => "spindle ×",
    };
    let turning = operation.samples.iter().filter(|s| s.rpm > 0.0);
    let points = turning.map(|s| (s.s, line.frequency_hz(s.rpm)));
    Curve::new((source, line.harmonic), true, points)
}

/// The line's frequency at the sample where it is nearest to the mode.
fn nearest_hz(operation: &OperationRisk, mode: usize, line: &ExcitationLine) -> Option<f64> {
    let turning = operation.samples.iter().filter(|s| s.rpm > 0.0);
    let pairs = turning.filter_map(|sample| {
        let natural = *sample.natural_frequencies_hz.get(mode.checked_sub(1)?)?;
        let excitation = line.frequency_hz(sample.rpm);
        (natural.is_finite() && excitation.is_finite()).then_some((excitation, natural))
    });
    let apart = |(excitation, natural): &(f64, f64)| (excitation - natural).abs();
    pairs.min_by(|a, b| apart(a).total_cmp(&apart(b))).map(|(excitation, _)| excitation)
}

impl Curve {
    fn new(name: Name, dashed: bool, points: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let points: Vec<_> =
            points.filter(|(s, frequency)| s.is_finite() && frequency.is_finite()).collect();
        let low = points.iter().map(|p| p.1).reduce(f64::min)?;
        let high = points.iter().map(|p| p.1).reduce(f64::max)?;
        Some(Self { name, dashed, points, low, high })
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

/// Frequencies at the lower and upper edge: those that must be seen, and of the others the nearest
/// for as long as the window does not get too wide.
fn window<'a>(must: &[[f64; 2]], others: impl Iterator<Item = &'a Curve>) -> Option<[f64; 2]> {
    let mut low = must.iter().map(|span| span[0]).reduce(f64::min)?;
    let mut high = must.iter().map(|span| span[1]).reduce(f64::max)?;
    let (must_low, must_high) = (low, high);
    let gap = |curve: &Curve| (curve.low - must_high).max(must_low - curve.high).max(0.0);
    let mut others: Vec<&Curve> = others.collect();
    others.sort_by(|a, b| gap(a).total_cmp(&gap(b)));
    for curve in others {
        let (wider_low, wider_high) = (low.min(curve.low), high.max(curve.high));
        if wider_high <= MAX_RATIO * wider_low {
            (low, high) = (wider_low, wider_high);
        }
    }
    let missing = (high.abs().max(f64::MIN_POSITIVE) * MIN_SPAN - (high - low)).max(0.0);
    let free = FREE_SHARE * (high - low) + missing / 2.0;
    let window = [(low - free).max(0.0), high + free];
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

    fn text(
        &self,
        curves: &[&Curve],
        left_out: usize,
        crossings: &[Crossing],
        colour: bool,
    ) -> String {
        let labels = self.labels(curves);
        let mut text = format!("{:>TICK_WIDTH$}\n", "Hz");
        for (row, label) in labels.iter().enumerate() {
            if row % 5 == 0 {
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
                text.push_str(&format!(" {label}"));
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
        if left_out > 0 {
            text.push_str(&format!(
                "{:TICK_WIDTH$}  {MAX_LINES} of {} excitation lines are drawn\n",
                "",
                MAX_LINES + left_out
            ));
        }
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

    /// For each row, the names of the curves that end there; with an arrow where a curve has left
    /// the drawing.
    fn labels(&self, curves: &[&Curve]) -> Vec<String> {
        let mut names: Vec<[Vec<Name>; 3]> = vec![Default::default(); ROWS];
        for curve in curves {
            let row = (self.height(curve.at(1.0)) / DOTS_PER_ROW as f64).floor();
            let (row, place) = if row < 0.0 {
                (0, 1)
            } else if row >= ROWS as f64 {
                (ROWS - 1, 2)
            } else {
                (row as usize, 0)
            };
            names[row][place].push(curve.name);
        }
        names.iter_mut().map(|[here, above, below]| label(here, above, below)).collect()
    }
}

/// `f1, f2, tooth ×3–5, spindle ×1 ↑`: neighbours in number are joined.
fn label(here: &mut [Name], above: &mut [Name], below: &mut [Name]) -> String {
    let mut parts: Vec<String> = Vec::new();
    for (names, arrow) in [(here, ""), (above, " ↑"), (below, " ↓")] {
        // Modes first.
        names.sort_by_key(|&(kind, number)| (kind != "f", kind, number));
        for run in names.chunk_by(|a, b| a.0 == b.0 && a.1 + 1 == b.1) {
            match run {
                [(kind, from), .., (_, to)] if run.len() > 2 => {
                    parts.push(format!("{kind}{from}–{to}{arrow}"));
                }
                few => parts.extend(few.iter().map(|(kind, n)| format!("{kind}{n}{arrow}"))),
            }
        }
    }
    parts.join(", ")
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
