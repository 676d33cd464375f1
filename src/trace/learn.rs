//! The picture of a mark, learned from the frames in which it was found.

use super::disc::disc;
use super::picture::{Area, Crop};
use super::spline::{Nodes, RIM, Samples, Spline};
use super::template::{Fit, ROUNDING, Template, split};

/// Fewer frames say nothing of single pixels.
const FEW_FRAMES: usize = 6;

/// How often picture and weights are found anew, at most; and the change of a place that ends it,
/// px.
const ROUNDS: usize = 10;
const SETTLED_PX: f64 = 1e-3;

/// Nodes a pixel: a pixel's mean over its area has detail that one does not hold.
const PER_PX: usize = 2;

/// How often the picture is made to agree with the frames in each round.
const PASSES: usize = 3;

/// Pixels about the box that are learned, too.
const BORDER: usize = 3;

/// A node keeps its value where it has seen less than this share of what it sees on average.
const UNSEEN: f64 = 0.02;

/// Weight of a pixel that has not changed, where others have: still background, or plain.
const UNCHANGED: f64 = 0.01;

/// Pixels about one that has changed count as it does: of those along an edge, the ones that the
/// edge's slope is too low at would be too many otherwise.
const ABOUT: usize = 2;

/// Fewer pixels that change are no motion.
const FEW_PIXELS: usize = 16;

/// A pixel whose variance is so many times that of the steadiest does not move with the mark.
const STILL: f64 = 3.0;

/// Nor is it told by what places that are off by so much leave at the mark's own slopes, px.
const MISPLACED_PX: f64 = 0.1;

/// A box of which less moves with the mark is not plain about it.
const PLAIN: f64 = 0.8;

/// A mark is taken for a disc where that leaves no more than this share more of the frames than
/// what was learned of them, found on so many of them.
const DISC: f64 = 0.05;
const DISC_FRAMES: usize = 48;

/// What the learned picture leaves of the error that one node a pixel would make.
const LEFT: f64 = 0.35;

/// Frames, and where the mark is in each.
type Frames<'f> = [(&'f Crop, Option<Fit>)];

/// A template that says more than the first, which is that of one frame; the frames are fitted to
/// it. Pixels that do not move with the mark, such as still background in its box, count by the
/// inverse of their variance.
pub(super) fn learned(first: &Template, frames: &mut Frames<'_>) -> Template {
    let mut template = first.clone();
    if found(frames) < FEW_FRAMES {
        return template;
    }
    // Where background and mark both have detail, what changes in the box is the mark.
    if let Some(weights) = changing(first.area, frames) {
        adopt(&mut template, first.nodes.clone(), weights, frames);
    }
    let (before, placed) = (template.clone(), frames.to_vec());
    settle(&mut template, PER_PX, frames);
    let moving = template.weights().iter().filter(|weight| **weight == 1.0).count();
    if (moving as f64) < PLAIN * template.weights().len() as f64 {
        // What little of the box moves with the mark does not tell that much detail.
        frames.copy_from_slice(&placed);
        template = before;
        settle(&mut template, 1, frames);
    }
    let few: Vec<(&Crop, [f64; 2])> = {
        let found = frames.iter().filter_map(|(crop, fit)| Some((*crop, fit.as_ref()?.shift)));
        let found: Vec<_> = found.collect();
        let stride = found.len().div_ceil(DISC_FRAMES).max(1);
        found.into_iter().step_by(stride).collect()
    };
    let left = |template: &Template| {
        let noise = few.iter().map(|(crop, shift)| Some(template.fit(crop, *shift)?.noise));
        noise.sum::<Option<f64>>()
    };
    // A learned picture also fits the noise of the frames that it is learned from.
    let most = 1.0 + DISC + (PER_PX * PER_PX) as f64 / found(frames).max(1) as f64;
    let round = disc(&template, &few);
    let round = round.filter(|disc| match (left(disc), left(&template)) {
        (Some(disc), Some(learned)) => disc < most * learned,
        _ => false,
    });
    match round {
        Some(disc) => {
            template = disc;
            refit(&template, frames);
            let nodes = template.nodes.clone();
            let by_variance = weights(&template, &nodes, frames);
            template = Template::new(first.area, nodes, by_variance, 0.0).unwrap_or(template);
        }
        None => template.unsure = unsure(&template),
    }
    refit(&template, frames);
    template
}

/// Learns picture and weights until places no longer change.
fn settle(template: &mut Template, per_px: usize, frames: &mut Frames<'_>) {
    let nodes = finer(&agreeing(template, frames, 1), per_px);
    let same = template.weights().to_vec();
    adopt(template, nodes, same, frames);
    for _ in 0..ROUNDS {
        let nodes = agreeing(template, frames, PASSES);
        let by_variance = weights(template, &nodes, frames);
        if adopt(template, nodes, by_variance, frames) < SETTLED_PX {
            break;
        }
    }
}

fn found(frames: &Frames<'_>) -> usize {
    frames.iter().filter(|(_, fit)| fit.is_some()).count()
}

/// Fits frames to a template; how far the farthest moved, px.
fn refit(template: &Template, frames: &mut Frames<'_>) -> f64 {
    let mut farthest: f64 = 0.0;
    for (crop, fit) in frames {
        let Some(old) = *fit else { continue };
        *fit = template.fit(crop, old.shift);
        if let Some(new) = fit {
            let moved = (new.shift[0] - old.shift[0]).hypot(new.shift[1] - old.shift[1]);
            farthest = farthest.max(moved);
        }
    }
    farthest
}

/// Goes over to another picture, if it can be told where that is.
fn adopt(template: &mut Template, nodes: Nodes, weights: Vec<f64>, frames: &mut Frames<'_>) -> f64 {
    let own_noise = 1.0 / found(frames).max(1) as f64;
    match Template::new(template.area, nodes, weights, own_noise) {
        Some(new) => {
            *template = new;
            refit(template, frames)
        }
        None => 0.0,
    }
}

/// The nodes of a picture, in which each was corrected by the mean of what frames show near it
/// beyond the picture (back-projection: Irani & Peleg, CVGIP: Graph. Models Image Process. 53,
/// 1991, 231–239).
fn agreeing(template: &Template, frames: &Frames<'_>, passes: usize) -> Nodes {
    let mut nodes = template.nodes.clone();
    let Area { width, height, .. } = template.area;
    let [across, down] = Nodes::counts(width, height, nodes.per_px);
    let mut samples = Samples::default();
    for _ in 0..passes {
        let spline = Spline::of(&nodes);
        let mut sums = vec![[0.0; 2]; across * down];
        for (crop, fit) in frames {
            let Some(fit) = fit else { continue };
            let (whole, part) = split(fit.shift);
            let Some(rows) = crop.rows(template.area, whole, BORDER) else { continue };
            spline.sample(part, BORDER, &mut samples);
            let [x, y] = part.map(|part| ((RIM - BORDER) as f64 - part) * nodes.per_px as f64);
            let (column, row) = (x.floor(), y.floor());
            let shares = |part: f64| [1.0 - part, part];
            let (shares_x, shares_y) = (shares(x - column), shares(y - row));
            let first = row as usize * across + column as usize;
            let values = samples.values.chunks(width + 2 * BORDER);
            for (y, (row, values)) in rows.zip(values).enumerate() {
                for (x, (pixel, value)) in row.iter().zip(values).enumerate() {
                    let beyond = (f64::from(*pixel) - fit.offset) / fit.gain - value;
                    let node = first + (y * across + x) * nodes.per_px;
                    for (row, share_y) in shares_y.iter().enumerate() {
                        for (column, share_x) in shares_x.iter().enumerate() {
                            let share = share_x * share_y;
                            let [sum, weight] = &mut sums[node + row * across + column];
                            *sum += share * beyond;
                            *weight += share;
                        }
                    }
                }
            }
        }
        let usual = found(frames) as f64 / (nodes.per_px * nodes.per_px) as f64;
        for (value, [sum, weight]) in nodes.values.iter_mut().zip(&sums) {
            *value += sum / (weight + UNSEEN * usual);
        }
    }
    nodes
}

/// The same picture with more nodes.
fn finer(nodes: &Nodes, per_px: usize) -> Nodes {
    let Nodes { width, height, .. } = *nodes;
    let [across, down] = Nodes::counts(width, height, per_px);
    let spline = Spline::of(nodes);
    let mut samples = Samples::default();
    let border = RIM - 3;
    let stride = width + 2 * border;
    // Beyond the border nothing is ever sampled but its neighbours.
    let near = |at: usize, count: usize| (at / per_px).clamp(3, count + RIM + 2) - 3;
    let mut values = vec![0.0; across * down];
    for y in 0..per_px {
        for x in 0..per_px {
            let part = [x, y].map(|k| -(k as f64) / per_px as f64);
            spline.sample(part, border, &mut samples);
            for row in (y..down).step_by(per_px) {
                for column in (x..across).step_by(per_px) {
                    let at = near(row, height) * stride + near(column, width);
                    values[row * across + column] = samples.values[at];
                }
            }
        }
    }
    Nodes { width, height, per_px, values }
}

/// Weights by which pixels count that change in the still box; `None` where too few do.
fn changing(area: Area, frames: &Frames<'_>) -> Option<Vec<f64>> {
    let mut spread = Spread::new(area);
    for (crop, fit) in frames {
        let Some((fit, rows)) = fit.as_ref().zip(crop.rows(area, [0, 0], 0)) else { continue };
        spread.take(rows.flatten().map(|value| (f64::from(*value) - fit.offset) / fit.gain));
    }
    let (variances, usual) = spread.variances()?;
    let mut weights = vec![UNCHANGED; variances.len()];
    let changed = (0..variances.len()).filter(|k| variances[*k] > STILL * usual);
    let count = changed.clone().count();
    for k in changed {
        let about = |at: usize, most: usize| at.saturating_sub(ABOUT)..(at + ABOUT + 1).min(most);
        for y in about(k / area.width, area.height) {
            let row = y * area.width;
            about(k % area.width, area.width).for_each(|x| weights[row + x] = 1.0);
        }
    }
    (count >= FEW_PIXELS).then_some(weights)
}

/// Weights by what a picture leaves of each pixel.
fn weights(template: &Template, nodes: &Nodes, frames: &Frames<'_>) -> Vec<f64> {
    let spline = Spline::of(nodes);
    let mut spread = Spread::new(template.area);
    let mut samples = Samples::default();
    for (crop, fit) in frames {
        let Some(fit) = fit else { continue };
        let (whole, part) = split(fit.shift);
        let Some(rows) = crop.rows(template.area, whole, 0) else { continue };
        spline.sample(part, 0, &mut samples);
        let pixels = rows.flatten().zip(&samples.values);
        spread.take(pixels.map(|(seen, value)| (f64::from(*seen) - fit.offset) / fit.gain - value));
    }
    let Some((variances, usual)) = spread.variances() else { return template.weights().to_vec() };
    spline.sample([0.0; 2], 0, &mut samples);
    let slopes = samples.along_x.iter().zip(&samples.along_y);
    let weight = |(variance, (x, y)): (&f64, (&f64, &f64))| {
        let own = (x * x + y * y) * MISPLACED_PX * MISPLACED_PX;
        if *variance > STILL * usual + own { usual / variance } else { 1.0 }
    };
    variances.iter().zip(slopes).map(weight).collect()
}

/// Sums and sums of squares of the pixels of a box.
struct Spread {
    sums: Vec<[f64; 2]>,
    count: usize,
}

impl Spread {
    fn new(area: Area) -> Self {
        Self { sums: vec![[0.0; 2]; area.width * area.height], count: 0 }
    }

    fn take(&mut self, values: impl Iterator<Item = f64>) {
        for ([sum, squares], value) in self.sums.iter_mut().zip(values) {
            *sum += value;
            *squares += value * value;
        }
        self.count += 1;
    }

    /// The variance of each pixel, and the usual one; `None` of few frames.
    fn variances(&self) -> Option<(Vec<f64>, f64)> {
        let count = self.count as f64;
        let variance =
            |[sum, squares]: &[f64; 2]| ((squares - sum * sum / count) / (count - 1.0)).max(0.0);
        (self.count >= FEW_FRAMES).then(|| {
            let variances: Vec<f64> = self.sums.iter().map(variance).collect();
            let usual = low_variance(&variances, count - 1.0).max(ROUNDING);
            (variances, usual)
        })
    }
}

/// The variance that the steadiest tenth of the pixels has, from estimates of so many degrees of
/// freedom (quantile of χ² by Wilson & Hilferty).
fn low_variance(variances: &[f64], freedom: f64) -> f64 {
    const TENTH: f64 = -1.281_55;
    let share = 2.0 / (9.0 * freedom);
    let quantile = (1.0 - share + TENTH * share.sqrt()).powi(3);
    let mut sorted = variances.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 10).map_or(0.0, |low| low / quantile)
}

/// How far places may be off, px: the form of a mark between its pixels is known from the marks'
/// other places alone, so a part of what one node a pixel would leave stays.
fn unsure(template: &Template) -> [f64; 2] {
    let area = template.area;
    let Area { left, top, width, height } = area;
    let mut samples = Samples::default();
    let border = RIM - 3;
    template.sample([0.0; 2], border, &mut samples);
    let coarse = |_: ()| {
        let [across, down] = Nodes::counts(width, height, 1);
        let near = |at: usize, count: usize| at.clamp(3, count + RIM + 2) - 3;
        let at =
            |k: usize| near(k / across, height) * (width + 2 * border) + near(k % across, width);
        let values = (0..across * down).map(|k| samples.values[at(k)]).collect();
        let nodes = Nodes { width, height, per_px: 1, values };
        Template::new(area, nodes, template.weights().to_vec(), 0.0)
    };
    let Some(coarse) = coarse(()) else { return [0.0; 2] };
    let (mut squares, mut count) = ([0.0; 2], 0.0);
    let mut moved = Samples::default();
    for k in 0..16 {
        let shift = [k % 4, k / 4].map(|quarter| 0.25 * quarter as f64 - 0.25);
        template.sample(shift, border, &mut moved);
        let crop = Crop {
            left: left as isize - border as isize,
            top: top as isize - border as isize,
            width: width + 2 * border,
            height: height + 2 * border,
            values: moved.values.iter().map(|value| *value as f32).collect(),
        };
        if let Some(fit) = coarse.fit(&crop, shift) {
            for axis in 0..2 {
                squares[axis] += (fit.shift[axis] - shift[axis]).powi(2);
            }
            count += 1.0;
        }
    }
    squares.map(|squares| LEFT * (squares / f64::max(count, 1.0)).sqrt())
}
