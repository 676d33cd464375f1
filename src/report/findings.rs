//! Crossings put together as a reader sees them: an uncertain stretch beside a certain one is its flank,
//! and what one mode and one line do in one operation is one finding, however often they meet.

use super::CheckedOperation;
use crate::excitation::ExcitationLine;
use crate::risk::{Certainty, Crossing};
use crate::units::percent_from_ratio;

/// Stretches that are no further apart than this share of the path adjoin each other: what a check looks
/// for is that wide at least.
const ADJOINING_S: f64 = 1e-3;

/// A crossing with the uncertain stretches on either side of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch<'a> {
    pub crossing: &'a Crossing,
    /// Where the flank before it starts; `crossing.from_s` if there is none.
    pub flank_from_s: f64,
    /// Where the flank after it ends; `crossing.to_s` if there is none.
    pub flank_to_s: f64,
}

impl Stretch<'_> {
    /// Ends of the stretch with its flanks, if it has any.
    pub(super) fn flanks(&self) -> Option<(f64, f64)> {
        let crossing = self.crossing;
        (self.flank_from_s < crossing.from_s || self.flank_to_s > crossing.to_s)
            .then_some((self.flank_from_s, self.flank_to_s))
    }
}

/// All that one mode and one line do in an operation with one certainty.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Finding<'a> {
    pub certainty: Certainty,
    pub mode: usize,
    pub line: ExcitationLine,
    /// The worst of its stretches.
    pub worst: Stretch<'a>,
    /// The others, in the order of the path.
    pub others: Vec<Stretch<'a>>,
}

/// The crossings of an operation without those that flank another, the most severe first: certain before
/// uncertain, then the closest (to a tenth of a percent, as it is shown), then the one that moves the tool
/// tip most, then the first along the path.
pub(super) fn stretches<'a>(crossings: &'a [Crossing]) -> Vec<Stretch<'a>> {
    let mut stretches: Vec<Stretch<'a>> = crossings
        .iter()
        .filter(|crossing| !is_flank(crossing, crossings))
        .map(|crossing| with_flanks(crossing, crossings))
        .collect();
    stretches.sort_by(|a, b| {
        let (a, b) = (a.crossing, b.crossing);
        let shown = |crossing: &Crossing| (percent_from_ratio(crossing.separation) * 10.0).round();
        b.certainty
            .cmp(&a.certainty)
            .then(shown(a).total_cmp(&shown(b)))
            .then(b.tip_response_m_per_n.total_cmp(&a.tip_response_m_per_n))
            .then(a.from_s.total_cmp(&b.from_s))
    });
    stretches
}

/// The findings of an operation, the most severe first.
pub(super) fn findings<'a>(operation: &CheckedOperation<'a>) -> Vec<Finding<'a>> {
    let mut findings: Vec<Finding<'a>> = Vec::new();
    for stretch in stretches(&operation.risk.crossings) {
        let crossing = stretch.crossing;
        let same = findings.iter_mut().find(|finding| {
            finding.mode == crossing.mode
                && finding.line == crossing.line
                && finding.certainty == crossing.certainty
        });
        match same {
            Some(finding) => finding.others.push(stretch),
            None => findings.push(Finding {
                certainty: crossing.certainty,
                mode: crossing.mode,
                line: crossing.line,
                worst: stretch,
                others: Vec::new(),
            }),
        }
    }
    for finding in &mut findings {
        finding.others.sort_by(|a, b| a.crossing.from_s.total_cmp(&b.crossing.from_s));
    }
    findings
}

fn is_flank(crossing: &Crossing, all: &[Crossing]) -> bool {
    crossing.certainty == Certainty::Uncertain
        && all.iter().any(|other| adjoins_before(crossing, other) || adjoins_after(crossing, other))
}

fn with_flanks<'a>(crossing: &'a Crossing, all: &[Crossing]) -> Stretch<'a> {
    let (mut flank_from_s, mut flank_to_s) = (crossing.from_s, crossing.to_s);
    for other in all.iter().filter(|other| other.certainty == Certainty::Uncertain) {
        if adjoins_before(other, crossing) {
            flank_from_s = flank_from_s.min(other.from_s);
        }
        if adjoins_after(other, crossing) {
            flank_to_s = flank_to_s.max(other.to_s);
        }
    }
    Stretch { crossing, flank_from_s, flank_to_s }
}

/// Whether `flank` runs up to the start of the certain crossing `of`.
fn adjoins_before(flank: &Crossing, of: &Crossing) -> bool {
    same_certain(flank, of) && (of.from_s - flank.to_s).abs() <= ADJOINING_S
}

/// Whether `flank` goes on from the end of the certain crossing `of`.
fn adjoins_after(flank: &Crossing, of: &Crossing) -> bool {
    same_certain(flank, of) && (flank.from_s - of.to_s).abs() <= ADJOINING_S
}

fn same_certain(flank: &Crossing, of: &Crossing) -> bool {
    of.certainty == Certainty::Certain && flank.mode == of.mode && flank.line == of.line
}
