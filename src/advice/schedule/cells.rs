//! The plane of path and spindle speed, cut into cells along the path; in each, the corridors
//! between the bands.
//!
//! A band of a line is where the speed would lie in a mode's widened band: f_r(s) (1 ± w) · 60/k.
//! Within a cell its edges are taken as straight, moved outwards by as much as they bulge in
//! between; bands that touch, overlap or change places are one. What is left over between two of
//! them is a corridor: a trapezium, so a speed that is linear between its sides stays within it.

use crate::excitation::ExcitationLine;
use crate::job::Policy;
use crate::notes::Note;
use crate::path::{Path, Station, Survey};
use crate::progress::silent;
use crate::risk::detail;
use crate::units::rpm_from_hz;

use crate::advice::choice::guard_rpm;
use crate::advice::ranges::Counting;
use crate::advice::speeds::{Speeds, ignored_speeds};
use crate::job::Spindle;

/// Cells along a path, where nothing asks for more.
const CELLS: usize = 500;

/// A region of a cell between straight edges: speeds at its left and its right side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trapezium {
    pub(super) left: Speeds,
    pub(super) right: Speeds,
}

/// The path cut into cells, with the corridors that are left in each.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plane<'a> {
    /// s of the sides of the cells, from 0 to 1.
    pub(super) s: &'a [f64],
    /// Per cell, ascending.
    pub(super) corridors: Vec<Vec<Trapezium>>,
}

/// The path cut into cells, and what the modes do in each.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    /// s of the sides, from 0 to 1.
    pub(super) s: Vec<f64>,
    cells: Vec<Cell>,
}

/// What the modes do in one cell.
#[derive(Debug, Clone, PartialEq)]
struct Cell {
    /// Those that count.
    modes: Vec<ModeInCell>,
}

/// What a mode's widened band lies about in a cell, Hz: lower and upper end.
#[derive(Debug, Clone, PartialEq)]
struct ModeInCell {
    /// At the left side.
    left_hz: [f64; 2],
    /// At the right side.
    right_hz: [f64; 2],
    /// How far they bulge outwards of the straight lines between.
    bulge_hz: [f64; 2],
}

/// Sides of [`CELLS`] equal cells, and of more where `places` (ascending) lie between them.
pub(super) fn sides(places: &[f64]) -> Vec<f64> {
    /// Sides closer than this are one.
    const ONE: f64 = 1e-6;
    let equal = (0..=CELLS).map(|i| i as f64 / CELLS as f64);
    let is_apart = |s: f64| {
        let after = places.partition_point(|place| *place < s);
        let near = [after.checked_sub(1), Some(after)].into_iter().flatten();
        near.filter_map(|i| places.get(i)).all(|place| (place - s).abs() > ONE)
    };
    let mut s: Vec<f64> = equal.filter(|&s| s == 0.0 || s == 1.0 || is_apart(s)).collect();
    s.extend(places.iter().filter(|place| (ONE..=1.0 - ONE).contains(*place)));
    s.sort_by(f64::total_cmp);
    s.dedup_by(|b, a| *b - *a < ONE);
    s
}

impl Cells {
    /// Looks at a path in the cells between `s`. `survey` has stations wherever frequencies bend;
    /// bulges are taken `slack` times as large as it and the middles of the cells show them.
    ///
    /// # Errors
    /// The arm has no modes somewhere.
    pub(super) fn look(
        path: &Path,
        s: Vec<f64>,
        survey: &Survey,
        counting: &Counting,
        slack: f64,
    ) -> Result<Self, Note> {
        let middles = s.windows(2).flat_map(|side| [side[0], 0.5 * (side[0] + side[1])]);
        let stations: Vec<f64> = middles.chain([1.0]).collect();
        let own = Survey::take(path, stations, detail(counting.rules.policy), &silent)?;
        let mut first = 0;
        let cells = (0..s.len() - 1).map(|i| {
            while first < survey.len() && survey.station(first).s <= s[i] {
                first += 1;
            }
            let mut last = first;
            while last < survey.len() && survey.station(last).s < s[i + 1] {
                last += 1;
            }
            let between = (first..last).map(|k| survey.station(k));
            let ends = [own.station(2 * i), own.station(2 * i + 2)];
            cell(ends, between.chain([own.station(2 * i + 1)]), counting, slack)
        });
        let cells = cells.collect();
        Ok(Self { s, cells })
    }

    /// The corridors between bands of half width `half_width` (a share of the frequency).
    pub(super) fn plane(
        &self,
        lines: &[ExcitationLine],
        policy: &Policy,
        spindle: &Spindle,
        half_width: f64,
    ) -> Plane<'_> {
        let of = |cell| corridors(&bands(cell, lines, policy, half_width), spindle);
        Plane { s: &self.s, corridors: self.cells.iter().map(of).collect() }
    }
}

fn cell<'s>(
    [left, right]: [Station<'s>; 2],
    between: impl Iterator<Item = Station<'s>> + Clone,
    counting: &Counting,
    slack: f64,
) -> Cell {
    let reach_hz = |station: &Station, r: usize| {
        counting.rules.reach_hz(station.s, r, station.frequencies_hz[r])
    };
    let modes = (0..left.frequencies_hz.len()).filter_map(|r| {
        let (a, b) = (reach_hz(&left, r), reach_hz(&right, r));
        let mut is_counted = counting.counts(&left, r) || counting.counts(&right, r);
        let mut bulge_hz = [1e-9 * a[0], 1e-9 * a[1]];
        for station in between.clone() {
            is_counted |= counting.counts(&station, r);
            let way = (station.s - left.s) / (right.s - left.s);
            let reach_hz = reach_hz(&station, r);
            let beyond = |end: usize| slack * (reach_hz[end] - (a[end] + (b[end] - a[end]) * way));
            bulge_hz = [bulge_hz[0].max(-beyond(0)), bulge_hz[1].max(beyond(1))];
        }
        is_counted.then_some(ModeInCell { left_hz: a, right_hz: b, bulge_hz })
    });
    Cell { modes: modes.collect() }
}

/// The bands in a cell, cut where the policy ignores excitation.
fn bands(
    cell: &Cell,
    lines: &[ExcitationLine],
    policy: &Policy,
    half_width: f64,
) -> Vec<Trapezium> {
    let mut bands = Vec::new();
    for ModeInCell { left_hz, right_hz, bulge_hz: [below_hz, above_hz] } in &cell.modes {
        for &line in lines {
            let rpm = |hz: f64| rpm_from_hz(hz) / f64::from(line.order);
            let side = |[low_hz, high_hz]: &[f64; 2]| Speeds {
                low_rpm: rpm((low_hz - below_hz) * (1.0 - half_width)),
                high_rpm: rpm((high_hz + above_hz) * (1.0 + half_width)),
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
