//! What robot programs leave to the cell: frames by number, external axes, and which call, signal
//! or comment sets the spindle's speed or the tool's number.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use nalgebra::Isometry3;

use super::log::{Log, States, Tool};
use super::span::Span;
use super::{Assumed, ExternalAxis, SetBy, Setter, Settings, Spindle, tool_number};
use crate::motion::{MechanicalUnit, UnitAxis, UnitMove, Work};
use crate::notes::Code;
use crate::units::{deg_from_rad, m_from_mm, rad_from_deg};

/// Joints that a robot's own program has.
const ROBOT_AXES: usize = 6;

/// Two positions of an external axis nearer than this are one, mm or degrees: taught positions
/// scatter.
const SAME_POSITION: f64 = 1e-2;

/// Tool `number` in the tip frame: the job's frame of that number, the flange for 0, else the job's
/// tcp.
pub(super) fn tool_frame(
    settings: &Settings,
    number: f64,
    list: &str,
) -> Result<Isometry3<f64>, String> {
    let index = tool_number(number)?;
    if let Some(frame) = settings.tool_frames.get(&index) {
        return Ok(*frame);
    }
    match (index, settings.tcp) {
        (_, Some(tcp)) => Ok(tcp),
        (0, None) => Ok(Isometry3::identity()),
        (_, None) => Err(format!(
            "{list}[{number}] is in no file that is read; give path.program.tool_frames: \
             {{{number}: …}} or the tcp in the job"
        )),
    }
}

/// The tool, where its frame is the job's tcp, or the tip frame where the job has none, for want of
/// one of its own; 0 is the flange.
pub(super) fn without_own_frame(settings: &Settings, number: u32) -> Option<Tool> {
    let is_own = settings.tool_frames.contains_key(&number);
    (number != 0 && !is_own).then_some(Tool::Number(number))
}

/// Base `number` in the robot's base frame: the job's frame of that number, the base frame itself
/// for 0, else the job's work object.
pub(super) fn base_frame(
    settings: &Settings,
    number: f64,
    list: &str,
) -> Result<Isometry3<f64>, String> {
    let index = tool_number(number).map_err(|_| format!("{list}[{number}] is no frame"))?;
    if let Some(frame) = settings.base_frames.get(&index) {
        return Ok(*frame);
    }
    match (index, settings.work_object) {
        (0, _) => Ok(Isometry3::identity()),
        (_, Some(object)) => Ok(object),
        (_, None) => Err(format!(
            "{list}[{number}] is in no file that is read; give path.program.base_frames: \
             {{{number}: …}} or the work_object in the job"
        )),
    }
}

/// External axes: those that stand still do not count, those that move are joints of the robot or
/// refused.
#[derive(Debug)]
pub(super) struct External {
    /// Joints by the axis's name, as the job maps them.
    joints: Vec<(String, ExternalAxis)>,
    joint_count: usize,
    /// See [`Settings::sliding`].
    sliding: Vec<usize>,
    /// Where each axis is: rad or m where it is a joint, else as the program has it.
    at: HashMap<String, f64>,
    /// What was said of an axis that moves: the same at every move, so that it is one error.
    told: HashMap<String, String>,
    /// Where each was placed, mm or degrees, now and at the end of the move before.
    given: [HashMap<String, f64>; 2],
    /// Axes of mechanical units that carry the work, and whether they slide.
    unit_axes: HashMap<String, bool>,
}

impl External {
    pub(super) fn new(settings: &Settings) -> Self {
        let joints = settings.external_axes.iter();
        let unit_axes = settings.mechanical_units.values().flat_map(|unit| &unit.axes);
        Self {
            joints: joints.map(|(name, index)| (name.clone(), *index)).collect(),
            joint_count: settings.joint_count,
            sliding: settings.sliding.clone(),
            at: HashMap::new(),
            told: HashMap::new(),
            given: Default::default(),
            unit_axes: unit_axes.map(|axis| (axis.name.clone(), axis.slides)).collect(),
        }
    }

    /// A move begins.
    pub(super) fn move_begins(&mut self) {
        let [now, before] = &mut self.given;
        if now != before {
            before.clone_from(now);
        }
    }

    /// What the axes that move need for the move that has begun, s, at these speeds, mm/s and
    /// degrees/s.
    pub(super) fn seconds(&self, [sliding, turning]: [Option<f64>; 2]) -> f64 {
        let [now, before] = &self.given;
        let needs = now.iter().filter_map(|(name, to)| {
            let joint = self.joints.iter().find(|(own, _)| own == name);
            let slides = joint.map(|(_, axis)| axis.slides);
            let slides = slides.or(self.unit_axes.get(name).copied())?;
            let speed = if slides { sliding } else { turning };
            Some((to - before.get(name)?).abs() / speed.filter(|speed| *speed > 0.0)?)
        });
        needs.fold(0.0, f64::max)
    }

    /// Where an axis was placed last, mm or degrees.
    pub(super) fn stands_at(&self, name: &str) -> Option<f64> {
        self.given[0].get(name).copied()
    }

    /// What a unit does on the move that has begun, where it carries the work; `has_moved`: whether
    /// there is a move before.
    pub(super) fn work_on(
        &self,
        unit: &Arc<MechanicalUnit>,
        has_moved: bool,
    ) -> Result<Work, String> {
        let [now, before] = &self.given;
        let to = |axis: &UnitAxis| match now.get(&axis.name) {
            Some(_) if has_moved && !before.contains_key(&axis.name) => Err(format!(
                "targets before do not say where external axis {} is; write it in all of them",
                axis.name
            )),
            Some(at) => Ok(si(*at, axis.slides)),
            None => Err(format!("external axis {} is placed by no target so far", axis.name)),
        };
        let to: Vec<f64> = unit.axes.iter().map(to).collect::<Result<_, _>>()?;
        let starts = unit.axes.iter().zip(&to);
        let from = starts.map(|(axis, to)| match before.get(&axis.name) {
            Some(at) => si(*at, axis.slides),
            None => *to,
        });
        let from = from.collect();
        Ok(Work::Moves(Arc::new(UnitMove { unit: Arc::clone(unit), from, to })))
    }

    /// An axis is to be at a position, mm or degrees.
    pub(super) fn place(&mut self, log: &mut Log, name: &str, value: f64) -> Result<(), String> {
        self.given[0].insert(name.to_owned(), value);
        if let Some((_, axis)) = self.joints.iter().find(|(own, _)| own == name) {
            let value = si(value, axis.slides);
            self.at.insert(name.to_owned(), value);
            log.hold(axis.joint, value);
            return Ok(());
        }
        if self.unit_axes.contains_key(name) {
            return Ok(());
        }
        match self.at.get(name).copied() {
            Some(before) if (before - value).abs() > SAME_POSITION => {
                let what = || {
                    format!(
                        "external axis {name} moves from {before} to {value}; write \
                         external_axes: {{{name}: …}} in the job, with the joint of the robot \
                         that it is{}",
                        if name.starts_with("eax_") {
                            ", or path.program.mechanical_units with the unit that carries the work"
                        } else {
                            ""
                        }
                    )
                };
                Err(self.told.entry(name.to_owned()).or_insert_with(what).clone())
            }
            Some(_) => Ok(()),
            // Where it was before is not known.
            None if log.has_moved() && value != 0.0 => Err(format!(
                "external axis {name} is {value} here, and targets before do not say where it is; \
                 write external_axes: {{{name}: …}} in the job, with the joint of the robot that \
                 it is, or {name} in all targets"
            )),
            // Constant so far.
            None => {
                self.at.insert(name.to_owned(), value);
                Ok(())
            }
        }
    }

    /// Where the robot has the joints of the arm, if it has six and those that the job maps.
    pub(super) fn arm(&self) -> Option<[usize; ROBOT_AXES]> {
        let mapped = |index: &usize| self.joints.iter().any(|(_, axis)| axis.joint == *index);
        let arm: Vec<usize> = (0..self.joint_count).filter(|index| !mapped(index)).collect();
        arm.try_into().ok()
    }

    /// All joints of the robot, rad or m, from the six of the arm and the external axes.
    pub(super) fn joints(&self, arm: &[f64; ROBOT_AXES]) -> Result<Vec<f64>, String> {
        let expected = ROBOT_AXES + self.joints.len();
        if self.joint_count != expected {
            return Err(format!(
                "a jointtarget has {ROBOT_AXES} axes{}, the robot has {} moving joints{}",
                if self.joints.is_empty() {
                    String::new()
                } else {
                    format!(" and {} mapped by external_axes", self.joints.len())
                },
                self.joint_count,
                if self.joint_count > expected {
                    ": external_axes in the job names those that the program has as external axes"
                } else {
                    ""
                }
            ));
        }
        let mut arm = arm.iter();
        let mut found = Vec::with_capacity(self.joint_count);
        for index in 0..self.joint_count {
            match self.joints.iter().find(|(_, axis)| axis.joint == index) {
                None => {
                    let slides = self.sliding.contains(&index);
                    let own = arm.next().copied();
                    found.extend(own.map(|position| match slides {
                        true => m_from_mm(deg_from_rad(position)),
                        false => position,
                    }));
                }
                Some((name, _)) => {
                    let value = self.at.get(name);
                    found.push(*value.ok_or_else(|| {
                        format!("external axis {name} is placed by no target before")
                    })?);
                }
            }
        }
        Ok(found)
    }
}

/// A position in mm or degrees, in m or rad.
fn si(position: f64, slides: bool) -> f64 {
    if slides { m_from_mm(position) } else { rad_from_deg(position) }
}

/// What a number sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sets {
    Spindle,
    Tool,
}

pub(super) fn all(settings: &Settings) -> impl Iterator<Item = (Sets, &SetBy)> {
    let spindle = settings.spindle_from.as_ref().map(|by| (Sets::Spindle, by));
    spindle.into_iter().chain(settings.tool_from.as_ref().map(|by| (Sets::Tool, by)))
}

/// Procedures, signals and data that the job names, in lower case: they mean the same in all files.
pub(super) fn named_by_job(settings: &Settings) -> HashSet<String> {
    let procedures = all(settings).filter_map(|(_, by)| match &by.what {
        Setter::Procedure(name, _) | Setter::Signal(name) => Some(name.to_lowercase()),
        _ => None,
    });
    let start = settings.procedure.iter().map(|name| name.to_lowercase());
    let base = |name: &String| {
        let datum = Assumed::enumeration(name).map_or(name.as_str(), |(datum, _)| datum);
        datum.split(['[', '{', '.']).next().unwrap_or(datum).to_lowercase()
    };
    procedures.chain(start).chain(settings.assume.keys().map(base)).collect()
}

/// A number that a program gives.
#[derive(Debug, Clone)]
pub(super) struct Given {
    /// Or why it is not known.
    pub(super) value: Result<f64, String>,
    /// Where it stands in the text, if it does.
    pub(super) span: Option<Span>,
    /// Whether what it is given to takes whole numbers alone.
    pub(super) whole: bool,
}

impl Given {
    /// To what takes any number.
    pub(super) fn any(value: Result<f64, String>, span: Option<Span>) -> Self {
        Self { value, span, whole: false }
    }
}

/// Sets the speed of the spindle or the number of the tool.
pub(super) fn set(log: &mut Log, line: usize, sets: Sets, given: Given, per_unit: f64) {
    /// A product of two decimal fractions is off by less than this share.
    const ROUNDING: f64 = 1e-12;
    log.sets(line);
    let Given { value, span, whole } = given;
    let value = value.and_then(|value| match whole && value.fract() != 0.0 {
        true => Err(format!("{value} is set where whole numbers alone are taken")),
        false => Ok(value),
    });
    let scaled = value.clone().map(|value| {
        let rpm = value * per_unit;
        let round = (rpm * 1e3).round() / 1e3;
        if (rpm - round).abs() <= ROUNDING * rpm.abs() { round } else { rpm }
    });
    match (sets, scaled) {
        (Sets::Spindle, Ok(rpm)) if rpm >= 0.0 => {
            if let (true, Ok(value)) = (rpm > 0.0, value) {
                log.states(line, span, States::Spindle { value, rpm_per_unit: per_unit, whole });
            }
            log.reverse(false);
            log.spindle(line, Spindle::at(Some(rpm)));
        }
        // It turns the other way round. A sign may stand outside of the span, so that the number is
        // not one to be replaced.
        (Sets::Spindle, Ok(rpm)) => {
            log.states(line, None, States::speed(-rpm));
            log.reverse(true);
            log.spindle(line, Spindle::at(Some(-rpm)));
        }
        (Sets::Spindle, Err(why)) => {
            let what = format!("the spindle's speed is known only at run time: {why}");
            log.warning(Code::SpindleCommand, line, what);
            log.spindle(line, Spindle::Turns(None));
        }
        (Sets::Tool, value) => match value.and_then(tool_number) {
            Ok(number) => log.tool(number),
            Err(why) => log.error(Code::Value, line, format!("tool: {why}")),
        },
    }
}

/// Whether a call of a procedure (name in lower case) sets something; then it is done.
pub(super) fn set_by_call(
    settings: &Settings,
    log: &mut Log,
    line: usize,
    name: &str,
    args: &[Given],
) -> bool {
    let mut done = false;
    for (sets, by) in all(settings) {
        if let Setter::Procedure(procedure, argument) = &by.what
            && procedure.to_lowercase() == name
            && let Some(given) = argument.checked_sub(1).and_then(|at| args.get(at))
        {
            set(log, line, sets, given.clone(), by.per_unit);
            done = true;
        }
    }
    done
}

/// Whether an assignment to a name (in lower case) sets something; then it is done.
pub(super) fn set_by_name(
    settings: &Settings,
    log: &mut Log,
    line: usize,
    name: &str,
    given: Given,
) -> bool {
    let mut done = false;
    for (sets, by) in all(settings) {
        if matches!(&by.what, Setter::Signal(signal) if signal.to_lowercase() == name) {
            set(log, line, sets, given.clone(), by.per_unit);
            done = true;
        }
    }
    done
}

/// What a comment sets; `span` gives the place of its digits.
pub(super) fn set_by_comment(
    settings: &Settings,
    log: &mut Log,
    line: usize,
    comment: &str,
    span: impl Fn(&str) -> Option<Span>,
) {
    for (sets, by) in all(settings) {
        let Setter::Comment(start) = &by.what else { continue };
        let rest = comment.trim_start().strip_prefix(start.as_str());
        if let Some((value, digits)) = rest.and_then(number) {
            set(log, line, sets, Given::any(Ok(value), span(digits)), by.per_unit);
        } else if is_unread(comment, start) {
            tell_unread(log, line, start);
        }
    }
}

/// Whether a comment has the text that the job names, and a number behind it that is not read.
fn is_unread(comment: &str, start: &str) -> bool {
    let (comment, start) = (comment.to_lowercase(), start.to_lowercase());
    let behind = comment.split_once(&start).map(|(_, behind)| behind);
    behind.is_some_and(|behind| behind.contains(|c: char| c.is_ascii_digit()))
}

fn tell_unread(log: &mut Log, line: usize, start: &str) {
    let what = format!(
        "a comment has '{start}' and no number is read from it: expected '{start}' first, and the \
         number behind it"
    );
    log.warning(Code::SpindleCommand, line, what);
}

/// A number in a comment: its line, what it sets, its value, its place, and what its unit stands
/// for.
type InComment = (usize, Sets, f64, Span, f64);

/// What comments say that begin with a text of the job's.
#[derive(Debug, Default)]
pub(super) struct Comments {
    /// Numbers, by the line of the instruction that follows.
    numbers: HashMap<usize, Vec<InComment>>,
    /// Comments that have the text, and no number that is read: line and text.
    unread: Vec<(usize, String)>,
}

impl Comments {
    /// The comments of a program that set something; comments begin with `mark`.
    pub(super) fn of(text: &str, mark: char, settings: &Settings) -> Self {
        let mut found = HashMap::new();
        let (mut open, mut unread) = (Vec::new(), Vec::new());
        if !all(settings).any(|(_, by)| matches!(by.what, Setter::Comment(_))) {
            return Self::default();
        }
        for (index, whole) in text.lines().enumerate() {
            let line = whole.trim();
            if let Some(comment) = line.strip_prefix(mark) {
                for (sets, by) in all(settings) {
                    let Setter::Comment(start) = &by.what else { continue };
                    let rest = comment.trim_start().strip_prefix(start.as_str());
                    if let Some((value, digits)) = rest.and_then(number) {
                        // The digits are a part of the text.
                        let at = digits.as_ptr() as usize - text.as_ptr() as usize;
                        let span = Span::new(at, at + digits.len());
                        open.push((index + 1, sets, value, span, by.per_unit));
                    } else if is_unread(comment, start) {
                        unread.push((index + 1, start.clone()));
                    }
                }
                continue;
            }
            // A comment behind an instruction holds from nowhere.
            if let Some((_, comment)) = line.split_once(mark) {
                let texts = all(settings).filter_map(|(_, by)| match &by.what {
                    Setter::Comment(start) => Some(start),
                    _ => None,
                });
                let own = texts.filter(|start| is_unread(comment, start));
                unread.extend(own.map(|start| (index + 1, start.clone())));
            }
            if !line.is_empty() && !open.is_empty() {
                found.insert(index + 1, std::mem::take(&mut open));
            }
        }
        Self { numbers: found, unread }
    }

    /// Tells of comments whose number is not read: of the main file, and all of the others.
    pub(super) fn tell(&self, mark: char, settings: &Settings, log: &mut Log) {
        for (line, start) in &self.unread {
            tell_unread(log, *line, start);
        }
        for other in &settings.companions {
            let own = Self::of(&other.text, mark, settings);
            let first = own.numbers.values().flatten().map(|(line, ..)| *line);
            if let Some(line) = first.chain(own.unread.iter().map(|(line, _)| *line)).min() {
                let what = format!(
                    "{}:{line}: a comment sets the spindle or the tool: comments are read in the \
                     main file alone",
                    other.name
                );
                log.warning(Code::SpindleCommand, 1, what);
            }
        }
    }

    /// Whether comments before the instruction of this line set something.
    pub(super) fn set_at(&self, line: usize) -> bool {
        self.numbers.contains_key(&line)
    }

    /// Tells of comments behind which no instruction stands, but the end of a branch or the like.
    pub(super) fn tell_unheeded(&self, is_instruction: impl Fn(usize) -> bool, log: &mut Log) {
        let unheeded = self.numbers.iter().filter(|(line, _)| !is_instruction(**line));
        if let Some(line) = unheeded.flat_map(|(_, own)| own).map(|(line, ..)| *line).min() {
            let what = "a comment that sets the spindle or the tool does not count here: no \
                        instruction follows it; write it before an instruction";
            log.warning(Code::SpindleCommand, line, what);
        }
    }

    /// Runs what comments before the instruction of this line set.
    pub(super) fn heed(&self, line: usize, log: &mut Log) {
        for &(line, sets, value, span, per_unit) in self.numbers.get(&line).into_iter().flatten() {
            set(log, line, sets, Given::any(Ok(value), Some(span)), per_unit);
        }
    }
}

/// The number at the start of a text, behind blanks and `=` or `:`, and its digits.
fn number(text: &str) -> Option<(f64, &str)> {
    let text = text.trim_start_matches([' ', '\t', '=', ':']);
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let digits = text.get(..end)?;
    // `12,000` and `1.2E4` are no numbers of this kind.
    let mut behind = text.get(end..)?.chars();
    let goes_on = matches!(behind.next(), Some(',' | 'e' | 'E'));
    if goes_on && behind.next().is_some_and(|c| c.is_ascii_digit()) {
        return None;
    }
    Some((digits.parse().ok()?, digits))
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_behind_the_start_of_a_comment() {
        for (text, expected) in [
            (" 12000 rpm", Some(12000.0)),
            ("=800.5;", Some(800.5)),
            (" off", None),
            ("", None),
            (" 12,000", None),
            (" 1.2E4", None),
        ] {
            assert_eq!(number(text).map(|(value, _)| value), expected, "{text}");
        }
    }
}
