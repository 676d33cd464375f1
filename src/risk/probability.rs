//! How probable it is that a line lies in a mode's band somewhere on a stretch: the share of draws
//! of the whole arm, each the same along the whole path.
//!
//! The frequencies of a draw are worked out exactly at places along the stretches that a line can
//! come near to; between them ln of their ratio to the model's own is linear.

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

/// Shares of draws for an operation and its crossings.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Probabilities {
    /// Per draw, whether any line lies in any band anywhere.
    pub(super) rings: Vec<bool>,
    /// Per crossing, that its line lies in its mode's band somewhere on its stretch.
    pub(super) crossings: Vec<Estimate>,
}

/// A line and a mode on the stretches where they may meet.
struct Pair {
    r: usize,
    /// The band, in ln of the line over the frequency.
    band: [f64; 2],
    /// ln of the line over the model's frequency at every site; `None` where it does not count.
    offsets: Vec<Option<f64>>,
    /// The first of two neighbouring stations each.
    cells: Vec<usize>,
    /// Crossings of this line and mode, by index.
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
    /// Per site, the place before it and the share of the way to the next one.
    of_sites: Vec<(usize, f64)>,
    /// Per place, ln of the ratio to the model's frequencies: one row of modes a draw.
    ln_ratio: Vec<Vec<f64>>,
    /// Per place and mode, σ of what is not explained.
    unexplained: Vec<Vec<f64>>,
}

/// The probabilities of an operation. `all` holds the bands of every line.
///
/// # Errors
/// The arm has no modes somewhere.
pub(super) fn probabilities(
    draws: &ArmDraws,
    all: &[LineBands],
    path: &Path,
    survey: &Survey,
    crossings: &[Crossing],
) -> Result<Probabilities, Note> {
    let sites = sites(survey);
    let pairs: Vec<Pair> = all
        .iter()
        .flat_map(|bands| (0..draws.modes).map(move |r| (bands, r)))
        .map(|(bands, r)| Pair::new(bands, r, &sites, crossings))
        .filter(|pair| !pair.cells.is_empty())
        .collect();
    let std_ln = all.first().map_or(0.0, |bands| bands.rules.std_ln(0.0, 0));
    let places = Places::new(draws, path, &sites, &pairs, std_ln)?;
    let outcomes: Vec<(bool, Vec<usize>)> = (0..draws.count())
        .into_par_iter()
        .map(|i| {
            let mut met = Vec::new();
            let mut rings = false;
            for pair in &pairs {
                let ln_ratio = |k: usize| places.ln_ratio(draws, i, k, pair.r);
                for &k in &pair.cells {
                    if !pair.meets(k, [ln_ratio(k), ln_ratio(k + 1)], 0.0) {
                        continue;
                    }
                    rings = true;
                    let [from, to] = [sites[k].s, sites[k + 1].s];
                    let on =
                        |c: &&usize| crossings[**c].from_s <= to && crossings[**c].to_s >= from;
                    met.extend(pair.crossings.iter().filter(on));
                }
            }
            (rings, met)
        })
        .collect();
    let of_crossing = |c: usize| {
        let hits: Vec<bool> = outcomes.iter().map(|(_, met)| met.contains(&c)).collect();
        Draws::share(&hits)
    };
    Ok(Probabilities {
        crossings: (0..crossings.len()).map(of_crossing).collect(),
        rings: outcomes.into_iter().map(|(rings, _)| rings).collect(),
    })
}

/// Stations that are not closer than draws need them.
fn sites(survey: &Survey) -> Vec<Site> {
    const LEAST_APART: f64 = 1e-4;
    let mut sites: Vec<Site> = Vec::new();
    for (i, station) in survey.stations().enumerate() {
        let is_apart = sites.last().is_none_or(|last| station.s - last.s >= LEAST_APART);
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
    fn new(bands: &LineBands, r: usize, sites: &[Site], crossings: &[Crossing]) -> Self {
        let rules = bands.rules;
        let is_own = |c: &usize| crossings[*c].mode == r + 1 && crossings[*c].line == bands.line;
        let offset = |site: &Site| {
            let excitation_hz = bands.excitation_hz(site.s);
            let is_faint = site.tip_m_per_n.get(r).is_some_and(|&tip| rules.is_faint(tip));
            let counts = excitation_hz > 0.0 && !rules.policy.ignores(excitation_hz) && !is_faint;
            counts.then(|| (excitation_hz / site.frequencies_hz[r]).ln())
        };
        let separation = rules.policy.separation;
        let mut pair = Self {
            r,
            band: [(1.0 - separation).max(f64::MIN_POSITIVE).ln(), separation.ln_1p()],
            offsets: sites.iter().map(offset).collect(),
            cells: Vec::new(),
            crossings: (0..crossings.len()).filter(is_own).collect(),
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
}

impl Places {
    fn new(
        draws: &ArmDraws,
        path: &Path,
        sites: &[Site],
        pairs: &[Pair],
        std_ln: f64,
    ) -> Result<Self, Note> {
        let Trust::Belief(belief) = &draws.trust else {
            return Ok(Self::alike(std_ln, sites.len(), draws.modes));
        };
        let mut near: Vec<usize> =
            pairs.iter().flat_map(|pair| &pair.cells).flat_map(|&k| [k, k + 1]).collect();
        near.sort_unstable();
        near.dedup();
        let step = near.len().div_ceil(MAX_PLACES).max(1);
        let mut chosen: Vec<usize> = near.iter().copied().step_by(step).collect();
        chosen.extend(near.last().copied().filter(|last| chosen.last() != Some(last)));
        let theta = draws.parameters();
        let mut surveyor = Surveyor::new(path);
        let (mut ln_ratio, mut unexplained) = (Vec::new(), Vec::new());
        for &k in &chosen {
            let (known, left) = ln_ratios(belief, &theta, &mut surveyor, sites[k].s)?;
            ln_ratio.push(known);
            unexplained.push(left);
        }
        let of_site = |k: usize| {
            let after = chosen.partition_point(|&place| place <= k).clamp(1, chosen.len().max(1));
            match (chosen.get(after - 1), chosen.get(after)) {
                (Some(&from), Some(&to)) => {
                    let way = sites[to].s - sites[from].s;
                    (after - 1, ((sites[k].s - sites[from].s) / way).clamp(0.0, 1.0))
                }
                _ => (after - 1, 0.0),
            }
        };
        Ok(Self { of_sites: (0..sites.len()).map(of_site).collect(), ln_ratio, unexplained })
    }

    /// Where one figure says what every frequency may lie off by: each mode by itself, the same
    /// along the whole path.
    fn alike(std_ln: f64, sites: usize, modes: usize) -> Self {
        Self {
            of_sites: vec![(0, 0.0); sites],
            ln_ratio: vec![Vec::new()],
            unexplained: vec![vec![std_ln; modes]],
        }
    }

    /// ln of the ratio of a draw's frequency to the model's.
    fn ln_ratio(&self, draws: &ArmDraws, draw: usize, site: usize, r: usize) -> f64 {
        let (before, share) = self.of_sites[site];
        let between = |values: &[Vec<f64>], at: usize| {
            let from = values.get(before).and_then(|row| row.get(at)).copied().unwrap_or(0.0);
            let to = values.get(before + 1).and_then(|row| row.get(at)).copied().unwrap_or(from);
            from + share * (to - from)
        };
        let known = between(&self.ln_ratio, draw * draws.modes + r);
        known + draws.draws.row(draw)[r] * between(&self.unexplained, r)
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
    let own: Vec<f64> = sensitivities.column(crossing.mode - 1).iter().copied().collect();
    Ok(belief
        .driver(&own)
        .map(|(parameter, share)| Driver { parameter: parameter.name(robot), share }))
}
