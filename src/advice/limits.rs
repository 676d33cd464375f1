//! Limits of the policy on the tool tip at the speeds that the bands leave.

use super::choice::settle;
use super::outcome::Remedy;
use super::speeds::{SafeSet, SpeedProblem, feed_at};
use super::{FeedRule, Speeds};
use crate::job::{Job, Operation, SpindleSpeed};
use crate::notes::Note;
use crate::path::Path;
use crate::risk::{Rules, exceeded_at_speed, limits_at_speed};

/// Speeds that are tried over the safe ones, and in each stretch of them at least.
const TRIED: usize = 48;
const MIN_TRIED: usize = 3;

/// An operation whose cut is held against the limits.
pub(super) struct Limits<'a> {
    pub(super) job: &'a Job,
    pub(super) operation: &'a Operation,
    pub(super) path: &'a Path<'a>,
    pub(super) rules: &'a Rules<'a>,
    pub(super) stations: Vec<f64>,
    pub(super) programmed_rpm: f64,
    pub(super) feed: FeedRule,
}

impl Limits<'_> {
    /// What they say of what is to be run; nothing where no speed is safe.
    ///
    /// # Errors
    /// The arm has no modes somewhere.
    pub(super) fn of(&self, remedy: &Remedy) -> Result<Vec<Note>, Note> {
        let (speed, feed_m_per_s) = match remedy {
            Remedy::Constant(one) => (SpindleSpeed::Constant(one.rpm), one.feed_m_per_s),
            Remedy::Scheduled(plan) => {
                (SpindleSpeed::Schedule(plan.points.clone()), plan.feed_m_per_s)
            }
            Remedy::Kept(kept) => (SpindleSpeed::Schedule(kept.points.clone()), kept.feed_m_per_s),
            Remedy::Infeasible => return Ok(Vec::new()),
        };
        self.at(speed, feed_m_per_s)
    }

    /// The safe speed nearest to `rpm` at which none is exceeded, or `rpm` where there is none.
    ///
    /// # Errors
    /// As above.
    pub(super) fn kept_near(
        &self,
        rpm: f64,
        problem: &SpeedProblem,
        set: &SafeSet,
    ) -> Result<f64, Note> {
        let Some(worst) = self.exceeded(rpm, &self.stations)? else { return Ok(rpm) };
        // Where one speed exceeds a limit others do, too: one place is looked at before the path.
        let mut worst = [worst];
        let range: f64 = set.safe.iter().map(|gap| gap.high_rpm - gap.low_rpm).sum();
        let tried = |gap: &Speeds| {
            let width = gap.high_rpm - gap.low_rpm;
            let share = if range > 0.0 { width / range } else { 1.0 };
            let count = ((TRIED as f64 * share).ceil() as usize).max(MIN_TRIED);
            let at = |i: usize| gap.low_rpm + width * i as f64 / count as f64;
            (0..=count).filter_map(|i| settle(problem, *gap, at(i).round())).collect::<Vec<_>>()
        };
        let mut speeds: Vec<f64> = set.safe.iter().flat_map(tried).collect();
        speeds.sort_by(|a, b| (a - rpm).abs().total_cmp(&(b - rpm).abs()));
        speeds.dedup();
        for speed in speeds {
            if self.exceeded(speed, &worst)?.is_some() {
                continue;
            }
            match self.exceeded(speed, &self.stations)? {
                Some(s) => worst = [s],
                None => return Ok(speed),
            }
        }
        Ok(rpm)
    }

    /// Where, of `stations`, a constant speed surely exceeds a limit most.
    fn exceeded(&self, rpm: f64, stations: &[f64]) -> Result<Option<f64>, Note> {
        let feed_m_per_s = match self.feed {
            FeedRule::ChipLoad => feed_at(self.operation.feed_m_per_s, self.programmed_rpm, rpm),
            FeedRule::Programmed => self.operation.feed_m_per_s,
        };
        let speed = (SpindleSpeed::Constant(rpm), self.ratio(feed_m_per_s));
        exceeded_at_speed(self.job, self.operation, self.path, (self.rules, stations), speed)
    }

    fn at(&self, speed: SpindleSpeed, feed_m_per_s: f64) -> Result<Vec<Note>, Note> {
        let speed = (speed, self.ratio(feed_m_per_s));
        let looked = (self.rules, &self.stations[..]);
        limits_at_speed(self.job, self.operation, self.path, looked, speed)
    }

    fn ratio(&self, feed_m_per_s: f64) -> f64 {
        feed_m_per_s / self.operation.feed_m_per_s
    }
}
