//! Where the frequencies mirror. A planar section has the same frequencies at β2 and at −β2; if the
//! measured ones mirror about another angle, its zero is off, or a centre of mass off its axis.

use std::f64::consts::{FRAC_PI_2, PI};

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::candidate::Candidate;
use super::data::Data;
use super::outcome::{Mirror, ResidualRow, Symmetry};
use super::structure::{SIGNIFICANCE, dot, orthonormal};
use crate::model::{Cause, JointKind, Robot};

/// Joint positions that differ by less are the same, rad: tables are rounded.
const SAME: f64 = 1e-6;

/// The least share of the table's range that must lie on either side of where it mirrors.
const MIN_SIDE: f64 = 0.2;

/// Most harmonics of a curve.
const MAX_HARMONICS: usize = 6;

/// Steps of the search over the half turn in which a centre may lie.
const STEPS: usize = 180;

/// A centre that is less sure says nothing, rad either way.
const MAX_HALF_WIDTH: f64 = 0.2;

/// No frequency is known better, share of itself.
const ROUNDING: f64 = 1e-6;

/// About which angle the frequencies mirror, where the table varies just one.
pub(super) fn symmetry(
    robot: &Robot,
    data: &Data,
    residuals: &[ResidualRow],
    candidates: &[Candidate],
) -> Option<Symmetry> {
    let joint = data.swept_joint(SAME)?;
    if robot.joints()[joint].kind == JointKind::Prismatic {
        return None;
    }
    let curves = |of: fn(&ResidualRow) -> Option<f64>| {
        let mut curves = vec![Vec::new(); data.columns];
        for row in residuals {
            curves[row.mode].extend(of(row).map(|hz| [row.joints[joint], hz.ln()]));
        }
        curves.retain(|curve| !curve.is_empty());
        curves
    };
    let measured = centre(&curves(|row| Some(row.measured_hz)))?;
    let model = centre(&curves(|row| row.before_hz));
    let differ = model.as_ref().is_some_and(|model| {
        let half = |of: &Mirror| 0.5 * (of.ci95_rad[1] - of.ci95_rad[0]);
        (measured.centre_rad - model.centre_rad).abs() > half(&measured).hypot(half(model))
    });
    // With its zero off by δ, the arm is at q + δ where it says q.
    let zero_offset_rad = model.as_ref().filter(|_| differ).and_then(|model| {
        let offset = model.centre_rad - measured.centre_rad;
        let name = robot.joints()[joint].name.as_str();
        let is_own =
            |c: &&Candidate| c.cause == Cause::JointZeroOffset && c.at.as_deref() == Some(name);
        let [low, high] = candidates.iter().find(is_own)?.parameters.first()?.bounds;
        (low..=high).contains(&offset).then_some(offset)
    });
    let angle = [("beta2", robot.beta2()), ("beta1", robot.beta1())].into_iter().find_map(
        |(name, form)| form.filter(|form| form.terms().any(|(j, _)| j == joint)).map(|f| (name, f)),
    );
    let as_shown = |mirror: Mirror| {
        let Some((_, form)) = angle else { return mirror };
        let at = |position: f64| {
            let mut q = data.rows[0].q.clone();
            q[joint] = position;
            form.at(&q)
        };
        let mut ci95_rad = mirror.ci95_rad.map(at);
        ci95_rad.sort_by(f64::total_cmp);
        Mirror { centre_rad: at(mirror.centre_rad), ci95_rad }
    };
    let joint = robot.joints()[joint].name.clone();
    Some(Symmetry {
        angle: angle.map_or_else(|| joint.clone(), |(name, _)| name.to_owned()),
        joint,
        measured: as_shown(measured),
        model: model.map(as_shown),
        differ,
        zero_offset_rad,
    })
}

/// Points of one mode: position, ln of the frequency.
type Curve = Vec<[f64; 2]>;

/// Where all curves mirror, by least squares of even Fourier series about a common centre.
fn centre(curves: &[Curve]) -> Option<Mirror> {
    let positions = || curves.iter().flatten().map(|[x, _]| *x);
    let [low, high] = [positions().reduce(f64::min)?, positions().reduce(f64::max)?];
    let count = positions().count() as f64;
    let middle = 0.5 * (low + high);
    // About c and about c + π an even series is the same.
    let reach = FRAC_PI_2.min((0.5 - MIN_SIDE) * (high - low));
    let step = PI / STEPS as f64;
    let steps = (reach / step).floor() as i32;
    let grid: Vec<f64> = (-steps..=steps).map(|i| middle + f64::from(i) * step).collect();
    let freedom = |harmonics: usize| (curves.len() * (harmonics + 1) + 1) as f64;
    let squares = |c: f64, harmonics: usize| left(curves, c, harmonics, false);
    let mut best: Option<(f64, usize, f64)> = None;
    for harmonics in 1..=MAX_HARMONICS {
        if count < (curves.len() * (2 * harmonics + 1)) as f64 + 3.0 {
            break;
        }
        let at = grid.iter().map(|&c| (c, squares(c, harmonics)));
        let (c, square) = at.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let bic = count * (square / count).ln() + freedom(harmonics) * count.ln();
        if best.is_none_or(|(least, ..)| bic < least) {
            best = Some((bic, harmonics, c));
        }
    }
    let (_, harmonics, c) = best?;
    let squares = |c: f64| squares(c, harmonics);
    let c = lowest(squares, [c - step, c + step]);
    let least = squares(c);
    let rest = count - freedom(harmonics);
    // What odd terms add must be noise; what even terms say must not.
    let odd = curves.len() as f64 * harmonics as f64 - 1.0;
    let whole = left(curves, c, harmonics, true);
    let flat = left(curves, c, 0, false);
    let p_value = |more: f64, square: f64, freedom: f64, left: f64| {
        let ratio = (more / square - 1.0) * left / freedom;
        FisherSnedecor::new(freedom, left).map_or(1.0, |f| f.sf(ratio.max(0.0)))
    };
    let even = freedom(harmonics) - curves.len() as f64;
    if odd >= 1.0 && p_value(least, whole, odd, rest - odd) < SIGNIFICANCE
        || p_value(flat, least, even, rest) > SIGNIFICANCE
    {
        return None;
    }
    let quantile = FisherSnedecor::new(1.0, rest).ok()?.inverse_cdf(0.95);
    let bound = least * (1.0 + quantile / rest);
    let is_within = |c: f64| squares(c) <= bound;
    // A second centre that is as good leaves neither.
    if grid.iter().any(|&other| (other - c).abs() > MAX_HALF_WIDTH && is_within(other)) {
        return None;
    }
    let end = |mut outside: f64| {
        let mut inside = c;
        (!is_within(outside)).then(|| {
            for _ in 0..40 {
                let between = 0.5 * (inside + outside);
                *(if is_within(between) { &mut inside } else { &mut outside }) = between;
            }
            inside
        })
    };
    let ci95_rad = [end(c - MAX_HALF_WIDTH)?, end(c + MAX_HALF_WIDTH)?];
    Some(Mirror { centre_rad: c, ci95_rad })
}

/// Sum of squares that Fourier series about `c` leave of all curves: even, or whole.
fn left(curves: &[Curve], c: f64, harmonics: usize, with_odd: bool) -> f64 {
    let of_curve = |curve: &Curve| {
        let column = |of: &dyn Fn(f64) -> f64| curve.iter().map(|[x, _]| of(x - c)).collect();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        orthonormal(column(&|_| 1.0), &mut basis);
        for k in (1..=harmonics).map(|k| k as f64) {
            orthonormal(column(&|x| (k * x).cos()), &mut basis);
            if with_odd {
                orthonormal(column(&|x| (k * x).sin()), &mut basis);
            }
        }
        let mut rest: Vec<f64> = curve.iter().map(|[_, y]| *y).collect();
        for q in &basis {
            let along = dot(q, &rest);
            rest.iter_mut().zip(q).for_each(|(r, q)| *r -= along * q);
        }
        dot(&rest, &rest) + curve.len() as f64 * ROUNDING * ROUNDING
    };
    curves.iter().map(of_curve).sum()
}

/// Where a function with one minimum in an interval is lowest, by golden section.
fn lowest(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..40 {
        let [a, b] = [high - share * (high - low), low + share * (high - low)];
        if f(a) < f(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}
