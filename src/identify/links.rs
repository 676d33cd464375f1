//! Displacements of marked points → rotation of each link, per mode: the paper's Section 4, Fig. 9.
//!
//! A rigid link in the picture's plane moves a point at r by u + α·(−r_y, r_x) for small α, seen
//! positive from x to y. Over all marked points of a link u and α follow by least squares; with two
//! points that is the paper's plan of displacements.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::estimate::C64;
use super::record::{MarkedLink, Marker};

/// How a link turns relative to the first that turns clearly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sense {
    /// In the same direction at the same time.
    Together,
    /// In the opposite direction.
    Against,
    /// So far out of phase, or so little, that it is neither.
    Unclear,
}

/// The rotation of one link in one mode.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "JsonLink")]
pub struct LinkRotation {
    /// Name of the link.
    pub link: String,
    /// Rotation per unit of the shape, rad: real and imaginary part.
    #[serde(rename = "rotation_rad", serialize_with = "parts")]
    #[schemars(with = "[f64; 2]")]
    pub rotation: C64,
    /// Standard deviation of both.
    #[serde(rename = "std_rad")]
    pub std: f64,
    // Free decays only.
    /// Amplitude when the strongest decay begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_rad: Option<f64>,
    /// Relative to the first link that turns: together, against, unclear.
    #[schemars(with = "String")]
    pub sense: Sense,
}

fn parts<S: Serializer>(value: &C64, to: S) -> Result<S::Ok, S::Error> {
    [value.re, value.im].serialize(to)
}

/// Rotations of all links, from the displacement of each channel in the mode with its standard
/// deviation.
pub(super) fn rotations(
    links: &[MarkedLink],
    displacement: &dyn Fn(&str) -> Option<(C64, f64)>,
    amplitude: Option<f64>,
) -> Vec<LinkRotation> {
    /// Two rotations have a clear sense where their phases lie within 60° of 0° or 180°: its
    /// cosine.
    const CLEAR_COSINE: f64 = 0.5;
    let mut found: Vec<LinkRotation> = links
        .iter()
        .filter_map(|link| {
            let (rotation, std) = rotation(&link.markers, displacement)?;
            let amplitude_rad = amplitude.map(|amplitude| amplitude * rotation.norm());
            let sense = Sense::Unclear;
            Some(LinkRotation { link: link.link.clone(), rotation, std, amplitude_rad, sense })
        })
        .collect();
    let Some(first) = found.iter().position(|link| link.rotation.norm() > 3.0 * link.std) else {
        return found;
    };
    let reference = found[first].rotation;
    for link in &mut found {
        let size = link.rotation.norm() * reference.norm();
        let cosine = (link.rotation * reference.conj()).re / size.max(f64::MIN_POSITIVE);
        link.sense = match cosine {
            _ if link.rotation.norm() <= 3.0 * link.std => Sense::Unclear,
            c if c >= CLEAR_COSINE => Sense::Together,
            c if c <= -CLEAR_COSINE => Sense::Against,
            _ => Sense::Unclear,
        };
    }
    found
}

/// Where a point is, and its displacement along x and y, each with its deviation.
type Moved = ([f64; 2], [(C64, f64); 2]);

fn rotation(
    markers: &[Marker],
    displacement: &dyn Fn(&str) -> Option<(C64, f64)>,
) -> Option<(C64, f64)> {
    let moved: Vec<Moved> = markers
        .iter()
        .map(|marker| {
            let moves = match &marker.channels {
                None => [(C64::default(), 0.0); 2],
                Some([x, y]) => [displacement(x)?, displacement(y)?],
            };
            Some((marker.at_m, moves))
        })
        .collect::<Option<_>>()?;
    let count = moved.len() as f64;
    let centre =
        moved.iter().fold([0.0; 2], |c, (at, _)| [c[0] + at[0] / count, c[1] + at[1] / count]);
    let (mut sum, mut variance, mut spread) = (C64::default(), 0.0, 0.0);
    for (at, [(x, x_std), (y, y_std)]) in &moved {
        let (dx, dy) = (at[0] - centre[0], at[1] - centre[1]);
        sum += y * dx - x * dy;
        variance += (y_std * dx).powi(2) + (x_std * dy).powi(2);
        spread += dx * dx + dy * dy;
    }
    (spread > 0.0).then(|| (sum / spread, variance.sqrt() / spread))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's arm: A fixed, B at the end of link 1, C at the end of link 2; both turn by known
    /// angles.
    #[test]
    fn rotations_of_a_two_link_arm_come_back() {
        let (a, b, c) = ([0.1, 0.2], [0.1 - 0.35, 0.2 + 0.6], [0.55, 0.7]);
        for (alpha_1, alpha_2, sense) in [(1.0, 0.7, Sense::Together), (0.4, -1.3, Sense::Against)]
        {
            let turned = |alpha: f64, from: [f64; 2], to: [f64; 2]| {
                [-alpha * (to[1] - from[1]), alpha * (to[0] - from[0])]
            };
            let at_b = turned(alpha_1, a, b);
            let of_c = turned(alpha_2, b, c);
            let at_c = [at_b[0] + of_c[0], at_b[1] + of_c[1]];
            let phase = C64::from_polar(1.0, 0.4);
            let displacement = |name: &str| {
                let value = match name {
                    "bx" => at_b[0],
                    "by" => at_b[1],
                    "cx" => at_c[0],
                    "cy" => at_c[1],
                    _ => return None,
                };
                Some((phase * value, 1e-3))
            };
            let point = |at_m, names: Option<[&str; 2]>| Marker {
                at_m,
                channels: names.map(|names| names.map(str::to_owned)),
            };
            let links = [
                MarkedLink {
                    link: "link_1".into(),
                    markers: vec![point(a, None), point(b, Some(["bx", "by"]))],
                },
                MarkedLink {
                    link: "link_2".into(),
                    markers: vec![point(b, Some(["bx", "by"])), point(c, Some(["cx", "cy"]))],
                },
                MarkedLink { link: "lost".into(), markers: vec![point(c, Some(["?", "cy"]))] },
            ];
            let found = rotations(&links, &displacement, Some(2.0));
            assert!((found[0].amplitude_rad.unwrap() - 2.0 * alpha_1).abs() < 1e-12);
            assert_eq!(found.len(), 2);
            assert!((found[0].rotation - phase * alpha_1).norm() < 1e-12);
            assert!((found[1].rotation - phase * alpha_2).norm() < 1e-12);
            assert_eq!((found[0].sense, found[1].sense), (Sense::Together, sense));
        }
    }
}
