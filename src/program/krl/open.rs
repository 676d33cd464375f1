//! Branches and loops that only the run decides: what they may set is not known behind them.

use super::run::Run;
use super::syntax::{Block, Routine, Statement, What};
use super::value::Value;
use super::walk::{blocks_in, expressions, functions_in, paths_in};
use super::words::{
    BEHIND_MOVE, MAY_SET, fills, is_harmless, is_own_function, is_without_effect,
    sounds_like_motion,
};
use crate::notes::Code;

const DEPENDS: &str = " depends on a condition: ";

impl<'a> Run<'a> {
    /// One of the blocks may run or not: harmless if they neither move nor set anything.
    pub(super) fn undecided(
        &mut self,
        line: usize,
        keyword: &str,
        why: &str,
        blocks: [&'a Block; 2],
    ) {
        let mut open: Vec<&'a Block> = blocks.into_iter().collect();
        while let Some(block) = open.pop() {
            for statement in block {
                // A statement of another file counts as the one that leads to it.
                let own = if statement.file == 0 { statement.line } else { line };
                self.doubt_open(own, &statement.what);
                if self.calls_a_routine(expressions(&statement.what)) {
                    return self.decides(line, keyword, why);
                }
                for (name, args) in functions_in(expressions(&statement.what)) {
                    self.fill(name, args);
                    if !self.file.functions.contains_key(name) && !is_own_function(name) {
                        self.not_read(own, name, args);
                    }
                }
                match &statement.what {
                    What::Call(name, args) if name == "pulse" => self.pulse(args),
                    What::Call(name, args) if name == "wait for" => {
                        let values: Vec<Value> =
                            args.iter().map(|arg| self.argument(arg.as_ref())).collect();
                        self.waited(args, &values);
                    }
                    What::Call(name, args) if fills(name) => self.fill(name, args),
                    What::Declare(..) | What::Halt | What::Label(_) | What::InterruptOff(_) => {}
                    What::WaitSec(_) => {
                        // The body of REPEAT has run once.
                        let read = if keyword == "UNTIL" { "counts once" } else { "is left out" };
                        let what =
                            format!("WAIT SEC under {keyword} that only the run decides {read}");
                        self.log.warning(Code::LeftOut, own, what);
                    }
                    What::InterruptDecl(number, action) => {
                        self.declare_interrupt(number, action.as_deref());
                    }
                    What::InterruptOn(number) => self.interrupt_on(own, number.as_ref()),
                    What::Trigger(action) => self.trigger(own, action.as_deref()),
                    What::Call(name, _)
                        if !self.file.routines.contains_key(name) && is_harmless(name) => {}
                    What::Assign(path, _)
                        if is_without_effect(&path.name) || !path.name.starts_with('$') =>
                    {
                        // Of conditions that depend on conditions the cause is told.
                        let cause = why.rsplit(DEPENDS).next().unwrap_or(why);
                        let what = format!("'{}'{DEPENDS}{cause}", path.name);
                        self.forget(path, &what);
                    }
                    What::If(_, yes, no) => open.extend([yes, no]),
                    What::Call(name, args)
                        if !self.file.routines.contains_key(name)
                            && name != "bas"
                            && !sounds_like_motion(name) =>
                    {
                        self.not_read(own, name, args);
                    }
                    _ => {
                        self.decides(line, keyword, why);
                        return;
                    }
                }
            }
        }
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
                && let Some(callee) = self.file.routines.get(name)
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
        let declares = |what: &What| match what {
            What::Declare(_, paths, _) => paths.iter().any(|path| path.name == name),
            _ => false,
        };
        let is_own = match routine {
            None => self.is_own(name),
            Some(routine) => {
                routine.parameters.iter().any(|own| own.name == name)
                    || routine.body.iter().any(|own| declares(&own.what))
            }
        };
        let is_place = name.starts_with("$pos_") || name.starts_with("$axis_");
        !is_own && !is_place && !self.file.constants.contains(name)
    }

    pub(super) fn decides(&mut self, line: usize, keyword: &str, why: &str) {
        self.is_way_open = true;
        let hint = match why {
            _ if why.contains("assume: ") => "",
            _ if why.contains(MAY_SET) || why.contains(BEHIND_MOVE) => {
                "; path.program.files in the job can name its file"
            }
            _ => "; assume: in the job can settle it",
        };
        let what = format!("{keyword} decides about motion at run time: {why}{hint}");
        self.log.error(Code::Motion, line, what);
    }
}
