//! Warnings in which a resonance may hide, findings that a job accepts, and verdicts about nothing.
//!
//! The spindle turns at 24 000 rpm with two teeth, 800 Hz, where the IRB 1600 has no mode: without a
//! warning the verdict is clear.

use std::fs;
use std::process::Output;

use detune::study::advise::read;
use detune::units::Date;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{FORMATS, code, err, flat, json, out, repository, run};

const STEADY: &str = "G0 X0 Y0 Z0\nG1 X240 F400\nY40\nX0\n";
const MOVES_RAIL: &str = "G0 X0 Y0 Z0\nG1 X240 F400\nY40 E100\nX0\n";

struct Bench(TempDir);

impl Bench {
    /// A job that runs a program, with further keys.
    fn new(program: &str, keys: &str) -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        let robot = repository().join("robots/irb1600/robot.yaml");
        let job = format!(
            "robot: {}
tool: {{teeth: 2, payload: none}}
tcp: {{xyz_m: [0, 0, 0.15]}}
work_object: {{xyz_m: [0.72, -0.12, 0.42]}}
spindle: {{min_rpm: 500, max_rpm: 24000}}
operations:
  - {{name: rough, spindle_rpm: 24000, feed_mm_per_min: 400, path: {{program: {{file: rough.nc}}}}}}
{keys}",
            robot.display()
        );
        fs::write(bench.0.path().join("rough.nc"), format!("{program}M30\n")).unwrap();
        fs::write(bench.0.path().join("job.yaml"), job).unwrap();
        bench
    }

    fn check(&self, arguments: &[&str]) -> Output {
        run(self.0.path(), &[&["check", "job.yaml"], arguments].concat())
    }

    fn json(&self) -> Value {
        json(&self.check(&["--format", "json"]))["jobs"][0].clone()
    }
}

fn policy(keys: &str) -> String {
    format!("policy: {{tooth_passing_harmonics: 1, spindle_harmonics: 0{keys}}}\n")
}

fn accepted(until: &str) -> String {
    let entry = "code: axis_ignored, operation: rough, reason: the rail stands still";
    format!("{}accept:\n  - {{{entry}, until: {until}}}\n", policy(""))
}

#[test]
fn an_axis_that_is_ignored_leaves_the_verdict_uncertain_in_every_output() {
    let steady = Bench::new(STEADY, &policy(""));
    assert_eq!(steady.json()["verdict"], "clear");
    let bench = Bench::new(MOVES_RAIL, &policy(""));
    let found = bench.json();
    assert_eq!(found["verdict"], "uncertain");
    assert_eq!(found["operations"][0]["verdict"], "uncertain");
    assert_eq!(found["warnings"][0]["code"], "axis_ignored");
    assert_eq!(found["warnings"][0]["hides_clear"], true);
    assert_eq!(found["warnings"][0]["accepted"], Value::Null);
    assert_eq!(code(&bench.check(&[])), 0);
    let text = bench.check(&["--fail-on", "uncertain"]);
    assert_eq!(code(&text), 1);
    let because = "because  rough.nc:3: E words";
    assert!(out(&text).lines().nth(1).unwrap().trim_start().starts_with(because), "{}", out(&text));
    let junit = bench.check(&["--format", "junit", "--fail-on", "uncertain"]);
    assert!(out(&junit).contains("so the verdict is no better than uncertain"), "{}", out(&junit));
    let sarif: Value = serde_json::from_str(out(&bench.check(&["--format", "sarif"]))).unwrap();
    let result = &sarif["runs"][0]["results"][0];
    assert_eq!((&result["ruleId"], &result["level"]), (&"doubt".into(), &"warning".into()));
    assert_eq!(result["locations"][0]["physicalLocation"]["region"]["startLine"], 3);
    let github = bench.check(&["--format", "github"]);
    assert!(
        out(&github).starts_with("::warning file=rough.nc,line=3::E words"),
        "{}",
        out(&github)
    );
    assert!(!err(&github).contains("::warning"), "told twice: {}", err(&github));
}

#[test]
fn motion_that_is_left_out_leaves_the_verdict_uncertain() {
    let bench = Bench::new("", "");
    let job = fs::read_to_string(bench.0.path().join("job.yaml")).unwrap();
    let job = job.replace("rough.nc", "rough.mod").replace("feed_mm_per_min: 400, ", "");
    let job = job + &policy("");
    fs::write(bench.0.path().join("job.yaml"), job).unwrap();
    let pose = |x: f64| format!("[[{x},0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let program = |call: &str| {
        format!(
            "MODULE m\nPROC main()\nMoveL {},v5,fine,tool0;\n{call}\nMoveL {},v5,fine,tool0;\nENDPROC\nENDMODULE\n",
            pose(0.0),
            pose(100.0)
        )
    };
    for (call, verdict) in [("", "clear"), ("ChangeFixture;", "uncertain")] {
        fs::write(bench.0.path().join("rough.mod"), program(call)).unwrap();
        let found = bench.json();
        assert_eq!(found["verdict"], verdict, "{found}");
        let codes = found["warnings"].as_array().unwrap().iter().map(|w| &w["code"]);
        assert_eq!(
            codes.filter(|code| *code == "motion_left_out").count(),
            usize::from(!call.is_empty())
        );
    }
}

#[test]
fn what_a_job_accepts_counts_no_more_and_is_shown() {
    let bench = Bench::new(MOVES_RAIL, &accepted("2999-12-31"));
    let ran = bench.check(&["--deny-warnings", "--fail-on", "uncertain"]);
    assert_eq!(code(&ran), 0, "{}{}", out(&ran), err(&ran));
    assert!(out(&ran).starts_with("CLEAR (1 accepted) "), "{}", out(&ran));
    let terms = "until 2999-12-31: the rail stands still";
    let flat = flat(&ran);
    assert!(flat.contains(&format!(" accepted {terms}")), "{}", out(&ran));
    assert!(err(&ran).starts_with("accepted: rough.nc:3: E words"), "{}", err(&ran));
    // Whoever reads annotations or a build server's report sees it, too.
    let said = "accepted until 2999-12-31: the rail stands still";
    let github = bench.check(&["--format", "github"]);
    assert!(out(&github).starts_with("::notice ") && out(&github).contains(said), "{github:?}");
    let junit = bench.check(&["--format", "junit"]);
    assert!(out(&junit).contains(said), "{}", out(&junit));
    let found = bench.json();
    assert_eq!(found["warnings"][0]["hides_clear"], false);
    assert_eq!(found["warnings"][0]["accepted"]["until"], "2999-12-31");
    let sarif: Value = serde_json::from_str(out(&bench.check(&["--format", "sarif"]))).unwrap();
    let suppression = &sarif["runs"][0]["results"][0]["suppressions"][0];
    assert_eq!(
        (&suppression["status"], &suppression["justification"]),
        (&"accepted".into(), &terms.into())
    );
}

#[test]
fn an_acceptance_ends_with_its_day() {
    let bench = Bench::new(MOVES_RAIL, &accepted("2027-06-30"));
    let path = bench.0.path().join("job.yaml");
    for (today, entries) in [("2027-06-29", 1), ("2027-06-30", 1), ("2027-07-01", 0)] {
        let job = read(&path, Date::read(today).unwrap()).value.unwrap();
        assert_eq!(job.review.accept.len(), entries, "{today}");
    }
    let bench = Bench::new(MOVES_RAIL, &accepted("2020-01-31"));
    let ran = bench.check(&[]);
    assert!(out(&ran).starts_with("UNCERTAIN "), "{}", out(&ran));
    let told = "job.yaml:10: accept: 'axis_ignored' was accepted until 2020-01-31 and counts again";
    assert!(err(&ran).contains(told), "{}", err(&ran));
    let bench = Bench::new(STEADY, &accepted("2999-12-31"));
    let told = "job.yaml:10: accept: there is no 'axis_ignored' in operation 'rough' to accept";
    assert!(err(&bench.check(&[])).contains(told), "{}", err(&bench.check(&[])));
}

#[test]
fn entries_with_faults_are_errors() {
    let keys = format!(
        "{}accept:
  - {{code: axis_ignord, reason: a, until: 2999-12-31}}
  - {{code: axis_ignored, reason: ' ', until: 2999-02-30}}
  - {{code: value, reason: a, until: 2999-12-31, operation: ruogh}}
  - {{code: axis_ignored, mode: 1, until: 2999-12-31, reason: a}}
  - {{code: axis_ignored, until: 2999-12-31}}
",
        policy("")
    );
    let ran = Bench::new(STEADY, &keys).check(&[]);
    assert_eq!(code(&ran), 2);
    for told in [
        "job.yaml:10: accept[0].code is 'axis_ignord', must be crossing or the code of a warning; did you mean 'axis_ignored'?",
        "job.yaml:11: accept[1].reason is empty",
        "job.yaml:11: accept[1].until is '2999-02-30', must be a day as YYYY-MM-DD",
        "job.yaml:12: accept[2].code is 'value'",
        "job.yaml:12: accept[2].operation is 'ruogh', which does not exist; did you mean 'rough'?",
        "job.yaml:13: accept[3].mode has no effect",
        "job.yaml:14: accept[4]: missing key 'reason'",
    ] {
        assert!(err(&ran).contains(told), "{told}\n{}", err(&ran));
    }
}

#[test]
fn a_crossing_is_accepted_by_its_mode() {
    let folder = tempfile::tempdir().unwrap();
    let robot = repository().join("robots/two-link/robot.yaml");
    // 26 Hz lies on mode 1, see `check.rs`.
    let job = format!(
        "robot: {}\ntool: {{teeth: 2}}\npayload: none\nspindle: {{min_rpm: 500, max_rpm: 6000}}\noperations:
  - {{name: rough, spindle_rpm: 780, feed_mm_per_min: 400, path: {{joints_deg: [[0, 90], [0, 150]]}}}}\n{}",
        robot.display(),
        policy("")
    );
    let check = |accept: &str, format: &str| {
        fs::write(folder.path().join("job.yaml"), format!("{job}{accept}")).unwrap();
        run(folder.path(), &["check", "job.yaml", "--format", format])
    };
    let entry = |keys: &str| {
        format!(
            "accept: [{{code: crossing, {keys}reason: ran without marks, until: 2999-12-31}}]\n"
        )
    };
    let verdict = |accept: &str| json(&check(accept, "json"))["verdict"].clone();
    assert_eq!(verdict(""), "resonance");
    assert_eq!(verdict(&entry("")), "clear");
    assert_eq!(verdict(&entry("mode: 1, operation: rough, ")), "clear");
    assert_eq!(verdict(&entry("mode: 2, ")), "resonance");
    let other = check(&entry("mode: 2, "), "text");
    assert!(err(&other).contains("there is no 'crossing' to accept"), "{}", err(&other));
    let text = check(&entry("mode: 1, "), "text");
    assert!(
        flat(&text).contains(" accepted until 2999-12-31: ran without marks"),
        "{}",
        out(&text)
    );
    let github = check(&entry("mode: 1, "), "github");
    assert!(out(&github).starts_with("::notice file=job.yaml"), "{}", out(&github));
    let sarif: Value = serde_json::from_str(out(&check(&entry(""), "sarif"))).unwrap();
    let results = sarif["runs"][0]["results"].as_array().unwrap();
    assert!(results.iter().all(|result| result["suppressions"][0]["status"] == "accepted"));
}

#[test]
fn warnings_can_be_denied_and_the_output_is_written_all_the_same() {
    let bench = Bench::new(MOVES_RAIL, &policy(""));
    for format in FORMATS {
        let ran = bench.check(&["--deny-warnings", "--format", format, "--fail-on", "never"]);
        assert_eq!(code(&ran), 1, "{format}");
        assert_eq!(out(&ran), out(&bench.check(&["--format", format, "--fail-on", "never"])));
        assert!(err(&ran).ends_with("failed: there were warnings (--deny-warnings)\n"));
    }
    assert_eq!(code(&Bench::new(STEADY, &policy("")).check(&["--deny-warnings"])), 0);
    let advise = run(bench.0.path(), &["--deny-warnings", "advise", "job.yaml"]);
    assert_eq!(code(&advise), 1, "{}", err(&advise));
    assert!(out(&advise).contains("doubt    rough.nc:3: E words"), "{}", out(&advise));
    assert_eq!(code(&run(bench.0.path(), &["advise", "job.yaml"])), 0);
    // Two rows in a line leave an interval of stiffness that holds zero.
    let loads = "angle_rad,moment_nm\n0,0\n1,3\n2,3\n";
    fs::write(bench.0.path().join("loads.csv"), loads).unwrap();
    for (arguments, expected) in
        [(&["stiffness", "loads.csv"][..], 0), (&["stiffness", "loads.csv", "--deny-warnings"], 1)]
    {
        let ran = run(bench.0.path(), arguments);
        assert_eq!(code(&ran), expected, "{}", err(&ran));
        assert!(out(&ran).contains("includes zero"));
    }
}

#[test]
fn a_verdict_about_nothing_fails_in_every_output() {
    let stopped = format!("M5\n{STEADY}");
    for (program, keys) in [
        (stopped.as_str(), policy("")),
        (STEADY, policy(", ignore_hz: [[0, 1000]]")),
        (STEADY, policy(", min_tip_response_um_per_n: 1e9")),
    ] {
        let bench = Bench::new(program, &keys);
        for (format, told) in [
            ("text", "UNCHECKED"),
            ("json", "\"verdict\": \"unchecked\""),
            ("junit", "type=\"unchecked\""),
            ("sarif", "\"ruleId\": \"unchecked\""),
            ("github", "detune check: job.yaml unchecked"),
            ("gitlab", "\"check_name\": \"unchecked\""),
            ("html", "class=\"verdict unchecked\""),
        ] {
            let ran = bench.check(&["--format", format]);
            assert_eq!(code(&ran), 1, "{format}: {}", out(&ran));
            assert!(out(&ran).contains(told), "{format}: {}", out(&ran));
            assert!(out(&ran).contains("nothing was checked"), "{format}: {}", out(&ran));
        }
        let accept = "accept: [{code: nothing_checked, reason: transport, until: 2999-12-31}]\n";
        let ran = Bench::new(program, &format!("{keys}{accept}")).check(&[]);
        assert_eq!(code(&ran), 0, "{}", out(&ran));
        assert!(out(&ran).starts_with("UNCERTAIN (1 accepted) "), "{}", out(&ran));
    }
}

/// What a program leaves open, or stops, is told where the verdict is read.
#[test]
fn a_stopped_spindle_two_lengths_and_no_unit_are_told_with_the_verdict() {
    let job = |program: &str, of_program: &str| {
        let bench = Bench::new(program, &policy(""));
        let path = bench.0.path().join("job.yaml");
        let job = fs::read_to_string(&path).unwrap();
        let job = job.replace("spindle_rpm: 24000, feed_mm_per_min: 400, ", "");
        let job = job.replace("{file: rough.nc}", &format!("{{file: rough.nc{of_program}}}"));
        fs::write(&path, job).unwrap();
        bench
    };
    let verdict = |program: &str, of_program: &str| {
        let found = job(program, of_program).json();
        let doubts: Vec<String> = found["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|warning| warning["hides_clear"] == true)
            .map(|warning| warning["code"].as_str().unwrap().to_owned())
            .collect();
        (found["verdict"].as_str().unwrap().to_owned(), doubts.join(" "))
    };
    let is = |verdict: &str, doubts: &str| (verdict.to_owned(), doubts.to_owned());
    let on = "G21 S24000 M3\nG0 X0 Y0 Z0\nG1 X240 F400\n";
    assert_eq!(verdict(&format!("{on}M5\nG0 Y40\n"), ""), is("clear", ""));
    assert_eq!(verdict(&format!("{on}M5\nY40\n"), ""), is("uncertain", "spindle_command"));
    // Nowhere to go.
    let still = "G21 S24000 M3\nG0 X0 Y0 Z0\nG1 X0 F400\n";
    assert_eq!(verdict(still, ""), is("unchecked", "nothing_checked"));
    // Never on: the job need not say a speed, and there is none to advise.
    let off = "G21 M5\nG0 X0 Y0 Z0\nG1 X240 F400\n";
    assert_eq!(verdict(off, ""), is("unchecked", "nothing_checked"));
    let bench = job(off, "");
    assert_eq!(code(&bench.check(&[])), 1);
    assert_eq!(bench.json()["operations"][0]["spindle_rpm"], 0.0);
    let advise = run(bench.0.path(), &["advise", "job.yaml"]);
    assert_eq!(code(&advise), 2, "{}", out(&advise));
    assert!(err(&advise).contains("has stopped the spindle on the whole path"), "{advise:?}");
    // Silent on the spindle: the speed is missing.
    let silent = run(job(STEADY, "").0.path(), &["check", "job.yaml"]);
    assert_eq!(code(&silent), 2);
    assert!(err(&silent).contains("missing key 'spindle_rpm'"), "{silent:?}");

    let tools = |second: u32| format!("G21\nT1 M6\n{on}T{second} M6\nM3\nG1 Y40\n");
    let keys = ", tool_frames: {1: {xyz_m: [0, 0, 0.15]}, 2: {xyz_m: [0, 0, 0.17]}}";
    assert_eq!(verdict(&tools(1), ""), is("clear", ""));
    let two = job(&tools(2), "");
    let path = two.0.path().join("job.yaml");
    let text = fs::read_to_string(&path).unwrap();
    let text = text
        .replace("tool: {teeth", "tools: {1: {teeth: 2, payload: none}, 2: {teeth")
        .replace("payload: none}\ntcp", "payload: none}}\ntcp");
    fs::write(&path, &text).unwrap();
    let found = two.json();
    assert_eq!(found["verdict"], "uncertain", "{found}");
    assert_eq!(found["warnings"][0]["code"], "change_ignored");
    fs::write(&path, text.replace("rough.nc}", &format!("rough.nc{keys}}}"))).unwrap();
    assert_eq!(two.json()["verdict"], "clear");

    let inches = "S24000 M3\nG0 X0 Y0 Z0\nG1 X2.5 F20\n";
    assert_eq!(verdict(inches, ""), is("uncertain", "unit_assumed"));
    for unit in ["mm", "inch"] {
        assert_eq!(verdict(inches, &format!(", unit: {unit}")), is("clear", ""));
    }
}

#[test]
fn a_schedule_that_ends_early_and_a_speed_of_many_zeros_are_told() {
    let bench = Bench::new(STEADY, &policy(""));
    let job = fs::read_to_string(bench.0.path().join("job.yaml")).unwrap();
    let with = |speed: &str| {
        let job = job.replace("spindle_rpm: 24000", speed);
        fs::write(bench.0.path().join("job.yaml"), job).unwrap();
    };
    let told = || {
        let found = bench.json()["warnings"].as_array().unwrap().clone();
        let texts = found.iter().map(|own| own["text"].as_str().unwrap().to_owned());
        texts.filter(|text| text.contains("spindle_schedule")).collect::<Vec<_>>()
    };
    with("spindle_schedule: [{s: 0.25, rpm: 24000}, {s: 0.5, rpm: 23000}]");
    let called = "job.yaml:7: operation 'rough': spindle_schedule";
    assert_eq!(
        told(),
        [
            format!(
                "{called} starts at s = 0.25 and says nothing before; 24000 rpm is taken to hold"
            ),
            format!("{called} ends at s = 0.5 and says nothing behind; 23000 rpm is taken to hold"),
        ]
    );
    with("spindle_schedule: [{s: 0, rpm: 24000}, {s: 1, rpm: 23000}]");
    assert!(told().is_empty());
    with("spindle_rpm: 1e-300");
    let refused = bench.check(&[]);
    assert_eq!(code(&refused), 2);
    assert!(err(&refused).contains("spindle_rpm is 1e-300, must lie in"), "{}", err(&refused));
}

/// A program of two moves with a tool of this load, and one under tool0.
fn with_load(load: &str) -> String {
    format!(
        "MODULE M\nCONST robtarget p:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
         PERS tooldata ta:=[TRUE,[[0,0,150],[1,0,0,0]],[{load},[1,0,0,0],0,0,0]];\nPROC main()\n\
         MoveL p,v5,fine,ta;\nMoveL Offs(p,9,0,0),v5,fine,ta;\nMoveL Offs(p,9,9,0),v5,fine,tool0;\n\
         ENDPROC\nENDMODULE\n"
    )
}

/// `payload: none` of the job is the load of moves of which the program states none.
#[test]
fn moves_without_a_load_carry_nothing_where_the_job_says_so() {
    let bench = Bench::new(STEADY, &policy(""));
    let job = bench.0.path().join("job.yaml");
    let of_job = fs::read_to_string(&job).unwrap();
    let of_job = of_job.replace("rough.nc", "rough.mod").replace(": 400", ": 300");
    fs::write(&job, of_job.replace(", payload: none}", "}\npayload: none")).unwrap();
    fs::write(bench.0.path().join("rough.mod"), with_load("1.5,[0,0,1]")).unwrap();
    let found = bench.json();
    let codes: Vec<_> =
        found["warnings"].as_array().unwrap().iter().map(|own| &own["code"]).collect();
    assert!(codes.iter().all(|code| **code != "payload_unknown"), "{found}");
    let sources: Vec<_> = found["operations"]
        .as_array()
        .unwrap()
        .iter()
        .map(|own| &own["payload"]["source"])
        .collect();
    assert_eq!(sources, ["program", "none"], "{found}");
    // The tool of the program is not nothing.
    assert!(codes.iter().any(|code| **code == "tool_mass_conflict"), "{found}");
}

/// RobotStudio gives every new tool 1 kg at [0, 0, 1] mm, which states nothing, and tool0 has no load; a load of
/// other moves says nothing of those under tool0.
#[test]
fn the_load_of_a_new_tool_leaves_no_doubt_about_others() {
    let bench = Bench::new(STEADY, &policy(""));
    let job = bench.0.path().join("job.yaml");
    let of_job = fs::read_to_string(&job).unwrap();
    let of_job = of_job.replace("rough.nc", "rough.mod").replace(": 400", ": 300");
    // With a tcp of the job, lines with tool0 beside those with `ta` would be a doubt.
    fs::write(&job, of_job.replace("tcp: {xyz_m: [0, 0, 0.15]}\n", "")).unwrap();
    for (load, verdict) in [("1,[0,0,1]", "clear"), ("1.5,[0,0,1]", "uncertain")] {
        fs::write(bench.0.path().join("rough.mod"), with_load(load)).unwrap();
        let found = bench.json();
        let doubts = found["warnings"].as_array().unwrap().iter();
        let doubts = doubts.filter(|own| own["code"] == "payload_unknown").count();
        assert_eq!(
            (found["verdict"].as_str(), doubts > 0),
            (Some(verdict), verdict != "clear"),
            "{found}"
        );
    }
}
