//! How the tool turns on lines and arcs: $ORI_TYPE and $CIRC_TYPE.

use nalgebra::Isometry3;

use super::run::Run;
use super::turns::OnLines;
use crate::notes::Code;

/// Turns below this are rounding, rad.
const NO_TURN_RAD: f64 = 1e-5;

impl<'a> Run<'a> {
    /// The end of a line or an arc, with the orientation that the tool has there.
    pub(super) fn turned(&mut self, line: usize, end: Isometry3<f64>) -> Isometry3<f64> {
        let Some(last) = self.log.last().map(|last| last.with(&self.tcp)) else { return end };
        match self.turns.on_lines {
            OnLines::ToTarget => end,
            OnLines::Not => Isometry3::from_parts(end.translation, last.rotation),
            OnLines::Unread => {
                if last.rotation.angle_to(&end.rotation) > NO_TURN_RAD {
                    let what = "$ORI_TYPE is neither #VAR nor #CONSTANT: the tool is taken to turn \
                                to the orientation of the target";
                    self.log.warning(Code::AxisIgnored, line, what);
                }
                end
            }
        }
    }

    /// Tells of an arc with which the tool turns.
    pub(super) fn doubt_arc(&mut self, line: usize) {
        if self.turns.with_arc {
            let what = "$CIRC_TYPE is not #BASE: that the tool turns with the arc is not read";
            self.log.warning(Code::AxisIgnored, line, what);
        }
    }
}
