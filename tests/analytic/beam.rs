//! A link that bends over its length against the beam of Euler and Bernoulli.

use crate::planar_arm::{L1, two_link};
use detune::model::{
    Carries, Cause, CoordinateKind, Correction, Description, Hinge, Inertial, Joint, Link,
    Placement, Robot,
};
use detune::modes::{ModalSolver, Statics};
use detune::notes::{Note, Part};
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

/// Of the whole link, N·m/rad: EI over its length.
const STIFFNESS: f64 = 4e5;
const LINK_KG: f64 = 40.0;

/// An arm of which the first link alone gives, with a mass on its end.
struct Bent {
    link_kg: f64,
    end_kg: f64,
    end_kgm2: f64,
    axes: Vec<Vector3<f64>>,
    carries: Carries,
    /// Inertia about itself over that across it.
    slender: f64,
}

impl Default for Bent {
    fn default() -> Self {
        Self {
            link_kg: LINK_KG,
            end_kg: 1.0,
            end_kgm2: 1e-9,
            axes: vec![Vector3::z()],
            carries: Carries::Part,
            slender: 0.02,
        }
    }
}

impl Bent {
    fn with(self, parameters: &[(&str, f64)]) -> Result<Robot, Vec<Note>> {
        Robot::new(&self.description(parameters))
    }

    fn description(self, parameters: &[(&str, f64)]) -> Description {
        let mut description =
            Description { elastic_joints: Vec::new(), tip: Some("two".to_owned()), ..two_link() };
        let rod = self.link_kg * L1 * L1 / 12.0;
        let about = Vector3::new(self.slender * rod, rod, rod);
        description.links[1].inertial = (self.link_kg > 0.0).then(|| Inertial {
            mass_kg: self.link_kg,
            com_m: Vector3::new(0.5 * L1, 0.0, 0.0),
            inertia_kgm2: Matrix3::from_diagonal(&about),
        });
        description.links[2].inertial = Some(Inertial {
            mass_kg: self.end_kg,
            com_m: Vector3::zeros(),
            inertia_kgm2: Matrix3::from_diagonal_element(self.end_kgm2),
        });
        let all = [&[("stiffness_nm_per_rad", STIFFNESS)], parameters].concat();
        description.corrections = vec![Correction {
            cause: Cause::LinkFlexibility,
            at: Some("one".to_owned()),
            parameters: all.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
            hinge: Some(Hinge {
                kind: CoordinateKind::Rotation,
                axes: self.axes,
                origin_m: Vector3::zeros(),
                carries: self.carries,
            }),
        }];
        description
    }
}

/// Of the end of the link, across it: under a force and under a moment there, m/N and 1/N.
fn compliances(parameters: &[(&str, f64)]) -> [f64; 2] {
    let robot = Bent::default().with(parameters).unwrap();
    let mut placement = Placement::new(&robot);
    placement.place(&robot, &[0.0, 0.0]);
    let found = Statics::of(&robot, &placement, &Point3::origin()).unwrap();
    [found.compliance_m_per_n[(1, 1)], found.compliance_m_per_nm[(1, 2)]]
}

/// Under a force F and a moment M on the end, EI y'' = F (L − x) + M. The compliance changes linearly over a length
/// about the middle and has its centre at a position; here it is summed over thin slices.
#[test]
fn a_link_that_bends_over_its_length_is_as_soft_as_a_beam() {
    const SLICES: usize = 2000;
    for (position, length) in [(0.5, 1.0), (0.4, 1.0), (0.65, 1.0), (0.5, 0.6), (0.45, 0.5)] {
        let taper = 6.0 * (position - 0.5) / length;
        let (mut force, mut moment) = (0.0, 0.0);
        for slice in 0..SLICES {
            let along = (slice as f64 + 0.5) / SLICES as f64 - 0.5;
            let soft = (1.0 + taper * 2.0 * along) / (STIFFNESS * SLICES as f64);
            let to_end = L1 * (0.5 - along * length);
            force += soft * to_end * to_end;
            moment += soft * to_end;
        }
        let found = compliances(&[("position", position), ("length", length)]);
        for (found, expected) in found.iter().zip([force, moment]) {
            assert!(
                (found / expected - 1.0).abs() < 1e-6,
                "{position} {length}: {found} {expected}"
            );
        }
    }
    // L³/3EI and L²/2EI.
    let uniform = compliances(&[("length", 1.0)]);
    assert!((uniform[0] / (L1 * L1 / (3.0 * STIFFNESS)) - 1.0).abs() < 1e-9, "{uniform:?}");
    assert!((uniform[1] / (L1 / (2.0 * STIFFNESS)) - 1.0).abs() < 1e-9, "{uniform:?}");
    // One hinge at the middle.
    let hinge = compliances(&[("position", 0.5)]);
    assert!((hinge[0] / (L1 * L1 / (4.0 * STIFFNESS)) - 1.0).abs() < 1e-9, "{hinge:?}");
}

/// First root of 1 + cos β cosh β + (M/m) β (cos β sinh β − sin β cosh β) = 0, of a clamped beam with a mass on its end
/// (Blevins, Formulas for Natural Frequency and Mode Shape, 1979, Table 8-8); f = β²/2π √(EI/mL³).
#[test]
fn a_bent_link_with_its_own_mass_rings_as_a_beam() {
    for end_kg in [10.0, 40.0, 160.0] {
        let left = |beta: f64| {
            1.0 + beta.cos() * beta.cosh()
                + end_kg / LINK_KG * beta * (beta.cos() * beta.sinh() - beta.sin() * beta.cosh())
        };
        let (mut low, mut high) = (0.1, 1.88);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if left(middle) > 0.0 { low = middle } else { high = middle }
        }
        let expected = low * low / std::f64::consts::TAU * (STIFFNESS / (LINK_KG * L1 * L1)).sqrt();
        let hz = |parameters: &[(&str, f64)]| {
            let robot = Bent { end_kg, ..Bent::default() }.with(parameters).unwrap();
            ModalSolver::new(&robot).frequencies_hz(&[0.0, 0.0]).unwrap()[0]
        };
        let found = hz(&[("length", 1.0)]);
        println!("{end_kg}: {} {}", found / expected, hz(&[("position", 0.5)]) / expected);
        assert!((found / expected - 1.0).abs() < 0.01, "{end_kg} kg: {found} {expected}");
    }
}

/// Turned about itself, a link is as soft as its spring says, whether it has inertia about itself or not.
#[test]
fn a_link_that_bends_and_turns_about_itself_has_modes() {
    for slender in [0.02, 0.0] {
        let axes = vec![Vector3::y(), Vector3::z(), Vector3::x()];
        let robot = Bent { slender, end_kg: 30.0, end_kgm2: 0.5, axes, ..Bent::default() };
        let robot = robot.with(&[("length", 1.0), ("ratio_3", 2.0)]).unwrap();
        let mut placement = Placement::new(&robot);
        placement.place(&robot, &[0.0, 0.0]);
        let hz = ModalSolver::new(&robot).frequencies_hz(&[0.0, 0.0]).map(<[f64]>::to_vec);
        let hz = hz.unwrap_or_else(|fault| panic!("{slender}: {fault}"));
        assert!(hz.len() >= 5 && hz.iter().all(|hz| hz.is_finite() && *hz > 1.0), "{hz:?}");
        // A force a metre beside the axis turns the end about it.
        let beside = Point3::new(0.0, 1.0, 0.0);
        let at =
            |point| Statics::of(&robot, &placement, &point).unwrap().compliance_m_per_n[(2, 2)];
        let turns = at(beside) - at(Point3::origin());
        assert!((turns * 2.0 * STIFFNESS - 1.0).abs() < 1e-9, "{slender}: {turns}");
    }
}

/// A counterweight at a quarter of the link stays before what bends beyond it: a part that is welded there changes as
/// much as a mass of its own does.
#[test]
fn what_is_fixed_to_a_link_bends_with_the_part_that_it_is_on() {
    let hz = |at: f64| {
        let mut description = Bent::default().description(&[("position", 0.5)]);
        let weight = Inertial {
            mass_kg: 35.0,
            com_m: Vector3::zeros(),
            inertia_kgm2: Matrix3::from_diagonal_element(0.1),
        };
        let (joint, link) = (&description.joints[2], &description.links[2]);
        let mut joint = Joint { name: "weld".into(), child: "weight".into(), ..joint.clone() };
        joint.parent = "one".into();
        joint.origin = Isometry3::translation(at * L1, 0.0, 0.0);
        let link = Link { name: "weight".into(), inertial: Some(weight), ..link.clone() };
        description.joints.push(joint);
        description.links.push(link);
        let robot = Robot::new(&description).unwrap();
        ModalSolver::new(&robot).frequencies_hz(&[0.0, 0.0]).unwrap()[0]
    };
    let plain = {
        let robot = Bent::default().with(&[("position", 0.5)]).unwrap();
        ModalSolver::new(&robot).frequencies_hz(&[0.0, 0.0]).unwrap()[0]
    };
    assert!((hz(0.25) / plain - 1.0).abs() < 1e-9, "{} {plain}", hz(0.25));
    assert!(hz(0.75) < 0.9 * plain, "{} {plain}", hz(0.75));
}

/// What no link can be is refused, at its key.
#[test]
fn a_length_that_no_link_has_is_refused() {
    let refused = |bent: Bent, at: &str, parameters: &[(&str, f64)]| {
        let mut description = bent.description(parameters);
        description.elastic_joints = two_link().elastic_joints;
        description.corrections[0].at = Some(at.to_owned());
        let faults = Robot::new(&description).map(|_| ()).unwrap_err();
        faults.iter().map(|fault| fault.what.clone()).collect::<Vec<_>>().join("; ")
    };
    for (bent, parameters, what) in [
        (
            Bent::default(),
            [("length", -1.0), ("position", 0.5)],
            "length is -1, must be from 0.2 to 1",
        ),
        (
            Bent::default(),
            [("length", 1.0), ("position", 0.9)],
            "position is 0.9, must be from 0.333 to 0.667",
        ),
        (
            Bent { carries: Carries::Link, ..Bent::default() },
            [("length", 1.0), ("position", 0.5)],
            "carries is link, must be part",
        ),
        (
            Bent { link_kg: 0.0, ..Bent::default() },
            [("length", 1.0), ("position", 0.5)],
            "has no mass to bend",
        ),
    ] {
        let told = refused(bent, "one", &parameters);
        assert!(told.contains(what), "{told}");
    }
    // Where no tip is named, it is the farthest link that a joint moves.
    let mut of_no_tip = Bent::default().description(&[("position", 0.5)]);
    of_no_tip.elastic_joints = two_link().elastic_joints;
    of_no_tip.joints.reverse();
    let moved = |joint: &&Joint| joint.kind.moves();
    let deepest = of_no_tip.joints.iter().filter(moved).find(|joint| {
        !of_no_tip.joints.iter().any(|other| other.kind.moves() && other.parent == joint.child)
    });
    of_no_tip.corrections[0].at = deepest.map(|joint| joint.child.clone());
    of_no_tip.tip = None;
    let faults = Robot::new(&of_no_tip).map(|_| ()).unwrap_err();
    assert!(faults.iter().any(|fault| fault.what.contains("at is the tip's link")), "{faults:?}");
    let mut twice = Bent::default().description(&[("position", 0.5)]);
    twice.elastic_joints = two_link().elastic_joints;
    twice.corrections.push(twice.corrections[0].clone());
    let faults = Robot::new(&twice).map(|_| ()).unwrap_err();
    let told: Vec<_> =
        faults.iter().map(|fault| (&fault.place.part, fault.what.as_str())).collect();
    let [(Some(Part::Correction(1)), what)] = told[..] else { panic!("{told:?}") };
    assert!(what.contains("correction 1 is link_flexibility there already"), "{what}");
    for parameters in [[("length", 1.0)], [("position", 0.5)]] {
        let told = refused(Bent::default(), "two", &parameters);
        assert!(told.contains("at is the tip's link"), "{told}");
    }
}
