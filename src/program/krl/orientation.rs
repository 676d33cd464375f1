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
        let last = self.log.last().map(|last| last.with(&self.tcp));
        let turns = |last: Isometry3<f64>| last.rotation.angle_to(&end.rotation) > NO_TURN_RAD;
        match (self.turns.on_lines, last) {
            (OnLines::Not, Some(last)) => Isometry3::from_parts(end.translation, last.rotation),
            (OnLines::Not | OnLines::Unread, last) if last.is_none_or(turns) => {
                let what = "$ORI_TYPE is not #VAR, or of an LDAT that is not known, and how the \
                            tool stands at the end is not known: it is taken to turn to the \
                            orientation of the target";
                self.log.warning(Code::AxisIgnored, line, what);
                end
            }
            _ => end,
        }
    }

    /// Tells of an arc with which the tool turns.
    pub(super) fn doubt_arc(&mut self, line: usize) {
        if self.turns.with_arc {
            let what = "$CIRC_TYPE is not #BASE, or of an LDAT that is not known: that the tool \
                        turns with the arc is not read";
            self.log.warning(Code::AxisIgnored, line, what);
        }
    }
}
