//! Places that the program does not give: the ways there and back are not on the path.

use super::{Log, Pace, Spindle};
use crate::motion::Target;
use crate::notes::Code;

impl Log {
    /// The tool goes to a place that the program does not give. Before the first move and behind
    /// the last the path is whole without that way; in between the way back must be rapid.
    pub(in crate::program) fn leaves(&mut self, line: usize, how: &str) {
        let what = format!("{how}: the place is not in the program");
        if self.moves.is_empty() {
            self.begins_away = true;
            self.warning(Code::LeftOut, line, left_out(&what));
        } else {
            self.away.get_or_insert((line, what));
        }
    }

    /// Whether the program begins with a way to where it does not say.
    pub(in crate::program) fn begins_away(&self) -> bool {
        self.begins_away && self.moves.is_empty()
    }

    /// Whether the tool is where the program does not say.
    pub(in crate::program) fn is_away(&self) -> bool {
        self.away.is_some()
    }

    /// Where the path starts, the move that leads there is no part of it: a cut is lost. A line may
    /// come from anywhere, unless the program goes to a place of its own before.
    pub(super) fn tell_start(&mut self, line: usize, to: &Target, pace: Pace) {
        let is_cut = match to {
            Target::Arc { .. } => true,
            Target::Line(_) => self.begins_away && pace != Pace::Rapid,
            Target::Joints(_) | Target::JointsTo(_) => false,
        };
        if is_cut && self.moves.is_empty() && self.stated.spindle != Some(Spindle::Stands) {
            let what = "the first move that is read is at feed, from a place that is not in the \
                        program: what it cuts on the way is not checked; begin with a rapid move, \
                        or one in the joints, to a place that the program states";
            self.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// The way back from a place that the program does not give: by the joints where it is rapid.
    pub(super) fn come_back(&mut self, line: usize, to: Target, pace: Pace) -> Target {
        let Some((from, what)) = self.away.take() else { return to };
        let to = match to {
            Target::Line(pose) if pace == Pace::Rapid => Target::JointsTo(pose),
            to => to,
        };
        if matches!(to, Target::Joints(_) | Target::JointsTo(_)) {
            let stands = self.stated.spindle == Some(Spindle::Stands);
            let code = if stands { Code::LeftOut } else { Code::MotionLeftOut };
            let what = format!(
                "{what}; the arm is taken to go from the place before to that of line {line} \
                 straight in the joints"
            );
            self.warning(code, from, what);
        } else {
            let what = format!(
                "{what}, and motion at feed follows from there; state X, Y and Z by rapid moves \
                 before, or split the program here into several operations"
            );
            self.error(Code::Motion, from, what);
        }
        to
    }
}

pub(super) fn left_out(what: &str) -> String {
    format!("{what}; the move there is skipped")
}
