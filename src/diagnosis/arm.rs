//! What candidates need to know of the robot: sizes to measure by, places, what the table covers.

use nalgebra::Vector3;

use super::data::Data;
use super::hypothesis::Hypothesis;
use super::mechanics::Mechanics;
use super::predict::predict;

use crate::model::{Description, Inertial, Joint, Placement, Robot, potential_gradient};
use crate::statistics::median;

/// A link that vibrates.
#[derive(Debug, Clone)]
pub(super) struct Body {
    pub(super) name: String,
    pub(super) inertial: Option<Inertial>,
    /// From its joint to where it ends, in its frame, m: the next moving joint, the tip or the
    /// centre of mass.
    pub(super) reach_m: Vector3<f64>,
    /// Links welded to it, the tip's link first.
    pub(super) welded: Vec<String>,
    /// Whether it lies between base and tip.
    pub(super) on_chain: bool,
    /// Moving joints that hang on it.
    pub(super) carries_joint: bool,
    /// Axis of the moving joint above it, in its frame; `None` for the base.
    pub(super) joint_axis: Option<Vector3<f64>>,
}

/// An elastic joint.
#[derive(Debug, Clone)]
pub(super) struct Spring {
    pub(super) joint: String,
    pub(super) slides: bool,
    pub(super) stiffness: f64,
    /// Typical own entry of M over the table's poses.
    pub(super) inertia: f64,
    /// Largest torque of gravity over the table's poses, N·m.
    pub(super) gravity_torque_nm: f64,
    /// Smallest of these.
    pub(super) min_gravity_torque_nm: f64,
    pub(super) reflected_inertia: f64,
    /// How far the joint's position varies over the table's poses, rad or m.
    pub(super) travel: f64,
    /// The elastic joint before it.
    pub(super) before: Option<String>,
}

/// The robot as the candidates see it.
#[derive(Debug)]
pub(super) struct Arm<'a> {
    pub(super) description: &'a Description,
    pub(super) root: String,
    pub(super) tip: String,
    pub(super) bodies: Vec<Body>,
    pub(super) springs: Vec<Spring>,
    /// All moving joints between base and tip, with whether they slide.
    pub(super) joints: Vec<(String, bool)>,
    pub(super) moving_mass_kg: f64,
    /// Typical length of a link, m.
    pub(super) length_m: f64,
    /// Largest spring constant of a turning joint, N·m/rad.
    pub(super) stiffest: f64,
    /// Number of modes that the model has.
    pub(super) modes: usize,
    pub(super) has_gravity_stiffness: bool,
    /// Least, median and largest.
    pub(super) temperatures_c: Option<[f64; 3]>,
    pub(super) amplitudes_nm: Option<[f64; 3]>,
    /// Lowest sampling rate in the table.
    pub(super) min_sample_rate_hz: Option<f64>,
    /// Highest frequency of each mode of the model over the table's poses, Hz.
    pub(super) highest_of_mode_hz: Vec<f64>,
    /// Lowest frequency measured, Hz.
    pub(super) lowest_hz: f64,
    /// Highest frequency measured, Hz.
    pub(super) highest_hz: f64,
    /// Median of each column of the table that has values, Hz.
    pub(super) median_of_column_hz: Vec<f64>,
}

impl<'a> Arm<'a> {
    /// `None` if the model has no modes at a pose of the table.
    pub(super) fn new(description: &'a Description, robot: &Robot, data: &Data) -> Option<Self> {
        let corrected = description.corrected().ok()?;
        let mut mechanics = Mechanics::new(description, &[], &data.rows)?;
        let mut inertias = vec![0.0; robot.coordinates().len()];
        for row in &data.rows {
            mechanics.place(row)?;
            for (i, inertia) in inertias.iter_mut().enumerate() {
                *inertia += mechanics.mass()[(i, i)] / data.rows.len() as f64;
            }
        }
        let predicted = predict(description, &Hypothesis::default(), data)?;
        let highest_of_mode_hz = (0..robot.coordinates().len())
            .map(|mode| {
                let of_mode = predicted.iter().filter_map(|row| row.get(mode));
                of_mode.map(|frequency| frequency.ln_hz.exp()).fold(0.0, f64::max)
            })
            .collect();
        let tip = robot.tip_link().to_owned();
        let root = root_of(&corrected)?;
        let above = |link: &str| corrected.joints.iter().find(|joint| joint.child == link);
        let mut chain = vec![tip.clone()];
        let mut at = tip.clone();
        while at != root {
            let joint = above(&at)?;
            at.clone_from(&joint.parent);
            chain.push(at.clone());
        }
        let springs = springs(&corrected, robot, data, &inertias);
        let bodies = bodies(&corrected, &root, &tip, &chain);
        let lengths: Vec<f64> = bodies.iter().map(|body| body.reach_m.norm()).collect();
        let range = |values: Vec<f64>| -> Option<[f64; 3]> {
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let is_varied = values.len() == data.rows.len() && high > low;
            is_varied.then_some([low, median(values)?, high])
        };
        let rows = &data.rows;
        Some(Self {
            description,
            modes: robot.coordinates().len(),
            stiffest: springs.iter().filter(|s| !s.slides).map(|s| s.stiffness).fold(0.0, f64::max),
            springs,
            length_m: median(lengths.into_iter().filter(|&l| l > 0.02).collect()).unwrap_or(0.3),
            bodies,
            root,
            tip,
            joints: robot
                .joints()
                .iter()
                .map(|j| (j.name.clone(), j.kind == crate::model::JointKind::Prismatic))
                .collect(),
            moving_mass_kg: robot.moving_mass_kg(),
            has_gravity_stiffness: robot.has_gravity_stiffness(),
            temperatures_c: range(rows.iter().filter_map(|r| r.conditions.temperature_c).collect()),
            amplitudes_nm: range(rows.iter().filter_map(|r| r.conditions.amplitude_nm).collect()),
            min_sample_rate_hz: rows.iter().filter_map(|r| r.sample_rate_hz).reduce(f64::min),
            highest_of_mode_hz,
            lowest_hz: data.points.iter().map(|p| p.ln_f.exp()).fold(f64::INFINITY, f64::min),
            highest_hz: data.points.iter().map(|p| p.ln_f.exp()).fold(0.0, f64::max),
            median_of_column_hz: (0..data.columns)
                .filter_map(|column| {
                    let own = data.points.iter().filter(|point| point.column == column);
                    median(own.map(|point| point.ln_f.exp()).collect())
                })
                .collect(),
        })
    }

    /// Stiffness of a rotation that matters: the joints' or the stiffest.
    pub(super) fn rotation_stiffness(&self) -> f64 {
        if self.stiffest > 0.0 { self.stiffest } else { 1e6 }
    }
}

fn root_of(description: &Description) -> Option<String> {
    if let Some(base) = &description.base {
        return Some(base.clone());
    }
    let is_child = |name: &str| description.joints.iter().any(|joint| joint.child == name);
    description.links.iter().find(|link| !is_child(&link.name)).map(|link| link.name.clone())
}

fn springs(description: &Description, robot: &Robot, data: &Data, inertias: &[f64]) -> Vec<Spring> {
    let mut placement = Placement::new(robot);
    let n = robot.coordinates().len();
    let mut torques = vec![[f64::INFINITY, 0.0_f64]; n];
    let mut gradient = vec![0.0; n];
    for row in &data.rows {
        placement.place(robot, &row.q);
        potential_gradient(robot, &placement, &mut gradient);
        for (range, torque) in torques.iter_mut().zip(&gradient) {
            *range = [range[0].min(torque.abs()), range[1].max(torque.abs())];
        }
    }
    let mut springs: Vec<Spring> = Vec::new();
    for (i, coordinate) in robot.coordinates().iter().enumerate() {
        let Some(spring) = description.elastic_joints.iter().find(|s| s.joint == coordinate.name)
        else {
            continue;
        };
        let positions = || {
            let joint = coordinate.joint;
            data.rows.iter().filter_map(move |row| row.q.get(joint?).copied())
        };
        let low = positions().fold(f64::INFINITY, f64::min);
        let high = positions().fold(f64::NEG_INFINITY, f64::max);
        springs.push(Spring {
            travel: (high - low).max(0.0),
            before: springs.last().map(|before| before.joint.clone()),
            joint: spring.joint.clone(),
            slides: spring.is_linear,
            stiffness: spring.stiffness,
            inertia: inertias[i],
            min_gravity_torque_nm: torques[i][0],
            gravity_torque_nm: torques[i][1],
            reflected_inertia: description
                .drives
                .iter()
                .find(|drive| drive.joint == spring.joint)
                .map_or(0.0, |drive| drive.reflected_inertia_kgm2),
        });
    }
    springs
}

fn bodies(description: &Description, root: &str, tip: &str, chain: &[String]) -> Vec<Body> {
    let below = |link: &str| -> Vec<&Joint> {
        description.joints.iter().filter(|joint| joint.parent == link).collect()
    };
    let mut bodies = Vec::new();
    let mut open = vec![root.to_owned()];
    while let Some(link) = open.pop() {
        let joints = below(&link);
        open.extend(joints.iter().rev().map(|joint| joint.child.clone()));
        let own = description.joints.iter().find(|joint| joint.child == link);
        let is_body = link == root || own.is_some_and(|joint| joint.kind.moves());
        if !is_body {
            continue;
        }
        // Links welded on count as part of the body.
        let mut welded = Vec::new();
        let mut ends: Vec<(String, Vector3<f64>)> = Vec::new();
        let mut weld = vec![(link.clone(), nalgebra::Isometry3::identity())];
        let mut carries_joint = false;
        while let Some((at, frame)) = weld.pop() {
            for joint in below(&at) {
                let frame = frame * joint.origin;
                if joint.kind.moves() {
                    carries_joint = true;
                    ends.push((joint.child.clone(), frame.translation.vector));
                } else {
                    welded.push(joint.child.clone());
                    ends.push((joint.child.clone(), frame.translation.vector));
                    weld.push((joint.child.clone(), frame));
                }
            }
        }
        welded.sort_by_key(|name| *name != tip);
        let Some(found) = description.links.iter().find(|l| l.name == link) else { continue };
        let on_the_way = ends.iter().filter(|(name, _)| chain.contains(name));
        let far =
            on_the_way.map(|(_, end)| *end).fold(Vector3::zeros(), |far: Vector3<f64>, end| {
                if end.norm() > far.norm() { end } else { far }
            });
        let com = found.inertial.map_or(Vector3::zeros(), |inertial| inertial.com_m);
        bodies.push(Body {
            reach_m: if far.norm() > 0.02 { far } else { com },
            inertial: found.inertial.filter(|inertial| inertial.mass_kg > 0.0),
            welded,
            on_chain: chain.contains(&link),
            carries_joint,
            joint_axis: own.filter(|_| link != root).map(|joint| joint.axis.normalize()),
            name: link,
        });
    }
    bodies
}
