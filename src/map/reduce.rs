//! Statistics of a map that is too long to read: extremes, means, quantiles and histograms of each
//! mode, gathered as the poses go by.
//!
//! Values are counted in bins whose edges are doubles with 14 bits after the point: 2⁻¹⁴ of a power
//! of two wide, at most 0.0061 % of the frequency. Quantiles of few poses are exact. Sums are exact
//! too, until the end: the same poses give the same bits whatever the number of threads, and in
//! however many parts they are gathered ([`Reduction::append`]).

use std::ops::Range;

use rayon::prelude::*;
use serde::{Deserialize, Deserializer, Serialize};

use super::Block;
use super::bins::{Bin, Bins, OCTAVE, bin_of};
use crate::units::written;

/// Quantiles that are found.
pub const SHARES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// Poses up to which all frequencies are kept, and quantiles are exact.
pub const EXACT_UP_TO: usize = 65_536;

/// Widest bin as a share of the frequencies in it.
pub const RESOLUTION: f64 = 1.0 / OCTAVE as f64;

/// Statistics of a reduced map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Statistic {
    /// The lowest frequency, and where.
    Min,
    /// The highest frequency, and where.
    Max,
    /// The mean.
    Mean,
    /// The quantiles of [`SHARES`].
    Quantiles,
    /// How many poses lie in which band.
    Histogram,
}

impl Statistic {
    /// All, in the order in which they are written.
    pub const ALL: [Self; 5] = [Self::Min, Self::Max, Self::Mean, Self::Quantiles, Self::Histogram];
}

/// A frequency and the first pose that has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extreme {
    /// Hz.
    pub frequency_hz: f64,
    /// Place of the pose, from zero.
    #[serde(serialize_with = "written::from_one", deserialize_with = "from_one")]
    pub pose: usize,
    /// Joint positions, rad or m, base to tip.
    pub joints: Vec<f64>,
    /// β2 of the two-link model, where the robot defines it, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beta2_rad: Option<f64>,
}

/// A place that is written counted from one.
fn from_one<'de, D: Deserializer<'de>>(from: D) -> Result<usize, D::Error> {
    let place = usize::deserialize(from)?;
    place.checked_sub(1).ok_or_else(|| serde::de::Error::custom("a place is 0, counts from 1"))
}

/// One mode of a reduced map.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedMode {
    /// The lowest frequency.
    pub min: Extreme,
    /// The highest frequency.
    pub max: Extreme,
    /// Mean frequency, Hz.
    pub mean_hz: f64,
    /// One per entry of [`SHARES`], Hz: between the two nearest poses in order of frequency, in
    /// proportion.
    pub quantiles_hz: [f64; SHARES.len()],
    /// Adjoining bands from the lowest to the highest frequency, at most 48.
    pub histogram: Vec<Bin>,
}

/// A reduced map.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduced {
    /// Poses that went by.
    pub poses: usize,
    /// By how much of themselves quantiles may be off at most; 0 where they are exact.
    pub quantile_resolution: f64,
    /// In ascending order of frequency.
    pub modes: Vec<ReducedMode>,
}

/// Gathers the statistics of a map, or of a part of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reduction {
    joints: usize,
    /// The place of the part's first pose in the whole, from zero.
    first: usize,
    poses: usize,
    modes: Vec<Gathered>,
}

impl Reduction {
    /// For poses of so many joints and modes.
    pub fn new(joints: usize, modes: usize) -> Self {
        Self::from_pose(0, joints, modes)
    }

    /// The same for the part of a map that starts with a pose, by its place from zero.
    pub fn from_pose(first: usize, joints: usize, modes: usize) -> Self {
        Self { joints, first, poses: 0, modes: vec![Gathered::default(); modes] }
    }

    /// The places of its poses in the whole, from zero.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first.saturating_add(self.poses)
    }

    /// Takes in the part that follows.
    pub fn append(&mut self, later: Self) {
        self.poses += later.poses;
        let is_short = self.poses <= EXACT_UP_TO;
        for (mode, later) in self.modes.iter_mut().zip(later.modes) {
            mode.join(later, is_short);
        }
    }

    /// Whether it can be what poses of so many joints and modes have left: nothing that is read
    /// from a file is taken on trust.
    pub fn is_sound(&self, joints: usize, modes: usize) -> bool {
        let fits = |extreme: &Option<Extreme>| match extreme {
            Some(extreme) => {
                extreme.joints.len() == joints
                    && self.range().contains(&extreme.pose)
                    && extreme.frequency_hz.is_finite()
            }
            None => self.poses == 0,
        };
        let has_all = |mode: &Gathered| {
            let kept = if self.poses > EXACT_UP_TO { 0 } else { self.poses };
            let range = mode.min.as_ref().zip(mode.max.as_ref());
            fits(&mode.min)
                && fits(&mode.max)
                && mode.bins.range() == range.map(|(a, b)| [a, b].map(|e| bin_of(e.frequency_hz)))
                && mode.bins.total() == Some(self.poses as u64)
                && mode.kept.len() == kept
                && (kept == 0 || mode.bins == Bins::of(&mode.kept))
        };
        self.joints == joints
            && self.modes.len() == modes
            && self.first.checked_add(self.poses).is_some()
            && self.modes.iter().all(has_all)
    }

    /// Takes in the next poses, in their order; each mode on a thread of its own.
    pub fn add(&mut self, blocks: &[&Block]) {
        let (joints, before, count) = (self.joints, self.poses, self.modes.len());
        let all = before + blocks.iter().map(|block| block.count).sum::<usize>();
        let start = self.first;
        self.modes.par_iter_mut().enumerate().for_each(|(mode, gathered)| {
            if all > EXACT_UP_TO {
                gathered.kept = Vec::new();
            }
            let mut first = start + before;
            for block in blocks {
                let values = block.frequencies_hz.iter().skip(mode).step_by(count).copied();
                if all <= EXACT_UP_TO {
                    gathered.kept.extend(values.clone());
                }
                gathered.scan(values, |at| Extreme {
                    frequency_hz: block.frequencies_hz[at * count + mode],
                    pose: first + at,
                    joints: block.poses[at * joints..(at + 1) * joints].to_vec(),
                    beta2_rad: block.beta2_rad.get(at).copied(),
                });
                first += block.count;
            }
        });
        self.poses = all;
    }

    /// The statistics; `None` if no pose went by.
    pub fn finish(self) -> Option<Reduced> {
        let poses = self.poses;
        let modes = self.modes.into_iter().map(|mode| mode.finish(poses)).collect::<Option<_>>()?;
        let quantile_resolution = if poses > EXACT_UP_TO { RESOLUTION } else { 0.0 };
        Some(Reduced { poses, quantile_resolution, modes })
    }
}

/// One mode so far.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Gathered {
    min: Option<Extreme>,
    max: Option<Extreme>,
    bins: Bins,
    /// All values while they are few.
    kept: Vec<f64>,
}

impl Gathered {
    fn scan(&mut self, values: impl Iterator<Item = f64>, pose: impl Fn(usize) -> Extreme) {
        let frequency = |extreme: &Option<Extreme>, none: f64| {
            extreme.as_ref().map_or(none, |extreme| extreme.frequency_hz)
        };
        let (mut min, mut max) =
            (frequency(&self.min, f64::INFINITY), frequency(&self.max, f64::NEG_INFINITY));
        let (mut min_at, mut max_at) = (None, None);
        for (i, f) in values.enumerate() {
            if f < min {
                (min, min_at) = (f, Some(i));
            }
            if f > max {
                (max, max_at) = (f, Some(i));
            }
            self.bins.count(f);
        }
        if let Some(at) = min_at {
            self.min = Some(pose(at));
        }
        if let Some(at) = max_at {
            self.max = Some(pose(at));
        }
    }

    fn join(&mut self, later: Self, keeps_values: bool) {
        let is_lower = |other: &Extreme, own: &Extreme| other.frequency_hz < own.frequency_hz;
        let is_higher = |other: &Extreme, own: &Extreme| other.frequency_hz > own.frequency_hz;
        take_if(&mut self.min, later.min, is_lower);
        take_if(&mut self.max, later.max, is_higher);
        self.bins.join(later.bins);
        if keeps_values {
            self.kept.extend(later.kept);
        } else {
            self.kept = Vec::new();
        }
    }

    fn finish(mut self, poses: usize) -> Option<ReducedMode> {
        let (min, max) = (self.min?, self.max?);
        self.kept.sort_by(f64::total_cmp);
        let within = |f: f64| f.clamp(min.frequency_hz, max.frequency_hz);
        let quantiles_hz = SHARES.map(|share| {
            let rank = share * (poses - 1) as f64;
            let (below, part) = (rank.floor() as usize, rank.fract());
            let value = |rank: usize| match self.kept.get(rank) {
                Some(&exact) => exact,
                None => within(self.bins.value(rank as u64)),
            };
            let (low, high) = (value(below), value((below + 1).min(poses - 1)));
            within(low + part * (high - low))
        });
        let histogram = self.bins.histogram(min.frequency_hz, max.frequency_hz);
        let mean_hz = within(self.bins.sum() / poses as f64);
        Some(ReducedMode { min, max, mean_hz, quantiles_hz, histogram })
    }
}

/// Takes a later extreme where there is none or it goes beyond the own one.
fn take_if(
    own: &mut Option<Extreme>,
    later: Option<Extreme>,
    goes_beyond: impl Fn(&Extreme, &Extreme) -> bool,
) {
    let Some(later) = later else { return };
    if own.as_ref().is_none_or(|own| goes_beyond(&later, own)) {
        *own = Some(later);
    }
}
