//! Colours that most colour-blind readers can distinguish.

/// Text, frames and what matters most.
pub(in crate::report) const INK: &str = "#222222";

/// What is there but does not matter.
pub(in crate::report) const GREY: &str = "#999999";

/// What is allowed.
pub(in crate::report) const SAFE: &str = "#009e73";

/// The lines of a grid.
pub(super) const GRID: &str = "#dddddd";

/// Okabe & Ito (2008); black last.
const CURVES: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

/// Patterns of dashes: curves beyond the colours take the next one, so that no two look the same.
const DASHES: [&str; 5] = ["", "9 4", "2 4", "9 4 2 4", "14 4 2 4 2 4"];

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
