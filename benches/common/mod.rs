//! Robots, poses and times for the benches.

use std::path::Path;
use std::time::Instant;

use detune::model::{Description, ElasticJoint, Inertial, Joint, JointKind, Link, Robot};
use nalgebra::{Isometry3, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) fn six_axes() -> Robot {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    detune::input::read_robot(&file, &mut detune::input::Reading::default()).unwrap()
}

/// A chain of `n` elastic joints about x, y and z in turn, each link lighter and shorter than the last.
pub(crate) fn chain(n: usize) -> Robot {
    let name = |i: usize| if i == 0 { "ground".to_owned() } else { format!("link_{i}") };
    let mut links = vec![Link { name: name(0), inertial: None, ..Link::default() }];
    let mut joints = Vec::new();
    let mut elastic_joints = Vec::new();
    for i in 1..=n {
        let size = 0.85_f64.powi(i as i32);
        let mass_kg = 60.0 * size;
        links.push(Link {
            name: name(i),
            inertial: Some(Inertial {
                mass_kg,
                com_m: Vector3::new(0.1, 0.02, 0.15) * size,
                inertia_kgm2: Matrix3::from_diagonal(&Vector3::new(0.03, 0.02, 0.025))
                    * (mass_kg * size),
            }),
            ..Link::default()
        });
        joints.push(Joint {
            name: format!("joint_{i}"),
            kind: JointKind::Revolute,
            parent: name(i - 1),
            child: name(i),
            origin: Isometry3::translation(0.2 * size, 0.0, 0.4 * size),
            axis: Vector3::ith(i % 3, 1.0),
            position_limit: Some([-3.0, 3.0]),
            velocity_limit: None,
            mimics: None,
        });
        elastic_joints.push(ElasticJoint {
            joint: format!("joint_{i}"),
            stiffness: 6e5 * size * size,
            is_linear: false,
            std: None,
            damping: None,
        });
    }
    Robot::new(&Description {
        name: format!("chain of {n}"),
        links,
        joints,
        base: None,
        tip: None,
        elastic_joints,
        extra: vec![],
        default_damping_ratio: 0.02,
        gravity_m_per_s2: -9.81 * Vector3::z(),
        gravity_stiffness: false,
        drives: vec![],
        payload: None,
        beta1: None,
        beta2: None,
        calibration: None,
        corrections: vec![],
    })
    .unwrap()
}

pub(crate) fn poses(robot: &Robot, count: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    (0..count * robot.joints().len())
        .map(|i| {
            let [lower, upper] =
                robot.joints()[i % robot.joints().len()].limit.unwrap_or([-3.0, 3.0]);
            rng.random_range(lower..=upper)
        })
        .collect()
}

/// Least ns a pose of `work` on `count` poses: other work on the machine only ever adds to it.
pub(crate) fn least_ns(count: usize, repetitions: usize, mut work: impl FnMut()) -> f64 {
    (0..repetitions)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e9 / count as f64
        })
        .fold(f64::INFINITY, f64::min)
}
