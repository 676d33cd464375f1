//! Spectra with many modes are fitted in bands: the cost of one fit grows with the fourth power of
//! its modes, and a mode is known from the lines around it. Modes of other bands show as skirts:
//! those near by as held poles, the others as a background that bends.

use std::ops::Range;

use super::Estimate;
use super::block::{Block, Pole};
use super::fit::strongest;
use super::noise::Noise;
use super::peaks::divisions;

/// Lines and starts from which on bands are worth it.
const MIN_LINES: usize = 1200;
const MIN_STARTS: usize = 8;

/// Starts of a band, where they lie far enough apart.
const STARTS: usize = 4;

/// Fewest lines of a band.
const LINES_OF_BAND: usize = 120;

/// How far the background of a band bends in what an analyser made: errors that lines share bend
/// it, too.
const BEND_OF_GIVEN: usize = 3;

/// A stretch of the lines, rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Band {
    /// Its modes lie from here to there, the end not included.
    own: [f64; 2],
    /// The lines that are fitted.
    seen: [f64; 2],
}

/// The bands of spectra with many modes, ascending, without gaps; one band or none where all lines
/// are fitted together.
pub(super) fn divided(blocks: &[Block], starts: &[Pole]) -> Vec<Band> {
    /// A band sees its neighbours as far as this share of its own width.
    const MARGIN: f64 = 0.15;
    let Some(block) = blocks.iter().max_by_key(|block| block.omega.len()) else {
        return Vec::new();
    };
    let omega = &block.omega;
    if omega.len() < MIN_LINES || starts.len() < MIN_STARTS {
        return Vec::new();
    }
    let (first, last) = (omega[0], omega[omega.len() - 1]);
    let ends = divisions(starts, omega, STARTS, LINES_OF_BAND);
    let band = |pair: &[f64]| {
        let [from, to] = [pair[0].max(first), pair[1].min(last)];
        let margin = MARGIN * (to - from);
        Band { own: [pair[0], pair[1]], seen: [from - margin, to + margin] }
    };
    ends.windows(2).map(band).collect()
}

impl Band {
    pub(super) fn holds(&self, omega: f64) -> bool {
        omega >= self.own[0] && omega < self.own[1]
    }

    /// All that lies so far to either side of a place, rad/s.
    pub(super) fn about(omega: f64, reach: f64) -> Self {
        let both = [omega - reach, omega + reach];
        Self { own: both, seen: both }
    }

    fn lines(&self, block: &Block) -> Range<usize> {
        let at = |limit: f64| block.omega.partition_point(|omega| *omega < limit);
        at(self.seen[0])..at(self.seen[1])
    }

    /// Whether it sees less than this share of the lines of each block.
    pub(super) fn sees_less(&self, share: f64, blocks: &[Block]) -> bool {
        let own = |block: &Block| self.lines(block).len() as f64;
        blocks.iter().all(|block| own(block) < share * block.omega.len() as f64)
    }

    /// The noise of the lines that it sees.
    pub(super) fn cut_noise(&self, blocks: &[Block], noise: &Noise) -> Noise {
        let of = |(block, own): (&Block, &Vec<Vec<f64>>)| {
            let lines = self.lines(block);
            own.iter().map(|own| own[lines.clone()].to_vec()).collect()
        };
        blocks.iter().zip(noise).map(of).collect()
    }

    /// The blocks within the lines that it sees; `None` where one has none there.
    pub(super) fn cut(&self, blocks: &[Block]) -> Option<Vec<Block>> {
        let of = |block: &Block| {
            let lines = self.lines(block);
            let cut = |values: &[f64]| values.get(lines.clone()).unwrap_or(&[]).to_vec();
            Block {
                omega: block.omega[lines.clone()].to_vec(),
                drive: block.drive.get(lines.clone()).unwrap_or(&[]).to_vec(),
                drive_error: cut(&block.drive_error),
                spectra: block.spectra.iter().map(|own| own[lines.clone()].to_vec()).collect(),
                is_cut_out: true,
                bend: if block.is_given() { BEND_OF_GIVEN } else { block.bend },
                loudest: block.spectra.iter().map(|own| strongest(own)).collect(),
                ..block.clone()
            }
        };
        let cut: Vec<Block> = blocks.iter().map(of).collect();
        cut.iter().all(|block| !block.omega.is_empty()).then_some(cut)
    }

    /// The starts among the lines that it sees.
    pub(super) fn seen(&self, starts: &[Pole]) -> Vec<Pole> {
        let is_seen = |pole: &&Pole| (self.seen[0]..=self.seen[1]).contains(&pole.omega());
        starts.iter().filter(is_seen).copied().collect()
    }

    /// The poles that are its own.
    pub(super) fn own(&self, poles: &[Pole]) -> Vec<Pole> {
        poles.iter().filter(|pole| self.holds(pole.omega())).copied().collect()
    }

    /// The nearest poles of other bands, held; a tone's is its own business.
    pub(super) fn held(&self, known: &[Pole]) -> Vec<Pole> {
        const NEAREST: usize = 4;
        let mut others: Vec<Pole> = known
            .iter()
            .filter(|pole| !self.holds(pole.omega()) && pole.is_driven)
            .map(|pole| Pole { is_held: true, ..*pole })
            .collect();
        let apart = |pole: &Pole| {
            let below = self.own[0] - pole.omega();
            below.max(pole.omega() - self.own[1])
        };
        others.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
        others.truncate(NEAREST);
        others
    }
}

/// What the bands found as one: each line's fit is that of the band that it belongs to.
pub(super) fn joined(blocks: &[Block], bands: &[Band], found: Vec<Estimate>) -> Estimate {
    let mut all = Estimate {
        poles: Vec::new(),
        fitted: blocks.iter().map(|block| block.spectra.clone()).collect(),
        noise: blocks
            .iter()
            .map(|block| block.spectra.iter().map(|own| vec![0.0; own.len()]).collect())
            .collect(),
        begins_moving: found.iter().any(|found| found.begins_moving),
    };
    for (band, found) in bands.iter().zip(found) {
        all.poles.extend(found.poles);
        for (at, block) in blocks.iter().enumerate() {
            let Some((fitted, noise)) = found.fitted.get(at).zip(found.noise.get(at)) else {
                continue;
            };
            let from = block.omega.partition_point(|omega| *omega < band.seen[0]);
            for (k, omega) in block.omega.iter().enumerate().skip(from) {
                if !band.holds(*omega) {
                    continue;
                }
                for response in 0..block.spectra.len() {
                    if let Some(value) = fitted[response].get(k - from) {
                        all.fitted[at][response][k] = *value;
                        all.noise[at][response][k] = noise[response][k - from];
                    }
                }
            }
        }
    }
    all.poles.sort_by(|a, b| a.pole.omega().total_cmp(&b.pole.omega()));
    all
}
