//! What blocks would change if they ran, where only the run knows whether they do.

use std::collections::HashSet;

use super::filled::filled;
use super::instructions::{change, is_ignored, is_own_function};
use super::interpreter::{Interpreter, MAX_DEPTH};
use super::modules::LOADS;
use super::sets::CHANGE;
use super::syntax::{Args, Block, Expr, Name, Path, Routine, Statement, What};
use super::walk::{blocks_in, functions_in, names_in};

/// The instruction that says what the gripper holds.
pub(super) const GRIP: &str = "gripload";

/// The instruction that says how the tool turns on arcs.
pub(super) const CIR_PATH_MODE: &str = "cirpathmode";

/// Instructions that stand for what they set: no datum has their names.
pub(super) const STAND_FOR: [&str; 2] = [GRIP, CIR_PATH_MODE];

/// What a block would change if it ran.
pub(super) enum Effect<'a> {
    /// Data alone.
    Data(Vec<&'a Name>),
    /// Motion, or which statements run.
    Motion,
}

/// Of several together.
impl<'a> FromIterator<Effect<'a>> for Effect<'a> {
    fn from_iter<I: IntoIterator<Item = Effect<'a>>>(effects: I) -> Self {
        let mut names = Vec::new();
        for effect in effects {
            match effect {
                Effect::Motion => return Effect::Motion,
                Effect::Data(more) => names.extend(more),
            }
        }
        Effect::Data(names)
    }
}

fn names_of(paths: Vec<&Path>) -> Vec<&Name> {
    paths.into_iter().map(|path| &path.name).collect()
}

impl<'a> Interpreter<'a> {
    /// Whether nothing in the block of a routine moves, or may.
    pub(super) fn is_still(&self, block: &'a Block) -> bool {
        matches!(self.effect(block, true, &mut HashSet::new()), Effect::Data(_))
    }

    /// `is_called`: of a routine, which RETURN ends alone; `seen`: routines counted already.
    pub(super) fn effect(
        &self,
        block: &'a Block,
        is_called: bool,
        seen: &mut HashSet<&'a str>,
    ) -> Effect<'a> {
        let effect = |statement: &'a Statement| {
            let what = &statement.what;
            let asked = self.effect_of_functions(functions_in(what), seen);
            let own = match what {
                What::Assign(path, _) if self.would_assign(path) => Effect::Motion,
                What::Assign(path, _) => Effect::Data(vec![&path.name]),
                What::Call(name, args) => self.effect_of_call(name, args, seen),
                What::Return(_) if is_called => Effect::Data(Vec::new()),
                // Which one it calls only the run may know.
                What::CallByName(..) => Effect::Motion,
                What::Return(_) | What::Goto(_) | What::NotUnderstood(_) => Effect::Motion,
                _ => Effect::Data(Vec::new()),
            };
            let blocks = blocks_in(what).into_iter();
            let inside = blocks.map(|body| self.effect(body, is_called, seen)).collect();
            [asked, own, inside].into_iter().collect()
        };
        block.iter().map(effect).collect()
    }

    /// Of one that is in no file it is not known.
    pub(super) fn effect_of_functions(
        &self,
        functions: Vec<&'a (Name, Args)>,
        seen: &mut HashSet<&'a str>,
    ) -> Effect<'a> {
        let effect = |(name, args): &'a (Name, Args)| match self.file.functions.get(&name.key) {
            Some(routine) => self.effect_of_routine(routine, &name.key, seen),
            None if is_own_function(&name.key) => Effect::Data(names_of(filled(name, args))),
            None => Effect::Motion,
        };
        functions.into_iter().map(effect).collect()
    }

    fn effect_of_routine(
        &self,
        routine: &'a Routine,
        key: &'a str,
        seen: &mut HashSet<&'a str>,
    ) -> Effect<'a> {
        if !seen.insert(key) {
            return Effect::Data(Vec::new());
        }
        // A deep chain of calls is taken to move rather than followed on a small stack.
        if seen.len() > MAX_DEPTH {
            return Effect::Motion;
        }
        self.effect(&routine.body, true, seen)
    }

    fn effect_of_call(
        &self,
        name: &'a Name,
        args: &'a Args,
        seen: &mut HashSet<&'a str>,
    ) -> Effect<'a> {
        let references = args.positional.iter().filter_map(|arg| match arg {
            Expr::Ref(path) => Some(&path.name),
            _ => None,
        });
        if self.would_set(name, args) {
            return Effect::Motion;
        }
        if let Some(routine) = self.file.procedures.get(&name.key) {
            if self.gives_signal(routine, args) {
                return Effect::Motion;
            }
            return match self.effect_of_routine(routine, &name.key, seen) {
                Effect::Data(names) => Effect::Data(names.into_iter().chain(references).collect()),
                Effect::Motion => Effect::Motion,
            };
        }
        match name.key.as_str() {
            key if CHANGE.contains(&key) => Effect::Data(references.collect()),
            key if STAND_FOR.contains(&key) => Effect::Data(vec![name]),
            "mechunitload" | "confj" | "confl" | "setsysdata" => Effect::Data(Vec::new()),
            "waituntil" => {
                let waited = names_in(args.positional.iter().collect());
                Effect::Data(waited.into_iter().chain(names_of(filled(name, args))).collect())
            }
            // These use what they are given.
            _ if change(name, args).is_some() => Effect::Data(names_of(filled(name, args))),
            key if LOADS.contains(&key) => Effect::Data(references.chain([name]).collect()),
            key if is_ignored(key) => {
                Effect::Data(references.chain(names_of(filled(name, args))).collect())
            }
            _ => Effect::Motion,
        }
    }
}
