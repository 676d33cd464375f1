//! What is asked for.

use schemars::JsonSchema;
use serde::Serialize;

/// What makes one safe speed better than another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub enum Objective {
    /// Nearest to the programmed one.
    #[default]
    Nearest,
    /// Farthest from everything, as a share of the modes' frequencies.
    Margin,
    /// The highest.
    Highest,
    /// The one at which the tool tip vibrates least; needs `cutting`.
    Vibration,
    /// The one at which the cut chatters at the largest depth only; needs `cutting`. It is one of
    /// the safe speeds as all others are, and no promise.
    Depth,
}

/// What becomes of the feed when the speed changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FeedRule {
    /// It keeps the chip load: the feed per tooth stays what it was.
    #[default]
    ChipLoad,
    /// It stays as programmed.
    Programmed,
}

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// What makes one safe speed better than another.
    pub objective: Objective,
    /// What becomes of the feed.
    pub feed: FeedRule,
    /// Whether to plan a speed that varies along the path even where a constant one is safe.
    pub schedule: bool,
}
