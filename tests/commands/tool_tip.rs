//! What the cut does at the tool tip, and limits of the policy on it, as a user meets them.

use std::fs;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{code, err, json, out, repository, run};

const TOOL: &str = "{name: 12 mm 2-flute, teeth: 2, diameter_mm: 12}";

const SPINDLE: &str = "payload: {mass_kg: 8, com_m: [0, 0, 0.1], \
                       inertia_kgm2: {ixx: 0.05, iyy: 0.05, izz: 0.02}}";

/// A speed at which no line meets a mode: the spindle's at 600 Hz, the fifth mode up to 358 Hz.
const QUIET: [(&str, &str); 2] =
    [("spindle_rpm: 1100", "spindle_rpm: 36000"), ("max_rpm: 24000", "max_rpm: 40000")];

/// The pocket of the repository with its first operation alone, and pieces of it replaced.
struct Pocket(TempDir);

impl Pocket {
    fn new(replaced: &[(&str, &str)]) -> Self {
        let mut text = fs::read_to_string(repository().join("jobs/pocket.yaml")).unwrap();
        text.truncate(text.find("  - name: finish").unwrap());
        let robot = repository().join("robots/irb1600/robot.yaml").display().to_string();
        for (from, to) in [("../robots/irb1600/robot.yaml", robot.as_str())].iter().chain(replaced)
        {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("job.yaml"), text).unwrap();
        Self(folder)
    }

    fn run(&self, arguments: &[&str]) -> Output {
        run(self.0.path(), arguments)
    }

    fn check(&self, options: &[&str]) -> (i32, Value) {
        let mut arguments = vec!["check", "job.yaml", "--format", "json"];
        arguments.extend(options);
        let ran = self.run(&arguments);
        (code(&ran), json(&ran)["jobs"][0].clone())
    }

    fn operation(&self) -> Value {
        self.check(&["--fail-on", "never"]).1["operations"][0].clone()
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn codes(job: &Value) -> Vec<&str> {
    let warnings = job["warnings"].as_array().unwrap();
    warnings.iter().map(|warning| warning["code"].as_str().unwrap()).collect()
}

/// By the modes here, by the springs there: K⁻¹ at a hundred places of the path under the same force.
#[test]
fn the_deflection_is_that_of_the_springs() {
    for tool in [
        TOOL,
        "{teeth: 2, diameter_mm: 12, helix_deg: 30, modes: [{frequency_hz: 400, \
                        damping_ratio: 0.02, stiffness_n_per_m: 100000, axis: [0.3, 1, 0.2]}]}",
    ] {
        let pocket = Pocket::new(&[(TOOL, tool), ("al-6061", "al-7075")]);
        let tip = &pocket.operation()["tool_tip"];
        let found = number(&tip["deflection"]["largest_um"]);
        let rows = json(&pocket.run(&["deflection", "job.yaml", "--format", "json"]));
        let size = |row: &Value| {
            let moved = row["deflection_um"].as_array().unwrap();
            moved.iter().map(|m| number(m).powi(2)).sum::<f64>().sqrt()
        };
        let largest = rows["poses"].as_array().unwrap().iter().map(size).fold(0.0, f64::max);
        // The stations of a check are closer.
        assert!((1.0 - 1e-9..1.01).contains(&(found / largest)), "{tool}: {found} {largest}");
        assert_eq!(tip["modes"], if tool == TOOL { "arm" } else { "arm_and_tool" });
    }
}

/// What `advise` tells of the programmed speed from its own points of the path.
#[test]
fn the_vibration_is_that_of_advice() {
    let pocket = Pocket::new(&[]);
    let tip = &pocket.operation()["tool_tip"];
    let advice = json(&pocket.run(&["advise", "job.yaml", "--format", "json"]));
    let told = number(&advice["operations"][0]["vibration"]["programmed"]["amplitude_um"]);
    let found = number(&tip["vibration"]["largest_um"]);
    assert!((1.0 - 1e-9..1.02).contains(&(found / told)), "{found} {told}");
    // The squares of its harmonics add up to it where all are largest at one place, else to more.
    let harmonics = tip["harmonics"].as_array().unwrap();
    let sum: f64 = harmonics.iter().map(|one| number(&one["amplitude_um"]).powi(2)).sum();
    assert!(sum.sqrt() > 0.99 * found, "{sum}");
    assert!(harmonics.iter().all(|one| one["source"] == "tooth_passing"));
    let hz = number(&harmonics[0]["excitation_hz"]);
    assert!((hz - 1100.0 / 60.0 * 2.0).abs() < 1e-9, "{hz}");
}

#[test]
fn runout_adds_lines_of_the_spindle() {
    let with = TOOL.replace("diameter_mm: 12", "diameter_mm: 12, runout: {offset_mm: 0.02}");
    let tip = Pocket::new(&[(TOOL, &with)]).operation()["tool_tip"].clone();
    let is_spindle = |one: &&Value| one["source"] == "spindle";
    let first = tip["harmonics"].as_array().unwrap().iter().find(is_spindle).unwrap().clone();
    assert_eq!(first["harmonic"], 1);
    for (from, to, told) in [
        ("offset_mm: 0.02", "offset_mm: -1", "offset_mm"),
        ("offset_mm: 0.02", "offset_mm: 0.02, angel_deg: 3", "did you mean"),
        ("diameter_mm: 12", "diameter_mm: 0.03", "must be below half of diameter_mm"),
    ] {
        let ran = Pocket::new(&[(TOOL, &with.replace(from, to))]).run(&["check", "job.yaml"]);
        assert!(code(&ran) == 2 && err(&ran).contains(told), "{to}: {}", err(&ran));
    }
}

/// A limit makes a verdict worse where it is exceeded, or may be; else nothing changes.
#[test]
fn limits_make_a_verdict_worse_only() {
    // A speed at which no line meets a mode.
    let pocket = Pocket::new(&QUIET);
    let (passes, plain) = pocket.check(&[]);
    assert_eq!((passes, plain["verdict"].as_str()), (0, Some("clear")), "{plain}");
    for (key, quantity) in [("max_deflection_um", "deflection"), ("max_vibration_um", "vibration")]
    {
        let largest = &plain["operations"][0]["tool_tip"][quantity];
        let (value, up_to) = (number(&largest["largest_um"]), number(&largest["up_to_um"]));
        assert!(up_to > 1.5 * value, "{value} {up_to}");
        let under = |limit_um: f64| pocket.check(&["--policy", &format!("{key}={limit_um}")]);

        let (failed, job) = under(0.5 * value);
        assert_eq!((failed, job["verdict"].as_str()), (1, Some("resonance")));
        assert!(codes(&job).contains(&"limit_exceeded"), "{:?}", codes(&job));
        let beyond = job["operations"][0]["tool_tip"]["beyond"].as_array().unwrap();
        let worst = beyond.iter().find(|one| one["certainty"] == "certain").unwrap();
        assert_eq!(worst["quantity"], quantity);
        let limit_um = number(&worst["limit_um"]);
        assert!((limit_um / (0.5 * value) - 1.0).abs() < 1e-12, "{limit_um}");
        let [from, to] = ["from_line", "to_line"].map(|key| worst[key].as_u64().unwrap());
        assert!((10..=40).contains(&from) && from <= to && to <= 40, "{worst}");

        let (passes, job) = under(0.5 * (value + up_to));
        assert_eq!((passes, job["verdict"].as_str()), (0, Some("uncertain")));
        assert_eq!(codes(&job), ["limit_in_doubt"]);

        let (passes, job) = under(1.001 * up_to);
        assert_eq!((passes, job["verdict"].as_str()), (0, Some("clear")), "{:?}", codes(&job));
    }
}

#[test]
fn every_format_tells_a_limit_that_is_exceeded() {
    let pocket = Pocket::new(&QUIET);
    let told = |format: &str| -> String {
        let limit = ["--policy", "max_deflection_um=0.001", "--format", format];
        let ran = pocket.run(&[&["check", "job.yaml"], &limit[..]].concat());
        assert_eq!(code(&ran), 1, "{format}: {}", err(&ran));
        out(&ran).to_owned()
    };
    let text = told("text");
    assert!(text.starts_with("RESONANCE") && text.contains("limit    job.yaml:"), "{text}");
    assert!(text.contains("where a limit is exceeded"), "{text}");
    assert!(told("github").contains("::error file=job.yaml,line="));
    assert!(told("junit").contains("<failure"));
    let sarif: Value = serde_json::from_str(&told("sarif")).unwrap();
    let results = sarif["runs"][0]["results"].as_array().unwrap();
    let limit = results.iter().find(|result| result["ruleId"] == "limit").unwrap();
    assert_eq!(limit["level"], "error");
    let rule = limit["ruleIndex"].as_u64().unwrap() as usize;
    assert_eq!(sarif["runs"][0]["tool"]["driver"]["rules"][rule]["id"], "limit");
    let gitlab: Value = serde_json::from_str(&told("gitlab")).unwrap();
    let is_limit = |entry: &&Value| entry["check_name"] == "limit";
    assert_eq!(gitlab.as_array().unwrap().iter().find(is_limit).unwrap()["severity"], "critical");
}

/// What is not known is not clear; what is accepted counts no more.
#[test]
fn a_limit_without_a_force_leaves_a_doubt() {
    let [quiet, fast] = QUIET;
    for (from, to, why) in [
        ("al-6061", "oak", "cutting.material is not among"),
        (", diameter_mm: 12", "", "tool.diameter_mm is not given"),
        (
            "    cutting: {radial_depth_mm: 6, axial_depth_mm: 2, direction: climb, material: al-6061}\n",
            "",
            "has no 'cutting'",
        ),
    ] {
        let pocket = Pocket::new(&[quiet, fast, (from, to)]);
        let (_, job) = pocket.check(&[]);
        assert_eq!(job["verdict"], "clear");
        assert!(job["operations"][0].get("tool_tip").is_none(), "{to}");
        let (passes, job) = pocket.check(&["--policy", "max_vibration_um=50"]);
        assert_eq!((passes, job["verdict"].as_str()), (0, Some("uncertain")), "{to}");
        let warning = &job["warnings"][0];
        assert_eq!(warning["code"], "limit_unchecked");
        assert!(warning.to_string().contains(why), "{warning}");
    }
    let pocket = Pocket::new(&[
        quiet,
        fast,
        (
            "payload: none",
            "accept: [{code: limit_exceeded, reason: roughing, until: 2999-12-31}]\n\
                           policy: {max_deflection_um: 0.001}\npayload: none",
        ),
    ]);
    let (passes, job) = pocket.check(&[]);
    assert_eq!((passes, job["verdict"].as_str()), (0, Some("clear")));
    for bad in ["max_deflection_um=0", "max_vibration_um=-1", "max_vibration_um=.nan"] {
        let ran = pocket.run(&["check", "job.yaml", "--policy", bad]);
        assert_eq!(code(&ran), 2, "{bad}: {}", err(&ran));
    }
}

/// A limit is held against moves that cut; where none does, nothing is known of it. All moves of the program
/// run at 9000 mm/min, the operation's feed is 400.
#[test]
fn a_limit_that_no_move_is_held_against_leaves_a_doubt() {
    let [quiet, fast] = QUIET;
    let pocket = Pocket::new(&[quiet, fast, ("operations:", "speeds_from: job\noperations:")]);
    let path = pocket.0.path().join("job.yaml");
    let text = fs::read_to_string(&path).unwrap();
    let (head, _) = text.split_once("      poses:").unwrap();
    fs::write(&path, format!("{head}      program: {{file: fast.nc}}\n")).unwrap();
    let program = "G21 G90\nS36000 M3\nG0 X0 Y0 Z0\nG1 X100 F9000\nG1 Y50\nM5\nM30\n";
    fs::write(pocket.0.path().join("fast.nc"), program).unwrap();
    assert_eq!(pocket.check(&[]).1["verdict"], "clear");
    let (_, job) = pocket.check(&["--policy", "max_vibration_um=50"]);
    assert_eq!(job["verdict"], "uncertain", "{job}");
    let warning = &job["warnings"][0];
    assert_eq!(warning["code"], "limit_unchecked");
    assert!(warning.to_string().contains("nothing cuts"), "{warning}");
}

/// The section of `check` has what `lobes` tells of the same place and speed.
#[test]
fn stability_stands_beside_the_verdict() {
    let pocket = Pocket::new(&[]);
    let operation = pocket.operation();
    let stability = &operation["stability"];
    assert_eq!(stability["modes"], "arm");
    assert_eq!(stability["depth_mm"], 2.0);
    let along = stability["along"].as_array().unwrap();
    assert!(along.len() > 20, "{}", along.len());
    let limit = |at: &Value| number(&at["limit_mm"]);
    assert_eq!(along.iter().filter(|at| at["method"] == "exact").count(), 3);
    let smallest = along.iter().map(limit).fold(f64::INFINITY, f64::min);
    assert_eq!(limit(&stability["smallest"]), smallest);
    assert_eq!(stability["is_beyond"], smallest <= 2.0);
    for at in [&along[0], &along[17], &stability["smallest"]] {
        let s = number(&at["s"]).to_string();
        let method = at["method"].as_str().unwrap();
        let speed = ["--rpm", "1100:1100:1", "--method", method, "--at", &s];
        let ran = pocket.run(&[&["lobes", "job.yaml"], &speed[..]].concat());
        let told = out(&ran);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let row: Vec<&str> = told.lines().nth(1).unwrap().split(',').collect();
        let expected: f64 = row[1].parse().unwrap();
        assert!((limit(at) / expected - 1.0).abs() < 1e-9, "{at} {told}");
        assert_eq!(at["kind"], row[3]);
        // The arm's mode nearest to the frequency of the vibration is the one that is named.
        let hz = number(&at["frequency_hz"]);
        let mode = at["mode"].as_u64().unwrap() as usize;
        let samples = operation["samples"].as_array().unwrap();
        let here = samples.iter().find(|sample| sample["s"] == at["s"]).unwrap();
        let own = number(&here["natural_frequencies_hz"][mode - 1]);
        assert!((own / hz - 1.0).abs() < 0.2, "mode {mode} {own} Hz, {hz} Hz");
    }
    let ran = pocket.run(&["check", "job.yaml", "--fail-on", "never"]);
    let text = crate::program::flat(&ran);
    assert!(text.contains(" chatter from "), "{text}");
    assert!(text.contains("the arm's modes alone"), "{text}");
    // A deep cut chatters; the verdict on resonance stays what it was.
    let deep = Pocket::new(&[("axial_depth_mm: 2", "axial_depth_mm: 500")]).operation();
    assert_eq!(deep["stability"]["is_beyond"], true);
    assert_eq!(deep["verdict"], operation["verdict"]);
    let [quiet, fast] = QUIET;
    for (depth, says) in [("2", "what the cut does stands beside"), ("500", "but the cut chatters")]
    {
        let axial = format!("axial_depth_mm: {depth}");
        let clear = Pocket::new(&[quiet, fast, ("axial_depth_mm: 2", &axial)]);
        let text = crate::program::flat(&clear.run(&["check", "job.yaml"]));
        assert!(text.starts_with("CLEAR") && text.contains(says), "{text}");
    }
    // Where nothing is known of the material nothing is told.
    assert!(Pocket::new(&[("al-6061", "oak")]).operation().get("stability").is_none());
}

/// Cordes, Hintze & Altintas, Robotics and Computer-Integrated Manufacturing 55 (2019) 11: in titanium at a
/// few hundred rpm the arm limits the depth, at milling speeds the tool does. The cutter: four teeth of
/// 20 mm with a mode of 900 Hz and 12 N/µm; Ti6Al4V with K_tc 1900 N/mm², K_rc 0.35 of it; a spindle of 8 kg.
/// Between the two, to 14 000 rpm, the arm's modes at 117 Hz and the tool's take turns.
#[test]
fn at_low_speeds_the_arm_limits_and_at_milling_speeds_the_tool() {
    let tool = "{teeth: 4, diameter_mm: 20, modes: [\
                {frequency_hz: 900, damping_ratio: 0.03, stiffness_n_per_m: 12.0e6, axis: [1, 0, 0]}, \
                {frequency_hz: 900, damping_ratio: 0.03, stiffness_n_per_m: 12.0e6, axis: [0, 1, 0]}]}";
    let titanium = "ti6al4v, coefficients: {ktc_n_per_mm2: 1900, krc_n_per_mm2: 665}";
    let pocket = Pocket::new(&[
        (TOOL, tool),
        ("al-6061", titanium),
        ("radial_depth_mm: 6", "radial_depth_mm: 10"),
        ("payload: none", SPINDLE),
    ]);
    let limits = |speeds: &str| {
        let ran = pocket.run(&["lobes", "job.yaml", "--rpm", speeds, "--at", "0.5"]);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let rows = out(&ran);
        let rows = rows.lines().skip(1).map(|row| {
            let cells: Vec<f64> =
                row.split(',').take(3).map(|cell| cell.parse().unwrap()).collect();
            (cells[0], cells[1], cells[2])
        });
        rows.collect::<Vec<_>>()
    };
    for (rpm, limit_mm, hz) in limits("150:600:10") {
        assert!(hz < 50.0, "{rpm} rpm: {limit_mm} mm at {hz} Hz");
    }
    let fast = limits("16000:24000:9");
    for &(rpm, limit_mm, hz) in &fast {
        println!("{rpm} rpm: {limit_mm} mm at {hz} Hz");
    }
    assert!(fast.iter().all(|&(_, _, hz)| hz > 700.0), "{fast:?}");
}

/// Depth is weighed among the safe speeds alone.
#[test]
fn advice_by_depth_takes_a_safe_speed() {
    let tool = "{teeth: 2, diameter_mm: 12, modes: [\
                {frequency_hz: 800, damping_ratio: 0.02, stiffness_n_per_m: 5.0e6, axis: [0, 1, 0]}]}";
    let fast = ("max_rpm: 24000", "max_rpm: 40000");
    let pocket = Pocket::new(&[fast, (TOOL, tool)]);
    let advise = |objective: &str| {
        let ran = pocket.run(&["advise", "job.yaml", "--objective", objective, "--format", "json"]);
        json(&ran)["operations"][0].clone()
    };
    let (deep, near) = (advise("depth"), advise("nearest"));
    assert_eq!(deep["safe_speeds_rpm"], near["safe_speeds_rpm"]);
    assert!(near.get("depth").is_none());
    let rpm = number(&deep["recommended_rpm"]);
    let safe = deep["safe_speeds_rpm"].as_array().unwrap();
    assert!(safe.iter().any(|gap| (number(&gap[0])..=number(&gap[1])).contains(&rpm)), "{rpm}");
    let limit = |of: &Value| number(&of["smallest"]["limit_mm"]);
    let (recommended, programmed) =
        (limit(&deep["depth"]["recommended"]), limit(&deep["depth"]["programmed"]));
    assert!(recommended > programmed, "{recommended} {programmed}");
    assert_eq!(deep["depth"]["modes"], "arm_and_tool");
    // No other safe speed of a coarse look is much deeper, by check's own exact limits.
    for share in [0.2, 0.5, 0.8] {
        let gap = safe.iter().max_by(|a, b| {
            (number(&a[1]) - number(&a[0])).total_cmp(&(number(&b[1]) - number(&b[0])))
        });
        let gap = gap.unwrap();
        let other = (number(&gap[0]) + share * (number(&gap[1]) - number(&gap[0]))).round();
        let slower = format!("spindle_rpm: {other}");
        let checked =
            Pocket::new(&[fast, (TOOL, tool), ("spindle_rpm: 1100", &slower)]).operation();
        let other_limit = number(&checked["stability"]["smallest"]["limit_mm"]);
        assert!(other_limit < 1.1 * recommended, "{other} rpm: {other_limit} {recommended}");
    }
    let ran = Pocket::new(&[fast, ("al-6061", "oak")]).run(&[
        "advise",
        "job.yaml",
        "--objective",
        "depth",
    ]);
    assert!(code(&ran) == 2 && err(&ran).contains("is not known"), "{}", err(&ran));
    // A limit of the policy speaks of the advised speed.
    let ran = pocket.run(&["advise", "job.yaml", "--policy", "max_deflection_um=0.01"]);
    assert!(out(&ran).contains("policy.max_deflection_um is 0.0"), "{}", out(&ran));
}
