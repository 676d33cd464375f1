//! A table of identified modes: one row a pose. Plain data, without any model.

/// Measured modes over poses. `P` says where the robot stood: joint positions from base to tip in
/// rad or m, as the diagnosis needs them, or a session's [`Pose`](super::pose::Pose).
#[derive(Debug, Clone, PartialEq)]
pub struct ModeTable<P = Vec<f64>> {
    /// One entry a pose, in the order of the file.
    pub rows: Vec<ModeRow<P>>,
    /// Number of columns of frequencies; each row has as many entries.
    pub modes: usize,
    /// Joints, by name, that the table does not state: what `pose` has for them is assumed.
    pub unstated: Vec<String>,
}

/// The modes at one pose and what they were measured under.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModeRow<P = Vec<f64>> {
    /// Where the robot stood.
    pub pose: P,
    /// Natural frequencies, Hz, ascending; `None` where none was measured.
    pub frequencies_hz: Vec<Option<f64>>,
    /// Their standard deviations, Hz.
    pub deviations_hz: Vec<Option<f64>>,
    /// Their damping ratios.
    pub damping_ratios: Vec<Option<f64>>,
    /// Temperature, °C.
    pub temperature_c: Option<f64>,
    /// Joint torque of the excitation, N·m.
    pub amplitude_nm: Option<f64>,
    /// Mass at the tip that is known to be there, kg.
    pub payload_kg: Option<f64>,
    /// Masses added at the centres of mass of links, by name, kg.
    pub added_kg: Vec<(String, f64)>,
    /// By mode, how links turn in it.
    pub rotations: Vec<Vec<MeasuredRotation>>,
    /// Samples per second of the record.
    pub sample_rate_hz: Option<f64>,
    /// What the row is called.
    pub id: Option<String>,
}

/// How a link turns in a mode, against the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredRotation {
    /// The link.
    pub link: String,
    /// About which axis.
    pub about: RotationAxis,
    /// Up to a factor that all rotations of the mode in this row have in common.
    pub value: f64,
    /// Its standard deviation, in the same unit.
    pub std: Option<f64>,
}

/// An axis about which a link turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RotationAxis {
    /// The axis of the joint that carries the link.
    Joint,
    /// An axis of the base frame, from 0.
    Base(usize),
}

impl<P> ModeRow<P> {
    /// The same row at a pose that is given otherwise.
    pub fn at<Q>(self, pose: Q) -> ModeRow<Q> {
        ModeRow {
            pose,
            frequencies_hz: self.frequencies_hz,
            deviations_hz: self.deviations_hz,
            damping_ratios: self.damping_ratios,
            temperature_c: self.temperature_c,
            amplitude_nm: self.amplitude_nm,
            payload_kg: self.payload_kg,
            added_kg: self.added_kg,
            rotations: self.rotations,
            sample_rate_hz: self.sample_rate_hz,
            id: self.id,
        }
    }
}

impl<P> ModeTable<P> {
    /// The step to which the frequencies are rounded, Hz: the coarsest common step that all of them
    /// are multiples of; 0 where there is none.
    pub fn quantum_hz(&self) -> f64 {
        /// Steps that people and instruments round to.
        const STEPS_HZ: [f64; 13] =
            [1.0, 0.5, 0.25, 0.2, 0.125, 0.1, 0.05, 0.025, 0.02, 0.01, 0.005, 0.002, 0.001];
        let values: Vec<f64> =
            self.rows.iter().flat_map(|row| row.frequencies_hz.iter().flatten().copied()).collect();
        // Fewer values may be multiples by chance.
        if values.len() < 6 {
            return 0.0;
        }
        let is_multiple = |step: f64| {
            values.iter().all(|value| {
                let steps = value / step;
                // Decimal fractions are not exact in binary.
                (steps - steps.round()).abs() < 1e-6 * steps.abs().max(1.0)
            })
        };
        STEPS_HZ.into_iter().find(|&step| is_multiple(step)).unwrap_or(0.0)
    }

    /// Number of frequencies in the table.
    pub fn count(&self) -> usize {
        self.rows.iter().map(|row| row.frequencies_hz.iter().flatten().count()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rounding_is_seen_in_the_values() {
        let table = |values: &[f64]| ModeTable::<Vec<f64>> {
            rows: values
                .iter()
                .map(|&f| ModeRow { frequencies_hz: vec![Some(f)], ..ModeRow::default() })
                .collect(),
            modes: 1,
            unstated: Vec::new(),
        };
        assert_eq!(table(&[10.05, 20.1, 33.35, 41.2, 50.0, 60.95]).quantum_hz(), 0.05);
        assert_eq!(table(&[10.01, 20.1, 33.35, 41.2, 50.0, 60.95]).quantum_hz(), 0.01);
        assert_eq!(table(&[10.0123, 20.1, 33.35, 41.2, 50.0, 60.95]).quantum_hz(), 0.0);
        assert_eq!(table(&[10.0, 20.0]).quantum_hz(), 0.0);
    }
}
