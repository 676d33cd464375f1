//! What Q parameters are set to: formulas, and the functions FN 0 to FN 8 and FN 13 (HEIDENHAIN,
//! TNC 640 Conversational Programming, "Programming Q parameters").

use std::collections::BTreeSet;

use super::Reader;
use super::block::{Block, Parameters};
use crate::program::functions::function;
use crate::program::span::{Held, Span};
use crate::program::unread::read_of_lost;
use crate::units::deg_from_rad;

/// Terms in one another beyond this are refused.
const MAX_DEPTH: usize = 40;

/// Parameters of a program's own, those that the control keeps, and texts.
pub(super) const OTHER_KINDS: [&str; 3] = ["QL", "QR", "QS"];
pub(super) const OTHERS: &str =
    "QL, QR and QS parameters are not read: have Q parameters with a number alone written";

/// The radius of the tool in the spindle, with DR.
pub(super) const RADIUS: u32 = 108;
pub(super) const OF_TOOL: &str = "Q108 is the tool's radius, which TOOL CALL takes from the \
     control's tool table: assume: {Q108: 5} in the job gives that of the first tool alone, and \
     holds up to a call of another tool or with another DR";

impl Reader<'_, '_> {
    /// `Q2 = Q1 + 68`, also behind `FN 1:`.
    pub(super) fn assign(&mut self, text: &str, block: &Block<'_>) -> Result<(), String> {
        let (name, formula) = text.split_once('=').ok_or("a Q parameter without '='")?;
        let digits = name.trim().strip_prefix(['Q', 'q']).unwrap_or("");
        if digits.starts_with(['L', 'R', 'S', 'l', 'r', 's']) {
            return Err(OTHERS.to_owned());
        }
        let number = digits.parse::<u32>();
        let number = number.map_err(|_| format!("'{}' is no Q parameter", name.trim()))?;
        let value = self.value_of(formula);
        // What a formula that is not read would have set is not known.
        self.parameters.remove(&number);
        self.lost.insert(number);
        self.given.close(number);
        if self.cycle.as_ref().is_some_and(|cycle| cycle.has(number)) {
            return Err(format!("Q{number} of a cycle that is defined is changed: not supported"));
        }
        let value = value?;
        let is_number = formula.replace(',', ".").trim().parse() == Ok(value);
        let word = block.words.iter().find(|word| word.name.strip_prefix('Q') == Some(digits));
        let span = word.filter(|_| is_number).and_then(|word| word.span);
        let sign = usize::from(formula.trim_start().starts_with('+'));
        let span = span.map(|span| Span::new(span.start + sign, span.end));
        self.parameters.insert(number, Held { value, span });
        self.lost.remove(&number);
        Ok(())
    }

    pub(super) fn value_of(&self, formula: &str) -> Result<f64, String> {
        value_of(formula, &self.parameters, &self.lost)
    }
}

/// The value of a formula. Decimal commas are points.
fn value_of(text: &str, known: &Parameters, lost: &BTreeSet<u32>) -> Result<f64, String> {
    let mut reader = Formula { bytes: text.as_bytes(), at: 0, known, lost, depth: 0 };
    let value = reader.sum()?;
    match reader.peek() {
        None if value.is_finite() => Ok(value),
        None => Err("the formula has no finite result".to_owned()),
        Some(byte) => Err(format!("'{}' is not understood in a formula", char::from(byte))),
    }
}

struct Formula<'t> {
    bytes: &'t [u8],
    at: usize,
    known: &'t Parameters,
    /// Those that a refused block would have set.
    lost: &'t BTreeSet<u32>,
    depth: usize,
}

impl Formula<'_> {
    fn peek(&mut self) -> Option<u8> {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
        self.bytes.get(self.at).map(u8::to_ascii_uppercase)
    }

    fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.at += usize::from(found);
        found
    }

    fn letters(&mut self) -> String {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let word = rest.iter().take_while(|byte| byte.is_ascii_alphabetic());
        let word: String = word.map(|byte| char::from(byte.to_ascii_uppercase())).collect();
        self.at += word.len();
        word
    }

    fn sum(&mut self) -> Result<f64, String> {
        let mut value = self.product()?;
        loop {
            match self.peek() {
                Some(b'+') => {
                    self.at += 1;
                    value += self.product()?;
                }
                Some(b'-') => {
                    self.at += 1;
                    value -= self.product()?;
                }
                _ => return Ok(value),
            }
        }
    }

    fn product(&mut self) -> Result<f64, String> {
        let mut value = self.power()?;
        loop {
            let before = self.at;
            let operator = match self.peek() {
                Some(b'*') => {
                    self.at += 1;
                    "*".to_owned()
                }
                Some(b'/') => {
                    self.at += 1;
                    "DIV".to_owned()
                }
                Some(b'%') => {
                    self.at += 1;
                    "%".to_owned()
                }
                Some(byte) if byte.is_ascii_alphabetic() => self.letters(),
                _ => return Ok(value),
            };
            if !matches!(operator.as_str(), "*" | "%" | "DIV" | "LEN" | "ANG") {
                self.at = before;
                return Ok(value);
            }
            let by = self.power()?;
            value = match operator.as_str() {
                "*" => value * by,
                "DIV" | "%" if by == 0.0 => return Err("division by zero".to_owned()),
                "DIV" => value / by,
                "%" if value < 0.0 || by < 0.0 => {
                    return Err(format!("{value} % {by}: the remainder is read of numbers from 0"));
                }
                "%" => value % by,
                "LEN" => value.hypot(by),
                // FN 13: of the first over the second, from 0 to 360.
                _ => deg_from_rad(value.atan2(by)).rem_euclid(360.0),
            };
        }
    }

    fn power(&mut self) -> Result<f64, String> {
        let base = self.term()?;
        if self.take(b'^') { Ok(base.powf(self.deeper(Self::power)?)) } else { Ok(base) }
    }

    fn deeper(&mut self, inner: fn(&mut Self) -> Result<f64, String>) -> Result<f64, String> {
        if self.depth >= MAX_DEPTH {
            return Err("the formula is nested too deep".to_owned());
        }
        self.depth += 1;
        let found = inner(self);
        self.depth -= 1;
        found
    }

    fn term(&mut self) -> Result<f64, String> {
        match self.peek() {
            Some(b'-') => {
                self.at += 1;
                self.deeper(Self::term).map(|value| -value)
            }
            Some(b'+') => {
                self.at += 1;
                self.deeper(Self::term)
            }
            Some(b'(') => {
                self.at += 1;
                let value = self.deeper(Self::sum)?;
                if self.take(b')') { Ok(value) } else { Err("expected ')' in a formula".into()) }
            }
            Some(byte) if byte.is_ascii_digit() || matches!(byte, b'.' | b',') => self.number(),
            Some(byte) if byte.is_ascii_alphabetic() => self.named(),
            _ => Err("expected a number in a formula".to_owned()),
        }
    }

    fn number(&mut self) -> Result<f64, String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let digits = rest.iter().take_while(|b| b.is_ascii_digit() || matches!(b, b'.' | b','));
        let text: String = digits.map(|b| if *b == b',' { '.' } else { char::from(*b) }).collect();
        self.at += text.len();
        text.parse().map_err(|_| format!("'{text}' is no number"))
    }

    /// A parameter or a function.
    fn named(&mut self) -> Result<f64, String> {
        let name = self.letters();
        let own: fn(f64) -> f64 = match name.as_str() {
            "Q" => return self.parameter(),
            other if OTHER_KINDS.contains(&other) => return Err(OTHERS.to_owned()),
            "PI" => return Ok(std::f64::consts::PI),
            "ATAN" => |x| deg_from_rad(x.atan()),
            "SQ" => |x| x * x,
            "LOG" => f64::log10,
            "NEG" => |x| -x,
            "INT" => f64::trunc,
            "FRAC" => f64::fract,
            "SGN" => f64::signum,
            other => {
                function(other).ok_or_else(|| format!("'{name}' is not understood in a formula"))?
            }
        };
        let term = self.deeper(Self::term)?;
        if name == "SGN" && term == 0.0 {
            return Err("SGN 0: the sign is 1 on older controls and 0 on newer ones".to_owned());
        }
        let value = own(term);
        if value.is_finite() { Ok(value) } else { Err(format!("{name} has no finite result")) }
    }

    fn parameter(&mut self) -> Result<f64, String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit());
        let digits: String = digits.map(|byte| char::from(*byte)).collect();
        self.at += digits.len();
        let number = digits.parse::<u32>().ok();
        let value = number.and_then(|number| self.known.get(&number)).map(|held| held.value);
        value.ok_or_else(|| match number {
            Some(number) if self.lost.contains(&number) => read_of_lost(&format!("Q{number}")),
            Some(RADIUS) => OF_TOOL.to_owned(),
            _ => format!("Q{digits} is read, and the program has not set it"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_as_the_manual_has_them() {
        let known = [(1, 10.0), (2, -4.0), (12, 3.5)];
        let known =
            Parameters::from(known.map(|(number, value)| (number, Held::worked_out(value))));
        for (text, expected) in [
            ("Q1 - 3", 7.0),
            ("- 3", -3.0),
            ("-Q2 + -5", -1.0),
            ("5 * 3 + 2 * Q1", 35.0),
            ("SQ Q1 - 3 ^ 3", 73.0),
            ("( Q1 + 2 ) / Q2", -3.0),
            ("+4 DIV +Q2", -1.0),
            ("+3 LEN +4", 5.0),
            ("400 % 360", 40.0),
            ("+10 ANG -Q1", 135.0),
            ("SQRT 16 * SIN 30", 2.0),
            ("INT Q12 + FRAC Q12", 3.5),
            ("NEG ( ABS Q2 )", -4.0),
            ("SGN Q2 * SGN Q12", -1.0),
            ("1,5 * PI", 1.5 * std::f64::consts::PI),
        ] {
            let found = value_of(text, &known, &BTreeSet::new()).unwrap();
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
        }
        for (text, said) in [
            ("Q3 + 1", "Q3 is read"),
            ("1 / 0", "division by zero"),
            ("-1 % 3", "numbers from 0"),
            ("( 1", "expected ')'"),
            ("1 )", "')' is not understood"),
            ("FOO 1", "'FOO'"),
            ("SQRT -1", "no finite"),
            ("SGN ( Q1 - 10 )", "SGN 0"),
            ("1.2.3", "no number"),
        ] {
            let why = value_of(text, &known, &BTreeSet::new()).unwrap_err();
            assert!(why.contains(said), "{text}: {why}");
        }
        assert!(value_of(&"(".repeat(100_000), &known, &BTreeSet::new()).is_err());
    }
}
