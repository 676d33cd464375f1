//! Records that mislead: noise alone, hits that come late, twice or too early, frequencies above half of every rate,
//! springs that are stiffer on one side. All motion is integrated in time (Runge-Kutta).

use crate::identify::{asked, record};
use crate::vibration::{TrueMode, gauss, hammered, noisy, seeded};
use detune::identify::mode::Mode;
use detune::identify::pose::Pose;
use detune::identify::record::{Asked, Conditions, Measurement, Quantity, Record, Session};
use detune::identify::record_modes::{IdentifiedRecord, identify_record};
use detune::identify::session::{IdentifiedSession, PoseMode, identify_session};
use detune::notes::{Code, Note};
use detune::progress::silent;

/// Natural frequency, Hz, and damping ratio of an oscillator.
type Own = (f64, f64);

/// Acceleration of a unit mass on a spring that has `soft` of its stiffness in tension, at the samples, under a
/// force over time; from `speed` at rest position on.
fn swung(
    (hz, ratio): Own,
    soft: f64,
    speed: f64,
    rate: f64,
    samples: usize,
    force: &dyn Fn(f64) -> f64,
) -> Vec<f64> {
    const STEPS: usize = 16;
    let omega = std::f64::consts::TAU * hz;
    let acceleration = |t: f64, x: f64, v: f64| {
        let share = if x > 0.0 { soft } else { 1.0 };
        force(t) - 2.0 * ratio * omega * v - omega * omega * share * x
    };
    let h = 1.0 / (rate * STEPS as f64);
    let (mut x, mut v, mut all) = (0.0, speed, Vec::new());
    for k in 0..samples {
        all.push(acceleration(k as f64 / rate, x, v));
        for step in 0..STEPS {
            let t = k as f64 / rate + step as f64 * h;
            let (v1, a1) = (v, acceleration(t, x, v));
            let (x2, v2) = (x + 0.5 * h * v1, v + 0.5 * h * a1);
            let a2 = acceleration(t + 0.5 * h, x2, v2);
            let (x3, v3) = (x + 0.5 * h * v2, v + 0.5 * h * a2);
            let a3 = acceleration(t + 0.5 * h, x3, v3);
            let (x4, v4) = (x + h * v3, v + h * a3);
            let a4 = acceleration(t + h, x4, v4);
            x += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        }
    }
    all
}

/// A half sine, 1 s^-1 high for `width` seconds.
fn half_sine(t: f64, start: f64, width: f64) -> f64 {
    let phase = (t - start) / width;
    if (0.0..=1.0).contains(&phase) { (std::f64::consts::PI * phase).sin() } else { 0.0 }
}

/// Sums of the modes over the rows of `shapes`, with noise of a share of the loudest sample.
fn mixed(own: &[Vec<f64>], shapes: &[&[f64]], noise: f64, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = seeded(seed);
    let mix = |shape: &&[f64]| -> Vec<f64> {
        let at = |k: usize| own.iter().zip(*shape).map(|(own, s)| s * own[k]).sum::<f64>();
        (0..own[0].len()).map(at).collect()
    };
    let mut all: Vec<Vec<f64>> = shapes.iter().map(mix).collect();
    for channel in &mut all {
        let loudest = channel.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        channel.iter_mut().for_each(|y| *y += noise * loudest * gauss(&mut rng));
    }
    all
}

fn acceleration(rate: f64, force: Option<Vec<f64>>, responses: Vec<Vec<f64>>) -> Record {
    record(rate, force, responses, Quantity::Acceleration)
}

/// What goes into the table, Hz.
fn listed(found: &IdentifiedRecord) -> Vec<f64> {
    let own = found.modes.iter().filter(|mode| mode.suspicion.is_none());
    own.map(|mode| mode.frequency_hz).collect()
}

/// Every mode and no other, each within so many deviations and within a share of its damping.
fn must_be(found: &IdentifiedRecord, truth: &[Own], what: &str) {
    let own: Vec<_> = found.modes.iter().filter(|mode| mode.suspicion.is_none()).collect();
    assert_eq!(own.len(), truth.len(), "{what}: {:?} {:?}", listed(found), found.warnings);
    for (mode, (hz, ratio)) in own.iter().zip(truth) {
        let off = (mode.frequency_hz - hz) / mode.frequency_std_hz;
        assert!(off.abs() < 4.5, "{what}: {hz} {} is {off} off", mode.frequency_hz);
        assert!((mode.damping_ratio / ratio - 1.0).abs() < 0.1, "{what}: {hz} {mode:?}");
    }
}

/// Noise in several channels has poles that keep their place as the order rises: none is a mode.
#[test]
fn noise_alone_has_no_modes() {
    let (mut with_modes, mut all) = (0, 0);
    for (channels, samples, seeds) in
        [(1, 3000, 8), (3, 3000, 8), (6, 3000, 8), (3, 30_000, 6), (6, 30_000, 4)]
    {
        for seed in 0..seeds {
            let mut rng = seeded(5000 + seed);
            let responses: Vec<Vec<f64>> =
                (0..channels).map(|_| (0..samples).map(|_| gauss(&mut rng)).collect()).collect();
            let found = identify_record(
                &record(500.0, None, responses, Quantity::Displacement),
                &asked(&[]),
            );
            with_modes += usize::from(!listed(&found).is_empty());
            all += 1;
        }
    }
    assert!(20 * with_modes <= all, "{with_modes} of {all} records of noise have modes");
}

/// The same samples, whatever the rate that they are said to have: a quarter of a second of quiet at 44 100 samples/s
/// is a hundred times as long at 441.
#[test]
fn a_hit_after_quiet_is_found_at_any_rate() {
    const RATE: f64 = 44_100.0;
    let truth = [(310.0, 0.004), (742.0, 0.003), (1260.0, 0.005), (2210.0, 0.003)];
    let own: Vec<Vec<f64>> = truth
        .iter()
        .map(|own| {
            let mut quiet = vec![0.0; 11_025];
            // Displacement of free decays, as a microphone near by hears them.
            let omega = std::f64::consts::TAU * own.0;
            quiet.extend(swung(*own, 1.0, 1.0, RATE, 66_150, &|_| 0.0).iter().map(|a| a / omega));
            quiet
        })
        .collect();
    let responses = mixed(&own, &[&[0.5, 0.8, 0.4, 0.6]], 0.003, 1);
    for slower in [1.0, 10.0, 100.0] {
        let found = identify_record(
            &record(RATE / slower, None, responses.clone(), Quantity::Unknown),
            &asked(&[]),
        );
        let truth = truth.map(|(hz, ratio)| (hz / slower, ratio));
        must_be(&found, &truth, &format!("{slower} times as slow"));
    }
}

fn arm() -> [Own; 3] {
    [(21.0, 0.015), (43.0, 0.012), (91.0, 0.01)]
}

const SHAPES: [&[f64]; 3] = [&[1.0, 0.5, 0.3], &[0.6, -0.8, 0.5], &[0.4, 0.5, -0.9]];

/// A hammer that bounces within 40 ms, and a force sensor with noise of 0.2 % of its peak: what it says between and
/// after the pulses is no force.
#[test]
fn noise_of_the_force_between_two_pulses_makes_no_modes() {
    const RATE: f64 = 1024.0;
    for seed in 0..6 {
        let (start, apart) = (0.3 + 0.01 * seed as f64, 0.025 + 0.004 * seed as f64);
        let force = move |t: f64| {
            100.0 * (half_sine(t, start, 0.003) + 0.4 * half_sine(t, start + apart, 0.003))
        };
        let own = arm().map(|own| swung(own, 1.0, 0.0, RATE, 4096, &force));
        let mut rng = seeded(seed + 40);
        let heard = (0..4096).map(|k| force(k as f64 / RATE) + 0.2 * gauss(&mut rng)).collect();
        let found = identify_record(
            &acceleration(RATE, Some(heard), mixed(&own, &SHAPES, 0.001, seed)),
            &asked(&[]),
        );
        assert_eq!(listed(&found).len(), 3, "{seed}: {:?} {:?}", listed(&found), found.warnings);
    }
}

/// The second hit comes while the first decay still is a third as loud.
#[test]
fn a_decay_ends_where_the_next_hit_begins() {
    const RATE: f64 = 1000.0;
    for seed in 0..4 {
        let hits = [0.3, 1.1 + 0.02 * seed as f64, 2.0 + 0.01 * seed as f64];
        let force = move |t: f64| hits.iter().map(|start| half_sine(t, *start, 0.003)).sum();
        let truth = [(19.3, 0.007), (37.0, 0.006), (81.0, 0.005)];
        let own = truth.map(|own| swung(own, 1.0, 0.0, RATE, 5000, &force));
        let found = identify_record(
            &acceleration(RATE, None, mixed(&own, &SHAPES, 0.005, seed)),
            &asked(&[]),
        );
        must_be(&found, &truth, &format!("seed {seed}"));
    }
}

/// A hammer that strikes again 25 to 150 ms later, with no channel for its force: too early for the past to predict
/// what comes, which is left out, and told where it is no part of the first impact.
#[test]
fn a_hit_in_the_first_moments_of_a_decay_divides_it() {
    const RATE: f64 = 512.0;
    let truth = [(11.2, 0.02), (17.9, 0.02), (26.8, 0.015), (44.1, 0.015)];
    let shapes: [&[f64]; 3] =
        [&[1.0, 0.5, 0.3, 0.4], &[0.6, -0.8, 0.5, 0.6], &[0.4, 0.5, -0.9, 0.7]];
    for (seed, gap) in [0.025, 0.03, 0.045, 0.06, 0.08, 0.1, 0.12, 0.15].into_iter().enumerate() {
        let hits = [(0.25, 1.0), (0.25 + gap, 0.6)];
        let force = move |t: f64| -> f64 {
            hits.iter().map(|(start, height)| 100.0 * height * half_sine(t, *start, 0.004)).sum()
        };
        let own = truth.map(|own| swung(own, 1.0, 0.0, RATE, 3072, &force));
        let found = identify_record(
            &acceleration(RATE, None, mixed(&own, &shapes, 0.002, seed as u64)),
            &asked(&[]),
        );
        let codes: Vec<Code> = found.warnings.iter().map(|note| note.code).collect();
        let is_told = codes.iter().any(|c| matches!(c, Code::Discontinuity | Code::DoubleHit));
        assert!(is_told || gap < 0.04, "{gap}: {:?}", found.warnings);
        must_be(&found, &truth, &format!("{gap} s"));
    }
}

/// Three samples that a recorder lost in the middle of a decay, its column of time as even as ever; and a blow that
/// the hammer's channel does not have.
#[test]
fn a_vibration_that_does_not_go_on_is_used_up_to_there() {
    const RATE: f64 = 500.0;
    const SAMPLES: usize = 3000;
    let truth = [(9.3, 0.012), (23.0, 0.008), (61.0, 0.006)];
    let told = |found: &IdentifiedRecord| -> usize {
        found.warnings.iter().filter(|note| note.code == Code::Discontinuity).count()
    };
    for seed in 0..4 {
        let force = |t: f64| 300.0 * half_sine(t, 0.2, 0.006);
        let second = 1.7 + 0.1 * seed as f64;
        let both = move |t: f64| force(t) + 60.0 * half_sine(t, second, 0.006);
        let heard = |lost: usize| -> Option<Vec<f64>> {
            let mut rng = seeded(seed + 70);
            let whole = (0..SAMPLES).map(|k| force(k as f64 / RATE) + 0.2 * gauss(&mut rng));
            Some(whole.take(SAMPLES - lost).collect())
        };
        let swings = |force: &dyn Fn(f64) -> f64| {
            truth.map(|own| swung(own, 1.0, 0.0, RATE, SAMPLES, force))
        };
        let whole = mixed(&swings(&force), &SHAPES, 0.005, seed);
        let mut lost = whole.clone();
        let at = 500 + 37 * seed as usize;
        lost.iter_mut().for_each(|own| drop(own.drain(at..at + 3)));
        let struck = mixed(&swings(&both), &SHAPES, 0.005, seed);
        let identified = |heard: Option<Vec<f64>>, responses: Vec<Vec<f64>>| {
            identify_record(&acceleration(RATE, heard, responses), &asked(&[]))
        };
        for (what, found, departs) in [
            ("whole", identified(heard(0), whole.clone()), 0),
            ("lost", identified(heard(3), lost.clone()), 1),
            ("struck", identified(heard(0), struck), 1),
            ("free", identified(None, whole), 0),
            ("free, lost", identified(None, lost), 1),
        ] {
            must_be(&found, &truth, &format!("seed {seed}, {what}"));
            assert_eq!(told(&found), departs, "seed {seed}, {what}: {:?}", found.warnings);
        }
    }
}

fn two_rates(hz: f64, rates: [f64; 2]) -> IdentifiedSession {
    let taken = |rate: f64| {
        let samples = (6.0 * rate) as usize;
        let own =
            [(19.7, 0.012), (hz, 0.008)].map(|own| swung(own, 1.0, 1.0, rate, samples, &|_| 0.0));
        let record = Record {
            name: format!("{rate}"),
            ..acceleration(rate, None, mixed(&own, &[&[1.0, 0.2], &[0.5, -0.3]], 0.003, 3))
        };
        Measurement {
            record,
            pose: Pose::Joints(vec![0.0]),
            conditions: Conditions::default(),
            id: None,
        }
    };
    identify_session(
        &Session { asked: asked(&[]), joint_columns: None, records: rates.map(taken).to_vec() },
        &silent,
    )
}

/// 91 Hz shows as 49 Hz at 140 samples/s and as 29 Hz at 120: above half of both.
#[test]
fn a_frequency_above_half_of_two_rates_is_told() {
    let told = |session: &IdentifiedSession, code: Code| -> Vec<String> {
        let own = session.warnings.iter().filter(|note| note.code == code);
        own.map(|note| note.what.clone()).collect()
    };
    let session = two_rates(91.0, [140.0, 120.0]);
    let folded = told(&session, Code::MayBeFolded);
    assert!(
        folded.len() == 1 && (folded[0].contains(" 90.9") || folded[0].contains(" 91.0")),
        "{:?}",
        session.warnings
    );
    let session = two_rates(47.0, [140.0, 120.0]);
    assert!(told(&session, Code::MayBeFolded).is_empty(), "{:?}", session.warnings);
    assert!(told(&session, Code::Disagreement).is_empty(), "{:?}", session.warnings);
}

/// 38.2 Hz shows as 21.8 Hz at 60 samples/s and as itself at 100: the alias stays out of the table, and what both rates
/// show is in one column. 91 Hz lies above half of 140 and of 120: neither alias is in the table.
#[test]
fn aliases_that_two_rates_show_stay_out_of_the_table() {
    let session = two_rates(38.2, [60.0, 100.0]);
    let rows = session.table().rows;
    let hz = |row: usize| -> Vec<Option<f64>> {
        rows[row].frequencies_hz.iter().map(|hz| hz.map(|hz| (10.0 * hz).round() / 10.0)).collect()
    };
    assert_eq!(hz(0), [Some(19.7), None], "{:?}", session.warnings);
    assert_eq!(hz(1), [Some(19.7), Some(38.2)], "{:?}", session.warnings);
    let suspected: Vec<Option<Code>> = session.poses[0].modes.iter().map(|m| m.suspicion).collect();
    assert_eq!(suspected, [None, Some(Code::MayBeFolded)]);
    let session = two_rates(91.0, [140.0, 120.0]);
    for row in session.table().rows {
        let hz: Vec<f64> = row.frequencies_hz.iter().flatten().copied().collect();
        assert!(hz.len() == 1 && (hz[0] - 19.7).abs() < 0.1, "{hz:?} {:?}", session.warnings);
    }
}

/// Minutes of blows at 1000 samples/s: the modes up to 120 Hz are there, not those below 12 Hz alone.
#[test]
fn a_long_record_keeps_its_band() {
    const RATE: f64 = 500.0;
    let hits: Vec<f64> = (0..40).map(|i| 1.0 + 4.0 * f64::from(i)).collect();
    let force = |t: f64| -> f64 {
        let near = ((t - 1.0) / 4.0).floor().clamp(0.0, 39.0) as usize;
        1000.0 * half_sine(t, hits[near], 0.008)
    };
    let truth = [(31.0, 0.012), (66.0, 0.01)];
    let own = truth.map(|own| swung(own, 1.0, 0.0, RATE, 80_000, &force));
    let heard: Vec<f64> = (0..80_000).map(|k| force(k as f64 / RATE)).collect();
    let shapes: [&[f64]; 1] = [&[1.0, 0.7]];
    let found = identify_record(
        &acceleration(RATE, Some(heard), mixed(&own, &shapes, 0.01, 2)),
        &asked(&[]),
    );
    must_be(&found, &truth, "hits");
    let is_told = found.warnings.iter().any(|note| note.what.contains("so long"));
    assert!(is_told, "{:?}", found.warnings);
}

#[test]
fn modes_of_a_clipped_record_stay_out_of_the_table_and_a_clipped_channel_out_of_the_record() {
    const RATE: f64 = 500.0;
    let truth = [(20.0, 0.01), (47.0, 0.015)];
    let own = truth.map(|own| swung(own, 1.0, 1.0, RATE, 3000, &|_| 0.0));
    let mut responses = mixed(&own, &[&[2.0, 0.5], &[1.0, -0.5]], 0.005, 1);
    let limit = 0.3 * responses[0].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    responses[0].iter_mut().for_each(|y| *y = y.clamp(-limit, limit));
    let both = identify_record(&acceleration(RATE, None, responses.clone()), &asked(&[]));
    must_be(&both, &truth, "one of two");
    responses.truncate(1);
    let alone = identify_record(&acceleration(RATE, None, responses), &asked(&[]));
    assert!(listed(&alone).is_empty(), "{:?}", listed(&alone));
}

/// A clipped record of a pose bends nothing that a sound one knows.
#[test]
fn a_sound_record_of_a_pose_is_not_bent_by_a_clipped_one() {
    const RATE: f64 = 500.0;
    let own = [(20.0, 0.01), (47.0, 0.015)].map(|own| swung(own, 1.0, 1.0, RATE, 3000, &|_| 0.0));
    let sound = mixed(&own, &[&[2.0, 0.5]], 0.005, 1);
    let mut clipped = mixed(&own, &[&[2.0, 0.5]], 0.005, 2);
    let limit = 0.3 * clipped[0].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    clipped[0].iter_mut().for_each(|y| *y = y.clamp(-limit, limit));
    let measured = |responses: Vec<Vec<f64>>| Measurement {
        record: acceleration(RATE, None, responses),
        pose: Pose::Joints(vec![0.0]),
        conditions: Conditions::default(),
        id: None,
    };
    let of = |records: Vec<Measurement>| {
        let session = Session { asked: asked(&[]), joint_columns: None, records };
        identify_session(&session, &silent)
    };
    let alone = of(vec![measured(sound.clone())]);
    let both = of(vec![measured(clipped), measured(sound)]);
    assert_eq!(both.records[0].modes[0].suspicion, Some(Code::Clipping));
    let values = |of: &[PoseMode]| -> Vec<[f64; 4]> {
        let certain = of.iter().filter(|mode| mode.suspicion.is_none());
        certain
            .map(|m| [m.frequency_hz, m.frequency_std_hz, m.damping_ratio, m.damping_std])
            .collect()
    };
    let (alone, both) = (values(&alone.poses[0].modes), values(&both.poses[0].modes));
    assert_eq!((alone.len(), &alone), (2, &both));
}

/// A mode that noise leaves uncertain lies at no multiple of another.
#[test]
fn a_mode_near_twice_another_in_noise_is_no_harmonic() {
    const RATE: f64 = 500.0;
    let own = [(20.0, 0.02), (40.12, 0.02)].map(|own| swung(own, 1.0, 1.0, RATE, 2000, &|_| 0.0));
    let mut told = 0;
    for seed in 0..8 {
        let responses = mixed(&own, &[&[1.0, 0.7], &[0.8, -0.6]], 0.1, seed);
        let found = identify_record(&acceleration(RATE, None, responses), &asked(&[]));
        let listed = listed(&found);
        let is_near = |hz: f64| listed.iter().any(|own| (own / hz - 1.0).abs() < 0.01);
        assert!(is_near(20.0) && is_near(40.12), "seed {seed}: {listed:?} {:?}", found.warnings);
        told += found.warnings.iter().filter(|note| note.what.contains("may be 2 times")).count();
    }
    // The louder of the two is not always the lower one.
    assert!((1..8).contains(&told), "{told} times");
}

/// A mode at 0.985 of half the rate; a frequency that is asked for and not there; a record twice.
#[test]
fn what_is_not_looked_at_is_told_once() {
    const RATE: f64 = 500.0;
    let decays = |hz: f64| {
        let own = [(20.0, 0.01), (hz, 0.004)].map(|own| swung(own, 1.0, 1.0, RATE, 3000, &|_| 0.0));
        acceleration(RATE, None, mixed(&own, &[&[1.0, 0.2]], 0.003, 1))
    };
    let found = identify_record(&decays(246.25), &asked(&[]));
    let is_told = |note: &&detune::notes::Note| note.code == Code::MayBeFolded;
    assert!(found.warnings.iter().any(|note| is_told(&note)), "{:?}", found.warnings);
    let found = identify_record(&decays(47.0), &asked(&[]));
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    let wanted = Asked { near_hz: vec![33.0], ..asked(&[]) };
    let found = identify_record(&decays(47.0), &wanted);
    let codes: Vec<Code> = found.warnings.iter().map(|note| note.code).collect();
    assert_eq!(codes, [Code::NoModes, Code::Remark], "{:?}", found.warnings);
    let measurement = Measurement {
        record: decays(47.0),
        pose: Pose::Joints(vec![0.0]),
        conditions: Conditions::default(),
        id: None,
    };
    let records = vec![measurement.clone(), measurement];
    let session = Session { asked: asked(&[]), joint_columns: None, records };
    let twice = identify_session(&session, &silent);
    let (one, merged) = (&twice.records[0].modes[0], &twice.poses[0].modes[0]);
    assert_eq!(merged.frequency_std_hz, one.frequency_std_hz);
    assert!(twice.warnings.iter().any(|note| note.what.contains("counts once")));
}

/// 15 % softer in tension: the second harmonic is no mode.
#[test]
fn harmonics_of_a_spring_that_is_softer_on_one_side_are_no_modes() {
    const RATE: f64 = 200.0;
    for seed in 0..3 {
        let own = [swung((8.8, 0.01), 0.85, 1.0, RATE, 2400, &|_| 0.0)];
        let responses = mixed(&own, &[&[1.0], &[0.4]], 0.001, seed);
        let found = identify_record(&acceleration(RATE, None, responses), &asked(&[]));
        // The mean of both halves of a period.
        let hz = 2.0 / (1.0 / 8.8 + 1.0 / (8.8 * 0.85_f64.sqrt()));
        let listed = listed(&found);
        assert!(listed.len() == 1 && (listed[0] / hz - 1.0).abs() < 1e-3, "{listed:?} {hz}");
    }
}

/// Two modes nearer to each other than they are wide, in one response: they beat, which a mode that depends on its
/// amplitude imitates in part.
#[test]
fn two_modes_side_by_side_are_not_one_that_depends_on_amplitude() {
    const RATE: f64 = 512.0;
    for (seed, (apart, ratio)) in
        [(0.0133, 0.015), (0.02, 0.025), (0.03, 0.025)].into_iter().enumerate()
    {
        let truth = [(15.0, ratio), (15.0 * (1.0 + apart), ratio), (31.0, 0.02)];
        let force = |t: f64| 100.0 * half_sine(t, 0.25, 0.006);
        let own = truth.map(|own| swung(own, 1.0, 0.0, RATE, 4096, &force));
        let heard = (0..4096).map(|k| force(k as f64 / RATE)).collect();
        let responses = mixed(&own, &[&[0.64, 0.49, 0.64]], 0.002, seed as u64);
        let found = identify_record(&acceleration(RATE, Some(heard), responses), &asked(&[]));
        must_be(&found, &truth, &format!("{apart} {ratio}"));
        let told = |note: &Note| note.code == Code::AmplitudeDependent;
        assert!(!found.warnings.iter().any(told), "{:?}", found.warnings);
    }
}

/// Seconds under a header of milliseconds, in one of three records.
#[test]
fn a_record_a_thousand_times_as_fast_as_the_others_is_told() {
    let record = |rate: f64, at: f64| Measurement {
        record: {
            let own = [swung((20.0 * rate / 500.0, 0.01), 1.0, 1.0, rate, 3000, &|_| 0.0)];
            acceleration(rate, None, mixed(&own, &[&[1.0, 0.2]], 0.003, 1))
        },
        pose: Pose::Joints(vec![at]),
        conditions: Conditions::default(),
        id: None,
    };
    let told = |fast: f64| {
        let records = vec![record(500.0, 0.0), record(500.0, 0.1), record(fast, 0.2)];
        let session = Session { asked: asked(&[]), joint_columns: None, records };
        let found = identify_session(&session, &silent).warnings;
        found.into_iter().filter(|note| note.code == Code::Units).count()
    };
    assert_eq!((told(500e3), told(5e3)), (1, 0));
}

/// A steady tone beside a mode outlives it after a blow, and is not that mode at small amplitudes.
#[test]
fn a_tone_that_outlives_a_mode_is_not_taken_for_it() {
    const RATE: f64 = 400.0;
    let modes = [TrueMode::new(47.0, 0.03, &[1.0]), TrueMode::new(21.0, 0.02, &[0.8])];
    let force: Vec<f64> =
        (0..1200).map(|k| if (40..43).contains(&k) { 80.0 } else { 0.0 }).collect();
    let clean = hammered(&modes, 0, 2, RATE, &force);
    let loudest = clean[0].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let tone = |k: usize| 0.03 * loudest * (std::f64::consts::TAU * 49.3 * k as f64 / RATE).sin();
    let seen: Vec<f64> = clean[0].iter().enumerate().map(|(k, y)| y + tone(k)).collect();
    for seed in 0..4 {
        let seen = noisy(std::slice::from_ref(&seen), 0.01, &mut seeded(seed));
        let record = record(RATE, Some(force.clone()), seen, Quantity::Acceleration);
        let found = identify_record(&record, &asked(&[]));
        let near = |mode: &&Mode| (mode.frequency_hz / 47.0 - 1.0).abs() < 0.02;
        let own = found.modes.iter().find(near);
        let own = own.unwrap_or_else(|| panic!("{:?} {:?}", found.modes, found.warnings));
        assert!((own.frequency_hz - 47.0).abs() < 4.0 * own.frequency_std_hz, "{own:?}");
        assert!(own.frequency_std_hz < 0.005 * 47.0, "{own:?}");
    }
}
