//! What of a robot does not depend on the pose, worked out once: frames chosen so that as many
//! joint axes as possible lie along a frame's axis, bodies that never move against each other
//! merged, and all masses.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::model::{CoordinateKind, Damping, NodeMotion, Robot};

/// An entry of a unit vector below this counts as zero: the rounding of a few chained rotations.
const ALIGNED: f64 = 4e-15;

/// The axis of a frame along which a joint's axis lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Along {
    X,
    Y,
    Z,
}

/// How a node moves against its parent with the pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Turn {
    None,
    /// About an axis of the node's frame, by the angle of a [`Spin`].
    About(Along, usize),
    /// Along a direction of the node's frame, by a joint's position.
    Slide {
        joint: usize,
        direction: [f64; 3],
    },
}

/// A sine and cosine to work out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spin {
    pub(super) joint: usize,
    /// −1 where the joint's axis lies against the frame's axis.
    pub(super) sign: f64,
}

/// Motion of the points of a node per unit rate of a coordinate: at p, `spin` × p + `slide`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Screw {
    /// A rotation about an axis of the node's frame through its origin.
    Axis(Along),
    General {
        spin: [f64; 3],
        slide: [f64; 3],
    },
}

/// Mass properties in a node's frame: centre of mass, and inertia about it as xx, yy, zz, xy, xz,
/// yz.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Body {
    pub(super) mass: f64,
    pub(super) com: [f64; 3],
    pub(super) inertia: [f64; 6],
}

/// A child whose composite body joins its parent's: shares of the masses met so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Joining {
    pub(super) child: usize,
    /// m_child / (m_before + m_child).
    pub(super) share: f64,
    /// m_before · m_child / (m_before + m_child), kg.
    pub(super) reduced: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct NodePlan {
    pub(super) parent: Option<usize>,
    pub(super) turn: Turn,
    /// The node's frame in the parent's at q = 0, where it is not parallel to it.
    pub(super) tilt: Option<[[f64; 3]; 3]>,
    /// Origin in the parent's frame at q = 0.
    pub(super) offset: [f64; 3],
    /// Own body and those that never move against it.
    pub(super) body: Body,
    /// Mass with all that it carries.
    pub(super) mass: f64,
    pub(super) joining: Vec<Joining>,
    /// Elastic coordinates of this node.
    pub(super) coordinates: std::ops::Range<usize>,
    /// Whether this node or one that carries it is elastic: only such bodies take part.
    pub(super) vibrates: bool,
    /// Whether a node further out that carries this one is elastic.
    pub(super) carried: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct CoordinatePlan {
    pub(super) node: usize,
    pub(super) screw: Screw,
    pub(super) kind: CoordinateKind,
    /// ±1/√k: a coordinate times √k, turned over where the screw runs against the robot's axis.
    pub(super) scale: f64,
    /// Drive inertia over k.
    pub(super) drive: f64,
    /// ζ of a spring's loss; 0 for a dashpot.
    pub(super) loss_ratio: f64,
    /// N·m·s/rad or N·s/m; 0 where a ratio is given.
    pub(super) viscous: f64,
}

/// The plan of one robot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    /// Values in a pose.
    pub(super) joints: usize,
    /// Parents before children, as in the robot.
    pub(super) nodes: Vec<NodePlan>,
    pub(super) coordinates: Vec<CoordinatePlan>,
    pub(super) spins: Vec<Spin>,
    /// Whether a spring follows the pose, which this code is not made for.
    pub(super) has_varying_springs: bool,
    /// What their modes do to the tool tip is not what the shapes say.
    pub(super) has_hung_parts: bool,
    /// Gravity in the first node's frame, m/s², where it is part of K.
    pub(super) gravity: Option<[f64; 3]>,
    /// ζ where every mode has this one.
    pub(super) one_damping_ratio: Option<f64>,
    pub(super) tip_node: usize,
    /// Tip frame in its node's frame: rotation and origin.
    tip: (Matrix3<f64>, Vector3<f64>),
}

impl Plan {
    pub(super) fn new(robot: &Robot) -> Self {
        let frames = Frames::of(robot);
        let mut spins = Vec::new();
        let mut nodes: Vec<NodePlan> = Vec::with_capacity(robot.nodes().len());
        for (i, node) in robot.nodes().iter().enumerate() {
            let carried = node.parent.is_some_and(|p| nodes[p].vibrates);
            let rest = &frames.rest[i];
            let inward = frames.chosen[i].transpose() * rest.rotation;
            let body = &node.body;
            let inertia = inward * body.inertia_kgm2 * inward.transpose();
            nodes.push(NodePlan {
                parent: node.parent,
                turn: turn(&node.motion, &frames.chosen[i], &rest.rotation, &mut spins),
                tilt: frames.tilt(i, node.parent),
                offset: frames.offset(i, node.parent).into(),
                body: Body {
                    mass: body.mass_kg,
                    com: (inward * body.com_m).into(),
                    inertia: packed(&inertia),
                },
                mass: node.subtree_mass_kg,
                joining: Vec::new(),
                coordinates: node.coordinates.clone(),
                vibrates: carried || !node.coordinates.is_empty(),
                carried,
            });
        }
        merge(&mut nodes);
        let coordinates: Vec<CoordinatePlan> = robot
            .coordinates()
            .iter()
            .map(|c| {
                let inward = frames.chosen[c.node].transpose() * frames.rest[c.node].rotation;
                let axis = snapped(inward * c.axis.into_inner());
                let (screw, sign) = screw(c.kind, &axis, &(inward * c.origin.coords));
                let (loss_ratio, viscous) = match c.damping {
                    Damping::Ratio(zeta) => (zeta, 0.0),
                    Damping::Viscous(c) => (0.0, c),
                };
                let stiffness = c.stiffness_of_all_poses().unwrap_or(c.stiffness);
                CoordinatePlan {
                    node: c.node,
                    screw,
                    kind: c.kind,
                    scale: sign / stiffness.sqrt(),
                    drive: c.drive_inertia / stiffness,
                    loss_ratio,
                    viscous,
                }
            })
            .collect();
        let gravity = robot.has_gravity_stiffness().then(|| (*robot.gravity_m_per_s2()).into());
        let first = coordinates[0].loss_ratio;
        let alike = coordinates.iter().all(|c| c.viscous == 0.0 && c.loss_ratio == first);
        let (tip_node, offset) = robot.tip();
        let inward = frames.chosen[tip_node].transpose() * frames.rest[tip_node].rotation;
        Self {
            joints: robot.joints().len(),
            nodes,
            coordinates,
            spins,
            has_hung_parts: robot.has_hung_parts(),
            has_varying_springs: robot
                .coordinates()
                .iter()
                .any(|c| c.stiffness_of_all_poses().is_none())
                || !robot.couplings().is_empty(),
            gravity,
            one_damping_ratio: (alike && gravity.is_none()).then_some(first),
            tip_node,
            tip: (
                inward * offset.rotation.to_rotation_matrix().matrix(),
                inward * offset.translation.vector,
            ),
        }
    }

    /// A point of the tip frame in its node's frame.
    pub(super) fn tool_point(&self, tcp_m: &Point3<f64>) -> [f64; 3] {
        (self.tip.1 + self.tip.0 * tcp_m.coords).into()
    }
}

/// Orientation and origin of a node in the base frame.
struct Rest {
    rotation: Matrix3<f64>,
    origin: Vector3<f64>,
}

/// The nodes as they stand at q = 0, and the orientation chosen for the frame of each.
struct Frames {
    rest: Vec<Rest>,
    chosen: Vec<Matrix3<f64>>,
}

impl Frames {
    /// Frames stay parallel to the parent's, so that nothing need be turned between them but by the
    /// joint itself; only where the joint's axis lies along none of the parent's axes is a new
    /// frame chosen, with z along the axis.
    fn of(robot: &Robot) -> Self {
        let mut rest: Vec<Rest> = Vec::new();
        let mut chosen: Vec<Matrix3<f64>> = Vec::new();
        for node in robot.nodes() {
            let (rotation, origin, parent) = match node.parent {
                None => (node.fixed.rotation, node.fixed.origin, Matrix3::identity()),
                Some(p) => (
                    rest[p].rotation * node.fixed.rotation,
                    rest[p].origin + rest[p].rotation * node.fixed.origin,
                    chosen[p],
                ),
            };
            let axis = match node.motion {
                NodeMotion::Revolute { axis, .. } => Some(rotation * axis.into_inner()),
                NodeMotion::Fixed | NodeMotion::Prismatic { .. } => None,
            };
            chosen.push(match axis {
                Some(axis) if along(&snapped(parent.transpose() * axis)).is_none() => {
                    with_z_along(&axis)
                }
                _ => parent,
            });
            rest.push(Rest { rotation, origin });
        }
        Self { rest, chosen }
    }

    fn tilt(&self, node: usize, parent: Option<usize>) -> Option<[[f64; 3]; 3]> {
        let parent = parent.map_or_else(Matrix3::identity, |p| self.chosen[p]);
        (self.chosen[node] != parent).then(|| {
            let t = parent.transpose() * self.chosen[node];
            std::array::from_fn(|i| std::array::from_fn(|j| t[(i, j)]))
        })
    }

    fn offset(&self, node: usize, parent: Option<usize>) -> Vector3<f64> {
        match parent {
            None => self.rest[node].origin,
            Some(p) => self.chosen[p].transpose() * (self.rest[node].origin - self.rest[p].origin),
        }
    }
}

/// Folds bodies that never move against their parent into it, and lists those that do, with the
/// shares of their masses.
fn merge(nodes: &mut [NodePlan]) {
    for child in (0..nodes.len()).rev() {
        let Some(parent) = nodes[child].parent else { continue };
        let still = nodes[child].joining.is_empty()
            && nodes[child].turn == Turn::None
            && nodes[child].tilt.is_none();
        if nodes[child].mass == 0.0 {
            continue;
        }
        if still {
            let offset = nodes[child].offset;
            let mut body = nodes[child].body;
            for (c, o) in body.com.iter_mut().zip(offset) {
                *c += o;
            }
            nodes[parent].body = joined(&nodes[parent].body, &body);
        } else {
            nodes[parent].joining.push(Joining { child, share: 0.0, reduced: 0.0 });
        }
    }
    for node in nodes.iter_mut() {
        node.joining.reverse();
    }
    for i in 0..nodes.len() {
        let mut before = nodes[i].body.mass;
        let mut joining = std::mem::take(&mut nodes[i].joining);
        for join in &mut joining {
            let mass = nodes[join.child].mass;
            join.share = mass / (before + mass);
            join.reduced = before * mass / (before + mass);
            before += mass;
        }
        nodes[i].joining = joining;
    }
}

/// Two bodies of one frame as one, about the common centre of mass.
fn joined(a: &Body, b: &Body) -> Body {
    let mass = a.mass + b.mass;
    if mass == 0.0 {
        return *a;
    }
    let apart: [f64; 3] = std::array::from_fn(|k| b.com[k] - a.com[k]);
    let [x, y, z] = apart;
    let reduced = a.mass * b.mass / mass;
    let point = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z];
    Body {
        mass,
        com: std::array::from_fn(|k| a.com[k] + apart[k] * (b.mass / mass)),
        inertia: std::array::from_fn(|k| a.inertia[k] + b.inertia[k] + reduced * point[k]),
    }
}

fn turn(
    motion: &NodeMotion,
    chosen: &Matrix3<f64>,
    rest: &Matrix3<f64>,
    spins: &mut Vec<Spin>,
) -> Turn {
    match motion {
        NodeMotion::Fixed => Turn::None,
        NodeMotion::Revolute { joint, axis } => {
            let axis = snapped(chosen.transpose() * (rest * axis.into_inner()));
            // The frame was chosen so that the axis lies along one of its own.
            let (along, sign) = along(&axis).unwrap_or((Along::Z, 1.0));
            spins.push(Spin { joint: *joint, sign });
            Turn::About(along, spins.len() - 1)
        }
        NodeMotion::Prismatic { joint, axis } => Turn::Slide {
            joint: *joint,
            direction: (chosen.transpose() * (rest * axis.into_inner())).into(),
        },
    }
}

/// The screw of a coordinate, and −1 where it runs against the coordinate.
fn screw(kind: CoordinateKind, axis: &Vector3<f64>, origin: &Vector3<f64>) -> (Screw, f64) {
    match (kind, along(axis)) {
        (CoordinateKind::Translation, _) => {
            (Screw::General { spin: [0.0; 3], slide: (*axis).into() }, 1.0)
        }
        (CoordinateKind::Rotation, Some((along, sign))) if *origin == Vector3::zeros() => {
            (Screw::Axis(along), sign)
        }
        (CoordinateKind::Rotation, _) => {
            (Screw::General { spin: (*axis).into(), slide: origin.cross(axis).into() }, 1.0)
        }
    }
}

/// Right-handed frame with the unit vector `z` as its third axis.
fn with_z_along(z: &Vector3<f64>) -> Matrix3<f64> {
    let least = Vector3::ith(z.iamin(), 1.0);
    let x = least.cross(z).normalize();
    Matrix3::from_columns(&[x, z.cross(&x), *z])
}

/// A unit vector without entries that are zero but for rounding.
fn snapped(axis: Vector3<f64>) -> Vector3<f64> {
    let kept = axis.map(|x| if x.abs() < ALIGNED { 0.0 } else { x });
    if kept.iter().filter(|x| **x != 0.0).count() == 1 {
        kept.map(|x| x.clamp(-1.0, 1.0).round())
    } else {
        axis
    }
}

/// The frame's axis that `axis` lies along, and ±1 for its sense.
fn along(axis: &Vector3<f64>) -> Option<(Along, f64)> {
    [Along::X, Along::Y, Along::Z].into_iter().enumerate().find_map(|(k, which)| {
        let others_vanish = (0..3).all(|other| other == k || axis[other] == 0.0);
        (others_vanish && axis[k] != 0.0).then(|| (which, axis[k].signum()))
    })
}

fn packed(m: &Matrix3<f64>) -> [f64; 6] {
    [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(0, 2)], m[(1, 2)]]
}
