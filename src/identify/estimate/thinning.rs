//! Fewer lines for the same least squares. Away from modes, responses that an analyser made are
//! straight over many lines. Of such a bin two lines stay, each with the mean of half of the bin's
//! lines, so to speak: at Gauss's points ω̄ ± σ, with the values of the straight line that fits the
//! bin best. Sums of squares then differ as they do over all lines, for whatever is straight there.

use super::block::{Block, C64, Pole};
use super::noise::Noise;

/// Blocks of fewer lines with their noise, for poles that move little.
pub(super) struct Thinned {
    pub(super) blocks: Vec<Block>,
    pub(super) noise: Noise,
}

impl Thinned {
    /// `None` where it is not worth it. Spectra of records stay: they turn from line to line with
    /// the time at which the force begins.
    pub(super) fn of(blocks: &[Block], noise: &Noise, poles: &[Pole]) -> Option<Self> {
        let thinned = |(block, noise): (&Block, &Vec<Vec<f64>>)| {
            let is_ready = block.is_given() && poles.iter().all(|pole| block.admits(pole));
            is_ready.then(|| thinned(block, noise, poles)).flatten()
        };
        let (blocks, noise) =
            blocks.iter().zip(noise).map(thinned).collect::<Option<Vec<_>>>()?.into_iter().unzip();
        Some(Self { blocks, noise })
    }
}

fn thinned(block: &Block, noise: &[Vec<f64>], poles: &[Pole]) -> Option<(Block, Vec<Vec<f64>>)> {
    /// Fewer are fitted as fast as they are thinned.
    const MIN_LINES: usize = 500;
    /// Of the lines, those that may stay.
    const SHARE: f64 = 0.5;
    let lines = block.omega.len();
    if lines < MIN_LINES {
        return None;
    }
    let weights = weights(noise, lines);
    let mut losses = Losses::new(lines);
    for pole in poles {
        let of = block.contribution(pole, pole.is_driven);
        let slopes = of.slopes.iter().map(|[slope, _]| slope);
        std::iter::once(&of.value[0]).chain(slopes).for_each(|own| losses.add(own, &weights));
    }
    block.background().iter().for_each(|own| losses.add(own, &weights));
    let bins = losses.bins();
    let stay = bins.iter().map(|bin| bin.lines.len().min(2)).sum::<usize>();
    if stay as f64 > SHARE * lines as f64 {
        return None;
    }
    let over = |of: &dyn Fn(&Bin) -> Vec<f64>| bins.iter().flat_map(of).collect::<Vec<f64>>();
    let spectrum = |own: &Vec<C64>| -> Vec<C64> {
        let re = over(&|bin| bin.values(&block.omega, |k| own[k].re));
        let im = over(&|bin| bin.values(&block.omega, |k| own[k].im));
        re.into_iter().zip(im).map(|(re, im)| C64::new(re, im)).collect()
    };
    let thinned = Block {
        omega: over(&|bin| bin.values(&block.omega, |k| block.omega[k])),
        spectra: block.spectra.iter().map(spectrum).collect(),
        ..block.clone()
    };
    Some((thinned, noise.iter().map(|own| over(&|bin| bin.variances(own))).collect()))
}

/// Of each line, over all responses.
fn weights(noise: &[Vec<f64>], lines: usize) -> Vec<f64> {
    let mut powers = vec![0.0; lines];
    for own in noise {
        let whole: f64 = own.iter().map(|variance| variance.recip()).sum();
        powers.iter_mut().zip(own).for_each(|(sum, variance)| *sum += (variance * whole).recip());
    }
    powers.into_iter().map(f64::sqrt).collect()
}

/// Neighbouring lines over which everything is straight; few lines stay as they are.
struct Bin {
    lines: std::ops::Range<usize>,
}

impl Bin {
    /// Values at both points of the straight line nearest to values on the lines.
    fn values(&self, omega: &[f64], of: impl Fn(usize) -> f64) -> Vec<f64> {
        let lines = self.lines.clone();
        if lines.len() <= 2 {
            return lines.map(of).collect();
        }
        let count = lines.len() as f64;
        let middle = omega[lines.clone()].iter().sum::<f64>() / count;
        let [mut mean, mut along, mut spread] = [0.0; 3];
        for k in lines {
            let (apart, value) = (omega[k] - middle, of(k));
            mean += value / count;
            along += apart * value;
            spread += apart * apart;
        }
        let rise = along / (spread * count).sqrt();
        vec![mean - rise, mean + rise]
    }

    fn variances(&self, of: &[f64]) -> Vec<f64> {
        let own = &of[self.lines.clone()];
        if own.len() <= 2 {
            return own.to_vec();
        }
        let count = own.len() as f64;
        vec![own.iter().sum::<f64>() / count * 2.0 / count; 2]
    }
}

/// Of a column over neighbouring lines.
#[derive(Clone, Copy)]
struct Moments {
    sum: f64,
    /// About the middle.
    slope: f64,
    energy: f64,
}

impl Moments {
    fn of(values: &[f64]) -> Self {
        let middle = 0.5 * (values.len() as f64 - 1.0);
        let mut of = Self { sum: 0.0, slope: 0.0, energy: 0.0 };
        for (k, value) in values.iter().enumerate() {
            of.sum += value;
            of.slope += (k as f64 - middle) * value;
            of.energy += value * value;
        }
        of
    }

    /// Over both of two stretches of as many lines each.
    fn with(self, next: Self, lines: f64) -> Self {
        Self {
            sum: self.sum + next.sum,
            slope: self.slope + next.slope + 0.5 * lines * (next.sum - self.sum),
            energy: self.energy + next.energy,
        }
    }

    /// Energy that is not straight.
    fn bent(self, lines: f64) -> f64 {
        let spread = lines * (lines * lines - 1.0) / 12.0;
        self.energy - self.sum * self.sum / lines - self.slope * self.slope / spread
    }
}

/// What bins of 4, 8, 16, … lines would lose of the columns, each relative to its energy.
struct Losses {
    lines: usize,
    by_size: Vec<Vec<f64>>,
}

impl Losses {
    /// Fewest lines of a bin.
    const FIRST: usize = 4;

    fn new(lines: usize) -> Self {
        let sizes = std::iter::successors(Some(Self::FIRST), |size| Some(2 * size));
        let counts = sizes.map(|size| lines / size).take_while(|count| *count > 0);
        Self { lines, by_size: counts.map(|count| vec![0.0; count]).collect() }
    }

    fn add(&mut self, column: &[C64], weights: &[f64]) {
        let part = |of: fn(&C64) -> f64| -> Vec<f64> {
            column.iter().zip(weights).map(|(value, weight)| of(value) * weight).collect()
        };
        let parts = [part(|value| value.re), part(|value| value.im)];
        let energy: f64 = parts.iter().flatten().map(|value| value * value).sum();
        if energy <= 0.0 {
            return;
        }
        for part in parts {
            let of = |few: &[f64]| Moments::of(few);
            let mut moments: Vec<Moments> = part.chunks_exact(Self::FIRST).map(of).collect();
            let mut lines = Self::FIRST as f64;
            for losses in &mut self.by_size {
                for (loss, moments) in losses.iter_mut().zip(&moments) {
                    *loss += moments.bent(lines) / energy;
                }
                let pairs = moments.chunks_exact(2).map(|pair| pair[0].with(pair[1], lines));
                moments = pairs.collect();
                lines *= 2.0;
            }
        }
    }

    /// The largest bins that lose little.
    fn bins(&self) -> Vec<Bin> {
        /// Of all columns, over all bins.
        const LOST: f64 = 1e-4;
        let size_at = |level: usize| Self::FIRST << level;
        let mut bins: Vec<Bin> = Vec::new();
        let mut line = 0;
        while line < self.lines {
            let fits = |&level: &usize| {
                let size = size_at(level);
                let loss = self.by_size[level].get(line / size);
                let allowed = LOST * size as f64 / self.lines as f64;
                line.is_multiple_of(size) && loss.is_some_and(|loss| *loss <= allowed)
            };
            let level = (0..self.by_size.len()).rev().find(fits);
            let end = line + level.map_or(1, size_at);
            bins.push(Bin { lines: line..end });
            line = end;
        }
        bins
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::block::Origin;
    use super::super::fit::{FULL, Fit};
    use super::*;

    const LINES: usize = 6000;

    fn response(lambda: C64, omega: f64) -> C64 {
        (C64::new(0.0, omega) - lambda).inv()
    }

    /// Two modes, one of them hardly wider than a line, in noise that is known.
    fn measured(poles: &[Pole], deviation: f64) -> (Vec<Block>, Noise) {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut noise = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
        let omega: Vec<f64> = (0..LINES).map(|k| 0.1 * (k as f64 + 500.0)).collect();
        let shapes =
            [[C64::new(2.0, 0.3), C64::new(1.0, -0.5)], [C64::new(0.2, 0.1), C64::from(0.5)]];
        let value = |shape: &[C64; 2], omega: f64| -> C64 {
            let mode = |(factor, pole): (&C64, &Pole)| {
                factor * response(pole.lambda, omega)
                    + factor.conj() * response(pole.lambda.conj(), omega)
            };
            shape.iter().zip(poles).map(mode).sum()
        };
        let spectrum = |shape: &[C64; 2]| {
            let noisy = |w: &f64| value(shape, *w) + C64::new(noise(), noise()) * deviation;
            omega.iter().map(noisy).collect()
        };
        let spectra: Vec<Vec<C64>> = shapes.iter().map(spectrum).collect();
        let variances = vec![vec![2.0 * deviation * deviation; LINES]; 2];
        (vec![Block::new(Origin::Responses { hann_s: None }, omega, spectra)], vec![variances])
    }

    /// The same least squares over all lines and over those that stay: sums of squares differ by as
    /// much between poles, and the least lies where the other does.
    #[test]
    fn what_stays_tells_as_much_as_all_lines() {
        let truth = [Pole::from_modal(200.0, 0.001), Pole::from_modal(410.0, 0.02)];
        let (blocks, noise) = measured(&truth, 0.02);
        let Thinned { blocks: few, noise: of_few } = Thinned::of(&blocks, &noise, &truth).unwrap();
        let stay = few[0].omega.len();
        assert!(10 * stay < LINES, "{stay}");
        assert!(few[0].omega.is_sorted());
        let moved: Vec<Pole> = truth.iter().map(|pole| pole.moved(&[0.01, -0.02])).collect();
        let sum = |blocks: &[Block], noise: &Noise, poles: &[Pole]| {
            Fit::at(blocks, noise.clone(), poles.to_vec()).unwrap().evaluation.sum_of_squares
        };
        let [all, fewer] = [(&blocks, &noise), (&few, &of_few)]
            .map(|(blocks, noise)| sum(blocks, noise, &moved) - sum(blocks, noise, &truth));
        assert!(all > 100.0 && (fewer / all - 1.0).abs() < 1e-3, "{all} {fewer}");
        let least = |blocks: &[Block], noise: &Noise| {
            Fit::at(blocks, noise.clone(), moved.clone()).unwrap().descended(blocks, FULL)
        };
        let (all, fewer) = (least(&blocks, &noise), least(&few, &of_few));
        let covariance = all.covariance().unwrap();
        for (at, (one, other)) in all.poles.iter().zip(&fewer.poles).enumerate() {
            let deviation = covariance[(2 * at, 2 * at)].sqrt();
            let apart = (one.lambda - other.lambda).norm();
            // What is lost is a ten-thousandth: both differ by a hundredth of it.
            assert!(apart < 0.03 * deviation, "pole {at}: {apart} of {deviation}");
        }
    }

    /// Lines that are all near a mode stay, and so do few lines.
    #[test]
    fn lines_that_tell_more_each_stay() {
        let wide = [Pole::from_modal(300.0, 0.3), Pole::from_modal(320.0, 0.3)];
        let (blocks, noise) = measured(&wide, 0.02);
        let mut rough = noise.clone();
        rough[0][0].iter_mut().step_by(2).for_each(|variance| *variance *= 9.0);
        assert!(Thinned::of(&blocks, &rough, &wide).is_none());
        let few = vec![Block { omega: blocks[0].omega[..400].to_vec(), ..blocks[0].clone() }];
        assert!(Thinned::of(&few, &noise, &wide).is_none());
    }
}
