//! A policy on one operation: how wide the bands are at each place, and which modes count.

use rayon::prelude::*;

use crate::job::Policy;
use crate::notes::Note;
use crate::path::{Path, Survey, Surveyor};
use crate::uncertainty::{Belief, Trust, UNCALIBRATED, largest_by_mode, reach_of};

/// Unless a policy says otherwise, a mode counts whose response at the tool tip reaches this share
/// of the operation's largest.
const MIN_SHARE_OF_TIP_RESPONSE: f64 = 0.01;

/// Intervals are worked out at one station in so many: they change little from pose to pose.
const STRIDE: usize = 24;

/// A policy as it applies to one operation.
#[derive(Debug, Clone)]
pub struct Rules<'a> {
    /// What the job asks for.
    pub policy: &'a Policy,
    /// A mode that moves the tip less than this at resonance does not count, m/N.
    pub min_tip_response_m_per_n: f64,
    intervals: Intervals,
    /// Half an interval of ln f, in standard deviations.
    reach: f64,
}

/// How far each frequency may lie off.
#[derive(Debug, Clone)]
enum Intervals {
    /// f (1 ± this).
    Share(f64),
    /// f e^±h(s).
    Along(Along),
}

/// h of each mode along a path, linear between places.
#[derive(Debug, Clone)]
struct Along {
    modes: usize,
    s: Vec<f64>,
    half_ln: Vec<f64>,
    /// The largest of them, and the steepest slope.
    most: f64,
    steepest: f64,
}

impl<'a> Rules<'a> {
    /// The rules for the operation of `path`. `first_look` holds the tip response where the policy
    /// asks about it.
    ///
    /// # Errors
    /// The arm has no modes somewhere.
    pub fn new(
        policy: &'a Policy,
        trust: &Trust,
        path: &Path,
        first_look: &Survey,
    ) -> Result<Self, Note> {
        let largest = || {
            let tips = first_look.stations().flat_map(|station| station.tip_m_per_n);
            tips.fold(0.0_f64, |largest, &tip| largest.max(tip))
        };
        let stated = policy.min_tip_response_m_per_n;
        let reach = reach_of(policy.confidence);
        Ok(Self {
            policy,
            reach,
            min_tip_response_m_per_n: stated
                .unwrap_or_else(|| MIN_SHARE_OF_TIP_RESPONSE * largest()),
            intervals: match trust {
                Trust::Share(share) => Intervals::Share(*share),
                Trust::Belief(belief) => {
                    Intervals::Along(Along::new(belief, reach, path, first_look)?)
                }
            },
        })
    }

    /// The rules as far as the policy alone says them: an uncalibrated model, no mode too faint.
    pub fn stated(policy: &'a Policy) -> Self {
        Self {
            policy,
            min_tip_response_m_per_n: policy.min_tip_response_m_per_n.unwrap_or(0.0),
            intervals: Intervals::Share(policy.model_uncertainty.unwrap_or(UNCALIBRATED)),
            reach: reach_of(policy.confidence),
        }
    }

    /// The same rules with no mode too faint.
    pub(super) fn of_every_mode(&self) -> Self {
        Self { min_tip_response_m_per_n: 0.0, ..self.clone() }
    }

    /// Whether a mode that moves the tool tip this much at resonance, m/N, is too faint to count.
    pub fn is_faint(&self, tip_response_m_per_n: f64) -> bool {
        tip_response_m_per_n < self.min_tip_response_m_per_n
    }

    /// What every frequency may lie off by as a share of it, where one figure says it; else zero.
    pub fn uncertainty(&self) -> f64 {
        match self.intervals {
            Intervals::Share(share) => share,
            Intervals::Along(_) => 0.0,
        }
    }

    /// Half width of the widened bands about [`Self::reach_hz`], as a share of its ends.
    pub fn half_width(&self) -> f64 {
        self.policy.separation + self.uncertainty()
    }

    /// What bands of [`Self::half_width`] lie about, for mode `r` of frequency `hz` at `s`: the
    /// interval, or the frequency itself where one figure says what it may lie off by.
    pub fn reach_hz(&self, s: f64, r: usize, hz: f64) -> [f64; 2] {
        match &self.intervals {
            Intervals::Share(_) => [hz, hz],
            Intervals::Along(_) => self.interval_hz(s, r, hz),
        }
    }

    /// In which the frequency lies with the confidence of the policy, Hz.
    pub fn interval_hz(&self, s: f64, r: usize, hz: f64) -> [f64; 2] {
        match &self.intervals {
            Intervals::Share(share) => [hz * (1.0 - share), hz * (1.0 + share)],
            Intervals::Along(along) => {
                let factor = along.half_ln(s, r).exp();
                [hz / factor, hz * factor]
            }
        }
    }

    /// The edges of the widened band and of the band, ascending, as shares of the frequency of mode
    /// `r` at `s`.
    pub(super) fn edges(&self, s: f64, r: usize) -> [f64; 4] {
        let [low, high] = self.reach_hz(s, r, 1.0);
        let (narrow, wide) = (self.policy.separation, self.half_width());
        [low * (1.0 - wide), 1.0 - narrow, 1.0 + narrow, high * (1.0 + wide)]
    }

    /// The lowest and the highest edge of any mode anywhere, and the steepest slope of ln of an
    /// edge.
    pub(super) fn bounds(&self) -> ([f64; 2], f64) {
        let (most, steepest) = match &self.intervals {
            Intervals::Share(_) => (0.0, 0.0),
            Intervals::Along(along) => (along.most, along.steepest),
        };
        let wide = self.half_width();
        ([(-most).exp() * (1.0 - wide), most.exp() * (1.0 + wide)], steepest)
    }

    /// Bounds the slope of ln of the widened band's edges against the frequency, between two
    /// places.
    pub fn edge_rate(&self, from_s: f64, to_s: f64, r: usize) -> f64 {
        match &self.intervals {
            Intervals::Share(_) => 0.0,
            Intervals::Along(along) => along.slope(from_s, to_s, r),
        }
    }

    /// Standard deviation of ln f of mode `r` at `s`.
    pub(super) fn std_ln(&self, s: f64, r: usize) -> f64 {
        let half = match &self.intervals {
            Intervals::Share(share) => *share,
            Intervals::Along(along) => along.half_ln(s, r),
        };
        half / self.reach
    }

    /// The widest half width of any widened band, as a share of the frequency.
    pub(super) fn widest(&self) -> f64 {
        match &self.intervals {
            Intervals::Share(_) => self.half_width(),
            Intervals::Along(along) => (1.0 + self.policy.separation) * along.most.exp() - 1.0,
        }
    }

    /// What the frequency of each of so many modes may lie off by at most along the path, as a
    /// share.
    pub fn uncertainty_by_mode(&self, modes: usize) -> Vec<f64> {
        match &self.intervals {
            Intervals::Share(share) => vec![*share; modes],
            Intervals::Along(along) => {
                let all = along.half_ln.chunks_exact(along.modes.max(1));
                let shares: Vec<Vec<f64>> =
                    all.map(|own| own.iter().map(|half| half.exp_m1()).collect()).collect();
                largest_by_mode(shares.iter().map(Vec::as_slice))
            }
        }
    }
}

impl Along {
    fn new(belief: &Belief, reach: f64, path: &Path, survey: &Survey) -> Result<Self, Note> {
        let last = survey.len().saturating_sub(1);
        let mut places: Vec<usize> = (0..survey.len()).step_by(STRIDE).collect();
        if places.last() != Some(&last) {
            places.push(last);
        }
        let s: Vec<f64> = places.iter().map(|&i| survey.station(i).s).collect();
        let own: Vec<Vec<f64>> = s
            .par_iter()
            .map_init(
                || Surveyor::new(path),
                |surveyor, &s| {
                    surveyor.modes(s)?;
                    let (robot, solver) = (surveyor.robot(), surveyor.solver());
                    let std_ln = belief.std_ln_at(robot, solver, surveyor.joints());
                    Ok(std_ln.into_iter().map(|std| reach * std).collect())
                },
            )
            .collect::<Result<_, Note>>()?;
        let modes = own.first().map_or(0, Vec::len);
        // Where modes change places their deviations do, too: between two places the larger of
        // them and their neighbours counts.
        let most = |k: usize, r: usize| {
            let near = &own[k.saturating_sub(1)..(k + 2).min(own.len())];
            near.iter().fold(0.0_f64, |most, half| most.max(half[r]))
        };
        let half_ln = (0..own.len()).flat_map(|k| (0..modes).map(move |r| (k, r)));
        let half_ln: Vec<f64> = half_ln.map(|(k, r)| most(k, r)).collect();
        let most = half_ln.iter().fold(0.0_f64, |most, h| most.max(*h));
        let mut found = Self { modes, s, half_ln, most, steepest: 0.0 };
        found.steepest = (0..modes).map(|r| found.slope(0.0, 1.0, r)).fold(0.0, f64::max);
        Ok(found)
    }

    fn at(&self, k: usize, r: usize) -> f64 {
        self.half_ln[k * self.modes + r]
    }

    fn half_ln(&self, s: f64, r: usize) -> f64 {
        let after = self.s.partition_point(|place| *place <= s).clamp(1, self.s.len());
        let before = after - 1;
        let (Some(&from), Some(&to)) = (self.s.get(before), self.s.get(after)) else {
            return self.at(before, r);
        };
        let share = ((s - from) / (to - from)).clamp(0.0, 1.0);
        self.at(before, r) + share * (self.at(after, r) - self.at(before, r))
    }

    fn slope(&self, from_s: f64, to_s: f64, r: usize) -> f64 {
        let first = self.s.partition_point(|place| *place <= from_s).saturating_sub(1);
        let behind = self.s.partition_point(|place| *place < to_s).min(self.s.len() - 1);
        let slope =
            |k: usize| (self.at(k + 1, r) - self.at(k, r)).abs() / (self.s[k + 1] - self.s[k]);
        (first..behind).map(slope).fold(0.0, f64::max)
    }
}
