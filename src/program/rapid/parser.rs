//! Tokens → the modules' data and routines. A statement that is not understood is kept as such, so
//! that it is a fault only where the program reaches it.

use std::collections::HashSet;
use std::rc::Rc;

use super::by_name;
use super::cursor::{Cursor, Parsed};
use super::filled::fills;
use super::instructions::is_ignored;
use super::lexer::Kind;
use super::modules::{Names, Renamed, names};
use super::syntax::{
    Args, Block, Declaration, Expr, File, Name, Optional, Parameter, Routine, Statement, There,
    Trap, What, place_of,
};
use super::twice::{self, is_of_both};
use crate::notes::Code;
use crate::program::Settings;
use crate::program::cell::named_by_job;
use crate::program::log::Log;

/// Blocks in blocks beyond this are no program that a person or a post-processor writes.
const MAX_BLOCK_DEPTH: usize = 40;

/// Words that only end or part what has begun; no procedure has such a name.
const ENDS: [&str; 9] =
    ["ELSEIF", "ELSE", "ENDIF", "ENDFOR", "ENDWHILE", "ENDTEST", "CASE", "DEFAULT", "THEN"];

const CUT: &str = "the file is cut off; export it again";

/// The modules of the main file and of the others of the program.
pub(super) fn parse(text: &str, settings: &Settings, log: &mut Log) -> File {
    let mut file = File::default();
    let others = &settings.companions;
    let all: Vec<&str> =
        [text].into_iter().chain(others.iter().map(|other| other.text.as_str())).collect();
    let entry = settings.procedure.as_deref().unwrap_or("main").to_lowercase();
    let names = &names(&all, &named_by_job(settings), &entry);
    let texts = others.iter().map(|other| (other.text.as_str(), Some(other.name.as_str())));
    for (index, (text, name)) in [(text, None)].into_iter().chain(texts).enumerate() {
        let cursor = Cursor::new(text, index, &names.renamed);
        let (fault, open) = (None, None);
        let name = name.map(Rc::from);
        let [is_of_task, is_local] = [false; 2];
        let mut parser =
            Parser { cursor, file, depth: 0, name, names, open, is_of_task, is_local, fault };
        while parser.cursor.peek().is_some() {
            parser.top_level(log);
        }
        parser.close_module(log);
        file = parser.file;
    }
    declare_registers(&mut file);
    file
}

/// The arguments of a procedure, each as the program would write it.
pub(super) fn arguments(texts: &[String]) -> Parsed<Vec<Expr>> {
    let none = Renamed::new();
    let parsed = texts.iter().map(|text| {
        let mut cursor = Cursor::new(text, 1, &none);
        let expr = cursor.expression()?;
        match cursor.peek() {
            None => Ok(expr),
            Some(_) => Err(format!("'{text}' is no argument")),
        }
    });
    parsed.collect()
}

/// Every controller has num data reg1…reg5, which programs use without declaring them.
fn declare_registers(file: &mut File) {
    for shown in ["reg1", "reg2", "reg3", "reg4", "reg5"] {
        let name = Name::new(shown);
        file.data.entry(name.key.clone()).or_insert_with(|| Declaration {
            line: 1,
            is_persistent: false,
            is_of_task: false,
            is_local: false,
            is_constant: false,
            kind: "num".to_owned(),
            name,
            dimensions: Vec::new(),
            value: None,
        });
    }
}

struct Parser<'a> {
    cursor: Cursor<'a>,
    file: File,
    depth: usize,
    /// Of a file that is not the main one.
    name: Option<Rc<str>>,
    names: &'a Names,
    /// The module that has begun.
    open: Option<Name>,
    /// Whether TASK stands before the declaration.
    is_of_task: bool,
    /// Whether LOCAL does.
    is_local: bool,
    /// The first number of the routine that runs into a word, by its line: what the parser expects
    /// behind it says little.
    fault: Option<(usize, String)>,
}

impl<'a> Parser<'a> {
    fn top_level(&mut self, log: &mut Log) {
        let line = self.cursor.line();
        let is_local = std::mem::take(&mut self.is_local);
        self.fault = None;
        if self.cursor.is_word("MODULE") {
            self.close_module(log);
            self.cursor.advance();
            let named = self.module_head();
            self.report(named, line, log);
        } else if self.cursor.take_word("TASK") {
            self.is_of_task = true;
        } else if self.cursor.take_word("ENDMODULE") {
            self.open = None;
        } else if self.cursor.take_word("LOCAL") {
            self.is_local = true;
        } else if self.cursor.is_any_word(&["CONST", "PERS", "VAR"]) {
            match self.declaration() {
                Ok(own) => self.keep_declaration(Declaration { is_local, ..own }, line, log),
                Err(what) => self.report(Err(what), line, log),
            }
        } else if self.cursor.take_word("PROC") {
            let routine = self.routine("ENDPROC", false);
            match routine {
                Ok(routine) => self.keep_procedure(routine, log),
                Err(what) => self.report(Err(what), line, log),
            }
        } else if self.cursor.take_word("FUNC") {
            match self.routine("ENDFUNC", true) {
                Ok(routine) => self.keep_function(routine, log),
                Err(what) => self.report(Err(what), line, log),
            }
        } else if self.cursor.take_word("TRAP") {
            match self.trap() {
                Ok(trap) => self.file.traps.push(trap),
                Err(what) => self.report(Err(what), line, log),
            }
        } else if self.cursor.take_word("RECORD") {
            let record = self.record();
            self.report(record, line, log);
        } else if self.cursor.take_word("ALIAS") {
            self.cursor.skip_statement();
        } else {
            let what = self.cursor.expected("MODULE, PROC or a declaration");
            self.report(Err(what), line, log);
            self.cursor.advance();
        }
    }

    fn report(&mut self, parsed: Parsed<()>, line: usize, log: &mut Log) {
        if let Err(what) = parsed {
            let line = self.cursor.line().max(line);
            let is_cut = self.cursor.peek().is_none() && self.open.take().is_some();
            let what = if is_cut { format!("{what}: {CUT}") } else { what };
            let (line, what) = self.fault.take().unwrap_or((line, what));
            self.tell(line, what, log);
            self.cursor.skip_statement();
        }
    }

    fn tell(&self, line: usize, what: String, log: &mut Log) {
        let there = self.there(line);
        let line = if there.is_some() { 1 } else { line };
        log.error(Code::Syntax, line, format!("{}{what}", place_of(there.as_ref())));
    }

    /// A line of a file that is not the main one.
    fn there(&self, line: usize) -> Option<There> {
        self.name.clone().map(|name| (name, line))
    }

    /// A module without an end: where the file ends, too, it was cut off.
    fn close_module(&mut self, log: &mut Log) {
        if let Some(open) = self.open.take() {
            let what = self.cursor.expected(&format!("ENDMODULE of '{}'", open.shown));
            let what = match self.cursor.peek() {
                None => format!("{what}: {CUT}"),
                Some(_) => what,
            };
            self.tell(self.cursor.line(), what, log);
        }
    }

    /// Line of the next token; none in a file that is not the main one.
    fn line(&self) -> usize {
        if self.name.is_some() { 0 } else { self.cursor.line() }
    }

    fn module_head(&mut self) -> Parsed<()> {
        let module = self.cursor.name()?;
        self.cursor.enter(&module);
        self.open = Some(module);
        if self.cursor.take_symbol("(") {
            self.cursor.list(")")?;
        }
        Ok(())
    }

    /// `line`: where it begins in its file.
    fn keep_declaration(&mut self, declaration: Declaration, line: usize, log: &mut Log) {
        let key = declaration.name.key.clone();
        let here = self.name.as_ref().map(|name| format!("{name}:{line}"));
        let first_place = self.file.places.remove(&key);
        let kept = match self.file.data.remove(&key) {
            Some(first) if is_of_both(&first, &declaration) => {
                self.file.shared.insert(key.clone());
                if first.value.is_some() { first } else { declaration }
            }
            Some(first) => {
                let is_tasks =
                    [&first, &declaration].iter().all(|own| own.is_persistent && !own.is_of_task)
                        && self.name.is_some();
                let shown = format!("'{}'", declaration.name.shown);
                let places = [(first.line, first_place), (line, here.clone())];
                twice::tell(&shown, places, twice::help(self.names.loads, is_tasks), log);
                declaration
            }
            None => declaration,
        };
        self.file.places.extend(here.map(|here| (key.clone(), here)));
        self.file.data.insert(key, kept);
    }

    fn keep_procedure(&mut self, routine: Routine, log: &mut Log) {
        let key = routine.name.key.clone();
        self.file.procedure_order.push(key.clone());
        let help = twice::help(self.names.loads, false);
        let first = self.file.procedures.insert(key.clone(), routine);
        twice::tell_routines(
            "procedure",
            [first.as_ref(), self.file.procedures.get(&key)],
            help,
            log,
        );
    }

    fn keep_function(&mut self, routine: Routine, log: &mut Log) {
        let key = routine.name.key.clone();
        let help = twice::help(self.names.loads, false);
        let first = self.file.functions.insert(key.clone(), routine);
        twice::tell_routines(
            "function",
            [first.as_ref(), self.file.functions.get(&key)],
            help,
            log,
        );
    }

    fn record(&mut self) -> Parsed<()> {
        let Name { key: name, shown } = self.cursor.name()?;
        let mut fields = Vec::new();
        while !self.cursor.take_word("ENDRECORD") {
            let kind = self.cursor.name()?.key;
            let field = self.cursor.own_name(false)?.key;
            self.cursor.symbol(";")?;
            fields.push((field, kind));
        }
        match self.file.records.insert(name, fields) {
            Some(_) => Err(format!("record '{shown}' is declared twice")),
            None => Ok(()),
        }
    }

    /// `CONST robtarget p{2}:=…;`, from the storage class on.
    fn declaration(&mut self) -> Parsed<Declaration> {
        let line = self.line();
        let is_of_task = std::mem::take(&mut self.is_of_task);
        let [is_persistent, is_constant] = ["PERS", "CONST"].map(|word| self.cursor.is_word(word));
        self.cursor.advance();
        let kind = self.cursor.name()?.key;
        let name = if self.depth > 0 { self.cursor.own_name(true)? } else { self.cursor.name()? };
        let dimensions =
            if self.cursor.take_symbol("{") { self.cursor.list("}")? } else { Vec::new() };
        let value =
            if self.cursor.take_symbol(":=") { Some(self.cursor.expression()?) } else { None };
        self.cursor.symbol(";")?;
        Ok(Declaration {
            line,
            is_persistent,
            is_of_task,
            is_local: false,
            is_constant,
            kind,
            name,
            dimensions,
            value,
        })
    }

    fn routine(&mut self, end: &str, typed: bool) -> Parsed<Routine> {
        let (line, there) = (self.line(), self.there(self.cursor.line()));
        if typed {
            self.cursor.name()?;
        }
        let name = self.cursor.name()?;
        self.cursor.enter_routine();
        self.cursor.symbol("(")?;
        let parameters = self.parameters()?;
        let mut body = Vec::new();
        let ends = [end, "ERROR", "UNDO", "BACKWARD"];
        while !self.cursor.is_any_word(&ends) {
            if self.is_past_routine() {
                return Err(self.cursor.expected(&format!("{end} of '{}'", name.shown)));
            }
            self.statement_or_stray(&mut body);
        }
        // Handlers of errors do not run when nothing goes wrong.
        let (before, handlers_from) = (self.cursor.clone(), self.line());
        let (end, in_handlers) = self.skip_past(end, &name)?;
        let handlers = self.handlers(before);
        let module = self.cursor.module().to_owned();
        Ok(Routine {
            line,
            there,
            end,
            in_handlers,
            handlers,
            handlers_from,
            name,
            module,
            parameters,
            body,
        })
    }

    /// A trap runs when its interrupt comes, and so do its handlers of errors.
    fn trap(&mut self) -> Parsed<Trap> {
        let (line, there) = (self.line(), self.there(self.cursor.line()));
        let name = self.cursor.name()?;
        self.cursor.enter_routine();
        let mut body = Vec::new();
        while !self.cursor.take_word("ENDTRAP") {
            if self.cursor.is_any_word(&["ERROR", "UNDO", "BACKWARD"]) {
                self.cursor.advance();
                if self.cursor.take_symbol("(") {
                    self.cursor.list(")")?;
                }
                continue;
            }
            if self.is_past_routine() {
                return Err(self.cursor.expected(&format!("ENDTRAP of '{}'", name.shown)));
            }
            self.statement_or_stray(&mut body);
        }
        Ok(Trap { line, there, name, body })
    }

    /// What stands from here up to where the parser is.
    fn handlers(&mut self, from: Cursor<'a>) -> Block {
        let behind = std::mem::replace(&mut self.cursor, from);
        let (count, fault) = (self.file.statement_count, self.fault.clone());
        let mut block = Vec::new();
        while self.cursor.place() + 1 < behind.place() {
            if self.cursor.is_any_word(&["ERROR", "UNDO", "BACKWARD"]) {
                self.cursor.advance();
                if self.cursor.take_symbol("(") && self.cursor.list(")").is_err() {
                    self.cursor.skip_statement();
                }
                continue;
            }
            self.statement_or_stray(&mut block);
        }
        self.cursor = behind;
        (self.file.statement_count, self.fault) = (count, fault);
        block
    }

    /// The line of the end, and the words before it.
    fn skip_past(&mut self, end: &str, of: &Name) -> Parsed<(usize, HashSet<String>)> {
        let mut words = HashSet::new();
        loop {
            let line = self.line();
            if self.cursor.take_word(end) {
                return Ok((line, words));
            }
            if self.is_past_routine() {
                return Err(self.cursor.expected(&format!("{end} of '{}'", of.shown)));
            }
            if let Some(Kind::Word(word) | Kind::Text(word)) = self.cursor.peek() {
                words.insert(word.to_lowercase());
            }
            self.cursor.advance();
        }
    }

    /// Whether something follows that no routine holds.
    fn is_past_routine(&self) -> bool {
        self.cursor.peek().is_none()
            || self.cursor.is_any_word(&["PROC", "FUNC", "TRAP", "ENDMODULE"])
    }

    fn parameters(&mut self) -> Parsed<Vec<Parameter>> {
        let mut parameters = Vec::new();
        let mut optional = false;
        while !self.cursor.take_symbol(")") {
            if self.cursor.take_symbol(",") {
                optional = false;
                continue;
            }
            if self.cursor.take_symbol("\\") {
                optional = true;
            } else if !self.cursor.take_symbol("|") && self.cursor.is_symbol("*") {
                return Err("arrays as parameters are not supported".to_owned());
            }
            let by_reference = self.cursor.is_any_word(&["VAR", "PERS", "INOUT"]);
            if by_reference {
                self.cursor.advance();
            }
            let first = self.cursor.name()?;
            let switch = first.key == "switch";
            let name = self.cursor.own_name(true)?;
            if self.cursor.take_symbol("{") {
                while !self.cursor.take_symbol("}") {
                    if self.cursor.peek().is_none() {
                        return Err(self.cursor.expected("'}'"));
                    }
                    self.cursor.advance();
                }
            }
            let optional = optional || switch;
            parameters.push(Parameter { name, kind: first.key, optional, by_reference });
        }
        Ok(parameters)
    }

    /// A statement, or what stands where none can stand, kept as not understood.
    fn statement_or_stray(&mut self, block: &mut Block) {
        let (mut own_line, start) = (self.cursor.line(), self.cursor.place());
        self.file.statement_count += 1;
        self.depth += 1;
        let parsed = if self.depth > MAX_BLOCK_DEPTH {
            Err("blocks are nested too deep".to_owned())
        } else {
            self.statement()
        };
        self.depth -= 1;
        let what = match parsed {
            Ok(what) => what,
            Err(mut what) => {
                if self.cursor.is_glued() {
                    self.fault.get_or_insert((self.cursor.line(), what.clone()));
                }
                // One in this statement is why it is not understood.
                if let Some(fault) = self.fault.clone().filter(|(line, _)| *line >= own_line) {
                    (own_line, what) = fault;
                }
                self.cursor.skip_statement();
                if self.cursor.place() == start {
                    self.cursor.advance();
                }
                What::NotUnderstood(what)
            }
        };
        let there = self.there(own_line);
        let line = if there.is_some() { 0 } else { own_line };
        block.push(Statement { line, there, what });
    }

    /// Statements up to one of `ends`, which is left standing.
    fn block(&mut self, ends: &[&str]) -> Parsed<Block> {
        let mut block = Vec::new();
        while !self.cursor.is_any_word(ends) {
            if self.cursor.peek().is_none()
                || self.cursor.is_any_word(&[
                    "ENDPROC",
                    "ENDFUNC",
                    "ENDTRAP",
                    "ENDMODULE",
                    "PROC",
                    "FUNC",
                ])
            {
                return Err(self.cursor.expected(ends.last().copied().unwrap_or("the end")));
            }
            self.statement_or_stray(&mut block);
        }
        Ok(block)
    }

    fn statement(&mut self) -> Parsed<What> {
        let line = self.line();
        let cursor = &mut self.cursor;
        if cursor.is_any_word(&["CONST", "PERS", "VAR"]) {
            return Ok(What::Declare(self.declaration()?));
        }
        if cursor.take_word("IF") {
            return self.if_statement();
        }
        if cursor.take_word("FOR") {
            return self.for_statement();
        }
        if cursor.take_word("WHILE") {
            let condition = cursor.expression()?;
            cursor.word("DO")?;
            let body = self.block(&["ENDWHILE"])?;
            self.cursor.advance();
            return Ok(What::While(condition, body));
        }
        if cursor.take_word("TEST") {
            return self.test_statement();
        }
        if cursor.take_word("RETURN") {
            let value = if cursor.is_symbol(";") { None } else { Some(cursor.expression()?) };
            cursor.symbol(";")?;
            return Ok(What::Return(value));
        }
        if cursor.take_word("GOTO") {
            let label = cursor.name()?;
            cursor.symbol(";")?;
            return Ok(What::Goto(label));
        }
        if cursor.take_word("CONNECT") {
            return self.connect();
        }
        if cursor.take_symbol("%") {
            let name = cursor.expression()?;
            cursor.symbol("%")?;
            let args = cursor.arguments(";")?;
            return self.call_by_name(line, name, &args);
        }
        if cursor.is_symbol("<") {
            return Err("a placeholder: the program is unfinished".to_owned());
        }
        if let Some(word) = ENDS.into_iter().find(|word| cursor.take_word(word)) {
            return Err(format!("{word} without its beginning: is THEN or DO missing before it?"));
        }
        let name = cursor.name()?;
        if cursor.take_symbol(":") {
            return Ok(What::Label(name));
        }
        if cursor.is_symbol(":=") || cursor.is_symbol("{") || cursor.is_symbol(".") {
            let path = cursor.path(name)?;
            cursor.symbol(":=")?;
            let value = cursor.expression()?;
            cursor.symbol(";")?;
            return Ok(What::Assign(path, value));
        }
        self.call(line, name)
    }

    /// A procedure by a name in a string, before which its module may stand: where the text has the
    /// whole name it is a call.
    fn call_by_name(&mut self, line: usize, name: Expr, args: &Args) -> Parsed<What> {
        let start = by_name::start(&name);
        if let Expr::Text(text) = &name {
            return match self.procedures(&start, text.trim()).as_slice() {
                [only] => Ok(What::Call(only.clone(), args.clone())),
                _ => {
                    let all = [self.procedures(&start, &start), Vec::new()];
                    by_name::choice(line, name, args, all)
                }
            };
        }
        let known = self.names.procedures.keys().filter(|own| own.starts_with(&start));
        let (of_modules, names): (Vec<_>, Vec<_>) = known.partition(|own| own.contains(':'));
        let all = [names, of_modules];
        let all =
            all.map(|own| own.into_iter().flat_map(|own| self.procedures(own, own)).collect());
        by_name::choice(line, name, args, all)
    }

    /// The procedures that a name in a string may be that of, in the module at hand.
    fn procedures(&self, key: &str, shown: &str) -> Vec<Name> {
        let own = Name { shown: shown.to_owned(), ..self.cursor.named(key) };
        let others = self.names.procedures.get(key).filter(|_| own.key == key);
        match others.filter(|others| !others.is_empty()) {
            Some(others) => {
                let own = |key: &String| Name { key: key.clone(), shown: shown.to_owned() };
                others.iter().map(own).collect()
            }
            None => vec![own],
        }
    }

    /// `CONNECT i1 WITH tr;`: an instruction with the name of the trap as a text.
    fn connect(&mut self) -> Parsed<What> {
        let interrupt = Optional::Value(self.cursor.expression()?);
        self.cursor.word("WITH")?;
        let trap = self.cursor.name()?;
        self.cursor.symbol(";")?;
        let optional = vec![("interrupt".to_owned(), interrupt)];
        let args = Args { positional: vec![Expr::Text(trap.shown)], optional };
        Ok(What::Call(Name::new("CONNECT"), args))
    }

    fn call(&mut self, line: usize, name: Name) -> Parsed<What> {
        // `Set do1;`, `foo;`: no arguments. `foo p10, \On;`: an instruction or a procedure.
        match self.cursor.arguments(";") {
            Ok(args) if name.key == "callbyvar" => match by_name::numbered(&args) {
                Some(own) => self.call_by_name(line, own, &Args::default()),
                None => Ok(What::Call(name, args)),
            },
            Ok(args) if self.names.procedures.get(&name.key).is_some_and(|own| own.len() > 1) => {
                self.call_by_name(line, Expr::Text(name.shown), &args)
            }
            Ok(args) => Ok(What::Call(name, args)),
            // One that fills data in must be understood.
            Err(_) if is_ignored(&name.key) && !fills(&name.key) => {
                self.cursor.skip_statement();
                Ok(What::Call(name, Args::default()))
            }
            Err(what) => Err(format!("{}: {what}", name.shown)),
        }
    }

    fn if_statement(&mut self) -> Parsed<What> {
        let condition = self.cursor.expression()?;
        if !self.cursor.take_word("THEN") {
            let mut body = Vec::new();
            self.statement_or_stray(&mut body);
            return Ok(What::If(vec![(condition, body)], Vec::new()));
        }
        let ends = ["ELSEIF", "ELSE", "ENDIF"];
        let mut branches = vec![(condition, self.block(&ends)?)];
        while self.cursor.take_word("ELSEIF") {
            let condition = self.cursor.expression()?;
            self.cursor.word("THEN")?;
            branches.push((condition, self.block(&ends)?));
        }
        let otherwise =
            if self.cursor.take_word("ELSE") { self.block(&["ENDIF"])? } else { Vec::new() };
        self.cursor.word("ENDIF")?;
        Ok(What::If(branches, otherwise))
    }

    fn for_statement(&mut self) -> Parsed<What> {
        let variable = self.cursor.name()?;
        self.cursor.word("FROM")?;
        let from = self.cursor.expression()?;
        self.cursor.word("TO")?;
        let to = self.cursor.expression()?;
        let step =
            if self.cursor.take_word("STEP") { Some(self.cursor.expression()?) } else { None };
        self.cursor.word("DO")?;
        let body = self.block(&["ENDFOR"])?;
        self.cursor.advance();
        Ok(What::For { variable, from, to, step, body })
    }

    fn test_statement(&mut self) -> Parsed<What> {
        let tested = self.cursor.expression()?;
        let ends = ["CASE", "DEFAULT", "ENDTEST"];
        let mut cases = Vec::new();
        let mut otherwise = Vec::new();
        loop {
            if self.cursor.take_word("CASE") {
                let values = self.cursor.list(":")?;
                cases.push((values, self.block(&ends)?));
            } else if self.cursor.take_word("DEFAULT") {
                self.cursor.symbol(":")?;
                otherwise = self.block(&ends)?;
            } else {
                self.cursor.word("ENDTEST")?;
                return Ok(What::Test(tested, cases, otherwise));
            }
        }
    }
}
