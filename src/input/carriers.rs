//! One robot with each thing that its tip carries in a job.

use std::sync::Arc;

use super::robot::DescribedRobot;
use crate::model::{Inertial, Robot};

/// One robot, with each thing that it carries once.
pub(in crate::input) struct Carriers<'j> {
    described: &'j DescribedRobot,
    pub(in crate::input) own: Arc<Robot>,
    others: Vec<(Option<Inertial>, Arc<Robot>)>,
}

impl<'j> Carriers<'j> {
    pub(in crate::input) fn new(described: &'j DescribedRobot, own: Arc<Robot>) -> Self {
        Self { described, own, others: Vec::new() }
    }

    /// The robot with a body at its tip, or with nothing.
    pub(in crate::input) fn with(&mut self, body: Option<Inertial>) -> Result<Arc<Robot>, String> {
        let own = self.own.carried().filter(|own| own.link == self.own.tip_link());
        if body == own.map(|own| own.inertial) && own.is_some() == self.own.carried().is_some() {
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
