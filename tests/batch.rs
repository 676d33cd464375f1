//! The batch kernel against the scalar path.

#![allow(clippy::unwrap_used)]

use detune::model::{Robot, elastic_jacobian};
use detune::modes::batch::{InstructionSet, Kernel, ModesOut, TipOut};
use detune::modes::{ModalSolver, peak_tip_compliance_m_per_n};
use nalgebra::{Matrix6xX, Point3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

mod random_robot;

/// What one pass over some poses gives.
struct Solved {
    frequencies: Vec<f64>,
    shapes: Vec<f64>,
    damping: Vec<f64>,
    compliances: Vec<f64>,
}

fn by_batch(kernel: &Kernel, robot: &Robot, poses: &[f64], tcp: &Point3<f64>) -> Solved {
    let n = robot.coordinates().len();
    let count = poses.len() / robot.joints().len();
    let mut s = Solved {
        frequencies: vec![0.0; count * n],
        shapes: vec![0.0; count * n * n],
        damping: vec![0.0; count * n],
        compliances: vec![0.0; count * n],
    };
    let out = TipOut {
        natural_frequencies_hz: &mut s.frequencies,
        peak_compliances_m_per_n: &mut s.compliances,
    };
    kernel.tip(poses, tcp, out).unwrap();
    let out = ModesOut {
        natural_frequencies_hz: &mut s.frequencies,
        shapes: &mut s.shapes,
        damping_ratios: &mut s.damping,
    };
    kernel.modes(poses, out).unwrap();
    kernel.frequencies_hz(poses, &mut s.frequencies).unwrap();
    s
}

#[test]
fn explore() {
    for seed in 0..300 {
        let mut description = random_robot::description(seed);
        for gravity in [false, true] {
            description.gravity_stiffness = gravity;
            let Ok(robot) = Robot::new(&description) else { continue };
            let n = robot.coordinates().len();
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let joints = robot.joints().len();
            let poses: Vec<f64> = (0..13 * joints).map(|_| rng.random_range(-2.0..2.0)).collect();
            let tcp = Point3::new(0.1, -0.2, 0.3);
            let mut solver = ModalSolver::new(&robot);
            if poses.chunks_exact(joints).any(|q| solver.solve(q).is_err()) { println!("skip {seed}"); continue; }
            for set in InstructionSet::available() {
                let kernel = Kernel::with_instructions(&robot, set).unwrap();
                let s = by_batch(&kernel, &robot, &poses, &tcp);
                let mut solver = ModalSolver::new(&robot);
                let mut worst = [0.0_f64; 4];
                for (i, q) in poses.chunks_exact(joints).enumerate() {
                    let m = solver.solve(q).unwrap().clone();
                    let mut jacobian = Matrix6xX::zeros(n);
                    elastic_jacobian(&robot, solver.placement(), &tcp, &mut jacobian);
                    let most = (0..n).map(|r| peak_tip_compliance_m_per_n(&m, &jacobian, r)).fold(0.0, f64::max);
                    for r in 0..n {
                        worst[0] = worst[0].max((s.frequencies[i * n + r] / m.natural_frequencies_hz[r] - 1.0).abs());
                        worst[1] = worst[1].max((s.damping[i * n + r] / m.damping_ratios[r] - 1.0).abs());
                        let c = peak_tip_compliance_m_per_n(&m, &jacobian, r);
                        worst[2] = worst[2].max((s.compliances[i * n + r] - c).abs() / most);
                        let top = m.shapes.column(r).amax();
                        for k in 0..n {
                            worst[3] = worst[3].max((s.shapes[(i * n + r) * n + k] - m.shapes[(k, r)]).abs() / top);
                        }
                    }
                }
                if worst.iter().any(|w| !(*w < 1e-11)) {
                    println!("seed {seed} gravity {gravity} {set:?} n {n}: {worst:?}");
                }
            }
        }
    }
}
