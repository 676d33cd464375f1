//! What is believed of the parameters, and how far the model is to be trusted.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use super::arm::ArmAtPose;
use super::parameters::{Parameter, all, scales_of, stated, states_all};
use crate::model::{Calibration, PoseFault, Posterior, Robot, Unexplained, beyond};
use crate::modes::ModalSolver;

/// Normal parameters about the values of the model, and what they leave unexplained.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// Σ of the parameters' logarithms, p × p.
    pub covariance: DMatrix<f64>,
    /// What a comparison with measurements left over.
    pub unexplained: Option<Unexplained>,
    /// By joint, rad or m: where that comparison speaks ([`Unexplained::ranges`]).
    pub ranges: Vec<[f64; 2]>,
    /// No frequency is better known than this, standard deviation of its logarithm: numbers of the
    /// model of which nothing is stated are not exact.
    pub least_std_ln: f64,
}

/// Standard normal quantile that leaves `confidence` (0..1) between itself and its negative.
pub fn reach_of(confidence: f64) -> f64 {
    Normal::standard().inverse_cdf(0.5 + 0.5 * confidence)
}

/// How far a model is to be trusted.
#[derive(Debug, Clone, PartialEq)]
pub enum Trust {
    /// Every frequency lies within f (1 ± this): said by a policy, by a calibration that states one
    /// figure only, or of a robot of which nothing is known.
    Share(f64),
    /// Parameter by parameter.
    Belief(Box<Belief>),
}

/// What an uncalibrated model of which nothing is stated may be wrong by, as a share of the
/// frequency.
pub const UNCALIBRATED: f64 = 0.10;

/// The same as a standard deviation of ln of the frequency.
pub fn uncalibrated_std_ln() -> f64 {
    UNCALIBRATED / reach_of(0.95)
}

/// A calibration of one figure: the model may be wrong by so many times the error on poses that it
/// was not fitted to.
const PER_HELDOUT_RMS: f64 = 2.0;

impl Trust {
    /// In a robot, unless a policy says it.
    pub fn of(robot: &Robot, policy: Option<f64>) -> Self {
        if let Some(share) = policy {
            return Self::Share(share);
        }
        if let Some(calibration) = robot.calibration() {
            return match &calibration.posterior {
                Some(posterior) => Self::Belief(Box::new(Belief::learned(robot, posterior))),
                None => {
                    let rms = calibration.heldout_rms_percent;
                    let percent = PER_HELDOUT_RMS * rms.max(Calibration::MIN_HELDOUT_PERCENT);
                    Self::Share(0.01 * percent)
                }
            };
        }
        let is_whole = states_all(robot);
        match stated(robot) {
            Some(parameters) if !parameters.is_empty() => {
                let least_std_ln = if is_whole { 0.0 } else { uncalibrated_std_ln() };
                Self::Belief(Box::new(Belief { least_std_ln, ..Belief::prior(parameters) }))
            }
            // Every number that a frequency depends on is said to be exact.
            Some(_) if is_whole => Self::Share(0.0),
            _ => Self::Share(UNCALIBRATED),
        }
    }
}

/// The largest figure of each mode among several lists of them.
pub fn largest_by_mode<'a>(lists: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    let mut all: Vec<f64> = Vec::new();
    for own in lists {
        all.resize(all.len().max(own.len()), 0.0);
        all.iter_mut().zip(own).for_each(|(most, own)| *most = most.max(*own));
    }
    all
}

/// Half of an interval about a frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HalfWidth {
    /// f (1 ± this).
    Share(f64),
    /// f e^±this.
    Ln(f64),
}

impl HalfWidth {
    /// The ends of the interval about a frequency.
    pub fn about(self, hz: f64) -> [f64; 2] {
        match self {
            Self::Share(share) => [hz * (1.0 - share), hz * (1.0 + share)],
            Self::Ln(half) => [hz * (-half).exp(), hz * half.exp()],
        }
    }
}

impl Trust {
    /// The intervals of every mode at pose `q` with this confidence, 0..1.
    ///
    /// # Errors
    /// The arm has no modes there.
    pub fn half_widths(
        &self,
        robot: &Robot,
        solver: &mut ModalSolver,
        q: &[f64],
        confidence: f64,
    ) -> Result<Vec<HalfWidth>, PoseFault> {
        let belief = match self {
            Self::Share(share) => {
                return Ok(vec![HalfWidth::Share(*share); robot.coordinates().len()]);
            }
            Self::Belief(belief) => belief,
        };
        solver.solve(q)?;
        let reach = reach_of(confidence);
        let std_ln = belief.std_ln_at(robot, solver, q);
        Ok(std_ln.into_iter().map(|std| HalfWidth::Ln(reach * std)).collect())
    }
}

impl Belief {
    /// Independent parameters with the deviations that they have.
    pub fn prior(parameters: Vec<Parameter>) -> Self {
        let variances = parameters.iter().map(|parameter| parameter.std.powi(2));
        let variances = DVector::from_iterator(parameters.len(), variances);
        Self {
            covariance: DMatrix::from_diagonal(&variances),
            parameters,
            unexplained: None,
            ranges: Vec::new(),
            least_std_ln: 0.0,
        }
    }

    /// What a calibration of the robot learned.
    pub fn learned(robot: &Robot, posterior: &Posterior) -> Self {
        let mut known: Vec<(Option<usize>, Parameter)> = posterior
            .parameters
            .iter()
            .enumerate()
            .filter_map(|(i, learned)| {
                let scales = scales_of(robot, learned.kind, &learned.at)?;
                Some((Some(i), Parameter { scales, std: learned.std, is_assumed: false }))
            })
            .collect();
        // What the calibration did not know, such as a spring that was added since.
        for parameter in all(robot) {
            if !known.iter().any(|(_, other)| other.scales == parameter.scales) {
                known.push((None, parameter));
            }
        }
        let correlation = |i: Option<usize>, j: Option<usize>| match (i, j) {
            (Some(i), Some(j)) if i > j => posterior.correlation[i][j],
            (Some(i), Some(j)) if i < j => posterior.correlation[j][i],
            _ => 0.0,
        };
        let covariance = DMatrix::from_fn(known.len(), known.len(), |a, b| {
            let [(i, first), (j, second)] = [&known[a], &known[b]];
            let correlation = if a == b { 1.0 } else { correlation(*i, *j) };
            correlation * first.std * second.std
        });
        Self {
            parameters: known.into_iter().map(|(_, parameter)| parameter).collect(),
            covariance,
            unexplained: Some(posterior.unexplained.clone()),
            ranges: posterior.unexplained.ranges(),
            least_std_ln: 0.0,
        }
    }

    /// σ of ln f_r of every mode at pose `q`, which `solver` solved last.
    pub fn std_ln_at(&self, robot: &Robot, solver: &ModalSolver, q: &[f64]) -> Vec<f64> {
        let arm = ArmAtPose::new(robot, solver, &self.parameters);
        self.std_ln(&arm.sensitivities(solver.modes()), q)
    }

    /// σ of ln f_r of every mode at pose `q`, with the `sensitivities` of that pose.
    pub fn std_ln(&self, sensitivities: &DMatrix<f64>, q: &[f64]) -> Vec<f64> {
        let left = self.left_std_ln(sensitivities, q);
        let known = self.known_variances(sensitivities);
        known.iter().zip(left).map(|(known, left)| (known + left * left).sqrt()).collect()
    }

    /// The part of it that the parameters do not account for.
    pub fn left_std_ln(&self, sensitivities: &DMatrix<f64>, q: &[f64]) -> Vec<f64> {
        let unexplained = self.unexplained.as_ref().map_or_else(Vec::new, |d| d.at(q));
        // A mode that the calibration did not know is known least of all.
        let worst = self.unexplained.as_ref().map_or(0.0, |d| {
            d.far.iter().chain(&d.near).fold(uncalibrated_std_ln(), |worst, d| worst.max(*d))
        });
        // Beyond the measured range no calibration knows more than a model that nobody measured.
        let least = beyond(&self.ranges, q).sqrt() * uncalibrated_std_ln();
        let left = |(r, known): (usize, f64)| {
            let left = unexplained.get(r).copied().unwrap_or(worst).hypot(least);
            (self.least_std_ln.powi(2) - known).max(left * left).max(0.0).sqrt()
        };
        self.known_variances(sensitivities).into_iter().enumerate().map(left).collect()
    }

    fn known_variances(&self, sensitivities: &DMatrix<f64>) -> Vec<f64> {
        let variance = |a: nalgebra::DVectorView<f64>| a.dot(&(&self.covariance * a)).max(0.0);
        sensitivities.column_iter().map(variance).collect()
    }

    /// The parameter that would take most of the variance of ln f_r with it if it were known, and
    /// the share that it would take, 0..1: its squared correlation with ln f_r, (Σa)ᵢ²/(Σᵢᵢ σ²).
    /// `None` where there is none. `sensitivities` are those of mode r, `std_ln` is its σ.
    pub fn driver(&self, sensitivities: &[f64], std_ln: f64) -> Option<(&Parameter, f64)> {
        let with = &self.covariance * DVector::from_column_slice(sensitivities);
        let share = |(i, with): (usize, &f64)| (with / std_ln).powi(2) / self.covariance[(i, i)];
        let shares = self.parameters.iter().zip(with.iter().enumerate().map(share));
        let known = shares.filter(|(_, share)| share.is_finite());
        known.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(one, share)| (one, share.min(1.0)))
    }

    /// L with Σ = L Lᵀ, p × p.
    pub fn factor(&self) -> DMatrix<f64> {
        // A covariance of measured parameters may be singular to rounding.
        let eigen = self.covariance.clone().symmetric_eigen();
        let roots = eigen.eigenvalues.map(|lambda| lambda.max(0.0).sqrt());
        eigen.eigenvectors * DMatrix::from_diagonal(&roots)
    }
}
