//! Where the controller stops as it works something out, or does not load the program: a division
//! by zero, an index beyond an array, a function of what it is not defined for, a constant that is
//! set.

use super::constants::predefined;
use super::eval::{Scope, beyond};
use super::interpreter::Interpreter;
use super::syntax::{Expr, Path, Step};
use super::value::Value;
use super::walk::names_in;
use crate::notes::Code;

impl<'a> Interpreter<'a> {
    /// The statement that runs stops the controller, by what `of` are: an error, and a doubt where
    /// that is not certain.
    pub(super) fn stops_at(&mut self, what: &str, of: Vec<&'a Expr>) {
        let mut names = names_in(of).into_iter();
        let others = names.find(|name| self.set_by_others.contains(name.key.as_str()));
        let unless = match others {
            Some(name) => format!("another task has set '{}'", name.shown),
            None if self.guarded > 0 => "it leaves out the second side of AND or OR".to_owned(),
            None if self.handlers > 0 => "a handler of errors, not read, goes on".to_owned(),
            None if !self.starts_at_main => "what has run before has set the data".to_owned(),
            None => {
                let what = format!("{what}: the controller stops here");
                self.fault_at = Some(self.line);
                return self.log.error(Code::Value, self.line, what);
            }
        };
        let what = format!(
            "{what}: the controller stops here unless {unless}; it is read as if it went on"
        );
        self.log.warning(Code::MotionLeftOut, self.line, what);
    }

    /// Tells of an index beyond the end of an array.
    pub(super) fn heed_end(&mut self, scope: Scope, key: &str, way: &[usize], path: &'a Path) {
        let mut value = self.own_root(scope, key).filter(|_| !path.is_whole());
        let mut is_beyond = false;
        for (level, index) in way.iter().enumerate() {
            let Some(Value::List(items)) = value else { break };
            value = items.get(*index);
            is_beyond = value.is_none() && is_element(path, way.len() - level);
        }
        if is_beyond {
            let indices = path.steps.iter().flat_map(|step| match step {
                Step::Index(indices) => indices.as_slice(),
                Step::Field(_) => &[],
            });
            self.stops_at(&beyond(&path.name), indices.collect());
        }
    }

    /// Of an assignment to a constant, which no controller loads.
    pub(super) fn refuse_constant(&mut self, line: usize, path: &Path) {
        let key = path.name.key.as_str();
        let local = self.frames.last().and_then(|frame| frame.get(key));
        let is_constant = match (local, self.file.data.get(key)) {
            (Some(datum), _) => datum.is_constant,
            (None, Some(data)) => data.is_constant,
            (None, None) => predefined(key).is_some(),
        };
        if is_constant {
            let what = format!(
                "'{}' is constant and is set here: the controller does not load the program",
                path.name.shown
            );
            self.log.error(Code::Conflict, line, what);
        }
    }
}

/// Whether the part so many levels above the last one is an element of an array.
fn is_element(path: &Path, from_end: usize) -> bool {
    let mut levels = path.steps.iter().rev().flat_map(|step| match step {
        Step::Index(indices) => vec![true; indices.len()],
        Step::Field(_) => vec![false],
    });
    levels.nth(from_end.saturating_sub(1)).unwrap_or(false)
}
