//! Moves at feed while the spindle is known to stand: what cuts there is not checked.

use std::collections::BTreeMap;

use super::{Dialect, Spindle, SpindleCommand};
use crate::motion::{Move, Target, Timing};

/// The line of the first such move and what is to be told of all. Nothing where the spindle never
/// turns: then nothing at all is checked, which is told elsewhere.
///
/// A CAM program says which moves are rapid. A robot's does not: there a move counts that is no
/// faster than the program mostly moves with the spindle on.
pub(super) fn feed_moves(
    moves: &[Move],
    spindle: &[SpindleCommand],
    dialect: Dialect,
) -> Option<(usize, String)> {
    // Nothing moves to where the path starts.
    let own = moves.get(1..)?;
    let is_led = |each: &&Move| {
        matches!(each.to, Target::Line(_) | Target::Arc { .. })
            && matches!(each.timing, Timing::Feed | Timing::Seconds(_))
    };
    if !own.iter().any(|each| each.spindle_turns) {
        return None;
    }
    let most = match dialect {
        Dialect::Rapid | Dialect::Krl | Dialect::Fanuc => {
            usual_feed(own.iter().filter(is_led).filter(|each| each.spindle_turns))?
        }
        Dialect::Apt | Dialect::GCode | Dialect::Sinumerik | Dialect::Heidenhain => f64::INFINITY,
    };
    let stands = |each: &&Move| !each.spindle_turns && each.feed_m_per_s <= most;
    let mut found = own.iter().enumerate().filter(|(_, each)| is_led(each) && stands(each));
    let (index, first) = found.next()?;
    let is_before = |at: &&SpindleCommand| at.from_move <= index + 1;
    let stop = spindle.iter().rev().filter(|at| at.spindle == Spindle::Stands).find(is_before)?;
    let more = match found.count() {
        0 => String::new(),
        1 => ", and one move more".to_owned(),
        more => format!(", and {more} moves more"),
    };
    let what = format!(
        "moves at feed with the spindle stopped (by line {}){more}: nothing is checked there; if \
         it turns, let the program start it",
        stop.line
    );
    Some((first.line, what))
}

/// The feed of most moves, m/s.
fn usual_feed<'m>(moves: impl Iterator<Item = &'m Move>) -> Option<f64> {
    let mut counts: BTreeMap<u64, usize> = BTreeMap::new();
    // The bits of positive numbers are in the order of the numbers.
    moves.for_each(|each| *counts.entry(each.feed_m_per_s.to_bits()).or_default() += 1);
    counts.into_iter().max_by_key(|&(_, count)| count).map(|(bits, _)| f64::from_bits(bits))
}
