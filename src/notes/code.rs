//! The kinds of notes, by the names that JSON, the guide and users' own lists have for them.

use serde::{Serialize, Serializer};

macro_rules! codes {
    ($($(#[doc = $meaning:literal])+ $variant:ident = $name:literal,)+) => {
        /// What kind of thing a note says.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code { $($(#[doc = $meaning])+ $variant,)+ }

        impl Serialize for Code {
            fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str(self.name())
            }
        }

        impl Code {
            /// Every code, in the order of the guide.
            pub const ALL: &[Self] = &[$(Self::$variant,)+];

            /// Its name: stable, in lower case with underscores.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)+ }
            }

            /// What it means, as a sentence.
            pub fn meaning(self) -> &'static str {
                match self { $(Self::$variant => concat!($($meaning,)+).trim(),)+ }
            }
        }
    };
}

codes! {
    /// An option of the command line is wrong, or contradicts another.
    Usage = "usage",
    /// A file does not exist, cannot be read, is too large, or is not of the kind that it must be.
    Unreadable = "unreadable",
    /// An output cannot be written where it should go, or would replace what the run reads.
    Unwritable = "unwritable",
    /// The text of a file does not follow its format.
    Syntax = "syntax",
    /// A key, column or tag that detune does not know.
    UnknownKey = "unknown_key",
    /// A key, column or tag that is needed is not there.
    MissingKey = "missing_key",
    /// A value has the wrong type or lies outside what is possible.
    Value = "value",
    /// A name refers to nothing: no such joint, link, file, channel or tool.
    Reference = "reference",
    /// Two statements contradict each other.
    Conflict = "conflict",
    /// A mass or inertia that no body can have.
    Inertia = "inertia",
    /// Links and joints do not form one serial chain or tree with one root.
    Tree = "tree",
    /// The robot has no elastic coordinate, or one that moves no mass.
    NotElastic = "not_elastic",
    /// The mass or stiffness matrix is not positive definite at a pose.
    Singular = "singular",
    /// The robot does not reach a waypoint, or not without passing a joint limit or a singularity.
    Unreachable = "unreachable",
    /// A joint lies outside its limits.
    JointLimit = "joint_limit",
    /// A statement of a program whose motion detune does not understand.
    Motion = "motion",
    /// A path, program or table is longer than detune accepts.
    TooLong = "too_long",
    /// A table or record holds too little data for what is asked.
    TooLittleData = "too_little_data",
    /// A computation did not converge.
    NotConverged = "not_converged",
    /// A file that would be written is not what was asked for, so nothing was written.
    NotRewritten = "not_rewritten",
    /// Further errors were counted but are not listed.
    More = "more",
    /// A setting that has no effect.
    Unused = "unused",
    /// A value that no file states was assumed.
    Assumed = "assumed",
    /// The same mass and inertia on several links.
    SameInertial = "same_inertial",
    /// A centre of mass or a radius of gyration that lies beyond its link.
    InertiaExtent = "inertia_extent",
    /// Masses that are out of scale with the length of the arm.
    TotalMass = "total_mass",
    /// Numbers of a robot's files that look like millimetres or grams.
    CadUnits = "cad_units",
    /// A moving joint that no spring is given for.
    RigidJoint = "rigid_joint",
    /// A first natural frequency that no arm has.
    FirstFrequency = "first_frequency",
    /// A part of the program or table was left out.
    LeftOut = "left_out",
    /// The verdict is about nothing: no line or no mode counted, or the spindle stood still.
    NothingChecked = "nothing_checked",
    /// A joint cannot keep the programmed feed.
    FeedLimit = "feed_limit",
    /// A spindle schedule asks for more than the spindle's acceleration.
    SpindleAcceleration = "spindle_acceleration",
    /// A spindle schedule cannot follow the objective that was asked for.
    ObjectiveNotFollowed = "objective_not_followed",
    /// Nobody says what the arm carries, so a verdict is at best uncertain.
    PayloadUnknown = "payload_unknown",
    /// The program declares a tool mass other than the job or the robot file.
    ToolMass = "tool_mass",
    /// The program's own tool or work object is used, and not the job's.
    FrameFromProgram = "frame_from_program",
    /// The program commands a spindle speed that is not checked, or that the spindle does not
    /// reach.
    SpindleCommand = "spindle_command",
    /// A job or program was not written, and why.
    NotWritten = "not_written",
    /// Poses of a map lie outside the joint limits.
    OutsideLimits = "outside_limits",
    /// A peak of a nonlinear map that may not be the mode.
    Doubtful = "doubtful",
    /// A mode above half the sampling rate, seen at another frequency.
    Folded = "folded",
    /// Frequencies look as if they were in another unit.
    Units = "units",
    /// A calibration that says little, or that was fitted to the same data.
    Calibration = "calibration",
    /// The hammer bounced, or a second hit fell into a decay.
    DoubleHit = "double_hit",
    /// A channel ran into its limit.
    Clipping = "clipping",
    /// A channel is quantised in few steps.
    CoarseSteps = "coarse_steps",
    /// A channel does not move.
    DeadChannel = "dead_channel",
    /// A sample stands alone.
    Spike = "spike",
    /// A channel stands still for a while in the middle of its motion.
    Dropout = "dropout",
    /// A channel shows none of the modes that others show.
    NoSignal = "no_signal",
    /// The record ends before a mode has decayed.
    Leakage = "leakage",
    /// Force and response are not coherent at a mode.
    LowCoherence = "low_coherence",
    /// The force hardly reaches a mode's frequency.
    WeakForce = "weak_force",
    /// The record is shorter than a mode needs.
    ShortRecord = "short_record",
    /// The frequency may be aliased.
    MayBeFolded = "may_be_folded",
    /// A mode looks like a harmonic of the mains.
    Mains = "mains",
    /// A mode looks like a harmonic of the spindle.
    Spindle = "spindle",
    /// A mode's frequency depends on amplitude.
    AmplitudeDependent = "amplitude_dependent",
    /// A joint's stiffness depends on the load.
    LoadDependent = "load_dependent",
    /// A steady tone beside the modes, which was fitted and left out.
    Tone = "tone",
    /// A start or peak that the fit could not settle.
    Unsettled = "unsettled",
    /// No mode was found.
    NoModes = "no_modes",
    /// Records of one pose do not agree, or one lacks a mode.
    Disagreement = "disagreement",
    /// Poses have different numbers of modes.
    ModesDiffer = "modes_differ",
    /// Something about the file or the session that changes how results read.
    Remark = "remark",
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_meanings_are_sentences() {
        let mut names: Vec<&str> = Code::ALL.iter().map(|code| code.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Code::ALL.len());
        for code in Code::ALL {
            assert!(code.meaning().ends_with('.') && !code.meaning().starts_with(' '), "{code}");
            assert!(code.name().chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{code}");
        }
    }
}
