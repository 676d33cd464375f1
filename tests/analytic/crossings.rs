//! Crossings against a brute-force scan that shares no code with the crate: closed-form frequencies of a
//! two-link arm (Pietruś & Gierlak 2023, Eq. 45), the time law by summing chords, and every band
//! condition as the job format words it, at 100 000 samples.

use std::path::PathBuf;
use std::sync::Arc;

use detune::job::{Carried, Job, Levers, Operation, Policy, Review, Spindle, SpindleSpeed, Tool};
use detune::model::Robot;
use detune::motion::{Move, Target, Timing, Work};
use detune::progress::silent;
use detune::risk::{Certainty, assess};
use nalgebra::Isometry3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::planar_arm::{L1, L2, closed_form_hz, two_link};

const SAMPLES: usize = 100_000;

/// Joint positions at equal steps of time: the share of each segment by the length of the tip's way.
fn scan_poses(waypoints: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let tip = |q: [f64; 2]| {
        let (a, b) = (q[0], q[0] + q[1]);
        [L1 * a.cos() + L2 * b.cos(), L1 * a.sin() + L2 * b.sin()]
    };
    let lerp = |a: [f64; 2], b: [f64; 2], u: f64| [0, 1].map(|i| a[i] + (b[i] - a[i]) * u);
    let chords = 20_000;
    let lengths: Vec<f64> = waypoints
        .windows(2)
        .map(|w| {
            (0..chords)
                .map(|i| {
                    let (a, b) = (i as f64 / chords as f64, (i + 1) as f64 / chords as f64);
                    let (p, q) = (tip(lerp(w[0], w[1], a)), tip(lerp(w[0], w[1], b)));
                    (p[0] - q[0]).hypot(p[1] - q[1])
                })
                .sum()
        })
        .collect();
    let total: f64 = lengths.iter().sum();
    (0..SAMPLES)
        .map(|i| {
            let mut left = i as f64 / (SAMPLES - 1) as f64 * total;
            let mut k = 0;
            while k + 1 < lengths.len() && left > lengths[k] {
                left -= lengths[k];
                k += 1;
            }
            lerp(waypoints[k], waypoints[k + 1], (left / lengths[k]).min(1.0))
        })
        .collect()
}

/// One stretch: mode, order of the line, certain?, from, to.
type Stretch = (usize, u32, bool, f64, f64);

fn scan(
    poses: &[[f64; 2]],
    speed: &dyn Fn(f64) -> f64,
    orders: &[u32],
    policy: &Policy,
) -> Vec<Stretch> {
    let frequencies: Vec<[f64; 2]> = poses.iter().map(|q| closed_form_hz(q[1])).collect();
    let mut stretches = Vec::new();
    for mode in 0..2 {
        for &order in orders {
            let mut open: Option<(bool, f64)> = None;
            for i in 0..=SAMPLES {
                let s = i as f64 / (SAMPLES - 1) as f64;
                let state = frequencies.get(i).and_then(|f| {
                    let line = f64::from(order) * speed(s) / 60.0;
                    let apart = (line - f[mode]).abs() / f[mode];
                    let ignored = policy.ignore_hz.iter().any(|b| b[0] <= line && line <= b[1]);
                    if ignored || apart >= policy.separation + policy.model_uncertainty.unwrap() {
                        None
                    } else {
                        Some(apart < policy.separation)
                    }
                });
                if let Some((certain, from)) = open
                    && state != Some(certain)
                {
                    let to = (i as f64 - 1.0) / (SAMPLES - 1) as f64;
                    stretches.push((mode + 1, order, certain, from, to));
                    open = None;
                }
                if let (None, Some(certain)) = (open, state) {
                    open = Some((certain, s));
                }
            }
        }
    }
    stretches
}

fn job(
    robot: &Arc<Robot>,
    waypoints: &[[f64; 2]],
    speed: SpindleSpeed,
    teeth: u32,
    policy: Policy,
) -> Job {
    Job {
        name: "held out".into(),
        file: PathBuf::from("job.yaml"),
        robot: robot.clone(),
        spindle: Spindle { min_rpm: 1.0, max_rpm: 1e5, max_acceleration_rpm_per_s: None },
        operations: vec![Operation::new(
            robot,
            Carried::NOTHING,
            Tool { teeth, ..Tool::default() },
            speed,
            0.01,
            waypoints
                .iter()
                .enumerate()
                .map(|(i, q)| Move {
                    to: Target::Joints(q.to_vec()),
                    feed_m_per_s: 0.01,
                    tcp: Isometry3::identity(),
                    work: Work::Stands,
                    line: 10 + i,
                    timing: Timing::Feed,
                    spindle_turns: true,
                    stated: Arc::default(),
                })
                .collect(),
        )],
        policy,
        levers: Levers::default(),
        review: Review::default(),
    }
}

fn policy(separation: f64, model_uncertainty: f64) -> Policy {
    Policy {
        tooth_passing_harmonics: 2,
        spindle_harmonics: 1,
        separation,
        model_uncertainty: Some(model_uncertainty),
        confidence: 0.95,
        ignore_hz: vec![],
        min_tip_response_m_per_n: Some(0.0),
        max_deflection_m: None,
        max_vibration_m: None,
    }
}

/// Every stretch of the scan that is wider than a few of its samples is found, with the same mode, line and
/// certainty and ends within 2e-5 of the path (the scan's own step is 1e-5); nothing else is reported.
#[test]
fn crossings_agree_with_a_scan_at_100_000_samples() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_121);
    let (mut compared, mut certain_seen, mut scheduled) = (0, 0, 0);
    for _ in 0..200 {
        let n = rng.random_range(2..6);
        let waypoints: Vec<[f64; 2]> =
            (0..n).map(|_| [rng.random_range(-1.0..2.5), rng.random_range(-2.6..2.6)]).collect();
        let teeth = rng.random_range(2..5);
        let mut policy = policy(rng.random_range(0.005..0.1), rng.random_range(0.0..0.1));
        let rpm = rng.random_range(300.0..1800.0);
        if rng.random_bool(0.3) {
            let f = f64::from(teeth) * rpm / 60.0;
            policy.ignore_hz.push([0.99 * f, 1.01 * f]);
        }
        let speed = if rng.random_bool(0.5) {
            scheduled += 1;
            let middle = rng.random_range(0.2..0.8);
            SpindleSpeed::Schedule(vec![
                (0.0, rpm),
                (middle, rpm * rng.random_range(0.7..1.4)),
                (1.0, rpm * rng.random_range(0.7..1.4)),
            ])
        } else {
            SpindleSpeed::Constant(rpm)
        };
        let rpm_at = {
            let speed = speed.clone();
            move |s: f64| match &speed {
                SpindleSpeed::Constant(rpm) => *rpm,
                SpindleSpeed::Schedule(p) => {
                    let i = usize::from(s > p[1].0);
                    p[i].1 + (p[i + 1].1 - p[i].1) * (s - p[i].0) / (p[i + 1].0 - p[i].0)
                }
            }
        };
        let separation = policy.separation;
        let expected = scan(&scan_poses(&waypoints), &rpm_at, &[1, teeth, 2 * teeth], &policy);
        let risk = assess(&job(&robot, &waypoints, speed, teeth, policy), &silent).unwrap();
        for crossing in &risk.operations[0].crossings {
            let certain = crossing.certainty == Certainty::Certain;
            assert_eq!(certain, crossing.separation < separation, "{crossing:?}");
        }
        let found: Vec<Stretch> = risk.operations[0]
            .crossings
            .iter()
            .map(|c| (c.mode, c.line.order, c.certainty == Certainty::Certain, c.from_s, c.to_s))
            .collect();
        let same = |a: &Stretch, b: &Stretch| {
            (a.0, a.1, a.2) == (b.0, b.1, b.2)
                && (a.3 - b.3).abs() < 2e-5
                && (a.4 - b.4).abs() < 2e-5
        };
        for stretch in expected.iter().filter(|e| e.4 - e.3 > 3e-5) {
            assert!(found.iter().any(|f| same(f, stretch)), "{stretch:?} not in {found:?}");
            compared += 1;
            certain_seen += usize::from(stretch.2);
        }
        for stretch in found.iter().filter(|f| f.4 - f.3 > 3e-5) {
            assert!(expected.iter().any(|e| same(e, stretch)), "{stretch:?} not in {expected:?}");
        }
    }
    println!("compared {compared}, certain {certain_seen}, scheduled {scheduled}");
    assert!(compared > 150 && certain_seen > 50 && scheduled > 20, "the jobs see no traffic");
}

/// A line that only just touches a band between two samples of the first look: from 0.1 % of the path wide
/// down to 0.003 %.
#[test]
fn a_narrow_touch_is_found() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    // f1 has its least value at β2 = 0: sweep through it, off centre by ever different amounts, so that
    // the touch falls anywhere between the points of a grid.
    for (i, width) in (0..24).map(|i| (i, [1e-3, 3e-4, 1e-4, 3e-5][i % 4])) {
        let waypoints = [[0.3, -0.37 - 0.000_37 * i as f64], [0.3, 0.61]];
        let poses = scan_poses(&waypoints);
        let frequencies: Vec<f64> = poses.iter().map(|q| closed_form_hz(q[1])[0]).collect();
        let least =
            (0..SAMPLES).min_by(|&a, &b| frequencies[a].total_cmp(&frequencies[b])).unwrap();
        let centre = least as f64 / (SAMPLES - 1) as f64;
        // Near the least value s and β2 go in step: f1 at half a width from it.
        let beta2 = 0.5 * width * (poses[least + 50][1] - poses[least - 50][1]) / 100.0
            * (SAMPLES - 1) as f64;
        let edge = closed_form_hz(beta2)[0];
        // The line meets the band's lower edge f (1 − separation) where f1 < edge.
        let separation = 0.02;
        let rpm = edge * (1.0 - separation) * 60.0 / 3.0;
        let mut policy = policy(separation, 0.0);
        policy.tooth_passing_harmonics = 1;
        policy.spindle_harmonics = 0;
        let risk =
            assess(&job(&robot, &waypoints, SpindleSpeed::Constant(rpm), 3, policy), &silent)
                .unwrap();
        let [crossing] = risk.operations[0].crossings.as_slice() else {
            panic!("{i}, width {width}: {:?}", risk.operations[0].crossings)
        };
        let found = crossing.to_s - crossing.from_s;
        assert!((found / width - 1.0).abs() < 0.02, "{found} against {width}");
        assert!((0.5 * (crossing.from_s + crossing.to_s) - centre).abs() < 1e-5);
    }
}

/// The line numbers are those of the waypoints that are approached, and what is reported at the closest
/// point is what the closed form gives there.
#[test]
fn a_crossing_carries_its_place_in_the_file() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let waypoints = [[0.0, 2.5], [0.2, 1.8], [0.4, 0.2], [0.6, -0.5]];
    let f1 = closed_form_hz(1.0)[0];
    let policy = Policy { tooth_passing_harmonics: 1, spindle_harmonics: 0, ..policy(0.002, 0.0) };
    let speed = SpindleSpeed::Constant(f1 * 60.0 / 2.0);
    let risk = assess(&job(&robot, &waypoints, speed, 2, policy), &silent).unwrap();
    let [crossing] = risk.operations[0].crossings.as_slice() else {
        panic!("{:?}", risk.operations[0].crossings)
    };
    assert_eq!((crossing.from_line, crossing.to_line), (12, 12));
    assert!(crossing.separation < 1e-9, "{}", crossing.separation);
    assert!((crossing.natural_frequency_hz / f1 - 1.0).abs() < 1e-9);
    assert!((crossing.moves.iter().map(|part| part.share).sum::<f64>() - 1.0).abs() < 1e-12);
}

/// SpindleProfile joint 1 alone changes no frequency of the planar arm but in the last digits; a line on the very
/// edge of a band is outside of it, all along.
#[test]
fn an_edge_does_not_flicker() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let waypoints = [[-1.0, 0.7], [2.0, 0.7]];
    let f1 = detune::modes::Modes::at(&robot, &[0.0, 0.7]).unwrap().natural_frequencies_hz[0];
    for (separation, expected) in [(0.1, 0), (0.1 + 1e-9, 1)] {
        let speed = SpindleSpeed::Constant(f1 * 1.1 * 60.0 / 2.0);
        let mut policy = policy(separation, 0.0);
        policy.tooth_passing_harmonics = 1;
        policy.spindle_harmonics = 0;
        let risk = assess(&job(&robot, &waypoints, speed, 2, policy), &silent).unwrap();
        assert_eq!(risk.operations[0].crossings.len(), expected, "separation {separation}");
    }
}

/// Where line and mode coincide at a sample to the last digit, that sample is the closest point.
#[test]
fn a_meeting_at_a_sample_is_exact() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let waypoints = [[0.0, 0.3], [0.4, 1.5]];
    let f1 = detune::modes::Modes::at(&robot, &waypoints[0]).unwrap().natural_frequencies_hz[0];
    // One revolution per second and tooth: the line's frequency is the spindle's, without rounding.
    let mut rpm = f1 * 60.0;
    while rpm / 60.0 < f1 {
        rpm = rpm.next_up();
    }
    let mut policy = policy(0.01, 0.0);
    policy.tooth_passing_harmonics = 1;
    let risk =
        assess(&job(&robot, &waypoints, SpindleSpeed::Constant(rpm), 1, policy), &silent).unwrap();
    let crossing = &risk.operations[0].crossings[0];
    assert!(crossing.separation < 1e-14, "{}", crossing.separation);
    assert!(crossing.closest_s < 1e-9, "{}", crossing.closest_s);
}

/// The spindle stands on the second of four equal moves: what is crossed all along without that ends and begins at
/// its waypoints, and names no line of it.
#[test]
fn nothing_is_crossed_where_the_spindle_stands() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let waypoints = [[0.0, 1.6], [0.0, 1.8], [0.0, 2.0], [0.0, 2.2], [0.0, 2.4]];
    let f = detune::modes::Modes::at(&robot, &[0.0, 2.0]).unwrap().natural_frequencies_hz[0];
    let speed = SpindleSpeed::Constant(60.0 * f / 2.0);
    // So wide a band that the mode never leaves it.
    let mut job = job(&robot, &waypoints, speed, 2, policy(0.5, 0.0));
    job.policy.tooth_passing_harmonics = 1;
    job.policy.spindle_harmonics = 0;
    let found = |job: &Job| -> Vec<(f64, f64, usize, usize)> {
        let risk = assess(job, &silent).unwrap();
        let crossings = risk.operations[0].crossings.iter().filter(|c| c.mode == 1);
        crossings.map(|c| (c.from_s, c.to_s, c.from_line, c.to_line)).collect()
    };
    assert_eq!(found(&job), [(0.0, 1.0, 11, 14)]);
    Arc::make_mut(&mut job.operations[0].moves)[2].spindle_turns = false;
    let [(a, b, 11, 11), (c, d, 13, 14)] = found(&job)[..] else { panic!("{:?}", found(&job)) };
    assert_eq!((a, d), (0.0, 1.0));
    assert!((b - 0.25).abs() < 1e-12 && (c - 0.5).abs() < 1e-12, "{b} {c}");
    for each in Arc::make_mut(&mut job.operations[0].moves) {
        each.spindle_turns = false;
    }
    assert_eq!(found(&job), []);
}
