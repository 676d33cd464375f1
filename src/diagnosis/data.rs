//! The measured table as the fits see it.

use crate::identify::ModeTable;
use crate::model::{Conditions, Payload};
use crate::statistics::median;

/// Least number of poses for a diagnosis.
pub(super) const MIN_POSES: usize = 5;

/// Least number of frequencies for a diagnosis.
pub(super) const MIN_POINTS: usize = 8;

/// Belief mass at the tip during a measurement, against the robot's file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Load {
    /// On top of what the file carries, at the tip's origin, kg.
    pub(super) more_kg: f64,
    /// Share of the file's payload that was there.
    pub(super) share: f64,
}

impl Load {
    /// As in the file.
    pub(super) const NOMINAL: Self = Self { more_kg: 0.0, share: 1.0 };
}

/// A row of the table.
#[derive(Debug, Clone)]
pub(super) struct Row {
    /// Joint positions, rad or m.
    pub(super) q: Vec<f64>,
    pub(super) conditions: Conditions,
    pub(super) load: Load,
    pub(super) sample_rate_hz: Option<f64>,
    /// Place of the row in the table as it was given.
    pub(super) index: usize,
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
    /// Share of the common noise level that this one has: 1 unless the table gives deviations.
    pub(super) unit: f64,
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
                load: load(row.payload_kg),
                sample_rate_hz: row.sample_rate_hz,
                index,
            })
            .collect();
        Self { rows, points, columns: table.modes, stated_noise: typical }
    }

    /// For each row which test it belongs to, counted from 0: rows of one pose under the same
    /// conditions repeat one.
    pub(super) fn tests(&self) -> Vec<usize> {
        let mut first_rows: Vec<&Row> = Vec::new();
        let test_of = |row: &'_ Row, first_rows: &mut Vec<&Row>| {
            let same = |other: &&Row| {
                other.q == row.q && other.conditions == row.conditions && other.load == row.load
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

    /// Number of tests, see [`Data::tests`].
    pub(super) fn test_count(&self) -> usize {
        self.tests().into_iter().max().map_or(0, |last| last + 1)
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
        Self { rows, points, columns: self.columns, stated_noise: self.stated_noise }
    }
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
        Some(kg) if counts_own => Load { more_kg: 0.0, share: kg / own_kg },
        Some(kg) => Load { more_kg: kg, share: 1.0 },
    }
}
