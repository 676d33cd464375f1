//! The one stream that every dialect writes into: moves, dwells, spindle, tool, load, and the words
//! of the text that state speeds and feeds.

mod away;

use std::collections::HashSet;
use std::fmt;
use std::sync::Arc;

use nalgebra::Isometry3;

use self::away::left_out;
use super::grouping::{Kinds, grouped};
use super::span::Span;
use super::{Dialect, Pace, Program, Settings, Spindle, SpindleCommand, standing};
use crate::motion::{
    Circle, Configuration, Load, Move, Stated, StatedFeeds, Target, Timing, Turning, Work,
};
use crate::notes::{Class, Code, Note, Notes};

/// Moves, spindle commands, errors and warnings so far.
#[derive(Debug)]
pub(super) struct Log {
    /// More than this is a fault.
    max_moves: usize,
    /// At what speed rapid moves are taken to run.
    rapid_m_per_s: f64,
    /// The job's feed.
    feed_m_per_s: Option<f64>,
    is_full: bool,
    moves: Vec<Move>,
    spindle: Vec<SpindleCommand>,
    /// Lines at which the job's `spindle_from` or `tool_from` has set something.
    set_by: HashSet<usize>,
    words: Vec<Word>,
    /// Where the last motion went, if that is a pose.
    last: Option<Last>,
    /// Moves beyond the first whose speed the program leaves open: their number, and the first's
    /// line.
    rapid: Option<(usize, usize)>,
    /// The tool that has no tcp but the job's, or none, now, and the first that has moved at feed
    /// so.
    tcp_of: [Option<Tool>; 2],
    /// The line that sends the tool to that the program does not give, and how.
    away: Option<(usize, String)>,
    /// Whether the program goes to such a place before the path starts.
    begins_away: bool,
    /// What holds for the next move.
    stated: Arc<Stated>,
    /// Where the work is on the next move.
    work: Work,
    feeds: StatedFeeds,
    notes: Notes,
    kinds: Kinds,
    /// Where in another file the statement that runs stands, before what is told of it.
    within: String,
    /// Texts of the warnings.
    warned: HashSet<String>,
    /// Of those that are doubts.
    doubts: HashSet<String>,
}

/// Turns from here on may go either way round: programs round to a few digits.
const HALF_TURN_RAD: f64 = std::f64::consts::PI - 2e-3;

/// A tool whose tool centre point no file gives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Tool {
    Number(u32),
    Name(String),
}

impl fmt::Display for Tool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "tool {number}"),
            Self::Name(name) => write!(f, "tool '{name}'"),
        }
    }
}

/// Where the last motion went.
#[derive(Debug, Clone, Copy)]
pub(super) struct Last {
    /// The tip in the base frame.
    tip: Isometry3<f64>,
    /// As the move has it.
    pub(super) tcp: Isometry3<f64>,
    /// Whether the arm holds the work, not the tool.
    pub(super) holds_work: bool,
}

impl Last {
    /// Where another tool has its centre point there, in the base frame.
    pub(super) fn with(&self, tcp: &Isometry3<f64>) -> Isometry3<f64> {
        self.tip * tcp
    }

    /// Where a tool is there, in the frame of the work at the start of a move.
    pub(super) fn seen_from(&self, work: &Work, tcp: &Isometry3<f64>) -> Isometry3<f64> {
        work.pose(0.0, &self.tip, tcp)
    }
}

/// A number in the text that states a speed or a feed, and where it began to hold.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Word {
    pub(super) line: usize,
    /// `None` where no number in the text is it: it is computed.
    pub(super) span: Option<Span>,
    pub(super) states: States,
    /// Index of the first move that may run under it.
    pub(super) from_move: usize,
}

/// What a number in the text states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum States {
    /// Spindle speed; one unit stands for so many rev/min; whether what it is given to takes whole
    /// numbers only.
    Spindle { value: f64, rpm_per_unit: f64, whole: bool },
    /// Feed per time, in some unit.
    Feed { value: f64 },
    /// Speed in a name of the language (`v100`), mm/s. Behind it, it can be given by `\V`, or the
    /// data take its place.
    NamedFeed { mm_per_s: f64, takes_v: bool },
    /// A time instead of a speed.
    Seconds { value: f64 },
    /// Feed per revolution.
    FeedPerRevolution,
    /// A tap follows at a feed per time: its pitch is feed over speed.
    Tap,
}

impl States {
    /// A spindle speed in rev/min.
    pub(super) fn speed(rpm: f64) -> Self {
        Self::Spindle { value: rpm, rpm_per_unit: 1.0, whole: false }
    }
}

impl Log {
    pub(super) fn new(max_moves: usize, settings: &Settings) -> Self {
        Self::of(max_moves, settings.rapid_m_per_s, settings.feed_m_per_s)
    }

    /// An empty one for the same program.
    pub(super) fn beside(&self) -> Self {
        Self::of(self.max_moves, self.rapid_m_per_s, self.feed_m_per_s)
    }

    fn of(max_moves: usize, rapid_m_per_s: f64, feed_m_per_s: Option<f64>) -> Self {
        Self {
            max_moves,
            rapid_m_per_s,
            feed_m_per_s,
            is_full: false,
            moves: Vec::new(),
            spindle: Vec::new(),
            set_by: HashSet::new(),
            words: Vec::new(),
            last: None,
            rapid: None,
            tcp_of: [None, None],
            away: None,
            begins_away: false,
            stated: Arc::default(),
            work: Work::Stands,
            feeds: StatedFeeds::default(),
            notes: Notes::default(),
            kinds: Kinds::default(),
            within: String::new(),
            warned: HashSet::new(),
            doubts: HashSet::new(),
        }
    }

    /// Whether another has the same moves and speeds, and neither an error nor a doubt more. Arm
    /// configurations may be watched in one alone.
    pub(super) fn moves_like(&self, other: &Self) -> bool {
        let unwatched =
            |own: &Stated| Stated { configuration: None, uncompared: None, ..own.clone() };
        let is_like = |(a, b): (&Move, &Move)| {
            let stated = &a.stated;
            a == b
                || unwatched(stated) == unwatched(&b.stated)
                    && *a == Move { stated: Arc::clone(stated), ..b.clone() }
        };
        !other.has_errors()
            && self.moves.len() == other.moves.len()
            && self.moves.iter().zip(&other.moves).all(is_like)
            && self.spindle == other.spindle
            && other.doubts.is_subset(&self.doubts)
    }

    /// A program of so many lines follows: most make one move or none.
    pub(super) fn expect_lines(&mut self, lines: usize) {
        self.moves.reserve(lines.min(self.max_moves));
    }

    /// Motion is lost, wrong or impossible. The same error of the same line (in a loop) is kept
    /// once.
    pub(super) fn error(&mut self, code: Code, line: usize, what: impl Into<String>) {
        let what = format!("{}{}", self.within, what.into());
        if self.kinds.is_first(code, line, &what) {
            self.notes.error(code, line, what);
        }
    }

    pub(super) fn has_errors(&self) -> bool {
        self.notes.errors() > 0
    }

    /// More statements run than any program has; the program stops at this line.
    pub(super) fn runs_too_long(&mut self, line: usize) {
        let what = "the program runs too long here: a loop without an end, or one that an \
                    interrupt or another program ends, which is not read";
        self.error(Code::TooLong, line, what);
    }

    /// Something beside the motion is left out or assumed; kept once, at the first line of the main
    /// file or of another.
    pub(super) fn warning(&mut self, code: Code, line: usize, what: impl Into<String>) {
        let what = what.into();
        if code.class() == Class::Doubt {
            self.doubts.insert(what.clone());
        }
        if self.warned.insert(what.clone()) {
            self.notes.warning(code, line, format!("{}{what}", self.within));
        }
    }

    /// What is told from here on is of a place in another file; gives the one before.
    pub(super) fn within(&mut self, place: String) -> String {
        std::mem::replace(&mut self.within, place)
    }

    /// Where in another file the statement that runs stands, before what is told of it.
    pub(super) fn place(&self) -> &str {
        &self.within
    }

    /// Numbers may be right in the text and overflow on the way to the base frame; one line may ask
    /// for more moves than the memory holds.
    pub(super) fn motion(&mut self, line: usize, to: Target, tcp: Isometry3<f64>, pace: Pace) {
        if self.is_full {
            return;
        }
        if matches!(pace, Pace::Feed(_) | Pace::Unstated | Pace::Seconds(_)) {
            self.one_tcp_for_all(line);
        }
        self.tell_start(line, &to, pace);
        let to = self.come_back(line, to, pace);
        let last = self.last;
        if let Some(last) = last
            && turn_rad(&last.seen_from(&self.work, &tcp), &to) > HALF_TURN_RAD
        {
            let what = "the tool turns by 180° on this way, and nothing says which way round: a \
                        point between would";
            self.warning(Code::AxisIgnored, line, what);
        }
        self.last = match &to {
            Target::Joints(_) => None,
            Target::JointsTo(at) | Target::Line(at) | Target::Arc { end: at, .. } => {
                let holds_work = self.work == Work::Held;
                Some(Last { tip: self.work.tip(1.0, at, &tcp), tcp, holds_work })
            }
        };
        let (feed_m_per_s, timing) = match pace {
            Pace::Feed(feed_m_per_s) => (feed_m_per_s, Timing::Feed),
            Pace::Rapid => (self.count_rapid(line), Timing::Rapid),
            Pace::Unstated => (self.feed_of_job(line), Timing::Feed),
            Pace::Joints(share) => (self.rapid_m_per_s, Timing::Joints(share)),
            Pace::Seconds(seconds) => {
                let from = last.map(|last| last.seen_from(&self.work, &tcp));
                let feed = from.and_then(|from| way_m(&from, &to)).map(|m| m / seconds);
                let feed = feed.filter(|feed| *feed > 0.0 && feed.is_finite());
                (feed.unwrap_or(self.rapid_m_per_s), Timing::Seconds(seconds))
            }
        };
        let (stated, work) = (Arc::clone(&self.stated), self.work.clone());
        self.push(Move { to, feed_m_per_s, timing, tcp, work, line, spindle_turns: true, stated });
    }

    fn push(&mut self, to: Move) {
        if self.moves.len() >= self.max_moves {
            self.is_full = true;
            let what = format!(
                "the program makes more than {} moves by here; split it into several operations",
                self.max_moves
            );
            self.error(Code::TooLong, to.line, what);
        } else if is_finite(&to) {
            self.moves.push(to);
        } else {
            self.error(Code::Value, to.line, "the target or the feed is too large a number");
        }
    }

    /// The arm stands for some time. Before the path starts nothing stands.
    pub(super) fn dwell(&mut self, line: usize, seconds: f64) {
        /// A day.
        const MAX_S: f64 = 86_400.0;
        if !(0.0..=MAX_S).contains(&seconds) {
            let what = format!("the arm is to stand for {seconds} s, expected 0 to {MAX_S}");
            self.error(Code::Value, line, what);
            return;
        }
        // It stands as it is.
        self.configure(None);
        self.external_needs(0.0);
        let Some(last) = self.moves.last().filter(|_| seconds > 0.0 && !self.is_full) else {
            return;
        };
        let to = match &last.to {
            Target::Joints(_) => last.to.clone(),
            Target::JointsTo(at) | Target::Line(at) | Target::Arc { end: at, .. } => {
                Target::JointsTo(*at)
            }
        };
        let stated = Arc::clone(&self.stated);
        let (timing, work) = (Timing::Seconds(seconds), last.work.ended());
        self.push(Move { to, timing, work, line, stated, spindle_turns: true, ..*last });
    }

    /// This tool has no tcp but the job's, or none, from here on; `None` is one without a name or a
    /// number, or with a tcp of its own.
    pub(super) fn tcp_of(&mut self, tool: Option<Tool>) {
        self.tcp_of[0] = tool;
    }

    /// The tool that has no tcp of its own, as `tcp_of` has stated it.
    pub(super) fn tool_of_tcp(&self) -> Option<Tool> {
        self.tcp_of[0].clone()
    }

    /// One tcp for two tools is right only where they are of one length.
    fn one_tcp_for_all(&mut self, line: usize) {
        let [Some(now), first] = &self.tcp_of else { return };
        match first {
            None => self.tcp_of[1] = Some(now.clone()),
            Some(first) if first == now => {}
            Some(first) => {
                let remedy = match (first, now) {
                    (Tool::Number(first), Tool::Number(now)) => format!(
                        "write path.program.tool_frames: {{{first}: {{xyz_m: …}}, {now}: …}} in \
                         the job"
                    ),
                    _ => "name the file that declares them under path.program.files".to_owned(),
                };
                let what = format!(
                    "{now} has the same tcp as {first}, and they may be of different lengths: \
                     {remedy}"
                );
                self.warning(Code::ChangeIgnored, line, what);
            }
        }
    }

    /// Where the tip is behind a motion to joints, by the job's robot.
    pub(super) fn stands_at(&mut self, tip: Isometry3<f64>, tcp: Isometry3<f64>) {
        self.last = Some(Last { tip, tcp, holds_work: false });
    }

    /// The lowest feed of lines and arcs that have a length and on which the spindle may turn, m/s.
    /// Nothing moves to where the path starts.
    pub(super) fn slowest_led(&self) -> Option<f64> {
        const NO_LENGTH_M: f64 = 1e-4;
        let place = |to: &Target| match to {
            Target::Joints(_) => None,
            Target::JointsTo(at) | Target::Line(at) | Target::Arc { end: at, .. } => {
                Some(at.translation.vector)
            }
        };
        let is_led = |(before, each): &(&Move, &Move)| {
            let has_length = match (&each.to, place(&before.to)) {
                (Target::Line(at), Some(from)) => {
                    (at.translation.vector - from).norm() > NO_LENGTH_M
                }
                (Target::Line(_), None) | (Target::Arc { .. }, _) => true,
                _ => false,
            };
            has_length && each.stated.spindle != Some(Spindle::Stands)
        };
        let led = self.moves.iter().zip(self.moves.iter().skip(1)).filter(is_led);
        led.map(|(_, each)| each.feed_m_per_s).reduce(f64::min)
    }

    /// Where the last motion went, if that is a pose.
    pub(super) fn last(&self) -> Option<Last> {
        self.last
    }

    /// The statement of a line sets the spindle or the tool.
    pub(super) fn sets(&mut self, line: usize) {
        self.set_by.insert(line);
    }

    /// Whether the statement of a line has set the spindle or the tool.
    pub(super) fn has_set(&self, line: usize) -> bool {
        self.set_by.contains(&line)
    }

    /// Whether the program sets a speed of the spindle that is known before anything moves: the
    /// first of all moves goes to where the path starts.
    pub(super) fn starts_under_speed(&self) -> bool {
        let first = self.spindle.first();
        first.is_some_and(|first| first.from_move <= 1 && first.spindle.rpm().is_some())
    }

    /// Whether the path goes on from where it starts.
    pub(super) fn has_way(&self) -> bool {
        self.moves.len() > 1
    }

    /// Whether the path has started.
    pub(super) fn has_moved(&self) -> bool {
        !self.moves.is_empty()
    }

    /// The speed that is assumed because the program gives none. The first of all moves does not
    /// count: it goes to where the path starts.
    fn count_rapid(&mut self, line: usize) -> f64 {
        if !self.moves.is_empty() {
            let (count, _) = self.rapid.get_or_insert((0, line));
            *count += 1;
        }
        self.rapid_m_per_s
    }

    /// The feed of the job where the program states none. The first of all moves does not count.
    fn feed_of_job(&mut self, line: usize) -> f64 {
        /// Stands in where there is none, which is an error.
        const ANY: f64 = 1.0;
        if !self.moves.is_empty() {
            self.feeds.incomplete = true;
            // What is wrong before may have stated it.
            if self.feed_m_per_s.is_none() && !self.has_errors() {
                let what = "moves at a feed that the program does not state: write \
                            feed_mm_per_min in the job's operation";
                if self.warned.insert(what.to_owned()) {
                    self.error(Code::MissingKey, line, what);
                }
            }
        }
        self.feed_m_per_s.unwrap_or(ANY)
    }

    /// Another tool is loaded, by its number.
    pub(super) fn tool(&mut self, number: u32) {
        if self.stated.tool != Some(number) {
            Arc::make_mut(&mut self.stated).tool = Some(number);
        }
    }

    /// Where the work is on the moves from here on.
    pub(super) fn work(&mut self, work: Work) {
        self.work = work;
    }

    /// A joint of the robot is at a position, rad or m, at the ends of the moves from here on.
    pub(super) fn hold(&mut self, joint: usize, position: f64) {
        let placed = self.stated.external.iter().position(|(own, _)| *own == joint);
        match placed {
            Some(index) if self.stated.external[index].1 == position => {}
            Some(index) => Arc::make_mut(&mut self.stated).external[index].1 = position,
            None => Arc::make_mut(&mut self.stated).external.push((joint, position)),
        }
    }

    /// How fast the tool may turn on lines and arcs from here on, rad/s.
    pub(super) fn turns_at(&mut self, speed: Option<f64>) {
        let speed = speed.filter(|speed| *speed > 0.0 && speed.is_finite());
        if self.stated.turning_rad_per_s != speed {
            Arc::make_mut(&mut self.stated).turning_rad_per_s = speed;
        }
    }

    /// What external axes need for the next move, s.
    pub(super) fn external_needs(&mut self, seconds: f64) {
        if self.stated.external_s != seconds {
            Arc::make_mut(&mut self.stated).external_s = seconds;
        }
    }

    /// The arm configuration that the next move asks for.
    pub(super) fn configure(&mut self, asked: Option<Configuration>) {
        if self.stated.configuration.as_deref() != asked.as_ref() {
            Arc::make_mut(&mut self.stated).configuration = asked.map(Arc::new);
        }
    }

    /// What the program says of the arm configuration of the next move, if that is the first one
    /// and cannot be compared.
    pub(super) fn compares_no(&mut self, said: Option<String>) {
        if self.stated.uncompared.as_deref() != said.as_deref() {
            Arc::make_mut(&mut self.stated).uncompared = said.map(Arc::from);
        }
    }

    /// What the tip carries from here on.
    pub(super) fn load(&mut self, load: Option<&Arc<Load>>) {
        if self.stated.load.as_ref() != load {
            Arc::make_mut(&mut self.stated).load = load.cloned();
        }
    }

    /// What the tip carries now.
    pub(super) fn carried(&self) -> Option<Arc<Load>> {
        self.stated.load.clone()
    }

    /// A number of the text states something; feeds are taken down as the program's own.
    pub(super) fn states(&mut self, line: usize, span: Option<Span>, states: States) {
        match states {
            States::Feed { .. } | States::NamedFeed { .. } | States::Seconds { .. } => {
                self.feeds.per_time = true;
            }
            States::FeedPerRevolution => self.feeds.per_revolution = true,
            States::Spindle { .. } | States::Tap => {}
        }
        self.words.push(Word { line, span, states, from_move: self.moves.len() });
    }

    /// Whether there are more moves than are accepted: reading on is in vain.
    pub(super) fn is_full(&self) -> bool {
        self.is_full
    }

    pub(super) fn spindle(&mut self, line: usize, spindle: Spindle) {
        if self.stated.spindle != Some(spindle) {
            Arc::make_mut(&mut self.stated).spindle = Some(spindle);
        }
        self.spindle.push(SpindleCommand { line, spindle, from_move: self.moves.len() });
    }

    /// Which way round the spindle turns from here on.
    pub(super) fn reverse(&mut self, is_reversed: bool) {
        if self.stated.is_reversed != is_reversed {
            Arc::make_mut(&mut self.stated).is_reversed = is_reversed;
        }
    }

    pub(super) fn finish(mut self, dialect: Dialect) -> Result<Program, Vec<Note>> {
        if self.notes.errors() == 0 && self.moves.is_empty() {
            let of = |code| self.notes.list().iter().find(move |note| note.code == code);
            let unread = of(Code::MotionLeftOut).or(of(Code::LeftOut));
            let first = unread.map(|note| (note.place.line.unwrap_or(1), note.what.clone()));
            let none = "the program contains no motion";
            match first {
                Some((line, why)) => {
                    self.error(Code::Motion, line, format!("{none} that is read: {why}"));
                }
                None => self.error(Code::Motion, 1, none),
            }
        }
        if let Some((line, what)) = self.away.take() {
            self.warning(Code::LeftOut, line, left_out(&what));
        }
        if let Some((count, first_line)) = self.rapid {
            let moves = if count == 1 {
                "a rapid move runs".to_owned()
            } else {
                format!("{count} rapid moves, of which this is the first, run")
            };
            let what = format!("{moves} at the assumed {} m/s", self.rapid_m_per_s);
            self.warning(Code::Assumed, first_line, what);
        }
        let Self { mut moves, spindle, words, feeds, mut notes, kinds, .. } = self;
        let ends = spindle.iter().skip(1).map(|next| next.from_move).chain([moves.len()]);
        let stops = spindle.iter().zip(ends).filter(|(at, _)| at.spindle == Spindle::Stands);
        for (stop, end) in stops {
            moves[stop.from_move..end].iter_mut().for_each(|each| each.spindle_turns = false);
        }
        if let Some((line, what)) = standing::feed_moves(&moves, &spindle, dialect) {
            notes.warning(Code::SpindleCommand, line, what);
        }
        let (errors, warnings) = notes.finish();
        if !errors.is_empty() {
            return Err(grouped(errors, &kinds));
        }
        Ok(Program { moves, spindle, feeds, warnings, words })
    }
}

/// Length of the straight or round way from a pose, m; the chords' where an arc's points are in
/// line. `None` where the way is not known.
fn way_m(from: &Isometry3<f64>, to: &Target) -> Option<f64> {
    let from = from.translation.vector;
    match to {
        Target::Joints(_) => None,
        Target::JointsTo(end) | Target::Line(end) => Some((end.translation.vector - from).norm()),
        Target::Arc { via, end, .. } => {
            let [via, end] = [via, end].map(|pose| pose.translation.vector);
            let chords = || (via - from).norm() + (end - via).norm();
            Some(Circle::through(from, via, end).map_or_else(chords, |circle| circle.length()))
        }
    }
}

/// By how much the tool turns from a pose, rad; on an arc that it goes with against that, and
/// nothing where the pose on the way tells which way round.
fn turn_rad(from: &Isometry3<f64>, to: &Target) -> f64 {
    /// What a pose on the way must be turned by to tell it, rad.
    const TELLS: f64 = 0.2;
    match to {
        Target::Joints(_) | Target::JointsTo(_) => 0.0,
        Target::Line(end) | Target::Arc { end, turning: Turning::ByWay | Turning::ToEnd, .. } => {
            from.rotation.angle_to(&end.rotation)
        }
        Target::Arc { via, end, turning: Turning::WithArc } => {
            let [a, b, c] = [from, via, end].map(|pose| pose.translation.vector);
            let Some(circle) = Circle::through(a, b, c) else { return 0.0 };
            let against = |u: f64, to: &Isometry3<f64>| {
                ((circle.turn(u) * from.rotation).inverse() * to.rotation).scaled_axis()
            };
            let (whole, half) = (against(1.0, end), against(circle.via_at(), via));
            let tells = half.dot(&whole).abs() > TELLS * whole.norm();
            if tells { 0.0 } else { whole.norm() }
        }
    }
}

fn is_finite(each: &Move) -> bool {
    let finite = |pose: &Isometry3<f64>| {
        pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite())
    };
    // Where the work is carried, numbers overflow on the way to the base frame.
    let pose = |pose: &Isometry3<f64>| {
        let ends = || [0.0, 1.0].iter().all(|&u| finite(&each.tip(u, pose)));
        finite(pose) && (each.work == Work::Stands || ends())
    };
    let timed = match each.timing {
        Timing::Feed | Timing::Rapid => true,
        Timing::Seconds(seconds) => seconds.is_finite(),
        Timing::Joints(share) => share.is_finite(),
    };
    timed
        && each.feed_m_per_s.is_finite()
        && finite(&each.tcp)
        && match &each.to {
            Target::Joints(joints) => joints.iter().all(|joint| joint.is_finite()),
            Target::JointsTo(end) | Target::Line(end) => pose(end),
            Target::Arc { via, end, .. } => pose(via) && pose(end),
        }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    use super::*;
    use crate::units::rad_from_deg;

    #[test]
    fn arcs_are_as_long_as_their_angle_says() {
        let point = |deg: f64| {
            let angle = rad_from_deg(deg);
            let at = Vector3::new(1.0 + 2.0 * angle.cos(), 2.0 * angle.sin(), 3.0);
            Isometry3::from_parts(Translation3::from(at), UnitQuaternion::identity())
        };
        for (via, end) in [(10.0, 30.0), (100.0, 190.0), (20.0, 300.0), (290.0, 350.0)] {
            let turning = Turning::default();
            let arc = Target::Arc { via: point(via), end: point(end), turning };
            let length = way_m(&point(0.0), &arc).unwrap();
            assert!((length - 2.0 * rad_from_deg(end)).abs() < 1e-12, "{via} {end} {length}");
        }
    }
}
