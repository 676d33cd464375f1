//! The modal kernel pose by pose, against the same problem through nalgebra's own decompositions, a whole check of a path
//! of 100 000 waypoints, advice, maps and a diagnosis. `cargo bench` prints the figures.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use detune::advice::{Options, advise};
use detune::diagnosis::{Settings, diagnose};
use detune::input::{Reading, read_described_robot, read_measured};
use detune::job::{Carried, Job, Levers, Operation, Policy, Review, Spindle, SpindleSpeed, Tool};
use detune::map::{FrequencyMap, Method, Reduction};
use detune::model::{Placement, Robot, mass_matrix};
use detune::modes::ModalSolver;
use detune::motion::{Move, Target, Timing, Work};
use detune::progress::silent;
use detune::risk::assess;
use detune::study;
use detune::study::map::{Request, Source, run};
use nalgebra::{Cholesky, DMatrix, DVector, Isometry3, SymmetricEigen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const WAYPOINTS: usize = 100_000;

fn six_axes() -> Robot {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    detune::input::read_robot(&file, &mut Reading::default()).unwrap()
}

fn poses(robot: &Robot, count: usize) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    (0..count)
        .map(|_| robot.joints().iter().map(|_| rng.random_range(-1.0..1.0)).collect())
        .collect()
}

fn kernel(c: &mut Criterion) {
    let robot = six_axes();
    let poses = poses(&robot, 1000);
    let mut group = c.benchmark_group("1000 poses, six axes");
    group.bench_function("frequencies", |b| {
        let mut solver = ModalSolver::new(&robot);
        b.iter(|| poses.iter().map(|q| solver.frequencies_hz(q).unwrap()[0]).sum::<f64>());
    });
    group.bench_function("modes", |b| {
        let mut solver = ModalSolver::new(&robot);
        b.iter(|| poses.iter().map(|q| solver.solve(q).unwrap().damping_ratios[0]).sum::<f64>());
    });
    group.bench_function("alternative: nalgebra Cholesky and SymmetricEigen", |b| {
        let n = robot.coordinates().len();
        let stiffness = DVector::from_iterator(n, robot.coordinates().iter().map(|c| c.stiffness));
        let k = DMatrix::from_diagonal(&stiffness);
        let mut placement = Placement::new(&robot);
        let mut m = DMatrix::zeros(n, n);
        b.iter(|| {
            poses
                .iter()
                .map(|q| {
                    placement.place(&robot, q);
                    mass_matrix(&robot, &placement, &mut m);
                    let inverse = Cholesky::new(m.clone()).unwrap().l().try_inverse().unwrap();
                    SymmetricEigen::new(&inverse * &k * inverse.transpose()).eigenvalues.min()
                })
                .sum::<f64>()
        });
    });
    group.finish();
}

/// A pocket-like zigzag of 100 000 joint waypoints.
fn long_job(robot: &Arc<Robot>) -> Job {
    let moves = (0..WAYPOINTS)
        .map(|i| {
            let t = i as f64 / WAYPOINTS as f64;
            let sweep = (40.0 * t * std::f64::consts::TAU).sin();
            let q = vec![0.3 * sweep, 0.2 + 0.3 * t, -0.3 + 0.2 * t, 0.0, 0.8 + 0.1 * sweep, 0.0];
            Move {
                to: Target::Joints(q),
                feed_m_per_s: 0.02,
                tcp: Isometry3::translation(0.0, 0.0, 0.15),
                work: Work::Stands,
                line: i + 1,
                timing: Timing::Feed,
                spindle_turns: true,
                stated: Arc::default(),
            }
        })
        .collect();
    Job {
        name: "zigzag".into(),
        file: PathBuf::from("zigzag.yaml"),
        robot: robot.clone(),
        spindle: Spindle { min_rpm: 100.0, max_rpm: 24_000.0, max_acceleration_rpm_per_s: None },
        operations: vec![Operation::new(
            robot,
            Carried::NOTHING,
            Tool { teeth: 2, ..Tool::default() },
            SpindleSpeed::Constant(620.0),
            0.02,
            moves,
        )],
        policy: Policy {
            tooth_passing_harmonics: 2,
            spindle_harmonics: 1,
            separation: 0.1,
            model_uncertainty: Some(0.1),
            confidence: 0.95,
            ignore_hz: vec![],
            min_tip_response_m_per_n: Some(0.0),
            max_deflection_m: None,
            max_vibration_m: None,
        },
        levers: Levers::default(),
        review: Review::default(),
    }
}

fn long_check(c: &mut Criterion) {
    let robot = Arc::new(six_axes());
    let job = long_job(&robot);
    let risk = assess(&job, &silent).unwrap();
    println!(
        "{WAYPOINTS} waypoints: {} eigenproblems, {} crossings",
        risk.operations[0].poses_solved,
        risk.operations[0].crossings.len()
    );
    let mut group = c.benchmark_group("check");
    group.sample_size(10);
    group.bench_function("100 000 waypoints", |b| {
        b.iter(|| assess(black_box(&job), &silent).unwrap())
    });
    group.finish();
}

/// Six operations of 50 000 waypoints in all.
fn six_operations(robot: &Arc<Robot>) -> Job {
    let mut job = long_job(robot);
    let moves = job.operations[0].moves[..50_000].to_vec();
    job.spindle.max_acceleration_rpm_per_s = Some(500.0);
    job.operations = moves
        .chunks(moves.len().div_ceil(6))
        .enumerate()
        .map(|(i, part)| Operation {
            name: format!("operation {i}"),
            moves: Arc::new(part.to_vec()),
            stretch: 0..part.len(),
            entry: i,
            ..job.operations[0].clone()
        })
        .collect();
    job.policy.separation = 0.03;
    job.policy.model_uncertainty = Some(0.02);
    job
}

fn long_advice(c: &mut Criterion) {
    let robot = Arc::new(six_axes());
    let job = six_operations(&robot);
    let scheduled = Options { schedule: true, ..Options::default() };
    let mut group = c.benchmark_group("six operations, 50 000 waypoints");
    group.sample_size(10);
    group.bench_function("check", |b| b.iter(|| assess(black_box(&job), &silent).unwrap()));
    group.bench_function("advise", |b| {
        b.iter(|| advise(black_box(&job), &Options::default(), &silent).unwrap());
    });
    group.bench_function("advise --schedule", |b| {
        b.iter(|| advise(black_box(&job), &scheduled, &silent).unwrap());
    });
    group.finish();
}

/// Random poses mapped and reduced, as `detune map --random … --reduce` does.
fn long_map(c: &mut Criterion) {
    let robot = six_axes();
    let map = FrequencyMap::new(&robot, Method::Linear);
    let request = Request::Random { count: WAYPOINTS, seed: 1, at: Vec::new() };
    let mut group = c.benchmark_group("map");
    group.sample_size(10);
    group.bench_function("100 000 random poses, reduced", |b| {
        b.iter(|| {
            let source = Source::new(&request, &robot).unwrap();
            let mut reduction = Reduction::new(map.joints(), map.modes());
            run(source, &map, study::map::Target::Statistics(&mut reduction), &silent).unwrap();
            black_box(reduction.finish())
        });
    });
    group.finish();
}

/// The paper's arm against its measured table, as `detune diagnose` does it, on one thread and on all.
fn diagnosis(c: &mut Criterion) {
    let folder = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/two-link");
    let mut reading = Reading::default();
    let described = read_described_robot(&folder.join("robot.yaml"), &mut reading).unwrap();
    let table =
        read_measured(&folder.join("measured.csv"), &described.robot, &mut reading).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let run = || {
        diagnose(
            black_box(&described.description),
            &table,
            Settings::default(),
            &detune::progress::silent,
        )
        .unwrap()
    };
    let mut group = c.benchmark_group("diagnosis, 40 frequencies at 20 poses");
    group.sample_size(10);
    group.bench_function("one thread", |b| b.iter(|| one.install(run)));
    group.bench_function("all threads", |b| b.iter(run));
    group.finish();
}

criterion_group!(benches, kernel, long_check, long_advice, long_map, diagnosis);
criterion_main!(benches);
