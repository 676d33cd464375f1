//! Where and how a foundation, a joint or a link gives: elastic coordinates put into a description.

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use crate::model::description::{
    Carries, Description, ExtraCoordinate, Hinge, Inertial, Joint, JointKind, Link,
};

/// How far the centres of a body's two parts may lie apart, as a share of what its inertia allows.
const MAX_SPREAD: f64 = 0.8;

impl Hinge {
    /// Adds the coordinates, called `name`, to the link `at`; the k-th axis has the k-th of the
    /// stiffnesses, or the last. `positions`, ascending, are shares of the link's reach, from its
    /// frame to the farthest joint on it, from the origin of the axes: a hinge is at each, and all
    /// together have the stiffnesses.
    pub(super) fn add(
        &self,
        description: &mut Description,
        at: &str,
        name: &str,
        stiffnesses: &[f64],
        positions: &[f64],
    ) {
        let reach_m = description.reach_of(at);
        let body = description.links.iter().find(|link| link.name == at);
        let about_itself = body.and_then(|link| link.inertial).is_some_and(|own| {
            let inertia = reach_m.dot(&(own.inertia_kgm2 * reach_m));
            inertia > 0.0
        });
        // About the line on which they lie, hinges with no inertia between them are one motion.
        let hinges = |axis: &Vector3<f64>| {
            let is_along = axis.cross(&reach_m).norm() <= 1e-9 * reach_m.norm();
            if is_along && !about_itself { 1 } else { positions.len() }
        };
        let spring = |n: usize| stiffnesses.get(n).or(stiffnesses.last()).copied().unwrap_or(0.0);
        // Of the link's own body there is left what is before the last hinge.
        let mut end = 1.0;
        for (i, &position) in positions.iter().enumerate().rev() {
            let own: Vec<_> = self.axes.iter().enumerate().filter(|(_, a)| i < hinges(a)).collect();
            let hinge = Self {
                axes: own.iter().map(|(_, axis)| **axis).collect(),
                origin_m: self.origin_m + reach_m * position,
                ..self.clone()
            };
            let springs: Vec<f64> =
                own.iter().map(|(n, axis)| spring(*n) * hinges(axis) as f64).collect();
            let moved = match self.carries {
                Carries::Link => at.to_owned(),
                Carries::Part => {
                    let link = description.links.iter_mut().find(|link| link.name == at);
                    let outer = link.and_then(|own| cut(own, &(reach_m * end), &hinge.origin_m));
                    let from = hinge.origin_m.dot(&reach_m);
                    beyond(description, at, i, outer, |joint| {
                        joint.origin.translation.vector.dot(&reach_m) >= from * (1.0 - 1e-9)
                    })
                }
                Carries::Rest => beyond(description, at, i, None, |_| true),
            };
            let outer = if i == 0 { "" } else { ", outer" };
            hinge.give(description, &moved, &format!("{name}{outer}"), &springs);
            end = position;
        }
    }

    /// Takes a point mass at the origin of the axes off the body of the link `at`, or off the
    /// payload there where the link has less.
    pub(super) fn take(
        &self,
        description: &mut Description,
        at: &str,
        mass_kg: f64,
    ) -> Result<(), String> {
        let link = description.links.iter_mut().find(|link| link.name == at);
        let own = link.and_then(|link| link.inertial.as_mut());
        let carried = description.payload.as_mut().filter(|payload| payload.link == at);
        let mut bodies = own.into_iter().chain(carried.map(|payload| &mut payload.inertial));
        let Some(body) = bodies.find(|body| body.mass_kg > mass_kg) else {
            return Err(format!(
                "mass_kg is {mass_kg}, must be less than that of '{at}' or of its payload, which \
                 carries: part takes it from"
            ));
        };
        let point = Inertial { mass_kg: -mass_kg, com_m: self.origin_m, ..Inertial::none() };
        *body = body.combined(&point);
        Ok(())
    }

    /// Hangs a point mass on the link `at`, that moves along the axes against springs of
    /// `stiffness`, N/m, called `name`.
    pub(super) fn hang(
        &self,
        description: &mut Description,
        at: &str,
        name: &str,
        mass_kg: f64,
        stiffness: f64,
    ) {
        let point = Inertial { mass_kg, ..Inertial::none() };
        description.links.push(Link {
            name: name.to_owned(),
            inertial: Some(point),
            is_hung: true,
            ..Link::default()
        });
        let origin = Isometry3::from_parts(self.origin_m.into(), UnitQuaternion::identity());
        weld(description, at, name, format!("{name}, its spring"), origin);
        let own = Self { origin_m: Vector3::zeros(), ..self.clone() };
        own.give(description, name, name, &[stiffness]);
    }

    /// One coordinate of the link `moved` an axis.
    fn give(&self, description: &mut Description, moved: &str, name: &str, stiffnesses: &[f64]) {
        for (i, axis) in self.axes.iter().enumerate() {
            description.extra.push(ExtraCoordinate {
                name: if i == 0 { name.to_owned() } else { format!("{name}, {}", i + 1) },
                link: moved.to_owned(),
                kind: self.kind,
                axis: *axis,
                origin_m: self.origin_m,
                stiffness: stiffnesses.get(i).or(stiffnesses.last()).copied().unwrap_or(0.0),
                std: None,
                damping: None,
            });
        }
    }
}

/// Welds the link `child` onto `parent`.
fn weld(
    description: &mut Description,
    parent: &str,
    child: &str,
    name: String,
    origin: Isometry3<f64>,
) {
    description.joints.push(Joint {
        name,
        kind: JointKind::Fixed,
        parent: parent.to_owned(),
        child: child.to_owned(),
        origin,
        axis: Vector3::x(),
        position_limit: None,
        velocity_limit: None,
        mimics: None,
    });
}

/// A new link in the place of `at` beyond its hinge `i`, with `body` and all that `at` carries
/// there.
fn beyond(
    description: &mut Description,
    at: &str,
    i: usize,
    body: Option<Inertial>,
    is_there: impl Fn(&Joint) -> bool,
) -> String {
    let name = |i: usize| format!("{at}, its {}hinge", if i == 0 { "" } else { "outer " });
    let rest = format!("{at}, beyond its {}hinge", if i == 0 { "" } else { "outer " });
    let next = name(i + 1);
    for joint in description.joints.iter_mut().filter(|joint| joint.parent == at) {
        if joint.name == next || is_there(joint) {
            joint.parent.clone_from(&rest);
        }
    }
    let whole = description.links.iter().find(|link| link.name == at).cloned().unwrap_or_default();
    description.links.push(Link {
        name: rest.clone(),
        inertial: body,
        has_geometry: false,
        ..whole
    });
    weld(description, at, &rest, name(i), Isometry3::identity());
    rest
}

/// Takes the part of a link's body beyond `origin_m` off it, as of a rod along `reach_m`; the two
/// parts together are the body as it was. `None` where there is nothing to take.
fn cut(link: &mut Link, reach_m: &Vector3<f64>, origin_m: &Vector3<f64>) -> Option<Inertial> {
    let whole = link.inertial.filter(|inertial| inertial.mass_kg > 0.0)?;
    let length_m = reach_m.norm();
    if length_m == 0.0 {
        return None;
    }
    let along = reach_m / length_m;
    let inner = (origin_m.dot(&along) / length_m).clamp(0.0, 1.0);
    let outer = 1.0 - inner;
    // ∫ r rᵀ dm about the centre of mass, per mass.
    let tensor = whole.inertia_kgm2 / whole.mass_kg;
    let second = Matrix3::identity() * (0.5 * tensor.trace()) - tensor;
    // Parts farther apart than this would need less than no inertia of their own.
    let spread = second
        .try_inverse()
        .map(|inverse| along.dot(&(inverse * along)) * inner * outer)
        .filter(|spread| spread.is_finite() && *spread > 0.0);
    let apart_m = spread.map_or(0.0, |spread| (MAX_SPREAD / spread.sqrt()).min(0.5 * length_m));
    let left = second - along * along.transpose() * (inner * outer * apart_m * apart_m);
    let part = |share: f64, by_m: f64| {
        let mass_kg = share * whole.mass_kg;
        Inertial {
            mass_kg,
            com_m: whole.com_m + along * by_m,
            inertia_kgm2: (Matrix3::identity() * left.trace() - left) * mass_kg,
        }
    };
    link.inertial = Some(part(inner, -outer * apart_m));
    Some(part(outer, inner * apart_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mass, first and second moment of the two parts are those of the whole.
    #[test]
    fn a_body_that_is_cut_is_the_same_body() {
        let inertial = Inertial {
            mass_kg: 30.0,
            com_m: Vector3::new(0.25, 0.02, 0.03),
            inertia_kgm2: Matrix3::from_diagonal(&Vector3::new(0.3, 1.8, 1.7)),
        };
        let mut link = Link { name: "a".into(), inertial: Some(inertial), ..Link::default() };
        let reach = Vector3::new(0.8, 0.0, 0.1);
        let outer = cut(&mut link, &reach, &(0.3 * reach)).unwrap();
        let inner = link.inertial.unwrap();
        assert!((outer.mass_kg - 21.0).abs() < 1e-12);
        assert!((outer.com_m - inner.com_m).norm() > 0.2);
        let both = inner.combined(&outer);
        assert!((both.mass_kg - 30.0).abs() < 1e-12);
        assert!((both.com_m - inertial.com_m).norm() < 1e-12);
        assert!((both.inertia_kgm2 - inertial.inertia_kgm2).norm() < 1e-10);
        for part in [inner, outer] {
            assert!(part.inertia_kgm2.symmetric_eigenvalues().min() > 0.0, "{part:?}");
        }
    }
}
