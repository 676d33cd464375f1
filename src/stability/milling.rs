//! Forces that repeat with a period and depend on where the tip is and was.

use std::f64::consts::TAU;

use nalgebra::Matrix3x2;

use super::cut::Cut;
use crate::units::hz_from_rpm;

/// What a force takes from the tip's motion: `now` · u(t) − `before` · u(t − delay) + `rate` ·
/// u̇(t).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// N/m.
    pub now: Matrix3x2<f64>,
    /// N/m.
    pub before: Matrix3x2<f64>,
    /// N s/m; `None` where nothing damps.
    pub rate: Option<Matrix3x2<f64>>,
}

/// A force on the tip that is linear in its motion, in as many terms as there are delays.
pub trait Process {
    /// After which it repeats, s.
    fn period_s(&self) -> f64;
    /// The delays of its terms, above zero and at most a period, s.
    fn delays_s(&self) -> Vec<f64>;
    /// Times within a period at which its coefficients have corners, at a depth.
    fn corners_s(&self, depth_m: f64) -> Vec<f64>;
    /// The fastest change of its coefficients, rad/s.
    fn fastest_rad_per_s(&self) -> f64;
    /// The term of a delay at a time within the period; `None` where there is no force.
    fn term(&self, delay: usize, time_s: f64, depth_m: f64) -> Option<Term>;
}

/// A cut at a spindle speed. Even teeth repeat with the tooth period and have one delay; uneven
/// ones repeat with the turn and have one each.
#[derive(Debug, Clone)]
pub struct Milling<'a> {
    cut: &'a Cut,
    turning_rad_per_s: f64,
    even_pitch_rad: Option<f64>,
    angles_rad: Vec<f64>,
}

impl<'a> Milling<'a> {
    /// At `rpm`, above zero.
    pub fn new(cut: &'a Cut, rpm: f64) -> Self {
        Self {
            cut,
            turning_rad_per_s: TAU * hz_from_rpm(rpm),
            even_pitch_rad: cut.even_pitch_rad(),
            angles_rad: cut.angles_rad().collect(),
        }
    }

    /// Teeth in a period.
    pub fn teeth_per_period(&self) -> usize {
        if self.even_pitch_rad.is_some() { 1 } else { self.angles_rad.len() }
    }
}

impl Process for Milling<'_> {
    fn period_s(&self) -> f64 {
        self.even_pitch_rad.unwrap_or(TAU) / self.turning_rad_per_s
    }

    fn delays_s(&self) -> Vec<f64> {
        match self.even_pitch_rad {
            Some(pitch) => vec![pitch / self.turning_rad_per_s],
            None => self.cut.pitch_rad.iter().map(|p| p / self.turning_rad_per_s).collect(),
        }
    }

    fn corners_s(&self, depth_m: f64) -> Vec<f64> {
        let of_tooth = self.cut.corners_rad(depth_m);
        let period_rad = self.even_pitch_rad.unwrap_or(TAU);
        // All even teeth come by at the same times.
        let teeth = &self.angles_rad[..self.teeth_per_period()];
        let time = |angle: f64| angle.rem_euclid(period_rad) / self.turning_rad_per_s;
        teeth
            .iter()
            .flat_map(|theta| of_tooth.iter().map(move |corner| corner - theta))
            .map(time)
            .collect()
    }

    fn fastest_rad_per_s(&self) -> f64 {
        2.0 * self.turning_rad_per_s
    }

    fn term(&self, delay: usize, time_s: f64, depth_m: f64) -> Option<Term> {
        let turned = self.turning_rad_per_s * time_s;
        let teeth = match self.even_pitch_rad {
            Some(_) => &self.angles_rad[..],
            None => self.angles_rad.get(delay..=delay)?,
        };
        let of = |theta: &f64| self.cut.stiffness_n_per_m(turned + theta, depth_m);
        let force = teeth.iter().filter_map(of).reduce(|a, b| a + b)?;
        let rubs = |theta: &f64| self.cut.rubbing_n_per_m(turned + theta, depth_m);
        let rate = match self.cut.is_damped() {
            true => teeth.iter().filter_map(rubs).reduce(|a, b| a + b),
            false => None,
        };
        let rate = rate.map(|rate| rate / self.turning_rad_per_s);
        Some(Term { now: force, before: force, rate })
    }
}
