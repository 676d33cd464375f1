//! The moves of a path → stretches under one spindle speed, with one cutter and one thing carried.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::motion::{Load, Move, Spindle, Target, Timing, Work};

/// Moves of a path that run alike.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub(super) moves: Range<usize>,
    /// Speed that the program states, rev/min; `None` where it is the job's.
    pub(super) rpm: Option<f64>,
    /// Number of the tool.
    pub(super) tool: Option<u32>,
    pub(super) load: Option<Arc<Load>>,
    /// Whether the program has stopped the spindle on the whole stretch.
    pub(super) stands: bool,
}

/// Moves under the same statements.
struct Run {
    moves: Range<usize>,
    /// `Some(None)`: turns at a speed that the program does not give. `None`: stands, or the
    /// program has said nothing yet.
    rpm: Option<Option<f64>>,
    tool: Option<u32>,
    load: Option<Arc<Load>>,
}

impl Run {
    fn has_cutter_of(&self, other: &Self) -> bool {
        let same_load = match (&self.load, &other.load) {
            (Some(a), Some(b)) => a.is_same_body(b),
            (a, b) => a.is_none() && b.is_none(),
        };
        self.tool == other.tool && same_load
    }
}

/// The stretches in order. Where the program is silent, or the spindle stands, the motion belongs
/// to the stretch that follows; with `is_speed_of_job` nothing that the program says of speed
/// counts. Tool 0 is an empty spindle unless the job has such a tool. With `has_payload` the job
/// says what moves carry of which the program does not.
pub(super) fn stretches(
    moves: &[Move],
    is_speed_of_job: bool,
    has_tool_0: bool,
    has_payload: bool,
) -> Vec<Stretch> {
    let mut runs = runs(moves, has_tool_0);
    fill(&mut runs, |run| &mut run.tool);
    if !has_payload {
        for group in runs.chunk_by_mut(|a, b| a.tool == b.tool) {
            fill(group, |run| &mut run.load);
        }
        fill(&mut runs, |run| &mut run.load);
    }
    if is_speed_of_job {
        runs.iter_mut().for_each(|run| run.rpm = None);
    }
    for group in runs.chunk_by_mut(|a, b| a.has_cutter_of(b)) {
        fill(group, |run| &mut run.rpm);
    }
    fill(&mut runs, |run| &mut run.rpm);
    let alike = |a: &Run, b: &Run| a.has_cutter_of(b) && a.rpm == b.rpm;
    let stretches = runs.chunk_by(alike).filter_map(|group| {
        let (first, last) = (group.first()?, group.last()?);
        let range = first.moves.start..last.moves.end;
        // Nothing moves to where the path starts.
        let from = usize::from(range.start == 0 && range.len() > 1) + range.start;
        let moved = moves.get(from..range.end).unwrap_or_default();
        Some(Stretch {
            moves: range,
            stands: !moved.iter().any(|each| each.spindle_turns),
            rpm: first.rpm.flatten(),
            tool: first.tool,
            load: first.load.clone(),
        })
    });
    stretches.collect()
}

fn runs(moves: &[Move], has_tool_0: bool) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut start = 0;
    let same = |a: &Move, b: &Move| Arc::ptr_eq(&a.stated, &b.stated) || a.stated == b.stated;
    for group in moves.chunk_by(same) {
        let end = start + group.len();
        let stated = &group[0].stated;
        runs.push(Run {
            moves: start..end,
            rpm: match stated.spindle {
                Some(Spindle::Turns(rpm)) => Some(rpm),
                Some(Spindle::Stands) | None => None,
            },
            tool: stated.tool.filter(|&number| number != 0 || has_tool_0 || may_cut(group)),
            load: stated.load.clone(),
        });
        start = end;
    }
    // Nothing moves to where the path starts.
    if let [first, second, ..] = runs.as_mut_slice()
        && first.moves.len() == 1
    {
        second.moves.start = 0;
        runs.remove(0);
    }
    runs
}

/// Whether the spindle turns on a move that is not rapid; a dwell is none.
fn may_cut(moves: &[Move]) -> bool {
    let is_led = |each: &Move| match each.timing {
        Timing::Rapid => false,
        Timing::Feed | Timing::Joints(_) => true,
        Timing::Seconds(_) => matches!(each.to, Target::Line(_) | Target::Arc { .. }),
    };
    moves.iter().any(|each| each.spindle_turns && is_led(each))
}

/// Gives each run that lacks a part that of the next one that has it, else of the one before.
fn fill<T: Clone>(runs: &mut [Run], part: fn(&mut Run) -> &mut Option<T>) {
    let take = |from: &mut Option<T>, run: &mut Run| match part(run) {
        Some(own) => *from = Some(own.clone()),
        lacking => lacking.clone_from(from),
    };
    let (mut behind, mut before) = (None, None);
    runs.iter_mut().rev().for_each(|run| take(&mut behind, run));
    runs.iter_mut().for_each(|run| take(&mut before, run));
}

/// The feed, m/s, at which a stretch of a path runs longest with the spindle on, by the straight
/// ways between its targets; moves with the spindle stopped count only where there is nothing else,
/// then rapid moves. A dwell has no feed.
pub(super) fn usual_feed_m_per_s(moves: &[Move], stretch: Range<usize>) -> Option<f64> {
    let has_feed = |each: &Move| matches!(each.timing, Timing::Feed | Timing::Seconds(_));
    let cuts = |each: &Move| has_feed(each) && each.spindle_turns;
    let kinds: [&dyn Fn(&Move) -> bool; 3] = [&cuts, &has_feed, &|_| true];
    let pair = |index: usize| Some((moves.get(index.checked_sub(1)?)?, moves.get(index)?));
    let pairs = || stretch.clone().filter_map(pair);
    let counts = kinds
        .into_iter()
        .find(|kind| pairs().any(|(before, to)| kind(to) && goes_on(before, to)))
        .unwrap_or(&|_| true);
    let mut seconds: BTreeMap<u64, f64> = BTreeMap::new();
    for index in stretch.clone() {
        let each = moves.get(index)?;
        if !counts(each) {
            continue;
        }
        let before = index.checked_sub(1).and_then(|index| moves.get(index));
        let way = before.and_then(|before| way(before, each)).map_or(0.0, |way| way.norm());
        // The bits of positive numbers are in the order of the numbers.
        *seconds.entry(each.feed_m_per_s.to_bits()).or_default() += way / each.feed_m_per_s;
    }
    let feeds = seconds.iter().map(|(&bits, &time)| (f64::from_bits(bits), time));
    let longest = feeds.reduce(|best, next| if next.1 > best.1 { next } else { best });
    longest.map(|(feed, _)| feed)
}

/// Whether a move goes anywhere, as far as that is known.
fn goes_on(before: &Move, to: &Move) -> bool {
    // The arm follows work that moves.
    matches!(to.work, Work::Moves(_)) || way(before, to).is_none_or(|way| way != Vector3::zeros())
}

/// The straight way of the tool in the work, where both ends lie in one frame.
fn way(before: &Move, to: &Move) -> Option<Vector3<f64>> {
    let is_one_frame = match (&before.work, &to.work) {
        (Work::Moves(a), Work::Moves(b)) => a.unit == b.unit,
        (a, b) => a == b,
    };
    Some(place(to)? - place(before)?).filter(|_| is_one_frame)
}

fn place(a_move: &Move) -> Option<Vector3<f64>> {
    match &a_move.to {
        Target::Joints(_) => None,
        Target::JointsTo(end) | Target::Line(end) | Target::Arc { end, .. } => {
            Some(end.translation.vector)
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Matrix3};

    use super::*;
    use crate::motion::Stated;

    fn moves(stated: &[(Option<Spindle>, Option<u32>, Option<f64>)]) -> Vec<Move> {
        let load = |mass_kg| Load {
            name: "t".to_owned(),
            line: 1,
            mass_kg,
            com_m: Vector3::zeros(),
            inertia_kgm2: Matrix3::zeros(),
            is_placeholder: false,
        };
        let each = stated.iter().enumerate().map(|(i, &(spindle, tool, mass))| Move {
            to: Target::Line(Isometry3::translation(i as f64, 0.0, 0.0)),
            feed_m_per_s: 0.01,
            tcp: Isometry3::identity(),
            work: Work::Stands,
            line: i + 1,
            timing: Timing::Feed,
            spindle_turns: spindle != Some(Spindle::Stands),
            stated: Arc::new(Stated {
                spindle,
                tool,
                load: mass.map(load).map(Arc::new),
                ..Stated::default()
            }),
        });
        each.collect()
    }

    /// On work that moves, too, the feed is that of the longest time of cutting.
    #[test]
    fn the_usual_feed_on_a_table() {
        use crate::motion::{MechanicalUnit, UnitMove};
        let frame = Isometry3::identity();
        let unit = Arc::new(MechanicalUnit { name: "T".to_owned(), axes: Vec::new(), frame });
        let mut program = moves(&[(Some(Spindle::Turns(Some(9.0))), None, None); 4]);
        for (each, (x, feed)) in
            program.iter_mut().zip([(0.0, 0.05), (0.001, 0.005), (0.9, 0.05), (0.9, 0.005)])
        {
            let of = UnitMove { unit: Arc::clone(&unit), from: Vec::new(), to: Vec::new() };
            each.work = Work::Moves(Arc::new(of));
            each.to = Target::Line(Isometry3::translation(x, 0.0, 0.0));
            each.feed_m_per_s = feed;
        }
        assert_eq!(usual_feed_m_per_s(&program, 0..4), Some(0.05));
    }

    #[test]
    fn silence_and_standstill_belong_to_what_follows() {
        let at = |rpm| Some(Spindle::Turns(Some(rpm)));
        let stands = Some(Spindle::Stands);
        let program = moves(&[
            (None, None, None),
            (None, Some(1), None),
            (at(900.0), Some(1), Some(4.0)),
            (stands, Some(1), None),
            (at(900.0), Some(1), Some(4.0)),
            (stands, Some(1), None),
            (stands, Some(2), None),
            (at(800.0), Some(2), Some(5.0)),
            (stands, Some(2), None),
        ]);
        let found = |job| -> Vec<_> {
            let found = stretches(&program, job, false, false).into_iter();
            found.map(|s| (s.moves, s.rpm, s.tool, s.load.map(|l| l.mass_kg))).collect()
        };
        let expected =
            [(0..6, Some(900.0), Some(1), Some(4.0)), (6..9, Some(800.0), Some(2), Some(5.0))];
        assert_eq!(found(false), expected);
        assert!(found(true).iter().all(|(_, rpm, ..)| rpm.is_none()));
    }
}
