//! The picture of a mark, and its fit to a frame.

use nalgebra::{Matrix4, Vector4};

use super::picture::{Area, Crop};
use super::spline::{Spline, noise_gain};

/// Pixels about the mark that the slopes at its edge need.
pub(super) const RIM: usize = 3;

/// A fit that is not done after so many steps does not converge.
const MAX_STEPS: usize = 100;

/// Steps shorter than this end the fit, px.
const SHORT_PX: f64 = 5e-5;

/// The last of these steps may be so long, px.
const LAST_PX: f64 = 0.01;

/// The brightness of a mark may change by such factors.
const GAINS: [f64; 2] = [0.3, 3.0];

/// Variance of rounding to whole grey values.
pub(super) const ROUNDING: f64 = 1.0 / 12.0;

/// The picture of a mark.
#[derive(Debug, Clone)]
pub(super) struct Template {
    pub(super) width: usize,
    pub(super) height: usize,
    /// For each pixel its grey value, 1, and the slopes along x and y.
    columns: Vec<[f64; 4]>,
    /// The weight of each pixel.
    weights: Vec<f64>,
    inverse: Matrix4<f64>,
    /// Variance of the template's own noise over that of a frame.
    own_noise: f64,
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

impl Template {
    /// `None` where the values do not say where the mark is along both axes.
    pub(super) fn new(
        area: Area,
        rimmed: Vec<f32>,
        weights: Vec<f64>,
        own_noise: f64,
    ) -> Option<Self> {
        let Area { width, height, .. } = area;
        let crop = Crop {
            left: 0,
            top: 0,
            width: width + 2 * RIM,
            height: height + 2 * RIM,
            values: rimmed,
        };
        let spline = Spline::of(&crop);
        let mut columns = Vec::with_capacity(width * height);
        let mut normal = Matrix4::zeros();
        for y in RIM..height + RIM {
            for x in RIM..width + RIM {
                let value = f64::from(crop.values[y * crop.width + x]);
                let [along_x, along_y] = spline.slope(x, y);
                let column = Vector4::new(value, 1.0, along_x, along_y);
                normal += column * column.transpose() * weights[columns.len()];
                columns.push(column.into());
            }
        }
        let inverse = normal.try_inverse().filter(|m| m.iter().all(|v| v.is_finite()))?;
        let is_seen = (0..4).all(|k| inverse[(k, k)] > 0.0);
        is_seen.then_some(Self { width, height, columns, weights, inverse, own_noise })
    }

    /// Grey value of a pixel.
    pub(super) fn value(&self, index: usize) -> f64 {
        self.columns[index][0]
    }

    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Deviations along x and y at a noise of this variance.
    pub(super) fn deviation(&self, noise: f64, gain: f64) -> [f64; 2] {
        [2, 3].map(|k| (noise * self.inverse[(k, k)]).sqrt() / gain.abs())
    }

    /// Fits the template to a frame from a start; `None` where that does not converge, or leads out
    /// of the crop.
    pub(super) fn fit(&self, frame: &Spline, corner: [f64; 2], start: [f64; 2]) -> Option<Fit> {
        let mut shift = start;
        let mut values = Vec::new();
        for left in (0..MAX_STEPS).rev() {
            let at = [corner[0] + shift[0], corner[1] + shift[1]];
            frame.values(at, self.width, self.height, &mut values)?;
            let (mut products, mut squares) = (Vector4::<f64>::zeros(), 0.0);
            for ((value, column), weight) in values.iter().zip(&self.columns).zip(&self.weights) {
                let weighted = weight * value;
                squares += weighted * value;
                for (product, column) in products.iter_mut().zip(column) {
                    *product += weighted * column;
                }
            }
            let found = self.inverse * products;
            let [gain, offset, along_x, along_y]: [f64; 4] = found.into();
            if !(GAINS[0]..GAINS[1]).contains(&gain) {
                return None;
            }
            let step = [along_x, along_y].map(|slope| (-slope / gain).clamp(-1.5, 1.5));
            shift = [shift[0] + step[0], shift[1] + step[1]];
            let short = if left == 0 { LAST_PX } else { SHORT_PX };
            if step.iter().all(|step| step.abs() < short) {
                let count = self.columns.len() as f64;
                let residuals = (squares - found.dot(&products)).max(0.0) / (count - 4.0);
                let [x, y] = at.map(|at| noise_gain(at - at.floor()));
                let noise = residuals / (x * y + self.own_noise) + 1e-6;
                let sum: f64 = self.weights.iter().sum();
                let mean = values.iter().zip(&self.weights).map(|(v, w)| v * w).sum::<f64>() / sum;
                let contrast = (squares - sum * mean * mean).max(0.0) / count;
                let deviation = self.deviation(noise, gain);
                return Some(Fit { shift, gain, offset, deviation, noise, contrast });
            }
        }
        None
    }
}
