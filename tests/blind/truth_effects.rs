//! The hidden effects of the blind cases: each is what it claims to be, and so are noise, instruments and records.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use crate::truth::arm::Body;
use crate::truth::case::{Case, Order, Scenario, Strength, rms};
use crate::truth::dice::Dice;
use crate::truth::records::HammerTest;
use crate::truth::robots::{Family, arm, pose, row_at};
use crate::truth::run::map;
use crate::truth::world::{Bend, Law, ModeLaw, Row, World};
use crate::truth::write;

/// Effects that a robot file can hold, written into one, give the frequencies that were hidden.
#[test]
fn hidden_effects_are_what_they_claim_to_be() {
    let causes = [
        "joint_stiffness",
        "link_inertia",
        "com_offset",
        "base_compliance",
        "transverse_compliance",
        "drive_inertia",
        "gravity_stiffness",
    ];
    for family in [Family::Planar { links: 3 }, Family::SixAxis] {
        for cause in causes {
            let scenario = Scenario::Single(cause);
            let strength = Strength::Plain;
            let order = Order { family, scenario, strength, poses: [16, 24], seed: 6 };
            let case = Case::draw(order).unwrap();
            let folder = tempfile::tempdir().unwrap();
            write::robot(&case.world.arm, folder.path());
            let poses: Vec<Vec<f64>> = case.rows.iter().map(|row| row.joints_rad.clone()).collect();
            let mapped = map(folder.path(), &case.nominal, &poses);
            for (row, mapped) in case.rows.iter().zip(&mapped) {
                // Nothing hangs at the tool of the file.
                let row = &Row { payload_kg: 0.0, ..row.clone() };
                for (own, theirs) in case.world.frequencies_hz(row, case.modes).iter().zip(mapped) {
                    let off = (own / theirs - 1.0).abs();
                    assert!(off < 1e-9, "{}: {own} Hz, {theirs} Hz in detune", case.name());
                }
            }
        }
    }
}

/// A load in the frame of the last link is a payload in that of the tool.
#[test]
fn a_carried_load_is_a_payload() {
    let mut arm = arm(Family::SixAxis, &mut Dice::new(7));
    arm.payload = None;
    let row = row_at(vec![0.3, 0.4, -0.5, 0.6, 0.7, -0.8]);
    let mut carried = World::of(&arm);
    carried.carried.push((6, Body::point(5.0, arm.tip_m + Vector3::new(0.1, 0.0, 0.02))));
    arm.payload = Some(Body::point(5.0, Vector3::new(0.1, 0.0, 0.02)));
    let payload = World::of(&arm).frequencies_hz(&row, 6);
    for (a, b) in carried.frequencies_hz(&row, 6).iter().zip(&payload) {
        assert!((a / b - 1.0).abs() < 1e-12, "{a}, {b}");
    }
}

/// Laws of springs at poses and circumstances where their factor is plain.
#[test]
fn laws_give_the_factors_that_they_state() {
    let arm = arm(Family::SixAxis, &mut Dice::new(8));
    let row = |temperature_c, amplitude_nm, q| Row {
        temperature_c,
        amplitude_nm,
        previous_rad: vec![0.0; 6],
        ..row_at(vec![q; 6])
    };
    let factor = |joint: usize, law: Law, row: &Row| {
        let mut world = World::of(&arm);
        world.laws.push((joint, law));
        let (_, k, _) = world.matrices(row);
        k[(joint, joint)] / arm.joints[joint].stiffness_nm_per_rad
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a}, not {b}");
    close(factor(2, Law::Warms { per_k: 0.004 }, &row(30.0, 1.0, 0.1)), 0.96);
    let softens = Law::AmplitudeSoftens { a: 0.2, reference_nm: 40.0 };
    close(factor(1, softens, &row(20.0, 20.0, 0.1)), 0.9);
    let power = Law::AmplitudePower { a: 0.5, reference_nm: 4.0 };
    close(factor(1, power, &row(20.0, 16.0, 0.1)), 0.5);
    let here = row(20.0, 1.0, 0.3);
    let reference_nm = World::of(&arm).gravity_torque_nm(1, &here).abs();
    close(factor(1, Law::LoadStiffens { a: 0.3, reference_nm }, &here), 1.3);
    close(factor(1, Law::LoadSoftens { a: 0.25, reference_nm }, &here), 0.8);
    let late = 1.0 + 0.3 * (1.0 - f64::exp(-2.0));
    close(factor(1, Law::LoadSaturates { a: 0.3, reference_nm }, &here), late);
    // Joint 1 stands upright: no load, no change.
    close(factor(0, Law::LoadStiffens { a: 0.3, reference_nm }, &here), 1.0);
    close(factor(3, Law::Hysteresis { a: 0.1 }, &here), 1.1);
    close(factor(3, Law::Hysteresis { a: 0.1 }, &row(20.0, 1.0, -0.3)), 0.9);
    close(factor(3, Law::Wave { a: 0.1, phase_rad: TAU / 4.0 - 0.9 }, &here), 1.1);
    close(factor(3, Law::Jump { a: 0.1 }, &here), 1.0);
    close(factor(3, Law::Jump { a: 0.1 }, &Row { unseen: true, ..here }), 1.1);
}

/// Where the mode meets the absorber's frequency the two part by ε: f √(1 ± ε).
#[test]
fn an_absorber_repels_its_mode() {
    let arm = arm(Family::SixAxis, &mut Dice::new(8));
    let row = row_at(vec![0.2; 6]);
    let mut world = World::of(&arm);
    let plain = world.frequencies_hz(&row, 4);
    let met = plain[1] * (1.0 - 1e-12);
    world.mode_laws.push(ModeLaw::Absorber { mode: 1, frequency_hz: met, coupling: 0.05 });
    let seen = world.frequencies_hz(&row, 4);
    assert!((seen[1] / plain[1] - 1.05_f64.sqrt()).abs() < 1e-6, "{seen:?} for {plain:?}");
    assert_eq!([seen[0], seen[2], seen[3]], [plain[0], plain[2], plain[3]]);
    // Elsewhere both branches are roots of (x − ω²)(x − ω_t²) = ε² ω² ω_t².
    for share in [0.8, 0.95, 1.05, 1.2] {
        let tuned = share * plain[1];
        let law = ModeLaw::Absorber { mode: 1, frequency_hz: tuned, coupling: 0.05 };
        world.mode_laws = vec![law];
        let x = world.frequencies_hz(&row, 4)[1].powi(2);
        let (a, b) = (plain[1].powi(2), tuned * tuned);
        assert!(((x - a) * (x - b) / (a * b) - 0.0025).abs() < 1e-12, "{share}");
        assert!((x > a) == (a > b), "{share}");
    }
}

#[test]
fn instruments_fold_and_overlook() {
    let arm = arm(Family::SixAxis, &mut Dice::new(9));
    let mut world = World::of(&arm);
    let mut row = row_at(vec![0.2; 6]);
    let f = world.frequencies_hz(&row, 6);
    world.instrument.sample_rate_hz = Some(f[3] + f[4]);
    let folded = world.seen_hz(&row, 5)[4].unwrap();
    assert!((folded - f[3]).abs() < 1e-9, "{folded}");
    world.instrument.sample_rate_hz = None;
    world.instrument.missed_mode = Some(1);
    assert_eq!(world.seen_hz(&row, 3), [Some(f[0]), Some(f[1]), Some(f[2])]);
    row.overlooked = true;
    assert_eq!(world.seen_hz(&row, 3), [Some(f[0]), Some(f[2]), Some(f[3])]);
    assert_eq!(world.seen_hz(&row, 6)[5], None);
}

/// The outer part of a bending link and the inner one are the whole link, and a stiff bend is none.
#[test]
fn a_link_that_hardly_bends_is_a_link() {
    let arm = arm(Family::SixAxis, &mut Dice::new(10));
    let row = row_at(vec![0.3, 0.4, -0.5, 0.6, 0.7, -0.8]);
    let whole = World::of(&arm).frequencies_hz(&row, 6);
    let mut world = World::of(&arm);
    let axis = Vector3::y();
    world.bends.push(Bend { link: 2, fraction: 0.4, axis, stiffness_nm_per_rad: 1e13 });
    for (bent, whole) in world.frequencies_hz(&row, 6).iter().zip(&whole) {
        assert!((bent / whole - 1.0).abs() < 1e-5, "{bent} for {whole}");
    }
}

#[test]
fn noise_has_unit_variance() {
    let dice = &mut Dice::new(12);
    let n = 200_000;
    let normal: Vec<f64> = (0..n).map(|_| dice.normal()).collect();
    let student: Vec<f64> = (0..n).map(|_| dice.student(4)).collect();
    assert!((rms(&normal) - 1.0).abs() < 0.01, "{}", rms(&normal));
    assert!((rms(&student) - 1.0).abs() < 0.1, "{}", rms(&student));
    let far = |all: &[f64]| all.iter().filter(|x| x.abs() > 4.0).count();
    assert!(far(&student) > 10 * far(&normal));
}

/// Half as long steps give the same record: the scheme is of a high order.
#[test]
fn records_do_not_depend_on_the_step() {
    let arm = arm(Family::Planar { links: 2 }, &mut Dice::new(11));
    let (world, row) = (World::of(&arm), row_at(vec![0.8, 0.5]));
    let record = |finer: usize| {
        let test = HammerTest { noise: 0.0, blows: 1, finer, ..HammerTest::default() };
        test.record(&world, &row, &mut Dice::new(13)).x_mm
    };
    let (coarse, fine) = (record(1), record(2));
    let off: Vec<f64> = coarse.iter().zip(&fine).map(|(a, b)| a - b).collect();
    assert!(rms(&off) < 1e-4 * rms(&fine), "{} of {}", rms(&off), rms(&fine));
}

/// By mode, how far from its frequency a record rings most, per mille.
fn rings_off_per_mille(cubic: f64) -> Vec<f64> {
    let dice = &mut Dice::new(11);
    let arm = arm(Family::Planar { links: 2 }, dice);
    let world = World::of(&arm);
    let row = row_at(pose(&arm, dice));
    let test = HammerTest { cubic, ..HammerTest::default() };
    let record = test.record(&world, &row, dice);
    let first = (0.2 * test.sample_rate_hz) as usize;
    let last = (test.seconds_per_blow * test.sample_rate_hz) as usize;
    let strength = |f: f64| -> f64 {
        let sum = |phase: f64| -> f64 {
            (first..last)
                .map(|s| {
                    let swing = record.x_mm[s] + record.z_mm[s];
                    swing * (TAU * f * record.time_s[s] + phase).cos()
                })
                .sum()
        };
        sum(0.0).hypot(sum(0.25 * TAU))
    };
    let best = |f: f64| {
        let at = |k: &i32| strength(f * (1.0 + 1e-4 * f64::from(*k)));
        (-150..=150).max_by(|a, b| at(a).total_cmp(&at(b))).unwrap()
    };
    world.frequencies_hz(&row, 2).into_iter().map(|f| 0.1 * f64::from(best(f))).collect()
}

/// A damped mode's spectrum peaks close to it; the cubic part of the springs moves the peak, but little.
#[test]
fn records_ring_at_the_true_frequencies() {
    let straight = rings_off_per_mille(0.0);
    let curved = rings_off_per_mille(HammerTest::default().cubic);
    println!("off by {straight:?} ‰, with cubic springs by {curved:?} ‰");
    for (straight, curved) in straight.iter().zip(&curved) {
        assert!(straight.abs() <= 3.0, "{straight} ‰");
        assert!((curved - straight).abs() <= 1.0, "{curved} ‰");
    }
    assert_ne!(straight, curved, "the springs are straight");
}
