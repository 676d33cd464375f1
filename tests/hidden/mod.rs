//! Arms drawn at random, with effects hidden in their frequencies.

#![allow(dead_code, reason = "each test uses its part")]

use detune::diagnosis::Verdict;
use detune::measured::{ModeRow, ModeTable};
use detune::model::{
    CoordinateKind, Description, Drive, ElasticJoint, ExtraCoordinate, Inertial, Joint, JointKind,
    Link, Placement, Robot, potential_gradient,
};
use detune::modes::ModalSolver;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) const EFFECTS: &[&str] = &[
    "nothing",
    "joint_stiffness",
    "link_inertia",
    "link_mass",
    "com_offset",
    "joint_zero_offset",
    "payload",
    "payload_off_flange",
    "base_compliance",
    "transverse_compliance",
    "link_flexibility",
    "drive_inertia",
    "load_dependent_stiffness",
    "amplitude_dependence",
    "temperature_drift",
    "gravity_stiffness",
    "aliased_mode",
    "missed_mode",
    "unknown_mode_bias",
    "unknown_joint_wave",
    "unknown_pose_scatter",
    "unknown_spring_wave",
    "unknown_absorber",
    "two",
    "three",
];

#[derive(Debug, Clone)]
pub(crate) struct Truth {
    pub(crate) cause: String,
    pub(crate) at: String,
    pub(crate) parameter: Option<(String, f64)>,
}

#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) seed: u64,
    pub(crate) arm: &'static str,
    pub(crate) label: String,
    pub(crate) description: Description,
    pub(crate) table: ModeTable,
    pub(crate) truths: Vec<Truth>,
    pub(crate) noise: f64,
    pub(crate) effect_over_noise: f64,
}

impl Case {
    pub(crate) fn verdict(&self) -> Verdict {
        if self.label == "nothing" { Verdict::Consistent } else { Verdict::Unexplained }
    }
}

/// What depends on the row.
#[derive(Debug, Clone)]
enum RowLaw {
    Load { joint: String, c: f64, free: bool },
    Amplitude { joint: String, c: f64 },
    Temperature { joint: String, c: f64 },
    Wave { joint: String, over: usize, a: f64 },
    ModeBias { factors: Vec<f64> },
    JointWave { over: usize, a: f64, k: f64 },
    Scatter { a: f64 },
    Absorber { hz: f64, share: f64 },
    Alias { mode: usize, rate: f64 },
    Missed { mode: usize, share: f64 },
}

fn link(name: &str, inertial: Option<(f64, Vector3<f64>, Vector3<f64>)>) -> Link {
    Link {
        name: name.into(),
        inertial: inertial.map(|(mass_kg, com_m, diagonal)| Inertial {
            mass_kg,
            com_m,
            inertia_kgm2: Matrix3::from_diagonal(&diagonal),
        }),
        has_geometry: false,
    }
}

fn joint(
    name: &str,
    parent: &str,
    child: &str,
    xyz: Vector3<f64>,
    axis: Vector3<f64>,
    limit: f64,
) -> Joint {
    Joint {
        name: name.into(),
        kind: JointKind::Revolute,
        parent: parent.into(),
        child: child.into(),
        origin: Isometry3::translation(xyz.x, xyz.y, xyz.z),
        axis,
        position_limit: Some([-limit, limit]),
        velocity_limit: Some(2.0),
        mimics: None,
    }
}

fn fixed(name: &str, parent: &str, child: &str, xyz: Vector3<f64>) -> Joint {
    Joint {
        kind: JointKind::Fixed,
        position_limit: None,
        ..joint(name, parent, child, xyz, Vector3::x(), 1.0)
    }
}

fn around(rng: &mut ChaCha8Rng, value: f64, factor: f64) -> f64 {
    value * factor.powf(rng.random_range(-1.0..1.0))
}

fn empty(name: &str) -> Description {
    Description {
        name: name.into(),
        links: vec![],
        joints: vec![],
        base: None,
        tip: Some("tool0".into()),
        elastic_joints: vec![],
        extra: vec![],
        default_damping_ratio: 0.02,
        gravity_m_per_s2: Vector3::new(0.0, 0.0, -9.80665),
        gravity_stiffness: false,
        drives: vec![],
        payload: None,
        beta1: None,
        beta2: None,
        calibration: None,
        corrections: vec![],
    }
}

fn planar(rng: &mut ChaCha8Rng) -> Description {
    let n = rng.random_range(2..=3);
    let mut d = empty("planar");
    d.links.push(link(
        "base_link",
        Some((
            around(rng, 80.0, 1.5),
            Vector3::new(0.0, 0.0, 0.2),
            Vector3::repeat(around(rng, 4.0, 2.0)),
        )),
    ));
    let mut at = "base_link".to_owned();
    let mut length = Vector3::new(0.0, 0.0, around(rng, 0.4, 1.5));
    for i in 1..=n {
        let l = around(rng, 0.65, 1.4) * 0.8_f64.powi(i - 1);
        let m = around(rng, 30.0, 1.6) * 0.6_f64.powi(i - 1);
        let name = format!("link_{i}");
        let across = m * l * l * rng.random_range(0.06..0.14);
        d.links.push(link(
            &name,
            Some((
                m,
                Vector3::new(l * rng.random_range(0.25..0.6), 0.0, 0.0),
                Vector3::new(0.15 * across, across, across),
            )),
        ));
        d.joints.push(joint(&format!("joint_{i}"), &at, &name, length, -Vector3::y(), 2.6));
        d.elastic_joints.push(ElasticJoint {
            joint: format!("joint_{i}"),
            stiffness: around(rng, 5e5, 1.7) * 0.4_f64.powi(i - 1),
            is_linear: false,
            damping: None,
        });
        at = name;
        length = Vector3::new(l, 0.0, 0.0);
    }
    d.links.push(link("tool0", None));
    d.joints.push(fixed("flange", &at, "tool0", length));
    d
}

fn six(rng: &mut ChaCha8Rng) -> Description {
    let mut d = empty("six axes");
    let s = around(rng, 1.0, 1.4);
    d.links.push(link(
        "base_link",
        Some((100.0 * s, Vector3::new(0.0, 0.0, 0.1), Vector3::repeat(4.0 * s))),
    ));
    let masses = [70.0, 30.0, 34.0, 9.0, 4.0, 1.5];
    let coms = [
        [0.05, 0.01, 0.33],
        [0.0, -0.05, 0.33],
        [0.05, 0.01, 0.03],
        [0.12, 0.0, 0.01],
        [0.02, 0.0, 0.0],
        [0.02, 0.003, 0.0],
    ];
    let radii = [
        [0.18, 0.2, 0.17],
        [0.25, 0.24, 0.11],
        [0.1, 0.12, 0.12],
        [0.07, 0.12, 0.12],
        [0.05, 0.06, 0.06],
        [0.035, 0.03, 0.03],
    ];
    let origins = [
        [0.0, 0.0, 0.0],
        [0.15, 0.0, 0.4865],
        [0.0, 0.0, 0.7],
        [0.3, 0.0, 0.0],
        [0.3, 0.0, 0.0],
        [0.09, 0.0, 0.0],
    ];
    let axes = [Vector3::z(), Vector3::y(), Vector3::y(), Vector3::x(), Vector3::y(), Vector3::x()];
    let springs = [8e5, 6e5, 2.5e5, 6e4, 5e4, 2e4];
    let mut at = "base_link".to_owned();
    for i in 0..6 {
        let m = around(rng, masses[i] * s, 1.4);
        let name = format!("link_{}", i + 1);
        let com = Vector3::from(coms[i]) * around(rng, 1.0, 1.3);
        let diagonal = Vector3::from(radii[i]).map(|r| m * r * r) * around(rng, 1.0, 1.3);
        d.links.push(link(&name, Some((m, com, diagonal))));
        d.joints.push(joint(
            &format!("joint_{}", i + 1),
            &at,
            &name,
            Vector3::from(origins[i]) * around(rng, 1.0, 1.15),
            axes[i],
            if i == 1 { 1.6 } else { 2.5 },
        ));
        d.elastic_joints.push(ElasticJoint {
            joint: format!("joint_{}", i + 1),
            stiffness: around(rng, springs[i], 1.6),
            is_linear: false,
            damping: None,
        });
        at = name;
    }
    d.links.push(link("tool0", None));
    d.joints.push(fixed("flange", &at, "tool0", Vector3::new(0.02, 0.0, 0.0)));
    d
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (a, b): (f64, f64) = (rng.random_range(1e-12..1.0), rng.random_range(0.0..1.0));
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

fn pick<'a, T>(rng: &mut ChaCha8Rng, of: &'a [T]) -> &'a T {
    &of[rng.random_range(0..of.len())]
}

fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 1.0 } else { -1.0 }
}

struct Hidden {
    truth: Description,
    laws: Vec<RowLaw>,
    truths: Vec<Truth>,
}

fn hide(
    effect: &str,
    d: &Description,
    rng: &mut ChaCha8Rng,
    strength: f64,
    hidden: &mut Hidden,
    fmax: &[f64],
    poses: &[Vec<f64>],
) -> Option<()> {
    let joints: Vec<String> = d.elastic_joints.iter().map(|s| s.joint.clone()).collect();
    let links: Vec<String> = (1..=joints.len()).map(|i| format!("link_{i}")).collect();
    let planar = d.name == "planar";
    let t = &mut hidden.truth;
    let told = &mut hidden.truths;
    let mut tell = |cause: &str, at: &str, parameter: Option<(&str, f64)>| {
        told.push(Truth {
            cause: cause.into(),
            at: at.into(),
            parameter: parameter.map(|(n, v)| (n.to_owned(), v)),
        });
    };
    match effect {
        "nothing" => {}
        "joint_stiffness" => {
            let j = pick(rng, &joints).clone();
            let s = t.elastic_joints.iter_mut().find(|s| s.joint == j)?;
            s.stiffness *= (sign(rng) * strength).exp();
            let k = s.stiffness;
            tell(effect, &j, Some(("stiffness_nm_per_rad", k)));
        }
        "link_inertia" => {
            let l = pick(rng, &links).clone();
            let f = (sign(rng) * 1.5 * strength).exp();
            t.links.iter_mut().find(|x| x.name == l)?.inertial.as_mut()?.inertia_kgm2 *= f;
            tell(effect, &l, Some(("inertia_factor", f)));
        }
        "link_mass" => {
            let l = pick(rng, &links).clone();
            let f = (sign(rng) * strength).exp();
            let i = t.links.iter_mut().find(|x| x.name == l)?.inertial.as_mut()?;
            i.inertia_kgm2 *= f;
            i.mass_kg *= f;
            tell("link_inertia", &l, Some(("mass_factor", f)));
        }
        "com_offset" => {
            let l = pick(rng, &links).clone();
            let i = t.links.iter_mut().find(|x| x.name == l)?.inertial.as_mut()?;
            let size = 0.15 * strength;
            if rng.random_bool(0.5) {
                // Along the line from the joint to the centre.
                let by = i.com_m.normalize() * size * sign(rng);
                i.com_m += by;
            } else {
                let axis =
                    if planar { Vector3::y() } else { Vector3::new(0.3, 1.0, -0.2).normalize() };
                i.com_m = Rotation3::from_scaled_axis(axis * sign(rng) * 2.0 * strength) * i.com_m;
            }
            tell(effect, &l, None);
        }
        "joint_zero_offset" => {
            let j = pick(rng, &joints[1..]).clone();
            let by = sign(rng) * 0.3 * strength;
            let joint = t.joints.iter_mut().find(|x| x.name == j)?;
            joint.origin *= Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_scaled_axis(joint.axis * by),
            );
            tell(effect, &j, Some(("offset_rad", by)));
        }
        "payload" | "payload_off_flange" => {
            let m = 10.0 * strength;
            let com_m = if effect == "payload" {
                Vector3::zeros()
            } else {
                Vector3::new(0.12, 0.03, -0.05) * rng.random_range(0.3..1.3)
            };
            let inertia = if effect == "payload" { 0.0 } else { 0.002 * m };
            t.payload = Some(detune::model::Payload {
                link: "tool0".into(),
                inertial: Inertial {
                    mass_kg: m,
                    com_m,
                    inertia_kgm2: Matrix3::from_diagonal_element(inertia),
                },
            });
            tell("payload", "tool0", Some(("mass_kg", m)));
        }
        "base_compliance" => {
            let axis =
                if planar { Vector3::y() } else { *pick(rng, &[Vector3::x(), Vector3::y()]) };
            let k = 2e6 / strength;
            t.extra.push(ExtraCoordinate {
                name: "base".into(),
                link: "base_link".into(),
                kind: CoordinateKind::Rotation,
                axis,
                origin_m: Vector3::zeros(),
                stiffness: k,
                damping: None,
            });
            tell(effect, "base_link", Some(("stiffness_nm_per_rad", k)));
        }
        "transverse_compliance" => {
            if planar {
                return None;
            }
            let i = rng.random_range(0..4);
            let j = &d.joints[i];
            let axis = *pick(
                rng,
                &[Vector3::x(), Vector3::y(), Vector3::z()]
                    .into_iter()
                    .filter(|a| a.dot(&j.axis).abs() < 0.5)
                    .collect::<Vec<_>>(),
            );
            let k = 2.0 * d.elastic_joints[i].stiffness / strength;
            t.extra.push(ExtraCoordinate {
                name: "across".into(),
                link: j.child.clone(),
                kind: CoordinateKind::Rotation,
                axis,
                origin_m: Vector3::zeros(),
                stiffness: k,
                damping: None,
            });
            tell(effect, &joints[i], Some(("stiffness_nm_per_rad", k)));
        }
        "link_flexibility" => {
            let i =
                if planar { rng.random_range(0..joints.len() - 1) } else { *pick(rng, &[1, 2]) };
            let next = d.joints[i + 1].origin.translation.vector;
            let k = d.elastic_joints[i].stiffness / strength;
            t.extra.push(ExtraCoordinate {
                name: "bend".into(),
                link: links[i].clone(),
                kind: CoordinateKind::Rotation,
                axis: Vector3::y(),
                origin_m: 0.5 * next,
                stiffness: k,
                damping: None,
            });
            tell(effect, &links[i], Some(("stiffness_nm_per_rad", k)));
        }
        "drive_inertia" => {
            let j = pick(rng, &joints).clone();
            let i = joints.iter().position(|x| *x == j)?;
            let typical = [8.0, 8.0, 3.0, 0.3, 0.2, 0.03][if planar { 1 + i } else { i }];
            let v = typical * strength;
            t.drives.push(Drive { joint: j.clone(), reflected_inertia_kgm2: v });
            tell(effect, &j, Some(("reflected_inertia_kgm2", v)));
        }
        "load_dependent_stiffness" => {
            let j =
                if planar { pick(rng, &joints).clone() } else { pick(rng, &joints[1..5]).clone() };
            hidden.laws.push(RowLaw::Load {
                joint: j.clone(),
                c: sign(rng) * strength.min(0.8),
                free: rng.random_bool(0.3),
            });
            tell(effect, &j, None);
        }
        "amplitude_dependence" => {
            let j = pick(rng, &joints).clone();
            hidden.laws.push(RowLaw::Amplitude { joint: j.clone(), c: -strength.min(0.8) });
            tell(effect, &j, None);
        }
        "temperature_drift" => {
            let j = pick(rng, &joints).clone();
            hidden.laws.push(RowLaw::Temperature { joint: j.clone(), c: -strength.min(0.8) });
            tell(effect, &j, None);
        }
        "gravity_stiffness" => {
            t.gravity_stiffness = true;
            tell(effect, "", None);
        }
        "aliased_mode" => {
            let mode = fmax.len() - 1;
            let rate = fmax[mode] * 2.0 * rng.random_range(0.62..0.9);
            hidden.laws.push(RowLaw::Alias { mode, rate });
            tell(effect, &format!("{}", mode + 1), None);
        }
        "missed_mode" => {
            let mode = rng.random_range(0..fmax.len() - 1);
            hidden.laws.push(RowLaw::Missed { mode, share: rng.random_range(0.15..0.5) });
            tell(effect, &format!("{}", mode + 1), None);
        }
        "unknown_mode_bias" => {
            let mut factors = vec![1.0; fmax.len()];
            let mode = rng.random_range(0..fmax.len());
            factors[mode] = 1.0 + 0.3 * strength * sign(rng);
            hidden.laws.push(RowLaw::ModeBias { factors });
        }
        "unknown_joint_wave" => hidden.laws.push(RowLaw::JointWave {
            over: rng.random_range(0..joints.len()),
            a: 0.15 * strength,
            k: *pick(rng, &[1.0, 2.0, 3.0]),
        }),
        "unknown_pose_scatter" => hidden.laws.push(RowLaw::Scatter { a: 0.15 * strength }),
        "unknown_spring_wave" => hidden.laws.push(RowLaw::Wave {
            joint: pick(rng, &joints).clone(),
            over: rng.random_range(0..joints.len()),
            a: strength.min(0.8),
        }),
        "unknown_absorber" => {
            let mode = rng.random_range(0..fmax.len());
            hidden.laws.push(RowLaw::Absorber {
                hz: fmax[mode] * rng.random_range(0.75..0.95),
                share: 0.4 * strength,
            });
        }
        _ => panic!("{effect}"),
    }
    let _ = poses;
    Some(())
}

/// Frequencies of one row.
fn frequencies(
    d: &Description,
    laws: &[RowLaw],
    q: &[f64],
    covariates: [f64; 2],
    scatter: f64,
    torque_scale: &[f64],
) -> Option<Vec<f64>> {
    let mut d = d.clone();
    let plain = Robot::new(&d).ok()?;
    let mut placement = Placement::new(&plain);
    placement.place(&plain, q);
    let mut gradient = vec![0.0; plain.coordinates().len()];
    potential_gradient(&plain, &placement, &mut gradient);
    for law in laws {
        let (joint, factor) = match law {
            RowLaw::Load { joint, c, free } => {
                let i = plain.coordinates().iter().position(|x| x.name == *joint)?;
                let share = gradient[i].abs() / torque_scale[i].max(1e-9);
                (joint, if *free { 1.0 / (1.0 - 0.5 * c * share) } else { 1.0 + c * share })
            }
            RowLaw::Amplitude { joint, c } => (joint, 1.0 + c * covariates[1] / 60.0),
            RowLaw::Temperature { joint, c } => (joint, 1.0 + c * (covariates[0] - 20.0) / 20.0),
            RowLaw::Wave { joint, over, a } => (joint, 1.0 + a * (q[*over] + 0.4).sin()),
            _ => continue,
        };
        d.elastic_joints.iter_mut().find(|s| s.joint == *joint)?.stiffness *= factor.max(0.05);
    }
    let robot = Robot::new(&d).ok()?;
    let mut f = ModalSolver::new(&robot).frequencies_hz(q).ok()?.to_vec();
    for law in laws {
        match law {
            RowLaw::ModeBias { factors } => f.iter_mut().zip(factors).for_each(|(f, k)| *f *= k),
            RowLaw::JointWave { over, a, k } => {
                f.iter_mut().for_each(|f| *f *= 1.0 + a * (k * q[*over] + 0.7).sin())
            }
            RowLaw::Scatter { a } => f.iter_mut().for_each(|f| *f *= 1.0 + a * scatter),
            RowLaw::Absorber { hz, share } => f.iter_mut().for_each(|f| {
                // Pushed away from a resonance that the model does not have.
                let (x, y) = (*f * *f, hz * hz);
                let root = (0.25 * (x - y).powi(2) + (share * 0.2 * y).powi(2)).sqrt();
                *f = (0.5 * (x + y) + if x >= y { root } else { -root }).max(1.0).sqrt();
            }),
            _ => {}
        }
    }
    f.sort_by(f64::total_cmp);
    Some(f)
}

/// A case of `effect`, its strength set so that it moves the model by a few times the noise.
pub(crate) fn case(effect: &str, seed: u64) -> Option<Case> {
    let salt: u64 = effect.bytes().fold(7, |h, b| h.wrapping_mul(31).wrapping_add(u64::from(b)));
    let rng = &mut ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1000) ^ salt);
    let arm = if rng.random_bool(0.5) { "planar" } else { "six" };
    let description = if arm == "planar" { planar(rng) } else { six(rng) };
    let robot = Robot::new(&description).ok()?;
    let n = robot.joints().len();
    let rows = rng.random_range(16..=44);
    let noise = rng.random_range(0.003..0.01);
    let poses: Vec<Vec<f64>> = (0..rows)
        .map(|_| {
            robot
                .joints()
                .iter()
                .map(|j| {
                    let [a, b] = j.limit.unwrap();
                    rng.random_range(a..b)
                })
                .collect()
        })
        .collect();
    let mut solver = ModalSolver::new(&robot);
    let nominal: Vec<Vec<f64>> =
        poses.iter().map(|q| solver.frequencies_hz(q).unwrap().to_vec()).collect();
    let fmax: Vec<f64> = (0..n).map(|m| nominal.iter().map(|f| f[m]).fold(0.0, f64::max)).collect();
    let mut torque_scale = vec![0.0_f64; n];
    let mut placement = Placement::new(&robot);
    let mut gradient = vec![0.0; n];
    for q in &poses {
        placement.place(&robot, q);
        potential_gradient(&robot, &placement, &mut gradient);
        torque_scale.iter_mut().zip(&gradient).for_each(|(s, g)| *s = s.max(g.abs()));
    }
    let covariates: Vec<[f64; 2]> =
        (0..rows).map(|_| [rng.random_range(12.0..40.0), rng.random_range(5.0..60.0)]).collect();
    let scatter: Vec<f64> = (0..rows).map(|_| normal(rng)).collect();
    let effects: Vec<&str> = match effect {
        "two" | "three" => {
            let pool = &EFFECTS[1..16];
            let mut chosen: Vec<&str> = Vec::new();
            while chosen.len() < if effect == "two" { 2 } else { 3 } {
                let one = *pick(rng, pool);
                let payload_twice = one == "payload_off_flange" && chosen.contains(&"payload");
                if !(chosen.contains(&one) || payload_twice) && one != "gravity_stiffness" {
                    chosen.push(one);
                }
            }
            chosen
        }
        one => vec![one],
    };
    let aim = rng.random_range(4.0..8.0);
    let mut hidden = Hidden { truth: description.clone(), laws: vec![], truths: vec![] };
    let mut moved = 0.0;
    let mut made = Vec::new();
    for one in &effects {
        let plan: u64 = rng.random_range(0..u64::MAX);
        // The strength that moves the model by `aim` times the noise, by bisection.
        let (mut low, mut high) = (1e-3_f64, 4.0_f64);
        let mut best = None;
        for _ in 0..24 {
            let strength = (low * high).sqrt();
            let mut trial = Hidden {
                truth: hidden.truth.clone(),
                laws: hidden.laws.clone(),
                truths: hidden.truths.clone(),
            };
            let before: Option<Vec<Vec<f64>>> = (0..rows)
                .map(|i| {
                    frequencies(
                        &hidden.truth,
                        &hidden.laws,
                        &poses[i],
                        covariates[i],
                        scatter[i],
                        &torque_scale,
                    )
                })
                .collect();
            hide(
                one,
                &description,
                &mut ChaCha8Rng::seed_from_u64(plan),
                strength,
                &mut trial,
                &fmax,
                &poses,
            )?;
            let after: Option<Vec<Vec<f64>>> = (0..rows)
                .map(|i| {
                    frequencies(
                        &trial.truth,
                        &trial.laws,
                        &poses[i],
                        covariates[i],
                        scatter[i],
                        &torque_scale,
                    )
                })
                .collect();
            let (Some(before), Some(after)) = (before, after) else {
                high = strength;
                continue;
            };
            let mut sum = 0.0;
            let mut count = 0.0;
            for (a, b) in before.iter().zip(&after) {
                for (x, y) in a.iter().zip(b) {
                    sum += (y / x).ln().powi(2);
                    count += 1.0;
                }
            }
            let ratio = f64::sqrt(sum / count) / noise;
            moved = ratio;
            best = Some((trial, after));
            if ratio < aim {
                low = strength
            } else {
                high = strength
            }
            if (ratio / aim - 1.0).abs() < 0.03 {
                break;
            }
        }
        let (trial, after) = best?;
        let strong = matches!(*one, "nothing" | "aliased_mode" | "missed_mode") || moved > 3.5;
        if !strong {
            return None;
        }
        hidden = trial;
        made = after;
    }
    let instrument_rate = hidden.laws.iter().find_map(|law| match law {
        RowLaw::Alias { rate, .. } => Some(*rate),
        _ => None,
    });
    let columns = n;
    let table_rows: Vec<ModeRow> = (0..rows)
        .map(|i| {
            let mut f: Vec<f64> = made[i].iter().map(|f| f * (1.0 + noise * normal(rng))).collect();
            if let Some(RowLaw::Alias { mode, rate }) =
                hidden.laws.iter().find(|l| matches!(l, RowLaw::Alias { .. }))
                && f[*mode] > 0.5 * rate
            {
                f[*mode] = (f[*mode] - rate * (f[*mode] / rate).round()).abs();
            }
            f.sort_by(f64::total_cmp);
            for law in &hidden.laws {
                if let RowLaw::Missed { mode, share } = law
                    && rng.random_bool(*share)
                {
                    f.remove(*mode);
                }
            }
            let mut frequencies_hz: Vec<Option<f64>> =
                f.iter().map(|f| Some((f / 0.05).round() * 0.05)).collect();
            frequencies_hz.resize(columns, None);
            ModeRow {
                joints: poses[i].clone(),
                deviations_hz: vec![None; columns],
                frequencies_hz,
                temperature_c: Some(covariates[i][0]),
                amplitude_nm: Some(covariates[i][1]),
                sample_rate_hz: instrument_rate,
                line: i + 2,
                ..ModeRow::default()
            }
        })
        .collect();
    Some(Case {
        seed,
        arm,
        label: effect.into(),
        description,
        table: ModeTable { rows: table_rows, modes: columns },
        truths: hidden.truths,
        noise,
        effect_over_noise: moved,
    })
}
