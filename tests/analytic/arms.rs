//! Arms that several tests share.

use crate::two_link::{TwoLink, TwoLinkGravity};
use detune::model::{ArmAngle, Description, ElasticJoint, Inertial, Joint, JointKind, Link, Robot};
use detune::units::STANDARD_GRAVITY_M_PER_S2;
use nalgebra::{Isometry3, Matrix3, Vector3};

/// A second arm without Table 1's coincidences.
pub(crate) const OTHER: TwoLink = TwoLink {
    link1_inertia_kgm2: 3.1,
    link2_inertia_kgm2: 0.7,
    link2_mass_kg: 31.0,
    link1_length_m: 0.7,
    link2_com_m: 0.28,
    stiffness_nm_per_rad: [410_000.0, 92_000.0],
};

/// Link 1 as a body: Table 1 has only its I_A. A slender rod from A to B with that I_A has the mass
/// 3 I_A / l1², its centre of mass halfway, a twelfth of m l1² across and next to nothing along.
pub(crate) fn link_1(arm: &TwoLink) -> Inertial {
    let mass_kg = 3.0 * arm.link1_inertia_kgm2 / arm.link1_length_m.powi(2);
    let across = mass_kg * arm.link1_length_m.powi(2) / 12.0;
    Inertial {
        mass_kg,
        com_m: Vector3::new(0.5 * arm.link1_length_m, 0.0, 0.0),
        inertia_kgm2: Matrix3::from_diagonal(&Vector3::new(0.01 * across, across, across)),
    }
}

pub(crate) fn gravity(arm: &TwoLink) -> TwoLinkGravity {
    let rod = link_1(arm);
    TwoLinkGravity {
        link1_first_moment_kgm: rod.mass_kg * rod.com_m.x,
        gravity_m_per_s2: STANDARD_GRAVITY_M_PER_S2,
    }
}

/// The arm in the x–z plane, x forward and z up: an angle that is counter-clockwise in the paper's x–y
/// plane turns about −y here. Link 2 is a ball of I_S2: any tensor with I_S2 about y would do.
pub(crate) fn two_link_arm(arm: &TwoLink, with_gravity: bool) -> Robot {
    let joint = |name: &str, parent: &str, child: &str, x: f64| Joint {
        name: name.into(),
        kind: JointKind::Revolute,
        parent: parent.into(),
        child: child.into(),
        origin: Isometry3::translation(x, 0.0, 0.0),
        axis: -Vector3::y(),
        position_limit: None,
        velocity_limit: None,
        mimics: None,
    };
    let link = |name: &str, inertial| Link { name: name.into(), inertial, ..Link::default() };
    let spring = |name: &str, stiffness| ElasticJoint {
        joint: name.into(),
        stiffness,
        is_linear: false,
        std: None,
        damping: None,
    };
    let angle = |joint: &str| Some(ArmAngle { terms: vec![(joint.into(), 1.0)], offset_rad: 0.0 });
    let description = Description {
        name: "two-link arm".into(),
        links: vec![
            link("base", None),
            link("link_1", Some(link_1(arm))),
            link(
                "link_2",
                Some(Inertial {
                    mass_kg: arm.link2_mass_kg,
                    com_m: Vector3::new(arm.link2_com_m, 0.0, 0.0),
                    inertia_kgm2: Matrix3::identity() * arm.link2_inertia_kgm2,
                }),
            ),
        ],
        joints: vec![
            joint("joint_1", "base", "link_1", 0.0),
            joint("joint_2", "link_1", "link_2", arm.link1_length_m),
        ],
        base: None,
        tip: None,
        elastic_joints: vec![
            spring("joint_1", arm.stiffness_nm_per_rad[0]),
            spring("joint_2", arm.stiffness_nm_per_rad[1]),
        ],
        extra: vec![],
        default_damping_ratio: 0.02,
        gravity_m_per_s2: Vector3::new(0.0, 0.0, -STANDARD_GRAVITY_M_PER_S2),
        gravity_stiffness: with_gravity,
        drives: vec![],
        payload: None,
        beta1: angle("joint_1"),
        beta2: angle("joint_2"),
        calibration: None,
        corrections: vec![],
    };
    Robot::new(&description).unwrap()
}

/// Six axes with the geometry of an ABB IRB 1600-10/1.45 (ros-industrial abb_irb1600_support); masses,
/// inertias and wrist stiffnesses are assumed, of a plausible size. `with_gravity` switches K_g on.
pub(crate) fn six_axis_arm(with_gravity: bool) -> Robot {
    let joint = |i: usize, xyz: [f64; 3], axis: Vector3<f64>| Joint {
        name: format!("joint_{i}"),
        kind: JointKind::Revolute,
        parent: if i == 1 { "base_link".into() } else { format!("link_{}", i - 1) },
        child: format!("link_{i}"),
        origin: Isometry3::translation(xyz[0], xyz[1], xyz[2]),
        axis,
        position_limit: None,
        velocity_limit: None,
        mimics: None,
    };
    let link = |i: usize, mass_kg: f64, com: [f64; 3], diagonal: [f64; 3]| Link {
        name: format!("link_{i}"),
        inertial: Some(Inertial {
            mass_kg,
            com_m: Vector3::from(com),
            inertia_kgm2: Matrix3::from_diagonal(&Vector3::from(diagonal)),
        }),
        has_geometry: true,
        ..Link::default()
    };
    let springs = [1.2e6, 555e3, 138e3, 60e3, 45e3, 25e3];
    let description = Description {
        name: "six axes".into(),
        links: vec![
            Link { name: "base_link".into(), inertial: None, ..Link::default() },
            link(1, 70.0, [0.05, 0.01, 0.3], [1.9, 2.1, 1.4]),
            link(2, 42.0, [0.0, -0.12, 0.32], [2.6, 2.5, 0.5]),
            link(3, 34.0, [0.06, 0.02, 0.05], [0.5, 0.8, 0.7]),
            link(4, 12.0, [0.15, 0.0, 0.01], [0.05, 0.16, 0.15]),
            link(5, 6.0, [0.02, 0.0, 0.0], [0.02, 0.03, 0.025]),
            link(6, 9.0, [0.08, 0.03, -0.01], [0.06, 0.05, 0.04]),
        ],
        joints: vec![
            joint(1, [0.0, 0.0, 0.0], Vector3::z()),
            joint(2, [0.15, 0.0, 0.4865], Vector3::y()),
            joint(3, [0.0, 0.0, 0.7], Vector3::y()),
            joint(4, [0.3, 0.0, 0.0], Vector3::x()),
            joint(5, [0.3, 0.0, 0.0], Vector3::y()),
            joint(6, [0.065, 0.0, 0.0], Vector3::x()),
        ],
        base: None,
        tip: None,
        elastic_joints: springs
            .iter()
            .enumerate()
            .map(|(i, &stiffness)| ElasticJoint {
                joint: format!("joint_{}", i + 1),
                stiffness,
                is_linear: false,
                std: None,
                damping: None,
            })
            .collect(),
        extra: vec![],
        default_damping_ratio: 0.02,
        gravity_m_per_s2: Vector3::new(0.0, 0.0, -STANDARD_GRAVITY_M_PER_S2),
        gravity_stiffness: with_gravity,
        drives: vec![],
        payload: None,
        beta1: None,
        beta2: None,
        calibration: None,
        corrections: vec![],
    };
    Robot::new(&description).unwrap()
}
