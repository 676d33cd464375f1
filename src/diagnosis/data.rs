//! The measured table as the fits see it.

use crate::measured::ModeTable;
use crate::model::Conditions;

/// A row of the table.
#[derive(Debug, Clone)]
pub(super) struct Row {
    /// Joint positions, rad or m.
    pub(super) q: Vec<f64>,
    pub(super) conditions: Conditions,
    /// Known mass at the tip, kg.
    pub(super) payload_kg: f64,
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
}

impl Data {
    /// All rows of a table.
    pub(super) fn of(table: &ModeTable) -> Self {
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
        let rows = table
            .rows
            .iter()
            .enumerate()
            .map(|(index, row)| Row {
                q: row.joints.clone(),
                conditions: Conditions {
                    temperature_c: row.temperature_c,
                    amplitude_nm: row.amplitude_nm,
                },
                payload_kg: row.payload_kg.unwrap_or(0.0),
                sample_rate_hz: row.sample_rate_hz,
                index,
            })
            .collect();
        Self { rows, points, columns: table.modes }
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
        Self { rows, points, columns: self.columns }
    }
}

/// The middle value; `None` of nothing.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => None,
        _ if n % 2 == 1 => Some(values[n / 2]),
        _ => Some(0.5 * (values[n / 2 - 1] + values[n / 2])),
    }
}
