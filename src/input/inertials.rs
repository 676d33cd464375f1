//! The links of a robot: the URDF's, with the mass properties that robot.yaml gives in their place.

use nalgebra::{Matrix3, Vector3};

use super::raw::robot as raw;
use crate::formats::yaml::{Node, Step};
use crate::model::{Inertial, Link};
use crate::notes::{Code, Notes};
use crate::units::ratio_from_percent;
use crate::wording::hint;

const KEYS: [&str; 3] = ["mass_kg", "com_m", "inertia_kgm2"];

/// The URDF's links with `inertials` put in.
pub(super) fn links(raw: &raw::Robot, tree: &Node, urdf: &[Link], notes: &mut Notes) -> Vec<Link> {
    let mut links = urdf.to_vec();
    for (name, given) in raw.inertials.iter().flatten() {
        let line = tree.line_at(&[Step::Key("inertials"), Step::Key(name)]);
        let Some(link) = links.iter_mut().find(|link| link.name == *name) else {
            let hint = hint(name, urdf.iter().map(|link| link.name.as_str()));
            let what = format!("inertials: the URDF has no link '{name}'{hint}");
            notes.error(Code::Reference, line, what);
            continue;
        };
        link.std = given.std_percent.map(ratio_from_percent);
        let node = tree.at(&[Step::Key("inertials"), Step::Key(name)]);
        let absent = |key: &&str| node.is_none_or(|node| node.get(key).is_none());
        let missing: Vec<&str> = KEYS.into_iter().filter(absent).collect();
        // Its mass comes out of that of the whole arm.
        if missing.len() == KEYS.len() && raw.total_mass_kg.is_some() {
            continue;
        }
        if link.inertial.is_none() && !missing.is_empty() {
            let what = format!(
                "link '{name}': its inertial has no {}, and the URDF has no <inertial> to take it \
                 from",
                missing.join(", ")
            );
            notes.error(Code::MissingKey, line, what);
            continue;
        }
        let body = link.inertial.get_or_insert(STAND_IN);
        body.mass_kg = given.mass_kg.unwrap_or(body.mass_kg);
        body.com_m = given.com_m.map_or(body.com_m, Vector3::from);
        let inertia = given.inertia_kgm2.as_ref().and_then(tensor);
        body.inertia_kgm2 = inertia.unwrap_or(body.inertia_kgm2);
    }
    links
}

/// A body without a fault of its own, for values that have one.
const STAND_IN: Inertial =
    Inertial { mass_kg: 1.0, com_m: Vector3::new(0.0, 0.0, 0.0), inertia_kgm2: UNIT };
const UNIT: Matrix3<f64> = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);

/// A tensor of inertia as it is written; `None` where a moment is missing.
pub(super) fn tensor(raw: &raw::Inertia) -> Option<Matrix3<f64>> {
    let [ixy, ixz, iyz] = [raw.ixy, raw.ixz, raw.iyz].map(|product| product.unwrap_or(0.0));
    let (ixx, iyy, izz) = (raw.ixx?, raw.iyy?, raw.izz?);
    Some(Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::robot::read_robot;
    use super::super::robot::tests::{URDF, YAML, folder};
    use super::*;
    use crate::input::Reading;
    use crate::model::Robot;

    fn load(yaml: &str) -> Result<Robot, Vec<String>> {
        let (folder, path) = folder(yaml, URDF);
        let prefix = format!("{}/", folder.path().display());
        read_robot(&path, &mut Reading::default())
            .map_err(|notes| notes.iter().map(|n| n.to_string().replace(&prefix, "")).collect())
    }

    /// Mass, first and second moment about the origin of the node, which simply add up.
    #[test]
    fn the_bodies_of_a_node_make_its_body() {
        let path = Path::new("robots/rail-mill/robot.yaml");
        let robot = read_robot(path, &mut Reading::default()).unwrap();
        let moments = |body: &Inertial| {
            let (m, c) = (body.mass_kg, body.com_m);
            let about_origin =
                body.inertia_kgm2 + (Matrix3::identity() * c.dot(&c) - c * c.transpose()) * m;
            (m, c * m, about_origin)
        };
        let mut shared = 0;
        for (index, node) in robot.nodes().iter().enumerate() {
            let own: Vec<_> = robot.bodies().iter().filter(|body| body.node == index).collect();
            shared += usize::from(own.len() > 1);
            let (mass, first, second) = moments(&node.body);
            let sum = own
                .iter()
                .map(|body| moments(&body.body))
                .fold((0.0, Vector3::zeros(), Matrix3::zeros()), |a, b| {
                    (a.0 + b.0, a.1 + b.1, a.2 + b.2)
                });
            assert!((sum.0 - mass).abs() <= 1e-12 * mass, "{index}");
            assert!((sum.1 - first).norm() <= 1e-12 * (1.0 + first.norm()), "{index}");
            assert!((sum.2 - second).norm() <= 1e-12 * (1.0 + second.norm()), "{index}");
        }
        assert!(shared > 0 && robot.bodies().iter().any(|body| body.body.mass_kg == 85.0));
    }

    #[test]
    fn robot_yaml_says_what_its_numbers_may_be_off_by() {
        let yaml = YAML
            .replace("stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: 555000, std_percent: 8")
            .replace("reflected_inertia_kgm2: 0.0", "reflected_inertia_kgm2: 2, std_percent: 40")
            + "inertials:\n  link_2: {mass_kg: 60, std_percent: 15}\n";
        let robot = load(&yaml).unwrap();
        let before = load(YAML).unwrap();
        let stds: Vec<_> = robot.coordinates().iter().map(|c| (c.std, c.drive_std)).collect();
        assert_eq!(stds, [(Some(0.08), Some(0.4)), (None, None)]);
        let body = |robot: &Robot| {
            let found = robot.bodies().iter().find(|body| body.link == "link_2").unwrap();
            (found.std, found.body)
        };
        let (none, was) = body(&before);
        assert_eq!(none, None);
        assert_eq!(body(&robot), (Some(0.15), Inertial { mass_kg: 60.0, ..was }));
    }

    #[test]
    fn faults_of_inertials_and_deviations_have_their_lines() {
        let inertials = "inertials:\n  link_1:\n    mass_kg: -3\n    std_percent: 120\n  \
                         base_link: {mass_kg: 5}\n  lnk_2: {mass_kg: 5}\n  link_2:\n    \
                         inertia_kgm2: {ixx: 1, iyy: 1, izz: 9}\n";
        let first = 1 + YAML.lines().count();
        let notes = load(&format!("{YAML}{inertials}")).unwrap_err();
        let at = |line: usize, what: &str| format!("robot.yaml:{}: {what}", first + line);
        let expected = [
            at(2, "link 'link_1': mass_kg is -3, must be a finite number, not negative"),
            at(3, "link 'link_1': std_percent is 120, must be a number from 0 to 100"),
            at(
                4,
                "link 'base_link': its inertial has no com_m, inertia_kgm2, and the URDF has no \
                 <inertial> to take it from",
            ),
            at(5, "inertials: the URDF has no link 'lnk_2'; did you mean 'link_2'?"),
            at(
                7,
                "link 'link_2': inertia fails the triangle inequality (ixx 1 + iyy 1 < izz 9 \
                 kg·m²); check the units of the CAD export",
            ),
        ];
        assert_eq!(notes, expected);
    }
}
