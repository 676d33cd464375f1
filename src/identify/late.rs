//! The same modes at smaller amplitudes: the second half of a decay, by itself. Where they lie
//! elsewhere there, they change with amplitude by no law that the fit knows.

use super::estimate::{PoleEstimate, estimate};
use super::impacts::{decays, impacts_in_force};
use super::mode::{Mode, mode_of};
use super::prepare::{Prepared, RecordKind, lines_hz, prepare, without_offset};
use super::record::{Channel, Data, Record};
use super::shapes::mac;
use super::starts::starts;
use crate::notes::{Code, Notes};

/// Shorter halves say nothing, samples.
const MIN_SAMPLES: usize = 64;

/// One mode and the other are the same within this share of the frequency, the nearest of their
/// kind, and of this modal assurance.
const SAME: f64 = 0.12;
const MIN_MAC: f64 = 0.9;

/// A difference is none below this many of its standard deviations, or this share of the frequency.
const SIGNIFICANT: f64 = 5.0;
const MIN_SHARE: f64 = 5e-4;

/// A mode decays, by so many standard deviations of its damping ratio and by no less than this one:
/// what does not is a tone that outlives it.
const DECAYS: f64 = 3.0;
const MIN_RATIO: f64 = 3e-4;

/// Of a late mode that is less certain than this share of its frequency nothing is said.
const MAX_STD: f64 = 0.02;

/// Takes modes that lie elsewhere in the second half of the last decay from there, with a warning
/// and half of the change as standard deviation; `highest` is the highest order of the
/// stabilisation diagram.
pub(super) fn hold_against_second_half(
    record: &Record,
    prepared: &Prepared,
    highest: usize,
    modes: &mut [Mode],
    notes: &mut Notes,
) {
    if !matches!(prepared.kind, RecordKind::Hammer | RecordKind::FreeDecay) {
        return;
    }
    let lines = prepared.blocks.first().map(lines_hz).unwrap_or_default();
    let [low, .., high] = lines[..] else { return };
    let Some(half) = second_half(record) else { return };
    let late = modes_within(&half, [low, high], highest).unwrap_or_default();
    // Each is the other's nearest, before any of them moves.
    let other_of = |at: usize| -> Option<&Mode> {
        let other = &late[nearest(&modes[at], &late)?];
        (nearest(other, modes) == Some(at)).then_some(other)
    };
    let others: Vec<Option<&Mode>> = (0..modes.len()).map(other_of).collect();
    for (mode, other) in modes.iter_mut().zip(others) {
        if let Some(other) = other {
            hold_against(mode, other, notes);
        }
    }
}

fn hold_against(mode: &mut Mode, late: &Mode, notes: &mut Notes) {
    let apart = (mode.frequency_hz - late.frequency_hz).abs();
    let by_noise = mode.frequency_std_hz.hypot(late.frequency_std_hz);
    // One response has no shape.
    let is_alike = mac(&mode.shape, &late.shape).is_none_or(|mac| mac >= MIN_MAC);
    if !is_alike || apart < SIGNIFICANT * by_noise || apart < MIN_SHARE * mode.frequency_hz {
        return;
    }
    let what = format!(
        "the mode at {:.3} Hz (damping ratio {:.4}) lies at {:.3} Hz ({:.4}) in the second half of \
         its decay: it changes with amplitude by no law that the fit knows, such as play or \
         friction; what is given is the second half's, which is nearer to small amplitudes, with \
         half of the change as standard deviation",
        mode.frequency_hz, mode.damping_ratio, late.frequency_hz, late.damping_ratio
    );
    notes.warning(Code::AmplitudeDependent, None, what);
    let change = 0.5 * (mode.damping_ratio - late.damping_ratio).abs();
    mode.frequency_std_hz = late.frequency_std_hz.hypot(0.5 * apart);
    mode.damping_std = late.damping_std.hypot(change);
    mode.frequency_hz = late.frequency_hz;
    mode.damping_ratio = late.damping_ratio;
}

/// The mode whose frequency is nearest, as far as one is near.
fn nearest(mode: &Mode, among: &[Mode]) -> Option<usize> {
    let far = |other: &Mode| (other.frequency_hz / mode.frequency_hz).ln().abs();
    let near = among.iter().enumerate().filter(|(_, other)| far(other) < SAME);
    near.min_by(|a, b| far(a.1).total_cmp(&far(b.1))).map(|(at, _)| at)
}

/// The second half of the last decay of a record, as a free decay.
fn second_half(record: &Record) -> Option<Record> {
    let Data::Time { sample_rate_hz, excitation, responses } = &record.data else { return None };
    let (from, to) = match excitation {
        Some(force) => {
            let impacts = impacts_in_force(&without_offset(&force.samples), *sample_rate_hz);
            (impacts.last()?.end, force.samples.len())
        }
        None => {
            let level: Vec<Vec<f64>> =
                responses.iter().map(|channel| without_offset(&channel.samples)).collect();
            let level: Vec<&[f64]> = level.iter().map(Vec::as_slice).collect();
            let last = *decays(&level, *sample_rate_hz).last()?;
            (last.from, last.to)
        }
    };
    let middle = from + to.saturating_sub(from) / 2;
    let cut = |channel: &Channel| Channel {
        samples: channel.samples.get(middle..to).unwrap_or_default().to_vec(),
        ..channel.clone()
    };
    let data = Data::Time {
        sample_rate_hz: *sample_rate_hz,
        excitation: None,
        responses: responses.iter().map(cut).collect(),
    };
    (to - middle >= MIN_SAMPLES).then(|| Record { data, ..record.clone() })
}

/// The modes of a free decay that are certain.
fn modes_within(record: &Record, band_hz: [f64; 2], highest: usize) -> Option<Vec<Mode>> {
    let mut prepared = prepare(record, Some(band_hz), &mut Notes::default())?;
    if prepared.kind != RecordKind::FreeDecay {
        return None;
    }
    let (_, starts) = starts(&prepared, highest, &mut Vec::new());
    let found = estimate(&mut prepared.blocks, &starts, highest / 2)?;
    let is_certain = |of: &&PoleEstimate| {
        of.pole.is_driven
            && of.pole.ratio() > MIN_RATIO.max(DECAYS * of.ratio_std)
            && of.omega_std < MAX_STD * of.pole.omega()
    };
    let certain = found.poles.iter().filter(is_certain);
    Some(certain.map(|pole| mode_of(record, &prepared, pole)).collect())
}
