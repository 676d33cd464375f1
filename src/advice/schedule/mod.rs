//! A spindle speed that varies along the path: between the moving bands where it can, across them where it
//! must.
//!
//! # Time
//! A schedule is a speed over s, and s runs in proportion to time at the operation's one feed. So the feed is
//! coupled to the speed by its mean: it is scaled so that the mean chip load stays what it was, which
//! changes the duration, and with it how much the spindle can change between two places. The schedule
//! is solved again until it holds for the duration that its own mean speed gives. It keeps the
//! acceleration limit at the programmed feed, too, so that an override between the two breaks nothing.
//! Where the duration does not follow the feed alone (programs with feeds of their own, turns on the
//! spot), and where it is asked for, the feed stays as programmed.

mod cells;
mod programme;
mod routes;

pub use programme::SolverEnd;

use self::cells::{CELLS, Plane, plane};
use self::programme::{objective, solve};
use self::routes::{Bands, Hurt, Limits, routes};
use super::ranges::Counting;
use super::speeds::{Speeds, feed_at, ignored_speeds};
use super::vibration::{Chip, TipModel};
use super::{FeedRule, KeptSchedule};
use crate::excitation::ExcitationLine;
use crate::job::{Job, Operation, SpindleSpeed};
use crate::path::{Detail, Path, Survey, SurveyFault, grid};
use crate::risk::{Crossing, crossings_under, detail};
use crate::units::{hz_from_rpm, rpm_from_hz};

/// Taken where the job gives no acceleration of the spindle: an assumption, not a figure of any spindle.
pub const ASSUMED_ACCELERATION_RPM_PER_S: f64 = 500.0;

/// Of the acceleration this much is used, so that rounding does not exceed it.
const USED_ACCELERATION: f64 = 0.999;

/// Bulges of bands between stations are taken so many times as large as stations show them; more, if a
/// check finds contact.
const SLACK: f64 = 1.5;
const MORE_SLACK: f64 = 4.0;

/// A move faster than this many times the operation's feed is one in the air.
const AIR_FEED: f64 = 2.0;

/// What a second in a band hurts in the air, as a share of a second in the cut.
const AIR_HURT: f64 = 1e-6;

/// Solutions for one operation: for durations that follow the mean speed, and for more slack.
const MOST_ROUNDS: usize = 24;

/// The feed is settled when the duration changes by less than this share.
const SETTLED: f64 = 1e-9;

/// Points nearer than this to the straight line between their neighbours are left out, rev/min.
const STRAIGHT_RPM: f64 = 1e-6;

/// Speeds of a schedule are told to so many parts of a rev/min.
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
    /// Σ w (n/n_p − 1)² + ρ Σ Δ(n/n_p)²/Δs: what was minimised.
    pub objective: f64,
    /// The duration for which it was minimised, s: the shorter of those at the programmed and the new feed.
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
        let mut stretches: Vec<(f64, f64)> =
            self.exposures.iter().map(|e| (e.crossing.from_s, e.crossing.to_s)).collect();
        stretches.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut share, mut reached) = (0.0, 0.0_f64);
        for (from, to) in stretches {
            share += (to - from.max(reached)).max(0.0);
            reached = reached.max(to);
        }
        share * self.duration_s
    }

    /// Whether all of it is this constant speed, but for what a solver leaves.
    pub(super) fn is_constant(&self, rpm: f64) -> bool {
        /// rev/min.
        const NOISE: f64 = 0.01;
        self.points.iter().all(|point| (point.1 - rpm).abs() < NOISE)
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
    /// It stays as programmed because turns on the spot take their time whatever the feed.
    StandsStill,
    /// It stays as programmed because the duration did not settle.
    NotSettled,
}

/// A stretch on which a band is crossed.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposure {
    /// Mode, line, place and certainty.
    pub crossing: Crossing,
    /// Time inside the band, s.
    pub seconds: f64,
    /// Teeth that enter the work in that time.
    pub tooth_impacts: f64,
    /// Whether the whole of it is run in the air.
    pub is_in_air: bool,
    /// What the cutting force moves the tool tip where the line is closest, as if it stayed there, m; zero in
    /// the air, `None` where the job does not tell enough of the cut.
    pub tip_amplitude_m: Option<f64>,
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
    pub(super) feed: FeedRule,
    pub(super) tip: Option<&'a TipModel>,
}

/// The schedule nearest to the programmed speed that keeps out of all bands or, where none does, crosses as
/// few as it can where it hurts least; or why there is none.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn schedule(task: &Task) -> Result<Result<Schedule, NoSchedule>, SurveyFault> {
    let Task { job, operation, path, .. } = *task;
    let programmed_s = path.duration_s();
    if programmed_s <= 0.0 {
        return Ok(Err(NoSchedule::NoTime));
    }
    let given = job.spindle.max_acceleration_rpm_per_s;
    let acceleration_rpm_per_s = given.unwrap_or(ASSUMED_ACCELERATION_RPM_PER_S);
    let mut coupling = match task.feed {
        FeedRule::Programmed => Coupling::Asked,
        FeedRule::ChipLoad if operation.program.is_some() => Coupling::OwnFeeds,
        FeedRule::ChipLoad if path.standing_s() > 0.0 => Coupling::StandsStill,
        FeedRule::ChipLoad => Coupling::MeanChipLoad { rounds: 1 },
    };
    let mut slack = SLACK;
    let mut solved_for_s = programmed_s;
    let mut cut = cut(task, slack)?;
    for round in 1..=MOST_ROUNDS {
        let limits = Limits {
            programmed_rpm: task.programmed_rpm,
            step_rpm: USED_ACCELERATION * acceleration_rpm_per_s * solved_for_s / CELLS as f64,
            min_rpm: job.spindle.min_rpm,
            max_rpm: job.spindle.max_rpm,
        };
        let best = match best(task, &cut, &limits)? {
            Ok(best) => best,
            Err(why) => return Ok(Err(why)),
        };
        let speed = SpindleSpeed::Schedule(thinned(&cut.s, &best.rpm, &limits));
        let mean_rpm = mean(&cut.s, &best.rpm);
        let mut feed_m_per_s = operation.feed_m_per_s;
        if let Coupling::MeanChipLoad { rounds } = &mut coupling {
            *rounds = round;
            feed_m_per_s = feed_at(operation.feed_m_per_s, task.programmed_rpm, mean_rpm);
            let duration_s = programmed_s * operation.feed_m_per_s / feed_m_per_s;
            if duration_s < solved_for_s * (1.0 - SETTLED) {
                solved_for_s = duration_s;
                if round == MOST_ROUNDS / 2 {
                    (coupling, solved_for_s) = (Coupling::NotSettled, programmed_s);
                }
                continue;
            }
        }
        let duration_s = programmed_s * operation.feed_m_per_s / feed_m_per_s;
        let stations = grid(path, speed.corners());
        let first_look = Survey::take(path, stations, detail(&job.policy), &|_| {})?;
        let (found, last_look) =
            crossings_under(task.lines, &job.policy, &speed, path, first_look)?;
        let is_told = |crossing: &Crossing| {
            best.ramps
                .iter()
                .any(|&(from, to)| crossing.from_s < cut.s[to] && crossing.to_s > cut.s[from])
        };
        if !found.iter().all(is_told) {
            slack *= MORE_SLACK;
            cut = self::cut(task, slack)?;
            continue;
        }
        return Ok(Ok(Schedule {
            separation: separation(task, &speed, &last_look),
            exposures: found
                .into_iter()
                .map(|crossing| exposure(task, &speed, feed_m_per_s, crossing))
                .collect(),
            points: match speed {
                SpindleSpeed::Schedule(points) => points,
                SpindleSpeed::Constant(rpm) => vec![(0.0, rpm)],
            },
            feed_m_per_s,
            duration_s,
            coupling,
            acceleration_rpm_per_s,
            is_acceleration_assumed: given.is_none(),
            objective: best.objective,
            solved_for_s,
            corridors_tried: best.tried,
            solver: best.end,
        }));
    }
    Ok(Err(NoSchedule::Contact))
}

/// The programmed schedule, where a check calls it clear.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn kept(task: &Task) -> Result<Option<KeptSchedule>, SurveyFault> {
    let Task { job, operation, path, .. } = *task;
    let SpindleSpeed::Schedule(points) = &operation.speed else { return Ok(None) };
    let stations = grid(path, operation.speed.corners());
    let first_look = Survey::take(path, stations, detail(&job.policy), &|_| {})?;
    let (found, last_look) =
        crossings_under(task.lines, &job.policy, &operation.speed, path, first_look)?;
    Ok(found.is_empty().then(|| KeptSchedule {
        points: points.clone(),
        feed_m_per_s: operation.feed_m_per_s,
        separation: separation(task, &operation.speed, &last_look),
    }))
}

fn cut(task: &Task, slack: f64) -> Result<Plane, SurveyFault> {
    let Task { job, path, survey, lines, counting, .. } = *task;
    plane(path, survey, lines, counting, &job.spindle, slack)
}

/// The best speed at the sides of the cells.
struct Best {
    rpm: Vec<f64>,
    objective: f64,
    ramps: Vec<(usize, usize)>,
    tried: usize,
    end: SolverEnd,
}

/// Solves way after way, in the order of their bounds, until no other can be better.
fn best(
    task: &Task,
    plane: &Plane,
    limits: &Limits,
) -> Result<Result<Best, NoSchedule>, SurveyFault> {
    let mut ways = routes(plane, limits, None);
    if ways.is_empty() {
        let policy = &task.job.policy;
        let ignores = |line, rpm| ignored_speeds(policy, line).any(|strip| strip.contains(rpm));
        ways = routes(plane, limits, Some(&Hurt::new(hurt(task, plane)?, &ignores)));
    }
    let mut best: Option<Best> = None;
    let mut why = NoSchedule::NoWay;
    let mut tried = 0;
    for way in ways {
        // With ramps the order is that of what hurts, and the first that can be run is the one.
        let is_settled = best
            .as_ref()
            .is_some_and(|best| !best.ramps.is_empty() || way.at_least >= best.objective);
        if is_settled {
            break;
        }
        tried += 1;
        let (rpm, end) = match solve(&plane.s, &way.bounds, limits) {
            Ok(solved) => solved,
            // Whatever stopped the solver, there may be another way.
            Err(end) => {
                why = NoSchedule::Solver(end);
                continue;
            }
        };
        let objective = objective(&plane.s, &rpm, limits.programmed_rpm);
        if best.as_ref().is_none_or(|best| objective < best.objective) {
            best = Some(Best { rpm, objective, ramps: way.ramps, tried, end });
        }
    }
    Ok(best.map(|best| Best { tried, ..best }).ok_or(why))
}

/// Per cell, what it hurts to be in the band of each mode.
fn hurt(task: &Task, plane: &Plane) -> Result<Vec<Bands>, SurveyFault> {
    let Task { job, path, lines, .. } = *task;
    let policy = &job.policy;
    let middles = plane.s.windows(2).map(|side| 0.5 * (side[0] + side[1])).collect();
    let survey = Survey::take(path, middles, Detail::TipResponse, &|_| {})?;
    let mut cells = Vec::with_capacity(plane.corridors.len());
    for (side, station) in plane.s.windows(2).zip(survey.stations()) {
        let in_air = is_idle(task, side[0]) && is_idle(task, side[1]);
        let share = (side[1] - side[0]) * if in_air { AIR_HURT } else { 1.0 };
        let mut bands = Vec::new();
        for (hz, &tip) in station.frequencies_hz.iter().zip(station.tip_m_per_n) {
            for &line in lines {
                let rpm = |hz: f64| rpm_from_hz(hz) / f64::from(line.order);
                let low_rpm = rpm(hz * (1.0 - policy.wide()));
                let high_rpm = rpm(hz * (1.0 + policy.wide()));
                if !policy.is_faint(tip) {
                    bands.push((Speeds { low_rpm, high_rpm }, line, share * tip));
                }
            }
        }
        cells.push(bands);
    }
    Ok(cells)
}

/// Whether the move run at `s` is one in the air.
pub(in crate::advice) fn is_air(operation: &Operation, path: &Path, s: f64) -> bool {
    path.feed_m_per_s_at(s) > AIR_FEED * operation.feed_m_per_s
}

/// Whether nothing cuts at `s`: the move is one in the air, or the spindle stands.
fn is_idle(task: &Task, s: f64) -> bool {
    task.counting.turning.stands_at(s) || is_air(task.operation, task.path, s)
}

/// Points of a schedule, without those on the straight line between others.
fn thinned(s: &[f64], rpm: &[f64], limits: &Limits) -> Vec<(f64, f64)> {
    let rounded = |rpm: f64| (rpm * PARTS_PER_RPM).round() / PARTS_PER_RPM;
    let points: Vec<(f64, f64)> = s
        .iter()
        .zip(rpm)
        .map(|(&s, &rpm)| (s, rounded(rpm).clamp(limits.min_rpm, limits.max_rpm)))
        .collect();
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

fn exposure(task: &Task, speed: &SpindleSpeed, feed_m_per_s: f64, crossing: Crossing) -> Exposure {
    let Task { job, operation, path, tip, .. } = *task;
    let duration_s = path.duration_s() * operation.feed_m_per_s / feed_m_per_s;
    let ends: Vec<f64> = std::iter::once(crossing.from_s)
        .chain(speed.corners().filter(|s| *s > crossing.from_s && *s < crossing.to_s))
        .chain([crossing.to_s])
        .collect();
    let rpm: Vec<f64> = ends.iter().map(|&s| speed.rpm_at(s)).collect();
    let turns = hz_from_rpm(mean(&ends, &rpm)) * duration_s;
    let is_in_air = ends.iter().all(|&s| is_idle(task, s));
    let tip_amplitude_m = tip.map(|tip| {
        let at = crossing.closest_s;
        let chip = Chip::Feed(feed_m_per_s);
        if is_in_air { 0.0 } else { tip.amplitude_near(at, speed.rpm_at(at), chip) }
    });
    Exposure {
        tip_amplitude_m,
        seconds: (crossing.to_s - crossing.from_s) * duration_s,
        tooth_impacts: turns * f64::from(job.tool.teeth),
        is_in_air,
        crossing,
    }
}
