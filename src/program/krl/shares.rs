//! How fast axes move from point to point: $VEL_AXIS and $VEL_EXTAX, axis by axis.

use crate::units::ratio_from_percent;

/// Shares of the axes' largest speeds; `None` of an axis of which the program has set none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Shares {
    /// A1 to A6, then E1 to E6.
    axes: [Option<f64>; 12],
    /// Those that only some controllers have so.
    are_unsure: [bool; 12],
}

/// Axes of the arm; external ones follow them.
const ARM: usize = 6;

impl Shares {
    /// The same for every axis: BAS(#VEL_PTP), and what WITH says of one move.
    pub(super) fn of_all(percent: f64) -> Result<Self, String> {
        Ok(Self { axes: [Some(share(percent)?); 12], are_unsure: [false; 12] })
    }

    /// The same, where other controllers keep what was set `before`.
    pub(super) fn or(self, before: &Self) -> Self {
        let mut own = self;
        for (at, is_unsure) in own.are_unsure.iter_mut().enumerate() {
            *is_unsure = before.are_unsure[at] || before.axes[at] != self.axes[at];
        }
        own
    }

    /// Whether other controllers have another share of any axis of the arm.
    pub(super) fn is_unsure(&self) -> bool {
        self.are_unsure[..ARM].contains(&true)
    }

    /// $VEL_AXIS[axis], or of an external one $VEL_EXTAX[axis], counted from 1.
    pub(super) fn set(&mut self, is_external: bool, axis: f64, percent: f64) -> Result<(), String> {
        let place = (1..=ARM).find(|&own| own as f64 == axis);
        let place = place.ok_or_else(|| format!("there is no axis {axis}, must be 1 to {ARM}"))?;
        let at = place - 1 + if is_external { ARM } else { 0 };
        (self.axes[at], self.are_unsure[at]) = (Some(share(percent)?), false);
        Ok(())
    }

    /// The share of every axis of the arm and of the `external` ones, counted from 1; where they
    /// differ, the lowest, and that they do.
    pub(super) fn common(&self, external: impl Iterator<Item = usize>) -> Option<(f64, bool)> {
        let external = external.filter_map(|axis| self.axes.get(ARM + axis.checked_sub(1)?));
        let counted: Vec<Option<f64>> = self.axes[..ARM].iter().chain(external).copied().collect();
        let lowest = counted.iter().flatten().copied().reduce(f64::min)?;
        Some((lowest, counted.iter().any(|own| *own != Some(lowest))))
    }
}

fn share(percent: f64) -> Result<f64, String> {
    if percent > 0.0 && percent <= 100.0 {
        return Ok(ratio_from_percent(percent));
    }
    Err(format!("the joints' speed is {percent} %, must be 1 to 100"))
}
