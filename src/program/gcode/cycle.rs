//! Drilling cycles of G-code, expanded as the controller does: over the hole, down to R, to the
//! bottom, and out.

use nalgebra::Vector3;

use super::block::Block;
use super::rotary;
use super::state::{AXES, Cycle, CycleKind, Height, Machine, Motion, Tip};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::arc::Plane;
use crate::program::cutter::{FeedKind, Hole};
use crate::program::log::States;

/// Of a cycle, and of pecks in a hole.
const MAX_REPEATS: f64 = 10_000.0;

/// Cosine between tool and hole from which on a hole is along the tool: less is no rounding.
const ALIGNED: f64 = 1.0 - 1e-9;

/// How far over the last depth a peck stops, mm: 0.010 inch.
const CLEARANCE_MM: f64 = 0.254;

impl Machine<'_> {
    /// G73–G89.
    pub(super) fn start_cycle(&mut self, code: i64) {
        let kind = match code {
            730 | 810 | 820 | 860 => CycleKind::Drill,
            830 => CycleKind::Peck,
            740 | 840 | 850 | 890 => CycleKind::Bore,
            other => CycleKind::Unknown(other / 10),
        };
        if !matches!(self.motion, Motion::Cycle(_)) {
            self.was_rapid = self.motion == Motion::Rapid;
            let Plane([.., w]) = self.plane;
            self.cycle = Cycle { initial: self.cutter.at[w], ..Cycle::default() };
        }
        self.cycle.is_tap = matches!(code, 740 | 840);
        if self.cycle.code != code {
            // Others dwell by a P of their own alone.
            self.cycle.dwells = matches!(code, 820 | 890);
        }
        self.cycle.code = code;
        self.cycle.breaks_chips = code == 730;
        self.motion = Motion::Cycle(kind);
    }

    /// G80. To Fanuc, cycles are a group of their own and G0 holds again; to LinuxCNC nothing does.
    /// Behind G1 the two differ in what moves.
    pub(super) fn end_cycle(&mut self) {
        let goes_on = match self.motion {
            Motion::Cycle(_) => self.was_rapid,
            other => other == Motion::Rapid,
        };
        self.motion = if goes_on { Motion::Rapid } else { Motion::None };
    }

    /// A hole, or several in a row where L or K repeats a relative block.
    pub(super) fn drill(
        &mut self,
        line: usize,
        block: &Block,
        kind: CycleKind,
    ) -> Result<(), String> {
        if self.turned.is_some() && self.relative {
            return Err("G91 under G68 is not supported".to_owned());
        }
        if let CycleKind::Unknown(code) = kind {
            return Err(format!("G{code} is not supported"));
        }
        let Plane([u, v, w]) = self.plane;
        if self.polar.is_on && self.relative && block.has_any(&[AXES[u], AXES[v]]) {
            return Err("relative polar coordinates are not supported".to_owned());
        }
        self.no_corner()?;
        let feed = self.cutter.pace()?;
        if self.cutter.feed.kind == FeedKind::InverseTime {
            return Err("a cycle in inverse time is not supported".to_owned());
        }
        let pattern = self.pattern_of(block);
        if pattern.is_none() && block.has_any(b"IJ") {
            return Err("I and J in a cycle are not read: in G73 and G83 of Haas they make every \
                        peck less deep than the one before; have pecks of one depth written, by Q"
                .to_owned());
        }
        let repeats = if pattern.is_some() { 1.0 } else { self.repeats(line, block)? };
        if repeats == 0.0 && self.rotary.turns_by(block, self.relative) {
            return Err("a rotary axis beside L0 or K0 of a cycle is not supported".to_owned());
        }
        let mut has_turned = self.cutter.place().is_none();
        let before = match self.cutter.place() {
            Some(place) => place,
            // Words are kept, and nothing moves.
            None if repeats == 0.0 => Vector3::zeros(),
            None => self.over_first_hole(line, block)?,
        };
        let [retract, bottom, step] =
            [b'R', AXES[w], b'Q'].map(|letter| block.word(letter).map(|word| self.mm(word.value)));
        let height = if self.relative { Height::Relative } else { Height::Word };
        self.cycle.retract = retract.map(height).or(self.cycle.retract);
        self.cycle.bottom = bottom.map(height).or(self.cycle.bottom);
        self.cycle.step = step.or(self.cycle.step);
        if let Some(word) = block.word(b'P') {
            self.cycle.dwell_s = self.dwell_s(line, word)?;
            self.cycle.dwells |= !matches!(self.cycle.code, 810 | 850);
        }
        let given_r = self.cycle.retract.ok_or(match self.is_sinumerik {
            true => {
                "the cycle has no R; with R parameters (R2=, R3=, R10=) it is one of older \
                 controls (Sinumerik 810, 840C): not supported, have CYCLE81 to CYCLE85 written"
            }
            false => "the cycle has no R",
        })?;
        let name = char::from(AXES[w]);
        let given_z = self.cycle.bottom.ok_or_else(|| format!("the cycle has no {name}"))?;
        let shift = self.shift.total()[w];
        let is_of_mode = |height| matches!(height, Height::Relative(_)) == self.relative;
        if !(is_of_mode(given_r) && is_of_mode(given_z)) {
            let what = "a cycle goes on behind a change of G90 and G91: it is taken to keep its \
                        levels, as on Fanuc and Haas; LinuxCNC reads R and its depth anew";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        } else if matches!(given_r, Height::Relative(_)) && self.cutter.at[w] != self.cycle.initial
        {
            let what = "R under G91 is taken to count from the initial level, as on Fanuc; \
                        LinuxCNC counts it from where the tool is before each block";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        let level = |height: Height, from: f64| match height {
            Height::Word(value) => value + shift,
            Height::Relative(by) => from + by,
        };
        let retract = match (given_r, self.cycle.initial) {
            (Height::Relative(_), None) => return Err(self.unknown_height(w)),
            (height, initial) => level(height, initial.unwrap_or_default()),
        };
        let bottom = level(given_z, retract);
        if bottom > retract {
            return Err(format!("the bottom ({name} {bottom}) lies above R ({retract})"));
        }
        if let Some(word) = block.word(b'Q')
            && !word.has_point
            && word.value.fract() == 0.0
            && self.mm(word.value) > retract - bottom
        {
            let what = format!(
                "Q{} without a decimal point is more than the depth, and no peck: controllers that \
                 take it in micrometres peck",
                word.value
            );
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        let depths = self.depths(kind, retract, bottom)?;
        if depths.len() > 1 {
            self.tell_clearance(line);
        }
        if self.cycle.is_tap {
            self.cutter.taps(line);
            if self.cutter.feed.kind == FeedKind::PerMinute {
                self.cutter.log.states(line, None, States::Tap);
            }
        }
        let by = |axis: usize| block.word(AXES[axis]).map_or(0.0, |word| self.mm(word.value));
        let (by_u, by_v) = (by(u), by(v));
        let initial = match self.cycle.initial {
            _ if !self.back_to_initial => retract,
            Some(initial) => initial.max(retract),
            None => return Err(self.unknown_height(w)),
        };
        if kind == CycleKind::Bore && !self.cycle.is_tap && initial > retract {
            self.tell_way_out(line);
        }
        let out = if kind == CycleKind::Bore { feed } else { Pace::Rapid };
        let hole = Hole {
            clearance: retract,
            lifts: vec![self.cycle.breaks_chips.then_some(CLEARANCE_MM); depths.len()],
            depths,
            over_peck: CLEARANCE_MM,
            retract: initial,
            feed,
            out,
            lift: out,
            dwell_s: if self.cycle.dwells { self.cycle.dwell_s } else { 0.0 },
            dwell_peck_s: 0.0,
            dwell_out_s: 0.0,
        };
        let mut over = before;
        let at = self.cutter.at;
        let stays = |end: [Option<f64>; 3]| (end[u], end[v]) == (at[u], at[v]);
        let would_go = repeats == 0.0 && !self.end_of(block).is_ok_and(stays);
        if repeats > 0.0 {
            self.starts(line);
            self.tell_place(line, block);
        }
        let places = match pattern {
            Some(code) => self.bolt_holes(code, block)?,
            None => Vec::new(),
        };
        self.cycle.asks_for_place = pattern.is_some() || would_go;
        // Whole and at most MAX_REPEATS, checked above.
        let count = if pattern.is_some() { places.len() } else { repeats as usize };
        for index in 0..count {
            if let Some(&[at_u, at_v]) = places.get(index) {
                (over[u], over[v]) = (at_u, at_v);
            } else if self.relative {
                (over[u], over[v]) = (over[u] + by_u, over[v] + by_v);
            } else {
                let to = self.end_of(block)?;
                (over[u], over[v]) = (to[u].unwrap_or(over[u]), to[v].unwrap_or(over[v]));
            }
            over[w] = 0.0;
            let turns = if std::mem::take(&mut has_turned) { None } else { Some(block) };
            self.drill_over(line, turns, over, &hole)?;
            if self.cutter.log.is_full() {
                break;
            }
        }
        Ok(())
    }

    /// How often L or K says that the block is run.
    fn repeats(&mut self, line: usize, block: &Block) -> Result<f64, String> {
        let repeats = block.get('L').or(block.get('K')).unwrap_or(1.0);
        let may_be_depth = matches!(self.cycle.code, 730 | 830) && block.word(b'K').is_some();
        if !(0.0..=MAX_REPEATS).contains(&repeats) || repeats.fract() != 0.0 {
            let more = match may_be_depth {
                true => "; K of G73 and G83 is a depth on Haas, which is not read: leave it out",
                false => "",
            };
            return Err(format!("{repeats} repeats: expected a whole number from 0{more}"));
        }
        let what = if may_be_depth {
            "K of G73 and G83 is taken as the number of holes, as on Fanuc: on Haas it is a depth \
             behind which the tool goes back to R, and L is the number of holes"
        } else if repeats > 1.0 && !self.relative && !self.is_sinumerik {
            "L or K repeats the hole at one place under G90: a row of holes needs G91"
        } else {
            return Ok(repeats);
        };
        self.cutter.log.warning(Code::MotionLeftOut, line, what);
        Ok(repeats)
    }

    /// A hole that counts from a place of which the manuals do not say where it is.
    fn tell_place(&mut self, line: usize, block: &Block) {
        let Plane([u, v, _]) = self.plane;
        let is_stated = [u, v].iter().all(|axis| block.word(AXES[*axis]).is_some());
        if self.cycle.asks_for_place && (self.relative || !is_stated) {
            let what = "behind a pattern of holes, or X and Y beside L0 or K0, the next hole is \
                        taken to count from where the last one was drilled: write X and Y of it \
                        (of a pattern, its centre) under G90";
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// Over a hole at rapid, as the rotary axes of `block` turn, down, and out: to Fanuc and Haas,
    /// A, B and C belong to the place of the hole. To LinuxCNC a turn in a cycle is an error.
    fn drill_over(
        &mut self,
        line: usize,
        block: Option<&Block>,
        over: Vector3<f64>,
        hole: &Hole,
    ) -> Result<(), String> {
        let Plane([.., w]) = self.plane;
        let up = Vector3::ith(w, 1.0);
        let block = block.filter(|block| block.has_any(&rotary::LETTERS));
        // Up to R before anything turns.
        if let (Some(_), Some(place)) = (block, self.cutter.place())
            && place[w] < hole.clearance
        {
            self.line_to(line, place + up * (hole.clearance - place[w]), Pace::Rapid, None)?;
        }
        let turns = block.map(|block| self.turn(line, block, Tip::Rapid)).transpose()?;
        let turns = turns == Some(true);
        let along = self.rotary.way_in_work(up);
        self.refuse_across(along)?;
        if !(turns || self.rotary.moves_work()) {
            self.cutter.hole(line, over, up, hole);
            return Ok(());
        }
        let zero = self.rotary.in_work(over);
        if let Some(place) = self.cutter.place() {
            let height = place[w].max(hole.clearance);
            if turns || place != over + up * height {
                self.line_to(line, over + up * height, Pace::Rapid, None)?;
            }
            self.cutter.at = (zero + along * height).map(Some).into();
        }
        self.cutter.straight_to_hole(line, zero, along, hole);
        // Where the text has it.
        self.cutter.at = (over + up * hole.retract).map(Some).into();
        Ok(())
    }

    /// A hole along `along` in the work, where a rotary axis or a direction of the tool turns the
    /// tool away from it. Where nothing turns it, a head may hold it along the plane's axis.
    pub(super) fn refuse_across(&self, along: Vector3<f64>) -> Result<(), String> {
        let unturned = self.rotary.untilted();
        let turns = self.rotary.turns_tool() || self.cutter.axis.dot(&unturned) < ALIGNED;
        if turns && self.cutter.axis.dot(&along) < ALIGNED {
            let what = "a cycle while the tool is turned away from the hole's axis would drill \
                        across the tool: not supported";
            return Err(what.to_owned());
        }
        Ok(())
    }

    /// The cycle begins with a rapid move over its first hole, to where rotary axes turn, too:
    /// level where the height is known, else to R, where it goes back there.
    fn over_first_hole(&mut self, line: usize, block: &Block) -> Result<Vector3<f64>, String> {
        let Plane([u, v, w]) = self.plane;
        self.turn(line, block, Tip::Rapid)?;
        let (at, to) = (self.cutter.at, self.end_of(block)?);
        let mut over = Vector3::zeros();
        for axis in [u, v] {
            over[axis] = to[axis].ok_or_else(|| unknown_before_cycle(axis))?;
        }
        match at[w] {
            Some(height) => {
                over[w] = height;
                self.line_to(line, over, Pace::Rapid, None)?;
            }
            None if self.back_to_initial || self.relative => return Err(self.unknown_height(w)),
            None => {}
        }
        Ok(over)
    }

    /// Where the cycle needs the height before it.
    fn unknown_height(&self, w: usize) -> String {
        let remedy = if self.relative { "" } else { ", or G99 to go back to R alone" };
        format!("{}{remedy}", unknown_before_cycle(w))
    }

    fn tell_way_out(&mut self, line: usize) {
        let what = "G85 and G89 are left at the feed up to R and at rapid from there to the \
                    initial level, as on Fanuc and Haas: LinuxCNC goes on at the feed behind \
                    G89, and older RS-274 controllers behind G85, too";
        self.tell_time(line, what);
    }

    /// What changes the time alone, which matters where the spindle's speed follows it.
    pub(super) fn tell_time(&mut self, line: usize, what: &str) {
        let code = if self.is_scheduled { Code::UnitAssumed } else { Code::Assumed };
        self.cutter.log.warning(code, line, what);
    }

    fn tell_clearance(&mut self, line: usize) {
        let what = format!(
            "pecks stop {CLEARANCE_MM} mm over the last depth, and chips are broken by a way back \
             of as much, as LinuxCNC has it: on other controllers a parameter says how far"
        );
        self.tell_time(line, &what);
    }

    fn depths(&self, kind: CycleKind, retract: f64, bottom: f64) -> Result<Vec<f64>, String> {
        let step = match (kind, self.cycle.step) {
            (CycleKind::Peck, step) => step.ok_or("G83 has no Q")?,
            (_, Some(step)) if self.cycle.breaks_chips => step,
            _ => return Ok(vec![bottom]),
        };
        let count = ((retract - bottom) / step).ceil().max(1.0);
        if !(step > 0.0 && count <= MAX_REPEATS) {
            return Err(format!("Q is {step} mm for a depth of {} mm", retract - bottom));
        }
        // At least 1 and at most MAX_REPEATS.
        let steps = 1..=count as u32;
        Ok(steps.map(|peck| (retract - f64::from(peck) * step).max(bottom)).collect())
    }
}

/// What a cycle needs of an axis that it does not state itself.
pub(super) fn unknown_before_cycle(axis: usize) -> String {
    let name = char::from(AXES[axis]);
    format!("{name} is not known before the cycle: program {name} by a rapid move before it")
}
