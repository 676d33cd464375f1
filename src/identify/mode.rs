//! A mode as one record shows it: from a pole with its residues to frequency, damping, shape and
//! scale.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::estimate::{C64, PoleEstimate};
use super::links::{LinkRotation, rotations};
use super::prepare::{Prepared, RecordKind, Response};
use super::record::Record;
use super::references::{PointPart, PointShape};
use crate::notes::Code;
use crate::units::hz_from_rad_per_s;

/// One part of a mode shape.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "JsonShapePart")]
pub struct ShapePart {
    /// Name of the response.
    pub response: String,
    /// Displacement against the largest part of the shape, which is 1 (responses of unknown
    /// quantity: as they were read).
    #[serde(flatten, with = "Parts")]
    pub value: C64,
    /// Standard deviation of its real and imaginary part.
    pub std: f64,
    /// Where a force was measured: φ_response·φ_reference of the receptance Σ φφ/(ω_r² − ω² +
    /// 2iζω_rω), 1/kg (where a quantity is not known: in the response's unit over N); real and
    /// imaginary part. Of several references: for a force at the shape's largest part, where it is
    /// known.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "both")]
    #[schemars(with = "Option<[f64; 2]>")]
    pub modal_constant: Option<C64>,
    /// Mass-normalised shape where the response at the driving point is known, 1/√kg: real and
    /// imaginary part.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "both")]
    #[schemars(with = "Option<[f64; 2]>")]
    pub mass_normalised: Option<C64>,
}

/// A displacement relative to the largest part of the shape, which is 1.
#[derive(Serialize, JsonSchema)]
#[serde(remote = "C64")]
struct Parts {
    /// Displacement relative to the largest part, which is 1.
    re: f64,
    im: f64,
}

fn both<S: Serializer>(value: &Option<C64>, to: S) -> Result<S::Ok, S::Error> {
    value.map(|value| [value.re, value.im]).serialize(to)
}

/// A mode as one record shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Natural frequency |λ|/2π, Hz.
    pub frequency_hz: f64,
    /// Standard deviation, Hz.
    pub frequency_std_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Standard deviation.
    pub damping_std: f64,
    /// One part a response.
    pub shape: Vec<ShapePart>,
    /// Free decays: displacement amplitude of the shape's largest part when the strongest decay
    /// begins, m (or the channel's unit).
    pub amplitude: Option<f64>,
    /// Lowest coherence of all responses, where several hits or stretches were averaged.
    pub coherence: Option<f64>,
    /// Fraction of the orders of the stabilisation diagram that have this pole.
    pub support: f64,
    /// Relative change of the frequency at the record's largest amplitudes, where it depends on
    /// amplitude: the frequency is then that of small amplitudes.
    pub drift: Option<f64>,
    /// Share of the residues' power over several references that is not of one shape, beyond what
    /// noise makes; `None` of one reference.
    pub apart: Option<f64>,
    /// Its loudest line relative to the spectrum's, at the response where that is most.
    pub prominence: f64,
    /// Rotation of each link with marked points.
    pub links: Vec<LinkRotation>,
    /// What else it may be: such a mode stays out of the table of modes.
    pub suspicion: Option<Code>,
}

/// Displacement amplitude of a residue: differentiation multiplies it by λ.
fn displacement(response: &Response, residue: C64, lambda: C64) -> C64 {
    residue / lambda.powi(response.quantity.derivatives().unwrap_or(0))
}

/// The mode of a pole; its `support` is not known here and 0.
pub(super) fn mode_of(record: &Record, prepared: &Prepared, pole: &PoleEstimate) -> Mode {
    let lambda = pole.pole.lambda;
    let count = prepared.responses.len();
    // Displacements with deviations, by block and response.
    let moves: Vec<Vec<(C64, f64)>> = pole
        .residues
        .iter()
        .map(|block| {
            (0..count)
                .map(|i| {
                    let value = displacement(&prepared.responses[i], block[i].value, lambda);
                    let scale = value.norm() / block[i].value.norm().max(f64::MIN_POSITIVE);
                    (value, scale * block[i].variance.sqrt())
                })
                .collect()
        })
        .collect();
    let over_points = prepared.pairs.as_ref().map(|pairs| pairs.shape(&moves[0]));
    let (shape, reference) = common_shape(&moves, count);
    let strongest = moves.iter().map(|block| block[reference].0.norm()).fold(0.0, f64::max);
    let constants: Option<Vec<C64>> = scaled(prepared).map(|per_step| {
        moves[0]
            .iter()
            .map(|(value, _)| value * C64::new(0.0, 2.0 * lambda.im * per_step))
            .collect()
    });
    let driving = constants.as_ref().and_then(|constants| {
        let name = record.driving_point.as_ref()?;
        let at = prepared.responses.iter().position(|response| response.name == *name)?;
        // The driving point's constant is a square, so positive but for noise.
        (constants[at].re > 0.0).then(|| constants[at].sqrt())
    });
    let parts = (0..count).map(|i| ShapePart {
        response: prepared.responses[i].name.clone(),
        value: shape[i].0,
        std: shape[i].1,
        modal_constant: constants.as_ref().map(|constants| constants[i]),
        mass_normalised: driving.and_then(|driving| Some(constants.as_ref()?[i] / driving)),
    });
    let amplitude = (prepared.kind == RecordKind::FreeDecay).then_some(2.0 * strongest);
    let per_residue = scaled(prepared).map(|per_step| C64::new(0.0, 2.0 * lambda.im * per_step));
    let parts: Vec<ShapePart> = match &over_points {
        Some(points) => parts_over_points(points, per_residue),
        None => parts.collect(),
    };
    let at_channel = |name: &str| {
        let part = parts.iter().find(|part| part.response == name)?;
        Some((part.value, part.std))
    };
    Mode {
        frequency_hz: hz_from_rad_per_s(pole.pole.omega()),
        frequency_std_hz: hz_from_rad_per_s(pole.omega_std),
        damping_ratio: pole.pole.ratio(),
        damping_std: pole.ratio_std,
        links: rotations(&record.links, &at_channel, amplitude),
        shape: parts,
        amplitude,
        coherence: coherence(prepared, hz_from_rad_per_s(pole.pole.omega())),
        support: 0.0,
        drift: pole.drift,
        apart: over_points.map(|points| (points.apart - points.by_noise).max(0.0)),
        prominence: pole.prominence,
        suspicion: None,
    }
}

/// The parts of a shape over points; `per_residue` turns a residue into a modal constant.
fn parts_over_points(points: &PointShape, per_residue: Option<C64>) -> Vec<ShapePart> {
    let largest = points.parts.iter().max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
    let unit = largest.map_or(C64::new(1.0, 0.0), |part| part.1);
    let size = unit.norm().max(f64::MIN_POSITIVE);
    let of_unit = largest.map_or(0.0, |part| part.2);
    let root = per_residue.filter(|_| points.is_scaled).map(|factor| factor.sqrt());
    let part = |(name, value, std): &PointPart| {
        let relative = value / unit;
        let is_unit = largest.is_some_and(|part| part.0 == *name);
        ShapePart {
            response: name.clone(),
            value: if is_unit { C64::new(1.0, 0.0) } else { relative },
            std: if is_unit { 0.0 } else { std.hypot(relative.norm() * of_unit) / size },
            modal_constant: root.map(|root| value * unit * root * root),
            mass_normalised: root.map(|root| {
                // The sign of a shape is free: its largest part is positive.
                let turn = if (unit * root).re < 0.0 { -1.0 } else { 1.0 };
                value * root * turn
            }),
        }
    };
    points.parts.iter().map(part).collect()
}

/// What a residue must be multiplied by to be one of the continuous receptance; `None` without
/// force.
fn scaled(prepared: &Prepared) -> Option<f64> {
    match prepared.kind {
        RecordKind::FreeDecay | RecordKind::RandomResponse => None,
        RecordKind::GivenResponses => Some(1.0),
        RecordKind::Hammer | RecordKind::Steady => prepared.nyquist_hz.map(|nyquist| 2.0 * nyquist),
    }
}

/// The shape that all blocks share, each block with an amplitude of its own: alternating least
/// squares. Its largest part is 1.
fn common_shape(moves: &[Vec<(C64, f64)>], count: usize) -> (Vec<(C64, f64)>, usize) {
    let power = |i: usize| moves.iter().map(|block| block[i].0.norm_sqr()).sum::<f64>();
    // The loudest of several decays, and its largest part, to begin with.
    let mut shape: Vec<C64> = moves
        .iter()
        .max_by(|a, b| {
            let size = |block: &[(C64, f64)]| block.iter().map(|(v, _)| v.norm_sqr()).sum::<f64>();
            size(a).total_cmp(&size(b))
        })
        .map_or_else(Vec::new, |block| block.iter().map(|(value, _)| *value).collect());
    let mut amplitudes = vec![C64::default(); moves.len()];
    for _ in 0..20 {
        let norm = shape.iter().map(C64::norm_sqr).sum::<f64>().max(f64::MIN_POSITIVE);
        for (amplitude, block) in amplitudes.iter_mut().zip(moves) {
            *amplitude =
                block.iter().zip(&shape).map(|((v, _), s)| v * s.conj()).sum::<C64>() / norm;
        }
        let norm = amplitudes.iter().map(C64::norm_sqr).sum::<f64>().max(f64::MIN_POSITIVE);
        for (i, part) in shape.iter_mut().enumerate() {
            *part =
                moves.iter().zip(&amplitudes).map(|(block, a)| block[i].0 * a.conj()).sum::<C64>()
                    / norm;
        }
    }
    let reference = (0..count).max_by(|&a, &b| power(a).total_cmp(&power(b))).unwrap_or(0);
    let unit = shape.get(reference).copied().unwrap_or(C64::new(1.0, 0.0));
    let norm = amplitudes.iter().map(C64::norm_sqr).sum::<f64>().max(f64::MIN_POSITIVE);
    let deviation = |i: usize| {
        let sum: f64 =
            moves.iter().zip(&amplitudes).map(|(block, a)| a.norm_sqr() * block[i].1.powi(2)).sum();
        sum.sqrt() / norm
    };
    let of_unit = deviation(reference);
    let size = unit.norm().max(f64::MIN_POSITIVE);
    let parts = (0..count)
        .map(|i| {
            if i == reference {
                return (C64::new(1.0, 0.0), 0.0);
            }
            let value = shape[i] / unit;
            (value, deviation(i).hypot(value.norm() * of_unit) / size)
        })
        .collect();
    (parts, reference)
}

/// Lowest coherence of all responses at the mode.
fn coherence(prepared: &Prepared, frequency_hz: f64) -> Option<f64> {
    let averaged = prepared.averaged.as_ref().filter(|averaged| !averaged.coherence.is_empty())?;
    let bin = averaged.frequencies_hz.get(1)?;
    let at = (frequency_hz / bin).round() as usize;
    let of = |coherence: &Vec<f64>| coherence.get(at).copied();
    averaged.coherence.iter().filter_map(of).min_by(f64::total_cmp)
}
