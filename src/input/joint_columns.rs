//! Columns of a table that hold the positions of a robot's joints.

use crate::model::{JointKind, MovingJoint, Robot};
use crate::notes::Code;
use crate::units::{m_from_mm, rad_from_deg};
use crate::wording::nearest;

/// How a value becomes rad or m.
pub(super) type ToSi = fn(f64) -> f64;

/// Where the value of one joint stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    pub(super) index: usize,
    pub(super) to_si: ToSi,
}

/// Units of a joint's columns, as their titles end.
fn units(joint: &MovingJoint) -> &'static [(&'static str, ToSi)] {
    match joint.kind {
        // Tables made for any robot call every SI column `_rad`.
        JointKind::Prismatic => {
            &[("m", std::convert::identity), ("mm", m_from_mm), ("rad", std::convert::identity)]
        }
        _ => &[("rad", std::convert::identity), ("deg", rad_from_deg)],
    }
}

/// The columns of one joint.
pub(super) fn columns_of(header: &[String], joint: &MovingJoint) -> Vec<Column> {
    let of_unit = |&(unit, to_si): &(&'static str, ToSi)| {
        let is_meant = move |title: &String| {
            title.strip_prefix(&joint.name).and_then(|rest| rest.strip_prefix('_')) == Some(unit)
        };
        let indices = (0..header.len()).filter(move |&index| is_meant(&header[index]));
        indices.map(move |index| Column { index, to_si })
    };
    units(joint).iter().flat_map(of_unit).collect()
}

/// What is wrong with a column that is called as a joint alone.
pub(super) fn without_unit(header: &[String], joint: &MovingJoint) -> Option<String> {
    let name = header.iter().find(|title| **title == joint.name)?;
    let [(si, _), (other, _), ..] = units(joint) else { return None };
    Some(format!(
        "column '{name}' has no unit; name it {name}_{si} or {name}_{other}, by what its values \
         are in"
    ))
}

/// Whether a title is that of a joint's position.
pub(super) fn is_of_joint(title: &str, robot: &Robot) -> bool {
    robot.joints().iter().any(|joint| {
        let unit = title.strip_prefix(joint.name.as_str());
        matches!(unit, Some("_rad" | "_deg" | "_m" | "_mm"))
    })
}

/// For each moving joint, base to tip, one column `<joint name>_rad` or `_deg` (a prismatic joint:
/// `_m` or `_mm`; `_rad` is read as m), in any order; or what is wrong with them.
pub(super) fn joint_columns(
    header: &[String],
    robot: &Robot,
) -> Result<Vec<Column>, Vec<(Code, String)>> {
    let (mut columns, mut faults) = (Vec::new(), Vec::new());
    for joint in robot.joints() {
        match columns_of(header, joint).as_slice() {
            [column] => columns.push(*column),
            [] => {
                let [(si, _), (other, _), ..] = units(joint) else { continue };
                let wanted = format!("{}_{si}", joint.name);
                // The column of another joint is not meant.
                let free = header.iter().map(String::as_str);
                let free = free.filter(|title| !is_of_joint(title, robot));
                let hint = nearest(&wanted, free)
                    .map_or_else(String::new, |near| format!("; did you mean '{near}' for it?"));
                let what = without_unit(header, joint).unwrap_or_else(|| {
                    format!("no column '{wanted}' or '{}_{other}'{hint}", joint.name)
                });
                faults.push((Code::MissingKey, what));
            }
            several => {
                let (name, count) = (&joint.name, several.len());
                let what = format!("joint '{name}' has {count} columns, must have one");
                faults.push((Code::Conflict, what));
            }
        }
    }
    if faults.is_empty() { Ok(columns) } else { Err(faults) }
}
