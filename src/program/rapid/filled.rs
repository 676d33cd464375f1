//! Data that the run fills in: what an operator answers, what a channel gives, whether a wait was
//! in time, what another task sets while this one waits.

use super::interpreter::Interpreter;
use super::syntax::{Args, Expr, Name, Optional, Path};
use super::value::Value;
use super::walk::names_in;

/// Instructions and functions that write into what they are given.
const FILL: [&str; 18] = [
    "getdataval",
    "getnextmechunit",
    "getnextsym",
    "getsysdata",
    "gettrapdata",
    "readanybin",
    "readcfgdata",
    "readdir",
    "readerrdata",
    "readrawbytes",
    "rmqgetmsgdata",
    "socketreceive",
    "strtoval",
    "testandset",
    "tpreaddnum",
    "tpreadfk",
    "tpreadnum",
    "unpackrawbytes",
];

/// Optional arguments that others write.
const FILLED: [&str; 5] = ["timeflag", "valueattimeout", "breakflag", "result", "buttonres"];

/// The data that an instruction or a function of the controller fills in.
pub(super) fn filled<'a>(name: &Name, args: &'a Args) -> Vec<&'a Path> {
    let fills = FILL.contains(&name.key.as_str());
    let given = usize::from(name.key == "strtoval");
    let positional = args.positional.iter().skip(given).filter(|_| fills);
    let optional = args.optional.iter().filter_map(|(own, value)| match value {
        Optional::Value(expr) if fills || FILLED.contains(&own.as_str()) => Some(expr),
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
            let key = path.name.key.as_str();
            let own = self.settings.assume.get(key).filter(|_| path.is_whole());
            if own.is_some() {
                self.heed(key);
            }
            let value = own.map_or_else(
                || {
                    let (datum, by) = (&path.name.shown, &name.shown);
                    Value::unknown(format!("{by} fills in '{datum}': known only at run time"))
                },
                |own| Value::from(*own),
            );
            self.forget(&path.name, &value);
            if own.is_some() && !self.is_declared(key) {
                // What the job says of it holds, whatever was known of it before.
                self.forgotten.remove(key);
                self.assigned.remove(key);
            }
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
        if self.eval(condition).bool() != Ok(false) {
            return;
        }
        for name in names_in(vec![condition]) {
            if self.settings.assume.contains_key(&name.key) {
                self.heed(&name.key);
            }
            let value = self.settings.assume.get(&name.key).map_or_else(
                || {
                    let what = "another task sets it while WaitUntil waits: known only at run time";
                    Value::unknown(format!("'{}': {what}", name.shown))
                },
                |own| Value::from(*own),
            );
            let is_declared = self.file.data.contains_key(&name.key);
            // What the job says of a signal holds on.
            if is_declared || matches!(value, Value::Unknown(_)) {
                self.forget(name, &value);
            }
        }
    }
}
