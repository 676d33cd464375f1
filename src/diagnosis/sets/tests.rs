//! The linear problem against a singular value decomposition, sets against what was put in.

use super::super::arm::Arm;
use super::super::causes::candidates;
use super::super::fit::tests::{arm, data};
use super::*;
use crate::model::{Cause, Robot};

fn noise(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43758.5453;
    x - x.floor() - 0.5
}

/// A candidate of one parameter of either sign, and one that is expected near zero.
fn candidate(cause: Cause, at: &str, second: bool) -> Candidate {
    let parameter = |expected: Option<[f64; 2]>| Parameter {
        name: "p",
        scale: Scale::Linear(1.0),
        nominal: Some(0.0),
        bounds: [-10.0, 10.0],
        starts: vec![1.0],
        expected,
    };
    let mut parameters = vec![parameter(None)];
    if second {
        parameters.push(parameter(Some([0.3, 0.5])));
    }
    Candidate::new(cause, at, parameters)
}

/// Coefficients and squares of sets of columns, against the whole matrix with what is expected as
/// further rows.
#[test]
fn sets_are_solved_as_a_decomposition_solves_them() {
    let points = 30;
    let known: Vec<Candidate> =
        (0..4).map(|i| candidate(Cause::JointStiffness, &format!("j{i}"), i % 2 == 1)).collect();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut expected = Vec::new();
    let mut members = Vec::new();
    for (i, candidate) in known.iter().enumerate() {
        let first_column = columns.len();
        for k in 0..candidate.parameters.len() {
            columns.push((0..points).map(|j| noise(1 + j + 97 * (first_column + k))).collect());
            let [mean, spread] = candidate.parameters[k].expected.unwrap_or([0.0, f64::INFINITY]);
            expected.push([spread.powi(-2), mean]);
        }
        let at = vec![1.0; candidate.parameters.len()];
        members.push(Member { candidate, at, first_column, columns: 1 + i % 2 });
    }
    let rest: Vec<f64> = (0..points).map(|j| noise(5000 + j)).collect();
    let weights: Vec<f64> = (0..points).map(|j| 1.0 + noise(9000 + j)).collect();
    let linear = Linear::of(members, &columns, expected.clone(), &rest, &weights);
    for set in [vec![0], vec![1], vec![0, 3], vec![1, 2, 3], vec![0, 1, 2, 3]] {
        // Whichever member comes last.
        let last = set[set.len() / 2];
        let others = set.iter().copied().filter(|&i| i != last).collect();
        let others = TrialSet::of(others);
        let tried =
            linear.with_one_more(&others).into_iter().find(|own| own.members == set).unwrap();
        let own: Vec<usize> = set
            .iter()
            .flat_map(|&i| {
                let member = &linear.members[i];
                member.first_column..member.first_column + member.columns
            })
            .collect();
        let rows = points + own.len();
        let entry = |row: usize, a: usize| {
            if row < points {
                columns[own[a]][row] * weights[row].sqrt()
            } else if row - points == a {
                expected[own[a]][0].sqrt()
            } else {
                0.0
            }
        };
        let matrix = DMatrix::from_fn(rows, own.len(), entry);
        let target = DVector::from_fn(rows, |row, _| {
            if row < points {
                rest[row] * weights[row].sqrt()
            } else {
                let [precision, mean] = expected[own[row - points]];
                precision.sqrt() * mean
            }
        });
        let solution = matrix.clone().svd(true, true).solve(&target, 1e-12).unwrap();
        let coefficients = linear.coefficients(&tried).unwrap();
        assert_eq!(coefficients.len(), own.len());
        for (a, b) in coefficients.iter().zip(solution.iter()) {
            assert!((a - b).abs() < 1e-6, "{set:?} {a} {b}");
        }
        // Of what is left, the part of the data alone stands in the likelihood.
        let left = (&matrix * &solution - &target).rows(0, points).norm_squared();
        let penalty: f64 = own
            .iter()
            .zip(solution.iter())
            .map(|(&i, c)| expected[i][0] * (c - expected[i][1]).powi(2))
            .sum();
        let free: f64 = own
            .iter()
            .map(|&i| {
                let own: f64 = (0..points).map(|j| weights[j] * columns[i][j].powi(2)).sum();
                own / (own + expected[i][0])
            })
            .sum();
        let n = points as f64;
        let log_evidence = -0.5 * n * (left / n).ln() - 0.5 * penalty - 0.5 * free * n.ln();
        assert!(
            (tried.log_evidence - log_evidence).abs() < 1e-6,
            "{set:?} {} {log_evidence}",
            tried.log_evidence
        );
    }
}

/// Three causes of which the first to be found alone is none: the set is among the first, with its
/// parameters.
#[test]
fn three_causes_are_found_together() {
    let description = arm();
    let mut data = data(16);
    let robot = Robot::new(&description).unwrap();
    let of = |cause: Cause, at: &str, parameters: usize, all: &[Candidate]| -> usize {
        let is = |c: &Candidate| {
            c.cause == cause && c.at.as_deref() == Some(at) && c.parameters.len() == parameters
        };
        all.iter().position(is).unwrap()
    };
    let all = candidates(&Arm::new(&description, &robot, &data).unwrap());
    let truth = [
        of(Cause::JointStiffness, "j2", 1, &all),
        of(Cause::DriveInertia, "j3", 1, &all),
        of(Cause::TemperatureDrift, "j3", 1, &all),
    ];
    let values = [1.85e5, 0.15, -0.004];
    let effects = truth
        .iter()
        .zip(values)
        .map(|(&which, value)| (&all[which], vec![all[which].parameters[0].inner(value)]))
        .collect();
    let problem = Problem { description: &description, data: &data };
    let seen = problem.compare(&Hypothesis { effects }).unwrap().left.residuals;
    for (i, (point, residual)) in data.points.iter_mut().zip(seen).enumerate() {
        point.ln_f += 0.004 * noise(i) - residual.unwrap();
    }
    let problem = Problem { description: &description, data: &data };
    let screen = Screen::new(&problem, &all).unwrap();
    let baseline = problem.optimise(Hypothesis::default()).unwrap();
    let found = sets(&problem, &all, &screen, &baseline, 3, 10);
    let place = found.iter().position(|set| {
        truth.iter().all(|&which| set.effects.iter().any(|(c, _)| c.same_place(&all[which])))
    });
    assert!(place.is_some_and(|place| place < 5), "{place:?}");
    // Near the model with the right causes the parameters come out as they are.
    let near = problem.optimise(found[place.unwrap()].clone()).unwrap();
    let first = &sets(&problem, &all, &screen, &near, 3, 1)[0];
    for (&which, value) in truth.iter().zip(values) {
        let (candidate, inner) =
            first.effects.iter().find(|(c, _)| c.same_place(&all[which])).unwrap();
        let found = candidate.parameters[0].value(inner[0]);
        assert!((found / value - 1.0).abs() < 0.05, "{} {found} {value}", candidate.cause);
    }
}
