//! Cells between stations that are halved together, wave by wave, so that the kernel has many poses at a
//! time. The stations are those of a recursion that halves each cell by itself: whether a cell is halved
//! depends on its two ends and on the slopes of the cells that it lies in, not on its neighbours.

use rayon::prelude::*;

use super::survey::{Station, Survey};

/// Cells that one thread asks about at a time.
const CHUNK: usize = 512;

/// Says whether a cell is to be halved: its ends, and per mode a bound on |d ln f_r / ds| in it.
pub(super) trait Wants: Fn(&Station, &Station, &[f64]) -> bool + Sync {}

impl<F: Fn(&Station, &Station, &[f64]) -> bool + Sync> Wants for F {}

/// Cells of a survey that are to be halved, ascending in s.
pub(super) struct Wave {
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

impl Wave {
    /// Those of a survey whose stations ascend.
    pub(super) fn first(survey: &Survey, wants: &impl Wants) -> Self {
        let cells = survey.len().saturating_sub(1);
        Self::gathered(survey.modes, cells, |cell, rates, wave| {
            steepest_nearby(survey, cell, rates);
            wave.ask(survey, [cell, cell + 1], rates, wants);
        })
    }

    /// The halves of these cells that are to be halved again; cell i was halved at station `middles` + i.
    pub(super) fn halved(&self, survey: &Survey, middles: usize, wants: &impl Wants) -> Self {
        Self::gathered(self.modes, self.cells.len(), |i, rates, wave| {
            let Cell { left, right, .. } = self.cells[i];
            let middle = middles + i;
            rates.copy_from_slice(&self.rates[i * self.modes..][..self.modes]);
            // A steeper slope than the neighbours showed raises the bound.
            raise_rates(survey, [left, middle], 1.0, rates);
            raise_rates(survey, [middle, right], 1.0, rates);
            wave.ask(survey, [left, middle], rates, wants);
            wave.ask(survey, [middle, right], rates, wants);
        })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Where the cells are to be halved.
    pub(super) fn middles(&self) -> Vec<f64> {
        self.cells.iter().map(|cell| cell.middle_s).collect()
    }

    /// What `look` adds to a wave for each of 0..`count`, in that order, over all cores. `look` is lent room
    /// for the rates of a cell.
    fn gathered(
        modes: usize,
        count: usize,
        look: impl Fn(usize, &mut [f64], &mut Self) + Sync,
    ) -> Self {
        let empty = || Self { modes, cells: Vec::new(), rates: Vec::new() };
        let parts: Vec<Self> = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let (mut wave, mut rates) = (empty(), vec![0.0; modes]);
                for i in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                    look(i, &mut rates, &mut wave);
                }
                wave
            })
            .collect();
        parts.into_iter().fold(empty(), |mut all, part| {
            all.cells.extend(part.cells);
            all.rates.extend(part.rates);
            all
        })
    }

    /// Takes the cell between two stations in if it is to be halved, and can be.
    fn ask(&mut self, survey: &Survey, ends: [usize; 2], rates: &[f64], wants: &impl Wants) {
        let [left, right] = ends.map(|i| survey.station(i));
        let middle_s = 0.5 * (left.s + right.s);
        if wants(&left, &right, rates) && middle_s > left.s && middle_s < right.s {
            self.cells.push(Cell { left: ends[0], right: ends[1], middle_s });
            self.rates.extend_from_slice(rates);
        }
    }
}

/// Twice the steepest relative slope per mode in cell `cell` and its neighbours.
fn steepest_nearby(survey: &Survey, cell: usize, rates: &mut [f64]) {
    const SAFETY: f64 = 2.0;
    rates.fill(0.0);
    for i in cell.saturating_sub(1)..=(cell + 1).min(survey.len() - 2) {
        raise_rates(survey, [i, i + 1], SAFETY, rates);
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
