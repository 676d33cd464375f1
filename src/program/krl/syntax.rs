//! The syntax tree of KRL, as far as motion may depend on it.

use std::collections::{HashMap, HashSet};

use super::signals::Signals;
use super::value::{Sort, Type};
use crate::program::span::Span;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Expr {
    Number(f64, Option<Span>, Sort),
    Bool(bool),
    Text(String),
    Enum(String),
    /// Components in order, by name in lower case.
    Parts(Vec<(String, Expr)>),
    Ref(Path),
    Call(String, Vec<Option<Expr>>),
    Not(Box<Expr>),
    Minus(Box<Expr>),
    Binary(&'static str, Box<Expr>, Box<Expr>),
    /// A comparison beside AND, OR or EXOR without parentheses: as it is meant, the comparison
    /// first, and the other way round, as Siemens has it and KUKA may.
    TwoWays(Box<[Expr; 2]>),
}

impl Expr {
    pub(super) fn of_name(name: &str) -> Self {
        Self::Ref(Path { name: name.to_owned(), indices: Vec::new(), fields: Vec::new() })
    }
}

/// A datum or a part of it, names in lower case: `$vel.cp`, `xp[3].x`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Path {
    pub(super) name: String,
    pub(super) indices: Vec<Expr>,
    pub(super) fields: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Statement {
    pub(super) line: usize,
    /// 0 of the main file, else the place of the other among those that the job names, from 1.
    pub(super) file: usize,
    pub(super) what: What,
}

pub(super) type Block = Vec<Statement>;

/// Of SWITCH: values and what runs for them.
pub(super) type Cases = Vec<(Vec<Expr>, Block)>;

/// How the robot goes to a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    Joint,
    Linear,
    Circular,
    /// A point of a spline.
    Spline,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Motion {
    pub(super) way: Way,
    /// PTP_REL, LIN_REL.
    pub(super) is_relative: bool,
    /// `LIN_REL … #TOOL`: relative to the tool where it is, else along the axes of the base.
    pub(super) is_of_tool: bool,
    pub(super) targets: Vec<Expr>,
    /// CA.
    pub(super) angle: Option<Expr>,
    pub(super) with: Vec<(Path, Expr)>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum What {
    Declare(Type, Vec<Path>, Option<Expr>),
    Assign(Path, Expr),
    Call(String, Vec<Option<Expr>>),
    Move(Box<Motion>),
    Spline(Vec<(Path, Expr)>, Block),
    If(Expr, Block, Block),
    For(Path, [Expr; 2], Option<Expr>, Block),
    While(Expr, Block),
    Repeat(Block, Expr),
    Loop(Block),
    Switch(Expr, Cases, Block),
    /// With the value of a function.
    Return(Option<Expr>),
    Exit,
    Halt,
    WaitSec(Expr),
    Goto(String),
    Label(String),
    /// `INTERRUPT DECL n WHEN … DO …`; what it does is `None` where that is not understood.
    InterruptDecl(Expr, Option<Box<What>>),
    /// `INTERRUPT ON n`, or all.
    InterruptOn(Option<Expr>),
    /// `INTERRUPT OFF n`, of all without a number.
    InterruptOff(Option<Expr>),
    /// `TRIGGER WHEN … DO …`, likewise.
    Trigger(Option<Box<What>>),
    /// A fault if it is ever reached.
    NotUnderstood(String),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Routine {
    pub(super) line: usize,
    /// As written.
    pub(super) shown: String,
    pub(super) parameters: Vec<Parameter>,
    pub(super) body: Block,
    /// Of a function: what it gives.
    pub(super) gives: Option<Type>,
}

impl Routine {
    /// Whether a name is of one of its parameters or of what it declares.
    pub(super) fn declares(&self, name: &str) -> bool {
        let declares = |what: &What| match what {
            What::Declare(_, paths, _) => paths.iter().any(|path| path.name == name),
            _ => false,
        };
        self.parameters.iter().any(|own| own.name == name)
            || self.body.iter().any(|own| declares(&own.what))
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    pub(super) name: String,
    /// IN: what the routine sets stays in it. OUT, and where neither is said, reaches the caller.
    pub(super) is_by_value: bool,
}

/// All that the files declare.
#[derive(Debug, Default)]
pub(super) struct File {
    /// By name in lower case, and the order of the main file.
    pub(super) routines: HashMap<String, Routine>,
    pub(super) order: Vec<String>,
    /// By name in lower case.
    pub(super) functions: HashMap<String, Routine>,
    /// Data lists: what is set before the program runs.
    pub(super) data: Block,
    pub(super) signals: Signals,
    /// Of STRUC: the types that components of a name have.
    pub(super) components: HashMap<String, Vec<Type>>,
    /// What `DECL CONST` declares, by name in lower case.
    pub(super) constants: HashSet<String>,
    /// What is declared for all programs, by name in lower case.
    pub(super) for_all: HashSet<String>,
    pub(super) statement_count: usize,
    pub(super) is_cut: Option<usize>,
}

impl File {
    /// A routine or a function by its name in lower case.
    pub(super) fn routine(&self, name: &str) -> Option<&Routine> {
        self.routines.get(name).or_else(|| self.functions.get(name))
    }
}
