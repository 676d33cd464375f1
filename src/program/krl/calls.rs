//! Calls of KRL: routines and functions of the files, the basic package, and what is in no file.

use super::rests::Rests;
use super::run::{Flow, Frame, Run, given};
use super::syntax::{Expr, Path, Routine};
use super::value::{Type, Value, is_position};
use super::walk::{names_in, paths_in};
use super::words::{MAY_SET, fills, is_harmless, sets_motion, sounds_like_motion};
use crate::notes::Code;
use crate::program::cell::{Given, set_by_call};

/// Of an expression that calls a function: it needs more of the stack than a statement.
const DEPTH: usize = 3;

/// What an argument rests on.
type On = Option<Rests>;

impl<'a> Run<'a> {
    pub(super) fn call(&mut self, line: usize, name: &'a str, args: &'a [Option<Expr>]) -> Flow {
        let outer = self.rests_on.clone();
        let (values, on) = self.arguments(args);
        let numbers: Vec<Given> = values.iter().map(given).collect();
        let sets = set_by_call(self.settings, self.log, line, name, &numbers);
        if let Some(routine) = self.file.routine(name) {
            self.doubt_routine(line, name, routine);
            if !sets {
                self.rests_on = outer;
            }
            let outer = self.is_in_spindle;
            self.is_in_spindle |= self.spindles_procedure().is_some_and(|own| own == name);
            let flow = self.run_routine(routine, args, values, on);
            self.is_in_spindle = outer;
            return flow;
        }
        if name == "bas" {
            if let Err(why) = self.bas(line, values) {
                self.log.error(Code::Motion, line, format!("BAS: {why}"));
            }
            return Flow::Next;
        }
        match name {
            "pulse" => self.pulse(args),
            "wait for" => self.waited(args, &values),
            _ => self.fill(name, args),
        }
        if !sets {
            self.doubt_call(line, name, args);
        }
        if sets || is_harmless(name) {
            return Flow::Next;
        }
        if name == "rsi_movecorr" {
            let what = "RSI_MOVECORR is a function of the controller: sensors move the robot \
                        there, by what is known only at run time; leave it out of the file that \
                        is checked";
            self.log.error(Code::Motion, line, what);
            return Flow::Next;
        }
        let is_given_place = values.iter().any(is_position);
        if is_given_place || sounds_like_motion(name) {
            let why = if is_given_place { "is given a position" } else { "moves by its name" };
            let what = format!(
                "'{name}' is in no file that is read and {why}: path.program.files in the job can \
                 name its file"
            );
            self.log.error(Code::Motion, line, what);
        } else {
            self.not_read(line, name, args);
        }
        Flow::Next
    }

    pub(super) fn argument(&mut self, arg: Option<&'a Expr>) -> Value {
        arg.map_or_else(|| Value::unknown("an argument is left out"), |expr| self.eval(expr))
    }

    /// Arguments, and what each rests on: a routine of the files is followed with that.
    pub(super) fn arguments(&mut self, args: &'a [Option<Expr>]) -> (Vec<Value>, Vec<On>) {
        let of = |arg: &'a Option<Expr>| {
            let outer = self.rests_on.take();
            let value = self.argument(arg.as_ref());
            let on = std::mem::replace(&mut self.rests_on, outer);
            self.rests_too(on.clone());
            (value, on)
        };
        args.iter().map(of).unzip()
    }

    pub(super) fn not_read(&mut self, line: usize, name: &'a str, args: &'a [Option<Expr>]) {
        let what = format!(
            "'{name}' is in no file that is read: if it moves, or sets frames or data, that is \
             not read"
        );
        self.log.warning(Code::MotionLeftOut, line, what);
        if self.unmoved.unread.iter().all(|(_, own)| *own != name) {
            self.unmoved.unread.push((line, name));
        }
        let what = format!("'{name}' {MAY_SET}");
        self.forget_signals(&what);
        for arg in args.iter().flatten() {
            if let Expr::Ref(path) = arg {
                self.leave_to_the_run(path, &what);
            }
        }
    }

    /// What CREAD, SREAD and the like fill in.
    pub(super) fn fill(&mut self, name: &str, args: &'a [Option<Expr>]) {
        if !fills(name) {
            return;
        }
        for arg in args {
            if let Some(Expr::Ref(path)) = arg {
                let (shown, by) = (path.name.to_uppercase(), name.to_uppercase());
                // Of structures the job gives no components here.
                let hint = match self.type_of(&path.name) {
                    None | Some(Type::Int | Type::Real) if !path.name.starts_with('$') => format!(
                        "assume: {{\"{shown}\": …}} in the job can give it where {shown} is a \
                         number, not an array or a structure"
                    ),
                    _ => format!(
                        "assume: cannot give it; in the file that is checked set {shown} in place \
                         of {by}"
                    ),
                };
                let what = format!("{by} fills in '{shown}': known only at run time; {hint}");
                if sets_motion(&path.name) {
                    self.log.error(Code::Motion, self.line, what.clone());
                }
                self.leave_to_the_run(path, &what);
            }
        }
    }

    /// Behind WAIT FOR what it waited for holds: where the program itself says otherwise, another
    /// has set it.
    pub(super) fn waited(&mut self, args: &'a [Option<Expr>], values: &[Value]) {
        let Some(value) = values.first() else { return };
        if value.bool() == Ok(false) {
            for path in paths_in(args.iter().flatten().collect()) {
                let shown = path.name.to_uppercase();
                let what = format!("'{shown}' is set by another while WAIT FOR waits");
                self.leave_to_the_run(path, &what);
            }
        }
        self.others_may_set(args, value);
    }

    /// What only the run knows, or the job by what it assumes.
    fn leave_to_the_run(&mut self, path: &'a Path, what: &str) {
        let key = self.key(path).ok().filter(|key| {
            let fields: String = path.fields.iter().map(|field| format!(".{field}")).collect();
            let assume = &self.settings.assume;
            let is_assumed = |name: &String| assume.contains_key(&format!("{name}{fields}"));
            !self.forgotten.contains(key) && self.names(key).iter().any(is_assumed)
        });
        self.forget(path, what);
        if path.indices.is_empty() {
            self.forget_all(&path.name, what);
        }
        if let Some(key) = key {
            let own = format!("{key}.{}", path.fields.join("."));
            self.forgotten.remove(&own);
            self.forgotten.remove(&key);
            self.resting(&key).remove(&key);
        }
    }

    /// `PULSE($OUT[1],TRUE,2.0)`: at its end the output is what it was, or not.
    pub(super) fn pulse(&mut self, args: &'a [Option<Expr>]) {
        match args.first() {
            Some(Some(Expr::Ref(path))) => {
                let what = format!("'{}' is pulsed: known only at run time", path.name);
                self.forget(path, &what);
            }
            _ => self.forget_signals("an output is pulsed: known only at run time"),
        }
    }

    fn run_routine(
        &mut self,
        routine: &'a Routine,
        args: &'a [Option<Expr>],
        values: Vec<Value>,
        on: Vec<On>,
    ) -> Flow {
        let mut frame = Frame::default();
        // By reference: the parameter, the caller's datum, its components.
        let mut references: Vec<(&str, String, &'a [String])> = Vec::new();
        let (mut values, mut all_on) = (values.into_iter(), on.into_iter());
        for (index, parameter) in routine.parameters.iter().enumerate() {
            let name = parameter.name.as_str();
            let missing =
                || Value::unknown(format!("'{}' is called without '{name}'", routine.shown));
            frame.data.insert(name.to_owned(), values.next().unwrap_or_else(missing));
            let on = all_on.next().flatten();
            frame.resting.extend(on.iter().map(|on| (name.to_owned(), on.clone())));
            let Some(Some(Expr::Ref(path))) = args.get(index) else { continue };
            // Which element it sets may be another.
            if !parameter.is_by_value && !names_in(path.indices.iter().collect()).is_empty() {
                self.rests_too(on.clone());
            }
            match self.key(path) {
                Ok(key) => {
                    let elements = self.store(&key).iter().filter_map(|(element, value)| {
                        let indices = element.strip_prefix(&key).filter(|it| it.starts_with('['));
                        indices.map(|indices| (format!("{name}{indices}"), value.clone()))
                    });
                    for (element, value) in elements {
                        frame.resting.extend(on.iter().map(|on| (element.clone(), on.clone())));
                        frame.data.insert(element, value);
                    }
                    if !parameter.is_by_value {
                        // A component that is set of what no file declares does not come back.
                        let fields: String =
                            path.fields.iter().map(|it| format!(".{it}")).collect();
                        self.forget_components(&format!("{key}{fields}"));
                        references.push((name, key, &path.fields));
                    }
                }
                Err(why) if !parameter.is_by_value => {
                    let what = format!("'{}' may set an element: {why}", routine.shown);
                    self.forget_all(&path.name, &what);
                }
                Err(_) => {}
            }
        }
        let before = frame.data.clone();
        self.frames.push(frame);
        let flow = self.body(&routine.body);
        let frame = self.frames.pop().unwrap_or_default();
        let set = frame.data.iter().filter(|(key, value)| before.get(*key) != Some(*value));
        // The caller's name of a parameter or of an element of it.
        let caller = |own: &str, (name, key, fields): &(&str, String, &'a [String])| {
            let indices = own.strip_prefix(*name)?;
            match indices {
                "" => Some((key.clone(), *fields)),
                _ if indices.starts_with('[') => Some((format!("{key}{indices}"), &[][..])),
                _ => None,
            }
        };
        for (own, value) in set {
            for (key, fields) in references.iter().filter_map(|given| caller(own, given)) {
                self.give_back(&routine.shown, key, fields, value.clone());
            }
        }
        for (own, on) in &frame.resting {
            for (key, _) in references.iter().filter_map(|given| caller(own, given)) {
                self.rests(key, on.clone());
            }
        }
        if flow == Flow::Halt { Flow::Halt } else { Flow::Next }
    }

    /// Components that the program has set of a datum are known no longer.
    pub(super) fn forget_components(&mut self, key: &str) {
        self.components.retain(|name, _| {
            let part = name.strip_prefix(key);
            part.is_none_or(|part| !part.starts_with(['.', '[']))
        });
    }

    /// What a routine has set a parameter to, for the datum of the caller.
    fn give_back(&mut self, routine: &str, key: String, fields: &[String], value: Value) {
        let shown = self.names(&key).pop().unwrap_or_default().to_uppercase();
        if sets_motion(&key) {
            let what = format!(
                "'{routine}' sets {shown} through its parameter, which is not read: let it set a \
                 datum, and {shown} to that behind the call"
            );
            self.log.error(Code::Motion, self.line, what);
        }
        self.forget_sharing(&key);
        if self.is_read_by_job(&key) {
            let what = format!(
                "'{routine}' sets {shown} through its parameter: what the job reads from it is \
                 not known"
            );
            self.log.warning(Code::SpindleCommand, self.line, what);
        }
        // What has no components has none to give back.
        drop(self.write_at(key, fields, value));
    }

    /// The value of a call in an expression.
    pub(super) fn run_function(
        &mut self,
        routine: &'a Routine,
        args: &'a [Option<Expr>],
        values: Vec<Value>,
        on: Vec<On>,
    ) -> Value {
        let shown = &routine.shown;
        // An index is worked out more than once.
        if self.indexing > 0 {
            return Value::unknown(format!("'{shown}' is a function within an index: not read"));
        }
        self.depth += DEPTH;
        self.returned = None;
        let flow = self.run_routine(routine, args, values, on);
        self.depth -= DEPTH;
        self.is_halted |= flow == Flow::Halt;
        let Some((value, on)) = self.returned.take() else {
            return Value::unknown(format!("'{shown}' ends without RETURN"));
        };
        self.rests_too(on);
        value.held_as(routine.gives)
    }
}
