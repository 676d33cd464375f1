//! Modes followed along a path by shape, so that a crossing or veering of modes never swaps them
//! silently.

use rayon::prelude::*;

use super::surveyor::Surveyor;
use super::timed_path::Path;
use crate::modes::{Follow, Modes, Tracker};
use crate::notes::Note;
use nalgebra::DMatrix;

/// A step over which every mode keeps at least this MAC is short enough to follow.
const MIN_MAC: f64 = 0.9;

/// Modes that turn into each other within less than this share of the path count as crossing: no
/// spindle dwells there.
const MIN_STEP: f64 = 1e-7;

/// Two neighbouring modes closer than this share of their frequency have no shapes of their own.
const REPEATED: f64 = 1e-9;

/// A place where two modes, neighbours in frequency, change places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeExchange {
    /// Where on the path.
    pub s: f64,
    /// Index of the lower one, from 0.
    pub lower_mode: usize,
}

/// Modes of a path's stations and the families that they belong to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Families {
    /// Per station and mode (ascending frequency), the index that the mode had at the first
    /// station.
    pub of: Vec<Vec<Option<usize>>>,
    /// Where families change places, ascending in s.
    pub exchanges: Vec<ModeExchange>,
    /// Per station, what the arm is like there.
    pub poses: Vec<ModalPose>,
}

/// The arm at one station.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalPose {
    /// Joint positions, rad or m.
    pub joints: Vec<f64>,
    /// Ascending, Hz.
    pub natural_frequencies_hz: Vec<f64>,
    /// Per mode, what it alone moves the tool tip at resonance, m/N.
    pub tip_response_m_per_n: Vec<f64>,
}

/// What modes become from one station to the next: `[r]` is the index at the next station.
type Step = Vec<Option<usize>>;

/// Follows the modes over `stations` (ascending s), looking as closely as needed between them, over
/// all cores.
///
/// # Errors
/// A pose at which the arm has no modes.
pub fn follow(path: &Path, stations: &[f64]) -> Result<Families, Note> {
    let (looks, poses): (Vec<Look>, Vec<ModalPose>) = stations
        .par_iter()
        .with_min_len(64)
        .map_init(|| Follower::new(path), |follower, &s| follower.station(s))
        .collect::<Result<Vec<_>, Note>>()?
        .into_iter()
        .unzip();
    let steps: Vec<(Step, Vec<ModeExchange>)> = looks
        .par_windows(2)
        .with_min_len(64)
        .map_init(
            || Follower::new(path),
            |follower, pair| {
                let mut exchanges = Vec::new();
                let step = follower.step(&pair[0], &pair[1], &mut exchanges)?;
                Ok((step, exchanges))
            },
        )
        .collect::<Result<_, Note>>()?;

    let n = path.robot().coordinates().len();
    let mut here: Vec<Option<usize>> = (0..n).map(Some).collect();
    let mut of: Vec<_> = poses.first().map(|_| here.clone()).into_iter().collect();
    let mut exchanges = Vec::new();
    for (step, found) in steps {
        let mut next = vec![None; n];
        for (r, to) in step.iter().enumerate() {
            if let Some(to) = to {
                next[*to] = here[r];
            }
        }
        of.push(next.clone());
        exchanges.extend(found);
        here = next;
    }
    Ok(Families { of, exchanges, poses })
}

/// A pose with its modes and the mass matrix that they are normalised to.
#[derive(Debug, Clone)]
struct Look {
    s: f64,
    modes: Modes,
    mass: DMatrix<f64>,
    /// Two frequencies coincide here and beside: their shapes are arbitrary, however close one
    /// looks.
    repeated: bool,
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

    /// A station: its shapes to follow, and what the arm is like there.
    fn station(&mut self, s: f64) -> Result<(Look, ModalPose), Note> {
        let look = self.look_at(s)?;
        let pose = ModalPose {
            joints: self.surveyor.joints().to_vec(),
            natural_frequencies_hz: look.modes.natural_frequencies_hz.clone(),
            tip_response_m_per_n: self.surveyor.tip_response_m_per_n().to_vec(),
        };
        Ok((self.distinct(look)?, pose))
    }

    /// A place between stations.
    fn look(&mut self, s: f64) -> Result<Look, Note> {
        let look = self.look_at(s)?;
        self.distinct(look)
    }

    /// The same, or just beside it where two frequencies coincide.
    fn distinct(&mut self, look: Look) -> Result<Look, Note> {
        let s = look.s;
        let beside = if s < 0.5 { MIN_STEP } else { -MIN_STEP };
        if look.repeated { Ok(Look { s, ..self.look_at(s + beside)? }) } else { Ok(look) }
    }

    fn look_at(&mut self, s: f64) -> Result<Look, Note> {
        let modes = self.surveyor.modes(s)?.clone();
        let repeated = modes
            .natural_frequencies_hz
            .windows(2)
            .any(|pair| pair[1] - pair[0] < REPEATED * pair[1]);
        Ok(Look { s, modes, mass: self.surveyor.solver().mass().clone(), repeated })
    }

    fn step(
        &mut self,
        here: &Look,
        next: &Look,
        exchanges: &mut Vec<ModeExchange>,
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
        let similar = self.tracker.least_mac() > MIN_MAC;
        if in_order && similar {
            return Ok(step);
        }
        let middle = 0.5 * (here.s + next.s);
        if next.s - here.s > MIN_STEP && !here.repeated && !next.repeated {
            let between = self.look(middle)?;
            let first = self.step(here, &between, exchanges)?;
            let second = self.step(&between, next, exchanges)?;
            return Ok(first.iter().map(|to| to.and_then(|to| second[to])).collect());
        }
        for (r, to) in step.iter().enumerate() {
            if to.is_some_and(|to| to > r) {
                exchanges.push(ModeExchange { s: middle, lower_mode: r });
            }
        }
        Ok(step)
    }
}
