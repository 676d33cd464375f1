//! A RAPID program that is named by its list (.pgf) or its folder → the files that it consists of.

use std::path::{Path, PathBuf};

use super::files::MAX_FILE_BYTES;
use crate::formats::text::{lower_first, read_bytes};
use crate::paths::folder_of;
use crate::program::Dialect;

/// Where the program starts, and its other modules.
pub(super) type Members = (PathBuf, Vec<PathBuf>);

/// The files of a program, if `path` is a list or a folder; a lower-case fragment where they are
/// not to be had.
pub(super) fn members(path: &Path, procedure: &str) -> Option<Result<Members, String>> {
    let is_list = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("pgf"));
    if path.is_dir() {
        Some(in_folder(path).and_then(|files| starting(files, procedure)))
    } else if is_list && path.is_file() {
        Some(in_list(path).and_then(|files| starting(files, procedure)))
    } else {
        None
    }
}

fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let unreadable = |error: std::io::Error| lower_first(&error.to_string());
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_string();
        if Dialect::from_extension(&extension) == Some(Dialect::Rapid) && path.is_file() {
            found.push(path);
        }
    }
    found.sort();
    if found.is_empty() {
        return Err("is a folder without modules of RAPID; name the file where the program starts"
            .to_owned());
    }
    Ok(found)
}

fn in_list(list: &Path) -> Result<Vec<PathBuf>, String> {
    let bytes = read_bytes(list, MAX_FILE_BYTES).map_err(|note| note.what)?;
    let text = String::from_utf8_lossy(&bytes);
    let word = text.trim_start_matches('\u{feff}').split_whitespace().next().unwrap_or_default();
    if word.eq_ignore_ascii_case("MODULE") || word.starts_with("%%%") {
        return Err("is no list but a module of RAPID; give it the extension .mod".to_owned());
    }
    let tree = roxmltree::Document::parse(&text).map_err(|error| format!("is no list: {error}"))?;
    let modules = tree.descendants().filter(|node| node.has_tag_name("Module"));
    let names = modules.filter_map(|node| node.text()).map(|name| name.trim().replace('\\', "/"));
    let found: Vec<PathBuf> = names.map(|name| folder_of(list).join(name)).collect();
    match found.iter().find(|path| !path.is_file()) {
        Some(missing) => Err(format!("lists '{}': no such file", missing.display())),
        None if found.is_empty() => Err("lists no modules".to_owned()),
        None => Ok(found),
    }
}

/// The module with the procedure, and the others.
fn starting(mut files: Vec<PathBuf>, procedure: &str) -> Result<Members, String> {
    let wanted = procedure.to_lowercase();
    let mut starts = Vec::new();
    for (index, file) in files.iter().enumerate() {
        let bytes = read_bytes(file, MAX_FILE_BYTES).map_err(|note| note.what)?;
        let text = String::from_utf8_lossy(&bytes).to_lowercase();
        let declares = |line: &str| {
            let line = line.trim_start().trim_start_matches("local").trim_start();
            let rest = line.strip_prefix("proc").unwrap_or("");
            let name = rest.trim_start().split(|c: char| !(c.is_alphanumeric() || c == '_')).next();
            rest.starts_with([' ', '\t']) && name == Some(&wanted)
        };
        if text.lines().any(declares) {
            starts.push(index);
        }
    }
    match starts.as_slice() {
        [start] => Ok((files.remove(*start), files)),
        [] => Err(format!("none of its modules has PROC {procedure}")),
        _ => Err(format!("{} of its modules have PROC {procedure}", starts.len())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_and_a_folder_lead_to_the_module_with_the_procedure() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.mod"), "MODULE a\nENDMODULE\n! PROC main()\n").unwrap();
        std::fs::write(at("b.MOD"), "MODULE b\n  LOCAL PROC Main()\nENDPROC\nENDMODULE\n").unwrap();
        std::fs::write(at("c.nc"), "PROC main()\n").unwrap();
        let list = "<?xml version=\"1.0\" encoding=\"ISO-8859-1\" ?>\n<Program>\n\t<Module>a.mod\
                    </Module>\n\t<Module>b.MOD</Module>\n</Program>\n";
        std::fs::write(at("p.pgf"), list).unwrap();
        let expected = (at("b.MOD"), vec![at("a.mod")]);
        assert_eq!(members(folder.path(), "main"), Some(Ok(expected.clone())));
        assert_eq!(members(&at("p.pgf"), "MAIN"), Some(Ok(expected)));
        assert_eq!(members(&at("a.mod"), "main"), None);
        let said = |found: Option<Result<Members, String>>| found.unwrap().unwrap_err();
        assert!(said(members(folder.path(), "cut")).contains("has PROC cut"));
        std::fs::write(at("p.pgf"), list.replace("a.mod", "gone.mod")).unwrap();
        assert!(said(members(&at("p.pgf"), "main")).contains("gone.mod': no such file"));
        std::fs::write(at("p.pgf"), "%%%\nVERSION:1\n%%%\nMODULE a\nENDMODULE\n").unwrap();
        assert!(said(members(&at("p.pgf"), "main")).contains("a module of RAPID"));
        std::fs::write(at("p.pgf"), "\r\nModule a\nENDMODULE\n").unwrap();
        assert!(said(members(&at("p.pgf"), "main")).contains("extension .mod"));
    }
}
