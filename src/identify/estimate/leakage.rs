//! How far frequency responses scatter that were averaged over n stretches of a random force under
//! a Hann window w of T seconds. Within a stretch a mode λ also rings from before it, and the
//! window cuts off what it would ring after: with F the windowed force and Y the windowed response,
//!
//! ```text
//! Y − bF = ∫ f(s) e^{−iωs} g(s) ds,   g(s) = v(s) − b w(s),   v(s) = ∫ e^{(λ−iω)(t−s)} w(t) dt
//! ```
//!
//! over t from s or 0 to T, with the mean b of [`hann`](super::hann), so that the averaged response
//! is off by e with
//!
//! ```text
//! E(e_k e_l*) = Σ R_r R_q* ⟨g_rk, g_ql⟩ ρ_kl / (n W),   W = ∫ w² dt,   ρ = 1, −⅔, ⅙
//! ```
//!
//! on lines 0, 1 and 2 apart, and with E(e_k e_l) of the products of force and leakage on both
//! lines: one error on all lines near a narrow peak, and on all responses. Stretches overlap by
//! half, so that each shares it with its neighbours. Noise of the responses scatters with ρ². The
//! number of stretches nobody says; it is the one with which what the fit leaves near its modes has
//! its expected size (white force; Bendat & Piersol, Random Data, 4th ed., §9.2, have the variances
//! without the leakage).

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView, DVector};

use super::block::{Block, C64, Origin, Pole};
use super::fit::{Fit, Part, rows, weights};
use super::{lines_near, noise};

/// What leakage and noise make of the poles.
pub(super) struct Scatter {
    /// As [`Fit::covariance`].
    pub(super) covariance: DMatrix<f64>,
    /// Expected sum of squares that the fit leaves near each pole.
    pub(super) expected: Vec<f64>,
}

/// Correlation of the windowed force on lines so far apart.
const FORCE: [f64; 3] = [1.0, -2.0 / 3.0, 1.0 / 6.0];

/// Of the fit of one block of responses under a window; `None` of others, and where the spectra do
/// not determine all poles.
pub(super) fn under_window(blocks: &[Block], fit: &Fit) -> Option<Scatter> {
    let [block @ Block { origin: Origin::Responses { hann_s: Some(length_s) }, .. }] = blocks
    else {
        return None;
    };
    let inverse = fit.covariance()?;
    let (lines, parameters) = (block.omega.len(), inverse.nrows());
    let near: Vec<_> = fit.poles.iter().map(|pole| lines_near(&block.omega, pole)).collect();
    let window = Window::new(block, &fit.poles, *length_s);
    let none = || Share::none(near.len(), parameters);
    let [mut of_leakage, mut of_noise, mut of_sensors, mut left] = [(); 4].map(|()| none());
    let seen: Vec<Seen> =
        fit.evaluation.parts.iter().map(|part| Seen::new(blocks, fit, part)).collect();
    for (part, seen) in fit.evaluation.parts.iter().zip(&seen) {
        let noisy = Band::of(lines, |k, l| {
            let rho = window.force(k, l).powi(2);
            (C64::from(seen.level[k] * seen.level[l] * rho), C64::default())
        });
        of_noise.leave(&noisy.left_of(part), &near);
        for (k, l) in pairs(lines) {
            let own = 0.5 * noisy.0[k][l - k].0.re;
            if own == 0.0 {
                continue;
            }
            let moved =
                |p: usize, q: usize| own * (seen.turned[(k, p)] * seen.turned[(l, q)].conj()).re;
            of_noise.move_by(k == l, DMatrix::from_fn(parameters, parameters, moved));
        }
        of_sensors.vary(part, seen, &near);
        let own = |k: usize| part.residual[k].powi(2) + part.residual[lines + k].powi(2);
        left.leave(&(0..lines).map(own).collect::<Vec<_>>(), &near);
    }
    // Leakage is one for all responses.
    let line = |k: usize| Line::new(&window, &near, &seen, k);
    let mut ahead: VecDeque<Line> = (0..REACH.min(lines)).map(line).collect();
    let mut leaks: Vec<Band> =
        seen.iter().map(|_| Band::of(lines, |_, _| Default::default())).collect();
    for k in 0..lines {
        let own = &ahead[0];
        for (d, other) in ahead.iter().enumerate().filter(|(_, other)| other.leaks() && own.leaks())
        {
            let between = LinePair::new(&window, own, other);
            for (at, band) in leaks.iter_mut().enumerate() {
                let [a, b] = [&own.by_response, &other.by_response].map(|all| all.rows(at, 1));
                band.0[k][d] = between.products(a, b).map(|product| product[(0, 0)]).into();
            }
            let both = [&own.by_parameter, &other.by_parameter].map(|all| all.as_view());
            let [proper, improper] = between.products(both[0], both[1]);
            of_leakage.move_by(d == 0, (proper + improper).map(|sum| 0.5 * sum.re));
        }
        ahead.pop_front();
        if k + REACH < lines {
            ahead.push_back(line(k + REACH));
        }
    }
    for (part, leaks) in fit.evaluation.parts.iter().zip(&leaks) {
        of_leakage.leave(&leaks.left_of(part), &near);
    }
    for share in [&mut of_leakage, &mut of_noise, &mut of_sensors] {
        share.absorb(&fit.poles, &inverse);
    }
    // Near the modes they leak, elsewhere sensors show.
    let sum = |share: &Share| share.near.iter().sum::<f64>();
    let (mut leakage, mut sensors) = (0.0, 0.0);
    for _ in 0..20 {
        let far = left.far - of_noise.far - leakage * of_leakage.far;
        sensors = (far / of_sensors.far.max(f64::MIN_POSITIVE)).clamp(0.0, MOST_OF_SENSORS.powi(2));
        let near = sum(&left) - sum(&of_noise) - sensors * sum(&of_sensors);
        leakage = (near / sum(&of_leakage).max(f64::MIN_POSITIVE))
            .clamp(STRETCHES[1].recip(), STRETCHES[0].recip());
    }
    // Few lines tell little of their scatter: each pole and its residue take four values of them.
    let own = fit.poles.iter().zip(&near).filter(|(pole, _)| !pole.is_held);
    let free = own.map(|(_, near)| (near.len() as f64 - 4.0).max(0.0)).sum::<f64>().max(3.0);
    leakage *= free / (free - 2.0);
    let meat = of_leakage.meat * leakage + of_noise.meat + of_sensors.meat * sensors;
    let expected = |at: usize| {
        of_leakage.near[at] * leakage + of_noise.near[at] + of_sensors.near[at] * sensors
    };
    let covariance = &inverse * meat * &inverse;
    let is_finite = covariance.iter().all(|value| value.is_finite());
    let expected = (0..near.len()).map(expected).collect();
    is_finite.then_some(Scatter { covariance, expected })
}

/// Least and most stretches that an analyser averages.
const STRETCHES: [f64; 2] = [1.0, 500.0];

/// What sensors vary by at most.
const MOST_OF_SENSORS: f64 = 0.1;

/// A response as the fit sees it.
struct Seen {
    /// J_re − iJ_im by line and parameter, so that the gradient of a weighted error e is Re Σ J e.
    turned: DMatrix<C64>,
    residues: Vec<C64>,
    weights: Vec<f64>,
    /// Weighted size of the noise by line.
    level: Vec<f64>,
    fitted: Vec<C64>,
}

impl Seen {
    fn new(blocks: &[Block], fit: &Fit, part: &Part) -> Self {
        let block = &blocks[part.block];
        let weights = weights(&fit.noise[part.block][part.response]);
        let (changes, lines) = (fit.projected_changes(blocks, part), weights.len());
        let turned = DMatrix::from_fn(lines, changes.ncols(), |k, p| {
            C64::new(changes[(k, p)], -changes[(lines + k, p)])
        });
        let residue =
            |(place, _): &(usize, bool)| C64::new(part.factors[*place], part.factors[place + 1]);
        let residues = block.columns_of(&fit.poles).iter().map(residue).collect();
        let spectrum = &block.spectra[part.response];
        let fitted = fit.fitted(part, spectrum);
        let level = level(spectrum, &fitted);
        let level =
            level.iter().zip(&weights).map(|(power, weight)| power.sqrt() * weight).collect();
        Self { turned, residues, weights, level, fitted }
    }

    /// The gradient of an error by line.
    fn moved_by(&self, error: &[C64]) -> DVector<f64> {
        let weighted = error.iter().zip(&self.weights).map(|(e, weight)| e * *weight);
        let weighted = DVector::from_iterator(error.len(), weighted);
        self.turned.tr_mul(&weighted).map(|moved| moved.re)
    }
}

/// What leaks on a line, of the modes that are near.
struct Line {
    modes: Vec<Pair>,
    /// The share of each mode in each response, weighted.
    by_response: DMatrix<C64>,
    /// Its share in the gradient by each parameter.
    by_parameter: DMatrix<C64>,
    /// w.
    window: Pair,
}

impl Line {
    fn new(window: &Window, near: &[Range<usize>], seen: &[Seen], k: usize) -> Self {
        let own: Vec<usize> = (0..near.len()).filter(|r| near[*r].contains(&k)).collect();
        let parameters = seen.first().map_or(0, |seen| seen.turned.ncols());
        let into = |i: &Seen, r: usize| i.residues[r] * i.weights[k];
        let moved = |p: usize, r: usize| seen.iter().map(|i| i.turned[(k, p)] * into(i, r)).sum();
        Self {
            modes: own.iter().map(|r| window.g(k, *r)).collect(),
            by_response: DMatrix::from_fn(seen.len(), own.len(), |i, at| into(&seen[i], own[at])),
            by_parameter: DMatrix::from_fn(parameters, own.len(), |p, at| moved(p, own[at])),
            window: window.w(k),
        }
    }

    /// Away from the modes nothing does.
    fn leaks(&self) -> bool {
        !self.modes.is_empty()
    }
}

/// Lines that share errors, one to the next but so many.
const REACH: usize = 4;

/// Pairs of such lines, the first not above the second.
fn pairs(lines: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..lines).flat_map(move |k| (k..(k + REACH).min(lines)).map(move |l| (k, l)))
}

/// Power of the noise from line to line: of what lies apart by more lines than the window couples.
fn level(spectrum: &[C64], fitted: &[C64]) -> Vec<f64> {
    const APART: usize = 3;
    let off: Vec<C64> = spectrum.iter().zip(fitted).map(|(own, fit)| own - fit).collect();
    let apart = |k: usize| {
        let ahead = off.get(k + APART).or_else(|| off.get(k.wrapping_sub(APART)));
        ahead.map_or(0.0, |ahead| 0.5 * (ahead - off[k]).norm_sqr())
    };
    let powers: Vec<f64> = (0..off.len()).map(apart).collect();
    noise::floor(&powers, super::fit::strongest(spectrum))
}

/// One source of errors.
struct Share {
    /// Covariance of the gradient by the poles' parameters.
    meat: DMatrix<f64>,
    /// Expected square of what the fit leaves near each pole, and far from all.
    near: Vec<f64>,
    far: f64,
}

impl Share {
    fn none(poles: usize, parameters: usize) -> Self {
        Self { meat: DMatrix::zeros(parameters, parameters), near: vec![0.0; poles], far: 0.0 }
    }

    /// Squares by line.
    fn leave(&mut self, squares: &[f64], near: &[Range<usize>]) {
        for (sum, near) in self.near.iter_mut().zip(near) {
            *sum += squares[near.clone()].iter().sum::<f64>();
        }
        let is_far = |k: &usize| !near.iter().any(|near| near.contains(k));
        self.far += (0..squares.len()).filter(is_far).map(|k| squares[k]).sum::<f64>();
    }

    /// Covariance of the gradient's parts on two lines.
    fn move_by(&mut self, is_one_line: bool, own: DMatrix<f64>) {
        self.meat += &own;
        if !is_one_line {
            self.meat += own.transpose();
        }
    }

    /// Gains and phases of a sensor that vary smoothly over the lines, by 1.
    fn vary(&mut self, part: &Part, seen: &Seen, near: &[Range<usize>]) {
        /// Half waves over all lines.
        const MOST: usize = 40;
        let lines = seen.fitted.len();
        let most = MOST.min(lines / 8).max(1);
        let mut squares = vec![0.0; lines];
        for wave in 0..most {
            let size = if wave == 0 { 0.5_f64 } else { 1.0 };
            let size = (size / most as f64).sqrt();
            for turn in [C64::new(1.0, 0.0), C64::new(0.0, 1.0)] {
                let at = |k: usize| {
                    let angle = PI * wave as f64 * (k as f64 + 0.5) / lines as f64;
                    seen.fitted[k] * turn * (size * angle.cos())
                };
                let varied: Vec<C64> = (0..lines).map(at).collect();
                let moved = seen.moved_by(&varied);
                let mut varied = rows(&varied, &seen.weights);
                self.meat += &moved * moved.transpose();
                part.projection.remove(&mut varied);
                for (k, square) in squares.iter_mut().enumerate() {
                    *square += varied[k].powi(2) + varied[lines + k].powi(2);
                }
            }
        }
        self.leave(&squares, near);
    }

    /// Takes off what the poles absorb.
    fn absorb(&mut self, poles: &[Pole], inverse: &DMatrix<f64>) {
        let absorbed = inverse * &self.meat;
        let (firsts, _) = super::parameters_of(poles);
        for ((near, first), pole) in self.near.iter_mut().zip(firsts).zip(poles) {
            let own = first..first + 2 * pole.parameters();
            *near = (*near - own.map(|p| absorbed[(p, p)]).sum::<f64>()).max(0.0);
        }
    }
}

/// Covariance of weighted complex values e on lines up to so far apart: E(e_k e_l*) and E(e_k e_l).
struct Band(Vec<[(C64, C64); REACH]>);

impl Band {
    fn of(lines: usize, product: impl Fn(usize, usize) -> (C64, C64)) -> Self {
        let own = |k: usize, d: usize| match k + d {
            l if l < lines => product(k, l),
            _ => Default::default(),
        };
        Self((0..lines).map(|k| std::array::from_fn(|d| own(k, d))).collect())
    }

    /// Expected square of what the columns of a part leave of such errors, by line.
    fn left_of(&self, part: &Part) -> Vec<f64> {
        let lines = self.0.len();
        let span = part.projection.span();
        let mut applied = DMatrix::<f64>::zeros(span.nrows(), span.ncols());
        for (column, target) in span.column_iter().zip(applied.column_iter_mut()) {
            let mut target = target;
            let at = |k: usize| C64::new(column[k], column[lines + k]);
            for k in 0..lines {
                for (d, (proper, improper)) in self.0[k].iter().enumerate().take(lines - k) {
                    let ahead = (proper * at(k + d) + improper * at(k + d).conj()) * 0.5;
                    target[k] += ahead.re;
                    target[lines + k] += ahead.im;
                    if d > 0 {
                        let behind = (proper.conj() * at(k) + improper * at(k).conj()) * 0.5;
                        target[k + d] += behind.re;
                        target[lines + k + d] += behind.im;
                    }
                }
            }
        }
        let inner = span.transpose() * &applied;
        let twice = &*span * inner - &applied * 2.0;
        let row = |row: usize| span.row(row).dot(&twice.row(row));
        (0..lines).map(|k| self.0[k][0].0.re + row(k) + row(lines + k)).collect()
    }
}

/// The window on the lines of a block, and what it makes of its poles.
struct Window<'b> {
    omega: &'b [f64],
    poles: &'b [Pole],
    length_s: f64,
    /// From half a window before the stretch to its end, and from each to the next.
    times: Vec<f64>,
    step: f64,
    /// Before these times modes ring freely: root of ∫ e^{(λ + λ'*)t} dt over all that went before.
    before: Option<DMatrix<C64>>,
}

/// Of a stretch, and of the next, which begins half a window later: values at the times of the
/// first.
struct Pair([DVector<C64>; 2]);

impl Pair {
    /// ∫ ab* dt over the times of both.
    fn meet(&self, at: usize, other: &Self, other_at: usize) -> C64 {
        let [own, other] = [&self.0[at], &other.0[other_at]];
        let common = own.len().min(other.len());
        other.rows(0, common).dotc(&own.rows(0, common))
    }
}

impl<'b> Window<'b> {
    fn new(block: &'b Block, poles: &'b [Pole], length_s: f64) -> Self {
        /// Decay from one time to the next, and the number of times in half a window.
        const DECAY: f64 = 0.25;
        const STEPS: [usize; 2] = [16, 64];
        let fastest = poles.iter().map(|pole| -pole.lambda.re).fold(0.0, f64::max);
        let steps = ((0.5 * length_s * fastest / DECAY) as usize).clamp(STEPS[0], STEPS[1]);
        let step = 0.5 * length_s / steps as f64;
        let ringing = DMatrix::from_fn(poles.len(), poles.len(), |r, q| {
            -(poles[r].lambda + poles[q].lambda.conj()).inv()
        });
        Self {
            omega: &block.omega,
            poles,
            length_s,
            times: (0..3 * steps).map(|j| (j as f64 + 0.5) * step - 0.5 * length_s).collect(),
            step,
            before: ringing.cholesky().map(|factor| factor.l()),
        }
    }

    fn delays(&self) -> [f64; 2] {
        [0.0, 0.5 * self.length_s]
    }

    /// w at a time.
    fn at(&self, t: f64) -> f64 {
        let is_within = (0.0..=self.length_s).contains(&t);
        if is_within { 0.5 - 0.5 * (TAU / self.length_s * t).cos() } else { 0.0 }
    }

    /// w e^{−iωt} on a line.
    fn w(&self, k: usize) -> Pair {
        let at = |t: f64| C64::from_polar(self.at(t) * self.step.sqrt(), -self.omega[k] * t);
        let values = |delay: f64| self.times.iter().map(|t| at(t - delay)).collect::<Vec<_>>();
        Pair(self.delays().map(|delay| DVector::from_vec(values(delay))))
    }

    /// g e^{−iωt} of a pole on a line; what rings before the times comes after them.
    fn g(&self, k: usize, r: usize) -> Pair {
        let (omega, lambda, length_s) = (self.omega[k], self.poles[r].lambda, self.length_s);
        let s = lambda - C64::new(0.0, omega);
        let turn = TAU / length_s;
        let parts: [(C64, f64); 3] = [(0.5, 0.0), (-0.25, turn), (-0.25, -turn)]
            .map(|(size, by)| (size / (s + C64::new(0.0, by)), by));
        let v = |t: f64| -> C64 {
            let end = (s * (length_s - t)).exp();
            let of = |(c, by): &(C64, f64)| c * (end - C64::from_polar(1.0, by * t));
            parts.iter().map(of).sum()
        };
        let whole = v(0.0);
        let (b, _) = super::hann::response(s, length_s);
        let at = |t: f64| if t < 0.0 { whole * (-s * t).exp() } else { v(t) - b * self.at(t) };
        let values = |delay: f64| -> Vec<C64> {
            let within = self.times.iter().map(|t| t - delay);
            let within = within.map(|t| at(t) * C64::from_polar(self.step.sqrt(), -omega * t));
            let first = whole * (lambda * (0.5 * length_s + delay)).exp();
            let ring =
                |j: usize| self.before.as_ref().map_or_else(C64::default, |b| first * b[(r, j)]);
            within.chain((0..self.poles.len()).map(ring)).collect()
        };
        Pair(self.delays().map(|delay| DVector::from_vec(values(delay))))
    }

    /// Correlation of the windowed force on two lines.
    fn force(&self, k: usize, l: usize) -> f64 {
        let apart = (self.omega[l] - self.omega[k]).abs() * self.length_s / TAU;
        FORCE.get(apart.round() as usize).copied().unwrap_or(0.0)
    }
}

/// Two lines over one stretch, with itself and with those before and after it: E(e_k e_l*) and
/// E(e_k e_l) of each mode that leaks on the one with each on the other.
struct LinePair {
    proper: DMatrix<C64>,
    improper: DMatrix<C64>,
}

impl LinePair {
    fn new(window: &Window<'_>, own: &Line, other: &Line) -> Self {
        /// Stretches that meet.
        const STRETCHES: [[usize; 2]; 3] = [[0, 0], [0, 1], [1, 0]];
        // ∫ w² dt.
        let power = C64::from(0.375 * window.length_s);
        let (rows, columns) = (own.modes.len(), other.modes.len());
        let mut proper = DMatrix::zeros(rows, columns);
        let mut improper = DMatrix::zeros(rows, columns);
        for [a, b] in STRETCHES {
            let windows = other.window.meet(b, &own.window, a) / power.powi(2);
            proper += DMatrix::from_fn(rows, columns, |r, q| {
                own.modes[r].meet(a, &other.modes[q], b) * windows
            });
            let met_own = own.modes.iter().map(|own| own.meet(a, &other.window, b) / power);
            let met_other = other.modes.iter().map(|other| other.meet(b, &own.window, a) / power);
            improper += DVector::from_iterator(rows, met_own)
                * DVector::from_iterator(columns, met_other).transpose();
        }
        Self { proper, improper }
    }

    /// The same of sums of modes with the shares `a` on the one line and `b` on the other.
    fn products(&self, a: DMatrixView<'_, C64>, b: DMatrixView<'_, C64>) -> [DMatrix<C64>; 2] {
        [a * &self.proper * b.adjoint(), a * &self.improper * b.transpose()]
    }
}
