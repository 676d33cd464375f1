//! What programs state beside their motion: what the arm carries, spindle speeds, tools.

use std::fs;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{code, err, out, repository, run};

fn robot() -> String {
    repository().join("robots/irb1600/robot.yaml").display().to_string()
}

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        let program = fs::read_to_string(repository().join("jobs/contour.mod")).unwrap();
        bench.add("contour.mod", &program);
        bench.add("bare.mod", &program.replace("[4.2, [0, 0, 70]", "[0.001, [0, 0, 0.001]"));
        bench
    }

    fn add(&self, file: &str, text: &str) {
        fs::write(self.0.path().join(file), text).unwrap();
    }

    fn read(&self, file: &str) -> String {
        fs::read_to_string(self.0.path().join(file)).unwrap()
    }

    fn run(&self, arguments: &[&str]) -> Output {
        run(self.0.path(), arguments)
    }

    fn check(&self, job: &str) -> Value {
        self.add("job.yaml", job);
        let ran = self.run(&["check", "job.yaml", "--format", "json", "--fail-on", "never"]);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        serde_json::from_slice(&ran.stdout).unwrap()
    }
}

fn contour(rpm: f64, program: &str, payload: &str) -> String {
    format!(
        "robot: {}\ntool: {{teeth: 3, diameter_mm: 8}}\n{payload}spindle: {{min_rpm: 500, max_rpm: 24000}}\n\
         operations:\n  - name: contour\n    spindle_rpm: {rpm}\n    feed_mm_per_min: 600\n    path: {{program: {{file: \
         {program}}}}}\npolicy: {{separation_percent: 5, model_uncertainty_percent: 5}}\n",
        robot()
    )
}

/// The tool that the program declares is carried: 4.2 kg turn the verdict both ways.
#[test]
fn the_tool_that_the_program_declares_is_part_of_the_model() {
    let bench = Bench::new();
    for (rpm, bare, carrying) in [(780.0, "resonance", "clear"), (3000.0, "clear", "resonance")] {
        let found = bench.check(&contour(rpm, "bare.mod", "payload: none\n"));
        assert_eq!(found["verdict"], bare, "{rpm}");
        assert_eq!(found["jobs"][0]["model"]["payload"]["source"], "none");
        let found = bench.check(&contour(rpm, "contour.mod", ""));
        assert_eq!(found["verdict"], carrying, "{rpm}");
        let payload = serde_json::json!({"mass_kg": 4.2, "source": "program"});
        assert_eq!(found["jobs"][0]["model"]["payload"], payload);
        if carrying == "clear" {
            let closest = &found["jobs"][0]["operations"][0]["closest"]["separation_percent"];
            assert!((closest.as_f64().unwrap() - 26.6).abs() < 0.05, "{closest}");
        }
        // The same body by the job.
        let body = "payload: {mass_kg: 4.2, com_m: [0, 0, 0.07]}\n";
        let of_job = bench.check(&contour(rpm, "bare.mod", body));
        let modes = |found: &Value| {
            found["jobs"][0]["operations"][0]["samples"][0]["natural_frequencies_hz"].clone()
        };
        assert_eq!((modes(&of_job), of_job["verdict"].as_str()), (modes(&found), Some(carrying)));
        assert_eq!(of_job["jobs"][0]["model"]["payload"]["source"], "job");
    }
}

/// Where nobody says what is carried, no speed is clear; what to write is said, and speeds are advised.
#[test]
fn what_nobody_says_is_at_best_uncertain() {
    let bench = Bench::new();
    let found = bench.check(&contour(3000.0, "bare.mod", ""));
    assert_eq!(found["verdict"], "uncertain");
    let payload = serde_json::json!({"mass_kg": 0.0, "source": "unknown"});
    assert_eq!(found["jobs"][0]["model"]["payload"], payload);
    assert!(found["jobs"][0]["notices"][0].as_str().unwrap().contains("payload: none"));
    for verb in ["check", "advise"] {
        let ran = bench.run(&[verb, "job.yaml"]);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        for text in [out(&ran), err(&ran)] {
            assert!(text.contains("payload: {mass_kg: …, com_m: […]} or payload: none"), "{text}");
        }
    }
    for format in ["sarif", "junit", "github"] {
        let ran = bench.run(&["check", "job.yaml", "--format", format, "--fail-on", "uncertain"]);
        assert_eq!(code(&ran), 1, "{format}: {}", out(&ran));
    }
    let resonant = bench.check(&contour(780.0, "bare.mod", ""));
    assert_eq!(resonant["verdict"], "resonance");
}

const TWO_TOOLS: &str = "T1 M6\nS12000 M3\nG0 X800 Y0 Z600\nG1 X850 F1200\nX900\nM5\nT2 M6\nS800 M3\nG1 X950 F400\n\
                         X800\nM5\nM30\n";

/// Two tools of one length.
const PATH: &str = "    path: {program: {file: p.nc, tool_frames: {1: {xyz_m: [0, 0, 0]}, 2: {xyz_m: [0, 0, 0]}}}}\n";

fn two_tools(more: &str, operation: &str) -> String {
    format!(
        "robot: {}\n{more}payload: {{mass_kg: 4.2, com_m: [0, 0, 0.07]}}\nspindle: {{min_rpm: 500, max_rpm: 24000}}\n\
         operations:\n  - name: part\n{operation}{PATH}policy: {{separation_percent: 3, \
         model_uncertainty_percent: 2}}\n",
        robot()
    )
}

/// Each stretch of a program is checked with its own tool and at its own speed, as if it were alone.
#[test]
fn a_program_with_two_tools_and_speeds_is_checked_stretch_by_stretch() {
    let bench = Bench::new();
    bench.add("p.nc", TWO_TOOLS);
    let tools = "tools: {1: {teeth: 3}, 2: {teeth: 2}}\n";
    let found = bench.check(&two_tools(tools, ""));
    let operations = found["jobs"][0]["operations"].as_array().unwrap();
    let listed: Vec<_> = operations
        .iter()
        .map(|o| (o["name"].as_str().unwrap(), o["spindle_rpm"].as_f64(), o["tool"].as_u64()))
        .collect();
    let expected = [("part", Some(12_000.0), Some(1)), ("part/2", Some(800.0), Some(2))];
    assert_eq!(listed, expected);
    // 800 rpm with two teeth lie on a mode: 12000 rpm over both would be clear.
    assert_eq!(
        (&operations[0]["verdict"], &operations[1]["verdict"]),
        (&"clear".into(), &"resonance".into())
    );
    assert_eq!(found["verdict"], "resonance");
    let joints = |o: &Value, end: usize| {
        let samples = o["samples"].as_array().unwrap();
        samples[end * (samples.len() - 1)]["joints_rad"].clone()
    };
    assert_eq!(joints(&operations[0], 1), joints(&operations[1], 0));

    bench.add("job.yaml", &two_tools("tool: {teeth: 2}\n", "    spindle_rpm: 12000\n"));
    let ran = bench.run(&["check", "job.yaml"]);
    assert_eq!(code(&ran), 2);
    for said in [
        "job.yaml:7: operation 'part': spindle_rpm is 12000",
        "p.nc:8 commands 800 rpm",
        "tools: {1: ",
    ] {
        assert!(err(&ran).contains(said), "{}", err(&ran));
    }
}

/// Each stretch of the program gets its own speed, and the feed follows the speed that the program ran at.
#[test]
fn advice_is_written_into_each_stretch_of_the_program() {
    let bench = Bench::new();
    bench.add("p.nc", TWO_TOOLS);
    bench.add("job.yaml", &two_tools("tools: {1: {teeth: 3}, 2: {teeth: 2}}\n", ""));
    let advise = ["advise", "job.yaml", "--format", "json", "--write", "new.yaml"];
    let ran = bench.run(&advise);
    assert_eq!(code(&ran), 2, "{}", out(&ran));
    assert!(err(&ran).contains("--write-program"), "{}", err(&ran));
    assert!(!bench.0.path().join("new.yaml").exists());
    let ran = bench.run(&[&advise[..], &["--write-program", "new.nc"]].concat());
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    let advice: Value = serde_json::from_slice(&ran.stdout).unwrap();
    let rpm = |i: usize| advice["operations"][i]["recommended_rpm"].as_f64().unwrap();
    assert_eq!((rpm(0), advice["operations"].as_array().unwrap().len()), (12_000.0, 2));
    assert_ne!(rpm(1), 800.0);
    let feed = (400.0 * rpm(1) / 800.0 * 1e3).round() / 1e3;
    let expected =
        TWO_TOOLS.replace("S800", &format!("S{}", rpm(1))).replace("F400", &format!("F{feed}"));
    assert_eq!(bench.read("new.nc"), expected);
    let ran = bench.run(&["check", "new.yaml", "--fail-on", "uncertain"]);
    assert_eq!(code(&ran), 0, "{}{}", out(&ran), err(&ran));
}

/// A speed of the job beside another of the program does not multiply the chip load.
#[test]
fn a_program_that_cannot_be_rewritten_is_an_error() {
    let bench = Bench::new();
    bench.add("job.yaml", &contour(3000.0, "contour.mod", ""));
    let ran =
        bench.run(&["advise", "job.yaml", "--write", "new.yaml", "--write-program", "new.mod"]);
    assert_eq!(code(&ran), 2, "{}", out(&ran));
    assert!(err(&ran).contains("RAPID has no instruction for the spindle"), "{}", err(&ran));
    assert!(!bench.0.path().join("new.yaml").exists() && !bench.0.path().join("new.mod").exists());
}

/// By what sets the spindle: a group output takes whole numbers of its unit, an analog one any; data
/// that another procedure uses change for it, too, and that is told.
#[test]
fn advice_is_written_in_the_units_of_what_sets_the_spindle() {
    let bench = Bench::new();
    let program = bench.read("contour.mod");
    let (head, body) = program.split_once("PROC main()").unwrap();
    let sets = |by: &str| {
        format!(
            "{head}CONST num nS:=30;\nPROC main()\n{by}{body}",
            body = body.replace("ENDMODULE", "PROC two()\nSetGO goS, nS;\nENDPROC\nENDMODULE")
        )
    };
    let job = |signal: &str, per_unit: &str| {
        let job = contour(3000.0, "p.mod", "assume: {nS: 5, nowhere: 1}\n");
        let by = format!("p.mod, spindle_from: {{signal: {signal}, rpm_per_unit: {per_unit}}}");
        job.replace("    spindle_rpm: 3000\n    feed_mm_per_min: 600\n", "").replace("p.mod", &by)
    };
    for (by, signal, per_unit, value, step) in [
        ("SetGO goS, nS;", "goS", "100", "nS:=30", 100.0),
        ("SetAO aoS, 0.3;", "aoS", "10000", "aoS, 0.3", 0.0),
    ] {
        bench.add("p.mod", &sets(by));
        bench.add("job.yaml", &job(signal, per_unit));
        let ran = bench.run(&[
            "advise",
            "job.yaml",
            "--format",
            "json",
            "--write",
            "new.yaml",
            "--write-program",
            "new.mod",
        ]);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let advice: Value = serde_json::from_slice(&ran.stdout).unwrap();
        let rpm = advice["operations"][0]["recommended_rpm"].as_f64().unwrap();
        assert!(rpm != 3000.0 && (step == 0.0 || rpm % step == 0.0), "{rpm}");
        let new = value.replace("30", &(rpm / 100.0).to_string());
        let new = new.replace("0.3", &(rpm / 10_000.0).to_string());
        assert!(bench.read("new.mod").contains(&new), "{new}: {}", bench.read("new.mod"));
        let steps =
            "operation 'contour': what sets the spindle takes whole numbers of 100 rpm each";
        let shared = "'nS' changes for line";
        for said in [steps, shared] {
            assert_eq!(err(&ran).contains(said), step > 0.0, "{}", err(&ran));
        }
        let unused = "assume: 'nowhere' stands in no program that the job runs";
        assert!(err(&ran).contains(unused) && !err(&ran).contains("assume: 'nS'"), "{}", err(&ran));
        let ran = bench.run(&["check", "new.yaml", "--format", "json", "--fail-on", "resonance"]);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let found: Value = serde_json::from_slice(&ran.stdout).unwrap();
        assert_eq!(found["jobs"][0]["operations"][0]["spindle_rpm"], rpm);
    }
}

/// Two operations run two procedures of one module: both are written into one file.
#[test]
fn advice_for_two_procedures_is_written_into_one_module() {
    let bench = Bench::new();
    let program = bench.read("contour.mod");
    let (head, body) = program.split_once("PROC main()").unwrap();
    let (body, end) = body.split_once("ENDPROC").unwrap();
    let procedure = |name: &str| format!("PROC {name}()\nSetAO aoS, 3000;{body}ENDPROC\n");
    bench.add("p.mod", &format!("{head}{}{}{}", procedure("one"), procedure("two"), &end));
    let job = contour(3000.0, "p.mod", "").replace("    spindle_rpm: 3000\n", "");
    let job = job.replace("    feed_mm_per_min: 600\n", "");
    let of = |procedure: &str| {
        let by = "spindle_from: {signal: aoS, rpm_per_unit: 1}";
        format!("    path: {{program: {{file: p.mod, procedure: {procedure}, {by}}}}}\n")
    };
    let two = format!("{}  - name: second\n{}", of("one"), of("two"));
    let job = job.replace("    path: {program: {file: p.mod}}\n", &two);
    bench.add("job.yaml", &job);
    let ran = bench.run(&[
        "advise",
        "job.yaml",
        "--format",
        "json",
        "--write",
        "new.yaml",
        "--write-program",
        "new.mod",
    ]);
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    let advice: Value = serde_json::from_slice(&ran.stdout).unwrap();
    let rpm = advice["operations"][1]["recommended_rpm"].as_f64().unwrap();
    let written = bench.read("new.mod");
    assert_eq!(written.matches(&format!("SetAO aoS, {rpm};")).count(), 2, "{rpm}: {written}");
    let ran = bench.run(&["check", "new.yaml", "--fail-on", "resonance"]);
    assert_eq!(code(&ran), 0, "{}{}", out(&ran), err(&ran));
}

/// What is wrong with a path is wrong once, however often its program changes speed.
#[test]
fn the_errors_of_a_divided_path_are_listed_once() {
    let bench = Bench::new();
    bench.add("p.nc", &TWO_TOOLS.replace("G1 X850", "G1 X9850"));
    bench.add("job.yaml", &two_tools("tools: {1: {teeth: 3}, 2: {teeth: 2}}\n", ""));
    for verb in ["check", "advise"] {
        let ran = bench.run(&[verb, "job.yaml"]);
        assert_eq!(code(&ran), 2);
        let errors: Vec<&str> = err(&ran).lines().filter(|l| l.starts_with("error: ")).collect();
        assert_eq!(errors.len(), 1, "{}", err(&ran));
        assert!(
            errors[0].starts_with("error: p.nc:4: operation 'part': waypoint 2"),
            "{}",
            errors[0]
        );
    }
}

/// Stretches are called after their operation: no other operation may be.
#[test]
fn names_of_stretches_are_not_taken() {
    let bench = Bench::new();
    bench.add("p.nc", TWO_TOOLS);
    let job = two_tools("tools: {1: {teeth: 3}, 2: {teeth: 2}}\n", "");
    let other = |name: &str| job.replace(PATH, &format!("{PATH}  - name: {name}\n{PATH}"));
    bench.add("job.yaml", &other("part/2"));
    let ran = bench.run(&["check", "job.yaml"]);
    assert_eq!(code(&ran), 2);
    let told = "error: job.yaml:8: operation 'part/2': so is a stretch of operation 'part' (line 6) called";
    assert!(err(&ran).contains(told), "{}", err(&ran));
    for name in ["part/top", "part2", "parts/2"] {
        bench.add("job.yaml", &other(name));
        let ran = bench.run(&["check", "job.yaml", "--fail-on", "never"]);
        assert_eq!(code(&ran), 0, "{name}: {}", err(&ran));
    }
    // What is accepted in an operation is accepted in its stretches, and in no other operation.
    let accept = "accept: [{code: crossing, operation: part, reason: a, until: 2999-12-31}]\n";
    let found = bench.check(&format!("{}{accept}", other("part/top")));
    let accepted: Vec<(&str, bool)> = found["jobs"][0]["operations"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|o| o["crossings"].as_array().unwrap().iter().map(move |c| (o, c)))
        .map(|(o, c)| (o["name"].as_str().unwrap(), c["accepted"].is_object()))
        .collect();
    assert!(accepted.contains(&("part/2", true)), "{accepted:?}");
    assert!(accepted.contains(&("part/top/2", false)), "{accepted:?}");
}

/// 10 mm and a turn of 20° take the longer of 10 mm at 100 mm/s (0.1 s) and 20° at the speed of turning.
#[test]
fn a_turn_takes_as_long_as_its_own_speed_says() {
    let bench = Bench::new();
    let seconds = |file: &str, text: &str| {
        bench.add(file, text);
        let job = contour(780.0, file, "payload: none\nspeeds_from: job\n");
        let job = job.replace("    feed_mm_per_min: 600\n", "");
        bench.check(&job)["jobs"][0]["operations"][0]["duration_s"].as_f64().unwrap()
    };
    let data = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let rapid = |before: &str, speed: &str, x: f64| {
        let text = format!(
            "MODULE m\nPROC main()\nConfL \\Off;\nMoveL [[900,0,800],[0,0,1,0],{data},v100,fine,tool0;\n\
             {before}\nMoveL [[{x},0,800],[0.17364818,0,0.98480775,0],{data},{speed},fine,tool0;\n\
             ENDPROC\nENDMODULE\n"
        );
        seconds("a.mod", &text)
    };
    let krl = |before: &str, motion: &str| {
        let text = format!(
            "DEF p()\n$VEL.CP=0.1\nPTP {{X 900,Y 0,Z 800,A 0,B 180,C 0}}\n{before}\n{motion}\nEND\n"
        );
        seconds("a.src", &text)
    };
    let line = "LIN {X 910,Y 0,Z 800,A 0,B 160,C 0}";
    // Half a circle of 5 mm is 15.7 mm long.
    let arc = "CIRC {X 905,Y 5,Z 800,A 0,B 170,C 0},{X 910,Y 0,Z 800,A 0,B 160,C 0}";
    for (found, expected) in [
        (rapid("", "[100,10,5000,1000]", 910.0), 2.0),
        (rapid("", "[100,400,5000,1000]", 910.0), 0.1),
        (rapid("", "[100,10,5000,1000]\\V:=50", 910.0), 2.0),
        (rapid("", "[100,10,5000,1000]\\T:=3", 910.0), 3.0),
        (rapid("VelSet 50,1000;", "[100,10,5000,1000]", 910.0), 4.0),
        // The point stands still.
        (rapid("", "[100,10,5000,1000]", 900.0), 2.0),
        (krl("", line), 0.1),
        (krl("$VEL.ORI1=20", line), 1.0),
        (krl("$VEL.ORI1=20\n$VEL.ORI2=10", line), 2.0),
        (krl("$VEL={CP 0.1,ORI1 20,ORI2 10}\n$OV_PRO=50", line), 4.0),
        (krl("$VEL.ORI1=10", arc), 2.0),
        (krl("$VEL.ORI1=DEF_VEL_ORI1", line), 0.1),
    ] {
        assert!((found - expected).abs() < 1e-6, "found {found} s, expected {expected} s");
    }
}

/// A program that a list or a folder names has its lines in the file where it starts.
#[test]
fn lines_of_a_list_are_those_of_the_file_where_it_starts() {
    let bench = Bench::new();
    fs::create_dir(bench.0.path().join("cell")).unwrap();
    bench.add("cell/start.mod", &bench.read("contour.mod"));
    bench.add("cell/Data.mod", "MODULE Data\nENDMODULE\n");
    let list = "<?xml version=\"1.0\"?>\n<Program><Module>Data.mod</Module><Module>start.mod</Module></Program>\n";
    bench.add("cell/all.pgf", list);
    for named in ["cell/all.pgf", "cell"] {
        let found = bench.check(&contour(3000.0, named, "payload: none\n"));
        let crossing = &found["jobs"][0]["operations"][0]["crossings"][0];
        assert_eq!(crossing["file"], "cell/start.mod", "{named}: {crossing}");
        let ran = bench.run(&["check", "job.yaml", "--fail-on", "never"]);
        let text = out(&ran);
        assert!(text.contains("cell/start.mod:") && !text.contains("all.pgf:"), "{text}");
    }
}
