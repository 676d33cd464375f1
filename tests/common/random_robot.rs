//! Robots made at random, and their kinematics by another road than the crate's: 4 × 4 homogeneous
//! matrices of every link with their exact derivatives over an elastic coordinate.

#![allow(dead_code, reason = "each test uses a part")]

use std::collections::BTreeMap;

use detune::model::{
    CoordinateKind, Damping, Description, Drive, ElasticJoint, ExtraCoordinate, Inertial, Joint,
    JointKind, Link, Payload,
};
use nalgebra::{
    Isometry3, Matrix3, Matrix4, Rotation3, Translation3, Unit, UnitQuaternion, Vector3, Vector4,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A robot with two to eight moving joints of every kind, welds and massless links between them, rigid
/// joints, branches (fixed, moving, sprung), extra coordinates, drives and sometimes a payload.
pub(crate) fn description(seed: u64) -> Description {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let mut d = Description {
        name: format!("random {seed}"),
        links: vec![link(rng, "ground", true)],
        joints: Vec::new(),
        base: Some("ground".to_owned()),
        tip: Some("tool".to_owned()),
        elastic_joints: Vec::new(),
        extra: Vec::new(),
        default_damping_ratio: 0.03,
        gravity_m_per_s2: direction(rng) * 9.81,
        gravity_stiffness: false,
        drives: Vec::new(),
        payload: None,
        beta1: None,
        beta2: None,
        calibration: None,
        corrections: vec![],
    };
    let moving = rng.random_range(2..=8);
    let mut at = "ground".to_owned();
    for i in 1..=moving {
        if rng.random_bool(0.25) {
            let name = format!("spacer_{i}");
            let weld = joint(rng, &format!("weld_{i}"), JointKind::Fixed, &at, &name);
            let has_mass = rng.random_bool(0.5);
            d.links.push(link(rng, &name, has_mass));
            d.joints.push(weld);
            at = name;
        }
        let kind = match rng.random_range(0..4) {
            0 => JointKind::Prismatic,
            1 => JointKind::Continuous,
            _ => JointKind::Revolute,
        };
        let (name, axis) = (format!("link_{i}"), format!("axis_{i}"));
        let has_mass = i == moving || rng.random_bool(0.85);
        d.links.push(link(rng, &name, has_mass));
        d.joints.push(joint(rng, &axis, kind, &at, &name));
        if i == 1 || rng.random_bool(0.75) {
            d.elastic_joints.push(spring(rng, &axis, kind));
            if rng.random_bool(0.4) {
                let reflected_inertia_kgm2 = rng.random_range(0.0..5.0);
                d.drives.push(Drive { joint: axis, reflected_inertia_kgm2, std: None });
            }
        }
        at = name;
    }
    d.links.push(link(rng, "tool", false));
    d.joints.push(joint(rng, "weld_tool", JointKind::Fixed, &at, "tool"));
    for b in 1..=rng.random_range(0..=2) {
        let parent = format!("link_{}", rng.random_range(1..=moving));
        let kind = match rng.random_range(0..3) {
            0 => JointKind::Fixed,
            1 => JointKind::Prismatic,
            _ => JointKind::Revolute,
        };
        let (name, axis) = (format!("branch_{b}"), format!("branch_axis_{b}"));
        d.links.push(link(rng, &name, true));
        let mut branch = joint(rng, &axis, kind, &parent, &name);
        if rng.random_bool(0.5) {
            // Zero lies outside: the branch is held at the nearer limit.
            branch.position_limit = Some([0.1, 0.6]);
        }
        d.joints.push(branch);
        if kind != JointKind::Fixed && rng.random_bool(0.5) {
            d.elastic_joints.push(spring(rng, &axis, kind));
        }
    }
    for e in 0..rng.random_range(0..=3) {
        let links = ["ground".to_owned(), "link_1".to_owned(), format!("link_{moving}")];
        let turns = rng.random_bool(0.5);
        d.extra.push(ExtraCoordinate {
            name: format!("extra_{e}"),
            link: links[rng.random_range(0..links.len())].clone(),
            kind: if turns { CoordinateKind::Rotation } else { CoordinateKind::Translation },
            axis: direction(rng) * rng.random_range(0.3..3.0),
            origin_m: vector(rng, 0.3),
            stiffness: 10_f64.powf(rng.random_range(5.0..7.0)),
            std: None,
            damping: None,
        });
    }
    if rng.random_bool(0.5) {
        let link = if rng.random_bool(0.5) { "tool".to_owned() } else { at };
        d.payload = Some(Payload { link, inertial: inertial(rng) });
    }
    d
}

/// A pose of the moving joints, within ±0.8 (prismatic) or ±3 (others).
pub(crate) fn pose(robot: &detune::model::Robot, seed: u64) -> Vec<f64> {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed ^ 0xb0b5);
    let reach = |kind| if kind == JointKind::Prismatic { 0.8 } else { 3.0 };
    robot
        .joints()
        .iter()
        .map(|joint| rng.random_range(-reach(joint.kind)..reach(joint.kind)))
        .collect()
}

/// A vector of `n` entries in ±1.
pub(crate) fn numbers(n: usize, seed: u64) -> Vec<f64> {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed ^ 0xf00d);
    (0..n).map(|_| rng.random_range(-1.0..1.0)).collect()
}

/// Any orientation and place.
pub(crate) fn isometry(seed: u64) -> Isometry3<f64> {
    random_isometry(&mut ChaCha8Rng::seed_from_u64(seed ^ 0xace))
}

fn vector(rng: &mut ChaCha8Rng, reach: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-reach..reach))
}

fn direction(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    loop {
        let v = vector(rng, 1.0);
        if (0.1..1.0).contains(&v.norm()) {
            return v.normalize();
        }
    }
}

fn random_isometry(rng: &mut ChaCha8Rng) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::from(vector(rng, 0.5)),
        UnitQuaternion::from_scaled_axis(direction(rng) * rng.random_range(0.0..3.0)),
    )
}

fn link(rng: &mut ChaCha8Rng, name: &str, has_mass: bool) -> Link {
    Link { name: name.to_owned(), inertial: has_mass.then(|| inertial(rng)), ..Link::default() }
}

/// Mass properties of a box, turned and shifted.
fn inertial(rng: &mut ChaCha8Rng) -> Inertial {
    let mass_kg = rng.random_range(0.5..15.0);
    let [a, b, c] = [(); 3].map(|()| rng.random_range(0.05_f64..0.5).powi(2));
    let principal = Matrix3::from_diagonal(&(Vector3::new(b + c, a + c, a + b) * (mass_kg / 12.0)));
    let r = Rotation3::from_scaled_axis(direction(rng) * rng.random_range(0.0..3.0));
    Inertial { mass_kg, com_m: vector(rng, 0.2), inertia_kgm2: r * principal * r.transpose() }
}

fn joint(rng: &mut ChaCha8Rng, name: &str, kind: JointKind, parent: &str, child: &str) -> Joint {
    Joint {
        name: name.to_owned(),
        kind,
        parent: parent.to_owned(),
        child: child.to_owned(),
        origin: random_isometry(rng),
        axis: direction(rng) * rng.random_range(0.3..3.0),
        position_limit: match kind {
            JointKind::Prismatic => Some([-0.8, 0.8]),
            JointKind::Revolute => Some([-3.0, 3.0]),
            _ => None,
        },
        velocity_limit: None,
        mimics: None,
    }
}

fn spring(rng: &mut ChaCha8Rng, joint: &str, kind: JointKind) -> ElasticJoint {
    ElasticJoint {
        joint: joint.to_owned(),
        stiffness: 10_f64.powf(rng.random_range(4.5..6.5)),
        is_linear: kind == JointKind::Prismatic,
        std: None,
        damping: match rng.random_range(0..3) {
            0 => None,
            1 => Some(Damping::Ratio(rng.random_range(0.01..0.08))),
            _ => Some(Damping::Viscous(rng.random_range(5.0..200.0))),
        },
    }
}

/// A link's frame in the base's, and its derivative over one elastic coordinate.
pub(crate) type Frame = (Matrix4<f64>, Matrix4<f64>);

/// Frames of all links with the joints at `q` (by name; others held) and the elastic coordinates at rest,
/// with ∂/∂α of the coordinate called `over`.
pub(crate) fn frames(
    d: &Description,
    q: &BTreeMap<&str, f64>,
    over: &str,
) -> BTreeMap<String, Frame> {
    let base = d.base.clone().expect("the base is named");
    let start = step((Matrix4::identity(), Matrix4::zeros()), d, &base, None, over);
    let mut found = BTreeMap::from([(base, start)]);
    while found.len() < d.links.len() {
        for joint in &d.joints {
            let Some(&parent) = found.get(&joint.parent) else { continue };
            if found.contains_key(&joint.child) {
                continue;
            }
            let value = q.get(joint.name.as_str()).copied().unwrap_or_else(|| {
                joint.position_limit.map_or(0.0, |[low, high]| 0.0_f64.clamp(low, high))
            });
            let moved = joint.origin.to_homogeneous() * travel(joint.kind, &joint.axis, value);
            let frame = (parent.0 * moved, parent.1 * moved);
            let spring = (joint.name == over).then_some(joint);
            found.insert(joint.child.clone(), step(frame, d, &joint.child, spring, over));
        }
    }
    found
}

/// Passes the elastic coordinates of a link: T stays, ∂T gains T·Ŝ.
fn step(frame: Frame, d: &Description, link: &str, spring: Option<&Joint>, over: &str) -> Frame {
    let (t, mut dt) = frame;
    if let Some(joint) = spring {
        let turns = joint.kind != JointKind::Prismatic;
        dt += t * rate(turns, &joint.axis, &Vector3::zeros());
    }
    for extra in d.extra.iter().filter(|extra| extra.link == link && extra.name == over) {
        dt += t * rate(extra.kind == CoordinateKind::Rotation, &extra.axis, &extra.origin_m);
    }
    (t, dt)
}

/// Ŝ of a unit rate about (or along) an axis through a point.
fn rate(turns: bool, axis: &Vector3<f64>, point: &Vector3<f64>) -> Matrix4<f64> {
    let axis = axis.normalize();
    let mut s = Matrix4::zeros();
    if turns {
        s.fixed_view_mut::<3, 3>(0, 0).copy_from(&axis.cross_matrix());
        s.fixed_view_mut::<3, 1>(0, 3).copy_from(&-axis.cross(point));
    } else {
        s.fixed_view_mut::<3, 1>(0, 3).copy_from(&axis);
    }
    s
}

fn travel(kind: JointKind, axis: &Vector3<f64>, value: f64) -> Matrix4<f64> {
    match kind {
        JointKind::Fixed => Matrix4::identity(),
        JointKind::Prismatic => Translation3::from(axis.normalize() * value).to_homogeneous(),
        _ => Rotation3::from_axis_angle(&Unit::new_normalize(*axis), value).to_homogeneous(),
    }
}

/// Every body of the robot with its link: the links' own and the payload.
pub(crate) fn bodies(d: &Description) -> impl Iterator<Item = (&str, &Inertial)> {
    let own = d.links.iter().filter_map(|l| Some((l.name.as_str(), l.inertial.as_ref()?)));
    own.chain(d.payload.iter().map(|p| (p.link.as_str(), &p.inertial)))
}

/// Pseudo-inertia ∫ r rᵀ dm of homogeneous points r, in the link's frame.
pub(crate) fn pseudo_inertia(body: &Inertial) -> Matrix4<f64> {
    let spread =
        Matrix3::from_diagonal_element(0.5 * body.inertia_kgm2.trace()) - body.inertia_kgm2;
    let about_origin = spread + body.mass_kg * body.com_m * body.com_m.transpose();
    let mut j = Matrix4::zeros();
    j.fixed_view_mut::<3, 3>(0, 0).copy_from(&about_origin);
    let first = body.com_m * body.mass_kg;
    j.set_column(3, &Vector4::new(first.x, first.y, first.z, body.mass_kg));
    j.set_row(3, &Vector4::new(first.x, first.y, first.z, body.mass_kg).transpose());
    j
}
