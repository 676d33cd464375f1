//! Programs that say nowhere what unit their lengths are in: whether the figures look like inches.

use super::log::Log;
use crate::notes::Code;
use crate::wording::rounded;

/// In inches more is beyond the reach of any arm: the unit is mm.
const MAX_INCHES: f64 = 120.0;

/// As far as small parts go in mm, and large ones in inches.
const SMALL: f64 = 50.0;

/// Feeds a minute below which few cut in mm and most do in inches, of parts of any size.
const SLOW: f64 = 60.0;

/// The same of small parts.
const MODERATE: f64 = 200.0;

/// Whole numbers of lengths from here on are micrometres to some controls, where they stand without
/// a decimal point.
const LONG_WITHOUT_POINT: f64 = 1000.0;

/// Numbers of moves while no unit is stated.
#[derive(Debug, Default)]
pub(super) struct UnitWatch {
    is_stated: bool,
    /// The line of the first such move.
    first: Option<usize>,
    least: [f64; 3],
    most: [f64; 3],
    /// Has numbers of more than three decimals, as posts write inches and not mm.
    is_fine: bool,
    feed: Option<f64>,
    /// Inches are stated behind the first move.
    is_late: bool,
    /// Whether a whole number stands with a decimal point, and the first line where a long one
    /// stands without, whatever states the unit.
    has_point: bool,
    without_point: Option<usize>,
}

impl UnitWatch {
    /// The program or the job says it. That it is mm holds for moves before, too: so they were
    /// read.
    pub(super) fn state(&mut self, is_mm: bool) {
        let is_first = !std::mem::replace(&mut self.is_stated, true);
        if is_mm && is_first {
            self.first = None;
        }
        self.is_late |= !is_mm && is_first && self.first.is_some();
    }

    /// A move ends here; `written` are numbers of lengths as they stand in the text.
    pub(super) fn goes_to(
        &mut self,
        line: usize,
        at: [Option<f64>; 3],
        written: impl Iterator<Item = f64>,
    ) {
        if self.is_stated {
            return;
        }
        if self.first.is_none() {
            self.first = Some(line);
            (self.least, self.most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        }
        for (axis, at) in at.into_iter().enumerate() {
            let Some(at) = at else { continue };
            self.least[axis] = self.least[axis].min(at);
            self.most[axis] = self.most[axis].max(at);
        }
        let is_fine = |value: f64| (value * 1e3 - (value * 1e3).round()).abs() > 1e-3;
        self.is_fine |= written.into_iter().any(is_fine);
    }

    /// A length as it is written.
    pub(super) fn writes(&mut self, line: usize, value: f64, has_point: bool) {
        self.has_point |= has_point && value.fract() == 0.0;
        if !has_point && value.abs() >= LONG_WITHOUT_POINT {
            self.without_point.get_or_insert(line);
        }
    }

    /// At the end of a program of G-code: posts write whole numbers either with a point or without.
    pub(super) fn tell_without_point(&self, log: &mut Log) {
        if let Some(line) = self.without_point.filter(|_| self.has_point) {
            let what = format!(
                "X, Y or Z has a whole number of {LONG_WITHOUT_POINT} or more without a decimal \
                 point, and others have one: it is taken as any other number; Fanuc and Haas may \
                 count it in 0.001 mm or 0.0001 inch; write the point"
            );
            log.warning(Code::UnitAssumed, line, what);
        }
    }

    /// A feed a minute.
    pub(super) fn feeds(&mut self, feed: f64) {
        if !self.is_stated {
            self.feed = Some(self.feed.map_or(feed, |most| most.max(feed)));
        }
    }

    /// At the end of the program. `words` state a unit in its language; `is_usual`: mm is what such
    /// programs are in that do not say it.
    pub(super) fn tell(&self, log: &mut Log, words: &str, is_usual: bool) {
        let Some(line) = self.first else { return };
        let is_zero = |ends: &[f64; 3]| ends.iter().all(|end| !end.is_finite() || *end == 0.0);
        if self.is_late && !(is_zero(&self.least) && is_zero(&self.most)) {
            let what = format!("lengths are taken as mm until inches are stated ({words})");
            log.warning(Code::UnitAssumed, line, what);
            return;
        }
        let ways = self.most.iter().zip(&self.least).map(|(most, least)| most - least);
        let extent = ways.fold(0.0, f64::max);
        if extent > MAX_INCHES {
            return;
        }
        let said = format!("lengths are taken as mm, as nothing says their unit ({words})");
        let below = |limit: f64| self.feed.map(|feed| feed < limit);
        let is_small = extent < SMALL && below(MODERATE).unwrap_or(!is_usual);
        if !(is_small || self.is_fine || below(SLOW).unwrap_or(false)) {
            if !is_usual {
                log.warning(Code::Assumed, line, said);
            }
            return;
        }
        let feed = self.feed.map_or(String::new(), |feed| format!(", at feeds up to {feed}"));
        let what = format!(
            "{said}; they may be inches: the program goes over {}{feed}; write the unit in the \
             program, or path.program.unit: mm or inch in the job",
            rounded(extent, 4)
        );
        log.warning(Code::UnitAssumed, line, what);
    }
}
