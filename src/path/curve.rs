//! Curves of the tool centre point in the frame of the work: lines and arcs, with orientation.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::motion::{Circle, Turning};

/// Below this a turn has no axis to turn about the other way round, rad.
const NO_TURN_RAD: f64 = 1e-3;

/// Pieces in which a turn is summed up whose axis moves.
const PIECES: usize = 64;

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
    turn: Turn,
}

/// How the tool turns on an arc.
#[derive(Debug, Clone, PartialEq)]
enum Turn {
    /// From one orientation to the next.
    ByWay([UnitQuaternion<f64>; 3]),
    /// From the first by a rotation vector in the tool's frame, rad, with the arc or without it.
    Steady { first: UnitQuaternion<f64>, by: Vector3<f64>, with_arc: bool },
}

impl Turn {
    /// Which of the two ways round comes nearer to the orientation `via` at the share `via_at`.
    fn steady(
        circle: &Circle,
        [first, via, last]: [UnitQuaternion<f64>; 3],
        with_arc: bool,
    ) -> Self {
        let carried = if with_arc { circle.turn(1.0).into() } else { UnitQuaternion::identity() };
        let short = (first.inverse() * carried.inverse() * last).scaled_axis();
        // What hardly turns has no axis.
        let long = match short.norm() {
            angle if angle < NO_TURN_RAD => short,
            angle => short * (1.0 - TAU / angle),
        };
        let ways = [short, long].map(|by| Self::Steady { first, by, with_arc });
        let off = |turn: &Self| turn.at(circle, circle.via_at()).angle_to(&via);
        let [short, long] = ways;
        if off(&long) < off(&short) { long } else { short }
    }

    /// Orientation behind the share `u` of the arc.
    fn at(&self, circle: &Circle, u: f64) -> UnitQuaternion<f64> {
        match self {
            Self::ByWay([first, via, last]) => match circle.via_at() {
                via_at if u < via_at => turned(first, via, u / via_at),
                via_at => turned(via, last, (u - via_at) / (1.0 - via_at)),
            },
            Self::Steady { first, by, with_arc } => {
                let own = first * UnitQuaternion::from_scaled_axis(by * u);
                if *with_arc { UnitQuaternion::from(circle.turn(u)) * own } else { own }
            }
        }
    }
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
        turning: Turning,
    ) -> Option<Self> {
        let [a, b, c] = [from, via, to].map(|pose| pose.translation.vector);
        let orientations = [from, via, to].map(|pose| pose.rotation);
        let circle = Circle::through(a, b, c)?;
        let turn = match turning {
            Turning::ByWay => Turn::ByWay(orientations),
            Turning::ToEnd => Turn::steady(&circle, orientations, false),
            Turning::WithArc => Turn::steady(&circle, orientations, true),
        };
        Some(Self::Arc(Arc { circle, turn }))
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
            Self::Arc(Arc { turn: Turn::ByWay([first, via, last]), .. }) => {
                first.angle_to(via) + via.angle_to(last)
            }
            Self::Arc(Arc { turn: Turn::Steady { by, with_arc: false, .. }, .. }) => by.norm(),
            // With the arc and against it: less than both together.
            Self::Arc(Arc { circle, turn }) => {
                let at = |piece: usize| turn.at(circle, piece as f64 / PIECES as f64);
                (0..PIECES).map(|piece| at(piece).angle_to(&at(piece + 1))).sum()
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
                Isometry3::from_parts(Translation3::from(p), arc.turn.at(&arc.circle, u))
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
        let Some(arc) = Curve::arc(on(0.0, 0.0), on(200.0, 0.4), on(270.0, 1.0), Turning::ByWay)
        else {
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
        let line = [0.0, 1.0, 2.0].map(|x| at(x, 0.0, 0.0));
        assert_eq!(Curve::arc(line[0], line[1], line[2], Turning::ByWay), None);
    }

    /// ABB's manual of MoveC: a tool that stands to the path at the end as at the start stands so
    /// all the way; the orientation on the way only tells which way round.
    #[test]
    fn a_tool_turns_with_the_arc_or_straight_to_its_end() {
        let pose = |deg: f64, turn: UnitQuaternion<f64>| {
            let at = UnitQuaternion::from_scaled_axis(Vector3::z() * rad(deg)) * Vector3::x();
            Isometry3::from_parts(Translation3::from(at), turn)
        };
        let yaw = |deg: f64| UnitQuaternion::from_scaled_axis(Vector3::z() * rad(deg));
        let tilt = UnitQuaternion::from_scaled_axis(Vector3::x() * 2.5);
        let assert_turn = |curve: &Option<Curve>, u: f64, expected: UnitQuaternion<f64>| {
            let found = curve.as_ref().unwrap().at(u).rotation;
            assert!(found.angle_to(&expected) < 1e-12, "at {u}: {found} {expected}");
        };
        for end in [100.0, 270.0] {
            let via = pose(0.4 * end, yaw(7.0) * tilt);
            // It stands to the path as before.
            let with = Curve::arc(
                pose(0.0, tilt),
                pose(0.4 * end, yaw(0.4 * end + 7.0) * tilt),
                pose(end, yaw(end) * tilt),
                Turning::WithArc,
            );
            // It keeps its orientation, whatever that on the way.
            let kept = [Turning::WithArc, Turning::ToEnd]
                .map(|turning| Curve::arc(pose(0.0, tilt), via, pose(end, tilt), turning));
            for u in [0.0, 0.1, 0.4, 0.7, 1.0] {
                assert_turn(&with, u, yaw(end * u) * tilt);
                kept.iter().for_each(|curve| assert_turn(curve, u, tilt));
            }
            assert!((with.unwrap().turn_rad() - rad(end)).abs() < 1e-9);
            let [against, still] = kept.map(|curve| curve.unwrap().turn_rad());
            assert!(against.abs() < 1e-6 && still == 0.0, "{against} {still}");
        }
        // A quarter of a turn the long way, as the orientation on the way says.
        let long = Curve::arc(
            pose(0.0, yaw(0.0)),
            pose(50.0, yaw(-135.0)),
            pose(100.0, yaw(90.0)),
            Turning::ToEnd,
        );
        assert_turn(&long, 0.1, yaw(-27.0));
    }

    fn rad(deg: f64) -> f64 {
        deg * PI / 180.0
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
