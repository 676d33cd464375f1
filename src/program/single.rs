//! Comparisons of numbers of which a controller keeps seven digits.
//!
//! Here they have sixteen. Where rounding there decides which of two is larger, the answer is not
//! known: one of them may be a sum.

use std::cmp::Ordering;

/// What helps.
pub(super) const COUNT: &str = "count in whole numbers";

/// Which of two numbers is larger.
pub(super) fn order(left: f64, right: f64) -> Result<Ordering, String> {
    apart(left, right)?;
    left.partial_cmp(&right).ok_or_else(|| rounded(right))
}

/// Whether two numbers are one.
pub(super) fn is_same(left: f64, right: f64) -> Result<bool, String> {
    if left != right {
        apart(left, right)?;
    }
    Ok(left == right)
}

/// Refuses numbers of which rounding decides which is larger.
fn apart(left: f64, right: f64) -> Result<(), String> {
    let is_sure = are_apart(left, right) || is_exact(left) && is_exact(right);
    is_sure.then_some(()).ok_or_else(|| rounded(right))
}

/// Whether two numbers differ by more than rounding.
pub(super) fn are_apart(left: f64, right: f64) -> bool {
    /// What some hundred sums lose, as a share.
    const ROUNDED: f64 = 1e-5;
    /// What they leave of numbers that cancel each other.
    const LEFT: f64 = 1e-4;
    let off = (left - right).abs();
    off > LEFT && off > ROUNDED * left.abs().max(right.abs())
}

/// Whether seven digits hold a number: whole ones and binary fractions. What sums leave beside
/// zero is none.
pub(super) fn is_exact(number: f64) -> bool {
    /// Parts of one that are exact.
    const PARTS: f64 = 65_536.0;
    f64::from(number as f32) == number && (number * PARTS).fract() == 0.0
}

/// Why a comparison with such a number is not known.
pub(super) fn rounded(near: f64) -> String {
    format!(
        "two numbers near {} are compared, and the controller's rounding to seven digits decides \
         which is larger: {COUNT}",
        near as f32
    )
}
