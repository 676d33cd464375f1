//! Video → tracks of marks, in pixels and frames.
//!
//! A mark is followed by the Gauss–Newton method (Lucas & Kanade, Proc. 7th Int. Joint Conf.
//! Artif. Intell., 1981, 674–679): a frame I(x) = a T(x − p) + b is solved for the translation p,
//! the gain a and the offset b. The mark's picture T is known between the pixels, from the frames
//! or as that of a disc; so what a pixel averages is not interpolated. The deviation of p is the
//! Cramér–Rao bound at the noise that the residuals show.

mod disc;
mod find_round;
mod learn;
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
