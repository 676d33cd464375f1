//! What shifts the targets of TP motions: `Offset`, `Tool_Offset`, their conditions, `INC`.

use nalgebra::{Isometry3, Vector3};

use super::pace::NO_TURN_RAD;
use super::position::{OffsetCondition, POSE, axes, element_of, pose, six};
use super::run::Run;
use super::text::Group;
use crate::notes::Code;
use crate::units::{m_from_mm, rad_from_deg};

/// Angles below this are rounding, degrees.
const NO_ANGLE_DEG: f64 = 1e-6;

/// What `Offset,PR[n]` and `Tool_Offset,PR[n]` shift a target by: along the axes of the frame, and
/// of the tool, m; the frame and the tool whose axes these are, if not those of the target; and
/// whether the target is itself a shift, `INC`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Shift {
    pub(super) frame: Vector3<f64>,
    pub(super) tool: Vector3<f64>,
    pub(super) of: [Option<u32>; 2],
    pub(super) is_from_before: bool,
}

/// The frames whose axes `Offset` and `Tool_Offset` shift along.
fn list_of(option: &str) -> &'static str {
    if option.starts_with(['T', 't']) { "UTOOL" } else { "UFRAME" }
}

impl Shift {
    pub(super) fn is_none(&self) -> bool {
        *self == Self { of: self.of, ..Self::default() }
    }
}

impl Run<'_> {
    /// With `INC` a position says how far to go from the one before, along the axes of its frame.
    pub(super) fn counted_from_before(
        &self,
        place: &Isometry3<f64>,
        base: &Isometry3<f64>,
        tcp: &Isometry3<f64>,
        group: &Group,
    ) -> Result<Isometry3<f64>, String> {
        let by = base.inverse() * *place;
        if by.rotation.angle() > NO_TURN_RAD {
            return Err("INC that turns the tool is not read".to_owned());
        }
        if axes(group).next().is_some() {
            return Err("INC with external axes is not read".to_owned());
        }
        let last = self.log.last().ok_or("INC, and where the tool is before is not known")?;
        Ok(base * by.translation * base.inverse() * last.with(tcp))
    }

    /// `OFFSET CONDITION PR[1]`, `TOOL_OFFSET CONDITION PR[1],UTOOL[2]`: what a bare `Offset` or
    /// `Tool_Offset` shifts by from here on, and along whose axes.
    pub(super) fn set_offset(&mut self, text: &str) -> Result<(), String> {
        let (own, by) = text.split_once(' ').unwrap_or((text, ""));
        let list = list_of(own);
        self.offsets.remove(list);
        let by = by.trim_start().strip_prefix("CONDITION").map_or("", str::trim_start);
        let unread = || {
            format!(
                "'{text}' is not read: expected {own} CONDITION PR[n] or {own} CONDITION \
                 PR[n],{list}[m]"
            )
        };
        let (register, behind) = self.registers.numbered(by, "PR")?.ok_or_else(unread)?;
        let behind = behind.trim_start().trim_start_matches(',').trim();
        let axes_of = match self.registers.numbered(behind, list)? {
            None if behind.is_empty() => None,
            Some((of, "")) => Some(u32::try_from(of).map_err(|_| unread())?),
            _ => return Err(unread()),
        };
        let held = self.registers.position(register);
        self.offsets.insert(list, OffsetCondition { register, held, axes_of });
        Ok(())
    }

    /// The register of the condition that holds, and the frame or tool that it names. Whether the
    /// controller takes what it held there or what it holds now is told apart by a change alone.
    fn offset_of_condition(&self, shown: &str) -> Result<(i64, Option<u32>), String> {
        let own = shown.to_uppercase();
        let condition = self.offsets.get(list_of(shown));
        let OffsetCondition { register, held, axes_of } = condition
            .ok_or_else(|| format!("{shown} stands behind no {own} CONDITION that is read"))?;
        if self.registers.position(*register) != *held {
            return Err(format!(
                "PR[{register}] has changed since {own} CONDITION: which value {shown} takes is \
                 not read"
            ));
        }
        Ok((*register, *axes_of))
    }

    /// What `Offset,PR[1]` shifts by, m, along whose axes, and what follows.
    pub(super) fn shift<'t>(
        &mut self,
        line: usize,
        text: &'t str,
    ) -> Result<(Vector3<f64>, Option<u32>, &'t str), String> {
        let shown = text.split([' ', '\t', ',']).next().unwrap_or("");
        let behind = text.get(shown.len()..).unwrap_or("");
        let ((number, of), behind) = match behind.trim_start().strip_prefix(',') {
            Some(by) => {
                let found = self.registers.numbered(by.trim_start(), "PR")?.ok_or_else(|| {
                    format!("{shown} shifts the target by what is not PR[n], and is not read")
                })?;
                ((found.0, None), found.1)
            }
            None => (self.offset_of_condition(shown)?, behind),
        };
        let name = format!("PR[{number}]");
        let held = self.registers.position(number);
        let group = held.group(&name).map_err(|why| {
            // What the job assumes holds only before the program sets it.
            if held.is_set_to_unknown() || held.is_set() || self.registers.is_assumed_zero(number) {
                return format!("{shown} shifts the target: {why}");
            }
            format!(
                "{shown} shifts the target by what is known only at run time; assume: \
                 {{\"{name}\": 0}} in the job says that it is 0 until the program sets it, and \
                 {{\"{}\": …}} gives an element",
                element_of(&name, 3)
            )
        })?;
        // Joints do not shift a pose.
        self.tell_kind(line, &name, &held, Code::Assumed);
        let by = six(&group, POSE)?.ok_or("an offset by joints is not read")?;
        // Full turns, as sums of angles may have, turn nothing.
        if pose(by).rotation.angle() > rad_from_deg(NO_ANGLE_DEG) {
            return Err(format!("{shown} turns the target, which is not read"));
        }
        if let Some((axis, _)) = axes(&group).find(|(_, value)| *value != 0.0) {
            return Err(format!("{shown} shifts external axis {axis}, which is not read"));
        }
        Ok((Vector3::new(by[0], by[1], by[2]).map(m_from_mm), of, behind))
    }
}

/// Why a shift is not read that is not of a J or an L to a pose.
pub(super) fn unshifted(kind: &str, shift: &Shift) -> String {
    let own = if shift.tool == Vector3::zeros() { "Offset" } else { "Tool_Offset" };
    match kind {
        _ if shift.is_from_before => "INC of an arc or of joints is not read".to_owned(),
        "A" => "an offset of an arc point (A) is not read".to_owned(),
        "C" => format!("whether {own} of C shifts both of its points is not known: it is not read"),
        _ => "an offset of a position in joints is not read".to_owned(),
    }
}
