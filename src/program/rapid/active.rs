//! `SetSysData`: the tool and the work object that count until the next move, for what asks for
//! where the arm is, or for the tool (`CTool`); and the load, which counts as that of `GripLoad`.

use nalgebra::Isometry3;

use super::carried::{Carrier, Holds, WorkObject};
use super::constants::predefined;
use super::interpreter::Interpreter;
use super::syntax::{Args, Expr};
use super::value::Value;
use crate::notes::Code;

const OPEN: &str = "SetSysData sets what is not known";

impl<'a> Interpreter<'a> {
    /// Type of a datum, or of the elements of an array.
    pub(super) fn kind_of(&self, key: &str) -> Option<&str> {
        let local = self.frames.last().and_then(|frame| frame.get(key)).map(|datum| datum.kind);
        let own = local.or_else(|| self.file.data.get(key).map(|data| data.kind.as_str()));
        own.or_else(|| predefined(key).map(|(_, kind)| kind))
    }

    /// What `SetSysData` sets, by its type.
    fn kind_set(&self, args: &Args) -> Option<String> {
        match args.positional.first() {
            Some(Expr::Ref(path)) => self.kind_of(&path.name.key).map(str::to_owned),
            _ => None,
        }
    }

    /// `SetSysData tool1;`
    pub(super) fn set_sys_data(&mut self, line: usize, args: &'a Args) {
        self.doubt_beside(Code::ChangeIgnored, line, "SetSysData");
        let kind = self.kind_set(args);
        let Some(expr) = args.positional.first() else { return self.lose_active(args) };
        let value = self.eval(expr);
        let is_open = matches!(value, Value::Unknown(_)) || value.why_first_unknown().is_some();
        let done = match kind.as_deref() {
            Some("loaddata") => return self.grip(line, args),
            Some("tooldata") if !is_open => {
                self.declared_tool = matches!(value, Value::List(_)).then(|| value.clone());
                self.tcp_of(line, Some(expr), &value).map(|frame| self.active_tool = Some(frame))
            }
            Some("wobjdata") if !is_open => {
                self.work_object(line, Some(&value), args).map(|object| self.active_object = object)
            }
            _ => Err(String::new()),
        };
        if done.is_err() {
            self.lose_active(args);
        }
    }

    /// Where what it sets, or whether it does, only the run knows.
    pub(super) fn lose_active(&mut self, args: &Args) {
        let kind = self.kind_set(args);
        if !matches!(kind.as_deref(), Some("tooldata" | "wobjdata")) {
            self.gripped = Err(OPEN.to_owned());
        }
        self.active_unknown = true;
    }

    /// Why the tool or the work object of before is not known.
    pub(super) fn why_not_active(&self) -> Option<String> {
        self.active_unknown.then(|| OPEN.to_owned())
    }

    /// Whether a function gives the tool or the work object for which that of the job stands.
    pub(super) fn gives_jobs(&self, key: &str) -> bool {
        let has_moved = self.log.has_moved();
        match key {
            _ if self.active_unknown => false,
            "ctool" => {
                let of = |holds_work| if holds_work { Holds::Work } else { Holds::Tool };
                let last = self.log.last().map(|last| (last.tcp, of(last.holds_work)));
                match self.active_tool.or(last) {
                    Some((tcp, holds)) => holds == Holds::Tool && Some(tcp) == self.settings.tcp,
                    None => !has_moved,
                }
            }
            "cwobj" => {
                let WorkObject { on, frame } = &self.active_object;
                let is_none = !has_moved && *frame == Isometry3::identity();
                matches!(on, Carrier::Ground)
                    && (is_none || Some(*frame) == self.settings.work_object)
            }
            _ => false,
        }
    }
}
