//! The motion instructions of KRL, and what sets their speed, tool and base.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3};

use super::eval::AXES_AT_START;
use super::forms::{BASE, TOOL};
use super::frames::KEPT;
use super::run::{OfWorld, Run};
use super::shares::Shares;
use super::syntax::{Block, Expr, Motion, Path, Way, What};
use super::turns::Turns;
use super::value::{AXES, Parts, Value, base, frame, part};
use super::words::{is_harmless, is_without_effect};
use crate::motion::{Circle, Load, Target, Turning};
use crate::notes::Code;
use crate::program::log::Tool;
use crate::program::spindle_names::is_spindles;
use crate::units::{rad_from_deg, ratio_from_percent};

const POSITIONS_NOW: [&str; 4] = ["$axis_act", "$axis_act_meas", "$pos_act", "$pos_act_meas"];

/// LOAD_DATA of a controller.
const LOADS: usize = 16;

/// Speeds, orientation, tool and base, load.
type Kept = (
    (Option<f64>, Option<String>, Shares, [Option<f64>; 2]),
    Turns,
    (
        (Isometry3<f64>, Option<Tool>, Option<&'static str>),
        (Isometry3<f64>, Option<String>, Option<OfWorld>),
    ),
    Option<(String, [bool; 2])>,
    Option<Arc<Load>>,
);

impl<'a> Run<'a> {
    pub(super) fn assign(&mut self, line: usize, path: &'a Path, expr: &'a Expr) {
        let value = self.eval(expr);
        let key = self.key(path).unwrap_or_default();
        self.forget_sharing(&key);
        // A datum may round what it is set to.
        let declared = self.type_of(&key).filter(|_| path.fields.is_empty());
        let is_timed = self.timed.contains(&key) || self.timed.contains(base(&key));
        let is_datum = declared.is_some() && !is_timed;
        let held = if is_datum { value.clone().held_as(declared) } else { value.clone() };
        if self.sets_signal(line, &key, &held) {
            if is_datum && let Err(why) = self.write(path, value) {
                self.log.warning(Code::LeftOut, line, format!("assignment left out: {why}"));
            }
            return;
        }
        if self.set_numbered(line, path, expr) {
            return;
        }
        self.doubt_assignment(line, path, expr);
        if matches!(value, Value::Num(..) | Value::Unknown(_)) {
            self.doubt_undeclared(line, path, Some(expr));
        }
        if key.starts_with("$anout[") && !is_spindles(&path.name) {
            let value = value.clone().num().ok();
            self.analog.set(self.settings, self.log, line, &key, value);
        }
        match self.set_motion(line, path, &value) {
            Ok(true) => {}
            // Last by the program or by what the run decides.
            Ok(false) if is_timed => {
                let what =
                    format!("'{}' is set by a trigger, an interrupt or a pulse, too", path.name);
                self.forget(path, &what);
            }
            Ok(false) => {
                if let Err(why) = self.write(path, value) {
                    let what = format!("an element of '{}' was set: {why}", path.name);
                    self.forget_element(path, &what);
                    self.log.warning(Code::LeftOut, line, format!("assignment left out: {why}"));
                }
            }
            Err(why) => {
                let shown = path.name.to_uppercase();
                self.log.error(Code::Motion, line, format!("{shown}: {why}"));
            }
        }
    }

    /// System variables that motion depends on; whether it is one.
    fn set_motion(&mut self, line: usize, path: &'a Path, value: &Value) -> Result<bool, String> {
        let field = path.fields.first().map(String::as_str);
        match (path.name.as_str(), field) {
            ("$vel", Some("cp")) => self.set_velocity(line, value)?,
            ("$vel", None) => match value {
                Value::Parts(parts) => {
                    if let Some(value) = parts.get("cp") {
                        self.set_velocity(line, value)?;
                    }
                    for field in ["ori1", "ori2"] {
                        if let Some(value) = parts.get(field) {
                            self.set_turning(line, field, value)?;
                        }
                    }
                }
                other => self.set_velocity(line, other)?,
            },
            ("$vel", Some(field @ ("ori1" | "ori2"))) => self.set_turning(line, field, value)?,
            ("$vel", Some(_)) => {}
            ("$vel_axis" | "$vel_extax", _) => {
                let [index] = &*path.indices else {
                    return Err("the number of the axis is missing".to_owned());
                };
                let axis = self.eval(index).num()?;
                self.shares.set(path.name == "$vel_extax", axis, value.num()?)?;
            }
            ("$ori_type", _) => self.turns.set_type(value),
            ("$circ_type", _) => self.turns.set_arc(value),
            ("$ov_pro", _) => {
                let share = ratio_from_percent(value.num()?);
                if !(share > 0.0 && share <= 1.0) {
                    return Err("the override must be 1 to 100 %".to_owned());
                }
                self.over = share;
            }
            ("$tool", None) => {
                self.states(TOOL);
                self.tcp = self.own_tool(line, value)?;
                self.log.tcp_of(None);
            }
            ("$base", None) => {
                self.states(BASE);
                let frame = self.own_base(line, value)?;
                self.chooses_base(frame);
            }
            ("$tool", Some(field)) => self.tcp = self.with_component(TOOL, field, value)?,
            ("$base", Some(field)) => self.base = self.with_component(BASE, field, value)?,
            ("$load", None) => self.set_load(line, value),
            ("$load" | "$load_a1" | "$load_a2" | "$load_a3", _) => {
                let what = format!(
                    "{} changes what the arm carries and is not read: payload in the job says it",
                    path.name.to_uppercase()
                );
                self.log.warning(Code::ChangeIgnored, line, what);
            }
            ("$ipo_mode", _) => match value {
                Value::Enum(mode) if mode == "base" => {}
                _ => return Err("a stationary tool (#TCP) is not supported".to_owned()),
            },
            ("$robroot" | "$world" | "$corr", _) => {
                return Err("moves the robot's own frame and is not supported".to_owned());
            }
            ("$tech" | "$tech_c", _) if !matches!(value, Value::Enum(off) if off == "off") => {
                let what = "$TECH may change the path (weaving), which is not read";
                self.log.warning(Code::MotionLeftOut, line, what);
                return Ok(false);
            }
            (name, _) if changes_speed(name) => {
                let what = format!(
                    "{} may change how fast the arm moves and is not read",
                    name.to_uppercase()
                );
                self.log.warning(Code::ChangeIgnored, line, what);
                return Ok(false);
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// $VEL.ORI1, $VEL.ORI2, deg/s: how fast the tool's direction swivels, and how fast it turns
    /// about that. A turn is both in some proportion; the lower speed is taken for all of it.
    fn set_turning(&mut self, line: usize, field: &str, value: &Value) -> Result<(), String> {
        let index = usize::from(field == "ori2");
        let speed = match value.num() {
            Ok(speed) => speed,
            Err(why) => {
                let field = field.to_uppercase();
                let what = format!("$VEL.{field}: {why}; turns of the tool are not slowed by it");
                self.log.warning(Code::Assumed, line, what);
                self.turning[index] = None;
                return Ok(());
            }
        };
        if !(speed > 0.0 && speed.is_finite()) {
            return Err(format!("the speed of orientation is {speed} deg/s, must be positive"));
        }
        self.turning[index] = Some(rad_from_deg(speed));
        Ok(())
    }

    /// $LOAD: mass, centre of mass and axes of inertia in the flange, moments.
    pub(super) fn set_load(&mut self, line: usize, value: &Value) {
        let load = value.parts().map(|parts| load_of(parts, line));
        if let Err(why) = &load {
            let what = format!("what the arm carries is not known: $LOAD: {why}");
            self.log.warning(Code::ChangeIgnored, line, what);
        }
        self.log.load(load.ok().flatten().map(Arc::new).as_ref());
    }

    /// BAS(#…, n): the basic package of the controller.
    pub(super) fn bas(&mut self, line: usize, mut values: Vec<Value>) -> Result<(), String> {
        values.resize(2, Value::unknown("the number is missing"));
        let [Value::Enum(what), number] = values.as_slice() else {
            return Err("expected BAS(#…, number)".to_owned());
        };
        match what.as_str() {
            "initmov" => self.initialise(line),
            "acc_cp" | "acc_ptp" | "acc_glue" | "acc_gluecp" | "acc_ori" | "group" => Ok(()),
            "vel_cp" => self.set_basic_velocity(line, number),
            "vel_ptp" => self.set_basic_share(line, number),
            "tool" => {
                self.states(TOOL);
                self.choose_tool(line, number.num()?)
            }
            "base" => {
                self.states(BASE);
                self.chooses_base_number(number.num()?);
                Ok(())
            }
            "ptp_params" => {
                self.set_basic_share(line, number)?;
                self.frames_of_form(line)
            }
            "cp_params" => {
                self.turns_of_form();
                self.set_basic_velocity(line, number)?;
                self.frames_of_form(line)
            }
            "ptp_dat" => self.share_of_data(line),
            "cp_dat" => {
                self.velocity_of_data(line)?;
                self.turns_of_form();
                Ok(())
            }
            "frames" => self.frames_of_form(line),
            "ov_pro" => Err("#OV_PRO is no command of bas.src: write $OV_PRO=…".to_owned()),
            other => Err(format!("#{} is not understood", other.to_uppercase())),
        }
    }

    /// The basic package slows what is within its limit by DEF_VEL_FACT (bas.src, VEL_CP), where a
    /// file declares it.
    pub(super) fn set_basic_velocity(&mut self, line: usize, value: &Value) -> Result<(), String> {
        let allowed = self.basic_velocity(line, value)?;
        let (asked, run) = (value.num()?, allowed.num()?);
        match self.velocity_factor() {
            factor if run == asked && factor != 1.0 => {
                self.set_velocity(line, &Value::real(asked * factor))
            }
            _ => self.set_velocity(line, &allowed),
        }
    }

    fn velocity_factor(&mut self) -> f64 {
        self.datum("def_vel_fact").num().ok().filter(|factor| *factor > 0.0).unwrap_or(1.0)
    }

    /// #INITMOV: joints at full speed, DEF_VEL_CP, the world as the base, and tool 1 where it is
    /// known. A job that gives a work object may mean it for the base that no line of the program
    /// sets: what moves in it tells so.
    fn initialise(&mut self, line: usize) -> Result<(), String> {
        self.set_basic_share(line, &Value::real(100.0))?;
        let factor = self.velocity_factor();
        self.velocity = self.datum("def_vel_cp").num().ok().map(|velocity| velocity * factor);
        self.velocity.into_iter().for_each(|velocity| self.doubt_velocity(line, velocity));
        self.unsure_velocity = None;
        self.turning = ["def_vel_ori1", "def_vel_ori2"]
            .map(|key| self.datum(key).num().ok().map(rad_from_deg));
        self.starts_in_world();
        self.turns = self.usual_turns();
        self.unknown_form = None;
        // Where there is none the robot has its flange until it is told another.
        match self.take_tool(1.0) {
            Ok(()) => self.acts("$act_tool", 1.0),
            Err(_) => {
                self.globals.remove("$act_tool");
                self.unsure_tool = Some(KEPT).filter(|_| self.tcp != Isometry3::identity());
            }
        }
        self.globals.remove("$act_base");
        Ok(())
    }

    /// SPLINE … ENDSPLINE: lines and arcs in it are that; SPL goes straight to its points here.
    pub(super) fn spline(&mut self, line: usize, with: &'a [(Path, Expr)], block: &'a Block) {
        let kept = self.kept();
        self.apply(line, with);
        for statement in block {
            let line = self.enter(statement.file, statement.line);
            match &statement.what {
                What::Move(motion) => {
                    if let Err(why) = self.motion(line, motion) {
                        self.log.error(Code::Motion, line, why);
                    }
                }
                What::Call(name, _) if is_harmless(name) => {}
                What::Trigger(action) => self.trigger(line, action.as_deref()),
                What::Assign(path, expr) => self.assign(line, path, expr),
                What::NotUnderstood(why) => {
                    self.log.error(Code::Syntax, line, why.clone());
                }
                _ => {
                    let what = "is not understood within SPLINE";
                    self.log.error(Code::Motion, line, what);
                }
            }
        }
        self.keep(kept);
    }

    /// What WITH sets for a motion.
    fn apply(&mut self, line: usize, with: &'a [(Path, Expr)]) {
        for (path, expr) in with {
            let value = self.eval(expr);
            if is_without_effect(&path.name) {
                continue;
            }
            // SLOAD(n) is LOAD_DATA[n]: where no file has any, the job says what is carried.
            let mut is_of_cell = || {
                let mut all = (1..=LOADS).map(|n| self.datum(&format!("load_data[{n}]")));
                all.all(|load| matches!(load, Value::Unknown(_)))
            };
            let is_by_number = match expr {
                Expr::Call(name, _) => name == "sload",
                Expr::Ref(path) => path.name == "load_data",
                _ => false,
            };
            if path.name == "$load"
                && matches!(value, Value::Unknown(_))
                && is_by_number
                && is_of_cell()
            {
                self.log.load(None);
                continue;
            }
            if self.set_numbered(line, path, expr) {
                continue;
            }
            // What forms write for axis 1 holds for all of them.
            let set = match path.name.as_str() {
                "$vel_axis" => self.set_joint_share(&value),
                _ => self.set_motion(line, path, &value).map(drop),
            };
            if let Err(why) = set {
                let shown = path.name.to_uppercase();
                self.log.error(Code::Motion, line, format!("WITH {shown}: {why}"));
            }
        }
    }

    /// What WITH may set for a motion.
    fn kept(&self) -> Kept {
        let unsure = self.unsure_velocity.clone();
        let speeds = (self.velocity, unsure, self.shares, self.turning);
        let tool = (self.tcp, self.log.tool_of_tcp(), self.unsure_tool);
        let frames = (tool, (self.base, self.no_base.clone(), self.of_world));
        (speeds, self.turns, frames, self.unknown_form.clone(), self.log.carried())
    }

    fn keep(&mut self, kept: Kept) {
        let (speeds, tool, base, load);
        (speeds, self.turns, (tool, base), self.unknown_form, load) = kept;
        (self.base, self.no_base, self.of_world) = base;
        (self.tcp, self.unsure_tool) = (tool.0, tool.2);
        self.log.tcp_of(tool.1);
        self.log.load(load.as_ref());
        (self.velocity, self.unsure_velocity, self.shares, self.turning) = speeds;
    }

    pub(super) fn motion(&mut self, line: usize, motion: &'a Motion) -> Result<(), String> {
        if self.is_skipped(line, motion) {
            // What WITH sets holds for the move alone; functions in it may do more.
            motion.with.iter().for_each(|(_, expr)| drop(self.eval(expr)));
            return Ok(());
        }
        let kept = self.kept();
        self.apply(line, &motion.with);
        let done = self.motion_inside(line, motion);
        if !motion.with.is_empty() {
            self.keep(kept);
        }
        done
    }

    /// Whether a motion goes nowhere, or to the home position of the cell, which no file gives.
    fn is_skipped(&mut self, line: usize, motion: &'a Motion) -> bool {
        let [Expr::Ref(path)] = motion.targets.as_slice() else { return false };
        // To where it is.
        if POSITIONS_NOW.contains(&path.name.as_str()) {
            return true;
        }
        if !(self.has_left || self.log.has_moved())
            && matches!(self.read(path), Value::Unknown(why) if why == AXES_AT_START)
        {
            return true;
        }
        let is_home = path.name.starts_with("xhome") || path.name.starts_with("home");
        let is_unknown = is_home && matches!(self.read(path), Value::Unknown(_));
        if is_unknown {
            (self.joints, self.has_left) = (None, true);
            let home = path.name.to_uppercase();
            self.log.leaves(line, &format!("PTP {home}"));
            self.unmoved.home.get_or_insert((line, home));
        }
        is_unknown
    }

    fn motion_inside(&mut self, line: usize, motion: &'a Motion) -> Result<(), String> {
        let turning = self.turning.into_iter().flatten().reduce(f64::min);
        self.log.turns_at(turning.map(|speed| speed * self.over));
        let values: Vec<Value> = motion.targets.iter().map(|expr| self.eval(expr)).collect();
        let last = values.last().ok_or("the target is missing")?;
        let parts = last.parts().map_err(|why| format!("target: {why}"))?;
        self.external_axes(parts, motion.is_relative)?;
        if AXES.iter().any(|axis| parts.contains_key(*axis)) {
            if motion.way != Way::Joint {
                return Err("a line or arc to joint positions".to_owned());
            }
            let q = self.joint_target(parts, motion.is_relative)?;
            if let Some((why, _)) = &self.unknown_form {
                self.log.warning(Code::ChangeIgnored, line, why.clone());
            }
            let pace = self.joint_pace(line);
            self.log.configure(None);
            let q = self.external.joints(&q.map(rad_from_deg))?;
            let tip = self.settings.tip_at.as_ref().and_then(|tip| tip.at(&q));
            self.log.motion(line, Target::Joints(q), self.tcp, pace);
            tip.into_iter().for_each(|tip| self.log.stands_at(tip, self.tcp));
            return Ok(());
        }
        if let Some((why, _)) = &self.unknown_form {
            return Err(why.clone());
        }
        self.tell_of_tool(line);
        let end = self.target(parts, motion)?;
        // The controller turns the arm on PTP alone.
        let asked = (motion.way == Way::Joint).then(|| self.configuration(parts)).flatten();
        let has = |name: &str| parts.contains_key(name);
        if motion.way == Way::Joint && asked.is_none() && has("s") && self.log.has_moved() {
            let what = "S without T: which arm configuration it asks for is not read, and the \
                        nearest is taken";
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        self.log.configure(asked);
        let to = match motion.way {
            Way::Joint => Target::JointsTo(end),
            Way::Linear => Target::Line(self.turned(line, end)),
            Way::Spline => {
                let what = "SPL goes through its points on a curve that is taken to be straight \
                            between them";
                self.log.warning(Code::Assumed, line, what);
                Target::Line(self.turned(line, end))
            }
            Way::Circular => {
                self.doubt_arc(line);
                let end = self.turned(line, end);
                let via = values.first().ok_or("the auxiliary point is missing")?;
                let via = via.parts().map_err(|why| format!("auxiliary point: {why}"))?;
                let via = self.target(via, motion)?;
                return self.arc(line, via, end, motion.angle.as_ref());
            }
        };
        let is_joint = motion.way == Way::Joint;
        let pace = if is_joint { self.joint_pace(line) } else { self.path_pace(line) };
        self.log.motion(line, to, self.tcp, pace);
        self.joints = None;
        Ok(())
    }

    /// An arc; CA says how far it goes on, whatever the end.
    fn arc(
        &mut self,
        line: usize,
        via: Isometry3<f64>,
        end: Isometry3<f64>,
        angle: Option<&'a Expr>,
    ) -> Result<(), String> {
        let pace = self.path_pace(line);
        self.joints = None;
        // The orientation of the point on the way does not count: the tool goes the short way.
        let from = self.log.last().map(|last| last.with(&self.tcp));
        let via = match from.map(|from| from.rotation.inverse() * end.rotation) {
            Some(turn) => {
                let half = nalgebra::UnitQuaternion::from_scaled_axis(turn.scaled_axis() * 0.5);
                let start = from.unwrap_or_default().rotation;
                Isometry3::from_parts(via.translation, start * half)
            }
            None => via,
        };
        let Some(angle) = angle else {
            self.log.motion(
                line,
                Target::Arc { via, end, turning: Turning::ToEnd },
                self.tcp,
                pace,
            );
            return Ok(());
        };
        let angle = rad_from_deg(self.eval(angle).num()?);
        let from = from.ok_or("an arc from an unknown position")?;
        let [a, b, c] = [from, via, end].map(|pose| pose.translation.vector);
        let circle = Circle::through(a, b, c).ok_or("the arc's points lie on one line")?;
        if !(angle.abs() > 1e-6 && angle.abs() < 100.0) {
            return Err("CA is no angle for an arc".to_owned());
        }
        let pieces = (angle.abs() / std::f64::consts::PI).ceil();
        let turn = from.rotation.inverse() * end.rotation;
        let at = |share: f64| {
            let point = circle.at(share * angle / circle.angle());
            let turned = from.rotation
                * nalgebra::UnitQuaternion::from_scaled_axis(turn.scaled_axis() * share);
            Isometry3::from_parts(point.into(), turned)
        };
        for piece in 0..pieces as usize {
            let share = |part: f64| (piece as f64 + part) / pieces;
            let (via, end) = (at(share(0.5)), at(share(1.0)));
            self.log.motion(
                line,
                Target::Arc { via, end, turning: Turning::ToEnd },
                self.tcp,
                pace,
            );
        }
        Ok(())
    }
}

/// Whether a system variable that is not read may change how fast the arm moves.
fn changes_speed(name: &str) -> bool {
    let is_of_system = name.starts_with('$') && !is_without_effect(name);
    is_of_system && ["vel", "speed", "$ov_"].iter().any(|part| name.contains(part))
}

/// {M 5, CM {X …}, J {X …}}; `None` where it has no mass.
fn load_of(parts: &Parts, line: usize) -> Option<Load> {
    let mass_kg = part(parts, "m").ok().flatten().filter(|mass| *mass > 1e-3)?;
    let centre = frame(parts.get("cm")?.parts().ok()?).ok()?;
    let moments = match parts.get("j") {
        Some(Value::Parts(j)) => {
            ["x", "y", "z"].map(|axis| part(j, axis).ok().flatten().unwrap_or(0.0))
        }
        _ => [0.0; 3],
    };
    let axes = centre.rotation.to_rotation_matrix();
    let inertia_kgm2 = axes * Matrix3::from_diagonal(&moments.into()) * axes.transpose();
    let com_m = centre.translation.vector;
    Some(Load {
        name: "$LOAD".to_owned(),
        line,
        mass_kg,
        com_m,
        inertia_kgm2,
        is_placeholder: false,
    })
}
