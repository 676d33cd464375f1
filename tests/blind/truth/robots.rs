//! Arms drawn at random.

use nalgebra::{Matrix3, Vector3};

use super::arm::{Arm, Body, Joint};
use super::dice::Dice;
use super::dynamics::roll_pitch_yaw;
use super::world::{Row, World};

/// What kind of arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    /// Two or three links in the x–z plane.
    Planar {
        links: usize,
    },
    /// Two links of which the second alone is moved, as in the paper: tables tell β2.
    Sweep,
    SixAxis,
}

impl Family {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Planar { links: 2 } => "planar2",
            Self::Planar { .. } => "planar3",
            Self::Sweep => "sweep",
            Self::SixAxis => "six-axis",
        }
    }
}

/// An arm whose frequencies could be those of a machine: the lowest within 4 to 40 Hz, none above 500 Hz.
pub(crate) fn arm(family: Family, dice: &mut Dice) -> Arm {
    loop {
        let arm = match family {
            Family::Planar { links } => planar(links, dice),
            Family::Sweep => sweep(dice),
            Family::SixAxis => six_axis(dice),
        };
        let world = World::of(&arm);
        let plausible = (0..5).all(|_| {
            let row = row_at(pose(&arm, dice));
            let f = world.frequencies_hz(&row, arm.joints.len());
            f[0] > 4.0 && f[0] < 40.0 && f[f.len() - 1] < 500.0
        });
        if plausible {
            return arm;
        }
    }
}

/// A pose within limits, to a tenth of a milliradian as a table holds it.
pub(crate) fn pose(arm: &Arm, dice: &mut Dice) -> Vec<f64> {
    let within = |joint: &Joint, dice: &mut Dice| {
        let [from, to] = joint.limits_rad;
        (dice.even(from, to) * 1e4).round() / 1e4
    };
    arm.joints.iter().map(|joint| within(joint, dice)).collect()
}

/// A pose of a family.
pub(crate) fn pose_of(family: Family, arm: &Arm, dice: &mut Dice) -> Vec<f64> {
    let mut q = pose(arm, dice);
    if family == Family::Sweep {
        q[0] = 0.0;
    }
    q
}

/// A row at a pose, with nothing happening.
pub(crate) fn row_at(joints_rad: Vec<f64>) -> Row {
    Row {
        previous_rad: joints_rad.clone(),
        joints_rad,
        temperature_c: super::world::REFERENCE_C,
        amplitude_nm: 10.0,
        payload_kg: 0.0,
        unseen: false,
        scatter: 0.0,
        overlooked: false,
    }
}

fn sweep(dice: &mut Dice) -> Arm {
    let mut arm = planar(2, dice);
    arm.joints[0].limits_rad = [-2.4, 2.4];
    arm
}

fn planar(links: usize, dice: &mut Dice) -> Arm {
    let axis = Vector3::y() * dice.sign();
    let mut mass_kg = dice.even(40.0, 80.0);
    let mut stiffness = dice.log_even(6e5, 3e6);
    let mut arm = empty("planar", true, dice);
    let pedestal = Vector3::new(0.0, 0.0, dice.pick(&[0.0, 0.3, 0.5]));
    // Motors stand beside the arm's plane in half of the arms.
    let aside = if dice.chance(0.5) { 0.12 } else { 0.0 };
    for i in 1..=links {
        let length = dice.even(0.45, 0.9);
        let com = Vector3::new(length * dice.even(0.15, 0.6), aside * dice.even(-1.0, 1.0), 0.0);
        let edges =
            Vector3::new(length * dice.even(0.7, 1.1), dice.even(0.1, 0.3), dice.even(0.1, 0.3));
        arm.joints.push(Joint {
            name: format!("joint_{i}"),
            link: format!("link_{i}"),
            origin_m: if i == 1 { pedestal } else { arm.tip_m },
            rpy_rad: Vector3::zeros(),
            axis,
            limits_rad: if i == 1 { [0.2, 2.4] } else { [-2.3, 2.3] },
            stiffness_nm_per_rad: stiffness.max(1e5).round(),
            drive_kgm2: 0.0,
            body: Body::block(mass_kg, com, edges, Matrix3::identity()),
        });
        arm.tip_m = Vector3::new(length, 0.0, 0.0);
        mass_kg *= dice.even(0.35, 0.8);
        stiffness *= dice.even(0.2, 0.7);
    }
    arm
}

fn six_axis(dice: &mut Dice) -> Arm {
    let mut arm = empty("six_axis", false, dice);
    let (shoulder, forearm) = (dice.even(0.05, 0.35), dice.even(0.4, 0.9));
    let (column, upper) = (dice.even(0.35, 0.7), dice.even(0.5, 1.0));
    let (elbow, wrist) = (dice.even(-0.05, 0.2), dice.even(0.06, 0.2));
    let share = dice.even(0.3, 0.7);
    let origins = [
        Vector3::new(0.0, 0.0, dice.even(0.0, 0.2)),
        Vector3::new(shoulder, 0.0, column),
        Vector3::new(0.0, 0.0, upper),
        Vector3::new(forearm * share, 0.0, elbow),
        Vector3::new(forearm * (1.0 - share), 0.0, 0.0),
        Vector3::new(wrist, 0.0, 0.0),
    ];
    let axes = [Vector3::z(), Vector3::y(), Vector3::y(), Vector3::x(), Vector3::y(), Vector3::x()];
    // Part-way limits, as in a cell; degrees.
    let limits = [[-150, 150], [-60, 90], [-120, 60], [-170, 170], [-115, 115], [-180, 180]];
    arm.tip_m = Vector3::new(dice.even(0.05, 0.25), 0.0, 0.0);
    let mut mass_kg = dice.even(50.0, 80.0);
    let mut stiffness = dice.log_even(1e6, 3e6);
    for i in 0..6 {
        let reach = origins.get(i + 1).copied().unwrap_or(arm.tip_m);
        let aside = Vector3::from_fn(|_, _| dice.even(-0.04, 0.04));
        let edges = reach.map(f64::abs) * dice.even(0.8, 1.2)
            + Vector3::from_fn(|_, _| dice.even(0.08, 0.25));
        let tilt = roll_pitch_yaw(&Vector3::from_fn(|_, _| dice.even(-0.2, 0.2)));
        arm.joints.push(Joint {
            name: format!("joint_{}", i + 1),
            link: format!("link_{}", i + 1),
            origin_m: origins[i],
            rpy_rad: Vector3::zeros(),
            axis: axes[i] * dice.pick(&[1.0, 1.0, -1.0]),
            limits_rad: limits[i]
                .map(|degrees| (f64::from(degrees).to_radians() * 1e4).round() / 1e4),
            stiffness_nm_per_rad: stiffness.max(1e5).round(),
            drive_kgm2: 0.0,
            body: Body::block(mass_kg, reach * dice.even(0.2, 0.6) + aside, edges, tilt),
        });
        mass_kg = (mass_kg * dice.even(0.5, 0.85)).max(5.0);
        stiffness *= dice.even(0.45, 0.95);
    }
    if dice.chance(0.4) {
        let spindle = Vector3::new(dice.even(0.0, 0.1), 0.0, dice.even(-0.05, 0.05));
        let edges = Vector3::new(0.25, 0.12, 0.12);
        arm.payload = Some(Body::block(dice.even(2.0, 20.0), spindle, edges, Matrix3::identity()));
    }
    if dice.chance(0.3) {
        for joint in &mut arm.joints[..3] {
            joint.drive_kgm2 = dice.even(1.0, 20.0);
        }
    }
    arm
}

fn empty(name: &str, planar: bool, dice: &mut Dice) -> Arm {
    let edges = Vector3::new(0.5, 0.5, 0.4);
    let centre = Vector3::new(0.0, 0.0, dice.even(0.1, 0.25));
    Arm {
        name: name.to_owned(),
        planar,
        base: Body::block(dice.even(60.0, 150.0), centre, edges, Matrix3::identity()),
        joints: Vec::new(),
        tip_m: Vector3::zeros(),
        payload: None,
        extras: Vec::new(),
        gravity_stiffness: false,
    }
}
