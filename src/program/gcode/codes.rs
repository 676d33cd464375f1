//! A block of G-code → what the controller does, in the order that RS-274 gives.

use super::block::{BLOCK_FEED, Block, DIRECTION, LIMIT, OPENING, Word};
use super::flow::Flow;
use super::macro_call::macro_call;
use super::names::Name;
use super::state::{AXES, Machine, Motion};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::arc::Plane;
use crate::program::cutter::FeedKind;

/// Above all codes of work offsets: G54.1 P1 and on.
const NUMBERED: i64 = 10_000;

/// Above these: G15 H of Okuma's.
const OF_OKUMA: i64 = 1_000_000;

/// More than any control has.
const MOST_OFFSETS: f64 = 9999.0;

/// G80.
const CANCEL: i64 = 800;

/// Codes behind which some controllers take S for a limit.
const G92: i64 = 920;
const G50: i64 = 500;

/// Sinumerik's ways to the reference and the fixed point, rapid ones.
const REFERENCE: &str = "G74/G75";

/// Codes that hold for their block alone.
#[derive(Debug, Default)]
struct Once {
    dwell: bool,
    reference: bool,
    /// G53 and the like, as written.
    machine: Option<&'static str>,
    /// G10, G52, G68, G92: axis words set something.
    sets: Option<i64>,
    macro_call: bool,
    /// G110 to G112.
    pole: Option<i64>,
    /// G43.1 with axes.
    tool_length: bool,
}

/// Runs a block.
pub(super) fn run(machine: &mut Machine<'_>, flow: &mut Flow<'_>, line: usize, block: &Block) {
    if block.words.is_empty() && block.names.is_empty() {
        return;
    }
    machine.tell_unknown_before(block);
    // To G65 it is an argument, to Haas' G187 how much corners are rounded, to M66 an input.
    let is_argument = block.codes('G').any(|code| matches!(code, 650 | 1870))
        || block.codes('M').any(|code| code == 660);
    if block.word(b'E').is_some() && !is_argument {
        machine.cutter.log.warning(Code::AxisIgnored, line, "E words are left out");
    }
    let contradictions = contradictions(block);
    if !contradictions.is_empty() {
        for what in contradictions {
            machine.cutter.log.error(Code::Conflict, line, what);
        }
        return;
    }
    if let Err(what) = run_checked(machine, flow, line, block) {
        machine.cutter.log.error(Code::Motion, line, what);
    }
}

fn run_checked(
    machine: &mut Machine<'_>,
    flow: &mut Flow<'_>,
    line: usize,
    block: &Block,
) -> Result<(), String> {
    if machine.corner.is_some() && parts_lines(block) {
        machine.no_corner()?;
    }
    let mut once = Once::default();
    for (name, inside) in &block.names {
        match machine.name(line, name, inside, block, &flow.parameters)? {
            Name::None => {}
            Name::Machine => once.machine = Some("SUPA"),
            Name::Frame => return Ok(()),
            Name::Back => {
                flow.back();
            }
            Name::Call => return flow.call_file(name, inside, block.get('P').unwrap_or(1.0)),
        }
    }
    if let Some(number) = block.get('L').filter(|_| machine.is_sinumerik)
        && block.names.is_empty()
        && block.words.iter().all(|word| matches!(word.letter, b'N' | b'L' | b'P'))
    {
        return flow.call_file(&format!("L{number}"), "", block.get('P').unwrap_or(1.0));
    }
    let (inches, states_unit) = (machine.inches, machine.states_unit);
    let cancels_beside_motion =
        |code: &i64| *code == CANCEL && block.codes('G').any(|other| other < 40);
    for code in block.codes('G').filter(|code| !cancels_beside_motion(code)) {
        modal(machine, &mut once, line, code, block)?;
    }
    // Length 0 of Fanuc's and Haas' is none, with G43 and without it.
    if !machine.is_sinumerik && machine.length_in(block) == Some(0.0) {
        machine.end_compensation();
    }
    if let Some(feed) = block.word(b'F')
        && (!once.dwell || block.has_any(b"PXUS"))
        && !once.macro_call
    {
        // The first unit of a program is no change where nothing was fed before.
        if machine.inches != inches && (states_unit || machine.cutter.feed.value.is_some()) {
            return Err("F beside a change of units: controllers differ in what it means".into());
        }
        machine.set_feed(line, feed)?;
    }
    let modal = machine.held_feed();
    if let Some(feed) = block.word(BLOCK_FEED) {
        machine.set_feed(line, feed)?;
    }
    if once.macro_call {
        return macro_call(flow, block);
    }
    let done =
        spindle_and_tool(machine, &once, line, block).map(|()| moves(machine, &once, line, block));
    flow.parameters.diameter = machine.diameter();
    let done = done?;
    if block.word(BLOCK_FEED).is_some() {
        machine.hold_feed(modal);
    }
    done?;
    // MCALL's cycle runs behind every block that moves.
    let turns = block.has_any(&super::rotary::LETTERS);
    let is_arc = matches!(machine.motion, Motion::Arc { .. }) && block.has_any(b"IJK");
    if (block.has_place() || turns || is_arc)
        && once.sets.is_none()
        && once.pole.is_none()
        && !once.dwell
        && let Some(call) = machine.called.take()
    {
        let done = machine.drill_call(line, &call);
        machine.called = Some(call);
        done?;
    }
    // LinuxCNC stops the spindle before the motion of the block, Fanuc after it: taken to turn on
    // the way.
    if block.codes('M').any(|code| code == 50) {
        // A line that ends in a corner is not drawn yet.
        machine.no_corner()?;
        machine.cutter.turn_spindle(line, false);
    }
    flow_codes(machine, flow, line, block)
}

/// Whether a block changes something between the lines of a corner, which are drawn together.
fn parts_lines(block: &Block) -> bool {
    let starts = |code| matches!(code, 30 | 40 | 50 | 60 | 130 | 140);
    block.has_any(b"STHD")
        || block.has_any(&super::rotary::LETTERS)
        || block.has_any(&DIRECTION)
        || block.codes('G').any(|c| c == 40)
        || block.codes('M').any(starts)
}

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
    const GROUPS: [(char, IsOfGroup); 10] = [
        ('G', motion),
        ('G', |code| code == CANCEL || cycle(code)),
        ('G', |code| matches!(code, 40 | 280 | 300 | 530)),
        ('G', |code| matches!(code, 170 | 180 | 190)),
        ('G', |code| matches!(code, 200 | 210 | 700 | 710 | 7000 | 7100)),
        ('G', |code| matches!(code, 430 | 431 | 434 | 440 | 490)),
        ('G', |code| matches!(code, 900 | 910)),
        ('G', |code| matches!(code, 901 | 911)),
        ('G', |code| matches!(code, 930 | 940 | 950)),
        ('M', |code| matches!(code, 30 | 40 | 50 | 130 | 140)),
    ];
    let mut found = Vec::new();
    // Most blocks have no two codes.
    let codes = block.words.iter().filter(|word| matches!(word.letter, b'G' | b'M')).count();
    if codes < 2 {
        return found;
    }
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

/// A G code, in tenths.
fn modal(
    machine: &mut Machine<'_>,
    once: &mut Once,
    line: usize,
    code: i64,
    block: &Block,
) -> Result<(), String> {
    let has_axes = block.has_any(&AXES);
    match code {
        0 => machine.motion = Motion::Rapid,
        10 => machine.motion = Motion::Straight,
        20 => machine.motion = Motion::Arc { clockwise: true },
        30 => machine.motion = Motion::Arc { clockwise: false },
        40 => once.dwell = true,
        170 => machine.choose_plane(Plane::XY)?,
        180 => machine.choose_plane(Plane::ZX)?,
        190 => machine.choose_plane(Plane::YZ)?,
        1100 | 1110 | 1120 if machine.is_sinumerik => once.pole = Some(code),
        150 | 160 if has_offset_of_okuma(machine, block) => {
            okuma_offset(machine, line, code, block)?;
        }
        150 => machine.polar.is_on = false,
        160 if !machine.is_sinumerik => {
            machine.no_corner()?;
            machine.keeps_frame("G16")?;
            machine.begin_g16(line);
        }
        680 if !machine.is_sinumerik => once.sets = Some(code),
        690 => {
            machine.no_corner()?;
            machine.end_turn();
        }
        700 | 710 if machine.pattern_of(block).is_some() => {}
        200 | 210 | 7000 | 7100 => machine.set_unit(matches!(code, 200 | 7000), false),
        700 | 710 => machine.set_unit(code == 700, machine.is_sinumerik),
        280 | 300 => once.reference = true,
        // Its reference, and its fixed point.
        740 | 750 if machine.is_sinumerik => once.machine = Some(REFERENCE),
        410 | 420 => {
            let what = "G41/G42: the path is read as programmed";
            machine.cutter.log.warning(Code::Assumed, line, what);
        }
        650 => once.macro_call = true,
        G50 if has_axes => {
            return Err("G50 with axes sets or scales the place and is not supported".to_owned());
        }
        // Ends of what is not supported, tool length, path mode, start of feed modes.
        130 if block.has_any(b"IJK") => {
            return Err("G13 with words of a pocket is not supported".to_owned());
        }
        400 | 500 | 610 | 611 | 640 | 130 | 6010 | 6020 | 6410 | 6420 | 90 | 600 | 4500 | 4510 => {}
        430 | 440 => {
            machine.compensate();
            machine.follow_tip(false)?;
        }
        490 => {
            machine.end_compensation();
            machine.follow_tip(false)?;
        }
        // G97 of Sinumerik's is one of the kinds of feed, that of G95 with a fixed speed.
        970 if machine.is_sinumerik => {
            machine.is_g97 = true;
            machine.cutter.feed_kind(FeedKind::PerRevolution);
        }
        970 => {}
        960 | 9610 | 9620 => {
            let shown = shown('G', code);
            return Err(format!(
                "{shown} keeps the cutting speed, so that the spindle's speed follows the \
                 diameter: not supported; have G97 and a fixed speed written"
            ));
        }
        // Limits of travel, checked or not.
        220 | 230 if !machine.is_sinumerik && !has_axes && !block.has_any(b"IJK") => {}
        // GRBL and LinuxCNC: the axes are those of a tool's length.
        431 => {
            once.tool_length = has_axes && block.word(b'H').is_none();
            machine.compensate();
            machine.follow_tip(false)?;
        }
        // Look-ahead, smoothing and corners' speed.
        51 | 80 | 620 | 1030 | 1870 if !has_axes => {}
        50 if !has_axes && block.word(b'P').is_some() => {}
        434 if machine.rotary.is_named() => {
            machine.compensate();
            machine.follow_tip(true)?;
        }
        434 => return Err("G43.4 turns the tool: rotary_axes in the job must say how".to_owned()),
        530 => once.machine = Some("G53"),
        1530 => once.machine = Some("G153"),
        // Fanuc: G54 P is G54.1 P.
        540 | 541 | 1540 if code != 540 || gives_offset(machine, block) => {
            let offset = block.get('P').ok_or("G54.1 without P")?;
            machine.work_offset(line, NUMBERED + number_of_offset('P', offset)?)?;
        }
        580 | 590 if machine.is_sinumerik && has_axes => {
            let shown = shown('G', code);
            return Err(format!("{shown} with axes shifts the work and is not supported"));
        }
        540..=599 | 5000..=5990 => machine.work_offset(line, code)?,
        730 | 740 | 810..=869 | 890 => machine.start_cycle(code),
        CANCEL => machine.end_cycle(),
        900 => machine.relative = false,
        901 => machine.centre_absolute = true,
        910 => machine.relative = true,
        911 => machine.centre_absolute = false,
        930 | 940 | 950 => {
            machine.is_g97 = false;
            machine.cutter.feed_kind(match code {
                930 => FeedKind::InverseTime,
                940 => FeedKind::PerMinute,
                _ => FeedKind::PerRevolution,
            });
        }
        980 => machine.back_to_initial = true,
        990 => machine.back_to_initial = false,
        100 | 520 | 920 => once.sets = Some(code),
        921 | 922 => machine.end_g92(line, code == 922),
        923 => machine.shift.restore(),
        _ => {
            return Err(format!("{} is not understood; motion may be lost", shown('G', code)));
        }
    }
    Ok(())
}

/// Whether G54 has a P that is of no other code of the block.
fn gives_offset(machine: &Machine<'_>, block: &Block) -> bool {
    let of_g = |code| {
        let of_cycle = (730..=890).contains(&code) && code != CANCEL;
        of_cycle
            || matches!(code, 20 | 30 | 40 | 50 | 51 | 80 | 100 | 300 | 610..=650 | 1030 | 1870)
    };
    // From M100 on they are the machine builder's or the user's own.
    let of_m = |code| matches!(code, 190 | 620..=680 | 970 | 980 | 990) || code >= 1000;
    let is_own = block.word(b'P').is_some() && !machine.is_sinumerik;
    is_own && !(block.codes('G').any(of_g) || block.codes('M').any(of_m))
}

fn has_offset_of_okuma(machine: &Machine<'_>, block: &Block) -> bool {
    !machine.is_sinumerik && block.word(b'H').is_some() && !block.compensates()
}

/// G15 H and G16 H: on Okuma they choose a work coordinate system, G16 for its block alone.
fn okuma_offset(
    machine: &mut Machine<'_>,
    line: usize,
    code: i64,
    block: &Block,
) -> Result<(), String> {
    if code == 160 {
        return Err("G16 with H: on Okuma its block alone is in another work coordinate system, \
                    elsewhere polar coordinates begin: not supported; write G15 H before the \
                    block, or leave out the H"
            .to_owned());
    }
    machine.polar.is_on = false;
    let offset = number_of_offset('H', block.get('H').unwrap_or(0.0))?;
    machine.work_offset(line, OF_OKUMA + offset)
}

fn number_of_offset(letter: char, number: f64) -> Result<i64, String> {
    if !(0.0..=MOST_OFFSETS).contains(&number) || number.fract() != 0.0 {
        return Err(format!(
            "{letter}{number} is no work offset: expected a whole number up to {MOST_OFFSETS}"
        ));
    }
    // Whole and at most so much, checked above.
    Ok(number as i64)
}

pub(super) fn shown(letter: char, code: i64) -> String {
    match (code / 10, code % 10) {
        (code, 0) => format!("{letter}{code}"),
        (code, tenths) => format!("{letter}{code}.{tenths}"),
    }
}

/// S, T and M words.
fn spindle_and_tool(
    machine: &mut Machine<'_>,
    once: &Once,
    line: usize,
    block: &Block,
) -> Result<(), String> {
    // LinuxCNC: 0 is the main spindle, -1 are all.
    if let Some(spindle) = block.get('$').filter(|spindle| ![0.0, -1.0].contains(spindle)) {
        return Err(format!(
            "${spindle} commands another spindle than the main one ($0), which has the tool: not \
             supported"
        ));
    }
    // Alone beside G4 it is a time in turns of the spindle.
    let speed = block.word(b'S').filter(|_| !once.dwell || block.has_any(b"PXUF"));
    if speed.is_some() && (once.sets == Some(G92) || block.codes('G').any(|code| code == G50)) {
        return Err("S beside G92 or G50: controllers differ in whether it is the speed or its \
                    limit"
            .to_owned());
    }
    if let Some(Word { value, span, .. }) = speed {
        machine.cutter.state_speed(line, value, span)?;
    }
    machine.limit_rpm = block.word(LIMIT).map(|word| word.value).or(machine.limit_rpm);
    machine.tell_limit(line);
    if let Some(tool) = block.get('T') {
        machine.select_tool(tool)?;
    }
    if let Some(why) = &block.unset_length {
        let what = format!("H: {why}; the tcp stays the same");
        machine.cutter.log.warning(Code::ChangeIgnored, line, what);
    }
    // Whatever the order in the block.
    if block.codes('M').any(|code| code == 60) {
        machine.cutter.change();
    }
    let mut starts = false;
    for code in block.codes('M') {
        match code {
            // M13 and M14 turn on the coolant, too.
            30 | 40 | 130 | 140 => {
                starts = true;
                if machine.cutter.rpm.is_none() {
                    let what = "M3/M4 without S: the speed is not known yet";
                    machine.cutter.log.warning(Code::LeftOut, line, what);
                }
                machine.cutter.log.reverse(matches!(code, 40 | 140));
                machine.cutter.turn_spindle(line, true);
            }
            // Behind the block's motion, see `run_checked`.
            50 => {}
            1980 => return Err("M198 calls a program that is not read".to_owned()),
            60 => machine.change_tool()?,
            // LinuxCNC's; without Q it is what the machine's builder makes of it.
            610 => match block.get('Q').filter(|_| !machine.is_sinumerik) {
                Some(tool) => machine.state_tool(tool)?,
                None => starts |= machine.unknown(line, code, block, speed.is_some()),
            },
            // The spindle stands at an angle until it is started anew.
            190 => machine.cutter.turn_spindle(line, false),
            0 | 10 | 20 | 300 | 70..=99 | 170 | 480 | 490 | 600 | 970 | 980 | 990 => {}
            _ => starts |= machine.unknown(line, code, block, speed.is_some()),
        }
    }
    // Of the tool to which the block changes.
    machine.take_length(line, block)?;
    if speed.is_some() && !starts {
        machine.cutter.assume_started(line);
    }
    Ok(())
}

fn moves(machine: &mut Machine<'_>, once: &Once, line: usize, block: &Block) -> Result<(), String> {
    if let Some(code) = once.sets {
        return sets(machine, line, code, block);
    }
    if let Some(code) = once.pole {
        return machine.set_pole(code, block);
    }
    if once.dwell {
        return machine.dwell(line, block);
    }
    if once.tool_length {
        let what = "G43.1 sets the tool's length: the job's tcp is used";
        machine.cutter.log.warning(Code::ChangeIgnored, line, what);
        return Ok(());
    }
    let pattern = machine.pattern_of(block);
    if let Some(code) = pattern.filter(|_| !matches!(machine.motion, Motion::Cycle(_))) {
        let name = shown('G', code);
        return Err(format!(
            "{name} with L is a row of Haas' holes, and needs a drilling cycle (G73, G81 to G89) \
             that holds: write the cycle before it, with L0 where the centre has no hole"
        ));
    }
    let repeats = block.codes('M').any(|code| code == 970 || code == 980);
    // Q of M61, L and Q of M66, Q of M67 and M68.
    let has_words_of_m = block.codes('M').any(|code| matches!(code, 610 | 660 | 670 | 680));
    let is_call = block.word(b'L').is_some() && !repeats && !has_words_of_m;
    if is_call && block.names.iter().any(|(name, _)| name == "MCALL") {
        return Err("MCALL of a subprogram is not supported: call it at every place".to_owned());
    }
    if is_call && !matches!(machine.motion, Motion::Cycle(_)) {
        return Err("L calls a subprogram that is not read, or is not understood here".to_owned());
    }
    let has_axes = block.has_place() || block.has_any(&super::rotary::LETTERS);
    let in_cycle = matches!(machine.motion, Motion::Cycle(_));
    let has_cycle_words = in_cycle && !has_words_of_m && block.has_any(b"RQ");
    let of_arc = block.has_any(&[b'I', b'J', b'K', OPENING]);
    let full_turn = matches!(machine.motion, Motion::Arc { .. }) && of_arc;
    if once.reference {
        machine.no_corner()?;
        return machine.refer(line, block);
    }
    if let Some(how) = once.machine.filter(|_| has_axes) {
        machine.no_corner()?;
        machine.leave(line, block, how);
        // On LinuxCNC and Sinumerik the feed holds; to Fanuc and Haas G53 is rapid.
        if how != REFERENCE && !matches!(machine.motion, Motion::None | Motion::Rapid) {
            machine.cutter.cut_away(line, how);
        }
        return Ok(());
    }
    if !(has_axes || has_cycle_words || full_turn || pattern.is_some()) {
        let is_held = in_cycle && block.has_any(b"IJKL") && !(repeats || has_words_of_m);
        return if is_held {
            Err("I, J, K or L without an axis in a drilling cycle: controllers differ in whether \
                 it drills; write the axes, or G80 before it"
                .to_owned())
        } else {
            Ok(())
        };
    }
    if block.codes('G').any(|code| code == 600)
        && !machine.is_sinumerik
        && !matches!(machine.motion, Motion::None | Motion::Rapid)
    {
        return Err("G60 with axes at feed: on Fanuc it goes there at rapid from one side, \
                    elsewhere it stops at the end; write G0 or G9"
            .to_owned());
    }
    machine.tell_moved_zero(line, block);
    machine.tell_turned_place(line, block);
    machine.tell_moved_work();
    let done = match machine.motion {
        other if block.word(OPENING).is_some() && !matches!(other, Motion::Arc { .. }) => {
            Err("AR= is the opening angle of an arc: write G2 or G3".to_owned())
        }
        Motion::None => Err("axes without G0, G1, G2, G3 or a cycle".to_owned()),
        Motion::Rapid | Motion::Straight if block.has_any(b"RIJK") => {
            Err("R, I, J or K beside G0 or G1 is not supported: controllers differ in what it \
                 means"
                .to_owned())
        }
        Motion::Rapid => machine.straight(line, block, Pace::Rapid),
        Motion::Straight => {
            let pace = machine.cutter.pace()?;
            machine.straight(line, block, pace)
        }
        Motion::Arc { clockwise } => machine.arc(line, block, clockwise),
        Motion::Through => machine.arc_through(line, block),
        Motion::Tangent => machine.arc_tangent(line, block),
        Motion::Cycle(kind) => machine.drill(line, block, kind),
    };
    let is_cut = machine.motion != Motion::Rapid;
    if is_cut {
        machine.cuts(line);
    }
    let states_z = block.word(b'Z').is_some_and(|word| !machine.is_relative(word));
    machine.tell_length(line, is_cut, states_z);
    machine.watch_unit(line, block);
    if machine.cutter.feed.kind == FeedKind::InverseTime {
        machine.cutter.feed.value = None;
    }
    done
}

/// G10, G52, G68 and G92.
fn sets(machine: &mut Machine<'_>, line: usize, code: i64, block: &Block) -> Result<(), String> {
    let axes = AXES.map(|axis| block.word(axis).map(|word| machine.mm(word.value)));
    if code == 680 {
        machine.no_corner()?;
        return machine.turn_work(block);
    }
    machine.keeps_frame("a shift of the work")?;
    match (code, block.get('L')) {
        (920, _) | (100, Some(20.0)) => machine.rotary.count_anew(block, false)?,
        (520, _) | (100, Some(2.0)) => machine.rotary.count_anew(block, true)?,
        _ => {}
    }
    match code {
        520 => machine.shift.set_local(axes),
        920 => machine.stand_at(line, axes, false)?,
        _ => {
            let of = block.get('P').filter(|p| *p != 0.0);
            let offset =
                of.map(|p| if p <= 6.0 { 530 + (p * 10.0) as i64 } else { 590 + p as i64 - 6 });
            match block.get('L').map(|l| l as i64) {
                Some(2) if block.word(b'R').is_some() => {
                    return Err("G10 L2 with R turns the work and is not supported".to_owned());
                }
                Some(20) if offset.is_some_and(|of| of != machine.shift.active()) => {
                    return Err(
                        "G10 L20 of another offset than the one that holds is not supported".into(),
                    );
                }
                Some(2) => machine.shift.set_origin(offset, axes, machine.relative)?,
                Some(20) => machine.stand_at(line, axes, true)?,
                Some(kind @ (1 | 10 | 11 | 12 | 13)) => machine.set_tool_data(line, kind, block),
                _ => return Err("G10 is understood with L1, L2, L10 to L13 and L20 alone".into()),
            }
        }
    }
    if code != 100 && machine.shift.is_mixed() {
        let what = "G52 and G92 both shift: controllers differ in what one makes of the other";
        machine.cutter.log.warning(Code::ChangeIgnored, line, what);
    }
    Ok(())
}

/// M codes that end the program or call another.
fn flow_codes(
    machine: &mut Machine<'_>,
    flow: &mut Flow<'_>,
    line: usize,
    block: &Block,
) -> Result<(), String> {
    for code in block.codes('M') {
        match code {
            20 | 300 if machine.is_sinumerik && flow.is_called() => {
                flow.back();
                let what = "M2 or M30 in a subprogram that is called ends that alone, as M17, and \
                            the program goes on behind the call, as Sinumerik has it; write M17, \
                            or end the whole in the main program";
                machine.cutter.log.warning(Code::MotionLeftOut, line, what);
            }
            20 | 300 => flow.end(),
            170 if !machine.is_sinumerik => {
                let what = "M17 ends a subprogram of Sinumerik's; here it is left out";
                machine.cutter.left_out(line, what.to_owned());
            }
            990 | 170 => {
                let starts_again = match block.get('P').filter(|_| code == 990) {
                    Some(number) => flow.back_to(number)?,
                    None => flow.back() && code == 990,
                };
                if starts_again {
                    machine.tell_moved_work();
                    let what = "M99 runs the program again without end: it is read once";
                    machine.cutter.log.warning(Code::Assumed, line, what);
                }
            }
            980 => {
                let p = block.get('P').ok_or("M98 without P")?;
                if block.word(b'Q').is_some() {
                    return Err("M98 with Q begins within the subprogram: not supported".to_owned());
                }
                if block.word(b'K').is_some() {
                    return Err("M98 with K: controllers differ in what it counts".to_owned());
                }
                // Older controllers write the repeats before the four digits of the number.
                let (repeats, number) = match block.get('L') {
                    Some(repeats) => (repeats, p),
                    None if p > 9999.0 => ((p / 1e4).floor(), p % 1e4),
                    None => (1.0, p),
                };
                flow.call(number, repeats, None)?;
            }
            970 => {
                let number = block.get('P').ok_or("M97 without P")?;
                flow.call_line(number, block.get('L').unwrap_or(1.0))?;
            }
            _ => {}
        }
    }
    Ok(())
}
