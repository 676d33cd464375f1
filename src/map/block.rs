//! Some poses of a map with their frequencies.

use super::shapes::{self, ModeShape};
use crate::free_vibration::Measurement;

/// Poses with their frequencies, as plain numbers, pose after pose. Its room can be used again.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// How many poses.
    pub count: usize,
    /// Joint positions, rad or m, base to tip.
    pub poses: Vec<f64>,
    /// β2 of the two-link model, rad, one a pose; empty where the robot does not define it.
    pub beta2_rad: Vec<f64>,
    /// Frequencies, Hz, ascending, one a mode; NaN where a nonlinear record does not show the mode.
    pub frequencies_hz: Vec<f64>,
    /// Ends of the 95 % intervals of the frequencies, Hz, lower and upper, one pair a mode; empty
    /// where nobody asked.
    pub intervals_hz: Vec<f64>,
    /// Mode shapes, as [`Row::mode_shapes`] reads them; empty where nobody asked.
    pub shapes: Vec<f64>,
    /// What else a nonlinear method found, one a pose; empty for a linear map.
    pub nonlinear: Vec<Measurement>,
}

/// One pose of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<'a> {
    /// Joint positions, rad or m, base to tip.
    pub joints: &'a [f64],
    /// β2, rad; empty where the robot does not define it.
    pub beta2_rad: &'a [f64],
    /// As [`Block::frequencies_hz`].
    pub frequencies_hz: &'a [f64],
    /// As [`Block::intervals_hz`].
    pub intervals_hz: &'a [f64],
    shapes: &'a [f64],
    /// What else a nonlinear method found.
    pub nonlinear: Option<&'a Measurement>,
}

impl<'a> Row<'a> {
    /// The shapes of its modes in ascending order; none where nobody asked.
    pub fn mode_shapes(&self) -> impl Iterator<Item = ModeShape<'a>> {
        shapes::read(self.shapes, self.frequencies_hz.len())
    }
}

impl Block {
    /// The poses one by one.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        let (joints, beta2, frequencies, intervals, shapes) = (
            part(&self.poses, self.count),
            part(&self.beta2_rad, self.count),
            part(&self.frequencies_hz, self.count),
            part(&self.intervals_hz, self.count),
            part(&self.shapes, self.count),
        );
        (0..self.count).map(move |pose| Row {
            joints: joints(pose),
            beta2_rad: beta2(pose),
            frequencies_hz: frequencies(pose),
            intervals_hz: intervals(pose),
            shapes: shapes(pose),
            nonlinear: self.nonlinear.get(pose),
        })
    }

    /// Takes the poses of `later` behind its own.
    pub fn append(&mut self, later: &mut Self) {
        self.count += std::mem::take(&mut later.count);
        self.poses.append(&mut later.poses);
        self.beta2_rad.append(&mut later.beta2_rad);
        self.frequencies_hz.append(&mut later.frequencies_hz);
        self.intervals_hz.append(&mut later.intervals_hz);
        self.shapes.append(&mut later.shapes);
        self.nonlinear.append(&mut later.nonlinear);
    }
}

/// The values of each of `count` poses.
fn part<'a>(values: &'a [f64], count: usize) -> impl Fn(usize) -> &'a [f64] {
    let width = values.len() / count.max(1);
    move |pose| &values[pose * width..(pose + 1) * width]
}
