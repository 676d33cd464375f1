//! What is wrong or odd about a table of measured modes.

use super::outcome::ResidualRow;
use crate::identify::{ModeRow, ModeTable};
use crate::model::Robot;
use crate::notes::{Code, Note, Part, Place};

/// What reading a file makes sure of, for tables that were made otherwise.
pub(super) fn check_rows(robot: &Robot, table: &ModeTable) -> Result<(), Note> {
    let positive = |value: &Option<f64>| value.is_none_or(|f| f.is_finite() && f > 0.0);
    for (row, measured) in table.rows.iter().enumerate() {
        let fault = |what| Err(Note::error(Code::Value, Place::part(Part::Pose(row)), what));
        if let Err(bad) = robot.check_pose(&measured.pose) {
            return fault(bad.to_string());
        }
        let numbers = measured.frequencies_hz.iter().chain(&measured.deviations_hz);
        if !numbers.into_iter().all(positive) || measured.frequencies_hz.len() != table.modes {
            return fault(format!(
                "frequencies are {:?} Hz and deviations {:?} Hz, must be {} and positive",
                measured.frequencies_hz, measured.deviations_hz, table.modes
            ));
        }
    }
    Ok(())
}

/// The table without columns of modes that the model lacks and that few rows have: any cause that
/// adds a mode would explain them. With a warning if there are such modes.
pub(super) fn within_the_model(table: &ModeTable, modes: usize) -> (ModeTable, Option<Note>) {
    let count = |column: usize| {
        table.rows.iter().filter(|row| row.frequencies_hz[column].is_some()).count()
    };
    let extra = (modes..table.modes).take_while(|&column| 2 * count(column) >= table.rows.len());
    let kept = modes.min(table.modes) + extra.count();
    let first = |values: &[Option<f64>]| values.iter().take(kept).copied().collect();
    let rows = table.rows.iter().map(|row| ModeRow {
        frequencies_hz: first(&row.frequencies_hz),
        deviations_hz: first(&row.deviations_hz),
        damping_ratios: first(&row.damping_ratios),
        rotations: row.rotations.iter().take(kept).cloned().collect(),
        ..row.clone()
    });
    let rows = rows.collect();
    let note = |code, what| Some(Note::warning(code, Place::default(), what));
    let plural = if modes == 1 { "" } else { "s" };
    let note = if kept < table.modes {
        let what = format!(
            "the model has {modes} mode{plural}: columns from 'f{}_hz' on are not used, few rows \
             have them",
            kept + 1
        );
        note(Code::LeftOut, what)
    } else if kept > modes {
        let what = format!(
            "the model has {modes} mode{plural}: only a cause that adds a mode can explain \
             'f{}_hz' and further columns",
            modes + 1
        );
        note(Code::Remark, what)
    } else {
        None
    };
    (ModeTable { rows, modes: kept, unstated: table.unstated.clone() }, note)
}

/// Frequencies that are all off by the factor between two units.
pub(super) fn unit_hint(residuals: &[ResidualRow]) -> Option<Note> {
    /// A model is seldom this near by chance, and all modes at once.
    const NEAR: f64 = 0.15;
    let mut ratios: Vec<f64> =
        residuals.iter().filter_map(|row| Some(row.measured_hz / row.before_hz?)).collect();
    ratios.sort_by(f64::total_cmp);
    let at = |share: f64| ratios.get((share * ratios.len() as f64) as usize).copied();
    let spread = [at(0.1)?, at(0.5)?, at(0.9)?];
    let units = [(std::f64::consts::TAU, "rad/s"), (60.0, "1/min")];
    let is_near = |factor: f64| spread.iter().all(|ratio| (ratio / factor - 1.0).abs() < NEAR);
    let (factor, unit) = units.into_iter().find(|&(factor, _)| is_near(factor))?;
    let what = format!(
        "the frequencies are about {factor:.2} times the model's: are they in {unit}? Columns \
         f1_hz, f2_hz, … are in Hz"
    );
    Some(Note::warning(Code::Units, Place::default(), what))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: &[[Option<f64>; 3]]) -> ModeTable {
        let row = |f: &[Option<f64>; 3]| ModeRow {
            frequencies_hz: f.to_vec(),
            deviations_hz: vec![None, None, Some(1.0)],
            ..ModeRow::default()
        };
        ModeTable { rows: rows.iter().map(row).collect(), modes: 3, unstated: Vec::new() }
    }

    #[test]
    fn modes_that_the_model_lacks_are_reported_and_left_out_where_few_rows_have_them() {
        let [one, two] = [[Some(10.0), Some(20.0), Some(30.0)], [Some(10.0), Some(20.0), None]];
        let (kept, note) = within_the_model(&table(&[one, two, two]), 2);
        assert_eq!((kept.modes, kept.rows[0].frequencies_hz.len()), (2, 2));
        assert_eq!(kept.rows[0].deviations_hz, [None, None]);
        assert!(note.unwrap().what.contains("from 'f3_hz' on"));
        let (kept, note) = within_the_model(&table(&[one, one]), 2);
        assert_eq!((kept.modes, kept.rows[0].frequencies_hz[2]), (3, Some(30.0)));
        assert!(note.unwrap().what.contains("adds a mode can explain 'f3_hz'"));
        assert_eq!(within_the_model(&table(&[one, two, two]), 3).1, None);
    }
}
