//! Statements of TP programs in the order in which the controller would run them.

use std::collections::{BTreeMap, HashMap, HashSet};

use nalgebra::Isometry3;

use super::expressions::without_name;
use super::position::{OffsetCondition, places_by_job};
use super::programs::Programs;
use super::registers::{Asked, IS_PULSED, Registers, State};
use super::text::{Source, Statement, is_dashed_remark, is_motion, is_remark};
use super::words::{brackets, is_of_arm, nameless, split_outside, starts_with};
use crate::notes::Code;
use crate::program::cell::{External, Given, all, set_by_comment, set_by_name};
use crate::program::log::Log;
use crate::program::spindle_names::{Analog, is_spindles};
use crate::program::unread::behind_end;
use crate::program::{Setter, Settings};

/// Statements that loops may run beyond one pass through the program.
const STATEMENTS_IN_LOOPS: usize = 1_000_000;

/// What stands behind a motion where its logic is listed behind it, up to a line of dashes.
const POINT_LOGIC: [&str; 2] = ["P-SPS", "POINT_LOGIC"];

/// Ends why something is not known where a line before it has an error: to tell of that, too, would
/// tell of one fault twice.
pub(super) const BEHIND_ERROR: &str = "behind a line that is not read";

/// How statements begin that neither move nor change anything that is read here.
const HARMLESS: [&str; 44] = [
    "DO[",
    "RO[",
    "GO[",
    "AO[",
    "SO[",
    "UO[",
    "F[",
    "M[",
    "SR[",
    "SSR[",
    "TIMER[",
    "MESSAGE[",
    "UALM[",
    "WAIT",
    "PULSE",
    "Arc Start",
    "Arc End",
    "Weave",
    "Weld Start",
    "Weld End",
    "COL ",
    "LOCK PREG",
    "UNLOCK PREG",
    "PAUSE",
    "RSR",
    "DEFAULT",
    "COMMENT",
    "STRLEN",
    "RESUME_PROG",
    "RETURN_PATH",
    "DIAG",
    "Track",
    "STOP_TRACKING",
    "ERROR_PROG",
    "GUNMOTN",
    // Counts on moves with Skip alone, which are not read.
    "SKIP CONDITION",
    "VISION RUN_FIND",
    "Spray",
    "Dispense",
    "TC_ONLINE",
    "Sensor",
    "USER_ALARM",
    "SOFTFLOAT",
    "FOLLOW UP",
];

/// Macros of HandlingTool as it is delivered, on the outputs of a gripper: `Close hand 1`.
const HANDS: [&str; 3] = ["OPEN HAND", "CLOSE HAND", "RELAX HAND"];

/// Parts of the names of system variables that motion depends on.
const SYSTEM: [&str; 8] =
    ["UFRAME", "UTOOL", "OVERRIDE", "OVRD", "SPEED", "MAXVEL", "JNTVEL", "$ACCEL"];

/// Parts of the names of others that may change how the arm moves.
const OF_MOTION: [&str; 5] = ["_GRP", "GROUP", "$SCR.", "$MCR", "$CPCFG"];

/// Flags, markers and outputs: what the program sets them to, it may ask for.
pub(super) const SIGNALS: [&str; 8] = ["F[", "M[", "DO[", "RO[", "GO[", "AO[", "SO[", "UO["];

/// How statements begin that move, shift or search.
const MOVES: [&str; 8] =
    ["VOFFSET", "SEARCH", "TOUCH", "Touch", "Search", "CALIB", "INDEPENDENT", "SIMUL"];

pub(super) struct Run<'a> {
    pub(super) programs: &'a Programs,
    /// The program that runs.
    pub(super) source: &'a Source,
    /// The line of the file that is checked which leads to it, where it is of another file.
    pub(super) called_at: Option<usize>,
    /// How many calls lead to it.
    pub(super) depth: usize,
    /// Programs that have been called.
    pub(super) examined: HashSet<usize>,
    /// Whether ABORT or an error has ended all.
    pub(super) is_over: bool,
    pub(super) settings: &'a Settings,
    pub(super) log: &'a mut Log,
    pub(super) registers: Registers<'a>,
    /// `None` where the program has not said.
    pub(super) frame: Option<u32>,
    pub(super) tool: Option<u32>,
    /// Frames that the program has set, by list, `UFRAME` or `UTOOL`, and number.
    /// What they are, or why that is not known.
    pub(super) frames: HashMap<(&'static str, u32), Result<Isometry3<f64>, String>>,
    /// Who else may have chosen the frame and the tool since the program has.
    pub(super) chosen_by: [Option<String>; 2],
    /// The payload schedule that holds.
    payload: Option<u32>,
    /// CONFIG of the position before: letters of wrist, elbow and shoulder.
    pub(super) config: Option<String>,
    /// OVERRIDE as a share, or why it is not known.
    pub(super) over: Result<f64, String>,
    /// The line of LINEAR_MAX_SPEED and its value, mm/s, where that is known.
    pub(super) limit: Option<(usize, Option<f64>)>,
    /// The line of JOINT_MAX_SPEED.
    pub(super) joint_limit: Option<usize>,
    /// Of OFFSET CONDITION under UFRAME, of TOOL_OFFSET CONDITION under UTOOL.
    pub(super) offsets: HashMap<&'static str, OffsetCondition>,
    pub(super) external: External,
    /// Frame and tool of the last target that has a number of its own.
    pub(super) of_target: [Option<u32>; 2],
    /// Where targets have placed the external axes, mm or degrees.
    pub(super) axes: BTreeMap<String, f64>,
    /// Why it is not known where the arm stands, unless at the target of the last move.
    pub(super) stands: Result<(), String>,
    /// The joints of the last target, where it is one, degrees.
    pub(super) joints: Option<[f64; 6]>,
    /// The line that goes straight to a place that the program does not give, and its register:
    /// only behind all other motion is the rest of the path whole without it.
    pub(super) unknown_end: Option<(usize, String)>,
    /// Registers in which the program goes to places that it does not give, with the first line
    /// of each.
    pub(super) skipped: Vec<(usize, String)>,
    pub(super) next: usize,
    pub(super) budget: usize,
    /// Labels that have run, with what was known there last.
    pub(super) passed: HashMap<usize, State>,
    /// By label and jump: what conditions between ask for; `None` where nothing leads out.
    pub(super) asked: HashMap<[usize; 2], Option<Vec<Asked>>>,
    /// FOR loops: statement, register, last value, step.
    pub(super) loops: Vec<(usize, i64, f64, f64)>,
    /// Whether a branch had an error: from there on, loops are read no more.
    pub(super) is_lost: bool,
    /// Registers that the program gives to what the job reads the spindle or the tool from.
    pub(super) given_on: HashSet<i64>,
    pub(super) analog: Analog,
}

impl<'a> Run<'a> {
    pub(super) fn new(programs: &'a Programs, settings: &'a Settings, log: &'a mut Log) -> Self {
        let count: usize = programs.all().map(|source| source.statements.len()).sum();
        Self {
            programs,
            source: programs.main(),
            called_at: None,
            depth: 0,
            examined: HashSet::new(),
            is_over: false,
            settings,
            log,
            registers: Registers::new(settings),
            frame: None,
            tool: None,
            frames: HashMap::new(),
            chosen_by: [None, None],
            payload: None,
            config: None,
            over: Ok(1.0),
            limit: None,
            joint_limit: None,
            offsets: HashMap::new(),
            external: External::new(settings),
            of_target: [None; 2],
            axes: BTreeMap::new(),
            stands: Err("before the first move is known only at run time".to_owned()),
            joints: None,
            unknown_end: None,
            skipped: Vec::new(),
            next: 0,
            budget: count.saturating_mul(2).saturating_add(STATEMENTS_IN_LOOPS),
            passed: HashMap::new(),
            asked: HashMap::new(),
            loops: Vec::new(),
            is_lost: false,
            given_on: HashSet::new(),
            analog: Analog::default(),
        }
    }

    pub(super) fn run(mut self) {
        self.statements();
        // Of the same listing, and perhaps meant.
        let is_left = |own: &&Source| {
            own.index > 0 && own.file.is_none() && !self.examined.contains(&own.index)
        };
        let moves = |own: &&Statement| is_motion(own.text.trim());
        let left = self.programs.all().filter(is_left);
        if let Some(first) = left.flat_map(|source| &source.statements).find(moves) {
            behind_end(self.log, first.line);
        }
        // The path is made of places that the program does not give.
        if let (false, false, Some((line, name))) =
            (self.log.has_moved(), self.log.has_errors(), self.skipped.first())
        {
            let names: Vec<&str> = self.skipped.iter().map(|(_, name)| &**name).collect();
            let what = format!(
                "the program contains no motion that is read: it moves to {}, which it does not \
                 set; {}",
                names.join(", "),
                places_by_job(name)
            );
            self.log.error(Code::Motion, *line, what);
        }
    }

    /// The line of the file that is checked which a statement counts as.
    pub(super) fn line_of(&self, statement: &Statement) -> usize {
        self.called_at.unwrap_or(statement.line)
    }

    pub(super) fn statements(&mut self) {
        while let Some(statement) = self.source.statements.get(self.next) {
            if self.is_over || self.log.is_full() {
                return;
            }
            let file = self.source.file.as_ref();
            self.log
                .within(file.map_or_else(String::new, |it| format!("{it}:{}: ", statement.line)));
            if self.budget == 0 {
                self.log.runs_too_long(self.line_of(statement));
                self.is_over = true;
                return;
            }
            self.budget -= 1;
            self.next += 1;
            let found = self.statement(statement);
            self.tell_served_twice(statement);
            match found {
                Ok(true) => return self.doubt_behind(statement),
                Ok(false) => {}
                Err(why) => {
                    let decides = ["IF", "SELECT", "JMP"];
                    let text = statement.text.trim();
                    let is_branch = decides.iter().any(|own| starts_with(text, own));
                    self.is_lost |= is_branch;
                    // Where nothing moves, a branch decides about nothing.
                    let moves = |own: &Statement| is_motion(own.text.trim());
                    let mut all = self.programs.all().flat_map(|source| &source.statements);
                    let is_idle = is_branch && !all.any(moves);
                    if !(is_idle || self.log.has_errors() && why.contains(BEHIND_ERROR)) {
                        self.log.error(Code::Motion, self.line_of(statement), why);
                    }
                }
            }
        }
    }

    /// True at the end of the program.
    fn statement(&mut self, statement: &'a Statement) -> Result<bool, String> {
        let text = statement.text.trim();
        let line = self.line_of(statement);
        if let Some(comment) = text.strip_prefix('!') {
            let at = |part: &str| part.as_ptr() as usize - statement.text.as_ptr() as usize;
            let span = |digits: &str| statement.span(at(digits), at(digits) + digits.len());
            set_by_comment(self.settings, self.log, line, comment, span);
            return Ok(false);
        }
        if is_remark(text) {
            return Ok(false);
        }
        if is_motion(text) {
            self.motion(statement)?;
            return Ok(false);
        }
        let keyword = text.split([' ', '[', '(', '=', ',']).next().unwrap_or("");
        match keyword {
            "END" | "ABORT" => {
                self.is_over = keyword == "ABORT";
                return Ok(true);
            }
            // Of another group, which the arm is not of.
            "UFRAME_NUM" | "UTOOL_NUM" if !is_of_arm(text, keyword)? => {}
            "UFRAME_NUM" => {
                (self.frame, self.chosen_by[0]) = (None, None);
                self.frame = Some(self.number_behind(text)?);
            }
            "UTOOL_NUM" => {
                (self.tool, self.chosen_by[1]) = (None, None);
                self.tool = Some(self.number_behind(text)?);
            }
            "OVERRIDE" => self.set_override(line, text)?,
            "R" => self.assign(line, text, statement)?,
            "PR" => self.assign_position(line, text)?,
            "AR" => {}
            "LBL" => drop(self.passed.insert(self.next - 1, self.registers.state())),
            "JMP" => {
                self.doubt_behind(statement);
                self.jump(text, line)?;
            }
            _ if keyword.eq_ignore_ascii_case("CALL") => self.call(text, statement),
            "RUN" => self.run_beside(text, line),
            "MONITOR" => self.monitor(line, text),
            _ if text.starts_with('$') => self.system_variable(text, line)?,
            "IF" => self.condition(statement)?,
            "ELSE" => self.next = self.behind("ENDIF", &["IF"])?,
            "ENDIF" => {}
            "SELECT" => self.select(statement)?,
            "FOR" => self.for_loop(text)?,
            "ENDFOR" => self.end_for()?,
            "WAIT" => self.wait(text, line),
            "PULSE" => self.pulse(line, text),
            "UFRAME" => self.set_frame(line, "UFRAME", text)?,
            "UTOOL" => self.set_frame(line, "UTOOL", text)?,
            "PAYLOAD" => self.set_payload(text, line)?,
            "OFFSET" | "TOOL_OFFSET" => self.set_offset(text)?,
            "LINEAR_MAX_SPEED" => self.limit = Some((line, self.linear_limit(text))),
            "JOINT_MAX_SPEED" => self.joint_limit = Some(line),
            _ if MOVES.iter().any(|start| text.starts_with(start)) => {
                return Err(format!("'{keyword}' moves or shifts motion and is not supported"));
            }
            _ if drives_hand(text) => self.drive_hand(line, text),
            "VISION" if !is_harmless(text) => self.vision(text)?,
            _ => {
                self.bends_path(line, text);
                if !self.set_signal(text, statement) && !is_harmless(text) {
                    return Err(format!(
                        "'{text}' is not understood; if it is a macro, write CALL with the program \
                         that it runs"
                    ));
                }
            }
        }
        Ok(false)
    }

    fn number_behind(&self, text: &str) -> Result<u32, String> {
        let (name, value) = text.split_once('=').ok_or("expected '='")?;
        let value = self.registers.value(value)?;
        crate::program::tool_number(value).map_err(|_| format!("{} is {value}", name.trim()))
    }

    /// `PAYLOAD[2]`: the masses are on the controller; where the number changes, so does the load.
    fn set_payload(&mut self, text: &str, line: usize) -> Result<(), String> {
        let found = self.registers.numbered(text, "PAYLOAD")?;
        let (number, _) = found.ok_or("PAYLOAD without a number")?;
        let number = u32::try_from(number).map_err(|_| format!("PAYLOAD[{number}]"))?;
        let is_first = self.payload.is_none() && !self.log.has_moved();
        if !is_first && self.payload != Some(number) {
            let what = format!(
                "PAYLOAD[{number}]: what the arm carries changes, and the job's payload is used \
                 throughout"
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
        self.payload = Some(number);
        Ok(())
    }

    /// Keeps what an output or a flag is set to; whether the job says that it sets something.
    pub(super) fn set_signal(&mut self, text: &str, statement: &Statement) -> bool {
        let Some((name, value)) = assignment(text) else { return false };
        let line = self.line_of(statement);
        let mut given = self.given(value, statement);
        if let Ok(is_on) = self.registers.truth(value) {
            given.value = Ok(f64::from(u8::from(is_on)));
        } else if starts_with(value.trim(), "PULSE") {
            given.value = Err(IS_PULSED.to_owned());
        }
        // An analog output counts, unless the program itself writes a fraction.
        let writes_fraction = value.trim().parse::<f64>().is_ok() && value.contains('.');
        given.whole = starts_with(name, "GO[") || starts_with(name, "AO[") && !writes_fraction;
        let sets = set_by_name(self.settings, self.log, line, &signal_key(name), given);
        if is_signal(name) {
            if !sets {
                self.doubt_signal(line, name, value);
            }
            if starts_with(name, "AO[") {
                let value = self.registers.value(value).ok();
                self.analog.set(self.settings, self.log, line, &signal_key(name), value);
            }
            self.registers.set_signal(name, value);
        }
        sets
    }

    /// `Weave Sine[1]`, `Track TAST[2]`: from here on the tool leaves the path that is programmed.
    pub(super) fn bends_path(&mut self, line: usize, text: &str) {
        let mut words = text.split_whitespace();
        let first = words.next().unwrap_or("").to_ascii_uppercase();
        let next = words.next().unwrap_or("").to_ascii_uppercase();
        let ends = ["END", "OFF"].iter().any(|word| next.starts_with(word));
        if matches!(first.as_str(), "WEAVE" | "TRACK" | "SENSOR") && !ends {
            let what = format!(
                "'{}' moves the tool beside the programmed path, which is not read",
                text.trim()
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        let is_end = first == "SOFTFLOAT" && next.starts_with("END");
        if first.starts_with("SOFTFLOAT") && !is_end {
            let what = format!(
                "'{}' softens the servos: the arm gives way to forces, and leaves the programmed \
                 path by what is not read",
                text.trim()
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// `MONITOR CHECK` arms a condition program, `MONITOR END CHECK` ends it.
    fn monitor(&mut self, line: usize, text: &str) {
        let name = text.get(7..).unwrap_or("").trim();
        if name.split_whitespace().next() != Some("END") {
            let what = format!(
                "MONITOR {name}: what its conditions do from here on, at any time, is not read"
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// `$WAITTMOUT=200`: most say nothing of motion.
    pub(super) fn system_variable(&mut self, text: &str, line: usize) -> Result<(), String> {
        let name = text.split('=').next().unwrap_or(text).trim();
        let upper = name.to_ascii_uppercase();
        if upper == "$MCR.$GENOVERRIDE" {
            return self.set_override(line, text);
        }
        // How long a WAIT with TIMEOUT waits.
        if upper.ends_with("$WAITTMOUT") {
            return Ok(());
        }
        if SYSTEM.iter().any(|part| upper.contains(part)) {
            return Err(format!("{name} changes frame, tool or speed and is not supported"));
        }
        let (code, why) = if upper.contains("PAYLOAD") {
            let why = "what the arm carries changes, and the job's payload is used throughout";
            (Code::ChangeIgnored, why)
        } else if OF_MOTION.iter().any(|part| upper.contains(part)) {
            (Code::ChangeIgnored, "the variable may change how the arm moves, and is not read")
        } else {
            (Code::LeftOut, "the variable is not read: by its name it says nothing of motion")
        };
        self.log.warning(code, line, format!("{name}: {why}"));
        Ok(())
    }

    /// What is not known is an error where a move follows.
    fn set_override(&mut self, line: usize, text: &str) -> Result<(), String> {
        let value = text.split_once('=').map_or("", |(_, value)| value);
        let percent = match self.registers.value(value.trim().trim_end_matches('%')) {
            Ok(percent) => percent,
            Err(why) => {
                self.over = Err(format!("OVERRIDE of line {line}: {why}"));
                return Ok(());
            }
        };
        if !(percent > 0.0 && percent <= 100.0) {
            return Err(format!("OVERRIDE is {percent} %, must be 1 to 100"));
        }
        self.over = Ok(crate::units::ratio_from_percent(percent));
        Ok(())
    }

    /// `LINEAR_MAX_SPEED=2000`, mm/s; `None` where only the run knows it.
    fn linear_limit(&self, text: &str) -> Option<f64> {
        let (_, value) = text.split_once('=')?;
        self.registers.value(value).ok().filter(|value| *value > 0.0)
    }

    /// `R[1:name]=R[2]+1`.
    pub(super) fn assign(
        &mut self,
        line: usize,
        text: &str,
        statement: &Statement,
    ) -> Result<(), String> {
        let found = self.registers.numbered(text, "R")?;
        let (number, rest) = found.ok_or("R[ without a number")?;
        let value_text = rest.trim_start().strip_prefix('=').ok_or("expected '='")?;
        if let Some(part) = nameless(value_text) {
            self.registers.set_unread(number, BEHIND_ERROR);
            return Err(without_name(part));
        }
        let given = self.given(value_text, statement);
        let name = format!("r[{number}]");
        if !set_by_name(self.settings, self.log, line, &name, given.clone()) {
            self.doubt_register(line, number, text);
        }
        let value = self.registers.value(value_text);
        self.registers.set_from(number, value, given.span);
        Ok(())
    }

    /// The value of a part of a statement, and its place if it is a number.
    pub(super) fn given(&self, part: &str, statement: &Statement) -> Given {
        let own = part.trim();
        let at = own.as_ptr() as usize - statement.text.as_ptr() as usize;
        let span = own.parse::<f64>().ok().and_then(|_| statement.span(at, at + own.len()));
        let span = span.or_else(|| self.registers.place(own));
        Given::any(self.registers.value(part).map_err(String::from), span)
    }

    /// `DO[1]=PULSE,0.5sec` sets an output as `PULSE DO[1]` does: at its end it is what it was, or
    /// not.
    pub(super) fn pulse(&mut self, line: usize, text: &str) {
        let name = text.get(5..).unwrap_or("").trim();
        let end = name.find(']').map_or(name.len(), |at| at + 1);
        let name = name.get(..end).unwrap_or(name);
        self.registers.forget_signal(name, IS_PULSED.into());
        self.doubt_signal(line, name, "");
    }

    /// Which outputs a hand has is the cell's matter.
    pub(super) fn drive_hand(&mut self, line: usize, text: &str) {
        let what = "hands are taken to open and close by outputs alone, as the macros of \
                    HandlingTool do; if a macro of the cell runs a program that moves, write CALL \
                    with that program";
        self.log.warning(Code::Assumed, line, what);
        self.registers.lose_outputs(&format!("'{text}' of line {line} may set it"));
    }

    /// Whether an assignment sets a register or a signal; then that is known no longer.
    pub(super) fn forget_assigned(&mut self, line: usize, text: &str, why: &str) -> bool {
        if starts_with(text, "PR[") {
            return self.forget_position(text, why);
        }
        let Some((name, value)) = assignment(text) else { return false };
        let Ok(found) = self.registers.numbered(text, "R") else { return false };
        let number = found.map(|(number, _)| number);
        let key = match number {
            Some(number) => {
                self.registers.set(number, Err(why.into()));
                format!("r[{number}]")
            }
            None if is_signal(name) => {
                if starts_with(name, "AO[") {
                    let value = self.registers.value(value).ok();
                    let key = signal_key(name);
                    self.analog.set(self.settings, self.log, line, &key, value);
                }
                self.registers.forget_signal(name, why.into());
                signal_key(name)
            }
            None => return false,
        };
        let given = Given::any(Err(why.to_owned()), None);
        match (set_by_name(self.settings, self.log, line, &key, given), number) {
            (true, _) => {}
            (false, Some(number)) => self.doubt_register(line, number, text),
            (false, None) => self.doubt_signal(line, name, value),
        }
        true
    }

    /// Whether the logic of a point, listed behind it, changes nothing about its motion, which it
    /// comes a little before the end of.
    fn is_quiet_logic(&self) -> bool {
        let rest = self.source.statements.iter().skip(self.next);
        let texts: Vec<&str> = rest.map(|own| own.text.trim()).collect();
        let Some(end) = texts.iter().position(|text| text.starts_with("---")) else { return false };
        texts.iter().take(end).all(|text| {
            let set = assignment(text).filter(|_| starts_with(text, "R[") || is_signal(text));
            match set {
                Some((name, _)) => !is_spindles(name) && !self.is_setter(&signal_key(name)),
                None => is_remark(text) && !self.sets_by_comment(text) || is_harmless(text),
            }
        })
    }

    /// Whether the job reads the spindle or the tool from a name or a program.
    pub(super) fn is_setter(&self, name: &str) -> bool {
        all(self.settings).any(|(_, by)| match &by.what {
            Setter::Signal(own) | Setter::Procedure(own, _) => own.eq_ignore_ascii_case(name),
            Setter::Comment(_) => false,
        })
    }

    /// What stands behind a motion: what it sets, at a time or a place near the target, is known
    /// no longer.
    pub(super) fn act(&mut self, statement: &Statement, action: &str) {
        let line = self.line_of(statement);
        let Some((_, done)) = split_outside(action, ",") else { return };
        let done = done.trim();
        if starts_with(done, "CALL") {
            self.call_beside(done, statement);
        } else if POINT_LOGIC.contains(&done) && self.is_quiet_logic() {
            // Its statements stand behind the motion and are read there.
        } else if !self.forget_assigned(line, done, "it is set beside a motion") {
            let what = format!("'{done}' beside a motion: if it moves, its motion is not read");
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }
}

/// Why it is not known where the arm stands.
pub(super) fn unstopped(behind: &str) -> String {
    format!("behind {behind} is known only at run time")
}

fn is_signal(name: &str) -> bool {
    SIGNALS.iter().any(|start| name.starts_with(start))
}

/// Whether a statement neither moves nor changes anything that is read here.
pub(super) fn is_harmless(text: &str) -> bool {
    is_dashed_remark(text) || HARMLESS.iter().any(|start| begins(text, start))
}

/// `Open hand 1`, `CLOSE HAND R[2]`; with more words it is another macro.
pub(super) fn drives_hand(text: &str) -> bool {
    let hand = HANDS.iter().find(|start| begins(text, start));
    let number = hand.and_then(|start| text.get(start.len()..)).map_or("", str::trim);
    let is_digits = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    let is_register = |list| brackets(number, list).is_some_and(|(_, rest)| rest.is_empty());
    is_digits || is_register("R") || is_register("AR")
}

fn begins(text: &str, start: &str) -> bool {
    text.get(..start.len()).is_some_and(|head| head.eq_ignore_ascii_case(start))
}

/// The name and the value of `AO[1:a=b] = 5`: a comment in the brackets may hold the sign, too.
pub(super) fn assignment(text: &str) -> Option<(&str, &str)> {
    let at = ["]=", "] ="].into_iter().filter_map(|sign| text.find(sign)).min();
    let at = at.map_or(0, |at| at + 1);
    let (name, value) = text.split_at_checked(at)?;
    let (blank, value) = value.split_once('=')?;
    Some((if at == 0 { blank } else { name }, value))
}

/// `AO[1:spindle]` as a job names it: `ao[1]`.
pub(super) fn signal_key(name: &str) -> String {
    let (number, _) =
        name.trim().trim_end_matches(']').split_once(':').unwrap_or((name.trim(), ""));
    let key = number.trim_end().to_lowercase();
    if key.contains('[') && !key.ends_with(']') { key + "]" } else { key }
}
