//! Branches and loops that only the run decides, and what they call: what they may set is not known
//! behind them.

use std::collections::HashSet;

use super::run::{Frame, MAX_DEPTH, Run};
use super::syntax::{Block, Expr, Path, Routine, Statement, What};
use super::value::Value;
use super::walk::{blocks_in, expressions, functions_in, paths_in};
use super::words::{
    BEHIND_MOVE, MAY_SET, fills, is_harmless, is_own_function, is_without_effect, sets_motion,
    sounds_like_motion,
};
use crate::notes::Code;
use crate::program::Setter;
use crate::program::cell::all;

const DEPENDS: &str = " depends on a condition: ";

/// What stands under a condition that only the run decides.
struct Open<'a, 'w> {
    keyword: &'static str,
    /// Why the condition is not known.
    why: &'w str,
    /// Routines that have been looked at.
    seen: HashSet<&'a str>,
    /// In which of them, and on which line, something decides about motion.
    found: Option<(&'a str, usize)>,
}

/// Where a statement stands under it.
#[derive(Debug, Clone, Copy, Default)]
struct Within<'a> {
    /// In a routine that is called there: its name.
    routine: Option<&'a str>,
    /// In a loop that begins there.
    is_loop: bool,
}

impl<'a> Run<'a> {
    /// One of the blocks may run or not: harmless if they, and the routines that they call, neither
    /// move nor set anything that motion depends on.
    pub(super) fn undecided(
        &mut self,
        line: usize,
        keyword: &'static str,
        why: &str,
        blocks: [&'a Block; 2],
    ) {
        let all = blocks.into_iter().flatten().map(|statement| &statement.what).collect();
        let reached = self.reached(all);
        let actions = reached.iter().copied().filter_map(|what| match what {
            What::Trigger(action) | What::InterruptDecl(_, action) => action.as_deref(),
            _ => None,
        });
        let actions = actions.chain(self.interrupts.values().flatten().copied()).collect();
        let sets = self.reached(actions).into_iter().chain(reached).flat_map(names_set).collect();
        let outer = std::mem::replace(&mut self.open_sets, sets);
        let mut open = Open { keyword, why, seen: HashSet::new(), found: None };
        let (place, main_line) = (self.place, self.line);
        let mut blocks = blocks.into_iter();
        let is_read = blocks.all(|block| self.open_block(&mut open, block, Within::default()));
        self.enter_again(place, main_line);
        self.open_sets = outer;
        // One that runs too long is told of already.
        if !is_read && self.budget > 0 {
            let found = open.found.map_or_else(String::new, |(name, line)| {
                format!(", which line {line} of '{name}' rests on")
            });
            self.decides(line, keyword, &format!("{why}{found}"));
        }
    }

    /// False where something in the block decides about motion.
    fn open_block(
        &mut self,
        open: &mut Open<'a, '_>,
        block: &'a Block,
        within: Within<'a>,
    ) -> bool {
        if self.depth >= MAX_DEPTH {
            return false;
        }
        self.depth += 1;
        let is_read = block.iter().all(|statement| {
            let line = self.enter(statement.file, statement.line);
            // What comments set there may hold behind it or not.
            let is_set = statement.file == 0 && self.comments.set_at(line);
            let is_read = self.another(line)
                && !is_set
                && self.open_statement(open, line, &statement.what, within);
            if let (false, Some(name)) = (is_read, within.routine) {
                open.found.get_or_insert((name, statement.line));
            }
            is_read
        });
        self.depth -= 1;
        is_read
    }

    fn open_statement(
        &mut self,
        open: &mut Open<'a, '_>,
        line: usize,
        what: &'a What,
        within: Within<'a>,
    ) -> bool {
        self.doubt_open(line, what);
        for (name, args) in functions_in(expressions(what)) {
            if let Some(function) = self.file.functions.get(name) {
                if !self.open_call(open, line, (name, function), args) {
                    return false;
                }
                continue;
            }
            self.fill(name, args);
            if !is_own_function(name) {
                self.not_read(line, name, args);
            }
        }
        match what {
            What::Declare(..) | What::Halt | What::Label(_) | What::InterruptOff(_) => {}
            // Out of the routine alone, or within it.
            What::Return(_) | What::Goto(_) if within.routine.is_some() => {}
            What::Exit if within.is_loop => {}
            What::WaitSec(_) => {
                let keyword = open.keyword;
                // The body of REPEAT has run once.
                let read = if keyword == "UNTIL" { "counts once" } else { "is left out" };
                let what = format!("WAIT SEC under {keyword} that only the run decides {read}");
                self.log.warning(Code::LeftOut, line, what);
            }
            What::InterruptDecl(number, action) => {
                self.declare_interrupt(number, action.as_deref());
            }
            What::InterruptOn(number) => self.interrupt_on(line, number.as_ref()),
            What::Trigger(action) => self.trigger(line, action.as_deref()),
            What::Call(name, args) => match self.file.routine(name) {
                Some(routine) => return self.open_call(open, line, (name, routine), args),
                None => return self.open_unread((line, open.why), name, args),
            },
            What::Assign(path, _)
                if is_without_effect(&path.name) || !path.name.starts_with('$') =>
            {
                self.open_path(open, line, path, within);
            }
            What::If(..) | What::Switch(..) => {
                return blocks_in(what).into_iter().all(|own| self.open_block(open, own, within));
            }
            What::For(..) | What::While(..) | What::Repeat(..) | What::Loop(_) => {
                if let What::For(variable, ..) = what {
                    self.open_path(open, line, variable, within);
                }
                if let What::While(_, body) | What::Repeat(body, _) | What::Loop(body) = what {
                    self.polled(body, expressions(what));
                }
                let within = Within { is_loop: true, ..within };
                return blocks_in(what).into_iter().all(|own| self.open_block(open, own, within));
            }
            _ => return false,
        }
        true
    }

    /// A statement of the controller, or a routine that is in no file.
    fn open_unread(
        &mut self,
        (line, why): (usize, &str),
        name: &'a str,
        args: &'a [Option<Expr>],
    ) -> bool {
        match name {
            "pulse" => self.pulse(args),
            // What it gives depends on the passes, and so does what holds then.
            "wait for" if self.asks_routines(args) => {
                for path in paths_in(args.iter().flatten().collect()) {
                    self.forget_under(path, why);
                }
            }
            "wait for" => {
                let values: Vec<Value> =
                    args.iter().map(|arg| self.argument(arg.as_ref())).collect();
                self.waited(args, &values);
            }
            _ if fills(name) => self.fill(name, args),
            _ if is_harmless(name) => {}
            _ if name == "bas" || sounds_like_motion(name) => return false,
            _ => self.not_read(line, name, args),
        }
        true
    }

    fn asks_routines(&self, args: &[Option<Expr>]) -> bool {
        let asked = functions_in(args.iter().flatten().collect());
        asked.iter().any(|(name, _)| self.file.functions.contains_key(*name))
    }

    /// A routine of the files: what it may set is known no longer, whatever it is given.
    fn open_call(
        &mut self,
        open: &mut Open<'a, '_>,
        line: usize,
        (name, routine): (&'a str, &'a Routine),
        args: &'a [Option<Expr>],
    ) -> bool {
        // What the job reads the spindle or the tool from has to be decided.
        let is_of_job = all(self.settings).any(|(_, by)| match &by.what {
            Setter::Procedure(own, _) => own.to_lowercase() == name,
            Setter::Comment(_) | Setter::Signal(_) => false,
        });
        if is_of_job {
            return false;
        }
        self.doubt_routine(line, name, routine);
        for (parameter, arg) in routine.parameters.iter().zip(args) {
            let Some(Expr::Ref(path)) = arg else { continue };
            if !parameter.is_by_value {
                if sets_motion(&path.name) {
                    return false;
                }
                self.forget_under(path, open.why);
                if path.indices.is_empty() {
                    self.forget_all(&path.name, &depends(&path.name, open.why));
                }
            }
        }
        if !open.seen.insert(name) {
            return true;
        }
        let mut frame = Frame::default();
        for parameter in &routine.parameters {
            let value = Value::unknown(depends(&parameter.name, open.why));
            frame.data.insert(parameter.name.clone(), value);
        }
        for statement in &routine.body {
            if let What::Declare(declared, paths, _) = &statement.what {
                frame.types.extend(paths.iter().map(|path| (path.name.clone(), *declared)));
            }
        }
        let (place, main_line) = (self.place, self.line);
        self.frames.push(frame);
        let within = Within { routine: Some(&routine.shown), is_loop: false };
        let is_read = self.open_block(open, &routine.body, within);
        self.frames.pop();
        self.enter_again(place, main_line);
        is_read
    }

    /// A datum that may be set there.
    fn open_path(&mut self, open: &Open<'a, '_>, line: usize, path: &'a Path, within: Within<'a>) {
        self.forget_under(path, open.why);
        // A line of a routine may have been read elsewhere, too.
        if within.routine.is_some()
            && self.place.0 == 0
            && self.key(path).is_ok_and(|key| self.is_read_by_job(&key))
        {
            let what = format!("{}: the job reads it", depends(&path.name, open.why));
            self.log.warning(Code::SpindleCommand, line, what);
        }
    }

    /// A datum is set or not by what the run decides.
    pub(super) fn forget_under(&mut self, path: &'a Path, why: &str) {
        self.forget(path, &depends(&path.name, why));
    }

    /// What an endless loop, or a routine that it calls, does under conditions that others may
    /// change, as a message goes on: they are read as they are in its first pass.
    pub(super) fn open_in(&mut self, body: &'a [Statement]) -> String {
        // Each with the routine that it is of, where the loop calls that.
        let mut open: Vec<(&'a Statement, Option<&'a Routine>)> =
            body.iter().rev().map(|own| (own, None)).collect();
        let mut called: Vec<&str> = Vec::new();
        while let Some((statement, routine)) = open.pop() {
            let what = &statement.what;
            if let What::Call(name, _) = what
                && let Some(callee) = self.file.routine(name)
                && !called.contains(&name.as_str())
            {
                called.push(name);
                open.extend(callee.body.iter().rev().map(|own| (own, Some(callee))));
            }
            let blocks = blocks_in(what).into_iter().flatten();
            let moving = blocks.clone().find(|own| self.moves(&own.what));
            let Some(moving) = moving else { continue };
            open.extend(blocks.rev().map(|own| (own, routine)));
            let asked = paths_in(expressions(what));
            let mut asked = asked.into_iter();
            let Some(path) = asked.find(|path| self.may_change(&path.name, routine)) else {
                continue;
            };
            let mut name = self.key(path).unwrap_or_else(|_| path.name.clone());
            for field in &path.fields {
                name = format!("{name}.{field}");
            }
            let name = name.to_uppercase();
            let other = moving.file.checked_sub(1);
            let other = other.and_then(|index| self.settings.companions.get(index));
            let of = other.map_or_else(String::new, |it| format!(" of {}", it.name));
            return format!(
                "; what moves from line {}{of} on depends on {name}, which another may change \
                 between two passes, and is read as {name} is in the first: assume: \
                 {{\"{name}\": …}} in the job says that, where the file that is checked does not \
                 set it before the loop",
                moving.line
            );
        }
        String::new()
    }

    /// Whether others may change a datum: no constant, none of a routine, not where the robot is.
    fn may_change(&self, name: &str, routine: Option<&Routine>) -> bool {
        let is_own = routine.map_or_else(|| self.is_own(name), |own| own.declares(name));
        let is_place = name.starts_with("$pos_") || name.starts_with("$axis_");
        !is_own && !is_place && !self.file.constants.contains(name)
    }

    pub(super) fn decides(&mut self, line: usize, keyword: &str, why: &str) {
        self.is_way_open = true;
        let function = why.split_once("function '").and_then(|(_, rest)| rest.split_once('\''));
        let hint = match function {
            _ if why.contains("assume: ") => String::new(),
            _ if why.contains(MAY_SET) || why.contains(BEHIND_MOVE) => {
                "; path.program.files in the job can name its file".to_owned()
            }
            Some((name, rest)) if rest.starts_with(" is not read") => {
                let name = name.to_uppercase();
                format!("; assume: {{\"{name}\": …}} in the job can give it")
            }
            _ => "; assume: in the job can settle it".to_owned(),
        };
        let what = format!("{keyword} decides about motion at run time: {why}{hint}");
        self.log.error(Code::Motion, line, what);
    }
}

/// Why a datum is not known that is set under a condition; of conditions that depend on conditions
/// the cause is told.
fn depends(name: &str, why: &str) -> String {
    let cause = why.rsplit(DEPENDS).next().unwrap_or(why);
    format!("'{name}'{DEPENDS}{cause}")
}

/// Names that a statement, its blocks aside, may set.
pub(super) fn names_set(what: &What) -> Vec<&str> {
    let given = functions_in(expressions(what)).into_iter().map(|(_, args)| args);
    let own = match what {
        What::Call(_, args) => Some(args.as_slice()),
        _ => None,
    };
    // By reference: names in an index are not set.
    let args = given.chain(own).flatten().flatten();
    let mut found: Vec<&str> = args
        .filter_map(|arg| match arg {
            Expr::Ref(path) => Some(path.name.as_str()),
            _ => None,
        })
        .collect();
    if let What::Assign(path, _) | What::For(path, ..) = what {
        found.push(&path.name);
    }
    found
}
