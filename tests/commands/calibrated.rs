//! Verdicts of calibrated robots: a calibration vouches for the model that was calibrated, by a table that fits, and for
//! what the tip carried then.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{code, err, json, out, repository, run};

/// An arm that carries 3 kg more than its file says, and its calibration by twelve poses.
struct Calibrated {
    folder: TempDir,
    robot: String,
    urdf: String,
}

impl Calibrated {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let own = repository().join("robots/irb1600");
        let read = |name: &str| fs::read_to_string(own.join(name)).unwrap();
        let (robot, urdf) = (read("robot.yaml"), read("irb1600.urdf"));
        let carrying = |kg: u32| format!("{robot}payload: {{link: tool0, mass_kg: {kg}}}\n");
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("irb1600.urdf", &urdf);
        write("truth.yaml", &carrying(8));
        write("robot.yaml", &carrying(5));
        let map = run(folder.path(), &["map", "truth.yaml", "--random", "12", "--seed", "3"]);
        assert_eq!(code(&map), 0, "{}", err(&map));
        // Without the column of β2.
        let row = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            [&cells[..6], &cells[7..]].concat().join(",") + "\n"
        };
        write("measured.csv", &out(&map).lines().map(row).collect::<String>());
        let arguments = ["diagnose", "robot.yaml", "measured.csv", "--write", "calibrated.yaml"];
        let ran = run(folder.path(), &arguments);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let robot = fs::read_to_string(folder.path().join("calibrated.yaml")).unwrap();
        assert!(robot.contains("cause: payload"), "{robot}");
        Self { folder, robot, urdf }
    }

    /// The verdict of a job of two poses far above all modes, and the codes and texts of its warnings.
    fn verdict(&self, robot: &str, urdf: &str, keys: &str) -> (String, Vec<[String; 2]>) {
        let write = |name: &str, text: &str| {
            fs::write(self.folder.path().join(name), text).unwrap();
        };
        write("irb1600.urdf", urdf);
        write("calibrated.yaml", robot);
        write(
            "job.yaml",
            &format!(
                "robot: calibrated.yaml\ntool: {{teeth: 2}}\nspindle: {{min_rpm: 500, max_rpm: 90000}}\n\
                 operations:\n  - {{name: a, spindle_rpm: 90000, feed_mm_per_min: 400, path: {{joints_deg: \
                 [[0, 20, -10, 0, 60, 0], [5, 22, -12, 0, 60, 0]]}}}}\npolicy: {{tooth_passing_harmonics: 1, \
                 spindle_harmonics: 0, min_tip_response_um_per_n: 0}}\n{keys}"
            ),
        );
        let ran = run(self.folder.path(), &["check", "job.yaml", "--format", "json"]);
        let found = json(&ran);
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let warnings = found["jobs"][0]["warnings"].as_array().unwrap().iter();
        let warnings = warnings.map(|own| [text(&own["code"]), text(&own["text"])]);
        (text(&found["verdict"]), warnings.collect())
    }

    fn changed(&self, from: &str, to: &str) -> String {
        assert!(self.robot.contains(from), "{}", self.robot);
        self.robot.replacen(from, to, 1)
    }
}

#[test]
fn a_calibration_vouches_for_the_model_that_was_measured() {
    let arm = Calibrated::new();
    let as_it_was = arm.verdict(&arm.robot, &arm.urdf, "");
    assert_eq!(as_it_was, ("clear".to_owned(), vec![]));
    // Comments and what is no number of the model change nothing.
    let renamed = arm.changed("name: ABB IRB 1600-x/1.45", "name: Cell 3  # ours");
    assert_eq!(arm.verdict(&renamed, &arm.urdf, "").0, "clear");
    let told = |robot: &str, urdf: &str, keys: &str, code: &str, what: &str| {
        let (verdict, warnings) = arm.verdict(robot, urdf, keys);
        assert_eq!(verdict, "uncertain", "{what}");
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert_eq!(warnings[0][0], code);
        assert!(warnings[0][1].contains(what), "{warnings:?}");
    };
    let heavier = arm.urdf.replace("<mass value=\"33.68\"/>", "<mass value=\"43.68\"/>");
    assert_ne!(heavier, arm.urdf);
    told(&arm.robot, &heavier, "", "calibration", "masses or dimensions were changed after");
    let stiffer = arm.changed("stiffness_nm_per_rad: 138000", "stiffness_nm_per_rad: 276000");
    told(&stiffer, &arm.urdf, "", "calibration", "springs were changed after the calibration");
    told(&stiffer, &arm.urdf, "", "calibration", "K is 2 times as much at joint_3");
    let swapped = stiffer.replace(": 276000", ": 555000").replacen(": 555000", ": 138000", 1);
    told(&swapped, &arm.urdf, "", "calibration", "times as much at joint_2, 4.0217 times");
    let rms = arm.robot.find("heldout_rms_percent: ").unwrap();
    let end = rms + arm.robot[rms..].find(',').unwrap();
    let poor = format!("{}heldout_rms_percent: 10.94{}", &arm.robot[..rms], &arm.robot[end..]);
    told(&poor, &arm.urdf, "", "calibration", "is 10.94, more than the 5.1 %");

    let doubtful = arm.changed("heldout_rms_percent:", "doubtful: true, heldout_rms_percent:");
    told(&doubtful, &arm.urdf, "", "calibration", "far better than they predicted poses left out");

    // The 3 kg that were found do not go away with a payload that the job repeats.
    let same = "payload: {mass_kg: 5, com_m: [0, 0, 0]}\n";
    told(&arm.robot, &arm.urdf, same, "tool_mass_conflict", "where it states 5 kg");
    told(&arm.robot, &arm.urdf, "payload: none\n", "tool_mass_conflict", "a payload of 0 kg");
    let in_all = "payload: {mass_kg: 8, com_m: [0, 0, 0]}\n";
    assert_eq!(arm.verdict(&arm.robot, &arm.urdf, in_all).0, "clear");
}

/// What corrections found at the tip does not go away with a tool that the program declares, whether or not the job
/// repeats its mass.
#[test]
fn a_programs_tool_takes_no_found_mass_away_in_silence() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| fs::read_to_string(repository().join(name)).unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("contour.mod", &read("jobs/contour.mod"));
    write("irb1600.urdf", &read("robots/irb1600/irb1600.urdf"));
    write(
        "robot.yaml",
        &(read("robots/irb1600/robot.yaml")
            + "payload: {link: tool0, mass_kg: 4.2}\ncorrections:\n  - {cause: payload, at: tool0, parameters: \
               {mass_kg: 3}}\n"),
    );
    let job = read("jobs/contour.yaml").replace("../robots/irb1600/robot.yaml", "robot.yaml");
    for own in ["", "payload: {mass_kg: 4.2, com_m: [0, 0, 0.07]}\n"] {
        write("job.yaml", &format!("{job}{own}"));
        let found = json(&run(folder.path(), &["check", "job.yaml", "--format", "json"]));
        let warnings = found["jobs"][0]["warnings"].as_array().unwrap().iter();
        let texts = warnings.filter(|own| own["code"] == "tool_mass_conflict");
        let texts: Vec<&str> = texts.map(|own| own["text"].as_str().unwrap()).collect();
        assert_eq!(texts.len(), 1, "{found}");
        assert!(texts[0].contains("4.2 kg takes the place of the 7.2 kg"), "{texts:?}");
    }
}

/// A figure that somebody typed measures no spring.
#[test]
fn a_guessed_spring_stays_a_guess_until_a_table_judged_it() {
    let folder = tempfile::tempdir().unwrap();
    let arm = repository().join("robots/irb1600");
    let own = fs::read_to_string(arm.join("robot.yaml")).unwrap();
    let urdf = format!("urdf: {}", arm.join("irb1600.urdf").display());
    let guessed = own
        .replace("urdf: irb1600.urdf", &urdf)
        .replace("{stiffness_nm_per_rad: 50000,", "{stiffness_nm_per_rad: 50000, assumed: true,");
    assert_ne!(own, guessed);
    let robot = guessed + "calibration: {poses: 20, heldout_rms_percent: 1}\n";
    fs::write(folder.path().join("robot.yaml"), robot).unwrap();
    fs::write(
        folder.path().join("job.yaml"),
        "robot: robot.yaml\ntool: {teeth: 2}\npayload: none\nspindle: {min_rpm: 500, max_rpm: 90000}\noperations:\n  - \
         {name: a, spindle_rpm: 90000, feed_mm_per_min: 400, path: {joints_deg: [[0, 20, -10, 0, 60, 0], \
         [5, 22, -12, 0, 60, 0]]}}\npolicy: {tooth_passing_harmonics: 1, spindle_harmonics: 0}\n",
    )
    .unwrap();
    let found = json(&run(folder.path(), &["check", "job.yaml", "--format", "json"]));
    assert_eq!(found["verdict"], "uncertain", "{found}");
    assert_eq!(found["jobs"][0]["warnings"][0]["code"], "assumed_spring");
}

#[test]
fn the_doctor_shows_what_a_check_takes_springs_to_be_off_by() {
    let arm = Calibrated::new();
    let spring = |robot: &str| {
        fs::write(arm.folder.path().join("robot.yaml"), robot).unwrap();
        let told = run(arm.folder.path(), &["doctor", "robot.yaml"]);
        assert_eq!(code(&told), 0, "{}", err(&told));
        let line = out(&told).lines().find(|line| line.contains("joint_4: ")).unwrap();
        (line.to_owned(), out(&told).contains("frequencies within ± 10 %"))
    };
    let stated = |robot: &str| robot.replace("60000, ", "60000, std_percent: 69, ");
    let bare = fs::read_to_string(repository().join("robots/irb1600/robot.yaml")).unwrap();
    let (line, is_share) = spring(&bare);
    assert!(is_share && !line.contains('±'), "{line}");
    let (line, is_share) = spring(&stated(&bare));
    assert!(!is_share && line.ends_with("± 69 %"), "{line}");
    let (line, is_share) = spring(&bare.replace("50000, ", "50000, std_percent: 69, "));
    assert!(!is_share && line.ends_with("± 10 % assumed"), "{line}");
    // What the file says of the spring, the calibration has learned better.
    let (line, is_share) = spring(&stated(&arm.robot));
    assert!(!is_share && line.contains('±'), "{line}");
    assert!(!line.contains("69 %") && !line.contains("assumed"), "{line}");
}
