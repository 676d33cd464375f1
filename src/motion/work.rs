//! Where the work is: on the ground, on a positioner that turns it, or in the arm's own gripper.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, Unit, Vector3};

/// Where the work is on a move, and so the frame in which the poses of its target are.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Work {
    /// It stands still: poses are in the base frame.
    #[default]
    Stands,
    /// The arm holds it and leads it along a tool that stands: poses are in the tip frame, and
    /// [`Move::tcp`](super::Move::tcp) is in the base frame.
    Held,
    /// A mechanical unit moves it: poses are in the unit's user frame.
    Moves(Arc<UnitMove>),
}

/// What a mechanical unit does on a move: its axes go straight from one position to the other.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitMove {
    /// The unit.
    pub unit: Arc<MechanicalUnit>,
    /// Positions of its axes at the start of the move, rad or m.
    pub from: Vec<f64>,
    /// Positions of its axes at the end of the move, rad or m.
    pub to: Vec<f64>,
}

/// A positioner or a track that carries the work; it is taken as rigid.
#[derive(Debug, Clone, PartialEq)]
pub struct MechanicalUnit {
    /// As the program spells it.
    pub name: String,
    /// Its axes, from the ground to the work.
    pub axes: Vec<UnitAxis>,
    /// The user frame in the base frame of the robot, with all axes at zero.
    pub frame: Isometry3<f64>,
}

/// An axis of a mechanical unit.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitAxis {
    /// The external axis that it is, in lower case.
    pub name: String,
    /// Its direction in the base frame of the robot, with all axes at zero.
    pub axis: Unit<Vector3<f64>>,
    /// A point on it there, m.
    pub origin_m: Point3<f64>,
    /// Whether it slides: positions are in m, else in rad.
    pub slides: bool,
}

impl MechanicalUnit {
    /// The user frame in the base frame where the axes are at `positions`, rad or m: a product of
    /// exponentials (Murray, Li & Sastry 1994, eq. 3.3).
    pub(crate) fn user_frame(&self, positions: impl Iterator<Item = f64>) -> Isometry3<f64> {
        let moved = self.axes.iter().zip(positions).map(|(axis, at)| axis.moved(at));
        moved.fold(Isometry3::identity(), |whole, next| whole * next) * self.frame
    }
}

impl UnitAxis {
    fn moved(&self, at: f64) -> Isometry3<f64> {
        if self.slides {
            return Translation3::from(self.axis.into_inner() * at).into();
        }
        let turn = Rotation3::from_axis_angle(&self.axis, at);
        let shift = self.origin_m - turn * self.origin_m;
        Isometry3::from_parts(Translation3::from(shift), turn.into())
    }
}

impl Work {
    /// Its frame in the base frame behind the share `u` of the move, the tip being at `tip`.
    pub(crate) fn frame(&self, u: f64, tip: &Isometry3<f64>) -> Isometry3<f64> {
        match self {
            Self::Stands => Isometry3::identity(),
            Self::Held => *tip,
            Self::Moves(of) => {
                let at = of.from.iter().zip(&of.to).map(|(from, to)| from + (to - from) * u);
                of.unit.user_frame(at)
            }
        }
    }

    /// The pose of the tool in the frame of the work behind the share `u` of the move.
    pub(crate) fn pose(
        &self,
        u: f64,
        tip: &Isometry3<f64>,
        tcp: &Isometry3<f64>,
    ) -> Isometry3<f64> {
        match self {
            Self::Stands => tip * tcp,
            Self::Held => tip.inverse() * tcp,
            Self::Moves(_) => self.frame(u, tip).inverse() * tip * tcp,
        }
    }

    /// The tip in the base frame where the tool is at `pose` in the frame of the work, behind the
    /// share `u` of the move.
    pub(crate) fn tip(
        &self,
        u: f64,
        pose: &Isometry3<f64>,
        tcp: &Isometry3<f64>,
    ) -> Isometry3<f64> {
        match self {
            Self::Stands => pose * tcp.inverse(),
            Self::Held => tcp * pose.inverse(),
            Self::Moves(_) => self.frame(u, &Isometry3::identity()) * pose * tcp.inverse(),
        }
    }

    /// Largest change of an axis that moves the work, rad or m.
    pub(crate) fn largest_step(&self) -> f64 {
        let Self::Moves(of) = self else { return 0.0 };
        of.from.iter().zip(&of.to).fold(0.0, |most, (from, to)| most.max((to - from).abs()))
    }

    /// How fast work that moves carries a point of the base frame and turns, per share of the move
    /// at the share `u`: m and rad, in the base frame.
    pub(crate) fn motion(&self, u: f64, at: &Point3<f64>) -> [Vector3<f64>; 2] {
        /// Of the move: the error goes with its square.
        const STEP: f64 = 1e-5;
        let tip = Isometry3::identity();
        let [before, here, after] = [u - STEP, u, u + STEP].map(|u| self.frame(u, &tip));
        let at = here.inverse_transform_point(at);
        let turn = after.rotation * before.rotation.inverse();
        [(after * at - before * at) / (2.0 * STEP), turn.scaled_axis() / (2.0 * STEP)]
    }

    /// The same where the move has ended.
    pub(crate) fn ended(&self) -> Self {
        match self {
            Self::Moves(of) => {
                let ended = UnitMove { from: of.to.clone(), ..UnitMove::clone(of) };
                Self::Moves(Arc::new(ended))
            }
            own => own.clone(),
        }
    }
}
