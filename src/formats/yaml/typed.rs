//! A checked tree → a raw type, through serde_yaml.

use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Deserializer};
use serde_yaml::{Mapping, Number, Value};

use super::node::{Kind, Node, Step};
use crate::notes::{Code, Notes};

/// Stands in a raw type for a value that is read from the tree itself: it says only that it is
/// there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Apart;

impl<'de> Deserialize<'de> for Apart {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        IgnoredAny::deserialize(deserializer).map(|_| Self)
    }
}

/// The raw type that the tree spells, without the values that errors are about.
pub(crate) fn typed<T: DeserializeOwned>(root: &Node, notes: &mut Notes) -> Option<T> {
    let read = serde_path_to_error::deserialize(value_of(root)?);
    // The schema was checked before, so this finds only what a schema cannot say.
    read.map_err(|error| {
        let path = error.path().clone();
        let steps: Vec<Step<'_>> = path
            .iter()
            .filter_map(|segment| match segment {
                serde_path_to_error::Segment::Seq { index } => Some(Step::Index(*index)),
                serde_path_to_error::Segment::Map { key } => Some(Step::Key(key)),
                serde_path_to_error::Segment::Enum { .. }
                | serde_path_to_error::Segment::Unknown => None,
            })
            .collect();
        notes.error(Code::Value, root.line_at(&steps), format!("{path}: {}", error.into_inner()));
    })
    .ok()
}

fn value_of(node: &Node) -> Option<Value> {
    if node.faulty {
        return None;
    }
    if node.apart {
        return Some(Value::Bool(true));
    }
    Some(match &node.kind {
        Kind::Numbers(numbers) => Value::Sequence(
            numbers.iter().map(|&number| Value::Number(number_from(number))).collect(),
        ),
        Kind::Sequence(items) => Value::Sequence(items.iter().filter_map(value_of).collect()),
        Kind::Mapping(entries) => Value::Mapping(
            entries
                .iter()
                .filter_map(|entry| {
                    Some((Value::String(entry.key.to_string()), value_of(&entry.value)?))
                })
                .collect::<Mapping>(),
        ),
        Kind::Scalar { .. } => match (node.number(), node.boolean(), node.text()) {
            (Some(number), ..) => Value::Number(number_from(number)),
            (_, Some(truth), _) => Value::Bool(truth),
            (.., Some(text)) => Value::String(text.to_owned()),
            _ => Value::Null,
        },
    })
}

/// Whole numbers as integers, as serde gives a float to no integer field.
fn number_from(number: f64) -> Number {
    const MAX_EXACT: f64 = 9_007_199_254_740_992.0;
    if number.fract() == 0.0 && number.abs() <= MAX_EXACT {
        Number::from(number as i64)
    } else {
        Number::from(number)
    }
}
