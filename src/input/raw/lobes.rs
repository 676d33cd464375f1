//! A file of modes of a tool tip as it is written.

use schemars::JsonSchema;
use serde::Deserialize;

use super::job::{Coefficients, Direction, TipMode, Tool};

/// Modes of a tool tip and the cut that it is in.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune modes.yaml")]
pub(in crate::input) struct Lobes {
    /// Free text.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) note: Option<String>,
    /// The modes, as seen at the tip.
    #[schemars(required, extend("minItems" = 1))]
    pub(in crate::input) modes: Option<Vec<TipMode>>,
    /// The cutter.
    #[schemars(required)]
    pub(in crate::input) tool: Option<Tool>,
    /// How the tool cuts.
    #[schemars(required)]
    pub(in crate::input) cutting: Option<Cut>,
}

/// How the tool cuts; the axial depth is what is sought.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Cut {
    /// Radial depth of cut, mm; not needed for a slot or a drill.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000, "examples" = [6]))]
    pub(in crate::input) radial_depth_mm: Option<f64>,
    /// On which side of the cut the chip is thick: climb (down-milling), conventional (up-milling)
    /// or slot; or drill, along the axis, where the limit is a width of cut.
    #[schemars(required)]
    pub(in crate::input) direction: Option<Direction>,
    /// Of a drill: diameter of the hole that is there before, mm; 0, none, if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 1000, "default" = 0, "examples" = [4]))]
    pub(in crate::input) pilot_diameter_mm: Option<f64>,
    /// Name of the work's material: one of al-6061, al-6082 and al-7075, where coefficients are
    /// absent.
    #[schemars(extend("examples" = ["al-6082"]))]
    pub(in crate::input) material: Option<String>,
    /// Your own cutting coefficients.
    pub(in crate::input) coefficients: Option<Coefficients>,
    /// Whether a tooth cuts what the one ahead of it has left (true), or meets fresh material, so
    /// that modes can only feed each other; true if absent.
    #[schemars(extend("default" = true))]
    pub(in crate::input) regeneration: Option<bool>,
    /// Process damping C, N/mm, of the flank that rubs on the waves of the surface: the force
    /// against the motion normal to it is C times the depth times the speed of that motion over the
    /// cutting speed; 0, none, if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 1000000, "default" = 0, "examples" = [250]))]
    pub(in crate::input) process_damping_n_per_mm: Option<f64>,
}
