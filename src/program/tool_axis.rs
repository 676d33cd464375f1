//! The orientation of a tool of which only the axis is given.

use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};

/// An axis this nearly along another has no direction across it.
const PARALLEL: f64 = 1e-6;

/// The orientation whose z axis lies opposite to `tool_axis` (a unit vector from the work to the
/// spindle), turned least from `previous`; without one, with x along the frame's x axis projected.
pub(super) fn orientation(
    tool_axis: Unit<Vector3<f64>>,
    previous: Option<UnitQuaternion<f64>>,
) -> UnitQuaternion<f64> {
    let z = -tool_axis.into_inner();
    match previous {
        // The shortest rotation that takes z to its new place turns no less than any other that
        // does.
        Some(previous) => {
            let turn = UnitQuaternion::rotation_between(&(previous * Vector3::z()), &z)
                .unwrap_or_else(|| {
                    UnitQuaternion::from_axis_angle(
                        &Unit::new_normalize(previous * Vector3::x()),
                        std::f64::consts::PI,
                    )
                });
            turn * previous
        }
        None => {
            let x = across(Vector3::x(), z).or_else(|| across(Vector3::y(), z));
            let x = x.unwrap_or_else(Vector3::x);
            let rotation = Rotation3::from_basis_unchecked(&[x, z.cross(&x), z]);
            UnitQuaternion::from_rotation_matrix(&rotation)
        }
    }
}

/// The direction of `v` across the unit vector `z`.
fn across(v: Vector3<f64>, z: Vector3<f64>) -> Option<Vector3<f64>> {
    (v - z * v.dot(&z)).try_normalize(PARALLEL)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn turned(axis: Vector3<f64>, previous: Option<UnitQuaternion<f64>>) -> UnitQuaternion<f64> {
        orientation(Unit::new_normalize(axis), previous)
    }

    #[test]
    fn first_orientation_looks_down_with_x_along_the_work_object() {
        let down = turned(Vector3::z(), None);
        assert!((down * Vector3::z() + Vector3::z()).norm() < 1e-15);
        assert!((down * Vector3::x() - Vector3::x()).norm() < 1e-15);
        assert!((down * Vector3::y() + Vector3::y()).norm() < 1e-15);
        let sideways = turned(Vector3::x(), None);
        assert!((sideways * Vector3::z() + Vector3::x()).norm() < 1e-15);
        assert!((sideways * Vector3::x() - Vector3::y()).norm() < 1e-15);
    }

    #[test]
    fn no_turn_about_the_tool_comes_nearer_to_the_previous_orientation() {
        let previous = UnitQuaternion::from_euler_angles(0.3, -1.2, 2.0);
        let axis = Vector3::new(0.2, -0.7, 0.5);
        let chosen = turned(axis, Some(previous));
        assert!((chosen * Vector3::z() + axis.normalize()).norm() < 1e-14);
        for step in 1..360 {
            let roll =
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), f64::from(step).to_radians());
            assert!((chosen * roll).angle_to(&previous) > chosen.angle_to(&previous));
        }
    }

    #[test]
    fn a_reversed_axis_turns_about_x() {
        let previous = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2);
        let chosen = turned(Vector3::z(), Some(previous));
        assert!((chosen * Vector3::z() + Vector3::z()).norm() < 1e-14);
        assert!((chosen * Vector3::x() - Vector3::y()).norm() < 1e-14);
    }
}
