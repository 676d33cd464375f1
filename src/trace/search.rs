//! A mark that is not where it is expected, on whole pixels.

use super::picture::{Area, Picture};
use super::template::Template;

/// So many pixels of a template are compared, spread over it.
const COMPARED: usize = 600;

/// The whole-pixel displacement within `reach` of `about` at which the picture resembles the
/// template most, by correlation.
pub(super) fn search(
    picture: &Picture<'_>,
    template: &Template,
    area: Area,
    about: [f64; 2],
    reach: isize,
) -> [f64; 2] {
    let Area { left, top, width, height } = area;
    let stride = ((width * height) as f64 / COMPARED as f64).sqrt().ceil().max(1.0) as usize;
    let mut pixels = Vec::new();
    for y in (0..height).step_by(stride) {
        for x in (0..width).step_by(stride) {
            let index = y * width + x;
            let place = ((left + x) as isize, (top + y) as isize);
            pixels.push((place, template.value(index) as f32, template.weights()[index] as f32));
        }
    }
    let weight: f32 = pixels.iter().map(|pixel| pixel.2).sum();
    let mean = pixels.iter().map(|(_, value, w)| value * w).sum::<f32>() / weight;
    let [x, y] = about.map(|at| at.round() as isize);
    // Only where the whole mark is in the picture.
    let allowed = |at: isize, from: usize, count: usize, most: usize| {
        let low = -(from as isize);
        let high = (most - count) as isize - from as isize;
        (at - reach).clamp(low, high)..=(at + reach).clamp(low, high)
    };
    let mut best = (f32::NEG_INFINITY, about);
    for dy in allowed(y, top, height, picture.height) {
        for dx in allowed(x, left, width, picture.width) {
            let (mut sum, mut squares, mut product) = (0.0, 0.0, 0.0);
            for &((x, y), value, weight) in &pixels {
                let seen = picture.at(x + dx, y + dy);
                sum += weight * seen;
                squares += weight * seen * seen;
                product += weight * seen * (value - mean);
            }
            let spread = (squares - sum * sum / weight).max(1e-3);
            let score = product / spread.sqrt();
            if score > best.0 {
                best = (score, [dx as f64, dy as f64]);
            }
        }
    }
    best.1
}
