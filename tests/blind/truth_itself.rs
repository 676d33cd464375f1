//! The truth of the blind cases against a closed form, against the program, and against itself.

use std::f64::consts::TAU;
use std::fs;

use nalgebra::{DMatrix, Matrix3, Vector3};
use serde_json::json;

use crate::truth::arm::{Arm, Body, Kind};
use crate::truth::case::{Case, Hidden, Order, Scenario, Strength, rms};
use crate::truth::confusion::{Bar, Confusion};
use crate::truth::dice::Dice;
use crate::truth::effects::{BEYOND, VOCABULARY};
use crate::truth::eigen::lowest_hz;
use crate::truth::robots::{Family, arm, pose, row_at};
use crate::truth::run::map;
use crate::truth::score::{Diagnosis, Met, Score};
use crate::truth::world::{World, extra};
use crate::truth::write;

const FAMILIES: [Family; 3] =
    [Family::Planar { links: 2 }, Family::Planar { links: 3 }, Family::SixAxis];

/// Relative; two ways of solving problems whose eigenvalues span four decades.
const AGREEMENT: f64 = 1e-9;

/// Eq. (45) of Pietruś & Gierlak (2023), written out from M and K of Eqs. (30) and (32).
#[test]
fn a_two_link_arm_has_the_frequencies_of_equation_45() {
    let dice = &mut Dice::new(1);
    for _ in 0..50 {
        let arm = arm(Family::Planar { links: 2 }, dice);
        let [first, second] = [&arm.joints[0], &arm.joints[1]];
        let about = |body: &Body| {
            body.inertia_kgm2[(1, 1)] + body.mass_kg * (body.com_m.x.powi(2) + body.com_m.z.powi(2))
        };
        let (l1, m2, lc2) = (second.origin_m.x, second.body.mass_kg, second.body.com_m.x);
        let a1 = about(&first.body) + about(&second.body) + m2 * l1 * l1;
        let (a2, a3) = (m2 * l1 * lc2, about(&second.body));
        let (k1, k2) = (first.stiffness_nm_per_rad, second.stiffness_nm_per_rad);
        let q = pose(&arm, dice);
        let cos = q[1].cos();
        let d1 = a1 * k2 + 2.0 * a2 * k2 * cos + a3 * k1;
        let d2 = a1 * a3 - a3 * a3 - (a2 * cos).powi(2);
        let root = (d1 * d1 - 4.0 * d2 * k1 * k2).sqrt();
        let closed = [(d1 - root) / (2.0 * d2), (d1 + root) / (2.0 * d2)].map(|w| w.sqrt() / TAU);
        let found = World::of(&arm).frequencies_hz(&row_at(q), 2);
        for (closed, found) in closed.iter().zip(&found) {
            assert!((found / closed - 1.0).abs() < 1e-11, "{found} for {closed}");
        }
    }
}

/// A chain of equal masses and springs between walls: ω_r = 2 √(k/m) sin(r π / 2 (n + 1)).
#[test]
fn bisection_finds_the_frequencies_of_a_chain() {
    let n = 7;
    let (mass, spring) = (3.0, 4e5);
    let m = DMatrix::identity(n, n) * mass;
    let k = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => 2.0 * spring,
        1 => -spring,
        _ => 0.0,
    });
    let found = lowest_hz(&k, &m, n);
    assert_eq!(found.len(), n);
    for (r, f) in found.iter().enumerate() {
        let angle = (r + 1) as f64 * std::f64::consts::PI / (2 * (n + 1)) as f64;
        let closed = 2.0 * f64::sqrt(spring / mass) * angle.sin() / TAU;
        assert!((f / closed - 1.0).abs() < 1e-12, "{f} for {closed}");
    }
}

/// Gravity's torque and stiffness against differences of the height of a straight pendulum's mass.
#[test]
fn gravity_pulls_a_pendulum_as_it_should() {
    let dice = &mut Dice::new(2);
    let mut arm = arm(Family::Planar { links: 2 }, dice);
    arm.joints.truncate(1);
    let (m, l, g) = (7.0, 0.6, 9.80665);
    arm.joints[0].body = Body::point(m, Vector3::new(l, 0.0, 0.0));
    arm.joints[0].axis = -Vector3::y();
    let world = World::of(&arm);
    for q in [-1.0, 0.0, 0.4, 1.5] {
        // The axis points away from the reader: the link rises with q, V = m g l sin q.
        let (_, _, motion) = world.matrices(&row_at(vec![q]));
        assert!((motion.gravity_torque[0] - m * g * l * q.cos()).abs() < 1e-12);
        assert!((motion.gravity_stiffness[(0, 0)] + m * g * l * q.sin()).abs() < 1e-12);
    }
}

/// Robots with everything that a robot file can hold, against `detune map`.
#[test]
fn frequencies_equal_those_of_the_program() {
    for (i, family) in FAMILIES.into_iter().cycle().take(18).enumerate() {
        let dice = &mut Dice::new(100 + i as u64);
        let mut arm = arm(family, dice);
        if i >= 3 {
            embellish(&mut arm, i, dice);
        }
        let folder = tempfile::tempdir().unwrap();
        write::robot(&arm, folder.path());
        let poses: Vec<Vec<f64>> = (0..12).map(|_| pose(&arm, dice)).collect();
        let world = World::of(&arm);
        let n = arm.joints.len() + arm.extras.len();
        let mapped = map(folder.path(), &arm, &poses);
        assert_eq!(mapped.len(), poses.len());
        for (q, mapped) in poses.iter().zip(&mapped) {
            let own = world.frequencies_hz(&row_at(q.clone()), n);
            assert_eq!(own.len(), n, "{}", arm.name);
            for (own, theirs) in own.iter().zip(mapped) {
                let off = (own / theirs - 1.0).abs();
                assert!(off < AGREEMENT, "robot {i}: {own} Hz here, {theirs} Hz there");
            }
        }
    }
}

/// Extra coordinates, a payload, drives, gravity, turned joints.
fn embellish(arm: &mut Arm, i: usize, dice: &mut Dice) {
    let direction = |dice: &mut Dice| Vector3::from_fn(|_, _| dice.even(-1.0, 1.0)).normalize();
    let kind = |dice: &mut Dice| if dice.chance(0.5) { Kind::Rotation } else { Kind::Translation };
    for link in [0, arm.joints.len()] {
        let (kind, axis) = (kind(dice), direction(dice));
        let origin = Vector3::from_fn(|_, _| dice.even(-0.3, 0.3));
        arm.extras.push(extra(link, kind, axis, origin, dice.log_even(2e5, 1e7)));
    }
    for joint in &mut arm.joints {
        joint.rpy_rad = Vector3::from_fn(|_, _| dice.even(-1.0, 1.0));
        joint.drive_kgm2 = dice.even(0.0, 10.0);
        joint.stiffness_nm_per_rad *= 0.3;
    }
    let edges = Vector3::new(0.2, 0.1, 0.3);
    let com = Vector3::from_fn(|_, _| dice.even(-0.1, 0.1));
    arm.payload = Some(Body::block(8.0, com, edges, Matrix3::identity()));
    arm.gravity_stiffness = i.is_multiple_of(2);
}

fn order(family: Family, scenario: Scenario, seed: u64) -> Order {
    Order { family, scenario, strength: Strength::Plain, poses: [16, 24], seed }
}

/// Every cause can be hidden, at the size that is wanted, and the same seed hides the same.
#[test]
fn every_cause_can_be_hidden() {
    for family in FAMILIES {
        for cause in VOCABULARY.into_iter().chain(BEYOND) {
            let scenario = if BEYOND.contains(&cause) {
                Scenario::Beyond(cause)
            } else {
                Scenario::Single(cause)
            };
            let Some(case) = Case::draw(order(family, scenario, 5)) else {
                panic!("{cause} cannot be hidden in a {} arm", family.name());
            };
            let part = &case.hidden[0];
            let sized = part.effect.change.has_size();
            let fits = part.over_noise >= 4.0 && (!sized || part.over_noise < 12.5);
            assert!(fits, "{}: {} of the noise", case.name(), part.over_noise);
            let again = Case::draw(order(family, scenario, 5)).unwrap();
            assert_eq!(case.table(), again.table());
        }
    }
}

/// What is measured differs from what is true by noise and rounding, and from the model by what is hidden.
#[test]
fn tables_hold_the_truth_and_noise() {
    for seed in 0..10 {
        for scenario in [Scenario::Nothing, Scenario::Single("joint_stiffness")] {
            let case = Case::draw(order(Family::SixAxis, scenario, seed)).unwrap();
            let plain = World::of(&case.nominal);
            let away = |world: &World| {
                let mut off = Vec::new();
                for (row, measured) in case.rows.iter().zip(&case.measured_hz) {
                    for (seen, f) in world.seen_hz(row, case.modes).iter().zip(measured) {
                        off.extend(f.map(|f| f / seen.unwrap() - 1.0));
                    }
                }
                rms(&off)
            };
            let from_truth = away(&case.world) / case.floor;
            assert!((0.6..1.4).contains(&from_truth), "{}: {from_truth}", case.name());
            if !case.hidden.is_empty() {
                let from_model = away(&plain) / case.floor;
                assert!(from_model > 3.0, "{}: {from_model}", case.name());
            }
        }
    }
}

/// What the table says of pose and circumstances is what the truth was asked at, to the last digit.
#[test]
fn tables_round_nothing_but_frequencies() {
    for cause in ["temperature_drift", "amplitude_dependence"] {
        let case = Case::draw(order(Family::SixAxis, Scenario::Single(cause), 4)).unwrap();
        let table = case.table();
        let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
        for (line, row) in table.lines().skip(1).zip(&case.rows) {
            let cells: Vec<&str> = line.split(',').collect();
            let told = |name: &str| -> Option<f64> {
                head.iter().position(|h| *h == name).map(|c| cells[c].parse().unwrap())
            };
            for (i, q) in row.joints_rad.iter().enumerate() {
                assert!((told(&format!("joint_{}_rad", i + 1)).unwrap() - q).abs() < 1e-12);
            }
            let circumstances =
                [("temperature_c", row.temperature_c), ("amplitude_nm", row.amplitude_nm)];
            for (name, true_value) in circumstances {
                assert!(told(name).is_none_or(|t| (t - true_value).abs() < 1e-9), "{name}");
            }
            let covariate = if cause.starts_with('t') { "temperature_c" } else { "amplitude_nm" };
            assert!(told(covariate).is_some());
        }
    }
}

/// The program reads what is written (every key and column of it is in its schema).
#[test]
fn several_effects_can_be_hidden_and_written() {
    for (count, family) in
        [(2, Family::Planar { links: 3 }), (2, Family::SixAxis), (3, Family::SixAxis)]
    {
        let case = Case::draw(order(family, Scenario::Several(count), 9)).unwrap();
        assert_eq!(case.hidden.len(), count);
        let folder = tempfile::tempdir().unwrap();
        case.write(folder.path());
        let poses: Vec<Vec<f64>> = case.rows.iter().map(|row| row.joints_rad.clone()).collect();
        assert_eq!(map(folder.path(), &case.nominal, &poses).len(), poses.len());
        let table = fs::read_to_string(folder.path().join("measured.csv")).unwrap();
        let cells = table.lines().next().unwrap().split(',').count();
        assert_eq!(table.lines().count(), poses.len() + 1);
        assert!(table.lines().all(|line| line.split(',').count() == cells));
    }
}

#[test]
fn more_poses_are_appended_and_the_old_rows_stay() {
    let case = Case::draw(order(Family::SixAxis, Scenario::Single("payload"), 3)).unwrap();
    let dice = &mut Dice::new(4);
    let poses: Vec<Vec<f64>> = (0..3).map(|_| pose(&case.nominal, dice)).collect();
    let more = case.measured_also_at(&poses, 1);
    assert!(more.table().starts_with(&case.table()));
    assert_eq!(more.rows.len(), case.rows.len() + 3);
}

/// A diagnosis of a case, written by hand.
fn diagnosis(findings: &serde_json::Value, heldout: f64) -> Diagnosis {
    Diagnosis::read(&json!({
        "schema": "diagnosis/1",
        "verdict": if findings.as_array().unwrap().is_empty() { "consistent" } else { "explained" },
        "baseline": {"rms_percent": 9.0, "heldout_rms_percent": 9.5, "per_mode_rms_percent": [9.0]},
        "findings": findings,
        "extended": {"rms_percent": 0.5, "heldout_rms_percent": heldout, "per_mode_rms_percent": [0.5]},
        "noise_floor_percent": 0.5,
        "next_poses": [{"joints_rad": [0.1, 0.2], "separates": ["payload", "joint_stiffness"]}],
    }))
    .unwrap()
}

#[test]
fn a_right_diagnosis_is_right_and_wrong_ones_are_wrong() {
    let family = Family::Planar { links: 2 };
    let case = Case::draw(order(family, Scenario::Single("joint_stiffness"), 7)).unwrap();
    let at = case.hidden[0].effect.at[0].clone();
    let truth = case.hidden[0].known.iter().find(|k| k.ending == "nm_per_rad").unwrap();
    let floor = 100.0 * case.noise_to_beat();
    let finding = |cause: &str, at: &str, group: serde_json::Value, ci: [f64; 2]| {
        json!([{"cause": cause, "at": at, "indistinguishable_from": group,
            "parameters": [{"name": "stiffness_nm_per_rad", "nominal": truth.nominal,
                "estimate": ci[0], "ci95": ci}],
            "evidence": {"delta_bic": -80.0, "p_value": 0.001}, "gain_percent_points": 6.0}])
    };
    let ci = [0.98 * truth.value, 1.02 * truth.value];
    let judge = |findings: &serde_json::Value, heldout: f64| {
        let score = Score::of(&case, &diagnosis(findings, heldout));
        let faults = score.faults(&case);
        (score, faults)
    };

    let (score, faults) = judge(&finding("joint_stiffness", &at, json!([]), ci), floor);
    assert!(faults.is_empty(), "{faults:?}");
    assert_eq!((score.answers[0].met, &score.answers[0].covered[..]), (Met::Found, &[true][..]));

    for beside in [[1.01, 1.02], [0.98, 0.99]] {
        let ci = beside.map(|share| share * truth.value);
        let (score, _) = judge(&finding("joint_stiffness", &at, json!([]), ci), floor);
        assert_eq!(score.answers[0].covered, [false]);
    }

    let member = json!([{"cause": "joint_stiffness", "at": at}]);
    let (score, faults) = judge(&finding("payload", "tool0", member, ci), floor);
    assert!(faults.is_empty(), "{faults:?}");
    assert_eq!((score.answers[0].met, score.answers[0].group), (Met::InGroup, 2));

    let crowd = json!([{"cause": "joint_stiffness", "at": at}, {"cause": "a", "at": "b"},
        {"cause": "c", "at": "d"}, {"cause": "e", "at": "f"}]);
    let (score, faults) = judge(&finding("payload", "tool0", crowd, ci), floor);
    assert!(!score.is_right() && faults[0].contains("group of 5"), "{faults:?}");

    let elsewhere = if at == "joint_1" { "joint_2" } else { "joint_1" };
    for (cause, at) in [("joint_stiffness", elsewhere), ("drive_inertia", &at)] {
        let (score, faults) = judge(&finding(cause, at, json!([]), ci), floor);
        assert_eq!(score.answers[0].met, Met::Missed);
        assert_eq!(score.spurious.len(), 1);
        assert_eq!(faults.len(), 2, "{faults:?}");
    }

    let (_, faults) = judge(&finding("joint_stiffness", &at, json!([]), ci), 1.3 * floor);
    assert!(faults[0].starts_with("held-out error 1.3"), "{faults:?}");
    let (_, faults) = judge(&json!([]), 9.5);
    assert!(faults[0].contains("consistent, not explained"), "{faults:?}");
}

/// Modes are places by their number, however they are written.
#[test]
fn modes_are_recognised() {
    let family = Family::Planar { links: 3 };
    let case = Case::draw(order(family, Scenario::Single("aliased_mode"), 1)).unwrap();
    for at in [json!(3), json!("3"), json!("mode 3"), json!("f3_hz")] {
        let findings = json!([{"cause": "aliased_mode", "at": at, "indistinguishable_from": [],
            "parameters": [], "evidence": {"delta_bic": -80.0, "p_value": 0.001},
            "gain_percent_points": 6.0}]);
        let score = Score::of(&case, &diagnosis(&findings, 100.0 * case.noise_to_beat()));
        assert_eq!(score.answers[0].met, Met::Found);
    }
}

#[test]
fn a_diagnosis_that_lacks_a_field_is_told() {
    for lacking in ["verdict", "findings", "noise_floor_percent", "next_poses"] {
        let mut whole = json!({
            "schema": "diagnosis/1", "verdict": "consistent", "findings": [],
            "baseline": {"heldout_rms_percent": 1.0}, "extended": {"heldout_rms_percent": 1.0},
            "noise_floor_percent": 0.5, "next_poses": [],
        });
        assert!(Diagnosis::read(&whole).is_ok());
        whole.as_object_mut().unwrap().remove(lacking);
        assert!(Diagnosis::read(&whole).unwrap_err().contains(lacking));
    }
}

/// What a perfect diagnosis, or an empty one, would say of a case.
fn oracle(case: &Case, blind: bool) -> Diagnosis {
    let finding = |part: &Hidden| {
        let parameters: Vec<_> = part
            .known
            .iter()
            .take(1)
            .map(|k| {
                let nominal = if k.nominal.is_finite() { json!(k.nominal) } else { json!(null) };
                let slack = 0.01 * k.value.abs();
                json!({"name": k.ending, "nominal": nominal, "estimate": k.value,
                    "ci95": [k.value - slack, k.value + slack]})
            })
            .collect();
        json!({"cause": part.effect.cause, "at": part.effect.at[0], "indistinguishable_from": [],
            "parameters": parameters, "evidence": {"delta_bic": -80.0, "p_value": 0.001},
            "gain_percent_points": 3.0})
    };
    let findings: Vec<_> = if blind || case.is_beyond() {
        Vec::new()
    } else {
        case.hidden.iter().map(finding).collect()
    };
    let mut read = diagnosis(&json!(findings), 100.0 * case.noise_to_beat());
    if case.is_beyond() && !blind {
        read.verdict = "unexplained".to_owned();
    }
    read
}

/// The bar lets a perfect engine pass and holds a blind one.
#[test]
fn a_perfect_diagnosis_passes_and_a_blind_one_does_not() {
    let all = Some(0.95);
    let bar = Bar {
        named: all,
        verdict: all,
        clean: all,
        gained: all,
        held_out: all,
        covered: all,
        split: None,
    };
    let scenarios = [
        Scenario::Single("joint_stiffness"),
        Scenario::Single("joint_zero_offset"),
        Scenario::Single("transverse_compliance"),
        Scenario::Single("missed_mode"),
        Scenario::Several(2),
        Scenario::Beyond("jump"),
    ];
    let (mut perfect, mut blind) = (Confusion::default(), Confusion::default());
    for scenario in scenarios {
        let case = Case::draw(order(Family::SixAxis, scenario, 2)).unwrap();
        perfect.add(&case, &Score::of(&case, &oracle(&case, false)));
        blind.add(&case, &Score::of(&case, &oracle(&case, true)));
    }
    assert_eq!(perfect.shortfalls(&bar), Vec::<String>::new());
    assert!(perfect.failures().is_empty(), "{:?}", perfect.failures());
    let markdown = perfect.markdown();
    assert!(markdown.contains("| joint_stiffness | six-axis | 1 | 100 % (1/1) |"), "{markdown}");
    let short = blind.shortfalls(&bar);
    // Beyond the vocabulary there is nothing to name, and so nothing to miss.
    assert!(short[0].ends_with("1 of 6, asked are 95 %"), "{short:?}");
    assert!(short[1].starts_with("the verdict: 0 of 6"), "{short:?}");

    let mut unjudged = Confusion::default();
    let case = Case::draw(order(Family::SixAxis, Scenario::Nothing, 2)).unwrap();
    unjudged.add_failure(&case, "no answer");
    assert_eq!(unjudged.shortfalls(&Bar::default()), ["no answer: 1 of 1"]);
}
