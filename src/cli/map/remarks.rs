//! What a map tells on standard error.

use super::stream::Passed;
use crate::free_vibration::{Doubt, DoubtReason, Measurement};
use crate::map::{OutsideLimits, Row};
use crate::model::{JointKind, Robot};
use crate::report::{number, trimmed};
use crate::units::{deg_from_rad, mm_from_m};
use crate::wording::printable;

/// What is told once at the end rather than pose by pose.
#[derive(Default)]
pub(super) struct Remarks {
    pub(super) poses: usize,
    outside_limits: OutsideLimits,
    doubtful: usize,
    first_doubtful: Option<String>,
    folded: usize,
    first_folded: Option<String>,
    unresolved: usize,
}

impl From<Passed> for Remarks {
    fn from(passed: Passed) -> Self {
        let Passed { poses, outside_limits } = passed;
        Self { poses, outside_limits, ..Self::default() }
    }
}

impl Remarks {
    pub(super) fn note(&mut self, robot: &Robot, rows: &[Row]) {
        self.poses += rows.len();
        for row in rows {
            self.outside_limits.look_at(robot, &row.joints);
            let Some(nonlinear) = &row.nonlinear else { continue };
            self.doubtful += nonlinear.doubts.len();
            if let (None, Some(doubt)) = (&self.first_doubtful, nonlinear.doubts.first()) {
                self.first_doubtful = Some(doubtful(doubt, nonlinear));
            }
            self.folded += nonlinear.folded.len();
            if let (None, Some(folded)) = (&self.first_folded, nonlinear.folded.first()) {
                self.first_folded = Some(format!(
                    "mode {} at {} Hz would show at {} Hz",
                    folded.mode + 1,
                    number(folded.frequency_hz, 2),
                    number(folded.seen_at_hz, 2)
                ));
            }
            let blank = row.frequencies_hz.iter().filter(|f| f.is_none()).count();
            self.unresolved += blank - nonlinear.folded.len();
        }
    }

    pub(super) fn tell(self, robot: &Robot, notices: &mut Vec<String>) {
        let all = self.poses;
        if all == 0 {
            notices.push("the table holds no poses".to_owned());
        }
        if let Some((joint, value)) = self.outside_limits.first {
            let (count, first) = (self.outside_limits.poses, at(robot, joint, value));
            notices.push(format!(
                "{count} of {all} poses lie outside the joint limits (the first: {first})"
            ));
        }
        if let Some(first) = self.first_doubtful {
            notices.push(format!(
                "{} frequencies may be no modes' but harmonics or combination tones of a large \
                 vibration (the first: {first}); lower --amplitude-deg",
                self.doubtful
            ));
        }
        if let Some(first) = self.first_folded {
            notices.push(format!(
                "{} frequencies lie above half the sample rate and are left blank ({first}); \
                 raise --sample-rate-hz",
                self.folded
            ));
        }
        if self.unresolved > 0 {
            notices.push(format!(
                "{} frequencies are blank, as two modes lie too close for the record to part \
                 them; lengthen --duration-s",
                self.unresolved
            ));
        }
    }
}

/// `joint_2 at -300°, allowed -90 to 120°`.
fn at(robot: &Robot, joint: usize, value: f64) -> String {
    let joint = &robot.joints()[joint];
    let slides = joint.kind == JointKind::Prismatic;
    let shown = |value: f64| {
        let value = if slides { mm_from_m(value) } else { deg_from_rad(value) };
        trimmed(value, 1)
    };
    let unit = if slides { " mm" } else { "°" };
    let allowed = joint.limit.map_or(String::new(), |[lower, upper]| {
        format!(", allowed {} to {}{unit}", shown(lower), shown(upper))
    });
    format!("{} at {}{unit}{allowed}", printable(&joint.name), shown(value))
}

/// `mode 2 at 167.35 Hz, linear 84.18 Hz: far off`.
fn doubtful(doubt: &Doubt, found: &Measurement) -> String {
    let why = match doubt.reason {
        DoubtReason::FarFromLinear => "far off",
        DoubtReason::NearerToAnotherMode => "nearer to another mode's",
        DoubtReason::RivalPeak => "another peak is about as high",
    };
    let frequency = found.frequencies_hz[doubt.mode]
        .map_or(String::new(), |hz| format!(" at {} Hz", number(hz, 2)));
    let linear = number(found.linear_hz[doubt.mode], 2);
    format!("mode {}{frequency}, linear {linear} Hz: {why}", doubt.mode + 1)
}
