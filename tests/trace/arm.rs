//! The two-link arm in free vibration before a rolling shutter: film → trace → identify.

use std::f64::consts::TAU;
use std::fs;

use serde_json::Value;

use crate::command::{detune, text};
use crate::film::{Camera, Disc, Edge, y4m};
use crate::vibration::seeded;

/// Damped frequency, damping ratio, rotations of both links (the paper's Table 2 at β2 = 1.571 rad, and
/// signs of its Fig. 4), amplitude in rad, phase.
const MODES: [(f64, f64, [f64; 2], f64, f64); 2] =
    [(23.195, 0.02, [1.0, 0.69], 0.011, 0.4), (39.398, 0.015, [0.3, -1.0], 0.009, 1.9)];

/// Joints A and B and the tip C at rest, px from the left and top.
const REST: [[f64; 2]; 3] = [[60.4, 196.3], [150.2, 62.1], [262.7, 190.8]];
const MM_PER_PX: f64 = 2.0;
const RATE: u32 = 240;
const FRAMES: usize = 600;

fn rotations(time: f64) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for (hz, ratio, shape, amplitude, phase) in MODES {
        let omega = TAU * hz / (1.0 - ratio * ratio).sqrt();
        let q = amplitude * (-ratio * omega * time).exp() * (TAU * hz * time + phase).cos();
        sum = [sum[0] + shape[0] * q, sum[1] + shape[1] * q];
    }
    sum
}

fn turned(vector: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [vector[0] * cos - vector[1] * sin, vector[0] * sin + vector[1] * cos]
}

fn discs(time: f64) -> Vec<Disc> {
    let [first, second] = rotations(time);
    let [a, b, c] = REST;
    let of_first = turned([b[0] - a[0], b[1] - a[1]], first);
    let elbow = [a[0] + of_first[0], a[1] + of_first[1]];
    let of_second = turned([c[0] - b[0], c[1] - b[1]], second);
    let tip = [elbow[0] + of_second[0], elbow[1] + of_second[1]];
    [a, elbow, tip].map(|at| Disc { at, radius: 8.0, contrast: 150.0, edge: Edge::Soft }).to_vec()
}

/// Without `readout_ms` rows 130 px apart are 8.7 ms apart: 123° at 39.4 Hz.
#[test]
fn a_film_of_the_arm_gives_its_frequencies_and_with_the_readout_its_shapes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let camera = Camera { width: 320, height: 240, noise: 1.5, readout_s: 0.016 };
    let mut rng = seeded(11);
    let frames: Vec<Vec<u8>> = (0..FRAMES)
        .map(|k| camera.frame(k as f64 / f64::from(RATE), &|_, _| 50.0, &discs, &mut rng))
        .collect();
    fs::write(path("clip.y4m"), y4m(&camera, RATE, &frames)).unwrap();
    let [a, b, _] = REST;
    let distance = MM_PER_PX * (a[0] - b[0]).hypot(a[1] - b[1]);
    let marks = format!(
        "scale: {{points_px: {:?}, distance_mm: {distance}}}\n\
         round_marks: {{count: 3, names: [a, b, c]}}\n",
        [a, b]
    );
    let at = |k: usize| {
        let [x, y] = REST[k];
        format!("at_mm: [{}, {}]", MM_PER_PX * x, MM_PER_PX * (240.0 - y))
    };
    let session = format!(
        "mains_hz: []\nmarkers:\n  link_1: [{{{}}}, {{{}, x: b_x_mm, y: b_y_mm}}]\n  link_2: \
         [{{{1}, x: b_x_mm, y: b_y_mm}}, {{{}, x: c_x_mm, y: c_y_mm}}]\nrecords:\n  - {{file: \
         traces.csv, pose: {{beta2_rad: 1.571}}, responses: [b_x_mm, b_y_mm, c_x_mm, c_y_mm]}}\n",
        at(0),
        at(1),
        at(2)
    );
    fs::write(path("session.yaml"), session).unwrap();
    for has_readout in [true, false] {
        let readout = if has_readout { "readout_ms: 16\n" } else { "" };
        fs::write(path("marks.yaml"), format!("{readout}{marks}")).unwrap();
        let traced = detune(
            &["trace", "clip.y4m", "--marks", "marks.yaml", "--output", "traces.csv"],
            folder.path(),
        );
        assert!(traced.status.success(), "{}", text(&traced.stderr));
        let table = fs::read_to_string(path("traces.csv")).unwrap();
        println!("{}", table.lines().take(6).collect::<Vec<_>>().join("\n"));
        let found = detune(&["identify", "session.yaml", "--format", "json"], folder.path());
        assert!(found.status.success(), "{}", text(&found.stderr));
        let found: Value = serde_json::from_slice(&found.stdout).unwrap();
        let modes = found["records"][0]["modes"].as_array().unwrap();
        // Rows that move while they are read modulate time: with the readout unknown, sums and
        // differences of the frequencies appear.
        assert!(modes.len() == 2 || !has_readout, "{modes:#?}");
        let mut worst: f64 = 0.0;
        for (hz, ratio, shape, ..) in MODES {
            let off = |mode: &&Value| (mode["frequency_hz"].as_f64().unwrap() - hz).abs();
            let mode = modes.iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
            let number = |key: &str| mode[key].as_f64().unwrap();
            // Written is the damped frequency; identified is the natural one.
            let natural = hz / f64::sqrt(1.0 - ratio * ratio);
            let off = (number("frequency_hz") - natural) / number("frequency_std_hz");
            let damping = (number("damping_ratio") - ratio) / number("damping_ratio_std");
            let rotation = |link: usize| {
                let parts = &mode["links"][link]["rotation_rad"];
                nalgebra::Complex::new(parts[0].as_f64().unwrap(), parts[1].as_f64().unwrap())
            };
            let share = rotation(1) / rotation(0) / (-shape[1] / shape[0]);
            worst = worst.max((share + 1.0).norm());
            println!(
                "{has_readout}: {} Hz, {off:.2} σ; damping {damping:.2} σ; shape off by {:.4}",
                number("frequency_hz"),
                (share + 1.0).norm()
            );
            assert!(off.abs() < 3.0 && damping.abs() < 4.0, "{off} {damping}");
        }
        assert!(if has_readout { worst < 0.02 } else { worst > 0.3 }, "{has_readout}: {worst}");
    }
}
