//! The best speed between the bands or, where there is no way, across them; for the margin, between
//! the widest bands that leave one.

use super::cells::Cells;
use super::not_cutting::is_not_cutting_between;
use super::outcome::NoSchedule;
use super::quadratic_program::{SolverEnd, objective, solve};
use super::routes::{Bands, ExposureCost, Limits, Route, routes};
use super::task::Task;
use crate::advice::options::Objective;
use crate::advice::speeds::{MAX_HALF_WIDTH, Speeds, ignored_speeds};
use crate::notes::Note;
use crate::path::{Detail, Survey};
use crate::progress::silent;
use crate::units::rpm_from_hz;

/// What a second in a band costs in an air cut, as a share of a second in the cut.
const AIR_CUT_WEIGHT: f64 = 1e-6;

/// The widest bands that leave a way are found to this share of themselves.
const WIDEST_TOLERANCE: f64 = 1e-4;

/// Of what the widest bands have beyond the policy's, this much is kept: the first with which the
/// solver finds a speed.
const NEARLY: [f64; 4] = [0.9999, 0.998, 0.98, 0.9];

/// The best speed, at the sides of the cells and where ramps end.
pub(super) struct Best {
    pub(super) s: Vec<f64>,
    pub(super) rpm: Vec<f64>,
    pub(super) objective: f64,
    pub(super) ramps: Vec<[f64; 2]>,
    pub(super) tried: usize,
    pub(super) end: SolverEnd,
    pub(super) follows: Objective,
    pub(super) half_width: f64,
}

/// The best speed between the bands, or across them where it must be.
pub(super) fn best(
    task: &Task,
    cells: &Cells,
    follows: Objective,
    limits: &Limits,
) -> Result<Result<Best, NoSchedule>, Note> {
    let rules = task.counting.rules;
    let (policy, spindle) = (rules.policy, &task.job.spindle);
    let plane = |half_width| cells.plane(task.lines, policy, spindle, half_width);
    let ways = |half_width| routes(&plane(half_width), limits, None);
    let least = rules.half_width();
    let open = ways(least);
    if open.is_empty() {
        let ignores = |line, rpm| ignored_speeds(policy, line).any(|strip| strip.contains(rpm));
        let exposure = ExposureCost::new(exposure_costs(task, &cells.s)?, &ignores);
        let across = routes(&plane(least), limits, Some(&exposure));
        // What goes through a band keeps no margin.
        let follows = if follows == Objective::Margin { Objective::Nearest } else { follows };
        return Ok(first_of(across, limits).map(|best| Best {
            follows,
            half_width: least,
            ..best
        }));
    }
    if follows == Objective::Margin
        && let Some(widest) = widest(least, &|half_width| !ways(half_width).is_empty())
    {
        for share in NEARLY {
            let half_width = least + share * (widest - least);
            if let Ok(best) = first_of(ways(half_width), limits) {
                return Ok(Ok(Best { follows, half_width, ..best }));
            }
        }
    }
    Ok(first_of(open, limits).map(|best| Best { follows, half_width: least, ..best }))
}

/// The widest bands that leave a way, from `least` on, which do; `None` where they may be as wide
/// as they like.
fn widest(least: f64, leaves_way: &dyn Fn(f64) -> bool) -> Option<f64> {
    // Where there are no bands to be widened, begin with 1 %.
    let (mut open, mut closed) = (least, 2.0 * least.max(0.01));
    while leaves_way(closed) {
        if closed > MAX_HALF_WIDTH {
            return None;
        }
        (open, closed) = (closed, 2.0 * closed);
    }
    while closed - open > WIDEST_TOLERANCE * closed {
        let middle = 0.5 * (open + closed);
        if leaves_way(middle) { open = middle } else { closed = middle }
    }
    Some(open)
}

/// Solves way after way, in the order of their bounds, until no other can be better.
fn first_of(ways: Vec<Route>, limits: &Limits) -> Result<Best, NoSchedule> {
    let mut best: Option<Best> = None;
    let mut why = NoSchedule::NoWay;
    let mut tried = 0;
    for way in ways {
        // With ramps the order is that of exposure, and the first that can be run is the one.
        let is_settled = best
            .as_ref()
            .is_some_and(|best| !best.ramps.is_empty() || way.at_least >= best.objective);
        if is_settled {
            break;
        }
        tried += 1;
        let (rpm, end) = match solve(&way.s, &way.bounds, limits) {
            Ok(solved) => solved,
            // Whatever stopped the solver, there may be another way.
            Err(end) => {
                why = NoSchedule::Solver(end);
                continue;
            }
        };
        let objective = objective(&way.s, &rpm, limits);
        if best.as_ref().is_none_or(|best| objective < best.objective) {
            best = Some(Best {
                s: way.s,
                rpm,
                objective,
                ramps: way.ramps,
                tried,
                end,
                follows: Objective::Nearest,
                half_width: 0.0,
            });
        }
    }
    best.map(|best| Best { tried, ..best }).ok_or(why)
}

/// Per cell, what it costs to be in the band of each mode for as long as the whole path takes.
fn exposure_costs(task: &Task, s: &[f64]) -> Result<Vec<Bands>, Note> {
    let Task { path, lines, .. } = *task;
    let rules = task.counting.rules;
    let middles = s.windows(2).map(|side| 0.5 * (side[0] + side[1])).collect();
    let survey = Survey::take(path, middles, Detail::TipResponse, &silent)?;
    let mut cells = Vec::with_capacity(survey.len());
    for (side, station) in s.windows(2).zip(survey.stations()) {
        let share =
            if is_not_cutting_between(task, side[0], side[1]) { AIR_CUT_WEIGHT } else { 1.0 };
        let mut bands = Vec::new();
        for (r, (&hz, &tip)) in station.frequencies_hz.iter().zip(station.tip_m_per_n).enumerate() {
            let [low_hz, high_hz] = rules.reach_hz(station.s, r, hz);
            for &line in lines {
                let rpm = |hz: f64| rpm_from_hz(hz) / f64::from(line.order);
                let low_rpm = rpm(low_hz * (1.0 - rules.half_width()));
                let high_rpm = rpm(high_hz * (1.0 + rules.half_width()));
                if !rules.is_faint(tip) {
                    bands.push((Speeds { low_rpm, high_rpm }, line, share * tip));
                }
            }
        }
        cells.push(bands);
    }
    Ok(cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_bands_are_found() {
        let found = widest(0.05, &|half_width| half_width <= 0.2371).unwrap();
        assert!(found <= 0.2371 && found > 0.2371 * (1.0 - 2.0 * WIDEST_TOLERANCE), "{found}");
        assert_eq!(widest(0.05, &|_| true), None);
        assert_eq!(
            widest(0.05, &|half_width| half_width <= 0.05).map(|w| (w * 1e3) as u32),
            Some(50)
        );
    }
}
