//! The arm at one pose, and what each parameter has in its M and K.

use nalgebra::{DMatrix, DVector, DVectorView};
use rayon::prelude::*;

use super::parameters::{Parameter, Scales, compared_with};
use crate::model::{
    Conditions, Placement, Robot, body_mass_matrix, lacking_rotations, spring_constant,
};
use crate::modes::batch::Pencils;
use crate::modes::{ModalSolver, Modes, Pencil};
use crate::units::hz_from_rad_per_s;

/// M and K at a pose, and the share that each parameter scales.
#[derive(Debug, Clone)]
pub struct ArmAtPose {
    mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    parts: Vec<Part>,
}

/// What a parameter scales, n × n.
#[derive(Debug, Clone)]
enum Part {
    Nothing,
    /// In K, N·m/rad or N/m: ½ k (Σ share α)² over the coordinates that the spring feels.
    Spring {
        felt: Vec<(usize, f64)>,
        stiffness: f64,
    },
    /// In M.
    Body(DMatrix<f64>),
    /// On the diagonal of M, kg·m² or kg.
    Drive {
        at: usize,
        inertia: f64,
    },
    /// A compliance that the model lacks: by [`lacking_rotations`], against a spring, N·m/rad.
    Lacking {
        rows: DMatrix<f64>,
        stiffness: f64,
    },
}

impl ArmAtPose {
    /// The arm where `solver` placed it last, with n elastic coordinates.
    pub fn new(robot: &Robot, solver: &ModalSolver, parameters: &[Parameter]) -> Self {
        let scales = parameters.iter().map(|parameter| Some(parameter.scales));
        let (mass, stiffness) = (solver.mass().clone(), solver.stiffness().clone());
        let conditions = Conditions::default();
        Self::placed(robot, solver.placement(), &conditions, scales, [mass, stiffness])
    }

    /// The arm as placed under `conditions`, with its M and K there; parameters that the robot
    /// lacks have no part in it.
    pub fn placed(
        robot: &Robot,
        placement: &Placement,
        conditions: &Conditions,
        scales: impl Iterator<Item = Option<Scales>>,
        [mass, stiffness]: [DMatrix<f64>; 2],
    ) -> Self {
        let part = |scales: Option<Scales>| {
            scales.map_or(Part::Nothing, |scales| part(robot, placement, conditions, scales))
        };
        Self { parts: scales.map(part).collect(), mass, stiffness }
    }

    /// ∂ln f_r/∂θ of every parameter (rows) and mode (columns). `modes` are those of the pose. A
    /// body's part in the stiffness of gravity is left out: it is a small share of a small one.
    pub fn sensitivities(&self, modes: &Modes) -> DMatrix<f64> {
        let n = modes.natural_frequencies_hz.len();
        let mut found = DMatrix::zeros(self.parts.len(), n);
        for (r, hz) in modes.natural_frequencies_hz.iter().enumerate() {
            let omega_squared = (std::f64::consts::TAU * hz).powi(2);
            let shape = modes.shapes.column(r);
            found.set_column(r, &self.slopes(shape.as_slice(), omega_squared));
        }
        found
    }

    /// ∂ln f/∂θ of every parameter, for a mass-normalised mode.
    pub fn slopes(&self, shape: &[f64], omega_squared: f64) -> DVector<f64> {
        let shape = DVectorView::from_slice(shape, shape.len());
        let slope = |part: &Part| match part {
            Part::Nothing => 0.0,
            Part::Spring { felt, stiffness } => {
                let deflection: f64 = felt.iter().map(|&(j, share)| share * shape[j]).sum();
                0.5 * stiffness * deflection.powi(2) / omega_squared
            }
            Part::Body(mass) => -0.5 * shape.dot(&(mass * shape)),
            Part::Drive { at, inertia } => -0.5 * inertia * shape[*at].powi(2),
            // A coordinate without inertia transmits no moment.
            Part::Lacking { .. } if !omega_squared.is_finite() => 0.0,
            Part::Lacking { rows, stiffness } => {
                -0.5 * omega_squared * (rows * shape).norm_squared() / stiffness
            }
        };
        DVector::from_iterator(self.parts.len(), self.parts.iter().map(slope))
    }

    /// f_r, Hz, ascending, of every draw of the parameters: `theta` has one row of parameters a
    /// draw, one after the other; the result has n values a draw. `None` where a draw has no modes.
    pub fn frequencies_hz(&self, theta: &[f64]) -> Option<Vec<f64>> {
        /// Draws that one thread solves at a time.
        const CHUNK: usize = 256;
        let n = self.mass.nrows();
        let lacking = self.lacking()?;
        let pieces: Option<Vec<Vec<f64>>> = theta
            .par_chunks(CHUNK * self.parts.len())
            .map(|rows| {
                let mut pencils = Pencils::new(n);
                let (mut mass, mut stiffness) = (self.mass.clone(), self.stiffness.clone());
                for row in rows.chunks_exact(self.parts.len()) {
                    mass.copy_from(&self.mass);
                    stiffness.copy_from(&self.stiffness);
                    for (part, theta) in self.parts.iter().zip(row) {
                        part.scale(theta.exp_m1(), &mut mass, &mut stiffness);
                    }
                    pencils.push(&mass, &stiffness);
                }
                let hz = |omega_squared: &f64| hz_from_rad_per_s(omega_squared.sqrt());
                let mut found: Vec<f64> = pencils.solve_values().then(|| {
                    (0..pencils.count())
                        .flat_map(|i| pencils.omega_squared(i).iter().map(hz))
                        .collect()
                })?;
                let draws = rows.chunks_exact(self.parts.len());
                for (found, row) in found.chunks_exact_mut(n).zip(draws) {
                    for (p, slopes) in &lacking {
                        let factors = slopes.iter().map(|slope| (slope * row[*p]).exp());
                        found.iter_mut().zip(factors).for_each(|(hz, factor)| *hz *= factor);
                    }
                }
                Some(found)
            })
            .collect();
        Some(pieces?.concat())
    }
}

impl ArmAtPose {
    /// Of each compliance that the model lacks, its place among the parts and ∂ln f_r/∂θ of every
    /// mode; `None` where the arm has no modes.
    fn lacking(&self) -> Option<Vec<(usize, Vec<f64>)>> {
        let parts = self.parts.iter().enumerate();
        let places: Vec<usize> = parts
            .filter_map(|(p, part)| matches!(part, Part::Lacking { .. }).then_some(p))
            .collect();
        if places.is_empty() {
            return Some(Vec::new());
        }
        let mut pencil = Pencil::new(self.mass.nrows());
        pencil.solve(&self.mass, &self.stiffness).then(|| {
            let of_mode =
                |r: usize| self.slopes(pencil.shapes.column(r).as_slice(), pencil.omega_squared[r]);
            let slopes: Vec<DVector<f64>> = (0..self.mass.nrows()).map(of_mode).collect();
            places.iter().map(|&p| (p, slopes.iter().map(|of| of[p]).collect())).collect()
        })
    }
}

fn part(robot: &Robot, placement: &Placement, conditions: &Conditions, scales: Scales) -> Part {
    match scales {
        Scales::Spring(at) => {
            let stiffness = spring_constant(robot, placement, conditions, at);
            Part::Spring { felt: robot.felt_by(at).collect(), stiffness }
        }
        Scales::Body(b) => Part::Body(body_mass_matrix(robot, placement, &robot.bodies()[b])),
        Scales::Drive(at) => Part::Drive { at, inertia: robot.coordinates()[at].drive_inertia },
        Scales::Foundation | Scales::Bending(_) => {
            let across = match scales {
                Scales::Bending(i) => Some(i),
                _ => None,
            };
            compared_with(robot, scales).map_or(Part::Nothing, |stiffness| Part::Lacking {
                rows: lacking_rotations(robot, placement, across),
                stiffness,
            })
        }
    }
}

impl Part {
    /// Adds the part, this many times.
    fn scale(&self, by: f64, mass: &mut DMatrix<f64>, stiffness: &mut DMatrix<f64>) {
        match self {
            // Too small to change the shapes: [`ArmAtPose::frequencies_hz`] adds it.
            Self::Nothing | Self::Lacking { .. } => {}
            Self::Spring { felt, stiffness: k } => {
                for &(i, share) in felt {
                    for &(j, other) in felt {
                        stiffness[(i, j)] += by * k * share * other;
                    }
                }
            }
            Self::Body(body) => {
                for (m, b) in mass.as_mut_slice().iter_mut().zip(body.as_slice()) {
                    *m += by * b;
                }
            }
            Self::Drive { at, inertia } => mass[(*at, *at)] += by * inertia,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::{Isometry3, Matrix3, Vector3};

    use super::super::{Draws, all};
    use super::*;
    use crate::model::{
        Cause, Correction, Description, ElasticJoint, Inertial, Joint, JointKind, Link,
    };

    /// Two links in a plane; the second spring feels the first joint, too, and the first has a law.
    fn coupled(stiffness: [f64; 2]) -> Robot {
        let name = |of: &str, i: usize| format!("{of}{i}");
        let inertial = Inertial {
            mass_kg: 20.0,
            com_m: Vector3::new(0.3, 0.0, 0.0),
            inertia_kgm2: Matrix3::from_diagonal_element(0.9),
        };
        let link = |i| Link { name: name("l", i), inertial: Some(inertial), ..Link::default() };
        let joint = |i: usize| Joint {
            name: name("j", i),
            kind: JointKind::Continuous,
            parent: name("l", i - 1),
            child: name("l", i),
            origin: Isometry3::translation(0.5, 0.0, 0.0),
            axis: Vector3::y(),
            position_limit: None,
            velocity_limit: None,
            mimics: None,
        };
        let spring = |i: usize| ElasticJoint {
            joint: name("j", i),
            stiffness: stiffness[i - 1],
            is_linear: false,
            std: None,
            damping: None,
        };
        let correction = |cause, at: &str, parameter: &str, value| Correction {
            cause,
            at: Some(at.to_owned()),
            parameters: vec![(parameter.to_owned(), value)],
            hinge: None,
        };
        Robot::new(&Description {
            name: "arm".to_owned(),
            links: (0..3).map(link).collect(),
            joints: (1..3).map(joint).collect(),
            base: None,
            tip: None,
            elastic_joints: (1..3).map(spring).collect(),
            extra: Vec::new(),
            default_damping_ratio: 0.02,
            gravity_m_per_s2: Vector3::zeros(),
            gravity_stiffness: false,
            drives: Vec::new(),
            payload: None,
            beta1: None,
            beta2: None,
            calibration: None,
            corrections: vec![
                correction(Cause::PositionDependentStiffness, "j1", "cos_1", -0.6),
                correction(Cause::JointCoupling, "j2", "ratio", 0.5),
            ],
        })
        .unwrap()
    }

    /// Differences of solved frequencies: the square of one deflection misses what the spring feels
    /// of the other joint.
    #[test]
    fn sensitivities_are_differences_where_springs_are_coupled_and_have_laws() {
        const STEP: f64 = 1e-4;
        let (own, q) = ([3e5, 1e5], [0.4, 0.7]);
        let robot = coupled(own);
        let mut solver = ModalSolver::new(&robot);
        let modes = solver.solve(&q).unwrap().clone();
        let parameters = all(&robot);
        let found = ArmAtPose::new(&robot, &solver, &parameters).sensitivities(&modes);
        for (p, parameter) in parameters.iter().enumerate() {
            let Scales::Spring(i) = parameter.scales else { continue };
            let ln_hz = |by: f64| {
                let mut stiffness = own;
                stiffness[i] *= by.exp();
                Modes::at(&coupled(stiffness), &q).unwrap().natural_frequencies_hz
            };
            let (more, less) = (ln_hz(STEP), ln_hz(-STEP));
            for (r, shares) in [0, 1].map(|r| (r, solver.strain_energy_shares(r))) {
                let slope = (more[r] / less[r]).ln() / (2.0 * STEP);
                assert!((found[(p, r)] - slope).abs() < 1e-7, "{i} {r}: {slope}");
                assert!((0.5 * shares[i] - slope).abs() < 1e-7, "{i} {r}: {slope}");
                assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{shares:?}");
            }
        }
    }

    /// Two degrees of freedom, M = [[3, 1], [1, 1]], K = diag(3, 1) (20π)², ln k independent with σ
    /// = 0.10 and 0.15. With t = k₂/k₁ the pencil is a quadratic in ω² with coefficients linear in
    /// k₁ and k₂, so that both probabilities are double integrals of the normal density, worked out
    /// to eight digits. First order gives 0.1385 and 0.2399.
    #[test]
    fn draws_give_the_exact_probabilities_of_two_degrees_of_freedom() {
        let k = (20.0 * PI).powi(2);
        let arm = ArmAtPose {
            mass: DMatrix::from_row_slice(2, 2, &[3.0, 1.0, 1.0, 1.0]),
            stiffness: DMatrix::from_diagonal(&DVector::from_vec(vec![3.0 * k, k])),
            parts: vec![
                Part::Spring { felt: vec![(0, 1.0)], stiffness: 3.0 * k },
                Part::Spring { felt: vec![(1, 1.0)], stiffness: k },
            ],
        };
        let std = [0.10, 0.15];
        let draws = Draws::new(2, 1024, 7);
        let theta: Vec<f64> = (0..draws.count())
            .flat_map(|i| draws.row(i).iter().zip(std).map(|(z, std)| z * std).collect::<Vec<_>>())
            .collect();
        let hz = arm.frequencies_hz(&theta).unwrap();
        for (r, low, high, exact) in
            [(0, 8.360365, 9.156590, 0.12260852), (1, 13.843701, 14.920433, 0.22070595)]
        {
            let hits: Vec<bool> = hz.chunks(2).map(|f| low < f[r] && f[r] < high).collect();
            let found = Draws::share(&hits);
            let off = (found.probability - exact).abs();
            assert!(off < 4.0 * found.std_error, "{found:?}, must be {exact}");
            assert!(found.std_error < 2e-3 && off < 2e-3, "{found:?}, must be {exact}");
        }
    }
}
