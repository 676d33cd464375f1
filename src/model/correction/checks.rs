//! What makes no physical sense in a correction: units that are not the joint's, shares of springs
//! below zero, laws that cannot be. What a diagnosis writes passes, whatever its signs.

use super::ALL_JOINTS;
use crate::model::cause::Cause;
use crate::model::description::{Carries, Correction, Description, Hinge, JointKind};
use crate::notes::{Code, Note, Part, Place};

impl Description {
    /// Every correction that makes no sense, each with the key at fault.
    pub(in crate::model) fn correction_faults(&self) -> Vec<Note> {
        let mut faults = Vec::new();
        for (index, correction) in self.corrections.iter().enumerate() {
            let mut check = Check { description: self, correction, found: Vec::new() };
            check.run();
            // Parts that hang on one link are told apart.
            let is_same = |own: &Correction| {
                own.cause != Cause::LocalMode
                    && own.hinge.is_some()
                    && (own.cause, &own.at) == (correction.cause, &correction.at)
            };
            let before = self.corrections[..index].iter().position(is_same);
            if let Some(before) = before.filter(|_| correction.hinge.is_some()) {
                check.refuse(
                    "at",
                    format!(
                        "correction {} is {} there already: put the axes of both into one, or use \
                         elasticity: extra for more",
                        before + 1,
                        correction.cause
                    ),
                );
            }
            faults.extend(check.found.into_iter().map(|(key, what)| {
                Note::error(Code::Value, Place::key(Part::Correction(index), key), what)
            }));
        }
        faults
    }
}

/// One correction, and the keys at fault with what is to be said of them.
struct Check<'a> {
    description: &'a Description,
    correction: &'a Correction,
    found: Vec<(&'static str, String)>,
}

impl Check<'_> {
    fn run(&mut self) {
        if self.correction.hinge.as_ref().is_some_and(|hinge| hinge.axes.is_empty()) {
            self.refuse("axes", "axes is empty, must have one or more".to_owned());
        }
        match self.correction.cause {
            Cause::JointStiffness => {
                self.fits_joint(["stiffness_nm_per_rad", "stiffness_n_per_m"]);
                self.all_positive();
            }
            Cause::JointZeroOffset => self.fits_joint(["offset_rad", "offset_m"]),
            Cause::LinkInertia | Cause::DriveInertia => {
                let names = Correction::parameter_names(self.correction.cause);
                names.iter().for_each(|name| self.not_negative(name));
            }
            Cause::Payload => self.not_negative("gyration_m"),
            Cause::BaseCompliance | Cause::TransverseCompliance | Cause::LinkFlexibility => {
                let names = Correction::parameter_names(self.correction.cause);
                let scales = |name: &&&str| name.contains("stiffness") || name.contains("ratio");
                names.iter().filter(scales).for_each(|name| self.positive(name));
                self.share("position");
                self.leaves_the_tip();
                self.bends_over_length();
            }
            Cause::LocalMode => {
                ["frequency_hz", "mass_kg"].into_iter().for_each(|name| self.positive(name));
                if self.correction.hinge.as_ref().is_some_and(Hinge::turns) {
                    self.refuse("kind", "kind is rotation, must be translation".to_owned());
                }
                let carries = self.correction.hinge.as_ref().map(|hinge| hinge.carries);
                if carries == Some(Carries::Rest) {
                    let what = "carries is rest, must be link (the part is beside the link's \
                                mass) or part (it is in it)";
                    self.refuse("carries", what.to_owned());
                }
                let of_a_place = ["mass_kg", "com_x_m", "com_y_m", "com_z_m"];
                for name in of_a_place.into_iter().filter(|_| self.correction.at.is_none()) {
                    if let Some(value) = self.value(name) {
                        let what = format!("{name} is {value}, must be absent without 'at'");
                        self.refuse(name, what);
                    }
                }
            }
            Cause::LoadDependentStiffness => {
                self.turns("the law is of a torque");
                let names = ["factor", "saturation_nm", "ratio_1", "ratio_3"];
                names.into_iter().for_each(|name| self.positive(name));
                self.positive("torque_1_nm");
                self.not_negative("reference_nm");
                let torques = ["torque_1_nm", "torque_2_nm"].map(|name| self.value(name));
                if let [Some(first), Some(second)] = torques
                    && (second.is_nan() || second <= first)
                {
                    let what =
                        format!("torque_2_nm is {second}, must be above torque_1_nm, {first}");
                    self.refuse("torque_2_nm", what);
                }
            }
            Cause::AmplitudeDependence => {
                self.positive("factor");
                if self.value("exponent").is_some() {
                    self.positive("reference_nm");
                } else {
                    self.not_negative("reference_nm");
                }
            }
            Cause::TemperatureDrift => self.positive("factor"),
            Cause::PositionDependentStiffness => {
                self.turns("the law is a wave of its angle");
                self.positive("factor");
                if self.correction.parameters.is_empty() {
                    let names = Correction::parameter_names(self.correction.cause).join(", ");
                    self.refuse(
                        "parameters",
                        format!("has no parameters, must have one of {names}"),
                    );
                }
            }
            Cause::GravityStiffness => {
                if let Some(at) = &self.correction.at {
                    let what = format!("at is '{at}', must be absent: gravity pulls the whole arm");
                    self.refuse("at", what);
                }
            }
            Cause::AliasedMode => self.positive("sample_rate_hz"),
            Cause::MissedMode => self.share("share"),
            // Any value has a sense; the place of a coupling is held against the chain of joints.
            Cause::ComOffset | Cause::JointCoupling => {}
        }
    }

    fn value(&self, name: &str) -> Option<f64> {
        self.correction.value(name)
    }

    fn refuse(&mut self, key: &'static str, what: String) {
        self.found.push((key, what));
    }

    fn all_positive(&mut self) {
        let names = Correction::parameter_names(self.correction.cause);
        names.iter().for_each(|name| self.positive(name));
    }

    fn positive(&mut self, name: &'static str) {
        if let Some(value) = self.value(name).filter(|value| value.is_nan() || *value <= 0.0) {
            self.refuse(name, format!("{name} is {value}, must be positive"));
        }
    }

    fn not_negative(&mut self, name: &'static str) {
        if let Some(value) = self.value(name).filter(|value| value.is_nan() || *value < 0.0) {
            self.refuse(name, format!("{name} is {value}, must not be negative"));
        }
    }

    fn share(&mut self, name: &'static str) {
        if let Some(value) = self.value(name).filter(|value| !(0.0..=1.0).contains(value)) {
            self.refuse(name, format!("{name} is {value}, must be from 0 to 1"));
        }
    }

    /// A hinge within the tip's own link would leave the tool behind, which stands on the frame of
    /// that link.
    fn leaves_the_tip(&mut self) {
        let carries = self.correction.hinge.as_ref().map(|hinge| hinge.carries);
        let Some(at) = self.correction.at.as_deref() else { return };
        let of_joint = self.description.joints.iter().find(|joint| joint.name == at);
        let is_joint = self.correction.cause == Cause::TransverseCompliance;
        let link = of_joint.filter(|_| is_joint).map_or(at, |joint| joint.child.as_str());
        if carries.is_some_and(|carries| carries != Carries::Link) && self.may_be_tip(link) {
            let what = "at is the tip's link, whose tool would not move with the hinge: set \
                        carries: link, or add a link fixed to its end to the URDF and make that \
                        the tip";
            self.refuse("at", what.to_owned());
        }
    }

    /// Whether a link is the tip, or where none is named one of the farthest that a joint moves.
    fn may_be_tip(&self, link: &str) -> bool {
        let Description { tip, joints, .. } = self.description;
        if let Some(tip) = tip {
            return tip == link;
        }
        let parent = |of: &&str| {
            let joint = joints.iter().find(|joint| joint.child == **of);
            joint.map(|joint| joint.parent.as_str())
        };
        // Of a tree with a circle no more than its joints.
        let depth = |of: &str| {
            std::iter::successors(Some(of), |at| parent(at)).take(joints.len() + 1).count()
        };
        let moved = || joints.iter().filter(|joint| joint.kind.moves()).map(|j| j.child.as_str());
        moved().any(|own| own == link) && moved().map(depth).max() == Some(depth(link))
    }

    /// A length over which a link bends, about its middle: compliance is nowhere below zero, and
    /// the link's body lies there.
    fn bends_over_length(&mut self) {
        const LEAST: f64 = 0.2;
        let Some(length) = self.value("length") else { return };
        if !(LEAST..=1.0).contains(&length) {
            return self.refuse("length", format!("length is {length}, must be from {LEAST} to 1"));
        }
        let [low, high] = [-1.0, 1.0].map(|side| 0.5 + side * length / 6.0);
        if let Some(position) = self.value("position").filter(|at| !(low..=high).contains(at)) {
            let what = format!(
                "position is {position}, must be from {low:.3} to {high:.3} with length {length}: \
                 it is the middle of a compliance that is nowhere below zero"
            );
            self.refuse("position", what);
        }
        let carries = self.correction.hinge.as_ref().map_or(Carries::Link, |hinge| hinge.carries);
        if carries != Carries::Part {
            let what = format!(
                "carries is {}, must be part with a length: the link's body bends, too",
                carries.name()
            );
            self.refuse("carries", what);
        }
        let at = self.correction.at.as_deref();
        let link = self.description.links.iter().find(|link| Some(link.name.as_str()) == at);
        if let Some(link) = link
            && link.inertial.is_none_or(|body| body.mass_kg <= 0.0)
        {
            let what =
                format!("'{}' has no mass to bend over a length: leave length out", link.name);
            self.refuse("length", what);
        }
    }

    /// The names of the moving joints that the correction is about, each with whether it slides.
    fn joints(&self) -> impl Iterator<Item = (&str, bool)> {
        let at = self.correction.at.as_deref().unwrap_or_default();
        let is_elastic =
            |name: &str| self.description.elastic_joints.iter().any(|own| own.joint == name);
        let joints = self.description.joints.iter().filter(|joint| joint.kind.moves());
        joints
            .filter(move |joint| joint.name == at || at == ALL_JOINTS && is_elastic(&joint.name))
            .map(|joint| (joint.name.as_str(), joint.kind == JointKind::Prismatic))
    }

    /// The parameter of a joint that turns, or else of one that slides, is the other's.
    fn fits_joint(&mut self, [of_turning, of_sliding]: [&'static str; 2]) {
        let found: Vec<(&'static str, String)> = self
            .joints()
            .filter_map(|(joint, slides)| {
                let (wrong, right, kind) = if slides {
                    (of_turning, of_sliding, "is prismatic")
                } else {
                    (of_sliding, of_turning, "turns")
                };
                let value = self.value(wrong)?;
                let what =
                    format!("{wrong} is {value}, must be {right}, as joint '{joint}' {kind}");
                Some((wrong, what))
            })
            .collect();
        self.found.extend(found);
    }

    /// No joint that it is about slides.
    fn turns(&mut self, why: &str) {
        let sliding = self.joints().find(|(_, slides)| *slides);
        let what = sliding.map(|(joint, _)| {
            let at = self.correction.at.as_deref().unwrap_or_default();
            format!("at is '{at}', must be a joint that turns, as {why}; '{joint}' slides")
        });
        if let Some(what) = what {
            self.refuse("at", what);
        }
    }
}
