//! G-code → motions, for three axes and a tool along z.
//!
//! Read: G0–G3 (centre and radius form, full turns, helices), G17–G19, G20/G21, G90/G91,
//! G90.1/G91.1, G94/G95, drilling by G73, G81–G86 and G89 with G98/G99, F, S, M3–M5, M2/M30. Every
//! work offset is the job's work object. Reported and left out: radius compensation (the path is
//! read as programmed), M codes that are not known. Errors: everything else that
//! moves, shifts or computes motion; two words of one letter or two codes of one modal group in a
//! block. Until X, Y and Z are all given the place is not known: the path starts where they are.
//! Reference and machine positions (G28, G30, G53) are not in the program, so behind them axes are
//! not known, either: a warning, and an error where motion follows.

mod arc;
mod block;
mod cycle;
mod state;

use super::log::Log;
use super::{Pace, Settings};
use crate::notes::Code;
use block::Block;
use state::{Feed, Motion, Reader};

/// Reads a G-code file into the log.
pub(super) fn read(text: &str, settings: &Settings, log: &mut Log) {
    let changes = |content: &str| {
        block::parse(content).is_ok_and(|block| block.codes('M').any(|code| code == 60))
    };
    let mut reader = Reader::new(settings, log, text.lines().any(changes));
    for (index, content) in text.lines().enumerate() {
        let line = index + 1;
        match block::parse(content) {
            Ok(block) => {
                if run(&mut reader, line, &block) {
                    break;
                }
            }
            Err(what) => reader.log.error(Code::Syntax, line, what),
        }
        if reader.log.is_full() {
            break;
        }
    }
}

/// Runs a block in the order that RS-274 gives; true at the end of the program.
fn run(reader: &mut Reader, line: usize, block: &Block) -> bool {
    if block.words.is_empty() {
        return false;
    }
    if block.optional {
        reader.log.warning(Code::Assumed, line, "blocks with '/' are read as if they ran");
    }
    if let Some((letter, _)) = block.words.iter().find(|(letter, number)| {
        matches!(letter, 'A' | 'B' | 'C' | 'U' | 'V' | 'W') && *number != 0.0
    }) {
        reader.log.error(
            Code::Motion,
            line,
            format!("axis {letter} is not supported: X, Y and Z alone"),
        );
    }
    if block.get('E').is_some() {
        reader.log.warning(Code::AxisIgnored, line, "E words are left out");
    }
    let contradictions = contradictions(block);
    if !contradictions.is_empty() {
        contradictions.into_iter().for_each(|what| reader.log.error(Code::Conflict, line, what));
        return false;
    }
    let cancels_beside_motion =
        |code: &i64| *code == CANCEL && block.codes('G').any(|other| other < 40);
    let mut once = Once::default();
    for code in block.codes('G').filter(|code| !cancels_beside_motion(code)) {
        if let Err(what) = modal(reader, &mut once, line, code) {
            reader.log.error(Code::Motion, line, what);
        }
    }
    if let Some(feed) = block.get('F')
        && !once.dwell
        && let Err(what) = reader.set_feed(feed)
    {
        reader.log.error(Code::Motion, line, what);
    }
    let ends = spindle_and_tool(reader, line, block);
    if let Err(what) = moves(reader, &once, line, block) {
        reader.log.error(Code::Motion, line, what);
    }
    // LinuxCNC stops the spindle before the motion of the block, Fanuc after it: taken to turn on
    // the way.
    if block.codes('M').any(|code| code == 50) {
        reader.turn_spindle(line, false);
    }
    ends
}

/// G80.
const CANCEL: i64 = 800;

/// Codes of which a block may hold one, in tenths, by letter: those that change what is read here.
/// Cycles and G80 are one group with G0–G3 to LinuxCNC and another to Fanuc, where posts write G80
/// beside G0.
fn contradictions(block: &Block) -> Vec<String> {
    fn motion(code: i64) -> bool {
        matches!(code, 0 | 10 | 20 | 30) || cycle(code)
    }
    fn cycle(code: i64) -> bool {
        matches!(code, 730 | 740 | 810..=890)
    }
    type IsOfGroup = fn(i64) -> bool;
    const GROUPS: [(char, IsOfGroup); 9] = [
        ('G', motion),
        ('G', |code| code == CANCEL || cycle(code)),
        ('G', |code| matches!(code, 40 | 280 | 300 | 530)),
        ('G', |code| matches!(code, 170 | 180 | 190)),
        ('G', |code| matches!(code, 200 | 210)),
        ('G', |code| matches!(code, 900 | 910)),
        ('G', |code| matches!(code, 901 | 911)),
        ('G', |code| matches!(code, 930 | 940 | 950)),
        ('M', |code| matches!(code, 30 | 40 | 50 | 130 | 140)),
    ];
    let mut found = Vec::new();
    for (letter, is_of_group) in GROUPS {
        let mut codes: Vec<i64> = block.codes(letter).filter(|&code| is_of_group(code)).collect();
        codes.sort_unstable();
        codes.dedup();
        if let [first, second, ..] = codes.as_slice() {
            let [first, second] = [first, second].map(|&code| shown(letter, code));
            let what =
                format!("{first} and {second} in one block: which of them applies is not clear");
            if !found.contains(&what) {
                found.push(what);
            }
        }
    }
    found
}

/// Codes that hold for their block alone.
#[derive(Debug, Default)]
struct Once {
    dwell: bool,
    reference: bool,
    machine: bool,
}

/// A G code, in tenths.
fn modal(reader: &mut Reader, once: &mut Once, line: usize, code: i64) -> Result<(), String> {
    match code {
        0 => reader.motion = Motion::Rapid,
        10 => reader.motion = Motion::Straight,
        20 => reader.motion = Motion::Arc { clockwise: true },
        30 => reader.motion = Motion::Arc { clockwise: false },
        40 => once.dwell = true,
        170 => reader.plane = arc::Plane::XY,
        180 => reader.plane = arc::Plane::ZX,
        190 => reader.plane = arc::Plane::YZ,
        200 => reader.inches = true,
        210 => reader.inches = false,
        280 | 300 => once.reference = true,
        410 | 420 => {
            reader.log.warning(Code::Assumed, line, "G41/G42: the path is read as programmed")
        }
        // Ends of what is not supported, tool length, path mode, start of feed modes.
        400 | 430 | 431 | 440 | 490 | 500 | 690 | 610 | 611 | 640 | 150 | 130 | 970 | 921 => {}
        530 => once.machine = true,
        540..=599 => reader.work_offset(line, code),
        730 | 810..=869 | 890 => reader.start_cycle(code),
        740 => reader.start_cycle(code),
        CANCEL => reader.motion = Motion::None,
        900 => reader.relative = false,
        901 => reader.centre_absolute = true,
        910 => reader.relative = true,
        911 => reader.centre_absolute = false,
        930 => reader.feed = Feed::InverseTime,
        940 => reader.feed_per_rev(false),
        950 => reader.feed_per_rev(true),
        980 => reader.back_to_initial = true,
        990 => reader.back_to_initial = false,
        920 | 520 | 100 => {
            return Err(format!("{}: shifted axes are not supported", shown('G', code)));
        }
        _ => {
            return Err(format!("{} is not understood; motion may be lost", shown('G', code)));
        }
    }
    Ok(())
}

fn shown(letter: char, code: i64) -> String {
    match (code / 10, code % 10) {
        (code, 0) => format!("{letter}{code}"),
        (code, tenths) => format!("{letter}{code}.{tenths}"),
    }
}

/// S, T and M words; true at the end of the program.
fn spindle_and_tool(reader: &mut Reader, line: usize, block: &Block) -> bool {
    if let Some(rpm) = block.get('S') {
        if rpm >= 0.0 {
            reader.set_spindle(line, rpm);
        } else {
            reader.log.error(Code::Value, line, format!("S is {rpm}, must not be negative"));
        }
    }
    if let Some(tool) = block.get('T')
        && let Err(what) = reader.select_tool(tool)
    {
        reader.log.error(Code::Value, line, what);
    }
    let mut ends = false;
    for code in block.codes('M') {
        match code {
            20 | 300 => ends = true,
            // M13 and M14 turn on the coolant, too.
            30 | 40 | 130 | 140 => reader.turn_spindle(line, true),
            // Behind the block's motion, see `run`.
            50 => {}
            60 => reader.change_tool(),
            970 | 980 | 990 => {
                reader.log.error(
                    Code::Motion,
                    line,
                    format!("M{}: subprograms are not supported", code / 10),
                );
            }
            0 | 10 | 70..=99 | 190 | 480 | 490 | 600 => {}
            _ => {
                let code = code as f64 / 10.0;
                reader.log.warning(
                    Code::LeftOut,
                    line,
                    format!("M{code} is not understood and left out"),
                );
            }
        }
    }
    ends
}

fn moves(reader: &mut Reader, once: &Once, line: usize, block: &Block) -> Result<(), String> {
    let has_axes = ['X', 'Y', 'Z'].iter().any(|&axis| block.get(axis).is_some());
    let in_cycle = matches!(reader.motion, Motion::Cycle(_));
    let has_cycle_words = in_cycle && ['R', 'Q'].iter().any(|&word| block.get(word).is_some());
    let full_turn = matches!(reader.motion, Motion::Arc { .. })
        && ['I', 'J', 'K'].iter().any(|&word| block.get(word).is_some());
    if once.reference {
        return reader.refer(line, block);
    }
    if once.machine && has_axes {
        reader.leave(line, block, "G53");
        return Ok(());
    }
    if once.dwell || !(has_axes || has_cycle_words || full_turn) {
        return Ok(());
    }
    match reader.motion {
        Motion::None => Err("axes without G0, G1, G2, G3 or a cycle".to_owned()),
        Motion::Rapid => reader.straight(line, block, Pace::Rapid),
        Motion::Straight => {
            let pace = reader.pace()?;
            reader.straight(line, block, pace)
        }
        Motion::Arc { clockwise } => reader.arc(line, block, clockwise),
        Motion::Cycle(kind) => reader.drill(line, block, kind),
    }
}
