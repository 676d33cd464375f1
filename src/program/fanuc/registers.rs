//! Registers and arithmetic of TP programs.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::position::{Held, POSE};
use crate::program::span::Span;
use crate::program::{Assumed, Settings};

/// Why `PR[GP1:1,7]` is not read.
pub(super) const OF_A_GROUP: &str = "PR[GP…]: elements of a group are not supported";

/// R[n], PR[n], flags and outputs, and what the job assumes of others.
#[derive(Debug)]
pub(super) struct Registers<'a> {
    settings: &'a Settings,
    numbers: HashMap<i64, f64>,
    /// Where the number stands that a register was set to, if it was set to one.
    places: HashMap<i64, Span>,
    /// PR[n] that the program has set, as a whole or in part; shared with what was known at labels.
    positions: HashMap<i64, Rc<Held>>,
    /// What the program has set of flags, markers and outputs, by name: `F[1]`.
    signals: HashMap<String, Assumed>,
    /// What the program sets to what is not known, by name, `f[1]`, or of a list any, `f`: what
    /// the job assumes of it holds no longer.
    forgotten: HashSet<String>,
}

/// What numbers, positions and signals are at a place of the run.
#[derive(Debug, PartialEq)]
pub(super) struct State {
    numbers: HashMap<i64, f64>,
    positions: HashMap<i64, Rc<Held>>,
    signals: HashMap<String, Assumed>,
}

/// What a condition asks for.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Asked {
    /// R[n].
    Number(i64),
    /// PR[n], in any of its elements.
    Position(i64),
    /// A flag or an output by its name.
    Signal(String),
    /// By an index that the run works out.
    Any,
}

impl State {
    /// Whether what is asked for is the same in another state.
    pub(super) fn is_same(&self, other: &Self, asked: &[Asked]) -> bool {
        asked.iter().all(|asked| match asked {
            Asked::Number(number) => self.numbers.get(number) == other.numbers.get(number),
            Asked::Position(number) => self.positions.get(number) == other.positions.get(number),
            Asked::Signal(name) => self.signals.get(name) == other.signals.get(name),
            Asked::Any => self == other,
        })
    }
}

/// What a statement asks for, if it decides: `IF R[1:parts]>=3 OR F[2],JMP LBL[9]`, a case of a
/// SELECT.
pub(super) fn names_asked(text: &str) -> Vec<Asked> {
    if !["IF", "SELECT", "WAIT", "="].iter().any(|own| starts_with(text, own)) {
        return Vec::new();
    }
    let asked = names_in(text).into_iter().filter_map(|name| {
        let (list, index) = indexed(name)?;
        let index = if list == "PR" { index.split(',').next().unwrap_or(index) } else { index };
        Some(match (list, index.trim().parse::<i64>()) {
            ("LBL", _) => return None,
            (_, Err(_)) => Asked::Any,
            ("R", Ok(number)) => Asked::Number(number),
            ("PR", Ok(number)) => Asked::Position(number),
            (list, Ok(number)) => Asked::Signal(format!("{list}[{number}]")),
        })
    });
    asked.collect()
}

/// The names in a condition, of signals, registers and labels: `DI[1:part]=ON AND !DO[2]`.
pub(super) fn names_in(condition: &str) -> Vec<&str> {
    let (mut names, mut from) = (Vec::new(), 0);
    // Never true: every place is looked at once, but those within brackets.
    outside(condition, |_, rest| {
        let next = condition.len() - rest.len() + rest.chars().next().map_or(0, char::len_utf8);
        if rest.starts_with(']') {
            names.extend(condition.get(from..next));
        }
        if !rest.starts_with(|c: char| c.is_ascii_alphanumeric()) {
            from = next;
        }
        false
    });
    names
}

impl<'a> Registers<'a> {
    pub(super) fn new(settings: &'a Settings) -> Self {
        Self {
            settings,
            numbers: HashMap::new(),
            places: HashMap::new(),
            positions: HashMap::new(),
            signals: HashMap::new(),
            forgotten: HashSet::new(),
        }
    }

    /// What conditions look at, as far as it is known.
    pub(super) fn state(&self) -> State {
        State {
            numbers: self.numbers.clone(),
            positions: self.positions.clone(),
            signals: self.signals.clone(),
        }
    }

    /// Where the number stands that a text gives as a register that holds it: `R[2:speed]`.
    pub(super) fn place(&self, text: &str) -> Option<Span> {
        let (number, rest) = self.numbered(text.trim(), "R").ok()??;
        rest.trim().is_empty().then(|| self.places.get(&number).copied())?
    }

    /// R[n] is set to a number that stands in the text.
    pub(super) fn set_from(&mut self, number: i64, value: Result<f64, String>, at: Option<Span>) {
        self.set(number, value);
        if let Some(at) = at {
            self.places.insert(number, at);
        }
    }

    pub(super) fn set(&mut self, number: i64, value: Result<f64, String>) {
        self.places.remove(&number);
        match value {
            Ok(value) => drop(self.numbers.insert(number, value)),
            Err(_) => {
                self.numbers.remove(&number);
                self.forgotten.insert(format!("r[{number}]"));
            }
        }
    }

    /// What the job assumes of a name.
    pub(super) fn assumed(&self, name: &str) -> Option<Assumed> {
        let name = name.trim().to_lowercase();
        let bare = without_comment(&name);
        let given = [&name, &bare].into_iter().find_map(|own| self.settings.assume.get(own));
        given.copied().filter(|_| !self.is_forgotten(&bare))
    }

    /// Whether the program has set a name, in lower case, to what is not known.
    fn is_forgotten(&self, name: &str) -> bool {
        let list = name.split('[').next().unwrap_or(name);
        [name, list].into_iter().any(|own| self.forgotten.contains(own))
    }

    /// Why a name is not known, and what may help.
    fn unknown(&self, name: &str) -> String {
        let name = &without_comment(name.trim());
        if self.is_forgotten(&name.trim().to_lowercase()) {
            format!("{name} is set to what is known only at run time")
        } else {
            format!(
                "{name} is known only at run time; assume: {{\"{name}\": …}} in the job can give it"
            )
        }
    }

    /// What the program has set a flag or an output to, else what the job assumes of it.
    fn known(&self, name: &str) -> Option<Assumed> {
        let own = indexed(name.trim())
            .and_then(|(list, index)| Some(format!("{list}[{}]", self.value(index).ok()?)));
        let set = own.and_then(|own| self.signals.get(&own).copied());
        set.or_else(|| self.assumed(name))
    }

    /// `F[1]=(DI[2] AND R[3]=1)`, `DO[4]=ON`: what the run alone knows is what the job assumes.
    pub(super) fn set_signal(&mut self, name: &str, value: &str) {
        let Some((list, index)) = indexed(name.trim()) else { return };
        let Ok(number) = self.value(index) else {
            // Any of them may be set.
            self.signals.retain(|key, _| indexed(key).is_none_or(|(other, _)| other != list));
            self.forgotten.insert(list.to_lowercase());
            return;
        };
        let value = value.trim();
        let truth = self.truth(value).map(Assumed::Truth);
        let found = truth.or_else(|_| self.value(value).map(Assumed::Number));
        let key = format!("{list}[{number}]");
        match found {
            Ok(value) => drop(self.signals.insert(key, value)),
            Err(_) => {
                self.signals.remove(&key);
                self.forgotten.insert(key.to_lowercase());
            }
        }
    }

    /// What a signal is set to is known no longer.
    pub(super) fn forget_signal(&mut self, name: &str) {
        self.set_signal(name, "");
    }

    /// What PR[n] holds: what the program has set it to, before that what the job assumes.
    pub(super) fn position(&self, number: i64) -> Held {
        match self.positions.get(&number) {
            Some(held) => Held::clone(held),
            None => self.assumed_position(number),
        }
    }

    /// What the job says of PR[n], which the program has not set: its elements, `PR[n,3]`, or that
    /// all others are zero.
    fn assumed_position(&self, number: i64) -> Held {
        let mut held =
            if self.is_assumed_zero(number) { Held::assumed_zero() } else { Held::unset() };
        for index in 1..=POSE.len() as i64 {
            if let Some(Assumed::Number(value)) = self.assumed(&format!("PR[{number},{index}]")) {
                // The index is one of the six.
                drop(held.give(index, value));
            }
        }
        held
    }

    /// Whether the job assumes that PR[n] is zero.
    pub(super) fn is_assumed_zero(&self, number: i64) -> bool {
        self.assumed(&format!("PR[{number}]")) == Some(Assumed::Number(0.0))
    }

    /// PR[n] as a whole.
    pub(super) fn set_position(&mut self, number: i64, held: Held) {
        self.positions.insert(number, Rc::new(held));
    }

    /// An element of PR[n].
    pub(super) fn set_element(
        &mut self,
        number: i64,
        index: i64,
        value: Result<f64, String>,
    ) -> Result<(), String> {
        let mut held = self.position(number);
        held.set(index, value)?;
        self.set_position(number, held);
        Ok(())
    }

    /// `PR[1,3]`.
    fn component(&self, inside: &str) -> Result<f64, String> {
        if inside.starts_with("GP") {
            return Err(OF_A_GROUP.to_owned());
        }
        let (number, index) = split_outside(inside, ",").ok_or("expected PR[n,i]")?;
        let (number, index) = (self.whole(number)?, self.whole(index)?);
        self.position(number).element(&format!("PR[{number}]"), index)
    }

    /// A number in brackets: `5`, `R[1]`, `R[2:id]+1`.
    pub(super) fn whole(&self, text: &str) -> Result<i64, String> {
        /// More no controller has of anything.
        const MAX: f64 = 1e9;
        let text = text.trim();
        if let Ok(number) = text.parse() {
            return Ok(number);
        }
        let value = self.value(text)?;
        if value.fract() == 0.0 && value.abs() < MAX {
            Ok(value as i64)
        } else {
            Err(format!("{text} is {value}, expected a whole number"))
        }
    }

    /// The number of `R[5:comment]` or `PR[R[1]]` at the start of a text, and what follows.
    pub(super) fn numbered<'t>(
        &self,
        text: &'t str,
        name: &str,
    ) -> Result<Option<(i64, &'t str)>, String> {
        let Some((inside, rest)) = brackets(text, name) else { return Ok(None) };
        Ok(Some((self.whole(inside)?, rest)))
    }

    fn get(&self, number: i64) -> Result<f64, String> {
        if let Some(value) = self.numbers.get(&number) {
            return Ok(*value);
        }
        match self.assumed(&format!("R[{number}]")) {
            Some(Assumed::Number(value)) => Ok(value),
            _ => Err(self.unknown(&format!("R[{number}]"))),
        }
    }

    /// A sum of products of numbers and registers.
    pub(super) fn value(&self, text: &str) -> Result<f64, String> {
        let text = bare(text)?;
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
        let unsigned = text.trim_start_matches(['-', ' ', '\t']);
        let signs = text.bytes().take(text.len() - unsigned.len()).filter(|b| *b == b'-');
        let sign = if signs.count() % 2 == 1 { -1.0 } else { 1.0 };
        self.unsigned(unsigned).map(|(value, rest)| (sign * value, rest))
    }

    fn unsigned<'t>(&self, text: &'t str) -> Result<(f64, &'t str), String> {
        if text.starts_with('(') {
            // The one that closes it has nothing open around it.
            let close = outside(text, |depth, rest| depth == 0 && rest.starts_with(')'));
            let close = close.ok_or("expected ')'")?;
            let inner = text.get(1..close).unwrap_or("");
            return Ok((self.value(inner)?, text.get(close + 1..).unwrap_or("")));
        }
        if let Some((inside, rest)) = brackets(text, "PR") {
            return Ok((self.component(inside)?, rest));
        }
        if let Some((number, rest)) = self.numbered(text, "R")? {
            return Ok((self.get(number)?, rest));
        }
        let digits = text.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        if digits > 0 {
            let value = text.get(..digits).and_then(|text| text.parse().ok());
            let value = value.ok_or_else(|| format!("'{text}' is no number"))?;
            return Ok((value, text.get(digits..).unwrap_or("")));
        }
        let (name, rest) = text.split_at(name_length(text));
        match self.known(name) {
            Some(Assumed::Number(value)) => Ok((value, rest)),
            Some(Assumed::Truth(value)) => Ok((f64::from(u8::from(value)), rest)),
            None if name.is_empty() => Err(format!("'{}' is no value", text.trim())),
            None => Err(self.unknown(name)),
        }
    }

    /// A condition: a comparison of values, or an input that the job assumes; joined by AND or OR.
    pub(super) fn truth(&self, text: &str) -> Result<bool, String> {
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
                    Err(why) if found.is_ok() => found = Err(why),
                    _ => {}
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
        match self.known(text) {
            Some(Assumed::Truth(value)) => Ok(value),
            _ => Err(self.unknown(text)),
        }
    }

    fn compare(&self, operator: &str, left: &str, right: &str) -> Result<bool, String> {
        let right = bare(right)?;
        if let "ON" | "OFF" = right {
            let known = match self.known(left) {
                Some(Assumed::Truth(value)) => value,
                Some(Assumed::Number(value)) => value != 0.0,
                None => return Err(self.unknown(left)),
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

pub(super) fn starts_with(text: &str, word: &str) -> bool {
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// What stands in the parentheses that hold the whole text.
pub(super) fn bare(text: &str) -> Result<&str, String> {
    /// More is no program that a teach pendant writes.
    const MAX_NESTING: usize = 20;
    let mut text = text.trim();
    let mut brackets = 0_usize;
    let is_too_deep = text.bytes().any(|byte| {
        match byte {
            b'[' => brackets += 1,
            b']' => brackets = brackets.saturating_sub(1),
            _ => {}
        }
        brackets > MAX_NESTING
    });
    if is_too_deep || outside(text, |depth, _| depth > MAX_NESTING).is_some() {
        return Err("parentheses are nested too deep".to_owned());
    }
    while text.starts_with('(')
        && outside(text, |depth, rest| depth == 0 && rest.starts_with(')')) == Some(text.len() - 1)
    {
        text = text.get(1..text.len() - 1).unwrap_or("").trim();
    }
    Ok(text)
}

/// The first place at which a test of the parentheses that are open there, and of what follows,
/// holds; a closing one counts as behind them. What stands in brackets, comments in them, is passed
/// over.
pub(super) fn outside(text: &str, mut is_it: impl FnMut(usize, &str) -> bool) -> Option<usize> {
    let (mut depth, mut brackets) = (0_usize, 0_usize);
    for (at, c) in text.char_indices() {
        match c {
            '[' => brackets += 1,
            ']' => brackets = brackets.saturating_sub(1),
            '(' if brackets == 0 => depth += 1,
            ')' if brackets == 0 => depth = depth.saturating_sub(1),
            _ => {}
        }
        if brackets == 0 && is_it(depth, text.get(at..).unwrap_or("")) {
            return Some(at);
        }
    }
    None
}

/// `DI[3:part here]` is DI[3].
fn without_comment(name: &str) -> String {
    name.split_once(':').map_or_else(|| name.to_owned(), |(head, _)| format!("{head}]"))
}

/// The parts of a text between signs that stand in no parentheses and no brackets.
fn parts_outside<'t>(text: &'t str, sign: &str) -> Vec<&'t str> {
    let mut cuts = Vec::new();
    // Never true: every place is looked at once.
    outside(text, |depth, rest| {
        if depth == 0 && rest.starts_with(sign) {
            cuts.push(text.len() - rest.len());
        }
        false
    });
    let ends = cuts.iter().copied().chain([text.len()]);
    let starts = [0].into_iter().chain(cuts.iter().map(|at| at + sign.len()));
    starts.zip(ends).filter_map(|(start, end)| text.get(start..end)).collect()
}

/// A text before and behind a sign that stands in no parentheses and no brackets.
pub(super) fn split_outside<'t>(text: &'t str, sign: &str) -> Option<(&'t str, &'t str)> {
    let at = outside(text, |depth, rest| depth == 0 && rest.starts_with(sign))?;
    Some((text.get(..at)?, text.get(at + sign.len()..)?))
}

/// How long the name at the start of a text is: `GI[5:program]/10` has one of 13 signs.
fn name_length(text: &str) -> usize {
    let is_of_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '$' | '.' | ']');
    let end = outside(text, |_, rest| rest.starts_with(|c: char| !is_of_name(c)));
    end.unwrap_or(text.len())
}

/// `F[1:comment]` or `F[R[1]]` as a whole: list and index.
fn indexed(name: &str) -> Option<(&str, &str)> {
    let (list, index) = name.strip_suffix(']')?.split_once('[')?;
    Some((list, index.split(':').next()?))
}

/// `R[5:comment]` or `PR[R[2:id],3]` at the start of a text: what stands in the brackets but for a
/// comment, and what follows.
pub(super) fn brackets<'t>(text: &'t str, name: &str) -> Option<(&'t str, &'t str)> {
    if !starts_with(text, name) {
        return None;
    }
    let rest = text.get(name.len()..)?.strip_prefix('[')?;
    let (mut depth, mut comment) = (0_usize, None);
    // A comment goes on to the next bracket that closes, whatever stands in it.
    let mut is_comment = false;
    for (at, byte) in rest.bytes().enumerate() {
        match byte {
            b']' if depth == 0 => {
                return Some((rest.get(..comment.unwrap_or(at))?, rest.get(at + 1..)?));
            }
            b']' => (depth, is_comment) = (depth - 1, false),
            b'[' if !is_comment => depth += 1,
            b':' if !is_comment => {
                is_comment = true;
                if depth == 0 {
                    comment = Some(at);
                }
            }
            _ => {}
        }
    }
    None
}

/// `R[5:comment]` at the start of a text: the number, where it is one, and what follows.
pub(super) fn register<'t>(text: &'t str, name: &str) -> Option<(i64, &'t str)> {
    let (inside, rest) = brackets(text, name)?;
    Some((inside.split(',').next()?.trim().parse().ok()?, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_hold_brackets_and_comments() {
        for (text, expected) in [
            ("PR[1,3:a [b]=2", Some(("1,3", "=2"))),
            ("PR[R[2:id],R[3:a:b]:c]+1", Some(("R[2:id],R[3:a:b]", "+1"))),
            ("PR[R[R[1]]]", Some(("R[R[1]]", ""))),
            ("PR[R[1]", None),
            ("R[1]", None),
        ] {
            assert_eq!(brackets(text, "PR"), expected, "{text}");
        }
    }

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
