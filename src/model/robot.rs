//! The immutable model of one robot: bodies that move against each other, joints, elastic
//! coordinates.

use std::fmt;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Unit, Vector3};

use super::cause::Cause;
use super::correction::{Conditions, SpringState, StiffnessLaw};
use super::description::{
    Calibration, CoordinateKind, Damping, Description, Inertial, JointKind, Mesh, Payload,
};
use super::frame::Frame;
use super::pose_fault::PoseFault;
use super::posterior::ParameterKind;
use crate::notes::Note;
use crate::units::{deg_from_rad, mm_from_m};
use crate::wording::distinguishable;

/// A pose may pass a limit by this much, rad or m: URDFs print limits with four or five digits
/// (3.1416 for half a turn), and a pose at the limit itself is meant to be allowed.
pub(super) const LIMIT_SLACK: f64 = 1e-4;

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

impl MovingJoint {
    /// Whether the joint may stand at `value` (rad or m): limits in files are rounded, so a hair
    /// beyond them counts as within.
    pub fn allows(&self, value: f64) -> bool {
        self.limit.is_none_or(|[lower, upper]| {
            (lower - LIMIT_SLACK..=upper + LIMIT_SLACK).contains(&value)
        })
    }

    /// How `value` (rad or m) is outside the limits; `None` for one that is allowed.
    pub fn violation(&self, value: f64) -> Option<LimitViolation<'_>> {
        let limit = self.limit.filter(|_| !self.allows(value))?;
        Some(LimitViolation { joint: self, value, limit })
    }
}

/// A joint outside its limits. Shown as "joint 'a' is 190.000 deg, must lie in -180.000..180.000
/// deg".
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
        let name = &self.joint.name;
        let value = shown(self.value);
        let [lower, upper] = self.limit.map(shown);
        let [below, lower] = distinguishable(value, lower, 3);
        let [above, upper] = distinguishable(value, upper, 3);
        // The limit that is passed decides how many digits the value needs.
        let value = if above.len() > below.len() { above } else { below };
        write!(f, "joint '{name}' is {value} {unit}, must lie in {lower}..{upper} {unit}")
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
    /// Whether it is that of a part that a correction hangs on the arm.
    pub is_hung: bool,
    /// The moving joint whose spring this is; `None` for an extra coordinate.
    pub joint: Option<usize>,
    /// Spring constant, N·m/rad or N/m.
    pub stiffness: f64,
    /// What the spring constant may be off by, as the files say: one standard deviation of its
    /// natural logarithm.
    pub std: Option<f64>,
    /// How the spring departs from its constant, one factor each.
    pub laws: Vec<StiffnessLaw>,
    /// Loss.
    pub damping: Damping,
    /// Reflected rotor inertia on the coordinate's own diagonal of M, kg·m² or kg.
    pub drive_inertia: f64,
    /// What the rotor inertia may be off by, likewise.
    pub drive_std: Option<f64>,
    pub(crate) node: usize,
    /// In the node's frame.
    pub(crate) axis: Unit<Vector3<f64>>,
    /// In the node's frame.
    pub(crate) origin: Point3<f64>,
}

impl Coordinate {
    /// The spring's constant in a state.
    pub(super) fn stiffness_under(&self, state: SpringState, conditions: &Conditions) -> f64 {
        let shares = self.laws.iter().map(|law| law.share(state, conditions));
        self.stiffness * shares.product::<f64>()
    }

    /// The spring's constant at rest and at room temperature, N·m/rad or N/m; `None` if it follows
    /// the pose.
    pub(crate) fn stiffness_of_all_poses(&self) -> Option<f64> {
        let follows_pose = self.laws.iter().any(StiffnessLaw::follows_pose);
        let at_rest = SpringState { gravity_torque_nm: 0.0, position: 0.0 };
        (!follows_pose).then(|| self.stiffness_under(at_rest, &Conditions::default()))
    }
}

/// A spring that feels α_own + ratio · α_other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Coupling {
    pub(crate) own: usize,
    pub(crate) other: usize,
    pub(crate) ratio: f64,
}

/// What moves a node against its parent when the pose changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum NodeMotion {
    Fixed,
    Revolute { joint: usize, axis: Unit<Vector3<f64>> },
    Prismatic { joint: usize, axis: Unit<Vector3<f64>> },
}

/// A body of the reduced tree: all links that never move against each other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Node {
    pub(crate) parent: Option<usize>,
    /// This node's frame in the parent's at q = 0, α = 0.
    pub(crate) fixed: Frame,
    pub(crate) motion: NodeMotion,
    /// Elastic coordinates of this node: indices into [`Robot::coordinates`], outermost first.
    pub(crate) coordinates: std::ops::Range<usize>,
    /// Lumped mass properties in the node's frame.
    pub(crate) body: Inertial,
    /// Mass of this node and all that it carries.
    pub(crate) subtree_mass_kg: f64,
}

/// A body of the model with what it may be off by: a link, or the payload.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainBody {
    /// The link that it belongs to.
    pub link: String,
    /// The body of the reduced tree that it is part of: an index into the robot's nodes.
    pub(crate) node: usize,
    /// Whether it is the payload that hangs on the link.
    pub is_payload: bool,
    /// In that node's frame.
    pub body: Inertial,
    /// Whether mass and inertia are distributed from the mass of the whole arm.
    pub assumed: bool,
    /// What mass and inertia may be off by, together, as the files say: one standard deviation of
    /// their natural logarithm.
    pub std: Option<f64>,
}

/// A mesh that shows a link, and the body of the reduced tree that it moves with.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedMesh {
    /// The link.
    pub link: String,
    pub(crate) node: usize,
    /// Where it is found; its frame is given in the node's.
    pub mesh: Mesh,
}

/// An angle of the two-link model: Σ scale·q + offset.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleForm {
    pub(super) terms: Vec<(usize, f64)>,
    pub(super) offset_rad: f64,
}

impl AngleForm {
    /// The angle at pose `q`, rad.
    pub fn at(&self, q: &[f64]) -> f64 {
        self.terms.iter().map(|&(joint, scale)| scale * q[joint]).sum::<f64>() + self.offset_rad
    }

    /// Each joint that has a say, with its factor.
    pub fn terms(&self) -> impl Iterator<Item = (usize, f64)> {
        self.terms.iter().copied().filter(|(_, scale)| *scale != 0.0)
    }
}

/// The checked, immutable model of one robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    pub(super) name: String,
    pub(super) nodes: Vec<Node>,
    pub(super) bodies: Vec<UncertainBody>,
    pub(super) meshes: Arc<[PlacedMesh]>,
    pub(super) joints: Vec<MovingJoint>,
    pub(super) coordinates: Vec<Coordinate>,
    /// Springs that also feel another coordinate.
    pub(super) couplings: Vec<Coupling>,
    /// For each coordinate j, the coordinates i ≤ j that carry it (j itself last).
    pub(super) carriers: Vec<Vec<usize>>,
    /// Gravity in the base frame, m/s².
    pub(super) gravity: Vector3<f64>,
    pub(super) gravity_stiffness: bool,
    pub(super) tip_node: usize,
    /// The coordinates that move the tip.
    pub(super) tip_carriers: Vec<usize>,
    /// Tip frame in its node's frame.
    pub(super) tip_offset: Isometry3<f64>,
    pub(super) tip_link: String,
    pub(super) beta1: Option<AngleForm>,
    pub(super) beta2: Option<AngleForm>,
    pub(super) carried: Option<Payload>,
    pub(super) calibration: Option<Calibration>,
    pub(super) moving_mass_kg: f64,
    pub(super) warnings: Vec<Note>,
}

impl Robot {
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

    /// The reduced tree, parents before children; the first node stands on the ground.
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Every link with mass, and the payload, after corrections.
    pub fn bodies(&self) -> &[UncertainBody] {
        &self.bodies
    }

    /// The meshes that show its links.
    pub fn meshes(&self) -> &[PlacedMesh] {
        &self.meshes
    }

    /// The elastic coordinates that move a body.
    pub fn carriers_of(&self, body: &UncertainBody) -> Vec<usize> {
        let mut carriers = Vec::new();
        let mut node = Some(body.node);
        while let Some(at) = node {
            carriers.extend(self.nodes[at].coordinates.clone());
            node = self.nodes[at].parent;
        }
        carriers
    }

    /// The node that carries the tip, and the tip frame in the node's frame.
    pub(crate) fn tip(&self) -> (usize, &Isometry3<f64>) {
        (self.tip_node, &self.tip_offset)
    }

    /// Gravity in the base frame, m/s².
    pub(crate) fn gravity_m_per_s2(&self) -> &Vector3<f64> {
        &self.gravity
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

    /// What the tip carries beside the robot's own links: the payload of the description, if it is
    /// fixed to the body that the tip belongs to.
    pub fn carried(&self) -> Option<&Payload> {
        self.carried.as_ref()
    }

    /// Mass of what the tip carries beside the robot's own links, kg: the payload of the
    /// description of this robot, `own`, and what corrections put on the tip's body; `None` where
    /// neither is.
    pub fn carried_kg(&self, own: &Description) -> Option<f64> {
        let payload_kg = self.carried.as_ref().map(|payload| payload.inertial.mass_kg);
        let bare = self.without_carried_corrections(own);
        if bare.corrections.len() == own.corrections.len() {
            return payload_kg;
        }
        let of_links = |description: &Description| -> Option<f64> {
            let corrected = description.corrected().ok()?;
            let bodies = corrected.links.iter().filter_map(|link| link.inertial);
            Some(bodies.map(|body| body.mass_kg).sum())
        };
        Some(payload_kg.unwrap_or(0.0) + of_links(own)? - of_links(&bare)?)
    }

    /// Mass of the parts with a natural frequency of their own that corrections hang on the tip's
    /// body, kg.
    pub fn hung_kg(&self, own: &Description) -> f64 {
        let parts = own.corrections.iter().filter(|correction| {
            correction.cause == Cause::LocalMode
                && correction.at.as_deref().is_some_and(|at| self.is_at_tip(at))
        });
        parts.filter_map(|part| part.value("mass_kg")).sum()
    }

    /// Whether a link belongs to the tip's body.
    fn is_at_tip(&self, link: &str) -> bool {
        let mut here = self.bodies.iter().filter(|body| body.node == self.tip_node);
        link == self.tip_link || here.any(|body| body.link == link)
    }

    /// Whether corrections hang parts on the arm, each on a spring of its own.
    pub(crate) fn has_hung_parts(&self) -> bool {
        self.coordinates.iter().any(|coordinate| coordinate.is_hung)
    }

    /// `own` without the payloads that corrections put on the tip's body, and without what was
    /// learned of a link that is nothing but such a payload.
    fn without_carried_corrections(&self, own: &Description) -> Description {
        let is_massless = |link: &str| {
            own.links.iter().any(|other| other.name == link && other.inertial.is_none())
        };
        let mut description = own.clone();
        description.corrections.retain(|correction| {
            let at = correction.at.as_deref().filter(|at| self.is_at_tip(at));
            !at.is_some_and(|at| match correction.cause {
                Cause::Payload => true,
                Cause::LinkInertia | Cause::ComOffset => is_massless(at),
                // What a tool or load is heavy by, and nothing else, goes with it.
                _ => false,
            })
        });
        if description.corrections.len() < own.corrections.len()
            && let Some(calibration) = &mut description.calibration
            && let Some(posterior) = &mut calibration.posterior
        {
            posterior.retain(|learned| {
                learned.kind != ParameterKind::Link
                    || !(self.is_at_tip(&learned.at) && is_massless(&learned.at))
            });
        }
        description
    }

    /// The description of this robot, `own`, with another body at the tip, in the tip frame,
    /// instead of what the tip carries.
    pub fn description_carrying(&self, own: &Description, body: Option<Inertial>) -> Description {
        let mut description = self.without_carried_corrections(own);
        let elsewhere = description.payload.take().filter(|_| self.carried.is_none());
        // A payload elsewhere on the arm stays there.
        if let Some(payload) = elsewhere
            && let Some(link) = description.links.iter_mut().find(|l| l.name == payload.link)
        {
            let together = |own: Inertial| own.combined(&payload.inertial);
            link.inertial = Some(link.inertial.map_or(payload.inertial, together));
        }
        description.payload =
            body.map(|inertial| Payload { link: self.tip_link.clone(), inertial });
        description
    }

    /// How well the model is known to predict; `None` if it never was compared.
    pub fn calibration(&self) -> Option<&Calibration> {
        self.calibration.as_ref()
    }

    /// Whether K holds the geometric stiffness of gravity.
    pub fn has_gravity_stiffness(&self) -> bool {
        self.gravity_stiffness
    }

    /// Whether K holds more than its diagonal.
    pub fn has_coupled_stiffness(&self) -> bool {
        self.gravity_stiffness || !self.couplings.is_empty()
    }

    /// Springs that also feel another coordinate.
    pub(crate) fn couplings(&self) -> &[Coupling] {
        &self.couplings
    }

    /// The coordinates whose deflections the spring of coordinate `i` feels, each with its share:
    /// its own, and those that it is coupled with.
    pub(crate) fn felt_by(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let coupled = self.couplings.iter().filter(move |coupling| coupling.own == i);
        std::iter::once((i, 1.0)).chain(coupled.map(|coupling| (coupling.other, coupling.ratio)))
    }

    /// Mass of everything that the first elastic coordinates carry, payload included, kg.
    pub fn moving_mass_kg(&self) -> f64 {
        self.moving_mass_kg
    }

    /// Whether frames and elastic axes are those of `other` at every pose.
    pub(crate) fn stands_like(&self, other: &Self) -> bool {
        let nodes = self.nodes.iter().zip(&other.nodes);
        let coordinates = self.coordinates.iter().zip(&other.coordinates);
        self.nodes.len() == other.nodes.len()
            && self.coordinates.len() == other.coordinates.len()
            && nodes.into_iter().all(|(a, b)| {
                a.parent == b.parent
                    && a.fixed == b.fixed
                    && a.motion == b.motion
                    && a.coordinates == b.coordinates
            })
            && coordinates.into_iter().all(|(a, b)| {
                a.kind == b.kind && a.node == b.node && a.axis == b.axis && a.origin == b.origin
            })
    }

    /// Whether its bodies are those of `other`, node by node.
    pub(crate) fn weighs_like(&self, other: &Self) -> bool {
        self.nodes.len() == other.nodes.len()
            && self.nodes.iter().zip(&other.nodes).all(|(a, b)| a.body == b.body)
    }

    /// Warnings: settings without effect, joints without limits, links that count as massless.
    pub fn warnings(&self) -> &[Note] {
        &self.warnings
    }

    /// The joints that `q` puts outside their limits; none for a joint without limits.
    pub fn limit_violations<'a>(
        &'a self,
        q: &'a [f64],
    ) -> impl Iterator<Item = LimitViolation<'a>> + 'a {
        self.joints.iter().zip(q).filter_map(|(joint, &value)| joint.violation(value))
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

impl Node {
    pub(super) fn add_body(&mut self, other: &Inertial) {
        self.body = self.body.combined(other);
        self.subtree_mass_kg += other.mass_kg;
    }
}

/// `node` and all nodes that carry it, outwards in.
pub(super) fn ancestors(nodes: &[Node], node: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(Some(node), |&n| nodes[n].parent)
}
