//! Cutters, and what of a cut does not depend on a path.

use nalgebra::Vector3;

use super::super::raw::job as raw;
use crate::formats::yaml::{Node, Step};
use crate::job::{CuttingCoefficients, CuttingDirection, Drill, Runout, TipMode, Tool};
use crate::notes::{Code, Notes};
use crate::units::{
    m_from_mm, mm_from_m, n_per_m_from_n_per_mm, n_per_m2_from_n_per_mm2, rad_from_deg,
    rad_per_s_from_hz,
};

/// A cutter; `what` names it in messages and `at` is where it stands in the tree.
pub(in crate::input) fn tool(
    raw: &raw::Tool,
    what: &str,
    at: &[Step<'_>],
    tree: &Node,
    notes: &mut Notes,
) -> Option<Tool> {
    let of_pitch = [at, &[Step::Key("pitch_deg")]].concat();
    if let (Some(pitch), Some(teeth)) = (&raw.pitch_deg, raw.teeth) {
        if pitch.len() != teeth as usize {
            let what = format!(
                "{what}.pitch_deg has {} angles, must have one for each of the {teeth} teeth",
                pitch.len()
            );
            notes.error(Code::Conflict, tree.line_at(&of_pitch), what);
        }
        let sum: f64 = pitch.iter().sum();
        // Pitches are written with a few digits.
        if (sum - 360.0).abs() > 1e-3 {
            let what = format!("{what}.pitch_deg adds up to {sum}, must be 360");
            notes.error(Code::Value, tree.line_at(&of_pitch), what);
        }
    }
    let of_modes = [at, &[Step::Key("modes")]].concat();
    let modes = raw.modes.as_deref().unwrap_or_default();
    let modes = tip_modes(modes, &format!("{what}.modes"), &of_modes, tree, notes);
    Some(Tool {
        name: raw.name.clone(),
        teeth: raw.teeth?,
        diameter_m: raw.diameter_mm.map(m_from_mm),
        pitch_rad: raw
            .pitch_deg
            .as_ref()
            .map(|pitch| pitch.iter().map(|&angle| rad_from_deg(angle)).collect()),
        helix_rad: rad_from_deg(raw.helix_deg.unwrap_or(0.0)),
        point_angle_rad: raw.point_angle_deg.map(rad_from_deg),
        runout: runout(raw, what, at, tree, notes),
        modes,
    })
}

/// Most teeth of a cutter with runout: each may cut what any other has left.
const MAX_WITH_RUNOUT: u32 = 60;

fn runout(
    raw: &raw::Tool,
    what: &str,
    at: &[Step<'_>],
    tree: &Node,
    notes: &mut Notes,
) -> Option<Runout> {
    let own = raw.runout.as_ref()?;
    let of_runout = [at, &[Step::Key("runout")]].concat();
    let offset_m = m_from_mm(own.offset_mm?);
    let mut refuse = |message: String| {
        notes.error(Code::Conflict, tree.line_at(&of_runout), message);
    };
    if let Some(teeth) = raw.teeth.filter(|teeth| *teeth > MAX_WITH_RUNOUT) {
        refuse(format!(
            "{what}.runout: the cutter has {teeth} teeth, runout is known for at most \
             {MAX_WITH_RUNOUT}"
        ));
    }
    if let Some(diameter_mm) = raw.diameter_mm.filter(|d| 2.0 * offset_m >= m_from_mm(*d)) {
        refuse(format!(
            "{what}.runout.offset_mm is {}, must be below half of diameter_mm, {diameter_mm}",
            own.offset_mm.unwrap_or_default()
        ));
    }
    let angle_rad = rad_from_deg(own.angle_deg.unwrap_or(0.0));
    (offset_m > 0.0).then_some(Runout { offset_m, angle_rad })
}

/// Modes of a tool tip, those without fault.
pub(in crate::input) fn tip_modes(
    raws: &[raw::TipMode],
    what: &str,
    at: &[Step<'_>],
    tree: &Node,
    notes: &mut Notes,
) -> Vec<TipMode> {
    let mut modes = Vec::new();
    for (index, raw) in raws.iter().enumerate() {
        let here = [at, &[Step::Index(index)]].concat();
        let (Some(frequency_hz), Some(damping_ratio), Some(axis)) =
            (raw.frequency_hz, raw.damping_ratio, raw.axis)
        else {
            continue;
        };
        let omega = rad_per_s_from_hz(frequency_hz);
        let mass_kg = match (raw.mass_kg, raw.stiffness_n_per_m) {
            (Some(mass_kg), None) => mass_kg,
            (None, Some(stiffness)) => stiffness / (omega * omega),
            (mass, _) => {
                let has = if mass.is_some() { "both" } else { "neither" };
                let what = format!(
                    "{what}[{index}] has {has} of mass_kg and stiffness_n_per_m, must have one"
                );
                notes.error(Code::Conflict, tree.line_at(&here), what);
                continue;
            }
        };
        let length = Vector3::from(axis).norm();
        if !(length.is_finite() && length > 1e-6) {
            let [x, y, z] = axis;
            let what = format!("{what}[{index}].axis is [{x}, {y}, {z}], must be a direction");
            let of_axis = [here.as_slice(), &[Step::Key("axis")]].concat();
            notes.error(Code::Value, tree.line_at(&of_axis), what);
            continue;
        }
        let axis = Vector3::from(axis) / length;
        modes.push(TipMode { frequency_hz, damping_ratio, mass_kg, axis });
    }
    modes
}

/// The cut by its name; `drill` is what a drill needs beside it.
pub(in crate::input) fn direction(raw: raw::Direction, drill: Drill) -> CuttingDirection {
    match raw {
        raw::Direction::Climb => CuttingDirection::Climb,
        raw::Direction::Conventional => CuttingDirection::Conventional,
        raw::Direction::Slot => CuttingDirection::Slot,
        raw::Direction::Drill => CuttingDirection::Drill(drill),
    }
}

/// Whether a cut has a width, which all have but a slot and a drill.
pub(in crate::input) fn needs_width(raw: raw::Direction) -> bool {
    match raw {
        raw::Direction::Climb | raw::Direction::Conventional => true,
        raw::Direction::Slot | raw::Direction::Drill => false,
    }
}

/// What keeps a cutter from drilling: the key that is at fault, none for the direction, and why;
/// `whose` is the cutter's name in messages.
pub(in crate::input) fn drill_fault(
    raw: raw::Direction,
    pilot_diameter_mm: Option<f64>,
    whose: &str,
    tool: &Tool,
) -> Option<(&'static str, Code, String)> {
    if !matches!(raw, raw::Direction::Drill) {
        return None;
    }
    let Some(diameter_m) = tool.diameter_m else {
        let what = format!("cutting.direction is drill, which needs {whose}.diameter_mm");
        return Some(("direction", Code::MissingKey, what));
    };
    let pilot_mm = pilot_diameter_mm.filter(|pilot_mm| m_from_mm(*pilot_mm) >= diameter_m)?;
    let what = format!(
        "cutting.pilot_diameter_mm is {pilot_mm}, must be below {whose}.diameter_mm, {}",
        mm_from_m(diameter_m)
    );
    Some(("pilot_diameter_mm", Code::Value, what))
}

/// C of the cut, N/m; a drill has none.
pub(in crate::input) fn process_damping_n_per_m(n_per_mm: Option<f64>, raw: raw::Direction) -> f64 {
    let drills = matches!(raw, raw::Direction::Drill);
    n_per_mm.filter(|_| !drills).map_or(0.0, n_per_m_from_n_per_mm)
}

/// What is said of a key that another direction of the cut takes.
pub(in crate::input) fn unused_key(key: &str, drills: bool) -> String {
    let whose = if drills { "a drill has none" } else { "it is for direction: drill" };
    format!("cutting.{key} has no effect: {whose}")
}

/// What is said of process damping without the diameter of the cutter `whose`, which it needs;
/// `None` where it has it.
pub(in crate::input) fn undamped_without_diameter(
    n_per_mm: Option<f64>,
    whose: &str,
    tool: &Tool,
) -> Option<String> {
    n_per_mm.filter(|c| *c > 0.0 && tool.diameter_m.is_none())?;
    Some(format!(
        "cutting.process_damping_n_per_mm needs {whose}.diameter_mm, for the cutting speed"
    ))
}

/// Why process damping has no effect on a cut, if it has none.
pub(in crate::input) fn undamped(
    n_per_mm: Option<f64>,
    raw: raw::Direction,
    regenerates: bool,
) -> Option<&'static str> {
    n_per_mm?;
    match (raw, regenerates) {
        (raw::Direction::Drill, _) => {
            Some("process_damping_n_per_mm has no effect: it is for milling")
        }
        (_, false) => {
            Some("process_damping_n_per_mm has no effect: it is for a cut that regenerates")
        }
        (_, true) => None,
    }
}

/// `None` where a key is missing, which was reported before.
pub(in crate::input) fn coefficients(own: &raw::Coefficients) -> Option<CuttingCoefficients> {
    let edge = |value: Option<f64>| n_per_m_from_n_per_mm(value.unwrap_or(0.0));
    Some(CuttingCoefficients {
        tangential_n_per_m2: n_per_m2_from_n_per_mm2(own.ktc_n_per_mm2?),
        radial_n_per_m2: n_per_m2_from_n_per_mm2(own.krc_n_per_mm2?),
        tangential_edge_n_per_m: edge(own.kte_n_per_mm),
        radial_edge_n_per_m: edge(own.kre_n_per_mm),
        axial: own.kac_n_per_mm2.map(|k| [n_per_m2_from_n_per_mm2(k), edge(own.kae_n_per_mm)]),
        exponents: [own.tangential_exponent, own.radial_exponent, own.axial_exponent]
            .map(Option::unwrap_or_default),
    })
}
