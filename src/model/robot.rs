//! From a description to the immutable model: checks, then the reduced tree of bodies that move
//! against each other.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

use super::description::{
    ArmAngle, Calibration, CoordinateKind, Damping, Description, Inertial, JointKind, Link,
};
use super::fault::{ModelFault, Place, PoseFault};
use crate::units::{deg_from_rad, mm_from_m};

/// Slack in the triangle inequality of principal moments, as a share of the largest: CAD exports and
/// data sheets print three digits.
const TRIANGLE_SLACK: f64 = 1e-3;

/// Slack of the smallest principal moment below zero, as a share of the largest: rounding only.
const POSITIVITY_SLACK: f64 = 1e-9;

/// An axis shorter than this has no direction.
const SHORTEST_AXIS: f64 = 1e-9;

/// A pose may pass a limit by this much, rad or m: URDFs print limits with four or five digits (3.1416 for
/// half a turn), and a pose at the limit itself is meant to be allowed.
const LIMIT_SLACK: f64 = 1e-4;

/// A joint of the chain from base to tip that a pose sets.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingJoint {
    /// URDF name.
    pub name: String,
    /// Kind: revolute, continuous or prismatic.
    pub kind: JointKind,
    /// Limits of position, rad or m; `None` for a continuous joint and where the URDF has none.
    pub limit: Option<[f64; 2]>,
    /// Largest speed, rad/s or m/s.
    pub velocity_limit: Option<f64>,
    pub(super) node: usize,
    pub(super) axis: Unit<Vector3<f64>>,
}

/// A joint outside its limits. Shown as "joint 'a' is 190.000 deg, must lie in -180.000..180.000 deg".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitViolation<'a> {
    /// The joint.
    pub joint: &'a MovingJoint,
    /// Its position, rad or m.
    pub value: f64,
    /// Its limits, rad or m.
    pub limit: [f64; 2],
}

impl fmt::Display for LimitViolation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (shown, unit): (fn(f64) -> f64, _) = match self.joint.kind {
            JointKind::Prismatic => (mm_from_m, "mm"),
            _ => (deg_from_rad, "deg"),
        };
        let (name, [lower, upper]) = (&self.joint.name, self.limit.map(shown));
        let value = shown(self.value);
        write!(f, "joint '{name}' is {value:.3} {unit}, must lie in {lower:.3}..{upper:.3} {unit}")
    }
}

/// An elastic coordinate α_i.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinate {
    /// The joint's name, or the extra coordinate's.
    pub name: String,
    /// Rotation or translation.
    pub kind: CoordinateKind,
    /// The URDF link that it moves.
    pub link: String,
    /// The moving joint whose spring this is; `None` for an extra coordinate.
    pub joint: Option<usize>,
    /// Spring constant, N·m/rad or N/m.
    pub stiffness: f64,
    /// Loss.
    pub damping: Damping,
    /// Reflected rotor inertia on the coordinate's own diagonal of M, kg·m² or kg.
    pub drive_inertia: f64,
    pub(super) node: usize,
    /// In the node's frame.
    pub(super) axis: Unit<Vector3<f64>>,
    /// In the node's frame.
    pub(super) origin: Point3<f64>,
}

/// What moves a node against its parent when the pose changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum NodeMotion {
    Fixed,
    Revolute { joint: usize, axis: Unit<Vector3<f64>> },
    Prismatic { joint: usize, axis: Unit<Vector3<f64>> },
}

/// A body of the reduced tree: all links that never move against each other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) parent: Option<usize>,
    /// This node's frame in the parent's at q = 0, α = 0.
    pub(super) fixed: Isometry3<f64>,
    pub(super) motion: NodeMotion,
    /// Elastic coordinates of this node: indices into [`Robot::coordinates`], outermost first.
    pub(super) coordinates: std::ops::Range<usize>,
    /// Lumped mass properties in the node's frame.
    pub(super) body: Inertial,
    /// Mass of this node and all that it carries.
    pub(super) subtree_mass_kg: f64,
}

/// An angle of the two-link model: Σ scale·q + offset.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleForm {
    terms: Vec<(usize, f64)>,
    offset_rad: f64,
}

impl AngleForm {
    /// The angle at pose `q`, rad.
    pub fn at(&self, q: &[f64]) -> f64 {
        self.terms.iter().map(|&(joint, scale)| scale * q[joint]).sum::<f64>() + self.offset_rad
    }
}

/// The checked, immutable model of one robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    name: String,
    pub(super) nodes: Vec<Node>,
    pub(super) joints: Vec<MovingJoint>,
    pub(super) coordinates: Vec<Coordinate>,
    /// For each coordinate j, the coordinates i ≤ j that carry it (j itself last).
    pub(super) carriers: Vec<Vec<usize>>,
    /// Gravity in the base frame, m/s².
    pub(super) gravity: Vector3<f64>,
    gravity_stiffness: bool,
    pub(super) tip_node: usize,
    /// The coordinates that move the tip.
    pub(super) tip_carriers: Vec<usize>,
    /// Tip frame in its node's frame.
    pub(super) tip_offset: Isometry3<f64>,
    tip_link: String,
    beta1: Option<AngleForm>,
    beta2: Option<AngleForm>,
    calibration: Option<Calibration>,
    moving_mass_kg: f64,
    notices: Vec<ModelFault>,
}

impl Robot {
    /// Checks a description and builds the model.
    ///
    /// # Errors
    /// Every fault of the description, each with its place.
    pub fn new(description: &Description) -> Result<Self, Vec<ModelFault>> {
        Builder::new(description).build()
    }

    /// What the robot is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The moving joints from base to tip: the order of a pose.
    pub fn joints(&self) -> &[MovingJoint] {
        &self.joints
    }

    /// The elastic coordinates, base first.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// The link whose frame carries the tool.
    pub fn tip_link(&self) -> &str {
        &self.tip_link
    }

    /// β1 of the two-link model, where the robot defines it.
    pub fn beta1(&self) -> Option<&AngleForm> {
        self.beta1.as_ref()
    }

    /// β2 of the two-link model, where the robot defines it.
    pub fn beta2(&self) -> Option<&AngleForm> {
        self.beta2.as_ref()
    }

    /// How well the model is known to predict; `None` if it never was compared.
    pub fn calibration(&self) -> Option<&Calibration> {
        self.calibration.as_ref()
    }

    /// Whether K holds the geometric stiffness of gravity.
    pub fn has_gravity_stiffness(&self) -> bool {
        self.gravity_stiffness
    }

    /// Mass of everything that the first elastic coordinates carry, payload included, kg.
    pub fn moving_mass_kg(&self) -> f64 {
        self.moving_mass_kg
    }

    /// Remarks that do not stop the work: settings without effect, links that count as massless.
    pub fn notices(&self) -> &[ModelFault] {
        &self.notices
    }

    /// The joints that `q` puts outside their limits; none for a joint without limits.
    pub fn limit_violations<'a>(
        &'a self,
        q: &'a [f64],
    ) -> impl Iterator<Item = LimitViolation<'a>> + 'a {
        self.joints.iter().zip(q).filter_map(|(joint, &value)| {
            let limit @ [lower, upper] = joint.limit?;
            let inside = value >= lower - LIMIT_SLACK && value <= upper + LIMIT_SLACK;
            (!inside).then_some(LimitViolation { joint, value, limit })
        })
    }

    /// Checks that `q` is a pose of this robot: one finite value per moving joint.
    ///
    /// # Errors
    /// [`PoseFault::Length`] or [`PoseFault::NotFinite`].
    pub fn check_pose(&self, q: &[f64]) -> Result<(), PoseFault> {
        if q.len() != self.joints.len() {
            return Err(PoseFault::Length { given: q.len(), expected: self.joints.len() });
        }
        match q.iter().position(|value| !value.is_finite()) {
            Some(bad) => Err(PoseFault::NotFinite { joint: self.joints[bad].name.clone() }),
            None => Ok(()),
        }
    }
}

/// The tree of a description by index, and the faults found so far.
struct Builder<'a> {
    description: &'a Description,
    faults: Vec<ModelFault>,
    notices: Vec<ModelFault>,
}

/// Who is whose parent, by index into the description.
struct Tree {
    /// Joint above each link.
    parent_joint: Vec<Option<usize>>,
    /// Joints below each link.
    child_joints: Vec<Vec<usize>>,
    parent_link: Vec<usize>,
    child_link: Vec<usize>,
    root: usize,
}

impl<'a> Builder<'a> {
    fn new(description: &'a Description) -> Self {
        Self { description, faults: Vec::new(), notices: Vec::new() }
    }

    fn fault(&mut self, place: Place, key: &'static str, what: impl Into<String>) {
        self.faults.push(ModelFault::new(place, key, what));
    }

    fn notice(&mut self, place: Place, key: &'static str, what: impl Into<String>) {
        self.notices.push(ModelFault::new(place, key, what));
    }

    fn build(mut self) -> Result<Robot, Vec<ModelFault>> {
        self.check_inertias();
        self.check_axes();
        self.check_springs();
        let robot = self.tree().and_then(|tree| self.assemble(&tree));
        match robot {
            Some(robot) if self.faults.is_empty() => Ok(Robot { notices: self.notices, ..robot }),
            _ => {
                if self.faults.is_empty() {
                    self.fault(Place::Robot, "", "the robot could not be assembled");
                }
                Err(self.faults)
            }
        }
    }

    fn check_inertias(&mut self) {
        for link in &self.description.links {
            if let Some(inertial) = &link.inertial {
                for (key, what) in inertial_faults(inertial) {
                    self.fault(Place::Link(link.name.clone()), key, what);
                }
            }
        }
        if let Some(payload) = &self.description.payload {
            for (key, what) in inertial_faults(&payload.inertial) {
                self.fault(Place::Payload, key, what);
            }
        }
    }

    fn check_axes(&mut self) {
        for joint in &self.description.joints {
            let place = || Place::Joint(joint.name.clone());
            if joint.kind.moves() && !has_direction(&joint.axis) {
                let axis = triple(&joint.axis);
                self.fault(place(), "axis", format!("axis is {axis}, must have a direction"));
            }
            let origin = joint.origin.translation.vector;
            let rotation = joint.origin.rotation;
            if !is_finite(&origin) || !rotation.coords.iter().all(|c| c.is_finite()) {
                self.fault(place(), "origin", "origin must be finite");
            }
            if let Some([lower, upper]) = joint.position_limit
                && !(lower.is_finite() && upper.is_finite() && lower <= upper)
            {
                let what = format!("limits are {lower}..{upper}, must be finite and ascending");
                self.fault(place(), "limit", what);
            }
            if let Some(speed) = joint.velocity_limit
                && !(speed.is_finite() && speed > 0.0)
            {
                let what = format!("velocity limit is {speed}, must be positive and finite");
                self.fault(place(), "limit", what);
            }
        }
    }

    fn check_springs(&mut self) {
        let description = self.description;
        let joints: BTreeMap<&str, JointKind> =
            description.joints.iter().map(|j| (j.name.as_str(), j.kind)).collect();
        let moving: Vec<&str> =
            description.joints.iter().filter(|j| j.kind.moves()).map(|j| j.name.as_str()).collect();

        let default = description.default_damping_ratio;
        if let Some(what) = damping_fault(Some(Damping::Ratio(default))) {
            self.fault(Place::Damping, "damping_ratio", what);
        }
        for spring in &description.elastic_joints {
            let place = || Place::ElasticJoint(spring.joint.clone());
            match joints.get(spring.joint.as_str()) {
                None => {
                    let what = format!("the URDF has no such joint; it has {}", listed(&moving));
                    self.fault(place(), "", what);
                }
                Some(kind) if !kind.moves() => {
                    let what = "the joint does not move in the URDF; give the compliance as an extra coordinate";
                    self.fault(place(), "", what);
                }
                Some(kind) => {
                    let slides = *kind == JointKind::Prismatic;
                    if slides != spring.is_linear {
                        let (has, needs) = if slides {
                            ("stiffness_nm_per_rad", "stiffness_n_per_m, as the joint is prismatic")
                        } else {
                            ("stiffness_n_per_m", "stiffness_nm_per_rad, as the joint turns")
                        };
                        self.fault(place(), has, format!("{has} given, must be {needs}"));
                    }
                }
            }
            let key = if spring.is_linear { "stiffness_n_per_m" } else { "stiffness_nm_per_rad" };
            if let Some(what) = stiffness_fault(key, spring.stiffness) {
                self.fault(place(), key, what);
            }
            if let Some(what) = damping_fault(spring.damping) {
                self.fault(place(), "damping_ratio", what);
            }
        }
        for (index, extra) in description.extra.iter().enumerate() {
            let place = || Place::Extra(index);
            if !has_direction(&extra.axis) {
                let what = format!("axis is {}, must have a direction", triple(&extra.axis));
                self.fault(place(), "axis", what);
            }
            if !is_finite(&extra.origin_m) {
                let what = format!("origin_m is {}, must be finite", triple(&extra.origin_m));
                self.fault(place(), "origin_m", what);
            }
            if let Some(what) = stiffness_fault("stiffness", extra.stiffness) {
                self.fault(place(), "stiffness", what);
            }
            if let Some(what) = damping_fault(extra.damping) {
                self.fault(place(), "damping_ratio", what);
            }
        }
        let mut names = BTreeSet::new();
        for (place, name) in description
            .elastic_joints
            .iter()
            .map(|s| (Place::ElasticJoint(s.joint.clone()), &s.joint))
            .chain(description.extra.iter().enumerate().map(|(i, e)| (Place::Extra(i), &e.name)))
        {
            if !names.insert(name) {
                let what = format!("name '{name}' is taken by another elastic coordinate");
                self.fault(place, "name", what);
            }
        }
        let mut driven = BTreeSet::new();
        for drive in &description.drives {
            let place = || Place::Drive(drive.joint.clone());
            if !moving.contains(&drive.joint.as_str()) {
                let what = format!("the URDF has no such moving joint; it has {}", listed(&moving));
                self.fault(place(), "", what);
            }
            if !driven.insert(&drive.joint) {
                self.fault(place(), "", "given twice");
            }
            let inertia = drive.reflected_inertia_kgm2;
            if !(inertia.is_finite() && inertia >= 0.0) {
                let what = format!(
                    "reflected_inertia_kgm2 is {inertia}, must not be negative and must be finite"
                );
                self.fault(place(), "reflected_inertia_kgm2", what);
            } else if inertia > 0.0
                && !description.elastic_joints.iter().any(|s| s.joint == drive.joint)
            {
                let what = "has no effect, as the joint is rigid";
                self.notice(place(), "reflected_inertia_kgm2", what);
            }
        }
        let gravity = description.gravity_m_per_s2;
        if !is_finite(&gravity) {
            let what = format!("gravity_m_per_s2 is {}, must be finite", triple(&gravity));
            self.fault(Place::Gravity, "gravity_m_per_s2", what);
        }
    }

    /// The parent-child relations, if they form one tree.
    fn tree(&mut self) -> Option<Tree> {
        let description = self.description;
        let before = self.faults.len();
        let mut index = BTreeMap::new();
        for (i, link) in description.links.iter().enumerate() {
            if index.insert(link.name.as_str(), i).is_some() {
                self.fault(Place::Link(link.name.clone()), "name", "name is taken by another link");
            }
        }
        let mut names = BTreeSet::new();
        let mut parent_joint = vec![None; description.links.len()];
        let mut child_joints = vec![Vec::new(); description.links.len()];
        let (mut parent_link, mut child_link) = (Vec::new(), Vec::new());
        for (j, joint) in description.joints.iter().enumerate() {
            let place = || Place::Joint(joint.name.clone());
            if !names.insert(joint.name.as_str()) {
                self.fault(place(), "name", "name is taken by another joint");
            }
            let parent = index.get(joint.parent.as_str()).copied();
            let child = index.get(joint.child.as_str()).copied();
            for (key, name, found) in
                [("parent", &joint.parent, parent), ("child", &joint.child, child)]
            {
                if found.is_none() {
                    let what = format!("{key} link '{name}' does not exist");
                    self.fault(place(), key, what);
                }
            }
            parent_link.push(parent.unwrap_or(usize::MAX));
            child_link.push(child.unwrap_or(usize::MAX));
            if let (Some(parent), Some(child)) = (parent, child) {
                child_joints[parent].push(j);
                if let Some(other) = parent_joint[child].replace(j) {
                    let what = format!(
                        "link '{}' is already the child of joint '{}'; a link has one parent",
                        joint.child, description.joints[other].name
                    );
                    self.fault(place(), "child", what);
                }
            }
        }
        // A joint that hangs in the air leaves roots behind that are no faults of their own.
        if self.faults.len() > before {
            return None;
        }
        let roots: Vec<usize> =
            (0..description.links.len()).filter(|&l| parent_joint[l].is_none()).collect();
        match roots.as_slice() {
            [] if description.links.is_empty() => {
                self.fault(Place::Robot, "", "the URDF has no link");
            }
            [] => {
                self.fault(Place::Robot, "", "the joints form a loop: no link is without a parent")
            }
            [_] => {}
            [first, others @ ..] => {
                for &other in others {
                    let what = format!(
                        "a second root beside '{}'; every link but one must be the child of a joint",
                        description.links[*first].name
                    );
                    self.fault(Place::Link(description.links[other].name.clone()), "", what);
                }
            }
        }
        if self.faults.len() > before {
            return None;
        }
        let tree = Tree { parent_joint, child_joints, parent_link, child_link, root: roots[0] };
        let mut reached = vec![false; description.links.len()];
        for link in tree.from(tree.root) {
            reached[link] = true;
        }
        for (link, _) in reached.iter().enumerate().filter(|(_, reached)| !**reached) {
            let name = description.links[link].name.clone();
            self.fault(Place::Link(name), "", "is part of a loop of joints");
        }
        (self.faults.len() == before).then_some(tree)
    }

    fn link_index(&mut self, place: Place, key: &'static str, name: &str) -> Option<usize> {
        let found = self.description.links.iter().position(|link| link.name == name);
        if found.is_none() {
            let names: Vec<&str> =
                self.description.links.iter().map(|link| link.name.as_str()).collect();
            let what = format!("the URDF has no link '{name}'; it has {}", listed(&names));
            self.fault(place, key, what);
        }
        found
    }

    /// Finds the tip where none is named: the child of the last joint that moves.
    fn default_tip(&mut self, tree: &Tree, base: usize) -> Option<usize> {
        let moving: Vec<usize> = tree
            .from(base)
            .into_iter()
            .filter(|&link| {
                link != base
                    && tree.parent_joint[link]
                        .is_some_and(|j| self.description.joints[j].kind.moves())
            })
            .collect();
        let Some(&last) = moving.iter().max_by_key(|&&link| tree.path_to(link).len()) else {
            self.fault(
                Place::Tip,
                "tip",
                "no joint moves, so the tip link must be named with 'tip'",
            );
            return None;
        };
        let chain = tree.path_to(last);
        if moving.iter().any(|link| !chain.contains(link)) {
            let what = "the moving joints branch, so the tip link must be named with 'tip'";
            self.fault(Place::Tip, "tip", what);
            return None;
        }
        Some(last)
    }

    fn assemble(&mut self, tree: &Tree) -> Option<Robot> {
        let description = self.description;
        let base = match &description.base {
            Some(name) => self.link_index(Place::Base, "base", name)?,
            None => tree.root,
        };
        let tip = match &description.tip {
            Some(name) => self.link_index(Place::Tip, "tip", name)?,
            None => self.default_tip(tree, base)?,
        };
        let chain = tree.path_to(tip);
        let Some(start) = chain.iter().position(|&link| link == base) else {
            let what = format!(
                "link '{}' is not carried by the base '{}'",
                description.links[tip].name, description.links[base].name
            );
            self.fault(Place::Tip, "tip", what);
            return None;
        };
        let chain: BTreeSet<usize> = chain[start + 1..].iter().copied().collect();
        for &link in &chain {
            let Some(joint) = tree.parent_joint[link].map(|j| &description.joints[j]) else {
                continue;
            };
            let place = Place::Joint(joint.name.clone());
            if matches!(joint.kind, JointKind::Floating | JointKind::Planar) {
                let what = "type floating or planar between base and tip; a serial arm has revolute, \
                            continuous, prismatic and fixed joints";
                self.fault(place, "type", what);
            } else if let Some(other) = &joint.mimics {
                let what = format!(
                    "mimics '{other}' between base and tip; joints of the chain must be independent"
                );
                self.fault(place, "mimic", what);
            } else if joint.kind.moves()
                && joint.kind != JointKind::Continuous
                && joint.position_limit.is_none()
            {
                self.notice(place, "limit", "has no <limit>: taken as unlimited");
            }
        }

        let carried: BTreeSet<usize> = tree.from(base).into_iter().collect();
        let mut extras_of: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (i, extra) in description.extra.iter().enumerate() {
            let Some(link) = self.link_index(Place::Extra(i), "link", &extra.link) else {
                continue;
            };
            if carried.contains(&link) {
                extras_of.entry(link).or_default().push(i);
            } else {
                let what =
                    format!("link '{}' lies outside the base's part of the tree", extra.link);
                self.fault(Place::Extra(i), "link", what);
            }
        }
        let payload_link = match &description.payload {
            Some(payload) => {
                let link = self.link_index(Place::Payload, "link", &payload.link)?;
                if !carried.contains(&link) {
                    let what =
                        format!("link '{}' lies outside the base's part of the tree", payload.link);
                    self.fault(Place::Payload, "link", what);
                }
                Some(link)
            }
            None => None,
        };

        let mut assembly = Assembly {
            description,
            tree,
            chain: &chain,
            extras_of: &extras_of,
            payload_link,
            nodes: Vec::new(),
            joints: Vec::new(),
            coordinates: Vec::new(),
            place_of: vec![None; description.links.len()],
        };
        assembly.grow(base);
        let Assembly { mut nodes, joints, coordinates, place_of, .. } = assembly;
        for index in (1..nodes.len()).rev() {
            if let Some(parent) = nodes[index].parent {
                nodes[parent].subtree_mass_kg += nodes[index].subtree_mass_kg;
            }
        }
        let (tip_node, tip_offset) = place_of[tip]?;

        if coordinates.is_empty() {
            let what =
                "no elastic coordinate: list the stiffness of at least one joint under elasticity";
            self.fault(Place::Robot, "elasticity", what);
            return None;
        }
        for spring in &description.elastic_joints {
            let known = description.joints.iter().any(|j| j.name == spring.joint && j.kind.moves());
            if known && !coordinates.iter().any(|c| c.name == spring.joint) {
                let what = "lies outside the base's part of the tree";
                self.fault(Place::ElasticJoint(spring.joint.clone()), "", what);
            }
        }
        self.check_carried_mass(&nodes, &coordinates);
        self.notice_massless_links(&nodes, &place_of);

        let carriers = carriers(&nodes, &coordinates);
        let tip_carriers = (0..coordinates.len())
            .filter(|&i| ancestors(&nodes, tip_node).any(|node| node == coordinates[i].node))
            .collect();
        let moving_mass_kg = nodes
            .iter()
            .enumerate()
            .filter(|(i, _)| ancestors(&nodes, *i).any(|a| !nodes[a].coordinates.is_empty()))
            .map(|(_, node)| node.body.mass_kg)
            .sum();
        Some(Robot {
            name: description.name.clone(),
            beta1: self.angle_form("beta1", description.beta1.as_ref(), &joints),
            beta2: self.angle_form("beta2", description.beta2.as_ref(), &joints),
            carriers,
            tip_carriers,
            gravity: description.gravity_m_per_s2,
            gravity_stiffness: description.gravity_stiffness,
            tip_node,
            tip_offset,
            tip_link: description.links[tip].name.clone(),
            calibration: description.calibration,
            moving_mass_kg,
            notices: Vec::new(),
            nodes,
            joints,
            coordinates,
        })
    }

    /// A coordinate that carries no inertia at all has no finite frequency at any pose.
    fn check_carried_mass(&mut self, nodes: &[Node], coordinates: &[Coordinate]) {
        for coordinate in coordinates {
            let carries_inertia = (0..nodes.len())
                .filter(|&n| ancestors(nodes, n).any(|a| a == coordinate.node))
                .any(|n| nodes[n].body.mass_kg > 0.0);
            if carries_inertia || coordinate.drive_inertia > 0.0 {
                continue;
            }
            let extra = self.description.extra.iter().position(|e| e.name == coordinate.name);
            let place = match extra {
                Some(index) => Place::Extra(index),
                None => Place::ElasticJoint(coordinate.name.clone()),
            };
            let what = format!(
                "nothing behind '{}' has mass, so its mass matrix is singular; give link '{}' or those \
                 behind it an <inertial>, or leave the joint rigid",
                coordinate.name, coordinate.link
            );
            self.fault(place, "", what);
        }
    }

    /// A massless link with geometry, or right behind a moving joint, is more likely forgotten than meant.
    fn notice_massless_links(
        &mut self,
        nodes: &[Node],
        place_of: &[Option<(usize, Isometry3<f64>)>],
    ) {
        for (link, place) in self.description.links.iter().zip(place_of) {
            let Some((node, _)) = place else { continue };
            let vibrates = ancestors(nodes, *node).any(|a| !nodes[a].coordinates.is_empty());
            if vibrates && link.inertial.is_none() && link.has_geometry {
                let what = "has geometry but no <inertial>: counted as massless";
                self.notice(Place::Link(link.name.clone()), "inertial", what);
            }
        }
    }

    fn angle_form(
        &mut self,
        angle: &'static str,
        form: Option<&ArmAngle>,
        joints: &[MovingJoint],
    ) -> Option<AngleForm> {
        let form = form?;
        let mut terms = Vec::new();
        for (name, scale) in &form.terms {
            match joints.iter().position(|joint| joint.name == *name) {
                Some(joint) => terms.push((joint, *scale)),
                None => {
                    let names: Vec<&str> = joints.iter().map(|j| j.name.as_str()).collect();
                    let what = format!(
                        "'{name}' is not a moving joint between base and tip; these are {}",
                        listed(&names)
                    );
                    self.fault(Place::ArmAngle(angle), "terms", what);
                }
            }
            if !scale.is_finite() {
                let what = format!("factor of '{name}' is {scale}, must be finite");
                self.fault(Place::ArmAngle(angle), "terms", what);
            }
        }
        if !form.offset_rad.is_finite() {
            let what = format!("offset_rad is {}, must be finite", form.offset_rad);
            self.fault(Place::ArmAngle(angle), "offset_rad", what);
        }
        Some(AngleForm { terms, offset_rad: form.offset_rad })
    }
}

impl Tree {
    /// Links carried by `link`, itself first, parents before children, in file order.
    fn from(&self, link: usize) -> Vec<usize> {
        let mut links = vec![link];
        let mut next = 0;
        while next < links.len() {
            links.extend(self.child_joints[links[next]].iter().map(|&j| self.child_link[j]));
            next += 1;
        }
        links
    }

    /// Links from the root to `link`, both included.
    fn path_to(&self, link: usize) -> Vec<usize> {
        let mut path = vec![link];
        let mut at = link;
        while let Some(joint) = self.parent_joint[at] {
            at = self.parent_link[joint];
            path.push(at);
        }
        path.reverse();
        path
    }
}

/// The reduced tree while it grows.
struct Assembly<'a> {
    description: &'a Description,
    tree: &'a Tree,
    /// Links between base (excluded) and tip (included).
    chain: &'a BTreeSet<usize>,
    extras_of: &'a BTreeMap<usize, Vec<usize>>,
    payload_link: Option<usize>,
    nodes: Vec<Node>,
    joints: Vec<MovingJoint>,
    coordinates: Vec<Coordinate>,
    /// Node of each link, and the link's frame in the node's.
    place_of: Vec<Option<(usize, Isometry3<f64>)>>,
}

impl Assembly<'_> {
    /// Adds `base` and all that it carries, depth first so that the coordinates of a subtree are
    /// contiguous. A stack of our own: descriptions may be deep.
    fn grow(&mut self, base: usize) {
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
        let has_extras = self.extras_of.contains_key(&link);
        let place = match above {
            None => (self.open_node(None, Isometry3::identity()), Isometry3::identity()),
            Some((parent, offset, j)) => {
                let sets_pose = self.chain.contains(&link) && description.joints[j].kind.moves();
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
            let axis = Unit::new_normalize(description.joints[j].axis);
            self.coordinates.push(Coordinate {
                name: spring.joint.clone(),
                kind: if description.joints[j].kind == JointKind::Prismatic {
                    CoordinateKind::Translation
                } else {
                    CoordinateKind::Rotation
                },
                link: description.links[link].name.clone(),
                joint: self.joints.iter().position(|joint| joint.name == spring.joint),
                stiffness: spring.stiffness,
                damping: self.damping(spring.damping),
                drive_inertia: description
                    .drives
                    .iter()
                    .find(|d| d.joint == spring.joint)
                    .map_or(0.0, |d| d.reflected_inertia_kgm2),
                node,
                axis,
                origin: Point3::origin(),
            });
        }
        for &index in self.extras_of.get(&link).into_iter().flatten() {
            let extra = &description.extra[index];
            self.coordinates.push(Coordinate {
                name: extra.name.clone(),
                kind: extra.kind,
                link: extra.link.clone(),
                joint: None,
                stiffness: extra.stiffness,
                damping: self.damping(extra.damping),
                drive_inertia: 0.0,
                node,
                axis: Unit::new_normalize(extra.axis),
                origin: extra.origin_m.into(),
            });
        }
        if spring.is_some() || has_extras {
            self.nodes[node].coordinates.end = self.coordinates.len();
        }
        self.lump(node, &offset, &description.links[link]);
        if let (Some(payload), true) = (&description.payload, self.payload_link == Some(link)) {
            self.nodes[node].add_body(&payload.inertial.transformed(&offset));
        }
    }

    fn lump(&mut self, node: usize, offset: &Isometry3<f64>, link: &Link) {
        if let Some(inertial) = &link.inertial {
            self.nodes[node].add_body(&inertial.transformed(offset));
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
            fixed,
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

impl Node {
    fn add_body(&mut self, other: &Inertial) {
        self.body = self.body.combined(other);
        self.subtree_mass_kg += other.mass_kg;
    }
}

impl Inertial {
    /// A body without mass.
    pub(super) fn none() -> Self {
        Self { mass_kg: 0.0, com_m: Vector3::zeros(), inertia_kgm2: Matrix3::zeros() }
    }

    /// The same body seen from the frame in which its own frame is `pose`.
    pub(super) fn transformed(&self, pose: &Isometry3<f64>) -> Self {
        let r = pose.rotation.to_rotation_matrix();
        Self {
            mass_kg: self.mass_kg,
            com_m: pose.transform_point(&self.com_m.into()).coords,
            inertia_kgm2: r * self.inertia_kgm2 * r.transpose(),
        }
    }

    /// Two bodies of the same frame as one.
    pub(super) fn combined(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        if mass_kg == 0.0 {
            return Self { inertia_kgm2: self.inertia_kgm2 + other.inertia_kgm2, ..*self };
        }
        let apart = other.com_m - self.com_m;
        let reduced = self.mass_kg * other.mass_kg / mass_kg;
        Self {
            mass_kg,
            com_m: self.com_m + apart * (other.mass_kg / mass_kg),
            inertia_kgm2: self.inertia_kgm2 + other.inertia_kgm2 + point_inertia(reduced, &apart),
        }
    }
}

/// Inertia of a point mass at `r` about the origin: m (r·r 1 − r rᵀ).
pub(super) fn point_inertia(mass: f64, r: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(mass * r.norm_squared()) - mass * r * r.transpose()
}

/// For each coordinate, those that carry it, itself last.
fn carriers(nodes: &[Node], coordinates: &[Coordinate]) -> Vec<Vec<usize>> {
    coordinates
        .iter()
        .enumerate()
        .map(|(j, coordinate)| {
            (0..=j)
                .filter(|&i| {
                    ancestors(nodes, coordinate.node).any(|node| node == coordinates[i].node)
                })
                .collect()
        })
        .collect()
}

/// `node` and all nodes that carry it, outwards in.
fn ancestors(nodes: &[Node], node: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(Some(node), |&n| nodes[n].parent)
}

fn has_direction(axis: &Vector3<f64>) -> bool {
    is_finite(axis) && axis.norm() > SHORTEST_AXIS
}

fn is_finite(v: &Vector3<f64>) -> bool {
    v.iter().all(|x| x.is_finite())
}

fn triple(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

/// A few names for a message.
fn listed(names: &[&str]) -> String {
    const SHOWN: usize = 12;
    let mut text = names.iter().take(SHOWN).copied().collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        text.push_str(", …");
    }
    if text.is_empty() { "none".to_owned() } else { text }
}

fn stiffness_fault(key: &str, stiffness: f64) -> Option<String> {
    (!(stiffness.is_finite() && stiffness > 0.0))
        .then(|| format!("{key} is {stiffness}, must be positive and finite"))
}

fn damping_fault(damping: Option<Damping>) -> Option<String> {
    match damping? {
        Damping::Ratio(zeta) if !(zeta.is_finite() && zeta > 0.0 && zeta < 1.0) => {
            Some(format!("damping_ratio is {zeta}, must lie between 0 and 1"))
        }
        Damping::Viscous(c) if !(c.is_finite() && c > 0.0) => {
            Some(format!("damping is {c}, must be positive and finite"))
        }
        Damping::Ratio(_) | Damping::Viscous(_) => None,
    }
}

/// What makes mass properties impossible: (key, fragment).
fn inertial_faults(inertial: &Inertial) -> Vec<(&'static str, String)> {
    let mut faults = Vec::new();
    let m = inertial.mass_kg;
    let com = inertial.com_m;
    let inertia = inertial.inertia_kgm2;
    if !m.is_finite() || m < 0.0 {
        faults.push(("mass", format!("mass is {m} kg, must not be negative and must be finite")));
    }
    if !is_finite(&com) {
        let what = format!("centre of mass is {}, must be finite", triple(&com));
        faults.push(("com", what));
    }
    if !inertia.iter().all(|x| x.is_finite()) {
        faults.push(("inertia", "inertia must be finite".to_owned()));
        return faults;
    }
    let mut moments: [f64; 3] = inertia.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    let [smallest, middle, largest] = moments;
    if m == 0.0 && largest.abs().max(smallest.abs()) > 0.0 {
        faults.push(("mass", "mass is 0 but the inertia is not".to_owned()));
    }
    if smallest < -POSITIVITY_SLACK * largest.abs() {
        let what = format!(
            "inertia is not positive: principal moments {smallest:.4e}, {middle:.4e}, {largest:.4e} kg·m²"
        );
        faults.push(("inertia", what));
    } else if smallest + middle < largest * (1.0 - TRIANGLE_SLACK) {
        let (ixx, iyy, izz) = (inertia[(0, 0)], inertia[(1, 1)], inertia[(2, 2)]);
        let diagonal = inertia == Matrix3::from_diagonal(&inertia.diagonal());
        let sum = if diagonal {
            triangle_by_axis([ixx, iyy, izz])
        } else {
            format!("principal moments {smallest:.4} + {middle:.4} < {largest:.4} kg·m²")
        };
        let what = format!(
            "inertia fails the triangle inequality ({sum}); check the units of the CAD export"
        );
        faults.push(("inertia", what));
    }
    faults
}

fn triangle_by_axis(diagonal: [f64; 3]) -> String {
    let names = ["ixx", "iyy", "izz"];
    let largest = if diagonal[0] > diagonal[1].max(diagonal[2]) {
        0
    } else if diagonal[1] > diagonal[2] {
        1
    } else {
        2
    };
    let (a, b) = ((largest + 1) % 3, (largest + 2) % 3);
    let (a, b) = (a.min(b), a.max(b));
    format!(
        "{} {} + {} {} < {} {} kg·m²",
        names[a], diagonal[a], names[b], diagonal[b], names[largest], diagonal[largest]
    )
}
