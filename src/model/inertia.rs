//! M(q) and K_g(q) over the elastic coordinates, by composite rigid bodies (Featherstone, Rigid
//! Body Dynamics Algorithms, 2008, §6.2).
//!
//! Bodies are combined about their common centre of mass, so every term of a diagonal entry is a
//! sum of squares: nothing cancels, however far the arm reaches.

use nalgebra::{DMatrix, Vector3};

use super::body::Composite;
use super::correction::{Conditions, SpringState};
use super::description::CoordinateKind;
use super::placement::{Axis, Placement};
use super::products::turned;
use super::robot::{Coupling, Robot, UncertainBody};

/// An inertia about an axis below this share of what the same body has across it counts as none: a
/// point mass on a slanting axis leaves rounding, not zero, and rounding is no inertia to vibrate
/// with.
const MIN_INERTIA: f64 = 1e-13;

/// M(q), n × n, symmetric, kg·m² (rotations), kg (translations), kg·m (mixed): the inertia over the
/// elastic coordinates of the robot as placed, drives included.
///
/// `m` must be n × n with n the number of elastic coordinates.
pub fn mass_matrix(robot: &Robot, placement: &Placement, m: &mut DMatrix<f64>) {
    m.fill(0.0);
    for (j, carriers) in robot.carriers.iter().enumerate() {
        let axis_j = &placement.elastic_axes[j];
        let body = &placement.composites[robot.coordinates[j].node];
        // Momentum of what j carries, per unit rate of α_j: linear, and angular about the centre of
        // mass.
        let linear = axis_j.velocity_at(&body.com) * body.mass;
        let angular = turned(&body.inertia, &axis_j.angular_velocity());
        for &i in carriers {
            let axis_i = &placement.elastic_axes[i];
            let entry = axis_i.velocity_at(&body.com).dot(&linear)
                + axis_i.angular_velocity().dot(&angular);
            m[(i, j)] = entry;
            m[(j, i)] = entry;
        }
        if axis_j.kind == CoordinateKind::Rotation {
            let arm = body.com - axis_j.point;
            let across = body.mass * arm.norm_squared() + body.inertia.trace();
            if m[(j, j)] <= MIN_INERTIA * across {
                m[(j, j)] = 0.0;
            }
        }
        m[(j, j)] += robot.coordinates[j].drive_inertia;
    }
}

/// What one body adds to M(q), n × n: M(q) is the sum over all bodies, and drives.
pub fn body_mass_matrix(
    robot: &Robot,
    placement: &Placement,
    body: &UncertainBody,
) -> DMatrix<f64> {
    let n = robot.coordinates.len();
    let frame = &placement.frames[body.node];
    let placed = Composite::placed(&body.body, &frame.rotation, &frame.origin);
    let mut m = DMatrix::zeros(n, n);
    let carriers = robot.carriers_of(body);
    for &j in &carriers {
        for &i in &carriers {
            let axes = [i, j].map(|coordinate| &placement.elastic_axes[coordinate]);
            m[(i, j)] = coupling(axes, &placed);
        }
    }
    m
}

/// Entry of M for two axes that move a body.
fn coupling([i, j]: [&Axis; 2], body: &Composite) -> f64 {
    let linear: Vector3<f64> = j.velocity_at(&body.com) * body.mass;
    let angular: Vector3<f64> = turned(&body.inertia, &j.angular_velocity());
    i.velocity_at(&body.com).dot(&linear) + i.angular_velocity().dot(&angular)
}

/// The rows that rotations which the robot lacks would have in M(q), one a rotation, by its n
/// elastic coordinates, kg·m² (rotations), kg·m (translations): about three axes at the origin of
/// the root, or about two axes across that of the coordinate `across`.
///
/// A mode φ transmits the moment ω² (row·φ) about such an axis. A compliance c there, small against
/// the model's own, lowers ln f by ½ c ω² (row·φ)² (Rayleigh's quotient, φ mass-normalised).
pub fn lacking_rotations(
    robot: &Robot,
    placement: &Placement,
    across: Option<usize>,
) -> DMatrix<f64> {
    let about = |point: Vector3<f64>, direction: Vector3<f64>| Axis {
        direction,
        point,
        kind: CoordinateKind::Rotation,
    };
    let axes: Vec<Axis> = match across {
        None => {
            let root = placement.frames[0].origin;
            [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| about(root, axis)).into()
        }
        Some(i) => {
            let own = &placement.elastic_axes[i];
            let most = own.direction.iamax();
            let aside = Vector3::from_fn(|k, _| if k == (most + 1) % 3 { 1.0 } else { 0.0 });
            let first = own.direction.cross(&aside).normalize();
            vec![about(own.point, first), about(own.point, own.direction.cross(&first))]
        }
    };
    let n = robot.coordinates.len();
    DMatrix::from_fn(axes.len(), n, |a, j| {
        let carries = |outer: usize, inner: usize| robot.carriers[outer].contains(&inner);
        // What both move.
        let node = match across {
            Some(i) if carries(i, j) => robot.coordinates[i].node,
            Some(i) if !carries(j, i) => return 0.0,
            _ => robot.coordinates[j].node,
        };
        coupling([&axes[a], &placement.elastic_axes[j]], &placement.composites[node])
    })
}

/// K(q), n × n, symmetric, N·m/rad (rotations), N/m (translations): the springs, by their laws
/// under `conditions`, and gravity's part where the robot asks for it.
///
/// `k` must be n × n.
pub fn stiffness_matrix(
    robot: &Robot,
    placement: &Placement,
    conditions: &Conditions,
    k: &mut DMatrix<f64>,
) {
    if robot.gravity_stiffness {
        gravity_stiffness(robot, placement, k);
    } else {
        k.fill(0.0);
    }
    for i in 0..robot.coordinates.len() {
        k[(i, i)] += spring_constant(robot, placement, conditions, i);
    }
    for &Coupling { own, other, ratio } in &robot.couplings {
        // ½ k (α_own + ratio · α_other)².
        let constant = spring_constant(robot, placement, conditions, own);
        k[(other, other)] += ratio * ratio * constant;
        k[(own, other)] += ratio * constant;
        k[(other, own)] += ratio * constant;
    }
}

/// The spring of coordinate `i` by its laws, N·m/rad or N/m, for a robot placed at a pose.
pub fn spring_constant(
    robot: &Robot,
    placement: &Placement,
    conditions: &Conditions,
    i: usize,
) -> f64 {
    let coordinate = &robot.coordinates[i];
    if coordinate.laws.is_empty() {
        return coordinate.stiffness;
    }
    let state = SpringState {
        gravity_torque_nm: gravity_torque(robot, placement, i),
        position: coordinate.joint.map_or(0.0, |joint| placement.positions[joint]),
    };
    coordinate.stiffness_under(state, conditions)
}

/// What gravity pulls on coordinate `i` with, N·m or N.
pub(super) fn gravity_torque(robot: &Robot, placement: &Placement, i: usize) -> f64 {
    let body = &placement.composites[robot.coordinates[i].node];
    body.mass * robot.gravity.dot(&placement.elastic_axes[i].velocity_at(&body.com))
}

/// K_g(q), n × n, symmetric, N·m/rad: the Hessian of the potential of gravity −Σ m g·c over the
/// elastic coordinates at rest. For the two-link arm it follows from Eqs. (5)–(6) of Pietruś &
/// Gierlak (2023) without the linearisation (7)–(8), which drops it.
///
/// `k` must be n × n.
pub fn gravity_stiffness(robot: &Robot, placement: &Placement, k: &mut DMatrix<f64>) {
    k.fill(0.0);
    for (j, carriers) in robot.carriers.iter().enumerate() {
        let axis_j = &placement.elastic_axes[j];
        let body = &placement.composites[robot.coordinates[j].node];
        let moved = axis_j.velocity_at(&body.com);
        for &i in carriers {
            // i is the outer coordinate: turning it turns the displacement that j causes.
            let axis_i = &placement.elastic_axes[i];
            let bent = match axis_i.kind {
                CoordinateKind::Rotation => axis_i.direction.cross(&moved),
                CoordinateKind::Translation => Vector3::zeros(),
            };
            let entry = -body.mass * robot.gravity.dot(&bent);
            k[(i, j)] = entry;
            k[(j, i)] = entry;
        }
    }
}
