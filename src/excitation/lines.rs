//! The lines: multiples of the spindle's frequency.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

use crate::job::{Policy, Tool};
use crate::units::hz_from_rpm;

/// A line of a cutter with uneven pitch counts if the pitch lets through at least this share of
/// what evenly pitched teeth would put on the tooth-passing line. At a mode with 2 % damping that
/// is half of what the tooth-passing force deflects at rest.
const MIN_PITCH_WEIGHT: f64 = 0.02;

/// Where an excitation line comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    inline,
    description = "`tooth_passing`: multiples of teeth times spindle frequency. \
                   `spindle`: multiples of the spindle\nfrequency."
)]
pub enum Source {
    /// Teeth entering the work: multiples of z·n/60.
    ToothPassing,
    /// The spindle's own turn: multiples of n/60, from runout, unbalance or uneven pitch.
    Spindle,
}

/// One excitation line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Line")]
pub struct ExcitationLine {
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub source: Source,
    /// Which multiple of the source's own frequency, counted from 1.
    pub harmonic: u32,
    /// The same as a multiple of the spindle's frequency.
    pub order: u32,
}

/// An excitation line as results name it beside other facts.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(remote = "ExcitationLine", deny_unknown_fields)]
pub struct WithoutOrder {
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub source: Source,
    /// Which multiple of the source's own frequency, counted from 1.
    pub harmonic: u32,
}

impl ExcitationLine {
    /// Frequency at a spindle speed, Hz.
    pub fn frequency_hz(&self, rpm: f64) -> f64 {
        f64::from(self.order) * hz_from_rpm(rpm)
    }
}

/// The lines that a policy asks about, ascending in frequency. Where a spindle line coincides with
/// a tooth-passing line, it is listed once, as tooth passing.
///
/// Teeth with uneven pitch repeat only once a turn, so their force has lines at every multiple of
/// n/60, weighted by |Σ_j exp(i k θ_j)| / z with θ_j the teeth's angles. Up to the highest
/// tooth-passing harmonic asked for, those that weigh at least 2 % are listed as multiples of the
/// spindle's frequency.
pub fn lines(tool: &Tool, policy: &Policy) -> Vec<ExcitationLine> {
    let z = tool.teeth;
    let top = z.saturating_mul(policy.tooth_passing_harmonics);
    let mut lines: Vec<ExcitationLine> = (1..=policy.tooth_passing_harmonics)
        .map(|harmonic| ExcitationLine {
            source: Source::ToothPassing,
            harmonic,
            order: harmonic.saturating_mul(z),
        })
        .collect();
    let uneven = |k: u32| {
        tool.pitch_rad
            .as_ref()
            .is_some_and(|pitch| k <= top && pitch_weight(pitch, k) >= MIN_PITCH_WEIGHT)
    };
    lines.extend(
        (1..=policy.spindle_harmonics.max(top))
            .filter(|&k| k <= policy.spindle_harmonics || uneven(k))
            .filter(|&k| k > top || !k.is_multiple_of(z))
            .map(|k| ExcitationLine { source: Source::Spindle, harmonic: k, order: k }),
    );
    lines.sort_by_key(|line| line.order);
    lines
}

/// |Σ_j exp(i k θ_j)| / z: one at multiples of z and zero between for evenly pitched teeth.
fn pitch_weight(pitch_rad: &[f64], k: u32) -> f64 {
    let mut angle = 0.0;
    let (mut re, mut im) = (0.0, 0.0);
    for pitch in pitch_rad {
        let (sin, cos) = (f64::from(k) * angle % TAU).sin_cos();
        re += cos;
        im += sin;
        angle += pitch;
    }
    f64::hypot(re, im) / pitch_rad.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::rad_from_deg;

    fn tool(teeth: u32, pitch_deg: Option<&[f64]>) -> Tool {
        Tool {
            name: None,
            teeth,
            diameter_m: None,
            pitch_rad: pitch_deg.map(|pitch| pitch.iter().map(|&p| rad_from_deg(p)).collect()),
            ..Tool::default()
        }
    }

    fn policy(tooth_passing_harmonics: u32, spindle_harmonics: u32) -> Policy {
        Policy {
            tooth_passing_harmonics,
            spindle_harmonics,
            separation: 0.1,
            model_uncertainty: None,
            confidence: 0.95,
            ignore_hz: vec![],
            min_tip_response_m_per_n: None,
            max_deflection_m: None,
            max_vibration_m: None,
        }
    }

    fn found(tool: &Tool, policy: &Policy) -> Vec<(Source, u32, u32)> {
        lines(tool, policy).iter().map(|l| (l.source, l.harmonic, l.order)).collect()
    }

    use Source::{Spindle, ToothPassing};

    #[test]
    fn even_teeth_have_their_multiples_and_the_spindles() {
        let expected = [(Spindle, 1, 1), (ToothPassing, 1, 3), (ToothPassing, 2, 6)];
        assert_eq!(found(&tool(3, None), &policy(2, 1)), expected);
        assert_eq!(found(&tool(3, Some(&[120.0; 3])), &policy(2, 1)), expected);
        assert_eq!(found(&tool(3, None), &policy(1, 0)), [(ToothPassing, 1, 3)]);
        let line = lines(&tool(2, None), &policy(2, 0))[1];
        assert!((line.frequency_hz(1100.0) - 4.0 * 1100.0 / 60.0).abs() < 1e-12);
    }

    #[test]
    fn coinciding_lines_are_listed_once_as_tooth_passing() {
        assert_eq!(found(&tool(1, None), &policy(1, 2)), [(ToothPassing, 1, 1), (Spindle, 2, 2)]);
        let two = found(&tool(2, None), &policy(2, 4));
        assert_eq!(
            two,
            [(Spindle, 1, 1), (ToothPassing, 1, 2), (Spindle, 3, 3), (ToothPassing, 2, 4)]
        );
    }

    /// Pairs 70°/110°: |1 + e^(i70k)| |1 + e^(i180k)| / 4 vanishes for odd k; for k = 2 it is
    /// |1 + e^(i140°)| / 2 = cos 70° = 0.342.
    #[test]
    fn uneven_teeth_add_lines_where_the_pitch_lets_them_through() {
        let pitch = [70.0, 110.0, 70.0, 110.0];
        let weight =
            |k| pitch_weight(&pitch.iter().map(|&p| rad_from_deg(p)).collect::<Vec<_>>(), k);
        assert!((weight(2) - rad_from_deg(70.0).cos()).abs() < 1e-12);
        assert!(weight(1) < 1e-12 && weight(3) < 1e-12);
        assert_eq!(
            found(&tool(4, Some(&pitch)), &policy(1, 0)),
            [(Spindle, 2, 2), (ToothPassing, 1, 4)]
        );
    }
}
