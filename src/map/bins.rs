//! Counts and sums of values that do not depend on the order in which they come.

use serde::{Deserialize, Serialize};

/// Bins from one power of two to the next.
pub(super) const OCTAVE: usize = 1 << OCTAVE_BITS;
const OCTAVE_BITS: u32 = 14;

/// Octaves of all doubles that are not negative.
const OCTAVES: usize = 1 << 11;

/// No map spans more: from a millionth of a hertz to beyond 10¹² Hz.
const MAX_OCTAVES: usize = 64;

/// Bits of a double below those that number the bin.
const BELOW_BIN: u32 = MANTISSA_BITS - OCTAVE_BITS;

/// Bits of a double behind its exponent.
const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;

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

/// Counts of values and their sum, octave by octave.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(into = "Filled", try_from = "Filled")]
pub(super) struct Bins {
    /// By exponent.
    octaves: Vec<Octave>,
}

/// The values between two powers of two.
#[derive(Debug, Clone, Default, PartialEq)]
struct Octave {
    /// Bin by bin; empty where nothing was counted.
    counts: Vec<u64>,
    /// Sum of the values in units of the last place: exact, whatever the order.
    sum: u128,
}

/// The bins that hold something.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Filled {
    /// Number of the bin, and how many values lie in it; ascending.
    bins: Vec<(usize, u64)>,
    /// Number of the octave, and the sum of its values in units of the last place, in decimal:
    /// more than other programs' numbers hold. Ascending.
    sums: Vec<(usize, String)>,
}

impl From<Bins> for Filled {
    fn from(bins: Bins) -> Self {
        let sums = bins.octaves.iter().enumerate().filter(|(_, octave)| octave.sum > 0);
        Self {
            sums: sums.map(|(number, octave)| (number, octave.sum.to_string())).collect(),
            bins: bins.filled().collect(),
        }
    }
}

impl TryFrom<Filled> for Bins {
    type Error = String;

    fn try_from(filled: Filled) -> Result<Self, String> {
        let mut bins = Self::default();
        let ascends = filled.bins.windows(2).all(|pair| pair[0].0 < pair[1].0)
            && filled.sums.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let octaves = filled.bins.chunk_by(|a, b| a.0 / OCTAVE == b.0 / OCTAVE).count();
        let is_known = octaves <= MAX_OCTAVES
            && filled.bins.iter().all(|(bin, count)| *bin < OCTAVE * OCTAVES && *count > 0)
            && filled.sums.iter().all(|(octave, _)| *octave < OCTAVES);
        if !(ascends && is_known) {
            return Err("bins must be counted, ascend and be those of doubles".to_owned());
        }
        for (bin, count) in filled.bins {
            bins.open(bin / OCTAVE).counts[bin % OCTAVE] = count;
        }
        for (octave, sum) in filled.sums {
            let sum: u128 = sum.parse().map_err(|_| format!("'{sum}' is no sum of values"))?;
            bins.open(octave).sum = sum;
        }
        for (number, octave) in bins.octaves.iter().enumerate() {
            octave.check(number)?;
        }
        Ok(bins)
    }
}

impl Octave {
    /// Whether counts and sum can belong together: each value lies within its bin.
    fn check(&self, number: usize) -> Result<(), String> {
        let low = |bin: usize| u128::from(mantissa(edge(number * OCTAVE + bin)));
        let width = 1_u128 << BELOW_BIN;
        let (mut least, mut most) = (0_u128, 0_u128);
        for (bin, &count) in self.counts.iter().enumerate() {
            let times = |value: u128| value.saturating_mul(u128::from(count));
            least = least.saturating_add(times(low(bin)));
            most = most.saturating_add(times(low(bin) + width - 1));
        }
        let fits = (least..=most).contains(&self.sum);
        fits.then_some(()).ok_or_else(|| "a sum is not one of the values counted".to_owned())
    }
}

/// Number of the bin of a value that is not negative; ascending with the value.
pub(super) fn bin_of(value: f64) -> usize {
    (value.to_bits() >> BELOW_BIN) as usize & (OCTAVE * OCTAVES - 1)
}

/// Lower end of a bin.
fn edge(bin: usize) -> f64 {
    f64::from_bits((bin as u64) << BELOW_BIN)
}

/// A value in units of its last place.
fn mantissa(value: f64) -> u64 {
    let bits = value.to_bits();
    let hidden = u64::from(bits >> MANTISSA_BITS & 0x7FF != 0) << MANTISSA_BITS;
    bits & ((1 << MANTISSA_BITS) - 1) | hidden
}

/// The unit of the last place of the values in an octave.
fn last_place(octave: usize) -> f64 {
    // Below the smallest normal number the places get no finer.
    f64::from_bits((octave.max(1) as u64) << MANTISSA_BITS) / (1_u64 << MANTISSA_BITS) as f64
}

impl Bins {
    /// Of these values.
    pub(super) fn of(values: &[f64]) -> Self {
        let mut bins = Self::default();
        values.iter().for_each(|value| bins.count(*value));
        bins
    }

    /// The lowest and the highest bin that hold something.
    pub(super) fn range(&self) -> Option<[usize; 2]> {
        let mut filled = self.filled().map(|(bin, _)| bin);
        let first = filled.next()?;
        Some([first, filled.last().unwrap_or(first)])
    }

    #[inline]
    pub(super) fn count(&mut self, value: f64) {
        let bin = bin_of(value);
        let own = match self.octaves.get_mut(bin / OCTAVE) {
            Some(own) if !own.counts.is_empty() => own,
            _ => self.open(bin / OCTAVE),
        };
        own.counts[bin % OCTAVE] += 1;
        own.sum += u128::from(mantissa(value));
    }

    #[cold]
    fn open(&mut self, octave: usize) -> &mut Octave {
        if self.octaves.len() <= octave {
            self.octaves.resize(octave + 1, Octave::default());
        }
        let own = &mut self.octaves[octave];
        if own.counts.is_empty() {
            own.counts = vec![0; OCTAVE];
        }
        own
    }

    /// Takes in the values of others.
    pub(super) fn join(&mut self, later: Self) {
        for (number, later) in later.octaves.into_iter().enumerate() {
            if later.counts.is_empty() {
                continue;
            }
            let own = self.open(number);
            own.sum += later.sum;
            own.counts.iter_mut().zip(later.counts).for_each(|(own, later)| *own += later);
        }
    }

    /// How many values were counted; `None` beyond what can be counted.
    pub(super) fn total(&self) -> Option<u64> {
        self.filled().try_fold(0_u64, |all, (_, count)| all.checked_add(count))
    }

    /// The sum of the values, rounded once at the end: that of each octave is exact, and they are
    /// added without losing what is small (Neumaier, ZAMM 54, 1974).
    pub(super) fn sum(&self) -> f64 {
        let (mut high, mut low) = (0.0, 0.0);
        for (number, octave) in self.octaves.iter().enumerate() {
            for limb in 0..4 {
                // 32 bits of a sum are a double without rounding.
                let bits = (octave.sum >> (32 * limb)) as u32;
                let x = f64::from(bits) * last_place(number) * (1_u128 << (32 * limb)) as f64;
                let sum: f64 = high + x;
                let part = sum - high;
                low += (high - (sum - part)) + (x - part);
                high = sum;
            }
        }
        high + low
    }

    /// Bins that hold something, with their counts, in ascending order.
    fn filled(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        self.octaves.iter().enumerate().flat_map(|(octave, own)| {
            let counted = own.counts.iter().enumerate().filter(|(_, count)| **count > 0);
            counted.map(move |(bin, &count)| (octave * OCTAVE + bin, count))
        })
    }

    /// The value with so many values below it, as if values lay evenly in their bin.
    pub(super) fn value(&self, rank: u64) -> f64 {
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
    pub(super) fn histogram(&self, min: f64, max: f64) -> Vec<Bin> {
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
            if let Some(band) = (bin >> shift).checked_sub(first).and_then(|b| bands.get_mut(b)) {
                band.poses += count;
            }
        }
        bands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_exact_in_any_order_and_in_parts() {
        // Added one by one in doubles, 0.1 a hundred thousand times and a million is not this.
        let mut values = vec![0.1; 100_000];
        values.push(1e6);
        let whole = Bins::of(&values);
        assert_ne!(values.iter().sum::<f64>(), 1_010_000.0);
        assert_eq!(whole.sum(), 1_010_000.0);
        values.reverse();
        assert_eq!(Bins::of(&values), whole);
        let (a, b) = values.split_at(777);
        let mut joined = Bins::of(a);
        joined.join(Bins::of(b));
        assert_eq!(joined, whole);
        assert_eq!(Bins::of(&[f64::MIN_POSITIVE, 5e-324, 0.0]).sum(), f64::MIN_POSITIVE + 5e-324);
    }

    #[test]
    fn what_is_written_is_read_back_and_what_cannot_be_is_refused() {
        let bins = Bins::of(&[0.0, 1e-300, 25.75, 25.75, 84.2, 1e9]);
        let text = serde_json::to_string(&bins).unwrap();
        assert_eq!(serde_json::from_str::<Bins>(&text).unwrap(), bins);
        for (from, to) in [("\"bins\":[[0,1]", "\"bins\":[[0,2]"), ("[[0,1]", "[[9,1]")] {
            let wrong = text.replacen(from, to, 1);
            assert_ne!(wrong, text);
            let read = serde_json::from_str::<Bins>(&wrong);
            assert!(read.is_err() || read.unwrap().total() != bins.total(), "{wrong}");
        }
        for wrong in [
            "{\"bins\":[[33554432,1]],\"sums\":[]}",
            "{\"bins\":[[2,1],[1,1]],\"sums\":[]}",
            "{\"bins\":[[16777216,1]],\"sums\":[[1024,\"1\"]]}",
            "{\"bins\":[],\"sums\":[[1024,\"x\"]]}",
        ] {
            assert!(serde_json::from_str::<Bins>(wrong).is_err(), "{wrong}");
        }
    }
}
