//! One record → its modes: frequencies, damping, shapes and scaling with standard deviations, and what
//! must be known about them.

use super::estimate::lscf::{StabilisationPoint, candidates, poles_by_order, stabilisation};
use super::estimate::{C64, Estimate, Pole, PoleEstimate, Residue, estimate};
use super::links::{LinkRotation, rotations};
use super::notice::{Notice, NoticeKind, Notices};
use super::prepare::{Kind, Prepared, Response, lines_hz, prepare};
use super::record::Record;
use super::spectra::Averaged;
use super::suspicions;
use crate::units::{hz_from_rad_per_s, percent_from_ratio};

/// Damping ratios above this are no mode of an arm.
const MOST_DAMPING: f64 = 0.3;

/// A mode whose frequency is no better known than this share is not reported.
const LEAST_CERTAINTY: f64 = 0.03;

/// A mode weaker than this share of the strongest line of every response is the model's own error.
const LEAST_PROMINENCE: f64 = 1e-3;

/// Below this share, what could not be settled is not told either.
const LEAST_TOLD: f64 = 0.02;

/// Bands that are tried where a hammer's spectra cannot be fitted.
const MOST_NARROWED: usize = 4;

/// Where the force has fallen to this share of its highest amplitude, the band ends first (20 dB).
const FORCE_SHARE: f64 = 0.1;

/// Noise within this factor of what rounding brings is rounding.
const ROUNDED: f64 = 1.01;

/// Rounding below this share of the strongest line is that of the digits of a file.
const TOLD_ROUNDING: f64 = 1e-5;

/// One part of a mode shape.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapePart {
    /// Name of the response.
    pub response: String,
    /// Displacement against the largest part of the shape, which is 1 (responses of unknown quantity: as
    /// they were read).
    pub value: C64,
    /// Standard deviation of its real and imaginary part.
    pub std: f64,
    /// Where a force was measured: φ_response·φ_reference of the receptance Σ φφ/(ω_r² − ω² + 2iζω_rω), 1/kg
    /// (where a quantity is not known: in the response's unit over N).
    pub modal_constant: Option<C64>,
    /// Mass-normalised shape where the response at the driving point is known, 1/√kg.
    pub mass_normalised: Option<C64>,
}

/// A mode as one record shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Natural frequency |λ|/2π, Hz.
    pub frequency_hz: f64,
    /// Standard deviation, Hz.
    pub frequency_std_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Standard deviation.
    pub damping_std: f64,
    /// One part a response.
    pub shape: Vec<ShapePart>,
    /// Free decays: displacement amplitude of the shape's largest part when the strongest decay begins, m (or the
    /// channel's unit).
    pub amplitude: Option<f64>,
    /// Lowest coherence of all responses, where several hits or stretches were averaged.
    pub coherence: Option<f64>,
    /// Share of the orders of the stabilisation diagram that have this pole.
    pub support: f64,
    /// Change of the frequency at the record's largest amplitudes, as a share, where it depends on amplitude: the
    /// frequency is then that of small amplitudes.
    pub drift: Option<f64>,
    /// Rotation of each link with marked points.
    pub links: Vec<LinkRotation>,
    /// What else it may be: such a mode is not written to the table of modes.
    pub suspicion: Option<NoticeKind>,
}

/// Spectrum and fit of one response.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedSpectrum {
    /// Name of the response.
    pub response: String,
    /// Lines, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Magnitude of the spectrum (free decays: of the first decay).
    pub measured: Vec<f64>,
    /// Magnitude of the fit.
    pub fitted: Vec<f64>,
}

/// All that one record gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The record's name.
    pub record: String,
    /// How the arm was excited.
    pub kind: Kind,
    /// By ascending frequency.
    pub modes: Vec<Mode>,
    /// What must be known.
    pub notices: Vec<Notice>,
    /// For the plot.
    pub spectra: Vec<FittedSpectrum>,
    /// For the plot.
    pub stabilisation: Vec<StabilisationPoint>,
    /// Averaged frequency responses of records with force.
    pub averaged: Option<Averaged>,
}

/// Finds the modes of a record. Nothing found is a notice, never an error.
pub fn identify_record(record: &Record, band_hz: Option<[f64; 2]>, mains_hz: &[f64]) -> Identified {
    let mut notices = Notices::about(&record.name);
    let mut identified = Identified {
        record: record.name.clone(),
        kind: Kind::FreeDecay,
        modes: Vec::new(),
        notices: Vec::new(),
        spectra: Vec::new(),
        stabilisation: Vec::new(),
        averaged: None,
    };
    let Some((prepared, orders, found)) = fitted(record, band_hz, &mut identified, &mut notices)
    else {
        identified.notices = notices.list;
        return identified;
    };
    rounding(&prepared, &found, &mut notices);
    if found.begins_moving && prepared.kind == Kind::Hammer {
        let what = "the arm was still moving when the record began, which was taken into account; wait longer \
                    before the first hit";
        notices.add(NoticeKind::Remark, None, what.to_owned());
    }
    identified.spectra = spectra(&prepared, &found);
    for pole in &found.poles {
        if !pole.pole.is_driven {
            let hz = hz_from_rad_per_s(pole.pole.omega());
            let what = format!(
                "a steady tone at {hz:.3} Hz that the force does not cause was fitted and left out"
            );
            notices.add(NoticeKind::Tone, None, what);
            continue;
        }
        if pole.is_remainder {
            let hz = hz_from_rad_per_s(pole.pole.omega());
            let what = format!(
                "something weak at {hz:.2} Hz was fitted and left out: it lies in the width of a mode that depends on \
                 amplitude, or at a sum or difference of such modes' frequencies, and may be no more than that"
            );
            notices.add(NoticeKind::AmplitudeDependent, None, what);
            continue;
        }
        if !is_settled(pole, &mut notices) {
            continue;
        }
        if let Some(drift) = pole.drift {
            tell_of_drift(pole, drift, &mut notices);
        }
        let mut mode = mode(record, &prepared, pole);
        mode.support = support(&mode, &identified.stabilisation, orders);
        identified.modes.push(mode);
    }
    if !identified.modes.is_empty() {
        silent_responses(&prepared, &found, &mut notices);
    }
    if identified.modes.is_empty() {
        let what = "no mode stands out of the noise; hit harder, or come nearer to the arm's end"
            .to_owned();
        notices.add(NoticeKind::NoModes, None, what);
    }
    suspicions::tell(record, &prepared, mains_hz, &mut identified.modes, &mut notices);
    identified.averaged = prepared.averaged;
    identified.notices = notices.list;
    identified
}

/// The record ready for the estimation, how many orders were tried, and the fit. What the force of a short
/// pulse leaves unexplained at high frequencies can spoil the whole fit: then the band is narrowed, and told.
fn fitted(
    record: &Record,
    band_hz: Option<[f64; 2]>,
    identified: &mut Identified,
    notices: &mut Notices,
) -> Option<(Prepared, usize, Estimate)> {
    let mut band_hz = band_hz;
    for narrowed in 0..=MOST_NARROWED {
        let mut told = Notices::about(&record.name);
        let prepared = prepare(record, band_hz, &mut told);
        if narrowed == 0 || prepared.is_some() {
            notices.list = told.list;
        }
        let mut prepared = prepared?;
        identified.kind = prepared.kind;
        let (orders, starts) = starts(&prepared, identified);
        if let Some(found) = estimate(&mut prepared.blocks, &starts) {
            if let (true, Some([_, high])) = (narrowed > 0, band_hz) {
                let what = format!(
                    "the spectra could not be fitted up to where they end; they were fitted up to {high:.1} Hz \
                     instead; give band_hz to choose"
                );
                notices.add(NoticeKind::Remark, None, what);
            }
            return Some((prepared, orders, found));
        }
        match narrower(&prepared, band_hz) {
            Some(band) => band_hz = Some(band),
            None => break,
        }
    }
    let what = "the spectra could not be fitted; give band_hz, or look at the record".to_owned();
    notices.add(NoticeKind::NoModes, None, what);
    None
}

/// The next band for a hammer test: up to where the force has fallen, or half of the last.
fn narrower(prepared: &Prepared, band_hz: Option<[f64; 2]>) -> Option<[f64; 2]> {
    /// Fewer lines are no band.
    const FEWEST_LINES: usize = 32;
    let block = prepared.blocks.first().filter(|_| prepared.kind == Kind::Hammer)?;
    let low = band_hz.map_or(0.0, |band| band[0]);
    let high = hz_from_rad_per_s(block.highest());
    let strongest = block.drive.iter().map(|f| f.norm()).fold(0.0, f64::max);
    let reached = block.drive.iter().rposition(|f| f.norm() > FORCE_SHARE * strongest);
    let reached = reached.map_or(high, |k| hz_from_rad_per_s(block.omega[k]));
    let half = low + 0.5 * (high - low);
    let end = if reached > half && reached < 0.9 * high { reached } else { half };
    (block.omega.len() >= 2 * FEWEST_LINES).then_some([low, end])
}

/// How many orders the linear least squares had, and the poles that they agree on.
fn starts(prepared: &Prepared, identified: &mut Identified) -> (usize, Vec<Pole>) {
    let sets: Vec<(&[f64], &[Vec<C64>])> = prepared
        .starts_from
        .iter()
        .map(|(omega, spectra)| (omega.as_slice(), spectra.as_slice()))
        .collect();
    let by_order: Vec<(usize, Vec<Pole>)> = poles_by_order(&sets)
        .into_iter()
        .map(|(order, poles)| {
            let unwindowed =
                |pole: Pole| Pole { lambda: pole.lambda + prepared.window_decay, ..pole };
            (order, poles.into_iter().map(unwindowed).filter(|pole| pole.lambda.re < 0.0).collect())
        })
        .collect();
    identified.stabilisation = stabilisation(&by_order);
    (by_order.len(), candidates(&identified.stabilisation))
}

/// Tells of responses whose rounding is louder than their noise.
fn rounding(prepared: &Prepared, found: &Estimate, notices: &mut Notices) {
    let Some((block, noise)) = prepared.blocks.first().zip(found.noise.first()) else { return };
    for ((response, least), noise) in prepared.responses.iter().zip(&block.least_noise).zip(noise) {
        let at_least = |std: &&f64| **std <= ROUNDED * least.sqrt();
        let rounded = noise.iter().filter(at_least).count();
        let strongest = block.spectra.iter().flatten().map(|v| v.norm()).fold(0.0, f64::max);
        let is_told = notices.list.iter().any(|notice| {
            notice.kind == NoticeKind::CoarseSteps
                && notice.channel.as_deref() == Some(&response.name)
        });
        if 2 * rounded > noise.len() && least.sqrt() > TOLD_ROUNDING * strongest && !is_told {
            let what = "moves in steps that are coarser than its noise: rounding hides what is weaker; use a \
                        finer range or a harder hit";
            notices.add(NoticeKind::CoarseSteps, Some(&response.name), what.to_owned());
        }
    }
}

/// Tells of responses in which no pole stands out of what is not known about its residue, where some other shows them.
fn silent_responses(prepared: &Prepared, found: &Estimate, notices: &mut Notices) {
    /// |residue|² over the variance of its parts, which chance exceeds once in ten thousand times (χ² with two
    /// degrees of freedom).
    const CHANCE: f64 = 18.4;
    // A force that goes on may be none: then it is the force that shows nothing.
    if !matches!(prepared.kind, Kind::Hammer | Kind::FreeDecay) {
        return;
    }
    let stands_out = |residue: &Residue| residue.value.norm_sqr() > CHANCE * residue.variance;
    let driven: Vec<&PoleEstimate> =
        found.poles.iter().filter(|pole| pole.pole.is_driven).collect();
    let shows = |i: usize| {
        let mut residues = driven.iter().flat_map(|pole| &pole.residues);
        residues.any(|block| block.get(i).is_some_and(stands_out))
    };
    let silent: Vec<usize> = (0..prepared.responses.len()).filter(|&i| !shows(i)).collect();
    if silent.len() == prepared.responses.len() {
        return;
    }
    for i in silent {
        let what =
            "shows none of the modes, only noise: look at its cable and range, or leave it out";
        notices.add(NoticeKind::NoSignal, Some(&prepared.responses[i].name), what.to_owned());
    }
}

/// Tells that a mode depends on amplitude; what is reported is its limit at small amplitudes.
fn tell_of_drift(pole: &PoleEstimate, drift: f64, notices: &mut Notices) {
    let what = format!(
        "the mode at {:.3} Hz depends on amplitude: where the arm swings most its frequency is {:.2} % {}; the \
         frequency given is that of small amplitudes, its deviation allows for the extrapolation; hit less hard to \
         see less of it",
        hz_from_rad_per_s(pole.pole.omega()),
        percent_from_ratio(drift.abs()),
        if drift < 0.0 { "lower" } else { "higher" }
    );
    notices.add(NoticeKind::AmplitudeDependent, None, what);
}

/// Whether a pole is a mode that can be reported; tells if it was near.
fn is_settled(pole: &PoleEstimate, notices: &mut Notices) -> bool {
    let (omega, ratio) = (pole.pole.omega(), pole.pole.ratio());
    if pole.prominence < LEAST_PROMINENCE || ratio > MOST_DAMPING {
        return false;
    }
    let is_decaying = ratio > -2.0 * pole.ratio_std;
    if pole.omega_std > LEAST_CERTAINTY * omega || !is_decaying {
        if pole.prominence < LEAST_TOLD {
            return false;
        }
        let what = format!(
            "something near {:.2} ± {:.2} Hz with damping ratio {ratio:.4} ± {:.4} was fitted and is not reported: \
             it is not certain enough to be a mode",
            hz_from_rad_per_s(omega),
            hz_from_rad_per_s(pole.omega_std),
            pole.ratio_std
        );
        notices.add(NoticeKind::Unsettled, None, what);
        return false;
    }
    true
}

/// Share of the orders that have a steady pole near the mode.
fn support(mode: &Mode, points: &[StabilisationPoint], orders: usize) -> f64 {
    const NEAR: f64 = 0.01;
    let mut having: Vec<usize> = points
        .iter()
        .filter(|point| (point.frequency_hz / mode.frequency_hz - 1.0).abs() < NEAR)
        .map(|point| point.order)
        .collect();
    having.dedup();
    having.len() as f64 / orders.max(1) as f64
}

fn spectra(prepared: &Prepared, found: &Estimate) -> Vec<FittedSpectrum> {
    let Some(block) = prepared.blocks.first() else { return Vec::new() };
    let scale = |k: usize| match block.drive.get(k) {
        // Over the force, as a frequency response.
        Some(drive) => drive.norm().max(f64::MIN_POSITIVE).recip(),
        None => 1.0,
    };
    let sizes =
        |values: &[C64]| values.iter().enumerate().map(|(k, v)| v.norm() * scale(k)).collect();
    prepared
        .responses
        .iter()
        .zip(block.spectra.iter().zip(&found.fitted[0]))
        .map(|(response, (measured, fitted))| FittedSpectrum {
            response: response.name.clone(),
            frequencies_hz: lines_hz(block),
            measured: sizes(measured),
            fitted: sizes(fitted),
        })
        .collect()
}

/// Displacement amplitude of a residue: differentiation multiplies it by λ.
fn displacement(response: &Response, residue: C64, lambda: C64) -> C64 {
    residue / lambda.powi(response.quantity.derivatives().unwrap_or(0))
}

fn mode(record: &Record, prepared: &Prepared, pole: &PoleEstimate) -> Mode {
    let lambda = pole.pole.lambda;
    let count = prepared.responses.len();
    // Displacements with deviations, by block and response.
    let moves: Vec<Vec<(C64, f64)>> = pole
        .residues
        .iter()
        .map(|block| {
            (0..count)
                .map(|i| {
                    let value = displacement(&prepared.responses[i], block[i].value, lambda);
                    let scale = value.norm() / block[i].value.norm().max(f64::MIN_POSITIVE);
                    (value, scale * block[i].variance.sqrt())
                })
                .collect()
        })
        .collect();
    let (shape, reference) = common_shape(&moves, count);
    let strongest = moves.iter().map(|block| block[reference].0.norm()).fold(0.0, f64::max);
    let constants: Option<Vec<C64>> = scaled(prepared).map(|per_step| {
        moves[0]
            .iter()
            .map(|(value, _)| value * C64::new(0.0, 2.0 * lambda.im * per_step))
            .collect()
    });
    let driving = constants.as_ref().and_then(|constants| {
        let name = record.driving_point.as_ref()?;
        let at = prepared.responses.iter().position(|response| response.name == *name)?;
        // The driving point's constant is a square, so positive but for noise.
        (constants[at].re > 0.0).then(|| constants[at].sqrt())
    });
    let parts = (0..count).map(|i| ShapePart {
        response: prepared.responses[i].name.clone(),
        value: shape[i].0,
        std: shape[i].1,
        modal_constant: constants.as_ref().map(|constants| constants[i]),
        mass_normalised: driving.and_then(|driving| Some(constants.as_ref()?[i] / driving)),
    });
    let amplitude = (prepared.kind == Kind::FreeDecay).then_some(2.0 * strongest);
    let parts: Vec<ShapePart> = parts.collect();
    let at_channel = |name: &str| {
        let part = parts.iter().find(|part| part.response == name)?;
        Some((part.value, part.std))
    };
    Mode {
        frequency_hz: hz_from_rad_per_s(pole.pole.omega()),
        frequency_std_hz: hz_from_rad_per_s(pole.omega_std),
        damping_ratio: pole.pole.ratio(),
        damping_std: pole.ratio_std,
        links: rotations(&record.links, &at_channel, amplitude),
        shape: parts,
        amplitude,
        coherence: coherence(prepared, hz_from_rad_per_s(pole.pole.omega())),
        support: 0.0,
        drift: pole.drift,
        suspicion: None,
    }
}

/// What a residue must be multiplied by to be one of the continuous receptance; `None` without force.
fn scaled(prepared: &Prepared) -> Option<f64> {
    match prepared.kind {
        Kind::FreeDecay => None,
        Kind::GivenResponses => Some(1.0),
        Kind::Hammer | Kind::Steady => prepared.nyquist_hz.map(|nyquist| 2.0 * nyquist),
    }
}

/// The shape that all blocks share, each block with an amplitude of its own: alternating least squares.
/// Its largest part is 1.
fn common_shape(moves: &[Vec<(C64, f64)>], count: usize) -> (Vec<(C64, f64)>, usize) {
    const ROUNDS: usize = 20;
    let power = |i: usize| moves.iter().map(|block| block[i].0.norm_sqr()).sum::<f64>();
    // The loudest of several decays, and its largest part, to begin with.
    let mut shape: Vec<C64> = moves
        .iter()
        .max_by(|a, b| {
            let size = |block: &[(C64, f64)]| block.iter().map(|(v, _)| v.norm_sqr()).sum::<f64>();
            size(a).total_cmp(&size(b))
        })
        .map_or_else(Vec::new, |block| block.iter().map(|(value, _)| *value).collect());
    let mut amplitudes = vec![C64::default(); moves.len()];
    for _ in 0..ROUNDS {
        let norm = shape.iter().map(C64::norm_sqr).sum::<f64>().max(f64::MIN_POSITIVE);
        for (amplitude, block) in amplitudes.iter_mut().zip(moves) {
            *amplitude =
                block.iter().zip(&shape).map(|((v, _), s)| v * s.conj()).sum::<C64>() / norm;
        }
        let norm = amplitudes.iter().map(C64::norm_sqr).sum::<f64>().max(f64::MIN_POSITIVE);
        for (i, part) in shape.iter_mut().enumerate() {
            *part =
                moves.iter().zip(&amplitudes).map(|(block, a)| block[i].0 * a.conj()).sum::<C64>()
                    / norm;
        }
    }
    let reference = (0..count).max_by(|&a, &b| power(a).total_cmp(&power(b))).unwrap_or(0);
    let unit = shape.get(reference).copied().unwrap_or(C64::new(1.0, 0.0));
    let norm = amplitudes.iter().map(C64::norm_sqr).sum::<f64>().max(f64::MIN_POSITIVE);
    let deviation = |i: usize| {
        let sum: f64 =
            moves.iter().zip(&amplitudes).map(|(block, a)| a.norm_sqr() * block[i].1.powi(2)).sum();
        sum.sqrt() / norm
    };
    let of_unit = deviation(reference);
    let size = unit.norm().max(f64::MIN_POSITIVE);
    let parts = (0..count)
        .map(|i| {
            if i == reference {
                return (C64::new(1.0, 0.0), 0.0);
            }
            let value = shape[i] / unit;
            (value, deviation(i).hypot(value.norm() * of_unit) / size)
        })
        .collect();
    (parts, reference)
}

/// Lowest coherence of all responses at the mode.
fn coherence(prepared: &Prepared, frequency_hz: f64) -> Option<f64> {
    let averaged = prepared.averaged.as_ref().filter(|averaged| !averaged.coherence.is_empty())?;
    let bin = averaged.frequencies_hz.get(1)?;
    let at = (frequency_hz / bin).round() as usize;
    let of = |coherence: &Vec<f64>| coherence.get(at).copied();
    averaged.coherence.iter().filter_map(of).min_by(f64::total_cmp)
}
