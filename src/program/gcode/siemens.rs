//! Sinumerik's drilling cycles, where they stand or at every position behind MCALL: CYCLE81 to
//! CYCLE83 and CYCLE85 (Siemens, SINUMERIK 840D sl/828D Fundamentals, "Programming cycles
//! externally"). Others are refused.

use super::expression::{Reader, not_vacant};
use super::parameters::Parameters;
use crate::units::ratio_from_percent;

/// Pecks in a hole.
const MOST_PECKS: usize = 10_000;

/// A call: its parameters by their place, `None` where nothing stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DrillingCall {
    pub(super) cycle: Cycle,
    parameters: Vec<Option<f64>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cycle {
    /// 81 and 82, with a dwell.
    Drill,
    /// 83.
    Peck,
    /// 84: with a tap, in and out with the spindle's turns.
    Tap,
    /// 85: out at a feed.
    Ream,
}

impl DrillingCall {
    /// Reads what stands between the parentheses of a call.
    pub(super) fn read(name: &str, inside: &str, known: &Parameters) -> Result<Self, String> {
        let cycle = match name {
            "CYCLE81" | "CYCLE82" => Cycle::Drill,
            "CYCLE83" => Cycle::Peck,
            "CYCLE84" => Cycle::Tap,
            "CYCLE85" => Cycle::Ream,
            _ => {
                return Err(format!(
                    "{name}: of Sinumerik's cycles CYCLE81 to CYCLE85 alone are supported"
                ));
            }
        };
        Ok(Self { cycle, parameters: arguments(name, inside, known)? })
    }

    pub(super) fn get(&self, place: usize) -> Option<f64> {
        self.parameters.get(place).copied().flatten()
    }

    /// A digit of the word that says how the others count, from the right.
    pub(super) fn mode(&self, digit: i32) -> i64 {
        let place = match self.cycle {
            Cycle::Drill => 8,
            Cycle::Peck => 19,
            Cycle::Tap => 23,
            Cycle::Ream => 10,
        };
        // Saturates; modes have eight digits.
        let word = self.get(place).unwrap_or(0.0).abs() as i64;
        word / 10_i64.pow(digit.unsigned_abs()) % 10
    }

    /// A digit of CYCLE83's `_AMODE` that is not read.
    pub(super) fn refuse_modes(&self) -> Result<(), String> {
        for digit in 0..9 {
            // 0 is as in older cycles; of the two behind that of DAM, 1 is all that is known.
            let most = match digit {
                0..=5 => 2,
                6 | 7 => 1,
                _ => 0,
            };
            let own = self.mode(digit);
            if own > most {
                return Err(format!(
                    "_AMODE of CYCLE83: digit {} from the right is {own}, and 0 to {most} are \
                     known there: not supported; have the cycle written with one of these",
                    digit + 1
                ));
            }
        }
        Ok(())
    }

    /// Whether `_AMODE` is written, in which percent are possible.
    pub(super) fn has_mode(&self) -> bool {
        self.get(19).is_some_and(|mode| mode != 0.0)
    }

    /// A word that changes the axis or the plane, or that is not read, for a plane's normal.
    pub(super) fn refuse_others(&self, normal: usize) -> Result<(), String> {
        let (plane, last, axis) = match self.cycle {
            Cycle::Drill => (7, 8, None),
            Cycle::Peck => (18, 19, Some(12)),
            Cycle::Tap => (22, 23, Some(12)),
            Cycle::Ream => (9, 10, None),
        };
        // Saturates; modes have few digits.
        let digit = self.get(plane).unwrap_or(0.0).abs() as i64 % 10;
        if digit != 0 && digit != 3 - normal as i64 {
            return Err("the cycle has a plane of its own (_DMODE): not supported".to_owned());
        }
        if axis.and_then(|at| self.get(at)).is_some_and(|axis| axis == 1.0 || axis == 2.0) {
            return Err("the cycle has an axis of its own (_AXN): not supported".to_owned());
        }
        let others = self.parameters.iter().skip(last + 1).flatten();
        if others.into_iter().any(|value| *value != 0.0) {
            return Err(format!("a word of the cycle behind the {}th is not supported", last + 1));
        }
        Ok(())
    }

    /// A depth from an absolute and a relative word, in the program's coordinates.
    pub(super) fn depth(
        &self,
        [absolute, relative]: [usize; 2],
        mode: i64,
        surface: f64,
    ) -> Result<Option<f64>, String> {
        // A relative depth of 0 is none.
        let by = self.get(relative).filter(|depth| *depth != 0.0);
        let by = by.map(|depth| surface - depth.abs());
        match (self.get(absolute), by, mode) {
            (None, None, _) => Ok(None),
            (Some(depth), None, 0 | 2) => Ok(Some(depth)),
            (_, Some(depth), 0 | 1) if self.get(absolute).is_none_or(|own| own == depth) => {
                Ok(Some(depth))
            }
            _ => Err("the cycle's words give different depths, or in a mode that is not \
                      supported"
                .to_owned()),
        }
    }

    /// Below the reference plane, positive: each peck, with the degression of CYCLE83.
    pub(super) fn pecks(&self, depth: f64, first: f64) -> Result<Vec<f64>, String> {
        let least = self.get(13).filter(|least| *least > 0.0);
        let less = match (self.get(7).unwrap_or(0.0), self.mode(5)) {
            (100.0, 2) => 0.0,
            (percent, 2) if percent > 0.0 && percent < 100.0 => -ratio_from_percent(percent),
            (percent, 2) => {
                return Err(format!(
                    "DAM is {percent}, and _AMODE (digit 6 from the right) has it in percent: must \
                     be above 0, up to 100"
                ));
            }
            (amount, 1) if amount < 0.0 => {
                return Err(format!(
                    "DAM is {amount}, and _AMODE (digit 6 from the right) has it as an amount: \
                     must not be negative"
                ));
            }
            (less, _) => less,
        };
        if less < 0.0 && least.is_none() {
            return Err("DAM is a factor, or in percent, and the cycle has no _MDEP".to_owned());
        }
        let (mut depths, mut at, mut stroke) = (Vec::new(), 0.0, first);
        let floor = least.unwrap_or(if less > 0.0 { less } else { 0.0 });
        while depth - at > 1e-9 {
            let left = depth - at;
            // Of the least strokes, the last two are equal.
            let is_least = less != 0.0 && at > 0.0 && stroke <= floor;
            let own = if is_least && left > stroke && left < 2.0 * stroke {
                left / 2.0
            } else {
                stroke.min(left)
            };
            if !(own > 0.0 && depths.len() < MOST_PECKS) {
                return Err(format!("a first depth of {first} gives no pecks, or too many"));
            }
            at += own;
            depths.push(at);
            let next = if less < 0.0 { stroke * -less } else { stroke - less };
            stroke = next.max(floor).min(stroke);
        }
        Ok(depths)
    }
}

/// What stands between the parentheses of a call: numbers, `None` where nothing or an empty text
/// stands.
pub(super) fn arguments(
    name: &str,
    inside: &str,
    known: &Parameters,
) -> Result<Vec<Option<f64>>, String> {
    let read = |text: &str| {
        if matches!(text.trim(), "" | "\"\"") {
            return Ok(None);
        }
        let mut reader = Reader::new(text.as_bytes(), 0, known);
        let value = not_vacant(reader.expression()?)?;
        match reader.peek() {
            None => Ok(Some(value)),
            Some(_) => Err(format!("{name}: '{}' is not understood", text.trim())),
        }
    };
    inside.split(',').map(read).collect()
}

/// Pitch of a metric thread by its diameter, mm: the coarse series of ISO 261.
pub(super) fn coarse_pitch(diameter: f64) -> Option<f64> {
    const SERIES: [(f64, f64); 23] = [
        (3.0, 0.5),
        (3.5, 0.6),
        (4.0, 0.7),
        (5.0, 0.8),
        (6.0, 1.0),
        (8.0, 1.25),
        (10.0, 1.5),
        (12.0, 1.75),
        (14.0, 2.0),
        (16.0, 2.0),
        (18.0, 2.5),
        (20.0, 2.5),
        (22.0, 2.5),
        (24.0, 3.0),
        (27.0, 3.0),
        (30.0, 3.5),
        (33.0, 3.5),
        (36.0, 4.0),
        (39.0, 4.0),
        (42.0, 4.5),
        (45.0, 4.5),
        (48.0, 5.0),
        (52.0, 5.0),
    ];
    SERIES.into_iter().find(|(own, _)| *own == diameter).map(|(_, pitch)| pitch)
}
