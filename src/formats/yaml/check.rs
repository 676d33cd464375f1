//! A tree against a JSON Schema: the part of JSON Schema that the raw types make, with messages for
//! people. Values with faults are marked, so that reading goes on without them.

use std::collections::HashSet;
use std::sync::Arc;

use serde_json::{Map, Value};

use super::node::{Entry, Kind, Node};
use super::number::{is_not_finite, number_of};
use crate::notes::{Code, Notes};
use crate::units::unit_of;
use crate::wording::{MAX_WORD_BYTES, hint, nearest};

/// Every keyword that is understood or that only describes. A test holds the schemas to it.
#[cfg(test)]
pub(crate) const KEYWORDS: &[&str] = &[
    "$schema",
    "title",
    "description",
    "examples",
    "default",
    "format",
    "type",
    "enum",
    "anyOf",
    "minimum",
    "maximum",
    "exclusiveMinimum",
    "properties",
    "required",
    "additionalProperties",
    "items",
    "minItems",
    "maxItems",
    NOUN,
    APART,
    NARROWS,
];

/// Schema keyword: what to call such a mapping in a message, before its name.
pub(crate) const NOUN: &str = "x-noun";

/// Schema keyword: the value is read from the tree, not through serde.
pub(crate) const APART: &str = "x-apart";

/// Schema keyword: absent, the key would say more than with a value, so it must not be empty.
pub(crate) const NARROWS: &str = "x-narrows";

/// Checks `root` against `schema`: one fault for each key and value that does not fit.
pub(crate) fn check(root: &mut Node, schema: &Value, notes: &mut Notes) {
    let trail = Trail { parent: None, step: TrailStep::Root };
    let line = root.line;
    check_value(root, line, schema, &trail, notes);
}

/// Where a value lies, from the root on.
struct Trail<'t> {
    parent: Option<&'t Trail<'t>>,
    step: TrailStep<'t>,
}

enum TrailStep<'t> {
    Root,
    Key(&'t str),
    Index(usize),
    /// "joint 'joint_1'": stands for all steps so far.
    Called(String),
}

impl<'t> Trail<'t> {
    fn then(&'t self, step: TrailStep<'t>) -> Trail<'t> {
        Trail { parent: Some(self), step }
    }

    /// The key that the value stands at, itself or in a list.
    fn key(&self) -> &str {
        match (&self.step, self.parent) {
            (TrailStep::Key(key), _) => key,
            (TrailStep::Index(_), Some(parent)) => parent.key(),
            _ => "",
        }
    }

    /// What the value belongs to, and its key path from there.
    fn owner_and_path(&self) -> (Option<&str>, String) {
        let (called, mut path) = match (&self.step, self.parent) {
            (TrailStep::Called(name), _) => (Some(name.as_str()), String::new()),
            (_, Some(parent)) => parent.owner_and_path(),
            (_, None) => (None, String::new()),
        };
        match &self.step {
            TrailStep::Key(key) => {
                if !path.is_empty() {
                    path.push('.');
                }
                path.push_str(key);
            }
            TrailStep::Index(index) => path.push_str(&format!("[{index}]")),
            TrailStep::Root | TrailStep::Called(_) => {}
        }
        (called, path)
    }

    /// A message about the value itself: "joint 'a': stiffness is 0, must be positive".
    fn about(&self, what: &str) -> String {
        match self.owner_and_path() {
            (Some(called), path) if path.is_empty() => format!("{called} {what}"),
            (Some(called), path) => format!("{called}: {path} {what}"),
            (None, path) if path.is_empty() => format!("the file {what}"),
            (None, path) => format!("{path} {what}"),
        }
    }

    /// A message about what is inside: "operation 'a': cutting: unknown key 'b'".
    fn within(&self, what: &str) -> String {
        match self.owner_and_path() {
            (Some(called), path) if path.is_empty() => format!("{called}: {what}"),
            (Some(called), path) => format!("{called}: {path}: {what}"),
            (None, path) if path.is_empty() => what.to_owned(),
            (None, path) => format!("{path}: {what}"),
        }
    }
}

fn check_value(node: &mut Node, line: u32, schema: &Value, trail: &Trail<'_>, notes: &mut Notes) {
    let Some(schema) = schema.as_object() else { return };
    if node.faulty {
        return;
    }
    let mut or_word = String::new();
    let schema = match schema.get("anyOf").and_then(Value::as_array) {
        // An optional mapping or list: itself, or null.
        Some(_) if node.is_null() => return,
        Some(choices) => {
            // A word instead of what stands there as a rule: `none`.
            for word in choices.iter().filter_map(only_word) {
                if node.text() == Some(word) {
                    return;
                }
                or_word = format!(", or {word}");
            }
            // `true` or a number: any of the types will do.
            let simple = choices
                .iter()
                .filter_map(Value::as_object)
                .filter(|choice| matches!(type_of(choice), Some("boolean" | "number" | "integer")));
            let simple: Vec<_> = simple.collect();
            if simple.len() > 1 {
                if simple.iter().any(|choice| fits_simple(node, choice)) {
                    return;
                }
                let others = simple.iter().skip(1);
                or_word = others.map(|choice| format!(", or {}", expectation(choice))).collect();
            }
            match choices
                .iter()
                .find(|c| !admits_null(c) && only_word(c).is_none())
                .and_then(Value::as_object)
            {
                Some(choice) => choice,
                None => return,
            }
        }
        None => schema,
    };
    node.apart = schema.contains_key(APART);
    let fits = match type_of(schema) {
        _ if node.is_null() && schema.get("type").is_some_and(type_admits_null) => true,
        Some("object") => match &mut node.kind {
            Kind::Mapping(entries) => {
                check_mapping(entries, line, schema, trail, notes);
                return;
            }
            _ => false,
        },
        Some("array") => match &mut node.kind {
            Kind::Numbers(_) | Kind::Sequence(_) => {
                node.faulty = !check_list(node, line, schema, trail, notes);
                return;
            }
            Kind::Scalar { .. } | Kind::Mapping(_) => false,
        },
        Some("number" | "integer" | "boolean") => fits_simple(node, schema),
        Some("string") => node.text().is_some_and(|text| {
            schema
                .get("enum")
                .and_then(Value::as_array)
                .is_none_or(|choices| choices.iter().any(|choice| choice == text))
        }),
        _ => true,
    };
    if !fits {
        let mut what = format!("is {}, must be {}{or_word}", node.shown(), expectation(schema));
        let choices = schema.get("enum").and_then(Value::as_array);
        if let (Some(text), Some(choices)) = (node.text(), choices) {
            what.push_str(&hint(text, choices.iter().filter_map(Value::as_str)));
        } else if let (None, Some("string"), false) = (node.text(), type_of(schema), node.is_null())
        {
            what.push_str("; put it in quotes");
        }
        let is_number = matches!(type_of(schema), Some("number" | "integer"));
        if let (true, Kind::Scalar { text, quoted: true }) = (is_number, &node.kind)
            && number_of(text).is_some()
        {
            what.push_str("; in quotes it is text: write it without them");
        }
        if let (true, Kind::Scalar { text, .. }) = (is_number, &node.kind)
            && number_of(text).is_none()
            && !is_not_finite(text)
            && text.trim_start_matches(['+', '-', '.']).starts_with(|c: char| c.is_ascii_digit())
        {
            what.push_str("; write a plain number");
            let (_, unit) = unit_of(trail.key());
            if !unit.is_empty() {
                what.push_str(&format!(" in {unit}"));
            }
        }
        notes.error(Code::Value, line as usize, trail.about(&what));
        node.faulty = true;
    }
}

fn check_mapping(
    entries: &mut Vec<Entry>,
    line: u32,
    schema: &Map<String, Value>,
    trail: &Trail<'_>,
    notes: &mut Notes,
) {
    let none = Map::new();
    let properties = schema.get("properties").and_then(Value::as_object).unwrap_or(&none);
    let additional = schema.get("additionalProperties");
    let given: HashSet<Arc<str>> = entries.iter().map(|entry| Arc::clone(&entry.key)).collect();
    for entry in entries.iter_mut() {
        let key = &*entry.key;
        if let Some(schema) = properties.get(key) {
            check_value(
                &mut entry.value,
                entry.line,
                schema,
                &trail.then(TrailStep::Key(key)),
                notes,
            );
        } else if let Some(schema) = additional.filter(|schema| schema.is_object()) {
            let step = match noun_of(schema) {
                Some(noun) => TrailStep::Called(format!("{noun} '{key}'")),
                None => TrailStep::Key(key),
            };
            check_value(&mut entry.value, entry.line, schema, &trail.then(step), notes);
        } else if additional == Some(&Value::Bool(false)) {
            let known = || properties.keys().map(String::as_str);
            let near = nearest(key, known());
            let advice = match near {
                Some(near) => format!("did you mean '{near}'?"),
                None => format!("known keys are {}", known().collect::<Vec<_>>().join(", ")),
            };
            let key: String =
                key.chars().take(MAX_WORD_BYTES).flat_map(char::escape_debug).collect();
            notes.error(
                Code::UnknownKey,
                entry.line as usize,
                trail.within(&format!("unknown key '{key}'; {advice}")),
            );
            entry.value.faulty = true;
            // The key that was meant is not missing as well.
            if let Some(near) = near.filter(|near| !given.contains(*near)) {
                entry.key = near.into();
            }
        }
    }
    for entry in entries.iter().filter(|entry| entry.value.is_null()) {
        if properties.get(&*entry.key).is_some_and(|schema| schema.get(NARROWS).is_some()) {
            let what = format!("{} is empty: give a value, or delete the key", entry.key);
            notes.error(Code::Value, entry.line as usize, trail.within(&what));
        }
    }
    // A key without a value is one that is not there, for every reader.
    entries.retain(|entry| {
        entry.value.faulty || !entry.value.is_null() || !properties.contains_key(&*entry.key)
    });
    for required in schema.get("required").and_then(Value::as_array).into_iter().flatten() {
        let Some(required) = required.as_str() else { continue };
        if !entries.iter().any(|entry| &*entry.key == required) {
            let what = trail.within(&format!("missing key '{required}'"));
            notes.error(Code::MissingKey, line as usize, what);
        }
    }
}

/// Whether the list as such can be used: it has the right length and, unless its items are read one
/// by one, none that is faulty.
fn check_list(
    node: &mut Node,
    line: u32,
    schema: &Map<String, Value>,
    trail: &Trail<'_>,
    notes: &mut Notes,
) -> bool {
    let bound = |key: &str| schema.get(key).and_then(Value::as_u64);
    let (least, most) = (bound("minItems"), bound("maxItems"));
    let length = match &node.kind {
        Kind::Numbers(numbers) => numbers.len(),
        _ => node.items().len(),
    } as u64;
    if least.is_some_and(|least| length < least) || most.is_some_and(|most| length > most) {
        let what = if length == 0 {
            format!("is an empty list, must be {}", expectation(schema))
        } else {
            format!("has {length} {}, must be {}", plural(length, "value"), expectation(schema))
        };
        notes.error(Code::Value, line as usize, trail.about(&what));
        return false;
    }
    let Some(items_schema) = schema.get("items") else { return true };
    let line = node.line;
    let mut fits = true;
    match &mut node.kind {
        Kind::Numbers(numbers) => {
            let Some(item_schema) = items_schema.as_object() else { return true };
            let numeric = matches!(type_of(item_schema), Some("number" | "integer"));
            let range = Range::of(item_schema);
            for (index, &number) in numbers.iter().enumerate() {
                if !(numeric && range.holds(number)) {
                    let trail = trail.then(TrailStep::Index(index));
                    let what = format!("is {number}, must be {}", expectation(item_schema));
                    notes.error(Code::Value, line as usize, trail.about(&what));
                    fits = false;
                    if !numeric {
                        break;
                    }
                }
            }
        }
        Kind::Sequence(items) => {
            let noun = noun_of(items_schema);
            for (index, item) in items.iter_mut().enumerate() {
                let step = match noun {
                    Some(noun) => TrailStep::Called(called(noun, item, index)),
                    None => TrailStep::Index(index),
                };
                let line = item.line;
                check_value(item, line, items_schema, &trail.then(step), notes);
                fits &= !item.faulty;
            }
        }
        Kind::Scalar { .. } | Kind::Mapping(_) => {}
    }
    fits || node.apart
}

/// "operation 'rough'", or "operation 2" where it has no name.
fn called(noun: &str, item: &Node, index: usize) -> String {
    match item.get("name").and_then(Node::text) {
        Some(name) => format!("{noun} '{name}'"),
        None => format!("{noun} {}", index + 1),
    }
}

fn noun_of(schema: &Value) -> Option<&str> {
    schema.get(NOUN).and_then(Value::as_str)
}

/// The one word that a schema admits.
fn only_word(schema: &Value) -> Option<&str> {
    match schema.get("enum")?.as_array()?.as_slice() {
        [word] => word.as_str(),
        _ => None,
    }
}

/// Whether a number or a truth is what a schema says of it.
fn fits_simple(node: &Node, schema: &Map<String, Value>) -> bool {
    match type_of(schema) {
        Some("boolean") => node.boolean().is_some(),
        _ => node.number().is_some_and(|number| Range::of(schema).holds(number)),
    }
}

/// The type beside null.
fn type_of(schema: &Map<String, Value>) -> Option<&str> {
    match schema.get("type")? {
        Value::String(name) => Some(name),
        Value::Array(names) => names.iter().filter_map(Value::as_str).find(|name| *name != "null"),
        _ => None,
    }
}

fn type_admits_null(types: &Value) -> bool {
    types == "null" || types.as_array().is_some_and(|names| names.iter().any(|name| name == "null"))
}

fn admits_null(schema: &Value) -> bool {
    schema.get("type").is_some_and(type_admits_null)
}

/// What a schema says of a number.
struct Range {
    is_whole: bool,
    least: Option<f64>,
    above: Option<f64>,
    most: Option<f64>,
}

impl Range {
    fn of(schema: &Map<String, Value>) -> Self {
        let bound = |key: &str| schema.get(key).and_then(Value::as_f64);
        Self {
            is_whole: type_of(schema) == Some("integer"),
            least: bound("minimum"),
            above: bound("exclusiveMinimum"),
            most: bound("maximum"),
        }
    }

    fn holds(&self, number: f64) -> bool {
        (!self.is_whole || number.fract() == 0.0)
            && self.least.is_none_or(|least| number >= least)
            && self.above.is_none_or(|above| number > above)
            && self.most.is_none_or(|most| number <= most)
    }
}

/// What a value must be, in words.
fn expectation(schema: &Map<String, Value>) -> String {
    let bound = |key: &str| schema.get(key).and_then(Value::as_f64);
    let (least, below, most) = (bound("minimum"), bound("exclusiveMinimum"), bound("maximum"));
    match type_of(schema) {
        Some("number") => match (least, below, most) {
            (None, Some(0.0), None) => "positive and finite".to_owned(),
            (Some(0.0), None, None) => "a finite number, not negative".to_owned(),
            (Some(least), None, Some(most)) => format!("a number from {least} to {most}"),
            (None, Some(below), Some(most)) => format!("a number above {below} and at most {most}"),
            _ => "a finite number".to_owned(),
        },
        Some("integer") => match (least, most) {
            (Some(least), Some(most)) => format!("a whole number from {least} to {most}"),
            (Some(least), None) => format!("a whole number, at least {least}"),
            _ => "a whole number".to_owned(),
        },
        Some("boolean") => "true or false".to_owned(),
        Some("string") => match schema.get("enum").and_then(Value::as_array) {
            Some(choices) => {
                let names: Vec<&str> = choices.iter().filter_map(Value::as_str).collect();
                format!("one of {}", names.join(", "))
            }
            None => "text".to_owned(),
        },
        Some("array") => {
            let bound = |key: &str| schema.get(key).and_then(Value::as_u64);
            let items = match schema.get("items").and_then(Value::as_object).and_then(type_of) {
                Some("number" | "integer") => "number",
                Some("array") => "list",
                Some("object") => "mapping",
                _ => "value",
            };
            match (bound("minItems"), bound("maxItems")) {
                (Some(least), Some(most)) if least == most => {
                    format!("a list of {least} {}", plural(least, items))
                }
                (Some(least), None) => {
                    format!("a list of at least {least} {}", plural(least, items))
                }
                _ => format!("a list of {items}s"),
            }
        }
        Some("object") => "a mapping of keys to values".to_owned(),
        _ => "a value".to_owned(),
    }
}

fn plural(count: u64, noun: &str) -> String {
    if count == 1 { noun.to_owned() } else { format!("{noun}s") }
}
