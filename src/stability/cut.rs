//! A cutter in a cut: what its teeth feel of the tip's motion.

use std::f64::consts::TAU;

use nalgebra::{Matrix3x2, Vector3};

use super::limit::LimitOf;
use super::mode::ToolMode;
use crate::excitation::{Engagement, Lips, coefficients};
use crate::job::{Cutting, CuttingCoefficients, CuttingDirection, Tool};

/// Below this share of the diameter in the cut, the zeroth order knows no flips that bound the
/// depth, and may be wrong by its double.
const NARROW: f64 = 0.25;

/// Of usual cuts the exact limit is above this share of that of the zeroth order.
const USUAL_SHARE: f64 = 0.9;

/// Whether the exact limit is further below that of the zeroth order than is usual.
pub fn is_misled(zeroth_m: f64, exact_m: f64) -> bool {
    exact_m < USUAL_SHARE * zeroth_m
}

/// Whether a cut is too narrow for the zeroth order.
pub fn is_narrow(tool: &Tool, cutting: &Cutting) -> bool {
    let share = tool.diameter_m.map(|diameter| cutting.radial_depth_m / diameter);
    match cutting.direction {
        CuttingDirection::Climb | CuttingDirection::Conventional => {
            share.is_some_and(|share| share < NARROW)
        }
        CuttingDirection::Slot | CuttingDirection::Drill(_) => false,
    }
}

/// A cutter in a cut, without its depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// Where a tooth is in the work.
    pub engagement: Engagement,
    /// Angle from each tooth to the next, rad, adding up to one turn.
    pub pitch_rad: Vec<f64>,
    /// K_tc, K_rc and K_ac: what the force grows by with the chip's section, N/m².
    pub coefficients_n_per_m2: [f64; 3],
    /// By how much an edge lags behind the tip of its tooth, per height above it, rad/m: 2 tan β/D.
    pub lag_rad_per_m: f64,
    /// Of a drill: what the thrust of a lip grows by with how far the tip moves along the axis, per
    /// width of cut, N/m². A drill feels nothing of the rest.
    pub lip_n_per_m2: Option<f64>,
    /// Process damping 2 C / D, over the spindle's angular speed what a force per depth grows by
    /// with the speed of the tip normal to the surface, N/m².
    pub rubbing_n_per_m2: f64,
}

impl Cut {
    /// `None` where the material is not known and the cut has no coefficients, or the cutter's
    /// diameter is missing, or the coefficients have exponents ([`crate::excitation::linear_about`]
    /// takes them away). An axial coefficient that nobody knows counts as zero.
    pub fn new(tool: &Tool, cutting: &Cutting) -> Option<Self> {
        let own = coefficients(cutting).filter(CuttingCoefficients::is_linear)?;
        let even = || vec![TAU / f64::from(tool.teeth); tool.teeth as usize];
        let pitch_rad = tool.pitch_rad.clone().unwrap_or_else(even);
        let coefficients_n_per_m2 = own.cutting_n_per_m2();
        if let Some(drill) = cutting.drill() {
            return Some(Self {
                engagement: Engagement { entry_rad: 0.0, exit_rad: TAU },
                pitch_rad,
                coefficients_n_per_m2,
                lag_rad_per_m: 0.0,
                lip_n_per_m2: Some(Lips::new(tool, drill)?.stiffness_n_per_m2(&own)),
                rubbing_n_per_m2: 0.0,
            });
        }
        let lag_rad_per_m = match tool.helix_rad.tan() {
            0.0 => 0.0,
            slope => 2.0 * slope / tool.diameter_m?,
        };
        Some(Self {
            engagement: Engagement::new(cutting, tool.diameter_m)?,
            pitch_rad,
            coefficients_n_per_m2,
            lag_rad_per_m,
            lip_n_per_m2: None,
            rubbing_n_per_m2: match cutting.process_damping_n_per_m {
                0.0 => 0.0,
                damping => 2.0 * damping / tool.diameter_m?,
            },
        })
    }

    /// Whether the flank rubs.
    pub fn is_damped(&self) -> bool {
        self.rubbing_n_per_m2 > 0.0
    }

    /// What its limit bounds.
    pub fn limit_of(&self) -> LimitOf {
        match self.lip_n_per_m2 {
            Some(_) => LimitOf::WidthOfCut,
            None => LimitOf::AxialDepth,
        }
    }

    /// Modes in the axes in which the force is told: those of the tool's frame, for a drill z, x
    /// and y of it, as the chip feels the first two alone.
    pub fn in_axes(&self, modes: &[ToolMode]) -> Vec<ToolMode> {
        let turned = |mode: &ToolMode| match self.lip_n_per_m2 {
            Some(_) => {
                let [x, y, z] = mode.motion.into();
                ToolMode { motion: Vector3::new(z, x, y), ..*mode }
            }
            None => *mode,
        };
        modes.iter().map(turned).collect()
    }

    /// The force of a lip per width of cut for how far the tip moves along the axis.
    fn of_lip(lip_n_per_m2: f64) -> Matrix3x2<f64> {
        let mut force = Matrix3x2::zeros();
        force[(0, 0)] = -lip_n_per_m2;
        force
    }

    /// A depth below which nothing grows, as the force for any motion is smaller than what holds
    /// the modes: 1 / (2 N |K| Σ |φ|² / (2 ζ ω²)), with N teeth, m. Process damping, which only
    /// holds, is left out.
    pub(super) fn surely_stable_m(&self, modes: &[ToolMode]) -> f64 {
        let [tangential, radial, axial] = self.coefficients_n_per_m2;
        let force = self.pitch_rad.len() as f64 * tangential.hypot(radial).hypot(axial);
        let moved = |mode: &ToolMode| {
            let stiffness = 2.0 * mode.damping_ratio * mode.omega_rad_per_s.powi(2);
            mode.motion.norm_squared() / stiffness
        };
        1.0 / (2.0 * force * modes.iter().map(moved).sum::<f64>())
    }

    /// One pitch if all are equal.
    pub fn even_pitch_rad(&self) -> Option<f64> {
        let first = *self.pitch_rad.first()?;
        let is_equal = |pitch: &f64| (pitch - first).abs() < 1e-9;
        self.pitch_rad.iter().all(is_equal).then(|| TAU / self.pitch_rad.len() as f64)
    }

    /// Angle of each tooth's tip when the first is at zero, rad.
    pub fn angles_rad(&self) -> impl Iterator<Item = f64> + '_ {
        self.pitch_rad.iter().scan(0.0, |angle, pitch| {
            let here = *angle;
            *angle += pitch;
            Some(here)
        })
    }

    /// ∫ H dφ up to an angle: force on the tool in x, y and z for a displacement along x and y, of
    /// a tooth that takes a chip Δx sin φ + Δy cos φ thick, N/m².
    fn integral(&self, phi: f64) -> Matrix3x2<f64> {
        let (sin, cos) = phi.sin_cos();
        self.of_products(integrals(phi), [-cos, sin])
    }

    /// H of one tooth at an angle, as if it were in the cut.
    fn at(&self, phi: f64) -> Matrix3x2<f64> {
        let (sin, cos) = phi.sin_cos();
        self.of_products([sin * sin, sin * cos, cos * cos], [sin, cos])
    }

    fn of_products(
        &self,
        [sin_sin, sin_cos, cos_cos]: [f64; 3],
        [sin, cos]: [f64; 2],
    ) -> Matrix3x2<f64> {
        let [t, r, a] = self.coefficients_n_per_m2;
        Matrix3x2::new(
            -t * sin_cos - r * sin_sin,
            -t * cos_cos - r * sin_cos,
            t * sin_sin - r * sin_cos,
            t * sin_cos - r * cos_cos,
            -a * sin,
            -a * cos,
        )
    }

    /// The force against a rate along the direction of the chip, of products of sine and cosine.
    fn rubbing(&self, [sin_sin, sin_cos, cos_cos]: [f64; 3]) -> Matrix3x2<f64> {
        let of_products = Matrix3x2::new(sin_sin, sin_cos, sin_cos, cos_cos, 0.0, 0.0);
        of_products * -self.rubbing_n_per_m2
    }

    /// The mean of what rubs over a turn, of all teeth, per depth and over the spindle's angular
    /// speed: the force for a rate of the tip, N/m².
    pub fn mean_rubbing(&self) -> Matrix3x2<f64> {
        let Engagement { entry_rad, exit_rad } = self.engagement;
        let teeth = self.pitch_rad.len() as f64;
        let (from, to) = (integrals(entry_rad), integrals(exit_rad));
        self.rubbing([0, 1, 2].map(|i| (to[i] - from[i]) * teeth / TAU))
    }

    /// What rubs at one tooth, its tip at `phi`, over the spindle's angular speed, N/m; `None`
    /// where it is not in the cut.
    pub fn rubbing_n_per_m(&self, phi: f64, depth_m: f64) -> Option<Matrix3x2<f64>> {
        if self.lip_n_per_m2.is_some() {
            return None;
        }
        let at = |phi: f64| {
            let (sin, cos) = phi.sin_cos();
            self.rubbing([sin * sin, sin * cos, cos * cos])
        };
        self.over_edge(phi, depth_m, at, |phi| self.rubbing(integrals(phi)))
    }

    /// The mean of H over a turn, of all teeth, per depth, in the axes of [`Self::in_axes`], N/m².
    pub fn mean(&self) -> Matrix3x2<f64> {
        let Engagement { entry_rad, exit_rad } = self.engagement;
        let teeth = self.pitch_rad.len() as f64;
        if let Some(lip) = self.lip_n_per_m2 {
            return Self::of_lip(lip) * teeth;
        }
        (self.integral(exit_rad) - self.integral(entry_rad)) * (teeth / TAU)
    }

    /// Force of one tooth, its tip at `phi`, for a displacement of the tip of the tool, N/m, in the
    /// axes of [`Self::in_axes`]; `None`
    /// where it is not in the cut.
    pub fn stiffness_n_per_m(&self, phi: f64, depth_m: f64) -> Option<Matrix3x2<f64>> {
        if let Some(lip) = self.lip_n_per_m2 {
            return Some(Self::of_lip(lip) * depth_m);
        }
        self.over_edge(phi, depth_m, |phi| self.at(phi), |phi| self.integral(phi))
    }

    /// What the edge of a tooth has in the cut, from what there is at an angle and its integral.
    fn over_edge(
        &self,
        phi: f64,
        depth_m: f64,
        at: impl Fn(f64) -> Matrix3x2<f64>,
        integral: impl Fn(f64) -> Matrix3x2<f64>,
    ) -> Option<Matrix3x2<f64>> {
        let Engagement { entry_rad, exit_rad } = self.engagement;
        let phi = phi.rem_euclid(TAU);
        let lag = self.lag_rad_per_m * depth_m;
        if lag < 1e-9 {
            return (entry_rad..exit_rad).contains(&phi).then(|| at(phi) * depth_m);
        }
        let mut sum = None;
        // The edge higher up may still be in the cut that its tip made turns ago.
        let mut ahead = phi;
        while ahead - lag < exit_rad {
            let (from, to) = ((ahead - lag).max(entry_rad), ahead.min(exit_rad));
            if to > from {
                let part = (integral(to) - integral(from)) / self.lag_rad_per_m;
                sum = Some(sum.map_or(part, |sum: Matrix3x2<f64>| sum + part));
            }
            ahead += TAU;
        }
        sum
    }

    /// Angles of a tooth's tip at which its force changes its form, at a depth.
    pub fn corners_rad(&self, depth_m: f64) -> Vec<f64> {
        let Engagement { entry_rad, exit_rad } = self.engagement;
        let lag = self.lag_rad_per_m * depth_m;
        if self.lip_n_per_m2.is_some() {
            return Vec::new();
        }
        let mut corners = vec![entry_rad, exit_rad];
        if lag >= 1e-9 {
            corners.extend([entry_rad + lag, exit_rad + lag]);
        }
        corners
    }
}

/// The integrals of sin², sin cos and cos² up to an angle.
fn integrals(phi: f64) -> [f64; 3] {
    let (sin, cos) = phi.sin_cos();
    [0.5 * (phi - sin * cos), 0.5 * sin * sin, 0.5 * (phi + sin * cos)]
}
