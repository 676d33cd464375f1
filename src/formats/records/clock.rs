//! A column of times → how samples lie in time. Times may be uneven, as a telephone's are; a jump
//! by far more than they usually vary is a loss of samples.

use crate::units::{s_from_ms, s_from_us};

/// How far a sample may lie from its place in even steps, as a share of a step: times are printed
/// with few digits (7 ms for 1/140 s), while a lost sample moves all that follow by a whole step.
const UNEVEN: f64 = 0.12;

pub(crate) type ToSeconds = fn(f64) -> f64;

/// What a title of time ends in, after its name.
const TIMES: [(&str, ToSeconds); 7] = [
    ("", std::convert::identity),
    ("s", std::convert::identity),
    ("sec", std::convert::identity),
    ("seconds", std::convert::identity),
    ("ms", s_from_ms),
    ("us", s_from_us),
    ("µs", s_from_us),
];

fn words(title: &str) -> Vec<String> {
    let mark = |c: char| " _,/()[]".contains(c);
    let words = title.split(mark).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect()
}

fn of_unit(unit: &str) -> Option<ToSeconds> {
    TIMES.iter().find(|(label, _)| *label == unit).map(|(_, to_s)| *to_s)
}

/// How a column of time becomes seconds; `None` for any other column.
pub(crate) fn time(title: &str) -> Option<ToSeconds> {
    match words(title).as_slice() {
        [name] if is_time(name) => of_unit(""),
        [name, unit] if is_time(name) => of_unit(unit),
        _ => None,
    }
}

fn is_time(name: &str) -> bool {
    matches!(name, "t" | "time")
}

/// The place of time among titles, and how it becomes seconds: the one that is `named`, with the
/// unit that it ends in, or the first that is called as time is.
pub(super) fn time_among(titles: &[String], named: Option<&str>) -> Option<(usize, ToSeconds)> {
    let own = titles.iter().position(|title| Some(title.as_str()) == named);
    let by_unit = |title: &str| words(title).last().and_then(|unit| of_unit(unit));
    let of_own = |at: usize| (at, by_unit(&titles[at]).unwrap_or(std::convert::identity));
    let called = || titles.iter().enumerate().find_map(|(at, title)| Some((at, time(title)?)));
    own.map(of_own).or_else(called)
}

/// How the samples lie in time.
pub(super) enum Clock {
    Even { rate_hz: f64 },
    Uneven { times_s: Vec<f64> },
}

impl Clock {
    /// Samples per second, or when they were taken.
    pub(super) fn parts(self) -> (Option<f64>, Option<Vec<f64>>) {
        match self {
            Self::Even { rate_hz } => (Some(rate_hz), None),
            Self::Uneven { times_s } => (None, Some(times_s)),
        }
    }
}

/// The clock of a column of times; the sample at which it lost some or goes back is a fault.
pub(super) fn clock(times: Vec<f64>, title: &str) -> Result<Clock, (usize, String)> {
    let (first, last) = match times.as_slice() {
        [first, .., last] => (*first, *last),
        _ => return Err((0, format!("{title} has fewer than two times"))),
    };
    let step = (last - first) / (times.len() - 1) as f64;
    if step <= 0.0 || !step.is_finite() {
        let what = format!("{title} does not rise from the first row to the last");
        return Err((times.len() - 1, what));
    }
    let off = |(k, time): (usize, &f64)| (time - first - k as f64 * step).abs();
    let most_off = times.iter().enumerate().map(off).fold(0.0, f64::max);
    if most_off <= UNEVEN * step {
        let rate_hz = whole(step.recip(), 2.0 * most_off / (last - first));
        return Ok(Clock::Even { rate_hz });
    }
    jump(&times, title).map_or(Ok(Clock::Uneven { times_s: times }), Err)
}

/// The first step back, or the first jump by far more than the times usually move, with the sample
/// behind it.
fn jump(times: &[f64], title: &str) -> Option<(usize, String)> {
    /// Usual steps in a jump, at least.
    const LEAST: f64 = 1.5;
    /// A jump is so many times as far from the usual step as nine tenths of all steps are.
    const FAR: f64 = 5.0;
    const MAX_STEPS: f64 = 0.9;
    let moves = || times.windows(2).map(|pair| pair[1] - pair[0]);
    if let Some(k) = moves().position(|step| step <= 0.0) {
        let what = format!(
            "{title} goes from {} s to {} s, must rise from row to row",
            times[k],
            times[k + 1]
        );
        return Some((k + 1, what));
    }
    let mut steps: Vec<f64> = moves().collect();
    let middle = steps.len() / 2;
    let usual = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    steps.iter_mut().for_each(|step| *step = (*step - usual).abs());
    let most = ((MAX_STEPS * steps.len() as f64) as usize).min(steps.len() - 1);
    let spread = *steps.select_nth_unstable_by(most, f64::total_cmp).1;
    let limit = (usual + FAR * spread).max(LEAST * usual);
    let k = moves().position(|step| step > limit)?;
    let [before, after] = [times[k], times[k + 1]];
    let lost = match ((after - before) / usual).round() - 1.0 {
        lost if lost < 1.5 => "a sample is".to_owned(),
        lost => format!("about {lost:.0} samples are"),
    };
    let what = format!(
        "{title} goes from {before} s to {after} s, must go on in steps of about {usual:.6} s: \
            {lost} lost; record again, or keep the part before or after"
    );
    Some((k + 1, what))
}

/// A rate that the times give within `share` is the whole number that it may be.
fn whole(rate_hz: f64, share: f64) -> f64 {
    /// What arithmetic alone leaves, and the most that is rounded away.
    const LEAST: f64 = 1e-12;
    const MOST: f64 = 1e-5;
    let rounded = rate_hz.round();
    let is_whole = (rounded / rate_hz - 1.0).abs() <= share.clamp(LEAST, MOST);
    if is_whole { rounded } else { rate_hz }
}
