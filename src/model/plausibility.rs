//! Robots that a reader should doubt: figures that no arm has, each with what to check. None of
//! them is impossible, so none is an error.

use nalgebra::Matrix3;

use super::correction::StiffnessLaw;
use super::description::{Calibration, CoordinateKind, Description, Inertial, JointKind};
use super::posterior::Fingerprint;
use super::robot::{Coordinate, NodeMotion, Robot, ancestors};
use crate::notes::{Code, Note, Part, Place};
use crate::statistics::median;
use crate::wording::rounded;

/// Two identical parts are common, as the fingers of a gripper are; three different links of an arm
/// never weigh the same to the last digit.
const MIN_SAME: usize = 3;

/// How far a body may stand out from the stretch between its joints, as a share of the arm's
/// length: motors, counterweights and girth. A rod has a radius of gyration of 0.29 of its length.
const MAX_OVERHANG: f64 = 0.25;

/// Joints of one arm that lie farther apart than this in all, m: the largest arms reach 5 m.
const MAX_LENGTH_M: f64 = 20.0;

/// Mass that moves over the cube of the arm's length, kg/m³: between a rod of aluminium a fiftieth
/// as thick as it is long (2700 π/4 / 50²) and one of steel a fifth as thick (7850 π/4 / 5²). The
/// IRB 1600 has 20.
const MASS_OVER_LENGTH_CUBED: [f64; 2] = [0.85, 250.0];

/// Lead, kg/m³: no part of an arm is denser as a whole.
const MAX_DENSITY: f64 = 11_340.0;

/// A spring over the median of the other springs of its kind: the stiffest joint of an arm is some
/// 100 times as stiff as the softest, N·m/arcmin are 3438 N·m/rad, N·mm/rad a thousandth.
const SPRING_OVER_OTHERS: [f64; 2] = [1e-3, 1e3];

/// What is doubtful about a robot, with places in its files. `rigid` are the joints that are meant
/// to be rigid.
pub fn doubts(description: &Description, robot: &Robot, rigid: &[String]) -> Vec<Note> {
    let arm = Arm::of(description, robot);
    let mut notes = Vec::new();
    notes.extend(arm.same_inertials());
    notes.extend(arm.bodies.iter().flat_map(|(name, body)| arm.extent(name, body)));
    notes.extend(arm.length());
    match arm.mass() {
        Some(note) => notes.push(note),
        None => notes.extend(arm.too_dense()),
    }
    notes.extend(springs_out_of_scale(robot));
    notes.extend(joints_without_spring(robot, rigid));
    notes.extend(springs_off_the_chain(description, robot));
    notes.extend(joints_beside_the_arm(description, robot));
    notes.extend(strong_gravity(description));
    notes.extend(limits_in_degrees(robot));
    notes.extend(laws_of_conditions(robot));
    notes.extend(robot.calibration().and_then(slight));
    notes.extend(robot.calibration().and_then(|calibration| changed_since(calibration, robot)));
    notes
}

/// What moves when the joints do.
struct Arm<'d> {
    description: &'d Description,
    /// Links with a mass that somebody states, each in its own frame.
    bodies: Vec<(&'d str, &'d Inertial)>,
    moving_mass_kg: f64,
    /// From the first moving joint to the tip, from joint to joint.
    length_m: f64,
    /// Travel of joints that slide, which no file's origins hold; infinite without limits.
    travel_m: f64,
}

impl<'d> Arm<'d> {
    fn of(description: &'d Description, robot: &Robot) -> Self {
        let moves = |node: usize| {
            ancestors(robot.nodes(), node).any(|n| robot.nodes()[n].motion != NodeMotion::Fixed)
        };
        let moving = || robot.bodies().iter().filter(|body| moves(body.node) && !body.is_payload);
        let bodies = moving().filter_map(|body| {
            let link = description.links.iter().find(|link| link.name == body.link)?;
            let own = link.inertial.as_ref().filter(|own| own.mass_kg > 0.0 && !link.assumed)?;
            Some((link.name.as_str(), own))
        });
        let sliding = robot.joints().iter().filter(|joint| joint.kind == JointKind::Prismatic);
        let (tip, tip_offset) = robot.tip();
        let carried = ancestors(robot.nodes(), tip)
            .filter(|&n| robot.nodes()[n].parent.is_some_and(moves))
            .map(|n| robot.nodes()[n].fixed.origin.norm());
        Self {
            description,
            bodies: bodies.collect(),
            moving_mass_kg: moving().map(|body| body.body.mass_kg).sum(),
            length_m: carried.sum::<f64>() + tip_offset.translation.vector.norm(),
            travel_m: sliding
                .map(|joint| joint.limit.map_or(f64::INFINITY, |[from, to]| to - from))
                .sum(),
        }
    }

    /// Placeholders of an exporter.
    fn same_inertials(&self) -> Option<Note> {
        let like = |of: &Inertial| {
            let same = self.bodies.iter().filter(|(_, body)| {
                body.mass_kg == of.mass_kg
                    && (body.inertia_kgm2 - of.inertia_kgm2).amax() <= 1e-9 * of.inertia_kgm2.amax()
            });
            same.map(|&(name, _)| name).collect::<Vec<_>>()
        };
        let (names, body) =
            self.bodies.iter().map(|(_, body)| (like(body), body)).max_by_key(|(n, _)| n.len())?;
        let most = names.len() >= MIN_SAME && 2 * names.len() > self.bodies.len();
        most.then(|| {
            let [x, y, z] = [0, 1, 2].map(|i| body.inertia_kgm2[(i, i)]);
            let what = format!(
                "the same inertial on {}: {} kg, ixx {x}, iyy {y}, izz {z} kg·m²; is it a \
                 placeholder? Give each link its own under inertials",
                names.join(", "),
                body.mass_kg
            );
            Note::warning(Code::SameInertial, Place::part(Part::Robot), what)
        })
    }

    /// A body that stands out farther than links do.
    fn extent(&self, name: &str, body: &Inertial) -> Vec<Note> {
        let length_m = self.description.reach_of(name).norm();
        // What slides may stand out by its travel.
        let limit_m = length_m + MAX_OVERHANG * self.length_m + self.travel_m;
        if limit_m == 0.0 {
            return Vec::new();
        }
        let note = |key, of: &str, value_m: f64, unit: &str| {
            let in_mm = looks_scaled(value_m, limit_m);
            let check = if in_mm { unit } else { "check the CAD export and its reference frame" };
            let what = format!(
                "{of} is {value_m:.3} m, where the link is {length_m:.3} m and the arm {:.3} m \
                 long; {check}",
                self.length_m
            );
            let code = if in_mm { Code::CadUnits } else { Code::InertiaExtent };
            Note::warning(code, Place::key(Part::Link(name.to_owned()), key), what)
        };
        let com_m = body.com_m.norm();
        let gyration_m = gyration(&body.inertia_kgm2, body.mass_kg);
        let com = (com_m > limit_m)
            .then(|| note("com", "distance of the centre of mass", com_m, "is it in millimetres?"));
        let gyration = (gyration_m > limit_m).then(|| {
            note("inertia", "radius of gyration", gyration_m, "is the inertia in kg·mm² or g·mm²?")
        });
        com.into_iter().chain(gyration).collect()
    }

    /// Bodies more compact than lead: one may be an idealisation, most of them are a wrong unit.
    fn too_dense(&self) -> Option<Note> {
        let mean_kgm2 = |body: &Inertial| body.inertia_kgm2.trace() / 3.0;
        let is_dense = |body: &Inertial| mean_kgm2(body) < least_moment_kgm2(body.mass_kg);
        let dense: Vec<_> = self.bodies.iter().filter(|(_, body)| is_dense(body)).collect();
        let (first, body) = dense.first()?;
        (dense.len() >= 2 && 2 * dense.len() > self.bodies.len()).then(|| {
            let names: Vec<&str> = dense.iter().map(|(name, _)| *name).collect();
            let what = format!(
                "links denser than lead: {}; {first}, {} kg, has moments of inertia of {} kg·m² on \
                 average, a ball of lead has {}; are the inertias in kg·m²?",
                names.join(", "),
                rounded(body.mass_kg, 3),
                rounded(mean_kgm2(body), 3),
                rounded(least_moment_kgm2(body.mass_kg), 3)
            );
            Note::warning(Code::CadUnits, Place::part(Part::Robot), what)
        })
    }

    fn length(&self) -> Option<Note> {
        self.is_too_long().then(|| {
            let what = format!(
                "the arm is {:.3} m long from joint to joint; are the origins of the joints in \
                 millimetres?",
                self.length_m
            );
            Note::warning(Code::CadUnits, Place::part(Part::Robot), what)
        })
    }

    fn is_too_long(&self) -> bool {
        self.length_m > MAX_LENGTH_M
    }

    fn mass(&self) -> Option<Note> {
        let cube_m3 = self.length_m.powi(3);
        if self.travel_m > 0.0 || self.is_too_long() || self.moving_mass_kg == 0.0 || cube_m3 == 0.0
        {
            return None;
        }
        let [least_kg, most_kg] = MASS_OVER_LENGTH_CUBED.map(|limit| limit * cube_m3);
        if (least_kg..=most_kg).contains(&self.moving_mass_kg) {
            return None;
        }
        let in_grams = looks_scaled(self.moving_mass_kg, most_kg);
        let (code, check) = if in_grams {
            (Code::CadUnits, "are the masses in grams?")
        } else {
            (Code::TotalMass, "check the masses and the scale of the model")
        };
        let what = format!(
            "what moves weighs {} kg on an arm of {:.3} m from joint to joint, where \
             {least_kg:.1} to {most_kg:.1} kg are usual; {check}",
            rounded(self.moving_mass_kg, 3),
            self.length_m
        );
        Some(Note::warning(code, Place::part(Part::Robot), what))
    }
}

/// Moment of a ball of lead, which has the smallest sum of moments of all bodies of its mass that
/// are no denser: ⅖ m r² with m = ⁴⁄₃ π ρ r³.
fn least_moment_kgm2(mass_kg: f64) -> f64 {
    let radius_m = (0.75 * mass_kg / (std::f64::consts::PI * MAX_DENSITY)).cbrt();
    0.4 * mass_kg * radius_m * radius_m
}

/// Units that are not N·m/rad, or N/m.
fn springs_out_of_scale(robot: &Robot) -> Vec<Note> {
    [CoordinateKind::Rotation, CoordinateKind::Translation]
        .into_iter()
        .flat_map(|kind| {
            let of_joints = robot.coordinates().iter().filter(|own| own.joint.is_some());
            out_of_scale(&of_joints.filter(|own| own.kind == kind).collect::<Vec<_>>(), kind)
        })
        .collect()
}

/// Of springs of one kind.
fn out_of_scale(springs: &[&Coordinate], kind: CoordinateKind) -> Vec<Note> {
    let (unit, key) = match kind {
        CoordinateKind::Rotation => ("N·m/rad", "stiffness_nm_per_rad"),
        CoordinateKind::Translation => ("N/m", "stiffness_n_per_m"),
    };
    let note = |own: &Coordinate, what: String| {
        let what = format!(
            "{what}; is it in {unit}? A joint that is meant to be rigid belongs in \
             elasticity.rigid"
        );
        let place = Place::key(Part::ElasticJoint(own.name.clone()), key);
        Note::warning(Code::StiffnessScale, place, what)
    };
    let out = |own: &&Coordinate| {
        let others = springs.iter().filter(|other| other.name != own.name);
        let typical = median(others.map(|other| other.stiffness).collect())?;
        let [least, most] = SPRING_OVER_OTHERS.map(|limit| limit * typical);
        (!(least..=most).contains(&own.stiffness)).then_some(typical)
    };
    let found: Vec<(&Coordinate, f64)> =
        springs.iter().filter_map(|own| Some((*own, out(own)?))).collect();
    if found.len() < springs.len() {
        let alone = |&(own, typical): &(&Coordinate, f64)| {
            let [k, typical] = [own.stiffness, typical].map(|k| rounded(k, 3));
            note(own, format!("{k} {unit}, where the median of the other joints is {typical}"))
        };
        return found.iter().map(alone).collect();
    }
    // Two halves: which one is out of scale, neither says.
    let (soft, stiff): (Vec<_>, Vec<_>) =
        found.into_iter().partition(|(own, typical)| own.stiffness < *typical);
    let half = |half: &[(&Coordinate, f64)]| {
        let names: Vec<&str> = half.iter().map(|(own, _)| own.name.as_str()).collect();
        let all = || half.iter().map(|(own, _)| rounded(own.stiffness, 3));
        let [least, most] =
            [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)];
        let to = if most > least { format!(" to {most}") } else { String::new() };
        format!("{} {least}{to} {unit}", names.join(", "))
    };
    let first = springs.first().filter(|_| !soft.is_empty());
    let what = || format!("{}, but {}: one half of the joints", half(&stiff), half(&soft));
    first.map(|own| note(own, what())).into_iter().collect()
}

/// A calibration that says more than its poses can.
fn slight(calibration: &Calibration) -> Option<Note> {
    let Calibration { poses, heldout_rms_percent, is_doubtful, ref posterior } = *calibration;
    let (least, floor) = (Calibration::MIN_POSES, Calibration::MIN_HELDOUT_PERCENT);
    let what = if poses < least {
        format!("calibration.poses is {poses}: fewer than {least} poses say little of any other")
    } else if heldout_rms_percent < floor {
        format!(
            "calibration.heldout_rms_percent is {heldout_rms_percent}, less than any instrument's \
             {floor} %, which is taken"
        )
    } else if posterior.is_some() && heldout_rms_percent > Calibration::UNCALIBRATED_PERCENT {
        let what = format!(
            "calibration.heldout_rms_percent is {}, more than the {} % of a model that nobody \
             measured: the table does not fit this arm; check its joints, their order, signs and \
             units, then run detune diagnose --write again",
            rounded(heldout_rms_percent, 3),
            Calibration::UNCALIBRATED_PERCENT
        );
        return Some(of_calibration(what));
    } else if is_doubtful {
        let what = format!(
            "the causes of the calibration fit their table far better than they predicted poses \
             left out (heldout_rms_percent {}): elsewhere they may be off by more than the \
             intervals say; measure more poses, then run detune diagnose --write again",
            rounded(heldout_rms_percent, 3)
        );
        return Some(of_calibration(what));
    } else {
        return None;
    };
    Some(of_calibration(format!("{what}; write it with detune diagnose --write")))
}

/// A calibration of another model than the one that stands here.
fn changed_since(calibration: &Calibration, robot: &Robot) -> Option<Note> {
    /// Figures are written with eight digits.
    const ROUNDED: f64 = 1e-6;
    let posterior = calibration.posterior.as_ref()?;
    let then = posterior.fingerprint.as_ref()?;
    let now = Fingerprint::of(robot, posterior.unexplained.poses.first()?)?;
    let named = |then: &[f64], now: &[f64]| -> Vec<String> {
        let both = now.iter().zip(then).zip(robot.coordinates());
        let apart = both.filter(|((now, then), _)| (*now / *then - 1.0).abs() > ROUNDED);
        let told = |((now, then), of): ((&f64, &f64), &Coordinate)| {
            format!("{} times as much at {}", rounded(now / then, 4), of.name)
        };
        apart.map(told).collect()
    };
    let masses = named(&then.mass_diagonal, &now.mass_diagonal);
    let springs = named(&then.stiffness_diagonal, &now.stiffness_diagonal);
    let (what, figures) = match (masses.is_empty(), springs.is_empty()) {
        _ if then.mass_diagonal.len() != now.mass_diagonal.len() => {
            ("elastic joints were", "the file has another number of them".to_owned())
        }
        (true, true) => return None,
        (false, true) => ("masses or dimensions were", format!("M is {}", masses.join(", "))),
        (true, false) => ("springs were", format!("K is {}", springs.join(", "))),
        (false, false) => (
            "masses or dimensions, and springs, were",
            format!("M is {}; K is {}", masses.join(", "), springs.join(", ")),
        ),
    };
    Some(of_calibration(format!(
        "{what} changed after the calibration: at its first pose {figures}; undo the change, or \
         measure again and run detune diagnose --write"
    )))
}

fn of_calibration(what: String) -> Note {
    Note::warning(Code::Calibration, Place::key(Part::Robot, "calibration"), what)
}

/// Whether a value that is too large would be well within the limit a thousand times smaller.
fn looks_scaled(value: f64, limit: f64) -> bool {
    (0.01 * limit..=limit).contains(&(value / 1000.0))
}

/// About the axis about which it is largest, m.
fn gyration(inertia_kgm2: &Matrix3<f64>, mass_kg: f64) -> f64 {
    (inertia_kgm2.symmetric_eigenvalues().max().max(0.0) / mass_kg).sqrt()
}

/// Jobs say where the joints between base and tip stand, and no others.
fn springs_off_the_chain(description: &Description, robot: &Robot) -> Option<Note> {
    let is_on_it = |name: &str| robot.joints().iter().any(|joint| joint.name == name);
    let springs = description.elastic_joints.iter().map(|spring| spring.joint.as_str());
    let off: Vec<&str> = springs.filter(|name| !is_on_it(name)).collect();
    (!off.is_empty()).then(|| {
        let what = format!(
            "has springs at joints that do not lie between base and tip: {}; they are taken to \
             stand at zero in every pose: name a tip behind them, or delete their springs",
            off.join(", ")
        );
        Note::warning(Code::AxisIgnored, Place::key(Part::Robot, "tip"), what)
    })
}

/// Links of a parallelogram and of a counterweight, which follow a joint of the arm.
fn joints_beside_the_arm(description: &Description, robot: &Robot) -> Option<Note> {
    let is_on_it = |name: &str| robot.joints().iter().any(|joint| joint.name == name);
    let beside = description.joints.iter().filter(|own| own.kind.moves() && !is_on_it(&own.name));
    let following: Vec<String> = beside
        .filter_map(|own| {
            let other = own.mimics.as_deref().filter(|other| is_on_it(other))?;
            carries_mass(description, &own.child).then(|| format!("{} follows {other}", own.name))
        })
        .collect();
    (!following.is_empty()).then(|| {
        let what = format!(
            "joints beside the arm are taken to stand still, at zero or at the limit nearest to \
             it: {}; their masses are elsewhere in fact",
            following.join(", ")
        );
        Note::warning(Code::HeldJoint, Place::part(Part::Robot), what)
    })
}

/// Whether a link or what it carries has mass.
fn carries_mass(description: &Description, link: &str) -> bool {
    let mut all = vec![link];
    let mut at = 0;
    while let Some(&own) = all.get(at) {
        at += 1;
        let found = description.links.iter().find(|link| link.name == own);
        if found.and_then(|link| link.inertial).is_some_and(|body| body.mass_kg > 0.0) {
            return true;
        }
        let below = description.joints.iter().filter(|joint| joint.parent == own);
        all.extend(below.map(|joint| joint.child.as_str()));
    }
    false
}

/// Springs that vary with what no job states: a check takes them at one level or temperature.
fn laws_of_conditions(robot: &Robot) -> Option<Note> {
    let varying = robot.coordinates().iter().filter_map(|own| {
        let at: Vec<String> = own.laws.iter().filter_map(StiffnessLaw::taken_at).collect();
        (!at.is_empty()).then(|| format!("{} at {}", own.name, at.join(" and ")))
    });
    let varying: Vec<String> = varying.collect();
    (!varying.is_empty()).then(|| {
        let what = format!(
            "springs vary with temperature or the level of vibration, and count as {}: frequencies \
             at others are not checked",
            varying.join(", ")
        );
        Note::warning(Code::Calibration, Place::key(Part::Robot, "corrections"), what)
    })
}

/// Nowhere that robots work does a body fall so fast.
fn strong_gravity(description: &Description) -> Option<Note> {
    const MOST_M_PER_S2: f64 = 30.0;
    let own = description.gravity_m_per_s2.norm();
    (description.gravity_stiffness && own > MOST_M_PER_S2).then(|| {
        let what = format!("gravity is {} m/s²; is it in mm/s²?", rounded(own, 4));
        Note::warning(Code::CadUnits, Place::key(Part::Gravity, "gravity_m_per_s2"), what)
    })
}

/// One joint of an arm may turn round several times, the last one; two do not.
fn limits_in_degrees(robot: &Robot) -> Option<Note> {
    const MOST_RAD: f64 = 4.0 * std::f64::consts::PI;
    let mut far = robot.joints().iter().filter_map(|joint| {
        let [from, to] = joint.limit.filter(|_| joint.kind == JointKind::Revolute)?;
        (from.abs().max(to.abs()) > MOST_RAD).then_some((joint, from, to))
    });
    let ((joint, from, to), _) = (far.next()?, far.next()?);
    let what = format!(
        "its limits are {} and {} rad, several turns, as are those of other joints; are they in \
         degrees?",
        rounded(from, 4),
        rounded(to, 4)
    );
    Some(Note::warning(Code::CadUnits, Place::key(Part::Joint(joint.name.clone()), "limit"), what))
}

/// Their compliance is not in the model.
fn joints_without_spring(robot: &Robot, rigid: &[String]) -> Option<Note> {
    let springs: Vec<usize> = robot.coordinates().iter().filter_map(|c| c.joint).collect();
    let joints = robot.joints().iter().enumerate();
    let without: Vec<&str> = joints
        .filter(|(index, joint)| !springs.contains(index) && !rigid.contains(&joint.name))
        .map(|(_, joint)| joint.name.as_str())
        .collect();
    (!without.is_empty()).then(|| {
        let what = format!(
            "rigid: {}; their compliance is not in the model: give their stiffness under \
             elasticity.joints, or name them in elasticity.rigid if they are meant to be rigid",
            without.join(", ")
        );
        Note::warning(Code::RigidJoint, Place::key(Part::Robot, "elasticity"), what)
    })
}
