//! How far from everything a job stays where nothing is crossed.

use super::verdict::{Approach, Sample};
use crate::excitation::ExcitationLine;
use crate::job::Policy;

/// The closest approach of any line to any mode among the samples of a path; `None` where no line
/// and no mode count. What the policy lets pass (ignored bands, modes that hardly move the tool
/// tip) does not count. Of equals the first along the path, then the lowest mode, then the lowest
/// line.
pub fn closest_approach(
    samples: &[Sample],
    lines: &[ExcitationLine],
    policy: &Policy,
    min_tip_response_m_per_n: f64,
) -> Option<Approach> {
    let mut closest: Option<Approach> = None;
    for sample in samples {
        for approach in approaches(sample, lines, policy, min_tip_response_m_per_n) {
            if closest.is_none_or(|best| approach.separation < best.separation) {
                closest = Some(approach);
            }
        }
    }
    closest
}

fn approaches<'a>(
    sample: &'a Sample,
    lines: &'a [ExcitationLine],
    policy: &'a Policy,
    min_tip_response_m_per_n: f64,
) -> impl Iterator<Item = Approach> + 'a {
    let counts = move |mode: usize| {
        sample.rpm > 0.0
            && sample
                .tip_response_m_per_n
                .get(mode)
                .is_none_or(|&response| response >= min_tip_response_m_per_n)
    };
    let modes = sample
        .natural_frequencies_hz
        .iter()
        .enumerate()
        .filter(move |&(mode, &hz)| hz > 0.0 && counts(mode));
    modes.flat_map(move |(mode, &natural_frequency_hz)| {
        lines.iter().filter_map(move |&line| {
            let excitation_hz = line.frequency_hz(sample.rpm);
            (!policy.ignores(excitation_hz)).then(|| Approach {
                mode: mode + 1,
                line,
                s: sample.s,
                excitation_hz,
                natural_frequency_hz,
                separation: (excitation_hz - natural_frequency_hz).abs() / natural_frequency_hz,
            })
        })
    })
}
