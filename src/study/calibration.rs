//! Which corrections of a robot were fitted to a table of measured modes: by the table's digest, or
//! by a pose in common.

use std::hash::Hasher;

use fnv::FnvHasher;

use crate::identify::{ModeRow, ModeTable};
use crate::input::{DescribedRobot, FittedCorrection};

/// Poses that differ by less in every joint are the same, rad or m: no frequency shows the
/// difference.
const SAME_POSE: f64 = 1e-3;

/// Digest of the numbers of a table: the same whatever its comments, line ends, names of rows and
/// order of columns.
pub(super) fn digest(table: &ModeTable) -> String {
    let mut hasher = FnvHasher::default();
    let mut add = |value: Option<f64>| {
        // No number of a table has the bits of NaN; adding zero makes -0 the same as 0.
        hasher.write(&value.map_or(f64::NAN, |value| value + 0.0).to_bits().to_le_bytes());
    };
    add(Some(table.modes as f64));
    for row in &table.rows {
        let ModeRow { pose, frequencies_hz, deviations_hz, .. } = row;
        pose.iter().for_each(|&q| add(Some(q)));
        frequencies_hz.iter().chain(deviations_hz).for_each(|&value| add(value));
        [row.temperature_c, row.amplitude_nm, row.payload_kg, row.sample_rate_hz]
            .into_iter()
            .for_each(&mut add);
        for (link, kg) in row.added_kg.iter().filter(|(_, kg)| *kg > 0.0) {
            link.bytes().for_each(|byte| add(Some(f64::from(byte))));
            add(Some(*kg));
        }
    }
    format!("fnv1a-{:016x}", hasher.finish())
}

/// The corrections of a robot that were fitted to poses of this table, or after one that was; and
/// the others. What was written by hand is among the others.
pub(super) fn fitted_to_table(
    robot: &DescribedRobot,
    table: &ModeTable,
    digest: &str,
) -> (Vec<FittedCorrection>, Vec<FittedCorrection>) {
    let fitted_to = robot.calibration.iter().flat_map(|calibration| &calibration.fitted_to);
    let shared: Vec<&str> = fitted_to
        .filter(|fitted| fitted.joints.iter().any(|q| has_pose(table, q)))
        .map(|fitted| fitted.table.digest.as_str())
        .chain([digest])
        .collect();
    let is_shared = |correction: &FittedCorrection| {
        correction.table.as_deref().is_some_and(|table| shared.contains(&table))
    };
    // What was fitted later was fitted to a model that had the earlier corrections.
    let corrections = &robot.corrections;
    let first = corrections.iter().position(is_shared).unwrap_or(corrections.len());
    let (fitted, kept): (Vec<_>, Vec<_>) = corrections
        .iter()
        .enumerate()
        .partition(|(i, correction)| *i >= first && correction.table.is_some());
    let owned = |list: Vec<(usize, &FittedCorrection)>| {
        list.into_iter().map(|(_, correction)| correction.clone()).collect()
    };
    (owned(fitted), owned(kept))
}

fn has_pose(table: &ModeTable, pose: &[f64]) -> bool {
    let is_same = |row: &ModeRow| {
        row.pose.len() == pose.len()
            && row.pose.iter().zip(pose).all(|(a, b)| (a - b).abs() < SAME_POSE)
    };
    table.rows.iter().any(is_same)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::input::{CalibrationRecord, FittedTable, Reading, TableName, read_described_robot};
    use crate::model::{Calibration, Cause, Correction};

    fn table(poses: &[[f64; 2]]) -> ModeTable {
        let row = |&[a, b]: &[f64; 2]| ModeRow {
            pose: vec![a, b],
            frequencies_hz: vec![Some(20.0 + a), None],
            deviations_hz: vec![None, None],
            ..ModeRow::default()
        };
        ModeTable { rows: poses.iter().map(row).collect(), modes: 2, unstated: Vec::new() }
    }

    fn correction(at: &str, table: Option<&ModeTable>) -> FittedCorrection {
        FittedCorrection {
            correction: Correction {
                cause: Cause::Payload,
                at: Some(at.to_owned()),
                parameters: vec![("mass_kg".to_owned(), 1.0)],
                hinge: None,
            },
            ci95: vec![("mass_kg".to_owned(), [0.5, 2.0])],
            table: table.map(digest),
            note: None,
        }
    }

    /// A robot with a correction of each table and some by hand between them.
    fn robot(first: &ModeTable, second: &ModeTable) -> DescribedRobot {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/two-link/robot.yaml");
        let mut robot = read_described_robot(&file, &mut Reading::default()).unwrap();
        robot.corrections = vec![
            correction("hand 1", None),
            correction("first", Some(first)),
            correction("hand 2", None),
            correction("second", Some(second)),
        ];
        let fitted = |table: &ModeTable| FittedTable {
            table: TableName { file: String::new(), digest: digest(table) },
            joints: table.rows.iter().map(|row| row.pose.clone()).collect(),
        };
        robot.calibration = Some(CalibrationRecord {
            model: Calibration {
                poses: 2,
                heldout_rms_percent: 1.0,
                is_doubtful: false,
                posterior: None,
            },
            table: None,
            fitted_to: vec![fitted(first), fitted(second)],
        });
        robot
    }

    #[test]
    fn corrections_that_were_fitted_to_a_pose_of_the_table_are_fitted_again() {
        let first = table(&[[0.0, 0.1], [0.0, 0.2]]);
        let second = table(&[[0.0, 0.5], [0.3, 0.2]]);
        let robot = robot(&first, &second);
        let fitted = |table: &ModeTable| -> Vec<String> {
            let (fitted, kept) = fitted_to_table(&robot, table, &digest(table));
            assert_eq!(fitted.len() + kept.len(), 4);
            assert!(kept.iter().any(|c| c.table.is_none()));
            fitted.into_iter().filter_map(|c| c.correction.at).collect()
        };
        // What was fitted to the second was fitted on top of the first.
        assert_eq!(fitted(&first), ["first", "second"]);
        assert_eq!(fitted(&second), ["second"]);
        // With rows added, with rows taken away, with poses that were rounded.
        assert_eq!(fitted(&table(&[[0.0, 0.1], [0.0, 0.2], [1.0, 1.0]])), ["first", "second"]);
        assert_eq!(fitted(&table(&[[0.3, 0.2]])), ["second"]);
        assert_eq!(fitted(&table(&[[0.300_04, 0.199_97]])), ["second"]);
        // At fresh poses everything stays.
        assert!(fitted(&table(&[[1.0, 0.1], [1.0, 0.2]])).is_empty());
    }

    #[test]
    fn the_digest_is_that_of_the_numbers() {
        let one = table(&[[0.0, 0.1], [0.0, 0.2]]);
        let mut same = one.clone();
        same.rows[0].id = Some("a".to_owned());
        same.rows[0].pose[0] = -0.0;
        assert_eq!(digest(&one), digest(&same));
        let mut other = one.clone();
        other.rows[0].frequencies_hz.swap(0, 1);
        assert_ne!(digest(&one), digest(&other));
        other = one.clone();
        other.rows[1].payload_kg = Some(2.0);
        assert_ne!(digest(&one), digest(&other));
        assert_ne!(digest(&one), digest(&table(&[[0.0, 0.2], [0.0, 0.1]])));
    }
}
