//! Slot tests: feeds, depths and mean forces.

use std::path::Path;

use super::Reading;
use super::files::MAX_FILE_BYTES;
use crate::formats::table::Table;
use crate::formats::text::read_text;
use crate::identify::cutting::SlotTest;
use crate::notes::{Code, Note, Notes, Place};
use crate::units::m_from_mm;

/// Columns that must be there.
const NEEDED: [&str; 5] = ["feed_mm_per_tooth", "axial_depth_mm", "teeth", "fx_n", "fy_n"];

/// Reads a table of slot tests: CSV with a header, the columns feed_mm_per_tooth, axial_depth_mm,
/// teeth, fx_n and fy_n, optionally fz_n. Other columns are passed over, and so are lines that
/// begin with `#`.
///
/// # Errors
/// Every fault of the table, each with its line; a table without rows.
pub fn read_slots(path: &Path, reading: &mut Reading) -> Result<Vec<SlotTest>, Vec<Note>> {
    reading.files.push(path.to_owned());
    let text = read_text(path, MAX_FILE_BYTES)?;
    let mut notes = Notes::about(Place::file(path));
    let mut table = Table::open(path, text.as_bytes())?;
    let (header, line) = (table.header(), table.line());
    let find = |name: &str| header.iter().position(|title| title == name);
    let found = NEEDED.map(|name| (name, find(name)));
    let axial = find("fz_n");
    for (name, _) in found.iter().filter(|(_, column)| column.is_none()) {
        notes.error(Code::MissingKey, line, format!("no column '{name}'"));
    }
    let columns: Vec<usize> = found.iter().filter_map(|(_, column)| *column).collect();
    let Ok(columns) = <[usize; 5]>::try_from(columns) else { return Err(notes.finish().0) };
    let (mut rows, mut cells) = (Vec::new(), Vec::new());
    loop {
        match table.row(&mut cells) {
            Ok(true) => rows.extend(row(&table, &cells, columns, axial, &mut notes)),
            Ok(false) => break,
            Err(note) => {
                notes.push(note);
                break;
            }
        }
    }
    if rows.is_empty() && notes.errors() == 0 {
        notes.error(
            Code::TooLittleData,
            None,
            "has no rows, must have at least one below the header",
        );
    }
    let errors = reading.settle(notes);
    if errors.is_empty() { Ok(rows) } else { Err(errors) }
}

fn row(
    table: &Table<&[u8]>,
    cells: &[String],
    columns: [usize; 5],
    axial: Option<usize>,
    notes: &mut Notes,
) -> Option<SlotTest> {
    let line = table.line();
    let mut number = |column| match table.number(cells, column) {
        Ok(value) => Some(value),
        Err(fault) => {
            notes.push(fault);
            None
        }
    };
    let [feed, depth, teeth, x, y] = columns.map(&mut number);
    let axial = axial.map(&mut number);
    let (feed, depth, teeth, x, y) = (feed?, depth?, teeth?, x?, y?);
    let axial_n = match axial {
        Some(value) => Some(value?),
        None => None,
    };
    for (name, value) in [("feed_mm_per_tooth", feed), ("axial_depth_mm", depth)] {
        if value <= 0.0 {
            notes.error(Code::Value, line, format!("{name} is {value}, must be above zero"));
            return None;
        }
    }
    if !((1.0..=1000.0).contains(&teeth) && teeth.fract() == 0.0) {
        let what = format!("teeth is {teeth}, must be a whole number from 1 to 1000");
        notes.error(Code::Value, line, what);
        return None;
    }
    Some(SlotTest {
        feed_per_tooth_m: m_from_mm(feed),
        axial_depth_m: m_from_mm(depth),
        teeth: teeth as u32,
        force_n: [x, y],
        axial_n,
        line,
    })
}
