//! Damping of joints from measured damping ratios: each mode loses what its springs lose, in
//! proportion to their shares of its strain energy (Ungar & Kerwin, J. Acoust. Soc. Am. 34, 1962).
//! By linear least squares about what the file says.

use nalgebra::{DMatrix, DVector};

use super::data::Data;
use super::fit::Fit;
use super::mechanics::Mechanics;
use super::outcome::LearnedDamping;
use super::predict::participation;
use super::problem::Problem;
use crate::model::Damping;
use crate::statistics::{median, rms};

/// What the file says may be off by this factor either way, about: few measure damping.
const PRIOR: f64 = 1.0;

/// Damping ratios of one table agree within this share at best.
const MIN_NOISE: f64 = 0.1;

/// A joint is learned where the data leave less than this share of what was open.
const INFORMED: f64 = 0.5;

/// No joint is known to lose less.
const LEAST: f64 = 1e-4;

/// The joints whose damping the table tells, in the order of the elastic coordinates.
pub(super) fn damping(problem: &Problem<'_>, fit: &Fit<'_>) -> Vec<LearnedDamping> {
    learned(problem, fit).unwrap_or_default()
}

fn learned(problem: &Problem<'_>, fit: &Fit<'_>) -> Option<Vec<LearnedDamping>> {
    let Data { rows, points, .. } = problem.data;
    let measured = || {
        let of_point = |point: &super::data::Point| {
            Some((*point, rows[point.row].damping.get(point.column).copied().flatten()?))
        };
        points.iter().filter_map(of_point)
    };
    let typical = median(measured().map(|(_, zeta)| zeta).collect())?;
    let mut here = Mechanics::new(problem.description, &fit.hypothesis.corrections(), rows)?;
    let energies = participation(&mut here, problem.data)?;
    let coordinates = here.robot(rows.first()?)?.coordinates();
    let told: Vec<f64> = coordinates
        .iter()
        .map(|coordinate| match coordinate.damping {
            Damping::Ratio(zeta) => zeta,
            Damping::Viscous(_) => problem.description.default_damping_ratio,
        })
        .collect();
    let joints: Vec<usize> = (0..told.len()).filter(|&i| coordinates[i].joint.is_some()).collect();
    let shares: Vec<(Vec<f64>, f64)> = measured()
        .filter_map(|(point, zeta)| {
            let parts = energies[point.row].get(point.column)?;
            let whole: f64 = parts.iter().map(|[strain, _]| strain).sum();
            let share = |i: usize| parts[i][0] / whole;
            let expected: f64 = (0..told.len()).map(|i| share(i) * told[i]).sum();
            let own = joints.iter().map(|&i| share(i)).collect();
            (whole > 0.0).then_some((own, zeta - expected))
        })
        .collect();
    let p = joints.len();
    let precision: Vec<f64> =
        joints.iter().map(|&i| (PRIOR * told[i].max(typical)).powi(-2)).collect();
    let solved = |noise: f64| {
        let mut information = DMatrix::from_diagonal(&DVector::from_column_slice(&precision));
        let mut along = DVector::zeros(p);
        for (own, left) in &shares {
            let own = DVector::from_column_slice(own);
            information.ger(noise.powi(-2), &own, &own, 1.0);
            along.axpy(left / noise.powi(2), &own, 1.0);
        }
        let covariance = information.try_inverse()?;
        Some((&covariance * along, covariance))
    };
    let least = MIN_NOISE * typical;
    let mut noise = least;
    // The noise follows from what is left.
    for _ in 0..5 {
        let (moved, _) = solved(noise)?;
        let left = shares.iter().map(|(own, left)| {
            left - own.iter().zip(moved.iter()).map(|(share, by)| share * by).sum::<f64>()
        });
        let freedom = (shares.len() as f64 - p as f64).max(1.0);
        noise = (rms(left) * (shares.len() as f64 / freedom).sqrt()).max(least);
    }
    let (moved, covariance) = solved(noise)?;
    let learned = joints.iter().enumerate().filter_map(|(k, &i)| {
        let std = covariance[(k, k)].sqrt();
        let is_informed = std * precision[k].sqrt() < INFORMED;
        is_informed.then(|| LearnedDamping {
            joint: coordinates[i].name.clone(),
            damping_ratio: (told[i] + moved[k]).clamp(LEAST, 0.99),
            std,
        })
    });
    Some(learned.collect())
}

#[cfg(test)]
mod tests {
    use super::super::fit::tests::{arm, data};
    use super::super::hypothesis::Hypothesis;
    use super::*;
    use crate::model::ElasticJoint;
    use crate::model::Robot;
    use crate::modes::Modes;

    /// Against the damping that the modal solver gives joints of known damping.
    #[test]
    fn joints_lose_what_their_modes_lose() {
        let damped = [0.01, 0.06, 0.03];
        let mut lossy = arm();
        let spring = |(joint, zeta): (&ElasticJoint, f64)| ElasticJoint {
            damping: Some(Damping::Ratio(zeta)),
            ..joint.clone()
        };
        lossy.elastic_joints = lossy.elastic_joints.iter().zip(damped).map(spring).collect();
        let robot = Robot::new(&lossy).unwrap();
        let mut data = data(8);
        for row in &mut data.rows {
            let modes = Modes::at(&robot, &row.q).unwrap();
            row.damping = modes.damping_ratios.iter().map(|zeta| Some(*zeta)).collect();
        }
        let description = arm();
        let problem = Problem { description: &description, data: &data };
        let fit = problem.optimise(Hypothesis::default()).unwrap();
        let found = damping(&problem, &fit);
        assert_eq!(found.len(), 3);
        for (found, expected) in found.iter().zip(damped) {
            let error = (found.damping_ratio - expected).abs();
            assert!(error < 0.03 * expected, "{found:?} {expected}");
        }
        data.rows.iter_mut().for_each(|row| row.damping.clear());
        assert!(damping(&Problem { description: &description, data: &data }, &fit).is_empty());
    }
}
