//! The motion instructions: arguments → a move in the frame of the work.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Isometry3;

use super::carried::{Holds, WorkObject};
use super::constants::VMAX_MM_PER_S;
use super::instructions::{Motion, TOGETHER, ToolAt, Way};
use super::interpreter::Interpreter;
use super::number::Number;
use super::syntax::{Args, Expr, Name, Path};
use super::value::{NO_AXIS, Value, from_pose, pose};
use super::walk::Named;
use super::why::Why;
use crate::motion::{Configuration, Target, Turning, Work};
use crate::notes::Code;
use crate::program::log::States;
use crate::program::span::Span;
use crate::program::{Pace, Settings};
use crate::units::{deg_from_rad, m_per_s_from_mm_per_s, rad_from_deg};

/// Joints that a jointtarget has.
const ROBOT_AXES: usize = 6;

/// Why the configuration of where the arm is is not known; the path goes on in it.
const OF_THE_RUN: &str = "the arm configuration is that of the run";

/// External axes in the order of extjoint.
const EXTERNAL: [&str; ROBOT_AXES] = ["eax_a", "eax_b", "eax_c", "eax_d", "eax_e", "eax_f"];

impl<'a> Interpreter<'a> {
    /// Runs a motion instruction.
    pub(super) fn motion(
        &mut self,
        line: usize,
        motion: Motion,
        args: &'a Args,
    ) -> Result<(), String> {
        let Motion { way, takes_v, .. } = motion;
        self.motions += 1;
        let options = self.options(args);
        let option =
            |wanted: &str| options.iter().find(|(name, _)| name == wanted).map(|(_, value)| value);
        let at = |index: usize, what: &str| {
            args.positional.get(index).ok_or_else(|| format!("{what} is missing"))
        };
        let targets = if way == Way::Circular { 2 } else { 1 };
        let tool = match motion.tool {
            ToolAt::Index(index) => at(index, "the tool")?,
            ToolAt::Last => args.positional.last().ok_or("the tool is missing")?,
        };
        let (tcp, holds) = self.tool_centre_point(line, tool)?;
        let zone = args.positional.iter().take_while(|own| !std::ptr::eq(*own, tool)).last();
        let stops = match option("inpos") {
            Some(data) => data.part(1, "stoppointdata").and_then(Value::bool) == Ok(true),
            None => zone.is_some_and(|zone| self.stops(zone)),
        };
        self.names_tool(line, tool, args);
        if holds == Holds::Work {
            let what = "the tool stands (robhold FALSE): the tip carries the gripper with the \
                        work, and the tool's stand is taken as rigid";
            self.log.warning(Code::Assumed, line, what);
        }
        if option("id").is_some() {
            self.doubt_change(line, "\\ID", TOGETHER);
        }
        if option("corr").is_some() {
            let what = "\\Corr: the arm goes where a sensor corrects the path to (CorrWrite), \
                        which is not read: the path is checked as it is programmed; leave \\Corr \
                        out of a copy of the program where nothing corrects it";
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        self.external.move_begins();
        let speed_arg = at(targets, "the speed")?;
        let first = self.eval(at(0, "the target")?);
        // A target that asks where the arm is asks before the move.
        let end = match way {
            Way::Circular => Some(self.eval(at(1, "the end of the arc")?)),
            _ => None,
        };
        self.begin_move(stops, option("conc").is_some());
        if way == Way::AbsoluteJoints {
            let joints = self.joints(&first)?;
            self.log.configure(None);
            let is_moved =
                |object: &Value| object.part(1, "a work object").and_then(Value::bool) == Ok(false);
            let counts = option("wobj").is_some_and(|own| holds == Holds::Work || is_moved(own));
            let object =
                counts.then(|| self.work_object(line, option("wobj"), args)).transpose()?;
            let (work, gripped_in) = match (holds, object) {
                (Holds::Tool, None) => (Work::Stands, Some(tcp)),
                (Holds::Tool, Some(object)) => (self.work(line, holds, &object)?, Some(tcp)),
                (Holds::Work, None) => (Work::Held, None),
                (Holds::Work, Some(object)) => {
                    (self.work(line, holds, &object)?, Some(object.frame))
                }
            };
            self.note_load(line, tool, gripped_in.as_ref(), args);
            self.log.work(work);
            // Its pose is not worked out, so that no frame is asked for.
            self.active_object = WorkObject::default();
            let (from, to) = (self.joints_now, self.six_axes(&first));
            self.joints_now = to;
            // The wrist turns the tool; how long the way is, is not worked out.
            let way = from.zip(to).map(|(from, to)| {
                let turns = from.iter().zip(&to).skip(3).map(|(from, to)| (to - from).abs());
                (0.0, rad_from_deg(turns.fold(0.0, f64::max)))
            });
            let timed = (option("t"), option("v"));
            let pace = self.timed_pace(line, (speed_arg, takes_v), timed, way, args)?;
            self.log.motion(line, Target::Joints(joints), tcp, pace);
            self.dwell_at_end(line, option("inpos"));
            return Ok(());
        }
        self.tell_own_frames(line, way, tool, option("wobj"));
        let object = self.work_object(line, option("wobj"), args)?;
        let place = self.target(&first, &object.frame)?;
        let (last, to) = match (end, way) {
            (Some(end), _) => {
                let to = self.target(&end, &object.frame)?;
                (end, Target::Arc { via: place, end: to, turning: self.turning_of(line) })
            }
            (None, Way::Joint) => (first, Target::JointsTo(place)),
            (None, _) => (first, Target::Line(place)),
        };
        let asked = self.monitors[usize::from(way != Way::Joint)];
        if asked {
            self.doubt_configuration(line, &last);
        }
        let asked = asked.then(|| self.configuration(&last)).flatten();
        self.log.configure(asked);
        let gripped_in = if holds == Holds::Tool { tcp } else { object.frame };
        self.note_load(line, tool, Some(&gripped_in), args);
        let work = self.work(line, holds, &object)?;
        let way = self.log.last().map(|last| {
            let from = last.seen_from(&work, &tcp);
            let end = if let Target::Arc { end, .. } = &to { end } else { &place };
            let along = end.translation.vector - from.translation.vector;
            (along.norm(), from.rotation.angle_to(&end.rotation))
        });
        self.log.work(work);
        (self.active_object, self.joints_now) = (object, None);
        let timed = (option("t"), option("v"));
        let pace = self.timed_pace(line, (speed_arg, takes_v), timed, way, args)?;
        self.log.motion(line, to, tcp, pace);
        self.dwell_at_end(line, option("inpos"));
        Ok(())
    }

    /// Tells of tool0 and wobj0 where the job gives a frame that stands for others: a doubt where
    /// the tool is led, and the job may mean it for these.
    fn tell_own_frames(
        &mut self,
        line: usize,
        way: Way,
        tool: &'a Expr,
        work_object: Option<&Value>,
    ) {
        // Each in words of its own: the same words are told once.
        let (code, shown) = match way {
            Way::Joint => (Code::Assumed, "a joint move"),
            _ => (Code::ChangeIgnored, "a line or arc"),
        };
        if way != Way::Joint {
            self.note_led(line, tool, work_object);
        }
        let Named { tool: for_tools, work_object: for_objects } = self.stands_for;
        let is_tool0 = for_tools && self.eval(tool) == Value::Tool0;
        let is_wobj0 = matches!(work_object, None | Some(Value::Wobj0));
        for (is_told, name, of_job) in [
            (is_tool0 && self.settings.tcp.is_some(), "tool0", "tcp"),
            (
                for_objects && is_wobj0 && self.settings.work_object.is_some(),
                "wobj0",
                "work_object",
            ),
        ] {
            if is_told {
                let what = format!(
                    "{shown} with {name}: that is the controller's own, as the job's {of_job} \
                     stands for what no file that is read declares; path.program.files can name \
                     the file that does"
                );
                self.log.warning(code, line, what);
            }
        }
    }

    /// The time of `\T`, or the speed, behind which `\V` may stand or not, of a way.
    fn timed_pace(
        &mut self,
        line: usize,
        speed: (&'a Expr, bool),
        (time, own_speed): (Option<&Value>, Option<&Value>),
        way: Option<(f64, f64)>,
        args: &'a Args,
    ) -> Result<Pace, String> {
        let own = args.optional_value("v");
        match time.map(Value::num).transpose()? {
            Some(seconds) if seconds > 0.0 && seconds.is_finite() => {
                let span = args.optional_value("t").and_then(|expr| self.literal(expr));
                self.log.states(line, span, States::Seconds { value: seconds });
                self.log.external_needs(0.0);
                // VelSet and SpeedRefresh slow timed moves, too.
                Ok(Pace::Seconds(seconds / (self.velocity.0 * self.over)))
            }
            Some(seconds) => Err(format!("\\T:={seconds} s is no time for a move")),
            None => {
                let own = own_speed.map(|value| (value, own));
                let (pace, data) = self.pace(line, speed, own)?;
                self.doubt_time(line, &data, pace, way);
                Ok(pace)
            }
        }
    }

    /// Whether a name is that of a datum of the routine that runs.
    fn is_own(&self, path: &Path) -> bool {
        self.frames.last().is_some_and(|frame| frame.contains_key(&path.name.key))
    }

    /// The number in the text that an expression is: itself, or that of a declaration in the
    /// module.
    pub(super) fn literal(&self, expr: &'a Expr) -> Option<Span> {
        match expr {
            Expr::Number(_, span) => *span,
            Expr::Ref(path) if path.is_whole() && !self.is_own(path) => {
                let declared = self.file.data.get(&path.name.key)?.value.as_ref()?;
                match declared {
                    Expr::Number(_, span) => *span,
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// What the text states where an expression gives a speeddata.
    fn speed_word(&self, expr: &'a Expr, mm_per_s: f64, takes_v: bool) -> (Option<Span>, States) {
        let first = |list: &Expr| match list {
            Expr::List(items) => match items.first() {
                Some(Expr::Number(_, span)) => *span,
                _ => None,
            },
            _ => None,
        };
        let feed = States::Feed { value: mm_per_s };
        match expr {
            // What the routine was called with, or has worked out.
            Expr::Ref(path) if self.is_own(path) => (None, feed),
            Expr::Ref(path) if path.is_whole() => match self.file.data.get(&path.name.key) {
                Some(declared) => (declared.value.as_ref().and_then(first), feed),
                None => (path.span, States::NamedFeed { mm_per_s, takes_v }),
            },
            list => (first(list), feed),
        }
    }

    /// How the tool turns on an arc.
    fn turning_of(&mut self, line: usize) -> Turning {
        self.turning.unwrap_or_else(|| {
            let what = "CirPathMode is not known here, or is one of the wrist: the tool is taken \
                        to turn with the arc";
            self.log.warning(Code::AxisIgnored, line, what);
            Turning::WithArc
        })
    }

    /// Where the external axes are, as a target has them.
    fn where_external(&self) -> Value {
        let at = |name: &str| match self.external.stands_at(name) {
            Some(at) => Number::of(at).opened(),
            None => Number::of(9e9),
        };
        Value::List(EXTERNAL.map(|name| Value::Num(at(name))).to_vec())
    }

    /// `CJointT()`: the joints of the last target.
    pub(super) fn current_joints(&self) -> Result<Value, String> {
        const WHY: &str = "CJointT: the joints are known behind MoveAbsJ alone, as the reader does \
                           not work them out";
        let joints = match self.joints_now {
            Some(joints) => Value::nums(&joints).opened(),
            // Where the external axes are the targets say.
            None if self.log.has_moved() => Value::unknown(WHY),
            None => return Err(WHY.to_owned()),
        };
        Ok(Value::List(vec![joints, self.where_external()]))
    }

    /// Whether a zone is that of a stop: `fine`, or zonedata that say so.
    fn stops(&mut self, zone: &'a Expr) -> bool {
        self.eval(zone).part(0, "zonedata").and_then(Value::bool) == Ok(true)
    }

    /// Tells where the program asks for where the arm is while it moves on.
    pub(super) fn doubt_where(&mut self, function: &Name) {
        if !self.has_arrived && self.log.has_moved() {
            let what = format!(
                "{} asks for where the arm is behind a move for whose end the program does not \
                 wait (fine, without \\Conc): the end of that move is taken",
                function.shown
            );
            self.log.warning(Code::MotionLeftOut, self.line, what);
        }
    }

    /// `CRobT()`: the last target, in the work object and with the tool asked for, or with those of
    /// the motion before.
    pub(super) fn current_target(
        &mut self,
        args: &'a Args,
        options: &[(String, Value)],
    ) -> Result<Value, String> {
        let Some(last) = self.log.last() else {
            if !self.log.has_moved() {
                return Err("the robot's position is known only at run time".to_owned());
            }
            // Where the external axes are a jointtarget says.
            let why = "the pose behind a motion to joints is not worked out by the reader";
            let [at, turned] = [Value::unknown(why), Value::unknown(why)];
            let found = Value::unknown(OF_THE_RUN);
            return Ok(Value::List(vec![at, turned, found, self.where_external()]));
        };
        let find = |wanted: &str| options.iter().find(|(name, _)| name == wanted);
        let line = self.line;
        let is_own = find("tool").is_none() || find("wobj").is_none();
        if let Some(why) = self.why_not_active().filter(|_| is_own) {
            return Err(why);
        }
        let (tcp, holds) = match find("tool") {
            Some((_, tool)) => self.tcp_of(line, args.optional_value("tool"), tool)?,
            None => {
                let holds = if last.holds_work { Holds::Work } else { Holds::Tool };
                self.active_tool.unwrap_or((last.tcp, holds))
            }
        };
        let object = match find("wobj") {
            Some((_, object)) => self.work_object(line, Some(object), args)?,
            None => self.active_object.clone(),
        };
        let work = self.work_behind(line, holds, &object, false)?.ended();
        let at = object.frame.inverse() * last.seen_from(&work, &tcp);
        // It is measured.
        let [translation, rotation] = from_pose(&at).map(Value::opened);
        let external = self.where_external();
        let found = Value::unknown(OF_THE_RUN);
        Ok(Value::List(vec![translation, rotation, found, external]))
    }

    /// A robtarget in the frame of the work.
    fn target(&mut self, value: &Value, object: &Isometry3<f64>) -> Result<Isometry3<f64>, String> {
        let target = pose(value);
        let target = target.map_err(|why| format!("target: {why}{}", self.who_sets(value)))?;
        if let Value::List(parts) = value {
            self.external_axes(parts.get(3))?;
        }
        Ok(object * target)
    }

    /// What may set a target to which nothing that is read has given a place.
    fn who_sets(&self, value: &Value) -> String {
        let at = value.part(0, "a robtarget").and_then(|own| own.numbers("a place"));
        let turned = value.part(1, "a robtarget").and_then(|own| own.numbers("an orientation"));
        match (at, turned, &self.called_elsewhere) {
            (Ok([0.0, 0.0, 0.0]), Ok([0.0, 0.0, 0.0, 0.0]), Some(shown)) => format!(
                "; nothing that is read sets it, and '{shown}', which is in no file, may: \
                 path.program.files in the job can name its file"
            ),
            _ => String::new(),
        }
    }

    /// The quadrants of axes 1, 4 and 6 of a robtarget. cfx is not read.
    fn configuration(&self, target: &Value) -> Option<Configuration> {
        let robconf = target.part(2, "a confdata").ok()?;
        let quadrants: [f64; 4] = robconf.numbers("a confdata").ok()?;
        let arm = self.external.arm()?;
        let joints = [(0, quadrants[0]), (3, quadrants[1]), (5, quadrants[2])];
        let range = |from: f64| [from * FRAC_PI_2, (from + 1.0) * FRAC_PI_2];
        let joints = joints.map(|(axis, quadrant)| (arm[axis], range(quadrant)));
        let shown = quadrants.map(|number| number.to_string()).join(",");
        let is_sane = quadrants.iter().all(|number| number.abs() < 100.0);
        is_sane.then(|| Configuration {
            shown: format!("confdata [{shown}]"),
            joints: joints.into(),
            sides: None,
        })
    }

    /// Of a target of which the program has set other parts alone.
    fn doubt_configuration(&mut self, line: usize, target: &Value) {
        let is_open = |value: &&Value| matches!(value, Value::Unknown(_));
        let why = match target.part(2, "a confdata") {
            Ok(Value::Unknown(why)) if &**why != OF_THE_RUN => why.to_string(),
            Ok(Value::List(quadrants)) => match quadrants.iter().find(is_open).map(Value::num) {
                Some(Err(why)) => why,
                _ => return,
            },
            _ => return,
        };
        let what = format!("the arm configuration of the target is not known: {why}");
        self.log.warning(Code::AxisIgnored, line, what);
    }

    /// The robot's axes of a jointtarget, degrees.
    fn six_axes(&self, value: &Value) -> Option<[f64; ROBOT_AXES]> {
        value.part(0, "a jointtarget").and_then(|axes| axes.numbers("the robot's axes")).ok()
    }

    fn joints(&mut self, value: &Value) -> Result<Vec<f64>, String> {
        let degrees: [f64; ROBOT_AXES] = value
            .part(0, "a jointtarget")
            .and_then(|axes| axes.numbers("the robot's axes"))
            .map_err(|why| format!("target: {why}"))?;
        if let Value::List(parts) = value {
            self.external_axes(parts.get(1))?;
        }
        self.external.joints(&degrees.map(rad_from_deg))
    }

    fn external_axes(&mut self, external: Option<&Value>) -> Result<(), String> {
        let values = match external {
            Some(Value::List(values)) => values,
            Some(Value::Unknown(why)) => return self.doubt_external(why),
            _ => return Ok(()),
        };
        let is_open = |value: &&Value| matches!(value, Value::Unknown(_));
        if let Some(Value::Unknown(why)) = values.iter().find(is_open) {
            self.doubt_external(why)?;
        }
        for (name, value) in EXTERNAL.into_iter().zip(values).filter(|(_, own)| !is_open(own)) {
            let value = value.num().map_err(|why| format!("{name}: {why}"))?;
            if value.abs() < NO_AXIS && !self.stays(name, value) {
                self.external.place(self.log, name, value)?;
            }
        }
        Ok(())
    }

    /// External axes that are not known: a fault where the job has any that may move.
    fn doubt_external(&mut self, why: &str) -> Result<(), String> {
        let Settings { external_axes, mechanical_units, .. } = self.settings;
        if !(external_axes.is_empty() && mechanical_units.is_empty()) {
            return Err(format!("external axes: {why}"));
        }
        let what = format!(
            "the external axes of the target are not known: {why}; they are taken to stand"
        );
        self.log.warning(Code::AxisIgnored, self.line, what);
        Ok(())
    }

    /// The job's feed for a speed that is not known; the first of all moves needs none.
    fn unstated(&mut self, line: usize, expr: &Expr, why: &Why) -> Result<Pace, String> {
        let (mut code, mut more) = (Code::Assumed, "");
        if self.log.has_moved() {
            code = self.code_of_assumed(Some(expr), why);
            if why.is_another(&mut self.speeds_of_job) {
                // They differ, or there would be one.
                (code, more) = (Code::ChangeIgnored, " for more than one of them");
            }
        }
        let help = why.help();
        if self.log.has_moved() && self.settings.feed_m_per_s.is_none() {
            return Err(format!(
                "speed: {why}{help}; or feed_mm_per_min in the job's operation stands for it"
            ));
        }
        let help = if code == Code::Assumed { "" } else { &help };
        self.log.warning(code, line, format!("speed: {why}{help}; the job's feed is used{more}"));
        Ok(Pace::Unstated)
    }

    /// Tells where a speed is known, and the one at which the tool turns is not.
    fn doubt_turning(&mut self, line: usize, speed: &Value) {
        let why = match speed.part(1, "a speeddata") {
            _ if !matches!(speed, Value::List(_)) => return,
            Ok(Value::Unknown(why)) => why.clone(),
            part => match part.and_then(Value::num) {
                Err(why) => Why::from(why),
                Ok(_) => return,
            },
        };
        // The first of all moves takes no time.
        let (code, help) = match self.log.has_moved() {
            true => (Code::ChangeIgnored, why.help()),
            false => (Code::Assumed, String::new()),
        };
        let what = format!("v_ori: {why}{help}; turns of the tool are not slowed by it");
        self.log.warning(code, line, what);
    }

    /// A speed that is not known says nothing of how fast the tool turns and external axes go: a
    /// doubt where these may take longer than the way, of a length in m and a turn in rad.
    fn doubt_time(&mut self, line: usize, speed: &Value, pace: Pace, way: Option<(f64, f64)>) {
        /// Degrees/s and mm/s: programs that turn slowly have some tens.
        const SLOW: f64 = 10.0;
        const SHORT_S: f64 = 0.01;
        let m_per_s = match (pace, self.settings.feed_m_per_s) {
            (Pace::Feed(m_per_s), _) | (Pace::Unstated, Some(m_per_s)) => m_per_s,
            _ => return,
        };
        let Value::Unknown(why) = speed else { return };
        let (length_m, turned_rad) = way.unwrap_or_default();
        let turning_s = deg_from_rad(turned_rad) / SLOW;
        let others_s = turning_s.max(self.external.seconds([Some(SLOW); 2]));
        if self.log.has_moved() && others_s > SHORT_S.max(length_m / m_per_s) {
            let what = format!(
                "v_ori, v_leax, v_reax: {why}{}; how long the tool turns or external axes move is \
                 not known",
                why.help()
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// Speed of the tool centre point, of a speeddata and `\V` in mm/s, and the speeddata.
    fn pace(
        &mut self,
        line: usize,
        (expr, takes_v): (&'a Expr, bool),
        speed: Option<(&Value, Option<&'a Expr>)>,
    ) -> Result<(Pace, Value), String> {
        let data = self.eval(expr);
        let (share, limit) = self.velocity;
        let share = share * self.over;
        let turning = data.part(1, "a speeddata").and_then(Value::num);
        self.doubt_turning(line, &data);
        self.log.turns_at(turning.ok().map(|speed| rad_from_deg(speed) * share));
        let external = [2, 3].map(|part| {
            data.part(part, "a speeddata").and_then(Value::num).ok().map(|speed| speed * share)
        });
        self.log.external_needs(self.external.seconds(external));
        let mm_per_s = match (speed, &data) {
            (Some((speed, _)), _) => speed.num().map_err(|why| format!("speed: {why}"))?,
            (None, Value::Unknown(why)) => return Ok((self.unstated(line, expr, why)?, data)),
            (None, data) => data
                .part(0, "a speeddata")
                .and_then(Value::num)
                .map_err(|why| format!("speed: {why}"))?,
        };
        let stated = mm_per_s;
        let mm_per_s = (mm_per_s * share).min(limit);
        let own = speed.map(|(speed, _)| speed).or_else(|| data.part(0, "a speeddata").ok());
        // VelSet does not say how fast.
        if stated * share <= limit && own.is_some_and(Value::is_of_robot) {
            self.keep_vmax(line, m_per_s_from_mm_per_s(mm_per_s));
        }
        if mm_per_s > 0.0 && mm_per_s.is_finite() {
            let (span, states) = match speed {
                Some((_, own)) => {
                    (own.and_then(|expr| self.literal(expr)), States::Feed { value: stated })
                }
                None => self.speed_word(expr, stated, takes_v),
            };
            self.log.states(line, span, states);
            Ok((Pace::Feed(m_per_s_from_mm_per_s(mm_per_s)), data))
        } else {
            Err(format!("speed is {mm_per_s} mm/s, must be positive"))
        }
    }

    /// A move takes its speed from vmax.
    fn keep_vmax(&mut self, line: usize, m_per_s: f64) {
        // The first of all moves takes no time.
        let m_per_s = if self.log.has_moved() { m_per_s } else { f64::INFINITY };
        let (_, least) = self.at_vmax.get_or_insert((line, m_per_s));
        *least = least.min(m_per_s);
    }

    /// Tells of vmax: a doubt where its moves may be the cuts, or where their time counts.
    pub(super) fn tell_vmax(&mut self) {
        let Some((line, m_per_s)) = self.at_vmax else { return };
        let assumed = format!("vmax is taken as {VMAX_MM_PER_S} mm/s");
        let why = if self.log.slowest_led().is_some_and(|own| own >= m_per_s) {
            "no line or arc is slower"
        } else if self.settings.is_scheduled && m_per_s.is_finite() {
            "the speed of the spindle follows the time"
        } else {
            return self.log.warning(Code::Assumed, line, assumed);
        };
        let what = format!(
            "{assumed}, and {why}: what it is depends on the robot; state the speed in the \
             program (\\V, VelSet or speeddata with numbers)"
        );
        self.log.warning(Code::ChangeIgnored, line, what);
    }
}
