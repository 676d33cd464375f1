//! Corrections of a robot file: what they do to strain energy, and what they refuse.

use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{code, err, json, out, repository, run};

/// A copy of a robot with corrections, one a line.
fn robot(folder: &Path, of: &str, corrections: &[&str]) -> PathBuf {
    let own = repository().join("robots").join(of);
    let text = fs::read_to_string(&own).unwrap();
    let urdf = text.lines().find_map(|line| line.strip_prefix("urdf: ")).unwrap().trim();
    let whole = own.parent().unwrap().join(urdf).display().to_string();
    let text = text.replacen(&format!("urdf: {urdf}"), &format!("urdf: {whole}"), 1);
    let mut text = format!("{text}\ncorrections:\n");
    corrections.iter().for_each(|line| text += &format!("  - {line}\n"));
    let file = folder.join("robot.yaml");
    fs::write(&file, text).unwrap();
    file
}

/// The cells of `map --shapes` whose names start with a word, pose by pose.
fn map(corrections: &[&str], words: &[&str]) -> Vec<Vec<f64>> {
    let folder = tempfile::tempdir().unwrap();
    robot(folder.path(), "irb1600/planar.yaml", corrections);
    let poses = ["--joint", "joint_3", "--from-deg", "-60", "--to-deg", "60", "--steps", "7"];
    let arguments = [&["map", "robot.yaml", "--shapes"][..], &poses].concat();
    let ran = run(folder.path(), &arguments);
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    let mut lines = out(&ran).lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let is_wanted = |name: &str| words.iter().any(|word| name.starts_with(word));
    let wanted: Vec<usize> = (0..names.len()).filter(|&i| is_wanted(names[i])).collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        wanted.iter().map(|&i| cells[i].parse().unwrap()).collect()
    };
    lines.map(row).collect()
}

const SOFT: &str =
    "{cause: joint_stiffness, at: joint_2, parameters: {stiffness_nm_per_rad: 111000}}";
const LAWS: [&str; 3] = [
    "{cause: position_dependent_stiffness, at: joint_2, parameters: {factor: 0.2}}",
    "{cause: temperature_drift, at: joint_2, parameters: {change_per_k: 0, factor: 0.2}}",
    "{cause: load_dependent_stiffness, at: joint_2, parameters: {change_per_nm: 0, factor: 0.2}}",
];

/// 111000 N·m/rad is a fifth of the file's 555000: the arm is the same, however it is told.
#[test]
fn a_law_that_is_a_constant_leaves_frequencies_and_shares_of_that_constant() {
    let of = |correction: &str| map(&[correction], &["f1", "f2", "strain"]);
    let plain = of(SOFT);
    assert_eq!((plain.len(), plain[0].len()), (7, 6));
    for law in LAWS {
        for (row, expected) in of(law).iter().zip(&plain) {
            for (value, expected) in row.iter().zip(expected) {
                assert!((value / expected - 1.0).abs() < 1e-9, "{law}: {row:?} {expected:?}");
            }
        }
    }
}

/// A part that the arm does not feel adds its frequency to the arm's; one on a spring without end is
/// a mass on the link.
#[test]
fn a_local_mode_is_the_parts_frequency_or_its_mass() {
    let frequencies = |corrections: &[&str]| map(corrections, &["f1_hz", "f2_hz", "f3_hz"]);
    let plain = frequencies(&[SOFT]);
    let light = "{cause: local_mode, parameters: {frequency_hz: 12.5}}";
    let both = frequencies(&[SOFT, light]);
    assert_eq!((both.len(), both[0].len(), plain[0].len()), (7, 3, 2));
    for (found, plain) in both.iter().zip(&plain) {
        let mut expected = [plain.clone(), vec![12.5]].concat();
        expected.sort_by(f64::total_cmp);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found / expected - 1.0).abs() < 1e-3, "{found:?}, must be {expected:?}");
        }
    }
    // Held without end, a part of the link's own mass changes nothing.
    let own = "{cause: local_mode, at: link_3, parameters: {frequency_hz: 1e6, mass_kg: 2}, \
               axes: [[0, 0, 1]], origin_m: [0.1, 0, 0.05], carries: part}";
    for (found, expected) in frequencies(&[SOFT, own]).iter().zip(&plain) {
        assert_eq!((found.len(), expected.len()), (3, 2));
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found:?}, must be {expected:?}");
        }
    }
    let rigid = "{cause: local_mode, at: tool0, parameters: {frequency_hz: 1e6, mass_kg: 6}, \
                 kind: translation, axes: [[1, 0, 0]], origin_m: [0.1, 0, 0.2]}";
    let mass = "{cause: payload, at: tool0, parameters: {mass_kg: 6, com_x_m: 0.1, com_z_m: 0.2}}";
    for (found, expected) in frequencies(&[rigid]).iter().zip(&frequencies(&[mass])) {
        assert_eq!((found.len(), expected.len()), (3, 2));
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found:?}, must be {expected:?}");
        }
    }
    // Two parts may hang on one link.
    let two = [rigid, &rigid.replace("1e6", "9e5").replace("mass_kg: 6", "mass_kg: 3")];
    let nine = mass.replace("mass_kg: 6", "mass_kg: 9");
    for (found, expected) in frequencies(&two).iter().zip(&frequencies(&[&nine])) {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found:?}, must be {expected:?}");
        }
    }
}

/// A part too light for the arm to feel it moves no tool tip in the model: nobody knows what it does to the cut.
#[test]
fn a_line_on_a_local_mode_is_not_clear_and_a_heavy_part_may_be_in_the_payload() {
    let check = |corrections: &[&str], payload: &str| {
        let folder = tempfile::tempdir().unwrap();
        robot(folder.path(), "irb1600/planar.yaml", corrections);
        let job = format!(
            "robot: robot.yaml
tcp: {{xyz_m: [0, 0, 0.1]}}
tool: {{teeth: 2, payload: {payload}}}
spindle: {{min_rpm: 200, max_rpm: 6000}}
operations:
  - name: rough
    spindle_rpm: 3900
    feed_mm_per_min: 400
    path: {{joints_deg: [[0, 0, 30, 0, 0, 0], [0, 0, 60, 0, 0, 0]]}}
policy: {{tooth_passing_harmonics: 1, spindle_harmonics: 0, model_uncertainty_percent: 1}}
"
        );
        fs::write(folder.path().join("job.yaml"), job).unwrap();
        let ran = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
        let verdict = json(&ran)["jobs"][0]["operations"][0]["verdict"].clone();
        (verdict.as_str().unwrap().to_owned(), err(&ran).to_owned())
    };
    let verdict = |corrections: &[&str]| check(corrections, "none").0;
    assert_eq!(verdict(&["{cause: local_mode, parameters: {frequency_hz: 160}}"]), "clear");
    let one = "{cause: local_mode, parameters: {frequency_hz: 130}}";
    assert_eq!(verdict(&[one]), "resonance");
    // Of a part behind the first arm's joint the tool tip feels next to nothing, and its mass is a guess.
    let inside = "{cause: local_mode, at: link_2, parameters: {frequency_hz: 130, mass_kg: 0.01}, axes: [[0, 0, 1]]}";
    assert_eq!(verdict(&[inside]), "resonance");
    // Two on one link have names of their own.
    let other = "{cause: local_mode, parameters: {frequency_hz: 145}}";
    assert_eq!(verdict(&[one, other]), "resonance");
    let heavy = "{cause: local_mode, at: tool0, parameters: {frequency_hz: 160, mass_kg: 2}, axes: [[0, 0, 1]]}";
    let (verdict, doubts) = check(&[heavy], "{mass_kg: 9, com_m: [0, 0, 0.1]}");
    assert_eq!(verdict, "uncertain");
    assert!(doubts.contains("stands beside the 2 kg"), "{doubts}");
}

/// A coupled spring holds the energy of both deflections.
#[test]
fn shares_add_up_to_one() {
    let coupled = "{cause: joint_coupling, at: joint_3, parameters: {ratio: 0.6}}";
    for corrections in [vec![SOFT], vec![LAWS[0], coupled], vec![coupled]] {
        for mode in ["strain1", "strain2"] {
            for row in map(&corrections, &[mode]) {
                assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{corrections:?}: {row:?}");
            }
        }
    }
}

/// What moves at a resonance is told of the arm as the laws leave it.
#[test]
fn what_moves_at_a_crossing_follows_the_laws() {
    let moves = |correction: &str| {
        let folder = tempfile::tempdir().unwrap();
        robot(folder.path(), "irb1600/planar.yaml", &[correction]);
        let job = "robot: robot.yaml
tool: {teeth: 2, payload: none}
spindle: {min_rpm: 200, max_rpm: 6000}
operations:
  - name: rough
    spindle_rpm: 390
    feed_mm_per_min: 400
    path: {joints_deg: [[0, 0, -60, 0, 0, 0], [0, 0, 60, 0, 0, 0]]}
policy: {tooth_passing_harmonics: 6, spindle_harmonics: 0}
";
        fs::write(folder.path().join("job.yaml"), job).unwrap();
        let ran = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
        let crossings = json(&ran)["jobs"][0]["operations"][0]["crossings"].clone();
        let own: Vec<(String, f64)> = crossings
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|crossing| crossing["moves"].as_array().unwrap().clone())
            .map(|one| {
                let text = one.to_string();
                (text, one["share"].as_f64().unwrap())
            })
            .collect();
        assert!(!own.is_empty(), "{}", out(&ran));
        own
    };
    let plain = moves(SOFT);
    for law in LAWS {
        let own = moves(law);
        assert_eq!(own.len(), plain.len());
        for ((told, share), (_, expected)) in own.iter().zip(&plain) {
            assert!((share - expected).abs() < 1e-6 * expected.abs(), "{law}: {told} {expected}");
        }
    }
}

/// Robot, correction, what is said.
#[rustfmt::skip]
const REFUSED: [(&str, &str, &str); 36] = [
    // Units that are not the joint's.
    ("irb1600/planar.yaml", "{cause: joint_stiffness, at: joint_2, parameters: {stiffness_n_per_m: 1000}}", "stiffness_n_per_m is 1000, must be stiffness_nm_per_rad, as joint 'joint_2' turns"),
    ("rail-mill/robot.yaml", "{cause: joint_stiffness, at: track, parameters: {stiffness_nm_per_rad: 1000}}", "stiffness_nm_per_rad is 1000, must be stiffness_n_per_m, as joint 'track' is prismatic"),
    ("irb1600/planar.yaml", "{cause: joint_zero_offset, at: joint_2, parameters: {offset_m: 0.1}}", "offset_m is 0.1, must be offset_rad, as joint 'joint_2' turns"),
    ("rail-mill/robot.yaml", "{cause: joint_zero_offset, at: track, parameters: {offset_rad: 0.1}}", "offset_rad is 0.1, must be offset_m, as joint 'track' is prismatic"),
    ("rail-mill/robot.yaml", "{cause: position_dependent_stiffness, at: track, parameters: {cos_1: 0.1}}", "at is 'track', must be a joint that turns, as the law is a wave of its angle"),
    ("rail-mill/robot.yaml", "{cause: position_dependent_stiffness, at: all, parameters: {cos_1: 0.1}}", "at is 'all', must be a joint that turns"),
    ("rail-mill/robot.yaml", "{cause: load_dependent_stiffness, at: track, parameters: {change_per_nm: 0.1}}", "at is 'track', must be a joint that turns, as the law is of a torque"),
    // Values that no spring has.
    ("irb1600/planar.yaml", "{cause: position_dependent_stiffness, at: joint_2, parameters: {factor: -1}}", "factor is -1, must be positive"),
    ("irb1600/planar.yaml", "{cause: temperature_drift, at: joint_2, parameters: {change_per_k: 0, factor: -3}}", "factor is -3, must be positive"),
    ("irb1600/planar.yaml", "{cause: amplitude_dependence, at: joint_2, parameters: {exponent: 0.1, factor: 0}}", "factor is 0, must be positive"),
    ("irb1600/planar.yaml", "{cause: amplitude_dependence, at: joint_2, parameters: {exponent: 0.1, reference_nm: 0}}", "reference_nm is 0, must be positive"),
    ("irb1600/planar.yaml", "{cause: joint_stiffness, at: all, parameters: {factor: -2}}", "factor is -2, must be positive"),
    ("irb1600/planar.yaml", "{cause: position_dependent_stiffness, at: joint_2, parameters: {}}", "has no parameters, must have one of cos_1, sin_1"),
    ("irb1600/planar.yaml", "{cause: position_dependent_stiffness, at: joint_2}", "has no parameters, must have one of cos_1, sin_1"),
    ("irb1600/planar.yaml", "{cause: load_dependent_stiffness, at: joint_2, parameters: {torque_1_nm: 5, torque_2_nm: 3}}", "torque_2_nm is 3, must be above torque_1_nm, 5"),
    ("irb1600/planar.yaml", "{cause: load_dependent_stiffness, at: joint_2, parameters: {torque_1_nm: 5, torque_2_nm: 8, ratio_3: -1}}", "ratio_3 is -1, must be positive"),
    ("irb1600/planar.yaml", "{cause: load_dependent_stiffness, at: joint_2, parameters: {change_per_nm: 0.001, saturation_nm: -1}}", "saturation_nm is -1, must be positive"),
    ("irb1600/planar.yaml", "{cause: drive_inertia, at: joint_2, parameters: {reflected_inertia_kgm2: -1}}", "reflected_inertia_kgm2 is -1, must not be negative"),
    ("irb1600/planar.yaml", "{cause: missed_mode, at: '1', parameters: {share: 2}}", "share is 2, must be from 0 to 1"),
    ("irb1600/planar.yaml", "{cause: local_mode, parameters: {frequency_hz: 0}}", "frequency_hz is 0, must be positive"),
    ("irb1600/planar.yaml", "{cause: local_mode, at: tool0, parameters: {frequency_hz: 12, mass_kg: -1}, kind: translation, axes: [[1, 0, 0]]}", "mass_kg is -1, must be positive"),
    ("irb1600/planar.yaml", "{cause: local_mode, at: tool0, parameters: {frequency_hz: 12, mass_kg: 1}, kind: rotation, axes: [[1, 0, 0]]}", "kind is rotation, must be translation"),
    ("irb1600/planar.yaml", "{cause: local_mode, at: link_3, parameters: {frequency_hz: 12, mass_kg: 1}, axes: [[1, 0, 0]], carries: rest}", "carries is rest, must be link"),
    ("irb1600/planar.yaml", "{cause: local_mode, at: link_3, parameters: {frequency_hz: 12, mass_kg: 1000}, axes: [[1, 0, 0]], carries: part}", "mass_kg is 1000, must be less than that of 'link_3'"),
    ("irb1600/planar.yaml", "{cause: local_mode, parameters: {frequency_hz: 12, mass_kg: 1}}", "mass_kg is 1, must be absent without 'at'"),
    ("irb1600/planar.yaml", "{cause: local_mode, at: tool0, parameters: {frequency_hz: 12}}", "parameter 'mass_kg' is missing"),
    ("irb1600/planar.yaml", "{cause: local_mode, at: tool0, parameters: {frequency_hz: 12, mass_kg: 1}}", "axes are missing"),
    ("irb1600/planar.yaml", "{cause: local_mode, at: tool0, parameters: {frequency_hz: 12, mass_kg: 1}, axes: []}", "axes is empty, must have one or more"),
    // Places without an effect.
    ("irb1600/planar.yaml", "{cause: joint_coupling, at: joint_2, parameters: {ratio: 0.5}}", "at is 'joint_2', must be one elastic joint with another before it"),
    ("irb1600/planar.yaml", "{cause: joint_coupling, at: all, parameters: {ratio: 0.5}}", "at is 'all', must be one elastic joint with another before it"),
    ("irb1600/planar.yaml", "{cause: aliased_mode, at: xyz}", "at is 'xyz', must be the number of a mode, from 1 to 2"),
    ("irb1600/planar.yaml", "{cause: missed_mode, at: '3'}", "at is '3', must be the number of a mode, from 1 to 2"),
    ("irb1600/planar.yaml", "{cause: gravity_stiffness, at: joint_9}", "at is 'joint_9', must be absent"),
    // What is missing, with all that would do.
    ("irb1600/planar.yaml", "{cause: joint_stiffness, at: joint_2, parameters: {ratio_1: 2}}", "parameter 'stiffness_nm_per_rad' or 'factor' is missing"),
    ("rail-mill/robot.yaml", "{cause: joint_stiffness, at: track, parameters: {ratio_1: 2}}", "parameter 'stiffness_n_per_m' or 'factor' is missing"),
    ("irb1600/planar.yaml", "{cause: joint_stiffness, at: all, parameters: {ratio_1: 2}}", "parameter 'factor' is missing"),
];

#[test]
fn corrections_without_sense_are_errors_at_their_lines() {
    let mut wrong = Vec::new();
    for (of, correction, says) in REFUSED {
        let folder = tempfile::tempdir().unwrap();
        let good = "{cause: drive_inertia, at: joint_3, parameters: {reflected_inertia_kgm2: 1}}";
        let file = robot(folder.path(), of, &[good, correction]);
        let text = fs::read_to_string(file).unwrap();
        let ran = run(folder.path(), &["map", "robot.yaml", "--random", "1"]);
        let expected = format!("robot.yaml:{}: correction 2: {says}", text.lines().count());
        if code(&ran) != 2 || !err(&ran).contains(&expected) {
            wrong.push(format!("{correction}: {expected}\n  but {}", err(&ran)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A parameter that stands on a line of its own is named there.
#[test]
fn a_parameter_is_named_at_its_own_line() {
    let folder = tempfile::tempdir().unwrap();
    let correction = "cause: temperature_drift
    at: joint_2
    parameters:
      change_per_k: -0.001
      factor: -3
    note: by hand";
    let text = fs::read_to_string(robot(folder.path(), "irb1600/planar.yaml", &[correction]));
    let line = 1 + text.unwrap().lines().position(|line| line.contains("factor: -3")).unwrap();
    let ran = run(folder.path(), &["map", "robot.yaml", "--random", "1"]);
    assert!(
        err(&ran).contains(&format!("robot.yaml:{line}: correction 1: factor")),
        "{}",
        err(&ran)
    );
}

/// Of either sign, and in every form that a diagnosis may write.
#[test]
fn corrections_that_a_diagnosis_may_write_are_read() {
    for correction in [
        "{cause: temperature_drift, at: all, parameters: {change_per_k: -0.003, factor: 0.95, reference_c: 31}}",
        "{cause: temperature_drift, at: joint_2, parameters: {change_per_k: 0.003}}",
        "{cause: amplitude_dependence, at: joint_2, parameters: {change_per_nm: -0.002, factor: 0.9, reference_nm: 12}}",
        "{cause: amplitude_dependence, at: joint_2, parameters: {exponent: -0.1, factor: 1.1, reference_nm: 12}}",
        "{cause: load_dependent_stiffness, at: joint_2, parameters: {change_per_nm: -0.0004, saturation_nm: 300, factor: 0.8, reference_nm: 90}}",
        "{cause: load_dependent_stiffness, at: joint_2, parameters: {torque_1_nm: 40, torque_2_nm: 300}}",
        "{cause: position_dependent_stiffness, at: joint_2, parameters: {sin_3: -0.2}}",
        "{cause: joint_zero_offset, at: joint_2, parameters: {offset_rad: -0.1}}",
        "{cause: payload, at: tool0, parameters: {mass_kg: -2}}",
        "{cause: joint_coupling, at: joint_3, parameters: {ratio: -1}}",
        "{cause: aliased_mode, at: '2'}",
        "{cause: missed_mode, at: '1'}",
        "{cause: gravity_stiffness}",
    ] {
        let folder = tempfile::tempdir().unwrap();
        robot(folder.path(), "irb1600/planar.yaml", &[correction]);
        let ran = run(folder.path(), &["map", "robot.yaml", "--random", "1"]);
        assert_eq!(code(&ran), 0, "{correction}: {}", err(&ran));
    }
}
