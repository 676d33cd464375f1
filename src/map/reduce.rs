//! Statistics of a map that is too long to read: extremes, means, quantiles and histograms of each
//! mode, gathered as the poses go by.
//!
//! Values are counted in bins whose edges are doubles with 14 bits after the point: 2⁻¹⁴ of a power
//! of two wide, at most 0.0061 % of the frequency. Quantiles of few poses are exact. Poses come in
//! their order, so the same poses give the same bits whatever the number of threads.

use rayon::prelude::*;
use serde::Serialize;

use super::Block;
use crate::units::written;

/// Quantiles that are found.
pub const SHARES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// Poses up to which all frequencies are kept, and quantiles are exact.
pub const EXACT_UP_TO: usize = 65_536;

/// Widest bin as a share of the frequencies in it.
pub const RESOLUTION: f64 = 1.0 / OCTAVE as f64;

/// Bins from one power of two to the next.
const OCTAVE: usize = 1 << OCTAVE_BITS;
const OCTAVE_BITS: u32 = 14;

/// Bits of a double below those that number the bin.
const BELOW_BIN: u32 = f64::MANTISSA_DIGITS - 1 - OCTAVE_BITS;

/// Statistics of a reduced map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

/// A frequency and the first pose that has it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Extreme {
    /// Hz.
    pub frequency_hz: f64,
    /// Place of the pose, from zero.
    #[serde(serialize_with = "written::from_one")]
    pub pose: usize,
    /// Joint positions, rad or m, base to tip.
    pub joints: Vec<f64>,
    /// β2 of the two-link model, where the robot defines it, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beta2_rad: Option<f64>,
}

/// A band of a histogram.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bin {
    /// Lower end, within, Hz.
    pub from_hz: f64,
    /// Upper end, without, Hz.
    pub to_hz: f64,
    /// Poses in it.
    pub poses: u64,
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

/// Gathers the statistics of a map.
#[derive(Debug, Clone)]
pub struct Reduction {
    joints: usize,
    poses: usize,
    modes: Vec<Gathered>,
}

impl Reduction {
    /// For poses of so many joints and modes.
    pub fn new(joints: usize, modes: usize) -> Self {
        Self { joints, poses: 0, modes: vec![Gathered::default(); modes] }
    }

    /// Takes in the next poses, in their order; each mode on a thread of its own.
    pub fn add(&mut self, blocks: &[&Block]) {
        let (joints, before, count) = (self.joints, self.poses, self.modes.len());
        let all = before + blocks.iter().map(|block| block.count).sum::<usize>();
        self.modes.par_iter_mut().enumerate().for_each(|(mode, gathered)| {
            if all > EXACT_UP_TO {
                gathered.kept = Vec::new();
            }
            let mut first = before;
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
#[derive(Debug, Clone, Default)]
struct Gathered {
    min: Option<Extreme>,
    max: Option<Extreme>,
    sum: Sum,
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
            self.sum.add(f);
            self.bins.count(f);
        }
        if let Some(at) = min_at {
            self.min = Some(pose(at));
        }
        if let Some(at) = max_at {
            self.max = Some(pose(at));
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
        let mean_hz = within(self.sum.value() / poses as f64);
        Some(ReducedMode { min, max, mean_hz, quantiles_hz, histogram })
    }
}

/// A sum that does not lose what is small (Neumaier, ZAMM 54, 1974).
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    fn add(&mut self, x: f64) {
        let sum = self.high + x;
        // Knuth's exact rounding error of a sum: no branches.
        let part = sum - self.high;
        self.low += (self.high - (sum - part)) + (x - part);
        self.high = sum;
    }

    fn value(self) -> f64 {
        self.high + self.low
    }
}

/// Counts of values, octave by octave.
#[derive(Debug, Clone, Default)]
struct Bins {
    /// By exponent; empty where nothing was counted.
    octaves: Vec<Vec<u64>>,
}

/// Number of the bin of a value that is not negative; ascending with the value.
fn bin_of(value: f64) -> usize {
    (value.to_bits() >> BELOW_BIN) as usize & (OCTAVE * 2048 - 1)
}

/// Lower end of a bin.
fn edge(bin: usize) -> f64 {
    f64::from_bits((bin as u64) << BELOW_BIN)
}

impl Bins {
    #[inline]
    fn count(&mut self, value: f64) {
        let bin = bin_of(value);
        let octave = bin / OCTAVE;
        if let Some(count) = self.octaves.get_mut(octave).and_then(|o| o.get_mut(bin % OCTAVE)) {
            *count += 1;
        } else {
            self.open(octave)[bin % OCTAVE] += 1;
        }
    }

    #[cold]
    fn open(&mut self, octave: usize) -> &mut [u64] {
        if self.octaves.len() <= octave {
            self.octaves.resize(octave + 1, Vec::new());
        }
        self.octaves[octave] = vec![0; OCTAVE];
        &mut self.octaves[octave]
    }

    /// Bins that hold something, with their counts, in ascending order.
    fn filled(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        self.octaves.iter().enumerate().flat_map(|(octave, bins)| {
            let counted = bins.iter().enumerate().filter(|(_, count)| **count > 0);
            counted.map(move |(bin, &count)| (octave * OCTAVE + bin, count))
        })
    }

    /// The value with so many values below it, as if values lay evenly in their bin.
    fn value(&self, rank: u64) -> f64 {
        let mut before = 0;
        for (bin, count) in self.filled() {
            if rank < before + count {
                let share = ((rank - before) as f64 + 0.5) / count as f64;
                return edge(bin) + (edge(bin + 1) - edge(bin)) * share;
            }
            before += count;
        }
        f64::INFINITY
    }

    /// Up to 48 bands of as many bins each, a power of two, so that the bands' ends are ends of
    /// bins.
    fn histogram(&self, min: f64, max: f64) -> Vec<Bin> {
        let (low, high) = (bin_of(min), bin_of(max));
        let mut shift = 0;
        while (high >> shift) - (low >> shift) >= 48 {
            shift += 1;
        }
        let first = low >> shift;
        let mut bands: Vec<Bin> = (first..=high >> shift)
            .map(|band| Bin {
                from_hz: edge(band << shift),
                to_hz: edge((band + 1) << shift),
                poses: 0,
            })
            .collect();
        for (bin, count) in self.filled() {
            bands[(bin >> shift) - first].poses += count;
        }
        bands
    }
}
