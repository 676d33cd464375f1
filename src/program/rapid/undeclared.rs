//! Data, and parts of them, that no file declares.

use super::constants::is_unread;
use super::interpreter::Interpreter;
use super::syntax::{File, Name, Path, Step};
use super::value::{Value, initial};
use super::why::{COPY, FILE, Why};
use crate::notes::Code;

impl<'a> Interpreter<'a> {
    /// Why a name that no file declares has no value.
    pub(super) fn why_undeclared(&self, name: &Name) -> Why {
        let of_controller = || {
            is_unread(&name.key).then(|| {
                format!(
                    "'{0}' is a constant of the controller, and its number is not read; assume: \
                     {{\"{0}\": …}} in the job can give it",
                    name.shown
                )
            })
        };
        let why = self.why_lost(name).or_else(of_controller).map(Why::from);
        why.unwrap_or_else(|| Why::elsewhere(undeclared(name), &name.shown))
    }

    /// What no file declares, or a part of it; which one, an index that is not known leaves open.
    pub(super) fn undeclared_part(&mut self, path: &'a Path) -> Value {
        let why = self.why_undeclared(&path.name);
        let mut way = Vec::new();
        for step in &path.steps {
            let Step::Index(indices) = step else {
                way.push(0);
                continue;
            };
            for index in indices {
                match self.index(index, &path.name) {
                    Ok(index) => way.push(index),
                    Err(index) => return Value::unknown(format!("{why}, and {index}")),
                }
            }
        }
        Value::Unknown(why.part(&shown_steps(path, &way).concat()))
    }

    /// A number, truth value or string is used that the program has set and no file declares:
    /// others may set it besides.
    pub(super) fn doubt_undeclared(&mut self, name: &'a Name, value: &Value) {
        let is_single = matches!(value, Value::Num(_) | Value::Bool(_) | Value::Text(_));
        // Where a trap sets it, the job may say what it is.
        let trapped = self.trapped.get(name.key.as_str());
        let is_of_job = trapped.is_some_and(|own| !matches!(own, Value::Unknown(_)));
        if is_single && !is_of_job && self.believed.insert(&name.key) {
            let what = format!(
                "{}: it is taken as the program has set it, and other tasks and error handlers may \
                 set it besides; {FILE}",
                undeclared(name)
            );
            self.log.warning(Code::MotionLeftOut, self.line, what);
        }
    }

    /// What is in no file may set data that are declared in none: these may be of one module.
    pub(super) fn lose_undeclared(&mut self, by: &str) {
        for (key, value) in &mut self.assigned {
            if matches!(value, Value::Num(_) | Value::Bool(_) | Value::Text(_)) {
                let what = "and both are in no file that is read";
                *value = Value::unknown(format!("'{by}' may set '{key}', {what}: {FILE}"));
            }
        }
    }

    /// Whether a datum of a module is of a type that no file declares, and the program gives it
    /// nothing.
    pub(super) fn is_left_open(&self, key: &str, kind: &str) -> bool {
        let declared = self.file.data.get(key);
        declared.is_some_and(|own| own.value.is_none())
            && !self.written.contains(key)
            && matches!(initial(self.file, kind), Value::Unknown(_))
    }
}

pub(super) fn undeclared(name: &Name) -> String {
    format!("'{}' is not declared in this file", name.shown)
}

/// The steps of the way to a part as they are written, one for each level.
pub(super) fn shown_steps(path: &Path, way: &[usize]) -> Vec<String> {
    let levels = path.steps.iter().flat_map(|step| match step {
        Step::Index(indices) => vec![None; indices.len()],
        Step::Field(name) => vec![Some(name)],
    });
    let levels: Vec<Option<&String>> = levels.collect();
    // What a parameter stands for may be a part itself.
    let before = way.len().saturating_sub(levels.len());
    let levels = vec![None; before].into_iter().chain(levels);
    let shown = levels.zip(way).map(|(field, index)| match field {
        Some(field) => format!(".{field}"),
        None => format!("{{{}}}", index + 1),
    });
    shown.collect()
}

/// The steps of a path from one on, if all are components.
pub(super) fn fields(path: &Path, from: usize) -> Option<String> {
    let rest = path.steps.iter().skip(from).map(|step| match step {
        Step::Field(name) => Some(format!(".{name}")),
        Step::Index(_) => None,
    });
    rest.collect()
}

pub(super) fn no_component(file: &File, of: &Name, kind: &str, component: &str) -> String {
    match initial(file, kind) {
        Value::Unknown(_) => {
            format!(
                "the type '{kind}' of '{}' is in no file that is read: {FILE}; if it is one of the \
                 controller, {COPY}",
                of.shown
            )
        }
        _ => format!("'{}' ({kind}) has no component '{component}'", of.shown),
    }
}
