//! The elements of a drawing, and the drawing as SVG.

use std::fmt::Write;

use super::palette::{INK, PAPER};
use crate::wording::printable;

/// A rectangle on the canvas, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report) struct Frame {
    pub(in crate::report) left: f64,
    pub(in crate::report) top: f64,
    pub(in crate::report) width: f64,
    pub(in crate::report) height: f64,
}

impl Frame {
    pub(in crate::report) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(in crate::report) fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report) struct Stroke<'a> {
    pub(in crate::report) colour: &'a str,
    pub(in crate::report) width: f64,
    /// Lengths of dashes and gaps, px; empty for a line without gaps.
    pub(in crate::report) dashes: &'a str,
}

/// Which way text runs from its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum Anchor {
    Start,
    Middle,
    End,
}

/// How text looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum Face {
    /// The head of a drawing.
    Title,
    /// The head of a panel.
    PanelTitle,
    /// Names of axes, numbers of ticks, legends.
    Plain,
    /// Labels within a panel.
    Small,
}

impl Face {
    /// Size of the letters, px.
    fn size(self) -> f64 {
        match self {
            Self::Title => 16.0,
            Self::PanelTitle => 14.0,
            Self::Plain => 13.0,
            Self::Small => 11.0,
        }
    }

    /// About how wide a text becomes, px: generous, as fonts differ.
    pub(super) fn width_of(self, text: &str) -> f64 {
        // Letters of the far east are square.
        let em = |c: char| if c < '\u{2e80}' { 0.6 } else { 1.0 };
        self.size() * text.chars().map(em).sum::<f64>()
    }

    /// As much of a text as fits into a width.
    pub(super) fn elided(self, text: &str, width: f64) -> String {
        let text = printable(text);
        if self.width_of(&text) <= width {
            return text;
        }
        let mut short = text;
        while !short.is_empty() && self.width_of(&short) + self.width_of("…") > width {
            short.pop();
        }
        short + "…"
    }
}

/// What stands on a canvas, px.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Element {
    Text {
        at: (f64, f64),
        anchor: Anchor,
        face: Face,
        run: Run,
        text: String,
    },
    Rect {
        frame: Frame,
        fill: String,
        opacity: f64,
    },
    Border(Frame),
    Line {
        from: (f64, f64),
        to: (f64, f64),
        stroke: OwnStroke,
    },
    /// Pieces of one line.
    Path {
        pieces: Vec<Vec<(f64, f64)>>,
        stroke: OwnStroke,
    },
    Polygon {
        outline: Vec<(f64, f64)>,
        fill: String,
        opacity: f64,
    },
    Dot {
        at: (f64, f64),
        radius: f64,
        fill: String,
    },
    /// An area that senses the pointer, with its attributes.
    Sense(Frame, String),
    /// An entry of a legend: its swatch and its text.
    Entry(Vec<Element>),
}

/// How text runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Run {
    Level,
    /// Upwards; where letters do not turn, level from this point.
    Upright((f64, f64)),
    /// Level, to be read over what is drawn.
    Over,
}

/// A stroke that keeps its colour.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OwnStroke {
    pub(super) colour: String,
    pub(super) width: f64,
    pub(super) dashes: String,
}

impl From<Stroke<'_>> for OwnStroke {
    fn from(stroke: Stroke<'_>) -> Self {
        let Stroke { colour, width, dashes } = stroke;
        Self { colour: colour.to_owned(), width, dashes: dashes.to_owned() }
    }
}

/// A drawing, as SVG or with characters.
#[derive(Debug, Clone, PartialEq)]
pub struct Canvas {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) elements: Vec<Element>,
}

impl Canvas {
    pub(in crate::report) fn new(width: f64, height: f64) -> Self {
        Self { width, height, elements: Vec::new() }
    }

    /// Adds an element, unless a coordinate of it is not finite.
    fn put(&mut self, coordinates: &[f64], element: Element) {
        if coordinates.iter().all(|at| at.is_finite()) {
            self.elements.push(element);
        }
    }

    pub(in crate::report) fn text(
        &mut self,
        at: (f64, f64),
        anchor: Anchor,
        face: Face,
        text: &str,
    ) {
        self.put_text(at, anchor, face, Run::Level, text);
    }

    /// Text that runs upwards; where letters do not turn, level from `level`.
    pub(super) fn upright_text(&mut self, at: (f64, f64), level: (f64, f64), text: &str) {
        self.put_text(at, Anchor::Middle, Face::Plain, Run::Upright(level), text);
    }

    /// Small text that can be read over what is drawn.
    pub(super) fn text_over(&mut self, at: (f64, f64), anchor: Anchor, text: &str) {
        self.put_text(at, anchor, Face::Small, Run::Over, text);
    }

    fn put_text(&mut self, at: (f64, f64), anchor: Anchor, face: Face, run: Run, text: &str) {
        let element = Element::Text { at, anchor, face, run, text: printable(text) };
        self.put(&[at.0, at.1], element);
    }

    /// A filled rectangle.
    pub(in crate::report) fn rect(&mut self, frame: Frame, fill: &str, opacity: f64) {
        let Frame { left, top, width, height } = frame;
        let element = Element::Rect { frame, fill: fill.to_owned(), opacity };
        self.put(&[left, top, width, height], element);
    }

    /// The outline of a rectangle.
    pub(in crate::report) fn border(&mut self, frame: Frame) {
        let Frame { left, top, width, height } = frame;
        self.put(&[left, top, width, height], Element::Border(frame));
    }

    /// A straight line.
    pub(in crate::report) fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        let element = Element::Line { from, to, stroke: stroke.into() };
        self.put(&[from.0, from.1, to.0, to.1], element);
    }

    /// A line through points; it breaks where one is missing or not finite.
    pub(super) fn polyline(
        &mut self,
        points: impl Iterator<Item = Option<(f64, f64)>>,
        stroke: Stroke,
    ) {
        let points: Vec<Option<(f64, f64)>> =
            points.map(|point| point.filter(|(x, y)| x.is_finite() && y.is_finite())).collect();
        let runs = points.split(Option::is_none).filter(|run| !run.is_empty());
        let pieces: Vec<Vec<(f64, f64)>> =
            runs.map(|run| run.iter().copied().flatten().collect()).collect();
        if !pieces.is_empty() {
            self.put(&[], Element::Path { pieces, stroke: stroke.into() });
        }
    }

    /// The inside of an outline; points that are not finite are left out.
    pub(super) fn polygon(
        &mut self,
        outline: impl Iterator<Item = (f64, f64)>,
        fill: &str,
        opacity: f64,
    ) {
        let outline: Vec<(f64, f64)> =
            outline.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        if !outline.is_empty() {
            self.put(&[], Element::Polygon { outline, fill: fill.to_owned(), opacity });
        }
    }

    /// What the script of a page finds: an area that senses the pointer, with these attributes.
    pub(super) fn sense(&mut self, frame: Frame, attributes: &str) {
        let Frame { left, top, width, height } = frame;
        self.put(&[left, top, width, height], Element::Sense(frame, attributes.to_owned()));
    }

    /// Keeps what is drawn by `draw` together as an entry of a legend.
    pub(super) fn entry(&mut self, draw: impl FnOnce(&mut Self)) {
        let first = self.elements.len();
        draw(self);
        let parts = self.elements.split_off(first);
        self.elements.push(Element::Entry(parts));
    }

    /// A filled circle.
    pub(super) fn dot(&mut self, at: (f64, f64), radius: f64, fill: &str) {
        self.put(&[at.0, at.1, radius], Element::Dot { at, radius, fill: fill.to_owned() });
    }

    /// The whole document; it can stand in a page, too.
    pub fn svg(&self) -> String {
        let Self { width, height, elements } = self;
        let mut body = String::new();
        for element in elements {
            // Writing to a string does not fail.
            let _ = element.write(&mut body);
        }
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-size=\"{}\" \
             font-family=\"Helvetica, Arial, sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"{PAPER}\"/>\n{body}</svg>\n",
            Face::Plain.size()
        )
    }
}

impl Element {
    /// As an element of SVG, a line each.
    fn write(&self, out: &mut String) -> std::fmt::Result {
        match self {
            Self::Text { at: (x, y), anchor, face, run, text } => {
                let anchor = match anchor {
                    Anchor::Start => "start",
                    Anchor::Middle => "middle",
                    Anchor::End => "end",
                };
                let style = match face {
                    Face::Plain => String::new(),
                    Face::Small => format!(" font-size=\"{}\"", face.size()),
                    Face::Title | Face::PanelTitle => {
                        format!(" font-size=\"{}\" font-weight=\"bold\"", face.size())
                    }
                };
                let more = match run {
                    Run::Level => String::new(),
                    Run::Upright(_) => format!(" transform=\"rotate(-90 {x:.1} {y:.1})\""),
                    Run::Over => {
                        format!(" stroke=\"{PAPER}\" stroke-width=\"3\" paint-order=\"stroke\"")
                    }
                };
                let text = escaped(text);
                writeln!(
                    out,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{INK}\"\
                     {style}{more}>{text}</text>"
                )
            }
            Self::Rect { frame: Frame { left, top, width, height }, fill, opacity } => {
                let opacity = opacity_attribute(*opacity);
                writeln!(
                    out,
                    "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" \
                     height=\"{height:.2}\" fill=\"{fill}\"{opacity}/>"
                )
            }
            Self::Border(Frame { left, top, width, height }) => writeln!(
                out,
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" \
                 height=\"{height:.1}\" fill=\"none\" stroke=\"{INK}\"/>"
            ),
            Self::Line { from: (x1, y1), to: (x2, y2), stroke } => {
                let stroke = stroke.attributes();
                writeln!(
                    out,
                    "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" {stroke}/>"
                )
            }
            Self::Path { pieces, stroke } => {
                let path: String = pieces.iter().map(|piece| path_of(piece)).collect();
                let stroke = stroke.attributes();
                writeln!(
                    out,
                    "<path d=\"{path}\" fill=\"none\" {stroke} stroke-linejoin=\"round\"/>"
                )
            }
            Self::Polygon { outline, fill, opacity } => {
                let (path, opacity) = (path_of(outline), opacity_attribute(*opacity));
                writeln!(out, "<path d=\"{path}Z\" fill=\"{fill}\"{opacity}/>")
            }
            Self::Sense(Frame { left, top, width, height }, attributes) => writeln!(
                out,
                "<rect class=\"sense\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" \
                 height=\"{height:.1}\" fill=\"none\"{attributes}/>"
            ),
            Self::Entry(parts) => parts.iter().try_for_each(|part| part.write(out)),
            Self::Dot { at: (x, y), radius, fill } => {
                writeln!(
                    out,
                    "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{fill}\"/>"
                )
            }
        }
    }
}

impl OwnStroke {
    fn attributes(&self) -> String {
        let Self { colour, width, dashes } = self;
        let dashes = match dashes.as_str() {
            "" => String::new(),
            dashes => format!(" stroke-dasharray=\"{dashes}\""),
        };
        format!("stroke=\"{colour}\" stroke-width=\"{width}\"{dashes}")
    }
}

/// Move to the first point, lines to the others: how far from the last, as that is short. Places
/// are rounded to a tenth of a pixel before, so that errors do not add up.
fn path_of(points: &[(f64, f64)]) -> String {
    let rounded = points.iter().map(|(x, y)| [x, y].map(|at| (at * 10.0).round() as i64));
    let mut path = String::new();
    let mut last: Option<[i64; 2]> = None;
    for at in rounded {
        let step = match last {
            None => at,
            Some(from) => [at[0] - from[0], at[1] - from[1]],
        };
        if last.is_some() && step == [0, 0] {
            continue;
        }
        path.push(if last.is_none() { 'M' } else { 'l' });
        path.push_str(&tenths(step[0]));
        if step[1] >= 0 {
            path.push(' ');
        }
        path.push_str(&tenths(step[1]));
        last = Some(at);
    }
    path
}

/// A number of tenths, as short as can be: `-.3`, `12`, `4.5`.
fn tenths(value: i64) -> String {
    let (sign, size) = (if value < 0 { "-" } else { "" }, value.unsigned_abs());
    match (size / 10, size % 10) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, tenth) => format!("{sign}.{tenth}"),
        (whole, tenth) => format!("{sign}{whole}.{tenth}"),
    }
}

fn opacity_attribute(opacity: f64) -> String {
    if opacity < 1.0 { format!(" fill-opacity=\"{opacity}\"") } else { String::new() }
}

/// Text as XML and HTML hold it; control characters stay.
pub(in crate::report) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_short_enough() {
        assert_eq!(escaped("a<b & \"c\"\n"), "a&lt;b &amp; &quot;c&quot;\n");
        assert_eq!(Face::Small.elided("accelerometer", 50.0), "accele…");
        assert_eq!(Face::Small.elided("x", 50.0), "x");
    }

    #[test]
    fn what_is_not_finite_is_not_drawn() {
        let stroke = Stroke { colour: INK, width: 1.0, dashes: "" };
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut canvas = Canvas::new(10.0, 10.0);
            canvas.text((bad, 1.0), Anchor::Start, Face::Plain, "text");
            canvas.rect(Frame { left: 0.0, top: bad, width: 1.0, height: 1.0 }, INK, 1.0);
            canvas.border(Frame { left: 0.0, top: 0.0, width: bad, height: 1.0 });
            canvas.line((0.0, 0.0), (1.0, bad), stroke);
            canvas.dot((bad, bad), 1.0, INK);
            canvas.polyline([Some((bad, 1.0)), None].into_iter(), stroke);
            canvas.polygon([(1.0, bad)].into_iter(), INK, 0.5);
            assert_eq!(canvas.svg(), Canvas::new(10.0, 10.0).svg());
            let mut canvas = Canvas::new(10.0, 10.0);
            let points = [(0.0, 0.0), (1.0, bad), (2.0, 2.0)];
            canvas.polyline(points.into_iter().map(Some), stroke);
            assert!(canvas.svg().contains("d=\"M0 0M2 2\""));
        }
    }

    #[test]
    fn paths_lead_through_their_points() {
        let wave =
            (0..500).map(|i| f64::from(i) * 0.37).map(|x| (x, 40.0 + 35.0 * (x / 9.0).sin()));
        let wave: Vec<(f64, f64)> = wave.collect();
        let path = path_of(&wave);
        let mut at = [0.0, 0.0];
        let mut places = Vec::new();
        for step in path[1..].split('l') {
            // The sign of the second number may stand for the gap before it.
            let gap = 1 + step[1..].find([' ', '-']).unwrap();
            let [x, y] = [&step[..gap], step[gap..].trim()].map(|n| n.parse::<f64>().unwrap());
            at = [at[0] + x, at[1] + y];
            places.push((at[0], at[1]));
        }
        assert_eq!(places.len(), wave.len());
        for (a, b) in places.iter().zip(&wave) {
            assert!((a.0 - b.0).abs() < 0.051 && (a.1 - b.1).abs() < 0.051, "{a:?} {b:?}");
        }
    }
}
