//! Which line of G-code comes next: subprograms, loops, conditions and jumps of LinuxCNC (O-words)
//! and Fanuc (M98, WHILE, IF, GOTO).

use std::collections::{HashMap, HashSet};

use super::abbreviated::whole;
use super::by_value;
use super::expression::{Reader, not_vacant};
use super::files::Files;
use super::o_words::{computed, nothing_behind, o_word};
use super::parameters::{Locals, Parameters, Set};
use super::running::{Head, Running};
use super::structure::{Structure, stripped, within};
use crate::notes::Code;
use crate::program::log::Log;
use crate::program::unread::left_over;

/// Lines that loops may run beyond one pass through the file.
const LINES_IN_LOOPS: usize = 1_000_000;

/// Calls in one another.
const MAX_CALLS: usize = 10;

/// What is open at a place of the program.
struct Call {
    /// Line to go on with.
    back: usize,
    /// First line of the subprogram, and how often it runs yet.
    first: usize,
    repeats: u32,
    /// The caller's locals, where the call has its own.
    kept: Option<Locals>,
    /// The program of Fanuc's that calls.
    by: Running,
}

/// A statement with an O-word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OWord {
    pub(super) line: usize,
    pub(super) label: String,
    pub(super) keyword: String,
}

/// A line from a place on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Behind<'t> {
    pub(super) content: &'t str,
    pub(super) rest: usize,
}

impl<'t> Behind<'t> {
    pub(super) fn reader<'p>(self, parameters: &'p Parameters) -> Reader<'p>
    where
        't: 'p,
    {
        Reader::new(self.content.as_bytes(), self.rest, parameters)
    }
}

pub(super) struct Flow<'t> {
    pub(super) lines: &'t [(usize, &'t str)],
    pub(super) files: &'t Files<'t>,
    pub(super) parameters: Parameters,
    /// What an assignment behind THEN sets when the line has been read.
    pub(super) sets: Vec<Set>,
    pub(super) next: usize,
    budget: usize,
    ended: bool,
    /// Which lines have run, of the file.
    ran: Vec<bool>,
    calls: Vec<Call>,
    running: Running,
    /// Passes left of repeats, by their line.
    pub(super) repeats: HashMap<usize, u64>,
    /// Of a program of Sinumerik's, which has its own words.
    is_sinumerik: bool,
    pub(super) structure: Structure,
    pub(super) o_words: Vec<OWord>,
    /// Heads of Fanuc's programs, by line.
    heads: HashMap<usize, Head>,
    /// Fanuc's programs, by number, those that have been called, and its WHILE loops, by line of
    /// WHILE and of END.
    programs: HashMap<i64, usize>,
    called: HashSet<i64>,
    /// Lines by their block number, in order.
    numbers: HashMap<i64, Vec<usize>>,
    loops: Vec<(usize, usize)>,
}

impl<'t> Flow<'t> {
    pub(super) fn new(files: &'t Files<'t>, parameters: Parameters) -> Self {
        let lines = files.lines.as_slice();
        let is_sinumerik = parameters.is_sinumerik();
        let mut flow = Self {
            lines,
            files,
            parameters,
            sets: Vec::new(),
            next: 0,
            budget: lines.len().saturating_mul(2).saturating_add(LINES_IN_LOOPS),
            ended: false,
            ran: vec![false; lines.len()],
            calls: Vec::new(),
            running: Running::default(),
            repeats: HashMap::new(),
            is_sinumerik,
            structure: if is_sinumerik { Structure::of(files) } else { Structure::default() },
            o_words: Vec::new(),
            heads: HashMap::new(),
            programs: HashMap::new(),
            called: HashSet::new(),
            numbers: HashMap::new(),
            loops: Vec::new(),
        };
        flow.index();
        flow
    }

    fn index(&mut self) {
        let mut open: Vec<(i64, usize)> = Vec::new();
        for (line, (_, content)) in self.lines.iter().enumerate() {
            let number = content.trim_start().strip_prefix(['N', 'n']).and_then(leading_number);
            if let Some(number) = number {
                self.numbers.entry(number).or_default().push(line);
            }
            let content = stripped(content);
            match content.as_bytes().first() {
                Some(b'O' | b'o' | b':') => {
                    let own = o_word(content).filter(|_| !content.starts_with(':'));
                    if let Some((label, keyword, _)) = own {
                        self.o_words.push(OWord { line, label, keyword });
                    } else if let Some(head) = Head::of(content) {
                        self.programs.entry(head.number).or_insert(line);
                        self.heads.insert(line, head);
                    }
                }
                Some(b'W' | b'w') if keyword(content) == "WHILE" => {
                    let upper = content.to_ascii_uppercase();
                    let number = upper.rfind("DO").and_then(|at| leading_number(&upper[at + 2..]));
                    open.extend(number.map(|number| (number, line)));
                }
                Some(b'E' | b'e') if keyword(content) == "END" => {
                    let number = leading_number(content.get(letters(content)..).unwrap_or(""));
                    let from = open.iter().rposition(|(open, _)| Some(*open) == number);
                    if let Some(from) = from {
                        self.loops.push((open.remove(from).1, line));
                    }
                }
                _ => {}
            }
        }
    }

    /// The line to run, or `None` at the end of the program or the file.
    pub(super) fn next_line(&mut self, log: &mut Log) -> Option<usize> {
        if self.ended || self.next >= self.files.main().len() && self.calls.is_empty() {
            return None;
        }
        if self.files.is_end(self.next) {
            self.end_at_mark(log);
            return None;
        }
        if self.budget == 0 {
            log.runs_too_long(self.next + 1);
            self.ended = true;
            return None;
        }
        self.budget -= 1;
        self.ran[self.next] = true;
        self.next += 1;
        Some(self.next - 1)
    }

    /// The line of the program from which what runs is called, counted from 1.
    fn line_of_call(&self) -> usize {
        self.calls.first().map_or(self.next, |call| call.back)
    }

    /// The lines behind the end of the program that nothing has run or called.
    pub(super) fn left_over(&self) -> Vec<usize> {
        let subs = self.o_words.iter().filter(|o| o.keyword == "SUB").map(|o| o.line);
        let heads = self.programs.values().copied().chain(subs).collect();
        let ran = self.ran.get(..self.files.main().len()).unwrap_or_default();
        left_over(ran, self.next.min(ran.len()), &heads)
    }

    /// Whether what runs has been called.
    pub(super) fn is_called(&self) -> bool {
        !self.calls.is_empty()
    }

    /// M2, M30.
    pub(super) fn end(&mut self) {
        self.ended = true;
    }

    /// The closing mark, or the end of a file.
    pub(super) fn end_at_mark(&mut self, log: &mut Log) {
        if !self.calls.is_empty() {
            let what = "a subprogram ends without M99, M17 or RET: is the file whole?";
            log.error(Code::Syntax, self.line_of_call(), what);
        }
        self.ended = true;
    }

    pub(super) fn has_ended(&self) -> bool {
        self.ended
    }

    /// M99, M17, RET: back to the caller. The main program ends, where it might begin again: then
    /// true.
    pub(super) fn back(&mut self) -> bool {
        let Some(call) = self.calls.last_mut() else {
            self.ended = true;
            return true;
        };
        if call.repeats > 1 {
            call.repeats -= 1;
            self.next = call.first;
        } else if let Some(call) = self.calls.pop() {
            self.leave(call);
        }
        false
    }

    /// Back to the caller, behind the call.
    fn leave(&mut self, call: Call) {
        if let Some(kept) = call.kept {
            self.parameters.leave(kept);
        }
        self.next = call.back;
        self.running = call.by;
    }

    /// `M99 P n`: back to N n of the caller, whatever repeats are left. In the main program it
    /// jumps; back to what has run it never ends: then true.
    pub(super) fn back_to(&mut self, number: f64) -> Result<bool, String> {
        let here = self.next;
        match self.calls.pop() {
            Some(call) => {
                self.leave(call);
                self.jump_to(number).map(|()| false)
            }
            None => {
                self.jump_to(number)?;
                self.ended = self.next < here;
                Ok(self.ended)
            }
        }
    }

    /// M98 and G65: program `number`, so often.
    pub(super) fn call(
        &mut self,
        number: f64,
        repeats: f64,
        locals: Option<HashMap<i64, f64>>,
    ) -> Result<(), String> {
        if !(0.0..=9999.0).contains(&repeats) || repeats.fract() != 0.0 {
            return Err(format!("a subprogram runs {repeats} times: expected a whole number"));
        }
        let own = self.programs.get(&(number as i64)).map(|head| self.first_of(*head));
        let names = [format!("O{number:04}"), format!("O{number}"), format!("{number}")];
        let first = own.or_else(|| names.iter().find_map(|name| self.files.named(name)));
        let first = first.ok_or_else(|| {
            format!("O{number} is not in this file: name its own under path.program.files")
        })?;
        // Whole and in 0..=9999, checked above.
        self.enter(first, repeats as u32, locals, true)?;
        if repeats > 0.0 {
            self.called.insert(number as i64);
            self.running = Running::called(own.map(|_| number as i64));
        }
        Ok(())
    }

    /// A subprogram of Sinumerik's, a file of its own, so often, with what stands in the
    /// parentheses behind its name.
    pub(super) fn call_file(
        &mut self,
        name: &str,
        inside: &str,
        repeats: f64,
    ) -> Result<(), String> {
        if !(0.0..=9999.0).contains(&repeats) || repeats.fract() != 0.0 {
            return Err(format!("a subprogram runs {repeats} times: expected a whole number"));
        }
        let first = self.files.named(own_name(name)).ok_or_else(|| {
            let head = format!("%_N_{name}_");
            let is_head = |line: &str| line.trim_start().to_ascii_uppercase().starts_with(&head);
            if self.lines.iter().any(|(_, line)| is_head(line)) {
                return format!(
                    "'{name}' is called, and stands behind {head}… in a file of several programs: \
                     write each into a file of its own, and name it under path.program.files"
                );
            }
            format!(
                "'{name}' calls a subprogram or a cycle that is not read, or is not understood; a \
                 subprogram is read where path.program.files names its file"
            )
        })?;
        let lines = self.lines.get(first..self.files.around(first).end).unwrap_or_default();
        let given = by_value::given(name, inside, lines, &self.parameters)?;
        if !given.is_empty() && repeats != 1.0 {
            return Err(format!("{name}: P beside parameters is not supported"));
        }
        // Whole and in 0..=9999, checked above.
        self.enter(first, repeats as u32, Some(HashMap::new()), false)?;
        given.into_iter().try_for_each(|(key, value)| self.parameters.set(key, value, None))
    }

    /// M97 of Haas: from N `number` of the program that runs, to its M99.
    pub(super) fn call_line(&mut self, number: f64, repeats: f64) -> Result<(), String> {
        if !(0.0..=9999.0).contains(&repeats) || repeats.fract() != 0.0 {
            return Err(format!("M97 runs {repeats} times: expected a whole number"));
        }
        let first = self.target(number)?;
        // Whole and in 0..=9999, checked above.
        self.enter(first, repeats as u32, None, false)
    }

    pub(super) fn enter(
        &mut self,
        first: usize,
        repeats: u32,
        locals: Option<HashMap<i64, f64>>,
        is_macro: bool,
    ) -> Result<(), String> {
        if self.calls.len() >= MAX_CALLS {
            return Err("calls are nested too deep".to_owned());
        }
        if repeats == 0 {
            return Ok(());
        }
        let kept = locals.map(|locals| self.parameters.enter(locals, is_macro));
        self.calls.push(Call { back: self.next, first, repeats, kept, by: self.running });
        self.next = first;
        Ok(())
    }

    /// The first line of a program by that of its head, behind which there may be words.
    fn first_of(&self, line: usize) -> usize {
        let has_words = self.heads.get(&line).is_some_and(|head| head.has_words);
        if has_words { line } else { line + 1 }
    }

    /// Whether the line directs the flow; then it is done.
    pub(super) fn control(&mut self, content: &str, line: usize) -> Result<bool, String> {
        if self.is_sinumerik {
            return self.structured(content, line);
        }
        let content = stripped(content);
        let is_head = |head: &&Head| !head.may_be_block() || self.called.contains(&head.number);
        let head = self.heads.get(&line).filter(is_head).copied();
        if let Err(what) = self.running.goes_on(content, head) {
            self.ended = true;
            return Err(what);
        }
        match content.as_bytes().first() {
            Some(b'O' | b'o') => {
                let own = o_word(content).map(Ok);
                let own = own.or_else(|| computed(content, &self.parameters).transpose());
                let Some((label, keyword, rest)) = own.transpose()? else { return Ok(false) };
                nothing_behind(&keyword, content.get(rest..).unwrap_or(""))?;
                let here = OWord { line, label, keyword };
                self.o_statement(&here, Behind { content, rest })?;
                Ok(true)
            }
            Some(b'I' | b'i' | b'W' | b'w' | b'E' | b'e' | b'G' | b'g' | b'T' | b't') => {
                self.fanuc(content, line)
            }
            _ => Ok(false),
        }
    }

    fn fanuc(&mut self, content: &str, line: usize) -> Result<bool, String> {
        let keyword = keyword(content);
        match keyword {
            "IF" => {
                let (truth, rest) =
                    self.condition(content, 2).inspect_err(|_| self.lose_behind_then(content))?;
                let rest = content.get(rest..).unwrap_or("").trim_start();
                let words = rest.split('(').next().unwrap_or(rest).to_ascii_uppercase();
                if words.contains("ELSE") {
                    return Err("ELSE in the block of its IF is not supported".to_owned());
                }
                let behind = rest.get(letters(rest)..).unwrap_or("").trim_start();
                match (self::keyword(rest), self::keyword(behind)) {
                    ("GOTO", _) => self.jump(rest, truth).map(|()| true),
                    ("THEN", "GOTO") => self.jump(behind, truth).map(|()| true),
                    ("THEN", _) if truth => self.assign(behind).map(|()| true),
                    ("THEN", _) => Ok(true),
                    _ => Err("'IF' is understood with [ ], GOTO and THEN alone".to_owned()),
                }
            }
            "GOTO" => self.jump(content, true).map(|()| true),
            "WHILE" => {
                let condition = self.condition(content, letters(content));
                let end = self.loops.iter().find(|(from, _)| *from == line);
                let (_, end) = *end.ok_or("WHILE without DO and END of its number")?;
                let truth = condition.and_then(|(truth, behind)| {
                    let behind = content.get(behind..).unwrap_or("").trim_start();
                    match self::keyword(behind) {
                        "DO" => self.nothing_behind_number(behind).map(|()| truth),
                        _ => Err(format!("'{behind}' stands where DO is expected")),
                    }
                });
                self.enter_loop(truth, end + 1).map(|()| true)
            }
            "END" => {
                let from = self.loops.iter().find(|(_, end)| *end == line);
                let (from, _) = *from.ok_or("END without WHILE of its number")?;
                self.nothing_behind_number(content)?;
                self.next = from;
                Ok(true)
            }
            "THEN" | "ELSE" | "ENDIF" | "GOTOF" | "GOTOB" | "ENDWHILE" => Err(format!(
                "'{keyword}': conditions, jumps and loops of this kind are not supported here"
            )),
            _ => Ok(false),
        }
    }

    /// At the head of a loop: past its body where the condition is false, or not known, so that it
    /// is told once.
    pub(super) fn enter_loop(
        &mut self,
        truth: Result<bool, String>,
        behind: usize,
    ) -> Result<(), String> {
        if truth != Ok(true) {
            self.next = behind;
        }
        truth.map(|_| ())
    }

    /// `#1 = 5`, behind THEN.
    fn assign(&mut self, text: &str) -> Result<(), String> {
        let mut block = super::block::Block::default();
        let parsed = super::block::parse(text, None, &mut block, &self.parameters);
        let is_one = block.words.is_empty() && !block.sets.is_empty();
        self.sets = block.sets;
        match parsed {
            Ok(()) if !is_one => Err("behind THEN stands one assignment to a parameter".to_owned()),
            other => other,
        }
    }

    /// What an assignment behind THEN sets is not known where its condition is not.
    fn lose_behind_then(&mut self, content: &str) {
        let behind = content.match_indices(']').map(|(at, _)| content[at + 1..].trim_start());
        if let Some(then) = behind.into_iter().find(|behind| keyword(behind) == "THEN") {
            // The condition's fault is told.
            let _ = self.assign(then.get(letters(then)..).unwrap_or("").trim_start());
        }
    }

    /// The truth of `[…]` at a place, and where it ends.
    pub(super) fn condition(&self, content: &str, at: usize) -> Result<(bool, usize), String> {
        let mut reader = Reader::new(content.as_bytes(), at, &self.parameters);
        if reader.peek() != Some(b'[') {
            return Err(format!(
                "'{}': a condition must stand in [ ]; Sinumerik's without is not supported",
                keyword(content)
            ));
        }
        Ok((reader.value()? != 0.0, reader.at))
    }

    /// Whether `DO n` and `END n` stand alone.
    fn nothing_behind_number(&self, content: &str) -> Result<(), String> {
        let (word, rest) = content.split_at(letters(content));
        let behind = rest.trim_start().trim_start_matches(|c: char| c.is_ascii_digit());
        let mut reader = Reader::new(behind.as_bytes(), 0, &self.parameters).with_comments();
        if reader.peek().is_none_or(|next| next == b';') {
            return Ok(());
        }
        let behind = behind.trim();
        Err(format!("'{behind}' behind {word} is not read; write it in a block of its own"))
    }

    /// `GOTO n`: to the line with N n, if it `is_made`.
    fn jump(&mut self, content: &str, is_made: bool) -> Result<(), String> {
        let own = letters(content);
        let reader = Reader::new(content.as_bytes(), own, &self.parameters);
        let mut reader = if self.is_sinumerik { reader } else { reader.with_comments() };
        let is_cut = own < "GOTO".len();
        let hint = if is_cut { "; GO is short for GOTO: for G0 write the digit" } else { "" };
        let number = reader.expression().map_err(|why| format!("{why}{hint}"));
        let number = match number {
            Err(_) if !is_made => return Ok(()),
            number => number?,
        };
        if reader.peek().is_some_and(|next| next != b';') {
            let rest = content.get(reader.at..).unwrap_or("").trim();
            return Err(format!("'{rest}' behind the target of GOTO is not read{hint}"));
        }
        if is_made { self.jump_to(not_vacant(number)?) } else { Ok(()) }
    }

    /// To N n of the program that runs: forward, then from its head.
    fn jump_to(&mut self, number: f64) -> Result<(), String> {
        self.next = self.target(number)?;
        Ok(())
    }

    fn target(&self, number: f64) -> Result<usize, String> {
        let here = self.next.saturating_sub(1);
        let heads = || self.programs.values().copied();
        let file = self.files.around(here);
        let head = heads().filter(|head| *head <= here).max().unwrap_or(0).max(file.start);
        let end = heads().filter(|head| *head > here).min().unwrap_or(file.end).min(file.end);
        let number = number as i64;
        let first = |lines| within(self.numbered(number), lines).first().copied();
        let target = first(self.next..end).or_else(|| first(head..self.next));
        target.ok_or_else(|| format!("there is no N{number} in this program"))
    }

    /// The lines that have a block number, in order.
    pub(super) fn numbered(&self, number: i64) -> &[usize] {
        self.numbers.get(&number).map_or(&[], Vec::as_slice)
    }
}

/// How many letters a line begins with.
fn letters(line: &str) -> usize {
    line.bytes().take_while(u8::is_ascii_alphabetic).count()
}

/// The keyword that a line begins with; empty where there is none.
fn keyword(line: &str) -> &'static str {
    const KEYWORDS: [&str; 11] =
        ["IF", "THEN", "ELSE", "ENDIF", "WHILE", "ENDWHILE", "END", "GOTO", "GOTOF", "GOTOB", "DO"];
    let word = line.get(..letters(line)).unwrap_or("").to_ascii_uppercase();
    let find = |word: &str| KEYWORDS.into_iter().find(|known| *known == word);
    find(&word).or_else(|| find(whole(&word))).unwrap_or("")
}

/// The name of a program of Sinumerik's without its directory and what the control puts round it,
/// `/_N_SPF_DIR/_N_SLOT_SPF`.
fn own_name(name: &str) -> &str {
    let name = name.rsplit('/').next().unwrap_or(name);
    let inner = name.strip_prefix("_N_").unwrap_or(name);
    let ends = |end: &str| inner.strip_suffix(end).filter(|_| inner.len() < name.len());
    ends("_SPF").or_else(|| ends("_MPF")).unwrap_or(name)
}

fn leading_number(text: &str) -> Option<i64> {
    let text = text.trim_start();
    let length = text.bytes().take_while(u8::is_ascii_digit).count();
    text.get(..length)?.parse().ok()
}
