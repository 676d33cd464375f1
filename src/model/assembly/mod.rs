//! From a description to the immutable model: checks, then the reduced tree of bodies that move
//! against each other.

mod bodies;
mod checks;
mod tree;

use nalgebra::Isometry3;

use self::bodies::Bodies;
use self::tree::Tree;
use super::description::{ArmAngle, Description, JointKind};
use super::robot::{AngleForm, Coordinate, Coupling, MovingJoint, Node, Robot, ancestors};
use crate::model::cause::Cause;
use crate::notes::{Code, Note, Part, Place};
use crate::wording::hint;

/// Elastic coordinates, at most: six joints, each of them soft about three axes, a foundation and a
/// few links have 30.
const MAX_COORDINATES: usize = 100;

/// Factors and offsets of arm angles beyond this are typing errors, and would overflow.
const MAX_OF_ANGLE: f64 = 1e6;

impl Robot {
    /// Checks a description and builds the model.
    ///
    /// # Errors
    /// Every error of the description, each with the part that it is about.
    pub fn new(description: &Description) -> Result<Self, Vec<Note>> {
        let learned = description.calibration.as_ref().is_some_and(|own| own.posterior.is_some());
        if description.corrections.is_empty() && !learned {
            return Builder::new(description).build();
        }
        let mut faults = description.correction_faults();
        let built = description.corrected().and_then(|corrected| {
            if !faults.is_empty() {
                return Err(Vec::new());
            }
            let robot = Builder::new(&corrected).build()?;
            let misplaced = misplaced(description, robot.coordinates());
            if misplaced.is_empty() { Ok(robot) } else { Err(misplaced) }
        });
        built.map_err(|errors| {
            let known: Vec<_> = faults.iter().map(|fault| fault.place.part.clone()).collect();
            faults.extend(errors.into_iter().filter(|error| !known.contains(&error.place.part)));
            // Errors of the files themselves are reported in their terms.
            let bare = Description { corrections: Vec::new(), ..description.clone() };
            Builder::new(&bare).build().err().unwrap_or(faults)
        })
    }

    /// The model of a description that nobody needs any more; `None` if there is none.
    pub(crate) fn of(description: Description) -> Option<Self> {
        let corrected = description.into_corrected().ok()?;
        Builder::new(&corrected).build().ok()
    }
}

/// A description, and the errors and warnings found so far.
struct Builder<'a> {
    description: &'a Description,
    errors: Vec<Note>,
    warnings: Vec<Note>,
}

impl<'a> Builder<'a> {
    fn new(description: &'a Description) -> Self {
        Self { description, errors: Vec::new(), warnings: Vec::new() }
    }

    fn error(&mut self, code: Code, part: Part, key: &'static str, what: impl Into<String>) {
        self.errors.push(Note::error(code, Place::key(part, key), what));
    }

    fn warning(&mut self, code: Code, part: Part, key: &'static str, what: impl Into<String>) {
        self.warnings.push(Note::warning(code, Place::key(part, key), what));
    }

    fn build(mut self) -> Result<Robot, Vec<Note>> {
        let springs = self.description.extra.len() + self.description.elastic_joints.len();
        if springs > MAX_COORDINATES {
            let what = format!(
                "{springs} elastic coordinates, must be at most {MAX_COORDINATES}: the time for a \
                 pose grows with their cube"
            );
            self.error(Code::TooLong, Part::Robot, "elasticity", what);
            return Err(self.errors);
        }
        self.check_inertias();
        self.check_axes();
        self.check_springs();
        let robot = self.tree().and_then(|tree| self.assemble(&tree));
        match robot {
            Some(robot) if self.errors.is_empty() => Ok(Robot { warnings: self.warnings, ..robot }),
            _ => {
                if self.errors.is_empty() {
                    self.error(Code::Value, Part::Robot, "", "the robot could not be assembled");
                }
                Err(self.errors)
            }
        }
    }

    fn link_index(&mut self, part: Part, key: &'static str, name: &str) -> Option<usize> {
        let found = self.description.links.iter().position(|link| link.name == name);
        if found.is_none() {
            let names: Vec<&str> =
                self.description.links.iter().map(|link| link.name.as_str()).collect();
            let hint = hint(name, names.iter().copied());
            let what = format!("the URDF has no link '{name}'; it has {}{hint}", listed(&names));
            self.error(Code::Reference, part, key, what);
        }
        found
    }

    /// Finds the tip where none is named: the child of the last joint that moves.
    fn default_tip(&mut self, tree: &Tree, base: usize) -> Option<usize> {
        let carried = tree.from(base);
        // Parents come before their children.
        let mut depths = vec![0; self.description.links.len()];
        for &link in carried.iter().skip(1) {
            if let Some(joint) = tree.parent_joint[link] {
                depths[link] = depths[tree.parent_link[joint]] + 1;
            }
        }
        let moving: Vec<usize> = carried
            .into_iter()
            .filter(|&link| {
                link != base
                    && tree.parent_joint[link]
                        .is_some_and(|j| self.description.joints[j].kind.moves())
            })
            .collect();
        let Some(&last) = moving.iter().max_by_key(|&&link| depths[link]) else {
            self.error(
                Code::Tree,
                Part::Tip,
                "tip",
                "no joint moves, so the tip link must be named with 'tip'",
            );
            return None;
        };
        let chain = self.marked(&tree.path_to(last));
        if moving.iter().any(|&link| !chain[link]) {
            let what = "the moving joints branch, so the tip link must be named with 'tip'";
            self.error(Code::Tree, Part::Tip, "tip", what);
            return None;
        }
        Some(last)
    }

    /// By link: whether it is between base (excluded) and tip (included).
    fn chain(&mut self, tree: &Tree, base: usize, tip: usize) -> Option<Vec<bool>> {
        let description = self.description;
        let chain = tree.path_to(tip);
        let Some(start) = chain.iter().position(|&link| link == base) else {
            let what = format!(
                "link '{}' is not carried by the base '{}'",
                description.links[tip].name, description.links[base].name
            );
            self.error(Code::Tree, Part::Tip, "tip", what);
            return None;
        };
        let chain = self.marked(&chain[start + 1..]);
        for link in (0..chain.len()).filter(|&link| chain[link]) {
            let Some(joint) = tree.parent_joint[link].map(|j| &description.joints[j]) else {
                continue;
            };
            let part = Part::Joint(joint.name.clone());
            if matches!(joint.kind, JointKind::Floating | JointKind::Planar) {
                let what = "type floating or planar between base and tip; a serial arm has \
                            revolute, continuous, prismatic and fixed joints";
                self.error(Code::Tree, part, "type", what);
            } else if let Some(other) = &joint.mimics {
                let what = format!(
                    "mimics '{other}' between base and tip; joints of the chain must be independent"
                );
                self.error(Code::Tree, part, "mimic", what);
            } else if joint.kind.moves()
                && joint.kind != JointKind::Continuous
                && joint.position_limit.is_none()
            {
                self.warning(
                    Code::Assumed,
                    part,
                    "limit",
                    "has no <limit> with lower and upper: taken as unlimited",
                );
            }
        }
        Some(chain)
    }

    /// By link: whether it is one of these.
    fn marked(&self, links: &[usize]) -> Vec<bool> {
        let mut marked = vec![false; self.description.links.len()];
        links.iter().for_each(|&link| marked[link] = true);
        marked
    }

    /// Indices of the extra coordinates of each link that the base carries.
    fn extras_of(&mut self, carried: &[bool]) -> Vec<Vec<usize>> {
        let mut extras_of = vec![Vec::new(); carried.len()];
        for (i, extra) in self.description.extra.iter().enumerate() {
            let Some(link) = self.link_index(Part::Extra(i), "link", &extra.link) else {
                continue;
            };
            if carried[link] {
                extras_of[link].push(i);
            } else {
                let what =
                    format!("link '{}' lies outside the base's part of the tree", extra.link);
                self.error(Code::Tree, Part::Extra(i), "link", what);
            }
        }
        extras_of
    }

    /// Every spring moves something that the base carries.
    fn check_springs_are_carried(&mut self, coordinates: &[Coordinate]) {
        let description = self.description;
        for spring in &description.elastic_joints {
            let known = description.joints.iter().any(|j| j.name == spring.joint && j.kind.moves());
            if known && !coordinates.iter().any(|c| c.name == spring.joint) {
                let what = "lies outside the base's part of the tree";
                self.error(Code::Tree, Part::ElasticJoint(spring.joint.clone()), "", what);
            }
        }
    }

    fn assemble(&mut self, tree: &Tree) -> Option<Robot> {
        let description = self.description;
        let base = match &description.base {
            Some(name) => self.link_index(Part::Base, "base", name)?,
            None => tree.root,
        };
        let tip = match &description.tip {
            Some(name) => self.link_index(Part::Tip, "tip", name)?,
            None => self.default_tip(tree, base)?,
        };
        let chain = self.chain(tree, base, tip)?;
        let carried = self.marked(&tree.from(base));
        let extras_of = self.extras_of(&carried);
        let payload_link = match &description.payload {
            Some(payload) => {
                let link = self.link_index(Part::Payload, "link", &payload.link)?;
                if !carried[link] {
                    let what =
                        format!("link '{}' lies outside the base's part of the tree", payload.link);
                    self.error(Code::Tree, Part::Payload, "link", what);
                }
                Some(link)
            }
            None => None,
        };

        let mut bodies = Bodies {
            description,
            tree,
            chain: &chain,
            extras_of: &extras_of,
            payload_link,
            nodes: Vec::new(),
            bodies: Vec::new(),
            meshes: Vec::new(),
            joints: Vec::new(),
            coordinates: Vec::new(),
            place_of: vec![None; description.links.len()],
        };
        bodies.grow(base);
        let Bodies { mut nodes, bodies, meshes, joints, coordinates, place_of, .. } = bodies;
        add_up_masses(&mut nodes);
        let (tip_node, tip_offset) = place_of[tip]?;

        if coordinates.is_empty() {
            let what =
                "no elastic coordinate: list the stiffness of at least one joint under elasticity";
            self.error(Code::NotElastic, Part::Robot, "elasticity", what);
            return None;
        }
        self.check_springs_are_carried(&coordinates);
        self.check_carried_mass(&nodes, &coordinates);
        self.warn_of_massless_links(&nodes, &place_of);

        let couplings = couplings(description, &coordinates);
        let carriers = carriers(&nodes, &coordinates);
        let tip_carriers = carriers_of(&nodes, tip_node);
        Some(Robot {
            name: description.name.clone(),
            beta1: self.angle_form("beta1", description.beta1.as_ref(), &joints),
            beta2: self.angle_form("beta2", description.beta2.as_ref(), &joints),
            carriers,
            couplings,
            tip_carriers,
            gravity: description.gravity_m_per_s2,
            gravity_stiffness: description.gravity_stiffness,
            tip_node,
            tip_offset,
            tip_link: description.links[tip].name.clone(),
            carried: payload_link
                .filter(|&link| place_of[link].is_some_and(|(node, _)| node == tip_node))
                .and(description.payload.clone()),
            calibration: description.calibration.clone(),
            moving_mass_kg: moving_mass_kg(&nodes),
            warnings: Vec::new(),
            nodes,
            bodies,
            meshes: meshes.into(),
            joints,
            coordinates,
        })
    }

    /// A coordinate that carries no inertia at all has no finite frequency at any pose.
    fn check_carried_mass(&mut self, nodes: &[Node], coordinates: &[Coordinate]) {
        for coordinate in coordinates {
            let carries_inertia = nodes[coordinate.node].subtree_mass_kg > 0.0;
            if carries_inertia || coordinate.drive_inertia > 0.0 {
                continue;
            }
            let extra = self.description.extra.iter().position(|e| e.name == coordinate.name);
            let part = match extra {
                Some(index) => Part::Extra(index),
                None => Part::ElasticJoint(coordinate.name.clone()),
            };
            let what = format!(
                "nothing behind '{}' has mass, so its mass matrix is singular; give link '{}' or \
                 those behind it an <inertial>, or leave the joint rigid",
                coordinate.name, coordinate.link
            );
            self.error(Code::NotElastic, part, "", what);
        }
    }

    /// A link without inertial that has geometry, or that a joint moves with nothing on it that has
    /// mass, is more likely forgotten than meant.
    fn warn_of_massless_links(
        &mut self,
        nodes: &[Node],
        place_of: &[Option<(usize, Isometry3<f64>)>],
    ) {
        for (link, place) in self.description.links.iter().zip(place_of) {
            let Some((node, _)) = place else { continue };
            let vibrates = || ancestors(nodes, *node).any(|a| !nodes[a].coordinates.is_empty());
            if link.inertial.is_some() || !vibrates() {
                continue;
            }
            let is_moved =
                || self.description.joints.iter().any(|j| j.child == link.name && j.kind.moves());
            let what = if link.has_geometry {
                "has geometry but no <inertial>: counted as massless"
            } else if nodes[*node].body.mass_kg == 0.0 && is_moved() {
                "has no <inertial>, and nothing fixed to it has mass: counted as massless"
            } else {
                continue;
            };
            self.warning(Code::Massless, Part::Link(link.name.clone()), "inertial", what);
        }
    }

    fn angle_form(
        &mut self,
        angle: &'static str,
        form: Option<&ArmAngle>,
        joints: &[MovingJoint],
    ) -> Option<AngleForm> {
        let form = form?;
        let bounded = |value: f64| value.abs() <= MAX_OF_ANGLE;
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
                    self.error(Code::Reference, Part::ArmAngle(angle), "terms", what);
                }
            }
            if !bounded(*scale) {
                let what = format!(
                    "factor of '{name}' is {scale}, must be from -{MAX_OF_ANGLE} to {MAX_OF_ANGLE}"
                );
                self.error(Code::Value, Part::ArmAngle(angle), "terms", what);
            }
        }
        if !bounded(form.offset_rad) {
            let what = format!(
                "offset_rad is {}, must be from -{MAX_OF_ANGLE} to {MAX_OF_ANGLE}",
                form.offset_rad
            );
            self.error(Code::Value, Part::ArmAngle(angle), "offset_rad", what);
        }
        Some(AngleForm { terms, offset_rad: form.offset_rad })
    }
}

/// Adds to the mass of each node that of all that it carries.
fn add_up_masses(nodes: &mut [Node]) {
    for index in (1..nodes.len()).rev() {
        if let Some(parent) = nodes[index].parent {
            nodes[parent].subtree_mass_kg += nodes[index].subtree_mass_kg;
        }
    }
}

/// What any coordinate moves.
fn moving_mass_kg(nodes: &[Node]) -> f64 {
    nodes
        .iter()
        .enumerate()
        .filter(|(i, _)| ancestors(nodes, *i).any(|a| !nodes[a].coordinates.is_empty()))
        .map(|(_, node)| node.body.mass_kg)
        .sum()
}

/// For each coordinate, those that carry it, itself last.
fn carriers(nodes: &[Node], coordinates: &[Coordinate]) -> Vec<Vec<usize>> {
    let own = coordinates.iter().enumerate().map(|(j, coordinate)| {
        let mut carriers = carriers_of(nodes, coordinate.node);
        // Those of its own node that come after it are carried by it.
        carriers.retain(|&i| i <= j);
        carriers
    });
    own.collect()
}

/// The coordinates that move a node, ascending.
fn carriers_of(nodes: &[Node], node: usize) -> Vec<usize> {
    let mut carriers: Vec<usize> =
        ancestors(nodes, node).flat_map(|above| nodes[above].coordinates.clone()).collect();
    carriers.sort_unstable();
    carriers
}

/// The springs that the corrections couple, each with that of the elastic joint before.
fn couplings(description: &Description, coordinates: &[Coordinate]) -> Vec<Coupling> {
    let own = description.corrections.iter().filter(|c| c.cause == Cause::JointCoupling);
    own.filter_map(|correction| {
        let [own, other] = coupled_at(correction.at.as_deref()?, coordinates)?;
        Some(Coupling { own, other, ratio: correction.value("ratio")? })
    })
    .collect()
}

/// Corrections at a place that the arm does not have: a coupling needs an elastic joint before its
/// own, and a mode is one of the arm's.
fn misplaced(description: &Description, coordinates: &[Coordinate]) -> Vec<Note> {
    let modes = coordinates.len();
    let is_mode = |at: &str| at.parse().is_ok_and(|mode: usize| (1..=modes).contains(&mode));
    let mut faults = Vec::new();
    for (index, correction) in description.corrections.iter().enumerate() {
        let at = correction.at.as_deref().unwrap_or_default();
        let expected = if correction.cause.is_of_the_instrument() && !is_mode(at) {
            format!("the number of a mode, from 1 to {modes}")
        } else if correction.cause == Cause::JointCoupling && coupled_at(at, coordinates).is_none()
        {
            "one elastic joint with another before it".to_owned()
        } else {
            continue;
        };
        let what = format!("at is '{at}', must be {expected}");
        faults.push(Note::error(Code::Value, Place::key(Part::Correction(index), "at"), what));
    }
    faults
}

/// The coordinates of a joint's spring and of that of the elastic joint before.
fn coupled_at(joint: &str, coordinates: &[Coordinate]) -> Option<[usize; 2]> {
    let own = coordinates.iter().position(|c| c.joint.is_some() && c.name == joint)?;
    let other = coordinates[..own].iter().rposition(|c| c.joint.is_some())?;
    Some([own, other])
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
