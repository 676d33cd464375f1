//! Linear maps of any length: while the pool solves one batch of poses, this thread writes the batch before
//! and reads the batch after it. Two batches are all that is ever held.

use std::io::Write;

use indicatif::ProgressBar;
use rayon::prelude::*;

use super::progress::progress;
use super::source::{Decoder, Raw, Source, usage};
use crate::cli::Failure;
use crate::input::DecodedPoses;
use crate::map::{Block, LinearMap, MapFault, OutsideLimits, Reduction};
use crate::notes::Note;

/// Pieces of a batch: fixed, so that what is written and what is told does not depend on the machine.
const PIECES: usize = 32;

/// Faults that are told in one go.
const MOST_TOLD: usize = 20;

/// Writes the poses of a block.
pub(super) type Render<'a> = &'a (dyn Fn(&Block, &mut Vec<u8>) -> Result<(), String> + Sync);

/// What becomes of the frequencies.
pub(super) enum Aim<'a> {
    /// All are written, in order, without the first `skip` bytes.
    Write { render: Render<'a>, skip: usize, out: &'a mut dyn Write },
    /// Their figures are gathered.
    Reduce(&'a mut Reduction),
}

/// What went by.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Passed {
    pub(super) poses: usize,
    pub(super) outside_limits: OutsideLimits,
}

/// Some poses on their way; its room is used again and again.
#[derive(Default)]
struct Piece {
    raw: Raw,
    decoded: DecodedPoses,
    beta2_rad: Vec<f64>,
    frequencies_hz: Vec<f64>,
    outside_limits: OutsideLimits,
    fault: Option<MapFault>,
    text: Vec<u8>,
    internal: Option<String>,
}

impl Piece {
    fn block(&self) -> Block<'_> {
        Block {
            count: self.decoded.count,
            poses: &self.decoded.values,
            beta2_rad: &self.beta2_rad,
            frequencies_hz: &self.frequencies_hz,
        }
    }

    fn solve(&mut self, decoder: &Decoder, map: &LinearMap) {
        decoder.decode(&self.raw, &mut self.decoded);
        let (count, poses) = (self.decoded.count, &self.decoded.values);
        self.fault = map.solve(count, poses, &mut self.frequencies_hz).err();
        map.beta2(poses, &mut self.beta2_rad);
        self.outside_limits = map.outside_limits(poses);
    }

    fn render(&mut self, render: Render) {
        let mut text = std::mem::take(&mut self.text);
        text.clear();
        self.internal = match self.fault {
            None => render(&self.block(), &mut text).err(),
            Some(_) => None,
        };
        self.text = text;
    }
}

/// Pieces that are solved together; the first `used` of them hold something.
struct Batch {
    pieces: Vec<Piece>,
    used: usize,
}

impl Batch {
    fn new() -> Self {
        Self { pieces: std::iter::repeat_with(Piece::default).take(PIECES).collect(), used: 0 }
    }

    fn fill(&mut self, source: &mut Source) -> Result<(), Note> {
        self.used = 0;
        for piece in &mut self.pieces {
            if !source.read(&mut piece.raw)? {
                break;
            }
            self.used += 1;
        }
        Ok(())
    }
}

/// Sends all poses of `source` through `map` towards `aim`.
pub(super) fn run(mut source: Source, map: &LinearMap, aim: Aim) -> Result<Passed, Failure> {
    let decoder = source.decoder();
    let (render, mut reduction, out, skip) = match aim {
        Aim::Write { render, skip, out } => (Some(render), None, Some(out), skip),
        Aim::Reduce(reduction) => (None, Some(reduction), None, 0),
    };
    let progress = progress(source.count());
    let passed = Passed::default();
    let mut book = Book { decoder: decoder.clone(), out, skip, place: 0, passed, progress };
    let (mut solved, mut next) = (Batch::new(), Batch::new());
    next.fill(&mut source).map_err(|fault| vec![fault])?;
    while next.used > 0 {
        let mut beside: Result<Result<(), Note>, Failure> = Ok(Ok(()));
        rayon::in_place_scope(|scope| {
            let pieces = &mut next.pieces[..next.used];
            let (decoder, reduction) = (&decoder, reduction.as_deref_mut());
            scope.spawn(move |_| {
                pieces.par_iter_mut().for_each(|piece| {
                    piece.solve(decoder, map);
                    if let Some(render) = render {
                        piece.render(render);
                    }
                });
                let is_whole = pieces.iter().all(|piece| piece.fault.is_none());
                if let Some(reduction) = reduction.filter(|_| is_whole) {
                    let blocks: Vec<Block> = pieces.iter().map(Piece::block).collect();
                    reduction.add(&blocks);
                }
            });
            beside = book.enter(&solved).map(|()| solved.fill(&mut source));
        });
        std::mem::swap(&mut solved, &mut next);
        if let Err(fault) = beside? {
            // What is wrong before the end of what could be read comes first.
            book.enter(&solved)?;
            return Err(vec![fault].into());
        }
    }
    book.enter(&solved)?;
    book.progress.finish_and_clear();
    Ok(book.passed)
}

/// What was solved is written and told here, in order.
struct Book<'a> {
    decoder: Decoder,
    out: Option<&'a mut dyn Write>,
    skip: usize,
    /// Places (lines, rows, poses) that went by.
    place: usize,
    passed: Passed,
    progress: ProgressBar,
}

impl Book<'_> {
    fn enter(&mut self, batch: &Batch) -> Result<(), Failure> {
        let (progress, before) = (self.progress.clone(), self.passed.poses);
        // Both may stand on one terminal.
        progress.suspend(|| self.write(batch))?;
        progress.inc((self.passed.poses - before) as u64);
        Ok(())
    }

    fn write(&mut self, batch: &Batch) -> Result<(), Failure> {
        let mut faults = Vec::new();
        for piece in &batch.pieces[..batch.used] {
            if let Some(what) = &piece.internal {
                return Err(Failure::Internal(what.clone()));
            }
            let decoded = &piece.decoded;
            let mut tell = |place: usize, what: &str| {
                faults.push(self.decoder.fault(self.place + place, what));
            };
            decoded.faults.iter().for_each(|(place, what)| tell(*place, what));
            if let Some(bad) = &piece.fault {
                let place = decoded.place_of(bad.index);
                // A number that is none was told by whoever read it.
                if !decoded.faults.iter().any(|(told, _)| *told == place) {
                    tell(place, &bad.fault.to_string());
                }
            }
            if faults.len() >= MOST_TOLD {
                faults.push(usage(format!("reading stopped after {MOST_TOLD} faults or more")));
                break;
            }
            if faults.is_empty() {
                if let Some(out) = &mut self.out {
                    let skipped = self.skip.min(piece.text.len());
                    self.skip -= skipped;
                    out.write_all(&piece.text[skipped..])?;
                }
                self.passed.poses += decoded.count;
                self.passed.outside_limits.add(piece.outside_limits);
            }
            self.place += decoded.places;
        }
        if !faults.is_empty() {
            return Err(faults.into());
        }
        if let Some(out) = &mut self.out {
            out.flush()?;
        }
        Ok(())
    }
}
