//! One record → its modes: frequencies, damping, shapes and scaling with standard deviations, and
//! what must be known about them.

use super::estimate::lscf::{
    PolesByOrder, StabilisationPoint, candidates, poles_by_order, stabilisation,
};
use super::estimate::subspace::of_random;
use super::estimate::{C64, Estimate, Pole, PoleEstimate, Residue, estimate};
use super::mode::{Mode, mode_of};
use super::prepare::{Prepared, RecordKind, lines_hz, prepare};
use super::record::{MarkedLink, Record};
use super::spectra::Averaged;
use super::suspicions;
use crate::notes::{Code, Note, Notes, Part, Place};
use crate::units::{hz_from_rad_per_s, percent_from_ratio};

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
pub struct IdentifiedRecord {
    /// The record's name.
    pub name: String,
    /// How the arm was excited.
    pub kind: RecordKind,
    /// By ascending frequency.
    pub modes: Vec<Mode>,
    /// What must be known.
    pub warnings: Vec<Note>,
    /// For the plot.
    pub spectra: Vec<FittedSpectrum>,
    /// For the plot.
    pub stabilisation: Vec<StabilisationPoint>,
    /// Averaged frequency responses of records with force.
    pub averaged: Option<Averaged>,
    /// Links with marked points, for the plot.
    pub links: Vec<MarkedLink>,
}

/// Finds the modes of a record. A record without modes gets a warning, not an error.
pub fn identify_record(
    record: &Record,
    band_hz: Option<[f64; 2]>,
    mains_hz: &[f64],
) -> IdentifiedRecord {
    let mut notes = Notes::about(Place::part(Part::Record(record.name.clone())));
    let mut identified = IdentifiedRecord {
        name: record.name.clone(),
        kind: RecordKind::FreeDecay,
        modes: Vec::new(),
        warnings: Vec::new(),
        spectra: Vec::new(),
        stabilisation: Vec::new(),
        averaged: None,
        links: record.links.clone(),
    };
    if let Some((prepared, orders, found)) = fitted(record, band_hz, &mut identified, &mut notes) {
        warn_of_rounding(&prepared, &found, &mut notes);
        if found.begins_moving && prepared.kind == RecordKind::Hammer {
            let what = "the arm was still moving when the record began, which was taken into \
                        account; wait longer before the first impact";
            notes.warning(Code::Remark, None, what);
        }
        identified.spectra = spectra(&prepared, &found);
        for pole in found.poles.iter().filter(|pole| is_mode(pole, &mut notes)) {
            let mut mode = mode_of(record, &prepared, pole);
            mode.support = support(&mode, &identified.stabilisation, orders);
            identified.modes.push(mode);
        }
        if identified.modes.is_empty() {
            let what = match prepared.kind {
                RecordKind::RandomResponse => {
                    "no pole keeps its place as the order rises; record for longer"
                }
                _ => "no mode rises above the noise; hit harder, or closer to the arm's end",
            };
            notes.warning(Code::NoModes, None, what);
        } else {
            warn_of_silent_responses(&prepared, &found, &mut notes);
        }
        suspicions::check(record, &prepared, mains_hz, &mut identified.modes, &mut notes);
        identified.averaged = prepared.averaged;
    }
    identified.warnings = notes.list().to_vec();
    identified
}

/// Whether a pole is a mode to be reported; warns of those that are not but might be taken for one,
/// and of modes that depend on amplitude.
fn is_mode(pole: &PoleEstimate, notes: &mut Notes) -> bool {
    let hz = hz_from_rad_per_s(pole.pole.omega());
    if !pole.pole.is_driven {
        let what = format!(
            "a steady tone at {hz:.3} Hz that the force does not cause was fitted and left out"
        );
        notes.warning(Code::Tone, None, what);
        return false;
    }
    if pole.is_artefact {
        let what = format!(
            "a weak peak at {hz:.2} Hz was fitted and left out: it lies within the width of a mode \
             that depends on amplitude, or at a sum or difference of such modes' frequencies, and \
             may be an effect of that dependence"
        );
        notes.warning(Code::AmplitudeDependent, None, what);
        return false;
    }
    if !is_settled(pole, notes) {
        return false;
    }
    if let Some(drift) = pole.drift {
        let what = format!(
            "the mode at {hz:.3} Hz depends on amplitude: at its largest amplitude its frequency \
             is {:.2} % {}; the frequency given is that of small amplitudes, its standard \
             deviation includes the extrapolation; hit less hard to reduce the effect",
            percent_from_ratio(drift.abs()),
            if drift < 0.0 { "lower" } else { "higher" }
        );
        notes.warning(Code::AmplitudeDependent, None, what);
    }
    true
}

/// The record ready for the estimation, how many orders were tried, and the fit. What the force of
/// a short pulse leaves unexplained at high frequencies can spoil the whole fit: then the band is
/// narrowed, with a warning.
fn fitted(
    record: &Record,
    band_hz: Option<[f64; 2]>,
    identified: &mut IdentifiedRecord,
    notes: &mut Notes,
) -> Option<(Prepared, usize, Estimate)> {
    let blank = notes.clone();
    let mut band_hz = band_hz;
    for narrowed in 0..=4 {
        let mut own_notes = blank.clone();
        let prepared = prepare(record, band_hz, &mut own_notes);
        if narrowed == 0 || prepared.is_some() {
            *notes = own_notes;
        }
        let mut prepared = prepared?;
        identified.kind = prepared.kind;
        if let Some(stationary) = &prepared.stationary {
            let Some((found, by_order)) = of_random(stationary) else {
                let what = "the response goes on, as under a random force that was not measured, \
                            and is too short for its modes; record for at least ten minutes";
                notes.warning(Code::ShortRecord, None, what);
                return None;
            };
            identified.stabilisation = stabilisation(&by_order);
            return Some((prepared, by_order.len(), found));
        }
        let (orders, starts) = starts(&prepared, identified);
        if let Some(found) = estimate(&mut prepared.blocks, &starts) {
            if let (true, Some([_, high])) = (narrowed > 0, band_hz) {
                let what = format!(
                    "the whole band could not be fitted; the spectra were fitted up to {high:.1} \
                     Hz instead; set band_hz to choose the band"
                );
                notes.warning(Code::Remark, None, what);
            }
            return Some((prepared, orders, found));
        }
        match narrower(&prepared, band_hz) {
            Some(band) => band_hz = Some(band),
            None => break,
        }
    }
    let what = "the spectra could not be fitted; set band_hz, or inspect the record";
    notes.warning(Code::NoModes, None, what);
    None
}

/// The next band for a hammer test: up to where the force has fallen, or half of the last.
fn narrower(prepared: &Prepared, band_hz: Option<[f64; 2]>) -> Option<[f64; 2]> {
    let block = prepared.blocks.first().filter(|_| prepared.kind == RecordKind::Hammer)?;
    let low = band_hz.map_or(0.0, |band| band[0]);
    let high = hz_from_rad_per_s(block.highest());
    let strongest = block.drive.iter().map(|f| f.norm()).fold(0.0, f64::max);
    // The band ends first where the force has fallen by 20 dB.
    let reached = block.drive.iter().rposition(|f| f.norm() > 0.1 * strongest);
    let reached = reached.map_or(high, |k| hz_from_rad_per_s(block.omega[k]));
    let half = low + 0.5 * (high - low);
    let end = if reached > half && reached < 0.9 * high { reached } else { half };
    (block.omega.len() >= 64).then_some([low, end])
}

/// How many orders the linear least squares had, and the poles that they agree on.
fn starts(prepared: &Prepared, identified: &mut IdentifiedRecord) -> (usize, Vec<Pole>) {
    let sets: Vec<(&[f64], &[Vec<C64>])> = prepared
        .starts_from
        .iter()
        .map(|(omega, spectra)| (omega.as_slice(), spectra.as_slice()))
        .collect();
    let by_order: PolesByOrder = poles_by_order(&sets)
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

/// Warns of responses whose rounding is louder than their noise.
fn warn_of_rounding(prepared: &Prepared, found: &Estimate, notes: &mut Notes) {
    let Some((block, noise)) = prepared.blocks.first().zip(found.noise.first()) else { return };
    for ((response, least), noise) in prepared.responses.iter().zip(&block.min_noise).zip(noise) {
        let at_least = |std: &&f64| **std <= 1.01 * least.sqrt();
        let rounded = noise.iter().filter(at_least).count();
        let strongest = block.spectra.iter().flatten().map(|v| v.norm()).fold(0.0, f64::max);
        let name = response.name.as_str();
        let is_known = notes.list().iter().any(|note| {
            let names =
                |part: &Part| matches!(part, Part::Channel { channel, .. } if *channel == name);
            note.code == Code::CoarseSteps && note.place.part.as_ref().is_some_and(names)
        });
        // Less rounding than this is that of the digits of a file.
        if 2 * rounded > noise.len() && least.sqrt() > 1e-5 * strongest && !is_known {
            let what = "its steps are coarser than its noise: quantisation hides weaker signals; \
                        use a finer range or hit harder";
            notes.channel_warning(Code::CoarseSteps, &response.name, what);
        }
    }
}

/// Warns of responses in which no residue is significant, where another response shows some.
fn warn_of_silent_responses(prepared: &Prepared, found: &Estimate, notes: &mut Notes) {
    // Where a steady force is not the real one, no response follows it.
    if !matches!(prepared.kind, RecordKind::Hammer | RecordKind::FreeDecay) {
        return;
    }
    // A p-value of 10⁻⁴ (χ² with two degrees of freedom).
    let stands_out = |residue: &Residue| residue.value.norm_sqr() > 18.4 * residue.variance;
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
            "shows none of the modes, only noise: check its cable and range, or leave it out";
        notes.channel_warning(Code::NoSignal, &prepared.responses[i].name, what);
    }
}

/// Whether a pole is certain enough to be reported; warns where it is strong but uncertain.
fn is_settled(pole: &PoleEstimate, notes: &mut Notes) -> bool {
    let (omega, ratio) = (pole.pole.omega(), pole.pole.ratio());
    // Weaker ones are errors of the fit; an arm's modes are damped less.
    if pole.prominence < 1e-3 || ratio > 0.3 {
        return false;
    }
    let is_decaying = ratio > -2.0 * pole.ratio_std;
    if is_decaying && pole.omega_std <= 0.03 * omega {
        return true;
    }
    if pole.prominence >= 0.02 {
        let what = format!(
            "a peak near {:.2} ± {:.2} Hz with damping ratio {ratio:.4} ± {:.4} was fitted but is \
             not reported: it is too uncertain to be a mode",
            hz_from_rad_per_s(omega),
            hz_from_rad_per_s(pole.omega_std),
            pole.ratio_std
        );
        notes.warning(Code::Unsettled, None, what);
    }
    false
}

/// Fraction of the orders that have a stable pole near the mode.
fn support(mode: &Mode, points: &[StabilisationPoint], orders: usize) -> f64 {
    let mut having: Vec<usize> = points
        .iter()
        .filter(|point| (point.frequency_hz / mode.frequency_hz - 1.0).abs() < 0.01)
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
