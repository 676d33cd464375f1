//! APT source and cutter location files → motions.
//!
//! A statement is `MAJOR/minor,…`, in any case; `$` at the end of a line continues it, `$$` starts
//! a comment. Understood: `FROM`, `GOTO`, `GODLTA`, `RAPID`, `FEDRAT`, `SPINDL`, `UNITS`, `MULTAX`,
//! and drilling by `GOHOME` to a point, `CYCLE/…` in the form with keywords (`DEPTH` or `FEDTO`,
//! `CLEAR` or `RAPTO`, `RTRCTO`, a feed after its unit). Lengths are in mm unless `UNITS/INCHES`
//! says otherwise. Arcs and statements that shift, copy or compute motion are errors: cutter
//! location files can be written without them. So is a second coordinate system (`MSYS`), and
//! motion behind a `GOHOME` that does not say where to. Words that are not known are reported and
//! left out: most are for the postprocessor.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

use super::log::Log;
use super::tool_axis::orientation;
use super::{Pace, Settings, Spindle, tool_number};
use crate::motion::Target;
use crate::notes::Code;
use crate::units::{m_from_mm, m_per_s_from_mm_per_min, mm_from_inch};

/// A tool axis is a unit vector to about three digits.
const AXIS_LENGTH_TOLERANCE: f64 = 0.02;

pub(super) fn read(text: &str, settings: &Settings, log: &mut Log) {
    let mut reader = Reader::new(settings, log);
    for statement in statements(text) {
        if !reader.statement(&statement) || reader.log.is_full() {
            break;
        }
    }
}

/// A statement: continued lines joined, comments gone, and the line it starts on.
struct Statement {
    line: usize,
    major: String,
    minor: Vec<Word>,
}

/// What stands between commas.
#[derive(Debug, Clone, PartialEq)]
enum Word {
    Number(f64),
    /// In upper case.
    Name(String),
}

/// Statements that are text to the end of the line.
const FREE_TEXT: [&str; 6] = ["PARTNO", "PPRINT", "REMARK", "INSERT", "TPRINT", "PPWORD"];

fn statements(text: &str) -> Vec<Statement> {
    let mut out = Vec::new();
    let mut open: Option<(usize, String)> = None;
    for (index, line) in text.lines().enumerate() {
        let content = line.split("$$").next().unwrap_or("").trim();
        let (start, mut whole) = open.take().unwrap_or((index + 1, String::new()));
        let free = FREE_TEXT.iter().any(|word| starts_with_word(content, word));
        match content.strip_suffix('$') {
            Some(part) if !(free && whole.is_empty()) => {
                whole.push_str(part);
                open = Some((start, whole));
            }
            _ => {
                whole.push_str(content);
                out.extend(statement(start, &whole));
            }
        }
    }
    if let Some((start, whole)) = open {
        out.extend(statement(start, &whole));
    }
    out
}

fn starts_with_word(content: &str, word: &str) -> bool {
    content.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

fn statement(line: usize, text: &str) -> Option<Statement> {
    let (major, minor) = match text.split_once('/') {
        Some((major, minor)) => (major, Some(minor)),
        None => (text, None),
    };
    // `TLON,GOFWD/…`: the first word says what it is.
    let major = major.split([',', ' ', '\t']).find(|word| !word.is_empty())?.to_ascii_uppercase();
    let word = |part: &str| {
        let part: String = part.split_whitespace().collect();
        match part.parse::<f64>() {
            // `parse` takes "inf" and "nan", which are names here.
            Ok(number) if number.is_finite() && !part.contains(['n', 'N']) => Word::Number(number),
            _ => Word::Name(part.to_ascii_uppercase()),
        }
    };
    let minor = minor.map_or_else(Vec::new, |minor| minor.split(',').map(word).collect());
    Some(Statement { line, major, minor })
}

/// A drilling cycle that is on: lengths in mm along the tool axis from the programmed point.
#[derive(Debug, Clone, Copy)]
struct Cycle {
    depth: f64,
    clear: f64,
    retract: f64,
    feed: Option<Feed>,
    /// Bores, reams and taps are left at the feed.
    out_at_feed: bool,
}

/// A feed as the program gives it.
#[derive(Debug, Clone, Copy)]
enum Feed {
    MmPerMin(f64),
    MmPerRev(f64),
}

struct Reader<'a> {
    log: &'a mut Log,
    work_object: Isometry3<f64>,
    tcp: Isometry3<f64>,
    inches: bool,
    units_given: bool,
    feed: Option<Feed>,
    rapid: bool,
    spindle_rpm: Option<f64>,
    /// Where the tool is, mm in the work object.
    at: Option<Vector3<f64>>,
    axis: Unit<Vector3<f64>>,
    turned: Option<UnitQuaternion<f64>>,
    cycle: Option<Cycle>,
    /// The first `MSYS`, and its line.
    system: Option<(usize, Vec<Word>)>,
}

impl<'a> Reader<'a> {
    fn new(settings: &'a Settings, log: &'a mut Log) -> Self {
        Self {
            log,
            work_object: settings.work_object.unwrap_or_default(),
            tcp: settings.tcp.unwrap_or_default(),
            inches: false,
            units_given: false,
            feed: None,
            rapid: false,
            spindle_rpm: None,
            at: None,
            axis: Vector3::z_axis(),
            turned: None,
            cycle: None,
            system: None,
        }
    }

    /// False at the end of the program.
    fn statement(&mut self, statement: &Statement) -> bool {
        let Statement { line, major, minor } = statement;
        let line = *line;
        let done = match major.as_str() {
            "GOTO" => self.go_to(line, minor),
            "FROM" => self.from(line, minor),
            "GODLTA" => self.go_delta(line, minor),
            "RAPID" => {
                self.rapid = true;
                Ok(())
            }
            "FEDRAT" => self.feed_statement(line, minor),
            "SPINDL" => self.spindle(line, minor),
            "UNITS" => self.units(minor),
            "CYCLE" => self.cycle_statement(minor),
            "LOADTL" | "LOAD" | "TURRET" => self.load_tool(line, minor),
            "FINI" => return false,
            "GOHOME" if !minor.is_empty() => self.home(line, minor),
            "GOHOME" | "GOCLER" => {
                self.log.leaves(line, major);
                Ok(())
            }
            "MSYS" => self.system(line, minor),
            "HEAD" => {
                self.log.warning(
                    Code::ChangeIgnored,
                    line,
                    "HEAD: the job's tcp is used with every head",
                );
                Ok(())
            }
            "CUTCOM" => {
                if minor.first() != Some(&Word::Name("OFF".to_owned())) {
                    self.log.warning(Code::Assumed, line, "CUTCOM: the path is read as programmed");
                }
                Ok(())
            }
            _ => self.other(line, major),
        };
        if let Err(what) = done {
            self.log.error(Code::Motion, line, format!("{major}: {what}"));
        }
        true
    }

    fn other(&mut self, line: usize, major: &str) -> Result<(), String> {
        const WITHOUT_MOTION: [&str; 41] = [
            "PARTNO",
            "PPRINT",
            "REMARK",
            "INSERT",
            "TPRINT",
            "PPWORD",
            "MACHIN",
            "MULTAX",
            "COOLNT",
            "DELAY",
            "DWELL",
            "END",
            "OPSTOP",
            "STOP",
            "CUTTER",
            "TOLER",
            "INTOL",
            "OUTTOL",
            "MODE",
            "PLABEL",
            "SEQNO",
            "AUXFUN",
            "PREFUN",
            "CLEARP",
            "TMARK",
            "LIMIT",
            "SAFPOS",
            "SELCTL",
            "PAINT",
            "END-OF-PATH",
            "TLDATA",
            "DISPLAY",
            "TOOL",
            "UNLOAD",
            "UNCLMP",
            "CLAMP",
            "OPSKIP",
            "LEADER",
            "REWIND",
            "CLDIST",
            "THREAD",
        ];
        const MOVES: [&str; 27] = [
            "CIRCLE", "INDIRV", "INDIRP", "TLON", "TLLFT", "TLRGT", "GO", "GOFWD", "GOBACK",
            "GOLFT", "GORGT", "GOUP", "GODOWN", "MOVARC", "COPY", "INDEX", "TRACUT", "TRANS",
            "ORIGIN", "ROTATE", "ROTABL", "ROTHED", "CALL", "JUMPTO", "LOOPST", "NURBS", "LCS",
        ];
        if MOVES.contains(&major) || major.starts_with("GO") {
            return Err("moves or shifts motion and is not understood; have the CAM system write \
                        GOTO points"
                .to_owned());
        }
        if !WITHOUT_MOTION.contains(&major) {
            self.log.warning(
                Code::LeftOut,
                line,
                format!("{major} is not understood and left out"),
            );
        }
        Ok(())
    }

    fn mm(&self, length: f64) -> f64 {
        if self.inches { mm_from_inch(length) } else { length }
    }

    fn point(&self, minor: &[Word]) -> Result<Vector3<f64>, String> {
        match minor {
            [Word::Number(x), Word::Number(y), Word::Number(z), ..] => {
                Ok(Vector3::new(self.mm(*x), self.mm(*y), self.mm(*z)))
            }
            _ => Err("expected x, y, z as numbers".to_owned()),
        }
    }

    /// The tool axis after x, y, z: it stays until another is given.
    fn axis_of(&self, minor: &[Word]) -> Result<Unit<Vector3<f64>>, String> {
        match minor.get(3..) {
            None | Some([]) => Ok(self.axis),
            Some([Word::Number(i), Word::Number(j), Word::Number(k)]) => {
                let axis = Vector3::new(*i, *j, *k);
                let length = axis.norm();
                if (length - 1.0).abs() > AXIS_LENGTH_TOLERANCE {
                    return Err(format!(
                        "tool axis ({i}, {j}, {k}) has length {length:.4}, must be 1"
                    ));
                }
                Ok(Unit::new_normalize(axis))
            }
            Some(_) => Err("expected x, y, z or x, y, z, i, j, k".to_owned()),
        }
    }

    fn go_to(&mut self, line: usize, minor: &[Word]) -> Result<(), String> {
        let to = self.point(minor)?;
        self.axis = self.axis_of(minor)?;
        match self.cycle {
            Some(cycle) => self.drill(line, to, cycle),
            None => self.straight(line, to),
        }
    }

    fn from(&mut self, line: usize, minor: &[Word]) -> Result<(), String> {
        let to = self.point(minor)?;
        self.axis = self.axis_of(minor)?;
        if self.at.is_some() {
            self.log.warning(Code::Assumed, line, "FROM after motion: read as a rapid move");
        }
        self.rapid_to(line, to);
        Ok(())
    }

    fn home(&mut self, line: usize, minor: &[Word]) -> Result<(), String> {
        let to = self.point(minor)?;
        self.axis = self.axis_of(minor)?;
        self.rapid_to(line, to);
        Ok(())
    }

    /// The job's work object stands for the first coordinate system; where another lies is its own
    /// matter.
    fn system(&mut self, line: usize, minor: &[Word]) -> Result<(), String> {
        if self.system.is_none() && self.at.is_some() {
            return Err("a coordinate system behind motion that has none".to_owned());
        }
        let (first_line, first) = self.system.get_or_insert_with(|| (line, minor.to_vec()));
        if first == minor {
            Ok(())
        } else {
            Err(format!(
                "another coordinate system than that of line {first_line}; split the program into \
                 several operations, each with its work object"
            ))
        }
    }

    fn go_delta(&mut self, line: usize, minor: &[Word]) -> Result<(), String> {
        let from = self.at.ok_or("a relative move before any position")?;
        let by = match minor {
            // A single number goes along the tool axis.
            [Word::Number(along)] => self.axis.into_inner() * self.mm(*along),
            _ => self.point(minor)?,
        };
        self.straight(line, from + by)
    }

    fn straight(&mut self, line: usize, to: Vector3<f64>) -> Result<(), String> {
        if std::mem::take(&mut self.rapid) {
            self.rapid_to(line, to);
        } else {
            let pace = self.pace(self.feed)?;
            self.push(line, to, pace);
        }
        Ok(())
    }

    fn rapid_to(&mut self, line: usize, to: Vector3<f64>) {
        self.push(line, to, Pace::Rapid);
    }

    fn push(&mut self, line: usize, to: Vector3<f64>, pace: Pace) {
        let turned = orientation(self.axis, self.turned);
        let target = Isometry3::from_parts(Translation3::from(to.map(m_from_mm)), turned);
        let to_base = Target::Line(self.work_object * target);
        self.log.motion(line, to_base, self.tcp, pace);
        self.at = Some(to);
        self.turned = Some(turned);
    }

    /// Rapid to the clearance, feed to the depth, and out.
    fn drill(&mut self, line: usize, to: Vector3<f64>, cycle: Cycle) -> Result<(), String> {
        let axis = self.axis.into_inner();
        let feed = self.pace(cycle.feed.or(self.feed))?;
        self.rapid = false;
        self.rapid_to(line, to + axis * cycle.clear);
        self.push(line, to - axis * cycle.depth, feed);
        let out = if cycle.out_at_feed { feed } else { Pace::Rapid };
        self.push(line, to + axis * cycle.clear, out);
        if cycle.retract > cycle.clear {
            self.rapid_to(line, to + axis * cycle.retract);
        }
        Ok(())
    }

    fn pace(&self, feed: Option<Feed>) -> Result<Pace, String> {
        match feed {
            None => Ok(Pace::Unstated),
            Some(Feed::MmPerMin(feed)) => Ok(Pace::Feed(m_per_s_from_mm_per_min(feed))),
            Some(Feed::MmPerRev(feed)) => match self.spindle_rpm {
                Some(rpm) if rpm > 0.0 => Ok(Pace::Feed(m_per_s_from_mm_per_min(feed * rpm))),
                _ => Err("the feed is per revolution, but the spindle's speed is not known".into()),
            },
        }
    }

    /// The feed that `unit` (default: per minute) makes of a number.
    fn feed_of(&self, number: f64, unit: Option<&str>) -> Result<Feed, String> {
        let feed = match unit {
            None | Some("PERMIN") => Feed::MmPerMin(self.mm(number)),
            Some("PERREV") => Feed::MmPerRev(self.mm(number)),
            Some("MMPM") => Feed::MmPerMin(number),
            Some("IPM") => Feed::MmPerMin(mm_from_inch(number)),
            Some("MMPR") => Feed::MmPerRev(number),
            Some("IPR") => Feed::MmPerRev(mm_from_inch(number)),
            Some(other) => return Err(format!("'{other}' is not understood as a unit of feed")),
        };
        if number > 0.0 { Ok(feed) } else { Err(format!("the feed is {number}, must be positive")) }
    }

    /// The same, taken down as one that the program states.
    fn stated_feed(&mut self, number: f64, unit: Option<&str>) -> Result<Feed, String> {
        let feed = self.feed_of(number, unit)?;
        self.log.feed(matches!(feed, Feed::MmPerRev(_)));
        Ok(feed)
    }

    fn feed_statement(&mut self, line: usize, minor: &[Word]) -> Result<(), String> {
        let numbers: Vec<f64> = minor.iter().filter_map(number).collect();
        let names: Vec<&str> =
            minor.iter().filter_map(name).filter(|name| !matches!(*name, "F" | "")).collect();
        if names == ["RAPID"] && numbers.is_empty() {
            self.rapid = true;
            return Ok(());
        }
        let ([number], [] | [_]) = (numbers.as_slice(), names.as_slice()) else {
            return Err("expected a number and a unit".to_owned());
        };
        let unit = names.first().copied();
        if !self.units_given && matches!(unit, Some("IPM" | "IPR")) {
            self.log.warning(
                Code::UnitAssumed,
                line,
                "the feed is in inches, but no UNITS is given: lengths are in mm",
            );
        }
        self.feed = Some(self.stated_feed(*number, unit)?);
        Ok(())
    }

    fn spindle(&mut self, line: usize, minor: &[Word]) -> Result<(), String> {
        let numbers: Vec<f64> = minor.iter().filter_map(number).collect();
        let has = |wanted: &str| minor.iter().filter_map(name).any(|name| name == wanted);
        let spindle = if has("OFF") {
            Spindle::Stands
        } else if has("SFM") || has("SMM") {
            self.log.warning(
                Code::LeftOut,
                line,
                "SPINDL by surface speed is left out: the speed is not known",
            );
            self.spindle_rpm = None;
            Spindle::Turns(None)
        } else if let [rpm, ..] = numbers.as_slice() {
            if *rpm < 0.0 {
                return Err(format!("the speed is {rpm} rpm, must not be negative"));
            }
            self.spindle_rpm = Some(*rpm);
            Spindle::at(self.spindle_rpm)
        } else {
            // ON, CLW, CCLW: as before, or at a speed that is set elsewhere.
            Spindle::Turns(self.spindle_rpm.filter(|&rpm| rpm > 0.0))
        };
        self.log.spindle(line, spindle);
        Ok(())
    }

    fn units(&mut self, minor: &[Word]) -> Result<(), String> {
        self.inches = match minor.first().and_then(name) {
            Some("MM") => false,
            Some("INCHES" | "INCH" | "IN") => true,
            Some("CM") => return Err("CM is not supported, write MM or INCHES".to_owned()),
            _ => return Err("expected MM or INCHES".to_owned()),
        };
        self.units_given = true;
        Ok(())
    }

    /// `LOADTL/1,…`, `LOAD/TOOL,1,…`, `TURRET/1`: the first number is the tool's.
    fn load_tool(&mut self, line: usize, minor: &[Word]) -> Result<(), String> {
        let Some(number) = minor.iter().find_map(number) else {
            self.log.warning(Code::LeftOut, line, "a tool without a number is left out");
            return Ok(());
        };
        self.log.tool(tool_number(number)?);
        Ok(())
    }

    fn cycle_statement(&mut self, minor: &[Word]) -> Result<(), String> {
        self.cycle = None;
        let kind = minor.first().and_then(name).ok_or("expected a kind of cycle")?;
        let out_at_feed = match kind {
            "OFF" | "END" => return Ok(()),
            "DRILL" | "FACE" | "CSINK" | "THRU" | "DEEP" | "BRKCHP" => false,
            "BORE" | "REAM" | "TAP" => true,
            other => return Err(format!("'{other}' is not understood")),
        };
        let mut cycle =
            Cycle { depth: f64::NAN, clear: 0.0, retract: 0.0, feed: None, out_at_feed };
        let mut rest = minor.get(1..).unwrap_or_default();
        // The words that only say how the depth is reached: the places passed are the same.
        while let [Word::Name(word), tail @ ..] = rest
            && matches!(word.as_str(), "DEEP" | "BRKCHP" | "BACK" | "DRAG" | "NODRAG" | "MANUAL")
        {
            rest = tail;
        }
        while let [Word::Name(key), tail @ ..] = rest {
            let (value, tail) = match tail {
                [Word::Number(value), tail @ ..] => (Some(*value), tail),
                // RTRCTO,AUTO: back to the clearance.
                [Word::Name(word), tail @ ..] if matches!(word.as_str(), "AUTO" | "NONE") => {
                    (None, tail)
                }
                tail => (None, tail),
            };
            match (key.as_str(), value) {
                ("DEPTH" | "FEDTO", Some(value)) => cycle.depth = self.mm(value.abs()),
                ("CLEAR" | "RAPTO", Some(value)) => cycle.clear = self.mm(value),
                ("RTRCTO" | "RETURN", Some(value)) => cycle.retract = self.mm(value),
                ("MMPM" | "IPM" | "MMPR" | "IPR" | "PERMIN" | "PERREV", Some(value)) => {
                    cycle.feed = Some(self.stated_feed(value, Some(key))?);
                }
                ("RTRCTO" | "RETURN", None)
                | ("DWELL" | "STEP" | "STEP1" | "INCR" | "TIMES" | "REV" | "CAM" | "ORIENT", _) => {
                }
                _ => return Err(format!("'{key}' is not understood in a cycle")),
            }
            rest = tail;
        }
        if !rest.is_empty() {
            return Err("numbers without keywords: write DEPTH, CLEAR and the unit before the \
                        feed"
                .to_owned());
        }
        if !cycle.depth.is_finite() {
            return Err("the depth is missing (DEPTH or FEDTO)".to_owned());
        }
        self.cycle = Some(cycle);
        Ok(())
    }
}

fn number(word: &Word) -> Option<f64> {
    match word {
        Word::Number(number) => Some(*number),
        Word::Name(_) => None,
    }
}

fn name(word: &Word) -> Option<&str> {
    match word {
        Word::Number(_) => None,
        Word::Name(name) => Some(name),
    }
}
