//! Spectra → poles and residues with covariances.
//!
//! One method serves hammer tests, steady excitation, given frequency responses and free decays: a
//! rational function with common denominator in the frequency domain, first by linear least squares
//! of rising order ([`lscf`]), which gives the stabilisation diagram and starts, then by maximum
//! likelihood ([`fit`]) with the order chosen by significance ([`select`]).
//!
//! Why not a subspace or eigensystem realisation for the decays: the discrete Fourier transform of
//! a free decay is a rational function exactly ([`basis`]), so decays and hammer records differ by
//! one term; a band is cut out by taking its lines, where a realisation would need filters whose
//! own poles disturb it; and the last step reaches the Cramér–Rao bound and states it, while
//! realisations and LSCF alone are biased in damping at low signal-to-noise ratio and need a
//! perturbation analysis of their own for deviations. The response to a force that goes on and was
//! not measured has no such spectrum: there a realisation is the method ([`subspace`]).

mod bands;
mod basis;
mod block;
mod drift;
mod fit;
mod given_noise;
pub(super) mod hann;
mod impacts;
mod leakage;
pub(super) mod lscf;
mod merge;
mod noise;
pub(super) mod peaks;
mod projection;
mod select;
mod states;
pub(super) mod subspace;
mod thinning;
mod unexplained;
mod window;

use nalgebra::{DMatrix, DVector, Vector2};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use bands::Band;
pub(super) use block::{Block, C64, ForceSample, OF_SENSORS, Origin, Pole};
use fit::{Fit, Part, parameters_of};
use merge::{have_one_shape, merged, shape_of};
use window::{Doubt, Rival, share_of_rival};

use crate::statistics::chi_squared_bound;

/// A residue with what is known about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Residue {
    /// Factor of b(ω) at λ.
    pub(super) value: C64,
    /// Mean variance of its real and imaginary part.
    pub(super) variance: f64,
}

/// A pole as it was estimated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PoleEstimate {
    /// The pole.
    pub(super) pole: Pole,
    /// Standard deviation of the natural frequency |λ|, rad/s; of a pole that drifts, with the
    /// error of the model of drift.
    pub(super) omega_std: f64,
    /// Standard deviation of the damping ratio.
    pub(super) ratio_std: f64,
    /// By block and response.
    pub(super) residues: Vec<Vec<Residue>>,
    /// The pole's loudest line relative to the spectrum's, at the response where that is largest.
    pub(super) prominence: f64,
    /// Largest shift of the frequency from that at small amplitudes, relative to it; `None` where
    /// it does not depend on amplitude.
    pub(super) drift: Option<f64>,
    /// By how much the damping ratio is larger there.
    pub(super) damping_drift: Option<f64>,
    /// Whether it is an effect of other modes' drift.
    pub(super) is_artefact: bool,
}

impl PoleEstimate {
    /// Without what a window added to its decay rate, 1/s.
    pub(super) fn without_window(&self, decay_per_s: f64) -> Self {
        let lambda = self.pole.lambda + decay_per_s;
        Self { pole: Pole { lambda, ..self.pole }, ..self.clone() }
    }
}

/// All poles of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Estimate {
    /// By ascending frequency.
    pub(super) poles: Vec<PoleEstimate>,
    /// The fit on the lines of each spectrum, by block and response.
    pub(super) fitted: Vec<Vec<Vec<C64>>>,
    /// Standard deviation of each line's noise, by block and response.
    pub(super) noise: Vec<Vec<Vec<f64>>>,
    /// Whether the arm was moving when the records began.
    pub(super) begins_moving: bool,
}

/// Finds the poles, `most` in a band of lines at most. `None` where the spectra are empty or hold
/// nothing that can be fitted.
pub(super) fn estimate(blocks: &mut [Block], starts: &[Pole], most: usize) -> Option<Estimate> {
    if blocks.iter().all(|block| block.spectra.is_empty() || block.omega.is_empty()) {
        return None;
    }
    let bands = bands::divided(blocks, starts);
    if bands.len() > 1 {
        let fits_together = starts.len() <= MOST_TOGETHER;
        let found = in_bands(blocks, starts, &bands, most, fits_together, true);
        if found.is_some() || !fits_together {
            return found;
        }
    }
    let certain = |blocks: &mut [Block]| {
        let fit = fitted_poles(blocks, starts, most)?;
        determined(blocks, fit)
    };
    let mut fit = certain(blocks)?;
    let mut rival = Rival::of(blocks, &fit);
    if let Some(better) = rival.take_if(|rival| rival.gain > 0.0) {
        let before = std::mem::replace(&mut blocks[0].origin, better.origin);
        match certain(blocks) {
            Some(other) => fit = other,
            None => blocks[0].origin = before,
        }
        rival = Rival::of(blocks, &fit);
    }
    beside_rival(blocks, fit, rival)
}

/// Without leakage where there is none, with the doubt of the window. Where each response has a
/// mode in another place, the sharpest of them would have it alone.
fn beside_rival(blocks: &[Block], mut fit: Fit, rival: Option<Rival>) -> Option<Estimate> {
    if let Some(rival) = rival.as_ref().filter(|_| have_one_place(blocks, &fit)) {
        let sharper = rival.without_leakage(blocks, fit.clone());
        fit = if sharper.covariance().is_some() { sharper } else { fit };
    }
    let doubt = rival.map(|rival| Doubt { share: share_of_rival(rival.gain), poles: rival.poles });
    report(blocks, &fit, doubt.as_ref())
}

/// The poles of all lines together.
fn fitted_poles(blocks: &mut [Block], starts: &[Pole], most: usize) -> Option<Fit> {
    let mut fit = select::select(blocks, starts, most)?.reweighted(blocks);
    if let Some(moving) = moving_before(blocks, &fit) {
        fit = moving;
    }
    fit = merged(blocks, fit);
    drop_outside_band(blocks, &mut fit);
    Some(fit)
}

/// Starts beyond which a record is not fitted as a whole: that costs their fourth power.
const MOST_TOGETHER: usize = 16;

/// The poles band by band: first each for itself, then with those of its neighbours held. `None`
/// where a band cannot be fitted, or where a mode drifts, which takes all of the spectrum; where
/// there are too many to be fitted together, its drift is that of its band.
fn in_bands(
    blocks: &mut [Block],
    starts: &[Pole],
    bands: &[Band],
    most: usize,
    fits_together: bool,
    may_exchange: bool,
) -> Option<Estimate> {
    let alone = |band: &Band| {
        let mut cut = band.cut(blocks)?;
        let fit = fitted_poles(&mut cut, &band.seen(starts), most)?;
        Some((cut, fit))
    };
    let first: Vec<(Vec<Block>, Fit)> = bands.par_iter().map(alone).collect::<Option<_>>()?;
    let rivals: Vec<Option<Rival>> = first.iter().map(|(cut, fit)| Rival::of(cut, fit)).collect();
    let gain: f64 = rivals.iter().flatten().map(|rival| rival.gain).sum();
    if let Some(better) = rivals.iter().flatten().next().filter(|_| gain > 0.0 && may_exchange) {
        blocks[0].origin = better.origin.clone();
        return in_bands(blocks, starts, bands, most, fits_together, false);
    }
    let known: Vec<Pole> =
        bands.iter().zip(&first).flat_map(|(band, (_, fit))| band.own(&fit.poles)).collect();
    let together = |(band, (cut, fit)): (&Band, &(Vec<Block>, Fit))| {
        let mut poles = band.own(&fit.poles);
        poles.extend(band.held(&known));
        let fit = Fit::near(cut, fit.noise.clone(), poles, fit::FULL)?.reweighted(cut);
        let is_linear = !has_twins(cut, &fit) && drift::drifting(cut, &fit).is_none();
        if is_linear || fits_together {
            let rival = Rival::of(cut, &fit).map(|rival| Rival { gain, ..rival });
            return beside_rival(cut, fit, rival).filter(|_| is_linear);
        }
        let (cut, fit) = with_own_drift(cut, fit);
        report(&cut, &determined(&cut, fit)?, None)
    };
    let found: Vec<Estimate> = bands.par_iter().zip(&first).map(together).collect::<Option<_>>()?;
    Some(bands::joined(blocks, bands, found))
}

/// A band in which modes drift instead of having twins, wherever that explains the spectra as well.
/// Drift alone is not looked for: feet of other bands' modes pass for it.
fn with_own_drift(blocks: &[Block], fit: Fit) -> (Vec<Block>, Fit) {
    /// Of what the twin explains.
    const MIN_FRACTION: f64 = 0.7;
    let instead = |blocks: &[Block], fit: &Fit, twin: usize| {
        let mut poles = fit.poles.clone();
        poles.remove(twin);
        let without = Fit::near(blocks, fit.noise.clone(), poles, fit::NORMAL)?;
        let (drifting, other, _) = drift::drifting(blocks, &without)?;
        let [with, left, alone] = [fit, &other, &without].map(|of| of.evaluation.sum_of_squares);
        (alone - left > MIN_FRACTION * (alone - with)).then_some((drifting, other))
    };
    let (mut blocks, mut fit) = (blocks.to_vec(), fit);
    while let Some((drifting, other)) =
        twins(&blocks, &fit).into_iter().find_map(|twin| instead(&blocks, &fit, twin))
    {
        fit = other.reweighted(&drifting);
        blocks = drifting;
    }
    (blocks, fit)
}

/// Without the weakest poles, as long as the spectra do not determine all.
fn determined(blocks: &[Block], mut fit: Fit) -> Option<Fit> {
    while fit.covariance().is_none() {
        let mut poles = fit.poles.clone();
        poles.remove(select::weakest(blocks, &fit)?);
        fit = Fit::near(blocks, fit.noise.clone(), poles, fit::FULL)?;
    }
    Some(fit)
}

/// Whether two poles of one shape lie within their widths: without a law of drift, a mode that
/// drifts needs such a row.
fn has_twins(blocks: &[Block], fit: &Fit) -> bool {
    !twins(blocks, fit).is_empty()
}

/// The poles that may be such twins of others.
fn twins(blocks: &[Block], fit: &Fit) -> Vec<usize> {
    let own = |at: &usize| !fit.poles[*at].is_held && fit.poles[*at].is_driven;
    let own: Vec<usize> = (0..fit.poles.len()).filter(own).collect();
    let is_twin = |a: usize, b: usize| {
        select::is_on(&fit.poles[a], &fit.poles[b])
            && have_one_shape(&shape_of(blocks, fit, a), &shape_of(blocks, fit, b))
    };
    own.iter().copied().filter(|&a| own.iter().any(|&b| b != a && is_twin(a, b))).collect()
}

/// With vibration from before the records, where that is significant.
fn moving_before(blocks: &mut [Block], fit: &Fit) -> Option<Fit> {
    /// −ln of the probability that noise alone shows such vibration, about one in a thousand.
    const FALSE_ALARM: f64 = 7.0;
    /// Of what is required, what must show before the poles move.
    const PROMISING: f64 = 0.3;
    let before: Vec<bool> = blocks.iter().map(|block| block.begins_moving).collect();
    let waits: Vec<bool> = blocks.iter().map(waits_for_its_force).collect();
    if !waits.contains(&true) {
        return None;
    }
    for (block, waits) in blocks.iter_mut().zip(&waits) {
        block.begins_moving |= waits;
    }
    let freedom: usize =
        blocks.iter().zip(&waits).filter(|(_, w)| **w).map(|(b, _)| 2 * b.spectra.len()).sum();
    let required = chi_squared_bound((freedom * fit.poles.len()) as f64, FALSE_ALARM);
    let gain = |trial: &Fit| fit.evaluation.sum_of_squares - trial.evaluation.sum_of_squares;
    let trial = Fit::at(blocks, fit.noise.clone(), fit.poles.clone())
        .filter(|trial| gain(trial) > PROMISING * required)
        .map(|trial| trial.refined(blocks, fit::FULL));
    match trial {
        Some(trial) if gain(&trial) > required => Some(trial.reweighted(blocks)),
        _ => {
            blocks.iter_mut().zip(before).for_each(|(block, before)| block.begins_moving = before);
            None
        }
    }
}

/// Whether the force begins late enough to distinguish an earlier vibration from the one it causes.
fn waits_for_its_force(block: &Block) -> bool {
    match &block.origin {
        Origin::Sampled { force: Some(force), .. } if !block.begins_moving => {
            force.first().is_some_and(|sample| sample.at >= 8.0)
        }
        _ => false,
    }
}

/// Without the poles that the refinement has moved out of the band; without them, others may move
/// there. In what an analyser made they stay, held, as modes beyond its lines: their skirts would
/// move others.
fn drop_outside_band(blocks: &[Block], fit: &mut Fit) {
    let is_given = blocks.iter().all(Block::is_given);
    let is_outside = |pole: &&Pole| !pole.is_held && !select::in_band(blocks, pole);
    while fit.poles.iter().any(|pole| is_outside(&pole)) {
        let held = |pole: &Pole| Pole { is_held: pole.is_held || is_outside(&pole), ..*pole };
        let poles = fit.poles.iter();
        let poles: Vec<Pole> = match is_given {
            true => poles.map(held).collect(),
            false => poles.filter(|pole| !is_outside(pole)).copied().collect(),
        };
        let other = Fit::near(blocks, fit.noise.clone(), poles, fit::FULL);
        let Some(other) = other else { return };
        *fit = other;
    }
}

fn report(blocks: &[Block], fit: &Fit, doubt: Option<&Doubt>) -> Option<Estimate> {
    let errors = Errors::of(blocks, fit)?;
    let (firsts, _) = parameters_of(&fit.poles);
    let own: Vec<usize> = (0..fit.poles.len()).filter(|&at| !fit.poles[at].is_held).collect();
    let of = |&at: &usize| {
        let pole = pole_estimate(blocks, fit, at, firsts[at], &errors);
        doubt.map_or_else(|| pole.clone(), |doubt| doubt.widen(&pole, at))
    };
    let mut poles: Vec<PoleEstimate> = own.iter().map(of).collect();
    let peaks: Vec<f64> = poles.iter().map(|pole| pole.prominence).collect();
    let own: Vec<Pole> = own.iter().map(|&at| fit.poles[at]).collect();
    for (at, pole) in poles.iter_mut().enumerate() {
        pole.is_artefact = unexplained::is_artefact(blocks, &own, &peaks, at);
    }
    poles.sort_by(|a, b| a.pole.omega().total_cmp(&b.pole.omega()));
    let deviations = |variances: &Vec<f64>| variances.iter().map(|v| v.sqrt()).collect();
    let noise = fit.noise.iter().map(|block| block.iter().map(deviations).collect()).collect();
    Some(Estimate {
        poles,
        fitted: fitted(blocks, fit),
        noise,
        begins_moving: blocks.iter().any(|block| block.begins_moving),
    })
}

/// How many lines share an error near the modes of what an analyser made, which has that much less
/// to tell; lines of a record have each their own. What bends over many lines elsewhere moves no
/// pole.
fn shared_lines(blocks: &[Block], fit: &Fit) -> f64 {
    let near = |part: &Part| -> Vec<Vec<f64>> {
        let lines = blocks[part.block].omega.len();
        let own = |pole: &Pole| {
            let near = lines_near(&blocks[part.block].omega, pole);
            let imaginary = lines + near.start..lines + near.end;
            [&part.residual[near], &part.residual[imaginary]].concat()
        };
        fit.poles.iter().filter(|pole| !pole.is_held).map(own).collect()
    };
    let parts = fit.evaluation.parts.iter().filter(|part| blocks[part.block].is_given());
    noise::shared_lines(parts.flat_map(near))
}

/// The fit on the lines of each spectrum, by block and response.
fn fitted(blocks: &[Block], fit: &Fit) -> Vec<Vec<Vec<C64>>> {
    let mut fitted: Vec<Vec<Vec<C64>>> = blocks.iter().map(|_| Vec::new()).collect();
    for part in &fit.evaluation.parts {
        let spectrum = &blocks[part.block].spectra[part.response];
        fitted[part.block].push(fit.fitted(part, spectrum));
    }
    fitted
}

/// How far a fit may be off.
struct Errors {
    /// Of both parts of each parameter of each pole in turn.
    covariance: DMatrix<f64>,
    /// Lines that share an error.
    shared: f64,
    /// What is left near each pole by the errors that are known.
    expected: Option<Vec<f64>>,
    /// The covariance by what an analyser's responses show of each other.
    between: Option<DMatrix<f64>>,
}

impl Errors {
    fn of(blocks: &[Block], fit: &Fit) -> Option<Self> {
        let shared = shared_lines(blocks, fit);
        let (covariance, expected) = match leakage::under_window(blocks, fit) {
            Some(scatter) => (scatter.covariance, Some(scatter.expected)),
            None => (fit.covariance()? * shared, None),
        };
        let is_given = blocks.iter().all(Block::is_given);
        let between = fit.covariance_between().filter(|_| is_given);
        Some(Self { covariance, shared, expected, between })
    }

    /// What is left about a pole of the fit, over what is expected there.
    fn misfit(&self, blocks: &[Block], fit: &Fit, at: usize) -> f64 {
        misfit_near(blocks, fit, &fit.poles[at], self.expected.as_ref().map(|own| own[at]))
    }

    /// Variance of a function of both parts of the parameter that begins at `first`, where what is
    /// left is so many times what is expected: as the responses show it where that is more than
    /// chance, as they have it where each has its modes in another place.
    fn variance(&self, fit: &Fit, first: usize, by: Vector2<f64>, misfit: f64) -> f64 {
        /// −ln of the probability that noise alone shows so much more.
        const FALSE_ALARM: f64 = 3.0;
        let own = misfit * variance_along(&self.covariance, first, by);
        let between = self.between.as_ref().map(|all| variance_along(all, first, by));
        between.filter(|between| *between > own * excess(fit, FALSE_ALARM)).unwrap_or(own)
    }
}

/// How many times the variance between the responses exceeds their own with such a −ln of
/// probability by chance.
fn excess(fit: &Fit, false_alarm: f64) -> f64 {
    let free = fit.evaluation.parts.len() as f64 - 1.0;
    chi_squared_bound(free, false_alarm) / free
}

fn variance_along(covariance: &DMatrix<f64>, first: usize, by: Vector2<f64>) -> f64 {
    by.dot(&(covariance.fixed_view::<2, 2>(first, first) * by)).max(0.0)
}

/// Whether the responses do not have a mode in places that differ by more than noise.
fn have_one_place(blocks: &[Block], fit: &Fit) -> bool {
    /// −ln of the probability that noise alone shows otherwise at a mode.
    const FALSE_ALARM: f64 = 9.0;
    let Some(errors) = Errors::of(blocks, fit) else { return true };
    let Some(between) = &errors.between else { return true };
    let (firsts, _) = parameters_of(&fit.poles);
    let is_one = |at: usize| {
        let [own, between] = [&errors.covariance, between]
            .map(|all| variance_along(all, firsts[at], Vector2::new(0.0, 1.0)));
        between <= own * errors.misfit(blocks, fit, at) * excess(fit, FALSE_ALARM)
    };
    (0..fit.poles.len()).filter(|&at| !fit.poles[at].is_held).all(is_one)
}

/// A pole of the fit; `first` is its first real parameter.
fn pole_estimate(
    blocks: &[Block],
    fit: &Fit,
    at: usize,
    first: usize,
    errors: &Errors,
) -> PoleEstimate {
    let pole = &fit.poles[at];
    let misfit = errors.misfit(blocks, fit, at);
    let (omega, s, w) = (pole.omega(), pole.lambda.re, pole.lambda.im);
    let by_omega = Vector2::new(s, w) / omega;
    let by_ratio = Vector2::new(-w * w, s * w) / omega.powi(3);
    let deviation = |by: Vector2<f64>| errors.variance(fit, first, by, misfit).sqrt();
    let mut residues: Vec<Vec<Residue>> = blocks.iter().map(|_| Vec::new()).collect();
    let mut prominence: f64 = 0.0;
    for part in &fit.evaluation.parts {
        let block = &blocks[part.block];
        let (place, _) = block.columns_of(&fit.poles)[at];
        let residue = residue(part, place, &errors.covariance, errors.shared);
        // Its loudest line: the nearest one may lie where the force has none.
        let of = block.contribution(pole, pole.is_driven);
        let loudest = of.value[0].iter().map(|b| b.norm()).fold(0.0, f64::max);
        let strongest = block.loudest.get(part.response).copied();
        let strongest =
            strongest.unwrap_or_else(|| fit::strongest(&block.spectra[part.response])).sqrt();
        prominence = prominence.max(residue.value.norm() * loudest / strongest);
        residues[part.block].push(residue);
    }
    let drift = unexplained::drift_of(blocks, pole);
    let [of_omega, of_ratio] = unexplained::model_error(blocks, drift);
    PoleEstimate {
        pole: *pole,
        omega_std: deviation(by_omega).hypot(omega * of_omega),
        ratio_std: deviation(by_ratio).hypot(of_ratio),
        residues,
        prominence,
        drift: pole.drifts().then_some(drift.im),
        damping_drift: pole.drifts().then_some(-drift.re),
        is_artefact: false,
    }
}

/// What a fit to responses that an analyser made leaves near a pole.
struct Leaves {
    /// Sum of squares, over what is allowed on each line.
    left: f64,
    /// Of so many values, but for those that residues take.
    values: f64,
}

/// From a line to the next, rad/s; some may be left out.
fn apart(omega: &[f64]) -> f64 {
    omega.windows(2).map(|pair| pair[1] - pair[0]).reduce(f64::min).unwrap_or(0.0)
}

/// The lines that tell of a pole.
fn lines_near(omega: &[f64], pole: &Pole) -> std::ops::Range<usize> {
    /// Decay rates and lines to either side.
    const RATES: f64 = 4.0;
    const LINES: f64 = 4.0;
    let reach = (RATES * pole.lambda.re.abs()).max(LINES * apart(omega));
    let from = omega.partition_point(|w| *w < pole.omega() - reach);
    from..omega.partition_point(|w| *w <= pole.omega() + reach)
}

fn leaves(blocks: &[Block], fit: &Fit, pole: &Pole) -> Leaves {
    let mut near = Leaves { left: 0.0, values: 0.0 };
    for part in fit.evaluation.parts.iter().filter(|part| blocks[part.block].is_given()) {
        let omega = &blocks[part.block].omega;
        let std::ops::Range { start: from, end: to } = lines_near(omega, pole);
        let own = |k: usize| part.residual[k].powi(2) + part.residual[omega.len() + k].powi(2);
        near.left += (from..to).map(own).sum::<f64>();
        // The residue takes two of them.
        near.values += 2.0 * (to - from) as f64 - 2.0;
    }
    near
}

/// What is left about a pole over what sensors and noise are allowed there, or over what is
/// `expected`, which is believed where less is left. 1 for records. Few lines say little: they
/// count beside some that leave what is allowed.
fn misfit_near(blocks: &[Block], fit: &Fit, pole: &Pole, expected: Option<f64>) -> f64 {
    /// Values that are taken to be as allowed.
    const ALLOWED: f64 = 3.0;
    let Leaves { left, values } = leaves(blocks, fit, pole);
    match expected {
        Some(expected) => ((ALLOWED + left) / (ALLOWED + expected)).max(1.0),
        // The pole takes two.
        None => (ALLOWED + left) / (ALLOWED + (values - 2.0).max(0.0)),
    }
}

/// The residue whose columns begin at `place`; its variance has shares of the noise and of the
/// poles.
fn residue(part: &Part, place: usize, covariance: &DMatrix<f64>, shared: f64) -> Residue {
    let inverse = part.projection.inverse_triangle();
    // R⁻¹ is kept by columns: row i of it meets every column.
    let of_noise = |i: usize| inverse.iter().map(|column| column[i].powi(2)).sum::<f64>();
    let of_poles = |i: usize| {
        let row = DVector::from_iterator(
            part.sensitivities.len(),
            part.sensitivities.iter().map(|by| by[i]),
        );
        row.dot(&(covariance * &row)).max(0.0)
    };
    let variance = |i: usize| shared * of_noise(i) + of_poles(i);
    Residue {
        value: C64::new(part.factors[place], part.factors[place + 1]),
        variance: 0.5 * (variance(place) + variance(place + 1)),
    }
}
