//! `detune identify` on records as people have them: a roving hammer, a telephone's clock, a slow camera. The truth
//! is a chain of masses and springs: its frequency responses by solving with the dynamic stiffness, its motion by
//! steps of Runge and Kutta, its modes by the eigenvalues of M⁻½ K M⁻½.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::program::{self};
use crate::vibration::{C64, gauss, seeded};
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use serde_json::Value;

/// Masses in a row, the first one held by a spring to the ground; damping in proportion to stiffness and mass.
struct Chain {
    mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
}

/// Natural frequency, Hz, damping ratio, and the mass-normalised shape.
type ChainMode = (f64, f64, DVector<f64>);

impl Chain {
    fn new(masses: &[f64], springs: &[f64], [by_mass, by_stiffness]: [f64; 2]) -> Self {
        let n = masses.len();
        let mass = DMatrix::from_diagonal(&DVector::from_column_slice(masses));
        let stiffness = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => springs[i] + springs.get(i + 1).copied().unwrap_or(0.0),
            1 => -springs[i.max(j)],
            _ => 0.0,
        });
        let damping = &mass * by_mass + &stiffness * by_stiffness;
        Self { mass, stiffness, damping }
    }

    fn modes(&self) -> Vec<ChainMode> {
        let root = self.mass.map_diagonal(|m| m.powf(-0.5));
        let scale = DMatrix::from_diagonal(&root);
        let eigen = (&scale * &self.stiffness * &scale).symmetric_eigen();
        let mut modes: Vec<ChainMode> = (0..root.len())
            .map(|r| {
                let omega = eigen.eigenvalues[r].sqrt();
                let shape = &scale * eigen.eigenvectors.column(r);
                let damping = (shape.transpose() * &self.damping * &shape)[(0, 0)];
                (omega / std::f64::consts::TAU, damping / (2.0 * omega), shape)
            })
            .collect();
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes
    }

    /// Accelerations at all masses for a force at one.
    fn accelerance(&self, hz: f64, drive: usize) -> DVector<C64> {
        let omega = std::f64::consts::TAU * hz;
        let n = self.mass.nrows();
        let dynamic = DMatrix::from_fn(n, n, |i, j| {
            let real = self.stiffness[(i, j)] - omega * omega * self.mass[(i, j)];
            C64::new(real, omega * self.damping[(i, j)])
        });
        let force = DVector::from_fn(n, |i, _| C64::new(f64::from(u8::from(i == drive)), 0.0));
        dynamic.lu().solve(&force).unwrap() * C64::new(-omega * omega, 0.0)
    }

    /// Displacements at rising times after all masses got a speed.
    fn decay(&self, speed: &[f64], times: &[f64]) -> Vec<Vec<f64>> {
        const STEP_S: f64 = 2e-4;
        let inverse = self.mass.clone().try_inverse().unwrap();
        let accelerate = |x: &DVector<f64>, v: &DVector<f64>| {
            -&inverse * (&self.stiffness * x + &self.damping * v)
        };
        let n = speed.len();
        let (mut x, mut v) = (DVector::zeros(n), DVector::from_column_slice(speed));
        let mut now = 0.0;
        let mut all = vec![Vec::new(); n];
        for &time in times {
            let steps = ((time - now) / STEP_S).ceil().max(1.0);
            let h = (time - now) / steps;
            for _ in 0..steps as usize {
                let (v1, a1) = (v.clone(), accelerate(&x, &v));
                let v2 = &v + &a1 * (0.5 * h);
                let a2 = accelerate(&(&x + &v1 * (0.5 * h)), &v2);
                let v3 = &v + &a2 * (0.5 * h);
                let a3 = accelerate(&(&x + &v2 * (0.5 * h)), &v3);
                let v4 = &v + &a3 * h;
                let a4 = accelerate(&(&x + &v3 * h), &v4);
                x += (v1 + (v2 + v3) * 2.0 + v4) * (h / 6.0);
                v += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
            }
            now = time;
            all.iter_mut().enumerate().for_each(|(i, samples)| samples.push(x[i]));
        }
        all
    }
}

/// A frequency response of acceleration as data set 58.
fn response_set(response: &str, reference: (usize, i32), values: &[C64], step_hz: f64) -> String {
    let (node, direction) = (response, 3);
    let mut text = format!(
        "    -1\n    58\nroving\nNONE\nNONE\nNONE\nNONE\n{:5}{:10}{:5}{:10} {:<10}",
        4, 0, 1, 0, "NONE"
    );
    let _ =
        writeln!(text, "{node:>10}{direction:4} {:<10}{:10}{:4}", "NONE", reference.0, reference.1);
    let _ = writeln!(
        text,
        "{:10}{:10}{:10}{:13.5e}{step_hz:13.5e}{:13.5e}",
        6,
        values.len(),
        1,
        step_hz,
        0.0
    );
    for kind in [18, 12, 13, 0] {
        let _ = writeln!(text, "{kind:10}{:5}{:5}{:5} {:<20} {:<20}", 0, 0, 0, "NONE", "");
    }
    for value in values {
        let _ = writeln!(text, "{:20.11e}{:20.11e}", value.re, value.im);
    }
    text + "    -1\n"
}

fn identified(folder: &Path, session: &str) -> Value {
    fs::write(folder.join("s.yaml"), session).unwrap();
    let output = program::run(folder, &["identify", "s.yaml", "--format", "json"]);
    assert!(output.status.success(), "{}", program::err(&output));
    program::json(&output)
}

fn codes(found: &Value) -> Vec<String> {
    let notices = found["records"][0]["notices"].as_array().unwrap();
    notices.iter().map(|n| n["code"].as_str().unwrap().to_owned()).collect()
}

fn frequencies(found: &Value) -> Vec<f64> {
    let modes = found["records"][0]["modes"].as_array().unwrap();
    modes.iter().map(|mode| mode["frequency_hz"].as_f64().unwrap()).collect()
}

fn chain() -> Chain {
    Chain::new(&[2.0, 1.5, 1.0, 0.8], &[9e4, 7e4, 5e4, 6e4], [0.8, 5e-5])
}

const STEP_HZ: f64 = 0.25;

/// All pairs of sensors and hits (direction of the hit: 3 or −3), with noise of 0.5 % of each response's mean.
fn roving(sensors: &[usize], hits: &[(usize, i32)], spoilt: Option<usize>) -> String {
    let chain = chain();
    let mut rng = seeded(5);
    let mut text = String::new();
    for (place, &(hit, direction)) in hits.iter().enumerate() {
        for &sensor in sensors {
            let lines = 1..360;
            let exact: Vec<C64> = lines
                .map(|k| {
                    chain.accelerance(f64::from(k) * STEP_HZ, hit)[sensor]
                        * f64::from(direction.signum())
                })
                .collect();
            let noise = 5e-3 * exact.iter().map(|v| v.norm()).sum::<f64>() / exact.len() as f64;
            let sign = if spoilt == Some(place) { -1.0 } else { 1.0 };
            let values: Vec<C64> = exact
                .iter()
                .map(|v| (v + C64::new(gauss(&mut rng), gauss(&mut rng)) * noise) * sign)
                .collect();
            text +=
                &response_set(&(sensor + 1).to_string(), (hit + 1, direction), &values, STEP_HZ);
        }
    }
    text
}

fn must_have_the_chains_shapes(found: &Value) {
    let truth = chain().modes();
    let told = frequencies(found);
    assert_eq!(told.len(), 4, "{told:?} {:?}", codes(found));
    for (mode, (hz, ratio, shape)) in truth.iter().enumerate() {
        let of = &found["records"][0]["modes"][mode];
        assert!((told[mode] / hz - 1.0).abs() < 1e-3, "{told:?} {hz}");
        assert!((of["damping_ratio"].as_f64().unwrap() / ratio - 1.0).abs() < 0.1, "{of} {ratio}");
        let parts = of["shape"].as_array().unwrap();
        assert_eq!(parts.len(), 4, "{parts:?}");
        let largest = shape.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap();
        for part in parts {
            let name = part["response"].as_str().unwrap();
            let node: usize = name.strip_suffix("+Z").unwrap().parse().unwrap();
            let own = part["mass_normalised"][0].as_f64().unwrap();
            let exact = shape[node - 1] * largest.signum();
            assert!((own - exact).abs() < 0.03 * largest.abs(), "{part} {exact}");
        }
    }
}

/// One sensor and a hammer that goes round; and two sensors, one hit in the opposite direction.
#[test]
fn a_roving_hammer_gives_shapes_over_the_points_it_hit() {
    let folder = tempfile::tempdir().unwrap();
    let session = "records:\n  - {file: r.uff, pose: {beta2_rad: 1}}\n";
    let hits = [(0, 3), (1, 3), (2, 3), (3, 3)];
    fs::write(folder.path().join("r.uff"), roving(&[0], &hits, None)).unwrap();
    let found = identified(folder.path(), session);
    must_have_the_chains_shapes(&found);
    assert!(codes(&found).is_empty(), "{:?}", codes(&found));
    let hits = [(0, 3), (1, -3), (2, 3), (3, 3)];
    fs::write(folder.path().join("r.uff"), roving(&[0, 2], &hits, None)).unwrap();
    let found = identified(folder.path(), session);
    must_have_the_chains_shapes(&found);
    assert!(codes(&found).is_empty(), "{:?}", codes(&found));
    // One reference alone, as it is asked for.
    let found = identified(
        folder.path(),
        "records:\n  - {file: r.uff, pose: {beta2_rad: 1}, excitation: 3+Z}\n",
    );
    assert_eq!(found["records"][0]["modes"][0]["shape"].as_array().unwrap().len(), 2);
}

/// A hit that was written down in the wrong direction.
#[test]
fn what_breaks_reciprocity_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let hits = [(0, 3), (1, 3), (2, 3), (3, 3)];
    fs::write(folder.path().join("r.uff"), roving(&[0, 2], &hits, Some(2))).unwrap();
    let found = identified(folder.path(), "records:\n  - {file: r.uff, pose: {beta2_rad: 1}}\n");
    let notices = found["records"][0]["notices"].as_array().unwrap();
    let told: Vec<&str> = notices.iter().map(|n| n["what"].as_str().unwrap()).collect();
    assert!(told.iter().any(|what| what.contains("(reciprocity)")), "{told:?}");
}

fn csv_of(times: &[f64], columns: &[Vec<f64>]) -> String {
    let mut text = String::from("time_s,x_m,y_m\n");
    for (k, time) in times.iter().enumerate() {
        let _ = writeln!(text, "{time:.6},{:.7e},{:.7e}", columns[0][k], columns[1][k]);
    }
    text
}

/// Two masses with modes at 8.0 and 22.1 Hz, a clock that is off by up to 0.3 of a step, 26 dB.
#[test]
fn a_telephones_clock_is_made_even() {
    let chain = Chain::new(&[2.0, 1.0], &[1.2e4, 8e3], [0.9, 1e-4]);
    for seed in 0..3 {
        let mut rng = seeded(seed);
        let times: Vec<f64> =
            (0..500).map(|k| 0.01 * (f64::from(k) + 0.6 * (rng.random::<f64>() - 0.5))).collect();
        let times: Vec<f64> = times.iter().map(|t| t - times[0]).collect();
        let clean = chain.decay(&[0.1, -0.3], &times);
        let columns = crate::vibration::noisy(&clean, 0.05, &mut rng);
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("p.csv"), csv_of(&times, &columns)).unwrap();
        let found =
            identified(folder.path(), "records:\n  - {file: p.csv, pose: {beta2_rad: 1}}\n");
        let told = frequencies(&found);
        let truth = chain.modes();
        assert_eq!(told.len(), 2, "{told:?} {:?}", codes(&found));
        for (mode, (hz, ratio, _)) in truth.iter().enumerate() {
            let of = &found["records"][0]["modes"][mode];
            assert!((told[mode] / hz - 1.0).abs() < 2e-3, "{told:?} {hz}");
            let own = of["damping_ratio"].as_f64().unwrap();
            assert!((own / ratio - 1.0).abs() < 0.1, "{own} {ratio}");
        }
        let notices = found["records"][0]["notices"].as_array().unwrap();
        let is_told = |n: &&Value| n["what"].as_str().unwrap().contains("cubic spline");
        assert_eq!(notices.iter().filter(is_told).count(), 1, "{notices:?}");
    }
}

/// At 60 frames/s a mode at 39.4 Hz shows at 20.6 Hz and nothing in the record says so: both modes may be folded.
#[test]
fn at_a_low_rate_every_mode_may_be_folded() {
    // 23.2 and 39.4 Hz, by the two roots of the chain's characteristic polynomial.
    let chain = Chain::new(&[1.0, 1.0], &[2.6e4, 5.0e4], [1.0, 3e-5]);
    let truth = chain.modes();
    let times: Vec<f64> = (0..480).map(|k| f64::from(k) / 60.0).collect();
    let columns = crate::vibration::noisy(&chain.decay(&[0.3, -0.2], &times), 0.02, &mut seeded(1));
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("c.csv"), csv_of(&times, &columns)).unwrap();
    let found = identified(folder.path(), "records:\n  - {file: c.csv, pose: {beta2_rad: 1}}\n");
    let told = frequencies(&found);
    assert_eq!(told.len(), 2, "{told:?}");
    let folded = |hz: f64| (hz - 60.0 * (hz / 60.0).round()).abs();
    let mut seen: Vec<f64> = truth.iter().map(|(hz, _, _)| folded(*hz)).collect();
    seen.sort_by(f64::total_cmp);
    assert!(truth[1].0 > 30.0 && told.iter().zip(&seen).all(|(a, b)| (a - b).abs() < 0.1));
    let notices = found["records"][0]["notices"].as_array().unwrap();
    for hz in told {
        let is_told = |n: &Value| {
            let what = n["what"].as_str().unwrap();
            n["code"] == "may_be_folded" && what.starts_with(&format!("{hz:.3} Hz"))
        };
        assert!(notices.iter().any(is_told), "{hz}: {notices:?}");
    }
}

/// Shapes and synthesised responses of a roving hammer, read again: the same modes.
#[test]
fn synthesised_responses_have_the_modes_that_made_them() {
    let folder = tempfile::tempdir().unwrap();
    let hits = [(0, 3), (1, 3), (2, 3), (3, 3)];
    fs::write(folder.path().join("r.uff"), roving(&[0], &hits, None)).unwrap();
    let session = "records:\n  - {file: r.uff, pose: {beta2_rad: 1}}\n";
    let first = identified(folder.path(), session);
    let output = program::run(folder.path(), &["identify", "s.yaml", "--write-uff", "modes.uff"]);
    assert!(output.status.success(), "{}", program::err(&output));
    let text = fs::read_to_string(folder.path().join("modes.uff")).unwrap();
    let sets = |kind: &str| text.matches(&format!("    -1\n    {kind}\n")).count();
    assert_eq!((sets("55"), sets("58")), (4, 4));
    // Three complex translations a node, on one line, as pyuff 2.4.2 reads them; it does not read six.
    assert_eq!(
        text.matches("\n         1         3         2         8         5         3\n").count(),
        4
    );
    let again =
        identified(folder.path(), "records:\n  - {file: modes.uff, pose: {beta2_rad: 1}}\n");
    let (before, after) = (frequencies(&first), frequencies(&again));
    assert_eq!(after.len(), 4, "{after:?} {:?}", codes(&again));
    for (mode, (a, b)) in before.iter().zip(&after).enumerate() {
        assert!((a / b - 1.0).abs() < 1e-4, "{before:?} {after:?}");
        let part = |found: &Value, place: usize| {
            let part = &found["records"][0]["modes"][mode]["shape"][place];
            (part["response"].as_str().unwrap().to_owned(), part["re"].as_f64().unwrap())
        };
        for place in 0..4 {
            let ((a_name, a), (b_name, b)) = (part(&first, place), part(&again, place));
            assert!(a_name == b_name && (a - b).abs() < 0.01, "{a_name} {a}, {b_name} {b}");
        }
    }
    let reused = program::run(folder.path(), &["identify", "s.yaml", "--write-uff", "modes.uff"]);
    assert_eq!(reused.status.code(), Some(2), "an input is written over");
}

/// Of a roving hammer with two sensors, each pair that was measured is synthesised, with its own reference: those of the
/// chain's dynamic stiffness, within 1 % of each one's loudest line.
#[test]
fn synthesised_responses_of_several_references_say_which() {
    let folder = tempfile::tempdir().unwrap();
    let hits = [(0, 3), (1, 3), (2, 3), (3, 3)];
    fs::write(folder.path().join("r.uff"), roving(&[0, 2], &hits, None)).unwrap();
    fs::write(folder.path().join("s.yaml"), "records:\n  - {file: r.uff, pose: {beta2_rad: 1}}\n")
        .unwrap();
    let output = program::run(folder.path(), &["identify", "s.yaml", "--write-uff", "modes.uff"]);
    assert!(output.status.success(), "{}", program::err(&output));
    let text = fs::read_to_string(folder.path().join("modes.uff")).unwrap();
    let chain = chain();
    let mut pairs = Vec::new();
    for set in text.split("    -1\n    58\n").skip(1) {
        let lines: Vec<&str> = set.lines().collect();
        let words: Vec<&str> = lines[5].split_whitespace().collect();
        let place = |word: &str| word.parse::<usize>().unwrap();
        let (response, reference) = (place(words[5]), place(words[8]));
        assert_eq!([words[6], words[9]], ["3", "3"], "{}", lines[5]);
        pairs.push((response, reference));
        let grid: Vec<f64> =
            lines[6].split_whitespace().skip(3).take(2).map(|w| w.parse().unwrap()).collect();
        let values = lines[11..].iter().take_while(|line| line.trim() != "-1").map(|line| {
            let both: Vec<f64> = line.split_whitespace().map(|w| w.parse().unwrap()).collect();
            C64::new(both[0], both[1])
        });
        let (mut most, mut off) = (0.0_f64, 0.0_f64);
        for (k, value) in values.enumerate() {
            let hz = grid[0] + k as f64 * grid[1];
            let omega = std::f64::consts::TAU * hz;
            let truth = chain.accelerance(hz, reference - 1)[response - 1] / -(omega * omega);
            most = most.max(truth.norm());
            off = off.max((value - truth).norm());
        }
        assert!(off < 0.01 * most, "{response} {reference}: {off} of {most}");
    }
    pairs.sort_unstable();
    let measured: Vec<(usize, usize)> =
        [1, 3].into_iter().flat_map(|own| (1..=4).map(move |hit| (own, hit))).collect();
    assert_eq!(pairs, measured);
}

/// What a column makes of a value.
type OfValue = fn(C64) -> f64;

/// The two columns of a response as laboratories call them, with what each holds.
const COLUMNS: [([&str; 2], [OfValue; 2]); 7] = [
    (["tip_re", "tip_im"], [|v| v.re, |v| v.im]),
    (["Re(tip) [m/s2/N]", "Im(tip) [m/s2/N]"], [|v| v.re, |v| v.im]),
    (["tip real", "tip imag"], [|v| v.re, |v| v.im]),
    (["tip_mag_m_per_s2_per_n", "tip_phase_deg"], [|v| v.norm(), |v| v.arg().to_degrees()]),
    (["tip magnitude", "tip phase [rad]"], [|v| v.norm(), |v| v.arg()]),
    (["tip_db", "tip_phase (deg)"], [|v| 20.0 * v.norm().log10(), |v| v.arg().to_degrees()]),
    (["Magnitude [dB]", "Phase [deg]"], [|v| 20.0 * v.norm().log10(), |v| v.arg().to_degrees()]),
];

/// A table of frequencies in a unit of `in_hz` and of one response, with a coherence.
fn table(frequency: &str, in_hz: f64, titles: [&str; 2], of: [OfValue; 2]) -> String {
    let chain = chain();
    let mut rng = seeded(9);
    let mut text = format!("{frequency};{};{};coherence\n", titles[0], titles[1]);
    for k in 1..360 {
        let hz = f64::from(k) * STEP_HZ;
        let noise = C64::new(gauss(&mut rng), gauss(&mut rng)) * 2e-3;
        let value = chain.accelerance(hz, 0)[3] + noise;
        let _ = writeln!(text, "{};{};{};1", hz / in_hz, of[0](value), of[1](value));
    }
    text
}

/// However its columns are called, a table holds the same frequency response.
#[test]
fn a_table_holds_frequency_responses() {
    let folder = tempfile::tempdir().unwrap();
    let session = "records:\n  - {file: r.csv, pose: {beta2_rad: 1}, excitation: hammer}\n";
    let truth: Vec<f64> = chain().modes().iter().map(|mode| mode.0).collect();
    let mut constants: Vec<f64> = Vec::new();
    let clocks = [
        ("f_hz", 1.0),
        ("Frequency [kHz]", 1e3),
        ("omega_rad_per_s", std::f64::consts::TAU.recip()),
    ];
    for (place, (titles, of)) in COLUMNS.into_iter().enumerate() {
        let (frequency, in_hz) = clocks[place % clocks.len()];
        fs::write(folder.path().join("r.csv"), table(frequency, in_hz, titles, of)).unwrap();
        let found = identified(folder.path(), session);
        let told = frequencies(&found);
        assert_eq!(told.len(), 4, "{titles:?} {told:?} {:?}", codes(&found));
        for (told, truth) in told.iter().zip(&truth) {
            assert!((told / truth - 1.0).abs() < 1e-3, "{titles:?} {told} {truth}");
        }
        let constant = &found["records"][0]["modes"][0]["shape"][0];
        let name = if place == 6 { "response" } else { "tip" };
        assert_eq!(constant["response"], name, "{titles:?}");
        let size = &constant["modal_constant"];
        constants.push(size[0].as_f64().unwrap().hypot(size[1].as_f64().unwrap()));
    }
    // Where the unit says that it is an acceleration, the constant is that of the displacement.
    for (place, constant) in constants.iter().enumerate() {
        let same = if [1, 3].contains(&place) { constants[1] } else { constants[0] };
        assert!((constant / same - 1.0).abs() < 1e-6, "{constants:?}");
    }
    assert!(constants[1] < 1e-3 * constants[0], "{constants:?}");
}

/// What a table lacks, or cannot mean, is an error with its line.
#[test]
fn a_table_that_holds_no_whole_frequency_response_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let session = "records:\n  - {file: r.csv, pose: {beta2_rad: 1}}\n";
    fs::write(folder.path().join("s.yaml"), session).unwrap();
    let angle: OfValue = |v| v.arg();
    for (titles, of, what) in [
        (["tip_re", "other_im"], COLUMNS[0].1, "column 'tip_re' has no imaginary part beside it"),
        (["tip_db", "tip"], COLUMNS[5].1, "column 'tip_db' has no phase beside it"),
        (["tip_mag", "tip_phase"], COLUMNS[4].1, "column 'tip_phase' must say its unit"),
        (["tip_mag", "tip_phase_deg"], [COLUMNS[4].1[0], angle], "is it in radians?"),
        (["tip_mag", "tip_phase_rad"], COLUMNS[3].1, "is it in degrees?"),
        (["tip_mag", "tip_phase_deg"], COLUMNS[5].1, "has negative values: decibels"),
        (["tip_re", "tip real"], COLUMNS[0].1, "columns 'tip_re' and 'tip real' are the same"),
        (["x_mm", "y_mm"], COLUMNS[0].1, "and none that is a part of one"),
    ] {
        let text = table("frequency_hz", 1.0, titles, of);
        fs::write(folder.path().join("r.csv"), text).unwrap();
        let output = program::run(folder.path(), &["identify", "s.yaml"]);
        let told = program::err(&output);
        let line = if titles[0] == "x_mm" { "s.yaml:2: " } else { "r.csv:1: " };
        assert_eq!(output.status.code(), Some(2), "{titles:?}: {told}");
        assert!(told.contains(what) && told.contains(line), "{titles:?}: {told}");
    }
}

/// Magnitudes, with or without decibels, and pairs of decibels and degrees are no complex response.
#[test]
fn a_data_set_without_real_and_imaginary_part_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.yaml"), "records:\n  - {file: r.uff, pose: {beta2_rad: 1}}\n")
        .unwrap();
    let values: Vec<C64> =
        (1..200).map(|k| (C64::new(400.0 - f64::from(k * k) * 0.25, f64::from(k))).inv()).collect();
    let decibels = |v: &C64| 20.0 * v.norm().log10();
    let magnitudes: Vec<C64> = values.iter().map(|v| C64::new(v.norm(), 0.0)).collect();
    let plain: Vec<C64> = values.iter().map(|v| C64::new(decibels(v), 0.0)).collect();
    let pairs: Vec<C64> =
        values.iter().map(|v| C64::new(decibels(v), v.arg().to_degrees())).collect();
    let unit = |text: String| {
        let axis = format!("{:10}{:5}{:5}{:5} {:<20} {:<20}", 12, 0, 0, 0, "NONE", "");
        assert!(text.contains(&axis));
        text.replacen(
            &axis,
            &format!("{:10}{:5}{:5}{:5} {:<20} {:<20}", 12, 0, 0, 0, "NONE", "dB"),
            1,
        )
    };
    for (text, what) in [
        (response_set("1", (1, 3), &magnitudes, 0.5), "has no imaginary part, as a magnitude"),
        (response_set("1", (1, 3), &plain, 0.5), "has no imaginary part"),
        (unit(response_set("1", (1, 3), &pairs, 0.5)), "is in decibels: export real"),
    ] {
        fs::write(folder.path().join("r.uff"), text).unwrap();
        let output = program::run(folder.path(), &["identify", "s.yaml"]);
        let told = program::err(&output);
        assert_eq!(output.status.code(), Some(2), "{what}: {told}");
        assert!(told.contains(what) && told.contains("r.uff:2: "), "{what}: {told}");
    }
}
