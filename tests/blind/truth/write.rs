//! Files as a user would have them.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::arm::{Arm, BASE, Body, Kind, TIP};
use super::world::Row;

/// Writes robot.yaml and robot.urdf into a folder.
pub(crate) fn robot(arm: &Arm, folder: &Path) {
    fs::write(folder.join("robot.urdf"), urdf(arm)).unwrap();
    fs::write(folder.join("robot.yaml"), yaml(arm)).unwrap();
}

/// States in robot.yaml how well its numbers are known: one standard deviation of ln of springs and of
/// links; drives are exact.
pub(crate) fn deviations(arm: &Arm, folder: &Path, of_springs: f64, of_links: f64) {
    let file = folder.join("robot.yaml");
    let mut text = fs::read_to_string(&file).unwrap();
    for joint in &arm.joints {
        let k = joint.stiffness_nm_per_rad;
        for (stated, std) in [
            (format!("{}: {{stiffness_nm_per_rad: {k}", joint.name), of_springs),
            (format!("{}: {{reflected_inertia_kgm2: {}", joint.name, joint.drive_kgm2), 0.0),
        ] {
            text = text.replace(&stated, &format!("{stated}, std_percent: {}", 100.0 * std));
        }
    }
    text += "inertials:\n";
    for joint in &arm.joints {
        text += &format!("  {}: {{std_percent: {}}}\n", joint.link, 100.0 * of_links);
    }
    fs::write(file, text).unwrap();
}

fn triple(v: &Vector3<f64>) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

fn list(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

fn link(name: &str, body: &Body) -> String {
    let i = &body.inertia_kgm2;
    format!(
        "  <link name=\"{name}\">\n    <inertial>\n      <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n      \
         <mass value=\"{}\"/>\n      <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" \
         izz=\"{}\"/>\n    </inertial>\n  </link>\n",
        triple(&body.com_m),
        body.mass_kg,
        i[(0, 0)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 1)],
        i[(1, 2)],
        i[(2, 2)]
    )
}

fn urdf(arm: &Arm) -> String {
    let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", arm.name);
    text += &link(BASE, &arm.base);
    let mut parent = BASE;
    for joint in &arm.joints {
        text += &link(&joint.link, &joint.body);
        let [lower, upper] = joint.limits_rad;
        let _ = write!(
            text,
            "  <joint name=\"{}\" type=\"revolute\">\n    <parent link=\"{parent}\"/>\n    \
             <child link=\"{}\"/>\n    <origin xyz=\"{}\" rpy=\"{}\"/>\n    <axis xyz=\"{}\"/>\n    \
             <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"1000\" velocity=\"3\"/>\n  </joint>\n",
            joint.name,
            joint.link,
            triple(&joint.origin_m),
            triple(&joint.rpy_rad),
            triple(&joint.axis),
        );
        parent = &joint.link;
    }
    let _ = write!(
        text,
        "  <link name=\"{TIP}\"/>\n  <joint name=\"{TIP}_fixed\" type=\"fixed\">\n    \
         <parent link=\"{parent}\"/>\n    <child link=\"{TIP}\"/>\n    \
         <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n  </joint>\n</robot>\n",
        triple(&arm.tip_m)
    );
    text
}

fn tensor(i: &Matrix3<f64>) -> String {
    format!(
        "{{ixx: {}, iyy: {}, izz: {}, ixy: {}, ixz: {}, iyz: {}}}",
        i[(0, 0)],
        i[(1, 1)],
        i[(2, 2)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 2)]
    )
}

fn yaml(arm: &Arm) -> String {
    let mut text = format!(
        "name: {}\nurdf: robot.urdf\nbase: {BASE}\ntip: {TIP}\nelasticity:\n  damping_ratio: 0.02\n",
        arm.name
    );
    if arm.gravity_stiffness {
        text += "  gravity: true\n";
    }
    text += "  joints:\n";
    for joint in &arm.joints {
        let k = joint.stiffness_nm_per_rad;
        let _ = writeln!(text, "    {}: {{stiffness_nm_per_rad: {k}}}", joint.name);
    }
    if !arm.extras.is_empty() {
        text += "  extra:\n";
    }
    for extra in &arm.extras {
        let kind = match extra.kind {
            Kind::Rotation => "rotation",
            Kind::Translation => "translation",
        };
        let _ = writeln!(
            text,
            "    - {{name: {}, link: {}, kind: {kind}, axis: {}, origin_m: {}, stiffness: {}}}",
            extra.name,
            arm.link_name(extra.link),
            list(&extra.axis),
            list(&extra.origin_m),
            extra.stiffness
        );
    }
    if arm.joints.iter().any(|joint| joint.drive_kgm2 > 0.0) {
        text += "drives:\n";
        for joint in &arm.joints {
            let inertia = joint.drive_kgm2;
            let _ = writeln!(text, "  {}: {{reflected_inertia_kgm2: {inertia}}}", joint.name);
        }
    }
    if tells_beta2(arm) {
        text += "arm_angles:\n  beta1: {terms: {joint_1: 1.0}, offset_rad: 0.0}\n  \
                 beta2: {terms: {joint_2: 1.0}, offset_rad: 0.0}\n";
    }
    if let Some(payload) = &arm.payload {
        let _ = writeln!(
            text,
            "payload: {{link: {TIP}, mass_kg: {}, com_m: {}, inertia_kgm2: {}}}",
            payload.mass_kg,
            list(&payload.com_m),
            tensor(&payload.inertia_kgm2)
        );
    }
    text
}

/// Whether the angle between two links tells the pose.
fn tells_beta2(arm: &Arm) -> bool {
    arm.planar && arm.joints.len() == 2
}

/// Which circumstances the experimenter wrote down.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Columns {
    pub(crate) temperature: bool,
    pub(crate) amplitude: bool,
    pub(crate) payload: bool,
    /// Relative standard deviation of every frequency, as an experimenter believes it.
    pub(crate) deviations: Option<f64>,
    pub(crate) sample_rate_hz: Option<f64>,
}

/// A table of measured frequencies: poses, then modes rounded to 0.05 Hz already, then circumstances.
pub(crate) fn table(
    arm: &Arm,
    rows: &[Row],
    measured_hz: &[Vec<Option<f64>>],
    columns: Columns,
) -> String {
    let modes = measured_hz.first().map_or(0, Vec::len);
    let as_beta2 = tells_beta2(arm) && rows.iter().all(|row| row.joints_rad[0] == 0.0);
    let mut head: Vec<String> = arm.joints.iter().map(|j| format!("{}_rad", j.name)).collect();
    if as_beta2 {
        head = vec!["beta1_rad".to_owned(), "beta2_rad".to_owned()];
    }
    head.extend((1..=modes).map(|r| format!("f{r}_hz")));
    let flags = [
        (columns.temperature, "temperature_c"),
        (columns.amplitude, "amplitude_nm"),
        (columns.payload, "payload_kg"),
        (columns.sample_rate_hz.is_some(), "sample_rate_hz"),
    ];
    head.extend(flags.iter().filter(|(on, _)| *on).map(|(_, name)| (*name).to_owned()));
    if columns.deviations.is_some() {
        head.extend((1..=modes).map(|r| format!("f{r}_std_hz")));
    }
    let mut text = head.join(",") + "\n";
    for (row, measured) in rows.iter().zip(measured_hz) {
        let mut cells: Vec<String> = row.joints_rad.iter().map(|q| format!("{q:.6}")).collect();
        cells.extend(measured.iter().map(|f| f.map_or(String::new(), |f| format!("{f:.2}"))));
        if columns.temperature {
            cells.push(format!("{:.1}", row.temperature_c));
        }
        if columns.amplitude {
            cells.push(format!("{:.2}", row.amplitude_nm));
        }
        if columns.payload {
            cells.push(format!("{}", row.payload_kg));
        }
        cells.extend(columns.sample_rate_hz.map(|rate| format!("{rate}")));
        if let Some(noise) = columns.deviations {
            let deviation =
                |f: &Option<f64>| f.map_or(String::new(), |f| format!("{:.3}", f * noise));
            cells.extend(measured.iter().map(deviation));
        }
        text += &(cells.join(",") + "\n");
    }
    text
}
