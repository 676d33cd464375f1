//! What the tip carries on each stretch: the program's tool data, else the job's payload, else the
//! robot file's; and the robot with it.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

use super::super::raw::job as raw;
use super::super::robot::inertial;
use super::Reader;
use crate::formats::yaml::Step;
use crate::job::{Carried, CarriedBy};
use crate::model::{Inertial, Robot};
use crate::motion::{Load, Move, Timing};
use crate::notes::{Code, Note, Place};
use crate::wording::rounded;

/// Masses that are closer than this are one that was rounded, share of the larger.
const ROUNDED: f64 = 0.01;

/// What a program and its job say of one tool may not lie farther apart, share of the larger: a
/// tenth of the mass at the tip is up to a twentieth of a frequency.
const MAX_APART: f64 = 0.1;

fn apart(kg: f64, other_kg: f64) -> f64 {
    (kg - other_kg).abs() / kg.max(other_kg).max(f64::MIN_POSITIVE)
}

impl<'r> Reader<'r> {
    /// The robot as it runs a stretch, and what it carries. `None` where there are faults.
    pub(super) fn carrier(
        &mut self,
        called: &str,
        load: Option<&Load>,
        of_tool: Option<(&raw::Payload, Option<&str>)>,
        program: Option<&Path>,
    ) -> Option<(Arc<Robot>, Carried)> {
        if let (Some(load), Some(file)) = (load, program) {
            if !load.is_placeholder {
                return self.loaded(load, file);
            }
            self.of_new_tool(load, file);
        }
        let raw = self.raw;
        let of_job = raw.payload.as_ref().map(|payload| (payload, None));
        let Some((payload, tool)) = of_tool.map(|(p, key)| (p, Some(key))).or(of_job) else {
            let carriers = self.carriers.as_ref()?;
            let of_robot = |mass_kg| Carried { mass_kg, source: CarriedBy::Robot };
            let carried = carriers.own_kg.map_or(Carried::UNKNOWN, of_robot);
            return Some((Arc::clone(&carriers.own), carried));
        };
        let (body, source) = match payload {
            raw::Payload::Nothing(raw::Nothing::None) => (None, CarriedBy::None),
            raw::Payload::Body(body) => (Some(inertial(body)), CarriedBy::Job),
        };
        let steps = match tool {
            Some(Some(key)) => vec![Step::Key("tools"), Step::Key(key)],
            Some(None) => vec![Step::Key("tool")],
            None => Vec::new(),
        };
        let steps = [steps, vec![Step::Key("payload")]].concat();
        match self.carriers.as_mut()?.with(body) {
            Ok(robot) => {
                let mass_kg = body.map_or(0.0, |body| body.mass_kg);
                for why in self.against_corrections(mass_kg) {
                    let what = format!("{called}: a payload of {mass_kg} kg {why}");
                    if !self.notes.list().iter().any(|note| note.what == what) {
                        let line = self.tree.line_at(&steps);
                        self.notes.warning(Code::ToolMassConflict, Some(line), what);
                    }
                }
                Some((robot, Carried { mass_kg, source }))
            }
            Err(why) => {
                self.error(Code::Inertia, &steps, format!("{called}: payload: {why}"));
                None
            }
        }
    }

    /// Whether the job says what the arm carries, or that it carries nothing, which holds for moves
    /// whose load no program states.
    pub(super) fn has_payload(&self) -> bool {
        self.raw.payload.is_some()
    }

    /// Doubts cuts of which a program does not state the load, where it states that of others: they
    /// are checked with one of these.
    pub(super) fn cuts_without_load(&mut self, called: &str, moves: &[Move], file: Option<&Path>) {
        let states = |each: &Move| each.stated.load.as_ref().is_some_and(|own| !own.is_placeholder);
        if self.has_payload() || !moves.iter().any(states) {
            return;
        }
        // Nothing moves to where the path starts.
        let mut cuts = moves.iter().skip(1).filter(|each| {
            let cuts = each.spindle_turns && each.timing == Timing::Feed;
            cuts && !states(each)
        });
        let (Some(first), Some(file)) = (cuts.next(), file) else { return };
        let place = Place { line: Some(first.line), ..Place::file(file) };
        let what = format!(
            "{called}: the program states the load of some moves and not of this one, which is \
             checked with that of a neighbour: write payload in the job, with all that the arm \
             carries on this move, the tool too; it is the load of moves without one"
        );
        self.programs.reading.warnings.push(Note::warning(Code::PayloadUnknown, place, what));
    }

    /// How a mass that is stated at the tip contradicts what corrections put there.
    fn against_corrections(&self, mass_kg: f64) -> impl Iterator<Item = String> + use<> {
        let both = [self.lost_correction(mass_kg), self.counted_twice(mass_kg)];
        both.into_iter().flatten()
    }

    /// What a mass at the tip takes away that corrections put there, if it does.
    fn lost_correction(&self, mass_kg: f64) -> Option<String> {
        let (of_file, in_all) = self.carriers.as_ref()?.corrected_kg()?;
        (apart(in_all, mass_kg) > MAX_APART).then(|| {
            format!(
                "takes the place of the {} kg that the robot file's corrections find at the tip, \
                 where it states {of_file} kg; state what the arm carries in all, or leave it out",
                rounded(in_all, 3)
            )
        })
    }

    /// What corrections hang on the tip and a mass there may both be, if it matters.
    fn counted_twice(&self, mass_kg: f64) -> Option<String> {
        /// Of all that is carried.
        const MATTERS: f64 = 0.02;
        let hung_kg = self.carriers.as_ref()?.hung_kg;
        (hung_kg > MATTERS * (mass_kg + hung_kg)).then(|| {
            format!(
                "stands beside the {} kg that the robot file's local_mode hangs on the tip; where \
                 it contains that part, the part is counted twice: state what else the arm carries",
                rounded(hung_kg, 3)
            )
        })
    }

    /// Doubts a tool that ends farther from the tip than tools do.
    pub(super) fn tcp_far_away(&mut self) {
        /// Tools of robots are shorter.
        const MAX_M: f64 = 2.0;
        let Some(xyz_m) = self.raw.tcp.as_ref().and_then(|tcp| tcp.xyz_m) else { return };
        let away_m = Vector3::from(xyz_m).norm();
        if away_m > MAX_M {
            let line = self.tree.line_at(&[Step::Key("tcp")]);
            let what = format!("tcp is {away_m} m from the robot's tip: is it in millimetres?");
            self.notes.warning(Code::CadUnits, Some(line), what);
        }
    }

    /// Doubts angles of frames beyond a whole turn.
    pub(super) fn angles_in_degrees(&mut self) {
        const TURN_RAD: f64 = std::f64::consts::TAU + 0.01;
        for (key, frame) in [("tcp", &self.raw.tcp), ("work_object", &self.raw.work_object)] {
            let Some(rpy) = frame.as_ref().and_then(|frame| frame.rpy_rad) else { continue };
            if rpy.iter().any(|angle| angle.abs() > TURN_RAD) {
                let line = self.tree.line_at(&[Step::Key(key)]);
                let what = format!(
                    "{key}: rpy_rad is [{}, {}, {}], more than a whole turn; is it in degrees?",
                    rpy[0], rpy[1], rpy[2]
                );
                self.notes.warning(Code::CadUnits, Some(line), what);
            }
        }
    }

    /// Doubts what is carried farther out than spindles, grippers and workpieces reach.
    pub(super) fn payloads_far_out(&mut self) {
        /// Radius of gyration about the worst axis, and distance of the centre of mass, m.
        const MOST_M: [f64; 2] = [1.0, 2.0];
        for (owner, steps, payload) in self.payloads() {
            let Some(raw::Payload::Body(body)) = payload else { continue };
            let body = inertial(body);
            let largest_kgm2 = body.inertia_kgm2.symmetric_eigenvalues().max();
            let gyration_m = (largest_kgm2 / body.mass_kg).sqrt();
            let of = [
                (gyration_m, MOST_M[0], "radius of gyration", "the inertia in kg·m²"),
                (body.com_m.norm(), MOST_M[1], "centre of mass", "com_m in metres"),
            ];
            for (value_m, most_m, name, unit) in of {
                if value_m.is_finite() && value_m > most_m {
                    let line = self.tree.line_at(&steps);
                    let what = format!(
                        "{owner}payload: the {name} is {} m, where tools and workpieces have at \
                         most {most_m} m; is {unit}?",
                        rounded(value_m, 3)
                    );
                    self.notes.warning(Code::InertiaExtent, Some(line), what);
                }
            }
        }
    }

    /// Payloads of the job and of its tools: how messages begin, where they stand, and what they
    /// are.
    fn payloads(&self) -> Vec<(String, Vec<Step<'r>>, Option<&'r raw::Payload>)> {
        let raw = self.raw;
        let of_job = [(String::new(), Vec::new(), raw.payload.as_ref())].into_iter();
        let of_tool = raw
            .tool
            .iter()
            .map(|tool| ("tool.".to_owned(), vec![Step::Key("tool")], tool.payload.as_ref()));
        let of_tools = raw.tools.iter().flatten().map(|(key, tool)| {
            let steps = vec![Step::Key("tools"), Step::Key(key)];
            (format!("tools.{key}."), steps, tool.payload.as_ref())
        });
        let all = of_job.chain(of_tool).chain(of_tools);
        let placed = |(owner, steps, payload): (String, Vec<Step<'r>>, _)| {
            (owner, [steps, vec![Step::Key("payload")]].concat(), payload)
        };
        all.map(placed).collect()
    }

    /// Reports masses at the tip of which nobody says where they are.
    pub(super) fn masses_without_place(&mut self) {
        for (owner, steps, payload) in self.payloads() {
            let Some(raw::Payload::Body(body)) = payload else { continue };
            if body.com_m.is_some() || body.mass_kg.is_none_or(|mass_kg| mass_kg == 0.0) {
                continue;
            }
            let line = self.tree.line_at(&steps);
            let what = format!(
                "{owner}payload has no com_m, so its centre of mass is taken at the origin of the \
                 tip frame"
            );
            self.notes.warning(Code::Assumed, Some(line), what);
        }
    }

    /// A placeholder states no load; beside a job that says that nothing is carried it is a doubt.
    fn of_new_tool(&mut self, load: &Load, file: &Path) {
        let says_nothing = matches!(self.raw.payload, Some(raw::Payload::Nothing(_)));
        let (code, check) = match says_nothing {
            true => {
                (Code::ToolMassConflict, "; the job says payload: none: put right what is wrong")
            }
            false => (Code::Assumed, ""),
        };
        let what = format!(
            "tooldata {}: 1 kg at [0, 0, 1] mm is RobotStudio's placeholder, which counts as no \
             load{check}",
            load.name
        );
        let place = Place { line: Some(load.line), ..Place::file(file) };
        let warning = Note::warning(code, place, what);
        if !self.programs.reading.warnings.contains(&warning) {
            self.programs.reading.warnings.push(warning);
        }
    }

    /// The robot with what the program says that it carries.
    fn loaded(&mut self, load: &Load, file: &Path) -> Option<(Arc<Robot>, Carried)> {
        let place = Place { line: Some(load.line), ..Place::file(file) };
        let Load { name, mass_kg, com_m, inertia_kgm2, .. } = load;
        let body = Inertial { mass_kg: *mass_kg, com_m: *com_m, inertia_kgm2: *inertia_kgm2 };
        let point = Inertial { inertia_kgm2: Default::default(), ..body };
        let carriers = self.carriers.as_mut()?;
        let mut warnings = Vec::new();
        // Moments that no body has are common in tool data, and hardly count beside the mass.
        let robot = carriers.with(Some(body)).or_else(|why| {
            let robot = carriers.with(Some(point))?;
            let what = format!("tooldata {name}: {why}; its load is taken as a point mass");
            warnings.push(Note::warning(Code::Inertia, place.clone(), what));
            Ok::<_, String>(robot)
        });
        let robot = match robot {
            Ok(robot) => robot,
            Err(why) => {
                let what = format!("tooldata {name}: {why}");
                self.programs.errors.push(Note::error(Code::Inertia, place, what));
                return None;
            }
        };
        let of_robot = carriers.own_kg.map(|kg| ("the robot file's", kg));
        let of_job = self.raw.payload.as_ref().map(|payload| match payload {
            raw::Payload::Nothing(_) => ("the job's", 0.0),
            raw::Payload::Body(body) => ("the job's", body.mass_kg.unwrap_or(*mass_kg)),
        });
        let other = of_job.or(of_robot).filter(|&(_, kg)| apart(kg, *mass_kg) > ROUNDED);
        for why in self.against_corrections(*mass_kg) {
            let what = format!("tooldata {name}: its {mass_kg} kg {why}");
            warnings.push(Note::warning(Code::ToolMassConflict, place.clone(), what));
        }
        if let Some((whose, other_kg)) = other {
            // A robot file may state what it carries at other times.
            let contradicts = of_job.is_some() && apart(other_kg, *mass_kg) > MAX_APART;
            let (code, check) = match contradicts {
                true => (Code::ToolMassConflict, "; put right the one that is wrong"),
                false => (Code::ToolMass, ""),
            };
            let other_kg = rounded(other_kg, 3);
            let what = format!(
                "tooldata {name} declares {mass_kg} kg, which is what the model carries; {whose} \
                 payload of {other_kg} kg is not used{check}"
            );
            warnings.push(Note::warning(code, place, what));
        }
        for warning in warnings {
            if !self.programs.reading.warnings.contains(&warning) {
                self.programs.reading.warnings.push(warning);
            }
        }
        Some((robot, Carried { mass_kg: *mass_kg, source: CarriedBy::Program }))
    }
}
