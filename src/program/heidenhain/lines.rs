//! Lines, arcs and the corners between lines.

use nalgebra::{Rotation3, Vector2, Vector3};

use super::block::{Block, Word};
use super::{Reader, approach, is_of_motion, is_rapid};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::arc::{Arc, Centre, Plane, centre_of};
use crate::program::corner::{Corner, Kind};
use crate::program::log::States;
use crate::units::{m_per_s_from_mm_per_min, rad_from_deg};

impl Reader<'_, '_> {
    /// The end of a block: axes as given, by `I` relative to where the tool is.
    pub(super) fn end_of(&self, block: &Block<'_>) -> Result<[Option<f64>; 3], String> {
        self.end_from(self.at(), block)
    }

    /// Where the block begins: a line that ends in a corner is not drawn yet.
    pub(super) fn at(&self) -> [Option<f64>; 3] {
        self.corner.map_or(self.cutter.at, |corner| corner.to.map(Some).into())
    }

    pub(super) fn end_from(
        &self,
        from: [Option<f64>; 3],
        block: &Block<'_>,
    ) -> Result<[Option<f64>; 3], String> {
        let mut end = from;
        for (index, (name, relative)) in
            [("X", "IX"), ("Y", "IY"), ("Z", "IZ")].into_iter().enumerate()
        {
            if let Some(value) = block.get(name) {
                end[index] = Some(self.mm(value) + self.shift[index]);
            } else if let Some(by) = block.get(relative) {
                let before = end[index].ok_or_else(|| format!("{relative} from no position"))?;
                end[index] = Some(before + self.mm(by));
            }
        }
        Ok(end)
    }

    pub(super) fn motion(&mut self, line: usize, block: &Block<'_>) -> Result<(), String> {
        for axis in ["A", "B", "C", "IA", "IB", "IC"] {
            let is_first = block.name(0) == axis;
            if !is_first && block.get(axis).is_some_and(|value| value != 0.0) {
                return Err(format!("axis {axis} is not supported: X, Y and Z alone"));
            }
        }
        let heads = if matches!(block.name(0), "APPR" | "DEP") { 2 } else { 1 };
        let of_way = |name: &str| heads == 2 && matches!(name, "LEN" | "CCA");
        let unknown = |word: &&Word<'_>| !is_of_motion(word.name) && !of_way(word.name);
        if let Some(word) = block.words.iter().skip(heads).find(unknown) {
            return Err(format!("'{}' is not understood", word.name));
        }
        for (name, code) in [("LA", 120.0), ("MB", 140.0)] {
            if block.has(name) && !block.all("M").any(|own| own == code) {
                return Err(format!("'{name}' without M{code} is not understood"));
            }
        }
        self.feed(line, block)?;
        self.m_codes(line, block, true)?;
        if block.has("RL") || block.has("RR") {
            let what = "RL/RR: the path is read as programmed";
            self.cutter.log.warning(Code::Assumed, line, what);
        }
        if let Some(side) = block.words.iter().find(|word| matches!(word.name, "RL" | "RR")) {
            self.side = Some(side.name == "RL");
        } else if block.all("R").any(|value| value == 0.0) {
            self.side = None;
        }
        let pace = if is_rapid(block) { Pace::Rapid } else { self.cutter.pace()? };
        let before = self.last_pace.replace(pace);
        let datum = block.all("M").find_map(|code| match code {
            91.0 => Some("M91"),
            92.0 => Some("M92"),
            _ => None,
        });
        let retracts = block.all("M").any(|code| code == 140.0);
        if retracts && ["X", "Y", "Z", "IX", "IY", "IZ"].iter().any(|axis| block.has(axis)) {
            return Err("M140 beside X, Y or Z is not supported".to_owned());
        } else if retracts && let Some(by) = block.get("MB") {
            self.retract(line, block, by)?;
        } else if datum.is_some() || retracts {
            let axes = ["X", "Y", "Z"].map(|axis| block.has(axis));
            let axes = if retracts { [false, false, true] } else { axes };
            self.cutter.leave(line, axes, datum.unwrap_or("M140"));
            if let Some(datum) = datum.filter(|_| pace != Pace::Rapid) {
                self.cutter.cut_away(line, datum);
            }
            self.heading = None;
        } else if block.name(0) == "CT" {
            self.tangential(line, block, pace)?;
        } else if block.name(0) == "APPR" {
            self.approach(line, block, before, pace)?;
        } else if block.name(0) == "DEP" {
            self.depart(line, block, pace)?;
        } else if block.name(0) == "C" || block.name(0) == "CR" || block.name(0) == "CP" {
            self.arc(line, block, pace)?;
        } else {
            self.line(line, block, pace)?;
        }
        if block.all("M").any(|code| code == 99.0) {
            self.no_corner()?;
            self.drill(line)?;
        }
        if block.all("M").any(|code| code == 5.0) {
            self.no_corner()?;
            self.cutter.turn_spindle(line, false);
        }
        Ok(())
    }

    /// M codes and STOP in a block of their own: of these M140 moves the tool, and M99 calls the
    /// cycle.
    pub(super) fn m_block(&mut self, line: usize, block: &Block<'_>) -> Result<(), String> {
        let has = |own: f64| block.all("M").any(|code| code == own);
        let retracts = has(140.0);
        let is_other = |word: &&Word<'_>| match word.name {
            "M" | "STOP" => false,
            "MB" | "MAX" | "F" | "FMAX" => !retracts,
            "LA" => !has(120.0),
            _ => !block.is_of_tilt(word),
        };
        if let Some(word) = block.words.iter().find(is_other) {
            let number = word.value.map_or(String::new(), |value| value.to_string());
            return Err(format!(
                "'{}{number}' in a block that begins with M or STOP: M codes alone are read there; \
                 write it behind L or TOOL CALL",
                word.name
            ));
        }
        if retracts {
            return self.motion(line, block);
        }
        self.m_codes(line, block, has(99.0))?;
        if has(99.0) {
            self.drill(line)?;
            if has(5.0) {
                self.cutter.turn_spindle(line, false);
            }
        }
        Ok(())
    }

    /// M140 MB: along the tool axis by so much, at the feed behind it or at rapid.
    fn retract(&mut self, line: usize, block: &Block<'_>, by: f64) -> Result<(), String> {
        let at = self.cutter.place().ok_or("M140 from an unknown position")?;
        let behind = block.words.iter().skip_while(|word| word.name != "MB");
        let feed = behind.filter(|word| word.name == "F").find_map(|word| word.value);
        let pace = match feed {
            Some(feed) => Pace::Feed(m_per_s_from_mm_per_min(self.mm_per_min(feed))),
            None => Pace::Rapid,
        };
        self.cutter.line_to(line, at + Vector3::z() * self.mm(by), pace);
        self.heading = None;
        Ok(())
    }

    /// What ends a line that ends in a corner would come before the line is drawn.
    fn no_corner(&mut self) -> Result<(), String> {
        self.corner.take().map_or(Ok(()), |corner| Err(corner.misplaced()))
    }

    pub(super) fn line(
        &mut self,
        line: usize,
        block: &Block<'_>,
        pace: Pace,
    ) -> Result<(), String> {
        let mut end = self.end_of(block)?;
        if block.name(0) == "LP" {
            let [x, y] = self.polar(self.at(), block)?;
            let Plane([u, v, _]) = self.plane();
            (end[u], end[v]) = (Some(x), Some(y));
        }
        const AXES: [&str; 10] = ["X", "Y", "Z", "IX", "IY", "IZ", "PR", "PA", "IPR", "IPA"];
        if !AXES.iter().any(|axis| block.has(axis)) {
            return Ok(());
        }
        match end {
            [Some(x), Some(y), Some(z)] => {
                let to = Vector3::new(x, y, z);
                if let Some(corner) = self.corner.take() {
                    corner.cut(&mut self.cutter, to, Plane::XY, "X and Y")?;
                }
                let way = self.cutter.place().map(|from| (to - from).xy());
                self.heading = way.and_then(|way| way.try_normalize(1e-9)).or(self.heading);
                self.corner = self.corner_behind(to, pace)?;
                if self.corner.is_none() {
                    self.cutter.line_to(line, to, pace);
                }
                Ok(())
            }
            _ => {
                self.cutter.goes_partly(line, end);
                if pace == Pace::Rapid { Ok(()) } else { Err(self.cutter.unknown(line)) }
            }
        }
    }

    /// The corner that the next block makes of the end of a line.
    pub(super) fn corner_behind(
        &mut self,
        to: Vector3<f64>,
        pace: Pace,
    ) -> Result<Option<Corner>, String> {
        let Some(text) = self.blocks.get(self.next) else { return Ok(None) };
        let block = self.parsed(text);
        let (line, name) = (text.line, block.name(0));
        if !matches!(name, "RND" | "CHF") {
            return Ok(None);
        }
        // `RND R5`, `RND 5`, `CHF 2`.
        let size = block.get("R").or(block.words[0].value).or_else(|| block.get(""));
        let size = size
            .filter(|size| *size > 0.0)
            .ok_or_else(|| format!("{name} in line {line} needs a size above 0"))?;
        let pace_in_corner = match block.word("F").filter(|_| !block.leaves_feed()) {
            Some(word) => {
                let value = word.value.filter(|feed| *feed > 0.0).ok_or("F must be positive")?;
                self.cutter.log.states(line, word.span, States::Feed { value });
                Pace::Feed(m_per_s_from_mm_per_min(self.mm_per_min(value)))
            }
            None => pace,
        };
        let size = self.mm(size);
        let kind = if name == "RND" { Kind::Round } else { Kind::OffLines };
        Ok(Some(Corner { kind, size, line, to, pace, pace_in_corner }))
    }

    pub(super) fn plane(&self) -> Plane {
        self.pole.map_or(Plane::XY, |(_, plane)| plane)
    }

    /// PR and PA about the pole, along the axes of its plane; angles count from the first of them
    /// (X in X/Y, Y in Y/Z, Z in Z/X: HEIDENHAIN, TNC 426 Pilot, Fundamentals). What is relative or
    /// left out counts from `at`.
    pub(super) fn polar(
        &self,
        at: [Option<f64>; 3],
        block: &Block<'_>,
    ) -> Result<[f64; 2], String> {
        self.polar_about(self.pole, at, block)
    }

    pub(super) fn polar_about(
        &self,
        pole: Option<([f64; 2], Plane)>,
        at: [Option<f64>; 3],
        block: &Block<'_>,
    ) -> Result<[f64; 2], String> {
        let (pole, Plane([u, v, _])) = pole.ok_or("polar coordinates without CC")?;
        let before = match (at[u], at[v]) {
            (Some(x), Some(y)) => Some([x - pole[0], y - pole[1]]),
            _ => None,
        };
        let radius = match (block.get("PR"), block.get("IPR")) {
            (Some(radius), _) => self.mm(radius),
            (None, by) => {
                let before = before.map(|[x, y]| x.hypot(y)).ok_or("PR from no position")?;
                before + self.mm(by.unwrap_or(0.0))
            }
        };
        let angle = match (block.get("PA"), block.get("IPA"), before) {
            (Some(angle), _, _) => rad_from_deg(angle),
            (None, by, Some([x, y])) => y.atan2(x) + rad_from_deg(by.unwrap_or(0.0)),
            _ => return Err("PA from no position".to_owned()),
        };
        Ok([pole[0] + radius * angle.cos(), pole[1] + radius * angle.sin()])
    }

    /// CC: the two axes that it names are the plane of arcs.
    pub(super) fn centre(&mut self, block: &Block<'_>) -> Result<(), String> {
        let names = |axis: &str, by: &str| block.has(axis) || block.has(by);
        let [x, y, z] = [names("X", "IX"), names("Y", "IY"), names("Z", "IZ")];
        let plane = match (x, y, z) {
            (_, _, false) => Plane::XY,
            (true, false, true) => Plane::ZX,
            (false, true, true) => Plane::YZ,
            _ => return Err("CC names no plane: two of X, Y and Z".to_owned()),
        };
        let Plane([u, v, _]) = plane;
        let end = self.end_of(block)?;
        match (end[u], end[v]) {
            (Some(u), Some(v)) => {
                self.pole = Some(([u, v], plane));
                Ok(())
            }
            _ => Err("a centre at an unknown position".to_owned()),
        }
    }

    pub(super) fn arc(&mut self, line: usize, block: &Block<'_>, pace: Pace) -> Result<(), String> {
        let start = self.cutter.place().ok_or_else(|| self.cutter.unknown(line))?;
        let clockwise = match block.word("DR").and_then(|word| word.sign) {
            Some(is_positive) => !is_positive,
            None => return Err("an arc without DR+ or DR-".to_owned()),
        };
        let [Some(x), Some(y), Some(z)] = self.end_of(block)? else {
            return Err("an arc to an unknown position".to_owned());
        };
        let mut end = Vector3::new(x, y, z);
        let (mut plane, mut more_turns) = (Plane::XY, 0);
        let centre = match block.name(0) {
            "CR" => {
                let radius = block.get("R").ok_or("CR without R")?;
                Centre::Radius(self.mm(radius))
            }
            name => {
                let (pole, own) = self.pole.ok_or("an arc without CC before it")?;
                plane = own;
                let Plane([u, v, _]) = plane;
                if name == "CP" {
                    [end[u], end[v]] = self.polar(self.at(), block)?;
                    match (block.get("IPA"), block.get("PA")) {
                        (Some(turned), _) if (turned < 0.0) != clockwise => {
                            return Err("IPA and DR have opposite signs".to_owned());
                        }
                        (Some(turned), _) => {
                            let turned = turned.abs();
                            // Whole turns, and the rest by the end.
                            more_turns = (turned / 360.0 - 1e-9).floor().clamp(0.0, 1e4) as u32;
                            if (turned % 360.0).abs() < 1e-9 {
                                (end[u], end[v]) = (start[u], start[v]);
                            }
                        }
                        // The angle of the end; turns on the way there are IPA's to say.
                        (None, Some(angle)) if angle.abs() > 360.0 => {
                            return Err(format!(
                                "PA is {angle}°, must be from -360 to 360; IPA turns"
                            ));
                        }
                        (None, Some(_)) => {}
                        (None, None) => return Err("CP without PA or IPA".to_owned()),
                    }
                }
                Centre::At(pole)
            }
        };
        let middle = match centre {
            Centre::At(centre) => centre,
            Centre::Radius(radius) => {
                centre_of([start.x, start.y], [end.x, end.y], radius, clockwise)?
            }
        };
        let is_level = plane == Plane::XY;
        self.heading = is_level
            .then(|| approach::heading(end.xy() - Vector2::from(middle), clockwise))
            .flatten();
        let arc =
            Arc { start, end, plane, turn: Rotation3::identity(), clockwise, centre, more_turns };
        self.cutter.tell_tiny(line, &arc);
        self.cutter.arc(line, &arc, pace)
    }
}
