//! What each mode's frequency covers along a path: the ends to nine digits, not those of the
//! nearest sample.

use std::sync::atomic::{AtomicBool, Ordering};

use schemars::JsonSchema;
use serde::Serialize;

use crate::notes::Note;
use crate::path::{MAX_GAP, Path, Station, Survey};
use crate::risk::{Rules, SpindleProfile};

/// The ends of a range are found to this share of the frequency: 1e-5 rev/min of 10 000.
const END_TOLERANCE: f64 = 1e-9;

/// Stretches on which a mode counts end within this share of the path.
const STRETCH_TOLERANCE: f64 = 1e-8;

// f is continuous, so a stretch covers all between its lowest and highest; stretches that overlap
// in frequency are one range.
/// Frequencies that a mode covers on the stretches of the path where it counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Range")]
pub struct ModeRange {
    /// Counted from 1 in ascending frequency.
    pub mode: usize,
    /// Lowest frequency.
    #[serde(rename = "lowest_hz")]
    pub low_hz: f64,
    /// Where, 0 to 1.
    #[serde(rename = "lowest_s")]
    pub low_s: f64,
    /// Highest frequency.
    #[serde(rename = "highest_hz")]
    pub high_hz: f64,
    /// Where, 0 to 1.
    #[serde(rename = "highest_s")]
    pub high_s: f64,
    /// What the widened bands lie about: from the lowest to the highest end of the intervals, or
    /// the frequencies themselves where one figure says what they may lie off by.
    pub reach_hz: [f64; 2],
}

/// What decides whether a mode counts at a place.
#[derive(Debug, Clone)]
pub(super) struct Counting<'a> {
    pub(super) rules: &'a Rules<'a>,
    pub(super) spindle: SpindleProfile<'a>,
}

impl Counting<'_> {
    /// Whether mode `r` (from 0) counts at a station: the spindle turns and the mode moves the tool
    /// tip enough.
    pub(super) fn counts(&self, station: &Station, r: usize) -> bool {
        !self.spindle.is_stopped_at(station.s)
            && station.tip_m_per_n.get(r).is_none_or(|&tip| !self.rules.is_faint(tip))
    }
}

/// The ranges of all modes, by mode and ascending, and the survey refined as far as they need it.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn mode_ranges(
    path: &Path,
    counting: &Counting,
    first_look: Survey,
) -> Result<(Vec<ModeRange>, Survey), Note> {
    let modes = path.robot().coordinates().len();
    let mut survey = first_look;
    // The last pass looks at 5e-4 / 2²⁴ of the path.
    for pass in 1..=24 {
        let covered: Vec<Vec<ModeRange>> =
            (0..modes).map(|r| covered(counting, &survey, r)).collect();
        // One halving a pass, so that the next one goes by the slopes of its own neighbourhood.
        let narrowest = MAX_GAP * 0.5_f64.powi(pass);
        let is_waiting = AtomicBool::new(false);
        survey = survey.refine(path, |left, right, rates| {
            let wanted =
                (0..modes).any(|r| needs_halving(counting, left, right, r, rates[r], &covered[r]));
            let wide_enough = right.s - left.s > narrowest;
            if wanted && !wide_enough {
                is_waiting.store(true, Ordering::Relaxed);
            }
            wanted && wide_enough
        })?;
        // Cells that were halved are looked at once more.
        let is_done = !is_waiting.into_inner();
        if is_done {
            break;
        }
    }
    Ok(((0..modes).flat_map(|r| covered(counting, &survey, r)).collect(), survey))
}

/// What the stations of a survey show of mode `r`'s ranges.
fn covered(counting: &Counting, survey: &Survey, r: usize) -> Vec<ModeRange> {
    let mut stretches: Vec<ModeRange> = Vec::new();
    let mut is_open = false;
    for station in survey.stations() {
        if !counting.counts(&station, r) {
            is_open = false;
            continue;
        }
        let (f, s) = (station.frequencies_hz[r], station.s);
        let reach_hz = counting.rules.reach_hz(s, r, f);
        match stretches.last_mut().filter(|_| is_open) {
            Some(stretch) => {
                if f < stretch.low_hz {
                    (stretch.low_hz, stretch.low_s) = (f, s);
                }
                if f > stretch.high_hz {
                    (stretch.high_hz, stretch.high_s) = (f, s);
                }
                stretch.reach_hz = union(stretch.reach_hz, reach_hz);
            }
            None => {
                stretches.push(ModeRange {
                    mode: r + 1,
                    low_hz: f,
                    low_s: s,
                    high_hz: f,
                    high_s: s,
                    reach_hz,
                });
            }
        }
        is_open = true;
    }
    stretches.sort_by(|a, b| a.low_hz.total_cmp(&b.low_hz));
    let mut merged: Vec<ModeRange> = Vec::new();
    for stretch in stretches {
        match merged.last_mut().filter(|last| stretch.low_hz <= last.high_hz) {
            Some(last) => {
                if stretch.high_hz > last.high_hz {
                    (last.high_hz, last.high_s) = (stretch.high_hz, stretch.high_s);
                }
                last.reach_hz = union(last.reach_hz, stretch.reach_hz);
            }
            None => merged.push(stretch),
        }
    }
    merged
}

fn union(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// Whether the cell between two stations may hide frequencies that `covered` lacks. `rate` bounds
/// |d ln f_r / ds| in the cell.
fn needs_halving(
    counting: &Counting,
    left: &Station,
    right: &Station,
    r: usize,
    rate: f64,
    covered: &[ModeRange],
) -> bool {
    let width = right.s - left.s;
    match (counting.counts(left, r), counting.counts(right, r)) {
        (false, false) => return false,
        (true, true) => {}
        _ => return width > STRETCH_TOLERANCE,
    }
    let ends_hz = [left.frequencies_hz[r], right.frequencies_hz[r]];
    let after = covered.partition_point(|range| range.low_hz <= ends_hz[0].min(ends_hz[1]));
    let Some(range) = after.checked_sub(1).and_then(|i| covered.get(i)) else { return true };
    // A function with slopes within ± L stays within L h / 2 of the mean of its ends (Piyavskii).
    let beyond = |ends: [f64; 2], rate: f64, [low, high]: [f64; 2]| {
        let reach = 0.5 * rate * width * ends[0].max(ends[1]);
        let mean = 0.5 * (ends[0] + ends[1]);
        mean + reach > high * (1.0 + END_TOLERANCE) || mean - reach < low * (1.0 - END_TOLERANCE)
    };
    let rules = counting.rules;
    let of_ends = [left, right].map(|end| rules.reach_hz(end.s, r, end.frequencies_hz[r]));
    let edge_rate = rate + rules.edge_rate(left.s, right.s, r);
    beyond(ends_hz, rate, [range.low_hz, range.high_hz])
        || beyond(of_ends.map(|reach| reach[0]), edge_rate, [range.reach_hz[0], f64::INFINITY])
        || beyond(of_ends.map(|reach| reach[1]), edge_rate, [0.0, range.reach_hz[1]])
}
