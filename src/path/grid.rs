//! Where a path is looked at before anything is known about it.
//!
//! # What cannot hide
//! Stations are at most [`MAX_GAP`] apart in s, so anything wider than that holds a station:
//! this bound rests on nothing but counting. All waypoints are stations, and no joint moves more
//! than [`MAX_STEP`] between two, so that frequencies are smooth from one to the next. From there
//! [`super::Survey::refine`] goes on wherever a band's edge is within reach of the steepest slope
//! seen nearby (twice that, to be safe), which finds the touch of a band's edge down to a millionth
//! of the path. (Gaps between ignored bands under a changing spindle speed have the first bound
//! only.)

use super::timed_path::Path;
use crate::units::rad_from_deg;

/// Largest distance between stations, as a share of the operation's time: half of 0.1 %.
pub const MAX_GAP: f64 = 5e-4;

/// Largest motion of any joint between stations, rad (one degree) or m.
pub const MAX_STEP: f64 = rad_from_deg(1.0);

/// Stations for a first look at `path`: both ends, all knots, all `corners` (values of s where
/// something else than the arm has a corner), and enough between them. Ascending, without repeats.
pub fn grid(path: &Path, corners: impl Iterator<Item = f64>) -> Vec<f64> {
    let knots = path.knots_s();
    let mut stations = Vec::with_capacity(knots.len() + (1.0 / MAX_GAP) as usize);
    for (k, pair) in knots.windows(2).enumerate() {
        let width = pair[1] - pair[0];
        let pieces = (width / MAX_GAP).max(path.step_after(k) / MAX_STEP).ceil().max(1.0);
        stations.extend((0..pieces as usize).map(|i| pair[0] + width * (i as f64 / pieces)));
    }
    // An operation in which nothing moves has one knot, yet its spindle may change speed.
    if knots.len() < 2 {
        let pieces = (1.0 / MAX_GAP).ceil();
        stations.extend((0..pieces as usize).map(|i| i as f64 / pieces));
    }
    stations.push(1.0);
    stations.extend(corners.filter(|s| (0.0..=1.0).contains(s)));
    stations.sort_by(f64::total_cmp);
    stations.dedup();
    stations
}
