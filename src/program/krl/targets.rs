//! What the components of a target say: a pose, axes of the arm, external axes.

use nalgebra::Isometry3;

use super::run::Run;
use super::syntax::Motion;
use super::value::{AXES, EXTERNAL, FRAME, Parts, numbers, part, pose};
use crate::motion::Configuration;

/// More than any axis turns, rad.
const TURNS: f64 = 20.0;

/// Why the position before is not known behind a motion that is skipped.
const AWAY: &str = "the motion before goes to a position that is in no file";

/// Whether two poses differ by rounding alone.
fn is_same(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    const ROUNDING: f64 = 1e-9;
    let way = (a.translation.vector - b.translation.vector).norm();
    way < ROUNDING && a.rotation.angle_to(&b.rotation) < ROUNDING
}

impl Run<'_> {
    /// A position in the base frame of the robot; components left out stay as they are.
    pub(super) fn target(
        &mut self,
        parts: &Parts,
        motion: &Motion,
    ) -> Result<Isometry3<f64>, String> {
        if motion.is_of_tool {
            return self.target_from_tool(parts);
        }
        if let Some(why) = &self.no_base {
            return Err(why.clone());
        }
        self.tell_of_world();
        let is_relative = motion.is_relative;
        let is_whole = FRAME.iter().all(|name| parts.contains_key(*name));
        let is_away = self.log.is_away();
        let before = match self.log.last() {
            _ if is_away && (is_relative || !is_whole) => {
                return Err(format!("components are left out, and {AWAY}"));
            }
            Some(last) => {
                let now = self.base.inverse() * last.with(&self.tcp);
                let is_now = |stated: &[f64; 6]| is_same(&pose(*stated), &now);
                // Those that the program has stated: at B 90 others say the same.
                let stated = self.stated.into_iter().flatten().find(is_now);
                Some(stated.unwrap_or_else(|| numbers(&now)))
            }
            None if is_whole && !is_relative => None,
            None => {
                let before = match self.log.has_moved() {
                    true => {
                        "the point before is given by axes, of which the program does not \
                             state the position; give X, Y, Z, A, B and C in full"
                    }
                    false => "the position before is known only at run time",
                };
                return Err(format!("components are left out, and {before}"));
            }
        };
        let mut found = [0.0; 6];
        for (index, name) in FRAME.into_iter().enumerate() {
            let old = before.map_or(0.0, |before| before[index]);
            let given = part(parts, name).map_err(|why| format!("target: {why}"))?;
            found[index] = match given {
                Some(value) if is_relative => old + value,
                Some(value) => value,
                None => old,
            };
        }
        self.stated = [Some(found), self.stated[0]];
        Ok(self.base * pose(found))
    }

    /// A position in the tool where it is; components left out are 0.
    fn target_from_tool(&mut self, parts: &Parts) -> Result<Isometry3<f64>, String> {
        if self.log.is_away() {
            return Err(format!("#TOOL: {AWAY}"));
        }
        let last = self.log.last().ok_or("#TOOL: the position before is not known as a pose")?;
        let mut by = [0.0; 6];
        for (own, name) in by.iter_mut().zip(FRAME) {
            let given = part(parts, name).map_err(|why| format!("target: {why}"))?;
            *own = given.unwrap_or_default();
        }
        // About one axis there is no order of turns.
        if by[3..].iter().filter(|angle| **angle != 0.0).count() > 1 {
            return Err("#TOOL with two of A, B and C is not supported".to_owned());
        }
        Ok(last.with(&self.tcp) * pose(by))
    }

    /// The signs of the axes that T has, where S stands with it: a bit is set where the axis is
    /// negative. S, of which only the robot's own dimensions tell what it means, is not read.
    pub(super) fn configuration(&self, parts: &Parts) -> Option<Configuration> {
        let number = |name| part(parts, name).ok().flatten();
        let (status, turn) = (number("s")?, number("t")?);
        let arm = self.external.arm()?;
        let bits = (0.0..64.0).contains(&turn).then_some(turn as u32)?;
        let range = |is_negative| if is_negative { [-TURNS, 0.0] } else { [0.0, TURNS] };
        let joints = arm.iter().enumerate();
        let joints = joints.map(|(axis, joint)| (*joint, range(bits >> axis & 1 == 1))).collect();
        Some(Configuration { shown: format!("S {status}, T {turn}"), joints, sides: None })
    }

    pub(super) fn joint_target(
        &mut self,
        parts: &Parts,
        is_relative: bool,
    ) -> Result<[f64; 6], String> {
        let mut found = [0.0; 6];
        for (index, name) in AXES.into_iter().enumerate() {
            let old = self.joints.map(|joints| joints[index]);
            let given = part(parts, name).map_err(|why| format!("target: {why}"))?;
            found[index] = match (given, old) {
                (Some(value), Some(old)) if is_relative => old + value,
                (Some(value), _) if !is_relative => value,
                (None, Some(old)) => old,
                _ => {
                    return Err(format!(
                        "{} is not known: the joints before are known only at run time",
                        name.to_uppercase()
                    ));
                }
            };
        }
        self.joints = Some(found);
        Ok(found)
    }

    pub(super) fn external_axes(&mut self, parts: &Parts, is_relative: bool) -> Result<(), String> {
        for name in EXTERNAL {
            if let Some(value) = part(parts, name)? {
                if is_relative && value == 0.0 {
                    continue;
                }
                if is_relative {
                    let shown = name.to_uppercase();
                    return Err(format!("{shown} of a relative motion is not supported"));
                }
                self.external.place(self.log, name, value)?;
            }
        }
        Ok(())
    }
}
