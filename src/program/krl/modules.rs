//! Names that several files have, each its own: what a data list declares without GLOBAL belongs
//! to the module of that name, and so does every routine of a file behind the first that is not
//! GLOBAL.
//!
//! Where files have one name each, it is another name in each of them, as they are read.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::lexer::Kind;
use super::lines::{Line, lines};
use super::words::is_predefined_type;

/// Data that are those of the controller wherever they are given.
const OF_CONTROL: [&str; 3] = ["tool_data", "base_data", "load_data"];

/// What a file says of names, in lower case.
#[derive(Default)]
struct Declared {
    /// Of its data lists and its first routine.
    modules: HashSet<String>,
    /// Of its data lists.
    lists: HashSet<String>,
    /// With the module that they belong to; `None`: GLOBAL.
    names: Vec<(String, Option<String>)>,
}

/// By file: what names stand for in it.
pub(super) type Renamed = Vec<HashMap<String, String>>;

/// The names of files, the main one first, but for those that are `kept`.
pub(super) fn renamed(texts: &[&str], kept: &HashSet<String>) -> Renamed {
    if texts.len() < 2 {
        return Renamed::new();
    }
    let all: Vec<Declared> = texts.iter().map(|text| declared(text)).collect();
    // Who has a name: the modules, and whether it is GLOBAL somewhere.
    let mut owners: HashMap<&str, (BTreeSet<&str>, bool)> = HashMap::new();
    for (name, module) in all.iter().flat_map(|file| &file.names) {
        let (modules, is_global) = owners.entry(name).or_default();
        match module {
            Some(module) => drop(modules.insert(module)),
            None => *is_global = true,
        }
    }
    let main = all.first().map(|file| &file.modules);
    let is_main = |module: &str| main.is_some_and(|own| own.contains(module));
    let mut renamed: Renamed = vec![HashMap::new(); all.len()];
    for (name, (modules, is_global)) in owners {
        if modules.len() + usize::from(is_global) < 2 || kept.contains(name) {
            continue;
        }
        // Who has no other name: all files that have none of their own, or else the main one.
        for module in modules.into_iter().filter(|module| is_global || !is_main(module)) {
            let files = renamed.iter_mut().zip(&all);
            for (names, _) in files.filter(|(_, file)| file.modules.contains(module)) {
                names.entry(name.to_owned()).or_insert_with(|| format!("{name} of {module}"));
            }
        }
    }
    renamed
}

/// What the main file takes from the data list of another program alone, which shows it to none
/// without GLOBAL: line, name and list of each.
pub(super) fn borrowed(texts: &[&str]) -> Vec<(usize, String, String)> {
    let all: Vec<Declared> = texts.iter().map(|text| declared(text)).collect();
    let [main, others @ ..] = all.as_slice() else { return Vec::new() };
    let of_main = texts.first().map_or_else(Vec::new, |text| lines(text, false));
    let imported = of_main.iter().filter(|line| line.first() == "import").flat_map(words);
    let own = main.names.iter().map(|(name, _)| name.as_str());
    let own: HashSet<&str> = own.chain(imported).collect();
    let for_all = others.iter().flat_map(|other| &other.names);
    let for_all: HashSet<&String> =
        for_all.filter(|(_, module)| module.is_none()).map(|(name, _)| name).collect();
    let foreign = others.iter().flat_map(|other| other.names.iter().map(move |of| (other, of)));
    let foreign: HashMap<String, String> = foreign
        .filter_map(|(other, (name, module))| {
            let module = module.as_ref().filter(|module| !main.modules.contains(*module))?;
            let is_data = other.lists.contains(module) && module != "config";
            let is_of_control = OF_CONTROL.contains(&name.as_str()) || name.starts_with("def_");
            let is_seen =
                is_of_control || own.contains(name.as_str()) || for_all.contains(name) || !is_data;
            (!is_seen).then(|| (name.clone(), module.clone()))
        })
        .collect();
    let mut found: Vec<(usize, String, String)> = Vec::new();
    for line in &of_main {
        let mut tokens = line.tokens().to_vec();
        rename(&mut tokens, &foreign);
        for (before, after) in line.tokens().iter().zip(&tokens) {
            if let (Kind::Word(name), Kind::Word(list)) = (before, after)
                && name != list
                && found.iter().all(|(_, known, _)| known != name)
            {
                found.push((line.number, name.clone(), list.clone()));
            }
        }
    }
    found
}

/// The names that files declare for all programs: GLOBAL, or in a list of the controller.
pub(super) fn for_all(texts: &[&str]) -> HashSet<String> {
    let all = texts.iter().flat_map(|text| declared(text).names);
    all.filter_map(|(name, module)| module.is_none().then_some(name)).collect()
}

fn declared(text: &str) -> Declared {
    let mut found = Declared::default();
    let mut list: Option<String> = None;
    let mut first: Option<String> = None;
    for line in lines(text, false) {
        let is_global = words(&line).any(|word| word == "global");
        match line.first() {
            "defdat" => {
                list = words(&line).nth(1).map(str::to_owned);
                found.modules.extend(list.clone());
                found.lists.extend(list.clone());
            }
            "enddat" => list = None,
            "def" | "deffct" => {
                let is_function = line.first() == "deffct";
                let mut own = words(&line).skip_while(|word| !word.starts_with("def"));
                let Some(name) = own.nth(1 + usize::from(is_function)) else { continue };
                let module = first.get_or_insert_with(|| name.to_owned()).clone();
                let is_global = is_global || module == name;
                found.modules.insert(module.clone());
                found.names.push((name.to_owned(), (!is_global).then_some(module)));
            }
            _ => {
                let Some(module) = &list else { continue };
                // What the controller's own lists declare is seen everywhere.
                let is_global = is_global || module.starts_with('$');
                let own = (!is_global).then(|| module.clone());
                found.names.extend(data(&line).map(|name| (name, own.clone())));
            }
        }
    }
    found
}

fn words(line: &Line) -> impl Iterator<Item = &str> {
    line.tokens().iter().filter_map(|token| match token {
        Kind::Word(word) => Some(word.as_str()),
        _ => None,
    })
}

/// The data of `DECL GLOBAL E6POS XP1={…}`, `INT N[3],M`; SIGNAL, EXT, STRUC and the like declare
/// none.
fn data(line: &Line) -> impl Iterator<Item = String> {
    let first = words(line).next().unwrap_or("");
    let declares = matches!(first, "decl" | "global" | "const") || is_predefined_type(first);
    let other = ["signal", "ext", "extfct", "struc", "enum", "interrupt", "import"];
    let is_other = words(line).take(2).any(|word| other.contains(&word));
    let mut depth = 0;
    let mut names: Vec<String> = Vec::new();
    for token in line.tokens() {
        match token {
            Kind::Symbol("=") => break,
            Kind::Symbol("[") => depth += 1,
            Kind::Symbol("]") => depth -= 1,
            Kind::Word(word) if depth == 0 => match word.as_str() {
                "decl" | "global" | "const" | "public" => {}
                _ => names.push(word.clone()),
            },
            _ => {}
        }
    }
    // The first is the type.
    let names = names.into_iter().skip(1).filter(|name| !name.starts_with('$'));
    names.filter(move |_| declares && !is_other)
}

/// Gives the names of a file in a line their own; components of structures are none.
pub(super) fn rename(tokens: &mut [Kind], names: &HashMap<String, String>) {
    if names.is_empty() {
        return;
    }
    let (mut depth, mut is_component) = (0, false);
    for token in tokens {
        match token {
            Kind::Word(word) => {
                if let Some(own) = names.get(word.as_str()).filter(|_| !is_component) {
                    word.clone_from(own);
                }
                is_component = false;
            }
            Kind::Symbol(symbol) => {
                depth += i32::from(*symbol == "{") - i32::from(*symbol == "}");
                // Of `{E6POS: X 1}`, too.
                is_component = match *symbol {
                    "." => true,
                    "{" | "," | ":" => depth > 0,
                    _ => false,
                };
            }
            _ => is_component = false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_several_modules_are_told_apart() {
        let main = "DEF a()\nEND\nDEF feed()\nEND\nDEFDAT a\nDECL E6POS XP1={X 1}\nENDDAT\n";
        let other = "DEF b()\nEND\nDEF feed()\nEND\n";
        let list = "DEFDAT b\nINT XP1[3],N\nDECL GLOBAL REAL V=1\nENDDAT\n";
        let none = HashSet::new();
        let found = renamed(&[main, other, list], &none);
        assert!(found[0].is_empty());
        let own = |name: &str| (name.to_owned(), format!("{name} of b"));
        let both: HashMap<_, _> = [own("xp1"), own("feed")].into();
        assert_eq!((&found[1], &found[2]), (&both, &both));

        // A GLOBAL one keeps its name, and the main file's own is another.
        let hides = "DEF a()\nEND\nDEFDAT a\nREAL V=2\nENDDAT\n";
        let found = renamed(&[hides, list], &none);
        assert_eq!(found[0], [("v".to_owned(), "v of a".to_owned())].into());
        assert!(found[1].is_empty());

        // Nothing of these is a name that a module has for itself.
        let lists = ["a", "b"].map(|name| {
            format!(
                "DEFDAT {name}\nEXT BAS (BAS_COMMAND :IN,REAL :IN )\nSTRUC FOO REAL V, INT K\n\
                 SIGNAL SPD $ANOUT[1]\nSIGNAL M $OUT[1] TO $OUT[8]\nDECL REAL JOB=1\nENDDAT\n"
            )
        });
        let config = "DEFDAT $CONFIG PUBLIC\nDECL E6POS XP1={X 1}\nENDDAT\n";
        let job = HashSet::from(["job".to_owned()]);
        let found = renamed(&["DEF p()\nEND\n", &lists[0], &lists[1], config], &job);
        assert!(found.iter().all(HashMap::is_empty), "{found:?}");

        let mut line = lines("P.XP1={XP1 XP1,V XP1[XP1]}", false).remove(0).tokens.unwrap();
        rename(&mut line, &[own("xp1")].into());
        let own = |at: usize| matches!(&line[at], Kind::Word(word) if word.ends_with(" of b"));
        let renamed: Vec<usize> = (0..line.len()).filter(|&at| own(at)).collect();
        // P . XP1 = { XP1 XP1 , V XP1 [ XP1 ] }
        assert_eq!(renamed, [6, 9, 11]);
    }
}
