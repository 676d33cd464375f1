//! Static deflections as CSV.

use crate::report::words::csv_field;
use crate::study::deflection::{Deflection, Deflections};
use crate::units::{um_from_m, um_per_n_from_m_per_n};

const AXES: [&str; 3] = ["x", "y", "z"];

/// One row a pose, numbers with as many digits as bring them back exactly; blank where a force is
/// not known.
pub fn deflection_csv(found: &Deflections) -> String {
    let has_path = found.rows.iter().any(|row| row.s.is_some());
    let mut titles: Vec<String> = Vec::new();
    if has_path {
        titles.extend(["operation", "s"].map(str::to_owned));
    }
    let joint = |(name, turns): &(String, bool)| {
        csv_field(&format!("{name}_{}", if *turns { "rad" } else { "m" }))
    };
    titles.extend(found.joints.iter().map(joint));
    for (what, unit) in [("gravity", "um"), ("force", "n"), ("moment", "nm"), ("deflection", "um")]
    {
        titles.extend(AXES.map(|axis| format!("{what}_{axis}_{unit}")));
    }
    if has_path {
        titles.extend(["feed", "across", "axial"].map(|axis| format!("in_tool_{axis}_um")));
    }
    for i in 1..=3 {
        titles.push(format!("compliance{i}_um_per_n"));
        titles.extend(AXES.map(|axis| format!("direction{i}_{axis}")));
    }
    let mut out = titles.join(",") + "\n";
    for row in &found.rows {
        out += &cells(row, has_path).join(",");
        out.push('\n');
    }
    out
}

fn cells(row: &Deflection, has_path: bool) -> Vec<String> {
    let three = |values: Option<[f64; 3]>, by: fn(f64) -> f64| {
        let blank = || [(); 3].map(|()| String::new());
        values.map_or_else(blank, |values| values.map(|value| by(value).to_string()))
    };
    let mut cells = Vec::new();
    if has_path {
        cells.push(csv_field(row.operation.as_deref().unwrap_or_default()));
        cells.push(row.s.map_or_else(String::new, |s| s.to_string()));
    }
    cells.extend(row.joints.iter().map(f64::to_string));
    cells.extend(three(Some(row.gravity_m), um_from_m));
    cells.extend(three(row.force_n, std::convert::identity));
    cells.extend(three(row.moment_nm, std::convert::identity));
    cells.extend(three(row.deflection_m, um_from_m));
    if has_path {
        cells.extend(three(row.in_tool_m, um_from_m));
    }
    for axis in &row.principal {
        cells.push(um_per_n_from_m_per_n(axis.compliance_m_per_n).to_string());
        cells.extend(axis.direction.map(|part| part.to_string()));
    }
    cells
}
