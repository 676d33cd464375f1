//! Traps: the run decides when their interrupts come, so that motion in them is left out, as a
//! doubt.

use std::collections::HashSet;

use super::filled::filled;
use super::instructions::{displaces, is_ignored, is_own_function, motion, sounds_like_motion};
use super::interpreter::Interpreter;
use super::syntax::{Args, Block, Expr, Name, Optional, Parameter, Routine, Trap, What};
use super::value::Value;
use super::walk::{blocks_in, functions_in, names_in, statements_in};
use crate::notes::Code;

/// Instructions that traps use and that neither move nor change later motion.
const QUIET: [&str; 12] = [
    "gettrapdata",
    "readerrdata",
    "ierror",
    "ipers",
    "ivarvalue",
    "exit",
    "raise",
    "trynext",
    "retry",
    "mechunitload",
    "confj",
    "confl",
];

impl<'a> Interpreter<'a> {
    pub(super) fn warn_of_traps(&mut self) {
        for trap in &self.file.traps {
            let line = if trap.file.is_none() { trap.line } else { 1 };
            self.doubt_open(line, &[&trap.body]);
            self.keep_open(trap);
            let Some(unread) = self.unread(&trap.body) else { continue };
            let what = format!("a TRAP {unread} when its interrupt comes: this is not read");
            match &trap.file {
                None => self.log.warning(Code::MotionLeftOut, trap.line, what),
                Some(file) => {
                    let what = format!("{file}:{}: {what}", trap.line);
                    self.log.warning(Code::MotionLeftOut, 1, what);
                }
            }
        }
    }

    /// What a trap sets, itself or by what it calls, may have its value at any time.
    fn keep_open(&mut self, trap: &'a Trap) {
        let mut seen: HashSet<&str> = HashSet::new();
        let mut open: Vec<(&'a Block, &'a [Parameter])> = vec![(&trap.body, &[])];
        while let Some((body, parameters)) = open.pop() {
            let statements = || statements_in(std::iter::once(body));
            let own: HashSet<&str> = statements()
                .filter_map(|what| match what {
                    What::Declare(declaration) => Some(&declaration.name),
                    _ => None,
                })
                .chain(parameters.iter().map(|parameter| &parameter.name))
                .map(|name| name.key.as_str())
                .collect();
            for what in statements() {
                let mut set: Vec<&'a Name> = Vec::new();
                match what {
                    What::Assign(path, _) => set.push(&path.name),
                    What::Call(name, args) => {
                        if let Some(routine) = self.file.procedures.get(&name.key) {
                            set.extend(reached(routine, args));
                            if seen.insert(&name.key) {
                                open.push((&routine.body, &routine.parameters));
                            }
                        } else if matches!(name.key.as_str(), "incr" | "decr" | "add" | "clear") {
                            set.extend(names_in(args.positional.iter().take(1).collect()));
                        }
                        set.extend(filled(name, args).into_iter().map(|path| &path.name));
                    }
                    _ => {}
                }
                for (name, args) in functions_in(what) {
                    if let Some(routine) = self.file.functions.get(&name.key) {
                        set.extend(reached(routine, args));
                        if seen.insert(&name.key) {
                            open.push((&routine.body, &routine.parameters));
                        }
                    }
                    set.extend(filled(name, args).into_iter().map(|path| &path.name));
                }
                for name in set.into_iter().filter(|name| !own.contains(name.key.as_str())) {
                    self.trap(name);
                }
            }
        }
    }

    /// A datum of the module that a trap sets.
    fn trap(&mut self, name: &'a Name) {
        let assumed = self.settings.assume.get(&name.key).map(|own| Value::from(*own));
        if assumed.is_some() {
            self.heed(&name.key);
        }
        let value = assumed.unwrap_or_else(|| {
            let what = "a TRAP sets it when its interrupt comes: known only at run time";
            Value::unknown(format!("'{}': {what}", name.shown))
        });
        if !self.file.data.contains_key(&name.key) && matches!(value, Value::Unknown(_)) {
            self.assigned.insert(&name.key, value.clone());
        }
        self.trapped.insert(&name.key, value);
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
            match what {
                What::Call(name, _) => {
                    let key = name.key.as_str();
                    if let Some(routine) = self.file.procedures.get(key) {
                        if seen.insert(key) {
                            bodies.push(&routine.body);
                        }
                    } else if motion(key).is_some() || sounds_like_motion(key) || displaces(key) {
                        return Some("moves the robot".to_owned());
                    } else if matches!(key, "velset" | "speedrefresh" | "gripload") {
                        return Some(format!("changes motion by {}", name.shown));
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

/// What an instruction does that ends the move under way, the path or the program.
fn ends(key: &str) -> Option<&'static str> {
    match key {
        "clearpath" | "stopmovereset" => Some("drops the rest of the path"),
        "exitcycle" => Some("starts the program again"),
        _ => None,
    }
}

/// The data that a call gives to parameters by which they may be set.
fn reached<'a>(routine: &'a Routine, args: &'a Args) -> Vec<&'a Name> {
    let of = |optional: bool| routine.parameters.iter().filter(move |p| p.optional == optional);
    let positional = of(false).zip(&args.positional);
    let named = args.optional.iter().filter_map(|(name, value)| match value {
        Optional::Value(expr) => Some((of(true).find(|own| own.name.key == *name)?, expr)),
        _ => None,
    });
    let both = positional.chain(named).filter(|(parameter, _)| parameter.by_reference);
    both.filter_map(|(_, expr)| match expr {
        Expr::Ref(path) => Some(&path.name),
        _ => None,
    })
    .collect()
}
