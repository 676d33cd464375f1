//! Maps made in parts and put together: the bytes of the undivided run.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::program::{code, err, out, repository, run};

/// The arm of six joints.
fn robot() -> String {
    repository().join("robots/irb1600/robot.yaml").display().to_string()
}

fn ran(folder: &Path, line: &str) -> std::process::Output {
    let robot = robot();
    let words: Vec<&str> =
        line.split_whitespace().map(|word| if word == "ROBOT" { &robot } else { word }).collect();
    run(folder, &words)
}

/// Parts of a map, in files named by their numbers.
fn parts(folder: &Path, request: &str, of: usize) -> Vec<String> {
    let make = |number: usize| {
        let file = format!("{number}.json");
        let line =
            format!("map ROBOT {request} --part {number}/{of} --format sketch --output {file}");
        let output = ran(folder, &line);
        assert_eq!(code(&output), 0, "{}", err(&output));
        file
    };
    (1..=of).map(make).collect()
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn merged_parts_are_the_undivided_run_to_the_byte() {
    // Few poses (exact quantiles) and many, random and a grid, more parts than pieces of 1024 poses.
    for (request, of) in [
        ("--random 3000 --seed 5 --reduce min,max,mean,quantiles,histogram", 7),
        ("--random 70001 --seed 1 --reduce mean,quantiles,histogram", 3),
        ("--grid joint_2=-60:200:151 --grid joint_3=-90:60:31 --reduce min,max,mean", 4),
    ] {
        let folder = folder();
        let mut files = parts(folder.path(), request, of);
        files.reverse();
        for format in ["csv", "json", "svg"] {
            let whole = ran(folder.path(), &format!("map ROBOT {request} --format {format}"));
            let merged =
                ran(folder.path(), &format!("merge {} --format {format}", files.join(" ")));
            assert_eq!(code(&merged), 0, "{}", err(&merged));
            assert!(out(&merged) == out(&whole), "{request} {format}");
            assert_eq!(err(&merged), err(&whole), "{request} {format}");
        }
    }
}

#[test]
fn parts_that_do_not_make_one_map_are_refused() {
    let folder = folder();
    let request = "--random 5000 --seed 5 --reduce mean";
    parts(folder.path(), request, 3);
    let refused = |sketches: &str, told: &str| {
        let output = ran(folder.path(), &format!("merge {sketches}"));
        assert_eq!((code(&output), out(&output)), (2, ""), "{sketches}");
        assert!(err(&output).contains(told), "{sketches}: {}", err(&output));
    };
    refused("1.json 3.json", "of 3 parts these are missing: 2");
    refused("1.json 2.json 3.json 2.json", "2.json: is part 2, and so is 2.json");
    refused("1.json 2.json gone.json", "gone.json: no such file");
    let other = |line: &str| {
        let output = ran(folder.path(), &format!("{line} --format sketch --output x.json"));
        assert_eq!(code(&output), 0, "{}", err(&output));
    };
    other("map ROBOT --random 5000 --seed 6 --reduce mean --part 3/3");
    refused("1.json 2.json x.json", "x.json: is about other poses than 1.json");
    other("map ROBOT --random 5000 --seed 5 --reduce min --part 3/3");
    refused("1.json 2.json x.json", "x.json: was made for other statistics than 1.json");
    let two_link = repository().join("robots/two-link/robot.yaml").display().to_string();
    other(&format!("map {two_link} --random 5000 --seed 5 --reduce mean --part 3/3"));
    refused("1.json 2.json x.json", "x.json: is about another robot than 1.json");
    // A number that was changed contradicts others.
    let text = fs::read_to_string(folder.path().join("3.json")).unwrap();
    for (from, to) in [("\"poses\": 5000", "\"poses\": 4000"), ("\"first\":", "\"frist\":")] {
        assert!(text.contains(from), "{text}");
        fs::write(folder.path().join("x.json"), text.replacen(from, to, 1)).unwrap();
        let output = ran(folder.path(), "merge 1.json 2.json x.json");
        assert_eq!((code(&output), out(&output)), (2, ""), "{to}");
    }
    refused(&robot(), "is no sketch of a map");
}

#[test]
fn options_of_parts_are_checked() {
    let folder = folder();
    fs::write(folder.path().join("poses.csv"), "joint_1_rad\n0\n").unwrap();
    for (line, told) in [
        ("map ROBOT --random 10 --part 4/3 --format sketch", "I from 1 to N"),
        ("map ROBOT --random 10 --part 0/3 --format sketch", "I from 1 to N"),
        ("map ROBOT --random 10 --part 1/3", "no effect without --format sketch"),
        ("map ROBOT --random 10 --method nonlinear --format sketch", "takes linear maps only"),
        ("map ROBOT --random 10 --intervals --format sketch", "csv, json, svg or html only"),
    ] {
        let output = ran(folder.path(), line);
        assert_eq!((code(&output), out(&output)), (2, ""), "{line}");
        assert!(err(&output).contains(told), "{line}: {}", err(&output));
    }
    let two_link = repository().join("robots/two-link");
    fs::write(folder.path().join("poses.csv"), "joint_1_rad,joint_2_rad\n0,1\n").unwrap();
    let line = format!("map {} --poses poses.csv --format sketch", two_link.display());
    let output = ran(folder.path(), &line);
    assert!(err(&output).contains("a table of poses cannot be divided"), "{}", err(&output));
}
