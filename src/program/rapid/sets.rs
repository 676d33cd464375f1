//! What blocks may set, themselves and by what they call in the files.

use std::collections::HashSet;

use super::filled::filled;
use super::instructions::may_set;
use super::syntax::{Args, Block, Expr, File, Name, Optional, Parameter, Path, Routine, What};
use super::walk::{functions_in, given, is_settable, names_in, statements_in, synced_procedure};

/// Instructions that change their first argument.
pub(super) const CHANGE: [&str; 6] = ["add", "bitclear", "bitset", "clear", "decr", "incr"];

/// The data that a block may set, itself or by what it calls in the files, but for those that the
/// routines there have for themselves.
pub(super) fn set_within<'a>(file: &'a File, block: &'a Block) -> Vec<&'a Name> {
    let mut seen: HashSet<&str> = HashSet::new();
    let mut open: Vec<(&'a Block, &'a [Parameter])> = vec![(block, &[])];
    let mut found = Vec::new();
    while let Some((body, parameters)) = open.pop() {
        let statements = || statements_in(std::iter::once(body));
        let own: HashSet<&str> = statements()
            .filter_map(|what| match what {
                What::Declare(declaration) => Some(&declaration.name),
                _ => None,
            })
            .chain(parameters.iter().map(|parameter| &parameter.name))
            .map(|name| name.key.as_str())
            .collect();
        for what in statements() {
            let mut set: Vec<&'a Name> = Vec::new();
            match what {
                What::Assign(path, _) => set.push(&path.name),
                What::Call(name, args) => {
                    if let Some(routine) = file.procedures.get(&name.key) {
                        set.extend(reached(routine, args));
                        if seen.insert(&name.key) {
                            open.push((&routine.body, &routine.parameters));
                        }
                    } else if CHANGE.contains(&name.key.as_str()) {
                        set.extend(names_in(args.positional.iter().take(1).collect()));
                    } else if may_set(&name.key) {
                        let all = given(args).map(|path| &path.name);
                        let may = |own: &&Name| file.data.get(&own.key).is_none_or(is_settable);
                        set.extend(all.filter(may));
                    }
                    set.extend(filled(name, args).into_iter().map(|path| &path.name));
                    let synced = synced_procedure(file, name, args);
                    let synced = synced.filter(|routine| seen.insert(&routine.name.key));
                    open.extend(synced.map(|own| (&own.body, own.parameters.as_slice())));
                }
                _ => {}
            }
            for (name, args) in functions_in(what) {
                if let Some(routine) = file.functions.get(&name.key) {
                    set.extend(reached(routine, args));
                    if seen.insert(&name.key) {
                        open.push((&routine.body, &routine.parameters));
                    }
                }
                set.extend(filled(name, args).into_iter().map(|path| &path.name));
            }
            found.extend(set.into_iter().filter(|name| !own.contains(name.key.as_str())));
        }
    }
    found
}

/// The data that a call gives to parameters by which they may be set.
fn reached<'a>(routine: &'a Routine, args: &'a Args) -> Vec<&'a Name> {
    let given = given_to(routine, args).into_iter();
    given.filter(|(own, _)| own.by_reference).map(|(_, path)| &path.name).collect()
}

/// The data, and parts of them, that a call gives to parameters as they are.
pub(super) fn given_to<'a>(routine: &'a Routine, args: &'a Args) -> Vec<(&'a Parameter, &'a Path)> {
    let of = |optional: bool| routine.parameters.iter().filter(move |p| p.optional == optional);
    let positional = of(false).zip(&args.positional);
    let named = args.optional.iter().filter_map(|(name, value)| match value {
        Optional::Value(expr) => Some((of(true).find(|own| own.name.key == *name)?, expr)),
        _ => None,
    });
    let both = positional.chain(named);
    both.filter_map(|(parameter, expr)| match expr {
        Expr::Ref(path) => Some((parameter, &**path)),
        _ => None,
    })
    .collect()
}
