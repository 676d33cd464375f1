//! Where a block goes: axes as they are given, polar coordinates (AP= and RP=, G16), a line by its
//! angle (ANG=), and G68, which turns the work.

use nalgebra::Vector3;

use super::block::{ANGLE, Block, Counts, POLAR_ANGLE, POLAR_RADIUS, Word};
use super::frame::{Place, Polar, ROUNDING_MM, Turned};
use super::predefined::Predefined;
use super::state::{AXES, Machine};
use crate::notes::Code;
use crate::program::arc::Plane;
use crate::units::rad_from_deg;

impl Machine<'_> {
    /// Where the tool is; a line that ends in a corner is not drawn yet.
    pub(super) fn at(&self) -> Place {
        self.corner.map_or(self.cutter.at, |corner| corner.to.map(Some).into())
    }

    /// Where the tool is in the program's frame.
    fn before(&self) -> Place {
        let at = self.at();
        self.turned.map_or(at, |turned| turned.place(-turned.angle_rad, at))
    }

    /// A place in the program's frame.
    pub(super) fn in_program(&self, at: Vector3<f64>) -> Vector3<f64> {
        let Some(turned) = self.turned else { return at };
        let Plane([u, v, _]) = turned.plane;
        let mut own = at;
        [own[u], own[v]] = turned.by(-turned.angle_rad, [at[u], at[v]]);
        own
    }

    pub(super) fn is_relative(&self, word: Word) -> bool {
        match word.counts {
            Counts::AsModal => self.relative,
            Counts::Absolute => false,
            Counts::Relative => true,
        }
    }

    /// The value of an axis word, where the axis was before in the program's frame.
    fn axis(&self, block: &Block, axis: usize, before: Place) -> Result<Option<f64>, String> {
        let Some(word) = block.word(AXES[axis]) else { return Ok(before[axis]) };
        let value = self.mm(word.value);
        match (self.is_relative(word), before[axis]) {
            (false, _) => Ok(Some(value + self.shift.total()[axis])),
            (true, Some(before)) => Ok(Some(before + value)),
            (true, None) => {
                Err(format!("{} is relative (G91) to no position", char::from(AXES[axis])))
            }
        }
    }

    /// The end of a block in the job's work object.
    pub(super) fn end_of(&mut self, block: &Block) -> Result<Place, String> {
        let before = self.before();
        let mut end = before;
        for (axis, end) in end.iter_mut().enumerate() {
            *end = self.axis(block, axis, before)?;
            if block.word(AXES[axis]).is_some_and(|word| !self.is_relative(word)) {
                self.shift.goes_by_zero(axis);
            }
        }
        let Plane([u, v, _]) = self.plane;
        if let Some([at_u, at_v]) = self.polar_end(block)? {
            (end[u], end[v]) = (Some(at_u), Some(at_v));
            [u, v].into_iter().for_each(|axis| self.shift.goes_by_zero(axis));
        }
        if let Some(angle) = block.word(ANGLE) {
            end = self.along(block, before, end, angle.value)?;
        }
        let Some(turned) = self.turned else { return Ok(end) };
        if self.relative && block.has_any(&AXES) {
            return Err("G91 under G68 is not supported".to_owned());
        }
        Ok(turned.place(turned.angle_rad, end))
    }

    /// Sinumerik: a relative way of an axis whose zero has moved since the axis went to a place.
    pub(super) fn tell_moved_zero(&mut self, line: usize, block: &Block) {
        for (axis, letter) in AXES.into_iter().enumerate() {
            let is_relative = block.word(letter).is_some_and(|word| self.is_relative(word));
            if self.is_sinumerik && is_relative && self.shift.has_moved_zero(axis) {
                let name = char::from(letter);
                let what = format!(
                    "{name} moves by a relative number behind a shift of its zero (TRANS, ATRANS): \
                     by setting data 42440 the control goes by the shift, too, or not; it is taken \
                     not to; write {name} as a place once"
                );
                self.cutter.log.warning(Code::ChangeIgnored, line, what);
            }
        }
    }

    /// By way of this point G28 goes.
    pub(super) fn way_of(&self, block: &Block) -> Place {
        let before = self.cutter.at;
        // Relative to no position: the reference itself.
        [0, 1, 2].map(|axis| self.axis(block, axis, before).unwrap_or(None))
    }

    /// AP= and RP=, or the words of G16, as places along the axes of the plane.
    fn polar_end(&mut self, block: &Block) -> Result<Option<[f64; 2]>, String> {
        let Plane([u, v, _]) = self.plane;
        let is_g16 = self.polar.is_on;
        let letters = if is_g16 { [AXES[u], AXES[v]] } else { [POLAR_RADIUS, POLAR_ANGLE] };
        if !block.has_any(&letters) {
            return Ok(None);
        }
        let [radius, angle] = letters.map(|letter| block.word(letter));
        let counts = [radius, angle].into_iter().flatten().map(|word| word.counts);
        let is_relative = counts.into_iter().any(|counts| match counts {
            Counts::AsModal => self.relative,
            Counts::Absolute => false,
            Counts::Relative => true,
        });
        if is_relative {
            return Err("relative polar coordinates are not supported".to_owned());
        }
        if !is_g16 && block.has_any(&[AXES[u], AXES[v]]) {
            return Err("AP= or RP= beside an axis of the plane".to_owned());
        }
        self.polar.radius = radius.map(|word| self.mm(word.value)).or(self.polar.radius);
        self.polar.angle = angle.map(|word| word.value).or(self.polar.angle);
        let (Some(radius), Some(angle)) = (self.polar.radius, self.polar.angle) else {
            return Err("polar coordinates without a radius or an angle".to_owned());
        };
        let (sin, cos) = rad_from_deg(angle).sin_cos();
        let pole = self.pole();
        Ok(Some([pole[0] + radius * cos, pole[1] + radius * sin]))
    }

    /// The pole in the job's work object, before G68 turns it.
    pub(super) fn pole(&self) -> [f64; 2] {
        let Plane([u, v, _]) = self.plane;
        let shift = self.shift.total();
        let pole = if self.polar.is_on { [0.0; 2] } else { self.polar.pole };
        [pole[0] + shift[u], pole[1] + shift[v]]
    }

    /// `G1 ANG=45 X40`: up to the axis that is given, in this direction from the first of the
    /// plane.
    fn along(
        &self,
        block: &Block,
        before: Place,
        mut end: Place,
        angle: f64,
    ) -> Result<Place, String> {
        let Plane([u, v, _]) = self.plane;
        let (known, open) = match (block.word(AXES[u]), block.word(AXES[v])) {
            (Some(_), None) => (u, v),
            (None, Some(_)) => (v, u),
            _ => {
                return Err("ANG= is read with one axis of the plane: a line whose end the next \
                            block gives is not supported"
                    .to_owned());
            }
        };
        let (sin, cos) = rad_from_deg(angle).sin_cos();
        let (along, across) = if known == u { (cos, sin) } else { (sin, cos) };
        let unknown = || "ANG= from an unknown position".to_owned();
        let [from, other] = [before[known], before[open]].map(|at| at.ok_or_else(unknown));
        let way = end[known].ok_or_else(unknown)? - from?;
        if along.abs() < 1e-6 || way / along < 0.0 {
            return Err(format!("a line at {angle}° does not lead to the axis that is given"));
        }
        end[open] = Some(other? + way / along * across);
        Ok(end)
    }

    /// G110 to G112: from the place before, the zero of the work, or the pole before.
    pub(super) fn set_pole(&mut self, code: i64, block: &Block) -> Result<(), String> {
        let Plane([u, v, _]) = self.plane;
        if block.has_any(&[POLAR_ANGLE, POLAR_RADIUS]) {
            return Err("a pole in polar coordinates is not supported".to_owned());
        }
        let shift = self.shift.total();
        let from = match code {
            1100 => {
                let before = self.before();
                let at = |axis: usize| before[axis].map(|at| at - shift[axis]);
                let [Some(u), Some(v)] = [at(u), at(v)] else {
                    return Err("G110 from an unknown position".to_owned());
                };
                [u, v]
            }
            1110 => [0.0; 2],
            _ => self.polar.pole,
        };
        let by = [u, v].map(|axis| block.word(AXES[axis]).map_or(0.0, |word| self.mm(word.value)));
        self.polar = Polar { pole: [from[0] + by[0], from[1] + by[1]], ..Polar::default() };
        Ok(())
    }

    /// G16 counts from the zero of the work.
    pub(super) fn begin_g16(&mut self, line: usize) {
        self.polar = Polar { is_on: true, ..Polar::default() };
        let Plane([u, v, _]) = self.plane;
        let zero = self.pole().map(Some);
        if [self.cutter.at[u], self.cutter.at[v]] != zero {
            let what = "G16 counts from the zero of the work, as on Fanuc: Mach3 counts from where \
                        the tool is";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// G68 X Y R: about a place, or where the tool is.
    pub(super) fn turn_work(&mut self, block: &Block) -> Result<(), String> {
        let Plane([u, v, w]) = self.plane;
        let angle = block.get('R').ok_or("G68 without R")?;
        if self.relative || self.polar.is_on || self.turned.is_some() {
            return Err("G68 under G91, G16 or another G68 is not supported".to_owned());
        }
        if block.has_any(&[AXES[w], b'I', b'J', b'K', b'A', b'B', b'C']) {
            return Err("G68 turns the work in the plane alone".to_owned());
        }
        let shift = self.shift.total();
        let centre = [u, v].map(|axis| match block.word(AXES[axis]) {
            Some(word) => Some(self.mm(word.value) + shift[axis]),
            None => self.cutter.at[axis],
        });
        let [Some(u), Some(v)] = centre else {
            return Err("G68 about an unknown position".to_owned());
        };
        let angle_rad = rad_from_deg(angle);
        let turned = Turned { plane: self.plane, centre: [u, v], angle_rad };
        self.turned = Some(turned);
        self.ask_for_place(turned, "G68");
        Ok(())
    }

    /// G69.
    pub(super) fn end_turn(&mut self) {
        if let Some(turned) = self.turned.take() {
            self.ask_for_place(turned, "G69");
        }
    }

    fn ask_for_place(&mut self, turned: Turned, code: &'static str) {
        let own = turned.place(-turned.angle_rad, self.cutter.at);
        let differs = |(at, own): (Option<f64>, Option<f64>)| {
            at.zip(own).is_some_and(|(at, own)| (at - own).abs() > ROUNDING_MM)
        };
        let is_other = self.cutter.at.into_iter().zip(own).any(differs);
        self.turns_at = is_other.then_some((turned.plane, code));
    }

    /// The first way in the plane behind G68 or G69: what is not stated of it counts from where the
    /// tool is, or from the coordinates that it had (Fanuc, B-62764EN, "Coordinate rotation").
    pub(super) fn tell_turned_place(&mut self, line: usize, block: &Block) {
        let Some((Plane([u, v, _]), code)) = self.turns_at else { return };
        let words = [u, v].map(|axis| block.word(AXES[axis]));
        if words.iter().all(Option::is_none) {
            return;
        }
        self.turns_at = None;
        if words.iter().all(|word| word.is_some_and(|word| !self.is_relative(word))) {
            return;
        }
        let [u, v] = [u, v].map(|axis| char::from(AXES[axis]));
        let what = format!(
            "the first move in the plane behind {code} does not state both {u} and {v} as places: \
             controls differ in whether the rest counts from where the tool is, as it is taken \
             here, or from the coordinates that it had before {code}; write {u} and {v} under G90"
        );
        self.cutter.log.warning(Code::ChangeIgnored, line, what);
    }

    /// What G68 and polar coordinates count from would change under them.
    pub(super) fn keeps_frame(&self, what: &str) -> Result<(), String> {
        if self.turned.is_some() {
            return Err(format!("{what} under G68 is not supported"));
        }
        if self.polar.is_on {
            return Err(format!("{what} under G16 is not supported"));
        }
        Ok(())
    }

    pub(super) fn choose_plane(&mut self, plane: Plane) -> Result<(), String> {
        if plane != self.plane {
            self.keeps_frame("another plane")?;
            self.polar = Polar::default();
            self.plane = plane;
        }
        Ok(())
    }
}

impl Machine<'_> {
    /// What LinuxCNC's own parameters have before a block.
    pub(super) fn predefined(&self) -> Predefined {
        let (at, shift) = (self.at(), self.shift.total());
        let place = |axis: usize| at[axis].map(|at| self.in_program_unit(at - shift[axis]));
        Predefined {
            place: [0, 1, 2].map(place),
            is_turned: self.turned.is_some() || self.polar.is_on,
            inches: self.stated_inches(),
            relative: self.relative,
            feed: self.feed_in_program_unit(),
            rpm: self.cutter.rpm,
        }
    }
}
