//! Colours that most colour-blind readers can distinguish.

/// Text, frames and what matters most.
pub(in crate::report) const INK: &str = "#222222";

/// What is there but does not matter.
pub(in crate::report) const GREY: &str = "#999999";

/// What is allowed.
pub(in crate::report) const SAFE: &str = "#009e73";

/// What is closed.
pub(in crate::report) const CLOSED: &str = "#d4d7dc";

/// Where a line lies in a band, and where it may.
pub(in crate::report) const CERTAIN: &str = "#f2a3a0";
pub(in crate::report) const POSSIBLE: &str = "#f6dd9b";

/// What all is drawn on.
pub(super) const PAPER: &str = "#ffffff";

/// The lines of a grid.
pub(super) const GRID: &str = "#dddddd";

/// Okabe & Ito (2008); black last.
const CURVES: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

/// Patterns of dashes: curves beyond the colours take the next one, so that no two look the same.
const DASHES: [&str; 5] = ["", "9 4", "2 4", "9 4 2 4", "14 4 2 4 2 4"];

/// What stands for each colour on a dark page.
const DARK: [(&str, &str); 15] = [
    (INK, "#e6e8eb"),
    (GREY, "#8b929c"),
    (GRID, "#343a43"),
    (PAPER, "#14171b"),
    (CLOSED, "#454b55"),
    (CERTAIN, "#8a2f2b"),
    (POSSIBLE, "#6e581a"),
    ("#0072b2", "#58aee8"),
    ("#d55e00", "#ff8b3d"),
    ("#009e73", "#2fc79b"),
    ("#cc79a7", "#e6a3c8"),
    ("#e69f00", "#f5b83d"),
    ("#56b4e9", "#9ad4f5"),
    ("#000000", "#ffffff"),
    ("#888888", "#9aa0a6"),
];

/// Rules of CSS by which drawings that stand in a page take the colours of a dark one.
pub(in crate::report) fn dark_rules() -> String {
    let rules = DARK.iter().flat_map(|(light, dark)| {
        ["fill", "stroke"].map(|of| format!("svg [{of}=\"{light}\"] {{ {of}: {dark}; }}\n"))
    });
    rules.collect()
}

/// Colour and dashes of the curve with this number, from 0.
pub(in crate::report) fn curve_style(index: usize) -> (&'static str, &'static str) {
    (CURVES[index % CURVES.len()], DASHES[index / CURVES.len() % DASHES.len()])
}

/// A colour for 0..=1, dark to light, even in lightness: seven of the colours of matplotlib's
/// "magma" with straight lines between.
pub(in crate::report) fn heat(share: f64) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_beyond_the_colours_differ_in_their_dashes() {
        let mut seen = std::collections::HashSet::new();
        assert!((0..35).all(|index| seen.insert(curve_style(index))));
        assert_eq!(curve_style(0), ("#0072b2", ""));
    }
}
