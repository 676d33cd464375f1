//! A table of poses, one row each: CSV, read as it streams in.

use std::io::Read;
use std::path::Path;

use super::Fault;
use super::table::Table;
use crate::model::{JointKind, Robot};
use crate::units::{m_from_mm, rad_from_deg};
use crate::wording::nearest;

type ToSi = fn(f64) -> f64;

/// Where the value of one joint stands.
#[derive(Debug, Clone, Copy)]
struct Column {
    index: usize,
    to_si: ToSi,
}

/// Poses of a robot as they stream in: an iterator over joint positions (rad or m, from base to tip), or
/// [`Self::read_into`] without a vector per pose.
#[derive(Debug)]
pub struct Poses<R> {
    table: Table<R>,
    columns: Vec<Column>,
    cells: Vec<String>,
}

/// Opens a table of poses: a header, then one row a pose. For each moving joint one column
/// `<joint name>_rad` or `_deg` (a prismatic joint: `_m` or `_mm`; `_rad` is read as m), in any order; other columns are passed
/// over, and so are lines that begin with `#`. `name` stands for the table in faults.
///
/// # Errors
/// A header that lacks a joint, names one twice, or cannot be read.
pub fn load_poses<R: Read>(reader: R, name: &Path, robot: &Robot) -> Result<Poses<R>, Vec<Fault>> {
    let table = Table::open(name, reader).map_err(|fault| vec![fault])?;
    let header = table.header();
    let mut faults = Vec::new();
    let mut fault = |what: String| faults.push(table.fault(&what));
    let mut columns = Vec::new();
    for joint in robot.joints() {
        let units: &[(&str, ToSi)] = match joint.kind {
            // Tables made for any robot call every SI column `_rad`.
            JointKind::Prismatic => {
                &[("m", std::convert::identity), ("mm", m_from_mm), ("rad", std::convert::identity)]
            }
            _ => &[("rad", std::convert::identity), ("deg", rad_from_deg)],
        };
        let found: Vec<Column> = units
            .iter()
            .flat_map(|&(unit, to_si)| {
                let wanted = format!("{}_{unit}", joint.name);
                let matching =
                    header.iter().enumerate().filter(move |(_, title)| **title == wanted);
                matching.map(move |(index, _)| Column { index, to_si }).collect::<Vec<_>>()
            })
            .collect();
        match found.as_slice() {
            [column] => columns.push(*column),
            [] => {
                let wanted = format!("{}_{}", joint.name, units[0].0);
                let hint = nearest(&wanted, header.iter().map(String::as_str))
                    .map_or_else(String::new, |near| format!("; did you mean '{near}' for it?"));
                fault(format!("no column '{wanted}' or '{}_{}'{hint}", joint.name, units[1].0));
            }
            _ => {
                fault(format!("joint '{}' has {} columns, must have one", joint.name, found.len()))
            }
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    Ok(Poses { table, columns, cells: Vec::new() })
}

impl<R: Read> Poses<R> {
    /// Reads the next pose into `q` (rad or m); `false` at the end.
    ///
    /// # Errors
    /// A row that is too short, a value that is not a finite number, bytes that are not UTF-8.
    pub fn read_into(&mut self, q: &mut Vec<f64>) -> Result<bool, Fault> {
        q.clear();
        if !self.table.row(&mut self.cells)? {
            return Ok(false);
        }
        for column in &self.columns {
            q.push((column.to_si)(self.table.number(&self.cells, column.index)?));
        }
        Ok(true)
    }

    /// The line of the pose that was read last, counted from 1.
    pub fn line(&self) -> usize {
        self.table.line()
    }
}

impl<R: Read> Iterator for Poses<R> {
    type Item = Result<Vec<f64>, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut q = Vec::with_capacity(self.columns.len());
        match self.read_into(&mut q) {
            Ok(true) => Some(Ok(q)),
            Ok(false) => None,
            Err(fault) => Some(Err(fault)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::robot::{load_robot, tests as two_link};
    use super::*;

    fn robot() -> Robot {
        let (_folder, path) = two_link::folder(two_link::YAML, two_link::URDF);
        load_robot(&path).unwrap().value
    }

    fn read(text: &[u8]) -> Result<Vec<Vec<f64>>, Vec<String>> {
        let robot = robot();
        let poses = load_poses(text, Path::new("p.csv"), &robot)
            .map_err(|faults| faults.iter().map(Fault::to_string).collect::<Vec<_>>())?;
        poses.collect::<Result<_, _>>().map_err(|fault: Fault| vec![fault.to_string()])
    }

    #[test]
    fn columns_come_in_any_order_and_unit() {
        let text = b"\xEF\xBB\xBF# from the cell\r\njoint_2_deg, id ,joint_1_rad\r\n90,a,0.5\r\n# pause\r\n-90,b,1e-1\r\n";
        let poses = read(text).unwrap();
        assert_eq!(poses[0][0], 0.5);
        assert!((poses[0][1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!((poses.len(), poses[1][0]), (2, 0.1));
    }

    #[test]
    fn faults_have_their_line() {
        for (text, told) in [
            (&b""[..], vec!["p.csv: is empty, must begin with a header"]),
            (
                b"joint_1_rad,joint2_rad\n",
                vec!["p.csv:1: no column 'joint_2_rad' or 'joint_2_deg'; did you mean 'joint"],
            ),
            (
                b"joint_1_rad,joint_1_deg,joint_2_rad\n",
                vec!["p.csv:1: joint 'joint_1' has 2 columns, must have one"],
            ),
            (
                b"joint_1_rad,joint_2_rad\n1,2\n1,nan\n",
                vec!["p.csv:3: joint_2_rad is 'nan', must be a finite number"],
            ),
            (
                b"joint_1_rad,joint_2_rad\n# c\n1\n",
                vec!["p.csv:3: joint_2_rad is empty, must be a finite number"],
            ),
            (b"joint_1_rad,joint_2_rad\n1,2\n1,\xFF\n", vec!["p.csv:3: is not UTF-8"]),
        ] {
            let faults = read(text).unwrap_err();
            assert_eq!(faults.len(), told.len(), "{faults:?}");
            for (fault, told) in faults.iter().zip(told) {
                assert!(fault.starts_with(told), "{fault}");
            }
        }
    }
}
