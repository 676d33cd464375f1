//! A map as CSV.

use crate::map::{Block, Head, JointColumn};
use crate::report::words::csv_field;
use crate::units::percent_from_ratio;

/// The header line of a map as CSV.
pub(super) fn header(head: &Head, is_nonlinear: bool) -> String {
    let mut columns: Vec<String> = titles(head).iter().map(|title| csv_field(title)).collect();
    if is_nonlinear {
        for r in 1..=head.coordinates.len() {
            columns.push(format!("f{r}_linear_hz"));
            columns.push(format!("f{r}_departure_percent"));
        }
        columns.push("energy_drift".into());
    }
    columns.join(",") + "\n"
}

/// Titles of the columns of a linear map: pose, frequencies, their intervals, and mode shapes.
pub(super) fn titles(head: &Head) -> Vec<String> {
    let modes = (1..=head.coordinates.len()).map(|r| format!("f{r}_hz"));
    let intervals = (1..=if head.has_intervals { head.coordinates.len() } else { 0 })
        .flat_map(|r| ["lo", "hi"].map(|end| format!("f{r}_{end}95_hz")));
    pose_titles(head).chain(modes).chain(intervals).chain(shape_titles(head)).collect()
}

/// Titles of the columns of the mode shapes, mode by mode.
fn shape_titles(head: &Head) -> Vec<String> {
    let Some(links) = &head.shape_links else { return Vec::new() };
    let of_mode = |r: usize| {
        let phi = head.coordinates.iter().map(move |name| format!("phi{r}_{name}"));
        let turns = links
            .iter()
            .flat_map(move |link| ["x", "y", "z"].map(|axis| format!("phi{r}_{link}_{axis}")));
        let strain = head.coordinates.iter().map(move |name| format!("strain{r}_{name}"));
        phi.chain(turns).chain(strain)
    };
    (1..=head.coordinates.len()).flat_map(of_mode).collect()
}

/// Titles of the columns of the pose.
pub(super) fn pose_titles(head: &Head) -> impl Iterator<Item = String> {
    let title =
        |joint: &JointColumn| format!("{}_{}", joint.name, if joint.turns { "rad" } else { "m" });
    let beta2 = head.has_beta2.then(|| "beta2_rad".to_owned());
    head.joints.iter().map(title).chain(beta2)
}

/// The rows of a block, appended to `out`: each number with as many digits as bring it back
/// exactly.
pub(super) fn append(block: &Block, out: &mut Vec<u8>) {
    let mut buffer = zmij::Buffer::new();
    let mut number = |value: f64, out: &mut Vec<u8>| {
        if !value.is_nan() {
            out.extend_from_slice(buffer.format(value).as_bytes());
        }
    };
    for row in block.rows() {
        let mut is_first = true;
        for &value in
            row.joints.iter().chain(row.beta2_rad).chain(row.frequencies_hz).chain(row.intervals_hz)
        {
            if !is_first {
                out.push(b',');
            }
            is_first = false;
            number(value, out);
        }
        for shape in row.mode_shapes() {
            let turns = shape.link_rotations.as_flattened();
            for &value in shape.phi.iter().chain(turns).chain(shape.strain_energy_shares) {
                out.push(b',');
                number(value, out);
            }
        }
        if let Some(nonlinear) = row.nonlinear {
            for (&linear, departure) in nonlinear.linear_hz.iter().zip(&nonlinear.departures) {
                out.push(b',');
                number(linear, out);
                out.push(b',');
                number(departure.map_or(f64::NAN, percent_from_ratio), out);
            }
            out.push(b',');
            number(nonlinear.energy_drift, out);
        }
        out.push(b'\n');
    }
}
