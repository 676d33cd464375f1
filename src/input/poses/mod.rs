//! Poses of a robot from a table, as CSV, NumPy's .npy or (a feature) Apache Arrow: read in pieces
//! of raw bytes, which any thread can take apart.

#[cfg(feature = "arrow")]
mod arrow;
mod csv;

use std::fmt;
use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use self::csv::Columns;
use crate::formats::npy::{Layout, MAGIC, Rows};
use crate::formats::table::Table;
use crate::model::Robot;
use crate::notes::{Code, Note, Place};

/// Errors of one piece that are reported.
const MAX_ERRORS: usize = 20;

/// What an Arrow file begins with, and what a stream does.
const ARROW_FILE: &[u8] = b"ARROW1";

/// What is read from: the bytes that show the format, then the rest.
type Stream = io::Chain<Cursor<Vec<u8>>, Box<dyn Read>>;

/// A table of poses as it streams in.
pub struct PoseTable {
    source: Source,
    decoder: PoseDecoder,
}

enum Source {
    Csv(Table<Stream>),
    Npy(Rows<Stream>),
    #[cfg(feature = "arrow")]
    Arrow(Box<arrow::Batches<Stream>>),
}

/// Some rows of a table as they stand in it.
#[derive(Debug, Clone, Default)]
pub struct RawPoses {
    bytes: Vec<u8>,
    /// Rows of an array.
    rows: usize,
    #[cfg(feature = "arrow")]
    batch: Option<arrow_array::RecordBatch>,
}

/// Some poses of a table. A place is a line of CSV or a row of anything else.
#[derive(Debug, Clone, Default)]
pub struct DecodedPoses {
    /// How many poses.
    pub count: usize,
    /// Joint positions, rad or m, base to tip, pose after pose.
    pub values: Vec<f64>,
    /// How many places there are, comments and all.
    pub places: usize,
    /// Faults, at most twenty, each with its place among those, from zero.
    pub faults: Vec<(usize, String)>,
    /// Place of each pose; empty where every place is a pose.
    place_of: Vec<u32>,
}

impl DecodedPoses {
    /// Forgets all; keeps the room.
    pub fn clear(&mut self) {
        self.count = 0;
        self.places = 0;
        self.values.clear();
        self.faults.clear();
        self.place_of.clear();
    }

    /// The place of a pose, both from zero.
    pub fn place_of(&self, pose: usize) -> usize {
        self.place_of.get(pose).map_or(pose, |&place| place as usize)
    }

    /// Takes `rows` rows of values for poses; those that are not finite are faults, `shown` as they
    /// were read.
    fn all_rows(&mut self, rows: usize, titles: &[String], shown: impl Fn(usize, f64) -> String) {
        (self.count, self.places) = (rows, rows);
        if self.values.iter().all(|value| value.is_finite()) {
            return;
        }
        let bad = self.values.iter().enumerate().filter(|(_, value)| !value.is_finite());
        self.faults.extend(bad.take(MAX_ERRORS).map(|(i, &value)| {
            let title = &titles[i % titles.len()];
            let what = format!("{title} is {}, must be a finite number", shown(i, value));
            (i / titles.len(), what)
        }));
    }

    fn push_place(&mut self) {
        self.count += 1;
        // A piece is far smaller than 2³² bytes, let alone lines.
        self.place_of.push(self.places as u32);
    }
}

/// Takes pieces of a table apart; shared between threads as it is.
#[derive(Debug, Clone)]
pub struct PoseDecoder {
    file: PathBuf,
    format: Format,
}

#[derive(Debug, Clone)]
enum Format {
    Csv {
        columns: Columns,
        first_line: usize,
    },
    Npy {
        layout: Layout,
        joints: Vec<String>,
    },
    #[cfg(feature = "arrow")]
    Arrow(Columns),
}

impl PoseDecoder {
    /// Takes `raw` apart, in place of what `out` holds.
    pub fn decode(&self, raw: &RawPoses, out: &mut DecodedPoses) {
        out.clear();
        match &self.format {
            Format::Csv { columns, .. } => columns.decode(&raw.bytes, out),
            Format::Npy { layout, joints } => {
                layout.decode(raw.rows, &raw.bytes, &mut out.values);
                out.all_rows(raw.rows, joints, |_, value| value.to_string());
            }
            #[cfg(feature = "arrow")]
            Format::Arrow(columns) => {
                if let Some(batch) = &raw.batch {
                    arrow::decode(batch, columns, out);
                }
            }
        }
    }

    /// A fault at a place, counted from the table's first, from zero.
    pub fn fault(&self, place: usize, what: &str) -> Note {
        match self.format {
            Format::Csv { first_line, .. } => {
                let place = Place::line(&self.file, first_line + place);
                Note::error(Code::Value, place, what)
            }
            _ => error(&self.file, format!("row {}: {what}", place + 1)),
        }
    }
}

impl PoseTable {
    /// Opens a table. CSV: a header, then one row a pose; for each moving joint one column `<joint
    /// name>_rad` or `_deg` (a prismatic joint: `_m` or `_mm`; `_rad` is read as m), in any order;
    /// other columns are passed over, and so are lines that begin with `#`. NumPy's .npy, known by
    /// its first bytes: an array of float64 or float32, one row a pose, one column per moving joint
    /// from base to tip, rad or m. With the feature `arrow`, Apache Arrow files and streams, too:
    /// columns of float64 or float32 with the titles of the CSV.
    ///
    /// # Errors
    /// A file that cannot be read; a header that lacks a joint or names one twice; an array of
    /// another shape or type.
    pub fn open(path: &Path, robot: &Robot) -> Result<Self, Vec<Note>> {
        let unreadable = |why: io::Error| vec![error(path, format!("cannot be read: {why}"))];
        let file = File::open(path).map_err(unreadable)?;
        let again = file.try_clone().map_err(unreadable)?;
        Self::new(Box::new(file), Some(again), path, robot)
    }

    /// [`Self::open`] for anything that can be read; `name` stands for it in faults.
    ///
    /// # Errors
    /// As [`Self::open`]; an array that is stored column after column.
    pub fn from_reader(
        reader: Box<dyn Read>,
        name: &Path,
        robot: &Robot,
    ) -> Result<Self, Vec<Note>> {
        Self::new(reader, None, name, robot)
    }

    fn new(
        mut reader: Box<dyn Read>,
        file: Option<File>,
        path: &Path,
        robot: &Robot,
    ) -> Result<Self, Vec<Note>> {
        let fault = |what: String| vec![error(path, what)];
        let mut start = Vec::new();
        reader
            .by_ref()
            .take(MAGIC.len() as u64)
            .read_to_end(&mut start)
            .map_err(|error| fault(format!("cannot be read: {error}")))?;
        let (source, format) = if start == MAGIC {
            let joints: Vec<_> = robot.joints().iter().map(|joint| joint.name.clone()).collect();
            let expected = format!(
                "(poses, {}), one column per moving joint in this order: {}",
                joints.len(),
                joints.join(", ")
            );
            let layout = Layout::read(&mut reader, Some(joints.len()), &expected).map_err(fault)?;
            let reader = Cursor::new(Vec::new()).chain(reader);
            let rows = Rows::new(layout.clone(), reader, file).map_err(fault)?;
            (Source::Npy(rows), Format::Npy { layout, joints })
        } else if start == ARROW_FILE || start.starts_with(&[0xFF; 4]) {
            Self::arrow(start, reader, file, path, robot)?
        } else if start.starts_with(b"PK\x03\x04") {
            return Err(fault("is an archive (.npz); save one array with numpy.save".into()));
        } else if path.extension().is_some_and(|extension| extension == "npy") {
            return Err(fault("does not begin as .npy does (\\x93NUMPY)".into()));
        } else {
            let table = Table::open(path, Cursor::new(start).chain(reader))?;
            let columns = Columns::find(path, Some(table.line()), table.header(), robot)?;
            let first_line = table.line() + 1;
            (Source::Csv(table), Format::Csv { columns, first_line })
        };
        let decoder = PoseDecoder { file: path.to_owned(), format };
        Ok(Self { source, decoder })
    }

    #[cfg(feature = "arrow")]
    fn arrow(
        start: Vec<u8>,
        reader: Box<dyn Read>,
        file: Option<File>,
        path: &Path,
        robot: &Robot,
    ) -> Result<(Source, Format), Vec<Note>> {
        let fault = |what: String| vec![error(path, what)];
        let batches = if start == ARROW_FILE {
            arrow::Batches::file(file)
        } else {
            arrow::Batches::stream(Cursor::new(start).chain(reader))
        };
        let batches = batches.map_err(fault)?;
        let columns = Columns::find(path, None, &batches.titles(), robot)?;
        let faults = batches.faults(&columns);
        if !faults.is_empty() {
            return Err(faults.into_iter().map(|what| error(path, what)).collect());
        }
        Ok((Source::Arrow(Box::new(batches)), Format::Arrow(columns)))
    }

    #[cfg(not(feature = "arrow"))]
    fn arrow(
        _: Vec<u8>,
        _: Box<dyn Read>,
        _: Option<File>,
        path: &Path,
        _: &Robot,
    ) -> Result<(Source, Format), Vec<Note>> {
        let what = "is Apache Arrow, which this detune was built without; build it with the \
                    feature 'arrow', or use CSV or .npy";
        Err(vec![error(path, what.into())])
    }

    /// How many poses there are, where the table says so.
    pub fn count(&self) -> Option<usize> {
        match &self.source {
            Source::Npy(rows) => Some(rows.layout.rows),
            _ => None,
        }
    }

    /// What takes its pieces apart.
    pub fn decoder(&self) -> &PoseDecoder {
        &self.decoder
    }

    /// Reads the next piece, of about so many poses, into `raw`, in place of what it holds; `false`
    /// at the end.
    ///
    /// # Errors
    /// A table that cannot be read, or an array that ends too soon.
    pub fn read(&mut self, poses: usize, raw: &mut RawPoses) -> Result<bool, Note> {
        match &mut self.source {
            Source::Csv(table) => {
                // About as many bytes as a pose has.
                table.lines(poses * 128, &mut raw.bytes)?;
                Ok(!raw.bytes.is_empty())
            }
            Source::Npy(rows) => {
                let taken = rows.take(poses, &mut raw.bytes);
                raw.rows = taken.map_err(|what| error(&self.decoder.file, what))?;
                Ok(raw.rows > 0)
            }
            #[cfg(feature = "arrow")]
            Source::Arrow(batches) => {
                let taken = batches.take(poses);
                raw.batch = taken.map_err(|what| error(&self.decoder.file, what))?;
                Ok(raw.batch.is_some())
            }
        }
    }
}

impl fmt::Debug for PoseTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PoseTable").field("decoder", &self.decoder).finish_non_exhaustive()
    }
}

fn error(file: &Path, what: String) -> Note {
    Note::error(Code::Value, Place::file(file), what)
}

#[cfg(test)]
mod tests {
    use super::super::Reading;
    use super::super::robot::{read_robot, tests as two_link};
    use super::*;

    fn robot() -> Robot {
        let (_folder, path) = two_link::folder(two_link::YAML, two_link::URDF);
        read_robot(&path, &mut Reading::default()).unwrap()
    }

    fn read_as(bytes: &[u8], name: &str) -> Result<Vec<Vec<f64>>, Vec<String>> {
        let robot = robot();
        let texts = |faults: Vec<Note>| faults.iter().map(Note::to_string).collect::<Vec<_>>();
        let reader = Box::new(Cursor::new(bytes.to_vec()));
        let mut table = PoseTable::from_reader(reader, Path::new(name), &robot).map_err(texts)?;
        let (mut raw, mut decoded) = (RawPoses::default(), DecodedPoses::default());
        let (mut poses, mut places, mut faults) = (Vec::new(), 0, Vec::new());
        while table.read(1024, &mut raw).map_err(|fault| texts(vec![fault]))? {
            table.decoder().decode(&raw, &mut decoded);
            poses.extend(decoded.values.chunks_exact(2).map(<[f64]>::to_vec));
            assert_eq!(decoded.values.len(), 2 * decoded.count);
            let fault =
                |(place, what): &(usize, String)| table.decoder().fault(places + place, what);
            faults.extend(decoded.faults.iter().map(fault));
            places += decoded.places;
        }
        if faults.is_empty() { Ok(poses) } else { Err(texts(faults)) }
    }

    fn read(text: &[u8]) -> Result<Vec<Vec<f64>>, Vec<String>> {
        read_as(text, "p.csv")
    }

    #[test]
    fn columns_come_in_any_order_and_unit() {
        let text = b"\xEF\xBB\xBF# from the cell\r\njoint_2_deg, id ,joint_1_rad\r\n90,a,0.5\r\n# \
            pause\r\n-90,b,1e-1\r\n";
        let poses = read(text).unwrap();
        assert_eq!(poses[0][0], 0.5);
        assert!((poses[0][1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!((poses.len(), poses[1][0]), (2, 0.1));
    }

    #[test]
    fn faults_have_their_line() {
        for (text, expected) in [
            (&b""[..], vec!["p.csv: is empty, must begin with a header"]),
            (
                b"joint_1_rad,joint2_rad\n",
                vec!["p.csv:1: no column 'joint_2_rad' or 'joint_2_deg'; did you mean 'joint"],
            ),
            (
                b"joint_1_rad,joint_1_deg,joint_2_rad\n",
                vec!["p.csv:1: joint 'joint_1' has 2 columns, must have one"],
            ),
            (
                b"joint_1_rad,joint_2_rad\n1,2\n1,nan\n",
                vec!["p.csv:3: joint_2_rad is 'nan', must be a finite number"],
            ),
            (
                b"joint_1_rad,joint_2_rad\n# c\n1\n",
                vec!["p.csv:3: joint_2_rad is empty, must be a finite number"],
            ),
            (b"joint_1_rad,joint_2_rad\n1,2\n1,\xFF\n", vec!["p.csv:3: is not UTF-8"]),
        ] {
            let faults = read(text).unwrap_err();
            assert_eq!(faults.len(), expected.len(), "{faults:?}");
            for (fault, expected) in faults.iter().zip(expected) {
                assert!(fault.starts_with(expected), "{fault}");
            }
        }
    }
}
