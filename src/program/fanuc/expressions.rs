//! Arithmetic and conditions of TP programs.

use super::registers::Registers;
use super::why::{Why, both};
use super::words::{
    bare, brackets, indexed, name_length, nameless, outside, parts_outside, split_outside,
    starts_with,
};
use crate::program::{Assumed, single};
use crate::units::{deg_from_rad, rad_from_deg};

/// Why `PR[GP1:1,7]` is not read.
pub(super) const OF_A_GROUP: &str = "PR[GP…]: elements of a group are not supported";

/// Of brackets that stand without the name of a list before them.
pub(super) fn without_name(part: &str) -> String {
    format!("'{part}' is not understood: expected a name before the '[', such as R[80]")
}

/// A function by its name.
type Function = (&'static str, fn(f64) -> f64);

/// Functions of one number; angles are in degrees.
const FUNCTIONS: [Function; 10] = [
    ("SQRT", f64::sqrt),
    ("SIN", |degrees| rad_from_deg(degrees).sin()),
    ("COS", |degrees| rad_from_deg(degrees).cos()),
    ("TAN", |degrees| rad_from_deg(degrees).tan()),
    ("ASIN", |ratio| deg_from_rad(ratio.asin())),
    ("ACOS", |ratio| deg_from_rad(ratio.acos())),
    ("ATAN", |ratio| deg_from_rad(ratio.atan())),
    ("ABS", f64::abs),
    ("ROUND", f64::round),
    ("TRUNC", f64::trunc),
];

/// A value at the start of a text, if it is known, and what follows.
type Operand<'t> = (Result<f64, Why>, &'t str);

impl Registers<'_> {
    /// A name with the number that its index has now: `DI[R[96]]` is DI[7].
    pub(super) fn resolved(&self, name: &str) -> Result<String, Why> {
        match indexed(name.trim()) {
            Some((list, index)) if !index.contains(',') => {
                Ok(format!("{list}[{}]", self.value(index)?))
            }
            _ => Ok(name.trim().to_owned()),
        }
    }

    /// `PR[1,3]`.
    fn component(&self, inside: &str) -> Result<f64, Why> {
        if inside.starts_with("GP") {
            return Err(OF_A_GROUP.into());
        }
        let (number, index) = split_outside(inside, ",").ok_or("expected PR[n,i]")?;
        let (number, index) = both(self.whole(number), self.whole(index))?;
        self.position(number).element(&format!("PR[{number}]"), index)
    }

    /// A number in brackets: `5`, `R[1]`, `R[2:id]+1`.
    pub(super) fn whole(&self, text: &str) -> Result<i64, Why> {
        /// More no controller has of anything.
        const MAX: f64 = 1e9;
        let text = text.trim();
        if let Ok(number) = text.parse() {
            return Ok(number);
        }
        if text == "..." {
            return Err(
                "'[...]' is a number that was never filled in on the pendant: write it in \
                        the file that is checked"
                    .into(),
            );
        }
        let value = self.value(text)?;
        if value.fract() == 0.0 && value.abs() < MAX {
            Ok(value as i64)
        } else {
            Err(format!("{text} is {value}, expected a whole number").into())
        }
    }

    /// The number of `R[5:comment]` or `PR[R[1]]` at the start of a text, and what follows.
    pub(super) fn numbered<'t>(
        &self,
        text: &'t str,
        name: &str,
    ) -> Result<Option<(i64, &'t str)>, Why> {
        let Some((inside, rest)) = brackets(text, name) else { return Ok(None) };
        Ok(Some((self.whole(inside)?, rest)))
    }

    /// A sum of products of numbers and registers.
    pub(super) fn value(&self, text: &str) -> Result<f64, Why> {
        let text = bare(text)?;
        let mut rest = text;
        let (mut sum, mut term, mut operator) = (0.0, 0.0, '+');
        // All that is not known is told at once.
        let mut unknown = None;
        loop {
            let (value, behind) = self.operand(rest)?;
            let value = value.unwrap_or_else(|why| {
                why.add_to(&mut unknown);
                f64::NAN
            });
            match operator {
                '+' => (sum, term) = (sum + term, value),
                '-' => (sum, term) = (sum + term, -value),
                '*' => term *= value,
                _ if value == 0.0 => return Err("division by zero".into()),
                '%' => term %= value,
                'D' => term = (term / value).trunc(),
                _ => term /= value,
            }
            rest = behind.trim_start();
            let Some(next) = rest.chars().next() else { break };
            let (op, length) = match next {
                '+' | '-' | '*' | '/' => (next, 1),
                _ if starts_with(rest, "MOD") => ('%', 3),
                _ if starts_with(rest, "DIV") => ('D', 3),
                _ => return Err(format!("'{rest}' is not understood in an expression").into()),
            };
            operator = op;
            rest = rest.get(length..).unwrap_or("");
        }
        if let Some(why) = unknown {
            return Err(why);
        }
        let value: f64 = sum + term;
        if value.is_finite() { Ok(value) } else { Err("the result is not finite".into()) }
    }

    fn operand<'t>(&self, text: &'t str) -> Result<Operand<'t>, Why> {
        let unsigned = text.trim_start_matches(['-', ' ', '\t']);
        let signs = text.bytes().take(text.len() - unsigned.len()).filter(|b| *b == b'-');
        let sign = if signs.count() % 2 == 1 { -1.0 } else { 1.0 };
        let (value, rest) = self.unsigned(unsigned)?;
        Ok((value.map(|value| sign * value), rest))
    }

    fn unsigned<'t>(&self, text: &'t str) -> Result<Operand<'t>, Why> {
        if text.starts_with('(') {
            // The one that closes it has nothing open around it.
            let close = outside(text, |depth, rest| depth == 0 && rest.starts_with(')'));
            let close = close.ok_or("expected ')'")?;
            let inner = text.get(1..close).unwrap_or("");
            return Ok((self.value(inner), text.get(close + 1..).unwrap_or("")));
        }
        if let Some((inside, rest)) = brackets(text, "PR") {
            return Ok((self.component(inside), rest));
        }
        if let Some((inside, rest)) = brackets(text, "R") {
            return Ok((self.whole(inside).and_then(|number| self.number(number)), rest));
        }
        let digits = text.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        if digits > 0 {
            let value = text.get(..digits).and_then(|text| text.parse().ok());
            let value = value.ok_or_else(|| format!("'{text}' is no number"))?;
            return Ok((Ok(value), text.get(digits..).unwrap_or("")));
        }
        if let Some((function, (inside, rest))) =
            FUNCTIONS.iter().find_map(|(name, of)| Some((of, brackets(text, name)?)))
        {
            return Ok((self.value(inside).map(function), rest));
        }
        if let Some(part) = nameless(text) {
            return Err(without_name(part).into());
        }
        let (name, rest) = text.split_at(name_length(text));
        if name.is_empty() {
            return Err(format!("'{}' is no value", text.trim()).into());
        }
        if name.contains('[') && !name.ends_with(']') {
            return Err(format!("'{name}' has no ']' behind it").into());
        }
        let value = self.known(name).map(|known| match known {
            Assumed::Number(value) => value,
            Assumed::Truth(value) => f64::from(u8::from(value)),
        });
        Ok((value, rest))
    }

    /// A condition: a comparison of values, or an input that the job assumes; joined by AND or OR.
    pub(super) fn truth(&self, text: &str) -> Result<bool, Why> {
        let text = bare(text)?;
        for (joint, decides) in [(" OR ", true), (" AND ", false)] {
            let parts = parts_outside(text, joint);
            if parts.len() == 1 {
                continue;
            }
            let mut found = Ok(!decides);
            for part in parts {
                match self.truth(part) {
                    Ok(value) if value == decides => return Ok(decides),
                    Err(why) => {
                        found = Err(match found {
                            Err(first) => Why::and(first, why),
                            Ok(_) => why,
                        });
                    }
                    Ok(_) => {}
                }
            }
            return found;
        }
        let inner = text.trim_start_matches(['!', ' ']);
        let signs = text.len() - inner.len();
        if signs > 0 {
            let signs = text.bytes().take(signs).filter(|b| *b == b'!');
            let is_kept = signs.count() % 2 == 0;
            return self.truth(inner).map(|value| value == is_kept);
        }
        for operator in ["<>", "<=", ">=", "=", "<", ">"] {
            if let Some((left, right)) = split_outside(text, operator) {
                return self.compare(operator, left.trim(), right.trim());
            }
        }
        if let "ON" | "OFF" = text {
            return Ok(text == "ON");
        }
        match self.known(text)? {
            Assumed::Truth(value) => Ok(value),
            Assumed::Number(value) => Err(format!(
                "{text} is the number {value}, expected ON or OFF; write true or false where \
                 assume: gives it"
            )
            .into()),
        }
    }

    fn compare(&self, operator: &str, left: &str, right: &str) -> Result<bool, Why> {
        let right = bare(right)?;
        if let "ON" | "OFF" = right {
            let known = match self.known(left)? {
                Assumed::Truth(value) => value,
                Assumed::Number(value) => value != 0.0,
            };
            return Ok((known == (right == "ON")) == (operator == "="));
        }
        // Numbers as the text has them are rounded alike.
        let is_written = |text: &str| text.parse::<f64>().is_ok() || self.place(text).is_some();
        let are_written = is_written(left) && is_written(right);
        let (left, right) = both(self.value(left), self.value(right))?;
        let asks_equal = matches!(operator, "=" | "<>");
        let order = match left.partial_cmp(&right) {
            Some(order) if are_written || asks_equal && order.is_eq() => order,
            _ => single::order(left, right)?,
        };
        Ok(match operator {
            "=" => order.is_eq(),
            "<>" => order.is_ne(),
            "<" => order.is_lt(),
            "<=" => order.is_le(),
            ">" => order.is_gt(),
            _ => order.is_ge(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Settings;

    #[test]
    fn values_and_truths() {
        let mut settings = Settings::default();
        settings.assume.insert("di[1]".to_owned(), Assumed::Truth(true));
        settings.assume.insert("weld_speed".to_owned(), Assumed::Number(8.0));
        let mut registers = Registers::new(&settings);
        registers.set(3, Ok(7.0));
        for (text, expected) in
            [("R[3:a b]*2-1", 13.0), ("(R[3]+1) DIV 3", 2.0), ("-4", -4.0), ("WELD_SPEED", 8.0)]
        {
            assert_eq!(registers.value(text), Ok(expected), "{text}");
        }
        assert!(registers.value("R[4]").unwrap_err().text().contains("only at run time"));
        assert_eq!(registers.truth("DI[1]=ON"), Ok(true));
        assert_eq!(registers.truth("(R[3]<>7 OR DI[1]=ON)"), Ok(true));
        assert!(registers.truth("DI[2]=ON").is_err());
    }
}
