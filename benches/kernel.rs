//! ns a pose of the scalar path and of the batch kernel at every instruction set that the machine has.
//! `cargo bench --bench kernel` prints it; `cargo bench --bench kernel -- quick` prints the six-axis arm alone.
//!
//! The least time of several repetitions stands: other work on the machine only ever adds to it.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use common::{chain, least_ns, poses, six_axes};
use detune::model::{Robot, elastic_jacobian};
use detune::modes::batch::{InstructionSet, Kernel, ModesOut, TipOut};
use detune::modes::{ModalSolver, peak_tip_compliance_m_per_n};
use nalgebra::{Matrix6xX, Point3};

mod common;

const REPETITIONS: usize = 7;

/// ns a pose for frequencies, with tip participation, with whole modes.
fn scalar_ns(robot: &Robot, poses: &[f64], tcp_m: &Point3<f64>) -> [f64; 3] {
    let joints = robot.joints().len();
    let count = poses.len() / joints;
    let mut solver = ModalSolver::new(robot);
    let n = robot.coordinates().len();
    let mut jacobian = Matrix6xX::zeros(n);
    let frequencies = least_ns(count, REPETITIONS, || {
        for q in poses.chunks_exact(joints) {
            black_box(solver.frequencies_hz(q).unwrap());
        }
    });
    let modes = least_ns(count, REPETITIONS, || {
        for q in poses.chunks_exact(joints) {
            black_box(solver.solve(q).unwrap());
        }
    });
    let tip = least_ns(count, REPETITIONS, || {
        for q in poses.chunks_exact(joints) {
            solver.solve(q).unwrap();
            elastic_jacobian(robot, solver.placement(), tcp_m, &mut jacobian);
            for r in 0..n {
                black_box(peak_tip_compliance_m_per_n(solver.modes(), &jacobian, r));
            }
        }
    });
    [frequencies, tip, modes]
}

fn batch_ns(
    kernel: &Kernel,
    n: usize,
    joints: usize,
    poses: &[f64],
    tcp_m: &Point3<f64>,
) -> [f64; 3] {
    let count = poses.len() / joints;
    let mut f = vec![0.0; count * n];
    let frequencies =
        least_ns(count, REPETITIONS, || kernel.frequencies_hz(poses, black_box(&mut f)).unwrap());
    let mut c = vec![0.0; count * n];
    let tip = least_ns(count, REPETITIONS, || {
        let out = TipOut {
            natural_frequencies_hz: black_box(&mut f),
            peak_compliances_m_per_n: black_box(&mut c),
        };
        kernel.tip(poses, tcp_m, out).unwrap();
    });
    let mut shapes = vec![0.0; count * n * n];
    let modes = least_ns(count, REPETITIONS, || {
        let out = ModesOut {
            natural_frequencies_hz: black_box(&mut f),
            shapes: black_box(&mut shapes),
            damping_ratios: black_box(&mut c),
        };
        kernel.modes(poses, out).unwrap();
    });
    [frequencies, tip, modes]
}

fn row(what: &str, ns: [f64; 3]) {
    println!("{what:<44} {:>10.1} {:>10.1} {:>10.1}", ns[0], ns[1], ns[2]);
}

fn sizes(robot: &Robot, count: usize) {
    let n = robot.coordinates().len();
    let joints = robot.joints().len();
    let poses = poses(robot, count);
    let tcp_m = Point3::new(0.0, 0.0, 0.15);
    row(&format!("n = {n:>2}  scalar"), scalar_ns(robot, &poses, &tcp_m));
    for set in InstructionSet::available() {
        let kernel = Kernel::with_instructions(robot, set).unwrap();
        let ns = batch_ns(&kernel, n, joints, &poses, &tcp_m);
        row(&format!("n = {n:>2}  batch, {set:?}, {} lanes", kernel.lanes()), ns);
    }
}

/// What `peers/run.py` asks for: the poses of a file by one way, the results to another file, and the least
/// and the median ns a pose.
fn beside_peers(poses: &str, out: &str, which: &str, what: &str) {
    let robot = six_axes();
    let n = robot.coordinates().len();
    let poses: Vec<f64> = std::fs::read(poses)
        .unwrap()
        .chunks_exact(8)
        .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()))
        .collect();
    let count = poses.len() / robot.joints().len();
    let tcp_m = Point3::new(0.0, 0.0, 0.15);
    let (mut f, mut c) = (vec![0.0; count * n], vec![0.0; count * n]);
    let mut solver = ModalSolver::new(&robot);
    let mut jacobian = Matrix6xX::zeros(n);
    let kernel = InstructionSet::available()
        .into_iter()
        .find(|set| format!("{set:?}") == which)
        .and_then(|set| Kernel::with_instructions(&robot, set));
    let mut ns: Vec<f64> = (0..15)
        .map(|_| {
            let start = Instant::now();
            match (&kernel, what) {
                (Some(kernel), "tip") => {
                    let out =
                        TipOut { natural_frequencies_hz: &mut f, peak_compliances_m_per_n: &mut c };
                    kernel.tip(&poses, &tcp_m, out).unwrap();
                }
                (Some(kernel), _) => kernel.frequencies_hz(&poses, &mut f).unwrap(),
                (None, _) => {
                    for (i, q) in poses.chunks_exact(robot.joints().len()).enumerate() {
                        let row = i * n..(i + 1) * n;
                        if what == "tip" {
                            solver.solve(q).unwrap();
                            elastic_jacobian(&robot, solver.placement(), &tcp_m, &mut jacobian);
                            f[row.clone()].copy_from_slice(&solver.modes().natural_frequencies_hz);
                            for (r, c) in c[row].iter_mut().enumerate() {
                                *c = peak_tip_compliance_m_per_n(solver.modes(), &jacobian, r);
                            }
                        } else {
                            f[row].copy_from_slice(solver.frequencies_hz(q).unwrap());
                        }
                    }
                }
            }
            start.elapsed().as_secs_f64() * 1e9 / count as f64
        })
        .collect();
    ns.sort_by(f64::total_cmp);
    println!("{} {}", ns[0], ns[ns.len() / 2]);
    let rows = f.chunks_exact(n).zip(c.chunks_exact(n));
    let bytes: Vec<u8> = rows
        .flat_map(|(f, c)| f.iter().chain(if what == "tip" { c } else { &[] }))
        .flat_map(|x| x.to_le_bytes())
        .collect();
    std::fs::write(out, bytes).unwrap();
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    if let [_, "peers", poses, out, which, what, ..] = arguments[..] {
        return beside_peers(poses, out, which, what);
    }
    if arguments.contains(&"sets") {
        return InstructionSet::available().iter().for_each(|set| println!("{set:?}"));
    }
    println!("{:<44} {:>10} {:>10} {:>10}", "ns a pose", "frequencies", "and tip", "and shapes");
    sizes(&six_axes(), 20_000);
    if arguments.contains(&"quick") {
        return;
    }
    for n in [2, 6, 7, 8, 12, 24] {
        sizes(&chain(n), if n < 12 { 20_000 } else { 2_000 });
    }
}
