//! The operations of a job: paths, speeds, feeds and cutting.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use nalgebra::Isometry3;

use super::super::frame::frame;
use super::super::moves::moves_of;
use super::super::raw::job as raw;
use super::super::waypoints::{OperationContext, PathMoves, joint_position};
use super::Reader;
use super::cutting::{cutting, with_measured_feed};
use super::speeds::Said;
use super::stretches::{stretches, usual_feed_m_per_s};
use crate::formats::yaml::{Node, Step};
use crate::job::{Operation, Spindle, SpindleSpeed, Tool, stretch_of};
use crate::motion::Move;
use crate::notes::{Code, Note, Place};
use crate::units::{m_per_s_from_mm_per_min, mm_from_m};
use crate::wording::plain;

/// Keys of the speed.
const SPEEDS: [&str; 2] = ["spindle_rpm", "spindle_schedule"];

impl<'j> Reader<'j> {
    pub(super) fn operations(
        &mut self,
        tool: Option<&Tool>,
        spindle: Option<&Spindle>,
    ) -> Option<Vec<Operation>> {
        let nodes = self.tree.get("operations")?.items();
        let raws = self.raw.operations.as_ref()?;
        self.check_names(raws, nodes);
        let mut operations = Vec::new();
        for (index, raw) in raws.iter().take(nodes.len()).enumerate() {
            let called = match &raw.name {
                Some(name) => format!("operation '{name}'"),
                None => format!("operation {}", index + 1),
            };
            operations.push(self.operation(index, &called, tool, spindle));
        }
        let operations: Option<Vec<Vec<Operation>>> = operations.into_iter().collect();
        Some(operations?.into_iter().flatten().collect())
    }

    /// Names are unique, those of stretches included, into which a program may divide an operation.
    fn check_names(&mut self, raws: &[raw::Operation], nodes: &[Node]) {
        let named: Vec<(&str, &Node)> = raws
            .iter()
            .zip(nodes)
            .filter_map(|(raw, node)| Some((raw.name.as_deref()?, node)))
            .collect();
        let mut first: BTreeMap<&str, &Node> = BTreeMap::new();
        for (name, node) in &named {
            first.entry(name).or_insert(node);
        }
        for (name, node) in &named {
            let line = node.line_at(&[Step::Key("name")]);
            if let Some(first) = first.get(name).filter(|first| !std::ptr::eq(**first, *node)) {
                let taken = format!("name is taken by the operation at line {}", first.line);
                self.notes.error(Code::Conflict, line, format!("operation '{name}': {taken}"));
            }
            if let Some((whole, first)) =
                stretch_of(name).and_then(|whole| first.get_key_value(whole))
            {
                let what = format!(
                    "operation '{name}': so is a stretch of operation '{whole}' (line {}) called \
                     where a program divides it; choose another name",
                    first.line
                );
                self.notes.error(Code::Conflict, line, what);
            }
        }
    }

    fn operation(
        &mut self,
        entry: usize,
        called: &str,
        tool: Option<&Tool>,
        spindle: Option<&Spindle>,
    ) -> Option<Vec<Operation>> {
        let raw = self.raw.operations.as_ref()?.get(entry)?;
        let node = self.tree.get("operations")?.items().get(entry)?;
        let speed = self.speed(raw, node, called, spindle);
        let feed_m_per_s = raw.feed_mm_per_min.map(m_per_s_from_mm_per_min);
        let start_near = self.start_near(raw, node, called);
        let (external_axes, assume) = (self.external_axes.clone(), self.assume());
        let tool_names = self.tool_names();
        let numbered = self.tools.iter().map(|(number, (_, tool))| (Some(*number), tool));
        let tools = numbered.chain(tool.map(|tool| (None, tool)));
        let tool_diameters_mm =
            tools.filter_map(|(of, tool)| Some((of, mm_from_m(tool.diameter_m?)))).collect();
        let operation = OperationContext {
            called,
            job: self.path,
            robot: self.robot,
            feed_m_per_s,
            nothing_stated: Arc::default(),
            tcp: self.raw.tcp.as_ref().map(placed),
            work_object: self.raw.work_object.as_ref().map(placed),
            external_axes: &external_axes,
            assume: &assume,
            tool_names: &tool_names,
            tool_diameters_mm: &tool_diameters_mm,
            spindle_rpm: raw.spindle_rpm,
            is_scheduled: raw.spindle_schedule.is_some(),
        };
        self.check_cutting(raw, node, called);
        if let Some(tool) = tool {
            self.check_diameter(raw, node, called, "tool", tool);
        }
        self.check_feed(raw, node, called);
        let path = raw.path.as_ref();
        let of_program = path.is_some_and(|path| path.program.is_some());
        if !of_program {
            self.require_speed_and_feed(raw, node, called);
        }
        let PathMoves { moves, program } = path.and_then(|path| {
            moves_of(&operation, path, node, &mut self.notes, &mut self.programs)
        })?;
        let said = Said { called, node, speed: speed.ok()?, feed_m_per_s };
        let is_speed_of_job = self.raw.speeds_from == Some(raw::SpeedsFrom::Job);
        self.cuts_without_load(called, &moves, program.as_ref().map(|own| own.file.as_path()));
        let stretches = stretches(
            &moves,
            is_speed_of_job && said.speed.is_some(),
            self.tools.contains_key(&0),
            self.has_payload(),
        );
        let settled = self.settle_speeds(&said, &moves, &stretches, program.as_ref(), spindle);
        let moves = Arc::new(moves);
        let mut operations = Vec::with_capacity(stretches.len());
        for (index, stretch) in stretches.into_iter().enumerate() {
            let line = moves.get(stretch.moves.start).map_or(0, |first| first.line);
            let file = program.as_ref().map(|program| (program.file.as_path(), line));
            let cutter = self.cutter(called, node, stretch.tool, tool, file);
            let of_tool = cutter.as_ref().and_then(|(key, _)| {
                let raw = self.raw;
                let numbered = key.and_then(|key| raw.tools.as_ref()?.get(key));
                let payload = match key {
                    Some(_) => numbered?.payload.as_ref(),
                    None => raw.tool.as_ref()?.payload.as_ref(),
                };
                payload.map(|payload| (payload, *key))
            });
            let file = file.map(|(file, _)| file);
            let carrier = self.carrier(called, stretch.load.as_deref(), of_tool, file);
            let name = raw.name.as_ref().map(|name| match index {
                0 => name.clone(),
                _ => format!("{name}/{}", index + 1),
            });
            let usual = || usual_feed_m_per_s(&moves, stretch.moves.clone());
            let (Some((key, cutter)), Some((robot, carried))) = (cutter, carrier) else { continue };
            if let Some(key) = key {
                self.check_diameter(raw, node, called, &format!("tools.{key}"), &cutter);
            }
            let speed = match (stretch.rpm, &said.speed) {
                (Some(rpm), _) => SpindleSpeed::Constant(rpm),
                (None, Some(speed)) => speed.clone(),
                (None, None) if stretch.stands => SpindleSpeed::Constant(0.0),
                (None, None) => continue,
            };
            let is_at_tip = |own: &Move| own.tcp == Isometry3::identity();
            let own = moves.get(stretch.moves.clone()).unwrap_or_default();
            operations.push(Operation {
                name: name?,
                is_tcp_assumed: self.raw.tcp.is_none() && own.iter().all(is_at_tip),
                entry,
                line: node.line as usize,
                tool: cutter,
                tool_number: stretch.tool,
                robot,
                carried,
                speed,
                is_speed_of_program: stretch.rpm.is_some() || stretch.stands,
                speed_step_rpm: program.as_ref().and_then(|program| program.speed_step_rpm),
                feed_m_per_s: feed_m_per_s.or_else(usual)?,
                is_feed_of_job: feed_m_per_s.is_some(),
                cutting: raw.cutting.as_ref().and_then(cutting),
                moves: Arc::clone(&moves),
                stretch: stretch.moves,
                program: program.as_ref().map(|program| program.called.clone()),
                program_feeds: program.as_ref().map(|p| p.feeds).unwrap_or_default(),
                start_near: start_near.clone(),
            });
        }
        with_measured_feed(&mut operations, (said.speed.as_ref(), feed_m_per_s));
        self.check_measured_of_one(&operations, raw.cutting.as_ref(), node, called);
        settled.then_some(operations)
    }

    /// The cutter of a stretch, with the key of `tools` that it stands under.
    fn cutter(
        &mut self,
        called: &str,
        node: &Node,
        number: Option<u32>,
        tool: Option<&Tool>,
        file: Option<(&Path, usize)>,
    ) -> Option<(Option<&'j str>, Tool)> {
        let numbered = number.and_then(|number| self.tools.get(&number));
        match (numbered, number, tool) {
            (Some((key, tool)), ..) => Some((Some(*key), tool.clone())),
            (None, Some(number), _) if self.raw.tools.is_some() => {
                let (file, line) = file?;
                let place = Place { line: Some(line), ..Place::file(file) };
                let known: Vec<String> = self.tools.keys().map(u32::to_string).collect();
                let what = format!(
                    "{called}: tool {number} is loaded, which is not among tools in the job ({})",
                    known.join(", ")
                );
                self.programs.errors.push(Note::error(Code::Reference, place, what));
                None
            }
            (_, _, Some(tool)) => Some((None, tool.clone())),
            (None, None, None) if self.raw.tools.is_some() => {
                let what = "the path names no tool by number: write tool beside tools";
                let line = node.line as usize;
                self.notes.error(Code::MissingKey, line, format!("{called}: {what}"));
                None
            }
            // A tool that is missing or wrong was reported.
            _ => None,
        }
    }

    /// The job's speed, if it gives one; a fault is reported.
    fn speed(
        &mut self,
        raw: &raw::Operation,
        node: &Node,
        called: &str,
        spindle: Option<&Spindle>,
    ) -> Result<Option<SpindleSpeed>, ()> {
        let faulty = |key: &str| node.get(key).is_some_and(|value| value.faulty);
        match (raw.spindle_rpm, &raw.spindle_schedule) {
            (Some(_), Some(_)) => {
                let line = node.line_at(&[Step::Key(SPEEDS[1])]);
                let what = "has both spindle_rpm and spindle_schedule, must have one";
                self.notes.error(Code::Conflict, line, format!("{called}: {what}"));
                Err(())
            }
            (None, None) if SPEEDS.into_iter().any(faulty) => Err(()),
            (None, None) => Ok(None),
            (Some(rpm), None) => {
                let line = node.line_at(&[Step::Key(SPEEDS[0])]);
                self.check_rpm(rpm, line, &format!("{called}: spindle_rpm"), spindle);
                Ok(Some(SpindleSpeed::Constant(rpm)))
            }
            (None, Some(points)) => {
                self.schedule(points, node, called, spindle).map(Some).ok_or(())
            }
        }
    }

    fn check_rpm(&mut self, rpm: f64, line: usize, what: &str, spindle: Option<&Spindle>) {
        if let Some(Spindle { min_rpm, max_rpm, .. }) = spindle
            && !(*min_rpm..=*max_rpm).contains(&rpm)
        {
            let [rpm, least, most] = [rpm, *min_rpm, *max_rpm].map(plain);
            let what = format!("{what} is {rpm}, must lie in the spindle's range {least}..{most}");
            self.notes.error(Code::Value, line, what);
        }
    }

    fn schedule(
        &mut self,
        raw: &[raw::SchedulePoint],
        node: &Node,
        called: &str,
        spindle: Option<&Spindle>,
    ) -> Option<SpindleSpeed> {
        let own = [Step::Key("spindle_schedule")];
        let points: Vec<(f64, f64)> =
            raw.iter().map(|point| Some((point.s?, point.rpm?))).collect::<Option<_>>()?;
        for (index, &(_, rpm)) in points.iter().enumerate() {
            let line = node.line_at(&[own[0], Step::Index(index), Step::Key("rpm")]);
            let what = format!("{called}: spindle_schedule[{index}].rpm");
            self.check_rpm(rpm, line, &what, spindle);
        }
        for (index, pair) in points.windows(2).enumerate() {
            if pair[1].0 <= pair[0].0 {
                let line = node.line_at(&[own[0], Step::Index(index + 1), Step::Key("s")]);
                let what = format!(
                    "{called}: spindle_schedule[{}].s is {}, must be above the one before, {}",
                    index + 1,
                    pair[1].0,
                    pair[0].0
                );
                self.notes.error(Code::Value, line, what);
            }
        }
        if let [(from, first), .., (to, last)] = points[..] {
            let held = |when: &str, rpm: f64| {
                format!("{called}: spindle_schedule {when}; {} rpm is taken to hold", plain(rpm))
            };
            let starts = (from > 0.0).then(|| {
                held(&format!("starts at s = {} and says nothing before", plain(from)), first)
            });
            let ends = (to < 1.0)
                .then(|| held(&format!("ends at s = {} and says nothing behind", plain(to)), last));
            for what in starts.into_iter().chain(ends) {
                self.notes.warning(Code::Assumed, node.line_at(&own), what);
            }
        }
        Some(SpindleSpeed::Schedule(points))
    }

    /// What no machine does would end in forces without bound.
    fn check_feed(&mut self, raw: &raw::Operation, node: &Node, called: &str) {
        const MAX_MM_PER_MIN: f64 = 1e9;
        if let Some(feed) = raw.feed_mm_per_min.filter(|feed| *feed > MAX_MM_PER_MIN) {
            let line = node.line_at(&[Step::Key("feed_mm_per_min")]);
            let what = format!(
                "{called}: feed_mm_per_min is {feed:e}, must be at most {MAX_MM_PER_MIN:e}"
            );
            self.notes.error(Code::Value, line, what);
        }
    }

    fn start_near(&mut self, raw: &raw::Operation, node: &Node, called: &str) -> Option<Vec<f64>> {
        let given = raw.start_near_deg.as_ref()?;
        let line = node.line_at(&[Step::Key("start_near_deg")]);
        if raw.path.as_ref().is_some_and(|path| path.joints_deg.is_some()) {
            let what = format!("{called}: start_near_deg has no effect on a path of joints_deg");
            self.notes.warning(Code::Unused, line, what);
        }
        let robot = self.robot?;
        match joint_position(robot, given) {
            Ok(q) => {
                for violation in robot.limit_violations(&q) {
                    self.notes.error(
                        Code::JointLimit,
                        line,
                        format!("{called}: start_near_deg: {violation}"),
                    );
                }
                Some(q)
            }
            Err(what) => {
                self.notes.error(Code::Value, line, format!("{called}: start_near_deg {what}"));
                None
            }
        }
    }
}

fn placed(raw: &raw::Frame) -> Isometry3<f64> {
    frame(raw.xyz_m.unwrap_or_default(), raw.rpy_rad.unwrap_or_default())
}
