//! Operators of KRL: what they give, or why that is not known.

use std::cmp::Ordering;

use super::value::{FRAME, INT, Sort, Value, frame, of_frame};
use crate::program::single;

pub(super) fn binary(operator: &str, left: &Value, right: &Value) -> Result<Value, String> {
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
        "b_and" => bits(left, right, |a, b| a & b),
        "b_or" => bits(left, right, |a, b| a | b),
        "b_exor" => bits(left, right, |a, b| a ^ b),
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
                (Value::Enum(_), Value::Enum(_)) => left == right,
                // No number and no truth is a name.
                (Value::Enum(name), other) | (other, Value::Enum(name)) => {
                    return Err(other.instead_of(&format!("a name as #{}", name.to_uppercase())));
                }
                (Value::Num(a, _, of_a), Value::Num(b, _, of_b)) if is_whole(*of_a, *of_b) => {
                    a == b
                }
                (Value::Num(a, ..), Value::Num(b, ..)) => single::is_same(*a, *b)?,
                _ => left == right,
            };
            Ok(Value::Bool(same == (operator == "==")))
        }
        "<" => Ok(Value::Bool(order(left, right)?.is_lt())),
        "<=" => Ok(Value::Bool(order(left, right)?.is_le())),
        ">" => Ok(Value::Bool(order(left, right)?.is_gt())),
        ">=" => Ok(Value::Bool(order(left, right)?.is_ge())),
        _ => arithmetic(operator, left.number()?, right.number()?),
    }
}

/// Which is larger.
fn order(left: &Value, right: &Value) -> Result<Ordering, String> {
    let ((a, of_a), (b, of_b)) = (left.number()?, right.number()?);
    // Numbers as the text has them are rounded alike.
    let are_written =
        matches!((left, right), (Value::Num(_, Some(_), _), Value::Num(_, Some(_), _)));
    match a.partial_cmp(&b) {
        Some(order) if are_written || is_whole(of_a, of_b) => Ok(order),
        _ => single::order(a, b),
    }
}

/// Whether both are INT, which lose no digit.
fn is_whole(a: Sort, b: Sort) -> bool {
    a == Sort::Whole && b == Sort::Whole
}

/// Of the bits of two INTs.
fn bits(left: &Value, right: &Value, join: fn(i64, i64) -> i64) -> Result<Value, String> {
    let whole = |value: &Value| match value.num()? {
        // Whole and within an INT, so that nothing is lost.
        number if number.fract() == 0.0 && INT.contains(&number) => Ok(number as i64),
        number => Err(format!("{number} is no INT, of which bits could be joined")),
    };
    let joined = join(whole(left)?, whole(right)?);
    Ok(Value::Num(joined as f64, None, Sort::Whole))
}

/// INT and INT give an INT, whose division drops what lies behind the point.
fn arithmetic(operator: &str, left: (f64, Sort), right: (f64, Sort)) -> Result<Value, String> {
    let ((a, of_a), (b, of_b)) = (left, right);
    let sort = match (of_a, of_b) {
        (Sort::Real, _) | (_, Sort::Real) => Sort::Real,
        (Sort::Whole, Sort::Whole) => Sort::Whole,
        _ => Sort::Open,
    };
    let value = match (operator, sort) {
        ("+", _) => a + b,
        ("-", _) => a - b,
        ("*", _) => a * b,
        _ if b == 0.0 => return Err("division by zero".to_owned()),
        (_, Sort::Whole) => (a / b).trunc(),
        (_, Sort::Open) if a % b != 0.0 => {
            return Err(format!(
                "whether {a}/{b} divides INTs is not known: one is declared in no file that is read"
            ));
        }
        _ => a / b,
    };
    if sort != Sort::Real && !INT.contains(&value) {
        return Err(format!("{a}{operator}{b} is beyond what an INT holds"));
    }
    Ok(Value::Num(value, None, sort))
}
