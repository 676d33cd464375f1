//! Traps: the run decides when their interrupts come, so that motion in them is left out, as a
//! doubt.

use std::collections::HashSet;

use super::constants::VMAX;
use super::instructions::{
    change, displaces, is_ignored, is_own_function, motion, sounds_like_motion,
};
use super::interpreter::Interpreter;
use super::outputs::WHOLE;
use super::sets::{CHANGE, given_to, set_within};
use super::syntax::{
    Args, Block, Declaration, Expr, Name, Path, Routine, Statement, Trap, What, place_of,
};
use super::timed::SETS;
use super::value::Value;
use super::walk::{
    blocks_in, blocks_within, calls_in, functions_in, given, reached_from, statements_in,
};
use super::why::COPY;
use crate::notes::Code;

/// Instructions that traps use and that neither move nor change later motion.
const QUIET: [&str; 10] = [
    "gettrapdata",
    "readerrdata",
    "ierror",
    "ipers",
    "ivarvalue",
    "trynext",
    "retry",
    "mechunitload",
    "confj",
    "confl",
];

/// Instructions that are read elsewhere, and say how the arm moves from then on.
const SET_MOTION: [&str; 5] = ["cirpathmode", "gripload", "setsysdata", "speedrefresh", "velset"];

impl<'a> Interpreter<'a> {
    pub(super) fn warn_of_traps(&mut self) {
        for trap in &self.file.traps {
            let line = trap.line.max(1);
            self.log.within(place_of(trap.there.as_ref()));
            self.doubt_open(line, &[&trap.body]);
            if let Some(unread) = self.unread(&trap.body) {
                let what = format!("a TRAP {unread} when its interrupt comes: this is not read");
                self.log.warning(Code::MotionLeftOut, line, what);
            }
        }
        self.log.within(String::new());
    }

    /// What traps set whose CONNECT, or one of them, the procedure of the job does not lead to:
    /// `main`, the procedure of an event, a handler or a module that is not read may have run it
    /// before.
    pub(super) fn heed_connected_elsewhere(&mut self, entry: &'a Routine) {
        let file = self.file;
        let named =
            |trap: &Trap, args: &Args| trap_of(args) == Some(trap.name.shown.to_lowercase());
        let mut blocks = vec![&entry.body];
        let mut known: Vec<&'a Trap> = Vec::new();
        let reached: Vec<&'a Args> = loop {
            let calls = calls_in(file, &blocks).into_iter();
            let reached = calls.filter(|(name, _)| name.key == "connect").map(|(_, args)| args);
            let reached: Vec<&'a Args> = reached.collect();
            let is_new = |trap: &&'a Trap| {
                let is_known = known.iter().any(|own| std::ptr::eq(*own, *trap));
                !is_known && reached.iter().any(|args| named(trap, args))
            };
            let new: Vec<&'a Trap> = file.traps.iter().filter(is_new).collect();
            if new.is_empty() {
                break reached;
            }
            blocks.extend(new.iter().map(|trap| &trap.body));
            known.extend(new);
        };
        let routines = || file.procedures.values().chain(file.functions.values());
        let elsewhere: Vec<&'a Args> = statements_in(routines().map(|own| &own.body))
            .filter_map(|what| match what {
                What::Call(name, args) if name.key == "connect" => Some(args),
                _ => None,
            })
            .filter(|args| !reached.iter().any(|own| std::ptr::eq(*own, *args)))
            .collect();
        let in_handlers = |trap: &Trap| {
            let key = trap.name.shown.to_lowercase();
            let mut words = routines().map(|own| &own.in_handlers);
            words.any(|words| words.contains("connect") && words.contains(&key))
        };
        for trap in &file.traps {
            let is_sure = known.iter().any(|own| std::ptr::eq(*own, trap))
                && !elsewhere.iter().any(|args| named(trap, args))
                && !in_handlers(trap);
            if !is_sure {
                let set = set_within(file, &trap.body).into_iter();
                self.elsewhere.extend(set.map(|name| name.key.as_str()));
            }
        }
    }

    /// `CONNECT i1 WITH tr;`: from here on the trap may run.
    pub(super) fn connect(&mut self, line: usize, args: &'a Args) {
        let Some(Expr::Text(shown)) = args.positional.first() else { return };
        let (file, key) = (self.file, shown.to_lowercase());
        let is_it = |own: &&'a Trap| own.name.shown.to_lowercase() == key;
        let traps: Vec<&'a Trap> = file.traps.iter().filter(is_it).collect();
        if traps.is_empty() {
            self.not_in_file(line, shown);
        }
        let interrupt = self.interrupt(args.optional_value("interrupt"));
        for trap in traps {
            self.keep_open(trap);
            let is_new =
                |(own, of): &(Option<&str>, &Trap)| *own != interrupt || !std::ptr::eq(*of, trap);
            if self.connected.iter().all(is_new) {
                self.connected.push((interrupt, trap));
                self.connect_within(trap);
            }
        }
    }

    /// `IDelete i1;`: what the trap has set keeps the value that it has, which is not known.
    pub(super) fn disconnect(&mut self, args: &'a Args) {
        let interrupt = self.interrupt(args.positional.first());
        let all = std::mem::take(&mut self.connected).into_iter();
        let (gone, left): (Vec<_>, Vec<_>) =
            all.partition(|(own, _)| own.is_some() && *own == interrupt);
        for (_, trap) in &gone {
            for name in set_within(self.file, &trap.body) {
                if self.set_beside.contains(name.key.as_str()) {
                    continue;
                }
                if let Some(value) = self.trapped.remove(name.key.as_str()) {
                    self.forget(name, &value);
                }
            }
        }
        // What others set, too, and what they may connect again.
        self.connected = left.clone();
        for (_, trap) in left {
            self.keep_open(trap);
            self.connect_within(trap);
        }
    }

    /// Traps that a trap connects may run from then on, too.
    fn connect_within(&mut self, trap: &'a Trap) {
        for (name, args) in calls_in(self.file, &[&trap.body]) {
            if name.key == "connect" {
                self.connect(self.line, args);
            }
        }
    }

    /// The name of an interrupt, where no other has it.
    fn interrupt(&self, expr: Option<&'a Expr>) -> Option<&'a str> {
        let Some(Expr::Ref(path)) = expr else { return None };
        let key = path.name.key.as_str();
        let is_local = self.frames.last().is_some_and(|frame| frame.contains_key(key));
        let is_its = path.is_whole() && !is_local && self.file.data.contains_key(key);
        is_its.then_some(key)
    }

    /// What a trap sets, itself or by what it calls, may have its value at any time.
    fn keep_open(&mut self, trap: &'a Trap) {
        for name in set_within(self.file, &trap.body) {
            self.set_at_any_time(name, "a TRAP sets it when its interrupt comes");
        }
    }

    /// The program itself has set the datum, and nothing takes time in between, or it leads to no
    /// CONNECT of the trap; but the interrupt may come.
    pub(super) fn doubt_trapped(&mut self, key: &str, name: &Name, value: &Value) {
        if matches!(value, Value::Unknown(_)) || !self.of_motion().contains(key) {
            return;
        }
        let shown = &name.shown;
        let what = if self.is_set_anew(key) && self.set_beside.contains(key) {
            format!(
                "another task sets '{shown}', too: the value that the program itself has set \
                 before is taken"
            )
        } else if self.is_set_anew(key) {
            format!(
                "a TRAP sets '{shown}' when its interrupt comes: the value that the program itself \
                 has set before is taken"
            )
        } else if self.elsewhere.contains(key) {
            format!(
                "a TRAP sets '{shown}', and the procedure of the job does not lead to its CONNECT: \
                 the program's own value is taken"
            )
        } else {
            return;
        };
        self.log.warning(Code::MotionLeftOut, self.line, what);
    }

    /// Whether the program itself has just set what a trap sets.
    pub(super) fn is_set_anew(&self, key: &str) -> bool {
        matches!(self.trapped.get(key), Some(Value::Unknown(_))) && self.set_anew.contains(key)
    }

    /// Behind a statement that may take time the value that a trap sets is not known any longer.
    pub(super) fn pass_time(&mut self, key: &str) {
        const AT_ONCE: [&str; 5] = ["confj", "confl", "setsysdata", "tperase", "tpwrite"];
        let is_quick = CHANGE.contains(&key) || SETS.contains(&key) || AT_ONCE.contains(&key);
        if !self.set_anew.is_empty() && !is_quick && !self.file.procedures.contains_key(key) {
            self.set_anew.clear();
        }
    }

    /// A datum of the module that a trap or another task sets; `by` says which.
    pub(super) fn set_at_any_time(&mut self, name: &'a Name, by: &str) {
        let value = self.said_by_job(&name.key).unwrap_or_else(|| {
            // For a tool or a work object the job's own stands.
            let is_frame = |own: &Declaration| matches!(&*own.kind, "tooldata" | "wobjdata");
            let is_told =
                self.is_single(&name.key) || self.file.data.get(&name.key).is_some_and(is_frame);
            let help = match is_told {
                true => String::new(),
                false => format!("; {WHOLE}: {COPY}"),
            };
            Value::unknown(format!("'{}': {by}: known only at run time{help}", name.shown))
        });
        // What the program has set it to before holds no longer, either.
        let is_open = matches!(value, Value::Unknown(_));
        let is_kept = is_open || self.assigned.contains_key(name.key.as_str());
        if is_kept && !self.file.data.contains_key(&name.key) {
            self.assigned.insert(&name.key, value.clone());
        }
        self.set_anew.remove(name.key.as_str());
        self.trapped.insert(&name.key, value);
    }

    /// What a statement, its blocks and what it calls aside, sets that counts for the moves behind.
    fn sets_for_later(&self, what: &What) -> Option<String> {
        let is_speed = |path: &Path| path.name.key == VMAX && !self.file.data.contains_key(VMAX);
        match what {
            What::Assign(path, _) => {
                let sets = is_speed(path) || self.would_assign(path);
                sets.then(|| format!("sets '{}'", path.name.shown))
            }
            What::Call(name, args) => {
                let key = name.key.as_str();
                let own = self.file.procedures.get(key);
                let is_job_signal = || match args.positional.first() {
                    Some(Expr::Ref(path)) => SETS.contains(&key) && self.would_assign(path),
                    _ => false,
                };
                let gives_speed = |own: &Routine| {
                    let mut given = given_to(own, args).into_iter();
                    given.any(|(parameter, path)| parameter.by_reference && is_speed(path))
                };
                let changes_motion = match own {
                    Some(own) => gives_speed(own),
                    None => {
                        let begins = change(name, args).is_some_and(|(_, begins)| begins);
                        SET_MOTION.contains(&key) || begins || displaces(key)
                    }
                };
                if changes_motion {
                    return Some(format!("changes motion by {}", name.shown));
                }
                let sets = self.would_set(name, args)
                    || is_job_signal()
                    || own.is_some_and(|own| self.gives_signal(own, args));
                sets.then(|| format!("sets the spindle or the tool by {}", name.shown))
            }
            _ => None,
        }
    }

    /// Of handlers of errors that set what counts for the moves behind, where the program may go on
    /// behind them.
    pub(super) fn doubt_handlers(&mut self, entry: &'a Routine) {
        let file = self.file;
        let reached = reached_from(file, vec![&entry.name.key]);
        let may_run = |own: &&'a Routine| {
            reached.as_ref().is_none_or(|reached| reached.contains(own.name.key.as_str()))
        };
        let procedures = file.procedures.values().filter(may_run);
        let mut routines: Vec<&'a Routine> = procedures.chain(file.functions.values()).collect();
        routines.retain(|own| own.in_handlers.contains("error"));
        routines.sort_by_key(|own| (own.line, &own.name.key));
        let some_go_on = routines.iter().any(|own| goes_on(&own.handlers));
        for routine in routines {
            // An error that it raises is handled elsewhere.
            let raises = || {
                statements_in(std::iter::once(&routine.handlers))
                    .any(|what| calls(what, &["raise", "errraise"]))
            };
            if !(goes_on(&routine.handlers) || some_go_on && raises()) {
                continue;
            }
            let blocks = blocks_within(file, &[&routine.handlers]);
            let all: Vec<&'a What> = statements_in(blocks.into_iter()).collect();
            self.budget = self.budget.saturating_sub(all.len());
            // A signal that it is given may be that of the job.
            let is_given = |path: &Path| {
                let mut own = routine.parameters.iter();
                own.any(|own| own.kind.starts_with("signal") && own.name.key == path.name.key)
            };
            let sets_given = |what: &&'a What| match *what {
                What::Call(name, args) => {
                    let key = name.key.as_str();
                    let may_set = SETS.contains(&key) || file.procedures.contains_key(key);
                    may_set && given(args).any(is_given)
                }
                _ => false,
            };
            let reads = self.settings.spindle_from.is_some() || self.settings.tool_from.is_some();
            let sets = all.iter().find_map(|what| self.sets_for_later(what)).or_else(|| {
                let sets = reads && all.iter().any(sets_given);
                sets.then(|| "sets a signal that it is given".to_owned())
            });
            if let Some(sets) = sets {
                let what = format!(
                    "a handler of errors in '{}' {sets} and the program goes on: this is not read",
                    routine.name.shown
                );
                self.log.warning(Code::MotionLeftOut, routine.line.max(1), what);
            }
        }
    }

    /// What of a block and all that it calls moves, or changes how the robot moves.
    fn unread(&self, body: &'a Block) -> Option<String> {
        let mut seen: HashSet<&str> = HashSet::new();
        let mut open: Vec<&'a What> = body.iter().map(|statement| &statement.what).collect();
        // What is stopped or put aside, and not taken up again.
        let mut called: HashSet<&str> = HashSet::new();
        while let Some(what) = open.pop() {
            let mut bodies = blocks_in(what);
            let not_read =
                |shown| Some(format!("calls '{shown}', which is in no file that is read,"));
            for (name, _) in functions_in(what) {
                match self.file.functions.get(&name.key) {
                    Some(routine) if seen.insert(&name.key) => bodies.push(&routine.body),
                    None if !is_own_function(&name.key) => return not_read(&name.shown),
                    _ => {}
                }
            }
            if let Some(sets) = self.sets_for_later(what) {
                return Some(sets);
            }
            match what {
                What::Call(name, _) => {
                    let key = name.key.as_str();
                    if let Some(routine) = self.file.procedures.get(key) {
                        if seen.insert(key) {
                            bodies.push(&routine.body);
                        }
                    } else if motion(key).is_some() || sounds_like_motion(key) {
                        return Some("moves the robot".to_owned());
                    } else if let Some(ends) = ends(key) {
                        return Some(format!("{ends} by {}", name.shown));
                    } else if !is_ignored(key) && !QUIET.contains(&key) {
                        return not_read(&name.shown);
                    }
                    called.insert(key);
                }
                What::NotUnderstood(_) => return Some("does what is not understood".to_owned()),
                _ => {}
            }
            open.extend(bodies.into_iter().flatten().map(|statement| &statement.what));
        }
        let is_left = |from: &str, to: &str| called.contains(from) && !called.contains(to);
        if is_left("stopmove", "startmove") {
            return Some("stops the arm by StopMove".to_owned());
        }
        is_left("storepath", "restopath").then(|| "puts the path aside by StorePath".to_owned())
    }
}

pub(super) fn calls(what: &What, wanted: &[&str]) -> bool {
    matches!(what, What::Call(name, _) if wanted.contains(&name.key.as_str()))
}

/// Whether the program may go on behind a handler of errors: unless it ends or raises in any case.
pub(super) fn goes_on(handler: &Block) -> bool {
    let leaves = |what: &What| {
        matches!(what, What::Return(_) | What::Goto(_)) || calls(what, &["retry", "trynext"])
    };
    let ends = |own: &Statement| calls(&own.what, &["exit", "exitcycle", "raise", "errraise"]);
    !handler.iter().any(ends) || statements_in(std::iter::once(handler)).any(leaves)
}

/// What an instruction does that ends the move under way, the path or the program.
fn ends(key: &str) -> Option<&'static str> {
    match key {
        "clearpath" | "stopmovereset" => Some("drops the rest of the path"),
        "exitcycle" => Some("starts the program again"),
        "exit" => Some("ends the program"),
        "raise" | "errraise" => Some("leaves the move under way with an error"),
        _ => None,
    }
}

/// The trap of a CONNECT, in lower case.
fn trap_of(args: &Args) -> Option<String> {
    match args.positional.first() {
        Some(Expr::Text(shown)) => Some(shown.to_lowercase()),
        _ => None,
    }
}
