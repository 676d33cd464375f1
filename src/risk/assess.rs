//! One job → its risk.

use std::sync::Arc;

use super::about::{about_operation, in_operation};
use super::bands::LineBands;
use super::certainty::Certainty;
use super::crossings;
use super::left_out::left_out;
use super::margin::closest_approach;
use super::operation_notes::{implausible_frequency, on_operation};
use super::probability::{ArmDraws, JobDraws, Probabilities, driver, probabilities};
use super::rules::Rules;
use super::speed_change::SpindleRun;
use super::spindle_profile::SpindleProfile;
use super::tool_tip;
use super::verdict::{
    Crossing, JobRisk, LeftOut, ModeExchange, OperationRisk, Sample, SpeedPoint, Verdict, Warning,
};
use super::warnings::{unused, warnings};
use crate::excitation::lines;
use crate::job::{Job, Operation, Policy, SpindleSpeed};
use crate::motion::Move;
use crate::notes::{Code, Note};
use crate::path::{Detail, MAX_GAP, ModalPose, Path, Survey, Surveyor, follow, grid};
use crate::progress::Progress;
use crate::uncertainty::{Draws, Trust, largest_by_mode};

/// Checks every operation of a job: plans its path, looks at the arm along it and finds where
/// excitation lines lie in the modes' bands.
///
/// # Errors
/// What cannot be run, for every operation.
pub fn assess(job: &Job, progress: Progress) -> Result<JobRisk, Vec<Note>> {
    let (mut faults, mut all) = (Vec::new(), Vec::new());
    let mut operations: Vec<OperationRisk> = Vec::new();
    let mut draws = JobDraws::default();
    let mut rings = Vec::new();
    let (mut paths, mut spindle) = (Paths::of(job), SpindleRun::default());
    for operation in &job.operations {
        let along = (&mut paths, &mut draws, &mut spindle);
        match assess_operation(job, operation, along, progress) {
            Ok((risk, of_operation, of_draws)) => {
                operations.push(risk);
                all.extend(of_operation);
                rings.resize(of_draws.len(), false);
                rings.iter_mut().zip(of_draws).for_each(|(all, own)| *all |= own);
            }
            Err(found) => faults.extend(found),
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    all.extend(implausible_frequency(job, &operations));
    let mut warnings = warnings(job, job.review.warnings.iter().cloned().chain(all));
    warnings.extend(unused(job, &warnings, &operations).into_iter().map(Warning::from));
    for operation in &mut operations {
        let own = warnings.iter().filter(|warning| warning.is_about(&operation.name));
        let best = own.map(Warning::best_verdict).max();
        operation.verdict = operation.verdict.max(best.unwrap_or(Verdict::Clear));
    }
    Ok(JobRisk {
        verdict: operations.iter().map(|o| o.verdict).max().unwrap_or(Verdict::Clear),
        calibrated: job.robot.calibration().is_some(),
        payload: job.carried(),
        model_uncertainty: operations.iter().map(|o| o.model_uncertainty).fold(0.0, f64::max),
        uncertainty_by_mode: largest_by_mode(
            operations.iter().map(|o| o.uncertainty_by_mode.as_slice()),
        ),
        probability: Draws::share(&rings),
        separation: job.policy.separation,
        coordinates: job.robot.coordinates().iter().map(|c| c.name.clone()).collect(),
        operations,
        warnings,
    })
}

fn assess_operation<'j>(
    job: &Job,
    operation: &'j Operation,
    (paths, draws, spindle): (&mut Paths<'j>, &mut JobDraws, &mut SpindleRun<'j>),
    progress: Progress,
) -> Result<(OperationRisk, Vec<Note>, Vec<bool>), Vec<Note>> {
    let path = paths.plan(operation)?;
    let (risk, rings, of_cut) = survey_operation(job, operation, &path, draws, progress)
        .map_err(|note| vec![in_operation(job, operation, note)])?;
    let mut notes = on_operation(job, operation, &path, &risk);
    notes.extend(spindle.cuts_too_early(job, operation, &path));
    notes.extend(of_cut);
    Ok((risk, notes, rings))
}

/// The paths of a job's operations: one that is divided is planned whole, once, so that the arm
/// runs each stretch as it runs the whole.
#[derive(Debug)]
pub struct Paths<'a> {
    job: &'a Job,
    /// The last path that is divided, with the moves that it was planned from; `None` in place of
    /// one that cannot be run.
    whole: Option<(&'a Arc<Vec<Move>>, Option<Path<'a>>)>,
}

impl<'a> Paths<'a> {
    /// Those of a job.
    pub fn of(job: &'a Job) -> Self {
        Self { job, whole: None }
    }

    /// The path of an operation of the job.
    ///
    /// # Errors
    /// What cannot be run: of a path that is divided with its first stretch, with the others none.
    pub fn plan(&mut self, operation: &'a Operation) -> Result<Path<'a>, Vec<Note>> {
        let robot = &operation.robot;
        let moves = &operation.moves;
        let run = || {
            let in_operation = |note| in_operation(self.job, operation, note);
            Path::plan(robot, moves, operation.start_near.as_deref())
                .map_err(|errors| errors.into_iter().map(in_operation).collect())
        };
        if !operation.is_divided() {
            return run();
        }
        let (path, errors) = match self.whole.take() {
            Some((of, path)) if Arc::ptr_eq(of, moves) => (path, Vec::new()),
            _ => run().map_or_else(|errors| (None, errors), |path| (Some(path), Vec::new())),
        };
        let stretch =
            path.as_ref().map(|path| path.stretch(moves, operation.stretch.clone(), robot));
        self.whole = Some((moves, path));
        stretch.ok_or(errors)
    }
}

/// What must be read along a path for a policy: tip response costs mode shapes, so only where the
/// policy asks about it.
pub fn detail(policy: &Policy) -> Detail {
    if policy.min_tip_response_m_per_n != Some(0.0) {
        Detail::TipResponse
    } else {
        Detail::Frequencies
    }
}

/// Where excitation lines lie in bands on the path of an operation under a spindle speed, with the
/// survey refined so far that none hides. `first_look` holds the stations of [`grid`] at least,
/// with the [`detail`] of the policy.
///
/// # Errors
/// The arm has no modes somewhere.
pub fn crossings_under(
    job: &Job,
    operation: &Operation,
    rules: &Rules,
    speed: &SpindleSpeed,
    path: &Path,
    first_look: Survey,
) -> Result<(Vec<Crossing>, Survey), Note> {
    let spindle = SpindleProfile::new(speed, path);
    let (lowest_hz, highest_hz) = first_look.range_hz();
    let file = job.named_file_of_moves(operation);
    let lines_bands: Vec<LineBands> = lines(&operation.tool, &job.policy)
        .into_iter()
        .map(|line| LineBands::new(line, &spindle, rules, file))
        .filter(|bands| bands.can_meet(lowest_hz, highest_hz))
        .collect();
    let survey = first_look.refine(path, |left, right, rates| {
        lines_bands.iter().any(|bands| {
            rates.iter().enumerate().any(|(r, &rate)| bands.needs_halving(left, right, r, rate))
        })
    })?;
    let mut surveyor = Surveyor::new(path);
    let mut found: Vec<Crossing> = Vec::new();
    for bands in &lines_bands {
        found.extend(crossings::find(bands, path, &survey, &mut surveyor)?);
    }
    found.sort_by(|a, b| {
        a.from_s
            .total_cmp(&b.from_s)
            .then(a.mode.cmp(&b.mode))
            .then(a.line.order.cmp(&b.line.order))
    });
    Ok((found, survey))
}

/// Draws of the arm for an operation, with the survey under `rules` and what it crosses there.
///
/// # Errors
/// The arm has no modes somewhere.
pub fn probabilities_under(
    job: &Job,
    operation: &Operation,
    rules: &Rules,
    draws: &ArmDraws,
    path: &Path,
    (survey, crossings): (&Survey, &[Crossing]),
) -> Result<Probabilities, Note> {
    let spindle = &SpindleProfile::new(&operation.speed, path);
    let file = job.named_file_of_moves(operation);
    let bands = |line| LineBands::new(line, spindle, rules, file);
    let all: Vec<LineBands> = lines(&operation.tool, &job.policy).into_iter().map(bands).collect();
    let is_open = |mode| job.review.of_crossing(&operation.name, mode).is_none();
    probabilities(draws, &all, path, survey, crossings, is_open)
}

fn survey_operation(
    job: &Job,
    operation: &Operation,
    path: &Path,
    draws: &mut JobDraws,
    progress: Progress,
) -> Result<(OperationRisk, Vec<bool>, Vec<Note>), Note> {
    let trust = Trust::of(&operation.robot, job.policy.model_uncertainty);
    let draws = draws.of(&trust, path.robot().coordinates().len());
    let lines = lines(&operation.tool, &job.policy);
    let spindle = SpindleProfile::new(&operation.speed, path);
    let stations = grid(path, operation.speed.corners());
    let first_look = Survey::take(path, stations, detail(&job.policy), progress)?;
    let rules = Rules::new(&job.policy, &trust, path, &first_look)?;
    let (mut found, survey) =
        crossings_under(job, operation, &rules, &operation.speed, path, first_look)?;
    let probabilities =
        probabilities_under(job, operation, &rules, &draws, path, (&survey, &found))?;
    let mut surveyor = Surveyor::new(path);
    for (crossing, probability) in found.iter_mut().zip(probabilities.crossings) {
        crossing.driver = driver(&trust, &mut surveyor, crossing)?;
        crossing.probability = Some(probability.probability);
        let entry = job.review.of_crossing(&operation.name, crossing.mode);
        crossing.accepted = entry.map(|entry| entry.terms.clone());
    }

    let shown = shown(&survey);
    let cut = tool_tip::look(job, operation, path, (&rules, &shown))?;
    let mut of_cut = tool_tip::notes(job, operation, &cut);
    of_cut.extend(tool_tip::assumed(job, operation, &cut));
    let left_out = left_out(&lines, &operation.speed, &rules, &survey);
    of_cut.extend(left_out_for_want_of_a_tcp(job, operation, &rules, path, (&survey, &left_out))?);
    let families = follow(path, &shown)?;
    let samples: Vec<Sample> = shown
        .iter()
        .zip(families.of.into_iter().zip(families.poses))
        .map(|(&s, (families, pose))| sample(path, &spindle, &rules, s, families, pose))
        .collect();
    let [spindle_min_rpm, spindle_max_rpm] = operation.speed.range_rpm();
    let share = Draws::share(&probabilities.rings);
    let uncertainty_by_mode = rules.uncertainty_by_mode(path.robot().coordinates().len());
    let risk = OperationRisk {
        name: operation.name.clone(),
        program: operation.program.clone(),
        verdict: worst(&found),
        tool: operation.tool_number,
        payload: operation.carried,
        spindle_rpm: operation.speed.rpm_at(0.0),
        spindle_min_rpm,
        spindle_max_rpm,
        spindle_schedule: match &operation.speed {
            SpindleSpeed::Constant(_) => None,
            SpindleSpeed::Schedule(points) => {
                Some(points.iter().map(|&(s, rpm)| SpeedPoint { s, rpm }).collect())
            }
        },
        duration_s: path.duration_s(),
        left_out,
        closest: closest_approach(&samples, &lines, &job.policy, rules.min_tip_response_m_per_n),
        lines,
        probability: share.probability,
        probability_std_error: share.std_error,
        min_tip_response_m_per_n: rules.min_tip_response_m_per_n,
        model_uncertainty: uncertainty_by_mode.iter().copied().fold(0.0, f64::max),
        uncertainty_by_mode,
        poses_solved: survey.len(),
        samples,
        crossings: found,
        mode_exchanges: families
            .exchanges
            .iter()
            .map(|e| ModeExchange { s: e.s, lower_mode: e.lower_mode + 1 })
            .collect(),
        tool_tip: cut.tool_tip.ok(),
        stability: cut.stability,
    };
    Ok((risk, probabilities.rings, of_cut))
}

/// How much a mode moves the tool hangs on where the tool ends: what a line meets among modes that
/// were left out by the usual limit, where nobody says it.
fn left_out_for_want_of_a_tcp(
    job: &Job,
    operation: &Operation,
    rules: &Rules,
    path: &Path,
    (survey, left_out): (&Survey, &LeftOut),
) -> Result<Option<Note>, Note> {
    let is_usual = job.policy.min_tip_response_m_per_n.is_none();
    if !operation.is_tcp_assumed || !is_usual || left_out.modes.is_empty() {
        return Ok(None);
    }
    let all = rules.of_every_mode();
    let (met, _) = crossings_under(job, operation, &all, &operation.speed, path, survey.clone())?;
    let first = met.iter().find(|crossing| left_out.modes.contains(&crossing.mode));
    Ok(first.map(|crossing| {
        let what = format!(
            "no tcp is stated: mode {} hardly moves the robot's tip, at which the tool is taken to \
             end, and is left out; a line of {:.1} Hz meets it from s = {:.3} on; state tcp",
            crossing.mode, crossing.excitation_hz, crossing.from_s
        );
        about_operation(job, operation, Code::TcpAssumed, what)
    }))
}

/// The worst of the crossings that are not accepted.
fn worst(crossings: &[Crossing]) -> Verdict {
    let of_crossing = |crossing: &Crossing| match crossing.certainty {
        Certainty::Certain => Verdict::Resonance,
        Certainty::Uncertain => Verdict::Uncertain,
    };
    let open = crossings.iter().filter(|crossing| crossing.accepted.is_none());
    open.map(of_crossing).max().unwrap_or(Verdict::Clear)
}

/// Stations that become samples: all, or so many that neighbours are no more than [`MAX_GAP`]
/// apart.
fn shown(survey: &Survey) -> Vec<f64> {
    let all: Vec<f64> = survey.stations().map(|station| station.s).collect();
    if all.len() <= 5000 {
        return all;
    }
    let mut shown: Vec<f64> = Vec::new();
    for pair in all.windows(2) {
        if shown.last().is_none_or(|last| pair[1] - last > MAX_GAP) {
            shown.push(pair[0]);
        }
    }
    shown.extend(all.last());
    shown
}

fn sample(
    path: &Path,
    spindle: &SpindleProfile,
    rules: &Rules,
    s: f64,
    families: Vec<Option<usize>>,
    pose: ModalPose,
) -> Sample {
    let ModalPose { joints, natural_frequencies_hz, tip_response_m_per_n } = pose;
    Sample {
        s,
        beta1_rad: path.robot().beta1().map(|angle| angle.at(&joints)),
        beta2_rad: path.robot().beta2().map(|angle| angle.at(&joints)),
        rpm: spindle.rpm_at(s),
        natural_frequencies_ci95_hz: natural_frequencies_hz
            .iter()
            .enumerate()
            .map(|(r, &hz)| rules.interval_hz(s, r, hz))
            .collect(),
        natural_frequencies_hz,
        tip_response_m_per_n,
        families,
        joints,
    }
}
