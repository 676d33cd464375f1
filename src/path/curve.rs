//! Curves of the tool centre point in the base frame: straight lines and arcs, with orientation.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

/// Three points closer to one line than this share of their distance do not make an arc.
const FLATTEST_ARC: f64 = 1e-9;

/// A move of the tool centre point between two poses, over u from 0 to 1 at constant speed.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Curve {
    Line { from: Isometry3<f64>, to: Isometry3<f64> },
    Arc(Arc),
}

/// Part of a circle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Arc {
    centre: Point3<f64>,
    /// From the centre to the start.
    start: Vector3<f64>,
    axis: Unit<Vector3<f64>>,
    /// Whole angle, rad, positive about `axis`.
    angle: f64,
    /// u at which the arc passes its middle pose.
    via_at: f64,
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
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(&ac);
        if normal.norm() <= FLATTEST_ARC * ab.norm().max(ac.norm()).powi(2) {
            return None;
        }
        // Circumcentre of a triangle, from one of its corners.
        let to_centre = (normal.cross(&ab) * ac.norm_squared()
            + ac.cross(&normal) * ab.norm_squared())
            / (2.0 * normal.norm_squared());
        let centre = a + to_centre;
        let axis = Unit::new_normalize(normal);
        let start = a - centre;
        let angle_to = |p: Vector3<f64>| {
            let r = p - centre;
            let angle = f64::atan2(axis.dot(&start.cross(&r)), start.dot(&r));
            if angle > 0.0 { angle } else { angle + std::f64::consts::TAU }
        };
        let angle = angle_to(c);
        Some(Self::Arc(Arc {
            centre: centre.into(),
            start,
            axis,
            angle,
            via_at: angle_to(b) / angle,
            orientations: [from.rotation, via.rotation, to.rotation],
        }))
    }

    /// Length of the point's way, m.
    pub(super) fn length_m(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to.translation.vector - from.translation.vector).norm(),
            Self::Arc(arc) => arc.angle * arc.start.norm(),
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
                let p =
                    arc.centre + Rotation3::from_axis_angle(&arc.axis, arc.angle * u) * arc.start;
                let [first, via, last] = &arc.orientations;
                let turn = if u < arc.via_at {
                    turned(first, via, u / arc.via_at)
                } else {
                    turned(via, last, (u - arc.via_at) / (1.0 - arc.via_at))
                };
                Isometry3::from_parts(Translation3::from(p.coords), turn)
            }
        }
    }
}

/// Orientation on the short way from `a` to `b`, about one fixed axis. Half a turn has two short ways;
/// the logarithm of the relative rotation picks one.
fn turned(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>, u: f64) -> UnitQuaternion<f64> {
    a * UnitQuaternion::from_scaled_axis((a.inverse() * b).scaled_axis() * u)
}

#[cfg(test)]
mod tests {
    use super::*;
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
