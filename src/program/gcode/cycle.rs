//! Drilling cycles of G-code, expanded as the controller does: over the hole, down to R, to the
//! bottom, and out.

use super::arc::Plane;
use super::block::Block;
use super::state::{Cycle, CycleKind, Motion, Reader};
use crate::program::Pace;

/// Of a cycle, and of pecks in a hole.
const MAX_REPEATS: f64 = 10_000.0;

impl Reader<'_> {
    /// G73–G89.
    pub(super) fn start_cycle(&mut self, code: i64) {
        let kind = match code {
            730 | 810 | 820 | 860 => CycleKind::Drill,
            830 => CycleKind::Peck,
            740 | 840 | 850 | 890 => CycleKind::Bore,
            other => CycleKind::Unknown(other / 10),
        };
        if !matches!(self.motion, Motion::Cycle(_)) {
            let initial = self.at.get(2).copied().flatten().unwrap_or_default();
            self.cycle = Cycle { initial, ..Cycle::default() };
        }
        self.motion = Motion::Cycle(kind);
    }

    /// A hole, or several in a row where L or K repeats a relative block.
    pub(super) fn drill(
        &mut self,
        line: usize,
        block: &Block,
        kind: CycleKind,
    ) -> Result<(), String> {
        if let CycleKind::Unknown(code) = kind {
            return Err(format!("G{code} is not supported"));
        }
        if self.plane != Plane::XY {
            return Err("drilling cycles are supported in the XY plane (G17) alone".to_owned());
        }
        let feed = self.pace()?;
        let before = self.place().ok_or("a cycle from an unknown position")?;
        let [retract, bottom, step] =
            ['R', 'Z', 'Q'].map(|word| block.get(word).map(|value| self.mm(value)));
        self.cycle.retract = retract.or(self.cycle.retract);
        self.cycle.bottom = bottom.or(self.cycle.bottom);
        self.cycle.step = step.or(self.cycle.step);
        let given_r = self.cycle.retract.ok_or("the cycle has no R")?;
        let given_z = self.cycle.bottom.ok_or("the cycle has no Z")?;
        let retract = if self.relative { self.cycle.initial + given_r } else { given_r };
        let bottom = if self.relative { retract + given_z } else { given_z };
        if bottom > retract {
            return Err(format!("the bottom (Z {bottom}) lies above R ({retract})"));
        }
        let repeats = block.get('L').or(block.get('K')).unwrap_or(1.0);
        if !(0.0..=MAX_REPEATS).contains(&repeats) || repeats.fract() != 0.0 {
            return Err(format!("{repeats} repeats: expected a whole number from 0"));
        }
        let depths = self.depths(kind, retract, bottom)?;
        let by = |letter: char| block.get(letter).map_or(0.0, |value| self.mm(value));
        let (by_x, by_y) = (by('X'), by('Y'));
        let [mut x, mut y, _] = before;
        let out = if kind == CycleKind::Bore { feed } else { Pace::Rapid };
        // Whole and at most MAX_REPEATS, checked above.
        for _ in 0..repeats as u32 {
            if self.relative {
                (x, y) = (x + by_x, y + by_y);
            } else {
                let [to_x, to_y, _] = self.end_of(block)?;
                (x, y) = (to_x.unwrap_or(x), to_y.unwrap_or(y));
            }
            self.hole(line, [x, y], retract, &depths, [feed, out]);
            if self.log.is_full() {
                break;
            }
        }
        Ok(())
    }

    /// `feed` in and `out`.
    fn hole(
        &mut self,
        line: usize,
        [x, y]: [f64; 2],
        retract: f64,
        depths: &[f64],
        [feed, out]: [Pace; 2],
    ) {
        if let Some([x, y, z]) = self.place()
            && z < retract
        {
            self.apart(line, [x, y, retract], Pace::Rapid);
        }
        let z = self.place().map_or(retract, |[_, _, z]| z);
        self.apart(line, [x, y, z], Pace::Rapid);
        self.apart(line, [x, y, retract], Pace::Rapid);
        for (index, &depth) in depths.iter().enumerate() {
            if let Some(&before) = index.checked_sub(1).and_then(|last| depths.get(last)) {
                self.apart(line, [x, y, retract], Pace::Rapid);
                self.apart(line, [x, y, before], Pace::Rapid);
            }
            self.apart(line, [x, y, depth], feed);
        }
        self.apart(line, [x, y, retract], out);
        if self.back_to_initial && self.cycle.initial > retract {
            self.apart(line, [x, y, self.cycle.initial], Pace::Rapid);
        }
    }

    /// A line, unless the tool is there already.
    fn apart(&mut self, line: usize, to: [f64; 3], pace: Pace) {
        if self.place() != Some(to) {
            self.line_to(line, to, pace);
        }
    }

    fn depths(&self, kind: CycleKind, retract: f64, bottom: f64) -> Result<Vec<f64>, String> {
        if kind != CycleKind::Peck {
            return Ok(vec![bottom]);
        }
        let step = self.cycle.step.ok_or("G83 has no Q")?;
        let count = ((retract - bottom) / step).ceil().max(1.0);
        if !(step > 0.0 && count <= MAX_REPEATS) {
            return Err(format!("Q is {step} mm for a depth of {} mm", retract - bottom));
        }
        // At least 1 and at most MAX_REPEATS.
        let steps = 1..=count as u32;
        Ok(steps.map(|peck| (retract - f64::from(peck) * step).max(bottom)).collect())
    }
}
