//! `diagnose` as a user meets it: the paper's own data, a hidden effect of each kind, faults, files.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop where they fail"
)]

use std::process::{Command, Output};

use serde_json::Value;

fn detune(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_detune"))
        .args(args)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn json(args: &[&str]) -> Value {
    let output = detune(args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Table 1 as printed is off by 171 % from the measured columns of Table 2; what the diagnosis finds brings
/// poses left out to 4.8 %, the simulated columns to 2.3 %.
#[test]
fn the_papers_own_data() {
    for (table, before, after) in
        [("measured", [150.0, 190.0], 4.8), ("simulated", [150.0, 190.0], 2.3)]
    {
        let table = format!("robots/two-link/{table}.csv");
        let found = json(&["diagnose", "robots/two-link", &table, "--format", "json"]);
        assert_eq!(found["schema"], "diagnosis/1");
        assert_eq!(found["verdict"], "explained", "{table}");
        let error = |of: &str| found[of]["heldout_rms_percent"].as_f64().unwrap();
        assert!(
            (before[0]..before[1]).contains(&error("baseline")),
            "{table} {}",
            error("baseline")
        );
        assert!(error("extended") <= after, "{table} {}", error("extended"));
    }
}

/// What --write writes is what check reads, from another folder, with twice the held-out error.
#[test]
fn the_written_robot_is_what_check_uses() {
    let folder = tempfile::tempdir().unwrap();
    let written = folder.path().join("arm.yaml");
    let measured = "robots/two-link/measured.csv";
    let arguments = ["diagnose", "robots/two-link", measured, "--format", "json", "--write"];
    let found = json(&[&arguments[..], &[written.to_str().unwrap()]].concat());
    let heldout = found["extended"]["heldout_rms_percent"].as_f64().unwrap();
    let job = folder.path().join("job.yaml");
    std::fs::write(
        &job,
        "name: a\nrobot: arm.yaml\ntool: {teeth: 2}\nspindle: {min_rpm: 500, max_rpm: 6000}\noperations:\n  \
         - name: a\n    spindle_rpm: 1100\n    feed_mm_per_min: 400\n    path: {joints_deg: [[120, 20], [120, 90]]}\n",
    )
    .unwrap();
    let checked = json(&["check", job.to_str().unwrap(), "--format", "json", "--fail-on", "never"]);
    let model = &checked["jobs"][0]["model"];
    assert_eq!(model["calibrated"], true);
    assert!((model["uncertainty_percent"].as_f64().unwrap() - 2.0 * heldout).abs() < 1e-9);
    // The frequencies are those of the extended model: near what was measured at 1.396 rad, 41.51 Hz.
    let last = checked["jobs"][0]["operations"][0]["samples"].as_array().unwrap().last().unwrap();
    let f2 = last["natural_frequencies_hz"][1].as_f64().unwrap();
    assert!((35.0..45.0).contains(&f2), "{f2}");
}

/// The same seed gives the same bytes, whatever the number of threads.
#[test]
fn the_same_seed_gives_the_same_bytes() {
    let run = |threads: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_detune"))
            .args([
                "diagnose",
                "robots/two-link",
                "robots/two-link/simulated.csv",
                "--format",
                "json",
            ])
            .args(["--seed", "5"])
            .env("RAYON_NUM_THREADS", threads)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        assert!(output.status.success());
        output.stdout
    };
    assert!(run("1") == run("3"));
}

#[test]
fn bad_tables_are_told_and_nothing_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("t.csv");
    for (content, told) in [
        ("beta2_rad\n1\n", "no column 'f1_hz'"),
        ("beta2_rad,f1_hz,f2_hz\n1,30,20\n", "f2_hz is 20, must not be less than f1_hz"),
        ("beta2_rad,f1_hz\n1,-3\n", "f1_hz is -3, must be positive"),
        ("beta2_rad,f1_hz\n1,x\n", "f1_hz is 'x', must be a finite number"),
        ("beta2_rad,f1_hz,f2_hz\n1,20,40\n", "too little data: 2 frequencies at 1 poses"),
    ] {
        std::fs::write(&table, content).unwrap();
        let output = detune(&["diagnose", "robots/two-link", table.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2), "{content}");
        assert!(text(&output.stderr).contains(told), "{}", text(&output.stderr));
        assert!(output.stdout.is_empty());
    }
}

/// A page holds its plots and nothing from elsewhere; the text says what to do next.
#[test]
fn the_page_stands_alone() {
    let page = text(
        &detune(&[
            "diagnose",
            "robots/two-link",
            "robots/two-link/simulated.csv",
            "--format",
            "html",
        ])
        .stdout,
    );
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    assert!(page.matches("<svg").count() == 4 && page.contains("next"));
    assert!(!page.contains("http") && !page.contains("NaN"));
}
