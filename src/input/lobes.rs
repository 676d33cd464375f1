//! Files of modes of a tool tip.

use std::path::Path;

use super::Reading;
use super::files::MAX_ROBOT_BYTES;
use super::job::cutter::{
    coefficients, direction, drill_fault, needs_width, process_damping_n_per_m, tip_modes, tool,
    undamped, undamped_without_diameter, unused_key,
};
use super::kind::{FileKind, document_of};
use super::raw::{job, lobes as raw};
use super::schema;
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, Step};
use crate::job::{Cutting, Drill, TipCut};
use crate::notes::{Code, Note, Notes, Place};
use crate::units::{m_from_mm, mm_from_m};

/// Reads a file of modes.
///
/// # Errors
/// Every fault, each with its line.
pub fn read_tip_cut(path: &Path, reading: &mut Reading) -> Result<TipCut, Vec<Note>> {
    reading.files.push(path.to_owned());
    let mut notes = Notes::about(Place::file(path));
    let text = read_text(path, MAX_ROBOT_BYTES)?;
    let schema = schema::of::<raw::Lobes>();
    let Some((tree, raw)) = document_of::<raw::Lobes>(FileKind::Modes, &text, &schema, &mut notes)
    else {
        return Err(reading.settle(notes));
    };
    let found = tip_cut(&raw, &tree, &mut notes);
    let errors = reading.settle(notes);
    match found {
        Some(found) if errors.is_empty() => Ok(found),
        _ => Err(errors),
    }
}

fn tip_cut(raw: &raw::Lobes, tree: &Node, notes: &mut Notes) -> Option<TipCut> {
    let modes = tip_modes(
        raw.modes.as_deref().unwrap_or_default(),
        "modes",
        &[Step::Key("modes")],
        tree,
        notes,
    );
    let raw_tool = raw.tool.as_ref();
    let tool = raw_tool.and_then(|raw| tool(raw, "tool", &[Step::Key("tool")], tree, notes));
    for (key, is_there) in [
        ("payload", raw_tool.is_some_and(|tool| tool.payload.is_some())),
        ("modes", raw_tool.is_some_and(|tool| tool.modes.is_some())),
    ] {
        if is_there {
            let line = tree.line_at(&[Step::Key("tool"), Step::Key(key)]);
            let instead = if key == "modes" { "; write them under modes" } else { "" };
            notes.error(Code::Conflict, line, format!("tool.{key} has no meaning here{instead}"));
        }
    }
    let raw = raw.cutting.as_ref()?;
    let key = |key| tree.line_at(&[Step::Key("cutting"), Step::Key(key)]);
    let named = raw.direction?;
    if needs_width(named) && raw.radial_depth_mm.is_none() {
        let what = "cutting has no 'radial_depth_mm', which all but a slot and a drill needs";
        notes.error(Code::MissingKey, key("direction"), what);
        return None;
    }
    if raw.coefficients.is_none() && raw.material.is_none() {
        let what = "cutting has neither 'coefficients' nor 'material', must have one";
        notes.error(Code::MissingKey, tree.line_at(&[Step::Key("cutting")]), what);
        return None;
    }
    let tool = tool?;
    if let Some((at, code, what)) = drill_fault(named, raw.pilot_diameter_mm, "tool", &tool) {
        notes.error(code, key(at), what);
        return None;
    }
    let regenerates = raw.regeneration.unwrap_or(true);
    if let Some(what) = undamped(raw.process_damping_n_per_mm, named, regenerates) {
        let what = format!("cutting.{what}");
        notes.warning(Code::Unused, key("process_damping_n_per_mm"), what);
    }
    let damping = raw.process_damping_n_per_mm;
    if let Some(what) = undamped_without_diameter(damping, "tool", &tool) {
        notes.error(Code::MissingKey, key("process_damping_n_per_mm"), what);
    }
    let drills = matches!(named, job::Direction::Drill);
    for (at, is_unused) in [
        ("radial_depth_mm", drills && raw.radial_depth_mm.is_some()),
        ("pilot_diameter_mm", !drills && raw.pilot_diameter_mm.is_some()),
    ] {
        if is_unused {
            notes.warning(Code::Unused, key(at), unused_key(at, drills));
        }
    }
    if let (Some(depth_mm), Some(diameter_m)) = (raw.radial_depth_mm, tool.diameter_m)
        && !drills
        && m_from_mm(depth_mm) > diameter_m
    {
        let diameter_mm = mm_from_m(diameter_m);
        let what = format!(
            "cutting.radial_depth_mm is {depth_mm}, must not be above tool.diameter_mm, \
             {diameter_mm}"
        );
        notes.error(Code::Value, key("radial_depth_mm"), what);
    }
    if let Some(own) = raw.coefficients.as_ref().and_then(coefficients)
        && !own.is_linear()
    {
        let what = "cutting.coefficients have exponents, which need a feed per tooth: give the \
                    coefficients at your chip, or ask for the lobes of a job";
        notes.error(Code::Conflict, key("coefficients"), what);
        return None;
    }
    let pilot_diameter_m = raw.pilot_diameter_mm.map_or(0.0, m_from_mm);
    let radial_depth_mm = raw.radial_depth_mm.filter(|_| !drills);
    let damping = process_damping_n_per_m(raw.process_damping_n_per_mm, named);
    let cutting = Cutting {
        radial_depth_m: radial_depth_mm.map_or(0.0, m_from_mm),
        axial_depth_m: 0.0,
        direction: direction(named, Drill { pilot_diameter_m, ..Drill::default() }),
        material: raw.material.clone().unwrap_or_default(),
        coefficients: match &raw.coefficients {
            Some(own) => Some(coefficients(own)?),
            None => None,
        },
        regenerates: raw.regeneration.unwrap_or(true),
        process_damping_n_per_m: damping,
    };
    Some(TipCut { modes, tool, cutting })
}
