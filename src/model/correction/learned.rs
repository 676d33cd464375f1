//! Means that a calibration learned, put into a description.

use crate::model::description::Description;
use crate::model::posterior::{LearnedParameter, ParameterKind, Posterior};
use crate::notes::{Code, Note, Part, Place};

impl Posterior {
    /// Scales the numbers of a description, whose corrections have been put in.
    pub(super) fn apply(&self, description: &mut Description) -> Result<(), Note> {
        let own = self.parameters.iter().filter(|parameter| !parameter.kind.is_lacking());
        for LearnedParameter { kind, at, ln, .. } in own {
            let factor = ln.exp();
            let found = match kind {
                ParameterKind::Spring => scale_spring(description, at, factor),
                ParameterKind::Link => description
                    .links
                    .iter_mut()
                    .find(|link| link.name == *at)
                    .and_then(|link| link.inertial.as_mut())
                    .map(|inertial| {
                        inertial.mass_kg *= factor;
                        inertial.inertia_kgm2 *= factor;
                    }),
                ParameterKind::Drive => description
                    .drives
                    .iter_mut()
                    .find(|drive| drive.joint == *at)
                    .map(|drive| drive.reflected_inertia_kgm2 *= factor),
                ParameterKind::Foundation | ParameterKind::Bending => Some(()),
            };
            if found.is_none() {
                let what = format!(
                    "calibration.posterior names '{at}', which the model lacks; run detune \
                     diagnose --write again"
                );
                return Err(Note::error(Code::Reference, Place::part(Part::Robot), what));
            }
        }
        Ok(())
    }
}

fn scale_spring(description: &mut Description, at: &str, factor: f64) -> Option<()> {
    let joints = description.elastic_joints.iter_mut();
    if let Some(spring) = joints.filter(|spring| spring.joint == at).last() {
        spring.stiffness *= factor;
        return Some(());
    }
    let mut extra = description.extra.iter_mut();
    extra.find(|extra| extra.name == at).map(|extra| extra.stiffness *= factor)
}
