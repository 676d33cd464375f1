//! A job.yaml with some of its values changed and every other byte kept: comments, order, line ends.
//!
//! The parser tells where each value stands; what changes is cut out of the text and written anew.

use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use saphyr_parser::{Event, Parser};

use super::text::{LARGEST_JOB_BYTES, LARGEST_PROGRAM_BYTES, read_bytes, read_text};
use crate::job::SpindleSpeed;
use crate::notes::{self, Code, Note};
use crate::program::{Dialect, Rewrite, Rewritten, rewrite};

/// What changes in one operation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OperationEdit {
    /// Takes the place of spindle_rpm or spindle_schedule.
    pub speed: Option<SpindleSpeed>,
    /// Takes the place of feed_mm_per_min, mm/min.
    pub feed_mm_per_min: Option<f64>,
    /// Takes the place of path.program.file: a file as seen from where the caller stands.
    pub program: Option<PathBuf>,
}

/// The text of the job `from` with one edit an operation, in order, as it is to stand in the file `to`:
/// relative paths still name the same files.
///
/// # Errors
/// `from` cannot be read, is not a job, or has another number of operations.
pub fn rewritten_job(from: &Path, to: &Path, edits: &[OperationEdit]) -> Result<String, Note> {
    let text = read_text(from, LARGEST_JOB_BYTES)?;
    let fault = |what: &str| Note::error(Code::NotRewritten, notes::Place::file(from), what);
    let Places { robot, operations } =
        places(&text).ok_or_else(|| fault("is not a job that can be rewritten"))?;
    if operations.len() != edits.len() {
        return Err(fault("has another number of operations than it had"));
    }
    let mut changes: Vec<(Range<usize>, String)> = Vec::new();
    let relocate = |named: &str| relocated(named, from, to);
    if let Some(robot) = robot
        && let Some(name) = relocate(&robot.text)
    {
        changes.push((robot.value, quoted(&name)));
    }
    for (operation, edit) in operations.into_iter().zip(edits) {
        if let (Some(feed), Some(place)) = (edit.feed_mm_per_min, operation.feed) {
            changes.push((place.value, feed.to_string()));
        }
        if let Some(place) = operation.program {
            let name = match &edit.program {
                Some(file) => named_from(to, &resolved(file)),
                None => relocate(&place.text),
            };
            changes.extend(name.map(|name| (place.value, quoted(&name))));
        }
        if let Some(speed) = &edit.speed {
            changes.extend(speed_changes(&text, speed, operation.rpm, operation.schedule));
        }
    }
    for (range, _) in &mut changes {
        // A block scalar ends with its line, which stays.
        let old = slice(&text, range.clone());
        range.end -= old.chars().rev().take_while(|c| c.is_whitespace()).count();
    }
    Ok(spliced(&text, changes))
}

/// What changes where one of the keys tells the speed and the other, if it is there, is null.
fn speed_changes(
    text: &str,
    speed: &SpindleSpeed,
    rpm: Option<Place>,
    schedule: Option<Place>,
) -> Vec<(Range<usize>, String)> {
    let is_constant = matches!(speed, SpindleSpeed::Constant(_));
    let (told, null) = match (rpm, schedule) {
        (Some(rpm), Some(schedule)) if is_null(text, &rpm) => {
            ((schedule, false), Some((rpm, "spindle_schedule")))
        }
        (Some(rpm), schedule) => ((rpm, true), schedule.map(|null| (null, "spindle_rpm"))),
        (None, Some(schedule)) => ((schedule, false), None),
        (None, None) => return Vec::new(),
    };
    match (told, speed) {
        ((place, true), SpindleSpeed::Constant(rpm)) => vec![(place.value, rpm.to_string())],
        ((place, was_constant), _) => {
            let whole = place.key.start..place.value.end;
            let old = slice(text, whole.clone());
            let mut changes = vec![(whole, speed_entry(speed, &place, &old))];
            // The key that is null makes room for the one that now tells the speed.
            let makes_room = was_constant != is_constant;
            let other = null.filter(|_| makes_room);
            changes.extend(other.map(|(null, name)| (null.key, name.to_owned())));
            changes
        }
    }
}

fn is_null(text: &str, place: &Place) -> bool {
    matches!(slice(text, place.value.clone()).trim(), "" | "~" | "null" | "Null" | "NULL")
}

/// The program `file` with another speed; the inner error says why it cannot be rewritten.
///
/// # Errors
/// It cannot be read, or its extension is that of no dialect.
pub fn rewritten_program(file: &Path, to: &Rewrite) -> Result<Result<Rewritten, Note>, Note> {
    let bytes = read_bytes(file, LARGEST_PROGRAM_BYTES)?;
    let fault = |what: &str| Note::error(Code::NotRewritten, notes::Place::file(file), what);
    let extension = file.extension().unwrap_or_default().to_string_lossy();
    let dialect = Dialect::from_extension(&extension)
        .ok_or_else(|| fault("is no program that is understood"))?;
    Ok(rewrite(&bytes, dialect, to).map_err(|why| fault(&why.what)))
}

/// Where the values stand that may change. Ranges count characters.
struct Places {
    robot: Option<Place>,
    operations: Vec<OperationPlaces>,
}

#[derive(Default)]
struct OperationPlaces {
    rpm: Option<Place>,
    schedule: Option<Place>,
    feed: Option<Place>,
    program: Option<Place>,
}

#[derive(Clone)]
struct Place {
    key: Range<usize>,
    /// Of the key, in characters.
    column: usize,
    value: Range<usize>,
    /// The value, if it is a scalar.
    text: String,
    /// Whether the mapping around it is written in braces.
    in_braces: bool,
}

/// A collection that has begun.
struct Open {
    is_mapping: bool,
    in_braces: bool,
    /// Key (text, place, column) that waits for its value, or that the finished value had.
    key: Option<(String, Range<usize>, usize)>,
    awaits_value: bool,
    index: usize,
    start: usize,
}

fn places(text: &str) -> Option<Places> {
    let mut places = Places { robot: None, operations: Vec::new() };
    let mut open: Vec<Open> = Vec::new();
    let mut last_end = 0;
    // Places count characters.
    let wide: Vec<char> = if text.is_ascii() { Vec::new() } else { text.chars().collect() };
    let text_at = |index: usize| {
        if wide.is_empty() {
            text.as_bytes().get(index).map(|&byte| char::from(byte))
        } else {
            wide.get(index).copied()
        }
    };
    for event in Parser::new_from_str(text) {
        let (event, span) = event.ok()?;
        let (start, end) = (span.start.index(), span.end.index());
        match event {
            Event::Scalar(value, ..) => {
                last_end = end;
                if let Some(top) = open.last_mut().filter(|o| o.is_mapping && !o.awaits_value) {
                    top.key = Some((value.into_owned(), start..end, span.start.col()));
                    top.awaits_value = true;
                } else {
                    record(&mut places, &open, start..end, &value);
                    value_done(&mut open);
                }
            }
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                let is_mapping = matches!(event, Event::MappingStart(..));
                // In braces or brackets the start is a token of its own.
                let in_braces =
                    text_at(start) == Some(if is_mapping { '{' } else { '[' }) && end > start;
                let top =
                    Open { is_mapping, in_braces, key: None, awaits_value: false, index: 0, start };
                open.push(top);
            }
            Event::SequenceEnd | Event::MappingEnd => {
                if end > start {
                    last_end = end;
                }
                let ended = open.pop()?;
                record(&mut places, &open, ended.start..last_end, "");
                value_done(&mut open);
            }
            _ => {}
        }
    }
    Some(places)
}

fn value_done(open: &mut [Open]) {
    if let Some(top) = open.last_mut() {
        top.awaits_value = false;
        top.index += 1;
    }
}

/// Keeps the place of a finished value if it may change.
fn record(places: &mut Places, open: &[Open], value: Range<usize>, text: &str) {
    let keys: Vec<&str> = open
        .iter()
        .map(|o| o.key.as_ref().filter(|_| o.is_mapping).map_or("", |(key, ..)| key.as_str()))
        .collect();
    let Some(Open { key: Some((_, key, column)), in_braces, .. }) = open.last() else { return };
    let place = || Place {
        key: key.clone(),
        column: *column,
        value: value.clone(),
        text: text.to_owned(),
        in_braces: *in_braces || open.iter().any(|o| o.in_braces),
    };
    match keys.as_slice() {
        ["robot"] => places.robot = Some(place()),
        ["operations", "", rest @ ..] => {
            let index = open.get(1).map_or(0, |list| list.index);
            while places.operations.len() <= index {
                places.operations.push(OperationPlaces::default());
            }
            let Some(operation) = places.operations.get_mut(index) else { return };
            match rest {
                ["spindle_rpm"] => operation.rpm = Some(place()),
                ["spindle_schedule"] => operation.schedule = Some(place()),
                ["feed_mm_per_min"] => operation.feed = Some(place()),
                ["path", "program", "file"] => operation.program = Some(place()),
                _ => {}
            }
        }
        _ => {}
    }
}

fn slice(text: &str, range: Range<usize>) -> String {
    text.chars().skip(range.start).take(range.len()).collect()
}

/// Key and value of a speed, in the manner of the mapping around it; comments that stood inside the old
/// entry come first.
fn speed_entry(speed: &SpindleSpeed, place: &Place, old: &str) -> String {
    let point = |(s, rpm): &(f64, f64)| format!("{{s: {s}, rpm: {rpm}}}");
    let end = if old.contains("\r\n") { "\r\n" } else { "\n" };
    let indent = " ".repeat(place.column);
    let mut entry: String =
        comments(old).iter().map(|comment| format!("{comment}{end}{indent}")).collect();
    match speed {
        SpindleSpeed::Constant(rpm) => entry.push_str(&format!("spindle_rpm: {rpm}")),
        SpindleSpeed::Schedule(points) if place.in_braces => {
            let points: Vec<String> = points.iter().map(point).collect();
            entry.push_str(&format!("spindle_schedule: [{}]", points.join(", ")));
        }
        SpindleSpeed::Schedule(points) => {
            entry.push_str("spindle_schedule:");
            for at in points {
                entry.push_str(&format!("{end}{indent}  - {}", point(at)));
            }
        }
    }
    entry
}

/// Comments within an entry: `#` after white space, to the end of the line. No value of a schedule holds one.
fn comments(old: &str) -> Vec<&str> {
    old.lines()
        .filter_map(|line| {
            let at = line.find('#')?;
            let before = line.get(..at)?;
            let is_comment = before.is_empty() || before.ends_with(char::is_whitespace);
            is_comment.then(|| line.get(at..)).flatten().map(str::trim_end)
        })
        .collect()
}

/// The text with the ranges (of characters, not overlapping) replaced.
fn spliced(text: &str, mut changes: Vec<(Range<usize>, String)>) -> String {
    changes.sort_by_key(|(range, _)| range.start);
    let mut out = String::with_capacity(text.len());
    let mut changes = changes.into_iter().peekable();
    let mut skip_to = 0;
    for (index, c) in text.chars().enumerate() {
        while let Some((range, new)) = changes.next_if(|(range, _)| range.start == index) {
            out.push_str(&new);
            skip_to = range.end;
        }
        if index >= skip_to {
            out.push(c);
        }
    }
    out
}

/// `named` in the file `from`, as the file `to` must name it; `None` where nothing changes.
fn relocated(named: &str, from: &Path, to: &Path) -> Option<String> {
    if Path::new(named).is_absolute() || resolved(folder_of(from)) == resolved(folder_of(to)) {
        return None;
    }
    named_from(to, &resolved(&folder_of(from).join(named)))
}

/// An absolute file as the file `by` names it: relative where the two have anything in common.
fn named_from(by: &Path, file: &Path) -> Option<String> {
    let folder = resolved(folder_of(by));
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let is_rooted = |c: &Component| matches!(c, Component::Normal(_));
    let name = if folder.components().take(shared).any(|c| is_rooted(&c)) || shared > 0 {
        let up = folder.components().skip(shared).map(|_| "..".to_owned());
        let down = file.components().skip(shared);
        let down = down.map(|part| part.as_os_str().to_str().map(str::to_owned));
        let parts: Option<Vec<String>> = up.map(Some).chain(down).collect();
        parts?.join("/")
    } else {
        file.to_str()?.to_owned()
    };
    Some(name)
}

fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Absolute, with links followed where the file is there; a file that is not yet there, in its folder.
fn resolved(path: &Path) -> PathBuf {
    path.canonicalize()
        .or_else(|error| match path.file_name() {
            Some(name) => folder_of(path).canonicalize().map(|folder| folder.join(name)),
            None => Err(error),
        })
        .or_else(|_| std::path::absolute(path))
        .unwrap_or_else(|_| path.to_owned())
}

/// Plain where that is text beyond doubt, else in double quotes.
fn quoted(name: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '/' | '.' | '_' | '-');
    let has_letter = name.contains(|c: char| c.is_ascii_alphabetic());
    let begins_well = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '.' || c == '/');
    if name.chars().all(is_plain) && has_letter && begins_well && name.contains(['/', '.']) {
        name.to_owned()
    } else {
        format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::yaml::parse;

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
            .replace("spindle_rpm: 900, feed_mm_per_min: 5e2", "spindle_rpm: 901.5, feed_mm_per_min: 500.5")
            .replace(
                "spindle_schedule:   # by hand\r\n      - {s: 0, rpm: 1000}\r\n      # the middle\r\n      - s: 1\r\n        rpm: 1200 # end",
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
                "spindle_schedule:\n      - {s: 0, rpm: 1200}\n      - {s: 0.5, rpm: 1350.5} ",
            )
            .replace(
                "spindle_rpm: 900",
                "spindle_schedule: [{s: 0, rpm: 1200}, {s: 0.5, rpm: 1350.5}]",
            );
        assert_eq!(found, expected);
        let mut notes = notes::Notes::about(notes::Place::file(Path::new("x")));
        assert!(parse(&found, &mut notes).is_some());
    }

    #[test]
    fn null_keys_and_folded_names_leave_a_job_that_can_be_read() {
        let folder = tempfile::tempdir().unwrap();
        for inner in ["jobs", "out"] {
            std::fs::create_dir(folder.path().join(inner)).unwrap();
        }
        let (from, to) = (folder.path().join("jobs/a.yaml"), folder.path().join("out/b.yaml"));
        let text = "robot: >-\n  r.yaml\noperations:\n  - spindle_rpm: ~ # none\n    spindle_schedule: \
                    [{s: 0, rpm: 900}]\n  - {spindle_schedule: null, spindle_rpm: 900}\n";
        std::fs::write(&from, text).unwrap();
        let edits = [
            speed(SpindleSpeed::Constant(780.0)),
            speed(SpindleSpeed::Schedule(vec![(0.0, 700.0)])),
        ];
        let expected = "robot: >-\n  ../jobs/r.yaml\noperations:\n  - spindle_schedule: ~ # none\n    \
                        spindle_rpm: 780\n  - {spindle_rpm: null, spindle_schedule: [{s: 0, rpm: 700}]}\n";
        assert_eq!(rewritten_job(&from, &to, &edits).unwrap(), expected);
    }

    #[test]
    fn relative_paths_still_name_the_same_files() {
        let none = vec![OperationEdit::default(); 3];
        let expected = JOB
            .replace("robot: r/robot.yaml ", "robot: ../jobs/r/robot.yaml ")
            .replace("{file: p.nc}", "{file: ../jobs/p.nc}");
        assert_eq!(edited("out/job.yaml", &none), expected);
        assert_eq!(quoted("a b.mod"), "\"a b.mod\"");
        assert_eq!(quoted("12"), "\"12\"");
    }
}
