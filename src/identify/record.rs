//! Records of vibration as plain data, in SI where their units are known.

use nalgebra::Complex;

use super::pose::{JointColumn, Pose};

/// What a channel measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// m inside.
    Displacement,
    /// m/s inside.
    Velocity,
    /// m/s² inside.
    Acceleration,
    /// N inside.
    Force,
    /// Values as they were read.
    Unknown,
}

impl Quantity {
    /// How many times the displacement was differentiated; `None` where that is not known.
    pub fn derivatives(self) -> Option<i32> {
        match self {
            Self::Displacement => Some(0),
            Self::Velocity => Some(1),
            Self::Acceleration => Some(2),
            Self::Force | Self::Unknown => None,
        }
    }

    /// Its SI unit; empty where the quantity is not known.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Displacement => "m",
            Self::Velocity => "m/s",
            Self::Acceleration => "m/s²",
            Self::Force => "N",
            Self::Unknown => "",
        }
    }
}

/// One channel over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name in the file.
    pub name: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Values at equal steps of time, SI where the quantity is known.
    pub samples: Vec<f64>,
}

/// A measured frequency response function: response over force.
#[derive(Debug, Clone, PartialEq)]
pub struct Frf {
    /// Name of the response.
    pub name: String,
    /// Name of the point that was excited, with its direction.
    pub reference: String,
    /// What the response measures; the excitation is a force.
    pub quantity: Quantity,
    /// Frequencies, Hz, ascending, positive.
    pub frequencies_hz: Vec<f64>,
    /// Values, SI where the quantity is known.
    pub values: Vec<Complex<f64>>,
}

/// What a file of raw data holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Data {
    /// Channels sampled together; all have the same length.
    Time {
        /// Samples per second.
        sample_rate_hz: f64,
        /// The force, if it was measured.
        excitation: Option<Channel>,
        /// What the arm did.
        responses: Vec<Channel>,
    },
    /// Channels sampled together at times that are not even, as telephones have them.
    Uneven {
        /// When, s, rising; as many as each channel has samples.
        times_s: Vec<f64>,
        /// The force, if it was measured.
        excitation: Option<Channel>,
        /// What the arm did.
        responses: Vec<Channel>,
    },
    /// Frequency responses that the measuring instrument made.
    Responses(Vec<Frf>),
}

impl Data {
    /// Samples per second, the mean of them where they are uneven; `None` for frequency responses.
    pub fn sample_rate_hz(&self) -> Option<f64> {
        match self {
            Self::Time { sample_rate_hz, .. } => Some(*sample_rate_hz),
            Self::Uneven { times_s, .. } => mean_rate_hz(times_s),
            Self::Responses(_) => None,
        }
    }
}

/// Samples per second over all of the times; `None` where they do not rise.
pub fn mean_rate_hz(times_s: &[f64]) -> Option<f64> {
    let [first, .., last] = times_s else { return None };
    let rate = (times_s.len() - 1) as f64 / (last - first);
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// A marked point on a link, as the camera sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Where it is in the picture, m.
    pub at_m: [f64; 2],
    /// Names of the channels of its displacement along x and y; `None` for a point that is known to
    /// stand still.
    pub channels: Option<[String; 2]>,
}

/// The marked points of one link.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkedLink {
    /// Name of the link.
    pub link: String,
    /// Two or more points.
    pub markers: Vec<Marker>,
}

/// One record: its data, and what is known beside them.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// What the record is called: its file, as the session names it.
    pub name: String,
    /// The samples or functions.
    pub data: Data,
    /// Response at the point and in the direction of the force: it makes shapes mass-normalised.
    pub driving_point: Option<String>,
    /// Links with marked points.
    pub links: Vec<MarkedLink>,
    /// Spindle speed while it was taken, rev/min.
    pub spindle_rpm: Option<f64>,
    /// What the instrument did to it.
    pub instrument: Instrument,
}

/// What an instrument did to a record that is no doing of the arm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Instrument {
    /// Time constant of the exponential window over the responses, s.
    pub exponential_window_s: Option<f64>,
    /// By how much the responses are late against the force, s.
    pub response_delay_s: f64,
}

/// What a measurement may depend on beside the pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Conditions {
    /// Temperature, °C.
    pub temperature_c: Option<f64>,
    /// Joint-torque scale of the excitation, as the user defines it.
    pub amplitude_nm: Option<f64>,
    /// Mass carried, kg.
    pub payload_kg: Option<f64>,
    /// Masses added at the centres of mass of links, by name, kg.
    pub added_kg: Vec<(String, f64)>,
}

/// A record with the pose and the conditions under which it was taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// The record.
    pub record: Record,
    /// Where the robot stood.
    pub pose: Pose,
    /// The conditions.
    pub conditions: Conditions,
    /// What the user calls the measurement.
    pub id: Option<String>,
}

/// What modes are looked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Asked {
    /// Frequencies to look at, Hz; chosen from each record where absent.
    pub band_hz: Option<[f64; 2]>,
    /// Mains frequencies, Hz: modes at their harmonics are suspected.
    pub mains_hz: Vec<f64>,
    /// Highest order of the stabilisation diagram; half of it is the most poles of a fit.
    pub max_order: Option<usize>,
    /// The most prominent modes alone, so many of them.
    pub modes: Option<usize>,
    /// The modes nearest to these frequencies alone, Hz; all of them where empty.
    pub near_hz: Vec<f64>,
}

/// All that a session holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// What modes are looked for in its records.
    pub asked: Asked,
    /// Columns of the joints in the table of modes, base to tip, where the session names them.
    pub joint_columns: Option<Vec<JointColumn>>,
    /// The records in the order of the file.
    pub records: Vec<Measurement>,
}
