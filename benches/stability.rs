//! Stability of cuts: zeroth order over a path and speeds, the exact limit, and a semi-discretisation
//! (Insperger & Stépán) of the same depth in the same run. `cargo bench --bench stability` prints them.
//!
//! The least time of several repetitions stands: other work on the machine only ever adds to it.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::time::Instant;

use detune::excitation::Engagement;
use detune::stability::{Chart, Cut, Milling, Process, ToolMode, milling_limit, milling_radius};
use nalgebra::{DMatrix, DVector, Vector3};

const POSES: usize = 2000;
const SPEEDS: usize = 200;

/// Six modes of an arm and two of a tool; the arm's wander with the pose.
fn modes(share: f64) -> Vec<ToolMode> {
    let mode = |hz: f64, damping_ratio: f64, mass_kg: f64, axis: [f64; 3]| ToolMode {
        omega_rad_per_s: TAU * hz,
        damping_ratio,
        motion: Vector3::from(axis).normalize() / f64::sqrt(mass_kg),
    };
    let wander = 1.0 + 0.2 * (TAU * share).sin();
    let mut all: Vec<ToolMode> = [14.0, 19.0, 27.0, 48.0, 77.0, 120.0]
        .iter()
        .enumerate()
        .map(|(i, hz)| {
            let turned = i as f64 + share;
            mode(hz * wander, 0.03, 80.0 / (1.0 + i as f64), [turned.cos(), turned.sin(), 0.3])
        })
        .collect();
    all.push(mode(900.0, 0.02, 0.3, [1.0, 0.0, 0.0]));
    all.push(mode(950.0, 0.02, 0.3, [0.0, 1.0, 0.0]));
    all
}

fn cut() -> Cut {
    Cut {
        engagement: Engagement { entry_rad: PI / 2.0, exit_rad: PI },
        pitch_rad: vec![TAU / 4.0; 4],
        coefficients_n_per_m2: [6.3e8, 1.0e8, 2.7e8],
        lag_rad_per_m: 0.0,
        lip_n_per_m2: None,
        rubbing_n_per_m2: 0.0,
    }
}

fn least<T>(repetitions: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut best: Option<(f64, T)> = None;
    for _ in 0..repetitions {
        let start = Instant::now();
        let found = black_box(work());
        let seconds = start.elapsed().as_secs_f64();
        if best.as_ref().is_none_or(|best| seconds < best.0) {
            best = Some((seconds, found));
        }
    }
    best.unwrap()
}

/// The spectral radius over a tooth period by first-order semi-discretisation in `steps` steps: states
/// of all modes, and the tip's places of the last period; the force is held over a step.
fn semi_discretised(modes: &[ToolMode], milling: &Milling<'_>, depth_m: f64, steps: usize) -> f64 {
    let n = modes.len();
    let h = milling.period_s() / steps as f64;
    let size = 2 * n + 2 * steps;
    // Over a step, each mode under a constant force: exact.
    let free: Vec<[f64; 6]> = modes
        .iter()
        .map(|mode| {
            let (w, z) = (mode.omega_rad_per_s, mode.damping_ratio);
            let wd = w * (1.0 - z * z).sqrt();
            let (s, c) = (wd * h).sin_cos();
            let e = (-z * w * h).exp();
            let (a, b) = (e * (c + z * w / wd * s), e * s / wd);
            let (d, f) = (-e * w * w / wd * s, e * (c - z * w / wd * s));
            [a, b, d, f, (1.0 - a) / (w * w), b]
        })
        .collect();
    let mut state = DVector::from_fn(size, |i, _| ((i * 7919 % 1000) as f64 / 1000.0) - 0.5);
    let forces: Vec<_> =
        (0..steps).map(|i| milling.term(0, (i as f64 + 0.5) * h, depth_m)).collect();
    let period = |state: &DVector<f64>| {
        let mut state = state.clone();
        for force in &forces {
            let mut tip = [0.0; 2];
            for (r, mode) in modes.iter().enumerate() {
                (0..2).for_each(|i| tip[i] += mode.motion[i] * state[2 * r]);
            }
            let last = 2 * n + 2 * (steps - 1);
            // First order: the mean of the step's ends stands for the step.
            let before = [state[last], state[last + 1]];
            let push = force.map_or(Vector3::zeros(), |term| {
                term.now * nalgebra::Vector2::from(tip)
                    - term.before * nalgebra::Vector2::from(before)
            });
            let mut next = DVector::zeros(size);
            for (r, mode) in modes.iter().enumerate() {
                let [a, b, d, f, p, v] = free[r];
                let own = mode.motion.dot(&push);
                next[2 * r] = a * state[2 * r] + b * state[2 * r + 1] + p * own;
                next[2 * r + 1] = d * state[2 * r] + f * state[2 * r + 1] + v * own;
            }
            next[2 * n] = tip[0];
            next[2 * n + 1] = tip[1];
            next.rows_mut(2 * n + 2, 2 * (steps - 1))
                .copy_from(&state.rows(2 * n, 2 * (steps - 1)));
            state = next;
        }
        state
    };
    // All columns, then all eigenvalues, as the method is published.
    let mut monodromy = DMatrix::zeros(size, size);
    for i in 0..size {
        state.fill(0.0);
        state[i] = 1.0;
        monodromy.set_column(i, &period(&state));
    }
    monodromy.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

fn main() {
    let cut = cut();
    let speeds: Vec<f64> = (0..SPEEDS).map(|i| 600.0 + 90.0 * i as f64).collect();
    let (seconds, smallest) = least(1, || {
        let mut smallest = f64::INFINITY;
        for pose in 0..POSES {
            let chart = Chart::new(&modes(pose as f64 / POSES as f64), &cut);
            for rpm in &speeds {
                smallest = chart.limit(*rpm).map_or(smallest, |limit| limit.depth_m.min(smallest));
            }
        }
        smallest
    });
    println!(
        "zeroth order, {POSES} poses × {SPEEDS} speeds, 8 modes, one thread: {seconds:.2} s; the smallest \
         limit is {:.4} mm",
        1e3 * smallest
    );

    for rpm in [1200.0, 6000.0, 13_000.0] {
        let modes = modes(0.3);
        let chart = Chart::new(&modes, &cut);
        let (limit_s, limit) =
            least(7, || milling_limit(&modes, &cut, &chart, rpm).unwrap().unwrap());
        println!(
            "exact limit at {rpm} rpm: {:.2} ms, {:.5} mm",
            1e3 * limit_s,
            1e3 * limit.depth_m
        );
        let depth_m = 0.9 * limit.depth_m;
        let (own_s, own) = least(7, || milling_radius(&modes, &cut, rpm, depth_m).unwrap());
        let milling = Milling::new(&cut, rpm);
        // As many steps a period as the fastest mode needs for twenty an oscillation.
        let steps = ((20.0 * 950.0 * milling.period_s()).ceil() as usize).max(40);
        let (other_s, other) = least(1, || semi_discretised(&modes, &milling, depth_m, steps));
        println!(
            "  spectral radius at 0.9 of it: {:.3} ms ({own:.6}); semi-discretisation in {steps} steps \
             {:.1} ms ({other:.6}): {:.0} times as long",
            1e3 * own_s,
            1e3 * other_s,
            other_s / own_s
        );
    }
}
