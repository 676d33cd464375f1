//! Numbers of RAPID. A num has single precision, a dnum double; here both are worked out in double.
//! Where a function jumps, or little of a number is left, rounding decides, and what the controller
//! has counts: if it rounds each operation, and if it rounds only what it keeps. Where these differ
//! the result is not known.

use std::cmp::Ordering;
use std::fmt;

use crate::program::single::{self, COUNT};

/// Digits of a num and of a dnum that a string has.
const SHOWN_DIGITS: [i32; 2] = [6, 15];

/// What helps where it is not known how a number is written.
pub(super) const WRITE: &str = "write the string itself";

#[derive(Debug, Clone, Copy)]
pub(super) struct Number {
    value: f64,
    held: Held,
}

/// What the controller has.
#[derive(Debug, Clone, Copy)]
enum Held {
    /// A dnum: the same.
    Double,
    /// A num, if each operation rounds, and if only what is kept is rounded.
    Single { each: f32, kept: f64 },
    /// A num of which the rounding is not known.
    Open,
    /// What depends on the robot, such as the speed of `vmax`.
    OfRobot,
}

/// Numbers are one as they are worked out here.
impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.value, f)
    }
}

/// What is worked out of exact numbers: whole numbers and binary fractions are exact, too.
impl From<f64> for Number {
    fn from(value: f64) -> Self {
        if single::is_exact(value) { Self::of(value) } else { Self::open(value) }
    }
}

/// Why what a number near this one decides is not known.
fn undecided(near: f64) -> String {
    format!(
        "a num has seven digits, and rounding decides about a number near {}: {COUNT}",
        near as f32
    )
}

/// Why what the speed of `vmax` decides is not known.
const OF_ROBOT: &str = "what vmax is depends on the robot: write the value into a copy of the \
                        program";

impl Number {
    /// As the text or the job states it.
    pub(super) fn of(value: f64) -> Self {
        Self::single(value, value as f32, f64::from(value as f32))
    }

    fn open(value: f64) -> Self {
        Self { value, held: Held::Open }
    }

    /// The same of which the rounding is not known.
    pub(super) fn opened(self) -> Self {
        if self.is_of_robot() { self } else { Self::open(self.value) }
    }

    /// The same as what another robot may have otherwise.
    pub(super) fn of_robot(self) -> Self {
        Self { held: Held::OfRobot, ..self }
    }

    pub(super) fn is_of_robot(self) -> bool {
        matches!(self.held, Held::OfRobot)
    }

    /// How a number that depends on the robot compares with another: `None` where neither does.
    fn order_of_robot(self, other: Self) -> Option<Result<Ordering, String>> {
        // No robot's own number is so much smaller.
        const SMALLER: f64 = 5.0;
        let is_far = |own: Self, other: Self| own.value.abs() > SMALLER * other.value.abs();
        let is_sure = match (self.is_of_robot(), other.is_of_robot()) {
            (false, false) => return None,
            (true, true) => self.value == other.value,
            (true, false) => is_far(self, other),
            (false, true) => is_far(other, self),
        };
        let order = self.value.partial_cmp(&other.value).filter(|_| is_sure);
        Some(order.ok_or_else(|| OF_ROBOT.to_owned()))
    }

    fn single(value: f64, each: f32, kept: f64) -> Self {
        let is_one = each.is_finite() && kept.is_finite();
        Self { value, held: if is_one { Held::Single { each, kept } } else { Held::Open } }
    }

    /// The result of an operation.
    pub(super) fn with(self, other: Self, apply: impl Fn(f64, f64) -> f64) -> Self {
        let value = apply(self.value, other.value);
        match (self.held, other.held) {
            (Held::OfRobot, _) | (_, Held::OfRobot) => Self { value, held: Held::OfRobot },
            (Held::Open, _) | (_, Held::Open) => Self::open(value),
            // The other is one, too, or a number in the text.
            (Held::Double, _) | (_, Held::Double) => Self { value, held: Held::Double },
            (Held::Single { each, kept }, Held::Single { each: by, kept: kept_by }) => {
                Self::single(value, apply(each.into(), by.into()) as f32, apply(kept, kept_by))
            }
        }
    }

    pub(super) fn negated(self) -> Self {
        self.with(Self::of(0.0), |number, zero| zero - number)
    }

    pub(super) fn is_finite(self) -> bool {
        self.value.is_finite()
    }

    /// As a datum of this type keeps it.
    pub(super) fn stored(self, is_dnum: bool) -> Self {
        match self.held {
            Held::Open | Held::OfRobot => self,
            _ if is_dnum => Self { held: Held::Double, ..self },
            Held::Single { each, kept } if kept as f32 == each => {
                const WITH_FRACTIONS: f64 = 8_388_608.0;
                let own = f64::from(each);
                // What is left beside a whole number has gone.
                let is_whole = own.fract() == 0.0 && own.abs() < WITH_FRACTIONS;
                let value = if is_whole { own } else { self.value };
                Self::single(value, each, own)
            }
            Held::Single { .. } if self.known() == Ok(self.value) => Self::open(self.value),
            _ => self,
        }
    }

    /// As a variable counts: each sum is rounded, and the number here goes on.
    fn rounded_each(self) -> Self {
        match self.held {
            Held::Single { each, .. } => Self::single(self.value, each, each.into()),
            _ => self,
        }
    }

    /// A dnum of this value.
    pub(super) fn to_dnum(self) -> Self {
        match self.stored(false) {
            Self { held: Held::Single { each, .. }, .. } => {
                Self { value: each.into(), held: Held::Double }
            }
            other => other,
        }
    }

    /// A num of this value.
    pub(super) fn to_num(self) -> Self {
        match self.held {
            Held::Double => Self::of(self.value),
            _ => self,
        }
    }

    /// The number that counts: what the controller has where that is certain, and another than
    /// here.
    pub(super) fn known(self) -> Result<f64, String> {
        const SAME: f64 = 1e-4;
        // A place that is off by so much is no other way of the arm.
        const NEAR: f64 = 1e-2;
        let Held::Single { each, kept } = self.held else { return Ok(self.value) };
        let (each, value) = (f64::from(each), self.value);
        let are = |share: f64, a: f64, b: f64| (a - b).abs() <= share * b.abs().max(1.0);
        if are(SAME, each, kept) {
            return Ok(if are(SAME, each, value) { value } else { each });
        }
        let is_near = are(NEAR, each, value) && are(NEAR, kept, value);
        if is_near { Ok(value) } else { Err(undecided(value)) }
    }

    /// The same with the number that counts.
    pub(super) fn settled(self) -> Result<Self, String> {
        Ok(Self { value: self.known()?, ..self })
    }

    fn is_whole(self) -> bool {
        self.is_exact() && self.value.fract() == 0.0
    }

    /// Whether the controller has the same.
    pub(super) fn is_exact(self) -> bool {
        match self.held {
            Held::Double => true,
            Held::Single { each, kept } => f64::from(each) == self.value && kept == self.value,
            Held::Open | Held::OfRobot => false,
        }
    }

    /// What a function gives that jumps, here `at` the nearest number.
    fn jump(self, at: f64, of: fn(f64) -> f64) -> Result<Self, String> {
        // No −0.
        let of = |number: f64| of(number) + 0.0;
        match self.held {
            Held::Double | Held::OfRobot => Ok(Self { value: of(self.value), ..self }),
            Held::Single { each, kept } => {
                let result = of(each.into());
                let is_sure = result == of(kept);
                is_sure.then(|| Self::of(result)).ok_or_else(|| undecided(self.value))
            }
            Held::Open => {
                let is_sure = single::are_apart(self.value, at);
                is_sure.then(|| Self::of(of(self.value))).ok_or_else(|| undecided(self.value))
            }
        }
    }

    pub(super) fn truncated(self) -> Result<Self, String> {
        // At 0 it does not jump.
        let near = self.value.round();
        self.jump(if near == 0.0 { 1.0 } else { near }, f64::trunc)
    }

    pub(super) fn rounded(self) -> Result<Self, String> {
        self.jump(self.value.floor() + 0.5, f64::round)
    }

    /// Rounded or truncated behind so many decimals.
    pub(super) fn at_decimals(
        self,
        decimals: f64,
        to_whole: fn(Self) -> Result<Self, String>,
    ) -> Result<Self, String> {
        let scale = Self::of(10_f64.powf(decimals));
        let whole = to_whole(self.with(scale, |number, by| number * by))?;
        Ok(whole.with(scale, |number, by| number / by))
    }

    /// DIV; of whole numbers it is exact.
    pub(super) fn divided(self, by: Self) -> Result<Self, String> {
        if self.is_whole() && by.is_whole() {
            return Ok(self.with(by, |number, by| (number / by).trunc()));
        }
        self.with(by, |number, by| number / by).truncated()
    }

    /// MOD.
    pub(super) fn remainder(self, by: Self) -> Result<Self, String> {
        if self.is_whole() && by.is_whole() {
            return Ok(self.with(by, |number, by| number % by));
        }
        let times = self.divided(by)?.value;
        Ok(self.with(by, |number, by| number - times * by))
    }

    /// The whole number that an index is: a little more is cut off, where any is.
    pub(super) fn index(self) -> Result<f64, String> {
        let value = self.known()?;
        let whole = value.round();
        if single::are_apart(value, whole) {
            return Ok(value);
        }
        let is_sure = match self.held {
            Held::Double => value == whole,
            Held::Single { each, kept } => {
                f64::from(each).trunc() == whole && kept.trunc() == whole
            }
            Held::Open | Held::OfRobot => false,
        };
        if is_sure { Ok(whole) } else { Err(undecided(value)) }
    }

    /// Which of two is larger.
    pub(super) fn order(self, other: Self) -> Result<Ordering, String> {
        if let Some(order) = self.order_of_robot(other) {
            return order;
        }
        let order = single::order(self.known()?, other.known()?)?;
        let is_sure = match (self.held, other.held) {
            (Held::Open, _) | (_, Held::Open) => single::are_apart(self.value, other.value),
            (Held::Single { each, kept }, Held::Single { each: with, kept: kept_with }) => {
                each.partial_cmp(&with) == Some(order)
                    && kept.partial_cmp(&kept_with) == Some(order)
            }
            _ => true,
        };
        if is_sure { Ok(order) } else { Err(single::rounded(other.value)) }
    }

    /// Whether two are one.
    pub(super) fn is_same(self, other: Self) -> Result<bool, String> {
        if let Some(order) = self.order_of_robot(other) {
            return order.map(Ordering::is_eq);
        }
        let is_same = single::is_same(self.known()?, other.known()?)?;
        let is_sure = match (self.held, other.held) {
            (Held::Open, _) | (_, Held::Open) => single::are_apart(self.value, other.value),
            (Held::Single { each, kept }, Held::Single { each: with, kept: kept_with }) => {
                (each == with) == is_same && (kept == kept_with) == is_same
            }
            _ => true,
        };
        if is_sure { Ok(is_same) } else { Err(single::rounded(other.value)) }
    }

    /// As a string has it: six digits of a num, fifteen of a dnum, where they are certain.
    pub(super) fn text(self) -> Result<String, String> {
        let value = self.known()?;
        let most = SHOWN_DIGITS[usize::from(matches!(self.held, Held::Double))];
        let digits = |number: f64| {
            let before = if number == 0.0 { 1 } else { number.abs().log10().floor() as i32 + 1 };
            let decimals = usize::try_from(most - before).unwrap_or(0);
            let text = format!("{:.decimals$}", number + 0.0);
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        };
        let text = digits(value);
        let is_sure = match self.held {
            // It has more digits.
            Held::Double => text.parse() == Ok(value),
            Held::Single { each, kept } => digits(each.into()) == text && digits(kept) == text,
            Held::Open | Held::OfRobot => false,
        };
        // Beyond, powers of ten are written.
        let is_plain = value == 0.0 || (1e-3..10_f64.powi(most - 1)).contains(&value.abs());
        match is_sure && is_plain {
            true => Ok(text),
            false => Err(format!("how {value} is written is not known: {WRITE}")),
        }
    }

    /// As a string has it with so many decimals, where they are certain.
    pub(super) fn text_with(self, decimals: f64) -> Result<String, String> {
        const MOST: f64 = 1e6;
        let scaled = self.with(Self::of(10_f64.powf(decimals)), |number, by| number * by);
        let is_plain = decimals >= 0.0 && decimals.fract() == 0.0 && scaled.known()?.abs() < MOST;
        let is_tie = scaled.value.fract().abs() == 0.5;
        let number = self.at_decimals(decimals, Self::rounded)?.known()?;
        // Not negative, where it is plain.
        let places = decimals as usize;
        match is_plain && !is_tie && (number != 0.0 || self.value >= 0.0) {
            true => Ok(format!("{number:.places$}")),
            false => Err(format!(
                "how {self} is written with {decimals} decimal{} is not known: {WRITE}",
                if decimals == 1.0 { "" } else { "s" }
            )),
        }
    }
}

/// The variable of a FOR, and the same as the controller counts.
#[derive(Debug)]
pub(super) struct Count {
    at: Number,
    end: Number,
    step: Number,
    /// Whether all that is counted is exact.
    is_exact: bool,
}

impl Count {
    /// `None`: the step is 0.
    pub(super) fn new(from: Number, end: Number, step: Option<Number>) -> Option<Self> {
        let down = if end.value < from.value { -1.0 } else { 1.0 };
        let step = step.unwrap_or(Number::of(down));
        let is_exact = from.is_exact() && step.is_exact();
        (step.value != 0.0).then_some(Self { at: from.rounded_each(), end, step, is_exact })
    }

    /// Whether it is behind the end.
    pub(super) fn is_behind(&self) -> Result<bool, String> {
        let is_behind = |at: f64, end: f64| if self.step.value > 0.0 { at > end } else { at < end };
        let here = is_behind(self.at.value, self.end.value);
        let there = match (self.at.held, self.end.held) {
            (Held::Single { each: at, .. }, Held::Single { each, kept }) => {
                [f64::from(each), kept].map(|end| is_behind(at.into(), end))
            }
            _ => [self.at.order(self.end).map(|_| here)?; 2],
        };
        let is_sure = there[0] == there[1] && (self.is_exact || there[0] == here);
        if is_sure { Ok(there[0]) } else { Err(single::rounded(self.end.value)) }
    }

    pub(super) fn now(&self) -> Number {
        if self.is_exact { self.at } else { self.at.opened() }
    }

    pub(super) fn advance(&mut self) {
        self.at = self.at.with(self.step, |at, step| at + step).rounded_each();
    }
}
