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
