//! The mass of a whole arm shared out to links without inertial, against closed forms.

use detune::model::{Inertial, Robot};
use detune::modes::Modes;
use nalgebra::{Matrix3, Vector3};

use crate::planar_arm::{L1, L2, two_link};

fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{a} is not {b}");
}

/// Moments of a uniform box, cylinder and sphere, by sums over small cells.
#[test]
fn simple_shapes_have_the_moments_of_their_cells() {
    const CELLS: i32 = 60;
    let cells = |half: [f64; 3], inside: &dyn Fn(Vector3<f64>) -> bool| {
        let at = |i: i32, half: f64| half * (f64::from(2 * i + 1) / f64::from(CELLS) - 1.0);
        let mut sums = (0.0, Matrix3::zeros());
        let cell = half.iter().map(|half| 2.0 * half / f64::from(CELLS)).product::<f64>();
        for (i, j, k) in (0..CELLS)
            .flat_map(|i| (0..CELLS).flat_map(move |j| (0..CELLS).map(move |k| (i, j, k))))
        {
            let r = Vector3::new(at(i, half[0]), at(j, half[1]), at(k, half[2]));
            if inside(r) {
                sums.0 += cell;
                sums.1 += cell * (Matrix3::identity() * r.norm_squared() - r * r.transpose());
            }
        }
        sums
    };
    let round = |r: Vector3<f64>| r.x.hypot(r.y);
    for (body, (volume, inertia)) in [
        (Inertial::cuboid([0.2, 0.5, 0.9]), cells([0.1, 0.25, 0.45], &|_| true)),
        (Inertial::cylinder(0.3, 0.8), cells([0.3, 0.3, 0.4], &|r| round(r) < 0.3)),
        (Inertial::sphere(0.4), cells([0.4; 3], &|r| r.norm() < 0.4)),
    ] {
        assert!((body.mass_kg / volume - 1.0).abs() < 0.01, "{body:?}, {volume}");
        let scale = body.inertia_kgm2.norm();
        assert!((body.inertia_kgm2 - inertia).norm() < 0.01 * scale, "{body:?}, {inertia}");
        assert_eq!(body.com_m, Vector3::zeros());
    }
}

#[test]
fn mass_is_shared_by_volume_where_shapes_are_known() {
    let mut arm = two_link();
    let mut slab = Inertial::cuboid([0.6, 0.1, 0.1]);
    slab.com_m = Vector3::new(0.3, 0.0, 0.0);
    for (link, shape) in arm.links[1..3].iter_mut().zip([slab, Inertial::cuboid([0.2; 3])]) {
        (link.inertial, link.shape, link.has_geometry) = (None, Some(shape), true);
    }
    let note = arm.share_mass(42.0).unwrap();
    assert!(note.what.contains("by volume") && note.what.contains("one 18.000, two 24.000 kg"));
    let one = arm.links[1].inertial.unwrap();
    near(one.mass_kg, 18.0);
    near(one.inertia_kgm2[(1, 1)], 18.0 / 12.0 * (0.36 + 0.01));
    assert_eq!(one.com_m, slab.com_m);
    assert!(arm.links[1].assumed && arm.links[2].assumed && !arm.links[0].assumed);
    let robot = Robot::new(&arm).unwrap();
    assert!(robot.bodies().iter().all(|body| body.assumed));
    assert_eq!((arm.links[0].inertial, arm.links[3].inertial), (None, None));
}

/// Rods of one thickness: 42 kg by 0.63 to 0.9 m, and a tenth of the longest without a length.
#[test]
fn mass_is_shared_by_length_where_shapes_are_not_known() {
    let mut arm = two_link();
    for link in &mut arm.links {
        (link.inertial, link.has_geometry) = (None, true);
    }
    arm.links[1].shape = Some(Inertial::sphere(0.1));
    assert!(arm.share_mass(42.0).unwrap().what.contains("by length"));
    let bodies: Vec<Inertial> = arm.links.iter().map(|link| link.inertial.unwrap()).collect();
    let lengths = [0.1 * L2, L1, L2, 0.1 * L2];
    let all: f64 = lengths.iter().sum();
    for (body, length) in bodies.iter().zip(lengths) {
        near(body.mass_kg, 42.0 * length / all);
    }
    near(bodies.iter().map(|body| body.mass_kg).sum(), 42.0);
    // 2000 kg/m³: the section is that of all mass over all length.
    let round_m2 = 42.0 / (std::f64::consts::PI * 2000.0 * all);
    let two = &bodies[2];
    near(two.com_m.x, L2 / 2.0);
    near(two.inertia_kgm2[(0, 0)], two.mass_kg * round_m2 / 2.0);
    near(two.inertia_kgm2[(1, 1)], two.mass_kg * (3.0 * round_m2 + L2 * L2) / 12.0);
    near(two.inertia_kgm2[(2, 2)], two.inertia_kgm2[(1, 1)]);
    let robot = Robot::new(&arm).unwrap();
    let modes = Modes::at(&robot, &[0.3, 0.7]).unwrap();
    assert!(modes.natural_frequencies_hz.iter().all(|f| f.is_finite() && *f > 1.0), "{modes:?}");
}

#[test]
fn what_is_left_is_shared_and_what_is_not_left_is_refused() {
    let mut arm = two_link();
    assert!(arm.clone().share_mass(50.0).unwrap_err().what.contains("more than the 60.58 kg"));
    arm.links[2].inertial = None;
    assert!(arm.clone().share_mass(10.0).unwrap_err().what.contains("more than the 10 kg"));
    arm.links[2].has_geometry = true;
    assert!(arm.share_mass(30.0).is_ok());
    near(arm.links[2].inertial.unwrap().mass_kg, 20.0);
    assert_eq!(arm.links[1].inertial.unwrap().mass_kg, 10.0);
    assert!(arm.share_mass(50.0).unwrap_err().what.contains("no link lacks an inertial"));
}
