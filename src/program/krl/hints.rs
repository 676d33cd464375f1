//! What looks like a command to the spindle by its name, and the job does not read; what would
//! move.

use std::collections::HashSet;

use super::interrupts::fixed_key;
use super::run::Run;
use super::signals::named_by;
use super::syntax::{Block, Expr, File, Path, Routine, Statement, What};
use super::value::{Value, base};
use super::walk::{blocks_in, expressions, functions_in, names_in};
use super::words::{corrects_frames, is_harmless, sounds_like_motion};
use crate::notes::Code;
use crate::program::cell::all;
use crate::program::spindle_names::{doubt, is_spindles};
use crate::program::{Assumed, Setter, Settings};

/// Parts of tools, frames and places.
const PARTS: [&str; 11] = ["x", "y", "z", "a", "b", "c", "s", "t", "a1", "m", "cm"];

/// Names in what the program gives to what the job reads the spindle or the tool from.
pub(super) fn given_on<'a>(file: &'a File, settings: &Settings) -> HashSet<&'a str> {
    let mut found = HashSet::new();
    let key = |name| file.signals.key(name);
    for (_, by) in all(settings) {
        let routines = file.routines.values().chain(file.functions.values());
        for what in statements_in(routines.map(|routine| &routine.body)) {
            let given: Vec<&Expr> = match (what, &by.what) {
                (What::Assign(path, expr), Setter::Signal(own))
                    if key(fixed_key(path)) == key(own.to_lowercase()) =>
                {
                    vec![expr]
                }
                (What::Call(name, args), Setter::Procedure(own, _))
                    if *name == own.to_lowercase() =>
                {
                    args.iter().flatten().collect()
                }
                _ => continue,
            };
            found.extend(names_in(given));
        }
    }
    found
}

/// Lines of the main file on which its statements begin.
pub(super) fn lines_of(file: &File) -> HashSet<usize> {
    let routines = file.routines.values().chain(file.functions.values());
    let all = all_in(routines.map(|routine| &routine.body)).into_iter();
    all.filter(|own| own.file == 0).map(|own| own.line).collect()
}

/// All statements of blocks and of those in them.
pub(super) fn all_in<'a>(blocks: impl Iterator<Item = &'a Block>) -> Vec<&'a Statement> {
    let mut open: Vec<&Block> = blocks.collect();
    let mut found = Vec::new();
    while let Some(block) = open.pop() {
        for statement in block {
            open.extend(blocks_in(&statement.what));
            found.push(statement);
        }
    }
    found
}

pub(super) fn statements_in<'a>(blocks: impl Iterator<Item = &'a Block>) -> Vec<&'a What> {
    all_in(blocks).into_iter().map(|own| &own.what).collect()
}

fn is_output(path: &Path) -> bool {
    path.name.starts_with("$out") || path.name.starts_with("$anout")
}

fn is_off(expr: &Expr) -> bool {
    matches!(expr, Expr::Bool(false)) || matches!(expr, Expr::Number(value, ..) if *value == 0.0)
}

impl<'a> Run<'a> {
    fn doubt(&mut self, line: usize, name: &str) {
        doubt(self.settings, self.log, line, name);
    }

    pub(super) fn doubt_assignment(&mut self, line: usize, path: &Path, expr: &Expr) {
        if corrects_frames(&path.name) && *expr != Expr::Bool(false) {
            let what = format!(
                "{} lets BAS shift tools or bases by a correction, which is not read",
                path.name.to_uppercase()
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
        self.doubt_beside_spindle(line, path, expr);
        let is_place = match expr {
            Expr::Parts(parts) => parts.iter().any(|(name, _)| PARTS.contains(&name.as_str())),
            _ => false,
        };
        if !is_place {
            self.doubt_set(line, path);
        }
        let may_be_signal = !path.name.starts_with('$') && path.fields.is_empty();
        let is_declared = self.is_own(&path.name) || self.types.contains_key(&path.name);
        if is_output(path) || may_be_signal && !is_declared {
            self.doubt_names(line, names_in(vec![expr]));
        }
    }

    /// Of a datum that is set to a number.
    pub(super) fn doubt_set(&mut self, line: usize, path: &Path) {
        let is_part = path.fields.iter().any(|field| PARTS.contains(&field.as_str()));
        let looks_so = is_spindles(&path.name) || path.fields.iter().any(|it| is_spindles(it));
        if looks_so
            && !is_part
            && !self.is_own(&path.name)
            && !self.given_on.contains(path.name.as_str())
        {
            self.doubt(line, &path.name);
        }
    }

    /// Of a statement of the controller, or a routine that is in no file.
    pub(super) fn doubt_call(&mut self, line: usize, name: &str, args: &[Option<Expr>]) {
        if name == "anout" {
            // Its first name is the output's, behind ON or OFF.
            let output = args.iter().flatten().filter_map(|arg| match arg {
                Expr::Ref(path) if !matches!(path.name.as_str(), "on" | "off") => Some(path),
                _ => None,
            });
            output.take(1).for_each(|path| self.doubt_undeclared(line, path, None));
        }
        if matches!(name, "pulse" | "anout") || !is_harmless(name) && name != "bas" {
            let mut names = names_in(args.iter().flatten().collect());
            names.push(name);
            self.doubt_names(line, names);
        }
    }

    /// The procedure that the job reads the spindle from, in lower case.
    pub(super) fn spindles_procedure(&self) -> Option<String> {
        match &self.settings.spindle_from.as_ref()?.what {
            Setter::Procedure(own, _) => Some(own.to_lowercase()),
            Setter::Signal(_) | Setter::Comment(_) => None,
        }
    }

    /// Outputs that this procedure sets, and what it sets to what it is given.
    pub(super) fn set_by_spindle(&self) -> HashSet<String> {
        let own = self.spindles_procedure().and_then(|own| self.file.routine(&own));
        let Some(own) = own else { return HashSet::new() };
        let is_given = |name: &&str| own.parameters.iter().any(|given| given.name == **name);
        let sets = own.body.iter().flat_map(|statement| self.unread(&statement.what).sets);
        let sets = sets.filter(|set| !own.declares(&set.path.name)).map(|set| {
            let key = self.file.signals.key(fixed_key(set.path));
            let is_speed = names_in(set.expr.into_iter().collect()).iter().any(is_given);
            (is_speed || key.starts_with("$out") || key.starts_with("$anout")).then_some(key)
        });
        sets.flatten().collect()
    }

    /// Of what that procedure sets, too, and another line sets to something else than off.
    pub(super) fn doubt_beside_spindle(&mut self, line: usize, path: &Path, expr: &Expr) {
        if self.is_in_spindle
            || self.of_spindle.is_empty()
            || is_off(expr)
            || self.is_own(&path.name)
        {
            return;
        }
        let key = self.file.signals.key(fixed_key(path));
        let mut all = self.file.signals.shared_with(&key);
        let shown = self.names(&key).pop().unwrap_or_default().to_uppercase();
        all.extend([base(&key).to_owned(), key.clone()]);
        // Where the index is not known it may be any element.
        let is_any = |own: &String| all.contains(own) || base(own) == key;
        if self.of_spindle.iter().any(is_any) {
            let what = format!(
                "'{shown}' is set here, and the procedure that the job names in spindle_from sets \
                 it, too: the spindle may have another speed; path.program.spindle_from: \
                 {{signal: …}} reads what it is set to"
            );
            self.log.warning(Code::SpindleCommand, line, what);
        }
    }

    /// Of a routine of the files that sets outputs, where the job reads nothing, or another
    /// procedure: then one that only switches off by its name and by what it sets has no speed.
    pub(super) fn doubt_routine(&mut self, line: usize, name: &str, routine: &'a Routine) {
        let stops = self.spindles_procedure().is_some()
            && ["off", "stop", "aus"].iter().any(|word| name.contains(word));
        let sets_output = |what: &&What| match what {
            What::Assign(path, expr) => is_output(path) && !(stops && is_off(expr)),
            What::Call(name, _) => matches!(name.as_str(), "pulse" | "anout"),
            _ => false,
        };
        let is_open = self.settings.spindle_from.is_none() || self.spindles_procedure().is_some();
        if is_open
            && is_spindles(name)
            && statements_in(std::iter::once(&routine.body)).iter().any(sets_output)
        {
            self.doubt(line, name);
        }
    }

    /// Of a statement that may run or not.
    pub(super) fn doubt_open(&mut self, line: usize, what: &What) {
        match what {
            What::Assign(path, expr) => {
                self.doubt_assignment(line, path, expr);
                self.doubt_undeclared(line, path, Some(expr));
            }
            What::Call(name, args) if self.file.routine(name).is_none() => {
                self.doubt_call(line, name, args);
            }
            _ => {}
        }
    }

    fn doubt_names(&mut self, line: usize, names: Vec<&str>) {
        if let Some(name) = names.into_iter().rev().find(|name| is_spindles(name)) {
            self.doubt(line, name);
        }
    }

    /// `$MODE_OP==#EX`: which name of an enumeration a datum has by the job's word.
    pub(super) fn assumed_name(&mut self, names: &[String]) -> Option<Value> {
        let given = self.names_given(names);
        let (name, _) = *given.iter().find(|(_, is)| *is == Assumed::Truth(true))?;
        let denies = |(own, is): &&(&str, Assumed)| {
            let is_true = *is == Assumed::Truth(true);
            is_true != (*own == name)
        };
        if let Some((other, _)) = given.iter().find(denies) {
            let datum = names.last().map_or("", String::as_str).to_uppercase();
            let [name, other] = [name, other].map(str::to_uppercase);
            let both = match name == other {
                true => format!("\"{datum}==#{name}\" true and false"),
                false => format!("\"{datum}==#{name}\" and \"{datum}==#{other}\" true"),
            };
            let what = format!("assume: in the job has {both}, of which one can be: delete one");
            self.log.error(Code::Conflict, self.line, what);
        }
        Some(Value::Enum(name.to_owned()))
    }

    /// Names of an enumeration that the job says a datum has or has not.
    pub(super) fn names_given(&self, names: &[String]) -> Vec<(&'a str, Assumed)> {
        let given = self.settings.assume.iter().filter_map(|(said, is)| {
            let (datum, name) = Assumed::enumeration(said)?;
            names.iter().any(|own| own == datum).then_some((name, *is))
        });
        given.collect()
    }

    /// Whether a datum that is not known has another name than this by the job's word.
    pub(super) fn is_other(&mut self, datum: &'a Expr, value: &Value, name: &Value) -> bool {
        let (Expr::Ref(path), Value::Unknown(_), Value::Enum(name)) = (datum, value, name) else {
            return false;
        };
        let Some(key) = self.key(path).ok().filter(|_| path.fields.is_empty()) else {
            return false;
        };
        let given = self.names_given(&self.names(&key));
        !self.forgotten.contains(&key) && given.contains(&(name.as_str(), Assumed::Truth(false)))
    }

    /// What the job can say of a datum that is compared with the name of an enumeration.
    pub(super) fn with_name(&self, why: String, sides: [(&Expr, &Value); 2]) -> String {
        let (path, name) = match sides {
            [(Expr::Ref(path), _), (_, Value::Enum(name))]
            | [(_, Value::Enum(name)), (Expr::Ref(path), _)] => (path, name),
            _ => return why,
        };
        let is_set = self.globals.contains_key(&path.name) || self.is_own(&path.name);
        let is_part = !path.fields.is_empty() || !path.indices.is_empty();
        if is_set || is_part || self.forgotten.contains(&path.name) {
            return why;
        }
        let said = format!("{}==#{name}", path.name).to_uppercase();
        format!("{why}; assume: {{\"{said}\": true}} in the job says that it is so")
    }

    /// Whether a datum is of the routine that runs.
    pub(super) fn is_own(&self, name: &str) -> bool {
        self.frames.last().is_some_and(|frame| frame.has(name))
    }

    /// Whether a statement, or what it calls in the files, would move if it ran.
    pub(super) fn moves(&self, what: &'a What) -> bool {
        self.reached(vec![what]).into_iter().any(|what| match what {
            What::Move(_) | What::Spline(..) => true,
            What::Call(name, _) => self.file.routine(name).is_none() && sounds_like_motion(name),
            _ => false,
        })
    }

    /// Statements, those in their blocks, and those of what they call in the files.
    pub(super) fn reached(&self, mut open: Vec<&'a What>) -> Vec<&'a What> {
        let mut seen: HashSet<&str> = HashSet::new();
        let mut found = Vec::new();
        while let Some(what) = open.pop() {
            found.push(what);
            let mut bodies = blocks_in(what);
            let functions = functions_in(expressions(what)).into_iter().map(|(name, _)| name);
            let routine = match what {
                What::Call(name, _) => Some(name.as_str()),
                _ => None,
            };
            let called = functions.chain(routine).filter(|name| seen.insert(*name));
            let file = self.file;
            bodies.extend(called.filter_map(|name| file.routine(name)).map(|own| &own.body));
            open.extend(bodies.into_iter().flatten().map(|statement| &statement.what));
        }
        found
    }

    /// Tells of a name that no file declares where the job reads an output, and of an output where
    /// no file says which one the job's name is, unless it is set from that name.
    pub(super) fn doubt_undeclared(&mut self, line: usize, path: &Path, expr: Option<&Expr>) {
        if expr.is_some_and(|expr| !may_be_number(expr)) {
            return;
        }
        let from = names_in(expr.into_iter().collect());
        let is_declared = self.is_own(&path.name) || self.types.contains_key(&path.name);
        let signals = &self.file.signals;
        let is_signal = |name: &str| name.starts_with('$') || signals.knows(name);
        // What inline forms set before BAS.
        let is_form = path.name.ends_with("_act");
        let is_given_on = self.given_on.contains(path.name.as_str());
        let is_known = is_declared || is_given_on || is_form || is_signal(&path.name);
        let is_unknown = !is_known && path.fields.is_empty();
        let is_analog = path.name == "$anout";
        let may_be = named_by(self.settings).find(|own| match own.starts_with('$') {
            // A file that names the output has it from where all names are.
            true if signals.names_of(own).contains(&path.name) => {
                signals.key(path.name.clone()) == path.name
            }
            true => is_unknown && signals.names_of(own).is_empty(),
            false => {
                let is_datum = self.is_own(own) || self.types.contains_key(own);
                is_analog && !signals.knows(own) && !is_datum && !from.contains(&own.as_str())
            }
        });
        if let Some(own) = may_be {
            let what = format!(
                "'{}' may be '{own}', which the job reads: no file that is read says so with \
                 SIGNAL; path.program.files in the job can name the one that does",
                path.name
            );
            self.log.warning(Code::SpindleCommand, line, what);
        }
    }
}

/// Whether an expression may give a number, as analog outputs take.
fn may_be_number(expr: &Expr) -> bool {
    const OF_SIGNS: [&str; 4] = ["$in", "$out", "$flag", "$cycflag"];
    match expr {
        Expr::Number(..) | Expr::Minus(_) | Expr::Call(..) => true,
        Expr::Ref(path) => !OF_SIGNS.contains(&path.name.as_str()),
        Expr::Binary(operator, ..) => matches!(*operator, "+" | "-" | "*" | "/"),
        _ => false,
    }
}
