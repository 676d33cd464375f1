//! The duration for which a schedule is solved, and the feed that belongs to it.
//!
//! The schedule solved for a duration T has a mean speed, and the feed that keeps the mean chip
//! load at it makes the path last g(T). With the slope of the speed over s bounded by the
//! acceleration times T, the schedule holds for every duration from T on, and no piece of it need
//! be slower than the spindle can if g(T) = T.
//!
//! T = g(T) is solved to a ten thousandth, by regula falsi, below the programmed duration T_p.
//! Where g(T_p) > T_p, T = T_p, as the acceleration is to be kept at the programmed feed, too;
//! where then a band is crossed, the feed stays as programmed, so that T is the schedule's own
//! duration all the same.

use super::outcome::Coupling;

/// The duration for which a schedule is solved and its own may differ by this share. What is left
/// of the acceleration for rounding is ten times as much.
const SETTLED: f64 = 1e-4;

/// Rounds after which the feed stays as programmed.
const MAX_ROUNDS: usize = 30;

/// The search for a duration.
#[derive(Debug, Clone)]
pub(super) struct DurationSearch {
    programmed_s: f64,
    solve_for_s: f64,
    coupling: Coupling,
    rounds: usize,
    /// A duration that is too long, and one that is too short: (T, g(T) − T).
    long: Option<(f64, f64)>,
    short: Option<(f64, f64)>,
}

/// What to do after a schedule was solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Next {
    /// Solve again, for another duration.
    Again,
    /// Take it, with this feed.
    Settled(Coupling),
}

impl DurationSearch {
    pub(super) fn new(programmed_s: f64, coupling: Coupling) -> Self {
        let solve_for_s = programmed_s;
        Self { programmed_s, solve_for_s, coupling, rounds: 0, long: None, short: None }
    }

    /// The duration to solve for, s.
    pub(super) fn solve_for_s(&self) -> f64 {
        self.solve_for_s
    }

    /// How often it was solved so far.
    pub(super) fn rounds(&self) -> usize {
        self.rounds
    }

    /// Goes by what was solved: `own_s` is g(T), and it `crosses` a band or not.
    pub(super) fn step(&mut self, own_s: f64, crosses: bool) -> Next {
        let Coupling::MeanChipLoad = self.coupling else {
            return Next::Settled(self.coupling);
        };
        self.rounds += 1;
        let settled = Next::Settled(Coupling::MeanChipLoad);
        let (solved_s, apart_s) = (self.solve_for_s, own_s - self.solve_for_s);
        let is_longest = solved_s == self.programmed_s;
        // After eight rounds a schedule that crosses nothing is taken if it holds.
        let is_enough = is_longest || self.rounds > 8;
        if apart_s.abs() <= SETTLED * solved_s || !crosses && apart_s > 0.0 && is_enough {
            return settled;
        }
        if apart_s > 0.0 && is_longest {
            self.coupling = Coupling::Crosses;
            return Next::Settled(self.coupling);
        }
        let before = self.long;
        if apart_s < 0.0 {
            self.long = Some((solved_s, apart_s));
        } else {
            self.short = Some((solved_s, apart_s));
        }
        let next_s = match (self.short, self.long) {
            // With every third step halved, a side that stays does not stop the search.
            (Some((a, _)), Some((b, _))) if self.rounds.is_multiple_of(3) => 0.5 * (a + b),
            (Some((a, above)), Some((b, below))) => a + (b - a) * above / (above - below),
            // On the same side as before: where the line through both would have it, if that is not
            // far off.
            _ => before
                .map(|(t, apart)| solved_s - apart_s * (solved_s - t) / (apart_s - apart))
                .filter(|next_s| (0.5 * own_s..=own_s).contains(next_s))
                .unwrap_or(own_s),
        };
        if self.rounds == MAX_ROUNDS || next_s == solved_s {
            (self.coupling, self.solve_for_s) = (Coupling::NotSettled, self.programmed_s);
        } else {
            self.solve_for_s = next_s.min(self.programmed_s);
        }
        Next::Again
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How the search ends for durations that follow `own`, the duration that was solved for, and
    /// how often.
    fn ends(own: &dyn Fn(f64) -> f64, crosses: bool) -> (Coupling, f64, usize) {
        let mut search = DurationSearch::new(100.0, Coupling::MeanChipLoad);
        for _ in 0..=2 * MAX_ROUNDS {
            let solved_s = search.solve_for_s();
            if let Next::Settled(coupling) = search.step(own(solved_s), crosses) {
                return (coupling, solved_s, search.rounds());
            }
        }
        panic!("it does not end");
    }

    #[test]
    fn across_a_band_the_duration_is_its_own() {
        // Flat, falling and rising in T, also so steep that repeating alone would not converge.
        for (slope, root) in [(0.0, 80.0), (-0.5, 90.0), (-1.5, 85.0), (0.6, 70.0), (-8.0, 95.0)] {
            let own = |t: f64| root + slope * (t - root);
            let (coupling, solved_s, rounds) = ends(&own, true);
            assert!(coupling == Coupling::MeanChipLoad && rounds < 12, "{slope}");
            assert!((own(solved_s) / solved_s - 1.0).abs() <= SETTLED, "{slope}: {solved_s}");
        }
    }

    #[test]
    fn a_slower_feed_does_not_stretch_a_crossing() {
        assert_eq!(ends(&|_| 117.0, true), (Coupling::Crosses, 100.0, 1));
        assert!(ends(&|_| 117.0, false) == (Coupling::MeanChipLoad, 100.0, 1));
    }

    #[test]
    fn out_of_the_bands_the_schedule_holds_for_its_duration() {
        for slope in [0.0, -0.5, -3.0] {
            let own = |t: f64| 80.0 + slope * (t - 80.0);
            let (coupling, solved_s, _) = ends(&own, false);
            assert!(coupling == Coupling::MeanChipLoad, "{slope}");
            assert!((own(solved_s) / solved_s - 1.0).abs() <= SETTLED, "{slope}: {solved_s}");
        }
        // Between two ways the mean jumps: the shorter duration holds.
        let own = |t: f64| if t > 80.0 { 70.0 } else { 90.0 };
        let (coupling, solved_s, _) = ends(&own, false);
        assert!(coupling == Coupling::MeanChipLoad && solved_s <= 80.0);
    }

    /// Between two ways the mean jumps: no duration is its own.
    #[test]
    fn what_does_not_settle_stays_as_programmed() {
        let own = |t: f64| if t > 80.0 { 70.0 } else { 90.0 };
        let (coupling, solved_s, _) = ends(&own, true);
        assert_eq!((coupling, solved_s), (Coupling::NotSettled, 100.0));
    }
}
