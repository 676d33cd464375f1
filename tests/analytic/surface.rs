//! What a cut leaves on the surface, and how far it moves the tool, against the equation of motion in time.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use detune::job::{
    Carried, Cutting, CuttingCoefficients, CuttingDirection, Operation, SpindleSpeed, Tool,
};
use detune::model::Robot;
use detune::process::{Effects, Owner, TipMode, TipPlace};
use detune::stability::ToolMode;
use nalgebra::Vector3;

use crate::planar_arm::two_link;

const RPM: f64 = 4800.0;
const DIAMETER_M: f64 = 0.012;
const DEPTH_M: f64 = 0.002;
const FEED_M: f64 = 8e-5;
const K: CuttingCoefficients = CuttingCoefficients {
    tangential_n_per_m2: 7e8,
    radial_n_per_m2: 2.5e8,
    tangential_edge_n_per_m: 12e3,
    radial_edge_n_per_m: 9e3,
    axial: None,
    exponents: [0.0; 3],
};
const TEETH: usize = 3;

fn operation(direction: CuttingDirection, radial_depth_m: f64) -> Operation {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let tool = Tool { teeth: TEETH as u32, diameter_m: Some(DIAMETER_M), ..Tool::default() };
    let speed = SpindleSpeed::Constant(RPM);
    let path = Operation::new(&robot, Carried::NOTHING, tool, speed, 0.01, vec![]);
    let cutting = Cutting {
        radial_depth_m,
        axial_depth_m: DEPTH_M,
        direction,
        material: String::new(),
        coefficients: Some(K),
        regenerates: true,
        process_damping_n_per_m: 0.0,
    };
    Operation { cutting: Some(cutting), ..path }
}

fn modes() -> Vec<ToolMode> {
    let mode = |hz: f64, damping_ratio: f64, mass_kg: f64, axis: [f64; 3]| ToolMode {
        omega_rad_per_s: TAU * hz,
        damping_ratio,
        motion: Vector3::from(axis).normalize() / f64::sqrt(mass_kg),
    };
    vec![
        mode(31.0, 0.04, 60.0, [0.7, 0.6, 0.1]),
        mode(212.0, 0.05, 2.0, [-0.3, 0.9, 0.0]),
        mode(610.0, 0.03, 0.4, [1.0, 0.2, 0.0]),
    ]
}

/// Straight teeth between `entry` and `exit`, φ from y, the force on the tool (Altintas, Manufacturing
/// Automation, 2nd ed., section 2.8).
fn force_n(turned: f64, [entry, exit]: [f64; 2]) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for j in 0..TEETH {
        let phi = (turned + TAU * j as f64 / TEETH as f64).rem_euclid(TAU);
        if phi < entry || phi >= exit {
            continue;
        }
        let (sin, cos) = phi.sin_cos();
        let chip = FEED_M * sin;
        let tangential = DEPTH_M * (K.tangential_n_per_m2 * chip + K.tangential_edge_n_per_m);
        let radial = DEPTH_M * (K.radial_n_per_m2 * chip + K.radial_edge_n_per_m);
        sum += Vector3::new(-tangential * cos - radial * sin, tangential * sin - radial * cos, 0.0);
    }
    sum
}

/// The tip over one turn when all has settled, at even angles from zero.
fn settled(engagement: [f64; 2], steps: usize) -> Vec<Vector3<f64>> {
    let turning = TAU * RPM / 60.0;
    let h = TAU / turning / steps as f64;
    let modes = modes();
    let mut state = vec![[0.0; 2]; modes.len()];
    let force = |step: f64| force_n(step * TAU / steps as f64, engagement);
    let place = |state: &[[f64; 2]]| -> Vector3<f64> {
        modes.iter().zip(state).map(|(mode, [q, _])| mode.motion * *q).sum()
    };
    let mut last = Vec::new();
    // The slowest mode dies to e⁻¹⁹ in as many turns.
    for turn in 0..200 {
        last.clear();
        for i in 0..steps {
            last.push(place(&state));
            let at = (turn * steps + i) as f64;
            let forces = [at, at + 0.5, at + 1.0 - 1e-9].map(force);
            for (mode, s) in modes.iter().zip(&mut state) {
                let w = mode.omega_rad_per_s;
                let rate = |[q, v]: [f64; 2], f: &Vector3<f64>| {
                    [v, mode.motion.dot(f) - 2.0 * mode.damping_ratio * w * v - w * w * q]
                };
                let on = |d: [f64; 2], by: f64| [s[0] + by * d[0], s[1] + by * d[1]];
                let a = rate(*s, &forces[0]);
                let b = rate(on(a, 0.5 * h), &forces[1]);
                let c = rate(on(b, 0.5 * h), &forces[1]);
                let d = rate(on(c, h), &forces[2]);
                for k in 0..2 {
                    s[k] += h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]);
                }
            }
        }
    }
    last
}

/// A conventional cut leaves its surface at φ = 0, on the side of y, where a tip that has moved away from it
/// leaves material; a climb cut at φ = π on the other side.
#[test]
fn the_surface_is_where_the_tip_is_as_a_tooth_makes_it() {
    for (direction, radial_depth_m) in [
        (CuttingDirection::Conventional, 0.003),
        (CuttingDirection::Climb, 0.003),
        (CuttingDirection::Climb, 0.001),
        (CuttingDirection::Slot, DIAMETER_M),
    ] {
        let arc = (1.0 - 2.0 * radial_depth_m / DIAMETER_M).acos();
        let (engagement, sides): ([f64; 2], &[(f64, f64)]) = match direction {
            CuttingDirection::Conventional => ([0.0, arc], &[(0.0, -1.0)]),
            CuttingDirection::Climb => ([PI - arc, PI], &[(PI, 1.0)]),
            _ => ([0.0, PI], &[(0.0, -1.0), (PI, 1.0)]),
        };
        let place = TipPlace {
            s: 0.0,
            rpm: RPM,
            feed_per_tooth_m: FEED_M,
            modes: modes()
                .into_iter()
                .map(|mode| TipMode { of: Owner::Tool, mode, turning: 0.0 })
                .collect(),
            is_sure: true,
            leaves_axis: false,
        };
        let operation = operation(direction, radial_depth_m);
        let effects = Effects::new(&operation, std::slice::from_ref(&place)).unwrap();
        let found = effects.at(&place, |_, hz| [hz, hz]).unwrap();

        const STEPS: usize = 3600;
        let tip = settled(engagement, STEPS);
        let mean: Vector3<f64> = tip.iter().sum::<Vector3<f64>>() / STEPS as f64;
        // Some tooth is at φ at every third of the turn; where, differs in its phase alone.
        let at = |phi: f64| tip[((phi / TAU * STEPS as f64).round() as usize) % STEPS];
        let errors = sides.iter().map(|&(phi, sign)| sign * at(phi).y);
        let expected = errors.fold(0.0, |a: f64, b: f64| if b.abs() > a.abs() { b } else { a });
        // Σ |u_k|² over the harmonics is twice the variance over the turn.
        let square = |u: &Vector3<f64>| (u - mean).norm_squared();
        let vibration = (2.0 * tip.iter().map(square).sum::<f64>() / STEPS as f64).sqrt();

        let surface = found.surface_error_m.unwrap();
        let scale = vibration.max(mean.norm());
        println!("{direction:?} {radial_depth_m}: {surface:e} {expected:e}, {vibration:e}");
        assert!((surface - expected).abs() < 0.01 * scale, "{surface:e} {expected:e}");
        assert!(expected.abs() > 0.05 * scale, "{expected:e} of {scale:e} shows nothing");
        let deflection = found.deflection.value_m;
        assert!((deflection / mean.norm() - 1.0).abs() < 0.01, "{deflection:e} {mean}");
        assert!((found.vibration.value_m / vibration - 1.0).abs() < 0.02, "{vibration:e}");
    }
}
