//! Responses to a random force that nobody measured: told from decays, and modes with right deviations.

use crate::identify::{asked, coverage_seeds, few, record};
use crate::vibration::{TrueMode, free_decay, noisy, random_response, seeded};
use detune::identify::RecordKind;
use detune::identify::record::Quantity;
use detune::identify::record_modes::{IdentifiedRecord, identify_record};
use detune::notes::Code;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Two of them 2.5 % apart.
fn modes() -> Vec<TrueMode> {
    vec![
        TrueMode::new(12.0, 0.010, &[1.0, 0.5, 0.3]),
        TrueMode::new(12.3, 0.012, &[0.6, -0.8, 0.4]),
        TrueMode::new(40.0, 0.010, &[3.0, 4.0, -7.0]),
    ]
}

fn measured(modes: &[TrueMode], seconds: f64, noise: f64, seed: u64) -> IdentifiedRecord {
    const RATE: f64 = 400.0;
    let mut rng = seeded(seed);
    let clean = random_response(modes, RATE, (seconds * RATE) as usize, &mut rng);
    let responses = noisy(&clean, noise, &mut rng);
    identify_record(&record(RATE, None, responses, Quantity::Displacement), &asked(&[50.0, 60.0]))
}

/// Over the seeds of the long run the intervals hold frequency and damping in 93 to 97 %.
#[test]
fn modes_of_a_random_response_have_deviations_that_cover() {
    const Z: f64 = 1.959_964;
    let seeds = coverage_seeds() / 4;
    let found: Vec<IdentifiedRecord> =
        (0..seeds).into_par_iter().map(|seed| measured(&modes(), 180.0, 0.1, 700 + seed)).collect();
    let (mut listed, mut there, mut by_frequency, mut by_damping) = (0, 0, 0, 0);
    for found in &found {
        assert_eq!(found.kind, RecordKind::RandomResponse);
        listed += found.modes.iter().filter(|mode| mode.suspicion.is_none()).count();
        for truth in modes() {
            let near = found.modes.iter().min_by(|a, b| {
                let apart = |hz: f64| (hz - truth.hz).abs();
                apart(a.frequency_hz).total_cmp(&apart(b.frequency_hz))
            });
            let Some(mode) = near.filter(|mode| (mode.frequency_hz / truth.hz - 1.0).abs() < 0.01)
            else {
                continue;
            };
            there += 1;
            let off = (mode.frequency_hz - truth.hz).abs();
            by_frequency += usize::from(off < Z * mode.frequency_std_hz);
            by_damping +=
                usize::from((mode.damping_ratio - truth.ratio).abs() < Z * mode.damping_std);
        }
    }
    let all = 3 * found.len();
    let share = |count: usize| count as f64 / all as f64;
    println!(
        "random response: {:.3} of the modes listed, {:.3} right; frequency {:.3}, damping {:.3}",
        share(listed),
        share(there),
        by_frequency as f64 / there as f64,
        by_damping as f64 / there as f64
    );
    assert!(share(there) > 0.95 && listed <= there + all / 50, "{there} and {listed} of {all}");
    for held in [by_frequency, by_damping] {
        let share = held as f64 / there as f64;
        // Three standard errors of a binomial share beside what is asked for.
        let error = 3.0 * (0.95 * 0.05 / there as f64).sqrt();
        assert!((0.93 - error..=0.97 + error).contains(&share), "{share}");
    }
}

/// 31.7 Hz is no harmonic of anything that the session states; a motor's speed wanders by a few parts
/// in ten thousand, which looks like a little damping.
#[test]
fn a_machines_tone_is_no_mode_where_no_force_was_measured() {
    const RATE: f64 = 400.0;
    for wander in [0.0, 5e-4, 1e-3, 2e-3] {
        let mut rng = seeded(11);
        let mut responses = random_response(&modes(), RATE, 72_000, &mut rng);
        let mut phase = 0.0;
        let tone: Vec<f64> = (0..72_000)
            .map(|k| {
                let slow = (std::f64::consts::TAU * 0.05 * k as f64 / RATE).sin();
                phase += std::f64::consts::TAU * 31.7 * (1.0 + wander * slow) / RATE;
                phase.sin()
            })
            .collect();
        for (channel, share) in responses.iter_mut().zip([2.0, 1.5, -1.8]) {
            let level = (channel.iter().map(|x| x * x).sum::<f64>() / channel.len() as f64).sqrt();
            channel.iter_mut().zip(&tone).for_each(|(x, tone)| *x += share * level * tone);
        }
        let responses = noisy(&responses, 0.05, &mut rng);
        let found = identify_record(
            &record(RATE, None, responses, Quantity::Displacement),
            &asked(&[50.0]),
        );
        let listed: Vec<f64> = found
            .modes
            .iter()
            .filter(|mode| mode.suspicion.is_none())
            .map(|mode| mode.frequency_hz)
            .collect();
        assert_eq!(listed.len(), 3, "{wander}: {listed:?}");
        assert!(listed.iter().all(|hz| (hz - 31.7).abs() > 1.0), "{wander}: {listed:?}");
    }
}

/// Wind and traffic come in gusts: values are small most of the time, and large between.
#[test]
fn gusts_are_no_decays() {
    const RATE: f64 = 400.0;
    for seed in 0..4_u8 {
        let mut rng = seeded(40 + u64::from(seed));
        let mut responses = random_response(&modes(), RATE, 72_000, &mut rng);
        let gust = |k: usize| {
            let t = std::f64::consts::TAU * k as f64 / RATE;
            (0.65 * ((t / 37.0 + f64::from(seed)).sin() + (t / 23.0).sin())).exp()
        };
        for channel in &mut responses {
            channel.iter_mut().enumerate().for_each(|(k, y)| *y *= gust(k));
            let power = |n: i32| channel.iter().map(|y| y.powi(n)).sum::<f64>();
            assert!(power(4) * channel.len() as f64 / power(2).powi(2) > 5.2);
        }
        let responses = noisy(&responses, 0.05, &mut rng);
        let found = identify_record(
            &record(RATE, None, responses, Quantity::Displacement),
            &asked(&[50.0]),
        );
        assert_eq!(found.kind, RecordKind::RandomResponse, "seed {seed}");
        let listed: Vec<_> = found.modes.iter().filter(|mode| mode.suspicion.is_none()).collect();
        assert_eq!(listed.len(), 3, "seed {seed}");
        for (mode, truth) in listed.iter().zip(modes()) {
            let off = (mode.frequency_hz - truth.hz).abs();
            assert!(off < 5.0 * mode.frequency_std_hz, "seed {seed}: {off} at {}", truth.hz);
        }
    }
}

/// The modes of a footbridge, of which the rate takes fifty samples a period: the correlations of a realisation at
/// that rate end before one is over.
#[test]
fn slow_modes_of_a_fast_record_are_where_they_are() {
    const RATE: f64 = 100.0;
    let modes = [
        TrueMode::new(1.88, 0.015, &[0.9, -0.2, 0.3, 1.0, 0.1, -0.9]),
        TrueMode::new(2.42, 0.015, &[1.0, 0.2, 1.0, -0.1, 0.9, -0.1]),
        TrueMode::new(2.69, 0.015, &[0.5, 1.0, 0.4, -0.6, -0.6, -0.7]),
        TrueMode::new(21.0, 0.010, &[9.0, -20.0, 31.0, 12.0, -17.0, 25.0]),
    ];
    for seed in 0..few(6) {
        let mut rng = seeded(70 + seed);
        let clean = random_response(&modes, RATE, 120_000, &mut rng);
        let responses = noisy(&clean, 0.1, &mut rng);
        let found = identify_record(
            &record(RATE, None, responses, Quantity::Displacement),
            &asked(&[50.0]),
        );
        let listed: Vec<_> = found.modes.iter().filter(|mode| mode.suspicion.is_none()).collect();
        let told: Vec<_> = listed.iter().map(|m| (m.frequency_hz, m.frequency_std_hz)).collect();
        assert_eq!(listed.len(), 4, "seed {seed}: {told:?}");
        for (mode, truth) in listed.iter().zip(&modes) {
            let off = (mode.frequency_hz - truth.hz).abs();
            assert!(off < 4.0 * mode.frequency_std_hz, "seed {seed}: {told:?}");
            let off = (mode.damping_ratio - truth.ratio).abs();
            assert!(off < 4.0 * mode.damping_std, "seed {seed}: {told:?} {}", mode.damping_ratio);
        }
    }
}

#[test]
fn shapes_of_a_random_response_are_those_of_the_modes() {
    let found = measured(&modes(), 600.0, 0.05, 3);
    for (mode, truth) in found.modes.iter().zip(modes()) {
        let largest = truth.shape.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()));
        for (part, s) in mode.shape.iter().zip(&truth.shape) {
            let apart = (part.value - s / largest.unwrap()).norm();
            assert!(apart < 0.1 && apart < 5.0 * part.std + 1e-12, "{part:?} {s}");
        }
    }
    assert_eq!(found.modes.len(), 3);
}

#[test]
fn a_random_response_that_is_too_short_is_told() {
    let is_told = |seconds: f64| {
        let found = measured(&modes(), seconds, 0.05, 1);
        found.warnings.iter().any(|note| note.code == Code::ShortRecord)
    };
    assert_eq!([1.0, 6.0, 60.0].map(is_told), [true, true, false]);
}

/// Several impacts, light damping, beats, noise as loud as a fifth of the decay.
#[test]
fn what_decays_is_not_taken_for_a_random_response() {
    for seed in 0..few(12) {
        let ratio = [0.002, 0.005, 0.02][seed as usize % 3];
        let modes = [
            TrueMode::new(25.0, ratio, &[1.0, 0.4]),
            TrueMode::new(25.7, ratio, &[0.8, -0.5]),
            TrueMode::new(61.0, ratio, &[0.3, 0.6]),
        ];
        // Two impacts need time to be told apart.
        let seconds = if seed % 2 == 0 { 1.0 } else { 3.0 } / (ratio * 157.0);
        let samples = (seconds * 400.0) as usize;
        let mut clean: Vec<Vec<f64>> = vec![Vec::new(); 2];
        for _ in 0..=seed % 2 {
            let one = free_decay(&modes, 0, 400.0, samples, 0);
            clean.iter_mut().zip(one).for_each(|(all, one)| all.extend(one));
        }
        let responses = noisy(&clean, 0.2, &mut seeded(seed));
        let record = record(400.0, None, responses, Quantity::Displacement);
        let found = identify_record(&record, &asked(&[]));
        assert_eq!(found.kind, RecordKind::FreeDecay, "seed {seed}");
    }
    // Over as long as gusts.
    let modes = [TrueMode::new(25.0, 0.02, &[1.0, 0.4]), TrueMode::new(61.0, 0.02, &[0.3, 0.6])];
    let one = noisy(&free_decay(&modes, 0, 400.0, 900, 0), 0.02, &mut seeded(5));
    let often: Vec<Vec<f64>> = one.iter().map(|one| one.repeat(12)).collect();
    let found = identify_record(&record(400.0, None, often, Quantity::Displacement), &asked(&[]));
    assert_eq!(found.kind, RecordKind::FreeDecay);
}

/// A recorder that stopped fills its file up: a quarter of it is no vibration, and no decay.
#[test]
fn what_a_recorder_fills_up_is_left_out_and_told() {
    const RATE: f64 = 400.0;
    let mut rng = seeded(3);
    let clean = random_response(&modes(), RATE, (180.0 * RATE) as usize, &mut rng);
    let mut responses = noisy(&clean, 0.1, &mut rng);
    let whole = identify_record(
        &record(RATE, None, responses.clone(), Quantity::Displacement),
        &asked(&[50.0, 60.0]),
    );
    responses.iter_mut().for_each(|own| own.resize((270.0 * RATE) as usize, 0.0));
    let found = identify_record(
        &record(RATE, None, responses, Quantity::Displacement),
        &asked(&[50.0, 60.0]),
    );
    assert_eq!(found.kind, RecordKind::RandomResponse);
    assert!(found.warnings.iter().any(|note| note.what.contains("moves in 90.0 s")), "{found:?}");
    assert_eq!(found.modes.len(), whole.modes.len());
    for (found, whole) in found.modes.iter().zip(&whole.modes) {
        assert!((found.frequency_hz / whole.frequency_hz - 1.0).abs() < 1e-6);
    }
}

/// Hum of the mains, steady or wandering as it does, 0.8 Hz from a mode: it is told, and neither pulls the mode nor
/// another one.
#[test]
fn hum_beside_a_mode_of_a_random_response_is_told_and_bends_nothing() {
    const RATE: f64 = 400.0;
    let modes = [
        TrueMode::new(17.3, 0.020, &[1.0, 0.5, 0.3, -0.6]),
        TrueMode::new(49.2, 0.012, &[0.6, -0.8, 0.4, 0.7]),
        TrueMode::new(104.0, 0.010, &[0.5, 0.7, -0.9, 0.4]),
    ]
    .map(|mode| {
        // Accelerations: the displacements of higher modes are smaller.
        let shape: Vec<f64> = mode.shape.iter().map(|own| own * mode.hz).collect();
        TrueMode { shape, ..mode }
    });
    let mut largest: f64 = 0.0;
    for (seed, share, wander) in [(1, 0.3, 0.0), (2, 0.5, 0.0), (3, 0.3, 0.015), (4, 0.0, 0.0)] {
        let mut rng = seeded(60 + seed);
        let mut responses = random_response(&modes, RATE, 120_000, &mut rng);
        let whole = responses.iter().flatten().map(|y| y * y).sum::<f64>();
        let level = (whole / (4.0 * 120_000.0)).sqrt();
        for (k, t) in (0..120_000).map(|k| f64::from(k) / RATE).enumerate() {
            // The phase of 50.01 Hz that swings by `wander` Hz in a hundred seconds.
            let swing =
                wander * 100.0 / std::f64::consts::TAU * (std::f64::consts::TAU * t / 100.0).sin();
            let tone = (std::f64::consts::TAU * (50.01 * t + swing) + 1.0).sin();
            let size = share * 2.0_f64.sqrt() * level;
            responses.iter_mut().for_each(|own| own[k] += size * tone);
        }
        let responses = noisy(&responses, 0.05, &mut rng);
        let found = identify_record(
            &record(RATE, None, responses, Quantity::Acceleration),
            &asked(&[50.0]),
        );
        let listed: Vec<_> = found.modes.iter().filter(|mode| mode.suspicion.is_none()).collect();
        let told: Vec<_> = listed.iter().map(|m| (m.frequency_hz, m.frequency_std_hz)).collect();
        assert_eq!(listed.len(), 3, "seed {seed}: {told:?} {:?}", found.warnings);
        for (mode, truth) in listed.iter().zip(&modes) {
            let off = (mode.frequency_hz - truth.hz).abs() / mode.frequency_std_hz;
            let of_damping = (mode.damping_ratio - truth.ratio).abs() / mode.damping_std;
            largest = largest.max(off).max(of_damping);
            assert!(off < 4.0 && of_damping < 4.0, "seed {seed}: {told:?} {of_damping}");
        }
        let is_hum = found.warnings.iter().any(|note| note.code == Code::Mains);
        assert_eq!(is_hum, share > 0.0, "seed {seed}: {:?}", found.warnings);
    }
    println!("hum: largest deviation {largest:.2}");
}
