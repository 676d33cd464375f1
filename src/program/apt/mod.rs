//! APT source and cutter location files → motions.
//!
//! A statement is `MAJOR/minor,…`, in any case; `$` at the end of a line continues it, `$$` starts
//! a comment. Lengths are in mm unless UNITS or UNIT says otherwise. The job's work object stands
//! for the first coordinate system (MSYS, CSYS, MCS); whether coordinates behind another are in it
//! or in the first the job says. Words that may move the tool, or change speed, feed, frame or
//! tool, and are not known are errors; those that do not are listed in `words`.

mod arcs;
mod cycles;
mod lexer;
mod senses;
mod spindle;
mod systems;
mod tools;
mod words;

use nalgebra::{Unit, Vector3};

use super::Pace;
use super::cutter::{Cutter, Feed, FeedKind};
use super::log::Log;
use super::span::Span;
use super::unread::behind_end;
use super::{Coordinates, LengthUnit, Settings};
use crate::notes::Code;
use crate::units::{hz_from_rpm, mm_from_inch};
use cycles::Cycle;
use lexer::{Kind, Lexer, Statement, Token, Word};
use senses::Senses;
use systems::Systems;
use tools::Tools;

/// A tool axis is a unit vector to about three digits.
const AXIS_LENGTH_TOLERANCE: f64 = 0.02;

/// Tool axes that differ by no more are one, rad.
const SAME_AXIS: f64 = 1e-6;

pub(super) fn read(text: &str, settings: &Settings, log: &mut Log) {
    let mut reader = Reader::new(settings, log);
    let mut lexer = Lexer::new(text);
    read_all(&mut lexer, &mut reader);
    reader.settle_senses();
    reader.settle_points();
    // All of its numbers have many decimals, in either unit.
    reader.cutter.unit.tell(reader.cutter.log, "UNITS/MM or UNITS/INCHES", true);
    // The job may say that all points are in the first system.
    if let (Some(line), false) =
        (lexer.other_system, settings.coordinates == Some(Coordinates::World))
    {
        let what = "the coordinate system in the comments changes here, and whether the points do \
                    with it is not known: they are read as all in one system";
        reader.cutter.log.warning(Code::ChangeIgnored, line, what);
    }
}

fn axes_of(at: Option<Vector3<f64>>) -> [Option<f64>; 3] {
    at.map_or([None; 3], |at| at.map(Some).into())
}

fn read_all<'t>(lexer: &mut Lexer<'t>, reader: &mut Reader<'_>) {
    let mut statement = Statement::default();
    while lexer.next_into(&mut statement) {
        reader.is_creo = lexer.is_creo;
        let goes_on = reader.statement(&statement);
        if reader.cutter.log.is_full() {
            return;
        }
        if !goes_on {
            reader.no_arc_is_open(statement.line);
            while lexer.next_into(&mut statement) {
                if matches!(statement.major().to_ascii_uppercase().as_str(), "GOTO" | "GODLTA") {
                    behind_end(reader.cutter.log, statement.line);
                    return;
                }
            }
            return;
        }
    }
    reader.no_arc_is_open(lexer.line());
    let what = if lexer.is_cut {
        "the program ends within a statement: is the file whole?"
    } else if reader.may_end {
        return;
    } else {
        "the program ends without FINI: is the file whole?"
    };
    reader.cutter.log.error(Code::Syntax, lexer.line(), what);
}

struct Reader<'a> {
    cutter: Cutter<'a>,
    /// Written by Creo, as its header says.
    is_creo: bool,
    inches: bool,
    units_given: bool,
    rapid: bool,
    /// The line of a feed that stands between RAPID and the move.
    fed_behind_rapid: Option<usize>,
    /// Whether RAPID stands behind the start of a cycle that is on.
    is_rapid_in_cycle: bool,
    /// In the coordinates of the program.
    axis: Unit<Vector3<f64>>,
    /// The line of MULTAX/OFF, where the axis was another and no statement has given it since.
    axis_is_back: Option<usize>,
    /// Whether MULTAX/OFF says that tool axes do not count.
    is_fixed: bool,
    at: Option<Vector3<f64>>,
    /// Whether the last statement may be the program's last.
    may_end: bool,
    /// CIRCLE: what the next GOTO ends.
    arc: Option<arcs::Open>,
    /// The arc that the last statement ended.
    arc_before: Option<arcs::Ended>,
    arc_points: arcs::Points,
    /// INDIRV, INDIRP: where the next arc starts to.
    direction: Option<Vector3<f64>>,
    senses: Senses,
    cycle: Option<Cycle>,
    /// The one that CYCLE/OFF has ended, which CYCLE/ON takes up again.
    ended_cycle: Option<Cycle>,
    /// Points behind a cycle that is refused are no moves.
    cycle_is_refused: bool,
    /// Whether the tool stands above the last hole.
    is_behind_cycle: bool,
    /// Whether the last FEDRAT is per revolution.
    is_per_revolution: bool,
    tools: Tools,
    systems: Systems,
}

impl<'a> Reader<'a> {
    fn new(settings: &'a Settings, log: &'a mut Log) -> Self {
        let mut cutter = Cutter::new(settings, log);
        // Files without FROM begin there.
        cutter.is_first_place_start = true;
        let inches = settings.unit == Some(LengthUnit::Inch);
        if settings.unit.is_some() {
            cutter.unit.state(!inches);
        }
        Self {
            cutter,
            is_creo: false,
            inches,
            units_given: settings.unit.is_some(),
            rapid: false,
            fed_behind_rapid: None,
            is_rapid_in_cycle: false,
            axis: Vector3::z_axis(),
            axis_is_back: None,
            is_fixed: false,
            at: None,
            may_end: false,
            arc: None,
            arc_before: None,
            arc_points: arcs::Points::default(),
            direction: None,
            senses: Senses::default(),
            cycle: None,
            ended_cycle: None,
            cycle_is_refused: false,
            is_behind_cycle: false,
            is_per_revolution: false,
            tools: Tools::default(),
            systems: Systems::new(settings.coordinates),
        }
    }

    /// False at the end of the program.
    fn statement(&mut self, statement: &Statement<'_>) -> bool {
        let line = statement.line;
        let major = statement.major();
        self.senses.is_nx |= lexer::is(major, "TOOL PATH");
        let major = major.split_whitespace().next().unwrap_or("").to_ascii_uppercase();
        if major != "GOTO" {
            self.leave_arc();
        }
        // END is M2 or M30: FINI may stand behind it, and CATIA ends by it alone.
        if major == "FINI" || major == "END" && statement.second().is_none() {
            return false;
        }
        // NX ends each operation by END-OF-PATH and has no FINI.
        self.may_end = major == "END-OF-PATH";
        let is_set = statement.tokens.get(1).is_some_and(|it| it.kind == Kind::Symbol(b'='));
        if is_set && !words::WITHOUT_MOTION.contains(&major.as_str()) {
            let what = "this is an APT part program, which defines geometry, and no \
                        cutter-location data: run it through the APT processor and give what \
                        that writes";
            self.cutter.log.error(Code::Syntax, line, what);
            return true;
        }
        let ran = match statement.second() {
            _ if statement.is_unclear => Err("a '$' behind ',' or '/' ends the line, or is the \
                                              first letter of a name: write a blank behind it \
                                              where the next line goes on, else the name without \
                                              it"
            .to_owned()),
            // How the tool stands to a curve, and the move along it, are one statement.
            Some(second) if !matches!(major.as_str(), "TLON" | "TLLFT" | "TLRGT") => {
                Err(format!("{second} stands behind it; write each statement on a line of its own"))
            }
            _ => self.run(line, &major, statement),
        };
        if let Err(what) = ran {
            let what = match major.as_str() {
                "" => "the statement begins with no word, as MAJOR/… does: where it goes on from \
                       the line before, that must end with '$'"
                    .to_owned(),
                _ => format!("{major}: {what}"),
            };
            self.cutter.log.error(Code::Motion, line, what);
        }
        true
    }

    fn run(&mut self, line: usize, major: &str, statement: &Statement<'_>) -> Result<(), String> {
        if words::WITHOUT_MOTION.contains(&major) {
            return Ok(());
        }
        let minor = statement.minor();
        let minor = minor.as_slice();
        if matches!(major, "GOTO" | "GODLTA" | "FROM" | "TLON") {
            self.settle_tool();
        }
        match major {
            "SELECT" if minor.first().and_then(name).is_some_and(|it| lexer::is(it, "TOOL")) => {
                Ok(())
            }
            "INSERT" | "PPWORD" | "SELECT" | "PPFUN" | "PREFUN" | "THREAD" => {
                let what = format!("{major} goes to the machine as it is and is not read");
                self.cutter.log.warning(Code::MotionLeftOut, line, what);
                Ok(())
            }
            "GOTO" => {
                let gone = self.go_to(line, minor);
                self.cutter.unit.goes_to(line, axes_of(self.at), std::iter::empty());
                gone
            }
            "FROM" => self.from(line, minor),
            "GODLTA" => self.go_delta(line, minor),
            "RAPID" => {
                let is_slash = |token: &Token<'_>| token.kind == Kind::Symbol(b'/');
                if !statement.tokens.iter().skip(1).all(is_slash) {
                    return Err(
                        "what stands behind it is not understood; write each statement on \
                                a line of its own"
                            .to_owned(),
                    );
                }
                self.rapid = true;
                self.is_rapid_in_cycle = self.cycle.is_some();
                self.fed_behind_rapid = None;
                Ok(())
            }
            "CIRCLE" => self.circle(line, minor),
            "MOVARC" => self.move_arc(line, minor),
            "INDIRV" => {
                self.direction = Some(vector(minor)?);
                Ok(())
            }
            "INDIRP" => {
                let to = self.point(minor)?;
                self.direction = Some(to - self.at.ok_or("INDIRP before any position")?);
                Ok(())
            }
            "TLON" => self.along_circle(line, statement),
            "MULTAX" if minor.first().and_then(name).is_some_and(|word| lexer::is(word, "OFF")) => {
                let axis = self.systems.axis();
                if self.axis.angle(&axis) > SAME_AXIS {
                    self.axis_is_back = Some(line);
                }
                self.axis = axis;
                self.is_fixed = true;
                Ok(())
            }
            "MULTAX" => {
                self.is_fixed = false;
                Ok(())
            }
            "TLAXIS" => {
                self.axis = self.given_axis(line, vector(minor)?)?;
                Ok(())
            }
            "FEDRAT" => self.feed_statement(line, minor),
            "SPINDL" => self.spindle(line, minor),
            "UNITS" | "UNIT" => self.units(minor),
            "CYCLE" => {
                let read = self.cycle_statement(line, minor);
                self.cycle_is_refused = read.is_err();
                read
            }
            "DELAY" | "DWELL" => self.delay(line, minor),
            "LOADTL" | "LOAD" | "TURRET" => self.load_tool(line, major, minor),
            "GOHOME" if !minor.is_empty() => self.home(line, minor),
            "GOHOME" | "GOCLER" => {
                self.at = None;
                self.cutter.log.leaves(line, major);
                Ok(())
            }
            "MSYS" | "CSYS" | "MCS" => self.system(line, major, minor),
            "ORIGIN" | "TRANS" if vector(minor) == Ok(Vector3::zeros()) && minor.len() == 3 => {
                Ok(())
            }
            // CAMWorks has it.
            "TRNTYP" => {
                self.senses.is_right_handed = true;
                self.systems.say(minor)
            }
            "HEAD" => {
                self.other_head(line);
                Ok(())
            }
            "CUTTER" | "TOOL" | "TOOLNO" => {
                self.name_tool(line, statement);
                Ok(())
            }
            "AUXFUN" => self.auxiliary(line, minor),
            "OPSKIP" => {
                if minor.first().and_then(name).is_some_and(|name| lexer::is(name, "ON")) {
                    let what = "OPSKIP: what the operator may skip is read as if it ran";
                    self.cutter.log.warning(Code::MotionLeftOut, line, what);
                }
                Ok(())
            }
            "CUTCOM" => {
                if minor.first().and_then(name) != Some("OFF") {
                    let what = "CUTCOM: the path is read as programmed";
                    self.cutter.log.warning(Code::Assumed, line, what);
                }
                Ok(())
            }
            _ if words::MOVES.contains(&major) || major.starts_with("GO") => {
                Err("moves or shifts motion and is not understood; have the CAM system write \
                     GOTO points"
                    .to_owned())
            }
            _ => Err("is not understood and may move the tool or change how it runs; delete it \
                      if it does not"
                .to_owned()),
        }
    }

    fn mm(&self, length: f64) -> f64 {
        if self.inches { mm_from_inch(length) } else { length }
    }

    fn point(&self, minor: &[Word<'_>]) -> Result<Vector3<f64>, String> {
        let at = vector(minor)?;
        Ok(at.map(|length| self.mm(length)))
    }

    /// The tool axis after x, y, z: it stays until another is given.
    fn axis_of(&mut self, line: usize, minor: &[Word<'_>]) -> Result<Unit<Vector3<f64>>, String> {
        match minor.get(3..) {
            None | Some([]) => {
                self.doubt_axis();
                Ok(self.axis)
            }
            Some(rest @ [_, _, _]) => {
                let axis = vector(rest).map_err(|_| NOT_A_TARGET.to_owned())?;
                self.given_axis(line, axis)
            }
            Some(_) => Err(NOT_A_TARGET.to_owned()),
        }
    }

    /// A tool axis that a statement gives; tilted behind MULTAX/OFF, posts may leave it out.
    fn given_axis(
        &mut self,
        line: usize,
        axis: Vector3<f64>,
    ) -> Result<Unit<Vector3<f64>>, String> {
        self.axis_is_back = None;
        let axis = unit(axis)?;
        if self.is_fixed && axis.angle(&self.systems.axis()) > SAME_AXIS {
            let what = "a tilted tool axis behind MULTAX/OFF is read as it stands: posts without \
                        tool axes leave it out; write MULTAX/ON before it, or no axis";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        Ok(axis)
    }

    /// A move without an axis of its own.
    fn doubt_axis(&mut self) {
        if let Some(line) = self.axis_is_back.take() {
            let what = "MULTAX/OFF: the tool axis is taken as that of the coordinate system from \
                        here on; some systems keep the last one, which is tilted";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    fn go_to(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        let to = self.point(minor)?;
        let before = self.axis;
        self.axis = self.axis_of(line, minor)?;
        if let Some(arc) = self.arc.take() {
            return self.close_arc(line, arc, to);
        }
        if self.goes_on_along_arc(line, to, before)? {
            return Ok(());
        }
        if self.cycle_is_refused {
            self.at = Some(to);
            return Ok(());
        }
        match self.cycle {
            Some(cycle) => self.drill(line, to, cycle),
            None => self.straight(line, to),
        }
    }

    fn from(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        let to = self.point(minor)?;
        self.axis = self.axis_of(line, minor)?;
        if self.at.is_some() {
            let what = "FROM after motion: read as a rapid move";
            self.cutter.log.warning(Code::Assumed, line, what);
        }
        self.line_to(line, to, Pace::Rapid);
        Ok(())
    }

    fn home(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        let to = self.point(minor)?;
        self.axis = self.axis_of(line, minor)?;
        self.line_to(line, to, Pace::Rapid);
        Ok(())
    }

    fn go_delta(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        if self.cycle.is_some() {
            return Err("a relative move within a cycle; write GOTO, or end the cycle".to_owned());
        }
        if self.is_behind_cycle {
            return Err(
                "a relative move behind a cycle counts from its last hole, not from where \
                        the tool is; write GOTO"
                    .to_owned(),
            );
        }
        let from = self.at.ok_or("a relative move before any position")?;
        let by = match minor {
            // A single number goes along the tool axis.
            [Word::Number(along, _)] => {
                self.doubt_axis();
                self.axis.into_inner() * self.mm(*along)
            }
            [_, _, _] | [_, _, _, _, _, _] => {
                let by = self.point(minor)?;
                self.axis = self.axis_of(line, minor)?;
                by
            }
            _ => return Err(NOT_A_STEP.to_owned()),
        };
        self.straight(line, from + by)
    }

    fn straight(&mut self, line: usize, to: Vector3<f64>) -> Result<(), String> {
        let is_rapid = std::mem::take(&mut self.rapid);
        let pace = if is_rapid { Pace::Rapid } else { self.cutter.pace()? };
        if let Some(line) = self.fed_behind_rapid.take().filter(|_| is_rapid) {
            let what = "FEDRAT stands between RAPID and the move, which is read as rapid: some \
                        posts run it at the feed";
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
        self.line_to(line, to, pace);
        Ok(())
    }

    fn line_to(&mut self, line: usize, to: Vector3<f64>, pace: Pace) {
        // Rapid moves go to where an arc starts from anywhere.
        if pace == Pace::Rapid {
            self.senses.lose();
        } else {
            self.senses.straight(self.at, to);
        }
        let frame = self.systems.start();
        self.cutter.tilt(frame.axis(self.axis));
        self.cutter.line_to(line, frame.point(to), pace);
        self.at = Some(to);
        self.is_behind_cycle = false;
    }

    /// The feed that `unit` (default: per minute) makes of a number.
    fn feed_of(&mut self, line: usize, number: f64, unit: Option<&str>) -> Result<Feed, String> {
        if !self.units_given && matches!(unit, Some("IPM" | "IPR")) {
            let what = "the feed is in inches, but no UNITS is given: lengths are in mm";
            self.cutter.log.warning(Code::UnitAssumed, line, what);
        }
        // Who states the unit of the feed means that of the lengths, or is told of it above.
        if matches!(unit, Some("MMPM" | "MMPR" | "IPM" | "IPR")) {
            self.cutter.unit.state(true);
        }
        let (kind, mm) = match unit {
            None | Some("PERMIN") => (FeedKind::PerMinute, self.mm(number)),
            Some("PERREV") => (FeedKind::PerRevolution, self.mm(number)),
            Some("MMPM") => (FeedKind::PerMinute, number),
            Some("IPM") => (FeedKind::PerMinute, mm_from_inch(number)),
            Some("MMPR") => (FeedKind::PerRevolution, number),
            Some("IPR") => (FeedKind::PerRevolution, mm_from_inch(number)),
            Some(other) => return Err(format!("'{other}' is not understood as a unit of feed")),
        };
        if number > 0.0 {
            Ok(Feed { kind, value: Some(mm) })
        } else {
            Err(format!("the feed is {number}, must be positive"))
        }
    }

    fn feed_statement(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        let numbers: Vec<(f64, Span)> = minor.iter().filter_map(number).collect();
        let names = minor.iter().filter_map(name).map(str::to_ascii_uppercase);
        let names: Vec<String> = names.filter(|name| !matches!(name.as_str(), "F" | "")).collect();
        if names == ["RAPID"] && numbers.is_empty() {
            self.rapid = true;
            self.is_rapid_in_cycle = self.cycle.is_some();
            return Ok(());
        }
        let ([(number, span)], [] | [_]) = (numbers.as_slice(), names.as_slice()) else {
            return Err("expected a number and a unit".to_owned());
        };
        let mut unit = names.first().map(String::as_str);
        match unit {
            None if self.is_per_revolution => {
                let what = "FEDRAT without a unit behind one per revolution is taken as per \
                            revolution: some posts take it as per minute";
                self.cutter.log.warning(Code::UnitAssumed, line, what);
                unit = Some("PERREV");
            }
            _ => self.is_per_revolution = matches!(unit, Some("PERREV" | "MMPR" | "IPR")),
        }
        self.fed_behind_rapid = self.rapid.then_some(line);
        let feed = self.feed_of(line, *number, unit)?;
        self.cutter.state_feed(line, feed, *number, Some(*span));
        Ok(())
    }

    fn units(&mut self, minor: &[Word<'_>]) -> Result<(), String> {
        let unit = minor.first().and_then(name).map(str::to_ascii_uppercase);
        let inches = match unit.as_deref() {
            Some("MM" | "MILLIMETERS" | "METRIC") => false,
            Some("INCHES" | "INCH" | "IN") => true,
            Some("CM") => return Err("CM is not supported, write MM or INCHES".to_owned()),
            _ => return Err("expected MM or INCHES".to_owned()),
        };
        self.inches = inches;
        self.units_given = true;
        self.cutter.unit.state(!inches);
        Ok(())
    }

    /// `DELAY/2`: seconds; with REV turns of the spindle.
    fn delay(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        let Some((time, _)) = minor.iter().find_map(number) else {
            return Err("expected a time in seconds".to_owned());
        };
        let in_turns = minor.iter().filter_map(name).any(|name| lexer::is(name, "REV"));
        let seconds = match (in_turns, self.cutter.rpm) {
            (false, _) => time,
            (true, Some(rpm)) if rpm > 0.0 => time / hz_from_rpm(rpm),
            (true, _) => return Err("in turns of a spindle whose speed is not known".to_owned()),
        };
        self.cutter.log.dwell(line, seconds);
        Ok(())
    }

    /// `AUXFUN/3`: an M code.
    fn auxiliary(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        match minor.iter().find_map(number).map(|(code, _)| code) {
            Some(code @ (3.0 | 4.0 | 13.0 | 14.0)) => {
                self.cutter.log.reverse(code == 4.0 || code == 14.0);
                self.cutter.turn_spindle(line, true);
            }
            Some(5.0) => self.cutter.turn_spindle(line, false),
            Some(0.0..=9.0) => {}
            _ => {
                let stands = self.cutter.is_on == Some(false);
                let code = if stands { Code::SpindleCommand } else { Code::LeftOut };
                let what = "AUXFUN is an M code that is not understood, and left out";
                self.cutter.log.warning(code, line, what);
            }
        }
        Ok(())
    }
}

const NOT_A_TARGET: &str = "expected x, y, z or x, y, z, i, j, k";
const NOT_A_STEP: &str =
    "expected dx, dy, dz or dx, dy, dz, i, j, k or one number, along the tool axis";

/// The first three words as numbers.
fn vector(minor: &[Word<'_>]) -> Result<Vector3<f64>, String> {
    match minor {
        [Word::Number(x, _), Word::Number(y, _), Word::Number(z, _), ..] => {
            Ok(Vector3::new(*x, *y, *z))
        }
        _ => Err("expected x, y, z as numbers".to_owned()),
    }
}

fn unit(axis: Vector3<f64>) -> Result<Unit<Vector3<f64>>, String> {
    let length = axis.norm();
    if (length - 1.0).abs() > AXIS_LENGTH_TOLERANCE {
        let [i, j, k] = [axis.x, axis.y, axis.z];
        return Err(format!("tool axis ({i}, {j}, {k}) has length {length:.4}, must be 1"));
    }
    Ok(Unit::new_normalize(axis))
}

fn number(word: &Word<'_>) -> Option<(f64, Span)> {
    match word {
        Word::Number(number, span) => Some((*number, *span)),
        Word::Name(_) => None,
    }
}

fn name<'t>(word: &Word<'t>) -> Option<&'t str> {
    match word {
        Word::Number(..) => None,
        Word::Name(name) => Some(name),
    }
}
