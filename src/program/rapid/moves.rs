//! The motion instructions: arguments → a move in the base frame.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::instructions::{ToolAt, Way};
use super::interpreter::{Interpreter, Last};
use super::syntax::{Args, Expr, Name};
use super::value::{Value, from_pose, has_external_axes, orientation, pose};
use crate::motion::{Circle, Load, Target};
use crate::notes::Code;
use crate::program::Pace;
use crate::units::{m_from_mm, m_per_s_from_mm_per_s, rad_from_deg};

/// Up to this mass, kg, a load says nothing: ABB's own templates have it where none is known.
const PLACEHOLDER_KG: f64 = 0.001;

/// Joints that a jointtarget has.
const ROBOT_AXES: usize = 6;

impl<'a> Interpreter<'a> {
    /// Runs a motion instruction.
    pub(super) fn motion(
        &mut self,
        line: usize,
        name: &Name,
        way: Way,
        tool_at: ToolAt,
        args: &'a Args,
    ) -> Result<(), String> {
        let options = self.options(args);
        let option =
            |wanted: &str| options.iter().find(|(name, _)| name == wanted).map(|(_, value)| value);
        let at = |index: usize, what: &str| {
            args.positional.get(index).ok_or_else(|| format!("{what} is missing"))
        };
        let targets = if way == Way::Circular { 2 } else { 1 };
        let tool = match tool_at {
            ToolAt::Index(index) => at(index, "the tool")?,
            ToolAt::Last => args.positional.last().ok_or("the tool is missing")?,
        };
        let tcp = self.tool_centre_point(line, tool)?;
        self.note_load(line, tool, option("tload"));
        let speed_arg = at(targets, "the speed")?;
        let first = self.eval(at(0, "the target")?);
        if way == Way::AbsoluteJoints {
            let joints = self.joints(line, &first)?;
            if option("t").is_some() {
                self.log.warning(
                    Code::LeftOut,
                    line,
                    format!("{} \\T: the time is not used", name.shown),
                );
            }
            let pace = self.pace(line, speed_arg, option("v"))?;
            self.log.motion(line, Target::Joints(joints), tcp, pace);
            self.last = None;
            return Ok(());
        }
        let work_object = self.work_object(line, option("wobj"))?;
        let first = self.target(line, &first, &work_object)?;
        let (via, end) = if way == Way::Circular {
            let end = self.eval(at(1, "the end of the arc")?);
            (Some(first), self.target(line, &end, &work_object)?)
        } else {
            (None, first)
        };
        let timed = option("t").map(Value::num).transpose()?;
        let pace = match (timed, self.last) {
            (Some(seconds), Some(last)) => {
                if way == Way::Joint {
                    let what = "MoveJ \\T: the path is taken to be as long as the straight line";
                    self.log.warning(Code::Assumed, line, what);
                }
                self.log.feed(false);
                Pace::Feed(timed_feed(seconds, &last.with(&tcp), via.as_ref(), &end)?)
            }
            (Some(_), _) => {
                self.log.warning(
                    Code::Assumed,
                    line,
                    format!(
                        "{} \\T: the length of the path is not known, the speed is used",
                        name.shown
                    ),
                );
                self.pace(line, speed_arg, option("v"))?
            }
            (None, _) => self.pace(line, speed_arg, option("v"))?,
        };
        let to = match (way, via) {
            (_, Some(via)) => Target::Arc { via, end },
            (Way::Joint, None) => Target::JointsTo(end),
            (_, None) => Target::Line(end),
        };
        self.log.motion(line, to, tcp, pace);
        self.last = Some(Last { at: end, tcp });
        Ok(())
    }

    /// `CRobT()`: the last target, in the work object and with the tool asked for.
    pub(super) fn current_target(&mut self, options: &[(String, Value)]) -> Result<Value, String> {
        let last = self.last.ok_or("CRobT: the robot's position is known only at run time")?;
        let find = |wanted: &str| options.iter().find(|(name, _)| name == wanted);
        let tcp = match find("tool") {
            Some((_, tool)) => self.frame_of_tool(tool)?.unwrap_or(last.tcp),
            None => last.tcp,
        };
        let work_object = match find("wobj") {
            Some((_, object)) => frame_of_work_object(object)?,
            None => None,
        };
        let work_object = work_object.or(self.settings.work_object).unwrap_or_default();
        let at = work_object.inverse() * last.with(&tcp);
        let [translation, rotation] = from_pose(&at);
        let external = Value::nums(&[9e9; ROBOT_AXES]);
        Ok(Value::List(vec![translation, rotation, Value::nums(&[0.0; 4]), external]))
    }

    /// A robtarget in the base frame.
    fn target(
        &mut self,
        line: usize,
        value: &Value,
        work_object: &Isometry3<f64>,
    ) -> Result<Isometry3<f64>, String> {
        let target = pose(value).map_err(|why| format!("target: {why}"))?;
        if let Value::List(parts) = value {
            self.note_external_axes(line, parts.get(3));
        }
        Ok(work_object * target)
    }

    fn joints(&mut self, line: usize, value: &Value) -> Result<Vec<f64>, String> {
        let degrees: [f64; ROBOT_AXES] = value
            .part(0, "a jointtarget")
            .and_then(|axes| axes.numbers("the robot's axes"))
            .map_err(|why| format!("target: {why}"))?;
        if self.settings.joint_count != ROBOT_AXES {
            return Err(format!(
                "a jointtarget has {ROBOT_AXES} axes, the robot has {} moving joints",
                self.settings.joint_count
            ));
        }
        if let Value::List(parts) = value {
            self.note_external_axes(line, parts.get(1));
        }
        Ok(degrees.map(rad_from_deg).to_vec())
    }

    fn note_external_axes(&mut self, line: usize, external: Option<&Value>) {
        if has_external_axes(external) {
            self.log.warning(
                Code::AxisIgnored,
                line,
                "targets place external axes: these are taken to stand still",
            );
        }
    }

    /// The tool's frame in the tip frame, or `None` for tool0.
    fn frame_of_tool(&self, tool: &Value) -> Result<Option<Isometry3<f64>>, String> {
        if *tool == Value::Tool0 {
            return Ok(None);
        }
        if !tool.part(0, "a tool")?.bool()? {
            return Err("a stationary tool (robhold FALSE) is not supported".to_owned());
        }
        pose(tool.part(1, "a tool frame")?).map(Some)
    }

    fn tool_centre_point(&mut self, line: usize, expr: &'a Expr) -> Result<Isometry3<f64>, String> {
        let tool = self.eval(expr);
        match (&tool, self.settings.tcp) {
            (Value::Tool0, tcp) => Ok(tcp.unwrap_or_default()),
            (Value::Unknown(why), Some(tcp)) => {
                self.log.warning(
                    Code::Assumed,
                    line,
                    format!("tool: {why}; the job's tcp is used"),
                );
                Ok(tcp)
            }
            (Value::Unknown(why), None) => Err(format!("tool: {why}; give the tcp in the job")),
            (_, tcp) => {
                if tcp.is_some() {
                    let what = "the program declares its tool: the job's tcp is not used there";
                    self.log.warning(Code::FrameFromProgram, line, what);
                }
                let frame = self.frame_of_tool(&tool).map_err(|why| format!("tool: {why}"))?;
                Ok(frame.unwrap_or_default())
            }
        }
    }

    /// What the tip carries with this tool: its own load, or that of `\TLoad`. `tool0` and a load
    /// without mass say nothing.
    fn note_load(&mut self, line: usize, expr: &'a Expr, total: Option<&Value>) {
        let tool = self.eval(expr);
        let own = tool.part(2, "a load").ok();
        let (name, line) = match expr {
            Expr::Ref(path) => {
                let declared = self.file.data.get(&path.name.key);
                (path.name.shown.clone(), declared.map_or(line, |data| data.line))
            }
            _ => ("of the instruction".to_owned(), line),
        };
        let load = total.or(own).and_then(|value| load(value, name, line).ok().flatten());
        self.log.load(load.map(Arc::new).as_ref());
    }

    fn work_object(
        &mut self,
        line: usize,
        given: Option<&Value>,
    ) -> Result<Isometry3<f64>, String> {
        match (given.unwrap_or(&Value::Wobj0), self.settings.work_object) {
            (Value::Wobj0, frame) => {
                if given.is_some() && frame.is_some() {
                    self.log.warning(
                        Code::Assumed,
                        line,
                        "wobj0 is named: the job's work_object is used for it",
                    );
                }
                Ok(frame.unwrap_or_default())
            }
            (Value::Unknown(why), Some(frame)) => {
                self.log.warning(
                    Code::Assumed,
                    line,
                    format!("work object: {why}; the job's work_object is used"),
                );
                Ok(frame)
            }
            (Value::Unknown(why), None) => {
                Err(format!("work object: {why}; give the work_object in the job"))
            }
            (object, frame) => {
                if frame.is_some() {
                    self.log.warning(
                        Code::FrameFromProgram,
                        line,
                        "the program declares its work object: the job's work_object is not used \
                         there",
                    );
                }
                let frame = frame_of_work_object(object);
                Ok(frame.map_err(|why| format!("work object: {why}"))?.unwrap_or_default())
            }
        }
    }

    /// Speed of the tool centre point, of a speeddata and `\V` in mm/s.
    fn pace(&mut self, line: usize, expr: &'a Expr, speed: Option<&Value>) -> Result<Pace, String> {
        let data = self.eval(expr);
        if let Expr::Ref(path) = expr
            && path.name.key == "vmax"
        {
            self.log.warning(Code::Assumed, line, "vmax is taken as 5000 mm/s");
        }
        let mm_per_s = match (speed, &data) {
            (Some(speed), _) => speed.num().map_err(|why| format!("speed: {why}"))?,
            (None, Value::Unknown(why)) => {
                self.log.warning(
                    Code::Assumed,
                    line,
                    format!("speed: {why}; the job's feed is used"),
                );
                return Ok(Pace::Unstated);
            }
            (None, data) => data
                .part(0, "a speeddata")
                .and_then(Value::num)
                .map_err(|why| format!("speed: {why}"))?,
        };
        let (share, limit) = self.velocity;
        let mm_per_s = (mm_per_s * share).min(limit);
        if mm_per_s > 0.0 && mm_per_s.is_finite() {
            self.log.feed(false);
            Ok(Pace::Feed(m_per_s_from_mm_per_s(mm_per_s)))
        } else {
            Err(format!("speed is {mm_per_s} mm/s, must be positive"))
        }
    }
}

/// A loaddata: mass, centre of mass in the wrist's frame, axes of moment about it, moments about
/// these; `None` where it has no mass.
fn load(value: &Value, name: String, line: usize) -> Result<Option<Load>, String> {
    let mass_kg = value.part(0, "a mass")?.num()?;
    if mass_kg <= PLACEHOLDER_KG {
        return Ok(None);
    }
    let com_mm: [f64; 3] = value.part(1, "a centre of mass")?.numbers("a centre of mass")?;
    let axes = orientation(value.part(2, "axes of moment")?)?.to_rotation_matrix();
    let mut moments = [0.0; 3];
    for (index, moment) in moments.iter_mut().enumerate() {
        *moment = value.part(3 + index, "a moment of inertia")?.num()?;
    }
    let inertia_kgm2 = axes * Matrix3::from_diagonal(&moments.into()) * axes.transpose();
    Ok(Some(Load { name, line, mass_kg, com_m: com_mm.map(m_from_mm).into(), inertia_kgm2 }))
}

/// uframe ∘ oframe in the base frame, or `None` for wobj0.
fn frame_of_work_object(object: &Value) -> Result<Option<Isometry3<f64>>, String> {
    if *object == Value::Wobj0 {
        return Ok(None);
    }
    if object.part(0, "a work object")?.bool()? {
        return Err("a work object that the robot holds is not supported".to_owned());
    }
    if !object.part(1, "a work object")?.bool()? {
        return Err("a moving work object (ufprog FALSE) is not supported".to_owned());
    }
    let user = pose(object.part(3, "a user frame")?)?;
    let frame = pose(object.part(4, "an object frame")?)?;
    Ok(Some(user * frame))
}

/// `\T`: the way divided by the time, m/s.
fn timed_feed(
    seconds: f64,
    from: &Isometry3<f64>,
    via: Option<&Isometry3<f64>>,
    to: &Isometry3<f64>,
) -> Result<f64, String> {
    let [from, to] = [from, to].map(|pose| pose.translation.vector);
    let way_m = match via {
        Some(via) => arc_length_m(from, via.translation.vector, to),
        None => (to - from).norm(),
    };
    let feed = way_m / seconds;
    if feed > 0.0 && feed.is_finite() {
        Ok(feed)
    } else {
        Err(format!("\\T:={seconds} s for {way_m} m is no speed"))
    }
}

/// Length of the arc of a circle from `a` through `b` to `c`, m; the chords' where they are in
/// line.
fn arc_length_m(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> f64 {
    match Circle::through(a, b, c) {
        Some(circle) => circle.length(),
        None => (b - a).norm() + (c - b).norm(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_are_as_long_as_their_angle_says() {
        let point = |deg: f64| {
            let angle = rad_from_deg(deg);
            Vector3::new(1.0 + 2.0 * angle.cos(), 2.0 * angle.sin(), 3.0)
        };
        for (via, end) in [(10.0, 30.0), (100.0, 190.0), (20.0, 300.0), (290.0, 350.0)] {
            let length = arc_length_m(point(0.0), point(via), point(end));
            assert!((length - 2.0 * rad_from_deg(end)).abs() < 1e-12, "{via} {end} {length}");
        }
        let straight = arc_length_m(Vector3::zeros(), Vector3::x(), Vector3::x() * 3.0);
        assert!((straight - 3.0).abs() < 1e-15);
    }
}
