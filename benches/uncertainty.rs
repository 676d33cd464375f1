//! What intervals and probabilities cost: draws of the arm against the batch kernel's own time for as many
//! eigenproblems, and a survey with intervals against one without, each in the same run. `cargo bench --bench
//! uncertainty` prints both and fails where one is too dear.
//!
//! The least time of several rounds stands: other work on the machine only ever adds to it.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

use common::{least_ns, poses};
use detune::input::{Reading, read_described_robot};
use detune::job::{Carried, Job, Levers, Operation, Policy, Review, Spindle, SpindleSpeed, Tool};
use detune::model::Robot;
use detune::modes::batch::Kernel;
use detune::motion::{Move, Target, Timing, Work};
use detune::path::{Path, Survey, grid};
use detune::progress::silent;
use detune::risk::{
    Crossing, JobDraws, Paths, Rules, assess, crossings_under, detail, probabilities_under,
};
use detune::uncertainty::Trust;
use nalgebra::Isometry3;

#[allow(dead_code, reason = "what the other benches need")]
mod common;

/// Draws may cost so many times the kernel's time, at most.
const MAX_DRAWS: f64 = 10.0;

/// Intervals may add this share to a check, at most.
const MAX_INTERVALS: f64 = 1.0 / 3.0;

const ROUNDS: usize = 15;

/// Six axes, every number of which may be off.
fn uncertain_arm() -> Arc<Robot> {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    let mut described = read_described_robot(&file, &mut Reading::default()).unwrap().description;
    described.elastic_joints.iter_mut().for_each(|joint| joint.std = Some(0.15));
    described.links.iter_mut().for_each(|link| link.std = Some(0.10));
    Arc::new(Robot::new(&described).unwrap())
}

/// One operation of some 2000 stations, under a speed whose lines lie about the modes all along.
fn job(robot: &Arc<Robot>) -> Job {
    let via = [
        [0.0, 20.0, -10.0, 0.0, 60.0, 0.0],
        [20.0, 30.0, -20.0, 10.0, 70.0, 0.0],
        [-10.0, 10.0, -5.0, 0.0, 50.0, 20.0],
    ];
    let moves = via.iter().enumerate().map(|(i, q)| Move {
        to: Target::Joints(q.iter().map(|angle: &f64| angle.to_radians()).collect()),
        feed_m_per_s: 0.01,
        tcp: Isometry3::translation(0.0, 0.0, 0.15),
        work: Work::Stands,
        line: i + 1,
        timing: Timing::Feed,
        spindle_turns: true,
        stated: Arc::default(),
    });
    let tool = Tool { teeth: 3, ..Tool::default() };
    let speed = SpindleSpeed::Constant(3000.0);
    Job {
        name: "bench".into(),
        file: PathBuf::from("bench.yaml"),
        robot: robot.clone(),
        spindle: Spindle { min_rpm: 500.0, max_rpm: 24_000.0, max_acceleration_rpm_per_s: None },
        operations: vec![Operation::new(
            robot,
            Carried::NOTHING,
            tool,
            speed,
            0.01,
            moves.collect(),
        )],
        policy: Policy {
            tooth_passing_harmonics: 2,
            spindle_harmonics: 1,
            separation: 0.05,
            model_uncertainty: None,
            confidence: 0.95,
            ignore_hz: vec![],
            min_tip_response_m_per_n: None,
            max_deflection_m: None,
            max_vibration_m: None,
        },
        levers: Levers::default(),
        review: Review::default(),
    }
}

/// What a check does for its crossings, without draws.
fn crossings<'j>(job: &'j Job, path: &Path, trust: &Trust) -> (Rules<'j>, Survey, Vec<Crossing>) {
    let operation = &job.operations[0];
    let stations = grid(path, operation.speed.corners());
    let first_look = Survey::take(path, stations, detail(&job.policy), &silent).unwrap();
    let rules = Rules::new(&job.policy, trust, path, &first_look).unwrap();
    let (found, survey) =
        crossings_under(job, operation, &rules, &operation.speed, path, first_look).unwrap();
    (rules, survey, found)
}

fn draws(job: &Job, path: &Path, trust: &Trust) {
    let robot = path.robot();
    let n = robot.coordinates().len();
    let (rules, survey, found) = crossings(job, path, trust);
    let arm = JobDraws::default().of(trust, n);
    let run = || {
        let both = (&survey, found.as_slice());
        probabilities_under(job, &job.operations[0], &rules, &arm, path, both).unwrap()
    };
    let solved = run().solved;
    let some = poses(robot, 4096);
    let kernel = Kernel::new(robot);
    let mut f = vec![0.0; 4096 * n];
    let (mut own, mut of_kernel) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        own = own.min(least_ns(solved, 1, || {
            black_box(run());
        }));
        let pieces = solved.div_ceil(4096);
        of_kernel = of_kernel.min(least_ns(pieces * 4096, 1, || {
            for _ in 0..pieces {
                kernel.par_frequencies_hz(black_box(&some), &mut f).unwrap();
            }
        }));
    }
    println!(
        "{} draws on {} stations, {} crossings: {solved} eigenproblems, {:.1} ms; {own:.0} ns each, \
         kernel {of_kernel:.0} ns: {:.2} times, must be at most {MAX_DRAWS}",
        arm.count(),
        survey.len(),
        found.len(),
        own * solved as f64 * 1e-6,
        own / of_kernel
    );
    assert!(own <= MAX_DRAWS * of_kernel);
}

fn intervals(job: &Job, path: &Path, trust: &Trust) {
    let (mut with, mut without) = (f64::INFINITY, f64::INFINITY);
    // The widest bands that intervals would give, so that both look for crossings as hard.
    let modes = path.robot().coordinates().len();
    let by_mode = crossings(job, path, trust).0.uncertainty_by_mode(modes);
    let widest = by_mode.into_iter().fold(0.0, f64::max);
    for _ in 0..ROUNDS {
        with = with.min(least_ns(1, 1, || drop(black_box(crossings(job, path, trust)))));
        let share = Trust::Share(widest);
        without = without.min(least_ns(1, 1, || drop(black_box(crossings(job, path, &share)))));
    }
    let mut checked = job.clone();
    checked.policy.model_uncertainty = Some(widest);
    let whole = least_ns(1, ROUNDS, || drop(black_box(assess(&checked, &silent).unwrap())));
    println!(
        "crossings with intervals {:.2} ms, without {:.2} ms; a check without {:.2} ms: {:+.1} %, must be at \
         most {:.1} %",
        with * 1e-6,
        without * 1e-6,
        whole * 1e-6,
        100.0 * (with - without) / whole,
        100.0 * MAX_INTERVALS
    );
    assert!(with - without <= MAX_INTERVALS * whole);
}

fn main() {
    let robot = uncertain_arm();
    let job = job(&robot);
    let path = Paths::of(&job).plan(&job.operations[0]).unwrap();
    let trust = Trust::of(&robot, None);
    assert!(matches!(trust, Trust::Belief(_)));
    draws(&job, &path, &trust);
    intervals(&job, &path, &trust);
}
