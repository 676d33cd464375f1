//! The general path (`model` and `modes`) against the closed form of the paper (`two_link`), and the
//! closed form against independently computed figures.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::arms::{OTHER, gravity, two_link_arm};
use crate::two_link::{TABLE_1, TABLE_1_BETA1_RAD};
use detune::model::{Placement, gravity_stiffness, mass_matrix, potential, potential_gradient};
use detune::modes::{ModalSolver, Statics};
use nalgebra::{DMatrix, Matrix2, Point3, Vector3};

/// −π to π in `steps` steps.
fn circle(steps: u32) -> impl Iterator<Item = f64> {
    (0..=steps).map(move |i| -PI + 2.0 * PI * f64::from(i) / f64::from(steps))
}

/// Table 1 in Eqs. (30), (32) and (43), solved outside this crate by `numpy.linalg.eig` of M⁻¹ K; the
/// printed Table 2 is different.
#[test]
fn table_1_gives_these_frequencies_and_not_those_of_table_2() {
    for (beta2, f1, f2) in [(0.174, 21.88, 413.24), (1.571, 25.76, 84.18), (2.618, 28.77, 144.68)] {
        let [g1, g2] = TABLE_1.natural_frequencies_hz(beta2);
        assert!((g1 - f1).abs() <= 0.005, "f1 at {beta2}: {g1}, expected {f1}");
        assert!((g2 - f2).abs() <= 0.005, "f2 at {beta2}: {g2}, expected {f2}");
    }
}

#[test]
fn frequencies_satisfy_the_printed_characteristic_equation() {
    for parameters in [TABLE_1, OTHER] {
        let [a1, a2, a3] = parameters.inertia_terms_kgm2();
        let [k1, k2] = parameters.stiffness_nm_per_rad;
        for beta2 in circle(720) {
            let d1 = a1 * k2 + 2.0 * a2 * k2 * beta2.cos() + a3 * k1;
            let d2 = a1 * a3 - a3 * a3 - (a2 * beta2.cos()).powi(2);
            for f in parameters.natural_frequencies_hz(beta2) {
                let squared = (2.0 * PI * f).powi(2);
                let terms = [d2 * squared * squared, -d1 * squared, k1 * k2];
                let scale = terms.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
                let left: f64 = terms.iter().sum();
                // d2 as printed loses a1 a3 / d2 ≤ 600 roundings near β2 = 0.
                assert!(left.abs() < 1e-12 * scale, "β2 = {beta2}: {left} of {scale}");
            }
        }
    }
}

#[test]
fn the_general_path_gives_equation_45_at_every_beta2() {
    for parameters in [TABLE_1, OTHER] {
        let robot = two_link_arm(&parameters, false);
        let mut solver = ModalSolver::new(&robot);
        let mut worst = 0.0_f64;
        for beta1 in [TABLE_1_BETA1_RAD, 0.0, -1.1, 3.0] {
            for beta2 in circle(3600) {
                let expected = parameters.natural_frequencies_hz(beta2);
                let found = solver.frequencies_hz(&[beta1, beta2]).unwrap();
                for (f, e) in found.iter().zip(expected) {
                    worst = worst.max((f / e - 1.0).abs());
                }
            }
        }
        assert!(worst < 1e-10, "relative error {worst:e}");
    }
}

#[test]
fn the_mass_matrix_is_equation_30() {
    for parameters in [TABLE_1, OTHER] {
        let robot = two_link_arm(&parameters, false);
        let mut placement = Placement::new(&robot);
        let mut m = DMatrix::zeros(2, 2);
        for beta1 in [TABLE_1_BETA1_RAD, -0.4] {
            for beta2 in circle(360) {
                for alpha in [[0.0, 0.0], [0.02, -0.05]] {
                    placement.place_deflected(&robot, &[beta1, beta2], &alpha);
                    mass_matrix(&robot, &placement, &mut m);
                    let expected = parameters.mass_matrix_kgm2(beta2 + alpha[1]);
                    let error = (m.fixed_view::<2, 2>(0, 0) - expected).amax();
                    assert!(error < 1e-13 * expected.amax(), "β2 = {beta2}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn static_deflections_are_equations_12_and_13() {
    for parameters in [TABLE_1, OTHER] {
        let robot = two_link_arm(&parameters, true);
        let gravity = gravity(&parameters);
        let mut placement = Placement::new(&robot);
        let mut gradient = [0.0; 2];
        for beta1 in circle(24) {
            for beta2 in circle(72) {
                placement.place(&robot, &[beta1, beta2]);
                potential_gradient(&robot, &placement, &mut gradient);
                let expected = parameters.static_deflections_rad(&gravity, beta1, beta2);
                for i in 0..2 {
                    let found = -gradient[i] / parameters.stiffness_nm_per_rad[i];
                    let error = (found - expected[i]).abs();
                    // Deflections are some 1e-3 rad.
                    assert!(error < 1e-17, "β = {beta1}, {beta2}: {error:e}");
                }
            }
        }
    }
}

/// The same as `detune deflection` tells it; two of the compliance's axes lie in the arm's plane, and the
/// softest gives C = J K⁻¹ Jᵀ its norm.
#[test]
fn the_sag_is_equations_12_and_13_and_the_compliance_that_of_the_jacobian() {
    for parameters in [TABLE_1, OTHER] {
        let robot = two_link_arm(&parameters, false);
        let gravity = gravity(&parameters);
        for (beta1, beta2) in [(0.3, 1.1), (2.0, -0.4), (-1.2, 2.5)] {
            let mut placement = Placement::new(&robot);
            placement.place(&robot, &[beta1, beta2]);
            let statics = Statics::of(&robot, &placement, &Point3::origin()).unwrap();
            let expected = parameters.static_deflections_rad(&gravity, beta1, beta2);
            for (found, expected) in statics.sag.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-16, "{found} {expected}");
            }
            let [soft, middle, stiff] = statics.principal;
            let first = statics.compliance_m_per_n * Vector3::from(soft.direction);
            assert!((first.norm() / soft.compliance_m_per_n - 1.0).abs() < 1e-12);
            assert!(soft.compliance_m_per_n >= middle.compliance_m_per_n);
            assert!(stiff.compliance_m_per_n <= 1e-12 * soft.compliance_m_per_n);
        }
    }
}

/// Eqs. (5)–(6) as they stand, without (7)–(8): values against `potential`, second central differences
/// against both K_g. Step 1e-3 rad: truncation 1e-6/12·4, rounding 4 ε V / h².
#[test]
fn gravity_stiffness_is_the_curvature_of_the_exact_potential() {
    for parameters in [TABLE_1, OTHER] {
        let robot = two_link_arm(&parameters, true);
        let gravity = gravity(&parameters);
        let scale = parameters.gravity_stiffness_nm_per_rad(&gravity, FRAC_PI_2, 0.0).amax();
        let v = |b1: f64, b2: f64, x: f64, y: f64| {
            parameters.gravity_potential_j(&gravity, b1 + x, b2 + y)
        };
        let mut placement = Placement::new(&robot);
        let mut k = DMatrix::zeros(2, 2);
        let h = 1e-3;
        for beta1 in circle(12) {
            for beta2 in circle(24) {
                placement.place(&robot, &[beta1, beta2]);
                let error = (potential(&robot, &placement) - v(beta1, beta2, 0.0, 0.0)).abs();
                assert!(error < 1e-13 * scale, "potential: {error:e}");

                gravity_stiffness(&robot, &placement, &mut k);
                let at = |x: f64, y: f64| v(beta1, beta2, x, y);
                let xx = (at(h, 0.0) - 2.0 * at(0.0, 0.0) + at(-h, 0.0)) / (h * h);
                let yy = (at(0.0, h) - 2.0 * at(0.0, 0.0) + at(0.0, -h)) / (h * h);
                let xy = (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4.0 * h * h);
                let difference = Matrix2::new(xx, xy, xy, yy);
                let closed = parameters.gravity_stiffness_nm_per_rad(&gravity, beta1, beta2);
                assert!((closed - difference).amax() < 1e-6 * scale);
                assert!((k.fixed_view::<2, 2>(0, 0) - closed).amax() < 1e-13 * scale);
            }
        }
    }
}

/// With gravity the frequencies of the general path are those of (M, K + K_g) in closed form, and depend
/// on β1, which the paper's linearisation denies.
#[test]
fn with_gravity_the_frequencies_depend_on_beta1() {
    let robot = two_link_arm(&TABLE_1, true);
    let gravity = gravity(&TABLE_1);
    let mut solver = ModalSolver::new(&robot);
    let mut range = [f64::INFINITY, 0.0_f64];
    for beta1 in circle(36) {
        let beta2 = 1.0;
        let m = TABLE_1.mass_matrix_kgm2(beta2);
        let k = TABLE_1.stiffness_matrix_nm_per_rad()
            + TABLE_1.gravity_stiffness_nm_per_rad(&gravity, beta1, beta2);
        let product = m.try_inverse().unwrap() * k;
        let (half, det) = (0.5 * product.trace(), product.determinant());
        let root = (half * half - det).sqrt();
        let found = solver.frequencies_hz(&[beta1, beta2]).unwrap();
        for (f, squared) in found.iter().zip([half - root, half + root]) {
            let expected = squared.sqrt() / (2.0 * PI);
            assert!((f / expected - 1.0).abs() < 1e-10, "{f} against {expected}");
        }
        range = [range[0].min(found[0]), range[1].max(found[0])];
    }
    // K_g is at most ±(m1 lc1 + m2 (l1 + lc2)) g = ±375 N·m/rad beside 555,000: ±0.03 % of f1.
    let spread = range[1] / range[0] - 1.0;
    assert!((1e-4..1e-3).contains(&spread), "{spread}");
}

#[test]
fn shapes_solve_equation_42_and_agree_with_the_general_path() {
    for parameters in [TABLE_1, OTHER] {
        let robot = two_link_arm(&parameters, false);
        let mut solver = ModalSolver::new(&robot);
        let k = parameters.stiffness_matrix_nm_per_rad();
        for beta2 in circle(720) {
            let closed = parameters.modes(beta2);
            assert_eq!(closed.natural_frequencies_hz, parameters.natural_frequencies_hz(beta2));
            let m = parameters.mass_matrix_kgm2(beta2);
            let general = solver.solve(&[0.3, beta2]).unwrap();
            for r in 0..2 {
                let shape = closed.shapes[r];
                let squared = (2.0 * PI * closed.natural_frequencies_hz[r]).powi(2);
                let residual = k * shape - m * shape * squared;
                assert!(residual.amax() < 1e-11 * (m * shape * squared).amax(), "β2 = {beta2}");
                let other = general.shapes.column(r);
                let cross = shape[0] * other[1] - shape[1] * other[0];
                assert!(cross.abs() < 1e-10 * other.amax(), "β2 = {beta2}, mode {}", r + 1);
            }
        }
    }
}

/// What Fig. 4 says, and where Table 1 agrees: relative angles change sides where M12 = 0, at
/// |β2| = acos(−a3 / a2) = 99.15°; the links' turns in space are together in the first mode everywhere.
#[test]
fn directions_of_the_links_in_the_two_modes() {
    let [_, a2, a3] = TABLE_1.inertia_terms_kgm2();
    let turning_point = (-a3 / a2).acos();
    assert!((turning_point.to_degrees() - 99.15).abs() < 0.005);
    for beta2 in circle(720) {
        let near = beta2.abs() < turning_point;
        let [first, second] = TABLE_1.modes(beta2).shapes;
        assert_eq!(first[0] * first[1] > 0.0, near, "relative, first, β2 = {beta2}");
        assert_eq!(second[0] * second[1] < 0.0, near, "relative, second, β2 = {beta2}");
        let [in_space_1, in_space_2] = [first, second].map(|s| s[0] * (s[0] + s[1]) > 0.0);
        assert!(in_space_1, "in space, first, β2 = {beta2}");
        assert_eq!(in_space_2, !near, "in space, second, β2 = {beta2}");
    }
}

/// f1 rises with |β2|, as the text says; f2 falls only as far as the point where M12 = 0.
#[test]
fn the_first_frequency_rises_and_the_second_has_a_minimum() {
    let [_, a2, a3] = TABLE_1.inertia_terms_kgm2();
    let turning_point = (-a3 / a2).acos();
    let scan: Vec<(f64, [f64; 2])> = (0..=1800)
        .map(|i| PI * f64::from(i) / 1800.0)
        .map(|beta2| (beta2, TABLE_1.natural_frequencies_hz(beta2)))
        .collect();
    assert!(scan.windows(2).all(|w| w[1].1[0] > w[0].1[0]));
    let lowest = scan.iter().min_by(|a, b| a.1[1].total_cmp(&b.1[1])).unwrap();
    assert!((lowest.0 - turning_point).abs() < 2e-2, "minimum of f2 at {}", lowest.0);
}

/// Eq. (46) with Eq. (30): M α̈ + C α̇ + K α is zero, and C as printed makes Ṁ − 2C skew, so that no
/// energy is lost.
#[test]
fn equation_46_solves_equation_28_and_keeps_the_energy() {
    for beta2 in circle(48) {
        let alpha = nalgebra::Vector2::new(0.03, -0.05);
        let rates = nalgebra::Vector2::new(3.0, -7.0);
        let q2 = beta2 + alpha[1];
        let m = TABLE_1.mass_matrix_kgm2(q2);
        let c = TABLE_1.velocity_matrix_nms(q2, &rates);
        let acceleration = TABLE_1.acceleration_rad_per_s2(beta2, &alpha, &rates);
        let spring = TABLE_1.stiffness_matrix_nm_per_rad() * alpha;
        let left = m * acceleration + c * rates + spring;
        assert!(left.amax() < 1e-12 * spring.amax(), "β2 = {beta2}: {left}");

        let h = 1e-6;
        let change = (TABLE_1.mass_matrix_kgm2(q2 + h) - TABLE_1.mass_matrix_kgm2(q2 - h))
            * (rates[1] / (2.0 * h));
        let skew = change - c * 2.0;
        assert!((skew + skew.transpose()).amax() < 1e-7, "β2 = {beta2}: {skew}");
    }
}
