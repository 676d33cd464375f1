//! What is said once about a map rather than pose by pose.

use crate::free_vibration::{Aliased, Doubt, DoubtReason, Measurement};
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
    pub aliased: usize,
    /// Modes too close to another to be resolved by the record.
    pub unresolved: usize,
    first_doubtful: Option<String>,
    first_aliased: Option<Aliased>,
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
            self.aliased += found.aliased.len();
            self.first_aliased = self.first_aliased.or(found.aliased.first().copied());
            let blank = found.frequencies_hz.iter().filter(|f| f.is_none()).count();
            self.unresolved += blank - found.aliased.len();
        }
    }

    /// The first pose outside the joint limits, in words.
    pub(super) fn first_outside(&self, robot: &Robot) -> Option<String> {
        first_outside(robot, self.outside_limits)
    }

    /// Warnings about the map of `robot`.
    pub fn warnings(&self, robot: &Robot) -> Vec<Note> {
        let outside = outside_warning(robot, self.outside_limits, self.poses);
        let mut warnings: Vec<Note> = outside.into_iter().collect();
        // `key` is what of the request to change.
        let mut warn = |code, key, what: String| {
            warnings.push(Note::warning(code, Place { key, ..Place::default() }, what));
        };
        if self.poses == 0 {
            warn(
                Code::NothingChecked,
                "",
                "there are no poses in the table, or in this part of the map".to_owned(),
            );
        }
        if let Some(first) = &self.first_doubtful {
            let what = format!(
                "{} may not be of modes but of harmonics or combination tones of a large vibration \
                 (the first: {first}); lower the amplitude",
                frequencies(self.doubtful)
            );
            warn(Code::Doubtful, "amplitude-deg", what);
        }
        if let Some(Aliased { mode, frequency_hz, seen_at_hz }) = self.first_aliased {
            let what = format!(
                "{} left blank: above half the sampling rate (mode {} at {frequency_hz:.2} Hz \
                 would appear at {seen_at_hz:.2} Hz); raise the sampling rate",
                frequencies(self.aliased),
                mode + 1
            );
            warn(Code::Folded, "sample-rate-hz", what);
        }
        if self.unresolved > 0 {
            let what = format!(
                "{} left blank: the record is too short to resolve close modes; lengthen the \
                 record",
                frequencies(self.unresolved)
            );
            warn(Code::Doubtful, "duration-s", what);
        }
        warnings
    }
}

fn first_outside(robot: &Robot, outside: OutsideLimits) -> Option<String> {
    let (index, value) = outside.first?;
    let joint = robot.joints().get(index)?;
    Some(LimitViolation { joint, value, limit: joint.limit? }.to_string())
}

/// A warning where some of the poses lie outside the joint limits.
pub fn outside_warning(robot: &Robot, outside: OutsideLimits, poses: usize) -> Option<Note> {
    let first = first_outside(robot, outside)?;
    let what = outside_limits(outside.poses, poses, &first);
    Some(Note::warning(Code::OutsideLimits, Place::default(), what))
}

/// Some of the poses lie outside the joint limits.
pub(super) fn outside_limits(outside: usize, poses: usize, first: &str) -> String {
    format!("{outside} of {poses} poses lie outside the joint limits (the first: {first})")
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
