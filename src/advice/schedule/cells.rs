//! The plane of path and spindle speed, cut into cells along the path; in each, the corridors between the
//! bands.
//!
//! A band of a line is where the speed would lie in a mode's widened band: f_r(s) (1 ± w) · 60/k. Within a
//! cell its edges are taken as straight, moved outwards by as much as they bulge in between; bands that
//! touch, overlap or change places are one. What is left over between two of them is a corridor: a
//! trapezium, so a speed that is linear between its sides stays within it.

use crate::excitation::ExcitationLine;
use crate::job::Policy;
use crate::path::{Path, Survey, SurveyFault};
use crate::risk::detail;
use crate::units::rpm_from_hz;

use super::super::choice::guard_rpm;
use super::super::ranges::Counting;
use super::super::speeds::{Speeds, ignored_speeds};
use crate::job::Spindle;

/// Cells along a path.
pub(super) const CELLS: usize = 500;

/// A region of a cell between straight edges: speeds at its left and its right side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trapezium {
    pub(super) left: Speeds,
    pub(super) right: Speeds,
}

/// The path cut into cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plane {
    /// s of the sides of the cells, from 0 to 1.
    pub(super) s: Vec<f64>,
    /// Per cell, ascending.
    pub(super) corridors: Vec<Vec<Trapezium>>,
}

/// What the modes do in one cell.
struct Cell {
    /// Per mode that counts: frequency at the left and right side and how far it bulges below and above
    /// the straight line between, Hz.
    modes: Vec<[f64; 4]>,
}

/// Cuts a path into cells. `survey` has stations wherever frequencies bend; bulges are taken `slack` times
/// as large as it shows them.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn plane(
    path: &Path,
    survey: &Survey,
    lines: &[ExcitationLine],
    counting: &Counting,
    spindle: &Spindle,
    slack: f64,
) -> Result<Plane, SurveyFault> {
    let s: Vec<f64> = (0..=CELLS).map(|i| i as f64 / CELLS as f64).collect();
    let sides = Survey::take(path, s.clone(), detail(counting.policy), &|_| {})?;
    let mut first = 0;
    let corridors = (0..CELLS)
        .map(|cell| {
            while first < survey.len() && survey.station(first).s <= s[cell] {
                first += 1;
            }
            let mut last = first;
            while last < survey.len() && survey.station(last).s < s[cell + 1] {
                last += 1;
            }
            let cell = look(&sides, cell, survey, first..last, counting, slack);
            corridors(&bands(&cell, lines, counting.policy), spindle)
        })
        .collect();
    Ok(Plane { s, corridors })
}

fn look(
    sides: &Survey,
    cell: usize,
    survey: &Survey,
    inner: std::ops::Range<usize>,
    counting: &Counting,
    slack: f64,
) -> Cell {
    /// What rounding leaves, as a share of the frequency.
    const ROUNDING: f64 = 1e-9;
    let (left, right) = (sides.station(cell), sides.station(cell + 1));
    let modes = (0..left.frequencies_hz.len()).filter_map(|r| {
        let (a, b) = (left.frequencies_hz[r], right.frequencies_hz[r]);
        let mut is_counted = counting.counts(&left, r) || counting.counts(&right, r);
        let (mut below, mut above) = (ROUNDING * a, ROUNDING * a);
        for i in inner.clone() {
            let station = survey.station(i);
            is_counted |= counting.counts(&station, r);
            let chord = a + (b - a) * (station.s - left.s) / (right.s - left.s);
            let bulge = slack * (station.frequencies_hz[r] - chord);
            (below, above) = (below.max(-bulge), above.max(bulge));
        }
        is_counted.then_some([a, b, below, above])
    });
    Cell { modes: modes.collect() }
}

/// The bands in a cell, cut where excitation is somebody else's business.
fn bands(cell: &Cell, lines: &[ExcitationLine], policy: &Policy) -> Vec<Trapezium> {
    let mut bands = Vec::new();
    for &[left_hz, right_hz, below_hz, above_hz] in &cell.modes {
        for &line in lines {
            let rpm = |hz: f64| rpm_from_hz(hz) / f64::from(line.order);
            let side = |hz: f64| Speeds {
                low_rpm: rpm((hz - below_hz) * (1.0 - policy.wide())),
                high_rpm: rpm((hz + above_hz) * (1.0 + policy.wide())),
            };
            let whole = Trapezium { left: side(left_hz), right: side(right_hz) };
            let pieces = ignored_speeds(policy, line).fold(vec![whole], |pieces, ignored| {
                pieces.into_iter().flat_map(|piece| without(piece, ignored)).flatten().collect()
            });
            bands.extend(pieces);
        }
    }
    bands
}

/// What a band leaves below and above a strip. An edge that crosses the strip's is taken level.
fn without(band: Trapezium, strip: Speeds) -> [Option<Trapezium>; 2] {
    let Trapezium { left, right } = band;
    let cut_top = left.high_rpm.max(right.high_rpm) > strip.low_rpm;
    let below = (left.low_rpm.min(right.low_rpm) < strip.low_rpm).then(|| {
        let side = |side: Speeds| Speeds {
            low_rpm: side.low_rpm.min(strip.low_rpm),
            high_rpm: if cut_top { strip.low_rpm } else { side.high_rpm },
        };
        Trapezium { left: side(left), right: side(right) }
    });
    let cut_bottom = left.low_rpm.min(right.low_rpm) < strip.high_rpm;
    let above = (left.high_rpm.max(right.high_rpm) > strip.high_rpm).then(|| {
        let side = |side: Speeds| Speeds {
            low_rpm: if cut_bottom { strip.high_rpm } else { side.low_rpm },
            high_rpm: side.high_rpm.max(strip.high_rpm),
        };
        Trapezium { left: side(left), right: side(right) }
    });
    [below, above]
}

/// What bands leave of the spindle's range, with a guard along them.
fn corridors(bands: &[Trapezium], spindle: &Spindle) -> Vec<Trapezium> {
    let mut sorted = bands.to_vec();
    sorted.sort_by(|a, b| a.left.low_rpm.total_cmp(&b.left.low_rpm));
    // Bands that leave no way between them, merged; each lies above the one before on both sides.
    let mut merged: Vec<Trapezium> = Vec::new();
    for band in sorted {
        let mut whole = band;
        while let Some(before) = merged.pop_if(|before| {
            before.left.high_rpm > whole.left.low_rpm || before.right.high_rpm > whole.right.low_rpm
        }) {
            let join = |a: Speeds, b: Speeds| Speeds {
                low_rpm: a.low_rpm.min(b.low_rpm),
                high_rpm: a.high_rpm.max(b.high_rpm),
            };
            whole = Trapezium {
                left: join(before.left, whole.left),
                right: join(before.right, whole.right),
            };
        }
        merged.push(whole);
    }
    let Spindle { min_rpm, max_rpm, .. } = *spindle;
    let above_band = |rpm: f64| (rpm + guard_rpm(rpm)).max(min_rpm);
    let below_band = |rpm: f64| (rpm - guard_rpm(rpm)).min(max_rpm);
    let mut floor = (min_rpm, min_rpm);
    let mut found = Vec::new();
    for band in &merged {
        found.push((floor, (below_band(band.left.low_rpm), below_band(band.right.low_rpm))));
        floor = (above_band(band.left.high_rpm), above_band(band.right.high_rpm));
    }
    found.push((floor, (max_rpm, max_rpm)));
    found
        .into_iter()
        .filter(|(low, high)| low.0 <= high.0 && low.1 <= high.1)
        .map(|(low, high)| Trapezium {
            left: Speeds { low_rpm: low.0, high_rpm: high.0 },
            right: Speeds { low_rpm: low.1, high_rpm: high.1 },
        })
        .collect()
}
