//! What a schedule is worked out from.

use crate::advice::options::{FeedRule, Objective};
use crate::advice::ranges::Counting;
use crate::advice::vibration::TipModel;
use crate::excitation::ExcitationLine;
use crate::job::{Job, Operation};
use crate::path::{Path, Survey};

/// What a schedule is worked out from.
#[derive(Debug, Clone, Copy)]
pub(in crate::advice) struct Task<'a> {
    pub(in crate::advice) job: &'a Job,
    pub(in crate::advice) operation: &'a Operation,
    pub(in crate::advice) path: &'a Path<'a>,
    pub(in crate::advice) survey: &'a Survey,
    pub(in crate::advice) counting: &'a Counting<'a>,
    pub(in crate::advice) lines: &'a [ExcitationLine],
    pub(in crate::advice) programmed_rpm: f64,
    pub(in crate::advice) objective: Objective,
    /// The best constant speed that is safe, rev/min.
    pub(in crate::advice) constant_rpm: Option<f64>,
    pub(in crate::advice) feed: FeedRule,
    pub(in crate::advice) tip: Option<&'a TipModel>,
}

impl Task<'_> {
    /// The objective that can be followed, and the speed to stay near to.
    pub(in crate::advice) fn goal(&self) -> (Objective, f64) {
        match self.objective {
            Objective::Nearest => (Objective::Nearest, self.programmed_rpm),
            Objective::Margin => (Objective::Margin, self.programmed_rpm),
            Objective::Highest => (Objective::Highest, self.job.spindle.max_rpm),
            Objective::Vibration | Objective::Depth => {
                (Objective::Nearest, self.constant_rpm.unwrap_or(self.programmed_rpm))
            }
        }
    }
}

/// Mean over time of a speed that is linear between places.
pub(in crate::advice) fn mean(s: &[f64], rpm: &[f64]) -> f64 {
    (1..s.len()).map(|i| 0.5 * (rpm[i] + rpm[i - 1]) * (s[i] - s[i - 1])).sum()
}
