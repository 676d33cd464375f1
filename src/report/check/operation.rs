//! One operation of a checked job, with where it stands in its files.

use std::path::{Path, PathBuf};

use crate::job::SpindleSpeed;
use crate::report::paths;
use crate::risk::{Crossing, OperationRisk};
use crate::study::check::{AskedOperation, CheckedJob};

/// One operation of a checked job.
#[derive(Debug, Clone, Copy)]
pub(super) struct CheckedOperation<'a> {
    pub(super) job: &'a CheckedJob,
    pub(super) asked: Option<&'a AskedOperation>,
    pub(super) risk: &'a OperationRisk,
}

impl<'a> CheckedOperation<'a> {
    /// The program, as the job names it.
    pub(super) fn program(&self) -> Option<&'a Path> {
        self.asked?.program.as_deref()
    }

    /// The file that the lines of the crossings refer to, seen from where the caller stands.
    pub(super) fn lines_file(&self) -> PathBuf {
        match self.program() {
            Some(program) => paths::beside(&self.job.file, program),
            None => crate::paths::tidied(&self.job.file),
        }
    }

    /// Lowest and highest programmed spindle speed, rev/min.
    pub(super) fn rpm_range(&self) -> [f64; 2] {
        self.asked.map_or([self.risk.spindle_rpm; 2], |asked| asked.speed.range_rpm())
    }

    /// The programmed (s, rev/min) where the speed is scheduled.
    pub(super) fn schedule(&self) -> Option<&'a [(f64, f64)]> {
        match &self.asked?.speed {
            SpindleSpeed::Constant(_) => None,
            SpindleSpeed::Schedule(points) => Some(points),
        }
    }

    /// Share of a mode's strain energy in each coordinate, largest first.
    pub(super) fn moves(&self, crossing: &Crossing) -> Vec<(&'a str, f64)> {
        let names = self.job.risk.coordinates.iter().map(String::as_str);
        let mut moves: Vec<_> = names.zip(crossing.strain_energy_shares.iter().copied()).collect();
        moves.sort_by(|a, b| b.1.total_cmp(&a.1));
        moves
    }
}

/// The operations of a job in order, each with where it stands.
pub(super) fn operations(job: &CheckedJob) -> impl Iterator<Item = CheckedOperation<'_>> {
    job.risk.operations.iter().enumerate().map(|(index, risk)| CheckedOperation {
        job,
        asked: job.asked.get(index),
        risk,
    })
}
