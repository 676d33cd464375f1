//! `detune map` over many poses: grids, figures against a plain scan, threads, pipes and memory.

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use crate::map_command::{command, fed, map, result};

const ARM: &str = "robots/two-link";

/// The columns of a map but for its header.
fn columns(text: &str) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    (0..rows[0].len()).map(|j| rows.iter().map(|row| row[j]).collect()).collect()
}

#[test]
fn a_grid_is_all_combinations_the_last_joint_fastest() {
    let grid = map(&format!("{ARM} --grid joint_1=-10:10:3 --grid joint_2=90:30:2")).unwrap();
    let single = |joint_1: f64| {
        map(&format!(
            "{ARM} --joint joint_2 --from-deg 90 --to-deg 30 --steps 2 --at joint_1={joint_1}"
        ))
        .unwrap()
    };
    let rows = |text: &str| text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    let expected: Vec<String> = [-10.0, 0.0, 10.0].iter().flat_map(|&q| rows(&single(q))).collect();
    assert_eq!(rows(&grid), expected);
    // One joint's grid is that joint's sweep.
    let one = map(&format!("{ARM} --grid joint_2=90:30:2 --at joint_1=-10")).unwrap();
    assert_eq!(one, single(-10.0));
}

#[test]
fn options_of_grids_are_checked() {
    for (options, expected) in [
        ("--grid joint_2=0:1:2 --grid joint_2=0:1:2", "--grid: joint 'joint_2' is given twice"),
        (
            "--grid joint_2=0:1:2 --at joint_2=4",
            "--at: joint 'joint_2' is swept and cannot be fixed as well",
        ),
        ("--grid joint2=0:1:2", "--grid: the robot has no moving joint 'joint2'; did you mean"),
        ("--grid joint_2=0:1", "must be NAME=FROM:TO:STEPS"),
        ("--grid joint_2=0:1:0", "'0' is not a number of steps"),
        ("--grid joint_2=0:nan:3", "'nan' is not a finite number"),
        ("--grid joint_2=0:1:2 --random 5", "cannot be used with"),
        ("--random 5 --joint joint_2", "cannot be used with"),
        ("--joint joint_2 --from-deg 0 --to-deg 1 --steps 2 --seed 4", "cannot be used"),
        ("--random 5 --from-deg 3", "cannot be used with"),
        ("", "required"),
        (
            "--grid joint_1=0:1:18446744073709551615 --grid joint_2=0:1:2",
            "--grid: the poses are too many to count",
        ),
    ] {
        let faults = map(&format!("{ARM} {options}")).unwrap_err().join(" ");
        assert!(faults.contains(expected), "{options}: {faults}");
    }
}

#[test]
fn random_poses_lie_within_the_limits() {
    let text = map(&format!("{ARM} --random 2000 --seed 3")).unwrap();
    assert_eq!(text, map(&format!("{ARM} --random 2000 --seed 3")).unwrap());
    assert_ne!(text, map(&format!("{ARM} --random 2000 --seed 4")).unwrap());
    let placed = map(&format!("{ARM} --random 3 --at joint_1=90")).unwrap();
    assert!(columns(&placed)[0].iter().all(|q| *q == std::f64::consts::FRAC_PI_2));
    // The rail mill's first joint slides, between limits of its own.
    let output = command("robots/rail-mill --random 500").output().unwrap();
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(result(output).is_ok());
}

struct Figures {
    /// Mode, name, frequency, upper end, poses, pose, joints and β2; NaN where blank.
    rows: Vec<(usize, String, Vec<f64>)>,
}

impl Figures {
    fn read(text: &str) -> Self {
        let expected =
            "mode,statistic,frequency_hz,to_hz,poses,pose,joint_1_rad,joint_2_rad,beta2_rad";
        assert_eq!(text.lines().next(), Some(expected));
        let row = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells.len(), 9);
            let values = cells[2..].iter().map(|v| v.parse().unwrap_or(f64::NAN)).collect();
            (cells[0].parse().unwrap(), cells[1].to_owned(), values)
        };
        Self { rows: text.lines().skip(1).map(row).collect() }
    }

    fn all(&self, mode: usize, name: &str) -> Vec<&[f64]> {
        let rows = self.rows.iter().filter(|row| row.0 == mode && row.1 == name);
        rows.map(|row| &row.2[..]).collect()
    }
}

/// NumPy's default quantile of sorted values.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let rank = share * (sorted.len() - 1) as f64;
    let (below, above) = (rank.floor() as usize, rank.ceil() as usize);
    sorted[below] + rank.fract() * (sorted[above] - sorted[below])
}

/// Few poses, whose quantiles are exact, and many, whose quantiles are within the resolution.
#[test]
fn figures_agree_with_a_plain_scan() {
    for (count, tolerance) in [(1, 0.0), (3001, 1e-15), (140_000, 2.0_f64.powi(-14))] {
        let source = format!("{ARM} --random {count} --seed 5");
        let columns = columns(&map(&source).unwrap());
        let text = map(&format!("{source} --reduce histogram,min,max,mean,quantiles")).unwrap();
        let figures = Figures::read(&text);
        for mode in 1..=2 {
            let values = &columns[2 + mode];
            let one = |name: &str| figures.all(mode, name)[0];
            let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
            let highest = values.iter().copied().fold(0.0, f64::max);
            for (name, extreme) in [("min", lowest), ("max", highest)] {
                let pose = values.iter().position(|v| *v == extreme).unwrap();
                let at = [columns[0][pose], columns[1][pose], columns[2][pose]];
                let row = one(name);
                assert_eq!((row[0], row[3]), (extreme, (pose + 1) as f64));
                assert_eq!(row[4..], at);
            }
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            assert!((one("mean")[0] / mean - 1.0).abs() < 1e-12);
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            for percent in [5, 25, 50, 75, 95] {
                let expected = quantile(&sorted, f64::from(percent) / 100.0);
                let found = one(&format!("q{percent}"))[0];
                assert!((found / expected - 1.0).abs() <= tolerance, "{found} {expected}");
            }
            let bins = figures.all(mode, "bin");
            assert!(bins.len() <= 48 && (count < 9 || bins.len() >= 20), "{}", bins.len());
            for bin in &bins {
                let inside = values.iter().filter(|v| bin[0] <= **v && **v < bin[1]).count();
                assert_eq!(bin[2], inside as f64);
            }
            assert!(bins.windows(2).all(|pair| pair[0][1] == pair[1][0]), "a gap");
            assert_eq!(bins.iter().map(|bin| bin[2]).sum::<f64>(), f64::from(count));
        }
    }
}

#[test]
fn figures_are_the_same_as_json_and_a_picture_has_no_blemish() {
    let source = format!("{ARM} --random 500 --seed 1 --reduce min,mean,quantiles,histogram");
    let figures = Figures::read(&map(&source).unwrap());
    let json = map(&format!("{source} --format json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["schema"], &json["poses"]), (&"map-reduced/1".into(), &500.into()));
    assert_eq!(json["quantile_resolution_percent"], 0.0);
    for mode in 1..=2 {
        let found = &json["modes"][mode - 1];
        let min = figures.all(mode, "min")[0];
        assert_eq!(found["min"]["frequency_hz"], min[0]);
        assert_eq!(found["min"]["pose"].as_f64(), Some(min[3]));
        assert_eq!(found["min"]["joints"][1], min[5]);
        assert_eq!(found["mean_hz"], figures.all(mode, "mean")[0][0]);
        assert_eq!(found["quantiles"][2]["percent"], 50.0);
        assert_eq!(found["quantiles"][2]["frequency_hz"], figures.all(mode, "q50")[0][0]);
        assert_eq!(found["histogram"].as_array().unwrap().len(), figures.all(mode, "bin").len());
        assert!(found["max"].is_null(), "was not asked for");
    }
    for poses in ["--random 500", "--grid joint_2=90:90:1"] {
        let svg = map(&format!("{ARM} {poses} --reduce histogram --format svg")).unwrap();
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    for options in
        ["", "--format json", "--format npy", "--reduce min,max,mean,quantiles,histogram"]
    {
        let with = |threads: &str| {
            let line = format!("{ARM} --random 70000 --seed 9 {options}");
            result(command(&line).env("RAYON_NUM_THREADS", threads).output().unwrap()).unwrap()
        };
        let one = with("1");
        assert!(one.len() > 500);
        for threads in ["2", "5"] {
            assert!(with(threads) == one, "{threads} threads, {options}");
        }
    }
}

#[test]
fn json_of_many_batches_is_one_document() {
    let line = format!("{ARM} --random 70000 --format json");
    let json: serde_json::Value = serde_json::from_str(&map(&line).unwrap()).unwrap();
    assert_eq!(json["rows"].as_array().unwrap().len(), 70_000);
    let none =
        fed(&format!("{ARM} --poses - --format json"), b"joint_1_rad,joint_2_rad\n").unwrap();
    let json: serde_json::Value = serde_json::from_slice(&none).unwrap();
    assert_eq!(json["rows"].as_array().unwrap().len(), 0);
    let none = fed(&format!("{ARM} --poses - --reduce min"), b"joint_1_rad,joint_2_rad\n");
    assert!(none.unwrap_err().concat().contains("--reduce: the table holds no poses"));
}

/// Lines are counted past comments, quotes and the borders of pieces and batches.
#[test]
fn faults_far_down_a_table_have_their_line() {
    let mut table = String::from("# a table\nid,joint_2_rad,joint_1_deg\n");
    for i in 0..300_000 {
        match i {
            70_000 => table.push_str("# pause\n\n"),
            150_000 => table.push_str("\"7,5\",0.25,1\n"),
            200_000 => table.push_str("8,much,1\n"),
            200_001 => table.push_str("9,1e999,1\n"),
            _ => table.push_str("ab,0.123456789012345,-12.3456789012345\n"),
        }
    }
    let faults = fed(&format!("{ARM} --poses -"), table.as_bytes()).unwrap_err();
    // Header and comments: four lines more than rows, less one row each that the special lines replace.
    assert_eq!(
        faults[..2],
        [
            "error: -:200004: joint_2_rad is 'much', must be a finite number",
            "error: -:200005: joint_2_rad is '1e999', must be a finite number",
        ]
    );
    assert_eq!(faults.len(), 3);
}

/// A row without an end is refused before it fills the memory.
#[test]
fn an_endless_row_is_refused() {
    let mut table = b"joint_1_rad,joint_2_rad\n0,1\n0,2,".to_vec();
    table.resize(4 << 20, b'7');
    let faults = fed(&format!("{ARM} --poses -"), &table).unwrap_err();
    assert_eq!(faults[0], "error: -:3: is longer than 1 MiB, must be one row of a table");
}

#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    for format in ["csv", "npy"] {
        let mut child = command(&format!("{ARM} --random 300000 --format {format}"))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut first = Vec::new();
        BufReader::new(child.stdout.take().unwrap()).read_until(b'\n', &mut first).unwrap();
        assert!(!first.is_empty());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()), "{format}");
    }
}

/// Peak memory of a process, kB.
#[cfg(target_os = "linux")]
fn peak_kb(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// Peak memory of the command in the middle of its work and near its end: it waits meanwhile for the test,
/// which does not read its output, or does not go on with its input.
#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_poses() {
    use std::io::{Read, Write};

    const POSES: usize = 800_000;
    /// Poses alone would take 16 bytes each, frequencies another 16.
    const MAX_KB: u64 = 4_000;

    let mut child = command(&format!("{ARM} --random {POSES}"))
        .env("RAYON_NUM_THREADS", "2")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    let mut read_to = |rows: usize, from: usize| {
        for _ in from..rows {
            line.clear();
            out.read_line(&mut line).unwrap();
        }
        peak_kb(child.id())
    };
    let early = read_to(POSES / 4, 0);
    let late = read_to(POSES - 10_000, POSES / 4);
    std::io::copy(&mut out.by_ref(), &mut std::io::sink()).unwrap();
    assert!(child.wait().unwrap().success());
    assert!(late < early + MAX_KB, "written: {early} kB, then {late} kB");

    for options in ["--reduce min,max,mean,quantiles,histogram", "--format npy"] {
        let mut child = command(&format!("{ARM} --poses - {options}"))
            .env("RAYON_NUM_THREADS", "2")
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let header =
            format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({POSES}, 2), }}\n");
        stdin.write_all(b"\x93NUMPY\x01\x00").unwrap();
        stdin.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
        stdin.write_all(header.as_bytes()).unwrap();
        let mut feed = |from: usize, to: usize| {
            for i in from..to {
                let q = [1e-6 * i as f64, 2.0 - 4.0 * i as f64 / POSES as f64];
                stdin.write_all(&[q[0].to_le_bytes(), q[1].to_le_bytes()].concat()).unwrap();
            }
            peak_kb(child.id())
        };
        // One sweep of the whole range, so that every bin is open by then; then the rest.
        let early = feed(0, POSES / 2);
        let late = feed(POSES / 2, POSES - 1);
        feed(POSES - 1, POSES);
        drop(stdin);
        assert!(child.wait().unwrap().success());
        assert!(late < early + MAX_KB, "{options}: {early} kB, then {late} kB");
    }
}
