//! Which way round arcs run. CAM systems differ in what the axis of CIRCLE means; the lines beside
//! an arc that are tangent to it show which it is.

use nalgebra::{Unit, Vector3};

use super::Reader;
use crate::notes::Code;

/// A line is tangent to an arc up to 15°: lead-ins are rounded, and lines of splines short.
const TANGENT_COS: f64 = 0.966;

/// Start and end are this near where a full turn is meant, mm.
const SAME_POINT_MM: f64 = 1e-6;

/// What the program shows of its arcs.
#[derive(Debug, Default)]
pub(super) struct Senses {
    /// Written by NX.
    pub(super) is_nx: bool,
    /// Written by another system whose arcs run counterclockwise about the axis.
    pub(super) is_right_handed: bool,
    /// Direction of the straight move that has just ended.
    heading: Option<Vector3<f64>>,
    open: Option<Beside>,
    /// Arcs that a tangent line confirms.
    confirmed: usize,
    /// Whether one of these is of a kind whose sense is not known otherwise.
    shows_sense: bool,
    /// Lines of arcs that are tangent to the lines beside them the other way round alone, and
    /// whether they are NX's.
    contradicted: Vec<(usize, bool)>,
    /// Whether the angle of an arc says that it runs clockwise about its axis.
    is_mixed: bool,
    /// The first arc not of NX about which the lines beside it say nothing.
    silent: Option<usize>,
}

/// An arc whose next move is to come.
#[derive(Debug)]
struct Beside {
    line: usize,
    is_of_nx: bool,
    /// Where it ends to.
    tangent: Vector3<f64>,
    confirmations: usize,
    contradictions: usize,
    is_full_turn: bool,
}

impl Beside {
    fn compare(&mut self, tangent: Vector3<f64>, heading: Vector3<f64>) {
        let cos = tangent.dot(&heading);
        self.confirmations += usize::from(cos > TANGENT_COS);
        self.contradictions += usize::from(cos < -TANGENT_COS);
    }
}

impl Senses {
    /// A straight move.
    pub(super) fn straight(&mut self, from: Option<Vector3<f64>>, to: Vector3<f64>) {
        let Some(from) = from else { return self.lose() };
        let Some(heading) = (to - from).try_normalize(SAME_POINT_MM) else { return };
        if let Some(open) = &mut self.open {
            open.compare(open.tangent, heading);
        }
        self.lose();
        self.heading = Some(heading);
    }

    /// An arc, counterclockwise about its axis, that a statement at `line` asks for.
    pub(super) fn arc(
        &mut self,
        (line, is_of_nx): (usize, bool),
        [from, to, centre]: [Vector3<f64>; 3],
        axis: Unit<Vector3<f64>>,
    ) {
        let heading = self.heading;
        self.lose();
        let tangent = |at: Vector3<f64>| axis.cross(&(at - centre)).try_normalize(SAME_POINT_MM);
        let (Some(start), Some(end)) = (tangent(from), tangent(to)) else { return };
        let is_full_turn = (to - from).norm() <= SAME_POINT_MM;
        let mut open = Beside {
            line,
            is_of_nx,
            tangent: end,
            confirmations: 0,
            contradictions: 0,
            is_full_turn,
        };
        if let Some(heading) = heading {
            open.compare(start, heading);
        }
        self.open = Some(open);
    }

    /// The arc goes on about its axis, to here.
    pub(super) fn arc_goes_on(
        &mut self,
        to: Vector3<f64>,
        centre: Vector3<f64>,
        axis: Unit<Vector3<f64>>,
    ) {
        let tangent = axis.cross(&(to - centre)).try_normalize(SAME_POINT_MM);
        if let (Some(open), Some(tangent)) = (&mut self.open, tangent) {
            open.tangent = tangent;
        }
    }

    /// An arc whose angle says which way round it runs: about its axis, or against it.
    pub(super) fn shown_by_angle(&mut self, is_about_axis: bool) {
        self.lose();
        self.shows_sense |= is_about_axis;
        self.is_mixed |= !is_about_axis;
    }

    /// What follows is no straight move from here.
    pub(super) fn lose(&mut self) {
        self.heading = None;
        match self.open.take() {
            Some(arc) if arc.confirmations > 0 => {
                self.confirmed += 1;
                self.shows_sense |= !arc.is_of_nx;
            }
            Some(arc) if arc.contradictions > 0 => {
                self.contradicted.push((arc.line, arc.is_of_nx));
            }
            Some(arc) if !arc.is_full_turn && !arc.is_of_nx => {
                self.silent.get_or_insert(arc.line);
            }
            _ => {}
        }
    }
}

impl Reader<'_> {
    /// At the end of the program.
    pub(super) fn settle_senses(&mut self) {
        self.senses.lose();
        let contradicted = std::mem::take(&mut self.senses.contradicted);
        let is_wrong = contradicted.len() > self.senses.confirmed;
        for (line, is_of_nx) in contradicted {
            let taken = if is_of_nx { "as NX has it clockwise" } else { "counterclockwise" };
            let what = format!(
                "CIRCLE: taken to run {taken} about its axis, the arc meets the lines beside it at \
                 a cusp, and the other way round it is tangent to them"
            );
            if is_wrong {
                let what = format!("{what}; have the CAM system write GOTO points");
                self.cutter.log.error(Code::Motion, line, what);
            } else {
                self.cutter.log.warning(Code::UnitAssumed, line, what);
            }
        }
        let is_shown = self.senses.shows_sense && !self.senses.is_mixed;
        let is_known = self.senses.is_right_handed || is_shown;
        if let (false, Some(line)) = (is_known, self.senses.silent) {
            let what = "CIRCLE: taken to run counterclockwise about its axis; no line tangent to \
                        an arc shows that, and some systems write it the other way round";
            self.cutter.log.warning(Code::UnitAssumed, line, what);
        }
    }
}
