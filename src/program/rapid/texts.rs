//! Functions of strings, as far as programs work out names and numbers with them. Characters count
//! from 1.

use super::functions::Given;
use super::interpreter::Interpreter;
use super::number::Number;
use super::syntax::{Args, Expr};
use super::value::Value;
use super::why::COPY;

/// The value of function `key` (lower case); `None` if there is no such function here.
pub(super) fn call(key: &str, given: &Given) -> Option<Result<Value, String>> {
    Some(match key {
        "strlen" => given.text(0).map(|text| count(text.chars().count())),
        "strpart" => str_part(given),
        "strfind" | "strmatch" => found_in(key, given).map(count),
        "valtostr" => val_to_str(given),
        "numtostr" => num_to_str(given),
        _ => return None,
    })
}

fn count(number: usize) -> Value {
    Value::Num(Number::of(number as f64))
}

/// A place in a string, or a number of characters.
fn place(given: &Given, index: usize, least: f64) -> Result<usize, String> {
    let number = given.at(index)?.number()?.index()?;
    // Whole and not negative; beyond the end nothing is found.
    let is_one = number.fract() == 0.0 && number >= least;
    let what = || format!("expected a whole number from {least}, found {number}");
    is_one.then_some(number as usize).ok_or_else(what)
}

/// `StrPart(text, from, length)`.
fn str_part(given: &Given) -> Result<Value, String> {
    let text: Vec<char> = given.text(0)?.chars().collect();
    let (from, length) = (place(given, 1, 1.0)?, place(given, 2, 0.0)?);
    let part = text.get(from - 1..(from - 1).saturating_add(length));
    let part =
        part.ok_or_else(|| format!("characters {from} and {length} more lie beyond the string"))?;
    Value::text(&part.iter().collect::<String>())
}

/// `StrFind(text, from, set \NotInSet)` and `StrMatch(text, from, pattern)`: the place, or the one
/// behind the end.
fn found_in(key: &str, given: &Given) -> Result<usize, String> {
    let text: Vec<char> = given.text(0)?.chars().collect();
    let from = place(given, 1, 1.0)?;
    let wanted: Vec<char> = given.text(2)?.chars().collect();
    let rest = text.get(from - 1..).filter(|rest| !rest.is_empty());
    let rest = rest.ok_or_else(|| format!("character {from} lies beyond the string"))?;
    let is_in = !given.optional.iter().any(|(name, _)| name == "notinset");
    let at = match key {
        "strfind" => rest.iter().position(|own| wanted.contains(own) == is_in),
        _ if wanted.is_empty() => return Err("the pattern is empty".to_owned()),
        _ => rest.windows(wanted.len()).position(|own| own == wanted),
    };
    Ok(at.map_or(text.len() + 1, |at| from + at))
}

fn val_to_str(given: &Given) -> Result<Value, String> {
    match given.at(0)? {
        Value::Bool(true) => Value::text("TRUE"),
        Value::Bool(false) => Value::text("FALSE"),
        value => Value::text(&value.number()?.text()?),
    }
}

/// `NumToStr(number, decimals)`.
fn num_to_str(given: &Given) -> Result<Value, String> {
    if !given.optional.is_empty() {
        return Err("with options it is not read".to_owned());
    }
    Value::text(&given.at(0)?.number()?.text_with(given.num(1)?)?)
}

/// A number, a truth value or a list of these in a string; nothing that has to be worked out.
fn literal(text: &str) -> Option<Value> {
    if let Some(inside) = text.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        let mut depth = 0_i32;
        let parts = inside.split(move |own| {
            depth += i32::from(own == '[') - i32::from(own == ']');
            own == ',' && depth == 0
        });
        return parts.map(|part| literal(part.trim())).collect::<Option<_>>().map(Value::List);
    }
    match text.to_uppercase().as_str() {
        "TRUE" => return Some(Value::Bool(true)),
        "FALSE" => return Some(Value::Bool(false)),
        _ => {}
    }
    let is_plain = text.chars().all(|own| own.is_ascii_digit() || "+-.eE".contains(own));
    let number: f64 = text.parse().ok().filter(|number: &f64| is_plain && number.is_finite())?;
    Some(Value::Num(Number::of(number)))
}

/// Whether a value has the parts of another.
fn is_like(value: &Value, other: &Value) -> bool {
    match (value, other) {
        (Value::Num(_), Value::Num(_)) | (Value::Bool(_), Value::Bool(_)) => true,
        (Value::List(parts), Value::List(others)) => {
            parts.len() == others.len()
                && parts.iter().zip(others).all(|(part, other)| is_like(part, other))
        }
        _ => false,
    }
}

impl<'a> Interpreter<'a> {
    /// `StrToVal("2.5", n)`: sets its second argument.
    pub(super) fn value_of_text(&mut self, args: &'a Args, given: &[Value]) -> Option<Value> {
        let Some(Expr::Ref(path)) = args.positional.get(1) else { return None };
        self.refuse_constant(self.line, path);
        let Some(Value::Text(text)) = given.first() else { return None };
        let value = literal(text)?;
        let now = self.read(path);
        let (kind, blank) = self.blank_of_part(path)?;
        let shape = match now {
            Value::List(_) => now,
            _ => blank,
        };
        // A byte goes up to 255, and a record of the program may have some.
        let has_bytes = kind == "byte" || self.file.records.contains_key(kind);
        if has_bytes || !is_like(&value, &shape) {
            return None;
        }
        self.doubt_assignment(self.line, path, None);
        let value = match self.guarded {
            0 => value,
            _ => Value::unknown(format!(
                "'{}' is set by StrToVal behind AND or OR, which need not work that out: {COPY}",
                path.name.shown
            )),
        };
        self.write(path, value).ok()?;
        Some(Value::Bool(true))
    }

    /// Why a string of what the job alone says is TRUE or FALSE is not known: a signal is 1 or 0.
    pub(super) fn why_no_text(&self, args: &Args, given: &[Value]) -> Option<String> {
        let (Some(Expr::Ref(path)), Some(Value::Bool(value))) =
            (args.positional.first(), given.first())
        else {
            return None;
        };
        let name = self.signal_of(&path.name);
        let is_own = std::ptr::eq(name, &path.name) && self.is_declared(&name.key);
        let (shown, number) = (&name.shown, u8::from(*value));
        (!is_own).then(|| {
            format!(
                "whether '{shown}' is a signal ({number}) or a bool no file says: assume: \
                 {{\"{shown}\": {number}}} in the job says that it is a signal"
            )
        })
    }
}
