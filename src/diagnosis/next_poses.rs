//! Where to measure next: poses at which rivals disagree most, in units of the noise, whatever their
//! parameters may still do (the expected information of Box & Hill, Technometrics 9, 1967).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::data::{Data, Load, Point, Row, median};
use super::fit::Fit;
use super::interval::covariance;
use super::problem::Problem;
use crate::model::{Cause, Conditions, Description, JointKind, Robot};

/// Poses that are looked at.
const LOOKED_AT: u32 = 600;

/// 2 ln of the odds beyond what the data say already at which two causes are sure to be split: what parts rivals
/// (twice [`super::findings::RIVAL_WITHIN`]), and as much as chance may take.
const SPLIT: f64 = 24.0;

/// The least that is likely to split them.
const MAY_SPLIT: f64 = 14.0;

/// A pose that adds less is not worth the way.
const LEAST: f64 = 2.0;

/// Poses closer than this in every joint are the same, rad or m.
const NEAR: f64 = 0.15;

/// Most poses that are suggested for one pair.
const MOST: usize = 6;

/// A pose worth measuring.
#[derive(Debug, Clone, PartialEq)]
pub struct NextPose {
    /// Joint positions, rad or m.
    pub joints: Vec<f64>,
    /// The two causes that it separates, each with its place.
    pub separates: [String; 2],
    /// What it adds to telling them apart, standard deviations of the noise: whatever the parameters may still do, and
    /// beyond what the poses before it show.
    pub apart: f64,
}

/// Poses that split `finding` from `rival`, which is `behind` it by this much of BIC, best first; empty if none
/// does, and `None` if nothing is known of the parameters.
pub(super) fn poses_between(
    description: &Description,
    robot: &Robot,
    data: &Data,
    finding: &Fit<'_>,
    rival: &Fit<'_>,
    behind: f64,
) -> Option<Vec<(Vec<f64>, f64)>> {
    let rows = &data.rows;
    let conditions = Conditions {
        temperature_c: median(rows.iter().filter_map(|r| r.conditions.temperature_c).collect()),
        amplitude_nm: median(rows.iter().filter_map(|r| r.conditions.amplitude_nm).collect()),
    };
    let sample_rate_hz = median(rows.iter().filter_map(|r| r.sample_rate_hz).collect());
    let looked_at: Vec<Row> = (1..=LOOKED_AT)
        .map(|i| Row {
            q: pose(robot, data, i),
            conditions,
            load: Load::NOMINAL,
            sample_rate_hz,
            index: 0,
        })
        .collect();
    let (sure_a, sure_b) = (covariance(data, finding)?, covariance(data, rival)?);
    let noise2 = finding.evaluation.noise.scale.powi(2);
    let columns = data.columns;
    let views: Vec<View> = looked_at
        .par_iter()
        .filter_map(|row| View::new(description, row, columns, finding, rival))
        .collect();
    // A rival that the data favour has to be split off all the same.
    let behind = behind.max(0.0);
    let mut known = Known::new(sure_a, sure_b);
    let mut taken: Vec<(Vec<f64>, f64)> = Vec::new();
    let mut total = 0.0;
    while taken.len() < MOST && total < SPLIT + behind {
        // The same pose twice says little more.
        let is_near = |q: &[f64]| taken.iter().any(|(other, _)| farthest(q, other) < NEAR);
        let best = views
            .par_iter()
            .filter(|view| !is_near(&view.q))
            .filter_map(|view| Some((known.odds(view, noise2)?, view)))
            .reduce_with(|a, b| if b.0 > a.0 { b } else { a });
        let Some((square, view)) = best.filter(|(square, _)| *square >= LEAST) else { break };
        known.take(view, noise2);
        total += square;
        taken.push((view.q.clone(), square));
    }
    Some(if total < MAY_SPLIT + behind { Vec::new() } else { taken })
}

/// The largest distance of one joint, rad or m.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// What a pose would show.
struct View {
    q: Vec<f64>,
    /// ln f of the rival less that of the finding, by mode.
    difference: DVector<f64>,
    /// By the parameters of the finding, and, negated, of the rival.
    slopes: DMatrix<f64>,
}

impl View {
    /// `None` where there is no such arm, or no mode that both have.
    fn new(
        description: &Description,
        row: &Row,
        columns: usize,
        finding: &Fit<'_>,
        rival: &Fit<'_>,
    ) -> Option<Self> {
        let point =
            |column| Point { row: 0, column, ln_f: 0.0, unit: 1.0, rounding: 0.0, index: 0 };
        let points = (0..columns).map(point).collect();
        let one = Data { rows: vec![row.clone()], points, columns, told_noise: None };
        let problem = Problem { description, data: &one };
        // Whether a mode will be missed there nobody knows.
        let a = problem.evaluate(&finding.hypothesis.without(Cause::MissedMode), true)?;
        let b = problem.evaluate(&rival.hypothesis.without(Cause::MissedMode), true)?;
        let shown: Vec<(usize, f64)> =
            (0..columns).filter_map(|i| Some((i, a.residuals[i]? - b.residuals[i]?))).collect();
        let [of_a, of_b] = [finding, rival].map(|fit| fit.hypothesis.inner().len());
        let slope = |i: usize, k: usize| {
            if k < of_a { a.slopes[i][k] } else { -b.slopes[i][k - of_a] }
        };
        (!shown.is_empty()).then(|| Self {
            q: row.q.clone(),
            difference: DVector::from_iterator(shown.len(), shown.iter().map(|(_, d)| *d)),
            slopes: DMatrix::from_fn(shown.len(), of_a + of_b, |m, k| slope(shown[m].0, k)),
        })
    }
}

/// What is known of the parameters of both when some poses are measured: one pose after the other, as a Kalman filter
/// has it, so that poses that show the same count once.
struct Known {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Known {
    fn new(sure_a: DMatrix<f64>, sure_b: DMatrix<f64>) -> Self {
        let (a, b) = (sure_a.nrows(), sure_b.nrows());
        let mut covariance = DMatrix::zeros(a + b, a + b);
        covariance.view_mut((0, 0), (a, a)).copy_from(&sure_a);
        covariance.view_mut((a, a), (b, b)).copy_from(&sure_b);
        Self { mean: DVector::zeros(a + b), covariance }
    }

    /// What the parameters do not account for at a pose, and the covariance of that.
    fn innovation(&self, view: &View, noise2: f64) -> (DVector<f64>, DMatrix<f64>) {
        let m = view.difference.len();
        let left = &view.difference - &view.slopes * &self.mean;
        let spread = &view.slopes * &self.covariance * view.slopes.transpose();
        (left, spread + DMatrix::from_diagonal_element(m, m, noise2))
    }

    /// 2 ln of the odds that a pose is expected to bring.
    fn odds(&self, view: &View, noise2: f64) -> Option<f64> {
        let (left, spread) = self.innovation(view, noise2);
        Some(left.dot(&spread.cholesky()?.solve(&left)))
    }

    /// As it is once the pose is measured.
    fn take(&mut self, view: &View, noise2: f64) {
        let (left, spread) = self.innovation(view, noise2);
        let Some(factor) = spread.cholesky() else { return };
        let across = &view.slopes * &self.covariance;
        self.mean += across.tr_mul(&factor.solve(&left));
        self.covariance -= across.tr_mul(&factor.solve(&across));
    }
}

/// The `i`-th pose of a Halton sequence within the limits of the joints.
fn pose(robot: &Robot, data: &Data, i: u32) -> Vec<f64> {
    const PRIMES: [u32; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];
    robot
        .joints()
        .iter()
        .enumerate()
        .map(|(j, joint)| {
            let measured = data.rows.iter().map(|row| row.q[j]);
            let low = measured.clone().fold(f64::INFINITY, f64::min);
            let high = measured.fold(f64::NEG_INFINITY, f64::max);
            let [low, high] = match (joint.limit, joint.kind) {
                (Some([a, b]), JointKind::Prismatic) => [a, b],
                // More than half a turn either way shows nothing new.
                (Some([a, b]), _) => {
                    [a.max(-std::f64::consts::PI).min(b), b.min(std::f64::consts::PI).max(a)]
                }
                (None, JointKind::Prismatic) => [low, high],
                (None, _) => [-std::f64::consts::PI, std::f64::consts::PI],
            };
            low + (high - low) * radical_inverse(i, PRIMES[j % PRIMES.len()])
        })
        .collect()
}

/// The digits of `i` in base `base`, mirrored at the point.
fn radical_inverse(mut i: u32, base: u32) -> f64 {
    let mut value = 0.0;
    let mut place = 1.0 / f64::from(base);
    while i > 0 {
        value += f64::from(i % base) * place;
        i /= base;
        place /= f64::from(base);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pose after pose comes to what all of them come to at once, in whatever order.
    #[test]
    fn poses_one_by_one_say_what_they_say_together() {
        let wave = |i: usize| (1.3 * i as f64).sin();
        let view = |n: usize| View {
            q: Vec::new(),
            difference: DVector::from_fn(2, |i, _| wave(7 * n + i)),
            slopes: DMatrix::from_fn(2, 3, |i, k| wave(31 * n + 5 * i + k)),
        };
        let sure = |n: usize, seed: usize| {
            let a = DMatrix::from_fn(n, n, |i, j| wave(seed + n * i + j));
            &a * a.transpose() + DMatrix::from_diagonal_element(n, n, 0.1)
        };
        let noise2 = 0.04;
        let views: Vec<View> = (0..4).map(view).collect();
        let one_by_one = |order: [usize; 4]| -> f64 {
            let mut known = Known::new(sure(2, 3), sure(1, 50));
            let odds = order.map(|i| {
                let odds = known.odds(&views[i], noise2).unwrap();
                known.take(&views[i], noise2);
                odds
            });
            odds.iter().sum()
        };
        let slopes = DMatrix::from_fn(8, 3, |i, k| views[i / 2].slopes[(i % 2, k)]);
        let difference = DVector::from_fn(8, |i, _| views[i / 2].difference[i % 2]);
        let spread = &slopes * Known::new(sure(2, 3), sure(1, 50)).covariance * slopes.transpose()
            + DMatrix::from_diagonal_element(8, 8, noise2);
        let together = difference.dot(&spread.try_inverse().unwrap().tr_mul(&difference));
        for order in [[0, 1, 2, 3], [3, 1, 0, 2]] {
            let found = one_by_one(order);
            assert!((found / together - 1.0).abs() < 1e-9, "{found} {together}");
        }
    }

    #[test]
    fn halton_starts_as_it_should() {
        let base_3: Vec<f64> = (1..=4).map(|i| radical_inverse(i, 3)).collect();
        for (found, expected) in base_3.iter().zip([1.0 / 3.0, 2.0 / 3.0, 1.0 / 9.0, 4.0 / 9.0]) {
            assert!((found - expected).abs() < 1e-15);
        }
    }
}
