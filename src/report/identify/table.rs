//! measured.csv: one row a pose, all digits, as `diagnose` reads it.

use super::pose_words;
use crate::identify::record::Pose;
use crate::identify::session::{IdentifiedSession, PoseMode, PoseRow};
use crate::units::{m_from_mm, rad_from_deg};

/// A number of a row that may be absent.
type OfRow = fn(&PoseRow) -> Option<f64>;

/// The table of identified modes. `joint_names` names the joints of poses by joints; a name that ends in
/// `_mm`, `_m`, `_deg` or `_rad` is the column's title as it is and sets its unit, any other gets `_deg`. Modes that are likely no
/// modes of the arm stay out, and a comment says so.
pub fn measured_csv(found: &IdentifiedSession, joint_names: Option<&[String]>) -> String {
    let rows = &found.rows;
    let modes: Vec<Vec<&PoseMode>> = rows
        .iter()
        .map(|row| row.modes.iter().filter(|mode| mode.suspicion.is_none()).collect())
        .collect();
    let most = modes.iter().map(Vec::len).max().unwrap_or(0);
    let mut out = String::from("# Identified modes; blank: not measured\n");
    if joint_names.is_none() && rows.iter().any(|row| matches!(row.pose, Pose::JointsDeg(_))) {
        out.push_str(
            "# joint_1, joint_2, … from base to tip: name them by joint_names in the session\n",
        );
    }
    for row in rows {
        for mode in &row.modes {
            if let Some(kind) = mode.suspicion {
                let (pose, f) = (pose_words(&row.pose), mode.frequency_hz);
                out.push_str(&format!("# left out at {pose}: {f} Hz ({})\n", kind.code()));
            }
        }
    }
    let has = |of: &dyn Fn(&PoseRow) -> bool| rows.iter().any(of);
    let mut columns: Vec<(String, Vec<String>)> = Vec::new();
    columns.extend(pose_columns(rows, joint_names));
    for mode in 0..most {
        let column = |of: &dyn Fn(&PoseMode) -> f64| -> Vec<String> {
            modes
                .iter()
                .map(|row| row.get(mode).map_or_else(String::new, |m| of(m).to_string()))
                .collect()
        };
        let n = mode + 1;
        columns.push((format!("f{n}_hz"), column(&|m| m.frequency_hz)));
        columns.push((format!("f{n}_std_hz"), column(&|m| m.frequency_std_hz)));
        columns.push((format!("zeta{n}"), column(&|m| m.damping_ratio)));
    }
    let number = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    let optional: [(&str, OfRow); 4] = [
        ("temperature_c", |row| row.conditions.temperature_c),
        ("amplitude_nm", |row| row.conditions.amplitude_nm),
        ("payload_kg", |row| row.conditions.payload_kg),
        ("sample_rate_hz", |row| row.sample_rate_hz),
    ];
    for (title, of) in optional {
        if has(&|row| of(row).is_some()) {
            columns.push((title.to_owned(), rows.iter().map(|row| number(of(row))).collect()));
        }
    }
    if has(&|row| row.id.is_some()) {
        let ids = rows.iter().map(|row| quoted(row.id.as_deref().unwrap_or(""))).collect();
        columns.push(("id".to_owned(), ids));
    }
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

fn pose_columns(rows: &[PoseRow], joint_names: Option<&[String]>) -> Vec<(String, Vec<String>)> {
    let cells = |of: &dyn Fn(&Pose) -> Option<f64>| -> Vec<String> {
        rows.iter().map(|row| of(&row.pose).map_or_else(String::new, |v| v.to_string())).collect()
    };
    let joints = rows
        .iter()
        .map(|row| match &row.pose {
            Pose::JointsDeg(joints) => joints.len(),
            Pose::Beta2Rad(_) => 0,
        })
        .max()
        .unwrap_or(0);
    if joints == 0 {
        let beta2 = |pose: &Pose| match pose {
            Pose::Beta2Rad(beta2) => Some(*beta2),
            Pose::JointsDeg(_) => None,
        };
        return vec![("beta2_rad".to_owned(), cells(&beta2))];
    }
    (0..joints)
        .map(|joint| {
            let title = match joint_names.and_then(|names| names.get(joint)) {
                Some(name)
                    if ["_mm", "_m", "_deg", "_rad"].iter().any(|end| name.ends_with(end)) =>
                {
                    name.clone()
                }
                Some(name) => format!("{name}_deg"),
                None => format!("joint_{}_deg", joint + 1),
            };
            let of = |pose: &Pose| match pose {
                Pose::JointsDeg(joints) => joints.get(joint).map(|value| in_unit(&title, *value)),
                Pose::Beta2Rad(_) => None,
            };
            let cells = cells(&of);
            (title, cells)
        })
        .collect()
}

/// A joint's degrees or millimetres in the unit that its column's title ends in.
fn in_unit(title: &str, value: f64) -> f64 {
    if title.ends_with("_rad") {
        rad_from_deg(value)
    } else if title.ends_with("_m") {
        m_from_mm(value)
    } else {
        value
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"']) || text.starts_with('#') {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::notice::NoticeKind;
    use crate::identify::record::Conditions;

    fn mode(frequency_hz: f64, suspicion: Option<NoticeKind>) -> PoseMode {
        PoseMode {
            frequency_hz,
            frequency_std_hz: 0.01,
            damping_ratio: 0.02,
            damping_std: 0.001,
            members: Vec::new(),
            suspicion,
        }
    }

    #[test]
    fn the_table_has_the_contract_s_columns() {
        let row = |pose, modes, temperature_c| PoseRow {
            pose,
            conditions: Conditions { temperature_c, ..Conditions::default() },
            id: Some("a,1".into()),
            sample_rate_hz: Some(140.0),
            modes,
        };
        let mut found = IdentifiedSession {
            rows: vec![
                row(Pose::Beta2Rad(1.571), vec![mode(23.0, None), mode(39.4, None)], Some(21.5)),
                row(
                    Pose::Beta2Rad(0.5),
                    vec![mode(20.0, None), mode(40.0, Some(NoticeKind::Mains))],
                    None,
                ),
            ],
            records: Vec::new(),
            notices: Vec::new(),
        };
        assert_eq!(
            measured_csv(&found, None),
            "# Identified modes; blank: not measured\n\
             # left out at beta2 0.5 rad: 40 Hz (mains)\n\
             beta2_rad,f1_hz,f1_std_hz,zeta1,f2_hz,f2_std_hz,zeta2,temperature_c,sample_rate_hz,id\n\
             1.571,23,0.01,0.02,39.4,0.01,0.02,21.5,140,\"a,1\"\n\
             0.5,20,0.01,0.02,,,,,140,\"a,1\"\n"
        );
        found.rows.truncate(1);
        found.rows[0].pose = Pose::JointsDeg(vec![10.0, -20.0]);
        let names = ["rail_mm".to_owned(), "joint_2".to_owned()];
        assert!(measured_csv(&found, Some(&names)).contains("\nrail_mm,joint_2_deg,f1_hz,"));
        assert!(measured_csv(&found, None).contains("\njoint_1_deg,joint_2_deg,f1_hz,"));
        found.rows[0].pose = Pose::JointsDeg(vec![180.0, 500.0]);
        let names = ["a_rad".to_owned(), "rail_m".to_owned()];
        let text = measured_csv(&found, Some(&names));
        assert!(text.contains("\n3.141592653589793,0.5,23,"), "{text}");
    }
}
