//! Cycles: drilling and tapping, and those that neither move nor shift.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::block::{Block, Word};
use super::{Reader, is_of_motion, is_rapid};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::cutter::{Feed, FeedKind, Hole, over_peck};
use crate::program::log::States;
use crate::program::span::Span;
use crate::units::{hz_from_rpm, m_per_s_from_mm_per_min};

/// This feed in a Q parameter stands for FMAX.
const FMAX_MM_PER_MIN: f64 = 99_999.0;

/// Drilling, reaming, universal drilling and pecking, tapping with and without a floating holder.
const DRILLING: [f64; 6] = [200.0, 201.0, 203.0, 205.0, 206.0, 207.0];

/// Q256 where the cycle does not have it, mm.
const CHIP_BREAK_MM: f64 = 0.2;

/// A drilling cycle: its number, its line, and each Q with its place in the text.
#[derive(Clone)]
pub(super) struct Cycle {
    number: f64,
    line: usize,
    values: HashMap<String, (f64, Option<Span>)>,
}

impl Cycle {
    /// Whether it has a parameter, by its number.
    pub(super) fn has(&self, number: u32) -> bool {
        self.values.contains_key(&format!("Q{number}"))
    }
}

impl Reader<'_, '_> {
    /// CYCL DEF: drilling, or what neither moves nor shifts.
    pub(super) fn define(&mut self, line: usize, block: &Block<'_>) -> Result<(), String> {
        let number = block.words.get(2).filter(|word| word.name.is_empty());
        let number = number.and_then(|word| word.value).ok_or("a cycle without a number")?;
        match number {
            _ if DRILLING.contains(&number) => {
                let values = self.values(block)?;
                complete(number, &values)?;
                self.cycle = Some(Cycle { number, line, values });
                self.is_refused = false;
                Ok(())
            }
            _ if number == 9.0 => Ok(()),
            _ if number.floor() == 9.0 => {
                let seconds = block.words.iter().skip(3).find_map(|word| word.value);
                let seconds = seconds.ok_or("a dwell without a time")?;
                self.cutter.log.dwell(line, seconds);
                Ok(())
            }
            // Tolerance, preset by number, thermal and the like.
            _ if number == 247.0 => {
                self.choose_preset(line, block.get("Q339"));
                Ok(())
            }
            _ if number.floor() == 32.0 || number == 392.0 => Ok(()),
            _ if number.floor() == 7.0 => self.shift_work(block),
            _ if number.floor() == 1.0 => self.pecking(line, number, block),
            // Of a cycle that is refused, its title alone is told.
            _ if number.fract() != 0.0 && self.is_refused => Ok(()),
            // Turns that are zero, behind a title; a mirror names axes alone.
            _ if matches!(number.floor() as i64, 8 | 10 | 19) => {
                let is_title = number.fract() == 0.0;
                // A number alone is a row of a table.
                let says_zero = |word: &Word<'_>| match word.value {
                    Some(value) => value == 0.0 && (is_title || !word.name.is_empty()),
                    None => is_title && word.sign.is_none() && !is_of_motion(word.name),
                };
                if block.words.iter().skip(3).all(says_zero) {
                    Ok(())
                } else {
                    Err(format!("cycle {number} shifts or turns the work and is not supported"))
                }
            }
            _ if number == 208.0 => Err("cycle 208 mills a helix whose radius the control works \
                                         out from the tool's in its tool table, which no program \
                                         states: have the motion written out"
                .to_owned()),
            _ if (251.0..=254.0).contains(&number) || (256.0..=258.0).contains(&number) => {
                Err(format!(
                    "cycle {number} mills on ways that the control works out by itself from the \
                     tool's radius and the overlap: have the motion written out"
                ))
            }
            _ => Err(format!("cycle {number} is not supported")),
        }
    }

    /// FUNCTION DWELL: TIME in seconds, REV in turns of the spindle.
    pub(super) fn dwell(&mut self, line: usize, block: &Block<'_>) -> Result<(), String> {
        let is_other = |word: &&Word<'_>| !matches!(word.name, "TIME" | "REV");
        if let Some(word) = block.words.iter().skip(2).find(is_other) {
            return Err(format!(
                "'{}' beside FUNCTION DWELL is not understood: write it in a block of its own",
                word.name
            ));
        }
        let seconds = match (block.get("TIME"), block.get("REV"), self.cutter.rpm) {
            (Some(seconds), None, _) => seconds,
            (None, Some(turns), Some(rpm)) if rpm > 0.0 => turns / hz_from_rpm(rpm),
            (None, Some(_), _) => {
                return Err("a dwell in turns, but the spindle's speed is not known".to_owned());
            }
            _ => return Err("FUNCTION DWELL needs TIME or REV with a number".to_owned()),
        };
        self.cutter.log.dwell(line, seconds);
        Ok(())
    }

    /// Cycle 247: the preset under which the path starts is the job's work object.
    fn choose_preset(&mut self, line: usize, preset: Option<f64>) {
        self.shift = Vector3::zeros();
        let is_other = preset.is_none() || preset != self.preset;
        let has_moved = self.cutter.log.has_moved();
        // Before, places may count from another preset.
        let counts = self.cutter.at.iter().any(Option::is_some);
        if !has_moved {
            self.preset = preset;
        }
        if is_other && (has_moved || counts) {
            let what = "cycle 247 chooses a preset: the job's work_object is used throughout";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// M104, M142 and M143: before anything counts from it, the work is where the job's work object
    /// says.
    pub(super) fn change_datum(&mut self, line: usize, code: f64) -> Result<(), String> {
        if code == 142.0 && self.shift != Vector3::zeros() {
            return Err("M142 takes back shifts of the work and is not supported: write cycle 7 \
                        with X+0, Y+0 and Z+0 in its place"
                .to_owned());
        }
        let counts = self.cutter.at.iter().any(Option::is_some) || self.shift != Vector3::zeros();
        let (note, what) = match counts || self.cutter.log.has_moved() {
            true => (Code::ChangeIgnored, "the job's work_object is used throughout"),
            false => (Code::LeftOut, "the job's work_object stands for what holds behind it"),
        };
        let which = match code {
            104.0 => "chooses the last datum again",
            142.0 => "deletes modal program information",
            _ => "ends a basic rotation",
        };
        self.cutter.log.warning(note, line, format!("M{code} {which}: {what}"));
        Ok(())
    }

    /// Cycle 7 and TRANS DATUM AXIS: the axes that they name count from so far away, by `I` from
    /// the shift before.
    pub(super) fn shift_work(&mut self, block: &Block<'_>) -> Result<(), String> {
        let mut shift = self.shift;
        let axes = [("X", "IX"), ("Y", "IY"), ("Z", "IZ")];
        for word in block.words.iter().skip(3) {
            let axis = |name: &str| axes.iter().position(|(x, ix)| *x == name || *ix == name);
            match (axis(word.name), word.value) {
                (Some(axis), Some(value)) => {
                    let from = if word.name.len() > 1 { shift[axis] } else { 0.0 };
                    shift[axis] = from + self.mm(value);
                }
                // A title, or an axis that does not turn.
                (None, None) if word.sign.is_none() && !is_of_motion(word.name) => {}
                (None, Some(0.0)) if !word.name.is_empty() => {}
                _ => {
                    let own = if block.name(0) == "TRANS" { "TRANS DATUM AXIS" } else { "cycle 7" };
                    return Err(format!(
                        "{own} shifts or turns the work by what is no number along X, Y or Z"
                    ));
                }
            }
        }
        self.shift = shift;
        Ok(())
    }

    /// The pecking of older controls: 1.0 begins it, 1.1 to 1.5 say the clearance, the depth, the
    /// peck, the dwell and the feed (HEIDENHAIN, TNC 426 Conversational Programming, "Pecking").
    fn pecking(&mut self, line: usize, number: f64, block: &Block<'_>) -> Result<(), String> {
        if number == 1.0 {
            self.cycle = Some(Cycle { number, line, values: HashMap::new() });
            self.is_refused = false;
            return Ok(());
        }
        let stated = block.words.iter().skip(3).rev().find(|word| word.value.is_some());
        let (Some(word), Some(cycle)) = (stated, &mut self.cycle) else {
            return Err(format!("cycle {number} without a number, or without its beginning"));
        };
        let name = match ((number - 1.0) * 10.0).round() as i64 {
            1 => "clearance",
            2 => "depth",
            3 => "step",
            4 => "dwell",
            5 => "feed",
            _ => return Err(format!("cycle {number} is not supported")),
        };
        if name == "feed" {
            cycle.line = line;
        }
        cycle.values.insert(name.to_owned(), (word.value.unwrap_or(0.0), word.span));
        Ok(())
    }

    /// From where the tool is, the clearance over the work.
    fn peck(&mut self, line: usize, cycle: &Cycle) -> Result<(), String> {
        let get = |name: &str| {
            let value = cycle.values.get(name).map(|(value, _)| *value);
            value.ok_or_else(|| format!("cycle 1 has no {name}"))
        };
        let at = self.cutter.place().ok_or("a cycle from an unknown position")?;
        let clearance = self.mm(get("clearance")?).abs();
        let depth = -self.mm(get("depth")?);
        let (feed, span) = *cycle.values.get("feed").ok_or("cycle 1 has no feed")?;
        if !(depth > 0.0 && feed > 0.0) {
            return Err("cycle 1 needs a depth below zero, and a feed".to_owned());
        }
        self.cutter.log.states(cycle.line, span, States::Feed { value: feed });
        let depths = pecks(-depth, self.mm(get("step")?).abs(), 0.0, 0.0);
        let surface = at.z - clearance;
        let hole = Hole {
            clearance: at.z,
            lifts: vec![None; depths.len()],
            depths: depths.iter().map(|depth| surface + depth).collect(),
            over_peck: over_peck(depth),
            retract: at.z,
            feed: Pace::Feed(m_per_s_from_mm_per_min(self.mm_per_min(feed))),
            out: Pace::Rapid,
            lift: Pace::Rapid,
            dwell_s: get("dwell").unwrap_or(0.0),
            dwell_peck_s: 0.0,
            dwell_out_s: 0.0,
        };
        self.cutter.hole(line, Vector3::new(at.x, at.y, 0.0), Vector3::z(), &hole);
        Ok(())
    }

    /// The Q words of a cycle: a number, and of feeds MAX or AUTO.
    fn values(&self, block: &Block<'_>) -> Result<HashMap<String, (f64, Option<Span>)>, String> {
        let mut values = HashMap::new();
        for (index, word) in block.words.iter().enumerate() {
            if word.name.len() < 2 || !word.name.starts_with('Q') {
                continue;
            }
            let value = match (word.value, block.name(index + 1)) {
                (Some(value), _) => value,
                (None, "MAX" | "FMAX") if word.name != "Q206" => FMAX_MM_PER_MIN,
                (None, "MAX" | "FMAX") => {
                    return Err("Q206: a feed of MAX into the work is not supported".to_owned());
                }
                (None, "AUTO" | "FAUTO") => match self.feed_of_tool {
                    Some(Feed { kind: FeedKind::PerMinute, value: Some(mm) }) => {
                        mm / self.mm_per_min(1.0)
                    }
                    _ => return Err(format!("{}: the last TOOL CALL has no F", word.name)),
                },
                (None, _) => {
                    return Err(format!(
                        "{}: a value from a Q parameter is not supported",
                        word.name
                    ));
                }
            };
            values.insert(word.name.to_owned(), (value, word.span));
        }
        Ok(values)
    }

    /// CYCL CALL, with M codes as in a move.
    pub(super) fn call_cycle(&mut self, line: usize, block: &Block<'_>) -> Result<(), String> {
        let is_by_place = block.name(2) == "POS";
        let unknown = |word: &&Word<'_>| match word.name {
            "M" | "F" | "FMAX" | "MAX" => false,
            "POS" | "X" | "Y" | "Z" => !is_by_place,
            _ => true,
        };
        if let Some(word) = block.words.iter().skip(2).find(unknown) {
            return Err(format!("'CYCL CALL {}' is not supported", word.name));
        }
        self.feed(line, block)?;
        self.m_codes(line, block, true)?;
        if is_by_place {
            self.drill_at(line, block)?;
        } else {
            self.drill(line)?;
        }
        if block.all("M").any(|code| code == 5.0) {
            self.cutter.turn_spindle(line, false);
        }
        Ok(())
    }

    /// CYCL CALL POS: the cycle at a place, from whose Z the surface counts (HEIDENHAIN, TNC 320
    /// Cycle Programming, "Calling a cycle with CYCL CALL POS").
    fn drill_at(&mut self, line: usize, block: &Block<'_>) -> Result<(), String> {
        let [Some(_), Some(_), Some(z)] = ["X", "Y", "Z"].map(|axis| block.get(axis)) else {
            return Err("CYCL CALL POS needs X, Y and Z".to_owned());
        };
        if self.is_refused {
            return Ok(());
        }
        let cycle = self.cycle.as_ref().ok_or("CYCL CALL POS without a drilling cycle")?;
        let surface = cycle.values.get("Q203").ok_or("CYCL CALL POS of a cycle without Q203")?.0;
        let pace = if is_rapid(block) { Pace::Rapid } else { self.cutter.pace()? };
        let end = self.end_of(block)?;
        let z = self.mm(z);
        let [Some(x), Some(y), _] = end else {
            return Err("CYCL CALL POS to an unknown position".to_owned());
        };
        if self.cutter.place().is_none() && pace != Pace::Rapid {
            return Err(self.cutter.unknown(line));
        }
        let surface = self.mm(surface) + self.shift.z + z;
        // From an unknown height the tool goes to that of the cycle at once.
        let height = self.cutter.at[2].unwrap_or(f64::NEG_INFINITY);
        if height < surface && pace != Pace::Rapid {
            return Err("CYCL CALL POS from below the surface at a feed is not supported".into());
        }
        // From below the surface the tool is taken up first, as at the start of every cycle.
        if height >= surface {
            self.cutter.apart(line, Vector3::new(x, y, height), pace);
        }
        self.shift.z += z;
        let done = self.drill_over(line, Some([x, y]));
        self.shift.z -= z;
        self.heading = None;
        done
    }

    /// Feed of a tap of a pitch, as the program would write it.
    fn tapping_feed(&self, pitch: f64) -> Result<f64, String> {
        match self.cutter.rpm {
            Some(rpm) if rpm > 0.0 => Ok(self.mm(pitch.abs()) * rpm / self.mm_per_min(1.0)),
            _ => Err("a tap needs the spindle's speed, which is not known".to_owned()),
        }
    }

    pub(super) fn drill(&mut self, line: usize) -> Result<(), String> {
        self.drill_over(line, None)
    }

    /// Where the tool is, or over a place in X and Y.
    fn drill_over(&mut self, line: usize, over: Option<[f64; 2]>) -> Result<(), String> {
        if self.is_refused {
            return Ok(());
        }
        let cycle = self.cycle.take().ok_or("CYCL CALL without a drilling cycle")?;
        let done = match cycle.number {
            1.0 => self.peck(line, &cycle),
            _ => self.drill_by(line, &cycle, over),
        };
        self.cycle = Some(cycle);
        done
    }

    fn drill_by(
        &mut self,
        line: usize,
        cycle: &Cycle,
        over: Option<[f64; 2]>,
    ) -> Result<(), String> {
        let get = |name: &str| cycle.values.get(name).map(|(value, _)| *value);
        let need = |name: &str| get(name).ok_or_else(|| format!("the cycle has no {name}"));
        // The cycle states its heights.
        let at = self.cutter.at;
        let over = over.map_or([at[0], at[1]], |over| over.map(Some));
        let [Some(x), Some(y)] = over else {
            let name = if over[0].is_none() { "X" } else { "Y" };
            return Err(format!(
                "{name} is not known before the cycle: program {name} by a rapid move before it"
            ));
        };
        let surface = self.mm(need("Q203")?) + self.shift.z;
        let clearance = surface + self.mm(need("Q200")?);
        let depth = self.mm(need("Q201")?);
        let second = surface + self.mm(get("Q204").unwrap_or(0.0));
        if depth >= 0.0 {
            return Err(format!("Q201 is {depth} mm, must be negative"));
        }
        if get("Q395").is_some_and(|of| of != 0.0) {
            let what = "Q395 measures the depth to the tool's full diameter, which needs its point \
                        angle: not supported";
            return Err(what.to_owned());
        }
        let step = self.mm(get("Q202").unwrap_or(0.0));
        let [less, least, breaks_every] =
            ["Q212", "Q205", "Q257"].map(|name| self.mm(get(name).unwrap_or(0.0)));
        let mut depths = pecks(depth, step, less, least);
        let lift = self.mm(get("Q256").unwrap_or(CHIP_BREAK_MM));
        let lifts = if cycle.number == 205.0 {
            let (all, come_out) = with_chips_broken(&depths, breaks_every);
            depths = all;
            come_out.into_iter().map(|comes_out| (!comes_out).then_some(lift)).collect()
        } else {
            // Chips are broken by a short way back so many times before the tool comes out.
            let breaks = get("Q213").unwrap_or(0.0).clamp(0.0, 1e4) as usize;
            let comes_out = |peck: usize| (peck + 1).is_multiple_of(breaks + 1);
            (0..depths.len()).map(|peck| (!comes_out(peck)).then_some(lift)).collect()
        };
        let stops = ["Q258", "Q259"].map(|name| get(name).map(|over| self.mm(over)));
        if let [Some(first), Some(last)] = stops
            && first != last
        {
            return Err("Q258 and Q259 differ: not supported".to_owned());
        }
        if get("Q379").is_some_and(|start| start != 0.0) {
            return Err("Q379 begins deeper in the hole: not supported".to_owned());
        }
        let feed = match cycle.number {
            207.0 => self.tapping_feed(need("Q239")?)?,
            _ => need("Q206")?,
        };
        if cycle.number == 206.0 {
            self.cutter.taps(line);
            self.cutter.log.states(line, None, States::Tap);
        }
        // Its feed follows the speed by the pitch.
        if cycle.number == 207.0 {
            self.cutter.taps(line);
            self.cutter.log.states(line, None, States::FeedPerRevolution);
        }
        let pace = |feed: f64| Pace::Feed(m_per_s_from_mm_per_min(self.mm_per_min(feed)));
        // Reaming and universal drilling say how fast the tool comes out, and by 0: as it went in.
        let out = match get("Q208") {
            _ if cycle.number == 200.0 => Pace::Rapid,
            _ if cycle.number > 205.0 => pace(feed),
            None => Pace::Rapid,
            Some(out) if out >= FMAX_MM_PER_MIN => Pace::Rapid,
            Some(out) => pace(if out > 0.0 { out } else { feed }),
        };
        let feed = pace(feed);
        if !matches!(feed, Pace::Feed(feed) if feed > 0.0) {
            return Err("Q206 must be positive".to_owned());
        }
        for (name, is_stated) in [("Q206", true), ("Q208", matches!(out, Pace::Feed(_)))] {
            if let Some((value, span)) = cycle.values.get(name).filter(|(value, _)| *value > 0.0)
                && is_stated
            {
                self.cutter.log.states(cycle.line, *span, States::Feed { value: *value });
            }
        }
        let hole = Hole {
            clearance,
            depths: depths.iter().map(|depth| surface + depth).collect(),
            lifts,
            over_peck: stops[0].unwrap_or(clearance - surface),
            retract: second.max(clearance),
            feed,
            out,
            lift: out,
            dwell_s: get("Q211").unwrap_or(0.0),
            dwell_peck_s: 0.0,
            dwell_out_s: get("Q210").unwrap_or(0.0),
        };
        self.cutter.hole(line, Vector3::new(x, y, 0.0), Vector3::z(), &hole);
        Ok(())
    }
}

/// Words without which a cycle cannot be called.
fn complete(number: f64, values: &HashMap<String, (f64, Option<Span>)>) -> Result<(), String> {
    let feed = if number == 207.0 { "Q239" } else { "Q206" };
    let mut needed = ["Q200", "Q201", feed, "Q203"].into_iter();
    needed.find(|name| !values.contains_key(*name)).map_or(Ok(()), |name| {
        Err(format!(
            "cycle {number} has no {name}: its Q words stand behind it, joined by '~' at the end \
             of each line"
        ))
    })
}

/// Depths with those between at which chips are broken, and at which the tool comes out.
fn with_chips_broken(depths: &[f64], every: f64) -> (Vec<f64>, Vec<bool>) {
    const MOST: usize = 10_000;
    let (mut all, mut come_out, mut at) = (Vec::new(), Vec::new(), 0.0);
    for &depth in depths {
        while every > 0.0 && at - every > depth + 1e-9 && all.len() < MOST {
            at -= every;
            all.push(at);
            come_out.push(false);
        }
        at = depth;
        all.push(at);
        come_out.push(true);
    }
    (all, come_out)
}

/// Depths of pecks, below zero: each less deep than the one before by `less`, down to `least`.
fn pecks(depth: f64, step: f64, less: f64, least: f64) -> Vec<f64> {
    const MOST: usize = 10_000;
    let (mut depths, mut at, mut step) = (Vec::new(), 0.0, step);
    while step > 0.0 && at - step > depth + 1e-9 && depths.len() < MOST {
        at -= step;
        depths.push(at);
        let next = (step - less).max(least).min(step);
        step = if next > 0.0 { next } else { step };
    }
    depths.push(depth);
    depths
}
