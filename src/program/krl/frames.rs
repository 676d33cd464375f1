//! $TOOL and $BASE: frames of the program, and those that files or the job give by number.

use nalgebra::Isometry3;

use super::eval::number_of;
use super::forms::{BASE, TOOL};
use super::run::{OfWorld, Run};
use super::syntax::{Expr, Path};
use super::value::{FRAME, Sort, Value, base, frame, numbers, pose};
use crate::notes::Code;
use crate::program::cell::{base_frame, tool_frame, without_own_frame};
use crate::program::{Settings, tool_number};

const CHOSEN: OfWorld = (
    Code::FrameFromProgram,
    "the base is $WORLD (base 0), the robot's base frame: the job's work_object is not used there",
);

/// Nothing but the start chooses it: a job may mean it by its work object.
const INITIAL: OfWorld = (
    Code::ChangeIgnored,
    "the base is $WORLD since BAS(#INITMOV), and the job's work_object is taken for it: \
     path.program.base_frames: {0: …} in the job says where $WORLD is, {xyz_m: [0, 0, 0]} for the \
     robot's base frame",
);

const NO_BASE: OfWorld = (
    Code::ChangeIgnored,
    "no line before chooses a base, so that the one of the program that ran before holds; the \
     robot's base frame is taken: work_object in the job says where the base is",
);

/// To the controller $NULLFRAME and tool 0 are the flange; a job may mean it by its tcp.
const FLANGE: &str = "the tool is the flange ($NULLFRAME, tool 0), and the job's tcp is taken for \
                      it: path.program.tool_frames: {0: …} in the job says where tool 0 is, \
                      {xyz_m: [0, 0, 0]} for the flange";

pub(super) const KEPT: &str = "BAS(#INITMOV) has taken tool 1 before, and TOOL_DATA[1] is in no \
                               file that is read: the tool that held then is kept; \
                               path.program.tool_frames: {1: …} in the job says where it is";

const NO_TOOL: &str = "no line before chooses a tool, so that the one of the program that ran \
                       before holds; the tip frame is taken: tcp in the job says where the tool is";

impl<'a> Run<'a> {
    /// `$TOOL=TOOL_DATA[2]`, `$BASE=BASE_DATA[1]`, `$TOOL=STOOL2(FP1)`, `$BASE=SBASE(1)`: frames
    /// that the job may give by number; whether it is one.
    pub(super) fn set_numbered(&mut self, line: usize, path: &Path, expr: &'a Expr) -> bool {
        let (from, index) = match expr {
            Expr::Ref(from) => match (&*from.indices, &*from.fields) {
                ([index], []) => (&*from.name, index),
                _ => return false,
            },
            Expr::Call(name, args) => match &**args {
                [Some(index)] if !self.file.functions.contains_key(name) => (&**name, index),
                _ => return false,
            },
            _ => return false,
        };
        let set = match (path.name.as_str(), from, &*path.fields) {
            ("$tool", "tool_data" | "stool" | "stool2", []) => {
                self.states(TOOL);
                let form = self.eval(index);
                if let ("stool2", Value::Parts(parts)) = (from, &form) {
                    for (key, part) in [("$act_tool", "tool_no"), ("$act_base", "base_no")] {
                        let own = parts.get(part).and_then(|own| own.num().ok());
                        own.into_iter().for_each(|number| self.acts(key, number));
                    }
                }
                number_of(&form, "tool_no").and_then(|n| self.take_tool(n))
            }
            ("$base", "base_data", []) => {
                self.states(BASE);
                let number = self.eval(index).num();
                number.and_then(|n| {
                    let frame = self.base_frame(n)?;
                    self.chooses_numbered_base(n, frame);
                    Ok(())
                })
            }
            ("$base", "sbase", []) => {
                self.states(BASE);
                let number = number_of(&self.eval(index), "base_no");
                number.map(|n| self.chooses_base_number(n))
            }
            _ => return false,
        };
        if let Err(why) = set {
            let shown = path.name.to_uppercase();
            self.log.error(Code::Motion, line, format!("{shown}: {why}"));
        }
        true
    }

    /// `$BASE.X=750`: the other components stay.
    pub(super) fn with_component(
        &mut self,
        which: usize,
        field: &str,
        value: &Value,
    ) -> Result<Isometry3<f64>, String> {
        let index = FRAME.iter().position(|own| *own == field);
        let index = index.ok_or_else(|| format!("a frame has no {}", field.to_uppercase()))?;
        let of_form = self.unknown_form.as_ref().filter(|(_, stated)| !stated[which]);
        let why = of_form.map(|(why, _)| why).or(self.no_base.as_ref().filter(|_| which == BASE));
        if let Some(why) = why {
            return Err(format!("its other components are not known: {why}"));
        }
        let mut six = numbers(if which == TOOL { &self.tcp } else { &self.base });
        six[index] = value.num()?;
        if which == TOOL {
            self.log.tcp_of(None);
            self.tell_of_tool(self.line);
        }
        Ok(pose(six))
    }

    pub(super) fn own_tool(
        &mut self,
        line: usize,
        value: &Value,
    ) -> Result<Isometry3<f64>, String> {
        let own = frame(value.parts()?)?;
        let is_flange = own == Isometry3::identity() && self.has_other_flange();
        self.unsure_tool = Some(FLANGE).filter(|_| is_flange);
        if own == Isometry3::identity() {
            return tool_frame(self.settings, 0.0, "TOOL_DATA");
        }
        if self.settings.tcp.is_some() {
            let what = "the program declares its tool: the job's tcp is not used there";
            self.log.warning(Code::FrameFromProgram, line, what);
        }
        Ok(own)
    }

    pub(super) fn own_base(
        &mut self,
        line: usize,
        value: &Value,
    ) -> Result<Isometry3<f64>, String> {
        let own = frame(value.parts()?)?;
        if self.settings.work_object.is_some() {
            let what = "the program declares its base: the job's work_object is not used there";
            self.log.warning(Code::FrameFromProgram, line, what);
        }
        Ok(own)
    }

    /// TOOL_DATA[n] of the files, else of the job.
    pub(super) fn tool_frame(&mut self, number: f64) -> Result<Isometry3<f64>, String> {
        match self.stated_frame("tool_data", number)? {
            Value::Parts(parts) if number > 0.0 => frame(&parts),
            _ => tool_frame(self.settings, number, "TOOL_DATA"),
        }
    }

    /// What the program, a file or the job says of a frame. What the program has set to what is not
    /// known the job does not give.
    fn stated_frame(&mut self, list: &str, number: f64) -> Result<Value, String> {
        let key = format!("{list}[{number}]");
        let shown = key.to_uppercase();
        match self.datum(&key) {
            Value::Unknown(why) if self.globals.contains_key(&key) => Err(format!(
                "the program sets {shown} to what is not known: {why}; assume: or \
                 path.program.files in the job can give that"
            )),
            _ if self.forgotten.contains(list) && !self.globals.contains_key(&key) => {
                let list = list.to_uppercase();
                Err(format!(
                    "the program sets an element of {list}, and which one is known only at run \
                     time: {shown} may be it"
                ))
            }
            value => Ok(value),
        }
    }

    /// Of a move with the tool, and where the program takes a number from it.
    pub(super) fn tell_of_tool(&mut self, line: usize) {
        if let Some(what) = self.unsure_tool {
            self.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// Where the files or the job have tools or bases by number, and neither the job's `tcp` nor
    /// its `work_object` stands for one: before the program chooses one, another may hold.
    pub(super) fn starts_unchosen(&mut self) {
        let Settings { tcp, work_object, tool_frames, base_frames, .. } = self.settings;
        let lists = |list: &str| self.globals.keys().any(|key| base(key) == list);
        let has_tools = !tool_frames.is_empty() || lists("tool_data");
        let has_bases = base_frames.keys().any(|number| *number > 0) || lists("base_data");
        self.unsure_tool = Some(NO_TOOL).filter(|_| tcp.is_none() && has_tools);
        self.of_world = Some(NO_BASE).filter(|_| work_object.is_none() && has_bases);
    }

    /// Whether the job has a tcp elsewhere than in the flange, and does not say where tool 0 is.
    fn has_other_flange(&self) -> bool {
        self.settings.tcp.is_some_and(|tcp| tcp != Isometry3::identity())
            && !self.settings.tool_frames.contains_key(&0)
    }

    pub(super) fn take_tool(&mut self, number: f64) -> Result<(), String> {
        self.tcp = self.tool_frame(number)?;
        let is_flange = number == 0.0 && self.has_other_flange();
        self.unsure_tool = Some(FLANGE).filter(|_| is_flange);
        let of_file = self.globals.get(&format!("tool_data[{number}]"));
        let is_of_file = matches!(of_file, Some(Value::Parts(_)));
        let of_job = tool_number(number).ok().filter(|_| !is_of_file);
        self.log.tcp_of(of_job.and_then(|number| without_own_frame(self.settings, number)));
        Ok(())
    }

    /// BASE_DATA[n]: only what moves in it must know where it is.
    pub(super) fn chooses_base_number(&mut self, number: f64) {
        self.acts("$act_base", number);
        match self.base_frame(number) {
            Ok(frame) => self.chooses_numbered_base(number, frame),
            Err(why) => (self.no_base, self.of_world) = (Some(why), None),
        }
    }

    /// Number 0 is $WORLD.
    fn chooses_numbered_base(&mut self, number: f64, frame: Isometry3<f64>) {
        self.chooses_base(frame);
        self.of_world = Some(CHOSEN).filter(|_| number == 0.0 && self.has_other_world());
    }

    /// The base of BAS(#INITMOV).
    pub(super) fn starts_in_world(&mut self) {
        let world = self.settings.base_frames.get(&0).or(self.settings.work_object.as_ref());
        self.chooses_base(world.copied().unwrap_or_default());
        self.of_world = Some(INITIAL).filter(|_| self.has_other_world());
    }

    /// The number of the tool or the base that the basic package has chosen (bas.src, TOOL and
    /// BASE).
    pub(super) fn acts(&mut self, key: &str, number: f64) {
        self.globals.insert(key.to_owned(), Value::Num(number, None, Sort::Whole));
    }

    pub(super) fn chooses_base(&mut self, frame: Isometry3<f64>) {
        self.base = frame;
        self.no_base = None;
        self.of_world = None;
    }

    /// Of a move in the base, and where the program takes a number from it: what is made of that no
    /// longer tells.
    pub(super) fn tell_of_world(&mut self) {
        if let Some((code, what)) = self.of_world {
            self.log.warning(code, self.line, what);
        }
    }

    /// Whether the job has a work object elsewhere than $WORLD, and does not say where that is.
    fn has_other_world(&self) -> bool {
        let work_object = self.settings.work_object;
        work_object.is_some_and(|object| object != Isometry3::identity())
            && !self.settings.base_frames.contains_key(&0)
    }

    pub(super) fn base_frame(&mut self, number: f64) -> Result<Isometry3<f64>, String> {
        match self.stated_frame("base_data", number)? {
            Value::Parts(parts) if number > 0.0 => frame(&parts),
            _ => base_frame(self.settings, number, "BASE_DATA"),
        }
    }

    pub(super) fn choose_tool(&mut self, line: usize, number: f64) -> Result<(), String> {
        self.take_tool(number)?;
        self.acts("$act_tool", number);
        // A tool whose load no file gives says nothing of it.
        let key = format!("load_data[{number}]");
        match self.datum(&key) {
            Value::Unknown(_) if !self.globals.contains_key(&key) => self.log.load(None),
            load => self.set_load(line, &load),
        }
        Ok(())
    }
}
