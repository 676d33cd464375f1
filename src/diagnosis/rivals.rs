//! How far frequencies that nobody measured differ between models that the table cannot tell apart.
//!
//! The springs and masses of one model with its causes have a posterior; which causes they are, and
//! how large each is, it takes for sure. Every rival, and every cause a standard deviation larger
//! or smaller, is calibrated by the table, too, and what its frequencies differ by, weighed by the
//! evidence for it, is left unexplained by the one that was chosen.
//!
//! A cause of size c, the parameters θ free: Var f = Var(f | c) + (df/dc)² Var c, with f calibrated
//! anew for each c.

use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;

use super::candidate::Parameter;
use super::data::{Data, Row};
use super::fit::Fit;
use super::interval::distinct_from;
use super::models::Model;
use super::next_poses::anywhere;
use super::posterior::{Means, covariance_of_causes, means, predicted, rounded};
use super::problem::Problem;
use crate::model::{Robot, Unexplained};

/// Rivals that are calibrated, the likeliest first.
const MOST_RIVALS: usize = 12;

/// Poses at which models are compared: of the table at most so many,
const MOST_NEAR: usize = 24;

/// and so many anywhere.
const FAR: u32 = 48;

/// `unexplained` with what rivals of `chosen` differ by, mode by mode, at poses like those of the
/// table and anywhere, `seen` being the models that were met; `None` where `chosen` has no modes at
/// some pose.
pub(super) fn widened_by_rivals(
    problem: &Problem<'_>,
    robot: &Robot,
    chosen: &Fit<'_>,
    seen: &[Model<'_>],
    unexplained: &mut Unexplained,
) -> Option<()> {
    let near = near(problem.data);
    let far = anywhere(robot, problem.data, FAR);
    let split = near.len();
    let poses: Vec<Row> = near.into_iter().chain(far).collect();
    let at_poses = |fit: &Fit<'_>, means: &Means| {
        let corrections = fit.hypothesis.corrections();
        predicted(problem.description, &corrections, &means.learned, &poses)
    };
    let calibrated = |fit: &Fit<'_>| at_poses(fit, &means(problem, fit)?);
    let learned = means(problem, chosen)?;
    let own = at_poses(chosen, &learned)?;
    let mut rivals = distinct_from(chosen, seen);
    rivals.truncate(MOST_RIVALS);
    let best = rivals.first().map_or(0.0, |rival| rival.log_evidence);
    let rivals: Vec<(f64, Vec<Vec<f64>>)> = rivals
        .par_iter()
        .filter_map(|rival| Some(((rival.log_evidence - best).exp(), calibrated(&rival.fit)?)))
        .collect();
    // The one that was chosen counts as much as the best of its rivals.
    let whole = 1.0 + rivals.iter().map(|(weight, _)| weight).sum::<f64>();
    let rivals = rivals.into_iter().map(|(weight, ln_hz)| (weight / whole, ln_hz));
    let moved = covariance_of_causes(problem, chosen, &learned)
        .map_or_else(Vec::new, |covariance| along_axes(chosen, covariance));
    // Both ends of an axis, each half.
    let moved: Vec<(f64, Vec<Vec<f64>>)> =
        moved.par_iter().filter_map(|fit| Some((0.5, calibrated(fit)?))).collect();
    let all: Vec<(f64, Vec<Vec<f64>>)> = rivals.chain(moved).collect();
    let differs = |poses: std::ops::Range<usize>, mode: usize| -> f64 {
        let square = |(weight, ln_hz): &(f64, Vec<Vec<f64>>)| {
            let apart = poses.clone().filter_map(|i| {
                let apart = ln_hz[i].get(mode)? - own[i].get(mode)?;
                apart.is_finite().then_some(apart * apart)
            });
            let (count, sum) = apart.fold((0.0, 0.0), |(n, sum), own| (n + 1.0, sum + own));
            weight * sum / f64::max(count, 1.0)
        };
        all.iter().map(square).sum()
    };
    let widen = |shares: &mut [f64],
                 poses: std::ops::Range<usize>,
                 is_known: &dyn Fn(usize) -> bool| {
        for (mode, share) in shares.iter_mut().enumerate().filter(|(mode, _)| !is_known(*mode)) {
            *share = rounded((*share * *share + differs(poses.clone(), mode)).sqrt());
        }
    };
    // What a mode of the table is off by near it is known from poses left out.
    let is_measured = |mode: usize| problem.data.points.iter().any(|point| point.column == mode);
    widen(&mut unexplained.near, 0..split, &is_measured);
    widen(&mut unexplained.far, split..poses.len(), &|_| false);
    Some(())
}

/// Rows of the table, evenly taken.
fn near(data: &Data) -> Vec<Row> {
    let step = data.rows.len().div_ceil(MOST_NEAR).max(1);
    let own = data.rows.iter().step_by(step).cloned();
    own.map(|row| Row { rotations: Vec::new(), damping: Vec::new(), ..row }).collect()
}

/// The same causes a standard deviation off, both ways along each principal axis of a covariance of
/// their parameters.
fn along_axes<'c>(chosen: &Fit<'c>, covariance: DMatrix<f64>) -> Vec<Fit<'c>> {
    let axes = SymmetricEigen::new(covariance);
    let inner = chosen.hypothesis.inner();
    let parameters = chosen.hypothesis.effects.iter().flat_map(|(c, _)| &c.parameters);
    let parameters: Vec<&Parameter> = parameters.collect();
    let ends = axes.eigenvalues.iter().zip(axes.eigenvectors.column_iter());
    let ends =
        ends.filter(|(variance, _)| **variance > 0.0).flat_map(|(variance, axis)| {
            [-1.0, 1.0].map(|sign| {
                let reach = sign * variance.sqrt();
                let moved = inner.iter().zip(axis.iter()).zip(&parameters);
                let moved = moved.map(|((own, part), parameter)| {
                    if *part == 0.0 { *own } else { parameter.clamp(own + reach * part) }
                });
                let moved: Vec<f64> = moved.collect();
                Fit { hypothesis: chosen.hypothesis.with(&moved), ..chosen.clone() }
            })
        });
    ends.collect()
}

#[cfg(test)]
mod tests {
    use super::super::candidate::{Candidate, Scale};
    use super::super::fit::tests::{arm, data};
    use super::super::hypothesis::Hypothesis;
    use super::*;
    use crate::model::{Cause, Conditions, LearnedParameter};
    use nalgebra::DVector;

    const NOISE: f64 = 0.002;

    /// Modes that the table has, of three.
    const MEASURED: usize = 2;

    fn moved_mass() -> Candidate {
        let offset = Parameter {
            name: "dx_m",
            scale: Scale::Linear(0.1),
            nominal: Some(0.0),
            bounds: [-1.0, 1.0],
            starts: vec![],
            expected: None,
        };
        Candidate::new(Cause::ComOffset, "l3", vec![offset])
    }

    /// What the doubt about a cause's size adds to frequencies anywhere, against the same from one
    /// least squares of all parameters and the size together, with slopes by differences: the
    /// variance with the size free less that with it held.
    #[test]
    fn the_doubt_of_a_size_is_that_of_all_parameters_together() {
        let mut description = arm();
        description.elastic_joints.iter_mut().for_each(|joint| joint.std = Some(0.05));
        let mut data = data(14);
        data.stated_noise = Some(NOISE);
        data.points.retain(|point| point.column < MEASURED);
        for row in &mut data.rows {
            row.conditions = Conditions::default();
        }
        let candidate = moved_mass();
        let hypothesis = Hypothesis { effects: vec![(&candidate, vec![1.2])] };
        let truth = |rows: &[Row]| predicted(&description, &hypothesis.corrections(), &[], rows);
        let exact = truth(&data.rows).unwrap();
        for (i, point) in data.points.iter_mut().enumerate() {
            let noise = 0.5 * NOISE * (2.399 * (i + 1) as f64).sin();
            point.ln_f = exact[point.row][point.column] + noise;
        }
        let problem = Problem { description: &description, data: &data };
        let chosen = problem.optimise(hypothesis.clone()).unwrap();
        let robot = Robot::new(&description).unwrap();
        let modes = 3;
        let mut found =
            Unexplained { near: vec![0.0; modes], far: vec![0.0; modes], ..Unexplained::default() };
        widened_by_rivals(&problem, &robot, &chosen, &[], &mut found).unwrap();

        let learned = means(&problem, &chosen).unwrap().learned;
        let own: Vec<usize> =
            (0..learned.len()).filter(|&k| !learned[k].kind.is_lacking()).collect();
        let slopes = |rows: &[Row]| -> Vec<Vec<DVector<f64>>> {
            const STEP: f64 = 1e-4;
            let at = |k: usize, step: f64| {
                let mut moved: Vec<LearnedParameter> = learned.clone();
                let mut inner = chosen.hypothesis.inner();
                match own.get(k) {
                    Some(&k) => moved[k].ln += step,
                    None => inner[0] += step,
                }
                let corrections = chosen.hypothesis.with(&inner).corrections();
                predicted(&description, &corrections, &moved, rows).unwrap()
            };
            let ends: Vec<_> = (0..=own.len()).map(|k| [at(k, STEP), at(k, -STEP)]).collect();
            let of = |i: usize, r: usize| {
                DVector::from_fn(ends.len(), |k, _| {
                    (ends[k][0][i][r] - ends[k][1][i][r]) / (2.0 * STEP)
                })
            };
            (0..rows.len()).map(|i| (0..modes).map(|r| of(i, r)).collect()).collect()
        };
        let measured = slopes(&data.rows);
        let mut precision = DMatrix::zeros(own.len() + 1, own.len() + 1);
        for (k, &at) in own.iter().enumerate() {
            precision[(k, k)] = learned[at].std.powi(-2);
        }
        for slope in measured.iter().flat_map(|row| &row[..MEASURED]) {
            precision += slope * slope.transpose() / (NOISE * NOISE);
        }
        let free = precision.clone().try_inverse().unwrap();
        let held = precision.view((0, 0), (own.len(), own.len())).into_owned();
        let held = held.try_inverse().unwrap();
        let expected = |rows: &[Row], mode: usize| -> f64 {
            let added = slopes(rows).into_iter().map(|row| {
                let slope = &row[mode];
                let inside = slope.rows(0, own.len());
                slope.dot(&(&free * slope)) - inside.dot(&(&held * inside))
            });
            let added: Vec<f64> = added.collect();
            (added.iter().sum::<f64>() / added.len() as f64).sqrt()
        };
        assert_eq!(found.near[0], 0.0);
        let far = anywhere(&robot, &data, FAR);
        for mode in 0..modes {
            let is_same = |found: f64, expected: f64| {
                assert!((found / expected - 1.0).abs() < 0.05, "{mode}: {found} {expected}");
            };
            is_same(found.far[mode], expected(&far, mode));
            if mode >= MEASURED {
                is_same(found.near[mode], expected(&near(&data), mode));
            }
        }
    }
}
