//! The likeliest shape of the noise of a table, by the residuals of a model.

use super::data::Data;
use super::decorrelation::NoiseShape;
use super::likelihood::noise;
use crate::statistics::median;

/// Scale of the common part and of the drift over that of single frequencies that are tried.
const TRIED: [f64; 7] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// A mode's scale counts as many frequencies of the common one.
const SHRINKAGE: f64 = 8.0;

/// The likeliest shape of the noise for the residuals of a model; `None` if it is not better than
/// noise of each frequency alone by this much log evidence.
pub(super) fn shape_of(
    data: &Data,
    residuals: &[Option<f64>],
    better_by: f64,
) -> Option<NoiseShape> {
    let n = data.points.len() as f64;
    // A cause may set all frequencies off alike: that says nothing of the noise.
    let known: Vec<f64> = residuals.iter().flatten().copied().collect();
    let middle = median(known).unwrap_or(0.0);
    let residuals: Vec<Option<f64>> =
        residuals.iter().map(|own| own.map(|residual| residual - middle)).collect();
    let residuals = &residuals[..];
    let evidence = |shape: &NoiseShape| -> f64 {
        let shaped = data.shaped(shape.clone());
        let innovations = shaped.decorrelation.of_residuals(residuals);
        // Without its middle, what a drift was off by before the first row costs nothing.
        let map = &shaped.decorrelation;
        noise(&shaped.points, &innovations).ln_likelihood + (map.ln_determinant - map.ln_constant)
            - shape.cost
    };
    let plain = evidence(&NoiseShape::plain());
    let has_order = data.rows.len() >= 8;
    let mut best: Option<(f64, NoiseShape)> = None;
    for common in TRIED {
        for drift in TRIED {
            if drift > 0.0 && !has_order || common > 0.0 && data.columns < 2 {
                continue;
            }
            for with_scales in [false, true] {
                let parts = f64::from(u8::from(common > 0.0)) + f64::from(u8::from(drift > 0.0));
                let mut shape =
                    NoiseShape { common, drift, cost: 0.5 * parts * n.ln(), ..NoiseShape::plain() };
                if with_scales {
                    if data.columns < 2 {
                        continue;
                    }
                    for _ in 0..3 {
                        scale_modes(data, residuals, &mut shape);
                    }
                    let of_column = n / data.columns as f64;
                    let freedom = (data.columns - 1) as f64 * of_column / (of_column + SHRINKAGE);
                    shape.cost += 0.5 * freedom * of_column.ln();
                }
                let found = evidence(&shape);
                if best.as_ref().is_none_or(|(known, _)| found > *known) {
                    best = Some((found, shape));
                }
            }
        }
    }
    let (found, shape) = best?;
    (found > plain + better_by).then_some(shape)
}

/// Scales of the modes from the residuals that a shape leaves, drawn towards a common one.
fn scale_modes(data: &Data, residuals: &[Option<f64>], shape: &mut NoiseShape) {
    let shaped = data.shaped(shape.clone());
    let innovations = shaped.decorrelation.of_residuals(residuals);
    let fitted = noise(&shaped.points, &innovations);
    let ratio = |column: usize| {
        let (mut sum, mut count) = (SHRINKAGE, SHRINKAGE);
        for ((point, residual), weight) in
            shaped.points.iter().zip(&innovations).zip(&fitted.weights)
        {
            if let Some(residual) = residual.filter(|_| point.column == column) {
                sum += weight * residual * residual;
                count += 1.0;
            }
        }
        (sum / count).sqrt()
    };
    let mut scales: Vec<f64> =
        (0..data.columns).map(|column| shape.scale(column) * ratio(column)).collect();
    let mean = scales.iter().map(|s| s.ln()).sum::<f64>() / scales.len() as f64;
    scales.iter_mut().for_each(|s| *s /= mean.exp());
    shape.scales = scales;
}
