//! The stiffness of a joint from known loads and measured deflections: the paper's Section 2, Fig.
//! 2. Ordinary least squares of moment over angle with an intercept (Draper & Smith, Applied
//! Regression Analysis, 3rd ed., ch. 1). The scatter is taken to lie in the moment; where it lies
//! in the angle, the slope is low by a fraction of 1 − R², which for a usable test is less than its
//! standard error.

use std::fmt;

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::statistics::mean;
use crate::units::written;
use crate::wording::counted;

/// Scatter below this relative to the moments is rounding: nothing is concluded from it.
const ROUNDING: f64 = 1e-12;

/// Two for the line and one for its scatter.
const MIN_ROWS: usize = 3;

/// The line through moment over angle of one joint; for a sliding joint read N for N·m and m for
/// rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StiffnessFit {
    /// Rows used.
    pub rows: usize,
    /// Slope k, N·m/rad.
    #[serde(rename = "stiffness_nm_per_rad")]
    pub stiffness: f64,
    /// Standard error of k, N·m/rad.
    #[serde(rename = "standard_error_nm_per_rad")]
    pub standard_error: f64,
    /// Confidence of the interval, 0..1.
    #[serde(rename = "confidence_percent", serialize_with = "written::percent")]
    pub confidence: f64,
    /// Confidence interval of k, N·m/rad.
    #[serde(rename = "interval_nm_per_rad")]
    pub interval: [f64; 2],
    /// Moment at zero angle, N·m.
    #[serde(rename = "intercept_nm")]
    pub intercept: f64,
    /// Standard error of the intercept, N·m.
    #[serde(rename = "intercept_standard_error_nm")]
    pub intercept_standard_error: f64,
    /// Standard deviation of the residuals, N·m.
    #[serde(rename = "residual_deviation_nm")]
    pub residual_deviation: f64,
    /// Fraction of the moments' variance that the line explains.
    pub r_squared: f64,
    /// How the residuals bend, where there are enough rows.
    pub curvature: Option<Curvature>,
}

/// Test of a quadratic term beside the line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Curvature {
    /// Of a bend as large as this from scatter alone.
    pub p_value: f64,
    /// Whether the stiffness grows with the load (or falls).
    pub stiffens: bool,
    /// Whether the bend is more than scatter, at the level of 1 %.
    #[serde(rename = "significant")]
    pub is_significant: bool,
}

/// Why no line can be fitted.
#[derive(Debug, Clone, PartialEq)]
pub enum StiffnessFault {
    /// Angles and moments are not equally many.
    Unpaired {
        /// Number of angles.
        angles: usize,
        /// Number of moments.
        moments: usize,
    },
    /// Fewer than three rows.
    TooFewRows(usize),
    /// A value is not a finite number; its row, from 0.
    NotFinite(usize),
    /// Each value is finite, but their squares, sums or quotients are not.
    OutOfRange,
    /// All angles are the same, or all moments.
    NothingVaries,
    /// The line falls, or is level: no spring does that. Its slope, N·m/rad.
    NotPositive(f64),
    /// Confidence outside 0..1.
    Confidence(f64),
}

impl fmt::Display for StiffnessFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unpaired { angles, moments } => {
                write!(f, "{angles} angles and {moments} moments, must be equally many")
            }
            Self::TooFewRows(rows) => write!(
                f,
                "{}, must have at least {MIN_ROWS}: two for the line, one for its scatter",
                counted(*rows, "row")
            ),
            Self::NotFinite(row) => write!(f, "row {}: not a finite number", row + 1),
            Self::OutOfRange => write!(
                f,
                "angles or moments are too large or too small to compute with; check their units"
            ),
            Self::NothingVaries => {
                write!(f, "all angles or all moments are the same; load the joint in steps")
            }
            Self::NotPositive(slope) => write!(
                f,
                "k is {slope:.4e} N·m/rad, must be positive; the angle must count positive in the \
                 direction in which a positive moment turns the joint: change the sign of one \
                 column if it does not"
            ),
            Self::Confidence(given) => {
                write!(f, "confidence is {given}, must lie between 0 and 1")
            }
        }
    }
}

impl std::error::Error for StiffnessFault {}

/// Fits moment = intercept + k·angle.
///
/// # Errors
/// Too little data, angles and moments that are not equally many, not finite, too large or all the
/// same, a line that falls, or a confidence outside of 0..1.
pub fn fit_stiffness(
    angles_rad: &[f64],
    moments_nm: &[f64],
    confidence: f64,
) -> Result<StiffnessFit, StiffnessFault> {
    check(angles_rad, moments_nm, confidence)?;
    let rows = angles_rad.len();
    let n = rows as f64;
    let (angle, moment) = (mean(angles_rad), mean(moments_nm));
    let x: Vec<f64> = angles_rad.iter().map(|a| a - angle).collect();
    let y: Vec<f64> = moments_nm.iter().map(|m| m - moment).collect();
    let (sxx, syy) = (dot(&x, &x), dot(&y, &y));
    check_range(&[sxx, syy])?;
    if sxx <= 0.0 || syy <= 0.0 {
        return Err(StiffnessFault::NothingVaries);
    }
    let stiffness = dot(&x, &y) / sxx;
    let intercept = moment - stiffness * angle;
    let residuals: Vec<f64> = x.iter().zip(&y).map(|(x, y)| y - stiffness * x).collect();
    let lost = dot(&residuals, &residuals);
    let freedom = n - 2.0;
    let residual_deviation = (lost / freedom).sqrt();
    let standard_error = residual_deviation / sxx.sqrt();
    let reach = students_t(freedom)?.inverse_cdf(0.5 + 0.5 * confidence) * standard_error;
    let fit = StiffnessFit {
        rows,
        stiffness,
        standard_error,
        interval: [stiffness - reach, stiffness + reach],
        confidence,
        intercept,
        intercept_standard_error: residual_deviation * (1.0 / n + angle * angle / sxx).sqrt(),
        residual_deviation,
        r_squared: 1.0 - lost / syy,
        curvature: curvature(&x, &residuals, syy, moments_nm)?,
    };
    check_range(&[fit.stiffness, fit.standard_error, fit.interval[0], fit.interval[1]])?;
    check_range(&[fit.intercept, fit.intercept_standard_error, residual_deviation, fit.r_squared])?;
    if fit.stiffness <= 0.0 {
        return Err(StiffnessFault::NotPositive(fit.stiffness));
    }
    Ok(fit)
}

/// Finite values may still overflow when they are squared or divided.
fn check_range(computed: &[f64]) -> Result<(), StiffnessFault> {
    if computed.iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(StiffnessFault::OutOfRange)
    }
}

fn check(angles: &[f64], moments: &[f64], confidence: f64) -> Result<(), StiffnessFault> {
    if angles.len() != moments.len() {
        return Err(StiffnessFault::Unpaired { angles: angles.len(), moments: moments.len() });
    }
    if angles.len() < MIN_ROWS {
        return Err(StiffnessFault::TooFewRows(angles.len()));
    }
    let is_bad = |(a, m): (&f64, &f64)| !(a.is_finite() && m.is_finite());
    if let Some(row) = angles.iter().zip(moments).position(is_bad) {
        return Err(StiffnessFault::NotFinite(row));
    }
    if !(confidence > 0.0 && confidence < 1.0) {
        return Err(StiffnessFault::Confidence(confidence));
    }
    Ok(())
}

/// t-test of the coefficient of a parabola orthogonal to the line. `x` are centred angles.
fn curvature(
    x: &[f64],
    residuals: &[f64],
    syy: f64,
    moments: &[f64],
) -> Result<Option<Curvature>, StiffnessFault> {
    let n = x.len() as f64;
    let freedom = n - 3.0;
    let sxx = dot(x, x);
    let skew: f64 = x.iter().map(|x| x * x * x).sum::<f64>() / sxx;
    let parabola: Vec<f64> = x.iter().map(|x| x * x - skew * x - sxx / n).collect();
    let size = dot(&parabola, &parabola);
    check_range(&[skew, size])?;
    // With two distinct angles the parabola is rounding.
    if freedom < 1.0 || size <= (ROUNDING * sxx).powi(2) {
        return Ok(None);
    }
    let bend = dot(&parabola, residuals) / size;
    let explained = bend * bend * size;
    if explained.max(dot(residuals, residuals)) <= ROUNDING * ROUNDING * syy {
        return Ok(Some(Curvature { p_value: 1.0, stiffens: false, is_significant: false }));
    }
    let rest: f64 = residuals.iter().zip(&parabola).map(|(r, p)| (r - bend * p).powi(2)).sum();
    check_range(&[bend, explained, rest])?;
    let t = (explained / (rest / freedom)).sqrt();
    let p_value = if t.is_finite() { 2.0 * students_t(freedom)?.sf(t) } else { 0.0 };
    // The slope changes by 2·bend per radian; it stiffens if it grows towards the larger moment.
    let by_size = |a: &(&f64, &f64), b: &(&f64, &f64)| a.1.abs().total_cmp(&b.1.abs());
    let most = x.iter().zip(moments).max_by(by_size).map_or(0.0, |(x, _)| *x);
    let least = x.iter().zip(moments).min_by(by_size).map_or(0.0, |(x, _)| *x);
    let stiffens = bend * (most - least) > 0.0;
    Ok(Some(Curvature { p_value, stiffens, is_significant: p_value < 0.01 }))
}

/// A jump of the angle where the moment changes its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jump {
    /// From one side to the other, rad.
    pub(crate) size_rad: f64,
    /// Of the lines on either side, N·m/rad.
    pub(crate) stiffness: f64,
}

/// The jump that play makes, or a spring that is soft near zero: θ = a + M/k + g sign(M), where g
/// is above zero at the level of 1 %. `None` too where the joint was not loaded both ways.
pub(crate) fn jump(angles_rad: &[f64], moments_nm: &[f64]) -> Option<Jump> {
    const LEVEL: f64 = 0.01;
    let sides = [1.0, -1.0].map(|side| moments_nm.iter().filter(|m| **m * side > 0.0).count());
    if sides.into_iter().any(|rows| rows < MIN_ROWS) {
        return None;
    }
    let most = moments_nm.iter().fold(0.0, |most: f64, m| most.max(m.abs()));
    let rows = || moments_nm.iter().map(|m| Vector3::new(1.0, m / most, m.signum()));
    let normal: Matrix3<f64> = rows().map(|row| row * row.transpose()).sum();
    let inverse = normal.try_inverse()?;
    let right: Vector3<f64> = rows().zip(angles_rad).map(|(row, angle)| row * *angle).sum();
    let found = inverse * right;
    let left: f64 = rows().zip(angles_rad).map(|(r, angle)| (angle - r.dot(&found)).powi(2)).sum();
    let freedom = angles_rad.len() as f64 - 3.0;
    let (jump, slope) = (found[2], found[1] / most);
    let t = jump / (left / freedom * inverse[(2, 2)]).sqrt();
    let is_there = t > 0.0 && slope > 0.0 && students_t(freedom).ok()?.sf(t.min(1e300)) < LEVEL;
    // Less is rounding.
    let is_there = is_there && jump > ROUNDING.sqrt() * slope * most;
    is_there.then(|| Jump { size_rad: 2.0 * jump, stiffness: slope.recip() })
}

fn students_t(freedom: f64) -> Result<StudentsT, StiffnessFault> {
    // Location 0 and scale 1 are valid, and the rows were counted.
    StudentsT::new(0.0, 1.0, freedom).map_err(|_| StiffnessFault::TooFewRows(freedom as usize))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// NIST Statistical Reference Datasets, linear regression, "Norris" (ozone monitors), (y, x):
    /// <https://www.itl.nist.gov/div898/strd/lls/data/Norris.shtml>.
    const NORRIS: [(f64, f64); 36] = [
        (0.1, 0.2),
        (338.8, 337.4),
        (118.1, 118.2),
        (888.0, 884.6),
        (9.2, 10.1),
        (228.1, 226.5),
        (668.5, 666.3),
        (998.5, 996.3),
        (449.1, 448.6),
        (778.9, 777.0),
        (559.2, 558.2),
        (0.3, 0.4),
        (0.1, 0.6),
        (778.1, 775.5),
        (668.8, 666.9),
        (339.3, 338.0),
        (448.9, 447.5),
        (10.8, 11.6),
        (557.7, 556.0),
        (228.3, 228.1),
        (998.0, 995.8),
        (888.8, 887.6),
        (119.6, 120.2),
        (0.3, 0.3),
        (0.6, 0.3),
        (557.6, 556.8),
        (339.3, 339.1),
        (888.0, 887.2),
        (998.5, 999.0),
        (778.9, 779.0),
        (10.2, 11.1),
        (117.6, 118.3),
        (228.9, 229.2),
        (668.4, 669.1),
        (449.2, 448.9),
        (0.2, 0.5),
    ];

    /// NIST's certified values, all of whose 15 digits were found with 500-digit arithmetic.
    #[test]
    fn agrees_with_the_certified_values_of_norris() {
        let (y, x): (Vec<f64>, Vec<f64>) = NORRIS.iter().copied().unzip();
        let fit = fit_stiffness(&x, &y, 0.95).unwrap();
        for (what, found, certified) in [
            ("slope", fit.stiffness, 1.00211681802045),
            ("intercept", fit.intercept, -0.262323073774029),
            ("standard error of the slope", fit.standard_error, 0.429796848199937e-3),
            ("standard error of the intercept", fit.intercept_standard_error, 0.232818234301152),
            ("residual deviation", fit.residual_deviation, 0.884796396144373),
            ("R squared", fit.r_squared, 0.999993745883712),
        ] {
            assert!((found / certified - 1.0).abs() < 1e-11, "{what}: {found}, not {certified}");
        }
        // t(0.975; 34) = 2.032245 from tables.
        let reach = 0.5 * (fit.interval[1] - fit.interval[0]) / fit.standard_error;
        assert!((reach - 2.032245).abs() < 1e-6, "{reach}");
    }

    /// A normal deviate by Box and Muller.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        let (u, v): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    /// Eight loads on joint 2 of the paper, 138,000 N·m/rad; `bend` in N·m/rad².
    fn load_test(seed: u64, bend: f64) -> StiffnessFit {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let angles: Vec<f64> = (0..8).map(|i| 2e-4 * f64::from(i)).collect();
        let moments: Vec<f64> = angles
            .iter()
            .map(|a| 5.0 + 138_000.0 * a + bend * a * a + 2.0 * normal(&mut rng))
            .collect();
        fit_stiffness(&angles, &moments, 0.95).unwrap()
    }

    /// 2000 tests: the share within the interval has a standard deviation of 0.5 %.
    #[test]
    fn the_interval_covers_the_truth_as_often_as_it_says() {
        let covers = (0..2000)
            .filter(|&seed| {
                let [low, high] = load_test(seed, 0.0).interval;
                (low..=high).contains(&138_000.0)
            })
            .count();
        let share = covers as f64 / 2000.0;
        assert!((0.94..=0.96).contains(&share), "{share}");
    }

    #[test]
    fn curvature_is_found_where_it_is_and_seldom_elsewhere() {
        let alarms = |bend: f64| {
            (0..1000)
                .filter(|&seed| load_test(seed, bend).curvature.unwrap().is_significant)
                .count()
        };
        // One in a hundred by design: 10 of 1000, standard deviation 3.
        let false_alarms = alarms(0.0);
        assert!((1..=20).contains(&false_alarms), "{false_alarms}");
        let found = alarms(4e7);
        assert!(found > 900, "{found}");
        assert!(load_test(0, 4e7).curvature.unwrap().stiffens);
        assert!(!load_test(0, -2e7).curvature.unwrap().stiffens);
    }

    #[test]
    fn load_in_the_other_direction_stiffens_alike() {
        let angles = [0.0, -1e-3, -2e-3, -3e-3, -4e-3];
        let stiffening: Vec<f64> = angles.iter().map(|a| 1e5 * a - 1e7 * a * a).collect();
        assert!(fit_stiffness(&angles, &stiffening, 0.95).unwrap().curvature.unwrap().stiffens);
        let softening: Vec<f64> = angles.iter().map(|a| 1e5 * a + 1e7 * a * a).collect();
        assert!(!fit_stiffness(&angles, &softening, 0.95).unwrap().curvature.unwrap().stiffens);
    }

    #[test]
    fn a_perfect_line_is_not_curved() {
        let angles = [1e-3, 2e-3, 3e-3, 5e-3];
        let fit = fit_stiffness(&angles, &angles.map(|a| 7.0 + 1.5e5 * a), 0.95).unwrap();
        assert!((fit.stiffness / 1.5e5 - 1.0).abs() < 1e-12);
        assert!(!fit.curvature.unwrap().is_significant);
    }

    /// At every scale: a fit without NaN, or a fault.
    #[test]
    fn sums_that_overflow_are_a_fault() {
        let (angles, moments) = ([0.0, 1.0, 2.0, 3.0, 4.5], [0.1, 1.0, 2.2, 3.0, 4.0]);
        let fit = |angle: f64, moment: f64| {
            fit_stiffness(&angles.map(|a| a * angle), &moments.map(|m| m * moment), 0.95)
        };
        for (angle, moment) in
            [(1e200, 1.0), (1.0, 1e200), (1e200, 1e200), (1e80, 1e5), (1e307, 1.0)]
        {
            assert_eq!(fit(angle, moment), Err(StiffnessFault::OutOfRange), "{angle} {moment}");
        }
        for angle in -300..=300 {
            for moment in (-300..=300).step_by(20) {
                let Ok(fit) = fit(10_f64.powi(angle), 10_f64.powi(moment)) else { continue };
                let p_value = fit.curvature.map_or(0.0, |curvature| curvature.p_value);
                let found = [fit.stiffness, fit.standard_error, fit.interval[0], fit.interval[1]];
                let more = [fit.intercept, fit.intercept_standard_error, fit.r_squared, p_value];
                assert!(
                    found.iter().chain(&more).all(|x| x.is_finite()),
                    "{angle} {moment} {fit:?}"
                );
            }
        }
        assert!(fit(1e-4, 1e4).is_ok());
    }

    #[test]
    fn bad_data_is_refused() {
        let fit = |a: &[f64], m: &[f64]| fit_stiffness(a, m, 0.95).err();
        assert_eq!(fit(&[0.0, 1.0], &[0.0, 1.0]), Some(StiffnessFault::TooFewRows(2)));
        let unpaired = StiffnessFault::Unpaired { angles: 3, moments: 2 };
        assert_eq!(fit(&[0.0, 1.0, 2.0], &[0.0, 1.0]), Some(unpaired));
        let not_finite = fit(&[0.0, f64::NAN, 2.0], &[0.0, 1.0, 2.0]);
        assert_eq!(not_finite, Some(StiffnessFault::NotFinite(1)));
        assert_eq!(fit(&[1.0; 3], &[0.0, 1.0, 2.0]), Some(StiffnessFault::NothingVaries));
        assert_eq!(fit(&[0.0, 1.0, 2.0], &[4.0; 3]), Some(StiffnessFault::NothingVaries));
        let confidence = fit_stiffness(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.5], 95.0).err();
        assert_eq!(confidence, Some(StiffnessFault::Confidence(95.0)));
    }
}
