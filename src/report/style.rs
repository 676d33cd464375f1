//! Colours of the terminal (ECMA-48, Select Graphic Rendition).

use std::fmt::Display;

use crate::risk::Verdict;

/// Bold red.
pub(super) const RESONANCE: &str = "1;31";
/// Bold yellow.
pub(super) const UNCERTAIN: &str = "1;33";
/// Bold green.
pub(super) const CLEAR: &str = "1;32";
/// Cyan.
pub(super) const LINE: &str = "36";
/// Bold.
pub(super) const STRONG: &str = "1";

/// The colour of a verdict.
pub(super) fn of(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Clear => CLEAR,
        Verdict::Uncertain | Verdict::Unchecked => UNCERTAIN,
        Verdict::Resonance => RESONANCE,
    }
}

/// The text in a style, or plain.
pub(super) fn paint(style: &str, text: impl Display, colour: bool) -> String {
    if colour { format!("\x1b[{style}m{text}\x1b[0m") } else { text.to_string() }
}
