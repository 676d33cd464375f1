//! Places of a path at which the tool cuts, with all that vibrates there.

use nalgebra::{Complex, Matrix3x4, Vector3};

use super::air_cuts::{DrillMove, InWork, drills, in_work};
use crate::job::Operation;
use crate::notes::Note;
use crate::path::{Path, TipModes, tip_modes_of_tool};
use crate::stability::ToolMode;
use crate::units::{hz_from_rpm, rad_per_s_from_hz};

/// Whose mode it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// The arm's, counted from 1 in ascending frequency.
    Arm(usize),
    /// The tool's own.
    Tool,
}

/// A mode with its owner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipMode {
    #[allow(missing_docs, reason = "the type says it")]
    pub of: Owner,
    /// In the tool's frame.
    pub mode: ToolMode,
    /// How it turns the tool about its axis out of the work, 1/(√kg m); zero of the tool's own.
    pub turning: f64,
}

impl TipMode {
    /// How the tip moves in it at ω, rad/s, under a force on the tip and a torque about the axis
    /// out of the work.
    pub fn moved_m(
        &self,
        force_n: &Vector3<Complex<f64>>,
        torque_nm: f64,
        omega_rad_per_s: f64,
    ) -> Vector3<Complex<f64>> {
        self.mode.moved_m(self.mode.pushed(force_n) + torque_nm * self.turning, omega_rad_per_s)
    }
}

/// Σ [`TipMode::moved_m`] for any load: 3 × 4, by the force and the torque.
pub(super) fn tip_receptance(modes: &[TipMode], omega_rad_per_s: f64) -> Matrix3x4<Complex<f64>> {
    let mut sum = Matrix3x4::zeros();
    for TipMode { mode, turning, .. } in modes {
        let dynamic = mode.dynamic(omega_rad_per_s);
        let pushed = mode.motion.push(*turning);
        for j in 0..4 {
            for i in 0..3 {
                sum[(i, j)] += dynamic * (mode.motion[i] * pushed[j]);
            }
        }
    }
    sum
}

/// The tool tip at one place of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct TipPlace {
    /// Where, 0..=1.
    pub s: f64,
    /// Spindle speed, rev/min.
    pub rpm: f64,
    /// Mean feed per tooth, m.
    pub feed_per_tooth_m: f64,
    /// The modes of the arm, then those of the tool.
    pub modes: Vec<TipMode>,
    /// Whether the tool surely cuts there, and as its force is worked out: not where its feed alone
    /// speaks for air, nor in a plunge of a mill, whose force is taken for that of a cut to any
    /// side, nor where a drill moves across its axis, whose force is taken for that of drilling.
    pub is_sure: bool,
    /// Whether a drill moves there across its axis at about the operation's feed: what it does to
    /// the work is not known.
    pub leaves_axis: bool,
}

/// Of places those at which the tool surely cuts; all where it does so nowhere.
pub fn sure_ones(places: Vec<TipPlace>) -> Vec<TipPlace> {
    let is_any_sure = places.iter().any(|place| place.is_sure);
    places.into_iter().filter(|place| place.is_sure || !is_any_sure).collect()
}

/// The modes of the arm at a place, in the frame that they are in there; those that do not move the
/// tip are left out.
pub fn arm_modes(at: &TipModes) -> Vec<TipMode> {
    let moved = at.motions.iter().zip(&at.turns);
    let all = at.natural_frequencies_hz.iter().zip(&at.damping_ratios).zip(moved);
    all.enumerate()
        .filter(|(_, ((hz, _), (motion, _)))| hz.is_finite() && motion.norm() > 0.0)
        .map(|(r, ((&hz, &damping_ratio), (motion, turn)))| TipMode {
            of: Owner::Arm(r + 1),
            mode: ToolMode {
                omega_rad_per_s: rad_per_s_from_hz(hz),
                damping_ratio,
                motion: *motion,
            },
            turning: turn.z,
        })
        .collect()
}

/// Those of `s` (0..=1) at which the tool may cut, with the modes there: where it moves
/// ([`in_work`]) and `turns`, the spindle, does so. A plunge of a mill stands as four places, cuts
/// to four sides; of a drill that leaves its hole nothing stands.
///
/// # Errors
/// The first place that the arm does not reach, or at which it has no modes.
pub fn tip_places(
    operation: &Operation,
    path: &Path,
    s: &[f64],
    turns: impl Fn(f64) -> bool,
) -> Result<Vec<TipPlace>, Note> {
    let may_cut = |s: f64| {
        turns(s)
            && operation.speed.rpm_at(s) > 0.0
            && matches!(in_work(operation, path, s), InWork::Cuts | InWork::TakenForAir)
    };
    let s: Vec<f64> = s.iter().copied().filter(|s| may_cut(*s)).collect();
    let of_tool = operation.tool.modes.iter().map(ToolMode::from);
    let of_tool = of_tool.map(|mode| TipMode { of: Owner::Tool, mode, turning: 0.0 });
    let of_tool: Vec<TipMode> = of_tool.collect();
    let place = |at: &TipModes| {
        let rpm = operation.speed.rpm_at(at.s);
        let teeth_per_s = hz_from_rpm(rpm) * f64::from(operation.tool.teeth);
        let feed_per_tooth_m = path.feed_m_per_s_at(at.s) / teeth_per_s;
        let drills = drills(operation, &at.feed);
        let is_model = drills.map_or(at.feed.is_across, |how| how == DrillMove::Into);
        let cuts = in_work(operation, path, at.s) == InWork::Cuts;
        let (is_sure, leaves_axis) = (is_model && cuts, drills == Some(DrillMove::Across) && cuts);
        let mut modes = arm_modes(at);
        modes.extend(&of_tool);
        TipPlace { s: at.s, rpm, feed_per_tooth_m, modes, is_sure, leaves_axis }
    };
    let all = tip_modes_of_tool(path, &s)?;
    let sides = |at: &TipModes| {
        let place = place(at);
        let count = match drills(operation, &at.feed) {
            Some(DrillMove::OutOf) => 0,
            Some(DrillMove::Into | DrillMove::Across) => 1,
            None if at.feed.is_across => 1,
            None => 4,
        };
        (0..count).map(move |quarter| turned(&place, quarter))
    };
    Ok(all.iter().flat_map(sides).collect())
}

/// A place with the feed so many quarters of a turn to the left.
fn turned(place: &TipPlace, quarters: usize) -> TipPlace {
    let mut turned = place.clone();
    for one in &mut turned.modes {
        for _ in 0..quarters {
            let [x, y, z] = one.mode.motion.into();
            one.mode.motion = Vector3::new(y, -x, z);
        }
    }
    turned
}
