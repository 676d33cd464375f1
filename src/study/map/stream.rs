//! Maps of any length: while the pool solves one batch of poses, this thread passes on the batch
//! before it and reads the batch after it. Two batches are all that is ever held.

use std::io;

use rayon::prelude::*;

use super::Summary;
use super::source::{Decoder, Raw, Source};
use crate::input::DecodedPoses;
use crate::map::{Block, FrequencyMap, Method, OutsideLimits, Reduction};
use crate::notes::{Code, Note, Part, Place};
use crate::progress::{Done, Progress};

/// Poses of a linear map that are solved in one go; parts of a map are whole pieces, so that each
/// pose is solved beside the same others.
pub(super) const PIECE_POSES: usize = 1024;

/// Errors that are reported in one go.
const MAX_ERRORS: usize = 20;

/// Renders the poses of a block behind what the buffer holds; called from any thread.
pub type Render<'a> = &'a (dyn Fn(&Block, &mut Vec<u8>) -> io::Result<()> + Sync);

/// What becomes of the blocks.
pub enum Target<'a> {
    /// Each is rendered on any thread; the bytes come in order, several blocks at a time.
    Bytes {
        /// Renders a block.
        render: Render<'a>,
        /// Takes the bytes of some blocks.
        take: &'a mut dyn FnMut(&[&[u8]]) -> io::Result<()>,
    },
    /// Their statistics are gathered; for linear maps.
    Statistics(&'a mut Reduction),
    /// They are kept together, for a drawing.
    Kept {
        /// Where.
        block: &'a mut Block,
        /// More poses are an error.
        max_poses: usize,
    },
}

/// Why a map ended early.
#[derive(Debug)]
pub enum MapError {
    /// Poses that cannot be read or that have no frequencies, at their places.
    Input(Vec<Note>),
    /// The bytes could not be rendered or were not taken.
    Output(io::Error),
}

impl From<io::Error> for MapError {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Sends all poses of `source` through `map` to `target`.
///
/// # Errors
/// See [`MapError`]; what came before the first error has been passed on.
pub fn run(
    mut source: Source,
    map: &FrequencyMap,
    target: Target,
    progress: Progress,
) -> Result<Summary, MapError> {
    let decoder = source.decoder();
    let (render, mut reduction, target) = match target {
        Target::Bytes { render, take } => (Some(render), None, Onward::Bytes(take)),
        Target::Statistics(reduction) => (None, Some(reduction), Onward::Nowhere),
        Target::Kept { block, max_poses } => (None, None, Onward::Kept(block, max_poses)),
    };
    let is_linear = map.method() == Method::Linear;
    let mut ledger = Ledger {
        decoder: &decoder,
        target,
        places: source.first(),
        summary: Summary::default(),
        // A nonlinear map reports each pose by itself.
        progress: if is_linear { progress } else { &crate::progress::silent },
    };
    let (mut solved, mut next) = (Batch::new(map), Batch::new(map));
    next.fill(&mut source).map_err(|error| MapError::Input(vec![error]))?;
    while next.used > 0 {
        let mut beside: Result<Result<(), Note>, MapError> = Ok(Ok(()));
        rayon::in_place_scope(|scope| {
            let pieces = &mut next.pieces[..next.used];
            let (decoder, reduction) = (&decoder, reduction.as_deref_mut());
            scope.spawn(move |_| {
                pieces.par_iter_mut().for_each(|piece| {
                    piece.solve(decoder, map, progress);
                    if let Some(render) = render {
                        piece.render(render);
                    }
                });
                let is_whole = pieces.iter().all(|piece| piece.error.is_none());
                if let Some(reduction) = reduction.filter(|_| is_whole) {
                    let blocks: Vec<&Block> = pieces.iter().map(|piece| &piece.block).collect();
                    reduction.add(&blocks);
                }
            });
            beside = ledger.enter(&mut solved).map(|()| solved.fill(&mut source));
        });
        std::mem::swap(&mut solved, &mut next);
        if let Err(error) = beside? {
            // What is wrong before the end of what could be read comes first.
            ledger.enter(&mut solved)?;
            return Err(MapError::Input(vec![error]));
        }
    }
    ledger.enter(&mut solved)?;
    Ok(ledger.summary)
}

/// Some poses on their way; its room is used again and again.
#[derive(Default)]
struct Piece {
    raw: Raw,
    decoded: DecodedPoses,
    block: Block,
    outside_limits: OutsideLimits,
    /// The first pose without frequencies, by its index in the block.
    error: Option<Note>,
    bytes: Vec<u8>,
    unrendered: Option<io::Error>,
}

impl Piece {
    fn solve(&mut self, decoder: &Decoder, map: &FrequencyMap, progress: Progress) {
        decoder.decode(&self.raw, &mut self.decoded);
        self.block.count = self.decoded.count;
        std::mem::swap(&mut self.block.poses, &mut self.decoded.values);
        self.error = map.solve(&mut self.block, progress).err();
        self.outside_limits = map.outside_limits(&self.block);
    }

    fn render(&mut self, render: Render) {
        self.bytes.clear();
        self.unrendered = match self.error {
            None => render(&self.block, &mut self.bytes).err(),
            Some(_) => None,
        };
    }

    /// What is wrong with it, where `before` places precede it.
    fn errors(&self, decoder: &Decoder, before: usize) -> Vec<Note> {
        let decoded = &self.decoded;
        let at = |place: usize, code, what: &str| {
            decoder.locate(before + place, &Note::error(code, Place::default(), what))
        };
        let mut errors: Vec<Note> =
            decoded.faults.iter().map(|(place, what)| at(*place, Code::Value, what)).collect();
        if let Some(error) = &self.error {
            let pose = match error.place.part {
                Some(Part::Pose(pose)) => pose,
                _ => 0,
            };
            let place = decoded.place_of(pose);
            // A value that is not a number was reported by whoever read it.
            if !decoded.faults.iter().any(|(known, _)| *known == place) {
                errors.push(at(place, error.code, &error.what));
            }
        }
        errors
    }
}

/// Pieces that are solved together; the first `used` of them hold something.
struct Batch {
    pieces: Vec<Piece>,
    used: usize,
    piece_poses: usize,
}

impl Batch {
    /// Sizes are fixed, so that what is written and reported does not depend on the machine. A pose
    /// of a nonlinear map takes long and holds spectra.
    fn new(map: &FrequencyMap) -> Self {
        let (pieces, piece_poses) = match map.method() {
            Method::Linear => (32, PIECE_POSES),
            Method::Nonlinear(_) => (64, 1),
        };
        let pieces = std::iter::repeat_with(Piece::default).take(pieces).collect();
        Self { pieces, used: 0, piece_poses }
    }

    fn fill(&mut self, source: &mut Source) -> Result<(), Note> {
        self.used = 0;
        for piece in &mut self.pieces {
            if !source.read(self.piece_poses, &mut piece.raw)? {
                break;
            }
            self.used += 1;
        }
        Ok(())
    }
}

/// Where solved pieces go from this thread.
enum Onward<'a> {
    Bytes(&'a mut dyn FnMut(&[&[u8]]) -> io::Result<()>),
    Kept(&'a mut Block, usize),
    Nowhere,
}

/// Passes on what was solved, in order, and counts it.
struct Ledger<'a> {
    decoder: &'a Decoder,
    target: Onward<'a>,
    /// Places (lines, rows, poses) that went by.
    places: usize,
    summary: Summary,
    progress: Progress<'a>,
}

impl Ledger<'_> {
    fn enter(&mut self, batch: &mut Batch) -> Result<(), MapError> {
        let pieces = &mut batch.pieces[..batch.used];
        let (mut errors, mut whole, before) = (Vec::new(), 0, self.summary.poses);
        for piece in pieces.iter_mut() {
            if let Some(error) = piece.unrendered.take() {
                return Err(error.into());
            }
            errors.extend(piece.errors(self.decoder, self.places));
            if errors.len() >= MAX_ERRORS {
                let what = format!("reading stopped after {MAX_ERRORS} errors or more");
                errors.push(Note::error(Code::More, Place::default(), what));
                break;
            }
            if errors.is_empty() {
                whole += 1;
                self.summary.add(&piece.block, piece.outside_limits);
            }
            self.places += piece.decoded.places;
        }
        self.pass_on(&mut pieces[..whole])?;
        (self.progress)(Done::More(self.summary.poses - before));
        if errors.is_empty() { Ok(()) } else { Err(MapError::Input(errors)) }
    }

    fn pass_on(&mut self, pieces: &mut [Piece]) -> Result<(), MapError> {
        match &mut self.target {
            Onward::Bytes(take) if !pieces.is_empty() => {
                let bytes: Vec<&[u8]> = pieces.iter().map(|piece| &piece.bytes[..]).collect();
                take(&bytes)?;
            }
            Onward::Kept(block, max_poses) => {
                pieces.iter_mut().for_each(|piece| block.append(&mut piece.block));
                if block.count > *max_poses {
                    let what = format!(
                        "more than {max_poses} poses are too many to draw; write a table, or \
                         reduce the map to its statistics"
                    );
                    let error = Note::error(Code::TooLong, Place::default(), what);
                    return Err(MapError::Input(vec![error]));
                }
            }
            Onward::Bytes(_) | Onward::Nowhere => {}
        }
        Ok(())
    }
}
