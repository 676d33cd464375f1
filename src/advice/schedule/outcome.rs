//! A schedule, and why there is none.

use schemars::JsonSchema;
use serde::Serialize;

use super::exposures::{Exposure, Passage};
use super::quadratic_program::SolverEnd;
use crate::advice::options::Objective;
use crate::advice::speeds::{Constant, Speeds};
use crate::units::written;

/// How a schedule came about, and what it crosses.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ScheduleFacts")]
pub struct Schedule {
    /// (s, rev/min), from s = 0 to 1; linear between.
    #[serde(skip)]
    pub points: Vec<(f64, f64)>,
    /// Lowest and highest speed, rev/min.
    #[serde(skip)]
    pub range_rpm: Speeds,
    /// The feed that belongs to it, m/s.
    #[serde(skip)]
    pub feed_m_per_s: f64,
    /// Time from s = 0 to s = 1 at the recommended feed.
    pub duration_s: f64,
    /// What became of the feed. `mean_chip_load`: it keeps the mean chip load. Otherwise it stays
    /// as programmed: `asked` for; the program has feeds of its own (`own_feeds`); its rapid moves
    /// (`rapids`) or turns on the spot (`stands_still`) take the same time at any feed; a slower
    /// one would prolong the crossing of a band (`crosses`); the duration did not settle
    /// (`not_settled`).
    #[serde(rename = "feed")]
    pub coupling: Coupling,
    /// How often it was solved until the duration settled; null where the feed stays.
    pub feed_rounds: Option<usize>,
    /// Lowest and highest chip load along the path, in percent of the programmed one.
    #[serde(rename = "chip_load_percent", serialize_with = "written::percent")]
    pub chip_load_ratios: [f64; 2],
    /// The acceleration that is kept, and whether the job gives none, so that it is assumed.
    pub acceleration_rpm_per_s: f64,
    /// Whether it is [`Spindle::ASSUMED_ACCELERATION_RPM_PER_S`](crate::job::Spindle).
    #[serde(rename = "acceleration_is_assumed")]
    #[schemars(description = "")]
    pub is_acceleration_assumed: bool,
    /// The objective that it follows: what was asked for, but `nearest` where vibration was, or
    /// where a band is crossed and margin was.
    pub follows: Objective,
    /// The speed that it stays near to.
    pub target_rpm: f64,
    /// Half width of the bands that it keeps out of, in percent of each frequency: the policy's and
    /// the model's, or the widest that leave a way where it follows the margin.
    #[serde(rename = "half_width_percent", serialize_with = "written::percent")]
    pub half_width: f64,
    // Σ w (n/n_p − n*/n_p)² + ρ Σ Δ(n/n_p)²/Δs with the target n*.
    /// What was minimised: mean square of the distance from target_rpm as a share of the programmed
    /// speed, plus 1e-3 times the mean square of the speed's slope over s.
    pub objective: f64,
    /// The duration for which it was minimised: where a band is crossed it is duration_s within
    /// 0.01 %, so the acceleration is used to the full.
    pub solved_for_s: f64,
    /// Ways between the bands for which it was minimised.
    pub corridors_tried: usize,
    /// How the solver ended for the one that was chosen.
    pub solver: SolverEnd,
    /// The least |f_exc − f_r| / f_r at the stations of the last look; `None` where nothing counts.
    #[serde(skip)]
    pub separation: Option<f64>,
    /// Where bands are crossed because they must be; empty where the schedule keeps out of all of
    /// them.
    pub exposures: Vec<Exposure>,
    /// The exposures, one for each time that a line goes through a mode's band.
    pub passages: Vec<Passage>,
    /// Time inside any band, s; where bands overlap it counts once.
    #[serde(skip)]
    pub exposed_s: f64,
}

impl Schedule {
    /// Whether all of it is this constant speed, but for what a solver leaves.
    pub(in crate::advice) fn is_constant(&self, rpm: f64) -> bool {
        self.points.iter().all(|point| (point.1 - rpm).abs() < 0.01)
    }

    /// Whether it follows the margin and keeps no more of it than this constant speed does.
    pub(in crate::advice) fn gains_nothing_on(&self, constant: &Constant) -> bool {
        let keeps = |margin: Option<f64>| margin.unwrap_or(f64::INFINITY);
        self.follows == Objective::Margin && keeps(constant.separation) >= keeps(self.separation)
    }
}

/// A programmed schedule that a check calls clear.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptSchedule {
    /// (s, rev/min), as programmed.
    pub points: Vec<(f64, f64)>,
    /// The programmed feed, m/s.
    pub feed_m_per_s: f64,
    /// The least |f_exc − f_r| / f_r at the stations of the last look; `None` where nothing counts.
    pub separation: Option<f64>,
}

/// Why there is no schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoSchedule {
    /// The path takes no time.
    NoTime,
    /// Nothing within the spindle's range and acceleration keeps out of the bands, or crosses them
    /// from one gap to another.
    NoWay,
    /// There are ways between the bands, but the solver found no speed along any; how it ended on
    /// the last.
    Solver(SolverEnd),
    /// A check of what was solved met bands again and again.
    Contact,
}

/// What became of the feed under a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub enum Coupling {
    /// It keeps the mean chip load.
    MeanChipLoad,
    /// It stays as programmed because that was asked for.
    Asked,
    /// It stays as programmed because the program has feeds of its own.
    OwnFeeds,
    /// It stays as programmed because the time of the program's rapid moves does not depend on it.
    Rapids,
    /// It stays as programmed because the time of turns on the spot does not depend on it.
    StandsStill,
    /// It stays as programmed because a band is crossed, and with the mean chip load kept the feed
    /// would be slower: a spindle that may not be asked too much at the programmed feed would then
    /// cross slower than it can.
    Crosses,
    /// It stays as programmed because the duration did not settle.
    NotSettled,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schedule(points: &[(f64, f64)]) -> Schedule {
        Schedule {
            points: points.to_vec(),
            range_rpm: Speeds { low_rpm: 900.0, high_rpm: 1100.0 },
            chip_load_ratios: [1.0, 1.0],
            feed_m_per_s: 0.01,
            duration_s: 10.0,
            coupling: Coupling::Asked,
            feed_rounds: None,
            acceleration_rpm_per_s: 500.0,
            is_acceleration_assumed: false,
            follows: Objective::Nearest,
            target_rpm: 1000.0,
            half_width: 0.1,
            objective: 0.0,
            solved_for_s: 10.0,
            corridors_tried: 1,
            solver: SolverEnd::Solved,
            separation: Some(0.12),
            exposures: Vec::new(),
            passages: Vec::new(),
            exposed_s: 0.0,
        }
    }

    #[test]
    fn a_hundredth_of_a_rev_per_minute_is_what_a_solver_leaves() {
        let near = schedule(&[(0.0, 1000.0), (0.4, 1000.0099), (1.0, 999.9901)]);
        assert!(near.is_constant(1000.0));
        for off in [1000.0101, 999.9899] {
            assert!(!schedule(&[(0.0, 1000.0), (0.4, off), (1.0, 1000.0)]).is_constant(1000.0));
        }
        // One speed throughout, but another one.
        assert!(!schedule(&[(0.0, 1000.5), (1.0, 1000.5)]).is_constant(1000.0));
    }

    #[test]
    fn a_schedule_for_the_margin_must_beat_the_constant_speed() {
        let of = |separation| Constant {
            rpm: 1000.0,
            feed_m_per_s: 0.01,
            separation,
            is_programmed: false,
        };
        let plan = Schedule { follows: Objective::Margin, ..schedule(&[(0.0, 9.0), (1.0, 8.0)]) };
        assert!(plan.gains_nothing_on(&of(Some(0.12))) && plan.gains_nothing_on(&of(None)));
        assert!(!plan.gains_nothing_on(&of(Some(0.1199))));
        let nearest = Schedule { follows: Objective::Nearest, ..plan };
        assert!(!nearest.gains_nothing_on(&of(Some(0.13))));
    }
}
