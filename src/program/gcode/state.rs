//! What a G-code controller remembers from block to block, and the moves that come of it.

use nalgebra::Vector3;

use super::block::{Block, Counts, DIRECTION, POLAR_ANGLE, POLAR_RADIUS, RADIUS, Word};
use super::frame::{Polar, Turned};
use super::lengths::Lengths;
use super::rotary::Rotary;
use super::shift::Shift;
use super::siemens::DrillingCall;
use crate::notes::Code;
use crate::program::arc::{Centre, Plane};
use crate::program::corner::Corner;
use crate::program::cutter::{Cutter, Feed, FeedKind};
use crate::program::log::Log;
use crate::program::{DwellUnit, LengthUnit, Pace, Settings, tool_number};
use crate::units::{deg_from_rad, mm_from_inch};

pub(super) const AXES: [u8; 3] = *b"XYZ";
pub(super) const CENTRES: [u8; 3] = *b"IJK";

/// The shorter way round is not told from the longer.
const HALF_TURN_DEG: f64 = 180.0;

/// Angles below this are rounding.
const ROUNDING_DEG: f64 = 1e-6;

/// A chord for the arc of a turn is 0.4 % off its radius.
const STRAIGHT_DEG: f64 = 10.0;

/// What puts the work where nothing says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MovedWork {
    OtherOffset,
    /// Its number.
    Parameter(i64),
    /// G92.1 or G92.2.
    EndOfG92,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    None,
    Rapid,
    Straight,
    Arc {
        clockwise: bool,
    },
    /// CIP.
    Through,
    /// CT.
    Tangent,
    Cycle(CycleKind),
}

/// What distinguishes the cycles as motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CycleKind {
    /// G81, G82, G73, G86: out at rapid.
    Drill,
    /// G83: in steps of Q, out to R between them.
    Peck,
    /// G74, G84, G85, G89: out at the feed.
    Bore,
    Unknown(i64),
}

/// A height of a cycle: what G91 makes of it, it stays behind a G90, and the other way round.
#[derive(Debug, Clone, Copy)]
pub(super) enum Height {
    /// In the program's coordinates.
    Word(f64),
    /// From where the cycle was called, or from R.
    Relative(f64),
}

/// What a cycle remembers from hole to hole, mm.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cycle {
    /// Height where the cycle was called, if it is known: where G98 goes back to.
    pub(super) initial: Option<f64>,
    /// The R word, the word of the bottom and Q as given.
    pub(super) retract: Option<Height>,
    pub(super) bottom: Option<Height>,
    pub(super) step: Option<f64>,
    /// P, which later cycles keep.
    pub(super) dwell_s: f64,
    /// The code of the cycle, in tenths.
    pub(super) code: i64,
    /// The tool stands at the bottom so long.
    pub(super) dwells: bool,
    /// Between pecks the tool goes back a little alone.
    pub(super) breaks_chips: bool,
    pub(super) is_tap: bool,
    /// A pattern ended, or X and Y stood beside L0: where the next hole counts from is not clear.
    pub(super) asks_for_place: bool,
}

/// A feed that holds, and in what it was stated.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldFeed {
    feed: Feed,
    unit: FeedUnit,
}

/// In what feeds are stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FeedUnit {
    in_inches: bool,
    /// The machine's own unit, by no word of the program: the job's, or mm where it has none.
    is_basic: bool,
}

/// How the tool tip goes where rotary axes turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tip {
    Rapid,
    Feed,
    /// At feed, to where it is.
    Stays,
    /// By a rapid move, to where it is.
    StaysByRapid,
}

pub(super) struct Machine<'a> {
    pub(super) cutter: Cutter<'a>,
    pub(super) motion: Motion,
    pub(super) plane: Plane,
    pub(super) inches: bool,
    /// The program has said it.
    pub(super) states_unit: bool,
    pub(super) feed_unit: FeedUnit,
    /// Of the feed that the cutter has.
    was_feed_unit: FeedUnit,
    /// The job's unit, in which feeds are under Sinumerik's G70 and G71.
    basic_in_inches: Option<bool>,
    /// Sinumerik's G70 has come: the machine's own unit may be inches.
    has_inches_of_lengths: bool,
    pub(super) is_sinumerik: bool,
    pub(super) relative: bool,
    pub(super) centre_absolute: bool,
    pub(super) back_to_initial: bool,
    pub(super) cycle: Cycle,
    /// Sinumerik's cycle that MCALL runs at every position.
    pub(super) called: Option<DrillingCall>,
    pub(super) shift: Shift,
    pub(super) polar: Polar,
    pub(super) turned: Option<Turned>,
    /// G68 or G69, behind which no block has stated both axes of the plane where the tool has
    /// other coordinates by it.
    pub(super) turns_at: Option<(Plane, &'static str)>,
    pub(super) rotary: Rotary<'a>,
    pub(super) corner: Option<Corner>,
    pub(super) dwell_unit: Option<DwellUnit>,
    pub(super) is_scheduled: bool,
    next_tool: Option<f64>,
    /// T only selects, M6 changes; without an M6 in the program, T does both.
    pub(super) waits_for_change: bool,
    /// No M6 has come, and one will.
    waits_for_first: bool,
    /// Line of the first cut before it.
    cuts_before_change: Option<usize>,
    pub(super) lengths: Lengths,
    /// M codes that are not known, with nothing behind them yet that they could matter to.
    pub(super) unknown_codes: Vec<(usize, String)>,
    /// A G92 or G10 L20 said where the path starts.
    pub(super) starts_by_g92: bool,
    /// Each with its line, and no move behind it yet.
    pub(super) moved_work: Vec<(usize, MovedWork)>,
    /// G0 held before the cycle: G80 goes back to it.
    pub(super) was_rapid: bool,
    /// LIMS=, rev/min.
    pub(super) limit_rpm: Option<f64>,
    /// G97 of Sinumerik's holds.
    pub(super) is_g97: bool,
    /// How far the tool has turned at feed while its tip stays, in moves on end, degrees.
    turned_in_place: f64,
}

impl<'a> Machine<'a> {
    pub(super) fn new(settings: &'a Settings, log: &'a mut Log, waits_for_change: bool) -> Self {
        let mut cutter = Cutter::new(settings, log);
        let basic_in_inches = settings.unit.map(|unit| unit == LengthUnit::Inch);
        if let Some(inches) = basic_in_inches {
            cutter.unit.state(!inches);
        }
        let inches = basic_in_inches.unwrap_or(false);
        let feed_unit = FeedUnit { in_inches: inches, is_basic: true };
        Self {
            cutter,
            motion: Motion::None,
            plane: Plane::XY,
            inches,
            states_unit: false,
            feed_unit,
            was_feed_unit: feed_unit,
            basic_in_inches,
            has_inches_of_lengths: false,
            is_sinumerik: false,
            relative: false,
            centre_absolute: false,
            back_to_initial: true,
            cycle: Cycle::default(),
            called: None,
            shift: Shift::default(),
            polar: Polar::default(),
            turned: None,
            turns_at: None,
            rotary: Rotary::new(&settings.rotary_axes),
            corner: None,
            dwell_unit: settings.dwell_unit,
            is_scheduled: settings.is_scheduled,
            next_tool: None,
            waits_for_change,
            waits_for_first: waits_for_change,
            cuts_before_change: None,
            lengths: Lengths::default(),
            unknown_codes: Vec::new(),
            starts_by_g92: false,
            moved_work: Vec::new(),
            was_rapid: false,
            limit_rpm: None,
            is_g97: false,
            turned_in_place: 0.0,
        }
    }

    pub(super) fn mm(&self, length: f64) -> f64 {
        if self.inches { mm_from_inch(length) } else { length }
    }

    /// Of the tool in the spindle, in the unit of the program, or why it is not known: the job
    /// gives it, and what the program sets by G10 has to agree.
    pub(super) fn diameter(&self) -> Option<Result<f64, String>> {
        /// Of the diameter: a program writes four digits of it.
        const SAME: f64 = 1e-3;
        let given = self.cutter.diameter_mm()?;
        let set =
            self.lengths.radii_mm(self.cutter.loaded()).into_iter().map(|radius| 2.0 * radius);
        let other = set.into_iter().find(|set| set.is_nan() || (set - given).abs() > SAME * given);
        Some(match other {
            None => Ok(self.in_program_unit(given)),
            Some(set) if set.is_finite() => Err(format!(
                "the program sets the diameter of the tool to {set:.3} mm by G10, and the job has \
                 {given} mm: state in the job's diameter_mm what holds"
            )),
            Some(_) => {
                Err("the program changes the diameter of the tool by G10 from what it was, \
                            which is not known"
                    .to_owned())
            }
        })
    }

    pub(super) fn in_program_unit(&self, mm: f64) -> f64 {
        if self.inches { mm / mm_from_inch(1.0) } else { mm }
    }

    /// Whether lengths are in inches, where the program or the job says so.
    pub(super) fn stated_inches(&self) -> Option<bool> {
        (self.states_unit || self.basic_in_inches.is_some()).then_some(self.inches)
    }

    /// The feed that holds, where it was stated in the unit that holds.
    pub(super) fn feed_in_program_unit(&self) -> Option<f64> {
        let is_of_unit = self.was_feed_unit.in_inches == self.inches;
        let is_length = self.cutter.feed.kind != FeedKind::InverseTime;
        let value = self.cutter.feed.value.filter(|_| is_of_unit && is_length)?;
        Some(self.in_program_unit(value))
    }

    /// G20 and G21, G70 and G71, G700 and G710.
    pub(super) fn set_unit(&mut self, inches: bool, of_lengths_alone: bool) {
        self.cutter.unit.state(!inches);
        (self.inches, self.states_unit) = (inches, true);
        self.has_inches_of_lengths |= inches && of_lengths_alone;
        let basic = self.basic_in_inches.unwrap_or(false);
        let in_inches = if of_lengths_alone { basic } else { inches };
        self.feed_unit = FeedUnit { in_inches, is_basic: of_lengths_alone };
    }

    pub(super) fn set_feed(&mut self, line: usize, word: Word) -> Result<(), String> {
        if word.value <= 0.0 {
            return Err(format!("F is {}, must be positive", word.value));
        }
        let kind = self.cutter.feed.kind;
        let value = self.feed_in(kind, word.value);
        let feed = Feed { kind, value: Some(value) };
        self.was_feed_unit = self.feed_unit;
        self.cutter.state_feed(line, feed, word.value, word.span);
        Ok(())
    }

    pub(super) fn held_feed(&self) -> HeldFeed {
        HeldFeed { feed: self.cutter.feed, unit: self.was_feed_unit }
    }

    /// Back to a feed that held before.
    pub(super) fn hold_feed(&mut self, HeldFeed { feed, unit }: HeldFeed) {
        (self.cutter.feed, self.was_feed_unit) = (feed, unit);
    }

    /// A feed that was stated before a change between inches and mm, or whose unit nothing says.
    fn tell_kept_feed(&mut self, line: usize) {
        let Feed { kind, value } = self.cutter.feed;
        if value.is_none() || kind == FeedKind::InverseTime {
            return;
        }
        self.tell_basic_feed(line, self.was_feed_unit);
        if self.was_feed_unit.in_inches != self.feed_unit.in_inches {
            let what = "F stands before a change between inches and mm, and is taken to stay the \
                        feed that it was; on some controls its number stays, in the other unit: \
                        write F again behind the change";
            self.cutter.log.warning(Code::UnitAssumed, line, what);
        }
    }

    /// A feed in the machine's own unit, in a program with Sinumerik's G70, which is of lengths
    /// alone.
    pub(super) fn tell_basic_feed(&mut self, line: usize, unit: FeedUnit) {
        if self.has_inches_of_lengths && unit.is_basic && self.basic_in_inches.is_none() {
            let what = "beside G70, feeds are in the basic unit of the machine (MD10240), which \
                        nothing says: they are taken as mm, and may be inches; write \
                        path.program.unit: mm or inch in the job, or G700 for feeds in inches";
            self.cutter.log.warning(Code::UnitAssumed, line, what);
        }
    }

    /// A feed as the program writes it, in mm where it is a length.
    pub(super) fn feed_in(&self, kind: FeedKind, written: f64) -> f64 {
        match kind {
            FeedKind::InverseTime => written,
            _ if self.feed_unit.in_inches => mm_from_inch(written),
            _ => written,
        }
    }

    pub(super) fn select_tool(&mut self, tool: f64) -> Result<(), String> {
        tool_number(tool)?;
        self.next_tool = Some(tool);
        if self.waits_for_change { Ok(()) } else { self.change_tool() }
    }

    /// The tool that was selected is in the spindle from here on.
    pub(super) fn change_tool(&mut self) -> Result<(), String> {
        self.tell_cuts_before_change();
        self.waits_for_first = false;
        self.next_tool.map_or(Ok(()), |tool| self.load(tool))?;
        self.take_selected_edge()
    }

    /// M61 of LinuxCNC: the tool that is in the spindle, without a change.
    pub(super) fn state_tool(&mut self, tool: f64) -> Result<(), String> {
        self.waits_for_first = false;
        self.load(tool)
    }

    /// LIMS= counts under G97, too (Siemens, SINUMERIK 840D sl Fundamentals, "Constant cutting
    /// rate").
    pub(super) fn tell_limit(&mut self, line: usize) {
        if let (true, Some(limit), Some(rpm)) = (self.is_g97, self.limit_rpm, self.cutter.rpm)
            && rpm > limit
        {
            let what = format!(
                "S{rpm} is above LIMS={limit}, which limits the speed under G97, too: it is taken \
                 as S states it"
            );
            self.cutter.log.warning(Code::SpindleCommand, line, what);
        }
    }

    pub(super) fn tell_cuts_before_change(&mut self) {
        if let Some(line) = self.cuts_before_change.take() {
            let what = "cuts before the first M6: which tool is in the spindle is not stated";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// A move at feed.
    pub(super) fn cuts(&mut self, line: usize) {
        self.tell_kept_feed(line);
        if !self.rotary.follows_tip() && self.rotary.tilts_tool() {
            let what = "cuts with the tool tilted by a rotary axis: without G43.4 or TRAORI, X, Y \
                        and Z may be places of the axis and not of the tool tip, as which they \
                        are read; have it posted with tool centre point control";
            self.cutter.log.warning(Code::UnitAssumed, line, what);
        }
        if self.waits_for_first {
            self.cuts_before_change.get_or_insert(line);
        }
    }

    /// Rotary axes and tool directions of a block, and whether it turns any. The path is taken to
    /// be straight in the work, and the shorter way round.
    pub(super) fn turn(&mut self, line: usize, block: &Block, tip: Tip) -> Result<bool, String> {
        let axis_before = self.cutter.axis;
        let direction = DIRECTION.map(|letter| block.word(letter).map(|word| word.value));
        let is_directed = direction.iter().any(Option::is_some);
        if is_directed {
            // A component that is not given is zero.
            let axis = Vector3::from(direction.map(Option::unwrap_or_default));
            let axis = axis.try_normalize(1e-6).ok_or("A3, B3 and C3 give no direction")?;
            self.cutter.tilt(nalgebra::Unit::new_unchecked(axis));
        }
        let turned = self.rotary.turn(block, self.relative)?;
        if let Some(name) = self.rotary.away() {
            let what = format!(
                "axis {name} has gone to where the program does not say, and is taken to be where \
                 it was before; state {name} by a rapid move"
            );
            self.cutter.log.warning(Code::AxisIgnored, line, what);
        }
        if turned > 0.0 {
            self.cutter.tilt(self.rotary.tool_axis());
        }
        let follows_tip = self.rotary.follows_tip();
        if follows_tip && !self.is_sinumerik && self.rotary.is_work_turned() {
            let what = "under G43.4, X, Y and Z are taken to be in the turned work; on Fanuc, \
                        parameter 19696 (WKP) may have them stay where the work was before it \
                        turned";
            self.cutter.log.warning(Code::UnitAssumed, line, what);
        }
        let is_still = follows_tip && tip == Tip::Stays;
        if is_still {
            let tilted = deg_from_rad(axis_before.angle(&self.cutter.axis));
            self.tell_turn_in_place(line, turned.max(tilted));
            return Ok(is_directed || turned > 0.0);
        }
        if tip != Tip::StaysByRapid {
            self.turned_in_place = 0.0;
        }
        let most = match tip {
            Tip::Rapid | Tip::StaysByRapid => HALF_TURN_DEG,
            _ if follows_tip => HALF_TURN_DEG,
            _ => STRAIGHT_DEG,
        };
        if turned > most + ROUNDING_DEG && self.cutter.log.has_moved() {
            let what = format!(
                "a rotary axis turns by {turned:.1}° in one move: it is read as straight in the \
                 work, the shorter way round, and at the feed along that, which is right under \
                 G43.4, TRAORI or M128 alone; write turns as steps of up to {most}°"
            );
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
        Ok(is_directed || turned > 0.0)
    }

    /// A turn at feed while the tip stays: in small steps it takes as long as in one.
    fn tell_turn_in_place(&mut self, line: usize, turned: f64) {
        let most = STRAIGHT_DEG + ROUNDING_DEG;
        let before = self.turned_in_place;
        self.turned_in_place += turned;
        if before <= most && self.turned_in_place > most && self.cutter.log.has_moved() {
            let what = format!(
                "the tool turns by {:.1}° at feed while the tool tip stays: how long that takes is \
                 not known, as F is in degrees a minute there on many controls; turn it by a rapid \
                 move, or in a block that moves the tip",
                self.turned_in_place
            );
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// Tool centre point control. The tool does not move by it; on turned work its place has other
    /// coordinates, where they depend on known ones alone.
    pub(super) fn follow_tip(&mut self, follows: bool) -> Result<(), String> {
        if follows != self.rotary.follows_tip() && self.rotary.is_work_turned() {
            self.no_corner()?;
            self.cutter.at = self.rotary.told_otherwise(self.cutter.at);
        }
        self.rotary.follow_tip(follows);
        Ok(())
    }

    /// G28 and G30 go by way of the point that they name to the reference of its axes, or of all.
    pub(super) fn refer(&mut self, line: usize, block: &Block) -> Result<(), String> {
        let Plane([u, v, _]) = self.plane;
        if block.has_any(&[AXES[u], AXES[v]]) {
            self.keeps_frame("G28 and G30 by a place")?;
        }
        let by_way = self.way_of(block);
        if let (Some(before), [Some(x), Some(y), Some(z)]) = (self.cutter.place(), by_way)
            && Vector3::new(x, y, z) != before
        {
            self.line_to(line, Vector3::new(x, y, z), Pace::Rapid, None)?;
        }
        self.leave(line, block, "G28/G30");
        Ok(())
    }

    /// The axes that the block names, or all if it names none, go to where the program does not
    /// give.
    pub(super) fn leave(&mut self, line: usize, block: &Block, how: &str) {
        self.rotary.leave(block);
        let names_none = !block.has_any(&AXES);
        let axes = AXES.map(|axis| names_none || block.word(axis).is_some());
        self.cutter.leave(line, axes, how);
    }

    /// Of an arc; words that say nothing themselves are places where they are absolute.
    pub(super) fn centre(
        &self,
        block: &Block,
        start: Vector3<f64>,
        plane: Plane,
        is_absolute: bool,
    ) -> Result<Centre, String> {
        let start = self.in_program(start);
        let Plane([u, v, w]) = plane;
        if let Some(radius) = block.get('R').or(block.get(char::from(RADIUS))) {
            return Ok(Centre::Radius(self.mm(radius)));
        }
        let shift = self.shift.total();
        // Each as a place, if it is given.
        let place = |axis: usize| {
            block.word(CENTRES[axis]).map(|word| {
                let value = self.mm(word.value);
                let is_place = match word.counts {
                    Counts::AsModal => is_absolute,
                    Counts::Absolute => true,
                    Counts::Relative => false,
                };
                value + if is_place { shift[axis] } else { start[axis] }
            })
        };
        let at = |own: [f64; 2]| Ok(Centre::At(self.turned.map_or(own, |turned| turned.turn(own))));
        match (place(u), place(v), place(w)) {
            (None, None, None) if block.has_any(&[POLAR_ANGLE, POLAR_RADIUS]) => at(self.pole()),
            (None, None, _) => Err("an arc without centre or radius".to_owned()),
            (_, _, Some(along)) if along != start[w] && !is_absolute => {
                Err("the arc's centre does not lie in the plane of the arc".to_owned())
            }
            (Some(u), Some(v), _) => at([u, v]),
            _ if is_absolute => {
                Err("an absolute centre (G90.1) needs both of its words".to_owned())
            }
            (at_u, at_v, _) => at([at_u.unwrap_or(start[u]), at_v.unwrap_or(start[v])]),
        }
    }

    /// Keeps the figures of a move until the unit is stated.
    pub(super) fn watch_unit(&mut self, line: usize, block: &Block) {
        let words = block.words.iter().filter(|word| AXES.contains(&word.letter));
        let written = words.filter(|word| word.span.is_some());
        for word in written.clone().filter(|word| !word.is_computed) {
            self.cutter.unit.writes(line, word.value, word.has_point);
        }
        self.cutter.unit.goes_to(line, self.cutter.at, written.map(|word| word.value));
    }

    pub(super) fn work_offset(&mut self, line: usize, code: i64) -> Result<(), String> {
        if code != self.shift.active() {
            self.keeps_frame("another work offset")?;
        }
        self.moved_work.retain(|(_, by)| *by != MovedWork::OtherOffset);
        if self.shift.choose(code, self.cutter.at).is_err() {
            self.moved_work.push((line, MovedWork::OtherOffset));
        }
        Ok(())
    }

    /// Fanuc keeps work offsets in these parameters, too, and Haas radii of tools; before the path
    /// starts they are part of the job's work object.
    pub(super) fn set_parameter_of_work(&mut self, line: usize, number: i64) {
        if matches!((number / 100, number % 100), (25..=28, 0..=6)) && self.shift.has_started() {
            self.moved_work.push((line, MovedWork::Parameter(number)));
        }
    }

    /// A move: where the work is, nothing says, from these lines on.
    pub(super) fn tell_moved_work(&mut self) {
        for (line, by) in std::mem::take(&mut self.moved_work) {
            let what = match by {
                MovedWork::OtherOffset => {
                    "another work offset is chosen: the job's work_object is used throughout".into()
                }
                MovedWork::Parameter(number) => format!(
                    "#{number} is a work offset on Fanuc: the job's work_object is used \
                     throughout; for a number of the program's own take #100 to #199"
                ),
                MovedWork::EndOfG92 => "ends the G92 that states where the path starts: where the \
                                        work is then, nothing says"
                    .to_owned(),
            };
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// The path starts, or has started before.
    pub(super) fn starts(&mut self, line: usize) {
        self.tell_moved_work();
        let of_other = AXES.into_iter().zip(self.shift.start()).filter(|(_, is_so)| *is_so);
        let axes: Vec<String> = of_other.map(|(axis, _)| char::from(axis).to_string()).collect();
        if !axes.is_empty() {
            let what = format!(
                "the path starts under another work offset than the one under which {} was given: \
                 the job's work_object is used throughout",
                axes.join(" and ")
            );
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
    }
}
