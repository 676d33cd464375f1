//! The force of a cutter, whichever way it cuts.

use super::chip::linear_about;
use super::cutting::MillingForce;
use super::drilling::{DrillingForce, Lips};
use super::engagement::{Engagement, ForceHarmonic};
use super::material::coefficients;
use crate::job::{Cutting, CuttingCoefficients, Tool};

/// The force of one cutter in one cut.
#[derive(Debug, Clone, PartialEq)]
pub enum ForceModel {
    /// Of an end mill.
    Milling(MillingForce),
    /// Of a drill.
    Drilling(DrillingForce),
}

impl ForceModel {
    /// `None` where the material is not known and the job gives neither coefficients nor the thrust
    /// of a drill, or the cutter's diameter is wanted and missing; or a drill has unlike lips and
    /// nothing but its thrust is known.
    pub fn new(tool: &Tool, cutting: &Cutting) -> Option<Self> {
        match coefficients(cutting) {
            Some(coefficients) => Self::with(tool, cutting, coefficients),
            None => DrillingForce::new(tool, cutting.drill()?, None).map(Self::Drilling),
        }
    }

    /// The same with other coefficients than the cut's.
    pub fn with(tool: &Tool, cutting: &Cutting, coefficients: CuttingCoefficients) -> Option<Self> {
        match cutting.drill() {
            Some(drill) => DrillingForce::new(tool, drill, Some(coefficients)).map(Self::Drilling),
            None => MillingForce::with(tool, cutting, coefficients).map(Self::Milling),
        }
    }

    /// The mean of the force on the tool along the feed, across it and out of the work, N; of a
    /// drill along the axis alone. In milling it is zero along the axis where the axial
    /// coefficients are not known.
    pub fn mean_n(&self, feed_per_tooth_m: f64) -> [f64; 3] {
        match self {
            Self::Milling(force) => force.mean_n(feed_per_tooth_m),
            Self::Drilling(force) => [0.0, 0.0, force.thrust_n(feed_per_tooth_m)],
        }
    }

    /// The harmonics of some orders at a mean feed per tooth; order 0 is twice the mean.
    pub fn harmonics(&self, orders: &[u32], feed_per_tooth_m: f64) -> Vec<ForceHarmonic> {
        match self {
            Self::Milling(force) => force.harmonics(orders, feed_per_tooth_m),
            Self::Drilling(force) => force.harmonics(orders, feed_per_tooth_m),
        }
    }

    /// The force of a drill.
    pub fn drilling(&self) -> Option<&DrillingForce> {
        match self {
            Self::Milling(_) => None,
            Self::Drilling(force) => Some(force),
        }
    }

    #[cfg(test)]
    pub(crate) fn force_n(&self, turned_rad: f64, feed_per_tooth_m: f64) -> [f64; 3] {
        match self {
            Self::Milling(force) => force.force_n(turned_rad, feed_per_tooth_m),
            Self::Drilling(force) => [0.0, 0.0, force.thrust_n(feed_per_tooth_m)],
        }
    }
}

/// The coefficients of a cut, linear about its mean chip; `None` where they are not known, or the
/// cutter's diameter is wanted and missing.
pub fn linear_at(
    tool: &Tool,
    cutting: &Cutting,
    feed_per_tooth_m: f64,
) -> Option<CuttingCoefficients> {
    let chip_m = match cutting.drill() {
        Some(drill) => Lips::new(tool, drill)?.chip_m(feed_per_tooth_m),
        None => Engagement::new(cutting, tool.diameter_m)?.mean_chip_m(feed_per_tooth_m),
    };
    Some(linear_about(&coefficients(cutting)?, chip_m))
}
