//! One record → its modes: frequencies, damping, shapes and scaling with standard deviations, and
//! what must be known about them.

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::clocks::{OtherClock, each_alone, may_differ, other_clock};
use super::estimate::lscf::{StabilisationPoint, stabilisation};
use super::estimate::subspace::{OfRandom, of_random};
use super::estimate::{Block, C64, Estimate, Origin, Pole, PoleEstimate, Residue, estimate};
use super::hum;
use super::late::hold_against_second_half;
use super::misfit;
use super::mode::{Mode, mode_of};
use super::prepare::{Prepared, RecordKind, lines_hz, prepare};
use super::record::{Asked, MarkedLink, Record};
use super::spectra::Averaged;
use super::starts::{Stretch, starts, support};
use super::suspicions;
use super::sway;
use crate::notes::{Code, Note, Notes, Part, Place};
use crate::statistics::upper_median;
use crate::units::{hz_from_rad_per_s, percent_from_ratio, rad_per_s_from_hz};

/// Highest order of the stabilisation diagram where none is asked for: more poles than any band of
/// an arm has.
const HIGHEST_ORDER: usize = 48;

/// A mode is near a frequency that is asked for within this share of it.
const NEAR_ASKED: f64 = 0.05;

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
pub fn identify_record(record: &Record, asked: &Asked) -> IdentifiedRecord {
    let blank = Notes::about(Place::part(Part::Record(record.name.clone())));
    let mut notes = blank.clone();
    let mut found = of_one_clock(record, asked, &mut notes);
    if let Some(clock) = another_clock(record, asked, &found.modes) {
        notes = blank;
        found = of_one_clock(&clock.left_out(record), asked, &mut notes);
        clock.doubt(&mut found.modes, &mut notes);
    }
    found.warnings = grouped(notes.list());
    found
}

/// The responses of another clock, where the modes look as if there were some.
fn another_clock(record: &Record, asked: &Asked, modes: &[Mode]) -> Option<OtherClock> {
    if !may_differ(modes) {
        return None;
    }
    let alone = each_alone(record);
    let of = |own: &Record| of_one_clock(own, asked, &mut Notes::default()).modes;
    other_clock(record, &alone.par_iter().map(of).collect::<Vec<_>>())
}

fn of_one_clock(record: &Record, asked: &Asked, notes: &mut Notes) -> IdentifiedRecord {
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
    if let Some((prepared, stretches, found)) = fitted(record, asked, &mut identified, notes) {
        warn_of_rounding(&prepared, &found, notes);
        if found.begins_moving && prepared.kind == RecordKind::Hammer {
            let what = "the arm was still moving when the record began, which was taken into \
                        account; wait longer before the first impact";
            notes.warning(Code::Remark, None, what);
        }
        identified.spectra = spectra(&prepared, &found);
        let poles = without_window(record, &prepared, &found, notes);
        let modes: Vec<&PoleEstimate> = poles.iter().filter(|pole| is_mode(pole, notes)).collect();
        let has_modes = !modes.is_empty();
        for pole in asked_for(modes, asked, notes) {
            let mut mode = mode_of(record, &prepared, pole);
            let own = (mode.frequency_hz, mode.damping_ratio, mode.damping_std);
            mode.support = support(own, &identified.stabilisation, &stretches);
            identified.modes.push(mode);
        }
        let highest = asked.max_order.unwrap_or(HIGHEST_ORDER);
        hold_against_second_half(record, &prepared, highest, &mut identified.modes, notes);
        if identified.modes.is_empty() && has_modes {
            // What was left out is told.
        } else if identified.modes.is_empty() {
            let what = match prepared.kind {
                _ if !found.poles.is_empty() => {
                    "no pole that was fitted is certain enough to be a mode; set band_hz, or look \
                     at the spectrum (--format svg)"
                }
                RecordKind::RandomResponse => {
                    "no pole keeps its place as the order rises and stands out of the spectrum; \
                     record for longer"
                }
                _ if stands_out(&prepared) => {
                    "the spectra stand out of the noise, but no pole could be fitted to them; set \
                     band_hz, or look at the spectrum (--format svg)"
                }
                _ => "no mode rises above the noise; hit harder, or closer to the arm's end",
            };
            notes.warning(Code::NoModes, None, what);
        } else {
            warn_of_silent_responses(&prepared, &found, notes);
            misfit::warn(&prepared, &found, notes);
        }
        suspicions::check(record, &prepared, &asked.mains_hz, &mut identified.modes, notes);
        identified.averaged = prepared.averaged;
    }
    if let (RecordKind::RandomResponse, Some(window_s)) =
        (identified.kind, record.instrument.exponential_window_s)
    {
        let what = format!(
            "exponential_window_s is {window_s}, but without that window the response does not \
             decay: the record has no such window, or one with a longer time constant"
        );
        notes.warning(Code::Disagreement, None, what);
    }
    identified
}

/// The poles without what the instrument's window added to their decay; a mode that has less
/// damping than that is told.
fn without_window(
    record: &Record,
    prepared: &Prepared,
    found: &Estimate,
    notes: &mut Notes,
) -> Vec<PoleEstimate> {
    /// Of those that are weaker nothing is said.
    const LEAST: f64 = 0.02;
    let Some(window_s) = record.instrument.exponential_window_s else {
        return found.poles.clone();
    };
    // Of samples it was taken off before.
    let decay_per_s = match prepared.kind {
        RecordKind::GivenResponses => window_s.recip(),
        _ => 0.0,
    };
    let poles: Vec<PoleEstimate> =
        found.poles.iter().map(|pole| pole.without_window(decay_per_s)).collect();
    let hz = |pole: &PoleEstimate| hz_from_rad_per_s(pole.pole.omega());
    let grows = |pole: &&PoleEstimate| {
        pole.pole.is_driven && pole.prominence >= LEAST && pole.pole.ratio() < -2.0 * pole.ratio_std
    };
    let grown: Vec<String> =
        poles.iter().filter(grows).map(|pole| format!("{:.3}", hz(pole))).collect();
    if !grown.is_empty() {
        let what = format!(
            "exponential_window_s is {window_s}, but the modes at {} Hz decay more slowly than \
             that window alone makes them: the record has no such window, or one with a longer \
             time constant",
            grown.join(", ")
        );
        notes.warning(Code::Disagreement, None, what);
    }
    poles
}

/// Notes that differ in their numbers alone, as one from the fourth on.
fn grouped(notes: &[Note]) -> Vec<Note> {
    const MANY: usize = 4;
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    let plain =
        |note: &Note| note.what.split(is_number).filter(|s| !s.is_empty()).collect::<String>();
    let keys: Vec<String> = notes.iter().map(plain).collect();
    let mut kept: Vec<Note> = Vec::new();
    for (at, note) in notes.iter().enumerate() {
        let is_alike = |other: &usize| {
            let (a, b) = (&notes[*other], note);
            (a.code, &a.place, &keys[*other]) == (b.code, &b.place, &keys[at])
        };
        let alike: Vec<usize> = (0..notes.len()).filter(is_alike).collect();
        if alike.len() < MANY {
            kept.push(note.clone());
        } else if alike[0] == at {
            let first_number = |at: &usize| {
                let words = notes[*at].what.split(|c: char| !is_number(c));
                words.map(|w| w.trim_matches('.')).find(|w| !w.is_empty()).unwrap_or_default()
            };
            let others: Vec<&str> = alike[1..].iter().map(first_number).collect();
            let what =
                format!("{}; {} more like it: {}", note.what, others.len(), others.join(", "));
            kept.push(Note { what, ..note.clone() });
        }
    }
    kept
}

/// Whether any spectrum has lines far above its median, as noise alone has not.
fn stands_out(prepared: &Prepared) -> bool {
    /// Power over the median one; of a million lines of noise the loudest has 20.
    const FAR: f64 = 60.0;
    prepared.blocks.iter().flat_map(|block| &block.spectra).any(|spectrum| {
        let powers: Vec<f64> = spectrum.iter().map(C64::norm_sqr).collect();
        let median = upper_median(&powers).unwrap_or(0.0);
        powers.iter().any(|power| *power > FAR * median)
    })
}

/// The poles that the session asks for; what is left out or missing is told.
fn asked_for<'p>(
    mut poles: Vec<&'p PoleEstimate>,
    asked: &Asked,
    notes: &mut Notes,
) -> Vec<&'p PoleEstimate> {
    let hz = |pole: &PoleEstimate| hz_from_rad_per_s(pole.pole.omega());
    let all = poles.clone();
    if !asked.near_hz.is_empty() {
        let nearest = |wanted: &f64| {
            let apart = |pole: &PoleEstimate| (hz(pole) / wanted - 1.0).abs();
            let near = poles.iter().enumerate().filter(|(_, pole)| apart(pole) < NEAR_ASKED);
            near.min_by(|a, b| apart(a.1).total_cmp(&apart(b.1))).map(|(at, _)| at)
        };
        let mut kept = Vec::new();
        for wanted in &asked.near_hz {
            match nearest(wanted) {
                Some(at) => kept.push(at),
                None => {
                    let what = format!(
                        "has no mode within {:.0} % of {wanted} Hz, where near_hz asks for one",
                        percent_from_ratio(NEAR_ASKED)
                    );
                    notes.warning(Code::NoModes, None, what);
                }
            }
        }
        let mut at = 0..;
        poles.retain(|_| at.next().is_some_and(|at: usize| kept.contains(&at)));
    }
    if let Some(count) = asked.modes {
        if poles.len() < count {
            let what = format!("has {} modes that are certain, not {count}", poles.len());
            notes.warning(Code::NoModes, None, what);
        }
        let mut by_size: Vec<f64> = poles.iter().map(|pole| pole.prominence).collect();
        by_size.sort_by(|a, b| b.total_cmp(a));
        if let Some(least) = count.checked_sub(1).and_then(|last| by_size.get(last)) {
            poles.retain(|pole| pole.prominence >= *least);
        }
    }
    let left_out = all.iter().filter(|pole| !poles.iter().any(|kept| std::ptr::eq(*kept, **pole)));
    let left_out: Vec<String> = left_out.map(|pole| format!("{:.3}", hz(pole))).collect();
    if !left_out.is_empty() {
        let what =
            format!("modes that are not asked for were left out: {} Hz", left_out.join(", "));
        notes.warning(Code::Remark, None, what);
    }
    poles
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
    warn_of_friction(pole, notes);
    true
}

/// Tells damping that changes with amplitude, as friction makes it.
fn warn_of_friction(pole: &PoleEstimate, notes: &mut Notes) {
    /// Least change, as a share of the damping and of the drift of the frequency.
    const OF_DAMPING: f64 = 0.1;
    const OF_DRIFT: f64 = 0.2;
    let ratio = pole.pole.ratio();
    let (Some(change), Some(drift)) = (pole.damping_drift, pole.drift) else { return };
    if change.abs() < (OF_DAMPING * ratio).max(OF_DRIFT * drift.abs()) {
        return;
    }
    let what = format!(
        "the damping of the mode at {:.3} Hz depends on amplitude, as friction makes it: its \
         ratio is {:.4} at the record's largest amplitude and {ratio:.4} at small ones, which is \
         the one given; hit as hard as the job shakes the arm to see the one that counts",
        hz_from_rad_per_s(pole.pole.omega()),
        ratio + change
    );
    notes.warning(Code::AmplitudeDamping, None, what);
}

/// A record ready for the estimation, its stretches, and the fit.
type Fitted = (Prepared, Vec<Stretch>, Estimate);

/// The record as it is fitted, from above what does not follow the hits on.
fn fitted(
    record: &Record,
    asked: &Asked,
    identified: &mut IdentifiedRecord,
    notes: &mut Notes,
) -> Option<Fitted> {
    let mut above = notes.clone();
    let all = fitted_in(record, asked, identified, notes);
    let points = &identified.stabilisation;
    let own = all.as_ref().filter(|_| asked.band_hz.is_none());
    let low = own.and_then(|(prepared, _, found)| sway::end(prepared, found, points));
    let Some(low) = low else { return all };
    // What such motion leaves unexplained may have narrowed the band.
    let whole = prepare(record, None, &mut Notes::default());
    let lines = whole.iter().flat_map(|whole| &whole.blocks).flat_map(lines_hz);
    let band = [low, lines.fold(0.0, f64::max)];
    let cut = Asked { band_hz: Some(band), ..asked.clone() };
    let mut other = IdentifiedRecord { stabilisation: Vec::new(), ..identified.clone() };
    let Some(found) = fitted_in(record, &cut, &mut other, &mut above) else { return all };
    let both = all.as_ref().map(|(_, _, all)| {
        sway::is_better((&found.2, &other.stabilisation), (all, &identified.stabilisation))
    });
    if both == Some(false) {
        return all;
    }
    sway::warn(low, &mut above);
    (*notes, *identified) = (above, other);
    Some(found)
}

/// The record ready for the estimation, its stabilisation diagrams, and the fit. What the force of
/// a short pulse leaves unexplained at high frequencies can spoil the whole fit: then the band is
/// narrowed, with a warning.
fn fitted_in(
    record: &Record,
    asked: &Asked,
    identified: &mut IdentifiedRecord,
    notes: &mut Notes,
) -> Option<Fitted> {
    let blank = notes.clone();
    let mut band_hz = asked.band_hz;
    let highest = asked.max_order.unwrap_or(HIGHEST_ORDER);
    for narrowed in 0..=4 {
        let mut own_notes = blank.clone();
        let prepared = prepare(record, band_hz, &mut own_notes);
        if narrowed == 0 || prepared.is_some() {
            *notes = own_notes;
        }
        let mut prepared = prepared?;
        if prepared.stationary.is_some()
            && let Some(quiet) = hum::taken_off(record, &asked.mains_hz, notes)
        {
            let again = prepare(&quiet, band_hz, &mut Notes::default());
            prepared = again.filter(|again| again.stationary.is_some()).unwrap_or(prepared);
        }
        identified.kind = prepared.kind;
        if let Some(stationary) = &prepared.stationary {
            let Some(OfRandom { found, by_order, hidden, slow }) = of_random(stationary, highest)
            else {
                let what = "the response goes on, as under a random force that was not measured, \
                            and is too short for its modes; record for at least ten minutes";
                notes.warning(Code::ShortRecord, None, what);
                return None;
            };
            warn_of_hidden(&hidden, notes);
            warn_of_slow(&slow, notes);
            identified.stabilisation = stabilisation(&by_order);
            let all = Stretch { own: [0.0, f64::INFINITY], orders: by_order.len() };
            return Some((prepared, vec![all], found));
        }
        identified.stabilisation.clear();
        let points = &mut identified.stabilisation;
        let (mut stretches, mut starts) = starts(&prepared, highest, points);
        let near = asked.near_hz.iter().map(|hz| rad_per_s_from_hz(*hz));
        starts.extend(near.map(|omega| Pole::from_modal(omega, 0.01)));
        let before = prepared.blocks.clone();
        if let Some(mut found) = estimate(&mut prepared.blocks, &starts, highest / 2) {
            misfit::looked_at_closely(
                (&mut prepared, before),
                (&mut stretches, points, starts),
                highest,
                &mut found,
            );
            if let (true, Some([_, high])) = (narrowed > 0, band_hz) {
                let what = format!(
                    "the whole band could not be fitted; the spectra were fitted up to {high:.1} \
                     Hz instead; set band_hz to choose the band"
                );
                notes.warning(Code::Remark, None, what);
            }
            warn_of_window(&prepared, notes);
            return Some((prepared, stretches, found));
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

/// Tells the window that an analyser's responses show.
fn warn_of_window(prepared: &Prepared, notes: &mut Notes) {
    let of = |block: &Block| match block.origin {
        Origin::Responses { hann_s } => hann_s,
        Origin::Sampled { .. } => None,
    };
    if let Some(length_s) = prepared.blocks.iter().find_map(of) {
        let what = format!(
            "the peaks are as wide as a Hann window over {length_s:.4} s makes them, which the fit \
             takes into account; damping is surer from raw records"
        );
        notes.warning(Code::Remark, None, what);
    }
}

/// Tells poles of a random response that noise makes as well.
fn warn_of_hidden(hidden: &[f64], notes: &mut Notes) {
    if hidden.is_empty() {
        return;
    }
    let what = format!(
        "poles at {} Hz do not stand out of the spectrum around them, as a mode would and noise \
         does not: left out; record for longer if you expect modes there",
        listed_hz(hidden)
    );
    notes.warning(Code::Unsettled, None, what);
}

/// Tells modes of a random response of which its correlations hold too little.
fn warn_of_slow(slow: &[f64], notes: &mut Notes) {
    if !slow.is_empty() {
        let what = format!(
            "the correlations hold fewer than three periods of the modes at {} Hz, whose standard \
             deviations may be too small: record for longer",
            listed_hz(slow)
        );
        notes.warning(Code::ShortRecord, None, what);
    }
}

fn listed_hz(omegas: &[f64]) -> String {
    let hz = omegas.iter().map(|omega| format!("{:.3}", hz_from_rad_per_s(*omega)));
    hz.collect::<Vec<_>>().join(", ")
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
