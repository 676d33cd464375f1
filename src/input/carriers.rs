//! One robot with each thing that its tip carries in a job.

use std::sync::Arc;

use super::robot::DescribedRobot;
use crate::model::{Inertial, Robot};

/// One robot, with each thing that it carries once.
pub(in crate::input) struct Carriers<'j> {
    described: &'j DescribedRobot,
    pub(in crate::input) own: Arc<Robot>,
    /// What its tip carries by the robot's file, corrections included; `None` where it says
    /// nothing.
    pub(in crate::input) own_kg: Option<f64>,
    /// What corrections hang on its tip on springs of its own, kg.
    pub(in crate::input) hung_kg: f64,
    others: Vec<(Option<Inertial>, Arc<Robot>)>,
}

impl<'j> Carriers<'j> {
    pub(in crate::input) fn new(described: &'j DescribedRobot, own: Arc<Robot>) -> Self {
        let own_kg = own.carried_kg(&described.description);
        let hung_kg = own.hung_kg(&described.description);
        Self { described, own, own_kg, hung_kg, others: Vec::new() }
    }

    /// Mass at the tip by the robot's file, and with what its corrections put there, kg; `None`
    /// where they put nothing there.
    pub(in crate::input) fn corrected_kg(&self) -> Option<(f64, f64)> {
        let of_file = self.own.carried().map_or(0.0, |own| own.inertial.mass_kg);
        let in_all = self.own_kg?;
        (in_all != of_file).then_some((of_file, in_all))
    }

    /// The robot with a body at its tip, or with nothing.
    pub(in crate::input) fn with(&mut self, body: Option<Inertial>) -> Result<Arc<Robot>, String> {
        let carried = self.own.carried();
        let own = carried.filter(|own| own.link == self.own.tip_link());
        if body == own.map(|own| own.inertial)
            && own.is_some() == carried.is_some()
            && self.own_kg == carried.map(|own| own.inertial.mass_kg)
        {
            return Ok(Arc::clone(&self.own));
        }
        if let Some((_, robot)) = self.others.iter().find(|(other, _)| *other == body) {
            return Ok(Arc::clone(robot));
        }
        let description = self.own.description_carrying(&self.described.description, body);
        let robot = Robot::new(&description).map_err(|faults| {
            faults.first().map_or_else(String::new, |fault| fault.what.clone())
        })?;
        let robot = Arc::new(robot);
        self.others.push((body, Arc::clone(&robot)));
        Ok(robot)
    }
}
