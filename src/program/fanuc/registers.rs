//! Registers and arithmetic of TP programs.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::position::{Held, POSE};
use super::words::{
    bare, brackets, indexed, name_length, names_in, outside, parts_outside, split_outside,
    starts_with, without_comment,
};
use crate::program::span::Span;
use crate::program::{Assumed, Settings, single};
use crate::units::{deg_from_rad, rad_from_deg};

/// Why `PR[GP1:1,7]` is not read.
pub(super) const OF_A_GROUP: &str = "PR[GP…]: elements of a group are not supported";

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
    /// What is known no longer, by name, `f[1]`, or of a list any, `f`.
    lost: HashMap<String, Lost>,
    /// What the program has asked for before it or another set it: there the job's word has served.
    started: RefCell<HashSet<String>>,
}

/// Why a name is known no longer.
#[derive(Debug)]
struct Lost {
    /// Who else may have set it; `None` where the program has, to what only the run knows.
    by: Option<String>,
    /// Whether what the job assumes of it holds no longer.
    is_final: bool,
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

impl<'a> Registers<'a> {
    pub(super) fn new(settings: &'a Settings) -> Self {
        Self {
            settings,
            numbers: HashMap::new(),
            places: HashMap::new(),
            positions: HashMap::new(),
            signals: HashMap::new(),
            lost: HashMap::new(),
            started: RefCell::default(),
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
                self.lost.insert(format!("r[{number}]"), Lost { by: None, is_final: true });
            }
        }
    }

    /// R[n] is set by a line that is not read.
    pub(super) fn set_unread(&mut self, number: i64, why: &str) {
        self.set(number, Err(why.to_owned()));
        let lost = Lost { by: Some(why.to_owned()), is_final: true };
        self.lost.insert(format!("r[{number}]"), lost);
    }

    /// What the job assumes of a name.
    pub(super) fn assumed(&self, name: &str) -> Option<Assumed> {
        let name = name.trim().to_lowercase();
        let bare = without_comment(&name);
        let lost = self.lost_of(&bare);
        let found = self.given(&name).filter(|_| lost.is_none_or(|lost| !lost.is_final));
        if found.is_some() && lost.is_none() {
            self.started.borrow_mut().insert(bare);
        }
        found
    }

    /// What the job says of a name, in lower case, whether or not it still holds.
    pub(super) fn given(&self, name: &str) -> Option<Assumed> {
        let assume = &self.settings.assume;
        assume.get(name).or_else(|| assume.get(&without_comment(name))).copied()
    }

    /// What the job says of a name, in lower case, if that has not served before: now it has.
    pub(super) fn given_once(&self, name: &str) -> Option<Assumed> {
        let is_first = self.started.borrow_mut().insert(name.to_owned());
        self.given(name).filter(|_| is_first)
    }

    /// Why a name, in lower case, is known no longer.
    fn lost_of(&self, name: &str) -> Option<&Lost> {
        let list = name.split('[').next().unwrap_or(name);
        self.lost.get(name).or_else(|| self.lost.get(list))
    }

    /// Why a name is not known, and what may help.
    fn unknown(&self, name: &str) -> String {
        let name = &without_comment(name.trim());
        let hint = hint(name);
        match self.lost_of(&name.trim().to_lowercase()) {
            None => format!("{name} is known only at run time{hint}"),
            Some(Lost { by: None, .. }) => {
                format!("{name} is set to what is known only at run time")
            }
            Some(Lost { by: Some(by), is_final }) => {
                let hint = if *is_final { "" } else { &hint };
                format!("{name} is known only at run time: {by}{hint}")
            }
        }
    }

    /// A name with the number that its index has now: `DI[R[96]]` is DI[7].
    fn resolved(&self, name: &str) -> Result<String, String> {
        match indexed(name.trim()) {
            Some((list, index)) if !index.contains(',') => {
                Ok(format!("{list}[{}]", self.value(index)?))
            }
            _ => Ok(name.trim().to_owned()),
        }
    }

    /// What the program has set a flag or an output to, else what the job assumes of it.
    fn known(&self, name: &str) -> Result<Assumed, String> {
        let own = self.resolved(name);
        let set = own
            .as_ref()
            .ok()
            .and_then(|own| self.signals.get(own).copied().or_else(|| self.assumed(own)));
        match set.or_else(|| self.assumed(name)) {
            Some(known) => Ok(known),
            None => Err(self.unknown(&own?)),
        }
    }

    /// Another may have set all that the program has, or some of it.
    fn lose_all(&mut self, by: &str) {
        for number in self.numbers.keys().copied().collect::<Vec<_>>() {
            self.lose_number(number, by);
        }
        for number in self.positions.keys().copied().collect::<Vec<_>>() {
            self.lose_position(number, None, by);
        }
        for name in self.signals.keys().cloned().collect::<Vec<_>>() {
            self.lose_signal(&name, by);
        }
    }

    /// Another may have set what the program has: the job's word counts where there is one that has
    /// not served before. The others, by name, stay as the program has them.
    pub(super) fn left_to_the_job(&mut self, by: &str) -> Vec<String> {
        let has_word = |own: &Self, name: &str| {
            own.given(name).is_some() && !own.started.borrow().contains(name)
        };
        let mut others = Vec::new();
        for number in self.numbers.keys().copied().collect::<Vec<_>>() {
            match has_word(self, &format!("r[{number}]")) {
                true => self.lose_number(number, by),
                false => others.push(format!("R[{number}]")),
            }
        }
        for number in self.positions.keys().copied().collect::<Vec<_>>() {
            let given = |element: i64| has_word(self, &format!("pr[{number},{element}]"));
            match (1..=POSE.len() as i64).any(given) {
                true => self.lose_position(number, None, by),
                false => others.push(format!("PR[{number}]")),
            }
        }
        for name in self.signals.keys().cloned().collect::<Vec<_>>() {
            match has_word(self, &name.to_lowercase()) {
                true => self.lose_signal(&name, by),
                false => others.push(name),
            }
        }
        others.sort();
        others
    }

    /// Another has set what a condition names, or some of it.
    pub(super) fn lose_named(&mut self, condition: &str, by: &str) {
        for name in names_in(condition) {
            self.lose(name, by);
        }
    }

    /// Whoever a WAIT waits for has set what its condition names.
    pub(super) fn lose_awaited(&mut self, condition: &str, by: &str) {
        self.lose_named(condition, by);
        // It cannot go on under what the job assumes of it: that was before.
        if self.truth(condition) == Ok(false) {
            for name in names_in(condition) {
                self.lose_given(name, by);
            }
        }
    }

    /// `WAIT R[1]=1` goes on when the register is 1.
    pub(super) fn set_awaited(&mut self, condition: &str) {
        let parts = bare(condition).ok().and_then(|text| split_outside(text, "="));
        let Some((left, right)) = parts.filter(|_| !condition.contains(['<', '>'])) else { return };
        let register = self.numbered(left.trim(), "R").ok().flatten();
        let register = register.filter(|(_, behind)| behind.trim().is_empty());
        // What stands on the right may have changed, too, unless it is a number.
        if let (Some((number, _)), true, Ok(value)) =
            (register, names_in(condition).len() == 1, self.value(right))
        {
            self.set(number, Ok(value));
        }
    }

    fn lose(&mut self, name: &str, by: &str) {
        let Some((list, index)) = indexed(name) else { return };
        let (number, element) = match split_outside(index, ",") {
            Some((number, element)) => (self.whole(number), self.whole(element).ok()),
            None => (self.whole(index), None),
        };
        match (list, number) {
            ("R", Ok(number)) => self.lose_number(number, by),
            ("PR", Ok(number)) => self.lose_position(number, element, by),
            // It may be any.
            ("R" | "PR", Err(_)) => self.lose_all(by),
            (_, Ok(number)) => self.lose_signal(&format!("{list}[{number}]"), by),
            (_, Err(_)) => self.forget_signal(name),
        }
    }

    fn lose_number(&mut self, number: i64, by: &str) {
        if self.numbers.remove(&number).is_some() {
            self.places.remove(&number);
            self.keep_lost(format!("r[{number}]"), by);
        }
    }

    fn lose_signal(&mut self, name: &str, by: &str) {
        if self.signals.remove(name).is_some() {
            self.keep_lost(name.to_lowercase(), by);
        }
    }

    /// Another may have set any of the outputs: what the program has set, and what the job assumes
    /// where that has served before.
    pub(super) fn lose_outputs(&mut self, by: &str) {
        const LISTS: [&str; 4] = ["DO", "RO", "GO", "AO"];
        let is_output = |name: &&String| {
            let is_of = |list: &str| LISTS.iter().any(|own| own.eq_ignore_ascii_case(list));
            indexed(name).is_some_and(|(list, _)| is_of(list))
        };
        for name in self.signals.keys().filter(is_output).cloned().collect::<Vec<_>>() {
            self.lose_signal(&name, by);
        }
        let started = self.started.borrow().iter().filter(is_output).cloned().collect::<Vec<_>>();
        for name in started {
            self.keep_lost(name, by);
        }
    }

    fn keep_lost(&mut self, name: String, by: &str) {
        let is_final = self.started.borrow().contains(&name);
        self.lost.insert(name, Lost { by: Some(by.to_owned()), is_final });
    }

    fn lose_position(&mut self, number: i64, element: Option<i64>, by: &str) {
        let Some(held) = self.positions.get(&number).map(|held| held.as_ref().clone()) else {
            return;
        };
        let name = |index: i64| format!("PR[{number},{index}]");
        let given = |index: i64| {
            let name = name(index);
            let lower = name.to_lowercase();
            match self.given(&lower) {
                Some(_) if self.started.borrow().contains(&lower) => Err(by.to_owned()),
                Some(Assumed::Number(value)) => Ok(value),
                _ => Err(format!("{by}{}", hint(&name))),
            }
        };
        let job = self.position_of_job(number, |name| self.given(&name.to_lowercase()));
        let left = held.left(element, &job, given);
        self.set_position(number, left);
    }

    /// What the job assumes of a name holds no longer.
    fn lose_given(&mut self, name: &str, by: &str) {
        let lost = || Lost { by: Some(by.to_owned()), is_final: true };
        match indexed(name) {
            Some(("PR", index)) => {
                let Some((number, element)) = split_outside(index, ",") else { return };
                let (Ok(number), Ok(element)) = (self.whole(number), self.whole(element)) else {
                    return;
                };
                // An element that a condition has read is one of the six.
                drop(self.set_element(number, element, Err(by.to_owned())));
            }
            _ => {
                let own = self.resolved(name).unwrap_or_else(|_| name.to_owned());
                for own in [own.as_str(), name] {
                    let own = own.to_lowercase();
                    if self.given(&own).is_some() {
                        self.lost.insert(without_comment(&own), lost());
                    }
                }
            }
        }
    }

    /// `F[1]=(DI[2] AND R[3]=1)`, `DO[4]=ON`: what the run alone knows is what the job assumes.
    pub(super) fn set_signal(&mut self, name: &str, value: &str) {
        let Some((list, index)) = indexed(name.trim()) else { return };
        let Ok(number) = self.value(index) else {
            // Any of them may be set.
            self.signals.retain(|key, _| indexed(key).is_none_or(|(other, _)| other != list));
            self.lost.insert(list.to_lowercase(), Lost { by: None, is_final: true });
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
                self.lost.insert(key.to_lowercase(), Lost { by: None, is_final: true });
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
            None => self.position_of_job(number, |name| self.assumed(name)),
        }
    }

    /// What the job says of PR[n]: its elements, `PR[n,3]`, or that all others are zero.
    pub(super) fn position_of_job(
        &self,
        number: i64,
        given: impl Fn(&str) -> Option<Assumed>,
    ) -> Held {
        let is_zero = given(&format!("PR[{number}]")) == Some(Assumed::Number(0.0));
        let mut held = if is_zero { Held::assumed_zero() } else { Held::unset() };
        for index in 1..=POSE.len() as i64 {
            if let Some(Assumed::Number(value)) = given(&format!("PR[{number},{index}]")) {
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
        if let Some((function, (inside, rest))) =
            FUNCTIONS.iter().find_map(|(name, of)| Some((of, brackets(text, name)?)))
        {
            return Ok((function(self.value(inside)?), rest));
        }
        let (name, rest) = text.split_at(name_length(text));
        if name.is_empty() {
            return Err(format!("'{}' is no value", text.trim()));
        }
        Ok(match self.known(name)? {
            Assumed::Number(value) => (value, rest),
            Assumed::Truth(value) => (f64::from(u8::from(value)), rest),
        })
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
        match self.known(text)? {
            Assumed::Truth(value) => Ok(value),
            Assumed::Number(_) => Err(self.unknown(text)),
        }
    }

    fn compare(&self, operator: &str, left: &str, right: &str) -> Result<bool, String> {
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
        let (left, right) = (self.value(left)?, self.value(right)?);
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

/// What in the job can give a name.
fn hint(name: &str) -> String {
    format!("; assume: {{\"{name}\": …}} in the job can give it")
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
