//! The nonlinear dynamics of the elastic coordinates: inverse dynamics by recursive Newton–Euler
//! (Featherstone 2008, §5.3) and the potential of gravity. Independent of [`super::mass_matrix`].

use nalgebra::Vector3;

use super::body::point_inertia;
use super::inertia::gravity_torque;
use super::placement::Placement;
use super::robot::Robot;

/// Motion of a body in the base frame: angular velocity and acceleration, and those of the
/// body-fixed point that is passing through the base origin.
#[derive(Clone, Copy)]
struct BodyMotion {
    angular_velocity: Vector3<f64>,
    velocity: Vector3<f64>,
    angular_acceleration: Vector3<f64>,
    acceleration: Vector3<f64>,
}

/// Forces (N·m or N) on the elastic coordinates for velocities `alpha_dot` and accelerations
/// `alpha_ddot` of a robot placed at its deflection: M(α) α̈ + C(α, α̇) α̇, without springs and
/// without gravity; the left side of Eq. (28) of Pietruś & Gierlak (2023) but for K α. Drives are
/// included.
///
/// All slices have one entry per elastic coordinate.
pub fn inverse_dynamics(
    robot: &Robot,
    placement: &Placement,
    alpha_dot: &[f64],
    alpha_ddot: &[f64],
    force: &mut [f64],
) {
    let rest = BodyMotion {
        angular_velocity: Vector3::zeros(),
        velocity: Vector3::zeros(),
        angular_acceleration: Vector3::zeros(),
        acceleration: Vector3::zeros(),
    };
    let mut motions: Vec<BodyMotion> = Vec::with_capacity(robot.nodes.len());
    // Force and moment about the base origin on each node and all that it carries.
    let mut wrenches: Vec<(Vector3<f64>, Vector3<f64>)> = Vec::with_capacity(robot.nodes.len());
    for (index, node) in robot.nodes.iter().enumerate() {
        let mut motion = node.parent.map_or(rest, |parent| motions[parent]);
        for i in node.coordinates.clone() {
            let axis = &placement.elastic_axes[i];
            let spin = axis.angular_velocity();
            let slide = axis.velocity_at(&Vector3::zeros());
            // Rate of the axis as it is carried along: V × S α̇.
            let spin_rate = motion.angular_velocity.cross(&spin);
            let slide_rate = motion.angular_velocity.cross(&slide) + motion.velocity.cross(&spin);
            motion.angular_acceleration += spin * alpha_ddot[i] + spin_rate * alpha_dot[i];
            motion.acceleration += slide * alpha_ddot[i] + slide_rate * alpha_dot[i];
            motion.angular_velocity += spin * alpha_dot[i];
            motion.velocity += slide * alpha_dot[i];
        }
        motions.push(motion);

        let frame = &placement.frames[index];
        let mass = node.body.mass_kg;
        let com = frame.origin + frame.rotation * node.body.com_m;
        let about_origin = frame.rotation * node.body.inertia_kgm2 * frame.rotation.transpose()
            + point_inertia(mass, &com);
        let first_moment = com * mass;
        let momentum = motion.velocity * mass + motion.angular_velocity.cross(&first_moment);
        let spin_momentum =
            about_origin * motion.angular_velocity + first_moment.cross(&motion.velocity);
        let force = motion.acceleration * mass
            + motion.angular_acceleration.cross(&first_moment)
            + motion.angular_velocity.cross(&momentum);
        let moment = about_origin * motion.angular_acceleration
            + first_moment.cross(&motion.acceleration)
            + motion.angular_velocity.cross(&spin_momentum)
            + motion.velocity.cross(&momentum);
        wrenches.push((force, moment));
    }
    for index in (0..robot.nodes.len()).rev() {
        let (carried_force, carried_moment) = wrenches[index];
        for i in robot.nodes[index].coordinates.clone() {
            let axis = &placement.elastic_axes[i];
            force[i] = axis.angular_velocity().dot(&carried_moment)
                + axis.velocity_at(&Vector3::zeros()).dot(&carried_force)
                + robot.coordinates[i].drive_inertia * alpha_ddot[i];
        }
        if let Some(parent) = robot.nodes[index].parent {
            wrenches[parent].0 += carried_force;
            wrenches[parent].1 += carried_moment;
        }
    }
}

/// Potential of gravity of the robot as placed, −Σ m g·c, J.
pub fn potential(robot: &Robot, placement: &Placement) -> f64 {
    robot.nodes.iter().zip(&placement.frames).fold(0.0, |sum, (node, frame)| {
        let com = frame.origin + frame.rotation * node.body.com_m;
        sum - node.body.mass_kg * robot.gravity.dot(&com)
    })
}

/// Gradient of [`potential`] over the elastic coordinates, N·m or N: the torques that the springs
/// carry at rest, and with them the static deflections α_st = −gradient / k of Eqs. (12)–(13).
///
/// `gradient` has one entry per elastic coordinate.
pub fn potential_gradient(robot: &Robot, placement: &Placement, gradient: &mut [f64]) {
    for (i, entry) in gradient.iter_mut().enumerate().take(robot.coordinates.len()) {
        *entry = -gravity_torque(robot, placement, i);
    }
}
