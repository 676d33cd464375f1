//! Slot tests → cutting coefficients.

use std::path::Path;

use super::Read;
pub use crate::identify::cutting::{Coefficient, CuttingFit, Direction, SlotTest};
use crate::identify::cutting::{CuttingFault, fit_slots};
use crate::input::read_slots;
use crate::notes::{Code, Note, Place};

/// Reads the table of slot tests.
pub fn read(file: &Path) -> Read<Vec<SlotTest>> {
    Read::of(|reading| read_slots(file, reading))
}

/// Fits the coefficients.
///
/// # Errors
/// Too few slots, or forces that no cut has.
pub fn cutting(file: &Path, slots: &[SlotTest]) -> Result<CuttingFit, Vec<Note>> {
    fit_slots(slots).map_err(|fault| {
        let code = match fault {
            CuttingFault::NotPositive(..)
            | CuttingFault::Implausible(_)
            | CuttingFault::NotFinite => Code::Value,
            _ => Code::TooLittleData,
        };
        vec![Note::error(code, Place::file(file), fault.to_string())]
    })
}
