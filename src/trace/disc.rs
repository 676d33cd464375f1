//! The picture of a disc: each pixel is the mean over its area of an ellipse with a blurred edge.

use nalgebra::{Matrix4, Vector4};
use statrs::function::erf::erf;

use super::picture::{Area, Crop};
use super::spline::{Nodes, RIM, Samples, Spline};
use super::template::{Template, columns, split};
use crate::statistics::median;

/// Nodes a pixel.
const PER_PX: usize = 4;

/// Smallest variance of the blur at the edge, px²; less makes no difference in a pixel.
const SHARP: f64 = 4e-4;

/// Beyond so many deviations of the blur nothing is blurred.
const FAR: f64 = 6.0;

/// Steps that end the fit, px or as shares, and the longest.
const SHORT: f64 = 1e-3;
const LONG: f64 = 0.5;
const MAX_STEPS: usize = 12;

/// Step of the differences that the slopes with the form are taken by.
const DIFFERENCE: f64 = 1e-3;

/// A circle looks no flatter than this share.
const MAX_FLATTENING: f64 = 0.4;

/// Smallest radius, px.
const MIN_RADIUS_PX: f64 = 1.5;

/// The form of a disc, seen at a slant.
#[derive(Debug, Clone, Copy)]
struct Disc {
    middle: [f64; 2],
    /// Radius, px; flattening along x against y, and along the diagonals; variance of the Gaussian
    /// blur at the edge, px².
    form: [f64; 4],
}

/// The template of the disc that leaves least of frames, from a template that was learned of them;
/// `None` where none fits.
pub(super) fn disc(learned: &Template, frames: &[(&Crop, [f64; 2])]) -> Option<Template> {
    let mut disc = Disc::at_half_height(learned)?;
    for _ in 0..MAX_STEPS {
        let step = disc.step(learned, frames)?;
        for (value, step) in disc.form.iter_mut().zip(step) {
            *value += step.clamp(-LONG, LONG);
        }
        let [radius, a, b, blur] = &mut disc.form;
        *blur = blur.max(SHARP);
        let is_disc = *radius >= MIN_RADIUS_PX && a.hypot(*b) <= MAX_FLATTENING;
        if !is_disc {
            return None;
        }
        if step.iter().take(3).all(|step| step.abs() < SHORT) {
            return disc.template(learned);
        }
    }
    None
}

impl Disc {
    /// From the pixels that are nearer to the grey value at the middle of the box than to that at
    /// its border.
    fn at_half_height(learned: &Template) -> Option<Self> {
        let (width, height) = (learned.area.width, learned.area.height);
        let mut border = Vec::new();
        let mut inside = Vec::new();
        for k in 0..width * height {
            let (x, y) = (k % width, k / width);
            let off = |at: usize, count: usize| (2 * at + 1).abs_diff(count);
            if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
                border.push(learned.value(k));
            } else if off(x, width) <= 4 && off(y, height) <= 4 {
                inside.push(learned.value(k));
            }
        }
        let about = median(border)?;
        let level = 0.5 * (about + median(inside)?);
        let (mut count, mut sums) = (0.0, [0.0; 2]);
        for k in 0..width * height {
            if (learned.value(k) > level) != (about > level) {
                count += 1.0;
                sums = [sums[0] + (k % width) as f64, sums[1] + (k / width) as f64];
            }
        }
        let radius = (count / std::f64::consts::PI).sqrt();
        (radius >= MIN_RADIUS_PX)
            .then(|| Self { middle: sums.map(|sum| sum / count), form: [radius, 0.0, 0.0, 0.2] })
    }

    /// Its share of each pixel about a node.
    fn shares(&self, Area { width, height, .. }: Area) -> Nodes {
        const SIDE: f64 = 1.0 / PER_PX as f64;
        let [across, down] = Nodes::counts(width, height, PER_PX);
        // Cells between the nodes, and half a pixel more on either side.
        let (columns, rows) = (across + PER_PX - 1, down + PER_PX - 1);
        let place = |k: usize| (k as f64 + 0.5) * SIDE - 0.5 - RIM as f64;
        let mut sums = vec![0.0; across * rows];
        for (y, line) in sums.chunks_mut(across).enumerate() {
            let cells: Vec<f64> =
                (0..columns).map(|x| self.share([place(x), place(y)], SIDE)).collect();
            for (sum, cells) in line.iter_mut().zip(cells.windows(PER_PX)) {
                *sum = cells.iter().sum::<f64>();
            }
        }
        let values = (0..across * down)
            .map(|k| (0..PER_PX).map(|row| sums[k + row * across]).sum::<f64>() * SIDE * SIDE);
        Nodes { width, height, per_px: PER_PX, values: values.collect() }
    }

    /// Its share of a square, in which its edge is taken as straight.
    fn share(&self, at: [f64; 2], side: f64) -> f64 {
        let [radius, a, b, blur] = self.form;
        let (x, y) = (at[0] - self.middle[0], at[1] - self.middle[1]);
        let (along_x, along_y) = ((1.0 + a) * x + b * y, b * x + (1.0 - a) * y);
        let (size, slope) = ((x * along_x + y * along_y).sqrt(), along_x.hypot(along_y));
        let blur = blur.sqrt();
        // Distance to the edge, positive inside; exact for a circle.
        let inside = (radius - size) * size / slope.max(1e-9);
        let reach = FAR * blur + side;
        if size < 0.5 || inside.abs() > reach {
            return if radius > size { 1.0 } else { 0.0 };
        }
        // Mean of Φ(inside/blur) over the square by its second integral at the corners.
        let half = |part: f64| 0.5 * side * (part / slope).abs().max(1e-3);
        let (a, b) = (half(along_x), half(along_y));
        let integral = |z: f64| {
            let t = z / blur;
            let cumulative = 0.5 * (1.0 + erf(t * std::f64::consts::FRAC_1_SQRT_2));
            let density = (-0.5 * t * t).exp() / std::f64::consts::TAU.sqrt();
            0.5 * ((z * z + blur * blur) * cumulative + z * blur * density)
        };
        let corners =
            integral(inside + a + b) - integral(inside + a - b) - integral(inside - a + b)
                + integral(inside - a - b);
        (corners / (4.0 * a * b)).clamp(0.0, 1.0)
    }

    /// Grey value about it, and by how much it differs, in a learned template.
    fn greys(&self, shares: &Nodes, learned: &Template) -> [f64; 2] {
        let width = learned.area.width;
        let [across, _] = Nodes::counts(width, learned.area.height, PER_PX);
        let (mut n, mut s, mut ss, mut v, mut sv) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (k, weight) in learned.weights().iter().enumerate() {
            let (row, column) = (k / width + RIM, k % width + RIM);
            let share = shares.values[(row * across + column) * PER_PX];
            let value = learned.value(k);
            n += weight;
            s += weight * share;
            ss += weight * share * share;
            v += weight * value;
            sv += weight * share * value;
        }
        let contrast = (sv - s * v / n) / (ss - s * s / n);
        [(v - contrast * s) / n, contrast]
    }

    /// A template of this form, with the grey values and weights of the learned one.
    fn template(&self, learned: &Template) -> Option<Template> {
        let shares = self.shares(learned.area);
        let [ground, contrast] = self.greys(&shares, learned);
        let values = shares.values.iter().map(|share| ground + contrast * share).collect();
        let nodes = Nodes { values, ..shares };
        Template::new(learned.area, nodes, learned.weights().to_vec(), 0.0)
    }

    /// The change of the form that leaves less of the frames, where each has its own place, gain
    /// and offset.
    fn step(&self, learned: &Template, frames: &[(&Crop, [f64; 2])]) -> Option<[f64; 4]> {
        let template = self.template(learned)?;
        let shares = self.shares(learned.area);
        let [_, contrast] = self.greys(&shares, learned);
        let slopes = [0, 1, 2, 3].map(|k| {
            let mut moved = *self;
            moved.form[k] += DIFFERENCE;
            let mut nodes = moved.shares(learned.area);
            for (value, share) in nodes.values.iter_mut().zip(&shares.values) {
                *value = contrast * (*value - share) / DIFFERENCE;
            }
            Spline::of(&nodes)
        });
        let (mut normal, mut products) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
        let mut samples = Samples::default();
        let mut changes = [0; 4].map(|_| Samples::default());
        for (crop, shift) in frames {
            let Some(fit) = template.fit(crop, *shift) else { continue };
            let (whole, part) = split(fit.shift);
            let Some(rows) = crop.rows(template.area, whole, 0) else { continue };
            template.sample(part, 0, &mut samples);
            for (slope, change) in slopes.iter().zip(&mut changes) {
                slope.sample(part, 0, change);
            }
            let (mut own, mut mixed) = (Matrix4::<f64>::zeros(), Matrix4::<f64>::zeros());
            let pixels = rows.flatten().zip(columns(&samples)).zip(template.weights());
            for (k, ((value, column), weight)) in pixels.enumerate() {
                let residual = f64::from(*value) - fit.gain * column[0] - fit.offset;
                let change = Vector4::from_fn(|i, _| fit.gain * changes[i].values[k]);
                let column = Vector4::from(column);
                own += column * column.transpose() * *weight;
                mixed += column * change.transpose() * *weight;
                normal += change * change.transpose() * *weight;
                products += change * (residual * weight);
            }
            normal -= mixed.transpose() * own.try_inverse()? * mixed;
        }
        let step = normal.try_inverse()? * products;
        step.iter().all(|step| step.is_finite()).then(|| step.into())
    }
}
