//! The measured table as the fits see it.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::decorrelation::{Decorrelation, NoiseShape, Standing};
use crate::identify::{MeasuredRotation, ModeRow, ModeTable};
use crate::model::{Calibration, Conditions, Payload};
use crate::statistics::median;

/// Least number of states of which some may be left out.
pub(super) const MIN_STATES: usize = Calibration::MIN_POSES;

/// Least number of frequencies for a diagnosis.
pub(super) const MIN_POINTS: usize = 5;

/// Masses that were there during a measurement, against the robot's file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Load {
    /// On top of what the file carries, at the tip's origin, kg.
    pub(super) more_kg: f64,
    /// Share of the file's payload that was there.
    pub(super) share: f64,
    /// At the centres of mass of links, kg.
    pub(super) added_kg: Vec<(String, f64)>,
}

impl Load {
    /// As in the file.
    pub(super) const NOMINAL: Self = Self { more_kg: 0.0, share: 1.0, added_kg: Vec::new() };
}

/// A row of the table.
#[derive(Debug, Clone)]
pub(super) struct Row {
    /// Joint positions, rad or m.
    pub(super) q: Vec<f64>,
    pub(super) conditions: Conditions,
    pub(super) load: Load,
    pub(super) sample_rate_hz: Option<f64>,
    /// By column, how links turn in the mode.
    pub(super) rotations: Vec<Vec<MeasuredRotation>>,
    /// By column, the damping ratio.
    pub(super) damping: Vec<Option<f64>>,
    /// Place of the row in the table as it was given.
    pub(super) index: usize,
}

impl Row {
    pub(super) fn has_rotations(&self) -> bool {
        self.rotations.iter().any(|own| !own.is_empty())
    }
}

/// One measured frequency.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    /// Into [`Data::rows`].
    pub(super) row: usize,
    /// Column of the table, from 0.
    pub(super) column: usize,
    /// ln of the frequency in Hz.
    pub(super) ln_f: f64,
    /// Share of the common noise level that this one has, as the shape of the noise has it.
    pub(super) unit: f64,
    /// The same as the table states it: 1 unless it gives deviations.
    pub(super) stated: f64,
    /// Variance of ln f from rounding.
    pub(super) rounding: f64,
    /// Place among the points of the whole table.
    pub(super) index: usize,
}

/// Rows and measured frequencies.
#[derive(Debug, Clone)]
pub(super) struct Data {
    pub(super) rows: Vec<Row>,
    /// By row, then column.
    pub(super) points: Vec<Point>,
    pub(super) columns: usize,
    /// Typical standard deviation that the table states, share of the frequency.
    pub(super) stated_noise: Option<f64>,
    /// Place of the last row of the whole table.
    pub(super) order_of_last: usize,
    /// Joints that no frequency depends on.
    pub(super) inert: Vec<bool>,
    pub(super) shape: NoiseShape,
    /// What the shape makes of residuals.
    pub(super) decorrelation: Decorrelation,
}

impl Data {
    /// All rows of a table.
    pub(super) fn of(table: &ModeTable, payload: Option<&Payload>) -> Self {
        let quantum = table.quantum_hz();
        let shares: Vec<f64> = table
            .rows
            .iter()
            .flat_map(|row| row.frequencies_hz.iter().zip(&row.deviations_hz))
            .filter_map(|(f, deviation)| Some((*deviation)? / (*f)?))
            .collect();
        let typical = median(shares);
        let mut points = Vec::new();
        for (row, measured) in table.rows.iter().enumerate() {
            for (column, f) in measured.frequencies_hz.iter().enumerate() {
                let Some(f) = *f else { continue };
                let deviation = measured.deviations_hz.get(column).copied().flatten();
                let unit = match (deviation, typical) {
                    // A deviation a hundred times below the others is a slip, not a certainty.
                    (Some(deviation), Some(typical)) => (deviation / f / typical).clamp(0.2, 20.0),
                    _ => 1.0,
                };
                points.push(Point {
                    index: points.len(),
                    row,
                    column,
                    ln_f: f.ln(),
                    unit,
                    stated: unit,
                    rounding: (quantum / f).powi(2) / 12.0,
                });
            }
        }
        let load = loads(table, payload.map_or(0.0, |payload| payload.inertial.mass_kg));
        let rows = table
            .rows
            .iter()
            .enumerate()
            .map(|(index, row)| Row {
                q: row.pose.clone(),
                conditions: Conditions {
                    temperature_c: row.temperature_c,
                    amplitude_nm: row.amplitude_nm,
                },
                load: Load { added_kg: added(row), ..load(row.payload_kg) },
                sample_rate_hz: row.sample_rate_hz,
                rotations: row.rotations.clone(),
                damping: row.damping_ratios.clone(),
                index,
            })
            .collect();
        Self {
            order_of_last: table.rows.len().saturating_sub(1),
            rows,
            points,
            columns: table.modes,
            stated_noise: typical,
            inert: Vec::new(),
            shape: NoiseShape::plain(),
            decorrelation: Decorrelation::default(),
        }
    }

    /// A row at which `columns` modes will be measured.
    pub(super) fn at(row: Row, columns: usize) -> Self {
        let point = |column| Point {
            row: 0,
            column,
            ln_f: 0.0,
            unit: 1.0,
            stated: 1.0,
            rounding: 0.0,
            index: 0,
        };
        Self {
            rows: vec![row],
            points: (0..columns).map(point).collect(),
            columns,
            stated_noise: None,
            order_of_last: 0,
            inert: Vec::new(),
            shape: NoiseShape::plain(),
            decorrelation: Decorrelation::default(),
        }
    }

    /// The same with noise of another shape.
    pub(super) fn shaped(&self, shape: NoiseShape) -> Self {
        let mut data = self.clone();
        for point in &mut data.points {
            point.unit = point.stated * shape.scale(point.column);
        }
        let last = data.order_of_last.max(1) as f64;
        let standing = |point: &Point| Standing {
            row: point.row,
            order: 2.0 * data.rows[point.row].index as f64 / last - 1.0,
            unit: point.unit,
        };
        let standing: Vec<Standing> = data.points.iter().map(standing).collect();
        data.decorrelation = Decorrelation::of(&standing, &shape);
        data.shape = shape;
        data
    }

    /// For each row which state it tests, counted from 0: rows of one pose under the same
    /// conditions test one, wherever joints stand that no frequency depends on.
    pub(super) fn tests(&self) -> Vec<usize> {
        let mut first_rows: Vec<&Row> = Vec::new();
        let test_of = |row: &'_ Row, first_rows: &mut Vec<&Row>| {
            let same = |other: &&Row| {
                let moves = |(joint, (a, b)): (usize, (&f64, &f64))| {
                    a != b && !self.inert.get(joint).copied().unwrap_or(false)
                };
                !other.q.iter().zip(&row.q).enumerate().any(moves)
                    && other.conditions == row.conditions
                    && other.load == row.load
            };
            first_rows.iter().position(same)
        };
        self.rows
            .iter()
            .map(|row| {
                test_of(row, &mut first_rows).unwrap_or_else(|| {
                    first_rows.push(row);
                    first_rows.len() - 1
                })
            })
            .collect()
    }

    /// Standard deviation of repeated tests, share of the frequency; `None` if too few are.
    pub(super) fn repeatability(&self) -> Option<f64> {
        /// Degrees of freedom that make it known.
        const ENOUGH: usize = 5;
        let tests = self.tests();
        let (mut square, mut freedom) = (0.0, 0);
        for test in 0..self.test_count() {
            for column in 0..self.columns {
                let own = self.points.iter().filter(|p| p.column == column && tests[p.row] == test);
                let own: Vec<f64> = own.map(|point| point.ln_f).collect();
                let mean = own.iter().sum::<f64>() / own.len().max(1) as f64;
                square += own.iter().map(|f| (f - mean).powi(2)).sum::<f64>();
                freedom += own.len().saturating_sub(1);
            }
        }
        (freedom >= ENOUGH).then(|| (square / freedom as f64).sqrt())
    }

    /// Number of tests, see [`Data::tests`].
    pub(super) fn test_count(&self) -> usize {
        self.tests().into_iter().max().map_or(0, |last| last + 1)
    }

    /// So many states of a large table that causes can be told apart by them, at random; `None`
    /// where the table is no larger.
    pub(super) fn thinned(&self) -> Option<Self> {
        /// Of 150 poses with four modes each an effect as large as the noise is known to a tenth.
        const ENOUGH: usize = 600;
        if self.points.len() <= ENOUGH + ENOUGH / 4 {
            return None;
        }
        let tests = self.tests();
        let mut order: Vec<usize> = (0..self.test_count()).collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(1));
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &test)| rank[test] = place);
        let kept = ENOUGH * rank.len() / self.points.len();
        Some(self.only(|row| rank[tests[row]] < kept.max(MIN_STATES)))
    }

    /// The joint that alone moves by more than `still`, rad or m, over the table, under one load;
    /// `None` if it is not just one.
    pub(super) fn swept_joint(&self, still: f64) -> Option<usize> {
        let (first, others) = self.rows.split_first()?;
        let moves = |joint: &usize| {
            others.iter().any(|row| (row.q[*joint] - first.q[*joint]).abs() > still)
        };
        let mut moved = (0..first.q.len()).filter(moves);
        let (joint, None) = (moved.next()?, moved.next()) else { return None };
        others.iter().all(|row| row.load == first.load).then_some(joint)
    }

    /// The rows for which `keep` holds; points remember their place in the whole table.
    pub(super) fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        let mut place = vec![None; self.rows.len()];
        let mut rows = Vec::new();
        for (i, row) in self.rows.iter().enumerate().filter(|(i, _)| keep(*i)) {
            place[i] = Some(rows.len());
            rows.push(row.clone());
        }
        let points = self
            .points
            .iter()
            .filter_map(|point| Some(Point { row: place[point.row]?, ..*point }))
            .collect();
        let kept = Self {
            rows,
            points,
            columns: self.columns,
            stated_noise: self.stated_noise,
            order_of_last: self.order_of_last,
            inert: self.inert.clone(),
            decorrelation: Decorrelation::default(),
            shape: NoiseShape::plain(),
        };
        kept.shaped(self.shape.clone())
    }
}

/// The masses that are there, by link.
fn added(row: &ModeRow) -> Vec<(String, f64)> {
    let mut added: Vec<_> = row.added_kg.iter().filter(|(_, kg)| *kg > 0.0).cloned().collect();
    added.sort_by(|a, b| a.0.cmp(&b.0));
    added
}

/// What a cell of `payload_kg` means where the robot's file carries `own_kg`: it counts the file's
/// payload in if some row has just that, and comes on top of it otherwise.
fn loads(table: &ModeTable, own_kg: f64) -> impl Fn(Option<f64>) -> Load + use<> {
    /// Cells are rounded.
    const SAME: f64 = 0.02;
    let is_own = move |kg: f64| own_kg > 0.0 && (kg / own_kg - 1.0).abs() < SAME;
    let counts_own = table.rows.iter().filter_map(|row| row.payload_kg).any(is_own);
    move |cell| match cell {
        None => Load::NOMINAL,
        Some(kg) if is_own(kg) => Load::NOMINAL,
        Some(kg) if counts_own => Load { share: kg / own_kg, ..Load::NOMINAL },
        Some(kg) => Load { more_kg: kg, ..Load::NOMINAL },
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::tests::data;

    #[test]
    fn a_joint_is_swept_where_nothing_else_changes() {
        let mut table = data(4);
        table.rows.iter_mut().for_each(|row| (row.q[0], row.q[2]) = (0.5, -0.5));
        table.rows[3].q[1] += 1.0;
        assert_eq!(table.swept_joint(0.0), Some(1));
        let mut other = table.clone();
        other.rows[2].q[2] += 0.1;
        assert_eq!(other.swept_joint(0.05), None);
        assert_eq!(other.swept_joint(0.2), Some(1));
        let mut loaded = table.clone();
        loaded.rows[2].load.more_kg = 5.0;
        assert_eq!(loaded.swept_joint(0.0), None);
        table.rows.truncate(1);
        assert_eq!(table.swept_joint(0.0), None);
    }
}
