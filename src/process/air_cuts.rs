//! Air cuts: moves on which no tooth is in the work.

use crate::job::Operation;
use crate::path::Path;

/// A move faster than this many times the operation's feed is one in the air.
const MIN_AIR_CUT_FEED_RATIO: f64 = 2.0;

/// Whether the move run at `s` is an air cut.
pub fn is_air_cut(operation: &Operation, path: &Path, s: f64) -> bool {
    path.feed_m_per_s_at(s) > MIN_AIR_CUT_FEED_RATIO * operation.feed_m_per_s
}
