//! Sinumerik's drilling cycles, where they stand or at every position behind MCALL: CYCLE81 to
//! CYCLE83 and CYCLE85 (Siemens, SINUMERIK 840D sl/828D Fundamentals, "Programming cycles
//! externally"). Others are refused.

use nalgebra::Vector3;

use super::expression::{Parameters, Reader, not_vacant};
use super::state::Machine;
use crate::program::Pace;
use crate::program::arc::Plane;
use crate::program::cutter::{Feed, FeedKind, Hole};
use crate::program::log::States;

/// Pecks in a hole.
const MOST_PECKS: usize = 10_000;

/// How far the drill goes back to break chips where the call has no _VRT, mm.
const CHIP_BREAK_MM: f64 = 1.0;

/// How far over the last depth a peck stops where the call has no _DIS1: so much, of deep holes a
/// share of the depth, mm.
const PECK_CLEARANCE_MM: f64 = 0.6;
const PECK_CLEARANCE_SHARE: f64 = 1.0 / 50.0;
const MOST_PECK_CLEARANCE_MM: f64 = 7.0;

/// A call: its parameters by their place, `None` where nothing stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DrillingCall {
    cycle: Cycle,
    parameters: Vec<Option<f64>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cycle {
    /// 81 and 82, with a dwell.
    Drill,
    /// 83.
    Peck,
    /// 85: out at a feed.
    Ream,
}

impl DrillingCall {
    /// Reads what stands between the parentheses of a call.
    pub(super) fn read(name: &str, inside: &str, known: &Parameters) -> Result<Self, String> {
        let cycle = match name {
            "CYCLE81" | "CYCLE82" => Cycle::Drill,
            "CYCLE83" => Cycle::Peck,
            "CYCLE85" => Cycle::Ream,
            _ => {
                return Err(format!(
                    "{name}: of Sinumerik's cycles CYCLE81, 82, 83 and 85 alone are supported"
                ));
            }
        };
        let read = |text: &str| {
            if text.trim().is_empty() {
                return Ok(None);
            }
            let mut reader = Reader::new(text.as_bytes(), 0, known);
            let value = not_vacant(reader.expression()?)?;
            match reader.peek() {
                None => Ok(Some(value)),
                Some(_) => Err(format!("{name}: '{}' is not understood", text.trim())),
            }
        };
        let parameters = inside.split(',').map(read).collect::<Result<_, String>>()?;
        Ok(Self { cycle, parameters })
    }

    fn get(&self, place: usize) -> Option<f64> {
        self.parameters.get(place).copied().flatten()
    }

    /// A digit of the word that says how the others count, from the right.
    fn mode(&self, digit: i32) -> i64 {
        let place = match self.cycle {
            Cycle::Drill => 8,
            Cycle::Peck => 19,
            Cycle::Ream => 10,
        };
        // Saturates; modes have seven digits.
        let word = self.get(place).unwrap_or(0.0).abs() as i64;
        word / 10_i64.pow(digit.unsigned_abs()) % 10
    }

    /// A depth from an absolute and a relative word, mm in the program's coordinates.
    fn depth(
        &self,
        [absolute, relative]: [usize; 2],
        mode: i64,
        surface: f64,
    ) -> Result<Option<f64>, String> {
        let by = self.get(relative).map(|depth| surface - depth.abs());
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

    /// Below the reference plane, mm, positive: each peck, with the degression of CYCLE83.
    fn pecks(&self, depth: f64, first: f64) -> Result<Vec<f64>, String> {
        let least = self.get(13).filter(|least| *least > 0.0);
        let less = self.get(7).unwrap_or(0.0);
        if less < 0.0 && least.is_none() {
            return Err("DAM is a factor, and the cycle has no _MDEP".to_owned());
        }
        let (mut depths, mut at, mut stroke) = (Vec::new(), 0.0, first);
        while depth - at > 1e-9 {
            let left = depth - at;
            // What is left is drilled in two equal strokes.
            let own = if less != 0.0 && at > 0.0 && left > stroke && left < 2.0 * stroke {
                left / 2.0
            } else {
                stroke.min(left)
            };
            if !(own > 0.0) || depths.len() >= MOST_PECKS {
                return Err(format!("a first depth of {first} mm gives no pecks"));
            }
            at += own;
            depths.push(at);
            let next = if less < 0.0 { stroke * -less } else { stroke - less };
            let floor = least.unwrap_or(if less > 0.0 { less } else { 0.0 });
            stroke = next.max(floor).min(stroke);
        }
        Ok(depths)
    }
}

impl Machine<'_> {
    /// A hole where the tool is.
    pub(super) fn drill_call(&mut self, line: usize, call: &DrillingCall) -> Result<(), String> {
        self.no_corner()?;
        let Plane([.., w]) = self.plane;
        if self.rotary.moves_work() || self.cutter.feed.kind == FeedKind::InverseTime {
            return Err("a cycle in inverse time or on turned work is not supported".to_owned());
        }
        let place = self.cutter.place().ok_or("a cycle from an unknown position")?;
        let need =
            |at: usize, name: &str| call.get(at).ok_or_else(|| format!("the cycle has no {name}"));
        let surface = need(1, "RFP")?;
        let back = need(0, "RTP")?;
        let clearance = need(2, "SDIS")?.abs();
        let depth = call.depth([3, 4], call.mode(0), surface)?;
        let depth = surface - depth.ok_or("the cycle has no DP and no DPR")?;
        if !(depth > 0.0 && back >= surface) {
            return Err(format!(
                "the bottom must lie {depth} mm below RFP, and RTP ({back}) not below it"
            ));
        }
        let shank = match call.cycle {
            Cycle::Drill => 6,
            Cycle::Peck => 17,
            Cycle::Ream => 8,
        };
        if call.get(shank).is_some_and(|mode| mode != 0.0) {
            return Err("a depth to the drill's shank is not supported".to_owned());
        }
        let feed = self.cutter.pace()?;
        let of_words = |own: &Self, at: usize| {
            let value = call.get(at).filter(|feed| *feed > 0.0);
            let value = value.map(|feed| own.mm(feed));
            let pace = value.map(|_| own.cutter.pace_of(Feed { value, ..own.cutter.feed }));
            pace.transpose()
        };
        let (feed, out) = match call.cycle {
            Cycle::Ream => {
                let [own, out] = [6, 7].map(|at| of_words(self, at));
                for value in [6, 7].into_iter().filter_map(|at| call.get(at)) {
                    self.cutter.log.states(line, None, States::Feed { value });
                }
                let feed = own?.unwrap_or(feed);
                (feed, out?.unwrap_or(feed))
            }
            _ => (feed, Pace::Rapid),
        };
        let dwell = |at: usize, digit: i32| self.dwell_of(call, at, digit);
        let (mut dwell_s, mut dwell_peck_s, mut dwell_out_s) = (dwell(5, 1)?, 0.0, 0.0);
        let (mut depths, mut lift, mut over_peck) = (vec![depth], None, 0.0);
        if call.cycle == Cycle::Peck {
            if call.get(10).is_some_and(|factor| factor != 0.0 && factor != 1.0) {
                return Err("FRF, a feed of its own for the first depth, is not supported".into());
            }
            let first = call.depth([5, 6], call.mode(4), surface)?;
            let first = surface - first.ok_or("the cycle has no FDEP and no FDPR")?;
            depths = call.pecks(depth, first)?;
            (dwell_peck_s, dwell_out_s) = (dwell(8, 1)?, dwell(9, 2)?);
            dwell_s = match dwell(15, 3)? {
                own if own > 0.0 => own,
                _ => dwell_peck_s,
            };
            let given = |at: usize| call.get(at).filter(|length| *length > 0.0);
            // VARI 0 breaks chips, 1 takes them out.
            lift = (call.get(11).unwrap_or(0.0) == 0.0)
                .then(|| given(14).map_or(CHIP_BREAK_MM, |back| self.mm(back)));
            let own = (self.mm(depth) * PECK_CLEARANCE_SHARE)
                .clamp(PECK_CLEARANCE_MM, MOST_PECK_CLEARANCE_MM);
            over_peck = given(16).map_or(own, |distance| self.mm(distance));
        }
        let origin = self.shift.total()[w];
        let [surface, back, clearance] = [surface, back, clearance].map(|length| self.mm(length));
        let hole = Hole {
            clearance: origin + surface + clearance,
            lifts: vec![lift; depths.len()],
            depths: depths.iter().map(|depth| origin + surface - self.mm(*depth)).collect(),
            over_peck,
            retract: origin + back,
            feed,
            out,
            dwell_s,
            dwell_peck_s,
            dwell_out_s,
        };
        let mut over = place;
        over[w] = 0.0;
        self.cutter.hole(line, over, Vector3::ith(w, 1.0), &hole);
        Ok(())
    }

    /// Seconds, or turns of the spindle where the value is negative or the mode says so.
    fn dwell_of(&self, call: &DrillingCall, at: usize, digit: i32) -> Result<f64, String> {
        let value = call.get(at).unwrap_or(0.0);
        if value == 0.0 || !(value < 0.0 || call.mode(digit) == 2) {
            return Ok(value);
        }
        match self.cutter.rpm {
            Some(rpm) if rpm > 0.0 => Ok(value.abs() / crate::units::hz_from_rpm(rpm)),
            _ => Err("a dwell in turns, but the spindle's speed is not known".to_owned()),
        }
    }
}
