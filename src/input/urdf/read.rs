//! An audited URDF → links and joints in SI.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use urdf_rs::{Geometry, JointType};

use super::super::frame::frame;
use super::audit::{Audit, JointFacts, Lines, LinkFacts, audit};
use crate::formats::text::read_text;
use crate::model::{Inertial, Joint, JointKind, Link, Mesh};
use crate::notes::{Code, Notes};

/// A limit beyond this is drawn in to it, rad or m: no arm gets there, exporters write 1e16 or the
/// largest of all numbers for "unlimited", and the width between two limits must not overflow.
const FAR: f64 = 1e9;

/// A velocity limit beyond this, rad/s or m/s, stands for "unlimited", as zero does for "not
/// given".
const MAX_VELOCITY: f64 = 1e4;

/// What a URDF holds, and where.
#[derive(Debug)]
pub(in crate::input) struct Urdf {
    pub(in crate::input) name: Option<String>,
    pub(in crate::input) links: Vec<Link>,
    pub(in crate::input) joints: Vec<Joint>,
    /// A link or joint had to be left out, so the tree is not the one that was meant.
    pub(in crate::input) damaged: bool,
    line: usize,
    link_lines: Vec<Lines>,
    joint_lines: Vec<Lines>,
}

impl Urdf {
    /// The line of the robot element.
    pub(in crate::input) fn line(&self) -> usize {
        self.line
    }

    /// The line of a part of a link. Of two links of one name, a fault about the name means the
    /// last.
    pub(in crate::input) fn link_line(&self, name: &str, part: &str) -> usize {
        let names = self.links.iter().map(|link| link.name.as_str());
        self.line_of(names, &self.link_lines, name, part)
    }

    /// The line of a part of a joint, likewise.
    pub(in crate::input) fn joint_line(&self, name: &str, part: &str) -> usize {
        let names = self.joints.iter().map(|joint| joint.name.as_str());
        self.line_of(names, &self.joint_lines, name, part)
    }

    fn line_of<'n>(
        &self,
        mut names: impl DoubleEndedIterator<Item = &'n str> + ExactSizeIterator,
        lines: &[Lines],
        name: &str,
        part: &str,
    ) -> usize {
        let found = if part == "name" {
            names.rposition(|other| other == name)
        } else {
            names.position(|other| other == name)
        };
        found.and_then(|index| lines.get(index)).map_or(self.line, |lines| lines.of(part))
    }
}

/// Reads a URDF. Faults that leave the rest readable go to `faults`; the first that does not is the
/// error.
pub(in crate::input) fn read_urdf(path: &Path, notes: &mut Notes) -> Option<Urdf> {
    // Meshes lie in files of their own, so real ones stay below 1 MB.
    let text = read_text(path, 4 << 20).map_err(|note| notes.push(note)).ok()?;
    let audit = audit(&text, notes)?;
    let robot = urdf_rs::read_from_string(&audit.plain)
        .map_err(|error| {
            let what = format!("cannot be read as URDF: {error}");
            notes.error(Code::Syntax, audit.line, what);
        })
        .ok()?;
    if robot.links.len() != audit.links.len() || robot.joints.len() != audit.joints.len() {
        let what = "cannot be read as URDF: links or joints were lost";
        notes.error(Code::Syntax, audit.line, what);
        return None;
    }
    let Audit { name, line, links: link_facts, joints: joint_facts, damaged, .. } = audit;
    Some(Urdf {
        name,
        links: robot.links.iter().zip(&link_facts).map(|(l, facts)| link(l, facts, path)).collect(),
        joints: robot.joints.iter().zip(&joint_facts).map(|(j, facts)| joint(j, facts)).collect(),
        damaged,
        line,
        link_lines: link_facts.into_iter().map(|facts| facts.lines).collect(),
        joint_lines: joint_facts.into_iter().map(|facts| facts.lines).collect(),
    })
}

fn link(link: &urdf_rs::Link, facts: &LinkFacts, urdf: &Path) -> Link {
    let inertial = facts.has_inertial.then(|| {
        let urdf_rs::Inertial { origin, mass, inertia } = &link.inertial;
        let pose = frame(*origin.xyz, *origin.rpy);
        let turn = pose.rotation.to_rotation_matrix();
        let own = Matrix3::new(
            inertia.ixx,
            inertia.ixy,
            inertia.ixz, //
            inertia.ixy,
            inertia.iyy,
            inertia.iyz, //
            inertia.ixz,
            inertia.iyz,
            inertia.izz,
        );
        // Without a turn the numbers stay as they were written, so that messages can quote them.
        let level = origin.rpy.iter().all(|&angle| angle == 0.0);
        Inertial {
            mass_kg: mass.value,
            com_m: pose.translation.vector,
            inertia_kgm2: if level { own } else { turn * own * turn.transpose() },
        }
    });
    let solids = link.collision.iter().filter_map(|part| {
        let solid = match &part.geometry {
            Geometry::Box { size } => Inertial::cuboid(**size),
            Geometry::Cylinder { radius, length } => Inertial::cylinder(*radius, *length),
            Geometry::Sphere { radius } => Inertial::sphere(*radius),
            Geometry::Capsule { .. } | Geometry::Mesh { .. } => return None,
        };
        Some(solid.transformed(&frame(*part.origin.xyz, *part.origin.rpy)))
    });
    let shape = solids.reduce(|a, b| a.combined(&b));
    Link {
        name: facts.name.clone(),
        inertial,
        has_geometry: facts.has_geometry,
        shape,
        meshes: link.visual.iter().filter_map(|visual| mesh(visual, urdf)).collect(),
        ..Link::default()
    }
}

fn mesh(visual: &urdf_rs::Visual, urdf: &Path) -> Option<Mesh> {
    let Geometry::Mesh { filename, scale } = &visual.geometry else { return None };
    Some(Mesh {
        file: filename.clone(),
        beside: urdf.parent().map(Path::to_owned).unwrap_or_default(),
        frame: frame(*visual.origin.xyz, *visual.origin.rpy),
        scale: scale.map_or([1.0; 3], |scale| *scale),
    })
}

fn joint(joint: &urdf_rs::Joint, facts: &JointFacts) -> Joint {
    let urdf_rs::JointLimit { lower, upper, velocity, .. } = joint.limit;
    Joint {
        name: facts.name.clone(),
        kind: match joint.joint_type {
            JointType::Revolute => JointKind::Revolute,
            JointType::Continuous => JointKind::Continuous,
            JointType::Prismatic => JointKind::Prismatic,
            JointType::Fixed => JointKind::Fixed,
            JointType::Planar => JointKind::Planar,
            // Neither has a place between base and tip.
            JointType::Floating | JointType::Spherical => JointKind::Floating,
        },
        parent: facts.parent.clone(),
        child: facts.child.clone(),
        origin: frame(*joint.origin.xyz, *joint.origin.rpy),
        axis: Vector3::from(*joint.axis.xyz),
        position_limit: facts.has_position_limit.then(|| [lower.max(-FAR), upper.min(FAR)]),
        velocity_limit: (velocity != 0.0 && velocity <= MAX_VELOCITY).then_some(velocity),
        mimics: facts.mimics.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notes::{Note, Place};

    fn read(text: &str) -> (Option<Urdf>, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.urdf");
        std::fs::write(&path, text).unwrap();
        let mut notes = Notes::about(Place::file(Path::new("a.urdf")));
        let urdf = read_urdf(&path, &mut notes);
        (urdf, notes.finish().0.iter().map(Note::to_string).collect())
    }

    #[test]
    fn missing_blocks_are_not_zero_and_have_the_standard_s_meaning() {
        let (urdf, notes) = read(
            "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"><visual><geometry><mesh \
             filename=\"package://x/y.stl\"/></geometry></visual></link>\n<joint name=\"j\" \
             type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/></joint><gazebo/></robot>",
        );
        let urdf = urdf.unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        assert!(urdf.links[1].inertial.is_none() && urdf.links[1].has_geometry);
        assert!(!urdf.links[0].has_geometry);
        let [mesh] = &*urdf.links[1].meshes else { panic!("{:?}", urdf.links[1].meshes) };
        assert_eq!((mesh.file.as_str(), mesh.scale), ("package://x/y.stl", [1.0; 3]));
        let joint = &urdf.joints[0];
        assert_eq!(joint.axis, Vector3::x());
        assert_eq!((joint.position_limit, joint.velocity_limit), (None, None));
        assert_eq!((urdf.joint_line("j", "axis"), urdf.link_line("a", "mass")), (2, 1));
    }

    #[test]
    fn a_limit_that_is_not_given_is_zero_and_a_huge_one_is_drawn_in() {
        let limit = |attributes: &str| {
            let (urdf, notes) = read(&format!(
                "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/><joint name=\"j\" \
                 type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><limit \
                 {attributes}/></joint>\
                 </robot>"
            ));
            assert!(notes.is_empty(), "{notes:?}");
            urdf.unwrap().joints[0].position_limit
        };
        assert_eq!(limit("upper=\"2\" velocity=\"1\" effort=\"1\""), Some([0.0, 2.0]));
        assert_eq!(limit("lower=\"-2\" velocity=\"1\" effort=\"1\""), Some([-2.0, 0.0]));
        let huge = limit("lower=\"-1.7e308\" upper=\"1.7e308\" velocity=\"1\" effort=\"1\"");
        assert_eq!(huge, Some([-FAR, FAR]));
    }

    #[test]
    fn inertia_is_turned_into_the_link_s_axes() {
        let (urdf, notes) = read(
            "<robot name=\"r\"><link name=\"a\"><inertial><origin xyz=\"1 2 3\" rpy=\"0 0 \
             1.5707963267948966\"/><mass value=\"2\"/><inertia ixx=\"1\" iyy=\"1.5\" izz=\"2\" \
             ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link></robot>",
        );
        let inertial = urdf.unwrap().links[0].inertial.unwrap();
        assert!(notes.is_empty());
        let expected = Matrix3::from_diagonal(&Vector3::new(1.5, 1.0, 2.0));
        assert!((inertial.inertia_kgm2 - expected).norm() < 1e-15);
        assert_eq!((inertial.mass_kg, inertial.com_m), (2.0, Vector3::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn every_faulty_number_and_missing_part_is_told_at_once() {
        let (urdf, notes) = read(
            "<robot name=\"r\">\n<link name=\"a\">\n<inertial>\n<origin xyz=\"0 abc 0 1\"/>\n<mass \
             value=\"NaN\"/>\n<inertia ixx=\"1\" iyy=\"inf\" izz=\"1\" ixy=\"0\" ixz=\"0\"/>\n\
             </inertial></link>\n<link/>\n<joint name=\"j\" type=\"ball\">\n<child \
             link=\"a\"/>\n<axis \
             xyz=\"0 0\"/>\n<limit lower=\"${x}\" upper=\"1\"/>\n</joint></robot>",
        );
        assert_eq!(
            notes,
            [
                "a.urdf:4: link 'a': <origin> xyz is \"0 abc 0 1\", must be 3 finite numbers",
                "a.urdf:5: link 'a': <mass> value is \"NaN\", must be a finite number",
                "a.urdf:6: link 'a': <inertia> iyy is \"inf\", must be a finite number",
                "a.urdf:6: link 'a': <inertia> has no iyz",
                "a.urdf:8: <link> has no name",
                "a.urdf:9: joint 'j': type is 'ball', must be one of revolute, continuous, \
                    prismatic, fixed, floating, planar, spherical",
                "a.urdf:9: joint 'j': has no <parent link=\"…\"/>",
                "a.urdf:11: joint 'j': <axis> xyz is \"0 0\", must be 3 finite numbers",
                "a.urdf:12: joint 'j': <limit> lower is \"${x}\", must be a finite number; it is \
                 unexpanded xacro; run 'xacro robot.xacro > robot.urdf' and name the result",
            ]
        );
        assert!(urdf.unwrap().damaged);
    }

    #[test]
    fn what_is_no_urdf_is_told_with_its_line() {
        for (text, expected) in [
            ("", "a.urdf:1: not valid XML"),
            ("<robot>\n<link name=\"a\">\n</robot>", "a.urdf:3: not valid XML"),
            ("<sdf/>", "a.urdf:1: root element is <sdf>"),
            ("<robot>\n<xacro:macro name=\"a\"/></robot>", "a.urdf:2: is unexpanded xacro"),
            (
                "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\">\n<xacro:include/></robot>",
                "a.urdf:2: is unexpanded xacro",
            ),
            (
                "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n\n<xacro:arg/></robot>",
                "a.urdf:3: is unexpanded xacro",
            ),
            ("<!DOCTYPE x [<!ENTITY a \"b\">]>\n<robot/>", "a.urdf:1: not valid XML"),
        ] {
            let (urdf, notes) = read(text);
            assert!(urdf.is_none() && notes[0].starts_with(expected), "{notes:?}");
        }
    }

    #[test]
    fn deep_nesting_does_not_exhaust_the_stack() {
        let depth = 200_000;
        let text = format!(
            "<robot name=\"r\"><link name=\"a\">{}{}</link></robot>",
            "<v>".repeat(depth),
            "</v>".repeat(depth)
        );
        let (urdf, _) = read(&text);
        assert_eq!(urdf.unwrap().links.len(), 1);
    }
}
