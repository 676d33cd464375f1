//! Registers and arithmetic of TP programs.

use std::collections::HashMap;

use crate::program::{Assumed, Settings};

/// R[n], and what the job assumes of others.
#[derive(Debug)]
pub(super) struct Registers<'a> {
    settings: &'a Settings,
    numbers: HashMap<i64, f64>,
}

impl<'a> Registers<'a> {
    pub(super) fn new(settings: &'a Settings) -> Self {
        Self { settings, numbers: HashMap::new() }
    }

    pub(super) fn set(&mut self, number: i64, value: Result<f64, String>) {
        match value {
            Ok(value) => drop(self.numbers.insert(number, value)),
            Err(_) => drop(self.numbers.remove(&number)),
        }
    }

    /// What the job assumes of a name.
    pub(super) fn assumed(&self, name: &str) -> Option<Assumed> {
        let name = name.trim().to_lowercase();
        // `di[3:part here]` is DI[3].
        let bare = name.split_once(':').map(|(head, _)| format!("{head}]"));
        let given = |name: &str| self.settings.assume.get(name).copied();
        given(&name).or_else(|| given(&bare?))
    }

    fn get(&self, number: i64) -> Result<f64, String> {
        if let Some(value) = self.numbers.get(&number) {
            return Ok(*value);
        }
        match self.assumed(&format!("R[{number}]")) {
            Some(Assumed::Number(value)) => Ok(value),
            _ => Err(format!(
                "R[{number}] is known only at run time; assume: {{\"R[{number}]\": …}} in the job \
                 can give it"
            )),
        }
    }

    /// A sum of products of numbers and registers.
    pub(super) fn value(&self, text: &str) -> Result<f64, String> {
        let text = text.trim();
        let text = text.strip_prefix('(').and_then(|t| t.strip_suffix(')')).unwrap_or(text);
        let mut rest = text;
        let (mut sum, mut term, mut operator) = (0.0, 0.0, '+');
        loop {
            let (value, behind) = self.operand(rest)?;
            match operator {
                '+' => (sum, term) = (sum + term, value),
                '-' => (sum, term) = (sum + term, -value),
                '*' => term *= value,
                _ if value == 0.0 => return Err("division by zero".to_owned()),
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
                _ => return Err(format!("'{rest}' is not understood in an expression")),
            };
            operator = op;
            rest = rest.get(length..).unwrap_or("");
        }
        let value: f64 = sum + term;
        if value.is_finite() { Ok(value) } else { Err("the result is not finite".to_owned()) }
    }

    fn operand<'t>(&self, text: &'t str) -> Result<(f64, &'t str), String> {
        let text = text.trim_start();
        if let Some(rest) = text.strip_prefix('(') {
            let close = rest.find(')').ok_or("expected ')'")?;
            let inner = rest.get(..close).unwrap_or("");
            // One level, as the teach pendant writes it.
            if inner.contains('(') {
                return Err("nested parentheses are not understood".to_owned());
            }
            return Ok((self.value(inner)?, rest.get(close + 1..).unwrap_or("")));
        }
        if let Some(rest) = text.strip_prefix('-') {
            return self.operand(rest).map(|(value, rest)| (-value, rest));
        }
        if let Some((number, rest)) = register(text, "R") {
            return Ok((self.get(number)?, rest));
        }
        let digits = text.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        if digits > 0 {
            let value = text.get(..digits).and_then(|text| text.parse().ok());
            let value = value.ok_or_else(|| format!("'{text}' is no number"))?;
            return Ok((value, text.get(digits..).unwrap_or("")));
        }
        match self.assumed(text) {
            Some(Assumed::Number(value)) => Ok((value, "")),
            Some(Assumed::Truth(value)) => Ok((f64::from(u8::from(value)), "")),
            None => Err(format!("'{}' is known only at run time", text.trim())),
        }
    }

    /// A condition: a comparison of values, or an input that the job assumes; joined by AND or OR.
    pub(super) fn truth(&self, text: &str) -> Result<bool, String> {
        let text = text.trim();
        let text = text.strip_prefix('(').and_then(|t| t.strip_suffix(')')).unwrap_or(text);
        for (joint, decides) in [(" OR ", true), (" AND ", false)] {
            if let Some((left, right)) = text.split_once(joint) {
                let (left, right) = (self.truth(left), self.truth(right));
                return match (left, right) {
                    (Ok(value), _) | (_, Ok(value)) if value == decides => Ok(decides),
                    (Ok(_), Ok(_)) => Ok(!decides),
                    (Err(why), _) | (_, Err(why)) => Err(why),
                };
            }
        }
        if let Some(inner) = text.strip_prefix('!') {
            return self.truth(inner).map(|value| !value);
        }
        for operator in ["<>", "<=", ">=", "=", "<", ">"] {
            if let Some((left, right)) = text.split_once(operator) {
                return self.compare(operator, left.trim(), right.trim());
            }
        }
        match self.assumed(text) {
            Some(Assumed::Truth(value)) => Ok(value),
            _ => Err(format!("'{text}' is known only at run time")),
        }
    }

    fn compare(&self, operator: &str, left: &str, right: &str) -> Result<bool, String> {
        if let "ON" | "OFF" = right {
            let known = match self.assumed(left) {
                Some(Assumed::Truth(value)) => value,
                Some(Assumed::Number(value)) => value != 0.0,
                None => {
                    return Err(format!(
                        "{left} is known only at run time; assume: {{\"{left}\": …}} in the job \
                         can give it"
                    ));
                }
            };
            return Ok((known == (right == "ON")) == (operator == "="));
        }
        let (left, right) = (self.value(left)?, self.value(right)?);
        Ok(match operator {
            "=" => left == right,
            "<>" => left != right,
            "<" => left < right,
            "<=" => left <= right,
            ">" => left > right,
            _ => left >= right,
        })
    }
}

fn starts_with(text: &str, word: &str) -> bool {
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// `R[5:comment]` at the start of a text: the number, and what follows.
pub(super) fn register<'t>(text: &'t str, name: &str) -> Option<(i64, &'t str)> {
    let rest = text.strip_prefix(name)?.strip_prefix('[')?;
    let close = rest.find(']')?;
    let inside = rest.get(..close)?;
    let number = inside.split([':', ',']).next()?.trim().parse().ok()?;
    Some((number, rest.get(close + 1..)?))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(registers.value("R[4]").unwrap_err().contains("only at run time"));
        assert_eq!(registers.truth("DI[1]=ON"), Ok(true));
        assert_eq!(registers.truth("(R[3]<>7 OR DI[1]=ON)"), Ok(true));
        assert!(registers.truth("DI[2]=ON").is_err());
    }
}
