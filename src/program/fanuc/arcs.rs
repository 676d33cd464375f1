//! The circular motion A of TP: arcs through points in a row.

use nalgebra::Isometry3;

use super::motion::Place;
use super::run::Run;
use super::text::{Statement, is_remark};
use crate::motion::{Circle, Target, Turning};
use crate::program::Pace;

impl Run<'_> {
    /// A: arcs through points in a row, each on the circle of its neighbours; the first is gone to
    /// straight.
    pub(super) fn arc_point(
        &mut self,
        statement: &Statement,
        to: Isometry3<f64>,
        tcp: Isometry3<f64>,
        pace: Pace,
    ) -> Result<(), String> {
        let index = self.source.statements.iter().position(|other| std::ptr::eq(other, statement));
        let index = index.ok_or("a statement of no program")?;
        let line = self.line_of(statement);
        let pose_of = |run: &mut Self, at: Option<usize>| -> Option<Isometry3<f64>> {
            let text = run.source.statements.get(at?)?.text.trim();
            let rest = text.strip_prefix('A')?.trim_start();
            let (aim, _) = run.aim(line, rest).ok()?;
            let (place, tcp) = run.resolve(line, &aim.group).ok()?;
            match run.led_to(&place, &tcp).ok()? {
                Place::Pose(pose) => Some(pose),
                Place::Joints(_) => None,
            }
        };
        // Remarks between them part no points.
        let all = &self.source.statements;
        let is_told = |own: &Statement| !is_remark(own.text.trim());
        let next_back = |at: usize| all.get(..at)?.iter().rposition(is_told);
        let at_before = next_back(index);
        let at_two_before = at_before.and_then(next_back);
        let at_behind = (index + 1..all.len()).find(|at| all.get(*at).is_some_and(is_told));
        let before = pose_of(self, at_before);
        let two_before = pose_of(self, at_two_before).filter(|_| before.is_some());
        let behind = pose_of(self, at_behind);
        let point = |pose: &Isometry3<f64>| pose.translation.vector;
        let Some(from) = before else {
            self.log.motion(line, Target::Line(to), tcp, pace);
            return Ok(());
        };
        let (circle, share) = match (two_before, behind) {
            (Some(first), _) => {
                let circle = Circle::through(point(&first), point(&from), point(&to));
                let circle = circle.ok_or("the arc's points lie on one line")?;
                let share = (circle.via_at() + 1.0) / 2.0;
                (circle, share)
            }
            (None, Some(next)) => {
                let circle = Circle::through(point(&from), point(&to), point(&next));
                let circle = circle.ok_or("the arc's points lie on one line")?;
                let share = circle.via_at() / 2.0;
                (circle, share)
            }
            (None, None) => return Err("A needs three points in a row".to_owned()),
        };
        let turned = from.rotation.try_slerp(&to.rotation, 0.5, 1e-12).unwrap_or(to.rotation);
        let via = Isometry3::from_parts(circle.at(share).into(), turned);
        self.log.motion(line, Target::Arc { via, end: to, turning: Turning::ByWay }, tcp, pace);
        Ok(())
    }
}
