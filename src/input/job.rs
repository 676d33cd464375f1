//! job.yaml → a job.

mod carried;
mod operations;
mod speeds;
mod stretches;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use self::carried::Carriers;
use super::files::{MAX_FILE_BYTES, named_file};
use super::raw::job as raw;
use super::robot::read_described_robot;
use super::waypoints::FromPrograms;
use super::{Reading, schema};
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, Step, document};
use crate::job::{Job, Levers, Operation, Policy, Spindle, Tool};
use crate::model::Robot;
use crate::notes::{Code, Note, Notes, Place};
use crate::units::{m_from_mm, m_per_n_from_um_per_n, rad_from_deg, ratio_from_percent};

const DEFAULT_TOOTH_PASSING_HARMONICS: u32 = 2;

/// Reads a job.yaml and the robot that it names.
///
/// # Errors
/// Every fault of the job and of its robot's files, each with its line: the job's come first.
pub fn read_job(path: &Path, reading: &mut Reading) -> Result<Job, Vec<Note>> {
    reading.files.push(path.to_owned());
    let text = read_text(path, MAX_FILE_BYTES)?;
    job_of_text(path, text, reading)
}

/// The job that `text` would be if it stood in the file `path`.
pub(super) fn job_of_text(
    path: &Path,
    text: String,
    reading: &mut Reading,
) -> Result<Job, Vec<Note>> {
    let mut notes = Notes::about(Place::file(path));
    let Some((tree, raw)) = document::<raw::Job>(&text, &schema::of::<raw::Job>(), &mut notes)
    else {
        return Err(reading.settle(notes));
    };
    drop(text);
    let robot_file = raw.robot.as_deref().and_then(|name| {
        let line = tree.line_at(&[Step::Key("robot")]);
        named_file(path, "robot", name, line, &mut notes)
    });
    let mut of_robot = Reading::default();
    let read = robot_file.map(|file| read_described_robot(&file, &mut of_robot));
    let (described, robot_faults) = match read {
        Some(Ok(described)) => (Some(described), Vec::new()),
        Some(Err(robot_faults)) => (None, robot_faults),
        None => (None, Vec::new()),
    };
    let robot = described.as_ref().map(|described| Arc::new(described.robot.clone()));
    let carriers = described.as_ref().zip(robot.clone());
    let mut reader = Reader {
        path,
        tree: &tree,
        raw: &raw,
        robot: robot.as_deref(),
        carriers: carriers.map(|(described, own)| Carriers::new(described, own)),
        tools: BTreeMap::new(),
        notes,
        programs: FromPrograms {
            reading: Reading { pending: reading.pending.take(), ..Reading::default() },
            ..FromPrograms::default()
        },
    };
    let parts = reader.parts();
    let Reader { notes, programs, .. } = reader;
    let mut errors = reading.settle(notes);
    reading.append(programs.reading);
    reading.append(of_robot);
    match (robot, parts) {
        (Some(robot), Some((spindle, operations, policy, levers)))
            if errors.is_empty() && robot_faults.is_empty() && programs.errors.is_empty() =>
        {
            let file_name = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            Ok(Job {
                name: raw.name.clone().unwrap_or_else(file_name),
                file: path.to_owned(),
                robot,
                spindle,
                operations,
                policy,
                levers,
            })
        }
        _ => {
            errors.extend(programs.errors);
            errors.extend(robot_faults);
            Err(errors)
        }
    }
}

/// What is at hand while a job is read.
struct Reader<'j> {
    path: &'j Path,
    tree: &'j Node,
    raw: &'j raw::Job,
    /// `None` where the robot has faults.
    robot: Option<&'j Robot>,
    carriers: Option<Carriers<'j>>,
    /// The cutters by the program's number, each with the key that it stands under.
    tools: BTreeMap<u32, (&'j str, Tool)>,
    notes: Notes,
    /// What the programs say that the job names.
    programs: FromPrograms,
}

impl<'j> Reader<'j> {
    fn error(&mut self, code: Code, steps: &[Step<'_>], what: impl Into<String>) {
        let line = self.tree.line_at(steps);
        self.notes.error(code, line, what);
    }

    /// Everything but the robot. `None` where a required part is missing, which was reported
    /// before.
    fn parts(&mut self) -> Option<(Spindle, Vec<Operation>, Policy, Levers)> {
        let raw = self.raw;
        if raw.tool.is_none() && raw.tools.is_none() && self.tree.get("tool").is_none() {
            self.error(Code::MissingKey, &[], "missing key 'tool' (or 'tools')");
        }
        let tool = raw.tool.as_ref().and_then(|raw| self.tool(raw, "tool", &[Step::Key("tool")]));
        self.numbered_tools();
        let spindle = self.spindle();
        let policy = self.policy();
        let operations = self.operations(tool.as_ref(), spindle.as_ref());
        let levers = self.levers(operations.as_deref().unwrap_or_default());
        let operations = operations?;
        if operations.iter().any(|operation| !operation.carried.is_known()) {
            let what = "what the arm carries is stated nowhere, so the model carries nothing and \
                        the verdict is at best uncertain: write payload: {mass_kg: …, com_m: […]} \
                        or payload: none in the job";
            self.notes.warning(Code::PayloadUnknown, None, what);
        }
        Some((spindle?, operations, policy, levers))
    }

    fn numbered_tools(&mut self) {
        let raw = self.raw;
        for (key, raw) in raw.tools.iter().flatten() {
            let steps = [Step::Key("tools"), Step::Key(key)];
            let tool = self.tool(raw, &format!("tools.{key}"), &steps);
            match (key.parse(), tool) {
                (Ok(number), Some(tool)) => {
                    self.tools.insert(number, (key, tool));
                }
                (Ok(_), None) => {}
                (Err(_), _) => {
                    let what = format!(
                        "tools has the key '{key}', must be the number of a tool in the program"
                    );
                    self.error(Code::Value, &steps, what);
                }
            }
        }
    }

    /// What may be changed besides speed and feed.
    fn levers(&mut self, operations: &[Operation]) -> Levers {
        let raw = self.raw;
        let tools_on_hand =
            raw.tools_on_hand.iter().flatten().enumerate().filter_map(|(i, tool)| {
                let steps = [Step::Key("tools_on_hand"), Step::Index(i)];
                if tool.payload.is_some() {
                    let what = format!("tools_on_hand[{i}].payload has no effect");
                    self.notes.warning(Code::Unused, self.tree.line_at(&steps), what);
                }
                self.tool(tool, &format!("tools_on_hand[{i}]"), &steps)
            });
        let tools_on_hand = tools_on_hand.collect();
        let work_object_shift_m = raw.work_object_shift.as_ref().map(|shift| {
            let axes = [("x_m", shift.x_m), ("y_m", shift.y_m), ("z_m", shift.z_m)];
            axes.map(|(key, range)| {
                let steps = [Step::Key("work_object_shift"), Step::Key(key)];
                self.ascending(
                    range.unwrap_or_default(),
                    &format!("work_object_shift.{key}"),
                    &steps,
                )
            })
        });
        let entries = raw.operations.iter().flatten().enumerate();
        let free_axis_rad = entries.map(|(i, operation)| {
            let steps = [Step::Key("operations"), Step::Index(i), Step::Key("free_axis_deg")];
            let name = operation.name.as_deref().unwrap_or_default();
            let what = format!("operation '{name}': free_axis_deg");
            let range = self.ascending(operation.free_axis_deg?, &what, &steps);
            Some(range.map(rad_from_deg))
        });
        let of_entries: Vec<Option<[f64; 2]>> = free_axis_rad.collect();
        let free_axis_rad =
            operations.iter().map(|each| of_entries.get(each.entry).copied().flatten()).collect();
        Levers { free_axis_rad, tools_on_hand, work_object_shift_m }
    }

    fn ascending(&mut self, range: [f64; 2], what: &str, steps: &[Step<'_>]) -> [f64; 2] {
        let [from, to] = range;
        if from > to {
            self.error(Code::Value, steps, format!("{what} is [{from}, {to}], must be ascending"));
        }
        range
    }

    /// A cutter; `what` names it in messages and `at` is where it stands.
    fn tool(&mut self, raw: &raw::Tool, what: &str, at: &[Step<'_>]) -> Option<Tool> {
        let mut steps = at.to_vec();
        steps.push(Step::Key("pitch_deg"));
        if let (Some(pitch), Some(teeth)) = (&raw.pitch_deg, raw.teeth) {
            if pitch.len() != teeth as usize {
                let what = format!(
                    "{what}.pitch_deg has {} angles, must have one for each of the {teeth} teeth",
                    pitch.len()
                );
                self.error(Code::Conflict, &steps, what);
            }
            let sum: f64 = pitch.iter().sum();
            // Pitches are written with a few digits.
            if (sum - 360.0).abs() > 1e-3 {
                self.error(
                    Code::Value,
                    &steps,
                    format!("{what}.pitch_deg adds up to {sum}, must be 360"),
                );
            }
        }
        Some(Tool {
            name: raw.name.clone(),
            teeth: raw.teeth?,
            diameter_m: raw.diameter_mm.map(m_from_mm),
            pitch_rad: raw
                .pitch_deg
                .as_ref()
                .map(|pitch| pitch.iter().map(|&angle| rad_from_deg(angle)).collect()),
        })
    }

    fn spindle(&mut self) -> Option<Spindle> {
        let raw = self.raw.spindle.as_ref()?;
        let (min_rpm, max_rpm) = (raw.min_rpm?, raw.max_rpm?);
        if min_rpm > max_rpm {
            let steps = [Step::Key("spindle"), Step::Key("min_rpm")];
            self.error(
                Code::Conflict,
                &steps,
                format!("spindle.min_rpm is {min_rpm}, must not be above max_rpm, {max_rpm}"),
            );
            return None;
        }
        Some(Spindle {
            min_rpm,
            max_rpm,
            max_acceleration_rpm_per_s: raw.max_acceleration_rpm_per_s,
        })
    }

    fn policy(&mut self) -> Policy {
        let default = raw::Policy::default();
        let raw = self.raw.policy.as_ref().unwrap_or(&default);
        let bands = raw.ignore_hz.clone().unwrap_or_default();
        for (index, &[from, to]) in bands.iter().enumerate() {
            if !(from >= 0.0 && to >= from) {
                let what = format!(
                    "policy.ignore_hz[{index}] is [{from}, {to}], must be ascending and not \
                        negative"
                );
                let steps = [Step::Key("policy"), Step::Key("ignore_hz"), Step::Index(index)];
                self.error(Code::Value, &steps, what);
            }
        }
        self.check_uneven_pitch(raw);
        let tooth = raw.tooth_passing_harmonics.unwrap_or(DEFAULT_TOOTH_PASSING_HARMONICS);
        let spindle = raw.spindle_harmonics.unwrap_or(1);
        if tooth == 0 && spindle == 0 {
            let what = "policy: tooth_passing_harmonics and spindle_harmonics are both 0, so \
                nothing would be checked";
            self.error(
                Code::Unused,
                &[Step::Key("policy"), Step::Key("tooth_passing_harmonics")],
                what,
            );
        }
        Policy {
            tooth_passing_harmonics: tooth,
            spindle_harmonics: spindle,
            separation: ratio_from_percent(raw.separation_percent.unwrap_or(10.0)),
            model_uncertainty: raw.model_uncertainty_percent.map(ratio_from_percent),
            confidence: ratio_from_percent(raw.confidence_percent.unwrap_or(95.0)),
            ignore_hz: bands,
            min_tip_response_m_per_n: raw.min_tip_response_um_per_n.map(m_per_n_from_um_per_n),
        }
    }

    /// Uneven pitch has a line at every multiple of the spindle's frequency, so their number is
    /// bounded.
    fn check_uneven_pitch(&mut self, policy: &raw::Policy) {
        const MAX_ORDERS: u64 = 10_000;
        let harmonics = policy.tooth_passing_harmonics.unwrap_or(DEFAULT_TOOTH_PASSING_HARMONICS);
        let raw = self.raw;
        let uneven = raw.tool.iter().chain(raw.tools.iter().flat_map(BTreeMap::values));
        let teeth = uneven.filter(|tool| tool.pitch_deg.is_some()).filter_map(|tool| tool.teeth);
        let most = teeth.max().unwrap_or(0);
        let orders = u64::from(most) * u64::from(harmonics);
        if orders > MAX_ORDERS {
            let what = format!(
                "policy.tooth_passing_harmonics is {harmonics}: with {most} unevenly pitched \
                    teeth that is {orders} lines, must be at most {MAX_ORDERS}"
            );
            self.error(
                Code::Value,
                &[Step::Key("policy"), Step::Key("tooth_passing_harmonics")],
                what,
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::super::robot::tests as robot;
    use super::*;
    use crate::job::{Carried, CarriedBy, CuttingDirection, SpindleSpeed};
    use crate::motion::Target;

    const JOB: &str = include_str!("../../tests/data/bad/job.yaml");

    fn load(job: &str, robot_yaml: &str) -> Result<(Job, Vec<Note>), Vec<String>> {
        let (folder, _) = robot::folder(robot_yaml, robot::URDF);
        let path = folder.path().join("job.yaml");
        std::fs::write(&path, job).unwrap();
        let prefix = format!("{}/", folder.path().display());
        let mut reading = Reading::default();
        read_job(&path, &mut reading)
            .map(|job| (job, reading.warnings))
            .map_err(|notes| notes.iter().map(|f| f.to_string().replace(&prefix, "")).collect())
    }

    #[test]
    fn every_key_arrives_in_si() {
        let (job, warnings) = load(JOB, robot::YAML).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(job.name, "Pocket");
        assert_eq!(job.robot.name(), "Two-link section");
        let tool = job.operations[0].tool.clone();
        assert_eq!((tool.teeth, tool.diameter_m), (2, Some(0.012)));
        let pitch = tool.pitch_rad.unwrap();
        assert!((pitch.iter().sum::<f64>() - std::f64::consts::TAU).abs() < 1e-12);
        assert_eq!(job.spindle.max_acceleration_rpm_per_s, Some(500.0));
        let [rough, finish] = &job.operations[..] else { panic!() };
        assert_eq!((rough.name.as_str(), rough.line), ("rough", 10));
        assert_eq!(rough.speed, SpindleSpeed::Constant(1100.0));
        assert_eq!(rough.feed_m_per_s, 0.01);
        assert_eq!(rough.cutting.as_ref().unwrap().direction, CuttingDirection::Climb);
        assert_eq!(rough.moves.iter().map(|m| m.line).collect::<Vec<_>>(), [16, 17, 18]);
        let Target::Joints(q) = &rough.moves[1].to else { panic!() };
        assert!((q[0] - 10_f64.to_radians()).abs() < 1e-15);
        assert_eq!(rough.moves[0].tcp.translation.z, 0.15);
        assert_eq!(finish.speed, SpindleSpeed::Schedule(vec![(0.0, 1200.0), (1.0, 1350.0)]));
        assert_eq!(finish.moves.iter().map(|m| m.line).collect::<Vec<_>>(), [25, 26]);
        // The work object is turned by 90° about z: its x is the base's y.
        let Target::Line(pose) = &finish.moves[0].to else { panic!() };
        let expected = nalgebra::Vector3::new(0.9, 0.1, 0.4);
        assert!((pose.translation.vector - expected).norm() < 1e-12);
        assert!((pose.rotation * nalgebra::Vector3::z() + nalgebra::Vector3::z()).norm() < 1e-12);
        assert!((finish.start_near.as_ref().unwrap()[1] - 10_f64.to_radians()).abs() < 1e-15);
        let policy = job.policy;
        assert_eq!((policy.tooth_passing_harmonics, policy.spindle_harmonics), (3, 0));
        assert_eq!(policy.separation, 0.08);
        assert_eq!((policy.model_uncertainty, policy.confidence), (None, 0.95));
        assert_eq!(policy.ignore_hz, [[49.0, 51.0], [99.0, 101.0]]);
        assert!((policy.min_tip_response_m_per_n.unwrap() - 0.5e-6).abs() < 1e-20);
    }

    #[test]
    fn what_may_be_absent_has_the_contract_s_defaults() {
        let job = "robot: robot.yaml\ntool: {teeth: 2}\nspindle: {min_rpm: 500, max_rpm: \
            6000}\noperations: \
                   [{name: a, spindle_rpm: 600, feed_mm_per_min: 60, path: {poses: [{xyz_mm: [1, \
                   2, 3]}]}}]\n";
        let uncalibrated: String = robot::YAML
            .lines()
            .filter(|l| !l.starts_with("calibration"))
            .collect::<Vec<_>>()
            .join("\n");
        let job = load(job, &uncalibrated).unwrap().0;
        assert_eq!(job.name, "job");
        assert_eq!(
            job.policy,
            Policy {
                tooth_passing_harmonics: 2,
                spindle_harmonics: 1,
                separation: 0.1,
                model_uncertainty: None,
                confidence: 0.95,
                ignore_hz: Vec::new(),
                min_tip_response_m_per_n: None,
            }
        );
        let operation = &job.operations[0];
        assert_eq!((operation.line, &operation.start_near, &operation.program), (4, &None, &None));
        assert_eq!(operation.moves[0].tcp, Isometry3::identity());
        let Target::Line(pose) = &operation.moves[0].to else { panic!() };
        assert!(
            (pose.translation.vector - nalgebra::Vector3::new(1e-3, 2e-3, 3e-3)).norm() < 1e-15
        );
    }

    #[test]
    fn faults_of_job_and_robot_are_told_at_once() {
        let job = JOB
            .replace("spindle_rpm: 1100", "spindle_rpm: 400")
            .replace("feed_mm_per_min: 300", "feed_mm_per_min: 0")
            .replace("separation_percent: 8", "seperation_percent: 8");
        let robot = robot::YAML.replace("138000", "-1");
        assert_eq!(
            load(&job, &robot).unwrap_err(),
            [
                "job.yaml:11: operation 'rough': spindle_rpm is 400, must lie in the spindle's \
                    range 500..6000",
                "job.yaml:21: operation 'finish': feed_mm_per_min is 0, must be positive and \
                    finite",
                "job.yaml:30: policy: unknown key 'seperation_percent'; did you mean \
                    'separation_percent'?",
                "robot.yaml:11: joint 'joint_2': stiffness_nm_per_rad is -1, must be positive and \
                    finite",
            ]
        );
    }

    /// A job with `operation` and a program beside it, and its notices; or the errors.
    fn read_of(
        operation: &str,
        file: &str,
        program: &str,
    ) -> Result<(Job, Vec<String>), Vec<String>> {
        let (folder, _) = robot::folder(robot::YAML, robot::URDF);
        let path = folder.path().join("job.yaml");
        let tool = if operation.contains("\ntools:") { "" } else { "tool: {teeth: 2}\n" };
        let job = format!(
            "robot: robot.yaml\n{tool}spindle: {{min_rpm: 500, max_rpm: 20000}}\n\
             operations:\n  - name: rough\n{operation}"
        );
        std::fs::write(&path, job).unwrap();
        std::fs::write(folder.path().join(file), program).unwrap();
        let prefix = format!("{}/", folder.path().display());
        let shown = |notes: Vec<Note>| -> Vec<String> {
            notes.iter().map(|note| note.to_string().replace(&prefix, "")).collect()
        };
        let mut reading = Reading::default();
        let job = read_job(&path, &mut reading);
        job.map(|job| (job, shown(reading.warnings))).map_err(shown)
    }

    fn notices_of(operation: &str, file: &str, program: &str) -> Vec<String> {
        read_of(operation, file, program).unwrap().1
    }

    const GCODE: &str = "    path: {program: {file: a.nc}}\n";

    #[test]
    fn what_program_and_job_say_differently_is_an_error_unless_it_is_settled() {
        // Nothing moves under 9000 and 5000 rpm.
        let speeds =
            "G0 X0 Y0 Z0\nS1100 M3\nG1 X1 F100\nS12000\nX2\nS9000\nS8000\nX3\nM5\nX4\nS5000 M3\n";
        let of_job = format!("    spindle_rpm: 1100\n{GCODE}");
        let errors = read_of(&of_job, "a.nc", speeds).unwrap_err();
        assert_eq!(
            errors,
            ["job.yaml:6: operation 'rough': spindle_rpm is 1100, a.nc:4 commands 12000 rpm, and \
              one more speed; make them agree, or write speeds_from: program or speeds_from: job"]
        );
        let rpm = |operation: &str| -> Vec<SpindleSpeed> {
            let (job, _) = read_of(operation, "a.nc", speeds).unwrap();
            job.operations.into_iter().map(|operation| operation.speed).collect()
        };
        let three = [1100.0, 12_000.0, 8000.0].map(SpindleSpeed::Constant);
        assert_eq!(rpm(GCODE), three);
        assert_eq!(rpm(&format!("{of_job}speeds_from: program\n")), three);
        assert_eq!(rpm(&format!("{of_job}speeds_from: job\n")), three[..1]);
        let schedule = "    spindle_schedule: [{s: 0, rpm: 1100}]\n";
        let errors = read_of(&format!("{schedule}{GCODE}"), "a.nc", speeds).unwrap_err();
        assert!(
            errors[0].contains("has a spindle_schedule, a.nc:2 commands 1100 rpm"),
            "{errors:?}"
        );
        let feed = format!("    feed_mm_per_min: 60\n{GCODE}");
        let errors = read_of(&feed, "a.nc", speeds).unwrap_err();
        assert!(
            errors[0].contains("feed_mm_per_min is 60, a.nc:3 runs at 100 mm/min, and no move"),
            "{errors:?}"
        );
        let (job, notices) = read_of(GCODE, "a.nc", "S30000 M3\nG1 X0 Y0 Z0 F120\nX1\n").unwrap();
        assert_eq!(job.operations[0].feed_m_per_s, 0.002);
        assert_eq!(
            notices,
            ["a.nc:1: commands 30000 rpm, outside the spindle's range 500..20000 (operation \
              'rough')"]
        );
    }

    #[test]
    fn what_neither_program_nor_job_says_is_missing() {
        let errors = read_of(GCODE, "a.nc", "G0 X0 Y0 Z0\nG1 X1\n").unwrap_err();
        assert_eq!(
            errors,
            ["a.nc:2: moves at a feed that the program does not state: write feed_mm_per_min in \
              the job's operation"]
        );
        let errors = read_of(GCODE, "a.nc", "G0 X0 Y0 Z0\nG1 X1 F100\n").unwrap_err();
        assert_eq!(
            errors,
            ["job.yaml:5: operation 'rough': missing key 'spindle_rpm' (or 'spindle_schedule'): \
              a.nc:1 runs at a speed that the program does not state"]
        );
    }

    #[test]
    fn each_tool_of_the_program_is_one_of_the_job_s() {
        let program =
            "T1 M6\nS12000 M3\nG1 X0 Y0 Z0 F100\nX1\nT2\nX2\nM5\nX3\nM6\nX4\nS800 M3\nX5\n";
        let errors = read_of(GCODE, "a.nc", program).unwrap_err();
        assert_eq!(
            errors,
            [
                "job.yaml:2: operation 'rough': the program loads tool 1 and, from a.nc:10 on, tool 2: \
              write tools: {1: {teeth: …}, 2: {teeth: …}} instead of tool"
            ]
        );
        let tools = format!("{GCODE}tools: {{1: {{teeth: 3}}, 2: {{teeth: 1, payload: none}}}}\n");
        let (job, _) = read_of(&tools, "a.nc", program).unwrap();
        let found: Vec<_> = job
            .operations
            .iter()
            .map(|o| (o.name.as_str(), o.tool.teeth, o.tool_number, o.speed.rpm_at(0.0)))
            .collect();
        assert_eq!(found, [("rough", 3, Some(1), 12_000.0), ("rough/2", 1, Some(2), 800.0)]);
        let stretches: Vec<_> = job.operations.iter().map(|o| o.stretch.clone()).collect();
        assert_eq!(stretches, [0..4, 4..6]);
        let carried: Vec<_> = job.operations.iter().map(|o| o.carried.source).collect();
        assert_eq!(carried, [CarriedBy::Robot, CarriedBy::None]);
        let masses: Vec<_> = job.operations.iter().map(|o| o.robot.moving_mass_kg()).collect();
        assert!((masses[0] - masses[1] - 1.5).abs() < 1e-12, "{masses:?}");
        let one = format!("{GCODE}tools: {{1: {{teeth: 3}}}}\n");
        assert_eq!(
            read_of(&one, "a.nc", program).unwrap_err(),
            [
                "a.nc:10: operation 'rough': tool 2 is loaded, which is not among tools in the job (1)"
            ]
        );
    }

    #[test]
    fn the_most_specific_payload_wins_and_is_told() {
        let program = |mass: &str| {
            format!(
                "MODULE m\n  PERS tooldata \
                    tMill:=[TRUE,[[0,0,7],[1,0,0,0]],[{mass},[0,0,70],[0.7071068,0.7071068,0,0],1,2,2.5]];\n\
                 PROC main()\n MoveL [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tMill;\n\
                 MoveL [[1,2,4],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tMill;\n\
                 ENDPROC\nENDMODULE\n"
            )
        };
        let job = "    spindle_rpm: 1100\n    path: {program: {file: a.mod}}\n";
        let carried = |job: &str, mass: &str| {
            let (job, notices) = read_of(job, "a.mod", &program(mass)).unwrap();
            let carried = job.operations[0].carried;
            (carried.mass_kg, carried.source, notices)
        };
        let not_used = |whose: &str, kg: f64| {
            format!(
                "a.mod:2: tooldata tMill declares 4.2 kg, which is what the model carries; {whose} \
                 payload of {kg} kg is not used"
            )
        };
        let of_job = format!("{job}payload: {{mass_kg: 3}}\n");
        let none = format!("{job}payload: none\n");
        assert_eq!(
            [carried(job, "4.2"), carried(&of_job, "4.2"), carried(&none, "4.2")],
            [
                (4.2, CarriedBy::Program, vec![not_used("the robot file's", 1.5)]),
                (4.2, CarriedBy::Program, vec![not_used("the job's", 3.0)]),
                (4.2, CarriedBy::Program, vec![not_used("the job's", 0.0)]),
            ]
        );
        // ABB's placeholders say nothing.
        for mass in ["-1", "0.001"] {
            assert_eq!(carried(job, mass), (1.5, CarriedBy::Robot, vec![]));
            assert_eq!(carried(&of_job, mass), (3.0, CarriedBy::Job, vec![]));
            assert_eq!(carried(&none, mass), (0.0, CarriedBy::None, vec![]));
        }
        assert_eq!(carried(job, "1.5"), (1.5, CarriedBy::Program, vec![]));
        // The moments are given in axes turned by 90° about x, so y and z change places.
        let (read, _) = read_of(job, "a.mod", &program("4.2")).unwrap();
        let body = read.operations[0].robot.carried().unwrap().inertial;
        assert_eq!(body.com_m, nalgebra::Vector3::new(0.0, 0.0, 0.07));
        let expected = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 2.5, 2.0));
        assert!((body.inertia_kgm2 - expected).norm() < 1e-6, "{}", body.inertia_kgm2);
        // What is not a mapping is not taken for one.
        let errors =
            read_of(&format!("{job}payload: nothing\n"), "a.mod", &program("1")).unwrap_err();
        assert_eq!(
            errors,
            ["job.yaml:8: payload is nothing, must be a mapping of keys to values, or none"]
        );
        let odd =
            format!("{job}payload: {{mass_kg: 3, inertia_kgm2: {{ixx: 9, iyy: 1, izz: 1}}}}\n");
        let errors = read_of(&odd, "a.mod", &program("0")).unwrap_err();
        assert!(errors[0].starts_with("job.yaml:8: operation 'rough': payload: "), "{errors:?}");
    }

    #[test]
    fn a_load_that_nobody_states_is_told() {
        let bare = robot::YAML.lines().filter(|l| !l.starts_with("payload")).collect::<Vec<_>>();
        let (job, notices) = load(JOB, &bare.join("\n")).unwrap();
        assert_eq!(job.operations[0].carried, Carried::UNKNOWN);
        assert_eq!((notices.len(), notices[0].code), (1, Code::PayloadUnknown));
        let (job, notices) = load(&format!("{JOB}payload: none\n"), &bare.join("\n")).unwrap();
        assert_eq!((job.operations[0].carried, notices.len()), (Carried::NOTHING, 0));
    }

    #[test]
    fn rapid_sets_speed_and_tool_as_the_job_says() {
        let to = |x: u32| {
            format!(
                "MoveL [[{x},0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;"
            )
        };
        let [a, b, c, d] = [0, 1, 2, 3].map(to);
        let cases = [
            (
                "signal: aoSpindle, rpm_per_unit: 100",
                "signal: goTool",
                [
                    "SetGO goTool, 1;\nSetAO aoSpindle, 9;",
                    "SetAO aospindle, 8;",
                    "SetGO goTool, 2;",
                ],
            ),
            (
                "procedure: SpindleOn, argument: 2, rpm_per_unit: 100",
                "procedure: LoadTool",
                ["LoadTool 1;\nSpindleOn TRUE, 9;", "SpindleOn TRUE, 8;", "LoadTool 2;"],
            ),
            (
                "comment: SPINDLE, rpm_per_unit: 100",
                "comment: T",
                ["! T1\n! SPINDLE: 9 x100", "!SPINDLE 8", "\n! T 2"],
            ),
        ];
        for (spindle, tool, [first, second, third]) in cases {
            let program = format!(
                "MODULE m\nPROC main()\n{first}\n{a}\n{b}\n{second}\n{c}\n{third}\n{d}\n\
                 ENDPROC\nENDMODULE\n"
            );
            let job = format!(
                "    path:\n      program: {{file: a.mod, spindle_from: {{{spindle}}}, tool_from: \
                 {{{tool}}}}}\ntools: {{1: {{teeth: 3}}, 2: {{teeth: 2}}}}\n"
            );
            let (job, _) = read_of(&job, "a.mod", &program).unwrap();
            let found: Vec<_> = job
                .operations
                .iter()
                .map(|o| (o.stretch.clone(), o.speed.rpm_at(0.0), o.tool_number))
                .collect();
            let expected = [(0..2, 900.0, Some(1)), (2..3, 800.0, Some(1)), (3..4, 800.0, Some(2))];
            assert_eq!(found, expected, "{spindle}");
        }
    }

    #[test]
    fn a_procedure_without_effect_and_rapid_moves_are_told() {
        let operation = "    feed_mm_per_min: 60\n    spindle_rpm: 1100\n    path:\n      program:\n        file: \
            a.nc\n        procedure: main\n";
        assert_eq!(
            notices_of(operation, "a.nc", "G0 X0 Y0 Z0\nG1 X1 F60\nG0 X2\nZ5\nG1 X3\n"),
            [
                "job.yaml:11: operation 'rough': path.program.procedure 'main' has no effect: \
                    G-code has no procedures",
                "a.nc:3: 2 rapid moves, of which this is the first, run at the assumed 0.5 m/s",
            ]
        );
        let apt =
            "    feed_mm_per_min: 60\n    spindle_rpm: 1100\n    path: {program: {file: a.cls}}\n";
        assert_eq!(
            notices_of(apt, "a.cls", "GOTO/1,2,3\nRAPID\nGOTO/1,2,4\nGOTO/1,2,5\n"),
            ["a.cls:3: a rapid move runs at the assumed 0.5 m/s"]
        );
    }

    #[test]
    fn a_start_for_joints_has_no_effect_and_says_so() {
        let job = JOB.replace("    cutting: {", "    start_near_deg: [0, 0]\n    cutting: {");
        let (_, notices) = load(&job, robot::YAML).unwrap();
        assert_eq!((notices.len(), notices[0].place.line), (1, Some(13)));
    }
}
