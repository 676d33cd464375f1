//! Curves of the tool centre point in the base frame: straight lines and arcs, with orientation.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::motion::Circle;

/// A move of the tool centre point between two poses, over u from 0 to 1 at constant speed.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Curve {
    Line { from: Isometry3<f64>, to: Isometry3<f64> },
    Arc(Arc),
}

/// Part of a circle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Arc {
    circle: Circle,
    orientations: [UnitQuaternion<f64>; 3],
}

impl Curve {
    pub(super) fn line(from: Isometry3<f64>, to: Isometry3<f64>) -> Self {
        Self::Line { from, to }
    }

    /// The arc from `from` through `via` to `to`; `None` if the three points lie on one line.
    pub(super) fn arc(
        from: Isometry3<f64>,
        via: Isometry3<f64>,
        to: Isometry3<f64>,
    ) -> Option<Self> {
        let [a, b, c] = [from, via, to].map(|pose| pose.translation.vector);
        Some(Self::Arc(Arc {
            circle: Circle::through(a, b, c)?,
            orientations: [from.rotation, via.rotation, to.rotation],
        }))
    }

    /// Length of the point's way, m.
    pub(super) fn length_m(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to.translation.vector - from.translation.vector).norm(),
            Self::Arc(arc) => arc.circle.length(),
        }
    }

    /// Angle by which it turns, rad.
    pub(super) fn turn_rad(&self) -> f64 {
        match self {
            Self::Line { from, to } => from.rotation.angle_to(&to.rotation),
            Self::Arc(arc) => {
                let [first, via, last] = &arc.orientations;
                first.angle_to(via) + via.angle_to(last)
            }
        }
    }

    /// Pose at u in 0..=1.
    pub(super) fn at(&self, u: f64) -> Isometry3<f64> {
        match self {
            Self::Line { from, to } => {
                let p = from.translation.vector.lerp(&to.translation.vector, u);
                let turn = turned(&from.rotation, &to.rotation, u);
                Isometry3::from_parts(Translation3::from(p), turn)
            }
            Self::Arc(arc) => {
                let p = arc.circle.at(u);
                let via_at = arc.circle.via_at();
                let [first, via, last] = &arc.orientations;
                let turn = if u < via_at {
                    turned(first, via, u / via_at)
                } else {
                    turned(via, last, (u - via_at) / (1.0 - via_at))
                };
                Isometry3::from_parts(Translation3::from(p), turn)
            }
        }
    }
}

/// Orientation on the short way from `a` to `b`, about one fixed axis. Half a turn has two short
/// ways; the logarithm of the relative rotation picks one.
fn turned(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>, u: f64) -> UnitQuaternion<f64> {
    a * UnitQuaternion::from_scaled_axis((a.inverse() * b).scaled_axis() * u)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use std::f64::consts::PI;

    #[test]
    fn an_arc_passes_its_middle_pose_at_constant_speed() {
        let at =
            |x: f64, y: f64, yaw: f64| Isometry3::new(Vector3::new(x, y, 0.3), Vector3::z() * yaw);
        // Circle of radius 2 about (1, 1): from angle 0 through 200° to 270°.
        let on = |deg: f64, yaw: f64| {
            let a = deg * PI / 180.0;
            at(1.0 + 2.0 * a.cos(), 1.0 + 2.0 * a.sin(), yaw)
        };
        let Some(arc) = Curve::arc(on(0.0, 0.0), on(200.0, 0.4), on(270.0, 1.0)) else {
            panic!("not an arc")
        };
        assert!((arc.length_m() - 3.0 * PI).abs() < 1e-12);
        for (u, deg, yaw) in [
            (0.0, 0.0, 0.0),
            (1.0 / 3.0, 90.0, 0.18),
            (200.0 / 270.0, 200.0, 0.4),
            (1.0, 270.0, 1.0),
        ] {
            let (found, expected) = (arc.at(u), on(deg, yaw));
            assert!((found.translation.vector - expected.translation.vector).norm() < 1e-12);
            assert!(found.rotation.angle_to(&expected.rotation) < 1e-12, "at u = {u}");
        }
        assert_eq!(Curve::arc(at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(2.0, 0.0, 0.0)), None);
    }

    #[test]
    fn a_line_turns_about_one_axis_the_short_way() {
        let a = Isometry3::new(Vector3::zeros(), Vector3::z() * 3.0);
        let b = Isometry3::new(Vector3::x() * 2.0, Vector3::z() * -3.0);
        let half = Curve::line(a, b).at(0.5);
        assert!((half.translation.vector - Vector3::x()).norm() < 1e-15);
        let expected = UnitQuaternion::from_scaled_axis(Vector3::z() * PI);
        assert!(half.rotation.angle_to(&expected) < 1e-12);
    }
}
