//! Drilling cycles of APT in the dialects of the CAM systems.

use nalgebra::{Unit, Vector3};

use super::lexer::{self, Word};
use super::{Reader, SAME_AXIS, name, number};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::cutter::{Feed, FeedKind, Hole};
use crate::program::log::States;
use crate::units::hz_from_rpm;

/// A drilling cycle that is on: lengths in mm along the tool axis from the programmed point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cycle {
    depth: f64,
    clear: f64,
    retract: f64,
    /// Creo's retract plane, to which the tool goes back: its axis, and how far along it from the
    /// origin it lies.
    plane: Option<(Unit<Vector3<f64>>, f64)>,
    feed: Option<Feed>,
    /// Bores, reams and taps are left at the feed.
    out_at_feed: bool,
    is_tap: bool,
    dwell_s: f64,
    /// How far down the first and each further peck goes; the tool comes out to the clearance
    /// between them.
    pecks: [Option<f64>; 2],
}

/// A feed in a turn beyond this is a feed a minute, or something else.
const MAX_PER_REVOLUTION_MM: f64 = 5.0;

/// A feed a minute below this is a clearance, or something else.
const MIN_PER_MINUTE_MM: f64 = 10.0;

/// Heights that differ by no more are one.
const SAME_HEIGHT_MM: f64 = 1e-6;

/// What a number of feed may stand for.
const UNITS: [&str; 6] = ["MMPM", "IPM", "MMPR", "IPR", "PERMIN", "PERREV"];

const BEHIND_UNIT: &str = "behind the unit of the feed stands the clearance alone, or in a file \
     with Creo's header the clearance and the step of a deep hole; write DEPTH, CLEAR, STEP and \
     the unit before the feed";

/// Whether a number, in mm, is as large as feeds of its kind are.
fn may_be_feed(kind: FeedKind, mm: f64) -> bool {
    match kind {
        FeedKind::PerRevolution => mm <= MAX_PER_REVOLUTION_MM,
        _ => mm >= MIN_PER_MINUTE_MM,
    }
}

/// Kinds of cycles, and whether the tool is left at the feed.
fn kind(name: &str) -> Option<bool> {
    match name {
        "DRILL" | "FACE" | "CSINK" | "THRU" | "DEEP" | "DEEP2" | "DEEPHL" | "BRKCHP" | "BRKCH"
        | "CBORE" | "SPOT" | "CTRDRL" | "PECK" | "CHIP" => Some(false),
        "BORE" | "BORE5" | "REAM" | "TAP" | "RTAP" => Some(true),
        _ => None,
    }
}

impl Cycle {
    /// Heights of the ends of the pecks, the last at the bottom.
    fn depths(&self) -> Vec<f64> {
        const MOST: usize = 10_000;
        let [first, further] = self.pecks;
        let mut depths = Vec::new();
        let mut at = first.or(further).unwrap_or(self.depth);
        while at < self.depth && at > 0.0 && depths.len() < MOST {
            depths.push(-at);
            at += further.or(first).unwrap_or(self.depth);
        }
        depths.push(-self.depth);
        depths
    }
}

impl Reader<'_> {
    pub(super) fn cycle_statement(
        &mut self,
        line: usize,
        minor: &[Word<'_>],
    ) -> Result<(), String> {
        self.is_rapid_in_cycle = false;
        self.ended_cycle = self.cycle.take().or(self.ended_cycle);
        let before = self.ended_cycle;
        let first = minor.first().and_then(name).map(str::to_ascii_uppercase);
        let first = first.ok_or("expected a kind of cycle")?;
        match first.as_str() {
            "OFF" | "END" | "NOMORE" | "INIT" if minor.len() == 1 => return Ok(()),
            "ON" if minor.len() == 1 => {
                self.cycle = Some(before.ok_or("ON without a cycle before")?);
                return Ok(());
            }
            _ => {}
        }
        let rest = minor.get(1..).unwrap_or_default();
        if let ("ON", Some(mut cycle)) = (first.as_str(), before) {
            let is_deep = self.keywords(line, rest, &mut cycle, false)?;
            self.begin(line, "ON", cycle, is_deep);
            return Ok(());
        }
        let out_at_feed = kind(&first).ok_or_else(|| format!("'{first}' is not understood"))?;
        let mut cycle = Cycle {
            depth: f64::NAN,
            clear: 0.0,
            retract: 0.0,
            plane: None,
            feed: None,
            out_at_feed,
            is_tap: matches!(first.as_str(), "TAP" | "RTAP"),
            dwell_s: 0.0,
            pecks: [None; 2],
        };
        // A hole through the work is drilled in pecks where their depth is stated.
        let has_step = rest.iter().filter_map(name).any(|word| lexer::is(word, "STEP"));
        let mut is_deep = matches!(first.as_str(), "DEEP" | "DEEP2" | "DEEPHL" | "PECK")
            || first == "THRU" && has_step;
        if rest.first().is_some_and(|word| number(word).is_some()) {
            is_deep = self.positional(line, rest, &mut cycle, is_deep)?;
        } else {
            is_deep = self.keywords(line, rest, &mut cycle, is_deep)?;
        }
        if !cycle.depth.is_finite() {
            return Err("the depth is missing (DEPTH or FEDTO)".to_owned());
        }
        self.begin(line, &first, cycle, is_deep);
        Ok(())
    }

    /// A deep one of which no peck is stated is a doubt.
    fn begin(&mut self, line: usize, first: &str, cycle: Cycle, is_deep: bool) {
        if is_deep && cycle.pecks == [None; 2] {
            let what = format!(
                "CYCLE/{first}: how deep a peck goes is not stated (STEP): read as one stroke"
            );
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
        self.cycle = Some(cycle);
    }

    /// CATIA: depth, feed and clearance, then the unit of the feed. Creo's fixed format: depth,
    /// feed, unit, clearance and, of a deep hole, the step.
    fn positional(
        &mut self,
        line: usize,
        rest: &[Word<'_>],
        cycle: &mut Cycle,
        is_deep: bool,
    ) -> Result<bool, String> {
        let count = rest.iter().take_while(|word| number(word).is_some()).count();
        let (numbers, names) = rest.split_at(count);
        let numbers: Vec<_> = numbers.iter().filter_map(number).collect();
        let (word, behind) = names.split_first().map_or((None, names), |(w, rest)| (Some(w), rest));
        let unit = word.and_then(name).map(str::to_ascii_uppercase);
        if let (1, [(depth, _)], [Word::Name(_), Word::Number(..), behind @ ..]) =
            (count, numbers.as_slice(), names)
        {
            cycle.depth = self.mm(depth.abs());
            let what = "CYCLE: the point of GOTO is taken as the top of the hole, and a clearance \
                        counts from there: some posts that write the depth without a word give \
                        the bottom; write DEPTH and CLEAR";
            self.cutter.log.warning(Code::UnitAssumed, line, what);
            if unit.is_some_and(|unit| UNITS.contains(&unit.as_str())) {
                return self.unit_before_feed(line, names, behind, (cycle, is_deep));
            }
            return self.keywords(line, names, cycle, is_deep);
        }
        // `depth, feed, unit, clearance`, or the unit behind all.
        let numbers = match behind {
            [] => numbers,
            [clear] if count == 2 && number(clear).is_some() => {
                numbers.into_iter().chain(number(clear)).collect()
            }
            [Word::Number(clear, span), Word::Number(step, _)]
                if count == 2 && is_deep && self.is_creo =>
            {
                cycle.pecks = [Some(self.mm(step.abs())).filter(|step| *step > 0.0); 2];
                let what = "CYCLE: the first number behind the unit of the feed is taken as the \
                            height over the point at which the feed begins: Creo's fixed format \
                            does not say from where it counts; write CLEAR and STEP";
                self.cutter.log.warning(Code::UnitAssumed, line, what);
                numbers.into_iter().chain([(*clear, *span)]).collect()
            }
            _ if unit.as_deref().is_some_and(|unit| UNITS.contains(&unit)) => {
                return Err(BEHIND_UNIT.to_owned());
            }
            _ => {
                let name = unit.unwrap_or_default();
                return Err(format!(
                    "numbers without keywords and behind them {name} and more: which of them is \
                     the feed and which the clearance is not known; write DEPTH, CLEAR and the \
                     unit before the feed"
                ));
            }
        };
        let (depth, feed, clear) = match *numbers.as_slice() {
            [(depth, _)] => (depth, None, 0.0),
            [(depth, _), feed] => (depth, Some(feed), 0.0),
            [(depth, _), feed, (clear, _)] => (depth, Some(feed), clear),
            _ => {
                return Err(
                    "more than three numbers without keywords: write DEPTH, CLEAR and the \
                            unit before the feed"
                        .to_owned(),
                );
            }
        };
        cycle.depth = self.mm(depth.abs());
        cycle.clear = self.mm(clear);
        if let Some((value, span)) = feed {
            let feed = self.feed_of(line, value, unit.as_deref())?;
            if feed.kind == FeedKind::PerRevolution
                && feed.value.is_some_and(|mm| !may_be_feed(feed.kind, mm))
            {
                return Err(format!(
                    "the second number is taken as the feed, and {value} in a turn is none: write \
                     DEPTH, CLEAR and the unit before the feed"
                ));
            }
            if unit.is_none() {
                let what = format!(
                    "CYCLE: the second number, {value}, is taken as the feed, though no unit \
                     stands behind it: some posts write the clearance there"
                );
                self.cutter.log.warning(Code::UnitAssumed, line, what);
            } else if let Some(mm) = feed.value
                && clear > 0.0
                && (!may_be_feed(feed.kind, mm) || may_be_feed(feed.kind, mm / value * clear))
            {
                let what = format!(
                    "CYCLE: of {value} and {clear} the first is taken as the feed, the other as \
                     the clearance: some posts write the clearance first; write DEPTH, CLEAR and \
                     the unit before the feed"
                );
                self.cutter.log.warning(Code::UnitAssumed, line, what);
            }
            self.state_cycle_feed(line, feed, value, span);
            cycle.feed = Some(feed);
        }
        Ok(is_deep)
    }

    /// `DRILL,20,MMPM,150,2` and `DRILL,20,MMPM,150,RAPTO,2`: the depth, and behind it keywords, of
    /// which the feed's is its unit; a clearance may stand alone.
    fn unit_before_feed(
        &mut self,
        line: usize,
        words: &[Word<'_>],
        behind: &[Word<'_>],
        (cycle, is_deep): (&mut Cycle, bool),
    ) -> Result<bool, String> {
        let words = match behind {
            [Word::Number(clear, _)] => {
                cycle.clear = self.mm(*clear);
                words.get(..2).unwrap_or(words)
            }
            [Word::Number(..), Word::Name(key), ..] => {
                return Err(format!(
                    "behind the feed stand a number and {key}: which is the clearance is not \
                     known; write CLEAR, or RAPTO and RTRCTO, alone"
                ));
            }
            _ => words,
        };
        self.keywords(line, words, cycle, is_deep)
    }

    fn state_cycle_feed(
        &mut self,
        line: usize,
        feed: Feed,
        value: f64,
        span: crate::program::span::Span,
    ) {
        let states = match feed.kind {
            FeedKind::PerRevolution => States::FeedPerRevolution,
            _ => States::Feed { value },
        };
        self.cutter.log.states(line, Some(span), states);
    }

    /// Whether the hole is drilled in pecks.
    fn keywords(
        &mut self,
        line: usize,
        rest: &[Word<'_>],
        cycle: &mut Cycle,
        is_deep: bool,
    ) -> Result<bool, String> {
        let (mut rest, mut is_deep) = (rest, is_deep);
        let (mut clear, mut rapto) = (None, None);
        // The words that only say how the depth is reached: the places passed are the same.
        while let [Word::Name(word), tail @ ..] = rest
            && matches!(
                word.to_ascii_uppercase().as_str(),
                "DEEP" | "BRKCHP" | "BACK" | "DRAG" | "NODRAG" | "MANUAL"
            )
        {
            is_deep |= word.eq_ignore_ascii_case("DEEP");
            rest = tail;
        }
        while let [Word::Name(key), tail @ ..] = rest {
            let key = key.to_ascii_uppercase();
            let (value, tail) = match tail {
                [Word::Number(value, span), tail @ ..] => (Some((*value, *span)), tail),
                [Word::Name(word), tail @ ..]
                    if matches!(word.to_ascii_uppercase().as_str(), "AUTO" | "NONE") =>
                {
                    (None, tail)
                }
                tail => (None, tail),
            };
            match (key.as_str(), value) {
                ("DEPTH" | "FEDTO", Some((value, _))) => cycle.depth = self.mm(value.abs()),
                ("CLEAR" | "RAPTO", Some((value, _))) => {
                    cycle.clear = self.mm(value);
                    let own = if key == "CLEAR" { &mut clear } else { &mut rapto };
                    *own = Some(cycle.clear);
                }
                ("RETURN", Some((0.0, _))) => self.return_to_plane(line, cycle),
                ("RTRCTO" | "RETURN" | "RETRCT", Some((value, _))) => {
                    cycle.retract = self.mm(value);
                    cycle.plane = None;
                }
                (
                    unit @ ("MMPM" | "IPM" | "MMPR" | "IPR" | "PERMIN" | "PERREV"),
                    Some((value, span)),
                ) => {
                    let feed = self.feed_of(line, value, Some(unit))?;
                    self.state_cycle_feed(line, feed, value, span);
                    cycle.feed = Some(feed);
                }
                ("STEP" | "STEP1" | "INCR", Some((value, _))) if is_deep => {
                    cycle.pecks = [Some(self.mm(value.abs())); 2];
                }
                ("STEP" | "STEP1" | "INCR", Some(_)) => self.tell_step(line),
                ("1STPECK", Some((value, _))) => cycle.pecks[0] = Some(self.mm(value.abs())),
                ("SUBPECK", Some((value, _))) => cycle.pecks[1] = Some(self.mm(value.abs())),
                ("DWELL", Some((value, _))) => cycle.dwell_s = value,
                // In turns of the spindle.
                ("REV", Some((value, _))) if cycle.dwell_s == 0.0 => {
                    match self.cutter.rpm.filter(|rpm| *rpm > 0.0) {
                        Some(rpm) => cycle.dwell_s = value / hz_from_rpm(rpm),
                        None => {
                            let what = "CYCLE: the dwell is in turns of a spindle whose speed the \
                                        program does not state, and is left out: what follows is \
                                        later than read";
                            self.cutter.log.warning(Code::MotionLeftOut, line, what);
                        }
                    }
                }
                ("RTRCTO" | "RETURN" | "RETRCT", None) => {
                    let what = format!(
                        "CYCLE: {key} without a length is read as back to the clearance; posts of \
                         NX go back to where the tool was before the cycle"
                    );
                    self.cutter.log.warning(Code::ChangeIgnored, line, what);
                }
                ("MANUAL" | "AUTO", None)
                | ("DWELL" | "STEP" | "STEP1" | "INCR" | "TIMES" | "REV" | "CAM" | "ORIENT", _) => {
                }
                _ => return Err(format!("'{key}' is not understood in a cycle")),
            }
            rest = tail;
        }
        if rest.is_empty() {
            self.clearance(line, cycle, clear, rapto)?;
            return Ok(is_deep);
        }
        Err("numbers without keywords: write DEPTH, CLEAR and the unit before the feed".to_owned())
    }

    /// In Creo RAPTO counts from CLEAR down.
    fn clearance(
        &mut self,
        line: usize,
        cycle: &mut Cycle,
        clear: Option<f64>,
        rapto: Option<f64>,
    ) -> Result<(), String> {
        let what = match (clear, rapto) {
            (Some(clear), Some(rapto)) if self.is_creo => {
                cycle.clear = clear - rapto;
                // Without RETURN the tool goes back to CLEAR.
                cycle.retract = cycle.retract.max(clear);
                if cycle.clear <= -cycle.depth {
                    return Err("RAPTO, which counts from CLEAR, leads to the bottom".to_owned());
                }
                if cycle.clear >= 0.0 {
                    return Ok(());
                }
                "CYCLE: RAPTO, which counts from CLEAR, leads to below the point of the hole: the \
                 way there is read as rapid"
            }
            (Some(_), Some(_)) => {
                "CYCLE: of CLEAR and RAPTO the last is taken as the height over the point at \
                 which the feed begins; in Creo's files RAPTO counts from CLEAR, and nothing says \
                 that this is one"
            }
            (None, Some(_)) if self.is_creo => {
                "CYCLE: RAPTO without CLEAR is taken as the height over the point at which the \
                 feed begins; Creo counts it from CLEAR"
            }
            _ => return Ok(()),
        };
        self.cutter.log.warning(Code::UnitAssumed, line, what);
        Ok(())
    }

    /// `RETURN,0` of Creo: back to the retract plane, from which the tool has come.
    fn return_to_plane(&mut self, line: usize, cycle: &mut Cycle) {
        cycle.retract = 0.0;
        cycle.plane = match (self.is_creo, self.is_behind_cycle) {
            (false, _) => None,
            (true, true) => self.ended_cycle.and_then(|before| before.plane),
            (true, false) => self.at.map(|at| (self.axis, at.dot(&self.axis))),
        };
        if cycle.plane.is_none() {
            self.tell_no_plane(line);
        }
    }

    fn tell_no_plane(&mut self, line: usize) {
        let what = "CYCLE: RETURN,0 is read as back to the clearance; Creo goes back to the \
                    retract plane, which nothing here shows";
        self.cutter.log.warning(Code::ChangeIgnored, line, what);
    }

    /// How far over a hole the tool is left.
    fn retract(&mut self, line: usize, to: Vector3<f64>, cycle: &Cycle) -> f64 {
        let least = cycle.retract.max(cycle.clear);
        let Some((axis, plane)) = cycle.plane else { return least };
        let height = plane - to.dot(&axis);
        if self.axis.angle(&axis) <= SAME_AXIS && height >= least - SAME_HEIGHT_MM {
            return height.max(least);
        }
        self.tell_no_plane(line);
        least
    }

    fn tell_step(&mut self, line: usize) {
        let what = "CYCLE: STEP of a cycle that is not deep is left out, and the hole read as one \
                    stroke: what the post makes of it, pecks or a short way back to break chips, \
                    is not stated";
        self.cutter.log.warning(Code::MotionLeftOut, line, what);
    }

    /// Rapid to the clearance, feed to the depth, and out.
    pub(super) fn drill(
        &mut self,
        line: usize,
        to: Vector3<f64>,
        cycle: Cycle,
    ) -> Result<(), String> {
        let feed = cycle.feed.unwrap_or(self.cutter.feed);
        if cycle.is_tap {
            self.cutter.taps(line);
            if feed.kind == FeedKind::PerMinute {
                self.cutter.log.states(line, None, States::Tap);
            }
        }
        let feed = self.cutter.pace_of(feed)?;
        let out = if cycle.out_at_feed { feed } else { Pace::Rapid };
        self.rapid = false;
        if std::mem::take(&mut self.is_rapid_in_cycle) {
            let what = "RAPID stands before a point of a cycle that is on, which is read as a \
                        hole: some posts only go there";
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
        let retract = self.retract(line, to, &cycle);
        let frame = self.systems.start();
        let axis = frame.axis(self.axis);
        let is_turned = self.cutter.axis != axis;
        self.cutter.tilt(axis);
        self.senses.lose();
        let hole = Hole {
            clearance: cycle.clear,
            depths: cycle.depths(),
            over_peck: 0.0,
            lifts: Vec::new(),
            retract,
            feed,
            out,
            lift: out,
            dwell_s: cycle.dwell_s,
            dwell_peck_s: 0.0,
            dwell_out_s: 0.0,
        };
        let (at, axis) = (frame.point(to), axis.into_inner());
        if hole.retract > hole.clearance {
            // Where the tool turns, its height over the next hole says nothing.
            if is_turned {
                self.cutter.apart(line, at + axis * hole.retract, Pace::Rapid);
            } else {
                self.cutter.over_hole(line, at, axis, hole.retract);
            }
        }
        self.cutter.straight_to_hole(line, at, axis, &hole);
        let height = hole.retract;
        self.at = Some(to + self.axis.into_inner() * height);
        self.is_behind_cycle = true;
        Ok(())
    }
}
