//! Frequencies of one robot at many poses, by either method.

use super::{Block, Method, OutsideLimits, shapes};
use crate::free_vibration::{Settings, measure};
use crate::model::{PoseFault, Robot};
use crate::modes::ModalSolver;
use crate::modes::batch::{BatchFault, Kernel};
use crate::notes::{Note, Part};
use crate::progress::{Done, Progress};
use crate::uncertainty::Trust;

/// Finds natural frequencies of one robot at many poses; shared between threads as it is.
#[derive(Debug, Clone)]
pub struct FrequencyMap<'a> {
    robot: &'a Robot,
    kernel: Kernel<'a>,
    method: Method,
    intervals: Option<Trust>,
    shape_links: Option<Vec<String>>,
}

impl<'a> FrequencyMap<'a> {
    /// A map of `robot` with the machine's best instructions.
    pub fn new(robot: &'a Robot, method: Method) -> Self {
        Self { robot, kernel: Kernel::new(robot), method, intervals: None, shape_links: None }
    }

    /// The same with the 95 % interval of every frequency.
    pub fn with_intervals(mut self) -> Self {
        self.intervals = Some(Trust::of(self.robot, None));
        self
    }

    /// Whether it has intervals.
    pub fn has_intervals(&self) -> bool {
        self.intervals.is_some()
    }

    /// The same with the mode shapes of every pose.
    pub fn with_shapes(mut self) -> Self {
        self.shape_links = Some(shapes::links(self.robot));
        self
    }

    /// The links whose rotations the shapes have, if it has shapes.
    pub fn shape_links(&self) -> Option<&[String]> {
        self.shape_links.as_deref()
    }

    /// The robot.
    pub fn robot(&self) -> &'a Robot {
        self.robot
    }

    /// How frequencies are found.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Values of a pose.
    pub fn joints(&self) -> usize {
        self.robot.joints().len()
    }

    /// Frequencies of a pose.
    pub fn modes(&self) -> usize {
        self.robot.coordinates().len()
    }

    /// Finds the frequencies of the poses of `block` on this thread, in place of what it holds.
    /// `progress` is called for each pose of a nonlinear map.
    ///
    /// # Errors
    /// The first pose that has none, with its index in the block as [`Part::Pose`].
    pub fn solve(&self, block: &mut Block, progress: Progress) -> Result<(), Note> {
        block.frequencies_hz.clear();
        block.nonlinear.clear();
        match &self.method {
            Method::Linear => {
                block.frequencies_hz.resize(block.count * self.modes(), 0.0);
                self.kernel
                    .frequencies_hz(&block.poses, &mut block.frequencies_hz)
                    .map_err(located)?;
            }
            Method::Nonlinear(settings) => self.measure(settings, block, progress)?,
        }
        block.intervals_hz.clear();
        if let Some(trust) = &self.intervals {
            self.add_intervals(trust, block)?;
        }
        block.shapes.clear();
        if let Some(links) = &self.shape_links {
            let mut solver = ModalSolver::new(self.robot);
            for (pose, q) in block.poses.chunks_exact(self.joints().max(1)).enumerate() {
                shapes::append(self.robot, links, &mut solver, q, &mut block.shapes)
                    .map_err(|fault| Note::from(fault).within(Part::Pose(pose)))?;
            }
        }
        block.beta2_rad.clear();
        if let Some(beta2) = self.robot.beta2() {
            let poses = block.poses.chunks_exact(self.joints().max(1));
            block.beta2_rad.extend(poses.map(|q| beta2.at(q)));
        }
        Ok(())
    }

    fn add_intervals(&self, trust: &Trust, block: &mut Block) -> Result<(), Note> {
        let (joints, modes) = (self.joints(), self.modes());
        let mut solver = ModalSolver::new(self.robot);
        for pose in 0..block.count {
            let hz = &block.frequencies_hz[pose * modes..(pose + 1) * modes];
            let q = &block.poses[pose * joints..(pose + 1) * joints];
            let half = trust.half_widths(self.robot, &mut solver, q, 0.95);
            let half = half.map_err(|fault| Note::from(fault).within(Part::Pose(pose)))?;
            let ends = hz.iter().zip(half).flat_map(|(hz, half)| half.about(*hz));
            block.intervals_hz.extend(ends);
        }
        Ok(())
    }

    fn measure(
        &self,
        settings: &Settings,
        block: &mut Block,
        progress: Progress,
    ) -> Result<(), Note> {
        let joints = self.joints();
        for pose in 0..block.count {
            let q = &block.poses[pose * joints..(pose + 1) * joints];
            let found =
                measure(self.robot, q, settings).map_err(|note| note.within(Part::Pose(pose)))?;
            let frequencies = found.frequencies_hz.iter().map(|f| f.unwrap_or(f64::NAN));
            block.frequencies_hz.extend(frequencies);
            block.nonlinear.push(found);
            progress(Done::More(1));
        }
        Ok(())
    }

    /// Which poses of `block` lie outside the joint limits.
    pub fn outside_limits(&self, block: &Block) -> OutsideLimits {
        let mut outside = OutsideLimits::default();
        let poses = block.poses.chunks_exact(self.joints().max(1));
        poses.for_each(|q| outside.look_at(self.robot, q));
        outside
    }
}

fn located(fault: BatchFault) -> Note {
    let (pose, fault) = match fault {
        BatchFault::Pose { pose, fault } => (pose, fault),
        BatchFault::Poses { given, joints: expected } | BatchFault::Room { given, expected } => {
            (0, PoseFault::Length { given, expected })
        }
    };
    Note::from(fault).within(Part::Pose(pose))
}
