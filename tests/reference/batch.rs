//! The batch kernel, at every instruction set that the machine has, against the scalar path, against a
//! solution in twice the digits, and against itself: neighbours, threads and remainders change no bit.

use detune::model::{
    Cause, CoordinateKind, Correction, Description, ExtraCoordinate, JointKind, PoseFault, Robot,
    elastic_jacobian,
};
use detune::modes::batch::{BatchFault, InstructionSet, Kernel, ModesOut, TipOut};
use detune::modes::{ModalSolver, Modes, peak_tip_compliance_m_per_n};
use nalgebra::{Matrix6xX, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

// Not all of its helpers are of use here.
use crate::exact::{Chain, frequencies_hz as exact_frequencies_hz};

const TCP_M: Point3<f64> = Point3::new(0.1, -0.2, 0.3);

/// What one pass over some poses gives.
#[derive(Clone, PartialEq, Debug)]
struct Solved {
    frequencies: Vec<f64>,
    shapes: Vec<f64>,
    damping: Vec<f64>,
    compliances: Vec<f64>,
}

impl Solved {
    fn room(n: usize, count: usize) -> Self {
        Self {
            frequencies: vec![0.0; count * n],
            shapes: vec![0.0; count * n * n],
            damping: vec![0.0; count * n],
            compliances: vec![0.0; count * n],
        }
    }
}

fn kernels(robot: &Robot) -> Vec<Kernel<'_>> {
    let sets = InstructionSet::available();
    sets.into_iter().map(|set| Kernel::with_instructions(robot, set).unwrap()).collect()
}

/// Frequencies come from each of the three ways, which must agree to rounding.
fn solve(kernel: &Kernel, robot: &Robot, poses: &[f64], threads: bool) -> Solved {
    let n = robot.coordinates().len();
    let count = poses.len() / robot.joints().len();
    let mut s = Solved::room(n, count);
    let (mut with_tip, mut with_modes) = (s.frequencies.clone(), s.frequencies.clone());
    let tip = TipOut {
        natural_frequencies_hz: &mut with_tip,
        peak_compliances_m_per_n: &mut s.compliances,
    };
    let modes = ModesOut {
        natural_frequencies_hz: &mut with_modes,
        shapes: &mut s.shapes,
        damping_ratios: &mut s.damping,
    };
    if threads {
        kernel.par_tip(poses, &TCP_M, tip).unwrap();
        kernel.par_modes(poses, modes).unwrap();
        kernel.par_frequencies_hz(poses, &mut s.frequencies).unwrap();
    } else {
        kernel.tip(poses, &TCP_M, tip).unwrap();
        kernel.modes(poses, modes).unwrap();
        kernel.frequencies_hz(poses, &mut s.frequencies).unwrap();
    }
    for (alone, others) in s.frequencies.iter().zip(with_tip.iter().zip(&with_modes)) {
        assert!((others.0 / alone - 1.0).abs() < 1e-12, "{alone} with tip {}", others.0);
        assert!((others.1 / alone - 1.0).abs() < 1e-12, "{alone} with modes {}", others.1);
    }
    s
}

fn limits(robot: &Robot, joint: usize) -> [f64; 2] {
    robot.joints()[joint].limit.unwrap_or([-3.0, 3.0])
}

fn random_poses(robot: &Robot, count: usize, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let joints = robot.joints().len();
    (0..count * joints)
        .map(|i| {
            let [lower, upper] = limits(robot, i % joints);
            rng.random_range(lower..=upper)
        })
        .collect()
}

fn irb1600() -> Robot {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    detune::input::read_robot(&file, &mut detune::input::Reading::default()).unwrap()
}

/// Largest relative difference of the frequencies from the scalar path.
fn worst_against_scalar(robot: &Robot, poses: &[f64], found: &[f64]) -> f64 {
    let mut solver = ModalSolver::new(robot);
    let n = robot.coordinates().len();
    poses
        .chunks_exact(robot.joints().len())
        .zip(found.chunks_exact(n))
        .flat_map(|(q, row)| {
            let expected = solver.frequencies_hz(q).unwrap();
            row.iter().zip(expected).map(|(f, e)| (f / e - 1.0).abs()).collect::<Vec<_>>()
        })
        .fold(0.0, f64::max)
}

#[test]
fn a_million_poses_of_the_six_axis_arm_agree_with_the_scalar_path() {
    let robot = irb1600();
    let poses = random_poses(&robot, 1_000_000, 3);
    let mut found = vec![0.0; poses.len()];
    Kernel::new(&robot).par_frequencies_hz(&poses, &mut found).unwrap();
    let worst = worst_against_scalar(&robot, &poses, &found);
    println!("a million poses: worst {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}

/// Robots of every kind: branches, slides, rigid joints, extra coordinates, drives, payload, dashpots, with and
/// without the stiffness of gravity. Differences count as shares of what the coordinates' scale allows: a mass
/// matrix that is nearly singular (a determinant of 1e-9 of its diagonal's) has no twelve digits to give.
#[test]
fn random_robots_agree_with_the_scalar_path() {
    let mut compared = 0;
    for seed in 0..200 {
        let mut description = crate::random_robot::description(seed);
        for gravity in [false, true] {
            description.gravity_stiffness = gravity;
            let Ok(robot) = Robot::new(&description) else { continue };
            let poses = random_poses(&robot, 11, seed);
            compared += compare_all(&robot, &poses, &format!("seed {seed}, gravity {gravity}"));
        }
    }
    assert!(compared > 3000, "only {compared} poses were compared");
}

/// Springs that follow load and temperature, as a diagnosis writes them into a robot's file.
#[test]
fn springs_with_laws_agree_with_the_scalar_path() {
    let law = |cause, at: &str, name: &str, change: f64| Correction {
        cause,
        at: Some(at.to_owned()),
        parameters: vec![(name.to_owned(), change), ("factor".to_owned(), 0.8)],
        hinge: None,
    };
    let (mut compared, mut moved) = (0, 0);
    for seed in 0..40 {
        let mut description = crate::random_robot::description(seed);
        let Ok(plain) = Robot::new(&description) else { continue };
        for spring in &description.elastic_joints {
            let warm = law(Cause::TemperatureDrift, &spring.joint, "change_per_k", -1e-3);
            let loaded = law(Cause::LoadDependentStiffness, &spring.joint, "change_per_nm", 2e-3);
            description.corrections.push(warm);
            let slides = description
                .joints
                .iter()
                .any(|joint| joint.name == spring.joint && joint.kind == JointKind::Prismatic);
            if seed % 2 == 0 && !slides {
                description.corrections.push(loaded);
            }
        }
        let robot = Robot::new(&description).unwrap();
        let poses = random_poses(&robot, 5, seed);
        compared += compare_all(&robot, &poses, &format!("seed {seed}"));
        let q = &poses[..robot.joints().len()];
        if let (Ok(with), Ok(without)) = (Modes::at(&robot, q), Modes::at(&plain, q)) {
            let [with, without] = [with, without].map(|modes| modes.natural_frequencies_hz[0]);
            moved += usize::from((with / without - 1.0).abs() > 1e-3);
        }
    }
    assert!(compared > 100 && moved > 20, "{compared} poses compared, {moved} moved");
}

/// Every result of every kernel against the scalar path; the number of poses compared.
fn compare_all(robot: &Robot, poses: &[f64], what: &str) -> usize {
    let (n, joints) = (robot.coordinates().len(), robot.joints().len());
    let mut solver = ModalSolver::new(robot);
    if poses.chunks_exact(joints).any(|q| solver.solve(q).is_err()) {
        return 0;
    }
    for kernel in kernels(robot) {
        let found = solve(&kernel, robot, poses, false);
        for (i, q) in poses.chunks_exact(joints).enumerate() {
            let modes = solver.solve(q).unwrap().clone();
            let slack = slack(solver.mass());
            let mut jacobian = Matrix6xX::zeros(n);
            elastic_jacobian(robot, solver.placement(), &TCP_M, &mut jacobian);
            let compliance = |r| peak_tip_compliance_m_per_n(&modes, &jacobian, r);
            let largest = (0..n).map(compliance).fold(0.0, f64::max);
            for r in 0..n {
                let (f, e) = (found.frequencies[i * n + r], modes.natural_frequencies_hz[r]);
                assert!((f / e - 1.0).abs() < 1e-12 * slack, "{what}: f{r} {f} against {e}");
                let apart = separation(&modes, r);
                let (z, e) = (found.damping[i * n + r], modes.damping_ratios[r]);
                assert!((z / e - 1.0).abs() < 1e-11 * slack / apart, "{what}: ζ{r} {z}, {e}");
                let (c, e) = (found.compliances[i * n + r], compliance(r));
                let off = (c - e).abs() / largest;
                assert!(off < 1e-11 * slack / apart, "{what}: compliance {r} {c}, {e}");
                let shape = &found.shapes[(i * n + r) * n..(i * n + r + 1) * n];
                check_residual(&solver, shape, f, what);
            }
        }
    }
    poses.len() / joints
}

/// 1, or more where M, scaled to a unit diagonal, is nearly singular.
fn slack(mass: &nalgebra::DMatrix<f64>) -> f64 {
    let n = mass.nrows();
    let unit = nalgebra::DMatrix::from_fn(n, n, |i, j| {
        mass[(i, j)] / (mass[(i, i)] * mass[(j, j)]).sqrt()
    });
    (1e-3 / unit.symmetric_eigenvalues().min()).max(1.0)
}

/// How far mode r's frequency lies from its neighbours', as a share, at most one.
fn separation(modes: &Modes, r: usize) -> f64 {
    let f = &modes.natural_frequencies_hz;
    let gap = |other: usize| (f[other] / f[r] - 1.0).abs();
    let below = if r > 0 { gap(r - 1) } else { 1.0 };
    let above = if r + 1 < f.len() { gap(r + 1) } else { 1.0 };
    below.min(above).min(1.0)
}

/// ‖Kφ − ω²Mφ‖ ≤ 1e-10 ‖Kφ‖ and φᵀMφ = 1 with the scalar path's M and K. Rows are weighed by their springs,
/// which makes one of N·m and N.
fn check_residual(solver: &ModalSolver, shape: &[f64], f: f64, what: &str) {
    let (m, k) = (solver.mass(), solver.stiffness());
    let phi = nalgebra::DVector::from_row_slice(shape);
    let omega = std::f64::consts::TAU * f;
    let (k_phi, m_phi) = (k * &phi, m * &phi);
    let weigh = |v: &nalgebra::DVector<f64>| {
        v.iter().enumerate().map(|(i, x)| x * x / k[(i, i)]).sum::<f64>().sqrt()
    };
    let residual = weigh(&(&k_phi - &m_phi * (omega * omega))) / weigh(&k_phi);
    assert!(residual <= 1e-10, "{what}: residual {residual:e} at {f} Hz");
    assert!((phi.dot(&m_phi) - 1.0).abs() < 1e-10, "{what}: φᵀMφ = {}", phi.dot(&m_phi));
}

#[test]
fn the_six_axis_arm_agrees_in_everything() {
    let robot = irb1600();
    let compared = compare_all(&robot, &random_poses(&robot, 1003, 5), "irb1600");
    assert_eq!(compared, 1003);
}

/// Chains of every size up to 24, with dampings that differ and with one for all.
#[test]
fn every_size_agrees_with_the_scalar_path() {
    for n in 1..=24 {
        let chain = Chain::new(n, |i| 6e5 * 0.7_f64.powi(i as i32));
        for alike in [true, false] {
            let mut description = chain.description();
            if !alike {
                for (i, spring) in description.elastic_joints.iter_mut().enumerate() {
                    let zeta = 0.01 * (1 + i % 5) as f64;
                    spring.damping = Some(detune::model::Damping::Ratio(zeta));
                }
            }
            let robot = Robot::new(&description).unwrap();
            let compared = compare_all(&robot, &random_poses(&robot, 13, n as u64), "chain");
            assert_eq!(compared, 13, "n = {n}");
        }
    }
}

/// Against the reference in twice the digits: largest relative difference of a frequency.
fn worst_against_exact(chain: &Chain, count: usize, seed: u64) -> f64 {
    let robot = Robot::new(&chain.description()).unwrap();
    let poses = random_poses(&robot, count, seed);
    let n = robot.coordinates().len();
    let exact: Vec<f64> = poses
        .chunks_exact(robot.joints().len())
        .flat_map(|q| exact_frequencies_hz(chain, q))
        .collect();
    kernels(&robot)
        .iter()
        .map(|kernel| {
            let mut found = vec![0.0; count * n];
            kernel.frequencies_hz(&poses, &mut found).unwrap();
            found.iter().zip(&exact).map(|(f, e)| (f / e - 1.0).abs()).fold(0.0, f64::max)
        })
        .fold(0.0, f64::max)
}

#[test]
fn ten_thousand_poses_agree_with_the_exact_solution() {
    let chain = Chain::new(6, |i| [6e5, 5.55e5, 1.38e5, 6e4, 5e4, 4e4][i]);
    let worst = worst_against_exact(&chain, 10_000, 11);
    println!("six axes: worst {worst:.1e}");
    assert!(worst < 1e-13, "{worst:e}");
}

/// Springs from 1e2 to 1e9 N·m/rad, stiff and soft ones beside each other.
#[test]
fn stiffness_over_seven_decades_agrees_with_the_exact_solution() {
    for springs in [
        [1e9, 1e2, 1e7, 1e4, 1e6, 1e3],
        [1e2, 1e9, 1e3, 1e8, 1e4, 1e5],
        [1e9, 1e8, 1e6, 1e5, 1e3, 1e2],
    ] {
        let worst = worst_against_exact(&Chain::new(6, |i| springs[i]), 500, 12);
        println!("{springs:?}: worst {worst:.1e}");
        assert!(worst < 1e-13, "{springs:?}: {worst:e}");
    }
}

/// A joint without a spring moves with the pose and not with the vibration.
#[test]
fn a_rigid_joint_agrees_with_the_exact_solution() {
    for rigid in 0..6 {
        let mut chain = Chain::new(6, |i| [6e5, 5.55e5, 1.38e5, 6e4, 5e4, 4e4][i]);
        chain.links[rigid].stiffness = None;
        let worst = worst_against_exact(&chain, 500, 13);
        assert!(worst < 1e-13, "joint {rigid}: {worst:e}");
    }
}

/// A ball on six springs: three slides and three turns through its centre of mass, each three alike, so that
/// the frequencies are known, √(k/m) and √(k/I), and repeat; then with springs that differ by 1e-12 to 1e-3.
#[test]
fn repeated_and_close_frequencies_are_exact() {
    let (mass, inertia, k) = (40.0_f64, 1.6_f64, 1e6_f64);
    for apart in [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3] {
        let mut description = crate::planar_arm::two_link();
        description.elastic_joints.clear();
        let body = description.links[2].inertial.as_mut().unwrap();
        body.mass_kg = mass;
        body.inertia_kgm2 = nalgebra::Matrix3::from_diagonal_element(inertia);
        body.com_m = Vector3::new(0.1, 0.0, 0.0);
        let mut expected = Vec::new();
        for i in 0..6 {
            let stiffness = k * (1.0 + apart * i as f64);
            let kind = if i < 3 { CoordinateKind::Translation } else { CoordinateKind::Rotation };
            description.extra.push(ExtraCoordinate {
                name: format!("extra {i}"),
                link: "two".into(),
                kind,
                axis: Vector3::ith(i % 3, 1.0),
                origin_m: Vector3::new(0.1, 0.0, 0.0),
                stiffness,
                std: None,
                damping: None,
            });
            let moved = if i < 3 { mass } else { inertia };
            expected.push((stiffness / moved).sqrt() / std::f64::consts::TAU);
        }
        expected.sort_by(f64::total_cmp);
        let robot = Robot::new(&description).unwrap();
        for kernel in kernels(&robot) {
            let poses = random_poses(&robot, 9, 17);
            let found = solve(&kernel, &robot, &poses, false);
            for row in found.frequencies.chunks_exact(6) {
                for (f, e) in row.iter().zip(&expected) {
                    assert!((f / e - 1.0).abs() < 1e-13, "{apart:e}: {f} against {e}");
                }
            }
            assert!(compare_frequencies_and_residuals(&robot, &poses, &found));
        }
    }
}

fn compare_frequencies_and_residuals(robot: &Robot, poses: &[f64], found: &Solved) -> bool {
    let n = robot.coordinates().len();
    let mut solver = ModalSolver::new(robot);
    for (i, q) in poses.chunks_exact(robot.joints().len()).enumerate() {
        solver.frequencies_hz(q).unwrap();
        for r in 0..n {
            let shape = &found.shapes[(i * n + r) * n..(i * n + r + 1) * n];
            check_residual(&solver, shape, found.frequencies[i * n + r], "close");
        }
    }
    true
}

/// One pose alone, a batch with a remainder, two threads and eight: the same bits.
#[test]
fn neighbours_threads_and_remainders_change_no_bit() {
    for seed in [0, 1, 2, 3] {
        let chain = Chain::new(3 + 3 * seed as usize, |i| 1e5 / (1 + i) as f64);
        let robot = Robot::new(&chain.description()).unwrap();
        let (n, joints) = (robot.coordinates().len(), robot.joints().len());
        let poses = random_poses(&robot, 2051, seed);
        for kernel in kernels(&robot) {
            let together = solve(&kernel, &robot, &poses, false);
            for threads in [1, 2, 8] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                assert!(pool.install(|| solve(&kernel, &robot, &poses, true)) == together);
            }
            for i in [0, 1, 7, 1024, 2050] {
                let alone = solve(&kernel, &robot, &poses[i * joints..(i + 1) * joints], false);
                assert_eq!(alone.frequencies, together.frequencies[i * n..(i + 1) * n]);
                assert_eq!(alone.compliances, together.compliances[i * n..(i + 1) * n]);
                assert_eq!(alone.shapes, together.shapes[i * n * n..(i + 1) * n * n]);
            }
        }
    }
}

#[test]
fn faults_are_those_of_the_scalar_path() {
    let robot = irb1600();
    for kernel in kernels(&robot) {
        let mut poses = random_poses(&robot, 3000, 1);
        let mut out = vec![0.0; poses.len()];
        // The first one counts; joint 1 counts although no frequency depends on it.
        poses[2500 * 6 + 3] = f64::INFINITY;
        poses[1025 * 6] = f64::NAN;
        let fault = BatchFault::Pose {
            pose: 1025,
            fault: PoseFault::NotFinite { joint: "joint_1".into() },
        };
        assert_eq!(kernel.frequencies_hz(&poses, &mut out), Err(fault.clone()));
        assert_eq!(kernel.par_frequencies_hz(&poses, &mut out), Err(fault));
        let short = kernel.frequencies_hz(&poses[1..], &mut out);
        assert_eq!(short, Err(BatchFault::Poses { given: 17_999, joints: 6 }));
        let room = kernel.frequencies_hz(&poses, &mut out[1..]);
        assert_eq!(room, Err(BatchFault::Room { given: 17_999, expected: 18_000 }));
        assert_eq!(kernel.frequencies_hz(&[], &mut []), Ok(()));
    }
}

/// Two turns about axes through a point mass's line: M loses a rank where the axes meet in one line.
#[test]
fn a_singular_mass_matrix_is_the_scalar_paths_fault() {
    let mut description: Description = crate::planar_arm::two_link();
    // Joint 2 above joint 1, so that both turn about one line at every pose.
    description.joints[1].origin = nalgebra::Isometry3::identity();
    description.links[1].inertial = None;
    let robot = Robot::new(&description).unwrap();
    let expected = ModalSolver::new(&robot).frequencies_hz(&[0.1, 0.2]).unwrap_err();
    assert_eq!(expected, PoseFault::MassNotPositive { coordinate: "j2".into() });
    for kernel in kernels(&robot) {
        let found = kernel.frequencies_hz(&[0.1, 0.2, 0.3, 0.4], &mut [0.0; 4]);
        assert_eq!(found, Err(BatchFault::Pose { pose: 0, fault: expected.clone() }));
    }
}

/// A spring that gravity overcomes at some poses and not at others.
#[test]
fn a_spring_that_gives_way_is_the_scalar_paths_fault() {
    let mut description = crate::planar_arm::two_link();
    description.gravity_stiffness = true;
    description.elastic_joints[1].stiffness = 20.0;
    let robot = Robot::new(&description).unwrap();
    let mut solver = ModalSolver::new(&robot);
    let poses: Vec<f64> = (0..40).flat_map(|i| [0.0, -1.9 + 0.1 * f64::from(i)]).collect();
    let outcomes: Vec<_> =
        poses.chunks_exact(2).map(|q| solver.frequencies_hz(q).map(<[f64]>::to_vec)).collect();
    let first = outcomes.iter().position(Result::is_err).unwrap();
    assert!(outcomes.iter().any(Result::is_ok), "every pose falls over");
    for kernel in kernels(&robot) {
        let mut out = [0.0; 80];
        let found = kernel.frequencies_hz(&poses, &mut out);
        let fault = outcomes[first].clone().unwrap_err();
        assert_eq!(found, Err(BatchFault::Pose { pose: first, fault }));
        for (q, outcome) in poses.chunks_exact(2).zip(&outcomes) {
            let mut row = [0.0; 2];
            let found = kernel.frequencies_hz(q, &mut row).is_ok();
            assert_eq!(found, outcome.is_ok(), "at {q:?}");
        }
    }
}

/// Angles beyond what the reduction of angles is made for take the scalar path.
#[test]
fn many_turns_change_nothing_but_the_last_digits() {
    let robot = irb1600();
    for turns in [1.0, 100.0, 1e6, 1e12] {
        let q: Vec<f64> = (0..6).map(|i| 0.3 * f64::from(i) + turns).collect();
        let mut found = vec![0.0; 6];
        Kernel::new(&robot).frequencies_hz(&q, &mut found).unwrap();
        let worst = worst_against_scalar(&robot, &q, &found);
        assert!(worst < 1e-12, "{turns}: {worst:e}");
    }
}

#[test]
fn the_batch_does_not_allocate_per_pose() {
    let robot = irb1600();
    let kernel = Kernel::new(&robot);
    let counted = |count: usize| {
        let poses = random_poses(&robot, count, 2);
        let mut out = vec![0.0; poses.len()];
        allocation_counter::measure(|| kernel.frequencies_hz(&poses, &mut out).unwrap()).count_total
    };
    assert!(counted(8) > 0, "the counter does not count");
    assert_eq!(counted(8), counted(8000));
}
