//! Natural frequencies over poses: from a table, a grid or random poses, block by block, linear or
//! nonlinear.

mod sketch;
mod source;
mod stream;
mod summary;

pub use sketch::{Merged, Part, Sketch, Started, merge};
pub use source::{Positions, Request, Source, Unit};
pub use stream::{MapError, Render, Target, run};
pub use summary::{Summary, outside_warning};

use std::path::Path;

use super::Read;
pub use crate::free_vibration::Sampling;
use crate::free_vibration::Settings;
use crate::input;
pub use crate::map::{Block, FrequencyMap, Head, Method, Reduction, Statistic};
pub use crate::model::Robot;
use crate::modes::batch::InstructionSet;
use crate::notes::{Code, Note, Place};
use crate::units::rad_from_deg;

/// Springs that turn farther than this have failed, degrees.
const MAX_AMPLITUDE_DEG: f64 = 90.0;

/// Reads a robot.yaml and its URDF.
pub fn read_robot(file: &Path) -> Read<Robot> {
    Read::of(|reading| input::read_robot(file, reading))
}

/// The nonlinear method with the defaults where nothing is given: the largest deflection of any
/// turning spring in degrees, and how the vibration is sampled.
///
/// # Errors
/// An amplitude that is not above 0 and at most 90 degrees.
pub fn nonlinear(amplitude_deg: Option<f64>, sampling: Sampling) -> Result<Method, Note> {
    let settings = Settings { sampling, ..Settings::default() };
    let Some(amplitude) = amplitude_deg else { return Ok(Method::Nonlinear(settings)) };
    if !(amplitude > 0.0 && amplitude <= MAX_AMPLITUDE_DEG) {
        let what = format!(
            "the amplitude is {amplitude} degrees, must be above 0 and at most {MAX_AMPLITUDE_DEG}"
        );
        return Err(wrong("amplitude-deg", what));
    }
    Ok(Method::Nonlinear(Settings { amplitude_rad: rad_from_deg(amplitude), ..settings }))
}

/// The machine's vector instructions that maps are computed with; the last digits of frequencies
/// may differ between them.
pub fn instructions() -> &'static str {
    match InstructionSet::available().last() {
        Some(InstructionSet::Avx512) => "avx512",
        Some(InstructionSet::Avx2) => "avx2",
        _ => "baseline",
    }
}

/// An error of the request, at one of its keys.
fn wrong(key: &'static str, what: impl Into<String>) -> Note {
    Note::error(Code::Usage, Place { key, ..Place::default() }, what)
}
