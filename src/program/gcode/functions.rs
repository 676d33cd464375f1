//! Functions that one kind of control alone has.

use super::expression::{Reader, not_vacant};

/// Eight digits, as many as Fanuc's variables have.
const MOST_BCD: f64 = 99_999_999.0;

/// 0x99999999, the same digits as hexadecimal ones.
const MOST_BIN: f64 = 2_576_980_377.0;

impl Reader<'_> {
    /// Fanuc: BCD gives the number whose hexadecimal digits are those of a decimal one, BIN goes
    /// back (Fanuc, Series 0i Operator's Manual, "Custom macro", "Arithmetic and logic operation").
    pub(super) fn recoded(&mut self, name: &str) -> Result<f64, String> {
        let value = self.deeper(Self::value)?;
        let wrong = |expected: &str| Err(format!("{name}[{value}]: expected {expected}"));
        let (from, to, most) = match name {
            "BCD" => (10, 16, MOST_BCD),
            _ => (16, 10, MOST_BIN),
        };
        if !(0.0..=most).contains(&value) || value.fract() != 0.0 {
            return wrong(&format!("a whole number from 0 to {most}"));
        }
        // Whole and at most so much, checked above.
        let (mut left, mut place, mut found) = (value as u64, 1, 0);
        while left > 0 {
            let digit = left % from;
            if digit > 9 {
                return wrong("a number whose hexadecimal digits are decimal ones");
            }
            found += digit * place;
            (left, place) = (left / from, place * to);
        }
        // At most 0x99999999.
        Ok(found as f64)
    }

    /// Sinumerik's `MINVAL(a,b)`, `MAXVAL(a,b)` and `BOUND(least,most,value)` (Siemens, SINUMERIK
    /// 840D sl/828D Job Planning, "Minimum, maximum and range of variables").
    pub(super) fn bounded(&mut self, name: &str) -> Result<f64, String> {
        let mut given = Vec::new();
        if self.take(b'(') {
            given.push(not_vacant(self.expression()?)?);
            while self.take(b',') {
                given.push(not_vacant(self.expression()?)?);
            }
        }
        let is_closed = self.take(b')');
        match (name, given.as_slice()) {
            ("MINVAL", [a, b]) if is_closed => Ok(a.min(*b)),
            ("MAXVAL", [a, b]) if is_closed => Ok(a.max(*b)),
            ("BOUND", [least, most, value]) if is_closed && least <= most => {
                Ok(value.clamp(*least, *most))
            }
            ("BOUND", [least, most, _]) if is_closed => {
                Err(format!("BOUND: the least is {least}, and the most is {most}"))
            }
            ("BOUND", _) => Err("BOUND: expected (least, most, value)".to_owned()),
            _ => Err(format!("{name}: expected two values in parentheses")),
        }
    }
}
