//! What bounds a cut.

use schemars::JsonSchema;
use serde::Serialize;

use crate::units::written;

/// Limits beyond this depth are not told, m.
pub const DEEPEST_M: f64 = 1.0;

/// How a limit is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`zeroth`: the cut replaced by its mean over a turn. `exact`: the growth of a \
                   small motion over one tooth period."
)]
pub enum Method {
    /// The cut replaced by its mean.
    Zeroth,
    /// By the growth of a small motion.
    Exact,
}

/// What a limit bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`axial_depth`: of a mill. `width_of_cut`: of a drill, what a lip takes across \
                   the axis, (D − d) / 2 with d the hole that\nis there before: limit_mm and \
                   depth_mm are that."
)]
pub enum LimitOf {
    /// The axial depth of a mill.
    AxialDepth,
    /// What the lip of a drill takes across the axis.
    WidthOfCut,
}

impl LimitOf {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::AxialDepth => "axial depth",
            Self::WidthOfCut => "width of cut",
        }
    }

    /// The same beside what says that it is about a cut.
    pub fn short_name(self) -> &'static str {
        match self {
            Self::AxialDepth => "depth",
            Self::WidthOfCut => "width of cut",
        }
    }
}

/// How a cut becomes unstable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`hopf`: a vibration beside the tooth passing, fed by what it leaves on the \
                   surface. `flip`: one that repeats every second tooth.\n`coupling`: modes that \
                   feed each other without what was left on the surface."
)]
pub enum Kind {
    /// At a frequency of its own.
    Hopf,
    /// At an odd multiple of half the tooth-passing frequency.
    Flip,
    /// Without regeneration.
    Coupling,
}

impl Kind {
    /// Its word in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hopf => "hopf",
            Self::Flip => "flip",
            Self::Coupling => "coupling",
        }
    }
}

/// The smallest axial depth at which a cut becomes unstable, or width of cut of a drill.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Limit {
    /// The depth.
    #[serde(rename = "limit_mm", serialize_with = "written::mm")]
    pub depth_m: f64,
    /// Of the vibration that grows.
    pub frequency_hz: f64,
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub kind: Kind,
}
