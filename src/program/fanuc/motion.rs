//! The motion statements of TP programs.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Translation3};

use super::pace::NO_TURN_RAD;
use super::position::{Held, JOINTS, POSE, axes, places_by_job, pose, six};
use super::run::{BEHIND_ERROR, Run, unstopped};
use super::shifts::{Shift, unshifted};
use super::text::{Group, Statement};
use super::words::{has_option, split_action, starts_with, word};
use crate::motion::{Configuration, Sides, Target, Turning};
use crate::notes::Code;
use crate::program::J3From;
use crate::program::cell::without_own_frame;
use crate::units::{deg_from_rad, rad_from_deg};

/// Of moves in which the robot holds the work.
const REMOTE: &str = "a stationary tool (remote TCP) is not supported";

/// A position that a statement names.
pub(super) struct Aim {
    /// `P[3]`, also where a register gives the number.
    name: String,
    is_register: bool,
    /// Values, with the frame and the tool in which they count.
    pub(super) group: Group,
}

/// Where a motion goes: a pose with its tool, or joints of the arm, rad.
#[derive(Debug, Clone)]
pub(super) enum Place {
    Pose(Isometry3<f64>),
    Joints([f64; 6]),
}

impl Run<'_> {
    pub(super) fn motion(&mut self, statement: &Statement) -> Result<(), String> {
        // Until it is done, where the arm is is not known.
        (self.stands, self.joints) = (Err(BEHIND_ERROR.to_owned()), None);
        let text = statement.text.trim_end();
        let start = text.len() - text.trim_start().len();
        let kind = text.get(start..=start).unwrap_or("");
        let mut rest = text.get(start + 1..).unwrap_or("").trim_start();
        if matches!(kind, "J" | "L")
            && let Some((number, behind)) = self.registers.numbered(rest, "PR")?
            && self.registers.position(number).is_unset()
        {
            return self.leave(statement, kind, &format!("PR[{number}]"), behind);
        }
        if let Some((line, name)) = self.unknown_end.take() {
            let what = format!(
                "{name} is known only at run time, and motion follows from there; {}",
                places_by_job(&name)
            );
            self.log.error(Code::Motion, line, what);
        }
        let line = self.line_of(statement);
        let count = if kind == "C" { 2 } else { 1 };
        let mut places = Vec::new();
        let mut tcp = None;
        let mut last = None;
        for _ in 0..count {
            let option = word(rest).split(',').next().unwrap_or("");
            if !places.is_empty() && option.to_ascii_uppercase().ends_with("OFFSET") {
                return Err(format!(
                    "{option} of the first point of C is not read: set a PR[] to the place that it \
                     shifts to"
                ));
            }
            let (aim, behind) = self.aim(line, rest)?;
            if !aim.is_register {
                self.frames_agree(&aim.name, &aim.group)?;
            }
            self.tell_chosen(line, &aim.name, &aim.group, aim.is_register);
            self.place_axes(line, &aim)?;
            let (place, tool) = self.resolve(line, &aim.group)?;
            // An increment has no posture, whatever its CONFIG is.
            if has_option(behind, "INC") {
                self.configure(None, Vec::new());
            } else {
                self.keep_config(line, kind, &aim)?;
                let joints = self.turns(line, kind, &aim.group);
                self.configure(aim.group.config.as_deref(), joints);
            }
            tcp = Some(tool);
            places.push(place);
            last = Some(aim.group);
            rest = behind.trim_start();
        }
        let tcp = tcp.ok_or("the position is missing")?;
        // A joint move to joints ends there with any tool.
        if kind != "J" || matches!(places.as_slice(), [Place::Pose(_)]) {
            let tool = last.as_ref().and_then(|group| group.tool).or(self.tool);
            self.tell_of_flange(line, tool);
        }
        let (term, options) = rest.split_at(word(rest).len());
        let (shift, actions) = self.options(line, options)?;
        let turn = self.ways_to(places.last(), &tcp).map(|[turn, _]| turn);
        self.tell_wrist(line, kind, options, (last.as_ref(), turn));
        if let (false, Some(group)) = (shift.is_none(), &last) {
            let frame = group.frame.or(self.frame);
            let base = self.base_of(frame)?;
            let (false, [Place::Pose(place)]) = (kind == "A", places.as_mut_slice()) else {
                return Err(unshifted(kind, &shift));
            };
            if shift.is_from_before {
                *place = self.counted_from_before(place, &base, &tcp, group)?;
            }
            let tool = group.tool.or(self.tool).unwrap_or(0);
            let in_frame = self.turned_from("UFRAME", shift.of[0], (frame, &base))?;
            let in_tool = self.turned_from("UTOOL", shift.of[1], (Some(tool), &tcp))?;
            let [frame, tool] =
                [in_frame * shift.frame, in_tool * shift.tool].map(Translation3::from);
            *place = base * frame * base.inverse() * *place * tool;
        }
        if kind != "J" {
            if let (Some(Place::Joints(q)), Some(arm)) = (places.last(), self.external.arm()) {
                self.log.configure(Some(ends_in(q, &arm)));
            }
            for place in &mut places {
                *place = self.led_to(place, &tcp)?;
            }
        }
        let ways = self.ways_to(places.last(), &tcp);
        let pace = self.pace(statement, term, kind, ways)?;
        self.compare_limits(line, kind, pace);
        match (kind, places.as_slice()) {
            ("J", [Place::Joints(q)]) => {
                let q = self.external.joints(q)?;
                self.log.motion(line, Target::Joints(q), tcp, pace);
            }
            ("J", [Place::Pose(pose)]) => {
                self.log.motion(line, Target::JointsTo(*pose), tcp, pace);
            }
            ("L", [Place::Pose(pose)]) => {
                self.log.motion(line, Target::Line(*pose), tcp, pace);
            }
            ("C", [Place::Pose(via), Place::Pose(end)]) => {
                let (via, end) = (*via, *end);
                self.log.motion(line, Target::Arc { via, end, turning: Turning::ByWay }, tcp, pace);
            }
            ("A", [Place::Pose(pose)]) => self.arc_point(statement, *pose, tcp, pace)?,
            ("S", _) => return Err("S (spline) is not supported".to_owned()),
            _ => return Err("a line or arc to joint positions".to_owned()),
        }
        let stops = options.split_whitespace().any(|own| own.eq_ignore_ascii_case("FINE"));
        self.stands = if stops { Ok(()) } else { Err(unstopped("a move without FINE")) };
        self.joints = last.and_then(|group| six(&group, JOINTS).ok().flatten());
        for action in actions {
            self.act(statement, action);
        }
        Ok(())
    }

    /// A line or an arc to joint positions goes to where the robot has the tool there.
    pub(super) fn led_to(&self, place: &Place, tcp: &Isometry3<f64>) -> Result<Place, String> {
        let Place::Joints(q) = place else { return Ok(place.clone()) };
        let joints = self.external.joints(q)?;
        let tip = self.settings.tip_at.as_ref().and_then(|tip| tip.at(&joints));
        Ok(Place::Pose(tip.ok_or("a line or arc to joint positions")? * tcp))
    }

    /// To a place that only the controller knows, as HOME is: before all other motion and behind it
    /// the path is whole without that way. A line to there may cut; between others it is an error.
    fn leave(
        &mut self,
        statement: &Statement,
        kind: &str,
        name: &str,
        behind: &str,
    ) -> Result<(), String> {
        let line = self.line_of(statement);
        self.stands = Err(unstopped("a move to a place that is not in the program"));
        let behind = behind.trim_start();
        let options = behind.get(word(behind).len()..).unwrap_or("");
        let (_, actions) = self.options(line, options)?;
        if self.skipped.iter().all(|(_, own)| own != name) {
            self.skipped.push((line, name.to_owned()));
        }
        if kind == "L" {
            let what =
                format!("L {name}: the place is not in the program; the move there is skipped");
            self.log.warning(Code::MotionLeftOut, line, what);
            if self.log.has_moved() {
                self.unknown_end.get_or_insert((line, name.to_owned()));
            }
        } else {
            let hint = format!(" ({})", places_by_job(name));
            let hint = if self.log.has_moved() { &hint } else { "" };
            self.log.leaves(line, &format!("{kind} {name}{hint}"));
        }
        for action in actions {
            self.act(statement, action);
        }
        Ok(())
    }

    /// The position at the start of a text, and what follows.
    pub(super) fn aim<'t>(&mut self, line: usize, text: &'t str) -> Result<(Aim, &'t str), String> {
        if let Some((number, rest)) = self.registers.numbered(text, "PR")? {
            let name = format!("PR[{number}]");
            let held = self.registers.position(number);
            let mut group = held.target(&name)?;
            // A target in joints would be quite another.
            self.tell_kind(line, &name, &held, Code::UnitAssumed);
            group.tool = self.chosen("UTOOL")?;
            if !group.parts.contains_key(JOINTS[0]) {
                group.frame = self.chosen("UFRAME")?;
            }
            return Ok((Aim { name, is_register: true, group }, rest));
        }
        let found = self.registers.numbered(text, "P")?;
        let (number, rest) = found.ok_or("the position is missing")?;
        let (name, group) = (format!("P[{number}]"), self.taught(number)?);
        Ok((Aim { name, is_register: false, group }, rest))
    }

    /// A position of /POS, with the external axes of all groups.
    pub(super) fn taught(&self, number: i64) -> Result<Group, String> {
        let position = u32::try_from(number).ok().and_then(|n| self.source.positions.get(&n));
        let position = position.ok_or_else(|| format!("P[{number}] is not in /POS"))?;
        let own = position.groups.iter().find(|(group, _)| *group == 1);
        let (_, own) = own.ok_or_else(|| format!("P[{number}] has no group 1"))?;
        let mut own = own.clone();
        for (group, other) in position.groups.iter().filter(|(group, _)| *group != 1) {
            let parts = other.parts.iter();
            own.parts.extend(parts.map(|(name, value)| (format!("gp{group}_{name}"), *value)));
        }
        Ok(own)
    }

    /// Tells where nothing says that elements are not joints.
    pub(super) fn tell_kind(&mut self, line: usize, name: &str, held: &Held, code: Code) {
        if held.is_of_unknown_kind() {
            let what = format!(
                "{name} is taken as X to R, not as joints: the program sets nothing but its \
                 elements"
            );
            self.log.warning(code, line, what);
        }
    }

    /// Places the external axes of a position.
    fn place_axes(&mut self, line: usize, aim: &Aim) -> Result<(), String> {
        let mut found: Vec<(String, f64)> = axes(&aim.group).collect();
        // Of the axes of a second robot first, which no job can give.
        let of_robot = |axis: &str| second_robot(axis, &aim.group);
        found.sort_by(|(a, _), (b, _)| (of_robot(a).is_none(), a).cmp(&(of_robot(b).is_none(), b)));
        for (axis, value) in found {
            let placed = self.external.place(self.log, &axis, value);
            placed.map_err(|why| of_robot(&axis).unwrap_or(why))?;
            self.axes.insert(axis, value);
        }
        let missing = self.axes.keys().find(|axis| !aim.group.parts.contains_key(*axis));
        if let Some(axis) = missing.filter(|_| aim.is_register) {
            let what = format!(
                "the program does not say what {} has for external axis {axis}, which is taken to \
                 stand still",
                aim.name
            );
            self.log.warning(Code::AxisIgnored, line, what);
        }
        Ok(())
    }

    /// The arm configuration follows from the start of the path: one other than that of the
    /// position before would turn the arm over.
    fn keep_config(&mut self, line: usize, kind: &str, aim: &Aim) -> Result<(), String> {
        let Some(config) = &aim.group.config else {
            let is_pose = !aim.group.parts.contains_key(JOINTS[0]);
            if !is_pose || !aim.is_register {
                self.config = None;
            } else if kind == "J" && self.log.has_moved() {
                let what = format!(
                    "J to {}, whose CONFIG the program does not set: the arm is taken to keep its \
                     configuration",
                    aim.name
                );
                self.log.warning(Code::AxisIgnored, line, what);
            }
            return Ok(());
        };
        // Wrist, elbow and shoulder; turns follow the shortest way.
        let own: Vec<&str> =
            config.split(' ').filter(|word| word.parse::<i32>().is_err()).collect();
        let own = own.join(" ");
        let is_first = !self.log.has_moved();
        if is_first {
            let what = format!(
                "CONFIG '{own}' is not compared with the arm configuration that is found; \
                 start_near_deg in the job can give it"
            );
            self.log.warning(Code::Assumed, line, what);
        }
        self.log.compares_no(is_first.then(|| format!("CONFIG '{own}'")));
        let before = self.config.replace(own.clone());
        let Some(before) = before.filter(|before| *before != own) else { return Ok(()) };
        let why = if kind == "J" {
            "the arm turns over, which is not read; teach the position in joints"
        } else {
            "the controller stops there, or with Wjnt turns the wrist over, which is not read"
        };
        Err(format!("CONFIG goes from '{before}' to '{own}': {why}"))
    }

    /// The arm configuration that the next move ends in: the letters that hold, and the joints that
    /// are known.
    fn configure(&mut self, config: Option<&str>, joints: Vec<(usize, [f64; 2])>) {
        let sides = self.config.as_deref().map(sides);
        let shown = config.or(self.config.as_deref()).map(|config| format!("CONFIG '{config}'"));
        let asked = shown.filter(|_| sides.is_some() || !joints.is_empty());
        self.log.configure(asked.map(|shown| Configuration { shown, joints, sides }));
    }

    /// A joint move ends with the turns of its CONFIG: with none, no axis is beyond half a turn.
    /// Which axes other numbers are of differs between arms.
    fn turns(&mut self, line: usize, kind: &str, group: &Group) -> Vec<(usize, [f64; 2])> {
        const TURNING: [usize; 3] = [0, 3, 5];
        let config = group.config.as_ref().filter(|_| kind == "J");
        let words = config.iter().flat_map(|config| config.split([' ', ',']));
        let turns: Vec<i32> = words.filter_map(|word| word.parse().ok()).collect();
        if turns.iter().any(|turn| *turn != 0) {
            let what = "the turn numbers of CONFIG are not read where they are not 0: the arm is \
                        taken to go the shorter way";
            self.log.warning(Code::AxisIgnored, line, what);
            return Vec::new();
        }
        let arm = self.external.arm().filter(|_| !turns.is_empty());
        let half = |arm: [usize; 6]| TURNING.map(|axis| (arm[axis], [-PI, PI])).into();
        arm.map_or_else(Vec::new, half)
    }

    /// Tells of what turns the wrist otherwise than the position and the kind of motion say;
    /// `turn` is by how much the tool turns on the way, rad, where that is known.
    fn tell_wrist(
        &mut self,
        line: usize,
        kind: &str,
        options: &str,
        (to, turn): (Option<&Group>, Option<f64>),
    ) {
        let has = |name| has_option(options, name);
        // The path starts where the first of all moves ends.
        if !self.log.has_moved() {
            return;
        }
        if kind != "J" && has("Wjnt") {
            let what = "Wjnt: on the way J4 to J6 go as in a joint move, which is not read: the \
                        tool is taken to turn evenly, as without Wjnt";
            self.log.warning(Code::AxisIgnored, line, what);
        }
        if kind == "J" && has("MROT") && to.is_some_and(|to| to.config.is_some()) {
            self.configure(None, Vec::new());
            if turn.is_some_and(|turn| turn < NO_TURN_RAD) {
                return;
            }
            let what = "MROT: the arm is taken to go the shorter way, whatever the turn numbers of \
                        CONFIG say; a position in joints says where the wrist ends";
            self.log.warning(Code::AxisIgnored, line, what);
        }
    }

    pub(super) fn resolve(
        &mut self,
        line: usize,
        group: &Group,
    ) -> Result<(Place, Isometry3<f64>), String> {
        let tool = group.tool.or(self.tool);
        let is_given = !self.settings.tool_frames.is_empty() && self.settings.tcp.is_none();
        selected(tool, is_given, "UT : F", "tcp")?;
        let tool = tool.unwrap_or(0);
        let tcp = self.tcp(tool)?;
        self.log.tcp_of(without_own_frame(self.settings, tool).filter(|_| !self.is_own_tool(tool)));
        if let Some(degrees) = six(group, JOINTS)? {
            let mut q = degrees.map(rad_from_deg);
            match self.settings.j3_from {
                Some(J3From::Horizontal) => q[2] += q[1],
                Some(J3From::UpperArm) => {}
                // Both are one where the upper arm stands at J2 = 0.
                None if q[1] == 0.0 => {}
                None => {
                    let what = "J3 of positions in joints is taken as the joint of the robot file, \
                                from the upper arm; most arms count it from the horizontal: write \
                                path.program.j3_from: horizontal or upper_arm in the job";
                    self.log.warning(Code::UnitAssumed, line, what);
                }
            }
            return Ok((Place::Joints(q), tcp));
        }
        if group.parts.contains_key("rx") {
            return Err(format!("RX to RR of the position: {REMOTE}"));
        }
        let numbers = six(group, POSE)?.ok_or("the position has neither X to R nor J1 to J6")?;
        let frame = group.frame.or(self.frame);
        let is_given = !self.settings.base_frames.is_empty() && self.settings.work_object.is_none();
        selected(frame, is_given, "UF : F", "work_object")?;
        if frame == Some(0) && self.settings.work_object.is_some() {
            let what =
                "UFRAME 0 is the robot's base frame: the job's work_object is not used there";
            self.log.warning(Code::FrameFromProgram, line, what);
        }
        Ok((Place::Pose(self.base_of(frame)? * pose(numbers)), tcp))
    }

    /// How far the tool turns on the way to a pose, rad, and goes, m.
    fn ways_to(&self, to: Option<&Place>, tcp: &Isometry3<f64>) -> Option<[f64; 2]> {
        let Some(Place::Pose(to)) = to else { return None };
        let from = self.log.last()?.with(tcp);
        let way = (to.translation.vector - from.translation.vector).norm();
        Some([from.rotation.angle_to(&to.rotation), way])
    }

    /// What stands behind the speed; by how much it shifts the target, and the actions in it.
    fn options<'t>(&mut self, line: usize, text: &'t str) -> Result<(Shift, Vec<&'t str>), String> {
        const HARMLESS: [&str; 14] = [
            "FINE", "CNT", "CR", "ACC", "PTH", "COORD", "WJNT", "RT_LD", "AP_LD", "BREAK", "EV",
            "SPOT", "MROT", "CD",
        ];
        /// `CNT R[2]`, `EV 50%`: how far corners are rounded, and how fast it gets there.
        const APART: [&str; 5] = ["CNT", "ACC", "CR", "CD", "EV"];
        let mut rest = text.trim();
        let (mut shift, mut actions) = (Shift::default(), Vec::new());
        while !rest.is_empty() {
            let (own, behind) = rest.split_at(word(rest).len());
            let upper = own.to_ascii_uppercase();
            if upper.starts_with("OFFSET") || upper.starts_with("TOOL_OFFSET") {
                let (by, of, behind) = self.shift(line, rest)?;
                if upper.starts_with('T') {
                    (shift.tool, shift.of[1]) = (by, of);
                } else {
                    (shift.frame, shift.of[0]) = (by, of);
                }
                rest = behind.trim_start();
            } else if upper.starts_with("VOFFSET") {
                rest = self.vision_shift(rest)?.trim_start();
            } else if let Some((action, behind)) = split_action(rest) {
                self.bends_path(line, action);
                actions.push(action);
                rest = behind.trim_start();
            } else if upper == "PSPD100" || HARMLESS.iter().any(|own| upper.starts_with(own)) {
                rest = behind.trim_start();
                let is_value = starts_with(rest, "R[")
                    || starts_with(rest, "AR[")
                    || rest.starts_with(|first: char| first.is_ascii_digit());
                if APART.contains(&upper.as_str()) && is_value {
                    rest = rest.get(word(rest).len()..).unwrap_or("").trim_start();
                }
            } else if upper.starts_with("PSPD") {
                return Err(format!("{own} changes the speed of the move and is not supported"));
            } else if upper == "INC" {
                shift.is_from_before = true;
                rest = behind.trim_start();
            } else if upper == "RTCP" {
                return Err(format!("{own}: {REMOTE}"));
            } else if upper.starts_with("SKIP") {
                return Err(format!(
                    "{own}: SKIP CONDITION may end the move before its target, at a place that \
                     only the run knows; in the file that is checked write the move to where it \
                     ends, without {}",
                    own.split(',').next().unwrap_or(own)
                ));
            } else {
                return Err(format!("'{own}' behind the target is not understood"));
            }
        }
        Ok((shift, actions))
    }
}

/// Why an axis cannot move that is of a group which is a robot itself, by a pose or six joints.
fn second_robot(axis: &str, group: &Group) -> Option<String> {
    let (name, _) = axis.split_once('_').filter(|(name, _)| name.starts_with("gp"))?;
    let has = |part: &str| group.parts.contains_key(&format!("{name}_{part}"));
    let shown = name.to_uppercase();
    (has(POSE[0]) || has(JOINTS[5])).then(|| {
        format!(
            "{shown} is a second robot, and it moves: one robot is read, that of group 1; in the \
             file that is checked leave {shown} out of the positions, if the other robot does not \
             matter"
        )
    })
}

/// What the letters of CONFIG say: at zero the wrist is in front (T, not B) and the elbow
/// up (U, not D).
fn sides(letters: &str) -> Sides {
    let is = |one: &str, other: &str| {
        let own = letters.split(' ').find(|letter| [one, other].contains(letter));
        own.map(|letter| letter == one)
    };
    Sides { name: letters.to_owned(), as_at_zero: [is("T", "B"), is("U", "D")] }
}

/// The joints of the arm in which a line or an arc ends.
fn ends_in(q: &[f64; 6], arm: &[usize; 6]) -> Configuration {
    let degrees = q.map(|q| format!("{:.1}", deg_from_rad(q)));
    Configuration {
        shown: format!("J1 to J6 at {}°", degrees.join("°, ")),
        joints: arm.iter().copied().zip(q.map(|q| [q, q])).collect(),
        sides: None,
    }
}

/// A frame or tool that the program selects, or that the job has for all; where the job gives such
/// by number alone, which one holds is not known.
fn selected(number: Option<u32>, is_by_number: bool, what: &str, key: &str) -> Result<(), String> {
    match number {
        None if is_by_number => Err(format!(
            "{what} is what is selected at run time, and the program selects none: write the {key} \
             in the job"
        )),
        _ => Ok(()),
    }
}
