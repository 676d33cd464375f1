//! A program with other spindle speeds and feeds where it states them, and every other byte kept.
//!
//! There is one parser: the reader takes down where the text states what (`log::Word`), and numbers
//! are spliced in there. Feeds per revolution keep the chip load by themselves and stay. A word
//! belongs to the first move under a turning spindle at or behind it. What is written is read
//! again: each move must have the speed that was asked for and a feed to match.

use std::collections::BTreeMap;

use super::beside::beside;
use super::log::{States, Word};
use super::span::Span;
use super::text::{self, Decoded};
use super::{Dialect, Program, Settings, read};
use crate::motion::{Move, Spindle, Timing};
use crate::notes::{Code, Note, Place};
use crate::wording::plain;

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
    /// The speed so far, rev/min, where it is the job's and not the program's.
    pub job_rpm: Option<f64>,
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
    /// Where a number that changes means more than the path that was read: its line, and what.
    pub beside: Vec<(usize, String)>,
}

/// Stands in for the feed of the job, so that moves at it are known.
const FEED_OF_JOB_M_PER_S: f64 = 0.123_456_789;

const SLACK: f64 = 1e-6;

/// Feeds are written with as many decimals as leave them this share of their value off, three at
/// least.
const COARSE: f64 = 2e-6;

/// And speeds this much, rev/min.
const COARSE_RPM: f64 = 2e-4;

/// Rewrites a program that [`read`] understands with `settings`.
///
/// # Errors
/// The program states no spindle speed in a number of its text; a pitch would change, or a number
/// holds for stretches whose speeds change differently.
pub fn rewrite(
    bytes: &[u8],
    dialect: Dialect,
    settings: &Settings,
    to: &Rewrite,
) -> Result<Rewritten, Note> {
    rewrite_all(bytes, dialect, &[(settings, to)])
}

/// The same of a program that is run in several ways, each with its own settings: from another
/// procedure, or again.
///
/// # Errors
/// As above, of any.
pub fn rewrite_all(
    bytes: &[u8],
    dialect: Dialect,
    runs: &[(&Settings, &Rewrite)],
) -> Result<Rewritten, Note> {
    let decoded = text::decode(bytes)?;
    let read: Vec<Program> = runs
        .iter()
        .map(|(settings, _)| reread(bytes, dialect, settings))
        .collect::<Result<_, _>>()?;
    let mut changes = Changes::default();
    for (before, (settings, to)) in read.iter().zip(runs) {
        let plan = Plan::new(&before.moves, to);
        let speeds = changes.add(&before.words, &plan, &decoded.text).map_err(refused)?;
        if speeds == 0 {
            return Err(refused(no_speed(&before.words, dialect, settings)));
        }
    }
    let words = read.iter().flat_map(|before| &before.words);
    let out = Rewritten {
        bytes: spliced(bytes, &decoded, &changes.texts),
        speeds: changes.speeds,
        feeds: changes.feeds,
        feeds_per_revolution: changes.feeds_per_revolution,
        beside: beside(&decoded.text, dialect, words, &changes.texts),
    };
    for (before, (settings, to)) in read.iter().zip(runs) {
        let after = reread(&out.bytes, dialect, settings)?;
        if let Some(what) = Plan::new(&before.moves, to).mismatch(before, &after) {
            return Err(refused(what));
        }
    }
    Ok(out)
}

/// Reads a program with a feed of the job that is known again.
fn reread(bytes: &[u8], dialect: Dialect, settings: &Settings) -> Result<Program, Note> {
    let settings = Settings { feed_m_per_s: Some(FEED_OF_JOB_M_PER_S), ..settings.clone() };
    read(bytes, dialect, &settings).map_err(|notes| {
        fault(notes.first().map_or("is not understood", |note| note.what.as_str()))
    })
}

fn fault(what: &str) -> Note {
    let at = Place { line: Some(1), ..Place::default() };
    Note::error(Code::NotWritten, at, what)
}

fn refused(what: String) -> Note {
    fault(&format!("is not rewritten: {what}"))
}

/// Why no number of the text is a speed that can be changed.
fn no_speed(words: &[Word], dialect: Dialect, settings: &Settings) -> String {
    let is_speed = |word: &&Word| matches!(word.states, States::Spindle { .. });
    let why = "it states no spindle speed as a number";
    match words.iter().find(is_speed) {
        Some(word) if word.span.is_some() => {
            format!("nothing turns at the speed that line {} states", word.line)
        }
        Some(word) => format!("the spindle's speed at line {} {ELSEWHERE}", word.line),
        None if settings.spindle_from.is_some() => {
            format!("{why}, and nothing that path.program.spindle_from names sets one")
        }
        None => match dialect {
            Dialect::Rapid | Dialect::Krl | Dialect::Fanuc => format!(
                "{why}: {dialect} has no instruction for the spindle; say in \
                 path.program.spindle_from what sets it"
            ),
            _ => why.to_owned(),
        },
    }
}

/// What can be said of a value that is no number at its place in the text.
const ELSEWHERE: &str = "is computed, or is a number at another place: state it there as a number";

/// What is written where.
#[derive(Default)]
struct Changes {
    texts: BTreeMap<Span, String>,
    speeds: usize,
    feeds: usize,
    feeds_per_revolution: usize,
}

impl Changes {
    /// What one way to run the program asks for; how many of its numbers are spindle speeds.
    fn add(&mut self, words: &[Word], plan: &Plan<'_>, text: &str) -> Result<usize, String> {
        let mut speeds = 0;
        for (word, holds) in words.iter().zip(plan.holding(words)) {
            if !holds {
                continue;
            }
            let change = plan.at_move(word.from_move);
            let of_feed = |value: f64| {
                let new = value * change.feed_ratio;
                (value, new, COARSE * new)
            };
            let (value, new, slack) = match word.states {
                States::Spindle { value, rpm_per_unit, whole } => {
                    // Whether a whole number misses the speed is seen when it is read again.
                    let slack = if whole { 0.5 } else { COARSE_RPM / rpm_per_unit };
                    (value, change.rpm / rpm_per_unit, slack)
                }
                States::Feed { value } => of_feed(value),
                States::NamedFeed { mm_per_s, .. } => of_feed(mm_per_s),
                States::Seconds { value } => {
                    let new = value / change.feed_ratio;
                    (value, new, COARSE * new)
                }
                States::FeedPerRevolution => {
                    self.feeds_per_revolution += 1;
                    continue;
                }
                States::Tap => {
                    let Change { turns_ratio, feed_ratio, .. } = change;
                    if (turns_ratio - feed_ratio).abs() > SLACK * turns_ratio {
                        let what = "it taps (G84, G74, cycle 206, CYCLE/TAP), and with this \
                                    feed the pitch would change";
                        return Err(what.to_owned());
                    }
                    continue;
                }
            };
            let is_speed = matches!(word.states, States::Spindle { .. });
            // What is computed stays; whether that is right is seen when the result is read.
            let Some(span) = word.span else { continue };
            let old = text.get(span.start..span.end).unwrap_or("");
            let written = match word.states {
                States::Spindle { whole: true, .. } => written(new.round(), 0, slack),
                States::Spindle { .. } => written(new, 0, slack),
                _ => written(new, 3, slack),
            };
            let new = match word.states {
                _ if written.parse() == Ok(value) => old.to_owned(),
                States::NamedFeed { takes_v: true, .. } => format!("{old}\\V:={written}"),
                // v_ori, v_leax and v_reax of the language's own speeds.
                States::NamedFeed { .. } => format!("[{written},500,5000,1000]"),
                _ => number_like(old, written),
            };
            speeds += usize::from(is_speed);
            match self.texts.get(&span) {
                None => {
                    self.speeds += usize::from(is_speed);
                    self.feeds += usize::from(!is_speed);
                    self.texts.insert(span, new);
                }
                Some(other) if *other == new => {}
                Some(other) => {
                    return Err(format!(
                        "'{old}' is one number for several moves, those behind line {} among \
                         them, of which some need {other} and others {new}: state a number for \
                         each, or have both run at one speed",
                        word.line
                    ));
                }
            }
        }
        Ok(speeds)
    }
}

/// A number with a decimal point where the one before had one.
fn number_like(old: &str, mut new: String) -> String {
    if old.contains('.') && !new.contains('.') {
        new.push_str(if old.ends_with('.') { "." } else { ".0" });
    }
    new
}

/// The fewest decimals, but as many as `least`, that leave a value off by `slack`; no zeros behind
/// them.
fn written(value: f64, least: usize, slack: f64) -> String {
    /// Beyond, an f64 holds no digit of a number that matters here.
    const MOST: usize = 15;
    for decimals in least..MOST {
        let text = format!("{value:.decimals$}");
        let is_near = text.parse::<f64>().is_ok_and(|read| (read - value).abs() <= slack);
        if is_near {
            let shown = if decimals == 0 { &text } else { text.trim_end_matches('0') };
            return shown.trim_end_matches('.').to_owned();
        }
    }
    value.to_string()
}

fn spliced(bytes: &[u8], decoded: &Decoded, texts: &BTreeMap<Span, String>) -> Vec<u8> {
    let places: Vec<usize> = texts.keys().flat_map(|span| [span.start, span.end]).collect();
    let in_file = decoded.in_file(&places);
    let mut out = Vec::with_capacity(bytes.len());
    let mut done = 0;
    for (place, text) in in_file.chunks_exact(2).zip(texts.values()) {
        out.extend_from_slice(&bytes[done..place[0]]);
        out.extend_from_slice(text.as_bytes());
        done = place[1];
    }
    out.extend_from_slice(&bytes[done..]);
    out
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
    /// New speed over the one that the program states.
    turns_ratio: f64,
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

    /// For words that hold from a move on.
    fn at_move(&self, index: usize) -> Change {
        let last = self.moves.len().saturating_sub(1);
        self.of_move(self.turning.get(index.min(last)).copied().unwrap_or(0))
    }

    fn of_move(&self, index: usize) -> Change {
        let speeds = &self.to.speeds;
        let of = speeds.partition_point(|speed| speed.end <= index).min(speeds.len().max(1) - 1);
        let new = speeds.get(of).copied();
        let stated = self.moves.get(index).and_then(stated_rpm);
        let rpm = new.map(|new| new.rpm).or(stated).unwrap_or(0.0);
        let over = |old: Option<f64>| old.filter(|old| *old > 0.0).map_or(1.0, |old| rpm / old);
        // Where the job's speed holds, the cut was checked at that.
        let speed_ratio = over(new.and_then(|new| new.job_rpm).or(stated));
        let feed_ratio = if self.to.keeps_chip_load { speed_ratio } else { 1.0 };
        Change { rpm, turns_ratio: over(stated), feed_ratio }
    }

    /// By word, whether a move runs under it. A speed that nothing turns at stays as it is: one to
    /// warm the spindle up, or for the program that follows. One that is stated again before
    /// anything moves follows the second.
    fn holding(&self, words: &[Word]) -> Vec<bool> {
        let is_speed = |word: &Word| matches!(word.states, States::Spindle { .. });
        let mut holds: Vec<bool> = words.iter().map(|w| w.from_move < self.moves.len()).collect();
        let mut next: Option<(&Word, bool)> = None;
        for (word, holds) in words.iter().zip(&mut holds).rev().filter(|(word, _)| is_speed(word)) {
            let end = next.map_or(self.moves.len(), |(next, _)| next.from_move);
            let own = self.moves.get(word.from_move..end).unwrap_or_default();
            let turns = own.iter().any(|each| each.spindle_turns && stated_rpm(each).is_some());
            let is_again = next
                .is_some_and(|(next, runs)| runs && next.states == word.states && own.is_empty());
            *holds = turns || is_again;
            next = Some((word, *holds));
        }
        holds
    }

    /// The first move that does not run as it is to, in words.
    fn mismatch(&self, before: &Program, after: &Program) -> Option<String> {
        const SLACK_RPM: f64 = 1e-3;
        if before.moves.len() != after.moves.len() {
            return Some("a number that changes decides which moves run, too".to_owned());
        }
        let pairs = before.moves.iter().zip(&after.moves).enumerate().skip(1);
        for (index, (old, new)) in pairs {
            let line = old.line;
            let is_same_place = old.to == new.to && old.tcp == new.tcp && old.work == new.work;
            if !is_same_place || line != new.line {
                return Some(format!(
                    "the move of line {line} would change: a number that changes places it, too"
                ));
            }
            let change = self.of_move(index);
            let (was, is) = (stated_rpm(old), stated_rpm(new));
            if was.is_some() != is.is_some() || old.spindle_turns != new.spindle_turns {
                return Some(format!("the spindle's speed at line {line} would be lost"));
            }
            if let Some(rpm) = is
                && (rpm - change.rpm).abs() > SLACK_RPM
            {
                let why = match before.speed_step_rpm() {
                    Some(step) => format!(
                        "what sets it takes whole numbers of {} rpm each, or it {ELSEWHERE}",
                        plain(step)
                    ),
                    None => format!("its speed {ELSEWHERE}"),
                };
                let [is, to] = [rpm, change.rpm].map(plain);
                return Some(format!("line {line} would run at {is} rpm, not {to}: {why}"));
            }
            let per_turn = before.feeds.per_revolution.then_some(change.turns_ratio);
            let ratios = [Some(change.feed_ratio), per_turn];
            if !ratios.into_iter().flatten().any(|ratio| keeps_pace(old, new, ratio)) {
                return Some(match old.timing {
                    Timing::Seconds(was) => format!(
                        "the time at line {line} would no longer be {} s: a number that changes \
                         sets it, too",
                        plain(was)
                    ),
                    _ => format!(
                        "the feed of line {line} would not be as advised: it {ELSEWHERE}; or it \
                         is bounded by a speed limit, or stated before the speed changes: state \
                         it behind each change of speed"
                    ),
                });
            }
        }
        None
    }
}

/// Whether a move runs so many times as fast as it did, or as it did where its speed is not the
/// program's.
fn keeps_pace(old: &Move, new: &Move, ratio: f64) -> bool {
    /// Three decimals, maybe of an inch a minute.
    const SLACK_M_PER_S: f64 = 3e-7;
    const SLACK_S: f64 = 2e-3;
    match (old.timing, new.timing) {
        (Timing::Feed, Timing::Feed) => {
            let is_of_job = old.feed_m_per_s == FEED_OF_JOB_M_PER_S;
            let expected = if is_of_job { old.feed_m_per_s } else { old.feed_m_per_s * ratio };
            let slack = SLACK_M_PER_S.max(1.01 * COARSE * expected);
            (new.feed_m_per_s - expected).abs() <= slack || !old.spindle_turns
        }
        // A dwell, or a time for a move.
        (Timing::Seconds(was), Timing::Seconds(is)) => {
            [was, was / ratio].into_iter().any(|expected| (is - expected).abs() <= SLACK_S)
        }
        (was, is) => was == is,
    }
}

/// The speed that the program states for a move.
fn stated_rpm(each: &Move) -> Option<f64> {
    each.stated.spindle.and_then(Spindle::rpm)
}

#[cfg(test)]
mod tests {
    use super::super::tests::settings;
    use super::*;

    const RAPID: &str = "MODULE m\nPROC main()\nMoveAbsJ [[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,\
                         9E9]],v100,fine,tool0;\nENDPROC\nENDMODULE\n";

    /// One speed for the whole program.
    fn to(rpm: f64, keeps_chip_load: bool) -> Rewrite {
        let whole = NewSpeed { end: usize::MAX, rpm, job_rpm: None };
        Rewrite { speeds: vec![whole], keeps_chip_load }
    }

    /// The reader sees the same moves, one spindle speed, and feeds that follow it.
    fn holds(text: &[u8], dialect: Dialect, expected: &[u8]) {
        let found = rewrite(text, dialect, &settings(), &to(1375.0, true)).unwrap();
        assert_eq!(String::from_utf8_lossy(&found.bytes), String::from_utf8_lossy(expected));
        let before = read(text, dialect, &settings()).unwrap();
        let after = read(&found.bytes, dialect, &settings()).unwrap();
        assert_eq!(before.moves.len(), after.moves.len());
        for (a, b) in before.moves.iter().zip(&after.moves) {
            assert_eq!((&a.to, a.line), (&b.to, b.line));
            let ratio = b.feed_m_per_s / a.feed_m_per_s;
            assert!(a.timing == Timing::Rapid || (ratio - 1.25).abs() < 1e-9, "{ratio}");
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
              Y5 f80 (F2) S0\r\nG4 P1.\r\nS1100\r\nX1\r\nM30\r\n",
            Dialect::GCode,
            b"(S900 F1 \xE4)\r\nN10 g0 X0 Y0 Z0 s 1375 M3 ; S1\r\nG1X10F500.\r\n\
              Y5 f100 (F2) S0\r\nG4 P1.\r\nS1375\r\nX1\r\nM30\r\n",
        );
        let per_revolution = b"S1000 M3\nG95 G1 X0 Y0 Z0 F0.2\nX1\nG94 F100\nX2\nM2\n";
        let found =
            rewrite(per_revolution, Dialect::GCode, &settings(), &to(1250.0, true)).unwrap();
        assert_eq!((found.speeds, found.feeds, found.feeds_per_revolution), (1, 1, 1));
        assert!(String::from_utf8(found.bytes).unwrap().contains("F0.2\nX1\nG94 F125\n"));
    }

    #[test]
    fn apt_keeps_all_but_speeds_and_feeds() {
        holds(
            b"PARTNO SPINDL/1\n$$ SPINDL/2\nspindl/ 1100 ,RPM,CLW\nFEDRAT/300,MMPM $$ F\n\
              GOTO/0,0,0\nGOTO/$\n1,0,0\nCYCLE/DRILL,DEPTH,5,MMPM,80,CLEAR,2\nGOTO/2,0,0\n\
              CYCLE/OFF\nSPINDL/OFF\nFINI\n",
            Dialect::Apt,
            b"PARTNO SPINDL/1\n$$ SPINDL/2\nspindl/ 1375 ,RPM,CLW\nFEDRAT/375,MMPM $$ F\n\
              GOTO/0,0,0\nGOTO/$\n1,0,0\nCYCLE/DRILL,DEPTH,5,MMPM,100,CLEAR,2\nGOTO/2,0,0\n\
              CYCLE/OFF\nSPINDL/OFF\nFINI\n",
        );
    }

    #[test]
    fn what_stays_keeps_its_bytes() {
        let same = to(1340.0, false);
        let text = b"S1100. M3\nG0 X0 Y0 Z0\nG1 X1 F0300.00\nM2\n";
        let found = rewrite(text, Dialect::GCode, &settings(), &same).unwrap();
        assert_eq!(found.bytes, b"S1340. M3\nG0 X0 Y0 Z0\nG1 X1 F0300.00\nM2\n");
    }

    #[test]
    fn pitches_are_not_lost() {
        let rewritten = |text: &str, dialect, keeps_chip_load| {
            rewrite(text.as_bytes(), dialect, &settings(), &to(1340.0, keeps_chip_load))
                .map_err(|why| why.what)
        };
        let tap = "S1000 M3\nG84 X0 Y0 Z-5 R1 F1000\nG80\nM2\n";
        let at = "G0 X0 Y0 Z5\n".to_owned() + tap;
        assert!(rewritten(&at, Dialect::GCode, false).unwrap_err().contains("pitch"));
        assert!(rewritten(&at, Dialect::GCode, true).is_ok());
        let tap = "SPINDL/1000\nCYCLE/TAP,DEPTH,5,MMPM,1000\nGOTO/0,0,0\nFINI\n";
        assert!(rewritten(tap, Dialect::Apt, false).unwrap_err().contains("pitch"));
    }

    /// Each stretch has its own speed; feeds follow the speed that the program ran at, and a feed
    /// that holds beyond a change of speed cannot follow two.
    #[test]
    fn each_stretch_has_its_own_speed_and_feed() {
        let rewritten = |text: &str| {
            let speed = |end, rpm| NewSpeed { end, rpm, job_rpm: None };
            let speeds = vec![speed(2, 1500.0), speed(4, 1000.0)];
            let to = Rewrite { speeds, keeps_chip_load: true };
            rewrite(text.as_bytes(), Dialect::GCode, &settings(), &to)
                .map(|out| String::from_utf8(out.bytes).unwrap())
                .map_err(|why| why.what)
        };
        assert_eq!(
            rewritten("S1000 M3\nG1 X0 Y0 Z0 F100\nX1\nM5\nF80\nS500 M3\nX2\nX3\nM30\n").unwrap(),
            "S1500 M3\nG1 X0 Y0 Z0 F150\nX1\nM5\nF160\nS1000 M3\nX2\nX3\nM30\n"
        );
        let modal = "S1000 M3\nG1 X0 Y0 Z0 F100\nX1\nS500\nX2\nX3\nM30\n";
        assert!(rewritten(modal).unwrap_err().contains("the feed of line 5"));
    }

    #[test]
    fn what_states_no_speed_is_not_rewritten() {
        let refused = |text: &str, dialect| {
            rewrite(text.as_bytes(), dialect, &settings(), &to(1340.0, true)).unwrap_err().what
        };
        assert!(refused(RAPID, Dialect::Rapid).contains("spindle_from"));
        assert!(
            refused("G1 X0 Y0 Z0 F100\nM2\n", Dialect::GCode).contains("states no spindle speed")
        );
        assert!(refused("GOTO/0,0,0\nFINI\n", Dialect::Apt).contains("states no spindle speed"));
    }
}
