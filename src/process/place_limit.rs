//! The limit of depth at one place, by either method.

use super::tip::{TipMode, TipPlace};
use crate::stability::{Chart, Cut, Limit, ToolMode, coupling_limit, milling_grows, milling_limit};

pub(super) fn modes_of(modes: &[TipMode]) -> Vec<ToolMode> {
    modes.iter().map(|one| one.mode).collect()
}

/// By the mean of the cut; of one that does not regenerate the depth at which modes feed each
/// other.
pub(super) fn zeroth(place: &TipPlace, cut: &Cut, regenerates: bool) -> Option<Limit> {
    let modes = modes_of(&place.modes);
    if regenerates {
        Chart::new(&modes, cut).limit(place.rpm)
    } else {
        coupling_limit(&cut.in_axes(&modes), &cut.mean())
    }
}

/// By the growth of a small motion; `None` where it does not converge.
pub(super) fn exact(place: &TipPlace, cut: &Cut) -> Option<Option<Limit>> {
    let modes = modes_of(&place.modes);
    milling_limit(&modes, cut, &Chart::new(&modes, cut), place.rpm).ok()
}

/// Whether a small motion grows at a depth; `None` where that is not found.
pub(super) fn grows(place: &TipPlace, cut: &Cut, depth_m: f64) -> Option<bool> {
    milling_grows(&modes_of(&place.modes), cut, place.rpm, depth_m)
}

/// A limit's depth; infinite where there is none below 1 m.
pub(super) fn depth_m(limit: Option<Limit>) -> f64 {
    limit.map_or(f64::INFINITY, |limit| limit.depth_m)
}
