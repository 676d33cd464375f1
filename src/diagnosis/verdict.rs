//! The diagnosis as a whole: choose, question, say how sure, measure the gain, say what to do next.

use std::fmt;

use super::arm::Arm;
use super::candidate::Candidate;
use super::causes::candidates;
use super::choose::{Choice, Effort, Model, choose, p_value};
use super::data::Data;
use super::fit::{Evaluation, Fit, Problem};
use super::gain::{gain_interval, held_out, relative_error, rms};
use super::interval::{covariance, quantile_95};
use super::next_poses::{NextPose, poses_between};
use super::screen::Screen;
use super::unknown::{self, Structure, structure};
use crate::measured::ModeTable;
use crate::model::{Cause, Correction, Description, Hinge, Robot};
use crate::units::percent_from_ratio;

/// Fewer poses than this say nothing.
const FEWEST_ROWS: usize = 5;

/// Fewer frequencies than this say nothing.
const FEWEST_POINTS: usize = 8;

/// A rival whose model is worth less by more than this is no rival: e^-6 is one in four hundred.
const RIVAL_WITHIN: f64 = 6.0;

/// Rivals that are told beside a finding.
const MOST_RIVALS: usize = 3;

/// A shape without a cause explains better than the causes do if it is worth more by this.
const UNKNOWN_BETTER_BY: f64 = 4.0;

/// Structure that is left is immaterial where the causes take this share of the squared error away ...
const OVERWHELMING: f64 = 0.985;

/// How to diagnose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Of the folds and resamples.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { seed: 1 }
    }
}

/// Why there is no diagnosis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DiagnosisFault {
    /// Too few poses or frequencies.
    TooLittle {
        /// Poses with at least one frequency.
        poses: usize,
        /// Frequencies.
        frequencies: usize,
    },
    /// The robot has no modes at a pose of the table, or cannot be built.
    NoModes,
}

impl fmt::Display for DiagnosisFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLittle { poses, frequencies } => write!(
                f,
                "too little data: {frequencies} frequencies at {poses} poses, must be at least \
                 {FEWEST_POINTS} at {FEWEST_ROWS}"
            ),
            Self::NoModes => write!(
                f,
                "the model has no modes at a pose of the table; check its stiffness and masses with \
                 detune map"
            ),
        }
    }
}

impl std::error::Error for DiagnosisFault {}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Causes explain what the model gets wrong.
    Explained,
    /// Nothing beyond noise.
    Consistent,
    /// The residual is structured, but no cause earns its place.
    Unexplained,
}

/// Errors of a model, relative to what was measured, %.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Root mean square over all frequencies.
    pub rms_percent: f64,
    /// The same at poses left out.
    pub heldout_rms_percent: f64,
    /// Root mean square mode by mode.
    pub per_mode_rms_percent: Vec<f64>,
}

/// A cause at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// The cause.
    pub cause: Cause,
    /// Joint, link or mode; `None` where the cause has no place.
    pub at: Option<String>,
    /// 2 ln of how much likelier the finding is, parameters paid for (difference of BIC).
    pub behind: f64,
}

/// A parameter of a finding.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Its name, with the unit.
    pub name: String,
    /// In the robot's file; `None` where no finite value stands for "no effect".
    pub nominal: Option<f64>,
    /// As found.
    pub estimate: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
}

/// Why a finding is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// BIC with the finding less BIC without it.
    pub delta_bic: f64,
    /// How often chance does as well with any candidate.
    pub p_value: f64,
}

/// A cause that earned its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The cause.
    pub cause: Cause,
    /// Joint, link or mode; `None` where the cause has no place.
    pub at: Option<String>,
    /// Causes that the data cannot tell from it, most plausible first.
    pub indistinguishable_from: Vec<Suspect>,
    /// What was fitted.
    pub parameters: Vec<Estimate>,
    /// Where something gives, for causes that add an elastic coordinate.
    pub hinge: Option<Hinge>,
    /// Why it is believed.
    pub evidence: Evidence,
    /// What the error would be more without it, percentage points.
    pub gain_percent_points: f64,
}

/// What the findings gain at poses left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Percentage points of held-out error.
    pub percent_points: f64,
    /// 95 % interval over resampled poses.
    pub ci95: [f64; 2],
}

/// A measured frequency and what the models say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualRow {
    /// Row of the table, from 0.
    pub row: usize,
    /// Mode column, from 0.
    pub mode: usize,
    /// Hz.
    pub measured_hz: f64,
    /// Hz; `None` where the model has no such mode.
    pub before_hz: Option<f64>,
    /// With the findings, Hz.
    pub after_hz: Option<f64>,
}

/// A whole diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// What was found, in a word.
    pub verdict: Verdict,
    /// Number of poses.
    pub poses: usize,
    /// Errors of the model as it is.
    pub baseline: Errors,
    /// Causes, the one that explains most first.
    pub findings: Vec<Finding>,
    /// Errors with the findings put in.
    pub extended: Errors,
    /// What the findings gain.
    pub gain: Gain,
    /// The level of the noise: the best that any model can do.
    pub noise_floor_percent: f64,
    /// What the model as it is leaves.
    pub structure_before: Option<Structure>,
    /// What the findings leave, if it is more than noise.
    pub structure_after: Option<Structure>,
    /// Poses worth measuring.
    pub next_poses: Vec<NextPose>,
    /// Pairs that no pose separates, with the test that does.
    pub next_tests: Vec<(String, &'static str)>,
    /// The best causes one by one, most plausible first, with the difference of BIC to the best.
    pub ranking: Vec<Suspect>,
    /// Every measured frequency.
    pub residuals: Vec<ResidualRow>,
    /// What `robot.yaml` needs to hold.
    pub corrections: Vec<Correction>,
    /// Elastic coordinates of the model as it is, for shapes that name one.
    pub coordinates: Vec<String>,
    /// Joints, for shapes that name one.
    pub joints: Vec<String>,
}

impl Suspect {
    /// "payload at tool0".
    pub fn label(&self) -> String {
        label(self.cause, self.at.as_deref())
    }
}

/// "payload at tool0".
pub(super) fn label(cause: Cause, at: Option<&str>) -> String {
    at.map_or_else(|| cause.to_string(), |at| format!("{cause} at {at}"))
}

/// Diagnoses a robot by a table of measured modes. `progress` is called with the share of the work done.
///
/// # Errors
/// Too little data, or a model without modes at a pose of the table.
pub fn diagnose(
    description: &Description,
    table: &ModeTable,
    settings: Settings,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Diagnosis, DiagnosisFault> {
    let data = Data::of(table, description.payload.as_ref());
    let mut rows: Vec<usize> = data.points.iter().map(|point| point.row).collect();
    rows.dedup();
    let (poses, frequencies) = (rows.len(), data.points.len());
    let data = data.only(|row| rows.contains(&row));
    if poses < FEWEST_ROWS || frequencies < FEWEST_POINTS {
        return Err(DiagnosisFault::TooLittle { poses, frequencies });
    }
    let robot = Robot::new(description).map_err(|_| DiagnosisFault::NoModes)?;
    let arm = Arm::new(description, &robot, &data).ok_or(DiagnosisFault::NoModes)?;
    let candidates = candidates(&arm);
    let problem = Problem { description, data: &data };
    let screen = Screen::new(&problem, &candidates).ok_or(DiagnosisFault::NoModes)?;
    progress(0.1);
    let choice =
        choose(&problem, &candidates, &screen, Effort::FULL).ok_or(DiagnosisFault::NoModes)?;
    progress(0.4);
    let judged = Judged::of(&problem, &choice);
    let chosen: &Fit<'_> =
        if judged.verdict == Verdict::Explained { &choice.best.fit } else { &choice.nothing };
    let folds = std::sync::atomic::AtomicUsize::new(0);
    let held_out = held_out(description, &data, &candidates, &screen, settings.seed, &|| {
        let done = folds.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        progress(0.4 + 0.06 * done as f64);
    });
    let held_out_before = rms(held_out.before.iter());
    let held_out_after = match judged.verdict {
        Verdict::Explained => rms(held_out.after.iter()),
        Verdict::Consistent | Verdict::Unexplained => held_out_before,
    };
    let interval = gain_interval(&data, &held_out, settings.seed);
    let baseline = errors(&data, &choice.nothing.evaluation, held_out_before);
    let extended = errors(&data, &chosen.evaluation, held_out_after);
    let findings = if judged.verdict == Verdict::Explained {
        findings(&problem, candidates.len(), &choice)
    } else {
        Vec::new()
    };
    let (next_poses, next_tests) = if judged.verdict == Verdict::Explained {
        next(&problem, &robot, &choice)
    } else {
        Default::default()
    };
    progress(1.0);
    let noise_left = (frequencies as f64 - chosen.freedom).max(1.0);
    let floor = rms(chosen.evaluation.residuals.iter()) * (frequencies as f64 / noise_left).sqrt();
    Ok(Diagnosis {
        verdict: judged.verdict,
        poses,
        gain: match judged.verdict {
            Verdict::Explained => Gain {
                percent_points: percent_from_ratio(held_out_before - held_out_after),
                ci95: interval.map(percent_from_ratio),
            },
            Verdict::Consistent | Verdict::Unexplained => {
                Gain { percent_points: 0.0, ci95: [0.0, 0.0] }
            }
        },
        baseline,
        extended,
        noise_floor_percent: percent_from_ratio(floor),
        structure_before: judged.before,
        structure_after: judged.after,
        next_poses,
        next_tests,
        ranking: ranking(&choice),
        residuals: residual_rows(&data, &choice.nothing.evaluation, &chosen.evaluation),
        corrections: chosen.hypothesis.corrections(),
        coordinates: robot.coordinates().iter().map(|c| c.name.clone()).collect(),
        joints: robot.joints().iter().map(|joint| joint.name.clone()).collect(),
        findings,
    })
}

/// The verdict and what it rests on.
struct Judged {
    verdict: Verdict,
    before: Option<Structure>,
    after: Option<Structure>,
}

impl Judged {
    fn of(problem: &Problem<'_>, choice: &Choice<'_>) -> Self {
        let nothing = structure(problem, &choice.nothing);
        let significant = |s: &Structure| s.p_value < unknown::SIGNIFICANCE;
        let before = nothing.as_ref().map(|s| s.clearest.clone()).filter(significant);
        if choice.best.fit.hypothesis.effects.is_empty() {
            let verdict = if before.is_some() { Verdict::Unexplained } else { Verdict::Consistent };
            return Self { verdict, after: before.clone(), before };
        }
        let left = structure(problem, &choice.best.fit);
        let after = left.as_ref().map(|s| s.clearest.clone()).filter(significant);
        let worth_of_nothing = choice.nothing.evaluation.score;
        let unknown_is_better = nothing.as_ref().is_some_and(|s| {
            worth_of_nothing + s.best_worth > choice.best.worth + UNKNOWN_BETTER_BY
        });
        let square = |fit: &Fit<'_>| rms(fit.evaluation.residuals.iter()).powi(2);
        let explained = 1.0 - square(&choice.best.fit) / square(&choice.nothing).max(1e-300);
        let verdict = if (after.is_some() || unknown_is_better) && explained < OVERWHELMING {
            Verdict::Unexplained
        } else {
            Verdict::Explained
        };
        Self { verdict, before, after }
    }
}

fn errors(data: &Data, evaluation: &Evaluation, heldout: f64) -> Errors {
    let errors: Vec<Option<f64>> =
        evaluation.residuals.iter().map(|r| r.map(relative_error)).collect();
    let of_mode = |mode: usize| {
        let own = data.points.iter().zip(&errors).filter(move |(p, _)| p.column == mode);
        percent_from_ratio(rms(own.map(|(_, e)| e)))
    };
    Errors {
        rms_percent: percent_from_ratio(rms(errors.iter())),
        heldout_rms_percent: percent_from_ratio(heldout),
        per_mode_rms_percent: (0..data.columns).map(of_mode).collect(),
    }
}

/// The places of one cause that count as one suspect, best first.
fn suspects(models: &[Model<'_>], i: usize, best: f64) -> Vec<Suspect> {
    let mut suspects: Vec<Suspect> = Vec::new();
    let mut add = |suspect: Suspect| {
        if !suspects.iter().any(|s| s.cause == suspect.cause && s.at == suspect.at) {
            suspects.push(suspect);
        }
    };
    for model in models {
        let Some((candidate, _)) = model.fit.hypothesis.effects.get(i) else { continue };
        let behind = 2.0 * (best - model.worth);
        add(Suspect { cause: candidate.cause, at: candidate.at.clone(), behind });
    }
    suspects
}

fn findings(problem: &Problem<'_>, candidates: usize, choice: &Choice<'_>) -> Vec<Finding> {
    let best = &choice.best;
    let data = problem.data;
    let covariance = covariance(data, &best.fit);
    let quantile = quantile_95(data, &best.fit);
    let rms_with = rms(best.fit.evaluation.residuals.iter());
    let n = data.points.len() as f64;
    let mut at = 0;
    let mut findings = Vec::new();
    for (i, (candidate, inner)) in best.fit.hypothesis.effects.iter().enumerate() {
        let parameters = candidate
            .parameters
            .iter()
            .zip(inner)
            .enumerate()
            .map(|(k, (parameter, &inner))| {
                let deviation = covariance
                    .as_ref()
                    .map(|c| c[(at + k, at + k)].max(0.0).sqrt())
                    .filter(|d| d.is_finite());
                let ci95 = [-1.0, 1.0].map(|sign| match deviation {
                    Some(deviation) => {
                        parameter.value(parameter.clamp(inner + sign * quantile * deviation))
                    }
                    None => parameter.bounds[usize::from(sign > 0.0)],
                });
                Estimate {
                    name: parameter.name.to_owned(),
                    nominal: parameter.nominal,
                    estimate: parameter.value(inner),
                    ci95,
                }
            })
            .collect();
        at += inner.len();
        let mut rest = best.fit.hypothesis.clone();
        rest.effects.remove(i);
        let without = problem.climb(rest).unwrap_or_else(|| choice.nothing.clone());
        let bic = |fit: &Fit<'_>| -2.0 * fit.evaluation.score + fit.freedom * n.ln();
        findings.push(Finding {
            cause: candidate.cause,
            at: candidate.at.clone(),
            indistinguishable_from: group(choice, i, candidate),
            parameters,
            hinge: candidate.hinge.clone(),
            evidence: Evidence {
                delta_bic: bic(&best.fit) - bic(&without),
                p_value: p_value(problem, candidates, &without, &best.fit),
            },
            gain_percent_points: percent_from_ratio(
                rms(without.evaluation.residuals.iter()) - rms_with,
            ),
        });
    }
    findings.sort_by(|a, b| b.gain_percent_points.total_cmp(&a.gain_percent_points));
    findings
}

/// Rivals of the finding `i` within reach.
fn group(choice: &Choice<'_>, i: usize, finding: &Candidate) -> Vec<Suspect> {
    let others: Vec<&Candidate> =
        choice.best.fit.hypothesis.effects.iter().map(|(candidate, _)| *candidate).collect();
    let mut group: Vec<Suspect> = suspects(&choice.rivals[i], i, choice.best.worth)
        .into_iter()
        .filter(|s| s.behind < 2.0 * RIVAL_WITHIN)
        .filter(|s| !others.iter().any(|o| o.cause == s.cause && o.at == s.at))
        .collect();
    group.truncate(MOST_RIVALS);
    // Other names of the same body come last.
    for name in &finding.also {
        if group.len() < MOST_RIVALS {
            group.push(Suspect { cause: finding.cause, at: Some(name.clone()), behind: 0.0 });
        }
    }
    group
}

fn ranking(choice: &Choice<'_>) -> Vec<Suspect> {
    const MOST_RANKED: usize = 12;
    let Some(models) = choice.rivals.first() else { return Vec::new() };
    let best = models.first().map_or(0.0, |model| model.worth);
    let mut ranking = suspects(models, 0, best);
    ranking.truncate(MOST_RANKED);
    ranking
}

fn next(
    problem: &Problem<'_>,
    robot: &Robot,
    choice: &Choice<'_>,
) -> (Vec<NextPose>, Vec<(String, &'static str)>) {
    let (mut poses, mut tests) = (Vec::new(), Vec::new());
    for (i, (candidate, _)) in choice.best.fit.hypothesis.effects.iter().enumerate() {
        let own = label(candidate.cause, candidate.at.as_deref());
        for suspect in group(choice, i, candidate) {
            let model = choice.rivals[i].iter().find(|model| {
                let (other, _) = model.fit.hypothesis.effects[i];
                other.cause == suspect.cause && other.at == suspect.at
            });
            let Some(model) = model else { continue };
            let found = poses_between(
                problem.description,
                robot,
                problem.data,
                &choice.best.fit,
                &model.fit,
            );
            if found.is_empty() {
                let pair = format!("{own} or {}", suspect.label());
                tests.push((pair, super::causes::words(candidate.cause).test));
            }
            for (joints, square) in found {
                poses.push(NextPose {
                    joints,
                    separates: [own.clone(), suspect.label()],
                    apart: square.sqrt(),
                });
            }
        }
    }
    (poses, tests)
}

fn residual_rows(data: &Data, before: &Evaluation, after: &Evaluation) -> Vec<ResidualRow> {
    data.points
        .iter()
        .enumerate()
        .map(|(i, point)| {
            let predicted = |evaluation: &Evaluation| {
                evaluation.residuals[i].map(|residual| (point.ln_f - residual).exp())
            };
            ResidualRow {
                row: data.rows[point.row].index,
                mode: point.column,
                measured_hz: point.ln_f.exp(),
                before_hz: predicted(before),
                after_hz: predicted(after),
            }
        })
        .collect()
}
