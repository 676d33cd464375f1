//! What a schedule that crosses bands exposes the arm to.

use schemars::JsonSchema;
use serde::Serialize;

use super::not_cutting::is_not_cutting_between;
use super::task::{Task, mean};
use crate::advice::vibration::Chip;
use crate::excitation::{ExcitationLine, WithoutOrder};
use crate::job::SpindleSpeed;
use crate::risk::{Certainty, Crossing};
use crate::units::{hz_from_rpm, written};

/// A stretch on which a line crosses a mode's widened band.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Exposure {
    /// Counted from 1 in ascending frequency.
    pub mode: usize,
    /// The line.
    #[serde(flatten, with = "WithoutOrder")]
    pub line: ExcitationLine,
    /// Whether the line also lies in the band itself.
    #[schemars(with = "&'static str")]
    pub certainty: Certainty,
    /// Where it begins, 0 to 1.
    pub from_s: f64,
    /// Where it ends.
    pub to_s: f64,
    /// Spindle speed where it begins and ends, rev/min.
    #[serde(skip)]
    pub ends_rpm: [f64; 2],
    /// Time inside the band.
    pub seconds: f64,
    /// Teeth that enter the work in that time.
    pub tooth_impacts: f64,
    /// Whether the whole of it is run in the air: at more than twice the operation's feed.
    #[serde(rename = "in_air")]
    pub is_in_air: bool,
    /// What the mode moves the tool tip at resonance where the line is closest.
    #[serde(rename = "tip_response_um_per_n", serialize_with = "written::um")]
    pub tip_response_m_per_n: f64,
    /// What the cutting force moves the tool tip there; null where the job does not say enough of
    /// the cut.
    #[serde(rename = "tip_amplitude_um", serialize_with = "written::um")]
    pub tip_amplitude_m: Option<f64>,
    /// Lines of the moves, first and last.
    #[serde(skip)]
    pub lines: [usize; 2],
}

// Of exposures, certain and uncertain, that touch.
/// A line going once through a mode's widened band.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Passage {
    /// Counted from 1 in ascending frequency.
    pub mode: usize,
    /// The line.
    #[serde(flatten, with = "WithoutOrder")]
    pub line: ExcitationLine,
    /// Where it enters and leaves the band, and at which speeds.
    pub from_s: f64,
    /// Where it leaves the band.
    pub to_s: f64,
    /// Spindle speed where it enters.
    pub from_rpm: f64,
    /// Spindle speed where it leaves.
    pub to_rpm: f64,
    /// Time inside the band.
    pub seconds: f64,
    /// Of this, seconds in the band itself, not only in what the model's uncertainty adds to it.
    #[serde(rename = "certain_seconds")]
    pub certain_s: f64,
    /// Teeth that enter the work in that time.
    pub tooth_impacts: f64,
    /// Whether the whole of it is run in the air.
    #[serde(rename = "in_air")]
    pub is_in_air: bool,
    /// What the mode moves the tool tip at resonance, where most.
    #[serde(rename = "tip_response_um_per_n", serialize_with = "written::um")]
    pub tip_response_m_per_n: f64,
    /// The largest of the exposures.
    #[serde(rename = "tip_amplitude_um", serialize_with = "written::um")]
    pub tip_amplitude_m: Option<f64>,
    /// Lines of the moves, first and last.
    #[serde(skip)]
    pub lines: [usize; 2],
}

/// What a check found under a speed, as exposures.
pub(super) fn exposures(
    task: &Task,
    speed: &SpindleSpeed,
    feed_m_per_s: f64,
    duration_s: f64,
    found: Vec<Crossing>,
) -> Vec<Exposure> {
    let exposure = |crossing: Crossing| {
        let [from_s, to_s] = [crossing.from_s, crossing.to_s];
        let ends: Vec<f64> = std::iter::once(from_s)
            .chain(speed.corners().filter(|s| *s > from_s && *s < to_s))
            .chain([to_s])
            .collect();
        let rpm: Vec<f64> = ends.iter().map(|&s| speed.rpm_at(s)).collect();
        let turns = hz_from_rpm(mean(&ends, &rpm)) * duration_s;
        let is_in_air = is_not_cutting_between(task, from_s, to_s);
        let tip_amplitude_m = task.tip.map(|tip| {
            let at = crossing.closest_s;
            let chip = Chip::Feed(feed_m_per_s);
            if is_in_air { 0.0 } else { tip.amplitude_near(at, speed.rpm_at(at), chip) }
        });
        Exposure {
            mode: crossing.mode,
            line: crossing.line,
            certainty: crossing.certainty,
            from_s,
            to_s,
            ends_rpm: [speed.rpm_at(from_s), speed.rpm_at(to_s)],
            seconds: (to_s - from_s) * duration_s,
            tooth_impacts: turns * f64::from(task.operation.tool.teeth),
            is_in_air,
            tip_response_m_per_n: crossing.tip_response_m_per_n,
            // As if the line stayed there; nothing is cut in the air.
            tip_amplitude_m,
            lines: [crossing.from_line, crossing.to_line],
        }
    };
    found.into_iter().map(exposure).collect()
}

/// The share of the path inside any band; where bands overlap it counts once.
pub(super) fn exposed_share(exposures: &[Exposure]) -> f64 {
    let mut stretches: Vec<(f64, f64)> = exposures.iter().map(|e| (e.from_s, e.to_s)).collect();
    stretches.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut share, mut reached) = (0.0, 0.0_f64);
    for (from, to) in stretches {
        share += (to - from.max(reached)).max(0.0);
        reached = reached.max(to);
    }
    share
}

/// Exposures of one mode and line that touch, put together; ascending by where they begin.
pub(super) fn passages(exposures: &[Exposure]) -> Vec<Passage> {
    let mut passages: Vec<Passage> = Vec::new();
    for exposure in exposures {
        let is_certain = exposure.certainty == Certainty::Certain;
        let certain_s = if is_certain { exposure.seconds } else { 0.0 };
        let before = passages.iter_mut().rev().find(|p| {
            (p.mode, p.line) == (exposure.mode, exposure.line) && p.to_s == exposure.from_s
        });
        let [from_rpm, to_rpm] = exposure.ends_rpm;
        let Some(p) = before else {
            passages.push(Passage {
                mode: exposure.mode,
                line: exposure.line,
                from_s: exposure.from_s,
                to_s: exposure.to_s,
                from_rpm,
                to_rpm,
                seconds: exposure.seconds,
                certain_s,
                tooth_impacts: exposure.tooth_impacts,
                is_in_air: exposure.is_in_air,
                tip_response_m_per_n: exposure.tip_response_m_per_n,
                tip_amplitude_m: exposure.tip_amplitude_m,
                lines: exposure.lines,
            });
            continue;
        };
        (p.to_s, p.to_rpm) = (exposure.to_s, to_rpm);
        p.seconds += exposure.seconds;
        p.certain_s += certain_s;
        p.tooth_impacts += exposure.tooth_impacts;
        p.is_in_air &= exposure.is_in_air;
        p.tip_response_m_per_n = p.tip_response_m_per_n.max(exposure.tip_response_m_per_n);
        p.tip_amplitude_m = match (p.tip_amplitude_m, exposure.tip_amplitude_m) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        p.lines[1] = exposure.lines[1];
    }
    passages
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::Source;

    fn exposure(mode: usize, certainty: Certainty, [from_s, to_s]: [f64; 2]) -> Exposure {
        Exposure {
            mode,
            line: ExcitationLine { source: Source::ToothPassing, harmonic: 1, order: 2 },
            certainty,
            from_s,
            to_s,
            ends_rpm: [1000.0 * from_s, 1000.0 * to_s],
            seconds: 10.0 * (to_s - from_s),
            tooth_impacts: 300.0 * (to_s - from_s),
            is_in_air: from_s > 0.3,
            tip_response_m_per_n: 1e-6 * to_s,
            lines: [(100.0 * from_s) as usize, (100.0 * to_s) as usize],
            tip_amplitude_m: (mode == 1).then_some(1e-6 * from_s),
        }
    }

    #[test]
    fn time_in_two_bands_at_once_counts_once() {
        let share = |ends: &[[f64; 2]]| {
            let all: Vec<Exposure> =
                ends.iter().map(|e| exposure(1, Certainty::Certain, *e)).collect();
            exposed_share(&all)
        };
        assert_eq!(share(&[]), 0.0);
        // Apart, touching, overlapping, one within another, and in any order.
        for (ends, expected) in [
            (vec![[0.1, 0.2], [0.5, 0.75]], 0.35),
            (vec![[0.25, 0.5], [0.5, 0.75]], 0.5),
            (vec![[0.25, 0.5], [0.375, 0.75]], 0.5),
            (vec![[0.25, 1.0], [0.375, 0.5], [0.625, 0.75]], 0.75),
            (vec![[0.5, 0.75], [0.0, 0.25], [0.125, 0.5]], 0.75),
        ] {
            assert!((share(&ends) - expected).abs() < 1e-15, "{ends:?}");
        }
    }

    #[test]
    fn exposures_that_touch_are_one_passage() {
        use Certainty::{Certain, Uncertain};
        let all = [
            exposure(1, Uncertain, [0.25, 0.375]),
            exposure(2, Uncertain, [0.25, 0.5]),
            exposure(1, Certain, [0.375, 0.5]),
            exposure(1, Uncertain, [0.5, 0.625]),
            exposure(1, Certain, [0.75, 0.875]),
        ];
        let found = passages(&all);
        let found_places: Vec<_> =
            found.iter().map(|p| (p.mode, [p.from_s, p.to_s], p.seconds)).collect();
        let expected = [(1, [0.25, 0.625], 3.75), (2, [0.25, 0.5], 2.5), (1, [0.75, 0.875], 1.25)];
        assert_eq!(found_places, expected);
        let first = &found[0];
        assert_eq!((first.certain_s, first.tooth_impacts), (1.25, 112.5));
        assert_eq!(([first.from_rpm, first.to_rpm], first.lines), ([250.0, 625.0], [25, 62]));
        assert!(!first.is_in_air && found[2].is_in_air);
        assert_eq!((first.tip_amplitude_m, found[1].tip_amplitude_m), (Some(1e-6 * 0.5), None));
        assert_eq!(first.tip_response_m_per_n, 1e-6 * 0.625);
    }
}
