//! What a G-code controller remembers from block to block, and the moves that come of it.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::arc::{self, Arc, Centre, Plane};
use super::block::Block;
use crate::motion::Target;
use crate::notes::Code;
use crate::program::log::Log;
use crate::program::tool_axis::orientation;
use crate::program::{Pace, Settings, Spindle, tool_number};
use crate::units::{m_from_mm, m_per_s_from_mm_per_min, mm_from_inch};

const AXES: [char; 3] = ['X', 'Y', 'Z'];
const CENTRES: [char; 3] = ['I', 'J', 'K'];

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    None,
    Rapid,
    Straight,
    Arc { clockwise: bool },
    Cycle(CycleKind),
}

/// What distinguishes the cycles as motion. Dwells and the short lifts of G73 leave the path as it
/// is.
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

/// What a cycle remembers from hole to hole, mm.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cycle {
    /// Z where the cycle was called: where G98 goes back to.
    pub(super) initial: f64,
    /// The R and Z words as given, in mm.
    pub(super) retract: Option<f64>,
    pub(super) bottom: Option<f64>,
    pub(super) step: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Feed {
    /// mm/min, if given.
    PerMinute(Option<f64>),
    /// mm a revolution, if given.
    PerRevolution(Option<f64>),
    InverseTime,
}

pub(super) struct Reader<'a> {
    settings: &'a Settings,
    pub(super) log: &'a mut Log,
    work_object: Isometry3<f64>,
    turned: UnitQuaternion<f64>,
    /// mm in the work object; `None` until given.
    pub(super) at: [Option<f64>; 3],
    pub(super) motion: Motion,
    pub(super) plane: Plane,
    pub(super) inches: bool,
    pub(super) relative: bool,
    pub(super) centre_absolute: bool,
    pub(super) feed: Feed,
    pub(super) back_to_initial: bool,
    pub(super) cycle: Cycle,
    spindle_rpm: Option<f64>,
    spindle_on: bool,
    next_tool: Option<u32>,
    /// T only selects, M6 changes; without an M6 in the program, T does both.
    waits_for_change: bool,
    offset: Option<i64>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(settings: &'a Settings, log: &'a mut Log, waits_for_change: bool) -> Self {
        Self {
            settings,
            log,
            work_object: settings.work_object.unwrap_or_default(),
            turned: orientation(Vector3::z_axis(), None),
            at: [None; 3],
            motion: Motion::None,
            plane: Plane::XY,
            inches: false,
            relative: false,
            centre_absolute: false,
            feed: Feed::PerMinute(None),
            back_to_initial: true,
            cycle: Cycle::default(),
            spindle_rpm: None,
            spindle_on: false,
            next_tool: None,
            waits_for_change,
            offset: None,
        }
    }

    pub(super) fn mm(&self, length: f64) -> f64 {
        if self.inches { mm_from_inch(length) } else { length }
    }

    pub(super) fn set_feed(&mut self, feed: f64) -> Result<(), String> {
        if feed <= 0.0 {
            return Err(format!("F is {feed}, must be positive"));
        }
        let mm = self.mm(feed);
        self.log.feed(matches!(self.feed, Feed::PerRevolution(_)));
        match &mut self.feed {
            Feed::PerMinute(value) | Feed::PerRevolution(value) => *value = Some(mm),
            Feed::InverseTime => {}
        }
        Ok(())
    }

    /// A feed of the other kind means nothing in this one.
    pub(super) fn feed_per_rev(&mut self, per_rev: bool) {
        self.feed = match (per_rev, self.feed) {
            (true, Feed::PerRevolution(_)) | (false, Feed::PerMinute(_)) => self.feed,
            (true, _) => Feed::PerRevolution(None),
            (false, _) => Feed::PerMinute(None),
        };
    }

    pub(super) fn pace(&self) -> Result<Pace, String> {
        match (self.feed, self.spindle_rpm) {
            (Feed::PerMinute(None) | Feed::PerRevolution(None), _) => Ok(Pace::Unstated),
            (Feed::PerMinute(Some(feed)), _) => Ok(Pace::Feed(m_per_s_from_mm_per_min(feed))),
            (Feed::PerRevolution(Some(feed)), Some(rpm)) if rpm > 0.0 => {
                Ok(Pace::Feed(m_per_s_from_mm_per_min(feed * rpm)))
            }
            (Feed::PerRevolution(_), _) => {
                Err("the feed is per revolution (G95), but S is not known".to_owned())
            }
            (Feed::InverseTime, _) => Err("inverse time feed (G93) is not supported".to_owned()),
        }
    }

    pub(super) fn set_spindle(&mut self, line: usize, rpm: f64) {
        self.spindle_rpm = Some(rpm);
        if self.spindle_on {
            self.log.spindle(line, Spindle::at(self.spindle_rpm));
        }
    }

    pub(super) fn turn_spindle(&mut self, line: usize, on: bool) {
        if on && self.spindle_rpm.is_none() {
            self.log.warning(Code::LeftOut, line, "M3/M4 without S: the speed is not known yet");
        }
        let spindle = if on { Spindle::at(self.spindle_rpm) } else { Spindle::Stands };
        self.log.spindle(line, spindle);
        self.spindle_on = on;
    }

    pub(super) fn select_tool(&mut self, tool: f64) -> Result<(), String> {
        self.next_tool = Some(tool_number(tool)?);
        if !self.waits_for_change {
            self.change_tool();
        }
        Ok(())
    }

    /// The tool that was selected is in the spindle from here on.
    pub(super) fn change_tool(&mut self) {
        if let Some(number) = self.next_tool {
            self.log.tool(number);
        }
    }

    pub(super) fn work_offset(&mut self, line: usize, code: i64) {
        if self.offset.is_some_and(|before| before != code) {
            let what = "another work offset is chosen: the job's work_object is used throughout";
            self.log.warning(Code::ChangeIgnored, line, what);
        }
        self.offset = Some(code);
    }

    /// The value of an axis word: mm in the work object.
    fn axis(&self, block: &Block, axis: usize) -> Result<Option<f64>, String> {
        let Some(letter) = AXES.get(axis) else { return Ok(None) };
        let before = self.at.get(axis).copied().flatten();
        match (block.get(*letter).map(|value| self.mm(value)), self.relative, before) {
            (None, _, before) => Ok(before),
            (Some(value), false, _) => Ok(Some(value)),
            (Some(by), true, Some(before)) => Ok(Some(before + by)),
            (Some(_), true, None) => Err(format!("{letter} is relative (G91) to no position")),
        }
    }

    pub(super) fn end_of(&self, block: &Block) -> Result<[Option<f64>; 3], String> {
        Ok([self.axis(block, 0)?, self.axis(block, 1)?, self.axis(block, 2)?])
    }

    /// The tool's place, if all of it is known.
    pub(super) fn place(&self) -> Option<[f64; 3]> {
        let [x, y, z] = self.at;
        Some([x?, y?, z?])
    }

    fn pose(&self, point: [f64; 3]) -> Isometry3<f64> {
        let at = Translation3::from(point.map(m_from_mm));
        self.work_object * Isometry3::from_parts(at, self.turned)
    }

    fn push(&mut self, line: usize, to: Target, pace: Pace) {
        let tcp = self.settings.tcp.unwrap_or_default();
        self.log.motion(line, to, tcp, pace);
    }

    pub(super) fn straight(
        &mut self,
        line: usize,
        block: &Block,
        pace: Pace,
    ) -> Result<(), String> {
        self.at = self.end_of(block)?;
        match self.place() {
            Some(place) => self.line_to(line, place, pace),
            None => {
                let what = "moves while not all of X, Y and Z are known are left out";
                self.log.warning(Code::LeftOut, line, what);
            }
        }
        Ok(())
    }

    pub(super) fn line_to(&mut self, line: usize, to: [f64; 3], pace: Pace) {
        self.push(line, Target::Line(self.pose(to)), pace);
        self.at = to.map(Some);
    }

    /// G28 and G30 go by way of the point that they name to the reference of its axes, or of all.
    pub(super) fn refer(&mut self, line: usize, block: &Block) -> Result<(), String> {
        if let Some(before) = self.place()
            && let [Some(x), Some(y), Some(z)] = self.end_of(block)?
            && [x, y, z] != before
        {
            self.line_to(line, [x, y, z], Pace::Rapid);
        }
        self.leave(line, block, "G28/G30");
        Ok(())
    }

    /// The axes that the block names, or all if it names none, go to where the program does not
    /// give.
    pub(super) fn leave(&mut self, line: usize, block: &Block, how: &str) {
        let names_none = AXES.iter().all(|&axis| block.get(axis).is_none());
        for (at, axis) in self.at.iter_mut().zip(AXES) {
            if names_none || block.get(axis).is_some() {
                *at = None;
            }
        }
        self.log.leaves(line, how);
    }

    pub(super) fn arc(
        &mut self,
        line: usize,
        block: &Block,
        clockwise: bool,
    ) -> Result<(), String> {
        let feed = self.pace()?;
        let start = self.place().ok_or("an arc from an unknown position")?;
        let [Some(x), Some(y), Some(z)] = self.end_of(block)? else {
            return Err("an arc to an unknown position".to_owned());
        };
        let end = [x, y, z];
        let centre = self.centre(block, start)?;
        let turns = block.get('P').unwrap_or(1.0);
        if !(1.0..=1000.0).contains(&turns) || turns.fract() != 0.0 {
            return Err(format!("P is {turns}, must be a whole number of turns"));
        }
        let arc = Arc {
            start,
            end,
            plane: self.plane,
            clockwise,
            centre,
            // Whole and in 0..1000, checked above.
            more_turns: turns as u32 - 1,
        };
        for piece in arc::pieces(&arc)? {
            let (via, end) = (self.pose(piece.via), self.pose(piece.end));
            self.push(line, Target::Arc { via, end }, feed);
        }
        self.at = end.map(Some);
        Ok(())
    }

    fn centre(&self, block: &Block, start: [f64; 3]) -> Result<Centre, String> {
        let Plane([u, v, w]) = self.plane;
        let offset = |axis: usize| {
            let letter = CENTRES.get(axis).copied().unwrap_or('I');
            block.get(letter).map(|value| self.mm(value))
        };
        if let Some(radius) = block.get('R') {
            return Ok(Centre::Radius(self.mm(radius)));
        }
        match (offset(u), offset(v), offset(w)) {
            (None, None, _) => Err("an arc without centre or radius".to_owned()),
            (_, _, Some(along)) if along != 0.0 && !self.centre_absolute => {
                Err("the arc's centre does not lie in the plane of the arc".to_owned())
            }
            (Some(u), Some(v), _) if self.centre_absolute => Ok(Centre::At([u, v])),
            _ if self.centre_absolute => {
                Err("an absolute centre (G90.1) needs both of its words".to_owned())
            }
            (by_u, by_v, _) => {
                Ok(Centre::At([start[u] + by_u.unwrap_or(0.0), start[v] + by_v.unwrap_or(0.0)]))
            }
        }
    }
}
