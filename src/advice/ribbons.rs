//! The bands in the plane of path and spindle speed, to be drawn.

use super::ranges::Counting;
use super::speeds::Speeds;
use crate::excitation::ExcitationLine;
use crate::path::Survey;
use crate::units::rpm_from_hz;

/// A band of one line and one mode on a stretch of the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Ribbon {
    /// Index of the mode in ascending frequency, counted from 1.
    pub mode: usize,
    /// The line.
    pub line: ExcitationLine,
    /// s and the speeds between which the line lies in the mode's widened band.
    pub edges: Vec<(f64, Speeds)>,
}

/// The bands of all lines along a path, as far as a drawing shows them.
pub(super) fn ribbons(
    survey: &Survey,
    counting: &Counting,
    lines: &[ExcitationLine],
) -> Vec<Ribbon> {
    let step = survey.len().div_ceil(400).max(1);
    let last = survey.len().checked_sub(1).filter(|last| last % step != 0);
    let shown: Vec<usize> = (0..survey.len()).step_by(step).chain(last).collect();
    let modes = shown.first().map_or(0, |&i| survey.station(i).frequencies_hz.len());
    let half_width = counting.rules.half_width();
    let mut ribbons: Vec<Ribbon> = Vec::new();
    for &line in lines {
        let rpm = |hz: f64| rpm_from_hz(hz) / f64::from(line.order);
        for r in 0..modes {
            let mut is_open = false;
            for station in shown.iter().map(|&i| survey.station(i)) {
                if !counting.counts(&station, r) {
                    is_open = false;
                    continue;
                }
                let hz = station.frequencies_hz[r];
                let [low_hz, high_hz] = counting.rules.reach_hz(station.s, r, hz);
                let edge = Speeds {
                    low_rpm: rpm(low_hz * (1.0 - half_width)),
                    high_rpm: rpm(high_hz * (1.0 + half_width)),
                };
                match ribbons.last_mut().filter(|_| is_open) {
                    Some(ribbon) => ribbon.edges.push((station.s, edge)),
                    None => {
                        ribbons.push(Ribbon { mode: r + 1, line, edges: vec![(station.s, edge)] });
                    }
                }
                is_open = true;
            }
        }
    }
    ribbons
}
