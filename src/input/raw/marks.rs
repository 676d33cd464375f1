//! marks.yaml as it is written.

use schemars::JsonSchema;
use serde::Deserialize;

/// Marks in a video, to be followed.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune marks.yaml")]
pub(in crate::input) struct Marks {
    /// Free text.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) note: Option<String>,
    /// Frames a second at which the video was taken: for folders, and in place of what a
    /// slow-motion file states.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [240]))]
    pub(in crate::input) frame_rate_hz: Option<f64>,
    /// Time from the first to the last row of a frame, ms: the readout of a rolling shutter; all
    /// rows at once if absent.
    #[schemars(extend("minimum" = 0, "examples" = [16]))]
    pub(in crate::input) readout_ms: Option<f64>,
    /// The side of the picture that is read first.
    #[schemars(extend("default" = "top"))]
    pub(in crate::input) readout_from: Option<Side>,
    /// A known distance in the plane of the marks.
    #[schemars(required)]
    pub(in crate::input) scale: Option<Scale>,
    /// The marks, each by its box in the first frame.
    #[schemars(extend("minItems" = 1))]
    pub(in crate::input) marks: Option<Vec<Mark>>,
    /// In place of `marks`: round marks that are found in the first frame.
    pub(in crate::input) round_marks: Option<RoundMarks>,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum Side {
    Top,
    Bottom,
    Left,
    Right,
}

/// A known distance, between two marks or two points.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Scale {
    /// The distance, mm.
    #[schemars(required, extend("exclusiveMinimum" = 0, "examples" = [630]))]
    pub(in crate::input) distance_mm: Option<f64>,
    /// Names of two marks whose middles are that far apart.
    #[schemars(extend("minItems" = 2, "maxItems" = 2, "examples" = [["base", "tip"]]))]
    pub(in crate::input) marks: Option<Vec<String>>,
    /// Two points of the first frame, px from its left and top.
    #[schemars(extend("minItems" = 2, "maxItems" = 2, "examples" = [[[100, 620], [910, 615]]]))]
    pub(in crate::input) points_px: Option<Vec<[f64; 2]>>,
}

/// A mark: anything with detail in both directions.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "mark"))]
pub(in crate::input) struct Mark {
    /// What it is called: its columns are `<name>_x_mm` and `<name>_y_mm`.
    #[schemars(required, extend("examples" = ["tip"]))]
    pub(in crate::input) name: Option<String>,
    /// Its box in the first frame: left, top, width, height, px.
    #[schemars(required, extend("examples" = [[612, 240, 28, 28]]))]
    pub(in crate::input) box_px: Option<[f64; 4]>,
}

/// Round marks, darker or lighter than what is around them.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct RoundMarks {
    /// How many there are; another number is an error.
    #[schemars(required, extend("minimum" = 1, "maximum" = 200, "examples" = [3]))]
    pub(in crate::input) count: Option<u32>,
    /// Their names from left to right; mark_1, mark_2, … if absent.
    #[schemars(extend("minItems" = 1, "examples" = [["base", "elbow", "tip"]]))]
    pub(in crate::input) names: Option<Vec<String>>,
}
