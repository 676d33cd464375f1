//! `detune map`: natural frequencies over poses.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use super::output::Sink;
use super::{Failure, Outcome};
use crate::free_vibration::{Doubt, DoubtReason, Measurement, Sampling, Settings};
use crate::input::{Fault, Poses, Reading, load_poses, read_robot};
use crate::map::{Head, Method, Row, outside_limits, rows_with_progress, sweep};
use crate::model::{JointKind, Robot};
use crate::report::map::{
    map_csv_header, map_csv_rows, map_json_end, map_json_rows, map_json_start, map_svg,
};
use crate::report::{number, trimmed};
use crate::units::{deg_from_rad, m_from_mm, mm_from_m, rad_from_deg};
use crate::wording::printable;

/// Poses that are held in memory at once: enough for all processors, little enough to forget.
const LINEAR_CHUNK: usize = 16_384;

/// The same for nonlinear maps, whose rows take long and hold spectra.
const NONLINEAR_CHUNK: usize = 64;

/// Faults of a table that are told in one go.
const MOST_TOLD: usize = 20;

/// Most poses in a picture.
const MOST_DRAWN: usize = 100_000;

/// Names less alike than this are no suggestion.
const LEAST_LIKENESS: f64 = 0.6;

/// Natural frequencies over poses.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    detune map robots/two-link --joint joint_2 --from-deg -130 --to-deg 150 --steps 281\n  \
    detune map robot.yaml --poses poses.csv --format json\n  \
    detune map robot.yaml --joint joint_3 --from-deg -90 --to-deg 45 --steps 41 \\\n      \
    --method nonlinear --amplitude-deg 0.5 --format svg --output map.svg")]
pub(super) struct MapArgs {
    /// A robot.yaml, or the folder that holds one.
    robot: PathBuf,
    /// The joint to sweep; the others stay at zero or at --at.
    #[arg(long, value_name = "NAME", required_unless_present = "poses", conflicts_with = "poses")]
    joint: Option<String>,
    /// Where the sweep of a turning joint starts, degrees.
    #[arg(long, value_name = "A", allow_negative_numbers = true, requires = "joint")]
    from_deg: Option<f64>,
    /// Where the sweep of a turning joint ends, degrees.
    #[arg(long, value_name = "B", allow_negative_numbers = true, requires = "joint")]
    to_deg: Option<f64>,
    /// Where the sweep of a sliding joint starts, mm.
    #[arg(long, value_name = "A", allow_negative_numbers = true, requires = "joint")]
    from_mm: Option<f64>,
    /// Where the sweep of a sliding joint ends, mm.
    #[arg(long, value_name = "B", allow_negative_numbers = true, requires = "joint")]
    to_mm: Option<f64>,
    /// Number of poses of the sweep, both ends included.
    #[arg(long, value_name = "N", requires = "joint",
        value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    steps: Option<u32>,
    /// Another joint's position during the sweep, degrees (mm for a sliding joint); may be repeated.
    #[arg(long, value_name = "NAME=DEG", requires = "joint", value_parser = named_value)]
    at: Vec<(String, f64)>,
    /// Poses as CSV, one column `<joint>_rad` or `_deg` (`_m` or `_mm`) per moving joint; `-` is standard input.
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,
    /// Eigenvalues, or spectra of a large free vibration.
    #[arg(long, value_enum, default_value_t = MethodName::Linear)]
    method: MethodName,
    /// Nonlinear: largest deflection of any turning spring, degrees; 1 if not given.
    #[arg(long, value_name = "X")]
    amplitude_deg: Option<f64>,
    /// Nonlinear: samples per second; chosen to show every mode if not given.
    #[arg(long, value_name = "HZ", requires = "duration_s")]
    sample_rate_hz: Option<f64>,
    /// Nonlinear: length of the record, s.
    #[arg(long, value_name = "S", requires = "sample_rate_hz")]
    duration_s: Option<f64>,
    /// How to write the map.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
    /// Where to write it; standard output if not given.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodName {
    Linear,
    Nonlinear,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Csv,
    Json,
    Svg,
}

/// Writes the map of `args` to `out` or to its file.
pub(super) fn run(args: &MapArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    only_nonlinear(args)?;
    let sink = Sink::open(args.output.as_deref())?;
    let mut reading = Reading::default();
    let robot = read_robot(&robot_file(&args.robot), &mut reading)?;
    // Standard input may be a file, too.
    reading.files.extend(args.poses.iter().map(|poses| match poses {
        dash if dash == Path::new("-") => PathBuf::from("/dev/stdin"),
        file => file.clone(),
    }));
    sink.spare(&reading.files)?;
    let mut notices: Vec<String> = reading.notices.iter().map(Fault::to_string).collect();
    let method = method(args);
    sink.stream(out, |out| write_map(args, &robot, &method, out, &mut notices))?;
    let mut stderr = io::stderr().lock();
    for notice in notices {
        // If standard error is closed, there is nobody to tell.
        let _ = writeln!(stderr, "warning: {notice}");
    }
    Ok(Outcome::Pass)
}

/// Options that the linear method would pass over in silence are faults.
fn only_nonlinear(args: &MapArgs) -> Result<(), Vec<Fault>> {
    if args.method == MethodName::Nonlinear {
        return Ok(());
    }
    let given = [
        ("--amplitude-deg", args.amplitude_deg),
        ("--sample-rate-hz", args.sample_rate_hz),
        ("--duration-s", args.duration_s),
    ];
    let faults: Vec<Fault> = given
        .into_iter()
        .filter(|(_, value)| value.is_some())
        .flat_map(|(name, _)| {
            fault(None, None, format!("{name} is of no effect here; it needs --method nonlinear"))
        })
        .collect();
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// A folder stands for the robot.yaml in it.
fn robot_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("robot.yaml") } else { path.to_owned() }
}

fn method(args: &MapArgs) -> Method {
    match args.method {
        MethodName::Linear => Method::Linear,
        MethodName::Nonlinear => Method::Nonlinear(Settings {
            amplitude_rad: args
                .amplitude_deg
                .map_or(Settings::default().amplitude_rad, rad_from_deg),
            sampling: match (args.sample_rate_hz, args.duration_s) {
                (Some(sample_rate_hz), Some(duration_s)) => {
                    Sampling::Fixed { sample_rate_hz, duration_s }
                }
                (Some(_), None) | (None, Some(_)) | (None, None) => Sampling::Automatic,
            },
            ..Settings::default()
        }),
    }
}

/// What is told once at the end rather than pose by pose.
#[derive(Default)]
struct Remarks {
    poses: usize,
    outside_limits: usize,
    first_outside: Option<String>,
    doubtful: usize,
    first_doubtful: Option<String>,
    folded: usize,
    first_folded: Option<String>,
    unresolved: usize,
}

impl Remarks {
    fn note(&mut self, robot: &Robot, rows: &[Row]) {
        self.poses += rows.len();
        for row in rows {
            if let Some(joint) = outside_limits(robot, &row.joints) {
                self.outside_limits += 1;
                self.first_outside.get_or_insert_with(|| at(robot, joint, row.joints[joint]));
            }
            let Some(nonlinear) = &row.nonlinear else { continue };
            self.doubtful += nonlinear.doubts.len();
            if let (None, Some(doubt)) = (&self.first_doubtful, nonlinear.doubts.first()) {
                self.first_doubtful = Some(doubtful(doubt, nonlinear));
            }
            self.folded += nonlinear.folded.len();
            if let (None, Some(folded)) = (&self.first_folded, nonlinear.folded.first()) {
                self.first_folded = Some(format!(
                    "mode {} at {} Hz would show at {} Hz",
                    folded.mode + 1,
                    number(folded.frequency_hz, 2),
                    number(folded.seen_at_hz, 2)
                ));
            }
            let blank = row.frequencies_hz.iter().filter(|f| f.is_none()).count();
            self.unresolved += blank - nonlinear.folded.len();
        }
    }

    fn tell(self, notices: &mut Vec<String>) {
        let all = self.poses;
        if let Some(first) = self.first_outside {
            let count = self.outside_limits;
            notices.push(format!(
                "{count} of {all} poses lie outside the joint limits (the first: {first})"
            ));
        }
        if let Some(first) = self.first_doubtful {
            notices.push(format!(
                "{} frequencies may be no modes' but harmonics or combination tones of a large \
                 vibration (the first: {first}); lower --amplitude-deg",
                self.doubtful
            ));
        }
        if let Some(first) = self.first_folded {
            notices.push(format!(
                "{} frequencies lie above half the sample rate and are left blank ({first}); \
                 raise --sample-rate-hz",
                self.folded
            ));
        }
        if self.unresolved > 0 {
            notices.push(format!(
                "{} frequencies are blank, as two modes lie too close for the record to part \
                 them; lengthen --duration-s",
                self.unresolved
            ));
        }
    }
}

/// `joint_2 at -300°, allowed -90 to 120°`.
fn at(robot: &Robot, joint: usize, value: f64) -> String {
    let joint = &robot.joints()[joint];
    let slides = joint.kind == JointKind::Prismatic;
    let shown = |value: f64| {
        let value = if slides { mm_from_m(value) } else { deg_from_rad(value) };
        trimmed(value, 1)
    };
    let unit = if slides { " mm" } else { "°" };
    let allowed = joint.limit.map_or(String::new(), |[lower, upper]| {
        format!(", allowed {} to {}{unit}", shown(lower), shown(upper))
    });
    format!("{} at {}{unit}{allowed}", printable(&joint.name), shown(value))
}

/// `mode 2 at 167.35 Hz, linear 84.18 Hz: more than a quarter off`.
fn doubtful(doubt: &Doubt, found: &Measurement) -> String {
    let why = match doubt.reason {
        DoubtReason::FarFromLinear => "far off",
        DoubtReason::NearerToAnotherMode => "nearer to another mode's",
        DoubtReason::RivalPeak => "another peak is about as high",
    };
    let frequency = found.frequencies_hz[doubt.mode]
        .map_or(String::new(), |hz| format!(" at {} Hz", number(hz, 2)));
    let linear = number(found.linear_hz[doubt.mode], 2);
    format!("mode {}{frequency}, linear {linear} Hz: {why}", doubt.mode + 1)
}

/// Counts poses on standard error while it is a terminal, and shows nothing elsewhere.
fn progress(steps: Option<u32>) -> ProgressBar {
    let (bar, template) = match steps {
        Some(steps) => (ProgressBar::new(u64::from(steps)), "{bar:30} {pos} of {len} poses, {eta}"),
        None => (ProgressBar::new_spinner(), "{spinner} {human_pos} poses, {elapsed}"),
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

fn write_map(
    args: &MapArgs,
    robot: &Robot,
    method: &Method,
    out: &mut dyn Write,
    notices: &mut Vec<String>,
) -> Result<(), Failure> {
    let mut source = Source::new(args, robot)?;
    let is_nonlinear = args.method == MethodName::Nonlinear;
    let chunk = if is_nonlinear { NONLINEAR_CHUNK } else { LINEAR_CHUNK };
    let head = Head::of(robot);
    let internal = |error: serde_json::Error| Failure::Internal(error.to_string());
    let mut remarks = Remarks::default();
    let progress = progress(args.steps);
    let more = |poses: usize| progress.inc(u64::try_from(poses).unwrap_or(u64::MAX));
    let mut drawn = Vec::new();
    let mut text = match args.format {
        Format::Csv => map_csv_header(&head, is_nonlinear),
        Format::Json => map_json_start(&head, is_nonlinear).map_err(internal)?,
        Format::Svg => String::new(),
    };
    loop {
        let (poses, lines) = source.next(chunk)?;
        if poses.is_empty() {
            break;
        }
        let found = rows_with_progress(robot, &poses, method, &more).map_err(|bad| match lines
            .get(bad.index)
        {
            Some(&line) => fault(args.poses.as_deref(), Some(line), bad.fault.to_string()),
            None => {
                let number = remarks.poses + bad.index + 1;
                fault(None, None, format!("pose {number}: {}", bad.fault))
            }
        })?;
        match args.format {
            Format::Csv => map_csv_rows(&found, &mut text),
            Format::Json => {
                map_json_rows(&found, remarks.poses == 0, &mut text).map_err(internal)?;
            }
            Format::Svg => {}
        }
        remarks.note(robot, &found);
        if args.format == Format::Svg {
            drawn.extend(found);
            if drawn.len() > MOST_DRAWN {
                let what = format!("more than {MOST_DRAWN} poses, too many to draw; use csv");
                return Err(fault(None, None, format!("--format svg: {what}")).into());
            }
        }
        // Both may stand on one terminal.
        progress.suspend(|| out.write_all(text.as_bytes()).and_then(|()| out.flush()))?;
        text.clear();
    }
    progress.finish_and_clear();
    match args.format {
        Format::Csv => {}
        Format::Json => text.push_str(map_json_end()),
        Format::Svg => text = map_svg(&head, &drawn, source.swept()),
    }
    out.write_all(text.as_bytes())?;
    out.flush()?;
    remarks.tell(notices);
    Ok(())
}

/// Poses and, where they are from a table, their lines.
type Chunk = (Vec<Vec<f64>>, Vec<usize>);

/// Where the poses come from.
enum Source {
    Sweep { joint: usize, at: Vec<f64>, from: f64, to: f64, steps: usize, done: usize },
    Table(Poses<Box<dyn Read>>),
}

impl Source {
    fn new(args: &MapArgs, robot: &Robot) -> Result<Self, Vec<Fault>> {
        if let Some(path) = &args.poses {
            let input: Box<dyn Read> = if path == Path::new("-") {
                Box::new(io::stdin().lock())
            } else {
                let file = File::open(path)
                    .map_err(|error| fault(Some(path), None, format!("cannot be read: {error}")))?;
                Box::new(file)
            };
            return Ok(Self::Table(load_poses(input, path, robot)?));
        }
        let Some(name) = &args.joint else {
            return Err(fault(None, None, "--joint or --poses must be given".into()));
        };
        let joint = joint_named(robot, "--joint", name)?;
        let mut at = vec![0.0; robot.joints().len()];
        for (name, value) in &args.at {
            let index = joint_named(robot, "--at", name)?;
            if index == joint {
                let what = format!("--at: joint '{name}' is the one that is swept");
                return Err(fault(None, None, what));
            }
            at[index] = if slides(robot, index) { m_from_mm(*value) } else { rad_from_deg(*value) };
        }
        let (from, to) = ends(args, slides(robot, joint), name)?;
        let Some(steps) = args.steps else {
            return Err(fault(None, None, "--steps must be given with --joint".into()));
        };
        Ok(Self::Sweep { joint, at, from, to, steps: steps as usize, done: 0 })
    }

    /// Up to `chunk` poses and, from a table, their lines.
    fn next(&mut self, chunk: usize) -> Result<Chunk, Vec<Fault>> {
        match self {
            Self::Table(table) => next_rows(table, chunk),
            Self::Sweep { joint, at, from, to, steps, done } => {
                let first = *done;
                *done = (first + chunk).min(*steps);
                let poses = sweep(at, *joint, *from, *to, *steps, first..*done);
                Ok((poses, Vec::new()))
            }
        }
    }

    fn swept(&self) -> Option<usize> {
        match self {
            Self::Sweep { joint, .. } => Some(*joint),
            Self::Table(_) => None,
        }
    }
}

/// The next rows of a table and their lines; all faults among them at once.
fn next_rows<R: Read>(table: &mut Poses<R>, chunk: usize) -> Result<Chunk, Vec<Fault>> {
    let (mut poses, mut lines, mut faults) = (Vec::new(), Vec::new(), Vec::new());
    while poses.len() < chunk && faults.len() < MOST_TOLD {
        let mut pose = Vec::new();
        let before = table.line();
        match table.read_into(&mut pose) {
            Ok(true) => {
                poses.push(pose);
                lines.push(table.line());
            }
            Ok(false) => break,
            Err(fault) => {
                let row = fault.line;
                faults.push(fault);
                // A table that cannot be read any further stays where it is.
                if row.is_none() || table.line() == before {
                    break;
                }
            }
        }
    }
    if faults.is_empty() { Ok((poses, lines)) } else { Err(faults) }
}

/// Both ends of the sweep in rad or m, from the options that fit the joint.
fn ends(args: &MapArgs, slides: bool, name: &str) -> Result<(f64, f64), Vec<Fault>> {
    let (wanted, unwanted, unit) = if slides {
        ((args.from_mm, args.to_mm), (args.from_deg, args.to_deg), "mm")
    } else {
        ((args.from_deg, args.to_deg), (args.from_mm, args.to_mm), "deg")
    };
    let (does, others) = if slides { ("slides", "deg") } else { ("turns", "mm") };
    if unwanted.0.is_some() || unwanted.1.is_some() {
        let what = format!(
            "joint '{name}' {does}: --from-{others} and --to-{others} do not fit, give \
             --from-{unit} and --to-{unit}"
        );
        return Err(fault(None, None, what));
    }
    let (Some(from), Some(to)) = wanted else {
        let what = format!("joint '{name}' {does}: --from-{unit} and --to-{unit} must be given");
        return Err(fault(None, None, what));
    };
    if !(from.is_finite() && to.is_finite()) {
        let what = format!("--from-{unit} and --to-{unit} are {from} and {to}, must be finite");
        return Err(fault(None, None, what));
    }
    let convert = if slides { m_from_mm } else { rad_from_deg };
    Ok((convert(from), convert(to)))
}

fn slides(robot: &Robot, joint: usize) -> bool {
    robot.joints()[joint].kind == JointKind::Prismatic
}

fn joint_named(robot: &Robot, option: &str, name: &str) -> Result<usize, Vec<Fault>> {
    let names: Vec<&str> = robot.joints().iter().map(|joint| joint.name.as_str()).collect();
    names.iter().position(|known| *known == name).ok_or_else(|| {
        let hint = nearest(name, &names).map_or_else(
            || format!("; it has {}", names.join(", ")),
            |n| format!("; did you mean '{n}'?"),
        );
        fault(None, None, format!("{option}: the robot has no moving joint '{name}'{hint}"))
    })
}

/// The known name most like `name`, if one is like it.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    known
        .iter()
        .map(|known| (strsim::jaro_winkler(name, known), *known))
        .filter(|(likeness, _)| *likeness >= LEAST_LIKENESS)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, known)| known)
}

fn named_value(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.rsplit_once('=').ok_or("must be NAME=VALUE, e.g. joint_2=45")?;
    match value.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((name.trim().to_owned(), number)),
        Ok(_) | Err(_) => Err(format!("'{value}' is not a finite number")),
    }
}

fn fault(file: Option<&Path>, line: Option<usize>, what: String) -> Vec<Fault> {
    vec![Fault { file: file.map(Path::to_owned), line, what }]
}

#[cfg(test)]
mod tests {
    use std::fs;

    use clap::Parser;

    use super::*;
    use crate::two_link::TABLE_1;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        map: MapArgs,
    }

    fn map(line: &str) -> Result<String, Vec<String>> {
        let words = std::iter::once("map").chain(line.split_whitespace());
        let parsed = Line::try_parse_from(words).map_err(|error| vec![error.to_string()])?;
        let mut out = Vec::new();
        match run(&parsed.map, &mut out) {
            Ok(Outcome::Pass) => Ok(String::from_utf8(out).unwrap()),
            Ok(Outcome::Fail) => panic!("a map cannot fail"),
            Err(Failure::Input(faults)) => Err(faults.iter().map(Fault::to_string).collect()),
            Err(other) => panic!("{other:?}"),
        }
    }

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

    /// A map's own output is a table of poses: the same frequencies come back to the last digit, across
    /// the border between two chunks, and in the order given.
    #[test]
    fn a_table_of_poses_gives_the_same_bytes() {
        let sweep = "--joint joint_2 --from-deg -100 --to-deg 100 --at joint_1=30";
        let swept = map(&format!("robots/two-link {sweep} --steps {}", LINEAR_CHUNK + 7)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("poses.csv");
        fs::write(&file, &swept).unwrap();
        let again = map(&format!("robots/two-link --poses {}", file.display())).unwrap();
        assert!(again == swept);
        assert_eq!(swept.lines().count(), LINEAR_CHUNK + 8);
    }

    #[test]
    fn degrees_and_any_order_of_columns() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("poses.csv");
        fs::write(&file, "# by hand\nid, joint_2_deg ,joint_1_rad\na, 90, 0.5\n\nb,-45,1\n")
            .unwrap();
        let (_, rows) =
            table(&map(&format!("robots/two-link --poses {}", file.display())).unwrap());
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
                .map(|fault| fault.rsplit_once("poses.csv:").unwrap().1.to_owned())
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
        assert!(units.contains("turns: --from-mm and --to-mm do not fit"), "{units}");
        let twice = told(
            "robots/two-link --joint joint_2 --from-deg 0 --to-deg 1 --steps 2 --at joint_2=3",
        );
        assert!(twice.contains("'joint_2' is the one that is swept"), "{twice}");
        let none = told("robots/two-link --joint joint_2 --from-deg 0 --to-deg 1 --steps 0");
        assert!(none.contains("--steps"), "{none}");
        let amplitude = told(
            "robots/two-link --joint joint_2 --from-deg 0 --to-deg 1 --steps 1 --method nonlinear \
         --amplitude-deg 0",
        );
        assert!(amplitude.contains("amplitude is 0 rad, must be positive"), "{amplitude}");
    }

    #[test]
    fn one_step_stays_at_the_start() {
        let text =
            map("robots/two-link --joint joint_2 --from-deg 10 --to-deg 20 --steps 1").unwrap();
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
        let line =
            format!("robots/two-link --poses {} --output {}", poses.display(), other.display());
        assert!(map(&line).is_err());
        assert!(!other.exists());
    }
}
