//! Names that several modules have, each its own: what a module declares LOCAL is seen in it alone,
//! and what a part has that the program loads and unloads is there no longer when the next comes.
//!
//! Where a name is LOCAL in one module and stands in another, too, it is another name in the first,
//! as it is read. So it is in parts that are loaded one after the other.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::lexer::{Kind, Lexer};
use super::syntax::Name;

/// The file of a module, the main one first, and its name in lower case.
pub(super) type Module = (usize, String);

/// By module, what names stand for in it.
pub(super) type Renamed = HashMap<Module, HashMap<String, String>>;

/// What names of several texts stand for.
#[derive(Debug, Default)]
pub(super) struct Names {
    pub(super) renamed: Renamed,
    /// The procedures by how a string may name them, in lower case: `name`, `module:name`; with
    /// what that is where it is not the module at hand that says so. Of several, each of a part of
    /// its own, the loaded one counts.
    pub(super) procedures: BTreeMap<String, Vec<String>>,
    /// Whether the program loads parts.
    pub(super) loads: bool,
}

/// Between a name and the module that has it for itself.
const OF: &str = " of ";

/// Whether a name is what one module has for itself under another.
pub(super) fn is_of_module(own: &str, name: &str) -> bool {
    own.strip_prefix(name).is_some_and(|rest| rest.starts_with(OF))
}

/// A name that a module declares, both in lower case.
struct Declared {
    name: String,
    module: Module,
    is_local: bool,
    is_procedure: bool,
    /// Whether other tasks have it, too.
    is_of_tasks: bool,
}

/// The names of the modules of several texts, the main one first, but for those that are `kept`.
/// The job starts with `entry`: as it is, or that of the main file where none is global.
pub(super) fn names(texts: &[&str], kept: &HashSet<String>, entry: &str) -> Names {
    let all: Vec<Declared> =
        texts.iter().enumerate().flat_map(|(file, text)| declared(text, file)).collect();
    let mut owners: HashMap<&str, Vec<&Declared>> = HashMap::new();
    for one in &all {
        let owners = owners.entry(&one.name).or_default();
        if owners.iter().all(|other| other.module != one.module) {
            owners.push(one);
        }
    }
    let several = owners.iter().filter(|(name, owners)| is_of_parts(owners, **name == entry));
    let mut of_parts: HashSet<&str> = several.map(|(name, _)| *name).collect();
    let loads = !of_parts.is_empty() && texts.iter().any(|text| loads(text));
    of_parts.retain(|_| loads);
    let strange = used_elsewhere(texts, &owners, &of_parts);
    let (mut renamed, mut procedures) = (Renamed::new(), BTreeMap::<String, Vec<String>>::new());
    for (name, owners) in owners {
        let is_entry = name == entry;
        let is_strange = strange.contains(name) && !is_entry;
        if owners.len() < 2 && !is_strange || kept.contains(name) && !is_entry {
            continue;
        }
        let is_global = owners.iter().any(|one| !one.is_local) || is_strange;
        let is_of_parts = of_parts.contains(name) && !strange.contains(name);
        for one in owners {
            let (file, module) = &one.module;
            let is_other = match one.is_local {
                true => is_global || *file > 0,
                false => is_of_parts && *file > 0,
            };
            if !is_other {
                continue;
            }
            let own = match file {
                0 => format!("{name}{OF}{module}"),
                _ => format!("{name}{OF}{module} {file}"),
            };
            if one.is_procedure && !one.is_local && !is_entry {
                procedures.entry(name.to_owned()).or_default().push(own.clone());
            }
            renamed.entry(one.module.clone()).or_default().insert(name.to_owned(), own);
        }
    }
    for one in all.iter().filter(|one| one.is_procedure) {
        procedures.entry(one.name.clone()).or_default();
        let own = named(&one.name, renamed.get(&one.module)).key;
        let of_module = procedures.entry(format!("{}:{}", one.module.1, one.name)).or_default();
        if !of_module.contains(&own) {
            of_module.push(own);
        }
    }
    Names { renamed, procedures, loads }
}

/// Whether a name is global in several files, each of which may be a part that is loaded when the
/// others are not. The procedure that the job starts with is that of the main file; data that tasks
/// share are one datum.
fn is_of_parts(owners: &[&Declared], is_entry: bool) -> bool {
    let global = || owners.iter().filter(|one| !one.is_local);
    let files: HashSet<usize> = global().map(|one| one.module.0).collect();
    global().count() > 1
        && files.len() == global().count()
        && files.contains(&0) == is_entry
        && (global().all(|one| one.is_procedure) || !global().any(|one| one.is_procedure))
        && !global().all(|one| one.is_of_tasks)
}

fn loads(text: &str) -> bool {
    Lexer::new(text).any(|token| match token.kind {
        Kind::Word(word) => ["load", "startload"].iter().any(|own| word.eq_ignore_ascii_case(own)),
        _ => false,
    })
}

/// Names that are LOCAL wherever they are declared, and that stand in another module, or may in one
/// that calls procedures by names in strings; and what other modules name of what is no procedure
/// of parts.
fn used_elsewhere(
    texts: &[&str],
    owners: &HashMap<&str, Vec<&Declared>>,
    of_parts: &HashSet<&str>,
) -> HashSet<String> {
    let mut found = HashSet::new();
    let modules: HashSet<&Module> = owners.values().flatten().map(|own| &own.module).collect();
    let local = owners.iter().filter(|(name, owners)| {
        owners.iter().all(|own| own.is_local)
            || of_parts.contains(*name) && !owners.iter().all(|own| own.is_procedure)
    });
    let local: HashMap<&str, &Vec<&Declared>> = local.map(|(name, own)| (*name, own)).collect();
    if modules.len() < 2 || local.is_empty() {
        return found;
    }
    let mut calling = HashSet::new();
    for (file, text) in texts.iter().enumerate() {
        let (mut module, mut names_module) = ((file, String::new()), false);
        for token in Lexer::new(text) {
            let calls = match token.kind {
                Kind::Symbol(symbol) => symbol == "%",
                Kind::Word(word) => word.eq_ignore_ascii_case("CallByVar"),
                _ => false,
            };
            // Before the first module a line of % may stand.
            if calls && !module.1.is_empty() && calling.insert(module.clone()) {
                let far = local.iter().filter(|(_, owners)| {
                    owners.iter().all(|own| own.is_procedure && own.module != module)
                });
                found.extend(far.map(|(name, _)| (*name).to_owned()));
            }
            let Kind::Word(word) = token.kind else { continue };
            let word = word.to_lowercase();
            if names_module {
                module.1.clone_from(&word);
            }
            names_module = word == "module";
            let owners = local.get(word.as_str());
            if owners.is_some_and(|owners| owners.iter().all(|own| own.module != module)) {
                found.insert(word);
            }
        }
    }
    found
}

/// Data and routines of the modules of a text; what stands in routines is theirs alone.
fn declared(text: &str, file: usize) -> Vec<Declared> {
    let mut found = Vec::new();
    let (mut module, mut in_routine) = ((file, String::new()), false);
    let [mut is_local, mut is_of_task] = [false; 2];
    let mut words = Lexer::new(text).filter_map(|token| match token.kind {
        Kind::Word(word) => Some(word.to_lowercase()),
        Kind::Symbol(";") => Some(String::new()),
        _ => None,
    });
    while let Some(word) = words.next() {
        // The words behind, of which the last is the name.
        let behind = match word.as_str() {
            "module" => {
                module.1 = words.next().unwrap_or_default();
                continue;
            }
            "local" => {
                is_local = true;
                continue;
            }
            "task" => {
                is_of_task = true;
                continue;
            }
            "endproc" | "endfunc" | "endtrap" => {
                in_routine = false;
                0
            }
            "const" | "var" | "pers" if !in_routine => 2,
            "func" if !in_routine => 2,
            "proc" | "trap" | "record" if !in_routine => 1,
            _ => 0,
        };
        in_routine |= behind > 0 && matches!(word.as_str(), "func" | "proc" | "trap");
        if let Some(name) = (0..behind).map_while(|_| words.next()).last() {
            let is_procedure = word == "proc";
            let is_of_tasks = word == "pers" && !is_of_task;
            let module = module.clone();
            found.push(Declared { name, module, is_local, is_procedure, is_of_tasks });
        }
        [is_local, is_of_task] = [false; 2];
    }
    found
}

/// A name as a module has it.
pub(super) fn named(word: &str, own: Option<&HashMap<String, String>>) -> Name {
    let name = Name::new(word);
    match own.and_then(|own| own.get(&name.key)) {
        Some(key) => Name { key: key.clone(), ..name },
        None => name,
    }
}

/// Instructions that load files, or take them away.
pub(super) const LOADS: [&str; 4] = ["load", "startload", "waitload", "unload"];

/// Names of files without folders, in lower case.
#[derive(Debug, Default)]
pub(super) struct Loaded {
    pub(super) now: Vec<String>,
    /// Those that `StartLoad` has begun to load.
    pub(super) begun: Vec<String>,
    pub(super) is_unknown: bool,
}

impl Loaded {
    /// Where the run decides what is loaded.
    pub(super) fn unknown() -> Self {
        Self { is_unknown: true, ..Self::default() }
    }
}
