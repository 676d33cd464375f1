//! How fast the spindle turns at each point of a path.

use crate::job::SpindleSpeed;
use crate::path::Path;

/// The programmed speed where the spindle turns, and zero where the program has stopped it.
#[derive(Debug, Clone)]
pub struct SpindleProfile<'a> {
    pub(super) speed: &'a SpindleSpeed,
    /// Stretches of s, ascending and apart.
    stops: Vec<[f64; 2]>,
}

impl<'a> SpindleProfile<'a> {
    /// The speed of an operation along its path.
    pub fn new(speed: &'a SpindleSpeed, path: &Path) -> Self {
        Self { speed, stops: path.spindle_stops() }
    }

    /// Whether the spindle stands still at `s`. At the waypoints where it stops and starts it
    /// turns.
    pub fn is_stopped_at(&self, s: f64) -> bool {
        let after = self.stops.partition_point(|&[from, _]| from < s);
        match after.checked_sub(1).and_then(|i| self.stops.get(i)) {
            Some(&[_, to]) => s < to || (s == to && to == 1.0),
            None => s == 0.0 && self.stops.first().is_some_and(|&[from, _]| from == 0.0),
        }
    }

    /// Speed at `s`, rev/min; zero where the spindle stands still.
    pub(super) fn rpm_at(&self, s: f64) -> f64 {
        if self.is_stopped_at(s) { 0.0 } else { self.speed.rpm_at(s) }
    }

    /// The place in `from_s..=to_s` where the spindle stops or starts, if there is one.
    pub(super) fn jump_in(&self, from_s: f64, to_s: f64) -> Option<f64> {
        self.stops.iter().flatten().copied().find(|s| (from_s..=to_s).contains(s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spindle_stands_between_the_waypoints_where_it_stops_and_starts() {
        let speed = SpindleSpeed::Constant(600.0);
        let turning =
            SpindleProfile { speed: &speed, stops: vec![[0.0, 0.1], [0.4, 0.5], [0.9, 1.0]] };
        for (s, rpm) in [
            (0.0, 0.0),
            (0.05, 0.0),
            (0.1, 600.0),
            (0.4, 600.0),
            (0.45, 0.0),
            (0.5, 600.0),
            (0.9, 600.0),
            (0.91, 0.0),
            (1.0, 0.0),
        ] {
            assert_eq!(turning.rpm_at(s), rpm, "{s}");
        }
        assert_eq!(turning.jump_in(0.39, 0.41), Some(0.4));
        assert_eq!(turning.jump_in(0.2, 0.3), None);
        let always = SpindleProfile { speed: &speed, stops: Vec::new() };
        assert_eq!([0.0, 0.5, 1.0].map(|s| always.rpm_at(s)), [600.0; 3]);
    }
}
