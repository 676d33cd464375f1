//! Drilling as a planner meets it: thrust, what it does at the tool tip, limits, keys.

use std::fs;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{code, err, json, out, repository, run};

/// Into the work at 36000 rpm, where no line meets a mode.
const INTO: [&str; 2] = ["[50, 40, 2]", "[50, 40, -8]"];
const OUT_OF: [&str; 2] = ["[50, 40, -8]", "[50, 40, 2]"];
const ACROSS: [&str; 2] = ["[50, 40, 0]", "[90, 40, 0]"];

const STATED: &str = "{direction: drill, thrust_n: 200, torque_nm: 0.5}";
const THRUST: &str = "{direction: drill, thrust_n: 200}";
const PILOT: &str = "{direction: drill, material: al-7075, pilot_diameter_mm: 4}";
const WHOLE: &str = "{direction: drill, material: al-7075}";

struct Job(TempDir);

impl Job {
    fn new(cutting: &str, tool: &str, poses: [&str; 2]) -> Self {
        let robot = repository().join("robots/irb1600/robot.yaml").display().to_string();
        let poses = poses.map(|at| format!("{{xyz_mm: {at}, rpy_deg: [0, 180, 0]}}")).join(", ");
        let text = format!(
            "robot: {robot}\ntool: {{teeth: 2, diameter_mm: 12{tool}}}\n\
             tcp: {{xyz_m: [0, 0, 0.15]}}\nwork_object: {{xyz_m: [0.72, -0.12, 0.42]}}\n\
             payload: none\nspindle: {{min_rpm: 500, max_rpm: 40000}}\noperations:\n  \
             - name: hole\n    spindle_rpm: 36000\n    feed_mm_per_min: 400\n    \
             cutting: {cutting}\n    path: {{poses: [{poses}]}}\n"
        );
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("job.yaml"), text).unwrap();
        Self(folder)
    }

    fn run(&self, arguments: &[&str]) -> Output {
        run(self.0.path(), arguments)
    }

    fn check(&self, options: &[&str]) -> Value {
        let mut arguments = vec!["check", "job.yaml", "--format", "json", "--fail-on", "never"];
        arguments.extend(options);
        let ran = self.run(&arguments);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        json(&ran)["jobs"][0].clone()
    }

    fn tip(&self) -> Value {
        self.check(&[])["operations"][0]["tool_tip"].clone()
    }

    /// The verdict under a limit of the deflection, and the codes of the warnings.
    fn under(&self, limit_um: f64) -> (Value, String) {
        let job = self.check(&["--policy", &format!("max_deflection_um={limit_um}")]);
        (job["verdict"].clone(), job["warnings"].to_string())
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The compliance at the pose, as `detune deflection` has it of the springs, times the thrust, which
/// pushes the tip away from the work: up, as the hole goes down. The torque turns it the other way than
/// a right-hand drill turns, which is clockwise seen from above.
#[test]
fn thrust_and_torque_move_the_tip_by_the_compliance_of_the_pose() {
    let [without, with] = [THRUST, "{direction: drill, thrust_n: 200, torque_nm: 6}"]
        .map(|cutting| moved_by_drilling(&Job::new(cutting, "", INTO)));
    assert_eq!([without.0, with.0], [0.0, 6.0]);
    let apart = (0..3).map(|i| (with.1[i] - without.1[i]).powi(2)).sum::<f64>().sqrt();
    assert!(apart > 1.0, "{apart} µm");
}

/// The torque, and how the tip moves under it and the thrust, where `check` and two ways of `deflection`
/// agree on it.
fn moved_by_drilling(job: &Job) -> (f64, [f64; 3]) {
    let tip = job.tip();
    let rows = json(&job.run(&["deflection", "job.yaml", "--format", "json"]));
    let last = rows["poses"].as_array().unwrap().last().unwrap().clone();
    let joints = last["joints"].as_array().unwrap();
    let at = |(i, q): (usize, &Value)| format!("joint_{}={}", i + 1, number(q).to_degrees());
    let at: Vec<String> = joints.iter().enumerate().map(at).collect();
    let robot = repository().join("robots/irb1600").display().to_string();
    let mut arguments = vec!["deflection", &robot, "--tcp-m", "0,0,0.15", "--format", "json"];
    arguments.extend(at.iter().flat_map(|at| ["--at", at.as_str()]));
    let torque_nm = tip["drilling"]["torque_nm"].as_f64().unwrap_or(0.0);
    let moment = format!("0,0,{torque_nm}");
    arguments.extend(["--force-n", "0,0,200", "--moment-nm", &moment]);
    let pose = json(&job.run(&arguments))["poses"][0].clone();
    let [x, y, z] = std::array::from_fn(|i| number(&pose["deflection_um"][i]));
    let expected = (x * x + y * y + z * z).sqrt();
    let found = tip["along"].as_array().unwrap().last().unwrap().clone();
    assert_eq!(number(&found["s"]), 1.0);
    let um = number(&found["deflection_um"][0]);
    assert!(z > 0.0 && (um / expected - 1.0).abs() < 1e-6, "{um} {expected}");
    for i in 0..3 {
        let (own, other) = (number(&last["deflection_um"][i]), number(&pose["deflection_um"][i]));
        assert!((own - other).abs() < 1e-6 * expected, "{own} {other}");
    }
    let drilling = &tip["drilling"];
    assert_eq!(number(&drilling["thrust_n"]), 200.0);
    let skid = x.hypot(y);
    // The largest along the path, which is ten millimetres long.
    let told = number(&drilling["skid_um"]);
    assert!((1.0 - 1e-6..1.05).contains(&(told / skid)), "{told} {skid}");
    assert!(tip["surface_error"].is_null());
    assert_eq!(drilling["is_lower_bound"], false);
    (torque_nm, [x, y, z])
}

/// N b (K_rc h + K_re) sin κ with b = (D − d) / (2 sin κ), h = c sin κ, and N b (K_tc h + K_te) at
/// the mean radius; al-7075, 118°.
#[test]
fn thrust_and_torque_come_from_the_lips() {
    let job = Job::new(PILOT, "", INTO);
    let drilling = job.tip()["drilling"].clone();
    let sin = 59_f64.to_radians().sin();
    let (b, h) = (8.0 / (2.0 * sin), 400.0 / (36000.0 * 2.0) * sin);
    let thrust_n = 2.0 * b * (169.0 * h + 26.6) * sin;
    let torque_nm = 2.0 * b * (767.0 * h + 27.7) * 4e-3;
    assert!((number(&drilling["thrust_n"]) / thrust_n - 1.0).abs() < 1e-9, "{drilling}");
    assert!((number(&drilling["torque_nm"]) / torque_nm - 1.0).abs() < 1e-9, "{drilling}");
    assert!(number(&drilling["thrust_up_to_n"]) > 1.5 * thrust_n);
    assert_eq!(drilling["is_point_angle_assumed"], true);
    let ran = job.run(&["check", "job.yaml", "--fail-on", "never"]);
    let text = out(&ran).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("thrust 219 N") && text.contains("point angle 118° assumed"), "{text}");
    assert!(err(&ran).contains("tool.point_angle_deg is not given: 118° is assumed"));
    let given = Job::new(PILOT, ", point_angle_deg: 140", INTO).check(&[]);
    assert!(!given.to_string().contains("\"assumed\""), "{}", given["warnings"]);
}

#[test]
fn limits_hold_for_drilling() {
    let job = Job::new(STATED, "", INTO);
    let deflection = job.tip()["deflection"].clone();
    let (most, up_to) = (number(&deflection["largest_um"]), number(&deflection["up_to_um"]));
    assert_eq!(job.under(1.01 * up_to).0, "clear");
    assert_eq!(job.under(0.5 * (most + up_to)).0, "uncertain");
    let (verdict, told) = job.under(0.99 * most);
    assert_eq!(verdict, "resonance", "{told}");
    assert!(told.contains("limit_exceeded"), "{told}");
}

/// Without the chisel edge no limit is kept for sure, and one that is exceeded is.
#[test]
fn a_lower_bound_never_keeps_a_limit() {
    let small = "{direction: drill, material: al-7075, pilot_diameter_mm: 2}";
    for cutting in [WHOLE, small] {
        let job = Job::new(cutting, "", INTO);
        assert_eq!(job.tip()["drilling"]["is_lower_bound"], true);
        let (verdict, told) = job.under(1e6);
        assert_eq!(verdict, "uncertain", "{told}");
        assert!(told.contains("limit_unchecked") && told.contains("chisel edge"), "{told}");
        let (verdict, told) = job.under(1.0);
        assert_eq!(verdict, "resonance", "{told}");
        assert!(!told.contains("limit_unchecked"), "{told}");
    }
    let whole = Job::new(WHOLE, "", INTO);
    let ran = whole.run(&["check", "job.yaml", "--fail-on", "never"]);
    assert!(out(&ran).contains("lower bound"), "{}", out(&ran));
    let stated = "{direction: drill, material: al-7075, thrust_n: 500, torque_nm: 2}";
    for known in [PILOT, stated] {
        assert_eq!(Job::new(known, "", INTO).under(1e6).0, "clear", "{known}");
    }
}

/// Out of the hole nothing cuts; across the axis a drill does nobody knows what.
#[test]
fn only_moves_along_the_axis_into_the_work_drill() {
    let across = Job::new(STATED, "", ACROSS);
    let (verdict, told) = across.under(1.0);
    assert_eq!(verdict, "uncertain", "{told}");
    assert!(told.contains("if it drills there"), "{told}");
    let out_of = Job::new(STATED, "", OUT_OF);
    let (verdict, told) = out_of.under(1.0);
    assert_eq!(verdict, "uncertain", "{told}");
    assert!(told.contains("limit_unchecked") && told.contains("nothing cuts"), "{told}");
    assert!(out_of.tip().is_null());
    let rows = json(&out_of.run(&["deflection", "job.yaml", "--format", "json"]));
    assert!(rows["poses"][50]["force_n"].is_null(), "{}", rows["poses"][50]);
    // Half a degree off the axis is drilling, two are not.
    for (x, verdict) in [(50.087, "resonance"), (50.35, "uncertain")] {
        let at = format!("[{x}, 40, -8]");
        assert_eq!(Job::new(STATED, "", [INTO[0], &at]).under(1.0).0, verdict, "{x}");
    }
}

/// What shakes a drill with even lips, or one that is moved across its axis, is not in the force: no
/// limit of it is kept for sure.
#[test]
fn limits_of_what_is_not_known_are_unchecked() {
    let vibration = ["--policy", "max_vibration_um=1000000"];
    for cutting in [WHOLE, PILOT, STATED] {
        let job = Job::new(cutting, "", INTO).check(&vibration);
        let told = job["warnings"].to_string();
        assert_eq!(job["verdict"], "uncertain", "{cutting}: {told}");
        assert!(told.contains("limit_unchecked") && told.contains("even lips"), "{told}");
    }
    let unlike = Job::new(PILOT, ", runout: {offset_mm: 0.02}", INTO).check(&vibration);
    assert_eq!(unlike["verdict"], "clear", "{}", unlike["warnings"]);

    let across = Job::new(STATED, "", ACROSS);
    assert_eq!(across.tip()["drilling"]["leaves_axis"], true);
    let (verdict, told) = across.under(1e6);
    assert_eq!(verdict, "uncertain", "{told}");
    assert!(told.contains("limit_unchecked") && told.contains("across its axis"), "{told}");
    assert_eq!(Job::new(STATED, "", INTO).tip()["drilling"]["leaves_axis"], false);

    let (verdict, told) = Job::new(THRUST, "", INTO).under(1e6);
    assert_eq!(verdict, "uncertain", "{told}");
    assert!(told.contains("limit_unchecked") && told.contains("torque_nm"), "{told}");
    assert_eq!(Job::new(STATED, "", INTO).under(1e6).0, "clear");
}

/// Even lips leave nothing that shakes; unlike ones a line of the spindle, which takes coefficients.
#[test]
fn unlike_lips_shake_at_the_speed_of_the_spindle() {
    let even = Job::new(PILOT, "", INTO).tip();
    assert_eq!(even["harmonics"], serde_json::json!([]));
    assert_eq!(number(&even["vibration"]["up_to_um"]), 0.0);
    let runout = ", runout: {offset_mm: 0.02}";
    let unlike = Job::new(PILOT, runout, INTO).tip();
    let [only] = unlike["harmonics"].as_array().unwrap().as_slice() else { panic!("{unlike}") };
    assert_eq!((&only["source"], &only["harmonic"]), (&"spindle".into(), &1.into()));
    assert!(number(&only["amplitude_um"]) > 0.0);
    let (verdict, told) = Job::new(STATED, runout, INTO).under(1e6);
    assert_eq!(verdict, "uncertain", "{told}");
    assert!(told.contains("unlike lips"), "{told}");
    let with = "{direction: drill, thrust_n: 200, torque_nm: 1, material: al-7075}";
    assert_eq!(Job::new(with, runout, INTO).under(1e6).0, "clear");
}

#[test]
fn wrong_keys_have_their_line() {
    for (cutting, tool, expected) in [
        (
            "{direction: drill, material: al-7075, pilot_diameter_mm: 12}",
            "",
            "job.yaml:11: operation 'hole': cutting.pilot_diameter_mm is 12, must be below \
             tool.diameter_mm, 12",
        ),
        ("{direction: drill}", "", "has none of 'material', 'coefficients' and 'thrust_n'"),
        ("{direction: drill, thrust_n: 0}", "", "cutting.thrust_n is 0"),
        (STATED, ", point_angle_deg: 200", "point_angle_deg is 200"),
        ("{direction: slot, material: al-7075}", "", "missing key 'axial_depth_mm'"),
    ] {
        let ran = Job::new(cutting, tool, INTO).run(&["check", "job.yaml"]);
        assert_eq!(code(&ran), 2, "{cutting}: {}", err(&ran));
        assert!(err(&ran).contains(expected), "{cutting}: {}", err(&ran));
    }
    let job = Job::new(STATED, "", INTO);
    let path = job.0.path().join("job.yaml");
    let text = fs::read_to_string(&path).unwrap().replace(", diameter_mm: 12", "");
    fs::write(&path, text).unwrap();
    let ran = job.run(&["check", "job.yaml"]);
    let what = "job.yaml:11: operation 'hole': cutting.direction is drill, which needs \
                tool.diameter_mm";
    assert!(code(&ran) == 2 && err(&ran).contains(what), "{}", err(&ran));
    for (cutting, key) in [
        ("{direction: drill, thrust_n: 200, radial_depth_mm: 3}", "radial_depth_mm"),
        ("{direction: drill, thrust_n: 200, axial_depth_mm: 3}", "axial_depth_mm"),
        ("{direction: slot, axial_depth_mm: 1, material: oak, thrust_n: 9}", "thrust_n"),
    ] {
        let found = Job::new(cutting, "", INTO).check(&[])["warnings"].to_string();
        let what = format!("cutting.{key} has no effect");
        assert!(found.contains("\"unused\"") && found.contains(&what), "{found}");
    }
}

const MODES: &str = "modes: [{frequency_hz: 300, damping_ratio: 0.03, stiffness_n_per_m: 4.0e6, \
                     axis: [0, 0, 1]}]\ntool: {teeth: 2, diameter_mm: 12, point_angle_deg: 140}\n\
                     cutting: {direction: drill, coefficients: {ktc_n_per_mm2: 600, \
                     krc_n_per_mm2: 200}}\n";

fn lobes(text: &str, options: &[&str]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("modes.yaml"), text).unwrap();
    run(folder.path(), &[&["lobes", "modes.yaml", "--rpm"], options].concat())
}

/// The lowest point of every lobe of one mode under constant coefficients is w = 2 k ζ (1 + ζ) / (N
/// K_rc sin κ) (Altintas, Manufacturing Automation, 2nd ed., section 4.2), and the growth of a small
/// motion, found by another method, is 1 on the limit.
#[test]
fn the_limit_of_a_drill_is_a_width_of_cut() {
    let ran = lobes(MODES, &["1500:9000:1501"]);
    let said = err(&ran);
    assert!(said.contains("width of cut") && !said.contains("kac_n_per_mm2"), "{said}");
    let told = out(&ran);
    let rows: Vec<Vec<f64>> = told
        .lines()
        .skip(1)
        .map(|row| row.split(',').take(2).map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let least = rows.iter().map(|row| row[1]).fold(f64::INFINITY, f64::min);
    let lip = 2.0 * 200e6 * 70_f64.to_radians().sin();
    let expected_mm = 2e3 * 4e6 * 0.03 * 1.03 / lip;
    assert!((1.0 - 1e-9..1.001).contains(&(least / expected_mm)), "{least} {expected_mm}");
    for row in [&rows[3], &rows[700], &rows[1490]] {
        let [rpm, limit] = [row[0], row[1]].map(|value| format!("{value:?}"));
        let speed = format!("{rpm}:{rpm}:1");
        let ran = lobes(MODES, &[&speed, "--depth-mm", &limit]);
        let radius: f64 = out(&ran).trim().rsplit(',').next().unwrap().parse().unwrap();
        assert!((radius - 1.0).abs() < 1e-6, "{rpm} rpm, {limit} mm: {radius}");
    }
    // Across the axis a mode feels nothing of it.
    let across = lobes(&MODES.replace("[0, 0, 1]", "[1, 0, 0]"), &["3000:3000:1"]);
    assert!(out(&across).ends_with("3000,,,\n"), "{}", out(&across));
    let picture = lobes(MODES, &["1500:9000:11", "--format", "svg"]);
    assert!(out(&picture).contains("width of cut [mm]"));
    let json = json(&lobes(MODES, &["1500:9000:2", "--format", "json"]));
    assert_eq!(json["limit_of"], "width_of_cut");
}

#[test]
fn wrong_keys_of_modes_have_their_line() {
    for (from, to, expected) in [
        (", diameter_mm: 12", "", "modes.yaml:3: cutting.direction is drill, which needs"),
        (
            "drill,",
            "drill, pilot_diameter_mm: 13,",
            "modes.yaml:3: cutting.pilot_diameter_mm is 13",
        ),
        ("drill,", "drill, thrust_n: 100,", "modes.yaml:3: "),
    ] {
        let ran = lobes(&MODES.replace(from, to), &["3000:3000:1"]);
        assert_eq!(code(&ran), 2, "{to}: {}", err(&ran));
        assert!(err(&ran).contains(expected), "{to}: {}", err(&ran));
    }
    let ran = lobes(&MODES.replace("drill,", "drill, radial_depth_mm: 3,"), &["3000:3000:1"]);
    assert!(err(&ran).contains("cutting.radial_depth_mm has no effect"), "{}", err(&ran));
    let ran = lobes(&MODES.replace(", point_angle_deg: 140", ""), &["3000:3000:1"]);
    assert!(err(&ran).contains("118° is assumed"), "{}", err(&ran));
}

/// Stability stands beside the verdict as a width; advice by depth speaks of it, and advice on
/// vibration has nothing to say of a steady thrust.
#[test]
fn stability_and_advice_speak_of_the_width_of_cut() {
    let job = Job::new(PILOT, "", INTO);
    let stability = job.check(&[])["operations"][0]["stability"].clone();
    assert_eq!(stability["limit_of"], "width_of_cut");
    assert!((number(&stability["depth_mm"]) - 4.0).abs() < 1e-12);
    assert!(stability["along"].as_array().unwrap().iter().all(|at| at["method"] == "zeroth"));
    assert!(number(&stability["smallest"]["limit_mm"]) > 0.0);
    let stated = Job::new(STATED, "", INTO).check(&[]);
    assert!(stated["operations"][0]["stability"].is_null());
    let ran = job.run(&["advise", "job.yaml", "--objective", "depth"]);
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    let text = out(&ran).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("tool tip the thrust of a drill with even lips is steady"), "{text}");
    assert!(text.contains("of width of cut at") && !text.contains("of depth"), "{text}");
    let ran = job.run(&["advise", "job.yaml", "--objective", "vibration"]);
    assert!(code(&ran) == 2 && err(&ran).contains("so none is quieter"), "{}", err(&ran));
    let stated = Job::new(STATED, "", INTO);
    let ran = stated.run(&["advise", "job.yaml", "--objective", "depth"]);
    assert!(code(&ran) == 2 && err(&ran).contains("has no coefficients"), "{}", err(&ran));
}

/// A thrust that was measured grows with the chip at most: also where the program slows the spindle
/// down, speeds the feed up, or the job is written with another speed.
#[test]
fn a_measured_thrust_belongs_to_its_feed_per_revolution() {
    let up_to = |job: &Value| -> Vec<f64> {
        let all = job["operations"].as_array().unwrap().iter();
        all.map(|one| number(&one["tool_tip"]["drilling"]["thrust_up_to_n"])).collect()
    };
    let near = |found: Vec<f64>, expected: &[f64]| {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        let fits = found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-6);
        assert!(fits, "{found:?} {expected:?}");
    };
    let job = Job::new(STATED, "", INTO);
    let whole = fs::read_to_string(job.0.path().join("job.yaml")).unwrap();
    let write = |text: &str| fs::write(job.0.path().join("job.yaml"), text).unwrap();
    let path = whole[whole.find("path:").unwrap()..].trim_end().to_owned();
    let program = "path: {program: {file: two.nc}}\n    start_near_deg: [0, 20, -10, 0, 60, 0]";
    let of_program = whole.replace(&path, program);
    let silent = of_program
        .replace("    spindle_rpm: 36000\n", "")
        .replace("    feed_mm_per_min: 400\n", "");
    let hole = |x: i32, feed: i32| format!("G0 X{x} Y40 Z5\nG1 Z-8 F{feed}\nG0 Z5\n");
    let two = format!("G21 G90 G94\nM3 S36000\n{}S18000\n{}M30\n", hole(50, 400), hole(70, 1600));
    fs::write(job.0.path().join("two.nc"), two).unwrap();
    // 0.0111 and 0.0889 mm a turn.
    write(&silent);
    near(up_to(&job.check(&[])), &[200.0, 1600.0]);
    // One hole of four that has a thicker chip, and one that has a thinner one.
    let program = fs::read_to_string(job.0.path().join("two.nc")).unwrap();
    for feeds in [[400, 400, 400, 1600], [1600, 1600, 400, 1600]] {
        let holes = feeds.iter().zip([50, 60, 70, 80]).map(|(feed, x)| hole(x, *feed));
        let holes: String = holes.collect();
        fs::write(job.0.path().join("two.nc"), format!("G21 G90 G94\nM3 S36000\n{holes}M30\n"))
            .unwrap();
        near(up_to(&job.check(&[])), &[800.0]);
    }
    fs::write(job.0.path().join("two.nc"), program).unwrap();
    // The job's own speed and feed are those of the thrust.
    write(&format!("speeds_from: program\n{}", of_program.replace(": 400\n", ": 200\n")));
    near(up_to(&job.check(&[])), &[400.0, 3200.0]);
    let fast = of_program.replace("    feed_mm_per_min: 400\n", "").replace(": 36000", ": 39000");
    write(&format!("speeds_from: program\n{fast}"));
    near(up_to(&job.check(&[])), &[200.0 * 39.0 / 36.0, 1600.0 * 39.0 / 36.0]);
    write(&silent.replace("thrust_n: 200", "thrust_n: 200, measured_at_mm_per_rev: 0.1"));
    near(up_to(&job.check(&[])), &[200.0, 200.0]);
    let falling = "spindle_schedule: [{s: 0, rpm: 36000}, {s: 1, rpm: 18000}]";
    write(&whole.replace("spindle_rpm: 36000", falling));
    near(up_to(&job.check(&[])), &[400.0]);
    // One thrust of two drills.
    let tool = "tool: {teeth: 2, diameter_mm: 12}";
    let tools = "tools: {1: {teeth: 2, diameter_mm: 12}, 2: {teeth: 2, diameter_mm: 6}}";
    write(&silent.replace(tool, tools));
    let text = fs::read_to_string(job.0.path().join("two.nc")).unwrap();
    let text = text.replace("M3 S36000", "T1 M6\nM3 S36000").replace("S18000", "T2 M6\nS18000");
    fs::write(job.0.path().join("two.nc"), text).unwrap();
    let ran = job.run(&["check", "job.yaml"]);
    assert!(code(&ran) == 2 && err(&ran).contains("was measured with one drill"), "{}", err(&ran));
}

/// What is written at another feed per tooth says at which one the thrust was measured.
#[test]
fn a_job_that_is_written_keeps_the_feed_of_its_thrust() {
    let job = Job::new(STATED, "", INTO);
    let text = fs::read_to_string(job.0.path().join("job.yaml")).unwrap();
    // At 3900 rpm tooth passing meets a mode, and all that is safe is slower; 0.1026 mm a turn.
    let ringing = text.replace("spindle_rpm: 36000", "spindle_rpm: 3900").replace(
        "max_rpm: 40000}",
        "max_rpm: 3950}\npolicy: {model_uncertainty_percent: 2, spindle_harmonics: 0}",
    );
    let block = "cutting:\n      # by hand\n      direction: drill\n      torque_nm: 0.5 # N m\n      thrust_n: 200";
    for (text, written) in [
        (ringing.clone(), "{direction: drill, measured_at_mm_per_rev: 0.102564102564102"),
        (
            ringing.replace(&format!("cutting: {STATED}"), block),
            "\n      measured_at_mm_per_rev: 0.102564",
        ),
        (
            ringing.replace("torque_nm: 0.5", "torque_nm: 0.5, measured_at_mm_per_rev: ~"),
            "torque_nm: 0.5, measured_at_mm_per_rev: 0.102564",
        ),
    ] {
        fs::write(job.0.path().join("job.yaml"), text).unwrap();
        let advise = ["advise", "job.yaml", "--feed", "programmed", "--write", "new.yaml"];
        let ran = job.run(&advise);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let new = fs::read_to_string(job.0.path().join("new.yaml")).unwrap();
        assert!(new.contains(written) && !new.contains("spindle_rpm: 3900"), "{new}");
        let ran = job.run(&["check", "new.yaml", "--format", "json", "--fail-on", "never"]);
        let found = json(&ran)["jobs"][0]["operations"][0].clone();
        let slower = 3900.0 / number(&found["spindle_rpm"]);
        assert!(slower > 1.05, "{slower}");
        let up_to = number(&found["tool_tip"]["drilling"]["thrust_up_to_n"]);
        assert!((up_to / (200.0 * slower) - 1.0).abs() < 1e-6, "{up_to} {slower}");
    }
}

/// What a program that is written alone would change of the thrust is refused, until the job says at which
/// feed it was measured.
#[test]
fn a_program_that_is_written_alone_keeps_the_feed_of_its_thrust() {
    let job = Job::new(STATED, "", INTO);
    let whole = fs::read_to_string(job.0.path().join("job.yaml")).unwrap();
    let path = whole[whole.find("path:").unwrap()..].trim_end().to_owned();
    let program = "path: {program: {file: a.nc}}\n    start_near_deg: [0, 20, -10, 0, 60, 0]";
    let policy = "max_rpm: 3950}\npolicy: {model_uncertainty_percent: 2, spindle_harmonics: 0}";
    let text = whole
        .replace(&path, program)
        .replace("    spindle_rpm: 36000\n", "")
        .replace("max_rpm: 40000}", policy);
    let silent = text.replace("    feed_mm_per_min: 400\n", "");
    let stated = |text: &str| {
        text.replace("thrust_n: 200", "thrust_n: 200, measured_at_mm_per_rev: 0.10256410256410257")
    };
    for (job_text, feed, word, is_refused) in [
        (silent.clone(), "programmed", " F400", true),
        (stated(&silent), "programmed", " F400", false),
        (silent, "chip-load", " F400", false),
        // The job's feed stays.
        (text.clone(), "chip-load", "", true),
        (stated(&text), "chip-load", "", false),
    ] {
        fs::write(job.0.path().join("job.yaml"), job_text).unwrap();
        let hole = format!("G21 G90 G94\nM3 S3900\nG0 X50 Y40 Z5\nG1 Z-8{word}\nG0 Z5\nM30\n");
        fs::write(job.0.path().join("a.nc"), hole).unwrap();
        let arguments = ["advise", "job.yaml", "--feed", feed, "--write-program", "b.nc"];
        let ran = job.run(&arguments);
        let is_told = err(&ran).contains("state cutting.measured_at_mm_per_rev: 0.10256");
        assert_eq!((code(&ran) == 2, is_told), (is_refused, is_refused), "{feed} {}", err(&ran));
    }
}
