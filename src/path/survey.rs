//! The arm along a path: natural frequencies, and on demand mode shapes and what the tool tip does.

use std::fmt;

use nalgebra::{Isometry3, Matrix6xX, Vector3};
use rayon::prelude::*;

use super::plan::{Path, Walker};
use crate::model::{IkFault, Placement, PoseFault, elastic_jacobian, forward_kinematics};
use crate::modes::{ModalSolver, Modes, peak_tip_compliance_m_per_n, tip_motion};

/// Poses that one thread takes at a time.
const CHUNK: usize = 512;

/// A pose of the path at which the arm cannot be looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct SurveyFault {
    /// Where on the path.
    pub s: f64,
    /// Why.
    pub cause: SurveyCause,
}

/// Why the arm cannot be looked at somewhere on a path.
#[derive(Debug, Clone, PartialEq)]
pub enum SurveyCause {
    /// It has no modes there.
    Pose(PoseFault),
    /// It does not get there.
    Kinematics(IkFault),
}

impl fmt::Display for SurveyFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.cause {
            SurveyCause::Pose(fault) => write!(f, "at s = {:.4}: {fault}", self.s),
            SurveyCause::Kinematics(fault) => write!(f, "at s = {:.4}: {fault}", self.s),
        }
    }
}

impl std::error::Error for SurveyFault {}

/// What is read at every pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Natural frequencies only.
    Frequencies,
    /// Also what each mode moves the tool tip.
    TipResponse,
}

/// Looks at a path pose by pose, in buffers of its own.
#[derive(Debug, Clone)]
pub struct Surveyor<'p, 'a> {
    walker: Walker<'p, 'a>,
    solver: ModalSolver<'a>,
    path: &'p Path<'a>,
    q: Vec<f64>,
    jacobian: Matrix6xX<f64>,
    tip_m_per_n: Vec<f64>,
}

impl<'p, 'a> Surveyor<'p, 'a> {
    /// Buffers for `path`.
    pub fn new(path: &'p Path<'a>) -> Self {
        let robot = path.robot();
        let n = robot.coordinates().len();
        Self {
            walker: path.walker(),
            solver: ModalSolver::new(robot),
            path,
            q: vec![0.0; robot.joints().len()],
            jacobian: Matrix6xX::zeros(n),
            tip_m_per_n: vec![0.0; n],
        }
    }

    fn stand(&mut self, s: f64) -> Result<Isometry3<f64>, SurveyFault> {
        self.walker
            .at(s, &mut self.q)
            .map_err(|fault| SurveyFault { s, cause: SurveyCause::Kinematics(fault) })
    }

    /// Natural frequencies at `s`, Hz, ascending.
    ///
    /// # Errors
    /// The arm has no modes there.
    pub fn frequencies_hz(&mut self, s: f64) -> Result<&[f64], SurveyFault> {
        self.stand(s)?;
        self.solver
            .frequencies_hz(&self.q)
            .map_err(|fault| SurveyFault { s, cause: SurveyCause::Pose(fault) })
    }

    /// Modes at `s`, and with them the tip response.
    ///
    /// # Errors
    /// The arm has no modes there.
    pub fn modes(&mut self, s: f64) -> Result<&Modes, SurveyFault> {
        let tcp = self.stand(s)?;
        self.solver
            .solve(&self.q)
            .map_err(|fault| SurveyFault { s, cause: SurveyCause::Pose(fault) })?;
        let tcp = tcp.translation.vector.into();
        elastic_jacobian(self.path.robot(), self.solver.placement(), &tcp, &mut self.jacobian);
        for (r, tip) in self.tip_m_per_n.iter_mut().enumerate() {
            *tip = peak_tip_compliance_m_per_n(self.solver.modes(), &self.jacobian, r);
        }
        Ok(self.solver.modes())
    }

    /// Joint positions of the last pose, rad or m.
    pub fn joints(&self) -> &[f64] {
        &self.q
    }

    /// Per mode of the last [`Self::modes`], what it alone moves the tool tip at resonance, m/N.
    pub fn tip_response_m_per_n(&self) -> &[f64] {
        &self.tip_m_per_n
    }

    /// How mode `r` (from 0) of the last [`Self::modes`] moves the tool tip, in the base frame: J φ_r.
    pub fn tip_motion(&self, r: usize) -> Vector3<f64> {
        tip_motion(self.solver.modes(), &self.jacobian, r)
    }

    /// Pose of the tool centre point in the base frame at `s`.
    ///
    /// # Errors
    /// The arm does not get there.
    pub fn tcp_pose(&mut self, s: f64) -> Result<Isometry3<f64>, SurveyFault> {
        let tcp = self.stand(s)?;
        let mut placement = Placement::new(self.path.robot());
        placement.place(self.path.robot(), &self.q);
        Ok(forward_kinematics(self.path.robot(), &placement) * tcp)
    }

    /// The solver as the last pose left it.
    pub fn solver(&self) -> &ModalSolver<'a> {
        &self.solver
    }

    /// Reads `s` into a row.
    fn read(
        &mut self,
        s: f64,
        detail: Detail,
        frequencies_hz: &mut [f64],
        tip: &mut [f64],
    ) -> Result<(), SurveyFault> {
        match detail {
            Detail::Frequencies => frequencies_hz.copy_from_slice(self.frequencies_hz(s)?),
            Detail::TipResponse => {
                frequencies_hz.copy_from_slice(&self.modes(s)?.natural_frequencies_hz);
                tip.copy_from_slice(&self.tip_m_per_n);
            }
        }
        Ok(())
    }
}

/// Frequencies along a path, ascending in s: one row a station.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    modes: usize,
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

/// A station that stands by itself.
#[derive(Debug, Clone)]
struct OwnStation {
    s: f64,
    frequencies_hz: Vec<f64>,
    tip_m_per_n: Vec<f64>,
}

impl OwnStation {
    fn read(surveyor: &mut Surveyor, s: f64, detail: Detail) -> Result<Self, SurveyFault> {
        let n = surveyor.tip_m_per_n.len();
        let tip = if detail == Detail::TipResponse { n } else { 0 };
        let mut own = Self { s, frequencies_hz: vec![0.0; n], tip_m_per_n: vec![0.0; tip] };
        surveyor.read(s, detail, &mut own.frequencies_hz, &mut own.tip_m_per_n)?;
        Ok(own)
    }

    fn view(&self) -> Station<'_> {
        Station { s: self.s, frequencies_hz: &self.frequencies_hz, tip_m_per_n: &self.tip_m_per_n }
    }
}

impl Survey {
    /// Looks at every station of `s` (ascending, 0..=1), over all cores. `progress` is told how many more
    /// stations are done, from any thread.
    ///
    /// # Errors
    /// The first station at which the arm has no modes.
    pub fn take(
        path: &Path,
        s: Vec<f64>,
        detail: Detail,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Self, SurveyFault> {
        let modes = path.robot().coordinates().len();
        let mut frequencies_hz = vec![0.0; s.len() * modes];
        let tip_columns = if detail == Detail::TipResponse { modes } else { 0 };
        let mut tip_m_per_n = vec![0.0; s.len() * tip_columns];
        // Rows of no columns still need a chunk each.
        let mut no_tip = vec![[0.0; 0]; s.len().div_ceil(CHUNK)];
        let tip_chunks: Vec<&mut [f64]> = if tip_columns > 0 {
            tip_m_per_n.chunks_mut(CHUNK * tip_columns).collect()
        } else {
            no_tip.iter_mut().map(|empty| &mut empty[..]).collect()
        };
        let faults: Vec<Option<SurveyFault>> = s
            .par_chunks(CHUNK)
            .zip(frequencies_hz.par_chunks_mut(CHUNK * modes))
            .zip(tip_chunks)
            .map_init(
                || Surveyor::new(path),
                |surveyor, ((s, frequencies), tip)| {
                    for (i, &s) in s.iter().enumerate() {
                        let row = &mut frequencies[i * modes..][..modes];
                        let tip = &mut tip[i * tip_columns..][..tip_columns];
                        if let Err(fault) = surveyor.read(s, detail, row, tip) {
                            return Some(fault);
                        }
                    }
                    progress(s.len());
                    None
                },
            )
            .collect();
        match faults.into_iter().flatten().next() {
            Some(fault) => Err(fault),
            None => Ok(Self { modes, detail, s, frequencies_hz, tip_m_per_n }),
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
        let tip = if self.detail == Detail::TipResponse { self.modes } else { 0 };
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
    /// steepest slope of the cell and its two neighbours.
    ///
    /// # Errors
    /// The first station at which the arm has no modes.
    pub fn refine(
        self,
        path: &Path,
        wants: impl Fn(&Station, &Station, &[f64]) -> bool + Sync,
    ) -> Result<Self, SurveyFault> {
        let cells = self.len().saturating_sub(1);
        let added: Vec<Vec<(usize, Vec<OwnStation>)>> = (0..cells.div_ceil(CHUNK))
            .into_par_iter()
            .map_init(
                || (Surveyor::new(path), vec![0.0; self.modes]),
                |(surveyor, rates), chunk| {
                    let mut added = Vec::new();
                    for cell in chunk * CHUNK..cells.min((chunk + 1) * CHUNK) {
                        self.rates(cell, rates);
                        let (left, right) = (self.station(cell), self.station(cell + 1));
                        if wants(&left, &right, rates) {
                            let inside =
                                halve(surveyor, self.detail, &left, &right, rates, &wants)?;
                            added.push((cell, inside));
                        }
                    }
                    Ok(added)
                },
            )
            .collect::<Result<_, SurveyFault>>()?;
        let mut added = added.into_iter().flatten().peekable();
        if added.peek().is_none() {
            return Ok(self);
        }
        let mut merged = Self {
            modes: self.modes,
            detail: self.detail,
            s: Vec::with_capacity(self.len()),
            frequencies_hz: Vec::with_capacity(self.frequencies_hz.len()),
            tip_m_per_n: Vec::with_capacity(self.tip_m_per_n.len()),
        };
        for (i, station) in self.stations().enumerate() {
            merged.push(&station);
            if let Some((_, inside)) = added.next_if(|(cell, _)| *cell == i) {
                inside.iter().for_each(|own| merged.push(&own.view()));
            }
        }
        Ok(merged)
    }

    fn push(&mut self, station: &Station) {
        self.s.push(station.s);
        self.frequencies_hz.extend_from_slice(station.frequencies_hz);
        self.tip_m_per_n.extend_from_slice(station.tip_m_per_n);
    }

    /// Twice the steepest relative slope per mode in cell `cell` and its neighbours.
    fn rates(&self, cell: usize, rates: &mut [f64]) {
        const SAFETY: f64 = 2.0;
        rates.fill(0.0);
        for i in cell.saturating_sub(1)..=(cell + 1).min(self.len() - 2) {
            let (a, b) = (self.station(i), self.station(i + 1));
            raise_rates(&a, &b, SAFETY, rates);
        }
    }
}

/// Raises each mode's rate to `factor` times its relative slope between two stations.
fn raise_rates(a: &Station, b: &Station, factor: f64, rates: &mut [f64]) {
    let width = b.s - a.s;
    for ((rate, fa), fb) in rates.iter_mut().zip(a.frequencies_hz).zip(b.frequencies_hz) {
        *rate = rate.max(factor * (fb - fa).abs() / (fa.min(*fb) * width));
    }
}

/// Stations strictly between `left` and `right`, ascending.
fn halve(
    surveyor: &mut Surveyor,
    detail: Detail,
    left: &Station,
    right: &Station,
    rates: &[f64],
    wants: &impl Fn(&Station, &Station, &[f64]) -> bool,
) -> Result<Vec<OwnStation>, SurveyFault> {
    let middle = 0.5 * (left.s + right.s);
    if middle <= left.s || middle >= right.s {
        return Ok(Vec::new());
    }
    let own = OwnStation::read(surveyor, middle, detail)?;
    let mut rates = rates.to_vec();
    // A steeper slope than the neighbours showed raises the bound.
    raise_rates(left, &own.view(), 1.0, &mut rates);
    raise_rates(&own.view(), right, 1.0, &mut rates);
    let mut stations = Vec::new();
    if wants(left, &own.view(), &rates) {
        stations = halve(surveyor, detail, left, &own.view(), &rates, wants)?;
    }
    let view = own.clone();
    stations.push(own);
    if wants(&view.view(), right, &rates) {
        stations.extend(halve(surveyor, detail, &view.view(), right, &rates, wants)?);
    }
    Ok(stations)
}
