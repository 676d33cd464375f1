//! Whether the spindle has reached the speed that a program changes to before the next cut.

use std::sync::Arc;

use super::about::in_operation;
use crate::job::{Job, Operation, SpindleSpeed};
use crate::motion::{Move, Spindle};
use crate::notes::{Code, Note, Place};
use crate::path::Path;
use crate::process::{InWork, in_work};
use crate::wording::{distinguishable, plain, rounded};

/// A change of speed that lacks less than this share of its time is done.
const DONE: f64 = 1e-6;

/// The spindle along the operations that one path is divided into.
#[derive(Debug, Default)]
pub(super) struct SpindleRun<'a> {
    /// The moves of the path, and the first that was not run yet.
    next: Option<(&'a Arc<Vec<Move>>, usize)>,
    /// Number of the tool in the spindle.
    tool: Option<u32>,
    /// The last change of speed; `None` where the spindle stands.
    change: Option<Change>,
}

/// A change of speed, rev/min, negative where the spindle turns the other way round.
#[derive(Debug, Clone, Copy)]
struct Change {
    from_rpm: f64,
    to_rpm: f64,
    /// Time since the command, s.
    passed_s: f64,
}

impl Change {
    fn done(rpm: f64) -> Self {
        Self { from_rpm: rpm, to_rpm: rpm, passed_s: 0.0 }
    }

    fn takes_s(&self, rpm_per_s: f64) -> f64 {
        (self.to_rpm - self.from_rpm).abs() / rpm_per_s
    }

    fn reached_rpm(&self, rpm_per_s: f64) -> f64 {
        let takes_s = self.takes_s(rpm_per_s);
        if self.passed_s >= takes_s {
            return self.to_rpm;
        }
        self.from_rpm + (self.to_rpm - self.from_rpm) * self.passed_s / takes_s
    }
}

impl<'a> SpindleRun<'a> {
    /// Runs one more operation of the job: a doubt where it cuts while the spindle still changes
    /// its speed. A start from standstill is not looked at, nor is a change of tool, for which the
    /// spindle stands.
    pub(super) fn cuts_too_early(
        &mut self,
        job: &Job,
        operation: &'a Operation,
        path: &Path,
    ) -> Option<Note> {
        let most = job.spindle.max_acceleration_rpm_per_s?;
        let SpindleSpeed::Constant(rpm) = operation.speed else {
            self.next = None;
            return None;
        };
        let moves = &operation.moves;
        let start = operation.stretch.start;
        if !self.next.is_some_and(|(of, next)| Arc::ptr_eq(of, moves) && next == start) {
            self.tool = moves.first().and_then(|first| first.stated.tool);
            self.change = start_of_path(operation, rpm).map(Change::done);
        }
        self.next = Some((moves, operation.stretch.end));
        let mut worst: Option<(f64, usize, Change)> = None;
        for (index, [from_s, to_s]) in path.moves_run() {
            let Some(each) = moves.get(index) else { continue };
            if !each.spindle_turns || each.stated.tool != self.tool {
                self.change = None;
            }
            self.tool = each.stated.tool;
            if !each.spindle_turns {
                continue;
            }
            let to_rpm = directed(rpm, each);
            let change = self.change.get_or_insert(Change::done(to_rpm));
            if change.to_rpm != to_rpm {
                *change = Change { from_rpm: change.reached_rpm(most), to_rpm, passed_s: 0.0 };
            }
            let takes_s = change.takes_s(most);
            let lacks_s = takes_s - change.passed_s;
            if lacks_s > DONE * takes_s
                && worst.is_none_or(|(other_s, ..)| lacks_s > other_s)
                && in_work(operation, path, to_s) == InWork::Cuts
            {
                worst = Some((lacks_s, each.line, *change));
            }
            change.passed_s += (to_s - from_s) * path.duration_s();
        }
        let (_, line, change) = worst?;
        let place = Place { line: Some(line), ..Place::default() };
        let note = Note::warning(Code::SpindleAcceleration, place, shown(&change, most));
        Some(in_operation(job, operation, note))
    }
}

/// The speed at which the spindle turns where the path starts, if the program has commanded it.
fn start_of_path(operation: &Operation, rpm: f64) -> Option<f64> {
    let rpm_of = |each: &Move| each.stated.spindle.and_then(Spindle::rpm);
    let [first, second, ..] = operation.moves.as_slice() else { return None };
    let is_of_program = operation.stretch.start == 0
        && operation.is_speed_of_program
        && rpm_of(second) == Some(rpm);
    rpm_of(first).filter(|_| is_of_program).map(|rpm| directed(rpm, first))
}

fn directed(rpm: f64, of: &Move) -> f64 {
    if of.stated.is_reversed { -rpm } else { rpm }
}

fn shown(change: &Change, rpm_per_s: f64) -> String {
    let [from, to] = [change.from_rpm, change.to_rpm].map(|rpm| plain(rounded(rpm.abs(), 1)));
    let speeds = if change.from_rpm * change.to_rpm < 0.0 {
        format!("{from} rpm to {to} rpm the other way round")
    } else {
        format!("{from} to {to} rpm")
    };
    let [takes, passed] = distinguishable(change.takes_s(rpm_per_s), change.passed_s, 1);
    format!(
        "the spindle takes {takes} s from {speeds} (spindle.max_acceleration_rpm_per_s is \
         {rpm_per_s}), of which {passed} s pass before the next cut: the speeds between are not \
         checked"
    )
}
