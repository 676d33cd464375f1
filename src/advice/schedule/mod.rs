//! A spindle speed that varies along the path: between the moving bands where it can, across them where it
//! must.
//!
//! # What is sought
//! The schedule follows the objective as far as that is a convex problem: near the programmed speed, or near the
//! spindle's highest; for the largest margin, the widest bands that leave a way are found by bisection, and the
//! way between them that is nearest to the programmed speed. How much the tool tip vibrates is no convex
//! function of the speed: there the schedule stays near the quietest safe constant speed, if there is one.
//!
//! # Time
//! A schedule is a speed over s, and s runs in proportion to time at the operation's one feed. So the feed is
//! coupled to the speed by its mean: it is scaled so that the mean chip load stays what it was, which
//! changes the duration, and with it how much the spindle can change between two places. See [`pace`]. The
//! acceleration limit is kept at the programmed feed, too, so that an override between the two breaks nothing.
//! Where the duration does not follow the feed alone (programs with feeds of their own, turns on the
//! spot), and where it is asked for, the feed stays as programmed.
//!
//! # Crossings
//! A band that must be crossed is crossed on one straight line at full acceleration, from the edge of one corridor
//! to the edge of the next; both ends are points of the schedule, however close together.

mod air;
mod cells;
mod exposures;
mod pace;
mod programme;
mod routes;
mod search;

pub use exposures::{Exposure, Passage};
pub use programme::SolverEnd;

pub(super) use air::is_air;

use self::air::air_sides;
use self::cells::{Cells, sides};
use self::exposures::{exposed_share, exposures, passages};
use self::pace::{Next, Pace};
use self::routes::Limits;
use self::search::best;
use super::ranges::Counting;
use super::speeds::{Speeds, feed_at};
use super::vibration::TipModel;
use super::{FeedRule, KeptSchedule, Objective};
use crate::excitation::ExcitationLine;
use crate::job::{Job, Operation, SpindleSpeed};
use crate::notes::Note;
use crate::path::{Path, Survey, grid};
use crate::progress::silent;
use crate::risk::{Crossing, crossings_under, detail};

/// Taken where the job gives no acceleration of the spindle: an assumption, not a figure of any spindle.
pub const ASSUMED_ACCELERATION_RPM_PER_S: f64 = 500.0;

/// No spindle is faster than from rest to its highest speed within a microsecond or so; more would be lost in digits.
const FASTEST_RPM_PER_S: f64 = 1e9;

/// Of the acceleration this much is used, so that rounding does not exceed it.
const USED_ACCELERATION: f64 = 0.999;

/// Bulges of bands between stations are taken so many times as large as stations show them; more, if a
/// check finds contact.
const SLACK: f64 = 1.5;
const MORE_SLACK: f64 = 4.0;

/// How often there is more.
const MOST_SLACKS: usize = 6;

/// Points nearer than this to the straight line between their neighbours are left out, rev/min.
const STRAIGHT_RPM: f64 = 1e-6;

/// Speeds of a schedule are told to so many parts of a rev/min where the acceleration is not felt in that.
const PARTS_PER_RPM: f64 = 1e6;

/// A speed that varies along the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// (s, rev/min), from s = 0 to 1; linear between.
    pub points: Vec<(f64, f64)>,
    /// The feed that belongs to it, m/s.
    pub feed_m_per_s: f64,
    /// Time from s = 0 to s = 1 at that feed, s.
    pub duration_s: f64,
    /// What became of the feed.
    pub coupling: Coupling,
    /// The acceleration that is kept, rev/min per second.
    pub acceleration_rpm_per_s: f64,
    /// Whether the job gives none, so that it is [`ASSUMED_ACCELERATION_RPM_PER_S`].
    pub is_acceleration_assumed: bool,
    /// What it follows: the objective asked for, but nearest where that cannot be followed.
    pub follows: Objective,
    /// The speed that it stays near to, rev/min.
    pub target_rpm: f64,
    /// Half width of the bands that it keeps out of, as a share of each frequency: the policy's, or the widest that
    /// leave a way where it follows the margin.
    pub half_width: f64,
    /// Σ w (n/n_p − n*/n_p)² + ρ Σ Δ(n/n_p)²/Δs with the target n*: what was minimised.
    pub objective: f64,
    /// The duration for which it was minimised, s; no longer than [`Self::duration_s`].
    pub solved_for_s: f64,
    /// Ways between the bands for which the programme was solved.
    pub corridors_tried: usize,
    /// How the solver ended for the one that was chosen.
    pub solver: SolverEnd,
    /// The least |f_exc − f_r| / f_r at the stations of the last look; `None` where nothing counts.
    pub separation: Option<f64>,
    /// Where bands are crossed because they must be.
    pub exposures: Vec<Exposure>,
}

impl Schedule {
    /// Lowest and highest speed, rev/min.
    pub fn range_rpm(&self) -> Speeds {
        let (low_rpm, high_rpm) = self
            .points
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), p| (low.min(p.1), high.max(p.1)));
        Speeds { low_rpm, high_rpm }
    }

    /// Time inside any band, s; where bands overlap it counts once.
    pub fn exposed_s(&self) -> f64 {
        exposed_share(&self.exposures) * self.duration_s
    }

    /// The exposures, put together into one passage for each time that a line goes through a mode's band.
    pub fn passages(&self) -> Vec<Passage> {
        passages(&self.exposures)
    }

    /// Whether all of it is this constant speed, but for what a solver leaves.
    pub(super) fn is_constant(&self, rpm: f64) -> bool {
        /// rev/min.
        const NOISE: f64 = 0.01;
        self.points.iter().all(|point| (point.1 - rpm).abs() < NOISE)
    }

    /// Whether it follows the margin and keeps no more of it than this constant speed does.
    pub(super) fn gains_nothing_on(&self, constant: &super::Constant) -> bool {
        let keeps = |margin: Option<f64>| margin.unwrap_or(f64::INFINITY);
        self.follows == Objective::Margin && keeps(constant.separation) >= keeps(self.separation)
    }

    /// Lowest and highest chip load along the path, as a share of the programmed one.
    pub fn chip_load_ratios(&self, operation: &super::OperationAdvice) -> (f64, f64) {
        let feed = self.feed_m_per_s / operation.programmed_feed_m_per_s;
        let Speeds { low_rpm, high_rpm } = self.range_rpm();
        (feed * operation.programmed_rpm / high_rpm, feed * operation.programmed_rpm / low_rpm)
    }
}

/// Why there is no schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoSchedule {
    /// The path takes no time.
    NoTime,
    /// Nothing within the spindle's range and acceleration keeps out of the bands, or crosses them from one gap
    /// to another.
    NoWay,
    /// There are ways between the bands, but the solver found no speed along any; how it ended on the last.
    Solver(SolverEnd),
    /// A check of what was solved met bands again and again.
    Contact,
}

/// What became of the feed under a schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// It keeps the mean chip load; solved so often until the duration settled.
    MeanChipLoad {
        /// How often.
        rounds: usize,
    },
    /// It stays as programmed because that was asked for.
    Asked,
    /// It stays as programmed because the program has feeds of its own.
    OwnFeeds,
    /// It stays as programmed because the program's rapid moves take their time whatever the feed.
    Rapids,
    /// It stays as programmed because turns on the spot take their time whatever the feed.
    StandsStill,
    /// It stays as programmed because a band is crossed, and with the mean chip load kept the feed would be slower:
    /// a spindle that may not be asked too much at the programmed feed would then cross slower than it can.
    Crosses,
    /// It stays as programmed because the duration did not settle.
    NotSettled,
}

/// What a schedule is worked out from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task<'a> {
    pub(super) job: &'a Job,
    pub(super) operation: &'a Operation,
    pub(super) path: &'a Path<'a>,
    pub(super) survey: &'a Survey,
    pub(super) counting: &'a Counting<'a>,
    pub(super) lines: &'a [ExcitationLine],
    pub(super) programmed_rpm: f64,
    pub(super) objective: Objective,
    /// The best constant speed that is safe, rev/min.
    pub(super) constant_rpm: Option<f64>,
    pub(super) feed: FeedRule,
    pub(super) tip: Option<&'a TipModel>,
}

impl Task<'_> {
    /// The objective that can be followed, and the speed to stay near to.
    fn goal(&self) -> (Objective, f64) {
        match self.objective {
            Objective::Nearest => (Objective::Nearest, self.programmed_rpm),
            Objective::Margin => (Objective::Margin, self.programmed_rpm),
            Objective::Highest => (Objective::Highest, self.job.spindle.max_rpm),
            Objective::Vibration => {
                (Objective::Nearest, self.constant_rpm.unwrap_or(self.programmed_rpm))
            }
        }
    }
}

/// The schedule that follows the objective best and keeps out of all bands or, where none does, crosses as
/// few as it must where it hurts least.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn schedule(task: &Task) -> Result<Result<Schedule, NoSchedule>, Note> {
    let Task { job, operation, path, .. } = *task;
    let programmed_s = path.duration_s();
    if programmed_s <= 0.0 {
        return Ok(Err(NoSchedule::NoTime));
    }
    let given = job.spindle.max_acceleration_rpm_per_s;
    let acceleration_rpm_per_s =
        given.unwrap_or(ASSUMED_ACCELERATION_RPM_PER_S).min(FASTEST_RPM_PER_S);
    let (follows, target_rpm) = task.goal();
    let sides = sides(&air_sides(task));
    let look = |slack| Cells::look(path, sides.clone(), task.survey, task.counting, slack);
    let (mut slack, mut slacks) = (SLACK, 1);
    let mut cells = look(slack)?;
    let mut pace = Pace::new(programmed_s, coupling(task));
    loop {
        let limits = Limits {
            programmed_rpm: task.programmed_rpm,
            target_rpm,
            slope_rpm: USED_ACCELERATION * acceleration_rpm_per_s * pace.solve_for_s(),
            min_rpm: job.spindle.min_rpm,
            max_rpm: job.spindle.max_rpm,
        };
        let best = match best(task, &cells, follows, &limits)? {
            Ok(best) => best,
            Err(why) => return Ok(Err(why)),
        };
        let mean_rpm = mean(&best.s, &best.rpm);
        let own_feed_m_per_s = feed_at(operation.feed_m_per_s, task.programmed_rpm, mean_rpm);
        let own_s = programmed_s * operation.feed_m_per_s / own_feed_m_per_s;
        let coupling = match pace.step(own_s, !best.ramps.is_empty()) {
            Next::Again => continue,
            Next::Settled(coupling) => coupling,
        };
        let (feed_m_per_s, duration_s) = match coupling {
            Coupling::MeanChipLoad { .. } => (own_feed_m_per_s, own_s),
            _ => (operation.feed_m_per_s, programmed_s),
        };
        let speed = SpindleSpeed::Schedule(thinned(&best.s, &best.rpm, &limits));
        let stations = grid(path, speed.corners());
        let first_look = Survey::take(path, stations, detail(&job.policy), &silent)?;
        let (found, last_look) =
            crossings_under(task.lines, &job.policy, &speed, path, first_look)?;
        let is_told = |crossing: &Crossing| {
            best.ramps.iter().any(|&[from, to]| crossing.from_s < to && crossing.to_s > from)
        };
        if !found.iter().all(is_told) {
            if slacks == MOST_SLACKS {
                return Ok(Err(NoSchedule::Contact));
            }
            (slack, slacks) = (slack * MORE_SLACK, slacks + 1);
            cells = look(slack)?;
            continue;
        }
        return Ok(Ok(Schedule {
            separation: separation(task, &speed, &last_look),
            exposures: exposures(task, &speed, feed_m_per_s, duration_s, found),
            points: match speed {
                SpindleSpeed::Schedule(points) => points,
                SpindleSpeed::Constant(rpm) => vec![(0.0, rpm)],
            },
            feed_m_per_s,
            duration_s,
            coupling,
            acceleration_rpm_per_s,
            is_acceleration_assumed: given.is_none(),
            follows: best.follows,
            target_rpm,
            half_width: best.half_width,
            objective: best.objective,
            solved_for_s: pace.solve_for_s(),
            corridors_tried: best.tried,
            solver: best.end,
        }));
    }
}

/// What becomes of the feed, as far as that does not depend on the speed.
fn coupling(task: &Task) -> Coupling {
    match task.feed {
        FeedRule::Programmed => Coupling::Asked,
        FeedRule::ChipLoad if task.operation.program_feeds.any() => Coupling::OwnFeeds,
        FeedRule::ChipLoad if has_rapids(task.operation) => Coupling::Rapids,
        FeedRule::ChipLoad if task.path.standing_s() > 0.0 => Coupling::StandsStill,
        FeedRule::ChipLoad => Coupling::MeanChipLoad { rounds: 1 },
    }
}

/// Whether a program without feeds of its own has moves that do not run at the job's; the first is not run.
fn has_rapids(operation: &Operation) -> bool {
    let mut run = operation.moves.iter().skip(1);
    operation.program.is_some() && run.any(|each| each.feed_m_per_s != operation.feed_m_per_s)
}

/// The programmed schedule, where a check calls it clear.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn kept(task: &Task) -> Result<Option<KeptSchedule>, Note> {
    let Task { job, operation, path, .. } = *task;
    let SpindleSpeed::Schedule(points) = &operation.speed else { return Ok(None) };
    let stations = grid(path, operation.speed.corners());
    let first_look = Survey::take(path, stations, detail(&job.policy), &silent)?;
    let (found, last_look) =
        crossings_under(task.lines, &job.policy, &operation.speed, path, first_look)?;
    Ok(found.is_empty().then(|| KeptSchedule {
        points: points.clone(),
        feed_m_per_s: operation.feed_m_per_s,
        separation: separation(task, &operation.speed, &last_look),
    }))
}

/// Points of a schedule, without those on the straight line between others.
fn thinned(s: &[f64], rpm: &[f64], limits: &Limits) -> Vec<(f64, f64)> {
    /// Rounding takes this share of what the acceleration allows between two points at most.
    const FELT: f64 = 1e-4;
    let is_felt = |i: usize| FELT * limits.slope_rpm * (s[i + 1] - s[i]) * PARTS_PER_RPM < 1.0;
    let rounded = |i: usize| {
        let near = [i.checked_sub(1), (i + 1 < s.len()).then_some(i)];
        if near.into_iter().flatten().any(is_felt) {
            rpm[i]
        } else {
            (rpm[i] * PARTS_PER_RPM).round() / PARTS_PER_RPM
        }
    };
    let points: Vec<(f64, f64)> =
        (0..s.len()).map(|i| (s[i], rounded(i).clamp(limits.min_rpm, limits.max_rpm))).collect();
    let mut kept: Vec<(f64, f64)> = points.first().copied().into_iter().collect();
    let mut from = 0;
    for to in 2..points.len() {
        let (a, b) = (points[from], points[to]);
        let is_straight = points[from + 1..to].iter().all(|&(s, rpm)| {
            (a.1 + (b.1 - a.1) * (s - a.0) / (b.0 - a.0) - rpm).abs() < STRAIGHT_RPM
        });
        if !is_straight {
            from = to - 1;
            kept.push(points[from]);
        }
    }
    kept.extend(points.last().filter(|_| points.len() > 1));
    kept
}

fn mean(s: &[f64], rpm: &[f64]) -> f64 {
    (1..s.len()).map(|i| 0.5 * (rpm[i] + rpm[i - 1]) * (s[i] - s[i - 1])).sum()
}

fn separation(task: &Task, speed: &SpindleSpeed, survey: &Survey) -> Option<f64> {
    let policy = &task.job.policy;
    let mut least: Option<f64> = None;
    for station in survey.stations() {
        let rpm = speed.rpm_at(station.s);
        for line in task.lines {
            let excitation_hz = line.frequency_hz(rpm);
            if policy.ignores(excitation_hz) {
                continue;
            }
            for (r, hz) in station.frequencies_hz.iter().enumerate() {
                if task.counting.counts(&station, r) {
                    let apart = (excitation_hz - hz).abs() / hz;
                    least = Some(least.map_or(apart, |least| least.min(apart)));
                }
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schedule(points: &[(f64, f64)]) -> Schedule {
        Schedule {
            points: points.to_vec(),
            feed_m_per_s: 0.01,
            duration_s: 10.0,
            coupling: Coupling::Asked,
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
        let of = |separation| super::super::Constant {
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

    /// Corners stay, what lies on a line goes, and ends of a fast ramp keep all their digits.
    #[test]
    fn points_are_thinned_but_ramps_are_not() {
        let limits = Limits {
            programmed_rpm: 1000.0,
            target_rpm: 1000.0,
            slope_rpm: 1e6,
            min_rpm: 100.0,
            max_rpm: 6000.0,
        };
        let s = [0.0, 0.25, 0.5, 0.5 + 1e-9, 0.75, 1.0];
        let end_rpm = 1_002.000_999_912_3;
        let rpm = [1000.0, 1001.0, 1002.0, end_rpm, end_rpm, end_rpm];
        let found = thinned(&s, &rpm, &limits);
        let expected = [(0.0, 1000.0), (0.5, 1002.0), (0.5 + 1e-9, end_rpm), (1.0, 1002.001)];
        assert_eq!(found, expected);
    }
}
