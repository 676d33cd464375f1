//! Interpolation by cubic B-splines (Unser, Aldroubi & Eden, IEEE Trans. Signal Process. 41, 1993,
//! 821–848).

use super::picture::Crop;

/// The pole of the filter that turns samples into coefficients, √3 − 2.
const POLE: f64 = -0.267_949_192_431_122_7;

/// Samples after which the pole's power is nothing.
const REACH: usize = 16;

/// A crop as coefficients of a spline.
#[derive(Debug, Clone)]
pub(super) struct Spline {
    left: isize,
    top: isize,
    width: usize,
    height: usize,
    coefficients: Vec<f64>,
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

/// Values of the four splines about a place, `part` of a step behind the second.
fn weights(part: f64) -> [f64; 4] {
    let rest = 1.0 - part;
    let near = |t: f64| 2.0 / 3.0 - t * t * (1.0 - 0.5 * t);
    [rest.powi(3) / 6.0, near(part), near(rest), part.powi(3) / 6.0]
}

/// How interpolation at `part` of a step changes the variance of white noise, along one axis.
pub(super) fn noise_gain(part: f64) -> f64 {
    // Autocorrelation of the filter's impulse response, √3 POLE^|n|.
    let square = POLE * POLE;
    let correlation =
        |lag: i32| 3.0 * POLE.powi(lag) * ((1.0 + square) / (1.0 - square) + f64::from(lag));
    let weights = weights(part);
    let mut gain = 0.0;
    for (i, a) in weights.iter().enumerate() {
        for (j, b) in weights.iter().enumerate() {
            gain += a * b * correlation(i.abs_diff(j) as i32);
        }
    }
    gain
}

impl Spline {
    pub(super) fn of(crop: &Crop) -> Self {
        let Crop { left, top, width, height, .. } = *crop;
        let mut coefficients: Vec<f64> = crop.values.iter().copied().map(f64::from).collect();
        coefficients.chunks_mut(width.max(1)).for_each(filter);
        let mut column = vec![0.0; height];
        for x in 0..width {
            for (y, value) in column.iter_mut().enumerate() {
                *value = coefficients[y * width + x];
            }
            filter(&mut column);
            for (y, value) in column.iter().enumerate() {
                coefficients[y * width + x] = *value;
            }
        }
        Self { left, top, width, height, coefficients }
    }

    /// Values at `width` × `height` places one pixel apart from (x, y) on, row by row; `None` where
    /// the crop does not reach that far.
    pub(super) fn values(
        &self,
        [x, y]: [f64; 2],
        width: usize,
        height: usize,
        values: &mut Vec<f64>,
    ) -> Option<()> {
        let (column, row) = (x.floor(), y.floor());
        let across = weights(x - column);
        let down = weights(y - row);
        let first = |at: f64, from: isize| usize::try_from(at as isize - 1 - from).ok();
        let (column, row) = (first(column, self.left)?, first(row, self.top)?);
        if column + width + 3 > self.width || row + height + 3 > self.height {
            return None;
        }
        let mut rows = Vec::with_capacity((height + 3) * width);
        for y in row..row + height + 3 {
            let line = &self.coefficients[y * self.width + column..][..width + 3];
            rows.extend(line.windows(4).map(|c| {
                c[0] * across[0] + c[1] * across[1] + c[2] * across[2] + c[3] * across[3]
            }));
        }
        values.clear();
        for y in 0..height {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| &rows[(y + k) * width..][..width]);
            values.extend(
                (0..width)
                    .map(|x| a[x] * down[0] + b[x] * down[1] + c[x] * down[2] + d[x] * down[3]),
            );
        }
        Some(())
    }

    /// The slope along x and y at a pixel of the crop that is not at its edge.
    pub(super) fn slope(&self, x: usize, y: usize) -> [f64; 2] {
        const SMOOTH: [f64; 3] = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];
        let at = |x: usize, y: usize| self.coefficients[y * self.width + x];
        let along_x =
            (0..3).map(|k| SMOOTH[k] * 0.5 * (at(x + 1, y + k - 1) - at(x - 1, y + k - 1)));
        let along_y =
            (0..3).map(|k| SMOOTH[k] * 0.5 * (at(x + k - 1, y + 1) - at(x + k - 1, y - 1)));
        [along_x.sum(), along_y.sum()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic polynomial is its own spline; noise keeps its variance at samples and loses some
    /// between them.
    #[test]
    fn polynomials_are_reproduced_and_noise_is_not_raised() {
        let of = |x: f64, y: f64| 3.0 + 0.2 * x - 0.1 * y + 0.01 * x * y;
        let pixels = (0..40 * 40).map(|k| of(f64::from(k % 40), f64::from(k / 40)) as f32);
        let crop = Crop { left: 0, top: 0, width: 40, height: 40, values: pixels.collect() };
        let spline = Spline::of(&crop);
        let mut values = Vec::new();
        spline.values([15.3, 16.8], 5, 4, &mut values).unwrap();
        for (k, value) in values.iter().enumerate() {
            let expected = of(15.3 + (k % 5) as f64, 16.8 + (k / 5) as f64);
            assert!((value - expected).abs() < 1e-4, "{value} {expected}");
        }
        let [x, y] = spline.slope(20, 18);
        assert!((x - 0.38).abs() < 1e-4 && (y - 0.1).abs() < 1e-4, "{x} {y}");
        assert!(spline.values([36.0, 1.0], 5, 4, &mut values).is_none());
        assert!((noise_gain(0.0) - 1.0).abs() < 1e-12 && (noise_gain(1.0) - 1.0).abs() < 1e-12);
        // Cardinal cubic spline at half steps, Σ of squares: 2 (0.6010² + 0.1242² + 0.0333² + …).
        assert!((noise_gain(0.5) - 0.756).abs() < 0.002, "{}", noise_gain(0.5));
    }
}
