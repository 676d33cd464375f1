//! Nonlinear free vibration: the general equation of motion against the paper's explicit one, against
//! conservation of energy, and its small-amplitude spectrum against the eigenvalues.

use std::f64::consts::PI;
use std::time::Instant;

use crate::arms::{gravity, six_axis_arm, two_link_arm};
use crate::two_link::TABLE_1;
use detune::free_vibration::{
    Recording, Sampling, Settings, Start, measure, respond, start_all_modes,
};
use detune::model::Robot;
use detune::modes::Modes;
use nalgebra::Vector2;

/// Eq. (46), written out in `two_link`, by the classical Runge–Kutta method of order 4 with small steps: another
/// equation, another method.
fn paper_response(beta2: f64, start: Vector2<f64>, interval: f64, count: usize) -> Vec<[f64; 2]> {
    const SUBSTEPS: usize = 200;
    let h = interval / SUBSTEPS as f64;
    let f = |a: Vector2<f64>, v: Vector2<f64>| TABLE_1.acceleration_rad_per_s2(beta2, &a, &v);
    let (mut a, mut v) = (start, Vector2::zeros());
    let mut record = vec![[a[0], a[1]]];
    for _ in 1..count {
        for _ in 0..SUBSTEPS {
            let (ka1, kv1) = (v, f(a, v));
            let (ka2, kv2) = (v + kv1 * (h / 2.0), f(a + ka1 * (h / 2.0), v + kv1 * (h / 2.0)));
            let (ka3, kv3) = (v + kv2 * (h / 2.0), f(a + ka2 * (h / 2.0), v + kv2 * (h / 2.0)));
            let (ka4, kv4) = (v + kv3 * h, f(a + ka3 * h, v + kv3 * h));
            a += (ka1 + ka2 * 2.0 + ka3 * 2.0 + ka4) * (h / 6.0);
            v += (kv1 + kv2 * 2.0 + kv3 * 2.0 + kv4) * (h / 6.0);
        }
        record.push([a[0], a[1]]);
    }
    record
}

/// Without damping.
fn recording(sample_rate_hz: f64, count: usize, tolerance: f64) -> Recording {
    Recording { sample_rate_hz, count, tolerance, is_damped: false }
}

/// At 5°, where the nonlinear terms change the motion by far more than the tolerance here.
#[test]
fn the_general_equation_moves_as_equation_46() {
    let robot = two_link_arm(&TABLE_1, false);
    for (beta1, beta2) in [(2.0, 1.571), (-0.7, 2.618), (0.0, -0.9)] {
        let q = [beta1, beta2];
        let amplitude = 5.0_f64.to_radians();
        let start = start_all_modes(
            &robot,
            &q,
            &Settings { amplitude_rad: amplitude, ..Settings::default() },
        )
        .unwrap();
        let (rate, count) = (2000.0, 400);
        let found = respond(&robot, &q, &start, &recording(rate, count, 1e-11)).unwrap();
        let alpha = Vector2::new(start.deflection[0], start.deflection[1]);
        let expected = paper_response(beta2, alpha, 1.0 / rate, count);
        let linear = {
            let modes = Modes::at(&robot, &q).unwrap();
            let t = (count - 1) as f64 / rate;
            let mass = TABLE_1.mass_matrix_kgm2(beta2);
            (0..2).fold(Vector2::zeros(), |sum: Vector2<f64>, r| {
                let shape = Vector2::new(modes.shapes[(0, r)], modes.shapes[(1, r)]);
                let omega = 2.0 * PI * modes.natural_frequencies_hz[r];
                sum + shape * (shape.dot(&(mass * alpha)) * (omega * t).cos())
            })
        };
        for (t, e) in expected.iter().enumerate() {
            for (i, expected) in e.iter().enumerate() {
                let error = (found.deflections[i][t] - expected).abs();
                assert!(error < 1e-7 * amplitude, "β2 = {beta2}, sample {t}: {error:e}");
            }
        }
        let last = expected[count - 1];
        let bent = (linear - Vector2::from(last)).amax();
        assert!(bent > 1e-3 * amplitude, "the test would pass on a linear equation: {bent:e}");
    }
}

/// The exact potential (5)–(6) preloads the springs: α = 0 stays at rest, and the force at a deflection is
/// the gradient's change.
#[test]
fn gravity_is_balanced_at_rest_and_acts_off_it() {
    let robot = two_link_arm(&TABLE_1, true);
    let q = [0.4, 1.1];
    let rest = Start {
        deflection: vec![0.0; 2],
        rate: vec![0.0; 2],
        scale: vec![1e-3; 2],
        highest_rad_per_s: 600.0,
    };
    let record = respond(&robot, &q, &rest, &recording(1000.0, 200, 1e-10)).unwrap();
    assert!(record.deflections.iter().flatten().all(|&a| a == 0.0));

    // One short step from rest at α: α(h) − α ≈ ½ h² α̈, against M⁻¹ of the closed form's torques.
    let alpha = [0.05, -0.08];
    let start = Start { deflection: alpha.to_vec(), ..rest };
    let h = 1e-5;
    let record = respond(&robot, &q, &start, &recording(1.0 / h, 2, 1e-12)).unwrap();
    let weight = gravity(&TABLE_1);
    let v = |x: f64, y: f64| TABLE_1.gravity_potential_j(&weight, q[0] + x, q[1] + y);
    let slope = |x: f64, y: f64| {
        let d = 1e-5;
        Vector2::new(v(x + d, y) - v(x - d, y), v(x, y + d) - v(x, y - d)) / (2.0 * d)
    };
    let torque = -(TABLE_1.stiffness_matrix_nm_per_rad() * Vector2::from(alpha))
        - (slope(alpha[0], alpha[1]) - slope(0.0, 0.0));
    let m = TABLE_1.mass_matrix_kgm2(q[1] + alpha[1]);
    let expected = m.try_inverse().unwrap() * torque;
    for i in 0..2 {
        let found = 2.0 * (record.deflections[i][1] - alpha[i]) / (h * h);
        assert!((found / expected[i] - 1.0).abs() < 1e-5, "{found} against {}", expected[i]);
    }
}

#[test]
fn energy_is_kept() {
    for (robot, q) in poses() {
        // Of small amplitudes, below.
        for degrees in [1.0, 10.0] {
            let settings =
                Settings { amplitude_rad: f64::to_radians(degrees), ..Settings::default() };
            let found = measure(&robot, &q, &settings).unwrap();
            assert!(found.energy_drift < 1e-7, "{degrees}°: drift {:e}", found.energy_drift);
        }
    }
}

/// Two-link arm and six axes, with and without gravity.
fn poses() -> Vec<(Robot, Vec<f64>)> {
    let mut poses = Vec::new();
    for with_gravity in [false, true] {
        for beta2 in [0.174, 1.571, 2.618] {
            poses.push((two_link_arm(&TABLE_1, with_gravity), vec![2.0, beta2]));
        }
        for q in [[0.0; 6], [0.3, 0.7, -0.5, 1.0, -0.8, 0.2], [0.0, 0.3, -1.2, 0.0, 0.9, 0.0]] {
            poses.push((six_axis_arm(with_gravity), q.to_vec()));
        }
    }
    poses
}

/// 0.05 % is asked for; the method promises a thousandth of a bin, 2e-5 of f1, and keeps to it.
#[test]
fn small_vibrations_have_the_natural_frequencies() {
    for (robot, q) in poses() {
        let settings = Settings { amplitude_rad: 1e-4, ..Settings::default() };
        let started = Instant::now();
        let found = measure(&robot, &q, &settings).unwrap();
        let seconds = started.elapsed().as_secs_f64();
        let expected = Modes::at(&robot, &q).unwrap().natural_frequencies_hz;
        let mut worst = 0.0_f64;
        for (f, e) in found.frequencies_hz.iter().zip(&expected) {
            let f = f.unwrap_or_else(|| panic!("a mode was not seen: {:?}", found.frequencies_hz));
            assert!((f - e).abs() < 2e-5 * expected[0], "{q:?}: {f} against {e}");
            worst = worst.max((f / e - 1.0).abs());
        }
        assert!(found.energy_drift < 1e-7, "{q:?}: drift {:e}", found.energy_drift);
        println!("{q:?}: {worst:.1e} {:.1e} in {seconds:.2} s", found.energy_drift);
    }
}

/// A soft second joint couples strongly: at 10° the frequencies move by more than the method's error, at
/// 1 mrad they do not, and the departure grows with the square of the amplitude.
#[test]
fn departure_grows_with_the_square_of_the_amplitude() {
    let robot = two_link_arm(&TABLE_1, false);
    let departure = |degrees: f64| {
        let settings = Settings { amplitude_rad: degrees.to_radians(), ..Settings::default() };
        let found = measure(&robot, &[2.0, 2.618], &settings).unwrap();
        [0, 1].map(|r| found.frequencies_hz[r].unwrap() / found.linear_hz[r] - 1.0)
    };
    let (small, large) = (departure(2.0), departure(4.0));
    for r in 0..2 {
        println!("mode {}: {:.3e} at 2°, {:.3e} at 4°", r + 1, small[r], large[r]);
        let ratio = large[r] / small[r];
        assert!((3.7..4.3).contains(&ratio), "mode {}: ratio {ratio}", r + 1);
    }
}

/// 140 frames a second for 5 s: 0.2 Hz lines up to 70 Hz. The second mode at β2 = 1.571, 84.18 Hz, folds to
/// 55.82 Hz, and is not reported there.
#[test]
fn the_papers_acquisition_does_not_see_what_folds() {
    let robot = two_link_arm(&TABLE_1, false);
    let sampling = Sampling::Fixed { sample_rate_hz: 140.0, duration_s: 5.0 };
    let settings = Settings { amplitude_rad: 1e-4, sampling, ..Settings::default() };
    let found = measure(&robot, &[2.0, 1.571], &settings).unwrap();
    assert!((found.spectrum.bin_hz - 0.2).abs() < 1e-12);
    assert_eq!(found.spectrum.amplitudes[0].len(), 351);
    assert!((found.frequencies_hz[0].unwrap() - 25.76).abs() < 0.005);
    assert_eq!(found.frequencies_hz[1], None);
    assert_eq!(found.aliased.len(), 1);
    assert_eq!(found.aliased[0].mode, 1);
    assert!((found.aliased[0].frequency_hz - 84.18).abs() < 0.005);
    assert!((found.aliased[0].seen_at_hz - 55.82).abs() < 0.005);
}

/// Free decay: the envelope of a single excited mode falls as exp(−ζ ω t).
#[test]
fn damped_modes_decay_at_their_rate() {
    let robot = six_axis_arm(false);
    let q = [0.3, 0.7, -0.5, 1.0, -0.8, 0.2];
    let modes = Modes::at(&robot, &q).unwrap();
    for r in 0..6 {
        let omega = 2.0 * PI * modes.natural_frequencies_hz[r];
        let zeta = modes.damping_ratios[r];
        let shape: Vec<f64> = modes.shapes.column(r).iter().map(|phi| phi * 1e-6).collect();
        let start = Start {
            deflection: shape.clone(),
            rate: vec![0.0; 6],
            scale: vec![1e-6; 6],
            highest_rad_per_s: 2.0 * PI * modes.natural_frequencies_hz[5],
        };
        // α(t) / α(0) = exp(−ζωt) (cos ω_d t + ζ/√(1−ζ²) sin ω_d t); after whole damped periods exp(−ζωt).
        let period = 2.0 * PI / (omega * (1.0 - zeta * zeta).sqrt());
        let damped = Recording { is_damped: true, ..recording(1.0 / period, 6, 1e-10) };
        let record = respond(&robot, &q, &start, &damped).unwrap();
        for (k, &alpha) in record.deflections[1].iter().enumerate() {
            let expected = shape[1] * (-zeta * omega * period * k as f64).exp();
            assert!((alpha - expected).abs() < 1e-4 * shape[1].abs(), "mode {r}, period {k}");
        }
    }
}
