//! What a user must know about a record or a mode beside its numbers.

/// What kind of thing is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoticeKind {
    /// The hammer bounced, or a second hit fell into a decay.
    DoubleHit,
    /// A channel ran into its limit.
    Clipping,
    /// A channel moves in few steps.
    CoarseSteps,
    /// A channel does not move.
    DeadChannel,
    /// A sample stands alone.
    Spike,
    /// A channel stands still for a while in the middle of its motion.
    Dropout,
    /// A channel shows none of the modes that others show.
    NoSignal,
    /// The record ends before a mode has decayed.
    Leakage,
    /// Force and response do not belong together at a mode.
    LowCoherence,
    /// The force hardly reaches a mode's frequency.
    WeakForce,
    /// The record is shorter than a mode needs.
    ShortRecord,
    /// The frequency may be folded about half the sampling rate.
    MayBeFolded,
    /// A mode looks like a harmonic of the mains.
    Mains,
    /// A mode looks like a harmonic of the spindle.
    Spindle,
    /// A mode's frequency depends on amplitude.
    AmplitudeDependent,
    /// A steady tone beside the modes, which was fitted and left out.
    Tone,
    /// A start or peak that the fit could not settle.
    Unsettled,
    /// No mode was found.
    NoModes,
    /// Records of one pose do not agree, or one lacks a mode.
    Disagreement,
    /// Poses have different numbers of modes.
    ModesDiffer,
    /// Something about the file or the session that changes how results read.
    Remark,
}

impl NoticeKind {
    /// Its name in JSON.
    pub fn code(self) -> &'static str {
        match self {
            Self::DoubleHit => "double_hit",
            Self::Clipping => "clipping",
            Self::CoarseSteps => "coarse_steps",
            Self::DeadChannel => "dead_channel",
            Self::Spike => "spike",
            Self::Dropout => "dropout",
            Self::NoSignal => "no_signal",
            Self::Leakage => "leakage",
            Self::LowCoherence => "low_coherence",
            Self::WeakForce => "weak_force",
            Self::ShortRecord => "short_record",
            Self::MayBeFolded => "may_be_folded",
            Self::Mains => "mains",
            Self::Spindle => "spindle",
            Self::AmplitudeDependent => "amplitude_dependent",
            Self::Tone => "tone",
            Self::Unsettled => "unsettled",
            Self::NoModes => "no_modes",
            Self::Disagreement => "disagreement",
            Self::ModesDiffer => "modes_differ",
            Self::Remark => "remark",
        }
    }
}

/// One remark.
#[derive(Debug, Clone, PartialEq)]
pub struct Notice {
    /// Of what kind.
    pub kind: NoticeKind,
    /// The record, where it is about one.
    pub record: Option<String>,
    /// The channel, where it is about one.
    pub channel: Option<String>,
    /// What was seen, what it may mean, what helps: a lower-case fragment.
    pub what: String,
}

/// Notices about one record as they come up.
#[derive(Debug, Default)]
pub(super) struct Notices {
    record: Option<String>,
    pub(super) list: Vec<Notice>,
}

impl Notices {
    pub(super) fn about(record: &str) -> Self {
        Self { record: Some(record.to_owned()), list: Vec::new() }
    }

    pub(super) fn add(&mut self, kind: NoticeKind, channel: Option<&str>, what: String) {
        let channel = channel.map(str::to_owned);
        self.list.push(Notice { kind, record: self.record.clone(), channel, what });
    }
}
