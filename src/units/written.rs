//! Quantities as outputs write them: under a key that names another unit than SI they are converted
//! as they are written, `#[serde(serialize_with = "written::percent")]`.

use std::path::Path;

use serde::{Serialize, Serializer};

use super::{
    deg_from_rad, mm_from_m, mm_per_min_from_m_per_s, percent_from_ratio, percent_read_as,
    um_from_m, um_per_n_read_as,
};

/// A number, or several.
pub trait Numbers: Serialize {
    /// Each of them converted.
    fn each(&self, by: fn(f64) -> f64) -> Self;
}

impl Numbers for f64 {
    fn each(&self, by: fn(f64) -> f64) -> Self {
        by(*self)
    }
}

impl<T: Numbers> Numbers for Option<T> {
    fn each(&self, by: fn(f64) -> f64) -> Self {
        self.as_ref().map(|numbers| numbers.each(by))
    }
}

impl<T: Numbers> Numbers for Vec<T> {
    fn each(&self, by: fn(f64) -> f64) -> Self {
        self.iter().map(|numbers| numbers.each(by)).collect()
    }
}

impl<T: Numbers, const N: usize> Numbers for [T; N]
where
    [T; N]: Serialize,
{
    fn each(&self, by: fn(f64) -> f64) -> Self {
        std::array::from_fn(|i| self[i].each(by))
    }
}

macro_rules! written {
    ($($(#[$doc:meta])* $name:ident: $by:path;)*) => {$(
        $(#[$doc])*
        ///
        /// # Errors
        /// The serializer's.
        pub fn $name<S: Serializer>(value: &impl Numbers, to: S) -> Result<S::Ok, S::Error> {
            value.each($by).serialize(to)
        }
    )*};
}

written! {
    /// A ratio in percent.
    percent: percent_from_ratio;
    /// A ratio that somebody stated, in percent as it was stated.
    stated_percent: percent_read_as;
    /// A compliance that somebody stated, in µm/N as it was stated.
    stated_um_per_n: um_per_n_read_as;
    /// An angle in degrees.
    deg: deg_from_rad;
    /// A length in millimetres.
    mm: mm_from_m;
    /// A length in micrometres, a compliance in µm/N.
    um: um_from_m;
    /// A feed in mm/min.
    mm_per_min: mm_per_min_from_m_per_s;
}

/// The place of what stands in a list, counted from 1.
///
/// # Errors
/// The serializer's.
pub fn from_one<S: Serializer>(index: &usize, to: S) -> Result<S::Ok, S::Error> {
    (index + 1).serialize(to)
}

/// A path as it is named.
///
/// # Errors
/// The serializer's.
pub fn path<S: Serializer>(path: &Path, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&path.to_string_lossy())
}
