//! Mass properties for links that have none: the mass of the whole arm, distributed by shape.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::description::{Description, Inertial};
use crate::notes::{Code, Note, Part, Place};
use crate::wording::rounded;

/// A link counts as at least this share of the longest: joints whose axes meet have bodies, too.
const MIN_LENGTH_SHARE: f64 = 0.1;

/// Mean density of a link that is taken for a rod, kg/m³: its thickness follows from it. Assumed,
/// castings of aluminium or iron with motors and hollows.
const DENSITY_KG_PER_M3: f64 = 2000.0;

impl Description {
    /// Gives the links with geometry and without inertial what is left of `total_kg`: by the volume
    /// of their boxes, cylinders and spheres if all of them have such, else by their length as rods
    /// of one thickness. Links without geometry are frames, unless no link has any. The note names
    /// the masses.
    ///
    /// # Errors
    /// Nothing is left, or no link is without inertial, or they have no extent.
    pub fn share_mass(&mut self, total_kg: f64) -> Result<Note, Note> {
        let place = Place::key(Part::Robot, "total_mass_kg");
        let refused = |what: String| {
            let what = format!("total_mass_kg is {total_kg}, {what}");
            Note::error(Code::Conflict, place.clone(), what)
        };
        let known_kg: f64 = self.links.iter().flat_map(|l| l.inertial).map(|i| i.mass_kg).sum();
        let any_geometry = self.links.iter().any(|link| link.has_geometry);
        let lacking: Vec<usize> = (0..self.links.len())
            .filter(|&i| self.links[i].inertial.is_none())
            .filter(|&i| if any_geometry { self.links[i].has_geometry } else { self.carries(i) })
            .collect();
        if lacking.is_empty() {
            return Err(refused(
                "but no link lacks an inertial: leave it out, or correct links under inertials"
                    .to_owned(),
            ));
        }
        let left_kg = total_kg - known_kg;
        if left_kg <= 0.0 {
            return Err(refused(format!(
                "must be more than the {} kg of the links that have an inertial",
                rounded(known_kg, 3)
            )));
        }
        let shapes: Option<Vec<Inertial>> = lacking.iter().map(|&i| self.links[i].shape).collect();
        let (how, shapes) = match shapes {
            Some(shapes) => ("volume", shapes),
            None => ("length", self.rods(&lacking, left_kg)),
        };
        let volume: f64 = shapes.iter().map(|shape| shape.mass_kg).sum();
        if !(volume > 0.0 && volume.is_finite()) {
            let what = "but no link has a length to share it by: give the links under inertials";
            return Err(refused(what.to_owned()));
        }
        let mut given = Vec::new();
        for (&i, shape) in lacking.iter().zip(shapes) {
            let link = &mut self.links[i];
            let body = shape.scaled(left_kg / volume);
            given.push(format!("{} {:.3}", link.name, body.mass_kg));
            link.inertial = Some(body);
            link.assumed = true;
        }
        let what = format!(
            "{} kg distributed by {how} among the links without <inertial>: {} kg; these masses \
             and inertias are assumed",
            rounded(left_kg, 3),
            given.join(", ")
        );
        Ok(Note::warning(Code::AssumedMass, place, what))
    }

    /// Whether joints hang on a link.
    fn carries(&self, link: usize) -> bool {
        self.joints.iter().any(|joint| joint.parent == self.links[link].name)
    }

    /// The links as rods from their frame to the farthest joint, of one thickness and of density 1.
    fn rods(&self, links: &[usize], mass_kg: f64) -> Vec<Inertial> {
        let reaches: Vec<Vector3<f64>> =
            links.iter().map(|&i| self.reach_of(&self.links[i].name)).collect();
        let longest_m = reaches.iter().map(Vector3::norm).fold(0.0, f64::max);
        let length_m = |reach: &Vector3<f64>| reach.norm().max(MIN_LENGTH_SHARE * longest_m);
        let all_m: f64 = reaches.iter().map(length_m).sum();
        let radius_m = (mass_kg / (std::f64::consts::PI * DENSITY_KG_PER_M3 * all_m)).sqrt();
        let rod = |reach: &Vector3<f64>| {
            let along = UnitQuaternion::rotation_between(&Vector3::z(), reach)
                // Opposite to z, or no direction at all: a rod looks the same from both ends.
                .unwrap_or_default();
            let middle = Isometry3::from_parts((reach / 2.0).into(), along);
            Inertial::cylinder(radius_m, length_m(reach)).transformed(&middle)
        };
        reaches.iter().map(rod).collect()
    }
}
