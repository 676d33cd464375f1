//! Names that several modules have, each its own: what a module declares LOCAL is seen in it alone.
//!
//! Where a name is LOCAL in one module and stands in another, too, it is another name in the first,
//! as it is read.

use std::collections::{HashMap, HashSet};

use super::lexer::{Kind, Lexer};
use super::syntax::Name;

/// By module, in lower case, what names stand for in it.
pub(super) type Renamed = HashMap<String, HashMap<String, String>>;

/// Between a name and the module that has it for itself.
const OF: &str = " of ";

/// Whether a name is what one module has for itself under another.
pub(super) fn is_of_module(own: &str, name: &str) -> bool {
    own.strip_prefix(name).is_some_and(|rest| rest.starts_with(OF))
}

/// A name that a module declares, both in lower case.
struct Declared {
    name: String,
    module: String,
    is_local: bool,
    is_procedure: bool,
    is_of_main: bool,
}

/// The names of the modules of several texts, the main one first, but for those that are `kept`.
/// The job starts with `entry`: as it is, or that of the main file where none is global.
pub(super) fn renamed(texts: &[&str], kept: &HashSet<String>, entry: &str) -> Renamed {
    let all: Vec<Declared> =
        texts.iter().enumerate().flat_map(|(i, text)| declared(text, i == 0)).collect();
    let mut owners: HashMap<&str, Vec<&Declared>> = HashMap::new();
    for one in &all {
        let owners = owners.entry(&one.name).or_default();
        if owners.iter().all(|other| other.module != one.module) {
            owners.push(one);
        }
    }
    let strange = used_elsewhere(texts, &owners);
    let mut renamed = Renamed::new();
    for (name, owners) in owners {
        let is_entry = name == entry;
        let is_strange = strange.contains(name) && !is_entry;
        if owners.len() < 2 && !is_strange || kept.contains(name) && !is_entry {
            continue;
        }
        let is_global = owners.iter().any(|one| !one.is_local) || is_strange;
        for one in owners.iter().filter(|one| one.is_local && (is_global || !one.is_of_main)) {
            let own = format!("{name}{OF}{}", one.module);
            renamed.entry(one.module.clone()).or_default().insert(name.to_owned(), own);
        }
    }
    renamed
}

/// Names that are LOCAL wherever they are declared, and that stand in another module, or may in one
/// that calls procedures by names in strings.
fn used_elsewhere(texts: &[&str], owners: &HashMap<&str, Vec<&Declared>>) -> HashSet<String> {
    let mut found = HashSet::new();
    let modules: HashSet<&str> = owners.values().flatten().map(|own| own.module.as_str()).collect();
    let local = owners.iter().filter(|(_, owners)| owners.iter().all(|own| own.is_local));
    let local: HashMap<&str, &Vec<&Declared>> = local.map(|(name, own)| (*name, own)).collect();
    if modules.len() < 2 || local.is_empty() {
        return found;
    }
    let mut calling = HashSet::new();
    for text in texts {
        let (mut module, mut names_module) = (String::new(), false);
        for token in Lexer::new(text) {
            let calls = match token.kind {
                Kind::Symbol(symbol) => symbol == "%",
                Kind::Word(word) => word.eq_ignore_ascii_case("CallByVar"),
                _ => false,
            };
            // Before the first module a line of % may stand.
            if calls && !module.is_empty() && calling.insert(module.clone()) {
                let far = local.iter().filter(|(_, owners)| {
                    owners.iter().all(|own| own.is_procedure && own.module != module)
                });
                found.extend(far.map(|(name, _)| (*name).to_owned()));
            }
            let Kind::Word(word) = token.kind else { continue };
            let word = word.to_lowercase();
            if names_module {
                module.clone_from(&word);
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
fn declared(text: &str, is_of_main: bool) -> Vec<Declared> {
    let mut found = Vec::new();
    let (mut module, mut is_local, mut in_routine) = (String::new(), false, false);
    let mut words = Lexer::new(text).filter_map(|token| match token.kind {
        Kind::Word(word) => Some(word.to_lowercase()),
        Kind::Symbol(";") => Some(String::new()),
        _ => None,
    });
    while let Some(word) = words.next() {
        // The words behind, of which the last is the name.
        let behind = match word.as_str() {
            "module" => {
                module = words.next().unwrap_or_default();
                continue;
            }
            "local" => {
                is_local = true;
                continue;
            }
            "task" => continue,
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
            let module = module.clone();
            found.push(Declared { name, module, is_local, is_procedure, is_of_main });
        }
        is_local = false;
    }
    found
}

/// The procedures of several texts, in lower case, each once.
pub(super) struct Procedures {
    pub(super) names: Vec<String>,
    /// With their modules before them: `module:name`.
    pub(super) of_modules: Vec<String>,
}

pub(super) fn procedures(texts: &[&str]) -> Procedures {
    let all = texts.iter().flat_map(|text| declared(text, false)).filter(|own| own.is_procedure);
    let (names, of_modules): (Vec<String>, Vec<String>) =
        all.map(|own| (own.name.clone(), format!("{}:{}", own.module, own.name))).unzip();
    let [names, of_modules] = [names, of_modules].map(|mut found| {
        found.sort_unstable();
        found.dedup();
        found
    });
    Procedures { names, of_modules }
}

/// The procedure of a name with its module before it, as the files have it.
pub(super) fn of_module(text: &str, renamed: &Renamed) -> Name {
    let (module, name) = text.split_once(':').unwrap_or_default();
    let name = named(name.trim(), renamed.get(&module.trim().to_lowercase()));
    Name { shown: text.to_owned(), ..name }
}

/// A name as a module has it.
pub(super) fn named(word: &str, own: Option<&HashMap<String, String>>) -> Name {
    let name = Name::new(word);
    match own.and_then(|own| own.get(&name.key)) {
        Some(key) => Name { key: key.clone(), ..name },
        None => name,
    }
}
