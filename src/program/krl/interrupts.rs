//! Interrupts and triggers of KRL: the run decides when they come. What they move is not read, so
//! that it is a doubt; what they set is not known afterwards.

use std::collections::HashSet;

use super::run::Run;
use super::syntax::{Block, Expr, Path, What};
use super::words::{is_harmless, is_without_effect, sets_motion};
use crate::notes::Code;

/// What an interrupt or a trigger does that is not read.
struct Unread<'a> {
    /// With motion, or with what motion depends on.
    motion: Option<String>,
    sets: Vec<&'a Path>,
}

impl<'a> Run<'a> {
    pub(super) fn declare_interrupt(&mut self, number: &'a Expr, action: Option<&'a What>) {
        // One of which the number is not known may be any.
        let number = self.eval(number).num().map(|number| number.to_string()).unwrap_or_default();
        self.interrupts.insert(number, action);
    }

    pub(super) fn interrupt_on(&mut self, line: usize, number: Option<&'a Expr>) {
        let number = number.and_then(|expr| self.eval(expr).num().ok()).map(|n| n.to_string());
        if let Some(number) = &number
            && !["", number].iter().any(|key| self.interrupts.contains_key(*key))
        {
            let what = format!(
                "INTERRUPT ON {number}: it is declared in no file that is read; if it moves, its \
                 motion is not read"
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        let is_on = |key: &str| key.is_empty() || number.as_deref().is_none_or(|own| own == key);
        let on = self.interrupts.iter().filter(|(key, _)| is_on(key));
        let actions: Vec<_> = on.map(|(_, action)| *action).collect();
        for action in actions {
            self.leave_out(line, "an interrupt", action);
        }
    }

    pub(super) fn trigger(&mut self, line: usize, action: Option<&'a What>) {
        self.leave_out(line, "a TRIGGER", action);
    }

    fn leave_out(&mut self, line: usize, by: &str, action: Option<&'a What>) {
        let unread = match action {
            Some(what) => self.unread(what),
            None => {
                let motion = Some("does what is not understood".to_owned());
                Unread { motion, sets: Vec::new() }
            }
        };
        if let Some(motion) = unread.motion {
            let what = format!("{by} {motion} when it comes: this is not read");
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        for path in unread.sets {
            let what = format!("'{}' is set by {by}: known only at run time", path.name);
            self.forget(path, &what);
        }
    }

    /// What a statement and all that it calls would do.
    fn unread(&self, what: &'a What) -> Unread<'a> {
        let mut found = Unread { motion: None, sets: Vec::new() };
        let mut seen = HashSet::new();
        let mut open = vec![what];
        while let Some(what) = open.pop() {
            let mut bodies: Vec<&'a Block> = Vec::new();
            for name in self.functions_in(what) {
                if seen.insert(name) {
                    bodies.extend(self.file.functions.get(name).map(|routine| &routine.body));
                }
            }
            let motion = match what {
                What::Move(_) | What::Spline(..) => Some("moves the robot".to_owned()),
                What::Assign(path, _) if sets_motion(&path.name) => {
                    Some(format!("sets {}", path.name.to_uppercase()))
                }
                What::Assign(path, _) => {
                    if !path.name.starts_with('$') && !is_without_effect(&path.name) {
                        found.sets.push(path);
                    }
                    None
                }
                What::Call(name, _) => match self.file.routines.get(name) {
                    Some(routine) => {
                        if seen.insert(name) {
                            bodies.push(&routine.body);
                        }
                        None
                    }
                    None if self.file.functions.contains_key(name) => {
                        if seen.insert(name) {
                            bodies.extend(self.file.functions.get(name).map(|it| &it.body));
                        }
                        None
                    }
                    None if is_harmless(name) => None,
                    None => Some(format!("calls '{name}', which is in no file that is read,")),
                },
                What::NotUnderstood(_) | What::Trigger(None) => {
                    Some("does what is not understood".to_owned())
                }
                What::Trigger(Some(action)) => {
                    open.push(action);
                    None
                }
                What::If(_, yes, no) => {
                    bodies.extend([yes, no]);
                    None
                }
                What::For(.., body)
                | What::While(_, body)
                | What::Repeat(body, _)
                | What::Loop(body) => {
                    bodies.push(body);
                    None
                }
                What::Switch(_, cases, otherwise) => {
                    bodies.extend(cases.iter().map(|(_, body)| body).chain([otherwise]));
                    None
                }
                _ => None,
            };
            found.motion = found.motion.or(motion);
            open.extend(bodies.into_iter().flatten().map(|statement| &statement.what));
        }
        found
    }

    /// Functions of the files that the expressions of a statement call, its blocks aside.
    pub(super) fn functions_in(&self, what: &'a What) -> impl Iterator<Item = &'a str> {
        let mut open = expressions(what);
        std::iter::from_fn(move || {
            while let Some(expr) = open.pop() {
                match expr {
                    Expr::Parts(parts) => open.extend(parts.iter().map(|(_, expr)| expr)),
                    Expr::Ref(path) => open.extend(&path.indices),
                    Expr::Not(inner) | Expr::Minus(inner) => open.push(inner),
                    Expr::Binary(_, left, right) => open.extend([&**left, &**right]),
                    Expr::Call(name, args) => {
                        open.extend(args.iter().flatten());
                        if self.file.functions.contains_key(name) {
                            return Some(name.as_str());
                        }
                    }
                    _ => {}
                }
            }
            None
        })
    }
}

fn expressions(what: &What) -> Vec<&Expr> {
    match what {
        What::Declare(.., Some(expr))
        | What::Return(Some(expr))
        | What::WaitSec(expr)
        | What::If(expr, ..)
        | What::While(expr, _)
        | What::Repeat(_, expr)
        | What::Switch(expr, ..) => vec![expr],
        What::Assign(path, expr) => path.indices.iter().chain([expr]).collect(),
        What::Call(_, args) => args.iter().flatten().collect(),
        What::For(_, [from, to], step, _) => [from, to].into_iter().chain(step).collect(),
        What::Move(motion) => {
            let own = motion.targets.iter().chain(&motion.angle);
            own.chain(motion.with.iter().map(|(_, expr)| expr)).collect()
        }
        What::Spline(given, _) => given.iter().map(|(_, expr)| expr).collect(),
        _ => Vec::new(),
    }
}
