//! What a record lacks or may mislead by is told, each with record and channel, and nothing of it in a
//! sound record.

use crate::identify::asked;
use crate::vibration::{
    TrueMode, channel_of, free_decay, gauss, hammered, noisy, pulses, rms, seeded,
};
use detune::identify::mode::ShapePart;
use detune::identify::pose::Pose;
use detune::identify::record::{Channel, Conditions, Data, Measurement, Quantity, Record, Session};
use detune::identify::record_modes::{IdentifiedRecord, identify_record};
use detune::identify::session::identify_session;
use detune::notes::Code;
use detune::progress::silent;

const NOISE: f64 = 0.03;

fn arm() -> Vec<TrueMode> {
    vec![TrueMode::new(18.0, 0.02, &[1.0, 0.6]), TrueMode::new(36.5, 0.02, &[0.6, -1.0])]
}

fn record(rate: f64, force: Option<Vec<f64>>, responses: Vec<Vec<f64>>) -> Record {
    let channel =
        |(i, samples)| Channel { name: format!("r{i}"), quantity: Quantity::Acceleration, samples };
    let excitation =
        force.map(|samples| Channel { name: "hammer".into(), quantity: Quantity::Force, samples });
    let responses = responses.into_iter().enumerate().map(channel).collect();
    Record {
        name: "r.csv".into(),
        data: Data::Time { sample_rate_hz: rate, excitation, responses },
        driving_point: None,
        links: Vec::new(),
        spindle_rpm: None,
        instrument: Default::default(),
    }
}

fn identify(record: &Record) -> IdentifiedRecord {
    identify_record(record, &asked(&[50.0, 60.0]))
}

fn kinds(found: &IdentifiedRecord) -> Vec<Code> {
    let mut kinds: Vec<Code> = found.warnings.iter().map(|note| note.code).collect();
    kinds.sort();
    kinds.dedup();
    kinds
}

fn decay(samples: usize) -> Vec<Vec<f64>> {
    noisy(&free_decay(&arm(), 2, 200.0, samples, 0), NOISE, &mut seeded(1))
}

fn hammer(starts: &[usize]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let force = pulses(3000, starts, 5, 40.0);
    let clean = hammered(&arm(), 0, 2, 200.0, &force);
    (force, noisy(&clean, NOISE, &mut seeded(2)))
}

#[test]
fn sound_records_have_no_notices() {
    let (force, responses) = hammer(&[50, 800, 1500, 2250]);
    for found in [
        identify(&record(200.0, None, decay(1000))),
        identify(&record(200.0, Some(force), responses)),
    ] {
        assert_eq!(found.modes.len(), 2);
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    }
}

#[test]
fn a_bounce_of_the_hammer_is_told_and_bends_nothing() {
    let (force, responses) = hammer(&[50, 800, 815, 1500, 2250]);
    let found = identify(&record(200.0, Some(force), responses));
    assert_eq!(kinds(&found), [Code::DoubleHit]);
    assert_eq!(channel_of(&found.warnings[0]), Some("hammer"));
    assert!(found.warnings[0].to_string().starts_with("record 'r.csv'"), "{:?}", found.warnings);
    for (mode, truth) in found.modes.iter().zip(arm()) {
        assert!((mode.frequency_hz - truth.hz).abs() < 5.0 * mode.frequency_std_hz, "{mode:?}");
        assert!((mode.damping_ratio / truth.ratio - 1.0).abs() < 0.05, "{mode:?}");
    }
}

/// Without a force channel a second hit shows as a decay that is cut short.
#[test]
fn a_second_hit_within_a_decay_is_told() {
    let one = free_decay(&arm(), 2, 200.0, 1600, 100);
    let two = free_decay(&arm(), 2, 200.0, 1600, 190);
    let both: Vec<Vec<f64>> = one
        .iter()
        .zip(&two)
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a + 3.0 * b).collect())
        .collect();
    let found = identify(&record(200.0, None, noisy(&both, 0.01, &mut seeded(3))));
    assert!(kinds(&found).contains(&Code::DoubleHit), "{:?}", found.warnings);
    for (mode, truth) in found.modes.iter().zip(arm()) {
        assert!((mode.frequency_hz / truth.hz - 1.0).abs() < 1e-3, "{mode:?}");
    }
}

#[test]
fn clipping_and_dead_channels_are_told_by_name() {
    let mut responses = decay(1000);
    let limit = 0.4 * responses[1].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    responses[1].iter_mut().for_each(|s| *s = s.clamp(-limit, limit));
    responses.push(vec![0.25; 1000]);
    let found = identify(&record(200.0, None, responses));
    let named = |kind| {
        let mut of = found.warnings.iter().filter(move |note| note.code == kind);
        of.next().and_then(channel_of).map(str::to_owned)
    };
    assert_eq!(named(Code::Clipping).as_deref(), Some("r1"));
    assert_eq!(named(Code::DeadChannel).as_deref(), Some("r2"));
}

/// 0.7 s: the first mode is at e^(−1.6) = 20 %; 0.15 s: fewer than eight periods.
#[test]
fn leakage_and_short_records_are_told() {
    let found = identify(&record(200.0, None, decay(140)));
    assert_eq!(kinds(&found), [Code::Leakage], "{:?}", found.warnings);
    assert!((found.modes[0].frequency_hz / 18.0 - 1.0).abs() < 5e-3, "{:?}", found.modes);
    let one: Vec<Vec<f64>> = free_decay(&arm()[..1], 2, 200.0, 50, 0);
    let found = identify(&record(200.0, None, noisy(&one, 0.01, &mut seeded(1))));
    assert!(kinds(&found).contains(&Code::ShortRecord), "{:?}", found.warnings);
}

#[test]
fn low_coherence_at_a_mode_is_told_with_its_channel() {
    let (force, mut responses) = hammer(&[50, 800, 1500, 2250]);
    let mut rng = seeded(5);
    let loud = 15.0 * rms(&responses[1]);
    responses[1].iter_mut().for_each(|s| *s += loud * gauss(&mut rng));
    let found = identify(&record(200.0, Some(force), responses));
    let told: Vec<_> = found.warnings.iter().filter(|n| n.code == Code::LowCoherence).collect();
    assert!(!told.is_empty() && told.iter().all(|n| channel_of(n) == Some("r1")), "{told:?}");
    assert_eq!(found.modes.len(), 2, "{:?}", found.modes);
}

fn with_tone(hz: f64, rate: f64) -> Vec<Vec<f64>> {
    let modes = [TrueMode::new(18.0, 0.02, &[1.0, 0.6])];
    let mut responses = noisy(&free_decay(&modes, 2, rate, 1000, 0), NOISE, &mut seeded(4));
    for samples in &mut responses {
        let size = 0.3 * rms(samples);
        for (k, s) in samples.iter_mut().enumerate() {
            *s += size * (std::f64::consts::TAU * hz * k as f64 / rate + 1.0).sin();
        }
    }
    responses
}

#[test]
fn tones_of_mains_and_spindle_are_flagged_and_neither_dropped_nor_passed_for_modes() {
    for (tone_hz, rate, seen_hz, spindle_rpm, kind) in [
        (50.01, 200.0, 50.01, None, Some(Code::Mains)),
        // Lamps flicker at twice the mains: at 140 frames/s that is 40 Hz.
        (100.0, 140.0, 40.0, None, Some(Code::Mains)),
        (47.0, 200.0, 47.0, Some(1410.0), Some(Code::Spindle)),
        // A tone of unknown source whose damping is none is told, and no finding.
        (43.3, 200.0, 43.3, None, Some(Code::Unsettled)),
    ] {
        let record = Record { spindle_rpm, ..record(rate, None, with_tone(tone_hz, rate)) };
        let found = identify(&record);
        assert_eq!(found.modes.len(), 2, "{tone_hz}: {:?}", found.modes);
        assert!((found.modes[1].frequency_hz - seen_hz).abs() < 0.01, "{:?}", found.modes);
        assert_eq!(found.modes[1].suspicion, kind, "{tone_hz}");
        assert_eq!(found.modes[0].suspicion, None);
        assert!(kind.is_none_or(|kind| kinds(&found).contains(&kind)), "{tone_hz}");
        let is_unknown = kind == Some(Code::Unsettled);
        assert_eq!(kinds(&found).contains(&Code::Tone), is_unknown, "{tone_hz}");
    }
}

/// In a hammer test the force explains modes but not the mains.
#[test]
fn mains_in_a_hammer_test_are_told_and_bend_nothing() {
    let (force, mut responses) = hammer(&[50, 800, 1500, 2250]);
    for samples in &mut responses {
        let size = 0.3 * rms(samples);
        for (k, s) in samples.iter_mut().enumerate() {
            *s += size * (std::f64::consts::TAU * 50.0 * k as f64 / 200.0).sin();
        }
    }
    let found = identify(&record(200.0, Some(force), responses));
    let told = kinds(&found);
    assert!(told.contains(&Code::Tone) || told.contains(&Code::Mains), "{told:?}");
    let modes: Vec<_> = found.modes.iter().filter(|mode| mode.suspicion.is_none()).collect();
    assert_eq!(modes.len(), 2, "{:?}", found.modes);
    for (mode, truth) in modes.iter().zip(arm()) {
        assert!((mode.frequency_hz / truth.hz - 1.0).abs() < 1e-3, "{mode:?}");
        assert!((mode.damping_ratio / truth.ratio - 1.0).abs() < 0.1, "{mode:?}");
    }
}

/// A mode at 83 Hz, taken at 140 and at 400 samples/s: it shows at 57 Hz, which is told as possible from one
/// rate and as certain from two.
#[test]
fn aliased_frequencies_are_reported() {
    let modes = [TrueMode::new(18.0, 0.02, &[1.0]), TrueMode::new(83.0, 0.01, &[0.5])];
    let taken = |rate: f64, samples| Measurement {
        record: record(
            rate,
            None,
            noisy(&free_decay(&modes, 0, rate, samples, 0), NOISE, &mut seeded(7)),
        ),
        pose: Pose::Angles { beta1: None, beta2: 1.0 },
        conditions: Conditions::default(),
        id: None,
    };
    let slow = identify(&taken(140.0, 700).record);
    assert!((slow.modes[1].frequency_hz - 57.0).abs() < 0.05, "{:?}", slow.modes);
    assert!(kinds(&slow).contains(&Code::MayBeFolded));
    let session = Session {
        asked: asked(&[50.0]),
        joint_columns: None,
        records: vec![taken(140.0, 700), taken(400.0, 2000)],
    };
    let found = identify_session(&session, &silent);
    assert_eq!(found.poses.len(), 2);
    let told: Vec<_> = found.warnings.iter().filter(|n| n.code == Code::MayBeFolded).collect();
    assert_eq!(told.len(), 1, "{:?}", found.warnings);
    assert!(told[0].what.contains(" 82.9") && told[0].what.contains("alias"), "{told:?}");
}

/// Records of one pose are merged, others not; a record that disagrees is told.
#[test]
fn records_of_one_pose_make_one_row() {
    let taken = |seed, hz: f64, beta2, temperature_c| {
        let modes = [TrueMode::new(hz, 0.02, &[1.0]), TrueMode::new(41.0, 0.02, &[0.7])];
        Measurement {
            record: record(
                200.0,
                None,
                noisy(&free_decay(&modes, 0, 200.0, 1000, 0), NOISE, &mut seeded(seed)),
            ),
            pose: Pose::Angles { beta1: None, beta2 },
            conditions: Conditions { temperature_c, ..Conditions::default() },
            id: Some(format!("t{seed}")),
        }
    };
    let session = |records| Session { asked: asked(&[]), joint_columns: None, records };
    let found = identify_session(
        &session(vec![
            taken(1, 18.0, 0.5, Some(20.0)),
            taken(2, 18.0, 0.5, Some(20.0)),
            taken(3, 18.0, 0.5, Some(30.0)),
            taken(4, 18.0, 0.6, Some(20.0)),
        ]),
        &silent,
    );
    assert_eq!(found.poses.len(), 3);
    assert_eq!(found.poses[0].id.as_deref(), Some("t1+t2"));
    assert_eq!(found.poses[0].modes[0].members, [(0, 0), (1, 0)]);
    let (merged, single) = (&found.poses[0].modes[0], &found.records[0].modes[0]);
    assert!(merged.frequency_std_hz < single.frequency_std_hz * 1.5);
    assert!((merged.frequency_hz - 18.0).abs() < 4.0 * merged.frequency_std_hz);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    let found = identify_session(
        &session(vec![taken(1, 18.0, 0.5, None), taken(2, 18.1, 0.5, None)]),
        &silent,
    );
    assert_eq!(found.warnings[0].code, Code::Disagreement, "{:?}", found.warnings);
    let spread = found.poses[0].modes[0].frequency_std_hz;
    assert!((0.02..0.1).contains(&spread), "{spread}");
}

/// A decay seen by some of the sensors, its parts as loud as `loud`.
fn seen(modes: &[TrueMode], sensors: &[usize], loud: &[f64], seed: u64) -> Record {
    let own: Vec<TrueMode> = modes
        .iter()
        .zip(loud)
        .map(|(mode, loud)| {
            let shape: Vec<f64> = sensors.iter().map(|&at| loud * mode.shape[at]).collect();
            TrueMode::new(mode.hz, mode.ratio, &shape)
        })
        .collect();
    let responses = noisy(&free_decay(&own, 0, 200.0, 1000, 0), NOISE, &mut seeded(seed));
    let mut seen = record(200.0, None, responses);
    let Data::Time { responses, .. } = &mut seen.data else { panic!("decays are sampled") };
    for (channel, at) in responses.iter_mut().zip(sensors) {
        channel.name = format!("s{at}");
    }
    seen.driving_point = None;
    seen
}

fn arm_modes(factor: f64) -> Vec<TrueMode> {
    vec![
        TrueMode::new(12.0 * factor, 0.02, &[1.0, 0.8, 0.5, 0.2, -0.3]),
        TrueMode::new(27.0 * factor, 0.015, &[-0.6, 0.3, 1.0, 0.7, 0.4]),
        TrueMode::new(43.0 * factor, 0.01, &[0.5, -0.9, 0.2, 0.6, -1.0]),
    ]
}

fn at_pose(record: Record, beta2: f64) -> Measurement {
    let pose = Pose::Angles { beta1: None, beta2 };
    Measurement { record, pose, conditions: Conditions::default(), id: None }
}

/// Two set-ups with two sensors in common, started unlike: one shape over all five.
#[test]
fn set_ups_of_a_pose_make_one_shape() {
    let modes = arm_modes(1.0);
    let records = vec![
        at_pose(seen(&modes, &[0, 1, 2], &[1.0, 0.6, 0.4], 1), 0.5),
        at_pose(seen(&modes, &[2, 1, 3, 4], &[0.3, -0.9, 0.7], 2), 0.5),
    ];
    let session = Session { asked: asked(&[]), joint_columns: None, records };
    let found = identify_session(&session, &silent);
    assert_eq!(found.poses.len(), 1);
    assert_eq!(found.poses[0].modes.len(), 3, "{:?}", found.warnings);
    for (mode, truth) in found.poses[0].modes.iter().zip(&modes) {
        assert_eq!(mode.shape.len(), 5, "{mode:?}");
        let sensor = |part: &ShapePart| part.response[1..].parse::<usize>().unwrap();
        let largest = mode.shape.iter().max_by(|a, b| a.value.norm().total_cmp(&b.value.norm()));
        let scale = truth.shape[sensor(largest.unwrap())];
        for part in &mode.shape {
            let off = (part.value - truth.shape[sensor(part)] / scale).norm();
            assert!(off <= 4.5 * part.std && off < 0.03, "{part:?} {truth:?}");
        }
    }
}

/// Sensors that were moved between records under the same names. By hand, the shapes' criteria are 0.36, 0.00 and 0.27.
#[test]
fn moved_sensors_of_one_name_are_told() {
    let modes = arm_modes(1.0);
    let mut moved = seen(&modes, &[2, 3, 4], &[0.8, 0.9, 0.7], 2);
    let Data::Time { responses, .. } = &mut moved.data else { panic!("decays are sampled") };
    for (at, channel) in responses.iter_mut().enumerate() {
        channel.name = format!("s{at}");
    }
    let first = || at_pose(seen(&modes, &[0, 1, 2], &[1.0, 0.6, 0.4], 1), 0.5);
    let told = |other: Record| -> Vec<String> {
        let records = vec![first(), at_pose(other, 0.5)];
        let session = Session { asked: asked(&[]), joint_columns: None, records };
        let found = identify_session(&session, &silent);
        let unlike = found.warnings.into_iter().filter(|note| note.what.contains("unlike shapes"));
        unlike.map(|note| note.what).collect()
    };
    let of_moved = told(moved);
    assert_eq!(of_moved.len(), 3, "{of_moved:?}");
    for (told, criterion) in of_moved.iter().zip(["0.36", "0.00", "0.27"]) {
        assert!(told.contains(&format!("criterion {criterion}")), "{told}");
    }
    let again = seen(&modes, &[0, 1, 2], &[-0.5, 0.9, 1.0], 3);
    assert_eq!(told(again), Vec::<String>::new());
}

/// A pose whose second mode was not excited: its third is in the column of the third. With one sensor nobody knows, and
/// is told so.
#[test]
fn a_missed_mode_leaves_its_column_blank() {
    let session = |sensors: &[usize]| Session {
        asked: asked(&[]),
        joint_columns: None,
        records: vec![
            at_pose(seen(&arm_modes(1.0), sensors, &[1.0, 0.6, 0.4], 1), 0.5),
            at_pose(seen(&arm_modes(0.93), sensors, &[1.0, 0.0, 0.7], 2), 0.8),
        ],
    };
    let found = identify_session(&session(&[0, 1, 2, 3, 4]), &silent);
    let rows = found.table().rows;
    let hz = |row: usize, mode: usize| rows[row].frequencies_hz[mode].map(f64::round);
    assert_eq!([0, 1, 2].map(|mode| hz(0, mode)), [Some(12.0), Some(27.0), Some(43.0)]);
    assert_eq!([0, 1, 2].map(|mode| hz(1, mode)), [Some(11.0), None, Some(40.0)]);
    let told: Vec<&str> = found.warnings.iter().map(|note| note.what.as_str()).collect();
    assert!(told.len() == 1 && told[0].contains("f1, f3"), "{told:?}");
    let found = identify_session(&session(&[0]), &silent);
    let rows = found.table().rows;
    assert_eq!(rows[1].frequencies_hz[1].map(f64::round), Some(40.0));
    let told: Vec<&str> = found.warnings.iter().map(|note| note.what.as_str()).collect();
    assert!(told.len() == 1 && told[0].contains("compare the rows"), "{told:?}");
}

/// Five decays of one state, clamped again before each: the five modes scatter by 1.2 %, each by itself or all together,
/// and two of them lie 2 % apart. They stay five columns, whose deviations are those of the scatter's mean.
#[test]
fn modes_that_scatter_between_records_keep_their_columns() {
    let shapes: [&[f64]; 5] = [
        &[1.0, 0.8, 0.5, 0.2, -0.3],
        &[-0.6, 0.3, 1.0, 0.7, 0.4],
        &[0.5, -0.9, 0.2, 0.6, -1.0],
        &[0.9, -0.2, -0.8, 0.5, 0.6],
        &[-0.3, 1.0, -0.7, 0.6, 0.2],
    ];
    let hz = [11.3, 18.9, 34.6, 35.3, 79.5];
    for together in [false, true] {
        let mut rng = seeded(31);
        let mut truth: Vec<[f64; 5]> = Vec::new();
        let records = (0..5).map(|record| {
            let all = 0.012 * gauss(&mut rng);
            let own =
                hz.map(|hz| hz * (1.0 + if together { all } else { 0.012 * gauss(&mut rng) }));
            truth.push(own);
            let modes = own.iter().zip(shapes).map(|(hz, shape)| TrueMode::new(*hz, 0.008, shape));
            at_pose(seen(&modes.collect::<Vec<_>>(), &[0, 1, 2, 3, 4], &[1.0; 5], record), 0.5)
        });
        let session =
            Session { asked: asked(&[]), joint_columns: None, records: records.collect() };
        let found = identify_session(&session, &silent);
        let modes = &found.poses[0].modes;
        let told: Vec<_> = modes.iter().map(|m| (m.frequency_hz, m.frequency_std_hz)).collect();
        assert_eq!(modes.len(), 5, "{told:?} {:?}", found.warnings);
        for (at, mode) in modes.iter().enumerate() {
            assert_eq!((mode.number, mode.members.len()), (Some(at + 1), 5), "{told:?}");
            for &(record, own) in &mode.members {
                let own = found.records[record].modes[own].frequency_hz;
                assert!((own / truth[record][at] - 1.0).abs() < 2e-3, "{record} {at} {own}");
            }
            let mean = truth.iter().map(|own| own[at]).sum::<f64>() / 5.0;
            let square: f64 = truth.iter().map(|own| (own[at] - mean).powi(2)).sum();
            let of_mean = (square / 4.0 / 5.0).sqrt();
            let ratio = mode.frequency_std_hz / of_mean;
            // Records count by what they state of their noise, too.
            assert!((0.8..1.25).contains(&ratio), "{at}: {ratio} {told:?}");
            assert!((mode.frequency_hz - mean).abs() < 0.1 * of_mean, "{at}: {mean} {told:?}");
        }
    }
}

/// Two modes of a record 3 % apart, each missing in the other record: of unlike shapes they stay two; and two of one
/// record are never one, however near and alike they are.
#[test]
fn modes_that_are_two_stay_two() {
    let [a, b]: [&[f64]; 2] = [&[1.0, 0.8, 0.5, 0.2, -0.3], &[-0.6, 0.3, 1.0, 0.7, 0.4]];
    let session = |first: &[TrueMode], second: &[TrueMode]| {
        let taken =
            |modes: &[TrueMode], seed| at_pose(seen(modes, &[0, 1, 2, 3, 4], &[1.0; 5], seed), 0.5);
        let records = vec![taken(first, 1), taken(second, 2)];
        let session = Session { asked: asked(&[]), joint_columns: None, records };
        identify_session(&session, &silent).poses[0].modes.clone()
    };
    let mode = |hz: f64, shape: &[f64]| TrueMode::new(hz, 0.008, shape);
    let apart = session(&[mode(20.0, a), mode(60.0, b)], &[mode(20.6, b), mode(60.0, b)]);
    assert_eq!(apart.iter().map(|m| m.members.len()).collect::<Vec<_>>(), [1, 1, 2]);
    let alike = session(&[mode(20.0, a), mode(20.5, a)], &[mode(20.2, a), mode(20.7, a)]);
    assert_eq!(alike.iter().map(|m| m.members.len()).collect::<Vec<_>>(), [2, 2], "{alike:?}");
    assert!((alike[0].frequency_hz - 20.1).abs() < 0.02, "{alike:?}");
}

/// Between two poses the upper two modes change places: columns stay by frequency, and that is told.
#[test]
fn modes_that_cross_between_poses_are_told() {
    let told = |factors: [f64; 3]| -> Vec<String> {
        let mut moved = arm_modes(1.0);
        moved.iter_mut().zip(factors).for_each(|(mode, factor)| mode.hz *= factor);
        let all = |modes: &[TrueMode], seed| seen(modes, &[0, 1, 2, 3, 4], &[1.0; 3], seed);
        let records = vec![at_pose(all(&arm_modes(1.0), 1), 0.5), at_pose(all(&moved, 2), 0.8)];
        let session = Session { asked: asked(&[]), joint_columns: None, records };
        let found = identify_session(&session, &silent);
        for row in found.table().rows {
            assert!(row.frequencies_hz.is_sorted(), "{:?}", row.frequencies_hz);
        }
        found.warnings.into_iter().map(|note| note.what).collect()
    };
    assert_eq!(told([1.05, 1.2, 0.9]), Vec::<String>::new());
    let crossed = told([1.0, 1.4, 0.8]);
    assert!(crossed.len() == 1 && crossed[0].contains("change places"), "{crossed:?}");
    assert!(crossed[0].contains(" 34.4"), "{crossed:?}");
}
