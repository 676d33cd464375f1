//! What places of G-code count from beside shifts of the zero: a pole, and the turn of G68.

use crate::program::arc::Plane;

/// Places that differ by no more are one, mm.
pub(super) const ROUNDING_MM: f64 = 1e-6;

/// A place of which not all axes are known, mm in the job's work object.
pub(super) type Place = [Option<f64>; 3];

/// Radius and angle that were given last, mm and degrees: each holds until the next.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Polar {
    /// Of AP= and RP=, along the axes of the plane, in the program's coordinates.
    pub(super) pole: [f64; 2],
    pub(super) radius: Option<f64>,
    pub(super) angle: Option<f64>,
    /// G16: the words of the plane's axes are radius and angle.
    pub(super) is_on: bool,
}

/// G68.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turned {
    pub(super) plane: Plane,
    /// mm in the job's work object.
    pub(super) centre: [f64; 2],
    pub(super) angle_rad: f64,
}

impl Turned {
    pub(super) fn turn(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        self.by(self.angle_rad, [u, v])
    }

    pub(super) fn by(&self, angle: f64, [u, v]: [f64; 2]) -> [f64; 2] {
        let [du, dv] = [u - self.centre[0], v - self.centre[1]];
        let (sin, cos) = angle.sin_cos();
        [self.centre[0] + du * cos - dv * sin, self.centre[1] + du * sin + dv * cos]
    }

    pub(super) fn place(&self, angle: f64, mut place: Place) -> Place {
        let Plane([u, v, _]) = self.plane;
        let known = place[u].zip(place[v]).map(|(u, v)| self.by(angle, [u, v]));
        (place[u], place[v]) = (known.map(|at| at[0]), known.map(|at| at[1]));
        place
    }
}
