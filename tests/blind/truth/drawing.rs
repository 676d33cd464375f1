//! Where an effect may sit, and which one is drawn.

use nalgebra::Vector3;

use super::arm::{Arm, BASE, Kind, TIP};
use super::dice::Dice;
use super::effects::{Change, Compliance, Effect, LoadLaw};
use super::world::{Row, World, waves_at};

/// Draws an effect of a cause on an arm; `None` where the arm has no place for it. Whether it shows enough is for
/// the caller to find out.
pub(crate) fn effect(
    cause: &'static str,
    arm: &Arm,
    rows: &[Row],
    modes: usize,
    dice: &mut Dice,
) -> Option<Effect> {
    let n = arm.joints.len();
    let joint = dice.index(n);
    let link = joint + 1;
    let link_at = || vec![arm.link_name(link).to_owned()];
    let joint_at = || vec![arm.joints[joint].name.clone()];
    let mode_at = |mode: usize| vec![format!("{}", mode + 1)];
    let typical = arm.joints[joint].stiffness_nm_per_rad;
    // What follows a joint that stands still is a constant, which the vocabulary has a name for.
    let stands_still = rows.iter().all(|row| row.joints_rad[joint] == rows[0].joints_rad[joint]);
    if stands_still && ["position_dependent_stiffness", "hysteresis"].contains(&cause) {
        return None;
    }
    let (at, change) = match cause {
        "joint_stiffness" => {
            (joint_at(), Change::JointStiffness { joint, softer: dice.chance(0.6) })
        }
        "link_inertia" => {
            let larger = dice.chance(0.7);
            let with_mass = dice.chance(0.3);
            (link_at(), Change::LinkInertia { link, larger, with_mass })
        }
        "com_offset" => (link_at(), com_offset(arm, link, dice)),
        "joint_zero_offset" => (joint_at(), Change::ZeroOffset { joint, sign: dice.sign() }),
        "payload" => payload(arm, dice),
        "base_compliance" => (vec![BASE.to_owned()], base(arm, dice)),
        "transverse_compliance" => (
            joint_at(),
            Change::Compliance {
                what: Compliance::Transverse,
                link,
                kind: Kind::Rotation,
                axis: across(&arm.joints[joint].axis, dice),
                origin_m: Vector3::zeros(),
                stiff: 4.0 * typical,
            },
        ),
        "link_flexibility" => (link_at(), flexibility(arm, link, dice)?),
        "drive_inertia" => (joint_at(), drive(arm, joint, &rows[0])),
        "load_dependent_stiffness" => (joint_at(), load(arm, joint, rows, dice)?),
        "amplitude_dependence" => (joint_at(), amplitude(joint, rows, dice)),
        "temperature_drift" => (joint_at(), Change::Temperature { joint }),
        "gravity_stiffness" => (vec![String::new()], Change::Gravity),
        "aliased_mode" => {
            let mode = modes - 1;
            (mode_at(mode), aliased(arm, rows, mode, dice)?)
        }
        "missed_mode" => {
            let mode = dice.index(modes);
            (mode_at(mode), Change::Missed { mode })
        }
        "position_dependent_stiffness" => {
            (joint_at(), Change::Wave { joint, phase_rad: dice.even(0.0, std::f64::consts::TAU) })
        }
        "absorber" => {
            let mode = dice.index(modes);
            let row = &rows[dice.index(rows.len())];
            let frequency_hz = World::of(arm).frequencies_hz(row, modes)[mode];
            (mode_at(mode), Change::Absorber { mode, frequency_hz })
        }
        "scatter" => (vec![String::new()], Change::Scatter),
        "jump" => (joint_at(), Change::Jump { joint, sign: dice.sign() }),
        "smooth" => (vec![String::new()], smooth(n, rows, modes, dice)),
        "hysteresis" => (joint_at(), Change::Hysteresis { joint }),
        other => panic!("no effect is called {other}"),
    };
    Some(Effect { cause, at, change })
}

fn com_offset(arm: &Arm, link: usize, dice: &mut Dice) -> Change {
    if dice.chance(0.4) {
        return Change::ComTurn { link, sign: dice.sign() };
    }
    let axes: &[Vector3<f64>] = if arm.planar {
        &[Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 0.0, 1.0)]
    } else {
        &[Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)]
    };
    // Along the link more often than across.
    let along = arm.reach(link).normalize();
    let direction = if dice.chance(0.5) { along } else { dice.pick(axes) };
    Change::ComShift { link, direction: direction * dice.sign() }
}

/// At the tool, or on a link (a valve block, a cable drum).
fn payload(arm: &Arm, dice: &mut Dice) -> (Vec<String>, Change) {
    let n = arm.joints.len();
    let aside = if dice.chance(0.5) { dice.even(0.0, 0.15) } else { 0.0 };
    if dice.chance(0.7) {
        let com_m = arm.tip_m + Vector3::new(aside, 0.0, 0.0);
        let at = vec![TIP.to_owned(), arm.link_name(n).to_owned()];
        let gyration_m = if dice.chance(0.3) { dice.even(0.03, 0.08) } else { 0.0 };
        return (at, Change::Payload { link: n, com_m, gyration_m, tool: true });
    }
    let link = dice.between(1, n);
    let mut at = vec![arm.link_name(link).to_owned()];
    if link == n {
        at.push(TIP.to_owned());
    }
    let com_m = arm.reach(link) * dice.even(0.3, 1.0);
    (at, Change::Payload { link, com_m, gyration_m: 0.0, tool: false })
}

fn base(arm: &Arm, dice: &mut Dice) -> Change {
    let kind = if dice.chance(0.7) { Kind::Rotation } else { Kind::Translation };
    let axis = match (arm.planar, kind) {
        (true, Kind::Rotation) => Vector3::y(),
        (true, Kind::Translation) => dice.pick(&[Vector3::x(), Vector3::z()]),
        (false, _) => dice.pick(&[Vector3::x(), Vector3::y(), Vector3::z()]),
    };
    let below = if dice.chance(0.5) { dice.even(-0.5, -0.1) } else { 0.0 };
    let stiff = arm.joints[0].stiffness_nm_per_rad * 4.0;
    Change::Compliance {
        what: Compliance::Base,
        link: 0,
        kind,
        axis,
        origin_m: Vector3::new(0.0, 0.0, if kind == Kind::Rotation { below } else { 0.0 }),
        stiff,
    }
}

/// A unit vector of the frame across an axis.
fn across(axis: &Vector3<f64>, dice: &mut Dice) -> Vector3<f64> {
    let all = [Vector3::x(), Vector3::y(), Vector3::z()];
    let fit: Vec<_> = all.into_iter().filter(|v| v.dot(axis).abs() < 0.5).collect();
    dice.pick(&fit)
}

/// Half of the time the whole link bends about a point inside it, half of the time its outer part.
fn flexibility(arm: &Arm, link: usize, dice: &mut Dice) -> Option<Change> {
    let reach = arm.reach(link);
    if reach.norm() < 0.2 {
        return None;
    }
    let axis = if arm.planar { Vector3::y() } else { across(&reach.normalize(), dice) };
    let stiff = 4.0 * arm.joints[link - 1].stiffness_nm_per_rad;
    let fraction = dice.even(0.3, 0.6);
    Some(if dice.chance(0.5) {
        let (what, kind, origin_m) = (Compliance::Link, Kind::Rotation, reach * fraction);
        Change::Compliance { what, link, kind, axis, origin_m, stiff }
    } else {
        Change::Bend { link, fraction, axis, stiff }
    })
}

fn drive(arm: &Arm, joint: usize, row: &Row) -> Change {
    let (mass, _, _) = World::of(arm).matrices(row);
    let c: usize = (0..joint).map(|i| 1 + extras(arm, i)).sum::<usize>() + extras(arm, joint);
    Change::Drive { joint, unit_kgm2: mass[(c, c)] }
}

/// Extra coordinates of link i.
fn extras(arm: &Arm, link: usize) -> usize {
    arm.extras.iter().filter(|extra| extra.link == link).count()
}

/// Only where the load changes from pose to pose.
fn load(arm: &Arm, joint: usize, rows: &[Row], dice: &mut Dice) -> Option<Change> {
    let world = World::of(arm);
    let torques: Vec<f64> =
        rows.iter().map(|row| world.gravity_torque_nm(joint, row).abs()).collect();
    let most = torques.iter().fold(0.0_f64, |m, t| m.max(*t));
    let least = torques.iter().fold(f64::INFINITY, |m, t| m.min(*t));
    if most < 20.0 || least > 0.5 * most {
        return None;
    }
    let law = dice.pick(&[LoadLaw::Stiffens, LoadLaw::Softens, LoadLaw::Saturates]);
    Some(Change::Load { joint, law, reference_nm: most })
}

fn amplitude(joint: usize, rows: &[Row], dice: &mut Dice) -> Change {
    let most = rows.iter().fold(0.0_f64, |m, row| m.max(row.amplitude_nm));
    let least = rows.iter().fold(f64::INFINITY, |m, row| m.min(row.amplitude_nm));
    let power = dice.chance(0.4);
    Change::Amplitude { joint, power, reference_nm: if power { least } else { most } }
}

/// A rate that folds the last mode at some poses and leaves the order of the modes, as an experimenter sorts them.
fn aliased(arm: &Arm, rows: &[Row], mode: usize, dice: &mut Dice) -> Option<Change> {
    let world = World::of(arm);
    let all: Vec<Vec<f64>> = rows.iter().map(|row| world.frequencies_hz(row, mode + 1)).collect();
    let mut top: Vec<f64> = all.iter().map(|f| f[mode]).collect();
    top.sort_by(f64::total_cmp);
    let half = top[dice.index(top.len() * 7 / 10)] * dice.even(0.97, 1.0);
    let rate = (2.0 * half).round();
    let folded = all.iter().filter(|f| f[mode] > 1.04 * 0.5 * rate).count();
    let ordered = all.iter().all(|f| {
        let seen = if f[mode] > 0.5 * rate { rate - f[mode] } else { f[mode] };
        mode == 0 && seen > 1.0 || mode > 0 && seen > 1.05 * f[mode - 1]
    });
    (ordered && 4 * folded >= all.len()).then_some(Change::Aliased { mode, sample_rate_hz: rate })
}

/// Three waves for each mode, of no mean over the poses.
fn smooth(joints: usize, rows: &[Row], modes: usize, dice: &mut Dice) -> Change {
    let mut waves = Vec::new();
    for _ in 0..=modes {
        let wave = |dice: &mut Dice| {
            let w = (0..joints).map(|_| dice.even(-2.0, 2.0)).collect();
            (w, dice.even(0.0, std::f64::consts::TAU))
        };
        waves.push((0..3).map(|_| wave(dice)).collect::<Vec<_>>());
    }
    let count = rows.len() as f64;
    let mean = |waves: &Vec<(Vec<f64>, f64)>| {
        rows.iter().map(|row| waves_at(waves, &row.joints_rad)).sum::<f64>() / count
    };
    let means = waves.iter().map(mean).collect();
    Change::Smooth { waves, means }
}
