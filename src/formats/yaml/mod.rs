//! Reading YAML so that every fault of a file is reported with its line.
//!
//! serde stops at the first fault and serde_yaml's values do not know their lines. So the text is
//! read into a tree of our own that knows them ([`tree`]); the tree is checked against the JSON
//! Schema of the raw type ([`check`]), which finds unknown keys, missing keys, wrong types and
//! numbers out of range, all at once; and what passed is given to serde ([`typed`]). Schema and
//! serde code both derive from the one raw type, so what an editor accepts and what the program
//! accepts cannot drift apart. Long tables of waypoints are read from the tree itself, as they
//! would be slow and large as serde values, and get into it past the YAML parser ([`rows`]).

mod check;
mod node;
mod number;
mod rows;
pub(crate) mod splice;
mod tree;
mod typed;

#[cfg(test)]
pub(crate) use check::KEYWORDS;
pub(crate) use node::{Entry, Kind, Node, Step};
pub(crate) use tree::parse;
pub(crate) use typed::Apart;

use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::notes::Notes;

/// The tree of a file and the raw type that it spells, without the values that errors are about.
/// `None` where nothing can be read.
pub(crate) fn document<T: DeserializeOwned>(
    text: &str,
    schema: &Value,
    notes: &mut Notes,
) -> Option<(Node, T)> {
    let tree = parse(text, notes)?;
    spelled(tree, schema, notes)
}

/// The same of a tree, whatever it was read from.
pub(crate) fn spelled<T: DeserializeOwned>(
    mut tree: Node,
    schema: &Value,
    notes: &mut Notes,
) -> Option<(Node, T)> {
    check::check(&mut tree, schema, notes);
    let raw = typed::typed(&tree, notes)?;
    Some((tree, raw))
}
