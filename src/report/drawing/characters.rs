//! A drawing with characters, for a terminal: lines as Braille dots (two by four a character),
//! areas as shades, the legend below.

use super::canvas::{Anchor, Canvas, Element, Frame, OwnStroke, Run};
use super::palette::{GRID, INK, PAPER};
use crate::report::style;

/// Width of a drawing, characters.
const COLUMNS: usize = 100;

/// A character is twice as high as wide.
const HEIGHT_OVER_WIDTH: f64 = 2.0;

/// Dots of a Braille character.
const DOTS: [usize; 2] = [2, 4];

/// Code point of the Braille character without dots.
const NO_DOTS: u32 = 0x2800;

/// Bits of the dots of a Braille character, column by column, from top to bottom.
const DOT_BITS: [[u8; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// From the frame down to the middle of the numbers of its ticks, px.
const TO_NUMBERS_PX: f64 = 14.5;

/// Shorter lines are marks of axes, px; broader ones are areas.
const MIN_LINE_PX: f64 = 6.0;
const MAX_STROKE_PX: f64 = 6.0;

/// Of areas that let through what is below, and of others in the order in which they come.
const THIN_SHADE: char = '░';
const SHADES: [char; 3] = ['▒', '▓', '█'];

/// Of areas with more colours than that, from dark to light.
const RAMP: [char; 5] = [' ', '░', '▒', '▓', '█'];

/// Text that would lie on other text moves by at most so many rows.
const MAX_MOVED: isize = 3;

/// What stands in a character, and in which colour.
#[derive(Debug, Clone, Default)]
struct Cell {
    text: Option<char>,
    dots: u8,
    dots_colour: String,
    frame: Option<char>,
    shade: Option<char>,
    shade_colour: String,
}

impl Cell {
    /// Text over lines over frames over areas.
    fn shown(&self) -> (char, &str) {
        if let Some(text) = self.text {
            return (text, INK);
        }
        if self.dots != 0 {
            let dots = char::from_u32(NO_DOTS + u32::from(self.dots)).unwrap_or(' ');
            return (dots, &self.dots_colour);
        }
        match (self.frame, self.shade) {
            (Some(frame), _) => (frame, INK),
            (None, Some(shade)) => (shade, &self.shade_colour),
            (None, None) => (' ', INK),
        }
    }
}

struct Grid {
    /// Width and height of a character, px.
    cell: [f64; 2],
    rows: Vec<Vec<Cell>>,
    /// Colours of opaque areas in the order in which they came.
    fills: Vec<String>,
    many_fills: bool,
}

impl Canvas {
    /// The drawing with characters, 100 a line at most; with colours if `colour`.
    pub fn characters(&self, colour: bool) -> String {
        let width = self.width / COLUMNS as f64;
        let cell = [width, HEIGHT_OVER_WIDTH * width];
        let rows = (self.height / cell[1]).ceil() as usize;
        let mut grid = Grid {
            cell,
            rows: vec![vec![Cell::default(); COLUMNS]; rows],
            fills: Vec::new(),
            many_fills: false,
        };
        let fills = self.elements.iter().filter_map(opaque_fill);
        for fill in fills {
            if !grid.fills.iter().any(|known| known == fill) {
                grid.fills.push(fill.to_owned());
            }
        }
        grid.many_fills = grid.fills.len() > SHADES.len();
        self.elements.iter().for_each(|element| grid.draw(element));
        // Text moves out of the way of other text, so that of the frame comes last.
        self.elements.iter().for_each(|element| grid.write(element));
        let mut text = grid.text(colour);
        text.push_str(&grid.legend(&self.elements, colour));
        text
    }
}

fn opaque_fill(element: &Element) -> Option<&str> {
    let fill = match element {
        Element::Rect { fill, opacity, .. } | Element::Polygon { fill, opacity, .. }
            if *opacity >= 1.0 =>
        {
            fill
        }
        Element::Path { stroke, .. } if stroke.width > MAX_STROKE_PX => &stroke.colour,
        _ => return None,
    };
    (fill != PAPER).then_some(fill)
}

impl Grid {
    fn shade_of(&self, fill: &str, opacity: f64) -> char {
        if opacity < 1.0 {
            return THIN_SHADE;
        }
        if self.many_fills {
            let shade = (lightness(fill) * RAMP.len() as f64) as usize;
            return RAMP[shade.min(RAMP.len() - 1)];
        }
        self.fills.iter().zip(SHADES).find(|(known, _)| *known == fill).map_or(' ', |(_, s)| s)
    }

    fn draw(&mut self, element: &Element) {
        match element {
            Element::Rect { frame: Frame { left, top, width, height }, fill, opacity } => {
                let (right, bottom) = (left + width, top + height);
                let corners = [(*left, *top), (right, *top), (right, bottom), (*left, bottom)];
                self.area(&corners, fill, *opacity);
            }
            Element::Polygon { outline, fill, opacity } => self.area(outline, fill, *opacity),
            Element::Border(frame) => self.border(*frame),
            Element::Line { from, to, stroke } => {
                let length = f64::hypot(to.0 - from.0, to.1 - from.1);
                if stroke.colour != GRID && length >= MIN_LINE_PX {
                    self.line(&[*from, *to], stroke);
                }
            }
            Element::Path { pieces, stroke } => {
                pieces.iter().for_each(|piece| self.line(piece, stroke));
            }
            Element::Dot { at, .. } => {
                if let Some(cell) = self.at(at.0, at.1) {
                    cell.text = Some('•');
                }
            }
            Element::Text { .. } | Element::Sense(..) | Element::Entry(_) => {}
        }
    }

    fn at(&mut self, x: f64, y: f64) -> Option<&mut Cell> {
        let [column, row] = [x / self.cell[0], y / self.cell[1]];
        let is_inside = column >= 0.0 && row >= 0.0;
        let row = self.rows.get_mut(row as usize).filter(|_| is_inside)?;
        row.get_mut(column as usize)
    }

    /// Characters whose middle lies inside (even-odd rule).
    fn area(&mut self, outline: &[(f64, f64)], fill: &str, opacity: f64) {
        let shade = self.shade_of(fill, opacity);
        for (index, row) in self.rows.iter_mut().enumerate() {
            let y = (index as f64 + 0.5) * self.cell[1];
            let edges = outline.iter().zip(outline.iter().cycle().skip(1));
            let mut ends: Vec<f64> = edges
                .filter(|(a, b)| (a.1 <= y) != (b.1 <= y))
                .map(|(a, b)| a.0 + (b.0 - a.0) * (y - a.1) / (b.1 - a.1))
                .collect();
            ends.sort_by(f64::total_cmp);
            for inside in ends.chunks_exact(2) {
                let column = |x: f64| (x / self.cell[0] - 0.5).ceil().max(0.0) as usize;
                let to = column(inside[1]).min(COLUMNS);
                for cell in row.get_mut(column(inside[0])..to).unwrap_or_default() {
                    cell.shade = Some(shade);
                    fill.clone_into(&mut cell.shade_colour);
                }
            }
        }
    }

    /// The left and the lower side of a frame.
    fn border(&mut self, frame: Frame) {
        let [wide, high] = self.cell;
        let right = frame.right();
        // A row above the numbers of the ticks.
        let bottom = frame.bottom() + TO_NUMBERS_PX - high;
        let rows = ((bottom - frame.top) / high).floor() as usize;
        for row in 0..rows {
            if let Some(cell) = self.at(frame.left, bottom - (row + 1) as f64 * high) {
                cell.frame = Some('│');
            }
        }
        for column in 0..((right - frame.left) / wide).ceil() as usize {
            let corner = if column == 0 { '└' } else { '─' };
            if let Some(cell) = self.at(frame.left + column as f64 * wide, bottom) {
                cell.frame = Some(corner);
            }
        }
    }

    /// A line through points, with its dashes.
    fn line(&mut self, points: &[(f64, f64)], stroke: &OwnStroke) {
        let dashes: Vec<f64> =
            stroke.dashes.split(' ').filter_map(|length| length.parse().ok()).collect();
        let period: f64 = dashes.iter().sum();
        let is_broad = stroke.width > MAX_STROKE_PX;
        let shade = self.shade_of(&stroke.colour, 1.0);
        let mut along = 0.0;
        for ends in points.windows(2) {
            let [(x0, y0), (x1, y1)] = [ends[0], ends[1]];
            let length = f64::hypot(x1 - x0, y1 - y0);
            // Half a dot at a step.
            let steps = (4.0 * length / self.cell[0]).ceil().max(1.0);
            for step in 0..=steps as usize {
                let share = step as f64 / steps;
                let mut rest = if period > 0.0 { (along + share * length) % period } else { 0.0 };
                let mut gaps = dashes.iter().enumerate().skip_while(|(_, dash)| {
                    let is_behind = rest >= **dash;
                    rest -= if is_behind { **dash } else { 0.0 };
                    is_behind
                });
                if gaps.next().is_some_and(|(place, _)| place % 2 == 1) {
                    continue;
                }
                let (x, y) = (x0 + share * (x1 - x0), y0 + share * (y1 - y0));
                let dot = |at: f64, k: usize| {
                    ((at / self.cell[k]).fract() * DOTS[k] as f64) as usize % DOTS[k]
                };
                let bit = DOT_BITS[dot(x, 0)][dot(y, 1)];
                let Some(cell) = self.at(x, y) else { continue };
                if is_broad {
                    cell.shade = Some(shade);
                    stroke.colour.clone_into(&mut cell.shade_colour);
                } else {
                    cell.dots |= bit;
                    stroke.colour.clone_into(&mut cell.dots_colour);
                }
            }
            along += length;
        }
    }

    /// Text at its place; where other text stands there, behind it or a few rows off.
    fn write(&mut self, element: &Element) {
        let Element::Text { at, anchor, run, text, .. } = element else { return };
        let (x, y) = if let Run::Upright(level) = run { *level } else { *at };
        let text: Vec<char> = text.chars().take(COLUMNS).collect();
        let count = text.len();
        let column = (x / self.cell[0]).max(0.0) as usize;
        let start = match (anchor, run) {
            (Anchor::Start, _) | (_, Run::Upright(_)) => column,
            (Anchor::Middle, _) => column.saturating_sub(count / 2),
            (Anchor::End, _) => (column + 1).saturating_sub(count),
        };
        let start = start.min(COLUMNS - count);
        // From the foot of the letters to their middle.
        let row = ((y - 4.5) / self.cell[1]).floor() as isize;
        let moved = (1..=MAX_MOVED).flat_map(|by| [-by, by]);
        let places = std::iter::once((row, true)).chain(moved.map(|by| (row + by, false)));
        for (row, may_shift) in places {
            let Some(row) = usize::try_from(row).ok().and_then(|row| self.rows.get_mut(row)) else {
                continue;
            };
            let is_free = |from: usize| {
                let around = from.saturating_sub(1)..(from + count + 1).min(COLUMNS);
                row[around].iter().all(|cell| cell.text.is_none())
            };
            let last = if may_shift && *anchor == Anchor::Start { COLUMNS - count } else { start };
            let Some(from) = (start..=last).find(|&from| is_free(from)) else { continue };
            for (cell, letter) in row[from..].iter_mut().zip(&text) {
                cell.text = Some(*letter);
            }
            return;
        }
    }

    fn text(&self, colour: bool) -> String {
        let mut text = String::new();
        for row in &self.rows {
            let cells: Vec<(char, &str)> = row.iter().map(Cell::shown).collect();
            let end = cells.iter().rposition(|(shown, _)| *shown != ' ').map_or(0, |last| last + 1);
            for run in cells[..end].chunk_by(|a, b| a.1 == b.1) {
                let shown: String = run.iter().map(|(shown, _)| *shown).collect();
                text.push_str(&painted(run[0].1, &shown, colour));
            }
            text.push('\n');
        }
        let kept = text.trim_start_matches('\n').trim_end().to_owned();
        kept + "\n"
    }

    /// The entries of all legends, as many on a line as fit.
    fn legend(&self, elements: &[Element], colour: bool) -> String {
        let entries = elements.iter().filter_map(|element| match element {
            Element::Entry(parts) => Some(parts),
            _ => None,
        });
        let (mut lines, mut room) = (String::new(), 0);
        for parts in entries {
            let swatch = match parts.first() {
                Some(Element::Line { stroke, .. }) => {
                    let shown = if stroke.dashes.is_empty() { "⠒⠒⠒" } else { "⠒ ⠒" };
                    painted(&stroke.colour, shown, colour)
                }
                Some(Element::Rect { fill, opacity, .. }) => {
                    let shade = self.shade_of(fill, *opacity).to_string();
                    painted(fill, &shade.repeat(2), colour)
                }
                _ => "•".to_owned(),
            };
            let Some(Element::Text { text, .. }) = parts.get(1) else { continue };
            let needed = text.chars().count() + 8;
            if needed > room {
                let end = if lines.is_empty() { "" } else { "\n" };
                lines.push_str(&format!("{end}  "));
                room = COLUMNS - 2;
            }
            lines.push_str(&format!("{swatch} {text}   "));
            room = room.saturating_sub(needed);
        }
        let lines: Vec<&str> = lines.lines().map(str::trim_end).collect();
        if lines.is_empty() { String::new() } else { lines.join("\n") + "\n" }
    }
}

/// Red, green and blue of `#rrggbb`.
fn rgb(colour: &str) -> Option<[u8; 3]> {
    let digits = colour.strip_prefix('#').filter(|digits| digits.len() == 6)?;
    let part = |k: usize| u8::from_str_radix(digits.get(2 * k..2 * k + 2)?, 16).ok();
    Some([part(0)?, part(1)?, part(2)?])
}

/// From 0 (black) to 1 (white).
fn lightness(colour: &str) -> f64 {
    let [r, g, b] = rgb(colour).unwrap_or_default().map(f64::from);
    (0.299 * r + 0.587 * g + 0.114 * b) / 255.0
}

/// In its colour, but for that of text, which is the terminal's own.
fn painted(colour: &str, text: &str, coloured: bool) -> String {
    match rgb(colour).filter(|_| coloured && colour != INK && colour != "#000000") {
        Some([r, g, b]) => style::paint(&format!("38;2;{r};{g};{b}"), text, true),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::canvas::{Face, Stroke};
    use super::super::{Axis, Panel, Scale};
    use super::*;

    #[test]
    fn lines_areas_and_text_stand_where_they_are() {
        let mut canvas = Canvas::new(1000.0, 400.0);
        let frame = Frame { left: 100.0, top: 40.0, width: 800.0, height: 280.0 };
        let axis = |name: &str| Axis::new(name, Scale::linear(0.0, 1.0));
        let panel = Panel { frame, x: axis("share"), y: axis("speed [rpm]") };
        let stroke = Stroke { colour: INK, width: 2.0, dashes: "" };
        panel.curve(&mut canvas, &[(0.1, 0.1), (1.0, 1.0)], stroke);
        let lower = [(0.5, 0.0), (1.0, 0.0), (1.0, 0.25), (0.5, 0.25)];
        panel.area(&mut canvas, lower.into_iter(), "#d4d7dc", 1.0);
        panel.axes(&mut canvas, true);
        canvas.border(frame);
        canvas.text((300.0, 100.0), Anchor::Start, Face::Plain, "one");
        canvas.text((300.0, 100.0), Anchor::Start, Face::Plain, "two");
        let text = canvas.characters(false);
        let lines: Vec<Vec<char>> = text.lines().map(|line| line.chars().collect()).collect();
        assert!(lines.iter().all(|line| line.len() <= COLUMNS), "{text}");
        let is_braille = |c: &char| ('\u{2801}'..='\u{28ff}').contains(c);
        // The diagonal falls from the upper right to the lower left.
        let columns: Vec<usize> =
            lines.iter().filter_map(|line| line.iter().position(is_braille)).collect();
        assert!(columns.len() >= 12, "{text}");
        assert!(columns.windows(2).all(|pair| pair[1] < pair[0]), "{text}");
        assert!(columns[0] >= 82 && columns[columns.len() - 1] <= 20, "{columns:?}");
        // A quarter of the height of half the width.
        let shaded = lines.iter().flatten().filter(|c| **c == '▒').count();
        assert!((120..=170).contains(&shaded), "{shaded}\n{text}");
        assert!(text.contains("one two"), "{text}");
        for told in ["speed [rpm]", "share", "0.2", "0└──"] {
            assert!(text.contains(told), "{told}\n{text}");
        }
    }

    #[test]
    fn dashes_are_kept_and_colours_only_where_asked_for() {
        let mut canvas = Canvas::new(1000.0, 40.0);
        let stroke = Stroke { colour: "#0072b2", width: 2.0, dashes: "100 100" };
        canvas.line((0.0, 10.0), (1000.0, 10.0), stroke);
        let plain = canvas.characters(false);
        let dashes: Vec<&str> = plain.split_whitespace().collect();
        assert_eq!(dashes.len(), 5, "{plain}");
        assert!(dashes.iter().all(|dash| dash.chars().count().abs_diff(10) <= 1), "{plain}");
        assert!(!plain.contains('\x1b'));
        assert!(canvas.characters(true).contains("\x1b[38;2;0;114;178m"));
    }
}
