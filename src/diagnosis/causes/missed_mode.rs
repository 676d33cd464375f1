//! At some poses a mode was not seen and the next one took its column.

use super::{Arm, Candidate, Cause, CauseText};

pub(super) const TEXT: CauseText = CauseText {
    description: "at some poses the mode was missed and the next mode is in its column",
    confounded_with: "an aliased mode",
    test: "repeat the impact at these poses, at another place and in another direction",
};

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    // Nothing takes the last one's column.
    (1..arm.modes)
        .map(|mode| {
            let candidate = Candidate::new(Cause::MissedMode, &mode.to_string(), Vec::new());
            // The share of the poses, which the likelihood chooses.
            Candidate { hidden_freedom: 1.0, ..candidate }
        })
        .collect()
}
