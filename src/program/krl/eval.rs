//! Expressions of KRL → values. What cannot be known from the files is [`Value::Unknown`] with the
//! reason, and becomes a fault only where motion depends on it.

use std::collections::HashMap;

use nalgebra::Isometry3;

use super::operators::binary;
use super::run::{Beside, Run};
use super::signals::named_by;
use super::syntax::{Expr, Path};
use super::value::{AXES, FRAME, Parts, Sort, Type, Value, base, frame, of_frame, unset};
use super::walk::{all_of, names_in};
use super::words::{BEHIND_MOVE, ON_KINEMATIC, is_own_function};
use crate::notes::Code;
use crate::program::cell::{base_frame, tool_frame};
use crate::program::{Assumed, Settings};
use crate::units::{deg_from_rad, rad_from_deg};

/// Lists of signals that the program sets and asks for.
const SIGNALS: [&str; 4] = ["$out", "$anout", "$flag", "$cycflag"];

/// What changes while the program does something else.
const RUNNING: [&str; 2] = ["$timer", "$cycflag"];

/// What changes with every move.
const POSITIONS: [&str; 6] =
    ["$pos_act", "$pos_ret", "$pos_int", "$pos_act_meas", "$axis_act", "$axis_act_meas"];

/// Of the axes before the first move: a move to them goes nowhere.
pub(super) const AXES_AT_START: &str =
    "where the axes are before the first move is known only at run time";

impl<'a> Run<'a> {
    pub(super) fn eval(&mut self, expr: &'a Expr) -> Value {
        match expr {
            Expr::Number(value, span, sort) => Value::Num(*value, *span, *sort),
            Expr::Bool(value) => Value::Bool(*value),
            Expr::Text(text) => Value::Text(text.clone()),
            Expr::Enum(name) => Value::Enum(name.clone()),
            Expr::Parts(parts) => {
                let parts = parts.iter().map(|(name, expr)| {
                    let value = self.eval(expr);
                    (name.clone(), self.held_in(value, name))
                });
                Value::Parts(parts.collect())
            }
            Expr::Ref(path) => self.read(path),
            Expr::Call(name, args) => self.function(name, args),
            Expr::Not(inner) => known(self.eval(inner).bool().map(|value| Value::Bool(!value))),
            Expr::Minus(inner) => match self.eval(inner) {
                // The sign belongs to the number in the text.
                Value::Num(value, _, sort) => Value::Num(-value, None, sort),
                other => known(other.num().map(Value::real)),
            },
            Expr::Binary(operator, left, right) => {
                let (of, to) = (self.eval(left), self.eval(right));
                if matches!(*operator, "==" | "<>")
                    && (self.is_other(left, &of, &to) || self.is_other(right, &to, &of))
                {
                    return Value::Bool(*operator == "<>");
                }
                let found = binary(operator, &of, &to);
                known(found.map_err(|why| self.with_name(why, [(left, &of), (right, &to)])))
            }
            Expr::TwoWays(ways) => self.either_way(ways),
        }
    }

    /// What both ways to read an expression say. Where the second makes no sense of data that are
    /// known, no controller reads it so.
    fn either_way(&mut self, [meant, other]: &'a [Expr; 2]) -> Value {
        const OPEN: &str = "a comparison stands beside AND, OR or EXOR, and which is evaluated \
                            first changes the result: put parentheses";
        let parts = all_of(vec![meant]);
        let calls = |part: &&Expr| matches!(part, Expr::Call(name, _) if !is_own_function(name));
        if parts.iter().any(calls) {
            // A function may do something each time that it is called.
            return Value::unknown(OPEN);
        }
        let (value, else_value) = (self.eval(meant), self.eval(other));
        if value == else_value {
            return value;
        }
        let data = parts.into_iter().filter(|part| matches!(part, Expr::Ref(_)));
        let is_known = |value: &Value| !matches!(value, Value::Unknown(_));
        let all_known = data.map(|datum| self.eval(datum)).all(|value| is_known(&value));
        if all_known && !is_known(&else_value) {
            return value;
        }
        Value::unknown(if is_known(&else_value) || all_known {
            OPEN.to_owned()
        } else {
            match value {
                Value::Unknown(why) => why,
                _ => OPEN.to_owned(),
            }
        })
    }

    /// The name of a datum with the values of its indices: `xp[3]`.
    pub(super) fn key(&mut self, path: &'a Path) -> Result<String, String> {
        let mut key = path.name.clone();
        for index in &path.indices {
            self.indexing += 1;
            let number = self.eval(index).num();
            self.indexing -= 1;
            let number = number?;
            key.push_str(&format!("[{number}]"));
        }
        let is_own = self.frames.last().is_some_and(|frame| frame.has(&key));
        Ok(if is_own { key } else { self.file.signals.key(key) })
    }

    pub(super) fn read(&mut self, path: &'a Path) -> Value {
        let key = match self.key(path) {
            Ok(key) => key,
            Err(why) => return Value::unknown(why),
        };
        let is_said = self.asks_for(&key, &path.fields);
        let mut value = self.found(&key, is_said && path.fields.is_empty());
        if (is_said || matches!(value, Value::Unknown(_)))
            && let Some(assumed) = self.assumed_component(&key, &path.fields)
        {
            return assumed;
        }
        for field in &path.fields {
            value = match value {
                Value::Parts(mut parts) => parts.remove(field).unwrap_or_else(|| {
                    Value::unknown(format!("'{key}' has no component {}", field.to_uppercase()))
                }),
                Value::Unknown(why) => Value::Unknown(why),
                _ => Value::unknown(format!("'{key}' has no components")),
            };
        }
        value
    }

    /// What the job assumes of a component of a datum that is not known: `$POS_ACT.Z`.
    fn assumed_component(&mut self, key: &str, fields: &[String]) -> Option<Value> {
        let is_position = POSITIONS.contains(&key);
        let has_left = is_position && (self.has_left || self.log.has_moved());
        if fields.is_empty() || has_left || self.forgotten.contains(key) {
            return None;
        }
        let name = format!("{key}.{}", fields.join("."));
        if self.scope(key).is_none()
            && let Some(set) = self.components.get(&name)
        {
            return Some(set.clone());
        }
        let assumed = *self.settings.assume.get(&name)?;
        if self.forgotten.contains(&name) {
            return Some(Value::unknown(format!(
                "the program sets {}, so that assume: does not count, and '{key}' is declared in \
                 no file that is read; path.program.files in the job can name the file",
                name.to_uppercase()
            )));
        }
        if is_position && !key.starts_with("$axis") {
            let frames = (self.base, self.tcp, self.no_base.clone(), self.unknown_form.clone());
            if self.asked_in.is_none() {
                let what = "what assume: gives of the robot's position counts in the base and with \
                            the tool that are chosen here";
                self.log.warning(Code::Assumed, self.line, what);
            }
            // A number counts in one base and with one tool.
            if *self.asked_in.get_or_insert_with(|| frames.clone()) != frames {
                return Some(Value::unknown(format!(
                    "assume: {{\"{}\": …}} counts in the base and with the tool where the program \
                     asks for the position first, and others are chosen since",
                    name.to_uppercase()
                )));
            }
        }
        Some(value_of(assumed).held_in(fields.last()?))
    }

    /// As a component of this name holds it: of a structure that the files declare a FRAME, too.
    fn held_in(&self, value: Value, component: &str) -> Value {
        let declared = self.file.components.get(component).map_or(&[][..], Vec::as_slice);
        let (Value::Parts(_), Some((first, others))) = (&value, declared.split_first()) else {
            return value.held_in(component);
        };
        let held = value.clone().held_as(Some(*first));
        if others.iter().all(|other| value.clone().held_as(Some(*other)) == held) {
            return held;
        }
        Value::unknown(format!(
            "{} is a component of several STRUC, which differ in whether it keeps S, T and \
             external axes: which one this is is not read",
            component.to_uppercase()
        ))
    }

    pub(super) fn datum(&mut self, key: &str) -> Value {
        let is_said = self.asks_for(key, &[]);
        self.found(key, is_said)
    }

    /// A datum; what the job says of it counts before its value where `is_said`.
    fn found(&mut self, key: &str, is_said: bool) -> Value {
        let own = match self.frames.last().filter(|frame| frame.has(key)) {
            Some(frame) => Some(frame.data.get(key).cloned().unwrap_or_else(|| unset(key))),
            // What is worked out anew all the time.
            None if RUNNING.contains(&base(key)) || is_said => None,
            None => self.globals.get(key).cloned(),
        };
        if let Some(value) = own.as_ref().filter(|value| !matches!(value, Value::Unknown(_))) {
            return value.clone();
        }
        // The job may call an output by any of its names.
        let names = self.names(key);
        if !self.forgotten.contains(key)
            && let Some(name) = self.assumed_name(&names)
        {
            return name;
        }
        let assumed = names.iter().find_map(|name| self.settings.assume.get(name));
        let assumed = assumed.copied();
        match (own, assumed.filter(|_| !self.forgotten.contains(key))) {
            (None | Some(Value::Unknown(_)), Some(assumed)) => {
                return value_of(assumed).held_as(self.type_of(key));
            }
            (Some(value), _) => {
                if let (Value::Unknown(why), true) = (&value, assumed.is_some()) {
                    let what = format!("assume: '{key}' has no effect here: {why}");
                    self.log.warning(Code::Unused, self.line, what);
                }
                return value;
            }
            (None, None) => {}
        }
        match key {
            "$nullframe" | "tool_data[0]" => of_frame(&Isometry3::identity()),
            "$world" => of_frame(&self.settings.base_frames.get(&0).copied().unwrap_or_default()),
            "$nullpos" if self.settings.external_axes.is_empty() => null_position(),
            "$pos_act" | "$pos_ret" | "$pos_int" => self.position(),
            "$axis_act" | "$axis_act_meas" if !(self.has_left || self.log.has_moved()) => {
                Value::unknown(AXES_AT_START)
            }
            "$base" => match &self.no_base {
                Some(why) => Value::unknown(why.clone()),
                None => {
                    self.tell_of_world();
                    of_frame(&self.base)
                }
            },
            "$tool" => {
                self.tell_of_tool(self.line);
                of_frame(&self.tcp)
            }
            "$vel" => self.speeds(),
            _ if key.starts_with("tool_data[") => self.of_job(key, tool_frame),
            _ if key.starts_with("base_data[") => self.of_job(key, base_frame),
            _ if key.starts_with('$') => {
                let shown = names.last().map_or(key, String::as_str).to_uppercase();
                Value::unknown(format!("'{shown}' is known only at run time"))
            }
            _ => Value::unknown(format!("'{key}' is declared in no file that is read")),
        }
    }

    /// `tool_data[2]`, `base_data[1]` that no file gives.
    fn of_job(
        &self,
        key: &str,
        frame: fn(&Settings, f64, &str) -> Result<Isometry3<f64>, String>,
    ) -> Value {
        let (list, index) = key.split_once('[').unwrap_or((key, ""));
        let number = index.trim_end_matches(']').parse().map_err(|_| format!("'{key}'"));
        let found = number.and_then(|n| frame(self.settings, n, &list.to_uppercase()));
        known(found.map(|frame| of_frame(&frame)))
    }

    /// Where the robot is, in the base.
    fn position(&mut self) -> Value {
        match self.log.last() {
            _ if self.no_base.is_some() => Value::unknown("the base is not known"),
            Some(last) if !self.log.is_away() => {
                self.tell_of_world();
                self.tell_of_tool(self.line);
                of_frame(&(self.base.inverse() * last.with(&self.tcp)))
            }
            _ if self.has_left || self.log.has_moved() => {
                Value::unknown(format!("the robot's position {BEHIND_MOVE}"))
            }
            _ => Value::unknown(
                "the robot's position before the first move is known only at run time; assume: \
                 {\"$POS_ACT.Z\": …} gives a component",
            ),
        }
    }

    /// Stores a value in a datum or a part of it.
    pub(super) fn write(&mut self, path: &'a Path, value: Value) -> Result<(), String> {
        let key = self.key(path)?;
        self.write_at(key, &path.fields, value)
    }

    pub(super) fn write_at(
        &mut self,
        key: String,
        fields: &[String],
        value: Value,
    ) -> Result<(), String> {
        let scope = self.scope(&key);
        self.sets_anew(&key, fields);
        let is_it = |own: &&Beside| [key.as_str(), base(&key)].contains(&own.key.as_str());
        let beside = self.beside.iter().find(|own| own.scope == scope && is_it(own));
        let value = beside.map_or(value, |own| Value::unknown(own.why.clone()));
        let declared = self.type_of(&key);
        // A component of a frame that the job gives: the others stay.
        if !fields.is_empty()
            && ["tool_data", "base_data"].contains(&base(&key))
            && !self.globals.contains_key(&key)
            && let given @ Value::Parts(_) = self.datum(&key)
        {
            self.globals.insert(key.clone(), given);
        }
        if matches!(value, Value::Unknown(_)) && fields.is_empty() {
            self.forgotten.insert(key.clone());
        }
        let Some((last, way)) = fields.split_last() else {
            self.store(&key).insert(key, value.held_as(declared));
            return Ok(());
        };
        let value = self.held_in(value, last);
        let store = self.store(&key);
        let is_new = store.get(&key).is_none_or(|old| *old == unset(&key));
        if is_new && (declared.is_some() || key.ends_with("dat_act")) {
            store.insert(key.clone(), Value::Parts(Parts::new()));
        }
        let undeclared = || Value::unknown(format!("'{key}' is declared in no file that is read"));
        let mut target = store.entry(key.clone()).or_insert_with(undeclared);
        if let Value::Unknown(why) = target {
            // The other components of a position are as unknown as before.
            let names = [FRAME, AXES].into_iter().find(|names| names.contains(&last.as_str()));
            let Some(names) = names.filter(|_| way.is_empty()) else {
                let name = format!("{key}.{}", fields.join("."));
                if scope.is_none() && !key.starts_with('$') {
                    self.components.insert(name.clone(), value);
                }
                self.forgotten.insert(name);
                return Ok(());
            };
            let parts = names.map(|name| (name.to_owned(), Value::unknown(why.clone())));
            *target = Value::Parts(parts.into_iter().collect());
        }
        for field in way {
            let Value::Parts(parts) = target else { return Err("has no components".to_owned()) };
            target = parts.entry(field.clone()).or_insert_with(|| Value::Parts(Parts::new()));
        }
        match target {
            Value::Parts(parts) => {
                parts.insert(last.clone(), value);
                Ok(())
            }
            other => {
                *other = Value::Parts(Parts::from([(last.clone(), value)]));
                Ok(())
            }
        }
    }

    /// The routine whose own a datum is, by its depth; `None` of what is there for all.
    pub(super) fn scope(&self, key: &str) -> Option<usize> {
        self.frames.last().filter(|frame| frame.has(key)).map(|_| self.frames.len())
    }

    pub(super) fn store(&mut self, key: &str) -> &mut HashMap<String, Value> {
        match self.frames.last_mut().filter(|frame| frame.has(key)) {
            Some(frame) => &mut frame.data,
            None => &mut self.globals,
        }
    }

    /// What its declaration says, if a file declares it.
    pub(super) fn type_of(&self, key: &str) -> Option<Type> {
        let name = base(key);
        match self.frames.last().filter(|frame| frame.has(key)) {
            Some(frame) => frame.types.get(name).copied(),
            None => self.types.get(name).copied(),
        }
    }

    /// A datum is no longer known.
    pub(super) fn forget(&mut self, path: &'a Path, what: &str) {
        // In a branch or loop that only the run decides the index may be another.
        let indices = names_in(path.indices.iter().collect());
        let may_be_any = indices.into_iter().any(|name| self.open_sets.contains(name));
        match self.key(path) {
            Ok(key) if !may_be_any => {
                self.forgotten.insert(key.clone());
                self.forget_components(&key);
                self.forget_sharing(&key);
                // Lines of the main file that name it are told of by themselves.
                if self.place.0 != 0 && self.is_read_by_job(&key) {
                    self.log.warning(
                        Code::SpindleCommand,
                        self.line,
                        format!("{what}: the job reads it"),
                    );
                }
                self.store(&key).insert(key, Value::unknown(what));
            }
            _ => self.forget_element(path, what),
        }
    }

    /// An element is set, and which one is not known: it may be the one that the job reads.
    pub(super) fn forget_element(&mut self, path: &Path, what: &str) {
        if self.is_list_of_job(&path.name) {
            let told =
                format!("{what}: which one is known only at run time, and the job reads one");
            self.log.warning(Code::SpindleCommand, self.line, told);
        }
        self.forget_all(&path.name, what);
    }

    /// Whether the job reads the spindle or the tool from a datum, by any of its names.
    pub(super) fn is_read_by_job(&self, key: &str) -> bool {
        let names = self.names(key);
        named_by(self.settings).any(|own| names.contains(&own))
    }

    /// An output is set that belongs to others, too: those are no longer known, and the job may
    /// read one of them.
    pub(super) fn forget_sharing(&mut self, key: &str) {
        for other in self.file.signals.shared_with(key) {
            let [set, shared] = [key, &other].map(|key| self.names(key).pop().unwrap_or_default());
            let [set, shared] = [set, shared].map(|name| name.to_uppercase());
            let what = format!("'{shared}' shares outputs with '{set}', which is set");
            if self.is_read_by_job(&other) {
                let told = format!("{what} here: what the job reads from it is not known");
                self.log.warning(Code::SpindleCommand, self.line, told);
            }
            self.forgotten.insert(other.clone());
            self.globals.insert(other, Value::unknown(what));
        }
    }

    /// Every name of a datum: its key, and what SIGNAL calls it.
    pub(super) fn names(&self, key: &str) -> Vec<String> {
        let signals = self.file.signals.names_of(key).iter().cloned();
        std::iter::once(key.to_owned()).chain(signals).collect()
    }

    /// No element of an array is known any longer.
    pub(super) fn forget_all(&mut self, name: &str, what: &str) {
        let datum = |said| Assumed::enumeration(said).map_or(said, |(datum, _)| datum).to_owned();
        let assumed = self.settings.assume.keys().map(|said| self.file.signals.key(datum(said)));
        let assumed: Vec<String> = assumed.filter(|key| base(key) == name).collect();
        self.forgotten.extend(assumed.iter().cloned().chain([name.to_owned()]));
        self.forget_components(name);
        let store = self.store(name);
        for key in assumed {
            store.entry(key).or_insert_with(|| Value::unknown(what));
        }
        for (key, value) in store {
            if base(key) == name {
                *value = Value::unknown(what);
            }
        }
    }

    /// What is in no file may have set any signal that the program has set. Of others the job's
    /// word is that of when the program asks.
    pub(super) fn forget_signals(&mut self, what: &str) {
        for (key, value) in &mut self.globals {
            if SIGNALS.contains(&base(key)) {
                self.forgotten.insert(key.clone());
                *value = Value::unknown(what);
            }
        }
    }

    /// `VARSTATE("X")` of a datum that the program has set.
    fn state_of(&mut self, name: Option<&Value>) -> Value {
        match name {
            Some(Value::Text(name))
                if !matches!(self.datum(&name.to_lowercase()), Value::Unknown(_)) =>
            {
                Value::Enum("initialized".to_owned())
            }
            _ => Value::unknown("function 'varstate' is known only at run time"),
        }
    }

    fn function(&mut self, name: &'a str, args: &'a [Option<Expr>]) -> Value {
        let outer = self.rests_on.clone();
        let (values, on) = self.arguments(args);
        if let Some(routine) = self.file.functions.get(name) {
            self.rests_on = outer;
            return self.run_function(routine, args, values, on);
        }
        let first = values.first();
        let num = || first.map_or_else(|| Err("an argument is missing".to_owned()), Value::num);
        let of = |apply: fn(f64) -> f64| known(num().map(|x| Value::real(apply(x))));
        match name {
            "abs" => of(f64::abs),
            "sqrt" => of(f64::sqrt),
            "sin" => of(|x| rad_from_deg(x).sin()),
            "cos" => of(|x| rad_from_deg(x).cos()),
            "tan" => of(|x| rad_from_deg(x).tan()),
            // Its first half turn alone is counted alike everywhere.
            "atan2" => known(num().and_then(|y| match values.get(1).map(Value::num) {
                // Without the sign of a zero.
                Some(Ok(x)) if y >= 0.0 => Ok(Value::real(deg_from_rad((y + 0.0).atan2(x)))),
                Some(Err(why)) => Err(why),
                _ => Err("ATAN2 of a negative Y is not read".to_owned()),
            })),
            "varstate" => self.state_of(first),
            "acos" => of(|x| deg_from_rad(x.acos())),
            "inv_pos" | "inv_frame" => {
                known(first.ok_or_else(String::new).and_then(|value| {
                    frame(value.parts()?).map(|frame| of_frame(&frame.inverse()))
                }))
            }
            // The speed and the frames of inline forms.
            "svel_cp" | "svel_joint" => known(match first {
                Some(value) if name == "svel_cp" => self.speeds_of_spline(self.line, value),
                Some(value) => self.basic_share(self.line, value),
                None => Err("no speed".to_owned()),
            }),
            // How the tool turns on its lines and arcs.
            "sori_typ" | "scirc_typ" => {
                let part = if name == "sori_typ" { "ori_typ" } else { "circ_typ" };
                let of = first.and_then(|form| form.parts().ok()?.get(part).cloned());
                of.unwrap_or_else(|| Value::unknown(format!("{part} is in no file that is read")))
            }
            "sload" => match first.map(|value| number_of(value, "tool_no")) {
                Some(Ok(number)) => self.datum(&format!("load_data[{number}]")),
                Some(Err(why)) => Value::unknown(why),
                None => Value::unknown("SLOAD without a number"),
            },
            "stool" | "stool2" => {
                let number = first.map(|value| number_of(value, "tool_no"));
                known(
                    number
                        .unwrap_or(Err(String::new()))
                        .and_then(|n| self.tool_frame(n).map(|frame| of_frame(&frame))),
                )
            }
            "sbase" => {
                let number = first.map(|value| number_of(value, "base_no"));
                known(
                    number
                        .unwrap_or(Err(String::new()))
                        .and_then(|n| self.base_frame(n).map(|frame| of_frame(&frame))),
                )
            }
            "ek" | "eb" => Value::unknown(format!("{}(…) {ON_KINEMATIC}", name.to_uppercase())),
            "sipo_mode" => match first {
                Some(value @ Value::Enum(_)) => value.clone(),
                _ => Value::Enum("base".to_owned()),
            },
            _ => {
                self.fill(name, args);
                if !is_own_function(name) {
                    self.not_read(self.line, name, args);
                }
                match self.settings.assume.get(name) {
                    Some(assumed) => value_of(*assumed).held_as(None),
                    None => Value::unknown(format!(
                        "function '{name}' is not read: its value is known only at run time"
                    )),
                }
            }
        }
    }
}

/// What the job assumes, as the text of a program would have it.
fn value_of(assumed: Assumed) -> Value {
    match assumed {
        Assumed::Truth(value) => Value::Bool(value),
        Assumed::Number(value) => {
            let sort = if value.fract() == 0.0 { Sort::Whole } else { Sort::Real };
            Value::Num(value, None, sort)
        }
    }
}

/// $NULLPOS; which S and T it has is not known here.
fn null_position() -> Value {
    let mut parts = match of_frame(&Isometry3::identity()) {
        Value::Parts(parts) => parts,
        other => return other,
    };
    let unknown = || Value::unknown("S and T of $NULLPOS are not read");
    parts.extend(["s", "t"].map(|name| (name.to_owned(), unknown())));
    Value::Parts(parts)
}

pub(super) fn number_of(value: &Value, part: &str) -> Result<f64, String> {
    match value {
        Value::Parts(parts) => {
            parts.get(part).map_or_else(|| Err(format!("{part} is missing")), Value::num)
        }
        other => other.num(),
    }
}

fn known(value: Result<Value, String>) -> Value {
    match value {
        Ok(Value::Num(number, ..)) if !number.is_finite() => {
            Value::unknown("the result is not finite")
        }
        Ok(value) => value,
        Err(why) => Value::unknown(why),
    }
}
