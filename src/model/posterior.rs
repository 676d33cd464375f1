//! What a calibration learned of the numbers of a model: they are scaled by the means before the
//! robot is built, and what they may still be off by is kept beside them.

/// What a calibration learned.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Posterior {
    /// The parameters.
    pub parameters: Vec<LearnedParameter>,
    /// Correlation of each parameter with those before it: row i has i values.
    pub correlation: Vec<Vec<f64>>,
    /// What they leave unexplained.
    pub unexplained: Unexplained,
    /// The model that was calibrated; older files have none.
    pub fingerprint: Option<Fingerprint>,
}

/// A model at a pose: a figure a coordinate for masses and lengths, and one for springs.
#[derive(Debug, Clone, PartialEq)]
pub struct Fingerprint {
    /// Diagonal of M, kg·m² or kg.
    pub mass_diagonal: Vec<f64>,
    /// Diagonal of K, N·m/rad or N/m.
    pub stiffness_diagonal: Vec<f64>,
}

impl Posterior {
    /// Forgets the parameters for which `keep` does not hold; what is known of the others stays.
    pub(super) fn retain(&mut self, keep: impl Fn(&LearnedParameter) -> bool) {
        let kept: Vec<usize> =
            (0..self.parameters.len()).filter(|&i| keep(&self.parameters[i])).collect();
        let row =
            |(n, &i): (usize, &usize)| kept[..n].iter().map(|&j| self.correlation[i][j]).collect();
        self.correlation = kept.iter().enumerate().map(row).collect();
        self.parameters.retain(keep);
    }
}

/// A number of the model against its value in the file, with corrections.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedParameter {
    /// What it is.
    pub kind: ParameterKind,
    /// The joint or extra coordinate, or the link.
    pub at: String,
    /// Mean of ln(true value / value in the file).
    pub ln: f64,
    /// Standard deviation of the same.
    pub std: f64,
}

/// What a parameter scales.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterKind {
    /// The spring of an elastic coordinate.
    Spring,
    /// Mass and inertia of a link.
    Link,
    /// The drive of a joint.
    Drive,
    /// A compliance of the foundation about any axis that the model lacks, against the softest
    /// joint's: not a factor of anything, so `ln` is the compliance itself, zero.
    Foundation,
    /// A compliance across the axis of a joint that the model lacks, against the joint's own,
    /// likewise.
    Bending,
}

impl ParameterKind {
    /// Every kind.
    pub const ALL: [Self; 5] =
        [Self::Spring, Self::Link, Self::Drive, Self::Foundation, Self::Bending];

    /// Whether it is a compliance that the model lacks.
    pub fn is_lacking(self) -> bool {
        matches!(self, Self::Foundation | Self::Bending)
    }

    /// As robot.yaml spells it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Spring => "spring",
            Self::Link => "link",
            Self::Drive => "drive",
            Self::Foundation => "foundation",
            Self::Bending => "bending",
        }
    }
}

/// Standard deviation of ln f_r beyond what the parameters account for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Unexplained {
    /// Per mode, at poses like the measured ones, each left out in turn.
    pub near: Vec<f64>,
    /// Per mode, at poses farther from the measured ones than these are from each other.
    pub far: Vec<f64>,
    /// The measured poses, rad or m.
    pub poses: Vec<Vec<f64>>,
    /// Distance within which poses inform about each other, rad or m.
    pub reach: f64,
}

impl Unexplained {
    /// d_r at a pose, for every mode.
    pub fn at(&self, q: &[f64]) -> Vec<f64> {
        let apart = self.poses.iter().map(|pose| distance(pose, q)).fold(f64::INFINITY, f64::min);
        // The correlation of a squared-exponential process, gone at some three times the reach.
        let known = (-0.5 * (apart / self.reach).powi(2)).exp();
        let square = |(near, far): (&f64, &f64)| {
            (known * near * near + (1.0 - known) * far * far).sqrt().max(*near)
        };
        self.near.iter().zip(&self.far).map(square).collect()
    }

    /// By joint, rad or m: where the calibration speaks, which is where the joint was measured, and
    /// a little more; anywhere of one that stood still.
    pub fn ranges(&self) -> Vec<[f64; 2]> {
        /// Of a joint's measured range, on either side: poses beside those of a table.
        const MARGIN: f64 = 0.15;
        /// A joint that moved less stood still, rad or m.
        const STILL: f64 = 0.01;
        let joints = self.poses.first().map_or(0, Vec::len);
        let range = |joint: usize| {
            let measured = self.poses.iter().filter_map(|pose| pose.get(joint).copied());
            let none = [f64::INFINITY, f64::NEG_INFINITY];
            let [low, high] = measured.fold(none, |[a, b], at| [a.min(at), b.max(at)]);
            let more = MARGIN * (high - low);
            let is_varied = high - low > STILL;
            if is_varied { [low - more, high + more] } else { [f64::NEG_INFINITY, f64::INFINITY] }
        };
        (0..joints).map(range).collect()
    }
}

/// How much of a calibration says nothing of a pose, 0 to 1, as joints stand beyond its `ranges`:
/// laws of load and angle show only where they were tried.
pub fn beyond(ranges: &[[f64; 2]], q: &[f64]) -> f64 {
    /// rad or m.
    const REACH: f64 = 0.2;
    let off = ranges.iter().zip(q).map(|([low, high], at)| (low - at).max(at - high));
    let most = off.fold(0.0, f64::max);
    1.0 - (-0.5 * (most / REACH).powi(2)).exp()
}

/// Largest difference of any joint, rad or m.
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: a joint that was varied by 1 rad counts from 0.15 rad beyond, 1 − e^(−½) at 0.2 rad
    /// more; one that stood still does not count.
    #[test]
    fn what_lies_beyond_the_measured_range_is_counted() {
        let poses = vec![vec![0.0, 5.0], vec![0.4, 5.001], vec![1.0, 5.0]];
        let ranges = Unexplained { poses, ..Unexplained::default() }.ranges();
        for (q, expected) in [
            ([0.5, 5.0], 0.0),
            ([0.5, 9.0], 0.0),
            ([-0.15, 5.0], 0.0),
            ([1.35, 5.0], 0.393_469_340),
            ([-0.35, 5.0], 0.393_469_340),
            ([4.0, 5.0], 1.0),
        ] {
            assert!((beyond(&ranges, &q) - expected).abs() < 1e-9, "{q:?} {}", beyond(&ranges, &q));
        }
    }
}
