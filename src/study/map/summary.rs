//! What is said once about a map rather than pose by pose.

use crate::free_vibration::{Doubt, DoubtReason, Folded, Measurement};
use crate::map::{Block, OutsideLimits};
use crate::model::{LimitViolation, Robot};
use crate::notes::{Code, Note, Place};

/// What went by.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Summary {
    /// How many poses.
    pub poses: usize,
    /// Those outside the joint limits.
    pub outside_limits: OutsideLimits,
    /// Peaks of a nonlinear map that may not be the mode.
    pub doubtful: usize,
    /// Modes above half the sampling rate.
    pub folded: usize,
    /// Modes too close to another to be resolved by the record.
    pub unresolved: usize,
    first_doubtful: Option<String>,
    first_folded: Option<Folded>,
}

impl Summary {
    pub(super) fn add(&mut self, block: &Block, outside_limits: OutsideLimits) {
        self.poses += block.count;
        self.outside_limits.add(outside_limits);
        for found in &block.nonlinear {
            self.doubtful += found.doubts.len();
            if let (None, Some(doubt)) = (&self.first_doubtful, found.doubts.first()) {
                self.first_doubtful = Some(described(doubt, found));
            }
            self.folded += found.folded.len();
            self.first_folded = self.first_folded.or(found.folded.first().copied());
            let blank = found.frequencies_hz.iter().filter(|f| f.is_none()).count();
            self.unresolved += blank - found.folded.len();
        }
    }

    /// Warnings about the map of `robot`.
    pub fn warnings(&self, robot: &Robot) -> Vec<Note> {
        let mut warnings = Vec::new();
        let mut warn =
            |code, what: String| warnings.push(Note::warning(code, Place::default(), what));
        if self.poses == 0 {
            warn(Code::NothingChecked, "the table holds no poses".to_owned());
        }
        if let Some((index, value)) = self.outside_limits.first
            && let Some(joint) = robot.joints().get(index)
            && let Some(limit) = joint.limit
        {
            let what = format!(
                "{} of {} poses lie outside the joint limits (the first: {})",
                self.outside_limits.poses,
                self.poses,
                LimitViolation { joint, value, limit }
            );
            warn(Code::OutsideLimits, what);
        }
        if let Some(first) = &self.first_doubtful {
            let what = format!(
                "{} may not be of modes but of harmonics or combination tones of a large vibration \
                 (the first: {first}); lower the amplitude (--amplitude-deg)",
                frequencies(self.doubtful)
            );
            warn(Code::Doubtful, what);
        }
        if let Some(Folded { mode, frequency_hz, seen_at_hz }) = self.first_folded {
            let what = format!(
                "{} left blank: above half the sample rate (mode {} at {frequency_hz:.2} Hz would \
                 appear at {seen_at_hz:.2} Hz); raise the rate (--sample-rate-hz)",
                frequencies(self.folded),
                mode + 1
            );
            warn(Code::Folded, what);
        }
        if self.unresolved > 0 {
            let what = format!(
                "{} left blank: modes too close for the record to resolve; lengthen it (--duration-s)",
                frequencies(self.unresolved)
            );
            warn(Code::Doubtful, what);
        }
        warnings
    }
}

/// `mode 2 at 167.35 Hz, linear 84.18 Hz: far off`.
fn described(doubt: &Doubt, found: &Measurement) -> String {
    let why = match doubt.reason {
        DoubtReason::FarFromLinear => "far off",
        DoubtReason::NearerToAnotherMode => "nearer to another mode",
        DoubtReason::RivalPeak => "another peak has a similar amplitude",
    };
    let frequency =
        found.frequencies_hz[doubt.mode].map_or(String::new(), |hz| format!(" at {hz:.2} Hz"));
    let linear = found.linear_hz[doubt.mode];
    format!("mode {}{frequency}, linear {linear:.2} Hz: {why}", doubt.mode + 1)
}

/// `1 frequency`, `2 frequencies`.
fn frequencies(count: usize) -> String {
    if count == 1 { "1 frequency".to_owned() } else { format!("{count} frequencies") }
}
