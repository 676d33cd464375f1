//! Arcs: CIRCLE before GOTO, and CATIA's TLON,GOFWD/(CIRCLE/…),ON,(LINE/…).

use std::f64::consts::TAU;

use nalgebra::{Unit, Vector3};

use super::lexer::{Statement, Word, is};
use super::{Reader, SAME_AXIS, name, number, unit};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::arc::Arc;
use crate::units::{deg_from_rad, rad_from_deg};

/// CIRCLE without the end that the next GOTO gives, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Open {
    line: usize,
    centre: Vector3<f64>,
    axis: Unit<Vector3<f64>>,
    more_turns: u32,
    /// Of NX, which gives the axis about which it runs clockwise.
    is_of_nx: bool,
    /// How far it turns, rad, either way round.
    angle: Option<f64>,
}

/// An arc that has just ended in a GOTO at feed: further ones may be points on it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ended {
    centre: Vector3<f64>,
    axis: Unit<Vector3<f64>>,
    /// How far it has turned, rad.
    swept: f64,
    points: usize,
    /// Whether it stays at one height.
    is_flat: bool,
}

impl Ended {
    fn radius(&self, at: Vector3<f64>) -> f64 {
        let off = at - self.centre;
        (off - self.axis.into_inner() * off.dot(&self.axis)).norm()
    }

    /// Whether the circle leads from one point to another.
    fn may_lead(&self, from: Vector3<f64>, to: Vector3<f64>) -> bool {
        (to - from).norm() > SAME_POINT_MM
            && (to - from).dot(&self.axis).abs() <= ON_CIRCLE_MM
            && (self.radius(to) - self.radius(from)).abs() <= ON_CIRCLE_MM
    }
}

/// How many points the program gives of an arc.
#[derive(Debug, Clone, Copy)]
pub(super) struct Points {
    /// How far the longest arc with one point alone turns, and the shortest with three or more,
    /// rad.
    single: f64,
    several: f64,
    /// The first line of a further one that is no matter of tolerance.
    further: Option<usize>,
}

impl Default for Points {
    fn default() -> Self {
        Self { single: 0.0, several: f64::INFINITY, further: None }
    }
}

/// A point that lies on the circle of the arc before it is this near to it, mm: no more than an arc
/// may end off its circle.
const ON_CIRCLE_MM: f64 = 0.005;

/// Between points on an arc by tolerance the line and the arc are one up to this, mm.
const SAGITTA_MM: f64 = 0.05;

/// Angles of MOVARC have a few digits, rad.
const ANGLE_TOLERANCE: f64 = 0.02;
const SAME_ANGLE: f64 = 1e-3;

/// Start and end of a full turn are this near, mm.
const SAME_POINT_MM: f64 = 1e-6;

/// Turns of one helix: a job is no spring.
const MOST_TURNS: f64 = 1000.0;

/// The radius that a statement gives may differ from that of its points by what programs round to,
/// mm, and by this share.
const RADIUS_TOLERANCE_MM: f64 = 0.01;
const RADIUS_TOLERANCE_SHARE: f64 = 0.001;

/// Centre, axis, radius, tolerance and its ratio, diameter and corner of the tool.
const NX_VALUES: usize = 11;

impl Reader<'_> {
    /// `CIRCLE/x,y,z,i,j,k[,r,…]`: counterclockwise about the axis, in NX's 11 values clockwise.
    /// Its `TIMES,n` counts the turns of a helix, the last one not whole.
    pub(super) fn circle(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        self.no_arc_is_open(line);
        self.open_arc(line, minor, None)
    }

    /// `MOVARC/x,y,z,i,j,k,r[,ANGLE],a` of Autodesk's posts, some of which write CENTER, AXIS and
    /// RADIUS before their numbers. The angle tells which way round.
    pub(super) fn move_arc(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        const WORDS: [(usize, &str); 4] = [(0, "CENTER"), (3, "AXIS"), (6, "RADIUS"), (7, "ANGLE")];
        let mut numbers: Vec<Word<'_>> = Vec::new();
        for word in minor {
            match word {
                Word::Name(key)
                    if WORDS.iter().any(|(at, own)| *at == numbers.len() && is(key, own)) => {}
                Word::Name(key) => return Err(format!("'{key}' is not understood")),
                number => numbers.push(*number),
            }
        }
        if numbers.len() > 8 {
            return Err("expected x, y, z, i, j, k, a radius and an angle".to_owned());
        }
        let angle = match numbers.len() {
            8 => {
                numbers.pop().as_ref().and_then(number).map(|(angle, _)| rad_from_deg(angle.abs()))
            }
            _ => None,
        };
        self.no_arc_is_open(line);
        self.open_arc(line, &numbers, angle)
    }

    fn open_arc(
        &mut self,
        line: usize,
        minor: &[Word<'_>],
        angle: Option<f64>,
    ) -> Result<(), String> {
        let (minor, more_turns) = match minor {
            [circle @ .., Word::Name(word), Word::Number(turns, _)] if is(word, "TIMES") => {
                if turns.fract() != 0.0 || !(1.0..=MOST_TURNS).contains(turns) {
                    return Err(format!("TIMES is {turns}, must be a whole number from 1 on"));
                }
                (circle, *turns as u32 - 1)
            }
            _ => (minor, 0),
        };
        if let Some(word) = minor.iter().find_map(name) {
            return Err(format!("'{word}' is not understood"));
        }
        let numbers: Vec<f64> = minor.iter().filter_map(number).map(|(n, _)| n).collect();
        let [x, y, z, i, j, k, ref rest @ ..] = *numbers.as_slice() else {
            return Err("expected x, y, z, i, j, k and a radius".to_owned());
        };
        let centre = Vector3::new(x, y, z).map(|length| self.mm(length));
        let axis = unit(Vector3::new(i, j, k))?;
        let is_of_nx = self.senses.is_nx && numbers.len() == NX_VALUES;
        let axis = if is_of_nx { -axis } else { axis };
        let start = self.at.ok_or("an arc before any position")?;
        if let [radius, ..] = *rest {
            let off = start - centre;
            let found = (off - axis.into_inner() * off.dot(&axis)).norm();
            let radius = self.mm(radius).abs();
            let apart = (found - radius).abs();
            if apart > RADIUS_TOLERANCE_MM && apart > RADIUS_TOLERANCE_SHARE * radius {
                return Err(format!(
                    "the radius is {radius} mm, and the tool is {found:.4} mm from the centre"
                ));
            }
        }
        self.arc = Some(Open { line, centre, axis, more_turns, is_of_nx, angle });
        Ok(())
    }

    pub(super) fn close_arc(
        &mut self,
        line: usize,
        arc: Open,
        to: Vector3<f64>,
    ) -> Result<(), String> {
        if self.cycle.is_some() {
            return Err("an arc within a cycle".to_owned());
        }
        let from = self.at.ok_or("an arc before any position")?;
        let axis = match arc.angle {
            Some(angle) => turned_by(angle, [from, to, arc.centre], arc.axis)?,
            None => None,
        };
        match axis {
            Some(axis) => self.senses.shown_by_angle(axis == arc.axis),
            None => self.senses.arc((arc.line, arc.is_of_nx), [from, to, arc.centre], arc.axis),
        }
        let axis = axis.unwrap_or(arc.axis);
        // One that NX writes, or whose angle is given, ends there.
        let is_whole = arc.is_of_nx || arc.angle.is_some() || arc.more_turns > 0;
        let is_flat = (to - from).dot(&axis).abs() <= ON_CIRCLE_MM;
        let may_go_on = !is_whole && !self.rapid;
        self.arc_to(line, [from, to], arc.centre, (axis, arc.more_turns))?;
        let swept = swept([from, to, arc.centre], axis);
        let ended = Ended { centre: arc.centre, axis, swept, points: 1, is_flat };
        self.arc_before = may_go_on.then_some(ended);
        Ok(())
    }

    /// Creo may write several points of an arc behind CIRCLE, the last its end. Others end it in
    /// the first: there a further point on the circle is a doubt where the way to it is another.
    pub(super) fn goes_on_along_arc(
        &mut self,
        line: usize,
        to: Vector3<f64>,
        axis_before: Unit<Vector3<f64>>,
    ) -> Result<bool, String> {
        let (Some(arc), Some(from)) = (self.arc_before, self.at) else { return Ok(false) };
        let turned = swept([from, to, arc.centre], arc.axis);
        let is_within_turn = arc.swept + turned <= TAU + SAME_ANGLE;
        let is_on = arc.is_flat
            && self.axis.angle(&axis_before) <= SAME_AXIS
            && arc.may_lead(from, to)
            && is_within_turn;
        let is_apart = arc.radius(from) * (1.0 - (turned / 2.0).cos()) > SAGITTA_MM;
        if !is_on {
            // Round the same axis at another height: a helix by points, or a line.
            let is_higher = !arc.is_flat || (to - from).dot(&arc.axis).abs() > ON_CIRCLE_MM;
            let is_round = (arc.radius(to) - arc.radius(from)).abs() <= ON_CIRCLE_MM;
            if is_apart && is_higher && is_round && is_within_turn {
                self.doubt_line_behind_arc(line);
            }
            self.leave_arc();
            return Ok(false);
        }
        self.arc_before = Some(Ended { swept: arc.swept + turned, points: arc.points + 1, ..arc });
        if self.is_creo {
            if is_apart {
                self.arc_points.further.get_or_insert(line);
            }
            self.senses.arc_goes_on(to, arc.centre, arc.axis);
            self.arc_to(line, [from, to], arc.centre, (arc.axis, 0))?;
        } else if is_apart {
            self.doubt_line_behind_arc(line);
        }
        Ok(self.is_creo)
    }

    fn doubt_line_behind_arc(&mut self, line: usize) {
        let what = "GOTO right behind an arc lies on the same circle, and is read as a line: some \
                    systems write several points of an arc, the last its end";
        self.cutter.log.warning(Code::MotionLeftOut, line, what);
    }

    /// What follows is no point on the arc before it.
    pub(super) fn leave_arc(&mut self) {
        let arc = self.arc_before.take().filter(|arc| arc.is_flat);
        let Some(Ended { swept, points, .. }) = arc else { return };
        let Points { single, several, .. } = &mut self.arc_points;
        match points {
            1 => *single = single.max(swept),
            // An arc and its chord.
            2 => {}
            _ => *several = several.min(swept),
        }
    }

    /// At the end of the program: Creo gives arcs as many points as their length asks for. Three
    /// on one circle show it; two may be a D.
    pub(super) fn settle_points(&mut self) {
        self.leave_arc();
        let Points { single, several, further } = self.arc_points;
        if let Some(line) = further.filter(|_| several.is_infinite() || single >= several) {
            let what = "GOTO right behind an arc lies on the same circle, and is read as a further \
                        point on the arc, as Creo may write it: no arc has three points, or a \
                        longer one has a single point, so that it may be a line";
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
        }
    }

    /// An arc that nothing ends is motion that is lost.
    pub(super) fn no_arc_is_open(&mut self, line: usize) {
        if let Some(arc) = self.arc.take() {
            let what = format!("CIRCLE: no GOTO follows that ends the arc before line {line}");
            self.cutter.log.error(Code::Motion, arc.line, what);
        }
    }

    fn arc_to(
        &mut self,
        line: usize,
        [from, to]: [Vector3<f64>; 2],
        centre: Vector3<f64>,
        (axis, more_turns): (Unit<Vector3<f64>>, u32),
    ) -> Result<(), String> {
        let pace =
            if std::mem::take(&mut self.rapid) { Pace::Rapid } else { self.cutter.pace()? };
        let frame = self.systems.start();
        let [start, end, centre] = [from, to, centre].map(|point| frame.point(point));
        self.cutter.tilt(frame.axis(self.axis));
        let arc = Arc { more_turns, ..Arc::about(start, end, centre, frame.axis(axis)) };
        self.cutter.arc(line, &arc, pace)?;
        self.at = Some(to);
        Ok(())
    }

    /// `TLON,GOFWD/(CIRCLE/xc,yc,zc,r),ON,[2,INTOF,](LINE/xc,yc,zc,xe,ye,ze)` in the plane across
    /// the tool, or about the axis of `CIRCLE/CANON,xc,yc,zc,i,j,k,r`; starts along INDIRV.
    pub(super) fn along_circle(
        &mut self,
        line: usize,
        statement: &Statement<'_>,
    ) -> Result<(), String> {
        let form = "expected (CIRCLE/x,y,z,r),ON,(LINE/x,y,z,x,y,z)";
        let direction = self.direction.take().ok_or("INDIRV is missing before it")?;
        let from = self.at.ok_or("an arc before any position")?;
        let line_numbers = statement.inside("LINE").ok_or(form)?;
        let circle = statement.inside("CIRCLE").ok_or(form)?;
        // Without parentheses the circle's numbers run on into those of the line.
        let own = circle.len().checked_sub(if circle.len() > 7 { 6 } else { 0 });
        let (centre, axis, radius) = match own.and_then(|own| circle.get(..own)) {
            Some(&[x, y, z, r, ..]) if circle.len() != 7 => (Vector3::new(x, y, z), self.axis, r),
            Some(&[x, y, z, i, j, k, r]) => (Vector3::new(x, y, z), unit([i, j, k].into())?, r),
            _ => return Err(form.to_owned()),
        };
        let [xc, yc, zc, xe, ye, ze] = *line_numbers.as_slice() else {
            return Err(form.to_owned());
        };
        let mm = |at: Vector3<f64>| at.map(|length| self.mm(length));
        let (centre, radius) = (mm(centre), self.mm(radius));
        let (near, far) = (mm([xc, yc, zc].into()), mm([xe, ye, ze].into()));
        let along = (far - near).try_normalize(1e-9).ok_or("the LINE has no direction")?;
        // The line leads from the centre through the end; how long it is differs.
        let to_centre = near - centre;
        let across = |v: Vector3<f64>| v - axis.into_inner() * v.dot(&axis);
        if across(to_centre).norm() > RADIUS_TOLERANCE_MM {
            return Err("the LINE does not start at the centre of the CIRCLE".to_owned());
        }
        let to = far - across(far - near) + across(along).normalize() * radius;
        let to = if to.iter().all(|x| x.is_finite()) { to } else { return Err(form.to_owned()) };
        self.senses.lose();
        let tangent = axis.cross(&across(from - centre));
        let axis = if tangent.dot(&direction) < 0.0 { -axis } else { axis };
        self.arc_to(line, [from, to], centre, (axis, 0))
    }
}

/// How far an arc turns counterclockwise about an axis, rad: by a full turn where it ends where it
/// starts.
fn swept([from, to, centre]: [Vector3<f64>; 3], axis: Unit<Vector3<f64>>) -> f64 {
    if (to - from).norm() <= SAME_POINT_MM {
        return TAU;
    }
    let (start, end) = (from - centre, to - centre);
    let cos = start.dot(&end) - axis.dot(&start) * axis.dot(&end);
    axis.dot(&start.cross(&end)).atan2(cos).rem_euclid(TAU)
}

/// The axis about which an arc turns counterclockwise by an angle, rad: the given one, or against
/// it; `None` where both do, as of half and whole turns.
fn turned_by(
    angle: f64,
    points: [Vector3<f64>; 3],
    axis: Unit<Vector3<f64>>,
) -> Result<Option<Unit<Vector3<f64>>>, String> {
    let ways = [axis, -axis].map(|axis| swept(points, axis));
    let [off, off_against] = ways.map(|way| (angle - way).abs());
    if off.min(off_against) > ANGLE_TOLERANCE {
        return Err(format!(
            "the angle is {:.2}°, and its points are {:.2}° apart",
            deg_from_rad(angle),
            deg_from_rad(ways[0])
        ));
    }
    let is_open = (off - off_against).abs() < SAME_ANGLE;
    Ok((!is_open).then_some(if off < off_against { axis } else { -axis }))
}
