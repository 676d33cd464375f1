//! Arcs: CIRCLE before GOTO, and CATIA's TLON,GOFWD/(CIRCLE/…),ON,(LINE/…).

use std::f64::consts::TAU;

use nalgebra::{Unit, Vector3};

use super::lexer::{Statement, Word, is};
use super::{Reader, name, number, unit};
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
        self.arc_to(line, [from, to], arc.centre, (axis.unwrap_or(arc.axis), arc.more_turns))
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

/// The axis about which an arc turns counterclockwise by an angle, rad: the given one, or against
/// it; `None` where both do, as of half and whole turns.
fn turned_by(
    angle: f64,
    [from, to, centre]: [Vector3<f64>; 3],
    axis: Unit<Vector3<f64>>,
) -> Result<Option<Unit<Vector3<f64>>>, String> {
    let (start, end) = (from - centre, to - centre);
    let across = axis.dot(&start.cross(&end));
    let turned = across.atan2(start.dot(&end) - axis.dot(&start) * axis.dot(&end));
    let is_whole = (to - from).norm() <= SAME_POINT_MM;
    let sweep = |turned: f64| if is_whole { TAU } else { turned.rem_euclid(TAU) };
    let [off, off_against] = [turned, -turned].map(|turned| (angle - sweep(turned)).abs());
    if off.min(off_against) > ANGLE_TOLERANCE {
        return Err(format!(
            "the angle is {:.2}°, and its points are {:.2}° apart",
            deg_from_rad(angle),
            deg_from_rad(sweep(turned))
        ));
    }
    let is_open = (off - off_against).abs() < SAME_ANGLE;
    Ok((!is_open).then_some(if off < off_against { axis } else { -axis }))
}
