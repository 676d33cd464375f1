//! What the policy leaves out of consideration on a whole path: a verdict says nothing about it.

use super::rules::Rules;
use super::verdict::LeftOut;
use crate::excitation::ExcitationLine;
use crate::job::SpindleSpeed;
use crate::path::Survey;

/// Lines in ignored bands and modes that hardly move the tool tip, from one end of the path to the
/// other.
pub(super) fn left_out(
    lines: &[ExcitationLine],
    speed: &SpindleSpeed,
    rules: &Rules,
    survey: &Survey,
) -> LeftOut {
    let [low, high] = speed.range_rpm();
    let ignored = |line: &&ExcitationLine| {
        rules.policy.ignores_all(line.frequency_hz(low), line.frequency_hz(high))
    };
    let modes = survey.stations().next().map_or(0, |station| station.frequencies_hz.len());
    let faint = |mode: &usize| {
        survey.stations().all(|station| {
            station.tip_m_per_n.get(*mode).is_some_and(|&response| rules.is_faint(response))
        })
    };
    LeftOut {
        lines: lines.iter().filter(ignored).copied().collect(),
        modes: (0..modes).filter(faint).map(|mode| mode + 1).collect(),
    }
}
