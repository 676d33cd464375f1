//! Bands that the session cuts out of a record, records with many modes, and what a session asks for: each mode
//! once, with right deviations, and whatever else is told.

use crate::identify::{asked, record};
use crate::vibration::{TrueMode, free_decay, gauss, hammered, noisy, pulses, rms, seeded};
use detune::identify::mode::Mode;
use detune::identify::record::{Asked, Quantity, Record};
use detune::identify::record_modes::{IdentifiedRecord, identify_record};
use detune::notes::Code;
use rand::RngExt;

const RATE: f64 = 400.0;

fn arm() -> Vec<TrueMode> {
    vec![
        TrueMode::new(12.0, 0.03, &[1.0, 0.5, 0.2]),
        TrueMode::new(25.0, 0.02, &[0.6, -0.8, 0.5]),
        TrueMode::new(58.0, 0.015, &[0.3, 0.4, -0.7]),
        TrueMode::new(95.0, 0.010, &[0.5, 0.5, 0.5]),
    ]
}

/// Four hits, 50 dB, with the force or without it.
fn hit(seed: u64, with_force: bool) -> Record {
    let force = pulses(6000, &[100, 1600, 3100, 4600], 5, 100.0);
    let clean = hammered(&arm(), 0, 2, RATE, &force);
    let responses = noisy(&clean, 0.003, &mut seeded(seed));
    record(RATE, with_force.then_some(force), responses, Quantity::Acceleration)
}

fn within(record: &Record, band_hz: [f64; 2]) -> IdentifiedRecord {
    identify_record(record, &Asked { band_hz: Some(band_hz), ..asked(&[]) })
}

/// Modes of the arm outside of the band are neither seen in it nor bend those in it.
#[test]
fn a_narrow_band_has_its_own_mode_once() {
    for seed in 0..3 {
        for with_force in [true, false] {
            let record = hit(seed, with_force);
            for (band, truth) in [
                ([20.0, 30.0], &arm()[1]),
                ([40.0, 70.0], &arm()[2]),
                ([50.0, 62.0], &arm()[2]),
                ([24.0, 26.0], &arm()[1]),
            ] {
                let found = within(&record, band);
                let told: Vec<_> =
                    found.modes.iter().map(|m| (m.frequency_hz, m.damping_ratio)).collect();
                let what = format!("seed {seed}, {band:?}, force {with_force}: {told:?}");
                assert_eq!(told.len(), 1, "{what} {:?}", found.warnings);
                let mode = &found.modes[0];
                let off = (mode.frequency_hz - truth.hz).abs();
                assert!(off < 4.0 * mode.frequency_std_hz && off < 1e-4 * truth.hz, "{what}");
                let off = (mode.damping_ratio - truth.ratio).abs();
                assert!(off < 4.0 * mode.damping_std && off < 0.01 * truth.ratio, "{what}");
                let is_told = found.warnings.iter().any(|note| note.code == Code::Unsettled);
                assert_eq!(is_told, mode.support == 0.0, "{what} {:?}", found.warnings);
            }
        }
    }
}

/// Twelve modes within four octaves, which the least squares over all of them do not tell apart.
#[test]
fn many_modes_are_found_band_by_band() {
    let truth: Vec<TrueMode> = (0..12)
        .map(|i| {
            let turn = |by: usize| ((i * by) as f64 * 1.7 + 0.4).sin() + 0.2;
            let hz = 20.0 * 1.25_f64.powi(i as i32);
            TrueMode::new(hz, 0.008 + 0.0005 * i as f64, &[1.0 + 0.1 * i as f64, turn(1), turn(2)])
        })
        .collect();
    let force = pulses(4096, &[40, 2080], 3, 100.0);
    for seed in 0..2 {
        let clean = hammered(&truth, 0, 2, 1024.0, &force);
        let responses = noisy(&clean, 0.01, &mut seeded(seed));
        let record = record(1024.0, Some(force.clone()), responses, Quantity::Acceleration);
        let found = identify_record(&record, &asked(&[]));
        let told: Vec<_> = found.modes.iter().map(|m| (m.frequency_hz, m.support)).collect();
        assert_eq!(told.len(), truth.len(), "{told:?} {:?}", found.warnings);
        for (mode, truth) in found.modes.iter().zip(&truth) {
            let off = (mode.frequency_hz - truth.hz).abs();
            assert!(off < 4.5 * mode.frequency_std_hz && off < 1e-3 * truth.hz, "{told:?}");
            let off = (mode.damping_ratio - truth.ratio).abs();
            assert!(off < 4.5 * mode.damping_std && off < 0.1 * truth.ratio, "{mode:?}");
        }
        let supported = found.modes.iter().filter(|mode| mode.support > 0.2).count();
        assert!(supported >= 10, "{told:?}");
    }
}

/// Twenty modes 10 to 50 % apart under four blows: the gaps between their peaks are shallow, as one is in the skirts of
/// the next.
#[test]
fn twenty_modes_under_four_blows_are_found() {
    let truth: Vec<TrueMode> = (0..20)
        .map(|i| {
            let turn = |by: usize| ((i * by + 1) as f64 * 2.3).sin();
            let hz = 26.0 + 13.0 * i as f64 + 3.0 * turn(5);
            let shape: Vec<f64> = (1..6).map(turn).collect();
            TrueMode::new(hz, 0.012 + 0.004 * turn(7), &shape)
        })
        .collect();
    let force = pulses(16_384, &[6, 4102, 8198, 12_294], 3, 100.0);
    let clean = hammered(&truth, 0, 2, 1024.0, &force);
    let responses = noisy(&clean, 0.003, &mut seeded(5));
    let record = record(1024.0, Some(force), responses, Quantity::Acceleration);
    let found = identify_record(&record, &asked(&[]));
    let told: Vec<_> = found.modes.iter().map(|m| (m.frequency_hz, m.support)).collect();
    assert_eq!(told.len(), truth.len(), "{told:?} {:?}", found.warnings);
    for (mode, truth) in found.modes.iter().zip(&truth) {
        let off = (mode.frequency_hz - truth.hz).abs();
        assert!(off < 4.5 * mode.frequency_std_hz && off < 1e-3 * truth.hz, "{truth:?} {mode:?}");
    }
}

/// More modes than are fitted together, one of them with a spring that softens: its frequency is
/// that of small amplitudes and its drift is told; the others have theirs.
#[test]
fn one_mode_of_sixty_that_softens_is_told() {
    let softening = 0.02;
    let truth: Vec<TrueMode> = (0..60)
        .map(|i| {
            let turn = |by: usize| ((i * by + 1) as f64 * 2.3).sin();
            let hz = 30.0 + 15.0 * i as f64 + 3.0 * turn(5);
            TrueMode::new(hz, 0.003 + 0.001 * turn(7), &[1.0, 1.0 + 0.5 * turn(3)])
        })
        .collect();
    let force = pulses(8192, &[6], 3, 100.0);
    let (soft, linear) = truth.split_at(1);
    let mut clean = hammered(linear, 0, 2, 2048.0, &force);
    let acceleration = softened(&soft[0], softening, 2048.0, &force);
    for (samples, shape) in clean.iter_mut().zip(&soft[0].shape) {
        samples.iter_mut().zip(&acceleration).for_each(|(sum, own)| *sum += shape * own);
    }
    let responses = noisy(&clean, 0.003, &mut seeded(7));
    let record = record(2048.0, Some(force), responses, Quantity::Acceleration);
    let found = identify_record(&record, &asked(&[]));
    let told: Vec<_> =
        found.modes.iter().map(|m| (m.frequency_hz, m.frequency_std_hz, m.support)).collect();
    for truth in &truth {
        let nearest = found.modes.iter().min_by(|a, b| {
            let far = |mode: &Mode| (mode.frequency_hz - truth.hz).abs();
            far(a).total_cmp(&far(b))
        });
        let off = nearest.map(|mode| (mode.frequency_hz - truth.hz).abs() / mode.frequency_std_hz);
        assert!(off.is_some_and(|off| off < 4.5), "{truth:?} {nearest:?} {told:?}");
    }
    assert_eq!(told.len(), truth.len(), "{told:?} {:?}", found.warnings);
    let drifts: Vec<&str> = found
        .warnings
        .iter()
        .filter(|note| note.code == Code::AmplitudeDependent)
        .map(|note| note.what.as_str())
        .collect();
    assert!(drifts.len() == 1 && drifts[0].contains("lower"), "{drifts:?}");
}

/// The modal acceleration of a mode whose spring loses a share of its stiffness at the largest
/// deflection of the linear mode, by the square of the deflection; Runge–Kutta of fourth order.
fn softened(mode: &TrueMode, share: f64, rate: f64, force: &[f64]) -> Vec<f64> {
    const SUBSTEPS: usize = 16;
    let omega = std::f64::consts::TAU * mode.hz;
    let linear = hammered(std::slice::from_ref(mode), 0, 0, rate, force);
    let largest = linear[0].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let rates = |[x, v]: [f64; 2], force: f64| {
        let spring = omega * omega * x * (1.0 - share * (x / largest).powi(2));
        [v, force - 2.0 * mode.ratio * omega * v - spring]
    };
    let step = 1.0 / rate / SUBSTEPS as f64;
    let mut state = [0.0; 2];
    let mut found = vec![rates(state, force[0])[1]];
    for pair in force.windows(2) {
        for part in 0..SUBSTEPS {
            let at = |by: f64| pair[0] + (pair[1] - pair[0]) * (part as f64 + by) / SUBSTEPS as f64;
            let moved =
                |by: [f64; 2], step: f64| [state[0] + step * by[0], state[1] + step * by[1]];
            let a = rates(state, at(0.0));
            let b = rates(moved(a, 0.5 * step), at(0.5));
            let c = rates(moved(b, 0.5 * step), at(0.5));
            let d = rates(moved(c, step), at(1.0));
            let mean = |i: usize| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0;
            state = moved([mean(0), mean(1)], step);
        }
        found.push(rates(state, pair[1])[1]);
    }
    found
}

/// Three channels, 60 dB: the least squares and the fit agree, and nobody speaks of noise.
#[test]
fn a_clean_ring_down_of_three_channels_has_its_modes() {
    let truth = [
        TrueMode::new(80.4, 0.003, &[1.0, 0.4, -0.3]),
        TrueMode::new(190.0, 0.004, &[0.5, -0.9, 0.7]),
        TrueMode::new(330.0, 0.003, &[0.2, 0.6, 0.9]),
    ];
    let clean = free_decay(&truth, 0, 2048.0, 4096, 0);
    for seed in 0..3 {
        let responses = noisy(&clean, 1e-3, &mut seeded(seed));
        let found =
            identify_record(&record(2048.0, None, responses, Quantity::Acceleration), &asked(&[]));
        let told: Vec<f64> = found.modes.iter().map(|mode| mode.frequency_hz).collect();
        assert_eq!(told.len(), 3, "{told:?} {:?}", found.warnings);
        assert!(told.iter().zip(&truth).all(|(hz, t)| (hz / t.hz - 1.0).abs() < 1e-5), "{told:?}");
    }
}

#[test]
fn what_is_asked_for_is_reported_and_the_rest_is_told() {
    let record = hit(1, true);
    let of = |asked: Asked| {
        let found = identify_record(&record, &asked);
        let hz: Vec<f64> = found.modes.iter().map(|mode| mode.frequency_hz.round()).collect();
        let told = |code: Code| {
            let of = found.warnings.iter().filter(move |note| note.code == code);
            of.map(|note| note.what.clone()).collect::<Vec<_>>().join("; ")
        };
        (hz, told(Code::Remark), told(Code::NoModes))
    };
    let (hz, told, _) = of(Asked { near_hz: vec![25.3, 58.0], ..asked(&[]) });
    assert_eq!(hz, [25.0, 58.0]);
    assert!(told.contains("12.0") && told.contains("95.0"), "{told}");
    let (hz, _, missing) = of(Asked { near_hz: vec![40.0], ..asked(&[]) });
    assert!(hz.is_empty() && missing.contains("within 5 % of 40 Hz"), "{missing}");
    let (hz, told, _) = of(Asked { modes: Some(2), ..asked(&[]) });
    assert_eq!(hz.len(), 2, "{hz:?}");
    assert!(told.contains("not asked for"), "{told}");
    let (_, _, missing) = of(Asked { modes: Some(9), ..asked(&[]) });
    assert!(missing.contains("4 modes that are certain, not 9"), "{missing}");
    let found = identify_record(&record, &Asked { max_order: Some(10), ..asked(&[]) });
    assert!(found.stabilisation.iter().all(|point| point.order <= 10));
    assert!(found.modes.len() <= 5, "{:?}", found.modes.len());
}

/// Three sensors at the tool and six along the arm, all with one noise: two light modes, which the tool alone shows, lie
/// beside loud ones. Least squares of rising order pass over one of them in every order; the fit knows it.
#[test]
fn channels_that_hold_loud_modes_alone_hide_no_light_one() {
    let modes = [
        TrueMode::new(10.18, 0.02, &[1.0, 0.62, 0.03, -0.34, -0.71, -0.19, -0.15, -0.73, -0.72]),
        TrueMode::new(13.37, 0.02, &[0.15, 0.04, -0.06, 0.0, 0.01, 0.01, 0.01, 0.0, 0.0]),
        TrueMode::new(14.3, 0.02, &[-0.9, -0.88, 0.11, -0.37, 0.61, -0.7, 0.29, 0.59, -0.44]),
        TrueMode::new(19.57, 0.02, &[0.8, -0.37, -0.7, 0.32, -0.08, 0.48, -0.42, -0.29, 0.48]),
        TrueMode::new(24.06, 0.02, &[-0.12, 0.0, -0.06, -0.01, 0.01, -0.01, 0.01, 0.0, 0.01]),
    ];
    let (rate, samples) = (256.0, 1536);
    let hit = |k: i32| {
        if (20..=23).contains(&k) {
            200.0 * (f64::from(k - 20) / 3.0 * std::f64::consts::PI).sin()
        } else {
            0.0
        }
    };
    let force: Vec<f64> = (0..samples).map(hit).collect();
    let clean = hammered(&modes, 0, 2, rate, &force);
    for seed in 0..4 {
        let mut rng = seeded(seed);
        let noise = 0.01 * rms(&clean[0]);
        let moves =
            clean.iter().map(|own| own.iter().map(|a| a + noise * gauss(&mut rng)).collect());
        let record = record(rate, Some(force.clone()), moves.collect(), Quantity::Acceleration);
        let found = identify_record(&record, &asked(&[50.0, 60.0]));
        let listed: Vec<_> = found.modes.iter().filter(|mode| mode.suspicion.is_none()).collect();
        let told: Vec<_> = listed.iter().map(|m| (m.frequency_hz, m.support)).collect();
        assert_eq!(told.len(), modes.len(), "seed {seed}: {told:?} {:?}", found.warnings);
        for (mode, truth) in listed.iter().zip(&modes) {
            let off = (mode.frequency_hz - truth.hz).abs();
            assert!(off < 4.0 * mode.frequency_std_hz, "seed {seed}: {told:?}");
        }
        let is_told = found
            .warnings
            .iter()
            .any(|note| note.what.contains("by the fit alone, which knows it well"));
        assert!(is_told, "seed {seed}: {told:?} {:?}", found.warnings);
    }
}

/// Marks that a camera tracks to 0.0035 of a pixel beside a bias that repeats with every pixel: of a large motion that
/// leaves a second pole within the width of a mode. Two modes 0.7 % apart, one a third of the other, stay two.
#[test]
fn what_sub_pixel_errors_leave_is_no_mode() {
    let mut echoes = 0;
    for seed in 0..8 {
        let mut rng = seeded(400 + seed);
        let channels = [8, 20][seed as usize % 2];
        let mut shape = || (0..channels).map(|_| gauss(&mut rng)).collect::<Vec<f64>>();
        let modes = [TrueMode::new(9.1, 0.02, &shape()), TrueMode::new(22.3, 0.02, &shape())];
        let mut responses = free_decay(&modes, 0, 240.0, 1200, 0);
        for own in &mut responses {
            let place = 0.5 + 0.5 * gauss(&mut rng);
            for y in own.iter_mut() {
                // free_decay has amplitudes of two shapes.
                *y *= 0.5;
                *y += 0.003 * (std::f64::consts::TAU * (*y + place)).sin();
                *y += 0.0035 * gauss(&mut rng);
            }
        }
        let record = record(240.0, None, responses, Quantity::Displacement);
        let found = identify_record(&record, &asked(&[50.0]));
        let listed: Vec<_> = found.modes.iter().filter(|mode| mode.suspicion.is_none()).collect();
        let told: Vec<_> =
            listed.iter().map(|m| (m.frequency_hz, m.damping_ratio, m.amplitude)).collect();
        assert_eq!(listed.len(), 2, "seed {seed}: {told:?} {:?}", found.warnings);
        for (mode, truth) in listed.iter().zip(&modes) {
            assert!((mode.frequency_hz / truth.hz - 1.0).abs() < 1e-3, "seed {seed}: {told:?}");
        }
        echoes += found.modes.len() - listed.len();
    }
    assert!(echoes > 0, "no record had such a pole");
    for seed in 0..4 {
        let modes = [
            TrueMode::new(9.1, 0.01, &[1.0, 0.7, -0.4, 0.5]),
            TrueMode::new(9.16, 0.01, &[-0.2, 0.3, 0.25, 0.1]),
        ];
        let clean = free_decay(&modes, 0, 240.0, 2400, 0);
        let responses = noisy(&clean, 0.01, &mut seeded(seed));
        let record = record(240.0, None, responses, Quantity::Displacement);
        let found = identify_record(&record, &asked(&[50.0]));
        let told: Vec<_> = found.modes.iter().map(|m| (m.frequency_hz, m.suspicion)).collect();
        assert_eq!(told.len(), 2, "seed {seed}: {told:?} {:?}", found.warnings);
        for ((hz, suspicion), truth) in told.iter().zip(&modes) {
            assert!(suspicion.is_none() && (hz / truth.hz - 1.0).abs() < 1e-3, "{seed}: {told:?}");
        }
    }
}

/// A film whose frames come up to a ninth of a step late or early, its times unstated: poles that a few orders of the
/// least squares have, beside many that none has, are no modes.
#[test]
fn a_clock_that_jitters_makes_no_modes() {
    const RATE: f64 = 120.0;
    let truth = [(11.3, 0.02, [0.1, -0.06, 1.0, -0.53]), (23.9, 0.015, [-0.35, -0.23, 1.0, 0.96])];
    let mut unsettled = 0;
    for seed in 0..8 {
        let mut rng = seeded(seed);
        let mut responses = vec![Vec::new(); 4];
        for k in 0..720 {
            let t = (f64::from(k) + 0.11 * (2.0 * rng.random::<f64>() - 1.0)) / RATE;
            for (at, own) in responses.iter_mut().enumerate() {
                let of = |(hz, ratio, shape): &(f64, f64, [f64; 4])| {
                    let omega = std::f64::consts::TAU * hz;
                    shape[at] * (-ratio * omega * t).exp() * (omega * t + hz).cos()
                };
                own.push(truth.iter().map(of).sum::<f64>() + 0.002 * gauss(&mut rng));
            }
        }
        let record = record(RATE, None, responses, Quantity::Displacement);
        let found = identify_record(&record, &asked(&[50.0]));
        unsettled += found.modes.iter().filter(|mode| mode.suspicion.is_some()).count();
        for mode in found.modes.iter().filter(|mode| mode.suspicion.is_none()) {
            let near =
                |(hz, ..): &(f64, f64, [f64; 4])| (mode.frequency_hz / hz - 1.0).abs() < 0.01;
            let told = (mode.frequency_hz, mode.frequency_std_hz, mode.support);
            assert!(truth.iter().any(near), "seed {seed}: {told:?}");
        }
    }
    assert!(unsettled >= 8, "{unsettled}");
}
