//! The arm as it really is, as a chain of elements ([`crate::truth::dynamics`]).

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::truth::arm::{Arm, Body, GRAVITY_M_PER_S2, Kind};
use crate::truth::dynamics::{Element, frame, motion, roll_pitch_yaw, rotation, shift, turn};
use crate::truth::eigen::lowest_hz;
use crate::truth::world::Row;

/// A spring between a link and what carries it.
#[derive(Debug, Clone)]
pub(super) struct Spring {
    /// 0 is the base.
    pub(super) link: usize,
    pub(super) kind: Kind,
    pub(super) axis: Vector3<f64>,
    pub(super) origin_m: Vector3<f64>,
    pub(super) stiffness: f64,
}

/// A link as a beam of rigid segments.
#[derive(Debug, Clone)]
pub(super) struct Beam {
    pub(super) link: usize,
    pub(super) segments: usize,
    /// About the axes across the reach and along it, of the whole beam, N·m/rad.
    pub(super) stiffness: [f64; 3],
}

/// A gear's stiffness over its constant.
#[derive(Debug, Clone)]
pub(super) enum Gear {
    /// 1 + c (|τ|/τ_max − ½).
    Leaning { c: f64, largest_nm: f64 },
    /// Tangent stiffness in three steps, K1 below T1, K2, K3 above T2, over K2; averaged over the swing.
    Slopes { torques_nm: [f64; 2], shares: [f64; 3], swing_nm: f64 },
    /// Stuck for small swings, slipping for large: s + (1 − s) / (1 + A/A₀).
    Slips { least: f64, level_nm: f64 },
    /// 1 + Σ a_n cos(n q + φ_n), from n = 1.
    Mesh { waves: Vec<[f64; 2]> },
    /// exp(−c (T − 20 °C)).
    Warms { per_k: f64 },
}

impl Gear {
    fn share(&self, q: f64, row: &Row, torque_nm: f64) -> f64 {
        let torque = torque_nm.abs();
        match self {
            Self::Leaning { c, largest_nm } => 1.0 + c * (torque / largest_nm - 0.5),
            Self::Slopes { torques_nm: [t1, t2], shares: [k1, k2, k3], swing_nm } => {
                let steps = 21;
                let tangent = |i: usize| {
                    let at = torque + swing_nm * (2.0 * i as f64 / (steps - 1) as f64 - 1.0);
                    let at = at.abs();
                    if at < *t1 {
                        *k1
                    } else if at < *t2 {
                        *k2
                    } else {
                        *k3
                    }
                };
                // Compliances add along a swing.
                steps as f64 / (0..steps).map(|i| 1.0 / tangent(i)).sum::<f64>()
            }
            Self::Slips { least, level_nm } => {
                least + (1.0 - least) / (1.0 + row.amplitude_nm / level_nm)
            }
            Self::Mesh { waves } => {
                let one =
                    |(n, [a, phase]): (usize, &[f64; 2])| a * ((n + 1) as f64 * q + phase).cos();
                1.0 + waves.iter().enumerate().map(one).sum::<f64>()
            }
            Self::Warms { per_k } => (-per_k * (row.temperature_c - 20.0)).exp(),
        }
    }
}

/// A servo in series with the gear: its stiffness, and the rotor between.
#[derive(Debug, Clone)]
pub(super) struct Servo {
    pub(super) joint: usize,
    pub(super) stiffness: f64,
    pub(super) rotor_kgm2: f64,
}

/// A gripper or a cable at the tip, as stiff on its spring as its own frequency says.
#[derive(Debug, Clone)]
pub(super) struct Hung {
    pub(super) mass_kg: f64,
    pub(super) frequency_hz: f64,
    pub(super) axis: Vector3<f64>,
}

impl Hung {
    /// Of some size: the engine's is a point.
    fn body(&self) -> Body {
        let edges = Vector3::new(0.12, 0.08, 0.05);
        Body::block(self.mass_kg, 0.5 * edges, edges, Matrix3::identity())
    }
}

/// The arm as it is.
#[derive(Debug, Clone)]
pub(super) struct Real {
    pub(super) arm: Arm,
    pub(super) springs: Vec<Spring>,
    pub(super) beams: Vec<Beam>,
    pub(super) gears: Vec<(usize, Gear)>,
    pub(super) servos: Vec<Servo>,
    /// Bodies on links, in their frames.
    pub(super) carried: Vec<(usize, Body)>,
    /// Parts at the tip, each on a spring along an axis.
    pub(super) hung: Vec<Hung>,
    /// A belt: the spring of this joint also feels so much of the deflection of the joint before.
    pub(super) belts: Vec<(usize, f64)>,
}

/// An elastic coordinate of the chain.
struct Coordinate {
    stiffness: f64,
    /// The joint whose gear it is.
    gear: Option<usize>,
    rotor_kgm2: f64,
}

impl Real {
    pub(super) fn of(arm: &Arm) -> Self {
        Self {
            arm: arm.clone(),
            springs: Vec::new(),
            beams: Vec::new(),
            gears: Vec::new(),
            servos: Vec::new(),
            carried: Vec::new(),
            hung: Vec::new(),
            belts: Vec::new(),
        }
    }

    fn chain(&self, row: &Row) -> (Vec<Element>, Vec<Coordinate>) {
        let (mut chain, mut coordinates) = (Vec::new(), Vec::new());
        self.link(0, &self.arm.base, &mut chain, &mut coordinates);
        for (i, joint) in self.arm.joints.iter().enumerate() {
            let posed = rotation(&joint.axis, row.joints_rad[i]);
            chain.push(Element::Step(frame(&roll_pitch_yaw(&joint.rpy_rad), &joint.origin_m)));
            chain.push(Element::Step(frame(&posed, &Vector3::zeros())));
            let mut turns = |stiffness, gear, rotor_kgm2| {
                chain.push(Element::Spring(turn(&joint.axis, &Vector3::zeros())));
                coordinates.push(Coordinate { stiffness, gear, rotor_kgm2 });
            };
            for servo in self.servos.iter().filter(|servo| servo.joint == i) {
                turns(servo.stiffness, None, servo.rotor_kgm2);
            }
            turns(joint.stiffness_nm_per_rad, Some(i), joint.drive_kgm2);
            self.link(i + 1, &joint.body, &mut chain, &mut coordinates);
        }
        chain.push(Element::Step(frame(&Matrix3::identity(), &self.arm.tip_m)));
        if let Some(payload) = &self.arm.payload {
            chain.push(Element::Body(payload.pseudo_inertia()));
        }
        chain.push(Element::Body(Body::point(row.payload_kg, Vector3::zeros()).pseudo_inertia()));
        for part in &self.hung {
            let turns = TAU * part.frequency_hz;
            chain.push(Element::Spring(shift(&part.axis)));
            let (gear, rotor_kgm2) = (None, 0.0);
            let stiffness = part.mass_kg * turns * turns;
            coordinates.push(Coordinate { stiffness, gear, rotor_kgm2 });
            chain.push(Element::Body(part.body().pseudo_inertia()));
        }
        (chain, coordinates)
    }

    fn link(
        &self,
        link: usize,
        body: &Body,
        chain: &mut Vec<Element>,
        coordinates: &mut Vec<Coordinate>,
    ) {
        let plain = |stiffness| Coordinate { stiffness, gear: None, rotor_kgm2: 0.0 };
        for spring in self.springs.iter().filter(|spring| spring.link == link) {
            chain.push(Element::Spring(match spring.kind {
                Kind::Rotation => turn(&spring.axis, &spring.origin_m),
                Kind::Translation => shift(&spring.axis),
            }));
            coordinates.push(plain(spring.stiffness));
        }
        match self.beams.iter().find(|beam| beam.link == link) {
            None => chain.push(Element::Body(body.pseudo_inertia())),
            Some(beam) => {
                let reach = self.arm.reach(link);
                let slabs = slabs(body, &reach, beam.segments + 1);
                chain.push(Element::Body(slabs[0].pseudo_inertia()));
                let along = reach.normalize();
                let across = along.cross(&any_other(&along)).normalize();
                let axes = [across, along.cross(&across), along];
                for (k, slab) in slabs[1..].iter().enumerate() {
                    let at = reach * ((k as f64 + 0.5) / beam.segments as f64);
                    for (axis, stiffness) in axes.iter().zip(beam.stiffness) {
                        chain.push(Element::Spring(turn(axis, &at)));
                        coordinates.push(plain(stiffness * beam.segments as f64));
                    }
                    chain.push(Element::Body(slab.pseudo_inertia()));
                }
            }
        }
        for (_, carried) in self.carried.iter().filter(|(at, _)| *at == link) {
            chain.push(Element::Body(carried.pseudo_inertia()));
        }
    }

    /// Torque of gravity on a joint, N·m.
    pub(super) fn gravity_torque_nm(&self, joint: usize, row: &Row) -> f64 {
        let (chain, coordinates) = self.chain(row);
        let at = coordinates.iter().position(|c| c.gear == Some(joint)).unwrap();
        motion(&chain, GRAVITY_M_PER_S2).gravity_torque[at]
    }

    /// The `wanted` lowest frequencies, Hz.
    pub(super) fn frequencies_hz(&self, row: &Row, wanted: usize) -> Vec<f64> {
        let (chain, coordinates) = self.chain(row);
        let motion = motion(&chain, GRAVITY_M_PER_S2);
        let mut mass = motion.mass.clone();
        let mut k = DVector::from_iterator(
            coordinates.len(),
            coordinates.iter().map(|coordinate| coordinate.stiffness),
        );
        for (c, coordinate) in coordinates.iter().enumerate() {
            mass[(c, c)] += coordinate.rotor_kgm2;
            let Some(joint) = coordinate.gear else { continue };
            for (_, gear) in self.gears.iter().filter(|(at, _)| *at == joint) {
                k[c] *= gear.share(row.joints_rad[joint], row, motion.gravity_torque[c]);
            }
        }
        let mut stiffness = DMatrix::from_diagonal(&k);
        for (joint, ratio) in &self.belts {
            let of = |joint: usize| coordinates.iter().position(|c| c.gear == Some(joint)).unwrap();
            let (before, own) = (of(joint - 1), of(*joint));
            stiffness[(before, before)] += ratio * ratio * k[own];
            stiffness[(before, own)] += ratio * k[own];
            stiffness[(own, before)] += ratio * k[own];
        }
        lowest_hz(&stiffness, &mass, wanted)
    }
}

fn any_other(along: &Vector3<f64>) -> Vector3<f64> {
    if along.z.abs() < 0.8 { Vector3::z() } else { Vector3::x() }
}

/// A body cut into slabs of equal mass across a direction; together they are the body.
fn slabs(body: &Body, direction: &Vector3<f64>, count: usize) -> Vec<Body> {
    let u = direction.normalize();
    let second = body.second_moment() / body.mass_kg;
    let spread = second * u;
    let variance = u.dot(&spread);
    let line = spread / variance;
    let n = count as f64;
    let left = second - line * line.transpose() * (variance * (1.0 - 1.0 / (n * n)));
    let inertia = (Matrix3::identity() * left.trace() - left) * (body.mass_kg / n);
    (0..count)
        .map(|k| {
            let place = ((k as f64 + 0.5) / n - 0.5) * (12.0 * variance).sqrt();
            Body {
                mass_kg: body.mass_kg / n,
                com_m: body.com_m + line * place,
                inertia_kgm2: inertia,
            }
        })
        .collect()
}

/// Slabs are the body, and a beam that hardly bends is a link.
#[test]
fn a_stiff_beam_is_a_link() {
    use crate::truth::dice::Dice;
    use crate::truth::robots::{Family, arm, row_at};
    let arm = arm(Family::SixAxis, &mut Dice::new(10));
    let row = row_at(vec![0.3, 0.4, -0.5, 0.6, 0.7, -0.8]);
    let whole = crate::truth::world::World::of(&arm).frequencies_hz(&row, 6);
    let mut real = Real::of(&arm);
    for (own, whole) in real.frequencies_hz(&row, 6).iter().zip(&whole) {
        assert!((own / whole - 1.0).abs() < 1e-9, "{own} for {whole}");
    }
    real.beams.push(Beam { link: 2, segments: 4, stiffness: [1e12; 3] });
    for (bent, whole) in real.frequencies_hz(&row, 6).iter().zip(&whole) {
        assert!((bent / whole - 1.0).abs() < 1e-4, "{bent} for {whole}");
    }
    let body = &arm.joints[1].body;
    let slabs = slabs(body, &arm.reach(2), 5);
    let sum = slabs.iter().map(Body::pseudo_inertia).sum::<nalgebra::Matrix4<f64>>();
    assert!((sum - body.pseudo_inertia()).norm() < 1e-9 * sum.norm());
}
