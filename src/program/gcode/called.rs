//! A call of Sinumerik's drilling cycles → its hole.

use nalgebra::Vector3;

use super::cycle::unknown_before_cycle;
use super::siemens::{Cycle, DrillingCall, coarse_pitch};
use super::state::Machine;
use crate::notes::Code;
use crate::program::arc::Plane;
use crate::program::cutter::{self, Feed, FeedKind, Hole};
use crate::program::log::States;
use crate::program::{Pace, Spindle};
use crate::units::{hz_from_rpm, m_per_s_from_mm_per_min};

/// How far the drill goes back to break chips where the call has no _VRT, mm.
const CHIP_BREAK_MM: f64 = 1.0;

impl Machine<'_> {
    /// A hole where the tool is in the plane: the heights are the call's own.
    pub(super) fn drill_call(&mut self, line: usize, call: &DrillingCall) -> Result<(), String> {
        self.no_corner()?;
        let Plane([u, v, w]) = self.plane;
        if self.rotary.moves_work() || self.cutter.feed.kind == FeedKind::InverseTime {
            return Err("a cycle in inverse time or on turned work is not supported".to_owned());
        }
        self.refuse_across(Vector3::ith(w, 1.0))?;
        let mut over = Vector3::zeros();
        for axis in [u, v] {
            over[axis] = self.cutter.at[axis].ok_or_else(|| unknown_before_cycle(axis))?;
        }
        call.refuse_others(w)?;
        let need =
            |at: usize, name: &str| call.get(at).ok_or_else(|| format!("the cycle has no {name}"));
        let surface = need(1, "RFP")?;
        let back = need(0, "RTP")?;
        let clearance = need(2, "SDIS")?.abs();
        let depth = call.depth([3, 4], call.mode(0), surface)?;
        let depth = surface - depth.ok_or("the cycle has no DP and no DPR")?;
        if depth <= 0.0 {
            return Err(format!("the bottom must lie below RFP ({surface})"));
        }
        if back < surface {
            return Err(format!("RTP ({back}) must not lie below RFP ({surface})"));
        }
        let shank = match call.cycle {
            Cycle::Drill => Some(6),
            Cycle::Peck => Some(17),
            Cycle::Ream => Some(8),
            Cycle::Tap => None,
        };
        if shank.and_then(|at| call.get(at)).is_some_and(|mode| mode != 0.0) {
            return Err("a depth to the drill's shank is not supported".to_owned());
        }
        let feed = match call.cycle {
            Cycle::Tap => Pace::Unstated,
            _ => self.cutter.pace()?,
        };
        let of_words = |own: &Self, at: usize| {
            let value = call.get(at).filter(|feed| *feed > 0.0);
            let value = value.map(|feed| own.feed_in(own.cutter.feed.kind, feed));
            let pace = value.map(|_| own.cutter.pace_of(Feed { value, ..own.cutter.feed }));
            pace.transpose()
        };
        let mut tapped = None;
        let (feed, out) = match call.cycle {
            Cycle::Ream => {
                let [own, out] = [6, 7].map(|at| of_words(self, at));
                let given = [6, 7].into_iter().filter_map(|at| call.get(at));
                for value in given.filter(|value| *value > 0.0) {
                    self.tell_basic_feed(line, self.feed_unit);
                    let states = match self.cutter.feed.kind {
                        FeedKind::PerRevolution => States::FeedPerRevolution,
                        _ => States::Feed { value },
                    };
                    self.cutter.log.states(line, None, states);
                }
                let feed = own?.unwrap_or(feed);
                (feed, out?.unwrap_or(feed))
            }
            Cycle::Tap => {
                let (pitch, turns) = thread(call)?;
                tapped = Some(turns);
                let [feed, out] = turns.map(|rpm| Pace::Feed(m_per_s_from_mm_per_min(pitch * rpm)));
                (feed, out)
            }
            _ => (feed, Pace::Rapid),
        };
        if call.cycle == Cycle::Peck {
            call.refuse_modes()?;
            self.whole_feed(line, call)?;
        }
        let dwell = |at: usize, digit: i32| self.dwell_of(call, at, digit);
        let dwell_s = match call.cycle {
            Cycle::Peck => match dwell(15, 3)? {
                own if own > 0.0 => own,
                _ => dwell(8, 1)?,
            },
            _ => dwell(5, 1)?,
        };
        let (mut dwell_peck_s, mut dwell_out_s) = (0.0, 0.0);
        let (mut depths, mut lift, mut over_peck) = (vec![depth], None, 0.0);
        if call.cycle == Cycle::Peck {
            let first = call.depth([5, 6], call.mode(4), surface)?;
            let first = surface - first.ok_or("the cycle has no FDEP and no FDPR")?;
            depths = call.pecks(depth, first)?;
            (dwell_peck_s, dwell_out_s) = (dwell(8, 1)?, dwell(9, 2)?);
            let given = |at: usize| call.get(at).filter(|length| *length > 0.0);
            // VARI 0 breaks chips, 1 takes them out.
            lift = (call.get(11).unwrap_or(0.0) == 0.0)
                .then(|| given(14).map_or(CHIP_BREAK_MM, |back| self.mm(back)));
            over_peck = given(16).map_or(cutter::over_peck(self.mm(depth)), |over| self.mm(over));
        }
        self.shift.goes_by_zero(w);
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
            // Chips are broken by a way back at the feed.
            lift: feed,
            dwell_s,
            dwell_peck_s,
            dwell_out_s,
        };
        self.starts(line);
        match tapped {
            Some(turns) => {
                self.tap(line, |height| over + Vector3::ith(w, height), &hole, turns);
                self.end_tap(line, call);
            }
            None => self.cutter.hole(line, over, Vector3::ith(w, 1.0), &hole),
        }
        self.cuts(line);
        self.tell_length(line, true, true);
        Ok(())
    }

    /// To the clearance as the spindle turned before, then in and out each at a speed of its own.
    fn tap(
        &mut self,
        line: usize,
        above: impl Fn(f64) -> Vector3<f64>,
        hole: &Hole,
        [speed, back]: [f64; 2],
    ) {
        let axis = above(1.0) - above(0.0);
        self.cutter.over_hole(line, above(0.0), axis, hole.clearance);
        self.cutter.apart(line, above(hole.clearance), Pace::Rapid);
        self.cutter.taps(line);
        self.cutter.log.states(line, None, States::Tap);
        self.turns_by_call(line, speed);
        for &depth in &hole.depths {
            self.cutter.apart(line, above(depth), hole.feed);
        }
        self.cutter.log.dwell(line, hole.dwell_s);
        self.turns_by_call(line, back);
        self.cutter.apart(line, above(hole.clearance), hole.out);
        self.cutter.apart(line, above(hole.retract), Pace::Rapid);
    }

    /// A speed that is a word of the call, at which no new number can be written.
    fn turns_by_call(&mut self, line: usize, rpm: f64) {
        self.cutter.log.states(line, None, States::speed(rpm));
        self.cutter.log.spindle(line, Spindle::at(Some(rpm)));
    }

    /// SDAC: which way the spindle turns behind the tap, at the speed that was programmed before.
    fn end_tap(&mut self, line: usize, call: &DrillingCall) {
        let turns = matches!(call.get(6).map(|code| code as i64), Some(3 | 4));
        self.cutter.turn_spindle(line, turns);
    }

    /// CYCLE83: whether FRF gives the first depth a feed of its own.
    fn whole_feed(&mut self, line: usize, call: &DrillingCall) -> Result<(), String> {
        match (call.get(10).unwrap_or(0.0), call.has_mode()) {
            (1.0, true) => {
                let what = "FRF of CYCLE83 is 1 beside _AMODE: where it is in percent there, the \
                            first depth is drilled at a hundredth of the feed; it is taken as the \
                            whole feed; write 100, or leave it out";
                self.cutter.log.warning(Code::ChangeIgnored, line, what);
                Ok(())
            }
            (0.0 | 1.0, _) | (100.0, true) => Ok(()),
            (factor, _) => Err(format!(
                "FRF={factor}, a feed of its own for the first depth, is not supported: write 1, \
                 or 100 (percent) beside _AMODE"
            )),
        }
    }

    /// Seconds, or turns of the spindle where the value is negative or the mode says so.
    fn dwell_of(&self, call: &DrillingCall, at: usize, digit: i32) -> Result<f64, String> {
        let value = call.get(at).unwrap_or(0.0);
        if value == 0.0 || !(value < 0.0 || call.mode(digit) == 2) {
            return Ok(value);
        }
        match self.cutter.rpm {
            Some(rpm) if rpm > 0.0 => Ok(value.abs() / hz_from_rpm(rpm)),
            _ => Err("a dwell in turns, but the spindle's speed is not known".to_owned()),
        }
    }
}

/// CYCLE84: the pitch, mm, and the speeds into the hole and out of it.
fn thread(call: &DrillingCall) -> Result<(f64, [f64; 2]), String> {
    let size = |at: usize| call.get(at).map(f64::abs).filter(|size| *size > 0.0);
    if call.get(13).is_some_and(|unit| unit != 0.0 && unit != 1.0) {
        return Err("CYCLE84: a pitch in another unit than mm is not supported".to_owned());
    }
    if call.get(15).is_some_and(|kind| kind != 0.0) {
        return Err("CYCLE84: tapping in several strokes is not supported".to_owned());
    }
    let of_size = size(7).map(|size| {
        coarse_pitch(size).ok_or_else(|| format!("MPIT: M{size} has no pitch of its own"))
    });
    let pitch = match (of_size.transpose()?, size(8)) {
        (Some(a), Some(b)) if a != b => {
            return Err("MPIT and PIT give different pitches".to_owned());
        }
        (of_size, pitch) => of_size.or(pitch).ok_or("CYCLE84 has no MPIT and no PIT")?,
    };
    let speed = size(10).ok_or("CYCLE84 has no SST")?;
    Ok((pitch, [speed, size(11).unwrap_or(speed)]))
}
