//! Signals: what the cell agrees on beside the language, which of them (or which procedure or
//! comment) sets the speed of the spindle or the number of the tool.

use std::collections::{HashMap, HashSet};

use super::interpreter::Interpreter;
use super::outputs::references;
use super::syntax::{Args, Expr, File, Name, Path, Routine, What};
use super::timed::SETS;
use super::walk::{names_in, statements_in};
use crate::notes::Code;
use crate::program::cell::{Given, Sets, all, set, set_by_name};
use crate::program::{SetBy, Setter, Settings};

/// The signal that an instruction names first.
fn first(args: &Args) -> Option<&Name> {
    match args.positional.first() {
        Some(Expr::Ref(path)) => Some(&path.name),
        _ => None,
    }
}

/// The argument that a call sets something to; `own` is the signal that it names first.
fn value_set<'a>(by: &SetBy, name: &Name, args: &'a Args, own: Option<&Name>) -> Option<&'a Expr> {
    match (&by.what, args.positional.as_slice()) {
        (Setter::Signal(_), [_, value, ..])
            if matches!(name.key.as_str(), "setao" | "setgo" | "setdo")
                && is_of_signal(by, own) =>
        {
            Some(value)
        }
        (Setter::Procedure(procedure, argument), values)
            if name.key == procedure.to_lowercase() =>
        {
            values.get(argument.checked_sub(1)?)
        }
        _ => None,
    }
}

/// Whether an instruction has the signal of the job for its first argument.
fn is_of_signal(by: &SetBy, own: Option<&Name>) -> bool {
    match (&by.what, own) {
        (Setter::Signal(signal), Some(own)) => own.key == signal.to_lowercase(),
        _ => false,
    }
}

/// What `Set` and `Reset` set a signal of the job to.
fn switched(by: &SetBy, name: &Name, own: Option<&Name>) -> Option<f64> {
    let value = match name.key.as_str() {
        "set" => 1.0,
        "reset" => 0.0,
        _ => return None,
    };
    is_of_signal(by, own).then_some(value)
}

/// Names in what the program gives to what sets something.
pub(super) fn given_on<'a>(file: &'a File, settings: &Settings) -> HashSet<&'a str> {
    let mut found = HashSet::new();
    for (_, by) in all(settings) {
        let routines = file.procedures.values().chain(file.functions.values());
        for what in statements_in(routines.map(|routine| &routine.body)) {
            if let What::Call(name, args) = what
                && let Some(value) = value_set(by, name, args, first(args))
            {
                found.extend(names_in(vec![value]).into_iter().map(|name| name.key.as_str()));
            }
        }
    }
    found
}

/// Outputs that procedures of the files, which the job names, set to what they work out, with what
/// they are for and the name of the procedure.
pub(super) fn setter_outputs<'a>(
    file: &'a File,
    settings: &Settings,
) -> HashMap<&'a str, (Sets, &'a str)> {
    let mut found = HashMap::new();
    for (sets, by) in all(settings) {
        let Setter::Procedure(procedure, _) = &by.what else { continue };
        let Some(routine) = file.procedures.get(&procedure.to_lowercase()) else { continue };
        for what in statements_in(std::iter::once(&routine.body)) {
            if let What::Call(name, args) = what
                && SETS.contains(&name.key.as_str())
                && let [Expr::Ref(output), value, ..] = &*args.positional
                && !names_in(vec![value]).is_empty()
            {
                found.insert(output.name.key.as_str(), (sets, routine.name.shown.as_str()));
            }
        }
    }
    found
}

/// Of doubts about what is set.
fn code_of(sets: Sets) -> Code {
    match sets {
        Sets::Spindle => Code::SpindleCommand,
        Sets::Tool => Code::ChangeIgnored,
    }
}

impl<'a> Interpreter<'a> {
    /// An output that is set elsewhere than in the procedure from which the job reads it: a doubt,
    /// but where it is set to 0.
    pub(super) fn doubt_setter_output(&mut self, line: usize, output: &Name, value: Option<f64>) {
        let Some(&(sets, procedure)) = self.setter_outputs.get(output.key.as_str()) else { return };
        if self.in_setters > 0 || value == Some(0.0) {
            return;
        }
        let read = match sets {
            Sets::Spindle => "the spindle's speed",
            Sets::Tool => "the tool",
        };
        let what = format!(
            "'{}' is set here, too, by which '{procedure}' sets {read}: what it is set to \
             here is not read; name the signal in the job instead",
            output.shown
        );
        self.log.sets(line);
        self.log.warning(code_of(sets), line, what);
    }

    /// Whether the call sets something; then it is done.
    pub(super) fn sets(&mut self, line: usize, name: &Name, args: &'a Args) -> bool {
        let settings = self.settings;
        let mut done = false;
        let given = first(args);
        let own = given.map(|given| self.signal_of(given));
        for (sets, by) in all(settings) {
            let (value, switched) = (value_set(by, name, args, own), switched(by, name, own));
            if value.is_none() && switched.is_none() {
                self.doubt_pulse(line, (sets, by), name, own);
                continue;
            }
            done = true;
            self.sets_by_argument(by, given);
            if let (Setter::Signal(signal), true) = (&by.what, self.is_late(args)) {
                let what = format!(
                    "'{signal}' is set with \\SDelay, later than its instruction: the run decides \
                     on which move, and the value is not read"
                );
                self.log.sets(line);
                self.log.warning(code_of(sets), line, what);
                continue;
            }
            self.doubt_beside(code_of(sets), line, &name.shown);
            // A digital output is on or off, and no number in the text can be another.
            let is_digital = name.key == "setdo";
            let span = value.filter(|_| !is_digital).and_then(|value| self.literal(value));
            // A group of outputs takes whole numbers.
            let whole = matches!(name.key.as_str(), "setgo" | "setdo" | "set" | "reset");
            let number = value.map_or(Ok(switched.unwrap_or_default()), |value| {
                let number = self.eval(value).num()?;
                Ok(if is_digital { f64::from(u8::from(number != 0.0)) } else { number })
            });
            let given = Given { value: number, span, whole };
            set(self.log, line, sets, given, by.per_unit);
        }
        done
    }

    /// Of instructions that switch the signal of the job, and of which it is not read to what.
    fn doubt_pulse(
        &mut self,
        line: usize,
        (sets, by): (Sets, &SetBy),
        name: &Name,
        own: Option<&Name>,
    ) {
        if !matches!(name.key.as_str(), "pulsedo" | "invertdo") || !is_of_signal(by, own) {
            return;
        }
        let what = format!(
            "{} switches the signal that the job reads, and to what it does is not read: Set, \
             Reset, SetDO, SetGO and SetAO are",
            name.shown
        );
        self.log.sets(line);
        self.log.warning(code_of(sets), line, what);
    }

    /// A line that asks for the signal of the job, which the program has set, does not set it.
    pub(super) fn asks_for_own(&mut self, args: &Args) {
        if let Some(Expr::Ref(path)) = args.positional.first()
            && self.would_assign(path)
            && self.output(&path.name.key).is_some()
        {
            self.log.sets(self.line);
        }
    }

    /// Whether an output gets its value after a delay that is not known to be zero.
    fn is_late(&mut self, args: &'a Args) -> bool {
        let mut options = self.options(args).into_iter();
        options.any(|(name, delay_s)| name == "sdelay" && delay_s.num() != Ok(0.0))
    }

    /// A tool of the files that is called as a signal of the job is, stands for itself: its move
    /// names nothing that the run would set.
    pub(super) fn names_tool(&mut self, line: usize, tool: &'a Expr, args: &'a Args) {
        let Expr::Ref(path) = tool else { return };
        let key = &path.name.key;
        let is_tool = self.file.data.get(key).is_some_and(|data| data.kind == "tooldata");
        let is_alone = references(args).filter(|name| name == key).count() == 1;
        if is_tool && is_alone && self.would_assign(path) {
            self.log.sets(line);
        }
    }

    /// Whether an assignment sets something; then it is done.
    pub(super) fn assigns_setter(&mut self, line: usize, path: &Path, given: Given) -> bool {
        let Some(sets) = self.set_by_assignment(path) else { return false };
        self.doubt_beside(code_of(sets), line, &path.name.shown);
        set_by_name(self.settings, self.log, line, &path.name.key, given)
    }

    /// Whether an assignment would set something.
    pub(super) fn would_assign(&self, path: &Path) -> bool {
        self.set_by_assignment(path).is_some()
    }

    fn set_by_assignment(&self, path: &Path) -> Option<Sets> {
        let is_it = |by: &SetBy| match &by.what {
            Setter::Signal(own) => own.to_lowercase() == path.name.key,
            _ => false,
        };
        let mut own = all(self.settings).filter(|_| path.steps.is_empty());
        own.find(|(_, by)| is_it(by)).map(|(sets, _)| sets)
    }

    /// Whether a call would set something.
    pub(super) fn would_set(&self, name: &Name, args: &Args) -> bool {
        let own = first(args).map(|given| self.signal_of(given));
        let sets =
            |by| value_set(by, name, args, own).is_some() || switched(by, name, own).is_some();
        all(self.settings).any(|(_, by)| sets(by))
    }

    /// Where the signal of the job is an argument of the routine, the line of the call that gives
    /// it sets something, too.
    fn sets_by_argument(&mut self, by: &SetBy, given: Option<&Name>) {
        let datum = given.and_then(|own| self.frames.last()?.get(&own.key));
        if let Some((signal, line)) = datum.and_then(|datum| datum.signal)
            && is_of_signal(by, Some(signal))
        {
            self.log.sets(line);
        }
    }

    /// Whether a call gives a procedure of the files the signal of the job.
    pub(super) fn gives_signal(&self, routine: &Routine, args: &Args) -> bool {
        let of = |optional| routine.parameters.iter().filter(move |own| own.optional == optional);
        let named = of(true).filter_map(|own| Some((own, args.optional_value(&own.name.key)?)));
        let mut given = of(false).zip(&args.positional).chain(named);
        given.any(|(parameter, given)| {
            parameter.kind.starts_with("signal")
                && matches!(given, Expr::Ref(path) if self.would_assign(path))
        })
    }
}
