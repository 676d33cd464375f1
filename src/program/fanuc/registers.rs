//! Registers and signals of TP programs: what the program has set, and what the job assumes.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use super::position::{Held, POSE};
use super::why::Why;
use super::words::{bare, indexed, names_in, split_outside, starts_with, without_comment};
use crate::program::span::Span;
use crate::program::{Assumed, Settings};

/// Why an output is not known behind `DO[1]=PULSE,0.5sec` or `PULSE DO[1]`.
pub(super) const IS_PULSED: &str = "it is pulsed";

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
    /// What the CALL gives that runs the program at hand.
    arguments: Option<Vec<Result<f64, String>>>,
    /// What the program has asked for before it or another set it: there the job's word has served.
    started: RefCell<HashSet<String>>,
    /// Of these, those that a program may have set since that is not read: by name, who.
    suspected: RefCell<HashMap<String, String>>,
    /// Those that the job's word has served for again.
    served_twice: RefCell<Vec<(String, String)>>,
}

/// Why a name is known no longer.
#[derive(Debug)]
enum Lost {
    /// The program has set it to what is not known.
    Set(Why),
    /// Who else may have set it, and whether what the job assumes of it holds no longer.
    Otherwise { by: String, is_final: bool },
}

impl Lost {
    fn is_final(&self) -> bool {
        matches!(self, Self::Set(_) | Self::Otherwise { is_final: true, .. })
    }
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
            arguments: None,
            started: RefCell::default(),
            suspected: RefCell::default(),
            served_twice: RefCell::default(),
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
    pub(super) fn set_from(&mut self, number: i64, value: Result<f64, Why>, at: Option<Span>) {
        self.set(number, value);
        if let Some(at) = at {
            self.places.insert(number, at);
        }
    }

    pub(super) fn set(&mut self, number: i64, value: Result<f64, Why>) {
        self.places.remove(&number);
        match value {
            Ok(value) => drop(self.numbers.insert(number, value)),
            Err(why) => {
                self.numbers.remove(&number);
                self.lost.insert(format!("r[{number}]"), Lost::Set(why));
            }
        }
    }

    /// R[n] is set by a line that is not read.
    pub(super) fn set_unread(&mut self, number: i64, why: &str) {
        self.set(number, Err(Why::default()));
        let lost = Lost::Otherwise { by: why.to_owned(), is_final: true };
        self.lost.insert(format!("r[{number}]"), lost);
    }

    /// What the job assumes of a name.
    pub(super) fn assumed(&self, name: &str) -> Option<Assumed> {
        let name = name.trim().to_lowercase();
        let bare = without_comment(&name);
        let lost = self.lost_of(&bare);
        let found = self.given(&name).filter(|_| lost.is_none_or(|lost| !lost.is_final()));
        if found.is_some() && lost.is_none() {
            let who = self.suspected.borrow_mut().remove(&bare);
            self.served_twice.borrow_mut().extend(who.map(|who| (name, who)));
            self.started.borrow_mut().insert(bare);
        }
        found
    }

    /// A program that is not read may set what the job's word has served for: registers, flags and
    /// outputs.
    pub(super) fn may_be_set_by(&mut self, who: &str) {
        const SET: [&str; 8] = ["r", "pr", "f", "m", "do", "ro", "go", "ao"];
        let own = self.started.borrow();
        let set =
            own.iter().filter(|name| indexed(name).is_some_and(|(list, _)| SET.contains(&list)));
        let set = set.map(|name| (name.clone(), who.to_owned()));
        self.suspected.borrow_mut().extend(set);
    }

    /// What the job's word has served for on both sides of such a program, and who it is; once.
    pub(super) fn served_twice(&mut self) -> Vec<(String, String)> {
        let mut found = std::mem::take(self.served_twice.get_mut());
        found.iter_mut().for_each(|(name, _)| *name = name.to_uppercase());
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
    pub(super) fn unknown(&self, name: &str) -> Why {
        let name = &without_comment(name.trim());
        let text = format!("{name} is known only at run time");
        match self.lost_of(&name.trim().to_lowercase()) {
            None => Why::of(text, name),
            Some(Lost::Set(why)) => why.clone().set(name),
            Some(Lost::Otherwise { by, is_final: true }) => format!("{text}: {by}").into(),
            Some(Lost::Otherwise { by, .. }) => Why::of(format!("{text}: {by}"), name),
        }
    }

    /// AR[1] and the others are those of a call; gives those of the caller.
    pub(super) fn replace_arguments(
        &mut self,
        arguments: Option<Vec<Result<f64, String>>>,
    ) -> Option<Vec<Result<f64, String>>> {
        std::mem::replace(&mut self.arguments, arguments)
    }

    /// AR[n] in a program that another calls.
    fn argument(&self, name: &str) -> Option<Result<f64, Why>> {
        let arguments = self.arguments.as_ref()?;
        let (_, index) = indexed(name).filter(|(list, _)| list.eq_ignore_ascii_case("AR"))?;
        let given = self.whole(index).map(|number| {
            let at = usize::try_from(number - 1).ok();
            at.and_then(|at| arguments.get(at)).cloned().unwrap_or_else(|| {
                Err(format!("the call gives no AR[{number}], of {} arguments", arguments.len()))
            })
        });
        Some(given.and_then(|given| given.map_err(Why::from)))
    }

    /// What the program has set a flag or an output to, else what the job assumes of it.
    pub(super) fn known(&self, name: &str) -> Result<Assumed, Why> {
        if let Some(given) = self.argument(name) {
            return given.map(Assumed::Number);
        }
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
            (_, Err(_)) => self.forget_signal(name, by.into()),
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
        self.lost.insert(name, Lost::Otherwise { by: by.to_owned(), is_final });
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
                Some(_) if self.started.borrow().contains(&lower) => Err(by.into()),
                Some(Assumed::Number(value)) => Ok(value),
                _ => Err(Why::of(by, &name)),
            }
        };
        let job = self.position_of_job(number, |name| self.given(&name.to_lowercase()));
        let left = held.left(element, &job, given);
        self.set_position(number, left);
    }

    /// What the job assumes of a name holds no longer.
    fn lose_given(&mut self, name: &str, by: &str) {
        let lost = || Lost::Otherwise { by: by.to_owned(), is_final: true };
        match indexed(name) {
            Some(("PR", index)) => {
                let Some((number, element)) = split_outside(index, ",") else { return };
                let (Ok(number), Ok(element)) = (self.whole(number), self.whole(element)) else {
                    return;
                };
                // An element that a condition has read is one of the six.
                drop(self.set_element(number, element, Err(by.into())));
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
        let value = value.trim();
        let found = match (self.truth(value), self.value(value)) {
            (Ok(truth), _) => Ok(Assumed::Truth(truth)),
            (_, Ok(number)) => Ok(Assumed::Number(number)),
            _ if starts_with(value, "PULSE") => Err(IS_PULSED.into()),
            (Err(truth), Err(number)) => Err(truth.or(number)),
        };
        self.keep_signal(name, found);
    }

    /// What a signal is set to is known no longer.
    pub(super) fn forget_signal(&mut self, name: &str, why: Why) {
        self.keep_signal(name, Err(why));
    }

    fn keep_signal(&mut self, name: &str, value: Result<Assumed, Why>) {
        let Some((list, index)) = indexed(name.trim()) else { return };
        let number = match self.value(index) {
            Ok(number) => number,
            Err(why) => {
                // Any of them may be set.
                self.signals.retain(|key, _| indexed(key).is_none_or(|(other, _)| other != list));
                self.lost.insert(list.to_lowercase(), Lost::Set(why));
                return;
            }
        };
        let key = format!("{list}[{number}]");
        match value {
            Ok(value) => drop(self.signals.insert(key, value)),
            Err(why) => {
                self.signals.remove(&key);
                self.lost.insert(key.to_lowercase(), Lost::Set(why));
            }
        }
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
        value: Result<f64, Why>,
    ) -> Result<(), String> {
        let mut held = self.position(number);
        held.set(index, value)?;
        self.set_position(number, held);
        Ok(())
    }

    /// R[n].
    pub(super) fn number(&self, number: i64) -> Result<f64, Why> {
        if let Some(value) = self.numbers.get(&number) {
            return Ok(*value);
        }
        match self.assumed(&format!("R[{number}]")) {
            Some(Assumed::Number(value)) => Ok(value),
            _ => Err(self.unknown(&format!("R[{number}]"))),
        }
    }
}
