//! How noisy the lines of responses are that an analyser made without a window: to a level that
//! changes slowly from line to line comes a share of each line, of sensors and of noise on the
//! force. How good these were nobody says: the share is that of the largest likelihood of what a
//! fit leaves, whose values are normal with these variances.

use super::noise;

/// What a fit leaves of a response.
pub(super) struct Left {
    /// Power of the residual by line.
    pub(super) powers: Vec<f64>,
    /// Of each line's noise, the share that the fit has absorbed.
    pub(super) taken: Vec<f64>,
    /// Power of the fitted response by line.
    pub(super) fitted: Vec<f64>,
    /// Power of the loudest line.
    pub(super) strongest: f64,
}

/// Variances by response and line.
pub(super) fn variances(left: &[Left]) -> Vec<Vec<f64>> {
    /// Least and largest share of a line, as deviations: beyond it a fit is wrong rather than its
    /// data noisy.
    const LEAST: f64 = 1e-5;
    const MOST: f64 = 0.05;
    let levels: Vec<Vec<f64>> =
        left.iter().map(|own| noise::floor(&own.powers, own.strongest)).collect();
    let with = |share: f64| -> Vec<Vec<f64>> {
        left.iter().zip(&levels).map(|(own, level)| own.variances(share, level)).collect()
    };
    let ln_likelihood = |variances: &[Vec<f64>]| -> f64 {
        left.iter().zip(variances).map(|(own, variances)| own.ln_likelihood(variances)).sum()
    };
    let (mut share, mut best) = (MOST, with(MOST));
    let mut most = ln_likelihood(&best);
    let mut factor: f64 = 8.0;
    while factor > 1.1 {
        let before = most;
        for near in [share / factor, share * factor] {
            let near = near.clamp(LEAST, MOST);
            let variances = with(near);
            let own = ln_likelihood(&variances);
            if own > most {
                (share, best, most) = (near, variances, own);
            }
        }
        if most <= before {
            factor = factor.sqrt();
        }
    }
    best
}

impl Left {
    /// With this share of each line; lines on which it is small tell the level.
    fn variances(&self, share: f64, level: &[f64]) -> Vec<f64> {
        const STEPS: usize = 4;
        let of_line: Vec<f64> = self.fitted.iter().map(|power| share.powi(2) * power).collect();
        let mut level = level.to_vec();
        for _ in 0..STEPS {
            level = noise::beside(&self.powers, &self.taken, &of_line, &level, self.strongest);
        }
        level.iter().zip(&of_line).map(|(level, of_line)| level + of_line).collect()
    }

    /// Of circular normal values with these variances, but for a constant.
    fn ln_likelihood(&self, variances: &[f64]) -> f64 {
        let lines = self.powers.iter().zip(&self.taken).zip(variances);
        lines.map(|((power, taken), own)| -(1.0 - taken) * own.ln() - power / own).sum()
    }
}
