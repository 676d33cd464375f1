//! Ways through the syntax tree: blocks and statements in blocks, functions in expressions.

use std::collections::HashSet;

use super::instructions::{ToolAt, motion};
use super::syntax::{Args, Block, Expr, File, Name, Optional, Routine, Step, What};

/// The blocks of a statement.
pub(super) fn blocks_in(what: &What) -> Vec<&Block> {
    match what {
        What::If(branches, otherwise) => {
            branches.iter().map(|(_, body)| body).chain([otherwise]).collect()
        }
        What::Test(_, cases, otherwise) => {
            cases.iter().map(|(_, body)| body).chain([otherwise]).collect()
        }
        What::For { body, .. } | What::While(_, body) => vec![body],
        _ => Vec::new(),
    }
}

/// All statements of blocks and of those in them.
pub(super) fn statements_in<'a>(
    blocks: impl Iterator<Item = &'a Block>,
) -> impl Iterator<Item = &'a What> {
    let mut open: Vec<&'a What> = blocks.flatten().map(|statement| &statement.what).collect();
    std::iter::from_fn(move || {
        let what = open.pop()?;
        open.extend(blocks_in(what).into_iter().flatten().map(|statement| &statement.what));
        Some(what)
    })
}

/// Whether motion names a tool, and a work object, that no file that is read declares.
pub(super) fn has_undeclared_frames(file: &File) -> [bool; 2] {
    let mut found = [false; 2];
    let routines = file.procedures.values().chain(file.functions.values());
    let bodies = routines.map(|own| (own_names(own), &own.body));
    let traps = file.traps.iter().map(|trap| (HashSet::new(), &trap.body));
    for (own, body) in bodies.chain(traps) {
        for what in statements_in(std::iter::once(body)) {
            let What::Call(name, args) = what else { continue };
            let Some(motion) = motion(&name.key) else { continue };
            let tool = match motion.tool {
                ToolAt::Index(index) => args.positional.get(index),
                ToolAt::Last => args.positional.last(),
            };
            let is_elsewhere = |expr: Option<&Expr>, of_language: &str| match expr {
                Some(Expr::Ref(path)) => {
                    let key = path.name.key.as_str();
                    key != of_language && !own.contains(key) && !file.data.contains_key(key)
                }
                _ => false,
            };
            found[0] |= is_elsewhere(tool, "tool0");
            found[1] |= is_elsewhere(args.optional_value("wobj"), "wobj0");
        }
    }
    found
}

/// Parameters and data of a routine.
fn own_names(routine: &Routine) -> HashSet<&str> {
    let declared = statements_in(std::iter::once(&routine.body)).filter_map(|what| match what {
        What::Declare(declaration) => Some(&declaration.name),
        _ => None,
    });
    let given = routine.parameters.iter().map(|parameter| &parameter.name);
    declared.chain(given).map(|name| name.key.as_str()).collect()
}

/// Functions that the expressions of a statement call, with what they are given, its blocks aside.
pub(super) fn functions_in(what: &What) -> Vec<&(Name, Args)> {
    let mut open: Vec<&Expr> = Vec::new();
    match what {
        What::Declare(declaration) => {
            open.extend(declaration.dimensions.iter().chain(&declaration.value));
        }
        What::Assign(path, value) => {
            of_steps(&path.steps, &mut open);
            open.push(value);
        }
        What::Call(_, args) => of_args(args, &mut open),
        What::If(branches, _) => open.extend(branches.iter().map(|(condition, _)| condition)),
        What::For { from, to, step, .. } => open.extend([from, to].into_iter().chain(step)),
        What::While(expr, _) | What::Return(Some(expr)) => open.push(expr),
        What::Test(tested, cases, _) => {
            open.push(tested);
            open.extend(cases.iter().flat_map(|(values, _)| values));
        }
        _ => {}
    }
    functions_of(open)
}

/// The same of expressions.
pub(super) fn functions_of(open: Vec<&Expr>) -> Vec<&(Name, Args)> {
    let all = all_of(open).into_iter();
    all.filter_map(|expr| match expr {
        Expr::Call(call) => Some(&**call),
        _ => None,
    })
    .collect()
}

/// Data that expressions name.
pub(super) fn names_in(open: Vec<&Expr>) -> Vec<&Name> {
    let all = all_of(open).into_iter();
    all.filter_map(|expr| match expr {
        Expr::Ref(path) => Some(&path.name),
        _ => None,
    })
    .collect()
}

/// Expressions and those in them.
fn all_of(mut open: Vec<&Expr>) -> Vec<&Expr> {
    let mut found = Vec::new();
    while let Some(expr) = open.pop() {
        found.push(expr);
        match expr {
            Expr::List(parts) => open.extend(parts),
            Expr::Ref(path) => of_steps(&path.steps, &mut open),
            Expr::Call(call) => of_args(&call.1, &mut open),
            Expr::Not(inner) | Expr::Minus(inner) => open.push(inner),
            Expr::Binary(_, left, right) => open.extend([&**left, &**right]),
            Expr::Number(..) | Expr::Text(_) | Expr::Bool(_) => {}
        }
    }
    found
}

fn of_args<'a>(args: &'a Args, open: &mut Vec<&'a Expr>) {
    open.extend(&args.positional);
    open.extend(args.optional.iter().filter_map(|(_, value)| match value {
        Optional::Value(expr) => Some(expr),
        _ => None,
    }));
}

fn of_steps<'a>(steps: &'a [Step], open: &mut Vec<&'a Expr>) {
    for step in steps {
        if let Step::Index(indices) = step {
            open.extend(indices);
        }
    }
}
