//! The right side of the equation of motion, y = (α, α̇), and its energy.

use nalgebra::DMatrix;

use crate::model::{
    Conditions, Coupling, Placement, PoseFault, Robot, inverse_dynamics, mass_matrix, potential,
    potential_gradient, spring_constant,
};
use crate::modes::ModalSolver;

/// M(α) α̈ = −h(α, α̇) − C α̇ − K α − (g(α) − g(0)) for one robot at one pose.
pub(super) struct Equation<'a> {
    robot: &'a Robot,
    q: &'a [f64],
    placement: Placement,
    mass: DMatrix<f64>,
    damping: Option<DMatrix<f64>>,
    /// Potential and gradient of gravity at α = 0, where gravity acts.
    preload: Option<(f64, Vec<f64>)>,
    /// N·m/rad or N/m, as they are at α = 0.
    springs: Vec<f64>,
    no_acceleration: Vec<f64>,
    velocity_torque: Vec<f64>,
    gravity_torque: Vec<f64>,
}

impl<'a> Equation<'a> {
    pub(super) fn new(robot: &'a Robot, q: &'a [f64], damped: bool) -> Result<Self, PoseFault> {
        let n = robot.coordinates().len();
        let mut solver = ModalSolver::new(robot);
        solver.solve(q)?;
        let mut placement = Placement::new(robot);
        placement.place(robot, q);
        let preload = robot.has_gravity_stiffness().then(|| {
            let mut gradient = vec![0.0; n];
            potential_gradient(robot, &placement, &mut gradient);
            (potential(robot, &placement), gradient)
        });
        let spring = |i| spring_constant(robot, &placement, &Conditions::default(), i);
        let springs = (0..n).map(spring).collect();
        Ok(Self {
            robot,
            q,
            placement,
            mass: DMatrix::zeros(n, n),
            damping: damped.then(|| solver.damping_matrix()),
            preload,
            springs,
            no_acceleration: vec![0.0; n],
            velocity_torque: vec![0.0; n],
            gravity_torque: vec![0.0; n],
        })
    }

    /// ẏ at y.
    pub(super) fn derivative(&mut self, y: &[f64], rate: &mut [f64]) -> Result<(), PoseFault> {
        let (alpha, alpha_dot) = y.split_at(y.len() / 2);
        self.placement.place_deflected(self.robot, self.q, alpha);
        mass_matrix(self.robot, &self.placement, &mut self.mass);
        inverse_dynamics(
            self.robot,
            &self.placement,
            alpha_dot,
            &self.no_acceleration,
            &mut self.velocity_torque,
        );
        let (velocity, acceleration) = rate.split_at_mut(y.len() / 2);
        velocity.copy_from_slice(alpha_dot);
        for (i, spring) in self.springs.iter().enumerate() {
            acceleration[i] = -self.velocity_torque[i] - spring * alpha[i];
        }
        for &Coupling { own, other, ratio } in self.robot.couplings() {
            let force = self.springs[own] * ratio;
            acceleration[own] -= force * alpha[other];
            acceleration[other] -= force * (alpha[own] + ratio * alpha[other]);
        }
        if let Some(damping) = &self.damping {
            for (j, rate) in alpha_dot.iter().enumerate() {
                for (i, torque) in acceleration.iter_mut().enumerate() {
                    *torque -= damping[(i, j)] * rate;
                }
            }
        }
        if let Some((_, at_rest)) = &self.preload {
            potential_gradient(self.robot, &self.placement, &mut self.gravity_torque);
            for ((torque, now), then) in
                acceleration.iter_mut().zip(&self.gravity_torque).zip(at_rest)
            {
                *torque -= now - then;
            }
        }
        solve_in_place(&mut self.mass, acceleration).map_err(|i| PoseFault::MassNotPositive {
            coordinate: self.robot.coordinates()[i].name.clone(),
        })
    }

    /// Kinetic energy, strain energy and, where gravity acts, its potential less that of the
    /// preload, J.
    pub(super) fn energy(&mut self, y: &[f64]) -> f64 {
        let (alpha, alpha_dot) = y.split_at(y.len() / 2);
        self.placement.place_deflected(self.robot, self.q, alpha);
        mass_matrix(self.robot, &self.placement, &mut self.mass);
        let mut energy = 0.0;
        for (j, rate) in alpha_dot.iter().enumerate() {
            let momentum: f64 =
                alpha_dot.iter().enumerate().map(|(i, r)| self.mass[(i, j)] * r).sum();
            energy += 0.5 * momentum * rate;
        }
        for (spring, a) in self.springs.iter().zip(alpha) {
            energy += 0.5 * spring * a * a;
        }
        for &Coupling { own, other, ratio } in self.robot.couplings() {
            let stretched = alpha[own] + 0.5 * ratio * alpha[other];
            energy += self.springs[own] * ratio * alpha[other] * stretched;
        }
        if let Some((potential_at_rest, gradient)) = &self.preload {
            let preload: f64 = gradient.iter().zip(alpha).map(|(g, a)| g * a).sum();
            energy += potential(self.robot, &self.placement) - potential_at_rest - preload;
        }
        energy
    }
}

/// Solves M x = b for symmetric positive definite M, by M = L Lᵀ in M's lower triangle; `b` becomes
/// x. `Err` is the row whose pivot is not positive.
fn solve_in_place(m: &mut DMatrix<f64>, b: &mut [f64]) -> Result<(), usize> {
    let n = b.len();
    for j in 0..n {
        for k in 0..j {
            let factor = m[(j, k)];
            for i in j..n {
                m[(i, j)] -= m[(i, k)] * factor;
            }
        }
        let pivot = m[(j, j)];
        if pivot.is_nan() || pivot <= 0.0 {
            return Err(j);
        }
        let root = pivot.sqrt();
        for i in j..n {
            m[(i, j)] /= root;
        }
    }
    for i in 0..n {
        for k in 0..i {
            b[i] -= m[(i, k)] * b[k];
        }
        b[i] /= m[(i, i)];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            b[i] -= m[(k, i)] * b[k];
        }
        b[i] /= m[(i, i)];
    }
    Ok(())
}
