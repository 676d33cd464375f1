//! What a table teaches about all numbers of the model, beside the causes: a normal posterior of
//! the springs, links and drives about the model with its corrections, and what it leaves
//! unexplained, by poses left out.
//!
//! Gauss–Newton on r − A δ with the prior Σ₀, Σ = (Σ₀⁻¹ + Aᵀ W A)⁻¹; parameters that the data do
//! not reach keep their prior.

use nalgebra::{DMatrix, DVector};

use super::data::{Data, Row};
use super::fit::Fit;
use super::likelihood::noise;
use super::mechanics::Mechanics;
use super::problem::Problem;
use crate::model::{
    Calibration, Cause, Correction, Description, LearnedParameter, ParameterKind, Posterior, Robot,
    Unexplained, distance,
};
use crate::modes::Pencil;
use crate::statistics::median;
use crate::uncertainty::{ArmAtPose, all, scales_of, states_all, uncalibrated_std_ln};
use crate::units::hz_from_rad_per_s;

/// Prior of what a correction fitted, or added: the data alone speak.
const STD_OF_CORRECTED: f64 = 1.0;

/// Steps of Gauss–Newton: springs off by 15 % leave 1e-5 of ln f after three.
const STEPS: usize = 4;

/// Least standard deviation of ln f that stays unexplained of a mode that nobody measured: half of
/// what is assumed of an uncalibrated model.
const UNMEASURED: f64 = 0.025;

/// Blocks of neighbouring poses that are left out together.
const BLOCKS: usize = 4;

/// Points and their linear model at some value of the parameters.
struct Linear {
    /// The points, by their place among those of the data.
    points: Vec<usize>,
    /// Tests of the points, see [`Data::tests`].
    tests: Vec<usize>,
    columns: Vec<usize>,
    residuals: DVector<f64>,
    /// One row a point.
    slopes: DMatrix<f64>,
    /// Variance of each point.
    variances: DVector<f64>,
    /// θ at which it holds.
    theta: DVector<f64>,
    prior: DVector<f64>,
}

/// The mean and covariance that some of the points give.
struct Normal {
    /// From θ of the linear model.
    step: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// A posterior, and what the robot predicts with its means.
pub(super) struct Calibrated {
    pub(super) posterior: Posterior,
    /// ln of the frequency in Hz, one a point; `None` where it was not compared.
    pub(super) ln_hz: Vec<Option<f64>>,
    /// ln of the evidence for the model, by Laplace's approximation, without what its causes cost.
    pub(super) ln_evidence: f64,
}

/// The posterior of a robot with the causes that were chosen; `None` where the model has no modes
/// at a row.
pub(super) fn posterior(problem: &Problem<'_>, chosen: &Fit<'_>) -> Option<Calibrated> {
    let corrections = chosen.hypothesis.corrections();
    let mut learned = prior(problem.description, &corrections)?;
    let instrument = of_instrument(chosen);
    let mut last = None;
    for _ in 0..STEPS {
        let linear = linear(problem, &corrections, &learned, &instrument)?;
        let normal = linear.given(|_| true)?;
        let theta = &linear.theta + &normal.step;
        for (one, theta) in learned.iter_mut().zip(theta.iter()) {
            one.ln = *theta;
        }
        last = Some(normal);
    }
    for one in &mut learned {
        one.ln = rounded(one.ln);
    }
    let linear = linear(problem, &corrections, &learned, &instrument)?;
    let mut ln_hz = vec![None; problem.data.points.len()];
    for (&at, residual) in linear.points.iter().zip(linear.residuals.iter()) {
        ln_hz[at] = Some(problem.data.points[at].ln_f - residual);
    }
    // Where nothing is stated of a spring, a link or a drive, a mode that nobody measured is not
    // better known than before.
    let robot = Robot::new(problem.description).ok()?;
    let least = if states_all(&robot) { UNMEASURED } else { uncalibrated_std_ln() };
    let unexplained = unexplained(problem.data, &linear, robot.coordinates().len(), least)?;
    let last = last?;
    let ln_evidence = linear.ln_evidence(&last);
    let covariance = last.covariance;
    let std: Vec<f64> = (0..learned.len()).map(|i| covariance[(i, i)].max(0.0).sqrt()).collect();
    let correlation = |i: usize, j: usize| {
        let scale = std[i] * std[j];
        if scale > 0.0 { (covariance[(i, j)] / scale).clamp(-1.0, 1.0) } else { 0.0 }
    };
    let correlation =
        (0..learned.len()).map(|i| (0..i).map(|j| rounded(correlation(i, j))).collect()).collect();
    let parameters = learned
        .into_iter()
        .zip(std)
        .map(|(one, std)| LearnedParameter { std: rounded(std), ..one })
        .collect();
    let posterior = Posterior { parameters, correlation, unexplained };
    Some(Calibrated { posterior, ln_hz, ln_evidence })
}

/// Six decimals: what is written is read again as it was.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Every parameter of the corrected robot, with its prior.
fn prior(description: &Description, corrections: &[Correction]) -> Option<Vec<LearnedParameter>> {
    let plain = Robot::new(description).ok()?;
    let mut corrected = description.clone();
    corrected.corrections.extend_from_slice(corrections);
    let robot = Robot::new(&corrected).ok()?;
    let is_corrected = |kind: ParameterKind, at: &str| {
        let by = |cause: Cause| {
            corrections.iter().any(|c| c.cause == cause && c.at.as_deref() == Some(at))
        };
        match kind {
            ParameterKind::Spring => {
                by(Cause::JointStiffness) || scales_of(&plain, kind, at).is_none()
            }
            ParameterKind::Link => by(Cause::LinkInertia),
            ParameterKind::Drive => by(Cause::DriveInertia),
        }
    };
    let one = |parameter: &crate::uncertainty::Parameter| {
        let (kind, at) = parameter.place(&robot);
        let std = if is_corrected(kind, at) { STD_OF_CORRECTED } else { parameter.std };
        LearnedParameter { kind, at: at.to_owned(), ln: 0.0, std }
    };
    Some(all(&robot).iter().map(one).collect())
}

/// Per column of the table, whether the instrument shows it otherwise than the arm has it.
fn of_instrument(chosen: &Fit<'_>) -> impl Fn(usize) -> bool + use<> {
    let effects = chosen.hypothesis.effects.iter();
    let modes: Vec<(Cause, usize)> = effects
        .filter(|(candidate, _)| candidate.cause.is_of_the_instrument())
        .filter_map(|(candidate, _)| {
            let mode: usize = candidate.at.as_deref()?.parse().ok()?;
            Some((candidate.cause, mode.checked_sub(1)?))
        })
        .collect();
    // An aliased frequency may stand in any column; where a mode is missed the next ones move up.
    move |column| {
        modes.iter().any(|&(cause, mode)| match cause {
            Cause::MissedMode => column >= mode,
            _ => true,
        })
    }
}

/// Residuals and slopes of the points at the parameters as learned so far.
fn linear(
    problem: &Problem<'_>,
    corrections: &[Correction],
    learned: &[LearnedParameter],
    instrument: &impl Fn(usize) -> bool,
) -> Option<Linear> {
    let Problem { description, data } = *problem;
    let here = Posterior { parameters: learned.to_vec(), ..Posterior::default() };
    let description = Description {
        calibration: Some(Calibration {
            poses: 0,
            heldout_rms_percent: 0.0,
            posterior: Some(here),
        }),
        ..description.clone()
    };
    let mut mechanics = Mechanics::new(&description, corrections, &data.rows)?;
    let tests = data.tests();
    let mut pencil = Pencil::new(mechanics.mass.nrows());
    let (mut points, mut places) = (Vec::new(), Vec::new());
    let (mut residuals, mut slopes) = (Vec::new(), Vec::new());
    for (i, row) in data.rows.iter().enumerate() {
        let arm = arm(&mut mechanics, row, learned)?;
        if !pencil.solve(&mechanics.mass, &mechanics.stiffness) {
            return None;
        }
        for (at, point) in data.points.iter().enumerate().filter(|(_, point)| point.row == i) {
            let omega_squared = pencil.omega_squared.get(point.column).copied();
            let Some(omega_squared) = omega_squared.filter(|o| o.is_finite()) else { continue };
            if instrument(point.column) {
                continue;
            }
            residuals.push(point.ln_f - hz_from_rad_per_s(omega_squared.sqrt()).ln());
            let shape = pencil.shapes.column(point.column);
            slopes.push(arm.slopes(shape.as_slice(), omega_squared));
            points.push(*point);
            places.push(at);
        }
    }
    let some: Vec<Option<f64>> = residuals.iter().copied().map(Some).collect();
    let scale = noise(&points, &some).scale;
    let taken = effective(&slopes, learned, scale);
    // The scale of the residuals is that of the noise for the degrees of freedom that remain.
    let count = points.len() as f64;
    let inflation = count / (count - taken).max(1.0);
    let variance = |p: &super::data::Point| inflation * (scale * p.unit).powi(2) + p.rounding;
    let columns = slopes.iter().map(DVector::transpose).collect::<Vec<_>>();
    Some(Linear {
        points: places,
        tests: points.iter().map(|point| tests[point.row]).collect(),
        columns: points.iter().map(|point| point.column).collect(),
        slopes: if columns.is_empty() {
            DMatrix::zeros(0, learned.len())
        } else {
            DMatrix::from_rows(&columns)
        },
        variances: DVector::from_iterator(points.len(), points.iter().map(variance)),
        residuals: DVector::from_vec(residuals),
        theta: DVector::from_iterator(learned.len(), learned.iter().map(|one| one.ln)),
        prior: DVector::from_iterator(learned.len(), learned.iter().map(|one| one.std.powi(2))),
    })
}

/// Degrees of freedom that the parameters take at a level of noise.
fn effective(slopes: &[DVector<f64>], learned: &[LearnedParameter], scale: f64) -> f64 {
    let p = learned.len();
    let mut information = DMatrix::zeros(p, p);
    for slope in slopes {
        information += slope * slope.transpose() / scale.powi(2);
    }
    let prior = DVector::from_iterator(p, learned.iter().map(|one| one.std.powi(-2)));
    let whole = &information + DMatrix::from_diagonal(&prior);
    whole.cholesky().map_or(0.0, |factor| factor.solve(&information).trace())
}

fn arm(mechanics: &mut Mechanics, row: &Row, learned: &[LearnedParameter]) -> Option<ArmAtPose> {
    mechanics.place(row)?;
    let robot = mechanics.robot(row)?;
    let scales = learned.iter().map(|one| scales_of(robot, one.kind, &one.at));
    let both = [mechanics.mass.clone(), mechanics.stiffness.clone()];
    Some(ArmAtPose::placed(robot, mechanics.placement(), &row.conditions, scales, both))
}

impl Linear {
    /// ln of the evidence at the mean, without constants.
    fn ln_evidence(&self, normal: &Normal) -> f64 {
        let points = self.residuals.iter().zip(self.variances.iter());
        let misfit: f64 = points.map(|(r, v)| r * r / v + v.ln()).sum();
        let prior: f64 =
            self.theta.iter().zip(self.prior.iter()).map(|(t, v)| t * t / v + v.ln()).sum();
        let volume = normal.covariance.clone().cholesky().map_or(0.0, |l| l.ln_determinant());
        -0.5 * (misfit + prior - volume)
    }

    /// What the points for which `keep` holds give.
    fn given(&self, keep: impl Fn(usize) -> bool) -> Option<Normal> {
        let p = self.theta.len();
        let mut information = DMatrix::from_diagonal(&self.prior.map(|variance| 1.0 / variance));
        let mut pull = -self.theta.component_div(&self.prior);
        for i in (0..self.residuals.len()).filter(|&i| keep(i)) {
            let slope = self.slopes.row(i).transpose();
            pull += &slope * (self.residuals[i] / self.variances[i]);
            information += &slope * slope.transpose() / self.variances[i];
        }
        let factor = information.cholesky()?;
        Some(Normal {
            step: factor.solve(&pull),
            covariance: factor.solve(&DMatrix::identity(p, p)),
        })
    }

    /// Per point that a group leaves out: its error, squared, less the variance that the parameters
    /// let expect.
    fn excess(&self, groups: &[usize]) -> Option<Vec<f64>> {
        let mut found = vec![0.0; groups.len()];
        let most = groups.iter().copied().max().unwrap_or(0);
        for group in 0..=most {
            let normal = self.given(|i| groups[i] != group)?;
            for i in (0..groups.len()).filter(|&i| groups[i] == group) {
                let slope = self.slopes.row(i).transpose();
                let error = self.residuals[i] - slope.dot(&normal.step);
                let expected = slope.dot(&(&normal.covariance * &slope));
                found[i] = error * error - expected;
            }
        }
        Some(found)
    }
}

/// What the parameters leave, mode by mode: by tests left out one at a time, and by blocks of
/// neighbouring poses.
fn unexplained(data: &Data, linear: &Linear, modes: usize, least: f64) -> Option<Unexplained> {
    let poses = distinct(data);
    let blocks = blocks(data);
    let near = linear.excess(&linear.tests)?;
    let of_block: Vec<usize> = linear.tests.iter().map(|&test| blocks[test]).collect();
    let far = linear.excess(&of_block)?;
    let of_mode = |excess: &[f64], column: usize| -> Option<f64> {
        // The noise of the table counts as an error of the model: an effect that the model lacks
        // hides in it.
        let own = (0..excess.len()).filter(|&i| linear.columns[i] == column).map(|i| excess[i]);
        let (count, sum) = own.fold((0.0, 0.0), |(count, sum), own| (count + 1.0, sum + own));
        (count > 0.0).then(|| (sum / count).max(0.0_f64).sqrt())
    };
    let per_mode: Vec<Option<(f64, f64)>> =
        (0..modes).map(|r| Some((of_mode(&near, r)?, of_mode(&far, r)?))).collect();
    // What was not measured is not better known than the worst that was, far from the data, and
    // may hold what the measured modes do not show.
    let worst = per_mode.iter().flatten().fold(least, |worst, (n, f)| worst.max(*n).max(*f));
    let shares = per_mode.iter().map(|own| own.map_or((worst, worst), |(n, f)| (n, n.max(f))));
    let (near, far): (Vec<f64>, Vec<f64>) =
        shares.map(|(near, far)| (rounded(near), rounded(far))).unzip();
    Some(Unexplained { near, far, reach: rounded(reach(&poses)), poses })
}

/// The poses of the tests, to a millionth of a rad or m.
fn distinct(data: &Data) -> Vec<Vec<f64>> {
    let mut poses: Vec<Vec<f64>> = Vec::new();
    for row in &data.rows {
        let q: Vec<f64> = row.q.iter().copied().map(rounded).collect();
        if !poses.contains(&q) {
            poses.push(q);
        }
    }
    poses
}

/// Median distance of a pose to the nearest other.
fn reach(poses: &[Vec<f64>]) -> f64 {
    /// Poses closer than this, rad or m, are one.
    const LEAST: f64 = 0.01;
    let nearest = |(i, pose): (usize, &Vec<f64>)| {
        let others = poses.iter().enumerate().filter(move |(j, _)| *j != i);
        others.map(|(_, other)| distance(pose, other)).fold(f64::INFINITY, f64::min)
    };
    let nearest: Vec<f64> =
        poses.iter().enumerate().map(nearest).filter(|apart| apart.is_finite()).collect();
    median(nearest).unwrap_or(LEAST).max(LEAST)
}

/// Per test, its block: tests in the order of the joint that moves most, cut into equal parts.
fn blocks(data: &Data) -> Vec<usize> {
    let tests = data.tests();
    let count = data.test_count();
    let joints = data.rows.first().map_or(0, |row| row.q.len());
    let spread = |joint: usize| {
        let values = data.rows.iter().map(|row| row.q[joint]);
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), q| (l.min(q), h.max(q)));
        high - low
    };
    let widest = (0..joints).max_by(|&a, &b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
    let mut place = vec![0.0; count];
    for (row, &test) in data.rows.iter().zip(&tests) {
        place[test] = row.q.get(widest).copied().unwrap_or(0.0);
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| place[a].total_cmp(&place[b]));
    let mut block = vec![0; count];
    for (i, &test) in order.iter().enumerate() {
        block[test] = i * BLOCKS / count.max(1);
    }
    block
}
