//! Surveys of a path, and their refinement: cells between stations that are halved together, round
//! by round, so that the kernel has many poses at a time. The stations are those of a recursion
//! that halves each cell by itself: whether a cell is halved depends on its two ends and on the
//! slopes of the cells that it lies in, not on its neighbours.

use rayon::prelude::*;

use super::batch::BatchSurveyor;
use super::survey::{Detail, Station, Survey};
use super::timed_path::Path;
use crate::notes::Note;
use crate::progress::{Progress, silent};

/// Cells that one thread asks about at a time.
const CHUNK: usize = 512;

/// Says whether a cell is to be halved: its ends, and per mode a bound on |d ln f_r / ds| in it.
trait NeedsHalving: Fn(&Station, &Station, &[f64]) -> bool + Sync {}

impl<F: Fn(&Station, &Station, &[f64]) -> bool + Sync> NeedsHalving for F {}

/// Cells of a survey that are to be halved, ascending in s.
struct PendingCells {
    modes: usize,
    cells: Vec<Cell>,
    /// One row a cell.
    rates: Vec<f64>,
}

/// The stations at the ends of a cell, by index, and the place halfway.
#[derive(Debug, Clone, Copy)]
struct Cell {
    left: usize,
    right: usize,
    middle_s: f64,
}

impl Survey {
    /// Looks at every station of `s` (ascending, 0..=1), over all cores.
    ///
    /// # Errors
    /// The first station at which the arm has no modes.
    pub fn take(
        path: &Path,
        s: Vec<f64>,
        detail: Detail,
        progress: Progress,
    ) -> Result<Self, Note> {
        let mut survey = Self::empty(path.robot().coordinates().len(), detail);
        survey.extend(&BatchSurveyor::new(path, detail), s, progress)?;
        Ok(survey)
    }

    /// The stations of `s` (ascending, 0..=1), with the same detail: those that are here already
    /// are not solved again.
    ///
    /// # Errors
    /// The first station that is not here and at which the arm has no modes.
    pub fn at_stations(&self, path: &Path, s: &[f64], progress: Progress) -> Result<Self, Note> {
        let mut known = (0..self.len()).peekable();
        let known: Vec<Option<usize>> = s
            .iter()
            .map(|&s| {
                while known.next_if(|&i| self.s[i] < s).is_some() {}
                known.peek().copied().filter(|&i| self.s[i] == s)
            })
            .collect();
        let missing = s.iter().zip(&known).filter(|(_, known)| known.is_none());
        let missing: Vec<f64> = missing.map(|(&s, _)| s).collect();
        let solved = Self::take(path, missing, self.detail, progress)?;
        let mut found = Self::empty(self.modes, self.detail);
        let mut solved = solved.stations();
        for known in known {
            match known {
                Some(i) => found.push(&self.station(i)),
                None => solved.by_ref().take(1).for_each(|station| found.push(&station)),
            }
        }
        Ok(found)
    }

    /// Looks at more stations and puts them behind those that are there.
    fn extend(
        &mut self,
        batch: &BatchSurveyor,
        s: Vec<f64>,
        progress: Progress,
    ) -> Result<(), Note> {
        let (had_values, had_tips) = (self.frequencies_hz.len(), self.tip_m_per_n.len());
        self.frequencies_hz.resize(had_values + s.len() * self.modes, 0.0);
        self.tip_m_per_n.resize(had_tips + s.len() * self.tip_columns(), 0.0);
        batch.look(
            &s,
            &mut self.frequencies_hz[had_values..],
            &mut self.tip_m_per_n[had_tips..],
            progress,
        )?;
        if self.s.is_empty() {
            self.s = s;
        } else {
            self.s.extend(s);
        }
        Ok(())
    }

    /// Halves the cells between stations wherever `needs_halving` asks for it, again and again;
    /// over all cores.
    ///
    /// `needs_halving` is shown both ends of a cell and, per mode, a bound on |d ln f_r / ds| in
    /// it: twice the steepest slope of the cell and its two neighbours, or the steepest seen in the
    /// halves of a cell that holds it, whichever is steeper.
    ///
    /// # Errors
    /// The first station at which the arm has no modes, of the largest cells that have one.
    pub fn refine(
        mut self,
        path: &Path,
        needs_halving: impl Fn(&Station, &Station, &[f64]) -> bool + Sync,
    ) -> Result<Self, Note> {
        let first_look = self.len();
        let mut pending = PendingCells::first(&self, &needs_halving);
        if pending.is_empty() {
            return Ok(self);
        }
        let batch = BatchSurveyor::new(path, self.detail);
        while !pending.is_empty() {
            let looked_at = self.len();
            self.extend(&batch, pending.middles(), &silent)?;
            pending = pending.halved(&self, looked_at, &needs_halving);
        }
        Ok(self.merged(first_look))
    }

    /// The same in order, where the first `sorted` stations are.
    fn merged(&self, sorted: usize) -> Self {
        let mut added: Vec<usize> = (sorted..self.len()).collect();
        added.sort_by(|&a, &b| self.s[a].total_cmp(&self.s[b]));
        let mut merged = Self::empty(self.modes, self.detail);
        let mut added = added.into_iter().peekable();
        for i in 0..sorted {
            while let Some(before) = added.next_if(|&a| self.s[a] < self.s[i]) {
                merged.push(&self.station(before));
            }
            merged.push(&self.station(i));
        }
        merged
    }
}

impl PendingCells {
    /// Those of a survey whose stations ascend.
    fn first(survey: &Survey, needs_halving: &impl NeedsHalving) -> Self {
        let cells = survey.len().saturating_sub(1);
        Self::gathered(survey.modes, cells, |cell, rates, pending| {
            steepest_nearby(survey, cell, rates);
            pending.ask(survey, [cell, cell + 1], rates, needs_halving);
        })
    }

    /// The halves of these cells that are to be halved again; cell i was halved at station
    /// `middles` + i.
    fn halved(&self, survey: &Survey, middles: usize, needs_halving: &impl NeedsHalving) -> Self {
        Self::gathered(self.modes, self.cells.len(), |i, rates, pending| {
            let Cell { left, right, .. } = self.cells[i];
            let middle = middles + i;
            rates.copy_from_slice(&self.rates[i * self.modes..][..self.modes]);
            // A steeper slope than the neighbours showed raises the bound.
            raise_rates(survey, [left, middle], 1.0, rates);
            raise_rates(survey, [middle, right], 1.0, rates);
            pending.ask(survey, [left, middle], rates, needs_halving);
            pending.ask(survey, [middle, right], rates, needs_halving);
        })
    }

    fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Where the cells are to be halved.
    fn middles(&self) -> Vec<f64> {
        self.cells.iter().map(|cell| cell.middle_s).collect()
    }

    /// What `look` adds to the pending cells for each of 0..`count`, in that order, over all cores.
    /// `look` is lent room for the rates of a cell.
    fn gathered(
        modes: usize,
        count: usize,
        look: impl Fn(usize, &mut [f64], &mut Self) + Sync,
    ) -> Self {
        let empty = || Self { modes, cells: Vec::new(), rates: Vec::new() };
        let parts: Vec<Self> = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let (mut pending, mut rates) = (empty(), vec![0.0; modes]);
                for i in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                    look(i, &mut rates, &mut pending);
                }
                pending
            })
            .collect();
        parts.into_iter().fold(empty(), |mut all, part| {
            all.cells.extend(part.cells);
            all.rates.extend(part.rates);
            all
        })
    }

    /// Takes the cell between two stations in if it is to be halved, and can be.
    fn ask(
        &mut self,
        survey: &Survey,
        ends: [usize; 2],
        rates: &[f64],
        needs_halving: &impl NeedsHalving,
    ) {
        let [left, right] = ends.map(|i| survey.station(i));
        let middle_s = 0.5 * (left.s + right.s);
        if needs_halving(&left, &right, rates) && middle_s > left.s && middle_s < right.s {
            self.cells.push(Cell { left: ends[0], right: ends[1], middle_s });
            self.rates.extend_from_slice(rates);
        }
    }
}

/// Twice the steepest relative slope per mode in cell `cell` and its neighbours.
fn steepest_nearby(survey: &Survey, cell: usize, rates: &mut [f64]) {
    rates.fill(0.0);
    for i in cell.saturating_sub(1)..=(cell + 1).min(survey.len() - 2) {
        raise_rates(survey, [i, i + 1], 2.0, rates);
    }
}

/// Raises each mode's rate to `factor` times its relative slope between two stations.
fn raise_rates(survey: &Survey, ends: [usize; 2], factor: f64, rates: &mut [f64]) {
    let [a, b] = ends.map(|i| survey.station(i));
    let width = b.s - a.s;
    for ((rate, fa), fb) in rates.iter_mut().zip(a.frequencies_hz).zip(b.frequencies_hz) {
        *rate = rate.max(factor * (fb - fa).abs() / (fa.min(*fb) * width));
    }
}
