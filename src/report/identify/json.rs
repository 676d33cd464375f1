//! The output `identification/1`: everything that was found, for programs. Every number is written
//! with all digits of a double; a number that is not finite is refused.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::{degrees_or_mm, kind_words, record_and_channel, shape_words};
use crate::identify::StabilisationPoint;
use crate::identify::links::LinkRotation;
use crate::identify::mode::{Mode, ShapePart};
use crate::identify::pose::{JointColumn, Pose};
use crate::identify::record_modes::IdentifiedRecord;
use crate::identify::session::{IdentifiedSession, PoseMode, PoseModes};
use crate::notes::Note;
use crate::report::json::{NotFinite, laid_out};
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
    /// The angle β1 of the two-link model, rad, where the session gives it.
    #[serde(skip_serializing_if = "Option::is_none")]
    beta1_rad: Option<f64>,
    /// The angle β2 of the two-link model, rad, where the session gives it.
    #[serde(skip_serializing_if = "Option::is_none")]
    beta2_rad: Option<f64>,
    /// From base to tip: degrees, millimetres for a joint that slides, where the session gives
    /// them.
    #[serde(skip_serializing_if = "Option::is_none")]
    joints_deg: Option<Vec<f64>>,
    /// Names of the measurements, joined by '+'.
    id: Option<&'a str>,
    /// Samples per second; null for given frequency responses.
    sample_rate_hz: Option<f64>,
    temperature_c: Option<f64>,
    amplitude_nm: Option<f64>,
    payload_kg: Option<f64>,
    /// Masses added at the centres of mass of links, by link, where the session gives them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    added_mass_kg: BTreeMap<&'a str, f64>,
    /// By ascending frequency, merged over the records of the pose.
    modes: &'a [PoseMode],
    /// Modal assurance criterion of each mode with each of the same pose, over the responses of
    /// both; null of fewer than two.
    mac: Vec<Vec<Option<f64>>>,
    /// The same with each mode of the pose before; absent at the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    mac_with_previous: Option<Vec<Vec<Option<f64>>>>,
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
    stabilisation: &'a [StabilisationPoint],
    /// Warnings about the record.
    notices: Vec<JsonNotice<'a>>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JsonMode<'a> {
    frequency_hz: f64,
    /// Standard deviation, Hz.
    frequency_std_hz: f64,
    damping_ratio: f64,
    /// Standard deviation.
    damping_ratio_std: f64,
    /// Free decays: displacement of the shape's largest part when the strongest decay begins, m (or
    /// the channel's unit).
    amplitude: Option<f64>,
    /// Where the frequency depends on amplitude: how much higher it is at the largest amplitude,
    /// percent; the frequency given is that of small amplitudes.
    #[serde(skip_serializing_if = "Option::is_none")]
    drift_percent: Option<f64>,
    /// Lowest coherence of all responses at the mode, where several hits or stretches were
    /// averaged.
    coherence: Option<f64>,
    /// Fraction of the orders of the stabilisation diagram that have this pole.
    support: f64,
    /// What else it may be, as the code of a notice.
    suspicion: Option<&'static str>,
    /// The shape in words.
    in_words: String,
    /// One entry a response.
    shape: &'a [ShapePart],
    /// One entry a link with marked points.
    links: &'a [LinkRotation],
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
        poses: found
            .poses
            .iter()
            .enumerate()
            .map(|(at, own)| {
                let previous = at.checked_sub(1).map(|before| &found.poses[before]);
                pose(own, previous, found.joint_columns.as_deref())
            })
            .collect(),
        records: found.records.iter().map(record).collect(),
        notices: found.warnings.iter().map(notice).collect(),
    };
    laid_out(&all, MAX_SPREAD_DEPTH)
}

fn pose<'a>(
    row: &'a PoseModes,
    previous: Option<&PoseModes>,
    named: Option<&[JointColumn]>,
) -> JsonPose<'a> {
    let (beta1_rad, beta2_rad, joints_deg) = match &row.pose {
        Pose::Angles { beta1, beta2 } => (*beta1, Some(*beta2), None),
        Pose::Joints(joints) => (None, None, Some(degrees_or_mm(joints, named))),
    };
    JsonPose {
        beta1_rad,
        beta2_rad,
        joints_deg,
        id: row.id.as_deref(),
        sample_rate_hz: row.sample_rate_hz,
        temperature_c: row.conditions.temperature_c,
        amplitude_nm: row.conditions.amplitude_nm,
        payload_kg: row.conditions.payload_kg,
        added_mass_kg: row.conditions.added_kg.iter().map(|(l, m)| (l.as_str(), *m)).collect(),
        modes: &row.modes,
        mac: row.mac(row),
        mac_with_previous: previous.map(|previous| row.mac(previous)),
    }
}

fn record(found: &IdentifiedRecord) -> JsonRecord<'_> {
    JsonRecord {
        record: &found.name,
        kind: kind_words(found.kind),
        averages: found.averaged.as_ref().map(|averaged| averaged.averages),
        modes: found.modes.iter().map(mode).collect(),
        stabilisation: &found.stabilisation,
        notices: found.warnings.iter().map(notice).collect(),
    }
}

fn mode(mode: &Mode) -> JsonMode<'_> {
    JsonMode {
        frequency_hz: mode.frequency_hz,
        frequency_std_hz: mode.frequency_std_hz,
        damping_ratio: mode.damping_ratio,
        damping_ratio_std: mode.damping_std,
        amplitude: mode.amplitude,
        drift_percent: mode.drift.map(percent_from_ratio),
        coherence: mode.coherence,
        support: mode.support,
        suspicion: mode.suspicion.map(|code| code.name()),
        in_words: shape_words(mode),
        shape: &mode.shape,
        links: &mode.links,
    }
}

fn notice(note: &Note) -> JsonNotice<'_> {
    let (record, channel) = record_and_channel(note);
    JsonNotice { code: note.code.name(), record, channel, what: &note.what }
}
