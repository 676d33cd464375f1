//! Static deflection, forced vibration and the error of the surface at one place.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt;

use nalgebra::{Complex, Matrix3x4, Vector3};

use super::tip::{Owner, TipMode, TipPlace, tip_receptance};
use crate::excitation::{
    DrillingForce, ForceHarmonic, ForceModel, MillingForce, coefficient_corners, coefficients,
    is_unlike,
};
use crate::job::{CuttingDirection, Operation, Tool};
use crate::stability::ToolMode;
use crate::units::{hz_from_rad_per_s, hz_from_rpm, rad_per_s_from_hz};

/// Harmonics of the force's own period, at least: what is beyond hardly moves an arm.
const HARMONICS: u32 = 12;

/// At most so many of the spindle where the force repeats once a turn, unless two of the tooth
/// passing or the tool's modes need more.
const SPINDLE_ORDERS: u32 = 48;

/// So many times the highest mode of the tool is looked at, in so many orders at most: a harmonic
/// falls with its order, and a tool that rings at the hundredth is far stiffer than an arm.
const BEYOND: f64 = 1.3;
const MAX_ORDERS: u32 = 600;

/// Heights of the cut at which the surface is looked at.
const HEIGHTS: usize = 5;

/// Why no cutting force is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoForce {
    /// The operation has no `cutting`.
    NoCutting,
    /// The material is not known and the job gives no coefficients.
    UnknownMaterial,
    /// The tool has no diameter.
    NoDiameter,
    /// A drill has unlike lips, and nothing but its thrust is known.
    UnlikeLips,
    /// The force is steady: it shakes nothing at any speed.
    Steady,
    /// Nothing cuts.
    OnlyAir,
    /// What the force does comes out as no finite number.
    NotFinite,
}

impl fmt::Display for NoForce {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoCutting => "the operation has no 'cutting'",
            Self::UnknownMaterial => {
                "cutting.material is not among al-6061, al-6082 and al-7075, and \
                 cutting.coefficients is not given"
            }
            Self::NoDiameter => "tool.diameter_mm is not given",
            Self::UnlikeLips => {
                "thrust_n says nothing of the force to the side that unlike lips make \
                 (tool.runout, pitch_deg or a single tooth): give cutting.material or coefficients"
            }
            Self::Steady => "the thrust of a drill with even lips is steady at every speed",
            Self::OnlyAir => {
                "nothing cuts: all moves run with the spindle stopped, at more than twice the \
                 operation's feed, or, of a drill, out of the work"
            }
            Self::NotFinite => {
                "what the force may do at the tool tip is no finite number: check 'tool', \
                 'cutting', the damping of the robot and what its frequencies are uncertain by"
            }
        })
    }
}

/// The cutting force of an operation.
///
/// # Errors
/// Why it is not known.
pub fn force_of(operation: &Operation) -> Result<ForceModel, NoForce> {
    let cutting = operation.cutting.as_ref().ok_or(NoForce::NoCutting)?;
    match (coefficients(cutting), cutting.drill().and_then(|drill| drill.thrust_n)) {
        (Some(_), _) => {}
        (None, Some(_)) if is_unlike(&operation.tool) => return Err(NoForce::UnlikeLips),
        (None, Some(_)) => {}
        (None, None) => return Err(NoForce::UnknownMaterial),
    }
    ForceModel::new(&operation.tool, cutting).ok_or(NoForce::NoDiameter)
}

/// The orders of the spindle at which a force has harmonics that are looked at, at speeds of
/// `slowest_rpm` and more: to beyond the tool's own modes.
pub fn orders_of(force: &ForceModel, tool: &Tool, slowest_rpm: f64) -> Vec<u32> {
    let force = match force {
        ForceModel::Drilling(force) => return force.orders(),
        ForceModel::Milling(force) => force,
    };
    let top = tool.teeth.saturating_mul(HARMONICS);
    let top = if force.is_computed() {
        top.min(SPINDLE_ORDERS.max(tool.teeth.saturating_mul(2)))
    } else {
        top
    };
    let highest_hz = tool.modes.iter().map(|mode| mode.frequency_hz).fold(0.0, f64::max);
    let beyond = (BEYOND * highest_hz / hz_from_rpm(slowest_rpm)).ceil().min(f64::from(MAX_ORDERS));
    let top = top.max(beyond as u32);
    let step = force.repeats().max(1);
    (1..=top / step).map(|h| h * step).collect()
}

/// A quantity as the model has it, and what it may come to: with every frequency of the arm where
/// it is worst within its interval, and coefficients as laboratories have them. Damping and the
/// tool's own modes are taken as they are given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Doubtful {
    /// As the model has it, m.
    pub value_m: f64,
    /// What it may come to, m.
    pub up_to_m: f64,
}

/// What the cut does at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct AtPlace {
    /// Where, 0..=1.
    pub s: f64,
    /// Whether the tool surely cuts there.
    pub is_sure: bool,
    /// How far the mean force moves the tip.
    pub deflection: Doubtful,
    /// √(Σ_k |u_k|²) over the harmonics.
    pub vibration: Doubtful,
    /// |u_k| of each order, m.
    pub amplitudes_m: Vec<f64>,
    /// How much material is left on the surface, m; below zero where too much is taken. Of a slot
    /// the side that is farther off; none in drilling.
    pub surface_error_m: Option<f64>,
    /// What a drill does beside; none in milling.
    pub drilling: Option<DrillingAt>,
}

/// Thrust and torque of a drill, and how far it is pushed aside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrillingAt {
    /// Thrust, N.
    pub thrust_n: f64,
    /// What it may come to, N.
    pub thrust_up_to_n: f64,
    /// Torque, N m, where it is known.
    pub torque_nm: Option<f64>,
    /// How far thrust and torque move the tip across the axis, m.
    pub skid_m: f64,
    /// As in [`TipPlace`].
    pub leaves_axis: bool,
}

/// The forces of a cut at one feed per tooth.
#[derive(Debug, Clone)]
struct Forces {
    mean_n: [f64; 3],
    /// About the axis out of the work: of a drill alone, against its turning; zero where it is not
    /// known.
    torque_nm: f64,
    harmonics: Vec<ForceHarmonic>,
}

/// The cutting forces of an operation along its path.
#[derive(Debug, Clone)]
pub struct Effects {
    /// As the model has it first.
    forces: Vec<ForceModel>,
    orders: Vec<u32>,
    direction: CuttingDirection,
    by_feed: BTreeMap<u64, Vec<Forces>>,
}

impl Effects {
    /// For the places of an operation.
    ///
    /// # Errors
    /// Why the force is not known.
    pub fn new(operation: &Operation, places: &[TipPlace]) -> Result<Self, NoForce> {
        let nominal = force_of(operation)?;
        let cutting = operation.cutting.as_ref().ok_or(NoForce::NoCutting)?;
        // A thrust that is given needs no coefficients.
        let corners = coefficient_corners(cutting).unwrap_or_default();
        let others =
            corners.into_iter().filter_map(|k| ForceModel::with(&operation.tool, cutting, k));
        let slowest = places.iter().map(|place| place.rpm).fold(f64::INFINITY, f64::min);
        let orders = orders_of(&nominal, &operation.tool, slowest);
        let forces: Vec<ForceModel> = std::iter::once(nominal).chain(others).collect();
        let mut by_feed = BTreeMap::new();
        for place in places {
            let feed = place.feed_per_tooth_m;
            let torque_nm = |force: &DrillingForce| force.torque_nm(feed);
            let of = |force: &ForceModel| Forces {
                mean_n: force.mean_n(feed),
                torque_nm: force.drilling().and_then(torque_nm).unwrap_or(0.0),
                harmonics: force.harmonics(&orders, feed),
            };
            by_feed.entry(feed.to_bits()).or_insert_with(|| forces.iter().map(of).collect());
        }
        Ok(Self { forces, orders, direction: cutting.direction, by_feed })
    }

    /// The orders of the harmonics.
    pub fn orders(&self) -> &[u32] {
        &self.orders
    }

    /// The force of a drill, as the model has it.
    pub fn drilling(&self) -> Option<&DrillingForce> {
        self.forces.first().and_then(ForceModel::drilling)
    }

    /// What the cut does at one of the places; `interval_hz` tells in which a frequency of the arm
    /// lies, Hz, by the mode's number from 1. `None` where the feed is that of no place, or the
    /// result is not finite.
    pub fn at(
        &self,
        place: &TipPlace,
        interval_hz: impl Fn(usize, f64) -> [f64; 2],
    ) -> Option<AtPlace> {
        let all = self.by_feed.get(&place.feed_per_tooth_m.to_bits())?;
        let forces = all.first()?;
        let turning = rad_per_s_from_hz(hz_from_rpm(place.rpm));
        let modes = &place.modes;
        let of_orders = |modes: &dyn Fn(usize) -> Vec<TipMode>| -> Vec<Receptance> {
            let at = |i: usize| tip_receptance(&modes(i), f64::from(self.orders[i]) * turning);
            (0..self.orders.len()).map(at).collect()
        };
        let (still, each) = (tip_receptance(modes, 0.0), of_orders(&|_| modes.clone()));
        let moved = moved(forces, &still, &each);
        let mut vibration = Doubtful::of(root(&moved.1));
        let mut deflection = Doubtful::of(moved.0.norm());
        let worst = |load: &TipLoad, omega: f64| worst(modes, load, omega, &interval_hz);
        let worst_each = of_orders(&|i| {
            worst(&TipLoad::of(&forces.harmonics[i]), f64::from(self.orders[i]) * turning)
        });
        let feed = place.feed_per_tooth_m;
        let [more, more_torque] =
            self.drilling().map_or([1.0; 2], |force| force.thrust_and_torque_up_to(feed));
        // Nobody says which hand a drill has, and a torque that helps may be smaller.
        let torques: &[f64] = if forces.torque_nm == 0.0 { &[0.0] } else { &[1.0, 0.0, -1.0] };
        let pairs = all.iter().flat_map(|forces| torques.iter().map(move |share| (forces, share)));
        let load = |(forces, share): (&Forces, &f64)| {
            let load = forces.mean(more, share * more_torque);
            (load.moves_m(&still).norm(), load)
        };
        let mut loads: Vec<(f64, TipLoad)> = pairs.map(load).collect();
        loads.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (moved_m, load) in loads {
            deflection.may_be(moved_m);
            // Most need no search for where they move the tip most.
            let at_most_m = at_most_m(modes, &load, &interval_hz);
            if at_most_m.is_nan() || at_most_m > deflection.up_to_m {
                deflection.may_be(answer(&worst(&load, 0.0), &load, 0.0).norm());
            }
        }
        for forces in all {
            for each in [&each, &worst_each] {
                vibration.may_be(root(&moves_m(&forces.harmonics, each)));
            }
        }
        let largest = all.iter().map(|forces| forces.mean_n[2] * more).fold(0.0, f64::max);
        let drilling = self.drilling().map(|force| DrillingAt {
            thrust_n: forces.mean_n[2],
            thrust_up_to_n: largest,
            torque_nm: force.torque_nm(place.feed_per_tooth_m),
            skid_m: moved.0.xy().norm(),
            leaves_axis: place.leaves_axis,
        });
        let at = AtPlace {
            s: place.s,
            is_sure: place.is_sure,
            deflection,
            vibration,
            amplitudes_m: moved.1.iter().map(|u| u.norm()).collect(),
            surface_error_m: match self.forces.first() {
                Some(ForceModel::Milling(force)) => Some(self.surface_error_m(force, &moved)),
                _ => None,
            },
            drilling,
        };
        [deflection, vibration].iter().all(Doubtful::is_finite).then_some(at)
    }

    /// Material is left where the tip lies inside of the surface as a tooth makes it: an up-milling
    /// one at φ = 0, on the side of y, a down-milling one at φ = π, on the other.
    fn surface_error_m(&self, force: &MillingForce, (rest, harmonics): &Moved) -> f64 {
        let sides: &[(f64, f64)] = match self.direction {
            CuttingDirection::Conventional => &[(0.0, -1.0)],
            CuttingDirection::Climb => &[(PI, 1.0)],
            CuttingDirection::Slot => &[(0.0, -1.0), (PI, 1.0)],
            CuttingDirection::Drill(_) => &[],
        };
        let mut worst = 0.0_f64;
        for &(phi, sign) in sides {
            for theta in force.angles_rad() {
                for height in 0..HEIGHTS {
                    let lag = force.lag_rad() * height as f64 / (HEIGHTS - 1) as f64;
                    let turned = phi + lag - theta;
                    let wave = |(u, &k): (&Vector3<Complex<f64>>, &u32)| {
                        (u.y * Complex::cis(f64::from(k) * turned)).re
                    };
                    let y = rest.y + harmonics.iter().zip(&self.orders).map(wave).sum::<f64>();
                    if y.abs() > worst.abs() {
                        worst = sign * y;
                    }
                }
            }
        }
        worst
    }
}

impl Doubtful {
    fn of(value_m: f64) -> Self {
        Self { value_m, up_to_m: value_m }
    }

    fn may_be(&mut self, m: f64) {
        // `f64::max` would drop what is no number.
        self.up_to_m = if m <= self.up_to_m { self.up_to_m } else { m };
    }

    fn is_finite(&self) -> bool {
        self.value_m.is_finite() && self.up_to_m.is_finite()
    }
}

/// How the mean force moves the tip, and how each harmonic does.
type Moved = (Vector3<f64>, Vec<Vector3<Complex<f64>>>);

/// As [`tip_receptance`] has it.
type Receptance = Matrix3x4<Complex<f64>>;

fn moved(forces: &Forces, still: &Receptance, each: &[Receptance]) -> Moved {
    let rest = forces.mean(1.0, 1.0).moves_m(still).map(|u| u.re);
    (rest, moves_m(&forces.harmonics, each))
}

/// How each harmonic moves the tip.
fn moves_m(harmonics: &[ForceHarmonic], each: &[Receptance]) -> Vec<Vector3<Complex<f64>>> {
    let one = |(k, at): (&ForceHarmonic, &Receptance)| TipLoad::of(k).moves_m(at);
    harmonics.iter().zip(each).map(one).collect()
}

/// What acts on the tip at one frequency.
#[derive(Debug, Clone)]
struct TipLoad {
    force_n: Vector3<Complex<f64>>,
    /// About the axis out of the work.
    torque_nm: f64,
}

impl TipLoad {
    fn moves_m(&self, receptance: &Receptance) -> Vector3<Complex<f64>> {
        receptance * self.force_n.push(Complex::from(self.torque_nm))
    }

    fn of(harmonic: &ForceHarmonic) -> Self {
        Self { force_n: Vector3::from(harmonic.amplitude_n), torque_nm: 0.0 }
    }
}

impl Forces {
    /// The mean with the force so many times, and the torque.
    fn mean(&self, times: f64, torque_times: f64) -> TipLoad {
        let force_n = Vector3::from(self.mean_n).map(|n| Complex::from(n * times));
        TipLoad { force_n, torque_nm: self.torque_nm * torque_times }
    }
}

fn answer(modes: &[TipMode], load: &TipLoad, omega_rad_per_s: f64) -> Vector3<Complex<f64>> {
    modes.iter().map(|one| one.moved_m(&load.force_n, load.torque_nm, omega_rad_per_s)).sum()
}

fn root(harmonics: &[Vector3<Complex<f64>>]) -> f64 {
    // The sum of none is minus zero.
    harmonics.iter().map(Vector3::norm_squared).fold(0.0, |sum, one| sum + one).sqrt()
}

/// What a steady load moves the tip by at most: each mode as soft as it may be, all in one
/// direction.
fn at_most_m(
    modes: &[TipMode],
    load: &TipLoad,
    interval_hz: &impl Fn(usize, f64) -> [f64; 2],
) -> f64 {
    let of = |one: &TipMode| {
        let own = one.mode.omega_rad_per_s;
        let lowest = match one.of {
            Owner::Arm(number) => {
                own.min(rad_per_s_from_hz(interval_hz(number, hz_from_rad_per_s(own))[0]))
            }
            Owner::Tool => own,
        };
        answer(&[*one], load, 0.0).norm() * (own / lowest).powi(2)
    };
    modes.iter().map(of).sum()
}

/// The modes with each frequency of the arm where, within its interval, the answer to a load is
/// largest. As near to ω as can be is not always that: of two modes on either side of ω one takes
/// away what the other gives. So in turn each mode is taken at its nearest, the others where they
/// add most to it; from the best of these one mode after the other goes to an end of its interval
/// or to its own place as long as that makes the answer larger.
fn worst(
    modes: &[TipMode],
    load: &TipLoad,
    omega: f64,
    interval_hz: &impl Fn(usize, f64) -> [f64; 2],
) -> Vec<TipMode> {
    let candidates = |one: &TipMode| -> Vec<TipMode> {
        let Owner::Arm(number) = one.of else { return vec![*one] };
        let own = one.mode.omega_rad_per_s;
        let [low, high] = interval_hz(number, hz_from_rad_per_s(own)).map(rad_per_s_from_hz);
        let [low, high] = [low.min(own), high.max(own)];
        let places = [omega.max(low).min(high), low, high, own];
        let at = |omega_rad_per_s| ToolMode { omega_rad_per_s, ..one.mode };
        places.map(|omega| TipMode { mode: at(omega), ..*one }).into()
    };
    let all: Vec<Vec<TipMode>> = modes.iter().map(candidates).collect();
    let answers: Vec<Vec<Vector3<Complex<f64>>>> =
        all.iter().map(|of| of.iter().map(|one| answer(&[*one], load, omega)).collect()).collect();
    let sum_of = |taken: &[usize]| -> Vector3<Complex<f64>> {
        answers.iter().zip(taken).map(|(of, at)| of[*at]).sum()
    };
    let with_most_along = |towards: &Vector3<Complex<f64>>| -> Vec<usize> {
        let along = |answer: &Vector3<Complex<f64>>| towards.dotc(answer).re;
        let best = |of: &Vec<Vector3<Complex<f64>>>| {
            (0..of.len()).max_by(|a, b| along(&of[*a]).total_cmp(&along(&of[*b]))).unwrap_or(0)
        };
        answers.iter().map(best).collect()
    };
    let starts = answers.iter().map(|of| with_most_along(&of[0])).chain([vec![0; all.len()]]);
    let norm = |taken: &Vec<usize>| sum_of(taken).norm_squared();
    let mut taken = starts.max_by(|a, b| norm(a).total_cmp(&norm(b))).unwrap_or_default();
    let mut sum = sum_of(&taken);
    loop {
        let before = taken.clone();
        for (at, of) in answers.iter().enumerate() {
            let others = sum - of[taken[at]];
            let size = |i: usize| (others + of[i]).norm_squared();
            let best = (0..of.len()).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0);
            if size(best) > size(taken[at]) {
                (taken[at], sum) = (best, others + of[best]);
            }
        }
        if taken == before {
            break;
        }
    }
    all.iter().zip(taken).map(|(of, at)| of[at]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(number: usize, omega_rad_per_s: f64, motion: [f64; 3]) -> TipMode {
        let mode = ToolMode { omega_rad_per_s, damping_ratio: 0.01, motion: Vector3::from(motion) };
        TipMode { of: Owner::Arm(number), mode, turning: 0.4 * motion[0] - 0.3 }
    }

    fn size(modes: &[TipMode], load: &TipLoad, omega: f64) -> f64 {
        answer(modes, load, omega).norm()
    }

    /// The largest answer with every frequency anywhere in its interval, by trying.
    fn scanned(modes: &[TipMode], load: &TipLoad, omega: f64, by: f64) -> f64 {
        const STEPS: usize = 40;
        let mut largest: f64 = 0.0;
        let count = (STEPS + 1).pow(modes.len() as u32);
        for index in 0..count {
            let mut rest = index;
            let moved = modes.iter().map(|one| {
                let step = rest % (STEPS + 1);
                rest /= STEPS + 1;
                let factor = 1.0 + by * (2.0 * step as f64 / STEPS as f64 - 1.0);
                let omega_rad_per_s = factor * one.mode.omega_rad_per_s;
                TipMode { mode: ToolMode { omega_rad_per_s, ..one.mode }, ..*one }
            });
            largest = largest.max(size(&moved.collect::<Vec<_>>(), load, omega));
        }
        largest
    }

    /// As near to the excitation as they can be, modes on both sides of it cancel each other.
    #[test]
    fn the_worst_frequencies_are_worse_than_the_nearest() {
        let real = |f: [f64; 3]| Vector3::from(f).map(Complex::from);
        for torque_nm in [0.0, 0.7] {
            for (modes, force, omega, by) in [
                (
                    vec![mode(1, 90.0, [1.0, 0.0, 0.0]), mode(2, 112.0, [1.0, 0.0, 0.0])],
                    real([1.0, 0.0, 0.0]),
                    100.0,
                    0.05,
                ),
                (
                    vec![mode(1, 80.0, [1.0, 0.0, 0.0]), mode(2, 80.0, [-0.8, 0.6, 0.0])],
                    real([0.2, 1.0, 0.0]),
                    0.0,
                    0.1,
                ),
                (
                    vec![
                        mode(1, 90.0, [0.4, 0.9, 0.1]),
                        mode(2, 101.0, [-0.7, 0.3, 0.5]),
                        mode(3, 140.0, [0.6, -0.6, 0.2]),
                    ],
                    real([0.5, -1.0, 0.3]),
                    104.0,
                    0.1,
                ),
            ] {
                let interval = |_: usize, hz: f64| [hz * (1.0 - by), hz * (1.0 + by)];
                let load = TipLoad { force_n: force, torque_nm };
                let found = size(&worst(&modes, &load, omega, &interval), &load, omega);
                let all = scanned(&modes, &load, omega, by);
                println!("{found:e} by ends, {all:e} by trying");
                assert!(found > 0.98 * all, "{found:e} {all:e}");
            }
        }
    }
}
