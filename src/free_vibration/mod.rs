//! Free vibration of the arm as it is, without linearising: the independent check on
//! [`crate::modes`], and what large amplitudes do to the frequencies. Not for advice.
//!
//! M(α) α̈ + h(α, α̇) + C α̇ + K α + g(α) − g(0) = 0, Eq. (28)/(46) of Pietruś & Gierlak (2023) for
//! any robot. h are the centrifugal and Coriolis torques; C is zero unless damping is asked for; g
//! is the gradient of gravity's potential where the robot has gravity stiffness: the springs are
//! preloaded, so that α = 0 is the equilibrium. The equation is integrated with step control and
//! sampled evenly; frequencies are read from the spectrum of the record, see [`measure`].

mod equation;
mod integrator;
mod spectrum;

pub use spectrum::{Spectrum, spectrum};

use serde::Serialize;

use crate::model::{CoordinateKind, Robot};
use crate::modes::ModalSolver;
use crate::notes::{Code, Note, Place};
use crate::units::{aliased_hz, m_from_mm, rad_from_deg, rad_per_s_from_hz, written};
use equation::Equation;
use integrator::{Integrator, Stop};

/// Samples in a period of the highest mode. The integrator steps about as densely on its own, and
/// up to the fourth harmonic of that mode nothing is aliased.
const SAMPLES_PER_SHORTEST_PERIOD: f64 = 8.0;

/// Least length of an automatic record, in periods of the lowest mode: a thousandth of a bin is
/// then less than 2e-5 of the lowest frequency.
const PERIODS_OF_THE_LOWEST: f64 = 64.0;

/// Least distance of two modes in an automatic record, in bins: both main lobes and room to spare.
const BINS_BETWEEN_MODES: f64 = 10.0;

/// Samples of an automatic record; modes closer than the record can part stay unresolved.
const MAX_AUTOMATIC_SAMPLES: f64 = 262_144.0;

/// Samples of any record.
const MAX_SAMPLES: f64 = 16_777_216.0;

/// A peak lower than this share of the highest, in strain energy, is no mode: all modes start with
/// equal energy, while combination tones of an amplitude a (rad) have some a² of it.
const PEAK_FLOOR: f64 = 0.02;

/// A peak that lies further than this share from its mode's linear frequency may be another's: what
/// amplitude does to a frequency grows with its square, and long before this the motion is no
/// longer a mode.
const MAX_DEPARTURE: f64 = 0.25;

/// A peak that no mode has taken, with more than this share of the strain energy of the lowest that
/// a mode has: harmonics and combination tones are about to take the place of modes.
const RIVAL_SHARE: f64 = 0.25;

/// When the record is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sampling {
    /// As long and as dense as it takes to resolve all modes: eight samples in a period of the
    /// highest mode, 64 periods of the lowest, and ten bins between neighbours as far as 262,144
    /// samples reach.
    Automatic,
    /// As a camera or a recorder would: what lies above half the rate is not seen. 140 Hz for 5 s
    /// is the acquisition of the paper's Section 4.
    Fixed {
        /// Samples per second, Hz.
        sample_rate_hz: f64,
        /// Length of the record, s.
        duration_s: f64,
    },
}

/// How to shake the arm, and how to look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest deflection of any turning coordinate if all modes peak at once, rad.
    pub amplitude_rad: f64,
    /// The same of any sliding coordinate, m, for a robot whose coordinates all slide; its equation
    /// is linear and the number is of no effect on frequencies.
    pub amplitude_m: f64,
    /// Record.
    pub sampling: Sampling,
    /// Error that one step may make, as a share of the amplitude of each coordinate.
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            amplitude_rad: rad_from_deg(1.0),
            amplitude_m: m_from_mm(1.0),
            sampling: Sampling::Automatic,
            tolerance: 1e-10,
        }
    }
}

/// A motion to integrate.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// α at t = 0, rad or m.
    pub deflection: Vec<f64>,
    /// α̇ at t = 0, rad/s or m/s.
    pub rate: Vec<f64>,
    /// Size of the motion of each coordinate, rad or m: what the tolerance refers to; positive.
    pub scale: Vec<f64>,
    /// Highest angular frequency that matters, rad/s.
    pub highest_rad_per_s: f64,
}

/// How a motion is integrated and sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recording {
    /// Samples per second, Hz; the first is at t = 0.
    pub sample_rate_hz: f64,
    /// Number of samples.
    pub count: usize,
    /// Error that one step may make, as a share of each coordinate's [`Start::scale`].
    pub tolerance: f64,
    /// Whether C of the modal damping at α = 0 acts.
    pub is_damped: bool,
}

/// A record of free vibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Samples per second, Hz; the first is at t = 0.
    pub sample_rate_hz: f64,
    /// For each elastic coordinate α over time, rad or m.
    pub deflections: Vec<Vec<f64>>,
    /// Largest change of the energy over the record, as a share of the energy at t = 0. Without
    /// damping this is the error of the integration.
    pub energy_drift: f64,
}

/// What the spectrum of a large free vibration shows at one pose; also `nonlinear` of `map/1`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measurement {
    /// Frequencies of the peaks, Hz, one per mode in ascending order; `None` where the record
    /// cannot show it: it lies above half the rate, or too close to a neighbour.
    #[serde(skip)]
    pub frequencies_hz: Vec<Option<f64>>,
    /// Linear natural frequencies, Hz, ascending.
    pub linear_hz: Vec<f64>,
    /// By what share each frequency departs from the linear one; `None` where it was not seen.
    #[serde(rename = "departure_percent", serialize_with = "written::percent")]
    pub departures: Vec<Option<f64>>,
    /// Error of the integration: see [`Response::energy_drift`].
    pub energy_drift: f64,
    /// Modes above half the sampling rate, and where a record without an anti-alias filter shows
    /// them.
    #[serde(rename = "folded")]
    pub aliased: Vec<Aliased>,
    /// Peaks that may not be modes but harmonics or combination tones of a large vibration,
    /// ascending in mode.
    #[serde(rename = "doubtful")]
    pub doubts: Vec<Doubt>,
    /// Spectrum of each coordinate, up to half the rate of a fixed sampling, or to the whole
    /// record's.
    #[serde(skip)]
    pub spectrum: Spectrum,
    /// The vibration, at a rate that shows every mode where it is.
    #[serde(skip)]
    pub response: Response,
}

/// A mode that the sampling rate is too low for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Aliased {
    /// Which mode, counted from 0.
    #[serde(serialize_with = "written::from_one")]
    pub mode: usize,
    /// Where it is, Hz.
    pub frequency_hz: f64,
    /// Where it would be seen, Hz.
    pub seen_at_hz: f64,
}

/// A peak that stands for a mode and may be something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Doubt {
    /// Which mode, counted from 0.
    #[serde(serialize_with = "written::from_one")]
    pub mode: usize,
    /// Why.
    pub reason: DoubtReason,
}

/// Why a peak may not be the mode that it stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DoubtReason {
    /// It lies more than a quarter off the mode's linear frequency.
    FarFromLinear,
    /// It lies nearer to another mode's linear frequency.
    NearerToAnotherMode,
    /// A peak that no mode has taken is nearly as high as the lowest that one has.
    RivalPeak,
}

/// All modes at pose `q` with equal energy, each at the peak of its deflection at t = 0. The size
/// of the motion is that of [`Settings::amplitude_rad`], or of [`Settings::amplitude_m`] where
/// nothing turns.
///
/// # Errors
/// The pose has no modes.
pub fn start_all_modes(robot: &Robot, q: &[f64], settings: &Settings) -> Result<Start, Note> {
    let mut solver = ModalSolver::new(robot);
    let modes = solver.solve(q)?;
    let n = robot.coordinates().len();
    // Mass-normalised φ with modal amplitude 1/ω has the energy 1/2.
    let omega: Vec<f64> =
        modes.natural_frequencies_hz.iter().map(|&f| rad_per_s_from_hz(f)).collect();
    let modal = |i: usize, r: usize| modes.shapes[(i, r)] / omega[r];
    let sizes: Vec<f64> = (0..n).map(|i| (0..n).map(|r| modal(i, r).abs()).sum()).collect();
    let turns = |i: &usize| robot.coordinates()[*i].kind == CoordinateKind::Rotation;
    let some_turn = (0..n).any(|i| turns(&i));
    let largest =
        (0..n).filter(|i| turns(i) || !some_turn).fold(0.0_f64, |max, i| max.max(sizes[i]));
    let amplitude = if some_turn { settings.amplitude_rad } else { settings.amplitude_m };
    let factor = amplitude / largest;
    Ok(Start {
        deflection: (0..n).map(|i| factor * (0..n).map(|r| modal(i, r)).sum::<f64>()).collect(),
        rate: vec![0.0; n],
        scale: sizes.iter().map(|size| factor * size).collect(),
        highest_rad_per_s: omega.last().copied().unwrap_or(0.0),
    })
}

/// Integrates the free vibration of `robot` at pose `q` from `start`.
///
/// # Errors
/// The pose has no modes, the start does not fit the robot, or the motion runs away.
pub fn respond(
    robot: &Robot,
    q: &[f64],
    start: &Start,
    recording: &Recording,
) -> Result<Response, Note> {
    let &Recording { sample_rate_hz, count, tolerance, is_damped } = recording;
    let n = robot.coordinates().len();
    for (what, given) in
        [("deflection", &start.deflection), ("rate", &start.rate), ("scale", &start.scale)]
    {
        if given.len() != n {
            let given = given.len();
            return Err(setting(format!(
                "{what} has {given} values, must have {n}, one per elastic coordinate"
            )));
        }
    }
    positive("sample rate", "Hz", sample_rate_hz)?;
    positive("tolerance", "of the amplitude", tolerance)?;
    positive("highest angular frequency", "rad/s", start.highest_rad_per_s)?;

    let mut equation = Equation::new(robot, q, is_damped)?;
    let mut y: Vec<f64> = start.deflection.iter().chain(&start.rate).copied().collect();
    let mut deflections = vec![Vec::with_capacity(count); n];
    let tolerances = start
        .scale
        .iter()
        .map(|scale| scale * tolerance)
        .chain(start.scale.iter().map(|scale| scale * start.highest_rad_per_s * tolerance))
        .collect();
    let mut integrator = Integrator::new(tolerances, 1.0 / start.highest_rad_per_s);
    let energy = equation.energy(&y);
    let mut drift = 0.0_f64;
    for sample in 0..count {
        if sample > 0 {
            let derivative = |y: &[f64], rate: &mut [f64]| equation.derivative(y, rate);
            integrator.advance(&mut y, 1.0 / sample_rate_hz, derivative).map_err(
                |stop| match stop {
                    Stop::Derivative(fault) => Note::from(fault),
                    Stop::StepTooSmall => runs_away(),
                },
            )?;
            drift = drift.max((equation.energy(&y) - energy).abs());
        }
        for (record, &alpha) in deflections.iter_mut().zip(&y) {
            record.push(alpha);
        }
    }
    let energy_drift = if energy > 0.0 { drift / energy } else { 0.0 };
    Ok(Response { sample_rate_hz, deflections, energy_drift })
}

/// Shakes the arm at pose `q` in all its modes at once and reads their frequencies from the
/// spectrum.
///
/// The peaks are those of the strain energy's spectrum Σ k_i |α_i(f)|². All modes start with equal
/// energy, so each has a peak of about the same height there, and the highest peaks are the modes
/// whatever the units and sizes of the coordinates. Linear frequencies choose length and rate of
/// the record and, where peaks are missing, show which; they do not enter the frequencies that are
/// read.
///
/// With [`Sampling::Fixed`] the vibration is sampled at a multiple of the rate that shows every
/// mode where it is; peaks above half the rate are then left out and named in
/// [`Measurement::aliased`], and never taken for modes at the place where they fold to.
///
/// Error of a frequency: less than 1/1000 of a bin 1/T where modes stand eight bins from each other
/// and from zero, in an automatic record less than 2e-5 of the lowest frequency.
///
/// # Errors
/// As [`respond`]; settings that are not positive and finite or ask for more than 16,777,216
/// samples.
pub fn measure(robot: &Robot, q: &[f64], settings: &Settings) -> Result<Measurement, Note> {
    positive("amplitude", "rad", settings.amplitude_rad)?;
    positive("amplitude", "m", settings.amplitude_m)?;
    let mut solver = ModalSolver::new(robot);
    let linear_hz = solver.frequencies_hz(q)?.to_vec();
    let record = Record::new(&linear_hz, settings.sampling)?;
    let start = start_all_modes(robot, q, settings)?;
    let rate = record.sample_rate_hz;
    let recording = Recording {
        sample_rate_hz: rate,
        count: record.count,
        tolerance: settings.tolerance,
        is_damped: false,
    };
    let response = respond(robot, q, &start, &recording)?;

    let found =
        spectrum::peaks(&response.deflections, solver.springs(), rate, linear_hz.len(), PEAK_FLOOR);
    let taken = assign(&found.peaks_hz, &linear_hz);
    let doubts = doubts(&taken, &linear_hz, found.runner_up_share > RIVAL_SHARE);
    let mut frequencies_hz = vec![None; linear_hz.len()];
    let mut aliased = Vec::new();
    for (mode, peak) in taken {
        if peak < record.highest_seen_hz {
            frequencies_hz[mode] = Some(peak);
        } else {
            let seen_at_hz = aliased_hz(peak, 2.0 * record.highest_seen_hz);
            aliased.push(Aliased { mode, frequency_hz: peak, seen_at_hz });
        }
    }
    let mut spectrum = spectrum(&response.deflections, rate);
    let lines = (record.highest_seen_hz / spectrum.bin_hz + 0.5).floor() as usize + 1;
    for amplitudes in &mut spectrum.amplitudes {
        amplitudes.truncate(lines);
    }
    let energy_drift = response.energy_drift;
    let pairs = frequencies_hz.iter().zip(&linear_hz);
    let departures = pairs.map(|(seen, linear)| seen.map(|hz: f64| hz / linear - 1.0)).collect();
    Ok(Measurement {
        frequencies_hz,
        linear_hz,
        departures,
        energy_drift,
        aliased,
        doubts,
        spectrum,
        response,
    })
}

/// How the vibration is sampled inside.
struct Record {
    sample_rate_hz: f64,
    count: usize,
    /// Half the rate that the caller asked for.
    highest_seen_hz: f64,
}

impl Record {
    fn new(linear_hz: &[f64], sampling: Sampling) -> Result<Self, Note> {
        let (Some(&lowest), Some(&highest)) = (linear_hz.first(), linear_hz.last()) else {
            return Err(setting("the robot has no elastic coordinate, so nothing vibrates"));
        };
        let min_rate = SAMPLES_PER_SHORTEST_PERIOD * highest;
        match sampling {
            Sampling::Automatic => {
                let gap = linear_hz.windows(2).fold(f64::INFINITY, |gap, w| gap.min(w[1] - w[0]));
                let duration_s = (PERIODS_OF_THE_LOWEST / lowest).max(BINS_BETWEEN_MODES / gap);
                let max = (PERIODS_OF_THE_LOWEST / lowest * min_rate).max(MAX_AUTOMATIC_SAMPLES);
                let count = samples((duration_s * min_rate).min(max))?;
                Ok(Self { sample_rate_hz: min_rate, count, highest_seen_hz: 0.5 * min_rate })
            }
            Sampling::Fixed { sample_rate_hz, duration_s } => {
                positive("sample rate", "Hz", sample_rate_hz)?;
                positive("duration", "s", duration_s)?;
                let multiple = (min_rate / sample_rate_hz).ceil().max(1.0);
                let count = samples(sample_rate_hz * multiple * duration_s)?;
                let highest_seen_hz = 0.5 * sample_rate_hz;
                Ok(Self { sample_rate_hz: sample_rate_hz * multiple, count, highest_seen_hz })
            }
        }
    }
}

fn samples(count: f64) -> Result<usize, Note> {
    if count > MAX_SAMPLES {
        return Err(setting(format!(
            "the record would need {count:.0} samples to hold every mode, must be at most \
             {MAX_SAMPLES}; shorten the duration"
        )));
    }
    if count < 16.0 {
        return Err(setting(format!(
            "the record would have {count:.0} samples, must have at least 16; lengthen the duration"
        )));
    }
    Ok(count.round() as usize)
}

fn positive(what: &str, unit: &str, value: f64) -> Result<(), Note> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    let what = format!("{what} is {value} {unit}, must be positive and finite");
    Err(setting(what))
}

/// A setting is out of range.
fn setting(what: impl Into<String>) -> Note {
    Note::error(Code::Value, Place::default(), what)
}

fn runs_away() -> Note {
    let what = "the vibration grows without bound: the springs do not hold the arm at this \
                amplitude; lower the amplitude, or check stiffness and gravity";
    Note::error(Code::NotConverged, Place::default(), what)
}

/// Which mode each peak belongs to, both ascending: in order, and where peaks are fewer than modes
/// with the least sum of |ln(peak / linear)|.
fn assign(peaks: &[f64], linear_hz: &[f64]) -> Vec<(usize, f64)> {
    let (p, n) = (peaks.len(), linear_hz.len());
    // cost[i][j]: of the first i peaks among the first j modes.
    let mut cost = vec![vec![f64::INFINITY; n + 1]; p + 1];
    cost[0] = vec![0.0; n + 1];
    for i in 1..=p {
        for j in i..=n {
            let taken = cost[i - 1][j - 1] + (peaks[i - 1] / linear_hz[j - 1]).ln().abs();
            cost[i][j] = taken.min(cost[i][j - 1]);
        }
    }
    let (mut i, mut j) = (p, n);
    let mut pairs = Vec::with_capacity(p);
    while i > 0 && j > 0 {
        if cost[i][j] < cost[i][j - 1] {
            pairs.push((j - 1, peaks[i - 1]));
            i -= 1;
        }
        j -= 1;
    }
    pairs.reverse();
    pairs
}

/// Which of the (mode, peak) pairs may be no modes. A rival peak casts doubt on the pair that is
/// furthest from its linear frequency: which of the peaks is the mode is not clear.
fn doubts(taken: &[(usize, f64)], linear_hz: &[f64], has_rival: bool) -> Vec<Doubt> {
    let departure = |mode: usize, peak: f64| (peak / linear_hz[mode]).ln().abs();
    let furthest = taken
        .iter()
        .max_by(|a, b| departure(a.0, a.1).total_cmp(&departure(b.0, b.1)))
        .map(|&(mode, _)| mode);
    taken
        .iter()
        .filter_map(|&(mode, peak)| {
            let nearer = |other: usize| departure(other, peak) < departure(mode, peak);
            let reason = if (peak / linear_hz[mode] - 1.0).abs() > MAX_DEPARTURE {
                DoubtReason::FarFromLinear
            } else if (0..linear_hz.len()).any(nearer) {
                DoubtReason::NearerToAnotherMode
            } else if has_rival && furthest == Some(mode) {
                DoubtReason::RivalPeak
            } else {
                return None;
            };
            Some(Doubt { mode, reason })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_peak_is_missed_where_it_is_missing() {
        let linear = [10.0, 20.0, 20.1, 55.0];
        let modes = |peaks: &[f64]| assign(peaks, &linear).iter().map(|p| p.0).collect::<Vec<_>>();
        assert_eq!(modes(&[10.1, 19.9, 20.3, 54.0]), [0, 1, 2, 3]);
        assert_eq!(modes(&[9.9, 20.0, 54.0]), [0, 1, 3]);
        assert_eq!(modes(&[20.11, 54.0]), [2, 3]);
        assert_eq!(modes(&[]), [0; 0]);
    }

    #[test]
    fn peaks_far_off_or_out_of_order_are_doubted() {
        let linear = [10.0, 20.0, 22.0];
        let reasons = |peaks: [f64; 3], rival| {
            let taken: Vec<_> = peaks.into_iter().enumerate().collect();
            let found = doubts(&taken, &linear, rival);
            found.iter().map(|d| (d.mode, d.reason)).collect::<Vec<_>>()
        };
        assert_eq!(reasons([10.1, 20.3, 22.1], false), []);
        assert_eq!(reasons([10.1, 20.3, 44.2], false), [(2, DoubtReason::FarFromLinear)]);
        assert_eq!(reasons([10.1, 21.5, 22.5], false), [(1, DoubtReason::NearerToAnotherMode)]);
        assert_eq!(reasons([10.1, 20.6, 22.1], true), [(1, DoubtReason::RivalPeak)]);
    }

    #[test]
    fn settings_out_of_range_are_told() {
        let fixed = |sample_rate_hz, duration_s| Sampling::Fixed { sample_rate_hz, duration_s };
        for (sampling, word) in [
            (fixed(0.0, 5.0), "sample rate"),
            (fixed(140.0, f64::NAN), "duration"),
            (fixed(140.0, 1e9), "at most"),
            (fixed(140.0, 1e-4), "at least"),
        ] {
            let fault = Record::new(&[20.0, 80.0], sampling).err().unwrap().to_string();
            assert!(fault.contains(word), "{fault}");
        }
        assert!(Record::new(&[], Sampling::Automatic).is_err());
    }
}
