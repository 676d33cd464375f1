//! Which modes of the records of a pose are one mode: by shape and frequency, one to one.

use super::record_modes::IdentifiedRecord;
use super::shapes::mac;
use crate::notes::Code;

/// Modes of two records within this relative distance of frequency are the same mode.
pub(super) const SAME_MODE: f64 = 0.012;

/// Where an arm was clamped again between records its frequencies scatter by some per cent: modes
/// within this distance are one where their shapes are alike by this modal assurance criterion.
const SAME_SHAPE_MODE: f64 = 0.05;
const ALIKE: f64 = 0.85;

/// Without shapes, modes within this distance are one as long as any other mode of both records is
/// so many times as far away.
const LONE_MODE: f64 = 0.03;
const FARTHER: f64 = 3.0;

/// Cost of a mode that no other record shows. A pair costs the square of its distance over
/// [`SAME_SHAPE_MODE`], so that modes that move together keep their order, and the share of the
/// shape that differs times [`OF_SHAPE`]: less than 1 within [`SAME_MODE`].
const ALONE: f64 = 1.0;
const OF_SHAPE: f64 = 0.9;

/// A mode: its record and its place there.
type Member = (usize, usize);

/// Modes of a group of records that belong together, at most one of each record.
pub(super) fn clusters(records: &[IdentifiedRecord], group: &[usize]) -> Vec<Vec<Member>> {
    let mut clusters: Vec<Vec<Member>> = Vec::new();
    for &record in group {
        let modes = records[record].modes.len();
        let own: Vec<f64> = (0..modes).map(|mode| log_hz(records, &(record, mode))).collect();
        let known: Vec<f64> = clusters.iter().map(|own| middle(records, own)).collect();
        let cost = |mode: usize, at: usize| {
            let apart = (own[mode] - known[at]).abs();
            let is_lone =
                apart < LONE_MODE && FARTHER * apart < nearest(&own, mode).min(nearest(&known, at));
            let likeness = likeness(records, &clusters[at], (record, mode));
            let is_one = apart < SAME_MODE
                || are_modes(records, &clusters[at], (record, mode))
                    && match likeness {
                        Some(likeness) => apart < SAME_SHAPE_MODE && likeness >= ALIKE,
                        None => is_lone,
                    };
            let unlike = 1.0 - likeness.unwrap_or(1.0);
            is_one.then(|| (apart / SAME_SHAPE_MODE).powi(2) + OF_SHAPE * unlike)
        };
        let pairs = paired(modes, clusters.len(), ALONE, cost);
        for (mode, pair) in pairs.into_iter().enumerate() {
            match pair {
                Some(at) => clusters[at].push((record, mode)),
                None => clusters.push(vec![(record, mode)]),
            }
        }
    }
    clusters
}

fn log_hz(records: &[IdentifiedRecord], &(record, mode): &Member) -> f64 {
    records[record].modes[mode].frequency_hz.max(f64::MIN_POSITIVE).ln()
}

fn middle(records: &[IdentifiedRecord], members: &[Member]) -> f64 {
    let sum: f64 = members.iter().map(|member| log_hz(records, member)).sum();
    sum / members.len().max(1) as f64
}

/// Distance of one of some frequencies to the next.
fn nearest(all: &[f64], at: usize) -> f64 {
    let others = all.iter().enumerate().filter(|(other, _)| *other != at);
    others.map(|(_, other)| (other - all[at]).abs()).fold(f64::INFINITY, f64::min)
}

/// How alike a mode is to those of a cluster that have responses in common with it, on average.
fn likeness(records: &[IdentifiedRecord], members: &[Member], own: Member) -> Option<f64> {
    let shape = |(record, mode): Member| &records[record].modes[mode].shape;
    let known: Vec<f64> =
        members.iter().filter_map(|&member| mac(shape(member), shape(own))).collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}

/// Whether none of some modes is a tone or an effect of another mode, whose frequency has nothing
/// to do with those of modes near it.
fn are_modes(records: &[IdentifiedRecord], members: &[Member], own: Member) -> bool {
    members.iter().chain([&own]).all(|&(record, mode)| {
        let code = records[record].modes[mode].suspicion;
        matches!(code, None | Some(Code::Unsettled | Code::Clipping))
    })
}

/// The pairs of `own` and `others`, each in one at most, that cost least in all, where leaving one
/// of `own` without costs `alone` and a pair without a cost is none: by successive shortest
/// augmenting paths (Kuhn, Naval Research Logistics Quarterly 2, 1955; Jonker & Volgenant,
/// Computing 38, 1987). By `own`, its partner.
pub(super) fn paired(
    own: usize,
    others: usize,
    alone: f64,
    cost: impl Fn(usize, usize) -> Option<f64>,
) -> Vec<Option<usize>> {
    // Column `others + k` leaves row k alone; what is no pair costs more than that.
    let columns = others + own;
    let of = |row: usize, column: usize| match column.checked_sub(others) {
        None => cost(row, column).unwrap_or(3.0 * alone),
        Some(k) if k == row => alone,
        Some(_) => 3.0 * alone,
    };
    let costs: Vec<Vec<f64>> =
        (0..own).map(|row| (0..columns).map(|column| of(row, column)).collect()).collect();
    let (mut of_row, mut of_column) = (vec![0.0; own], vec![0.0; columns]);
    let mut row_of: Vec<Option<usize>> = vec![None; columns];
    for first in 0..own {
        let mut least = vec![f64::INFINITY; columns];
        let mut before: Vec<Option<usize>> = vec![None; columns];
        let mut is_reached = vec![false; columns];
        let (mut row, mut from) = (first, None);
        // Each turn reaches one more column; a free one ends the path.
        let end = loop {
            for column in (0..columns).filter(|column| !is_reached[*column]) {
                let reduced = costs[row][column] - of_row[row] - of_column[column];
                if reduced < least[column] {
                    (least[column], before[column]) = (reduced, from);
                }
            }
            let open = (0..columns).filter(|column| !is_reached[*column]);
            let Some(next) = open.min_by(|&a, &b| least[a].total_cmp(&least[b])) else {
                break None;
            };
            let step = least[next];
            of_row[first] += step;
            for column in 0..columns {
                if is_reached[column] {
                    of_column[column] -= step;
                    row_of[column].into_iter().for_each(|row| of_row[row] += step);
                } else {
                    least[column] -= step;
                }
            }
            is_reached[next] = true;
            match row_of[next] {
                Some(other) => (row, from) = (other, Some(next)),
                None => break Some(next),
            }
        };
        let mut at = end;
        while let Some(column) = at {
            at = before[column];
            row_of[column] = at.map_or(Some(first), |before| row_of[before]);
        }
    }
    let mut pairs = vec![None; own];
    for (column, row) in row_of.into_iter().enumerate().take(others) {
        if let Some(row) = row.filter(|&row| cost(row, column).is_some()) {
            pairs[row] = Some(column);
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all ways, tried one by one.
    #[test]
    fn pairs_cost_least_of_all_ways() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / (1_u64 << 24) as f64
        };
        fn best(row: usize, costs: &[Vec<Option<f64>>], taken: &mut Vec<usize>) -> f64 {
            let Some(own) = costs.get(row) else { return 0.0 };
            let mut least = 1.0 + best(row + 1, costs, taken);
            for (column, cost) in own.iter().enumerate() {
                if let (Some(cost), false) = (cost, taken.contains(&column)) {
                    taken.push(column);
                    least = least.min(cost + best(row + 1, costs, taken));
                    taken.pop();
                }
            }
            least
        }
        for (own, others) in [(1, 1), (3, 2), (2, 4), (5, 5), (6, 5), (0, 3), (3, 0)] {
            for _ in 0..30 {
                let mut cell = || Some(1.3 * random()).filter(|_| random() < 0.7);
                let costs: Vec<Vec<Option<f64>>> =
                    (0..own).map(|_| (0..others).map(|_| cell()).collect()).collect();
                let pairs = paired(own, others, 1.0, |row, column| costs[row][column]);
                let mut seen: Vec<usize> = pairs.iter().copied().flatten().collect();
                seen.sort_unstable();
                seen.dedup();
                assert_eq!(seen.len(), pairs.iter().flatten().count());
                let of = |(row, pair): (usize, &Option<usize>)| {
                    pair.map_or(1.0, |column| costs[row][column].unwrap())
                };
                let sum: f64 = pairs.iter().enumerate().map(of).sum();
                let least = best(0, &costs, &mut Vec::new());
                assert!((sum - least).abs() < 1e-9, "{sum} {least} {costs:?} {pairs:?}");
            }
        }
    }
}
