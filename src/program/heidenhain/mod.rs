//! Heidenhain's conversational programs → motions, as milling posts write them.
//!
//! Read: L, CC with C and CP in planes of two axes, CR, CT, LP, RND and CHF between lines, APPR
//! and DEP in X/Y, TOOL CALL, F, FMAX, M, drilling cycles 1, 200, 201, 203 and 205 to 207 with CYCL
//! CALL and M99, CYCL DEF without motion, LBL and CALL LBL with REP. Q parameters that formulas
//! and FN 0 to 8 set stand for their numbers, FN 9 to 12 jump, cycle 7 and TRANS DATUM AXIS shift
//! the work. Errors: other parameters, cycles and planes. The preset under which the path starts is
//! the job's work object.

mod approach;
mod assumed;
mod block;
mod cycle;
mod flow;
mod formula;
mod lines;
mod quiet;

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};

use nalgebra::{Vector2, Vector3};

use super::arc::Plane;
use super::corner::Corner;
use super::cutter::{Cutter, Feed, FeedKind};
use super::log::Log;
use super::span::Held;
use super::unread::{behind_end, left_over, read_as_run, read_of_lost};
use super::{Pace, Settings};
use crate::notes::Code;
use crate::units::mm_from_inch;
use assumed::Given;
use block::{Block, Parameters, Text, Word, blocks, content, parse};
use cycle::Cycle;
use formula::{OF_TOOL, OTHER_KINDS, OTHERS, RADIUS};

/// Blocks that repeats may run beyond one pass through the program.
const BLOCKS_IN_LOOPS: usize = 1_000_000;

/// M codes that change what later blocks do: cycles at every position, corners, feeds, axes.
const CHANGES_MOTION: [f64; 13] =
    [89.0, 97.0, 98.0, 103.0, 109.0, 110.0, 112.0, 114.0, 124.0, 136.0, 141.0, 144.0, 150.0];

/// M codes that change where the work is: the last datum again, no modal program information, no
/// basic rotation.
const CHANGES_DATUM: [f64; 3] = [104.0, 142.0, 143.0];

/// Reads a program into the log.
pub(super) fn read(text: &str, settings: &Settings, log: &mut Log) {
    let mut reader = Reader::new(text, settings, log);
    if let Some(line) = reader.blocks.iter().find(|block| is_iso(block)).map(|block| block.line) {
        let what = "is a block of DIN/ISO (G codes), which is not read: write the program in \
                    conversational language";
        reader.cutter.log.error(Code::Syntax, line, what);
        return;
    }
    if let Some((line, what)) = reader.begins_otherwise() {
        reader.cutter.log.error(Code::Syntax, line, what);
        return;
    }
    reader.run();
    reader.cutter.tell_not_started();
    reader.end_unknown();
    reader.tell_unheeded();
    if let Some(line) = reader.first_to_skip() {
        read_as_run(reader.cutter.log, line);
    }
    let last = reader.blocks.last().map_or(1, |block| block.line);
    if !reader.has_end {
        let what = "the program ends without END PGM, M2 or M30: is the file whole?";
        reader.cutter.log.error(Code::Syntax, last, what);
    }
    let heads = reader.labels.values().copied().collect();
    let none = Parameters::new();
    let moves = |text: &Text<'_>| {
        let first = text.parts.first().map(|(offset, part)| parse(part, *offset, &none));
        first.is_some_and(|block| {
            matches!(block.name(0), "L" | "C" | "CR" | "CT" | "CP" | "LP" | "APPR" | "DEP")
        })
    };
    let left = left_over(&reader.ran, reader.next, &heads);
    let idle = reader.uncalled();
    let left = left.into_iter().filter(|block| !idle.contains(block));
    let mut left = left.filter_map(|block| reader.blocks.get(block));
    if let Some(text) = left.find(|text| moves(text)) {
        behind_end(reader.cutter.log, text.line);
    }
}

/// `%NAME G71 *` and `G01 X+5`.
fn is_iso(block: &Text<'_>) -> bool {
    let text = block.parts[0].1.trim_start();
    let code = text.strip_prefix('G').unwrap_or("");
    text.starts_with('%') || code.starts_with(|c: char| c.is_ascii_digit())
}

struct Reader<'a, 't> {
    cutter: Cutter<'a>,
    blocks: Vec<Text<'t>>,
    labels: HashMap<String, usize>,
    next: usize,
    /// Which blocks have run.
    ran: Vec<bool>,
    budget: usize,
    /// Block to go back to, head of the subprogram, passes left; `None` for a part that repeats.
    calls: Vec<(usize, usize, u32)>,
    repeats: HashMap<usize, u32>,
    inches: bool,
    /// The last CC, along the axes of the plane that it names.
    pole: Option<([f64; 2], Plane)>,
    /// Number and Q parameters.
    cycle: Option<Cycle>,
    /// Whether the last one was refused: where it is called is told once, with it.
    is_refused: bool,
    /// F of the last TOOL CALL, which FAUTO means.
    feed_of_tool: Option<Feed>,
    /// What formulas and FN 0 to 8 and 13 have set, or the job gives.
    parameters: Parameters,
    /// Those that a refused block would have set.
    lost: BTreeSet<u32>,
    given: Given<'a>,
    /// Cycle 7: where the program's zero is in the work object, mm.
    shift: Vector3<f64>,
    /// A line that RND or CHF cuts off.
    corner: Option<Corner>,
    /// Where the last element of the contour ends, which way it heads in X/Y.
    heading: Option<Vector2<f64>>,
    /// RL: the tool is to the left of the contour.
    side: Option<bool>,
    /// Of the last move.
    last_pace: Option<Pace>,
    /// M codes that are not known, with nothing behind them yet that they could matter to.
    unknown_codes: Vec<(usize, f64)>,
    /// Of cycle 247 before the path started: the job's work object stands for it.
    preset: Option<f64>,
    has_end: bool,
}

impl<'a, 't> Reader<'a, 't> {
    fn new(text: &'t str, settings: &'a Settings, log: &'a mut Log) -> Self {
        let blocks = blocks(text);
        let mut labels = HashMap::new();
        for (index, block) in blocks.iter().enumerate() {
            let words = content(block.parts[0].1);
            if let Some(label) = words.strip_prefix("LBL") {
                let label = label.trim().trim_matches('"').to_owned();
                if label != "0" {
                    labels.entry(label).or_insert(index);
                }
            }
        }
        let (given, parameters) = Given::new(&settings.assume);
        Self {
            cutter: Cutter::new(settings, log),
            budget: blocks.len().saturating_mul(2).saturating_add(BLOCKS_IN_LOOPS),
            ran: vec![false; blocks.len()],
            blocks,
            labels,
            next: 0,
            calls: Vec::new(),
            repeats: HashMap::new(),
            inches: false,
            pole: None,
            cycle: None,
            is_refused: false,
            feed_of_tool: None,
            parameters,
            lost: BTreeSet::new(),
            given,
            shift: Vector3::zeros(),
            corner: None,
            heading: None,
            side: None,
            last_pace: None,
            unknown_codes: Vec::new(),
            preset: None,
            has_end: false,
        }
    }

    fn run(&mut self) {
        while let Some(text) = self.blocks.get(self.next) {
            if self.cutter.log.is_full() || self.has_end {
                self.has_end = true;
                return;
            }
            let line = text.line;
            if self.budget == 0 {
                self.cutter.log.runs_too_long(line);
                self.has_end = true;
                return;
            }
            self.budget -= 1;
            let block = self.parsed(text);
            let content = joined(text);
            self.ran[self.next] = true;
            self.next += 1;
            self.given.heed(&content);
            if let Err(what) = self.block(line, &content, &block) {
                self.cutter.log.error(Code::Motion, line, what);
            }
        }
    }

    /// The words of a block, its continued lines joined.
    fn parsed(&self, text: &Text<'t>) -> Block<'t> {
        let mut block = Block::default();
        for (offset, part) in &text.parts {
            let own = parse(part, *offset, &self.parameters);
            block.words.extend(own.words);
            block.quoted = block.quoted.or(own.quoted);
        }
        block
    }

    fn mm(&self, length: f64) -> f64 {
        if self.inches { mm_from_inch(length) } else { length }
    }

    fn block(&mut self, line: usize, text: &str, block: &Block<'_>) -> Result<(), String> {
        if !block.is_quiet() {
            self.tell_unknown();
        }
        if block.name(0) == "ERROR" {
            return Err("the control has marked this block as faulty (ERROR =): correct it, or \
                        take it out, on the control or where the program was written"
                .to_owned());
        }
        // `X+Q5` and `FQ5` of a Q5 that nothing has set.
        let is_unset = |word: &Word<'_>| {
            word.name.len() > 1
                && word.name != "SEQ"
                && (word.name.starts_with('Q') || word.name.ends_with('Q'))
        };
        if block.words.iter().any(is_unset)
            && !matches!(block.name(0), "CALL" | "CYCL" | "TCH" | "FN" | "BEGIN" | "END" | "BLK")
            && !block.name(0).starts_with('Q')
        {
            let is_other = block.words.iter().any(|word| OTHER_KINDS.contains(&word.name));
            let read = || block.words.iter().filter_map(Word::parameter);
            if let Some(number) = read().find(|own| self.lost.contains(own)) {
                return Err(read_of_lost(&format!("Q{number}")));
            }
            if let Some(number) = read().find(|own| self.parameters.contains_key(own)) {
                return Err(format!(
                    "Q{number} stands apart, and is not read as the number of the word before it: \
                     write it in its word, as in X+Q{number}"
                ));
            }
            let own = "Q parameters in words are read only where the program has set them";
            let own = if block.words.iter().any(is_radius) { OF_TOOL } else { own };
            return Err(if is_other { OTHERS } else { own }.to_owned());
        }
        block.loose().map_or(Ok(()), Err)?;
        let without = without_handwheel(block);
        if without.is_some() {
            let what =
                "M118 lets the operator's handwheel shift the path: it is read as programmed";
            self.cutter.log.warning(Code::Assumed, line, what);
        }
        let block = without.as_ref().unwrap_or(block);
        if parts_lines(block)
            && let Some(corner) = self.corner.take()
        {
            self.cutter.log.error(Code::Motion, line, corner.misplaced());
        }
        match block.name(0) {
            "BEGIN" => self.begin(text),
            "END" => {
                self.has_end = true;
                Ok(())
            }
            "FN" => {
                let number = block.words.get(1).and_then(|word| word.value).unwrap_or(f64::NAN);
                let (_, rest) = text.split_once(':').unwrap_or(("", ""));
                match number {
                    _ if (0.0..=8.0).contains(&number) || number == 13.0 => {
                        self.assign(rest, block)
                    }
                    _ if (9.0..=12.0).contains(&number) => self.jump(rest),
                    // Prints.
                    _ if number == 16.0 => Ok(()),
                    _ => Err("FN: FN 0 to 13 and 16 alone are supported".to_owned()),
                }
            }
            "TCH" => {
                self.probe(line, block);
                self.forget(block);
                Ok(())
            }
            "FUNCTION" if block.name(1) == "DWELL" => self.dwell(line, block),
            "" | "STOP" | "M" => self.m_block(line, block),
            "BLK" | "FUNCTION" => {
                if block.name(0) == "FUNCTION" && !block.has("RESET") {
                    return Err(format!("FUNCTION {} is not supported", block.name(1)));
                }
                self.m_codes(line, block, false)
            }
            "TOOL" => self.tool(line, block),
            "L" | "C" | "CR" | "CT" | "CP" | "LP" | "APPR" | "DEP" => self.motion(line, block),
            "RND" | "CHF" if self.corner.is_some() => Ok(()),
            "RND" | "CHF" => Err(format!("{} must lie between two lines", block.name(0))),
            "CC" => self.centre(block),
            "CYCL" if block.name(1) == "CALL" => self.call_cycle(line, block),
            "CYCL" => {
                let defined = self.define(line, block);
                self.forget(block);
                self.is_refused |= defined.is_err();
                defined
            }
            "LBL" => {
                if block.words.get(1).is_some_and(|word| word.value == Some(0.0)) {
                    self.back();
                }
                Ok(())
            }
            "CALL" if block.name(1) == "LBL" => self.call(),
            "CALL" => Err("CALL PGM calls another program, which is not read".to_owned()),
            "PLANE" if block.has("RESET") || turns_nothing(block) => {
                if block.has("MB") {
                    self.cutter.leave(line, [false, false, true], "PLANE with MB");
                }
                // The angles of the rotary axes that it works out.
                self.parameters.extend((120..=122).map(|number| (number, Held::worked_out(0.0))));
                Ok(())
            }
            "PLANE" => Err("PLANE tilts the working plane and is not supported".to_owned()),
            "TRANS" if block.has("RESET") => {
                let of_others = ["ROTATION", "MIRROR", "SCALE"].iter().any(|own| block.has(own));
                if !of_others {
                    self.shift = Vector3::zeros();
                }
                Ok(())
            }
            "TRANS" if block.name(1) != "DATUM" => Err(format!(
                "TRANS {} turns, mirrors or scales the work and is not supported",
                block.name(1)
            )),
            "TRANS" if block.name(2) == "AXIS" => self.shift_work(block),
            "TRANS" => Err("TRANS DATUM takes the shift from a table or a point of the control: \
                            have TRANS DATUM AXIS written"
                .into()),
            name if name.starts_with('Q') => self.assign(text, block),
            "SPL" => Err("SPL is a spline, which is not read: have lines and arcs written".into()),
            name => Err(format!("'{name}' is not understood; motion may be lost")),
        }
    }

    /// What is wrong with the first block, and its line, where it is no BEGIN PGM.
    fn begins_otherwise(&self) -> Option<(usize, String)> {
        let begins = |block: &&Text<'_>| content(block.parts[0].1).starts_with("BEGIN");
        let first = self.blocks.first().filter(|first| !begins(first))?;
        let remedy = match self.blocks.iter().find(begins) {
            Some(begin) => format!("take out what stands before line {}", begin.line),
            None => "if the file is whole, write BEGIN PGM NAME MM, or INCH, in capital letters \
                     before it"
                .to_owned(),
        };
        let what = format!(
            "the program begins with '{}', expected BEGIN PGM, which states its unit: {remedy}",
            content(first.parts[0].1)
        );
        Some((first.line, what))
    }

    /// BEGIN PGM states the unit of the program, and so does its END PGM.
    fn begin(&mut self, text: &str) -> Result<(), String> {
        if self.next > 1 {
            return Err("a second BEGIN PGM: have each program written to a file of its own".into());
        }
        let stated = states_inches(text);
        self.inches = stated.ok_or_else(|| {
            let last = text.split_whitespace().last().unwrap_or_default();
            format!("BEGIN PGM ends with '{last}', expected MM or INCH: write the program's unit")
        })?;
        let behind = self.blocks.iter().skip(self.next);
        let mut ends = behind.map(|block| (block.line, content(block.parts[0].1)));
        match ends.find(|(_, text)| text.starts_with("END")) {
            Some((line, end)) if states_inches(end).is_some_and(|own| own != self.inches) => {
                Err(format!(
                    "BEGIN PGM and END PGM (line {line}) state different units: correct one of them"
                ))
            }
            _ => Ok(()),
        }
    }

    /// Cycles and probes write Q parameters that they name.
    fn forget(&mut self, block: &Block<'_>) {
        let named = block.words.iter().filter_map(|word| word.name.strip_prefix('Q'));
        for number in named.filter_map(|digits| digits.parse().ok()) {
            self.parameters.remove(&number);
            self.lost.remove(&number);
            self.given.close(number);
        }
    }

    fn tool(&mut self, line: usize, block: &Block<'_>) -> Result<(), String> {
        if block.name(1) != "CALL" {
            return Ok(());
        }
        let has_loaded = self.given.has_loaded();
        match block.quoted.map(|name| (name, self.cutter.number_of(name).map(f64::from))) {
            Some((_, Some(number))) => self.load(number)?,
            Some((name, None)) => {
                self.cutter.named_tool(line, name);
                self.measure(has_loaded);
            }
            None => {}
        }
        let unknown = |word: &&Word<'_>| {
            !matches!(word.name, "" | "X" | "Y" | "Z" | "S" | "F" | "DL" | "DR" | "M")
        };
        if let Some(word) = block.words.iter().skip(2).find(unknown) {
            return Err(format!("'{}' is not understood", word.name));
        }
        if let Some(number) = block.words.get(2).filter(|word| word.name.is_empty()) {
            self.load(number.value.unwrap_or(0.0))?;
        }
        if self.given.changes_dr(block.get("DR").unwrap_or(0.0)) {
            self.measure(true);
        }
        if block.get("DL").is_some_and(|by| by != 0.0) {
            let what = "DL changes the tool's length: the job's tcp is used";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        if let Some(axis) = ["X", "Y"].into_iter().find(|axis| block.has(axis)) {
            return Err(format!("tool axis {axis} is not supported: Z alone"));
        }
        if let Some(speed) = block.word("S") {
            let rpm = speed.value.ok_or("S without a number")?;
            self.cutter.state_speed(line, rpm, speed.span)?;
            self.cutter.assume_started(line);
        }
        self.feed(line, block)?;
        let states_feed = block.has("F") && !block.leaves_feed();
        self.feed_of_tool = states_feed.then_some(self.cutter.feed);
        self.m_codes(line, block, false)
    }

    fn load(&mut self, number: f64) -> Result<(), String> {
        // The one in the spindle again: its speed or feed changes.
        let is_other = self.cutter.has_other_than(number);
        if is_other {
            self.cutter.change();
        }
        self.measure(is_other);
        self.cutter.tool(number)
    }

    /// F, not FMAX, which holds for its block alone.
    fn feed(&mut self, line: usize, block: &Block<'_>) -> Result<(), String> {
        if block.has("FAUTO") || block.is_after("F", "AUTO") {
            let of_tool = self.feed_of_tool.ok_or("FAUTO: the last TOOL CALL has no F")?;
            self.cutter.feed = of_tool;
            return Ok(());
        }
        if let Some(word) = block.word("FU") {
            let value = word.value.filter(|value| *value > 0.0).ok_or("FU must be positive")?;
            let feed = Feed { kind: FeedKind::PerRevolution, value: Some(self.mm(value)) };
            self.cutter.state_feed(line, feed, value, word.span);
            return Ok(());
        }
        let Some(word) = block.word("F").filter(|_| !is_rapid(block)) else { return Ok(()) };
        if block.leaves_feed() {
            return Ok(());
        }
        let value = word.value.ok_or("F without a number")?;
        if value <= 0.0 {
            return Err(format!("F is {value}, must be positive"));
        }
        let feed = Feed { kind: FeedKind::PerMinute, value: Some(self.mm_per_min(value)) };
        self.cutter.state_feed(line, feed, value, word.span);
        Ok(())
    }

    /// Inch programs have feeds in tenths of an inch a minute, those of cycles, too.
    fn mm_per_min(&self, written: f64) -> f64 {
        if self.inches { mm_from_inch(written) / 10.0 } else { written }
    }

    /// Touch probes move to where the program does not say, and may set the preset. What follows
    /// the title belongs to it.
    fn probe(&mut self, line: usize, block: &Block<'_>) {
        let number = block.words.get(2).and_then(|word| word.value);
        if number.is_none_or(|number| number.fract() == 0.0) {
            self.cutter.leave(line, [true; 3], "TCH PROBE");
        }
    }

    fn m_codes(&mut self, line: usize, block: &Block<'_>, moves: bool) -> Result<(), String> {
        for code in block.all("M") {
            match code {
                _ if code == 3.0 || code == 4.0 || code == 13.0 || code == 14.0 => {
                    self.cutter.log.reverse(code == 4.0 || code == 14.0);
                    self.cutter.turn_spindle(line, true);
                }
                _ if code == 5.0 && !moves => self.cutter.turn_spindle(line, false),
                _ if code == 2.0 || code == 30.0 => self.has_end = true,
                _ if code == 91.0 || code == 92.0 || code == 140.0 => {
                    if !moves {
                        return Err(format!("M{code} without a move; write L M{code}"));
                    }
                }
                _ if code == 128.0 => {
                    return Err("M128 moves with rotary axes and is not supported".to_owned());
                }
                _ if CHANGES_DATUM.contains(&code) && block.ends_program() => {}
                _ if CHANGES_DATUM.contains(&code) => self.change_datum(line, code)?,
                _ if CHANGES_MOTION.contains(&code) => {
                    return Err(format!("M{code} changes motion or feed and is not supported"));
                }
                _ if (0.0..=9.0).contains(&code) || [99.0, 126.0, 127.0, 129.0].contains(&code) => {
                }
                _ => {
                    self.unknown_codes.push((line, code));
                    if self.cutter.is_on != Some(false) {
                        self.end_unknown();
                    } else if !block.is_quiet() {
                        self.tell_unknown();
                    }
                }
            }
        }
        Ok(())
    }
}

/// Whether BEGIN PGM or END PGM states inches, not mm, by its last word: the name before it may
/// hold such a word, too. `None` where it states neither.
fn states_inches(text: &str) -> Option<bool> {
    match text.split_whitespace().last()?.to_ascii_uppercase().as_str() {
        "INCH" | "IN" => Some(true),
        "MM" => Some(false),
        _ => None,
    }
}

/// The text of a block, its continued lines joined.
fn joined<'t>(text: &Text<'t>) -> Cow<'t, str> {
    let first = content(text.parts[0].1);
    if text.parts.len() == 1 {
        return Cow::Borrowed(first);
    }
    let others = text.parts.iter().skip(1);
    let others = others.map(|part| part.1.split(';').next().unwrap_or("").trim());
    Cow::Owned(std::iter::once(first).chain(others).collect::<Vec<_>>().join(" "))
}

/// A word that reads Q108.
fn is_radius(word: &Word<'_>) -> bool {
    word.parameter() == Some(RADIUS)
}

/// The block without M118 and the axes behind it: how far the handwheel may shift them. `None` if
/// it has no M118.
fn without_handwheel<'t>(block: &Block<'t>) -> Option<Block<'t>> {
    let begins = |word: &Word<'_>| word.name == "M" && word.value == Some(118.0);
    if !block.words.iter().any(begins) {
        return None;
    }
    let mut is_behind = false;
    let mut stays = |word: &&Word<'t>| {
        let is_axis = ["X", "Y", "Z", "A", "B", "C"].contains(&word.name);
        is_behind = begins(word) || is_behind && is_axis;
        !is_behind
    };
    let words = block.words.iter().filter(|word| stays(word)).copied().collect();
    Some(Block { words, quoted: block.quoted })
}

/// `PLANE SPATIAL SPA+0 SPB+0 SPC+0`.
fn turns_nothing(block: &Block<'_>) -> bool {
    ["SPA", "SPB", "SPC"].iter().all(|angle| block.get(angle) == Some(0.0))
}

/// Whether a block cannot stand between the two lines of a corner, which are drawn together.
fn parts_lines(block: &Block<'_>) -> bool {
    let parts = |code: f64| ![7.0, 8.0, 9.0].contains(&code);
    let reckons = block.name(0) == "FN" || block.name(0).starts_with('Q');
    !(reckons || matches!(block.name(0), "L" | "LP" | "CC" | "RND" | "CHF" | "" | "M" | "LBL"))
        || block.all("M").any(parts)
}

/// FMAX, which some posts write apart.
fn is_rapid(block: &Block<'_>) -> bool {
    block.has("FMAX") || block.is_after("F", "MAX")
}

/// Words that a block of motion may have behind its first.
fn is_of_motion(name: &str) -> bool {
    // LA of M120: how far ahead a corrected contour is looked at.
    const WORDS: [&str; 31] = [
        "", "X", "Y", "Z", "IX", "IY", "IZ", "A", "B", "C", "IA", "IB", "IC", "PR", "PA", "IPA",
        "IPR", "DR", "R", "RL", "RR", "F", "FMAX", "FAUTO", "FU", "MAX", "AUTO", "M", "MB", "LA",
        "Q",
    ];
    WORDS.contains(&name) || name.starts_with('Q')
}
