//! The arm as it really is: its bodies and springs, and laws that no robot file holds.

use nalgebra::{DMatrix, DVector, Vector3};

use super::arm::{Arm, Body, Extra, GRAVITY_M_PER_S2, Kind};
use super::dynamics::{Element, Motion, frame, motion, roll_pitch_yaw, rotation, shift, turn};
use super::eigen::lowest_hz;

/// Temperature at which the springs are what the model says, °C.
pub(crate) const REFERENCE_C: f64 = 20.0;

/// One measured pose, and the circumstances.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    pub(crate) joints_rad: Vec<f64>,
    /// Of the pose before, for what remembers.
    pub(crate) previous_rad: Vec<f64>,
    pub(crate) temperature_c: f64,
    pub(crate) amplitude_nm: f64,
    /// Mass that hangs at the tool and is written down, kg.
    pub(crate) payload_kg: f64,
    /// Something that happened at half of the poses and nobody wrote down.
    pub(crate) unseen: bool,
    /// Something that nobody measured, of unit variance.
    pub(crate) scatter: f64,
    /// Whether a mode was overlooked here.
    pub(crate) overlooked: bool,
}

/// A body of a link of which the outer part bends away from the inner one.
#[derive(Debug, Clone)]
pub(crate) struct Bend {
    /// Index of the link, from 1.
    pub(crate) link: usize,
    /// Along the link's reach.
    pub(crate) fraction: f64,
    pub(crate) axis: Vector3<f64>,
    pub(crate) stiffness_nm_per_rad: f64,
}

/// By what factor a joint's spring differs from its constant at one pose.
#[derive(Debug, Clone)]
pub(crate) enum Law {
    /// 1 + a |τ|/τ_ref.
    LoadStiffens { a: f64, reference_nm: f64 },
    /// 1 / (1 + a |τ|/τ_ref).
    LoadSoftens { a: f64, reference_nm: f64 },
    /// 1 + a (1 − exp(−2 |τ|/τ_ref)): stiff once the teeth are in touch.
    LoadSaturates { a: f64, reference_nm: f64 },
    /// 1 − a A/A_ref.
    AmplitudeSoftens { a: f64, reference_nm: f64 },
    /// (A/A_ref)^−a.
    AmplitudePower { a: f64, reference_nm: f64 },
    /// 1 − a (ϑ − ϑ_ref).
    Warms { per_k: f64 },
    /// 1 + a sin(3 q + φ).
    Wave { a: f64, phase_rad: f64 },
    /// 1 + a at the poses where nobody looked: beyond the vocabulary.
    Jump { a: f64 },
    /// 1 ± a by the side from which the pose was reached: beyond the vocabulary.
    Hysteresis { a: f64 },
}

impl Law {
    fn factor(&self, joint: usize, row: &Row, torque_nm: f64) -> f64 {
        let q = row.joints_rad[joint];
        match *self {
            Self::LoadStiffens { a, reference_nm } => 1.0 + a * torque_nm.abs() / reference_nm,
            Self::LoadSoftens { a, reference_nm } => {
                1.0 / (1.0 + a * torque_nm.abs() / reference_nm)
            }
            Self::LoadSaturates { a, reference_nm } => {
                1.0 + a * (1.0 - (-2.0 * torque_nm.abs() / reference_nm).exp())
            }
            Self::AmplitudeSoftens { a, reference_nm } => 1.0 - a * row.amplitude_nm / reference_nm,
            Self::AmplitudePower { a, reference_nm } => (row.amplitude_nm / reference_nm).powf(-a),
            Self::Warms { per_k } => 1.0 - per_k * (row.temperature_c - REFERENCE_C),
            Self::Wave { a, phase_rad } => 1.0 + a * (3.0 * q + phase_rad).sin(),
            Self::Jump { a } => {
                if row.unseen {
                    1.0 + a
                } else {
                    1.0
                }
            }
            Self::Hysteresis { a } => {
                if q > row.previous_rad[joint] {
                    1.0 + a
                } else {
                    1.0 - a
                }
            }
        }
    }
}

/// What happens to a mode itself: beyond the vocabulary.
#[derive(Debug, Clone)]
pub(crate) enum ModeLaw {
    /// A tuned mass: the mode's ω² and the mass's ω_t² repel each other, [ω², ε ω ω_t; ε ω ω_t, ω_t²], and the
    /// branch nearer to the mode is seen.
    Absorber {
        mode: usize,
        frequency_hz: f64,
        coupling: f64,
    },
    /// Each mode times 1 + a s_r(q), s_r a smooth function of its own: Σ cos(w·q + φ) less its mean.
    /// Every mode times 1 + a s, s the row's own.
    Scatter {
        a: f64,
    },
    Smooth {
        a: f64,
        waves: Vec<Vec<(Vec<f64>, f64)>>,
        means: Vec<f64>,
    },
}

/// A sum of cosines of the pose.
pub(crate) fn waves_at(waves: &[(Vec<f64>, f64)], joints_rad: &[f64]) -> f64 {
    waves
        .iter()
        .map(|(w, phase)| (w.iter().zip(joints_rad).map(|(w, q)| w * q).sum::<f64>() + phase).cos())
        .sum()
}

impl ModeLaw {
    fn apply(&self, row: &Row, frequencies_hz: &mut [f64]) {
        match self {
            Self::Absorber { mode, frequency_hz, coupling } => {
                let Some(f) = frequencies_hz.get_mut(*mode) else { return };
                let (a, b) = (*f * *f, frequency_hz * frequency_hz);
                let half = (0.25 * (a - b).powi(2) + coupling * coupling * a * b).sqrt();
                let branch = if a > b { half } else { -half };
                *f = (0.5 * (a + b) + branch).sqrt();
            }
            Self::Scatter { a } => {
                frequencies_hz.iter_mut().for_each(|f| *f *= 1.0 + a * row.scatter)
            }
            Self::Smooth { a, waves, means } => {
                for (f, (waves, mean)) in frequencies_hz.iter_mut().zip(waves.iter().zip(means)) {
                    *f *= 1.0 + a * (waves_at(waves, &row.joints_rad) - mean);
                }
            }
        }
    }
}

/// What the instrument does to what it sees.
#[derive(Debug, Clone, Default)]
pub(crate) struct Instrument {
    /// Folds what lies above half of it, Hz.
    pub(crate) sample_rate_hz: Option<f64>,
    /// Mode (from 0) that is not seen at the poses that are so marked.
    pub(crate) missed_mode: Option<usize>,
}

/// The arm as it really is.
#[derive(Debug, Clone)]
pub(crate) struct World {
    pub(crate) arm: Arm,
    /// Added to what the joints tell, rad.
    pub(crate) zero_rad: Vec<f64>,
    /// Bodies that the arm carries without the model's knowledge, by link (0 is the base), in its frame.
    pub(crate) carried: Vec<(usize, Body)>,
    pub(crate) bends: Vec<Bend>,
    pub(crate) laws: Vec<(usize, Law)>,
    pub(crate) mode_laws: Vec<ModeLaw>,
    pub(crate) instrument: Instrument,
}

impl World {
    /// A world that the model describes in full.
    pub(crate) fn of(arm: &Arm) -> Self {
        Self {
            arm: arm.clone(),
            zero_rad: vec![0.0; arm.joints.len()],
            carried: Vec::new(),
            bends: Vec::new(),
            laws: Vec::new(),
            mode_laws: Vec::new(),
            instrument: Instrument::default(),
        }
    }

    /// The chain at a pose, and by elastic coordinate its spring and the joint that it belongs to.
    fn chain(&self, row: &Row) -> (Vec<Element>, Vec<(f64, Option<usize>)>) {
        let arm = &self.arm;
        let (mut chain, mut springs) = (Vec::new(), Vec::new());
        self.link(0, &arm.base, &mut chain, &mut springs);
        for (i, joint) in arm.joints.iter().enumerate() {
            let posed = rotation(&joint.axis, row.joints_rad[i] + self.zero_rad[i]);
            chain.push(Element::Step(frame(&roll_pitch_yaw(&joint.rpy_rad), &joint.origin_m)));
            chain.push(Element::Step(frame(&posed, &Vector3::zeros())));
            chain.push(Element::Spring(turn(&joint.axis, &Vector3::zeros())));
            springs.push((joint.stiffness_nm_per_rad, Some(i)));
            self.link(i + 1, &joint.body, &mut chain, &mut springs);
        }
        chain.push(Element::Step(frame(&nalgebra::Matrix3::identity(), &arm.tip_m)));
        if let Some(payload) = &arm.payload {
            chain.push(Element::Body(payload.pseudo_inertia()));
        }
        let known = Body::point(row.payload_kg, Vector3::zeros());
        chain.push(Element::Body(known.pseudo_inertia()));
        (chain, springs)
    }

    /// A link's own coordinates and bodies.
    fn link(
        &self,
        link: usize,
        body: &Body,
        chain: &mut Vec<Element>,
        springs: &mut Vec<(f64, Option<usize>)>,
    ) {
        for extra in self.arm.extras.iter().filter(|extra| extra.link == link) {
            chain.push(Element::Spring(match extra.kind {
                Kind::Rotation => turn(&extra.axis, &extra.origin_m),
                Kind::Translation => shift(&extra.axis),
            }));
            springs.push((extra.stiffness, None));
        }
        let whole = body.pseudo_inertia();
        match self.bends.iter().find(|bend| bend.link == link) {
            None => chain.push(Element::Body(whole)),
            Some(bend) => {
                let reach = self.arm.reach(link);
                let (inner, outer) = halves(body, bend.fraction, &reach);
                chain.push(Element::Body(inner.pseudo_inertia()));
                chain.push(Element::Spring(turn(&bend.axis, &(reach * bend.fraction))));
                springs.push((bend.stiffness_nm_per_rad, None));
                chain.push(Element::Body(outer.pseudo_inertia()));
            }
        }
        for (_, carried) in self.carried.iter().filter(|(at, _)| *at == link) {
            chain.push(Element::Body(carried.pseudo_inertia()));
        }
    }

    /// M with drives, K with laws and gravity, and the tool's Jacobian at a pose.
    pub(crate) fn matrices(&self, row: &Row) -> (DMatrix<f64>, DMatrix<f64>, Motion) {
        let (chain, springs) = self.chain(row);
        let motion = motion(&chain, GRAVITY_M_PER_S2);
        let mut mass = motion.mass.clone();
        let mut k = DVector::from_iterator(springs.len(), springs.iter().map(|(k, _)| *k));
        for (c, (_, joint)) in springs.iter().enumerate() {
            let Some(joint) = *joint else { continue };
            mass[(c, c)] += self.arm.joints[joint].drive_kgm2;
            for (_, law) in self.laws.iter().filter(|(at, _)| *at == joint) {
                k[c] *= law.factor(joint, row, motion.gravity_torque[c]);
            }
        }
        let mut stiffness = DMatrix::from_diagonal(&k);
        if self.arm.gravity_stiffness {
            stiffness += &motion.gravity_stiffness;
        }
        (mass, stiffness, motion)
    }

    /// Torque of gravity on a joint's spring, N·m.
    pub(crate) fn gravity_torque_nm(&self, joint: usize, row: &Row) -> f64 {
        let (chain, springs) = self.chain(row);
        let c = springs.iter().position(|(_, at)| *at == Some(joint)).unwrap();
        motion(&chain, GRAVITY_M_PER_S2).gravity_torque[c]
    }

    /// The `wanted` lowest frequencies at a pose as they are, Hz, ascending.
    pub(crate) fn frequencies_hz(&self, row: &Row, wanted: usize) -> Vec<f64> {
        let (mass, stiffness, _) = self.matrices(row);
        let mut frequencies = lowest_hz(&stiffness, &mass, wanted);
        for law in &self.mode_laws {
            law.apply(row, &mut frequencies);
        }
        frequencies.sort_by(f64::total_cmp);
        frequencies
    }

    /// The same as the instrument shows them: `columns` frequencies, a blank where none is left.
    pub(crate) fn seen_hz(&self, row: &Row, columns: usize) -> Vec<Option<f64>> {
        let mut seen = self.frequencies_hz(row, columns + 1);
        match self.instrument.missed_mode {
            Some(mode) if row.overlooked && mode < seen.len() => {
                seen.remove(mode);
            }
            _ => {}
        }
        seen.truncate(columns);
        if let Some(rate) = self.instrument.sample_rate_hz {
            for f in &mut seen {
                *f = (*f - rate * (*f / rate).round()).abs();
            }
        }
        (0..columns).map(|r| seen.get(r).copied()).collect()
    }
}

/// A body parted at a fraction of its reach: masses by the fraction, centres apart along the reach as far as its
/// second moment allows, and the sum unchanged.
fn halves(body: &Body, fraction: f64, reach: &Vector3<f64>) -> (Body, Body) {
    let u = reach.normalize();
    let (w, v) = (fraction, 1.0 - fraction);
    let second = body.second_moment() / body.mass_kg;
    let spread = u.dot(&(second.try_inverse().unwrap() * u)) * w * v;
    let apart = 0.8 / spread.sqrt();
    let left = second - u * u.transpose() * (w * v * apart * apart);
    let part = |share: f64, along: f64| {
        let mass_kg = share * body.mass_kg;
        let inertia = nalgebra::Matrix3::identity() * left.trace() - left;
        Body { mass_kg, com_m: body.com_m + u * along, inertia_kgm2: inertia * mass_kg }
    };
    (part(w, -v * apart), part(v, w * apart))
}

/// An elastic coordinate that the model lacks.
pub(crate) fn extra(
    link: usize,
    kind: Kind,
    axis: Vector3<f64>,
    origin_m: Vector3<f64>,
    stiffness: f64,
) -> Extra {
    Extra { name: format!("hidden_{link}"), link, kind, axis, origin_m, stiffness }
}
