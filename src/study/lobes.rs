//! Modes and a cut → the depth at which it chatters, over spindle speeds.

use std::path::Path;

use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;

use super::{Read, advise};
use crate::excitation::{Lips, coefficients, linear_at};
use crate::input::{FileKind, file_kind, read_tip_cut};
use crate::job::{Cutting, Job, Operation, TipCut, Tool};
use crate::notes::{Code, Note, Place};
use crate::path::{self, tip_modes_of_tool};
use crate::process::arm_modes;
use crate::risk::{Paths, about_operation, assumed_point, in_operation};
use crate::stability::{
    Chart, Cut, DEEPEST_M, ToolMode, coupling_limit, is_misled, is_narrow, milling_limit,
    milling_radius,
};
pub use crate::stability::{Limit, LimitOf, Method};
use crate::units::{Date, hz_from_rad_per_s, hz_from_rpm, m_from_mm, mm_from_m, written};
use crate::wording::counted;

/// What lobes are asked of.
#[derive(Debug, Clone)]
pub enum Subject {
    /// The arm of a job at a place of its path, and its tool.
    Job(Box<Job>),
    /// Modes alone.
    Modes(Box<TipCut>),
}

/// What is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Spindle speeds, rev/min.
    pub speeds_rpm: Vec<f64>,
    /// A depth whose spectral radius is asked for in place of the limit, mm.
    pub depth_mm: Option<f64>,
    /// Place of the path, 0..=1.
    pub at_s: Option<f64>,
    /// The operation; the first that cuts if absent.
    pub operation: Option<String>,
    /// How limits are computed.
    pub method: Method,
}

/// One mode as the tool tip sees it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct SeenMode {
    /// Natural frequency.
    pub frequency_hz: f64,
    /// Share of critical damping.
    pub damping_ratio: f64,
    /// How the tip moves along the feed, across it and out of the work for a unit of the modal
    /// coordinate, 1/√kg.
    pub motion: [f64; 3],
}

/// The limit at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct LimitAt {
    /// Spindle speed.
    pub rpm: f64,
    /// The limit; null where there is none below 1 m.
    pub limit: Option<Limit>,
}

/// The growth of a small motion at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct RadiusAt {
    /// Spindle speed.
    pub rpm: f64,
    /// Axial depth, or width of cut of a drill.
    #[serde(rename = "depth_mm", serialize_with = "written::mm")]
    pub depth_m: f64,
    /// By which factor a small motion grows over one tooth period.
    pub spectral_radius: f64,
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub enum Rows {
    /// The smallest depth, or width of cut of a drill, that chatters, per speed.
    Limits(Vec<LimitAt>),
    /// The growth at a depth, per speed.
    Radii(Vec<RadiusAt>),
}

/// Lobes, with what they stand for.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobes {
    /// What was asked, in words.
    pub title: String,
    /// How it was computed.
    pub method: Method,
    /// What a limit bounds.
    pub limit_of: LimitOf,
    /// The modes, those of the arm first.
    pub modes: Vec<SeenMode>,
    /// Whether a mode of the tool is among them.
    pub has_tool_modes: bool,
    /// What was found.
    pub rows: Rows,
    /// What it does not cover.
    pub warnings: Vec<Note>,
}

/// Reads a job, or a file of modes.
pub fn read(file: &Path, today: Date) -> Read<Subject> {
    match file_kind(file) {
        Ok(FileKind::Modes) => {
            let read = Read::of(|reading| read_tip_cut(file, reading));
            let Read { value, warnings, files } = read;
            Read { value: value.map(|cut| Subject::Modes(Box::new(cut))), warnings, files }
        }
        Ok(_) => {
            let Read { value, warnings, files } = advise::read(file, today);
            Read { value: value.map(|job| Subject::Job(Box::new(job))), warnings, files }
        }
        Err(errors) => {
            Read { value: Err(errors), warnings: Vec::new(), files: vec![file.to_owned()] }
        }
    }
}

/// What vibrates and what it cuts.
struct Setting<'a> {
    title: String,
    modes: Vec<ToolMode>,
    has_tool_modes: bool,
    tool: &'a Tool,
    /// With coefficients that are linear in the chip.
    cutting: Cutting,
    /// About the subject.
    place: Place,
}

/// The lobes that are asked for.
///
/// # Errors
/// What the request asks for and is not there; a place of the path without modes; a cut without
/// coefficients.
pub fn lobes(subject: &Subject, request: &Request) -> Result<Lobes, Vec<Note>> {
    let setting = match subject {
        Subject::Modes(cut) => {
            for (key, is_given) in
                [("at", request.at_s.is_some()), ("operation", request.operation.is_some())]
            {
                if is_given {
                    let what = "is for jobs: a file of modes has no path";
                    return Err(vec![usage(key, what.to_owned())]);
                }
            }
            of_modes(cut)
        }
        Subject::Job(job) => of_job(job, request)?,
    };
    let Setting { title, modes, has_tool_modes, tool, cutting, place } = setting;
    let cutting = &cutting;
    let Some(cut) = Cut::new(tool, cutting) else {
        return Err(vec![Note::error(Code::MissingKey, place, lacks(tool, cutting))]);
    };
    if request.depth_mm.is_some() && !cutting.regenerates {
        let what = "the growth over a tooth period is that of a cut that regenerates, and \
                    cutting.regeneration is false: leave the option away for the depth at which \
                    modes feed each other, or take the key away";
        return Err(vec![usage("depth-mm", what.to_owned())]);
    }
    let drill = cutting.drill();
    let method = match (request.depth_mm, cutting.regenerates) {
        (Some(_), _) => Method::Exact,
        (None, true) if drill.is_none() => request.method,
        // What the motion meets is the mean alone.
        (None, _) => Method::Zeroth,
    };
    let mut warnings = Vec::new();
    let mut warn = |what: &str| {
        let what = what.to_owned();
        warnings.push(Note::warning(Code::Remark, place.clone(), what));
    };
    if !has_tool_modes {
        warn(
            "the tool has no modes (tool.modes), so this stands for the arm's modes alone: at \
             milling speeds it is the tool that chatters first",
        );
    }
    if let Some(lips) = drill.and_then(|drill| Lips::new(tool, drill)) {
        warn(
            "limits are of a drill's width of cut, half of what its diameter is above that of the \
             hole before it, in the motion along its axis: the side, the twist and the chisel edge \
             are not looked at",
        );
        if lips.is_point_assumed {
            warn(&assumed_point(&lips));
        }
    } else if coefficients(cutting).is_some_and(|own| own.axial.is_none()) {
        warn("no axial coefficient (kac_n_per_mm2), so the force along the spindle is left out");
    }
    if method == Method::Zeroth && cutting.regenerates && drill.is_none() {
        match misled_at(&modes, &cut, &request.speeds_rpm) {
            Some((rpm, limits_m)) => {
                let [zeroth, exact] = limits_m.map(|m| format!("{:.4}", mm_from_m(m)));
                let zeroth = if limits_m[0] < DEEPEST_M { zeroth + " mm" } else { "none".into() };
                warn(&format!(
                    "the zeroth order is misled: at {rpm} rpm the exact limit is {exact} mm, its \
                     own is {zeroth}; use --method exact"
                ));
            }
            None if is_narrow(tool, cutting) => warn(
                "the radial depth is below a quarter of the diameter, where the zeroth order may \
                 be wrong by a factor of two; use --method exact",
            ),
            None => {}
        }
    }
    let rows = rows(&modes, &cut, cutting, (request, method))
        .map_err(|what| vec![Note::error(Code::NotConverged, place.clone(), what)])?;
    let seen = |mode: &ToolMode| SeenMode {
        frequency_hz: hz_from_rad_per_s(mode.omega_rad_per_s),
        damping_ratio: mode.damping_ratio,
        motion: mode.motion.into(),
    };
    let modes = modes.iter().map(seen).collect();
    let limit_of = cut.limit_of();
    Ok(Lobes { title, method, limit_of, modes, has_tool_modes, rows, warnings })
}

/// Of some of the speeds the one at which the zeroth order exceeds the exact limit most, with both
/// limits, m; 1 m where there is none.
fn misled_at(modes: &[ToolMode], cut: &Cut, speeds_rpm: &[f64]) -> Option<(f64, [f64; 2])> {
    const PROBED: usize = 12;
    let chart = Chart::new(modes, cut);
    let limits = |rpm: f64| {
        let exact_m = milling_limit(modes, cut, &chart, rpm).ok().flatten()?.depth_m;
        let zeroth_m = chart.limit(rpm).map_or(DEEPEST_M, |limit| limit.depth_m);
        is_misled(zeroth_m, exact_m).then_some((rpm, [zeroth_m, exact_m]))
    };
    let step = speeds_rpm.len().div_ceil(PROBED).max(1);
    let probed: Vec<f64> = speeds_rpm.iter().copied().step_by(step).collect();
    let found: Vec<(f64, [f64; 2])> = probed.into_par_iter().filter_map(limits).collect();
    let share = |(_, [zeroth_m, exact_m]): &(f64, [f64; 2])| exact_m / zeroth_m;
    found.into_iter().min_by(|a, b| share(a).total_cmp(&share(b)))
}

fn rows(
    modes: &[ToolMode],
    cut: &Cut,
    cutting: &Cutting,
    (request, method): (&Request, Method),
) -> Result<Rows, String> {
    let lost = |rpm: f64, depth_m: f64| {
        format!(
            "the exact method finds no growth at {rpm} rpm and {:.4} mm: the tooth period is long \
             beside that of the fastest mode; ask for higher speeds, or for --method zeroth \
             without --depth-mm",
            mm_from_m(depth_m)
        )
    };
    if let Some(depth_mm) = request.depth_mm {
        let depth_m = m_from_mm(depth_mm);
        let of = |rpm: &f64| {
            let radius = milling_radius(modes, cut, *rpm, depth_m);
            let spectral_radius = radius.ok_or_else(|| lost(*rpm, depth_m))?;
            Ok(RadiusAt { rpm: *rpm, depth_m, spectral_radius })
        };
        return request.speeds_rpm.par_iter().map(of).collect::<Result<_, _>>().map(Rows::Radii);
    }
    if !cutting.regenerates {
        let limit = coupling_limit(&cut.in_axes(modes), &cut.mean());
        let of = |rpm: &f64| LimitAt { rpm: *rpm, limit };
        return Ok(Rows::Limits(request.speeds_rpm.iter().map(of).collect()));
    }
    let chart = Chart::new(modes, cut);
    let of = |rpm: &f64| {
        let limit = match method {
            Method::Zeroth => chart.limit(*rpm),
            Method::Exact => {
                milling_limit(modes, cut, &chart, *rpm).map_err(|depth_m| lost(*rpm, depth_m))?
            }
        };
        Ok(LimitAt { rpm: *rpm, limit })
    };
    request.speeds_rpm.par_iter().map(of).collect::<Result<_, _>>().map(Rows::Limits)
}

/// Why nothing can be said of a cut.
fn lacks(tool: &Tool, cutting: &Cutting) -> String {
    match coefficients(cutting) {
        None => format!(
            "cutting.material is '{}', must be al-6061, al-6082 or al-7075, or give \
             cutting.coefficients",
            cutting.material
        ),
        Some(_) if tool.helix_rad > 0.0 => {
            "no tool.diameter_mm, which radial_depth_mm and helix_deg need".to_owned()
        }
        Some(_) => "no tool.diameter_mm, which radial_depth_mm needs".to_owned(),
    }
}

fn of_modes(cut: &TipCut) -> Setting<'_> {
    Setting {
        title: format!("{} of the tool tip", counted(cut.modes.len(), "mode")),
        modes: cut.modes.iter().map(ToolMode::from).collect(),
        has_tool_modes: true,
        tool: &cut.tool,
        cutting: cut.cutting.clone(),
        place: Place::default(),
    }
}

fn of_job<'a>(job: &'a Job, request: &Request) -> Result<Setting<'a>, Vec<Note>> {
    let at_s = request.at_s.unwrap_or(0.0);
    if !(0.0..=1.0).contains(&at_s) {
        let what = format!("is {at_s}, must lie between 0 and 1");
        return Err(vec![usage("at", what)]);
    }
    let operation = match &request.operation {
        Some(name) => job.operations.iter().find(|each| each.name == *name).ok_or_else(|| {
            let names: Vec<&str> = job.operations.iter().map(|each| each.name.as_str()).collect();
            let names = names.join(", ");
            vec![usage("operation", format!("'{name}' is not among those of the job: {names}"))]
        })?,
        None => {
            let cuts = |each: &&Operation| each.cutting.is_some();
            let first = job.operations.iter().find(cuts).or(job.operations.first());
            first.ok_or_else(|| vec![usage("operation", "the job has none".to_owned())])?
        }
    };
    let place = about_operation(job, operation, Code::MissingKey, String::new()).place;
    let Some(cutting) = &operation.cutting else {
        let what = "no 'cutting', which stability needs".to_owned();
        return Err(vec![Note::error(Code::MissingKey, place, what)]);
    };
    let path = Paths::of(job).plan(operation)?;
    let at = tip_modes_of_tool(&path, &[at_s])
        .map_err(|note| vec![in_operation(job, operation, note)])?;
    let of_arm = at.first().map(arm_modes).unwrap_or_default();
    let mut modes: Vec<ToolMode> = of_arm.into_iter().map(|one| one.mode).collect();
    modes.extend(operation.tool.modes.iter().map(ToolMode::from));
    Ok(Setting {
        title: format!("{}: {} at s = {at_s}", job.name, operation.name),
        modes,
        has_tool_modes: !operation.tool.modes.is_empty(),
        tool: &operation.tool,
        cutting: linear(operation, cutting, &path, at_s),
        place,
    })
}

/// A fault of an option.
fn usage(key: &'static str, what: String) -> Note {
    Note::error(Code::Usage, Place { key, ..Place::default() }, what)
}

/// A cut with coefficients that are linear about the chip at the speed and feed of a place.
fn linear(operation: &Operation, cutting: &Cutting, path: &path::Path, at_s: f64) -> Cutting {
    let rpm = operation.speed.rpm_at(at_s);
    let teeth_per_s = hz_from_rpm(rpm) * f64::from(operation.tool.teeth);
    let feed_per_tooth_m = path.feed_m_per_s_at(at_s) / teeth_per_s;
    let linear = coefficients(cutting)
        .filter(|own| !own.is_linear())
        .and_then(|_| linear_at(&operation.tool, cutting, feed_per_tooth_m));
    Cutting { coefficients: linear.or(cutting.coefficients), ..cutting.clone() }
}
