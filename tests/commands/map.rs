//! `detune map` as a user runs it.

use std::f64::consts::FRAC_PI_2;
use std::fs;

use crate::map_command::{command, map};
use crate::two_link::TABLE_1;
use detune::units::{rad_from_deg, rad_per_s_from_hz};
use nalgebra::{Vector2, Vector3};

/// More poses than are held in memory at once.
const MANY: usize = 70_000;

fn table(text: &str) -> (Vec<String>, Vec<Vec<Option<f64>>>) {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows = reader
        .records()
        .map(|record| record.unwrap().iter().map(|field| field.parse().ok()).collect())
        .collect();
    (names, rows)
}

#[test]
fn a_sweep_gives_equation_45() {
    let text = map("robots/two-link --joint joint_2 --from-deg -130 --to-deg 150 --steps 29 \
                --at joint_1=120")
    .unwrap();
    let (names, rows) = table(&text);
    assert_eq!(names, ["joint_1_rad", "joint_2_rad", "beta2_rad", "f1_hz", "f2_hz"]);
    assert_eq!(rows.len(), 29);
    assert_eq!(rows[0][1], Some(rad_from_deg(-130.0)));
    assert_eq!(rows[28][1], Some(rad_from_deg(150.0)));
    for row in rows {
        let row: Vec<f64> = row.into_iter().map(Option::unwrap).collect();
        assert_eq!((row[0], row[1]), (rad_from_deg(120.0), row[2]));
        let expected = TABLE_1.natural_frequencies_hz(row[2]);
        for r in 0..2 {
            assert!((row[3 + r] / expected[r] - 1.0).abs() < 1e-10, "{row:?}");
        }
    }
}

/// Fig. 4 of Pietruś & Gierlak: in the first mode both joints turn the same way, in the second against
/// each other, up to β2 = 99.2°. φᵀ M φ = 1 with M of Eq. (30).
#[test]
fn shapes_are_those_of_equation_42() {
    let sweep = "robots/two-link --joint joint_2 --from-deg 10 --to-deg 150 --steps 15 --shapes";
    let (names, rows) = table(&map(sweep).unwrap());
    for row in &rows {
        let value =
            |name: &str| row[names.iter().position(|known| known == name).unwrap()].unwrap();
        let q2 = value("joint_2_rad");
        let (m, k) = (TABLE_1.mass_matrix_kgm2(q2), TABLE_1.stiffness_nm_per_rad);
        let expected = TABLE_1.modes(q2);
        for r in 0..2 {
            let of_mode = |kind: &str, name: &str| value(&format!("{kind}{}_{name}", r + 1));
            let phi = Vector2::new(of_mode("phi", "joint_1"), of_mode("phi", "joint_2"));
            assert!((phi.dot(&(m * phi)) - 1.0).abs() < 1e-9, "{phi}");
            assert!((phi.normalize().perp(&expected.shapes[r].normalize())).abs() < 1e-9, "{phi}");
            // M12 of Table 1 changes its sign at 99.2 degrees.
            assert_eq!(phi.x * phi.y > 0.0, (r == 0) == (q2 < 99.2_f64.to_radians()), "{phi}");
            let omega_2 = rad_per_s_from_hz(expected.natural_frequencies_hz[r]).powi(2);
            for (i, joint) in ["joint_1", "joint_2"].into_iter().enumerate() {
                let share = k[i] * phi[i] * phi[i] / omega_2;
                assert!((of_mode("strain", joint) - share).abs() < 1e-9, "{joint} {share}");
            }
            let turn = |link: &str| {
                Vector3::from(["x", "y", "z"].map(|a| of_mode("phi", &format!("{link}_{a}"))))
            };
            assert!((turn("link_1").norm() - phi.x.abs()).abs() < 1e-12);
            assert!((turn("link_2").norm() - (phi.x + phi.y).abs()).abs() < 1e-12);
        }
    }
    let json: serde_json::Value =
        serde_json::from_str(&map(&format!("{sweep} --format json")).unwrap()).unwrap();
    assert_eq!(json["shape_links"], serde_json::json!(["link_1", "link_2"]));
    let first = &json["rows"][0]["mode_shapes"][1];
    assert_eq!(
        first["phi"][0].as_f64(),
        rows[0][names.iter().position(|n| n == "phi2_joint_1").unwrap()]
    );
    let refused = map(&format!("{sweep} --format npy")).unwrap_err();
    assert!(
        refused[0].contains("--shapes: takes linear maps as csv, json or html only"),
        "{refused:?}"
    );
}

/// The samples of the vibration have the frequencies that the map gives: zero crossings of the modal
/// coordinate of mode 1 are half a period apart.
#[test]
fn a_series_is_the_vibration() {
    let sweep = "robots/two-link --joint joint_2 --from-deg 90 --to-deg 90 --steps 1 --method \
                 nonlinear --amplitude-deg 0.01";
    let (names, rows) = table(&map(&format!("{sweep} --series")).unwrap());
    assert_eq!(names[3..], ["t_s", "alpha_joint_1_rad", "alpha_joint_2_rad"]);
    let (m, modes) = (TABLE_1.mass_matrix_kgm2(FRAC_PI_2), TABLE_1.modes(FRAC_PI_2));
    for r in 0..2 {
        let modal = |row: &[Option<f64>]| {
            modes.shapes[r].dot(&(m * Vector2::new(row[4].unwrap(), row[5].unwrap())))
        };
        let zeros: Vec<f64> = rows
            .windows(2)
            .filter(|pair| modal(&pair[0]).signum() != modal(&pair[1]).signum())
            .map(|pair| {
                let (a, b) = (modal(&pair[0]), modal(&pair[1]));
                let (from, to) = (pair[0][3].unwrap(), pair[1][3].unwrap());
                from + (to - from) * a / (a - b)
            })
            .collect();
        let halves = (zeros.len() - 1) as f64;
        let hz = 0.5 * halves / (zeros[zeros.len() - 1] - zeros[0]);
        let expected = modes.natural_frequencies_hz[r];
        assert!(halves > 20.0 && (hz / expected - 1.0).abs() < 1e-4, "{hz} {expected}");
    }
    let refused = map(&format!("{sweep} --series --format json")).unwrap_err();
    assert!(refused[0].contains("--series: takes --method nonlinear and csv only"), "{refused:?}");
}

/// A map's own output is a table of poses: the same frequencies come back to the last digit, across
/// the border between two chunks, and in the order given.
#[test]
fn a_table_of_poses_gives_the_same_bytes() {
    let sweep = "--joint joint_2 --from-deg -100 --to-deg 100 --at joint_1=30";
    let swept = map(&format!("robots/two-link {sweep} --steps {}", MANY)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("poses.csv");
    fs::write(&file, &swept).unwrap();
    let again = map(&format!("robots/two-link --poses {}", file.display())).unwrap();
    assert!(again == swept);
    assert_eq!(swept.lines().count(), MANY + 1);
}

#[test]
fn degrees_and_any_order_of_columns() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("poses.csv");
    fs::write(&file, "# by hand\nid, joint_2_deg ,joint_1_rad\na, 90, 0.5\n\nb,-45,1\n").unwrap();
    let (_, rows) = table(&map(&format!("robots/two-link --poses {}", file.display())).unwrap());
    assert_eq!(rows[0][..2], [Some(0.5), Some(rad_from_deg(90.0))]);
    assert_eq!(rows[1][..2], [Some(1.0), Some(rad_from_deg(-45.0))]);
}

#[test]
fn every_fault_of_a_table_has_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("poses.csv");
    let faults = |text: &str| {
        fs::write(&file, text).unwrap();
        let faults = map(&format!("robots/two-link --poses {}", file.display())).unwrap_err();
        faults
            .iter()
            .filter_map(|fault| Some(fault.rsplit_once("poses.csv:")?.1.to_owned()))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        faults("joint_1_rad,joint_2_rad\n0,0\n0,x\n0,nan\n1\n0,1\n"),
        [
            "3: joint_2_rad is 'x', must be a finite number",
            "4: joint_2_rad is 'nan', must be a finite number",
            "5: joint_2_rad is empty, must be a finite number",
        ]
    );
    let missing = faults("joint_1_rad,joint2_rad\n0,0\n").concat();
    assert!(missing.starts_with("1: no column 'joint_2_rad' or 'joint_2_deg'"), "{missing}");
    assert_eq!(
        faults("joint_1_rad,joint_2_rad,joint_1_deg\n0,0,0\n"),
        ["1: joint 'joint_1' has 2 columns, must have one"]
    );
}

#[test]
fn a_wrong_name_gets_a_suggestion_and_units_must_fit() {
    let told = |line: &str| map(line).unwrap_err().concat();
    let typo = told("robots/two-link --joint joint2 --from-deg 0 --to-deg 1 --steps 2");
    assert!(typo.contains("no moving joint 'joint2'; did you mean 'joint_2'?"), "{typo}");
    let units = told("robots/two-link --joint joint_2 --from-mm 0 --to-mm 1 --steps 2");
    assert!(units.contains("turns: positions in mm do not fit"), "{units}");
    let twice =
        told("robots/two-link --joint joint_2 --from-deg 0 --to-deg 1 --steps 2 --at joint_2=3");
    assert!(twice.contains("'joint_2' is swept and cannot be fixed as well"), "{twice}");
    let none = told("robots/two-link --joint joint_2 --from-deg 0 --to-deg 1 --steps 0");
    assert!(none.contains("--steps"), "{none}");
    let amplitude = told(
        "robots/two-link --joint joint_2 --from-deg 0 --to-deg 1 --steps 1 --method nonlinear \
     --amplitude-deg 0",
    );
    assert!(
        amplitude.contains(
            "--amplitude-deg: the amplitude is 0 degrees, must be above 0 and at most 90"
        ),
        "{amplitude}"
    );
}

#[test]
fn one_step_stays_at_the_start() {
    let text = map("robots/two-link --joint joint_2 --from-deg 10 --to-deg 20 --steps 1").unwrap();
    let (_, rows) = table(&text);
    assert_eq!(rows.len(), 1);
    assert_eq!(rows[0][1], Some(rad_from_deg(10.0)));
}

/// The columns after the linear ones, and the paper's acquisition, which cannot see the second mode.
#[test]
fn a_nonlinear_map_tells_departure_and_drift() {
    let line = "robots/two-link --joint joint_2 --from-deg 60 --to-deg 120 --steps 3 \
            --method nonlinear --amplitude-deg 0.1";
    let (names, rows) = table(&map(line).unwrap());
    assert_eq!(
        names[3..],
        [
            "f1_hz",
            "f2_hz",
            "f1_linear_hz",
            "f1_departure_percent",
            "f2_linear_hz",
            "f2_departure_percent",
            "energy_drift"
        ]
    );
    for row in &rows {
        let at = |i: usize| row[i].unwrap();
        assert!((at(3) / at(5) - 1.0).abs() < 1e-5);
        assert!(((at(4) / at(7) - 1.0) * 100.0 - at(8)).abs() < 1e-9);
        assert!(at(9) < 1e-7);
    }
    let camera = map(&format!("{line} --sample-rate-hz 140 --duration-s 5")).unwrap();
    let (_, rows) = table(&camera);
    assert!(rows.iter().all(|row| row[3].is_some() && row[4].is_none() && row[8].is_none()));
}

#[test]
fn json_and_svg_are_well_formed() {
    let line = "robots/two-link --joint joint_2 --from-deg -90 --to-deg 90 --steps 5";
    for method in ["linear", "nonlinear"] {
        let json = map(&format!("{line} --method {method} --format json")).unwrap();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["schema"], "map/1");
        assert_eq!(json["method"], method);
        assert_eq!(json["rows"].as_array().unwrap().len(), 5);
        let svg = map(&format!("{line} --method {method} --format svg")).unwrap();
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{method}");
        assert_eq!(svg.matches("β2 [°]").count(), if method == "linear" { 1 } else { 2 });
    }
}

#[test]
fn a_file_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map.csv");
    let line = "robots/two-link/robot.yaml --joint joint_2 --from-deg 0 --to-deg 9 --steps 4";
    let out = map(&format!("{line} --output {}", file.display())).unwrap();
    assert_eq!(out, "");
    assert_eq!(fs::read_to_string(&file).unwrap(), map(line).unwrap());

    let poses = folder.path().join("poses.csv");
    fs::write(&poses, "joint_1_rad,joint_2_rad\n0,0\n0,bad\n").unwrap();
    let other = folder.path().join("other.csv");
    let line = format!("robots/two-link --poses {} --output {}", poses.display(), other.display());
    assert!(map(&line).is_err());
    assert!(!other.exists());
}

/// The first of them lies behind the border between two pieces.
#[test]
fn poses_beyond_the_joint_limits_are_told_alike_by_every_way_through() {
    let told = |poses: &str, more: &str| {
        let output = command(&format!("robots/irb1600 {poses} {more}")).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{more}");
        String::from_utf8(output.stderr).unwrap()
    };
    let many = "--joint joint_2 --from-deg -89.9 --to-deg 179.9 --steps 1350";
    let expected = "warning: 300 of 1350 poses lie outside the joint limits (the first: joint \
                    'joint_2' is 120.100 deg, must lie in -90.000..120.000 deg)\n";
    let npy = "--format npy";
    for more in ["", "--format json", npy, "--format svg", "--reduce min"] {
        assert_eq!(told(many, more), expected, "{more}");
    }
    let few = "--grid joint_2=110:130:2 --at joint_1=12";
    let first = |more: &str| told(few, more).lines().next().unwrap_or_default().to_owned();
    let linear = first("");
    assert!(
        linear.contains("1 of 2 poses") && linear.contains("'joint_2' is 130.000 deg"),
        "{linear}"
    );
    assert_eq!(first("--method nonlinear --sample-rate-hz 2000 --duration-s 0.2"), linear);
}

#[test]
fn a_hair_beyond_a_limit_is_within_for_maps_as_for_checks() {
    // 120 degrees are 2.0943951 rad, and limits in files are rounded.
    let warned = |to: &str| {
        let sweep = format!("robots/irb1600 --joint joint_2 --from-deg 0 --to-deg {to} --steps 2");
        !command(&sweep).output().unwrap().stderr.is_empty()
    };
    assert_eq!(["120", "120.004", "120.01"].map(warned), [false, false, true]);
}

#[test]
fn a_fault_behind_written_rows_says_that_they_are_cut_short() {
    let mut poses = "joint_1_rad,joint_2_rad\n".to_owned();
    poses.push_str(&"0.1,0.2\n".repeat(700_000));
    poses.push_str(&"0.1,x\n".repeat(40));
    let mut child = command("robots/two-link --poses -")
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let feeder = std::thread::spawn(move || {
        // The reader stops at the fault.
        let _ = std::io::Write::write_all(&mut stdin, poses.as_bytes());
    });
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    let told: Vec<&str> = told.lines().collect();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        !output.stdout.is_empty() && told[0].contains("-:700002: joint_2_rad is 'x'"),
        "{told:?}"
    );
    let [.., stopped, last] = told.as_slice() else { panic!("{told:?}") };
    assert!(stopped.contains("reading stopped after 20 errors or more"), "{stopped}");
    assert_eq!(*last, "the output is incomplete: fix these errors and run the command again");
}

#[test]
fn nothing_is_written_over_the_poses() {
    let folder = tempfile::tempdir().unwrap();
    let [csv, npy] = ["p.csv", "p.npy"].map(|name| folder.path().join(name));
    fs::write(&csv, "joint_1_rad,joint_2_rad\n0,0\n").unwrap();
    fs::write(&npy, crate::map_command::data("poses.npy")).unwrap();
    for poses in [&csv, &npy] {
        let before = fs::read(poses).unwrap();
        for more in ["", "--format npy", "--format svg", "--reduce min", "--method nonlinear"] {
            let arguments = format!("robots/two-link {more} --output {}", poses.display());
            let named = map(&format!("{arguments} --poses {}", poses.display()));
            let mut piped = command(&format!("{arguments} --poses -"));
            let piped = piped.stdin(fs::File::open(poses).unwrap()).output().unwrap();
            for told in [named, crate::map_command::result(piped).map(|_| String::new())] {
                let told = told.unwrap_err().concat();
                assert!(told.contains("is read by this run as"), "{more}: {told}");
            }
            assert_eq!(fs::read(poses).unwrap(), before, "{more}");
        }
    }
}

#[test]
fn a_grid_of_one_position_has_one_end() {
    let told = map("robots/two-link --grid joint_1=3:4:1").unwrap_err().concat();
    assert!(told.contains("one position has one end"), "{told}");
    assert_eq!(map("robots/two-link --grid joint_1=3:3:1").unwrap().lines().count(), 2);
}

#[test]
fn every_option_that_does_not_fit_is_told() {
    let sweep = "robots/two-link --joint joint_2 --from-deg 0 --to-deg 1 --steps 2";
    for (more, expected) in [
        ("--reduce min --format npy --amplitude-deg 2", vec!["--amplitude-deg has no", "--format"]),
        (
            "--reduce min --sample-rate-hz 9 --duration-s 1",
            vec!["--sample-rate-hz has no effect", "--duration-s has no effect"],
        ),
        ("--reduce min --method nonlinear", vec!["--reduce: takes linear maps only"]),
        ("--at joint_1=3 --at joint_1=4", vec!["--at: joint 'joint_1' is given twice"]),
        (
            "--format npy --method nonlinear",
            vec!["--format npy and arrow: hold the frequencies of"],
        ),
    ] {
        let faults = map(&format!("{sweep} {more}")).unwrap_err();
        assert_eq!(faults.len(), expected.len() + 1, "{faults:?}");
        for (fault, expected) in faults.iter().zip(expected) {
            assert!(fault.starts_with(&format!("error: {expected}")), "{more}: {fault}");
        }
    }
}
