//! For programs.

use nalgebra::Complex;
use serde::Serialize;

use super::{kind_words, sense_words, shape_words};
use crate::measured::Stability;
use crate::measured::identify::{Identified, Mode};
use crate::measured::notice::Notice;
use crate::measured::record::Pose;
use crate::measured::session::{IdentifiedSession, PoseRow};

/// Name of the JSON format.
const SCHEMA: &str = "identification/1";

#[derive(Debug, Serialize)]
struct JsonIdentification<'a> {
    schema: &'static str,
    poses: Vec<JsonPose<'a>>,
    records: Vec<JsonRecord<'a>>,
    notices: Vec<JsonNotice<'a>>,
}

#[derive(Debug, Serialize)]
struct JsonPose<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    beta2_rad: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    joints_deg: Option<&'a [f64]>,
    id: Option<&'a str>,
    sample_rate_hz: Option<f64>,
    temperature_c: Option<f64>,
    amplitude_nm: Option<f64>,
    payload_kg: Option<f64>,
    modes: Vec<JsonPoseMode>,
}

#[derive(Debug, Serialize)]
struct JsonPoseMode {
    frequency_hz: f64,
    frequency_std_hz: f64,
    damping_ratio: f64,
    damping_ratio_std: f64,
    suspicion: Option<&'static str>,
    /// Record and mode of it, counted from 0.
    members: Vec<[usize; 2]>,
}

#[derive(Debug, Serialize)]
struct JsonRecord<'a> {
    record: &'a str,
    kind: &'static str,
    averages: Option<usize>,
    modes: Vec<JsonMode<'a>>,
    stabilisation: Vec<JsonPoint>,
    notices: Vec<JsonNotice<'a>>,
}

#[derive(Debug, Serialize)]
struct JsonMode<'a> {
    frequency_hz: f64,
    frequency_std_hz: f64,
    damping_ratio: f64,
    damping_ratio_std: f64,
    amplitude: Option<f64>,
    coherence: Option<f64>,
    support: f64,
    suspicion: Option<&'static str>,
    in_words: String,
    shape: Vec<JsonShapePart<'a>>,
    links: Vec<JsonLink<'a>>,
}

#[derive(Debug, Serialize)]
struct JsonShapePart<'a> {
    response: &'a str,
    re: f64,
    im: f64,
    std: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    modal_constant: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mass_normalised: Option<[f64; 2]>,
}

#[derive(Debug, Serialize)]
struct JsonLink<'a> {
    link: &'a str,
    rotation_rad: [f64; 2],
    std_rad: f64,
    /// Amplitude when the strongest decay begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    amplitude_rad: Option<f64>,
    sense: &'static str,
}

#[derive(Debug, Serialize)]
struct JsonPoint {
    order: usize,
    frequency_hz: f64,
    damping_ratio: f64,
    stable: &'static str,
}

#[derive(Debug, Serialize)]
struct JsonNotice<'a> {
    code: &'static str,
    record: Option<&'a str>,
    channel: Option<&'a str>,
    what: &'a str,
}

/// The modes of a session.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn identification_json(found: &IdentifiedSession) -> serde_json::Result<String> {
    let all = JsonIdentification {
        schema: SCHEMA,
        poses: found.rows.iter().map(pose).collect(),
        records: found.records.iter().map(record).collect(),
        notices: found.notices.iter().map(notice).collect(),
    };
    Ok(serde_json::to_string_pretty(&all)? + "\n")
}

fn pose(row: &PoseRow) -> JsonPose<'_> {
    let (beta2_rad, joints_deg) = match &row.pose {
        Pose::Beta2Rad(beta2) => (Some(*beta2), None),
        Pose::JointsDeg(joints) => (None, Some(joints.as_slice())),
    };
    JsonPose {
        beta2_rad,
        joints_deg,
        id: row.id.as_deref(),
        sample_rate_hz: row.sample_rate_hz,
        temperature_c: row.conditions.temperature_c,
        amplitude_nm: row.conditions.amplitude_nm,
        payload_kg: row.conditions.payload_kg,
        modes: row
            .modes
            .iter()
            .map(|mode| JsonPoseMode {
                frequency_hz: mode.frequency_hz,
                frequency_std_hz: mode.frequency_std_hz,
                damping_ratio: mode.damping_ratio,
                damping_ratio_std: mode.damping_std,
                suspicion: mode.suspicion.map(|kind| kind.code()),
                members: mode.members.iter().map(|&(record, mode)| [record, mode]).collect(),
            })
            .collect(),
    }
}

fn record(found: &Identified) -> JsonRecord<'_> {
    JsonRecord {
        record: &found.record,
        kind: kind_words(found.kind),
        averages: found.averaged.as_ref().map(|averaged| averaged.averages),
        modes: found.modes.iter().map(mode).collect(),
        stabilisation: found
            .stabilisation
            .iter()
            .map(|point| JsonPoint {
                order: point.order,
                frequency_hz: point.frequency_hz,
                damping_ratio: point.damping_ratio,
                stable: match point.stability {
                    Stability::New => "new",
                    Stability::Frequency => "frequency",
                    Stability::Pole => "pole",
                },
            })
            .collect(),
        notices: found.notices.iter().map(notice).collect(),
    }
}

fn mode(mode: &Mode) -> JsonMode<'_> {
    let parts = |value: Complex<f64>| [value.re, value.im];
    JsonMode {
        frequency_hz: mode.frequency_hz,
        frequency_std_hz: mode.frequency_std_hz,
        damping_ratio: mode.damping_ratio,
        damping_ratio_std: mode.damping_std,
        amplitude: mode.amplitude,
        coherence: mode.coherence,
        support: mode.support,
        suspicion: mode.suspicion.map(|kind| kind.code()),
        in_words: shape_words(mode),
        shape: mode
            .shape
            .iter()
            .map(|part| JsonShapePart {
                response: &part.response,
                re: part.value.re,
                im: part.value.im,
                std: part.std,
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
                std_rad: link.std,
                amplitude_rad: link.amplitude_rad,
                sense: sense_words(link.sense),
            })
            .collect(),
    }
}

fn notice(notice: &Notice) -> JsonNotice<'_> {
    JsonNotice {
        code: notice.kind.code(),
        record: notice.record.as_deref(),
        channel: notice.channel.as_deref(),
        what: &notice.what,
    }
}
