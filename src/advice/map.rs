//! The bands in the plane of path and spindle speed, to be drawn.

use super::ranges::Counting;
use super::speeds::Speeds;
use crate::excitation::ExcitationLine;
use crate::path::Survey;
use crate::units::rpm_from_hz;

/// Where the modes lie along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedMap {
    /// Ascending, from 0 to 1.
    pub s: Vec<f64>,
    /// Per station and mode, Hz; `None` where the mode does not count.
    frequencies_hz: Vec<Vec<Option<f64>>>,
    /// Half width of the bands, as a share of the frequency.
    half_width: f64,
}

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

impl SpeedMap {
    pub(super) fn new(survey: &Survey, counting: &Counting) -> Self {
        let step = survey.len().div_ceil(400).max(1);
        let mut shown: Vec<usize> = (0..survey.len()).step_by(step).collect();
        if shown.last().is_some_and(|last| last + 1 < survey.len()) {
            shown.push(survey.len() - 1);
        }
        let frequencies_hz = shown.iter().map(|&i| {
            let station = survey.station(i);
            let modes = station.frequencies_hz.iter().enumerate();
            modes.map(|(r, &hz)| counting.counts(&station, r).then_some(hz)).collect()
        });
        Self {
            s: shown.iter().map(|&i| survey.station(i).s).collect(),
            frequencies_hz: frequencies_hz.collect(),
            half_width: counting.policy.wide(),
        }
    }

    /// The bands of all lines, in stretches on which the mode counts.
    pub fn ribbons(&self, lines: &[ExcitationLine]) -> Vec<Ribbon> {
        let modes = self.frequencies_hz.first().map_or(0, Vec::len);
        let mut ribbons: Vec<Ribbon> = Vec::new();
        for &line in lines {
            let rpm = |hz: f64| rpm_from_hz(hz) / f64::from(line.order);
            for r in 0..modes {
                let mut is_open = false;
                for (&s, frequencies) in self.s.iter().zip(&self.frequencies_hz) {
                    let Some(hz) = frequencies[r] else {
                        is_open = false;
                        continue;
                    };
                    let edge = Speeds {
                        low_rpm: rpm(hz * (1.0 - self.half_width)),
                        high_rpm: rpm(hz * (1.0 + self.half_width)),
                    };
                    match ribbons.last_mut().filter(|_| is_open) {
                        Some(ribbon) => ribbon.edges.push((s, edge)),
                        None => {
                            ribbons.push(Ribbon { mode: r + 1, line, edges: vec![(s, edge)] });
                        }
                    }
                    is_open = true;
                }
            }
        }
        ribbons
    }
}
