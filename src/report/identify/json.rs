//! The output `identification/1`: everything that was found, for programs. Every number is written
//! with all digits of a double; a number that is not finite is refused.

use nalgebra::Complex;
use schemars::JsonSchema;
use serde::Serialize;

use super::{degrees_or_mm, kind_words, record_and_channel, sense_words, shape_words};
use crate::identify::Stability;
use crate::identify::mode::Mode;
use crate::identify::pose::{JointColumn, Pose};
use crate::identify::record_modes::IdentifiedRecord;
use crate::identify::session::{IdentifiedSession, PoseModes};
use crate::notes::Note;
use crate::report::json::{NotFinite, Number, laid_out};
use crate::units::percent_from_ratio;

/// Poses, records and their parts stand on lines of their own; parts of a mode do not.
const MAX_SPREAD_DEPTH: usize = 4;

/// What `detune identify --format json` writes.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune identification/1")]
pub(in crate::report) struct Identification<'a> {
    schema: SchemaName,
    /// One entry for each pose and its conditions: what the table of modes has.
    poses: Vec<JsonPose<'a>>,
    /// One entry for each record, in the order of the session.
    records: Vec<JsonRecord<'a>>,
    /// Warnings about several records.
    notices: Vec<JsonNotice<'a>>,
}

/// Name and version of this format.
#[derive(Debug, Serialize, JsonSchema)]
enum SchemaName {
    #[serde(rename = "identification/1")]
    Identification1,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonPose<'a> {
    /// The angle of the two-link model, rad, where the session gives it.
    #[serde(skip_serializing_if = "Option::is_none")]
    beta2_rad: Option<Number>,
    /// From base to tip: degrees, millimetres for a joint that slides, where the session gives
    /// them.
    #[serde(skip_serializing_if = "Option::is_none")]
    joints_deg: Option<Vec<Number>>,
    /// Names of the measurements, joined by '+'.
    id: Option<&'a str>,
    /// Samples per second; null for given frequency responses.
    sample_rate_hz: Option<Number>,
    temperature_c: Option<Number>,
    amplitude_nm: Option<Number>,
    payload_kg: Option<Number>,
    /// By ascending frequency, merged over the records of the pose.
    modes: Vec<JsonPoseMode>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonPoseMode {
    frequency_hz: Number,
    /// Standard deviation, Hz.
    frequency_std_hz: Number,
    damping_ratio: Number,
    /// Standard deviation.
    damping_ratio_std: Number,
    /// What else it may be, as the code of a notice: such a mode stays out of the table.
    suspicion: Option<&'static str>,
    /// Record and mode of it, counted from 0.
    members: Vec<[usize; 2]>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonRecord<'a> {
    /// The file, as the session names it.
    record: &'a str,
    /// How the arm was excited: hammer test, steady excitation, free decay, given frequency
    /// responses.
    kind: &'static str,
    /// Hits or stretches that were averaged for coherence.
    averages: Option<usize>,
    /// By ascending frequency.
    modes: Vec<JsonMode<'a>>,
    /// Poles of the linear least squares by order.
    stabilisation: Vec<JsonPoint>,
    /// Warnings about the record.
    notices: Vec<JsonNotice<'a>>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonMode<'a> {
    frequency_hz: Number,
    /// Standard deviation, Hz.
    frequency_std_hz: Number,
    damping_ratio: Number,
    /// Standard deviation.
    damping_ratio_std: Number,
    /// Free decays: displacement of the shape's largest part when the strongest decay begins, m (or
    /// the channel's unit).
    amplitude: Option<Number>,
    /// Where the frequency depends on amplitude: how much higher it is where the arm swings most,
    /// percent; the frequency given is that of small amplitudes.
    #[serde(skip_serializing_if = "Option::is_none")]
    drift_percent: Option<Number>,
    /// Lowest coherence of all responses at the mode, where several hits or stretches were
    /// averaged.
    coherence: Option<Number>,
    /// Fraction of the orders of the stabilisation diagram that have this pole.
    support: Number,
    /// What else it may be, as the code of a notice.
    suspicion: Option<&'static str>,
    /// The shape in words.
    in_words: String,
    /// One entry a response.
    shape: Vec<JsonShapePart<'a>>,
    /// One entry a link with marked points.
    links: Vec<JsonLink<'a>>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonShapePart<'a> {
    response: &'a str,
    /// Displacement relative to the largest part, which is 1.
    re: Number,
    im: Number,
    /// Standard deviation of both.
    std: Number,
    /// φ_response·φ_reference, 1/kg, where a force was measured: real and imaginary part.
    #[serde(skip_serializing_if = "Option::is_none")]
    modal_constant: Option<[Number; 2]>,
    /// Mass-normalised, 1/√kg, where the driving point is known: real and imaginary part.
    #[serde(skip_serializing_if = "Option::is_none")]
    mass_normalised: Option<[Number; 2]>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonLink<'a> {
    link: &'a str,
    /// Rotation per unit of the shape, rad: real and imaginary part.
    rotation_rad: [Number; 2],
    /// Standard deviation of both.
    std_rad: Number,
    /// Amplitude when the strongest decay begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    amplitude_rad: Option<Number>,
    /// Relative to the first link that turns: together, against, unclear.
    sense: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonPoint {
    order: usize,
    frequency_hz: Number,
    damping_ratio: Number,
    /// Compared with the next lower order: new, frequency, pole.
    stable: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonNotice<'a> {
    /// Kind of the warning.
    code: &'static str,
    record: Option<&'a str>,
    channel: Option<&'a str>,
    /// In words.
    what: &'a str,
}

/// The modes of a session.
///
/// # Errors
/// If a number is not finite, which would be a fault of the program.
pub fn identification_json(found: &IdentifiedSession) -> Result<String, NotFinite> {
    let all = Identification {
        schema: SchemaName::Identification1,
        poses: found.poses.iter().map(|at| pose(at, found.joint_columns.as_deref())).collect(),
        records: found.records.iter().map(record).collect(),
        notices: found.notes.iter().map(notice).collect(),
    };
    laid_out(&all, MAX_SPREAD_DEPTH)
}

fn pose<'a>(row: &'a PoseModes, named: Option<&[JointColumn]>) -> JsonPose<'a> {
    let (beta2_rad, joints_deg) = match &row.pose {
        Pose::Beta2(beta2) => (Some(Number(*beta2)), None),
        Pose::Joints(joints) => {
            (None, Some(degrees_or_mm(joints, named).into_iter().map(Number).collect()))
        }
    };
    JsonPose {
        beta2_rad,
        joints_deg,
        id: row.id.as_deref(),
        sample_rate_hz: row.sample_rate_hz.map(Number),
        temperature_c: row.conditions.temperature_c.map(Number),
        amplitude_nm: row.conditions.amplitude_nm.map(Number),
        payload_kg: row.conditions.payload_kg.map(Number),
        modes: row
            .modes
            .iter()
            .map(|mode| JsonPoseMode {
                frequency_hz: Number(mode.frequency_hz),
                frequency_std_hz: Number(mode.frequency_std_hz),
                damping_ratio: Number(mode.damping_ratio),
                damping_ratio_std: Number(mode.damping_std),
                suspicion: mode.suspicion.map(|code| code.name()),
                members: mode.members.iter().map(|&(record, mode)| [record, mode]).collect(),
            })
            .collect(),
    }
}

fn record(found: &IdentifiedRecord) -> JsonRecord<'_> {
    JsonRecord {
        record: &found.name,
        kind: kind_words(found.kind),
        averages: found.averaged.as_ref().map(|averaged| averaged.averages),
        modes: found.modes.iter().map(mode).collect(),
        stabilisation: found
            .stabilisation
            .iter()
            .map(|point| JsonPoint {
                order: point.order,
                frequency_hz: Number(point.frequency_hz),
                damping_ratio: Number(point.damping_ratio),
                stable: match point.stability {
                    Stability::New => "new",
                    Stability::Frequency => "frequency",
                    Stability::Pole => "pole",
                },
            })
            .collect(),
        notices: found.notes.iter().map(notice).collect(),
    }
}

fn mode(mode: &Mode) -> JsonMode<'_> {
    let parts = |value: Complex<f64>| [Number(value.re), Number(value.im)];
    JsonMode {
        frequency_hz: Number(mode.frequency_hz),
        frequency_std_hz: Number(mode.frequency_std_hz),
        damping_ratio: Number(mode.damping_ratio),
        damping_ratio_std: Number(mode.damping_std),
        amplitude: mode.amplitude.map(Number),
        drift_percent: mode.drift.map(|drift| Number(percent_from_ratio(drift))),
        coherence: mode.coherence.map(Number),
        support: Number(mode.support),
        suspicion: mode.suspicion.map(|code| code.name()),
        in_words: shape_words(mode),
        shape: mode
            .shape
            .iter()
            .map(|part| JsonShapePart {
                response: &part.response,
                re: Number(part.value.re),
                im: Number(part.value.im),
                std: Number(part.std),
                modal_constant: part.modal_constant.map(parts),
                mass_normalised: part.mass_normalised.map(parts),
            })
            .collect(),
        links: mode
            .links
            .iter()
            .map(|link| JsonLink {
                link: &link.link,
                rotation_rad: parts(link.rotation),
                std_rad: Number(link.std),
                amplitude_rad: link.amplitude_rad.map(Number),
                sense: sense_words(link.sense),
            })
            .collect(),
    }
}

fn notice(note: &Note) -> JsonNotice<'_> {
    let (record, channel) = record_and_channel(note);
    JsonNotice { code: note.code.name(), record, channel, what: &note.what }
}
