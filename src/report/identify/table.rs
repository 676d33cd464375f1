//! measured.csv: one row a pose, all digits, as `diagnose` reads it.

use super::pose_words;
use crate::identify::pose::{JointColumn, Pose};
use crate::identify::session::IdentifiedSession;
use crate::identify::{MeasuredRotation, ModeRow, ModeTable};
use crate::report::words::csv_field;

/// A title and the cells below it.
type Column = (String, Vec<String>);

/// A number of a row that may be absent.
type OfRow = fn(&ModeRow<Pose>) -> Option<f64>;

/// The session's table of modes. Modes that may be something else are named in comments only.
pub fn measured_csv(found: &IdentifiedSession) -> String {
    let table = found.table();
    let rows = &table.rows;
    let mut columns = pose_columns(rows, found.joint_columns.as_deref());
    columns.extend(mode_columns(&table));
    columns.extend(rotation_columns(&table));
    let optional: [(&str, OfRow); 4] = [
        ("temperature_c", |row| row.temperature_c),
        ("amplitude_nm", |row| row.amplitude_nm),
        ("payload_kg", |row| row.payload_kg),
        ("sample_rate_hz", |row| row.sample_rate_hz),
    ];
    for (title, of) in optional {
        if rows.iter().any(|row| of(row).is_some()) {
            columns.push((title.to_owned(), rows.iter().map(|row| cell(of(row))).collect()));
        }
    }
    let mut links: Vec<&str> = Vec::new();
    for (link, _) in rows.iter().flat_map(|row| &row.added_kg) {
        if !links.contains(&link.as_str()) {
            links.push(link);
        }
    }
    for link in links {
        let own =
            |row: &ModeRow<Pose>| row.added_kg.iter().find(|(l, _)| l == link).map(|(_, m)| *m);
        columns.push((format!("mass_{link}_kg"), rows.iter().map(|row| cell(own(row))).collect()));
    }
    if rows.iter().any(|row| row.id.is_some()) {
        let ids = rows.iter().map(|row| csv_field(row.id.as_deref().unwrap_or(""))).collect();
        columns.push(("id".to_owned(), ids));
    }
    let mut out = comments(found);
    let titles: Vec<&str> = columns.iter().map(|(title, _)| title.as_str()).collect();
    out.push_str(&titles.join(","));
    out.push('\n');
    for row in 0..rows.len() {
        let cells: Vec<&str> = columns.iter().map(|(_, cells)| cells[row].as_str()).collect();
        out.push_str(&cells.join(","));
        out.push('\n');
    }
    out
}

fn comments(found: &IdentifiedSession) -> String {
    let mut out = String::from("# Identified modes; blank: not measured\n");
    let by_joints = found.poses.iter().any(|at| matches!(at.pose, Pose::Joints(_)));
    if found.joint_columns.is_none() && by_joints {
        out.push_str(
            "# joint_1, joint_2, … from base to tip: name them by joint_names in the session\n",
        );
    }
    for at in &found.poses {
        for mode in &at.modes {
            if let Some(code) = mode.suspicion {
                let pose = pose_words(&at.pose, found.joint_columns.as_deref());
                let f = mode.frequency_hz;
                out.push_str(&format!("# left out at {pose}: {f} Hz ({code})\n"));
            }
        }
    }
    out
}

fn cell(value: Option<f64>) -> String {
    value.map_or_else(String::new, |v| v.to_string())
}

fn pose_columns(rows: &[ModeRow<Pose>], named: Option<&[JointColumn]>) -> Vec<Column> {
    let cells = |of: &dyn Fn(&Pose) -> Option<f64>| -> Vec<String> {
        rows.iter().map(|row| cell(of(&row.pose))).collect()
    };
    let joints = rows.iter().map(|row| match &row.pose {
        Pose::Joints(joints) => joints.len(),
        Pose::Angles { .. } => 0,
    });
    let joints = joints.max().unwrap_or(0);
    if joints == 0 {
        let angles = |pose: &Pose| match pose {
            Pose::Angles { beta1, beta2 } => (*beta1, Some(*beta2)),
            Pose::Joints(_) => (None, None),
        };
        let beta1 = rows
            .iter()
            .any(|row| angles(&row.pose).0.is_some())
            .then(|| ("beta1_rad".to_owned(), cells(&|pose| angles(pose).0)));
        let beta2 = ("beta2_rad".to_owned(), cells(&|pose| angles(pose).1));
        return beta1.into_iter().chain([beta2]).collect();
    }
    JointColumn::list(named, joints)
        .into_iter()
        .enumerate()
        .map(|(joint, column)| {
            let of = |pose: &Pose| match pose {
                Pose::Joints(joints) => joints.get(joint).map(|&si| column.in_unit(si)),
                Pose::Angles { .. } => None,
            };
            let cells = cells(&of);
            (column.title, cells)
        })
        .collect()
}

fn mode_columns(table: &ModeTable<Pose>) -> Vec<Column> {
    let column = |of: &dyn Fn(&ModeRow<Pose>) -> Option<f64>| -> Vec<String> {
        table.rows.iter().map(|row| cell(of(row))).collect()
    };
    (0..table.modes)
        .flat_map(|mode| {
            let n = mode + 1;
            [
                (format!("f{n}_hz"), column(&|row| row.frequencies_hz[mode])),
                (format!("f{n}_std_hz"), column(&|row| row.deviations_hz[mode])),
                (format!("zeta{n}"), column(&|row| row.damping_ratios[mode])),
            ]
        })
        .collect()
}

/// How links turn in each mode, where points were marked on them.
fn rotation_columns(table: &ModeTable<Pose>) -> Vec<Column> {
    let mut columns = Vec::new();
    for mode in 0..table.modes {
        let of_mode = |row: &'_ ModeRow<Pose>| row.rotations.get(mode).cloned().unwrap_or_default();
        let mut links: Vec<String> = Vec::new();
        for rotation in table.rows.iter().flat_map(of_mode) {
            if !links.contains(&rotation.link) {
                links.push(rotation.link);
            }
        }
        for link in links {
            let column = |of: fn(&MeasuredRotation) -> Option<f64>| -> Vec<String> {
                let own = |row| of_mode(row).iter().find(|r| r.link == link).and_then(of);
                table.rows.iter().map(|row| cell(own(row))).collect()
            };
            let title = format!("phi{}_{link}", mode + 1);
            columns.push((title.clone(), column(|rotation| Some(rotation.value))));
            columns.push((format!("{title}_std"), column(|rotation| rotation.std)));
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::record::Conditions;
    use crate::identify::session::{PoseMode, PoseModes};
    use crate::notes::Code;

    fn mode(frequency_hz: f64, number: usize, suspicion: Option<Code>) -> PoseMode {
        PoseMode {
            frequency_hz,
            frequency_std_hz: 0.01,
            damping_ratio: 0.02,
            damping_std: 0.001,
            members: Vec::new(),
            number: Some(number).filter(|_| suspicion.is_none()),
            shape: Vec::new(),
            suspicion,
        }
    }

    #[test]
    fn the_table_has_the_contract_s_columns() {
        let row = |pose, modes, temperature_c| PoseModes {
            pose,
            conditions: Conditions { temperature_c, ..Conditions::default() },
            id: Some("a,1".into()),
            sample_rate_hz: Some(140.0),
            modes,
        };
        let angles = |beta2| Pose::Angles { beta1: None, beta2 };
        let mut found = IdentifiedSession {
            poses: vec![
                row(angles(1.571), vec![mode(23.0, 1, None), mode(39.4, 2, None)], Some(21.5)),
                row(angles(0.5), vec![mode(20.0, 1, None), mode(40.0, 2, Some(Code::Mains))], None),
            ],
            records: Vec::new(),
            joint_columns: None,
            warnings: Vec::new(),
        };
        assert_eq!(
            measured_csv(&found),
            "# Identified modes; blank: not measured\n\
             # left out at beta2 0.5 rad: 40 Hz (mains)\n\
             beta2_rad,f1_hz,f1_std_hz,zeta1,f2_hz,f2_std_hz,zeta2,\
             temperature_c,sample_rate_hz,id\n\
             1.571,23,0.01,0.02,39.4,0.01,0.02,21.5,140,\"a,1\"\n\
             0.5,20,0.01,0.02,,,,,140,\"a,1\"\n"
        );
        found.poses.truncate(1);
        let joints = |values: [f64; 2], names: [&str; 2]| {
            let columns = names.map(JointColumn::of);
            let si = |i: usize| columns[i].si_from_degrees_or_mm(values[i]);
            (Pose::Joints(vec![si(0), si(1)]), Some(columns.to_vec()))
        };
        (found.poses[0].pose, found.joint_columns) = joints([10.0, -20.1], ["rail_mm", "joint_2"]);
        let text = measured_csv(&found);
        assert!(text.contains("\nrail_mm,joint_2_deg,f1_hz,"), "{text}");
        assert!(text.contains("\n10,-20.1,23,"), "{text}");
        (found.poses[0].pose, found.joint_columns) = joints([180.0, 500.0], ["a_rad", "rail_m"]);
        let text = measured_csv(&found);
        assert!(text.contains("\n3.141592653589793,0.5,23,"), "{text}");
        found.joint_columns = None;
        assert!(measured_csv(&found).contains("\njoint_1_deg,joint_2_deg,f1_hz,"));
    }
}
