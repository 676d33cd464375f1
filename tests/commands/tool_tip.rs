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

/// A program in place of the poses of the pocket, with keys of the job before the operations.
fn programmed(program: &str, keys: &str, replaced: &[(&str, &str)]) -> Pocket {
    let [quiet, fast] = QUIET;
    let keys = format!("{keys}operations:");
    let own = [quiet, fast, ("operations:", keys.as_str())];
    let pocket = Pocket::new(&[&own[..], replaced].concat());
    let path = pocket.0.path().join("job.yaml");
    let text = fs::read_to_string(&path).unwrap();
    let (head, _) = text.split_once("      poses:").unwrap();
    fs::write(&path, format!("{head}      program: {{file: p.nc}}\n")).unwrap();
    fs::write(pocket.0.path().join("p.nc"), program).unwrap();
    pocket
}

/// Where nothing cuts, nothing is known of a limit.
#[test]
fn a_limit_that_no_move_is_held_against_leaves_a_doubt() {
    let program = "G21 G90\nS36000 M3\nG0 X0 Y0 Z0\nG0 X100\nG0 Y50\nM5\nM30\n";
    let pocket = programmed(program, "speeds_from: job\n", &[]);
    assert_eq!(pocket.check(&[]).1["verdict"], "clear");
    let (_, job) = pocket.check(&["--policy", "max_vibration_um=50"]);
    assert_eq!(job["verdict"], "uncertain", "{}", job["warnings"]);
    let told = job["warnings"].as_array().unwrap();
    let is_of_limit = |warning: &&Value| warning["code"] == "limit_unchecked";
    let warning = told.iter().find(is_of_limit).unwrap();
    assert!(warning.to_string().contains("nothing cuts"), "{warning}");
}

/// A plunge that takes most of the time does not make air of the cut behind it, nor does a slow move with the
/// spindle stopped: what is taken for air for its feed alone is held against the limits as a doubt.
#[test]
fn slow_moves_do_not_hide_fast_cuts() {
    let no_feed = ("    feed_mm_per_min: 400\n", "");
    let largest =
        |job: &Value| number(&job["operations"][0]["tool_tip"]["deflection"]["largest_um"]);
    let up_to = |job: &Value| number(&job["operations"][0]["tool_tip"]["deflection"]["up_to_um"]);
    let of = |feed: &str, last: &str| {
        let program = format!(
            "G21 G90\nS36000 M3\nG0 X0 Y0 Z20\nG1 Z0 F{feed}\nG1 X100 F3000\nG1 Y20\n{last}M30\n"
        );
        programmed(&program, "", &[no_feed]).check(&["--policy", "max_deflection_um=10"]).1
    };
    let fast = of("3000", "");
    assert_eq!(fast["verdict"], "resonance", "{}", fast["warnings"]);
    let slow = of("100", "");
    assert_eq!(slow["verdict"], "uncertain", "{}", slow["warnings"]);
    assert!(up_to(&slow) >= largest(&fast), "{} {}", up_to(&slow), largest(&fast));
    let warning = slow["warnings"].to_string();
    assert!(warning.contains("limit_in_doubt") && warning.contains("if it cuts"), "{warning}");
    let stopped = of("3000", "M5\nG1 X0 F20\n");
    assert_eq!(stopped["verdict"], "resonance", "{}", stopped["warnings"]);
    assert!((largest(&stopped) / largest(&fast) - 1.0).abs() < 0.01, "{}", largest(&stopped));
}

/// The feed of a plunge has no direction across the tool: any is a guess, so all four are looked at.
#[test]
fn a_plunge_is_no_cut_to_one_side() {
    let check = |turn: &str| {
        let rpy = format!("rpy_deg: [0, 180, {turn}]");
        let pocket = Pocket::new(&[QUIET[0], QUIET[1], ("rpy_deg: [0, 180, 0]", &rpy)]);
        let path = pocket.0.path().join("job.yaml");
        let text = fs::read_to_string(&path).unwrap();
        let (head, _) = text.split_once("      poses:").unwrap();
        let poses = ["10", "0"].map(|z| format!("        - {{xyz_mm: [0, 0, {z}], {rpy}}}\n"));
        fs::write(&path, format!("{head}      poses:\n{}", poses.concat())).unwrap();
        let (_, job) = pocket.check(&["--policy", "max_deflection_um=1000"]);
        let tip = job["operations"][0]["tool_tip"].clone();
        let most = number(&tip["deflection"]["largest_um"]);
        let limit = format!("max_deflection_um={}", 0.9 * most);
        (most, pocket.check(&["--policy", &limit]).1["verdict"].clone())
    };
    let ((one, verdict), (other, _)) = (check("0"), check("90"));
    assert!((one / other - 1.0).abs() < 1e-3, "{one} {other}");
    assert_eq!(verdict, "uncertain");
}

/// What gates by probability sees limits, too: they have none.
#[test]
fn a_limit_that_is_exceeded_fails_every_gate_but_never() {
    let [quiet, fast] = QUIET;
    let pocket = Pocket::new(&[quiet, fast]);
    let limit = ["--policy", "max_deflection_um=0.001"];
    for (gate, fails) in [("resonance", 1), ("probability=0.5", 1), ("never", 0)] {
        let (passes, job) = pocket.check(&[&limit[..], &["--fail-on", gate]].concat());
        assert_eq!((passes, job["verdict"].as_str()), (fails, Some("resonance")), "{gate}");
    }
    // Nor does advice call such a speed one to run at, or another of the few that this spindle has.
    let own = ("payload: none", "policy: {max_deflection_um: 0.001}\npayload: none");
    let few = ("min_rpm: 500, max_rpm: 40000", "min_rpm: 35998, max_rpm: 36002");
    let pocket = Pocket::new(&[quiet, fast, few, own]);
    let ran = pocket.run(&["advise", "job.yaml", "--write", "as.yaml"]);
    let told = crate::program::flat(&ran);
    assert_eq!(code(&ran), 1, "{told}");
    assert!(told.contains("limit") && !told.contains("run the job as it is"), "{told}");
    assert!(!pocket.0.path().join("as.yaml").exists());
    let page = pocket.run(&["report", "job.yaml", "--output", "page.html"]);
    assert!(code(&page) < 2, "{}", err(&page));
    let page = fs::read_to_string(pocket.0.path().join("page.html")).unwrap();
    assert!(page.contains("max_deflection_um is") && page.contains("the mean force moves"));
}

/// A tool that rings at the thirteenth harmonic is seen as one that rings at the twelfth.
#[test]
fn harmonics_reach_beyond_the_modes_of_the_tool() {
    let vibration = |hz: u32| {
        let tool = format!(
            "{{teeth: 2, diameter_mm: 12, modes: [{{frequency_hz: {hz}, damping_ratio: 0.01, \
             stiffness_n_per_m: 2.0e6, axis: [0, 1, 0]}}]}}"
        );
        let pocket = Pocket::new(&[
            (TOOL, &tool),
            ("spindle_rpm: 1100", "spindle_rpm: 6000"),
            ("radial_depth_mm: 6", "radial_depth_mm: 0.5"),
        ]);
        number(&pocket.operation()["tool_tip"]["vibration"]["largest_um"])
    };
    let (twelfth, thirteenth, beside) = (vibration(2400), vibration(2600), vibration(2700));
    println!("{twelfth} {thirteenth} {beside} µm");
    assert!(thirteenth > 1.1 * beside && thirteenth > 0.6 * twelfth, "{twelfth} {thirteenth}");
}

/// What a quantity may come to holds what it comes to with coefficients inside the stated ranges.
#[test]
fn coefficients_within_their_range_stay_below_what_may_be() {
    let tip = |material: &str| {
        let operation = Pocket::new(&[("material: al-6061", material)]).operation();
        ["deflection", "vibration"].map(|of| {
            let of = &operation["tool_tip"][of];
            [number(&of["largest_um"]), number(&of["up_to_um"])]
        })
    };
    let [deflection, vibration] = tip("material: al-6061");
    // 1.72 times those of Al 6061; its K_rc as in the laboratory that has 4.67 times as much; no axial ones.
    for [tc, rc, te, re] in
        [[419.0, 195.0, 12.9, 13.4], [419.0, 530.0, 12.9, 13.4], [244.0, 530.0, 3.1, 3.2]]
    {
        let own = format!(
            "coefficients: {{ktc_n_per_mm2: {tc}, krc_n_per_mm2: {rc}, kte_n_per_mm: {te}, kre_n_per_mm: {re}}}"
        );
        let [d, v] = tip(&own);
        assert!(
            d[0] < deflection[1] && v[0] < vibration[1],
            "{own}: {d:?} {v:?} {deflection:?} {vibration:?}"
        );
    }
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
    // The stations that are nearest to equal parts of the path, both ends among them.
    let s: Vec<f64> = along.iter().map(|at| number(&at["s"])).collect();
    let stations: Vec<f64> =
        operation["samples"].as_array().unwrap().iter().map(|at| number(&at["s"])).collect();
    assert_eq!(s.len(), 41);
    for (i, s) in s.iter().enumerate() {
        let off = |at: f64| (at - i as f64 / 40.0).abs();
        let nearest = stations.iter().map(|at| off(*at)).fold(f64::INFINITY, f64::min);
        assert!(off(*s) <= nearest, "{i}: {s}, {nearest}");
    }
    let limit = |at: &Value| number(&at["limit_mm"]);
    let is_exact = |i: usize| along.get(i).is_none_or(|at| at["method"] == "exact");
    assert!((0..along.len()).filter(|&i| is_exact(i)).count() >= 8);
    let least = (0..along.len()).min_by(|&a, &b| limit(&along[a]).total_cmp(&limit(&along[b])));
    let least = least.unwrap();
    assert!(is_exact(least) && is_exact(least + 1) && is_exact(least.saturating_sub(1)));
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
    // Between the lower end of its interval and the limit it may chatter.
    let stability = &Pocket::new(&[quiet, fast]).operation()["stability"];
    let [low, limit] = [&stability["smallest_ci95_mm"][0], &stability["smallest"]["limit_mm"]];
    let between = format!("axial_depth_mm: {}", 0.5 * (number(low) + number(limit)));
    assert!(number(low) < 0.99 * number(limit), "{stability}");
    let clear = Pocket::new(&[quiet, fast, ("axial_depth_mm: 2", &between)]);
    let stability = &clear.operation()["stability"];
    assert_eq!(
        (&stability["is_beyond"], &stability["may_be_beyond"]),
        (&false.into(), &true.into())
    );
    let text = crate::program::flat(&clear.run(&["check", "job.yaml"]));
    assert!(text.starts_with("CLEAR"), "{text}");
    assert!(text.contains("may be beyond it") && text.contains("the cut may chatter"), "{text}");
    // Where nothing is known of the material nothing is told.
    assert!(Pocket::new(&[("al-6061", "oak")]).operation().get("stability").is_none());
}

/// The exact limit may be smallest where that of the zeroth order is not: here it falls along another mode.
#[test]
fn the_smallest_limit_is_that_of_the_path() {
    let pocket =
        Pocket::new(&[("spindle_rpm: 1100", "spindle_rpm: 18000"), ("al-6061", "al-6082")]);
    let smallest = number(&pocket.operation()["stability"]["smallest"]["limit_mm"]);
    for s in ["0", "0.15", "0.3", "0.5", "0.7", "0.85", "1"] {
        let ran = pocket.run(&["lobes", "job.yaml", "--rpm", "18000:18000:1", "--at", s]);
        let row: Vec<String> =
            out(&ran).lines().nth(1).unwrap().split(',').map(str::to_owned).collect();
        let limit: f64 = row[1].parse().unwrap();
        println!("{s}: {limit} mm, {smallest} along the path");
        assert!(limit > 0.98 * smallest, "at {s} {limit} mm, {smallest} along the path");
    }
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
    // A limit of the policy speaks of the advised speed. All safe ones are tried: few of this spindle are, from
    // 25 560 rpm on.
    let narrow = [
        ("spindle_rpm: 1100", "spindle_rpm: 25550"),
        ("min_rpm: 500, max_rpm: 24000", "min_rpm: 25550, max_rpm: 25565"),
        (TOOL, tool),
    ];
    let pocket = Pocket::new(&narrow);
    let ran = pocket.run(&["advise", "job.yaml", "--policy", "max_deflection_um=0.01"]);
    assert!(out(&ran).contains("policy.max_deflection_um is 0.0"), "{}", out(&ran));
}
