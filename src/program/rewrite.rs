//! A program with another spindle speed and other feeds where it states them, and every other byte
//! kept.
//!
//! G-code: S words (S0 stays) and F words per minute. APT: SPINDL and FEDRAT per minute, and the
//! feeds of cycles. Feeds per revolution keep the chip load by themselves and stay. RAPID has no
//! instruction for the spindle, so there is nothing that could be rewritten with certainty.

use super::Dialect;
use crate::notes::{Code, Note, Place};

/// What to write where the program states speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rewrite {
    /// Spindle speed, rev/min.
    pub rpm: f64,
    /// New feeds as a multiple of the old ones.
    pub feed_ratio: f64,
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

/// Rewrites a program that [`super::read`] understands.
///
/// # Errors
/// The dialect states no spindle speed, or this program does not.
pub fn rewrite(bytes: &[u8], dialect: Dialect, to: &Rewrite) -> Result<Rewritten, Note> {
    let at = || Place { line: Some(1), ..Place::default() };
    let fault = |what: &str| Note::error(Code::NotWritten, at(), what);
    let mut pen = Pen {
        bytes,
        to,
        done: 0,
        out: Rewritten {
            bytes: Vec::with_capacity(bytes.len()),
            speeds: 0,
            feeds: 0,
            feeds_per_revolution: 0,
        },
        speed: None,
        speeds_differ: false,
        taps: false,
    };
    match dialect {
        Dialect::Rapid => {
            return Err(fault(
                "is not rewritten: RAPID has no instruction for the spindle, its speed is a \
                 convention of the cell; set it there, and scale the speeds by the override",
            ));
        }
        Dialect::GCode => gcode(&mut pen),
        Dialect::Apt => apt(&mut pen),
    }
    if pen.speeds_differ {
        return Err(fault(
            "is not rewritten: it states several spindle speeds, which one speed would flatten",
        ));
    }
    if pen.changes_pitch() {
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
    Ok(out)
}

/// Copies bytes and writes numbers anew.
struct Pen<'a> {
    bytes: &'a [u8],
    to: &'a Rewrite,
    /// Bytes before this are written.
    done: usize,
    out: Rewritten,
    /// The speed that the program states, rev/min.
    speed: Option<f64>,
    speeds_differ: bool,
    /// Whether it taps at a feed per minute.
    taps: bool,
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

    /// Whether a tap would advance otherwise per turn than it did.
    fn changes_pitch(&self) -> bool {
        /// Speeds and feeds are written with three decimals.
        const SLACK: f64 = 1e-6;
        let ratio = self.speed.map(|old| self.to.rpm / old);
        self.taps && ratio.is_some_and(|ratio| (ratio - self.to.feed_ratio).abs() > SLACK * ratio)
    }

    fn speed(&mut self, number: &Number) {
        self.out.speeds += 1;
        self.speeds_differ |= self.speed.is_some_and(|other| other != number.value);
        self.speed = Some(number.value);
        self.replace(number, self.to.rpm);
    }

    fn feed(&mut self, number: &Number) {
        self.out.feeds += 1;
        self.replace(number, number.value * self.to.feed_ratio);
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
    for (start, end) in line_ranges(bytes) {
        let words = gcode_words(bytes, start, end);
        let code =
            |wanted: f64| words.iter().any(|(letter, n)| *letter == b'G' && n.value == wanted);
        if code(95.0) {
            per_revolution = true;
        } else if code(94.0) || code(93.0) {
            per_revolution = false;
        }
        let dwells = code(4.0);
        pen.taps |= !per_revolution && [74.0, 84.0].into_iter().any(code);
        for (letter, number) in &words {
            match letter {
                b'S' if number.value > 0.0 && !dwells => pen.speed(number),
                b'F' if dwells => {}
                b'F' if per_revolution => pen.out.feeds_per_revolution += 1,
                b'F' => pen.feed(number),
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
    for (start, end) in line_ranges(bytes) {
        let line = &bytes[start..end];
        let comment = line.windows(2).position(|pair| pair == b"$$").unwrap_or(line.len());
        let content = line[..comment].trim_ascii_end();
        let continued = content.last() == Some(&b'$');
        let content = if continued { &content[..content.len() - 1] } else { content };
        fields(content, start, &mut statement);
        if !continued {
            apt_statement(pen, &statement);
            statement.clear();
        }
    }
    apt_statement(pen, &statement);
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

fn apt_statement(pen: &mut Pen, statement: &[(String, Number)]) {
    let Some(((major, _), minor)) = statement.split_first() else { return };
    let has = |wanted: &[&str]| minor.iter().any(|(text, _)| wanted.contains(&text.as_str()));
    let first = minor.iter().map(|(_, number)| number).find(|number| number.value.is_finite());
    match (major.as_str(), first) {
        ("SPINDL", Some(number)) if !has(&["OFF", "SFM", "SMM"]) && number.value > 0.0 => {
            pen.speed(number);
        }
        ("FEDRAT", Some(_)) if has(&["PERREV", "MMPR", "IPR"]) => pen.out.feeds_per_revolution += 1,
        ("FEDRAT", Some(number)) => pen.feed(number),
        ("CYCLE", _) => {
            let per_revolution = has(&["MMPR", "IPR", "PERREV"]);
            pen.taps |= has(&["TAP"]) && !per_revolution;
            for pair in minor.windows(2) {
                let (unit, number) = (pair[0].0.as_str(), &pair[1].1);
                if matches!(unit, "MMPM" | "IPM" | "PERMIN") && number.value.is_finite() {
                    pen.feed(number);
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
    use super::super::{RAPID_M_PER_S, Spindle, read};
    use super::*;

    const TO: Rewrite = Rewrite { rpm: 1340.0, feed_ratio: 1.25 };

    /// The reader sees the same moves, feeds a quarter faster and one spindle speed.
    fn holds(text: &[u8], dialect: Dialect, expected: &[u8]) {
        let found = rewrite(text, dialect, &TO).unwrap();
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
                Spindle::Turns(Some(_)) => Spindle::Turns(Some(1340.0)),
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
            b"(S900 F1 \xE4)\r\nN10 g0 X0 Y0 Z0 s 1340 M3 ; S1\r\nG1X10F500.\r\n\
              Y5 f100 (F2) S0\r\nG4 P1\r\nS1340\r\nX1\r\n",
        );
        let per_revolution = b"S1000 M3\nG95 G1 X0 Y0 Z0 F0.2\nX1\nG94 F100\nX2\n";
        let found = rewrite(per_revolution, Dialect::GCode, &TO).unwrap();
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
            b"PARTNO SPINDL/1\n$$ SPINDL/2\nspindl/ 1340 ,RPM,CLW\nFEDRAT/375,MMPM $$ F\n\
              GOTO/0,0,0\nGOTO/$\n1,0,0\nCYCLE/DRILL,DEPTH,5,MMPM,100,CLEAR,2\nGOTO/2,0,0\n\
              CYCLE/OFF\nSPINDL/OFF\n",
        );
    }

    #[test]
    fn what_stays_keeps_its_bytes() {
        let same = Rewrite { rpm: 1340.0, feed_ratio: 1.0 };
        let text = b"S1100. M3\nG0 X0 Y0 Z0\nG1 X1 F0300.00\n";
        let found = rewrite(text, Dialect::GCode, &same).unwrap();
        assert_eq!(found.bytes, b"S1340. M3\nG0 X0 Y0 Z0\nG1 X1 F0300.00\n");
    }

    #[test]
    fn pitches_and_several_speeds_are_not_lost() {
        let rewritten = |text: &str, dialect, feed_ratio| {
            let to = Rewrite { rpm: 1340.0, feed_ratio };
            rewrite(text.as_bytes(), dialect, &to).map_err(|why| why.what)
        };
        let tap = "S1000 M3\nG84 X0 Y0 Z-5 R1 F1000\nG80\n";
        assert!(rewritten(tap, Dialect::GCode, 1.0).unwrap_err().contains("pitch"));
        assert!(rewritten(tap, Dialect::GCode, 1.34).is_ok());
        let tap = "SPINDL/1000\nCYCLE/TAP,DEPTH,5,MMPM,1000\nGOTO/0,0,0\n";
        assert!(rewritten(tap, Dialect::Apt, 1.0).unwrap_err().contains("pitch"));
        let two = "S1000 M3\nG1 X0 Y0 Z0 F100\nS500\nX1\n";
        assert!(rewritten(two, Dialect::GCode, 1.0).unwrap_err().contains("several"));
    }

    #[test]
    fn what_states_no_speed_is_not_rewritten() {
        let refused =
            |text: &str, dialect| rewrite(text.as_bytes(), dialect, &TO).unwrap_err().what;
        assert!(refused("MODULE m\nENDMODULE\n", Dialect::Rapid).contains("convention"));
        assert!(refused("G1 X0 Y0 Z0 F100\n", Dialect::GCode).contains("states no spindle speed"));
        assert!(refused("GOTO/0,0,0\n", Dialect::Apt).contains("states no spindle speed"));
    }
}
