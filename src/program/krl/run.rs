//! Statements of KRL in the order in which the controller would run them.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::rc::Rc;

use nalgebra::Isometry3;

use super::rests::{Rests, Uses, Waits};
use super::shares::Shares;
use super::syntax::{Block, Cases, Expr, File, Path, Routine, Statement, What};
use super::turns::Turns;
use super::unmoved::Unmoved;
use super::value::{Sort, Type, Value, base, unset};
use super::words::is_harmless;
use crate::notes::Code;
use crate::program::Settings;
use crate::program::cell::{External, Given, set_by_name};
use crate::program::log::Log;
use crate::program::spindle_names::Analog;
use crate::program::unread::behind;

/// Calls, blocks and expressions in one another.
pub(super) const MAX_DEPTH: usize = 60;

/// Statements that loops may run beyond one pass through the files.
const STATEMENTS_IN_LOOPS: usize = 1_000_000;

/// Names that decide how a loop goes on; `None` where that is not looked at.
pub(super) type Deciding<'a> = Option<Rc<HashSet<&'a str>>>;

/// The data of a routine.
#[derive(Debug, Default)]
pub(super) struct Frame {
    pub(super) data: HashMap<String, Value>,
    pub(super) types: HashMap<String, Type>,
    /// Data that rest on others, with those.
    pub(super) resting: HashMap<String, Rests>,
}

impl Frame {
    /// Whether a datum, or an array that it is an element of, is the routine's own.
    pub(super) fn has(&self, key: &str) -> bool {
        self.data.contains_key(key) || self.types.contains_key(base(key))
    }
}

/// How a statement ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Flow {
    Next,
    Return,
    /// Out of the innermost LOOP, FOR, WHILE, REPEAT.
    Exit,
    /// GOTO.
    Jump,
    /// The program ends.
    Halt,
}

/// What is told of a move whose coordinates count in $WORLD.
pub(super) type OfWorld = (Code, &'static str);

/// Base and tool, and why they are not known.
type AskedIn = (Isometry3<f64>, Isometry3<f64>, Option<String>, Option<(String, [bool; 2])>);

/// A datum that something beside the program may set at any time.
#[derive(PartialEq)]
pub(super) struct Beside {
    /// The number of the interrupt; `None` of a trigger, and of one whose number is not known.
    pub(super) interrupt: Option<String>,
    /// Of a list where any of its elements may be it.
    pub(super) key: String,
    pub(super) scope: Option<usize>,
    pub(super) why: String,
}

pub(super) struct Run<'a> {
    pub(super) file: &'a File,
    pub(super) settings: &'a Settings,
    pub(super) log: &'a mut Log,
    pub(super) globals: HashMap<String, Value>,
    /// What the program sets to what is not known: what the job assumes of it holds no longer.
    pub(super) forgotten: HashSet<String>,
    /// Components that the program has set of data that no file declares, by their whole names.
    pub(super) components: HashMap<String, Value>,
    /// Data for all that rest on others, with those.
    pub(super) resting: HashMap<String, Rests>,
    /// What the statement that runs rests on.
    pub(super) rests_on: Option<Rests>,
    pub(super) uses: Uses<'a>,
    pub(super) waits: Waits,
    /// What decides how loops go on, by their bodies.
    pub(super) loops: HashMap<*const Block, Deciding<'a>>,
    /// What may be set under a condition that only the run decides, while that is read.
    pub(super) open_sets: HashSet<&'a str>,
    /// Signals that triggers, interrupts and pulses set.
    pub(super) timed: HashSet<String>,
    /// Data that the program gives to what the job reads the spindle or the tool from.
    pub(super) given_on: HashSet<&'a str>,
    pub(super) analog: Analog,
    /// What the procedure sets that the job reads the spindle from, and whether that runs.
    pub(super) of_spindle: HashSet<String>,
    pub(super) is_in_spindle: bool,
    /// Of the data that data lists declare.
    pub(super) types: HashMap<String, Type>,
    /// The data of the routines that run, the innermost last.
    pub(super) frames: Vec<Frame>,
    pub(super) depth: usize,
    /// Expressions that are worked out for an index, one in another.
    pub(super) indexing: usize,
    /// What the function that runs gives, and what that rests on.
    pub(super) returned: Option<(Value, Option<Rests>)>,
    /// Where GOTO goes to, and its line.
    jump: Option<(usize, &'a str)>,
    /// A function has ended the program.
    pub(super) is_halted: bool,
    /// A branch that may leave a loop was not decided.
    pub(super) is_way_open: bool,
    /// The line of the main file that runs, and the place in another file, if it is there.
    pub(super) line: usize,
    pub(super) place: (usize, usize),
    /// By number: what interrupts do.
    pub(super) interrupts: BTreeMap<String, Option<&'a What>>,
    /// What interrupts that are on, and triggers, may set at any time.
    pub(super) beside: Vec<Beside>,
    pub(super) budget: usize,
    pub(super) tcp: Isometry3<f64>,
    /// Why another tool may be meant than the one that is taken.
    pub(super) unsure_tool: Option<&'static str>,
    pub(super) base: Isometry3<f64>,
    /// Why the base that the program has chosen is not known.
    pub(super) no_base: Option<String>,
    /// What is to be told of moves in the base, where that is $WORLD.
    pub(super) of_world: Option<OfWorld>,
    /// Base and tool where the program has first asked for what the job assumes of the position.
    pub(super) asked_in: Option<AskedIn>,
    /// Whether the robot may have left the place where it stood before the program.
    pub(super) has_left: bool,
    pub(super) unmoved: Unmoved<'a>,
    /// $VEL.CP, m/s.
    pub(super) velocity: Option<f64>,
    /// Why the controller may have another: the data of a form have set it.
    pub(super) unsure_velocity: Option<String>,
    /// $VEL.ORI1 and $VEL.ORI2, rad/s.
    pub(super) turning: [Option<f64>; 2],
    /// $VEL_AXIS and $VEL_EXTAX.
    pub(super) shares: Shares,
    /// Why the share of the last inline form is not known, or may be another.
    pub(super) unknown_share: Option<String>,
    /// Why tool and base of the last inline form are not known, and which the program has stated
    /// since.
    pub(super) unknown_form: Option<(String, [bool; 2])>,
    /// $ORI_TYPE and $CIRC_TYPE.
    pub(super) turns: Turns,
    /// $OV_PRO as a share.
    pub(super) over: f64,
    /// A1 to A6 of the last motion, degrees, if it went to joints.
    pub(super) joints: Option<[f64; 6]>,
    /// X to C of the last two targets, the newest first: of an arc its end and the point on it.
    pub(super) stated: [Option<[f64; 6]>; 2],
    pub(super) external: External,
    pub(super) comments: crate::program::cell::Comments,
}

impl<'a> Run<'a> {
    pub(super) fn new(
        file: &'a File,
        settings: &'a Settings,
        comments: crate::program::cell::Comments,
        log: &'a mut Log,
    ) -> Self {
        Self {
            file,
            settings,
            log,
            globals: HashMap::new(),
            forgotten: HashSet::new(),
            components: HashMap::new(),
            resting: HashMap::new(),
            rests_on: None,
            uses: Uses::of(file),
            waits: Waits::default(),
            loops: HashMap::new(),
            open_sets: HashSet::new(),
            timed: HashSet::new(),
            given_on: HashSet::new(),
            analog: Analog::default(),
            of_spindle: HashSet::new(),
            is_in_spindle: false,
            types: HashMap::new(),
            frames: Vec::new(),
            depth: 0,
            indexing: 0,
            returned: None,
            jump: None,
            is_halted: false,
            is_way_open: false,
            line: 1,
            place: (0, 0),
            interrupts: BTreeMap::new(),
            beside: Vec::new(),
            budget: file.statement_count.saturating_mul(2).saturating_add(STATEMENTS_IN_LOOPS),
            tcp: settings.tcp.unwrap_or_default(),
            unsure_tool: None,
            base: settings.work_object.unwrap_or_default(),
            no_base: None,
            of_world: None,
            asked_in: None,
            has_left: false,
            unmoved: Unmoved::default(),
            velocity: None,
            unsure_velocity: None,
            turning: [None; 2],
            shares: Shares::default(),
            unknown_share: None,
            unknown_form: None,
            turns: Turns::default(),
            over: 1.0,
            joints: None,
            stated: [None; 2],
            external: External::new(settings),
            comments,
        }
    }

    pub(super) fn run(mut self, routine: &'a Routine) {
        for statement in &self.file.data {
            match &statement.what {
                What::Declare(declared, paths, value) => {
                    self.declare(*declared, paths, value.as_ref(), true);
                }
                What::Assign(path, expr) => {
                    let value = self.eval(expr);
                    // Data that cannot be stored are unknown where they are read.
                    drop(self.write(path, value));
                }
                _ => {}
            }
        }
        self.waits = Waits::default();
        self.frames.push(Frame::default());
        self.timed = self.timed_signals();
        self.of_spindle = self.set_by_spindle();
        self.starts_unchosen();
        self.body(&routine.body);
        self.tell_no_motion(routine);
    }

    fn tell_no_motion(&mut self, routine: &'a Routine) {
        if self.log.has_moved() || self.log.has_errors() {
            return;
        }
        for what in self.reached(routine.body.iter().map(|own| &own.what).collect()) {
            if let What::Call(name, _) = what
                && self.file.routine(name).is_none()
                && !(is_harmless(name) || name == "bas")
                && !self.unmoved.missing.contains(&name.as_str())
            {
                self.unmoved.missing.push(name);
            }
        }
        if let Some((line, what)) = std::mem::take(&mut self.unmoved).error() {
            self.log.error(Code::Motion, line, what);
        }
    }

    /// Of a routine.
    pub(super) fn body(&mut self, body: &'a Block) -> Flow {
        let flow = self.block(body);
        if flow == Flow::Jump
            && let Some((line, label)) = self.jump.take()
        {
            let what = format!("GOTO {label}: there is no label '{label}' that it can go to");
            self.log.error(Code::Motion, line, what);
        }
        flow
    }

    pub(super) fn block(&mut self, block: &'a Block) -> Flow {
        let mut next = 0;
        while let Some(statement) = block.get(next) {
            next += 1;
            match self.statement(statement) {
                Flow::Next => {}
                Flow::Jump => {
                    self.doubt_behind(statement, block.get(next..).unwrap_or_default());
                    let Some((line, label)) = self.jump else { return Flow::Jump };
                    let is_label =
                        |each: &Statement| matches!(&each.what, What::Label(own) if own == label);
                    // Out of loops and branches, never into them.
                    let Some(at) = block.iter().position(is_label) else { return Flow::Jump };
                    self.jump = None;
                    let passed = block.get(at..next - 1).unwrap_or_default();
                    let goes_back = at < next && matches!(statement.what, What::Goto(_));
                    if goes_back && !leaves(passed, true) {
                        self.tell_endless(line, passed, "once");
                        return Flow::Halt;
                    }
                    next = at;
                }
                flow => {
                    self.doubt_behind(statement, block.get(next..).unwrap_or_default());
                    return flow;
                }
            }
        }
        Flow::Next
    }

    /// Tells of the first move in the rest of a block that ends here in any case: up to a label,
    /// which others may go to.
    fn doubt_behind(&mut self, end: &'a Statement, rest: &'a [Statement]) {
        let end = match end.what {
            What::Return(_) => "RETURN",
            What::Exit => "EXIT",
            What::Goto(_) => "GOTO",
            _ => return,
        };
        let mut rest = rest.iter().take_while(|each| !matches!(each.what, What::Label(_)));
        if let Some(first) = rest.find(|each| self.moves(&each.what)) {
            let (place, main_line) = (self.place, self.line);
            let line = self.enter(first.file, first.line);
            behind(self.log, line, end);
            self.enter_again(place, main_line);
        }
    }

    /// The line of the main file that a statement counts as: one of another file as the one that
    /// leads to it, with its own place in what is told of it.
    pub(super) fn enter(&mut self, file: usize, line: usize) -> usize {
        if file == 0 {
            self.line = line;
        }
        let place = if file == 0 { (0, 0) } else { (file, line) };
        if place != self.place {
            self.place = place;
            let other = file.checked_sub(1).and_then(|index| self.settings.companions.get(index));
            self.log.within(other.map_or_else(String::new, |it| format!("{}:{line}: ", it.name)));
        }
        self.line
    }

    /// Back to where the run stood before.
    pub(super) fn enter_again(&mut self, (file, outer): (usize, usize), main_line: usize) {
        self.line = main_line;
        self.enter(file, if file == 0 { main_line } else { outer });
    }

    pub(super) fn another(&mut self, line: usize) -> bool {
        if self.log.is_full() {
            return false;
        }
        match self.budget.checked_sub(1) {
            Some(left) => {
                self.budget = left;
                true
            }
            None => {
                self.log.runs_too_long(line);
                false
            }
        }
    }

    fn statement(&mut self, statement: &'a Statement) -> Flow {
        let (place, main_line) = (self.place, self.line);
        let line = self.enter(statement.file, statement.line);
        let flow = self.entered(line, statement);
        // What is told of the rest of a statement that calls is of that one.
        self.enter_again(place, main_line);
        flow
    }

    fn entered(&mut self, line: usize, statement: &'a Statement) -> Flow {
        if self.is_halted || !self.another(line) {
            return Flow::Halt;
        }
        if self.depth >= MAX_DEPTH {
            self.log.error(Code::TooLong, line, "calls are nested too deep here");
            return Flow::Halt;
        }
        if statement.file == 0 {
            self.comments.heed(line, self.log);
        }
        self.depth += 1;
        let outer = self.rests_on.take();
        let flow = self.inside(line, &statement.what);
        if let Some(on) = self.rests_on.take() {
            self.tell_resting(line, &statement.what, on);
        }
        self.rests_on = outer;
        self.depth -= 1;
        flow
    }

    fn inside(&mut self, line: usize, what: &'a What) -> Flow {
        match what {
            What::Declare(declared, paths, value) => {
                self.declare(*declared, paths, value.as_ref(), false);
            }
            What::Assign(path, expr) => self.assign(line, path, expr),
            What::Call(name, args) => return self.call(line, name, args),
            What::Move(motion) => {
                if let Err(why) = self.motion(line, motion) {
                    self.log.error(Code::Motion, line, why);
                }
            }
            What::Spline(with, block) => self.spline(line, with, block),
            What::If(condition, yes, no) => match self.eval(condition).bool() {
                Ok(true) => return self.block(yes),
                Ok(false) => return self.block(no),
                Err(why) => self.undecided(line, "IF", &why, [yes, no]),
            },
            What::For(variable, [from, to], step, body) => {
                return self.for_loop(line, variable, [Some(from), Some(to), step.as_ref()], body);
            }
            // WHILE TRUE and UNTIL FALSE are LOOP.
            What::While(Expr::Bool(true), body) | What::Repeat(body, Expr::Bool(false))
                if !leaves(body, true) =>
            {
                return self.endless(line, body);
            }
            What::While(condition, body) => {
                return self.repeated(line, Some(condition), None, body);
            }
            What::Repeat(body, until) => return self.repeated(line, None, Some(until), body),
            What::Loop(body) if leaves(body, true) => {
                return self.repeated(line, None, None, body);
            }
            What::Loop(body) => return self.endless(line, body),
            What::Switch(tested, cases, otherwise) => {
                return self.switch(line, tested, cases, otherwise);
            }
            What::Return(value) => {
                // It matters where the function is called.
                self.returned = value.as_ref().map(|expr| (self.eval(expr), self.rests_on.take()));
                return Flow::Return;
            }
            What::Exit => return Flow::Exit,
            What::Halt => {}
            What::WaitSec(expr) => match self.eval(expr).num() {
                Ok(seconds) => self.log.dwell(line, seconds),
                Err(why) => {
                    let what = format!("WAIT SEC: {why}; the time is left out");
                    self.log.warning(Code::LeftOut, line, what);
                }
            },
            What::Goto(label) => {
                self.jump = Some((line, label));
                return Flow::Jump;
            }
            What::Label(_) => {}
            What::InterruptDecl(number, action) => {
                self.declare_interrupt(number, action.as_deref())
            }
            What::InterruptOn(number) => self.interrupt_on(line, number.as_ref()),
            What::InterruptOff(number) => self.interrupt_off(number.as_ref()),
            What::Trigger(action) => self.trigger(line, action.as_deref()),
            What::NotUnderstood(why) => self.log.error(Code::Syntax, line, why.clone()),
        }
        Flow::Next
    }

    fn endless(&mut self, line: usize, body: &'a Block) -> Flow {
        self.tell_endless(line, body, "once");
        match self.block(body) {
            Flow::Exit => Flow::Next,
            Flow::Next => Flow::Halt,
            flow => flow,
        }
    }

    fn tell_endless(&mut self, line: usize, body: &'a [Statement], read: &str) {
        let open = self.open_in(body);
        let what = format!(
            "an endless loop: read {read}, without the move from its end back to its \
             beginning{open}"
        );
        if !open.is_empty() {
            self.unmoved.looped.get_or_insert_with(|| (line, what.clone()));
        }
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    fn declare(
        &mut self,
        declared: Type,
        paths: &'a [Path],
        value: Option<&'a Expr>,
        global: bool,
    ) {
        let Some(last) = paths.last() else { return };
        let value = value.map(|expr| self.eval(expr).held_as(Some(declared)));
        for path in paths {
            let types = match self.frames.last_mut().filter(|_| !global) {
                Some(frame) => &mut frame.types,
                None => &mut self.types,
            };
            types.insert(path.name.clone(), declared);
            let Ok(key) = self.key(path) else { continue };
            let own = value.clone().filter(|_| path == last);
            match (own, self.frames.last_mut().filter(|_| !global)) {
                (Some(value), None) => {
                    self.globals.insert(key, value);
                }
                // An array: its elements are told when they are set.
                (None, _) if !path.indices.is_empty() => {}
                // A parameter, which its routine declares.
                (None, Some(frame)) if frame.data.contains_key(&key) => {
                    let given = frame.data.remove(&key).unwrap_or_else(|| unset(&key));
                    frame.data.insert(key, given.held_as(Some(declared)));
                }
                (own, Some(frame)) => {
                    let own = own.unwrap_or_else(|| unset(&key));
                    frame.data.insert(key, own);
                }
                (None, None) => {}
            }
        }
    }

    /// WHILE, REPEAT, and LOOP with a way out.
    fn repeated(
        &mut self,
        line: usize,
        before: Option<&'a Expr>,
        behind: Option<&'a Expr>,
        body: &'a Block,
    ) -> Flow {
        const NONE: &Block = &Block::new();
        /// Passes whose data are compared.
        const COMPARED: usize = 3;
        let conditions: Vec<&Expr> = before.into_iter().chain(behind).collect();
        let deciding = self.deciding(body, conditions.clone());
        for passes in 1_usize.. {
            if let Some(condition) = before {
                match self.eval(condition).bool() {
                    Ok(true) => {}
                    Ok(false) => {
                        self.polled(body, conditions);
                        return Flow::Next;
                    }
                    // Whoever moves in the condition moves once more for each pass.
                    Err(why) if self.calls_a_routine(vec![condition]) => {
                        self.decides(line, "WHILE", &why);
                        return Flow::Next;
                    }
                    Err(why) => {
                        self.undecided(line, "WHILE", &why, [body, NONE]);
                        self.polled(body, conditions);
                        return Flow::Next;
                    }
                }
            }
            if !self.another(line) {
                return Flow::Halt;
            }
            self.is_way_open = false;
            let compared = deciding.as_deref().filter(|_| passes <= COMPARED);
            let state = compared.map(|names| (names, self.values_of(names)));
            match self.block(body) {
                // The run decides whether it ends: it is refused, and once is enough.
                Flow::Next if self.is_way_open && leaves(body, true) => return Flow::Next,
                Flow::Next => {}
                Flow::Exit => {
                    self.polled(body, conditions);
                    return Flow::Next;
                }
                flow => return flow,
            }
            if let Some(condition) = behind {
                match self.eval(condition).bool() {
                    Ok(false) => {}
                    Ok(true) => {
                        self.polled(body, conditions);
                        return Flow::Next;
                    }
                    Err(why) if self.calls_a_routine(vec![condition]) => {
                        self.decides(line, "UNTIL", &why);
                        return Flow::Next;
                    }
                    Err(why) => {
                        self.undecided(line, "UNTIL", &why, [body, NONE]);
                        self.polled(body, conditions);
                        return Flow::Next;
                    }
                }
            }
            if state.is_some_and(|(names, state)| self.values_of(names) == state) {
                let count = if passes == 1 { "once" } else { &format!("{passes} times") };
                let read = format!(
                    "{count} (nothing in it, and nothing that assume: gives, ends it: what stands \
                     behind it is not read, unless it ends in the file that is checked)"
                );
                self.tell_endless(line, body, &read);
                return Flow::Halt;
            }
        }
        Flow::Halt
    }

    fn switch(
        &mut self,
        line: usize,
        tested: &'a Expr,
        cases: &'a Cases,
        otherwise: &'a Block,
    ) -> Flow {
        let (datum, tested) = (tested, self.eval(tested));
        let key = |value: &Value| match value {
            Value::Num(number, ..) => Some(number.to_string()),
            Value::Enum(name) => Some(format!("#{name}")),
            Value::Text(text) => Some(format!("\"{text}")),
            _ => None,
        };
        let Some(wanted) = key(&tested) else {
            let why = tested.num().err().unwrap_or_default();
            let mut is_open = false;
            for (values, body) in cases {
                let mut may_be = false;
                for value in values {
                    let name = self.eval(value);
                    may_be |= !self.is_other(datum, &tested, &name);
                }
                if may_be {
                    is_open = true;
                    self.undecided(line, "SWITCH", &why, [body, otherwise]);
                }
            }
            return if is_open { Flow::Next } else { self.block(otherwise) };
        };
        for (values, body) in cases {
            for value in values {
                let value = self.eval(value);
                if key(&value).as_ref() == Some(&wanted) {
                    return self.block(body);
                }
            }
        }
        self.block(otherwise)
    }

    /// A signal of the cell may be a variable here: `$ANOUT[1] = 0.5`.
    pub(super) fn sets_signal(&mut self, line: usize, key: &str, value: &Value) -> bool {
        let names = self.names(key);
        let mut given = given(value);
        // A row of outputs takes whole numbers, an analog one shares of its range.
        let begins = |list: &str| names.iter().any(|name| name.starts_with(list));
        given.whole = begins("$out[") || given.whole && !begins("$anout[");
        let set = |name: &String| set_by_name(self.settings, self.log, line, name, given.clone());
        // Every name counts: of the spindle, and of the tool.
        names.iter().map(set).fold(false, |done, is_set| done | is_set)
    }
}

/// Whether a block leaves the LOOP that it stands in; EXIT counts where `own` says that no other
/// loop lies between.
pub(super) fn leaves(block: &[Statement], own: bool) -> bool {
    block.iter().any(|statement| match &statement.what {
        What::Exit => own,
        What::Return(_) | What::Goto(_) => true,
        What::If(_, yes, no) => leaves(yes, own) || leaves(no, own),
        What::Switch(_, cases, otherwise) => {
            cases.iter().any(|(_, body)| leaves(body, own)) || leaves(otherwise, own)
        }
        What::For(.., body) | What::While(_, body) | What::Repeat(body, _) | What::Loop(body) => {
            leaves(body, false)
        }
        _ => false,
    })
}

pub(super) fn given(value: &Value) -> Given {
    let (span, whole) = match value {
        Value::Num(_, span, sort) => (*span, *sort != Sort::Real),
        _ => (None, false),
    };
    Given { value: value.num(), span, whole }
}
