//! Pictures between their pixels, as cubic B-splines (Unser, Aldroubi & Eden, IEEE Trans. Signal
//! Process. 41, 1993, 821–848) of one or more nodes a pixel.

/// The pole of the filter that turns samples into coefficients, √3 − 2.
const POLE: f64 = -0.267_949_192_431_122_7;

/// Samples after which the pole's power is nothing.
const REACH: usize = 16;

/// Pixels about a box at which there are nodes, too.
pub(super) const RIM: usize = 6;

/// Values at nodes, row by row: the first is `RIM` pixels left of and above the first pixel of a
/// box, the last nearly as far behind its last.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    /// Pixels of the box.
    pub(super) width: usize,
    pub(super) height: usize,
    /// Nodes a pixel, along both axes.
    pub(super) per_px: usize,
    pub(super) values: Vec<f64>,
}

impl Nodes {
    /// Nodes in a row, and rows.
    pub(super) fn counts(width: usize, height: usize, per_px: usize) -> [usize; 2] {
        [width, height].map(|side| (side + 2 * RIM) * per_px)
    }
}

/// A picture that has values and slopes at every place.
#[derive(Debug, Clone)]
pub(super) struct Spline {
    width: usize,
    height: usize,
    per_px: usize,
    /// Coefficients, such that those one pixel apart lie beside each other: for each node within a
    /// pixel, row by row, a plane with one value a pixel.
    planes: Vec<Vec<f64>>,
}

/// Values of a spline at pixels, row by row, and its slopes there.
#[derive(Debug, Clone, Default)]
pub(super) struct Samples {
    pub(super) values: Vec<f64>,
    pub(super) along_x: Vec<f64>,
    pub(super) along_y: Vec<f64>,
}

/// Samples to coefficients, in place; mirrored at the ends.
fn filter(line: &mut [f64]) {
    let count = line.len();
    if count < 2 {
        return;
    }
    let mut sum = 0.0;
    for k in (0..count.min(REACH)).rev() {
        sum = line[k] + POLE * sum;
    }
    line[0] = sum;
    for k in 1..count {
        line[k] += POLE * line[k - 1];
    }
    let last = count - 1;
    line[last] = POLE / (POLE * POLE - 1.0) * (line[last] + POLE * line[last - 1]);
    for k in (0..last).rev() {
        line[k] = POLE * (line[k + 1] - line[k]);
    }
    line.iter_mut().for_each(|value| *value *= 6.0);
}

/// Values of the four splines about a place, `part` of a step behind the second, and their slopes.
fn weights(part: f64) -> [[f64; 2]; 4] {
    let rest = 1.0 - part;
    let near = |t: f64| [2.0 / 3.0 - t * t * (1.0 - 0.5 * t), -2.0 * t + 1.5 * t * t];
    let far = |t: f64| [t.powi(3) / 6.0, 0.5 * t * t];
    let turned = |[value, slope]: [f64; 2]| [value, -slope];
    [turned(far(rest)), near(part), turned(near(rest)), far(part)]
}

impl Spline {
    pub(super) fn of(nodes: &Nodes) -> Self {
        let Nodes { width, height, per_px, .. } = *nodes;
        let [across, down] = Nodes::counts(width, height, per_px);
        let mut coefficients = nodes.values.clone();
        coefficients.chunks_mut(across.max(1)).for_each(filter);
        let mut column = vec![0.0; down];
        for x in 0..across {
            for (y, value) in column.iter_mut().enumerate() {
                *value = coefficients[y * across + x];
            }
            filter(&mut column);
            for (y, value) in column.iter().enumerate() {
                coefficients[y * across + x] = *value;
            }
        }
        let plane = |index: usize| {
            let rows = coefficients.chunks(across.max(1)).skip(index / per_px).step_by(per_px);
            rows.flat_map(|row| row.iter().copied().skip(index % per_px).step_by(per_px)).collect()
        };
        let planes = (0..per_px * per_px).map(plane).collect();
        Self { width, height, per_px, planes }
    }

    /// The four splines at each pixel that is displaced by `part` against the nodes: for each the
    /// plane, the pixel in it, value and slope.
    fn taps(&self, part: f64, border: usize) -> [(usize, usize, [f64; 2]); 4] {
        let step = self.per_px as f64;
        let at = ((RIM - border) as f64 - part) * step;
        let first = at.floor().max(1.0);
        let weights = weights(at - first);
        let node = |k: usize| first as usize + k - 1;
        [0, 1, 2, 3].map(|k| {
            let [value, slope] = weights[k];
            (node(k) % self.per_px, node(k) / self.per_px, [value, step * slope])
        })
    }

    /// Values and slopes at the pixels of the box and of a border of so many pixels about it, no
    /// more than `RIM` − 3, where the picture is displaced by `part` of a pixel, less than one.
    pub(super) fn sample(&self, part: [f64; 2], border: usize, samples: &mut Samples) {
        let [width, height] = [self.width, self.height].map(|side| side + 2 * border);
        let [across, down] = part.map(|part| self.taps(part, border));
        let stride = self.width + 2 * RIM;
        for list in [&mut samples.values, &mut samples.along_x, &mut samples.along_y] {
            list.clear();
            list.resize(width * height, 0.0);
        }
        for y in 0..height {
            let row = y * width..(y + 1) * width;
            let values = &mut samples.values[row.clone()];
            let along_x = &mut samples.along_x[row.clone()];
            let along_y = &mut samples.along_y[row];
            for (plane, column, [weight, slope]) in across {
                let [a, b, c, d] = down.map(|(below, row, _)| {
                    let from = (y + row) * stride + column;
                    &self.planes[below * self.per_px + plane][from..][..width]
                });
                let [e, f, g, h] = down.map(|(.., [value, _])| value);
                let [k, l, m, n] = down.map(|(.., [_, slope])| slope);
                for x in 0..width {
                    let value = e * a[x] + f * b[x] + g * c[x] + h * d[x];
                    let sloping = k * a[x] + l * b[x] + m * c[x] + n * d[x];
                    values[x] += weight * value;
                    along_x[x] += slope * value;
                    along_y[x] += weight * sloping;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic polynomial is its own spline, at one node a pixel and at three.
    #[test]
    fn polynomials_and_their_slopes_are_reproduced() {
        let of = |x: f64, y: f64| 3.0 + 0.2 * x - 0.1 * y + 0.01 * x * y;
        for per_px in [1, 3] {
            let (width, height) = (40, 36);
            let [across, down] = Nodes::counts(width, height, per_px);
            let at = |k: usize| k as f64 / per_px as f64 - RIM as f64;
            let values = (0..across * down).map(|k| of(at(k % across), at(k / across))).collect();
            let spline = Spline::of(&Nodes { width, height, per_px, values });
            let mut samples = Samples::default();
            spline.sample([0.3, -0.6], 2, &mut samples);
            let index = 22 * (width + 4) + 17;
            let (x, y) = (15.0 - 0.3, 20.0 + 0.6);
            let found = [&samples.values, &samples.along_x, &samples.along_y].map(|v| v[index]);
            let expected = [of(x, y), 0.2 + 0.01 * y, -0.1 + 0.01 * x];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-3, "{per_px}: {found} {expected}");
            }
        }
    }
}
