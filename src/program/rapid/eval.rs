//! Expressions → values. What cannot be known from the file is [`Value::Unknown`] with the reason,
//! and becomes a fault only where motion depends on it.

use super::constants::{VMAX, predefined, stop_point};
use super::functions::{self, Given};
use super::instructions::{is_calculation, is_own_function};
use super::interpreter::{Datum, Flow, Global, Interpreter, MAX_DEPTH, TOO_DEEP};
use super::number::Number;
use super::operators::binary;
use super::outputs::WHOLE;
use super::own_frame::as_own_frame;
use super::syntax::{Args, Declaration, Expr, Name, Operator, Optional, Path, Step, What};
use super::texts;
use super::undeclared::{fields, no_component, shown_steps, undeclared};
use super::value::{Value, field, initial, initial_array, within_depth, within_size};
use super::walk::{functions_of, statements_in};
use super::why::{COPY, FILE, Why, hint};

/// Where a datum lives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scope {
    Routine,
    Module,
}

/// A datum or a part of one: where it lives, its name there, and the way down.
struct Place<'a> {
    scope: Scope,
    key: &'a str,
    way: Vec<usize>,
    /// Type of the part, or of elements of an array.
    kind: &'a str,
}

impl<'a> Interpreter<'a> {
    pub(super) fn eval(&mut self, expr: &'a Expr) -> Value {
        if self.depth >= MAX_DEPTH {
            return Value::unknown(TOO_DEEP);
        }
        self.depth += 1;
        let value = self.eval_inside(expr);
        self.depth -= 1;
        value
    }

    fn eval_inside(&mut self, expr: &'a Expr) -> Value {
        match expr {
            Expr::Number(number, _) => Value::Num(Number::of(*number)),
            Expr::Text(text) => known(Value::text(text)),
            Expr::Bool(value) => Value::Bool(*value),
            Expr::List(items) => known(self.list(items)),
            Expr::Ref(path) => self.read(path),
            Expr::Call(call) => self.function(&call.0, &call.1),
            Expr::Not(inner) => known(self.eval(inner).bool().map(|value| Value::Bool(!value))),
            Expr::Minus(inner) => match self.eval(inner) {
                Value::List(items) => known(
                    items
                        .iter()
                        .map(|item| item.number().map(|x| Value::Num(x.negated())))
                        .collect::<Result<Vec<_>, _>>()
                        .map(Value::List),
                ),
                value => known(value.number().map(|x| Value::Num(x.negated()))),
            },
            Expr::Binary(operator, left, right) => self.binary(*operator, left, right),
            Expr::TwoWays(ways) => self.either_way(ways),
        }
    }

    fn binary(&mut self, operator: Operator, left: &'a Expr, right: &'a Expr) -> Value {
        let first = self.eval(left);
        // Where the first side may decide alone, the second need not be worked out.
        let is_guard = match operator {
            Operator::And => first.bool() != Ok(true),
            Operator::Or => first.bool() != Ok(false),
            _ => false,
        };
        self.guarded += usize::from(is_guard);
        let second = self.eval(right);
        self.guarded -= usize::from(is_guard);
        let divides = matches!(operator, Operator::Over | Operator::Div | Operator::Mod);
        if divides && second.num() == Ok(0.0) {
            self.stops_at("division by zero", vec![right]);
        }
        let compares = matches!(operator, Operator::Equal | Operator::Unequal);
        let is_no_error =
            || self.is_no_error(&first, left, right) || self.is_no_error(&second, right, left);
        if compares && is_no_error() {
            return Value::Bool(operator == Operator::Unequal);
        }
        known(binary(operator, &first, &second).and_then(functions::finite))
    }

    /// What both ways to read an expression say.
    fn either_way(&mut self, ways: &'a [Expr; 2]) -> Value {
        const OPEN: &str = "NOT stands before AND, and what it is over changes the result: put \
                            parentheses";
        // A function of the program may do something each time that it is called.
        let mut called = functions_of(vec![&ways[0]]).into_iter();
        if called.any(|(name, _)| self.file.functions.contains_key(&name.key)) {
            return Value::unknown(OPEN);
        }
        let [value, other] = ways.each_ref().map(|way| self.eval(way));
        match (&value, &other) {
            (Value::Unknown(_), Value::Unknown(_)) => value,
            _ if value == other => value,
            _ => Value::unknown(OPEN),
        }
    }

    fn list(&mut self, items: &'a [Expr]) -> Result<Value, String> {
        let mut values = Vec::new();
        let mut size = 1;
        for item in items {
            let value = self.eval(item);
            size = within_size(size + value.size())?;
            values.push(value);
        }
        Ok(Value::List(values))
    }

    /// The value of a datum or of a part of it.
    pub(super) fn read(&mut self, path: &'a Path) -> Value {
        let signal = self.signal_of(&path.name);
        if !std::ptr::eq(signal, &path.name) {
            let known = self.output(&signal.key).or_else(|| self.assumed(&signal.key));
            return known.unwrap_or_else(|| Value::Unknown(self.why_undeclared(signal)));
        }
        let Place { scope, key, way, kind } = match self.place(path) {
            Ok(place) => place,
            Err(why) => {
                let known = self.predefined_part(path);
                let known = known.or_else(|| self.output(&path.name.key));
                let known = known.or_else(|| self.assumed(&path.name.key));
                self.doubt_late(&path.name.key, &path.name);
                let own = self.assigned.get(path.name.key.as_str()).cloned();
                let own = own.filter(|_| path.is_whole() && known.is_none());
                if let Some(own) = &own {
                    self.keep_own_value(&path.name, own);
                    self.doubt_undeclared(&path.name, own);
                }
                return match known.or(own) {
                    Some(known) => known,
                    None if self.is_declared(&path.name.key) => Value::Unknown(why),
                    None => self.undeclared_part(path),
                };
            }
        };
        if scope == Scope::Module {
            self.doubt_late(key, &path.name);
        }
        self.heed_end(scope, key, &way, path);
        let mut value = match self.root(scope, key) {
            Some(value) => value,
            None => return Value::unknown(undeclared(&path.name)),
        };
        let mut own;
        for (level, &index) in way.iter().enumerate() {
            if matches!(value, Value::Tool0 | Value::Wobj0) {
                own = value.clone().in_parts(self.own_frames());
                value = &own;
            }
            value = match value {
                Value::List(items) => match items.get(index) {
                    Some(item) => item,
                    None => return Value::unknown(beyond(&path.name)),
                },
                Value::Unknown(why) => {
                    let steps = shown_steps(path, &way).split_off(level);
                    return Value::Unknown(why.part(&steps.concat()));
                }
                _ => return Value::unknown(format!("'{}' has no parts", path.name.shown)),
            };
        }
        let found = match value {
            Value::Num(number) => Value::Num(number.stored(kind == "dnum")),
            value => value.clone(),
        };
        self.keep_own_value(&path.name, &found);
        if scope == Scope::Module {
            self.doubt_trapped(key, &path.name, &found);
        }
        found
    }

    /// Stores a value in a datum or a part of it.
    pub(super) fn write(&mut self, path: &'a Path, value: Value) -> Result<(), String> {
        let place = self.place(path);
        if let Err(why) = &place {
            self.lose_elements(path, why);
        }
        let Place { scope, key, way, .. } = place?;
        if scope == Scope::Module {
            self.doubt_order(key, &path.name);
        }
        self.heed_end(scope, key, &way, path);
        let sizes = self.sizes(scope, key, &way, path);
        let is_anew = way.is_empty() && scope == Scope::Module && self.trapped.contains_key(key);
        let own_frames = self.own_frames();
        let root = match scope {
            Scope::Routine => self
                .frames
                .last_mut()
                .and_then(|frame| frame.get_mut(key))
                .map(|datum| &mut datum.value),
            Scope::Module => {
                self.written.insert(key);
                match self.globals.get_mut(key) {
                    Some(Global::Known(value)) => Some(value),
                    _ => None,
                }
            }
        };
        let root = root.ok_or_else(|| undeclared(&path.name))?;
        let value = known(within_depth(value, way.len()));
        let mut target = &mut *root;
        for (level, index) in way.into_iter().enumerate() {
            if matches!(target, Value::Tool0 | Value::Wobj0) {
                *target = std::mem::replace(target, Value::Absent).in_parts(own_frames);
            }
            if let (Value::Unknown(_), Some(&size)) = (&*target, sizes.get(level)) {
                let rest = target.clone();
                *target = Value::List(vec![rest; size]);
            }
            target = match target {
                Value::List(items) => items.get_mut(index).ok_or_else(|| beyond(&path.name))?,
                Value::Unknown(why) => return Err(why.to_string()),
                _ => return Err(format!("'{}' has no parts", path.name.shown)),
            };
        }
        let grows = value.size() > target.size();
        *target = value;
        if grows && let Err(why) = within_size(root.size()) {
            *root = Value::unknown(why);
        }
        if is_anew {
            self.set_anew.insert(key);
        }
        Ok(())
    }

    /// Of an array of which some element was set, and which one is not known, nothing is known.
    fn lose_elements(&mut self, path: &'a Path, why: &str) {
        let has_index = path.steps.iter().any(|step| matches!(step, Step::Index(_)));
        if has_index && self.is_declared(&path.name.key) {
            let what =
                format!("an element of '{}' was set, which one is not known", path.name.shown);
            self.forget(&path.name, &Value::unknown(format!("{what}: {why}")));
        }
    }

    /// How many parts there are at each level of the way down to a part of what is not known as a
    /// whole: what is not set of it stays unknown. Of what is known, and of a local array, nothing.
    fn sizes(&mut self, scope: Scope, key: &str, way: &[usize], path: &Path) -> Vec<usize> {
        let mut value = self.own_root(scope, key);
        let is_open = way.iter().any(|index| match value {
            Some(Value::List(items)) => {
                value = items.get(*index);
                false
            }
            other => matches!(other, Some(Value::Unknown(_))),
        });
        let shape = match (scope, is_open) {
            (_, false) => return Vec::new(),
            (Scope::Module, _) => self.blank_of_module(key),
            (Scope::Routine, _) => {
                let is_record = matches!(path.steps.first(), Some(Step::Field(_)));
                let datum = self.frames.last().and_then(|frame| frame.get(key));
                datum.filter(|_| is_record).map(|datum| initial(self.file, datum.kind))
            }
        };
        let mut shape = shape.as_ref();
        let sizes = way.iter().map_while(|index| {
            let Some(Value::List(items)) = shape else { return None };
            shape = items.get(*index);
            Some(items.len())
        });
        sizes.collect()
    }

    /// Finds the datum and turns indices and fields into positions, working out globals on the way.
    fn place(&mut self, path: &'a Path) -> Result<Place<'a>, Why> {
        let mut key = path.name.key.as_str();
        let mut way = Vec::new();
        let local = self.frames.last().and_then(|frame| frame.get(key));
        let (scope, mut kind) = match (local, self.file.data.get(key)) {
            (Some(datum), _) => {
                let kind = datum.kind;
                match &datum.stands_for {
                    Some((other, way_there)) => {
                        key = other;
                        way.clone_from(way_there);
                        (Scope::Module, kind)
                    }
                    None => (Scope::Routine, kind),
                }
            }
            (None, Some(declaration)) => {
                self.work_out(declaration)?;
                (Scope::Module, declaration.kind.as_str())
            }
            (None, None) => return Err(undeclared(&path.name).into()),
        };
        for (at, step) in path.steps.iter().enumerate() {
            match step {
                Step::Index(indices) => {
                    for index in indices {
                        way.push(self.index(index, &path.name)?);
                    }
                }
                Step::Field(name) => {
                    let Some((index, inner)) = field(self.file, kind, name) else {
                        let why = no_component(self.file, &path.name, kind, name);
                        let is_elsewhere = scope == Scope::Module && self.is_left_open(key, kind);
                        let rest = fields(path, at).filter(|_| is_elsewhere);
                        let shown = shown_steps(path, &way).concat();
                        return Err(rest.map_or_else(
                            || Why::from(why.clone()),
                            |rest| Why::elsewhere(why.clone(), &format!("{key}{shown}{rest}")),
                        ));
                    };
                    way.push(index);
                    kind = inner;
                }
            }
        }
        Ok(Place { scope, key, way, kind })
    }

    /// The datum of a module, or the part of one, that a routine may set by this argument.
    pub(super) fn of_module(&mut self, path: &'a Path) -> Option<(&'a str, Vec<usize>)> {
        let place = self.place(path).ok().filter(|place| place.scope == Scope::Module)?;
        Some((place.key, place.way))
    }

    /// Data that every controller has, or a part of one.
    pub(super) fn predefined_part(&self, path: &Path) -> Option<Value> {
        let key = path.name.key.as_str();
        let (mut value, mut kind) = predefined(key)?;
        if let Some(own) = self.assigned.get(key).filter(|_| key == VMAX) {
            value = own.clone();
        }
        for step in &path.steps {
            let Step::Field(name) = step else { return None };
            let (index, inner) = field(self.file, kind, name)?;
            let Value::List(mut parts) = value.in_parts(self.own_frames()) else { return None };
            value = (index < parts.len()).then(|| parts.swap_remove(index))?;
            kind = inner;
        }
        Some(value)
    }

    pub(super) fn index(&mut self, index: &'a Expr, of: &Name) -> Result<usize, String> {
        let number = self.eval(index).number().and_then(Number::index);
        // What the index is not known by is not what the datum is not known by.
        let number = number.map_err(|why| format!("index of '{}': {why}", of.shown))?;
        if number < 1.0 && number.fract() == 0.0 {
            self.stops_at(&format!("index {number} of '{}'", of.shown), vec![index]);
        }
        if number >= 1.0 && number <= f64::from(u32::MAX) && number.fract() == 0.0 {
            // In 1..=u32::MAX and whole, checked above.
            Ok(number as usize - 1)
        } else {
            Err(format!(
                "index {number} of '{}' is not a whole number from 1: {COPY}, or start the \
                 program where it is set (path.program.procedure)",
                of.shown
            ))
        }
    }

    fn root(&self, scope: Scope, key: &str) -> Option<&Value> {
        let is_trapped = scope == Scope::Module && !self.is_set_anew(key);
        let trapped = self.trapped.get(key).filter(|_| is_trapped);
        trapped.or_else(|| self.own_root(scope, key))
    }

    /// What the program itself has set a datum to.
    pub(super) fn own_root(&self, scope: Scope, key: &str) -> Option<&Value> {
        match scope {
            Scope::Routine => {
                self.frames.last().and_then(|frame| frame.get(key)).map(|datum| &datum.value)
            }
            Scope::Module => match self.globals.get(key) {
                Some(Global::Known(value)) => Some(value),
                _ => None,
            },
        }
    }

    pub(super) fn work_out(&mut self, declaration: &'a Declaration) -> Result<(), String> {
        let key = declaration.name.key.as_str();
        match self.globals.get(key).unwrap_or(&Global::NotYet) {
            Global::Known(_) => return Ok(()),
            Global::Busy => {
                return Err(format!("'{}' is declared in terms of itself", declaration.name.shown));
            }
            Global::NotYet => {}
        }
        self.globals.insert(key, Global::Busy);
        // A module's data see nothing of the routine that happens to need them first.
        let frames = std::mem::take(&mut self.frames);
        let value = self.initial_value(declaration);
        self.frames = frames;
        self.globals.insert(key, Global::Known(value));
        Ok(())
    }

    /// The value that a declaration gives.
    pub(super) fn initial_value(&mut self, declaration: &'a Declaration) -> Value {
        let value = self.value_of(declaration);
        as_own_frame(declaration, value)
    }

    fn value_of(&mut self, declaration: &'a Declaration) -> Value {
        match (declaration.name.key.as_str(), &declaration.value) {
            (key, _)
                if declaration.is_persistent
                    && self.is_single(key)
                    && self.assumed(key).is_some() =>
            {
                self.assumed(key).unwrap_or(Value::Absent)
            }
            (_, Some(expr)) => {
                let value = self.eval(expr);
                let value = match declaration.kind.as_str() {
                    "stoppointdata" => named_stop_point(value, expr),
                    _ => value,
                };
                known(within_depth(value, 0))
            }
            (key, None) if declaration.is_persistent => {
                let part = self.part_assumed(key);
                let vain = part.map(|part| format!(" ('{part}' has no effect: {WHOLE})"));
                let why = format!(
                    "'{}' is PERS without a value in this file: another task has it; \
                     path.program.files in the job can name the module that gives it one{}",
                    declaration.name.shown,
                    vain.unwrap_or_default()
                );
                Value::Unknown(Why::elsewhere(why, &declaration.name.shown))
            }
            (_, None) => self.blank(declaration),
        }
    }

    /// What a datum holds when nothing was given to it.
    fn blank(&mut self, declaration: &'a Declaration) -> Value {
        let element = initial(self.file, &declaration.kind);
        let sizes: Result<Vec<usize>, String> = declaration
            .dimensions
            .iter()
            .map(|size| self.index(size, &declaration.name).map(|last| last + 1))
            .collect();
        match sizes {
            Ok(sizes) => initial_array(element, &sizes),
            Err(why) => Value::unknown(why),
        }
    }

    /// The same of a module's datum, which sees nothing of the routine that runs.
    fn blank_of_module(&mut self, key: &str) -> Option<Value> {
        let file = self.file;
        let declaration = file.data.get(key)?;
        let frames = std::mem::take(&mut self.frames);
        let blank = self.blank(declaration);
        self.frames = frames;
        Some(blank)
    }

    /// The type of an element, a part or a datum that is no array, and what it holds when nothing
    /// was given to it.
    pub(super) fn blank_of_part(&mut self, path: &'a Path) -> Option<(&'a str, Value)> {
        let kind = self.place(path).ok()?.kind;
        Some((kind, initial(self.file, kind)))
    }

    /// What a parameter of the routine that runs is now.
    pub(super) fn parameter(&self, key: &str) -> Option<Value> {
        let datum = self.frames.last().and_then(|frame| frame.get(key))?;
        let Some((other, way)) = &datum.stands_for else { return Some(datum.value.clone()) };
        let mut value = self.root(Scope::Module, other)?;
        for index in way {
            value = match value {
                Value::List(items) => items.get(*index)?,
                other => other,
            };
        }
        Some(value.clone())
    }

    /// The optional arguments of a call that are there.
    pub(super) fn options(&mut self, args: &'a Args) -> Vec<(String, Value)> {
        let mut options = Vec::new();
        for (name, option) in &args.optional {
            let value = match option {
                Optional::Switch => Value::Bool(true),
                Optional::Value(expr) => self.eval(expr),
                Optional::IfPresent(parameter) => {
                    let datum = self.frames.last().and_then(|frame| frame.get(&parameter.key));
                    let own = datum.and_then(|own| own.stands_for.as_ref());
                    if let Some(key) = own.map(|(key, _)| *key) {
                        self.doubt_late(key, parameter);
                    }
                    let value = self.parameter(&parameter.key);
                    value.unwrap_or_else(|| Value::unknown(undeclared(parameter)))
                }
            };
            if value != Value::Absent {
                options.push((name.clone(), value));
            }
        }
        options
    }

    fn function(&mut self, name: &'a Name, args: &'a Args) -> Value {
        if name.key == "present" {
            return match args.positional.first() {
                Some(Expr::Ref(path)) => Value::Bool(self.read(path) != Value::Absent),
                _ => Value::unknown("Present: expected a parameter"),
            };
        }
        if let Some(routine) = self.file.functions.get(&name.key) {
            return match self.call_routine(routine, args) {
                Flow::Return(Some(value)) => value,
                _ => {
                    let mut all = statements_in(std::iter::once(&routine.body));
                    let may = all.any(|what| matches!(what, What::Return(Some(_))));
                    let why = if may { "is known only at run time" } else { "returns nothing" };
                    Value::unknown(format!("function '{}' {why}", name.shown))
                }
            };
        }
        if let Some(value) = self.signal(&name.key, args) {
            self.asks_for_own(args);
            return value;
        }
        let options = self.options(args);
        if matches!(name.key.as_str(), "crobt" | "cjointt" | "cpos") {
            self.doubt_where(name);
        }
        match name.key.as_str() {
            "crobt" => return known(self.current_target(args, &options)),
            "cjointt" => return known(self.current_joints()),
            "ctool" if !self.active_unknown && self.declared_tool.is_some() => {
                return self.declared_tool.clone().unwrap_or(Value::Absent);
            }
            "cpos" => {
                let target = self.current_target(args, &options);
                return known(target.and_then(|at| at.part(0, "a target").cloned()));
            }
            _ => {}
        }
        let positional: Vec<Value> = args.positional.iter().map(|arg| self.eval(arg)).collect();
        if let Some(what) = functions::undefined(&name.key, &positional) {
            self.stops_at(&format!("{}: {what}", name.shown), args.positional.iter().collect());
        }
        if name.key == "strtoval"
            && let Some(value) = self.value_of_text(args, &positional)
        {
            return value;
        }
        if name.key == "valtostr"
            && let Some(why) = self.why_no_text(args, &positional)
        {
            return Value::unknown(format!("{}: {why}", name.shown));
        }
        let given = Given { positional: &positional, optional: &options };
        let found = texts::call(&name.key, &given);
        match found.or_else(|| functions::call(&name.key, &given)) {
            Some(Ok(value)) => value,
            Some(Err(why)) if name.key == "dim" && self.is_missed(args) => {
                Value::unknown(format!("{}: {why}; {FILE}", name.shown))
            }
            Some(Err(why)) => {
                let help = self.help_of_shift(&name.key, args, &why);
                Value::unknown(format!("{}: {why}{help}", name.shown))
            }
            None => {
                self.fill(name, args);
                if !is_own_function(&name.key) {
                    self.not_in_file(self.line, &name.shown);
                }
                let given = self.assumed(&name.key).filter(|_| !is_calculation(&name.key));
                given.unwrap_or_else(|| {
                    let why = match positional.first() {
                        // The job gives no strings.
                        Some(Value::Unknown(why)) if name.key == "strtoval" => {
                            let is_told = hint(why).is_empty();
                            let help = if is_told { String::new() } else { format!("; {COPY}") };
                            format!("{}: {why}{help}", name.shown)
                        }
                        _ => self.why_unknown(name, args),
                    };
                    match self.gives_jobs(&name.key) {
                        true => Value::Unknown(Why::elsewhere(why, &format!("{}()", name.shown))),
                        false => Value::unknown(why),
                    }
                })
            }
        }
    }

    /// A datum of the routine that runs.
    pub(super) fn declare(&mut self, key: &str, kind: &'a str, value: Value, is_constant: bool) {
        if let Some(frame) = self.frames.last_mut() {
            let datum = Datum { kind, value, stands_for: None, signal: None, is_constant };
            frame.insert(key.to_owned(), datum);
        }
    }
}

fn known(value: Result<Value, String>) -> Value {
    value.unwrap_or_else(Value::unknown)
}

/// `[stoptime,FALSE,…]`: its type may be given by a name, which elsewhere is that of anything.
fn named_stop_point(value: Value, expr: &Expr) -> Value {
    match (value, expr) {
        (Value::List(mut parts), Expr::List(given)) => {
            if let (Some(kind @ Value::Unknown(_)), Some(Expr::Ref(path))) =
                (parts.first_mut(), given.first())
                && let Some(number) = stop_point(&path.name.key)
            {
                *kind = Value::Num(Number::of(number));
            }
            Value::List(parts)
        }
        (value, _) => value,
    }
}

pub(super) fn beyond(name: &Name) -> String {
    format!("an index of '{}' lies beyond its end", name.shown)
}
