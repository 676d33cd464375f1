//! What $ORI_TYPE and $CIRC_TYPE say of how the tool turns.

use super::value::Value;

/// What the program has set.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Turns {
    pub(super) on_lines: OnLines,
    /// The tool turns with the arc: $CIRC_TYPE #PATH.
    pub(super) with_arc: bool,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum OnLines {
    /// #VAR: to the orientation of the target.
    #[default]
    ToTarget,
    /// #CONSTANT: not at all.
    Not,
    /// #JOINT, #IGNORE, or not known: to where is not read.
    Unread,
}

impl Turns {
    pub(super) fn set_type(&mut self, value: &Value) {
        self.on_lines = match value {
            Value::Enum(name) if matches!(name.as_str(), "var" | "variable") => OnLines::ToTarget,
            Value::Enum(name) if matches!(name.as_str(), "constant" | "const") => OnLines::Not,
            _ => OnLines::Unread,
        };
    }

    pub(super) fn set_arc(&mut self, value: &Value) {
        self.with_arc = !matches!(value, Value::Enum(name) if name == "base");
    }
}
