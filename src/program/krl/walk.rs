//! Ways through the syntax tree: blocks of statements, functions in expressions.

use super::syntax::{Block, Expr, Path, What};

/// The blocks of a statement.
pub(super) fn blocks_in(what: &What) -> Vec<&Block> {
    match what {
        What::If(_, yes, no) => vec![yes, no],
        What::For(.., body) | What::While(_, body) | What::Repeat(body, _) | What::Loop(body) => {
            vec![body]
        }
        What::Switch(_, cases, otherwise) => {
            cases.iter().map(|(_, body)| body).chain([otherwise]).collect()
        }
        _ => Vec::new(),
    }
}

/// Functions that expressions call, with what they are given.
pub(super) fn functions_in(open: Vec<&Expr>) -> Vec<(&str, &[Option<Expr>])> {
    let all = all_of(open).into_iter();
    all.filter_map(|expr| match expr {
        Expr::Call(name, args) => Some((name.as_str(), args.as_slice())),
        _ => None,
    })
    .collect()
}

/// Data that expressions name.
pub(super) fn names_in(open: Vec<&Expr>) -> Vec<&str> {
    paths_in(open).into_iter().map(|path| path.name.as_str()).collect()
}

/// The same with indices and components.
pub(super) fn paths_in(open: Vec<&Expr>) -> Vec<&Path> {
    let all = all_of(open).into_iter();
    all.filter_map(|expr| match expr {
        Expr::Ref(path) => Some(path),
        _ => None,
    })
    .collect()
}

/// Expressions and those in them.
pub(super) fn all_of(mut open: Vec<&Expr>) -> Vec<&Expr> {
    let mut found = Vec::new();
    while let Some(expr) = open.pop() {
        found.push(expr);
        match expr {
            Expr::Parts(parts) => open.extend(parts.iter().map(|(_, expr)| expr)),
            Expr::Ref(path) => open.extend(&path.indices),
            Expr::Not(inner) | Expr::Minus(inner) => open.push(inner),
            Expr::Binary(_, left, right) => open.extend([&**left, &**right]),
            Expr::Call(_, args) => open.extend(args.iter().flatten()),
            // Both have the same parts.
            Expr::TwoWays(ways) => open.push(&ways[0]),
            _ => {}
        }
    }
    found
}

/// The expressions of a statement, its blocks aside.
pub(super) fn expressions(what: &What) -> Vec<&Expr> {
    match what {
        What::Declare(.., Some(expr))
        | What::Return(Some(expr))
        | What::WaitSec(expr)
        | What::If(expr, ..)
        | What::While(expr, _)
        | What::Repeat(_, expr)
        | What::Switch(expr, ..) => vec![expr],
        What::Assign(path, expr) => path.indices.iter().chain([expr]).collect(),
        What::Call(_, args) => args.iter().flatten().collect(),
        What::For(_, [from, to], step, _) => [from, to].into_iter().chain(step).collect(),
        What::Move(motion) => {
            let own = motion.targets.iter().chain(&motion.angle);
            own.chain(motion.with.iter().map(|(_, expr)| expr)).collect()
        }
        What::Spline(given, _) => given.iter().map(|(_, expr)| expr).collect(),
        _ => Vec::new(),
    }
}
