//! Where a line stands against a mode at one point of the path.

use std::path::Path;

use super::spindle_profile::SpindleProfile;
use super::verdict::Certainty;
use crate::excitation::ExcitationLine;
use crate::job::Policy;
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
    pub(super) policy: &'a Policy,
    /// What the lines of its moves refer to.
    pub(super) file: &'a Path,
}

impl LineBands<'_> {
    /// f_exc at `s`, Hz; zero where the spindle stands still.
    pub(super) fn excitation_hz(&self, s: f64) -> f64 {
        self.line.frequency_hz(self.spindle.rpm_at(s))
    }

    /// Certainty of the crossing with mode `r` at a station; `None` where there is none.
    pub(super) fn state(&self, station: &Station, r: usize) -> Option<Certainty> {
        let policy = self.policy;
        let excitation = self.excitation_hz(station.s);
        let natural = station.frequencies_hz[r];
        let apart = (excitation - natural).abs();
        let is_faint = || station.tip_m_per_n.get(r).is_some_and(|&tip| policy.is_faint(tip));
        if excitation == 0.0 {
            // Nothing excites the arm, however wide the bands.
            None
        } else if apart >= natural * policy.wide() * INSIDE
            || policy.ignores(excitation)
            || is_faint()
        {
            None
        } else if apart < natural * policy.separation * INSIDE {
            Some(Certainty::Certain)
        } else {
            Some(Certainty::Uncertain)
        }
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
        let reach = self.policy.wide() + 0.1;
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
            let passage = if changes { self.policy.wide() / line_rate } else { 1.0 };
            let end = END_TOLERANCE.min(END_OF_PASSAGE * passage);
            return width > end.max(PASSAGE_TOLERANCE);
        }
        let ratio_left = excitation_left / left.frequencies_hz[r];
        let ratio_right = excitation_right / right.frequencies_hz[r];
        let (low, high) = (ratio_left.min(ratio_right), ratio_left.max(ratio_right));
        let edges = [
            1.0 - self.policy.wide(),
            1.0 - self.policy.separation,
            1.0 + self.policy.separation,
            1.0 + self.policy.wide(),
        ];
        if changes && edges.iter().any(|&edge| low < edge && edge < high) {
            return width > PASSAGE_TOLERANCE;
        }
        if width <= CONTACT_TOLERANCE {
            return false;
        }
        // A function with slopes within ± L stays within L h / 2 of the mean of its ends
        // (Piyavskii).
        let reach = 0.5 * (rate + line_rate) * width * high;
        let mean = 0.5 * (ratio_left + ratio_right);
        edges.iter().any(|&edge| {
            (edge > high && edge < mean + reach) || (edge < low && edge > mean - reach)
        })
    }
}
