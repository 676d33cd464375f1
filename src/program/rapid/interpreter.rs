//! The state of a program that runs: its data, what it has called, where the last motion went.

use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use nalgebra::Isometry3;

use super::carried::{ToolFrame, UnitOff, WorkObject};
use super::late::Late;
use super::modules::Loaded;
use super::number::Number;
use super::syntax::{Expr, File, Name, Routine, Trap};
use super::timed::Timed;
use super::value::Value;
use super::walk::{Named, set_by_others};
use crate::motion::{Load, Turning};
use crate::program::Settings;
use crate::program::cell::{Comments, External, Sets};
use crate::program::log::Log;
use crate::program::spindle_names::Analog;

/// Declarations, expressions and calls in one another beyond this are refused.
pub(super) const MAX_DEPTH: usize = 120;

/// Why nothing is known beyond that.
pub(super) const TOO_DEEP: &str = "declarations and calls are nested too deep";

/// Statements that loops may run beyond one pass through the file.
const STATEMENTS_IN_LOOPS: usize = 1_000_000;

/// A datum of a routine.
#[derive(Debug)]
pub(super) struct Datum<'a> {
    pub(super) kind: &'a str,
    pub(super) value: Value,
    /// The datum of the module that it is another name of, and the way down in that.
    pub(super) stands_for: Option<(&'a str, Vec<usize>)>,
    /// The signal that it is another name of, and the line that says so.
    pub(super) signal: Option<(&'a Name, usize)>,
    pub(super) is_constant: bool,
}

/// How a statement ends.
#[derive(Debug)]
pub(super) enum Flow {
    Next,
    Return(Option<Value>),
    /// A jump to a label, by its name in lower case, out of the blocks that do not have it, and
    /// where it stands.
    Goto {
        label: String,
        line: usize,
        place: String,
    },
    /// The program ends.
    Exit,
}

/// A global datum: its value is worked out when it is first needed.
#[derive(Debug)]
pub(super) enum Global {
    NotYet,
    Busy,
    Known(Value),
}

/// A datum that the job's word has filled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Filled<'a> {
    /// The routine that has it; none: the module.
    pub(super) routine: Option<&'a str>,
    /// The datum of the module that it is, or is another name of.
    pub(super) of_module: Option<&'a str>,
    /// Whether more depends on it than what is shown.
    pub(super) decides: bool,
}

/// What handlers of errors may set, by name in lower case.
#[derive(Debug, Default)]
pub(super) struct Handled<'a> {
    /// Data of the modules, and of no file.
    pub(super) data: HashSet<&'a str>,
    /// Parameters and data of routines.
    pub(super) own: HashMap<&'a str, HashSet<&'a str>>,
    /// Functions that may give what a handler says.
    pub(super) functions: HashSet<&'a str>,
}

pub(super) struct Interpreter<'a> {
    pub(super) file: &'a File,
    pub(super) settings: &'a Settings,
    pub(super) comments: Comments,
    pub(super) log: &'a mut Log,
    pub(super) globals: HashMap<&'a str, Global>,
    /// Those that the program has set, or may have.
    pub(super) written: HashSet<&'a str>,
    /// The data of the routines that run, the innermost last.
    pub(super) frames: Vec<HashMap<String, Datum<'a>>>,
    /// Calls, blocks and expressions in one another.
    pub(super) depth: usize,
    /// Statements that may still run.
    pub(super) budget: usize,
    /// Motion instructions that have run.
    pub(super) motions: usize,
    /// The procedures and functions that run, the innermost last.
    pub(super) running: Vec<&'a Routine>,
    pub(super) external: External,
    /// The line of the main file that runs.
    pub(super) line: usize,
    /// What the program has begun to change of how the arm moves that is not read.
    pub(super) begun: HashSet<&'static str>,
    /// SpeedRefresh as a share.
    pub(super) over: f64,
    /// The first line that moves at vmax, and the lowest speed behind the first move that it gives,
    /// m/s.
    pub(super) at_vmax: Option<(usize, f64)>,
    /// `VelSet`: share of the programmed speed, and its limit in mm/s.
    pub(super) velocity: (f64, f64),
    /// Whether the arm configuration of targets counts: ConfJ for joint moves, ConfL for others.
    pub(super) monitors: [bool; 2],
    /// How the tool turns on arcs, `CirPathMode`; `None` where that is not known.
    pub(super) turning: Option<Turning>,
    /// The work object of the motion before.
    pub(super) active_object: WorkObject,
    /// The tool that `SetSysData` has set since; whether it has set what is not known.
    pub(super) active_tool: Option<ToolFrame>,
    /// The tool of the last move, or of `SetSysData` behind it, where the program declares it.
    pub(super) declared_tool: Option<Value>,
    pub(super) active_unknown: bool,
    /// Whether the arm stands where it went: the last move stops at its end.
    pub(super) has_arrived: bool,
    /// The joints behind it, if they are known, degrees.
    pub(super) joints_now: Option<[f64; 6]>,
    /// Whether the last move may still run: `\Conc` stands there, and nothing has waited for it.
    pub(super) runs_on: bool,
    /// Whether `StopMove` holds the arm on its way.
    pub(super) is_stopped: bool,
    /// Whether no `StartMove` has followed `StopMove`, or may not have.
    pub(super) is_held: bool,
    /// What procedures of moves that do not stop have set.
    pub(super) late: Late<'a>,
    /// Whether such a procedure runs: the arm is on its way.
    pub(super) is_late: bool,
    /// Whether the program starts with `main`: nothing has set data before.
    pub(super) starts_at_main: bool,
    /// How many of the routines that run have handlers of errors.
    pub(super) handlers: usize,
    /// The last call that is in no file.
    pub(super) called_elsewhere: Option<String>,
    /// Of how many AND and OR in one another the second side is worked out that may not count.
    pub(super) guarded: usize,
    /// The last line at which the controller stops as it works something out.
    pub(super) fault_at: Option<usize>,
    /// Functions of no file that give no number or truth value, where somebody has asked.
    pub(super) not_plain: OnceCell<HashSet<&'a str>>,
    /// Units that are switched off.
    pub(super) off: Vec<UnitOff>,
    /// Outputs that the program has set, by name in lower case.
    pub(super) outputs: HashMap<String, Number>,
    pub(super) timed: Timed<'a>,
    /// Data that the program gives to what the job reads the spindle or the tool from.
    pub(super) given_on: HashSet<&'a str>,
    /// Outputs that the procedures set from which the job reads the spindle or the tool, and how
    /// many of these procedures run.
    pub(super) setter_outputs: HashMap<&'a str, (Sets, &'a str)>,
    pub(super) in_setters: usize,
    pub(super) analog: Analog,
    /// What the program sets to what is not known: what the job assumes of it holds no longer.
    pub(super) forgotten: HashSet<String>,
    /// Those of them of which it has only waited for another value than the job assumes.
    pub(super) awaited: HashSet<String>,
    /// Names of which the job's word has counted.
    pub(super) heeded: RefCell<HashSet<String>>,
    /// Names that the job assumes and of which the program has asked its own value: as written, and
    /// the first line that asks.
    pub(super) own_values: BTreeMap<&'a str, (&'a str, usize)>,
    /// Data that no file declares, as the program sets them.
    pub(super) assigned: HashMap<&'a str, Value>,
    /// The data of a name that the job's word has filled in.
    pub(super) filled_in: HashMap<&'a str, Vec<Filled<'a>>>,
    /// Conditions that have been looked at for what others set.
    pub(super) asked_of_others: HashSet<*const Expr>,
    /// Those of the data that others set which have decided about motion, as they are declared.
    pub(super) decided_by: BTreeSet<&'a str>,
    /// Whether ExitCycle has ended the program.
    pub(super) starts_again: bool,
    /// Persistent data that no file sets, by name in lower case.
    pub(super) set_by_others: HashSet<&'a str>,
    /// Data that another task shares and sets, by name in lower case.
    pub(super) set_beside: HashSet<&'a str>,
    /// What the files work out of data that others set, where somebody has asked.
    pub(super) of_others: OnceCell<HashSet<&'a str>>,
    /// What handlers of errors may set, where somebody has asked.
    pub(super) handled: OnceCell<Handled<'a>>,
    /// Data on which motion may depend, where somebody has asked.
    pub(super) of_motion: OnceCell<HashSet<&'a str>>,
    /// For which speeds that no file declares the job's feed has stood: why each is not known.
    pub(super) speeds_of_job: HashSet<String>,
    /// For which work objects that no file declares the job's has stood: why each is not known.
    pub(super) objects_of_job: HashSet<String>,
    /// Data of the module that traps set, with what the job assumes of them.
    pub(super) trapped: HashMap<&'a str, Value>,
    /// Those of them that the program itself has set, and nothing has taken time since.
    pub(super) set_anew: HashSet<&'a str>,
    /// Data of the module that traps set which the program does not connect.
    pub(super) elsewhere: HashSet<&'a str>,
    /// Data that no file declares, read as the program has set them.
    pub(super) believed: HashSet<&'a str>,
    /// Traps that may run, with the names of their interrupts.
    pub(super) connected: Vec<(Option<&'a str>, &'a Trap)>,
    /// Whether the job's tcp and work object stand for data that no file declares, and not for
    /// tool0 and wobj0 beside them.
    pub(super) stands_for: Named,
    /// Lines and arcs with tool0, and those in wobj0, for which the job's stand.
    pub(super) led: [Led; 2],
    /// What `GripLoad` says that the gripper holds, in the frame of the tool, or of the work object
    /// where the arm holds that; or why that is not known.
    pub(super) gripped: Result<Option<Load>, String>,
    pub(super) loaded: Loaded,
}

/// How the tool is led.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Led {
    /// First line under the controller's own frame, for which the job's stands.
    pub(super) by_own: Option<usize>,
    /// Whether it is led under a frame that the program declares, too.
    pub(super) by_declared: bool,
}

impl<'a> Interpreter<'a> {
    /// The signal that a name stands for: that of an argument is the caller's.
    pub(super) fn signal_of<'n>(&self, name: &'n Name) -> &'n Name
    where
        'a: 'n,
    {
        let own = self.frames.last().and_then(|frame| frame.get(&name.key));
        own.and_then(|datum| datum.signal).map_or(name, |(signal, _)| signal)
    }

    /// What the job has for tool0 and for wobj0.
    pub(super) fn own_frames(&self) -> [Option<Isometry3<f64>>; 2] {
        let Named { tool, work_object } = self.stands_for;
        [self.settings.tcp.filter(|_| !tool), self.settings.work_object.filter(|_| !work_object)]
    }

    pub(super) fn new(
        file: &'a File,
        settings: &'a Settings,
        comments: Comments,
        log: &'a mut Log,
    ) -> Self {
        Self {
            file,
            settings,
            comments,
            log,
            globals: HashMap::new(),
            written: HashSet::new(),
            frames: Vec::new(),
            forgotten: HashSet::new(),
            awaited: HashSet::new(),
            depth: 0,
            budget: budget(file),
            motions: 0,
            running: Vec::new(),
            external: External::new(settings),
            line: 1,
            begun: HashSet::new(),
            over: 1.0,
            at_vmax: None,
            velocity: (1.0, f64::INFINITY),
            monitors: [true; 2],
            turning: Some(Turning::WithArc),
            active_object: WorkObject::default(),
            led: [Led::default(); 2],
            active_tool: None,
            declared_tool: None,
            active_unknown: false,
            has_arrived: true,
            runs_on: false,
            is_stopped: false,
            is_held: false,
            late: Late::default(),
            is_late: false,
            starts_at_main: false,
            handlers: 0,
            called_elsewhere: None,
            guarded: 0,
            fault_at: None,
            not_plain: OnceCell::new(),
            off: Vec::new(),
            joints_now: None,
            outputs: HashMap::new(),
            timed: Timed::of(file),
            given_on: HashSet::new(),
            setter_outputs: HashMap::new(),
            in_setters: 0,
            analog: Analog::default(),
            heeded: RefCell::new(HashSet::new()),
            own_values: BTreeMap::new(),
            assigned: HashMap::new(),
            filled_in: HashMap::new(),
            speeds_of_job: HashSet::new(),
            asked_of_others: HashSet::new(),
            decided_by: BTreeSet::new(),
            starts_again: false,
            set_by_others: set_by_others(file),
            set_beside: HashSet::new(),
            of_others: OnceCell::new(),
            handled: OnceCell::new(),
            of_motion: OnceCell::new(),
            objects_of_job: HashSet::new(),
            trapped: HashMap::new(),
            set_anew: HashSet::new(),
            elsewhere: HashSet::new(),
            believed: HashSet::new(),
            connected: Vec::new(),
            stands_for: Named::default(),
            gripped: Ok(None),
            loaded: Loaded::default(),
        }
    }
}

/// Statements that one cycle may run.
pub(super) fn budget(file: &File) -> usize {
    file.statement_count.saturating_mul(2).saturating_add(STATEMENTS_IN_LOOPS)
}
