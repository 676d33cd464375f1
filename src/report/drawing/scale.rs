//! Ranges of numbers along an axis, and their ticks.

use crate::report::words::number;

/// A range of numbers, linear or logarithmic.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Scale {
    low: f64,
    high: f64,
    is_logarithmic: bool,
    /// Whether nothing lies between whole numbers.
    is_whole: bool,
}

impl Scale {
    /// A linear range. One without width is widened about its value; one that is not finite is 0 to
    /// 1.
    pub(in crate::report) fn linear(low: f64, high: f64) -> Self {
        let (low, high) = if (high - low).is_finite() { (low, high) } else { (0.0, 1.0) };
        let (low, high) = (low.min(high), low.max(high));
        // Below that, ticks would not differ.
        let is_narrow = high - low <= 1e-9 * low.abs().max(high.abs());
        let half = if is_narrow { (0.05 * high.abs()).max(0.5) } else { 0.0 };
        Self { low: low - half, high: high + half, is_logarithmic: false, is_whole: false }
    }

    /// Places from 1 to `count`, with half a place at either end.
    pub(in crate::report) fn places(count: usize) -> Self {
        Self { is_whole: true, ..Self::linear(0.5, count as f64 + 0.5) }
    }

    /// A logarithmic range; linear where an end is not positive.
    pub(in crate::report) fn logarithmic(low: f64, high: f64) -> Self {
        let linear = Self::linear(low, high);
        let is_logarithmic = linear.low > 0.0 && low < high;
        Self { is_logarithmic, ..linear }
    }

    /// The low end.
    pub(in crate::report) fn low(&self) -> f64 {
        self.low
    }

    /// The high end.
    pub(in crate::report) fn high(&self) -> f64 {
        self.high
    }

    /// Whether equal ratios are equally wide.
    pub(super) fn is_logarithmic(&self) -> bool {
        self.is_logarithmic
    }

    /// Where a value lies, 0 at the low end and 1 at the high.
    pub(in crate::report) fn share(&self, value: f64) -> f64 {
        if self.is_logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// The inverse of [`Self::share`].
    pub(in crate::report) fn value(&self, share: f64) -> f64 {
        if self.is_logarithmic {
            self.low * (self.high / self.low).powf(share)
        } else {
            self.low + (self.high - self.low) * share
        }
    }

    /// Round numbers within the range, about `count` of them.
    pub(super) fn ticks(&self, count: usize) -> Vec<f64> {
        let ticks = if self.is_logarithmic { self.decades() } else { self.steps(count) };
        let slack = 1e-9 * (self.high - self.low);
        ticks.into_iter().filter(|v| *v >= self.low - slack && *v <= self.high + slack).collect()
    }

    fn decades(&self) -> Vec<f64> {
        let steps: &[f64] = match (self.high / self.low).log10() {
            d if d > 3.0 => &[1.0],
            d if d > 1.6 => &[1.0, 2.0, 5.0],
            _ => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        };
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        decades.flat_map(|d| steps.iter().map(move |s| s * 10.0_f64.powi(d))).collect()
    }

    fn steps(&self, count: usize) -> Vec<f64> {
        let rough = (self.high - self.low) / count.max(1) as f64;
        let decade = 10.0_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .iter()
            .map(|s| s * decade)
            .find(|s| *s >= rough * 0.999)
            .unwrap_or(decade);
        let step = if self.is_whole { step.max(1.0) } else { step };
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }
}

/// Lowest and highest of the finite values; not finite where there is none.
pub(in crate::report) fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// A tick's number without needless digits.
pub(in crate::report) fn label(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e7).contains(&value.abs()) {
        return number(value, 0).replace('-', "−");
    }
    let rounded = format!("{value:.6}");
    let short = rounded.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(Scale::linear(-1.3, 2.2).ticks(4), [-1.0, 0.0, 1.0, 2.0]);
        assert_eq!(Scale::linear(0.0, 100.0).ticks(5), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
        assert_eq!(Scale::logarithmic(20.0, 900.0).ticks(5), [20.0, 50.0, 100.0, 200.0, 500.0]);
    }

    #[test]
    fn share_and_value_are_inverse() {
        for scale in [Scale::linear(3.0, 700.0), Scale::logarithmic(3.0, 700.0)] {
            for share in [0.0, 0.2, 0.9, 1.0] {
                assert!((scale.share(scale.value(share)) - share).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_range_without_width_still_has_a_scale() {
        let ends = [0.0, 7.0, -1e300, 1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        for (low, high) in ends.into_iter().flat_map(|low| ends.map(|high| (low, high))) {
            for scale in [Scale::linear(low, high), Scale::logarithmic(low, high)] {
                assert!(scale.low() < scale.high(), "{low} {high}");
                let middle = scale.share(scale.value(0.5));
                assert!((middle - 0.5).abs() < 1e-6, "{low} {high}: {middle}");
                assert!(scale.ticks(4).len() < 1000, "{low} {high}");
            }
        }
    }

    #[test]
    fn labels_are_short() {
        assert_eq!([label(-0.0), label(0.30000000000000004), label(-20.0)], ["0", "0.3", "−20"]);
        assert_eq!([label(2e300), label(-1e-9)], ["2.00e300", "−1.00e−9"]);
    }
}
