//! Outputs that the program sets and asks for: known only where nothing but its own order of
//! instructions sets them.

use super::instructions::{is_calculation, is_own_function};
use super::interpreter::Interpreter;
use super::number::Number;
use super::syntax::{Args, Expr, File, Name, Optional, Statement, What};
use super::timed::SETS;
use super::value::Value;
use super::walk::{blocks_in, own_names};
use super::why::{COPY, FILE};
use crate::notes::Code;
use crate::program::Setter;
use crate::program::cell::all;

/// Functions that read a signal, their argument.
const READ: [&str; 9] = [
    "dinput",
    "doutput",
    "ginput",
    "goutput",
    "ainput",
    "aoutput",
    "testdi",
    "ginputdnum",
    "goutputdnum",
];

/// What the job can assume.
pub(super) const WHOLE: &str =
    "assume gives a number or a truth value by its name, and no element or part of other data";

/// Kinds of signals, as in WaitDI and ISignalDI.
const SIGNALS: [&str; 4] = ["di", "do", "gi", "go"];

fn as_number(value: Value) -> Option<f64> {
    match value {
        Value::Bool(truth) => Some(f64::from(u8::from(truth))),
        other => other.num().ok(),
    }
}

/// The datum of which a key of `assume` names an element or a part.
fn whole_of(key: &str) -> Option<&str> {
    key.split_once(['{', '.']).map(|(whole, _)| whole.trim_end())
}

/// Names that a call is given as they are.
pub(super) fn references(args: &Args) -> impl Iterator<Item = &str> {
    let optional = args.optional.iter().filter_map(|(_, value)| match value {
        Optional::Value(expr) => Some(expr),
        _ => None,
    });
    args.positional.iter().chain(optional).filter_map(|expr| match expr {
        Expr::Ref(path) => Some(path.name.key.as_str()),
        _ => None,
    })
}

/// Where AliasIO stands, and what it names, but for texts and names that are worked out.
fn aliases(file: &File) -> Vec<(usize, Vec<&Name>)> {
    let routines = file.procedures.values().chain(file.functions.values());
    let bodies = routines.flat_map(|own| [(Some(own), &own.body), (Some(own), &own.handlers)]);
    let traps = file.traps.iter().map(|trap| (None, &trap.body));
    let mut found = Vec::new();
    for (routine, body) in bodies.chain(traps) {
        let mut open: Vec<&Statement> = body.iter().collect();
        while let Some(statement) = open.pop() {
            open.extend(blocks_in(&statement.what).into_iter().flatten());
            let What::Call(name, args) = &statement.what else { continue };
            if name.key != "aliasio" {
                continue;
            }
            let own = routine.map(own_names).unwrap_or_default();
            let is_signal = |name: &&Name| {
                let data = file.data.get(&name.key);
                !own.contains(name.key.as_str())
                    && data.is_none_or(|data| data.kind.starts_with("signal"))
            };
            let names = args.positional.iter().filter_map(|expr| match expr {
                Expr::Ref(path) => Some(&path.name),
                _ => None,
            });
            found.push((statement.line.max(1), names.filter(is_signal).collect()));
        }
    }
    found.sort_by_key(|(line, _)| *line);
    found
}

impl<'a> Interpreter<'a> {
    /// Keeps what an output is set to; one that an instruction names otherwise is no longer known.
    pub(super) fn set_output(&mut self, line: usize, key: &str, args: &'a Args) {
        let (true, Some(Expr::Ref(signal))) = (SETS.contains(&key), args.positional.first()) else {
            return self.forget_outputs(key, args);
        };
        let signal = self.signal_of(&signal.name);
        let name = signal.key.as_str();
        let given = args.positional.get(1).map(|expr| self.eval(expr));
        let number = given.as_ref().and_then(|value| value.num().ok());
        self.doubt_setter_output(line, signal, number);
        if key == "setao" {
            self.analog.set(self.settings, self.log, line, name, number);
        }
        // Another name of a signal: it may be any.
        let is_local = self.frames.last().is_some_and(|frame| frame.contains_key(name));
        if is_local || self.file.data.contains_key(name) {
            return self.forget_all_outputs();
        }
        let switched = |is_on: bool| Number::of(f64::from(u8::from(is_on)));
        let value = match key {
            _ if self.timed.has(name) => None,
            "set" => Some(switched(true)),
            "reset" => Some(switched(false)),
            "invertdo" => self.outputs.get(name).map(|own| switched(own.known() == Ok(0.0))),
            _ => given.and_then(|value| match value {
                Value::Bool(is_on) => Some(switched(is_on)),
                other => other.number().ok(),
            }),
        };
        match value {
            Some(value) => drop(self.outputs.insert(name.to_owned(), value)),
            None => self.forget_name(name),
        }
    }

    /// Runs the functions in the arguments of an instruction that is not read itself.
    pub(super) fn run_functions(&mut self, key: &str, args: &'a Args) {
        let optional = args.optional.iter().filter_map(|(_, value)| match value {
            Optional::Value(expr) => Some(expr),
            _ => None,
        });
        // What an output is set to has been worked out.
        let positional = args.positional.iter().enumerate();
        let positional = positional.filter(|(at, _)| *at != 1 || !SETS.contains(&key));
        for expr in positional.map(|(_, expr)| expr).chain(optional) {
            if !matches!(expr, Expr::Ref(_)) {
                self.eval(expr);
            }
        }
    }

    /// `AliasIO do1,do2;`, also in a procedure of an event: a signal has another name, by which the
    /// job does not know it.
    pub(super) fn doubt_aliases(&mut self) {
        let file = self.file;
        let own = all(self.settings).filter_map(|(_, by)| match &by.what {
            Setter::Signal(own) => Some(own.to_lowercase()),
            _ => None,
        });
        let own: Vec<String> = own.collect();
        for (line, names) in aliases(file) {
            let is_open = names.len() < 2;
            let is_named = |key: &String| names.iter().any(|name| name.key == *key);
            let may_be_signal =
                |key: &String| is_open && !file.data.contains_key(key) && !is_own_function(key);
            let mut assumed = self.settings.assume.keys();
            let code = match own.iter().any(|key| is_open || is_named(key)) {
                true => Code::SpindleCommand,
                false if assumed.any(|key| is_named(key) || may_be_signal(key)) => {
                    Code::MotionLeftOut
                }
                false => continue,
            };
            let shown: Vec<&str> = names.iter().map(|name| name.shown.as_str()).collect();
            let of = match is_open {
                true => "one of them worked out or a text: it may be one that the job has,",
                false => "of which the job has one:",
            };
            let what = format!(
                "AliasIO gives a signal two names, '{}', {of} what is done by the other is not \
                 read as done to it; write one name throughout in a copy of the program",
                shown.join("' and '")
            );
            self.log.warning(code, line, what);
        }
    }

    /// What a call names may be set by it, but for a signal that it looks after, or that it waits
    /// for and that is so anyway.
    fn forget_outputs(&mut self, key: &str, args: &'a Args) {
        // It sets neither.
        if key.starts_with("aliasio") {
            return;
        }
        let of = |start: &str| key.strip_prefix(start).is_some_and(|kind| SIGNALS.contains(&kind));
        let kept = match args.positional.as_slice() {
            [Expr::Ref(signal), ..] if of("isignal") => Some(&signal.name.key),
            [Expr::Ref(signal), awaited, ..] if of("wait") => {
                let awaited = as_number(self.eval(awaited));
                let name = &signal.name.key;
                let is = self.output(name).or_else(|| self.assumed(name)).and_then(as_number);
                Some(name).filter(|_| is.is_some() && is == awaited)
            }
            _ => None,
        };
        for name in references(args).filter(|name| kept.is_none_or(|kept| kept != name)) {
            self.forget_name(name);
        }
    }

    /// An output, or a datum that no file declares, is no longer known.
    pub(super) fn forget_name(&mut self, key: &str) {
        let own = self.frames.last().and_then(|frame| frame.get(key));
        let key = own.and_then(|datum| datum.signal).map_or(key, |(signal, _)| &signal.key);
        self.outputs.remove(key);
        self.awaited.remove(key);
        self.forgotten.insert(key.to_owned());
    }

    /// No output that the program has set is known any longer.
    pub(super) fn forget_all_outputs(&mut self) {
        self.forgotten.extend(self.outputs.drain().map(|(key, _)| key));
    }

    /// What the job assumes of a name.
    pub(super) fn assumed(&self, key: &str) -> Option<Value> {
        let own = self.settings.assume.get(key).filter(|_| !self.forgotten.contains(key))?;
        self.heed(key);
        Some(Value::from(*own))
    }

    /// Why what the job assumes of a name counts no longer.
    pub(super) fn why_lost(&self, name: &Name) -> Option<String> {
        let is_lost =
            self.settings.assume.contains_key(&name.key) && self.forgotten.contains(&name.key);
        is_lost.then(|| {
            format!(
                "'{}' is not known here: what the job assumes of it holds until something sets it \
                 or waits for another value; {COPY}",
                name.shown
            )
        })
    }

    /// The job's word of a name counts.
    pub(super) fn heed(&self, key: &str) {
        if !self.heeded.borrow().contains(key) {
            self.heeded.borrow_mut().insert(key.to_owned());
        }
    }

    /// The program has a value of its own for what it asks for.
    pub(super) fn keep_own_value(&mut self, name: &'a Name, value: &Value) {
        let is_known = !matches!(value, Value::Unknown(_) | Value::Absent);
        if is_known && self.settings.assume.contains_key(&name.key) {
            self.own_values.entry(&name.key).or_insert((&name.shown, self.line));
        }
    }

    /// An element or a part of a datum of which the job assumes something: that has no effect.
    pub(super) fn part_assumed(&self, of: &str) -> Option<&'a str> {
        let mut keys = self.settings.assume.keys().map(String::as_str);
        keys.find(|key| whole_of(key).is_some_and(|whole| whole == of))
    }

    /// Tells of what the job assumes in vain.
    pub(super) fn tell_unheeded(&mut self) {
        for part in self.settings.assume.keys() {
            if let Some(data) = whole_of(part).and_then(|whole| self.file.data.get(whole)) {
                let what = format!("the job assumes '{part}', which has no effect: {WHOLE}");
                self.log.warning(Code::Unused, data.line.max(1), what);
            }
        }
        for (key, (shown, line)) in std::mem::take(&mut self.own_values) {
            if !self.heeded.borrow().contains(key) {
                let what = format!(
                    "the job assumes '{shown}', which has no effect on this program: where it asks \
                     it has a value of its own for it (0, FALSE or \"\" if it has set none)"
                );
                self.log.warning(Code::Unused, line, what);
            }
        }
    }

    /// What the program has set an output to.
    pub(super) fn output(&self, key: &str) -> Option<Value> {
        self.outputs.get(key).map(|value| Value::Num(*value))
    }

    /// Why what a function gives is not known, and what may help.
    pub(super) fn why_unknown(&self, function: &Name, args: &Args) -> String {
        if is_calculation(&function.key) {
            return format!("function '{}' is not read: {COPY}", function.shown);
        }
        if let Some(why) = self.why_lost(function) {
            return why;
        }
        let shown = &function.shown;
        if !is_own_function(&function.key) {
            let what = format!("function '{shown}' is in no file that is read: {FILE}");
            return match self.gives_other(&function.key) {
                true => what,
                false => format!(
                    "{what}, or assume: {{\"{shown}\": …}} can give it, the same for each call"
                ),
            };
        }
        let head = format!("function '{shown}' is known only at run time");
        let signal = match args.positional.first() {
            Some(Expr::Ref(signal)) => Some(self.signal_of(&signal.name)),
            _ => None,
        };
        let signal = signal.filter(|_| READ.contains(&function.key.as_str()));
        if let Some(why) = signal.and_then(|signal| self.why_lost(signal)) {
            return format!("{head}: {why}");
        }
        match signal {
            Some(signal) if !self.forgotten.contains(&signal.key) => {
                let name = &signal.shown;
                format!("{head}; assume: {{\"{name}\": …}} in the job can give what {name} is")
            }
            _ if self.gives_other(&function.key) => format!(
                "{head}, and assume gives numbers and truth values alone: {COPY} in place of the \
                 call"
            ),
            _ => format!(
                "{head}; assume: {{\"{shown}\": …}} in the job can give it, the same for each call"
            ),
        }
    }

    /// What the signal that a function reads has been set to, or what the job assumes of it.
    pub(super) fn signal(&self, function: &str, args: &Args) -> Option<Value> {
        let Some(Expr::Ref(signal)) = args.positional.first() else { return None };
        let key = self.signal_of(&signal.name).key.as_str();
        let value = || self.output(key).or_else(|| self.assumed(key));
        let value = READ.contains(&function).then(value)??;
        Some(match (function, value) {
            ("testdi", value @ Value::Num(_)) => Value::Bool(value.num() != Ok(0.0)),
            ("testdi", value) => value,
            (_, Value::Bool(value)) => Value::Num(f64::from(u8::from(value)).into()),
            (_, value) => value,
        })
    }
}
