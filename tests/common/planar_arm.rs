//! A planar two-link arm whose frequencies are known in closed form, for several tests.

#![allow(dead_code, reason = "each test uses a part")]

use detune::model::{
    ArmAngle, Damping, Description, ElasticJoint, Inertial, Joint, JointKind, Link,
};
use nalgebra::{Isometry3, Matrix3, Vector3};

/// Planar arm in the x-z plane: Table 1 of the paper, but for I_S2, which is made ten thousand times
/// larger so that f2 stays below 100 Hz and both modes see traffic.
pub(crate) const I_A: f64 = 0.55;
pub(crate) const I_S2: f64 = 9.0;
pub(crate) const M2: f64 = 50.58;
pub(crate) const L1: f64 = 0.63;
pub(crate) const LC2: f64 = 0.1;
pub(crate) const L2: f64 = 0.9;
pub(crate) const K1: f64 = 555_000.0;
pub(crate) const K2: f64 = 138_000.0;

pub(crate) fn two_link() -> Description {
    let body = |mass_kg: f64, com: f64, about_com: f64| {
        Some(Inertial {
            mass_kg,
            com_m: Vector3::new(com, 0.0, 0.0),
            inertia_kgm2: Matrix3::from_diagonal_element(about_com),
        })
    };
    let link = |name: &str, inertial| Link { name: name.into(), inertial, ..Link::default() };
    let joint = |name: &str, kind, parent: &str, child: &str, x: f64| Joint {
        name: name.into(),
        kind,
        parent: parent.into(),
        child: child.into(),
        origin: Isometry3::translation(x, 0.0, 0.0),
        axis: -Vector3::y(),
        position_limit: Some([-4.0, 4.0]),
        velocity_limit: Some(2.0),
        mimics: None,
    };
    let spring = |name: &str, stiffness| ElasticJoint {
        joint: name.into(),
        stiffness,
        is_linear: false,
        std: None,
        damping: Some(Damping::Ratio(0.02)),
    };
    let angle =
        |name: &str| Some(ArmAngle { terms: vec![(name.to_owned(), 1.0)], offset_rad: 0.0 });
    Description {
        name: "two links".into(),
        links: vec![
            link("base", None),
            // 10 kg at 0.1 m: I_A = 0.45 + 10 · 0.01.
            link("one", body(10.0, 0.1, I_A - 0.1)),
            link("two", body(M2, LC2, I_S2)),
            link("tool0", None),
        ],
        joints: vec![
            joint("j1", JointKind::Revolute, "base", "one", 0.0),
            joint("j2", JointKind::Revolute, "one", "two", L1),
            joint("flange", JointKind::Fixed, "two", "tool0", L2),
        ],
        base: None,
        tip: Some("tool0".into()),
        elastic_joints: vec![spring("j1", K1), spring("j2", K2)],
        extra: vec![],
        default_damping_ratio: 0.02,
        gravity_m_per_s2: -9.81 * Vector3::z(),
        gravity_stiffness: false,
        drives: vec![],
        payload: None,
        beta1: angle("j1"),
        beta2: angle("j2"),
        calibration: None,
        corrections: vec![],
    }
}

/// Eq. (45).
pub(crate) fn closed_form_hz(beta2: f64) -> [f64; 2] {
    let (a1, a2, a3) =
        (I_A + I_S2 + M2 * (L1 * L1 + LC2 * LC2), M2 * L1 * LC2, I_S2 + M2 * LC2 * LC2);
    let c = beta2.cos();
    let d1 = a1 * K2 + 2.0 * a2 * K2 * c + a3 * K1;
    let d2 = a1 * a3 - a3 * a3 - a2 * a2 * c * c;
    let root = (d1 * d1 / (4.0 * d2 * d2) - K1 * K2 / d2).sqrt();
    [d1 / (2.0 * d2) - root, d1 / (2.0 * d2) + root]
        .map(|square| square.sqrt() / std::f64::consts::TAU)
}
