//! The speeds and times of TP motions.

use super::run::Run;
use super::text::Statement;
use crate::notes::Code;
use crate::program::Pace;
use crate::program::log::States;
use crate::units::{
    m_per_s_from_mm_per_min, m_per_s_from_mm_per_s, mm_from_inch, rad_from_deg, ratio_from_percent,
    s_from_ms,
};

/// Turns below this are rounding, rad.
pub(super) const NO_TURN_RAD: f64 = 1e-5;

/// Ways below this are rounding, m.
const NO_WAY_M: f64 = 1e-9;

/// Shares of a speed below this are rounding.
const ROUNDING: f64 = 1e-9;

impl Run<'_> {
    /// `100mm/sec`, `R[5]%`, `2.5sec`, `WELD_SPEED`; how far the tool turns on the way, rad, and
    /// goes, m, where that is known.
    pub(super) fn pace(
        &mut self,
        statement: &Statement,
        term: &str,
        kind: &str,
        ways: Option<[f64; 2]>,
    ) -> Result<Pace, String> {
        let over = self.over.clone()?;
        if term.eq_ignore_ascii_case("max_speed") {
            return Ok(Pace::Rapid);
        }
        let (number, unit) = speed(term)?;
        if unit == "%" && kind != "J" {
            return Err(format!(
                "speed is {term}: % is a share of joint speed, which J alone takes; {kind} takes \
                 mm/sec, cm/min, inch/min, deg/sec, sec or msec"
            ));
        }
        let value = match self.registers.value(number) {
            Ok(value) => value,
            Err(why) if kind != "J" => {
                let of = if unit.is_empty() { ", in mm/sec" } else { "" };
                return self.unknown_speed(self.line_of(statement), &format!("{why}{of}"));
            }
            Err(_) => return Ok(Pace::Rapid),
        };
        if !(value > 0.0 && value.is_finite()) {
            return Err(format!("speed is {term}, must be positive"));
        }
        let at = number.as_ptr() as usize - statement.text.as_ptr() as usize;
        let span = number.parse::<f64>().ok().and_then(|_| statement.span(at, at + number.len()));
        let span = span.or_else(|| self.registers.place(number));
        let feed = match unit {
            // A speed by name is in mm/sec.
            "mm/sec" | "" => m_per_s_from_mm_per_s(value),
            "cm/min" => m_per_s_from_mm_per_min(value * 10.0),
            "inch/min" => m_per_s_from_mm_per_min(mm_from_inch(value)),
            "deg/sec" => {
                // The way to the first position takes no time.
                if !self.log.has_moved() {
                    return Ok(Pace::Rapid);
                }
                let [angle, way] =
                    ways.ok_or("deg/sec, and how far the tool turns is not known")?;
                if angle < NO_TURN_RAD && kind == "L" && way < NO_WAY_M {
                    return Ok(Pace::Rapid);
                }
                if angle < NO_TURN_RAD {
                    return Err(
                        "deg/sec on a move on which the tool does not turn says no speed; \
                                write mm/sec there"
                            .to_owned(),
                    );
                }
                return Ok(Pace::Seconds(angle / rad_from_deg(value) / over));
            }
            "msec" | "sec" => {
                self.log.states(self.line_of(statement), span, States::Seconds { value });
                let seconds = if unit == "sec" { value } else { s_from_ms(value) };
                return Ok(Pace::Seconds(seconds / over));
            }
            _ if value > 100.0 => return Err(format!("speed is {term}, must be up to 100 %")),
            _ => return Ok(Pace::Joints(ratio_from_percent(value) * over)),
        };
        self.log.states(self.line_of(statement), span, States::Feed { value });
        Ok(Pace::Feed(feed * over))
    }

    /// LINEAR_MAX_SPEED changes nothing where no move is faster. What JOINT_MAX_SPEED slows is not
    /// known.
    pub(super) fn compare_limits(&mut self, line: usize, kind: &str, pace: Pace) {
        let is_first = !self.log.has_moved();
        let mut may_slow = |what: &str, set: usize| {
            let what = format!(
                "{what} of line {set} may slow this move, which is read at the speed that it states"
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        };
        if let Some(set) = self.joint_limit.filter(|_| !is_first) {
            may_slow("JOINT_MAX_SPEED", set);
        }
        let Some((set, limit)) = self.limit.filter(|_| kind != "J") else { return };
        let feed = match pace {
            Pace::Feed(feed) => Some(feed),
            Pace::Unstated => self.settings.feed_m_per_s,
            Pace::Rapid => Some(self.settings.rapid_m_per_s),
            // How long the way is tells the log alone.
            Pace::Seconds(_) | Pace::Joints(_) => None,
        };
        let is_below = limit
            .zip(feed)
            .is_some_and(|(limit, feed)| feed <= m_per_s_from_mm_per_s(limit) * (1.0 + ROUNDING));
        if !is_below {
            may_slow("LINEAR_MAX_SPEED", set);
        }
    }

    /// The job's feed stands in for a speed that is not known. The first move needs none.
    fn unknown_speed(&mut self, line: usize, why: &str) -> Result<Pace, String> {
        if self.settings.feed_m_per_s.is_none() && self.log.has_moved() {
            return Err(format!(
                "speed: {why}; feed_mm_per_min in the job's operation stands in for it"
            ));
        }
        let what = format!("speed: {why}; the job's feed is used");
        self.log.warning(Code::Assumed, line, what);
        Ok(Pace::Unstated)
    }
}

/// The number of a speed and its unit; a speed by name may have none.
fn speed(term: &str) -> Result<(&str, &'static str), String> {
    const UNITS: [&str; 7] = ["mm/sec", "cm/min", "inch/min", "deg/sec", "msec", "sec", "%"];
    let lower = term.to_ascii_lowercase();
    let unit = UNITS.into_iter().find(|unit| lower.ends_with(unit)).unwrap_or("");
    let number = term.get(..term.len() - unit.len()).unwrap_or("").trim();
    let is_digit = |c: char| c.is_ascii_digit() || c == '.';
    let end = match term.rfind(']') {
        Some(at) => at + 1,
        None if term.starts_with(is_digit) => term.find(|c| !is_digit(c)).unwrap_or(term.len()),
        None => return Ok((number, unit)),
    };
    let own = term.get(end..).unwrap_or("").trim_matches([' ', ')']);
    if own.eq_ignore_ascii_case(unit) {
        return Ok((number, unit));
    }
    Err(format!("speed is {term}: '{own}' is no unit of TP; {} are", UNITS.join(", ")))
}
