//! Functions that formulas of milling controls and RAPID share, angles in degrees.

use crate::units::{deg_from_rad, rad_from_deg};

/// A function by its name in upper case.
pub(super) fn function(name: &str) -> Option<fn(f64) -> f64> {
    Some(match name {
        "ABS" => f64::abs,
        "SQRT" => f64::sqrt,
        "EXP" => f64::exp,
        "LN" => f64::ln,
        "SIN" => |x| rad_from_deg(x).sin(),
        "COS" => |x| rad_from_deg(x).cos(),
        "TAN" => |x| rad_from_deg(x).tan(),
        "ASIN" => |x| deg_from_rad(x.asin()),
        "ACOS" => |x| deg_from_rad(x.acos()),
        _ => return None,
    })
}
