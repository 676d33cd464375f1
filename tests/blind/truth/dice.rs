//! Random numbers from a seed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A portable stream of random numbers.
pub(crate) struct Dice(ChaCha8Rng);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Evenly in from..to.
    pub(crate) fn even(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.0.random::<f64>()
    }

    /// Evenly in the logarithm.
    pub(crate) fn log_even(&mut self, from: f64, to: f64) -> f64 {
        self.even(from.ln(), to.ln()).exp()
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.even(0.0, 1.0) < share
    }

    /// +1 or −1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// 0 to `count` − 1.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// Both ends included.
    pub(crate) fn between(&mut self, from: usize, to: usize) -> usize {
        self.0.random_range(from..=to)
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.index(from.len())]
    }

    /// Standard normal, by Box and Muller.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.even(1e-300, 1.0).ln()).sqrt();
        radius * self.even(0.0, std::f64::consts::TAU).cos()
    }

    /// Student's t with `freedom` > 2 degrees of freedom, scaled to unit variance.
    pub(crate) fn student(&mut self, freedom: u32) -> f64 {
        let squares: f64 = (0..freedom).map(|_| self.normal().powi(2)).sum();
        let nu = f64::from(freedom);
        self.normal() / (squares / nu).sqrt() * ((nu - 2.0) / nu).sqrt()
    }
}
