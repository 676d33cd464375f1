//! Static deflections as text: a pose by itself, of several the largest.

use crate::report::words::number;
use crate::study::deflection::{Deflection, Deflections};
use crate::units::{deg_from_rad, mm_from_m, um_from_m, um_per_n_from_m_per_n};
use crate::wording::{printable, wrapped};

/// Components below this share of the largest are rounding.
const ROUNDING: f64 = 1e-9;

/// As text.
pub fn deflection_text(found: &Deflections) -> String {
    let mut out = format!("{}\n", printable(&found.name));
    let mut operations: Vec<Option<&str>> =
        found.rows.iter().map(|row| row.operation.as_deref()).collect();
    operations.dedup();
    for operation in operations {
        let rows = || found.rows.iter().filter(|row| row.operation.as_deref() == operation);
        let size = |row: &&Deflection| row.size_m().unwrap_or(0.0);
        let Some(worst) = rows().max_by(|a, b| size(a).total_cmp(&size(b))) else { continue };
        out.push('\n');
        if let Some(name) = operation {
            wrapped(&mut out, "  ", &format!("operation {}", printable(name)));
        }
        let count = rows().count();
        let which = match (worst.s, count) {
            (Some(s), _) => format!("largest at s = {s}, of {count} places"),
            (None, 1) => "at the pose".to_owned(),
            (None, _) => format!("largest of {count} poses"),
        };
        wrapped(&mut out, "  ", &format!("{which}: {}", pose(found, worst)));
        rows_of(&mut out, worst);
    }
    out
}

fn rows_of(out: &mut String, row: &Deflection) {
    let three = |values: [f64; 3]| components(values.map(um_from_m)).join(", ");
    wrapped(out, "  gravity     ", &format!("[{}] µm", three(row.gravity_m)));
    if let (Some(force), Some(moved), Some(size)) = (row.force_n, row.deflection_m, row.size_m()) {
        let mut load = format!("[{}] N", components(force).join(", "));
        if let Some(moment) = row.moment_nm.filter(|moment| *moment != [0.0; 3]) {
            load += &format!(" and [{}] N m", components(moment).join(", "));
        }
        let size = number(um_from_m(size), 1);
        let line = format!("{load} move the tip by [{}] µm, {size} µm in all", three(moved));
        wrapped(out, "  force       ", &line);
    }
    if let Some(moved) = row.in_tool_m {
        let [feed, across, axial] = components(moved.map(um_from_m));
        let line =
            format!("{feed} µm along the feed, {across} µm across it, {axial} µm out of the work");
        wrapped(out, "  at the tool ", &line);
    }
    for axis in &row.principal {
        let compliance = number(um_per_n_from_m_per_n(axis.compliance_m_per_n), 3);
        let direction = axis.direction.map(cosine).join(", ");
        let line = format!("{compliance} µm/N along [{direction}]");
        wrapped(out, "  compliance  ", &line);
    }
}

/// The components of a vector; what is rounding beside its largest is zero.
fn components(vector: [f64; 3]) -> [String; 3] {
    let largest = vector.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    vector.map(|part| number(if part.abs() < ROUNDING * largest { 0.0 } else { part }, 1))
}

/// An angle or a length below what is shown is zero.
fn position(value: f64) -> String {
    number(if value.abs() < 0.05 { 0.0 } else { value }, 1)
}

/// Without the sign of a negative zero.
fn cosine(part: f64) -> String {
    let shown = format!("{part:.2}");
    if shown == "-0.00" { "0.00".to_owned() } else { shown }
}

fn pose(found: &Deflections, row: &Deflection) -> String {
    let joint = |((name, turns), value): (&(String, bool), &f64)| {
        let name = printable(name);
        match turns {
            true => format!("{name} {}°", position(deg_from_rad(*value))),
            false => format!("{name} {} mm", position(mm_from_m(*value))),
        }
    };
    found.joints.iter().zip(&row.joints).map(joint).collect::<Vec<_>>().join(", ")
}
