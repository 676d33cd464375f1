//! Operators on values.

use super::number::Number;
use super::syntax::Operator;
use super::value::{Value, from_orientation, orientation, position};
use super::why::{COPY, Why};

pub(super) fn binary(operator: Operator, left: &Value, right: &Value) -> Result<Value, String> {
    use Operator as O;
    match operator {
        // A side that decides alone does so even where the other is not known.
        O::And | O::Or => {
            let decides = operator == O::Or;
            match (left.bool(), right.bool()) {
                (Ok(value), _) | (_, Ok(value)) if value == decides => Ok(Value::Bool(decides)),
                (Ok(_), Ok(_)) => Ok(Value::Bool(!decides)),
                (Err(why), _) | (_, Err(why)) => Err(why),
            }
        }
        O::Xor => Ok(Value::Bool(left.bool()? != right.bool()?)),
        O::Equal => equal(left, right).map(Value::Bool),
        O::Unequal => equal(left, right).map(|same| Value::Bool(!same)),
        O::Less | O::LessOrEqual | O::Greater | O::GreaterOrEqual => {
            let order = left.number()?.order(right.number()?)?;
            let is_so = match operator {
                O::Less => order.is_lt(),
                O::LessOrEqual => order.is_le(),
                O::Greater => order.is_gt(),
                _ => order.is_ge(),
            };
            Ok(Value::Bool(is_so))
        }
        O::Plus | O::Minus | O::Times | O::Over | O::Div | O::Mod => {
            arithmetic(operator, left, right)
        }
    }
}

pub(super) fn equal(left: &Value, right: &Value) -> Result<bool, String> {
    use Value as V;
    match (left, right) {
        (V::Unknown(why), V::Text(_)) | (V::Text(_), V::Unknown(why)) => Err(no_string(why)),
        (Value::Unknown(why), _) | (_, Value::Unknown(why)) => Err(why.to_string()),
        (Value::List(left), Value::List(right)) => {
            let mut same = left.len() == right.len();
            for (left, right) in left.iter().zip(right) {
                same &= equal(left, right)?;
            }
            Ok(same)
        }
        // A signal that is TRUE is 1.
        (Value::Bool(truth), Value::Num(number)) | (Value::Num(number), Value::Bool(truth)) => {
            number.is_same(Number::of(f64::from(u8::from(*truth))))
        }
        (Value::Num(left), Value::Num(right)) => left.is_same(*right),
        // No program has them beside each other: the one is what the job assumes.
        (V::Text(_), V::Num(_) | V::Bool(_) | V::List(_)) => Err(not_given(right, "a string")),
        (V::Num(_) | V::Bool(_) | V::List(_), V::Text(_)) => Err(not_given(left, "a string")),
        (V::List(_), V::Num(_) | V::Bool(_)) => Err(not_given(right, "a record or an array")),
        (V::Num(_) | V::Bool(_), V::List(_)) => Err(not_given(left, "a record or an array")),
        _ => Ok(left == right),
    }
}

/// Why a string is not known: one of another file `assume` does not give.
fn no_string(why: &Why) -> String {
    if why.of_other_file().is_none() || why.contains(COPY) {
        return why.to_string();
    }
    format!("{why}{}; assume gives no strings: {COPY}", why.help())
}

fn not_given(value: &Value, expected: &str) -> String {
    format!("{}; assume gives numbers and truth values alone: {COPY}", value.instead_of(expected))
}

fn arithmetic(operator: Operator, left: &Value, right: &Value) -> Result<Value, String> {
    let each = |items: &[Value], apply: &dyn Fn(&Value) -> Result<Value, String>| {
        items.iter().map(apply).collect::<Result<Vec<_>, _>>().map(Value::List)
    };
    match (left, right) {
        (Value::Unknown(why), _) | (_, Value::Unknown(why)) => Err(why.to_string()),
        (Value::Text(left), Value::Text(right)) if operator == Operator::Plus => {
            Value::text(&format!("{left}{right}"))
        }
        // pos · pos is their cross product, orient · orient one turn after the other.
        (Value::List(a), Value::List(b))
            if operator == Operator::Times && a.len() == 3 && b.len() == 3 =>
        {
            let product = Value::nums(position(left)?.cross(&position(right)?).as_slice());
            Ok(product.worked_out([left, right]))
        }
        (Value::List(a), Value::List(b))
            if operator == Operator::Times && a.len() == 4 && b.len() == 4 =>
        {
            let product = from_orientation(&(orientation(left)? * orientation(right)?));
            Ok(product.worked_out([left, right]))
        }
        // pos ± pos, by component; pos · num, num · pos, pos / num.
        (Value::List(left), Value::List(right))
            if matches!(operator, Operator::Plus | Operator::Minus)
                && left.len() == 3
                && right.len() == 3 =>
        {
            let pairs = left.iter().zip(right);
            let sums = pairs.map(|(left, right)| arithmetic(operator, left, right));
            sums.collect::<Result<Vec<_>, _>>().map(Value::List)
        }
        (Value::List(items), Value::Num(_))
            if matches!(operator, Operator::Times | Operator::Over) && items.len() == 3 =>
        {
            each(items, &|item| arithmetic(operator, item, right))
        }
        (Value::Num(_), Value::List(items)) if operator == Operator::Times && items.len() == 3 => {
            each(items, &|item| arithmetic(operator, left, item))
        }
        _ => {
            let (left, right) = (left.number()?, right.number()?);
            let divides = matches!(operator, Operator::Over | Operator::Div | Operator::Mod);
            if divides && right.known()? == 0.0 {
                return Err("division by zero".to_owned());
            }
            let result = match operator {
                Operator::Plus => left.with(right, |left, right| left + right),
                Operator::Minus => left.with(right, |left, right| left - right),
                Operator::Times => left.with(right, |left, right| left * right),
                Operator::Over => left.with(right, |left, right| left / right),
                Operator::Div => left.divided(right)?,
                Operator::Mod => left.remainder(right)?,
                _ => return Err("expected an arithmetic operator".to_owned()),
            };
            Ok(Value::Num(result))
        }
    }
}
