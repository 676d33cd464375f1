//! At some poses a mode was not seen and the next one took its column.

use super::{Arm, Candidate, Cause, Words};

pub(super) const WORDS: Words = Words {
    what: "at some poses the mode was not seen and the next one took its column",
    rivals: "an aliased mode",
    test: "hit these poses again at another place and in another direction",
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
