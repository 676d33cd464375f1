//! Laws that hold for every robot and pose, on robots made at random, each algorithm against another
//! one. Tolerances are relative to the size of what is compared and stand above what was seen by a factor
//! of ten or more.

use std::collections::BTreeMap;

use crate::random_robot::{bodies, description, frames, isometry, numbers, pose, pseudo_inertia};
use detune::model::{
    CoordinateKind, Description, ExtraCoordinate, Joint, JointKind, Link, Placement, PoseFault,
    Robot, elastic_jacobian, gravity_stiffness, inverse_dynamics, joint_jacobian, mass_matrix,
    potential, potential_gradient,
};
use detune::modes::{ModalSolver, Modes, Statics, mac, tip_receptance_m_per_n};
use detune::uncertainty::{ArmAtPose, Parameter, Scales};
use nalgebra::{Complex, DMatrix, DVector, Matrix6xX, Point3, Unit, Vector3};

/// Robots tried by each test.
const ROBOTS: u64 = 60;

/// Sums of some hundred products of well-scaled numbers; 3e-14 was the worst seen.
const EXACT: f64 = 1e-12;

struct Case {
    seed: u64,
    description: Description,
    robot: Robot,
    q: Vec<f64>,
    placement: Placement,
    m: DMatrix<f64>,
}

fn case(seed: u64, description: Description) -> Case {
    let robot = Robot::new(&description).unwrap_or_else(|faults| panic!("{seed}: {faults:?}"));
    let q = pose(&robot, seed);
    let n = robot.coordinates().len();
    let mut placement = Placement::new(&robot);
    placement.place(&robot, &q);
    let mut m = DMatrix::zeros(n, n);
    mass_matrix(&robot, &placement, &mut m);
    Case { seed, description, robot, q, placement, m }
}

fn cases() -> impl Iterator<Item = Case> {
    (0..ROBOTS).map(|seed| case(seed, description(seed)))
}

impl Case {
    fn size(&self) -> usize {
        self.robot.coordinates().len()
    }

    fn named_pose(&self) -> BTreeMap<&str, f64> {
        self.robot.joints().iter().zip(&self.q).map(|(j, &q)| (j.name.as_str(), q)).collect()
    }

    fn deflected(&self, alpha: &[f64]) -> Placement {
        let mut placement = Placement::new(&self.robot);
        placement.place_deflected(&self.robot, &self.q, alpha);
        placement
    }

    fn frequencies(&self) -> Vec<f64> {
        frequencies(&self.robot, &self.q)
    }
}

fn frequencies(robot: &Robot, q: &[f64]) -> Vec<f64> {
    ModalSolver::new(robot).frequencies_hz(q).expect("modes").to_vec()
}

fn assert_close(what: &str, seed: u64, found: f64, expected: f64, scale: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * scale,
        "robot {seed}: {what}: {found} against {expected} (scale {scale})"
    );
}

#[test]
fn mass_matrix_is_symmetric_and_positive_definite() {
    let mut sizes = Vec::new();
    for c in cases() {
        assert_eq!(c.m, c.m.transpose(), "robot {}", c.seed);
        assert!(c.m.clone().cholesky().is_some(), "robot {}: {}", c.seed, c.m);
        sizes.push(c.size());
    }
    // The robots must be worth the trial.
    assert!(sizes.iter().max() >= Some(&9) && sizes.iter().min() <= Some(&2), "{sizes:?}");
}

/// Column j of M is the force that a unit acceleration of coordinate j takes, at rest.
#[test]
fn mass_matrix_agrees_with_inverse_dynamics() {
    for c in cases() {
        let n = c.size();
        let rest = vec![0.0; n];
        for j in 0..n {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            let mut column = vec![0.0; n];
            inverse_dynamics(&c.robot, &c.placement, &rest, &unit, &mut column);
            for (i, force) in column.iter().enumerate() {
                let scale = (c.m[(i, i)] * c.m[(j, j)]).sqrt();
                assert_close("M", c.seed, c.m[(i, j)], *force, scale, EXACT);
            }
        }
    }
}

/// M_ij = Σ tr(∂T/∂α_i · J · ∂T/∂α_jᵀ) over the bodies, with homogeneous matrices T and pseudo-inertias J
/// (Uicker 1965): no spatial vectors, no composite bodies, no lumping of links, no code of the crate.
#[test]
fn mass_matrix_agrees_with_homogeneous_jacobians() {
    for c in cases() {
        let q = c.named_pose();
        let n = c.size();
        let names: Vec<&str> = c.robot.coordinates().iter().map(|c| c.name.as_str()).collect();
        let moved: Vec<_> = names.iter().map(|name| frames(&c.description, &q, name)).collect();
        for i in 0..n {
            for j in 0..=i {
                let mut expected: f64 = bodies(&c.description)
                    .map(|(link, body)| {
                        (moved[i][link].1 * pseudo_inertia(body) * moved[j][link].1.transpose())
                            .trace()
                    })
                    .sum();
                if i == j {
                    let drive = c.description.drives.iter().find(|d| d.joint == names[i]);
                    expected += drive.map_or(0.0, |d| d.reflected_inertia_kgm2);
                }
                let scale = (c.m[(i, i)] * c.m[(j, j)]).sqrt();
                assert_close("M", c.seed, c.m[(i, j)], expected, scale, EXACT);
            }
        }
    }
}

/// Power balance of the nonlinear dynamics: α̇ᵀ τ = d/dt (½ α̇ᵀ M α̇), the right side by a central
/// difference along the motion α̇ + α̈ t.
#[test]
fn inverse_dynamics_balances_power() {
    const H: f64 = 1e-5;
    for c in cases() {
        let n = c.size();
        let (alpha, rate) = (numbers(n, c.seed), numbers(n, c.seed + 1000));
        let acceleration = numbers(n, c.seed + 2000);
        let mut force = vec![0.0; n];
        inverse_dynamics(&c.robot, &c.deflected(&alpha), &rate, &acceleration, &mut force);
        let power: f64 = force.iter().zip(&rate).map(|(f, r)| f * r).sum();
        let energy = |t: f64| {
            let at: Vec<f64> =
                (0..n).map(|i| alpha[i] + rate[i] * t + 0.5 * acceleration[i] * t * t).collect();
            let v = DVector::from_fn(n, |i, _| rate[i] + acceleration[i] * t);
            let mut m = DMatrix::zeros(n, n);
            mass_matrix(&c.robot, &c.deflected(&at), &mut m);
            0.5 * (v.transpose() * m * v)[(0, 0)]
        };
        let expected = (energy(H) - energy(-H)) / (2.0 * H);
        // The difference loses eleven of sixteen digits of the energy.
        let scale = power.abs() + energy(0.0) * 10.0;
        assert_close("power", c.seed, power, expected, scale, 1e-9);
    }
}

#[test]
fn gravity_torque_and_stiffness_are_derivatives_of_the_potential() {
    const H: f64 = 1e-4;
    for c in cases() {
        let n = c.size();
        let at = |steps: &[(usize, f64)]| {
            let mut alpha = vec![0.0; n];
            for &(i, s) in steps {
                alpha[i] += s * H;
            }
            potential(&c.robot, &c.deflected(&alpha))
        };
        let mut gradient = vec![0.0; n];
        potential_gradient(&c.robot, &c.placement, &mut gradient);
        let mut k = DMatrix::zeros(n, n);
        gravity_stiffness(&c.robot, &c.placement, &mut k);
        assert_eq!(k, k.transpose(), "robot {}", c.seed);
        // Weight times reach: the size of either.
        let scale = 9.81 * c.robot.moving_mass_kg() * 3.0;
        for i in 0..n {
            let slope = (at(&[(i, 1.0)]) - at(&[(i, -1.0)])) / (2.0 * H);
            assert_close("gradient", c.seed, gradient[i], slope, scale, 1e-8);
            for j in 0..=i {
                let mixed = at(&[(i, 1.0), (j, 1.0)])
                    - at(&[(i, 1.0), (j, -1.0)])
                    - at(&[(i, -1.0), (j, 1.0)])
                    + at(&[(i, -1.0), (j, -1.0)]);
                // Truncation and rounding of the second difference are both near 1e-8.
                assert_close("K_g", c.seed, k[(i, j)], mixed / (4.0 * H * H), scale, 1e-7);
            }
        }
        assert!(k.amax() > 1e-3 * scale, "robot {}: gravity ought to do something", c.seed);
    }
}

/// Springs, gravity, a force and a moment at rest: the sag and what the load moves, against central differences
/// of the potential and of the tip's pose.
#[test]
fn statics_are_where_differences_of_the_potential_say() {
    const H: f64 = 1e-4;
    let (tcp, force) = (Point3::new(0.05, -0.02, 0.15), Vector3::new(30.0, -50.0, 80.0));
    let moment = Vector3::new(-4.0, 7.0, 5.0);
    for c in cases() {
        let n = c.size();
        let statics = Statics::of(&c.robot, &c.placement, &tcp).unwrap();
        let pose = |alpha: &[f64]| detune::model::forward_kinematics(&c.robot, &c.deflected(alpha));
        let [mut sag_m, mut moved_m, mut turned_m] = [Vector3::zeros(); 3];
        for (i, coordinate) in c.robot.coordinates().iter().enumerate() {
            let ends = [H, -H].map(|h| {
                let mut alpha = vec![0.0; n];
                alpha[i] = h;
                (potential(&c.robot, &c.deflected(&alpha)), pose(&alpha))
            });
            let slope = (ends[0].0 - ends[1].0) / (2.0 * H);
            let step = (ends[0].1 * tcp - ends[1].1 * tcp) / (2.0 * H);
            let turn = (ends[0].1.rotation / ends[1].1.rotation).scaled_axis() / (2.0 * H);
            let scale = 9.81 * c.robot.moving_mass_kg() * 3.0 / coordinate.stiffness;
            assert_close("sag", c.seed, statics.sag[i], -slope / coordinate.stiffness, scale, 1e-8);
            sag_m -= step * (slope / coordinate.stiffness);
            moved_m += step * (step.dot(&force) / coordinate.stiffness);
            turned_m += step * (turn.dot(&moment) / coordinate.stiffness);
        }
        let found = statics.compliance_m_per_n * force;
        assert!((found - moved_m).norm() < 1e-6 * moved_m.norm(), "robot {}", c.seed);
        let found = statics.compliance_m_per_nm * moment;
        // Slides alone do not turn.
        let scale = turned_m.norm().max(1e-6 * moved_m.norm());
        assert!((found - turned_m).norm() < 1e-6 * scale, "robot {}: {found} {turned_m}", c.seed);
        assert!((statics.sag_m - sag_m).norm() < 1e-6 * sag_m.norm(), "robot {}", c.seed);
    }
}

#[test]
fn elastic_tip_jacobian_agrees_with_homogeneous_matrices_and_differences() {
    const H: f64 = 1e-5;
    let tcp = Point3::new(0.05, -0.02, 0.15);
    for c in cases() {
        let n = c.size();
        let mut jacobian = Matrix6xX::zeros(n);
        elastic_jacobian(&c.robot, &c.placement, &tcp, &mut jacobian);
        let q = c.named_pose();
        let tip_at =
            |alpha: &[f64]| detune::model::forward_kinematics(&c.robot, &c.deflected(alpha)) * tcp;
        for (i, coordinate) in c.robot.coordinates().iter().enumerate() {
            let (t, dt) = frames(&c.description, &q, &coordinate.name)["tool"];
            let velocity = (dt * tcp.to_homogeneous()).xyz();
            let spin = dt.fixed_view::<3, 3>(0, 0) * t.fixed_view::<3, 3>(0, 0).transpose();
            let spin = Vector3::new(spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]);
            let mut alpha = vec![0.0; n];
            alpha[i] = H;
            let ahead = tip_at(&alpha);
            alpha[i] = -H;
            let difference = (ahead - tip_at(&alpha)) / (2.0 * H);
            for row in 0..3 {
                let found = jacobian[(row, i)];
                assert_close("J", c.seed, found, velocity[row], 1.0, EXACT);
                assert_close("J", c.seed, found, difference[row], 1.0, 1e-8);
                assert_close("J", c.seed, jacobian[(row + 3, i)], spin[row], 1.0, EXACT);
            }
        }
    }
}

#[test]
fn joint_jacobian_agrees_with_differences_of_the_pose() {
    const H: f64 = 1e-5;
    let tcp = Point3::new(0.05, -0.02, 0.15);
    for c in cases() {
        let mut jacobian = Matrix6xX::zeros(c.q.len());
        joint_jacobian(&c.robot, &c.placement, &tcp, &mut jacobian);
        let tip_at = |q: &[f64]| {
            let mut placement = Placement::new(&c.robot);
            placement.place(&c.robot, q);
            detune::model::forward_kinematics(&c.robot, &placement) * tcp
        };
        for i in 0..c.q.len() {
            let (mut ahead, mut behind) = (c.q.clone(), c.q.clone());
            ahead[i] += H;
            behind[i] -= H;
            let difference = (tip_at(&ahead) - tip_at(&behind)) / (2.0 * H);
            for row in 0..3 {
                assert_close("J", c.seed, jacobian[(row, i)], difference[row], 1.0, 1e-8);
            }
        }
    }
}

/// The base on a new foot, moved and turned, gravity turned with it.
#[test]
fn frequencies_do_not_depend_on_where_the_base_stands() {
    for (c, with_gravity) in cases().flat_map(|c| {
        let again = case(c.seed, c.description.clone());
        [(c, false), (again, true)]
    }) {
        let mut still = c.description.clone();
        still.gravity_stiffness = with_gravity;
        let mut moved = still.clone();
        let placed = isometry(c.seed);
        moved.links.push(Link { name: "foot".into(), inertial: None, ..Link::default() });
        moved.joints.push(Joint {
            name: "on_foot".into(),
            kind: JointKind::Fixed,
            parent: "foot".into(),
            child: "ground".into(),
            origin: placed,
            axis: Vector3::x(),
            position_limit: None,
            velocity_limit: None,
            mimics: None,
        });
        moved.base = Some("foot".into());
        moved.gravity_m_per_s2 = placed.rotation * still.gravity_m_per_s2;
        let still = Robot::new(&still).expect("robot");
        let moved = Robot::new(&moved).expect("robot on a foot");
        for (a, b) in frequencies(&still, &c.q).iter().zip(frequencies(&moved, &c.q)) {
            assert_close("frequency", c.seed, b, *a, *a, 1e-12);
        }
    }
}

#[test]
fn four_times_the_stiffness_doubles_the_frequencies() {
    for c in cases() {
        let mut stiff = c.description.clone();
        stiff.elastic_joints.iter_mut().for_each(|s| s.stiffness *= 4.0);
        stiff.extra.iter_mut().for_each(|s| s.stiffness *= 4.0);
        let stiff = case(c.seed, stiff).frequencies();
        for (a, b) in c.frequencies().iter().zip(stiff) {
            // Scaling by powers of two is exact, the rest may round differently.
            assert_close("frequency", c.seed, b, 2.0 * a, *a, 1e-14);
        }
    }
}

/// Rayleigh: each frequency in ascending order rises with any stiffness and falls with any inertia.
#[test]
fn stiffness_raises_and_inertia_lowers_every_frequency() {
    // Rounding of a frequency that ought not to move at all.
    const SLACK: f64 = 1e-12;
    for c in cases() {
        let before = c.frequencies();
        let check = |what: &str, changed: Description, rises: bool| {
            let after = case(c.seed, changed).frequencies();
            let sign = if rises { 1.0 } else { -1.0 };
            let change: Vec<f64> =
                before.iter().zip(&after).map(|(a, b)| sign * (b - a) / a).collect();
            assert!(change.iter().all(|&x| x >= -SLACK), "robot {}: {what}: {change:?}", c.seed);
            change.iter().fold(0.0_f64, |a, &b| a.max(b))
        };
        for i in 0..c.description.elastic_joints.len() {
            let mut d = c.description.clone();
            d.elastic_joints[i].stiffness *= 1.3;
            assert!(check("joint stiffness", d, true) > 1e-9, "robot {}: no effect", c.seed);
        }
        for i in 0..c.description.extra.len() {
            let mut d = c.description.clone();
            d.extra[i].stiffness *= 1.3;
            assert!(check("extra stiffness", d, true) > 1e-9, "robot {}: no effect", c.seed);
        }
        for i in 0..c.description.links.len() {
            let mut d = c.description.clone();
            if let Some(body) = &mut d.links[i].inertial {
                body.mass_kg *= 1.3;
                body.inertia_kgm2 *= 1.3;
                check("link", d, false);
            }
        }
        for i in 0..c.description.drives.len() {
            let mut d = c.description.clone();
            d.drives[i].reflected_inertia_kgm2 += 1.0;
            check("drive", d, false);
        }
    }
}

#[test]
fn modes_are_mass_normalised_and_solve_the_eigenproblem() {
    for c in cases() {
        for with_gravity in [false, true] {
            let mut d = c.description.clone();
            d.gravity_stiffness = with_gravity;
            let robot = Robot::new(&d).expect("robot");
            let mut solver = ModalSolver::new(&robot);
            let modes = solver.solve(&c.q).expect("modes").clone();
            let (m, k, phi) = (solver.mass(), solver.stiffness(), &modes.shapes);
            let (unit, squares) = (phi.transpose() * m * phi, phi.transpose() * k * phi);
            let omega: Vec<f64> =
                modes.natural_frequencies_hz.iter().map(|f| f * std::f64::consts::TAU).collect();
            assert!(omega.is_sorted(), "robot {}: {omega:?}", c.seed);
            for r in 0..c.size() {
                for s in 0..c.size() {
                    let same = if r == s { 1.0 } else { 0.0 };
                    assert_close("ΦᵀMΦ", c.seed, unit[(r, s)], same, 1.0, EXACT);
                    let scale = omega[r] * omega[s];
                    assert_close(
                        "ΦᵀKΦ",
                        c.seed,
                        squares[(r, s)],
                        same * omega[r].powi(2),
                        scale,
                        EXACT,
                    );
                }
                let elastic = k * phi.column(r);
                let residual = &elastic - m * phi.column(r) * omega[r].powi(2);
                assert!(
                    residual.norm() <= 1e-10 * elastic.norm(),
                    "robot {}: mode {r}: residual {}",
                    c.seed,
                    residual.norm() / elastic.norm()
                );
            }
        }
    }
}

#[test]
fn mac_lies_between_zero_and_one() {
    for c in cases() {
        let here = Modes::at(&c.robot, &c.q).expect("modes");
        let there = Modes::at(&c.robot, &pose(&c.robot, c.seed + 77)).expect("modes");
        for r in 0..c.size() {
            for s in 0..c.size() {
                let value = mac(&c.m, here.shapes.column(r), there.shapes.column(s));
                assert!((0.0..=1.0).contains(&value), "robot {}: {value}", c.seed);
                let own = mac(&c.m, here.shapes.column(r), here.shapes.column(s));
                let same = if r == s { 1.0 } else { 0.0 };
                assert_close("MAC", c.seed, own, same, 1.0, EXACT);
            }
        }
    }
}

/// G(ω) by modes against dᵀJ (K + iωC − ω²M)⁻¹ Jᵀd by complex LU.
#[test]
fn receptance_agrees_with_the_direct_solution() {
    let tcp = Point3::new(0.05, -0.02, 0.15);
    let direction = Unit::new_normalize(Vector3::new(0.3, -0.8, 0.5));
    for c in cases() {
        let mut solver = ModalSolver::new(&c.robot);
        let modes = solver.solve(&c.q).expect("modes").clone();
        let mut jacobian = Matrix6xX::zeros(c.size());
        elastic_jacobian(&c.robot, solver.placement(), &tcp, &mut jacobian);
        let force: DVector<f64> = jacobian.fixed_rows::<3>(0).transpose() * direction.into_inner();
        let damping = solver.damping_matrix();
        let resonances = &modes.natural_frequencies_hz;
        let peak = resonances
            .iter()
            .map(|&f| tip_receptance_m_per_n(&modes, &jacobian, &direction, f).norm())
            .fold(0.0, f64::max);
        for f in [0.0, 3.0, 0.9 * resonances[0]].into_iter().chain(resonances.iter().copied()) {
            let omega = f * std::f64::consts::TAU;
            let dynamic = DMatrix::from_fn(c.size(), c.size(), |i, j| {
                Complex::new(
                    solver.stiffness()[(i, j)] - omega * omega * c.m[(i, j)],
                    omega * damping[(i, j)],
                )
            });
            let answer = dynamic.lu().solve(&force.map(Complex::from)).expect("regular");
            let expected: Complex<f64> = answer.iter().zip(force.iter()).map(|(a, &f)| a * f).sum();
            let found = tip_receptance_m_per_n(&modes, &jacobian, &direction, f);
            let error = (found - expected).norm();
            assert!(error <= 1e-9 * peak, "robot {}: {f} Hz: {found} / {expected}", c.seed);
        }
    }
}

/// A pendulum: one link behind one hinge about y; what fails below fails by one change to it.
fn pendulum() -> Description {
    let mut d = description(0);
    d.links.truncate(1);
    d.joints.clear();
    d.elastic_joints.clear();
    d.extra.clear();
    d.drives.clear();
    d.payload = None;
    d.tip = Some("bob".into());
    d.gravity_m_per_s2 = Vector3::new(0.0, 0.0, -9.81);
    let inertial = detune::model::Inertial {
        mass_kg: 10.0,
        com_m: Vector3::new(0.0, 0.0, 0.5),
        inertia_kgm2: nalgebra::Matrix3::zeros(),
    };
    d.links.push(Link { name: "bob".into(), inertial: Some(inertial), ..Link::default() });
    d.joints.push(Joint {
        name: "hinge".into(),
        kind: JointKind::Continuous,
        parent: "ground".into(),
        child: "bob".into(),
        origin: nalgebra::Isometry3::identity(),
        axis: Vector3::y(),
        position_limit: None,
        velocity_limit: None,
        mimics: None,
    });
    d.elastic_joints.push(detune::model::ElasticJoint {
        joint: "hinge".into(),
        stiffness: 100.0,
        is_linear: false,
        std: None,
        damping: None,
    });
    d
}

/// f = √((k − m g l) / (m l²)) / 2π, upright; + m g l, hanging.
#[test]
fn a_pendulum_has_its_textbook_frequency() {
    let mut d = pendulum();
    d.gravity_stiffness = true;
    let robot = Robot::new(&d).expect("robot");
    let weight = 10.0 * 9.81 * 0.5;
    for (q, k) in [(0.0, 100.0 - weight), (std::f64::consts::PI, 100.0 + weight)] {
        let expected = (k / 2.5_f64).sqrt() / std::f64::consts::TAU;
        assert_close("pendulum", 0, frequencies(&robot, &[q])[0], expected, expected, 1e-14);
    }
}

#[test]
fn a_spring_with_nothing_behind_it_is_named() {
    let mut d = pendulum();
    d.links[1].inertial = None;
    let faults = Robot::new(&d).expect_err("massless");
    assert_eq!(faults.len(), 1, "{faults:?}");
    let text = faults[0].to_string();
    assert!(
        text.contains("joint 'hinge'") && text.contains("nothing behind 'hinge' has mass"),
        "{text}"
    );
}

#[test]
fn a_point_mass_on_the_axis_is_named() {
    let mut d = pendulum();
    d.links[1].inertial.as_mut().expect("body").com_m = Vector3::new(0.0, 0.3, 0.0);
    let robot = Robot::new(&d).expect("a fault of the pose, not of the robot");
    let fault = Modes::at(&robot, &[0.0]).expect_err("singular");
    assert_eq!(fault, PoseFault::MassNotPositive { coordinate: "hinge".into() });
}

/// The same on a slanting axis, where rounding leaves an inertia of some 1e-33 kg·m² instead of none.
#[test]
fn a_point_mass_on_a_slanting_axis_is_named() {
    for (axis, com) in [([1.0, 1.0, 1.0], 0.3), ([0.3, -0.2, 0.9], 0.7), ([-2.0, 0.1, 0.7], 0.1)] {
        let axis = Vector3::from(axis);
        let mut d = pendulum();
        d.joints[0].axis = axis;
        d.joints[0].origin = isometry(3);
        d.links[1].inertial.as_mut().expect("body").com_m = axis.normalize() * com;
        let robot = Robot::new(&d).expect("a fault of the pose, not of the robot");
        let fault = Modes::at(&robot, &[0.4]).expect_err("singular");
        assert_eq!(fault, PoseFault::MassNotPositive { coordinate: "hinge".into() });
    }
}

/// Two parallel axes through one point: M is singular though neither entry of its diagonal is.
#[test]
fn two_springs_that_move_the_same_are_named() {
    let mut d = pendulum();
    d.extra.push(detune::model::ExtraCoordinate {
        name: "twin".into(),
        link: "bob".into(),
        kind: CoordinateKind::Rotation,
        axis: Vector3::y() * 2.0,
        origin_m: Vector3::zeros(),
        stiffness: 1e5,
        std: None,
        damping: None,
    });
    let robot = Robot::new(&d).expect("robot");
    let fault = Modes::at(&robot, &[0.4]).expect_err("singular");
    assert_eq!(fault, PoseFault::MassNotPositive { coordinate: "twin".into() });
}

#[test]
fn gravity_that_overcomes_the_spring_is_named() {
    let mut d = pendulum();
    d.gravity_stiffness = true;
    d.elastic_joints[0].stiffness = 49.0; // m g l = 49.05 N·m/rad
    let robot = Robot::new(&d).expect("robot");
    let fault = Modes::at(&robot, &[0.0]).expect_err("falls over");
    assert_eq!(fault, PoseFault::StiffnessNotPositive { coordinate: "hinge".into() });
    assert!(Modes::at(&robot, &[0.2]).is_ok(), "leaning, the spring holds it");
}

fn root(description: &Description) -> String {
    let is_child = |link: &Link| description.joints.iter().any(|joint| joint.child == link.name);
    let root = description.links.iter().find(|link| !is_child(link)).unwrap();
    description.base.clone().unwrap_or_else(|| root.name.clone())
}

/// ∂ln f of a compliance that the model lacks, against a robot that has it: a foundation that turns about x, y and z, and
/// a joint that gives across its axis.
#[test]
fn compliances_that_the_model_lacks_lower_frequencies_as_real_ones_do() {
    /// The compliance, against that of the spring it is compared with: its square is the error.
    const SMALL: f64 = 1e-6;
    let mut compared = 0;
    for case in cases() {
        let lacking = detune::uncertainty::lacking(&case.robot);
        for scales in lacking {
            let rotary = case
                .robot
                .coordinates()
                .iter()
                .filter(|c| c.joint.is_some() && c.kind == CoordinateKind::Rotation);
            let (link, axes, origin, spring) = match scales {
                Scales::Bending(i) => {
                    let own = &case.robot.coordinates()[i];
                    let joint = &case.robot.joints()[own.joint.unwrap()].name;
                    let urdf = case.description.joints.iter().find(|j| j.name == *joint).unwrap();
                    let axis = urdf.axis.normalize();
                    let aside = if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
                    let first = axis.cross(&aside).normalize();
                    (
                        own.link.clone(),
                        vec![first, axis.cross(&first)],
                        Vector3::zeros(),
                        own.stiffness,
                    )
                }
                _ => {
                    let root = root(&case.description);
                    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
                    let softest = rotary.map(|c| c.stiffness).fold(f64::INFINITY, f64::min);
                    (root, axes, Vector3::zeros(), softest)
                }
            };
            let mut description = case.description.clone();
            description.extra.extend(axes.iter().enumerate().map(|(k, axis)| ExtraCoordinate {
                name: format!("gives_{k}"),
                link: link.clone(),
                kind: CoordinateKind::Rotation,
                axis: *axis,
                origin_m: origin,
                stiffness: spring / SMALL,
                std: None,
                damping: None,
            }));
            let Ok(softer) = Robot::new(&description) else { continue };
            let parameter = Parameter { scales, std: 1.0, is_assumed: true };
            let mut solver = ModalSolver::new(&case.robot);
            if solver.solve(&case.q).is_err() {
                continue;
            }
            let slopes =
                ArmAtPose::new(&case.robot, &solver, &[parameter]).sensitivities(solver.modes());
            let mut with = ModalSolver::new(&softer);
            if with.solve(&case.q).is_err() {
                continue;
            }
            let before = &solver.modes().natural_frequencies_hz;
            let after = &with.modes().natural_frequencies_hz;
            for (r, hz) in before.iter().enumerate() {
                let fell = (after[r] / hz).ln();
                let said = slopes[(0, r)] * SMALL;
                // Where modes lie close the small compliance turns them: second order.
                let error = (fell - said).abs();
                assert!(
                    error <= 0.01 * said.abs() + 1e-9,
                    "{} {scales:?} mode {r}: {fell:e}, must be {said:e}",
                    case.seed
                );
                compared += usize::from(said.abs() > 1e-8);
            }
        }
    }
    assert!(compared > 500, "{compared}");
}
