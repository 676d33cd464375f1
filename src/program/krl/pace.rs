//! What sets how fast axes move from point to point.

use super::run::Run;
use super::shares::Shares;
use super::value::Value;
use crate::notes::Code;
use crate::program::Pace;
use crate::units::{percent_from_ratio, ratio_from_percent};

/// No robot of KUKA's has more along a path as it is delivered ($VEL_MA.CP).
const LARGEST_M_PER_S: f64 = 3.0;

impl Run<'_> {
    pub(super) fn set_joint_share(&mut self, value: &Value) -> Result<(), String> {
        self.shares = Shares::of_all(value.num()?)?;
        Ok(())
    }

    pub(super) fn set_basic_share(&mut self, line: usize, value: &Value) -> Result<(), String> {
        let share = self.basic_share(line, value)?;
        self.set_joint_share(&share)
    }

    /// What the basic package makes of the joints' speed, %: a share of DEF_VEL_PTP, and never more
    /// (bas.src, VEL_PTP and SVEL_JOINT).
    pub(super) fn basic_share(&mut self, line: usize, value: &Value) -> Result<Value, String> {
        let percent = value.num()?;
        match self.datum("def_vel_ptp") {
            Value::Unknown(_) if percent <= 100.0 => Ok(Value::real(percent)),
            Value::Unknown(_) => {
                let what = format!(
                    "the joints' speed is {percent} %: the controller takes DEF_VEL_PTP, which is \
                     in no file that is read; 100 % is assumed"
                );
                self.log.warning(Code::ChangeIgnored, line, what);
                Ok(Value::real(100.0))
            }
            own => Ok(Value::real(ratio_from_percent(own.num()? * percent.min(100.0)))),
        }
    }

    /// What the basic package makes of the speed along a path, m/s: no more than DEF_VEL_CP
    /// (bas.src, VEL_CP and SVEL_CP).
    pub(super) fn basic_velocity(&mut self, line: usize, value: &Value) -> Result<Value, String> {
        let asked = value.num()?;
        let limit = self.datum("def_vel_cp").num().ok().filter(|limit| *limit > 0.0);
        if limit.is_none() && asked > LARGEST_M_PER_S {
            let what = format!(
                "the speed along the path is {asked} m/s: the controller takes DEF_VEL_CP, which \
                 is in no file that is read; {LARGEST_M_PER_S} m/s is assumed"
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
        let limit = limit.unwrap_or(LARGEST_M_PER_S);
        Ok(if asked > limit { Value::real(limit) } else { value.clone() })
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
