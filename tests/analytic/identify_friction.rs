//! Free decays of an arm with friction in its joints, or with springs that stiffen strongly: the modes of small
//! amplitudes within their deviations, one for each coordinate, and damping that changes with amplitude told. The
//! truth is an arm of two coordinates whose equations are integrated in time; at small amplitudes Dahl's friction
//! is a spring beside the joint's own.

use crate::identify::{asked, record};
use crate::vibration::{C64, noisy, seeded};
use detune::identify::record::Quantity;
use detune::identify::record_modes::{IdentifiedRecord, identify_record};
use detune::notes::{Code, Note};
use nalgebra::{Matrix2, Matrix4, Vector2};

const RATE: f64 = 400.0;
const SAMPLES: usize = 2000;

/// Steps of Runge and Kutta from one sample to the next.
const STEPS: usize = 24;

/// Deflection, rad, that the springs' laws are given for; the first swing reaches 1.3 of it.
const DEFLECTION: f64 = 1e-3;

/// How friction follows the speed.
#[derive(Clone, Copy, PartialEq)]
enum Law {
    /// Dahl: Ḟ = σ (v − |v| F/F_c).
    Dahl,
    /// Jenkins: a spring in series with a slider (J. Appl. Phys. 33, 1962).
    Jenkins,
}

/// An arm of two coordinates with friction.
struct Arm {
    mass: Matrix2<f64>,
    stiffness: Vector2<f64>,
    damping: Matrix2<f64>,
    /// σ of both joints, N·m/rad, and the torque at which they slip, N·m.
    friction: Vector2<f64>,
    slip: Vector2<f64>,
    law: Law,
    /// Of the third power of the deflection, N·m/rad³.
    cubic: Vector2<f64>,
}

impl Arm {
    /// `share` of a joint's stiffness is friction, which deflects by `depth` of what it slips at;
    /// `cubic` is what the springs gain at the deflection.
    fn new(share: f64, depth: f64, cubic: f64) -> Self {
        let mass = Matrix2::new(6.0, 1.2, 1.2, 1.5);
        let stiffness = Vector2::new(9.5e4, 4.0e4);
        let friction = share * stiffness;
        Self {
            mass,
            stiffness,
            damping: 0.4 * mass + 2.2e-4 * Matrix2::from_diagonal(&stiffness),
            friction,
            slip: friction * (DEFLECTION / depth),
            law: Law::Dahl,
            cubic: stiffness * (cubic / DEFLECTION.powi(2)),
        }
    }

    /// Frequency, Hz, and damping ratio of both modes at small amplitudes, from the eigenvalues of
    /// the state's matrix.
    fn modes(&self) -> [(f64, f64); 2] {
        let inverse = self.mass.try_inverse().unwrap();
        let by_place = -inverse * Matrix2::from_diagonal(&(self.stiffness + self.friction));
        let by_speed = -inverse * self.damping;
        let mut state = Matrix4::zeros();
        state.fixed_view_mut::<2, 2>(0, 2).fill_with_identity();
        state.fixed_view_mut::<2, 2>(2, 0).copy_from(&by_place);
        state.fixed_view_mut::<2, 2>(2, 2).copy_from(&by_speed);
        let mut poles: Vec<C64> =
            state.complex_eigenvalues().iter().copied().filter(|pole| pole.im > 0.0).collect();
        poles.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        [poles[0], poles[1]].map(|l| (l.norm() / std::f64::consts::TAU, -l.re / l.norm()))
    }

    /// Deflections of both joints after a blow.
    fn decay(&self) -> Vec<Vec<f64>> {
        let inverse = self.mass.try_inverse().unwrap();
        let slope = |(x, v, f): (Vector2<f64>, Vector2<f64>, Vector2<f64>)| {
            let springs =
                self.stiffness.component_mul(&x) + self.cubic.component_mul(&x.map(|x| x.powi(3)));
            let friction = Vector2::from_fn(|i, _| match self.law {
                _ if self.slip[i] <= 0.0 => 0.0,
                Law::Dahl => self.friction[i] * (v[i] - v[i].abs() * f[i] / self.slip[i]),
                Law::Jenkins if f[i] * v[i].signum() >= self.slip[i] => 0.0,
                Law::Jenkins => self.friction[i] * v[i],
            });
            (v, -inverse * (springs + self.damping * v + f), friction)
        };
        let h = 1.0 / RATE / STEPS as f64;
        let zero = Vector2::zeros();
        let mut now = (zero, Vector2::new(0.12, 0.2), zero);
        let mut seen = vec![Vec::new(); 2];
        for _ in 0..SAMPLES {
            seen[0].push(now.0[0]);
            seen[1].push(now.0[1]);
            for _ in 0..STEPS {
                let ahead = |h: f64, by: (Vector2<f64>, Vector2<f64>, Vector2<f64>)| {
                    (now.0 + h * by.0, now.1 + h * by.1, now.2 + h * by.2)
                };
                let a = slope(now);
                let b = slope(ahead(0.5 * h, a));
                let c = slope(ahead(0.5 * h, b));
                let d = slope(ahead(h, c));
                now = (
                    now.0 + h / 6.0 * (a.0 + 2.0 * (b.0 + c.0) + d.0),
                    now.1 + h / 6.0 * (a.1 + 2.0 * (b.1 + c.1) + d.1),
                    now.2 + h / 6.0 * (a.2 + 2.0 * (b.2 + c.2) + d.2),
                );
            }
        }
        seen
    }

    /// What `identify` finds in the decay with noise, as a share of its root mean square.
    fn found(&self, noise: f64, seed: u64) -> IdentifiedRecord {
        let seen = noisy(&self.decay(), noise, &mut seeded(seed));
        identify_record(&record(RATE, None, seen, Quantity::Displacement), &asked(&[]))
    }
}

/// One mode for each coordinate, each frequency and damping within three of its deviations.
fn must_hold(found: &IdentifiedRecord, arm: &Arm, what: &str) {
    let told: Vec<_> = found
        .modes
        .iter()
        .map(|m| (m.frequency_hz, m.frequency_std_hz, m.damping_ratio, m.damping_std))
        .collect();
    assert_eq!(told.len(), 2, "{what}: {told:?}");
    for ((hz, hz_std, ratio, ratio_std), (true_hz, true_ratio)) in told.into_iter().zip(arm.modes())
    {
        let [of_hz, of_ratio] = [(hz - true_hz) / hz_std, (ratio - true_ratio) / ratio_std];
        assert!(of_hz.abs() < 3.0, "{what}: {hz} ± {hz_std}, is {true_hz}");
        assert!(of_ratio.abs() < 3.0, "{what}: {ratio} ± {ratio_std}, is {true_ratio}");
    }
}

fn tells_of_damping(found: &IdentifiedRecord) -> bool {
    found.warnings.iter().any(|note| note.code == Code::AmplitudeDamping)
}

/// From joints that hardly slip to joints that slip through at the first swing.
#[test]
fn friction_leaves_the_modes_of_small_amplitudes() {
    for share in [0.01, 0.03, 0.06] {
        for depth in [0.3, 1.0, 3.0] {
            let arm = Arm::new(share, depth, 0.0);
            for seed in 0..2 {
                let found = arm.found(0.005, seed);
                must_hold(&found, &arm, &format!("{share} {depth} {seed}"));
                let is_strong = share > 0.02 && depth > 0.5;
                assert!(!is_strong || tells_of_damping(&found), "{:?}", found.warnings);
            }
        }
    }
}

/// A joint that slips through at first and sticks in the end, as no law of the fit describes it: the mode that still
/// moves in the second half of its decay is taken from there, within its deviations, and that is told.
#[test]
fn friction_that_sticks_in_the_end_is_told() {
    let first = Vector2::new(1.0, 0.0);
    for less in [0.3, 0.5] {
        let whole = Arm::new(0.3, 3.0, 0.0);
        let arm = Arm {
            law: Law::Jenkins,
            damping: less * whole.damping,
            friction: whole.friction.component_mul(&first),
            slip: whole.slip.component_mul(&first),
            ..whole
        };
        let (hz, _) = arm.modes()[0];
        for seed in 0..2 {
            let found = arm.found(0.005, seed);
            let told = |note: &Note| {
                note.code == Code::AmplitudeDependent && note.what.contains("second half")
            };
            assert!(found.warnings.iter().any(told), "{:?}", found.warnings);
            let own = &found.modes[0];
            let off = (own.frequency_hz - hz) / own.frequency_std_hz;
            assert!(off.abs() < 3.0, "{} ± {}, is {hz}", own.frequency_hz, own.frequency_std_hz);
            assert!((own.frequency_hz / hz - 1.0).abs() < 0.005, "{} of {hz}", own.frequency_hz);
        }
    }
}

/// What stiffens without friction keeps its damping, and nothing is told of it.
#[test]
fn stiffening_alone_does_not_change_the_damping() {
    for cubic in [0.0, 0.02, 0.05] {
        let arm = Arm::new(0.0, 1.0, cubic);
        for seed in 0..2 {
            let found = arm.found(0.005, seed);
            must_hold(&found, &arm, &format!("{cubic} {seed}"));
            assert!(!tells_of_damping(&found), "{:?}", found.warnings);
        }
    }
}

/// Friction that saturates with the speed in the second joint, as a seal's: what a linear fit needs beside the first
/// mode, of its shape and several times its damping, is told and left out.
#[test]
fn the_companion_that_friction_makes_is_no_mode() {
    const RATE: f64 = 512.0;
    const SPEED: f64 = 0.02;
    let inverse = Matrix2::new(60.0, 12.0, 12.0, 20.0).try_inverse().unwrap();
    let stiffness = Vector2::new(4e5, 2.2e5);
    let force = |t: f64| {
        let phase = (t - 0.25) / 0.004;
        let size =
            if (0.0..=1.0).contains(&phase) { (std::f64::consts::PI * phase).sin() } else { 0.0 };
        size * Vector2::new(1.0, 0.4)
    };
    for (seed, blow) in [300.0, 900.0].into_iter().enumerate() {
        let slope = |t: f64, x: Vector2<f64>, v: Vector2<f64>| {
            let friction = Vector2::new(0.0, 12.0 * (v[1] / SPEED).tanh());
            let springs = stiffness.component_mul(&(x + 2e-4 * v));
            inverse * (blow * force(t) - springs - friction)
        };
        let h = 1.0 / RATE / STEPS as f64;
        let (mut x, mut v) = (Vector2::zeros(), Vector2::zeros());
        let (mut heard, mut seen) = (Vec::new(), vec![Vec::new(); 2]);
        for sample in 0..2560 {
            let start = f64::from(sample) / RATE;
            heard.push(blow * force(start)[0]);
            let now = slope(start, x, v);
            (0..2).for_each(|i| seen[i].push(now[i]));
            for step in 0..STEPS {
                let t = start + step as f64 * h;
                let a = slope(t, x, v);
                let v2 = v + 0.5 * h * a;
                let b = slope(t + 0.5 * h, x + 0.5 * h * v, v2);
                let v3 = v + 0.5 * h * b;
                let c = slope(t + 0.5 * h, x + 0.5 * h * v2, v3);
                let v4 = v + h * c;
                let d = slope(t + h, x + h * v3, v4);
                x += h / 6.0 * (v + 2.0 * (v2 + v3) + v4);
                v += h / 6.0 * (a + 2.0 * (b + c) + d);
            }
        }
        // A third sensor between both joints.
        let between = seen[0].iter().zip(&seen[1]).map(|(a, b)| 0.6 * a + 0.5 * b).collect();
        seen.push(between);
        let seen = noisy(&seen, 0.01, &mut seeded(70 + seed as u64));
        let hammer = record(RATE, Some(heard), seen, Quantity::Acceleration);
        let found = identify_record(&hammer, &asked(&[]));
        let listed = found.modes.iter().filter(|mode| mode.suspicion.is_none());
        let listed: Vec<f64> = listed.map(|mode| mode.frequency_hz).collect();
        assert_eq!(listed.len(), 2, "{blow}: {listed:?} {:?}", found.warnings);
        // Small motion: the friction is a damper of 600 N·s/m.
        assert!((listed[0] / 12.258 - 1.0).abs() < 1e-3, "{listed:?}");
        let told = |note: &Note| note.code == Code::AmplitudeDependent;
        assert!(found.warnings.iter().any(told), "{:?}", found.warnings);
    }
}
