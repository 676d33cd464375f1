//! The vibrations of a nonlinear map as CSV: one row per sample.

use super::table::pose_titles;
use crate::map::{Block, Head};
use crate::report::words::csv_field;

/// The header line: the pose, the time, and the elastic coordinates.
pub(super) fn header(head: &Head) -> String {
    let alpha = head.coordinates.iter().zip(&head.coordinate_units);
    let alpha = alpha.map(|(name, unit)| format!("alpha_{name}_{unit}"));
    let titles = pose_titles(head).chain(["t_s".to_owned()]).chain(alpha);
    titles.map(|title| csv_field(&title)).collect::<Vec<_>>().join(",") + "\n"
}

/// The samples of all poses of a block, appended to `out`.
pub(super) fn append(block: &Block, out: &mut Vec<u8>) {
    let mut buffer = zmij::Buffer::new();
    for row in block.rows() {
        let Some(nonlinear) = row.nonlinear else { continue };
        let response = &nonlinear.response;
        let mut pose = Vec::new();
        for &value in row.joints.iter().chain(row.beta2_rad) {
            pose.extend_from_slice(buffer.format(value).as_bytes());
            pose.push(b',');
        }
        let samples = response.deflections.first().map_or(0, Vec::len);
        for sample in 0..samples {
            out.extend_from_slice(&pose);
            let time_s = sample as f64 / response.sample_rate_hz;
            out.extend_from_slice(buffer.format(time_s).as_bytes());
            for alpha in &response.deflections {
                out.push(b',');
                out.extend_from_slice(buffer.format(alpha[sample]).as_bytes());
            }
            out.push(b'\n');
        }
    }
}
