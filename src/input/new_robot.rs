//! A URDF → the first robot.yaml and job.yaml for it.

use std::path::Path;

use super::Reading;
use super::urdf::read_urdf;
use crate::formats::yaml::splice::quoted;
use crate::model::{Joint, Link};
use crate::notes::{Note, Notes, Place};

/// What a URDF holds.
#[derive(Debug, Clone, PartialEq)]
pub struct UrdfParts {
    /// Its name, where it has one.
    pub name: Option<String>,
    /// Its links.
    pub links: Vec<Link>,
    /// Its joints.
    pub joints: Vec<Joint>,
}

/// Reads a URDF by itself.
///
/// # Errors
/// Every fault of the file with its line.
pub fn read_urdf_alone(path: &Path, reading: &mut Reading) -> Result<UrdfParts, Vec<Note>> {
    reading.files.push(path.to_owned());
    let mut notes = Notes::about(Place::file(path));
    let urdf = read_urdf(path, &mut notes);
    let errors = reading.settle(notes);
    match urdf {
        Some(urdf) if errors.is_empty() => {
            Ok(UrdfParts { name: urdf.name, links: urdf.links, joints: urdf.joints })
        }
        _ => Err(errors),
    }
}

/// What a first robot.yaml says.
#[derive(Debug, Clone, PartialEq)]
pub struct NewRobot {
    /// What the robot is called.
    pub name: String,
    /// The URDF, as robot.yaml names it.
    pub urdf: String,
    /// The link that the tool is fixed to, where one hangs fixed behind the last joint.
    pub tip: Option<String>,
    /// Springs of the joints that turn, base to tip.
    pub springs: Vec<GuessedSpring>,
    /// Joints that slide, for which there is no typical figure.
    pub sliding: Vec<String>,
    /// Joints that turn and have nothing with a mass behind them.
    pub massless: Vec<String>,
    /// Mass of the whole arm, kg, where the URDF gives none.
    pub total_mass_kg: Option<f64>,
    /// The joints of β1 and β2 with their factors and offsets, rad, where the arm has such.
    pub arm_angles: Option<[(String, f64, f64); 2]>,
}

/// A spring that is to be replaced by the user's own.
#[derive(Debug, Clone, PartialEq)]
pub struct GuessedSpring {
    /// The joint.
    pub joint: String,
    /// N·m/rad.
    pub stiffness: f64,
    /// One standard deviation of its logarithm, %.
    pub std_percent: f64,
    /// Where the guess comes from.
    pub source: String,
}

impl GuessedSpring {
    /// Whether another joint's spring is the same guess.
    pub fn is_same_guess(&self, other: &Self) -> bool {
        self.stiffness == other.stiffness && self.source == other.source
    }
}

/// The text of a first robot.yaml.
pub fn new_robot_text(robot: &NewRobot) -> String {
    let mut text = format!(
        "# Springs with assumed: true are guesses from arms of similar size. As long as one\n\
         # remains, no verdict is better than uncertain: enter your own values (data sheet, load\n\
         # test, detune diagnose) and delete assumed: true.\n\
         name: {}\nurdf: {}\n",
        quoted(&robot.name),
        quoted(&robot.urdf)
    );
    if let Some(tip) = &robot.tip {
        text += &format!(
            "# The frame of tcp and payload; on most arms its z points from flange to tool.\n\
             tip: {}\n",
            quoted(tip)
        );
    }
    text += "elasticity:\n  damping_ratio: 0.02  # assumed\n  joints:\n";
    for GuessedSpring { joint, stiffness, std_percent, source } in &robot.springs {
        text += &format!(
            "    {}:\n      stiffness_nm_per_rad: {stiffness}\n      \
             std_percent: {std_percent}\n      assumed: true\n      source: {}\n",
            quoted(joint),
            quoted(source)
        );
    }
    for joint in &robot.sliding {
        text += &format!(
            "    # {}: slides; give it stiffness_n_per_m, or name it in elasticity.rigid\n",
            joint.replace(char::is_control, " ")
        );
    }
    for joint in &robot.massless {
        text += &format!(
            "    # {}: nothing behind it has a mass in the URDF, so that it is rigid here; give a \
             link\n    # behind it one under inertials, then this joint its stiffness_nm_per_rad\n",
            joint.replace(char::is_control, " ")
        );
    }
    if let Some(total_kg) = robot.total_mass_kg {
        text += &format!(
            "# Distributed over the links by their shapes; inertials by link are better.\n\
             total_mass_kg: {total_kg}\n"
        );
    }
    if let Some(angles) = &robot.arm_angles {
        text += "# Guessed from the first two joints with level, parallel axes: beta1 is the \
                 upper arm\n# above the horizon, beta2 the forearm against the upper arm.\n\
                 arm_angles:\n";
        for (name, (joint, factor, offset_rad)) in ["beta1", "beta2"].iter().zip(angles) {
            text += &format!(
                "  {name}: {{terms: {{{}: {factor:.1}}}, offset_rad: {offset_rad}}}\n",
                quoted(joint)
            );
        }
    }
    text
}

/// The text of a first job.yaml: a short motion from `start` to `end`, degrees (mm of joints that
/// slide).
pub fn new_job_text(robot: &str, start: &[f64], end: &[f64]) -> String {
    format!(
        "name: First job\nrobot: {}\ntool: {{teeth: 2, diameter_mm: 10}}  # yours\n\
         # What the arm carries, spindle and tool; until it is stated, verdicts\n\
         # are uncertain at best:\n\
         # payload: {{mass_kg: 8, com_m: [0, 0, 0.1]}}\n\
         tcp: {{xyz_m: [0, 0, 0.15]}}  # tool centre point in the frame of the tip\n\
         spindle: {{min_rpm: 1000, max_rpm: 24000}}  # yours\n\
         operations:\n  - name: first\n    spindle_rpm: 6000\n    feed_mm_per_min: 600\n    \
         path:\n      # A small motion in the middle of the joints' limits. Yours: joints_deg, \
         poses, or\n      # program: {{file: part.mod}}\n      joints_deg:\n        \
         - {start:?}\n        - {end:?}\n",
        quoted(robot)
    )
}
