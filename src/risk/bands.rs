//! Where a line stands against a mode at one point of the path.

use std::path::Path;

use super::certainty::Certainty;
use super::rules::Rules;
use super::spindle_profile::SpindleProfile;

use crate::excitation::ExcitationLine;
use crate::path::Station;

/// Ends of crossings are found to within this share of the path, and of what it takes a line that
/// changes fast to pass a band.
const END_TOLERANCE: f64 = 1e-8;
const END_OF_PASSAGE: f64 = 1e-4;

/// Beyond what [`crate::path::grid`] guarantees, bands are searched for hidden contact down to
/// cells of this share of the path.
const CONTACT_TOLERANCE: f64 = 1e-6;

/// A line that lies on one side of an edge at one station and on the other at the next has passed
/// it: that is looked into down to cells of this share of the path, however fast the spindle
/// changes.
const PASSAGE_TOLERANCE: f64 = 1e-13;

/// A line on the very edge of a band is outside; nearer to it than rounding, it counts as on the
/// edge. Else a mode that the path does not change would flicker in and out from pose to pose.
const INSIDE: f64 = 1.0 - 1e-12;

/// One line of one operation against the bands of a policy.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineBands<'a> {
    pub(super) line: ExcitationLine,
    pub(super) spindle: &'a SpindleProfile<'a>,
    pub(super) rules: &'a Rules<'a>,
    /// [`Rules::bounds`].
    bounds: ([f64; 2], f64),
    /// What the lines of its moves refer to.
    pub(super) file: &'a Path,
}

impl<'a> LineBands<'a> {
    pub(super) fn new(
        line: ExcitationLine,
        spindle: &'a SpindleProfile<'a>,
        rules: &'a Rules<'a>,
        file: &'a Path,
    ) -> Self {
        Self { line, spindle, rules, bounds: rules.bounds(), file }
    }

    /// f_exc at `s`, Hz; zero where the spindle stands still.
    pub(super) fn excitation_hz(&self, s: f64) -> f64 {
        self.line.frequency_hz(self.spindle.rpm_at(s))
    }

    /// Certainty of the crossing with mode `r` at a station; `None` where there is none.
    pub(super) fn state(&self, station: &Station, r: usize) -> Option<Certainty> {
        let rules = self.rules;
        let excitation = self.excitation_hz(station.s);
        let natural = station.frequencies_hz[r];
        if self.is_beyond(excitation / natural) {
            return None;
        }
        let apart = excitation - natural;
        let [low, _, _, high] =
            rules.edges(station.s, r).map(|edge| natural * (edge - 1.0) * INSIDE);
        let is_faint = || station.tip_m_per_n.get(r).is_some_and(|&tip| rules.is_faint(tip));
        if excitation == 0.0 {
            // Nothing excites the arm, however wide the bands.
            None
        } else if apart <= low || apart >= high || rules.policy.ignores(excitation) || is_faint() {
            None
        } else if apart.abs() < natural * rules.policy.separation * INSIDE {
            Some(Certainty::Certain)
        } else {
            Some(Certainty::Uncertain)
        }
    }

    /// Whether a line of this ratio to a frequency lies outside the bands of any mode.
    fn is_beyond(&self, ratio: f64) -> bool {
        // Room for rounding.
        const CLEAR: f64 = 1e-9;
        let ([low, high], _) = self.bounds;
        ratio < low * (1.0 - CLEAR) || ratio > high * (1.0 + CLEAR)
    }

    /// Whether no edge of any band comes within reach in a cell with these ratios at its ends, as
    /// [`Self::needs_halving`] asks edge by edge.
    fn stays_away(&self, ratios: [f64; 2], slope: f64, width: f64) -> bool {
        let ([low, high], steepest) = self.bounds;
        if low <= 0.0 || !ratios.iter().all(|ratio| self.is_beyond(*ratio)) {
            return false;
        }
        let (least, most) = (ratios[0].min(ratios[1]), ratios[0].max(ratios[1]));
        let reach = 0.5 * (slope + steepest) * width * most / low;
        (least > high && least / high - reach >= 1.0) || (most < low && most / low + reach <= 1.0)
    }

    /// Where the state changes that differs between two neighbouring stations.
    pub(super) fn edge(&self, from_s: f64, to_s: f64) -> f64 {
        self.spindle.jump_in(from_s, to_s).unwrap_or(0.5 * (from_s + to_s))
    }

    /// Whether the line ever comes near the frequencies between `lowest_hz` and `highest_hz`, which
    /// a first look found: most harmonics of a fast spindle never do.
    pub(super) fn can_meet(&self, lowest_hz: f64, highest_hz: f64) -> bool {
        let [low, high] = self.spindle.speed.range_rpm().map(|rpm| self.line.frequency_hz(rpm));
        // A tenth more for what a first look may have missed between its stations.
        let reach = self.rules.widest() + 0.1;
        high > lowest_hz * (1.0 - reach) && low < highest_hz * (1.0 + reach)
    }

    /// Whether the cell between two stations must be looked into: an end of a crossing lies in it
    /// that is not yet located, or the edge of a band is within reach. `rate` bounds |d ln f_r /
    /// ds| in the cell.
    pub(super) fn needs_halving(
        &self,
        left: &Station,
        right: &Station,
        r: usize,
        rate: f64,
    ) -> bool {
        let width = right.s - left.s;
        let (excitation_left, excitation_right) =
            (self.excitation_hz(left.s), self.excitation_hz(right.s));
        let line_rate = if excitation_left == excitation_right {
            0.0
        } else {
            (excitation_right - excitation_left).abs()
                / (excitation_left.min(excitation_right).max(f64::MIN_POSITIVE) * width)
        };
        // Where the spindle stops or starts there is a jump, and nothing between its ends.
        let changes = line_rate > 0.0 && excitation_left.min(excitation_right) > 0.0;
        if self.state(left, r) != self.state(right, r) {
            let passage = if changes { self.rules.half_width() / line_rate } else { 1.0 };
            let end = END_TOLERANCE.min(END_OF_PASSAGE * passage);
            return width > end.max(PASSAGE_TOLERANCE);
        }
        let ratio_left = excitation_left / left.frequencies_hz[r];
        let ratio_right = excitation_right / right.frequencies_hz[r];
        if self.stays_away([ratio_left, ratio_right], rate + line_rate, width) {
            return false;
        }
        let [edges_left, edges_right] = [left, right].map(|station| self.rules.edges(station.s, r));
        // Where the line lies against each edge that it can reach: 1 on it.
        let mut against = edges_left
            .into_iter()
            .zip(edges_right)
            .filter(|(left, right)| *left > 0.0 && *right > 0.0)
            .map(|(left, right)| [ratio_left / left, ratio_right / right]);
        if changes && against.clone().any(|[a, b]| a.min(b) < 1.0 && a.max(b) > 1.0) {
            return width > PASSAGE_TOLERANCE;
        }
        if width <= CONTACT_TOLERANCE {
            return false;
        }
        // A function with slopes within ± L stays within L h / 2 of the mean of its ends
        // (Piyavskii).
        let slope = rate + line_rate + self.rules.edge_rate(left.s, right.s, r);
        against.any(|[a, b]| {
            let (low, high, mean) = (a.min(b), a.max(b), 0.5 * (a + b));
            let reach = 0.5 * slope * width * high;
            (high < 1.0 && mean + reach > 1.0) || (low > 1.0 && mean - reach < 1.0)
        })
    }
}
