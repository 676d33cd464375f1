//! The controller's own tool and work object, where a program declares them.

use nalgebra::Isometry3;

use super::carried::{Holds, ToolFrame};
use super::load::PLACEHOLDER_KG;
use super::syntax::Declaration;
use super::value::{Value, pose};

/// What a declaration gives: one of the name of the controller's own tool or work object that says
/// the same as that, as system modules do, is that.
pub(super) fn as_own_frame(declaration: &Declaration, value: Value) -> Value {
    let shown = &declaration.name.shown;
    let own = match declaration.kind.as_str() {
        "tooldata" if shown.eq_ignore_ascii_case("tool0") => Value::Tool0,
        "wobjdata" if shown.eq_ignore_ascii_case("wobj0") => Value::Wobj0,
        _ => return value,
    };
    let is_shared = declaration.is_persistent && declaration.value.is_none();
    let is_same = match own {
        Value::Tool0 => is_plain_tool(&value),
        _ => is_plain_object(&value),
    };
    if is_shared || is_same == Ok(true) { own } else { value }
}

/// Whether a tool ends at the flange and states no load.
fn is_plain_tool(tool: &Value) -> Result<bool, String> {
    let (frame, holds) = frame_of_tool(tool)?;
    let mass_kg = tool.part(2, "a tool")?.part(0, "a load")?.num()?;
    let is_plain = frame == Isometry3::identity() && holds == Holds::Tool;
    Ok(is_plain && mass_kg <= PLACEHOLDER_KG)
}

/// Whether a work object stands in the base.
fn is_plain_object(object: &Value) -> Result<bool, String> {
    let is_held = object.part(0, "a work object")?.bool()?;
    let is_fixed = object.part(1, "a work object")?.bool()?;
    let frame = pose(object.part(3, "a user frame")?)? * pose(object.part(4, "an object frame")?)?;
    Ok(!is_held && is_fixed && frame == Isometry3::identity())
}

/// The frame of a tool that the program declares.
pub(super) fn frame_of_tool(tool: &Value) -> Result<ToolFrame, String> {
    let is_held = tool.part(0, "a tool")?.bool()?;
    let frame = pose(tool.part(1, "a tool frame")?)?;
    Ok((frame, if is_held { Holds::Tool } else { Holds::Work }))
}
