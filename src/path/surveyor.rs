//! The arm at one place of a path at a time, by the scalar path of [`crate::modes`].

use std::fmt;

use nalgebra::{Isometry3, Matrix6xX};

use super::plan::{Path, Walker};
use crate::model::{IkFault, PoseFault, elastic_jacobian};
use crate::modes::{ModalSolver, Modes, peak_tip_compliance_m_per_n};

/// A pose of the path at which the arm cannot be looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct SurveyFault {
    /// Where on the path.
    pub s: f64,
    /// Why.
    pub cause: SurveyCause,
}

/// Why the arm cannot be looked at somewhere on a path.
#[derive(Debug, Clone, PartialEq)]
pub enum SurveyCause {
    /// It has no modes there.
    Pose(PoseFault),
    /// It does not get there.
    Kinematics(IkFault),
}

impl fmt::Display for SurveyFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.cause {
            SurveyCause::Pose(fault) => write!(f, "at s = {:.4}: {fault}", self.s),
            SurveyCause::Kinematics(fault) => write!(f, "at s = {:.4}: {fault}", self.s),
        }
    }
}

impl std::error::Error for SurveyFault {}

/// Looks at a path pose by pose, in buffers of its own.
#[derive(Debug, Clone)]
pub struct Surveyor<'p, 'a> {
    walker: Walker<'p, 'a>,
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
            walker: path.walker(),
            solver: ModalSolver::new(robot),
            path,
            q: vec![0.0; robot.joints().len()],
            jacobian: Matrix6xX::zeros(n),
            tip_m_per_n: vec![0.0; n],
        }
    }

    fn stand(&mut self, s: f64) -> Result<Isometry3<f64>, SurveyFault> {
        self.walker
            .at(s, &mut self.q)
            .map_err(|fault| SurveyFault { s, cause: SurveyCause::Kinematics(fault) })
    }

    /// Natural frequencies at `s`, Hz, ascending.
    ///
    /// # Errors
    /// The arm has no modes there.
    pub fn frequencies_hz(&mut self, s: f64) -> Result<&[f64], SurveyFault> {
        self.stand(s)?;
        self.solver
            .frequencies_hz(&self.q)
            .map_err(|fault| SurveyFault { s, cause: SurveyCause::Pose(fault) })
    }

    /// Modes at `s`, and with them the tip response.
    ///
    /// # Errors
    /// The arm has no modes there.
    pub fn modes(&mut self, s: f64) -> Result<&Modes, SurveyFault> {
        let tcp = self.stand(s)?;
        self.solver
            .solve(&self.q)
            .map_err(|fault| SurveyFault { s, cause: SurveyCause::Pose(fault) })?;
        let tcp = tcp.translation.vector.into();
        elastic_jacobian(self.path.robot(), self.solver.placement(), &tcp, &mut self.jacobian);
        for (r, tip) in self.tip_m_per_n.iter_mut().enumerate() {
            *tip = peak_tip_compliance_m_per_n(self.solver.modes(), &self.jacobian, r);
        }
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
