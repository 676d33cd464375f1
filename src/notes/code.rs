//! The kinds of notes, by the names that JSON, the guide and users' own lists have for them.

use serde::{Serialize, Serializer};

/// What a note does to the verdict on a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// There is none.
    Error,
    /// Nothing.
    Remark,
    /// A resonance may hide in what the note is about: the verdict is at best uncertain.
    Doubt,
    /// A limit of the policy is exceeded: the verdict is resonance, the one that fails.
    Breach,
}

macro_rules! codes {
    ($($(#[doc = $meaning:literal])+ $variant:ident = $name:literal: $class:ident,)+) => {
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

            /// The code of this name.
            pub fn named(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|code| code.name() == name)
            }

            /// What its notes do to a verdict.
            pub const fn class(self) -> Class {
                match self { $(Self::$variant => Class::$class,)+ }
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
    Usage = "usage": Error,
    /// A file does not exist, cannot be read, is too large, or is not of the kind that it must be.
    Unreadable = "unreadable": Error,
    /// An output cannot be written where it should go, or would replace what the run reads.
    Unwritable = "unwritable": Error,
    /// The text of a file does not follow its format.
    Syntax = "syntax": Error,
    /// A key, column or tag that detune does not know.
    UnknownKey = "unknown_key": Error,
    /// A key, column or tag that is needed is not there.
    MissingKey = "missing_key": Error,
    /// A value has the wrong type or lies outside what is possible.
    Value = "value": Error,
    /// A name refers to nothing: no such joint, link, file, channel or tool.
    Reference = "reference": Error,
    /// Two statements contradict each other.
    Conflict = "conflict": Error,
    /// A mass or inertia that no body can have.
    Inertia = "inertia": Error,
    /// Links and joints do not form one serial chain or tree with one root.
    Tree = "tree": Error,
    /// The robot has no elastic coordinate, or one that moves no mass.
    NotElastic = "not_elastic": Error,
    /// The mass or stiffness matrix is not positive definite at a pose.
    Singular = "singular": Error,
    /// The robot does not reach a waypoint, or not without passing a joint limit or a singularity.
    Unreachable = "unreachable": Error,
    /// A joint lies outside its limits.
    JointLimit = "joint_limit": Error,
    /// A statement of a program whose motion detune does not understand.
    Motion = "motion": Error,
    /// A path, program or table is longer than detune accepts.
    TooLong = "too_long": Error,
    /// A table or record holds too little data for what is asked.
    TooLittleData = "too_little_data": Error,
    /// A computation did not converge.
    NotConverged = "not_converged": Error,
    /// A file that would be written is not what was asked for, so nothing was written.
    NotRewritten = "not_rewritten": Error,
    /// Further errors were counted but are not listed.
    More = "more": Error,
    /// A setting that has no effect.
    Unused = "unused": Remark,
    /// A value that no file states was assumed.
    Assumed = "assumed": Remark,
    /// The same mass and inertia on several links.
    SameInertial = "same_inertial": Doubt,
    /// A centre of mass or a radius of gyration that lies beyond its link.
    InertiaExtent = "inertia_extent": Doubt,
    /// Masses that are out of scale with the length of the arm.
    TotalMass = "total_mass": Doubt,
    /// A joint beside the arm that follows one of the arm's, and is taken to stand still.
    HeldJoint = "held_joint": Doubt,
    /// Masses and inertias that no file states, distributed from the mass of the whole arm.
    AssumedMass = "assumed_mass": Doubt,
    /// Numbers of robot or job that look like millimetres, grams, degrees or radians, or inertias
    /// that no body is compact enough for.
    CadUnits = "cad_units": Doubt,
    /// A stiffness out of scale with those of the other joints.
    StiffnessScale = "stiffness_scale": Doubt,
    /// A spring whose stiffness is a guess.
    AssumedSpring = "assumed_spring": Doubt,
    /// A moving joint that no spring is given for.
    RigidJoint = "rigid_joint": Doubt,
    /// A calibration that says little, that was fitted to the same data, or whose springs vary with
    /// what no job states.
    Calibration = "calibration": Doubt,
    /// A first natural frequency that no arm has.
    FirstFrequency = "first_frequency": Doubt,
    /// A table of measured modes does not state a joint, which is taken as zero.
    UnstatedJoint = "unstated_joint": Remark,
    /// The model's frequencies depend on a joint that the table does not state.
    AssumedPose = "assumed_pose": Remark,
    /// A part of the program or table was left out.
    LeftOut = "left_out": Remark,
    /// Motion, or what may be motion, was left out of the path.
    MotionLeftOut = "motion_left_out": Doubt,
    /// An axis that the program moves is taken to stand still.
    AxisIgnored = "axis_ignored": Doubt,
    /// A pose fixes fewer joints than the arm has, and where the controller moves the rest is not
    /// known.
    RedundantArm = "redundant_arm": Doubt,
    /// The program changes tool, head or work object, and the job's are used throughout.
    ChangeIgnored = "change_ignored": Doubt,
    /// The unit or the zero of a program's numbers is stated nowhere and was assumed.
    UnitAssumed = "unit_assumed": Doubt,
    /// A link without inertial, with geometry or between joints, counts as massless.
    Massless = "massless": Doubt,
    /// The verdict is about nothing: no line or no mode counted, or the spindle stood still.
    NothingChecked = "nothing_checked": Doubt,
    /// The cutting force moves the tool tip farther than the policy allows.
    LimitExceeded = "limit_exceeded": Breach,
    /// Within what model and cutting coefficients may be wrong by, the cutting force moves the tool
    /// tip farther than the policy allows.
    LimitInDoubt = "limit_in_doubt": Doubt,
    /// A limit of the policy on the tool tip cannot be held against a cutting force, as none is
    /// known, or not all of it.
    LimitUnchecked = "limit_unchecked": Doubt,
    /// A joint cannot keep the programmed feed.
    FeedLimit = "feed_limit": Remark,
    /// A spindle schedule asks for more than the spindle's acceleration, or a program cuts before
    /// the spindle can have reached the speed that it changes to.
    SpindleAcceleration = "spindle_acceleration": Doubt,
    /// A spindle schedule runs in time, and a joint cannot keep the feed that it counts on.
    ScheduleTiming = "schedule_timing": Doubt,
    /// A spindle schedule cannot follow the objective that was asked for.
    ObjectiveNotFollowed = "objective_not_followed": Remark,
    /// What the program sets the spindle with takes whole numbers, so that speeds between its steps
    /// are not advised.
    SpeedSteps = "speed_steps": Remark,
    /// A number that is rewritten also serves what the operation does not run, or an inline form
    /// still shows the old one.
    SharedNumber = "shared_number": Remark,
    /// Nobody says what the arm carries, so a verdict is at best uncertain.
    PayloadUnknown = "payload_unknown": Doubt,
    /// Nobody says where the tool ends, so it is taken at the robot's tip, and a line meets a mode
    /// that hardly moves that.
    TcpAssumed = "tcp_assumed": Remark,
    /// Frequencies of the table that are off by far more than the others, and that nothing which
    /// other poses bear out explains.
    Outlier = "outlier": Remark,
    /// The program declares a tool mass other than the job or the robot file.
    ToolMass = "tool_mass": Remark,
    /// The program and the job, or either and the corrections of the robot file, have masses at the
    /// tip that are more than a tenth apart.
    ToolMassConflict = "tool_mass_conflict": Doubt,
    /// The program's own tool or work object is used, and not the job's.
    FrameFromProgram = "frame_from_program": Remark,
    /// The program commands a spindle speed that is not checked, or that the spindle does not
    /// reach.
    SpindleCommand = "spindle_command": Doubt,
    /// A job or program was not written, and why.
    NotWritten = "not_written": Remark,
    /// Poses of a map lie outside the joint limits.
    OutsideLimits = "outside_limits": Remark,
    /// A peak of a nonlinear map that may not be the mode.
    Doubtful = "doubtful": Remark,
    /// A mode above half the sampling rate, seen at another frequency.
    Folded = "folded": Remark,
    /// Frequencies look as if they were in another unit.
    Units = "units": Remark,
    /// The hammer bounced, or a second hit fell into a decay.
    DoubleHit = "double_hit": Remark,
    /// A channel ran into its limit.
    Clipping = "clipping": Remark,
    /// A channel is quantised in few steps.
    CoarseSteps = "coarse_steps": Remark,
    /// A channel does not move.
    DeadChannel = "dead_channel": Remark,
    /// A sample stands alone.
    Spike = "spike": Remark,
    /// A channel stands still for a while in the middle of its motion.
    Dropout = "dropout": Remark,
    /// A free vibration does not go on as it did.
    Discontinuity = "discontinuity": Remark,
    /// A channel shows none of the modes that others show.
    NoSignal = "no_signal": Remark,
    /// A mark is not seen in some frames of a video.
    LostMark = "lost_mark": Remark,
    /// Force and responses seem not to have been sampled at the same time.
    Delay = "delay": Remark,
    /// The record ends before a mode has decayed.
    Leakage = "leakage": Remark,
    /// Force and response are not coherent at a mode.
    LowCoherence = "low_coherence": Remark,
    /// The force hardly reaches a mode's frequency.
    WeakForce = "weak_force": Remark,
    /// The record is shorter than a mode needs.
    ShortRecord = "short_record": Remark,
    /// The frequency may be aliased.
    MayBeFolded = "may_be_folded": Remark,
    /// A mode looks like a harmonic of the mains.
    Mains = "mains": Remark,
    /// A mode looks like a harmonic of the spindle.
    Spindle = "spindle": Remark,
    /// A mode's frequency depends on amplitude.
    AmplitudeDependent = "amplitude_dependent": Remark,
    /// A mode's damping depends on amplitude.
    AmplitudeDamping = "amplitude_damping": Remark,
    /// A joint's stiffness depends on the load.
    LoadDependent = "load_dependent": Remark,
    /// A steady tone beside the modes, which was fitted and left out.
    Tone = "tone": Remark,
    /// A start or peak that the fit could not settle.
    Unsettled = "unsettled": Remark,
    /// The fit leaves much of the responses at a mode: there may be another one beside it.
    Misfit = "misfit": Remark,
    /// No mode was found.
    NoModes = "no_modes": Remark,
    /// Records of one pose do not agree, or one lacks a mode.
    Disagreement = "disagreement": Remark,
    /// Poses have different numbers of modes, or modes change places.
    ModesDiffer = "modes_differ": Remark,
    /// Something about the file or the session that changes how results read.
    Remark = "remark": Remark,
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
            assert!(Code::named(code.name()) == Some(*code));
            assert!(code.name().chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{code}");
        }
    }
}
