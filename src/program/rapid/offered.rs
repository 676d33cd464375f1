//! What `assume` can give: functions that are known only at run time and give a number or a truth
//! value, as far as the files say what they give.

use std::collections::{HashMap, HashSet};

use super::instructions::{gives_no_number, motion};
use super::interpreter::Interpreter;
use super::syntax::{Args, Block, Expr, File, Operator, Optional, Parameter, Path, Step, What};
use super::undeclared::undeclared;
use super::value::{Value, field, initial};
use super::walk::{all_of, expressions_in, statements_in};

/// Functions that shift a target, their first argument.
const SHIFT: [&str; 2] = ["offs", "reltool"];

impl Interpreter<'_> {
    /// Whether no file declares what a function is given first.
    pub(super) fn is_missed(&self, args: &Args) -> bool {
        let first = args.positional.first();
        matches!(first, Some(Expr::Ref(path)) if !self.is_declared(&path.name.key))
    }

    /// What gives a number by which a function shifts a target, where that number is not known.
    pub(super) fn help_of_shift(&self, key: &str, args: &Args, why: &str) -> String {
        let optional = args.optional.iter().filter_map(|(_, value)| match value {
            Optional::Value(expr) => Some(expr),
            _ => None,
        });
        let numbers = args.positional.iter().skip(1).chain(optional);
        let mut missed = all_of(numbers.collect()).into_iter().filter_map(|expr| match expr {
            Expr::Ref(path) if path.is_whole() && why == undeclared(&path.name) => Some(path),
            _ => None,
        });
        match missed.next().filter(|_| SHIFT.contains(&key)) {
            Some(path) => {
                format!("; assume: {{\"{}\": …}} in the job can give it", path.name.shown)
            }
            None => String::new(),
        }
    }

    /// What the job says of a datum that others set.
    pub(super) fn said_by_job(&self, key: &str) -> Option<Value> {
        let own = self.settings.assume.get(key).filter(|_| self.is_single(key))?;
        self.heed(key);
        Some(Value::from(*own))
    }

    /// Whether a datum may be one number or truth value, and is no array or record.
    pub(super) fn is_single(&self, key: &str) -> bool {
        let local = self.frames.last().and_then(|frame| frame.get(key));
        match (local, self.file.data.get(key)) {
            (Some(own), _) => !matches!(own.value, Value::List(_)) && is_plain(self.file, own.kind),
            (None, Some(own)) => own.dimensions.is_empty() && is_plain(self.file, &own.kind),
            (None, None) => self.kind_of(key).is_none_or(|kind| is_plain(self.file, kind)),
        }
    }

    /// Whether a function that is known only at run time gives no number and no truth value.
    pub(super) fn gives_other(&self, key: &str) -> bool {
        gives_no_number(key) || self.not_plain.get_or_init(|| not_plain(self.file)).contains(key)
    }
}

/// Functions of no file that give a record, an array or a text, by where the files put it.
fn not_plain(file: &File) -> HashSet<&str> {
    let mut found = HashSet::new();
    for routine in file.procedures.values().chain(file.functions.values()) {
        look(file, &routine.parameters, &routine.body, &mut found);
    }
    for trap in &file.traps {
        look(file, &[], &trap.body, &mut found);
    }
    found.retain(|key| !file.functions.contains_key(*key));
    found
}

fn look<'a>(
    file: &'a File,
    parameters: &'a [Parameter],
    body: &'a Block,
    found: &mut HashSet<&'a str>,
) {
    let mut own: HashMap<&str, &str> =
        parameters.iter().map(|own| (own.name.key.as_str(), own.kind.as_str())).collect();
    for what in statements_in(std::iter::once(body)) {
        if let What::Declare(data) = what {
            own.insert(&data.name.key, &data.kind);
        }
    }
    for what in statements_in(std::iter::once(body)) {
        match what {
            What::Declare(data) if !is_plain(file, &data.kind) => {
                found.extend(data.value.as_ref().and_then(called));
            }
            What::Assign(path, value) => {
                let kind = kind_at(file, &own, path);
                if kind.is_some_and(|own| !is_plain(file, own)) {
                    found.extend(called(value));
                }
            }
            What::Call(name, args) if motion(&name.key).is_some() => {
                found.extend(args.positional.iter().filter_map(called));
            }
            _ => {}
        }
        for expr in all_of(expressions_in(what)) {
            match expr {
                Expr::Call(call) if SHIFT.contains(&call.0.key.as_str()) => {
                    found.extend(call.1.positional.first().and_then(called));
                }
                Expr::Binary(Operator::Equal | Operator::Unequal, left, right) => {
                    let is_other = |expr: &Expr| match expr {
                        Expr::Text(_) => true,
                        Expr::Ref(path) => {
                            kind_at(file, &own, path).is_some_and(|kind| !is_plain(file, kind))
                        }
                        _ => false,
                    };
                    for (own, other) in [(left, right), (right, left)] {
                        found.extend(called(own).filter(|_| is_other(other)));
                    }
                }
                _ => {}
            }
        }
        if let What::Test(tested, cases, _) = what {
            let mut values = cases.iter().flat_map(|(values, _)| values);
            let is_text = values.any(|value| matches!(value, Expr::Text(_)));
            found.extend(called(tested).filter(|_| is_text));
        }
    }
}

/// The function that an expression is a call of.
fn called(expr: &Expr) -> Option<&str> {
    match expr {
        Expr::Call(call) => Some(&call.0.key),
        _ => None,
    }
}

/// The type of what an assignment sets, or of its elements.
fn kind_at<'a>(file: &'a File, own: &HashMap<&str, &'a str>, path: &Path) -> Option<&'a str> {
    let key = path.name.key.as_str();
    let of_module = || file.data.get(key).map(|data| data.kind.as_str());
    let mut kind = own.get(key).copied().or_else(of_module)?;
    for step in &path.steps {
        if let Step::Field(name) = step {
            kind = field(file, kind, name)?.1;
        }
    }
    Some(kind)
}

/// Whether data of a type may be one number or truth value: of a type that is not known nobody
/// says.
fn is_plain(file: &File, kind: &str) -> bool {
    kind != "rawbytes" && !matches!(initial(file, kind), Value::List(_) | Value::Text(_))
}
