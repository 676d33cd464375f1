//! A program with other spindle speeds and feeds where it states them, and every other byte kept.
//!
//! G-code: S words (S0 stays) and F words per minute. APT: SPINDL and FEDRAT per minute, and the
//! feeds of cycles. Feeds per revolution keep the chip load by themselves and stay. RAPID has no
//! instruction for the spindle, so there is nothing that could be rewritten with certainty. A word
//! belongs to the first move under a turning spindle at or behind its line. What is written is read
//! again: each move must have the speed that was asked for and a feed to match.

use super::{Dialect, Program, RAPID_M_PER_S, Settings, read};
use crate::motion::{Move, Spindle};
use crate::notes::{Code, Note, Place};

/// What to write where the program states speeds.
#[derive(Debug, Clone, PartialEq)]
pub struct Rewrite {
    /// The speeds of the program's stretches, in order.
    pub speeds: Vec<NewSpeed>,
    /// Whether feeds follow the speed that the program states, so that the chip load stays; else
    /// they stay.
    pub keeps_chip_load: bool,
}

/// A new speed of a stretch of a program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewSpeed {
    /// Index of the move behind its last one.
    pub end: usize,
    /// Spindle speed, rev/min.
    pub rpm: f64,
    /// The speed so far, rev/min, where the program states none.
    pub old_rpm: f64,
}

/// A program rewritten.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rewritten {
    /// The new program.
    pub bytes: Vec<u8>,
    /// Spindle speeds that were changed or confirmed.
    pub speeds: usize,
    /// Feeds that were changed.
    pub feeds: usize,
    /// Feeds per revolution, which stay.
    pub feeds_per_revolution: usize,
}

/// Stands in for the feed of the job, so that moves at it are known.
const FEED_OF_JOB_M_PER_S: f64 = 0.123_456_789;

/// Rewrites a program that [`read`] understands.
///
/// # Errors
/// The dialect states no spindle speed, or this program does not; a pitch would change, or a feed
/// holds for stretches whose speeds change differently.
pub fn rewrite(bytes: &[u8], dialect: Dialect, to: &Rewrite) -> Result<Rewritten, Note> {
    let at = || Place { line: Some(1), ..Place::default() };
    let fault = |what: &str| Note::error(Code::NotWritten, at(), what);
    if dialect == Dialect::Rapid {
        return Err(fault(
            "is not rewritten: RAPID has no instruction for the spindle, its speed is a convention \
             of the cell; set it there, and scale the speeds by the override",
        ));
    }
    let reread = |bytes: &[u8]| {
        let settings = Settings {
            procedure: None,
            tcp: None,
            work_object: None,
            feed_m_per_s: Some(FEED_OF_JOB_M_PER_S),
            rapid_m_per_s: RAPID_M_PER_S,
            joint_count: 6,
            spindle_from: None,
            tool_from: None,
        };
        read(bytes, dialect, &settings).map_err(|notes| {
            fault(notes.first().map_or("is not understood", |note| note.what.as_str()))
        })
    };
    let before = reread(bytes)?;
    let plan = Plan::new(&before.moves, to);
    let mut pen = Pen {
        bytes,
        plan: &plan,
        done: 0,
        out: Rewritten {
            bytes: Vec::with_capacity(bytes.len()),
            speeds: 0,
            feeds: 0,
            feeds_per_revolution: 0,
        },
        changes_pitch: false,
    };
    match dialect {
        Dialect::GCode => gcode(&mut pen),
        Dialect::Apt | Dialect::Rapid => apt(&mut pen),
    }
    if pen.changes_pitch {
        return Err(fault(
            "is not rewritten: it taps (G84, G74, CYCLE/TAP), and with this feed the pitch would \
             change",
        ));
    }
    let mut out = pen.out;
    out.bytes.extend_from_slice(&bytes[pen.done..]);
    if out.speeds == 0 {
        return Err(fault("is not rewritten: it states no spindle speed"));
    }
    match plan.mismatch(&before, &reread(&out.bytes)?) {
        None => Ok(out),
        Some(what) => Err(fault(&format!("is not rewritten: {what}"))),
    }
}

/// What each move is to have.
struct Plan<'a> {
    to: &'a Rewrite,
    moves: &'a [Move],
    /// For each move, the first at or behind it under a spindle that turns, else the last before.
    turning: Vec<usize>,
}

/// What changes at a place of the program.
#[derive(Clone, Copy)]
struct Change {
    rpm: f64,
    /// New speed over old.
    speed_ratio: f64,
    /// New feed over old.
    feed_ratio: f64,
}

impl<'a> Plan<'a> {
    fn new(moves: &'a [Move], to: &'a Rewrite) -> Self {
        let turns = |i: &usize| moves[*i].spindle_turns && stated_rpm(&moves[*i]).is_some();
        let last = (0..moves.len()).rev().find(turns).unwrap_or(0);
        let mut turning = vec![last; moves.len()];
        let mut next = last;
        for i in (0..=last.min(moves.len().saturating_sub(1))).rev() {
            if turns(&i) {
                next = i;
            }
            turning[i] = next;
        }
        Self { to, moves, turning }
    }

    /// For words of a line.
    fn at_line(&self, line: usize) -> Change {
        let index = self.moves.partition_point(|each| each.line < line);
        let last = self.moves.len().saturating_sub(1);
        self.of_move(self.turning.get(index.min(last)).copied().unwrap_or(0))
    }

    fn of_move(&self, index: usize) -> Change {
        let speeds = &self.to.speeds;
        let of = speeds.partition_point(|speed| speed.end <= index).min(speeds.len().max(1) - 1);
        let new = speeds.get(of).copied();
        let stated = self.moves.get(index).and_then(stated_rpm);
        let rpm = new.map(|new| new.rpm).or(stated).unwrap_or(0.0);
        let old = stated.or(new.map(|new| new.old_rpm)).unwrap_or(rpm);
        let speed_ratio = if old > 0.0 { rpm / old } else { 1.0 };
        let feed_ratio = if self.to.keeps_chip_load { speed_ratio } else { 1.0 };
        Change { rpm, speed_ratio, feed_ratio }
    }

    /// The first move that does not run as it is to, in words.
    fn mismatch(&self, before: &Program, after: &Program) -> Option<String> {
        /// Speeds and feeds are written with three decimals, maybe of an inch.
        const SLACK_RPM: f64 = 1e-3;
        const SLACK_M_PER_S: f64 = 3e-7;
        if before.moves.len() != after.moves.len() {
            return Some("its moves would change".to_owned());
        }
        let pairs = before.moves.iter().zip(&after.moves).enumerate().skip(1);
        for (index, (old, new)) in pairs {
            let line = old.line;
            if old.to != new.to {
                return Some(format!("the move of line {line} would change"));
            }
            let change = self.of_move(index);
            if let Some(rpm) = stated_rpm(new)
                && (rpm - change.rpm).abs() > SLACK_RPM
            {
                return Some(format!("line {line} would run at {rpm} rpm, not {}", change.rpm));
            }
            let keeps = old.feed_m_per_s == RAPID_M_PER_S
                || old.feed_m_per_s == FEED_OF_JOB_M_PER_S
                || !old.spindle_turns;
            let per_time = Some(change.feed_ratio);
            let per_turn = before.feeds.per_revolution.then_some(change.speed_ratio);
            let fits =
                |ratio: f64| (new.feed_m_per_s - old.feed_m_per_s * ratio).abs() <= SLACK_M_PER_S;
            if !keeps && ![per_time, per_turn].into_iter().flatten().any(fits) {
                return Some(format!(
                    "the feed of line {line} is stated before the speed changes and would not \
                     follow it; state the feed anew after each change of speed"
                ));
            }
        }
        None
    }
}

/// The speed that the program states for a move.
fn stated_rpm(each: &Move) -> Option<f64> {
    each.stated.spindle.and_then(Spindle::rpm)
}

/// Copies bytes and writes numbers anew.
struct Pen<'a> {
    bytes: &'a [u8],
    plan: &'a Plan<'a>,
    /// Bytes before this are written.
    done: usize,
    out: Rewritten,
    /// Whether a tap would advance otherwise per turn than it did.
    changes_pitch: bool,
}

impl Pen<'_> {
    fn replace(&mut self, number: &Number, value: f64) {
        let new = written(value);
        if new.parse() == Ok(number.value) {
            return;
        }
        let had_point = self.bytes[number.start..number.end].contains(&b'.');
        self.out.bytes.extend_from_slice(&self.bytes[self.done..number.start]);
        self.out.bytes.extend_from_slice(new.as_bytes());
        if had_point && !new.contains('.') {
            self.out.bytes.push(b'.');
        }
        self.done = number.end;
    }

    /// A tap at a feed per minute.
    fn tap(&mut self, line: usize) {
        /// Speeds and feeds are written with three decimals.
        const SLACK: f64 = 1e-6;
        let Change { speed_ratio, feed_ratio, .. } = self.plan.at_line(line);
        self.changes_pitch |= (speed_ratio - feed_ratio).abs() > SLACK * speed_ratio;
    }

    fn speed(&mut self, number: &Number, line: usize) {
        self.out.speeds += 1;
        self.replace(number, self.plan.at_line(line).rpm);
    }

    fn feed(&mut self, number: &Number, line: usize) {
        self.out.feeds += 1;
        self.replace(number, number.value * self.plan.at_line(line).feed_ratio);
    }
}

/// Three decimals at most, or as many as a small number needs.
fn written(value: f64) -> String {
    let rounded = (value * 1e3).round() / 1e3;
    if rounded > 0.0 { rounded.to_string() } else { value.to_string() }
}

/// A number and where it stands.
#[derive(Debug, Clone, Copy)]
struct Number {
    start: usize,
    end: usize,
    value: f64,
}

/// Lines as ranges of bytes, ends left out; a text without `\n` has its lines ended by `\r`.
fn line_ranges(bytes: &[u8]) -> Vec<(usize, usize)> {
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    let mut lines = Vec::new();
    let mut start = 0;
    for line in bytes.split(|&byte| byte == end) {
        lines.push((start, start + line.len()));
        start += line.len() + 1;
    }
    lines
}

fn gcode(pen: &mut Pen) {
    let bytes = pen.bytes;
    let mut per_revolution = false;
    for (index, (start, end)) in line_ranges(bytes).into_iter().enumerate() {
        let at = index + 1;
        let words = gcode_words(bytes, start, end);
        let code =
            |wanted: f64| words.iter().any(|(letter, n)| *letter == b'G' && n.value == wanted);
        if code(95.0) {
            per_revolution = true;
        } else if code(94.0) || code(93.0) {
            per_revolution = false;
        }
        let dwells = code(4.0);
        if !per_revolution && [74.0, 84.0].into_iter().any(code) {
            pen.tap(at);
        }
        for (letter, number) in &words {
            match letter {
                b'S' if number.value > 0.0 && !dwells => pen.speed(number, at),
                b'F' if dwells => {}
                b'F' if per_revolution => pen.out.feeds_per_revolution += 1,
                b'F' => pen.feed(number, at),
                _ => {}
            }
        }
    }
}

/// Letters in upper case with the numbers behind them; comments are left out.
fn gcode_words(bytes: &[u8], start: usize, end: usize) -> Vec<(u8, Number)> {
    let mut words: Vec<(u8, Number)> = Vec::new();
    let mut open: Option<(u8, Option<usize>, usize, String)> = None;
    let mut close = |open: &mut Option<(u8, Option<usize>, usize, String)>| {
        if let Some((letter, Some(start), end, digits)) = open.take()
            && let Ok(value) = digits.parse()
        {
            words.push((letter, Number { start, end, value }));
        }
    };
    let mut at = start;
    while at < end {
        match bytes[at] {
            b';' => break,
            b'(' => {
                // A comment may stand within a word.
                while at < end && bytes[at] != b')' {
                    at += 1;
                }
            }
            byte if byte.is_ascii_alphabetic() => {
                close(&mut open);
                open = Some((byte.to_ascii_uppercase(), None, at, String::new()));
            }
            byte if byte.is_ascii_digit() || matches!(byte, b'.' | b'+' | b'-') => {
                if let Some((_, first, last, digits)) = &mut open {
                    first.get_or_insert(at);
                    *last = at + 1;
                    digits.push(char::from(byte));
                }
            }
            _ => {}
        }
        at += 1;
    }
    close(&mut open);
    words
}

fn apt(pen: &mut Pen) {
    let bytes = pen.bytes;
    let mut statement: Vec<(String, Number)> = Vec::new();
    let mut first_line = None;
    for (index, (start, end)) in line_ranges(bytes).into_iter().enumerate() {
        let at = *first_line.get_or_insert(index + 1);
        let line = &bytes[start..end];
        let comment = line.windows(2).position(|pair| pair == b"$$").unwrap_or(line.len());
        let content = line[..comment].trim_ascii_end();
        let continued = content.last() == Some(&b'$');
        let content = if continued { &content[..content.len() - 1] } else { content };
        fields(content, start, &mut statement);
        if !continued {
            apt_statement(pen, at, &statement);
            statement.clear();
            first_line = None;
        }
    }
    apt_statement(pen, first_line.unwrap_or(1), &statement);
}

/// What stands between `/` and `,`, in upper case without blanks, each with the number that it may
/// be.
fn fields(content: &[u8], offset: usize, statement: &mut Vec<(String, Number)>) {
    let mut start = 0;
    for field in content.split(|&byte| matches!(byte, b'/' | b',')) {
        let trimmed = field.trim_ascii();
        let blank = field.len() - field.trim_ascii_start().len();
        let text = String::from_utf8_lossy(trimmed).to_ascii_uppercase();
        let is_number =
            text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'));
        let value = text.parse().ok().filter(|_| is_number).unwrap_or(f64::NAN);
        let from = offset + start + blank;
        statement.push((text, Number { start: from, end: from + trimmed.len(), value }));
        start += field.len() + 1;
    }
}

fn apt_statement(pen: &mut Pen, at: usize, statement: &[(String, Number)]) {
    let Some(((major, _), minor)) = statement.split_first() else { return };
    let has = |wanted: &[&str]| minor.iter().any(|(text, _)| wanted.contains(&text.as_str()));
    let first = minor.iter().map(|(_, number)| number).find(|number| number.value.is_finite());
    match (major.as_str(), first) {
        ("SPINDL", Some(number)) if !has(&["OFF", "SFM", "SMM"]) && number.value > 0.0 => {
            pen.speed(number, at);
        }
        ("FEDRAT", Some(_)) if has(&["PERREV", "MMPR", "IPR"]) => pen.out.feeds_per_revolution += 1,
        ("FEDRAT", Some(number)) => pen.feed(number, at),
        ("CYCLE", _) => {
            let per_revolution = has(&["MMPR", "IPR", "PERREV"]);
            if has(&["TAP"]) && !per_revolution {
                pen.tap(at);
            }
            for pair in minor.windows(2) {
                let (unit, number) = (pair[0].0.as_str(), &pair[1].1);
                if matches!(unit, "MMPM" | "IPM" | "PERMIN") && number.value.is_finite() {
                    pen.feed(number, at);
                } else if matches!(unit, "MMPR" | "IPR" | "PERREV") {
                    pen.out.feeds_per_revolution += 1;
                }
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::settings;
    use super::*;

    /// One speed for the whole program.
    fn to(rpm: f64, keeps_chip_load: bool) -> Rewrite {
        let whole = NewSpeed { end: usize::MAX, rpm, old_rpm: 900.0 };
        Rewrite { speeds: vec![whole], keeps_chip_load }
    }

    /// The reader sees the same moves, one spindle speed, and feeds that follow it.
    fn holds(text: &[u8], dialect: Dialect, expected: &[u8]) {
        let found = rewrite(text, dialect, &to(1375.0, true)).unwrap();
        assert_eq!(String::from_utf8_lossy(&found.bytes), String::from_utf8_lossy(expected));
        let before = read(text, dialect, &settings()).unwrap();
        let after = read(&found.bytes, dialect, &settings()).unwrap();
        assert_eq!(before.moves.len(), after.moves.len());
        for (a, b) in before.moves.iter().zip(&after.moves) {
            assert_eq!((&a.to, a.line), (&b.to, b.line));
            let ratio = b.feed_m_per_s / a.feed_m_per_s;
            assert!(a.feed_m_per_s == RAPID_M_PER_S || (ratio - 1.25).abs() < 1e-9, "{ratio}");
        }
        assert_eq!(before.spindle.len(), after.spindle.len());
        for (a, b) in before.spindle.iter().zip(&after.spindle) {
            let expected = match a.spindle {
                Spindle::Turns(Some(_)) => Spindle::Turns(Some(1375.0)),
                other => other,
            };
            assert_eq!(b.spindle, expected);
        }
    }

    #[test]
    fn gcode_keeps_all_but_speeds_and_feeds() {
        holds(
            b"(S900 F1 \xE4)\r\nN10 g0 X0 Y0 Z0 s 1 100 M3 ; S1\r\nG1X10F400.\r\n\
              Y5 f80 (F2) S0\r\nG4 P1\r\nS1100\r\nX1\r\n",
            Dialect::GCode,
            b"(S900 F1 \xE4)\r\nN10 g0 X0 Y0 Z0 s 1375 M3 ; S1\r\nG1X10F500.\r\n\
              Y5 f100 (F2) S0\r\nG4 P1\r\nS1375\r\nX1\r\n",
        );
        let per_revolution = b"S1000 M3\nG95 G1 X0 Y0 Z0 F0.2\nX1\nG94 F100\nX2\n";
        let found = rewrite(per_revolution, Dialect::GCode, &to(1250.0, true)).unwrap();
        assert_eq!((found.speeds, found.feeds, found.feeds_per_revolution), (1, 1, 1));
        assert!(String::from_utf8(found.bytes).unwrap().contains("F0.2\nX1\nG94 F125\n"));
    }

    #[test]
    fn apt_keeps_all_but_speeds_and_feeds() {
        holds(
            b"PARTNO SPINDL/1\n$$ SPINDL/2\nspindl/ 1100 ,RPM,CLW\nFEDRAT/300,MMPM $$ F\n\
              GOTO/0,0,0\nGOTO/$\n1,0,0\nCYCLE/DRILL,DEPTH,5,MMPM,80,CLEAR,2\nGOTO/2,0,0\n\
              CYCLE/OFF\nSPINDL/OFF\n",
            Dialect::Apt,
            b"PARTNO SPINDL/1\n$$ SPINDL/2\nspindl/ 1375 ,RPM,CLW\nFEDRAT/375,MMPM $$ F\n\
              GOTO/0,0,0\nGOTO/$\n1,0,0\nCYCLE/DRILL,DEPTH,5,MMPM,100,CLEAR,2\nGOTO/2,0,0\n\
              CYCLE/OFF\nSPINDL/OFF\n",
        );
    }

    #[test]
    fn what_stays_keeps_its_bytes() {
        let same = to(1340.0, false);
        let text = b"S1100. M3\nG0 X0 Y0 Z0\nG1 X1 F0300.00\n";
        let found = rewrite(text, Dialect::GCode, &same).unwrap();
        assert_eq!(found.bytes, b"S1340. M3\nG0 X0 Y0 Z0\nG1 X1 F0300.00\n");
    }

    #[test]
    fn pitches_are_not_lost() {
        let rewritten = |text: &str, dialect, keeps_chip_load| {
            rewrite(text.as_bytes(), dialect, &to(1340.0, keeps_chip_load)).map_err(|why| why.what)
        };
        let tap = "S1000 M3\nG84 X0 Y0 Z-5 R1 F1000\nG80\n";
        let at = "G0 X0 Y0 Z5\n".to_owned() + tap;
        assert!(rewritten(&at, Dialect::GCode, false).unwrap_err().contains("pitch"));
        assert!(rewritten(&at, Dialect::GCode, true).is_ok());
        let tap = "SPINDL/1000\nCYCLE/TAP,DEPTH,5,MMPM,1000\nGOTO/0,0,0\n";
        assert!(rewritten(tap, Dialect::Apt, false).unwrap_err().contains("pitch"));
    }

    /// Each stretch has its own speed; feeds follow the speed that the program ran at, and a feed
    /// that holds beyond a change of speed cannot follow two.
    #[test]
    fn each_stretch_has_its_own_speed_and_feed() {
        let rewritten = |text: &str| {
            let speed = |end, rpm| NewSpeed { end, rpm, old_rpm: 1.0 };
            let speeds = vec![speed(2, 1500.0), speed(4, 1000.0)];
            let to = Rewrite { speeds, keeps_chip_load: true };
            rewrite(text.as_bytes(), Dialect::GCode, &to)
                .map(|out| String::from_utf8(out.bytes).unwrap())
                .map_err(|why| why.what)
        };
        assert_eq!(
            rewritten("S1000 M3\nG1 X0 Y0 Z0 F100\nX1\nM5\nF80\nS500 M3\nX2\nX3\nM5\n").unwrap(),
            "S1500 M3\nG1 X0 Y0 Z0 F150\nX1\nM5\nF160\nS1000 M3\nX2\nX3\nM5\n"
        );
        let modal = "S1000 M3\nG1 X0 Y0 Z0 F100\nX1\nS500\nX2\nX3\n";
        assert!(rewritten(modal).unwrap_err().contains("the feed of line 5"));
    }

    #[test]
    fn what_states_no_speed_is_not_rewritten() {
        let refused = |text: &str, dialect| {
            rewrite(text.as_bytes(), dialect, &to(1340.0, true)).unwrap_err().what
        };
        assert!(refused("MODULE m\nENDMODULE\n", Dialect::Rapid).contains("convention"));
        assert!(refused("G1 X0 Y0 Z0 F100\n", Dialect::GCode).contains("states no spindle speed"));
        assert!(refused("GOTO/0,0,0\n", Dialect::Apt).contains("states no spindle speed"));
    }
}
