//! Video → tracks of marks, in pixels and frames.
//!
//! A mark is followed by the inverse-compositional Gauss–Newton method (Baker & Matthews, Int. J.
//! Comput. Vis. 56, 2004, 221–255): its picture T is fixed, the frame I is interpolated by cubic
//! B-splines, and I(x + p) = a T(x) + b is solved for the translation p, the gain a and the offset
//! b. The deviation of p is the Cramér–Rao bound at the noise that the residuals show.

mod find_round;
mod picture;
mod resample;
mod search;
mod spline;
mod template;
mod track;

pub use find_round::{Round, find_round};
pub use picture::{Area, Picture};
pub use resample::{Band, Resampled, Sample, resample};
pub use track::{Faint, Position, Track, Tracker};
