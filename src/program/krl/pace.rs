//! What sets how fast the tool moves along a path, and axes from point to point.

use super::run::Run;
use super::shares::Shares;
use super::value::{Parts, Value};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::log::States;
use crate::units::{deg_from_rad, percent_from_ratio, ratio_from_percent};

/// No robot of KUKA's has more along a path as it is delivered ($VEL_MA.CP).
const LARGEST_M_PER_S: f64 = 3.0;

impl Run<'_> {
    /// $VEL.CP, m/s.
    pub(super) fn set_velocity(&mut self, line: usize, value: &Value) -> Result<(), String> {
        let velocity = value.num()?;
        if !(velocity > 0.0 && velocity.is_finite()) {
            return Err(format!("the speed is {velocity} m/s, must be positive"));
        }
        self.doubt_velocity(line, velocity);
        let span = match value {
            Value::Num(_, span, _) => *span,
            _ => None,
        };
        self.log.states(line, span, States::Feed { value: velocity });
        (self.velocity, self.unsure_velocity) = (Some(velocity), None);
        Ok(())
    }

    /// Tells of a speed that no robot has, as of one in mm/s.
    pub(super) fn doubt_velocity(&mut self, line: usize, velocity: f64) {
        if velocity > LARGEST_M_PER_S {
            let what = format!(
                "$VEL.CP is {velocity} m/s, and KUKA's robots have up to {LARGEST_M_PER_S} m/s: \
                 the controller stops there or goes slower; write the speed in m/s, not mm/s"
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// BAS(#CP_DAT). Older controllers take the speed, too (bas.src, CP_DAT).
    pub(super) fn velocity_of_data(&mut self, line: usize) -> Result<(), String> {
        let velocity = self.velocity_of_form("ldat_act")?;
        let (before, unsure) = (self.velocity, self.unsure_velocity.take());
        self.set_basic_velocity(line, &velocity)?;
        self.unsure_velocity = match self.velocity == before {
            true => unsure,
            false => Some(unsure_of("#CP_DAT", "LDAT_ACT", "#VEL_CP", line)),
        };
        Ok(())
    }

    /// BAS(#PTP_DAT), likewise (bas.src, PTP_DAT).
    pub(super) fn share_of_data(&mut self, line: usize) -> Result<(), String> {
        let before = self.shares;
        match self.velocity_of_form("pdat_act") {
            Ok(share) => {
                self.set_basic_share(line, &share)?;
                self.shares = self.shares.or(&before);
                let what = unsure_of("#PTP_DAT", "PDAT_ACT", "#VEL_PTP", line);
                self.unknown_share = Some(what);
            }
            // As rapid as where no speed is set, until one is: then nothing was lost.
            Err(why) => {
                self.shares = Shares::default();
                self.unknown_share =
                    Some(format!("{why}; the joints are taken to move as fast as rapid moves"));
            }
        }
        Ok(())
    }

    /// $VEL, as far as the program has set it.
    pub(super) fn speeds(&self) -> Value {
        let unknown =
            |part: &str| Value::unknown(format!("'$VEL{part}' is known only at run time"));
        let Some(velocity) = self.velocity else { return unknown("") };
        if let Some(why) = &self.unsure_velocity {
            return Value::unknown(why.clone());
        }
        let turning = ["ori1", "ori2"].into_iter().zip(self.turning).map(|(name, speed)| {
            let part = format!(".{}", name.to_uppercase());
            let speed = speed.map(|speed| Value::real(deg_from_rad(speed)));
            (name.to_owned(), speed.unwrap_or_else(|| unknown(&part)))
        });
        let mut parts: Parts = turning.collect();
        parts.insert("cp".to_owned(), Value::real(velocity));
        Value::Parts(parts)
    }

    /// SVEL_CP: the speed along the path, and DEF_VEL_ORIS for all turns (bas.src, SVEL_CP), where
    /// a file declares it.
    pub(super) fn speeds_of_spline(&mut self, line: usize, value: &Value) -> Result<Value, String> {
        let mut parts = Parts::from([("cp".to_owned(), self.basic_velocity(line, value)?)]);
        if let turning @ Value::Num(..) = self.datum("def_vel_oris") {
            parts.insert("ori1".to_owned(), turning.clone());
            parts.insert("ori2".to_owned(), turning);
        }
        Ok(Value::Parts(parts))
    }

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

    /// What the basic package makes of the speed along a path, m/s: no more than DEF_VEL_CP, or in
    /// newer ones than $VEL_MA.CP (bas.src, VEL_CP and SVEL_CP).
    pub(super) fn basic_velocity(&mut self, line: usize, value: &Value) -> Result<Value, String> {
        let asked = value.num()?;
        let declared = self.datum("def_vel_cp").num().ok().filter(|limit| *limit > 0.0);
        let limit = declared.unwrap_or(LARGEST_M_PER_S);
        if asked <= limit {
            return Ok(value.clone());
        }
        let why = match declared {
            Some(_) => {
                "above DEF_VEL_CP, which older controllers take for it, while newer ones run up \
                 to $VEL_MA.CP; write a speed up to DEF_VEL_CP"
            }
            None => {
                "and the controller takes DEF_VEL_CP or $VEL_MA.CP, which are in no file that is \
                 read"
            }
        };
        let what = format!("the speed along the path is {asked} m/s, {why}: {limit} m/s is taken");
        self.log.warning(Code::ChangeIgnored, line, what);
        Ok(Value::real(limit))
    }

    /// Of lines and arcs.
    pub(super) fn path_pace(&mut self, line: usize) -> Pace {
        if let Some(why) = &self.unsure_velocity {
            self.log.warning(Code::ChangeIgnored, line, why.clone());
        }
        self.velocity.map_or(Pace::Unstated, |velocity| Pace::Feed(velocity * self.over))
    }

    pub(super) fn joint_pace(&mut self, line: usize) -> Pace {
        let external = self.settings.external_axes.keys();
        let common = self.shares.common(external.filter_map(|name| name.get(1..)?.parse().ok()));
        if let Some(why) = &self.unknown_share
            && (common.is_none() || self.shares.is_unsure())
        {
            self.log.warning(Code::ChangeIgnored, line, why.clone());
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

/// Why a speed that the data of a form have set may be another.
fn unsure_of(command: &str, data: &str, sets: &str, line: usize) -> String {
    format!(
        "BAS({command}) of line {line}: older controllers take the speed from {data}.VEL, which is \
         used here, and newer ones keep the one from before; write BAS({sets},…) behind it"
    )
}
