//! What the procedures of `MoveLSync` and its like have set while the arm is still on its way to
//! where they run.

use std::collections::{HashMap, HashSet};

use super::carried::UnitOff;
use super::value::Value;
use crate::motion::{Load, Turning};

/// How the arm moves, as instructions have set it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Modes {
    pub(super) over: f64,
    pub(super) velocity: (f64, f64),
    pub(super) monitors: [bool; 2],
    pub(super) turning: Option<Turning>,
    pub(super) gripped: Result<Option<Load>, String>,
    pub(super) off: Vec<UnitOff>,
}

#[derive(Debug, Default)]
pub(super) struct Late<'a> {
    /// Data of the modules as the procedures leave them; `None`: nothing is known of them.
    pub(super) data: HashMap<&'a str, Option<Value>>,
    /// Data that the procedures ask for or set.
    pub(super) used: HashSet<&'a str>,
    /// The modes before and behind the procedures, where they set them.
    pub(super) modes: Option<Box<[Modes; 2]>>,
    /// Whether the procedures set the spindle or the tool.
    pub(super) sets: bool,
    /// The last of them.
    pub(super) shown: &'a str,
}
