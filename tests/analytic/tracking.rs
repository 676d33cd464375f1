//! Modes that cross keep their names; modes that veer keep their order; neither is ever silent.

use std::sync::Arc;

use detune::model::{CoordinateKind, ExtraCoordinate, Inertial, Joint, JointKind, Link, Robot};
use detune::modes::{ModalSolver, Modes, mac};
use detune::motion::{Move, Target, Timing, Work};
use detune::path::{Path, follow, grid};
use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::planar_arm::{M2, closed_form_hz, two_link};

/// The planar arm on a foundation that gives along `axis`. Across the plane (y) it has a mode of its own,
/// √(k/m)/2π at every pose, which the arm's first mode crosses as β2 opens. Tilted by a little, the two are
/// coupled and veer.
fn on_foundation(axis: Vector3<f64>) -> Robot {
    let mut description = two_link();
    let f = closed_form_hz(1.3)[0];
    let mass = 10.0 + M2;
    description.extra.push(ExtraCoordinate {
        name: "foundation".into(),
        link: "base".into(),
        kind: CoordinateKind::Translation,
        axis,
        origin_m: Vector3::zeros(),
        stiffness: mass * (std::f64::consts::TAU * f).powi(2),
        std: None,
        damping: None,
    });
    Robot::new(&description).unwrap()
}

fn sweep() -> Vec<Move> {
    [0.2, 2.4]
        .iter()
        .map(|beta2| Move {
            to: Target::Joints(vec![0.5, *beta2]),
            feed_m_per_s: 0.01,
            tcp: Isometry3::identity(),
            work: Work::Stands,
            line: 1,
            timing: Timing::Feed,
            spindle_turns: true,
            stated: Arc::default(),
        })
        .collect()
}

#[test]
fn crossing_modes_keep_their_names() {
    let robot = on_foundation(Vector3::y());
    let path = Path::plan(&robot, &sweep(), None).unwrap();
    let stations = grid(&path, std::iter::empty());
    let families = follow(&path, &stations).unwrap();
    let [exchange] = families.exchanges.as_slice() else { panic!("{:?}", families.exchanges) };
    assert_eq!(exchange.lower_mode, 0);
    // The crossing lies where the closed form says: β2 = 1.3.
    let mut q = [0.0; 2];
    path.reader().at(exchange.s, &mut q).unwrap();
    assert!((q[1] - 1.3).abs() < 1e-5, "exchange at beta2 = {}", q[1]);
    assert_eq!(families.of.first().unwrap(), &[Some(0), Some(1), Some(2)]);
    assert_eq!(families.of.last().unwrap(), &[Some(1), Some(0), Some(2)]);
    // Family 0 is the arm's first mode all along.
    for (s, of) in stations.iter().zip(&families.of) {
        path.reader().at(*s, &mut q).unwrap();
        let modes = Modes::at(&robot, &q).unwrap();
        let at = of.iter().position(|family| *family == Some(0)).unwrap();
        let expected = closed_form_hz(q[1])[0];
        assert!((modes.natural_frequencies_hz[at] / expected - 1.0).abs() < 1e-9, "at s = {s}");
    }
}

#[test]
fn veering_modes_keep_their_order_and_trade_shapes() {
    let robot = on_foundation(Vector3::new(0.004, 1.0, 0.003));
    let path = Path::plan(&robot, &sweep(), None).unwrap();
    // A look so coarse that the shapes of neighbours hardly resemble each other.
    let stations = [0.0, 0.5, 1.0];
    let families = follow(&path, &stations).unwrap();
    assert_eq!(families.exchanges, []);
    assert_eq!(families.of.last().unwrap(), &[Some(0), Some(1), Some(2)]);
    // Without looking between, the first mode at one end resembles the second at the other.
    let mut solver = ModalSolver::new(&robot);
    let start = solver.solve(&[0.5, 0.2]).unwrap().clone();
    let end = solver.solve(&[0.5, 2.4]).unwrap().clone();
    let resemblance = mac(solver.mass(), start.shapes.column(0), end.shapes.column(1));
    assert!(resemblance > 0.9, "the case does not veer: MAC {resemblance}");
}

/// Two modes that coincide at every pose have no shapes of their own; the search for them ends, and the
/// arm's own modes keep their names.
#[test]
fn modes_that_always_coincide_are_not_chased() {
    let mut description = two_link();
    for name in ["left", "right"] {
        description.links.push(Link {
            name: name.into(),
            inertial: Some(Inertial {
                mass_kg: 2.0,
                com_m: Vector3::zeros(),
                inertia_kgm2: Matrix3::identity(),
            }),
            ..Link::default()
        });
        description.joints.push(Joint {
            name: format!("{name}_mount"),
            kind: JointKind::Fixed,
            child: name.into(),
            parent: "base".into(),
            ..description.joints[2].clone()
        });
        description.extra.push(ExtraCoordinate {
            name: format!("{name}_spring"),
            link: name.into(),
            kind: CoordinateKind::Translation,
            axis: Vector3::z(),
            origin_m: Vector3::zeros(),
            stiffness: 2.0 * (std::f64::consts::TAU * 5.0).powi(2),
            std: None,
            damping: None,
        });
    }
    let robot = Robot::new(&description).unwrap();
    let path = Path::plan(&robot, &sweep(), None).unwrap();
    let stations = grid(&path, std::iter::empty());
    let families = follow(&path, &stations).unwrap();
    for of in &families.of {
        assert_eq!(of[2..], [Some(2), Some(3)]);
    }
    assert_eq!(families.exchanges, []);
}

/// Which way a joint's axis is written does not change which way its link turns.
#[test]
fn turning_together_does_not_depend_on_the_sign_of_an_axis() {
    let written = two_link();
    let mut other_way = written.clone();
    other_way.joints[1].axis = -other_way.joints[1].axis;
    let (a, b) = (Robot::new(&written).unwrap(), Robot::new(&other_way).unwrap());
    let (mut first, mut second) = (ModalSolver::new(&a), ModalSolver::new(&b));
    first.solve(&[0.3, 1.0]).unwrap();
    second.solve(&[0.3, -1.0]).unwrap();
    for (r, together) in [(0, true), (1, false)] {
        for solver in [&first, &second] {
            let found = solver.modes().turn_together(solver.placement(), r, 0, 1);
            assert_eq!(found, Some(together), "mode {r}");
        }
    }
}
