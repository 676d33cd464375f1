//! The arm at many places of a path at once, by the batch kernel.

use nalgebra::Point3;
use rayon::prelude::*;

use super::survey::Detail;
use super::surveyor::{no_modes_at, not_reached_at};
use super::timed_path::{Path, PathReader};
use crate::model::{IkFault, PoseFault};
use crate::modes::batch::{BatchFault, Kernel, TipOut};
use crate::notes::Note;
use crate::progress::{Done, Progress};

/// Looks at a path in batches.
pub(super) struct BatchSurveyor<'p, 'a> {
    path: &'p Path<'a>,
    kernel: Kernel<'a>,
    detail: Detail,
}

impl<'p, 'a> BatchSurveyor<'p, 'a> {
    pub(super) fn new(path: &'p Path<'a>, detail: Detail) -> Self {
        Self { path, kernel: Kernel::new(path.robot()), detail }
    }

    /// Looks at every station of `s` (0..=1), over all cores: frequencies (Hz, ascending) and, if
    /// they are wanted, tip responses (m/N), one value a mode.
    ///
    /// # Errors
    /// The first station, in the order of `s`, at which the arm has no modes.
    pub(super) fn look(
        &self,
        s: &[f64],
        frequencies_hz: &mut [f64],
        tip_m_per_n: &mut [f64],
        progress: Progress,
    ) -> Result<(), Note> {
        let n = self.path.robot().coordinates().len();
        // Four pieces a thread, so that the last one waits little for the others.
        let pieces = 4 * rayon::current_num_threads();
        let chunk = s.len().div_ceil(pieces).clamp(16, 512);
        let mut tips = tip_m_per_n.chunks_mut(chunk * n);
        let pieces: Vec<_> = s
            .chunks(chunk)
            .zip(frequencies_hz.chunks_mut(chunk * n))
            .map(|(s, frequencies)| (s, frequencies, tips.next().unwrap_or_default()))
            .collect();
        let faults: Vec<Option<Note>> = pieces
            .into_par_iter()
            .map_init(
                || Walk::new(self.path),
                |walk, (s, frequencies, tips)| {
                    let outcome = self.look_at_piece(walk, s, frequencies, tips);
                    outcome.map(|()| progress(Done::More(s.len()))).err()
                },
            )
            .collect();
        faults.into_iter().flatten().next().map_or(Ok(()), Err)
    }

    fn look_at_piece(
        &self,
        walk: &mut Walk,
        s: &[f64],
        frequencies: &mut [f64],
        tips: &mut [f64],
    ) -> Result<(), Note> {
        let stopped = walk.along(s);
        let count = walk.tools.last().map_or(0, |tool| tool.end);
        // What is wrong at a pose before the place where the arm gets no farther comes first.
        self.solve(walk, count, frequencies, tips)
            .map_err(|(i, fault)| no_modes_at(self.path, s[i], &fault))?;
        stopped.map_err(|fault| not_reached_at(self.path, s[count], &fault))
    }

    /// Solves the first `count` poses of `walk`; a fault comes with the place of its pose.
    fn solve(
        &self,
        walk: &Walk,
        count: usize,
        frequencies: &mut [f64],
        tips: &mut [f64],
    ) -> Result<(), (usize, PoseFault)> {
        let robot = self.path.robot();
        let (n, joints) = (robot.coordinates().len(), robot.joints().len());
        if self.detail == Detail::Frequencies {
            let poses = &walk.poses[..count * joints];
            let solved = self.kernel.frequencies_hz(poses, &mut frequencies[..count * n]);
            return solved.map_err(|fault| located(fault, 0));
        }
        let mut from = 0;
        for Tool { end, tcp_m } in &walk.tools {
            let out = TipOut {
                natural_frequencies_hz: &mut frequencies[from * n..end * n],
                peak_compliances_m_per_n: &mut tips[from * n..end * n],
            };
            let poses = &walk.poses[from * joints..end * joints];
            self.kernel.tip(poses, tcp_m, out).map_err(|fault| located(fault, from))?;
            from = *end;
        }
        Ok(())
    }
}

/// The pose at fault of a batch that has `before` poses before it.
pub(super) fn located(fault: BatchFault, before: usize) -> (usize, PoseFault) {
    match fault {
        BatchFault::Pose { pose, fault } => (before + pose, fault),
        BatchFault::Poses { given, joints: expected } | BatchFault::Room { given, expected } => {
            (before, PoseFault::Length { given, expected })
        }
    }
}

/// Poses of a piece of the path, in buffers of one thread.
struct Walk<'p, 'a> {
    reader: PathReader<'p, 'a>,
    joints: usize,
    poses: Vec<f64>,
    tools: Vec<Tool>,
}

/// The tool centre point, in the tip frame, of all poses up to `end` that have no earlier one.
struct Tool {
    end: usize,
    tcp_m: Point3<f64>,
}

impl<'p, 'a> Walk<'p, 'a> {
    fn new(path: &'p Path<'a>) -> Self {
        let joints = path.robot().joints().len();
        Self { reader: path.reader(), joints, poses: Vec::new(), tools: Vec::new() }
    }

    /// Fills the buffers with the stations of `s`, up to the first one that the arm does not get
    /// to.
    fn along(&mut self, s: &[f64]) -> Result<(), IkFault> {
        let joints = self.joints;
        self.poses.resize(s.len() * joints, 0.0);
        self.tools.clear();
        for (i, &s) in s.iter().enumerate() {
            let tcp = self.reader.at(s, &mut self.poses[i * joints..][..joints])?;
            let tcp_m = tcp.translation.vector.into();
            match self.tools.last_mut() {
                Some(tool) if tool.tcp_m == tcp_m => tool.end = i + 1,
                _ => self.tools.push(Tool { end: i + 1, tcp_m }),
            }
        }
        Ok(())
    }
}
