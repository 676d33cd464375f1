//! How long a move takes.

use nalgebra::{Matrix6xX, Vector3};

use crate::model::{Placement, Robot, forward_kinematics, joint_jacobian};
use crate::motion::{Move, Timing, Work};

/// A tool centre point that moves less than this stands still, m: tool frames in files are rounded,
/// and a turn about an axis that misses the point by a hair is a turn on the spot.
const MAX_STANDSTILL_M: f64 = 1e-6;

/// A joint that moves less than this, rad or m, hardly moves.
const NEGLIGIBLE_MOTION: f64 = 1e-5;

/// Pieces of a joint move over which the way of the tool centre point is integrated turn no joint
/// by more than this (rad or m). Five points then leave a relative error below 1e-12.
const MAX_PIECE: f64 = 0.1;

/// Below this step two points leave a relative error of some 1e-9.
const MAX_SHORT_PIECE: f64 = 0.02;

/// Nodes on 0..=1 and weights of Gauss–Legendre quadrature (Abramowitz & Stegun, Table 25.4).
const TWO_POINTS: [(f64, f64); 2] =
    [(0.211_324_865_405_187_1, 0.5), (0.788_675_134_594_812_9, 0.5)];
const FIVE_POINTS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_6, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Measures joint moves of one robot in buffers of its own.
#[derive(Debug, Clone)]
pub(super) struct Clock<'a> {
    robot: &'a Robot,
    placement: Placement,
    jacobian: Matrix6xX<f64>,
    q: Vec<f64>,
}

impl<'a> Clock<'a> {
    pub(super) fn new(robot: &'a Robot) -> Self {
        let joints = robot.joints().len();
        Self {
            robot,
            placement: Placement::new(robot),
            jacobian: Matrix6xX::zeros(joints),
            q: vec![0.0; joints],
        }
    }

    /// Way of the tool centre point while the joints go straight from `from` to `to`, m, and what
    /// the tool turns on it, rad, both in the frame of the work.
    pub(super) fn joint_move_ways(&mut self, next: &Move, from: &[f64], to: &[f64]) -> (f64, f64) {
        let step = largest_step(from, to).max(next.work.largest_step());
        let nodes: &[(f64, f64)] = if step <= MAX_SHORT_PIECE { &TWO_POINTS } else { &FIVE_POINTS };
        let pieces = (step / MAX_PIECE).ceil().max(1.0);
        let (mut length, mut turn) = (0.0, 0.0);
        let mut tcp = next.tcp.translation.vector.into();
        for piece in 0..pieces as usize {
            for &(node, weight) in nodes {
                let u = (piece as f64 + node) / pieces;
                for (q, (a, b)) in self.q.iter_mut().zip(from.iter().zip(to)) {
                    *q = a + (b - a) * u;
                }
                self.placement.place_joints(self.robot, &self.q);
                if next.work == Work::Held {
                    let tip = forward_kinematics(self.robot, &self.placement);
                    tcp = tip.inverse_transform_point(&next.tcp.translation.vector.into());
                }
                joint_jacobian(self.robot, &self.placement, &tcp, &mut self.jacobian);
                let (mut velocity, mut turning) = (Vector3::zeros(), Vector3::zeros());
                for (j, (a, b)) in from.iter().zip(to).enumerate() {
                    velocity += self.jacobian.fixed_view::<3, 1>(0, j) * (b - a);
                    turning += self.jacobian.fixed_view::<3, 1>(3, j) * (b - a);
                }
                if matches!(next.work, Work::Moves(_)) {
                    let tip = forward_kinematics(self.robot, &self.placement);
                    let [carried, turned] = next.work.motion(u, &(tip * tcp));
                    velocity -= carried;
                    turning -= turned;
                }
                length += weight / pieces * velocity.norm();
                turn += weight / pieces * turning.norm();
            }
        }
        (length, turn)
    }
}

/// Whether a tool centre point that goes this far stands still.
pub(super) fn stands_still(length_m: f64) -> bool {
    length_m <= MAX_STANDSTILL_M
}

/// Seconds for a move: as the program gives them, or the way of the tool centre point over the
/// feed; where the point stands still, no less than the slowest joint's motion at its largest
/// speed; no less than the turn of the tool, and than external axes, at the speed that the program
/// has for them. `ways` is what each joint turns or slides in all, `turn_rad` what the tool turns.
///
/// `Err` names a joint that has no largest speed to go by.
pub(super) fn seconds(
    robot: &Robot,
    length_m: f64,
    turn_rad: f64,
    next: &Move,
    ways: &[f64],
) -> Result<f64, usize> {
    let by_feed = length_m / next.feed_m_per_s;
    let by_feed = by_feed.max(by_turn(turn_rad, next).unwrap_or(0.0)).max(next.stated.external_s);
    match next.timing {
        Timing::Seconds(seconds) => Ok(seconds),
        // Without a limit of speed its share says nothing.
        Timing::Joints(share) => {
            Ok(by_joints(robot, ways).map_or(by_feed, |seconds| seconds / share))
        }
        Timing::Feed | Timing::Rapid if stands_still(length_m) => {
            Ok(by_feed.max(by_joints(robot, ways)?))
        }
        Timing::Feed | Timing::Rapid => Ok(by_feed),
    }
}

/// Seconds that the turn of the tool takes at the speed that the program has for it.
fn by_turn(turn_rad: f64, next: &Move) -> Option<f64> {
    next.stated.turning_rad_per_s.map(|speed| turn_rad / speed)
}

/// Whether a move takes as long as its feed says.
pub(super) fn is_of_feed(length_m: f64, turn_rad: f64, next: &Move) -> bool {
    let by_feed = length_m / next.feed_m_per_s;
    matches!(next.timing, Timing::Feed | Timing::Rapid)
        && !stands_still(length_m)
        && by_turn(turn_rad, next).is_none_or(|seconds| seconds <= by_feed)
        && next.stated.external_s <= by_feed
}

/// Seconds that the slowest joint takes at its largest speed.
fn by_joints(robot: &Robot, ways: &[f64]) -> Result<f64, usize> {
    let mut slowest = 0.0_f64;
    for (index, (way, joint)) in ways.iter().zip(robot.joints()).enumerate() {
        match joint.velocity_limit {
            Some(limit) => slowest = slowest.max(way / limit),
            // A step that rounding made.
            None if *way <= NEGLIGIBLE_MOTION => {}
            None => return Err(index),
        }
    }
    Ok(slowest)
}

/// Largest change of any joint.
pub(super) fn largest_step(from: &[f64], to: &[f64]) -> f64 {
    from.iter().zip(to).fold(0.0, |most, (a, b)| most.max((b - a).abs()))
}
