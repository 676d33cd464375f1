//! Round marks found in a picture: discs that are darker or lighter than what is around them.

use super::picture::{Area, Picture};

/// Levels of grey at which the picture is cut.
const LEVELS: u32 = 24;

/// A mark shows at this share of the levels that the clearest one shows at.
const CLEAR: f64 = 0.25;

/// Nobody has more marks; a picture that shows more shows a pattern.
const MAX_FOUND: usize = 1000;

/// Fewest levels.
const FEW_LEVELS: usize = 3;

/// Smallest radius, px, and largest, as a share of the picture.
const MIN_RADIUS_PX: f64 = 2.5;
const MAX_RADIUS: f64 = 0.125;

/// A disc's second moments differ by no more than this along any two directions, and its area from
/// that of a disc with these moments.
const ROUND: f64 = 0.15;

/// No pixel of a disc lies further outside of its radius than this share, or this many pixels.
const BEYOND: f64 = 0.1;
const BEYOND_PX: f64 = 0.8;

/// Pixels about a mark in its box: its edge, and what is around.
const ABOUT_PX: f64 = 4.0;

/// A round mark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Round {
    /// Its middle, px.
    pub middle: [f64; 2],
    /// Its radius, px.
    pub radius: f64,
    /// The box about it.
    pub area: Area,
}

/// A connected set of pixels: count, sums of x, y, x², y², xy, and whether it touches the edge.
#[derive(Debug, Clone, Copy, Default)]
struct Blob {
    count: f64,
    sums: [f64; 5],
    is_cut: bool,
}

impl Blob {
    fn disc(&self, pixels: &[[f64; 2]], most: f64) -> Option<([f64; 2], f64)> {
        let [x, y, xx, yy, xy] = self.sums.map(|sum| sum / self.count);
        let radius = (self.count / std::f64::consts::PI).sqrt();
        // Second moments of a disc are r²/4; pixels add 1/12.
        let [a, b, c] = [xx - x * x + 1.0 / 12.0, yy - y * y + 1.0 / 12.0, xy - x * y];
        let expected = 0.25 * radius * radius;
        let half = (0.25 * (a - b).powi(2) + c * c).sqrt();
        let is_round = half < ROUND * expected
            && (0.5 * (a + b) - expected).abs() < ROUND * expected
            && radius >= MIN_RADIUS_PX
            && radius <= most;
        let reach = radius + BEYOND_PX.max(BEYOND * radius);
        (is_round && !self.is_cut && pixels.iter().all(|[a, b]| (a - x).hypot(b - y) <= reach))
            .then_some(([x, y], radius))
    }
}

/// The clearly visible round marks of a picture, from left to right.
pub fn find_round(picture: &Picture<'_>) -> Vec<Round> {
    let Picture { width, height, .. } = *picture;
    let grey: Vec<f32> = (0..width * height)
        .map(|k| picture.at((k % width) as isize, (k / width) as isize))
        .collect();
    let low = grey.iter().copied().fold(f32::INFINITY, f32::min);
    let high = grey.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let most = MAX_RADIUS * width.min(height) as f64;
    // Middle and radius summed over levels, and their number.
    let mut found: Vec<([f64; 3], usize)> = Vec::new();
    let mut marked = vec![false; grey.len()];
    'levels: for level in 1..LEVELS {
        let cut = low + (high - low) * level as f32 / LEVELS as f32;
        for is_light in [false, true] {
            for (marked, value) in marked.iter_mut().zip(&grey) {
                *marked = (*value > cut) == is_light;
            }
            for ([x, y], radius) in discs(&mut marked, width, height, most) {
                let is_full = found.len() == MAX_FOUND;
                let same = found.iter_mut().find(|(sums, count)| {
                    let [a, b, r] = sums.map(|sum| sum / *count as f64);
                    (a - x).hypot(b - y) < 0.3 * r && (radius / r - 1.0).abs() < 0.3
                });
                match same {
                    Some((sums, count)) => {
                        *sums = [sums[0] + x, sums[1] + y, sums[2] + radius];
                        *count += 1;
                    }
                    None if is_full => break 'levels,
                    None => found.push(([x, y, radius], 1)),
                }
            }
        }
    }
    let clearest = found.iter().map(|(_, count)| *count).max().unwrap_or(0);
    let least = FEW_LEVELS.max((CLEAR * clearest as f64).ceil() as usize);
    let clear = found.into_iter().filter(|(_, count)| *count >= least);
    let mut marks: Vec<Round> = clear
        .map(|(sums, count)| {
            let [x, y, radius] = sums.map(|sum| sum / count as f64);
            Round { middle: [x, y], radius, area: about([x, y], radius, width, height) }
        })
        .collect();
    marks.sort_by(|a, b| a.middle[0].total_cmp(&b.middle[0]));
    marks
}

/// The box about a mark, within the picture.
fn about([x, y]: [f64; 2], radius: f64, width: usize, height: usize) -> Area {
    let side = |middle: f64, most: usize| {
        let low = (middle - radius - ABOUT_PX).floor().max(0.0) as usize;
        let high = ((middle + radius + ABOUT_PX).ceil() as usize).min(most.saturating_sub(1));
        (low, high - low + 1)
    };
    let ((left, width), (top, height)) = (side(x, width), side(y, height));
    Area { left, top, width, height }
}

/// The discs among the connected sets of marked pixels, whose marks are taken away.
fn discs(marked: &mut [bool], width: usize, height: usize, most: f64) -> Vec<([f64; 2], f64)> {
    let (mut found, mut open, mut pixels) = (Vec::new(), Vec::new(), Vec::new());
    for start in 0..marked.len() {
        if !std::mem::take(&mut marked[start]) {
            continue;
        }
        open.push(start);
        let mut blob = Blob::default();
        pixels.clear();
        while let Some(at) = open.pop() {
            let (column, row) = (at % width, at / width);
            let (x, y) = (column as f64, row as f64);
            pixels.push([x, y]);
            blob.count += 1.0;
            for (sum, term) in blob.sums.iter_mut().zip([x, y, x * x, y * y, x * y]) {
                *sum += term;
            }
            let is_inside = column > 0 && row > 0 && column + 1 < width && row + 1 < height;
            blob.is_cut |= !is_inside;
            let beside = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then_some(at + 1),
                (row > 0).then(|| at - width),
                (row + 1 < height).then_some(at + width),
            ];
            for next in beside.into_iter().flatten() {
                if std::mem::take(&mut marked[next]) {
                    open.push(next);
                }
            }
        }
        found.extend(blob.disc(&pixels, most));
    }
    found
}
