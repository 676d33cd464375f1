//! Mode shapes as evidence: how links turn in a measured mode against how they turn in the model's.
//! A measured shape has an unknown size, so the size that fits best is taken out of it. Where a row
//! has shapes, its modes are paired with the model's by them and by the frequencies; else by their
//! rank.

use super::data::{Data, Row};
use super::likelihood::NOISE_FREEDOM;
use super::predict::Frequency;
use crate::identify::MeasuredRotation;

/// Standard deviation of a rotation that the table does not state, share of the largest of its
/// mode.
const DEVIATION: f64 = 0.05;

/// No shape is known better.
const MIN_DEVIATION: f64 = 0.01;

/// How far a model may be off in ln of the frequency while modes are paired.
const FREQUENCY_ERROR: f64 = 0.1;

/// What it costs of log evidence to pair other than by rank.
const OUT_OF_RANK: f64 = 4.0;

/// A measured rotation against the model's, over its deviation.
#[derive(Debug, Clone)]
pub(super) struct ShapeTerm {
    pub(super) residual: f64,
    /// Weight of Student's t, as that of frequencies.
    pub(super) weight: f64,
    /// Derivative of what is predicted by each parameter.
    pub(super) slope: Vec<f64>,
}

/// Rotations of a mode with their deviations, and where they stand among the rotations of their
/// row.
struct Measured<'r> {
    own: &'r [MeasuredRotation],
    first: usize,
    deviations: Vec<f64>,
}

/// The modes of a row of which enough links are known to have a shape, with their columns.
fn measured(row: &Row) -> impl Iterator<Item = (usize, Measured<'_>)> {
    let mut first = 0;
    row.rotations.iter().enumerate().filter_map(move |(column, own)| {
        let start = first;
        first += own.len();
        let most = own.iter().map(|r| r.value.abs()).fold(0.0, f64::max);
        (own.len() > 1 && most > 0.0).then(|| {
            let deviation = |r: &MeasuredRotation| {
                r.std.map_or(DEVIATION * most, |std| std.max(MIN_DEVIATION * most))
            };
            (
                column,
                Measured { own, first: start, deviations: own.iter().map(deviation).collect() },
            )
        })
    })
}

impl Measured<'_> {
    /// What the model's mode leaves, over the deviations; the predicted shape likewise, and the
    /// size that fits.
    fn compared(&self, predicted: &Frequency) -> (Vec<f64>, Vec<f64>, f64) {
        let place = self.first..self.first + self.own.len();
        let over = |values: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            values.zip(&self.deviations).map(|(value, deviation)| value / deviation).collect()
        };
        let shape = over(&mut predicted.rotations[place].iter().copied());
        let seen = over(&mut self.own.iter().map(|rotation| rotation.value));
        let square = shape.iter().map(|s| s * s).sum::<f64>().max(f64::MIN_POSITIVE);
        let size = shape.iter().zip(&seen).map(|(s, m)| s * m).sum::<f64>() / square;
        let left = seen.iter().zip(&shape).map(|(m, s)| m - size * s).collect();
        (left, shape, size)
    }

    fn cost(&self, predicted: &Frequency) -> f64 {
        self.compared(predicted).0.iter().map(|z| cost(*z)).sum()
    }
}

/// −ln of Student's t, without constants.
fn cost(z: f64) -> f64 {
    0.5 * (NOISE_FREEDOM + 1.0) * (z * z / NOISE_FREEDOM).ln_1p()
}

/// Puts the model's modes of each row into the columns to which shapes say they belong; the rows
/// where that is not their rank.
pub(super) fn paired(data: &Data, rows: &mut [Vec<Frequency>]) -> Vec<usize> {
    let mut out_of_rank = Vec::new();
    for (i, (row, modes)) in data.rows.iter().zip(rows).enumerate() {
        if measured(row).next().is_none() {
            continue;
        }
        let points = || data.points.iter().filter(|point| point.row == i);
        let cost_of = |order: &[usize]| -> f64 {
            let mode = |column: usize| order.get(column).and_then(|&r| modes.get(r));
            let of_frequencies = points().filter_map(|point| {
                Some(cost((point.ln_f - mode(point.column)?.ln_hz) / FREQUENCY_ERROR))
            });
            let of_shapes =
                measured(row).filter_map(|(column, shape)| Some(shape.cost(mode(column)?)));
            of_frequencies.sum::<f64>() + of_shapes.sum::<f64>()
        };
        let by_rank: Vec<usize> = (0..modes.len()).collect();
        let columns = row.rotations.len().min(modes.len());
        let mut best = (cost_of(&by_rank) - OUT_OF_RANK, by_rank.clone());
        for k in 0..columns {
            let mut missed = by_rank.clone();
            missed.remove(k);
            let exchanged = (k + 1 < modes.len()).then(|| {
                let mut exchanged = by_rank.clone();
                exchanged.swap(k, k + 1);
                exchanged
            });
            // A mode that the table may have missed must leave one for each of its columns.
            let missed = (missed.len() >= columns).then_some(missed);
            for order in exchanged.into_iter().chain(missed) {
                let cost = cost_of(&order);
                if cost < best.0 {
                    best = (cost, order);
                }
            }
        }
        if best.1 != by_rank {
            *modes = best.1.iter().map(|&r| modes[r].clone()).collect();
            out_of_rank.push(i);
        }
    }
    out_of_rank
}

/// All rotations against the model's, paired, with ln of their likelihood.
pub(super) fn terms(data: &Data, rows: &[Vec<Frequency>]) -> (Vec<ShapeTerm>, f64) {
    let mut terms = Vec::new();
    let mut ln_likelihood = 0.0;
    for (row, modes) in data.rows.iter().zip(rows) {
        for (column, own) in measured(row) {
            let Some(predicted) = modes.get(column) else { continue };
            let (left, shape, size) = own.compared(predicted);
            let square = shape.iter().map(|s| s * s).sum::<f64>().max(f64::MIN_POSITIVE);
            // Size and slopes but for what a change of size makes up for.
            let slopes: Vec<Vec<f64>> = predicted
                .rotation_slopes
                .iter()
                .map(|slopes| {
                    let moved: Vec<f64> = own
                        .deviations
                        .iter()
                        .zip(&slopes[own.first..])
                        .map(|(deviation, slope)| size * slope / deviation)
                        .collect();
                    let along: f64 =
                        moved.iter().zip(&shape).map(|(m, s)| m * s).sum::<f64>() / square;
                    moved.iter().zip(&shape).map(|(m, s)| m - along * s).collect()
                })
                .collect();
            for (k, residual) in left.into_iter().enumerate() {
                ln_likelihood -= cost(residual);
                terms.push(ShapeTerm {
                    residual,
                    weight: (NOISE_FREEDOM + 1.0) / (NOISE_FREEDOM + residual * residual),
                    slope: slopes.iter().map(|slopes| slopes[k]).collect(),
                });
            }
        }
    }
    (terms, ln_likelihood)
}

#[cfg(test)]
mod tests {
    use super::super::candidate::{Candidate, Parameter, Scale};
    use super::super::fit::tests::{arm, data};
    use super::super::hypothesis::Hypothesis;
    use super::super::predict::predict;
    use super::super::problem::Problem;
    use super::*;
    use crate::identify::RotationAxis;
    use crate::model::Cause;

    /// A table whose shapes and frequencies are those of a hypothesis, in any size.
    fn shown(hypothesis: &Hypothesis<'_>) -> Data {
        let mut data = data(3);
        let rotation = |link: usize| MeasuredRotation {
            link: format!("l{link}"),
            about: if link == 2 { RotationAxis::Base(1) } else { RotationAxis::Joint },
            value: 1.0,
            std: None,
        };
        for row in &mut data.rows {
            row.rotations = vec![(1..=3).map(rotation).collect(); 3];
        }
        let modes = predict(&arm(), hypothesis, &data).unwrap();
        for (row, modes) in data.rows.iter_mut().zip(&modes) {
            for (column, own) in row.rotations.iter_mut().enumerate() {
                let values = &modes[column].rotations[3 * column..];
                own.iter_mut().zip(values).for_each(|(own, value)| own.value = -2.5 * value);
            }
        }
        for point in &mut data.points {
            point.ln_f = modes[point.row][point.column].ln_hz;
        }
        data
    }

    fn candidate(cause: Cause, at: &str, name: &'static str, scale: Scale) -> Candidate {
        let bounds = [-1e9, 1e9];
        let parameter =
            Parameter { name, scale, nominal: None, bounds, starts: vec![], expected: None };
        Candidate::new(cause, at, vec![parameter])
    }

    #[test]
    fn slopes_of_shapes_are_the_differences_of_solved_shapes() {
        let kg = Scale::Linear(1.0);
        for (candidate, inner) in [
            (candidate(Cause::JointStiffness, "j2", "stiffness_nm_per_rad", Scale::Log), 11.0),
            (candidate(Cause::LinkInertia, "l2", "inertia_factor", Scale::Log), 0.4),
            (candidate(Cause::Payload, "l3", "mass_kg", kg), 6.0),
        ] {
            let at = |inner: f64| Hypothesis { effects: vec![(&candidate, vec![inner])] };
            let data = shown(&at(inner));
            let problem = Problem { description: &arm(), data: &data };
            let shapes = |inner: f64| problem.evaluate(&at(inner)).unwrap().left.shapes;
            let [below, here, above] = [-1e-5, 0.0, 1e-5].map(|by| shapes(inner + by));
            assert_eq!(here.len(), 27);
            for ((below, here), above) in below.iter().zip(&here).zip(&above) {
                assert!(here.residual.abs() < 1e-9);
                let difference = (below.residual - above.residual) / 2e-5;
                let error = (here.slope[0] - difference).abs();
                let slope = here.slope[0];
                assert!(error < 1e-5 + 1e-4 * difference.abs(), "{slope} {difference}");
            }
        }
    }

    #[test]
    fn modes_go_by_their_shapes_where_a_row_has_them() {
        let mut data = shown(&Hypothesis::default());
        let modes = predict(&arm(), &Hypothesis::default(), &data).unwrap();
        assert!(paired(&data, &mut modes.clone()).is_empty());
        // In the second row the first mode was missed, and the next two moved up.
        data.rows[1].rotations.remove(0);
        data.points.retain(|point| point.row != 1 || point.column < 2);
        for point in data.points.iter_mut().filter(|point| point.row == 1) {
            point.ln_f = modes[1][point.column + 1].ln_hz;
        }
        let mut by_shape = modes.clone();
        assert_eq!(paired(&data, &mut by_shape), [1]);
        assert_eq!(by_shape[1][0].ln_hz, modes[1][1].ln_hz);
        // In the third the first two are exchanged.
        data.rows[2].rotations.swap(0, 1);
        assert_eq!(paired(&data, &mut modes.clone()), [1, 2]);
    }
}
