//! The depth at which the cut chatters, over constant speeds: what makes one safe speed better than
//! another where depth is wanted. Speeds are ranked by the zeroth order; what is told of a speed is
//! the exact limit.

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;

use super::speeds::SafeSet;
use crate::job::{Cutting, Operation, SpindleSpeed};
use crate::notes::Note;
use crate::path::Path;
use crate::process::{
    Chatter, LimitAt, Spread, TipPlace, chart_at, chatter, sure_ones, tip_places,
};
use crate::risk::SpindleProfile;
use crate::stability::{Chart, DEEPEST_M, LimitOf};

/// Places of the path.
const PLACES: usize = 12;

/// Speeds that are tried over the safe ones, and in each stretch of them at least.
const TRIED: usize = 400;
const MIN_TRIED: usize = 12;

/// So many of the best are weighed by the exact limit.
const WEIGHED: usize = 8;

/// The smallest limit along the path at a constant speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "DepthAt")]
pub struct DepthAt {
    /// Spindle speed.
    pub rpm: f64,
    /// The smallest limit; null where there is none below 1 m.
    pub smallest: Option<LimitAt>,
}

/// When an operation chatters.
pub(super) struct DepthModel<'a> {
    operation: &'a Operation,
    path: &'a Path<'a>,
    places: Vec<TipPlace>,
    charts: Vec<Chart>,
}

impl<'a> DepthModel<'a> {
    /// `Ok(None)` where the cut or its coefficients are not known, or do not depend on the speed.
    ///
    /// # Errors
    /// The arm has no modes somewhere.
    pub(super) fn new(operation: &'a Operation, path: &'a Path<'a>) -> Result<Option<Self>, Note> {
        let turning = SpindleProfile::new(&operation.speed, path);
        let s: Vec<f64> = (0..PLACES).map(|i| i as f64 / (PLACES - 1) as f64).collect();
        let places = sure_ones(tip_places(operation, path, &s, |s| !turning.is_stopped_at(s))?);
        let charts: Option<Vec<Chart>> =
            places.iter().map(|place| chart_at(operation, place)).collect();
        let charts = charts.filter(|charts| !charts.is_empty());
        Ok(charts.map(|charts| Self { operation, path, places, charts }))
    }

    fn smallest_m(&self, rpm: f64) -> f64 {
        let limits = self.charts.iter().filter_map(|chart| chart.limit(rpm));
        limits.map(|limit| limit.depth_m).fold(DEEPEST_M, f64::min)
    }

    /// Safe speeds, the deepest cut first: those at which the zeroth order is largest among their
    /// neighbours, the best of them weighed by the exact limit.
    pub(super) fn deepest(&self, set: &SafeSet) -> Vec<f64> {
        let range: f64 = set.safe.iter().map(|gap| gap.high_rpm - gap.low_rpm).sum();
        let peaks_of = |gap: &super::Speeds| {
            let width = gap.high_rpm - gap.low_rpm;
            let share = if range > 0.0 { width / range } else { 1.0 };
            let tried = ((TRIED as f64 * share).ceil() as usize).max(MIN_TRIED);
            let at = |i: usize| gap.low_rpm + width * i as f64 / tried as f64;
            let all: Vec<(f64, f64)> =
                (0..=tried).into_par_iter().map(|i| (self.smallest_m(at(i)), at(i))).collect();
            let depth = |i: Option<usize>| i.and_then(|i| all.get(i)).map_or(0.0, |one| one.0);
            let is_peak =
                |i: &usize| all[*i].0 > depth(i.checked_sub(1)) && all[*i].0 >= depth(Some(i + 1));
            let peaks: Vec<(f64, f64)> = (0..=tried).filter(is_peak).map(|i| all[i]).collect();
            peaks
        };
        let mut best: Vec<(f64, f64)> = set.safe.iter().flat_map(peaks_of).collect();
        best.sort_by(|a, b| b.0.total_cmp(&a.0));
        let weighed = |&(_, rpm): &(f64, f64)| {
            let exact = self.at(rpm).smallest.and_then(|smallest| smallest.depth_m);
            (exact.unwrap_or(DEEPEST_M), rpm)
        };
        let mut first: Vec<(f64, f64)> = best.iter().take(WEIGHED).map(weighed).collect();
        first.sort_by(|a, b| b.0.total_cmp(&a.0));
        first.iter().chain(best.iter().skip(WEIGHED)).map(|&(_, rpm)| rpm).collect()
    }

    /// What its limits bound.
    pub(super) fn limit_of(&self) -> LimitOf {
        match self.operation.cutting.as_ref().and_then(Cutting::drill) {
            Some(_) => LimitOf::WidthOfCut,
            None => LimitOf::AxialDepth,
        }
    }

    /// The exact limit at a speed with the programmed chip.
    pub(super) fn at(&self, rpm: f64) -> DepthAt {
        let places: Vec<TipPlace> =
            self.places.iter().map(|place| TipPlace { rpm, ..place.clone() }).collect();
        let operation = Operation { speed: SpindleSpeed::Constant(rpm), ..self.operation.clone() };
        let found: Option<Chatter> =
            chatter(&operation, &places, |s| self.path.line_at(s), Spread::NONE);
        DepthAt { rpm, smallest: found.and_then(|found| found.smallest) }
    }
}
