//! Modes found in records whose poles are known exactly: frequency, damping, shape, scaling, the number of
//! modes, and whether the stated deviations are right.

use crate::share::one_in;
use crate::vibration::{
    TrueMode, channel_of, free_decay, gauss, hammered, noisy, pulses, rms, seeded,
};
use detune::identify::record::{Asked, Channel, Data, Quantity, Record};
use detune::identify::record_modes::{IdentifiedRecord, identify_record};
use detune::notes::Code;
use nalgebra::{DMatrix, DVector};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// 20 dB: noise of a tenth of the signal.
const TWENTY_DB: f64 = 0.1;

const QUANTITIES: [Quantity; 3] =
    [Quantity::Displacement, Quantity::Velocity, Quantity::Acceleration];

pub(crate) fn record(
    rate: f64,
    force: Option<Vec<f64>>,
    responses: Vec<Vec<f64>>,
    quantity: Quantity,
) -> Record {
    let channel = |(i, samples)| Channel { name: format!("r{i}"), quantity, samples };
    let excitation =
        force.map(|samples| Channel { name: "hammer".into(), quantity: Quantity::Force, samples });
    Record {
        name: "record".into(),
        data: Data::Time {
            sample_rate_hz: rate,
            excitation,
            responses: responses.into_iter().enumerate().map(channel).collect(),
        },
        driving_point: Some("r0".into()),
        links: Vec::new(),
        spindle_rpm: None,
        instrument: Default::default(),
    }
}

pub(crate) fn asked(mains_hz: &[f64]) -> Asked {
    Asked { mains_hz: mains_hz.to_vec(), ..Asked::default() }
}

fn identify(record: &Record) -> IdentifiedRecord {
    identify_record(record, &asked(&[50.0, 60.0]))
}

/// Every mode and no other, within 0.1 % of frequency and 10 % of damping.
fn must_be(found: &IdentifiedRecord, truth: &[TrueMode], what: &str) {
    let told: Vec<_> = found.modes.iter().map(|m| (m.frequency_hz, m.damping_ratio)).collect();
    assert_eq!(told.len(), truth.len(), "{what}: {told:?} {:?}", found.warnings);
    for (mode, truth) in found.modes.iter().zip(truth) {
        assert!((mode.frequency_hz / truth.hz - 1.0).abs() < 1e-3, "{what}: {told:?}");
        assert!((mode.damping_ratio / truth.ratio - 1.0).abs() < 0.1, "{what}: {told:?}");
    }
}

fn arm() -> Vec<TrueMode> {
    vec![
        TrueMode::new(12.0, 0.03, &[1.0, 0.5, 0.2]),
        TrueMode::new(25.0, 0.02, &[0.6, -0.8, 0.5]),
        TrueMode::new(58.0, 0.015, &[0.3, 0.4, -0.7]),
    ]
}

/// Responses scaled so that each mode moves about as much in each quantity.
fn levelled(modes: &[TrueMode], derivatives: i32) -> Vec<TrueMode> {
    let scale = |mode: &TrueMode| mode.hz.powi(-derivatives);
    modes
        .iter()
        .map(|m| {
            TrueMode::new(m.hz, m.ratio, &m.shape.iter().map(|s| s * scale(m)).collect::<Vec<_>>())
        })
        .collect()
}

#[test]
fn free_decays_at_20_db_give_frequency_damping_and_shape() {
    for (derivatives, quantity) in QUANTITIES.into_iter().enumerate() {
        let derivatives = i32::try_from(derivatives).unwrap();
        let truth = levelled(&arm(), derivatives);
        for seed in 0..8 {
            // From the first sample on, and after a pause.
            let quiet = if seed % 2 == 0 { 0 } else { 100 };
            let clean = free_decay(&truth, derivatives, 200.0, 1000 + quiet, quiet);
            let found = identify(&record(
                200.0,
                None,
                noisy(&clean, TWENTY_DB, &mut seeded(seed)),
                quantity,
            ));
            must_be(&found, &truth, &format!("{quantity:?}, seed {seed}"));
            for (mode, truth) in found.modes.iter().zip(&truth) {
                let largest = truth
                    .shape
                    .iter()
                    .fold(0.0_f64, |a: f64, s| if s.abs() > a.abs() { *s } else { a });
                for (part, s) in mode.shape.iter().zip(&truth.shape) {
                    let error = (part.value - s / largest).norm();
                    assert!(
                        error < 0.03 && error < 5.0 * part.std + 1e-12,
                        "{part:?} {}",
                        s / largest
                    );
                }
            }
        }
    }
}

/// One response in which every mode is about as loud: no shape helps.
#[test]
fn one_response_at_20_db_is_enough() {
    for (derivatives, quantity) in QUANTITIES.into_iter().enumerate() {
        let derivatives = i32::try_from(derivatives).unwrap();
        let modes = [(12.0, 0.03), (25.0, 0.02), (58.0, 0.015)]
            .map(|(hz, ratio)| TrueMode::new(hz, ratio, &[1.0]));
        let truth = levelled(&modes, derivatives);
        for seed in 0..8 {
            let clean = free_decay(&truth, derivatives, 200.0, 1000, 0);
            let found = identify(&record(
                200.0,
                None,
                noisy(&clean, TWENTY_DB, &mut seeded(seed)),
                quantity,
            ));
            must_be(&found, &truth, &format!("{quantity:?}, seed {seed}"));
        }
    }
}

#[test]
fn hammer_tests_at_20_db_give_modal_constants_too() {
    // Fine enough that a force linear between samples has the spectrum of its samples within 1 %.
    let force = pulses(7000, &[100, 1900, 3700, 5300], 12, 100.0);
    for (derivatives, quantity) in QUANTITIES.into_iter().enumerate() {
        let derivatives = i32::try_from(derivatives).unwrap();
        let truth = arm();
        for seed in 0..3 {
            let clean = hammered(&truth, 0, derivatives, 600.0, &force);
            let mut rng = seeded(seed);
            let responses = noisy(&clean, TWENTY_DB, &mut rng);
            let heard: Vec<f64> = force.iter().map(|f| f + 0.05 * gauss(&mut rng)).collect();
            let found = identify(&record(600.0, Some(heard), responses, quantity));
            // In displacement the third mode is 40 dB below the first: what must hold is the first two.
            let count = if derivatives == 0 { found.modes.len().clamp(2, 3) } else { 3 };
            if derivatives > 0 {
                must_be(&found, &truth, &format!("{quantity:?}, seed {seed}"));
            }
            for (mode, truth) in found.modes.iter().zip(&truth).take(count.min(2)) {
                assert!(
                    (mode.frequency_hz / truth.hz - 1.0).abs() < 1e-3,
                    "{quantity:?}: {mode:?}"
                );
                assert!(
                    (mode.damping_ratio / truth.ratio - 1.0).abs() < 0.1,
                    "{quantity:?}: {mode:?}"
                );
                for (part, s) in mode.shape.iter().zip(&truth.shape) {
                    let constant = part.modal_constant.unwrap();
                    let exact = s * truth.shape[0];
                    assert!(
                        (constant - exact).norm() < 0.04 * truth.shape[0].abs(),
                        "{constant} {exact}"
                    );
                    let phi = part.mass_normalised.unwrap();
                    assert!((phi - s * truth.shape[0].signum()).norm() < 0.05, "{phi} {s}");
                }
            }
        }
    }
}

/// Blows that fall between samples: a force of 3 ms, taken at 1024 samples/s, is not the sum of its samples, and
/// each blow differs. Sixteen steps of the truth make one sample.
#[test]
fn blows_between_samples_make_no_false_modes() {
    const FINER: usize = 16;
    let truth = [TrueMode::new(14.0, 0.02, &[1.0, 0.6]), TrueMode::new(37.0, 0.015, &[0.3, -0.4])];
    for seed in 0..4_u64 {
        let apart = 45_000 + 5 * seed as usize;
        let fine = pulses(6 * 1024 * FINER, &[8_195, 8_195 + apart], 3 * FINER, 100.0);
        let every =
            |samples: &[f64]| -> Vec<f64> { samples.iter().step_by(FINER).copied().collect() };
        let moved = hammered(&truth, 0, 2, 1024.0 * FINER as f64, &fine);
        let clean: Vec<Vec<f64>> = moved.iter().map(|samples| every(samples)).collect();
        let responses = noisy(&clean, 0.03, &mut seeded(seed));
        let found =
            identify(&record(1024.0, Some(every(&fine)), responses, Quantity::Acceleration));
        must_be(&found, &truth, &format!("seed {seed}"));
    }
}

/// The same two modes 3 % apart in a decay and in a hammer test, in one response and in two.
#[test]
fn two_modes_3_percent_apart_are_told_apart() {
    let truth = [TrueMode::new(30.0, 0.01, &[1.0, 0.7]), TrueMode::new(30.9, 0.01, &[0.8, -1.0])];
    let force = pulses(1600, &[40], 4, 10.0);
    for seed in 0..10 {
        let mut rng = seeded(seed);
        let decay = noisy(&free_decay(&truth, 0, 160.0, 800, 0), TWENTY_DB, &mut rng);
        let hits = noisy(&hammered(&truth, 0, 2, 160.0, &force), TWENTY_DB, &mut rng);
        for (force, responses, quantity) in [
            (None, decay[..1].to_vec(), Quantity::Displacement),
            (None, decay, Quantity::Displacement),
            (Some(force.clone()), hits[..1].to_vec(), Quantity::Acceleration),
            (Some(force.clone()), hits, Quantity::Acceleration),
        ] {
            let what = format!("seed {seed}, {} responses, {quantity:?}", responses.len());
            must_be(&identify(&record(160.0, force, responses, quantity)), &truth, &what);
        }
    }
}

/// Displacement of ẍ + 2ζω ẋ + ω² (1 + s x²) x = f by Runge and Kutta's scheme of fourth order, the force linear
/// between samples.
fn stiffening(hz: f64, ratio: f64, s: f64, rate: f64, force: &[f64]) -> Vec<f64> {
    const PARTS: usize = 20;
    let w = std::f64::consts::TAU * hz;
    let h = 1.0 / rate / PARTS as f64;
    let slope =
        |x: f64, v: f64, f: f64| (v, f - 2.0 * ratio * w * v - w * w * (1.0 + s * x * x) * x);
    let (mut x, mut v) = (0.0, 0.0);
    (0..force.len())
        .map(|k| {
            let (now, next) = (force[k], force.get(k + 1).copied().unwrap_or(0.0));
            let seen = x;
            for part in 0..PARTS {
                let f = |step: f64| now + (next - now) * (part as f64 + step) / PARTS as f64;
                let a = slope(x, v, f(0.0));
                let b = slope(x + 0.5 * h * a.0, v + 0.5 * h * a.1, f(0.5));
                let c = slope(x + 0.5 * h * b.0, v + 0.5 * h * b.1, f(0.5));
                let d = slope(x + h * c.0, v + h * c.1, f(1.0));
                x += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
                v += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
            }
            seen
        })
        .collect()
}

/// A spring that stiffens with amplitude moves the frequency by 3/8 s a² (Nayfeh & Mook, §2.3.1): one mode, its
/// limit at small amplitudes, and the drift told; at 54 dB a linear model would ask for several.
#[test]
fn a_spring_that_stiffens_makes_one_mode() {
    let (hz, ratio, rate) = (20.0, 0.015, 400.0);
    let mut force = pulses(4000, &[40, 2040], 4, 100.0);
    force[2000..].iter_mut().for_each(|f| *f *= 0.8);
    let linear = stiffening(hz, ratio, 0.0, rate, &force);
    let largest = linear.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let share = 0.03;
    let moved = stiffening(hz, ratio, share / largest.powi(2), rate, &force);
    for seed in 0..3 {
        let responses = noisy(std::slice::from_ref(&moved), 0.006, &mut seeded(seed));
        let found = identify(&record(rate, Some(force.clone()), responses, Quantity::Displacement));
        must_be(&found, &[TrueMode::new(hz, ratio, &[1.0])], &format!("seed {seed}"));
        let drift = found.modes[0].drift.unwrap();
        let exact = 0.375 * share;
        assert!((drift / exact - 1.0).abs() < 0.15, "{drift} {exact}");
        let is_told = found.warnings.iter().any(|n| n.code.name() == "amplitude_dependent");
        assert!(is_told, "{:?}", found.warnings);
    }
}

/// A steady random force, which no hammer makes: Hann-windowed averages to start from, the whole record for
/// the fit.
#[test]
fn a_steady_random_force_serves_as_well() {
    let truth = arm();
    for seed in 0..3 {
        let mut rng = seeded(seed);
        let force: Vec<f64> = (0..6000).map(|_| gauss(&mut rng)).collect();
        let clean = hammered(&truth, 0, 2, 200.0, &force);
        let responses = noisy(&clean, TWENTY_DB, &mut rng);
        let found = identify(&record(200.0, Some(force), responses, Quantity::Acceleration));
        must_be(&found, &truth, &format!("seed {seed}"));
        assert!(found.modes.iter().all(|mode| mode.coherence.is_some()));
    }
}

/// A glitch as loud as a thousand decays hides nothing, and is told; so in hammer tests.
#[test]
fn a_spike_is_told_and_hides_nothing() {
    let truth = arm();
    // At 2.5 s of either.
    let glitch = |responses: &mut Vec<Vec<f64>>, at: usize| {
        let loudest = responses[1].iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
        responses[1][at] += 1000.0 * loudest;
    };
    let clean = free_decay(&truth, 0, 200.0, 1000, 0);
    let mut responses = noisy(&clean, TWENTY_DB, &mut seeded(3));
    glitch(&mut responses, 500);
    let decay = record(200.0, None, responses, Quantity::Displacement);
    let force = pulses(7000, &[100, 1900, 3700, 5300], 12, 100.0);
    let clean = hammered(&truth, 0, 2, 600.0, &force);
    let mut responses = noisy(&clean, TWENTY_DB, &mut seeded(4));
    glitch(&mut responses, 1500);
    let hammer = record(600.0, Some(force), responses, Quantity::Acceleration);
    for record in [decay, hammer] {
        let found = identify(&record);
        must_be(&found, &truth, "with a spike");
        let told: Vec<_> = found.warnings.iter().filter(|n| n.code == Code::Spike).collect();
        assert_eq!(told.len(), 1, "{:?}", found.warnings);
        assert!(told[0].what.contains("2.5000 s"), "{}", told[0].what);
        assert_eq!(channel_of(told[0]), Some("r1"));
    }
}

/// A cable that has come off: noise as loud as the other responses.
#[test]
fn a_response_of_noise_alone_is_told_and_spoils_nothing() {
    let truth = arm();
    for seed in 0..8 {
        let mut rng = seeded(seed);
        let mut responses = noisy(&free_decay(&truth, 0, 200.0, 1000, 0), TWENTY_DB, &mut rng);
        let level = rms(&responses[0]);
        responses[2] = (0..1000).map(|_| level * gauss(&mut rng)).collect();
        let found = identify(&record(200.0, None, responses, Quantity::Displacement));
        must_be(&found, &truth, "with a response of noise");
        let told: Vec<_> = found.warnings.iter().filter(|n| n.code == Code::NoSignal).collect();
        assert_eq!(told.len(), 1, "seed {seed}: {:?}", found.warnings);
        assert_eq!(channel_of(told[0]), Some("r2"));
    }
}

/// A channel that loses samples is left out; the others give the modes.
#[test]
fn lost_samples_are_told_and_spoil_nothing() {
    let truth = arm();
    let mut responses = noisy(&free_decay(&truth, 0, 200.0, 1000, 0), TWENTY_DB, &mut seeded(2));
    responses[1][300..400].fill(0.0);
    let found = identify(&record(200.0, None, responses, Quantity::Displacement));
    must_be(&found, &truth, "with lost samples");
    assert_eq!(found.modes[0].shape.len(), 2);
    let told: Vec<_> = found.warnings.iter().filter(|n| n.code == Code::Dropout).collect();
    assert_eq!(told.len(), 1, "{:?}", found.warnings);
    assert!(told[0].what.contains("100 samples from 1.5000 s"), "{}", told[0].what);
    assert_eq!(channel_of(told[0]), Some("r1"));
}

#[test]
fn noise_alone_has_no_modes() {
    let wrong: usize = (0..60_u64)
        .into_par_iter()
        .map(|seed| {
            let mut rng = seeded(seed);
            let noise: Vec<Vec<f64>> =
                (0..2).map(|_| (0..700).map(|_| gauss(&mut rng)).collect()).collect();
            usize::from(!identify(&record(140.0, None, noise, Quantity::Unknown)).modes.is_empty())
        })
        .sum();
    assert!(wrong <= 2, "{wrong} of 60");
}

/// Seeds of the coverage tests: `DETUNE_COVERAGE_SEEDS=500 cargo test --release --test analytic cover -- --nocapture`
/// is the long run, whose figures stand in the guide (validation).
pub(crate) fn coverage_seeds() -> u64 {
    const USUAL: u64 = 80;
    match std::env::var("DETUNE_COVERAGE_SEEDS") {
        Ok(seeds) => seeds.parse().expect("DETUNE_COVERAGE_SEEDS is a whole number"),
        Err(_) => USUAL,
    }
}

/// Seeds of other tests that ask for so many.
pub(crate) fn few(seeds: u64) -> u64 {
    seeds.div_ceil(one_in() as u64)
}

/// Shares outside of which right 95 % intervals lie once in a thousand times on either side, from the binomial
/// distribution itself; over 500 seeds no wider than 90 to 98 %.
fn bars(seeds: u64) -> [f64; 2] {
    const HELD: f64 = 0.95;
    const CHANCE: f64 = 1e-3;
    let mut chance = (1.0 - HELD).powf(seeds as f64);
    let (mut below, mut low, mut high) = (0.0, None, seeds);
    for held in 0..=seeds {
        below += chance;
        if below > CHANCE && low.is_none() {
            low = Some(held);
        }
        if 1.0 - below < CHANCE {
            high = held;
            break;
        }
        chance *= (seeds - held) as f64 / (held + 1) as f64 * HELD / (1.0 - HELD);
    }
    let [low, high] = [low.unwrap_or(0), high].map(|held| held as f64 / seeds as f64);
    if seeds < 500 { [low, high] } else { [low.max(0.90), high.min(0.98)] }
}

/// How many of the 95 % intervals hold the truth, over seeds.
fn must_cover(what: &str, truth: &[TrueMode], found: &[IdentifiedRecord]) {
    const Z: f64 = 1.959964;
    let count = found.len() as f64;
    let [low, high] = bars(found.len() as u64);
    for (index, truth) in truth.iter().enumerate() {
        let share = |is_in: &dyn Fn(&IdentifiedRecord) -> bool| {
            found.iter().filter(|f| is_in(f)).count() as f64 / count
        };
        let by_frequency = share(&|f| {
            let mode = &f.modes[index];
            (mode.frequency_hz - truth.hz).abs() < Z * mode.frequency_std_hz
        });
        let by_damping = share(&|f| {
            let mode = &f.modes[index];
            (mode.damping_ratio - truth.ratio).abs() < Z * mode.damping_std
        });
        let rms = |of: &dyn Fn(&IdentifiedRecord) -> f64| {
            (found.iter().map(|f| of(f).powi(2)).sum::<f64>() / count).sqrt()
        };
        let [of_frequency, of_damping] = [
            rms(&|f| (f.modes[index].frequency_hz - truth.hz) / f.modes[index].frequency_std_hz),
            rms(&|f| (f.modes[index].damping_ratio - truth.ratio) / f.modes[index].damping_std),
        ];
        println!(
            "{what}, mode {}: frequency {by_frequency:.3} ({of_frequency:.2} σ), damping \
             {by_damping:.3} ({of_damping:.2} σ)",
            index + 1
        );
        for covered in [by_frequency, by_damping] {
            assert!(
                (low..=high).contains(&covered),
                "{what}, mode {}: {covered} must lie in {low}..{high}",
                index + 1
            );
        }
    }
}

/// Cramér–Rao bound of frequency and damping of one mode, from the time domain: white noise of known
/// deviation, all modes' frequency, damping, amplitude and phase unknown, derivatives by differences.
fn cramer_rao(modes: &[TrueMode], rate: f64, samples: usize, deviation: f64) -> Vec<[f64; 2]> {
    let parameters: Vec<f64> =
        modes.iter().flat_map(|m| [m.hz, m.ratio, m.shape[0], -0.9]).collect();
    let model = |p: &[f64]| -> DVector<f64> {
        DVector::from_fn(samples, |k, _| {
            let t = k as f64 / rate;
            p.chunks(4)
                .map(|m| {
                    let lambda = TrueMode::new(m[0], m[1], &[]).lambda();
                    2.0 * m[2] * (lambda.re * t).exp() * (lambda.im * t + m[3]).cos()
                })
                .sum()
        })
    };
    let jacobian = DMatrix::from_columns(
        &(0..parameters.len())
            .map(|i| {
                let step = 1e-6 * parameters[i].abs();
                let (mut up, mut down) = (parameters.clone(), parameters.clone());
                up[i] += step;
                down[i] -= step;
                (model(&up) - model(&down)) / (2.0 * step)
            })
            .collect::<Vec<_>>(),
    );
    let covariance = (jacobian.transpose() * &jacobian).try_inverse().unwrap();
    (0..modes.len())
        .map(|m| [4 * m, 4 * m + 1].map(|i| deviation * covariance[(i, i)].sqrt()))
        .collect()
}

#[test]
fn deviations_of_free_decays_cover_and_reach_the_cramer_rao_bound() {
    let truth = [TrueMode::new(23.2, 0.02, &[1.0]), TrueMode::new(39.4, 0.015, &[0.7])];
    let clean = free_decay(&truth, 0, 140.0, 700, 0);
    let deviation = TWENTY_DB * rms(&clean[0]);
    let found: Vec<IdentifiedRecord> = (0..coverage_seeds())
        .into_par_iter()
        .map(|seed| {
            let responses = noisy(&clean, TWENTY_DB, &mut seeded(seed));
            identify(&record(140.0, None, responses, Quantity::Displacement))
        })
        .collect();
    let others = found.iter().filter(|f| f.modes.len() != 2).count();
    assert_eq!(others, 0);
    must_cover("free decay", &truth, &found);
    let bounds = cramer_rao(&truth, 140.0, 700, deviation);
    for (index, (mode, bound)) in truth.iter().zip(bounds).enumerate() {
        let errors =
            |of: &dyn Fn(&IdentifiedRecord) -> f64| rms(&found.iter().map(of).collect::<Vec<_>>());
        let scatter = [
            errors(&|f| f.modes[index].frequency_hz - mode.hz),
            errors(&|f| f.modes[index].damping_ratio - mode.ratio),
        ];
        let stated =
            [errors(&|f| f.modes[index].frequency_std_hz), errors(&|f| f.modes[index].damping_std)];
        for i in 0..2 {
            println!(
                "mode {}: bound {:.3e}, scatter {:.3e}, stated {:.3e}",
                index + 1,
                bound[i],
                scatter[i],
                stated[i]
            );
            // A deviation from n seeds is itself known to 1/√(2n); four of those on top of what the method
            // may lose: the first few samples, which may belong to the hit, are not used, and two lines at
            // the low end neither.
            let known = 4.0 / (2.0 * found.len() as f64).sqrt();
            assert!((scatter[i] / bound[i] - 1.0).abs() < 0.05 + known, "mode {}", index + 1);
            assert!((stated[i] / scatter[i] - 1.0).abs() < 0.03 + known, "mode {}", index + 1);
        }
    }
}

#[test]
fn deviations_of_hammer_tests_cover() {
    let truth = [TrueMode::new(14.0, 0.025, &[1.0, 0.4]), TrueMode::new(31.0, 0.015, &[0.5, -0.9])];
    let force = pulses(900, &[20, 460], 3, 50.0);
    let clean = hammered(&truth, 0, 2, 120.0, &force);
    let found: Vec<IdentifiedRecord> = (0..coverage_seeds())
        .into_par_iter()
        .map(|seed| {
            let responses = noisy(&clean, TWENTY_DB, &mut seeded(seed));
            identify(&record(120.0, Some(force.clone()), responses, Quantity::Acceleration))
        })
        .collect();
    assert!(
        found.iter().all(|f| f.modes.len() == 2),
        "{:?}",
        found.iter().find(|f| f.modes.len() != 2).map(|f| (&f.modes, &f.warnings))
    );
    must_cover("hammer", &truth, &found);
}

/// A shaker's force, coloured by a filter of first order, that goes on from before the record begins.
#[test]
fn deviations_under_a_measured_random_force_cover() {
    const BEFORE: usize = 400;
    let truth = [TrueMode::new(14.0, 0.025, &[1.0, 0.4]), TrueMode::new(31.0, 0.015, &[0.5, -0.9])];
    let found: Vec<IdentifiedRecord> = (0..coverage_seeds())
        .into_par_iter()
        .map(|seed| {
            let mut rng = seeded(9000 + seed);
            let mut last = 0.0;
            let force: Vec<f64> = (0..BEFORE + 1800)
                .map(|_| {
                    last = 0.5 * last + gauss(&mut rng);
                    last
                })
                .collect();
            let clean = hammered(&truth, 0, 2, 120.0, &force);
            let clean: Vec<Vec<f64>> = clean.iter().map(|own| own[BEFORE..].to_vec()).collect();
            let responses = noisy(&clean, TWENTY_DB, &mut rng);
            let force = force[BEFORE..].to_vec();
            identify(&record(120.0, Some(force), responses, Quantity::Acceleration))
        })
        .collect();
    assert!(
        found.iter().all(|f| f.modes.len() == 2),
        "{:?}",
        found.iter().find(|f| f.modes.len() != 2)
    );
    must_cover("random force", &truth, &found);
}
