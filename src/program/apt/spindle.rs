//! SPINDL in the forms of the CAM systems.

use super::Reader;
use super::lexer::Word;
use crate::notes::Code;
use crate::program::span::Span;

impl Reader<'_> {
    /// `SPINDL/780,RPM,CLW`, `SPINDL/RPM,780,CLW`, `SPINDL/RANGE,2,RPM,780`, `…,MAXRPM,5000`,
    /// `SPINDL/ON`, `SPINDL/OFF`.
    pub(super) fn spindle(&mut self, line: usize, minor: &[Word<'_>]) -> Result<(), String> {
        self.tools.has_spindle();
        let mut speeds: Vec<(f64, Span)> = Vec::new();
        let (mut stops, mut by_surface) = (false, false);
        let mut most: Option<f64> = None;
        let mut rest = minor;
        while let [first, tail @ ..] = rest {
            rest = tail;
            let word = match first {
                Word::Number(value, span) => {
                    speeds.push((*value, *span));
                    continue;
                }
                Word::Name(name) => name.to_ascii_uppercase(),
            };
            match word.as_str() {
                // What follows is a limit, or a gear.
                "MAXRPM" | "LIMIT" => {
                    most = tail.first().and_then(super::number).map(|(most, _)| most);
                    rest = tail.get(1..).unwrap_or_default();
                }
                "RANGE" | "OSETNO" => {
                    rest = tail.get(1..).unwrap_or_default();
                }
                "OFF" | "LOCK" | "ORIENT" | "STOP" => stops = true,
                "SFM" | "SMM" | "SURF" | "CSS" => by_surface = true,
                "CLW" | "CW" => self.cutter.log.reverse(false),
                "CCLW" | "CCW" => self.cutter.log.reverse(true),
                "RPM" | "ON" | "BOTH" | "AUTO" | "NOX" | "LOW" | "MEDIUM" | "HIGH" | "NEUTRL"
                | "MAIN" | "" => {}
                other => return Err(format!("'{other}' is not understood")),
            }
        }
        if let [(first, _), (second, _), ..] = speeds.as_slice() {
            return Err(format!("{first} or {second}: which of them is the speed is not clear"));
        }
        if stops {
            self.cutter.turn_spindle(line, false);
            return Ok(());
        }
        if by_surface {
            let what = "SPINDL by surface speed is left out: the speed is not known";
            self.cutter.log.warning(Code::LeftOut, line, what);
            self.cutter.rpm = None;
            self.cutter.turn_spindle(line, true);
            return Ok(());
        }
        if let [(rpm, span)] = *speeds.as_slice() {
            if let Some(most) = most.filter(|most| rpm > *most) {
                return Err(format!("{rpm} rpm is above the largest speed there, {most} rpm"));
            }
            self.cutter.is_on = None;
            self.cutter.state_speed(line, rpm, Some(span))?;
        } else {
            // ON, CLW, CCLW: as before, or at a speed that is set elsewhere.
            self.cutter.rpm = self.cutter.rpm.filter(|&rpm| rpm > 0.0);
        }
        self.cutter.turn_spindle(line, true);
        Ok(())
    }
}
