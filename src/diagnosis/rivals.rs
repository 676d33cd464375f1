//! How far frequencies that nobody measured differ between models that the table cannot tell apart.
//!
//! The springs and masses of one model with its causes have a posterior; which causes they are, and
//! how large each is, it takes for sure. Every rival, and every cause a standard deviation larger
//! or smaller, is calibrated by the table, too, and what its frequencies differ by, weighed by the
//! evidence for it, is left unexplained by the one that was chosen. Against the model without
//! causes, the evidence is that with the springs, links and drives free within what is stated of
//! them: where these explain the table by themselves, causes that are named as if all numbers were
//! exact have no weight.
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
use super::posterior::{Means, cost, covariance_of_causes, means, predicted, rounded};
use super::problem::Problem;
use crate::model::{Robot, Unexplained};

/// Rivals that are calibrated, the likeliest first.
const MOST_RIVALS: usize = 12;

/// Share of a difference of ln evidence that counts: the sizes of a rival's causes were fitted with
/// all other numbers held, so that its evidence is a lower bound.
const OF_DIFFERENCE: f64 = 0.5;

/// Poses at which models are compared: of the table at most so many,
const MOST_NEAR: usize = 24;

/// and so many anywhere.
const FAR: u32 = 48;

/// `unexplained` with what rivals of `chosen` differ by, mode by mode, at poses like those of the
/// table and anywhere, `seen` being the models that were met among so many `candidates`; `None`
/// where `chosen` has no modes at some pose.
pub(super) fn widened_by_rivals(
    problem: &Problem<'_>,
    robot: &Robot,
    chosen: &Fit<'_>,
    seen: &[Model<'_>],
    candidates: usize,
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
    // Causes stand against each other by their own evidence, and the chosen ones count as much as
    // the best of their rivals. The model without any stands against them by what the stated
    // numbers explain.
    let has_causes = !chosen.hypothesis.effects.is_empty();
    let with_free_numbers = |fit: &Fit<'_>, means: &Means| {
        OF_DIFFERENCE * (means.ln_evidence - cost(problem.data, fit, candidates))
    };
    let learned = means(problem, chosen)?;
    let own = at_poses(chosen, &learned)?;
    let mut rivals = distinct_from(chosen, seen);
    rivals.truncate(MOST_RIVALS);
    let rivals: Vec<(f64, Vec<Vec<f64>>)> = rivals
        .par_iter()
        .filter_map(|rival| {
            let means = means(problem, &rival.fit)?;
            let ln_weight = match has_causes {
                true => rival.log_evidence,
                false => with_free_numbers(&rival.fit, &means),
            };
            Some((ln_weight, at_poses(&rival.fit, &means)?))
        })
        .collect();
    let best_of = |least: f64| rivals.iter().fold(least, |best, (weight, _)| best.max(*weight));
    let of_own = match has_causes {
        true => best_of(f64::MIN),
        false => with_free_numbers(chosen, &learned),
    };
    let best = best_of(of_own);
    let share = |ln_weight: f64| (ln_weight - best).exp();
    let whole = share(of_own) + rivals.iter().map(|(ln_weight, _)| share(*ln_weight)).sum::<f64>();
    let rivals = rivals.into_iter().map(|(ln_weight, ln_hz)| (share(ln_weight) / whole, ln_hz));
    let moved = covariance_of_causes(problem, chosen, &learned)
        .map_or_else(Vec::new, |covariance| moved(problem, chosen, &learned, covariance));
    // Both ends of an axis, each half.
    let moved = moved.iter().filter_map(|(fit, means)| Some((0.5, at_poses(fit, means)?)));
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
/// their parameters, or as far as the table lets them: a parameter that acts by its square has no
/// slope at zero, and its covariance says nothing.
fn moved<'c>(
    problem: &Problem<'_>,
    chosen: &Fit<'c>,
    learned: &Means,
    covariance: DMatrix<f64>,
) -> Vec<(Fit<'c>, Means)> {
    /// A standard deviation costs 0.5 of ln evidence; more than this is no standard deviation.
    const MOST_LOST: f64 = 2.0;
    const MOST_HALVINGS: usize = 20;
    let axes = SymmetricEigen::new(covariance);
    let inner = chosen.hypothesis.inner();
    let parameters = chosen.hypothesis.effects.iter().flat_map(|(c, _)| &c.parameters);
    let parameters: Vec<&Parameter> = parameters.collect();
    let at = |axis: usize, reach: f64| {
        let axis = axes.eigenvectors.column(axis);
        let moved = inner.iter().zip(axis.iter()).zip(&parameters).map(|((own, part), one)| {
            if *part == 0.0 { *own } else { one.clamp(own + reach * part) }
        });
        let moved: Vec<f64> = moved.collect();
        Fit { hypothesis: chosen.hypothesis.with(&moved), ..chosen.clone() }
    };
    let within_reach = |&(axis, reach): &(usize, f64)| {
        let shorter = std::iter::successors(Some(reach), |reach| Some(0.5 * reach));
        shorter.take(MOST_HALVINGS).find_map(|reach| {
            let fit = at(axis, reach);
            let means = means(problem, &fit)?;
            (means.ln_evidence >= learned.ln_evidence - MOST_LOST).then_some((fit, means))
        })
    };
    let ends = axes.eigenvalues.iter().enumerate().filter(|(_, variance)| **variance > 0.0);
    let ends = ends.flat_map(|(axis, variance)| [-1.0, 1.0].map(|s| (axis, s * variance.sqrt())));
    let ends: Vec<(usize, f64)> = ends.collect();
    ends.par_iter().filter_map(within_reach).collect()
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

    /// A table of a softer spring: the model without causes whose numbers may be off by that much,
    /// and a rival that has a mass moved instead.
    fn widened_by_a_moved_mass(std: f64) -> Unexplained {
        let mut description = arm();
        description.elastic_joints.iter_mut().for_each(|one| one.std = Some(std));
        description.links.iter_mut().for_each(|one| one.std = Some(std));
        let mut truth = description.clone();
        truth.elastic_joints[2].stiffness *= 0.8;
        let mut data = data(14);
        data.stated_noise = Some(NOISE);
        data.points.retain(|point| point.column < MEASURED);
        for row in &mut data.rows {
            row.conditions = Conditions::default();
        }
        let exact = predicted(&truth, &[], &[], &data.rows).unwrap();
        for point in &mut data.points {
            point.ln_f = exact[point.row][point.column];
        }
        let problem = Problem { description: &description, data: &data };
        let plain = problem.optimise(Hypothesis::default()).unwrap();
        let candidate = moved_mass();
        let moved = problem.optimise(Hypothesis { effects: vec![(&candidate, vec![1.2])] });
        let rivals = [Model { fit: moved.unwrap(), log_evidence: 0.0 }];
        let mut found = Unexplained { near: vec![0.0; 3], far: vec![0.0; 3], ..Default::default() };
        let robot = Robot::new(&description).unwrap();
        widened_by_rivals(&problem, &robot, &plain, &rivals, 40, &mut found).unwrap();
        found
    }

    /// Where numbers that may be off explain the table, a cause in their place hardly counts; where
    /// they are said to be all but exact, it does.
    #[test]
    fn a_rival_counts_by_what_the_stated_numbers_leave_of_it() {
        let largest = |of: Unexplained| of.far.into_iter().fold(0.0, f64::max);
        let (free, held) = (widened_by_a_moved_mass(0.2), widened_by_a_moved_mass(1e-3));
        let (free, held) = (largest(free), largest(held));
        assert!(free < 0.002, "{free}");
        assert!(held > 0.01, "{held}");
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
        widened_by_rivals(&problem, &robot, &chosen, &[], 1, &mut found).unwrap();

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
