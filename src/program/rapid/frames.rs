//! Frames of tools and work objects.

use std::sync::Arc;

use nalgebra::Isometry3;

use super::carried::{Carrier, Holds, ToolFrame, WorkObject};
use super::eval::Scope;
use super::interpreter::Interpreter;
use super::own_frame::frame_of_tool;
use super::syntax::{Args, Expr};
use super::value::{Value, pose};
use super::why::Why;
use crate::motion::Work;
use crate::notes::Code;
use crate::program::log::Tool;

impl<'a> Interpreter<'a> {
    /// Of data of the names of the controller's own tool and work object that all modules see and
    /// that say otherwise: the controller may refuse them.
    pub(super) fn doubt_own_frames(&mut self) {
        let file = self.file;
        for key in ["tool0", "wobj0"] {
            let Some(own) = file.data.get(key).filter(|own| !own.is_local) else { continue };
            let is_known = self.work_out(own).is_ok();
            let value = self.own_root(Scope::Module, key).filter(|_| is_known);
            if matches!(value, Some(Value::Tool0 | Value::Wobj0)) {
                continue;
            }
            let what = format!(
                "'{key}' is the controller's own, and is declared otherwise here: the declaration \
                 is used where '{key}' is named, and the controller may refuse it or use its own; \
                 give it another name"
            );
            self.log.warning(Code::ChangeIgnored, own.line.max(1), what);
        }
    }

    /// Of a line or arc: whether the job's frames stand for the controller's own there.
    pub(super) fn note_led(&mut self, line: usize, tool: &'a Expr, work_object: Option<&Value>) {
        let [tcp, of_job] = self.own_frames().map(|own| own.unwrap_or_default());
        let is_moved = [tcp, of_job].map(|frame| frame != Isometry3::identity());
        let tool = if is_moved[0] { self.eval(tool) } else { Value::Tool0 };
        let both = [&tool, work_object.unwrap_or(&Value::Wobj0)];
        for ((led, value), is_moved) in self.led.iter_mut().zip(both).zip(is_moved) {
            match value {
                _ if !is_moved => {}
                Value::Tool0 | Value::Wobj0 => led.by_own = led.by_own.or(Some(line)),
                declared => {
                    let is_known = declared.why_first_unknown().is_none();
                    led.by_declared |= is_known && !matches!(declared, Value::Unknown(_));
                }
            }
        }
    }

    /// A job's frame beside those of the program is seldom meant for the controller's own.
    pub(super) fn tell_led(&mut self) {
        for (led, [name, of, what, of_job]) in self.led.into_iter().zip([
            ["tool0", "tools", "the flange", "tcp"],
            ["wobj0", "work objects", "the base frame", "work_object"],
        ]) {
            let Some(line) = led.by_own.filter(|_| led.by_declared) else { continue };
            let what = format!(
                "a line or arc with {name}, and others with {of} that the program declares: to the \
                 controller {name} is {what}, and the job's {of_job} is taken for it; leave \
                 {of_job} out of the job, or name for these moves what the program declares"
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    pub(super) fn tool_centre_point(
        &mut self,
        line: usize,
        expr: &'a Expr,
    ) -> Result<ToolFrame, String> {
        let tool = self.eval(expr);
        let why = match &tool {
            Value::Unknown(why) => Some(why),
            tool => tool.why_first_unknown(),
        };
        let of_job = match (expr, &tool) {
            (Expr::Ref(path), _) if why.is_some() => {
                let elsewhere = why.and_then(Why::of_other_file);
                Some(Tool::Name(elsewhere.unwrap_or(&path.name.shown).to_owned()))
            }
            (_, Value::Tool0) if self.own_frames()[0].is_some() => {
                Some(Tool::Name("tool0".to_owned()))
            }
            _ => None,
        };
        self.log.tcp_of(of_job);
        self.declared_tool =
            matches!(tool, Value::List(_)).then(|| tool.clone()).filter(|_| why.is_none());
        self.tcp_of(line, Some(expr), &tool)
    }

    /// Where a tool has its centre point.
    pub(super) fn tcp_of(
        &mut self,
        line: usize,
        expr: Option<&Expr>,
        tool: &Value,
    ) -> Result<ToolFrame, String> {
        if let (Some(why), Some(tcp)) = (tool.why_first_unknown(), self.settings.tcp) {
            // A load alone says nothing of where it ends.
            let is_frame = !matches!(tool.part(1, "a tool"), Ok(Value::Unknown(_)));
            let code = if is_frame { Code::ChangeIgnored } else { self.code_of_assumed(expr, why) };
            self.log.warning(code, line, format!("tool: {why}; the job's tcp is used"));
            return Ok((tcp, Holds::Tool));
        }
        match (tool, self.settings.tcp) {
            (Value::Tool0, _) => Ok((self.own_frames()[0].unwrap_or_default(), Holds::Tool)),
            (Value::Unknown(why), Some(tcp)) => {
                let code = self.code_of_assumed(expr, why);
                self.log.warning(code, line, format!("tool: {why}; the job's tcp is used"));
                Ok((tcp, Holds::Tool))
            }
            (Value::Unknown(why), None) => Err(format!("tool: {why}; give the tcp in the job")),
            (_, tcp) => {
                if tcp.is_some() {
                    let what = "the program declares its tool: the job's tcp is not used there";
                    self.log.warning(Code::FrameFromProgram, line, what);
                }
                frame_of_tool(tool).map_err(|why| format!("tool: {why}"))
            }
        }
    }

    /// The job stands in for data of other files, but not for what the program itself sets, or
    /// what the run decides.
    pub(super) fn code_of_assumed(&self, expr: Option<&Expr>, why: &Why) -> Code {
        match expr {
            Some(Expr::Ref(path)) if self.assigned.contains_key(path.name.key.as_str()) => {
                Code::ChangeIgnored
            }
            _ if why.of_other_file().is_some() => Code::Assumed,
            _ => Code::ChangeIgnored,
        }
    }

    pub(super) fn work_object(
        &mut self,
        line: usize,
        given: Option<&Value>,
        args: &'a Args,
    ) -> Result<WorkObject, String> {
        let object = given.unwrap_or(&Value::Wobj0);
        if let (Some(why), Some(frame)) = (object.why_first_unknown(), self.settings.work_object) {
            let what = format!(
                "work object: {why}; the job's work_object is used, and not what the program sets \
                 of it"
            );
            self.log.warning(Code::ChangeIgnored, line, what);
            return Ok(WorkObject::fixed(frame));
        }
        match (object, self.settings.work_object) {
            (Value::Wobj0, _) if self.stands_for.work_object => Ok(WorkObject::default()),
            (Value::Wobj0, frame) => {
                if given.is_some() && frame.is_some() {
                    self.log.warning(
                        Code::Assumed,
                        line,
                        "wobj0 is named: the job's work_object is used for it",
                    );
                }
                Ok(WorkObject::fixed(frame.unwrap_or_default()))
            }
            (Value::Unknown(why), Some(frame)) => {
                let mut code = self.code_of_assumed(args.optional_value("wobj"), why);
                let mut what = format!("work object: {why}; the job's work_object is used");
                if why.is_another(&mut self.objects_of_job) {
                    // They differ, or there would be one.
                    code = Code::ChangeIgnored;
                    what.push_str(" for more than one of them");
                }
                self.log.warning(code, line, what);
                Ok(WorkObject::fixed(frame))
            }
            (Value::Unknown(why), None) => {
                Err(format!("work object: {why}; give the work_object in the job"))
            }
            (object, frame) => {
                if frame.is_some() {
                    self.log.warning(
                        Code::FrameFromProgram,
                        line,
                        "the program declares its work object: the job's work_object is not used \
                         there",
                    );
                }
                let object = self.declared_work_object(object);
                object.map_err(|why| format!("work object: {why}"))
            }
        }
    }

    /// uframe ∘ oframe of a work object, in the frame of what carries it.
    fn declared_work_object(&self, object: &Value) -> Result<WorkObject, String> {
        let is_held = object.part(0, "a work object")?.bool()?;
        let is_fixed = object.part(1, "a work object")?.bool()?;
        let user = pose(object.part(3, "a user frame")?)?;
        let frame = pose(object.part(4, "an object frame")?)?;
        if is_fixed {
            let on = if is_held { Carrier::Arm } else { Carrier::Ground };
            return Ok(WorkObject { on, frame: user * frame });
        }
        let name = match object.part(2, "a work object")? {
            Value::Text(name) => name.to_string(),
            _ => String::new(),
        };
        if name.is_empty() {
            return Err("it moves (ufprog FALSE), and ufmec names no mechanical unit".to_owned());
        }
        let Some(unit) = self.settings.mechanical_units.get(&name.to_lowercase()) else {
            return Err(format!(
                "it moves with the mechanical unit '{name}' (ufprog FALSE), whose place no program \
                 says; write path.program.mechanical_units: {{{name}: {{axes: [{{name: eax_a, \
                 axis: [0, 0, 1], origin_m: …}}], user_frame: …}}}} in the job"
            ));
        };
        if is_held {
            return Err(format!("the arm holds it (robhold TRUE), and so does '{name}'"));
        }
        Ok(WorkObject { on: Carrier::Unit(Arc::clone(unit)), frame })
    }

    /// Where the work is on a move, from what the arm carries.
    pub(super) fn work(
        &mut self,
        line: usize,
        holds: Holds,
        object: &WorkObject,
    ) -> Result<Work, String> {
        self.work_behind(line, holds, object, self.log.has_moved())
    }

    /// The same; `has_start`: whether external axes start from where a move before has left them.
    pub(super) fn work_behind(
        &mut self,
        line: usize,
        holds: Holds,
        object: &WorkObject,
        has_start: bool,
    ) -> Result<Work, String> {
        match (holds, &object.on) {
            (Holds::Tool, Carrier::Ground) => Ok(Work::Stands),
            (Holds::Tool, Carrier::Unit(unit)) => {
                let what = format!("the mechanical unit '{}' is taken as rigid", unit.name);
                self.log.warning(Code::Assumed, line, what);
                self.external.work_on(unit, has_start)
            }
            (Holds::Work, Carrier::Arm) => Ok(Work::Held),
            (Holds::Tool, Carrier::Arm) => {
                Err("the arm holds the work object (robhold TRUE), and the tool, too".to_owned())
            }
            (Holds::Work, _) => Err("the tool stands (robhold FALSE), and the arm does not hold \
                                       the work object; name one with robhold TRUE"
                .to_owned()),
        }
    }
}
