//! Hammer tests in the time domain: the arm struck at its tool, damped, its springs slightly cubic, seen through
//! noise, written as records and session.yaml.
//!
//! M α̈ + C α̇ + K α + κ α³ = Jᵀ f(t), with C = a M + b K, integrated by the classical Runge–Kutta scheme of
//! fourth order.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use nalgebra::{DMatrix, DVector};

use super::dice::Dice;
use super::eigen::lowest_hz;
use super::world::{Row, World};

/// How the arm is struck and watched.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HammerTest {
    pub(crate) sample_rate_hz: f64,
    pub(crate) blows: usize,
    pub(crate) seconds_per_blow: f64,
    pub(crate) contact_s: f64,
    pub(crate) damping_ratio: f64,
    /// Share by which a spring stiffens at a deflection of `deflection_rad`.
    pub(crate) cubic: f64,
    /// How far the hardest blow deflects the joint that gives most: whoever strikes goes by what the arm does.
    pub(crate) deflection_rad: f64,
    /// Noise of the displacement over its largest value, of the force over its peak.
    pub(crate) noise: f64,
    /// Steps of the integration for each that is needed.
    pub(crate) finer: usize,
}

impl Default for HammerTest {
    fn default() -> Self {
        Self {
            sample_rate_hz: 1000.0,
            blows: 3,
            seconds_per_blow: 5.0,
            contact_s: 0.006,
            damping_ratio: 0.015,
            cubic: 0.02,
            deflection_rad: 1e-3,
            noise: 0.002,
            finer: 1,
        }
    }
}

/// A record of one pose.
pub(crate) struct Record {
    pub(crate) time_s: Vec<f64>,
    pub(crate) force_n: Vec<f64>,
    /// Displacement of the tool along x and z of the base, mm.
    pub(crate) x_mm: Vec<f64>,
    pub(crate) z_mm: Vec<f64>,
}

struct Motion {
    inverse_mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    cubic: DVector<f64>,
    /// Work of a unit force at the tool on each coordinate.
    reach: DVector<f64>,
}

impl Motion {
    fn acceleration(&self, a: &DVector<f64>, v: &DVector<f64>, force_n: f64) -> DVector<f64> {
        let cubes = self.cubic.component_mul(&a.map(|x| x * x * x));
        &self.inverse_mass
            * (&self.reach * force_n - &self.damping * v - &self.stiffness * a - cubes)
    }

    fn step(&self, a: &mut DVector<f64>, v: &mut DVector<f64>, h: f64, force_n: [f64; 3]) {
        let k1 = self.acceleration(a, v, force_n[0]);
        let (a2, v2) = (&*a + &*v * (0.5 * h), &*v + &k1 * (0.5 * h));
        let k2 = self.acceleration(&a2, &v2, force_n[1]);
        let (a3, v3) = (&*a + &v2 * (0.5 * h), &*v + &k2 * (0.5 * h));
        let k3 = self.acceleration(&a3, &v3, force_n[1]);
        let (a4, v4) = (&*a + &v3 * h, &*v + &k3 * h);
        let k4 = self.acceleration(&a4, &v4, force_n[2]);
        *a += (&*v + (&v2 + &v3) * 2.0 + &v4) * (h / 6.0);
        *v += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
    }
}

impl HammerTest {
    /// Half a sine for each blow, N; 0.1 s into its share of the record.
    fn force_n(&self, peaks_n: &[f64], t: f64) -> f64 {
        let blow = (t / self.seconds_per_blow).floor();
        let since = t - blow * self.seconds_per_blow - 0.1;
        let Some(peak) = peaks_n.get(blow as usize) else { return 0.0 };
        if (0.0..self.contact_s).contains(&since) {
            peak * (PI * since / self.contact_s).sin()
        } else {
            0.0
        }
    }

    /// The furthest that a blow of 1 N at its peak turns any joint, within `seconds` after it.
    fn deflection_rad_per_n(&self, motion: &Motion, h: f64, seconds: f64) -> f64 {
        let (mut deflection, mut rate) = (motion.reach.map(|_| 0.0), motion.reach.map(|_| 0.0));
        let mut most = 0.0_f64;
        for i in 0..((0.1 + self.contact_s + seconds) / h) as usize {
            let from = i as f64 * h;
            let force = [from, from + 0.5 * h, from + h].map(|t| self.force_n(&[1.0], t));
            motion.step(&mut deflection, &mut rate, h, force);
            most = deflection.iter().fold(most, |most, a| most.max(a.abs()));
        }
        most
    }

    /// The record of a pose of a planar arm, struck obliquely in its plane.
    pub(crate) fn record(&self, world: &World, row: &Row, dice: &mut Dice) -> Record {
        let (mass, stiffness, dynamics) = world.matrices(row);
        let n = mass.nrows();
        let f = lowest_hz(&stiffness, &mass, n);
        // C = a M + b K has ζ = a / 2ω + b ω / 2: as wanted at the lowest and the highest mode.
        let (low, high) = (TAU * f[0], TAU * f[n - 1]);
        let b = 2.0 * self.damping_ratio / (low + high);
        let a = b * low * high;
        let angle = dice.even(0.6, 1.0);
        let motion = Motion {
            inverse_mass: mass.clone().try_inverse().unwrap(),
            damping: &mass * a + &stiffness * b,
            cubic: stiffness.diagonal() * (self.cubic / self.deflection_rad.powi(2)),
            stiffness,
            reach: dynamics.tip.transpose()
                * DVector::from_vec(vec![angle.cos(), 0.0, angle.sin()]),
        };
        let samples = (self.sample_rate_hz * self.seconds_per_blow * self.blows as f64) as usize;
        // Forty steps in the shortest period, and at least sixteen in a blow.
        let finest = (40.0 * f[n - 1]).max(16.0 / self.contact_s);
        let needed = (finest / self.sample_rate_hz).ceil() as usize;
        let coarse = 1.0 / self.sample_rate_hz / needed as f64;
        let parts = self.finer * needed;
        let h = 1.0 / self.sample_rate_hz / parts as f64;
        let hardest_n = self.deflection_rad / self.deflection_rad_per_n(&motion, coarse, TAU / low);
        let peaks_n: Vec<f64> = (0..self.blows).map(|_| hardest_n * dice.even(0.67, 1.0)).collect();
        let (mut deflection, mut rate) = (DVector::zeros(n), DVector::zeros(n));
        let mut record =
            Record { time_s: Vec::new(), force_n: Vec::new(), x_mm: Vec::new(), z_mm: Vec::new() };
        for i in 0..samples {
            let t = i as f64 / self.sample_rate_hz;
            let place = &dynamics.tip * &deflection * 1e3;
            record.time_s.push(t);
            record.force_n.push(self.force_n(&peaks_n, t));
            record.x_mm.push(place[0]);
            record.z_mm.push(place[2]);
            for part in 0..parts {
                let from = t + part as f64 * h;
                let force = [from, from + 0.5 * h, from + h].map(|t| self.force_n(&peaks_n, t));
                motion.step(&mut deflection, &mut rate, h, force);
            }
        }
        for channel in [&mut record.force_n, &mut record.x_mm, &mut record.z_mm] {
            let most = channel.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            channel.iter_mut().for_each(|x| *x += self.noise * most * dice.normal());
        }
        record
    }

    /// Records and session.yaml of a planar arm at some poses.
    pub(crate) fn session(&self, world: &World, rows: &[Row], folder: &Path, dice: &mut Dice) {
        let mut session = format!("sample_rate_hz: {}\nrecords:\n", self.sample_rate_hz);
        for (i, row) in rows.iter().enumerate() {
            let record = self.record(world, row, dice);
            let mut text = String::from("time_s,force_n,x_mm,z_mm\n");
            for s in 0..record.time_s.len() {
                let (t, f) = (record.time_s[s], record.force_n[s]);
                let (x, z) = (record.x_mm[s], record.z_mm[s]);
                let _ = writeln!(text, "{t:.6},{f:.4},{x:.7},{z:.7}");
            }
            let file = format!("pose{:02}.csv", i + 1);
            fs::write(folder.join(&file), text).unwrap();
            let degrees: Vec<String> =
                row.joints_rad.iter().map(|q| format!("{}", q.to_degrees())).collect();
            let _ = writeln!(
                session,
                "  - file: {file}\n    pose: {{joints_deg: [{}]}}\n    excitation: force_n\n    \
                 responses: [x_mm, z_mm]",
                degrees.join(", ")
            );
        }
        fs::write(folder.join("session.yaml"), session).unwrap();
    }
}
