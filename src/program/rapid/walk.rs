//! Ways through the syntax tree: blocks and statements in blocks, functions in expressions.

use std::collections::HashSet;

use super::instructions::{ToolAt, is_synced, may_be_set, motion};
use super::syntax::{
    Args, Block, Declaration, Expr, File, Name, Optional, Path, Routine, Step, What,
};

/// The blocks of a statement.
pub(super) fn blocks_in(what: &What) -> Vec<&Block> {
    match what {
        What::If(branches, otherwise) => {
            branches.iter().map(|(_, body)| body).chain([otherwise]).collect()
        }
        What::CallByName(.., among) => among.iter().map(|(_, call)| call).collect(),
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

/// Blocks, and those of what they call in the files.
pub(super) fn blocks_within<'a>(file: &'a File, blocks: &[&'a Block]) -> Vec<&'a Block> {
    let mut seen: HashSet<&str> = HashSet::new();
    let (mut open, mut found) = (blocks.to_vec(), Vec::new());
    while let Some(block) = open.pop() {
        found.push(block);
        for what in statements_in(std::iter::once(block)) {
            let called = routines_in(file, what).into_iter();
            let new = called.filter(|routine| seen.insert(&routine.name.key));
            open.extend(new.map(|routine| &routine.body));
        }
    }
    found
}

/// The routines of the files that a statement calls, its blocks aside.
pub(super) fn routines_in<'a>(file: &'a File, what: &'a What) -> Vec<&'a Routine> {
    let functions = functions_in(what).into_iter();
    let functions = functions.filter_map(|(name, _)| file.functions.get(&name.key));
    let procedure = match what {
        What::Call(name, args) => {
            let own = file.procedures.get(&name.key);
            own.or_else(|| synced_procedure(file, name, args))
        }
        _ => None,
    };
    functions.chain(procedure).collect()
}

/// What is called in blocks, and in what of the files they call, and is in no file.
pub(super) fn calls_in<'a>(file: &'a File, blocks: &[&'a Block]) -> Vec<(&'a Name, &'a Args)> {
    let all = blocks_within(file, blocks).into_iter();
    all.flat_map(|block| statements_in(std::iter::once(block)))
        .filter_map(|what| match what {
            What::Call(name, args) if !file.procedures.contains_key(&name.key) => {
                Some((name, args))
            }
            _ => None,
        })
        .collect()
}

/// The name of the procedure of `MoveLSync` and its like; its module may stand before it.
pub(super) fn synced_name(args: &Args) -> Option<&str> {
    match args.positional.last() {
        Some(Expr::Text(text)) => Some(text.trim()),
        _ => None,
    }
}

/// That procedure, where a call is such a move, and the files have it, and no other of its name.
pub(super) fn synced_procedure<'a>(
    file: &'a File,
    name: &Name,
    args: &Args,
) -> Option<&'a Routine> {
    let own = synced_name(args).filter(|_| is_synced(&name.key))?;
    let own = own.to_lowercase();
    let (module, own) = match own.split_once(':') {
        Some((module, own)) => (Some(module.trim()), own.trim()),
        None => (None, own.as_str()),
    };
    // A LOCAL one may have another key.
    let is_it = |routine: &&Routine| {
        routine.name.shown.to_lowercase() == own
            && module.is_none_or(|module| routine.module == module)
    };
    let mut found = file.procedures.values().filter(is_it);
    found.next().filter(|_| found.next().is_none())
}

/// The procedures that may run, by name in lower case: the one that the program starts with,
/// `main`, and all that these, functions and traps name, in calls, texts and handlers of errors.
/// `None` where a name is worked out.
pub(super) fn reached<'a>(file: &'a File, entry: &'a Routine) -> Option<HashSet<&'a str>> {
    reached_from(file, vec![&entry.name.key, "main"])
}

/// The same, from these procedures on.
pub(super) fn reached_from<'a>(
    file: &'a File,
    mut names: Vec<&'a str>,
) -> Option<HashSet<&'a str>> {
    let mut found: HashSet<&str> = HashSet::new();
    let of_handlers = |routine: &'a Routine| {
        let own = file.procedures.keys().filter(|key| routine.in_handlers.contains(*key));
        own.map(String::as_str)
    };
    let functions = file.functions.values();
    let mut open: Vec<&Block> = functions.clone().map(|own| &own.body).collect();
    open.extend(file.traps.iter().map(|trap| &trap.body));
    names.extend(functions.flat_map(of_handlers));
    loop {
        for what in statements_in(open.drain(..)) {
            match what {
                What::NotUnderstood(_) => return None,
                What::Call(name, _) if name.key == "callbyvar" => return None,
                What::Call(name, args) => {
                    names.push(&name.key);
                    let synced = synced_procedure(file, name, args);
                    names.extend(synced.map(|own| own.name.key.as_str()));
                }
                _ => {}
            }
            let texts = all_of(expressions_in(what)).into_iter().filter_map(|expr| match expr {
                Expr::Text(text) => file.procedures.get_key_value(&text.to_lowercase()),
                _ => None,
            });
            names.extend(texts.map(|(key, _)| key.as_str()));
        }
        while let Some(name) = names.pop() {
            if let Some((key, routine)) = file.procedures.get_key_value(name)
                && found.insert(key)
            {
                open.push(&routine.body);
                names.extend(of_handlers(routine));
            }
        }
        if open.is_empty() {
            return Some(found);
        }
    }
}

/// Types of one number, truth value or text.
pub(super) const PLAIN: [&str; 5] = ["num", "dnum", "bool", "byte", "string"];

/// Persistent data that no statement of the files may set, by name in lower case: other tasks, or
/// people, set them.
pub(super) fn set_by_others(file: &File) -> HashSet<&str> {
    let mut found: HashSet<&str> = file
        .data
        .iter()
        .filter(|(_, data)| data.is_persistent)
        .map(|(key, _)| key.as_str())
        .collect();
    let routines = file.procedures.values().chain(file.functions.values());
    let bodies = routines.map(|own| &own.body).chain(file.traps.iter().map(|trap| &trap.body));
    for what in statements_in(bodies) {
        match what {
            // Back to what it is declared as: whoever waits for it resets it so.
            What::Assign(path, value)
                if path.is_whole()
                    && file.data.get(&path.name.key).is_some_and(|own| {
                        own.value.as_ref().is_some_and(|own| same_literal(own, value))
                    }) => {}
            What::Assign(path, _) => {
                found.remove(path.name.key.as_str());
            }
            What::Call(name, args) => {
                let own = file.procedures.get(&name.key).map(|own| own.parameters.as_slice());
                for (i, argument) in args.positional.iter().enumerate() {
                    // Of the controller's own instructions and of other files' nobody says.
                    let may_set =
                        own.is_none_or(|own| own.get(i).is_none_or(|own| own.by_reference));
                    if let (true, Expr::Ref(path)) = (may_set, argument) {
                        found.remove(path.name.key.as_str());
                    }
                }
            }
            _ => {}
        }
    }
    found
}

/// Whether two expressions are the same literal, wherever they stand.
pub(super) fn same_literal(a: &Expr, b: &Expr) -> bool {
    match (a, b) {
        (Expr::Minus(a), Expr::Minus(b)) => same_literal(a, b),
        (Expr::List(a), Expr::List(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same_literal(a, b))
        }
        (Expr::Number(a, _), Expr::Number(b, _)) => a == b,
        (Expr::Bool(a), Expr::Bool(b)) => a == b,
        (Expr::Text(a), Expr::Text(b)) => a == b,
        _ => false,
    }
}

/// What stands for a tool and for a work object.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Named {
    pub(super) tool: bool,
    pub(super) work_object: bool,
}

/// Whether what may run, all where that is not known, moves with a tool, and in a work object, that
/// no file that is read declares.
pub(super) fn undeclared_frames(file: &File, reached: Option<&HashSet<&str>>) -> Named {
    let mut found = Named::default();
    let may_run = |key: &String| reached.is_none_or(|own| own.contains(key.as_str()));
    let procedures = file.procedures.iter().filter(|(key, _)| may_run(key));
    let routines = procedures.map(|(_, own)| own).chain(file.functions.values());
    let bodies = routines.map(|own| (own_names(own), &own.body));
    let traps = file.traps.iter().map(|trap| (HashSet::new(), &trap.body));
    for (own, body) in bodies.chain(traps) {
        let is_elsewhere = |expr: Option<&Expr>, of_language: &str| match expr {
            Some(Expr::Ref(path)) => {
                let key = path.name.key.as_str();
                key != of_language && !own.contains(key) && !file.data.contains_key(key)
            }
            _ => false,
        };
        for what in statements_in(std::iter::once(body)) {
            // By a name in a string it may be a move, whose tool is its fourth argument at least.
            if let What::CallByName(_, args, _) = what
                && args.positional.len() > 3
            {
                found.tool |= is_elsewhere(args.positional.last(), "tool0");
                // `MoveLDO` and its like have a signal and its value behind the tool.
                if let [.., tool, _, _] = args.positional.get(3..).unwrap_or_default() {
                    found.tool |= is_elsewhere(Some(tool), "tool0");
                }
                found.work_object |= is_elsewhere(args.optional_value("wobj"), "wobj0");
            }
            let What::Call(name, args) = what else { continue };
            if let Some(motion) = motion(&name.key) {
                let tool = match motion.tool {
                    ToolAt::Index(index) => args.positional.get(index),
                    ToolAt::Last => args.positional.last(),
                };
                found.tool |= is_elsewhere(tool, "tool0");
                found.work_object |= is_elsewhere(args.optional_value("wobj"), "wobj0");
            } else if let Some(routine) = file.procedures.get(&name.key) {
                for (parameter, given) in routine.parameters.iter().zip(&args.positional) {
                    match parameter.kind.as_str() {
                        "tooldata" => found.tool |= is_elsewhere(Some(given), "tool0"),
                        "wobjdata" => found.work_object |= is_elsewhere(Some(given), "wobj0"),
                        _ => {}
                    }
                }
            }
        }
    }
    found
}

/// Parameters and data of a routine.
pub(super) fn own_names(routine: &Routine) -> HashSet<&str> {
    let declared = statements_in(std::iter::once(&routine.body)).filter_map(|what| match what {
        What::Declare(declaration) => Some(&declaration.name),
        _ => None,
    });
    let given = routine.parameters.iter().map(|parameter| &parameter.name);
    declared.chain(given).map(|name| name.key.as_str()).collect()
}

/// The expressions of a statement, its blocks aside.
pub(super) fn expressions_in(what: &What) -> Vec<&Expr> {
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
        What::CallByName(name, args, _) => {
            open.push(name);
            of_args(args, &mut open);
        }
        What::Test(tested, cases, _) => {
            open.push(tested);
            open.extend(cases.iter().flat_map(|(values, _)| values));
        }
        _ => {}
    }
    open
}

/// Whether a call may set a datum of the module.
pub(super) fn is_settable(data: &Declaration) -> bool {
    !data.is_constant && may_be_set(&data.kind)
}

/// Data, and parts of them, that a call is given as they are.
pub(super) fn given(args: &Args) -> impl Iterator<Item = &Path> {
    let optional = args.optional.iter().filter_map(|(_, value)| match value {
        Optional::Value(expr) => Some(expr),
        _ => None,
    });
    args.positional.iter().chain(optional).filter_map(|expr| match expr {
        Expr::Ref(path) => Some(&**path),
        _ => None,
    })
}

/// Functions that the expressions of a statement call, with what they are given, its blocks aside.
pub(super) fn functions_in(what: &What) -> Vec<&(Name, Args)> {
    functions_of(expressions_in(what))
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
pub(super) fn all_of(mut open: Vec<&Expr>) -> Vec<&Expr> {
    let mut found = Vec::new();
    while let Some(expr) = open.pop() {
        found.push(expr);
        match expr {
            Expr::List(parts) => open.extend(parts),
            Expr::Ref(path) => of_steps(&path.steps, &mut open),
            Expr::Call(call) => of_args(&call.1, &mut open),
            Expr::Not(inner) | Expr::Minus(inner) => open.push(inner),
            Expr::Binary(_, left, right) => open.extend([&**left, &**right]),
            // Both have the same parts.
            Expr::TwoWays(ways) => open.push(&ways[0]),
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
