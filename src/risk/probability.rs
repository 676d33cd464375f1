//! How probable it is that a line lies in a mode's band somewhere on a stretch: the share of draws
//! of the whole arm, each the same along the whole path.
//!
//! The frequencies of a draw are worked out exactly at places along the stretches that a line can
//! come near to; between them ln of their ratio to the model's own is linear.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVectorView};
use rayon::prelude::*;

use super::bands::LineBands;
use super::verdict::{Crossing, Driver};
use crate::notes::Note;
use crate::path::{Path, Survey, Surveyor};
use crate::uncertainty::{ArmAtPose, Belief, Draws, Estimate, Trust};

/// Draws of each of the sixteen sequences.
const PER_SEQUENCE: usize = 256;

/// Places at which draws are solved on one operation, at most.
const MAX_PLACES: usize = 64;

/// Farther than this many standard deviations from a band, a line does not come into it.
const FAR: f64 = 6.0;

/// The draws of a job: the same arm in all of its operations, whatever it carries.
#[derive(Debug, Clone, Default)]
pub struct JobDraws {
    last: Option<Arc<Draws>>,
}

/// The draws of one operation.
#[derive(Debug, Clone)]
pub struct ArmDraws {
    draws: Arc<Draws>,
    modes: usize,
    /// L of the parameters.
    factor: DMatrix<f64>,
    trust: Trust,
}

impl JobDraws {
    /// The draws of an arm with so many modes. Parameters come in one order, so that arms that
    /// carry different loads are drawn alike.
    pub fn of(&mut self, trust: &Trust, modes: usize) -> ArmDraws {
        let factor = match trust {
            Trust::Share(_) => DMatrix::zeros(0, 0),
            Trust::Belief(belief) => belief.factor(),
        };
        let dimensions = modes + factor.ncols();
        let fits = self.last.take().filter(|draws| draws.dimensions() == dimensions);
        let draws = fits.unwrap_or_else(|| Arc::new(Draws::new(dimensions, PER_SEQUENCE, 1)));
        self.last = Some(Arc::clone(&draws));
        ArmDraws { draws, modes, factor, trust: trust.clone() }
    }
}

impl ArmDraws {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.draws.count()
    }

    /// θ of every draw, row by row.
    fn parameters(&self) -> Vec<f64> {
        let p = self.factor.nrows();
        let row = |i: usize| {
            let z = &self.draws.row(i)[self.modes..];
            (0..p).map(move |k| (0..p).map(|j| self.factor[(k, j)] * z[j]).sum::<f64>())
        };
        (0..self.count()).flat_map(row).collect()
    }
}

/// Draws for an operation and its crossings.
#[derive(Debug, Clone, PartialEq)]
pub struct Probabilities {
    /// Per draw, whether any line lies anywhere in a band that nobody accepts.
    pub rings: Vec<bool>,
    /// Per crossing, that its line lies in its mode's band somewhere on its stretch.
    pub crossings: Vec<Estimate>,
    /// Eigenproblems that were solved for them.
    pub solved: usize,
}

/// A line and a mode on the stretches where they may meet.
struct Pair {
    r: usize,
    /// Whether nobody accepts that they meet.
    is_open: bool,
    /// The band, in ln of the line over the frequency.
    band: [f64; 2],
    /// ln of the line over the model's frequency at every site; `None` where it does not count.
    offsets: Vec<Option<f64>>,
    /// The first of two neighbouring stations each.
    cells: Vec<usize>,
}

/// Cells of a pair between the same two places, and of the same crossings.
struct Piece {
    /// The first of the two.
    place: usize,
    /// Of the pair's cells.
    cells: Range<usize>,
    /// Least and largest of the pair's offsets in them.
    offsets: [f64; 2],
    /// Crossings of the pair that they are part of, by index.
    crossings: Vec<usize>,
}

/// A station of the path, as far as draws need it.
struct Site {
    s: f64,
    frequencies_hz: Vec<f64>,
    tip_m_per_n: Vec<f64>,
}

/// Where frequencies of the draws are known exactly, and what they are.
struct Places {
    /// Where, ascending.
    s: Vec<f64>,
    /// Per place, ln of the ratio to the model's frequencies: one row of modes a draw; empty where
    /// that is zero.
    ln_ratio: Vec<Vec<f64>>,
    /// Per place and mode, σ of what is not explained.
    unexplained: Vec<Vec<f64>>,
}

/// The probabilities of an operation. `all` holds the bands of every line; `is_open` says of a mode
/// whether nobody accepts that lines lie in its band.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn probabilities(
    draws: &ArmDraws,
    all: &[LineBands],
    path: &Path,
    survey: &Survey,
    crossings: &[Crossing],
    is_open: impl Fn(usize) -> bool,
) -> Result<Probabilities, Note> {
    let sites = sites(survey, |s| all.first().map_or(0.0, |bands| bands.excitation_hz(s)));
    let bands_of = all.iter().flat_map(|bands| (0..draws.modes).map(move |r| (bands, r)));
    let pairs: Vec<(Pair, &LineBands)> = bands_of
        .map(|(bands, r)| (Pair::new(bands, r, &sites, is_open(r + 1)), bands))
        .filter(|(pair, _)| !pair.cells.is_empty())
        .collect();
    let std_ln = all.first().map_or(0.0, |bands| bands.rules.std_ln(0.0, 0));
    let places = Places::new(draws, path, &sites, &pairs, std_ln)?;
    let pieces: Vec<(&Pair, Vec<Piece>)> = pairs
        .iter()
        .map(|(pair, bands)| {
            let is_own =
                |c: &usize| crossings[*c].mode == pair.r + 1 && crossings[*c].line == bands.line;
            let own: Vec<usize> = (0..crossings.len()).filter(is_own).collect();
            (pair, pair.pieces(&places, &sites, crossings, &own))
        })
        .collect();
    // Of each draw: whether it rings, then every crossing.
    let width = 1 + crossings.len();
    let mut hits = vec![false; draws.count() * width];
    hits.par_chunks_mut(width).enumerate().for_each(|(draw, hits)| {
        for (pair, pieces) in &pieces {
            for piece in pieces {
                let ends = [piece.place, piece.place + 1];
                let ln_ratio = ends.map(|place| places.ln_ratio(draws, draw, place, pair.r));
                pair.take(piece, &places, &sites, ln_ratio, hits);
            }
        }
    });
    let column = |c: usize| -> Vec<bool> { hits.chunks(width).map(|row| row[c]).collect() };
    Ok(Probabilities {
        crossings: (1..width).map(|c| Draws::share(&column(c))).collect(),
        rings: column(0),
        solved: places.ln_ratio.iter().map(|own| own.len() / draws.modes).sum(),
    })
}

/// Stations that are not closer than draws need them, with those between which the speed changes.
fn sites(survey: &Survey, excitation_hz: impl Fn(f64) -> f64) -> Vec<Site> {
    const MIN_APART: f64 = 1e-4;
    const SAME_SPEED: f64 = 1e-4;
    let mut sites: Vec<Site> = Vec::new();
    for (i, station) in survey.stations().enumerate() {
        let is_apart = sites.last().is_none_or(|last| {
            let [before, here] = [last.s, station.s].map(&excitation_hz);
            station.s - last.s >= MIN_APART || (here - before).abs() > SAME_SPEED * before
        });
        if is_apart || i + 1 == survey.len() {
            sites.push(Site {
                s: station.s,
                frequencies_hz: station.frequencies_hz.to_vec(),
                tip_m_per_n: station.tip_m_per_n.to_vec(),
            });
        }
    }
    sites
}

impl Pair {
    fn new(bands: &LineBands, r: usize, sites: &[Site], is_open: bool) -> Self {
        let rules = bands.rules;
        let offset = |site: &Site| {
            let excitation_hz = bands.excitation_hz(site.s);
            let is_faint = site.tip_m_per_n.get(r).is_some_and(|&tip| rules.is_faint(tip));
            let counts = excitation_hz > 0.0 && !rules.policy.ignores(excitation_hz) && !is_faint;
            counts.then(|| (excitation_hz / site.frequencies_hz[r]).ln())
        };
        let separation = rules.policy.separation;
        let mut pair = Self {
            r,
            is_open,
            band: [(1.0 - separation).max(f64::MIN_POSITIVE).ln(), separation.ln_1p()],
            offsets: sites.iter().map(offset).collect(),
            cells: Vec::new(),
        };
        let near = |k: &usize| {
            let far = [*k, k + 1].map(|k| FAR * rules.std_ln(sites[k].s, r));
            pair.meets(*k, [0.0, 0.0], far[0].max(far[1]))
        };
        pair.cells = (0..sites.len().saturating_sub(1)).filter(near).collect();
        pair
    }

    /// Whether the line lies in the band, wider by `more`, somewhere between sites `k` and `k` + 1,
    /// where ln of the frequencies is higher by `ln_ratio`.
    fn meets(&self, k: usize, ln_ratio: [f64; 2], more: f64) -> bool {
        let [low, high] = [self.band[0] - more, self.band[1] + more];
        let offset = |end: usize| self.offsets[k + end].map(|offset| offset - ln_ratio[end]);
        match (offset(0), offset(1)) {
            (Some(a), Some(b)) => a.min(b) < high && a.max(b) > low,
            (Some(x), None) | (None, Some(x)) => low < x && x < high,
            (None, None) => false,
        }
    }

    /// Its cells by the places that they lie between and the crossings that they are part of; `own`
    /// are all of its crossings.
    fn pieces(
        &self,
        places: &Places,
        sites: &[Site],
        crossings: &[Crossing],
        own: &[usize],
    ) -> Vec<Piece> {
        let mut of_cells: Vec<Vec<usize>> = vec![Vec::new(); self.cells.len()];
        for &c in own {
            let Crossing { from_s, to_s, .. } = crossings[c];
            let first = self.cells.partition_point(|&k| sites[k + 1].s < from_s);
            let behind = self.cells.partition_point(|&k| sites[k].s <= to_s);
            of_cells[first..behind.max(first)].iter_mut().for_each(|of_cell| of_cell.push(c));
        }
        let place = |k: usize| places.before(sites[k].s);
        let cells: Vec<(usize, Vec<usize>)> = self.cells.iter().copied().zip(of_cells).collect();
        let mut end = 0;
        let alike = |a: &(usize, Vec<usize>), b: &(usize, Vec<usize>)| {
            place(a.0) == place(b.0) && a.1 == b.1
        };
        let pieces = cells.chunk_by(alike).map(|cells| {
            let offsets = cells.iter().flat_map(|&(k, _)| [self.offsets[k], self.offsets[k + 1]]);
            let bounds = [f64::INFINITY, f64::NEG_INFINITY];
            end += cells.len();
            Piece {
                place: place(cells[0].0),
                cells: end - cells.len()..end,
                offsets: offsets.flatten().fold(bounds, |[a, b], x| [a.min(x), b.max(x)]),
                crossings: cells[0].1.clone(),
            }
        });
        pieces.collect()
    }

    /// Takes down what a draw meets in a piece, at the ends of which ln of its frequency is higher
    /// by `ends`: whether it rings, then every crossing.
    fn take(
        &self,
        piece: &Piece,
        places: &Places,
        sites: &[Site],
        ends: [f64; 2],
        hits: &mut [bool],
    ) {
        let is_settled = (hits[0] || !self.is_open) && piece.crossings.iter().all(|c| hits[1 + c]);
        let [low, high] = self.band;
        let is_far = piece.offsets[1] - ends[0].min(ends[1]) <= low
            || piece.offsets[0] - ends[0].max(ends[1]) >= high;
        if is_far || is_settled {
            return;
        }
        let from_s = places.s[piece.place];
        let slope = (ends[1] - ends[0]) / (places.s[piece.place + 1] - from_s);
        let meets = |k: &usize| {
            let at = [sites[*k].s, sites[k + 1].s];
            self.meets(*k, at.map(|s| ends[0] + slope * (s - from_s)), 0.0)
        };
        if self.cells[piece.cells.clone()].iter().any(meets) {
            hits[0] |= self.is_open;
            piece.crossings.iter().for_each(|c| hits[1 + c] = true);
        }
    }
}

impl Places {
    fn new(
        draws: &ArmDraws,
        path: &Path,
        sites: &[Site],
        pairs: &[(Pair, &LineBands)],
        std_ln: f64,
    ) -> Result<Self, Note> {
        let Trust::Belief(belief) = &draws.trust else {
            return Ok(Self::alike(std_ln, draws.modes));
        };
        let mut near: Vec<usize> =
            pairs.iter().flat_map(|(pair, _)| &pair.cells).flat_map(|&k| [k, k + 1]).collect();
        near.sort_unstable();
        near.dedup();
        let step = near.len().div_ceil(MAX_PLACES).max(1);
        let mut chosen: Vec<usize> = near.iter().copied().step_by(step).collect();
        chosen.extend(near.last().copied().filter(|last| chosen.last() != Some(last)));
        let s: Vec<f64> = chosen.iter().map(|&k| sites[k].s).collect();
        let theta = draws.parameters();
        let mut surveyor = Surveyor::new(path);
        let (mut ln_ratio, mut unexplained) = (Vec::new(), Vec::new());
        for &s in &s {
            let (known, left) = ln_ratios(belief, &theta, &mut surveyor, s)?;
            ln_ratio.push(known);
            unexplained.push(left);
        }
        Ok(Self { s, ln_ratio, unexplained })
    }

    /// Where one figure says what every frequency may lie off by: each mode by itself, the same
    /// along the whole path.
    fn alike(std_ln: f64, modes: usize) -> Self {
        Self {
            s: vec![0.0, 1.0],
            ln_ratio: vec![Vec::new(); 2],
            unexplained: vec![vec![std_ln; modes]; 2],
        }
    }

    /// The last place at or before `s` that has one behind it.
    fn before(&self, s: f64) -> usize {
        let behind = self.s.partition_point(|place| *place <= s);
        behind.min(self.s.len().saturating_sub(1)).saturating_sub(1)
    }

    /// ln of the ratio of a draw's frequency to the model's.
    fn ln_ratio(&self, draws: &ArmDraws, draw: usize, place: usize, r: usize) -> f64 {
        let known = self.ln_ratio[place].get(draw * draws.modes + r).copied().unwrap_or(0.0);
        known + draws.draws.row(draw)[r] * self.unexplained[place][r]
    }
}

/// ln f_r of every draw against the model's own, at a place, and σ of what the parameters do not
/// account for.
fn ln_ratios(
    belief: &Belief,
    theta: &[f64],
    surveyor: &mut Surveyor,
    s: f64,
) -> Result<(Vec<f64>, Vec<f64>), Note> {
    surveyor.modes(s)?;
    let solver = surveyor.solver();
    let own = &solver.modes().natural_frequencies_hz;
    let arm = ArmAtPose::new(surveyor.robot(), solver, &belief.parameters);
    let sensitivities = arm.sensitivities(solver.modes());
    let left = belief.left_std_ln(&sensitivities, surveyor.joints());
    let ratios = match arm.frequencies_hz(theta) {
        Some(drawn) => drawn
            .chunks_exact(own.len())
            .flat_map(|row| row.iter().zip(own).map(|(f, own)| (f / own).ln()))
            .collect(),
        // Some draw is an arm that falls over: to first order.
        None => theta
            .chunks_exact(belief.parameters.len().max(1))
            .flat_map(|row| {
                let theta = DVectorView::from_slice(row, row.len());
                sensitivities.column_iter().map(move |a| a.dot(&theta)).collect::<Vec<_>>()
            })
            .collect(),
    };
    Ok((ratios, left))
}

/// What drives the doubt about a crossing.
///
/// # Errors
/// The arm has no modes there.
pub(super) fn driver(
    trust: &Trust,
    surveyor: &mut Surveyor,
    crossing: &Crossing,
) -> Result<Option<Driver>, Note> {
    let Trust::Belief(belief) = trust else { return Ok(None) };
    surveyor.modes(crossing.closest_s)?;
    let robot = surveyor.robot();
    let arm = ArmAtPose::new(robot, surveyor.solver(), &belief.parameters);
    let sensitivities = arm.sensitivities(surveyor.solver().modes());
    let r = crossing.mode - 1;
    let own: Vec<f64> = sensitivities.column(r).iter().copied().collect();
    let std_ln = belief.std_ln(&sensitivities, surveyor.joints())[r];
    Ok(belief
        .driver(&own, std_ln)
        .map(|(parameter, share)| Driver { parameter: parameter.name(robot), share }))
}
