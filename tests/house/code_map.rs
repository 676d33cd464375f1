//! The code map in the documentation of the crate, read as a list.

use std::collections::BTreeSet;
use std::fs;

use crate::source::root;

/// An item of the code map.
pub(crate) struct Room {
    pub(crate) name: String,
    /// What it may import beside itself and the ground.
    pub(crate) imports: BTreeSet<String>,
    /// Whether everybody may import it.
    pub(crate) is_ground: bool,
    /// Rooms that must never be known here.
    pub(crate) never: BTreeSet<String>,
}

/// The text between backticks.
fn quoted(text: &str) -> BTreeSet<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The code map of `src/lib.rs`, from the top floor down.
pub(crate) fn rooms() -> Vec<Room> {
    let lib = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    let map = lib.split_once("//! # Code map").expect("a code map").1;
    let lines = map.lines().skip(1).map_while(|line| line.strip_prefix("//!"));
    let list =
        lines.skip_while(|line| !line.starts_with(" - ")).take_while(|line| !line.is_empty());
    let text = list.fold(String::new(), |text, line| text + " " + line.trim());
    text.split(" - [`").skip(1).map(room).collect()
}

/// `name`]: what lives there. May import `…`. Must never …
fn room(text: &str) -> Room {
    let (name, text) = text.split_once("`]: ").unwrap_or_else(|| panic!("no name in {text}"));
    let (text, never) = text.split_once(" Must never ").unwrap_or((text, ""));
    let (what, imports) = text.split_once(" May import ").unwrap_or((text, ""));
    let is_ground = what.ends_with(" Everybody may import it.");
    // An item in other words is no item: what it allows or forbids would be lost.
    let mut between = imports.split('`').step_by(2);
    let is_list = between.all(|gap| gap.trim_matches([',', '.', ' ']).is_empty());
    assert!(is_list && (!is_ground || imports.is_empty()), "{name} may import {imports}");
    assert!(!what.contains(" must ") && !what.contains(" import `"), "{name}: {what}");
    Room { name: name.to_owned(), imports: quoted(imports), is_ground, never: quoted(never) }
}
