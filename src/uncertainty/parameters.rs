//! The numbers of a model that may be wrong.

use crate::model::{Coordinate, CoordinateKind, ParameterKind, Robot, UncertainBody};

/// Standard deviation of ln of a spring (and, once the robot was measured, of a body) for which the
/// files state none. A spring that is off by 10 % moves a mode that it holds alone by 5 %, so that
/// the 95 % interval is f (1 ± 10 %), the uncertainty of an uncalibrated model.
pub const ASSUMED_STD: f64 = 0.10;

/// What a parameter scales.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scales {
    /// The spring of this elastic coordinate.
    Spring(usize),
    /// Mass and inertia of this one of [`Robot::bodies`].
    Body(usize),
    /// The drive of this elastic coordinate.
    Drive(usize),
    /// No number of the model: a compliance of the foundation about any axis, which it lacks.
    Foundation,
    /// Likewise a compliance across the axis of this elastic coordinate.
    Bending(usize),
}

/// A number of a model that may be wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// What it scales.
    pub scales: Scales,
    /// Standard deviation of its natural logarithm; of a compliance that the model lacks, of the
    /// compliance against that of the joint that it is compared with.
    pub std: f64,
    /// Whether nobody stated the deviation.
    pub is_assumed: bool,
}

/// What a posterior calls the place of the foundation.
const FOUNDATION: &str = "base";

impl Parameter {
    /// Its kind and the name of its joint, extra coordinate or link.
    pub fn place<'r>(&self, robot: &'r Robot) -> (ParameterKind, &'r str) {
        match self.scales {
            Scales::Spring(i) => (ParameterKind::Spring, &robot.coordinates()[i].name),
            Scales::Body(b) => (ParameterKind::Link, &robot.bodies()[b].link),
            Scales::Drive(i) => (ParameterKind::Drive, &robot.coordinates()[i].name),
            Scales::Foundation => (ParameterKind::Foundation, FOUNDATION),
            Scales::Bending(i) => (ParameterKind::Bending, &robot.coordinates()[i].name),
        }
    }

    fn of(scales: Scales, std: Option<f64>, assumed: f64) -> Option<Self> {
        let parameter = Self { scales, std: std.unwrap_or(assumed), is_assumed: std.is_none() };
        (parameter.std > 0.0).then_some(parameter)
    }

    /// What it is called in messages.
    pub fn name(&self, robot: &Robot) -> String {
        let (kind, at) = self.place(robot);
        let what = match kind {
            ParameterKind::Spring => "stiffness",
            ParameterKind::Link => "mass",
            ParameterKind::Drive => "drive inertia",
            ParameterKind::Foundation => return "compliance of the foundation".to_owned(),
            ParameterKind::Bending => "bending compliance",
        };
        format!("{what} of {at}")
    }
}

/// The parameters of an uncalibrated robot as its files state them; `None` where they state no
/// deviation at all, be it zero. Else springs without one are off by [`ASSUMED_STD`]; bodies and
/// drives without one have no part, but no frequency is then better known than of an uncalibrated
/// robot.
pub fn stated(robot: &Robot) -> Option<Vec<Parameter>> {
    let coordinates = || robot.coordinates().iter();
    let springs = coordinates().flat_map(|c| [c.std, c.drive_std]);
    // What is carried counts as exact without anybody saying so.
    let bodies = robot.bodies().iter().filter(|body| !body.is_payload).map(|body| body.std);
    let is_any = springs.chain(bodies).any(|std| std.is_some());
    is_any.then(|| parameters(robot, 0.0))
}

/// Whether a deviation, be it zero, is stated of every number that a mode depends on.
pub fn states_all(robot: &Robot) -> bool {
    let moves = |body: &&UncertainBody| !robot.carriers_of(body).is_empty();
    robot.bodies().iter().filter(moves).all(|body| body.std.is_some())
        && robot
            .coordinates()
            .iter()
            .all(|c| c.std.is_some() && (c.drive_inertia == 0.0 || c.drive_std.is_some()))
}

/// Every parameter of a robot: springs and bodies without a stated deviation are off by
/// [`ASSUMED_STD`].
pub fn all(robot: &Robot) -> Vec<Parameter> {
    parameters(robot, ASSUMED_STD)
}

/// What a parameter scales in a robot, by the name of its joint, extra coordinate or link; `None`
/// where the robot has no such thing.
pub fn scales_of(robot: &Robot, kind: ParameterKind, at: &str) -> Option<Scales> {
    let coordinate = || robot.coordinates().iter().position(|c| c.name == at);
    match kind {
        ParameterKind::Spring => coordinate().map(Scales::Spring),
        ParameterKind::Drive => coordinate().map(Scales::Drive),
        ParameterKind::Link => {
            // What a job carries on a link is not the link.
            let mut bodies = robot.bodies().iter();
            bodies.position(|body| body.link == at && !body.is_payload).map(Scales::Body)
        }
        ParameterKind::Foundation => softest(robot).map(|_| Scales::Foundation),
        ParameterKind::Bending => {
            coordinate().filter(|&i| turns(&robot.coordinates()[i])).map(Scales::Bending)
        }
    }
}

/// The compliances that an arm of springs at its joints lacks: of the foundation, and across the
/// axis of each elastic joint.
pub fn lacking(robot: &Robot) -> Vec<Scales> {
    let rotary = robot.coordinates().iter().enumerate().filter(|(_, c)| turns(c));
    let bending: Vec<Scales> = rotary.map(|(i, _)| Scales::Bending(i)).collect();
    softest(robot).map(|_| Scales::Foundation).into_iter().chain(bending).collect()
}

/// The spring that a compliance which the model lacks is compared with, N·m/rad.
pub(super) fn compared_with(robot: &Robot, scales: Scales) -> Option<f64> {
    match scales {
        Scales::Foundation => softest(robot),
        Scales::Bending(i) => Some(robot.coordinates()[i].stiffness),
        Scales::Spring(_) | Scales::Body(_) | Scales::Drive(_) => None,
    }
}

fn turns(coordinate: &Coordinate) -> bool {
    coordinate.joint.is_some() && coordinate.kind == CoordinateKind::Rotation
}

/// The softest spring of a rotary joint, N·m/rad.
fn softest(robot: &Robot) -> Option<f64> {
    let rotary = robot.coordinates().iter().filter(|c| turns(c));
    rotary.map(|c| c.stiffness).min_by(f64::total_cmp)
}

fn parameters(robot: &Robot, assumed_of_bodies: f64) -> Vec<Parameter> {
    let coordinates = || robot.coordinates().iter().enumerate();
    let springs =
        coordinates().filter_map(|(i, c)| Parameter::of(Scales::Spring(i), c.std, ASSUMED_STD));
    let bodies =
        robot.bodies().iter().enumerate().filter(|(_, body)| !robot.carriers_of(body).is_empty());
    let bodies =
        bodies.filter_map(|(b, body)| Parameter::of(Scales::Body(b), body.std, assumed_of_bodies));
    let drives = coordinates().filter(|(_, c)| c.drive_inertia > 0.0);
    let drives = drives.filter_map(|(i, c)| Parameter::of(Scales::Drive(i), c.drive_std, 0.0));
    springs.chain(bodies).chain(drives).collect()
}
