//! Where to measure next: poses at which rivals disagree most, in units of the noise, whatever their
//! parameters may still do (the expected information of Box & Hill, Technometrics 9, 1967).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::data::{Data, Load, Point, Row};
use super::fit::Fit;
use super::gain::typical;
use super::interval::covariance;
use super::problem::Problem;
use crate::model::{Conditions, Description, JointKind, Robot};

/// Poses that are looked at.
const LOOKED_AT: u32 = 600;

/// 2 ln of the odds beyond what the data say already at which two causes are sure to be split: what parts rivals
/// (twice [`super::findings::RIVAL_WITHIN`]), and as much as chance may take.
const SPLIT: f64 = 24.0;

/// The least that is likely to split them.
const MAY_SPLIT: f64 = 14.0;

/// A pose at which two rivals disagree by less is not worth the way.
const LEAST: f64 = 2.0;

/// Most poses that are suggested for one pair.
const MOST: usize = 6;

/// A pose worth measuring.
#[derive(Debug, Clone, PartialEq)]
pub struct NextPose {
    /// Joint positions, rad or m.
    pub joints: Vec<f64>,
    /// The two causes that it separates, each with its place.
    pub separates: [String; 2],
    /// By how much they disagree there, standard deviations of the noise.
    pub apart: f64,
}

/// Poses that split `finding` from `rival`, which is `behind` it by this much of BIC, best first; empty if none
/// does.
pub(super) fn poses_between(
    description: &Description,
    robot: &Robot,
    data: &Data,
    finding: &Fit<'_>,
    rival: &Fit<'_>,
    behind: f64,
) -> Vec<(Vec<f64>, f64)> {
    let rows = &data.rows;
    let conditions = Conditions {
        temperature_c: typical(rows.iter().filter_map(|r| r.conditions.temperature_c).collect()),
        amplitude_nm: typical(rows.iter().filter_map(|r| r.conditions.amplitude_nm).collect()),
    };
    let sample_rate_hz = typical(rows.iter().filter_map(|r| r.sample_rate_hz).collect());
    let looked_at: Vec<Row> = (1..=LOOKED_AT)
        .map(|i| Row {
            q: pose(robot, data, i),
            conditions,
            load: Load::NOMINAL,
            sample_rate_hz,
            index: 0,
        })
        .collect();
    let (Some(sure_a), Some(sure_b)) = (covariance(data, finding), covariance(data, rival)) else {
        return Vec::new();
    };
    let noise2 = finding.evaluation.noise.scale.powi(2);
    let mut apart: Vec<(Vec<f64>, f64)> = looked_at
        .par_iter()
        .filter_map(|row| {
            let points = (0..data.columns)
                .map(|column| Point {
                    row: 0,
                    column,
                    ln_f: 0.0,
                    unit: 1.0,
                    rounding: 0.0,
                    index: 0,
                })
                .collect();
            let one =
                Data { rows: vec![row.clone()], points, columns: data.columns, told_noise: None };
            let problem = Problem { description, data: &one };
            let a = problem.evaluate(&finding.hypothesis, true)?;
            let b = problem.evaluate(&rival.hypothesis, true)?;
            let shown: Vec<usize> = (0..data.columns)
                .filter(|&i| a.residuals[i].is_some() && b.residuals[i].is_some())
                .collect();
            let m = shown.len();
            let difference = DVector::from_fn(m, |i, _| {
                a.residuals[shown[i]].unwrap_or(0.0) - b.residuals[shown[i]].unwrap_or(0.0)
            });
            let slopes = |slopes: &[Vec<f64>], p: usize| {
                DMatrix::from_fn(m, p, |i, k| slopes[shown[i]].get(k).copied().unwrap_or(0.0))
            };
            let (ja, jb) = (slopes(&a.slopes, sure_a.nrows()), slopes(&b.slopes, sure_b.nrows()));
            let spread = &ja * &sure_a * ja.transpose()
                + &jb * &sure_b * jb.transpose()
                + DMatrix::from_diagonal_element(m, m, noise2);
            let solved = spread.cholesky()?.solve(&difference);
            Some((row.q.clone(), difference.dot(&solved)))
        })
        .collect();
    apart.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut taken: Vec<(Vec<f64>, f64)> = Vec::new();
    let mut total = 0.0;
    for (q, square) in apart {
        if square < LEAST || taken.len() == MOST || total > SPLIT + behind {
            break;
        }
        // The same pose twice says half as much.
        let is_near = |other: &(Vec<f64>, f64)| {
            q.iter().zip(&other.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 0.15
        };
        if taken.iter().any(is_near) {
            continue;
        }
        total += square;
        taken.push((q, square));
    }
    if total < MAY_SPLIT + behind { Vec::new() } else { taken }
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

    #[test]
    fn halton_starts_as_it_should() {
        let base_3: Vec<f64> = (1..=4).map(|i| radical_inverse(i, 3)).collect();
        for (found, expected) in base_3.iter().zip([1.0 / 3.0, 2.0 / 3.0, 1.0 / 9.0, 4.0 / 9.0]) {
            assert!((found - expected).abs() < 1e-15);
        }
    }
}
