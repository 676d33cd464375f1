//! The procedures of `MoveLSync` and its like. Where the arm stops at the end of the move, one runs
//! there, and the program waits for it. In a zone it runs in the middle of the corner: the program
//! is at a later move by then, and goes on with its own data until the arm has come to stand.

use std::collections::{HashMap, HashSet};

use super::instructions::{motion, sounds_like_motion};
use super::interpreter::{Flow, Global, Interpreter};
use super::late::{Late, Modes};
use super::sets::set_within;
use super::syntax::{Args, Expr, Name, Routine, What};
use super::value::Value;
use super::walk::{
    blocks_within, calls_in, expressions_in, names_in, statements_in, synced_name, synced_procedure,
};
use crate::notes::Code;

/// Instructions that say how the arm moves from then on.
const SET_MODES: [&str; 8] =
    ["velset", "speedrefresh", "gripload", "cirpathmode", "confj", "confl", "actunit", "deactunit"];

static NO_ARGS: Args = Args { positional: Vec::new(), optional: Vec::new() };

impl<'a> Interpreter<'a> {
    /// `MoveLSync p, v, z, tool, "prc";`: the procedure that runs where the move ends.
    pub(super) fn synced(&mut self, line: usize, name: &Name, args: &'a Args) -> Flow {
        let Some(routine) = synced_procedure(self.file, name, args) else {
            match synced_name(args) {
                Some(own) => self.not_in_file(line, own),
                None => self.not_in_file(line, &format!("the procedure of {}", name.shown)),
            }
            return Flow::Next;
        };
        self.doubt_procedure(line, routine);
        let flow = match self.has_arrived {
            true => self.call_routine(routine, &NO_ARGS),
            false => self.run_late(line, name, routine),
        };
        match flow {
            Flow::Exit => Flow::Exit,
            _ => Flow::Next,
        }
    }

    /// Runs a procedure that the program is ahead of: what it sets counts from the next stop on.
    fn run_late(&mut self, line: usize, name: &Name, routine: &'a Routine) -> Flow {
        // Those of the moves before run before it.
        let mut late = std::mem::take(&mut self.late);
        self.take_over(&late);
        let set = set_within(self.file, &routine.body).into_iter();
        let set: HashSet<&'a str> = set.map(|name| name.key.as_str()).collect();
        let keys: HashSet<&'a str> = late.data.keys().chain(&set).copied().collect();
        let before: Vec<_> = keys.into_iter().map(|key| (key, self.datum_now(key))).collect();
        let own = self.modes();
        let outer = std::mem::replace(&mut self.is_late, true);
        let flow = self.call_routine(routine, &NO_ARGS);
        self.is_late = outer;
        self.settle();
        self.has_arrived = false;
        for (key, value) in before {
            let behind = self.datum_now(key);
            if behind != value || late.data.contains_key(key) {
                late.data.insert(key, behind);
                self.put_datum(key, value);
            }
        }
        let behind = self.modes();
        // What it sets counts where it is the same, too: the program may set it otherwise.
        if behind != own || late.modes.is_some() || self.sets_modes(routine) {
            self.put_modes(own.clone());
            late.modes = Some(Box::new([own, behind]));
        }
        late.used.extend(set);
        late.shown = &routine.name.shown;
        self.note_what_it_does(line, name, routine, &mut late);
        if matches!(flow, Flow::Exit) {
            let what = format!(
                "'{}' of {} ends the program in a zone: what is done of the next move is not read",
                late.shown, name.shown
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        self.late = late;
        flow
    }

    /// What it asks for, whether it sets the spindle, and whether it moves, which is a doubt.
    fn note_what_it_does(
        &mut self,
        line: usize,
        name: &Name,
        routine: &'a Routine,
        late: &mut Late<'a>,
    ) {
        let mut moves = false;
        let blocks = blocks_within(self.file, &[&routine.body]);
        // Names there are none of the routine that moves.
        self.frames.push(HashMap::new());
        for what in statements_in(blocks.into_iter()) {
            let asked = names_in(expressions_in(what)).into_iter();
            late.used.extend(asked.map(|name| name.key.as_str()));
            match what {
                What::Assign(path, _) => late.sets |= self.would_assign(path),
                What::Call(name, args) => {
                    let own = self.file.procedures.get(&name.key);
                    late.sets |= self.would_set(name, args)
                        || own.is_some_and(|own| self.gives_signal(own, args));
                    moves |= motion(&name.key).is_some() || sounds_like_motion(&name.key);
                }
                _ => {}
            }
        }
        self.frames.pop();
        if moves {
            let what = format!(
                "'{}' of {} moves the arm, which does not stop for it (fine): it is read as if it \
                 did",
                routine.name.shown, name.shown
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// The arm has come to stand: the procedures of the moves before have run.
    pub(super) fn settle(&mut self) {
        let late = std::mem::take(&mut self.late);
        self.take_over(&late);
    }

    fn take_over(&mut self, late: &Late<'a>) {
        for (key, value) in &late.data {
            self.put_datum(key, value.clone());
        }
        let Some(modes) = &late.modes else { return };
        let [own, behind] = &**modes;
        if self.modes() != *own {
            let what = format!(
                "'{}' changes how the arm moves (VelSet and the like) in the zone of its move, and \
                 so does the program beside it: which is last the run decides",
                late.shown
            );
            self.log.warning(Code::MotionLeftOut, self.line, what);
        }
        self.put_modes(behind.clone());
    }

    /// Of a datum that is asked for while a procedure that sets it may have run or not.
    pub(super) fn doubt_late(&mut self, key: &str, name: &Name) {
        if self.late.data.contains_key(key) && self.of_motion().contains(key) {
            let what = format!(
                "'{}' sets '{}' in the zone of its move, before this or behind it: the value \
                 before it is taken; a stop between them (fine, WaitRob \\InPos) settles it",
                self.late.shown, name.shown
            );
            self.log.warning(Code::MotionLeftOut, self.line, what);
        }
    }

    /// The program waits for what a procedure sets that may have run or not: it has run behind it.
    pub(super) fn waits_for_late(&mut self, line: usize, shown: &str, of: &'a Expr) -> bool {
        let frame = self.frames.last();
        let is_local = |key: &str| frame.is_some_and(|frame| frame.contains_key(key));
        let is_late = |name: &&'a Name| {
            let key = name.key.as_str();
            self.late.data.contains_key(key) && !is_local(key)
        };
        let Some(name) = names_in(vec![of]).into_iter().find(is_late) else { return false };
        let what = format!(
            "{shown} waits for '{}', which '{}' sets in the zone of its move: it is read as if \
             that had run by then, and the arm did not stop there; fine settles it",
            name.shown, self.late.shown
        );
        self.log.warning(Code::MotionLeftOut, line, what);
        self.settle();
        true
    }

    /// Of a datum that the program sets while a procedure that uses it may have run or not.
    pub(super) fn doubt_order(&mut self, key: &str, name: &Name) {
        if self.late.used.contains(key) && self.of_motion().contains(key) {
            let what = format!(
                "'{}' uses '{}' in the zone of its move, before it is set here or behind: it is \
                 read as if it did so before; a stop between them (fine, WaitRob \\InPos) settles \
                 it",
                self.late.shown, name.shown
            );
            self.log.warning(Code::MotionLeftOut, self.line, what);
        }
    }

    /// The same of the spindle or the tool, which both set.
    pub(super) fn doubt_order_of_setters(&mut self, line: usize, shown: &str) {
        if self.late.sets {
            let what = format!(
                "'{}' sets the spindle or the tool in the zone of its move, and {shown} does so \
                 here: which is last the run decides; they are read in this order",
                self.late.shown
            );
            self.log.warning(Code::SpindleCommand, line, what);
        }
    }

    /// Of a move that begins while a procedure that changes how the arm moves may have run or not.
    pub(super) fn doubt_modes(&mut self, line: usize) {
        let late = self.late.modes.as_deref();
        if late.is_some_and(|[_, behind]| self.modes() != *behind) {
            let what = format!(
                "'{}' changes how the arm moves (VelSet and the like) in the zone of its move, \
                 before this move or on it: this is read as if it had not; a stop between them \
                 (fine, WaitRob \\InPos) settles it",
                self.late.shown
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// Whether a procedure, or what it calls in the files, sets how the arm moves.
    fn sets_modes(&self, routine: &'a Routine) -> bool {
        let calls = calls_in(self.file, &[&routine.body]);
        calls.iter().any(|(name, _)| SET_MODES.contains(&name.key.as_str()))
    }

    fn modes(&self) -> Modes {
        Modes {
            over: self.over,
            velocity: self.velocity,
            monitors: self.monitors,
            turning: self.turning,
            gripped: self.gripped.clone(),
            off: self.off.clone(),
        }
    }

    fn put_modes(&mut self, modes: Modes) {
        let Modes { over, velocity, monitors, turning, gripped, off } = modes;
        (self.over, self.velocity, self.monitors) = (over, velocity, monitors);
        (self.turning, self.gripped, self.off) = (turning, gripped, off);
    }

    /// What the program has set a datum of the modules, or of no file, to.
    pub(super) fn datum_now(&mut self, key: &'a str) -> Option<Value> {
        let file = self.file;
        let Some(data) = file.data.get(key) else { return self.assigned.get(key).cloned() };
        // One that is declared in terms of itself stays unknown.
        self.work_out(data).ok();
        match self.globals.get(key) {
            Some(Global::Known(value)) => Some(value.clone()),
            _ => None,
        }
    }

    fn put_datum(&mut self, key: &'a str, value: Option<Value>) {
        match (self.file.data.contains_key(key), value) {
            (true, Some(value)) => drop(self.globals.insert(key, Global::Known(value))),
            (true, None) => {}
            (false, Some(value)) => drop(self.assigned.insert(key, value)),
            (false, None) => drop(self.assigned.remove(key)),
        }
    }
}
