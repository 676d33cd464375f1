//! marks.yaml, and tables of the times of frames.

use std::path::{Path, PathBuf};

use super::files::{MAX_FILE_BYTES, MAX_ROBOT_BYTES};
use super::raw::marks as raw;
use super::{Reading, schema};
use crate::formats::records::seconds_of;
use crate::formats::table::Table;
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, Step, document};
use crate::notes::{Code, Note, Notes, Place};
use crate::trace::Area;
use crate::units::{m_from_mm, s_from_ms};
use crate::wording::hint;

/// Most marks, smallest side of a box, px, and most pixels in all boxes.
const MAX_MARKS: usize = 200;
const MIN_SIDE_PX: usize = 6;
const MAX_BOXES_PX: usize = 1 << 22;

/// Frame rates of cameras, Hz, and the longest readout, s.
const RATES_HZ: [f64; 2] = [0.1, 1e6];
const MAX_READOUT_S: f64 = 1.0;

/// What is to be followed, and how pictures become metres and seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceSetup {
    /// The file.
    pub file: PathBuf,
    /// The marks.
    pub marks: Wanted,
    /// The known distance.
    pub scale: Scale,
    /// Frames a second, where the file states them.
    pub frame_rate_hz: Option<f64>,
    /// Time from the first to the last row, s.
    pub readout_s: f64,
    /// The side that is read first.
    pub readout_from: Side,
}

/// Marks by their boxes, or to be found.
#[derive(Debug, Clone, PartialEq)]
pub enum Wanted {
    /// With their boxes.
    Boxes(Vec<MarkBox>),
    /// Round ones from left to right, by their names.
    Round {
        /// The names.
        names: Vec<String>,
        /// Line of the file that asks for them.
        line: usize,
    },
}

/// A mark and where it is in the first frame.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkBox {
    /// Its name.
    pub name: String,
    /// Its box.
    pub area: Area,
    /// Line of the box in the file.
    pub line: usize,
}

/// A known distance.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// The distance, m.
    pub distance_m: f64,
    /// What is so far apart.
    pub between: Between,
    /// Line of the file.
    pub line: usize,
}

/// Two places in the first frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Between {
    /// The middles of two marks.
    Marks([String; 2]),
    /// Points, px.
    Points([[f64; 2]; 2]),
}

/// A side of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The first row.
    Top,
    /// The last row.
    Bottom,
    /// The first column.
    Left,
    /// The last column.
    Right,
}

/// Reads a marks.yaml.
///
/// # Errors
/// Every fault, each with its line.
pub fn read_marks(path: &Path, reading: &mut Reading) -> Result<TraceSetup, Vec<Note>> {
    reading.files.push(path.to_owned());
    let mut notes = Notes::about(Place::file(path));
    let text = read_text(path, MAX_ROBOT_BYTES)?;
    let schema = schema::of::<raw::Marks>();
    let Some((tree, raw)) = document::<raw::Marks>(&text, &schema, &mut notes) else {
        return Err(reading.settle(notes));
    };
    let mut reader = Reader { path, tree: &tree, notes };
    let setup = reader.setup(&raw);
    let errors = reading.settle(reader.notes);
    match setup {
        Some(setup) if errors.is_empty() => Ok(setup),
        _ => Err(errors),
    }
}

struct Reader<'r> {
    path: &'r Path,
    tree: &'r Node,
    notes: Notes,
}

impl Reader<'_> {
    fn error(&mut self, code: Code, steps: &[Step<'_>], what: impl Into<String>) {
        let line = self.tree.line_at(steps);
        self.notes.error(code, line, what);
    }

    fn setup(&mut self, raw: &raw::Marks) -> Option<TraceSetup> {
        let [low, high] = RATES_HZ;
        if let Some(rate) = raw.frame_rate_hz.filter(|rate| !(low..=high).contains(rate)) {
            let what = format!("frame_rate_hz is {rate}, must lie between {low} and {high}");
            self.error(Code::Value, &[Step::Key("frame_rate_hz")], what);
        }
        let readout_s = s_from_ms(raw.readout_ms.unwrap_or(0.0));
        if !(0.0..=MAX_READOUT_S).contains(&readout_s) {
            let what = format!(
                "readout_ms is {}, must lie between 0 and 1000: a few to some 30 ms are usual",
                raw.readout_ms.unwrap_or(0.0)
            );
            self.error(Code::Value, &[Step::Key("readout_ms")], what);
        }
        if raw.readout_from.is_some() && readout_s == 0.0 {
            let what = "readout_from has no effect without readout_ms";
            let line = self.tree.line_at(&[Step::Key("readout_from")]);
            self.notes.warning(Code::Unused, line, what);
        }
        let marks = self.marks(raw);
        let names: Vec<String> = match &marks {
            Some(Wanted::Boxes(marks)) => marks.iter().map(|mark| mark.name.clone()).collect(),
            Some(Wanted::Round { names, .. }) => names.clone(),
            None => Vec::new(),
        };
        let scale = self.scale(raw.scale.as_ref()?, &names);
        Some(TraceSetup {
            file: self.path.to_owned(),
            marks: marks?,
            scale: scale?,
            frame_rate_hz: raw.frame_rate_hz,
            readout_s,
            readout_from: match raw.readout_from {
                None | Some(raw::Side::Top) => Side::Top,
                Some(raw::Side::Bottom) => Side::Bottom,
                Some(raw::Side::Left) => Side::Left,
                Some(raw::Side::Right) => Side::Right,
            },
        })
    }

    fn marks(&mut self, raw: &raw::Marks) -> Option<Wanted> {
        match (&raw.marks, &raw.round_marks) {
            (Some(marks), None) => self.boxes(marks),
            (None, Some(round)) => self.round(round),
            (Some(_), Some(_)) => {
                let what = "has both marks and round_marks, must have one";
                self.error(Code::Conflict, &[Step::Key("round_marks")], what);
                None
            }
            (None, None) => {
                // Marks that are there and wrong were told.
                if self.notes.errors() == 0 {
                    self.error(Code::MissingKey, &[], "has neither marks nor round_marks");
                }
                None
            }
        }
    }

    fn boxes(&mut self, marks: &[raw::Mark]) -> Option<Wanted> {
        let mut found: Vec<MarkBox> = Vec::new();
        let mut pixels = 0;
        if marks.len() > MAX_MARKS {
            let what = format!("has {} marks, at most {MAX_MARKS} can be followed", marks.len());
            self.error(Code::TooLong, &[Step::Key("marks")], what);
        }
        for (index, mark) in marks.iter().enumerate().take(MAX_MARKS) {
            let steps = |key| [Step::Key("marks"), Step::Index(index), Step::Key(key)];
            let Some(name) = &mark.name else { continue };
            let others: Vec<&str> = found.iter().map(|mark| mark.name.as_str()).collect();
            self.check_name(name, &others, &steps("name"));
            let Some(corners) = mark.box_px else { continue };
            let area = area(corners);
            if let Some(Area { width, height, .. }) = area {
                pixels += width * height;
            }
            match area {
                Some(area) if pixels <= MAX_BOXES_PX => found.push(MarkBox {
                    name: name.clone(),
                    area,
                    line: self.tree.line_at(&steps("box_px")),
                }),
                _ => {
                    let what = format!(
                        "mark '{name}': box_px is {corners:?}, must be left, top, width and height \
                            in whole pixels of the picture, {MIN_SIDE_PX} or more a side"
                    );
                    self.error(Code::Value, &steps("box_px"), what);
                }
            }
        }
        (found.len() == marks.len()).then_some(Wanted::Boxes(found))
    }

    fn round(&mut self, round: &raw::RoundMarks) -> Option<Wanted> {
        let count = round.count? as usize;
        let key = Step::Key("round_marks");
        if let Some(names) = &round.names {
            if names.len() != count {
                let what = format!(
                    "round_marks has {} names, must have as many as its count, {count}",
                    names.len()
                );
                self.error(Code::Conflict, &[key, Step::Key("names")], what);
            }
            for (index, name) in names.iter().enumerate() {
                let others: Vec<&str> = names[..index].iter().map(String::as_str).collect();
                self.check_name(name, &others, &[key, Step::Key("names"), Step::Index(index)]);
            }
        }
        let numbered = || (1..=count).map(|number| format!("mark_{number}")).collect();
        let names = round.names.clone().unwrap_or_else(numbered);
        Some(Wanted::Round { names, line: self.tree.line_at(&[key]) })
    }

    fn check_name(&mut self, name: &str, others: &[&str], steps: &[Step<'_>]) {
        let shown = name.escape_debug();
        if name.trim() != name || name.is_empty() || name.contains([',', '"', '\n', '\r', '#']) {
            let what = format!("name is '{shown}', must be the name of a column");
            self.error(Code::Value, steps, what);
        } else if others.contains(&name) {
            self.error(Code::Conflict, steps, format!("two marks are called '{shown}'"));
        }
    }

    fn scale(&mut self, raw: &raw::Scale, names: &[String]) -> Option<Scale> {
        let key = Step::Key("scale");
        let between = match (&raw.marks, &raw.points_px) {
            (Some(marks), None) => {
                let mut is_known = true;
                for (index, name) in marks.iter().enumerate() {
                    if !names.is_empty() && !names.contains(name) {
                        is_known = false;
                        let what = format!(
                            "scale: there is no mark '{name}'{}",
                            hint(name, names.iter().map(String::as_str))
                        );
                        let steps = [key, Step::Key("marks"), Step::Index(index)];
                        self.error(Code::Reference, &steps, what);
                    }
                }
                match marks.as_slice() {
                    [a, b] if a == b => {
                        let what = format!("scale: both marks are '{a}', must be two");
                        self.error(Code::Conflict, &[key, Step::Key("marks")], what);
                        None
                    }
                    [a, b] if is_known => Some(Between::Marks([a.clone(), b.clone()])),
                    _ => None,
                }
            }
            (None, Some(points)) => match points.as_slice() {
                &[a, b] if f64::hypot(a[0] - b[0], a[1] - b[1]) >= 1.0 => {
                    Some(Between::Points([a, b]))
                }
                _ => {
                    let what = "scale: points_px must be two points, a pixel or more apart";
                    self.error(Code::Value, &[key, Step::Key("points_px")], what);
                    None
                }
            },
            (Some(_), Some(_)) => {
                let what = "scale has both marks and points_px, must have one";
                self.error(Code::Conflict, &[key], what);
                None
            }
            (None, None) => {
                let what = "scale has neither marks nor points_px, must have one";
                self.error(Code::MissingKey, &[key], what);
                None
            }
        };
        Some(Scale {
            distance_m: m_from_mm(raw.distance_mm?),
            between: between?,
            line: self.tree.line_at(&[key]),
        })
    }
}

/// A box of whole pixels.
fn area(corners: [f64; 4]) -> Option<Area> {
    let is_whole = |value: &f64| value.fract() == 0.0 && (0.0..=65_536.0).contains(value);
    let [left, top, width, height] = corners.iter().all(is_whole).then_some(corners)?;
    let [left, top, width, height] = [left, top, width, height].map(|value| value as usize);
    let is_large = width.min(height) >= MIN_SIDE_PX;
    is_large.then_some(Area { left, top, width, height })
}

/// Reads the times of frames, s: a table with a column `time_s` (or `t [ms]`, …).
///
/// # Errors
/// Every fault with its line; times that do not rise.
pub fn read_times(path: &Path, reading: &mut Reading) -> Result<Vec<f64>, Vec<Note>> {
    reading.files.push(path.to_owned());
    let text = read_text(path, MAX_FILE_BYTES)?;
    let mut notes = Notes::about(Place::file(path));
    let mut table = Table::open(path, text.as_bytes())?;
    let column = table.header().iter().enumerate().find_map(|(k, t)| Some((k, seconds_of(t)?)));
    let Some((column, to_s)) = column else {
        let what = "has no column of times, must have time_s, or time_ms";
        notes.error(Code::MissingKey, table.line(), what);
        return Err(reading.settle(notes));
    };
    let (mut times, mut cells) = (Vec::<f64>::new(), Vec::new());
    loop {
        match table.row(&mut cells) {
            Ok(true) => {}
            Ok(false) => break,
            Err(note) => {
                notes.push(note);
                break;
            }
        }
        match table.number(&cells, column).map(to_s) {
            Ok(time) if times.last().is_some_and(|last| time <= *last) => {
                let what = format!("the time {time} s is not after that of the row before");
                notes.error(Code::Value, table.line(), what);
            }
            Ok(time) => times.push(time),
            Err(fault) => notes.push(fault),
        }
    }
    let errors = reading.settle(notes);
    if errors.is_empty() { Ok(times) } else { Err(errors) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<TraceSetup, Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.yaml");
        std::fs::write(&path, text).unwrap();
        let prefix = format!("{}/", folder.path().display());
        read_marks(&path, &mut Reading::default())
            .map_err(|notes| notes.iter().map(|f| f.to_string().replace(&prefix, "")).collect())
    }

    #[test]
    fn marks_arrive_with_their_boxes_and_the_scale() {
        let setup = read(
            "readout_ms: 16\nscale: {marks: [a, b], distance_mm: 300}\nmarks:\n  - {name: a, \
             box_px: [1, 2, 20, 24]}\n  - {name: b, box_px: [90, 2, 20, 24]}\n",
        )
        .unwrap();
        assert_eq!((setup.readout_s, setup.readout_from), (0.016, Side::Top));
        assert_eq!((setup.scale.distance_m, setup.scale.line), (0.3, 2));
        let Wanted::Boxes(marks) = setup.marks else { panic!() };
        assert_eq!((marks[1].name.as_str(), marks[1].line), ("b", 5));
        assert_eq!(marks[0].area, Area { left: 1, top: 2, width: 20, height: 24 });
        let setup =
            read("round_marks: {count: 2}\nscale: {points_px: [[0, 0], [3, 4]], distance_mm: 5}\n")
                .unwrap();
        let Wanted::Round { names, .. } = setup.marks else { panic!() };
        assert_eq!(names, ["mark_1", "mark_2"]);
    }

    #[test]
    fn every_fault_is_told_with_its_line() {
        let scale = "scale: {points_px: [[0, 0], [3, 4]], distance_mm: 5}\n";
        for (text, expected) in [
            ("marks: []\n".to_owned(), vec!["m.yaml:1: marks", "m.yaml:1: missing key 'scale'"]),
            (
                format!("{scale}marks:\n  - {{name: a, bix_px: [1, 2, 3, 4]}}\n"),
                vec!["m.yaml:3: mark 'a': unknown key 'bix_px'; did you mean 'box_px'?"],
            ),
            (
                format!(
                    "{scale}marks:\n- {{name: a, box_px: [1.5, 2, 9, 9]}}\n\
                         - {{name: 'b,', box_px: [1, 2, 9, 9]}}\n"
                ),
                vec!["m.yaml:3: mark 'a': box_px is [1.5", "m.yaml:4: name is 'b,'"],
            ),
            (
                format!("{scale}round_marks: {{count: 2, names: [a]}}\nreadout_ms: 5000\n"),
                vec!["m.yaml:2: round_marks has 1 names", "m.yaml:3: readout_ms is 5000"],
            ),
            (
                "scale: {marks: [a, elbw], distance_mm: 5}\n\
                 round_marks: {count: 2, names: [a, elbow]}\n"
                    .to_owned(),
                vec!["m.yaml:1: scale: there is no mark 'elbw'; did you mean 'elbow'?"],
            ),
            (
                format!(
                    "{scale}round_marks: {{count: 2}}\n\
                         marks: [{{name: a, box_px: [1, 2, 9, 9]}}]\n"
                ),
                vec!["m.yaml:2: has both marks and round_marks"],
            ),
            (scale.to_owned(), vec!["m.yaml:1: has neither marks nor round_marks"]),
        ] {
            let told = read(&text).unwrap_err();
            assert_eq!(told.len(), expected.len(), "{text}{told:?}");
            for (told, expected) in told.iter().zip(expected) {
                assert!(told.starts_with(expected), "{text}{told}");
            }
        }
    }

    #[test]
    fn times_rise_and_have_their_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let told = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_times(&path, &mut Reading::default()).map_err(|notes| notes[0].message())
        };
        assert_eq!(told("time_ms\n0\n33\n").unwrap(), [0.0, 0.033]);
        assert!(told("pts\n0\n").unwrap_err().starts_with("has no column of times"));
        assert!(told("time_s\n0\n1\n1\n").unwrap_err().starts_with("the time 1 s is not after"));
    }
}
