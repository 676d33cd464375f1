//! A path: where the joints are at every moment.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::Isometry3;

use super::curve::Curve;
use super::timing::{largest_step, stands_still};
use crate::model::{IkFault, InverseKinematics, JointKind, MovingJoint, PoseFault, Robot, Solver};
use crate::motion::{Configuration, Move, Work};
use crate::units::{deg_from_rad, mm_from_m};
use crate::wording::distinguishable;

/// A joint that would have to be faster than it can to keep the programmed speed. Shown as "joint
/// 'a' would have to turn at 412.0 deg/s, its velocity limit in the URDF is 175.0 deg/s".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointOverspeed<'a> {
    /// The joint.
    pub joint: &'a MovingJoint,
    /// Speed that it would need, rad/s or m/s.
    pub needed: f64,
    /// Its largest speed, rad/s or m/s.
    pub allowed: f64,
    /// Where.
    pub s: f64,
    /// Whether the tool centre point stands still there, so that no feed has a part in it.
    pub is_reorientation: bool,
}

impl JointOverspeed<'_> {
    fn factor(&self) -> f64 {
        self.needed / self.allowed
    }
}

impl fmt::Display for JointOverspeed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (verb, shown, unit): (_, fn(f64) -> f64, _) = match self.joint.kind {
            JointKind::Prismatic => ("slide", mm_from_m, "mm/s"),
            _ => ("turn", deg_from_rad, "deg/s"),
        };
        let [needed, allowed] = distinguishable(shown(self.needed), shown(self.allowed), 1);
        write!(
            f,
            "joint '{}' would have to {verb} at {needed} {unit}, its velocity limit in the URDF is \
             {allowed} {unit}",
            self.joint.name
        )
    }
}

/// Joint positions as start_near_deg has them.
pub(super) fn shown_joints(robot: &Robot, q: &[f64]) -> String {
    let shown = robot.joints().iter().zip(q).map(|(joint, &value)| {
        let value = match joint.kind {
            JointKind::Prismatic => mm_from_m(value),
            _ => deg_from_rad(value),
        };
        format!("{:.1}", (value * 10.0).round() / 10.0 + 0.0)
    });
    format!("[{}]", shown.collect::<Vec<_>>().join(", "))
}

/// How a move goes, as far as it says whether the tool may cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MoveKind {
    /// The tool centre point stands, whether or not the arm turns about it.
    #[default]
    Still,
    /// A rapid move of a program.
    Rapid,
    /// From one joint position to the next.
    Joints,
    /// Along a line or an arc.
    Led,
}

/// What is run between two waypoints.
#[derive(Debug, Clone)]
pub(super) struct Segment {
    /// Index of its move.
    pub(super) index: usize,
    /// `None`: straight in the joints.
    pub(super) curve: Option<Box<Curve>>,
    pub(super) tcp: Isometry3<f64>,
    pub(super) work: Work,
    pub(super) line: usize,
    /// As the move asks for it, or less where the turn of the tool or a time sets the pace.
    pub(super) feed_m_per_s: f64,
    pub(super) spindle_turns: bool,
    pub(super) start_s: f64,
    pub(super) end_s: f64,
    /// Its time, if no feed has a part in it, s.
    pub(super) standing_s: f64,
    pub(super) kind: MoveKind,
    /// Joints that the program places itself, straight from one end to the other.
    pub(super) held: Option<Arc<[bool]>>,
}

impl Segment {
    /// Nothing moves; the tool and the line are still wanted.
    pub(super) fn standing(at: &Move, index: usize) -> Self {
        Self {
            index,
            curve: None,
            tcp: at.tcp,
            work: at.work.ended(),
            line: at.line,
            feed_m_per_s: at.feed_m_per_s,
            spindle_turns: at.spindle_turns,
            start_s: 0.0,
            end_s: 0.0,
            standing_s: 0.0,
            kind: MoveKind::Still,
            held: None,
        }
    }
}

/// The path of one operation. s runs from 0 to 1 in proportion to time.
#[derive(Debug, Clone)]
pub struct Path<'a> {
    robot: &'a Robot,
    kinematics: InverseKinematics,
    duration_s: f64,
    /// Time in which no feed has a part, s.
    standing_s: f64,
    segments: Vec<Segment>,
    /// Where the path starts, if nearer joint positions that reach its first target do not lead
    /// along it.
    pub(super) found_start: Option<Vec<f64>>,
    /// Where others reach its first target, too, and the program says which in a way that cannot be
    /// compared: the line, what it says, and the joint positions.
    pub(super) open_start: Option<(usize, Arc<str>, String)>,
    /// Targets that are reached beside the arm configurations that the program asks for.
    pub(super) beside: Vec<Beside>,
    /// Moves that may end with another shoulder or elbow than they do here: index and line.
    pub(super) open_sides: Vec<(usize, usize, Arc<Configuration>)>,
    /// Moves to poses that leave the arm a choice: fewer joints fixed than there are.
    pub(super) choices: Vec<usize>,
    /// s of the knots, strictly ascending from 0 to 1; one knot where nothing moves.
    knots_s: Vec<f64>,
    /// Joint positions at the knots, one row after the other.
    knots_q: Vec<f64>,
    /// Segment between each knot and the next.
    segment_of: Vec<usize>,
}

impl<'a> Path<'a> {
    pub(super) fn assemble(
        robot: &'a Robot,
        kinematics: InverseKinematics,
        knots: Knots,
        mut segments: Vec<Segment>,
    ) -> Self {
        let Knots { time_s, q, segment_of } = knots;
        let duration_s = time_s.last().copied().unwrap_or(0.0);
        let share = |t: f64| if duration_s > 0.0 { (t / duration_s).min(1.0) } else { 0.0 };
        for segment in &mut segments {
            segment.start_s = share(segment.start_s);
            segment.end_s = share(segment.end_s);
        }
        let standing_s = segments.iter().map(|segment| segment.standing_s).sum();
        let knots_s = time_s.iter().map(|&t| share(t)).collect();
        Self {
            robot,
            kinematics,
            duration_s,
            standing_s,
            segments,
            found_start: None,
            open_start: None,
            beside: Vec::new(),
            open_sides: Vec::new(),
            choices: Vec::new(),
            knots_s,
            knots_q: q,
            segment_of,
        }
    }

    /// The part of the path that the moves of `stretch` run, from where the move before ends, with
    /// the joints exactly as they are on the whole; `robot` stands like the path's own and may
    /// carry something else. `moves` are those that the path was planned from.
    pub fn stretch<'b>(&self, moves: &[Move], stretch: Range<usize>, robot: &'b Robot) -> Path<'b> {
        let n = self.robot.joints().len();
        let stretch_start = stretch.start;
        let beside = self.beside.iter().filter(|target| stretch.contains(&target.index));
        let beside = beside.cloned().collect();
        let open_sides = self.open_sides.iter().filter(|(index, ..)| stretch.contains(index));
        let open_sides = open_sides.cloned().collect();
        // A stretch starts where the move before ends.
        let from = stretch.start.saturating_sub(1);
        let chosen = self.choices.iter().copied();
        let choices = chosen.filter(|index| (from..stretch.end).contains(index)).collect();
        let first = self.segments.partition_point(|segment| segment.index < stretch.start);
        let behind = self.segments.partition_point(|segment| segment.index < stretch.end);
        let segments = self.segments.get(first..behind).unwrap_or_default();
        let knot = self.segment_of.partition_point(|&of| of < first);
        let last = self.segment_of.partition_point(|&of| of < behind);
        let time_s = |k: usize| (self.knots_s[k] - self.knots_s[knot]) * self.duration_s;
        let mut knots = Knots {
            time_s: (knot..=last).map(time_s).collect(),
            q: self.knots_q[knot * n..(last + 1) * n].to_vec(),
            segment_of: self.segment_of[knot..last].iter().map(|&of| of - first).collect(),
        };
        let mut own: Vec<Segment> = segments.to_vec();
        for segment in &mut own {
            segment.start_s = (segment.start_s - self.knots_s[knot]) * self.duration_s;
            segment.end_s = (segment.end_s - self.knots_s[knot]) * self.duration_s;
        }
        if own.iter().all(|segment| segment.end_s <= segment.start_s) {
            let last = moves.get(stretch).and_then(<[Move]>::last);
            knots = Knots { time_s: vec![0.0], q: knots.q[..n].to_vec(), segment_of: Vec::new() };
            own = last.map(|at| Segment::standing(at, own.len())).into_iter().collect();
        }
        let found_start = self.found_start.clone().filter(|_| stretch_start == 0);
        let open_start = self.open_start.clone().filter(|_| stretch_start == 0);
        Path {
            found_start,
            open_start,
            beside,
            open_sides,
            choices,
            ..Path::assemble(robot, self.kinematics.clone(), knots, own)
        }
    }

    /// Whether a pose leaves the arm a choice, as of seven joints: it moves them least then.
    pub fn leaves_choice(&self) -> bool {
        !self.choices.is_empty()
    }

    /// The first target that is reached only beside the arm configuration that its program asks
    /// for: its line, and what was asked for and found; and how many more there are.
    pub fn beside_configuration(&self) -> Option<(usize, &str, usize)> {
        let (first, others) = self.beside.split_first()?;
        Some((first.line, &first.what, others.len()))
    }

    /// The line of the first of these targets that several joint positions reach about as near to
    /// the arm configuration.
    pub fn open_configuration(&self) -> Option<usize> {
        self.beside.iter().find(|target| target.is_open).map(|target| target.line)
    }

    /// The line of the first joint move of which it is not known with which shoulder and elbow it
    /// ends, and the arm configuration that the program asks for there: no target before has told
    /// what that means, and the nearest joint positions have another shoulder or elbow than it
    /// seems to say (on an arm without a spherical wrist: others are about as near).
    pub fn open_sides(&self) -> Option<(usize, &str)> {
        self.open_sides.first().map(|(_, line, asked)| (*line, &*asked.shown))
    }

    /// Whether the controller takes no joint positions beside what is asked for at any of these
    /// targets, as where a program states the sign of an axis, not a quadrant.
    pub fn misses_configuration(&self) -> bool {
        self.beside.iter().any(|target| target.is_missed)
    }

    /// The joint positions where the path starts, as start_near_deg has them, if nobody asked for
    /// them and nearer ones reach the first target, too, but do not lead along the path.
    pub fn found_start(&self) -> Option<String> {
        self.found_start.as_ref().map(|start| shown_joints(self.robot, start))
    }

    /// Where nobody asked for joint positions at the start and others reach the first target, too:
    /// its line, what the program says of them that cannot be compared, and those that are taken,
    /// as start_near_deg has them.
    pub fn open_start(&self) -> Option<(usize, &str, &str)> {
        self.open_start.as_ref().map(|(line, said, start)| (*line, &**said, &**start))
    }

    /// The robot that runs the path.
    pub fn robot(&self) -> &'a Robot {
        self.robot
    }

    /// Time from s = 0 to s = 1, s; zero where nothing moves.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Time that does not depend on the feed, s: the tool centre point stands still, or the program
    /// gives the time.
    pub fn standing_s(&self) -> f64 {
        self.standing_s
    }

    /// s of the waypoints and, on lines and arcs, of the knots between them; ascending. Between two
    /// of them joints move smoothly.
    pub fn knots_s(&self) -> &[f64] {
        &self.knots_s
    }

    /// Largest change of any joint (rad or m) between knot `k` and the next.
    pub(super) fn step_after(&self, k: usize) -> f64 {
        let n = self.robot.joints().len();
        if k + 1 >= self.knots_s.len() {
            return 0.0;
        }
        largest_step(&self.knots_q[k * n..][..n], &self.knots_q[(k + 1) * n..][..n])
    }

    /// Line of the file that is run at `s`, counted from 1. At a waypoint, the line that leads to
    /// it.
    pub fn line_at(&self, s: f64) -> usize {
        self.segment_at(s).map_or(0, |segment| segment.line)
    }

    /// Feed of the move run at `s`, m/s: what it asks for, or less where the turn of the tool or a
    /// time sets the pace. At a waypoint, that of the move that leads to it.
    pub fn feed_m_per_s_at(&self, s: f64) -> f64 {
        self.segment_at(s).map_or(0.0, |segment| segment.feed_m_per_s)
    }

    /// How the move run at `s` goes. At a waypoint, the move that leads to it.
    pub fn kind_at(&self, s: f64) -> MoveKind {
        self.segment_at(s).map_or(MoveKind::Still, |segment| segment.kind)
    }

    /// The work and the tool of the move run at `s`, and the share of it behind which a place lies.
    /// At a waypoint, those of the move that leads to it.
    pub(super) fn led_at(&self, s: f64) -> Option<(&Work, &Isometry3<f64>, impl Fn(f64) -> f64)> {
        let segment = self.segment_at(s)?;
        let share = |at: f64| {
            let share = (at - segment.start_s) / (segment.end_s - segment.start_s);
            if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 }
        };
        Some((&segment.work, &segment.tcp, share))
    }

    fn segment_at(&self, s: f64) -> Option<&Segment> {
        let after = self.segments.partition_point(|segment| segment.end_s < s);
        self.segments.get(after).or(self.segments.last())
    }

    /// First and last line of the file among those that are run between `from_s` and `to_s`,
    /// counted from 1. A program that calls procedures does not run its lines in order.
    pub fn lines_between(&self, from_s: f64, to_s: f64) -> (usize, usize) {
        let first = self.segments.partition_point(|segment| segment.end_s <= from_s);
        let behind = self.segments.partition_point(|segment| segment.start_s < to_s);
        let run = self.segments.get(first..behind).unwrap_or_default().iter().map(|s| s.line);
        let bounds = run.fold(None, |bounds, line| match bounds {
            None => Some((line, line)),
            Some((low, high)) => Some((line.min(low), line.max(high))),
        });
        bounds.unwrap_or_else(|| (self.line_at(from_s), self.line_at(from_s)))
    }

    /// Each move that takes time, in the order in which they run: its index, and s at its start and
    /// end.
    pub fn moves_run(&self) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        let own = self.segments.iter().filter(|segment| segment.end_s > segment.start_s);
        own.map(|segment| (segment.index, [segment.start_s, segment.end_s]))
    }

    /// Whether the spindle turns anywhere on the path.
    pub fn spindle_turns(&self) -> bool {
        self.segments.iter().any(|segment| segment.spindle_turns)
    }

    /// Stretches of s on which the spindle stands still, ascending and apart from one another.
    pub fn spindle_stops(&self) -> Vec<[f64; 2]> {
        let mut stops: Vec<[f64; 2]> = Vec::new();
        for segment in self.segments.iter().filter(|segment| !segment.spindle_turns) {
            match stops.last_mut() {
                Some(last) if last[1] == segment.start_s => last[1] = segment.end_s,
                _ => stops.push([segment.start_s, segment.end_s]),
            }
        }
        stops
    }

    /// Where a joint would have to be faster than it can, by the largest factor; `None` where none
    /// would. Between two knots the mean speed counts.
    pub fn worst_joint_overspeed(&self) -> Option<JointOverspeed<'a>> {
        let mut worst: Option<JointOverspeed<'a>> = None;
        let n = self.robot.joints().len();
        for (k, knots) in self.knots_s.windows(2).enumerate() {
            let seconds = (knots[1] - knots[0]) * self.duration_s;
            let row = |k: usize| &self.knots_q[k * n..][..n];
            let segment = self.segment_of.get(k).and_then(|&i| self.segments.get(i));
            let curve = segment.and_then(|segment| segment.curve.as_ref());
            let is_reorientation = curve.is_some_and(|curve| stands_still(curve.length_m()));
            for (joint, (a, b)) in self.robot.joints().iter().zip(row(k).iter().zip(row(k + 1))) {
                let Some(allowed) = joint.velocity_limit else { continue };
                let needed = (b - a).abs() / seconds;
                let factor = needed / allowed;
                // A joint at its limit of speed is not beyond it: rounding.
                if factor > worst.as_ref().map_or(1.0 + 1e-6, JointOverspeed::factor) {
                    worst = Some(JointOverspeed {
                        joint,
                        needed,
                        allowed,
                        s: knots[1],
                        is_reorientation,
                    });
                }
            }
        }
        worst
    }

    /// Something that reads the path at any s.
    pub fn reader(&self) -> PathReader<'_, 'a> {
        let solver = self.kinematics.solver(self.robot);
        PathReader { path: self, guess: vec![0.0; self.robot.joints().len()], solver }
    }
}

/// Reads a path, point by point.
#[derive(Debug, Clone)]
pub struct PathReader<'p, 'a> {
    path: &'p Path<'a>,
    guess: Vec<f64>,
    solver: Solver<'p>,
}

impl PathReader<'_, '_> {
    /// Joint positions at `s` in 0..=1 (rad or m, one per moving joint) into `q`, and the tool
    /// centre point in the tip frame.
    ///
    /// # Errors
    /// `q` has another length, or a line or arc cannot be followed between two knots.
    pub fn at(&mut self, s: f64, q: &mut [f64]) -> Result<Isometry3<f64>, IkFault> {
        let path = self.path;
        let n = path.robot.joints().len();
        if q.len() != n {
            return Err(IkFault::Seed(PoseFault::Length { given: q.len(), expected: n }));
        }
        let row = |k: usize| &path.knots_q[k * n..][..n];
        let after = path.knots_s.partition_point(|&knot| knot <= s);
        let k = after.saturating_sub(1);
        let Some(segment) = path.segment_of.get(k).and_then(|&i| path.segments.get(i)) else {
            // At or behind the last knot.
            q.copy_from_slice(row(path.knots_s.len() - 1));
            let last = path.segments.last();
            return Ok(last.map_or_else(Isometry3::identity, |last| self.tool_in_tip(last, q)));
        };
        let u = (s - path.knots_s[k]) / (path.knots_s[k + 1] - path.knots_s[k]);
        for (value, (a, b)) in q.iter_mut().zip(row(k).iter().zip(row(k + 1))) {
            *value = a + (b - a) * u;
        }
        if let Some(curve) = &segment.curve {
            let u = (s - segment.start_s) / (segment.end_s - segment.start_s);
            let tip = segment.work.tip(u, &curve.at(u), &segment.tcp);
            self.guess.copy_from_slice(q);
            let solved = match &segment.held {
                Some(held) => path.kinematics.near_holding(path.robot, &tip, &self.guess, held),
                None => self.solver.near(&tip, &self.guess),
            };
            q.copy_from_slice(&solved?);
        }
        Ok(self.tool_in_tip(segment, q))
    }

    /// The tool centre point in the tip frame.
    fn tool_in_tip(&mut self, segment: &Segment, q: &[f64]) -> Isometry3<f64> {
        match segment.work {
            Work::Held => self.solver.tip(q).inverse() * segment.tcp,
            Work::Stands | Work::Moves(_) => segment.tcp,
        }
    }
}

/// A target that is reached in no joint positions of the arm configuration that its program asks
/// for, but in some beside it.
#[derive(Debug, Clone)]
pub(super) struct Beside {
    /// Index of its move.
    pub(super) index: usize,
    pub(super) line: usize,
    /// What was asked for, and the joint positions.
    pub(super) what: String,
    /// Whether others are about as near.
    pub(super) is_open: bool,
    /// Whether the controller takes none beside it.
    pub(super) is_missed: bool,
}

/// Knots as they are found, over time.
pub(super) struct Knots {
    pub(super) time_s: Vec<f64>,
    pub(super) q: Vec<f64>,
    pub(super) segment_of: Vec<usize>,
}

impl Knots {
    /// Room for so many more, of so many joints each.
    pub(super) fn reserve(&mut self, more: usize, joints: usize) {
        self.time_s.reserve(more);
        self.q.reserve(more * joints);
        self.segment_of.reserve(more);
    }
}
