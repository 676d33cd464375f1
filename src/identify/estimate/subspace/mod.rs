//! Modes from the response to a force that nobody measured and that goes on, by covariance-driven
//! stochastic subspace identification (Peeters & De Roeck, Mech. Syst. Signal Process. 13(6),
//! 1999). Deviations follow by first-order perturbation of the subspace from the scatter of the
//! correlations over stretches of the record (Reynders, Pintelon & De Roeck, Mech. Syst. Signal
//! Process. 22(4), 2008).

mod correlations;
mod realisation;
mod significance;

use correlations::Correlations;
use realisation::{Found, Realisation};
use significance::Spectra;

use super::block::{C64, Pole};
use super::lscf::PolesByOrder;
use super::{Estimate, PoleEstimate, Residue};
use crate::statistics::rms;
use crate::units::rad_per_s_from_hz;

/// Largest order of the state.
const HIGHEST: usize = 40;

/// Block rows of the Hankel matrix: the correlations are used up to twice as many lags.
const MAX_ROWS: usize = 60;
const MIN_ROWS: usize = 8;

/// Rows of the Hankel matrix in all.
const MAX_SIZE: usize = 240;

/// More damping is no vibration worth showing.
const MAX_RATIO: f64 = 0.2;

/// A pole that is known worse than this is none: relative to the frequency, and to the damping.
const MAX_OMEGA_STD: f64 = 0.02;
const MAX_RATIO_STD: f64 = 0.7;

/// Poles of neighbouring orders that lie this close in frequency and whose shapes have at least
/// this modal assurance criterion are one.
const SAME_FREQUENCY: f64 = 0.01;
const SAME_SHAPE: f64 = 0.9;

/// A mode has a pole in at least this share of the orders.
const MIN_SUPPORT: f64 = 0.35;

/// Responses to a random force, sampled together.
#[derive(Debug, Clone)]
pub(in crate::identify) struct Stationary {
    /// Samples per second.
    pub(in crate::identify) rate_hz: f64,
    /// Where modes are looked for, Hz.
    pub(in crate::identify) band_hz: [f64; 2],
    /// By response.
    pub(in crate::identify) responses: Vec<Vec<f64>>,
    /// Of the responses under a Hann window.
    pub(in crate::identify) spectra: Vec<Vec<C64>>,
    /// The same at a lower rate, for modes that are too slow for the lags.
    pub(in crate::identify) below: Option<Box<Stationary>>,
}

/// What a random response gives.
pub(in crate::identify) struct OfRandom {
    /// The modes.
    pub(in crate::identify) found: Estimate,
    /// The poles of each order.
    pub(in crate::identify) by_order: PolesByOrder,
    /// Poles that keep their place but do not stand out of the spectrum, rad/s.
    pub(in crate::identify) hidden: Vec<f64>,
    /// Modes of which the correlations hold too few periods, rad/s.
    pub(in crate::identify) slow: Vec<f64>,
}

impl Stationary {
    /// How long the record is.
    pub(in crate::identify) fn duration_s(&self) -> f64 {
        self.responses.first().map_or(0.0, |own| own.len() as f64 / self.rate_hz)
    }

    /// Lowest frequency of which the block rows hold enough: slower modes come out biased, with
    /// deviations that do not say so.
    pub(in crate::identify) fn slowest_hz(&self) -> f64 {
        const PERIODS: f64 = 3.0;
        PERIODS * self.rate_hz / most_rows(self.responses.len()) as f64
    }

    /// Whether so many samples are enough for all block rows.
    pub(in crate::identify) fn is_enough(&self, samples: f64) -> bool {
        samples >= Correlations::samples_for(most_rows(self.responses.len())) as f64
    }
}

fn most_rows(responses: usize) -> usize {
    (MAX_SIZE / responses.max(1)).clamp(MIN_ROWS, MAX_ROWS)
}

/// The modes, and the poles of each order. `None` where the record is too short.
pub(in crate::identify) fn of_random(stationary: &Stationary, highest: usize) -> Option<OfRandom> {
    let mut own = of_band(stationary, highest)?;
    let below = stationary.below.as_ref().and_then(|below| of_random(below, highest));
    let limit = rad_per_s_from_hz(stationary.slowest_hz());
    if let Some(below) = below {
        return Some(own.over(limit, below));
    }
    let slow = own.found.poles.iter().map(|own| own.pole.omega());
    own.slow = slow.filter(|omega| *omega < limit).collect();
    Some(own)
}

impl OfRandom {
    /// What lies above a limit, rad/s, with what another found below it.
    fn over(mut self, limit: f64, below: Self) -> Self {
        self.found.poles.retain(|own| own.pole.omega() >= limit);
        self.hidden.retain(|own| *own >= limit);
        let slow = |own: &PoleEstimate| own.pole.omega() < limit;
        self.found.poles.splice(0..0, below.found.poles.into_iter().filter(slow));
        self.hidden.splice(0..0, below.hidden.into_iter().filter(|own| *own < limit));
        self.slow = below.slow;
        for (i, (_, own)) in self.by_order.iter_mut().enumerate() {
            let slow = below.by_order.get(i).map_or(&[][..], |(_, poles)| poles);
            own.retain(|pole| pole.omega() >= limit);
            own.extend(slow.iter().filter(|pole| pole.omega() < limit));
        }
        self
    }
}

fn of_band(stationary: &Stationary, highest: usize) -> Option<OfRandom> {
    let Stationary { rate_hz, band_hz: [low_hz, high_hz], responses, spectra, .. } = stationary;
    // Responses count alike, whatever their units.
    let sizes: Vec<f64> =
        responses.iter().map(|r| rms(r.iter().copied()).max(f64::MIN_POSITIVE)).collect();
    let scaled: Vec<Vec<f64>> = responses
        .iter()
        .zip(&sizes)
        .map(|(r, size)| r.iter().map(|y| y / size).collect())
        .collect();
    let samples = responses.first()?.len();
    let correlations = (MIN_ROWS..=most_rows(responses.len()))
        .rev()
        .step_by(4)
        .find_map(|rows| Correlations::of(&scaled, rows))
        .filter(|_| samples > 0)?;
    let step_s = rate_hz.recip();
    let realisation =
        Realisation::new(&correlations, step_s, responses.len(), highest.min(HIGHEST));
    let is_asked = |lambda: C64| {
        let omega = lambda.norm();
        lambda.re < 0.0
            && -lambda.re < MAX_RATIO * omega
            && lambda.im < 0.98 * std::f64::consts::PI / step_s
            && (rad_per_s_from_hz(*low_hz)..=rad_per_s_from_hz(*high_hz)).contains(&omega)
    };
    let orders: Vec<usize> = (2..=realisation.highest()).step_by(2).collect();
    let by_order: Vec<Vec<Found>> =
        orders.iter().map(|&order| realisation.poles(order, &is_asked)).collect();
    let spectra = Spectra {
        lines: spectra,
        spacing: rad_per_s_from_hz(stationary.duration_s().recip()),
        band: [*low_hz, *high_hz].map(rad_per_s_from_hz),
    };
    let columns = modes(&by_order);
    let shows = |at: usize| {
        let others = (0..columns.len()).filter(|other| *other != at);
        let others: Vec<C64> = others.map(|other| columns[other].lambda).collect();
        spectra.show(columns[at].lambda, &others)
    };
    let (shown_at, hidden_at): (Vec<usize>, Vec<usize>) =
        (0..columns.len()).partition(|at| shows(*at));
    let mut hidden: Vec<f64> = hidden_at.into_iter().map(|at| columns[at].omega()).collect();
    hidden.sort_by(f64::total_cmp);
    let mut poles: Vec<PoleEstimate> =
        shown_at.into_iter().map(|at| estimate(columns[at], &sizes)).collect();
    poles.sort_by(|a, b| a.pole.omega().total_cmp(&b.pole.omega()));
    let shown = |found: &Vec<Found>| found.iter().map(|found| Pole::new(found.lambda)).collect();
    let by_order = orders.iter().copied().zip(by_order.iter().map(shown)).collect();
    let found = Estimate { poles, fitted: Vec::new(), noise: Vec::new(), begins_moving: false };
    Some(OfRandom { found, by_order, hidden, slow: Vec::new() })
}

fn estimate(found: &Found, sizes: &[f64]) -> PoleEstimate {
    let residue = |((value, variance), size): (&(C64, f64), &f64)| Residue {
        value: value * *size,
        variance: variance * size * size,
    };
    PoleEstimate {
        pole: Pole::new(found.lambda),
        omega_std: found.omega_std,
        ratio_std: found.ratio_std,
        residues: vec![found.shape.iter().zip(sizes).map(residue).collect()],
        prominence: 1.0,
        drift: None,
        damping_drift: None,
        is_artefact: false,
    }
}

/// Of the poles of a column of the stabilisation diagram, the share that is surer than the one that
/// counts: orders that a mode does not need state more than it scatters by.
const SURER: f64 = 0.3;

/// Of each column of the stabilisation diagram, that pole.
fn modes(by_order: &[Vec<Found>]) -> Vec<&Found> {
    let mut columns: Vec<Vec<&Found>> = Vec::new();
    let is_known = |found: &&Found| {
        found.omega_std < MAX_OMEGA_STD * found.omega()
            && found.ratio_std < MAX_RATIO_STD * found.ratio()
    };
    for found in by_order.iter().flatten().filter(is_known) {
        let apart = |column: &Vec<&Found>| {
            let last = column.last().filter(|last| last.order < found.order)?;
            let apart = (last.omega() / found.omega() - 1.0).abs();
            (apart < SAME_FREQUENCY && mac(last, found) > SAME_SHAPE).then_some(apart)
        };
        let nearest = (0..columns.len())
            .filter_map(|i| Some((i, apart(&columns[i])?)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        match nearest {
            Some((i, _)) => columns[i].push(found),
            None => columns.push(vec![found]),
        }
    }
    columns.retain(|column| column.len() as f64 >= MIN_SUPPORT * by_order.len() as f64);
    columns.sort_by_key(|column| std::cmp::Reverse(column.len()));
    let mut modes: Vec<&Found> = Vec::new();
    for mut column in columns {
        column.sort_by(|a, b| a.omega_std.total_cmp(&b.omega_std));
        let middle = column[(SURER * column.len() as f64) as usize];
        // High orders split a mode in two.
        let is_split = modes.iter().any(|mode| {
            let apart = (mode.omega() - middle.omega()).abs();
            let reach =
                2.0 * SAME_FREQUENCY * mode.omega() + 3.0 * (mode.omega_std + middle.omega_std);
            apart < reach && mac(mode, middle) > SAME_SHAPE
        });
        if !is_split {
            modes.push(middle);
        }
    }
    modes
}

/// Modal assurance criterion of two shapes; of one response it says nothing.
fn mac(a: &Found, b: &Found) -> f64 {
    let both = a.shape.iter().zip(&b.shape);
    let product: C64 = both.map(|((a, _), (b, _))| a.conj() * b).sum();
    let square = |of: &Found| of.shape.iter().map(|(value, _)| value.norm_sqr()).sum::<f64>();
    product.norm_sqr() / (square(a) * square(b)).max(f64::MIN_POSITIVE)
}
