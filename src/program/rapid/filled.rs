//! Data that the run fills in: what an operator answers, what a channel gives, whether a wait was
//! in time, what another task sets while this one waits.

use super::instructions::{may_be_set, may_set};
use super::interpreter::Interpreter;
use super::modules::is_of_module;
use super::outputs::WHOLE;
use super::syntax::{Args, Expr, Name, Optional, Path};
use super::value::Value;
use super::walk::{given, is_settable, names_in};
use super::why::COPY;
use crate::notes::Code;

/// Instructions and functions that write into what they are given, and how many arguments stand
/// before that.
const FILL: [(&str, usize); 30] = [
    ("bookerrno", 0),
    ("calcrotaxframez", 3),
    ("calcrotaxisframe", 3),
    ("defaccframe", 3),
    ("fricidevaluate", 0),
    ("getdataval", 0),
    ("getjointdata", 2),
    ("getnextmechunit", 0),
    ("getnextsym", 0),
    ("getsignalorigin", 1),
    ("getsysdata", 0),
    ("gettrapdata", 0),
    ("ivarvalue", 2),
    ("paridposvalid", 1),
    ("readanybin", 0),
    ("readcfgdata", 0),
    ("readdir", 0),
    ("readerrdata", 0),
    ("readrawbytes", 0),
    ("rmqgetmsgdata", 0),
    ("socketaccept", 0),
    ("socketreceive", 0),
    ("socketreceivefrom", 0),
    ("strtoval", 1),
    ("testandset", 0),
    ("tpreaddnum", 0),
    ("tpreadfk", 0),
    ("tpreadnum", 0),
    ("unpackrawbytes", 0),
    ("waittestandset", 0),
];

/// Optional arguments that others write.
const FILLED: [&str; 5] = ["timeflag", "valueattimeout", "breakflag", "result", "buttonres"];

/// Whether an instruction writes into what it is given.
pub(super) fn fills(key: &str) -> bool {
    FILL.iter().any(|(own, _)| *own == key)
}

/// The data that an instruction or a function of the controller fills in.
pub(super) fn filled<'a>(name: &Name, args: &'a Args) -> Vec<&'a Path> {
    let before = FILL.iter().find(|(own, _)| *own == name.key).map(|(_, before)| *before);
    let positional = args.positional.iter().skip(before.unwrap_or(usize::MAX));
    let optional = args.optional.iter().filter_map(|(own, value)| match value {
        Optional::Value(expr) if before.is_some() || FILLED.contains(&own.as_str()) => Some(expr),
        _ => None,
    });
    let data = positional.chain(optional).filter_map(|expr| match expr {
        Expr::Ref(path) => Some(&**path),
        _ => None,
    });
    data.collect()
}

impl<'a> Interpreter<'a> {
    /// What an instruction or a function fills in is known only at run time, or by what the job
    /// assumes.
    pub(super) fn fill(&mut self, name: &Name, args: &'a Args) {
        for path in filled(name, args) {
            match name.key.as_str() {
                // It has waited until no task had it set.
                "waittestandset" if path.is_whole() => {
                    self.forget(&path.name, &Value::Bool(true));
                    if !self.is_declared(&path.name.key) {
                        self.assigned.insert(&path.name.key, Value::Bool(true));
                    }
                }
                _ => self.lose(path, &format!("{} fills in", name.shown), ""),
            }
        }
        if name.key == "getdataval"
            && let Some((path, value)) = self.named_constant(args)
        {
            self.forget(&path.name, &value);
        }
    }

    /// `SetDataVal "k",v;`: what it sets is known only at run time.
    pub(super) fn set_named(&mut self, line: usize, name: &Name, args: &'a Args) {
        self.doubt_call(line, name, args);
        let file = self.file;
        let given: Vec<Value> = args.positional.iter().map(|expr| self.eval(expr)).collect();
        let data = match given.first() {
            Some(Value::Text(text)) => {
                file.data.get(&text.trim().to_lowercase()).filter(|own| !own.is_constant)
            }
            _ => None,
        };
        let Some(data) = data else {
            let what = format!(
                "{} sets a datum whose name only the run knows, or that is constant or in no file \
                 that is read: what it sets is not read",
                name.shown
            );
            return self.log.warning(Code::MotionLeftOut, line, what);
        };
        let (shown, own) = (&name.shown, &data.name.shown);
        let what = format!("{shown} sets '{own}': known only at run time; {COPY}");
        self.forget(&data.name, &Value::unknown(what));
    }

    /// `GetDataVal "p10",q;`: a datum as a whole, and the constant of all modules that a text
    /// names, of the same type; not where data of the routine or of one module have the name, too.
    fn named_constant(&mut self, args: &'a Args) -> Option<(&'a Path, Value)> {
        let [Expr::Text(text), Expr::Ref(path)] = args.positional.as_slice() else { return None };
        let file = self.file;
        let key = text.trim().to_lowercase();
        let (key, data) = file.data.get_key_value(&key)?;
        let is_it = data.is_constant
            && !data.is_local
            && data.dimensions.is_empty()
            && args.optional.is_empty()
            && path.is_whole()
            && self.kind_of(&path.name.key) == Some(&data.kind)
            && !self.is_local(key)
            && !file.data.keys().any(|own| is_of_module(own, key));
        let value = self.datum_now(key).filter(|_| is_it)?;
        Some((path, value))
    }

    /// What a call that is in no file may have set.
    pub(super) fn lose_arguments(&mut self, name: &Name, args: &'a Args) {
        if !may_set(&name.key) {
            return;
        }
        for path in given(args) {
            let local = self.frames.last().and_then(|frame| frame.get(&path.name.key));
            let is_lost = match local {
                Some(datum) => !datum.is_constant && may_be_set(datum.kind),
                None => self.file.data.get(&path.name.key).is_some_and(is_settable),
            };
            if is_lost {
                const FILES: &str = "path.program.files in the job can name its file, or ";
                let by = format!("{}, which is in no file that is read, may set", name.shown);
                self.lose(path, &by, FILES);
            }
        }
    }

    /// `by` is what stands before the datum in the text, `help` before what helps where `assume`
    /// cannot.
    fn lose(&mut self, path: &'a Path, by: &str, help: &str) {
        let key = path.name.key.as_str();
        let own = path.is_whole().then(|| self.said_by_job(key)).flatten();
        let shown = &path.name.shown;
        if own.is_some() {
            self.doubt_namesake(&path.name);
        }
        let hint = match path.is_whole() && self.is_single(key) {
            true => format!("assume: {{\"{shown}\": …}} in the job can give it"),
            false => format!("{WHOLE}: {help}{COPY}"),
        };
        let value = own.clone().unwrap_or_else(|| {
            Value::unknown(format!("{by} '{shown}': known only at run time; {hint}"))
        });
        self.forget(&path.name, &value);
        if own.is_some() && !self.is_declared(key) {
            // What the job says of it holds, whatever was known of it before.
            self.forgotten.remove(key);
            self.assigned.remove(key);
        }
    }

    /// `SearchL di1, found, …`: the place that a search finds.
    pub(super) fn fill_found(&mut self, name: &Name, args: &'a Args) {
        if let (true, Some(Expr::Ref(path))) =
            (name.key.starts_with("search"), args.positional.get(1))
        {
            let what = format!("'{}' is what {} finds", path.name.shown, name.shown);
            self.forget(&path.name, &Value::unknown(format!("{what}: known only at run time")));
        }
    }

    /// Behind `WaitUntil` what it waited for holds: where the program itself says otherwise,
    /// another task has set it. Runs the functions in the condition.
    pub(super) fn waited(&mut self, args: &'a Args) {
        let Some(condition) = args.positional.first() else { return };
        let is_false = self.eval(condition).bool() == Ok(false);
        if is_false {
            // The procedure of a move before may set it.
            let line = self.line;
            if self.waits_for_late(line, "WaitUntil", condition)
                && self.eval(condition).bool() != Ok(false)
            {
                return;
            }
            for name in names_in(vec![condition]) {
                self.set_while(name, "WaitUntil", true);
            }
        }
        // A function of the program runs once: it may set data.
        match self.asks_own_function(condition) {
            true if is_false => self.lose_assumed(condition),
            true => {}
            false => self.lose_awaited(condition),
        }
    }

    /// Another task has set what the program waited for: to what the job assumes, or it is known
    /// only at run time.
    pub(super) fn set_while(&mut self, name: &'a Name, waits: &str, heeds_job: bool) {
        let assumed = heeds_job.then(|| self.said_by_job(&name.key)).flatten();
        let value = assumed.unwrap_or_else(|| {
            let what = format!("another task sets it while {waits} waits");
            Value::unknown(format!("'{}': {what}: known only at run time", name.shown))
        });
        let key = name.key.as_str();
        let is_datum = self.file.data.contains_key(key) || self.assigned.contains_key(key);
        // What the job says of a signal holds on.
        if is_datum || matches!(value, Value::Unknown(_)) {
            self.forget(name, &value);
        }
    }
}
