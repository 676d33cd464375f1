//! A map as CSV, JSON, NumPy's .npy, Apache Arrow, SVG, and as a page.

#[cfg(feature = "arrow")]
mod arrow;
mod html;
mod json;
mod plot;
mod reduced;
mod reduced_plot;
mod series;
mod sketch;
mod table;

use std::io;

#[cfg(feature = "arrow")]
use arrow_schema::SchemaRef;
pub use html::{map_html, reduced_html};
pub use plot::map_drawing;
pub use reduced::{reduced_csv, reduced_json};
pub use reduced_plot::reduced_drawing;
pub use sketch::sketch_json;

use crate::formats::npy::Layout;
use crate::map::{Block, Head};

/// How the poses of a map are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapFormat {
    /// Each number with as many digits as bring it back exactly; blank where a record does not show
    /// the mode.
    Csv,
    /// The vibrations themselves as CSV, one row per sample; nonlinear maps.
    Series,
    /// `map/1`.
    Json,
    /// NumPy's array of the frequencies alone, one row a pose; linear maps.
    Npy,
    /// An Apache Arrow stream with the columns of the CSV; linear maps.
    #[cfg(feature = "arrow")]
    Arrow,
}

/// Writes a map block by block: [`Self::start`], each [`Self::block`], [`Self::end`].
#[derive(Debug)]
pub struct MapWriter<'a> {
    format: MapFormat,
    head: &'a Head,
    is_nonlinear: bool,
    #[cfg(feature = "arrow")]
    schema: SchemaRef,
}

impl<'a> MapWriter<'a> {
    /// A writer of maps of a robot.
    pub fn new(format: MapFormat, head: &'a Head, is_nonlinear: bool) -> Self {
        Self {
            format,
            head,
            is_nonlinear,
            #[cfg(feature = "arrow")]
            schema: arrow::schema(head),
        }
    }

    /// What stands before the first block. `poses` counts those of all blocks; only .npy needs it.
    ///
    /// # Errors
    /// The serialiser's, which has no cause of its own to fail.
    pub fn start(&self, poses: usize) -> io::Result<Vec<u8>> {
        Ok(match self.format {
            MapFormat::Csv => table::header(self.head, self.is_nonlinear).into_bytes(),
            MapFormat::Series => series::header(self.head).into_bytes(),
            MapFormat::Json => json::start(self.head, self.is_nonlinear)?.into_bytes(),
            MapFormat::Npy => Layout::of_rows(poses, self.head.coordinates.len()).header(),
            #[cfg(feature = "arrow")]
            MapFormat::Arrow => arrow::start(&self.schema).map_err(io::Error::other)?,
        })
    }

    /// The poses of a block, appended to `out`.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn block(&self, block: &Block, out: &mut Vec<u8>) -> io::Result<()> {
        match self.format {
            MapFormat::Csv => table::append(block, out),
            MapFormat::Series => series::append(block, out),
            MapFormat::Json => json::append(block, out)?,
            MapFormat::Npy => out.extend(block.frequencies_hz.iter().flat_map(|f| f.to_le_bytes())),
            #[cfg(feature = "arrow")]
            MapFormat::Arrow => {
                arrow::append(&self.schema, block, out).map_err(io::Error::other)?
            }
        }
        Ok(())
    }

    /// Bytes to leave out at the beginning of the first block that has any: what separates it from
    /// a block before.
    pub fn separator(&self) -> usize {
        if self.format == MapFormat::Json { json::SEPARATOR.len() } else { 0 }
    }

    /// What stands behind the last block.
    pub fn end(&self) -> &'static [u8] {
        match self.format {
            MapFormat::Csv | MapFormat::Series | MapFormat::Npy => b"",
            MapFormat::Json => b"\n]}\n",
            #[cfg(feature = "arrow")]
            MapFormat::Arrow => &arrow::END,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_vibration::{Aliased, Doubt, DoubtReason, Measurement, Response, Spectrum};
    use crate::map::JointColumn;
    use crate::units::percent_from_ratio;

    fn head() -> Head {
        Head {
            robot: "arm".into(),
            joints: vec![
                JointColumn { name: "a".into(), turns: true },
                JointColumn { name: "b,c".into(), turns: false },
            ],
            has_beta2: true,
            coordinates: vec!["a".into(), "b,c".into()],
            has_intervals: false,
            coordinate_units: vec!["rad", "m"],
            shape_links: None,
        }
    }

    fn nonlinear() -> Block {
        Block {
            count: 1,
            poses: vec![0.1, -1e-12],
            beta2_rad: vec![0.30000000000000004],
            frequencies_hz: vec![25.5, f64::NAN],
            intervals_hz: vec![],
            shapes: vec![],
            nonlinear: vec![Measurement {
                frequencies_hz: vec![Some(25.5), None],
                linear_hz: vec![25.0, 84.0],
                departures: vec![Some(25.5 / 25.0 - 1.0), None],
                aliased: vec![Aliased { mode: 1, frequency_hz: 84.0, seen_at_hz: 56.0 }],
                doubts: vec![Doubt { mode: 0, reason: DoubtReason::RivalPeak }],
                energy_drift: 1e-9,
                spectrum: Spectrum { bin_hz: 0.2, amplitudes: vec![] },
                response: Response {
                    sample_rate_hz: 8.0,
                    deflections: vec![vec![0.5, -0.25], vec![1e-3, 2e-3]],
                    energy_drift: 1e-9,
                },
            }],
        }
    }

    fn written(format: MapFormat, blocks: &[Block], is_nonlinear: bool) -> Vec<u8> {
        let head = head();
        let writer = MapWriter::new(format, &head, is_nonlinear);
        let mut rows = Vec::new();
        blocks.iter().for_each(|block| writer.block(block, &mut rows).unwrap());
        let mut bytes = writer.start(2).unwrap();
        bytes.extend_from_slice(&rows[writer.separator()..]);
        bytes.extend_from_slice(writer.end());
        bytes
    }

    fn linear() -> Block {
        Block {
            count: 2,
            poses: vec![0.1, -1e-12, 0.30000000000000004, 1e300],
            beta2_rad: vec![0.25, -0.5],
            frequencies_hz: vec![20.5, 123456.789, 1e-5, 2e16],
            intervals_hz: vec![],
            shapes: vec![],
            nonlinear: vec![],
        }
    }

    #[test]
    fn csv_reads_back_exactly() {
        let text = written(MapFormat::Csv, &[nonlinear()], true);
        let mut reader = csv::Reader::from_reader(&text[..]);
        let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        assert_eq!(
            names.join(" "),
            "a_rad b,c_m beta2_rad f1_hz f2_hz f1_linear_hz f1_departure_percent f2_linear_hz \
             f2_departure_percent energy_drift"
        );
        let record = reader.records().next().unwrap().unwrap();
        let values: Vec<Option<f64>> = record.iter().map(|v| v.parse().ok()).collect();
        let expected = [
            Some(0.1),
            Some(-1e-12),
            Some(0.30000000000000004),
            Some(25.5),
            None,
            Some(25.0),
            Some(percent_from_ratio(25.5 / 25.0 - 1.0)),
            Some(84.0),
            None,
            Some(1e-9),
        ];
        assert_eq!(values, expected);

        let text = String::from_utf8(written(MapFormat::Csv, &[linear()], false)).unwrap();
        let rows = text.lines().skip(1).flat_map(|line| line.split(','));
        let read: Vec<f64> = rows.map(|v| v.parse().unwrap()).collect();
        assert_eq!(read[..5], [0.1, -1e-12, 0.25, 20.5, 123456.789]);
        assert_eq!(read[5..], [0.30000000000000004, 1e300, -0.5, 1e-5, 2e16]);
    }

    #[test]
    fn a_series_has_one_row_a_sample() {
        let text = String::from_utf8(written(MapFormat::Series, &[nonlinear()], true)).unwrap();
        let expected = "a_rad,\"b,c_m\",beta2_rad,t_s,alpha_a_rad,\"alpha_b,c_m\"\n\
                        0.1,-1e-12,0.30000000000000004,0.0,0.5,0.001\n\
                        0.1,-1e-12,0.30000000000000004,0.125,-0.25,0.002\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn json_has_the_same_numbers() {
        let blocks = [nonlinear(), nonlinear(), nonlinear()];
        let json: serde_json::Value =
            serde_json::from_slice(&written(MapFormat::Json, &blocks, true)).unwrap();
        assert_eq!(json["schema"], "map/1");
        assert_eq!(json["method"], "nonlinear");
        assert_eq!(json["joints"][1]["unit"], "m");
        assert_eq!(json["rows"].as_array().unwrap().len(), 3);
        let row = &json["rows"][2];
        assert_eq!(row["joints"][1], -1e-12);
        assert_eq!(row["beta2_rad"], 0.30000000000000004);
        assert_eq!(row["natural_frequencies_hz"][0], 25.5);
        assert!(row["natural_frequencies_hz"][1].is_null());
        assert_eq!(row["nonlinear"]["folded"][0]["mode"], 2);
        let doubt = serde_json::json!({"mode": 1, "reason": "rival_peak"});
        assert_eq!(row["nonlinear"]["doubtful"], serde_json::json!([doubt]));

        let json: serde_json::Value =
            serde_json::from_slice(&written(MapFormat::Json, &[linear()], false)).unwrap();
        assert_eq!(json["rows"][1]["natural_frequencies_hz"][1], 2e16);
        assert!(json["rows"][1].get("nonlinear").is_none());
    }
}
