//! Arcs and helices → pieces of at most half a turn, each through a point on the way. Lengths in
//! mm.

use std::f64::consts::{PI, TAU};

use nalgebra::{Rotation3, Unit, Vector3};

/// The axes of a plane, the third along its normal, right-handed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Plane(pub(super) [usize; 3]);

impl Plane {
    pub(super) const XY: Self = Self([0, 1, 2]);
    pub(super) const ZX: Self = Self([2, 0, 1]);
    pub(super) const YZ: Self = Self([1, 2, 0]);
}

/// Where the centre is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Centre {
    /// Along the axes of the plane.
    At([f64; 2]),
    /// Radius; negative for the longer of the two arcs.
    Radius(f64),
}

/// An arc as a program gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    pub(super) start: Vector3<f64>,
    pub(super) end: Vector3<f64>,
    pub(super) plane: Plane,
    /// Turns the arc's plane from where its points are; the identity for a plane of the axes.
    pub(super) turn: Rotation3<f64>,
    pub(super) clockwise: bool,
    pub(super) centre: Centre,
    /// Full turns beyond the first way to the end.
    pub(super) more_turns: u32,
}

impl Arc {
    /// An arc about an axis through a centre, counterclockwise seen against the axis.
    pub(super) fn about(
        start: Vector3<f64>,
        end: Vector3<f64>,
        centre: Vector3<f64>,
        axis: Unit<Vector3<f64>>,
    ) -> Self {
        // Most axes are ±z: no turn, no rounding.
        let clockwise = axis.z < 0.0;
        let up = if clockwise { -axis } else { axis };
        let turn = Rotation3::rotation_between(&up, &Vector3::z());
        let turn = turn.unwrap_or_else(Rotation3::identity);
        let centre = turn * centre;
        let centre = Centre::At([centre.x, centre.y]);
        Self { start, end, plane: Plane::XY, turn, clockwise, centre, more_turns: 0 }
    }
}

/// A point on the way and the end of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub(super) via: Vector3<f64>,
    pub(super) end: Vector3<f64>,
}

/// Start and end are this near along the arc where a full turn is meant.
const SAME_POINT_MM: f64 = 1e-6;

/// Controls round places to so much.
const RESOLUTION_MM: f64 = 1e-3;

/// A circle of this radius is one with places so rounded.
const LEAST_RADIUS_MM: f64 = 10.0 * RESOLUTION_MM;

/// The radii at start and end may differ by what programs round to: as LinuxCNC has it.
const RADIUS_TOLERANCE_MM: f64 = 0.005;
const RADIUS_TOLERANCE_SHARE: f64 = 0.001;

/// A piece of a helix is written as the circle through three of its points; it departs by no more.
const HELIX_TOLERANCE_MM: f64 = 1e-3;

const MAX_PIECES: f64 = 100_000.0;

/// The pieces of an arc.
///
/// # Errors
/// An arc that does not exist: the lower-case reason.
pub(super) fn pieces(arc: &Arc) -> Result<Vec<Piece>, String> {
    let Plane([u, v, w]) = arc.plane;
    let [start, end] = [arc.start, arc.end].map(|point| arc.turn * point);
    let from = [start[u], start[v]];
    let to = [end[u], end[v]];
    let centre = match arc.centre {
        Centre::At(centre) => centre,
        Centre::Radius(radius) => centre_of(from, to, radius, arc.clockwise)?,
    };
    let (radius, angle) = polar(from, centre);
    let (end_radius, end_angle) = polar(to, centre);
    let off = (radius - end_radius).abs();
    if off > RADIUS_TOLERANCE_MM && off > RADIUS_TOLERANCE_SHARE * radius.max(end_radius) {
        return Err(format!(
            "the end is {end_radius:.4} mm from the arc's centre, the start {radius:.4} mm"
        ));
    }
    if radius <= SAME_POINT_MM {
        return Err("the arc has no radius".to_owned());
    }
    let sweep = sweep(radius, [angle, end_angle], arc);
    let rise = end[w] - start[w];
    let count = piece_count(radius, sweep, rise);
    if count > MAX_PIECES {
        return Err(format!("the arc takes {count:.0} pieces"));
    }
    let at = |share: f64| {
        let angle = angle + sweep * share;
        let radius = radius + (end_radius - radius) * share;
        let mut point = Vector3::zeros();
        point[u] = centre[0] + radius * angle.cos();
        point[v] = centre[1] + radius * angle.sin();
        point[w] = start[w] + rise * share;
        arc.turn.inverse() * point
    };
    // At least 1 and at most MAX_PIECES.
    let last = count as usize;
    Ok((1..=last)
        .map(|piece| {
            let share = |part: f64| (piece as f64 - part) / count;
            let end = if piece == last { arc.end } else { at(share(0.0)) };
            Piece { via: at(share(0.5)), end }
        })
        .collect())
}

/// Which way an arc ends, in its plane: at the point on the way of a piece the tool goes along the
/// piece's chord, and the chord from there to the end halves the angle that is left.
pub(super) fn heading(arc: &Arc, pieces: &[Piece]) -> Option<Vector3<f64>> {
    let last = pieces.last()?;
    let before = pieces.iter().rev().nth(1).map_or(arc.start, |piece| piece.end);
    let Plane([.., w]) = arc.plane;
    let flat = |from: Vector3<f64>, to: Vector3<f64>| {
        let mut way = arc.turn * (to - from);
        way[w] = 0.0;
        way.try_normalize(1e-9)
    };
    let (whole, rest) = (flat(before, last.end)?, flat(last.via, last.end)?);
    Some(arc.turn.inverse() * (rest * (2.0 * rest.dot(&whole)) - whole))
}

fn polar(point: [f64; 2], centre: [f64; 2]) -> (f64, f64) {
    let [x, y] = [point[0] - centre[0], point[1] - centre[1]];
    (x.hypot(y), y.atan2(x))
}

/// Angle from start to end in the sense of the arc, rad, signed. Where both lie in one direction
/// from the centre, it is a full turn, though their radii differ by what programs round to.
fn sweep(radius: f64, angles: [f64; 2], arc: &Arc) -> f64 {
    let sense = if arc.clockwise { -1.0 } else { 1.0 };
    let turn = (sense * (angles[1] - angles[0])).rem_euclid(TAU);
    let is_full = turn.min(TAU - turn) * radius <= SAME_POINT_MM;
    let turn = if is_full { TAU } else { turn };
    sense * (turn + TAU * f64::from(arc.more_turns))
}

/// How long an arc is whose ends a control may round to one point, about which it then makes a
/// whole circle.
pub(super) fn tiny(arc: &Arc) -> Option<f64> {
    let Centre::At(centre) = arc.centre else { return None };
    let Plane([u, v, _]) = arc.plane;
    let [(radius, start), (_, end)] = [arc.start, arc.end].map(|point| {
        let point = arc.turn * point;
        polar([point[u], point[v]], centre)
    });
    let length = sweep(radius, [start, end], &Arc { more_turns: 0, ..*arc }).abs() * radius;
    (radius > LEAST_RADIUS_MM && length < RESOLUTION_MM).then_some(length)
}

fn piece_count(radius: f64, sweep: f64, rise: f64) -> f64 {
    let mut half_piece = PI / 2.0;
    let pitch = (rise / sweep).abs();
    if pitch > 0.0 {
        // With a half piece h the circle leaves the helix, to leading order, by min(r, p)·h³·√3/27
        // across the circle's plane and by r·p²/(r² + p²)·h⁴/96 in it.
        let across = 3.0_f64.sqrt() / 27.0 * radius.min(pitch);
        let inside = radius * pitch * pitch / (radius * radius + pitch * pitch) / 96.0;
        half_piece = half_piece
            .min((HELIX_TOLERANCE_MM / 2.0 / across).cbrt())
            .min((HELIX_TOLERANCE_MM / 2.0 / inside).powf(0.25));
    }
    // Half a turn that rounding made a little longer is still one piece.
    (sweep.abs() / (2.0 * half_piece) - 1e-9).ceil().max(1.0)
}

/// The centre of the arc of this radius: on the left of the way if it turns left and is the
/// shorter.
pub(super) fn centre_of(
    from: [f64; 2],
    to: [f64; 2],
    radius: f64,
    clockwise: bool,
) -> Result<[f64; 2], String> {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let chord = x.hypot(y);
    if chord <= SAME_POINT_MM {
        return Err("an arc by its radius needs an end apart from its start".to_owned());
    }
    let half = chord / 2.0;
    let short_by = half - radius.abs();
    if short_by > RADIUS_TOLERANCE_MM && short_by > RADIUS_TOLERANCE_SHARE * half {
        return Err(format!(
            "radius {} mm is too small for ends {chord:.4} mm apart",
            radius.abs()
        ));
    }
    let height = (radius * radius - half * half).max(0.0).sqrt();
    let side = if clockwise == (radius > 0.0) { -height } else { height };
    Ok([from[0] + x / 2.0 - side * y / chord, from[1] + y / 2.0 + side * x / chord])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(end: [f64; 3], centre: Centre, clockwise: bool) -> Arc {
        let start = Vector3::new(10.0, 0.0, 0.0);
        let (end, turn) = (end.into(), Rotation3::identity());
        Arc { start, end, plane: Plane::XY, turn, clockwise, centre, more_turns: 0 }
    }

    fn near(found: Vector3<f64>, expected: [f64; 3]) -> bool {
        (found - Vector3::from(expected)).norm() < 1e-9
    }

    #[test]
    fn quarters_three_quarters_and_full_turns() {
        let half = 50.0_f64.sqrt();
        let end = [0.0, 10.0, 0.0];
        let quarter = pieces(&arc(end, Centre::At([0.0; 2]), false)).unwrap();
        assert_eq!(quarter.len(), 1);
        assert!(near(quarter[0].via, [half, half, 0.0]) && near(quarter[0].end, end));
        let rest = pieces(&arc(end, Centre::At([0.0; 2]), true)).unwrap();
        assert_eq!(rest.len(), 2);
        assert!(near(rest[0].end, [-half, -half, 0.0]), "{rest:?}");
        let full = pieces(&arc([10.0, 0.0, 0.0], Centre::At([0.0; 2]), true)).unwrap();
        assert_eq!(full.len(), 2);
        assert!(near(full[0].via, [0.0, -10.0, 0.0]) && near(full[0].end, [-10.0, 0.0, 0.0]));
        assert!(near(full[1].via, [0.0, 10.0, 0.0]));
        // An end that rounding has put a little nearer to the centre or farther from it.
        for off in [-1e-4, 1e-4] {
            let full = pieces(&arc([10.0 + off, 0.0, 0.0], Centre::At([0.0; 2]), true)).unwrap();
            assert_eq!(full.len(), 2, "{full:?}");
            assert!(near(full[0].end, [-10.0 - off / 2.0, 0.0, 0.0]), "{full:?}");
        }
    }

    /// From (10, 0) by the angle that its length is at 10 mm; the whole circle is 62.8 mm.
    #[test]
    fn an_arc_below_the_resolution_of_controls_is_tiny() {
        let of = |y: f64, clockwise| tiny(&arc([10.0, y, 0.0], Centre::At([0.0; 2]), clockwise));
        assert!(of(3e-4, false).is_some_and(|length| (length - 3e-4).abs() < 1e-9));
        assert!(of(-3e-4, true).is_some());
        for (y, clockwise) in [(0.0, false), (3e-4, true), (2e-3, false), (1e-8, false)] {
            assert_eq!(of(y, clockwise), None, "{y} {clockwise}");
        }
        // Of a radius, two points that are one have no circle.
        assert_eq!(tiny(&arc([10.0, 3e-4, 0.0], Centre::Radius(5.0), false)), None);
    }

    #[test]
    fn radius_form_chooses_among_four_arcs() {
        // From (10, 0) to (0, 10): centres (0, 0) and (10, 10).
        let end = [0.0, 10.0, 0.0];
        let (low, high) = (10.0 - 50.0_f64.sqrt(), 50.0_f64.sqrt());
        let first_via = |radius, clockwise| {
            let pieces = pieces(&arc(end, Centre::Radius(radius), clockwise)).unwrap();
            (pieces.len(), pieces[0].via)
        };
        let (count, via) = first_via(10.0, false);
        assert!(count == 1 && near(via, [high, high, 0.0]), "{via:?}");
        let (count, via) = first_via(10.0, true);
        assert!(count == 1 && near(via, [low, low, 0.0]), "{via:?}");
        // The long ones start away from the end.
        let (count, via) = first_via(-10.0, false);
        assert!(count == 2 && via[0] > 10.0, "{via:?}");
        let (count, via) = first_via(-10.0, true);
        assert!(count == 2 && via[1] < 0.0, "{via:?}");
    }

    #[test]
    fn impossible_arcs_are_told() {
        let far = pieces(&arc([0.0, 11.0, 0.0], Centre::At([0.0; 2]), false)).unwrap_err();
        assert!(far.contains("11.0000 mm"), "{far}");
        let small = pieces(&arc([-10.0, 0.0, 0.0], Centre::Radius(9.0), false)).unwrap_err();
        assert!(small.contains("too small"), "{small}");
        let same = pieces(&arc([10.0, 0.0, 0.0], Centre::Radius(9.0), false)).unwrap_err();
        assert!(same.contains("apart"), "{same}");
    }

    /// The circle through start, via and end of each piece, walked and compared with the helix.
    #[test]
    fn pieces_of_a_helix_stay_within_the_tolerance_and_do_not_waste() {
        for (rise, turns) in [(1.0, 0), (-5.0, 1), (60.0, 0), (600.0, 2), (0.01, 0)] {
            let mut arc = arc([0.0, 10.0, rise], Centre::At([0.0; 2]), false);
            arc.more_turns = turns;
            let sweep = PI / 2.0 + TAU * f64::from(turns);
            let mut start = arc.start;
            let mut worst: f64 = 0.0;
            let all = pieces(&arc).unwrap();
            for (index, piece) in all.iter().enumerate() {
                let Piece { via, end } = *piece;
                let (a, b) = (via - start, end - start);
                let normal = a.cross(&b);
                let centre = start
                    + (normal.cross(&a) * b.norm_squared() + b.cross(&normal) * a.norm_squared())
                        / (2.0 * normal.norm_squared());
                let first = index as f64 / all.len() as f64 * sweep;
                for step in 0..=200 {
                    let angle = first + f64::from(step) / 200.0 * sweep / all.len() as f64;
                    let on_helix =
                        Vector3::new(10.0 * angle.cos(), 10.0 * angle.sin(), rise * angle / sweep);
                    let across = normal.normalize().dot(&(on_helix - centre));
                    let inside = (on_helix - centre - normal.normalize() * across).norm()
                        - (start - centre).norm();
                    worst = worst.max(across.hypot(inside));
                }
                start = end;
            }
            assert!(worst < 1.1 * HELIX_TOLERANCE_MM, "{rise} {worst}");
            assert!(all.len() == 1 || worst > 0.1 * HELIX_TOLERANCE_MM, "{rise} {worst}");
        }
    }
}
