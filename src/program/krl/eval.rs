//! Expressions of KRL → values. What cannot be known from the files is [`Value::Unknown`] with the
//! reason, and becomes a fault only where motion depends on it.

use nalgebra::Isometry3;

use super::run::Run;
use super::syntax::{Expr, Path};
use super::value::{FRAME, Parts, Value, frame, of_frame};
use crate::program::cell::{base_frame, tool_frame};
use crate::program::{Assumed, Settings};
use crate::units::{deg_from_rad, rad_from_deg};

impl<'a> Run<'a> {
    pub(super) fn eval(&mut self, expr: &'a Expr) -> Value {
        match expr {
            Expr::Number(value, span) => Value::Num(*value, *span),
            Expr::Bool(value) => Value::Bool(*value),
            Expr::Text(text) => Value::Text(text.clone()),
            Expr::Enum(name) => Value::Enum(name.clone()),
            Expr::Parts(parts) => {
                let parts = parts.iter().map(|(name, expr)| (name.clone(), self.eval(expr)));
                Value::Parts(parts.collect())
            }
            Expr::Ref(path) => self.read(path),
            Expr::Call(name, args) => self.function(name, args),
            Expr::Not(inner) => known(self.eval(inner).bool().map(|value| Value::Bool(!value))),
            Expr::Minus(inner) => match self.eval(inner) {
                // The sign belongs to the number in the text.
                Value::Num(value, _) => Value::Num(-value, None),
                other => known(other.num().map(|value| Value::Num(-value, None))),
            },
            Expr::Binary(operator, left, right) => {
                let (left, right) = (self.eval(left), self.eval(right));
                known(binary(operator, &left, &right))
            }
        }
    }

    /// The name of a datum with the values of its indices: `xp[3]`.
    pub(super) fn key(&mut self, path: &'a Path) -> Result<String, String> {
        let mut key = path.name.clone();
        for index in &path.indices {
            let number = self.eval(index).num()?;
            key.push_str(&format!("[{number}]"));
        }
        Ok(key)
    }

    pub(super) fn read(&mut self, path: &'a Path) -> Value {
        let key = match self.key(path) {
            Ok(key) => key,
            Err(why) => return Value::unknown(why),
        };
        let mut value = self.datum(&key);
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

    pub(super) fn datum(&mut self, key: &str) -> Value {
        if let Some(value) = self.frames.last().and_then(|frame| frame.get(key)) {
            return value.clone();
        }
        if let Some(value) = self.globals.get(key) {
            return value.clone();
        }
        match self.settings.assume.get(key) {
            Some(Assumed::Truth(value)) => return Value::Bool(*value),
            Some(Assumed::Number(value)) => return Value::Num(*value, None),
            None => {}
        }
        match key {
            "$nullframe" | "$world" => of_frame(&Isometry3::identity()),
            "$pos_act" | "$pos_ret" | "$pos_int" => self.position(),
            "$base" | "$act_base" => of_frame(&self.base),
            "$tool" | "$act_tool" => of_frame(&self.tcp),
            _ if key.starts_with("tool_data[") => self.of_job(key, tool_frame),
            _ if key.starts_with("base_data[") => self.of_job(key, base_frame),
            _ if key.starts_with('$') => {
                Value::unknown(format!("'{}' is known only at run time", key.to_uppercase()))
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
    fn position(&self) -> Value {
        match self.log.last() {
            Some(last) => of_frame(&(self.base.inverse() * last.with(&self.tcp))),
            None => Value::unknown("the robot's position is known only at run time"),
        }
    }

    /// Stores a value in a datum or a part of it.
    pub(super) fn write(&mut self, path: &'a Path, value: Value) -> Result<(), String> {
        let key = self.key(path)?;
        let local = self.frames.last_mut().filter(|frame| frame.contains_key(&key));
        let store = match local {
            Some(frame) => frame,
            None => &mut self.globals,
        };
        let Some((last, way)) = path.fields.split_last() else {
            store.insert(key, value);
            return Ok(());
        };
        let mut target = store.entry(key).or_insert_with(|| Value::Parts(Parts::new()));
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

    fn function(&mut self, name: &'a str, args: &'a [Option<Expr>]) -> Value {
        let mut values: Vec<Value> = Vec::new();
        for arg in args {
            let value = match arg {
                Some(expr) => self.eval(expr),
                None => Value::unknown("an argument is left out"),
            };
            values.push(value);
        }
        let first = values.first();
        let num = || first.map_or_else(|| Err("an argument is missing".to_owned()), Value::num);
        let of = |apply: fn(f64) -> f64| known(num().map(|x| Value::Num(apply(x), None)));
        match name {
            "abs" => of(f64::abs),
            "sqrt" => of(f64::sqrt),
            "sin" => of(|x| rad_from_deg(x).sin()),
            "cos" => of(|x| rad_from_deg(x).cos()),
            "tan" => of(|x| rad_from_deg(x).tan()),
            "acos" => of(|x| deg_from_rad(x.acos())),
            "inv_pos" | "inv_frame" => {
                known(first.ok_or_else(String::new).and_then(|value| {
                    frame(value.parts()?).map(|frame| of_frame(&frame.inverse()))
                }))
            }
            // The speed and the frames of inline forms.
            "svel_cp" | "svel_joint" => {
                first.cloned().unwrap_or_else(|| Value::unknown("no speed"))
            }
            "stool" | "stool2" | "sload" => {
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
            "sipo_mode" => match first {
                Some(value @ Value::Enum(_)) => value.clone(),
                _ => Value::Enum("base".to_owned()),
            },
            _ => Value::unknown(format!(
                "function '{name}' is not read: its value is known only at run time"
            )),
        }
    }
}

fn number_of(value: &Value, part: &str) -> Result<f64, String> {
    match value {
        Value::Parts(parts) => {
            parts.get(part).map_or_else(|| Err(format!("{part} is missing")), Value::num)
        }
        other => other.num(),
    }
}

fn known(value: Result<Value, String>) -> Value {
    match value {
        Ok(Value::Num(number, _)) if !number.is_finite() => {
            Value::unknown("the result is not finite")
        }
        Ok(value) => value,
        Err(why) => Value::unknown(why),
    }
}

fn binary(operator: &str, left: &Value, right: &Value) -> Result<Value, String> {
    let number = |value: f64| Ok(Value::Num(value, None));
    match operator {
        "and" | "or" => {
            let decides = operator == "or";
            match (left.bool(), right.bool()) {
                (Ok(value), _) | (_, Ok(value)) if value == decides => Ok(Value::Bool(decides)),
                (Ok(_), Ok(_)) => Ok(Value::Bool(!decides)),
                (Err(why), _) | (_, Err(why)) => Err(why),
            }
        }
        "exor" => Ok(Value::Bool(left.bool()? != right.bool()?)),
        // Frames one in another.
        ":" => {
            let (first, second) = (frame(left.parts()?)?, right.parts()?);
            let product = of_frame(&(first * frame(second)?));
            // S, T and E1 to E6 stay those of the second.
            let (Value::Parts(mut parts), rest) = (product, second.iter()) else {
                return Err("expected frames".to_owned());
            };
            let kept = rest.filter(|(name, _)| !FRAME.contains(&name.as_str()));
            parts.extend(kept.map(|(name, value)| (name.clone(), value.clone())));
            Ok(Value::Parts(parts))
        }
        "==" | "<>" => {
            let same = match (left, right) {
                (Value::Unknown(why), _) | (_, Value::Unknown(why)) => return Err(why.clone()),
                (Value::Num(a, _), Value::Num(b, _)) => a == b,
                _ => left == right,
            };
            Ok(Value::Bool(same == (operator == "==")))
        }
        "<" => Ok(Value::Bool(left.num()? < right.num()?)),
        "<=" => Ok(Value::Bool(left.num()? <= right.num()?)),
        ">" => Ok(Value::Bool(left.num()? > right.num()?)),
        ">=" => Ok(Value::Bool(left.num()? >= right.num()?)),
        "+" => number(left.num()? + right.num()?),
        "-" => number(left.num()? - right.num()?),
        "*" => number(left.num()? * right.num()?),
        _ if right.num()? == 0.0 => Err("division by zero".to_owned()),
        _ => number(left.num()? / right.num()?),
    }
}
