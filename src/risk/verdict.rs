//! What a check finds: plain data that holds nothing of the model.

use schemars::JsonSchema;
use serde::Serialize;

use crate::excitation::ExcitationLine;
use crate::notes::Note;

/// The answer for an operation, a job or a set of jobs; the worst of its parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub enum Verdict {
    /// No line comes near any mode.
    Clear,
    /// A line comes nearer than the model is accurate.
    Uncertain,
    /// A line lies inside a mode's band.
    Resonance,
}

/// How sure a crossing is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`certain`: inside the band f (1 ± separation). `uncertain`: outside that band, \
                   inside the one widened by\nthe model's uncertainty."
)]
pub enum Certainty {
    /// Outside the band, inside the one widened by the model's uncertainty.
    Uncertain,
    /// Inside the band f_r (1 ± separation).
    Certain,
}

/// A stretch of path on which one line stays in one mode's band, with one certainty.
#[derive(Debug, Clone, PartialEq)]
pub struct Crossing {
    /// Index of the mode in ascending frequency, counted from 1.
    pub mode: usize,
    /// How sure.
    pub certainty: Certainty,
    /// The line.
    pub line: ExcitationLine,
    /// The line's frequency at `closest_s`, Hz.
    pub excitation_hz: f64,
    /// The mode's frequency at `closest_s`, Hz.
    pub natural_frequency_hz: f64,
    /// Where it starts, 0..=1.
    pub from_s: f64,
    /// Where it ends, 0..=1.
    pub to_s: f64,
    /// Where line and mode are closest.
    pub closest_s: f64,
    /// |f_exc − f_r| / f_r at `closest_s`.
    pub separation: f64,
    /// What the mode alone moves the tool tip at resonance, at `closest_s`, in its strongest
    /// direction, m/N.
    pub tip_response_m_per_n: f64,
    /// Share of the mode's strain energy in each elastic coordinate at `closest_s`.
    pub strain_energy_shares: Vec<f64>,
    /// Whether the two coordinates with the largest shares turn together or against each other.
    pub leading_turn_together: Option<bool>,
    /// First line of the file (job or program) among those run between `from_s` and `to_s`, counted
    /// from 1.
    pub from_line: usize,
    /// Last line among them.
    pub to_line: usize,
}

/// The arm at one point of the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Share of the operation's time, 0..=1.
    pub s: f64,
    /// Joint positions, rad or m.
    pub joints: Vec<f64>,
    /// β1 of the two-link model, where the robot defines it, rad.
    pub beta1_rad: Option<f64>,
    /// β2, rad.
    pub beta2_rad: Option<f64>,
    /// Spindle speed, rev/min; zero where the program has stopped the spindle.
    pub rpm: f64,
    /// Ascending, Hz.
    pub natural_frequencies_hz: Vec<f64>,
    /// Per mode, what it alone moves the tool tip at resonance, m/N.
    pub tip_response_m_per_n: Vec<f64>,
    /// Per mode, the number of the family that it belongs to: the index that the mode had at s = 0,
    /// followed along the path by shape. `None` where a family could not be followed.
    pub families: Vec<Option<usize>>,
}

/// A place where two neighbouring modes change places in the order of frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeExchange {
    /// Where.
    pub s: f64,
    /// The lower of the two, counted from 1.
    pub lower_mode: usize,
}

/// The place where some line comes nearest to some mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// Index of the mode in ascending frequency, counted from 1.
    pub mode: usize,
    /// The line.
    pub line: ExcitationLine,
    /// Where, 0..=1.
    pub s: f64,
    /// Spindle speed there, rev/min.
    pub rpm: f64,
    /// The line's frequency there, Hz.
    pub excitation_hz: f64,
    /// The mode's frequency there, Hz.
    pub natural_frequency_hz: f64,
    /// |f_exc − f_r| / f_r there.
    pub separation: f64,
}

/// What the policy leaves out: a verdict says nothing about it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// Lines that lie in ignored bands all along the path.
    pub lines: Vec<ExcitationLine>,
    /// Modes that nowhere move the tool tip enough to count, counted from 1.
    pub modes: Vec<usize>,
}

impl LeftOut {
    /// Whether everything was considered.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty() && self.modes.is_empty()
    }
}

/// What a check finds for one operation.
#[derive(Debug, Clone, PartialEq)]
pub struct OperationRisk {
    /// Name of the operation.
    pub name: String,
    /// The worst of the crossings.
    pub verdict: Verdict,
    /// Programmed spindle speed at s = 0, rev/min.
    pub spindle_rpm: f64,
    /// Time from s = 0 to s = 1, s.
    pub duration_s: f64,
    /// The lines that were looked at, ascending.
    pub lines: Vec<ExcitationLine>,
    /// The closest approach of any line to any mode among the samples; `None` where no line and no
    /// mode count.
    pub closest: Option<Approach>,
    /// Which of the lines and modes do not count.
    pub left_out: LeftOut,
    /// Poses at which the eigenproblem was solved to find the crossings.
    pub poses_solved: usize,
    /// The arm along the path, ascending in s: at every pose that was looked at, or, beyond 5000 of
    /// them, at so many that neighbours are no more than 1/2000 apart in s.
    pub samples: Vec<Sample>,
    /// Ascending in `from_s`, then mode, then line.
    pub crossings: Vec<Crossing>,
    /// Where modes change places.
    pub exchanges: Vec<ModeExchange>,
}

/// What a check finds for one job.
#[derive(Debug, Clone, PartialEq)]
pub struct JobRisk {
    /// The worst of the operations.
    pub verdict: Verdict,
    /// Whether the model was ever compared with measured frequencies.
    pub calibrated: bool,
    /// What the model may be wrong by, as a share of each frequency.
    pub model_uncertainty: f64,
    /// Half width of the bands, as a share of each frequency.
    pub separation: f64,
    /// Names of the elastic coordinates, in the order of `strain_energy_shares`.
    pub coordinates: Vec<String>,
    /// One per operation, in order.
    pub operations: Vec<OperationRisk>,
    /// Remarks that change no verdict, in the order of the operations.
    pub notices: Vec<Note>,
}
