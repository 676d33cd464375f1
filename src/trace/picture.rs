//! Pictures of grey values, and parts of them.

/// A picture.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'p> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Bits of a grey value, 8 to 16.
    pub bits: u32,
    /// Row by row from the top; above 8 bits two bytes a value, the low one first.
    pub bytes: &'p [u8],
}

impl Picture<'_> {
    /// The grey value of a pixel, where white is 255; beyond the edges that of the nearest pixel.
    pub(super) fn at(&self, x: isize, y: isize) -> f32 {
        let near = |at: isize, count: usize| (at.max(0) as usize).min(count.saturating_sub(1));
        let index = near(y, self.height) * self.width + near(x, self.width);
        if self.bits <= 8 {
            return self.bytes.get(index).copied().map_or(0.0, f32::from);
        }
        let pair = self.bytes.get(2 * index..2 * index + 2);
        let value = pair.map_or(0, |pair| u16::from_le_bytes([pair[0], pair[1]]));
        f32::from(value) * (255.0 / ((1_u32 << self.bits.min(16)) - 1) as f32)
    }

    /// A part of the picture.
    pub(super) fn crop(&self, left: isize, top: isize, width: usize, height: usize) -> Crop {
        let mut values = Vec::with_capacity(width * height);
        for y in top..top + height as isize {
            values.extend((left..left + width as isize).map(|x| self.at(x, y)));
        }
        Crop { left, top, width, height, values }
    }
}

/// A rectangle of whole pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Area {
    /// Its first column.
    pub left: usize,
    /// Its first row.
    pub top: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Area {
    /// Its middle; pixel centres lie at whole numbers.
    pub fn middle(&self) -> [f64; 2] {
        let middle = |from: usize, count: usize| from as f64 + 0.5 * (count as f64 - 1.0);
        [middle(self.left, self.width), middle(self.top, self.height)]
    }
}

/// Grey values of a part of a picture.
#[derive(Debug, Clone)]
pub(super) struct Crop {
    pub(super) left: isize,
    pub(super) top: isize,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<f32>,
}

impl Crop {
    /// The rows of a box that is displaced by whole pixels, with a border about it; `None` where
    /// the crop does not reach that far.
    pub(super) fn rows(
        &self,
        area: Area,
        [x, y]: [isize; 2],
        border: usize,
    ) -> Option<impl Iterator<Item = &[f32]>> {
        let from = |at: usize, moved: isize, first: isize| {
            usize::try_from(at as isize + moved - border as isize - first).ok()
        };
        let column = from(area.left, x, self.left)?;
        let row = from(area.top, y, self.top)?;
        let (across, down) = (area.width + 2 * border, area.height + 2 * border);
        let is_within = column + across <= self.width && row + down <= self.height;
        let line = move |y: usize| &self.values[y * self.width + column..][..across];
        is_within.then(|| (row..row + down).map(line))
    }
}
