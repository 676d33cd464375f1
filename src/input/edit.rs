//! A job.yaml with some of its values changed and every other byte kept: comments, order, line
//! ends.

use std::path::{Path, PathBuf};

use super::Reading;
use super::files::{MAX_FILE_BYTES, is_one_place};
use super::job::read_job;
use super::relocated::{named_from, relocated, resolved};
use crate::formats::text::{read_bytes, read_text};
use crate::formats::yaml::Step;
use crate::formats::yaml::splice::{Entry, Splice, entries};
use crate::job::SpindleSpeed;
use crate::notes::{Code, Note, Place};
use crate::program::{Dialect, Rewrite, Rewritten, Settings, rewrite_all};

/// What changes in one operation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OperationEdit {
    /// Takes the place of spindle_rpm or spindle_schedule.
    pub speed: Option<SpindleSpeed>,
    /// Takes the place of feed_mm_per_min, mm/min.
    pub feed_mm_per_min: Option<f64>,
    /// Stands as measured_at_mm_per_rev beside what was measured of a drill, where nobody says it
    /// yet.
    pub measured_at_mm_per_rev: Option<f64>,
    /// Takes the place of path.program.file: a file as seen from where the caller stands.
    pub program: Option<PathBuf>,
}

/// The text of the job `from` with one edit an operation, in order, as it is to stand in the file
/// `to`: relative paths still name the same files.
///
/// # Errors
/// `from` cannot be read, is not a job, or has another number of operations.
pub fn rewritten_job(from: &Path, to: &Path, edits: &[OperationEdit]) -> Result<String, Note> {
    let text = read_text(from, MAX_FILE_BYTES)?;
    let fault = |what: &str| Note::error(Code::NotRewritten, Place::file(from), what);
    let Entries { robot, operations } =
        job_entries(&text).ok_or_else(|| fault("is not a job that can be rewritten"))?;
    if operations.len() != edits.len() {
        return Err(fault("changed during the run: it has a different number of operations"));
    }
    let mut splice = Splice::of(&text);
    let relocate = |named: &str| relocated(named, from, to);
    if let Some(robot) = robot
        && let Some(name) = relocate(&robot.text)
    {
        let name = splice.text_like(&robot.value, &name);
        splice.replace(robot.value, name);
    }
    for (operation, edit) in operations.into_iter().zip(edits) {
        if let (Some(feed), Some(entry)) = (edit.feed_mm_per_min, operation.feed) {
            splice.replace(entry.value, feed.to_string());
        }
        if let Some(entry) = operation.program {
            let name = match &edit.program {
                Some(file) => named_from(to, &resolved(file)),
                None => relocate(&entry.text),
            };
            if let Some(name) = name {
                let name = splice.text_like(&entry.value, &name);
                splice.replace(entry.value, name);
            }
        }
        for entry in operation.files {
            if let Some(name) = relocate(&entry.text) {
                let name = splice.text_like(&entry.value, &name);
                splice.replace(entry.value, name);
            }
        }
        let null = operation.measured_at.as_ref().filter(|entry| splice.is_null(entry)).cloned();
        if let (Some(feed), Some(entry)) = (edit.measured_at_mm_per_rev, null) {
            splice.replace(entry.value, feed.to_string());
        } else if let (Some(feed), None, Some(beside)) =
            (edit.measured_at_mm_per_rev, operation.measured_at, operation.measured)
        {
            let (between, key) = (splice.between(&beside), splice.slice(beside.key.clone()));
            let new = match key.starts_with('"') {
                true => "\"measured_at_mm_per_rev\"",
                false => "measured_at_mm_per_rev",
            };
            splice.replace(beside.key, format!("{new}: {feed}{between}{key}"));
        }
        if let Some(speed) = &edit.speed {
            change_speed(&mut splice, speed, operation.rpm, operation.schedule);
        }
    }
    Ok(splice.finish())
}

/// Changes the speed where one of the keys holds it and the other, if it is there, is null.
fn change_speed(
    splice: &mut Splice<'_>,
    speed: &SpindleSpeed,
    rpm: Option<Entry>,
    schedule: Option<Entry>,
) {
    let (entry, was_constant, null) = match (rpm, schedule) {
        (Some(rpm), Some(schedule)) if splice.is_null(&rpm) => {
            (schedule, false, Some((rpm, "spindle_schedule")))
        }
        (Some(rpm), schedule) => (rpm, true, schedule.map(|null| (null, "spindle_rpm"))),
        (None, Some(schedule)) => (schedule, false, None),
        (None, None) => return,
    };
    match speed {
        SpindleSpeed::Constant(rpm) if was_constant => splice.replace(entry.value, rpm.to_string()),
        _ => {
            splice.replace_entry(&entry, &speed_entry(speed, &entry));
            // The key that is null makes room for the one that now holds the speed.
            let makes_room = was_constant != matches!(speed, SpindleSpeed::Constant(_));
            if let Some((null, name)) = null.filter(|_| makes_room) {
                splice.replace(null.key, name.to_owned());
            }
        }
    }
}

/// The program `file` of a job with other speeds: `to` has what each operation that runs it is to
/// have, in order.
///
/// # Errors
/// It cannot be read or rewritten, or not so that each runs as it is to; its extension is that of
/// no dialect.
pub fn rewritten_program(job: &Path, file: &Path, to: &[Rewrite]) -> Result<Rewritten, Note> {
    let mut reading = Reading::default();
    // The job is valid: what it says beside the program is wanted.
    drop(read_job(job, &mut reading));
    let own = reading.programs.iter().filter(|(read, _)| is_one_place(read, file));
    let own: Vec<&Settings> = own.map(|(_, settings)| settings).collect();
    let fault = |what: &str| Note::error(Code::NotRewritten, Place::file(file), what);
    if own.is_empty() || own.len() != to.len() {
        return Err(fault("changed during the run: another number of operations runs it"));
    }
    let mut runs: Vec<(&Settings, &Rewrite)> = Vec::new();
    for run in own.into_iter().zip(to) {
        if !runs.contains(&run) {
            runs.push(run);
        }
    }
    let bytes = read_bytes(file, MAX_FILE_BYTES)?;
    let dialect = Dialect::of_file(file)
        .ok_or_else(|| fault("is not in a supported dialect (RAPID, APT/CL, G-code)"))?;
    rewrite_all(&bytes, dialect, &runs).map_err(|why| fault(&why.what))
}

/// Where the values stand that may change.
#[derive(Default)]
struct Entries {
    robot: Option<Entry>,
    operations: Vec<OperationEntries>,
}

#[derive(Default)]
struct OperationEntries {
    rpm: Option<Entry>,
    schedule: Option<Entry>,
    feed: Option<Entry>,
    /// The first of thrust_n and torque_nm.
    measured: Option<Entry>,
    measured_at: Option<Entry>,
    program: Option<Entry>,
    /// Further files of the program.
    files: Vec<Entry>,
}

fn job_entries(text: &str) -> Option<Entries> {
    let mut found = Entries::default();
    entries(text, |path, entry| match path {
        [Step::Key("robot")] => found.robot = Some(entry()),
        [Step::Key("operations"), Step::Index(index), rest @ ..] => {
            while found.operations.len() <= *index {
                found.operations.push(OperationEntries::default());
            }
            let Some(operation) = found.operations.get_mut(*index) else { return };
            match rest {
                [Step::Key("spindle_rpm")] => operation.rpm = Some(entry()),
                [Step::Key("spindle_schedule")] => operation.schedule = Some(entry()),
                [Step::Key("feed_mm_per_min")] => operation.feed = Some(entry()),
                [Step::Key("cutting"), Step::Key("thrust_n" | "torque_nm")] => {
                    operation.measured.get_or_insert_with(entry);
                }
                [Step::Key("cutting"), Step::Key("measured_at_mm_per_rev")] => {
                    operation.measured_at = Some(entry());
                }
                [Step::Key("path"), Step::Key("program"), Step::Key("file")] => {
                    operation.program = Some(entry());
                }
                [Step::Key("path"), Step::Key("program"), Step::Key("files"), Step::Index(_)] => {
                    operation.files.push(entry());
                }
                _ => {}
            }
        }
        _ => {}
    })?;
    Some(found)
}

/// Key and value of a speed, in the manner of the mapping around it.
fn speed_entry(speed: &SpindleSpeed, entry: &Entry) -> String {
    let point = |(s, rpm): &(f64, f64)| format!("{{s: {s}, rpm: {rpm}}}");
    match speed {
        SpindleSpeed::Constant(rpm) => format!("spindle_rpm: {rpm}"),
        SpindleSpeed::Schedule(points) if entry.in_braces => {
            let points: Vec<String> = points.iter().map(point).collect();
            format!("spindle_schedule: [{}]", points.join(", "))
        }
        SpindleSpeed::Schedule(points) => {
            let indent = " ".repeat(entry.column);
            let rows = points.iter().map(|at| format!("\n{indent}  - {}", point(at)));
            format!("spindle_schedule:{}", rows.collect::<String>())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::yaml::parse;

    const JOB: &str = "\
# ä comment before\r
robot: r/robot.yaml   # the arm\r
tool: {teeth: 2}\r
operations:   # two\r
  # first\r
  - name: a\r
    spindle_rpm: 1100   # too fast?\r
    feed_mm_per_min: 400 # mm\r
    path: {program: {file: p.nc}}\r
  - {name: b, spindle_rpm: 900, feed_mm_per_min: 5e2, path: {poses: [{xyz_mm: [1, 2, 3]}]}}\r
  - name: c\r
    spindle_schedule:   # by hand\r
      - {s: 0, rpm: 1000}\r
      # the middle\r
      - s: 1\r
        rpm: 1200 # end\r
    # still c\r
    feed_mm_per_min: \"x\"\r
";

    fn edited(name: &str, edits: &[OperationEdit]) -> String {
        let folder = tempfile::tempdir().unwrap();
        for inner in ["jobs/r", "out"] {
            std::fs::create_dir_all(folder.path().join(inner)).unwrap();
        }
        for file in ["jobs/r/robot.yaml", "jobs/p.nc"] {
            std::fs::write(folder.path().join(file), "").unwrap();
        }
        let from = folder.path().join("jobs/job.yaml");
        std::fs::write(&from, JOB).unwrap();
        rewritten_job(&from, &folder.path().join(name), edits).unwrap()
    }

    fn speed(speed: SpindleSpeed) -> OperationEdit {
        OperationEdit { speed: Some(speed), ..OperationEdit::default() }
    }

    #[test]
    fn nothing_to_change_changes_no_byte() {
        let none = vec![OperationEdit::default(); 3];
        assert_eq!(edited("jobs/other.yaml", &none), JOB);
    }

    #[test]
    fn constant_speeds_and_feeds_take_the_place_of_the_old_ones() {
        let first = OperationEdit {
            feed_mm_per_min: Some(487.25),
            ..speed(SpindleSpeed::Constant(1340.0))
        };
        let second =
            OperationEdit { feed_mm_per_min: Some(500.5), ..speed(SpindleSpeed::Constant(901.5)) };
        let third = speed(SpindleSpeed::Constant(1000.0));
        let expected = JOB
            .replace("spindle_rpm: 1100 ", "spindle_rpm: 1340 ")
            .replace("feed_mm_per_min: 400 ", "feed_mm_per_min: 487.25 ")
            .replace(
                "spindle_rpm: 900, feed_mm_per_min: 5e2",
                "spindle_rpm: 901.5, \
                feed_mm_per_min: 500.5",
            )
            .replace(
                "spindle_schedule:   # by hand\r\n      - {s: 0, rpm: 1000}\r\n      # the \
                    middle\r\n      - s: 1\r\n        rpm: 1200 # end",
                "# by hand\r\n    # the middle\r\n    spindle_rpm: 1000 # end",
            );
        assert_eq!(edited("jobs/other.yaml", &[first, second, third]), expected);
    }

    #[test]
    fn schedules_are_written_in_the_manner_of_their_surroundings() {
        let schedule = || speed(SpindleSpeed::Schedule(vec![(0.0, 1200.0), (0.5, 1350.5)]));
        let found = edited("jobs/other.yaml", &[schedule(), schedule(), OperationEdit::default()]);
        let expected = JOB
            .replace(
                "spindle_rpm: 1100 ",
                "spindle_schedule:\r\n      - {s: 0, rpm: 1200}\r\n      - {s: 0.5, rpm: 1350.5} ",
            )
            .replace(
                "spindle_rpm: 900",
                "spindle_schedule: [{s: 0, rpm: 1200}, {s: 0.5, rpm: 1350.5}]",
            );
        assert_eq!(found, expected);
        let mut notes = crate::notes::Notes::about(Place::file(Path::new("x")));
        assert!(parse(&found, &mut notes).is_some());
    }

    #[test]
    fn null_keys_and_folded_names_leave_a_job_that_can_be_read() {
        let folder = tempfile::tempdir().unwrap();
        for inner in ["jobs", "out"] {
            std::fs::create_dir(folder.path().join(inner)).unwrap();
        }
        let (from, to) = (folder.path().join("jobs/a.yaml"), folder.path().join("out/b.yaml"));
        let text = "robot: >-\n  r.yaml\noperations:\n  - spindle_rpm: ~ # none\n    \
            spindle_schedule: [{s: 0, rpm: 900}]\n  - {spindle_schedule: null, spindle_rpm: 900}\n";
        std::fs::write(&from, text).unwrap();
        let edits = [
            speed(SpindleSpeed::Constant(780.0)),
            speed(SpindleSpeed::Schedule(vec![(0.0, 700.0)])),
        ];
        let expected = "robot: >-\n  ../jobs/r.yaml\noperations:\n  - spindle_schedule: ~ # \
            none\n    spindle_rpm: 780\n  - {spindle_rpm: null, spindle_schedule: [{s: 0, rpm: \
                        700}]}\n";
        assert_eq!(rewritten_job(&from, &to, &edits).unwrap(), expected);
    }

    #[test]
    fn relative_paths_still_name_the_same_files() {
        let none = vec![OperationEdit::default(); 3];
        let expected = JOB
            .replace("robot: r/robot.yaml ", "robot: ../jobs/r/robot.yaml ")
            .replace("{file: p.nc}", "{file: ../jobs/p.nc}");
        assert_eq!(edited("out/job.yaml", &none), expected);
    }
}
