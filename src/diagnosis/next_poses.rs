//! Where to measure next: poses at which alternatives disagree most, in units of the noise, after
//! their parameters have adapted (the expected information of Box & Hill, Technometrics 9, 1967).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::data::{Data, Load, Row};
use super::fit::Fit;
use super::interval::covariance;
use super::problem::Problem;

use crate::model::{Cause, Conditions, Description, JointKind, Robot};
use crate::statistics::median;

/// 2 ln of the odds beyond what the data say already at which two causes are separated: what
/// separates alternatives (twice [`super::models::ALTERNATIVE_WITHIN`]), and as much as chance may
/// take.
const SEPARATED: f64 = 24.0;

/// The least that is likely to separate them.
const MAY_SEPARATE: f64 = 14.0;

/// A pose that adds less is not suggested.
const MIN_ADDED: f64 = 2.0;

/// A mass that is added for a test, over what the arm moves.
const SHARE_OF_ARM: f64 = 0.08;

/// Rows that are measured again with a mass.
const ROWS_WITH_MASS: usize = 8;

/// Poses closer than this in every joint are the same, rad or m.
const SAME_POSE: f64 = 0.15;

/// Poses that are tried.
const TRIED: u32 = 600;

/// The first poses of a Halton sequence within the limits of the joints, as rows of the table under
/// its usual conditions.
pub(super) fn anywhere(robot: &Robot, data: &Data, count: u32) -> Vec<Row> {
    let rows = &data.rows;
    let conditions = Conditions {
        temperature_c: median(rows.iter().filter_map(|r| r.conditions.temperature_c).collect()),
        amplitude_nm: median(rows.iter().filter_map(|r| r.conditions.amplitude_nm).collect()),
    };
    let sample_rate_hz = median(rows.iter().filter_map(|r| r.sample_rate_hz).collect());
    let row = |i| Row {
        q: pose(robot, data, i),
        conditions,
        load: Load::NOMINAL,
        sample_rate_hz,
        rotations: Vec::new(),
        damping: Vec::new(),
        index: 0,
    };
    (1..=count).map(row).collect()
}

/// Poses that separate `finding` from `alternative`, which is `behind` it by this much of BIC, best
/// first; empty if none does, and `None` if nothing is known of the parameters.
pub(super) fn poses_between(
    description: &Description,
    robot: &Robot,
    data: &Data,
    finding: &Fit<'_>,
    alternative: &Fit<'_>,
    behind: f64,
) -> Option<Vec<(Vec<f64>, f64)>> {
    let tried = anywhere(robot, data, TRIED);
    let (covariance_a, covariance_b) = (covariance(data, finding)?, covariance(data, alternative)?);
    let noise2 = finding.evaluation.noise.scale.powi(2);
    let columns = data.columns;
    let poses: Vec<PredictedPose> = tried
        .par_iter()
        .filter_map(|row| PredictedPose::new(description, row, columns, finding, alternative))
        .collect();
    // An alternative that the data favour has to be split off all the same.
    let behind = behind.max(0.0);
    let mut belief = Belief::new(covariance_a, covariance_b);
    let mut chosen: Vec<(Vec<f64>, f64)> = Vec::new();
    let mut total = 0.0;
    while chosen.len() < 6 && total < SEPARATED + behind {
        // The same pose twice says little more.
        let is_near = |q: &[f64]| chosen.iter().any(|(other, _)| farthest(q, other) < SAME_POSE);
        let best = poses
            .par_iter()
            .filter(|pose_seen| !is_near(&pose_seen.q))
            .filter_map(|pose_seen| Some((belief.odds(pose_seen, noise2)?, pose_seen)))
            .reduce_with(|a, b| if b.0 > a.0 { b } else { a });
        let Some((square, pose_seen)) = best.filter(|(square, _)| *square >= MIN_ADDED) else {
            break;
        };
        belief.update(pose_seen, noise2);
        total += square;
        chosen.push((pose_seen.q.clone(), square));
    }
    Some(if total < MAY_SEPARATE + behind { Vec::new() } else { chosen })
}

/// Whether poses separate `finding` from `alternative`, too; not where nothing is known of the
/// parameters.
pub(super) fn part(
    problem: &Problem<'_>,
    robot: &Robot,
    poses: &[(Vec<f64>, f64)],
    finding: &Fit<'_>,
    alternative: &Fit<'_>,
    behind: f64,
) -> bool {
    let Problem { description, data } = *problem;
    let known = [finding, alternative].map(|fit| covariance(data, fit));
    let [Some(of_finding), Some(of_alternative)] = known else { return false };
    let noise2 = finding.evaluation.noise.scale.powi(2);
    let mut belief = Belief::new(of_finding, of_alternative);
    let mut total = 0.0;
    let Some(any) = anywhere(robot, data, 1).pop() else { return false };
    for (q, _) in poses {
        let row = Row { q: q.clone(), ..any.clone() };
        let columns = data.columns;
        let Some(seen) = PredictedPose::new(description, &row, columns, finding, alternative)
        else {
            continue;
        };
        total += belief.odds(&seen, noise2).unwrap_or(0.0);
        belief.update(&seen, noise2);
    }
    total >= MAY_SEPARATE + behind.max(0.0)
}

/// The mass on a link that separates `finding` from `alternative` best, at the poses of the table;
/// `None` if no mass does.
pub(super) fn mass_between(
    problem: &Problem<'_>,
    robot: &Robot,
    finding: &Fit<'_>,
    alternative: &Fit<'_>,
    behind: f64,
) -> Option<String> {
    let Problem { description, data } = *problem;
    let mass_kg = handy(SHARE_OF_ARM * robot.moving_mass_kg());
    let links = robot.bodies().iter().filter(|body| !body.is_payload);
    let links: Vec<&str> = links
        .filter(|body| !robot.carriers_of(body).is_empty())
        .map(|body| body.link.as_str())
        .collect();
    let step = data.rows.len().div_ceil(ROWS_WITH_MASS).max(1);
    let (of_finding, of_alternative) = (covariance(data, finding)?, covariance(data, alternative)?);
    let noise2 = finding.evaluation.noise.scale.powi(2);
    let odds = |link: &str| -> Option<f64> {
        let mut belief = Belief::new(of_finding.clone(), of_alternative.clone());
        let mut total = 0.0;
        for row in data.rows.iter().step_by(step).filter(|row| row.load == Load::NOMINAL) {
            let load = Load { added_kg: vec![(link.to_owned(), mass_kg)], ..Load::NOMINAL };
            let row = Row { load, rotations: Vec::new(), ..row.clone() };
            let columns = data.columns;
            let Some(seen) = PredictedPose::new(description, &row, columns, finding, alternative)
            else {
                continue;
            };
            total += belief.odds(&seen, noise2)?;
            belief.update(&seen, noise2);
        }
        Some(total)
    };
    let (total, link) = links
        .par_iter()
        .filter_map(|link| Some((odds(link)?, *link)))
        .reduce_with(|a, b| if b.0 > a.0 { b } else { a })?;
    let enough = MAY_SEPARATE + behind.max(0.0);
    (total >= enough).then(|| {
        format!(
            "add {mass_kg} kg at the centre of mass of {link} and measure poses of the table \
             again, with a column mass_{link}_kg"
        )
    })
}

/// The nearest mass below that weights come in, kg.
fn handy(mass_kg: f64) -> f64 {
    let decade = 10_f64.powf(mass_kg.max(1e-3).log10().floor());
    let digit = [5.0, 2.0, 1.0].into_iter().find(|d| d * decade <= mass_kg).unwrap_or(1.0);
    digit * decade
}

/// The largest distance of one joint, rad or m.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// What a pose would show.
struct PredictedPose {
    q: Vec<f64>,
    /// ln f of the alternative less that of the finding, by mode.
    difference: DVector<f64>,
    /// By the parameters of the finding, and, negated, of the alternative.
    slopes: DMatrix<f64>,
}

impl PredictedPose {
    /// `None` where there is no such arm, or no mode that both have.
    fn new(
        description: &Description,
        row: &Row,
        columns: usize,
        finding: &Fit<'_>,
        alternative: &Fit<'_>,
    ) -> Option<Self> {
        let one = Data::at(row.clone(), columns);
        let problem = Problem { description, data: &one };
        // Whether a mode will be missed there nobody knows.
        let a = problem.evaluate(&finding.hypothesis.without(Cause::MissedMode))?;
        let b = problem.evaluate(&alternative.hypothesis.without(Cause::MissedMode))?;
        let shown: Vec<(usize, f64)> = (0..columns)
            .filter_map(|i| Some((i, a.left.residuals[i]? - b.left.residuals[i]?)))
            .collect();
        let [of_a, of_b] = [finding, alternative].map(|fit| fit.hypothesis.inner().len());
        let slope = |i: usize, k: usize| {
            if k < of_a { a.left.slopes[i][k] } else { -b.left.slopes[i][k - of_a] }
        };
        (!shown.is_empty()).then(|| Self {
            q: row.q.clone(),
            difference: DVector::from_iterator(shown.len(), shown.iter().map(|(_, d)| *d)),
            slopes: DMatrix::from_fn(shown.len(), of_a + of_b, |m, k| slope(shown[m].0, k)),
        })
    }
}

/// What is known of the parameters of both when some poses are measured: one pose after the other,
/// as a Kalman filter has it, so that poses that show the same count once.
struct Belief {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Belief {
    fn new(covariance_a: DMatrix<f64>, covariance_b: DMatrix<f64>) -> Self {
        let (a, b) = (covariance_a.nrows(), covariance_b.nrows());
        let mut covariance = DMatrix::zeros(a + b, a + b);
        covariance.view_mut((0, 0), (a, a)).copy_from(&covariance_a);
        covariance.view_mut((a, a), (b, b)).copy_from(&covariance_b);
        Self { mean: DVector::zeros(a + b), covariance }
    }

    /// What the parameters do not account for at a pose, and the covariance of that.
    fn innovation(&self, pose_seen: &PredictedPose, noise2: f64) -> (DVector<f64>, DMatrix<f64>) {
        let m = pose_seen.difference.len();
        let left = &pose_seen.difference - &pose_seen.slopes * &self.mean;
        let spread = &pose_seen.slopes * &self.covariance * pose_seen.slopes.transpose();
        (left, spread + DMatrix::from_diagonal_element(m, m, noise2))
    }

    /// 2 ln of the odds that a pose is expected to bring.
    fn odds(&self, pose_seen: &PredictedPose, noise2: f64) -> Option<f64> {
        let (left, spread) = self.innovation(pose_seen, noise2);
        Some(left.dot(&spread.cholesky()?.solve(&left)))
    }

    /// As it is once the pose is measured.
    fn update(&mut self, pose_seen: &PredictedPose, noise2: f64) {
        let (left, spread) = self.innovation(pose_seen, noise2);
        let Some(factor) = spread.cholesky() else { return };
        let across = &pose_seen.slopes * &self.covariance;
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
        let pose_seen = |n: usize| PredictedPose {
            q: Vec::new(),
            difference: DVector::from_fn(2, |i, _| wave(7 * n + i)),
            slopes: DMatrix::from_fn(2, 3, |i, k| wave(31 * n + 5 * i + k)),
        };
        let sure = |n: usize, seed: usize| {
            let a = DMatrix::from_fn(n, n, |i, j| wave(seed + n * i + j));
            &a * a.transpose() + DMatrix::from_diagonal_element(n, n, 0.1)
        };
        let noise2 = 0.04;
        let poses: Vec<PredictedPose> = (0..4).map(pose_seen).collect();
        let one_by_one = |order: [usize; 4]| -> f64 {
            let mut belief = Belief::new(sure(2, 3), sure(1, 50));
            let odds = order.map(|i| {
                let odds = belief.odds(&poses[i], noise2).unwrap();
                belief.update(&poses[i], noise2);
                odds
            });
            odds.iter().sum()
        };
        let slopes = DMatrix::from_fn(8, 3, |i, k| poses[i / 2].slopes[(i % 2, k)]);
        let difference = DVector::from_fn(8, |i, _| poses[i / 2].difference[i % 2]);
        let spread = &slopes * Belief::new(sure(2, 3), sure(1, 50)).covariance * slopes.transpose()
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
