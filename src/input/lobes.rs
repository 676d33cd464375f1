//! Files of modes of a tool tip.

use std::path::Path;

use super::Reading;
use super::files::MAX_ROBOT_BYTES;
use super::job::cutter::{coefficients, direction, tip_modes, tool};
use super::kind::{FileKind, document_of};
use super::raw::lobes as raw;
use super::schema;
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, Step};
use crate::job::{Cutting, CuttingDirection, TipCut};
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
    let direction = direction(raw.direction?);
    if direction != CuttingDirection::Slot && raw.radial_depth_mm.is_none() {
        let what = "cutting has no 'radial_depth_mm', which all but a slot needs";
        notes.error(Code::MissingKey, key("direction"), what);
        return None;
    }
    if raw.coefficients.is_none() && raw.material.is_none() {
        let what = "cutting has neither 'coefficients' nor 'material', must have one";
        notes.error(Code::MissingKey, tree.line_at(&[Step::Key("cutting")]), what);
        return None;
    }
    let tool = tool?;
    if let (Some(depth_mm), Some(diameter_m)) = (raw.radial_depth_mm, tool.diameter_m)
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
    let cutting = Cutting {
        radial_depth_m: raw.radial_depth_mm.map_or(0.0, m_from_mm),
        axial_depth_m: 0.0,
        direction,
        material: raw.material.clone().unwrap_or_default(),
        coefficients: match &raw.coefficients {
            Some(own) => Some(coefficients(own)?),
            None => None,
        },
        regenerates: raw.regeneration.unwrap_or(true),
    };
    Some(TipCut { modes, tool, cutting })
}
