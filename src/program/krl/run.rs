//! Statements of KRL in the order in which the controller would run them.

use std::collections::HashMap;

use nalgebra::Isometry3;

use super::syntax::{Block, Cases, Expr, File, Path, Routine, Statement, What};
use super::value::{Value, is_position};
use super::words::{is_harmless, is_without_effect, sounds_like_motion};
use crate::notes::Code;
use crate::program::Settings;
use crate::program::cell::{External, Given, set_by_call, set_by_name};
use crate::program::log::Log;

/// Calls, blocks and expressions in one another.
const MAX_DEPTH: usize = 60;

/// Statements that loops may run beyond one pass through the files.
const STATEMENTS_IN_LOOPS: usize = 1_000_000;

/// How a statement ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Flow {
    Next,
    Return,
    /// Out of the innermost LOOP, FOR, WHILE, REPEAT.
    Exit,
    /// The program ends.
    Halt,
}

pub(super) struct Run<'a> {
    pub(super) file: &'a File,
    pub(super) settings: &'a Settings,
    pub(super) log: &'a mut Log,
    pub(super) globals: HashMap<String, Value>,
    /// The data of the routines that run, the innermost last.
    pub(super) frames: Vec<HashMap<String, Value>>,
    depth: usize,
    budget: usize,
    pub(super) tcp: Isometry3<f64>,
    pub(super) base: Isometry3<f64>,
    /// $VEL.CP, m/s.
    pub(super) velocity: Option<f64>,
    /// $VEL_AXIS, the lowest share.
    pub(super) joint_share: Option<f64>,
    /// $OV_PRO as a share.
    pub(super) over: f64,
    /// A1 to A6 of the last motion, degrees, if it went to joints.
    pub(super) joints: Option<[f64; 6]>,
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
            frames: Vec::new(),
            depth: 0,
            budget: file.statement_count.saturating_mul(2).saturating_add(STATEMENTS_IN_LOOPS),
            tcp: settings.tcp.unwrap_or_default(),
            base: settings.work_object.unwrap_or_default(),
            velocity: None,
            joint_share: None,
            over: 1.0,
            joints: None,
            external: External::new(settings),
            comments,
        }
    }

    pub(super) fn run(mut self, routine: &'a Routine) {
        for statement in &self.file.data {
            match &statement.what {
                What::Declare(paths, value) => self.declare(paths, value.as_ref(), true),
                What::Assign(path, expr) => {
                    let value = self.eval(expr);
                    // Data that cannot be stored are unknown where they are read.
                    drop(self.write(path, value));
                }
                _ => {}
            }
        }
        self.frames.push(HashMap::new());
        self.block(&routine.body);
    }

    pub(super) fn block(&mut self, block: &'a Block) -> Flow {
        for statement in block {
            match self.statement(statement) {
                Flow::Next => {}
                flow => return flow,
            }
        }
        Flow::Next
    }

    fn another(&mut self, line: usize) -> bool {
        if self.log.is_full() {
            return false;
        }
        match self.budget.checked_sub(1) {
            Some(left) => {
                self.budget = left;
                true
            }
            None => {
                let what = "the program runs too long here: a loop without an end?";
                self.log.error(Code::TooLong, line, what);
                false
            }
        }
    }

    fn statement(&mut self, statement: &'a Statement) -> Flow {
        let line = statement.line;
        if !self.another(line) {
            return Flow::Halt;
        }
        if self.depth >= MAX_DEPTH {
            self.log.error(Code::TooLong, line, "calls are nested too deep here");
            return Flow::Halt;
        }
        self.comments.heed(line, self.log);
        self.depth += 1;
        let flow = self.inside(line, &statement.what);
        self.depth -= 1;
        flow
    }

    fn inside(&mut self, line: usize, what: &'a What) -> Flow {
        match what {
            What::Declare(paths, value) => self.declare(paths, value.as_ref(), false),
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
            What::While(condition, body) => {
                return self.repeated(line, Some(condition), None, body);
            }
            What::Repeat(body, until) => return self.repeated(line, None, Some(until), body),
            What::Loop(body) if leaves(body, true) => {
                return self.repeated(line, None, None, body);
            }
            What::Loop(body) => {
                let what = "an endless loop: read once, without the move from its end back to its \
                            beginning";
                self.log.warning(Code::MotionLeftOut, line, what);
                return match self.block(body) {
                    Flow::Exit => Flow::Next,
                    Flow::Next => Flow::Halt,
                    flow => flow,
                };
            }
            What::Switch(tested, cases, otherwise) => {
                return self.switch(line, tested, cases, otherwise);
            }
            What::Return => return Flow::Return,
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
                let what = format!("GOTO {label}: jumps are not supported");
                self.log.error(Code::Motion, line, what);
            }
            What::NotUnderstood(why) => self.log.error(Code::Syntax, line, why.clone()),
        }
        Flow::Next
    }

    fn declare(&mut self, paths: &'a [Path], value: Option<&'a Expr>, global: bool) {
        let Some(last) = paths.last() else { return };
        let value = value.map(|expr| self.eval(expr));
        for path in paths {
            let Ok(key) = self.key(path) else { continue };
            let own = value.clone().filter(|_| path == last);
            match (own, self.frames.last_mut().filter(|_| !global)) {
                (Some(value), None) => {
                    self.globals.insert(key, value);
                }
                // An array: its elements are told when they are set.
                (None, _) if !path.indices.is_empty() => {}
                // A parameter, which its routine declares.
                (None, Some(frame)) if frame.contains_key(&key) => {}
                (own, Some(frame)) => {
                    let unset = || Value::unknown(format!("'{key}' is read before it is set"));
                    let own = own.unwrap_or_else(unset);
                    frame.insert(key, own);
                }
                (None, None) => {}
            }
        }
    }

    /// One of the blocks may run or not: harmless if they neither move nor set anything.
    fn undecided(&mut self, line: usize, keyword: &str, why: &str, blocks: [&'a Block; 2]) {
        let mut open: Vec<&'a Block> = blocks.into_iter().collect();
        while let Some(block) = open.pop() {
            for statement in block {
                match &statement.what {
                    What::Declare(..) | What::Halt | What::WaitSec(_) => {}
                    What::Call(name, _)
                        if !self.file.routines.contains_key(name) && is_harmless(name) => {}
                    What::Assign(path, _) if is_without_effect(&path.name) => {}
                    What::Assign(path, _) if !path.name.starts_with('$') => {
                        let what = format!("'{}' depends on a condition: {why}", path.name);
                        if let Ok(key) = self.key(path) {
                            self.globals.insert(key.clone(), Value::unknown(what.clone()));
                            if let Some(frame) = self.frames.last_mut() {
                                frame.remove(&key);
                            }
                        }
                    }
                    What::If(_, yes, no) => open.extend([yes, no]),
                    What::Call(name, _)
                        if !self.file.routines.contains_key(name)
                            && name != "bas"
                            && !sounds_like_motion(name) =>
                    {
                        self.not_read(statement.line, name);
                    }
                    _ => {
                        let what = format!(
                            "{keyword} decides about motion at run time: {why}; assume: in the job \
                             can settle it"
                        );
                        self.log.error(Code::Motion, line, what);
                        return;
                    }
                }
            }
        }
    }

    fn for_loop(
        &mut self,
        line: usize,
        variable: &'a Path,
        parts: [Option<&'a Expr>; 3],
        body: &'a Block,
    ) -> Flow {
        let mut numbers = [None; 3];
        for (number, expr) in numbers.iter_mut().zip(parts) {
            match expr.map(|expr| self.eval(expr).num()) {
                None => {}
                Some(Ok(value)) => *number = Some(value),
                Some(Err(why)) => {
                    const NONE: &Block = &Block::new();
                    self.undecided(line, "FOR", &why, [body, NONE]);
                    return Flow::Next;
                }
            }
        }
        let [Some(from), Some(to), step] = numbers else { return Flow::Next };
        let step = step.unwrap_or(1.0);
        if step == 0.0 {
            self.log.error(Code::Value, line, "FOR: STEP is 0");
            return Flow::Next;
        }
        let mut at = from;
        while (if step > 0.0 { at <= to } else { at >= to }) && self.another(line) {
            drop(self.write(variable, Value::Num(at, None)));
            match self.block(body) {
                Flow::Next => {}
                Flow::Exit => return Flow::Next,
                flow => return flow,
            }
            at += step;
        }
        Flow::Next
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
        loop {
            if let Some(condition) = before {
                match self.eval(condition).bool() {
                    Ok(true) => {}
                    Ok(false) => return Flow::Next,
                    Err(why) => {
                        self.undecided(line, "WHILE", &why, [body, NONE]);
                        return Flow::Next;
                    }
                }
            }
            if !self.another(line) {
                return Flow::Halt;
            }
            match self.block(body) {
                Flow::Next => {}
                Flow::Exit => return Flow::Next,
                flow => return flow,
            }
            if let Some(condition) = behind {
                match self.eval(condition).bool() {
                    Ok(false) => {}
                    Ok(true) => return Flow::Next,
                    Err(why) => {
                        self.undecided(line, "UNTIL", &why, [body, NONE]);
                        return Flow::Next;
                    }
                }
            }
        }
    }

    fn switch(
        &mut self,
        line: usize,
        tested: &'a Expr,
        cases: &'a Cases,
        otherwise: &'a Block,
    ) -> Flow {
        let tested = self.eval(tested);
        let key = |value: &Value| match value {
            Value::Num(number, _) => Some(number.to_string()),
            Value::Enum(name) => Some(format!("#{name}")),
            Value::Text(text) => Some(format!("\"{text}")),
            _ => None,
        };
        let Some(wanted) = key(&tested) else {
            let why = tested.num().err().unwrap_or_default();
            for (_, body) in cases {
                self.undecided(line, "SWITCH", &why, [body, otherwise]);
            }
            return Flow::Next;
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

    fn call(&mut self, line: usize, name: &'a str, args: &'a [Option<Expr>]) -> Flow {
        let given = args.iter().map(|arg| match arg {
            Some(expr) => given(&self.eval(expr)),
            None => (Err("an argument is left out".to_owned()), None),
        });
        let numbers: Vec<Given> = given.collect();
        let sets = set_by_call(self.settings, self.log, line, name, &numbers);
        if let Some(routine) = self.file.routines.get(name) {
            return self.run_routine(routine, args);
        }
        if name == "bas" {
            if let Err(why) = self.bas(line, args) {
                self.log.error(Code::Motion, line, format!("BAS: {why}"));
            }
            return Flow::Next;
        }
        if sets || is_harmless(name) {
            return Flow::Next;
        }
        let values: Vec<Value> = args.iter().flatten().map(|expr| self.eval(expr)).collect();
        if values.iter().any(is_position) || sounds_like_motion(name) {
            let what = format!("'{name}' is in no file that is read and moves");
            self.log.error(Code::Motion, line, what);
        } else {
            self.not_read(line, name);
        }
        Flow::Next
    }

    fn not_read(&mut self, line: usize, name: &str) {
        let what =
            format!("'{name}' is in no file that is read; if it moves, its motion is not read");
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    fn run_routine(&mut self, routine: &'a Routine, args: &'a [Option<Expr>]) -> Flow {
        let mut frame = HashMap::new();
        for (index, name) in routine.parameters.iter().enumerate() {
            let value = match args.get(index) {
                Some(Some(expr)) => self.eval(expr),
                _ => Value::unknown(format!("'{}' is called without '{name}'", routine.shown)),
            };
            frame.insert(name.clone(), value);
        }
        self.frames.push(frame);
        let flow = self.block(&routine.body);
        let frame = self.frames.pop().unwrap_or_default();
        // What the routine sets reaches the caller: parameters are references unless IN.
        for (name, arg) in routine.parameters.iter().zip(args) {
            if let (Some(Expr::Ref(path)), Some(value)) = (arg, frame.get(name)) {
                drop(self.write(path, value.clone()));
            }
        }
        if flow == Flow::Halt { Flow::Halt } else { Flow::Next }
    }

    /// A signal of the cell may be a variable here: `$ANOUT[1] = 0.5`.
    pub(super) fn sets_signal(&mut self, line: usize, key: &str, value: &Value) -> bool {
        set_by_name(self.settings, self.log, line, key, given(value))
    }
}

/// Whether a block leaves the LOOP that it stands in; EXIT counts where `own` says that no other
/// loop lies between.
fn leaves(block: &Block, own: bool) -> bool {
    block.iter().any(|statement| match &statement.what {
        What::Exit => own,
        What::Return => true,
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

fn given(value: &Value) -> Given {
    let span = match value {
        Value::Num(_, span) => *span,
        _ => None,
    };
    (value.num(), span)
}
