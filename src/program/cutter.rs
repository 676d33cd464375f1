//! The cutter of a CAM program: where it is in the work object, how fast it goes, and what becomes
//! of lines, arcs, holes and spindle commands. Every dialect of CAM systems ends here.
//!
//! Lengths in mm in the work object; the tool axis points from the work to the spindle.

use std::collections::HashMap;

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

use super::arc::{self, Arc};
use super::cell::without_own_frame;
use super::log::{Log, States};
use super::span::Span;
use super::tool_axis::orientation;
use super::unit_watch::UnitWatch;
use super::{Pace, Settings, Spindle, tool_number};
use crate::motion::{Target, Turning};
use crate::notes::Code;
use crate::units::{hz_from_rpm, m_from_mm, m_per_s_from_mm_per_min};

/// What a number of feed stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FeedKind {
    /// mm/min.
    PerMinute,
    /// mm a revolution.
    PerRevolution,
    /// Moves a minute; each move states its own.
    InverseTime,
}

/// A feed that holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Feed {
    pub(super) kind: FeedKind,
    /// `None` until one is stated.
    pub(super) value: Option<f64>,
}

/// How far over the last depth a peck stops where nothing says, as HEIDENHAIN's and Siemens' cycles
/// have it, by the depth of the hole. mm.
pub(super) fn over_peck(depth: f64) -> f64 {
    (depth / 50.0).clamp(0.6, 7.0)
}

/// A hole along the tool axis, mm above the place that it is drilled at.
#[derive(Debug, Clone)]
pub(super) struct Hole {
    /// Where the feed begins.
    pub(super) clearance: f64,
    /// How far down each peck goes, the last to the bottom.
    pub(super) depths: Vec<f64>,
    /// How far over the depth of the peck before the feed begins again.
    pub(super) over_peck: f64,
    /// By peck, how far the tool goes back behind it to break chips; where nothing is said, to the
    /// clearance.
    pub(super) lifts: Vec<Option<f64>>,
    /// How fast it goes back for that.
    pub(super) lift: Pace,
    /// Where the tool is left, by way of the clearance unless it comes out at rapid to below it.
    pub(super) retract: f64,
    pub(super) feed: Pace,
    pub(super) out: Pace,
    /// At the bottom, s.
    pub(super) dwell_s: f64,
    /// At the depth of each peck before the last, s.
    pub(super) dwell_peck_s: f64,
    /// Over the hole between pecks, s.
    pub(super) dwell_out_s: f64,
}

pub(super) struct Cutter<'a> {
    pub(super) log: &'a mut Log,
    settings: &'a Settings,
    work_object: Isometry3<f64>,
    tcp: Isometry3<f64>,
    pub(super) axis: Unit<Vector3<f64>>,
    turned: Option<UnitQuaternion<f64>>,
    /// `None` until known.
    pub(super) at: [Option<f64>; 3],
    /// Which way the tool went at the end of the last line or arc.
    pub(super) heading: Option<Vector3<f64>>,
    pub(super) feed: Feed,
    pub(super) rpm: Option<f64>,
    /// Whether the program has started or stopped the spindle, and which.
    pub(super) is_on: Option<bool>,
    /// Whether it turned when the tool was changed, and nothing has started it since.
    turns_through_change: bool,
    /// The first tool that has a name alone, and whether any has a number.
    named: Option<String>,
    has_number: bool,
    pub(super) unit: UnitWatch,
    loaded: Option<u32>,
    /// Another tool was loaded before.
    is_second: bool,
    /// A cut was refused whose tool nothing states.
    is_unmeasured: bool,
    /// The last move to a place that is not known in full: its line, and what is not.
    partly: Option<(usize, String)>,
    /// What is said of lines of moves at feed that are refused because the place is not known.
    lost: HashMap<usize, String>,
    /// The last move to where the program does not say: its line, and how.
    left: Option<(usize, String)>,
    /// The first place is where the tool is, and not where a move ends.
    pub(super) is_first_place_start: bool,
    /// Another tool has come into the spindle.
    is_changed: bool,
    /// What is to be told of a first move at feed behind that, unless the program starts the
    /// spindle only then.
    before_start: Option<(usize, String)>,
}

impl<'a> Cutter<'a> {
    pub(super) fn new(settings: &'a Settings, log: &'a mut Log) -> Self {
        Self {
            log,
            settings,
            work_object: settings.work_object.unwrap_or_default(),
            tcp: settings.tcp.unwrap_or_default(),
            axis: Vector3::z_axis(),
            turned: None,
            at: [None; 3],
            heading: None,
            feed: Feed { kind: FeedKind::PerMinute, value: None },
            rpm: None,
            is_on: None,
            turns_through_change: false,
            named: None,
            has_number: false,
            unit: UnitWatch::default(),
            loaded: None,
            is_second: false,
            is_unmeasured: false,
            partly: None,
            lost: HashMap::new(),
            left: None,
            is_first_place_start: false,
            is_changed: false,
            before_start: None,
        }
    }

    /// Where the tool is, if all of it is known.
    pub(super) fn place(&self) -> Option<Vector3<f64>> {
        let [x, y, z] = self.at;
        Some(Vector3::new(x?, y?, z?))
    }

    /// The tool axis from the next move on.
    pub(super) fn tilt(&mut self, axis: Unit<Vector3<f64>>) {
        if axis != self.axis {
            self.axis = axis;
            // The turn is least from the move before, which the next move works out.
            self.turned = self.turned.map(|before| orientation(axis, Some(before)));
        }
    }

    fn pose(&mut self, at: Vector3<f64>) -> Isometry3<f64> {
        let turned = *self.turned.get_or_insert_with(|| orientation(self.axis, None));
        let at = Translation3::from(at.map(m_from_mm));
        self.work_object * Isometry3::from_parts(at, turned)
    }

    pub(super) fn line_to(&mut self, line: usize, to: Vector3<f64>, pace: Pace) {
        self.tell_turning(line, pace);
        self.tell_unmeasured(line, pace);
        self.tell_start(line, pace);
        let pose = self.pose(to);
        self.log.motion(line, Target::Line(pose), self.tcp, pace);
        self.heading = self.place().and_then(|from| (to - from).try_normalize(1e-9));
        self.at = [Some(to.x), Some(to.y), Some(to.z)];
    }

    /// A line, unless the tool is there already.
    pub(super) fn apart(&mut self, line: usize, to: Vector3<f64>, pace: Pace) {
        if self.place() != Some(to) {
            self.line_to(line, to, pace);
        }
    }

    /// An arc or helix from where the tool is. A pace in seconds is that of the whole.
    pub(super) fn arc(&mut self, line: usize, arc: &Arc, pace: Pace) -> Result<(), String> {
        let pieces = arc::pieces(arc)?;
        self.tell_turning(line, pace);
        self.tell_unmeasured(line, pace);
        self.heading = arc::heading(arc, &pieces);
        let pace = match pace {
            Pace::Seconds(seconds) => Pace::Seconds(seconds / pieces.len() as f64),
            pace => pace,
        };
        for piece in pieces {
            let [via, end] = [piece.via, piece.end].map(|point| self.pose(point));
            self.log.motion(
                line,
                Target::Arc { via, end, turning: Turning::ByWay },
                self.tcp,
                pace,
            );
        }
        self.at = [Some(arc.end.x), Some(arc.end.y), Some(arc.end.z)];
        Ok(())
    }

    /// An arc that a program gives by its centre.
    pub(super) fn tell_tiny(&mut self, line: usize, arc: &Arc) {
        if let Some(length) = arc::tiny(arc) {
            let what = format!(
                "an arc of {length:.5} mm: controls that round places to 0.001 mm may make a whole \
                 circle of it; write a circle with its end where it begins, or no arc"
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// Over the hole at the height where the tool is or the clearance, down, and out. `axis` is a
    /// unit vector out of the hole.
    pub(super) fn hole(&mut self, line: usize, at: Vector3<f64>, axis: Vector3<f64>, hole: &Hole) {
        self.over_hole(line, at, axis, hole.clearance);
        self.straight_to_hole(line, at, axis, hole);
    }

    /// Level over the hole, at the height where the tool is or, if that is lower, `least`.
    pub(super) fn over_hole(
        &mut self,
        line: usize,
        at: Vector3<f64>,
        axis: Vector3<f64>,
        least: f64,
    ) {
        let height = self.place().map_or(least, |place| (place - at).dot(&axis));
        if height < least
            && let Some(place) = self.place()
        {
            self.apart(line, place + axis * (least - height), Pace::Rapid);
        }
        self.apart(line, at + axis * height.max(least), Pace::Rapid);
    }

    /// Straight to the clearance over the hole, down, and out.
    pub(super) fn straight_to_hole(
        &mut self,
        line: usize,
        at: Vector3<f64>,
        axis: Vector3<f64>,
        hole: &Hole,
    ) {
        let above = |height: f64| at + axis * height;
        self.apart(line, above(hole.clearance), Pace::Rapid);
        for (index, &depth) in hole.depths.iter().enumerate() {
            if let Some(&before) = index.checked_sub(1).and_then(|last| hole.depths.get(last)) {
                self.log.dwell(line, hole.dwell_peck_s);
                let lift = hole.lifts.get(index - 1).copied().flatten();
                let lifted = lift.map_or(hole.clearance, |lift| before + lift).min(hole.clearance);
                let pace = if lift.is_some() { hole.lift } else { hole.out };
                self.apart(line, above(lifted), pace);
                if lift.is_none() {
                    self.log.dwell(line, hole.dwell_out_s);
                    let from = (before + hole.over_peck).min(hole.clearance);
                    self.apart(line, above(from), Pace::Rapid);
                }
            }
            self.apart(line, above(depth), hole.feed);
        }
        self.log.dwell(line, hole.dwell_s);
        if hole.retract >= hole.clearance || hole.out != Pace::Rapid {
            self.apart(line, above(hole.clearance), hole.out);
        }
        self.apart(line, above(hole.retract), Pace::Rapid);
    }

    /// A hole is tapped: at its bottom the spindle turns round.
    pub(super) fn taps(&mut self, line: usize) {
        let what = "tapping stops the spindle and turns it back in the hole: the speeds that it \
                    passes are not checked";
        self.log.warning(Code::SpindleCommand, line, what);
    }

    /// Sets the kind of feed; a number of another kind means nothing in it.
    pub(super) fn feed_kind(&mut self, kind: FeedKind) {
        if self.feed.kind != kind {
            self.feed = Feed { kind, value: None };
        }
    }

    /// States a feed: `written` is the number in the text, the value what it stands for.
    pub(super) fn state_feed(&mut self, line: usize, feed: Feed, written: f64, span: Option<Span>) {
        let states = match feed.kind {
            FeedKind::PerMinute | FeedKind::InverseTime => States::Feed { value: written },
            FeedKind::PerRevolution => States::FeedPerRevolution,
        };
        self.log.states(line, span, states);
        if feed.kind == FeedKind::PerMinute {
            self.unit.feeds(written);
        }
        self.feed = feed;
    }

    /// The pace of moves at feed.
    pub(super) fn pace(&self) -> Result<Pace, String> {
        self.pace_of(self.feed)
    }

    pub(super) fn pace_of(&self, feed: Feed) -> Result<Pace, String> {
        match (feed.kind, feed.value) {
            (FeedKind::InverseTime, None) => {
                Err("a move in inverse time (G93) without a feed of its own".to_owned())
            }
            (_, None) => Ok(Pace::Unstated),
            (FeedKind::PerMinute, Some(feed)) => Ok(Pace::Feed(m_per_s_from_mm_per_min(feed))),
            (FeedKind::InverseTime, Some(feed)) => Ok(Pace::Seconds(1.0 / hz_from_rpm(feed))),
            (FeedKind::PerRevolution, Some(feed)) => match self.rpm {
                Some(rpm) if rpm > 0.0 => Ok(Pace::Feed(m_per_s_from_mm_per_min(feed * rpm))),
                _ => Err("the feed is per revolution, but the spindle's speed is not known".into()),
            },
        }
    }

    /// A speed that the program states; it holds where the spindle turns, or where the program has
    /// neither started nor stopped it.
    pub(super) fn state_speed(
        &mut self,
        line: usize,
        rpm: f64,
        span: Option<Span>,
    ) -> Result<(), String> {
        if !(rpm >= 0.0 && rpm.is_finite()) {
            return Err(format!("the spindle's speed is {rpm} rpm, must not be negative"));
        }
        if rpm > 0.0 {
            self.log.states(line, span, States::speed(rpm));
        }
        self.rpm = Some(rpm);
        if self.is_on == Some(true) {
            self.log.spindle(line, Spindle::at(self.rpm));
        }
        Ok(())
    }

    /// The speed holds though nothing has started the spindle.
    pub(super) fn assume_started(&mut self, line: usize) {
        if self.is_on.is_none() && self.rpm.is_some() {
            self.log.spindle(line, Spindle::at(self.rpm));
        }
    }

    pub(super) fn turn_spindle(&mut self, line: usize, on: bool) {
        if on {
            self.before_start = None;
        }
        self.tell_before_start();
        let spindle = if on { Spindle::at(self.rpm) } else { Spindle::Stands };
        self.log.spindle(line, spindle);
        self.is_on = Some(on);
        self.turns_through_change = false;
    }

    /// Another tool comes into the spindle.
    pub(super) fn change(&mut self) {
        self.tell_before_start();
        self.is_changed = true;
        self.turns_through_change |= self.is_on == Some(true);
    }

    /// The first move at feed behind a change of tool.
    fn tell_turning(&mut self, line: usize, pace: Pace) {
        if pace != Pace::Rapid && std::mem::take(&mut self.turns_through_change) {
            let what = "cuts with the spindle as it turned before the change of tool: most \
                        controls stop it there, and nothing starts it again";
            self.log.warning(Code::SpindleCommand, line, what);
        }
    }

    /// A cut while nothing says which of the job's tools is in the spindle.
    fn tell_unmeasured(&mut self, line: usize, pace: Pace) {
        let is_measured = self.loaded.is_some() || self.settings.tcp.is_some();
        if pace == Pace::Rapid || is_measured || self.settings.tool_frames.is_empty() {
            return;
        }
        if !std::mem::replace(&mut self.is_unmeasured, true) {
            let what = "cuts, and no number of a tool says which of path.program.tool_frames it \
                        is: state the job's tcp, or the tool's name under tools, or have the \
                        number written";
            self.log.error(Code::Motion, line, what);
        }
    }

    /// A cut that completes the place is not on the path, which begins at its end.
    fn tell_start(&mut self, line: usize, pace: Pace) {
        let is_known = self.place().is_some() || self.is_first_place_start;
        // Else the log tells of it.
        let is_own = !self.log.begins_away();
        if pace == Pace::Rapid || is_known || self.is_on == Some(false) || !is_own {
            return;
        }
        let what = format!(
            "a move at feed from where {} not known: what it cuts on the way is not checked; state \
             X, Y and Z by rapid moves before",
            self.unknown_axes()
        );
        // The change stops the spindle, which may stand up to a start that follows.
        if self.is_changed && self.is_on.is_none() {
            self.before_start.get_or_insert((line, what));
            return;
        }
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    /// Nothing has started the spindle behind a first move at feed.
    fn tell_before_start(&mut self) {
        if let Some((line, what)) = self.before_start.take() {
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// Whether another tool than one of this number is in the spindle, as far as it is known.
    pub(super) fn has_other_than(&self, number: f64) -> bool {
        match self.numbered() {
            Some(loaded) => f64::from(loaded) != number,
            None => self.named.is_some(),
        }
    }

    pub(super) fn tool(&mut self, number: f64) -> Result<(), String> {
        let number = tool_number(number)?;
        self.has_number = true;
        self.log.tool(number);
        self.measure(number)
    }

    /// The tool centre point of a tool; 0 is none.
    fn measure(&mut self, number: u32) -> Result<(), String> {
        self.is_second |= self.loaded.replace(number).is_some_and(|before| before != number);
        let frames = &self.settings.tool_frames;
        let own = frames.get(&number).or(self.settings.tcp.as_ref());
        if own.is_none() && number != 0 && !frames.is_empty() {
            return Err(format!(
                "tool {number} is not among path.program.tool_frames, and the job has no tcp"
            ));
        }
        self.tcp = own.copied().unwrap_or_default();
        self.log.tcp_of(without_own_frame(self.settings, number));
        Ok(())
    }

    /// While no tool has a number, a length stands for its tool by its own: H, or an edge (D) under
    /// whose number the job measures a tool.
    pub(super) fn measure_length(&mut self, number: u32, is_edge: bool) -> Result<(), String> {
        let is_tool = !is_edge || self.settings.tool_frames.contains_key(&number);
        if is_tool && !self.has_number { self.measure(number) } else { Ok(()) }
    }

    /// The tool that is loaded, if the program gives its number.
    pub(super) fn numbered(&self) -> Option<u32> {
        self.loaded.filter(|_| self.has_number)
    }

    /// The same, or the number of the length that stands for it.
    pub(super) fn loaded(&self) -> Option<u32> {
        self.loaded
    }

    /// The diameter of the tool in the spindle, mm, as the job states it; where it states that of
    /// one tool, that is the first.
    pub(super) fn diameter_mm(&self) -> Option<f64> {
        let all = &self.settings.tool_diameters_mm;
        let own = self.loaded.and_then(|number| all.get(&Some(number)));
        own.or_else(|| all.get(&None).filter(|_| !self.is_second)).copied()
    }

    /// The number of a tool that the job lists by its name.
    pub(super) fn number_of(&self, name: &str) -> Option<u32> {
        self.settings.tool_names.get(name).copied()
    }

    /// A tool by a name that the job does not list: the first is taken for the job's.
    pub(super) fn named_tool(&mut self, line: usize, name: &str) {
        let what = format!(
            "tool \"{name}\" has a name and no number (tools in the job may give one: {{1: {{name: \
             \"{name}\", …}}}})"
        );
        let is_first = self.named.get_or_insert_with(|| name.to_owned()) == name;
        if is_first && !self.has_number {
            self.log.warning(Code::LeftOut, line, format!("{what}: left out"));
        } else {
            let what = format!("{what}: the one before is taken to stay");
            self.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// A rapid move to a place that is not known in full.
    pub(super) fn goes_partly(&mut self, line: usize, at: [Option<f64>; 3]) {
        self.at = at;
        let mut what = format!("{} not known up to here", self.unknown_axes());
        if let Some((line, how)) = &self.left {
            what += &format!(" ({how} in line {line} goes to where the program does not say)");
        }
        self.partly = Some((line, what));
    }

    /// At the end of a program: what starts too late, or goes to no place which is known in full.
    pub(super) fn tell_not_started(&mut self) {
        self.tell_before_start();
        let is_told = self.log.has_moved() || self.log.has_errors();
        if let Some((line, what)) = self.partly.take().filter(|_| !is_told) {
            let what = format!(
                "{what}, and the path starts where X, Y and Z are all known: no move is read; \
                 state X, Y and Z by rapid moves"
            );
            self.log.error(Code::Motion, line, what);
        }
    }

    /// A move to where the program does not say.
    pub(super) fn leave(&mut self, line: usize, axes: [bool; 3], how: &str) {
        for (at, leaves) in self.at.iter_mut().zip(axes) {
            if leaves {
                *at = None;
            }
        }
        self.left = Some((line, how.to_owned()));
        self.log.leaves(line, how);
    }

    /// A way at feed to a place that the program does not give cuts, or may.
    pub(super) fn cut_away(&mut self, line: usize, how: &str) {
        let what = format!(
            "{how} at feed: the place is not in the program, so what is cut on the way there is \
             not checked; write it as a rapid move if nothing is"
        );
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    /// A move at feed while the place is not known is cutting that would be lost. Of a line that a
    /// loop runs again, where it may be other axes, the same is said, which is kept once.
    pub(super) fn unknown(&mut self, line: usize) -> String {
        let unknown = self.unknown_axes();
        let what = || {
            format!(
                "a move at feed while {unknown} not known; state X, Y and Z by rapid moves before"
            )
        };
        self.lost.entry(line).or_insert_with(what).clone()
    }

    /// `X and Y are`.
    fn unknown_axes(&self) -> String {
        let axes = ["X", "Y", "Z"].into_iter().zip(self.at);
        let unknown: Vec<&str> =
            axes.filter(|(_, at)| at.is_none()).map(|(axis, _)| axis).collect();
        let are = if unknown.len() == 1 { "is" } else { "are" };
        format!("{} {are}", unknown.join(" and "))
    }

    /// What a program may carry beside the motion, told once.
    pub(super) fn left_out(&mut self, line: usize, what: String) {
        self.log.warning(Code::LeftOut, line, what);
    }
}
