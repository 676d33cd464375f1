//! A spindle speed that varies along the path: between the moving bands where it can, across them
//! where it must.
//!
//! # What is sought
//! The schedule follows the objective as far as that is a convex problem: near the programmed
//! speed, or near the spindle's highest; for the largest margin, the widest bands that leave a way
//! are found by bisection, and the way between them that is nearest to the programmed speed. How
//! much the tool tip vibrates is no convex function of the speed: there the schedule stays near the
//! quietest safe constant speed, if there is one.
//!
//! # Time
//! A schedule is a speed over s, and s runs in proportion to time at the operation's one feed. So
//! the feed is coupled to the speed by its mean: it is scaled so that the mean chip load stays what
//! it was, which changes the duration, and with it how much the spindle can change between two
//! places. See [`duration`]. The acceleration limit is kept at the programmed feed, too, so that an
//! override between the two breaks nothing. Where the duration does not follow the feed alone
//! (programs with feeds of their own, turns on the spot), and where it is asked for, the feed stays
//! as programmed.
//!
//! # Crossings
//! A band that must be crossed is crossed on one straight line at full acceleration, from the edge
//! of one corridor to the edge of the next; both ends are points of the schedule, however close
//! together.

mod cells;
mod duration;
mod exposures;
mod not_cutting;
mod outcome;
mod quadratic_program;
mod routes;
mod search;
mod task;

pub use exposures::{Exposure, Passage};
pub use outcome::{Coupling, KeptSchedule, NoSchedule, Schedule};
pub use quadratic_program::SolverEnd;
pub(super) use task::Task;

use self::cells::{Cells, sides};
use self::duration::{DurationSearch, Next};
use self::exposures::{exposed_share, exposures, passages};
use self::not_cutting::air_cut_sides;
use self::routes::Limits;
use self::search::best;
use self::task::mean;
use super::options::FeedRule;
use super::speeds::{Speeds, feed_at};
use crate::job::{Operation, SpindleSpeed};
use crate::notes::Note;
use crate::path::{Survey, grid};
use crate::progress::silent;
use crate::risk::{Crossing, crossings_under};

/// Of the acceleration this much is used, so that rounding does not exceed it.
const USED_ACCELERATION: f64 = 0.999;

/// Bulges of bands between stations are taken so many times as large as stations show them; more,
/// if a check finds contact.
const SLACK: f64 = 1.5;

/// Speeds of a schedule are rounded to so many parts of a rev/min where the
/// acceleration is not felt in that.
const PARTS_PER_RPM: f64 = 1e6;

/// The schedule that follows the objective best and keeps out of all bands or, where none does,
/// crosses as few as it must where it costs least.
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
    // No spindle reaches its highest speed within a microsecond; more is lost in digits.
    let acceleration_rpm_per_s = job.spindle.acceleration_rpm_per_s().min(1e9);
    let (follows, target_rpm) = task.goal();
    let sides = sides(&air_cut_sides(task));
    let look = |slack| Cells::look(path, sides.clone(), task.survey, task.counting, slack);
    let (mut slack, mut slacks) = (SLACK, 1);
    let mut cells = look(slack)?;
    let mut duration = DurationSearch::new(programmed_s, coupling(task));
    loop {
        let limits = Limits {
            programmed_rpm: task.programmed_rpm,
            target_rpm,
            slope_rpm: USED_ACCELERATION * acceleration_rpm_per_s * duration.solve_for_s(),
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
        let coupling = match duration.step(own_s, !best.ramps.is_empty()) {
            Next::Again => continue,
            Next::Settled(coupling) => coupling,
        };
        let (feed_m_per_s, duration_s) = match coupling {
            Coupling::MeanChipLoad => (own_feed_m_per_s, own_s),
            _ => (operation.feed_m_per_s, programmed_s),
        };
        let speed = SpindleSpeed::Schedule(thinned(&best.s, &best.rpm, &limits));
        let Some((found, last_look)) = checked(task, &speed, &best.ramps)? else {
            // A band was met that was not planned: again, with bulges four times as large.
            if slacks == 6 {
                return Ok(Err(NoSchedule::Contact));
            }
            (slack, slacks) = (slack * 4.0, slacks + 1);
            cells = look(slack)?;
            continue;
        };
        let exposures = exposures(task, &speed, feed_m_per_s, duration_s, found);
        let [low_rpm, high_rpm] = speed.range_rpm();
        let feed_ratio = feed_m_per_s / operation.feed_m_per_s;
        let chip_load_ratio = |rpm: f64| feed_ratio * task.programmed_rpm / rpm;
        return Ok(Ok(Schedule {
            separation: separation(task, &speed, &last_look),
            range_rpm: Speeds { low_rpm, high_rpm },
            chip_load_ratios: [high_rpm, low_rpm].map(chip_load_ratio),
            passages: passages(&exposures),
            exposed_s: exposed_share(&exposures) * duration_s,
            exposures,
            points: match speed {
                SpindleSpeed::Schedule(points) => points,
                SpindleSpeed::Constant(rpm) => vec![(0.0, rpm)],
            },
            feed_m_per_s,
            duration_s,
            coupling,
            feed_rounds: (coupling == Coupling::MeanChipLoad).then(|| duration.rounds()),
            acceleration_rpm_per_s,
            is_acceleration_assumed: given.is_none(),
            follows: best.follows,
            target_rpm,
            half_width: best.half_width,
            objective: best.objective,
            solved_for_s: duration.solve_for_s(),
            corridors_tried: best.tried,
            solver: best.end,
        }));
    }
}

/// The crossings of a schedule, and the survey that shows them; `None` where one of them lies in no
/// planned ramp.
fn checked(
    task: &Task,
    speed: &SpindleSpeed,
    ramps: &[[f64; 2]],
) -> Result<Option<(Vec<Crossing>, Survey)>, Note> {
    let stations = grid(task.path, speed.corners());
    let first_look = task.survey.at_stations(task.path, &stations, &silent)?;
    let (found, last_look) = crossings_under(
        task.job,
        task.operation,
        task.counting.rules,
        speed,
        task.path,
        first_look,
    )?;
    let is_planned = |crossing: &Crossing| {
        ramps.iter().any(|&[from, to]| crossing.from_s < to && crossing.to_s > from)
    };
    Ok(found.iter().all(is_planned).then_some((found, last_look)))
}

/// What becomes of the feed, as far as that does not depend on the speed.
fn coupling(task: &Task) -> Coupling {
    match task.feed {
        FeedRule::Programmed => Coupling::Asked,
        FeedRule::ChipLoad if task.operation.program_feeds.any() => Coupling::OwnFeeds,
        FeedRule::ChipLoad if has_rapids(task.operation) => Coupling::Rapids,
        FeedRule::ChipLoad if task.path.standing_s() > 0.0 => Coupling::StandsStill,
        FeedRule::ChipLoad => Coupling::MeanChipLoad,
    }
}

/// Whether a program without feeds of its own has moves that do not run at the job's; the first is
/// not run.
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
    let first_look = task.survey.at_stations(path, &stations, &silent)?;
    let rules = task.counting.rules;
    let (found, last_look) =
        crossings_under(job, operation, rules, &operation.speed, path, first_look)?;
    Ok(found.is_empty().then(|| KeptSchedule {
        points: points.clone(),
        feed_m_per_s: operation.feed_m_per_s,
        separation: separation(task, &operation.speed, &last_look),
    }))
}

/// Points of a schedule, without those on the straight line between others.
fn thinned(s: &[f64], rpm: &[f64], limits: &Limits) -> Vec<(f64, f64)> {
    // Rounding takes 1e-4 of what the acceleration allows between two points at most.
    let is_felt = |i: usize| 1e-4 * limits.slope_rpm * (s[i + 1] - s[i]) * PARTS_PER_RPM < 1.0;
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
        let is_straight = points[from + 1..to]
            .iter()
            .all(|&(s, rpm)| (a.1 + (b.1 - a.1) * (s - a.0) / (b.0 - a.0) - rpm).abs() < 1e-6);
        if !is_straight {
            from = to - 1;
            kept.push(points[from]);
        }
    }
    kept.extend(points.last().filter(|_| points.len() > 1));
    kept
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
