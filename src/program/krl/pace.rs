//! What sets how fast axes move from point to point.

use super::run::Run;
use super::shares::Shares;
use super::value::Value;
use crate::notes::Code;
use crate::program::Pace;
use crate::units::percent_from_ratio;

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
