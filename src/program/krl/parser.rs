//! Lines of KRL → routines and data lists. A statement that is not understood is kept as such, so
//! that it is a fault only where the program reaches it.

use std::collections::{HashMap, HashSet};

use super::cursor::{Cursor, MAX_DEPTH};
use super::lexer::Kind;
use super::lines::{Line, lines};
use super::modules::rename;
use super::signals::Outputs;
use super::syntax::{
    Block, Cases, Expr, File, Motion, Parameter, Path, Routine, Statement, Way, What,
};
use super::value::Type;
use super::words::{fills, is_harmless_keyword, is_predefined_type};
use crate::wording::counted;

const DISPLAY: &str = "this is what the pendant shows of an inline form, without its code: take \
                       the .src file from the controller, where the code stands in folds (BAS and \
                       the data of a move, $OUT[n]=… of an output)";

/// Parses a file into `file`; the routines of the main one, number 0, may be where the program
/// starts. `names` are those that stand for others in it.
pub(super) fn parse(text: &str, file: &mut File, number: usize, names: &HashMap<String, String>) {
    let is_main = number == 0;
    let mut lines = lines(text, is_main);
    for tokens in lines.iter_mut().filter_map(|line| line.tokens.as_mut().ok()) {
        rename(tokens, names);
    }
    let mut parser = Parser {
        lines,
        file: number,
        at: 0,
        depth: 0,
        count: 0,
        signals: Vec::new(),
        components: Vec::new(),
        constants: HashSet::new(),
    };
    while let Some(line) = parser.lines.get(parser.at) {
        let number = line.number;
        match line.first() {
            "def" | "deffct" => {
                let is_function = line.first() == "deffct";
                let routine = parser.routine(is_function);
                match routine {
                    Some((key, routine, is_whole)) => {
                        if !is_whole {
                            file.is_cut.get_or_insert(number);
                        }
                        if is_function {
                            file.functions.entry(key).or_insert(routine);
                        } else {
                            if is_main && !file.routines.contains_key(&key) {
                                file.order.push(key.clone());
                            }
                            file.routines.entry(key).or_insert(routine);
                        }
                    }
                    None => parser.at += 1,
                }
            }
            "defdat" => {
                parser.at += 1;
                let (data, is_whole) = parser.block(&["enddat"]);
                if !is_whole {
                    file.is_cut.get_or_insert(number);
                }
                parser.at += 1;
                file.data.extend(data);
            }
            _ => parser.at += 1,
        }
    }
    file.statement_count += parser.count;
    parser.signals.into_iter().for_each(|(name, outputs)| file.signals.add(name, outputs));
    file.constants.extend(parser.constants);
    for (name, declared) in parser.components {
        file.components.entry(name).or_default().push(declared);
    }
}

struct Parser {
    lines: Vec<Line>,
    /// Its number, as statements have it.
    file: usize,
    at: usize,
    depth: usize,
    count: usize,
    signals: Vec<(String, Outputs)>,
    components: Vec<(String, Type)>,
    constants: HashSet<String>,
}

impl Parser {
    /// `DEF name(a :IN, …)` up to `END`; false where the end is missing.
    fn routine(&mut self, is_function: bool) -> Option<(String, Routine, bool)> {
        let line = self.lines.get(self.at)?;
        let number = line.number;
        let mut tokens = line.tokens().iter();
        tokens.by_ref().find(|token| is_word(token, &["def", "deffct"]));
        let mut names = tokens.by_ref().filter_map(|token| match token {
            Kind::Word(word) => Some(word),
            _ => None,
        });
        let gives = if is_function { Some(Type::named(names.next()?)) } else { None };
        let key = names.next()?.clone();
        let mut parameters: Vec<Parameter> = Vec::new();
        let mut is_behind_colon = false;
        for token in tokens {
            match token {
                Kind::Word(word) if is_behind_colon => {
                    if let Some(last) = parameters.last_mut() {
                        last.is_by_value = word == "in";
                    }
                }
                Kind::Word(word) => {
                    parameters.push(Parameter { name: word.clone(), is_by_value: false });
                }
                _ => {}
            }
            is_behind_colon = *token == Kind::Symbol(":");
        }
        let shown = line.text.split(['(', ' ', '\t']).find(|word| word.eq_ignore_ascii_case(&key));
        let shown = shown.unwrap_or(&key).to_owned();
        self.at += 1;
        let end: &[&str] = if is_function { &["endfct", "end"] } else { &["end"] };
        let (body, is_whole) = self.block(end);
        self.at += 1;
        let line = if self.file == 0 { number } else { 0 };
        Some((key, Routine { line, shown, parameters, body, gives }, is_whole))
    }

    /// Statements up to a line that begins with one of `ends`, which is left standing; false where
    /// none comes.
    fn block(&mut self, ends: &[&str]) -> (Block, bool) {
        let mut block = Block::new();
        self.depth += 1;
        while let Some(line) = self.lines.get(self.at) {
            let first = line.first();
            if ends.contains(&first) {
                self.depth -= 1;
                return (block, true);
            }
            if matches!(first, "def" | "deffct" | "defdat") {
                break;
            }
            let number = line.number;
            self.count += 1;
            let what = if self.depth > MAX_DEPTH {
                self.at += 1;
                What::NotUnderstood("blocks are nested too deep".to_owned())
            } else {
                self.statement().unwrap_or_else(What::NotUnderstood)
            };
            block.push(Statement { line: number, file: self.file, what });
        }
        self.depth -= 1;
        (block, false)
    }

    /// The block behind the line at hand, and past its end.
    fn body(&mut self, end: &str) -> Result<Block, String> {
        let (body, is_whole) = self.block(&[end]);
        let is_alone = self.lines.get(self.at).is_none_or(|line| line.tokens().len() == 1);
        self.at += 1;
        match is_whole {
            false => Err(format!("{} is missing", end.to_uppercase())),
            true if !is_alone => Err(format!(
                "what stands behind {} in its line is not understood",
                end.to_uppercase()
            )),
            true => Ok(body),
        }
    }

    fn statement(&mut self) -> Result<What, String> {
        let Some(line) = self.lines.get(self.at) else { return Err("the file ends".to_owned()) };
        let as_shown = is_display(&line.text);
        let tokens = match &line.tokens {
            Ok(tokens) => tokens.clone(),
            Err(why) => {
                let why = if as_shown { DISPLAY.to_owned() } else { why.clone() };
                self.at += 1;
                return Err(why);
            }
        };
        let first = line.first().to_owned();
        let mut cursor = Cursor::new(&tokens);
        self.at += 1;
        match first.as_str() {
            "struc" | "global" if tokens.iter().take(2).any(|token| is_word(token, &["struc"])) => {
                self.components.extend(components(&tokens));
                Ok(What::Call("struc".to_owned(), Vec::new()))
            }
            // `GLOBAL INT N`.
            "decl" | "global" => {
                let what = cursor.declaration()?;
                if let What::Declare(_, paths, _) = &what
                    && tokens.iter().any(|token| is_word(token, &["const"]))
                {
                    self.constants.extend(paths.iter().map(|path| path.name.clone()));
                }
                cursor.ended(what)
            }
            "if" => {
                let condition = cursor.behind(1)?.expression()?;
                self.if_statement(condition)
            }
            "for" => {
                let cursor = cursor.behind(1)?;
                let variable = cursor.path()?;
                cursor.symbol("=")?;
                let from = cursor.expression()?;
                cursor.word("to")?;
                let to = cursor.expression()?;
                let step = if cursor.take_word("step") { Some(cursor.expression()?) } else { None };
                let body = self.body("endfor")?;
                cursor.ended(What::For(variable, [from, to], step, body))
            }
            "while" => {
                let condition = cursor.behind(1)?.expression()?;
                let body = self.body("endwhile")?;
                cursor.ended(What::While(condition, body))
            }
            "loop" => {
                let body = self.body("endloop")?;
                cursor.behind(1)?.ended(What::Loop(body))
            }
            "repeat" => {
                let (body, is_whole) = self.block(&["until"]);
                let until = self.lines.get(self.at).map(|line| line.tokens().to_vec());
                self.at += 1;
                let until = until.filter(|_| is_whole).ok_or("UNTIL is missing")?;
                let mut cursor = Cursor::new(&until);
                let condition = cursor.behind(1)?.expression()?;
                cursor.ended(What::Repeat(body, condition))
            }
            "switch" => {
                let tested = cursor.behind(1)?.expression()?;
                self.switch(tested)
            }
            "spline" => {
                let with = cursor.behind(1)?.with()?;
                let body = self.body("endspline")?;
                cursor.ended(What::Spline(with, body))
            }
            "ptp_spline" => {
                self.body("endspline")?;
                Err("PTP_SPLINE is not supported".to_owned())
            }
            "return" => {
                let cursor = cursor.behind(1)?;
                let value = if cursor.is_end() { None } else { Some(cursor.expression()?) };
                cursor.ended(What::Return(value))
            }
            "interrupt" => interrupt(&tokens),
            "trigger" => Ok(What::Trigger(action(&tokens))),
            "exit" => Ok(What::Exit),
            "halt" => Ok(What::Halt),
            "goto" => {
                let label = cursor.behind(1)?.name()?;
                cursor.ended(What::Goto(label))
            }
            "wait" => {
                cursor.behind(1)?;
                if cursor.take_word("sec") {
                    let seconds = cursor.expression()?;
                    return cursor.ended(What::WaitSec(seconds));
                }
                // A condition that is not understood says nothing.
                let condition = cursor.take_word("for").then(|| cursor.expression().ok());
                let condition = condition.flatten().into_iter().map(Some).collect();
                Ok(What::Call("wait for".to_owned(), condition))
            }
            "ptp" | "lin" | "circ" | "sptp" | "slin" | "scirc" | "spl" | "ptp_rel" | "lin_rel"
            | "circ_rel" | "sptp_rel" | "slin_rel" | "scirc_rel" | "spl_rel" => {
                let found = cursor.behind(1)?.motion(&first);
                found.map_err(|why| if as_shown { DISPLAY.to_owned() } else { why })
            }
            "resume" | "brake" | "time_block" => {
                Err(format!("{}: is not supported", first.to_uppercase()))
            }
            // What it sets is not known behind it.
            "pulse" => cursor.other(),
            // What they name they may set or fill in.
            word if word == "anout" || fills(word) && is_harmless_keyword(word) => {
                let names = tokens.iter().skip(1).filter_map(|token| match token {
                    Kind::Word(word) => Some(Some(Expr::of_name(word))),
                    _ => None,
                });
                Ok(What::Call(first.clone(), names.collect()))
            }
            "signal" => {
                self.signals.extend(Outputs::named(&tokens));
                Ok(What::Call(first.clone(), Vec::new()))
            }
            word if is_harmless_keyword(word) => Ok(What::Call(first.clone(), Vec::new())),
            _ if as_shown => Err(DISPLAY.to_owned()),
            _ => {
                let what = cursor.other()?;
                cursor.ended(what)
            }
        }
    }

    fn if_statement(&mut self, condition: Expr) -> Result<What, String> {
        let (yes, is_whole) = self.block(&["else", "endif", "elseif", "elsif"]);
        if !is_whole {
            return Err("ENDIF is missing".to_owned());
        }
        // Whichever branch runs, a line that KRL does not have leaves open what the others are.
        let is_end = |line: &&Line| line.first() == "endif";
        if let Some(line) = self.lines.get(self.at).filter(|line| !is_end(line)) {
            let is_else = line.first() == "else" && line.tokens().len() == 1;
            let written = line.text.clone();
            self.at += 1;
            let no = self.body("endif")?;
            return match is_else {
                true => Ok(What::If(condition, yes, no)),
                false => Err(format!("its '{}' is not understood", written.trim())),
            };
        }
        self.at += 1;
        Ok(What::If(condition, yes, Block::new()))
    }

    fn switch(&mut self, tested: Expr) -> Result<What, String> {
        let ends = ["case", "default", "endswitch"];
        let (mut cases, mut otherwise) = (Cases::new(), Block::new());
        let (before, _) = self.block(&ends);
        if !before.is_empty() {
            return Err("a statement before the first CASE".to_owned());
        }
        loop {
            let Some(line) = self.lines.get(self.at) else {
                return Err("ENDSWITCH is missing".to_owned());
            };
            let (first, tokens) = (line.first().to_owned(), line.tokens().to_vec());
            self.at += 1;
            match first.as_str() {
                "case" => {
                    let mut cursor = Cursor::new(&tokens);
                    cursor.behind(1)?;
                    let mut values = vec![cursor.expression()?];
                    while cursor.take(",") {
                        values.push(cursor.expression()?);
                    }
                    cases.push((values, self.block(&ends).0));
                }
                "default" => otherwise = self.block(&ends).0,
                "endswitch" => return Ok(What::Switch(tested, cases, otherwise)),
                _ => return Err("ENDSWITCH is missing".to_owned()),
            }
        }
    }
}

/// `PTP P1 Vel=80 % PDAT1 Tool[1]`, `OUT 1 'grip' State=TRUE`: what the pendant shows of an inline
/// form.
fn is_display(text: &str) -> bool {
    let text = text.split(';').next().unwrap_or("").to_ascii_lowercase();
    let mut words = text.split_whitespace();
    let states = match words.next() {
        Some("ptp" | "lin" | "circ" | "sptp" | "slin" | "scirc") => "vel=",
        Some("out" | "syn" | "pulse") => "state=",
        _ => return false,
    };
    // `OUT = STATE==1` compares.
    words.any(|word| word.strip_prefix(states).is_some_and(|rest| !rest.starts_with('=')))
}

fn is_word(token: &Kind, words: &[&str]) -> bool {
    matches!(token, Kind::Word(word) if words.contains(&word.as_str()))
}

/// The components of `[GLOBAL] STRUC T1 FRAME F,G[3],INT K`, with their types.
fn components(tokens: &[Kind]) -> Vec<(String, Type)> {
    let behind = tokens.iter().skip_while(|token| !is_word(token, &["struc"])).skip(2);
    let behind: Vec<&Kind> = behind.collect();
    let (mut found, mut declared) = (Vec::new(), Type::Other);
    for part in behind.split(|token| **token == Kind::Symbol(",")) {
        let name = match part {
            [Kind::Word(own), Kind::Word(name), ..] => {
                declared = Type::named(own);
                name
            }
            [Kind::Word(name), ..] => name,
            // The second number of an array.
            _ => continue,
        };
        // Data of that name may have another in this file, which no component has.
        let name = name.split(' ').next().unwrap_or(name);
        found.push((name.to_owned(), declared));
    }
    found
}

/// `[GLOBAL] INTERRUPT DECL n WHEN … DO …`, `INTERRUPT ON n`, `INTERRUPT OFF n`.
fn interrupt(tokens: &[Kind]) -> Result<What, String> {
    let at = tokens.iter().position(|token| is_word(token, &["interrupt"])).unwrap_or(0);
    let mut cursor = Cursor::new(tokens);
    let cursor = cursor.behind(at + 1)?;
    if cursor.take_word("decl") {
        return Ok(What::InterruptDecl(cursor.expression()?, action(tokens)));
    }
    for (word, of) in
        [("on", What::InterruptOn as fn(Option<Expr>) -> What), ("off", What::InterruptOff)]
    {
        if cursor.take_word(word) {
            let number = if cursor.is_end() { None } else { Some(cursor.expression()?) };
            return Ok(of(number));
        }
    }
    Ok(What::Call("interrupt".to_owned(), Vec::new()))
}

/// What stands behind DO: a call or an assignment; PRIO may follow.
fn action(tokens: &[Kind]) -> Option<Box<What>> {
    let at = tokens.iter().rposition(|token| is_word(token, &["do"]))?;
    let what = Cursor::new(tokens.get(at + 1..)?).other().ok()?;
    matches!(what, What::Call(..) | What::Assign(..)).then(|| Box::new(what))
}

impl Cursor<'_> {
    /// `DECL [GLOBAL] [CONST] type a, b[3] = value`.
    fn declaration(&mut self) -> Result<What, String> {
        while ["global", "decl", "const", "public"].iter().any(|word| self.take_word(word)) {}
        let declared = Type::named(&self.name()?);
        let mut paths = vec![self.path()?];
        while self.take(",") {
            paths.push(self.path()?);
        }
        let value = if self.take("=") { Some(self.expression()?) } else { None };
        if value.is_some() && self.peek() == Some(&Kind::Symbol(",")) {
            return Err("a declaration that gives a value is of one variable alone: write a line \
                        for each"
                .to_owned());
        }
        Ok(What::Declare(declared, paths, value))
    }

    /// What was read, where nothing stands behind it.
    fn ended(&self, what: What) -> Result<What, String> {
        if self.is_end() { Ok(what) } else { Err("is not understood".to_owned()) }
    }

    /// An assignment, a call, a label or a declaration without DECL.
    fn other(&mut self) -> Result<What, String> {
        let start = self.at;
        if let (Some(Kind::Word(word)), Some(Kind::Word(_))) =
            (self.tokens.first(), self.tokens.get(1))
        {
            if !is_predefined_type(word) {
                return Err(format!(
                    "{} is no statement that is read, and no type that needs no DECL",
                    word.to_uppercase()
                ));
            }
            return self.declaration();
        }
        let path = self.path()?;
        if self.take("=") {
            return Ok(What::Assign(path, self.expression()?));
        }
        if self.take("(") {
            return Ok(What::Call(path.name, self.arguments()?));
        }
        if self.take(":") && self.is_end() {
            return Ok(What::Label(path.name));
        }
        if self.is_end() && path.indices.is_empty() && path.fields.is_empty() && start == 0 {
            return Ok(What::Call(path.name, Vec::new()));
        }
        Err("is not understood".to_owned())
    }

    /// `WITH $VEL.CP=0.1, $TOOL=…`, if it is there.
    fn with(&mut self) -> Result<Vec<(Path, Expr)>, String> {
        let mut found = Vec::new();
        if self.take_word("with") {
            loop {
                let path = self.path()?;
                self.symbol("=")?;
                found.push((path, self.expression()?));
                if !self.take(",") {
                    break;
                }
            }
        }
        Ok(found)
    }

    fn motion(&mut self, word: &str) -> Result<What, String> {
        let (kind, is_relative) = match word.strip_suffix("_rel") {
            Some(kind) => (kind, true),
            None => (word, false),
        };
        let way = match kind {
            "ptp" | "sptp" => Way::Joint,
            "lin" | "slin" => Way::Linear,
            "spl" => Way::Spline,
            _ => Way::Circular,
        };
        let mut targets = vec![self.expression()?];
        let mut angle = None;
        while self.take(",") {
            if self.take_word("ca") {
                angle = Some(self.expression()?);
            } else {
                targets.push(self.expression()?);
            }
        }
        let mut with = Vec::new();
        let mut is_of_tool = false;
        while !self.is_end() {
            match self.peek() {
                Some(Kind::Word(word)) if word == "with" => with.extend(self.with()?),
                // How corners are rounded.
                Some(Kind::Word(word))
                    if matches!(
                        word.as_str(),
                        "c_ptp" | "c_dis" | "c_vel" | "c_ori" | "c_spl" | "c_lin"
                    ) =>
                {
                    self.at += 1;
                }
                Some(Kind::Word(word)) if word == "ca" => {
                    self.at += 1;
                    angle = Some(self.expression()?);
                }
                Some(Kind::Symbol(",")) => self.at += 1,
                // What a relative motion is relative to, and so it is without the word.
                Some(Kind::Enum(name)) if is_relative && name == "base" => self.at += 1,
                Some(Kind::Enum(name)) if is_relative && name == "tool" => {
                    if way == Way::Joint {
                        return Err("PTP_REL relative to the tool (#TOOL) is not supported".into());
                    }
                    (self.at, is_of_tool) = (self.at + 1, true);
                }
                _ => return Err("what stands behind the target is not understood".to_owned()),
            }
        }
        let wanted = if way == Way::Circular { 2 } else { 1 };
        if targets.len() != wanted {
            return Err(format!("expected {}, found {}", counted(wanted, "target"), targets.len()));
        }
        Ok(What::Move(Box::new(Motion { way, is_relative, is_of_tool, targets, angle, with })))
    }
}
