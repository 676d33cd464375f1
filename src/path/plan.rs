//! Moves → a path, as the controller interpolates them.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Isometry3;

use super::configuration::{KnownSides, beside_configurations, compared, configured};
use super::curve::Curve;
use super::timed_path::{Knots, MoveKind, Path, Segment, shown_joints};
use super::timing::{Clock, is_of_feed, largest_step, seconds, stands_still};
use crate::model::{InverseKinematics, Robot, Solver};
use crate::motion::{Configuration, Move, Target, Timing};
use crate::notes::{Code, Note, Part, Place};
use crate::units::percent_from_ratio;

/// Between two knots of a line or arc no joint moves more than this (rad or m), so that the
/// solution of one is a good start for the other.
const MAX_KNOT_STEP: f64 = 0.035;

/// The shortest stretch of a line or arc, as a share of it, that is tried where the joints race:
/// beyond it the arm passes a singularity.
const MIN_STRETCH: f64 = 1e-6;

/// A line or arc longer than this is a slip of the pen, m.
const MAX_CURVE_M: f64 = 1e5;

/// Below this smallest singular value of the Jacobian (lengths over the arm's reach) the arm is
/// singular.
const MIN_SINGULAR_VALUE: f64 = 1e-3;

/// The most that a joint may move in one move and in a path, rad or m: a hundred turns, and a day
/// of milling. More is a slip of the pen, and would be looked at degree by degree.
const MAX_MOVE: f64 = 628.0;
const MAX_PATH: f64 = 200_000.0;

/// Why a move cannot be run.
pub(super) type Refusal = (Code, String);

/// An error at a waypoint (counted from 0), with the line that asks for it.
fn at_waypoint(index: usize, a_move: &Move, (code, what): Refusal) -> Note {
    let place = Place { line: Some(a_move.line), ..Place::part(Part::Waypoint(index)) };
    Note::error(code, place, what)
}

impl<'a> Path<'a> {
    /// Plans `moves`, the first of which is where the operation starts. Where it starts at a pose,
    /// that arm configuration is taken that is nearest to `start_near`; without it, the one nearest
    /// to zero from which the whole path can be run.
    ///
    /// # Errors
    /// Every waypoint that is wrong in itself (number of joints, limits), else the first move that
    /// cannot be run (out of reach, over a limit or through a singularity), and behind it the first
    /// few waypoints that are out of reach, with the number of the others.
    pub fn plan(
        robot: &'a Robot,
        moves: &[Move],
        start_near: Option<&[f64]>,
    ) -> Result<Self, Vec<Note>> {
        let errors = joint_target_errors(robot, moves);
        if !errors.is_empty() {
            return Err(errors);
        }
        let Some(first) = moves.first() else {
            return Err(vec![Note::error(Code::Value, Place::default(), "the path is empty")]);
        };
        let kinematics = InverseKinematics::new(robot);
        let mut furthest: Option<(usize, Refusal)> = None;
        let all_of = |(index, refusal): (usize, Refusal)| {
            with_those_behind(robot, &kinematics, moves, index, refusal)
        };
        let starts = starts(robot, &kinematics, first, start_near);
        let starts = starts.map_err(|refusal| all_of((0, refusal)))?;
        for (rank, start) in starts.iter().enumerate() {
            match Planner::new(robot, &kinematics, start).run(moves) {
                Ok(planned) if rank == 0 || start_near.is_none() => {
                    let Planner { knots, segments, open_sides, .. } = planned;
                    let beside =
                        beside_configurations(robot, &kinematics, moves, &knots, &segments);
                    let found_start = (rank > 0).then(|| start.clone());
                    let said = said_of_start(moves).filter(|_| start_near.is_none());
                    let open_start = said
                        .filter(|_| has_other_arm(&starts, start))
                        .map(|(line, said)| (line, said, shown_joints(robot, start)));
                    let mut path = Self::assemble(robot, kinematics, knots, segments);
                    (path.found_start, path.beside) = (found_start, beside);
                    (path.open_start, path.open_sides) = (open_start, open_sides);
                    let choices = moves.iter().enumerate();
                    let choices = choices.filter(|(_, a_move)| leaves_choice(robot, a_move));
                    path.choices = choices.map(|(index, _)| index).collect();
                    return Ok(path);
                }
                // What was asked for is kept or refused.
                Ok(_) => {
                    if let Some((_, (_, what))) = &mut furthest {
                        what.push_str(&format!(
                            "; that is from start_near_deg, and from {} the whole path can be run",
                            shown_joints(robot, start)
                        ));
                    }
                    break;
                }
                Err(refused) => {
                    let is_of_start = rank == 0 || start_near.is_none();
                    if is_of_start && furthest.as_ref().is_none_or(|f| refused.0 > f.0) {
                        furthest = Some(refused);
                    }
                }
            }
        }
        Err(furthest.map_or_else(Vec::new, all_of))
    }
}

/// What the program says of the arm configuration at the start that is not compared with joint
/// positions, and its line: there, or, where the first move has none, at the first target that has
/// one and is reached in the configuration of the start.
fn said_of_start(moves: &[Move]) -> Option<(usize, Arc<str>)> {
    let first = moves.first()?;
    if let Some(said) = &first.stated.uncompared {
        return Some((first.line, Arc::clone(said)));
    }
    if first.stated.configuration.is_some() {
        return None;
    }
    let keeps = |next: &&Move| matches!(next.to, Target::Line(_) | Target::Arc { .. });
    let later = moves.iter().skip(1).take_while(keeps);
    later.filter_map(|a_move| Some((a_move, a_move.stated.configuration.as_ref()?))).find_map(
        |(a_move, asked)| asked.sides.is_some().then(|| (a_move.line, asked.shown.as_str().into())),
    )
}

/// Whether others of the joint positions at which a path may start have the arm elsewhere. A wrist
/// that is turned over alone, the last three joints, moves next to no mass.
fn has_other_arm(starts: &[Vec<f64>], start: &[f64]) -> bool {
    /// Positions that are no nearer to each other are others, rad.
    const OTHER: f64 = 0.1;
    const WRIST: usize = 3;
    let arm = start.len().saturating_sub(WRIST);
    let is_other = |(a, b): (&f64, &f64)| {
        let by = (a - b).rem_euclid(TAU);
        by.min(TAU - by) > OTHER
    };
    starts.iter().any(|other| other.iter().zip(start).take(arm).any(is_other))
}

/// Whether a move ends at a pose that fixes fewer joints than are free there.
fn leaves_choice(robot: &Robot, a_move: &Move) -> bool {
    /// Of position and orientation.
    const FIXED: usize = 6;
    let placed = a_move.stated.external.len();
    !matches!(a_move.to, Target::Joints(_)) && robot.joints().len() > FIXED + placed
}

/// The joints that a move's program places itself, marked, and their positions at its end.
fn held_by(robot: &Robot, a_move: &Move) -> Option<Arc<[bool]>> {
    let external = &a_move.stated.external;
    let mut held = vec![false; robot.joints().len()];
    for (joint, _) in external {
        *held.get_mut(*joint)? = true;
    }
    (!external.is_empty()).then(|| held.into())
}

/// Puts the joints that the program places to where a share of the move's way has them.
fn place_held(q: &mut [f64], from: &[f64], a_move: &Move, share: f64) {
    for &(joint, to) in &a_move.stated.external {
        if let (Some(q), Some(from)) = (q.get_mut(joint), from.get(joint)) {
            *q = from + (to - from) * share;
        }
    }
}

/// Joint targets with the wrong number of joints, with numbers that are not finite, or outside
/// limits; and joint positions for the end of a line or an arc that are outside them.
fn joint_target_errors(robot: &Robot, moves: &[Move]) -> Vec<Note> {
    let mut errors = Vec::new();
    for (index, a_move) in moves.iter().enumerate() {
        let mut error = |code, what| errors.push(at_waypoint(index, a_move, (code, what)));
        let Target::Joints(q) = &a_move.to else {
            let asked = a_move.stated.configuration.iter().flat_map(|asked| &asked.joints);
            for (joint, [lowest, highest]) in asked {
                let joint = robot.joints().get(*joint).filter(|_| lowest == highest);
                let over = joint.and_then(|joint| joint.violation(*lowest));
                over.into_iter().for_each(|over| error(Code::JointLimit, over.to_string()));
            }
            continue;
        };
        match robot.check_pose(q) {
            Err(fault) => error(Code::Value, fault.to_string()),
            Ok(()) => {
                let violations = robot.limit_violations(q);
                violations.for_each(|over| error(Code::JointLimit, over.to_string()));
            }
        }
    }
    errors
}

/// Joint positions at which the operation may start, the best first.
fn starts(
    robot: &Robot,
    kinematics: &InverseKinematics,
    first: &Move,
    near: Option<&[f64]>,
) -> Result<Vec<Vec<f64>>, Refusal> {
    let pose = match &first.to {
        Target::Joints(q) => return Ok(vec![q.clone()]),
        Target::JointsTo(pose) | Target::Line(pose) | Target::Arc { end: pose, .. } => pose,
    };
    let zero = vec![0.0; robot.joints().len()];
    let near = near.unwrap_or(&zero);
    let tip = first.tip(1.0, pose);
    let found = match held_by(robot, first) {
        Some(held) => {
            let mut seed = near.to_vec();
            place_held(&mut seed, near, first, 1.0);
            kinematics.solutions_holding(robot, &tip, &seed, &held)
        }
        None => kinematics.solutions_near(robot, &tip, near),
    };
    if found.is_empty() {
        return Err(unreachable(robot, kinematics, &tip, near));
    }
    configured(robot, kinematics, first, &KnownSides::default(), found)
}

/// What stops the arm at waypoint `index`, with the later waypoints that are out of reach in
/// themselves: the first few, and how many more.
fn with_those_behind(
    robot: &Robot,
    kinematics: &InverseKinematics,
    moves: &[Move],
    index: usize,
    refusal: Refusal,
) -> Vec<Note> {
    /// Errors that are listed one by one.
    const MAX_LISTED: usize = 5;
    /// Waypoints that are tried: each costs a search.
    const MAX_TRIED: usize = 500;
    let near = vec![0.0; robot.joints().len()];
    let behind = moves.iter().enumerate().skip(index + 1);
    let mut unreached = behind.take(MAX_TRIED).filter_map(|(index, next)| {
        let (Target::JointsTo(pose) | Target::Line(pose) | Target::Arc { end: pose, .. }) =
            &next.to
        else {
            return None;
        };
        let tip = next.tip(1.0, pose);
        kinematics.solutions(robot, &tip).is_empty().then_some((index, next, tip))
    });
    let is_long = moves.len() > index + 1 + MAX_TRIED;
    let mut errors: Vec<Note> =
        moves.get(index).map(|at| at_waypoint(index, at, refusal)).into_iter().collect();
    errors.extend(unreached.by_ref().take(MAX_LISTED - 1).map(|(index, next, tip)| {
        at_waypoint(index, next, unreachable(robot, kinematics, &tip, &near))
    }));
    let more = unreached.count();
    if let (true, Some(last)) = (more > 0, errors.last_mut()) {
        let among = if is_long { format!(" of the next {MAX_TRIED}") } else { String::new() };
        last.what.push_str(&format!("; and {more} more waypoints{among} are out of reach"));
    }
    errors
}

/// Why no joint positions reach a pose, in words.
fn unreachable(
    robot: &Robot,
    kinematics: &InverseKinematics,
    tip: &Isometry3<f64>,
    near: &[f64],
) -> Refusal {
    let what = match kinematics.near(robot, tip, near) {
        Err(fault) => fault.to_string(),
        Ok(_) => "no joint positions within the limits reach the pose".to_owned(),
    };
    (Code::Unreachable, what)
}

struct Planner<'r> {
    robot: &'r Robot,
    kinematics: &'r InverseKinematics,
    solver: Solver<'r>,
    clock: Clock<'r>,
    q: Vec<f64>,
    /// Joint positions where the last line or arc ended, and on which side of the singularities.
    side_at: Option<(Vec<f64>, Option<bool>)>,
    sides: KnownSides,
    /// See [`Path::open_sides`].
    open_sides: Vec<(usize, usize, Arc<Configuration>)>,
    knots: Knots,
    segments: Vec<Segment>,
    /// What the fastest joint of each move turns or slides, summed up.
    way_in_all: f64,
    /// Index of the move that is planned.
    index: usize,
    /// Its time, if no feed has a part in it, s.
    standing_s: f64,
    kind: MoveKind,
}

impl<'r> Planner<'r> {
    fn new(robot: &'r Robot, kinematics: &'r InverseKinematics, start: &[f64]) -> Self {
        Self {
            robot,
            kinematics,
            solver: kinematics.solver(robot),
            clock: Clock::new(robot),
            q: start.to_vec(),
            side_at: None,
            sides: KnownSides::default(),
            open_sides: Vec::new(),
            knots: Knots { time_s: vec![0.0], q: start.to_vec(), segment_of: Vec::new() },
            segments: Vec::new(),
            way_in_all: 0.0,
            index: 0,
            standing_s: 0.0,
            kind: MoveKind::Still,
        }
    }

    /// Runs all moves; an error comes with the waypoint, counted from 0.
    fn run(mut self, moves: &[Move]) -> Result<Self, (usize, Refusal)> {
        // Most moves have one knot.
        self.segments.reserve(moves.len());
        self.knots.reserve(moves.len(), self.q.len());
        moves.iter().take(1).for_each(|first| self.sides.note(self.kinematics, first, &self.q));
        for (index, next) in moves.iter().enumerate().skip(1) {
            self.index = index;
            self.extend(next).map_err(|refusal| (index, refusal))?;
            self.sides.note(self.kinematics, next, &self.q);
        }
        if self.segments.is_empty()
            && let Some(last) = moves.last()
        {
            self.segments.push(Segment::standing(last, self.index));
        }
        Ok(self)
    }

    /// One more move from where the arm stands.
    fn extend(&mut self, next: &Move) -> Result<(), Refusal> {
        self.count_way(&[next.work.largest_step()])?;
        match &next.to {
            Target::Joints(q) => self.join(next, q.clone()),
            Target::JointsTo(pose) => {
                let tip = next.tip(1.0, pose);
                let solutions = match held_by(self.robot, next) {
                    Some(held) => {
                        let mut seed = self.q.clone();
                        place_held(&mut seed, &self.q, next, 1.0);
                        self.kinematics.solutions_holding(self.robot, &tip, &seed, &held)
                    }
                    None => self.kinematics.solutions_near(self.robot, &tip, &self.q),
                };
                if solutions.is_empty() {
                    return Err(unreachable(self.robot, self.kinematics, &tip, &self.q));
                }
                let (robot, kinematics) = (self.robot, self.kinematics);
                let found = configured(robot, kinematics, next, &self.sides, solutions)?;
                if let (Some(asked), true) = (
                    &next.stated.configuration,
                    self.sides.are_open(kinematics, next, &self.q, &found),
                ) {
                    self.open_sides.push((self.index, next.line, Arc::clone(asked)));
                }
                match found.into_iter().next() {
                    Some(q) => self.join(next, q),
                    None => Ok(()),
                }
            }
            Target::Line(pose) => {
                let curve = Curve::line(next.start(&self.solver.tip(&self.q)), *pose);
                self.follow(next, curve)
            }
            Target::Arc { via, end, turning } => {
                let from = next.start(&self.solver.tip(&self.q));
                let curve = Curve::arc(from, *via, *end, *turning).ok_or_else(|| {
                    (Code::Motion, "the three points of the arc lie on one line".to_owned())
                })?;
                self.follow(next, curve)
            }
        }
    }

    /// A move that is straight in the joints.
    fn join(&mut self, next: &Move, to: Vec<f64>) -> Result<(), Refusal> {
        let ways: Vec<f64> = self.q.iter().zip(&to).map(|(a, b)| (b - a).abs()).collect();
        self.count_way(&ways)?;
        let (length, turn) = self.clock.joint_move_ways(next, &self.q, &to);
        let duration = self.seconds(length, turn, next, &ways)?;
        self.push(next, None, (length, duration), vec![(1.0, to)]);
        Ok(())
    }

    /// A move that is straight or round in the tool centre point.
    fn follow(&mut self, next: &Move, curve: Curve) -> Result<(), Refusal> {
        let tip = next.tip(1.0, &curve.at(1.0));
        self.trace(next, curve).map_err(|on_the_way| {
            // A target out of reach is the better word for what stops the arm on the way to it.
            let solutions = self.kinematics.solutions_near(self.robot, &tip, &self.q);
            if solutions.is_empty() {
                unreachable(self.robot, self.kinematics, &tip, &self.q)
            } else {
                on_the_way
            }
        })
    }

    fn trace(&mut self, next: &Move, curve: Curve) -> Result<(), Refusal> {
        let length = curve.length_m();
        if !(0.0..=MAX_CURVE_M).contains(&length) {
            let what =
                format!("is {length:.3e} m long, beyond the reach of any arm; check the units");
            return Err((Code::TooLong, what));
        }
        let mut knots: Vec<(f64, Vec<f64>)> = Vec::new();
        let mut ways = vec![0.0; self.q.len()];
        let mut u = 0.0;
        // The first stretch is 20 mm; it doubles while the joints keep up.
        let mut stretch = (0.02 / length).min(1.0);
        let mut q = self.q.clone();
        let held = held_by(self.robot, next);
        let mut side = match &self.side_at {
            Some((at, side)) if *at == q => *side,
            _ => self.singular_joints(&q, None).1,
        };
        while u < 1.0 {
            let end = if u + stretch > 1.0 - MIN_STRETCH { 1.0 } else { u + stretch };
            let tip = next.tip(end, &curve.at(end));
            let step = match &held {
                Some(held) => {
                    let mut seed = q.clone();
                    place_held(&mut seed, &self.q, next, end);
                    self.kinematics.near_holding(self.robot, &tip, &seed, held)
                }
                None => self.solver.near(&tip, &q),
            };
            // Work that turns once round is where it was.
            let carried = next.work.largest_step() * (end - u);
            let near = carried <= MAX_KNOT_STEP
                && matches!(&step, Ok(solved) if largest_step(&q, solved) <= MAX_KNOT_STEP);
            if !near && stretch > MIN_STRETCH {
                stretch *= 0.5;
                continue;
            }
            let passed = || format!("{:.1} % of the way", percent_from_ratio(end));
            let solved = match step {
                Ok(solved) if near => solved,
                Ok(_) => {
                    return Err((Code::Unreachable, format!("passes a singularity {}", passed())));
                }
                Err(fault) => return Err((Code::Unreachable, format!("{fault}, {}", passed()))),
            };
            let (singular, now) = self.singular_joints(&solved, side);
            side = now;
            if let Some(joints) = singular {
                let what = format!(
                    "passes a singularity {} ({joints}); move the work object, turn the tool about \
                     its axis or use joint waypoints there",
                    passed()
                );
                return Err((Code::Unreachable, what));
            }
            for (way, (a, b)) in ways.iter_mut().zip(q.iter().zip(&solved)) {
                *way += (b - a).abs();
            }
            q.clone_from(&solved);
            knots.push((end, solved));
            u = end;
            stretch *= 2.0;
        }
        compared(self.robot, next, &q)?;
        self.side_at = Some((q, side));
        self.count_way(&ways)?;
        let duration = self.seconds(length, curve.turn_rad(), next, &ways)?;
        self.push(next, Some(curve), (length, duration), knots);
        Ok(())
    }

    /// The joints whose motions cancel each other at `q`, in words, if the arm is singular there or
    /// has passed such a place since it was on side `before`; and the side that it is on now.
    fn singular_joints(
        &mut self,
        q: &[f64],
        before: Option<bool>,
    ) -> (Option<String>, Option<bool>) {
        let regular = self.solver.side_if_regular(q, MIN_SINGULAR_VALUE);
        if regular.is_some() && (before.is_none() || before == regular) {
            return (None, regular);
        }
        let Ok(singularity) = self.kinematics.singularity(self.robot, q) else {
            return (None, None);
        };
        let side = singularity.is_right_handed;
        let passed = before.is_some() && side.is_some() && before != side;
        let words =
            (passed || singularity.smallest_singular_value < MIN_SINGULAR_VALUE).then(|| {
                let names: Vec<&str> = singularity
                    .joints
                    .iter()
                    .map(|&joint| self.robot.joints()[joint].name.as_str())
                    .collect();
                format!("{} cancel each other", names.join(" and "))
            });
        (words, side)
    }

    /// Counts what the fastest joint moves; checked before anything is computed along a way that is
    /// a slip of the pen.
    fn count_way(&mut self, ways: &[f64]) -> Result<(), Refusal> {
        let most = ways.iter().copied().fold(0.0, f64::max);
        self.way_in_all += most;
        if most > MAX_MOVE || self.way_in_all > MAX_PATH {
            let what = format!(
                "the joints move by {most:.4e} rad or m; one move may have {MAX_MOVE}, a path \
                 {MAX_PATH}"
            );
            return Err((Code::TooLong, what));
        }
        Ok(())
    }

    fn seconds(
        &mut self,
        length_m: f64,
        turn_rad: f64,
        next: &Move,
        ways: &[f64],
    ) -> Result<f64, Refusal> {
        let seconds = self.time_of(length_m, turn_rad, next, ways)?;
        self.standing_s = if is_of_feed(length_m, turn_rad, next) { 0.0 } else { seconds };
        self.kind = match next.timing {
            _ if stands_still(length_m) => MoveKind::Still,
            Timing::Rapid => MoveKind::Rapid,
            Timing::Feed | Timing::Seconds(_) | Timing::Joints(_) => match next.to {
                Target::Line(_) | Target::Arc { .. } => MoveKind::Led,
                Target::Joints(_) | Target::JointsTo(_) => MoveKind::Joints,
            },
        };
        let total = self.knots.time_s.last().copied().unwrap_or(0.0) + seconds;
        if total.is_finite() {
            Ok(seconds)
        } else {
            let what = format!("takes {seconds} s, more than can be counted; check feed and tcp");
            Err((Code::TooLong, what))
        }
    }

    fn time_of(
        &self,
        length_m: f64,
        turn_rad: f64,
        next: &Move,
        ways: &[f64],
    ) -> Result<f64, Refusal> {
        seconds(self.robot, length_m, turn_rad, next, ways).map_err(|joint| {
            let what = format!(
                "the tool centre point stands still, and joint '{}' has no velocity limit in the \
                 URDF (zero counts as none), so its motion has no duration; add the limit",
                self.robot.joints()[joint].name
            );
            (Code::MissingKey, what)
        })
    }

    /// Adds a segment with its knots (u of the segment, joint positions). One that takes no time,
    /// and so moves nothing, leaves no trace.
    fn push(
        &mut self,
        next: &Move,
        curve: Option<Curve>,
        (length_m, duration_s): (f64, f64),
        knots: Vec<(f64, Vec<f64>)>,
    ) {
        let start_s = self.knots.time_s.last().copied().unwrap_or(0.0);
        let end_s = start_s + duration_s;
        if end_s <= start_s {
            return;
        }
        for (u, q) in knots {
            let time = if u < 1.0 { start_s + duration_s * u } else { end_s };
            if self.knots.time_s.last().is_some_and(|&last| time <= last) {
                continue;
            }
            self.knots.time_s.push(time);
            self.knots.q.extend_from_slice(&q);
            self.knots.segment_of.push(self.segments.len());
            self.q = q;
        }
        // Slower than programmed where the turn of the tool, or a time, sets the pace.
        let is_slower = self.standing_s > 0.0 && !stands_still(length_m);
        let feed = if is_slower { length_m / duration_s } else { next.feed_m_per_s };
        self.segments.push(Segment {
            index: self.index,
            // Most paths have far more joint moves than there is room for curves.
            curve: curve.map(Box::new),
            tcp: next.tcp,
            work: next.work.clone(),
            line: next.line,
            feed_m_per_s: feed,
            spindle_turns: next.spindle_turns,
            start_s,
            end_s,
            standing_s: self.standing_s,
            kind: self.kind,
            held: held_by(self.robot, next),
        });
    }
}
