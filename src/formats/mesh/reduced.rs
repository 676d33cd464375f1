//! Surfaces with few triangles, in 16 bit: vertices that fall into one cell of a grid become one
//! (Rossignac & Borrel, Multi-resolution 3D approximations for rendering complex scenes, 1993).

use std::collections::{HashMap, HashSet};

use super::Triangles;

/// Cells along the longest side, from all that 16 bit tell apart to none.
const GRIDS: [u32; 21] =
    [65535, 1024, 724, 512, 362, 256, 181, 128, 90, 64, 45, 32, 22, 16, 11, 8, 6, 4, 3, 2, 1];

const LARGEST: f64 = 65535.0;

/// A surface: each number of a point is a share, of 65535, of the box about it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reduced {
    /// The corner of the box with the smallest coordinates.
    pub(crate) low: [f64; 3],
    /// Its sides.
    pub(crate) size: [f64; 3],
    pub(crate) points: Vec<[u16; 3]>,
    pub(crate) triangles: Vec<[u16; 3]>,
}

impl Reduced {
    /// `None` where no triangle is left; with up to `most` triangles where a grid leaves so few,
    /// and never with more points than 16 bit can name.
    pub(super) fn of(surface: &Triangles, most: usize) -> Option<Self> {
        let fold = |pick: fn(f64, f64) -> f64| {
            let mut corners = surface.corners.iter().copied();
            let first = corners.next()?;
            Some(corners.fold(first, |a, b| [0, 1, 2].map(|k| pick(a[k], b[k]))))
        };
        let (low, high) = (fold(f64::min)?, fold(f64::max)?);
        let size = [0, 1, 2].map(|k| high[k] - low[k]);
        let longest = size.into_iter().fold(0.0, f64::max);
        if longest <= 0.0 {
            return None;
        }
        let fits = |of: &Clustered| of.triangles.len() <= most && of.sums.len() <= 65536;
        let at = |grid: u32| clustered(surface, low, longest / f64::from(grid));
        let finest = at(GRIDS[0]);
        let clustered = if fits(&finest) {
            finest
        } else {
            // The count falls as cells grow, or nearly so.
            let coarse = GRIDS[1..].partition_point(|grid| !fits(&at(*grid)));
            at(*GRIDS[1..].get(coarse)?)
        };
        if clustered.triangles.is_empty() {
            return None;
        }
        let share = |value: f64, k: usize| {
            let share = if size[k] > 0.0 { (value - low[k]) / size[k] } else { 0.0 };
            (LARGEST * share.clamp(0.0, 1.0)).round() as u16
        };
        let point = |(sum, count): &([f64; 3], f64)| [0, 1, 2].map(|k| share(sum[k] / count, k));
        let narrow = |triangle: &[u32; 3]| {
            let narrow = triangle.map(u16::try_from);
            let [Ok(a), Ok(b), Ok(c)] = narrow else { return None };
            Some([a, b, c])
        };
        Some(Self {
            low,
            size,
            points: clustered.sums.iter().map(point).collect(),
            triangles: clustered.triangles.iter().map(narrow).collect::<Option<Vec<_>>>()?,
        })
    }
}

struct Clustered {
    /// Per cell, the sum of the corners in it, and how many they are.
    sums: Vec<([f64; 3], f64)>,
    triangles: Vec<[u32; 3]>,
}

fn clustered(surface: &Triangles, low: [f64; 3], cell: f64) -> Clustered {
    let mut of_cell: HashMap<[u32; 3], u32> = HashMap::new();
    let mut sums: Vec<([f64; 3], f64)> = Vec::new();
    let mut place = |corner: &[f64; 3]| {
        let key = [0, 1, 2].map(|k| ((corner[k] - low[k]) / cell).round() as u32);
        let index = *of_cell.entry(key).or_insert_with(|| {
            sums.push(([0.0; 3], 0.0));
            (sums.len() - 1) as u32
        });
        let (sum, count) = &mut sums[index as usize];
        (0..3).for_each(|k| sum[k] += corner[k]);
        *count += 1.0;
        index
    };
    let mut seen = HashSet::new();
    let mut triangles = Vec::new();
    for corners in surface.corners.chunks_exact(3) {
        let own = [0, 1, 2].map(|k| place(&corners[k]));
        let mut sorted = own;
        sorted.sort_unstable();
        // What shrinks to a line or lies on another is not seen.
        if sorted[0] < sorted[1] && sorted[1] < sorted[2] && seen.insert(sorted) {
            triangles.push(own);
        }
    }
    Clustered { sums, triangles }
}
