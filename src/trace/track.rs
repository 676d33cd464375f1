//! Marks followed through the frames of a video.

use super::learn::learned;
use super::picture::{Area, Crop, Picture};
use super::search::search;
use super::spline::{Nodes, RIM};
use super::template::{Fit, ROUNDING, Template};
use crate::statistics::{median, upper_median};

/// Pixels about a mark that are cut out with it.
const MARGIN: usize = 10;

/// The mean picture of a mark is that of at most so many frames, and of at least so many bytes'
/// worth of them.
const MAX_LEARNED: usize = 240;
const MAX_LEARNED_BYTES: usize = 128 << 20;
const MIN_LEARNED: usize = 8;

/// A mark is lost where more than this share of its contrast is not explained.
const UNEXPLAINED: f64 = 0.2;

/// How far a mark may be from where it is expected, px.
const MIN_REACH_PX: usize = 16;
const MAX_REACH_PX: usize = 64;

/// A mark is not seen where its place is less certain than this, px.
const FAINT_PX: f64 = 0.3;

/// Nor where its grey values vary no more than this over the noise: noise alone has slopes, too.
const FAINT: f64 = 3.0;

/// Where a mark was in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// Middle of its box along x (to the right) and y (down), px.
    pub at: [f64; 2],
    /// Standard deviations, px.
    pub deviation: [f64; 2],
}

/// A mark through all frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// One a frame; `None` where the mark is lost.
    pub positions: Vec<Option<Position>>,
    /// Share of the box that moves with the mark; the rest is still background.
    pub moving: f64,
}

/// A box whose contents do not say where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Faint {
    /// Which of the boxes.
    pub index: usize,
}

/// Follows marks, frame by frame.
#[derive(Debug)]
pub struct Tracker {
    marks: Vec<Mark>,
    learned: usize,
}

#[derive(Debug)]
struct Mark {
    area: Area,
    template: Template,
    /// Variance of the noise of a pixel.
    noise: f64,
    fits: Vec<Option<Fit>>,
    /// Frames that are kept to learn from.
    kept: Vec<(usize, Crop)>,
    is_learned: bool,
}

/// What a mark saw in a frame.
struct Seen {
    fit: Option<(Fit, Crop)>,
    is_searched: bool,
}

impl Tracker {
    /// Begins with the boxes of the first picture, which lie within it.
    ///
    /// # Errors
    /// A box without detail.
    pub fn new(areas: &[Area], first: &Picture<'_>) -> Result<Self, Faint> {
        let marks: Result<Vec<_>, _> = areas
            .iter()
            .enumerate()
            .map(|(index, area)| Mark::new(*area, first).ok_or(Faint { index }))
            .collect();
        let marks = marks?;
        let bytes = |area: &Area| 4 * (area.width + 2 * MARGIN) * (area.height + 2 * MARGIN);
        let bytes: usize = areas.iter().map(bytes).sum();
        let learned = (MAX_LEARNED_BYTES / bytes.max(1)).clamp(MIN_LEARNED, MAX_LEARNED);
        Ok(Self { marks, learned })
    }

    /// Takes the next frame, the first included.
    pub fn take(&mut self, picture: &Picture<'_>) {
        let mut seen: Vec<Seen> = self.marks.iter().map(|mark| mark.see(picture)).collect();
        for index in self.on_each_other(&seen) {
            seen[index].fit = None;
        }
        let learned = self.learned;
        self.marks.iter_mut().zip(seen).for_each(|(mark, seen)| mark.take(seen, learned));
    }

    /// Two marks are not at one place: the one that was searched for found the other.
    fn on_each_other(&self, seen: &[Seen]) -> Vec<usize> {
        let middle = |index: usize| {
            let shift = seen[index].fit.as_ref()?.0.shift;
            let [x, y] = self.marks[index].area.middle();
            Some([x + shift[0], y + shift[1]])
        };
        let mut lost = Vec::new();
        for a in 0..seen.len() {
            for b in 0..a {
                let (Some(at), Some(other)) = (middle(a), middle(b)) else { continue };
                let size = |index: usize| {
                    let Area { width, height, .. } = self.marks[index].area;
                    width.min(height) as f64
                };
                let distance = (at[0] - other[0]).hypot(at[1] - other[1]);
                if distance < 0.25 * size(a).min(size(b)) {
                    let both = [a, b].into_iter();
                    let any = seen[a].is_searched || seen[b].is_searched;
                    lost.extend(both.filter(|&index| seen[index].is_searched || !any));
                }
            }
        }
        lost
    }

    /// The tracks of all marks.
    pub fn finish(mut self) -> Vec<Track> {
        self.marks.iter_mut().for_each(Mark::learn);
        self.marks.into_iter().map(Mark::track).collect()
    }
}

impl Mark {
    fn new(area: Area, first: &Picture<'_>) -> Option<Self> {
        let rimmed = first.crop(
            area.left as isize - RIM as isize,
            area.top as isize - RIM as isize,
            area.width + 2 * RIM,
            area.height + 2 * RIM,
        );
        let noise = noise_of(&rimmed);
        let weights = vec![1.0; area.width * area.height];
        let Area { width, height, .. } = area;
        let values = rimmed.values.iter().copied().map(f64::from).collect();
        let nodes = Nodes { width, height, per_px: 1, values };
        let template = Template::new(area, nodes, weights, 1.0)?;
        let count = (area.width * area.height) as f64;
        let grey = || (0..area.width * area.height).map(|index| template.value(index));
        let mean = grey().sum::<f64>() / count;
        let variance = grey().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
        let is_seen = template.deviation(noise, 1.0).iter().all(|px| *px < FAINT_PX)
            && variance > FAINT * noise;
        is_seen.then_some(Self {
            area,
            template,
            noise,
            fits: Vec::new(),
            kept: Vec::new(),
            is_learned: false,
        })
    }

    fn crop(&self, picture: &Picture<'_>, near: [f64; 2]) -> Crop {
        let [x, y] = near.map(|at| at.round() as isize - MARGIN as isize);
        let Area { left, top, width, height } = self.area;
        let (left, top) = (left as isize + x, top as isize + y);
        picture.crop(left, top, width + 2 * MARGIN, height + 2 * MARGIN)
    }

    /// The mark in a frame, from a start.
    fn from(&self, picture: &Picture<'_>, mut start: [f64; 2]) -> Option<(Fit, Crop)> {
        // Once more where the fit led far from the start.
        for _ in 0..2 {
            let crop = self.crop(picture, start);
            let fit = self.template.fit(&crop, start)?;
            let is_near = (0..2).all(|k| (fit.shift[k] - start[k]).abs() < 2.0);
            if is_near {
                return Some((fit, crop)).filter(|(fit, _)| self.is_mark(fit, picture));
            }
            start = fit.shift;
        }
        None
    }

    fn is_mark(&self, fit: &Fit, picture: &Picture<'_>) -> bool {
        let Area { left, top, width, height } = self.area;
        let within = |from: usize, count: usize, shift: f64, all: usize| {
            let low = from as f64 + shift;
            low >= 0.0 && low + count as f64 <= all as f64
        };
        within(left, width, fit.shift[0], picture.width)
            && within(top, height, fit.shift[1], picture.height)
            && fit.noise - self.noise < UNEXPLAINED * fit.contrast
            && fit.deviation.iter().all(|px| *px < FAINT_PX)
    }

    fn see(&self, picture: &Picture<'_>) -> Seen {
        let mut recent = self.fits.iter().rev().map(|fit| fit.map(|fit| fit.shift));
        let (last, before) = (recent.next().flatten(), recent.next().flatten());
        if let Some(last) = last {
            let ahead = before.map(|before| [0, 1].map(|k| 2.0 * last[k] - before[k]));
            for start in ahead.into_iter().chain([last]) {
                if let Some(fit) = self.from(picture, start) {
                    return Seen { fit: Some(fit), is_searched: false };
                }
            }
        }
        let missed = self.fits.iter().rev().take_while(|fit| fit.is_none()).count();
        let known = self.fits.iter().rev().flatten().next();
        let Some(known) = known.map(|fit| fit.shift) else {
            // The first frame is where the template is from.
            return Seen { fit: self.from(picture, [0.0, 0.0]), is_searched: false };
        };
        let size = self.area.width.max(self.area.height) / 2;
        let reach = size.max(MIN_REACH_PX).saturating_add(2 * missed).min(MAX_REACH_PX);
        let start = search(picture, &self.template, self.area, known, reach as isize);
        Seen { fit: self.from(picture, start), is_searched: true }
    }

    fn take(&mut self, seen: Seen, learned: usize) {
        let frame = self.fits.len();
        let (fit, crop) = seen.fit.unzip();
        self.fits.push(fit);
        if !self.is_learned {
            self.kept.extend(crop.map(|crop| (frame, crop)));
            if frame + 1 >= learned {
                self.learn();
            }
        }
    }

    /// The picture of the mark in the frames that were kept, to which they are fitted anew.
    fn learn(&mut self) {
        if std::mem::replace(&mut self.is_learned, true) {
            return;
        }
        let kept = std::mem::take(&mut self.kept);
        let mut frames: Vec<(&Crop, Option<Fit>)> =
            kept.iter().map(|(frame, crop)| (crop, self.fits[*frame])).collect();
        self.template = learned(&self.template, &mut frames);
        for ((frame, _), (_, fit)) in kept.iter().zip(frames) {
            self.fits[*frame] = fit;
        }
        let noise: Vec<f64> = self.fits.iter().flatten().map(|fit| fit.noise).collect();
        self.noise = median(noise).unwrap_or(self.noise);
    }

    fn track(self) -> Track {
        let [x, y] = self.area.middle();
        let position = |fit: Fit| Position {
            at: [x + fit.shift[0], y + fit.shift[1]],
            deviation: fit.deviation,
        };
        let weights = self.template.weights();
        let moving = weights.iter().filter(|weight| **weight == 1.0).count();
        Track {
            moving: moving as f64 / weights.len() as f64,
            positions: self.fits.into_iter().map(|fit| fit.map(position)).collect(),
        }
    }
}

/// Variance of the noise of a crop, from second differences (Immerkær, Comput. Vis. Image
/// Underst. 64, 1996, 300–302) and their median, which edges do not move much.
fn noise_of(crop: &Crop) -> f64 {
    const MASK: [[f32; 3]; 3] = [[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]];
    /// Root of the sum of the mask's squares; deviation over median size of Gaussian noise.
    const DEVIATION: f64 = 6.0;
    const PER_MEDIAN: f64 = 1.4826;
    let mut sizes = Vec::new();
    for y in 1..crop.height.saturating_sub(1) {
        for x in 1..crop.width.saturating_sub(1) {
            let terms = (0..9).map(|k| {
                MASK[k / 3][k % 3] * crop.values[(y + k / 3 - 1) * crop.width + x + k % 3 - 1]
            });
            sizes.push(f64::from(terms.sum::<f32>().abs()));
        }
    }
    let deviation = upper_median(&sizes).unwrap_or(0.0) * PER_MEDIAN / DEVIATION;
    (deviation * deviation).max(ROUNDING)
}
