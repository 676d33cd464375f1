//! The scalar modal kernel: readable, and free of allocation once its buffers are made.

use nalgebra::{DMatrix, DVector};

use super::jacobi::diagonalise;
use crate::model::{
    Conditions, Damping, Placement, PoseFault, Robot, mass_matrix, spring_constant,
    stiffness_matrix,
};
use crate::units::hz_from_rad_per_s;

/// A pivot of the scaled mass or stiffness matrix below this share of its diagonal entry counts as
/// zero: 1e-13 is some hundred times the rounding of the entries.
const MIN_PIVOT: f64 = 1e-13;

/// The modes of a robot at one pose, n elastic coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// f_r, Hz, ascending, length n.
    pub natural_frequencies_hz: Vec<f64>,
    /// φ_r as columns, n × n, mass-normalised: Φᵀ M Φ = 1, Φᵀ K Φ = diag(ω²). The largest entry of
    /// each, weighted by its spring's energy, is positive.
    pub shapes: DMatrix<f64>,
    /// ζ_r, share of critical damping, length n.
    pub damping_ratios: Vec<f64>,
}

/// Solves pose after pose for one robot in buffers of its own.
#[derive(Debug, Clone)]
pub struct ModalSolver<'a> {
    robot: &'a Robot,
    placement: Placement,
    mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    /// As the laws leave them at the pose, N·m/rad or N/m.
    springs: Vec<f64>,
    /// L with K = L Lᵀ; its lower triangle.
    factor: DMatrix<f64>,
    scaled: DMatrix<f64>,
    vectors: DMatrix<f64>,
    omega: DVector<f64>,
    order: Vec<usize>,
    modes: Modes,
}

impl<'a> ModalSolver<'a> {
    /// Buffers for `robot`.
    pub fn new(robot: &'a Robot) -> Self {
        let n = robot.coordinates().len();
        Self {
            robot,
            placement: Placement::new(robot),
            mass: DMatrix::zeros(n, n),
            stiffness: DMatrix::zeros(n, n),
            springs: vec![0.0; n],
            factor: DMatrix::zeros(n, n),
            scaled: DMatrix::zeros(n, n),
            vectors: DMatrix::zeros(n, n),
            omega: DVector::zeros(n),
            order: (0..n).collect(),
            modes: Modes {
                natural_frequencies_hz: vec![0.0; n],
                shapes: DMatrix::zeros(n, n),
                damping_ratios: vec![0.0; n],
            },
        }
    }

    /// The robot placed at the pose of the last call.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }

    /// M of the last call, n × n.
    pub fn mass(&self) -> &DMatrix<f64> {
        &self.mass
    }

    /// K (+ K_g where the robot asks for it) of the last call, n × n.
    pub fn stiffness(&self) -> &DMatrix<f64> {
        &self.stiffness
    }

    /// Natural frequencies at pose `q`, Hz, ascending.
    ///
    /// # Errors
    /// `q` is no pose of the robot, or M or K is not positive definite there.
    pub fn frequencies_hz(&mut self, q: &[f64]) -> Result<&[f64], PoseFault> {
        self.set_up(q)?;
        diagonalise(&mut self.scaled, None);
        self.sort()?;
        Ok(&self.modes.natural_frequencies_hz)
    }

    /// Modes at pose `q`.
    ///
    /// # Errors
    /// As [`Self::frequencies_hz`].
    pub fn solve(&mut self, q: &[f64]) -> Result<&Modes, PoseFault> {
        self.set_up(q)?;
        diagonalise(&mut self.scaled, Some(&mut self.vectors));
        self.sort()?;
        let n = self.order.len();
        for (r, &from) in self.order.iter().enumerate() {
            let mut shape = self.modes.shapes.column_mut(r);
            shape.copy_from(&self.vectors.column(from));
            // φ = ω L⁻ᵀ y, by back substitution.
            for i in (0..n).rev() {
                let mut sum = shape[i];
                for k in i + 1..n {
                    sum -= self.factor[(k, i)] * shape[k];
                }
                shape[i] = sum / self.factor[(i, i)];
            }
            let y = self.vectors.column(from);
            let leading = y.iter().fold(0.0_f64, |a, &b| if b.abs() > a.abs() { b } else { a });
            shape.scale_mut(self.omega[r] * if leading < 0.0 { -1.0 } else { 1.0 });
        }
        self.damp();
        Ok(&self.modes)
    }

    /// The modes of the last [`Self::solve`].
    pub fn modes(&self) -> &Modes {
        &self.modes
    }

    /// The springs of the last call, as their laws leave them at the pose, N·m/rad or N/m.
    pub fn springs(&self) -> &[f64] {
        &self.springs
    }

    /// Share of the strain energy of mode `r` of the last [`Self::solve`] in the spring of each
    /// elastic coordinate; the shares add up to one. Says what moves in the mode, rotations and
    /// translations on one scale.
    pub fn strain_energy_shares(&self, r: usize) -> Vec<f64> {
        let energies: Vec<f64> =
            (0..self.springs.len()).map(|i| self.strain_energy(i, r)).collect();
        let total: f64 = energies.iter().sum();
        energies.iter().map(|energy| energy / total).collect()
    }

    /// Twice the energy that spring `i` holds in mode `r`.
    fn strain_energy(&self, i: usize, r: usize) -> f64 {
        let shape = self.modes.shapes.column(r);
        let felt: f64 = self.robot.felt_by(i).map(|(j, share)| share * shape[j]).sum();
        self.springs[i] * felt * felt
    }

    /// C = M Φ diag(2 ζ_r ω_r) Φᵀ M of the last [`Self::solve`], n × n, N·m·s/rad: the matrix whose
    /// modal form is the damping of [`Modes::damping_ratios`].
    pub fn damping_matrix(&self) -> DMatrix<f64> {
        let weighted = &self.mass * &self.modes.shapes;
        let rates = DVector::from_fn(self.omega.len(), |r, _| {
            2.0 * self.modes.damping_ratios[r] * self.omega[r]
        });
        &weighted * DMatrix::from_diagonal(&rates) * weighted.transpose()
    }

    /// A = L⁻¹ M L⁻ᵀ at pose `q`.
    fn set_up(&mut self, q: &[f64]) -> Result<(), PoseFault> {
        let robot = self.robot;
        robot.check_pose(q)?;
        self.placement.place(robot, q);
        mass_matrix(robot, &self.placement, &mut self.mass);
        let conditions = Conditions::default();
        stiffness_matrix(robot, &self.placement, &conditions, &mut self.stiffness);
        for (i, spring) in self.springs.iter_mut().enumerate() {
            *spring = spring_constant(robot, &self.placement, &conditions, i);
        }
        self.check_mass()?;
        if robot.has_coupled_stiffness() {
            self.scale_by_cholesky()
        } else {
            self.scale_by_diagonal();
            Ok(())
        }
    }

    /// M must be positive definite: its Cholesky pivots, scaled by the diagonal, name the
    /// coordinate at fault.
    fn check_mass(&mut self) -> Result<(), PoseFault> {
        self.factor.copy_from(&self.mass);
        cholesky_in_place(&mut self.factor).map_err(|i| PoseFault::MassNotPositive {
            coordinate: self.robot.coordinates()[i].name.clone(),
        })
    }

    fn scale_by_diagonal(&mut self) {
        let n = self.order.len();
        self.factor.fill(0.0);
        for i in 0..n {
            self.factor[(i, i)] = self.stiffness[(i, i)].sqrt();
        }
        for j in 0..n {
            for i in 0..n {
                self.scaled[(i, j)] =
                    self.mass[(i, j)] / (self.factor[(i, i)] * self.factor[(j, j)]);
            }
        }
    }

    fn scale_by_cholesky(&mut self) -> Result<(), PoseFault> {
        let n = self.order.len();
        self.factor.copy_from(&self.stiffness);
        cholesky_in_place(&mut self.factor).map_err(|i| PoseFault::StiffnessNotPositive {
            coordinate: self.robot.coordinates()[i].name.clone(),
        })?;
        self.scaled.copy_from(&self.mass);
        // L X = M column by column, then the same from the right, as X is L⁻¹ M and M is symmetric.
        for _ in 0..2 {
            for j in 0..n {
                for i in 0..n {
                    let mut sum = self.scaled[(i, j)];
                    for k in 0..i {
                        sum -= self.factor[(i, k)] * self.scaled[(k, j)];
                    }
                    self.scaled[(i, j)] = sum / self.factor[(i, i)];
                }
            }
            transpose_in_place(&mut self.scaled);
        }
        for j in 0..n {
            for i in 0..j {
                let mean = 0.5 * (self.scaled[(i, j)] + self.scaled[(j, i)]);
                self.scaled[(i, j)] = mean;
                self.scaled[(j, i)] = mean;
            }
        }
        Ok(())
    }

    /// Ascending frequencies from the diagonal of the solved matrix.
    fn sort(&mut self) -> Result<(), PoseFault> {
        let scaled = &self.scaled;
        self.order.sort_unstable_by(|&a, &b| scaled[(b, b)].total_cmp(&scaled[(a, a)]));
        for (r, &from) in self.order.iter().enumerate() {
            let lambda = scaled[(from, from)];
            if !(lambda.is_finite() && lambda > 0.0) {
                return Err(PoseFault::MassNotPositive {
                    coordinate: self.robot.coordinates()[from].name.clone(),
                });
            }
            self.omega[r] = 1.0 / lambda.sqrt();
            self.modes.natural_frequencies_hz[r] = hz_from_rad_per_s(self.omega[r]);
        }
        Ok(())
    }

    /// ζ_r from the coordinates: each spring's loss in proportion to its share of the strain energy
    /// of all springs (Ungar & Kerwin, J. Acoust. Soc. Am. 34, 1962; gravity's own stiffness, which
    /// loses nothing, is left out of the sum), each dashpot's as φᵀ C φ / 2ω.
    fn damp(&mut self) {
        for r in 0..self.order.len() {
            let (mut strain, mut lost, mut viscous) = (0.0, 0.0, 0.0);
            for (i, coordinate) in self.robot.coordinates().iter().enumerate() {
                let energy = self.strain_energy(i, r);
                strain += energy;
                match coordinate.damping {
                    Damping::Ratio(zeta) => lost += zeta * energy,
                    Damping::Viscous(c) => viscous += c * self.modes.shapes[(i, r)].powi(2),
                }
            }
            self.modes.damping_ratios[r] = lost / strain + viscous / (2.0 * self.omega[r]);
        }
    }
}

impl Modes {
    /// The modes of `robot` at pose `q`: the convenient form of [`ModalSolver::solve`].
    ///
    /// # Errors
    /// As [`ModalSolver::frequencies_hz`].
    pub fn at(robot: &Robot, q: &[f64]) -> Result<Self, PoseFault> {
        let mut solver = ModalSolver::new(robot);
        solver.solve(q)?;
        Ok(solver.modes)
    }

    /// Whether the two coordinates `i` and `j` turn together (`true`) or against each other in mode
    /// `r`, seen in space, whichever way their axes are written. `placement` is the robot's at the
    /// pose of the modes. `None` where one of them stands still, they do not both turn, or their
    /// axes are not nearly parallel.
    pub fn turn_together(
        &self,
        placement: &Placement,
        r: usize,
        i: usize,
        j: usize,
    ) -> Option<bool> {
        /// Axes within thirty degrees of each other count as parallel.
        const NEARLY_PARALLEL: f64 = 0.866;
        let cosine = placement.cosine_between(i, j).filter(|c| c.abs() > NEARLY_PARALLEL)?;
        let product = self.shapes[(i, r)] * self.shapes[(j, r)] * cosine;
        (product != 0.0).then_some(product > 0.0)
    }
}

/// L of A = L Lᵀ in the lower triangle; the upper is left as it was. `Err` is the row whose pivot
/// is not positive.
fn cholesky_in_place(a: &mut DMatrix<f64>) -> Result<(), usize> {
    let n = a.nrows();
    for j in 0..n {
        let diagonal = a[(j, j)];
        let mut pivot = diagonal;
        for k in 0..j {
            pivot -= a[(j, k)] * a[(j, k)];
        }
        if pivot.is_nan() || pivot <= MIN_PIVOT * diagonal.abs() {
            return Err(j);
        }
        let root = pivot.sqrt();
        a[(j, j)] = root;
        for i in j + 1..n {
            let mut sum = a[(i, j)];
            for k in 0..j {
                sum -= a[(i, k)] * a[(j, k)];
            }
            a[(i, j)] = sum / root;
        }
    }
    Ok(())
}

fn transpose_in_place(a: &mut DMatrix<f64>) {
    for j in 0..a.ncols() {
        for i in 0..j {
            a.swap((i, j), (j, i));
        }
    }
}
