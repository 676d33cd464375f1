//! What a table teaches about all numbers of the model, beside the causes: a normal posterior of
//! the springs, links and drives about the model with its corrections, and what it leaves
//! unexplained, by poses left out.
//!
//! Gauss–Newton on r − A δ with the prior Σ₀, Σ = (Σ₀⁻¹ + Aᵀ W A)⁻¹; parameters that the data do
//! not reach keep their prior. The means are those of the model without what it lacks. How large
//! the noise is, and the compliances that the model lacks, is not known: their levels are weighed
//! by the evidence for each, and Σ is the second moment of all of them about the means. So what
//! springs and masses may have taken from a foundation that gives counts as uncertainty of both.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::candidate::{Candidate, Parameter as CauseParameter};
use super::centred::centred;
use super::data::{Data, Row};
use super::fit::Fit;
use super::likelihood::MIN_NOISE;
use super::mechanics::Mechanics;
use super::problem::Problem;
use crate::model::{
    Calibration, Cause, Correction, Description, Fingerprint, LearnedParameter, ParameterKind,
    Posterior, Robot, Unexplained, distance,
};
use crate::modes::Pencil;
use crate::statistics::median;
use crate::uncertainty::{
    ArmAtPose, Parameter, all, lacking, scales_of, states_all, uncalibrated_std_ln,
};
use crate::units::hz_from_rad_per_s;

/// Prior of what a correction fitted, or added: the data alone speak.
const STD_OF_CORRECTED: f64 = 1.0;

/// Steps of Gauss–Newton: springs off by 15 % leave 1e-5 of ln f after three.
const STEPS: usize = 6;

/// Farthest that a parameter goes in one step, standard deviations of its prior.
const FARTHEST: f64 = 1.5;

/// Standard deviations of each compliance that the model lacks, against the spring that it is
/// compared with, and how probable they are beforehand: the model lacks something or not, as it may
/// be.
const LACKING: [(f64, f64); 5] =
    [(0.0, 0.5), (0.003, 0.125), (0.01, 0.125), (0.03, 0.125), (0.1, 0.125)];

/// From one level of noise to the next.
const PER_LEVEL: f64 = 1.5;

/// The largest noise of a table, share of the frequency.
const MAX_NOISE: f64 = 0.1;

/// Standard deviation of ln f of a mode that nobody measured, beyond what the measured ones leave
/// unexplained, if the model lacks something: what moves one mode by a few per cent moves others.
const UNMEASURED: f64 = 0.05;

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
    /// One row a point; the model's own parameters, then the compliances that it lacks.
    slopes: DMatrix<f64>,
    /// Of each point, the share of the noise and the variance of rounding.
    noise: Vec<(f64, f64)>,
    /// θ at which it holds.
    theta: DVector<f64>,
    /// Of the model's own parameters.
    prior: DVector<f64>,
}

/// What is taken for the noise and for the compliances that the model lacks.
#[derive(Debug, Clone, Copy)]
struct Level {
    noise: f64,
    lacking: f64,
}

/// Aᵀ W A, Aᵀ W r, and r W r − ln |W| of some of the points.
struct Sums {
    information: DMatrix<f64>,
    pull: DVector<f64>,
    misfit: f64,
}

/// The mean and covariance that some of the points give.
struct Normal {
    /// From θ of the linear model.
    step: DVector<f64>,
    covariance: DMatrix<f64>,
    /// ln of the evidence, without constants.
    ln_evidence: f64,
}

/// A posterior, and what the robot predicts with its means.
pub(super) struct Calibrated {
    pub(super) posterior: Posterior,
    /// ln of the frequency in Hz, one a point; `None` where it was not compared.
    pub(super) ln_hz: Vec<Option<f64>>,
    /// Variance of these by the parameters.
    pub(super) variance: Vec<Option<f64>>,
    /// ln of the evidence for the model, by Laplace's approximation, without what its causes cost.
    pub(super) ln_evidence: f64,
}

/// Parameters of a robot with causes, calibrated by a table.
pub(super) struct Means {
    /// The means; deviations as beforehand.
    pub(super) learned: Vec<LearnedParameter>,
    /// The likeliest noise, if the model lacks nothing, share of the frequency.
    noise: f64,
    /// ln of the evidence for the model then, without constants and without what its causes cost.
    pub(super) ln_evidence: f64,
}

/// The means of the parameters of a robot with causes that were fitted; `None` where the model has
/// no modes at a row.
pub(super) fn means(problem: &Problem<'_>, chosen: &Fit<'_>) -> Option<Means> {
    let corrections = chosen.hypothesis.corrections();
    let mut learned = prior(problem.description, &corrections)?;
    let instrument = of_instrument(chosen);
    let noises = noises(problem.data);
    let likeliest = |learned: &[LearnedParameter]| {
        let linear = linear(problem, &corrections, learned, &instrument)?;
        let found = noises
            .iter()
            .map(|&noise| Some((noise, linear.given_all(Level { noise, lacking: 0.0 })?)));
        let found = found.collect::<Option<Vec<(f64, Normal)>>>()?.into_iter();
        let best = found.max_by(|(_, a), (_, b)| a.ln_evidence.total_cmp(&b.ln_evidence))?;
        Some((linear, best))
    };
    let (mut noise, mut ln_evidence) = (MIN_NOISE, f64::NEG_INFINITY);
    for _ in 0..STEPS {
        let (linear, (likeliest, best)) = likeliest(&learned)?;
        (noise, ln_evidence) = (likeliest, best.ln_evidence);
        let reaches = best.step.component_div(&linear.prior.map(f64::sqrt));
        let share = (FARTHEST / reaches.amax().max(f64::MIN_POSITIVE)).min(1.0);
        for (one, step) in learned.iter_mut().zip(best.step.iter()) {
            one.ln += share * step;
        }
    }
    for one in &mut learned {
        one.ln = rounded(one.ln);
    }
    Some(Means { learned, noise, ln_evidence })
}

/// Covariance of the parameters of the causes of a fit, as the fit measures them, with those of the
/// posterior free: inverse of the Schur complement of these in the information of both; `None` if
/// the table does not hold them.
pub(super) fn covariance_of_causes(
    problem: &Problem<'_>,
    chosen: &Fit<'_>,
    means: &Means,
) -> Option<DMatrix<f64>> {
    let corrections = chosen.hypothesis.corrections();
    let linear = linear(problem, &corrections, &means.learned, &of_instrument(chosen))?;
    let level = Level { noise: means.noise, lacking: 0.0 };
    let own = linear.theta.len();
    // By parameter, what is expected of it; those of the posterior are there already.
    let parameters = chosen.hypothesis.effects.iter().flat_map(|(candidate, _)| {
        candidate.parameters.iter().map(|parameter| {
            let is_beyond =
                !is_of_posterior(candidate, parameter) && !candidate.cause.is_of_the_instrument();
            is_beyond.then(|| parameter.expectation().map_or(0.0, |(_, precision)| precision))
        })
    });
    let parameters: Vec<Option<f64>> = parameters.collect();
    let p = parameters.len();
    if p == 0 {
        return None;
    }
    let mut of_causes = DMatrix::zeros(p, p);
    let mut across = DMatrix::zeros(own, p);
    for (k, expected) in parameters.iter().enumerate() {
        of_causes[(k, k)] = expected.unwrap_or(1.0);
    }
    for (i, &at) in linear.points.iter().enumerate() {
        let slope = &chosen.evaluation.left.slopes[at];
        if slope.len() != p {
            continue;
        }
        let slope = DVector::from_fn(p, |k, _| parameters[k].map_or(0.0, |_| slope[k]));
        let weight = 1.0 / linear.variance(level, i);
        let of_theta = linear.slopes.row(i).columns(0, own).transpose();
        of_causes.ger(weight, &slope, &slope, 1.0);
        across.ger(weight, &of_theta, &slope, 1.0);
    }
    let theta = linear.sums(level, 0..linear.residuals.len()).information
        + DMatrix::from_diagonal(&linear.prior.map(|variance| 1.0 / variance));
    let mut covariance =
        (of_causes - across.tr_mul(&theta.cholesky()?.solve(&across))).cholesky()?.inverse();
    for k in (0..p).filter(|&k| parameters[k].is_none()) {
        covariance[(k, k)] = 0.0;
    }
    Some(covariance)
}

/// What the causes of a fit cost against the evidence: the choice of each among the candidates,
/// and in BIC each parameter that is not among those of the posterior, whose evidence charges for
/// its own.
pub(super) fn cost(data: &Data, fit: &Fit<'_>, candidates: usize) -> f64 {
    let effects = &fit.hypothesis.effects;
    let beyond = effects.iter().flat_map(|(candidate, _)| {
        let own = candidate.parameters.iter();
        own.filter(|parameter| !is_of_posterior(candidate, parameter))
    });
    let parameters = beyond.count();
    0.5 * (data.points.len() as f64).ln() * parameters as f64
        + (candidates as f64).ln() * effects.len() as f64
}

/// ln of every natural frequency in Hz at rows, with corrections and learned means; `None` where
/// there is no such robot or it has no modes.
pub(super) fn predicted(
    description: &Description,
    corrections: &[Correction],
    learned: &[LearnedParameter],
    rows: &[Row],
) -> Option<Vec<Vec<f64>>> {
    let mut mechanics = Mechanics::new(&with_means(description, learned), corrections, rows)?;
    let mut pencil = Pencil::new(mechanics.mass().nrows());
    let at = |row: &Row| {
        mechanics.place(row)?;
        let is_solved = pencil.solve(mechanics.mass(), mechanics.stiffness());
        let ln_hz = |omega_squared: &f64| hz_from_rad_per_s(omega_squared.sqrt()).ln();
        is_solved.then(|| pencil.omega_squared.iter().map(ln_hz).collect())
    };
    rows.iter().map(at).collect()
}

/// The posterior of a robot with the causes that were chosen; `None` where the model has no modes
/// at a row.
pub(super) fn posterior(problem: &Problem<'_>, chosen: &Fit<'_>) -> Option<Calibrated> {
    let Means { learned, .. } = means(problem, chosen)?;
    let corrections = chosen.hypothesis.corrections();
    let instrument = of_instrument(chosen);
    let noises = noises(problem.data);
    let linear = linear(problem, &corrections, &learned, &instrument)?;
    let mut ln_hz = vec![None; problem.data.points.len()];
    for (&at, residual) in linear.points.iter().zip(linear.residuals.iter()) {
        ln_hz[at] = Some(problem.data.points[at].ln_f - residual);
    }
    let Weighed { covariance, best, ln_evidence, lacks } = linear.weighed(&noises)?;
    let mut variance = vec![None; problem.data.points.len()];
    for (&at, slope) in linear.points.iter().zip(linear.slopes.row_iter()) {
        variance[at] = Some((slope * &covariance).dot(&slope));
    }
    // Where nothing is stated of a spring, a link or a drive, a mode that nobody measured is not
    // better known than before.
    let robot = Robot::new(problem.description).ok()?;
    let lacks = if problem.data.stated_noise.is_some() { lacks } else { 1.0 };
    let least = if states_all(&robot) { UNMEASURED * lacks.sqrt() } else { uncalibrated_std_ln() };
    let unexplained = unexplained(problem.data, &linear, best, robot.coordinates().len(), least)?;
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
    let mut posterior = Posterior { parameters, correlation, unexplained, fingerprint: None };
    posterior.fingerprint = as_written(problem, corrections, &posterior);
    Some(Calibrated { posterior, ln_hz, variance, ln_evidence })
}

/// The fingerprint of the robot as it will be read again, with its corrections and what was
/// learned.
fn as_written(
    problem: &Problem<'_>,
    mut corrections: Vec<Correction>,
    posterior: &Posterior,
) -> Option<Fingerprint> {
    corrections.iter_mut().for_each(|correction| centred(correction, problem.data));
    let mut description = with_posterior(problem.description, posterior.clone());
    description.corrections.extend(corrections);
    Fingerprint::of(&Robot::of(description)?, posterior.unexplained.poses.first()?)
}

/// Six decimals: what is written is read again as it was.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Levels of noise, share of the frequency: from what the table states, else from what an
/// instrument does at best.
fn noises(data: &Data) -> Vec<f64> {
    let least = data.stated_noise.unwrap_or(0.0).max(MIN_NOISE);
    std::iter::successors(Some(least), |noise| Some(noise * PER_LEVEL))
        .take_while(|noise| *noise <= MAX_NOISE.max(least))
        .collect()
}

/// Every parameter of the corrected robot with its prior, then the compliances that it lacks.
fn prior(description: &Description, corrections: &[Correction]) -> Option<Vec<LearnedParameter>> {
    let plain = Robot::new(description).ok()?;
    let mut corrected = description.clone();
    corrected.corrections.extend_from_slice(corrections);
    let robot = Robot::of(corrected)?;
    let is_corrected = |kind: ParameterKind, at: &str| {
        let by = corrections
            .iter()
            .any(|c| kind_of(c.cause) == Some(kind) && c.at.as_deref() == Some(at));
        by || (kind == ParameterKind::Spring && scales_of(&plain, kind, at).is_none())
    };
    let one = |parameter: &Parameter| {
        let (kind, at) = parameter.place(&robot);
        let std = if is_corrected(kind, at) { STD_OF_CORRECTED } else { parameter.std };
        LearnedParameter { kind, at: at.to_owned(), ln: 0.0, std }
    };
    let lacking = lacking(&robot).into_iter();
    let lacking = lacking.map(|scales| Parameter { scales, std: 0.0, is_assumed: true });
    Some(all(&robot).iter().copied().chain(lacking).map(|parameter| one(&parameter)).collect())
}

/// The parameters of a posterior among which those of a cause are.
fn kind_of(cause: Cause) -> Option<ParameterKind> {
    match cause {
        Cause::JointStiffness => Some(ParameterKind::Spring),
        Cause::LinkInertia => Some(ParameterKind::Link),
        Cause::DriveInertia => Some(ParameterKind::Drive),
        _ => None,
    }
}

/// Whether a parameter of a cause is among those of the posterior: springs that it adds are.
fn is_of_posterior(candidate: &Candidate, parameter: &CauseParameter) -> bool {
    let is_of_spring = ["stiffness_", "ratio_", "shift_ratio_", "frequency_"];
    let is_of_spring = is_of_spring.iter().any(|start| parameter.name.starts_with(start));
    kind_of(candidate.cause).is_some() || (candidate.hinge.is_some() && is_of_spring)
}

/// Per column of the table, whether the instrument shows it otherwise than the arm has it.
fn of_instrument(chosen: &Fit<'_>) -> impl Fn(usize) -> bool + use<> {
    let from = chosen.hypothesis.effects.iter().filter_map(|(candidate, _)| {
        let mode: usize = candidate.at.as_deref()?.parse().ok()?;
        match candidate.cause {
            // An aliased frequency may stand in any column.
            Cause::AliasedMode => Some(0),
            // Where a mode is missed the next ones move up.
            Cause::MissedMode => mode.checked_sub(1),
            _ => None,
        }
    });
    let first = from.min();
    move |column| first.is_some_and(|first| column >= first)
}

/// The robot with parameters as learned so far.
fn with_means(description: &Description, learned: &[LearnedParameter]) -> Description {
    with_posterior(description, Posterior { parameters: learned.to_vec(), ..Posterior::default() })
}

fn with_posterior(description: &Description, posterior: Posterior) -> Description {
    let calibration = Calibration {
        poses: 0,
        heldout_rms_percent: 0.0,
        is_doubtful: false,
        posterior: Some(posterior),
    };
    Description { calibration: Some(calibration), ..description.clone() }
}

/// Residuals and slopes of the points at the parameters as learned so far.
fn linear(
    problem: &Problem<'_>,
    corrections: &[Correction],
    learned: &[LearnedParameter],
    instrument: &impl Fn(usize) -> bool,
) -> Option<Linear> {
    let Problem { description, data } = *problem;
    let mut mechanics = Mechanics::new(&with_means(description, learned), corrections, &data.rows)?;
    let tests = data.tests();
    let mut pencil = Pencil::new(mechanics.mass().nrows());
    let (mut points, mut places) = (Vec::new(), Vec::new());
    let (mut residuals, mut slopes) = (Vec::new(), Vec::new());
    for (i, row) in data.rows.iter().enumerate() {
        let arm = arm(&mut mechanics, row, learned)?;
        if !pencil.solve(mechanics.mass(), mechanics.stiffness()) {
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
    let columns = slopes.iter().map(DVector::transpose).collect::<Vec<_>>();
    let own: Vec<&LearnedParameter> = learned.iter().filter(|one| !one.kind.is_lacking()).collect();
    Some(Linear {
        tests: points.iter().map(|point| tests[point.row]).collect(),
        columns: points.iter().map(|point| point.column).collect(),
        noise: points.iter().map(|point| (point.unit, point.rounding)).collect(),
        points: places,
        slopes: if columns.is_empty() {
            DMatrix::zeros(0, learned.len())
        } else {
            DMatrix::from_rows(&columns)
        },
        residuals: DVector::from_vec(residuals),
        theta: DVector::from_iterator(own.len(), own.iter().map(|one| one.ln)),
        prior: DVector::from_iterator(own.len(), own.iter().map(|one| one.std.powi(2))),
    })
}

fn arm(mechanics: &mut Mechanics, row: &Row, learned: &[LearnedParameter]) -> Option<ArmAtPose> {
    mechanics.place(row)?;
    let robot = mechanics.robot(row)?;
    let scales = learned.iter().map(|one| scales_of(robot, one.kind, &one.at));
    let both = [mechanics.mass().clone(), mechanics.stiffness().clone()];
    Some(ArmAtPose::placed(robot, mechanics.placement(), &row.conditions, scales, both))
}

/// Levels weighed by their evidence.
struct Weighed {
    /// Of all parameters, about θ of the linear model.
    covariance: DMatrix<f64>,
    /// The likeliest.
    best: Level,
    /// Of all levels, those of the noise as probable as each other beforehand.
    ln_evidence: f64,
    /// How probable it is that the model lacks something, or that the noise is not the least.
    lacks: f64,
}

impl Linear {
    /// Of the noise of a point.
    fn variance(&self, level: Level, i: usize) -> f64 {
        let (unit, rounding) = self.noise[i];
        (level.noise * unit).powi(2) + rounding
    }

    /// What some of the points tell at a level. Without compliances that the model lacks it is
    /// about the model's own parameters alone.
    fn sums(&self, level: Level, points: impl Iterator<Item = usize>) -> Sums {
        let p = if level.lacking > 0.0 { self.slopes.ncols() } else { self.theta.len() };
        let mut sums =
            Sums { information: DMatrix::zeros(p, p), pull: DVector::zeros(p), misfit: 0.0 };
        for i in points {
            let variance = self.variance(level, i);
            let slope = self.slopes.row(i).columns(0, p).transpose();
            sums.pull.axpy(self.residuals[i] / variance, &slope, 1.0);
            sums.information.ger(1.0 / variance, &slope, &slope, 1.0);
            sums.misfit += self.residuals[i].powi(2) / variance + variance.ln();
        }
        sums
    }

    /// With what is known beforehand.
    fn given(&self, level: Level, sums: &Sums) -> Option<Normal> {
        let (own, p) = (self.theta.len(), sums.pull.len());
        let prior = |k: usize| if k < own { self.prior[k] } else { level.lacking.powi(2) };
        let precision = DVector::from_fn(p, |k, _| 1.0 / prior(k));
        let theta = DVector::from_fn(p, |k, _| if k < own { self.theta[k] } else { 0.0 });
        let pull = &sums.pull - theta.component_mul(&precision);
        let misfit = sums.misfit + theta.dot(&theta.component_mul(&precision))
            - precision.map(f64::ln).sum();
        let factor = (&sums.information + DMatrix::from_diagonal(&precision)).cholesky()?;
        let step = factor.solve(&pull);
        Some(Normal {
            ln_evidence: -0.5 * (misfit - pull.dot(&step) + factor.ln_determinant()),
            covariance: factor.solve(&DMatrix::identity(p, p)),
            step,
        })
    }

    fn given_all(&self, level: Level) -> Option<Normal> {
        self.given(level, &self.sums(level, 0..self.residuals.len()))
    }

    /// Every level of noise and of what the model lacks.
    fn weighed(&self, noises: &[f64]) -> Option<Weighed> {
        let levels: Vec<Level> = noises
            .iter()
            .flat_map(|&noise| LACKING.map(|(lacking, _)| Level { noise, lacking }))
            .collect();
        let mut found: Vec<Normal> =
            levels.iter().map(|level| self.given_all(*level)).collect::<Option<_>>()?;
        for (normal, (_, probability)) in found.iter_mut().zip(LACKING.iter().cycle()) {
            normal.ln_evidence += probability.ln();
        }
        let of = |i: &usize| found[*i].ln_evidence;
        let best = (0..levels.len()).max_by(|a, b| of(a).total_cmp(&of(b)))?;
        let shares = found.iter().map(|normal| (normal.ln_evidence - of(&best)).exp());
        let shares: Vec<f64> = shares.collect();
        let whole: f64 = shares.iter().sum();
        let p = self.slopes.ncols();
        let mut covariance = DMatrix::zeros(p, p);
        for (normal, share) in found.iter().zip(&shares) {
            let own = normal.step.len();
            let moment = &normal.covariance + &normal.step * normal.step.transpose();
            let mut part = covariance.view_mut((0, 0), (own, own));
            part += moment * (share / whole);
        }
        let least = PER_LEVEL * levels[0].noise;
        let is_whole = |level: &Level| level.lacking == 0.0 && level.noise <= least;
        let lacking = levels.iter().zip(&shares).filter(|(level, _)| !is_whole(level));
        Some(Weighed {
            lacks: lacking.map(|(_, share)| share / whole).sum(),
            covariance,
            best: levels[best],
            ln_evidence: of(&best) + (whole / noises.len() as f64).ln(),
        })
    }

    /// Per point that a group leaves out: its error, squared, less the variance that the parameters
    /// let expect.
    fn excess(&self, level: Level, groups: &[usize]) -> Option<Vec<f64>> {
        let mut found = vec![0.0; groups.len()];
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, &group) in groups.iter().enumerate() {
            members.entry(group).or_default().push(i);
        }
        let whole = self.sums(level, 0..groups.len());
        for own in members.values() {
            let left_out = self.sums(level, own.iter().copied());
            let others = Sums {
                information: &whole.information - left_out.information,
                pull: &whole.pull - left_out.pull,
                misfit: whole.misfit - left_out.misfit,
            };
            let normal = self.given(level, &others)?;
            for &i in own {
                let slope = self.slopes.row(i).columns(0, normal.step.len()).transpose();
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
fn unexplained(
    data: &Data,
    linear: &Linear,
    level: Level,
    modes: usize,
    least: f64,
) -> Option<Unexplained> {
    let poses = distinct(data);
    let blocks = blocks(data);
    let near = linear.excess(level, &linear.tests)?;
    let of_block: Vec<usize> = linear.tests.iter().map(|&test| blocks[test]).collect();
    let far = linear.excess(level, &of_block)?;
    // Noise that the table does not state counts as an error of the model: an effect that the model
    // lacks hides in it.
    let stated = |i: usize| {
        let (unit, rounding) = linear.noise[i];
        data.stated_noise.map_or(0.0, |noise| (noise * unit).powi(2) + rounding)
    };
    let of_mode = |excess: &[f64], column: usize| -> Option<f64> {
        let own = (0..excess.len()).filter(|&i| linear.columns[i] == column);
        let own = own.map(|i| excess[i] - stated(i));
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
