//! `detune diagnose` as a black box, over many cases.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::arm::Arm;
use super::case::Case;
use super::confusion::Confusion;
use super::score::{Diagnosis, Named, Score};

/// A diagnosis that takes longer hangs; a minute is asked for in a release build.
const LONGEST: Duration = Duration::from_secs(900);

/// How the cases are run.
#[derive(Debug, Clone)]
pub(crate) struct Settings {
    /// Where cases are kept; a folder that vanishes if absent.
    pub(crate) keep: Option<PathBuf>,
    /// Whether groups are to be split by the suggested poses.
    pub(crate) split: bool,
}

/// The program that is judged: this build's, or another one that the environment names.
fn program() -> PathBuf {
    std::env::var_os("DETUNE_PROGRAM")
        .map_or_else(|| PathBuf::from(env!("CARGO_BIN_EXE_detune")), PathBuf::from)
}

/// One processor among those of the machine, for as long as this lives: tests run side by side, and each would
/// fill all of them.
struct Processor;

static BUSY: (Mutex<usize>, Condvar) = (Mutex::new(0), Condvar::new());

fn processors() -> usize {
    thread::available_parallelism().map_or(2, usize::from)
}

impl Processor {
    fn wait() -> Self {
        let mut busy = BUSY.0.lock().unwrap();
        while *busy >= processors() {
            busy = BUSY.1.wait(busy).unwrap();
        }
        *busy += 1;
        Self
    }
}

impl Drop for Processor {
    fn drop(&mut self) {
        *BUSY.0.lock().unwrap() -= 1;
        BUSY.1.notify_one();
    }
}

/// Runs the program on one processor, in a folder; its standard output, or what went wrong. What it says does
/// not depend on the number of its threads.
pub(crate) fn detune(folder: &Path, arguments: &[&str], answer: &str) -> Result<String, String> {
    let (out, err) = (folder.join(answer), folder.join("stderr.txt"));
    let _processor = Processor::wait();
    let mut child = Command::new(program())
        .args(arguments)
        .env("RAYON_NUM_THREADS", "1")
        .current_dir(folder)
        .stdout(File::create(&out).unwrap())
        .stderr(File::create(&err).unwrap())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > LONGEST {
            child.kill().unwrap();
            child.wait().unwrap();
            return Err(format!("no answer within {} s", LONGEST.as_secs()));
        }
        thread::sleep(Duration::from_millis(10));
    };
    if !status.success() {
        let told = fs::read_to_string(&err).unwrap();
        return Err(format!("{status}: {}", told.trim()));
    }
    Ok(fs::read_to_string(&out).unwrap())
}

/// Diagnoses a robot and a table that lie in a folder.
pub(crate) fn diagnose(folder: &Path, answer: &str) -> Result<Diagnosis, String> {
    let arguments = ["diagnose", "robot.yaml", "measured.csv", "--format", "json", "--seed", "1"];
    let text = detune(folder, &arguments, answer)?;
    let json: Value = serde_json::from_str(&text).map_err(|error| format!("no JSON: {error}"))?;
    Diagnosis::read(&json)
}

/// Diagnoses a case and judges the answer.
pub(crate) fn judge(case: &Case, folder: &Path, split: bool) -> Result<Score, String> {
    case.write(folder);
    let diagnosis = diagnose(folder, "diagnosis.json")?;
    let mut score = Score::of(case, &diagnosis);
    if split {
        score.split = split_by_suggestion(case, folder, &score, &diagnosis)?;
    }
    Ok(score)
}

/// Whether measuring at the suggested poses parts, in a group that holds a hidden effect, the finding from a rival as
/// promised, and leaves the effect named. Only what was promised counts: groups are cut at four, and who is fifth moves
/// up. `None` where nothing was promised of such a group.
fn split_by_suggestion(
    case: &Case,
    folder: &Path,
    score: &Score,
    diagnosis: &Diagnosis,
) -> Result<Option<bool>, String> {
    let joints = case.nominal.joints.len();
    let poses: Vec<_> =
        diagnosis.next_poses.iter().filter(|pose| pose.joints.len() == joints).collect();
    let promised = |i: usize| {
        let own = diagnosis.findings[i].named.label();
        let of = poses.iter().filter(move |pose| pose.separates[0] == own);
        of.map(|pose| pose.separates.clone()).collect::<Vec<_>>()
    };
    let open: Vec<(usize, Vec<[String; 2]>)> = (0..score.answers.len())
        .filter_map(|k| Some((k, promised(score.answers[k].finding?))))
        .filter(|(_, pairs)| !pairs.is_empty())
        .collect();
    if open.is_empty() {
        return Ok(None);
    }
    let after = folder.join("after");
    let poses: Vec<Vec<f64>> = poses.iter().map(|pose| pose.joints.clone()).collect();
    let more = case.measured_also_at(&poses, case.order.seed);
    more.write(&after);
    let diagnosis = diagnose(&after, "diagnosis.json")?;
    let again = Score::of(&more, &diagnosis);
    Ok(Some(open.iter().any(|(k, pairs)| {
        let Some(finding) = again.answers[*k].finding.map(|i| &diagnosis.findings[i]) else {
            return false;
        };
        let group: Vec<String> =
            finding.group.iter().chain([&finding.named]).map(Named::label).collect();
        pairs.iter().any(|pair| !pair.iter().all(|label| group.contains(label)))
    })))
}

/// Judges all cases on all processors; the tables are in the order of the cases.
pub(crate) fn judge_all(cases: &[Case], settings: &Settings) -> Confusion {
    let next = AtomicUsize::new(0);
    let scores: Mutex<Vec<(usize, Result<Score, String>)>> = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..processors() {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(i) else { break };
                    let score = match &settings.keep {
                        Some(keep) => judge(case, &keep.join(case.name()), settings.split),
                        None => {
                            let folder = tempfile::tempdir().unwrap();
                            judge(case, folder.path(), settings.split)
                        }
                    };
                    scores.lock().unwrap().push((i, score));
                }
            });
        }
    });
    let mut scores = scores.into_inner().unwrap();
    scores.sort_by_key(|(i, _)| *i);
    let mut confusion = Confusion::default();
    for (i, score) in scores {
        match score {
            Ok(score) => confusion.add(&cases[i], &score),
            Err(fault) => confusion.add_failure(&cases[i], &fault),
        }
    }
    confusion
}

/// Frequencies of `detune map` at poses.
pub(crate) fn map(folder: &Path, arm: &Arm, poses: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let is_mode = |name: &str| name.starts_with('f') && name.ends_with("_hz");
    map_columns(folder, &["robot.yaml"], arm, poses, &is_mode)
}

/// Some columns of `detune map` at poses, one row a pose.
pub(crate) fn map_columns(
    folder: &Path,
    arguments: &[&str],
    arm: &Arm,
    poses: &[Vec<f64>],
    is_wanted: &dyn Fn(&str) -> bool,
) -> Vec<Vec<f64>> {
    let names: Vec<String> = arm.joints.iter().map(|j| format!("{}_rad", j.name)).collect();
    let mut text = names.join(",") + "\n";
    for q in poses {
        let cells: Vec<String> = q.iter().map(f64::to_string).collect();
        text += &(cells.join(",") + "\n");
    }
    fs::write(folder.join("poses.csv"), text).unwrap();
    let arguments = [&["map", "--poses", "poses.csv"], arguments].concat();
    let csv = detune(folder, &arguments, "map.csv").unwrap();
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let wanted: Vec<usize> = (0..head.len()).filter(|&c| is_wanted(head[c])).collect();
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            wanted.iter().map(|&c| cells[c].parse().unwrap()).collect()
        })
        .collect()
}
