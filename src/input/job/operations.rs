//! The operations of a job: paths, speeds, feeds and cutting.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use super::super::frame::frame;
use super::super::raw::job as raw;
use super::super::waypoints::{OperationContext, joint_position, moves_of};
use super::Reader;
use crate::formats::yaml::{Node, Step};
use crate::job::{
    Cutting, CuttingCoefficients, CuttingDirection, Operation, Spindle, SpindleSpeed,
};
use crate::notes::Code;
use crate::units::{
    m_from_mm, m_per_s_from_mm_per_min, n_per_m_from_n_per_mm, n_per_m2_from_n_per_mm2,
};

impl Reader<'_> {
    pub(super) fn operations(&mut self, spindle: Option<&Spindle>) -> Option<Vec<Operation>> {
        let nodes = self.tree.get("operations")?.items();
        let raws = self.raw.operations.as_ref()?;
        let mut first_lines: BTreeMap<&str, usize> = BTreeMap::new();
        let mut operations = Vec::new();
        for (index, (raw, node)) in raws.iter().zip(nodes).enumerate() {
            let called = match &raw.name {
                Some(name) => format!("operation '{name}'"),
                None => format!("operation {}", index + 1),
            };
            let line = node.line as usize;
            if let Some(name) = &raw.name
                && let first = *first_lines.entry(name).or_insert(line)
                && first != line
            {
                let steps = [Step::Key("operations"), Step::Index(index), Step::Key("name")];
                let what = format!("{called}: name is taken by the operation at line {first}");
                self.error(Code::Conflict, &steps, what);
            }
            operations.push(self.operation(raw, node, &called, spindle));
        }
        operations.into_iter().collect()
    }

    fn operation(
        &mut self,
        raw: &raw::Operation,
        node: &Node,
        called: &str,
        spindle: Option<&Spindle>,
    ) -> Option<Operation> {
        let speed = self.speed(raw, node, called, spindle);
        let feed_m_per_s = raw.feed_mm_per_min.map(m_per_s_from_mm_per_min);
        let start_near = self.start_near(raw, node, called);
        let operation = OperationContext {
            called,
            job: self.path,
            robot: self.robot,
            // A feed that is missing was reported; the waypoints are looked at all the same.
            feed_m_per_s: feed_m_per_s.unwrap_or(1.0),
            speed: speed.as_ref(),
            tcp: self.raw.tcp.as_ref().map(placed),
            work_object: self.raw.work_object.as_ref().map(placed),
        };
        self.check_radial_depth(raw, node, called);
        self.check_feed(raw, node, called);
        let path = raw.path.as_ref();
        let moves = path
            .and_then(|path| moves_of(&operation, path, node, &mut self.notes, &mut self.programs));
        let program = path.and_then(|path| path.program.as_ref()?.file.as_ref());
        let (moves, program_feeds) = moves?;
        Some(Operation {
            name: raw.name.clone()?,
            line: node.line as usize,
            speed: speed?,
            feed_m_per_s: feed_m_per_s?,
            cutting: raw.cutting.as_ref().and_then(cutting),
            moves,
            program: program.map(Into::into),
            program_feeds,
            start_near,
        })
    }

    fn speed(
        &mut self,
        raw: &raw::Operation,
        node: &Node,
        called: &str,
        spindle: Option<&Spindle>,
    ) -> Option<SpindleSpeed> {
        const KEYS: [&str; 2] = ["spindle_rpm", "spindle_schedule"];
        let faulty = |key: &str| node.get(key).is_some_and(|value| value.faulty);
        match (raw.spindle_rpm, &raw.spindle_schedule) {
            (Some(_), Some(_)) => {
                let line = node.line_at(&[Step::Key(KEYS[1])]);
                let what = "has both spindle_rpm and spindle_schedule, must have one";
                self.notes.error(Code::Conflict, line, format!("{called}: {what}"));
                None
            }
            (None, None) => {
                if !KEYS.into_iter().any(faulty) {
                    let what = "missing key 'spindle_rpm' (or 'spindle_schedule')";
                    self.notes.error(
                        Code::MissingKey,
                        node.line as usize,
                        format!("{called}: {what}"),
                    );
                }
                None
            }
            (Some(rpm), None) => {
                let line = node.line_at(&[Step::Key(KEYS[0])]);
                self.check_rpm(rpm, line, &format!("{called}: spindle_rpm"), spindle);
                Some(SpindleSpeed::Constant(rpm))
            }
            (None, Some(points)) => self.schedule(points, node, called, spindle),
        }
    }

    fn check_rpm(&mut self, rpm: f64, line: usize, what: &str, spindle: Option<&Spindle>) {
        if let Some(Spindle { min_rpm, max_rpm, .. }) = spindle
            && !(*min_rpm..=*max_rpm).contains(&rpm)
        {
            let what =
                format!("{what} is {rpm}, must lie in the spindle's range {min_rpm}..{max_rpm}");
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

    /// A cutter cannot cut wider than it is.
    fn check_radial_depth(&mut self, raw: &raw::Operation, node: &Node, called: &str) {
        let depth_mm = raw.cutting.as_ref().and_then(|cutting| cutting.radial_depth_mm);
        let diameter_mm = self.raw.tool.as_ref().and_then(|tool| tool.diameter_mm);
        let (Some(depth_mm), Some(diameter_mm)) = (depth_mm, diameter_mm) else { return };
        if depth_mm > diameter_mm {
            let line = node.line_at(&[Step::Key("cutting"), Step::Key("radial_depth_mm")]);
            let what = format!(
                "{called}: cutting.radial_depth_mm is {depth_mm}, must not be above \
                    tool.diameter_mm, {diameter_mm}"
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

fn cutting(raw: &raw::Cutting) -> Option<Cutting> {
    Some(Cutting {
        radial_depth_m: m_from_mm(raw.radial_depth_mm?),
        axial_depth_m: m_from_mm(raw.axial_depth_mm?),
        direction: match raw.direction? {
            raw::Direction::Climb => CuttingDirection::Climb,
            raw::Direction::Conventional => CuttingDirection::Conventional,
            raw::Direction::Slot => CuttingDirection::Slot,
        },
        material: raw.material.clone()?,
        coefficients: match &raw.coefficients {
            Some(own) => Some(CuttingCoefficients {
                tangential_n_per_m2: n_per_m2_from_n_per_mm2(own.ktc_n_per_mm2?),
                radial_n_per_m2: n_per_m2_from_n_per_mm2(own.krc_n_per_mm2?),
                tangential_edge_n_per_m: n_per_m_from_n_per_mm(own.kte_n_per_mm.unwrap_or(0.0)),
                radial_edge_n_per_m: n_per_m_from_n_per_mm(own.kre_n_per_mm.unwrap_or(0.0)),
            }),
            None => None,
        },
    })
}

fn placed(raw: &raw::Frame) -> Isometry3<f64> {
    frame(raw.xyz_m.unwrap_or_default(), raw.rpy_rad.unwrap_or_default())
}
