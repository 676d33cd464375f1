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
    let (step, most_off) = even_steps(&times, step);
    let resolution = resolution(&times);
    // What rounding leaves, and a little more for the rounding of the steps themselves.
    let is_rounded = resolution <= 0.5 * step && most_off <= 0.55 * resolution;
    if most_off <= UNEVEN * step || is_rounded {
        let rate_hz = whole(step.recip(), 2.0 * most_off / (last - first));
        return Ok(Clock::Even { rate_hz });
    }
    jump(&times, title).map_or(Ok(Clock::Uneven { times_s: times }), Err)
}

/// The even step that fits times best (least squares), and how far a time lies from its place at
/// most; `guess` is about that step.
fn even_steps(times: &[f64], guess: f64) -> (f64, f64) {
    let middle = 0.5 * (times.len() - 1) as f64;
    let places = || times.iter().enumerate().map(|(k, time)| (k as f64 - middle, time));
    let off = |(k, time): (f64, &f64)| time - times[0] - (k + middle) * guess;
    let mean = places().map(off).sum::<f64>() / times.len() as f64;
    let along: f64 = places().map(|place| place.0 * off(place)).sum();
    let more = along / places().map(|(k, _)| k * k).sum::<f64>();
    let left = |place: (f64, &f64)| (off(place) - mean - more * place.0).abs();
    (guess + more, places().map(left).fold(0.0, f64::max))
}

/// What times were rounded to, s: the decimal place that all have, or six significant digits of the
/// largest.
fn resolution(times: &[f64]) -> f64 {
    /// Of a place, what arithmetic leaves.
    const EXACT: f64 = 1e-5;
    const SIGNIFICANT: i32 = 6;
    let has = |places: &i32| {
        let unit = 10_f64.powi(*places);
        times.iter().all(|time| (time * unit - (time * unit).round()).abs() < EXACT)
    };
    let decimals = (0..=SIGNIFICANT).find(has).unwrap_or(SIGNIFICANT);
    let places = |time: f64| SIGNIFICANT - 1 - time.abs().log10().floor() as i32;
    let is_six = |time: f64| {
        time == 0.0 || {
            let unit = 10_f64.powi(places(time));
            (time * unit - (time * unit).round()).abs() < EXACT
        }
    };
    let largest = times.iter().fold(0.0_f64, |most, time| most.max(time.abs()));
    if times.iter().all(|time| is_six(*time)) {
        return 10_f64.powi(-decimals.min(places(largest)));
    }
    10_f64.powi(-decimals)
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
        let [before, after] = [times[k], times[k + 1]];
        let what = match before == after {
            true => format!(
                "{title} is {before} s in two rows, must rise from row to row: where the recorder \
                 wrote a sample twice, delete one of them; where it rounds its times, leave the \
                 column out and give sample_rate_hz"
            ),
            false => format!(
                "{title} goes from {before} s to {after} s, must rise from row to row: sort the \
                 rows, or keep the part before or after"
            ),
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    fn rate_of(step: f64, round: impl Fn(f64) -> f64) -> Option<f64> {
        let times = (0..40_000).map(|k| round(f64::from(k) * step)).collect();
        clock(times, "t").ok()?.parts().0
    }

    /// A telephone that writes a sample twice, and rows out of order.
    #[test]
    fn times_that_do_not_rise_are_told_with_what_to_do() {
        let told = |times: &[f64]| clock(times.to_vec(), "t").err().unwrap();
        let (at, what) = told(&[0.0, 0.011, 0.019, 0.019, 0.032, 0.041]);
        assert_eq!(at, 3);
        assert!(what.contains("t is 0.019 s in two rows") && what.contains("delete"), "{what}");
        let (at, what) = told(&[0.0, 0.011, 0.019, 0.012, 0.032, 0.041]);
        assert_eq!(at, 3);
        assert!(what.contains("0.019 s to 0.012 s") && what.contains("sort"), "{what}");
    }

    /// 256 samples/s printed to the millisecond lie up to an eighth of a step off their places.
    #[test]
    fn even_times_that_were_rounded_are_even() {
        let to = |unit: f64| move |time: f64| (time / unit).round() * unit;
        assert_eq!(rate_of(1.0 / 256.0, to(1e-3)), Some(256.0));
        let of_120 = rate_of(1.0 / 120.0, to(1e-3)).unwrap();
        assert!((of_120 / 120.0 - 1.0).abs() < 1e-7, "{of_120}");
        // Six significant digits: to the millisecond from 100 s on.
        let six = |time: f64| format!("{time:.5e}").parse().unwrap();
        assert_eq!(rate_of(1.0 / 256.0, six), Some(256.0));
        // What moves by more than it was rounded by is uneven.
        let swings = |time: f64| to(1e-3)(time + 9e-4 * (40.0 * time).sin());
        assert_eq!(rate_of(1.0 / 256.0, swings), None);
        // Times to the microsecond that move by a fifth of a step do so, however large they are.
        let swings = |time: f64| to(1e-6)(time + 4e-4 * (40.0 * time).sin());
        assert_eq!(rate_of(1.0 / 500.0, swings), None);
        // Nobody can say where samples lie whose times are hardly finer than they.
        assert_eq!(rate_of(1.0 / 1200.0, to(1e-3)), None);
    }
}
