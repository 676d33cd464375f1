//! Small statistics that several steps share.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::statistics;

/// ln(measured/predicted) → (predicted − measured)/measured.
pub(super) fn relative_error(residual: f64) -> f64 {
    (-residual).exp_m1()
}

/// Root mean square of what is there; 0 of nothing.
pub(super) fn rms<'e>(errors: impl Iterator<Item = &'e Option<f64>>) -> f64 {
    statistics::rms(errors.flatten().copied())
}

/// p-value of a gain of ln likelihood from `freedom` parameters where `left` degrees of freedom of
/// `n` points remain: the F test of the residual sums of squares that the likelihoods stand for.
pub(super) fn p_value_of_gain(gain: f64, freedom: f64, left: f64, n: f64) -> f64 {
    if gain.is_nan() || gain <= 0.0 || left < 1.0 {
        return 1.0;
    }
    let ratio = ((2.0 * gain / n).exp() - 1.0) * left / freedom;
    match FisherSnedecor::new(freedom, left) {
        Ok(f) if ratio.is_finite() => f.sf(ratio),
        Ok(_) => 0.0,
        Err(_) => 1.0,
    }
}
