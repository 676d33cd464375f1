//! The syntax tree of RAPID, as far as motion may depend on it.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;

use crate::program::span::Span;

/// A name: RAPID ignores case.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    /// In lower case, to look up.
    pub(super) key: String,
    /// As written, to show.
    pub(super) shown: String,
}

impl Name {
    pub(super) fn new(shown: &str) -> Self {
        Self { key: shown.to_lowercase(), shown: shown.to_owned() }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Expr {
    /// With its place in the text of the main file.
    Number(f64, Option<Span>),
    Text(String),
    Bool(bool),
    List(Vec<Expr>),
    Ref(Box<Path>),
    Call(Box<(Name, Args)>),
    Not(Box<Expr>),
    Minus(Box<Expr>),
    Binary(Operator, Box<Expr>, Box<Expr>),
    /// `NOT a AND b` without parentheses: as the controller has it, NOT over all that AND joins
    /// (kernel grammar: `[NOT] term {OR term}`), and with NOT over the first alone.
    TwoWays(Box<[Expr; 2]>),
}

/// A datum or a part of it: `p10`, `p{3}`, `p10.trans.x`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Path {
    pub(super) name: Name,
    pub(super) steps: Vec<Step>,
    /// Place of the name in the text of the main file.
    pub(super) span: Option<Span>,
}

impl Path {
    /// Whether it is a datum and no part of one.
    pub(super) fn is_whole(&self) -> bool {
        self.steps.is_empty()
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step {
    Index(Vec<Expr>),
    Field(String),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Or,
    Xor,
    And,
    Equal,
    Unequal,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Plus,
    Minus,
    Times,
    Over,
    Div,
    Mod,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Args {
    pub(super) positional: Vec<Expr>,
    /// `\Name`, `\Name:=value`, `\Name?parameter`, by name in lower case.
    pub(super) optional: Vec<(String, Optional)>,
}

impl Args {
    /// `\Name:=value`.
    pub(super) fn optional_value(&self, wanted: &str) -> Option<&Expr> {
        self.optional.iter().find_map(|(name, value)| match value {
            Optional::Value(expr) if name == wanted => Some(expr),
            _ => None,
        })
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Optional {
    Switch,
    Value(Expr),
    IfPresent(Name),
}

/// A file beside the main one, and a line of it.
pub(super) type There = (Rc<str>, usize);

/// What stands before what is told of a place there.
pub(super) fn place_of(there: Option<&There>) -> String {
    there.map_or_else(String::new, |(file, line)| format!("{file}:{line}: "))
}

/// A statement and the line of its first token.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Statement {
    pub(super) line: usize,
    /// Where it stands, if not in the main file; its line is 0 then.
    pub(super) there: Option<There>,
    pub(super) what: What,
}

pub(super) type Block = Vec<Statement>;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum What {
    Declare(Declaration),
    Assign(Path, Expr),
    Call(Name, Args),
    /// A call by a name in a string: the name, what is given, and the procedures that it may be
    /// that of, by name in lower case, each with its call.
    CallByName(Expr, Args, Vec<(String, Block)>),
    If(Vec<(Expr, Block)>, Block),
    For {
        variable: Name,
        from: Expr,
        to: Expr,
        step: Option<Expr>,
        body: Block,
    },
    While(Expr, Block),
    Test(Expr, Vec<(Vec<Expr>, Block)>, Block),
    Return(Option<Expr>),
    Goto(Name),
    Label(Name),
    /// A fault if it is ever reached.
    NotUnderstood(String),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Declaration {
    pub(super) line: usize,
    /// PERS: other tasks have it, too, where it is neither TASK nor LOCAL.
    pub(super) is_persistent: bool,
    /// `TASK PERS`: this task alone has it.
    pub(super) is_of_task: bool,
    /// LOCAL: its module alone has it.
    pub(super) is_local: bool,
    /// CONST: nothing sets it.
    pub(super) is_constant: bool,
    /// Type, in lower case.
    pub(super) kind: String,
    pub(super) name: Name,
    pub(super) dimensions: Vec<Expr>,
    pub(super) value: Option<Expr>,
}

impl Declaration {
    /// Whether all tasks may have it.
    pub(super) fn is_of_tasks(&self) -> bool {
        self.is_persistent && !self.is_of_task && !self.is_local
    }
}

/// A PROC or FUNC.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Routine {
    pub(super) line: usize,
    /// As of a statement.
    pub(super) there: Option<There>,
    /// Line of its end.
    pub(super) end: usize,
    /// Words of its handlers of errors, in lower case, which are not read.
    pub(super) in_handlers: HashSet<String>,
    /// Their statements, as far as they are understood: they never run here.
    pub(super) handlers: Block,
    /// Line at which they begin.
    pub(super) handlers_from: usize,
    pub(super) name: Name,
    /// Its module, in lower case.
    pub(super) module: String,
    pub(super) parameters: Vec<Parameter>,
    pub(super) body: Block,
}

/// A TRAP, with the statements of its handlers of errors.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Trap {
    pub(super) line: usize,
    /// As of a statement.
    pub(super) there: Option<There>,
    pub(super) name: Name,
    pub(super) body: Block,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    pub(super) name: Name,
    pub(super) kind: String,
    pub(super) optional: bool,
    /// VAR, PERS or INOUT: what the routine assigns reaches the caller.
    pub(super) by_reference: bool,
}

/// All modules of a file together, by name in lower case.
#[derive(Debug, Default)]
pub(super) struct File {
    pub(super) data: HashMap<String, Declaration>,
    /// Where data of other files than the main one are declared.
    pub(super) places: HashMap<String, String>,
    pub(super) procedures: HashMap<String, Routine>,
    /// Keys of `procedures` in the order of the file.
    pub(super) procedure_order: Vec<String>,
    pub(super) functions: HashMap<String, Routine>,
    pub(super) traps: Vec<Trap>,
    /// Keys of the data that two tasks share: a file of each declares them.
    pub(super) shared: HashSet<String>,
    /// User's records: fields (name, type) by type.
    pub(super) records: HashMap<String, Vec<(String, String)>>,
    pub(super) statement_count: usize,
}
