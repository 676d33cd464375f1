//! How sure a finding is.

use schemars::JsonSchema;
use serde::Serialize;

/// How sure a crossing is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`certain`: inside the band f (1 ± separation). `uncertain`: outside that band, \
                   inside the one widened by\nthe model's uncertainty."
)]
pub enum Certainty {
    /// Outside the band, inside the one widened by the model's uncertainty.
    Uncertain,
    /// Inside the band f_r (1 ± separation).
    Certain,
}
