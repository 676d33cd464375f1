//! Modes followed along a path by shape, so that a crossing or veering of modes never swaps them silently.

use rayon::prelude::*;

use super::plan::Path;
use super::surveyor::Surveyor;
use crate::modes::{Follow, Modes, Tracker};
use crate::notes::Note;
use nalgebra::DMatrix;

/// A step over which every mode keeps at least this MAC is short enough to follow.
const FAMILIAR_MAC: f64 = 0.9;

/// Modes that turn into each other within less than this share of the path count as crossing: no spindle
/// dwells there.
const SHORTEST_STEP: f64 = 1e-7;

/// Two neighbouring modes closer than this share of their frequency have no shapes of their own.
const REPEATED: f64 = 1e-9;

/// Poses that one thread takes at a time.
const CHUNK: usize = 64;

/// A place where two modes, neighbours in frequency, change places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FamilyExchange {
    /// Where on the path.
    pub s: f64,
    /// Index of the lower one, from 0.
    pub lower_mode: usize,
}

/// Modes of a path's stations and the families that they belong to.
#[derive(Debug, Clone, PartialEq)]
pub struct Families {
    /// Per station and mode (ascending frequency), the index that the mode had at the first station.
    pub of: Vec<Vec<Option<usize>>>,
    /// Where families change places, ascending in s.
    pub exchanges: Vec<FamilyExchange>,
}

/// What modes become from one station to the next: `[r]` is the index at the next station.
type Step = Vec<Option<usize>>;

/// Follows the modes over `stations` (ascending s), looking as closely as needed between them, over all
/// cores.
///
/// # Errors
/// The first pose at which the arm has no modes.
pub fn follow(path: &Path, stations: &[f64]) -> Result<Families, Note> {
    let n = path.robot().coordinates().len();
    let pairs: Vec<(f64, f64)> = stations.windows(2).map(|pair| (pair[0], pair[1])).collect();
    let steps: Vec<(Step, Vec<FamilyExchange>)> = pairs
        .par_chunks(CHUNK)
        .map_init(
            || Follower::new(path),
            |follower, chunk| {
                let mut steps = Vec::with_capacity(chunk.len());
                let mut here = follower.look(chunk[0].0)?;
                for &(_, to) in chunk {
                    let next = follower.look(to)?;
                    let mut exchanges = Vec::new();
                    let step = follower.step(&here, &next, &mut exchanges)?;
                    steps.push((step, exchanges));
                    here = next;
                }
                Ok(steps)
            },
        )
        .collect::<Result<Vec<_>, Note>>()?
        .into_iter()
        .flatten()
        .collect();

    let mut families: Vec<Option<usize>> = (0..n).map(Some).collect();
    let mut of = vec![families.clone()];
    let mut exchanges = Vec::new();
    for (step, found) in steps {
        let mut next = vec![None; n];
        for (r, to) in step.iter().enumerate() {
            if let Some(to) = to {
                next[*to] = families[r];
            }
        }
        of.push(next.clone());
        families = next;
        exchanges.extend(found);
    }
    Ok(Families { of, exchanges })
}

/// A pose with its modes and the mass matrix that they are normalised to.
#[derive(Debug, Clone)]
struct Look {
    s: f64,
    modes: Modes,
    mass: DMatrix<f64>,
    /// Two modes coincide here and beside: their shapes mean nothing, however close one looks.
    blurred: bool,
}

struct Follower<'p, 'a> {
    surveyor: Surveyor<'p, 'a>,
    tracker: Tracker,
}

impl<'p, 'a> Follower<'p, 'a> {
    fn new(path: &'p Path<'a>) -> Self {
        let tracker = Tracker::new(path.robot().coordinates().len());
        Self { surveyor: Surveyor::new(path), tracker }
    }

    /// Looks at `s`, or just beside it where two modes coincide.
    fn look(&mut self, s: f64) -> Result<Look, Note> {
        let beside = if s < 0.5 { SHORTEST_STEP } else { -SHORTEST_STEP };
        let look = self.look_at(s)?;
        if look.blurred { Ok(Look { s, ..self.look_at(s + beside)? }) } else { Ok(look) }
    }

    fn look_at(&mut self, s: f64) -> Result<Look, Note> {
        let modes = self.surveyor.modes(s)?.clone();
        let blurred = modes
            .natural_frequencies_hz
            .windows(2)
            .any(|pair| pair[1] - pair[0] < REPEATED * pair[1]);
        Ok(Look { s, modes, mass: self.surveyor.solver().mass().clone(), blurred })
    }

    fn step(
        &mut self,
        here: &Look,
        next: &Look,
        exchanges: &mut Vec<FamilyExchange>,
    ) -> Result<Step, Note> {
        let follow = self.tracker.follow(&next.mass, &here.modes.shapes, &next.modes.shapes);
        let step: Step = follow
            .iter()
            .map(|follow| match follow {
                Follow::Mode(s) => Some(*s),
                Follow::Lost => None,
            })
            .collect();
        let in_order = step.iter().enumerate().all(|(r, to)| *to == Some(r));
        let familiar = self.tracker.least_mac() > FAMILIAR_MAC;
        if in_order && familiar {
            return Ok(step);
        }
        let middle = 0.5 * (here.s + next.s);
        if next.s - here.s > SHORTEST_STEP && !here.blurred && !next.blurred {
            let between = self.look(middle)?;
            let first = self.step(here, &between, exchanges)?;
            let second = self.step(&between, next, exchanges)?;
            return Ok(first.iter().map(|to| to.and_then(|to| second[to])).collect());
        }
        for (r, to) in step.iter().enumerate() {
            if to.is_some_and(|to| to > r) {
                exchanges.push(FamilyExchange { s: middle, lower_mode: r });
            }
        }
        Ok(step)
    }
}
