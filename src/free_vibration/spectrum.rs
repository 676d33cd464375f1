//! Spectra of sampled vibration, and the frequencies of their peaks.
//!
//! Window: four-term Blackman–Harris (Harris, Proc. IEEE 66, 1978): side lobes 92 dB down, so that
//! a mode does not hide another of equal energy anywhere beyond its main lobe of ±4 bins. The
//! spectrum for peaks is padded with zeros to at least four times its length; a peak is the vertex
//! of the parabola through the logarithms of its three highest points. On noise-free tones that
//! stand eight bins from each other and from zero this errs by less than 1/1000 of a bin 1/T.

use realfft::RealFftPlanner;

/// Harris's minimum four-term window.
const WINDOW: [f64; 4] = [0.35875, -0.48829, 0.14128, -0.01168];

/// Main lobe of the window to either side, in bins of 1/T.
const MAIN_LOBE_BINS: f64 = 4.0;

/// How much finer than 1/T the spectrum for peaks is.
const PADDING: usize = 4;

/// One-sided amplitude spectrum of one or more records.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Distance from one line to the next, 1/T, Hz; line k is at k/T.
    pub bin_hz: f64,
    /// For each record the amplitude of each line, in the record's unit: a tone on a line shows its
    /// own amplitude.
    pub amplitudes: Vec<Vec<f64>>,
}

/// Amplitude spectra of `records` (equal length, one value per sample), up to half the rate.
pub fn spectrum(records: &[Vec<f64>], sample_rate_hz: f64) -> Spectrum {
    let length = records.first().map_or(0, Vec::len);
    let amplitudes = records.iter().map(|record| magnitudes(record, length)).collect();
    Spectrum { bin_hz: sample_rate_hz / length.max(1) as f64, amplitudes }
}

/// The highest peaks of a spectrum.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Peaks {
    /// Hz, ascending.
    pub(super) peaks_hz: Vec<f64>,
    /// Height of the highest peak that was not wanted, as a share of the lowest one that was; 0
    /// without.
    pub(super) runner_up_share: f64,
}

/// The `count` highest peaks of Σ weight·|spectrum|² over `records`.
///
/// Fewer are returned where fewer local maxima reach `floor` times the highest: modes closer than
/// the main lobe melt into one peak.
pub(super) fn peaks(
    records: &[Vec<f64>],
    weights: &[f64],
    sample_rate_hz: f64,
    count: usize,
    floor: f64,
) -> Peaks {
    let length = records.first().map_or(0, Vec::len);
    if length == 0 {
        return Peaks { peaks_hz: Vec::new(), runner_up_share: 0.0 };
    }
    let padded = (length * PADDING).next_power_of_two();
    let mut energy = vec![0.0; padded / 2 + 1];
    for (record, weight) in records.iter().zip(weights) {
        for (sum, magnitude) in energy.iter_mut().zip(magnitudes(record, padded)) {
            *sum += weight * magnitude * magnitude;
        }
    }
    let per_bin = padded as f64 / length as f64;
    let highest = energy.iter().fold(0.0_f64, |a, &b| a.max(b));
    let mut maxima: Vec<(f64, f64)> = energy
        .windows(3)
        .enumerate()
        .filter(|(_, w)| w[1] > w[0] && w[1] >= w[2] && w[1] > floor * highest)
        .map(|(i, w)| (w[1], (i + 1) as f64 + vertex(w[0].ln(), w[1].ln(), w[2].ln())))
        // A constant part of the record, and rounding at the ends.
        .filter(|&(_, at)| at > 0.5 * MAIN_LOBE_BINS * per_bin)
        .collect();
    maxima.sort_by(|a, b| b.0.total_cmp(&a.0));
    let runner_up_share =
        match (count.checked_sub(1).and_then(|i| maxima.get(i)), maxima.get(count)) {
            (Some((lowest, _)), Some((next, _))) => next / lowest,
            (_, None) | (None, _) => 0.0,
        };
    maxima.truncate(count);
    let mut peaks_hz: Vec<f64> =
        maxima.iter().map(|&(_, at)| at * sample_rate_hz / padded as f64).collect();
    peaks_hz.sort_by(f64::total_cmp);
    Peaks { peaks_hz, runner_up_share }
}

/// Abscissa of the vertex of the parabola through three equally spaced values, from the middle one.
fn vertex(left: f64, middle: f64, right: f64) -> f64 {
    let bend = left - 2.0 * middle + right;
    let shift = 0.5 * (left - right) / bend;
    if shift.is_finite() { shift } else { 0.0 }
}

/// Magnitudes of the windowed record, padded with zeros to `length`, scaled to amplitudes.
fn magnitudes(record: &[f64], length: usize) -> Vec<f64> {
    let n = record.len();
    if n == 0 || length < n {
        return Vec::new();
    }
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let mut input = transform.make_input_vec();
    for (i, (slot, value)) in input.iter_mut().zip(record).enumerate() {
        let phase = std::f64::consts::TAU * i as f64 / n as f64;
        let window: f64 =
            WINDOW.iter().enumerate().map(|(k, c)| c * (k as f64 * phase).cos()).sum();
        *slot = window * value;
    }
    let mut output = transform.make_output_vec();
    // The lengths are the transform's own, so it cannot refuse them.
    if transform.process(&mut input, &mut output).is_err() {
        return Vec::new();
    }
    let scale = 2.0 / (WINDOW[0] * n as f64);
    output.iter().map(|line| scale * line.norm()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn tones(tones: &[(f64, f64, f64)], rate: f64, n: usize) -> Vec<f64> {
        (0..n)
            .map(|i| {
                let t = i as f64 / rate;
                tones.iter().map(|(a, f, phase)| a * (TAU * f * t + phase).cos()).sum()
            })
            .collect()
    }

    /// Tones at every fraction of a bin, the nearest neighbour eight bins off and ten times as
    /// loud.
    #[test]
    fn peaks_lie_within_a_thousandth_of_a_bin() {
        let (rate, n) = (1000.0, 1500);
        let bin = rate / n as f64;
        for i in 0..97 {
            let f = (8.0 + f64::from(i) / 97.0) * bin;
            let next = f + 8.0 * bin;
            let record = tones(&[(1.0, f, 0.1 * f64::from(i)), (10.0, next, 1.3)], rate, n);
            let found = peaks(&[record], &[1.0], rate, 2, 1e-4).peaks_hz;
            assert_eq!(found.len(), 2);
            for (a, b) in found.iter().zip([f, next]) {
                assert!((a - b).abs() < 1e-3 * bin, "{a} against {b}, bin {bin}");
            }
        }
    }

    #[test]
    fn a_tone_on_a_line_shows_its_amplitude() {
        let record = tones(&[(0.25, 12.0, 0.7), (3.0, 40.0, 0.0)], 140.0, 700);
        let found = spectrum(&[record], 140.0);
        assert!((found.bin_hz - 0.2).abs() < 1e-15);
        assert_eq!(found.amplitudes[0].len(), 351);
        assert!((found.amplitudes[0][60] - 0.25).abs() < 1e-4);
        assert!((found.amplitudes[0][200] - 3.0).abs() < 1e-4);
    }

    #[test]
    fn the_runner_up_is_told_by_its_share() {
        let of = |third: f64, count| {
            let all = [(1.0, 20.0, 0.0), (0.5, 40.0, 0.3), (third, 60.0, 0.0)];
            peaks(&[tones(&all, 200.0, 2000)], &[1.0], 200.0, count, 1e-4)
        };
        let two = of(0.25, 2);
        assert_eq!(two.peaks_hz.len(), 2);
        assert!((two.runner_up_share - 0.25).abs() < 1e-3, "{two:?}");
        assert_eq!(of(0.25, 3).runner_up_share, 0.0);
        assert_eq!(of(0.001, 2).runner_up_share, 0.0);
    }

    /// Two tones one bin apart are one peak: none is invented.
    #[test]
    fn tones_too_close_to_part_are_one_peak() {
        let record = tones(&[(1.0, 20.0, 0.0), (1.0, 20.05, 0.0)], 200.0, 2000);
        assert_eq!(peaks(&[record], &[1.0], 200.0, 2, 0.01).peaks_hz.len(), 1);
    }
}
