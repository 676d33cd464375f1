//! Expressions of G-code: `#1`, `#<depth>`, `[#1 + 2]`, `R1`.

use super::abbreviated::whole;
use super::comments::behind_comment;
use super::parameters::{Key, Parameters};
use super::words::is_r_parameter;
use crate::program::functions::function;
use crate::program::span::Span;
use crate::units::deg_from_rad;

/// Expressions in one another beyond this are refused.
const MAX_DEPTH: usize = 40;

/// Reads numbers and expressions from a line.
pub(super) struct Reader<'t> {
    pub(super) bytes: &'t [u8],
    pub(super) at: usize,
    pub(super) parameters: &'t Parameters,
    depth: usize,
    /// Parentheses hold comments, not terms.
    has_comments: bool,
    /// Those that were read.
    pub(super) read: Vec<Key>,
    /// What joins the terms of the brackets that are open.
    joined: Joined,
}

/// Operators beside each other.
#[derive(Debug, Clone, Copy, Default)]
struct Joined {
    /// `<`, `==` and the like.
    by_symbol: bool,
    /// AND, OR, XOR.
    by_word: bool,
}

impl<'t> Reader<'t> {
    pub(super) fn new(bytes: &'t [u8], at: usize, parameters: &'t Parameters) -> Self {
        let (read, joined) = (Vec::new(), Joined::default());
        Self { bytes, at, parameters, depth: 0, has_comments: false, read, joined }
    }

    /// As RS-274 and Fanuc have it; Sinumerik has terms in parentheses.
    pub(super) fn with_comments(self) -> Self {
        Self { has_comments: true, ..self }
    }

    pub(super) fn skip_blanks(&mut self) {
        while let Some(byte) = self.bytes.get(self.at) {
            // One whose end is not clear stays, as what ends the expression.
            let comment = || behind_comment(self.bytes, self.at).ok();
            match (self.has_comments && *byte == b'(').then(comment).flatten() {
                Some(behind) => self.at = behind,
                None if byte.is_ascii_whitespace() => self.at += 1,
                None => return,
            }
        }
    }

    pub(super) fn peek(&mut self) -> Option<u8> {
        self.skip_blanks();
        self.bytes.get(self.at).map(u8::to_ascii_uppercase)
    }

    pub(super) fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, byte: u8) -> Result<(), String> {
        if self.take(byte) {
            Ok(())
        } else if self.has_comments && self.peek() == Some(b'(') {
            behind_comment(self.bytes, self.at).and(Err(NO_NUMBER.to_owned()))
        } else {
            Err(format!("expected '{}' in an expression", char::from(byte)))
        }
    }

    /// The letters at this place, in upper case.
    pub(super) fn letters(&mut self) -> String {
        self.skip_blanks();
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let word = rest.iter().take_while(|byte| byte.is_ascii_alphabetic());
        let word: String = word.map(|byte| char::from(byte.to_ascii_uppercase())).collect();
        self.at += word.len();
        word
    }

    /// `#1`, `#<name>`, `#[1 + 1]`, `##1`: the parameter that is meant, behind its `#`.
    pub(super) fn key(&mut self) -> Result<Key, String> {
        if self.take(b'<') {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let end = rest.iter().position(|&byte| byte == b'>');
            let end = end.ok_or("a parameter's name is not closed")?;
            let name = rest.get(..end).unwrap_or_default();
            let name = name.iter().filter(|byte| !byte.is_ascii_whitespace());
            let name = name.map(|byte| char::from(byte.to_ascii_lowercase())).collect();
            self.at += end + 1;
            return Ok(Key::Name(name));
        }
        let number = self.deeper(Self::primary)?;
        if number.fract() != 0.0 || number.abs() > 1e9 {
            return Err(format!("#{number} is no parameter"));
        }
        Ok(Key::Number(number as i64))
    }

    /// A variable of Sinumerik's: letters, digits and underscores.
    pub(super) fn variable(&mut self) -> String {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let name = rest.iter().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_');
        let name: String = name.map(|byte| char::from(byte.to_ascii_lowercase())).collect();
        self.at += name.len();
        name
    }

    pub(super) fn parameter(&mut self, key: Key) -> Result<f64, String> {
        let value = self.parameters.get(&key);
        self.read.push(key);
        value
    }

    pub(super) fn deeper<T>(
        &mut self,
        inner: impl FnOnce(&mut Self) -> Result<T, String>,
    ) -> Result<T, String> {
        if self.depth >= MAX_DEPTH {
            return Err("the expression is nested too deep".to_owned());
        }
        self.depth += 1;
        let found = inner(self);
        self.depth -= 1;
        found
    }

    /// The number of the text that the expression from `from` to here is, if it is one: as it
    /// stands in the line, or where the one parameter that it names was set to it.
    pub(super) fn place(&self, from: usize, value: f64, offset: Option<usize>) -> Option<Span> {
        let text = std::str::from_utf8(self.bytes.get(from..self.at)?).ok()?;
        let start = from + text.len() - text.trim_start().len();
        let text = text.trim();
        if text.parse() == Ok(value) {
            return Some(Span::new(start, start + text.len()).behind(offset?));
        }
        let is_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '#' | '<' | '>' | '_');
        match &self.read[..] {
            [key] if text.chars().all(is_name) => self.parameters.place(key),
            _ => None,
        }
    }

    /// A number, a parameter, a function or an expression in brackets, with its sign.
    pub(super) fn primary(&mut self) -> Result<f64, String> {
        match self.peek() {
            Some(b'-') => {
                self.at += 1;
                self.deeper(Self::primary).map(|value| -value)
            }
            Some(b'+') => {
                self.at += 1;
                self.deeper(Self::primary)
            }
            Some(b'#') => {
                self.at += 1;
                let key = self.deeper(Self::key)?;
                self.parameter(key)
            }
            Some(b'(') if self.has_comments => {
                behind_comment(self.bytes, self.at).and(Err(NO_NUMBER.to_owned()))
            }
            Some(open @ (b'[' | b'(')) => {
                self.at += 1;
                let outside = std::mem::take(&mut self.joined);
                let value = self.deeper(|reader| reader.binary(0))?;
                self.joined = outside;
                self.expect(if open == b'[' { b']' } else { b')' })?;
                Ok(value)
            }
            Some(byte) if byte.is_ascii_digit() || byte == b'.' => self.number(),
            Some(b'_') => self.of_variable(),
            Some(b'$') if self.parameters.is_sinumerik() => self.of_control(),
            Some(byte) if byte.is_ascii_alphabetic() => self.function(),
            _ => Err(NO_NUMBER.to_owned()),
        }
    }

    /// Digits and a point, with the exponent that Sinumerik writes `EX-5`.
    fn number(&mut self) -> Result<f64, String> {
        let start = self.at;
        while self.bytes.get(self.at).is_some_and(|&b| b.is_ascii_digit() || b == b'.') {
            self.at += 1;
        }
        let digits = self.bytes.get(start..self.at).unwrap_or_default();
        let digits = std::str::from_utf8(digits).unwrap_or_default();
        let exponent = self.exponent().unwrap_or("0");
        let parsed = format!("{digits}e{exponent}").parse::<f64>();
        parsed.ok().filter(|number| number.is_finite()).ok_or_else(|| NO_NUMBER.to_owned())
    }

    fn exponent(&mut self) -> Option<&str> {
        let rest = self.bytes.get(self.at..).filter(|_| self.parameters.is_sinumerik())?;
        let (mark, behind) = rest.split_at_checked(2)?;
        let sign = usize::from(behind.first().is_some_and(|byte| b"+-".contains(byte)));
        let digits = behind.iter().skip(sign).take_while(|byte| byte.is_ascii_digit()).count();
        let own = behind.get(..sign + digits).filter(|_| digits > 0)?;
        if !mark.eq_ignore_ascii_case(b"EX") {
            return None;
        }
        self.at += 2 + own.len();
        std::str::from_utf8(own).ok()
    }

    fn function(&mut self) -> Result<f64, String> {
        let before = self.at;
        let variable = Key::Name(self.variable());
        let is_call = matches!(self.bytes.get(self.at), Some(b'[' | b'('));
        if !(is_call || variable.name().is_ok_and(is_r_parameter))
            && let Ok(value) = self.parameters.get(&variable)
        {
            self.read.push(variable);
            return Ok(value);
        }
        self.at = before;
        let letters = self.letters();
        let is_sinumerik = self.parameters.is_sinumerik();
        let name: &str = if is_sinumerik { &letters } else { whole(&letters) };
        if matches!(name, "TRUE" | "FALSE") {
            return Ok(if name == "TRUE" { 1.0 } else { 0.0 });
        }
        if name == "NOT" && is_sinumerik {
            return self.negated();
        }
        if name == "R" && self.bytes.get(self.at).is_some_and(u8::is_ascii_digit) {
            let number = self.number()?;
            return self.parameter(Key::Name(format!("r{number}")));
        }
        if name == "R" && is_sinumerik && self.bytes.get(self.at) == Some(&b'[') {
            let key = self.indexed("r".to_owned())?;
            return self.parameter(key);
        }
        if name == "EXISTS" {
            return self.exists();
        }
        let of_degrees: fn(f64) -> f64 = match name {
            "TRUNC" if is_sinumerik => f64::trunc,
            "POT" if is_sinumerik => |x| x * x,
            "ROUNDUP" if is_sinumerik => f64::ceil,
            "MINVAL" | "MAXVAL" | "BOUND" if is_sinumerik => return self.bounded(name),
            "BIN" | "BCD" if !is_sinumerik => return self.recoded(name),
            "FIX" => f64::floor,
            "FUP" => f64::ceil,
            "ROUND" => f64::round,
            "ATAN" if self.bytes.get(self.at) == Some(&b'2') => return self.of_vector(),
            "ATAN" => return self.arc_tangent(),
            other => match function(other) {
                Some(own) => own,
                None if is_sinumerik => {
                    self.at = before;
                    return self.of_variable();
                }
                None => return Err(format!("'{name}' is not understood in an expression")),
            },
        };
        let value = self.deeper(Self::value)?;
        if matches!(name, "FIX" | "FUP") && value < 0.0 && value.fract() != 0.0 {
            return Err(format!(
                "{name}[{value}]: Fanuc rounds towards zero or away from it, LinuxCNC down or up"
            ));
        }
        let value = of_degrees(value);
        if value.is_finite() { Ok(value) } else { Err(format!("{name} has no finite result")) }
    }

    /// Sinumerik's NOT, which binds its term before all operators.
    fn negated(&mut self) -> Result<f64, String> {
        match self.deeper(Self::value)? {
            0.0 => Ok(1.0),
            1.0 => Ok(0.0),
            value => Err(format!("NOT {value}: expected a condition, which is 0 or 1")),
        }
    }

    /// LinuxCNC's `EXISTS[#<name>]`.
    fn exists(&mut self) -> Result<f64, String> {
        self.expect(b'[')?;
        self.expect(b'#')?;
        let key = self.key()?;
        self.expect(b']')?;
        let is_set = self.parameters.get(&key).is_ok();
        if !is_set && key.name().is_ok_and(|name| name.starts_with('_')) {
            let shown = self.parameters.shown(&key);
            return Err(format!("EXISTS: {shown} may be one of the controller's"));
        }
        Ok(if is_set { 1.0 } else { 0.0 })
    }

    /// A primary that is not vacant.
    pub(super) fn value(&mut self) -> Result<f64, String> {
        not_vacant(self.primary()?)
    }

    /// `ATAN[y]/[x]`.
    fn arc_tangent(&mut self) -> Result<f64, String> {
        let y = self.deeper(Self::value)?;
        if !self.take(b'/') {
            return Ok(deg_from_rad(y.atan()));
        }
        let x = self.deeper(Self::value)?;
        Ok(deg_from_rad(y.atan2(x)))
    }

    /// Sinumerik's `ATAN2(y, x)`.
    fn of_vector(&mut self) -> Result<f64, String> {
        self.at += 1;
        self.expect(b'(')?;
        let y = self.deeper(|reader| reader.binary(0))?;
        self.expect(b',')?;
        let x = self.deeper(|reader| reader.binary(0))?;
        self.expect(b')')?;
        Ok(deg_from_rad(not_vacant(y)?.atan2(not_vacant(x)?)))
    }

    pub(super) fn expression(&mut self) -> Result<f64, String> {
        self.deeper(|reader| reader.binary(0))
    }

    fn binary(&mut self, weakest: u8) -> Result<f64, String> {
        let mut left = self.primary()?;
        let mut joined: Option<&str> = None;
        loop {
            let before = self.at;
            let Some((name, strength)) = self.operator().filter(|(_, s)| *s >= weakest) else {
                self.at = before;
                return Ok(left);
            };
            let is_symbol = matches!(self.bytes.get(self.at - 1), Some(b'<' | b'>' | b'='));
            // Fanuc has AND before OR, LinuxCNC takes them as they come.
            if strength == 0 && joined.replace(name).is_some_and(|before| before != name) {
                return Err(format!("{name} beside another of AND, OR and XOR: put brackets"));
            }
            // Sinumerik has comparisons behind AND, others before it.
            self.joined.by_symbol |= is_symbol;
            self.joined.by_word |= strength == 0;
            if self.joined.by_symbol && self.joined.by_word {
                return Err("a comparison beside AND, OR or XOR: put brackets".to_owned());
            }
            let right = self.deeper(|reader| reader.binary(strength + 1))?;
            left = apply(name, left, right)?;
        }
    }

    fn operator(&mut self) -> Option<(&'static str, u8)> {
        let found = match self.peek()? {
            b'*' if self.bytes.get(self.at + 1) == Some(&b'*') => ("**", 4),
            b'*' => ("*", 3),
            b'/' => ("/", 3),
            b'+' => ("+", 2),
            b'-' => ("-", 2),
            // Sinumerik's.
            first @ (b'<' | b'>' | b'=') => {
                let second = self.bytes.get(self.at + 1).copied();
                let (name, length) = match (first, second) {
                    (b'<', Some(b'=')) => ("LE", 2),
                    (b'<', Some(b'>')) => ("NE", 2),
                    (b'<', _) => ("LT", 1),
                    (b'>', Some(b'=')) => ("GE", 2),
                    (b'>', _) => ("GT", 1),
                    (_, Some(b'=')) => ("EQ", 2),
                    _ => return None,
                };
                self.at += length;
                return Some((name, 1));
            }
            byte if byte.is_ascii_alphabetic() => {
                let name = self.letters();
                let is_sinumerik = self.parameters.is_sinumerik();
                let name: &str = if is_sinumerik { &name } else { whole(&name) };
                const NAMED: [(&str, u8); 11] = [
                    ("DIV", 3),
                    ("MOD", 3),
                    ("EQ", 1),
                    ("NE", 1),
                    ("GT", 1),
                    ("GE", 1),
                    ("LT", 1),
                    ("LE", 1),
                    ("AND", 0),
                    ("OR", 0),
                    ("XOR", 0),
                ];
                let is_known = name != "DIV" || is_sinumerik;
                return NAMED.into_iter().find(|(known, _)| *known == name && is_known);
            }
            _ => return None,
        };
        self.at += found.0.len();
        Some(found)
    }
}

const NO_NUMBER: &str = "expected a number in an expression";

/// What is said where a parameter without a value is used as a number.
pub(super) const VACANT: &str = "a parameter that has no value (#0, or a letter that the call \
                                 does not give) stands where a number is expected";

/// Two numbers nearer than this are equal, as LinuxCNC has it.
const EQUAL: f64 = 1e-6;

/// A number that is used as one.
pub(super) fn not_vacant(value: f64) -> Result<f64, String> {
    if value.is_nan() { Err(VACANT.to_owned()) } else { Ok(value) }
}

fn apply(operator: &str, left: f64, right: f64) -> Result<f64, String> {
    let truth = |is_true: bool| if is_true { 1.0 } else { 0.0 };
    let vacant = [left, right].map(f64::is_nan);
    let value = match operator {
        "EQ" if vacant.contains(&true) => truth(vacant[0] == vacant[1]),
        "NE" if vacant.contains(&true) => truth(vacant[0] != vacant[1]),
        _ if vacant.contains(&true) => return Err(VACANT.to_owned()),
        "**" => left.powf(right),
        "*" => left * right,
        "/" | "DIV" | "MOD" if right == 0.0 => return Err("division by zero".to_owned()),
        "/" => left / right,
        // Of whole numbers the result is one, too; nothing says which way others are rounded.
        "DIV" if left.fract() != 0.0 || right.fract() != 0.0 || left * right < 0.0 => {
            return Err(format!("{left} DIV {right}: DIV is read of whole numbers from 0"));
        }
        "DIV" => (left / right).floor(),
        "MOD" if left * right < 0.0 && left % right != 0.0 => {
            return Err(format!(
                "{left} MOD {right}: controllers differ in the sign of the remainder"
            ));
        }
        "MOD" => left % right,
        "+" => left + right,
        "-" => left - right,
        "EQ" => truth((left - right).abs() < EQUAL),
        "NE" => truth((left - right).abs() >= EQUAL),
        "GT" => truth(left > right),
        "GE" => truth(left >= right),
        "LT" => truth(left < right),
        "LE" => truth(left <= right),
        "AND" | "OR" | "XOR" if [left, right].iter().any(|own| *own != 0.0 && *own != 1.0) => {
            return Err(format!(
                "{left} {operator} {right}: Fanuc joins the bits of numbers, LinuxCNC their truth; \
                 write conditions, which are 0 or 1"
            ));
        }
        "AND" => truth(left != 0.0 && right != 0.0),
        "OR" => truth(left != 0.0 || right != 0.0),
        _ => truth((left != 0.0) != (right != 0.0)),
    };
    if value.is_finite() { Ok(value) } else { Err("an expression has no finite result".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_have_the_precedence_of_rs_274() {
        let mut parameters = Parameters::default();
        parameters.set(Key::Number(1), 4.0, None).unwrap();
        parameters.set(Key::Name("depth".to_owned()), -2.5, None).unwrap();
        parameters.set(Key::Number(4), 7.0, None).unwrap();
        for (text, expected) in [
            ("[2 + 3 * 2 ** 3]", 26.0),
            ("[[2+3]*2]", 10.0),
            ("-#1", -4.0),
            ("##1", 7.0),
            ("#[2 + 2]", 7.0),
            ("[#<Depth> * -2]", 5.0),
            ("[-5 MOD -3]", -2.0),
            ("[5 MOD 3]", 2.0),
            ("[-6 MOD 3]", 0.0),
            ("ATAN[1]/[-1]", 135.0),
            ("SIN[30]", 0.5),
            ("[#1 GT 3 AND 1 LE 0]", 0.0),
            ("[10 - 4 - 3]", 3.0),
            ("FIX[-2]", -2.0),
            ("FIX[2.5]", 2.0),
            ("[[1 OR 0] AND 0]", 0.0),
            ("[1 AND 1 AND 0]", 0.0),
            ("[#1 EQ #0]", 0.0),
            ("[#0 NE #1]", 1.0),
            ("[#0 EQ #0]", 1.0),
        ] {
            let found = Reader::new(text.as_bytes(), 0, &parameters).primary().unwrap();
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
        }
        for (text, said) in [
            ("#2", "#2 is read"),
            ("[#0 + 1]", "no value"),
            ("ATAN[#0]", "no value"),
            ("FIX[-2.5]", "FIX[-2.5]"),
            ("[-5 MOD 3]", "-5 MOD 3"),
            ("[1 OR 0 AND 0]", "put brackets"),
            ("[1/0]", "division by zero"),
            ("[1", "expected ']'"),
            ("FOO[1]", "'FOO'"),
            ("SQRT[-1]", "no finite"),
        ] {
            let why = Reader::new(text.as_bytes(), 0, &parameters).primary().unwrap_err();
            assert!(why.contains(said), "{text}: {why}");
        }
        let deep = "[".repeat(1000);
        assert!(Reader::new(deep.as_bytes(), 0, &parameters).primary().is_err());
    }
}
