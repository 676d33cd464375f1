//! Calls of procedures by a name in a string: `%"weld"+ValToStr(n)% p10;`, `CallByVar "weld",n;`.

use super::cursor::Parsed;
use super::instructions::motion;
use super::interpreter::{Flow, Interpreter};
use super::number::WRITE;
use super::syntax::{Args, Block, Expr, Name, Operator, Statement, What};
use super::value::Value;
use crate::notes::Code;

/// Procedures that one call may choose from.
const MAX_CHOICE: usize = 200;

/// How such a call is told.
const SHOWN: &str = "a call by a name in a string";

/// The name that `CallByVar` calls, of its arguments.
pub(super) fn numbered(args: &Args) -> Option<Expr> {
    let [start, number] = args.positional.as_slice() else { return None };
    let digits = Args { positional: vec![number.clone()], optional: Vec::new() };
    let digits = Expr::Call(Box::new((Name::new("ValToStr"), digits)));
    Some(Expr::Binary(Operator::Plus, Box::new(start.clone()), Box::new(digits)))
}

/// A name in a string, before which its module may stand, as names are compared.
fn plain(text: &str) -> String {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    parts.join(":").to_lowercase()
}

/// What a name in a string begins with, as far as the text has it, as names are compared.
pub(super) fn start(name: &Expr) -> String {
    match name {
        Expr::Text(text) => plain(text),
        Expr::Binary(Operator::Plus, first, _) => start(first),
        _ => String::new(),
    }
}

/// A call of one of the procedures of the files that a name may be that of; those with their
/// modules before them are the same procedures.
pub(super) fn choice(
    line: usize,
    name: Expr,
    args: &Args,
    procedures: [Vec<Name>; 2],
) -> Parsed<What> {
    if procedures.iter().any(|own| own.len() > MAX_CHOICE) {
        return Err(format!("{SHOWN}, which may be that of more than {MAX_CHOICE} procedures"));
    }
    let call = |own: Name| {
        let shown = own.shown.to_lowercase();
        (shown, vec![Statement { line, there: None, what: What::Call(own, args.clone()) }])
    };
    let among = procedures.into_iter().flatten().map(call).collect();
    Ok(What::CallByName(name, args.clone(), among))
}

impl<'a> Interpreter<'a> {
    pub(super) fn call_by_name(
        &mut self,
        line: usize,
        name: &'a Expr,
        args: &'a Args,
        among: &'a [(String, Block)],
    ) -> Flow {
        self.doubt_shared(line, SHOWN, vec![name], among.iter().map(|(_, call)| call).collect());
        let why = match self.eval(name) {
            Value::Text(text) => {
                let own = plain(&text);
                let mut found: Vec<&'a Block> =
                    among.iter().filter(|(other, _)| *other == own).map(|(_, call)| call).collect();
                if found.len() > 1 {
                    found.retain(|call| self.is_loaded(call));
                    if found.len() != 1 {
                        self.tell_not_loaded(line, text.trim(), !found.is_empty());
                        return Flow::Next;
                    }
                }
                return match found.first() {
                    Some(call) => self.block(call),
                    None => self.call_of_controller(line, &Name::new(text.trim()), args),
                };
            }
            Value::Unknown(why) => why.to_string(),
            _ => format!("the name is no string: {WRITE}"),
        };
        // It may be that of a procedure in no file.
        let what = format!("{SHOWN} decides about motion at run time: {why}");
        self.log.error(Code::Motion, line, what);
        Flow::Next
    }

    /// A call by a name that no procedure of the files has.
    fn call_of_controller(&mut self, line: usize, name: &Name, args: &'a Args) -> Flow {
        let Some(motion) = motion(&name.key) else {
            self.not_in_file(line, &name.shown);
            self.lose_arguments(name, args);
            return Flow::Next;
        };
        let flow = self.move_by(line, motion, name, args);
        self.pass_time(&name.key);
        flow
    }
}
