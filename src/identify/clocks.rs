//! Responses of two recorders whose clocks differ: those of one show the same modes as those of the
//! other, all at a constant factor of their frequencies. A fit of all responses lists each mode
//! twice; fits of each response alone show the factor.

use super::mode::Mode;
use super::record::{Channel, Data, Record};
use crate::notes::{Code, Notes};

/// Clocks differ by less than this share, and by more than that.
const MOST: f64 = 0.04;
const LEAST: f64 = 2e-4;

/// Frequencies are known no better than this, relative.
const KNOWN: f64 = 5e-5;

/// Standard deviations: factors of two modes agree within `ALIKE`, and one is none below `CERTAIN`.
const ALIKE: f64 = 4.0;
const CERTAIN: f64 = 6.0;

fn is_sure(mode: &&Mode) -> bool {
    mode.suspicion.is_none()
}

/// The ln of a factor of frequencies, and its standard deviation.
fn apart(low: &Mode, high: &Mode) -> (f64, f64) {
    let std = |mode: &Mode| mode.frequency_std_hz / mode.frequency_hz;
    ((high.frequency_hz / low.frequency_hz).ln(), std(low).hypot(std(high)).hypot(KNOWN))
}

/// Whether modes come in pairs that lie apart by one factor.
pub(super) fn may_differ(modes: &[Mode]) -> bool {
    /// Of the modes, those that must be in such pairs.
    const PAIRED: f64 = 2.0 / 3.0;
    let sure: Vec<&Mode> = modes.iter().filter(is_sure).collect();
    let pairs: Vec<(f64, f64)> =
        sure.windows(2).map(|pair| apart(pair[0], pair[1])).filter(|(ln, _)| *ln < MOST).collect();
    let alike = |of: &(f64, f64)| {
        let is = |pair: &&(f64, f64)| (pair.0 - of.0).abs() < ALIKE * pair.1.hypot(of.1) + LEAST;
        pairs.iter().filter(is).count()
    };
    let most = pairs.iter().map(alike).max().unwrap_or(0);
    most >= 2 && 2.0 * most as f64 >= PAIRED * sure.len() as f64
}

/// Responses that go with another clock than the others.
pub(super) struct OtherClock {
    /// Their frequencies over those of the others.
    factor: f64,
    names: Vec<String>,
}

/// The responses of a record, each alone.
pub(super) fn each_alone(record: &Record) -> Vec<Record> {
    responses(record).iter().map(|own| with(record, |name| *name == own.name)).collect()
}

fn responses(record: &Record) -> &[Channel] {
    match &record.data {
        Data::Time { responses, .. } | Data::Uneven { responses, .. } => responses,
        Data::Responses(_) => &[],
    }
}

fn with(record: &Record, is_kept: impl Fn(&String) -> bool) -> Record {
    let mut kept = record.clone();
    if let Data::Time { responses, .. } | Data::Uneven { responses, .. } = &mut kept.data {
        responses.retain(|channel| is_kept(&channel.name));
    }
    kept
}

/// The fewer responses of those that two clocks sampled, by the modes that each response shows
/// alone; `None` of one clock.
pub(super) fn other_clock(record: &Record, alone: &[Vec<Mode>]) -> Option<OtherClock> {
    let count = |at: &usize| alone[*at].iter().filter(is_sure).count();
    let richest = (0..alone.len()).rev().max_by_key(count)?;
    let lns: Vec<f64> = alone.iter().map(|own| ln_factor(&alone[richest], own)).collect();
    let names = |is_other: bool| -> Vec<String> {
        let own = responses(record).iter().zip(&lns).filter(|(_, ln)| (**ln != 0.0) == is_other);
        own.map(|(channel, _)| channel.name.clone()).collect()
    };
    let others: Vec<f64> = lns.iter().copied().filter(|ln| *ln != 0.0).collect();
    let mean = others.iter().sum::<f64>() / others.len().max(1) as f64;
    let is_driving =
        |names: &[String]| record.driving_point.as_ref().is_some_and(|point| names.contains(point));
    let [same, other] = [names(false), names(true)];
    if other.is_empty() {
        return None;
    }
    let rank = |names: &[String]| (is_driving(names), names.len());
    let is_two = others.iter().all(|ln| (ln - mean).abs() < LEAST.max(0.2 * mean.abs()));
    Some(match is_two && rank(&other) > rank(&same) {
        true => OtherClock { factor: (-mean).exp(), names: same },
        false => OtherClock { factor: mean.exp(), names: other },
    })
}

/// The ln of the factor between the frequencies of two responses; 0 where there is none.
fn ln_factor(reference: &[Mode], own: &[Mode]) -> f64 {
    let nearest = |mode: &Mode, among: &[Mode]| -> Option<usize> {
        let far = |at: &usize| apart(mode, &among[*at]).0.abs();
        let sure = (0..among.len()).filter(|at| is_sure(&&among[*at]) && far(at) < MOST);
        sure.min_by(|a, b| far(a).total_cmp(&far(b)))
    };
    let pair = |at: usize| -> Option<(f64, f64)> {
        let other = nearest(&own[at], reference)?;
        (nearest(&reference[other], own) == Some(at)).then(|| apart(&reference[other], &own[at]))
    };
    let sure = (0..own.len()).filter(|at| is_sure(&&own[*at]));
    let pairs: Vec<(f64, f64)> = sure.filter_map(pair).collect();
    let weight: f64 = pairs.iter().map(|(_, std)| std.powi(-2)).sum();
    let mean = pairs.iter().map(|(ln, std)| ln * std.powi(-2)).sum::<f64>() / weight;
    let agree = pairs.iter().all(|(ln, std)| (ln - mean).abs() < ALIKE * std);
    let is_certain = mean.abs() > LEAST.max(CERTAIN * weight.sqrt().recip());
    if pairs.len() >= 2 && agree && is_certain { mean } else { 0.0 }
}

impl OtherClock {
    /// The record without those responses.
    pub(super) fn left_out(&self, record: &Record) -> Record {
        with(record, |name| !self.names.contains(name))
    }

    /// Tells it, and that no record says which clock is right.
    pub(super) fn doubt(&self, modes: &mut [Mode], notes: &mut Notes) {
        for mode in modes {
            let apart = (self.factor - 1.0).abs() * mode.frequency_hz;
            mode.frequency_std_hz = mode.frequency_std_hz.hypot(apart);
        }
        for name in &self.names {
            let what = format!(
                "shows all modes at {:.5} times the frequencies in the other responses: another \
                 clock sampled it, as with two recorders; it is left out; which clock is right \
                 the record does not say, so standard deviations hold the difference; record all \
                 channels with one clock",
                self.factor
            );
            notes.channel_warning(Code::Disagreement, name, what);
        }
    }
}
