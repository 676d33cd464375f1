//! The reduced tree: links that never move against each other become one body.

use nalgebra::{Isometry3, Point3, Unit};

use super::checks::has_direction;
use super::tree::Tree;
use crate::model::description::{
    CoordinateKind, Correction, Damping, Description, ElasticJoint, ExtraCoordinate, Inertial,
    Joint, JointKind, Mesh,
};
use crate::model::robot::{Coordinate, MovingJoint, Node, NodeMotion, PlacedMesh, UncertainBody};

/// The reduced tree while it grows.
pub(super) struct Bodies<'a> {
    pub(super) description: &'a Description,
    pub(super) tree: &'a Tree,
    /// By link: whether it is between base (excluded) and tip (included).
    pub(super) chain: &'a [bool],
    pub(super) extras_of: &'a [Vec<usize>],
    pub(super) payload_link: Option<usize>,
    pub(super) nodes: Vec<Node>,
    pub(super) bodies: Vec<UncertainBody>,
    pub(super) meshes: Vec<PlacedMesh>,
    pub(super) joints: Vec<MovingJoint>,
    pub(super) coordinates: Vec<Coordinate>,
    /// Node of each link, and the link's frame in the node's.
    pub(super) place_of: Vec<Option<(usize, Isometry3<f64>)>>,
}

impl Bodies<'_> {
    /// Adds `base` and all that it carries, depth first so that the coordinates of a subtree are
    /// contiguous. A stack of our own: descriptions may be deep.
    pub(super) fn grow(&mut self, base: usize) {
        let mut stack = vec![(base, None)];
        while let Some((link, joint)) = stack.pop() {
            self.add(link, joint);
            let below = &self.tree.child_joints[link];
            stack.extend(below.iter().rev().map(|&j| (self.tree.child_link[j], Some(j))));
        }
    }

    fn add(&mut self, link: usize, joint: Option<usize>) {
        let description = self.description;
        let above = joint.and_then(|j| {
            let (node, offset) = self.place_of[self.tree.parent_link[j]]?;
            Some((node, offset * description.joints[j].origin, j))
        });
        let spring = above.and_then(|(_, _, j)| {
            description.elastic_joints.iter().find(|s| s.joint == description.joints[j].name)
        });
        let has_extras = !self.extras_of[link].is_empty();
        let place = match above {
            None => (self.open_node(None, Isometry3::identity()), Isometry3::identity()),
            Some((parent, offset, j)) => {
                let sets_pose = self.chain[link] && description.joints[j].kind.moves();
                let offset = if sets_pose { offset } else { offset * self.held(j) };
                if sets_pose || spring.is_some() || has_extras {
                    let node = self.open_node(Some(parent), offset);
                    if sets_pose {
                        self.add_joint(node, j);
                    }
                    (node, Isometry3::identity())
                } else {
                    (parent, offset)
                }
            }
        };
        self.place_of[link] = Some(place);
        let (node, offset) = place;
        if let (Some(spring), Some((_, _, j))) = (spring, above) {
            let spring = self.spring(spring, &description.joints[j], link, node);
            self.coordinates.push(spring);
        }
        for &index in &self.extras_of[link] {
            let is_hung = description.links[link].is_hung;
            let extra = self.extra(&description.extra[index], node, is_hung);
            self.coordinates.push(extra);
        }
        if spring.is_some() || has_extras {
            self.nodes[node].coordinates.end = self.coordinates.len();
        }
        let own = &description.links[link];
        self.meshes.extend(own.meshes.iter().map(|mesh| PlacedMesh {
            link: own.name.clone(),
            node,
            mesh: Mesh { frame: offset * mesh.frame, ..mesh.clone() },
        }));
        let carried = description.payload.as_ref().filter(|_| self.payload_link == Some(link));
        let bodies = [
            own.inertial.map(|body| (body, own.std, own.assumed, false)),
            // What is carried is known, and differs from job to job.
            carried.map(|payload| (payload.inertial, Some(0.0), false, true)),
        ];
        for (body, std, assumed, is_payload) in bodies.into_iter().flatten() {
            let body = body.transformed(&offset);
            self.nodes[node].add_body(&body);
            if body.mass_kg > 0.0 {
                let link = own.name.clone();
                self.bodies.push(UncertainBody { link, node, is_payload, body, assumed, std });
            }
        }
    }

    fn spring(&self, spring: &ElasticJoint, joint: &Joint, link: usize, node: usize) -> Coordinate {
        let description = self.description;
        let drive = description.drives.iter().find(|d| d.joint == spring.joint);
        Coordinate {
            name: spring.joint.clone(),
            kind: if joint.kind == JointKind::Prismatic {
                CoordinateKind::Translation
            } else {
                CoordinateKind::Rotation
            },
            link: description.links[link].name.clone(),
            is_hung: false,
            joint: self.joints.iter().position(|joint| joint.name == spring.joint),
            stiffness: spring.stiffness,
            std: spring.std,
            laws: description
                .corrections
                .iter()
                .filter(|correction| correction.is_about(&spring.joint))
                .filter_map(Correction::law)
                .collect(),
            damping: self.damping(spring.damping),
            drive_inertia: drive.map_or(0.0, |d| d.reflected_inertia_kgm2),
            drive_std: drive.and_then(|d| d.std),
            node,
            axis: Unit::new_normalize(joint.axis),
            origin: Point3::origin(),
        }
    }

    fn extra(&self, extra: &ExtraCoordinate, node: usize, is_hung: bool) -> Coordinate {
        Coordinate {
            name: extra.name.clone(),
            kind: extra.kind,
            link: extra.link.clone(),
            is_hung,
            joint: None,
            stiffness: extra.stiffness,
            std: extra.std,
            laws: Vec::new(),
            damping: self.damping(extra.damping),
            drive_inertia: 0.0,
            drive_std: None,
            node,
            axis: Unit::new_normalize(extra.axis),
            origin: extra.origin_m.into(),
        }
    }

    /// Joints off the chain stay where zero is, or at the limit nearest to it.
    fn held(&self, joint: usize) -> Isometry3<f64> {
        let joint = &self.description.joints[joint];
        let q = joint.position_limit.map_or(0.0, |[lower, upper]| 0.0_f64.max(lower).min(upper));
        if q == 0.0 || !has_direction(&joint.axis) {
            return Isometry3::identity();
        }
        let axis = Unit::new_normalize(joint.axis);
        match joint.kind {
            JointKind::Revolute | JointKind::Continuous => {
                Isometry3::rotation(axis.into_inner() * q)
            }
            JointKind::Prismatic => Isometry3::translation(axis.x * q, axis.y * q, axis.z * q),
            JointKind::Fixed | JointKind::Floating | JointKind::Planar => Isometry3::identity(),
        }
    }

    fn damping(&self, own: Option<Damping>) -> Damping {
        own.unwrap_or(Damping::Ratio(self.description.default_damping_ratio))
    }

    fn open_node(&mut self, parent: Option<usize>, fixed: Isometry3<f64>) -> usize {
        self.nodes.push(Node {
            parent,
            fixed: fixed.into(),
            motion: NodeMotion::Fixed,
            coordinates: self.coordinates.len()..self.coordinates.len(),
            body: Inertial::none(),
            subtree_mass_kg: 0.0,
        });
        self.nodes.len() - 1
    }

    fn add_joint(&mut self, node: usize, joint: usize) {
        let joint = &self.description.joints[joint];
        let axis = Unit::new_normalize(joint.axis);
        let index = self.joints.len();
        self.nodes[node].motion = if joint.kind == JointKind::Prismatic {
            NodeMotion::Prismatic { joint: index, axis }
        } else {
            NodeMotion::Revolute { joint: index, axis }
        };
        self.joints.push(MovingJoint {
            name: joint.name.clone(),
            kind: joint.kind,
            limit: if joint.kind == JointKind::Continuous { None } else { joint.position_limit },
            velocity_limit: joint.velocity_limit,
            node,
            axis,
        });
    }
}
