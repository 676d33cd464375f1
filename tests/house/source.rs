//! The sources as a reader of text sees them: tokens without comments, the tree of modules, and what each
//! name refers to.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A word, a number, `::`, or any other character; the text of strings and comments is left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) text: String,
    pub(crate) line: usize,
}

impl Token {
    fn is_name(&self) -> bool {
        self.text.starts_with(|c: char| c.is_alphabetic() || c == '_')
    }
}

/// What a name that a file defines is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Function,
    Type,
    Other,
}

/// A name that a file brings in: the path as written, and the name that it has here (`*` for all).
#[derive(Debug, Clone)]
pub(crate) struct Import {
    pub(crate) path: Vec<String>,
    pub(crate) name: String,
    reexported: bool,
}

/// A source file of the library, without what only its tests use.
#[derive(Debug)]
pub(crate) struct File {
    /// Relative to `src`, with `/`.
    pub(crate) path: String,
    /// The module: `["model", "tip"]`; empty for `lib.rs`.
    pub(crate) module: Vec<String>,
    pub(crate) text: String,
    pub(crate) tokens: Vec<Token>,
    pub(crate) imports: Vec<Import>,
    /// Paths of more than one segment outside of imports.
    paths: Vec<Vec<String>>,
    items: BTreeMap<String, Kind>,
}

impl File {
    /// The folder or file right under `src` that it belongs to.
    pub(crate) fn room(&self) -> &str {
        self.path.split('/').next().unwrap().trim_end_matches(".rs")
    }

    /// Paths as they are written outside of imports.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &[String]> {
        self.paths.iter().map(Vec::as_slice)
    }
}

/// The tokens of a text of Rust.
pub(crate) fn tokens(text: &str) -> Vec<Token> {
    let c: Vec<char> = text.chars().collect();
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let starts = |i: usize, what: &str| what.chars().enumerate().all(|(k, w)| at(i + k) == w);
    let (mut i, mut line, mut found) = (0, 1, Vec::new());
    while i < c.len() {
        let start = i;
        let raw_hashes = |from: usize| (from..).take_while(|&k| at(k) == '#').count();
        if starts(i, "//") {
            while i < c.len() && c[i] != '\n' {
                i += 1;
            }
        } else if starts(i, "/*") {
            let mut depth = 0;
            loop {
                if starts(i, "/*") {
                    depth += 1;
                    i += 2;
                } else if starts(i, "*/") {
                    depth -= 1;
                    i += 2;
                } else {
                    i += 1;
                }
                if depth == 0 || i >= c.len() {
                    break;
                }
            }
        } else if at(i) == '"' || starts(i, "b\"") {
            i += if at(i) == '"' { 1 } else { 2 };
            while i < c.len() && c[i] != '"' {
                i += if c[i] == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if (starts(i, "r#") || starts(i, "r\"") || starts(i, "br#") || starts(i, "br\""))
            && at(i + 1 + usize::from(at(i) == 'b') + raw_hashes(i + 1 + usize::from(at(i) == 'b')))
                == '"'
        {
            let from = i + 1 + usize::from(at(i) == 'b');
            let hashes = raw_hashes(from);
            let end = format!("\"{}", "#".repeat(hashes));
            i = from + hashes + 1;
            while i < c.len() && !starts(i, &end) {
                i += 1;
            }
            i += end.len();
        } else if at(i) == '\'' && (at(i + 1) == '\\' || at(i + 2) == '\'') {
            i += if at(i + 1) == '\\' { 3 } else { 2 };
            while i < c.len() && c[i] != '\'' {
                i += 1;
            }
            i += 1;
        } else if c[i].is_alphanumeric() || c[i] == '_' {
            while at(i).is_alphanumeric()
                || at(i) == '_'
                || (at(i) == '.' && c[start].is_ascii_digit() && at(i + 1).is_ascii_digit())
            {
                i += 1;
            }
            found.push(Token { text: c[start..i].iter().collect(), line });
        } else if starts(i, "::") {
            i += 2;
            found.push(Token { text: "::".into(), line });
        } else {
            i += 1;
            if !c[start].is_whitespace() {
                found.push(Token { text: c[start].into(), line });
            }
        }
        line += c[start..i.min(c.len())].iter().filter(|&&c| c == '\n').count();
    }
    found
}

/// The end of the item that starts at a token: behind its `;` or its last brace.
fn item_end(tokens: &[Token], start: usize) -> usize {
    let is_import = tokens[start..].iter().take(6).any(|token| token.text == "use");
    let mut depth = 0_usize;
    for (i, token) in tokens.iter().enumerate().skip(start) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" => depth = depth.saturating_sub(1),
            "}" => {
                depth = depth.saturating_sub(1);
                if depth == 0 && !is_import {
                    return i + 1;
                }
            }
            ";" if depth == 0 => return i + 1,
            _ => {}
        }
    }
    tokens.len()
}

/// The tokens without items that are for tests alone, and the names of the modules among these.
pub(crate) fn without_tests(tokens: &[Token]) -> (Vec<Token>, Vec<String>) {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let (mut kept, mut modules, mut i) = (Vec::new(), Vec::new(), 0);
    while i < tokens.len() {
        let marked = tokens[i..].len() > MARK.len()
            && tokens[i..].iter().zip(MARK).all(|(token, mark)| token.text == mark);
        if !marked {
            kept.push(tokens[i].clone());
            i += 1;
            continue;
        }
        let end = item_end(tokens, i + MARK.len());
        let item = &tokens[i + MARK.len()..end];
        if let Some(at) = item.iter().take(5).position(|token| token.text == "mod") {
            modules.push(item[at + 1].text.clone());
        }
        i = end;
    }
    (kept, modules)
}

/// One tree of `use`, flattened; `at` stands behind `use` and is moved to the `;`.
fn import(
    tokens: &[Token],
    at: &mut usize,
    head: &[String],
    found: &mut Vec<(Vec<String>, String)>,
) {
    let mut path = head.to_vec();
    while *at < tokens.len() {
        let text = tokens[*at].text.as_str();
        match text {
            "{" => {
                *at += 1;
                while *at < tokens.len() && tokens[*at].text != "}" {
                    import(tokens, at, &path, found);
                    match tokens.get(*at).map(|token| token.text.as_str()) {
                        Some(",") => *at += 1,
                        Some("}") => {}
                        other => panic!("an import ends in {other:?}"),
                    }
                }
                *at += 1;
                return;
            }
            "*" => {
                found.push((path, "*".into()));
                *at += 1;
                return;
            }
            "::" => *at += 1,
            "as" => {
                found.push((path, tokens[*at + 1].text.clone()));
                *at += 2;
                return;
            }
            "," | ";" | "}" => {
                if path.last().is_some_and(|last| last == "self") {
                    path.pop();
                }
                if let Some(name) = path.last().cloned() {
                    found.push((path, name));
                }
                return;
            }
            _ => {
                path.push(text.to_owned());
                *at += 1;
            }
        }
    }
}

/// What a file imports, names and defines.
fn read(path: String, module: Vec<String>, text: String, tokens: Vec<Token>) -> File {
    let (mut imports, mut paths, mut items) = (Vec::new(), Vec::new(), BTreeMap::new());
    let mut depth = 0_usize;
    let mut i = 0;
    while i < tokens.len() {
        let word = tokens[i].text.as_str();
        let next = tokens.get(i + 1);
        let kind = match word {
            "fn" => Some(Kind::Function),
            "struct" | "enum" | "union" | "trait" | "type" => Some(Kind::Type),
            "const" | "static" | "mod" => Some(Kind::Other),
            _ => None,
        };
        match word {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "use" if next.is_none_or(|next| next.text != "<") => {
                let before = i.checked_sub(1).map_or("", |before| tokens[before].text.as_str());
                let reexported = matches!(before, "pub" | ")");
                let mut found = Vec::new();
                i += 1;
                import(&tokens, &mut i, &[], &mut found);
                imports.extend(found.into_iter().map(|(path, name)| Import {
                    path,
                    name,
                    reexported,
                }));
                continue;
            }
            _ => {}
        }
        if let (Some(kind), Some(name), 0) = (kind, next.filter(|next| next.is_name()), depth)
            && name.text != "fn"
        {
            items.insert(name.text.clone(), kind);
        }
        if tokens[i].is_name() && next.is_some_and(|next| next.text == "::") {
            let mut path = vec![word.to_owned()];
            while tokens.get(i + 1).is_some_and(|token| token.text == "::")
                && tokens.get(i + 2).is_some_and(Token::is_name)
            {
                path.push(tokens[i + 2].text.clone());
                i += 2;
            }
            if path.len() > 1 {
                paths.push(path);
            }
        }
        i += 1;
    }
    File { path, module, text, tokens, imports, paths, items }
}

#[derive(Debug, Clone)]
pub(crate) struct Target<'a> {
    pub(crate) file: &'a File,
    pub(crate) kind: Option<Kind>,
    pub(crate) name: String,
}

/// All files of the library, by module.
pub(crate) struct Library {
    files: BTreeMap<Vec<String>, File>,
}

impl Library {
    /// `src`, from `lib.rs` along its modules. Panics where a file belongs to no module.
    pub(crate) fn get() -> &'static Self {
        static LIBRARY: OnceLock<Library> = OnceLock::new();
        LIBRARY.get_or_init(Self::read)
    }

    fn read() -> Self {
        let mut reader = Reader { src: root().join("src"), ..Reader::default() };
        reader.walk("lib.rs".into(), vec![], false);
        let mut all = Vec::new();
        collect(&reader.src, &mut all);
        for file in all {
            let path = relative(&reader.src, &file);
            assert!(
                path == "main.rs" || reader.seen.contains(&path),
                "src/{path}: no `mod` leads to it"
            );
        }
        Self { files: reader.files }
    }

    pub(crate) fn files(&self) -> impl Iterator<Item = &File> {
        self.files.values()
    }

    /// The absolute path of what a file names, where it is of this crate.
    fn absolute(&self, file: &File, path: &[String]) -> Option<Vec<String>> {
        let first = path[0].as_str();
        let supers = path.iter().take_while(|part| *part == "super").count();
        let join = |head: &[String], tail: &[String]| [head, tail].concat();
        match first {
            "crate" => Some(path[1..].to_vec()),
            "super" => {
                let up = file.module.len().checked_sub(supers)?;
                Some(join(&file.module[..up], &path[supers..]))
            }
            "self" => Some(join(&file.module, &path[1..])),
            _ => {
                let imported = file.imports.iter().find(|import| import.name == first);
                let child = join(&file.module, &path[..1]);
                if self.files.contains_key(&child) || file.items.contains_key(first) {
                    Some(join(&file.module, path))
                } else {
                    let import = imported.filter(|import| import.path[0] != first)?;
                    Some(join(&self.absolute(file, &import.path)?, &path[1..]))
                }
            }
        }
    }

    /// The definition that an absolute path leads to, through re-exports; `None` for a module.
    fn resolve(&self, path: &[String], depth: usize) -> Option<Target<'_>> {
        let known = (0..=path.len()).rev().find(|&n| self.files.contains_key(&path[..n]))?;
        let (file, rest) = (&self.files[&path[..known]], &path[known..]);
        let name = rest.first()?;
        let target = |kind| Target { file, kind, name: name.clone() };
        if let Some(&kind) = file.items.get(name) {
            return Some(target(Some(kind)));
        }
        if depth < 9 {
            for import in &file.imports {
                let tail = match import.name.as_str() {
                    "*" => rest,
                    here if here == name => &rest[1..],
                    _ => continue,
                };
                let Some(head) = self.absolute(file, &import.path) else { continue };
                let whole = [head, tail.to_vec()].concat();
                let led = self.resolve(&whole, depth + 1);
                if let Some(led) = led.filter(|led| import.name != "*" || led.kind.is_some()) {
                    return Some(led);
                }
            }
        }
        // Made by a macro, or of another crate and re-exported.
        Some(target(None))
    }

    /// Everything of this crate that a file names, with the path as it is written.
    pub(crate) fn named(&self, file: &File) -> Vec<(String, Target<'_>)> {
        let mut found = Vec::new();
        let mut add = |path: &[String]| {
            if let Some(absolute) = self.absolute(file, path)
                && let Some(target) = self.resolve(&absolute, 0)
            {
                found.push((path.join("::"), target));
            }
        };
        for import in file.imports.iter().filter(|import| import.name != "*") {
            let used = || file.tokens.iter().filter(|token| token.text == import.name).count() > 1;
            if !import.reexported || used() {
                add(&import.path);
            }
        }
        file.paths.iter().for_each(|path| add(path));
        found
    }

    /// The rooms that a file names, each once.
    pub(crate) fn rooms(&self, file: &File) -> BTreeSet<String> {
        let imports = file.imports.iter().map(|import| &import.path);
        imports
            .chain(&file.paths)
            .filter_map(|path| self.absolute(file, path))
            .filter_map(|path| path.into_iter().next())
            .filter(|room| self.files.contains_key(std::slice::from_ref(room)))
            .filter(|room| room != file.room())
            .collect()
    }
}

#[derive(Default)]
struct Reader {
    src: PathBuf,
    files: BTreeMap<Vec<String>, File>,
    seen: BTreeSet<String>,
}

impl Reader {
    /// Reads a file and the modules that it declares; those for tests alone are only noted.
    fn walk(&mut self, path: String, module: Vec<String>, only_tests: bool) {
        let text = fs::read_to_string(self.src.join(&path)).unwrap();
        self.seen.insert(path.clone());
        let all = tokens(&text);
        let (kept, for_tests) = without_tests(&all);
        let folder = match path.rsplit_once('/') {
            _ if path == "lib.rs" => String::new(),
            Some((folder, "mod.rs")) => format!("{folder}/"),
            _ => format!("{}/", path.trim_end_matches(".rs")),
        };
        for (at, pair) in all.windows(3).enumerate() {
            let declared = pair[0].text == "mod" && pair[2].text == ";";
            if !declared {
                continue;
            }
            let name = pair[1].text.clone();
            let tests = only_tests || for_tests.contains(&name);
            let own = [format!("{folder}{name}.rs"), format!("{folder}{name}/mod.rs")];
            let own = own.into_iter().find(|file| self.src.join(file).exists());
            let own = own.unwrap_or_else(|| panic!("src/{path}: no file of mod {name} ({at})"));
            self.walk(own, [module.clone(), vec![name]].concat(), tests);
        }
        if !only_tests {
            self.files.insert(module.clone(), read(path, module, text, kept));
        }
    }
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

fn relative(root: &Path, file: &Path) -> String {
    let parts = file.strip_prefix(root).unwrap().components();
    parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}
