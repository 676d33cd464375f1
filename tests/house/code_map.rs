//! The code map in the documentation of the crate, read as a table.

use std::collections::BTreeSet;
use std::fs;

use crate::source::root;

/// A row of the code map.
pub(crate) struct Room {
    pub(crate) name: String,
    /// What it may import beside itself and the ground.
    pub(crate) imports: BTreeSet<String>,
    /// Whether everybody may import it.
    pub(crate) is_ground: bool,
    /// Rooms that the column "must never" names.
    pub(crate) never: BTreeSet<String>,
}

/// The text between backticks.
fn quoted(cell: &str) -> impl Iterator<Item = String> {
    cell.split('`').skip(1).step_by(2).map(str::to_owned)
}

/// The code map of `src/lib.rs`, from the top floor down.
pub(crate) fn rooms() -> Vec<Room> {
    let lib = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let map = lib.split_once("//! # Code map").expect("a code map").1;
    let rows = map.lines().filter_map(|line| line.strip_prefix("//! |"));
    let mut rows = rows.map(|row| row.split('|').map(str::trim).collect::<Vec<_>>());
    let head = rows.next().expect("a table");
    assert_eq!(head[..4], ["module", "what lives there", "may import", "must never"]);
    let read = |row: Vec<&str>| {
        let name = quoted(row[0]).next().unwrap_or_else(|| panic!("{row:?} names no module"));
        let is_ground = row[2] == "*ground*";
        let imports = if is_ground { BTreeSet::new() } else { quoted(row[2]).collect() };
        Room { name, imports, is_ground, never: quoted(row[3]).collect() }
    };
    rows.skip(1).map(read).collect()
}
