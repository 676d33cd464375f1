//! Poses that are made on the spot: grids over any joints, and random poses. A pose depends on its
//! number alone, so that pieces can be made in any order, on any thread.

use std::ops::Range;

/// One joint's share of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridAxis {
    /// Which joint, by place from base to tip.
    pub joint: usize,
    /// First position, rad or m.
    pub from: f64,
    /// Last position, rad or m.
    pub to: f64,
    /// Positions, both ends included; one stays at `from`.
    pub steps: usize,
}

impl GridAxis {
    fn position(&self, step: usize) -> f64 {
        let last = self.steps.saturating_sub(1);
        match step {
            0 => self.from,
            // Exactly, not as a rounded sum.
            step if step == last => self.to,
            step => self.from + (self.to - self.from) * (step as f64 / last as f64),
        }
    }
}

/// All combinations of the positions of some joints; the last axis runs fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Where the joints stand that no axis moves, rad or m, base to tip.
    pub at: Vec<f64>,
    /// The joints that move, slowest first; no joint twice.
    pub axes: Vec<GridAxis>,
}

impl Grid {
    /// How many poses there are; `None` where they cannot be counted.
    pub fn count(&self) -> Option<usize> {
        self.axes.iter().try_fold(1_usize, |all, axis| all.checked_mul(axis.steps))
    }

    fn append(&self, range: Range<usize>, poses: &mut Vec<f64>) {
        let mut q = self.at.clone();
        let mut steps = vec![0; self.axes.len()];
        let mut rest = range.start;
        for (axis, step) in self.axes.iter().zip(&mut steps).rev() {
            *step = rest % axis.steps.max(1);
            rest /= axis.steps.max(1);
            q[axis.joint] = axis.position(*step);
        }
        for _ in range {
            poses.extend_from_slice(&q);
            // As an odometer: only what turns over is worked out anew.
            for (axis, step) in self.axes.iter().zip(&mut steps).rev() {
                *step = if *step + 1 < axis.steps { *step + 1 } else { 0 };
                q[axis.joint] = axis.position(*step);
                if *step > 0 {
                    break;
                }
            }
        }
    }
}

/// Poses spread evenly at random.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomPoses {
    /// Between which positions each joint lies, rad or m, base to tip; a joint with equal ends
    /// stays there.
    pub ranges: Vec<[f64; 2]>,
    /// How many poses.
    pub count: usize,
    /// The same seed gives the same poses.
    pub seed: u64,
}

impl RandomPoses {
    fn append(&self, range: Range<usize>, poses: &mut Vec<f64>) {
        let start = mixed(self.seed);
        let joints = self.ranges.len() as u64;
        for pose in range {
            let first = pose as u64 * joints;
            poses.extend(self.ranges.iter().zip(first..).map(|([low, high], number)| {
                let bits = mixed(start.wrapping_add(GOLDEN.wrapping_mul(number.wrapping_add(1))));
                // The upper 53 bits, as many as a double holds: 0 ≤ share < 1.
                let share = (bits >> 11) as f64 * f64::EPSILON * 0.5;
                low + (high - low) * share
            }));
        }
    }
}

/// 2⁶⁴ over the golden ratio, odd.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// SplitMix64's finaliser (Steele, Lea & Flood, OOPSLA 2014): every bit in turns every bit out.
fn mixed(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// Poses that need not be read.
#[derive(Debug, Clone, PartialEq)]
pub enum Generator {
    /// All combinations of some joints' positions.
    Grid(Grid),
    /// Spread at random.
    Random(RandomPoses),
}

impl Generator {
    /// How many poses there are; `None` where they cannot be counted.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::Grid(grid) => grid.count(),
            Self::Random(random) => Some(random.count),
        }
    }

    /// Appends the poses with the numbers `range` (from zero), one value per joint, pose after
    /// pose.
    pub fn append(&self, range: Range<usize>, poses: &mut Vec<f64>) {
        match self {
            Self::Grid(grid) => grid.append(range, poses),
            Self::Random(random) => random.append(range, poses),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poses(generator: &Generator, range: Range<usize>) -> Vec<f64> {
        let mut poses = Vec::new();
        generator.append(range, &mut poses);
        poses
    }

    fn grid(at: &[f64], axes: &[(usize, f64, f64, usize)]) -> Generator {
        let axes = axes
            .iter()
            .map(|&(joint, from, to, steps)| GridAxis { joint, from, to, steps })
            .collect();
        Generator::Grid(Grid { at: at.to_vec(), axes })
    }

    #[test]
    fn one_axis_holds_both_ends_exactly() {
        let sweep = grid(&[0.5, 0.0], &[(1, -0.1, 0.7, 4)]);
        let all = poses(&sweep, 0..4);
        assert_eq!((all[1], all[7]), (-0.1, 0.7));
        assert!(all.chunks(2).all(|q| q[0] == 0.5));
        assert!((all[3] - (-0.1 + 0.8 / 3.0)).abs() < 1e-15);
        assert_eq!(poses(&grid(&[0.0], &[(0, 1.0, 2.0, 1)]), 0..1), [1.0]);
        assert_eq!(poses(&sweep, 2..4), all[4..]);
    }

    /// Against loops within loops; and any piece is a piece of the whole.
    #[test]
    fn the_last_axis_runs_fastest() {
        let generator =
            grid(&[9.0, 0.0, 0.0, 0.0], &[(2, 0.0, 1.0, 3), (1, 5.0, 6.0, 2), (3, -1.0, 1.0, 5)]);
        let mut expected = Vec::new();
        for a in [0.0, 0.5, 1.0] {
            for b in [5.0, 6.0] {
                for c in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                    expected.extend([9.0, b, a, c]);
                }
            }
        }
        assert_eq!(generator.count(), Some(30));
        assert_eq!(poses(&generator, 0..30), expected);
        for (from, to) in [(0, 7), (7, 8), (8, 29), (13, 30)] {
            assert_eq!(poses(&generator, from..to), expected[4 * from..4 * to]);
        }
        assert_eq!(grid(&[0.0; 2], &[(0, 0.0, 1.0, usize::MAX), (1, 0.0, 1.0, 2)]).count(), None);
    }

    #[test]
    fn random_poses_fill_their_ranges_evenly() {
        let random = RandomPoses {
            ranges: vec![[-1.0, 3.0], [0.25, 0.25], [0.0, 1e-3]],
            count: 40_000,
            seed: 7,
        };
        let all = poses(&Generator::Random(random.clone()), 0..40_000);
        for (joint, [low, high]) in random.ranges.iter().enumerate() {
            let values: Vec<f64> = all.iter().skip(joint).step_by(3).copied().collect();
            assert!(values.iter().all(|v| low <= v && v <= high));
            if low == high {
                continue;
            }
            // χ² of 20 equal cells, 19 degrees of freedom: above 43.8 once in a thousand.
            let mut cells = [0.0; 20];
            for v in &values {
                cells[((v - low) / (high - low) * 20.0) as usize] += 1.0;
            }
            let chi2: f64 = cells.iter().map(|n| (n - 2000.0_f64).powi(2) / 2000.0).sum();
            assert!(chi2 < 43.8, "{chi2}");
        }
        // Joints know nothing of each other.
        let product: f64 = all.chunks(3).map(|q| (q[0] - 1.0) * (q[2] - 5e-4)).sum();
        assert!((product / (40_000.0 * 4.0 / 12.0 * 1e-3)).abs() < 0.02, "{product}");
        assert_eq!(poses(&Generator::Random(random.clone()), 100..120), all[300..360]);
        let other = Generator::Random(RandomPoses { seed: 8, ..random });
        assert_ne!(poses(&other, 0..1)[0], all[0]);
    }
}
