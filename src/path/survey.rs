//! The arm along a path: natural frequencies, and on demand what each mode does to the tool tip.

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
    pub(super) detail: Detail,
    pub(super) s: Vec<f64>,
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) tip_m_per_n: Vec<f64>,
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
    /// Without stations, for an arm with so many modes.
    pub(super) fn empty(modes: usize, detail: Detail) -> Self {
        let (s, frequencies_hz, tip_m_per_n) = (Vec::new(), Vec::new(), Vec::new());
        Self { modes, detail, s, frequencies_hz, tip_m_per_n }
    }

    pub(super) fn tip_columns(&self) -> usize {
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

    pub(super) fn push(&mut self, station: &Station) {
        self.s.push(station.s);
        self.frequencies_hz.extend_from_slice(station.frequencies_hz);
        self.tip_m_per_n.extend_from_slice(station.tip_m_per_n);
    }
}
