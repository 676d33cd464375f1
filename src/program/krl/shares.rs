//! How fast axes move from point to point: $VEL_AXIS and $VEL_EXTAX, axis by axis.

use super::run::Run;
use super::value::Value;
use crate::notes::Code;
use crate::program::Pace;
use crate::units::{percent_from_ratio, ratio_from_percent};

/// Shares of the axes' largest speeds; `None` of an axis of which the program has set none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Shares {
    /// A1 to A6, then E1 to E6.
    axes: [Option<f64>; 12],
}

/// Axes of the arm; external ones follow them.
const ARM: usize = 6;

impl Shares {
    /// The same for every axis: BAS(#VEL_PTP), and what WITH says of one move.
    pub(super) fn of_all(percent: f64) -> Result<Self, String> {
        Ok(Self { axes: [Some(share(percent)?); 12] })
    }

    /// $VEL_AXIS[axis], or of an external one $VEL_EXTAX[axis], counted from 1.
    pub(super) fn set(&mut self, is_external: bool, axis: f64, percent: f64) -> Result<(), String> {
        let place = (1..=ARM).find(|&own| own as f64 == axis);
        let place = place.ok_or_else(|| format!("there is no axis {axis}, must be 1 to {ARM}"))?;
        self.axes[place - 1 + if is_external { ARM } else { 0 }] = Some(share(percent)?);
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

impl Run<'_> {
    pub(super) fn set_joint_share(&mut self, value: &Value) -> Result<(), String> {
        self.shares = Shares::of_all(value.num()?)?;
        Ok(())
    }

    /// Beyond 100 % the basic package takes DEF_VEL_PTP (bas.src, VEL_PTP).
    pub(super) fn set_basic_share(&mut self, line: usize, value: &Value) -> Result<(), String> {
        let percent = value.num()?;
        if percent <= 100.0 {
            return self.set_joint_share(value);
        }
        match self.datum("def_vel_ptp") {
            Value::Unknown(_) => {
                let what = format!(
                    "the joints' speed is {percent} %: the controller takes DEF_VEL_PTP, which is \
                     in no file that is read; 100 % is assumed"
                );
                self.log.warning(Code::ChangeIgnored, line, what);
                self.set_joint_share(&Value::real(100.0))
            }
            own => self.set_joint_share(&own),
        }
    }

    pub(super) fn joint_pace(&mut self, line: usize) -> Pace {
        let external = self.settings.external_axes.keys();
        let common = self.shares.common(external.filter_map(|name| name.get(1..)?.parse().ok()));
        if let (None, Some(why)) = (common, &self.unknown_share) {
            let what = format!("{why}; the joints are taken to move as fast as rapid moves");
            self.log.warning(Code::ChangeIgnored, line, what);
        }
        if let Some((lowest, true)) = common {
            let what = format!(
                "$VEL_AXIS or $VEL_EXTAX differ from axis to axis, or are set for some of them: \
                 all axes are taken to move at {} %",
                percent_from_ratio(lowest)
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
        common.map_or(Pace::Rapid, |(share, _)| Pace::Joints(share * self.over))
    }
}

fn share(percent: f64) -> Result<f64, String> {
    if percent > 0.0 && percent <= 100.0 {
        return Ok(ratio_from_percent(percent));
    }
    Err(format!("the joints' speed is {percent} %, must be 1 to 100"))
}
