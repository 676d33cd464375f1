//! What a mode may be beside a mode, and what a record may lack for it.

use super::estimate::Origin;
use super::notice::{NoticeKind, Notices};
use super::prepare::{Kind, Prepared};
use super::record::Record;
use super::record_modes::Mode;
use crate::units::{hz_from_rpm, percent_from_ratio, rad_per_s_from_hz};

/// Harmonics of the mains and of the spindle that are looked for.
const MAINS_HARMONICS: u32 = 20;
const SPINDLE_HARMONICS: u32 = 10;

/// A steady tone has no damping; records of finite length and drifting speed blur it up to this ratio.
const TONE_DAMPING: f64 = 2e-3;

/// How far a tone may lie from the exact multiple: the mains drifts by this share, spindles slip more.
const MAINS_SLACK: f64 = 2e-3;
const SPINDLE_SLACK: f64 = 5e-3;

/// A frequency that is no better known than this share is vague; so is damping, where no order of the
/// stabilisation diagram bears the mode out.
const VAGUE_FREQUENCY: f64 = 3e-3;
const VAGUE_DAMPING: f64 = 0.5;

/// Coherence below this at a mode is low.
const LOW_COHERENCE: f64 = 0.8;

/// A force below this share of its highest amplitude hardly excites a mode.
const WEAK_FORCE: f64 = 0.03;

/// How far around a mode the force is looked at, as a share of its frequency, and in lines at the least.
const NEAR_FORCE: f64 = 0.02;
const NEAR_LINES: f64 = 20.0;

/// A decay that is this far from over at the record's end leaks.
const LEAKS: f64 = 0.05;

/// Periods of a mode that a record must have, and decay times.
const FEWEST_PERIODS: f64 = 8.0;
const FEWEST_DECAY_TIMES: f64 = 0.7;

/// Frequencies above this share of half the sampling rate may well be folded.
const FOLDED_ABOVE: f64 = 0.75;

/// Tells all of it, and marks modes that are likely tones.
pub(super) fn tell(
    record: &Record,
    prepared: &Prepared,
    mains_hz: &[f64],
    modes: &mut [Mode],
    notices: &mut Notices,
) {
    for mode in modes {
        tones(record, prepared, mains_hz, mode, notices);
        uncertain(mode, notices);
        if mode.suspicion.is_none() {
            length(prepared, mode, notices);
            coherence(prepared, mode, notices);
            force(prepared, mode, notices);
        }
        folded(prepared, mode, notices);
    }
}

/// Multiples of a frequency, as they are or folded about half the sampling rate, and the mode among them.
fn multiple(
    mode: &Mode,
    base_hz: f64,
    most: u32,
    slack: f64,
    nyquist_hz: Option<f64>,
) -> Option<(u32, bool)> {
    (1..=most).find_map(|order| {
        let true_hz = f64::from(order) * base_hz;
        let seen_hz = match nyquist_hz {
            Some(nyquist) => {
                let rest = true_hz % (2.0 * nyquist);
                if rest > nyquist { 2.0 * nyquist - rest } else { rest }
            }
            None => true_hz,
        };
        let within = (slack * true_hz).max(3.0 * mode.frequency_std_hz);
        ((mode.frequency_hz - seen_hz).abs() <= within)
            .then_some((order, (seen_hz - true_hz).abs() > 1e-9))
    })
}

fn tones(
    record: &Record,
    prepared: &Prepared,
    mains_hz: &[f64],
    mode: &mut Mode,
    notices: &mut Notices,
) {
    if mode.damping_ratio > TONE_DAMPING.max(2.0 * mode.damping_std).min(4.0 * TONE_DAMPING) {
        return;
    }
    let mains = mains_hz.iter().map(|hz| (*hz, MAINS_HARMONICS, MAINS_SLACK, NoticeKind::Mains));
    let spindle = record
        .spindle_rpm
        .map(|rpm| (hz_from_rpm(rpm), SPINDLE_HARMONICS, SPINDLE_SLACK, NoticeKind::Spindle));
    for (base_hz, most, slack, kind) in mains.chain(spindle) {
        if let Some((order, is_folded)) = multiple(mode, base_hz, most, slack, prepared.nyquist_hz)
        {
            let source = if kind == NoticeKind::Mains { "mains" } else { "spindle" };
            let folded = if is_folded { ", folded about half the sampling rate" } else { "" };
            let what = format!(
                "{:.3} Hz has next to no damping ({:.5}) and lies at {order} times the {source}'s {base_hz:.3} \
                 Hz{folded}: likely no mode of the arm; it is not written to the table",
                mode.frequency_hz, mode.damping_ratio
            );
            notices.add(kind, None, what);
            mode.suspicion = Some(kind);
            return;
        }
    }
    let what = format!(
        "{:.3} Hz has next to no damping ({:.5}): a steady tone, such as a machine nearby, looks like that",
        mode.frequency_hz, mode.damping_ratio
    );
    notices.add(NoticeKind::Tone, None, what);
}

/// What is fitted and yet no finding: without damping beyond doubt, or so uncertain that nothing bears it out.
fn uncertain(mode: &mut Mode, notices: &mut Notices) {
    let share = mode.frequency_std_hz / mode.frequency_hz.max(f64::MIN_POSITIVE);
    let is_vague = share > VAGUE_FREQUENCY;
    let has_no_damping = mode.damping_ratio <= 0.0;
    let is_unknown = is_vague && mode.damping_std > mode.damping_ratio;
    let is_alone =
        mode.support == 0.0 && (is_vague || mode.damping_std > VAGUE_DAMPING * mode.damping_ratio);
    if mode.suspicion.is_some() || !(has_no_damping || is_unknown || is_alone) {
        return;
    }
    let what = format!(
        "{:.3} ± {:.3} Hz with damping ratio {:.5} ± {:.5}, in {:.0} % of the orders, is not certain enough to be a \
         mode: it is not written to the table",
        mode.frequency_hz,
        mode.frequency_std_hz,
        mode.damping_ratio,
        mode.damping_std,
        percent_from_ratio(mode.support)
    );
    notices.add(NoticeKind::Unsettled, None, what);
    mode.suspicion = Some(NoticeKind::Unsettled);
}

/// Leakage, and records too short.
fn length(prepared: &Prepared, mode: &Mode, notices: &mut Notices) {
    let duration = prepared
        .blocks
        .iter()
        .map(|block| match &block.origin {
            Origin::Sampled { step_s, samples, force } => {
                // A hammer record's last hit has least time.
                let last =
                    force.as_ref().and_then(|force| force.last()).map_or(0.0, |push| push.at);
                let from = if prepared.kind == Kind::Hammer { last } else { 0.0 };
                (*samples as f64 - from) * step_s
            }
            Origin::Responses => f64::INFINITY,
        })
        .fold(0.0, f64::max);
    if duration.is_infinite() || prepared.kind == Kind::Steady {
        return;
    }
    let periods = duration * mode.frequency_hz;
    let decay_times = duration * mode.damping_ratio.max(0.0) * rad_per_s_from_hz(mode.frequency_hz);
    let left = (-decay_times).exp();
    if periods < FEWEST_PERIODS || decay_times < FEWEST_DECAY_TIMES {
        let what = format!(
            "has {periods:.1} periods and {decay_times:.2} decay times of the mode at {:.3} Hz, fewer than it needs \
             (at least {FEWEST_PERIODS:.0} and {FEWEST_DECAY_TIMES}): record for longer",
            mode.frequency_hz
        );
        notices.add(NoticeKind::ShortRecord, None, what);
    } else if left > LEAKS {
        let what = format!(
            "ends before the mode at {:.3} Hz has decayed ({:.0} % are left); the fit takes that into account, a \
             spectrum with windows would not; record for {:.1} s or more",
            mode.frequency_hz,
            percent_from_ratio(left),
            -LEAKS.ln() / decay_times * duration
        );
        notices.add(NoticeKind::Leakage, None, what);
    }
}

fn coherence(prepared: &Prepared, mode: &Mode, notices: &mut Notices) {
    let Some(averaged) = prepared.averaged.as_ref().filter(|a| !a.coherence.is_empty()) else {
        return;
    };
    let Some(bin) = averaged.frequencies_hz.get(1) else { return };
    let at = (mode.frequency_hz / bin).round() as usize;
    for (response, coherence) in prepared.responses.iter().zip(&averaged.coherence) {
        if let Some(value) = coherence.get(at).filter(|value| **value < LOW_COHERENCE) {
            let what = format!(
                "coherence is {value:.2} at the mode at {:.3} Hz ({} averages): noise, a moving hit point, or a \
                 point that stands nearly still in this mode",
                mode.frequency_hz, averaged.averages
            );
            notices.add(NoticeKind::LowCoherence, Some(&response.name), what);
        }
    }
}

/// A soft tip is in touch for so long that it cannot excite high modes.
fn force(prepared: &Prepared, mode: &Mode, notices: &mut Notices) {
    if prepared.kind != Kind::Hammer {
        return;
    }
    let Some(block) = prepared.blocks.first() else { return };
    let omega = rad_per_s_from_hz(mode.frequency_hz);
    let strongest = block.drive.iter().map(|f| f.norm()).fold(0.0, f64::max);
    let spacing = block.omega.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(0.0);
    // Several hits make a comb: what counts is its envelope.
    let reach = (NEAR_FORCE * omega).max(NEAR_LINES * spacing);
    let near = block.omega.iter().zip(&block.drive).filter(|(w, _)| (*w - omega).abs() < reach);
    let here = near.map(|(_, f)| f.norm()).fold(0.0, f64::max);
    if here < WEAK_FORCE * strongest {
        let what = format!(
            "at the mode at {:.3} Hz the force has {:.1} % of its highest amplitude: the hammer hardly excites it; use \
             a harder tip",
            mode.frequency_hz,
            percent_from_ratio(here / strongest)
        );
        notices.add(NoticeKind::WeakForce, None, what);
    }
}

fn folded(prepared: &Prepared, mode: &Mode, notices: &mut Notices) {
    let Some(nyquist) = prepared.nyquist_hz else { return };
    if mode.suspicion.is_none() && mode.frequency_hz > FOLDED_ABOVE * nyquist {
        let what = format!(
            "{:.3} Hz lies near half the sampling rate ({nyquist:.1} Hz): without a filter against aliasing it may \
             be {:.3} Hz folded; record once at another rate to tell",
            mode.frequency_hz,
            2.0 * nyquist - mode.frequency_hz
        );
        notices.add(NoticeKind::MayBeFolded, None, what);
    }
}
