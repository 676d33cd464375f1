//! Constant spindle speeds: which are safe, exactly, and what closes the others.

use schemars::JsonSchema;
use serde::Serialize;

use crate::excitation::{ExcitationLine, WithoutOrder};
use crate::job::{Job, Operation, Policy, Spindle};
use crate::risk::Rules;
use crate::units::{hz_from_rpm, rpm_from_hz, written};

use super::ranges::ModeRange;

/// Speeds, rev/min, between two ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Speeds {
    /// Lowest.
    #[serde(rename = "from_rpm")]
    pub low_rpm: f64,
    /// Highest.
    #[serde(rename = "to_rpm")]
    pub high_rpm: f64,
}

impl Speeds {
    /// Whether a speed lies within, ends included.
    pub fn contains(&self, rpm: f64) -> bool {
        (self.low_rpm..=self.high_rpm).contains(&rpm)
    }
}

/// A mode and a line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// Counted from 1 in ascending frequency.
    pub mode: usize,
    /// The line.
    #[serde(flatten, with = "WithoutOrder")]
    pub line: ExcitationLine,
}

/// Speeds at which one line lies in one mode's widened band somewhere along the path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Counted from 1 in ascending frequency.
    pub mode: usize,
    /// The line.
    #[serde(flatten, with = "WithoutOrder")]
    pub line: ExcitationLine,
    /// The ends, which do not belong to it.
    #[serde(flatten)]
    pub speeds: Speeds,
}

impl Block {
    fn pair(self) -> Pair {
        Pair { mode: self.mode, line: self.line }
    }
}

/// Speeds without a safe one among them.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Closed")]
pub struct ClosedRange {
    /// From the lowest end to the highest; within the spindle's range.
    #[serde(flatten)]
    pub speeds: Speeds,
    /// What closes them, ascending in from_rpm.
    pub blocks: Vec<Block>,
}

/// The constant speeds of a spindle, divided.
#[derive(Debug, Clone, PartialEq)]
pub struct SafeSet {
    /// Safe ones, ascending.
    pub safe: Vec<Speeds>,
    /// The others, ascending.
    pub closed: Vec<ClosedRange>,
}

impl SafeSet {
    /// Whether a speed is safe, ends included.
    pub fn holds(&self, rpm: f64) -> bool {
        self.safe.iter().any(|gap| gap.contains(rpm))
    }

    /// The blocks in which a speed lies, ends not included; empty where it is safe.
    pub(super) fn blocks_at(&self, rpm: f64) -> Vec<Block> {
        let holds = |block: &Block| block.speeds.low_rpm < rpm && rpm < block.speeds.high_rpm;
        let around = self.closed.iter().find(|range| range.blocks.iter().any(holds));
        let blocks = around.map_or(&[][..], |range| &range.blocks);
        blocks.iter().copied().filter(holds).collect()
    }
}

/// Two blocks that meet at the speed that comes nearest to being safe.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Binding {
    /// The least distance that this speed keeps from the frequencies, or from their intervals, in
    /// percent of them; below zero where a mode passes through the line.
    #[serde(rename = "separation_percent", serialize_with = "written::percent")]
    pub separation: f64,
    /// The speed that comes nearest; not safe.
    #[serde(rename = "closest_rpm")]
    pub rpm: f64,
    /// What closes in from below; null for the spindle's lowest speed.
    pub below: Option<Pair>,
    /// What closes in from above; null for the spindle's highest speed.
    pub above: Option<Pair>,
}

/// A constant speed that is safe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant {
    /// The speed, rev/min.
    pub rpm: f64,
    /// The feed that belongs to it, m/s.
    pub feed_m_per_s: f64,
    /// The least |f_exc − f_r| / f_r along the path; `None` where nothing counts.
    pub separation: Option<f64>,
    /// Whether this is what is programmed.
    pub is_programmed: bool,
}

/// What lies outside bands this wide, a million times the frequency, is near to nothing that
/// counts.
pub(super) const MAX_HALF_WIDTH: f64 = 1e6;

/// What a set of constant speeds is worked out from.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpeedProblem<'a> {
    pub(super) ranges: &'a [ModeRange],
    pub(super) lines: &'a [ExcitationLine],
    pub(super) rules: &'a Rules<'a>,
    pub(super) spindle: &'a Spindle,
    /// Steps of the speeds that can be set, rev/min; any where it is `None`.
    pub(super) step_rpm: Option<f64>,
}

impl<'a> SpeedProblem<'a> {
    /// Of an operation with its own spindle.
    pub(super) fn of(
        (job, operation): (&'a Job, &Operation),
        rules: &'a Rules<'a>,
        ranges: &'a [ModeRange],
        lines: &'a [ExcitationLine],
    ) -> Self {
        let step_rpm = operation.speed_step_rpm;
        Self { ranges, lines, rules, spindle: &job.spindle, step_rpm }
    }

    /// Blocks of bands of half width `half_width` (a share of the frequency), ascending.
    fn blocks(&self, half_width: f64) -> Vec<Block> {
        let mut blocks = Vec::new();
        for range in self.ranges {
            for &line in self.lines {
                let rpm = |hz: f64| rpm_from_hz(hz) / f64::from(line.order);
                let speeds = Speeds {
                    low_rpm: rpm(range.reach_hz[0] * (1.0 - half_width)).max(0.0),
                    high_rpm: rpm(range.reach_hz[1] * (1.0 + half_width)),
                };
                let Spindle { min_rpm: min, max_rpm: max, .. } = *self.spindle;
                if speeds.low_rpm < speeds.high_rpm && speeds.low_rpm < max && speeds.high_rpm > min
                {
                    let pieces = self.not_ignored(line, speeds);
                    let closing =
                        pieces.filter(|piece| piece.low_rpm < max && piece.high_rpm > min);
                    blocks.extend(closing.map(|speeds| Block { mode: range.mode, line, speeds }));
                }
            }
        }
        blocks.sort_by(|a, b| {
            a.speeds.low_rpm.total_cmp(&b.speeds.low_rpm).then(a.mode.cmp(&b.mode))
        });
        blocks
    }

    /// Where the highest block of all speeds ends, rev/min; `None` where nothing counts.
    pub(super) fn highest_block_rpm(&self) -> Option<f64> {
        let highest_hz = self.ranges.iter().map(|range| range.reach_hz[1]).reduce(f64::max)?;
        let lowest_order = self.lines.iter().map(|line| line.order).min()?;
        Some(rpm_from_hz(highest_hz * (1.0 + self.rules.half_width())) / f64::from(lowest_order))
    }

    /// The parts of `speeds` at which the policy does not ignore the line.
    fn not_ignored(&self, line: ExcitationLine, speeds: Speeds) -> impl Iterator<Item = Speeds> {
        ignored_speeds(self.rules.policy, line)
            .fold(vec![speeds], |pieces, ignored| {
                pieces
                    .into_iter()
                    .flat_map(|piece| {
                        [
                            Speeds { high_rpm: piece.high_rpm.min(ignored.low_rpm), ..piece },
                            Speeds { low_rpm: piece.low_rpm.max(ignored.high_rpm), ..piece },
                        ]
                    })
                    .filter(|piece| piece.low_rpm < piece.high_rpm)
                    .collect()
            })
            .into_iter()
    }

    /// The spindle's speeds divided into those outside all bands of half width `half_width` and the
    /// others. Blocks are open, so two that touch leave one speed between them, which counts as
    /// closed: nobody can set it.
    pub(super) fn divide(&self, half_width: f64) -> SafeSet {
        let Spindle { min_rpm, max_rpm, .. } = *self.spindle;
        let mut set = SafeSet { safe: Vec::new(), closed: Vec::new() };
        let mut reached = min_rpm;
        for block in self.blocks(half_width) {
            let low_rpm = block.speeds.low_rpm.max(min_rpm);
            let high_rpm = block.speeds.high_rpm.min(max_rpm);
            match set.closed.last_mut() {
                Some(last) if low_rpm <= reached => {
                    last.speeds.high_rpm = last.speeds.high_rpm.max(high_rpm);
                    last.blocks.push(block);
                }
                _ => {
                    if low_rpm > reached {
                        set.safe.push(Speeds { low_rpm: reached, high_rpm: low_rpm });
                    }
                    let speeds = Speeds { low_rpm, high_rpm };
                    set.closed.push(ClosedRange { speeds, blocks: vec![block] });
                }
            }
            reached = reached.max(high_rpm);
        }
        if reached < max_rpm || set.closed.is_empty() {
            set.safe.push(Speeds { low_rpm: reached, high_rpm: max_rpm });
        }
        for unchecked in self.unchecked() {
            let rest = |gap: &Speeds| {
                let below = Speeds { high_rpm: gap.high_rpm.min(unchecked.low_rpm), ..*gap };
                let above = Speeds { low_rpm: gap.low_rpm.max(unchecked.high_rpm), ..*gap };
                [below, above].into_iter().filter(|part| part.low_rpm < part.high_rpm)
            };
            set.safe = set.safe.iter().flat_map(rest).collect();
        }
        set
    }

    /// Speeds at which every line lies in an ignored band: a check of them would check nothing.
    fn unchecked(&self) -> Vec<Speeds> {
        let Spindle { min_rpm, max_rpm, .. } = *self.spindle;
        let mut found = match self.lines {
            [] => return Vec::new(),
            _ => vec![Speeds { low_rpm: min_rpm, high_rpm: max_rpm }],
        };
        for line in self.lines {
            let per_hz = line.frequency_hz(1.0).recip();
            let bands = self.rules.policy.ignore_hz.iter().map(|band| band.map(|hz| hz * per_hz));
            let bands: Vec<[f64; 2]> = bands.collect();
            let within = |speeds: &Speeds| {
                let parts = bands.iter().map(|[low, high]| Speeds {
                    low_rpm: speeds.low_rpm.max(*low),
                    high_rpm: speeds.high_rpm.min(*high),
                });
                parts.filter(|part| part.low_rpm < part.high_rpm).collect::<Vec<_>>()
            };
            found = found.iter().flat_map(within).collect();
        }
        found
    }

    /// The least |f_exc − f_r| / f_r that a constant speed keeps from what counts; `None` where
    /// nothing does. Zero where a mode passes through a line.
    pub(super) fn separation(&self, rpm: f64) -> Option<f64> {
        let mut least: Option<f64> = None;
        for range in self.ranges {
            for line in self.lines {
                let excitation_hz = line.frequency_hz(rpm);
                if self.rules.policy.ignores(excitation_hz) {
                    continue;
                }
                let below = 1.0 - excitation_hz / range.low_hz;
                let above = excitation_hz / range.high_hz - 1.0;
                let apart = below.max(above).max(0.0);
                least = Some(least.map_or(apart, |least| least.min(apart)));
            }
        }
        least
    }

    /// The largest separation that any constant speed keeps, and what binds it; `None` where bands
    /// may be as wide as they like.
    pub(super) fn widest(&self) -> Option<Binding> {
        let has_gap = |half_width: f64| !self.divide(half_width).safe.is_empty();
        // Bands of half width −1 are empty.
        let (mut open, mut closed) = (-1.0, 1.0);
        while has_gap(closed) {
            if closed > MAX_HALF_WIDTH {
                return None;
            }
            (open, closed) = (closed, 2.0 * closed);
        }
        // To the last digit.
        for _ in 0..80 {
            let middle = 0.5 * (open + closed);
            if middle <= open || middle >= closed {
                break;
            }
            if has_gap(middle) { open = middle } else { closed = middle }
        }
        let gap = *self.divide(open).safe.first()?;
        let rpm = 0.5 * (gap.low_rpm + gap.high_rpm);
        // Of the blocks that close the gap at last, the one that ends in it and the one that begins
        // in it.
        let closing = || {
            let blocks = self.blocks(closed);
            blocks.into_iter().filter(move |b| {
                b.speeds.low_rpm <= gap.high_rpm && b.speeds.high_rpm >= gap.low_rpm
            })
        };
        let ends_here =
            |b: &Block| (b.speeds.high_rpm - rpm).abs() < (b.speeds.low_rpm - rpm).abs();
        let below = closing().filter(ends_here).min_by(|a, b| {
            (a.speeds.high_rpm - rpm).abs().total_cmp(&(b.speeds.high_rpm - rpm).abs())
        });
        let above = closing().filter(|block| !ends_here(block)).min_by(|a, b| {
            (a.speeds.low_rpm - rpm).abs().total_cmp(&(b.speeds.low_rpm - rpm).abs())
        });
        let [below, above] = [below, above].map(|block| block.map(Block::pair));
        Some(Binding { rpm, separation: open, below, above })
    }
}

/// Speeds at which a line lies in a band that the policy ignores.
pub(super) fn ignored_speeds(
    policy: &Policy,
    line: ExcitationLine,
) -> impl Iterator<Item = Speeds> + '_ {
    let rpm = move |hz: f64| rpm_from_hz(hz) / f64::from(line.order);
    policy
        .ignore_hz
        .iter()
        .map(move |&[low, high]| Speeds { low_rpm: rpm(low), high_rpm: rpm(high) })
}

/// Feed that keeps the chip load of `feed_m_per_s` at `from_rpm` when the spindle runs at `to_rpm`,
/// m/s.
pub(super) fn feed_at(feed_m_per_s: f64, from_rpm: f64, to_rpm: f64) -> f64 {
    feed_m_per_s * hz_from_rpm(to_rpm) / hz_from_rpm(from_rpm)
}
