//! The arm at one place of a path at a time, by the scalar path of [`crate::modes`].

use nalgebra::{Isometry3, Matrix6xX};

use super::timed_path::{Path, PathReader};
use crate::model::{IkFault, PoseFault, Robot, elastic_jacobian};
use crate::modes::{ModalSolver, Modes, peak_tip_compliances_m_per_n};
use crate::notes::{Code, Note, Place};

/// The arm has no modes at a place of the path.
pub(super) fn no_modes_at(path: &Path, s: f64, fault: &PoseFault) -> Note {
    let code = match fault {
        PoseFault::Length { .. } | PoseFault::NotFinite { .. } => Code::Value,
        PoseFault::MassNotPositive { .. } | PoseFault::StiffnessNotPositive { .. } => {
            Code::Singular
        }
    };
    at_place(path, s, code, fault)
}

/// The arm does not reach a place of the path.
pub(super) fn not_reached_at(path: &Path, s: f64, fault: &IkFault) -> Note {
    at_place(path, s, Code::Unreachable, fault)
}

fn at_place(path: &Path, s: f64, code: Code, fault: &dyn std::fmt::Display) -> Note {
    let place = Place { line: Some(path.line_at(s)), ..Place::default() };
    Note::error(code, place, format!("at s = {s:.4}: {fault}"))
}

/// Looks at a path pose by pose, in buffers of its own.
#[derive(Debug, Clone)]
pub struct Surveyor<'p, 'a> {
    reader: PathReader<'p, 'a>,
    solver: ModalSolver<'a>,
    path: &'p Path<'a>,
    q: Vec<f64>,
    jacobian: Matrix6xX<f64>,
    tip_m_per_n: Vec<f64>,
}

impl<'p, 'a> Surveyor<'p, 'a> {
    /// Buffers for `path`.
    pub fn new(path: &'p Path<'a>) -> Self {
        let robot = path.robot();
        let n = robot.coordinates().len();
        Self {
            reader: path.reader(),
            solver: ModalSolver::new(robot),
            path,
            q: vec![0.0; robot.joints().len()],
            jacobian: Matrix6xX::zeros(n),
            tip_m_per_n: vec![0.0; n],
        }
    }

    /// The robot that runs the path.
    pub fn robot(&self) -> &'a Robot {
        self.path.robot()
    }

    fn stand(&mut self, s: f64) -> Result<Isometry3<f64>, Note> {
        self.reader.at(s, &mut self.q).map_err(|fault| not_reached_at(self.path, s, &fault))
    }

    /// Natural frequencies at `s`, Hz, ascending.
    ///
    /// # Errors
    /// The arm has no modes there.
    pub fn frequencies_hz(&mut self, s: f64) -> Result<&[f64], Note> {
        self.stand(s)?;
        self.solver.frequencies_hz(&self.q).map_err(|fault| no_modes_at(self.path, s, &fault))
    }

    /// Modes at `s`, and with them the tip response.
    ///
    /// # Errors
    /// The arm has no modes there.
    pub fn modes(&mut self, s: f64) -> Result<&Modes, Note> {
        let tcp = self.stand(s)?;
        self.solver.solve(&self.q).map_err(|fault| no_modes_at(self.path, s, &fault))?;
        let tcp = tcp.translation.vector.into();
        elastic_jacobian(self.path.robot(), self.solver.placement(), &tcp, &mut self.jacobian);
        let (robot, modes) = (self.path.robot(), self.solver.modes());
        peak_tip_compliances_m_per_n(robot, modes, &self.jacobian, &mut self.tip_m_per_n);
        Ok(self.solver.modes())
    }

    /// Joint positions of the last pose, rad or m.
    pub fn joints(&self) -> &[f64] {
        &self.q
    }

    /// Per mode of the last [`Self::modes`], what it alone moves the tool tip at resonance, m/N.
    pub fn tip_response_m_per_n(&self) -> &[f64] {
        &self.tip_m_per_n
    }

    /// The solver as the last pose left it.
    pub fn solver(&self) -> &ModalSolver<'a> {
        &self.solver
    }
}
