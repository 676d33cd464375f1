//! Whether a pole of a random response stands out of the spectrum around it. Poles that keep their
//! place as the order rises are found in noise, too, the more responses there are: what counts is
//! how much louder the responses are within its half-power band than on either side, in the
//! combination of responses in which that is most.

use nalgebra::DMatrix;

use super::super::block::C64;

/// Half the width of the band is the decay rate; from so many of these away on, for so many, lines
/// are what it must stand out of.
const AWAY: f64 = 3.0;
const REACH: f64 = 5.0;

/// Spectra under a Hann window, whose neighbouring lines share their values: two count as one.
pub(super) struct Spectra<'s> {
    /// By response.
    pub(super) lines: &'s [Vec<C64>],
    /// From line to line, rad/s.
    pub(super) spacing: f64,
    /// Where modes are looked for, rad/s.
    pub(super) band: [f64; 2],
}

impl Spectra<'_> {
    /// Whether a pole stands out of the lines on either side that no other pole is near.
    pub(super) fn show(&self, pole: C64, others: &[C64]) -> bool {
        let half = self.half(pole);
        let own = self.within(pole.norm() - half, pole.norm() + half);
        let count = self.lines.len();
        // Fewer lines say too little of noise in so many responses.
        let wanted = (REACH * half / self.spacing).ceil().max((16 * count + 8) as f64) as usize;
        let is_free = |k: &usize| {
            let omega = *k as f64 * self.spacing;
            others.iter().all(|other| (omega - other.norm()).abs() > AWAY * self.half(*other))
        };
        let from = ((pole.norm() - AWAY * half) / self.spacing).max(0.0) as usize;
        let below: Vec<usize> = (1..from).rev().filter(is_free).take(wanted).collect();
        let to = ((pole.norm() + AWAY * half) / self.spacing).ceil() as usize;
        let all = self.lines.first().map_or(0, |own| own.len().saturating_sub(1));
        let above: Vec<usize> = (to..all).filter(is_free).take(wanted).collect();
        // At an end of the spectrum one side must do.
        let longest = below.len().max(above.len());
        let mut sides = [below, above].into_iter().filter(|side| 2 * side.len() >= longest);
        longest > 4 * count && sides.all(|side| self.exceeds(&own, &side, half))
    }

    fn half(&self, pole: C64) -> f64 {
        pole.re.abs().max(1.5 * self.spacing)
    }

    fn within(&self, from: f64, to: f64) -> Vec<usize> {
        let all = self.lines.first().map_or(0, Vec::len);
        let first = (from / self.spacing).ceil().max(1.0) as usize;
        (first..all).take_while(|k| *k as f64 * self.spacing <= to).collect()
    }

    /// Whether the largest power ratio over all combinations of responses is more than noise makes
    /// anywhere in the band: of n independent lines of l responses it exceeds
    /// (1 + √(l/n) + √(x/n))² with a probability of at most e^(−x), and the least of m lines is
    /// about (1 − √(l/m))² (Davidson & Szarek, Handbook of the geometry of Banach spaces I, 2001,
    /// II.13).
    fn exceeds(&self, own: &[usize], side: &[usize], half: f64) -> bool {
        /// Probability that noise alone does so anywhere in a record.
        const FALSE_ALARM: f64 = 0.01;
        /// Places and widths that a pole may have, as a multiple of how often it fits in the band.
        const TRIALS: f64 = 4.0;
        let count = self.lines.len() as f64;
        let [n, m] = [own.len(), side.len()].map(|lines| (0.5 * lines as f64).max(1.0));
        let places = TRIALS * ((self.band[1] - self.band[0]) / (2.0 * half)).max(1.0);
        let x = (places / FALSE_ALARM).ln();
        let most = 1.0 + (count / n).sqrt() + (x / n).sqrt();
        let least = (1.0 - (count / m).sqrt()).max(0.1);
        self.ratio(own, side).is_some_and(|ratio| ratio > (most / least).powi(2))
    }

    /// Largest power on some lines relative to that on others, over combinations of responses.
    fn ratio(&self, own: &[usize], side: &[usize]) -> Option<f64> {
        let mut around = self.power(side);
        // Each response in its own unit.
        for i in 0..around.nrows() {
            around[(i, i)] *= 1.0 + 1e-9;
        }
        let factor = around.cholesky()?.l();
        let half = factor.solve_lower_triangular(&self.power(own))?;
        let whole = factor.solve_lower_triangular(&half.adjoint())?;
        let values = whole.symmetric_eigenvalues();
        values.iter().copied().reduce(f64::max)
    }

    /// Mean of x xᴴ over lines.
    fn power(&self, lines: &[usize]) -> DMatrix<C64> {
        let count = self.lines.len();
        DMatrix::from_fn(count, count, |i, j| {
            let products = lines.iter().map(|&k| self.lines[i][k] * self.lines[j][k].conj());
            products.sum::<C64>() / lines.len().max(1) as f64
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tone in two of three responses of noise, one of them in a unit a million times as large.
    #[test]
    fn units_of_responses_do_not_count() {
        let noise = |k: usize, i: usize| {
            let turn = 1e4 * ((k * k + 17 * i * k) as f64).sin();
            C64::from_polar(1.0 + 0.5 * (0.3 * turn).sin(), turn)
        };
        let ratio = |unit: f64| {
            let line = |k: usize, i: usize| {
                let tone = if k < 20 && i > 0 { C64::new(3.0, 0.0) } else { C64::default() };
                (noise(k, i) + tone) * if i == 1 { unit } else { 1.0 }
            };
            let lines: Vec<Vec<C64>> =
                (0..3).map(|i| (0..200).map(|k| line(k, i)).collect()).collect();
            let spectra = Spectra { lines: &lines, spacing: 1.0, band: [0.0, 200.0] };
            let (own, side): (Vec<usize>, Vec<usize>) = ((0..20).collect(), (20..200).collect());
            spectra.ratio(&own, &side).unwrap()
        };
        assert!(ratio(1.0) > 10.0, "{}", ratio(1.0));
        assert!((ratio(1e-6) / ratio(1.0) - 1.0).abs() < 1e-6, "{} {}", ratio(1e-6), ratio(1.0));
    }
}
