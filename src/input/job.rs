//! job.yaml → a job.

mod accept;
mod carried;
pub(super) mod cutter;
mod cutting;
mod operations;
mod speeds;
mod stretches;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::accept::Entries;
use super::carriers::Carriers;
use super::files::{MAX_FILE_BYTES, named_file};
use super::kind::{FileKind, document_of};
use super::policy::{PolicyOverrides, check_bands};
use super::raw::job as raw;
use super::robot::read_described_robot;
use super::settings::{Settings, Shared};
use super::waypoints::FromPrograms;
use super::{Reading, schema};
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, Step};
use crate::job::{self, Acceptance, Job, Levers, Operation, Policy, Review, Spindle, Tool};
use crate::model::{JointKind, Robot};
use crate::notes::{Code, Note, Notes, Place};
use crate::program::{Assumed, ExternalAxis};
use crate::units::{m_from_um, m_per_n_from_um_per_n, rad_from_deg, ratio_from_percent};

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
    let mut settings = Settings::of(path, reading);
    let schema = schema::of::<raw::Job>();
    let Some((tree, raw)) = document_of::<raw::Job>(FileKind::Job, &text, &schema, &mut notes)
    else {
        let errors = [reading.settle(notes), reading.settle(settings.notes)];
        return Err(errors.concat());
    };
    drop(text);
    let robot_file = robot_file(path, &tree, &raw, &mut settings, &mut notes);
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
        external_axes: BTreeMap::new(),
        tools: BTreeMap::new(),
        shared: settings.shared.as_ref(),
        overrides: reading.policy.clone(),
        notes,
        notes_of_shared: settings.notes,
        programs: FromPrograms {
            reading: Reading { pending: reading.pending.take(), ..Reading::default() },
            ..FromPrograms::default()
        },
    };
    let parts = reader.parts();
    let accept = reader.acceptances();
    let taken = reader.taken_from_settings(&accept);
    let Reader { notes, notes_of_shared, programs, overrides, .. } = reader;
    let mut errors = [reading.settle(notes), reading.settle(notes_of_shared)].concat();
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
                review: Review {
                    warnings: reading.warnings.clone(),
                    settings: taken,
                    overrides: overrides.given,
                    accept,
                },
            })
        }
        _ => {
            errors.extend(programs.errors);
            errors.extend(robot_faults);
            Err(errors)
        }
    }
}

/// The robot that a job names, else that of the settings that it shares.
fn robot_file(
    path: &Path,
    tree: &Node,
    raw: &raw::Job,
    settings: &mut Settings,
    notes: &mut Notes,
) -> Option<PathBuf> {
    let steps = [Step::Key("robot")];
    if let Some(name) = &raw.robot {
        return named_file(path, "robot", name, tree.line_at(&steps), notes);
    }
    let shared = settings.shared.as_ref();
    if let Some((shared, name)) = shared.and_then(|s| Some((s, s.raw.robot.as_ref()?))) {
        let line = shared.tree.line_at(&steps);
        return named_file(&shared.file, "robot", name, line, &mut settings.notes);
    }
    let is_faulty = tree.get("robot").is_some_and(|robot| robot.faulty);
    if !is_faulty && settings.notes.errors() == 0 {
        let what = "missing key 'robot', which a detune.toml may give for all jobs";
        notes.error(Code::MissingKey, tree.line as usize, what);
    }
    None
}

/// What to write where nobody says what the arm carries.
fn unknown_payload(operations: &[Operation]) -> String {
    let unknown = operations.iter().filter(|operation| !operation.carried.is_known());
    let mut numbers: Vec<u32> = unknown.filter_map(|operation| operation.tool_number).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let keys: Vec<String> = numbers.iter().map(|number| format!("tools.{number}")).collect();
    let tools = match keys.is_empty() {
        true => String::new(),
        false => format!(", or with the tool ({})", keys.join(", ")),
    };
    format!(
        "what the arm carries is stated nowhere, so the model carries nothing: write payload: \
         {{mass_kg: …, com_m: […]}} or payload: none in the job{tools}"
    )
}

/// What is at hand while a job is read.
struct Reader<'j> {
    path: &'j Path,
    tree: &'j Node,
    raw: &'j raw::Job,
    /// `None` where the robot has faults.
    robot: Option<&'j Robot>,
    carriers: Option<Carriers<'j>>,
    /// Joints that programs move as external axes, by the axis's name in lower case.
    external_axes: BTreeMap<String, ExternalAxis>,
    /// The cutters by the program's number, each with the key that it stands under.
    tools: BTreeMap<u32, (&'j str, Tool)>,
    /// What the job shares with others.
    shared: Option<&'j Shared>,
    /// What wins over both.
    overrides: PolicyOverrides,
    notes: Notes,
    notes_of_shared: Notes,
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
        self.of_no_program();
        self.numbered_tools();
        self.external_axes();
        let spindle = self.spindle();
        let policy = self.policy();
        self.tcp_far_away();
        self.angles_in_degrees();
        self.masses_without_place();
        self.payloads_far_out();
        let operations = self.operations(tool.as_ref(), spindle.as_ref());
        self.assumed_of_nothing();
        let levers = self.levers(operations.as_deref().unwrap_or_default());
        let operations = operations?;
        if operations.iter().any(|operation| !operation.carried.is_known()) {
            self.notes.warning(Code::PayloadUnknown, None, unknown_payload(&operations));
        }
        Some((spindle?, operations, policy, levers))
    }

    /// Keys that are for programs, where no operation runs one.
    fn of_no_program(&mut self) {
        let raw = self.raw;
        let runs =
            |of: &raw::Operation| of.path.as_ref().is_some_and(|path| path.program.is_some());
        if raw.operations.iter().flatten().any(runs) {
            return;
        }
        for (key, is_given) in [
            ("tools", raw.tools.is_some() && raw.tool.is_some()),
            ("external_axes", raw.external_axes.is_some()),
            ("assume", raw.assume.is_some()),
            ("speeds_from", raw.speeds_from.is_some()),
        ] {
            if is_given {
                let what = format!("{key} has no effect: no operation runs a program");
                let line = self.tree.line_at(&[Step::Key(key)]);
                self.notes.warning(Code::Unused, line, what);
            }
        }
    }

    /// What `assume` gives and no program names, where all could be read.
    fn assumed_of_nothing(&mut self) {
        if self.programs.reading.programs.is_empty() {
            return;
        }
        for name in self.raw.assume.iter().flatten().map(|(name, _)| name) {
            if !self.programs.assumed.contains(&name.to_lowercase()) {
                let line = self.tree.line_at(&[Step::Key("assume"), Step::Key(name)]);
                let what = format!("assume: '{name}' stands in no program that the job runs");
                self.notes.warning(Code::Unused, line, what);
            }
        }
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
                        "tools has the key '{key}', must be the number of a tool in the program; \
                         for one that the program calls by a name: {{1: {{name: …, teeth: …}}}}"
                    );
                    self.error(Code::Value, &steps, what);
                }
            }
        }
    }

    /// Numbers of tools by their names, but for names that several have.
    fn tool_names(&self) -> BTreeMap<String, u32> {
        let mut found: BTreeMap<String, Option<u32>> = BTreeMap::new();
        for (number, (_, tool)) in &self.tools {
            if let Some(name) = &tool.name {
                let is_other = found.contains_key(name);
                found.insert(name.clone(), (!is_other).then_some(*number));
            }
        }
        found.into_iter().filter_map(|(name, number)| Some((name, number?))).collect()
    }

    fn external_axes(&mut self) {
        let (raw, robot) = (self.raw, self.robot);
        for (axis, name) in raw.external_axes.iter().flatten() {
            let Some(robot) = robot else { return };
            let joint = robot.joints().iter().position(|joint| joint.name == *name);
            match joint {
                Some(joint) => {
                    let slides = robot.joints()[joint].kind == JointKind::Prismatic;
                    self.external_axes.insert(axis.to_lowercase(), ExternalAxis { joint, slides });
                }
                None => {
                    let names: Vec<&str> =
                        robot.joints().iter().map(|joint| joint.name.as_str()).collect();
                    let what = format!(
                        "external_axes.{axis} is '{name}', must be a moving joint of the robot: {}",
                        names.join(", ")
                    );
                    self.error(
                        Code::Reference,
                        &[Step::Key("external_axes"), Step::Key(axis)],
                        what,
                    );
                }
            }
        }
    }

    /// What programs are taken to find, by name in lower case.
    fn assume(&self) -> BTreeMap<String, Assumed> {
        let given = self.raw.assume.iter().flatten();
        given
            .map(|(name, value)| {
                let value = match *value {
                    raw::Assumed::Truth(value) => Assumed::Truth(value),
                    raw::Assumed::Number(value) => Assumed::Number(value),
                };
                (name.to_lowercase(), value)
            })
            .collect()
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
        cutter::tool(raw, what, at, self.tree, &mut self.notes)
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

    /// Findings that count no more, by the job and by the settings that it shares.
    fn acceptances(&mut self) -> Vec<Acceptance> {
        let operations = self.raw.operations.iter().flatten();
        let own = Entries {
            file: self.path,
            tree: self.tree,
            raw: self.raw.accept.as_deref(),
            job: self.path,
            operations: operations.filter_map(|raw| raw.name.as_deref()).collect(),
        };
        let mut all = own.acceptances(&mut self.notes);
        if let Some(Shared { file, tree, raw }) = self.shared {
            let shared = Entries { file, tree, raw: raw.accept.as_deref(), ..own };
            all.extend(shared.acceptances(&mut self.notes_of_shared));
        }
        all
    }

    /// What the settings say and the job leaves open.
    fn taken_from_settings(&self, accept: &[Acceptance]) -> Option<job::Settings> {
        let Shared { file, tree, .. } = self.shared?;
        let taken = |steps: &[Step<'_>]| tree.at(steps).is_some() && self.tree.at(steps).is_none();
        let robot = taken(&[Step::Key("robot")]).then(|| "robot".to_owned());
        let of_policy = tree.get("policy").into_iter().flat_map(Node::keys);
        let overridden = |key: &str| self.overrides.sets(key);
        let of_policy = of_policy.filter(|key| taken(&policy_key(key)) && !overridden(key));
        let of_policy = of_policy.map(|key| format!("policy.{key}"));
        let accepts = accept.iter().any(|entry| entry.place.file.as_ref() == Some(file));
        let accept = accepts.then(|| "accept".to_owned());
        let keys: Vec<String> = robot.into_iter().chain(of_policy).chain(accept).collect();
        (!keys.is_empty()).then(|| job::Settings { file: file.clone(), keys })
    }

    /// An error about a key of the policy, in the file that gives it.
    fn policy_error(&mut self, code: Code, steps: &[Step<'_>], what: impl Into<String>) {
        let shared = self.shared.filter(|_| self.tree.at(&steps[..2]).is_none());
        match shared.filter(|shared| shared.tree.at(&steps[..2]).is_some()) {
            Some(shared) => self.notes_of_shared.error(code, shared.tree.line_at(steps), what),
            None => self.error(code, steps, what),
        }
    }

    fn policy(&mut self) -> Policy {
        let of_job = self.raw.policy.as_ref();
        let of_settings = self.shared.and_then(|shared| shared.raw.policy.as_ref());
        let default = raw::Policy::default();
        let of_files = of_job.unwrap_or(&default).or(of_settings.unwrap_or(&default));
        let raw = &self.overrides.raw.or(&of_files);
        let at = [Step::Key("policy")];
        check_bands(of_job, self.tree, &at, &mut self.notes);
        if let Some(shared) = self.shared {
            check_bands(of_settings, &shared.tree, &at, &mut self.notes_of_shared);
        }
        self.check_uneven_pitch(raw);
        let tooth = raw.tooth_passing_harmonics.unwrap_or(DEFAULT_TOOTH_PASSING_HARMONICS);
        let spindle = raw.spindle_harmonics.unwrap_or(1);
        if tooth == 0 && spindle == 0 {
            let what = "policy: tooth_passing_harmonics and spindle_harmonics are both 0, so \
                nothing would be checked";
            self.policy_error(Code::Unused, &policy_key("tooth_passing_harmonics"), what);
        }
        Policy {
            tooth_passing_harmonics: tooth,
            spindle_harmonics: spindle,
            separation: ratio_from_percent(raw.separation_percent.unwrap_or(10.0)),
            model_uncertainty: raw.model_uncertainty_percent.map(ratio_from_percent),
            confidence: ratio_from_percent(raw.confidence_percent.unwrap_or(95.0)),
            ignore_hz: raw.ignore_hz.clone().unwrap_or_default(),
            min_tip_response_m_per_n: raw.min_tip_response_um_per_n.map(m_per_n_from_um_per_n),
            max_deflection_m: raw.max_deflection_um.map(m_from_um),
            max_vibration_m: raw.max_vibration_um.map(m_from_um),
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
            self.policy_error(Code::Value, &policy_key("tooth_passing_harmonics"), what);
        }
    }
}

fn policy_key(key: &str) -> [Step<'_>; 2] {
    [Step::Key("policy"), Step::Key(key)]
}

#[cfg(test)]
mod tests;
