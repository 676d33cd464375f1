//! What else could open a gap where speed alone cannot: other teeth, the tool turned about its own
//! axis, the work object moved, another spindle, less separation, a better model. Each with the
//! margin that it would reach; none is applied.

use std::cmp::Ordering;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rayon::prelude::*;

use super::choice::choose;
use super::options::Objective;
use super::ranges::{Counting, ModeRange, mode_ranges};
use super::speeds::{Binding, SpeedProblem};
use crate::excitation::lines;
use crate::job::{Job, Operation, Spindle, Tool};
use crate::motion::{Move, Target, Work};
use crate::notes::Note;
use crate::path::{Detail, Path, Survey, grid};
use crate::progress::silent;
use crate::risk::{Rules, SpindleProfile, detail};
use crate::uncertainty::Trust;

/// Angles tried from one end of the free axis to the other, and closer about the best of them.
const ANGLES: usize = 9;
/// No spindle is offered that runs slower than this share of the lowest speed, or faster than this
/// multiple of the highest one: a machine's spindle is replaced by one of its kind.
const SLOWEST: f64 = 0.8;
const FASTEST: f64 = 2.0;
/// A mode that moves the tool tip less than this share of the largest may be left out by choice.
const FAINT: f64 = 0.05;
/// Places tried along each axis along which the work object may be moved.
const PLACES: usize = 3;

/// A change that was tried or worked out.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// Another cutter of those on hand.
    Tool {
        /// What it is called.
        name: Option<String>,
        /// Its teeth.
        teeth: u32,
    },
    /// The tool turned about its own axis along the whole path.
    TurnTool {
        /// By this angle, rad.
        angle_rad: f64,
    },
    /// The work object moved in the base frame.
    MoveWorkObject {
        /// By this, m.
        shift_m: [f64; 3],
    },
    /// A spindle that runs at this speed, too, rev/min.
    Spindle {
        /// The safe speed outside the spindle's range that is nearest to the programmed one.
        rpm: f64,
    },
    /// A threshold of the policy that leaves out one more mode, and those that are fainter.
    Threshold {
        /// Counted from 1 in ascending frequency.
        mode: usize,
        /// What it moves the tool tip at resonance at most, m/N.
        tip_response_m_per_n: f64,
        /// What a mode must then move it to count, m/N.
        min_tip_response_m_per_n: f64,
    },
    /// Bands of this half width, as a share of the frequency.
    Separation {
        /// The largest that leaves a gap.
        separation: f64,
    },
    /// A model that is wrong by no more than this, as a share of the frequency: compare it with
    /// measured frequencies.
    Uncertainty {
        /// The largest that leaves a gap.
        model_uncertainty: f64,
    },
}

/// A change and what it would reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Lever {
    /// What is changed.
    pub change: Change,
    /// The largest |f_exc − f_r| / f_r that a constant speed keeps then; `None` where nothing
    /// counts.
    pub margin: Option<f64>,
    /// The safe speed nearest to the programmed one then, rev/min; `None` where there still is
    /// none.
    pub rpm: Option<f64>,
}

/// Those that open a gap come before those that do not, and of these those with the larger margin.
fn before(a: &Lever, b: &Lever) -> Ordering {
    let margin = |lever: &Lever| lever.margin.unwrap_or(f64::INFINITY);
    a.rpm.is_none().cmp(&b.rpm.is_none()).then(margin(b).total_cmp(&margin(a)))
}

/// The changes that the job allows, the best first, where no constant speed is safe.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn levers(
    job: &Job,
    (operation, index, path): (&Operation, usize, &Path),
    rules: &Rules,
    ranges: &[ModeRange],
    bind: Option<&Binding>,
    programmed_rpm: f64,
) -> Result<Vec<Lever>, Note> {
    let mut found = Vec::new();
    let own = lines(&operation.tool, &job.policy);
    let problem = SpeedProblem::of((job, operation), rules, ranges, &own);
    for tool in job.levers.tools_on_hand.iter().chain(&evenly_pitched(&operation.tool)) {
        let lines = lines(tool, &job.policy);
        let problem = SpeedProblem { lines: &lines, ..problem };
        let change = Change::Tool { name: tool.name.clone(), teeth: tool.teeth };
        found.push(lever(&problem, change, programmed_rpm));
    }
    found.extend(faster_or_slower(&problem, programmed_rpm));
    found.extend(without_a_faint_mode(path, &problem, programmed_rpm)?);
    found.extend(turned(job, operation, index, programmed_rpm)?);
    found.extend(moved(job, operation, programmed_rpm)?);
    if let Some(bind) = bind {
        found.extend(narrower(rules, bind));
    }
    found.sort_by(before);
    Ok(found)
}

/// The cutter with as many teeth at equal angles, which has fewer lines.
fn evenly_pitched(tool: &Tool) -> Option<Tool> {
    tool.pitch_rad.as_ref()?;
    let name = Some("evenly pitched".to_owned());
    Some(Tool { name, pitch_rad: None, ..tool.clone() })
}

fn lever(problem: &SpeedProblem, change: Change, programmed_rpm: f64) -> Lever {
    let set = problem.divide(problem.rules.half_width());
    Lever {
        change,
        margin: problem.widest().map(|bind| bind.separation),
        rpm: choose(problem, &set, Objective::Nearest, programmed_rpm, &[]),
    }
}

/// A spindle with another range: the nearest safe speed beyond this one's.
fn faster_or_slower(problem: &SpeedProblem, programmed_rpm: f64) -> Option<Lever> {
    let within = |min_rpm: f64, max_rpm: f64| Spindle { min_rpm, max_rpm, ..*problem.spindle };
    let Spindle { min_rpm, max_rpm, .. } = *problem.spindle;
    let nearest = |spindle: Spindle| {
        let problem = SpeedProblem { spindle: &spindle, ..*problem };
        let set = problem.divide(problem.rules.half_width());
        choose(&problem, &set, Objective::Nearest, programmed_rpm, &[])
    };
    // Above all blocks there is room for a round speed.
    let beyond_rpm = (problem.highest_block_rpm()? + 10.0).min(FASTEST * max_rpm);
    let slower = nearest(within(SLOWEST * min_rpm, min_rpm));
    let faster = (beyond_rpm > max_rpm).then(|| nearest(within(max_rpm, beyond_rpm))).flatten();
    let rpm = slower
        .into_iter()
        .chain(faster)
        .filter(|rpm| !(min_rpm..=max_rpm).contains(rpm))
        .min_by(|a, b| (a - programmed_rpm).abs().total_cmp(&(b - programmed_rpm).abs()))?;
    let wider = within(min_rpm.min(rpm), max_rpm.max(rpm));
    let margin = SpeedProblem { spindle: &wider, ..*problem }.widest().map(|bind| bind.separation);
    Some(Lever { change: Change::Spindle { rpm }, margin, rpm: Some(rpm) })
}

/// The faintest of the modes that close the speeds left out, by a threshold, if that opens a gap.
fn without_a_faint_mode(
    path: &Path,
    problem: &SpeedProblem,
    programmed_rpm: f64,
) -> Result<Option<Lever>, Note> {
    let stations = grid(path, std::iter::empty());
    let survey = Survey::take(path, stations, Detail::TipResponse, &silent)?;
    let largest_of = |r: usize| {
        let tips = survey.stations().filter_map(|station| station.tip_m_per_n.get(r).copied());
        tips.fold(0.0, f64::max)
    };
    let responses: Vec<f64> = (0..path.robot().coordinates().len()).map(largest_of).collect();
    let largest = responses.iter().copied().fold(0.0, f64::max);
    let mut faint: Vec<usize> =
        (0..responses.len()).filter(|&r| responses[r] < FAINT * largest).collect();
    faint.sort_by(|&a, &b| responses[a].total_cmp(&responses[b]));
    for (before, &r) in faint.iter().enumerate() {
        if !problem.ranges.iter().any(|range| range.mode == r + 1) {
            continue;
        }
        let counts = |range: &&ModeRange| !faint[..=before].contains(&(range.mode - 1));
        let ranges: Vec<ModeRange> = problem.ranges.iter().filter(counts).copied().collect();
        let change = Change::Threshold {
            mode: r + 1,
            tip_response_m_per_n: responses[r],
            // Nobody writes a threshold below 1e-6 µm/N.
            min_tip_response_m_per_n: rounded_up(responses[r].max(1e-12)),
        };
        let found = lever(&SpeedProblem { ranges: &ranges, ..*problem }, change, programmed_rpm);
        if found.rpm.is_some() {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// The next number with two digits, with room for what lies between stations.
fn rounded_up(value: f64) -> f64 {
    let step = 10.0_f64.powf(value.log10().floor() - 1.0);
    if step.is_normal() { (1.01 * value / step).ceil() * step } else { value }
}

/// Narrower bands: by less separation, or by a model that can be trusted further.
fn narrower(rules: &Rules, bind: &Binding) -> Vec<Lever> {
    // Of the widest bands that leave a gap, 99 % leave one wide enough to set a speed in it.
    let wide = 0.99 * bind.separation;
    let mut found = Vec::new();
    let mut push = |change| {
        found.push(Lever { change, margin: Some(bind.separation), rpm: Some(bind.rpm) });
    };
    let (separation, uncertainty) = (rules.policy.separation, rules.uncertainty());
    if wide > uncertainty {
        push(Change::Separation { separation: wide - uncertainty });
    }
    if wide > separation && uncertainty > 0.0 {
        push(Change::Uncertainty { model_uncertainty: wide - separation });
    }
    found
}

/// The tool turned about its own axis: the best angle of those that the whole path can be run with.
fn turned(
    job: &Job,
    operation: &Operation,
    index: usize,
    programmed_rpm: f64,
) -> Result<Option<Lever>, Note> {
    let Some([from, to]) = job.levers.free_axis_rad.get(index).copied().flatten() else {
        return Ok(None);
    };
    let try_angle = |angle_rad: f64| {
        let turn = Isometry3::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad),
        );
        let change = Change::TurnTool { angle_rad };
        tried(job, operation, change, programmed_rpm, &|pose| pose * turn)
    };
    let mut step = (to - from) / (ANGLES - 1) as f64;
    let mut angles: Vec<f64> = (0..ANGLES).map(|i| from + step * i as f64).collect();
    let mut best: Option<(f64, Lever)> = None;
    for _ in 0..=2 {
        let found: Vec<Option<Lever>> =
            angles.par_iter().map(|&angle_rad| try_angle(angle_rad)).collect::<Result<_, _>>()?;
        for (angle_rad, lever) in std::mem::take(&mut angles).into_iter().zip(found) {
            let Some(lever) = lever else { continue };
            if best.as_ref().is_none_or(|(_, best)| before(&lever, best).is_lt()) {
                best = Some((angle_rad, lever));
            }
        }
        let Some((at, _)) = &best else { break };
        step *= 0.5;
        angles = [at - step, at + step].into_iter().filter(|a| (from..=to).contains(a)).collect();
    }
    Ok(best.map(|(_, lever)| lever))
}

/// The work object moved: the best place of a grid over its bounds.
fn moved(job: &Job, operation: &Operation, programmed_rpm: f64) -> Result<Option<Lever>, Note> {
    let Some(bounds) = job.levers.work_object_shift_m else { return Ok(None) };
    // What the arm or a positioner carries stands on no ground that can be moved.
    if operation.moves.iter().any(|each| each.work != Work::Stands) {
        return Ok(None);
    }
    let places = bounds.map(|[least, most]| -> Vec<f64> {
        let count = if most > least { PLACES } else { 1 };
        let steps = (count - 1).max(1) as f64;
        (0..count).map(|i| least + (most - least) * i as f64 / steps).collect()
    });
    let [xs, ys, zs] = &places;
    let shifts: Vec<[f64; 3]> = xs
        .iter()
        .flat_map(|&x| ys.iter().flat_map(move |&y| zs.iter().map(move |&z| [x, y, z])))
        .collect();
    let try_shift = |&shift_m: &[f64; 3]| {
        let shift = Translation3::from(shift_m);
        let change = Change::MoveWorkObject { shift_m };
        tried(job, operation, change, programmed_rpm, &|pose| shift * pose)
    };
    let found: Vec<Option<Lever>> = shifts.par_iter().map(try_shift).collect::<Result<_, _>>()?;
    Ok(found.into_iter().flatten().reduce(|best, lever| {
        let is_better = before(&lever, &best).is_lt();
        if is_better { lever } else { best }
    }))
}

/// What a change of all poses would reach; `None` where the path cannot be run then, or is one of
/// joint positions.
fn tried(
    job: &Job,
    operation: &Operation,
    change: Change,
    programmed_rpm: f64,
    changed: &(dyn Fn(&Isometry3<f64>) -> Isometry3<f64> + Sync),
) -> Result<Option<Lever>, Note> {
    let moves: Option<Vec<Move>> = operation
        .moves
        .iter()
        .map(|a_move| {
            let to = match &a_move.to {
                Target::Joints(_) => return None,
                Target::JointsTo(pose) => Target::JointsTo(changed(pose)),
                Target::Line(pose) => Target::Line(changed(pose)),
                Target::Arc { via, end, turning } => {
                    Target::Arc { via: changed(via), end: changed(end), turning: *turning }
                }
            };
            Some(Move { to, ..a_move.clone() })
        })
        .collect();
    let Some(moves) = moves else { return Ok(None) };
    let robot = &operation.robot;
    let Ok(path) = Path::plan(robot, &moves, operation.start_near.as_deref()) else {
        return Ok(None);
    };
    let path = match operation.is_divided() {
        true => path.stretch(&moves, operation.stretch.clone(), robot),
        false => path,
    };
    let stations = grid(&path, std::iter::empty());
    let survey = Survey::take(&path, stations, detail(&job.policy), &silent)?;
    let trust = Trust::of(robot, job.policy.model_uncertainty);
    let rules = Rules::new(&job.policy, &trust, &path, &survey)?;
    let counting =
        Counting { rules: &rules, spindle: SpindleProfile::new(&operation.speed, &path) };
    let (ranges, _) = mode_ranges(&path, &counting, survey)?;
    let lines = lines(&operation.tool, &job.policy);
    let problem = SpeedProblem::of((job, operation), &rules, &ranges, &lines);
    Ok(Some(lever(&problem, change, programmed_rpm)))
}
