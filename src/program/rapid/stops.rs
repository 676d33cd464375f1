//! Moves that run on beside the program (`\Conc`), what holds the arm or drops the rest of its way
//! (`StopMove`, `ClearPath`, …), and how long it stands at a stop point.

use super::constants::stop_point_of;
use super::interpreter::Interpreter;
use super::syntax::{Args, Block, Name};
use super::value::Value;
use super::walk::calls_in;
use crate::notes::Code;

/// Instructions after which what is left of the moves before may never be gone, or not from there.
const DROPS: [&str; 4] = ["clearpath", "storepath", "restopath", "stopmovereset"];

/// Whether an instruction drops the rest of the path.
pub(super) fn drops(key: &str) -> bool {
    DROPS.contains(&key)
}

impl<'a> Interpreter<'a> {
    /// A move begins: whether it stops at its end, and whether the program runs on beside it.
    pub(super) fn begin_move(&mut self, stops: bool, runs_on: bool) {
        self.has_arrived = stops && !runs_on;
        // The first of all moves goes to where the path starts.
        self.runs_on = runs_on && self.log.has_moved();
        self.is_stopped &= runs_on;
        (self.active_tool, self.active_unknown) = (None, false);
        if self.is_held {
            let what = "StopMove stands before this move, and no StartMove between them: the arm \
                        stands still until something else starts it; it is read as if it moved";
            self.log.warning(Code::MotionLeftOut, self.line, what);
        }
    }

    /// The program waits until the arm stands.
    pub(super) fn arrive(&mut self) {
        // What StopMove holds does not stand at its end.
        if !self.is_stopped {
            self.has_arrived = true;
            self.runs_on = false;
            self.settle();
        }
    }

    /// Heeds what holds the arm on its way, or drops the rest of it.
    pub(super) fn heed_stop(&mut self, line: usize, name: &Name) {
        match name.key.as_str() {
            "stopmove" => {
                self.is_stopped |= !self.has_arrived;
                self.is_held = true;
            }
            "startmove" | "startmoveretry" => (self.is_stopped, self.is_held) = (false, false),
            key if drops(key) => {
                self.doubt_rest(line, &name.shown);
                self.is_stopped &= key != "stopmovereset";
                self.is_held &= key != "stopmovereset";
                self.runs_on &= key != "clearpath";
            }
            _ => {}
        }
    }

    /// The same of blocks of which only the run knows whether they run.
    pub(super) fn heed_open(&mut self, line: usize, blocks: &[&'a Block]) {
        let calls = calls_in(self.file, blocks);
        // A block that starts the arm does so behind its stop.
        let holds = |block: &&'a Block| {
            let calls = calls_in(self.file, &[block]);
            let has = |wanted: &str| calls.iter().any(|(name, _)| name.key == wanted);
            has("stopmove")
                && !["startmove", "startmoveretry", "stopmovereset"].into_iter().any(has)
        };
        self.is_held |= blocks.iter().any(holds);
        for (name, args) in calls {
            match name.key.as_str() {
                "connect" => self.connect(line, args),
                "setsysdata" => self.lose_active(args),
                key if drops(key) => self.doubt_rest(line, &name.shown),
                "deactunit" => self.switch_off(args, false),
                _ => self.heed_change(line, name, args),
            }
        }
    }

    fn doubt_rest(&mut self, line: usize, shown: &str) {
        if !self.has_arrived && self.log.has_moved() {
            let what = format!(
                "{shown} stands behind a move for whose end the program does not wait (fine, \
                 without \\Conc): what is left of it may be dropped; it is read as if it were done"
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// Tells of what is done while the arm moves.
    pub(super) fn doubt_beside(&mut self, code: Code, line: usize, shown: &str) {
        if self.runs_on {
            let what = format!(
                "{shown} stands behind a move with \\Conc and is done while the arm is on it: it \
                 is read as if it were done at the end of the move"
            );
            self.log.warning(code, line, what);
        }
    }

    /// `WaitTime 2;`: the arm stands, unless it is on its way.
    pub(super) fn wait_time(&mut self, line: usize, args: &'a Args) {
        if args.optional.iter().any(|(name, _)| name == "inpos") {
            self.arrive();
        }
        match args.positional.first().map(|expr| self.eval(expr).num()) {
            Some(Ok(seconds)) if seconds > 0.0 && self.is_late => {
                let what = "WaitTime in the procedure of a move in a zone runs while the arm is on \
                            its way: the time is left out";
                self.leave_out_time(line, what);
            }
            Some(Ok(seconds)) if seconds > 0.0 && self.runs_on && !self.is_stopped => {
                let what = "WaitTime behind a move with \\Conc runs while the arm is on it: the \
                            time is left out";
                self.leave_out_time(line, what);
            }
            Some(Ok(seconds)) => self.log.dwell(line, seconds),
            Some(Err(why)) => {
                self.leave_out_time(line, &format!("WaitTime: {why}; the time is left out"));
            }
            None => self.log.error(Code::Motion, line, "WaitTime: the time is missing"),
        }
    }

    /// `\Inpos:=stoptime0_5`: at the end of its way the arm stands for the time that the data have,
    /// in a stop point of a position for the least time there.
    pub(super) fn dwell_at_end(&mut self, line: usize, data: Option<&Value>) {
        let Some(data) = data else { return };
        const OF: &str = "stoppointdata";
        let number = |at: usize| data.part(at, OF).and_then(Value::num);
        let seconds = match number(0).map(stop_point_of) {
            Ok(Some("inpos")) => {
                let least = data.part(2, OF).and_then(|own| own.part(2, OF)).and_then(Value::num);
                least.map(|seconds| seconds.max(0.0))
            }
            Ok(Some("stoptime")) => number(3),
            Ok(Some("fllwtime")) => Err("the arm follows a conveyor".to_owned()),
            Ok(_) => return,
            Err(why) => Err(why),
        };
        match seconds {
            Ok(seconds) => self.log.dwell(line, seconds),
            Err(why) => {
                let what = format!("\\Inpos: {why}; the time at the stop point is left out");
                self.leave_out_time(line, &what);
            }
        }
    }

    /// Where the speed of the spindle follows the time, it counts.
    fn leave_out_time(&mut self, line: usize, what: &str) {
        let code = match self.settings.is_scheduled {
            true => Code::MotionLeftOut,
            false => Code::LeftOut,
        };
        self.log.warning(code, line, what);
    }
}
