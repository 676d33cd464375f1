//! Where the tool is and how it moves with joints and springs.

use nalgebra::{
    Isometry3, Matrix3, Matrix6xX, Point3, Rotation3, Translation3, UnitQuaternion, Vector3,
};

use super::placement::{Axis, Placement};
use super::robot::{NodeMotion, Robot, ancestors};

/// Pose of the tip frame in the base frame, as placed.
pub fn forward_kinematics(robot: &Robot, placement: &Placement) -> Isometry3<f64> {
    let (rotation, origin) = tip(robot, placement);
    Isometry3::from_parts(
        Translation3::from(origin),
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)),
    )
}

/// J of the elastic coordinates, 6 × n: velocity (rows 0–2, m/s) of the point `tcp_m` of the tip
/// frame and angular velocity (rows 3–5, rad/s) of the tip, in the base frame, per unit rate of
/// each α.
///
/// `jacobian` must have n columns.
pub fn elastic_jacobian(
    robot: &Robot,
    placement: &Placement,
    tcp_m: &Point3<f64>,
    jacobian: &mut Matrix6xX<f64>,
) {
    let p = point(robot, placement, tcp_m);
    jacobian.fill(0.0);
    for &index in &robot.tip_carriers {
        set_column(jacobian, index, &placement.elastic_axes[index], &p);
    }
}

/// J of the moving joints, 6 × (number of joints): as [`elastic_jacobian`], per unit rate of each
/// q.
///
/// `jacobian` must have one column per moving joint.
pub fn joint_jacobian(
    robot: &Robot,
    placement: &Placement,
    tcp_m: &Point3<f64>,
    jacobian: &mut Matrix6xX<f64>,
) {
    let p = point(robot, placement, tcp_m);
    for (index, axis) in placement.joint_axes.iter().enumerate() {
        set_column(jacobian, index, axis, &p);
    }
}

/// How much each elastic coordinate turns a link, about `direction` of the base frame, or about the
/// axis of the joint that carries the link; `None` if there is no such link with mass, or no such
/// joint.
pub fn link_rotation(
    robot: &Robot,
    placement: &Placement,
    link: &str,
    direction: Option<Vector3<f64>>,
) -> Option<Vec<f64>> {
    let body = robot.bodies.iter().find(|body| body.link == link && !body.is_payload)?;
    let direction = match direction {
        Some(direction) => direction,
        None => {
            ancestors(&robot.nodes, body.node).find_map(|node| match robot.nodes[node].motion {
                NodeMotion::Revolute { joint, .. } => Some(placement.joint_axes[joint].direction),
                _ => None,
            })?
        }
    };
    let mut turns = vec![0.0; robot.coordinates.len()];
    for i in robot.carriers_of(body) {
        turns[i] = placement.elastic_axes[i].angular_velocity().dot(&direction);
    }
    Some(turns)
}

fn tip(robot: &Robot, placement: &Placement) -> (Matrix3<f64>, Vector3<f64>) {
    let frame = &placement.frames[robot.tip_node];
    let offset = &robot.tip_offset;
    (
        frame.rotation * offset.rotation.to_rotation_matrix().matrix(),
        frame.origin + frame.rotation * offset.translation.vector,
    )
}

fn point(robot: &Robot, placement: &Placement, tcp_m: &Point3<f64>) -> Vector3<f64> {
    let (rotation, origin) = tip(robot, placement);
    origin + rotation * tcp_m.coords
}

fn set_column(jacobian: &mut Matrix6xX<f64>, index: usize, axis: &Axis, p: &Vector3<f64>) {
    jacobian.fixed_view_mut::<3, 1>(0, index).copy_from(&axis.velocity_at(p));
    jacobian.fixed_view_mut::<3, 1>(3, index).copy_from(&axis.angular_velocity());
}
