//! The depth at which the cut chatters, along a path; of a drill the width of cut.

use nalgebra::Complex;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;

use super::limit_interval::{Spread, interval_m};
use super::place_limit::{depth_m, exact, modes_of, zeroth};
use super::tip::{Owner, TipMode, TipPlace};
use crate::excitation::{Lips, linear_at};
use crate::job::{Cutting, Operation};
use crate::stability::{
    Chart, Cut, DEEPEST_M, Kind, Limit, LimitOf, Method, is_narrow, receptance_m_per_n,
};
use crate::units::{rad_per_s_from_hz, written};

/// Which modes stability is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`arm`: the arm's modes alone; at milling speeds it is the tool that chatters \
                   first, so this says nothing\nthere. `arm_and_tool`: those of the tool \
                   (tool.modes), too."
)]
pub enum Seen {
    /// The arm's alone.
    Arm,
    /// Those of the tool, too.
    ArmAndTool,
}

/// So many places with the smallest limits of the zeroth order are solved exactly first: an exact
/// one costs a hundred of the zeroth order. Cuts too narrow for the zeroth order are solved
/// everywhere.
const SOLVED: usize = 3;

/// Of the others one in so many.
const EVERY: usize = 8;

/// The limit at one place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "LimitAlong")]
pub struct LimitAt {
    /// Share of the operation's time, 0 to 1.
    pub s: f64,
    /// Line that is run there.
    pub line: usize,
    /// Smallest depth, or width of cut, at which a small vibration grows; null where there is none
    /// below 1 m.
    #[serde(rename = "limit_mm", serialize_with = "written::mm")]
    pub depth_m: Option<f64>,
    /// Of the vibration that grows.
    pub frequency_hz: Option<f64>,
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub kind: Option<Kind>,
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub method: Method,
    /// The mode of the arm that moves most in it, counted from 1; null where it is one of the
    /// tool's.
    pub mode: Option<usize>,
}

/// When a cut chatters: a statement beside the verdict, which it never makes better.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Stability")]
pub struct Chatter {
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub modes: Seen,
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub limit_of: LimitOf,
    /// Axial depth of the cut, or width of cut of a drill.
    #[serde(rename = "depth_mm", serialize_with = "written::mm")]
    pub depth_m: f64,
    /// Whether the cut is deeper than the smallest limit.
    pub is_beyond: bool,
    /// Whether it may be: deeper than the lower end of that limit's interval.
    pub may_be_beyond: bool,
    /// The smallest limit along the path at the programmed speed; null where there is none below 1
    /// m.
    pub smallest: Option<LimitAt>,
    /// In which that limit lies with the confidence of the policy, with the arm's frequencies as
    /// uncertain as they are; null where there is none below 1 m.
    #[serde(rename = "smallest_ci95_mm", serialize_with = "written::mm")]
    pub smallest_ci95_m: [Option<f64>; 2],
    /// The limit at up to 41 places along the path, ascending in s.
    pub along: Vec<LimitAt>,
}

/// The zeroth order at a place; `None` where the coefficients are not known, or the cut does not
/// regenerate, so that no speed matters.
pub fn chart_at(operation: &Operation, place: &TipPlace) -> Option<Chart> {
    let cutting = operation.cutting.as_ref().filter(|cutting| cutting.regenerates)?;
    Some(Chart::new(&modes_of(&place.modes), &cut_at(operation, cutting, place)?))
}

/// A cut with coefficients that are linear about the chip at a place.
fn cut_at(operation: &Operation, cutting: &Cutting, place: &TipPlace) -> Option<Cut> {
    let linear = linear_at(&operation.tool, cutting, place.feed_per_tooth_m)?;
    let cutting = Cutting { coefficients: Some(linear), ..cutting.clone() };
    Cut::new(&operation.tool, &cutting)
}

/// Places that are solved exactly first: all, or those with the smallest limits of the zeroth order
/// and some over the path, as the exact limit may be smallest elsewhere.
fn first_solved(found: &[(Option<Limit>, Method)], all: bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..found.len()).collect();
    if !all {
        order.sort_by(|&a, &b| depth_of(&found[a]).total_cmp(&depth_of(&found[b])));
        order.truncate(SOLVED);
        order.extend((0..found.len()).step_by(EVERY));
        order.sort_unstable();
        order.dedup();
    }
    order
}

/// What is to be solved before the smallest limit is sure: itself, the places beside it, and those
/// that would be smaller if the exact limit were there `share` of the zeroth order, as it was
/// somewhere.
fn not_yet_sure(
    found: &[(Option<Limit>, Method)],
    tried: &[bool],
    (zeroth_m, share): (&[f64], f64),
) -> Vec<usize> {
    let least =
        (0..found.len()).min_by(|&a, &b| depth_of(&found[a]).total_cmp(&depth_of(&found[b])));
    let Some(least) = least.filter(|&i| found[i].0.is_some()) else { return Vec::new() };
    let depth_m = depth_of(&found[least]);
    let may_be_least = |i: usize| i.abs_diff(least) <= 1 || share * zeroth_m[i] < depth_m;
    (0..found.len()).filter(|&i| !tried[i] && may_be_least(i)).collect()
}

/// Stability at places of an operation; `None` where its coefficients are not known. Places are
/// solved exactly until the smallest limit of all is exact, and so are those beside it; where that
/// does not converge, the zeroth order stands.
pub fn chatter(
    operation: &Operation,
    places: &[TipPlace],
    line_at: impl Fn(f64) -> usize,
    spread: Spread<'_>,
) -> Option<Chatter> {
    let cutting = operation.cutting.as_ref()?;
    let cuts: Option<Vec<Cut>> =
        places.iter().map(|place| cut_at(operation, cutting, place)).collect();
    let cuts = cuts.filter(|cuts| !cuts.is_empty())?;
    let at: Vec<(&TipPlace, &Cut)> = places.iter().zip(&cuts).collect();
    let drill = cutting.drill();
    let of = |(place, cut): &(&TipPlace, &Cut)| {
        (zeroth(place, cut, cutting.regenerates), Method::Zeroth)
    };
    let mut found: Vec<(Option<Limit>, Method)> = at.par_iter().map(of).collect();
    // Of a drill the zeroth order is exact.
    if cutting.regenerates && drill.is_none() {
        let mut next = first_solved(&found, is_narrow(&operation.tool, cutting));
        let (mut tried, mut share) = (vec![false; found.len()], 1.0_f64);
        let zeroth_m: Vec<f64> = found.iter().map(|one| depth_of(one).min(DEEPEST_M)).collect();
        while !next.is_empty() {
            let solved: Vec<_> = next.par_iter().map(|&i| (i, exact(at[i].0, at[i].1))).collect();
            for (i, limit) in solved {
                tried[i] = true;
                if let Some(limit) = limit {
                    share = share.min(depth_m(limit) / zeroth_m[i]);
                    found[i] = (limit, Method::Exact);
                }
            }
            next = not_yet_sure(&found, &tried, (&zeroth_m, share));
        }
    }
    let least = at.iter().zip(&found).min_by(|a, b| depth_of(a.1).total_cmp(&depth_of(b.1)));
    let ends = least.and_then(|(&(place, cut), (limit, method))| {
        let limit = ((*limit)?.depth_m, *method);
        Some(interval_m((place, cut, cutting.regenerates), limit, spread))
    });
    let along: Vec<LimitAt> = places
        .iter()
        .zip(&cuts)
        .zip(found)
        .map(|((place, cut), (found, method))| LimitAt {
            s: place.s,
            line: line_at(place.s),
            depth_m: found.map(|limit| limit.depth_m),
            frequency_hz: found.map(|limit| limit.frequency_hz),
            kind: found.map(|limit| limit.kind),
            method,
            mode: found.and_then(|limit| strongest(&place.modes, cut, limit.frequency_hz)),
        })
        .collect();
    let told = along.iter().filter_map(|at| Some((at.depth_m?, at)));
    let smallest = told.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, at)| *at);
    let depth_m = match drill {
        Some(drill) => Lips::new(&operation.tool, drill)?.width_m,
        None => cutting.axial_depth_m,
    };
    let limit_of = cuts.first()?.limit_of();
    let is_beyond = smallest.and_then(|at| at.depth_m).is_some_and(|limit| depth_m >= limit);
    let may_be_beyond = is_beyond || ends.is_some_and(|[low, _]| depth_m >= low);
    let smallest_ci95_m = ends.map_or([None; 2], |ends| ends.map(up_to_deepest));
    let has_tool = !operation.tool.modes.is_empty();
    let modes = if has_tool { Seen::ArmAndTool } else { Seen::Arm };
    Some(Chatter {
        modes,
        limit_of,
        depth_m,
        is_beyond,
        may_be_beyond,
        smallest,
        smallest_ci95_m,
        along,
    })
}

/// A limit, unless it is beyond all that are told.
fn up_to_deepest(depth_m: f64) -> Option<f64> {
    (depth_m <= DEEPEST_M).then_some(depth_m)
}

fn depth_of((limit, _): &(Option<Limit>, Method)) -> f64 {
    depth_m(*limit)
}

/// The mode of the arm with the largest part in G(iω) H̄, which is what becomes unstable; `None`
/// where that is one of the tool's.
fn strongest(modes: &[TipMode], cut: &Cut, hz: f64) -> Option<usize> {
    let mean = cut.mean().map(Complex::from);
    let size = |one: &TipMode| {
        let own = cut.in_axes(&[one.mode]);
        (receptance_m_per_n(&own, rad_per_s_from_hz(hz)) * mean).norm()
    };
    match modes.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?.of {
        Owner::Arm(number) => Some(number),
        Owner::Tool => None,
    }
}
