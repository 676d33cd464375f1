//! What is hidden, where, how large, and the table that an experimenter would write of it.

use std::fs;
use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};

use super::world::{Beam, Gear, Hung, Real, Servo, Spring};
use crate::truth::arm::{Arm, BASE, Body, Kind, TIP};
use crate::truth::case::rms;
use crate::truth::dice::Dice;
use crate::truth::robots::{Family, arm, pose_of, row_at};
use crate::truth::world::Row;
use crate::truth::write::{self, Columns};

/// Every kind of case; those of [`CALM`] hide nothing.
pub(super) const KINDS: [&str; 23] = [
    "inertia",
    "base3",
    "base6",
    "bearing",
    "beam",
    "leaning",
    "slopes",
    "all",
    "warm_all",
    "servo_one",
    "servo_all",
    "friction",
    "mesh",
    "rigid",
    "payload_less",
    "payload_drift",
    "payload_unlike",
    "typo",
    "belt",
    "calm_drift",
    "calm_common",
    "calm_unlike",
    "hung",
];

/// Tables are rounded to this, Hz.
const STEP_HZ: f64 = 0.01;

/// A cause with the names of its place that are right.
#[derive(Debug, Clone)]
pub(super) struct Hidden {
    pub(super) cause: &'static str,
    pub(super) at: Vec<String>,
}

/// How a table is wrong beyond the effect.
#[derive(Debug, Clone, Default)]
struct Noise {
    /// Relative, by mode.
    of_mode: Vec<f64>,
    /// Of all modes of a pose together.
    common: f64,
    /// Change over the day.
    drift: f64,
    /// The drift is none at the first row, not on average.
    begins_right: bool,
}

/// One case.
#[derive(Debug, Clone)]
pub(super) struct Case {
    pub(super) name: String,
    pub(super) kind: &'static str,
    pub(super) hidden: Vec<Hidden>,
    pub(super) nominal: Arm,
    /// Joints that the file lists as rigid.
    rigid: Vec<usize>,
    pub(super) real: Real,
    pub(super) rows: Vec<Row>,
    pub(super) fresh: Vec<Row>,
    /// As the table's instrument would measure them, at some hour of its day.
    pub(super) fresh_measured_hz: Vec<Vec<Option<f64>>>,
    pub(super) modes: usize,
    measured_hz: Vec<Vec<Option<f64>>>,
    /// Row from 1 with a wrong angle, and the angles as written.
    pub(super) typo: Option<(usize, Vec<f64>)>,
    /// Root mean square of the relative error of the table.
    pub(super) noise: f64,
    columns: Columns,
}

/// Puts an effect of a size from 0 to 1 into an arm.
type Apply = Box<dyn Fn(&mut Real, f64)>;

/// What a kind hides on an arm.
struct Effect {
    hidden: Vec<Hidden>,
    rigid: Vec<usize>,
    apply: Apply,
}

impl Case {
    pub(super) fn draw(kind: &'static str, seed: u64) -> Option<Self> {
        (0..60).find_map(|attempt| Self::attempt(kind, seed, attempt))
    }

    fn attempt(kind: &'static str, seed: u64, attempt: u64) -> Option<Self> {
        let text = format!("{kind} {seed} {attempt}");
        let mixed = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        let mut dice = Dice::new(mixed);
        let dice = &mut dice;
        let place = KINDS.iter().position(|other| *other == kind)? as u64;
        let family = match (seed + place) % 4 {
            0 => Family::Planar { links: 3 },
            1 => Family::Planar { links: 2 },
            _ => Family::SixAxis,
        };
        let nominal = arm(family, dice);
        let count = dice.between(16, 30);
        let rows = rows(family, &nominal, count, dice);
        let fresh = fresh(family, &nominal, &rows, dice);
        let n = nominal.joints.len();
        let modes = if nominal.planar { n } else { dice.between(3, n) };
        // A joint that the file lists as rigid gives no mode.
        let modes = if kind == "rigid" { modes.min(n - 1) } else { modes };
        let level = dice.log_even(0.003, 0.008);
        let mut noise = Noise { of_mode: vec![level; modes], ..Noise::default() };
        match kind {
            "calm_drift" => {
                noise.drift = dice.even(0.01, 0.04) * dice.sign();
                noise.begins_right = dice.sign() > 0.0;
            }
            "payload_drift" => noise.drift = dice.even(0.008, 0.02) * dice.sign(),
            "calm_common" => noise.common = level * dice.even(1.0, 2.5),
            "calm_unlike" | "payload_unlike" => {
                noise.of_mode.iter_mut().for_each(|s| *s = level * dice.log_even(0.4, 4.0));
            }
            _ => {}
        }
        let effect = effect(kind, &nominal, (&rows, modes), dice)?;
        let mut told = nominal.clone();
        let plain = match effect.rigid.first() {
            None => Real::of(&nominal),
            Some(&joint) => {
                told.joints[joint].stiffness_nm_per_rad *= 1e5;
                Real::of(&told)
            }
        };
        let real = if effect.hidden.is_empty() {
            plain
        } else {
            sized(&effect, &plain, &rows, modes, dice.even(4.0, 10.0) * level)?
        };
        let measured_hz: Vec<Vec<Option<f64>>> = rows
            .iter()
            .enumerate()
            .map(|(i, row)| {
                let share = i as f64 / (count - 1) as f64;
                measure(&real, row, &noise, (modes, share), dice)
            })
            .collect();
        let errors: Vec<f64> = rows
            .iter()
            .zip(&measured_hz)
            .flat_map(|(row, measured)| {
                let seen = real.frequencies_hz(row, modes);
                let both = seen.into_iter().zip(measured.clone());
                both.filter_map(|(seen, f)| Some(f? / seen - 1.0)).collect::<Vec<_>>()
            })
            .collect();
        // Of dice of its own, so that the cases stay as they were.
        let mut later = Dice::new(mixed.rotate_left(32));
        let fresh_measured_hz = fresh.iter().map(|row| {
            let share = later.even(0.0, 1.0);
            measure(&real, row, &noise, (modes, share), &mut later)
        });
        let fresh_measured_hz = fresh_measured_hz.collect();
        let typo = (kind == "typo").then(|| {
            let row = dice.index(count);
            let mut joints = rows[row].joints_rad.clone();
            let joint = dice.between(1, n.min(3) - 1);
            let [from, to] = nominal.joints[joint].limits_rad;
            let middle = 0.5 * (from + to);
            joints[joint] += if joints[joint] > middle { -1.0 } else { 1.0 } * dice.even(0.6, 1.2);
            (row + 1, joints)
        });
        Some(Self {
            name: format!("{}-{kind}-{seed}", family.name()),
            kind,
            hidden: effect.hidden,
            nominal,
            rigid: effect.rigid,
            real,
            rows,
            fresh,
            fresh_measured_hz,
            modes,
            measured_hz,
            typo,
            noise: rms(&errors),
            columns: Columns {
                temperature: kind == "warm_all" || dice.chance(0.3),
                amplitude: kind == "friction" || dice.chance(0.3),
                deviations: std::env::var("DETUNE_STATED").is_ok().then_some(level),
                ..Columns::default()
            },
        })
    }

    /// Parameters of the hidden cause that have the same meaning in the engine's form of it, by name, if its
    /// finding has the parameters `named`.
    pub(super) fn parameters(&self, named: &[&str]) -> Vec<(&'static str, f64)> {
        const WAVES: [[&str; 2]; 3] = [["cos_1", "sin_1"], ["cos_2", "sin_2"], ["cos_3", "sin_3"]];
        let real = &self.real;
        let mass = |arm: &Arm| arm.payload.as_ref().map_or(0.0, |payload| payload.mass_kg);
        let spring = |i: usize| real.springs[i].stiffness;
        match self.kind {
            "rigid" => {
                let joint = &real.arm.joints[self.rigid[0]];
                vec![("stiffness_nm_per_rad", joint.stiffness_nm_per_rad)]
            }
            "servo_one" => {
                let servo = &real.servos[0];
                let gear = real.arm.joints[servo.joint].stiffness_nm_per_rad;
                let both = 1.0 / (1.0 / gear + 1.0 / servo.stiffness);
                vec![("stiffness_nm_per_rad", both)]
            }
            "payload_less" => vec![("mass_kg", mass(&real.arm) - mass(&self.nominal))],
            "payload_drift" | "payload_unlike" => {
                vec![("mass_kg", real.carried[0].1.mass_kg)]
            }
            "belt" => vec![("ratio", real.belts[0].1)],
            "hung" => vec![("frequency_hz", real.hung[0].frequency_hz)],
            // The law about a torque where it is not 1 has the factor for it.
            "leaning" if named.contains(&"factor") => match &real.gears[0].1 {
                Gear::Leaning { c, largest_nm } => vec![("change_per_nm", c / largest_nm)],
                _ => Vec::new(),
            },
            "mesh" => match &real.gears[0].1 {
                Gear::Mesh { waves } => waves
                    .iter()
                    .zip(WAVES)
                    .flat_map(|([a, phase], names)| {
                        [(names[0], a * phase.cos()), (names[1], -a * phase.sin())]
                    })
                    .collect(),
                _ => Vec::new(),
            },
            "base3" if named.contains(&"ratio_3") => vec![
                ("stiffness_nm_per_rad", spring(0)),
                ("ratio_2", spring(1) / spring(0)),
                ("ratio_3", spring(2) / spring(0)),
                ("depth_m", 0.0),
            ],
            "bearing" if named.contains(&"ratio_2") => {
                vec![("stiffness_nm_per_rad", spring(0)), ("ratio_2", spring(1) / spring(0))]
            }
            _ => Vec::new(),
        }
    }

    /// robot.yaml, robot.urdf, measured.csv; what is hidden, for whoever judges: hidden.json, fresh.csv, truth.txt.
    pub(super) fn write(&self, folder: &Path) {
        write::robot(&self.nominal, folder);
        let file = folder.join("robot.yaml");
        let text = fs::read_to_string(&file).unwrap();
        let is_rigid = |line: &str| {
            self.rigid.iter().any(|&joint| {
                line.starts_with(&format!("    {}: {{stiff", self.nominal.joints[joint].name))
            })
        };
        let lines: Vec<&str> = text.lines().filter(|line| !is_rigid(line)).collect();
        fs::write(&file, lines.join("\n") + "\n").unwrap();
        let mut rows = self.rows.clone();
        if let Some((row, joints)) = &self.typo {
            rows[row - 1].joints_rad.clone_from(joints);
        }
        let table = write::table(&self.nominal, &rows, &self.measured_hz, self.columns);
        fs::write(folder.join("measured.csv"), table).unwrap();
        let truth =
            format!("{:?}\n{:?}\nnoise {}\n{:#?}\n", self.hidden, self.typo, self.noise, self.real);
        fs::write(folder.join("truth.txt"), truth).unwrap();
        let seen =
            |row: &Row| self.real.frequencies_hz(row, self.modes).into_iter().map(Some).collect();
        let fresh: Vec<Vec<Option<f64>>> = self.fresh.iter().map(seen).collect();
        let fresh = write::table(&self.nominal, &self.fresh, &fresh, Columns::default());
        fs::write(folder.join("fresh.csv"), fresh).unwrap();
        let hidden: Vec<Value> = self
            .hidden
            .iter()
            .map(|hidden| json!({"cause": hidden.cause, "at": hidden.at}))
            .collect();
        let hidden = json!({"kind": self.kind, "hidden": hidden, "noise": self.noise});
        fs::write(folder.join("hidden.json"), hidden.to_string()).unwrap();
    }
}

/// A day of tests: the hall warms up, poses come at random.
fn rows(family: Family, arm: &Arm, count: usize, dice: &mut Dice) -> Vec<Row> {
    let (from, to) = (dice.even(14.0, 20.0), dice.even(26.0, 38.0));
    (0..count)
        .map(|i| {
            let mut row = row_at(pose_of(family, arm, dice));
            let drift = from + (to - from) * i as f64 / count as f64;
            row.temperature_c = ((drift + dice.normal()) * 10.0).round() / 10.0;
            row.amplitude_nm = (dice.log_even(4.0, 80.0) * 100.0).round() / 100.0;
            row
        })
        .collect()
}

/// Poses of a later day, under what was usual: the robot's file knows no other conditions.
fn fresh(family: Family, arm: &Arm, rows: &[Row], dice: &mut Dice) -> Vec<Row> {
    let middle = |of: &dyn Fn(&Row) -> f64| {
        let mut values: Vec<f64> = rows.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (temperature_c, amplitude_nm) = (middle(&|r| r.temperature_c), middle(&|r| r.amplitude_nm));
    (0..10)
        .map(|_| Row { temperature_c, amplitude_nm, ..row_at(pose_of(family, arm, dice)) })
        .collect()
}

fn measure(
    real: &Real,
    row: &Row,
    noise: &Noise,
    (modes, share): (usize, f64),
    dice: &mut Dice,
) -> Vec<Option<f64>> {
    let together = noise.common * dice.normal();
    // Fast in the morning, slow at night.
    let right = if noise.begins_right { 1.0 } else { 0.43 };
    let drift = noise.drift * ((-2.0 * share).exp() - right) / 0.86;
    let seen = real.frequencies_hz(row, modes);
    let mut hz: Vec<f64> = seen
        .iter()
        .zip(&noise.of_mode)
        .map(|(f, sigma)| f * (1.0 + sigma * dice.normal() + together + drift))
        .collect();
    hz.sort_by(f64::total_cmp);
    let cells = hz.iter().map(|f| Some((f / STEP_HZ).round() * STEP_HZ));
    cells.chain(std::iter::repeat(None)).take(modes).collect()
}

/// The size that moves the frequencies by `wanted`, root mean square.
fn sized(effect: &Effect, plain: &Real, rows: &[Row], modes: usize, wanted: f64) -> Option<Real> {
    let before: Vec<Vec<f64>> = rows.iter().map(|row| plain.frequencies_hz(row, modes)).collect();
    let at = |size: f64| {
        let mut real = plain.clone();
        (effect.apply)(&mut real, size);
        let moved: Vec<f64> = rows
            .iter()
            .zip(&before)
            .flat_map(|(row, before)| {
                let after = real.frequencies_hz(row, modes);
                before.iter().zip(after).map(|(b, a)| a / b - 1.0).collect::<Vec<_>>()
            })
            .collect();
        (rms(&moved), real)
    };
    if at(1.0).0 < wanted {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if at(middle).0 >= wanted { high = middle } else { low = middle }
    }
    Some(at(high).1)
}

fn effect(
    kind: &'static str,
    arm: &Arm,
    (rows, modes): (&[Row], usize),
    dice: &mut Dice,
) -> Option<Effect> {
    let n = arm.joints.len();
    let joint = dice.index(n.min(4));
    let link = joint + 1;
    let k = arm.joints[joint].stiffness_nm_per_rad;
    let one = |cause: &'static str, at: &str| vec![Hidden { cause, at: vec![at.to_owned()] }];
    let at_joint = arm.joints[joint].name.clone();
    let at_link = arm.joints[joint].link.clone();
    let (hidden, apply): (Vec<Hidden>, Apply) = match kind {
        "inertia" => (one("link_inertia", &at_link), inertia(link, dice)),
        "base3" | "base6" => (one("base_compliance", BASE), base(kind == "base6", arm, dice)),
        "bearing" => (one("transverse_compliance", &at_joint), bearing(arm, joint, dice)),
        "beam" => {
            if arm.reach(link).norm() < 0.35 {
                return None;
            }
            let stiffness = [2.0 * k, 2.0 * k * dice.log_even(0.4, 2.5), 4.0 * k];
            let beam = move |real: &mut Real, size: f64| {
                let stiffness = stiffness.map(|k| k / (10.0 * size));
                real.beams.push(Beam { link, segments: 4, stiffness });
            };
            (one("link_flexibility", &at_link), Box::new(beam))
        }
        "leaning" | "slopes" => {
            let largest_nm = varying_torque(arm, joint, rows)?;
            let leaning = kind == "leaning";
            (one("load_dependent_stiffness", &at_joint), loaded(joint, largest_nm, leaning, dice))
        }
        "all" => {
            let softer = dice.chance(0.7);
            let scatter: Vec<f64> = (0..n).map(|_| (0.02 * dice.normal()).exp()).collect();
            let all = move |real: &mut Real, size: f64| {
                let factor = if softer { 1.0 / (1.0 + size) } else { 1.0 + size };
                for (joint, scatter) in real.arm.joints.iter_mut().zip(&scatter) {
                    joint.stiffness_nm_per_rad *= factor * scatter;
                }
            };
            (one("joint_stiffness", "all"), Box::new(all))
        }
        "warm_all" => {
            let warm = move |real: &mut Real, size: f64| {
                for joint in 0..n {
                    real.gears.push((joint, Gear::Warms { per_k: 0.02 * size }));
                }
            };
            (one("temperature_drift", "all"), Box::new(warm))
        }
        // The rotor turns between gear and servo.
        "servo_one" | "servo_all" if arm.joints.iter().any(|j| j.drive_kgm2 > 0.0) => return None,
        "servo_one" => {
            let servo = move |real: &mut Real, size: f64| {
                real.servos.push(Servo { joint, stiffness: k / (3.0 * size), rotor_kgm2: 0.02 });
            };
            (one("joint_stiffness", &at_joint), Box::new(servo))
        }
        "servo_all" => {
            let unlike: Vec<f64> = (0..n).map(|_| dice.log_even(0.85, 1.2)).collect();
            let servos = move |real: &mut Real, size: f64| {
                for (joint, unlike) in unlike.iter().enumerate() {
                    let stiffness =
                        real.arm.joints[joint].stiffness_nm_per_rad * unlike / (3.0 * size);
                    real.servos.push(Servo { joint, stiffness, rotor_kgm2: 0.02 });
                }
            };
            (one("joint_stiffness", "all"), Box::new(servos))
        }
        "friction" => {
            let level_nm = dice.log_even(10.0, 60.0);
            let slips = move |real: &mut Real, size: f64| {
                real.gears.push((joint, Gear::Slips { least: 1.0 - 0.8 * size, level_nm }));
            };
            (one("amplitude_dependence", &at_joint), Box::new(slips))
        }
        "mesh" => {
            let count = dice.between(1, 3);
            let shape: Vec<[f64; 2]> = (0..count)
                .map(|_| [dice.even(0.3, 1.0), dice.even(0.0, std::f64::consts::TAU)])
                .collect();
            let mesh = move |real: &mut Real, size: f64| {
                let waves = shape.iter().map(|[a, phase]| [0.3 * size * a, *phase]).collect();
                real.gears.push((joint, Gear::Mesh { waves }));
            };
            (one("position_dependent_stiffness", &at_joint), Box::new(mesh))
        }
        "rigid" => {
            let rigid = move |real: &mut Real, size: f64| {
                real.arm.joints[joint].stiffness_nm_per_rad = k / size.max(1e-3);
            };
            let hidden = one("joint_stiffness", &at_joint);
            return Some(Effect { hidden, rigid: vec![joint], apply: Box::new(rigid) });
        }
        "payload_less" => {
            arm.payload.as_ref()?;
            let less = move |real: &mut Real, size: f64| {
                if let Some(payload) = &mut real.arm.payload {
                    payload.mass_kg *= 1.0 - 0.95 * size;
                    payload.inertia_kgm2 *= 1.0 - 0.95 * size;
                }
            };
            (payload_at(arm), Box::new(less))
        }
        "payload_drift" | "payload_unlike" => (payload_at(arm), payload(arm, dice)),
        "typo" => match dice.index(2) {
            0 => (payload_at(arm), payload(arm, dice)),
            _ => {
                let softer = move |real: &mut Real, size: f64| {
                    real.arm.joints[joint].stiffness_nm_per_rad /= 1.0 + 2.0 * size;
                };
                (one("joint_stiffness", &at_joint), Box::new(softer))
            }
        },
        "belt" => {
            let joint = joint.max(1);
            let sign = dice.sign();
            let belt = move |real: &mut Real, size: f64| real.belts.push((joint, sign * size));
            (one("joint_coupling", &arm.joints[joint].name), Box::new(belt))
        }
        "hung" => (hung_at(arm), hung(arm, (rows, modes), dice)),
        "calm_drift" | "calm_common" | "calm_unlike" => (Vec::new(), Box::new(|_, _| {})),
        other => panic!("no kind is called {other}"),
    };
    Some(Effect { hidden, rigid: Vec::new(), apply })
}

/// Where a part is that the arm does not feel cannot be told.
fn hung_at(arm: &Arm) -> Vec<Hidden> {
    let link = arm.joints[arm.joints.len() - 1].link.clone();
    vec![Hidden { cause: "local_mode", at: vec![TIP.to_owned(), link, String::new()] }]
}

/// Its frequency comes down among the arm's, from where it takes the last column at half of the poses.
fn hung(arm: &Arm, (rows, modes): (&[Row], usize), dice: &mut Dice) -> Apply {
    let real = Real::of(arm);
    let mut last_hz: Vec<f64> =
        rows.iter().map(|row| real.frequencies_hz(row, modes)[modes - 1]).collect();
    last_hz.sort_by(f64::total_cmp);
    let highest_hz = last_hz[last_hz.len() / 2];
    let mass_kg = dice.log_even(0.02, 4.0);
    let axis = [Vector3::x(), Vector3::y(), Vector3::z()][dice.index(3)];
    Box::new(move |real, size| {
        let frequency_hz = highest_hz * (-2.0 * size).exp();
        real.hung.push(Hung { mass_kg, frequency_hz, axis });
    })
}

fn payload_at(arm: &Arm) -> Vec<Hidden> {
    let link = arm.joints[arm.joints.len() - 1].link.clone();
    vec![Hidden { cause: "payload", at: vec![TIP.to_owned(), link] }]
}

fn payload(arm: &Arm, dice: &mut Dice) -> Apply {
    let (link, tip_m) = (arm.joints.len(), arm.tip_m);
    let aside = Vector3::new(dice.even(0.0, 0.12), 0.0, dice.even(-0.05, 0.05));
    let edges = Vector3::new(dice.even(0.1, 0.3), 0.1, 0.15);
    Box::new(move |real, size| {
        let body = Body::block(40.0 * size, tip_m + aside, edges, Matrix3::identity());
        real.carried.push((link, body));
    })
}

/// Principal moments by unlike factors, as far as a body can have them.
fn inertia(link: usize, dice: &mut Dice) -> Apply {
    let first = dice.index(3);
    let shrinks = dice.chance(0.5);
    let logs: Vec<f64> = (0..3)
        .map(|axis| if axis == first && shrinks { -1.9 } else { dice.even(0.7, 1.6) })
        .collect();
    Box::new(move |real, size| {
        let body = &mut real.arm.joints[link - 1].body;
        let principal = body.inertia_kgm2.symmetric_eigen();
        let mut moments =
            Vector3::from_fn(|i, _| principal.eigenvalues[i] * (size * logs[i]).exp());
        for i in 0..3 {
            moments[i] = moments[i].min(0.98 * (moments.sum() - moments[i]));
        }
        let axes = principal.eigenvectors;
        body.inertia_kgm2 = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    })
}

fn base(six: bool, arm: &Arm, dice: &mut Dice) -> Apply {
    let k = 2.0 * arm.joints[0].stiffness_nm_per_rad;
    let unlike: Vec<f64> = (0..6).map(|_| dice.log_even(0.4, 2.5)).collect();
    let depth = if six { dice.even(0.0, 0.5) } else { 0.0 };
    Box::new(move |real, size| {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let mut give = |kind, axis: usize, stiffness| {
            real.springs.push(Spring {
                link: 0,
                kind,
                axis: axes[axis],
                origin_m: Vector3::new(0.0, 0.0, -depth),
                stiffness,
            });
        };
        let (turns, shifts) = unlike.split_at(3);
        for (axis, unlike) in turns.iter().enumerate() {
            let stands = if axis == 2 { 3.0 } else { 1.0 };
            give(Kind::Rotation, axis, stands * k * unlike / (10.0 * size));
        }
        for (axis, unlike) in shifts.iter().enumerate().filter(|_| six) {
            give(Kind::Translation, axis, 4.0 * k * unlike / (10.0 * size));
        }
    })
}

fn bearing(arm: &Arm, joint: usize, dice: &mut Dice) -> Apply {
    let own = &arm.joints[joint];
    let k = 3.0 * own.stiffness_nm_per_rad;
    let all = [Vector3::x(), Vector3::y(), Vector3::z()];
    let across: Vec<Vector3<f64>> =
        all.into_iter().filter(|axis| axis.dot(&own.axis).abs() < 0.5).collect();
    let unlike = [1.0, dice.log_even(0.2, 5.0)];
    Box::new(move |real, size| {
        for (axis, unlike) in across.iter().zip(unlike) {
            real.springs.push(Spring {
                link: joint + 1,
                kind: Kind::Rotation,
                axis: *axis,
                origin_m: Vector3::zeros(),
                stiffness: k * unlike / (10.0 * size),
            });
        }
    })
}

fn varying_torque(arm: &Arm, joint: usize, rows: &[Row]) -> Option<f64> {
    let real = Real::of(arm);
    let torques: Vec<f64> =
        rows.iter().map(|row| real.gravity_torque_nm(joint, row).abs()).collect();
    let most = torques.iter().fold(0.0_f64, |m, t| m.max(*t));
    let least = torques.iter().fold(f64::INFINITY, |m, t| m.min(*t));
    (most > 20.0 && least < 0.5 * most).then_some(most)
}

fn loaded(joint: usize, largest_nm: f64, leaning: bool, dice: &mut Dice) -> Apply {
    if leaning {
        let sign = dice.sign();
        return Box::new(move |real, size| {
            real.gears.push((joint, Gear::Leaning { c: 1.4 * sign * size, largest_nm }));
        });
    }
    let torques_nm = [largest_nm * dice.even(0.15, 0.35), largest_nm * dice.even(0.5, 0.7)];
    let top = dice.even(0.6, 1.2);
    let swing_nm = 0.05 * largest_nm;
    Box::new(move |real, size| {
        let shares = [1.0 / (1.0 + 1.8 * size), 1.0, 1.0 + top * size];
        real.gears.push((joint, Gear::Slopes { torques_nm, shares, swing_nm }));
    })
}
