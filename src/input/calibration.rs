//! What a robot's file says of its corrections and its calibration beside what the model needs.

use crate::model::{Calibration, Correction};

/// A correction as the robot's file has it.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedCorrection {
    /// What the model takes.
    pub correction: Correction,
    /// 95 % interval of each parameter, by name.
    pub ci95: Vec<(String, [f64; 2])>,
    /// Digest of the table that it was fitted to; `None` for what was written by hand.
    pub table: Option<String>,
    /// Free text.
    pub note: Option<String>,
}

/// How a file names a table of measured modes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableName {
    /// File name without its folder.
    pub file: String,
    /// Digest of the numbers.
    pub digest: String,
}

/// A table that corrections were fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedTable {
    /// Its name.
    pub table: TableName,
    /// Its poses: joint positions from base to tip, rad or m.
    pub joints: Vec<Vec<f64>>,
}

/// What the calibration block says, but for the date.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationRecord {
    /// What the model takes.
    pub model: Calibration,
    /// The table that the error was measured with; older files name none.
    pub table: Option<TableName>,
    /// The tables that the corrections were fitted to.
    pub fitted_to: Vec<FittedTable>,
}
