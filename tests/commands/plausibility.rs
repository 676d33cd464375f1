//! Robots that cannot be: each warning on an IRB 1600 with one thing made absurd, and none without.

use std::fs;
use std::path::Path;
use std::time::SystemTime;

use detune::input::{Reading, read_described_robot, read_robot};
use detune::modes::Modes;
use detune::notes::{Code, Note};
use detune::progress::silent;
use detune::study::check::ReadJobs;
use detune::units::Date;

use crate::program::{code, err, json, repository, run};

fn original(file: &str) -> String {
    fs::read_to_string(repository().join("robots/irb1600").join(file)).unwrap()
}

/// The robot's warnings, or its errors.
fn warnings(yaml: &str, urdf: &str) -> Result<Vec<Note>, Vec<Note>> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("irb1600.urdf"), urdf).unwrap();
    let path = folder.path().join("robot.yaml");
    fs::write(&path, yaml).unwrap();
    let mut reading = Reading::default();
    read_robot(&path, &mut reading).map(|_| reading.warnings)
}

fn with_inertials(inertials: &[(&str, &str)]) -> String {
    let mut yaml = original("robot.yaml") + "inertials:\n";
    for (link, given) in inertials {
        yaml.push_str(&format!("  {link}: {{{given}}}\n"));
    }
    yaml
}

fn assert_doubt(yaml: &str, urdf: &str, code: Code, line: &str, says: &[&str]) {
    let found = warnings(yaml, urdf).unwrap();
    let [note] = &found[..] else { panic!("{says:?} is not alone in {found:#?}") };
    assert_eq!(note.code, code, "{note}");
    for says in says {
        assert!(note.what.contains(says), "{says:?} is not in {note}");
    }
    let file = note.place.file.as_deref().unwrap();
    let text = if file.ends_with("robot.yaml") { yaml } else { urdf };
    let told = text.lines().nth(note.place.line.unwrap() - 1).unwrap();
    assert!(told.contains(line), "{told:?} is not the line of {line:?}: {note}");
}

#[test]
fn the_robots_of_the_repository_are_plausible() {
    for robot in ["irb1600/robot", "irb1600/planar", "rail-mill/robot", "two-link/robot"] {
        let path = repository().join(format!("robots/{robot}.yaml"));
        let mut reading = Reading::default();
        read_robot(&path, &mut reading).unwrap();
        assert_eq!(reading.warnings, [], "{robot}");
    }
}

#[test]
fn an_inertia_of_another_unit_is_doubted() {
    let urdf = original("irb1600.urdf");
    let small = |links: usize| {
        let links: Vec<String> = (1..=links).map(|i| format!("link_{i}")).collect();
        let moments = "inertia_kgm2: {ixx: 1e-5, iyy: 1e-5, izz: 1e-5}";
        let all: Vec<_> = links.iter().map(|link| (link.as_str(), moments)).collect();
        with_inertials(&all)
    };
    assert_eq!(warnings(&small(1), &urdf).unwrap(), []);
    // 0.4 · 70 kg · (0.75 · 70 kg / (π · 11 340 kg/m³))^(2/3) = 0.3626 kg·m².
    let says = [
        "denser than lead: link_1, link_2, link_3, link_4; link_1, 70 kg,",
        "a ball of lead has 0.363; are the inertias in kg·m²?",
    ];
    assert_doubt(&small(4), &urdf, Code::CadUnits, "<robot", &says);
    // A rod of steel, 33.68 kg and 0.6 m long: thin, but a body that there is.
    let rod = with_inertials(&[("link_3", "inertia_kgm2: {ixx: 0.038, iyy: 1.03, izz: 1.03}")]);
    assert_eq!(warnings(&rod, &urdf).unwrap(), []);
}

#[test]
fn a_spring_of_another_unit_is_doubted() {
    let urdf = original("irb1600.urdf");
    let yaml = original("robot.yaml");
    let line = yaml.lines().find(|line| line.contains("joint_5: {")).unwrap();
    let with = |stiffness: &str| {
        let (key, rest) = line.split_once("stiffness_nm_per_rad: ").unwrap();
        let after = rest.find([',', '}']).unwrap();
        yaml.replace(line, &format!("{key}stiffness_nm_per_rad: {stiffness}{}", &rest[after..]))
    };
    let says = ["is it in N·m/rad?", "elasticity.rigid"];
    for stiffness in ["5e8", "50"] {
        assert_doubt(&with(stiffness), &urdf, Code::StiffnessScale, "joint_5: {", &says);
    }
    assert_eq!(warnings(&with("5e6"), &urdf).unwrap(), []);
}

#[test]
fn springs_in_two_halves_out_of_scale_are_told_once() {
    let urdf = original("irb1600.urdf");
    let scaled = |[soft, stiff]: [&str; 2]| {
        let line = |line: &str| {
            let (key, rest) = line.split_once("stiffness_nm_per_rad: ")?;
            let own = if key.contains('1') || key.contains('2') || key.contains('3') {
                stiff
            } else {
                soft
            };
            Some(format!("{key}stiffness_nm_per_rad: {own}{}", &rest[rest.find(',')?..]))
        };
        let yaml = original("robot.yaml");
        yaml.lines().map(|own| line(own).unwrap_or_else(|| own.to_owned()) + "\n").collect()
    };
    let yaml: String = scaled(["120000", "280000000"]);
    let says = [
        "joint_1, joint_2, joint_3 280000000 N·m/rad, but joint_4, joint_5, joint_6 120000 N·m/rad",
        "is it in N·m/rad?",
    ];
    assert_doubt(&yaml, &urdf, Code::StiffnessScale, "joint_1: {", &says);
    assert_eq!(warnings(&scaled(["120000", "2800000"]), &urdf).unwrap(), []);
}

#[test]
fn no_warning_shows_a_stand_in_for_what_is_at_fault() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("irb1600.urdf"), original("irb1600.urdf")).unwrap();
    let yaml = original("robot.yaml").replace("555000", ".nan");
    fs::write(folder.path().join("robot.yaml"), yaml).unwrap();
    let output = run(folder.path(), &["doctor", "robot.yaml"]);
    assert_eq!(code(&output), 2);
    assert!(err(&output).contains("stiffness_nm_per_rad is .nan"), "{}", err(&output));
    assert!(!err(&output).contains("median"), "{}", err(&output));
}

#[test]
fn angles_beyond_a_turn_are_doubted() {
    let urdf = original("irb1600.urdf");
    let with = |rpy: &str| {
        let at = urdf.find("<joint name=\"joint_3\"").unwrap();
        let origin = at + urdf[at..].find("<origin").unwrap();
        let end = origin + urdf[origin..].find("/>").unwrap();
        let own = &urdf[origin..end];
        let xyz = own.split("rpy").next().unwrap();
        format!("{}{xyz} rpy=\"{rpy}\"{}", &urdf[..origin], &urdf[end..])
    };
    let says = ["joint 'joint_3': <origin> rpy is \"30 10 -40\"", "is it in degrees?"];
    let yaml = original("robot.yaml");
    assert_doubt(&yaml, &with("30 10 -40"), Code::CadUnits, "30 10 -40", &says);
    assert_eq!(warnings(&yaml, &with("0 6.2832 -3.1416")).unwrap(), []);
}

#[test]
fn an_inertial_that_is_copied_to_all_links_is_doubted() {
    let links: Vec<String> = (1..=6).map(|i| format!("link_{i}")).collect();
    let copied = "mass_kg: 2, inertia_kgm2: {ixx: 0.01, iyy: 0.01, izz: 0.01}";
    let all: Vec<_> = links.iter().map(|link| (link.as_str(), copied)).collect();
    let says = ["the same inertial on link_1, link_2", "2 kg, ixx 0.01, iyy 0.01", "placeholder"];
    assert_doubt(
        &with_inertials(&all),
        &original("irb1600.urdf"),
        Code::SameInertial,
        "<robot",
        &says,
    );
    // Two of six may be alike.
    let two = with_inertials(&all[3..5]);
    assert_eq!(warnings(&two, &original("irb1600.urdf")).unwrap(), []);
}

#[test]
fn a_body_beyond_its_link_is_doubted() {
    let urdf = original("irb1600.urdf");
    let gyration = with_inertials(&[("link_2", "inertia_kgm2: {ixx: 60, iyy: 60, izz: 3}")]);
    let says =
        ["link 'link_2': radius of gyration is 1.557 m", "link is 0.700 m", "reference frame"];
    assert_doubt(&gyration, &urdf, Code::InertiaExtent, "link_2", &says);
    let com = with_inertials(&[("link_2", "com_m: [0, 0, 1.4]")]);
    let says = ["distance of the centre of mass is 1.400 m", "check the CAD export"];
    assert_doubt(&com, &urdf, Code::InertiaExtent, "link_2", &says);
    let near = with_inertials(&[("link_2", "com_m: [0, 0, 1.0]")]);
    assert_eq!(warnings(&near, &urdf).unwrap(), []);
}

#[test]
fn millimetres_and_grams_are_told_as_such() {
    let urdf = original("irb1600.urdf");
    let com = urdf.replace("xyz=\"0 0 0.353\"", "xyz=\"0 0 353\"");
    let says = ["centre of mass is 353.000 m", "is it in millimetres?"];
    assert_doubt(&original("robot.yaml"), &com, Code::CadUnits, "353", &says);
    let inertia = with_inertials(&[("link_2", "inertia_kgm2: {ixx: 1.2e6, iyy: 1.2e6, izz: 3e5}")]);
    let says = ["radius of gyration is 220.", "kg·mm²"];
    assert_doubt(&inertia, &urdf, Code::CadUnits, "link_2", &says);
    let heavy =
        ["70", "24.74", "33.68", "4.52", "2.43", "0.43"].iter().fold(urdf.clone(), |urdf, m| {
            let kg: f64 = m.parse().unwrap();
            urdf.replace(&format!("mass value=\"{m}\""), &format!("mass value=\"{}\"", kg * 1000.0))
        });
    let says = ["weighs 135800 kg", "arm of 1.874 m", "are the masses in grams?"];
    assert_doubt(&original("robot.yaml"), &heavy, Code::CadUnits, "<robot", &says);
    let long = urdf.replace("0.15 0 0.4865", "150 0 486.5").replace("0 0 0.700", "0 0 700");
    let says = ["the arm is 1209", "millimetres?"];
    assert_doubt(&original("robot.yaml"), &long, Code::CadUnits, "<robot", &says);
}

#[test]
fn a_mass_out_of_scale_is_doubted() {
    let urdf = original("irb1600.urdf");
    let heavy = with_inertials(&[("link_1", "mass_kg: 4000")]);
    let says = ["weighs 4065.8 kg on an arm of 1.874 m", "5.6 to 1645", "check the masses"];
    assert_doubt(&heavy, &urdf, Code::TotalMass, "<robot", &says);
    let light: Vec<(String, String)> = (1..=6)
        .map(|i| {
            let moments = "inertia_kgm2: {ixx: 0.001, iyy: 0.001, izz: 0.001}";
            (format!("link_{i}"), format!("mass_kg: 0.{i}, {moments}"))
        })
        .collect();
    let light: Vec<_> = light.iter().map(|(link, given)| (link.as_str(), given.as_str())).collect();
    let says = ["weighs 2.1 kg"];
    assert_doubt(&with_inertials(&light), &urdf, Code::TotalMass, "<robot", &says);
}

#[test]
fn a_joint_without_spring_is_named_unless_it_is_meant_so() {
    let urdf = original("irb1600.urdf");
    let without: String = original("robot.yaml")
        .lines()
        .filter(|line| !line.contains("joint_4: {") && !line.contains("joint_6: {"))
        .map(|line| format!("{line}\n"))
        .collect();
    let says =
        ["rigid: joint_4, joint_6; their compliance is not in the model", "elasticity.rigid"];
    assert_doubt(&without, &urdf, Code::RigidJoint, "elasticity", &says);
    let some = without.replace("elasticity:\n", "elasticity:\n  rigid: [joint_6]\n");
    assert_doubt(&some, &urdf, Code::RigidJoint, "elasticity", &["rigid: joint_4; "]);
    let meant = without.replace("elasticity:\n", "elasticity:\n  rigid: [joint_4, joint_6]\n");
    assert_eq!(warnings(&meant, &urdf).unwrap(), []);
}

/// The job of the repository with all springs so much stiffer.
fn first_frequency(factor: f64) -> Vec<Note> {
    let folder = tempfile::tempdir().unwrap();
    let robot = original("robot.yaml").lines().fold(String::new(), |text, line| {
        let scaled = line.split_once("stiffness_nm_per_rad: ").map(|(head, tail)| {
            let (value, rest) = tail.split_once(',').unwrap();
            let value: f64 = value.parse().unwrap();
            format!("{head}stiffness_nm_per_rad: {}, {rest}", factor * value)
        });
        text + &scaled.unwrap_or_else(|| line.to_owned()) + "\n"
    });
    fs::write(folder.path().join("robot.yaml"), robot).unwrap();
    fs::write(folder.path().join("irb1600.urdf"), original("irb1600.urdf")).unwrap();
    let job = fs::read_to_string(repository().join("jobs/pocket.yaml")).unwrap();
    let job = job.replace("../robots/irb1600/robot.yaml", "robot.yaml");
    let path = folder.path().join("job.yaml");
    fs::write(&path, job).unwrap();
    let checked = ReadJobs::read(&[path], Date::of(SystemTime::now())).check(&silent);
    assert!(checked.errors.is_empty(), "{:?}", checked.errors);
    checked.jobs[0]
        .risk
        .warnings
        .iter()
        .map(|warning| warning.note.clone())
        .filter(|n| n.code == Code::FirstFrequency)
        .collect()
}

#[test]
fn a_first_frequency_that_no_arm_has_is_doubted_once_a_job() {
    assert_eq!(first_frequency(1.0), []);
    for (factor, says) in [(1e-3, "where arms have 3 to 200 Hz"), (1e3, "operation '")] {
        let found = first_frequency(factor);
        let [note] = &found[..] else { panic!("{found:?}") };
        assert!(note.what.contains("first natural frequency is"), "{note}");
        assert!(note.what.contains(says) && note.what.contains("N·m/rad"), "{note}");
        assert!(note.place.file.as_deref().unwrap().ends_with("job.yaml"));
    }
}

/// As the support packages of makers are: meshes, and no inertial at all.
fn without_inertials() -> String {
    let mut urdf = original("irb1600.urdf");
    while let (Some(from), Some(to)) = (urdf.find("<inertial>"), urdf.find("</inertial>")) {
        let mesh = "<visual><geometry><mesh filename=\"a.stl\"/></geometry></visual>";
        urdf.replace_range(from..to + "</inertial>".len(), mesh);
    }
    urdf
}

#[test]
fn the_mass_of_an_arm_is_shared_out_to_links_without_inertial() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("irb1600.urdf"), without_inertials()).unwrap();
    let path = folder.path().join("robot.yaml");
    let yaml =
        original("robot.yaml") + "total_mass_kg: 250\ninertials:\n  link_2: {std_percent: 30}\n";
    fs::write(&path, &yaml).unwrap();
    let mut reading = Reading::default();
    let described = read_described_robot(&path, &mut reading).unwrap();
    let [note] = &reading.warnings[..] else { panic!("{:?}", reading.warnings) };
    assert_eq!(note.code, Code::AssumedMass);
    assert!(note.what.contains("250 kg distributed by length") && note.what.contains("link_2 "));
    let line = yaml.lines().position(|line| line.starts_with("total_mass_kg")).unwrap() + 1;
    assert_eq!(note.place.line, Some(line));
    let bodies = described.robot.bodies();
    assert_eq!(bodies.len(), 7);
    assert!((bodies.iter().map(|body| body.body.mass_kg).sum::<f64>() - 250.0).abs() < 1e-9);
    let stds: Vec<_> = bodies.iter().filter_map(|body| body.std).collect();
    assert_eq!(stds, [0.3]);
    assert!(bodies.iter().all(|body| body.assumed));
    let modes = Modes::at(&described.robot, &[0.0, 0.3, -0.2, 0.1, 0.6, 0.0]).unwrap();
    assert!(modes.natural_frequencies_hz.iter().all(|f| f.is_finite() && *f > 1.0), "{modes:?}");
}

/// A URDF's own shapes, with their places.
#[test]
fn boxes_of_a_urdf_share_the_mass_by_volume() {
    let mut urdf = without_inertials();
    let mesh = "<visual><geometry><mesh filename=\"a.stl\"/></geometry></visual>";
    let solid = format!(
        "{mesh}<collision><origin xyz=\"0.1 0 0\" rpy=\"0 1.5707963267948966 0\"/><geometry>\
         <cylinder radius=\"0.1\" length=\"0.4\"/></geometry></collision>"
    );
    urdf = urdf.replace(mesh, &solid);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("irb1600.urdf"), urdf).unwrap();
    let path = folder.path().join("robot.yaml");
    fs::write(&path, original("robot.yaml") + "total_mass_kg: 70\n").unwrap();
    let mut reading = Reading::default();
    let described = read_described_robot(&path, &mut reading).unwrap();
    assert!(reading.warnings[0].what.contains("by volume"), "{:?}", reading.warnings);
    let link = described.description.links.iter().find(|link| link.name == "link_3").unwrap();
    let body = link.inertial.unwrap();
    assert!((body.mass_kg - 10.0).abs() < 1e-9 && (body.com_m.x - 0.1).abs() < 1e-12);
    // 10 kg, along x: m r²/2 and m (3 r² + l²)/12.
    assert!((body.inertia_kgm2[(0, 0)] - 0.05).abs() < 1e-12, "{body:?}");
    assert!((body.inertia_kgm2[(1, 1)] - 10.0 * 0.19 / 12.0).abs() < 1e-12, "{body:?}");
}

#[test]
fn a_mass_that_cannot_be_shared_is_an_error_at_its_line() {
    for (urdf, mass, says) in [
        (original("irb1600.urdf"), "250", "total_mass_kg is 250, but no link lacks an inertial"),
        (without_inertials(), "0", "total_mass_kg is 0, must be positive"),
    ] {
        let yaml = original("robot.yaml") + &format!("total_mass_kg: {mass}\n");
        let errors = warnings(&yaml, &urdf).unwrap_err();
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert!(errors[0].what.contains(says), "{errors:?}");
        assert_eq!(errors[0].place.line, Some(yaml.lines().count()));
        assert!(errors[0].place.file.as_deref().unwrap().ends_with(Path::new("robot.yaml")));
    }
}

/// A clear job of two poses, at 24 000 rpm, on this robot.
fn verdict(yaml: &str, urdf: &str) -> (String, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("irb1600.urdf", urdf);
    write("robot.yaml", yaml);
    write(
        "job.yaml",
        "robot: robot.yaml\ntool: {teeth: 2}\npayload: none\nspindle: {min_rpm: 500, max_rpm: 24000}\noperations:\n  \
         - {name: a, spindle_rpm: 24000, feed_mm_per_min: 400, path: {joints_deg: [[0, 20, -10, 0, 60, 0], \
         [5, 22, -12, 0, 60, 0]]}}\npolicy: {tooth_passing_harmonics: 1, spindle_harmonics: 0, \
         min_tip_response_um_per_n: 0}\n",
    );
    let found = json(&run(folder.path(), &["check", "job.yaml", "--format", "json"]));
    let job = &found["jobs"][0];
    let codes = job["warnings"].as_array().unwrap().iter();
    let text = |value: &serde_json::Value| value.as_str().unwrap().to_owned();
    (text(&job["verdict"]), codes.map(|warning| text(&warning["code"])).collect())
}

#[test]
fn what_is_assumed_of_masses_or_claimed_of_few_poses_leaves_the_verdict_uncertain() {
    let (yaml, urdf) = (original("robot.yaml"), original("irb1600.urdf"));
    assert_eq!(verdict(&yaml, &urdf), ("clear".to_owned(), vec![]));
    let calibrated = |poses: usize, rms: f64| {
        format!("{yaml}calibration: {{poses: {poses}, heldout_rms_percent: {rms}}}\n")
    };
    assert_eq!(verdict(&calibrated(20, 2.0), &urdf), ("clear".to_owned(), vec![]));
    for (yaml, urdf, code) in [
        (yaml.clone() + "total_mass_kg: 250\n", without_inertials(), "assumed_mass"),
        (calibrated(1, 2.0), urdf.clone(), "calibration"),
        (calibrated(20, 0.0), urdf.clone(), "calibration"),
        (yaml, without_inertial_of(&urdf, "link_3"), "massless"),
    ] {
        assert_eq!(
            verdict(&yaml, &urdf),
            ("uncertain".to_owned(), vec![code.to_owned()]),
            "{code}"
        );
    }
}

fn without_inertial_of(urdf: &str, link: &str) -> String {
    let link = urdf.find(&format!("<link name=\"{link}\">")).unwrap();
    let [from, to] =
        ["<inertial>", "</inertial>"].map(|tag| link + urdf[link..].find(tag).unwrap());
    format!("{}{}", &urdf[..from], &urdf[to + "</inertial>".len()..])
}

/// What has a mass fixed to it is a frame, and so is a link that has none beyond it.
#[test]
fn a_link_between_joints_without_mass_is_doubted() {
    let urdf = without_inertial_of(&original("irb1600.urdf"), "link_3");
    let says = ["link 'link_3': has no <inertial>", "counted as massless"];
    assert_doubt(&original("robot.yaml"), &urdf, Code::Massless, "link_3", &says);
    let motor = "<link name=\"motor\"><inertial><mass value=\"33\"/><inertia ixx=\"0.3\" ixy=\"0\" ixz=\"0\" iyy=\"0.3\" \
                 iyz=\"0\" izz=\"0.3\"/></inertial></link><joint name=\"motor\" type=\"fixed\"><parent \
                 link=\"link_3\"/><child link=\"motor\"/></joint></robot>";
    let carried = urdf.replace("</robot>", motor);
    assert_eq!(warnings(&original("robot.yaml"), &carried).unwrap(), []);
}

/// Jobs say nothing of joints behind the tip: with springs there, the wrist stands at zero in every pose.
#[test]
fn springs_behind_the_tip_are_doubtful() {
    let yaml = original("robot.yaml").replace("tip: tool0", "tip: link_4");
    let says = ["joint_5, joint_6", "stand at zero"];
    assert_doubt(&yaml, &original("irb1600.urdf"), Code::AxisIgnored, "tip", &says);
}

/// A joint that slides makes no link longer than its travel: 40 g for 40 kg, with the inertia of these.
#[test]
fn masses_of_an_arm_on_a_track_are_judged() {
    let folder = repository().join("robots/rail-mill");
    let read = |file: &str| fs::read_to_string(folder.join(file)).unwrap();
    let temporary = tempfile::tempdir().unwrap();
    fs::write(temporary.path().join("rail-mill.urdf"), read("rail-mill.urdf")).unwrap();
    let path = temporary.path().join("robot.yaml");
    let inertia = "inertia_kgm2: {ixx: 2, iyy: 2, izz: 2}";
    let told = |mass_kg: f64| {
        let given = format!("inertials:\n  link_5: {{mass_kg: {mass_kg}, {inertia}}}\n");
        fs::write(&path, read("robot.yaml") + &given).unwrap();
        let mut reading = Reading::default();
        read_robot(&path, &mut reading).unwrap();
        reading.warnings.into_iter().map(|note| (note.code, note.what)).collect::<Vec<_>>()
    };
    assert_eq!(told(40.0), []);
    let found = told(0.04);
    let [(code, what)] = &found[..] else { panic!("{found:?}") };
    assert!(matches!(code, Code::InertiaExtent | Code::CadUnits), "{what}");
    assert!(what.contains("radius of gyration is 7.071 m"), "{what}");
}

/// A counterweight on a parallelogram swings with the arm; a finger that follows another does not.
#[test]
fn a_link_that_follows_a_joint_of_the_arm_is_doubted() {
    let (yaml, urdf) = (original("robot.yaml"), original("irb1600.urdf"));
    let with = |mass: &str, follows: &str| {
        let link = format!(
            "<link name=\"weight\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"0.3\" ixy=\"0\" \
             ixz=\"0\" iyy=\"0.3\" iyz=\"0\" izz=\"0.3\"/></inertial></link><link name=\"finger\"/>\
             <joint name=\"finger\" type=\"revolute\"><parent link=\"link_1\"/><child link=\"finger\"/>\
             <limit effort=\"0\" lower=\"-1\" upper=\"1\" velocity=\"1\"/></joint>\
             <joint name=\"swing\" type=\"revolute\"><parent link=\"finger\"/><child link=\"weight\"/>\
             <mimic joint=\"{follows}\"/><limit effort=\"0\" lower=\"-3\" upper=\"3\" velocity=\"1\"/>\
             </joint></robot>"
        );
        urdf.replace("</robot>", &link)
    };
    let says = ["taken to stand still", "swing follows joint_2"];
    assert_doubt(&yaml, &with("30", "joint_2"), Code::HeldJoint, "<robot", &says);
    assert_eq!(warnings(&yaml, &with("30", "finger")).unwrap(), []);
}

#[test]
fn gravity_in_millimetres_is_doubted() {
    let urdf = original("irb1600.urdf");
    let with = |g: &str| {
        let gravity = format!("elasticity:\n  gravity: true\n  gravity_m_per_s2: [0, 0, -{g}]");
        original("robot.yaml").replace("elasticity:", &gravity)
    };
    assert_doubt(&with("9810"), &urdf, Code::CadUnits, "gravity_m_per_s2", &["is it in mm/s²?"]);
    assert_eq!(warnings(&with("9.81"), &urdf).unwrap(), []);
}

/// Limits of ±166 are taken for radians; the last joint of an arm may turn round often.
#[test]
fn limits_in_degrees_are_doubted() {
    let (yaml, urdf) = (original("robot.yaml"), original("irb1600.urdf"));
    let limited = |urdf: &str, joint: &str| {
        let at = urdf.find(&format!("<joint name=\"{joint}\"")).unwrap();
        let from = at + urdf[at..].find("lower=").unwrap();
        let to = from + urdf[from..].find(" velocity").unwrap();
        format!("{}lower=\"-166\" upper=\"166\"{}", &urdf[..from], &urdf[to..])
    };
    let one = limited(&urdf, "joint_6");
    assert_eq!(warnings(&yaml, &one).unwrap(), []);
    let says = ["its limits are -166 and 166 rad", "are they in degrees?"];
    assert_doubt(&yaml, &limited(&one, "joint_4"), Code::CadUnits, "166", &says);
}

/// A source that is none is a guess, unless the file says otherwise.
#[test]
fn a_spring_whose_source_is_a_guess_is_doubted() {
    let urdf = original("irb1600.urdf");
    let from =
        |source: &str| original("robot.yaml").replace("source: \"assumed: like joint 2\"", source);
    for source in ["source: assumed", "source: Guess."] {
        assert_doubt(&from(source), &urdf, Code::AssumedSpring, "elasticity", &["joint_1"]);
    }
    for source in [
        "source: assumed, assumed: false",
        "source: \"assumed: like joint 2\"",
        "source: load test",
    ] {
        assert_eq!(warnings(&from(source), &urdf).unwrap(), [], "{source}");
    }
}

/// Readers of URDF pass over these: another robot than the one that is meant.
#[test]
fn what_readers_of_a_urdf_pass_over_is_refused() {
    let (yaml, urdf) = (original("robot.yaml"), original("irb1600.urdf"));
    let turned = |robot: &str| {
        let joint = "<link name=\"hose\"/><joint name=\"hose\" type=\"fixed\"><parent link=\"link_1\"/>\
                     <child link=\"hose\"/><origin quat_xyzw=\"0 0 1 0\"/></joint></robot>";
        urdf.replace("</robot>", joint).replacen("<robot ", robot, 1)
    };
    for version in ["1.1", "1.2"] {
        let robot = format!("<robot version=\"{version}\" ");
        assert_eq!(warnings(&yaml, &turned(&robot)).unwrap(), [], "{version}");
    }
    for (urdf, says) in [
        (turned("<robot "), "version=\"1.1\""),
        (turned("<robot version=\"1.0\" "), "version=\"1.1\""),
        (urdf.replace("</robot>", "<include filename=\"tool.urdf\"/></robot>"), "<include>"),
        (urdf.replacen("<inertial>", "<inertial><com xyz=\"0 0 1\"/>", 1), "has <com>"),
    ] {
        let faults = warnings(&yaml, &urdf).unwrap_err();
        assert!(faults.len() == 1 && faults[0].what.contains(says), "{says}: {faults:#?}");
        assert!(faults[0].place.line.is_some(), "{faults:#?}");
    }
}
