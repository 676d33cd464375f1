//! The files and folders of a folder do not import each other in a circle.
//!
//! A folder is one with its `mod.rs`: what a file takes from a module that it lies in does not count.

use std::collections::{BTreeMap, BTreeSet};

use crate::source::{File, Library};

/// Rooms with circles that have not been removed yet.
const NOT_YET: &[&str] = &[];

/// Of each file or folder those that define what it names, and these names.
type Arrows = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

/// What stands side by side where the ways to two files part.
fn side_by_side(a: &File, b: &File) -> Option<[String; 2]> {
    let common = a.module.iter().zip(&b.module).take_while(|(a, b)| a == b).count();
    let of = |file: &File| file.module.get(..=common).map(|path| path.join("/"));
    Some([of(a)?, of(b)?])
}

fn arrows(library: &Library) -> Arrows {
    let mut arrows = Arrows::new();
    for file in library.files() {
        for (_, target) in library.named(file) {
            if let Some([from, to]) = side_by_side(file, target.file)
                && from.contains('/')
            {
                arrows.entry(from).or_default().entry(to).or_default().insert(target.name);
            }
        }
    }
    arrows
}

fn reached<'a>(arrows: &'a Arrows, from: &str) -> BTreeSet<&'a str> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(file) = open.pop() {
        for next in arrows.get(file).into_iter().flat_map(BTreeMap::keys) {
            if seen.insert(next.as_str()) {
                open.push(next);
            }
        }
    }
    seen
}

/// Sets each member of which reaches all the others.
fn circles<'a>(arrows: &'a Arrows) -> BTreeSet<Vec<&'a str>> {
    let reach: BTreeMap<&str, _> =
        arrows.keys().map(|from| (from.as_str(), reached(arrows, from))).collect();
    let back = |from: &str, to: &str| reach.get(to).is_some_and(|seen| seen.contains(from));
    let circle = |(from, seen): (&&str, &BTreeSet<&'a str>)| {
        let circle: Vec<&str> = seen.iter().copied().filter(|to| back(from, to)).collect();
        (!circle.is_empty()).then_some(circle)
    };
    reach.iter().filter_map(circle).collect()
}

#[test]
fn no_files_and_folders_import_each_other_in_a_circle() {
    let library = Library::get();
    let arrows = arrows(library);
    let count: usize = arrows.values().map(BTreeMap::len).sum();
    assert!(count > 200, "only {count} arrows: this reads the wrong thing");
    let (mut rooms, mut said) = (BTreeSet::new(), String::new());
    for circle in circles(&arrows) {
        let room = circle[0].split('/').next().unwrap();
        rooms.insert(room);
        if NOT_YET.contains(&room) {
            continue;
        }
        said += &format!("{} in a circle:\n", circle.len());
        for &from in &circle {
            for (to, names) in arrows[from].iter().filter(|(to, _)| circle.contains(&to.as_str())) {
                said += &format!("  {from} → {to}: {names:?}\n");
            }
        }
    }
    assert!(said.is_empty(), "circles:\n{said}");
    for room in NOT_YET {
        assert!(rooms.contains(room), "{room} has no circles any more: delete the exception");
    }
}

#[test]
fn circles_are_found() {
    let mut arrows = Arrows::new();
    for (from, to) in [("a", "b"), ("b", "c"), ("c", "a"), ("c", "d"), ("e", "e2"), ("e2", "e")] {
        arrows.entry(from.into()).or_default().entry(to.into()).or_default();
    }
    assert_eq!(circles(&arrows), BTreeSet::from([vec!["a", "b", "c"], vec!["e", "e2"]]));
}
