//! Pages and plots as files; what a browser makes of them is held by `tests/browser`.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{code, err, json, out, repository, run};

/// A folder with a job of the two-link arm.
fn bench(name: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let robot = repository().join("robots/two-link/robot.yaml");
    let job = format!(
        "name: {name}\nrobot: {}\ntool: {{teeth: 2, payload: none}}\nspindle: {{min_rpm: 500, max_rpm: \
         6000}}\noperations:\n  - name: {name}\n    spindle_rpm: 780\n    feed_mm_per_min: 400\n    path:\n      \
         joints_deg: [[0, 90], [0, 150]]\n",
        robot.display()
    );
    fs::write(folder.path().join("job.yaml"), job).unwrap();
    folder
}

fn data(page: &str) -> Value {
    let data = page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
    serde_json::from_str(data).unwrap()
}

#[test]
fn a_report_holds_the_samples_of_the_check() {
    let bench = bench("rough");
    let output = run(bench.path(), &["report", "job.yaml"]);
    assert_eq!(code(&output), 0, "{}", err(&output));
    let data = data(out(&output));
    let checked = json(&run(bench.path(), &["check", "--format", "json", "job.yaml"]));
    let samples = checked["jobs"][0]["operations"][0]["samples"].as_array().unwrap();
    let places = data["jobs"][0]["operations"][0]["places"].as_array().unwrap();
    assert!(places.len() > 50, "{}", places.len());
    for place in places {
        let sample = samples.iter().find(|sample| sample["s"] == place["s"]).unwrap();
        for (key, value) in sample.as_object().unwrap() {
            assert_eq!(&place[key], value, "{key}");
        }
        assert_eq!(place["shapes"].as_array().unwrap().len(), 2);
    }
    let page = out(&output);
    assert!(page.contains("default-src 'none'") && page.contains("RESONANCE"));
    assert!(page.contains("advice</dt>"), "the advised speed stands on the first screen");
    assert!(!page.replace("http://www.w3.org/2000/svg", "").contains("://"));
}

#[test]
fn names_stay_text() {
    let bench = bench("'</script><script>x</script><b>'");
    for arguments in [&["report", "job.yaml"][..], &["check", "--format", "html", "job.yaml"]] {
        let output = run(bench.path(), arguments);
        let page = out(&output);
        assert_eq!(page.matches("<script").count(), 2);
        assert!(page.contains("&lt;b&gt;") && !page.contains("<b>"));
    }
}

#[test]
fn a_job_that_is_wrong_leaves_the_old_page() {
    let bench = bench("rough");
    let job = bench.path().join("job.yaml");
    let text = fs::read_to_string(&job).unwrap();
    fs::write(&job, text.replace("teeth: 2", "teeth: none")).unwrap();
    fs::write(bench.path().join("report.html"), "old").unwrap();
    let output = run(bench.path(), &["report", "job.yaml", "--output", "report.html"]);
    assert_eq!(code(&output), 2);
    assert_eq!(fs::read_to_string(bench.path().join("report.html")).unwrap(), "old");
}

/// Frequencies over a joint, read back from the characters: the row of a curve is where its value lies between
/// the numbers of the axis.
#[test]
fn plots_of_characters_show_what_the_numbers_say() {
    let robot = crate::program::repository().join("robots/two-link");
    let robot = robot.to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let sweep = ["map", robot, "--joint", "joint_2", "--from-deg", "60", "--to-deg", "150"];
    let sweep = [&sweep[..], &["--steps", "31"]].concat();
    let csv = crate::program::out(&run(folder.path(), &sweep)).to_owned();
    let lowest = csv.lines().nth(1).unwrap().split(',').nth(3).unwrap().parse::<f64>().unwrap();
    let output = run(folder.path(), &[&sweep[..], &["--format", "plot"]].concat());
    let text = crate::program::out(&output);
    let rows: Vec<Vec<char>> = text.lines().map(|line| line.chars().collect()).collect();
    assert!(rows.iter().all(|row| row.len() <= 100), "{text}");
    let is_braille = |c: &char| ('\u{2801}'..='\u{28ff}').contains(c);
    let row_of = |told: &str| {
        let at = |row: &Vec<char>| {
            row.iter().collect::<String>().split('│').next().unwrap().trim_start().starts_with(told)
        };
        rows.iter().position(at).unwrap_or_else(|| panic!("{told}\n{text}"))
    };
    // The lower curve starts between the numbers of the axis, as far as a row goes.
    let first = |row: &Vec<char>| row.iter().position(is_braille);
    let start = rows.iter().filter_map(first).min().unwrap();
    let own = rows.iter().rposition(|row| first(row).is_some_and(|at| at <= start + 1)).unwrap();
    let (upper, lower) = (row_of("50"), row_of("0"));
    let share = lowest / 50.0;
    let expected = lower as f64 - share * (lower - upper) as f64;
    assert!((own as f64 - expected).abs() <= 1.0, "row {own}, not {expected}\n{text}");
    for told in ["mode 1", "mode 2", "frequency [Hz]", "β2 [°]", "└──"] {
        assert!(text.contains(told), "{told}\n{text}");
    }
}

#[test]
fn every_verb_with_plots_draws_them_with_characters() {
    let repository = crate::program::repository();
    let path = |file: &str| repository.join(file).to_str().unwrap().to_owned();
    let (contour, two_link) = (path("jobs/contour.yaml"), path("robots/two-link"));
    let session = path("robots/two-link/session.yaml");
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("measured.csv");
    fs::write(&table, crate::program::first_rows("measured.csv", 4)).unwrap();
    let table = table.to_str().unwrap().to_owned();
    for (arguments, told) in [
        (&["check", &contour][..], &["tooth passing × 1", "mode 4", "▓▓ resonance"][..]),
        (&["advise", &contour], &["safe constant speeds", "mode 4 with tooth passing × 1"]),
        (&["identify", &session], &["model order", "stable pole", "Mode 1,"]),
        (&["diagnose", &two_link, &table], &["the model as it is", "residual [%]"]),
        (
            &["lobes", &path("jobs/pocket.yaml"), "--rpm", "3000:12000:60"],
            &["axial depth [mm]", "chatter [Hz]"],
        ),
    ] {
        let output = run(repository, &[arguments, &["--format", "plot"]].concat());
        assert!(code(&output) < 2, "{}", err(&output));
        let text = crate::program::out(&output);
        for told in told {
            assert!(text.contains(told), "{arguments:?}: {told}\n{text}");
        }
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
        let dots = text.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count();
        assert!(dots > 100, "{arguments:?}: {dots} characters with dots\n{text}");
        assert!(!text.contains('\x1b'), "colours in a pipe");
    }
}

#[test]
fn plots_are_files_of_svg() {
    let bench = bench("rough/a");
    for (verb, expected) in [
        ("check", &["1-1-rough-a-beta2.svg", "1-1-rough-a-frequencies.svg"][..]),
        ("advise", &["1-rough-a-speeds.svg"]),
    ] {
        let output = run(bench.path(), &[verb, "job.yaml", "--plots", verb]);
        assert!(code(&output) < 2, "{}", err(&output));
        let folder = bench.path().join(verb);
        let mut names: Vec<_> = fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(names, expected);
        for name in names {
            let svg = fs::read_to_string(folder.join(name)).unwrap();
            assert!(svg.starts_with("<svg") && svg.contains("share of the operation's time, s"));
            roxmltree::Document::parse(&svg).unwrap();
        }
    }
    let folder = bench.path().join("identify");
    let session = crate::program::repository().join("robots/two-link/session.yaml");
    let output = run(
        bench.path(),
        &["identify", session.to_str().unwrap(), "--plots", folder.to_str().unwrap()],
    );
    assert_eq!(code(&output), 0, "{}", err(&output));
    let plots: Vec<_> = fs::read_dir(&folder).unwrap().collect();
    assert!(plots.len() > 2);
    for plot in plots {
        roxmltree::Document::parse(&fs::read_to_string(plot.unwrap().path()).unwrap()).unwrap();
    }
}
