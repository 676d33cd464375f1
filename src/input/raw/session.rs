//! session.yaml as it is written.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

/// Raw records of vibration, to be turned into measured modes.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune session.yaml")]
pub(in crate::input) struct Session {
    /// Free text.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) note: Option<String>,
    /// Sampling rate, Hz, where the files state none.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [140]))]
    pub(in crate::input) sample_rate_hz: Option<f64>,
    /// Column of a table, or variable of a .mat, that is time, in seconds or in the unit (ms, us)
    /// that its name ends in; t or time if absent.
    #[schemars(extend("examples" = ["stamp_ms"]))]
    pub(in crate::input) time: Option<String>,
    /// Lowest and highest frequency to look at, Hz; chosen from each record if absent.
    #[schemars(extend("examples" = [[5, 70]]))]
    pub(in crate::input) band_hz: Option<[f64; 2]>,
    /// Highest order of the stabilisation diagram, and twice the most modes of a band; 48 if
    /// absent.
    #[schemars(extend("minimum" = 2, "maximum" = 96, "examples" = [24]))]
    pub(in crate::input) max_order: Option<u32>,
    /// Report the most prominent modes alone, so many of them.
    #[schemars(extend("minimum" = 1, "examples" = [2]))]
    pub(in crate::input) modes: Option<u32>,
    /// Report the modes nearest to these frequencies alone, Hz, each within 5 %.
    #[schemars(extend("minItems" = 1, "examples" = [[23, 39]]))]
    pub(in crate::input) near_hz: Option<Vec<f64>>,
    /// Frequencies of the mains whose multiples are flagged, Hz; [50, 60] if absent, [] for none.
    #[schemars(extend("default" = [50, 60]))]
    pub(in crate::input) mains_hz: Option<Vec<f64>>,
    /// Names of the moving joints from base to tip, for the columns of the table; joint_1, joint_2,
    /// … if absent.
    #[schemars(extend("minItems" = 1, "examples" = [["joint_1", "joint_2"]]))]
    pub(in crate::input) joint_names: Option<Vec<String>>,
    /// Time constant τ of the exponential window e^(-t/τ) that was laid over the responses, s: its
    /// share of the damping is taken off. With the end value p after T seconds it is T/ln(1/p).
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [0.4]))]
    pub(in crate::input) exponential_window_s: Option<f64>,
    /// By how much the responses are late against the force, s, as filters and wireless sensors
    /// make them; negative where they are early.
    #[schemars(extend("minimum" = -0.5, "maximum" = 0.5, "examples" = [0.002]))]
    pub(in crate::input) response_delay_s: Option<f64>,
    /// By channel name: its unit and scale, where the files do not state them.
    pub(in crate::input) channels: Option<BTreeMap<String, Channel>>,
    /// By link name: points of it that are marked in the picture, two or more; for records without
    /// their own.
    #[schemars(extend("examples" = [{"link_1": [
        {"at_mm": [0, 0]},
        {"at_mm": [-237, 411], "x": "bx_mm", "y": "by_mm"}
    ]}]))]
    pub(in crate::input) markers: Option<BTreeMap<String, Vec<Marker>>>,
    /// The records.
    #[schemars(required, extend("minItems" = 1))]
    pub(in crate::input) records: Option<Vec<Record>>,
}

/// What a channel's values mean.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "channel"))]
pub(in crate::input) struct Channel {
    /// One of m, mm, um, m/s, mm/s, m/s2, mm/s2, g, N, kN.
    #[schemars(extend("examples" = ["mm"]))]
    pub(in crate::input) unit: Option<String>,
    /// What one of the file's units is in `unit`: full scale for WAV; 1 if absent.
    pub(in crate::input) scale: Option<f64>,
}

/// A point of a link in the picture. Without channels it stands still, such as the first joint's
/// axis.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Marker {
    /// Where it is in the picture, mm.
    #[schemars(required, extend("examples" = [[-237, 411]]))]
    pub(in crate::input) at_mm: Option<[f64; 2]>,
    /// Channel of its displacement along x.
    #[schemars(extend("examples" = ["bx_mm"]))]
    pub(in crate::input) x: Option<String>,
    /// Channel of its displacement along y.
    #[schemars(extend("examples" = ["by_mm"]))]
    pub(in crate::input) y: Option<String>,
}

/// One file of raw data.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "record"))]
pub(in crate::input) struct Record {
    /// CSV with a header, UFF 58 (.uff, .unv), WAV, NumPy's .npy or MATLAB's .mat (to
    /// version 7), relative to this file.
    #[schemars(required, extend("examples" = ["pose01.csv"]))]
    pub(in crate::input) file: Option<String>,
    /// What the measurement is called in the table.
    pub(in crate::input) id: Option<String>,
    /// Where the robot stood: joints_deg, or beta2_rad with beta1_rad where it is known.
    #[schemars(required)]
    pub(in crate::input) pose: Option<Pose>,
    /// Channel that holds the excitation, or its UFF reference; absent for free decay, output only.
    #[schemars(extend("examples" = ["hammer"]))]
    pub(in crate::input) excitation: Option<String>,
    /// Channels that hold the responses; all but the excitation if absent.
    #[schemars(extend("minItems" = 1, "examples" = [["x_mm", "y_mm"]]))]
    pub(in crate::input) responses: Option<Vec<String>>,
    /// The response at the point and in the direction of the force, which makes shapes
    /// mass-normalised.
    pub(in crate::input) driving_point: Option<String>,
    /// Marked points as in the session, where they are in this record's picture.
    pub(in crate::input) markers: Option<BTreeMap<String, Vec<Marker>>>,
    /// Sampling rate of this record, Hz, where its file states none.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::input) sample_rate_hz: Option<f64>,
    /// Column or variable of this record that is time.
    #[schemars(extend("examples" = ["stamp_ms"]))]
    pub(in crate::input) time: Option<String>,
    /// Time constant of the exponential window over this record, s; that of the session if absent.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::input) exponential_window_s: Option<f64>,
    /// By how much the responses of this record are late, s; that of the session if absent.
    #[schemars(extend("minimum" = -0.5, "maximum" = 0.5))]
    pub(in crate::input) response_delay_s: Option<f64>,
    /// Spindle speed during the record, rev/min: its harmonics are flagged.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::input) spindle_rpm: Option<f64>,
    /// Temperature, °C.
    pub(in crate::input) temperature_c: Option<f64>,
    /// Joint-torque scale of the excitation, N·m.
    #[schemars(extend("minimum" = 0))]
    pub(in crate::input) amplitude_nm: Option<f64>,
    /// Mass carried, kg.
    #[schemars(extend("minimum" = 0))]
    pub(in crate::input) payload_kg: Option<f64>,
    /// Masses added at the centres of mass of links, by link, kg.
    #[schemars(extend("additionalProperties" = {"type": "number", "minimum": 0}))]
    pub(in crate::input) added_mass_kg: Option<BTreeMap<String, f64>>,
}

/// A pose: `joints_deg`, or angles of the two-link model.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Pose {
    /// The angle β1 of the two-link model, rad, beside beta2_rad; not known if absent.
    #[schemars(extend("examples" = [2.094]))]
    pub(in crate::input) beta1_rad: Option<f64>,
    /// The angle β2 of the two-link model, rad.
    #[schemars(extend("examples" = [1.571]))]
    pub(in crate::input) beta2_rad: Option<f64>,
    /// One value for each moving joint from base to tip: degrees, millimetres for a prismatic
    /// joint.
    #[schemars(extend("minItems" = 1))]
    pub(in crate::input) joints_deg: Option<Vec<f64>>,
}
