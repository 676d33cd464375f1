//! Patterns of holes. Sinumerik's HOLES1, a row, and HOLES2, a circle (Siemens, SINUMERIK 840D
//! sl/828D Fundamentals, "Programming cycles externally"): MCALL's cycle runs at every place. Haas'
//! G70, a circle, and G71, an arc (Haas, Mill Operator's Manual, "Bolt hole circle", "Bolt hole
//! arc"): the cycle that holds does.

use nalgebra::Vector3;

use super::block::Block;
use super::codes::shown;
use super::cycle::unknown_before_cycle;
use super::parameters::Parameters;
use super::rotary::LETTERS;
use super::siemens::arguments;
use super::state::{Machine, Motion};
use crate::program::Pace;
use crate::program::arc::Plane;
use crate::units::rad_from_deg;

const MOST_HOLES: f64 = 10_000.0;

impl Machine<'_> {
    /// Goes from place to place at rapid.
    pub(super) fn pattern(
        &mut self,
        line: usize,
        name: &str,
        inside: &str,
        known: &Parameters,
    ) -> Result<(), String> {
        let given = arguments(name, inside, known)?;
        let given: Vec<f64> = given.into_iter().map(Option::unwrap_or_default).collect();
        let [first, second, a, b, c, count, more @ ..] = given.as_slice() else {
            return Err(format!("{name} needs six words"));
        };
        if more.iter().any(|word| *word != 0.0) {
            return Err(format!("{name}: a word behind the 6th is not supported"));
        }
        if !(1.0..=MOST_HOLES).contains(count) || count.fract() != 0.0 {
            return Err(format!("{name}: {count} holes, expected a whole number from 1"));
        }
        self.no_corner()?;
        self.keeps_frame(name)?;
        let Plane([u, v, w]) = self.plane;
        let mut at = Vector3::zeros();
        for axis in [u, v] {
            // A circle states where it begins.
            let before = self.cutter.at[axis].or((name == "HOLES2").then_some(0.0));
            at[axis] = before.ok_or_else(|| unknown_before_cycle(axis))?;
        }
        at[w] = self.cutter.at[w].unwrap_or_default();
        [u, v].into_iter().for_each(|axis| self.shift.goes_by_zero(axis));
        let shift = self.shift.total();
        let centre = [self.mm(*first) + shift[u], self.mm(*second) + shift[v]];
        // Whole and at most MOST_HOLES.
        let holes = (0..*count as u32).map(f64::from);
        let polar: Vec<(f64, f64)> = match name {
            "HOLES1" => holes.map(|i| (self.mm(*b) + i * self.mm(*c), *a)).collect(),
            _ => {
                let step = if *c == 0.0 { 360.0 / count } else { *c };
                holes.map(|i| (self.mm(*a), b + i * step)).collect()
            }
        };
        let place = |(radius, angle): (f64, f64)| {
            let (sin, cos) = rad_from_deg(angle).sin_cos();
            let mut place = at;
            (place[u], place[v]) = (centre[0] + radius * cos, centre[1] + radius * sin);
            place
        };
        let mut places: Vec<Vector3<f64>> = polar.into_iter().map(place).collect();
        // A row is begun at its nearer end.
        if let (true, [first, .., last]) = (name == "HOLES1", places.as_slice())
            && (last - at).norm() < (first - at).norm()
        {
            places.reverse();
        }
        let call = self.called.take();
        let mut done = Ok(());
        for mut place in places {
            match self.cutter.at[w] {
                Some(height) => {
                    place[w] = height;
                    done = self.line_to(line, place, Pace::Rapid, None);
                }
                // The cycle goes to a height of its own.
                None => {
                    (self.cutter.at[u], self.cutter.at[v]) = (Some(place[u]), Some(place[v]));
                }
            }
            if let (Ok(()), Some(call)) = (&done, &call) {
                done = self.drill_call(line, call);
            }
            if done.is_err() || self.cutter.log.is_full() {
                break;
            }
        }
        self.called = call;
        done
    }

    /// The code of Haas' G70 or G71 with holes, in tenths; elsewhere these state a unit.
    pub(super) fn pattern_of(&self, block: &Block) -> Option<i64> {
        let code = block.codes('G').find(|code| matches!(code, 700 | 710))?;
        let is_cycle = |code| matches!(code, 730 | 740 | 810..=890);
        let ends = |code| matches!(code, 0 | 10 | 20 | 30 | 800);
        let holds = matches!(self.motion, Motion::Cycle(_)) && !block.codes('G').any(ends);
        let in_cycle = holds || block.codes('G').any(is_cycle);
        // L beside P is that of a call, or of G10.
        let counts = block.word(b'L').is_some() && block.word(b'P').is_none();
        let is_pattern = counts || in_cycle && block.has_any(b"IJKL");
        (is_pattern && !self.is_sinumerik).then_some(code)
    }

    /// Places of holes: I is the radius about X and Y or where the tool is, J the angle of the
    /// first hole, K the one between two, and L their number.
    pub(super) fn bolt_holes(&mut self, code: i64, block: &Block) -> Result<Vec<[f64; 2]>, String> {
        let name = shown('G', code);
        self.keeps_frame(&name)?;
        if self.plane != Plane::XY || block.has_any(&LETTERS) {
            return Err(format!("{name} with L is read under G17 and without rotary axes alone"));
        }
        let need =
            |letter: char| block.get(letter).ok_or_else(|| format!("{name} has no {letter}"));
        let (radius, count) = (self.mm(need('I')?), need('L')?);
        if !(1.0..=MOST_HOLES).contains(&count) || count.fract() != 0.0 {
            return Err(format!("{name}: {count} holes, expected a whole number from 1"));
        }
        let first = block.get('J').unwrap_or(0.0);
        let step = if code == 700 { 360.0 / count } else { need('K')? };
        let [x, y, _] = self.end_of(block)?;
        let (x, y) = match (x, y) {
            (Some(x), Some(y)) => (x, y),
            (x, _) => return Err(unknown_before_cycle(usize::from(x.is_some()))),
        };
        // Whole and at most MOST_HOLES.
        let angles = (0..count as u32).map(|hole| first + f64::from(hole) * step);
        let place = |angle| {
            let (sin, cos) = rad_from_deg(angle).sin_cos();
            [x + radius * cos, y + radius * sin]
        };
        Ok(angles.map(place).collect())
    }
}
