//! Outputs that triggers, pulses and delays set: the run decides when.

use std::collections::HashSet;

use super::instructions::is_synced;
use super::syntax::{Args, Expr, File, Optional, What};
use super::walk::{own_names, statements_in};

/// Instructions that set an output, their first argument.
pub(super) const SETS: [&str; 7] =
    ["set", "reset", "invertdo", "setdo", "setgo", "setao", "pulsedo"];

/// Outputs of which the run decides when they are set.
#[derive(Debug, Default)]
pub(super) struct Timed<'a> {
    names: HashSet<&'a str>,
    /// Any may be one of them.
    is_any: bool,
}

impl<'a> Timed<'a> {
    pub(super) fn of(file: &'a File) -> Self {
        let mut timed = Self { is_any: !file.traps.is_empty(), ..Self::default() };
        for routine in file.procedures.values().chain(file.functions.values()) {
            for what in statements_in([&routine.body, &routine.handlers].into_iter()) {
                let What::Call(name, args) = what else { continue };
                timed.add(&name.key, args);
                // Two names of one output; what sets a datum forgets all.
                if let ("aliasio", [from, Expr::Ref(to)]) =
                    (name.key.as_str(), args.positional.as_slice())
                    && !file.data.contains_key(&to.name.key)
                {
                    match from {
                        Expr::Ref(from) if !own_names(routine).contains(&*from.name.key) => {
                            let both = [from.name.key.as_str(), to.name.key.as_str()];
                            timed.names.extend(both);
                        }
                        // A text, which may name any.
                        _ => timed.is_any = true,
                    }
                }
            }
            // Another name of a signal: it may be any.
            let mut own = routine.parameters.iter().map(|parameter| parameter.name.key.as_str());
            timed.is_any |= own.any(|name| timed.names.contains(name));
        }
        timed.is_any |= timed.names.iter().any(|name| file.data.contains_key(*name));
        timed
    }

    fn add(&mut self, key: &str, args: &'a Args) {
        let is_late = || {
            args.optional.iter().any(|(name, delay)| {
                let is_zero = matches!(delay, Optional::Value(Expr::Number(s, _)) if *s == 0.0);
                name == "sdelay" && !is_zero
            })
        };
        let is_moving = ["movel", "movej", "movec"].iter().any(|start| key.starts_with(start));
        // Of these the data or the procedure say what they set.
        if key.ends_with("ios") || key == "triggspeed" || is_synced(key) {
            self.is_any = true;
        }
        let at = match key {
            "pulsedo" => Some(0),
            "triggrampao" => Some(3),
            _ if SETS.contains(&key) => is_late().then_some(0),
            // Before its value, the last argument.
            _ if is_moving && ["do", "go", "ao"].iter().any(|end| key.ends_with(end)) => {
                args.positional.len().checked_sub(2)
            }
            _ => None,
        };
        let of_data = args.optional.iter().filter_map(|(name, value)| match value {
            Optional::Value(expr) if matches!(name.as_str(), "dop" | "gop" | "aop") => Some(expr),
            _ => None,
        });
        for expr in at.and_then(|at| args.positional.get(at)).into_iter().chain(of_data) {
            if let Expr::Ref(path) = expr {
                self.names.insert(&path.name.key);
            }
        }
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.is_any || self.names.contains(name)
    }
}
