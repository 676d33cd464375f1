//! Stability lobes as CSV.

use std::fmt::Write;

use crate::study::lobes::{Lobes, Rows};
use crate::units::mm_from_m;

/// One row a speed, numbers with as many digits as bring them back exactly; blank where there is no
/// limit.
pub fn lobes_csv(lobes: &Lobes) -> String {
    let mut out = String::new();
    // Writing into a string does not fail.
    match &lobes.rows {
        Rows::Limits(rows) => {
            out.push_str("rpm,limit_mm,frequency_hz,kind\n");
            for row in rows {
                let _ = match row.limit {
                    Some(limit) => writeln!(
                        out,
                        "{},{},{},{}",
                        row.rpm,
                        mm_from_m(limit.depth_m),
                        limit.frequency_hz,
                        limit.kind.name()
                    ),
                    None => writeln!(out, "{},,,", row.rpm),
                };
            }
        }
        Rows::Radii(rows) => {
            out.push_str("rpm,depth_mm,spectral_radius\n");
            for row in rows {
                let depth_mm = mm_from_m(row.depth_m);
                let _ = writeln!(out, "{},{depth_mm},{}", row.rpm, row.spectral_radius);
            }
        }
    }
    out
}
