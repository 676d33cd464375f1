//! Zeroth order: the directional matrix replaced by its mean (Altintas & Budak, CIRP Annals 44,
//! 1995), with all cross terms.
//!
//! On the limit the tip vibrates at ω, and 1/a is an eigenvalue of G(iω) H̄ times
//! s(ω) = 1 − (1/z) Σ_j exp(−iωτ_j). Even teeth have one delay: then an eigenvalue λ gives the
//! depth, 1 / (2 Re λ), and the phase of the waves, whatever the speed is.
//!
//! Process damping adds iω D̄ to s(ω) H̄, D̄ its mean per depth; that changes with the speed, so
//! then eigenvalues are looked at along ω for each speed.

use std::f64::consts::TAU;

use nalgebra::{Complex, Matrix2, Matrix3x2};

use super::cut::Cut;
use super::limit::{DEEPEST_M, Kind, Limit};
use super::mode::{ToolMode, receptance_m_per_n};
use crate::units::{hz_from_rad_per_s, hz_from_rpm};

/// Frequencies per mode, on either side of it.
const PER_SIDE: usize = 80;

/// From this share of the lowest frequency to this multiple of the highest.
const REACH: [f64; 2] = [0.05, 5.0];

/// Candidates within this share of the smallest depth are solved exactly.
const NEAR: f64 = 1.3;

/// Most of them.
const MAX_SOLVED: usize = 6;

/// With process damping the waves between teeth change by this much in a step, rad, unless that
/// takes more parts between two frequencies than there may be.
const STEP_RAD: f64 = 0.1;
const MAX_PARTS: f64 = 1e4;

/// The eigenvalues of G(iω) H̄ per depth at one frequency, 1/m.
type Pair = [Complex<f64>; 2];

/// What does not depend on the spindle's speed.
#[derive(Debug, Clone)]
pub struct Chart {
    modes: Vec<ToolMode>,
    mean: Matrix3x2<f64>,
    /// The mean of what damps per depth, times the spindle's angular speed, N/m².
    rubbing: Option<Matrix3x2<f64>>,
    /// Angles between teeth over 2π; one alone where they are even.
    pitch_turns: Vec<f64>,
    omegas: Vec<f64>,
    /// In the order that keeps each branch smooth.
    values: Vec<Pair>,
    /// Where a limit of even teeth may lie, the shallowest first.
    segments: Vec<Segment>,
}

/// One branch between two frequencies.
#[derive(Debug, Clone, Copy)]
struct Segment {
    /// Of the lower frequency.
    index: usize,
    branch: usize,
    /// 1 over the depth at its ends, 1/m.
    inverse: [f64; 2],
    omega: [f64; 2],
    /// At its ends, without a jump between them, rad.
    phase: [f64; 2],
}

impl Segment {
    fn shallowest(&self) -> f64 {
        self.inverse[0].max(self.inverse[1])
    }
}

/// A place where the limit of even teeth may be.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// 1 over the depth, about, 1/m.
    inverse: f64,
    segment: Segment,
    /// Whole waves between teeth.
    waves: f64,
}

impl Chart {
    /// For modes that move the tip, in the tool's frame.
    pub fn new(modes: &[ToolMode], cut: &Cut) -> Self {
        let pitch_turns = match cut.even_pitch_rad() {
            Some(pitch) => vec![pitch / TAU],
            None => cut.pitch_rad.iter().map(|pitch| pitch / TAU).collect(),
        };
        let rubbing = cut.is_damped().then(|| cut.mean_rubbing());
        Self { rubbing, ..Self::of_mean(&cut.in_axes(modes), cut.mean(), pitch_turns) }
    }

    fn of_mean(modes: &[ToolMode], mean: Matrix3x2<f64>, pitch_turns: Vec<f64>) -> Self {
        let modes = modes.to_vec();
        let omegas = frequencies(&modes);
        let mut values: Vec<Pair> = Vec::with_capacity(omegas.len());
        for &omega in &omegas {
            let pair = eigenvalues(&modes, &mean, omega);
            values.push(values.last().map_or(pair, |last| in_order(*last, pair)));
        }
        let branches = if pitch_turns.len() == 1 { 0..2 } else { 0..0 };
        let mut segments: Vec<Segment> = branches
            .flat_map(|branch| {
                (0..values.len().saturating_sub(1)).map(move |index| (branch, index))
            })
            .filter_map(|(branch, index)| segment(&omegas, &values, branch, index))
            .collect();
        segments.sort_by(|a, b| b.shallowest().total_cmp(&a.shallowest()));
        Self { modes, mean, rubbing: None, pitch_turns, omegas, values, segments }
    }

    /// Smallest limit over all speeds without process damping, m; `None` where nothing ever grows.
    pub fn lowest_m(&self) -> Option<f64> {
        let all = self.values.iter().flatten().filter_map(|value| depth_of(*value));
        all.min_by(f64::total_cmp)
    }

    /// The limit at a spindle speed; `None` where there is none below 1 m.
    pub fn limit(&self, rpm: f64) -> Option<Limit> {
        let turn_s = hz_from_rpm(rpm).recip();
        match (self.pitch_turns.as_slice(), &self.rubbing) {
            (pitches, Some(rubbing)) => self.damped(pitches, rubbing, turn_s),
            ([pitch], None) => self.of_even_teeth(turn_s * pitch),
            (pitches, None) => {
                let delays: Vec<f64> = pitches.iter().map(|pitch| pitch * turn_s).collect();
                self.real(&|omega| regained(&delays, omega), 0.2 / turn_s)
            }
        }
        .map(|(depth_m, omega)| Limit {
            depth_m,
            frequency_hz: hz_from_rad_per_s(omega),
            kind: Kind::Hopf,
        })
    }

    /// The smallest depth at which an eigenvalue of G(iω) (s(ω) H̄ + iω D̄) is real and above zero,
    /// D̄ the mean of what damps per depth, with its frequency.
    fn damped(&self, pitches: &[f64], rubbing: &Matrix3x2<f64>, turn_s: f64) -> Option<(f64, f64)> {
        let delays: Vec<f64> = pitches.iter().map(|pitch| pitch * turn_s).collect();
        let pair_at = |omega: f64| {
            let [waves, rate] = [regained(&delays, omega), Complex::new(0.0, omega * turn_s / TAU)];
            let force = self.mean.map(Complex::from) * waves + rubbing.map(Complex::from) * rate;
            eigenvalues_of(&self.modes, &force, omega)
        };
        let longest = delays.iter().copied().fold(0.0, f64::max);
        let mut best: Option<(f64, f64)> = None;
        let mut last: Option<(f64, Pair)> = None;
        for &end in &self.omegas {
            let from = last.map_or(end, |(omega, _)| omega);
            let parts = ((end - from) * longest / STEP_RAD).ceil().clamp(1.0, MAX_PARTS);
            for part in 1..=parts as usize {
                let omega = from + (end - from) * part as f64 / parts;
                let pair = last
                    .map_or_else(|| pair_at(omega), |(_, before)| in_order(before, pair_at(omega)));
                if let Some((before, values)) = last {
                    for (value, here) in values.into_iter().zip(pair) {
                        if (value.im > 0.0) != (here.im > 0.0) && value.re.max(here.re) > 0.0 {
                            let at = |omega: f64| nearest(value, pair_at(omega));
                            let found = real_between(&at, [before, omega]);
                            best = match (best, found) {
                                (Some(best), Some(found)) if best.0 <= found.0 => Some(best),
                                (best, found) => found.or(best),
                            };
                        }
                    }
                }
                last = Some((omega, pair));
            }
        }
        best.filter(|&(depth_m, _)| depth_m < DEEPEST_M)
    }

    /// The smallest depth at which whole waves lie between teeth, with its frequency.
    fn of_even_teeth(&self, delay_s: f64) -> Option<(f64, f64)> {
        let mut found: Vec<Candidate> = Vec::new();
        let mut most: f64 = 0.0;
        for segment in &self.segments {
            if segment.shallowest() * NEAR < most {
                break;
            }
            let [first, last] =
                [0, 1].map(|end| waves(segment.omega[end], delay_s, segment.phase[end]));
            let (low, high) = (first.min(last), first.max(last));
            let mut whole = low.ceil().max(0.0);
            while whole <= high {
                let share = if last == first { 0.0 } else { (whole - first) / (last - first) };
                let [from, to] = segment.inverse;
                let inverse = from + (to - from) * share;
                if inverse * NEAR >= most {
                    most = most.max(inverse);
                    found.push(Candidate { inverse, segment: *segment, waves: whole });
                }
                whole += 1.0;
            }
        }
        found.retain(|candidate| candidate.inverse * NEAR >= most);
        found.sort_by(|a, b| b.inverse.total_cmp(&a.inverse));
        let solved = found.iter().take(MAX_SOLVED).filter_map(|candidate| {
            let (omega, value) = self.solved(candidate, delay_s);
            Some((depth_of(value)?, omega))
        });
        solved.filter(|&(depth_m, _)| depth_m < DEEPEST_M).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Where whole waves lie between teeth, within a segment.
    fn solved(&self, candidate: &Candidate, delay_s: f64) -> (f64, Complex<f64>) {
        let Candidate { segment, waves: whole, .. } = *candidate;
        let end = |i: usize| (segment.omega[i], self.values[segment.index + i][segment.branch]);
        let (mut low, mut high) = (end(0), end(1));
        let near = phase(if low.1.re > high.1.re { low.1 } else { high.1 });
        let off = |(omega, value)| waves(omega, delay_s, phase_near(near, value)) - whole;
        let (mut off_low, mut off_high) = (off(low), off(high));
        let mut best = low;
        for step in 0..80 {
            let secant = (off_low * high.0 - off_high * low.0) / (off_low - off_high);
            let inside = secant.is_finite() && secant > low.0 && secant < high.0 && step % 4 != 3;
            let omega = if inside { secant } else { 0.5 * (low.0 + high.0) };
            let pair = eigenvalues(&self.modes, &self.mean, omega);
            let beside = if (omega - low.0) < (high.0 - omega) { low.1 } else { high.1 };
            best = (omega, nearest(beside, pair));
            let off_here = off(best);
            if !off_here.is_finite() || off_here.abs() < 1e-14 || high.0 - low.0 < 1e-15 * omega {
                break;
            }
            if (off_here > 0.0) == (off_low > 0.0) {
                (low, off_low) = (best, off_here);
            } else {
                (high, off_high) = (best, off_here);
            }
        }
        best
    }

    /// The smallest depth at which an eigenvalue times `factor` is real and above zero; the grid is
    /// made finer than `step_rad_per_s`.
    fn real(
        &self,
        factor: &dyn Fn(f64) -> Complex<f64>,
        step_rad_per_s: f64,
    ) -> Option<(f64, f64)> {
        let mut best: Option<(f64, f64)> = None;
        let mut last: Option<(f64, Pair)> = None;
        for (i, (&omega, pair)) in self.omegas.iter().zip(&self.values).enumerate() {
            let parts = match i {
                0 => 1,
                _ => {
                    ((omega - self.omegas[i - 1]) / step_rad_per_s).ceil().clamp(1.0, 1e4) as usize
                }
            };
            let before =
                if i == 0 { (omega, *pair) } else { (self.omegas[i - 1], self.values[i - 1]) };
            for part in 1..=parts {
                let share = part as f64 / parts as f64;
                let at = before.0 + (omega - before.0) * share;
                let here: Pair =
                    std::array::from_fn(|b| before.1[b] + (pair[b] - before.1[b]) * share);
                if let Some((from, values)) = last {
                    for branch in 0..2 {
                        let ends = [values[branch] * factor(from), here[branch] * factor(at)];
                        if (ends[0].im > 0.0) != (ends[1].im > 0.0)
                            && ends[0].re.max(ends[1].re) > 0.0
                        {
                            let found = self.real_within(factor, [from, at], values[branch]);
                            best = match (best, found) {
                                (Some(best), Some(found)) if best.0 <= found.0 => Some(best),
                                (best, found) => found.or(best),
                            };
                        }
                    }
                }
                last = Some((at, here));
            }
        }
        best.filter(|&(depth_m, _)| depth_m < DEEPEST_M)
    }

    fn real_within(
        &self,
        factor: &dyn Fn(f64) -> Complex<f64>,
        ends: [f64; 2],
        near: Complex<f64>,
    ) -> Option<(f64, f64)> {
        let at =
            |omega: f64| nearest(near, eigenvalues(&self.modes, &self.mean, omega)) * factor(omega);
        real_between(&at, ends)
    }
}

/// The depth at which an eigenvalue is real and above zero, and where between two frequencies.
fn real_between(
    at: &dyn Fn(f64) -> Complex<f64>,
    [mut low, mut high]: [f64; 2],
) -> Option<(f64, f64)> {
    let is_above = at(low).im > 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (at(middle).im > 0.0) == is_above { low = middle } else { high = middle }
    }
    let omega = 0.5 * (low + high);
    let value = at(omega);
    // A pole of the phase is no root.
    let is_root = value.re > 0.0 && value.im.abs() < 1e-6 * value.re;
    is_root.then(|| (value.re.recip(), omega))
}

/// s(ω) = 1 − (1/z) Σ_j exp(−iωτ_j).
fn regained(delays_s: &[f64], omega: f64) -> Complex<f64> {
    let sum: Complex<f64> = delays_s.iter().map(|delay| Complex::cis(-omega * delay)).sum();
    Complex::from(1.0) - sum / delays_s.len() as f64
}

/// The smallest depth at which modes feed each other where a tooth meets fresh material, as in the
/// first pass over it: F = a H̄ u. `None` where there is none below 1 m.
pub fn coupling_limit(modes: &[ToolMode], mean: &Matrix3x2<f64>) -> Option<Limit> {
    let chart = Chart::of_mean(modes, *mean, vec![1.0]);
    let vibrating = chart.real(&|_| Complex::from(1.0), f64::INFINITY);
    // Without any vibration: the force grows faster than the springs hold.
    let still = eigenvalues(modes, mean, 0.0)
        .into_iter()
        .filter(|value| value.im.abs() < 1e-12 * value.norm() && value.re > DEEPEST_M.recip());
    let still = still.map(|value| (value.re.recip(), 0.0));
    let (depth_m, omega) = still.chain(vibrating).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Limit { depth_m, frequency_hz: hz_from_rad_per_s(omega), kind: Kind::Coupling })
}

/// The depth at which an eigenvalue of even teeth is on the limit, if at all: 1 / (2 Re λ).
fn depth_of(value: Complex<f64>) -> Option<f64> {
    let depth = (2.0 * value.re).recip();
    (depth > 0.0 && depth.is_finite()).then_some(depth)
}

/// Half the phase between the waves of two teeth that an eigenvalue on the limit asks for, rad.
fn phase(value: Complex<f64>) -> f64 {
    value.re.atan2(-value.im)
}

/// The same within half a turn of `near`.
fn phase_near(near: f64, value: Complex<f64>) -> f64 {
    let own = phase(value);
    own - TAU * ((own - near) / TAU).round()
}

/// Waves between two teeth beyond those that the eigenvalue of a phase asks for: a whole number on
/// the limit.
fn waves(omega: f64, delay_s: f64, phase: f64) -> f64 {
    (omega * delay_s - 2.0 * phase) / TAU
}

/// A branch between two frequencies; `None` where no limit below 1 m lies there. With a depth below
/// zero on one side only, the limit rises beyond all bounds between.
fn segment(omegas: &[f64], values: &[Pair], branch: usize, index: usize) -> Option<Segment> {
    let ends = [0, 1].map(|end| values[index + end][branch]);
    let [from, to] = ends;
    let near = phase(if from.re > to.re { from } else { to });
    let segment = Segment {
        index,
        branch,
        inverse: ends.map(|value| 2.0 * value.re),
        omega: [omegas[index], omegas[index + 1]],
        phase: ends.map(|value| phase_near(near, value)),
    };
    (segment.shallowest() > DEEPEST_M.recip()).then_some(segment)
}

fn eigenvalues(modes: &[ToolMode], mean: &Matrix3x2<f64>, omega: f64) -> Pair {
    eigenvalues_of(modes, &mean.map(Complex::from), omega)
}

/// Of G(iω) times a matrix.
fn eigenvalues_of(modes: &[ToolMode], force: &Matrix3x2<Complex<f64>>, omega: f64) -> Pair {
    let receptance = receptance_m_per_n(modes, omega);
    let mut gain = Matrix2::<Complex<f64>>::zeros();
    for i in 0..2 {
        for j in 0..2 {
            gain[(i, j)] = (0..3).map(|k| receptance[(i, k)] * force[(k, j)]).sum();
        }
    }
    let half = (gain[(0, 0)] + gain[(1, 1)]) * 0.5;
    let difference = (gain[(0, 0)] - gain[(1, 1)]) * 0.5;
    let root = (difference * difference + gain[(0, 1)] * gain[(1, 0)]).sqrt();
    // The smaller one without cancellation.
    let sign = if (half.conj() * root).re < 0.0 { -1.0 } else { 1.0 };
    let large = half + root * sign;
    let determinant = gain[(0, 0)] * gain[(1, 1)] - gain[(0, 1)] * gain[(1, 0)];
    let small = if large.norm() > 0.0 { determinant / large } else { large };
    [large, small]
}

fn in_order(last: Pair, [a, b]: Pair) -> Pair {
    let kept = (a - last[0]).norm() + (b - last[1]).norm();
    let turned = (b - last[0]).norm() + (a - last[1]).norm();
    if kept <= turned { [a, b] } else { [b, a] }
}

fn nearest(to: Complex<f64>, [a, b]: Pair) -> Complex<f64> {
    if (a - to).norm() <= (b - to).norm() { a } else { b }
}

/// Close about each mode, with the width of its resonance, and wide apart from all.
fn frequencies(modes: &[ToolMode]) -> Vec<f64> {
    let lowest = modes.iter().map(|mode| mode.omega_rad_per_s).fold(f64::INFINITY, f64::min);
    let highest = modes.iter().map(|mode| mode.omega_rad_per_s).fold(0.0, f64::max);
    let [from, to] = [lowest * REACH[0], highest * REACH[1]];
    let mut all = Vec::with_capacity(modes.len() * 2 * PER_SIDE + 2);
    for mode in modes {
        let width = mode.damping_ratio.max(1e-4);
        let reach = (2.0 / width).asinh();
        for i in 0..=PER_SIDE {
            let off = width * (reach * i as f64 / PER_SIDE as f64).sinh();
            all.extend([1.0 + off, 1.0 / (1.0 + off)].map(|f| f * mode.omega_rad_per_s));
        }
    }
    let steps = 60;
    let growth = (to / from).ln() / f64::from(steps);
    all.extend((0..=steps).map(|i| from * (growth * f64::from(i)).exp()));
    all.retain(|omega| (from..=to).contains(omega));
    all.sort_by(f64::total_cmp);
    all.dedup_by(|b, a| *b - *a < 1e-12 * *a);
    all
}
