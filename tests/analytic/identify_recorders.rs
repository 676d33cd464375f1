//! What recorders and their rooms add to a record: amplifiers without direct current, two clocks, floors that sway,
//! windows over clipped samples, coarse steps, times in another unit, other signs.

use crate::identify::{asked, few, record};
use crate::vibration::{
    C64, TrueMode, channel_of, free_decay, gauss, hammered, noisy, pulses, rms, seeded,
};
use detune::identify::record::{Data, Frf, Instrument, Quantity, Record};
use detune::identify::record_modes::{IdentifiedRecord, identify_record};
use detune::notes::Code;

const RATE_HZ: f64 = 500.0;

fn arm() -> Vec<TrueMode> {
    vec![
        TrueMode::new(11.2, 0.014, &[1.0, 0.7, 0.4]),
        TrueMode::new(17.9, 0.020, &[0.8, -0.9, 0.6]),
        TrueMode::new(26.8, 0.017, &[-0.6, -0.5, 1.0]),
    ]
}

fn identify(record: &Record) -> IdentifiedRecord {
    identify_record(record, &asked(&[50.0, 60.0]))
}

fn acceleration(force: Option<Vec<f64>>, responses: Vec<Vec<f64>>) -> Record {
    record(RATE_HZ, force, responses, Quantity::Acceleration)
}

fn has(found: &IdentifiedRecord, code: Code, words: &str) -> bool {
    found.warnings.iter().any(|note| note.code == code && note.what.contains(words))
}

/// The table has these modes and no other, each within five deviations, and damping within a twentieth.
fn must_be(found: &IdentifiedRecord, truth: &[TrueMode], what: &str) {
    let listed: Vec<_> = found.modes.iter().filter(|mode| mode.suspicion.is_none()).collect();
    let told: Vec<_> = listed.iter().map(|m| (m.frequency_hz, m.damping_ratio)).collect();
    assert_eq!(told.len(), truth.len(), "{what}: {told:?} {:?}", found.warnings);
    for (mode, truth) in listed.iter().zip(truth) {
        let off = (mode.frequency_hz - truth.hz).abs();
        assert!(off < 5.0 * mode.frequency_std_hz + 1e-4 * truth.hz, "{what}: {told:?}");
        assert!((mode.damping_ratio / truth.ratio - 1.0).abs() < 0.05, "{what}: {told:?}");
    }
}

/// A capacitor and a resistor in the way: y' = x' − 2π corner y.
fn coupled(samples: &[f64], corner_hz: f64) -> Vec<f64> {
    let share = 1.0 / (1.0 + std::f64::consts::TAU * corner_hz / RATE_HZ);
    let (mut before, mut y) = (0.0, 0.0);
    let next = |x: &f64| {
        y = share * (y + x - before);
        before = *x;
        y
    };
    samples.iter().map(next).collect()
}

/// Of all channels alike, once and twice; without it nothing is said.
#[test]
fn an_amplifier_without_direct_current_bends_nothing() {
    let force = pulses(9000, &[200, 3300, 6200], 5, 300.0);
    let clean = hammered(&arm(), 0, 2, RATE_HZ, &force);
    let mut rng = seeded(1);
    for (corner_hz, times) in [(0.0, 0), (0.5, 1), (1.5, 1), (3.0, 1), (0.5, 2), (1.5, 2), (3.0, 2)]
    {
        let through = |own: &Vec<f64>| (0..times).fold(own.clone(), |x, _| coupled(&x, corner_hz));
        let responses: Vec<Vec<f64>> = clean.iter().map(through).collect();
        let mut heard = through(&force);
        heard.iter_mut().for_each(|f| *f += 0.03 * gauss(&mut rng));
        let found = identify(&acceleration(Some(heard), noisy(&responses, 0.02, &mut rng)));
        let what = format!("{times} times {corner_hz} Hz");
        must_be(&found, &arm(), &what);
        assert!(!has(&found, Code::AmplitudeDependent, ""), "{what}: {:?}", found.warnings);
        assert_eq!(has(&found, Code::Remark, "AC coupling"), times > 0, "{what}");
    }
}

/// The first response runs at another clock than the two others: its modes lie at so much of theirs.
#[test]
fn two_clocks_are_told_and_double_no_mode() {
    for (seed, factor) in [1.0, 1.01, 0.99, 0.995, 1.001].into_iter().enumerate() {
        let others = free_decay(&arm(), 2, RATE_HZ, 3500, 0);
        let moved: Vec<TrueMode> =
            arm().iter().map(|m| TrueMode::new(m.hz * factor, m.ratio, &m.shape)).collect();
        let own = free_decay(&moved, 2, RATE_HZ, 3500, 0);
        let all = vec![own[0].clone(), others[1].clone(), others[2].clone()];
        let noisy = noisy(&all, 0.02, &mut seeded(seed as u64));
        let found = identify(&Record { driving_point: None, ..acceleration(None, noisy) });
        must_be(&found, &arm(), &format!("{factor}"));
        let told: Vec<_> = found.warnings.iter().filter(|n| n.what.contains("clock")).collect();
        assert_eq!(told.len(), usize::from(factor != 1.0), "{factor}: {:?}", found.warnings);
        // Which clock is right nobody knows.
        let apart = 0.97 * (factor - 1.0).abs();
        assert!(found.modes.iter().all(|m| m.frequency_std_hz >= apart * m.frequency_hz));
        assert!(told.iter().all(|note| channel_of(note) == Some("r0")), "{told:?}");
    }
}

/// A stand on a floor, both of which sway near 0.9 Hz as noise drives them, as far as the arm moves: it hides none of
/// the arm's modes, and is no mains. Poles of the sway itself still enter the table for some seeds.
#[test]
fn a_floor_that_sways_hides_no_mode_and_is_no_mains() {
    let mut told = 0;
    for seed in 0..few(8) {
        let mut rng = seeded(40 + seed);
        let force = pulses(4096, &[150], 5, 300.0);
        let mut responses = noisy(&hammered(&arm(), 0, 0, RATE_HZ, &force), 0.01, &mut rng);
        let wind: Vec<f64> = (0..4096 + 4000).map(|_| gauss(&mut rng)).collect();
        let floor = hammered(&[TrueMode::new(0.7, 0.3, &[1.0])], 0, 0, RATE_HZ, &wind);
        let stand = hammered(&[TrueMode::new(0.9, 0.3, &[1.0])], 0, 0, RATE_HZ, &floor[0]);
        let sway = &stand[0][4000..];
        let size = rms(&responses[0]) / rms(sway);
        for samples in &mut responses {
            samples.iter_mut().zip(sway).for_each(|(y, s)| *y += size * s);
        }
        let found = identify(&record(RATE_HZ, Some(force), responses, Quantity::Displacement));
        let listed = found.modes.iter().filter(|mode| mode.suspicion.is_none());
        let hz: Vec<f64> = listed.map(|mode| mode.frequency_hz).collect();
        for truth in arm() {
            let is_there = hz.iter().any(|hz| (hz / truth.hz - 1.0).abs() < 1e-3);
            assert!(is_there, "seed {seed}: {hz:?} {:?}", found.warnings);
        }
        assert!(!has(&found, Code::Mains, ""), "seed {seed}: {:?}", found.warnings);
        told += u32::from(has(&found, Code::Remark, "sways"));
    }
    assert!(told > 0);
}

/// A machine near by at 1.3 Hz: its tone neither decays nor enters the table, whatever its sign of damping.
#[test]
fn a_tone_that_does_not_decay_stays_out_of_the_table() {
    for seed in 0..few(8) {
        let mut responses =
            noisy(&free_decay(&arm(), 2, RATE_HZ, 3500, 0), 0.01, &mut seeded(seed));
        for samples in &mut responses {
            let size = 1.5 * rms(samples);
            for (k, y) in samples.iter_mut().enumerate() {
                *y += size * (std::f64::consts::TAU * 1.3 * k as f64 / RATE_HZ + 0.4).sin();
            }
        }
        must_be(&identify(&acceleration(None, responses)), &arm(), &format!("seed {seed}"));
    }
}

/// Clipped before an analyser laid its window over it, and by what wrote the file: both are told. Seven digits.
#[test]
fn clipping_is_seen_under_an_exponential_window() {
    let window = |k: usize| (-(k as f64) / RATE_HZ / 1.2).exp();
    let digits = |y: f64| format!("{y:.6e}").parse::<f64>().unwrap();
    let clean = noisy(&free_decay(&arm(), 2, RATE_HZ, 2000, 0), 0.003, &mut seeded(3));
    let instrument = Instrument { exponential_window_s: Some(1.2), ..Instrument::default() };
    for (before, after) in [(0.2, 9.0), (9.0, 0.2), (9.0, 9.0)] {
        let mut responses = clean.clone();
        let most = responses[1].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for (k, y) in responses[1].iter_mut().enumerate() {
            let clipped = y.clamp(-before * most, before * most) * window(k);
            *y = digits(clipped.clamp(-after * most, after * most));
        }
        for samples in [0, 2] {
            responses[samples]
                .iter_mut()
                .enumerate()
                .for_each(|(k, y)| *y = digits(*y * window(k)));
        }
        let found = identify(&Record { instrument, ..acceleration(None, responses) });
        let what = format!("before {before}, after {after}");
        let told: Vec<_> =
            found.warnings.iter().filter(|note| note.code == Code::Clipping).collect();
        assert_eq!(told.is_empty(), before > 1.0 && after > 1.0, "{what}: {:?}", found.warnings);
        assert!(told.iter().all(|note| channel_of(note) == Some("r1")), "{what}: {told:?}");
        must_be(&found, &arm(), &what);
    }
}

/// Twelve bits and many samples a period: the motion turns round in runs of equal samples.
#[test]
fn slow_motion_in_coarse_steps_is_neither_lost_nor_clipped() {
    const FAST_HZ: f64 = 2048.0;
    let slow = [TrueMode::new(3.1, 0.01, &[1.0, 0.7]), TrueMode::new(9.7, 0.02, &[0.4, -0.5])];
    for bits in [10, 11, 12] {
        let mut responses = free_decay(&slow, 0, FAST_HZ, 16_384, 0);
        for samples in &mut responses {
            let most = samples.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let step = most / f64::from(1 << (bits - 1));
            samples.iter_mut().for_each(|y| *y = (*y / step).round() * step);
        }
        let found = identify(&record(FAST_HZ, None, responses, Quantity::Displacement));
        let wrong = [Code::Clipping, Code::Dropout];
        let told: Vec<_> = found.warnings.iter().filter(|n| wrong.contains(&n.code)).collect();
        assert!(told.is_empty(), "{bits} bits: {told:?}");
    }
}

#[test]
fn times_in_another_unit_are_doubted() {
    let decay = noisy(&free_decay(&arm(), 2, RATE_HZ, 3500, 0), 0.01, &mut seeded(2));
    for (rate, is_told) in [(RATE_HZ, false), (1e3 * RATE_HZ, true)] {
        let found = identify(&record(rate, None, decay.clone(), Quantity::Acceleration));
        assert_eq!(has(&found, Code::Units, "unit of the times"), is_told, "{rate}");
    }
}

/// The driving point goes where the force pushes it.
#[test]
fn a_force_with_the_other_sign_is_told() {
    let force = pulses(3500, &[150], 5, 300.0);
    let responses = noisy(&hammered(&arm(), 0, 2, RATE_HZ, &force), 0.01, &mut seeded(2));
    for sign in [1.0, -1.0] {
        let heard = force.iter().map(|f| sign * f).collect();
        let found = identify(&acceleration(Some(heard), responses.clone()));
        must_be(&found, &arm(), &format!("{sign}"));
        assert_eq!(has(&found, Code::Disagreement, "wrong sign"), sign < 0.0, "{sign}");
    }
}

/// Σ A/(ω_r² − ω² + 2iζω_rω) over the force, of quarter lines.
fn responses(change: impl Fn(f64, C64) -> C64) -> Record {
    let mut rng = seeded(8);
    let hz: Vec<f64> = (8..320).map(|k| 0.25 * f64::from(k)).collect();
    let function = |response: usize| {
        let value = |hz: &f64| {
            let of = |mode: &TrueMode| {
                let below = C64::new(mode.hz.powi(2) - hz * hz, 2.0 * mode.ratio * mode.hz * hz);
                mode.shape[0] * mode.shape[response] / below
            };
            let noise = C64::new(gauss(&mut rng), gauss(&mut rng)) * 1e-5;
            change(*hz, arm().iter().map(of).sum::<C64>() + noise)
        };
        Frf {
            name: format!("r{response}"),
            reference: "hammer".into(),
            quantity: Quantity::Displacement,
            frequencies_hz: hz.clone(),
            values: hz.iter().map(value).collect(),
        }
    };
    let data = Data::Responses((0..3).map(function).collect());
    Record { data, ..record(1.0, None, Vec::new(), Quantity::Displacement) }
}

#[test]
fn responses_with_the_other_sign_of_phase_are_told_and_read_as_such() {
    let sound = identify(&responses(|_, value| value));
    must_be(&sound, &arm(), "sound");
    assert!(!has(&sound, Code::Disagreement, ""), "{:?}", sound.warnings);
    let turned = identify(&responses(|_, value| value.conj()));
    must_be(&turned, &arm(), "turned");
    assert!(has(&turned, Code::Disagreement, "convention"), "{:?}", turned.warnings);
}

/// An analyser sets the lines near 50 Hz to zero, and some within a mode.
#[test]
fn lines_that_an_analyser_blanked_are_left_out() {
    let is_blank = |hz: f64| (hz - 50.0).abs() < 0.6 || (hz - 17.75).abs() < 0.1;
    let found = identify(&responses(|hz, value| if is_blank(hz) { C64::default() } else { value }));
    must_be(&found, &arm(), "blank");
    assert!(has(&found, Code::Remark, "exactly zero"), "{:?}", found.warnings);
}
