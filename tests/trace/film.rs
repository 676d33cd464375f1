//! Films of discs whose places are known: each pixel is the mean of the picture over its area, each
//! row is taken at its own time. No pixel comes from another pixel.

use nalgebra::{Matrix4, Vector4};
use rand_chacha::ChaCha8Rng;

use crate::vibration::gauss;

/// A disc.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Disc {
    pub(crate) at: [f64; 2],
    pub(crate) radius: f64,
    pub(crate) contrast: f64,
    pub(crate) edge: Edge,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Edge {
    /// 1/(1 + e^((r − radius)/0.7 px)) of the contrast at the distance r, as in the published
    /// figures on tracking that the tests compare with.
    Soft,
    /// The contrast inside and nothing outside.
    Hard,
}

const SOFT_PX: f64 = 0.7;

impl Disc {
    /// Its mean over the pixel about (x, y).
    fn over(&self, x: f64, y: f64) -> f64 {
        let distance = (x - self.at[0]).hypot(y - self.at[1]) - self.radius;
        if distance.abs() > 12.0 {
            return if distance > 0.0 { 0.0 } else { self.contrast };
        }
        self.contrast
            * match self.edge {
                Edge::Soft => self.soft(x, y),
                Edge::Hard if distance.abs() > 1.0 => f64::from(u8::from(distance < 0.0)),
                Edge::Hard => self.hard(x, y),
            }
    }

    /// 5 × 5 points of the midpoint rule.
    fn soft(&self, x: f64, y: f64) -> f64 {
        const POINTS: i32 = 5;
        let share = |x: f64, y: f64| {
            let distance = (x - self.at[0]).hypot(y - self.at[1]);
            1.0 / (1.0 + ((distance - self.radius) / SOFT_PX).exp())
        };
        let place = |k: i32| (f64::from(k) + 0.5) / f64::from(POINTS) - 0.5;
        let cells =
            (0..POINTS * POINTS).map(|k| share(x + place(k % POINTS), y + place(k / POINTS)));
        cells.sum::<f64>() / f64::from(POINTS * POINTS)
    }

    /// The covered area: the lengths of the chords, by the midpoint rule over 64 of them.
    fn hard(&self, x: f64, y: f64) -> f64 {
        const CHORDS: i32 = 64;
        let chord = |k: i32| {
            let off = y + (f64::from(k) + 0.5) / f64::from(CHORDS) - 0.5 - self.at[1];
            let half = (self.radius * self.radius - off * off).max(0.0).sqrt();
            let (low, high) = (x - 0.5, x + 0.5);
            (self.at[0] + half).min(high) - (self.at[0] - half).max(low)
        };
        (0..CHORDS).map(|k| chord(k).max(0.0)).sum::<f64>() / f64::from(CHORDS)
    }
}

/// How a film is taken.
pub(crate) struct Camera {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Standard deviation of a pixel, grey values.
    pub(crate) noise: f64,
    /// From the first to the last row, s.
    pub(crate) readout_s: f64,
}

impl Camera {
    /// Noise, and rounding to whole grey values.
    pub(crate) fn variance(&self) -> f64 {
        self.noise * self.noise + 1.0 / 12.0
    }

    /// The frame that begins at a time: discs before a still background.
    pub(crate) fn frame(
        &self,
        time: f64,
        still: &dyn Fn(f64, f64) -> f64,
        discs: &dyn Fn(f64) -> Vec<Disc>,
        rng: &mut ChaCha8Rng,
    ) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.width * self.height);
        for row in 0..self.height {
            let y = row as f64;
            let discs = discs(time + self.readout_s * y / self.height as f64);
            for column in 0..self.width {
                let x = column as f64;
                let mut value = still(x, y);
                for disc in &discs {
                    let share = disc.over(x, y) / disc.contrast;
                    // What is behind the disc does not show through it.
                    value += share * (disc.contrast + still(disc.at[0], 1e9) - value);
                }
                value += self.noise * gauss(rng);
                bytes.push(value.round().clamp(0.0, 255.0) as u8);
            }
        }
        bytes
    }

    /// The Cramér–Rao bound of the place of a disc along x, with gain and offset unknown: from
    /// differences of its picture.
    pub(crate) fn bound(&self, disc: Disc) -> f64 {
        const STEP: f64 = 5e-3;
        let reach = disc.radius.ceil() as i32 + 6;
        let [x, y] = disc.at.map(f64::round);
        let moved = |dx: f64, dy: f64| Disc { at: [disc.at[0] + dx, disc.at[1] + dy], ..disc };
        let mut information = Matrix4::<f64>::zeros();
        for k in 0..(2 * reach + 1).pow(2) {
            let x = x + f64::from(k % (2 * reach + 1) - reach);
            let y = y + f64::from(k / (2 * reach + 1) - reach);
            let slope = |dx: f64, dy: f64| {
                (moved(dx, dy).over(x, y) - moved(-dx, -dy).over(x, y)) / (2.0 * STEP)
            };
            let row = Vector4::new(disc.over(x, y), 1.0, slope(STEP, 0.0), slope(0.0, STEP));
            information += row * row.transpose() / self.variance();
        }
        information.try_inverse().unwrap()[(2, 2)].sqrt()
    }
}

/// A film as YUV4MPEG.
pub(crate) fn y4m(camera: &Camera, rate: u32, frames: &[Vec<u8>]) -> Vec<u8> {
    let (width, height) = (camera.width, camera.height);
    let mut bytes = format!("YUV4MPEG2 W{width} H{height} F{rate}:1 Ip A1:1 Cmono\n").into_bytes();
    for frame in frames {
        bytes.extend(b"FRAME\n");
        bytes.extend(frame);
    }
    bytes
}
