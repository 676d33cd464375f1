//! `detune identify` as a user runs it: formats of files, the table it writes, faults of the session and of
//! its files, the example session, and what the paper's camera would give.
//!
//! `robots/two-link/session.yaml` and the records beside it are made by `camera_record` below: the measured
//! frequencies of the paper's Table 2 at three poses, with damping and rotations of the links that are
//! assumed here, as its camera would have seen them (140 frames/s, 5 s, points B and C). After a change, run
//! `DETUNE_WRITE_EXAMPLE=1 cargo test --test commands identify` to write them anew.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::program::{self, repository};
use crate::vibration::{C64, TrueMode, free_decay, gauss, hammered, noisy, pulses, rms, seeded};
use detune::identify::pose::{JointColumn, Pose};
use detune::identify::record::Conditions;
use detune::identify::session::{IdentifiedSession, PoseMode, PoseModes};
use detune::input::{Reading, read_described_robot, read_measured};
use detune::notes::Code;
use detune::report::identify::measured_csv;
use detune::study::identify::table_on;
use detune::units::mm_from_m;
use rand::RngExt;
use serde_json::Value;

fn identify(arguments: &[&str], folder: &Path) -> Output {
    program::run(folder, &[&["identify"], arguments].concat())
}

fn json(arguments: &[&str], folder: &Path) -> Value {
    let output = identify(&[arguments, &["--format", "json"]].concat(), folder);
    assert!(output.status.success(), "{}", program::err(&output));
    program::json(&output)
}

fn faults(session: &str, folder: &Path) -> String {
    fs::write(folder.join("s.yaml"), session).unwrap();
    let output = identify(&["s.yaml", "--write", "m.csv"], folder);
    assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stdout.is_empty() && !folder.join("m.csv").exists());
    String::from_utf8(output.stderr).unwrap()
}

fn frequencies(found: &Value, record: usize) -> Vec<f64> {
    let modes = found["records"][record]["modes"].as_array().unwrap();
    modes.iter().map(|mode| mode["frequency_hz"].as_f64().unwrap()).collect()
}

fn csv(titles: &[&str], columns: &[Vec<f64>]) -> String {
    let mut text = titles.join(",") + "\n";
    for row in 0..columns[0].len() {
        let cells: Vec<String> = columns.iter().map(|c| format!("{:.7e}", c[row])).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

fn uff_head(
    function: u8,
    node: usize,
    data_type: u8,
    count: usize,
    step: f64,
    quantity: u8,
) -> String {
    let mut text = format!(
        "channel {node}\nNONE\nNONE\nNONE\nNONE\n{function:5}{:10}{:5}{:10} {:<10}",
        0, 1, 0, "NONE"
    );
    let _ = writeln!(text, "{node:10}{:4} {:<10}{:10}{:4}", 1, "NONE", 9, 3);
    let _ =
        writeln!(text, "{data_type:10}{count:10}{:10}{:13.5e}{step:13.5e}{:13.5e}", 1, 0.0, 0.0);
    for (kind, unit) in [(17, ""), (quantity, ""), (0, ""), (0, "")] {
        let _ = writeln!(text, "{kind:10}{:5}{:5}{:5} {:<20} {unit:<20}", 0, 0, 0, "NONE");
    }
    text
}

fn wav(path: &Path, rate: u32, channels: &[Vec<f64>]) {
    let spec = hound::WavSpec {
        channels: u16::try_from(channels.len()).unwrap(),
        sample_rate: rate,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let mut writer = hound::WavWriter::create(path, spec).unwrap();
    for k in 0..channels[0].len() {
        channels.iter().for_each(|c| writer.write_sample(c[k] as f32).unwrap());
    }
    writer.finalize().unwrap();
}

/// As `numpy.save` writes an array of samples × channels.
fn npy(path: &Path, channels: &[Vec<f64>]) {
    let shape = format!("({}, {})", channels[0].len(), channels.len());
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{header:<117}\n").bytes());
    let row = |k: usize| channels.iter().flat_map(move |c| c[k].to_le_bytes());
    bytes.extend((0..channels[0].len()).flat_map(row));
    fs::write(path, bytes).unwrap();
}

/// The same hammer test as CSV, UFF as text and binary, WAV, and NPY, and its frequency responses as UFF: the
/// same modes and, where units are known, the same scaling.
#[test]
fn all_formats_give_the_same_modes() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let truth = [TrueMode::new(20.0, 0.02, &[1.0, 0.5]), TrueMode::new(47.0, 0.015, &[0.6, -0.9])];
    let (rate, samples) = (1000.0, 6000);
    let force = pulses(samples, &[100, 3100], 12, 50.0);
    let mut channels = vec![force.clone()];
    channels.extend(noisy(&hammered(&truth, 0, 2, rate, &force), 0.02, &mut seeded(1)));
    fs::write(at("a.csv"), csv(&["hammer_n", "p_m_per_s2", "q_m_per_s2"], &channels)).unwrap();
    wav(&at("a.wav"), 1000, &channels);
    npy(&at("a.npy"), &channels);
    let (mut text, mut binary) = (String::new(), Vec::new());
    for (i, channel) in channels.iter().enumerate() {
        let quantity = if i == 0 { 13 } else { 12 };
        let _ = write!(text, "    -1\n    58\n{}", uff_head(1, i + 1, 4, samples, 1e-3, quantity));
        for pair in channel.chunks(4) {
            pair.iter().for_each(|v| text += &format!("{v:20.11e}"));
            text.push('\n');
        }
        text += "    -1\n";
        binary.extend(format!("    -1\n    58b     1     2          11{:12}     0     0           0           0\n", 8 * samples).bytes());
        binary.extend(uff_head(1, i + 1, 4, samples, 1e-3, quantity).bytes());
        channel.iter().for_each(|v| binary.extend(v.to_le_bytes()));
        binary.extend(b"\n    -1\n");
    }
    fs::write(at("a.uff"), text).unwrap();
    fs::write(at("b.unv"), binary).unwrap();
    // Accelerance with 0.5 % of noise: Σ −ω² φφ/(ω_r² − ω² + 2iζω_rω).
    let mut rng = seeded(2);
    let mut responses = String::new();
    for response in 0..2 {
        let _ =
            write!(responses, "    -1\n    58\n{}", uff_head(4, response + 2, 6, 400, 0.25, 12));
        for k in 0..400_i32 {
            let omega = std::f64::consts::TAU * 0.25 * f64::from(k);
            let exact: C64 = truth
                .iter()
                .map(|m| {
                    let own = std::f64::consts::TAU * m.hz;
                    let below = C64::new(own * own - omega * omega, 2.0 * m.ratio * own * omega);
                    C64::new(-omega * omega * m.shape[response] * m.shape[0], 0.0) / below
                })
                .sum();
            let value = exact + C64::new(gauss(&mut rng), gauss(&mut rng)) * 0.05;
            let _ = writeln!(responses, "{:20.11e}{:20.11e}", value.re, value.im);
        }
        responses += "    -1\n";
    }
    fs::write(at("frf.uff"), responses).unwrap();
    let session = "channels:
  ch1: {unit: N}
  ch2: {unit: m/s2}
  ch3: {unit: m/s2}
records:
  - {file: a.csv, pose: {beta2_rad: 0.1}, excitation: hammer_n, sample_rate_hz: 1000}
  - {file: a.uff, pose: {beta2_rad: 0.2}, excitation: 1+X}
  - {file: b.unv, pose: {beta2_rad: 0.3}, excitation: 1+X, responses: [channel 2, 3+X]}
  - {file: a.wav, pose: {beta2_rad: 0.4}, excitation: ch1}
  - {file: a.npy, pose: {beta2_rad: 0.5}, excitation: ch1, sample_rate_hz: 1000}
  - {file: frf.uff, pose: {beta2_rad: 0.6}, excitation: 9+Z}
";
    fs::write(at("s.yaml"), session).unwrap();
    let found = json(&["s.yaml"], folder.path());
    assert_eq!(found["schema"], "identification/1");
    let first = frequencies(&found, 0);
    for record in 0..6 {
        let these = frequencies(&found, record);
        assert_eq!(these.len(), 2, "{record}: {}", found["records"][record]["notices"]);
        for (mode, truth) in these.iter().zip(&truth) {
            assert!((mode / truth.hz - 1.0).abs() < 1e-3, "{record}: {these:?}");
        }
        if record < 5 {
            // CSV and WAV have seven digits.
            assert!(these.iter().zip(&first).all(|(a, b)| (a / b - 1.0).abs() < 1e-5));
        }
        for (mode, truth) in truth.iter().enumerate() {
            for part in 0..2 {
                let constant =
                    &found["records"][record]["modes"][mode]["shape"][part]["modal_constant"];
                let exact = truth.shape[0] * truth.shape[part];
                assert!(
                    (constant[0].as_f64().unwrap() - exact).abs() < 0.03,
                    "{record}: {constant} {exact}"
                );
            }
        }
    }
}

#[test]
fn faults_have_file_and_line_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("ok.csv"), csv(&["x_mm", "y_mm"], &[vec![0.5; 40], vec![1.0; 40]])).unwrap();
    fs::write(at("bad.csv"), "x_mm\n1\nnan\nz\n").unwrap();
    fs::write(at("bad.uff"), "    -1\n    58\nshort\n    -1\n").unwrap();
    fs::write(at("bad.wav"), "RIFFRIFF").unwrap();
    fs::write(at("what.tdms"), "").unwrap();
    let told = faults(
        "sample_rate_hz: 140
band_hz: [30, 10]
markers:
  link_1: [{at_mm: [0, 0]}, {at_mm: [1, 1], x: x_mm}]
records:
  - {file: ok.csv, pose: {beta2_rad: 1, joints_deg: [1]}}
  - {file: ok.csv, pose: {beta2_rad: .nan}}
  - {file: ok.csv, pose: {beta2_rad: 1}, excitation: hamer, responses: [x_mm]}
  - {file: ok.csv, pose: {beta2_rad: 1}, excitation: y_mm, responses: [y_mm, x_m]}
  - {file: bad.csv, pose: {beta2_rad: 1}}
  - {file: bad.uff, pose: {beta2_rad: 1}}
  - {file: bad.wav, pose: {beta2_rad: 1}}
  - {file: what.tdms, pose: {beta2_rad: 1}}
  - {file: none.csv, pose: {joints_deg: [1]}, respones: [x]}
",
        folder.path(),
    );
    for expected in [
        "s.yaml:2: band_hz is [30, 10]",
        "s.yaml:4: markers: link 'link_1': point 2 has one of x and y",
        "s.yaml:6: pose has both",
        "s.yaml:7: record 2: pose.beta2_rad is",
        "s.yaml:8: excitation 'hamer' is not in file 'ok.csv'",
        "s.yaml:9: response 'y_mm' is the excitation, too",
        "s.yaml:9: response 'x_m' is not in file 'ok.csv'; did you mean 'x_mm'?",
        "bad.csv:3: x_mm is 'nan', must be a finite number",
        "bad.csv:4: x_mm is 'z', must be a finite number",
        "bad.uff:2: data set 58 ends within its header",
        "bad.wav: is no WAV file",
        "what.tdms: ends in '.tdms'",
        "s.yaml:14: file 'none.csv': no such file",
        "s.yaml:14: record 9: unknown key 'respones'; did you mean 'responses'?",
        "s.yaml:14: pose is given otherwise than that of the first record",
    ] {
        assert!(told.contains(expected), "{expected}\nin\n{told}");
    }
    let told = faults("records:\n  - {file: ok.csv, pose: {beta2_rad: 1}}\n", folder.path());
    assert!(told.contains("states no sampling rate"), "{told}");
    let rows: String = (1..10).map(|k| format!("{k},{},3\n", k * k)).collect();
    fs::write(folder.path().join("frf.csv"), format!("frequency_hz,H,G\n{rows}")).unwrap();
    let told = faults(
        "sample_rate_hz: 140\nrecords:\n  - {file: frf.csv, pose: {beta2_rad: 1}}\n",
        folder.path(),
    );
    assert!(told.contains("s.yaml:3: file 'frf.csv' has a column 'frequency_hz'"), "{told}");
    let told = faults(
        "sample_rate_hz: 140
records:
  - {file: ok.csv, pose: {beta1_rad: 2, beta2_rad: 1}}
  - {file: ok.csv, pose: {beta1_rad: 2}}
  - {file: ok.csv, pose: {beta2_rad: 1}}
",
        folder.path(),
    );
    for expected in [
        "s.yaml:4: pose has beta1_rad without beta2_rad, must have both",
        "s.yaml:5: pose is given otherwise than that of the first record, by beta1_rad and beta2_rad",
    ] {
        assert!(told.contains(expected), "{expected}\nin\n{told}");
    }
}

/// A file of MATLAB as SciPy wrote it: units from the names of its variables, and time that the session names.
#[test]
fn variables_of_matlab_are_channels() {
    let folder = tempfile::tempdir().unwrap();
    let data = repository().join("tests/data/mat");
    for name in ["decay.mat", "clock.mat"] {
        fs::copy(data.join(name), folder.path().join(name)).unwrap();
    }
    let session = "records:\n  - {file: decay.mat, pose: {beta2_rad: 1}, time: stamp_ms}\n";
    fs::write(folder.path().join("s.yaml"), session).unwrap();
    let found = json(&["s.yaml"], folder.path());
    let hz = frequencies(&found, 0);
    assert!(hz.len() == 1 && (hz[0] / 12.0 - 1.0).abs() < 1e-3, "{hz:?}");
    let shape = found["records"][0]["modes"][0]["shape"].as_array().unwrap();
    let parts: Vec<_> = shape.iter().map(|part| part["response"].as_str().unwrap()).collect();
    assert_eq!(parts, ["tip_mm", "elbow_mm"]);
    let told = faults(
        "time: stamp_ms
records:
  - {file: clock.mat, pose: {beta2_rad: 1}, time: stamp}
  - {file: decay.mat, pose: {beta2_rad: 1}, excitation: tip_m}
",
        folder.path(),
    );
    for expected in [
        "s.yaml:3: time 'stamp' is not in file 'clock.mat'; did you mean 'stamp_ms'?",
        "s.yaml:4: excitation 'tip_m' is not in file 'decay.mat'; did you mean 'tip_mm'?",
    ] {
        assert!(told.contains(expected), "{expected}\nin\n{told}");
    }
}

/// Bytes of any kind in place of a record: a fault or a result, never a fault of the program itself.
#[test]
fn garbage_never_ends_in_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = seeded(11);
    let mut names = Vec::new();
    for i in 0..60 {
        let name = format!("g{i}.{}", ["csv", "uff", "wav"][i % 3]);
        let length = 1 << (i / 5);
        let mut bytes: Vec<u8> = match i % 3 {
            0 => b"a,b\n".to_vec(),
            1 => b"    -1\n    58b     1     2          11         400\n".to_vec(),
            _ => b"RIFF\xff\xff\0\0WAVEfmt \x10\0\0\0\x01\0\x02\0".to_vec(),
        };
        bytes.extend((0..length).map(|_| match i % 3 {
            0 => b"0123456789.,-e\n"[rng.random_range(0..15)],
            _ => rng.random::<u8>(),
        }));
        fs::write(folder.path().join(&name), bytes).unwrap();
        names.push(name);
    }
    for name in names {
        let session = format!(
            "sample_rate_hz: 100\nrecords:\n  - {{file: {name}, pose: {{beta2_rad: 1}}}}\n"
        );
        fs::write(folder.path().join("s.yaml"), session).unwrap();
        let output = identify(&["s.yaml"], folder.path());
        let code = output.status.code();
        assert!(matches!(code, Some(0 | 2)), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

const FRAMES_PER_S: f64 = 140.0;
const FRAMES: usize = 700;

/// β1 = 2π/3 and lengths of the links, m: l1 from the paper's Table 1; C lies 0.6 m from B.
const BETA_1: f64 = 2.0 * std::f64::consts::PI / 3.0;
const LENGTHS_M: [f64; 2] = [0.63, 0.6];

/// Pose, measured frequencies of Table 2, and the rotations of both links assumed for them.
const POSES: [(f64, [f64; 2], [[f64; 2]; 2]); 3] = [
    (1.571, [23.195, 39.40], [[1.0, 0.7], [0.4, -1.3]]),
    (0.873, [21.47, 48.90], [[1.0, 0.8], [0.3, -1.2]]),
    (-0.873, [20.11, 52.15], [[1.0, 0.9], [0.3, -1.1]]),
];

fn points_mm(beta_2: f64) -> [[f64; 2]; 2] {
    let b = [LENGTHS_M[0] * BETA_1.cos(), LENGTHS_M[0] * BETA_1.sin()];
    let turned = BETA_1 + beta_2;
    let c = [b[0] + LENGTHS_M[1] * turned.cos(), b[1] + LENGTHS_M[1] * turned.sin()];
    [b.map(mm_from_m), c.map(mm_from_m)]
}

/// Displacements of B and C in mm after a hit half a second into the record, rounded to 10 nm, with noise 20 dB
/// below each.
fn camera_record(index: usize) -> Vec<Vec<f64>> {
    let (beta_2, frequencies, rotations) = POSES[index];
    let [b, c] = points_mm(beta_2);
    let modes: Vec<TrueMode> = (0..2)
        .map(|mode| {
            let [alpha_1, alpha_2] = rotations[mode].map(|alpha| 5e-5 * alpha);
            let at_b = [-alpha_1 * b[1], alpha_1 * b[0]];
            let at_c = [at_b[0] - alpha_2 * (c[1] - b[1]), at_b[1] + alpha_2 * (c[0] - b[0])];
            TrueMode::new(
                frequencies[mode],
                [0.02, 0.015][mode],
                &[at_b[0], at_b[1], at_c[0], at_c[1]],
            )
        })
        .collect();
    let clean = free_decay(&modes, 0, FRAMES_PER_S, FRAMES, 70);
    let round = |v: f64| (v * 1e5).round() / 1e5;
    let noisy = noisy(&clean, 0.1, &mut seeded(100 + index as u64));
    noisy.iter().map(|samples| samples.iter().map(|v| round(*v)).collect()).collect()
}

fn example() -> PathBuf {
    repository().join("robots/two-link")
}

fn example_text(index: usize) -> String {
    let columns = camera_record(index);
    let mut text = String::from(
        "# Synthetic: made by tests/commands/identify.rs, not measured. Displacements of points B and C.\n\
         bx_mm,by_mm,cx_mm,cy_mm\n",
    );
    for row in 0..FRAMES {
        let cells: Vec<String> = columns.iter().map(|c| format!("{:.5}", c[row])).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

#[test]
fn the_example_is_what_its_generator_makes_and_its_modes_come_back() {
    let records: Vec<PathBuf> =
        (1..=3).map(|i| example().join(format!("session/decay-{i}.csv"))).collect();
    for (index, file) in records.iter().enumerate() {
        if std::env::var_os("DETUNE_WRITE_EXAMPLE").is_some() {
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, example_text(index)).unwrap();
        }
        assert_eq!(fs::read_to_string(file).unwrap(), example_text(index), "{}", file.display());
    }
    let found = json(&["robots/two-link/session.yaml"], repository());
    for (index, (beta_2, frequencies, rotations)) in POSES.iter().enumerate() {
        let pose = &found["poses"][index];
        assert_eq!(pose["beta2_rad"].as_f64(), Some(*beta_2));
        assert!((pose["beta1_rad"].as_f64().unwrap() - BETA_1).abs() < 1e-4);
        let modes = found["records"][index]["modes"].as_array().unwrap();
        assert_eq!(modes.len(), 2, "{}", found["records"][index]["notices"]);
        for (mode, (hz, alphas)) in modes.iter().zip(frequencies.iter().zip(rotations)) {
            assert!((mode["frequency_hz"].as_f64().unwrap() / hz - 1.0).abs() < 1e-3);
            let links = mode["links"].as_array().unwrap();
            let expected = if alphas[1] > 0.0 { "together" } else { "against" };
            assert_eq!(links[1]["sense"], expected);
            let size = |link: usize| {
                let parts = &links[link]["rotation_rad"];
                parts[0].as_f64().unwrap().hypot(parts[1].as_f64().unwrap())
            };
            let share = |link: usize| links[link]["std_rad"].as_f64().unwrap() / size(link);
            let error = size(1) / size(0) / (alphas[1] / alphas[0]).abs() - 1.0;
            assert!(error.abs() < 4.0 * share(0).hypot(share(1)), "{error} {mode}");
            assert!(error.abs() < 0.1, "{error}");
        }
    }
}

#[test]
fn the_table_has_one_row_a_pose_and_is_written_whole() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("measured.csv");
    let root = repository();
    let output =
        identify(&["robots/two-link/session.yaml", "--write", table.to_str().unwrap()], root);
    assert!(output.status.success());
    let text = fs::read_to_string(&table).unwrap();
    let rows: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(
        rows[0],
        "beta1_rad,beta2_rad,f1_hz,f1_std_hz,zeta1,f2_hz,f2_std_hz,zeta2,phi1_link_1,phi1_link_1_std,\
         phi1_link_2,phi1_link_2_std,phi2_link_1,phi2_link_1_std,phi2_link_2,phi2_link_2_std,\
         sample_rate_hz,id"
    );
    assert_eq!(rows.len(), 4);
    for (row, (beta_2, frequencies, _)) in rows[1..].iter().zip(POSES) {
        let cells: Vec<&str> = row.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().unwrap();
        assert_eq!((number(1), number(16)), (beta_2, 140.0));
        assert!((number(2) / frequencies[0] - 1.0).abs() < 1e-3, "{row}");
        assert!((number(5) / frequencies[1] - 1.0).abs() < 1e-3, "{row}");
    }
    let again = identify(&["robots/two-link/session.yaml", "--format", "svg"], root);
    let svg = String::from_utf8(again.stdout).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("decay-3.csv") && !svg.contains("NaN"));
    let output = identify(
        &["robots/two-link/session.yaml", "--write", "missing/measured.csv"],
        folder.path().parent().unwrap(),
    );
    assert_eq!(output.status.code(), Some(2));
}

/// Neither a record nor the session is written over, and report and table are two files.
#[test]
fn inputs_are_spared() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("a.csv");
    fs::write(&record, example_text(0)).unwrap();
    let session = "sample_rate_hz: 140\nrecords:\n  - {file: a.csv, pose: {beta2_rad: 1}}\n";
    fs::write(folder.path().join("s.yaml"), session).unwrap();
    for arguments in [
        ["s.yaml", "--write", "a.csv"],
        ["s.yaml", "--output", "a.csv"],
        ["s.yaml", "--write", "s.yaml"],
    ] {
        let output = identify(&arguments, folder.path());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(told.contains("is read by this run"), "{told}");
    }
    let output = identify(&["s.yaml", "--write", "m.csv", "--output", "m.csv"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(!folder.path().join("m.csv").exists());
    assert_eq!(fs::read_to_string(record).unwrap(), example_text(0));
    assert_eq!(fs::read_to_string(folder.path().join("s.yaml")).unwrap(), session);
}

/// Channels go by their titles with or without the unit, in responses, driving point and markers.
#[test]
fn titles_with_units_need_not_be_spelt_out() {
    let folder = tempfile::tempdir().unwrap();
    let text = example_text(0)
        .replace("bx_mm,by_mm,cx_mm,cy_mm", "bx [mm],by [mm],cx [mm],cy [mm]")
        .replace('\n', "\r\n");
    fs::write(folder.path().join("a.csv"), format!("\u{feff}{text}")).unwrap();
    let session = "sample_rate_hz: 140
markers:
  link_1: [{at_mm: [0, 0]}, {at_mm: [-315.0, 545.6], x: bx, y: by}]
  link_2:
    - {at_mm: [-315.0, 545.6], x: bx, y: 'by [mm]'}
    - {at_mm: [-834.6, 245.5], x: cx, y: cy}
records:
  - {file: a.csv, pose: {beta2_rad: 1.571}, responses: [bx, 'by [mm]', cx, cy]}
";
    fs::write(folder.path().join("s.yaml"), session).unwrap();
    let found = json(&["s.yaml"], folder.path());
    let modes = &found["records"][0]["modes"];
    assert_eq!(modes[0]["links"][1]["sense"], "together", "{modes}");
    assert_eq!(modes[1]["links"][1]["sense"], "against", "{modes}");
}

/// The same bytes on two runs, whatever the threads do.
#[test]
fn two_runs_give_the_same_bytes() {
    let root = repository();
    let run = || identify(&["robots/two-link/session.yaml", "--format", "json"], root).stdout;
    assert_eq!(run(), run());
}

/// Noise of the example is 20 dB below its signal.
#[test]
fn the_example_is_as_noisy_as_it_says() {
    let record = camera_record(0);
    let end: Vec<f64> = record[0][650..].to_vec();
    let share = rms(&end) / rms(&record[0]);
    assert!((0.07..0.13).contains(&share), "{share}");
}

/// What identification of ten poses gives, at angles with few digits; a mode near the mains at one of them.
fn identified(pose: impl Fn(f64) -> (Pose, Option<Vec<JointColumn>>)) -> IdentifiedSession {
    let mode = |number: usize, frequency_hz: f64, suspicion: Option<Code>| PoseMode {
        frequency_hz,
        frequency_std_hz: 0.013 * frequency_hz.sqrt(),
        damping_ratio: 0.0217,
        damping_std: 0.001,
        members: Vec::new(),
        number: Some(number).filter(|_| suspicion.is_none()),
        shape: Vec::new(),
        suspicion,
    };
    let at = |i: u32| {
        let beta2 = 0.3 + 0.21 * f64::from(i);
        let suspicion = (i == 4).then_some(Code::Mains);
        let modes = vec![
            mode(1, 19.7 + 3.1 * beta2.sin(), None),
            mode(2, 61.1 - 14.0 * beta2.sin() / 3.0, suspicion),
        ];
        PoseModes {
            pose: pose(beta2).0,
            conditions: Conditions { temperature_c: Some(20.1), ..Conditions::default() },
            id: i.is_multiple_of(2).then(|| format!("p{i},a")),
            sample_rate_hz: Some(400.0),
            modes,
        }
    };
    let poses = (0..10).map(at).collect();
    let joint_columns = pose(1.0).1;
    IdentifiedSession { poses, records: Vec::new(), joint_columns, warnings: Vec::new() }
}

/// From identification to diagnosis with and without a file between them: the same table to the last digit,
/// which is all that a diagnosis is made of; and a session whose joints are not the robot's is refused either way.
#[test]
fn a_table_in_memory_is_the_table_that_is_written() {
    let robot_file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/two-link/robot.yaml");
    let described = read_described_robot(&robot_file, &mut Reading::default()).unwrap();
    let robot = &described.robot;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("measured.csv");
    let joints = |names: [&str; 2]| {
        let columns = names.map(JointColumn::of);
        move |beta2: f64| {
            let degrees = [-3.3 * beta2, (beta2 * 573.0).round() / 10.0];
            let si = |i: usize| columns[i].si_from_degrees_or_mm(degrees[i]);
            (Pose::Joints(vec![si(0), si(1)]), Some(columns.to_vec()))
        }
    };
    let sessions = [
        identified(|beta2| (Pose::Angles { beta1: None, beta2 }, None)),
        identified(joints(["joint_1", "joint_2"])),
        identified(joints(["joint_1_rad", "joint_2"])),
        identified(|beta2| (Pose::Angles { beta1: Some(-3.3 * beta2), beta2 }, None)),
    ];
    for (index, session) in sessions.iter().enumerate() {
        let (table, warnings) = table_on(robot, session).unwrap();
        // The first does not say where joint_1 stood.
        let unstated: &[&str] = if index == 0 { &["joint_1"] } else { &[] };
        assert_eq!(table.unstated, unstated);
        assert_eq!(warnings.len(), unstated.len(), "{warnings:?}");
        fs::write(&file, measured_csv(session)).unwrap();
        let written = read_measured(&file, robot, &mut Reading::default()).unwrap();
        assert_eq!(table, written);
        assert_eq!((table.rows.len(), table.count()), (10, 19));
    }
    let stranger = identified(joints(["joint_1", "elbow"]));
    let error = table_on(robot, &stranger).unwrap_err();
    assert!(error[0].to_string().contains("no column 'joint_2_rad'"), "{error:?}");
}
