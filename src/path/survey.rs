//! The arm along a path: natural frequencies, and on demand what each mode does to the tool tip.

use super::lookout::Lookout;
use super::plan::Path;
use super::waves::Wave;
use crate::notes::Note;
use crate::progress::{Progress, silent};

/// What is read at every pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Natural frequencies only.
    Frequencies,
    /// Also what each mode moves the tool tip.
    TipResponse,
}

/// Frequencies along a path, ascending in s: one row a station.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    pub(super) modes: usize,
    detail: Detail,
    s: Vec<f64>,
    frequencies_hz: Vec<f64>,
    tip_m_per_n: Vec<f64>,
}

/// One station of a survey.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station<'s> {
    /// Where on the path, 0..=1.
    pub s: f64,
    /// Ascending, Hz.
    pub frequencies_hz: &'s [f64],
    /// Per mode, m/N; empty where the survey has frequencies only.
    pub tip_m_per_n: &'s [f64],
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
        let mut survey = Self {
            modes: path.robot().coordinates().len(),
            detail,
            s: Vec::new(),
            frequencies_hz: Vec::new(),
            tip_m_per_n: Vec::new(),
        };
        survey.extend(&Lookout::new(path, detail), s, progress)?;
        Ok(survey)
    }

    /// Looks at more stations and puts them behind those that are there.
    fn extend(&mut self, lookout: &Lookout, s: Vec<f64>, progress: Progress) -> Result<(), Note> {
        let (had_values, had_tips) = (self.frequencies_hz.len(), self.tip_m_per_n.len());
        self.frequencies_hz.resize(had_values + s.len() * self.modes, 0.0);
        self.tip_m_per_n.resize(had_tips + s.len() * self.tip_columns(), 0.0);
        lookout.look(
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

    fn tip_columns(&self) -> usize {
        match self.detail {
            Detail::Frequencies => 0,
            Detail::TipResponse => self.modes,
        }
    }

    /// Number of stations.
    pub fn len(&self) -> usize {
        self.s.len()
    }

    /// Whether there is no station.
    pub fn is_empty(&self) -> bool {
        self.s.is_empty()
    }

    /// Station `i`.
    pub fn station(&self, i: usize) -> Station<'_> {
        let tip = self.tip_columns();
        Station {
            s: self.s[i],
            frequencies_hz: &self.frequencies_hz[i * self.modes..][..self.modes],
            tip_m_per_n: &self.tip_m_per_n[i * tip..][..tip],
        }
    }

    /// All stations in order.
    pub fn stations(&self) -> impl Iterator<Item = Station<'_>> {
        (0..self.len()).map(|i| self.station(i))
    }

    /// Lowest and highest frequency of all stations, Hz.
    pub fn range_hz(&self) -> (f64, f64) {
        let bounds = (f64::INFINITY, 0.0_f64);
        self.frequencies_hz.iter().fold(bounds, |(low, high), &f| (low.min(f), high.max(f)))
    }

    /// Halves the cells between stations wherever `wants` asks for it, again and again; over all cores.
    ///
    /// `wants` is shown both ends of a cell and, per mode, a bound on |d ln f_r / ds| in it: twice the
    /// steepest slope of the cell and its two neighbours, or the steepest seen in the halves of a cell that
    /// holds it, whichever is steeper.
    ///
    /// # Errors
    /// The first station at which the arm has no modes, of the largest cells that have one.
    pub fn refine(
        mut self,
        path: &Path,
        wants: impl Fn(&Station, &Station, &[f64]) -> bool + Sync,
    ) -> Result<Self, Note> {
        let first_look = self.len();
        let mut wave = Wave::first(&self, &wants);
        if wave.is_empty() {
            return Ok(self);
        }
        let lookout = Lookout::new(path, self.detail);
        while !wave.is_empty() {
            let looked_at = self.len();
            self.extend(&lookout, wave.middles(), &silent)?;
            wave = wave.halved(&self, looked_at, &wants);
        }
        Ok(self.merged(first_look))
    }

    /// The same in order, where the first `sorted` stations are.
    fn merged(&self, sorted: usize) -> Self {
        let mut added: Vec<usize> = (sorted..self.len()).collect();
        added.sort_by(|&a, &b| self.s[a].total_cmp(&self.s[b]));
        let mut merged = Self {
            modes: self.modes,
            detail: self.detail,
            s: Vec::with_capacity(self.s.len()),
            frequencies_hz: Vec::with_capacity(self.frequencies_hz.len()),
            tip_m_per_n: Vec::with_capacity(self.tip_m_per_n.len()),
        };
        let mut added = added.into_iter().peekable();
        for i in 0..sorted {
            while let Some(before) = added.next_if(|&a| self.s[a] < self.s[i]) {
                merged.push(&self.station(before));
            }
            merged.push(&self.station(i));
        }
        merged
    }

    fn push(&mut self, station: &Station) {
        self.s.push(station.s);
        self.frequencies_hz.extend_from_slice(station.frequencies_hz);
        self.tip_m_per_n.extend_from_slice(station.tip_m_per_n);
    }
}
