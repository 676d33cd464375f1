//! Inverse kinematics on arms of several kinds: what is solved leads back, through the forward
//! kinematics, to the pose that was asked for. The forward kinematics of the IRB 1600 and all its
//! solutions are compared with rs-opw-kinematics, which knows the arm by its OPW parameters.

#![allow(clippy::approx_constant, reason = "rounded angles are part of what is tested")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use detune::model::{
    Description, ElasticJoint, IkFault, IkMethod, Inertial, InverseKinematics, Joint, JointKind,
    Link, Placement, PoseFault, Robot, forward_kinematics,
};
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One joint of a test arm: kind, origin xyz (m) and rpy (rad), axis, limits (rad or m).
struct Row(JointKind, [f64; 3], [f64; 3], [f64; 3], [f64; 2]);

fn turning(xyz: [f64; 3], axis: [f64; 3], limit_deg: [f64; 2]) -> Row {
    Row(JointKind::Revolute, xyz, [0.0; 3], axis, limit_deg.map(f64::to_radians))
}

fn sliding(xyz: [f64; 3], axis: [f64; 3], limit_m: [f64; 2]) -> Row {
    Row(JointKind::Prismatic, xyz, [0.0; 3], axis, limit_m)
}

fn tool(xyz: [f64; 3], rpy: [f64; 3]) -> Row {
    Row(JointKind::Fixed, xyz, rpy, [0.0, 0.0, 1.0], [0.0, 0.0])
}

/// An arm of these joints; every link weighs 10 kg, the first joint is elastic.
fn arm(rows: &[Row]) -> Robot {
    let link = |i: usize| format!("link_{i}");
    let inertial = Inertial {
        mass_kg: 10.0,
        com_m: Vector3::new(0.02, 0.01, 0.05),
        inertia_kgm2: Matrix3::from_diagonal(&Vector3::new(0.2, 0.22, 0.15)),
    };
    let joints: Vec<Joint> = rows
        .iter()
        .enumerate()
        .map(|(i, Row(kind, [x, y, z], [roll, pitch, yaw], axis, limit))| Joint {
            name: format!("joint_{}", i + 1),
            kind: *kind,
            parent: link(i),
            child: link(i + 1),
            origin: Isometry3::from_parts(
                Translation3::new(*x, *y, *z),
                UnitQuaternion::from_euler_angles(*roll, *pitch, *yaw),
            ),
            axis: Vector3::from(*axis),
            position_limit: kind.moves().then_some(*limit),
            velocity_limit: None,
            mimics: None,
        })
        .collect();
    let description = Description {
        name: "arm".to_owned(),
        links: (0..=rows.len())
            .map(|i| Link {
                name: link(i),
                inertial: Some(inertial),
                has_geometry: true,
                ..Link::default()
            })
            .collect(),
        elastic_joints: vec![ElasticJoint {
            joint: "joint_1".to_owned(),
            stiffness: 5e5,
            is_linear: rows[0].0 == JointKind::Prismatic,
            std: None,
            damping: None,
        }],
        joints,
        base: None,
        tip: Some(link(rows.len())),
        extra: Vec::new(),
        default_damping_ratio: 0.02,
        gravity_m_per_s2: Vector3::zeros(),
        gravity_stiffness: false,
        drives: Vec::new(),
        payload: None,
        beta1: None,
        beta2: None,
        calibration: None,
        corrections: vec![],
    };
    Robot::new(&description).unwrap()
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

fn minus([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-x, -y, -z]
}

/// ABB IRB 1600 x/1.45, from the ROS-Industrial description.
fn irb1600() -> Robot {
    arm(&[
        turning([0.0, 0.0, 0.0], Z, [-180.0, 180.0]),
        turning([0.15, 0.0, 0.4865], Y, [-90.0, 120.0]),
        turning([0.0, 0.0, 0.7], Y, [-245.0, 65.0]),
        turning([0.3, 0.0, 0.0], X, [-200.0, 200.0]),
        turning([0.3, 0.0, 0.0], Y, [-115.0, 115.0]),
        turning([0.065, 0.0, 0.0], X, [-400.0, 400.0]),
        tool([0.0, 0.0, 0.0], [0.0, FRAC_PI_2, 0.0]),
    ])
}

/// In the manner of KUKA: axis 1 points down, the arm lies stretched out at zero, axes 4 and 6 point
/// back. Dimensions are made up.
fn down_and_stretched() -> Robot {
    arm(&[
        turning([0.0, 0.0, 0.675], minus(Z), [-185.0, 185.0]),
        turning([0.35, 0.0, 0.0], Y, [-140.0, -5.0]),
        turning([1.15, 0.0, 0.0], Y, [-120.0, 155.0]),
        turning([1.0, 0.0, -0.041], minus(X), [-350.0, 350.0]),
        turning([0.0, 0.0, 0.0], Y, [-122.5, 122.5]),
        turning([0.0, 0.0, 0.0], minus(X), [-350.0, 350.0]),
        tool([0.24, 0.0, 0.0], [0.0, FRAC_PI_2, 0.0]),
        tool([0.1, -0.05, 0.3], [0.3, -0.7, 1.1]),
    ])
}

/// A tilted base with a lateral offset, frames turned at every joint, an oblique wrist (60° between
/// its axes), right angles printed as 1.5708. Made up.
fn crooked() -> Robot {
    let row = |xyz, rpy, axis| Row(JointKind::Revolute, xyz, rpy, axis, [-3.0, 3.0]);
    arm(&[
        row([0.1, 0.2, 0.3], [0.4, -0.3, 0.8], [0.0, 0.6, 0.8]),
        row([0.2, 0.3, 0.1], [0.0, 0.0, 0.0], [0.0, 0.8, -0.6]),
        row([0.5, 0.1, 0.2], [3.1416, 0.0, 0.0], [0.0, 0.8, -0.6]),
        row([0.4, 0.0, 0.1], [1.5708, 0.0, 1.5708], Z),
        row([0.0, 0.0, 0.35], [1.0472, 0.0, 0.0], Z),
        row([0.0, 0.0, 0.0], [-1.0472, 0.0, 0.0], Z),
        tool([0.02, 0.03, 0.2], [0.1, 0.2, 0.3]),
    ])
}

/// In the manner of the UR5: axes 2, 3 and 4 parallel, no two of the last three in one plane but one
/// after another. Dimensions rounded.
fn offset_wrist() -> Robot {
    let range = [-180.0, 180.0];
    arm(&[
        turning([0.0, 0.0, 0.089], Z, range),
        turning([0.0, 0.136, 0.0], Y, range),
        turning([0.0, -0.12, 0.425], Y, range),
        turning([0.0, 0.0, 0.392], Y, range),
        turning([0.0, 0.093, 0.0], Z, range),
        turning([0.0, 0.0, 0.095], Y, range),
        tool([0.0, 0.082, 0.0], [0.0, 0.0, FRAC_PI_2]),
    ])
}

/// Seven axes in the manner of the LBR iiwa. Dimensions rounded.
fn seven_axes() -> Robot {
    arm(&[
        turning([0.0, 0.0, 0.15], Z, [-170.0, 170.0]),
        turning([0.0, 0.0, 0.19], Y, [-120.0, 120.0]),
        turning([0.0, 0.0, 0.21], Z, [-170.0, 170.0]),
        turning([0.0, 0.0, 0.19], minus(Y), [-120.0, 120.0]),
        turning([0.0, 0.0, 0.21], Z, [-170.0, 170.0]),
        turning([0.0, 0.0, 0.19], Y, [-120.0, 120.0]),
        turning([0.0, 0.0, 0.08], Z, [-175.0, 175.0]),
        tool([0.0, 0.0, 0.045], [0.0; 3]),
    ])
}

/// A gantry: three slides and a three-axis wrist. Made up.
fn gantry() -> Robot {
    arm(&[
        sliding([0.0, 0.0, 3.0], X, [0.0, 6.0]),
        sliding([0.0, 0.0, 0.0], Y, [-1.5, 1.5]),
        sliding([0.0, 0.0, 0.0], minus(Z), [0.0, 1.2]),
        turning([0.0, 0.0, -0.4], minus(Z), [-179.0, 179.0]),
        turning([0.0, 0.0, -0.2], Y, [5.0, 110.0]),
        turning([0.1, 0.0, -0.15], minus(Z), [-179.0, 179.0]),
    ])
}

/// Five axes: a three-axis arm with a fork wrist. Made up.
fn five_axes() -> Robot {
    arm(&[
        turning([0.0, 0.0, 0.3], Z, [-170.0, 170.0]),
        turning([0.1, 0.0, 0.0], Y, [-100.0, 100.0]),
        turning([0.0, 0.0, 0.6], Y, [-140.0, 140.0]),
        turning([0.5, 0.0, 0.0], Y, [-120.0, 120.0]),
        turning([0.1, 0.0, 0.0], X, [-179.0, 179.0]),
        tool([0.2, 0.0, 0.0], [0.0; 3]),
    ])
}

fn tip_at(robot: &Robot, q: &[f64]) -> Isometry3<f64> {
    let mut placement = Placement::new(robot);
    placement.place(robot, q);
    forward_kinematics(robot, &placement)
}

/// (m, rad)
fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>) -> (f64, f64) {
    ((a.translation.vector - b.translation.vector).norm(), a.rotation.angle_to(&b.rotation))
}

/// Largest difference of a joint, whole turns of turning joints aside.
fn joint_distance(robot: &Robot, a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).zip(robot.joints()).map(|((a, b), joint)| {
        let apart = a - b;
        if joint.kind == JointKind::Prismatic {
            apart.abs()
        } else {
            (apart - TAU * (apart / TAU).round()).abs()
        }
    });
    differences.fold(0.0, f64::max)
}

fn random_pose(robot: &Robot, rng: &mut ChaCha8Rng) -> Vec<f64> {
    robot
        .joints()
        .iter()
        .map(|joint| {
            let [lower, upper] = joint.limit.unwrap();
            rng.random_range(lower..upper)
        })
        .collect()
}

fn is_within_limits(robot: &Robot, q: &[f64]) -> bool {
    robot.limit_violations(q).next().is_none()
}

/// Every solution leads to the pose, no two are the same, and (where branches are countable) one is
/// the pose that the target was made from. Returns how many of the originals were missing.
fn round_trips(robot: &Robot, method: IkMethod, poses: usize, most: usize) -> usize {
    let kinematics = InverseKinematics::new(robot);
    assert_eq!(kinematics.method(), method);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut missing = 0;
    for _ in 0..poses {
        let original = random_pose(robot, &mut rng);
        let target = tip_at(robot, &original);
        let solutions = kinematics.solutions(robot, &target);
        assert!(!solutions.is_empty() && solutions.len() <= most, "{}", solutions.len());
        for (i, q) in solutions.iter().enumerate() {
            let (distance, angle) = apart(&tip_at(robot, q), &target);
            assert!(distance < 1e-11 && angle < 1e-11, "{distance:e} m, {angle:e} rad off");
            assert!(is_within_limits(robot, q), "{q:?}");
            assert!(solutions[..i].iter().all(|other| joint_distance(robot, other, q) > 1e-7));
        }
        let singularity = kinematics.singularity(robot, &original).unwrap();
        if singularity.smallest_singular_value > 1e-4
            && !solutions.iter().any(|q| joint_distance(robot, q, &original) < 1e-7)
        {
            missing += 1;
        }
    }
    missing
}

#[test]
fn closed_form_finds_every_pose_again_on_the_irb_1600() {
    assert_eq!(round_trips(&irb1600(), IkMethod::SphericalWrist, 5000, 8), 0);
}

#[test]
fn closed_form_finds_every_pose_again_whatever_the_zero_pose_and_signs() {
    assert_eq!(round_trips(&down_and_stretched(), IkMethod::SphericalWrist, 5000, 8), 0);
}

#[test]
fn closed_form_finds_every_pose_again_on_tilted_frames_and_an_oblique_wrist() {
    assert_eq!(round_trips(&crooked(), IkMethod::SphericalWrist, 5000, 8), 0);
}

/// All joint positions of one pose differ in a side; det J, which changes its sign with each of them, is that of the
/// Jacobian.
#[test]
fn sides_tell_the_solutions_of_a_pose_apart() {
    for robot in [irb1600(), down_and_stretched(), crooked()] {
        let kinematics = InverseKinematics::new(&robot);
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut hands = std::collections::HashMap::new();
        let mut most = 0;
        for _ in 0..500 {
            let target = tip_at(&robot, &random_pose(&robot, &mut rng));
            let solutions = kinematics.solutions(&robot, &target);
            let found: Vec<[Option<bool>; 3]> =
                solutions.iter().map(|q| kinematics.sides(q)).collect();
            if found.iter().flatten().any(Option::is_none) {
                continue;
            }
            for (i, sides) in found.iter().enumerate() {
                assert!(!found[..i].contains(sides), "{found:?}");
                let singularity = kinematics.singularity(&robot, &solutions[i]).unwrap();
                let is_even = sides.iter().filter(|side| **side == Some(true)).count() % 2 == 0;
                let hand = singularity.is_right_handed.unwrap();
                assert_eq!(*hands.entry(is_even).or_insert(hand), hand);
            }
            most = most.max(found.len());
        }
        assert!(most == 8 && hands[&true] != hands[&false], "{most} {hands:?}");
    }
    // Another wrist, and the arm of the IRB 1600 stretched out.
    assert_eq!(InverseKinematics::new(&offset_wrist()).sides(&[0.3; 6]), [None; 3]);
    let [shoulder, elbow, wrist] =
        InverseKinematics::new(&irb1600()).sides(&[0.0, 0.5, -FRAC_PI_2, 0.0, 0.5, 0.0]);
    assert!(shoulder.is_some() && elbow.is_none() && wrist.is_some());
}

#[test]
fn numeric_method_finds_every_pose_again_on_an_offset_wrist() {
    let missing = round_trips(&offset_wrist(), IkMethod::Numeric, 150, 16);
    assert_eq!(missing, 0);
}

#[test]
fn numeric_method_finds_every_pose_again_on_a_gantry() {
    assert_eq!(round_trips(&gantry(), IkMethod::Numeric, 150, 8), 0);
}

#[test]
fn numeric_method_finds_every_pose_again_on_five_axes() {
    assert_eq!(round_trips(&five_axes(), IkMethod::Numeric, 150, 8), 0);
}

#[test]
fn seven_axes_give_examples() {
    // A continuum of solutions: the original is one of infinitely many.
    round_trips(&seven_axes(), IkMethod::Numeric, 150, 8);
}

#[test]
fn solutions_of_the_irb_1600_are_those_of_rs_opw_kinematics() {
    use rs_opw_kinematics::kinematic_traits::Kinematics;
    use rs_opw_kinematics::kinematics_impl::OPWKinematics;
    use rs_opw_kinematics::parameters::opw_kinematics::Parameters;

    let robot = irb1600();
    let kinematics = InverseKinematics::new(&robot);
    // The parameters that the ROS-Industrial description of the arm gives.
    let opw = OPWKinematics::new(Parameters {
        a1: 0.15,
        a2: 0.0,
        b: 0.0,
        c1: 0.4865,
        c2: 0.7,
        c3: 0.6,
        c4: 0.065,
        offsets: [0.0, 0.0, -FRAC_PI_2, 0.0, 0.0, 0.0],
        sign_corrections: [1; 6],
        dof: 6,
    });
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut compared = 0;
    for _ in 0..2000 {
        let original = random_pose(&robot, &mut rng);
        let measure = kinematics.singularity(&robot, &original).unwrap();
        if measure.smallest_singular_value < 1e-3 {
            continue;
        }
        let target = tip_at(&robot, &original);
        let theirs = opw.try_forward(&original.clone().try_into().unwrap()).unwrap();
        let (t, r) = (theirs.translation, theirs.rotation);
        assert!((target.translation.vector - Vector3::new(t.x, t.y, t.z)).norm() < 1e-12);
        let quaternion = nalgebra::Quaternion::new(r.w, r.x, r.y, r.z);
        assert!(UnitQuaternion::from_quaternion(quaternion).angle_to(&target.rotation) < 1e-12);

        let ours = kinematics.solutions(&robot, &target);
        let mut reachable = 0;
        for q in opw.inverse(&theirs) {
            let allowed = q.iter().zip(robot.joints()).all(|(q, joint)| {
                let [lower, upper] = joint.limit.unwrap();
                (-1..=1).any(|turn| (lower..=upper).contains(&(q + TAU * f64::from(turn))))
            });
            if allowed {
                reachable += 1;
                assert!(ours.iter().any(|own| joint_distance(&robot, own, &q) < 1e-8), "{q:?}");
            }
        }
        assert_eq!(ours.len(), reachable);
        compared += 1;
    }
    assert!(compared > 1900, "{compared}");
}

#[test]
fn all_eight_branches_are_there_when_limits_allow() {
    let robot = irb1600();
    let target = tip_at(&robot, &[0.3, -0.4, 0.1, 0.7, 0.6, -0.2]);
    let wide = arm(&[
        turning([0.0, 0.0, 0.0], Z, [-400.0, 400.0]),
        turning([0.15, 0.0, 0.4865], Y, [-400.0, 400.0]),
        turning([0.0, 0.0, 0.7], Y, [-400.0, 400.0]),
        turning([0.3, 0.0, 0.0], X, [-400.0, 400.0]),
        turning([0.3, 0.0, 0.0], Y, [-400.0, 400.0]),
        turning([0.065, 0.0, 0.0], X, [-400.0, 400.0]),
        tool([0.0, 0.0, 0.0], [0.0, FRAC_PI_2, 0.0]),
    ]);
    let solutions = InverseKinematics::new(&wide).solutions(&wide, &target);
    assert_eq!(solutions.len(), 8);
    assert!(solutions.iter().flatten().all(|q| q.abs() <= PI + 1e-12));
    assert_eq!(solutions, InverseKinematics::new(&wide).solutions(&wide, &target));
}

#[test]
fn near_returns_to_a_disturbed_seed_to_rounding() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for robot in [irb1600(), down_and_stretched(), crooked(), offset_wrist(), gantry(), five_axes()]
    {
        let kinematics = InverseKinematics::new(&robot);
        let mut tried = 0;
        for _ in 0..500 {
            let original = random_pose(&robot, &mut rng);
            let measure = kinematics.singularity(&robot, &original).unwrap();
            if measure.smallest_singular_value < 0.02 {
                continue;
            }
            tried += 1;
            let target = tip_at(&robot, &original);
            let seed: Vec<f64> =
                original.iter().map(|q| q + rng.random_range(-2e-3..2e-3)).collect();
            let q = kinematics.near(&robot, &target, &seed).unwrap();
            let (distance, angle) = apart(&tip_at(&robot, &q), &target);
            assert!(distance < 1e-12 * kinematics.length_m().max(1.0) && angle < 1e-12);
            // No turn is lost: the difference is taken without whole turns.
            for (q, original) in q.iter().zip(&original) {
                assert!((q - original).abs() < 1e-9, "{q} instead of {original}");
            }
        }
        assert!(tried > 300, "{tried}");
    }
}

#[test]
fn near_follows_a_straight_line_without_a_jump() {
    let line = |robot: &Robot, start: &[f64], shift: [f64; 3]| {
        let kinematics = InverseKinematics::new(robot);
        let from = tip_at(robot, start);
        let mut q = start.to_vec();
        let mut longest: f64 = 0.0;
        for i in 0..=2000 {
            let share = f64::from(i) / 2000.0;
            let target = Isometry3::from_parts(
                Translation3::from(from.translation.vector + Vector3::from(shift) * share),
                from.rotation * UnitQuaternion::from_scaled_axis(Vector3::y() * 0.3 * share),
            );
            let next = kinematics.near(robot, &target, &q).unwrap();
            let (distance, angle) = apart(&tip_at(robot, &next), &target);
            assert!(distance < 1e-12 * kinematics.length_m().max(1.0) && angle < 1e-12);
            let step = next.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            longest = longest.max(step);
            q = next;
        }
        longest
    };
    // The first of them has joint 6 a turn away from zero, and stays there.
    let start = [0.2, 0.3, -0.2, 0.4, 0.8, 5.5];
    assert!(line(&irb1600(), &start, [0.1, 0.4, -0.3]) < 2e-3);
    let start = [0.2, -1.4, 1.2, 3.4, 0.7, -4.0];
    assert!(line(&down_and_stretched(), &start, [-0.3, 0.6, 0.2]) < 2e-3);
    let start = [0.4, -0.6, 1.1, -0.9, 1.2, 0.4];
    assert!(line(&offset_wrist(), &start, [0.05, 0.1, -0.15]) < 2e-3);
    let start = [0.1, 0.5, 0.2, 1.3, -0.2, 0.8, 0.3];
    assert!(line(&seven_axes(), &start, [0.1, 0.1, -0.1]) < 2e-3);
    let start = [1.0, 0.2, 0.5, 0.3, 0.9, -0.4];
    assert!(line(&gantry(), &start, [2.0, 0.5, 0.2]) < 2e-3);
}

#[test]
fn near_takes_the_nearest_branch_and_turn_from_a_far_seed() {
    let robot = irb1600();
    let kinematics = InverseKinematics::new(&robot);
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    for _ in 0..300 {
        let target = tip_at(&robot, &random_pose(&robot, &mut rng));
        let seed = random_pose(&robot, &mut rng);
        let q = kinematics.near(&robot, &target, &seed).unwrap();
        assert!(is_within_limits(&robot, &q));
        let (distance, angle) = apart(&tip_at(&robot, &q), &target);
        assert!(distance < 1e-11 && angle < 1e-11);
        let square = |a: &[f64]| a.iter().zip(&seed).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        // Brute force over all branches and turns.
        for branch in kinematics.solutions(&robot, &target) {
            for turns in 0..27 {
                let mut other = branch.clone();
                for (joint, factor) in [(0, 1), (3, 3), (5, 9)] {
                    other[joint] += TAU * f64::from(turns / factor % 3 - 1);
                }
                if is_within_limits(&robot, &other) {
                    assert!(square(&q) <= square(&other) + 1e-6);
                }
            }
        }
    }
}

#[test]
fn redundant_arm_stays_within_its_limits_where_it_can() {
    let robot = seven_axes();
    let kinematics = InverseKinematics::new(&robot);
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut at_limit = 0;
    for _ in 0..300 {
        let mut original = random_pose(&robot, &mut rng);
        let [_, upper] = robot.joints()[3].limit.unwrap();
        original[1] = rng.random_range(1.9..2.09);
        original[3] = original[3].min(upper);
        let target = tip_at(&robot, &original);
        let seed: Vec<f64> = original
            .iter()
            .zip(robot.joints())
            .map(|(q, joint)| {
                let [lower, upper] = joint.limit.unwrap();
                (q + rng.random_range(-0.1..0.1)).clamp(lower, upper)
            })
            .collect();
        if let Ok(q) = kinematics.near(&robot, &target, &seed) {
            assert!(is_within_limits(&robot, &q));
            let (distance, angle) = apart(&tip_at(&robot, &q), &target);
            assert!(distance < 2e-12 && angle < 1e-12);
            at_limit += usize::from(robot.joints().iter().zip(&q).any(|(joint, q)| {
                joint.limit.unwrap().iter().any(|limit| (q - limit).abs() < 1e-12)
            }));
        } else {
            panic!("a pose within limits was not found from nearby");
        }
    }
    assert!(at_limit > 10, "{at_limit}");
}

#[test]
fn out_of_reach_tells_by_how_much() {
    let robot = irb1600();
    let kinematics = InverseKinematics::new(&robot);
    let seed = [0.0, 0.5, 0.2, 0.0, 0.5, 0.0];
    let far = Isometry3::from_parts(Translation3::new(3.0, 0.0, 0.5), UnitQuaternion::identity());
    assert!(kinematics.solutions(&robot, &far).is_empty());
    let fault = kinematics.near(&robot, &far, &seed).unwrap_err();
    let IkFault::OutOfReach { distance_m, .. } = fault else { panic!("{fault}") };
    // Stretched towards it the flange comes to 0.15 + 0.7 + 0.6 + 0.065 = 1.515 m, or a little less for
    // the sake of the orientation.
    assert!((1.48..1.6).contains(&distance_m), "{distance_m}");
    assert!(fault.to_string().starts_with("out of reach: the nearest pose found is 1"), "{fault}");

    // Five axes: the flange cannot turn about the axis of the fork.
    let robot = five_axes();
    let kinematics = InverseKinematics::new(&robot);
    let seed = [0.3, 0.2, 0.4, 0.3, 0.1];
    let mut target = tip_at(&robot, &seed);
    target.rotation *= UnitQuaternion::from_scaled_axis(Vector3::z() * 0.2);
    assert!(kinematics.solutions(&robot, &target).is_empty());
    let fault = kinematics.near(&robot, &target, &seed).unwrap_err();
    let IkFault::OutOfReach { distance_m, angle_rad } = fault else { panic!("{fault}") };
    assert!(distance_m + angle_rad > 0.01 && angle_rad < 0.21, "{fault}");
}

#[test]
fn over_limit_names_the_joint() {
    let robot = irb1600();
    let kinematics = InverseKinematics::new(&robot);
    let beyond = [0.1, 0.3, 0.2, 0.4, 118f64.to_radians(), 0.5];
    let seed = [0.1, 0.3, 0.2, 0.4, 114f64.to_radians(), 0.5];
    let fault = kinematics.near(&robot, &tip_at(&robot, &beyond), &seed).unwrap_err();
    assert_eq!(
        fault.to_string(),
        "joint 'joint_5' would have to be at 118.000°, over its limit of 115.000°"
    );

    // A turn back, joint 4 would be within its limits: but from this seed that is a jump.
    let beyond = [0.1, 0.3, 0.2, 205f64.to_radians(), 0.8, 0.5];
    let seed = [0.1, 0.3, 0.2, 199f64.to_radians(), 0.8, 0.5];
    let target = tip_at(&robot, &beyond);
    let fault = kinematics.near(&robot, &target, &seed).unwrap_err();
    let IkFault::OverLimit { joint, value, limit, .. } = &fault else { panic!("{fault}") };
    assert_eq!(joint, "joint_4");
    assert!((value - beyond[3]).abs() < 1e-9 && (limit - 200f64.to_radians()).abs() < 1e-12);
    assert!(kinematics.solutions(&robot, &target).len() > 1);

    let robot = gantry();
    let kinematics = InverseKinematics::new(&robot);
    let target = tip_at(&robot, &[6.2, 0.0, 0.5, 0.3, 0.9, -0.4]);
    assert!(kinematics.solutions(&robot, &target).is_empty());
    for seed in [[5.9, 0.0, 0.5, 0.3, 0.9, -0.4], [0.0, 0.0, 0.0, 0.0, 0.5, 0.0]] {
        let fault = kinematics.near(&robot, &target, &seed).unwrap_err();
        assert_eq!(
            fault.to_string(),
            "joint 'joint_1' would have to be at 6200.000 mm, over its limit of 6000.000 mm"
        );
    }
}

#[test]
fn singularities_are_measured_and_named() {
    let robot = irb1600();
    let kinematics = InverseKinematics::new(&robot);
    let measure = |q: &[f64]| kinematics.singularity(&robot, q).unwrap();

    let wrist = measure(&[0.2, 0.3, -0.4, 0.5, 0.0, 0.7]);
    assert!(wrist.smallest_singular_value < 1e-15);
    assert_eq!(wrist.joints, [3, 5]);

    // Forearm and upper arm in line.
    let elbow = measure(&[0.2, 0.3, -FRAC_PI_2, 0.5, 0.8, 0.7]);
    assert!(elbow.smallest_singular_value < 1e-15);
    assert!(elbow.joints.starts_with(&[1, 2]), "{:?}", elbow.joints);

    // Wrist centre above axis 1: 0.15 + 0.7 sin q2 + 0.6 sin(q2 + q3 + π/2) = 0.
    let q2 = -0.6_f64;
    let q3 = (-(0.15 + 0.7 * q2.sin()) / 0.6).asin() - q2 - FRAC_PI_2;
    let shoulder = measure(&[0.2, q2, q3, 0.5, 0.8, 0.7]);
    assert!(shoulder.smallest_singular_value < 1e-15);
    assert!(shoulder.joints.contains(&0));

    let regular = measure(&[0.2, 0.3, -0.4, 0.5, 1.0, 0.7]);
    assert!(regular.smallest_singular_value > 0.05, "{}", regular.smallest_singular_value);
    // Near the wrist's singularity the measure grows in proportion to sin q5.
    let near = |q5: f64| measure(&[0.2, 0.3, -0.4, 0.5, q5, 0.7]).smallest_singular_value;
    assert!((near(2e-4) / near(1e-4) - 2.0).abs() < 1e-3);
}

/// The quick look never takes a pose for regular that is not.
#[test]
fn what_is_surely_regular_is_regular() {
    let robot = irb1600();
    let kinematics = InverseKinematics::new(&robot);
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    for least in [1e-4, 1e-3, 1e-2] {
        let (mut sure, mut regular) = (0, 0);
        for i in 0..4000 {
            let mut q = [0.0; 6].map(|_| rng.random_range(-1.5..1.5));
            if i % 2 == 0 {
                // At the wrist's singularity, and closer and closer to it.
                q[4] = rng.random_range(-1.0..1.0) * 10.0_f64.powi(-(i % 7));
            }
            let measured = kinematics.singularity(&robot, &q).unwrap();
            regular += usize::from(measured.smallest_singular_value > least);
            if let Some(side) = kinematics.side_if_regular(&robot, &q, least) {
                sure += 1;
                assert!(measured.smallest_singular_value > least, "{q:?}");
                assert_eq!(measured.is_right_handed, Some(side), "{q:?}");
            }
        }
        // Half of the poses are about the wrist's singularity, and still most need no closer look.
        let wanted = if least < 5e-3 { regular / 2 } else { 1 };
        assert!(regular < 4000 && sure > wanted, "{sure} of {regular}");
    }
}

#[test]
fn singular_poses_are_solved() {
    let robot = irb1600();
    let kinematics = InverseKinematics::new(&robot);
    for q in [
        [0.2, 0.3, -0.4, 0.5, 0.0, 0.7],
        [0.2, 0.3, -0.4, 0.5, 1e-9, 0.7],
        [0.2, 0.3, -0.4, 0.5, 1e-6, 0.7],
        [0.2, 0.3, -FRAC_PI_2, 0.5, 0.8, 0.7],
        [0.2, 0.3, -FRAC_PI_2 + 1e-7, 0.5, 0.8, 0.7],
        [0.0; 6],
    ] {
        let target = tip_at(&robot, &q);
        let solutions = kinematics.solutions(&robot, &target);
        assert!(!solutions.is_empty());
        for solution in &solutions {
            let (distance, angle) = apart(&tip_at(&robot, solution), &target);
            assert!(distance < 1e-11 && angle < 1e-11);
        }
        let seed = q.map(|q| q + 1e-4);
        let found = kinematics.near(&robot, &target, &seed).unwrap();
        let (distance, angle) = apart(&tip_at(&robot, &found), &target);
        assert!(distance < 2e-12 && angle < 1e-12, "{distance:e} {angle:e}");
        assert!(joint_distance(&robot, &found, &q) < 2e-3, "{found:?}");
    }
}

#[test]
fn bad_input_is_told() {
    let robot = irb1600();
    let kinematics = InverseKinematics::new(&robot);
    let seed = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5];
    let target = tip_at(&robot, &seed);
    let mut lost = target;
    lost.translation.x = f64::NAN;
    assert_eq!(kinematics.near(&robot, &lost, &seed), Err(IkFault::TargetNotFinite));
    assert!(kinematics.solutions(&robot, &lost).is_empty());
    lost.translation.x = f64::MAX;
    assert_eq!(kinematics.near(&robot, &lost, &seed), Err(IkFault::TargetNotFinite));
    let mut lost = target;
    lost.rotation =
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
    assert_eq!(kinematics.near(&robot, &lost, &seed), Err(IkFault::TargetNotFinite));
    let mut far = target;
    far.translation.x = 1e150;
    assert!(matches!(kinematics.near(&robot, &far, &seed), Err(IkFault::OutOfReach { .. })));

    let short = PoseFault::Length { given: 5, expected: 6 };
    assert_eq!(kinematics.near(&robot, &target, &seed[..5]), Err(IkFault::Seed(short.clone())));
    assert_eq!(kinematics.singularity(&robot, &seed[..5]), Err(short));
    let fault = kinematics.near(&robot, &target, &[f64::INFINITY; 6]).unwrap_err();
    assert_eq!(fault.to_string(), "starting joint 'joint_1': position is not a finite number");

    // Made for another robot.
    let other = seven_axes();
    assert!(kinematics.solutions(&other, &target).is_empty());
    assert!(kinematics.near(&other, &target, &[0.1; 7]).is_err());
    assert!(kinematics.singularity(&other, &[0.1; 7]).is_err());
}

/// An arm on a rail and one with seven axes: what is held stays, the tip arrives, and the joints go
/// no further than they were moved away from the pose.
#[test]
fn joints_that_are_held_stay_and_the_others_bring_the_tip_there() {
    let mut rows = vec![sliding([0.0, 0.0, 0.2], X, [0.0, 3.0])];
    rows.extend([
        turning([0.0, 0.0, 0.0], Z, [-180.0, 180.0]),
        turning([0.15, 0.0, 0.4865], Y, [-90.0, 120.0]),
        turning([0.0, 0.0, 0.7], Y, [-245.0, 65.0]),
        turning([0.3, 0.0, 0.0], X, [-200.0, 200.0]),
        turning([0.3, 0.0, 0.0], Y, [-115.0, 115.0]),
        turning([0.065, 0.0, 0.0], X, [-400.0, 400.0]),
    ]);
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for (robot, held_joint) in [(arm(&rows), 0), (seven_axes(), 2)] {
        let kinematics = InverseKinematics::new(&robot);
        let mut held = vec![false; robot.joints().len()];
        held[held_joint] = true;
        let mut reached = 0;
        for _ in 0..200 {
            let original = random_pose(&robot, &mut rng);
            let target = tip_at(&robot, &original);
            // Only what is held differs little: the arm stands near, on the same branch.
            let mut seed = original.clone();
            for (joint, q) in seed.iter_mut().enumerate() {
                if joint != held_joint {
                    *q += rng.random_range(-0.01..0.01);
                }
            }
            let singularity = kinematics.singularity(&robot, &original).unwrap();
            if singularity.smallest_singular_value < 0.05 || !is_within_limits(&robot, &seed) {
                continue;
            }
            let found = kinematics.near_holding(&robot, &target, &seed, &held).unwrap();
            assert_eq!(found[held_joint], seed[held_joint], "what is held moved");
            let (distance, angle) = apart(&tip_at(&robot, &found), &target);
            assert!(distance < 1e-9 && angle < 1e-9, "{distance:e} m, {angle:e} rad off");
            assert!(joint_distance(&robot, &found, &original) < 0.2, "{found:?} {original:?}");
            reached += 1;
            // The same pose with the held joint moved on: it stays where it is put.
            let mut moved = original.clone();
            moved[held_joint] += 0.005;
            if let Ok(found) = kinematics.near_holding(&robot, &target, &moved, &held) {
                assert_eq!(found[held_joint], moved[held_joint]);
                let (distance, angle) = apart(&tip_at(&robot, &found), &target);
                assert!(distance < 1e-9 && angle < 1e-9, "{distance:e} m, {angle:e} rad off");
            }
        }
        assert!(reached > 50, "{reached}");
        // Out of reach of the joints that are free.
        let far = Isometry3::translation(50.0, 0.0, 0.0);
        let seed = vec![0.1; robot.joints().len()];
        let refused = kinematics.near_holding(&robot, &far, &seed, &held);
        assert!(matches!(refused, Err(IkFault::OutOfReach { .. })), "{refused:?}");
    }
}
