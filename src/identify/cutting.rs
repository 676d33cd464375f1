//! Cutting coefficients from the mean forces of slot tests (Altintas, Manufacturing Automation, 2nd
//! ed., section 2.8.1): with N teeth, depth b and feed per tooth f,
//!
//! ```text
//! F̄x = −(Nb/4) K_rc f − (Nb/π) K_re,   F̄y = (Nb/4) K_tc f + (Nb/π) K_te,
//! F̄z = (Nb/π) K_ac f + (Nb/2) K_ae
//! ```
//!
//! by least squares, one direction at a time.

use std::f64::consts::PI;
use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::wording::counted;

/// K_tc of metals lies well within, N/mm²: plastics have 30, nickel alloys 5000.
const MIN_KTC: f64 = 10.0;
const MAX_KTC: f64 = 20_000.0;

/// Two for the coefficients of a direction and one for their scatter.
const MIN_ROWS: usize = 3;

/// One slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlotTest {
    /// Feed per tooth, m.
    pub feed_per_tooth_m: f64,
    /// Axial depth, m.
    pub axial_depth_m: f64,
    /// Teeth of the cutter.
    pub teeth: u32,
    /// Mean force along the feed and across it, N.
    pub force_n: [f64; 2],
    /// Mean force along the axis, N.
    pub axial_n: Option<f64>,
    /// Line of the table, counted from 1.
    pub line: usize,
}

/// One coefficient, with its standard deviation and 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Coefficient {
    /// N/m² or N/m here; N/mm² or N/mm as it is written.
    #[serde(skip)]
    pub si: f64,
    /// In the unit of its key.
    pub value: f64,
    /// Standard deviation of the value.
    pub std: f64,
    /// Interval that holds it with 95 %.
    pub interval95: [f64; 2],
}

/// The coefficients of one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Direction {
    /// Per area of the chip, N/mm².
    pub cutting_n_per_mm2: Coefficient,
    /// Per length of the edge, N/mm.
    pub edge_n_per_mm: Coefficient,
    /// Standard deviation of the residuals.
    pub residual_n: f64,
}

/// What a force takes from both coefficients of its direction, and the force, N.
type Row = ([f64; 2], f64);

/// What slot tests tell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct CuttingFit {
    /// Slots.
    pub slots: usize,
    /// Whether the table has forces on the work, against those on the tool.
    pub is_turned: bool,
    /// K_tc and K_te.
    pub tangential: Direction,
    /// K_rc and K_re.
    pub radial: Direction,
    /// K_ac and K_ae, where the table has forces along the axis.
    pub axial: Option<Direction>,
}

/// Why nothing can be fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CuttingFault {
    /// Fewer than three slots.
    TooFewRows(usize),
    /// All feeds are the same.
    OneFeed,
    /// The force across the feed (ktc), or against it (krc), does not grow with it; N/mm².
    NotPositive(&'static str, f64),
    /// ktc is none of any metal, N/mm².
    Implausible(f64),
    /// A number is too large to be fitted to.
    NotFinite,
}

impl fmt::Display for CuttingFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewRows(rows) => write!(
                f,
                "has {}, must have at least {MIN_ROWS}: two for the coefficients of a direction, \
                 one for their scatter",
                counted(*rows, "slot")
            ),
            Self::OneFeed => write!(f, "all slots have one feed; cut at several"),
            Self::NotPositive(which, k) => write!(
                f,
                "{which} is {k:.4e} N/mm², must be positive: fy_n must grow with the feed, and \
                 fx_n fall where fy_n is that on the tool; x runs along the feed, z along the \
                 spindle out of the work, y = z × x"
            ),
            Self::Implausible(k) => write!(
                f,
                "ktc is {k:.4} N/mm², must lie between {MIN_KTC} and {MAX_KTC}: forces are in N, \
                 depths in mm, feeds in mm per tooth"
            ),
            Self::NotFinite => write!(f, "a force, depth or feed is too large a number"),
        }
    }
}

/// Fits the coefficients.
///
/// # Errors
/// Too few slots, or forces that no cut has.
pub fn fit_slots(slots: &[SlotTest]) -> Result<CuttingFit, CuttingFault> {
    if slots.len() < MIN_ROWS {
        return Err(CuttingFault::TooFewRows(slots.len()));
    }
    // A force on the work has the other sign.
    let is_turned = slots.iter().map(|slot| slot.force_n[1]).sum::<f64>() < 0.0;
    let sign = if is_turned { -1.0 } else { 1.0 };
    let edge = |slot: &SlotTest| f64::from(slot.teeth) * slot.axial_depth_m;
    let area = |slot: &SlotTest| edge(slot) * slot.feed_per_tooth_m;
    let fit = |rows: Vec<Row>| least_squares(&rows).ok_or(CuttingFault::OneFeed);
    let across = |slot: &SlotTest| ([0.25 * area(slot), edge(slot) / PI], sign * slot.force_n[1]);
    let along = |slot: &SlotTest| ([-0.25 * area(slot), -edge(slot) / PI], sign * slot.force_n[0]);
    let tangential = fit(slots.iter().map(across).collect())?;
    let ktc = tangential.cutting_n_per_mm2.value;
    if ktc <= 0.0 {
        return Err(CuttingFault::NotPositive("ktc", ktc));
    }
    if ktc.is_finite() && !(MIN_KTC..MAX_KTC).contains(&ktc) {
        return Err(CuttingFault::Implausible(ktc));
    }
    let radial = fit(slots.iter().map(along).collect())?;
    // Noise alone may turn a small one.
    let krc = radial.cutting_n_per_mm2;
    if krc.interval95[1] < 0.0 {
        return Err(CuttingFault::NotPositive("krc", krc.value));
    }
    let axis: Option<Vec<_>> = slots
        .iter()
        .map(|slot| Some(([area(slot) / PI, 0.5 * edge(slot)], sign * slot.axial_n?)))
        .collect();
    let axial = axis.map(fit).transpose()?;
    let is_finite = |of: &Direction| {
        let all = [of.cutting_n_per_mm2, of.edge_n_per_mm];
        all.iter().all(|k| k.value.is_finite() && k.interval95.iter().all(|end| end.is_finite()))
    };
    if ![Some(tangential), Some(radial), axial].iter().flatten().all(is_finite) {
        return Err(CuttingFault::NotFinite);
    }
    Ok(CuttingFit { slots: slots.len(), is_turned, tangential, radial, axial })
}

/// y = x₀ k₀ + x₁ k₁ by least squares; `None` where the rows do not tell the two apart.
fn least_squares(rows: &[Row]) -> Option<Direction> {
    let sum = |f: fn(&Row) -> f64| rows.iter().map(f).sum::<f64>();
    let a = sum(|row| row.0[0] * row.0[0]);
    let b = sum(|row| row.0[0] * row.0[1]);
    let c = sum(|row| row.0[1] * row.0[1]);
    let (p, q) = (sum(|row| row.0[0] * row.1), sum(|row| row.0[1] * row.1));
    let determinant = a * c - b * b;
    if determinant.is_nan() || determinant <= 1e-9 * a * c {
        return None;
    }
    let k = [(c * p - b * q) / determinant, (a * q - b * p) / determinant];
    let off = |([x0, x1], y): &Row| y - x0 * k[0] - x1 * k[1];
    let squares: f64 = rows.iter().map(|row| off(row).powi(2)).sum();
    let freedom = rows.len() as f64 - 2.0;
    let residual_n = (squares / freedom).sqrt();
    let stds = [c, a].map(|own| residual_n * (own / determinant).sqrt());
    let factor = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975);
    let told = |si: f64, std: f64, scale: f64| {
        let (value, std) = (si * scale, std * scale);
        Coefficient { si, value, std, interval95: [value - factor * std, value + factor * std] }
    };
    Some(Direction {
        cutting_n_per_mm2: told(k[0], stds[0], 1e-6),
        edge_n_per_mm: told(k[1], stds[1], 1e-3),
        residual_n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slots(noise_n: f64, sign: f64) -> Vec<SlotTest> {
        let (mut seed, nb) = (1u64, 2.0 * 0.003);
        let mut noise = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            noise_n * ((seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
        };
        (1..=12)
            .map(|i| {
                let f = 0.02e-3 * f64::from(i);
                let x = -nb / 4.0 * 99e6 * f - nb / PI * 10e3;
                let y = nb / 4.0 * 631e6 * f + nb / PI * 13e3;
                let z = nb / PI * 273e6 * f + nb / 2.0 * 2.8e3;
                SlotTest {
                    feed_per_tooth_m: f,
                    axial_depth_m: 0.003,
                    teeth: 2,
                    force_n: [sign * (x + noise()), sign * (y + noise())],
                    axial_n: Some(sign * (z + noise())),
                    line: 1,
                }
            })
            .collect()
    }

    #[test]
    fn coefficients_come_back_exactly_without_noise_on_tool_or_work() {
        for sign in [1.0, -1.0] {
            let fit = fit_slots(&slots(0.0, sign)).unwrap();
            assert_eq!(fit.is_turned, sign < 0.0);
            for (found, expected) in [
                (fit.tangential, [631.0, 13.0]),
                (fit.radial, [99.0, 10.0]),
                (fit.axial.unwrap(), [273.0, 2.8]),
            ] {
                let values = [found.cutting_n_per_mm2.value, found.edge_n_per_mm.value];
                for (value, expected) in values.into_iter().zip(expected) {
                    assert!((value / expected - 1.0).abs() < 1e-9, "{value} {expected}");
                }
            }
        }
    }

    #[test]
    fn with_noise_they_lie_within_their_intervals() {
        let fit = fit_slots(&slots(4.0, 1.0)).unwrap();
        for (found, expected) in [
            (fit.tangential.cutting_n_per_mm2, 631.0),
            (fit.tangential.edge_n_per_mm, 13.0),
            (fit.radial.cutting_n_per_mm2, 99.0),
            (fit.radial.edge_n_per_mm, 10.0),
        ] {
            let [low, high] = found.interval95;
            assert!(low < expected && expected < high, "{found:?} {expected}");
            assert!(found.std > 0.0 && (found.value - expected).abs() < 4.0 * found.std);
        }
        assert!((1.0..8.0).contains(&fit.tangential.residual_n));
    }

    #[test]
    fn slots_that_tell_nothing_are_refused() {
        let mut few = slots(0.0, 1.0);
        few.truncate(2);
        assert_eq!(fit_slots(&few), Err(CuttingFault::TooFewRows(2)));
        let mut one = slots(1.0, 1.0);
        one.iter_mut().for_each(|slot| slot.feed_per_tooth_m = 1e-4);
        assert_eq!(fit_slots(&one), Err(CuttingFault::OneFeed));
        let mut falling = slots(0.0, 1.0);
        for slot in &mut falling {
            slot.force_n[1] = 500.0 - 1e6 * slot.feed_per_tooth_m;
        }
        assert!(matches!(fit_slots(&falling), Err(CuttingFault::NotPositive("ktc", _))));
        // Forces along the feed on the work, those across it on the tool.
        let mut mixed = slots(0.0, 1.0);
        mixed.iter_mut().for_each(|slot| slot.force_n[0] *= -1.0);
        assert!(matches!(fit_slots(&mixed), Err(CuttingFault::NotPositive("krc", _))));
        let mut in_kn = slots(0.0, 1.0);
        in_kn.iter_mut().for_each(|slot| slot.force_n = slot.force_n.map(|n| 1e-3 * n));
        assert!(matches!(fit_slots(&in_kn), Err(CuttingFault::Implausible(_))));
        let mut huge = slots(0.0, 1.0);
        huge[0].force_n = [1e308, 1e308];
        assert!(fit_slots(&huge).is_err());
    }
}
