//! An explicit Runge–Kutta method of order 8 with step control: Dormand and Prince's 8(5,3), as
//! given by Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed., §II.5 and
//! II.10. Steps are cut so that they end on the sampling instants; a record of vibration is sampled
//! about as densely as the method has to step anyway, so no dense output is needed.

const STAGES: usize = 12;

/// Weights of the stages before each stage: (stage, weight). Row 12 is the step itself.
const A: [&[(usize, f64)]; STAGES + 1] = [
    &[],
    &[(0, 0.05260015195876773)],
    &[(0, 0.0197250569845379), (1, 0.0591751709536137)],
    &[(0, 0.02958758547680685), (2, 0.08876275643042054)],
    &[(0, 0.2413651341592667), (2, -0.8845494793282861), (3, 0.924834003261792)],
    &[(0, 0.037037037037037035), (3, 0.17082860872947386), (4, 0.12546768756682242)],
    &[(0, 0.037109375), (3, 0.17025221101954405), (4, 0.06021653898045596), (5, -0.017578125)],
    &[
        (0, 0.03709200011850479),
        (3, 0.17038392571223998),
        (4, 0.10726203044637328),
        (5, -0.015319437748624402),
        (6, 0.008273789163814023),
    ],
    &[
        (0, 0.6241109587160757),
        (3, -3.3608926294469414),
        (4, -0.868219346841726),
        (5, 27.59209969944671),
        (6, 20.154067550477894),
        (7, -43.48988418106996),
    ],
    &[
        (0, 0.47766253643826434),
        (3, -2.4881146199716677),
        (4, -0.590290826836843),
        (5, 21.230051448181193),
        (6, 15.279233632882423),
        (7, -33.28821096898486),
        (8, -0.020331201708508627),
    ],
    &[
        (0, -0.9371424300859873),
        (3, 5.186372428844064),
        (4, 1.0914373489967295),
        (5, -8.149787010746927),
        (6, -18.52006565999696),
        (7, 22.739487099350505),
        (8, 2.4936055526796523),
        (9, -3.0467644718982196),
    ],
    &[
        (0, 2.273310147516538),
        (3, -10.53449546673725),
        (4, -2.0008720582248625),
        (5, -17.9589318631188),
        (6, 27.94888452941996),
        (7, -2.8589982771350235),
        (8, -8.87285693353063),
        (9, 12.360567175794303),
        (10, 0.6433927460157636),
    ],
    &[
        (0, 0.054293734116568765),
        (5, 4.450312892752409),
        (6, 1.8915178993145003),
        (7, -5.801203960010585),
        (8, 0.3111643669578199),
        (9, -0.1521609496625161),
        (10, 0.20136540080403034),
        (11, 0.04471061572777259),
    ],
];

/// Weights of the error estimates of third and fifth order.
const ERROR_3: &[(usize, f64)] = &[
    (0, -0.18980075407240762),
    (5, 4.450312892752409),
    (6, 1.8915178993145003),
    (7, -5.801203960010585),
    (8, -0.4226823213237919),
    (9, -0.1521609496625161),
    (10, 0.20136540080403034),
    (11, 0.02265179219836082),
];
const ERROR_5: &[(usize, f64)] = &[
    (0, 0.01312004499419488),
    (5, -1.2251564463762044),
    (6, -0.4957589496572502),
    (7, 1.6643771824549864),
    (8, -0.35032884874997366),
    (9, 0.3341791187130175),
    (10, 0.08192320648511571),
    (11, -0.022355307863886294),
];

/// Step control: safety and the most that a step may shrink or grow at once (Hairer et al., §II.4).
const SAFETY: f64 = 0.9;
const MIN_FACTOR: f64 = 0.3;
const MAX_FACTOR: f64 = 4.0;

/// A step below this share of the interval asked for is given up.
const MIN_STEP: f64 = 1e-10;

/// Why an integration stopped.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Stop<E> {
    /// The derivative could not be had.
    Derivative(E),
    /// No step is small enough for the tolerance: the motion runs away.
    StepTooSmall,
}

/// Integrates y' = f(y) from sample to sample, in buffers of its own.
#[derive(Debug, Clone)]
pub(super) struct Integrator {
    /// Error that a step may make in each entry of y.
    tolerance: Vec<f64>,
    stages: Vec<Vec<f64>>,
    trial: Vec<f64>,
    /// Step that the tolerance is thought to allow.
    step: f64,
    /// Whether stage 0 holds f at the present y.
    is_primed: bool,
    /// Steps taken, those that were refused included.
    pub(super) steps: usize,
}

impl Integrator {
    /// For `tolerance.len()` equations, starting with a step of `first_step`.
    pub(super) fn new(tolerance: Vec<f64>, first_step: f64) -> Self {
        let n = tolerance.len();
        Self {
            tolerance,
            stages: vec![vec![0.0; n]; STAGES],
            trial: vec![0.0; n],
            step: first_step,
            is_primed: false,
            steps: 0,
        }
    }

    /// Moves `y` on by `interval`.
    pub(super) fn advance<E>(
        &mut self,
        y: &mut [f64],
        interval: f64,
        mut derivative: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<(), Stop<E>> {
        if !self.is_primed {
            derivative(y, &mut self.stages[0]).map_err(Stop::Derivative)?;
            self.is_primed = true;
        }
        let mut left = interval;
        while left > 0.0 {
            let parts = (left / self.step).ceil().max(1.0);
            let step = left / parts;
            let error = self.try_step(y, step, &mut derivative).map_err(Stop::Derivative)?;
            self.steps += 1;
            let factor = if error.is_finite() {
                (SAFETY * error.powf(-0.125)).clamp(MIN_FACTOR, MAX_FACTOR)
            } else {
                MIN_FACTOR
            };
            if error <= 1.0 {
                y.copy_from_slice(&self.trial);
                derivative(y, &mut self.stages[0]).map_err(Stop::Derivative)?;
                left = if parts <= 1.0 { 0.0 } else { left - step };
                // A step cut short by the sampling instant shows only that it could be longer.
                let allowed = step * factor;
                self.step = if factor < 1.0 { allowed } else { self.step.max(allowed) };
            } else {
                self.step = step * factor.min(1.0);
                if self.step < MIN_STEP * interval {
                    return Err(Stop::StepTooSmall);
                }
            }
        }
        Ok(())
    }

    /// Puts y after one step into `trial`; the error against the tolerance, at most 1 if it will
    /// do.
    fn try_step<E>(
        &mut self,
        y: &[f64],
        step: f64,
        derivative: &mut impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<f64, E> {
        for (stage, weights) in A.iter().enumerate().skip(1) {
            for (i, (trial, &start)) in self.trial.iter_mut().zip(y).enumerate() {
                *trial = start + step * weighted(weights, &self.stages, i);
            }
            if stage < STAGES {
                derivative(&self.trial, &mut self.stages[stage])?;
            }
        }
        let (mut third, mut fifth) = (0.0, 0.0);
        for (i, tolerance) in self.tolerance.iter().enumerate() {
            third += (step * weighted(ERROR_3, &self.stages, i) / tolerance).powi(2);
            fifth += (step * weighted(ERROR_5, &self.stages, i) / tolerance).powi(2);
        }
        let both = fifth + 0.01 * third;
        if both == 0.0 {
            return Ok(0.0);
        }
        Ok(fifth / (both * self.tolerance.len() as f64).sqrt())
    }
}

fn weighted(weights: &[(usize, f64)], stages: &[Vec<f64>], i: usize) -> f64 {
    weights.iter().map(|&(stage, weight)| weight * stages[stage][i]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// y' = −y, with the tolerance so wide that every step is the one asked for.
    fn decay_error(steps: usize) -> f64 {
        let mut integrator = Integrator::new(vec![1e3], f64::INFINITY);
        let mut y = [1.0];
        for _ in 0..steps {
            integrator.is_primed = false;
            let derivative = |y: &[f64], d: &mut [f64]| {
                d[0] = -y[0];
                Ok::<(), Infallible>(())
            };
            integrator.step = f64::INFINITY;
            integrator.advance(&mut y, 2.0 / steps as f64, derivative).unwrap();
        }
        (y[0] - (-2.0_f64).exp()).abs()
    }

    #[test]
    fn order_is_eight() {
        let order = (decay_error(2) / decay_error(4)).log2();
        assert!((7.7..9.0).contains(&order), "order {order}");
    }

    /// Order conditions of quadrature, Σ b c^k = 1/(k+1) for k < 8, and the weights of both error
    /// estimates add up to zero.
    #[test]
    fn weights_satisfy_the_order_conditions() {
        let node = |stage: usize| A[stage].iter().map(|(_, w)| w).sum::<f64>();
        for k in 0..8 {
            let sum: f64 = A[STAGES].iter().map(|&(s, w)| w * node(s).powi(k)).sum();
            assert!((sum - 1.0 / f64::from(k + 1)).abs() < 1e-14, "k = {k}: {sum}");
        }
        for weights in [ERROR_3, ERROR_5] {
            let sum: f64 = weights.iter().map(|(_, w)| w).sum();
            assert!(sum.abs() < 1e-14);
        }
    }

    /// Pendulum y'' = −sin y from 2 rad: its period is 4 K(sin 1); K by the arithmetic-geometric
    /// mean.
    #[test]
    fn keeps_the_tolerance_on_a_pendulum() {
        let (mut a, mut g) = (1.0_f64, 1.0_f64.cos());
        for _ in 0..8 {
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
        }
        let period = 2.0 * std::f64::consts::PI / a;
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let mut integrator = Integrator::new(vec![tolerance; 2], 0.1);
            let mut y = [2.0, 0.0];
            for _ in 0..40 {
                let derivative = |y: &[f64], d: &mut [f64]| {
                    d[0] = y[1];
                    d[1] = -y[0].sin();
                    Ok::<(), Infallible>(())
                };
                integrator.advance(&mut y, period / 4.0, derivative).unwrap();
            }
            let error = (y[0] - 2.0).abs().max(y[1].abs());
            assert!(error < 300.0 * tolerance, "{error:e} at tolerance {tolerance:e}");
        }
    }

    #[test]
    fn gives_up_on_a_motion_that_runs_away() {
        let mut integrator = Integrator::new(vec![1e-9], 0.01);
        let derivative = |y: &[f64], d: &mut [f64]| {
            d[0] = y[0] * y[0];
            Ok::<(), Infallible>(())
        };
        let stop = integrator.advance(&mut [1.0], 2.0, derivative);
        assert_eq!(stop, Err(Stop::StepTooSmall));
    }
}
