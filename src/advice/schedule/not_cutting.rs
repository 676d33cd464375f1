//! Where nothing cuts: the spindle stands, or the move is an air cut.

use super::task::Task;
use crate::process::is_air_cut;

/// Whether nothing cuts at `s`: the move is one in the air, or the spindle stands.
fn is_not_cutting(task: &Task, s: f64) -> bool {
    task.counting.spindle.is_stopped_at(s) || is_air_cut(task.operation, task.path, s)
}

/// Whether nothing cuts anywhere between two places.
pub(super) fn is_not_cutting_between(task: &Task, from_s: f64, to_s: f64) -> bool {
    let knots = task.path.knots_s();
    let inner = knots.partition_point(|s| *s <= from_s)..knots.partition_point(|s| *s < to_s);
    let inner = knots.get(inner).unwrap_or_default();
    let ends: Vec<f64> =
        std::iter::once(from_s).chain(inner.iter().copied()).chain([to_s]).collect();
    ends.windows(2).all(|end| is_not_cutting(task, 0.5 * (end[0] + end[1])))
}

/// Where the air begins and ends, ascending; of too many the ends of the longest stretches.
pub(super) fn air_cut_sides(task: &Task) -> Vec<f64> {
    let mut stretches: Vec<[f64; 2]> = Vec::new();
    for pair in task.path.knots_s().windows(2) {
        if pair[1] <= pair[0] || !is_not_cutting(task, 0.5 * (pair[0] + pair[1])) {
            continue;
        }
        match stretches.last_mut().filter(|last| last[1] == pair[0]) {
            Some(last) => last[1] = pair[1],
            None => stretches.push([pair[0], pair[1]]),
        }
    }
    stretches.sort_by(|a, b| (b[1] - b[0]).total_cmp(&(a[1] - a[0])));
    stretches.truncate(500 / 2);
    let mut places: Vec<f64> = stretches.into_iter().flatten().collect();
    places.sort_by(f64::total_cmp);
    places
}
