//! detune.toml as it is written.

use schemars::JsonSchema;
use serde::Deserialize;

use super::job::{Acceptance, Policy};

/// What the jobs in a folder, and in those below it, share.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune.toml")]
pub(in crate::input) struct Settings {
    /// robot.yaml, relative to this file, of jobs that name none.
    #[schemars(extend("examples" = ["robots/irb1600/robot.yaml"]))]
    pub(in crate::input) robot: Option<String>,
    /// When an excitation line near a natural frequency counts: each key where a job does not give
    /// it.
    pub(in crate::input) policy: Option<Policy>,
    /// Findings that count no more until a day, beside those that a job accepts.
    pub(in crate::input) accept: Option<Vec<Acceptance>>,
}
