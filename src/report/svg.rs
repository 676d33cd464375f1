//! Drawing with axes in SVG: just enough for curves and heat maps. Text stays text; nothing depends on
//! fonts or scripts.

use std::fmt::Write;

use super::words::number;
use crate::wording::printable;

/// Okabe & Ito's colours, told apart by most colour-blind readers; black last.
const CURVES: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

/// Patterns of dashes: curves beyond the colours take the next one, so that no two look the same.
const DASHES: [&str; 5] = ["", "9 4", "2 4", "9 4 2 4", "14 4 2 4 2 4"];

/// Colour and dashes of the curve with this number, from 0.
pub(super) fn curve_style(index: usize) -> (&'static str, &'static str) {
    (CURVES[index % CURVES.len()], DASHES[index / CURVES.len() % DASHES.len()])
}

const INK: &str = "#222222";
const GRID: &str = "#dddddd";

/// A range of numbers along one side of a panel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) label: String,
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) is_logarithmic: bool,
}

impl Axis {
    /// Where a value lies, 0 at the low end and 1 at the high.
    pub(super) fn share(&self, value: f64) -> f64 {
        if self.is_logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// The inverse of [`Self::share`].
    pub(super) fn value(&self, share: f64) -> f64 {
        if self.is_logarithmic {
            self.low * (self.high / self.low).powf(share)
        } else {
            self.low + (self.high - self.low) * share
        }
    }

    /// Round numbers within the range, about `count` of them.
    pub(super) fn ticks(&self, count: usize) -> Vec<f64> {
        let slack = 1e-9 * (self.high - self.low);
        let is_within = |v: &f64| *v >= self.low - slack && *v <= self.high + slack;
        if self.is_logarithmic {
            let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
            let steps: &[f64] = match (self.high / self.low).log10() {
                d if d > 3.0 => &[1.0],
                d if d > 1.6 => &[1.0, 2.0, 5.0],
                _ => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
            };
            return decades
                .flat_map(|d| steps.iter().map(move |s| s * 10.0_f64.powi(d)))
                .filter(is_within)
                .collect();
        }
        let rough = (self.high - self.low) / count.max(1) as f64;
        let decade = 10.0_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .iter()
            .map(|s| s * decade)
            .find(|s| *s >= rough * 0.999)
            .unwrap_or(decade);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        (first..=last).map(|i| i as f64 * step).filter(is_within).collect()
    }
}

/// Where a panel lies on the sheet, in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// A panel with two axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Panel {
    pub(super) frame: Frame,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

impl Panel {
    pub(super) fn px(&self, x: f64) -> f64 {
        self.frame.left + self.frame.width * self.x.share(x)
    }

    pub(super) fn py(&self, y: f64) -> f64 {
        self.frame.top + self.frame.height * (1.0 - self.y.share(y))
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke<'a> {
    pub(super) colour: &'a str,
    pub(super) width: f64,
    /// Lengths of dashes and gaps, px; empty for a line without gaps.
    pub(super) dashes: &'a str,
}

/// Which way text runs from its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A sheet that is being drawn on.
#[derive(Debug)]
pub(super) struct Sheet {
    width: f64,
    height: f64,
    body: String,
}

impl Sheet {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// The whole document.
    pub(super) fn finish(self) -> String {
        let Self { width, height, body } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"Helvetica, Arial, sans-serif\" \
             font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{body}</svg>\n"
        )
    }

    fn put(&mut self, element: std::fmt::Arguments) {
        // Writing to a string does not fail.
        let _ = self.body.write_fmt(element);
        self.body.push('\n');
    }

    pub(super) fn text(&mut self, x: f64, y: f64, anchor: Anchor, style: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escaped(text);
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{INK}\" {style}>{text}</text>"
        ));
    }

    pub(super) fn rect(&mut self, frame: Frame, fill: &str) {
        let Frame { left, top, width, height } = frame;
        self.put(format_args!(
            "<rect x=\"{left:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{fill}\"/>"
        ));
    }

    /// Grid, ticks and labels; the frame itself is drawn by [`Self::border`], over the contents.
    pub(super) fn axes(&mut self, panel: &Panel, has_grid: bool) {
        let Frame { left, top, width, height } = panel.frame;
        let (right, bottom) = (left + width, top + height);
        for tick in panel.x.ticks((width / 80.0) as usize) {
            let x = panel.px(tick);
            if has_grid {
                self.line(x, top, x, bottom, GRID);
            }
            self.line(x, bottom, x, bottom + 5.0, INK);
            self.text(x, bottom + 19.0, Anchor::Middle, "", &label(tick));
        }
        for tick in panel.y.ticks((height / 50.0) as usize) {
            let y = panel.py(tick);
            if has_grid {
                self.line(left, y, right, y, GRID);
            }
            self.line(left - 5.0, y, left, y, INK);
            self.text(left - 8.0, y + 4.5, Anchor::End, "", &label(tick));
        }
        self.text(left + 0.5 * width, bottom + 39.0, Anchor::Middle, "", &panel.x.label);
        let (x, y) = (left - 50.0, top + 0.5 * height);
        let turned = format!("transform=\"rotate(-90 {x:.1} {y:.1})\"");
        self.text(x, y, Anchor::Middle, &turned, &panel.y.label);
    }

    pub(super) fn border(&mut self, frame: Frame) {
        let Frame { left, top, width, height } = frame;
        self.put(format_args!(
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
             fill=\"none\" stroke=\"{INK}\"/>"
        ));
    }

    pub(super) fn line(&mut self, x1: f64, y1: f64, x2: f64, y2: f64, colour: &str) {
        self.put(format_args!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{colour}\"/>"
        ));
    }

    /// A line through points in panel values; points outside the panel's height are left out, and break it.
    pub(super) fn curve(&mut self, panel: &Panel, points: &[(f64, f64)], stroke: Stroke) {
        let mut path = String::new();
        let mut is_down = false;
        for &(x, y) in points {
            let is_inside = (-1e-9..=1.0 + 1e-9).contains(&panel.y.share(y));
            if is_inside {
                let command = if is_down { 'L' } else { 'M' };
                let _ = write!(path, "{command}{:.2} {:.2}", panel.px(x), panel.py(y));
            }
            is_down = is_inside;
        }
        let Stroke { colour, width, dashes } = stroke;
        let dashes = match dashes {
            "" => String::new(),
            dashes => format!(" stroke-dasharray=\"{dashes}\""),
        };
        self.put(format_args!(
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             stroke-linejoin=\"round\"{dashes}/>"
        ));
    }

    /// The inside of an outline in panel values, which must lie within the panel.
    pub(super) fn area(&mut self, panel: &Panel, outline: &[(f64, f64)], fill: &str, opacity: f64) {
        let mut path = String::new();
        for (i, &(x, y)) in outline.iter().enumerate() {
            let command = if i == 0 { 'M' } else { 'L' };
            let _ = write!(path, "{command}{:.2} {:.2}", panel.px(x), panel.py(y));
        }
        self.put(format_args!(
            "<path d=\"{path}Z\" fill=\"{fill}\" fill-opacity=\"{opacity}\" stroke=\"none\"/>"
        ));
    }

    pub(super) fn dot(&mut self, panel: &Panel, x: f64, y: f64, radius: f64, fill: &str) {
        if (-1e-9..=1.0 + 1e-9).contains(&panel.y.share(y)) {
            let (x, y) = (panel.px(x), panel.py(y));
            self.put(format_args!(
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{fill}\"/>"
            ));
        }
    }
}

/// A colour for 0..=1, dark to light, even in lightness: seven of the colours of matplotlib's "magma" with
/// straight lines between.
pub(super) fn heat(share: f64) -> String {
    const STOPS: [[f64; 3]; 7] = [
        [0.0, 0.0, 4.0],
        [43.0, 17.0, 94.0],
        [114.0, 31.0, 129.0],
        [182.0, 54.0, 121.0],
        [241.0, 96.0, 93.0],
        [254.0, 175.0, 119.0],
        [252.0, 253.0, 191.0],
    ];
    let at = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let below = (at.floor() as usize).min(STOPS.len() - 2);
    let part = at - below as f64;
    let [r, g, b] = [0, 1, 2]
        .map(|c| (STOPS[below][c] + part * (STOPS[below + 1][c] - STOPS[below][c])).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A tick's number without needless digits.
pub(super) fn label(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e7).contains(&value.abs()) {
        return number(value, 0).replace('-', "−");
    }
    let rounded = format!("{value:.6}");
    let short = rounded.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.replace('-', "−") }
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in printable(text).chars() {
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
    fn ticks_are_round_and_within() {
        let axis =
            |low, high, is_logarithmic| Axis { label: String::new(), low, high, is_logarithmic };
        assert_eq!(axis(-1.3, 2.2, false).ticks(4), [-1.0, 0.0, 1.0, 2.0]);
        assert_eq!(axis(0.0, 100.0, false).ticks(5), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(axis(20.0, 900.0, true).ticks(5), [20.0, 50.0, 100.0, 200.0, 500.0]);
    }

    #[test]
    fn share_and_value_are_inverse() {
        for is_logarithmic in [false, true] {
            let axis = Axis { label: String::new(), low: 3.0, high: 700.0, is_logarithmic };
            for share in [0.0, 0.2, 0.9, 1.0] {
                assert!((axis.share(axis.value(share)) - share).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn curves_beyond_the_colours_differ_in_their_dashes() {
        let mut seen = std::collections::HashSet::new();
        assert!((0..35).all(|index| seen.insert(curve_style(index))));
        assert_eq!(curve_style(0), ("#0072b2", ""));
    }

    #[test]
    fn labels_and_text_are_fit_to_print() {
        assert_eq!(label(-0.0), "0");
        assert_eq!(label(0.30000000000000004), "0.3");
        assert_eq!(label(-20.0), "−20");
        assert_eq!(escaped("a<b & \"c\"\u{1}"), "a&lt;b &amp; &quot;c&quot;\\u{1}");
        assert_eq!([label(2e300), label(-1e-9)], ["2.00e300", "−1.00e−9"]);
    }
}
