//! Lines and arcs, and corners between two lines: `,R`, `,C`, RND=, CHR=, CHF=.

use nalgebra::{Rotation2, Rotation3, Unit, Vector2, Vector3};

use super::arc_plane::code;
use super::block::{
    Block, CHAMFER_LENGTH, CHAMFERED, Counts, ON_THE_WAY, OPENING, POLAR_ANGLE, POLAR_RADIUS,
    RADIUS, ROUNDED, TURNS,
};
use super::frame::Place;
use super::state::{AXES, Machine, MovedWork, Tip};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::arc::{Arc, Centre, Plane, pieces};
use crate::program::corner::{Corner, Kind};
use crate::units::rad_from_deg;

/// Programs round places to so much, mm.
const ROUNDING_MM: f64 = 0.01;

/// One arc closes clearly better than another where it is off by this share of that.
const CLEARLY: f64 = 0.1;

/// Whether places are one up to rounding.
fn is_near(from: Place, to: Place) -> bool {
    let all = from.into_iter().zip(to);
    let ways = all.map(|(from, to)| from.zip(to).map_or(f64::INFINITY, |(from, to)| to - from));
    ways.map(|way| way * way).sum::<f64>().sqrt() <= ROUNDING_MM
}

/// What a block asks for, and the size in mm.
pub(super) fn asked(block: &Block, mm: impl Fn(f64) -> f64) -> Result<Option<(Kind, f64)>, String> {
    let asked =
        [(ROUNDED, Kind::Round), (CHAMFERED, Kind::OffLines), (CHAMFER_LENGTH, Kind::Chamfer)];
    let mut found =
        asked.into_iter().filter_map(|(letter, kind)| Some((kind, mm(block.word(letter)?.value))));
    match (found.next(), found.next()) {
        (Some(_), Some(_)) => Err("a corner is both rounded and chamfered".to_owned()),
        (Some((_, size)), None) if size < 0.0 => {
            Err(format!("the size of a corner is {size} mm, must not be negative"))
        }
        (found, _) => Ok(found.filter(|(_, size)| *size > 0.0)),
    }
}

impl Machine<'_> {
    pub(super) fn straight(
        &mut self,
        line: usize,
        block: &Block,
        pace: Pace,
    ) -> Result<(), String> {
        let from = self.at();
        let end = self.end_of(block)?;
        let tip = match (pace, is_near(from, end)) {
            (Pace::Rapid, true) => Tip::StaysByRapid,
            (Pace::Rapid, false) => Tip::Rapid,
            (_, true) => Tip::Stays,
            (_, false) => Tip::Feed,
        };
        self.turn(line, block, tip)?;
        let corner = asked(block, |length| self.mm(length))?;
        match end {
            [Some(x), Some(y), Some(z)] => self.line_to(line, Vector3::new(x, y, z), pace, corner),
            _ => {
                self.cutter.goes_partly(line, end);
                if pace == Pace::Rapid { Ok(()) } else { Err(self.cutter.unknown(line)) }
            }
        }
    }

    pub(super) fn arc(
        &mut self,
        line: usize,
        block: &Block,
        clockwise: bool,
    ) -> Result<(), String> {
        self.turn(line, block, Tip::Feed)?;
        if asked(block, |length| length)?.is_some() {
            return Err("a corner at the end of an arc is not supported".to_owned());
        }
        let pace = self.cutter.pace()?;
        let start = self.cutter.place().ok_or_else(|| self.cutter.unknown(line))?;
        let [Some(x), Some(y), Some(z)] = self.end_of(block)? else {
            return Err("an arc to an unknown position".to_owned());
        };
        if self.polar.is_on && block.has_any(b"IJK") {
            return Err("a centre under G16 is not supported".to_owned());
        }
        let mut end = Vector3::new(x, y, z);
        let plane = self.plane_of_arc(line, block, [start, end], clockwise)?;
        let centre = match block.word(OPENING) {
            Some(opening) => self.opened(block, [start, end], opening.value)?,
            None => self.centre(block, start, plane, self.centre_absolute)?,
        };
        if let (Some(opening), Centre::At(centre)) = (block.word(OPENING), centre) {
            let Plane([u, v, _]) = self.plane;
            let turned = if clockwise { -opening.value } else { opening.value };
            let way = Vector2::new(start[u] - centre[0], start[v] - centre[1]);
            let way = Rotation2::new(rad_from_deg(turned)) * way;
            (end[u], end[v]) = (centre[0] + way.x, centre[1] + way.y);
        }
        // Fanuc and LinuxCNC count the first turn, Sinumerik does not.
        let more_turns = match block.word(TURNS) {
            Some(word) => word.value,
            None => block.get('P').unwrap_or(1.0) - 1.0,
        };
        if !(0.0..=999.0).contains(&more_turns) || more_turns.fract() != 0.0 {
            return Err("P or TURN= must be a whole number of turns".to_owned());
        }
        let arc = Arc {
            start,
            end,
            plane,
            turn: Rotation3::identity(),
            clockwise,
            centre,
            // Whole and in 0..1000, checked above.
            more_turns: more_turns as u32,
        };
        self.no_corner()?;
        if self.rotary.moves_work() {
            return Err("an arc while a rotary axis of the work is used".to_owned());
        }
        self.cutter.tell_tiny(line, &arc);
        self.cutter.arc(line, &arc, pace).map_err(|why| match self.fits_absolute(block, &arc) {
            true => format!("{why}; as places (G90.1) I, J and K fit: the program must say so"),
            false if plane != self.plane => {
                format!("{why}, in the plane of {} that its axes name", code(plane))
            }
            false => why,
        })
    }

    /// The centre of an arc with an opening angle, AR=, which stands with it or with the end.
    fn opened(
        &self,
        block: &Block,
        [start, end]: [Vector3<f64>; 2],
        angle: f64,
    ) -> Result<Centre, String> {
        if !(angle > 0.0 && angle < 360.0) {
            return Err(format!("AR= is {angle}°, must lie between 0 and 360"));
        }
        let Plane([u, v, _]) = self.plane;
        let gives_end = block.has_any(&[AXES[u], AXES[v], POLAR_ANGLE, POLAR_RADIUS]);
        match (gives_end, block.has_any(b"IJK")) {
            _ if block.has_any(&[RADIUS, b'R']) => Err("AR= beside a radius".to_owned()),
            (false, true) => self.centre(block, start, self.plane, self.centre_absolute),
            (true, false) => {
                let chord = (end[u] - start[u]).hypot(end[v] - start[v]);
                let radius = chord / 2.0 / rad_from_deg(angle / 2.0).sin();
                Ok(Centre::Radius(if angle > 180.0 { -radius } else { radius }))
            }
            _ => Err("AR= stands with the centre (I, J, K) or with the end in the plane, one of \
                      the two"
                .to_owned()),
        }
    }

    /// Whether an arc would close if I, J and K were the place of its centre, and so much better
    /// that it is no accident: about a centre far away any short way nearly closes.
    fn fits_absolute(&self, block: &Block, arc: &Arc) -> bool {
        let Plane([u, v, _]) = arc.plane;
        let off = |centre: Centre| match centre {
            Centre::At([x, y]) => {
                let radius = |at: Vector3<f64>| (at[u] - x).hypot(at[v] - y);
                (radius(arc.start) - radius(arc.end)).abs()
            }
            Centre::Radius(_) => 0.0,
        };
        let fits = |centre: Centre| {
            off(centre) < CLEARLY * off(arc.centre) && pieces(&Arc { centre, ..*arc }).is_ok()
        };
        !self.centre_absolute && self.centre(block, arc.start, arc.plane, true).is_ok_and(fits)
    }

    /// CIP: through a point on the way.
    pub(super) fn arc_through(&mut self, line: usize, block: &Block) -> Result<(), String> {
        let [start, end] = self.ends_of_arc(line, block)?;
        let mut via = start;
        let shift = self.shift.total();
        for (axis, letter) in ON_THE_WAY.into_iter().enumerate() {
            let Some(word) = block.word(letter) else { continue };
            let is_relative = match word.counts {
                Counts::AsModal => self.relative,
                Counts::Absolute => false,
                Counts::Relative => true,
            };
            via[axis] = self.mm(word.value) + if is_relative { start[axis] } else { shift[axis] };
        }
        let [a, b] = [via - start, end - start];
        let normal = a.cross(&b);
        if normal.norm() <= 1e-9 * a.norm() * b.norm() || !block.has_any(&ON_THE_WAY) {
            return Err("CIP: its three points lie on one line".to_owned());
        }
        let towards = normal.cross(&a) * b.norm_squared() + b.cross(&normal) * a.norm_squared();
        let centre = start + towards / (2.0 * normal.norm_squared());
        let pace = self.cutter.pace()?;
        self.cutter.arc(line, &Arc::about(start, end, centre, Unit::new_normalize(normal)), pace)
    }

    /// CT: on from the line or arc before without a bend, in the plane.
    pub(super) fn arc_tangent(&mut self, line: usize, block: &Block) -> Result<(), String> {
        let [start, end] = self.ends_of_arc(line, block)?;
        let Plane([u, v, _]) = self.plane;
        let heading = self.cutter.heading.map(|way| Vector2::new(way[u], way[v]));
        let heading = heading.and_then(|way| way.try_normalize(1e-9));
        let heading = heading.ok_or("CT behind no line or arc in the plane")?;
        let chord = Vector2::new(end[u] - start[u], end[v] - start[v]);
        let left = Vector2::new(-heading.y, heading.x);
        let off = left.dot(&chord);
        let pace = self.cutter.pace()?;
        if off.abs() <= 1e-9 * chord.norm() {
            return if heading.dot(&chord) > 0.0 {
                self.line_to(line, end, pace, None)
            } else {
                Err("CT: the end lies straight behind the tool".to_owned())
            };
        }
        let to_centre = left * (chord.norm_squared() / (2.0 * off));
        let arc = Arc {
            start,
            end,
            plane: self.plane,
            turn: Rotation3::identity(),
            clockwise: off < 0.0,
            centre: Centre::At([start[u] + to_centre.x, start[v] + to_centre.y]),
            more_turns: 0,
        };
        self.cutter.arc(line, &arc, pace)
    }

    /// Start and end of an arc of Sinumerik's.
    fn ends_of_arc(&mut self, line: usize, block: &Block) -> Result<[Vector3<f64>; 2], String> {
        self.turn(line, block, Tip::Feed)?;
        self.no_corner()?;
        if asked(block, |length| length)?.is_some() {
            return Err("a corner at the end of an arc is not supported".to_owned());
        }
        if self.rotary.moves_work() {
            return Err("an arc while a rotary axis of the work is used".to_owned());
        }
        let start = self.cutter.place().ok_or_else(|| self.cutter.unknown(line))?;
        match self.end_of(block)? {
            [Some(x), Some(y), Some(z)] => Ok([start, Vector3::new(x, y, z)]),
            _ => Err("an arc to an unknown position".to_owned()),
        }
    }

    /// A line, with the corner before it cut off, and the one behind it to be.
    pub(super) fn line_to(
        &mut self,
        line: usize,
        to: Vector3<f64>,
        pace: Pace,
        corner: Option<(Kind, f64)>,
    ) -> Result<(), String> {
        self.cut_corner(to)?;
        match corner {
            Some((kind, size)) => {
                let pace_in_corner = pace;
                self.corner = Some(Corner { kind, size, line, to, pace, pace_in_corner });
                Ok(())
            }
            None => {
                let at = self.rotary.in_work(to);
                self.cutter.line_to(line, at, pace);
                // Where the text has it.
                self.cutter.at = [Some(to.x), Some(to.y), Some(to.z)];
                self.starts(line);
                Ok(())
            }
        }
    }

    /// G92 or G10 L20: where the tool stands has these coordinates. Where the place was not known,
    /// the path starts there.
    pub(super) fn stand_at(
        &mut self,
        line: usize,
        axes: [Option<f64>; 3],
        is_of_offset: bool,
    ) -> Result<(), String> {
        self.no_corner()?;
        let was_known = self.cutter.place().is_some();
        self.shift.set_here(&mut self.cutter.at, axes, is_of_offset);
        // Both coordinates are stated, whatever they were under G68.
        let settles = |(Plane([u, v, _]), _): &(Plane, _)| axes[*u].and(axes[*v]).is_some();
        self.turns_at.take_if(|turn| settles(turn));
        self.starts_by_g92 |= !was_known;
        if !was_known && self.shift.has_started() {
            let what = "states coordinates at a place that is not known behind moves: the work is \
                        taken to stay where it was";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        match self.cutter.place() {
            Some(place) if !was_known => self.line_to(line, place, Pace::Rapid, None),
            _ => Ok(()),
        }
    }

    /// G92.1 and G92.2: where G92 said where the path starts, what they go back to is not stated.
    pub(super) fn end_g92(&mut self, line: usize, keep: bool) {
        if self.starts_by_g92 {
            self.moved_work.push((line, MovedWork::EndOfG92));
        }
        self.shift.reset(keep);
    }

    /// What comes now does not go on from a corner.
    pub(super) fn no_corner(&mut self) -> Result<(), String> {
        self.corner.take().map_or(Ok(()), |corner| Err(corner.misplaced()))
    }

    fn cut_corner(&mut self, to: Vector3<f64>) -> Result<(), String> {
        let Some(corner) = self.corner.take() else { return Ok(()) };
        if self.rotary.moves_work() {
            return Err("a corner while a rotary axis of the work is used".to_owned());
        }
        corner.cut(&mut self.cutter, to, self.plane, "G17 to G19")
    }
}
