//! The elements of an SVG drawing.

use std::fmt::{Arguments, Write};

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

impl Stroke<'_> {
    fn attributes(&self) -> String {
        let Self { colour, width, dashes } = self;
        let dashes = match *dashes {
            "" => String::new(),
            dashes => format!(" stroke-dasharray=\"{dashes}\""),
        };
        format!("stroke=\"{colour}\" stroke-width=\"{width}\"{dashes}")
    }
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

/// A drawing in the making.
#[derive(Debug)]
pub(in crate::report) struct Canvas {
    width: f64,
    height: f64,
    body: String,
}

impl Canvas {
    pub(in crate::report) fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// The whole document; it can stand in a page, too.
    pub(in crate::report) fn finish(self) -> String {
        let Self { width, height, body } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-size=\"{}\" \
             font-family=\"Helvetica, Arial, sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"{PAPER}\"/>\n{body}</svg>\n",
            Face::Plain.size()
        )
    }

    /// Adds an element, unless a coordinate of it is not finite.
    fn put(&mut self, coordinates: &[f64], element: Arguments) {
        if coordinates.iter().all(|at| at.is_finite()) {
            // Writing to a string does not fail.
            let _ = writeln!(self.body, "{element}");
        }
    }

    pub(in crate::report) fn text(
        &mut self,
        at: (f64, f64),
        anchor: Anchor,
        face: Face,
        text: &str,
    ) {
        self.text_with(at, anchor, face, "", text);
    }

    /// Text that runs upwards.
    pub(super) fn upright_text(&mut self, at: (f64, f64), text: &str) {
        let turned = format!(" transform=\"rotate(-90 {:.1} {:.1})\"", at.0, at.1);
        self.text_with(at, Anchor::Middle, Face::Plain, &turned, text);
    }

    /// Small text that can be read over what is drawn.
    pub(super) fn text_over(&mut self, at: (f64, f64), anchor: Anchor, text: &str) {
        let halo = format!(" stroke=\"{PAPER}\" stroke-width=\"3\" paint-order=\"stroke\"");
        self.text_with(at, anchor, Face::Small, &halo, text);
    }

    fn text_with(&mut self, at: (f64, f64), anchor: Anchor, face: Face, more: &str, text: &str) {
        let (x, y) = at;
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
        let text = escaped(&printable(text));
        self.put(
            &[x, y],
            format_args!(
                "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{INK}\"\
                 {style}{more}>{text}</text>"
            ),
        );
    }

    /// A filled rectangle.
    pub(in crate::report) fn rect(&mut self, frame: Frame, fill: &str, opacity: f64) {
        let Frame { left, top, width, height } = frame;
        let opacity = opacity_attribute(opacity);
        self.put(
            &[left, top, width, height],
            format_args!(
                "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" \
                 fill=\"{fill}\"{opacity}/>"
            ),
        );
    }

    /// The outline of a rectangle.
    pub(in crate::report) fn border(&mut self, frame: Frame) {
        let Frame { left, top, width, height } = frame;
        self.put(
            &[left, top, width, height],
            format_args!(
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
                 fill=\"none\" stroke=\"{INK}\"/>"
            ),
        );
    }

    /// A straight line.
    pub(in crate::report) fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke) {
        let ((x1, y1), (x2, y2)) = (from, to);
        let stroke = stroke.attributes();
        self.put(
            &[x1, y1, x2, y2],
            format_args!(
                "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" {stroke}/>"
            ),
        );
    }

    /// A line through points; it breaks where one is missing or not finite.
    pub(super) fn polyline(
        &mut self,
        points: impl Iterator<Item = Option<(f64, f64)>>,
        stroke: Stroke,
    ) {
        let mut path = String::new();
        let mut is_down = false;
        for point in points {
            let point = point.filter(|(x, y)| x.is_finite() && y.is_finite());
            if let Some((x, y)) = point {
                let command = if is_down { 'L' } else { 'M' };
                let _ = write!(path, "{command}{x:.2} {y:.2}");
            }
            is_down = point.is_some();
        }
        if !path.is_empty() {
            let stroke = stroke.attributes();
            self.put(
                &[],
                format_args!(
                    "<path d=\"{path}\" fill=\"none\" {stroke} stroke-linejoin=\"round\"/>"
                ),
            );
        }
    }

    /// The inside of an outline; points that are not finite are left out.
    pub(super) fn polygon(
        &mut self,
        outline: impl Iterator<Item = (f64, f64)>,
        fill: &str,
        opacity: f64,
    ) {
        let mut path = String::new();
        for (x, y) in outline.filter(|(x, y)| x.is_finite() && y.is_finite()) {
            let command = if path.is_empty() { 'M' } else { 'L' };
            let _ = write!(path, "{command}{x:.2} {y:.2}");
        }
        if !path.is_empty() {
            let opacity = opacity_attribute(opacity);
            self.put(&[], format_args!("<path d=\"{path}Z\" fill=\"{fill}\"{opacity}/>"));
        }
    }

    /// What the script of a page finds: an area that senses the pointer, with these attributes.
    pub(super) fn sense(&mut self, frame: Frame, attributes: &str) {
        let Frame { left, top, width, height } = frame;
        self.put(
            &[left, top, width, height],
            format_args!(
                "<rect class=\"sense\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" \
                 height=\"{height:.1}\" fill=\"none\"{attributes}/>"
            ),
        );
    }

    /// A filled circle.
    pub(super) fn dot(&mut self, at: (f64, f64), radius: f64, fill: &str) {
        let (x, y) = at;
        self.put(
            &[x, y, radius],
            format_args!("<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{fill}\"/>"),
        );
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
            assert_eq!(canvas.finish(), Canvas::new(10.0, 10.0).finish());
            let mut canvas = Canvas::new(10.0, 10.0);
            let points = [(0.0, 0.0), (1.0, bad), (2.0, 2.0)];
            canvas.polyline(points.into_iter().map(Some), stroke);
            assert!(canvas.finish().contains("d=\"M0.00 0.00M2.00 2.00\""));
        }
    }
}
