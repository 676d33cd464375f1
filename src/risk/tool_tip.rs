//! What the cut does at the tool tip along a path, and where that is more than the policy allows.

use std::path::PathBuf;

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;

use super::about::{about_operation, in_operation};
use super::certainty::Certainty;
use super::rules::Rules;
use super::spindle_profile::SpindleProfile;
use crate::excitation::Lips;
use crate::excitation::{ExcitationLine, Source, WithoutOrder};
use crate::job::{Cutting, Job, Operation, Policy, SpindleSpeed};
use crate::notes::{Code, Note, Place};
use crate::path::Path;
use crate::process::{
    AtPlace, Chatter, Doubtful, DrillingAt, Effects, NoForce, Seen, Spread, TipPlace, chatter,
    force_of, sure_ones, tip_places,
};
use crate::units::{deg_from_rad, hz_from_rpm, percent_from_ratio, um_from_m, written};

/// Stability is worked out at the places nearest to so many equal parts of the path.
const STABILITY_PARTS: usize = 40;

/// What the tool tip does is shown at the places nearest to so many equal parts.
const SHOWN_PARTS: usize = 200;

/// A harmonic is told that reaches this share of the largest.
const TOLD_SHARE: f64 = 0.01;

/// What a limit is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`deflection`: under the mean cutting force. `vibration`: under its harmonics."
)]
pub enum Quantity {
    /// Under the mean cutting force.
    Deflection,
    /// Under its harmonics.
    Vibration,
}

/// The largest of a quantity along the path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Largest {
    /// As the model has it.
    #[serde(rename = "largest_um", serialize_with = "written::um")]
    pub largest_m: f64,
    /// Where, 0 to 1.
    pub s: f64,
    /// Line that is run there.
    pub line: usize,
    /// What it may come to anywhere: every frequency where it is worst within its interval, the
    /// coefficients of a material as laboratories have them.
    #[serde(rename = "up_to_um", serialize_with = "written::um")]
    pub up_to_m: f64,
}

/// The error of the surface that is farthest off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceError {
    /// Material that is left; below zero where too much is taken. Of a slot the side that is
    /// farther off.
    #[serde(rename = "error_um", serialize_with = "written::um")]
    pub error_m: f64,
    /// Where, 0 to 1.
    pub s: f64,
    /// Line that is run there.
    pub line: usize,
}

/// Thrust and torque of a drill, and how far they move its tip to the side.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "DrillingAlong")]
pub struct Drilling {
    /// The largest thrust along the path, as the model has it.
    pub thrust_n: f64,
    /// What it may come to.
    pub thrust_up_to_n: f64,
    /// Whether that is a lower bound: the chisel edge, which carries about half of the thrust or
    /// more, is not in it, so no limit is kept for sure.
    pub is_lower_bound: bool,
    /// Whether it also moves across its axis at about the operation's feed: what that does to the
    /// work is not known, so no limit is kept for sure.
    pub leaves_axis: bool,
    /// The largest torque; null where it is not known: it is left out of the deflection,
    /// of which no limit is kept for sure.
    pub torque_nm: Option<f64>,
    /// Half of the point angle.
    #[serde(rename = "half_point_angle_deg", serialize_with = "written::deg")]
    pub half_point_rad: f64,
    /// Whether that is a guess which the thrust or the limit of chatter rests on.
    pub is_point_angle_assumed: bool,
    /// How far both move the tip across the axis, as the model has it, the largest along the path:
    /// how far the drill skids.
    #[serde(rename = "skid_um", serialize_with = "written::um")]
    pub skid_m: f64,
    /// Where, 0 to 1.
    pub skid_s: f64,
    /// Line that is run there.
    pub skid_line: usize,
}

/// The largest amplitude of a harmonic along the path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ToolTipHarmonic")]
pub struct Harmonic {
    /// Which.
    #[serde(flatten, with = "WithoutOrder")]
    pub line: ExcitationLine,
    /// Its frequency there.
    pub excitation_hz: f64,
    /// √(|u_x|² + |u_y|² + |u_z|²).
    #[serde(rename = "amplitude_um", serialize_with = "written::um")]
    pub amplitude_m: f64,
    /// Where, 0 to 1.
    pub s: f64,
}

/// A stretch on which the tool tip moves farther than the policy allows.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Excess")]
pub struct Excess {
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub quantity: Quantity,
    /// `certain`: as the model has it; `uncertain`: within what model and coefficients may be wrong
    /// by.
    pub certainty: Certainty,
    /// What the policy allows.
    #[serde(rename = "limit_um", serialize_with = "written::um")]
    pub limit_m: f64,
    /// The largest on the stretch, as the model has it.
    #[serde(rename = "largest_um", serialize_with = "written::um")]
    pub largest_m: f64,
    /// What it may come to there.
    #[serde(rename = "up_to_um", serialize_with = "written::um")]
    pub up_to_m: f64,
    /// Where it starts, 0 to 1.
    pub from_s: f64,
    /// Where it ends, 0 to 1.
    pub to_s: f64,
    /// Where it is largest.
    pub largest_s: f64,
    /// The file that the lines refer to, as in crossings.
    #[serde(serialize_with = "written::path")]
    pub file: PathBuf,
    /// The lowest line that is run between from_s and to_s, counted from 1.
    pub from_line: usize,
    /// The highest line that is run between from_s and to_s.
    pub to_line: usize,
}

/// How far the tool tip moves at one place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct TipAt {
    /// Share of the operation's time, 0 to 1.
    pub s: f64,
    /// Line that is run there.
    pub line: usize,
    /// Under the mean cutting force, and what that may come to.
    #[serde(rename = "deflection_um", serialize_with = "written::um")]
    pub deflection_m: [f64; 2],
    /// Under its harmonics, and what that may come to.
    #[serde(rename = "vibration_um", serialize_with = "written::um")]
    pub vibration_m: [f64; 2],
}

/// What the cut does at the tool tip.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToolTip {
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub modes: Seen,
    /// How far the mean cutting force moves the tip.
    pub deflection: Largest,
    /// How far it vibrates: the root of the sum of the squared amplitudes of the harmonics.
    pub vibration: Largest,
    /// What both leave on the surface; null in drilling.
    pub surface_error: Option<SurfaceError>,
    /// What a drill does beside; null in milling.
    pub drilling: Option<Drilling>,
    /// Both at up to 203 places where the tool surely cuts, those of the largest among them,
    /// ascending in s.
    pub along: Vec<TipAt>,
    /// Its harmonics that reach a hundredth of the largest, ascending in frequency.
    pub harmonics: Vec<Harmonic>,
    /// Where the policy allows less, ascending in from_s.
    pub beyond: Vec<Excess>,
}

/// What the cut does along the path of an operation.
#[derive(Debug)]
pub(super) struct Cut {
    /// Or why a limit of the policy cannot be held against it.
    pub(super) tool_tip: Result<ToolTip, NoForce>,
    pub(super) stability: Option<Chatter>,
}

/// What limits of the policy say of an operation at another speed, at which every feed is so many
/// times the programmed one.
///
/// # Errors
/// The arm has no modes somewhere.
pub fn limits_at_speed(
    job: &Job,
    operation: &Operation,
    path: &Path,
    looked: (&Rules, &[f64]),
    speed: (SpindleSpeed, f64),
) -> Result<Vec<Note>, Note> {
    if limits(&job.policy).next().is_none() {
        return Ok(Vec::new());
    }
    let tool_tip = tool_tip_at_speed(job, operation, path, looked, speed)?;
    Ok(notes(job, operation, &Cut { tool_tip, stability: None }))
}

/// Where, 0 to 1, one of these limits is surely exceeded most; `None` where none is.
///
/// # Errors
/// As above.
pub fn exceeded_at_speed(
    job: &Job,
    operation: &Operation,
    path: &Path,
    looked: (&Rules, &[f64]),
    speed: (SpindleSpeed, f64),
) -> Result<Option<f64>, Note> {
    if limits(&job.policy).next().is_none() {
        return Ok(None);
    }
    let Ok(tip) = tool_tip_at_speed(job, operation, path, looked, speed)? else { return Ok(None) };
    let sure = tip.beyond.iter().filter(|of| of.certainty == Certainty::Certain);
    let share = |of: &Excess| of.largest_m / of.limit_m;
    Ok(sure.max_by(|a, b| share(a).total_cmp(&share(b))).map(|most| most.largest_s))
}

fn tool_tip_at_speed(
    job: &Job,
    operation: &Operation,
    path: &Path,
    (rules, stations): (&Rules, &[f64]),
    (speed, feed_ratio): (SpindleSpeed, f64),
) -> Result<Result<ToolTip, NoForce>, Note> {
    let operation = &Operation { speed, ..operation.clone() };
    let mut places = cutting_places(operation, path, stations)?;
    for place in &mut places {
        place.feed_per_tooth_m *= feed_ratio;
    }
    Ok(tool_tip(job, operation, path, (rules, stations), &places))
}

/// Looks at the stations of a survey at which the tool cuts.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn look(
    job: &Job,
    operation: &Operation,
    path: &Path,
    (rules, stations): (&Rules, &[f64]),
) -> Result<Cut, Note> {
    if let Err(why) = force_of(operation) {
        return Ok(Cut { tool_tip: Err(why), stability: None });
    }
    let places = cutting_places(operation, path, stations)?;
    let tool_tip = tool_tip(job, operation, path, (rules, stations), &places);
    let std_ln = |s: f64, mode: usize| rules.std_ln(s, mode - 1);
    let spread = Spread { confidence: job.policy.confidence, std_ln: &std_ln };
    let places = thinned(&sure_ones(places));
    let stability = chatter(operation, &places, |s| path.line_at(s), spread);
    Ok(Cut { tool_tip, stability })
}

/// The places nearest to i / 40, the first and the last among them.
fn thinned(places: &[TipPlace]) -> Vec<TipPlace> {
    let s: Vec<f64> = places.iter().map(|place| place.s).collect();
    let taken = nearest_to_parts(&s, STABILITY_PARTS);
    places.iter().filter(|place| taken.contains(&place.s)).cloned().collect()
}

/// Those of `s`, ascending in 0..=1, that are nearest to the ends of equal parts of the path.
fn nearest_to_parts(s: &[f64], parts: usize) -> Vec<f64> {
    let nearest = |i: usize| {
        let end = i as f64 / parts as f64;
        let after = s.partition_point(|s| *s < end);
        let beside = &s[after.saturating_sub(1)..(after + 1).min(s.len())];
        beside.iter().copied().min_by(|a, b| (a - end).abs().total_cmp(&(b - end).abs()))
    };
    (0..=parts).filter_map(nearest).collect()
}

fn cutting_places(
    operation: &Operation,
    path: &Path,
    stations: &[f64],
) -> Result<Vec<TipPlace>, Note> {
    let spindle = SpindleProfile::new(&operation.speed, path);
    tip_places(operation, path, stations, |s| !spindle.is_stopped_at(s))
}

fn tool_tip(
    job: &Job,
    operation: &Operation,
    path: &Path,
    (rules, stations): (&Rules, &[f64]),
    places: &[TipPlace],
) -> Result<ToolTip, NoForce> {
    let effects = Effects::new(operation, places)?;
    let at =
        |place: &TipPlace| effects.at(place, |mode, hz| rules.interval_hz(place.s, mode - 1, hz));
    let found: Option<Vec<AtPlace>> = places.par_iter().map(at).collect();
    let found = found.ok_or(NoForce::NotFinite)?;
    if found.is_empty() {
        return Err(NoForce::OnlyAir);
    }
    let has_tool = !operation.tool.modes.is_empty();
    let is_any_sure = found.iter().any(|at| at.is_sure);
    let sure: Vec<&AtPlace> = found.iter().filter(|at| at.is_sure || !is_any_sure).collect();
    let deflection = largest(path, (&sure, &found), |at| at.deflection);
    let vibration = largest(path, (&sure, &found), |at| at.vibration);
    Ok(ToolTip {
        modes: if has_tool { Seen::ArmAndTool } else { Seen::Arm },
        deflection,
        vibration,
        along: along(path, &sure, [deflection.s, vibration.s]),
        surface_error: surface_error(path, &sure),
        drilling: drilling(path, &effects, &sure, &found),
        harmonics: harmonics(operation, &effects, &sure),
        beyond: beyond(job, operation, path, stations, &found),
    })
}

/// The largest where the tool surely cuts, and what it may be anywhere.
fn largest(
    path: &Path,
    (sure, all): (&[&AtPlace], &[AtPlace]),
    of: impl Fn(&AtPlace) -> Doubtful,
) -> Largest {
    let up_to_m = all.iter().map(|at| of(at).up_to_m).fold(0.0, f64::max);
    let mut largest = Largest { largest_m: 0.0, s: 0.0, line: 0, up_to_m };
    for at in sure {
        let Doubtful { value_m, .. } = of(at);
        if value_m >= largest.largest_m {
            largest = Largest { largest_m: value_m, s: at.s, ..largest };
        }
    }
    Largest { line: path.line_at(largest.s), ..largest }
}

/// The places nearest to equal parts of the path, and `others`.
fn along(path: &Path, found: &[&AtPlace], others: [f64; 2]) -> Vec<TipAt> {
    let s: Vec<f64> = found.iter().map(|at| at.s).collect();
    let taken = nearest_to_parts(&s, SHOWN_PARTS);
    let is_shown = |at: &&&AtPlace| taken.contains(&at.s) || others.contains(&at.s);
    let at = |at: &&AtPlace| {
        let [deflection_m, vibration_m] =
            [at.deflection, at.vibration].map(|of| [of.value_m, of.up_to_m]);
        TipAt { s: at.s, line: path.line_at(at.s), deflection_m, vibration_m }
    };
    found.iter().filter(is_shown).map(at).collect()
}

fn surface_error(path: &Path, found: &[&AtPlace]) -> Option<SurfaceError> {
    let all = found.iter().filter_map(|at| Some((at.surface_error_m?, at.s)));
    let (error_m, s) = all.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    Some(SurfaceError { error_m, s, line: path.line_at(s) })
}

fn drilling(
    path: &Path,
    effects: &Effects,
    sure: &[&AtPlace],
    all: &[AtPlace],
) -> Option<Drilling> {
    let force = effects.drilling()?;
    let of = |at: &&AtPlace| Some((at.drilling?, at.s));
    let most = |size: fn(&DrillingAt) -> f64| {
        sure.iter().filter_map(of).map(|(at, _)| size(&at)).fold(0.0, f64::max)
    };
    let (skid, skid_s) =
        sure.iter().filter_map(of).max_by(|a, b| a.0.skid_m.total_cmp(&b.0.skid_m))?;
    let up_to = all.iter().filter_map(|at| Some(at.drilling?.thrust_up_to_n)).fold(0.0, f64::max);
    Some(Drilling {
        thrust_n: most(|at| at.thrust_n),
        thrust_up_to_n: up_to,
        is_lower_bound: force.is_lower_bound(),
        leaves_axis: all.iter().filter_map(|at| at.drilling).any(|at| at.leaves_axis),
        torque_nm: skid.torque_nm.map(|_| most(|at| at.torque_nm.unwrap_or(0.0))),
        half_point_rad: force.lips().half_point_rad,
        is_point_angle_assumed: force.rests_on_assumed_point(),
        skid_m: skid.skid_m,
        skid_s,
        skid_line: path.line_at(skid_s),
    })
}

fn harmonics(operation: &Operation, effects: &Effects, found: &[&AtPlace]) -> Vec<Harmonic> {
    let teeth = operation.tool.teeth;
    let of = |(i, &order): (usize, &u32)| {
        let size = |at: &&&AtPlace| at.amplitudes_m.get(i).copied().unwrap_or(0.0);
        let worst = found.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
        let line = if order.is_multiple_of(teeth) {
            ExcitationLine { source: Source::ToothPassing, harmonic: order / teeth, order }
        } else {
            ExcitationLine { source: Source::Spindle, harmonic: order, order }
        };
        let excitation_hz = f64::from(order) * hz_from_rpm(operation.speed.rpm_at(worst.s));
        Some(Harmonic { line, excitation_hz, amplitude_m: size(&worst), s: worst.s })
    };
    let mut all: Vec<Harmonic> = effects.orders().iter().enumerate().filter_map(of).collect();
    let most = all.iter().map(|one| one.amplitude_m).fold(0.0, f64::max);
    all.retain(|one| one.amplitude_m > 0.0 && one.amplitude_m >= TOLD_SHARE * most);
    all
}

/// What the policy allows of each quantity, m.
fn limits(policy: &Policy) -> impl Iterator<Item = (Quantity, f64)> {
    let deflection = policy.max_deflection_m.map(|limit| (Quantity::Deflection, limit));
    let vibration = policy.max_vibration_m.map(|limit| (Quantity::Vibration, limit));
    deflection.into_iter().chain(vibration)
}

fn beyond(
    job: &Job,
    operation: &Operation,
    path: &Path,
    stations: &[f64],
    found: &[AtPlace],
) -> Vec<Excess> {
    let mut all: Vec<Excess> = Vec::new();
    for (quantity, limit_m) in limits(&job.policy) {
        let mut open: Option<Excess> = None;
        let mut at = found.iter().peekable();
        for &s in stations {
            // A station at which the tool does not cut ends a stretch; a plunge has several sides.
            let mut here: Option<(Certainty, f64, f64)> = None;
            while let Some(at) = at.next_if(|at| at.s == s) {
                let Doubtful { value_m, up_to_m } = match quantity {
                    Quantity::Deflection => at.deflection,
                    Quantity::Vibration => at.vibration,
                };
                let certainty = match () {
                    () if value_m > limit_m && at.is_sure => Certainty::Certain,
                    () if up_to_m > limit_m => Certainty::Uncertain,
                    () => continue,
                };
                here = Some(here.map_or((certainty, value_m, up_to_m), |(other, value, up_to)| {
                    (certainty.max(other), value_m.max(value), up_to_m.max(up_to))
                }));
            }
            if open.as_ref().map(|open| open.certainty) != here.map(|here| here.0) {
                all.extend(open.take());
            }
            let Some((certainty, value_m, up_to_m)) = here else { continue };
            let stretch = open.get_or_insert_with(|| Excess {
                quantity,
                certainty,
                limit_m,
                largest_m: value_m,
                up_to_m,
                from_s: s,
                to_s: s,
                largest_s: s,
                file: job.named_file_of_moves(operation).to_owned(),
                from_line: 0,
                to_line: 0,
            });
            stretch.to_s = s;
            stretch.up_to_m = stretch.up_to_m.max(up_to_m);
            if value_m > stretch.largest_m {
                (stretch.largest_m, stretch.largest_s) = (value_m, s);
            }
        }
        all.extend(open);
    }
    for excess in &mut all {
        (excess.from_line, excess.to_line) = path.lines_between(excess.from_s, excess.to_s);
    }
    all.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    all
}

/// What limits of the policy do to the verdict: of each quantity its worst stretch, and how many
/// more there are.
pub(super) fn notes(job: &Job, operation: &Operation, cut: &Cut) -> Vec<Note> {
    if limits(&job.policy).next().is_none() {
        let is_told = |why: &&NoForce| !matches!(why, NoForce::NoCutting | NoForce::OnlyAir);
        let untold = cut.tool_tip.as_ref().err().filter(is_told);
        let remark = |why| {
            let what = format!("nothing is said of the cut: {why}");
            about_operation(job, operation, Code::Remark, what)
        };
        return untold.map(remark).into_iter().collect();
    }
    let keys: Vec<&str> = limits(&job.policy).map(|(quantity, _)| key(quantity)).collect();
    let keys = keys.join(" and ");
    let tip = match &cut.tool_tip {
        Ok(tip) => tip,
        Err(why) => {
            let what = format!("{keys} cannot be checked: {why}");
            return vec![about_operation(job, operation, Code::LimitUnchecked, what)];
        }
    };
    let mut notes = Vec::new();
    for quantity in [Quantity::Deflection, Quantity::Vibration] {
        for certainty in [Certainty::Certain, Certainty::Uncertain] {
            let of =
                |excess: &&Excess| (excess.quantity, excess.certainty) == (quantity, certainty);
            let own: Vec<&Excess> = tip.beyond.iter().filter(of).collect();
            let worst = own.iter().max_by(|a, b| a.up_to_m.total_cmp(&b.up_to_m));
            if let Some(worst) = worst {
                notes.push(told(job, operation, worst, own.len() - 1));
            }
        }
    }
    notes.extend(
        unchecked(job, tip)
            .into_iter()
            .map(|what| about_operation(job, operation, Code::LimitUnchecked, what)),
    );
    notes
}

/// What of the limits cannot be held against a drill, unless they are exceeded anyway.
fn unchecked(job: &Job, tip: &ToolTip) -> Vec<String> {
    let Some(drilling) = &tip.drilling else { return Vec::new() };
    let is_exceeded = |quantity: Quantity| {
        let is_certain = |of: &Excess| of.certainty == Certainty::Certain;
        tip.beyond.iter().any(|of| of.quantity == quantity && is_certain(of))
    };
    let cannot = |of: &[Quantity], why: &str| {
        let open = limits(&job.policy)
            .filter(|(quantity, _)| of.contains(quantity) && !is_exceeded(*quantity));
        let keys: Vec<&str> = open.map(|(quantity, _)| key(quantity)).collect();
        (!keys.is_empty()).then(|| format!("{} cannot be checked: {why}", keys.join(" and ")))
    };
    let all = [Quantity::Deflection, Quantity::Vibration];
    let of_thrust = drilling.is_lower_bound.then(|| {
        cannot(
            &all,
            "the thrust by coefficients is a lower bound, as the chisel edge is not in it; give \
             cutting.thrust_n, or pilot_diameter_mm if there is a hole of a quarter of the \
             diameter or more",
        )
    });
    let of_moves = drilling.leaves_axis.then(|| {
        cannot(
            &all,
            "the drill also moves across its axis at the operation's feed, and what that does to \
             the work is not known; make it a rapid move, or an operation of its own with the \
             cutting of a mill",
        )
    });
    let of_torque = drilling.torque_nm.is_none().then(|| {
        cannot(
            &[Quantity::Deflection],
            "the torque of the drill is not known; give cutting.torque_nm, or material or \
             coefficients",
        )
    });
    let is_steady = tip.harmonics.is_empty();
    let of_vibration = is_steady.then(|| {
        cannot(
            &[Quantity::Vibration],
            "the thrust of a drill with even lips is steady, so what makes it vibrate is not known",
        )
    });
    [of_thrust, of_torque, of_moves, of_vibration].into_iter().flatten().flatten().collect()
}

/// A remark where the thrust of a drill, or the limit at which it chatters, rests on a point angle
/// that nobody gave.
pub(super) fn assumed(job: &Job, operation: &Operation, cut: &Cut) -> Option<Note> {
    let tip = cut.tool_tip.as_ref().ok()?;
    tip.drilling.filter(|drilling| drilling.is_point_angle_assumed)?;
    let drill = operation.cutting.as_ref()?.drill()?;
    let what = assumed_point(&Lips::new(&operation.tool, drill)?);
    Some(about_operation(job, operation, Code::Assumed, what))
}

/// What is assumed of a drill whose point angle nobody gave.
pub fn assumed_point(lips: &Lips) -> String {
    let point_deg = deg_from_rad(2.0 * lips.half_point_rad);
    format!("tool.point_angle_deg is not given: {point_deg:.0}° is assumed")
}

fn key(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Deflection => "policy.max_deflection_um",
        Quantity::Vibration => "policy.max_vibration_um",
    }
}

fn in_lines(from: usize, to: usize) -> String {
    if from == to { format!("line {from}") } else { format!("lines {from}–{to}") }
}

/// A length in µm with one decimal, or with two digits where that would leave none.
fn one_decimal(um: f64) -> String {
    match um.abs() {
        small if small > 0.0 && small < 0.1 => {
            let decimals = 1.0 - small.log10().floor().max(-12.0);
            format!("{um:.*}", decimals as usize)
        }
        _ => format!("{um:.1}"),
    }
}

fn told(job: &Job, operation: &Operation, excess: &Excess, more: usize) -> Note {
    let [um, up_to, limit] =
        [excess.largest_m, excess.up_to_m, excess.limit_m].map(|m| one_decimal(um_from_m(m)));
    let moves = match excess.quantity {
        Quantity::Deflection => "the mean cutting force moves the tool tip",
        Quantity::Vibration => "the tool tip vibrates under the cutting force by",
    };
    let (code, size) = match excess.certainty {
        Certainty::Certain => (Code::LimitExceeded, format!("{um} µm")),
        Certainty::Uncertain => {
            (Code::LimitInDoubt, format!("{um} µm, perhaps {up_to} µm on that stretch,"))
        }
    };
    let lines = in_lines(excess.from_line, excess.to_line);
    let [from, to] = [excess.from_s, excess.to_s].map(percent_from_ratio);
    let more = match more {
        0 => String::new(),
        1 => "; also on one more stretch".to_owned(),
        more => format!("; also on {more} more stretches"),
    };
    let unsure = match excess.certainty {
        Certainty::Uncertain if excess.largest_m > excess.limit_m => {
            match operation.cutting.as_ref().and_then(Cutting::drill) {
                Some(_) => {
                    ", if it drills there: a move across the axis, or at more than twice the \
                     operation's feed"
                }
                None => {
                    ", if it cuts sideways there: a plunge, or a move at more than twice the \
                     operation's feed"
                }
            }
        }
        _ => "",
    };
    let what = format!(
        "{moves} {size} at {:.1} % of the path{unsure}; {} is {limit} µm ({from:.1}–{to:.1} % of \
         the path, {lines}){more}",
        percent_from_ratio(excess.largest_s),
        key(excess.quantity),
    );
    let place = Place { line: Some(excess.from_line), ..Place::default() };
    in_operation(job, operation, Note::warning(code, place, what))
}
