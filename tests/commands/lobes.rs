//! `detune lobes` as a user runs it.

use std::fs;
use std::process::Output;

use crate::program::{repository, run};

fn lobes(arguments: &str) -> Output {
    let arguments: Vec<&str> =
        std::iter::once("lobes").chain(arguments.split_whitespace()).collect();
    run(repository(), &arguments)
}

fn told(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const MODES: &str = "\
modes: [{frequency_hz: 922, damping_ratio: 0.011, mass_kg: 0.03993, axis: [1, 0, 0]}]
tool: {teeth: 2, diameter_mm: 12}
cutting: {radial_depth_mm: 12, direction: slot, coefficients: {ktc_n_per_mm2: 600, krc_n_per_mm2: 200}}
";

/// Lobes of a text, and what is on standard error without the file's name.
fn of(text: &str, options: &str) -> (Option<i32>, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("modes.yaml");
    fs::write(&file, text).unwrap();
    let ran = lobes(&format!("{} {options}", file.display()));
    let said = told(&ran.stderr).replace(&format!("{}:", file.display()), "");
    (ran.status.code(), told(&ran.stdout), said)
}

/// The radius from issue 18; the limit lies where the radius is 1.
#[test]
fn a_file_of_modes_stands_for_itself() {
    let (code, text, said) = of(MODES, "--rpm 5000:6000:2 --depth-mm 0.5");
    assert_eq!(code, Some(0), "{said}");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0], ["rpm", "depth_mm", "spectral_radius"]);
    assert_eq!((rows.len(), rows[1][0], rows[1][1]), (3, "5000", "0.5"));
    let radius: f64 = rows[1][2].parse().unwrap();
    assert!((radius - 1.0739755867).abs() < 1e-9);
    assert!(said.contains("no axial coefficient"), "{said}");

    let (_, text, _) = of(MODES, "--rpm 5000:5000:1");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0], ["rpm", "limit_mm", "frequency_hz", "kind"]);
    assert_eq!(rows[1][3], "hopf");
    let (_, text, _) = of(MODES, &format!("--rpm 5000:5000:1 --depth-mm {}", rows[1][1]));
    let radius: f64 = text.trim().rsplit(',').next().unwrap().parse().unwrap();
    assert!((radius - 1.0).abs() < 1e-8, "{radius}");
}

#[test]
fn where_nothing_chatters_cells_are_blank_and_json_says_null() {
    let stiff = MODES.replace("mass_kg: 0.03993", "mass_kg: 39930000");
    for method in ["exact", "zeroth"] {
        let (code, text, _) = of(&stiff, &format!("--rpm 5000:5000:1 --method {method}"));
        assert_eq!((code, text.as_str()), (Some(0), "rpm,limit_mm,frequency_hz,kind\n5000,,,\n"));
    }
    let (_, text, _) = of(&stiff, "--rpm 5000:5000:1 --format json");
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["schema"], "lobes/1");
    assert!(json["rows"]["limits"][0]["limit"].is_null());
    let (_, text, _) = of(MODES, "--rpm 2000:20000:40 --method zeroth --format svg");
    assert!(text.starts_with("<svg") && text.contains("axial depth [mm]"));
}

/// Half immersion with modes along the spindle and at 45° to the feed: the change of the cut over the turn
/// decides, which the zeroth order takes for its mean.
#[test]
fn where_the_zeroth_order_is_misled_it_says_so() {
    let text = "modes:\n  - {frequency_hz: 800, damping_ratio: 0.03, stiffness_n_per_m: 5.0e6, \
                axis: [0, 0, 1]}\n  - {frequency_hz: 700, damping_ratio: 0.03, stiffness_n_per_m: \
                8.0e6, axis: [1, 1, 0]}\ntool: {teeth: 2, diameter_mm: 8}\n\
                cutting: {direction: climb, material: al-7075, radial_depth_mm: 4}\n";
    let limits = |method: &str| -> (Vec<[f64; 2]>, String) {
        let (_, rows, said) = of(text, &format!("--rpm 8000:24000:9 --method {method}"));
        let row = |row: &str| {
            let mut cells = row.split(',').map(|cell| cell.parse().unwrap());
            [cells.next().unwrap(), cells.next().unwrap()]
        };
        let rows = rows.lines().skip(1).map(|line| row(line.rsplitn(3, ',').nth(2).unwrap()));
        (rows.collect(), said)
    };
    let ((zeroth, said), (exact, nothing)) = (limits("zeroth"), limits("exact"));
    assert!(!nothing.contains("misled"), "{nothing}");
    let both = zeroth.iter().zip(&exact);
    let (a, b) = both.min_by(|(a, b), (c, d)| (b[1] / a[1]).total_cmp(&(d[1] / c[1]))).unwrap();
    let told =
        format!("at {} rpm the exact limit is {:.4} mm, its own is {:.4} mm", a[0], b[1], a[1]);
    assert!(b[1] < 0.5 * a[1] && said.contains(&told), "{told}\n{said}");
    // A slot with four teeth is even.
    let even = text.replace("teeth: 2", "teeth: 4").replace("climb", "slot");
    let (_, _, said) = of(&even, "--rpm 8000:24000:9 --method zeroth");
    assert!(!said.contains("misled"), "{said}");
}

/// At 41.35° the mean of this cut lets the mode feel nothing of the chip that it makes, so the zeroth order
/// knows no limit; the change over the turn makes it grow all the same.
#[test]
fn a_cut_grows_where_its_mean_lets_nothing_grow() {
    for (helix, angle) in [(10.6747, 0.7217664_f64), (11.3684, 0.7218664), (9.9779, 0.7216664)] {
        let (cos, sin) = (angle.cos(), angle.sin());
        let text = format!(
            "modes:\n  - {{frequency_hz: 700, damping_ratio: 0.03, stiffness_n_per_m: 5.0e6, axis: \
             [{cos}, {sin}, 0]}}\ntool: {{teeth: 2, diameter_mm: 8, helix_deg: {helix}}}\n\
             cutting: {{direction: climb, material: al-7075, radial_depth_mm: 4}}\n"
        );
        for rpm in [6000, 9000] {
            let (_, rows, _) = of(&text, &format!("--rpm {rpm}:{rpm}:1"));
            let limit: f64 =
                rows.lines().nth(1).unwrap().split(',').nth(1).unwrap().parse().unwrap();
            for (share, grows) in [(0.999, false), (0.5, false), (1.001, true)] {
                let depth = share * limit;
                let (_, row, _) = of(&text, &format!("--rpm {rpm}:{rpm}:1 --depth-mm {depth}"));
                let radius: f64 = row.trim().rsplit(',').next().unwrap().parse().unwrap();
                assert_eq!(radius > 1.0, grows, "{rpm} rpm, {depth} mm: {radius}");
            }
            assert!(limit < 15.0, "{helix}° {rpm} rpm: {limit} mm");
        }
    }
}

fn text_of_fresh() -> String {
    MODES.replace("direction: slot", "direction: slot, regeneration: false").replace(
        "[1, 0, 0]}]",
        "[1, 0, 0]}, {frequency_hz: 922, damping_ratio: 0.011, mass_kg: 0.03993, axis: [0, 1, 0]}]",
    )
}

/// Without regeneration the speed does not matter, and the kind says why.
#[test]
fn fresh_material_leaves_coupling_alone() {
    let (code, text, said) = of(&text_of_fresh(), "--rpm 1000:9000:2");
    assert_eq!(code, Some(0), "{said}");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[1][3], "coupling");
    assert_eq!(rows[1][1..], rows[2][1..]);
    // What it meets is the mean; it has no growth over a tooth period.
    let (_, json, _) = of(&text_of_fresh(), "--rpm 1000:9000:2 --format json");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["method"], "zeroth");
    let (code, out, said) = of(&text_of_fresh(), "--rpm 1000:9000:2 --depth-mm 0.5");
    assert_eq!((code, out.as_str()), (Some(2), ""), "{said}");
    assert!(said.contains("--depth-mm: ") && said.contains("cutting.regeneration"), "{said}");
}

#[test]
fn faults_have_file_line_and_key() {
    for (from, to, expected) in [
        ("mass_kg: 0.03993", "mass: 1", "1: "),
        ("mass_kg: 0.03993, ", "", "1: modes[0] has neither of mass_kg and stiffness_n_per_m"),
        ("damping_ratio: 0.011", "damping_ratio: 1", "1: mode 1: damping_ratio is 1, must be"),
        ("axis: [1, 0, 0]", "axis: [0, 0, 0]", "1: modes[0].axis is [0, 0, 0]"),
        ("slot", "climb", ""),
        (
            "radial_depth_mm: 12, direction: slot",
            "direction: climb",
            "3: cutting has no 'radial_depth_mm'",
        ),
        ("diameter_mm: 12", "diameter_mm: 10", "3: cutting.radial_depth_mm is 12"),
        (
            ", coefficients: {ktc_n_per_mm2: 600, krc_n_per_mm2: 200}",
            ", material: oak",
            "cutting.material is 'oak'",
        ),
        (", coefficients: {ktc_n_per_mm2: 600, krc_n_per_mm2: 200}", "", "3: cutting has neither"),
        ("ktc_n_per_mm2: 600, ", "", "3: "),
    ] {
        let (code, out, said) = of(&MODES.replace(from, to), "--rpm 5000:5000:1");
        if expected.is_empty() {
            assert_eq!(code, Some(0), "{said}");
            continue;
        }
        assert_eq!((code, out.as_str()), (Some(2), ""), "{to}: {said}");
        assert!(said.contains(expected), "{to}: {said}");
    }
    for options in ["--rpm 0:5:2", "--rpm 5", "--rpm 1:2:0", "--rpm 1:2:2 --depth-mm -1"] {
        let (code, _, said) = of(MODES, options);
        assert_eq!(code, Some(2), "{options}: {said}");
    }
    for (options, expected) in [
        ("--rpm 5000:5000:1 --at 0.5", "--at: is for jobs"),
        ("--rpm 5000:5000:1 --operation rough", "--operation: is for jobs"),
        // A tooth period of thirty seconds.
        ("--rpm 1:1:1", "the exact method finds no growth at 1 rpm"),
        ("--rpm 1:1:1 --depth-mm 0.5", "the exact method finds no growth at 1 rpm"),
    ] {
        let (code, out, said) = of(MODES, options);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{options}: {said}");
        assert!(said.contains(expected), "{options}: {said}");
    }
    let (code, out, said) = of(MODES, "--rpm 1:1:1 --method zeroth");
    assert_eq!(code, Some(0), "{said}");
    let limit_mm: f64 = out.lines().last().unwrap().split(',').nth(1).unwrap().parse().unwrap();
    assert!(limit_mm > 0.0);
}

/// The repository's job has no modes of the tool: the arm's modes alone are told as that.
#[test]
fn a_job_stands_for_its_arm_and_says_so() {
    let job = "jobs/pocket.yaml --rpm 300:3000:4";
    let ran = lobes(&format!("{job} --at 0.5 --method zeroth"));
    assert_eq!(ran.status.code(), Some(0), "{}", told(&ran.stderr));
    assert!(told(&ran.stderr).contains("the arm's modes alone"), "{}", told(&ran.stderr));
    assert_eq!(told(&ran.stdout).lines().count(), 5);
    let ran = lobes(&format!("{job} --at 1.5"));
    assert_eq!(ran.status.code(), Some(2));
    assert!(told(&ran.stderr).contains("--at: is 1.5, must lie between 0 and 1"));
    let ran = lobes(&format!("{job} --operation finish"));
    assert_eq!(ran.status.code(), Some(2));
    assert!(told(&ran.stderr).contains("no 'cutting'"), "{}", told(&ran.stderr));
}

/// The slower, the more the flank rubs; it needs a cutting speed, and a cut that regenerates.
#[test]
fn process_damping_raises_limits_and_needs_a_diameter() {
    let both = MODES.replace(
        "axis: [1, 0, 0]}]",
        "axis: [1, 0, 0]}, {frequency_hz: 922, damping_ratio: 0.011, mass_kg: 0.03993, axis: [0, 1, 0]}]",
    );
    let damped = both.replace("direction: slot", "direction: slot, process_damping_n_per_mm: 200");
    let limit = |text: &str, options: &str| -> f64 {
        let (code, out, said) = of(text, options);
        assert_eq!(code, Some(0), "{said}");
        out.lines().last().unwrap().split(',').nth(1).unwrap().parse().unwrap()
    };
    for method in ["exact", "zeroth"] {
        let rise = |rpm: &str| {
            let options = format!("--rpm {rpm}:{rpm}:1 --method {method}");
            limit(&damped, &options) / limit(&both, &options)
        };
        let (slow, fast) = (rise("2000"), rise("11000"));
        assert!(slow > 1.5 * fast && fast >= 1.0, "{method}: {slow} {fast}");
    }
    let text = damped.replace(", diameter_mm: 12", "").replace("radial_depth_mm: 12, ", "");
    let (code, _, said) = of(&text, "--rpm 5000:5000:1");
    let what = "cutting.process_damping_n_per_mm needs tool.diameter_mm";
    assert!(code == Some(2) && said.contains(what), "{said}");
    let fresh = damped.replace("direction: slot", "direction: slot, regeneration: false");
    let (_, _, said) = of(&fresh, "--rpm 5000:5000:1");
    assert!(said.contains("process_damping_n_per_mm has no effect"), "{said}");
}
