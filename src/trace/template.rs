//! The picture of a mark, and its fit to a frame.

use nalgebra::{Matrix4, Vector4};

use super::picture::{Area, Crop};
use super::spline::{Nodes, Samples, Spline};

/// A fit that is not done after so many steps does not converge.
const MAX_STEPS: usize = 50;

/// Steps shorter than this end the fit, px; the next would be a tenth of it or less.
const SHORT_PX: f64 = 2e-4;

/// The last of these steps may be so long, px.
const LAST_PX: f64 = 0.01;

/// The template is displaced by no more than this against whole pixels.
const MAX_PART_PX: f64 = 0.75;

/// The brightness of a mark may change by such factors.
const GAINS: [f64; 2] = [0.3, 3.0];

/// Variance of rounding to whole grey values.
pub(super) const ROUNDING: f64 = 1.0 / 12.0;

/// The picture of a mark.
#[derive(Debug, Clone)]
pub(super) struct Template {
    pub(super) area: Area,
    pub(super) nodes: Nodes,
    spline: Spline,
    /// Grey value of each pixel at no displacement.
    values: Vec<f64>,
    /// The weight of each pixel.
    weights: Vec<f64>,
    inverse: Matrix4<f64>,
    /// Variance of the template's own noise over that of a frame.
    own_noise: f64,
    /// What the template's form between the pixels leaves of places, px.
    pub(super) unsure: [f64; 2],
}

/// Where a mark was found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// Its displacement from the template, px.
    pub(super) shift: [f64; 2],
    pub(super) gain: f64,
    pub(super) offset: f64,
    /// Standard deviations of `shift`, px.
    pub(super) deviation: [f64; 2],
    /// Variance of the noise of a pixel, by the residuals.
    pub(super) noise: f64,
    /// Variance of the grey values, so weighted as the residuals are.
    pub(super) contrast: f64,
}

/// A displacement as whole pixels and the rest.
pub(super) fn split(shift: [f64; 2]) -> ([isize; 2], [f64; 2]) {
    let whole = shift.map(f64::round);
    (whole.map(|px| px as isize), [shift[0] - whole[0], shift[1] - whole[1]])
}

/// For each pixel the grey value of the template, 1, and the change with a displacement along x and
/// y.
pub(super) fn columns(samples: &Samples) -> impl Iterator<Item = [f64; 4]> {
    let slopes = samples.along_x.iter().zip(&samples.along_y);
    samples.values.iter().zip(slopes).map(|(value, (x, y))| [*value, 1.0, -x, -y])
}

impl Template {
    /// `None` where the values do not say where the mark is along both axes.
    pub(super) fn new(area: Area, nodes: Nodes, weights: Vec<f64>, own_noise: f64) -> Option<Self> {
        let spline = Spline::of(&nodes);
        let mut samples = Samples::default();
        spline.sample([0.0; 2], 0, &mut samples);
        let mut normal = Matrix4::zeros();
        for (column, weight) in columns(&samples).zip(&weights) {
            let column = Vector4::from(column);
            normal += column * column.transpose() * *weight;
        }
        let inverse = inverse(normal)?;
        let values = samples.values;
        let unsure = [0.0; 2];
        Some(Self { area, nodes, spline, values, weights, inverse, own_noise, unsure })
    }

    /// Grey value of a pixel.
    pub(super) fn value(&self, index: usize) -> f64 {
        self.values[index]
    }

    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    pub(super) fn sample(&self, part: [f64; 2], border: usize, samples: &mut Samples) {
        self.spline.sample(part, border, samples);
    }

    /// Deviations along x and y at a noise of this variance.
    pub(super) fn deviation(&self, noise: f64, gain: f64) -> [f64; 2] {
        [2, 3].map(|k| (noise * self.inverse[(k, k)]).sqrt() / gain.abs())
    }

    /// Fits the template to a frame from a start; `None` where that does not converge, or leads out
    /// of the crop.
    pub(super) fn fit(&self, frame: &Crop, start: [f64; 2]) -> Option<Fit> {
        let mut shift = start;
        let (mut whole, mut part) = split(shift);
        let mut samples = Samples::default();
        for left in (0..MAX_STEPS).rev() {
            self.spline.sample(part, 0, &mut samples);
            let rows = frame.rows(self.area, whole, 0)?;
            let mut normal = [[0.0; 4]; 4];
            let (mut products, mut squares) = ([0.0; 4], 0.0);
            let pixels = rows.flatten().zip(columns(&samples)).zip(&self.weights);
            for ((value, column), weight) in pixels {
                let value = f64::from(*value);
                squares += weight * value * value;
                for i in 0..4 {
                    let weighted = weight * column[i];
                    products[i] += weighted * value;
                    for j in 0..=i {
                        normal[i][j] += weighted * column[j];
                    }
                }
            }
            let normal = Matrix4::from_fn(|i, j| normal[i.max(j)][i.min(j)]);
            let (inverse, products) = (inverse(normal)?, Vector4::from(products));
            let found = inverse * products;
            let [gain, offset, along_x, along_y]: [f64; 4] = found.into();
            if !(GAINS[0]..GAINS[1]).contains(&gain) {
                return None;
            }
            let step = [along_x, along_y].map(|product| (product / gain).clamp(-1.5, 1.5));
            shift = [shift[0] + step[0], shift[1] + step[1]];
            let short = if left == 0 { LAST_PX } else { SHORT_PX };
            if step.iter().all(|step| step.abs() < short) {
                let count = self.weights.len() as f64;
                let residuals = (squares - found.dot(&products)).max(0.0) / (count - 4.0);
                let noise = residuals / (1.0 + self.own_noise) + 1e-6;
                let sum = normal[(1, 1)];
                let contrast = (squares - products[1] * products[1] / sum).max(0.0) / count;
                let deviation = [2, 3].map(|k| {
                    ((noise * inverse[(k, k)]).sqrt() / gain.abs()).hypot(self.unsure[k - 2])
                });
                return Some(Fit { shift, gain, offset, deviation, noise, contrast });
            }
            part = [0, 1].map(|k| shift[k] - whole[k] as f64);
            if part.iter().any(|part| part.abs() > MAX_PART_PX) {
                (whole, part) = split(shift);
            }
        }
        None
    }
}

/// The inverse of normal equations; `None` where they do not tell all unknowns.
fn inverse(normal: Matrix4<f64>) -> Option<Matrix4<f64>> {
    let inverse = normal.try_inverse().filter(|m| m.iter().all(|v| v.is_finite()))?;
    (0..4).all(|k| inverse[(k, k)] > 0.0).then_some(inverse)
}
