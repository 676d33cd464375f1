//! The best of the safe constant speeds.

use super::options::Objective;
use super::speeds::{MAX_HALF_WIDTH, SafeSet, SpeedProblem, Speeds};

/// Speeds are rounded to whole rev/min; in narrow gaps in tenths or hundredths.
const STEPS_PER_RPM: [f64; 3] = [1.0, 10.0, 100.0];

/// How far inside the end of a band a speed stays, rev/min or as a share of the speed: far more
/// than rounding and the ends of bands are wrong by.
const GUARD_RPM: f64 = 0.02;
const GUARD_RATIO: f64 = 1e-6;

/// In hundredths there is room for less.
const MIN_GUARD_RPM: f64 = 0.002;

/// Shares of the largest separation that a round speed may keep, the best first.
const NEARLY: [f64; 4] = [0.999, 0.99, 0.95, 0.8];

/// The speed to run at, or `None` where no gap is wide enough to set a speed in it.
/// `programmed_rpm` is the one to stay near to; `best_first` are speeds in gaps, for objectives
/// that rank them.
pub(super) fn choose(
    problem: &SpeedProblem,
    set: &SafeSet,
    objective: Objective,
    programmed_rpm: f64,
    best_first: &[f64],
) -> Option<f64> {
    let near = |set: &SafeSet, wished_rpm: f64| {
        set.safe
            .iter()
            .filter_map(|gap| settle(problem, *gap, wished_rpm))
            .min_by(|a, b| (a - wished_rpm).abs().total_cmp(&(b - wished_rpm).abs()))
    };
    match objective {
        Objective::Nearest => near(set, programmed_rpm),
        Objective::Vibration | Objective::Depth => best_first
            .iter()
            .find_map(|&rpm| {
                let gap = set.safe.iter().find(|gap| gap.contains(rpm))?;
                settle(problem, *gap, rounded(rpm, set))
            })
            .or_else(|| near(set, programmed_rpm)),
        Objective::Highest => {
            set.safe.iter().rev().find_map(|gap| settle(problem, *gap, gap.high_rpm))
        }
        Objective::Margin => match problem.widest() {
            // Round, at the cost of as little of the separation as it takes. Ignored bands end
            // abruptly, so the speeds that keep nearly as much are asked for anew.
            Some(bind) => NEARLY
                .into_iter()
                .map(|share| problem.divide(share * bind.separation))
                .find_map(|nearly| near(&nearly, rounded(bind.rpm, &nearly)))
                .or_else(|| near(set, bind.rpm))
                .filter(|rpm| set.safe.iter().any(|gap| gap.contains(*rpm))),
            // Some speeds are near to nothing that counts.
            None => near(&problem.divide(MAX_HALF_WIDTH), programmed_rpm)
                .or_else(|| near(set, programmed_rpm)),
        },
    }
}

/// The speed nearest to `wished_rpm` that can be set within a gap: itself, or round.
pub(super) fn settle(problem: &SpeedProblem, gap: Speeds, wished_rpm: f64) -> Option<f64> {
    let inside = |least_rpm: f64| {
        let guard = |rpm: f64, limit_rpm: f64| {
            // The spindle's own limits may be run at.
            if rpm == limit_rpm { 0.0 } else { least_rpm.max(GUARD_RATIO * rpm) }
        };
        Speeds {
            low_rpm: gap.low_rpm + guard(gap.low_rpm, problem.spindle.min_rpm),
            high_rpm: gap.high_rpm - guard(gap.high_rpm, problem.spindle.max_rpm),
        }
    };
    let wide = inside(GUARD_RPM);
    /// A multiple of a step is off by less than this share.
    const ROUNDING: f64 = 1e-12;
    let can_be_set = |rpm: f64| {
        let off = |step: f64| ((rpm / step).round() * step - rpm).abs();
        problem.step_rpm.is_none_or(|step| off(step) <= ROUNDING * rpm)
    };
    if wide.contains(wished_rpm) && can_be_set(wished_rpm) {
        return Some(wished_rpm);
    }
    let narrow = inside(MIN_GUARD_RPM);
    let [whole, tenths, hundredths] = STEPS_PER_RPM;
    let any = [(whole, wide), (tenths, wide), (hundredths, narrow)];
    let one_step = problem.step_rpm.map(|step| [(1.0 / step, wide)]);
    let ways = one_step.as_ref().map_or(&any[..], |own| &own[..]);
    ways.iter().find_map(|&(steps, Speeds { low_rpm, high_rpm })| {
        let (first, last) = ((low_rpm * steps).ceil() / steps, (high_rpm * steps).floor() / steps);
        let round = (wished_rpm * steps).round() / steps;
        let ends = [low_rpm, high_rpm]
            .into_iter()
            .filter(|&rpm| rpm == problem.spindle.min_rpm || rpm == problem.spindle.max_rpm)
            .filter(|&rpm| can_be_set(rpm));
        let round = (first <= last).then(|| round.clamp(first, last));
        ends.chain(round).min_by(|a, b| (a - wished_rpm).abs().total_cmp(&(b - wished_rpm).abs()))
    })
}

/// As round as the gap around it allows: a step is a fiftieth of its width at most.
fn rounded(rpm: f64, set: &SafeSet) -> f64 {
    let gap = set.safe.iter().find(|gap| gap.contains(rpm));
    let width_rpm = gap.map_or(0.0, |gap| gap.high_rpm - gap.low_rpm);
    let [.., finest] = STEPS_PER_RPM;
    let fine_enough = |steps: &f64| width_rpm * steps >= 50.0;
    let steps = STEPS_PER_RPM.into_iter().find(fine_enough).unwrap_or(finest);
    (rpm * steps).round() / steps
}

/// How far from a band a speed stays at least.
pub(super) fn guard_rpm(rpm: f64) -> f64 {
    GUARD_RPM.max(GUARD_RATIO * rpm)
}
