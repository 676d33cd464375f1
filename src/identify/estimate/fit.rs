//! Maximum likelihood for poles: the sum of squared residuals over all spectra, each line weighted
//! by its noise, is minimised over the poles alone; for given poles the residues are linear and
//! follow by projection (Golub & Pereyra, SIAM J. Numer. Anal. 10, 1973, with Kaufman's Jacobian,
//! BIT 15, 1975). With circular Gaussian noise of known variance this is the estimator of
//! Guillaume, Verboven & Vanlanduit (Frequency-domain maximum likelihood identification of modal
//! parameters with confidence intervals, ISMA 1998); the inverse of its normal matrix is the
//! Cramér–Rao bound, so the stated standard deviations are those of an efficient estimator.

use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView, Matrix2};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::block::{Block, C64, Pole};
use super::given_noise::{self, Left};
use super::noise::{self, Noise};
use super::projection::{Projection, dot, products};
use super::thinning::Thinned;
use super::unexplained::{Unexplained, unexplained};

/// How far a refinement goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Most steps.
    steps: usize,
    /// A step that lowers the sum of squares by less than this is the last, in units of a variance.
    negligible: f64,
}

/// For the choice among several starts.
pub(super) const COARSE: Effort = Effort { steps: 8, negligible: 0.1 };

impl Effort {
    /// Where less than such a gain does not matter.
    pub(super) fn for_gains_of(self, gain: f64) -> Self {
        Self { negligible: self.negligible.max(gain), ..self }
    }
}

/// For the decision whether a pole is significant.
pub(super) const NORMAL: Effort = Effort { steps: 30, negligible: 1e-2 };

/// For what is reported.
pub(super) const FULL: Effort = Effort { steps: 60, negligible: 1e-8 };

/// The fit of one response of one block.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub(super) block: usize,
    pub(super) response: usize,
    /// Columns of the linear problem, as they are spanned.
    pub(super) projection: Projection,
    /// Real factors of the columns.
    pub(super) factors: Vec<f64>,
    /// Derivatives of the factors by each pole's real and imaginary part.
    pub(super) sensitivities: Vec<Vec<f64>>,
    /// Weighted residual: real parts of all lines, then imaginary parts; unit variance.
    pub(super) residual: Vec<f64>,
    /// Its share of Jᵀr.
    pub(super) gradient: DVector<f64>,
}

/// All spectra at given poles.
#[derive(Debug, Clone)]
pub(super) struct Evaluation {
    pub(super) sum_of_squares: f64,
    /// JᵀJ over real and imaginary part of each parameter of each pole in turn.
    pub(super) normal: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    pub(super) parts: Vec<Part>,
}

impl Evaluation {
    /// How far a Gauss–Newton step would lower the sum of squares.
    pub(super) fn predicted_gain(&self) -> Option<f64> {
        let all: Vec<usize> = (0..self.gradient.len()).collect();
        self.predicted_gain_of(&all)
    }

    /// A step of these real parameters alone.
    pub(super) fn predicted_gain_of(&self, parameters: &[usize]) -> Option<f64> {
        let mut normal = self.normal.select_rows(parameters).select_columns(parameters);
        let gradient = self.gradient.select_rows(parameters);
        for i in 0..normal.nrows() {
            normal[(i, i)] *= 1.0 + 1e-9;
            normal[(i, i)] += f64::MIN_POSITIVE;
        }
        Some(normal.cholesky()?.solve(&gradient).dot(&gradient))
    }
}

/// First of the real parameters of each pole among those of all, and their number.
pub(super) fn parameters_of(poles: &[Pole]) -> (Vec<usize>, usize) {
    let mut next = 0;
    let firsts = poles
        .iter()
        .map(|pole| {
            let first = next;
            next += 2 * pole.parameters();
            first
        })
        .collect();
    (firsts, next)
}

/// The two real columns of one contribution, u = b + b̃ and v = i(b − b̃), so that residue x + iy
/// gives x·u + y·v; and s and t, the same of the derivatives by each parameter of the pole.
struct Pair {
    columns: [Vec<C64>; 2],
    slopes: Vec<[Vec<C64>; 2]>,
}

impl Pair {
    fn new(block: &Block, pole: &Pole, is_driven: bool) -> Self {
        let of = block.contribution(pole, is_driven);
        let sums = |[a, b]: &[Vec<C64>; 2]| -> [Vec<C64>; 2] {
            let i = C64::new(0.0, 1.0);
            [
                a.iter().zip(b).map(|(a, b)| a + b).collect(),
                a.iter().zip(b).map(|(a, b)| i * (a - b)).collect(),
            ]
        };
        Self { columns: sums(&of.value), slopes: of.slopes.iter().map(sums).collect() }
    }
}

/// Real rows of unit variance.
pub(super) fn rows(line: &[C64], weights: &[f64]) -> Vec<f64> {
    rows_of(line, weights).collect()
}

fn rows_of<'a>(line: &'a [C64], weights: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    let real = line.iter().zip(weights).map(|(v, w)| v.re * w);
    real.chain(line.iter().zip(weights).map(|(v, w)| v.im * w))
}

/// Real rows of each of some columns.
pub(super) fn matrix<'a>(
    columns: impl Iterator<Item = &'a Vec<C64>>,
    weights: &[f64],
) -> DMatrix<f64> {
    let columns: Vec<&Vec<C64>> = columns.collect();
    let mut values = Vec::with_capacity(2 * weights.len() * columns.len());
    columns.iter().for_each(|column| values.extend(rows_of(column, weights)));
    DMatrix::from_vec(2 * weights.len(), columns.len(), values)
}

pub(super) fn weights(variances: &[f64]) -> Vec<f64> {
    variances.iter().map(|variance| (2.0 / variance).sqrt()).collect()
}

/// Projects every spectrum on the columns of the poles. `None` where a pole cannot be evaluated.
pub(super) fn evaluate(blocks: &[Block], noise: &Noise, poles: &[Pole]) -> Option<Evaluation> {
    let (_, count) = parameters_of(poles);
    let mut evaluation = Evaluation {
        sum_of_squares: 0.0,
        normal: DMatrix::zeros(count, count),
        gradient: DVector::zeros(count),
        parts: Vec::new(),
    };
    for (at, block) in blocks.iter().enumerate() {
        if !poles.iter().all(|pole| pole.lambda.im > 0.0 && block.admits(pole)) {
            return None;
        }
        let pairs: Vec<Vec<Pair>> = poles.par_iter().map(|pole| pairs_of(block, pole)).collect();
        let background = block.background();
        let of_response = |(response, variances): (usize, &Vec<f64>)| {
            let weights = weights(variances);
            let columns = pairs.iter().flatten().flat_map(|pair| &pair.columns);
            let projection = Projection::of(matrix(columns.chain(&background), &weights));
            let residual = rows(&block.spectra[response], &weights);
            Share::new((at, response), poles, &pairs, projection, &weights, residual)
        };
        // In order, so that sums are the same however many threads there are.
        let shares: Vec<Share> = noise[at].par_iter().enumerate().map(of_response).collect();
        shares.into_iter().for_each(|share| evaluation.add(share));
    }
    evaluation.sum_of_squares.is_finite().then_some(evaluation)
}

/// The columns of a pole: as the force drives it, and as it moved before the record.
fn pairs_of(block: &Block, pole: &Pole) -> Vec<Pair> {
    let mut pairs = vec![Pair::new(block, pole, pole.is_driven)];
    if pole.is_driven && block.begins_moving {
        pairs.push(Pair::new(block, pole, false));
    }
    pairs
}

/// The fit of one response of one block, and its share of the normal equations.
struct Share {
    part: Part,
    sum_of_squares: f64,
    normal: DMatrix<f64>,
}

impl Evaluation {
    fn add(&mut self, share: Share) {
        self.sum_of_squares += share.sum_of_squares;
        self.normal += share.normal;
        self.gradient += &share.part.gradient;
        self.parts.push(share.part);
    }
}

impl Share {
    /// Of a weighted spectrum.
    fn new(
        (block, response): (usize, usize),
        poles: &[Pole],
        pairs: &[Vec<Pair>],
        projection: Projection,
        weights: &[f64],
        mut residual: Vec<f64>,
    ) -> Self {
        let whole = projection.shares(DMatrixView::from_slice(&residual, residual.len(), 1));
        let factors = projection.back(whole.as_slice());
        projection.remove_shares(&mut residual, whole.as_slice());
        // Of each change D only what lies outside the span Q of the columns counts:
        // JᵀJ = DᵀD − (QᵀD)ᵀ(QᵀD), and Jᵀr = Dᵀr, as the residual r lies outside of it. D = S·M.
        let (slopes, mixing) = changes(poles, pairs, &factors, weights);
        let shares = projection.shares(slopes.as_view());
        let normal = mixing.tr_mul(&(products(&slopes) - products(&shares))) * &mixing;
        let along = slopes.column_iter().map(|slope| dot(slope.as_slice(), &residual));
        let gradient = mixing.tr_mul(&DVector::from_iterator(slopes.ncols(), along));
        let back = |shares: DVectorView<f64>| {
            projection.back(shares.as_slice()).iter().map(|f| -f).collect()
        };
        let sensitivities = (shares * mixing).column_iter().map(back).collect();
        let sum_of_squares = dot(&residual, &residual);
        let part = Part { block, response, projection, factors, sensitivities, residual, gradient };
        Self { part, sum_of_squares, normal }
    }
}

/// S and M of the changes S·M of a weighted spectrum with both parts of each parameter of each pole
/// in turn: of the slopes s and t of each pair, by residue x + iy, x·s + y·t with the real part and
/// x·t − y·s with the imaginary part.
fn changes(
    poles: &[Pole],
    pairs: &[Vec<Pair>],
    factors: &[f64],
    weights: &[f64],
) -> (DMatrix<f64>, DMatrix<f64>) {
    let (firsts, count) = parameters_of(poles);
    let mut slopes: Vec<&Vec<C64>> = Vec::new();
    let mut places = Vec::new();
    let mut residues = factors.chunks_exact(2);
    for ((pole, pairs), first) in poles.iter().zip(pairs).zip(firsts) {
        for (pair, residue) in pairs.iter().zip(&mut residues) {
            for (at, of) in pair.slopes.iter().enumerate().take(pole.parameters()) {
                places.push((slopes.len(), first + 2 * at, residue));
                slopes.extend(of);
            }
        }
    }
    let mut mixing = DMatrix::zeros(slopes.len(), count);
    for (row, column, residue) in places {
        let (x, y) = (residue[0], residue[1]);
        mixing.fixed_view_mut::<2, 2>(row, column).copy_from(&Matrix2::new(x, -y, y, x));
    }
    (matrix(slopes.into_iter(), weights), mixing)
}

/// Poles and the fit at them.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) poles: Vec<Pole>,
    pub(super) noise: Noise,
    pub(super) evaluation: Evaluation,
}

impl Fit {
    /// At poles as they are.
    pub(super) fn at(blocks: &[Block], noise: Noise, poles: Vec<Pole>) -> Option<Self> {
        let evaluation = evaluate(blocks, &noise, &poles)?;
        Some(Self { poles, noise, evaluation })
    }

    /// At the least sum of squares near these poles.
    pub(super) fn near(
        blocks: &[Block],
        noise: Noise,
        poles: Vec<Pole>,
        effort: Effort,
    ) -> Option<Self> {
        /// Where a pole leaves its place, other lines are chosen.
        const THINNINGS: usize = 3;
        /// Steps over all lines where those that stayed have led to the least already: a hundredth
        /// of a deviation is left.
        const LAST: usize = 3;
        /// Less is lost between the lines that stay.
        const NEGLIGIBLE: f64 = 1e-4;
        let (mut poles, mut left) = (poles, effort);
        for _ in 0..THINNINGS {
            let Some(thinned) = Thinned::of(blocks, &noise, &poles) else { break };
            let fit = Self::at(&thinned.blocks, thinned.noise, poles.clone())?;
            let moved = fit.descended(&thinned.blocks, effort.for_gains_of(NEGLIGIBLE)).poles;
            let is_near = |(old, new): (&Pole, &Pole)| {
                (old.lambda - new.lambda).norm() < old.lambda.re.abs().min(new.lambda.re.abs())
            };
            let is_there = poles.iter().zip(&moved).all(is_near);
            poles = moved;
            if is_there {
                left.steps = left.steps.min(LAST);
                break;
            }
        }
        Some(Self::at(blocks, noise, poles)?.descended(blocks, left))
    }

    /// Moves the poles to the least sum of squares nearby.
    pub(super) fn refined(self, blocks: &[Block], effort: Effort) -> Self {
        let near = Self::near(blocks, self.noise.clone(), self.poles.clone(), effort);
        let is_better =
            |near: &Self| near.evaluation.sum_of_squares <= self.evaluation.sum_of_squares;
        near.filter(is_better).unwrap_or_else(|| self.descended(blocks, effort))
    }

    /// By Levenberg's and Marquardt's steps.
    pub(super) fn descended(mut self, blocks: &[Block], effort: Effort) -> Self {
        let mut damping = 1e-3;
        for _ in 0..effort.steps {
            let Evaluation { normal, gradient, sum_of_squares, .. } = &self.evaluation;
            let before = *sum_of_squares;
            let mut damped = normal.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] *= 1.0 + damping;
                damped[(i, i)] += f64::MIN_POSITIVE;
            }
            let Some(step) = damped.cholesky().map(|factor| factor.solve(gradient)) else {
                damping *= 10.0;
                if damping > 1e12 {
                    break;
                }
                continue;
            };
            // Less than is worth a step: its gain would drown in rounding, too.
            if step.dot(gradient) < effort.negligible {
                break;
            }
            let (firsts, _) = parameters_of(&self.poles);
            let moved: Vec<Pole> = self
                .poles
                .iter()
                .zip(firsts)
                .map(|(pole, first)| pole.moved(&step.as_slice()[first..]))
                .collect();
            let better = evaluate(blocks, &self.noise, &moved)
                .filter(|evaluation| evaluation.sum_of_squares <= before);
            match better {
                Some(evaluation) => {
                    let gained = before - evaluation.sum_of_squares;
                    self.poles = moved;
                    self.evaluation = evaluation;
                    damping = (damping * 0.1).max(1e-12);
                    if gained < effort.negligible {
                        break;
                    }
                }
                None => {
                    damping *= 10.0;
                    if damping > 1e12 {
                        break;
                    }
                }
            }
        }
        self
    }

    /// How a response changes with the poles where its residues do not follow, weighted, by both
    /// parts of each parameter of each pole in turn.
    pub(super) fn projected_changes(&self, blocks: &[Block], part: &Part) -> DMatrix<f64> {
        let block = &blocks[part.block];
        let pairs: Vec<Vec<Pair>> = self.poles.iter().map(|pole| pairs_of(block, pole)).collect();
        let weights = weights(&self.noise[part.block][part.response]);
        let (slopes, mixing) = changes(&self.poles, &pairs, &part.factors, &weights);
        let mut changes = slopes * mixing;
        part.projection.remove_from_all(&mut changes);
        changes
    }

    /// Powers of the residual in the unit of the spectrum, and the fraction of noise that the fit
    /// absorbed, line by line.
    pub(super) fn remaining(&self, part: &Part) -> (Vec<f64>, Vec<f64>) {
        let variances = &self.noise[part.block][part.response];
        let lines = variances.len();
        let leverages = part.projection.leverages(2 * lines);
        (0..lines)
            .map(|k| {
                let (re, im) = (part.residual[k], part.residual[lines + k]);
                let power = (re * re + im * im) * variances[k] / 2.0;
                (power, 0.5 * (leverages[k] + leverages[lines + k]))
            })
            .unzip()
    }

    /// The noise as the residual shows it, by `estimate` (powers, absorbed, strongest power).
    pub(super) fn noise_by(
        &self,
        blocks: &[Block],
        estimate: impl Fn(&[f64], &[f64], f64) -> Vec<f64>,
    ) -> Noise {
        let mut all: Noise = blocks.iter().map(|_| Vec::new()).collect();
        let sources: Vec<Vec<Unexplained>> =
            (0..blocks.len()).map(|at| unexplained(blocks, at, &self.poles)).collect();
        for part in &self.evaluation.parts {
            let (powers, taken) = self.remaining(part);
            let block = &blocks[part.block];
            let strongest = strongest(&block.spectra[part.response]);
            let noise = estimate(&powers, &taken, strongest);
            let mut noise = with_known(block, part.response, noise);
            for source in &sources[part.block] {
                source.add_to(&mut noise, &part.factors);
            }
            all[part.block].push(noise);
        }
        all
    }

    /// The noise of responses that an analyser made without a window, as the residual shows it.
    fn noise_without_window(&self, blocks: &[Block]) -> Noise {
        let left = |part: &Part| {
            let (powers, taken) = self.remaining(part);
            let spectrum = &blocks[part.block].spectra[part.response];
            let fitted = self.fitted(part, spectrum).iter().map(C64::norm_sqr).collect();
            Left { powers, taken, fitted, strongest: strongest(spectrum) }
        };
        let of = |at: usize| -> Vec<Left> {
            self.evaluation.parts.iter().filter(|part| part.block == at).map(left).collect()
        };
        (0..blocks.len()).map(|at| given_noise::variances(&of(at))).collect()
    }

    /// The fit on the lines of a spectrum.
    pub(super) fn fitted(&self, part: &Part, spectrum: &[C64]) -> Vec<C64> {
        let weights = weights(&self.noise[part.block][part.response]);
        let lines = spectrum.len();
        let residual = |k: usize| C64::new(part.residual[k], part.residual[lines + k]) / weights[k];
        spectrum.iter().enumerate().map(|(k, value)| value - residual(k)).collect()
    }

    /// With the lines weighted by the noise of the residual, and the poles moved accordingly.
    pub(super) fn reweighted(self, blocks: &[Block]) -> Self {
        self.weighted_by(blocks, |fit| fit.noise_by(blocks, noise::smooth))
    }

    /// The same of responses that an analyser made without a window.
    pub(super) fn reweighted_without_window(self, blocks: &[Block]) -> Self {
        self.weighted_by(blocks, |fit| fit.noise_without_window(blocks))
    }

    fn weighted_by(mut self, blocks: &[Block], noise: impl Fn(&Self) -> Noise) -> Self {
        // Only with the last noise must the poles be exact.
        for effort in [NORMAL, NORMAL, FULL] {
            let near = Self::near(blocks, noise(&self), self.poles.clone(), effort);
            let Some(fit) = near else { return self };
            self = fit;
        }
        self
    }

    /// Covariance over real and imaginary part of each parameter of each pole in turn: the
    /// Cramér–Rao bound at the estimate.
    pub(super) fn covariance(&self) -> Option<DMatrix<f64>> {
        // Scaled, as poles of different sharpness differ by many orders.
        let normal = &self.evaluation.normal;
        let scale: Vec<f64> =
            (0..normal.nrows()).map(|i| normal[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
        let scaled = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
            normal[(i, j)] / (scale[i] * scale[j])
        });
        let inverse = scaled.cholesky()?.inverse();
        let covariance = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
            inverse[(i, j)] / (scale[i] * scale[j])
        });
        covariance.iter().all(|v| v.is_finite()).then_some(covariance)
    }
}

impl Fit {
    /// Covariance as the responses show it by how far apart each would have the poles, whatever
    /// their errors share among lines (White, Maximum likelihood estimation of misspecified models,
    /// Econometrica 50, 1982, eq. 3.2, each response one observation); `None` for a single one.
    pub(super) fn covariance_between(&self) -> Option<DMatrix<f64>> {
        let parts = &self.evaluation.parts;
        let count = parts.len() as f64;
        let inverse = self.covariance()?;
        let mut meat = DMatrix::zeros(inverse.nrows(), inverse.ncols());
        for part in parts {
            meat += &part.gradient * part.gradient.transpose();
        }
        (parts.len() > 1).then(|| &inverse * (meat * (count / (count - 1.0))) * &inverse)
    }
}

pub(super) fn strongest(spectrum: &[C64]) -> f64 {
    spectrum.iter().fold(f64::MIN_POSITIVE, |most, v| most.max(v.norm_sqr()))
}

/// Noise of the force reaches the residual through the response: with noise in both, each line is
/// weighted by the sum (Pintelon & Schoukens, §9.11). No line is less noisy than the rounding of
/// its samples: that of a short burst is similar on neighbouring lines, which would pass for modes.
fn with_known(block: &Block, response: usize, mut noise: Vec<f64>) -> Vec<f64> {
    if let Some(least) = block.min_noise.get(response) {
        noise.iter_mut().for_each(|noise| *noise = noise.max(*least));
    }
    let spectrum = &block.spectra[response];
    for ((noise, error), value) in noise.iter_mut().zip(&block.drive_error).zip(spectrum) {
        *noise += error * value.norm_sqr();
    }
    noise
}

/// The noise that the spectra themselves show between their peaks.
pub(super) fn first_noise(blocks: &[Block]) -> Noise {
    blocks
        .iter()
        .map(|block| {
            block
                .spectra
                .iter()
                .enumerate()
                .map(|(response, spectrum)| {
                    let powers: Vec<f64> = spectrum.iter().map(C64::norm_sqr).collect();
                    let floor = noise::floor(&powers, strongest(spectrum));
                    with_known(block, response, floor)
                })
                .collect()
        })
        .collect()
}
