//! What an instrument does to a record beside measuring it: exponential windows, delays between force and
//! responses.

use crate::identify::{asked, few, record};
use crate::vibration::{C64, TrueMode, free_decay, hammered, noisy, pulses, seeded};
use detune::identify::mode::Mode;
use detune::identify::record::{Data, Frf, Instrument, Quantity, Record};
use detune::identify::record_modes::{IdentifiedRecord, identify_record};
use detune::notes::Code;

const RATE_HZ: f64 = 250.0;

/// Samples of the simulation for each of the record.
const OVER: usize = 40;

fn arm() -> Vec<TrueMode> {
    vec![
        TrueMode::new(12.0, 0.03, &[1.0, 0.5, 0.2]),
        TrueMode::new(25.0, 0.02, &[0.6, -0.8, 0.5]),
        TrueMode::new(58.0, 0.015, &[0.3, 0.4, -0.7]),
    ]
}

fn found(record: &Record, instrument: Instrument) -> IdentifiedRecord {
    identify_record(&Record { instrument, ..record.clone() }, &asked(&[]))
}

fn has(found: &IdentifiedRecord, code: Code) -> bool {
    found.warnings.iter().any(|note| note.code == code)
}

/// Every mode and no other, within four of its standard deviations, and within 0.1 % of frequency and 10 % of
/// damping.
fn must_be_the_arm(found: &IdentifiedRecord, what: &str) {
    let told: Vec<_> = found.modes.iter().map(|m| (m.frequency_hz, m.damping_ratio)).collect();
    assert_eq!(told.len(), 3, "{what}: {told:?} {:?}", found.warnings);
    for (mode, truth) in found.modes.iter().zip(arm()) {
        let off = (mode.frequency_hz - truth.hz).abs();
        assert!(off < 1e-3 * truth.hz && off < 4.0 * mode.frequency_std_hz, "{what}: {told:?}");
        let off = (mode.damping_ratio - truth.ratio).abs();
        assert!(off < 0.1 * truth.ratio && off < 4.0 * mode.damping_std, "{what}: {told:?}");
    }
}

/// Four blows; the responses are late by whole samples of the simulation, which are 0.1 ms.
fn hammer_record(late: usize, quantity: Quantity, seed: u64) -> Record {
    let count = 4000;
    let starts = [50, 1000, 2000, 3000].map(|start| start * OVER);
    let force = pulses(count * OVER, &starts, 3 * OVER, 40.0);
    let derivatives = quantity.derivatives().unwrap();
    let moves = hammered(&arm(), 0, derivatives, RATE_HZ * OVER as f64, &force);
    let sampled = |samples: &[f64], late: usize| -> Vec<f64> {
        (0..count).map(|k| (k * OVER).checked_sub(late).map_or(0.0, |at| samples[at])).collect()
    };
    let clean: Vec<Vec<f64>> = moves.iter().map(|own| sampled(own, late)).collect();
    let noisy = noisy(&clean, 0.01, &mut seeded(seed));
    record(RATE_HZ, Some(sampled(&force, 0)), noisy, quantity)
}

#[test]
fn a_delay_that_is_stated_is_taken_off() {
    for (seed, late) in [(1, 8), (2, 22), (3, 50), (4, 130)] {
        let record = hammer_record(late, Quantity::Displacement, seed);
        let delay_s = late as f64 / (RATE_HZ * OVER as f64);
        let stated = Instrument { response_delay_s: delay_s, ..Instrument::default() };
        let what = format!("{} ms", 1e3 * delay_s);
        let found = found(&record, stated);
        must_be_the_arm(&found, &what);
        assert!(!has(&found, Code::Delay), "{what}: {:?}", found.warnings);
    }
}

#[test]
fn a_delay_that_is_not_stated_is_suspected() {
    for seed in 1..=3 {
        let found = found(&hammer_record(0, Quantity::Acceleration, seed), Instrument::default());
        assert!(!has(&found, Code::Delay), "{:?}", found.warnings);
    }
    for (seed, late) in (1..=few(10)).flat_map(|seed| [(seed, 22), (seed, 50)]) {
        let record = hammer_record(late, Quantity::Acceleration, seed);
        let found = found(&record, Instrument::default());
        assert!(has(&found, Code::Delay), "{seed} {late}: {:?}", found.warnings);
    }
}

/// The window is laid over noise, too, and over responses alone.
fn windowed(record: &Record, window_s: f64) -> Record {
    let mut record = record.clone();
    let Data::Time { responses, .. } = &mut record.data else { unreachable!("sampled") };
    for channel in responses.iter_mut() {
        for (k, sample) in channel.samples.iter_mut().enumerate() {
            *sample *= (-(k as f64) / RATE_HZ / window_s).exp();
        }
    }
    record
}

/// The same samples, each with its time.
fn with_times(record: &Record) -> Record {
    let Data::Time { responses, excitation, .. } = record.data.clone() else {
        unreachable!("sampled")
    };
    let times_s = (0..responses[0].samples.len()).map(|k| k as f64 / RATE_HZ).collect();
    Record { data: Data::Uneven { times_s, excitation, responses }, ..record.clone() }
}

#[test]
fn an_exponential_window_that_is_stated_is_taken_off() {
    let window_s = 0.8;
    let stated = Instrument { exponential_window_s: Some(window_s), ..Instrument::default() };
    let force = pulses(1000, &[20], 5, 40.0);
    for seed in 0..few(4) {
        let decay = noisy(&free_decay(&arm(), 2, RATE_HZ, 1000, 0), 0.02, &mut seeded(seed));
        let hit = noisy(&hammered(&arm(), 0, 2, RATE_HZ, &force), 0.01, &mut seeded(seed));
        for (what, force, responses) in
            [("decay", None, decay), ("hammer", Some(force.clone()), hit)]
        {
            let record = record(RATE_HZ, force, responses, Quantity::Acceleration);
            let record = windowed(&record, window_s);
            must_be_the_arm(&found(&record, stated), &format!("{what}, seed {seed}"));
            let uneven = found(&with_times(&record), stated);
            let near = uneven.modes.iter().find(|mode| (mode.frequency_hz - 12.0).abs() < 0.1);
            let ratio = near.map_or(f64::NAN, |mode| mode.damping_ratio);
            assert!((ratio / 0.03 - 1.0).abs() < 0.1, "{what}, seed {seed}, uneven: {ratio}");
            // 1/τ over 2π f is half of the first mode's damping.
            let unstated = found(&record, Instrument::default());
            let off = |mode: &Mode| (mode.frequency_hz - 12.0).abs();
            let near = unstated.modes.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            let first = near.unwrap().damping_ratio;
            assert!((first / 0.03 - 1.55).abs() < 0.1, "{what}: {first}");
        }
    }
}

/// Σ A/(iω − λ) and its conjugate, as an analyser gives it: of an exponential window of 0.8 s, or late by 4 ms.
#[test]
fn what_an_analyser_did_is_taken_off_its_responses() {
    let values = |response: usize, lambda_moves: f64, delay_s: f64| -> Vec<C64> {
        let line = |k: usize| {
            let s = C64::new(0.0, std::f64::consts::TAU * 0.1 * k as f64);
            let mode = |mode: &TrueMode| {
                let (size, lambda) =
                    (mode.shape[0] * mode.shape[response], mode.lambda() - lambda_moves);
                let residue = C64::new(0.0, -size / (2.0 * lambda.im));
                residue / (s - lambda) + residue.conj() / (s - lambda.conj())
            };
            arm().iter().map(mode).sum::<C64>() * (-s * delay_s).exp()
        };
        (10..1000).map(line).collect()
    };
    let record = |lambda_moves: f64, delay_s: f64| {
        let function = |response: usize| Frf {
            name: format!("r{response}"),
            reference: "hammer".into(),
            quantity: Quantity::Displacement,
            frequencies_hz: (10..1000).map(|k| 0.1 * f64::from(k)).collect(),
            values: values(response, lambda_moves, delay_s),
        };
        let data = Data::Responses((0..3).map(function).collect());
        Record { data, ..record(1.0, None, Vec::new(), Quantity::Displacement) }
    };
    let window = Instrument { exponential_window_s: Some(0.8), ..Instrument::default() };
    must_be_the_arm(&found(&record(1.25, 0.0), window), "window");
    let late = Instrument { response_delay_s: 0.004, ..Instrument::default() };
    must_be_the_arm(&found(&record(0.0, 0.004), late), "delay");
    let unstated = found(&record(1.25, 0.0), Instrument::default());
    assert!((unstated.modes[0].damping_ratio / 0.03 - 1.55).abs() < 0.1, "{:?}", unstated.modes);
}

#[test]
fn a_window_that_the_record_does_not_have_is_told() {
    let decay = noisy(&free_decay(&arm(), 2, RATE_HZ, 1000, 0), 0.02, &mut seeded(1));
    let record = record(RATE_HZ, None, decay, Quantity::Acceleration);
    let stated = Instrument { exponential_window_s: Some(0.3), ..Instrument::default() };
    let found = found(&record, stated);
    assert!(has(&found, Code::Disagreement), "{:?}", found.warnings);
    assert!(found.modes.is_empty(), "{:?}", found.modes);
}
