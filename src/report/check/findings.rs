//! Crossings put together as a reader sees them: an uncertain stretch beside a certain one is its
//! flank, and what one mode and one line do in one operation is one finding, however often they
//! meet.

use std::collections::HashMap;

use super::operation::CheckedOperation;
use crate::excitation::{ExcitationLine, Source};
use crate::risk::{Certainty, Crossing};
use crate::units::percent_from_ratio;

/// Stretches that are no further apart than this share of the path adjoin each other: a reader
/// would not distinguish them.
const ADJOINING_S: f64 = 1e-3;

/// A crossing with the uncertain stretches on either side of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report) struct Stretch<'a> {
    pub crossing: &'a Crossing,
    /// Where the flank before it starts; `crossing.from_s` if there is none.
    pub flank_from_s: f64,
    /// Where the flank after it ends; `crossing.to_s` if there is none.
    pub flank_to_s: f64,
}

impl Stretch<'_> {
    /// Ends of the stretch with its flanks, if it has any.
    pub(in crate::report) fn flanks(&self) -> Option<(f64, f64)> {
        let crossing = self.crossing;
        (self.flank_from_s < crossing.from_s || self.flank_to_s > crossing.to_s)
            .then_some((self.flank_from_s, self.flank_to_s))
    }
}

/// All that one mode and one line do in an operation with one certainty.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Finding<'a> {
    pub certainty: Certainty,
    pub mode: usize,
    pub line: ExcitationLine,
    /// The worst of its stretches.
    pub worst: Stretch<'a>,
    /// The others, in the order of the path.
    pub others: Vec<Stretch<'a>>,
}

/// What a finding is to those who read it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum Class {
    /// Certain, and not accepted.
    Resonance,
    /// Uncertain, and not accepted.
    Uncertain,
    /// The job accepts it, be it certain or not.
    Accepted,
}

impl Finding<'_> {
    /// What it is, with what the job accepts.
    pub(in crate::report) fn class(&self) -> Class {
        match (&self.worst.crossing.accepted, self.certainty) {
            (None, Certainty::Certain) => Class::Resonance,
            (None, Certainty::Uncertain) => Class::Uncertain,
            (Some(_), _) => Class::Accepted,
        }
    }

    /// The name of what it goes against, whether the job accepts it or not.
    pub(in crate::report) fn rule(&self) -> &'static str {
        match self.certainty {
            Certainty::Certain => "resonance",
            Certainty::Uncertain => "uncertain",
        }
    }
}

/// The crossings of an operation without those that flank another, the most severe first: certain
/// before uncertain, then the closest (to a tenth of a percent, as it is shown), then the one that
/// moves the tool tip most, then the first along the path.
pub(in crate::report) fn stretches<'a>(crossings: &'a [Crossing]) -> Vec<Stretch<'a>> {
    let mut together: HashMap<Meeting, Vec<&'a Crossing>> = HashMap::new();
    for crossing in crossings {
        together.entry(meeting(crossing)).or_default().push(crossing);
    }
    let mut stretches: Vec<Stretch<'a>> = Vec::new();
    for along in together.values_mut() {
        // One mode and one line: the crossings do not overlap, so their ends ascend with their
        // starts.
        along.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        stretches.extend((0..along.len()).filter_map(|index| stretch(along, index)));
    }
    stretches.sort_by(|a, b| {
        let (a, b) = (a.crossing, b.crossing);
        let shown = |crossing: &Crossing| (percent_from_ratio(crossing.separation) * 10.0).round();
        let is_accepted = |crossing: &Crossing| crossing.accepted.is_some();
        is_accepted(a)
            .cmp(&is_accepted(b))
            .then(b.certainty.cmp(&a.certainty))
            .then(shown(a).total_cmp(&shown(b)))
            .then(b.tip_response_m_per_n.total_cmp(&a.tip_response_m_per_n))
            .then(a.from_s.total_cmp(&b.from_s))
            // The groups come in no order.
            .then(meeting(a).cmp(&meeting(b)))
    });
    stretches
}

/// The findings of an operation, the most severe first.
pub(in crate::report) fn findings<'a>(operation: &CheckedOperation<'a>) -> Vec<Finding<'a>> {
    let mut findings: Vec<Finding<'a>> = Vec::new();
    let mut index_of: HashMap<(Meeting, Certainty), usize> = HashMap::new();
    for stretch in stretches(&operation.risk.crossings) {
        let crossing = stretch.crossing;
        let next = findings.len();
        let index = *index_of.entry((meeting(crossing), crossing.certainty)).or_insert(next);
        match findings.get_mut(index) {
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

/// What meets: a mode, and a line by its source and harmonic.
type Meeting = (usize, Source, u32);

fn meeting(crossing: &Crossing) -> Meeting {
    (crossing.mode, crossing.line.source, crossing.line.harmonic)
}

/// The stretch of a crossing among those of its mode and line, in the order of the path; `None` if
/// it flanks another.
fn stretch<'a>(along: &[&'a Crossing], index: usize) -> Option<Stretch<'a>> {
    let (before, from_here) = along.split_at_checked(index)?;
    let (crossing, after) = from_here.split_first()?;
    // Only neighbours lie so near.
    let mut before = before
        .iter()
        .rev()
        .take_while(|other| crossing.from_s - other.to_s <= ADJOINING_S)
        .filter(|other| other.certainty != crossing.certainty);
    let mut after = after
        .iter()
        .take_while(|other| other.from_s - crossing.to_s <= ADJOINING_S)
        .filter(|other| other.certainty != crossing.certainty);
    if crossing.certainty == Certainty::Uncertain {
        let flanks = before.next().is_some() || after.next().is_some();
        return (!flanks).then_some(Stretch {
            crossing,
            flank_from_s: crossing.from_s,
            flank_to_s: crossing.to_s,
        });
    }
    Some(Stretch {
        crossing,
        flank_from_s: before.map(|other| other.from_s).fold(crossing.from_s, f64::min),
        flank_to_s: after.map(|other| other.to_s).fold(crossing.to_s, f64::max),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Crossings of three modes and two lines, end to end or apart, in no order.
    fn crossings(rng: &mut ChaCha8Rng) -> Vec<Crossing> {
        let mut all = Vec::new();
        for mode in 1..=3 {
            for source in [Source::ToothPassing, Source::Spindle] {
                let mut at = 0.0;
                while at < 1.0 {
                    let from_s = at + [0.0, 0.4e-3, 0.9e-3, 3e-3][rng.random_range(0..4)];
                    let to_s = from_s + rng.random_range(1e-4..0.05);
                    at = to_s;
                    let certain = rng.random();
                    all.push(Crossing {
                        mode,
                        certainty: if certain { Certainty::Certain } else { Certainty::Uncertain },
                        line: ExcitationLine { source, harmonic: 1, order: 1 },
                        excitation_hz: 20.0,
                        natural_frequency_hz: 20.0,
                        from_s,
                        to_s,
                        closest_s: from_s,
                        natural_frequency_ci95_hz: [0.0, 0.0],
                        probability: None,
                        driver: None,
                        accepted: None,
                        separation: 0.01 * f64::from(rng.random_range(0_u8..3)),
                        tip_response_m_per_n: 1e-6,
                        moves: Vec::new(),
                        leading_turn_together: None,
                        file: "a.yaml".into(),
                        from_line: 1,
                        to_line: 2,
                    });
                }
            }
        }
        for last in (1..all.len()).rev() {
            all.swap(last, rng.random_range(0..=last));
        }
        all
    }

    /// The definition word for word: every crossing against every other.
    fn by_definition(all: &[Crossing]) -> Vec<(usize, Source, f64, f64, f64)> {
        let adjoins = |flank: &Crossing, of: &Crossing| {
            let same = flank.mode == of.mode && flank.line == of.line;
            let unlike =
                (flank.certainty, of.certainty) == (Certainty::Uncertain, Certainty::Certain);
            let before = same && unlike && (of.from_s - flank.to_s).abs() <= ADJOINING_S;
            let after = same && unlike && (flank.from_s - of.to_s).abs() <= ADJOINING_S;
            (before, after)
        };
        let mut found = Vec::new();
        for crossing in all {
            if all.iter().any(|of| adjoins(crossing, of) != (false, false)) {
                continue;
            }
            let (mut from, mut to) = (crossing.from_s, crossing.to_s);
            for flank in all {
                let (before, after) = adjoins(flank, crossing);
                from = if before { from.min(flank.from_s) } else { from };
                to = if after { to.max(flank.to_s) } else { to };
            }
            found.push((crossing.mode, crossing.line.source, crossing.from_s, from, to));
        }
        found
    }

    #[test]
    fn neighbours_alone_give_what_the_definition_gives() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut flanked = 0;
        for _ in 0..50 {
            let all = crossings(&mut rng);
            let of = |each: &Stretch<'_>| {
                let crossing = each.crossing;
                let (from, to) = (each.flank_from_s, each.flank_to_s);
                (crossing.mode, crossing.line.source, crossing.from_s, from, to)
            };
            let found = stretches(&all);
            flanked += found.iter().filter(|each| each.flanks().is_some()).count();
            let mut found: Vec<_> = found.iter().map(of).collect();
            let mut expected = by_definition(&all);
            for list in [&mut found, &mut expected] {
                list.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
            }
            assert_eq!(found, expected);
        }
        assert!(flanked > 100, "{flanked}");
    }
}
