//! Tangential ways: CT, and APPR and DEP onto a contour and off it in the plane X/Y (HEIDENHAIN,
//! TNC 640 Conversational Programming, "Approaching and departing a contour"). A depth that the
//! same block names is taken apart, where the way in the plane allows it.

use nalgebra::{Rotation3, Vector2, Vector3};

use super::Reader;
use super::block::Block;
use crate::notes::Code;
use crate::program::Pace;
use crate::program::arc::{Arc, Centre, Plane, centre_of};

/// Below this a length or a sine counts as zero, mm.
const ZERO: f64 = 1e-9;

/// An LCT whose line meets the contour nearer to the contour's point than this has no arc: programs
/// round to so much. mm.
const NO_ARC: f64 = 0.005;

/// Beyond this it is no rounding of the reckoning, mm.
const ROUNDING: f64 = 1e-6;

/// Blocks between an approach and the contour's first element.
const NEAR: usize = 20;

/// To the left of a direction.
fn left(of: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-of.y, of.x)
}

/// A direction turned counterclockwise, rad.
fn turned(of: Vector2<f64>, by: f64) -> Vector2<f64> {
    of * by.cos() + left(of) * by.sin()
}

impl Reader<'_, '_> {
    /// CT: an arc that goes on along the last element.
    pub(super) fn tangential(
        &mut self,
        line: usize,
        block: &Block<'_>,
        pace: Pace,
    ) -> Result<(), String> {
        let [Some(x), Some(y), Some(z)] = self.end_of(block)? else {
            return Err("an arc to an unknown position".to_owned());
        };
        let start = self.cutter.place().ok_or("an arc from an unknown position")?;
        let along = self.heading.ok_or("CT behind no element of a contour")?;
        let end = Vector3::new(x, y, z);
        let chord = (end - start).xy();
        let across = chord.dot(&left(along));
        if across.abs() <= ZERO * chord.norm().max(1.0) {
            return Err("CT ends straight ahead or where it begins".to_owned());
        }
        let centre = start.xy() + left(along) * (chord.norm_squared() / (2.0 * across));
        self.turn_about(line, end, centre, across < 0.0, pace)
    }

    /// An arc in X/Y, and where it heads.
    fn turn_about(
        &mut self,
        line: usize,
        end: Vector3<f64>,
        centre: Vector2<f64>,
        clockwise: bool,
        pace: Pace,
    ) -> Result<(), String> {
        let start = self.cutter.place().ok_or("an arc from an unknown position")?;
        let arc = Arc {
            start,
            end,
            plane: Plane::XY,
            turn: Rotation3::identity(),
            clockwise,
            centre: Centre::At([centre.x, centre.y]),
            more_turns: 0,
        };
        self.heading = heading(end.xy() - centre, clockwise);
        self.cutter.arc(line, &arc, pace)
    }

    /// Which APPR or DEP: those with P before their name are the same by polar coordinates.
    fn way<'t>(block: &Block<'t>) -> &'t str {
        let name = block.name(1);
        match (block.name(0), name) {
            ("APPR", "PLT" | "PLN" | "PCT" | "PLCT") | ("DEP", "PLCT") => &name[1..],
            _ => name,
        }
    }

    /// Where APPR or DEP leads.
    fn end_of_way(&self, block: &Block<'_>) -> Result<[Option<f64>; 3], String> {
        let mut end = self.end_of(block)?;
        if Self::way(block) != block.name(1) {
            let shown = format!("{} {}", block.name(0), block.name(1));
            if block.get("PR").is_none() || block.get("PA").is_none() {
                return Err(format!("{shown} needs PR and PA"));
            }
            if self.plane() != Plane::XY {
                return Err(format!("{shown} about a CC in another plane than X/Y"));
            }
            let [x, y] = self.polar(self.at(), block)?;
            (end[0], end[1]) = (Some(x), Some(y));
        }
        Ok(end)
    }

    /// APPR: from where the tool is to a point on the way, at the pace of the block before, and on
    /// to the contour's first point.
    pub(super) fn approach(
        &mut self,
        line: usize,
        block: &Block<'_>,
        before: Option<Pace>,
        pace: Pace,
    ) -> Result<(), String> {
        let [Some(x), Some(y), Some(z)] = self.end_of_way(block)? else {
            return Err("APPR to an unknown position".to_owned());
        };
        let from = self.cutter.place().ok_or("APPR from an unknown position")?;
        let first = Vector2::new(x, y);
        let along = self.heading_of_next([Some(x), Some(y), Some(z)])?;
        let (way, arc) = match Self::way(block) {
            "LT" => (first - along * self.length(block, "LEN")?, None),
            "LN" => (first + left(along) * (self.sign()? * self.length(block, "LEN")?), None),
            "CT" => {
                let (centre, sense, angle) = self.arc_at(block, first, along)?;
                let back = turned(first - centre, -sense * angle);
                (centre + back, Some((centre, sense < 0.0)))
            }
            "LCT" => {
                let sense = self.sign()?;
                let radius = self.length(block, "R")?;
                let centre = first + left(along) * (sense * radius);
                let toward = tangent_from(from.xy(), centre, radius, sense)?;
                match self.leaves_out_arc(line, [toward, first], centre, sense) {
                    true => (first, None),
                    false => (toward, Some((centre, sense < 0.0))),
                }
            }
            other => return Err(format!("APPR {other} is not supported")),
        };
        let pace_to_way = match Self::way(block) {
            "LCT" => pace,
            _ => before.ok_or("APPR behind no move that says how fast")?,
        };
        let above = Vector3::new(way.x, way.y, from.z);
        self.cutter.apart(line, above, pace_to_way);
        self.cutter.apart(line, Vector3::new(way.x, way.y, z), pace_to_way);
        let end = Vector3::new(x, y, z);
        match arc {
            Some((centre, clockwise)) => self.turn_about(line, end, centre, clockwise, pace)?,
            None => self.cutter.apart(line, end, pace),
        }
        self.heading = Some(along);
        self.tell_depth(line, [from.z, z]);
        Ok(())
    }

    /// Controls differ in the way of the tool axis.
    fn tell_depth(&mut self, line: usize, [from, to]: [f64; 2]) {
        if from != to {
            let what = "APPR or DEP with a depth: Z is taken to move apart, between the ways in \
                        the plane, and newer controls move all axes at once, on another path; \
                        write Z in a block of its own";
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// Leaves out the arc of an LCT whose line and the contour are one line, so that it turns by
    /// nothing from one point to the other: then true. Where rounding puts the points the other way
    /// about, it would go round the whole circle, which is told.
    fn leaves_out_arc(
        &mut self,
        line: usize,
        [from, to]: [Vector2<f64>; 2],
        centre: Vector2<f64>,
        sense: f64,
    ) -> bool {
        let gap = (to - from).norm();
        let goes_round = sense * (from - centre).perp(&(to - centre)) < 0.0;
        if goes_round && gap > ROUNDING && gap <= NO_ARC {
            let what = format!(
                "the line of APPR or DEP LCT is tangent to the contour up to {gap:.4} mm, and is \
                 read without an arc: the control may go round a whole circle; write LT"
            );
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
        gap <= NO_ARC
    }

    /// DEP: off the contour, along the last element, across it or on an arc.
    pub(super) fn depart(
        &mut self,
        line: usize,
        block: &Block<'_>,
        pace: Pace,
    ) -> Result<(), String> {
        let from = self.cutter.place().ok_or("DEP from an unknown position")?;
        let along = self.heading.ok_or("DEP behind no element of a contour")?;
        let [x, y, z] = self.end_of_way(block)?;
        let (here, depth) = (from.xy(), from.z);
        let height = z.ok_or("DEP to an unknown position")?;
        let level = |at: Vector2<f64>| Vector3::new(at.x, at.y, depth);
        let end = match Self::way(block) {
            "LT" => here + along * self.length(block, "LEN")?,
            "LN" => here + left(along) * (self.sign()? * self.length(block, "LEN")?),
            "CT" => {
                let (centre, sense, angle) = self.arc_at(block, here, along)?;
                let end = centre + turned(here - centre, sense * angle);
                self.turn_about(line, level(end), centre, sense < 0.0, pace)?;
                end
            }
            "LCT" => {
                let end = Vector2::new(x.ok_or("DEP LCT without X")?, y.ok_or("and without Y")?);
                let sense = self.sign()?;
                let radius = self.length(block, "R")?;
                let centre = here + left(along) * (sense * radius);
                // The way backwards: from the end to the circle, in the other sense.
                let off = tangent_from(end, centre, radius, -sense)?;
                if !self.leaves_out_arc(line, [here, off], centre, sense) {
                    self.turn_about(line, level(off), centre, sense < 0.0, pace)?;
                }
                end
            }
            other => return Err(format!("DEP {other} is not supported")),
        };
        self.cutter.apart(line, level(end), pace);
        self.cutter.apart(line, Vector3::new(end.x, end.y, height), pace);
        self.tell_depth(line, [depth, height]);
        self.heading = None;
        self.side = None;
        Ok(())
    }

    /// 1 where the tool is to the left of the contour, -1 to the right.
    fn sign(&self) -> Result<f64, String> {
        match self.side {
            Some(true) => Ok(1.0),
            Some(false) => Ok(-1.0),
            None => Err("APPR and DEP without RL or RR: the side is not stated".to_owned()),
        }
    }

    /// Centre, sense (1 counterclockwise) and angle of a CT at a point of the contour. A negative
    /// radius turns to the other side.
    fn arc_at(
        &self,
        block: &Block<'_>,
        at: Vector2<f64>,
        along: Vector2<f64>,
    ) -> Result<(Vector2<f64>, f64, f64), String> {
        let radius = self.mm(block.get("R").ok_or("CT without R")?);
        let angle = block.get("CCA").ok_or("CT without CCA")?;
        if radius == 0.0 || !(angle > 0.0 && angle < 360.0) {
            return Err("CT needs a radius, and CCA between 0 and 360".to_owned());
        }
        let sense = self.sign()? * radius.signum();
        let centre = at + left(along) * (sense * radius.abs());
        Ok((centre, sense, crate::units::rad_from_deg(angle)))
    }

    /// A length of a block, mm, which must be positive.
    fn length(&self, block: &Block<'_>, name: &str) -> Result<f64, String> {
        let value = block.get(name).ok_or_else(|| format!("{} without {name}", block.name(0)))?;
        if value > 0.0 {
            Ok(self.mm(value))
        } else {
            Err(format!("{name} is {value}, must be positive"))
        }
    }

    /// Where the contour's first element heads, from its first point.
    fn heading_of_next(&self, from: [Option<f64>; 3]) -> Result<Vector2<f64>, String> {
        let at = Vector2::new(from[0].unwrap_or(f64::NAN), from[1].unwrap_or(f64::NAN));
        let mut pole = self.pole.filter(|(_, plane)| *plane == Plane::XY);
        for text in self.blocks.iter().skip(self.next).take(NEAR) {
            let block = self.parsed(text);
            let end = self.end_from(from, &block)?;
            let end = || match end {
                [Some(x), Some(y), _] => Ok(Vector2::new(x, y)),
                _ => Err("the contour's first element ends at an unknown position".to_owned()),
            };
            let clockwise = || block.word("DR").and_then(|word| word.sign).map(|plus| !plus);
            let turning = "an arc without DR+ or DR-";
            let found = match block.name(0) {
                "" | "RND" | "CHF" => continue,
                // A label that is passed; LBL 0 leads elsewhere.
                "LBL" if block.words.get(1).is_none_or(|word| word.value != Some(0.0)) => continue,
                "CC" if !(block.has("Z") || block.has("IZ")) => {
                    pole = Some((end()?.into(), Plane::XY));
                    continue;
                }
                "L" => (end()? - at).try_normalize(ZERO),
                "LP" => {
                    let [x, y] = self.polar_about(pole, from, &block)?;
                    (Vector2::new(x, y) - at).try_normalize(ZERO)
                }
                "C" | "CP" => {
                    let (centre, _) = pole.ok_or("an arc in X/Y without CC before it")?;
                    heading(at - Vector2::from(centre), clockwise().ok_or(turning)?)
                }
                "CR" => {
                    let radius = self.mm(block.get("R").ok_or("CR without R")?);
                    let clockwise = clockwise().ok_or(turning)?;
                    let [from, to] = [[at.x, at.y], end()?.into()];
                    let centre = centre_of(from, to, radius, clockwise)?;
                    heading(at - Vector2::from(centre), clockwise)
                }
                _ => break,
            };
            return found.ok_or_else(|| "the contour's first element has no direction".to_owned());
        }
        Err("APPR: the contour must go on with L, LP, C, CP or CR".to_owned())
    }
}

/// The direction of a way round a centre.
pub(super) fn heading(radius: Vector2<f64>, clockwise: bool) -> Option<Vector2<f64>> {
    let sense = if clockwise { -1.0 } else { 1.0 };
    (left(radius) * sense).try_normalize(ZERO)
}

/// Where a line from a point meets a circle that goes on in its direction, with the centre to the
/// left of it where `sense` is 1.
fn tangent_from(
    from: Vector2<f64>,
    centre: Vector2<f64>,
    radius: f64,
    sense: f64,
) -> Result<Vector2<f64>, String> {
    let way = centre - from;
    let distance = way.norm();
    if distance <= radius {
        return Err("the way to the contour begins or ends inside its arc".to_owned());
    }
    let along = turned(way / distance, -sense * (radius / distance).asin());
    Ok(from + along * (distance * distance - radius * radius).sqrt())
}
