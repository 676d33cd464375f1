//! `detune trace` as a user meets it.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::film::{Camera, Disc, Edge, y4m};
use crate::vibration::seeded;

pub(crate) fn detune(arguments: &[&str], folder: &Path) -> Output {
    let program = env!("CARGO_BIN_EXE_detune");
    Command::new(program).args(arguments).current_dir(folder).output().unwrap()
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

const CAMERA: Camera = Camera { width: 96, height: 80, noise: 1.5, readout_s: 0.0 };
const MARKS: &str = "scale: {points_px: [[0, 0], [100, 0]], distance_mm: 100}\nmarks:\n  - {name: \
                     tip, box_px: [26, 26, 28, 28]}\n";

/// 12 Hz at 100 frames a second.
fn path(time: f64) -> [f64; 2] {
    let turn = std::f64::consts::TAU * 12.0 * time;
    [40.3 + 4.0 * turn.sin(), 39.6 + 2.5 * (turn + 0.7).cos()]
}

fn tip(time: f64) -> Vec<Disc> {
    vec![Disc { at: path(time), radius: 8.0, contrast: 150.0, edge: Edge::Soft }]
}

fn frames(times: &[f64], discs: &dyn Fn(f64) -> Vec<Disc>) -> Vec<Vec<u8>> {
    let mut rng = seeded(2);
    times.iter().map(|time| CAMERA.frame(*time, &|_, _| 60.0, discs, &mut rng)).collect()
}

fn even(count: usize) -> Vec<f64> {
    (0..count).map(|k| k as f64 / 100.0).collect()
}

/// The rows of a table: time and the displacements; none where cells are blank.
fn rows(table: &str) -> Vec<(f64, Option<[f64; 2]>)> {
    let rows = table.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        let value = |k: usize| cells[k].parse::<f64>().ok();
        (value(0).unwrap(), value(1).zip(value(2)).map(|(x, y)| [x, y]))
    })
    .collect()
}

/// Largest error of displacements at the times of the table, px and mm alike; a constant is free.
fn largest_error(table: &str) -> f64 {
    let rows = rows(table);
    let mut largest: f64 = 0.0;
    for axis in 0..2 {
        let sign = [1.0, -1.0][axis];
        let off =
            rows.iter().filter_map(|(t, moved)| Some((*moved)?[axis] - sign * path(*t)[axis]));
        let off: Vec<f64> = off.collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        largest = off.iter().map(|off| (off - mean).abs()).fold(largest, f64::max);
    }
    largest
}

#[test]
fn a_hidden_mark_is_told_and_left_blank_and_identify_refuses_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let hides = |time: f64| if (0.295..0.345).contains(&time) { Vec::new() } else { tip(time) };
    let frames = frames(&even(80), &hides);
    fs::write(file("clip.y4m"), y4m(&CAMERA, 100, &frames)).unwrap();
    fs::write(file("marks.yaml"), MARKS).unwrap();
    let options = ["trace", "clip.y4m", "--marks", "marks.yaml", "--output", "traces.csv"];
    let more = ["--picture", "tracks.svg", "--frames", "frames.csv"];
    let answer = detune(&[&options[..], &more[..]].concat(), folder.path());
    assert!(answer.status.success(), "{}", text(&answer.stderr));
    assert_eq!(
        text(&answer.stderr),
        "warning: clip.y4m: mark 'tip' is lost in 5 of 80 frames (31-35); its cells are blank \
         there\n"
    );
    let table = fs::read_to_string(file("traces.csv")).unwrap();
    assert!(table.contains("; lost in frames 31-35\n"), "{table}");
    for (k, (_, moved)) in rows(&table).iter().enumerate() {
        assert_eq!(moved.is_none(), (30..35).contains(&k), "{k}");
    }
    assert!(largest_error(&table) < 0.03);
    let seen = fs::read_to_string(file("frames.csv")).unwrap();
    assert!(seen.contains("\n31,0.300000000,,,,,\n"), "{seen}");
    let svg = fs::read_to_string(file("tracks.svg")).unwrap();
    assert!(svg.matches("<path d=").count() == 4 && !svg.contains("NaN"), "{svg}");
    let session = "records: [{file: traces.csv, pose: {beta2_rad: 1}}]\n";
    fs::write(file("session.yaml"), session).unwrap();
    let refused = detune(&["identify", "session.yaml"], folder.path());
    assert_eq!(refused.status.code(), Some(2));
    let told = text(&refused.stderr);
    assert!(
        told.contains("traces.csv:34: tip_x_mm is empty, must be a finite number, and so in 4")
    );
    assert_eq!(told.matches("is empty").count(), 2, "{told}");
}

/// Steps that vary by a third, as phones have them: the table is even, and right.
#[test]
fn uneven_times_become_an_even_table() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let times: Vec<f64> =
        (0..120).map(|k| 0.01 * (f64::from(k) + 0.17 * (2.1 * f64::from(k)).sin())).collect();
    fs::write(file("clip.y4m"), y4m(&CAMERA, 100, &frames(&times, &tip))).unwrap();
    fs::write(file("marks.yaml"), MARKS).unwrap();
    let written = |times: &[f64]| {
        let rows: String = times.iter().map(|time| format!("{time:.6}\n")).collect();
        fs::write(file("times.csv"), format!("time_s\n{rows}")).unwrap();
    };
    written(&times);
    let options = ["trace", "clip.y4m", "--marks", "marks.yaml"];
    let timed = [&options[..], &["--times", "times.csv"]].concat();
    let answer = detune(&timed, folder.path());
    assert!(answer.status.success(), "{}", text(&answer.stderr));
    let table = text(&answer.stdout);
    let steps = rows(&table);
    assert!(steps.len() > 100, "{table}");
    let step = (steps.last().unwrap().0 - steps[0].0) / (steps.len() - 1) as f64;
    assert!(steps.windows(2).all(|pair| (pair[1].0 - pair[0].0 - step).abs() < 3e-9));
    assert!((step - 0.01).abs() < 5e-5, "{step}");
    println!("uneven: {} px; {}", largest_error(&table), table.lines().nth(1).unwrap());
    assert!(largest_error(&table) < 0.04, "{}", largest_error(&table));
    // Without the times they are taken for even, and that is wrong.
    assert!(largest_error(&text(&detune(&options, folder.path()).stdout)) > 0.3);
    written(&times[1..]);
    let answer = detune(&timed, folder.path());
    assert_eq!(answer.status.code(), Some(2));
    assert!(
        text(&answer.stderr).contains("clip.y4m has 120 frames, and the table of times has 119")
    );
}

/// With such times the value at the first frame is known, and that of the row behind it is not:
/// the table begins behind both, and `identify` takes it.
#[test]
fn uneven_times_leave_no_single_rows_at_the_ends() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let jitter = |k: usize| 2.0 * ((12.9898 * (k + 1) as f64).sin() * 43_758.545_3).rem_euclid(1.0);
    let times: Vec<f64> = (0..120).map(|k| 0.01 * (k as f64 + 0.15 * (jitter(k) - 1.0))).collect();
    fs::write(file("clip.y4m"), y4m(&CAMERA, 100, &frames(&times, &tip))).unwrap();
    fs::write(file("marks.yaml"), MARKS).unwrap();
    let stamps: String = times.iter().map(|time| format!("{time:.6}\n")).collect();
    fs::write(file("times.csv"), format!("time_s\n{stamps}")).unwrap();
    let options = ["trace", "clip.y4m", "--marks", "marks.yaml", "--times", "times.csv"];
    let answer = detune(&options, folder.path());
    assert_eq!(text(&answer.stderr), "");
    let table = text(&answer.stdout);
    let rows = rows(&table);
    assert!(rows.len() > 110 && rows.iter().all(|(_, moved)| moved.is_some()), "{table}");
    assert!(largest_error(&table) < 0.1, "{}", largest_error(&table));
}

#[test]
fn folders_of_png_and_of_jpeg_at_quality_80_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let (width, height) = (CAMERA.width as u16, CAMERA.height as u16);
    let frames = frames(&even(60), &tip);
    for name in ["png", "jpeg"] {
        fs::create_dir(file(name)).unwrap();
    }
    for (k, frame) in frames.iter().enumerate() {
        // Numbers without leading zeros: 10 comes after 9.
        let png = fs::File::create(file(&format!("png/frame{k}.png"))).unwrap();
        let mut encoder = png::Encoder::new(png, width.into(), height.into());
        encoder.set_color(png::ColorType::Grayscale);
        encoder.write_header().unwrap().write_image_data(frame).unwrap();
        let path = file(&format!("jpeg/frame{k}.jpg"));
        let jpeg = jpeg_encoder::Encoder::new_file(path, 80).unwrap();
        jpeg.encode(frame, width, height, jpeg_encoder::ColorType::Luma).unwrap();
    }
    fs::write(file("clip.y4m"), y4m(&CAMERA, 100, &frames)).unwrap();
    fs::write(file("marks.yaml"), format!("frame_rate_hz: 100\n{MARKS}")).unwrap();
    let run = |video: &str| {
        let answer = detune(&["trace", video, "--marks", "marks.yaml"], folder.path());
        assert!(answer.status.success(), "{}", text(&answer.stderr));
        text(&answer.stdout)
    };
    let (stream, png, jpeg) = (run("clip.y4m"), run("png"), run("jpeg"));
    assert_eq!(stream, png);
    println!("y4m {:.4} px, jpeg {:.4} px", largest_error(&png), largest_error(&jpeg));
    assert!(largest_error(&png) < 0.02 && largest_error(&jpeg) < 0.03);
    assert_ne!(png, jpeg);
    // From standard input, too.
    let mut child = Command::new(env!("CARGO_BIN_EXE_detune"))
        .args(["trace", "-", "--marks", "marks.yaml"])
        .current_dir(folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let bytes = fs::read(file("clip.y4m")).unwrap();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    assert_eq!(text(&child.wait_with_output().unwrap().stdout), stream);
    // A picture that breaks off, and one of another size.
    let whole = fs::read(file("jpeg/frame7.jpg")).unwrap();
    fs::write(file("jpeg/frame7.jpg"), &whole[..whole.len() / 2]).unwrap();
    fs::copy(file("jpeg/frame1.jpg"), file("png/frame3.png")).unwrap();
    let png = fs::read(file("png/frame4.png")).unwrap();
    fs::write(file("png/frame4.png"), &png[..png.len() / 2]).unwrap();
    for (video, expected) in [("jpeg", "frame7.jpg: is not a whole"), ("png", "frame4.png: is not")]
    {
        let answer = detune(&["trace", video, "--marks", "marks.yaml"], folder.path());
        assert_eq!(answer.status.code(), Some(2), "{video}");
        assert!(text(&answer.stderr).contains(expected), "{}", text(&answer.stderr));
    }
}

#[test]
fn what_cannot_be_traced_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let frames = frames(&even(20), &tip);
    fs::write(file("clip.y4m"), y4m(&CAMERA, 100, &frames)).unwrap();
    fs::write(file("clip.mov"), b"\0\0\0\x20ftypqt  ").unwrap();
    fs::create_dir(file("empty")).unwrap();
    let scale = "scale: {points_px: [[0, 0], [100, 0]], distance_mm: 100}\n";
    for (video, marks, expected) in [
        ("clip.mov", MARKS.to_owned(), "clip.mov: is not YUV4MPEG; make it of a video by: ffmpeg"),
        ("gone", MARKS.to_owned(), "gone: no such file or folder"),
        ("empty", MARKS.to_owned(), "empty: holds no picture, must hold .png or .jpg files"),
        (
            "clip.y4m",
            format!("{scale}marks: [{{name: a, box_px: [80, 0, 28, 28]}}]\n"),
            "marks.yaml:2: mark 'a': box_px reaches out of the picture of 96 × 80 px",
        ),
        (
            "clip.y4m",
            format!("{scale}marks: [{{name: a, box_px: [66, 50, 24, 24]}}]\n"),
            "marks.yaml:2: mark 'a': its box holds no detail in both directions",
        ),
        (
            "clip.y4m",
            format!("{scale}round_marks: {{count: 2}}\n"),
            "marks.yaml:2: round_marks asks for 2, but the first frame shows 1 round mark, at px",
        ),
    ] {
        fs::write(file("marks.yaml"), marks).unwrap();
        let answer = detune(&["trace", video, "--marks", "marks.yaml"], folder.path());
        assert_eq!(answer.status.code(), Some(2), "{expected}");
        assert!(text(&answer.stderr).contains(expected), "{}", text(&answer.stderr));
        assert!(answer.stdout.is_empty());
    }
    // A slow-motion file states the rate at which it is shown.
    fs::write(file("marks.yaml"), format!("frame_rate_hz: 240\n{MARKS}")).unwrap();
    let answer = detune(&["trace", "clip.y4m", "--marks", "marks.yaml"], folder.path());
    assert!(text(&answer.stderr).contains("states 100 frames/s; 240 of frame_rate_hz are used"));
    assert!(text(&answer.stdout).contains("\n0.004166667,"), "{}", text(&answer.stdout));
}
