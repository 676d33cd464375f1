//! What a mode may be beside a mode, and what the record lacks for it.

use super::estimate::{C64, Origin};
use super::harmonics::Harmonics;
use super::mode::Mode;
use super::prepare::{Prepared, RecordKind};
use super::record::{Channel, Data, Record};
use super::shapes::mac;
use crate::notes::{Code, Note, Notes, Part};
use crate::units::{percent_from_ratio, rad_per_s_from_hz};

/// A steady tone has no damping; records of finite length and varying speed blur it up to this
/// ratio.
const MAX_TONE_DAMPING: f64 = 2e-3;

/// So many poles that no order of the stabilisation diagram has, and that do not stand alone, show
/// a record that no sum of modes is, as one whose clock jitters: then a mode must be in this share
/// of the orders.
const MANY_UNSUPPORTED: usize = 3;
const LEAST_SUPPORT: f64 = 0.2;

/// Warns of all of it, and marks modes that are probably tones.
pub(super) fn check(
    record: &Record,
    prepared: &Prepared,
    mains_hz: &[f64],
    modes: &mut [Mode],
    notes: &mut Notes,
) {
    // Of the force, or of a response that was not left out.
    let is_used = |note: &&Note| match &note.place.part {
        Some(Part::Channel { channel, .. }) => {
            let is_response = |own: &Channel| own.name == *channel;
            !responses_of(record).iter().any(is_response)
                || prepared.responses.iter().any(|own| own.name == *channel)
        }
        _ => false,
    };
    let is_clipping = |note: &&Note| note.code == Code::Clipping;
    let is_clipped = notes.list().iter().filter(is_clipping).any(|note| is_used(&note));
    if is_clipped && !modes.is_empty() {
        let what = "a clipped record bends frequencies, damping and shapes: its modes are listed, \
                    but left out of the table";
        notes.warning(Code::Clipping, None, what);
    }
    let alone: Vec<bool> = (0..modes.len()).map(|at| stands_alone(prepared, modes, at)).collect();
    let is_lost = |&(mode, alone): &(&Mode, &bool)| mode.support == 0.0 && !alone;
    let is_no_sum = modes.iter().zip(&alone).filter(is_lost).count() >= MANY_UNSUPPORTED;
    let least = if is_no_sum { LEAST_SUPPORT } else { 0.0 };
    let own: Vec<bool> = alone.into_iter().map(|alone| alone && !is_no_sum).collect();
    for (mode, stands_alone) in modes.iter_mut().zip(own) {
        tones(record, prepared, mains_hz, mode, notes);
        uncertain(prepared, mode, (stands_alone, least), notes);
        if mode.suspicion.is_none() {
            length(prepared, mode, notes);
            coherence(prepared, mode, notes);
            force(prepared, mode, notes);
        }
        may_be_folded(prepared, mode, notes);
        one_shape(mode, notes);
        mode.suspicion = mode.suspicion.or(is_clipped.then_some(Code::Clipping));
    }
    if matches!(prepared.kind, RecordKind::FreeDecay | RecordKind::Hammer) {
        harmonics(modes, notes);
        companions(modes, notes);
        echoes(modes, notes);
    }
    delay(modes, notes);
    polarity(record, modes, notes);
}

/// A driving point that moves against the force: one of both has the other sign.
fn polarity(record: &Record, modes: &[Mode], notes: &mut Notes) {
    let Some(name) = &record.driving_point else { return };
    let parts = modes.iter().filter(|mode| mode.suspicion.is_none()).filter_map(|mode| {
        let part = mode.shape.iter().find(|part| part.response == *name)?;
        part.modal_constant
    });
    let (against, all) = parts.fold((0, 0), |(against, all), constant| {
        (against + usize::from(-constant.re > constant.im.abs()), all + 1)
    });
    if all == 0 || 2 * against <= all {
        return;
    }
    let what = "moves against the force at the driving point, which no mode can: force or response \
                has the wrong sign, or it is another point; shapes are not mass-normalised";
    notes.channel_warning(Code::Disagreement, name, what);
}

/// Force and responses that were not sampled at the same time: it turns the modal constants of a
/// mode, real but for a little of the damping, by its frequency times the delay.
fn delay(modes: &[Mode], notes: &mut Notes) {
    /// Delays looked for, s.
    const LONGEST_S: f64 = 0.02;
    /// Parts of a shape known worse than this share are left aside.
    const MAX_STD: f64 = 0.2;
    /// Least mean square of the constants' imaginary part, and what a delay may leave of it.
    const LEAST: f64 = 0.03;
    const LEFT: f64 = 0.15;
    // By mode: frequency, rad/s, and the mean of the squared constants' directions.
    let direction = |mode: &Mode| {
        let parts = mode.shape.iter().filter(|part| part.std < MAX_STD * part.value.norm());
        let constants = parts.filter_map(|part| part.modal_constant);
        let (sum, size) = constants.fold((C64::default(), 0.0), |(sum, size), constant| {
            (sum + constant * constant, size + constant.norm_sqr())
        });
        (size > 0.0).then(|| (rad_per_s_from_hz(mode.frequency_hz), sum / size))
    };
    let is_sure = |mode: &&Mode| mode.suspicion.is_none();
    let turned: Vec<(f64, C64)> = modes.iter().filter(is_sure).filter_map(direction).collect();
    let Some(highest) = turned.iter().map(|(omega, _)| *omega).reduce(f64::max) else { return };
    if turned.len() < 2 {
        return;
    }
    let imaginary = |delay_s: f64| {
        let real = |(omega, squared): &(f64, C64)| {
            (squared * C64::from_polar(1.0, 2.0 * omega * delay_s)).re
        };
        0.5 - 0.5 * turned.iter().map(real).sum::<f64>() / turned.len() as f64
    };
    let before = imaginary(0.0);
    let step_s = 0.05 / highest;
    let tried = (1..=(LONGEST_S / step_s) as usize)
        .flat_map(|k| [k as f64 * step_s, -(k as f64) * step_s])
        .map(|delay_s| (delay_s, imaginary(delay_s)));
    // The shortest that explains it: longer ones turn the modes by whole circles.
    let mut near = tried.filter(|(_, left)| *left < LEFT * before).peekable();
    let Some((first_s, _)) = near.peek().copied() else { return };
    let is_near = |(delay_s, _): &(f64, f64)| (delay_s - first_s).abs() * highest < 0.5;
    let best = near.filter(is_near).min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((delay_s, _)) = best.filter(|_| before > LEAST) else { return };
    let what = format!(
        "the phase of the modes turns with frequency as if the responses were {:.1} ms {} the \
         force, by a filter or a wireless sensor: then modes are missed and damping is wrong; \
         measure it with both on one point, or try response_delay_s: {delay_s:.4}",
        1e3 * delay_s.abs(),
        if delay_s > 0.0 { "behind" } else { "ahead of" }
    );
    notes.warning(Code::Delay, None, what);
}

fn responses_of(record: &Record) -> &[Channel] {
    match &record.data {
        Data::Time { responses, .. } | Data::Uneven { responses, .. } => responses,
        Data::Responses(_) => &[],
    }
}

fn tones(
    record: &Record,
    prepared: &Prepared,
    mains_hz: &[f64],
    mode: &mut Mode,
    notes: &mut Notes,
) {
    let max_damping = MAX_TONE_DAMPING.max(2.0 * mode.damping_std).min(4.0 * MAX_TONE_DAMPING);
    if mode.damping_ratio.abs() > max_damping {
        return;
    }
    for source in Harmonics::all(mains_hz, record.spindle_rpm) {
        let own = (mode.frequency_hz, mode.frequency_std_hz);
        if let Some((order, is_alias)) = source.at(own, prepared.nyquist_hz) {
            // What an analyser divided by the force has little of what the force did not cause.
            let is_divided = prepared.kind == RecordKind::GivenResponses;
            let what = format!(
                "{:.3} Hz has almost no damping ({:.5}) and lies at {order} times the {} frequency \
                 of {:.3} Hz{}: {}",
                mode.frequency_hz,
                mode.damping_ratio,
                source.name(),
                source.base_hz,
                if is_alias { ", aliased" } else { "" },
                match is_divided {
                    true => "check the coherence there",
                    false => "probably no mode of the arm; left out of the table",
                }
            );
            notes.warning(source.code, None, what);
            mode.suspicion = (!is_divided).then_some(source.code);
            return;
        }
    }
    if prepared.kind == RecordKind::GivenResponses {
        return;
    }
    // In a response to unknown forces nothing but damping tells a machine's tone from a mode.
    let is_unforced = prepared.kind == RecordKind::RandomResponse;
    let what = format!(
        "{:.3} Hz has almost no damping ({:.5}), like a steady tone, for example from a machine \
         nearby{}",
        mode.frequency_hz,
        mode.damping_ratio,
        match is_unforced {
            true =>
                ": no force was measured that would tell them apart; left out of the table; \
                     record once more with that machine stopped",
            false => "",
        }
    );
    notes.warning(Code::Tone, None, what);
    mode.suspicion = is_unforced.then_some(Code::Tone);
}

/// Whether the fit alone makes a mode certain: all respond in proportion, it is known well, and it
/// is no part of a louder mode near it, as its shape is another. Least squares of rising order may
/// pass over a light mode between loud ones, the more so the more channels hold the loud ones
/// alone.
fn stands_alone(prepared: &Prepared, modes: &[Mode], at: usize) -> bool {
    /// Relative deviations of damping and frequency.
    const DAMPING: f64 = 0.1;
    const FREQUENCY: f64 = 1e-3;
    /// Decay rates of both within which another mode may be the same one, and what the modal
    /// assurance criterion of two is below.
    const WIDTHS: f64 = 5.0;
    const OTHER_SHAPE: f64 = 0.9;
    let mode = &modes[at];
    let is_known = mode.damping_std < DAMPING * mode.damping_ratio
        && mode.frequency_std_hz < FREQUENCY * mode.frequency_hz;
    let is_linear = modes.iter().all(|mode| mode.drift.is_none());
    let is_record = matches!(prepared.kind, RecordKind::FreeDecay | RecordKind::Hammer);
    if !(is_known && is_linear && is_record) {
        return false;
    }
    let width = |mode: &Mode| mode.damping_ratio.abs() * mode.frequency_hz;
    modes.iter().enumerate().filter(|(other, _)| *other != at).all(|(_, other)| {
        let apart = (mode.frequency_hz - other.frequency_hz).abs();
        apart > WIDTHS * (width(mode) + width(other))
            || mac(&mode.shape, &other.shape).is_some_and(|mac| mac < OTHER_SHAPE)
    })
}

/// A fitted pole that is no mode: damping may be zero, or nothing but the fit supports it.
/// Modes in less than the `least` share of the orders, or in none, must stand alone.
fn uncertain(
    prepared: &Prepared,
    mode: &mut Mode,
    (stands_alone, least): (bool, f64),
    notes: &mut Notes,
) {
    /// Relative standard deviation of vague damping, where no order of the stabilisation diagram
    /// has the mode.
    const VAGUE_DAMPING: f64 = 0.5;
    /// Of the orders: a mode in more of them is one, however little is known of its damping.
    const SETTLED: f64 = 0.5;
    if mode.suspicion.is_some() {
        return;
    }
    let is_vague = mode.frequency_std_hz / mode.frequency_hz.max(f64::MIN_POSITIVE) > 3e-3;
    // Not above zero by more than chance, and known to be less than any arm has.
    let is_decay = matches!(prepared.kind, RecordKind::FreeDecay | RecordKind::Hammer);
    let has_no_damping = mode.damping_ratio <= 0.0
        || is_decay
            && mode.damping_ratio < 3.0 * mode.damping_std
            && mode.damping_ratio + 2.0 * mode.damping_std < MAX_TONE_DAMPING;
    let is_unknown = is_vague && mode.damping_std > mode.damping_ratio && mode.support < SETTLED;
    let is_alone = mode.support == 0.0 || mode.support < least;
    let is_unsettled = has_no_damping
        || is_unknown
        || is_alone && (is_vague || mode.damping_std > VAGUE_DAMPING * mode.damping_ratio);
    if !is_unsettled && !is_alone {
        return;
    }
    let found = format!(
        "{:.3} ± {:.3} Hz with damping ratio {:.5} ± {:.5}, in {:.0} % of the orders,",
        mode.frequency_hz,
        mode.frequency_std_hz,
        mode.damping_ratio,
        mode.damping_std,
        percent_from_ratio(mode.support)
    );
    if !is_unsettled && stands_alone {
        let what = format!(
            "{found} is supported by the fit alone, which knows it well: listed; compare it with \
             another record"
        );
        notes.warning(Code::Unsettled, None, what);
        return;
    }
    let what = match is_unsettled {
        true => format!("{found} is too uncertain to be a mode: left out of the table"),
        false if mode.support > 0.0 => format!(
            "{found} has little support, in a record that other poles of the fit show to be more \
             than modes and noise: left out of the table; compare it with another record"
        ),
        false => format!(
            "{found} is supported by the fit alone: left out of the table; compare it with \
             another record, or with the spectrum"
        ),
    };
    notes.warning(Code::Unsettled, None, what);
    mode.suspicion = Some(Code::Unsettled);
}

/// Multiples of a louder mode's frequency that fall with it: what does not respond in proportion,
/// as a joint with play or one that is stiffer on one side, sounds at them. A mode that happens to
/// lie there has a decay of its own.
fn harmonics(modes: &mut [Mode], notes: &mut Notes) {
    const MOST: u32 = 6;
    /// Of the frequency, beside three deviations; where these are more than so much of it, the mode
    /// may as well lie beside the multiple. Of the decay rates, relative.
    const NEAR: f64 = 2e-4;
    const KNOWN: f64 = 3e-3;
    const ALIKE: f64 = 0.15;
    let decay = |mode: &Mode| mode.damping_ratio * mode.frequency_hz;
    for at in 0..modes.len() {
        let mode = &modes[at];
        let order_of = |base: &Mode| (mode.frequency_hz / base.frequency_hz).round();
        let std_of =
            |base: &Mode| mode.frequency_std_hz.hypot(order_of(base) * base.frequency_std_hz);
        let is_of = |base: &&Mode| {
            let (order, std) = (order_of(base), std_of(base));
            let off = (mode.frequency_hz - order * base.frequency_hz).abs();
            // Between as fast as the mode itself, in proportion to it, and with its power.
            let rate = decay(mode) / decay(base).max(f64::MIN_POSITIVE);
            (2.0..=f64::from(MOST)).contains(&order)
                && off < 3.0 * std + NEAR * mode.frequency_hz
                && mode.prominence < base.prominence
                && (1.0 - ALIKE..=order * (1.0 + ALIKE)).contains(&rate)
                && base.suspicion.is_none()
        };
        let Some(base) = modes.iter().find(is_of).filter(|_| mode.suspicion.is_none()) else {
            continue;
        };
        let is_known = 3.0 * std_of(base) < KNOWN * mode.frequency_hz;
        let what = format!(
            "{:.3} Hz {} {:.0} times the mode at {:.3} Hz and falls with it, as play or springs \
             that are stiffer on one side make it: {}; hit less hard",
            mode.frequency_hz,
            if is_known { "is" } else { "may be" },
            order_of(base),
            base.frequency_hz,
            if is_known { "left out of the table" } else { "too uncertain to tell, so it is kept" }
        );
        notes.warning(Code::AmplitudeDependent, None, what);
        if is_known {
            modes[at].suspicion = Some(Code::AmplitudeDependent);
        }
    }
}

/// What decays several times as fast as a louder mode of the same shape and frequency: damping that
/// rises with amplitude, as of friction, needs such a companion in a linear fit.
fn companions(modes: &mut [Mode], notes: &mut Notes) {
    /// Of the decay rates.
    const FASTER: f64 = 2.0;
    /// Of the other's power.
    const WEAKER: f64 = 0.35;
    /// The modal assurance criterion of so weak a pole is not known any better.
    const ONE_SHAPE: f64 = 0.9;
    let decay = |mode: &Mode| mode.damping_ratio * mode.frequency_hz;
    for at in 0..modes.len() {
        let mode = &modes[at];
        let is_of = |of: &&Mode| {
            (mode.frequency_hz - of.frequency_hz).abs() < decay(mode)
                && decay(mode) > FASTER * decay(of)
                && mode.prominence < WEAKER * of.prominence
                && of.suspicion.is_none()
                && mac(&mode.shape, &of.shape).is_some_and(|mac| mac > ONE_SHAPE)
        };
        let Some(of) = modes.iter().find(is_of).filter(|_| mode.suspicion.is_none()) else {
            continue;
        };
        // Two responses tell shapes apart too badly to leave out what may be a mode.
        let is_known = mode.shape.len() >= 3;
        let what = format!(
            "{:.3} Hz with a damping ratio of {:.1} % has the shape of the mode at {:.3} Hz with \
             {:.1} %: damping that changes with amplitude, as of friction, makes such a companion; \
             {}; hit less hard",
            mode.frequency_hz,
            percent_from_ratio(mode.damping_ratio),
            of.frequency_hz,
            percent_from_ratio(of.damping_ratio),
            if is_known { "left out of the table" } else { "with two responses it is kept" }
        );
        notes.warning(Code::AmplitudeDependent, None, what);
        if is_known {
            modes[at].suspicion = Some(Code::AmplitudeDependent);
        }
    }
}

/// What is within the width of a mode that is far louder, and decays as it does: sensors that are
/// not quite linear, as the sub-pixel errors of a camera are, leave so much of the mode, by a shape
/// of their own. The louder mode may be off by as much as the weaker one can bend it.
fn echoes(modes: &mut [Mode], notes: &mut Notes) {
    /// Of the louder one's size over all responses; where both all but coincide they share the
    /// motion between them.
    const WEAKER: f64 = 0.05;
    const WEAKER_AS_ONE: f64 = 0.3;
    /// Of the louder one's decay rate; and of the decay rates.
    const WITHIN: f64 = 0.5;
    const AS_ONE: f64 = 0.1;
    const ALIKE: f64 = 2.0;
    let decay = |mode: &Mode| mode.damping_ratio * mode.frequency_hz;
    let share_of = |mode: &Mode, of: &Mode| Some(size(mode)? / size(of)?.max(f64::MIN_POSITIVE));
    for at in 0..modes.len() {
        let mode = &modes[at];
        let is_of = |of: &Mode| {
            let rate = decay(mode) / decay(of).max(f64::MIN_POSITIVE);
            let apart = (mode.frequency_hz - of.frequency_hz).abs();
            let weaker = if apart < AS_ONE * decay(of) { WEAKER_AS_ONE } else { WEAKER };
            apart < WITHIN * decay(of)
                && (ALIKE.recip()..ALIKE).contains(&rate)
                && share_of(mode, of).is_some_and(|share| share < weaker)
                && of.suspicion.is_none()
        };
        let of = (0..modes.len()).find(|&of| of != at && is_of(&modes[of]));
        let Some(of) = of.filter(|_| mode.suspicion.is_none()) else { continue };
        let share = share_of(mode, &modes[of]).unwrap_or(WEAKER);
        let what = format!(
            "{:.3} Hz lies within the width of the mode at {:.3} Hz and has {:.1} % of its \
             amplitude: sensors that are not quite linear, such as the sub-pixel errors of a \
             camera, make as much; left out of the table, and the other mode's standard \
             deviations include it; measure larger motion, or with other sensors, to tell",
            mode.frequency_hz,
            modes[of].frequency_hz,
            percent_from_ratio(share)
        );
        notes.warning(Code::Unsettled, None, what);
        modes[at].suspicion = Some(Code::Unsettled);
        let of = &mut modes[of];
        of.frequency_std_hz = of.frequency_std_hz.hypot(share * decay(of));
        of.damping_std = of.damping_std.hypot(share * of.damping_ratio);
    }
}

/// How large a mode is over all responses, against others of its record that are near it.
fn size(mode: &Mode) -> Option<f64> {
    let of_shape = || mode.shape.iter().map(|part| part.value.norm_sqr()).sum::<f64>().sqrt();
    let constants = mode.shape.iter().map(|part| Some(part.modal_constant?.norm_sqr()));
    let by_force = constants.sum::<Option<f64>>().map(f64::sqrt);
    mode.amplitude.map(|amplitude| amplitude * of_shape()).or(by_force)
}

/// Leakage, and records too short.
fn length(prepared: &Prepared, mode: &Mode, notes: &mut Notes) {
    const MIN_PERIODS: f64 = 8.0;
    const MIN_DECAY_TIMES: f64 = 0.7;
    /// Remaining amplitude at the record's end from which on a decay leaks.
    const MAX_REMAINING: f64 = 0.05;
    let duration = duration_s(prepared);
    if let Some(stationary) = &prepared.stationary {
        enough_of_it(stationary.duration_s(), mode, notes);
        return;
    }
    if duration.is_infinite() || prepared.kind == RecordKind::Steady {
        return;
    }
    let periods = duration * mode.frequency_hz;
    let decay_times = duration * mode.damping_ratio.max(0.0) * rad_per_s_from_hz(mode.frequency_hz);
    let remaining = (-decay_times).exp();
    if periods < MIN_PERIODS || decay_times < MIN_DECAY_TIMES {
        let what = format!(
            "has {periods:.1} periods and {decay_times:.2} decay times of the mode at {:.3} Hz, \
             must have at least {MIN_PERIODS:.0} and {MIN_DECAY_TIMES}; record for longer",
            mode.frequency_hz
        );
        notes.warning(Code::ShortRecord, None, what);
    } else if remaining > MAX_REMAINING {
        let what = format!(
            "ends before the mode at {:.3} Hz has decayed ({:.0} % of its amplitude remain); the \
             fit allows for that, a windowed spectrum would not; record for {:.1} s or more",
            mode.frequency_hz,
            percent_from_ratio(remaining),
            -MAX_REMAINING.ln() / decay_times * duration
        );
        notes.warning(Code::Leakage, None, what);
    }
}

/// A random response must hold many times over what a mode remembers of its past.
fn enough_of_it(duration_s: f64, mode: &Mode, notes: &mut Notes) {
    const MIN_DECAY_TIMES: f64 = 20.0;
    let per_s = mode.damping_ratio * rad_per_s_from_hz(mode.frequency_hz);
    if duration_s * per_s < MIN_DECAY_TIMES {
        let what = format!(
            "has {:.1} decay times of the mode at {:.3} Hz, must have at least {MIN_DECAY_TIMES} \
             where the force goes on and was not measured; record for {:.0} s or more",
            duration_s * per_s,
            mode.frequency_hz,
            MIN_DECAY_TIMES / per_s
        );
        notes.warning(Code::ShortRecord, None, what);
    }
}

/// Time that modes have to decay, s; infinite for given frequency responses.
fn duration_s(prepared: &Prepared) -> f64 {
    prepared
        .blocks
        .iter()
        .map(|block| match &block.origin {
            Origin::Sampled { step_s, samples, force } => {
                // A hammer record's last impact has the least time.
                let last =
                    force.as_ref().and_then(|force| force.last()).map_or(0.0, |sample| sample.at);
                let from = if prepared.kind == RecordKind::Hammer { last } else { 0.0 };
                (*samples as f64 - from) * step_s
            }
            Origin::Responses { .. } => f64::INFINITY,
        })
        .fold(0.0, f64::max)
}

fn coherence(prepared: &Prepared, mode: &Mode, notes: &mut Notes) {
    let Some(averaged) = prepared.averaged.as_ref().filter(|a| !a.coherence.is_empty()) else {
        return;
    };
    let Some(bin) = averaged.frequencies_hz.get(1) else { return };
    let at = (mode.frequency_hz / bin).round() as usize;
    for (response, coherence) in prepared.responses.iter().zip(&averaged.coherence) {
        if let Some(value) = coherence.get(at).filter(|value| **value < 0.8) {
            let what = format!(
                "coherence is {value:.2} at the mode at {:.3} Hz ({} averages): noise, a moving \
                 impact point, or a point near a node of this mode",
                mode.frequency_hz, averaged.averages
            );
            notes.channel_warning(Code::LowCoherence, &response.name, what);
        }
    }
}

/// The contact of a soft tip lasts so long that it cannot excite high modes.
fn force(prepared: &Prepared, mode: &Mode, notes: &mut Notes) {
    if prepared.kind != RecordKind::Hammer {
        return;
    }
    let Some(block) = prepared.blocks.first() else { return };
    let omega = rad_per_s_from_hz(mode.frequency_hz);
    let strongest = block.drive.iter().map(|f| f.norm()).fold(0.0, f64::max);
    let spacing = block.omega.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(0.0);
    // Several impacts make a comb: its envelope counts.
    let reach = (0.02 * omega).max(20.0 * spacing);
    let near = block.omega.iter().zip(&block.drive).filter(|(w, _)| (*w - omega).abs() < reach);
    let here = near.map(|(_, f)| f.norm()).fold(0.0, f64::max);
    if here < 0.03 * strongest {
        let what = format!(
            "at the mode at {:.3} Hz the force has {:.1} % of its highest amplitude: the hammer \
             hardly excites it; use a harder tip",
            mode.frequency_hz,
            percent_from_ratio(here / strongest)
        );
        notes.warning(Code::WeakForce, None, what);
    }
}

/// Frequencies that may be folded: near half the sampling rate, or anywhere where the rate is so
/// low that an arm's own modes lie above half of it.
fn may_be_folded(prepared: &Prepared, mode: &Mode, notes: &mut Notes) {
    /// Cameras and telephones below this rate have modes of an arm above half of it, and no filter.
    const LOW_RATE_HZ: f64 = 100.0;
    /// Near half the sampling rate, as a share of it.
    const NEAR: f64 = 0.75;
    let Some(nyquist) = prepared.nyquist_hz.filter(|_| mode.suspicion.is_none()) else { return };
    let (hz, rate) = (mode.frequency_hz, 2.0 * nyquist);
    let what = if rate < LOW_RATE_HZ {
        format!(
            "{hz:.3} Hz may be an alias: at {rate} samples/s modes at {:.3} and {:.3} Hz look the \
             same, and arms have modes there; record once more at another sampling rate",
            rate - hz,
            rate + hz
        )
    } else if hz > NEAR * nyquist {
        format!(
            "{hz:.3} Hz lies near half the sampling rate ({nyquist:.1} Hz): without an \
             anti-aliasing filter it may be an alias of {:.3} Hz; record once more at another \
             sampling rate",
            rate - hz
        )
    } else {
        return;
    };
    notes.warning(Code::MayBeFolded, None, what);
}

/// Residues over several references must be of one shape.
fn one_shape(mode: &Mode, notes: &mut Notes) {
    /// Share of their power.
    const MOST: f64 = 0.05;
    if let Some(apart) = mode.apart.filter(|apart| *apart > MOST) {
        let what = format!(
            "{:.0} % of the mode at {:.3} Hz over the references are not of one shape: directions \
             or places of the points are wrong, the arm changed between the hits, or two modes lie \
             there",
            percent_from_ratio(apart),
            mode.frequency_hz
        );
        notes.warning(Code::Disagreement, None, what);
    }
}
