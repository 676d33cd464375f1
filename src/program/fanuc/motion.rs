//! The motion statements of TP programs.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::registers::{
    JOINTS, OF_A_GROUP, POSE, no_shift, outside, register, split_outside, starts_with,
};
use super::run::Run;
use super::text::{Group, Statement};
use crate::motion::{Circle, Target};
use crate::notes::Code;
use crate::program::cell::{base_frame, of_job_tcp, tool_frame};
use crate::program::log::States;
use crate::program::{J3From, Pace};
use crate::units::{
    m_from_mm, m_per_s_from_mm_per_min, m_per_s_from_mm_per_s, mm_from_inch, rad_from_deg,
    ratio_from_percent, s_from_ms,
};

/// Where a motion goes: a pose with its tool, or joints of the arm, rad.
#[derive(Debug, Clone)]
enum Place {
    Pose(Isometry3<f64>),
    Joints([f64; 6]),
}

/// What `Offset,PR[n]` and `Tool_Offset,PR[n]` shift a target by: along the axes of the frame, and
/// of the tool, m.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Shift {
    frame: Vector3<f64>,
    tool: Vector3<f64>,
}

impl Run<'_> {
    pub(super) fn motion(&mut self, statement: &Statement) -> Result<(), String> {
        let text = statement.text.trim_end();
        let start = text.len() - text.trim_start().len();
        let kind = text.get(start..=start).unwrap_or("");
        let mut rest = text.get(start + 1..).unwrap_or("").trim_start();
        let count = if kind == "C" { 2 } else { 1 };
        let mut places = Vec::new();
        let mut tcp = None;
        let mut last = None;
        for _ in 0..count {
            let (group, behind) = self.place(rest)?;
            self.frames_agree(rest, &group)?;
            let (place, tool) = self.resolve(statement.line, &group)?;
            self.keep_config(statement.line, kind, &group)?;
            tcp = Some(tool);
            places.push(place);
            last = Some(group);
            rest = behind.trim_start();
        }
        let tcp = tcp.ok_or("the position is missing")?;
        let (term, options) = rest.split_at(word(rest).len());
        let line = statement.line;
        let (shift, actions) = self.options(line, options)?;
        if let (false, Some(group)) = (shift == Shift::default(), last) {
            let base = self.base(line, &group)?;
            let (false, [Place::Pose(place)]) = (kind == "A", places.as_mut_slice()) else {
                return Err("an offset of an arc or of positions in joints is not read".to_owned());
            };
            let [frame, tool] = [shift.frame, shift.tool].map(Translation3::from);
            *place = base * frame * base.inverse() * *place * tool;
        }
        let turned = self.turn_to(places.last(), &tcp);
        let pace = self.pace(statement, term, kind, turned)?;
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
                self.log.motion(line, Target::Arc { via, end }, tcp, pace);
            }
            ("A", [Place::Pose(pose)]) => self.arc_point(statement, *pose, tcp, pace)?,
            ("S", _) => return Err("S (spline) is not supported".to_owned()),
            _ => return Err("a line or arc to joint positions".to_owned()),
        }
        for action in actions {
            self.act(statement, action);
        }
        Ok(())
    }

    /// A: arcs through points in a row, each on the circle of its neighbours; the first is gone to
    /// straight.
    fn arc_point(
        &mut self,
        statement: &Statement,
        to: Isometry3<f64>,
        tcp: Isometry3<f64>,
        pace: Pace,
    ) -> Result<(), String> {
        let index = self.source.statements.iter().position(|other| std::ptr::eq(other, statement));
        let index = index.ok_or("a statement of no program")?;
        let line = statement.line;
        let pose_of = |run: &mut Self, at: Option<usize>| -> Option<Isometry3<f64>> {
            let text = run.source.statements.get(at?)?.text.trim();
            let rest = text.strip_prefix('A')?.trim_start();
            let (group, _) = run.place(rest).ok()?;
            match run.resolve(line, &group).ok()?.0 {
                Place::Pose(pose) => Some(pose),
                Place::Joints(_) => None,
            }
        };
        let before = pose_of(self, index.checked_sub(1));
        let two_before = pose_of(self, index.checked_sub(2)).filter(|_| before.is_some());
        let behind = pose_of(self, Some(index + 1));
        let point = |pose: &Isometry3<f64>| pose.translation.vector;
        let Some(from) = before else {
            self.log.motion(line, Target::Line(to), tcp, pace);
            return Ok(());
        };
        let (circle, share) = match (two_before, behind) {
            (Some(first), _) => {
                let circle = Circle::through(point(&first), point(&from), point(&to));
                let circle = circle.ok_or("the arc's points lie on one line")?;
                let share = (circle.via_at() + 1.0) / 2.0;
                (circle, share)
            }
            (None, Some(next)) => {
                let circle = Circle::through(point(&from), point(&to), point(&next));
                let circle = circle.ok_or("the arc's points lie on one line")?;
                let share = circle.via_at() / 2.0;
                (circle, share)
            }
            (None, None) => return Err("A needs three points in a row".to_owned()),
        };
        let turned = from.rotation.try_slerp(&to.rotation, 0.5, 1e-12).unwrap_or(to.rotation);
        let via = Isometry3::from_parts(circle.at(share).into(), turned);
        self.log.motion(line, Target::Arc { via, end: to }, tcp, pace);
        Ok(())
    }

    /// The position at the start of a text, and what follows.
    fn place<'t>(&mut self, text: &'t str) -> Result<(Group, &'t str), String> {
        if let Some((number, rest)) = register(text, "PR") {
            let group = self
                .registers
                .positions
                .get(&number)
                .cloned()
                .unwrap_or_else(|| Err(format!("PR[{number}] is known only at run time")))?;
            return Ok((group, rest));
        }
        if text.starts_with("P[R[") {
            return Err("a position by the number of a register is not supported".to_owned());
        }
        let (number, rest) = register(text, "P").ok_or("the position is missing")?;
        let position = u32::try_from(number).ok().and_then(|n| self.source.positions.get(&n));
        let position = position.ok_or_else(|| format!("P[{number}] is not in /POS"))?;
        let mut own = None;
        for (group, parts) in &position.groups {
            if *group == 1 {
                own = Some(parts.clone());
                continue;
            }
            let mut names: Vec<&String> = parts.parts.keys().collect();
            names.sort();
            for name in names {
                let axis = format!("gp{group}_{name}");
                self.external.place(self.log, &axis, parts.parts[name])?;
            }
        }
        let own = own.ok_or_else(|| format!("P[{number}] has no group 1"))?;
        for name in ["e1", "e2", "e3"] {
            if let Some(value) = own.parts.get(name) {
                self.external.place(self.log, name, *value)?;
            }
        }
        Ok((own, rest))
    }

    /// The arm configuration follows from the start of the path; a J that asks for another one than
    /// the position before would turn the arm over.
    fn keep_config(&mut self, line: usize, kind: &str, group: &Group) -> Result<(), String> {
        let Some(config) = &group.config else {
            self.config = None;
            return Ok(());
        };
        // Wrist, elbow and shoulder; turns follow the shortest way.
        let own: Vec<&str> =
            config.split(' ').filter(|word| word.parse::<i32>().is_err()).collect();
        let own = own.join(" ");
        if !self.log.has_moved() {
            let what = format!(
                "CONFIG '{own}' is not compared with the arm configuration that is found; \
                 start_near_deg in the job can give it"
            );
            self.log.warning(Code::Assumed, line, what);
        }
        let before = self.config.replace(own.clone());
        match before.filter(|before| kind == "J" && *before != own) {
            Some(before) => Err(format!(
                "CONFIG goes from '{before}' to '{own}': the arm turns over, which is not read; \
                 teach the position in joints"
            )),
            None => Ok(()),
        }
    }

    fn resolve(&mut self, line: usize, group: &Group) -> Result<(Place, Isometry3<f64>), String> {
        let tool = group.tool.or(self.tool).unwrap_or(0);
        let own = self.own_frame("UTOOL", tool);
        let tcp = own.map_or_else(|| tool_frame(self.settings, f64::from(tool), "UTOOL"), Ok)?;
        self.log.tcp_of(of_job_tcp(self.settings, tool).filter(|_| own.is_none()));
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
        let numbers = six(group, POSE)?.ok_or("the position has neither X to R nor J1 to J6")?;
        Ok((Place::Pose(self.base(line, group)? * pose(numbers)), tcp))
    }

    /// The frame of a position in the base frame of the robot.
    fn base(&mut self, line: usize, group: &Group) -> Result<Isometry3<f64>, String> {
        let Some(frame) = group.frame.or(self.frame) else {
            return Ok(self.settings.work_object.unwrap_or_default());
        };
        if frame == 0 && self.settings.work_object.is_some() {
            let what =
                "UFRAME 0 is the robot's base frame: the job's work_object is not used there";
            self.log.warning(Code::FrameFromProgram, line, what);
        }
        let own = self.own_frame("UFRAME", frame);
        own.map_or_else(|| base_frame(self.settings, f64::from(frame), "UFRAME"), Ok)
    }

    /// How far the tool turns on the way to a pose, rad.
    fn turn_to(&self, to: Option<&Place>, tcp: &Isometry3<f64>) -> Option<f64> {
        let Some(Place::Pose(to)) = to else { return None };
        Some(self.log.last()?.with(tcp).rotation.angle_to(&to.rotation))
    }

    /// `100mm/sec`, `R[5]%`, `2.5sec`, `WELD_SPEED`.
    fn pace(
        &mut self,
        statement: &Statement,
        term: &str,
        kind: &str,
        turned: Option<f64>,
    ) -> Result<Pace, String> {
        if term.eq_ignore_ascii_case("max_speed") {
            return Ok(Pace::Rapid);
        }
        const UNITS: [&str; 7] = ["mm/sec", "cm/min", "inch/min", "deg/sec", "msec", "sec", "%"];
        let unit = UNITS.into_iter().find(|unit| term.ends_with(unit)).unwrap_or("");
        let number = term.strip_suffix(unit).unwrap_or(term).trim();
        let value = match self.registers.value(number) {
            Ok(value) => value,
            Err(why) if kind != "J" => {
                let what = format!("speed: {why}; the job's feed is used");
                self.log.warning(Code::Assumed, statement.line, what);
                return Ok(Pace::Unstated);
            }
            Err(_) => return Ok(Pace::Rapid),
        };
        if !(value > 0.0 && value.is_finite()) {
            return Err(format!("speed is {term}, must be positive"));
        }
        let at = number.as_ptr() as usize - statement.text.as_ptr() as usize;
        let span = number.parse::<f64>().ok().and_then(|_| statement.span(at, at + number.len()));
        let feed = match unit {
            // A speed by name is in mm/sec.
            "mm/sec" | "" => m_per_s_from_mm_per_s(value),
            "cm/min" => m_per_s_from_mm_per_min(value * 10.0),
            "inch/min" => m_per_s_from_mm_per_min(mm_from_inch(value)),
            "deg/sec" => {
                let turned = turned.filter(|angle| *angle > 0.0);
                let angle = turned.ok_or("deg/sec, and how far the tool turns is not known")?;
                return Ok(Pace::Seconds(angle / rad_from_deg(value) / self.over));
            }
            "msec" | "sec" => {
                self.log.states(statement.line, span, States::Seconds { value });
                let seconds = if unit == "sec" { value } else { s_from_ms(value) };
                return Ok(Pace::Seconds(seconds));
            }
            _ if value > 100.0 => return Err(format!("speed is {term}, must be up to 100 %")),
            _ => return Ok(Pace::Joints(ratio_from_percent(value) * self.over)),
        };
        self.log.states(statement.line, span, States::Feed { value });
        Ok(Pace::Feed(feed * self.over))
    }

    /// What stands behind the speed; by how much it shifts the target, and the actions in it.
    fn options<'t>(&mut self, line: usize, text: &'t str) -> Result<(Shift, Vec<&'t str>), String> {
        const HARMLESS: [&str; 14] = [
            "FINE", "CNT", "CR", "ACC", "PTH", "COORD", "WJNT", "RT_LD", "AP_LD", "BREAK", "EV",
            "SPOT", "MROT", "CD",
        ];
        /// `CNT R[2]`: how far corners are rounded, and how fast it gets there.
        const BY_REGISTER: [&str; 4] = ["CNT", "ACC", "CR", "CD"];
        let mut rest = text.trim();
        let (mut shift, mut actions) = (Shift::default(), Vec::new());
        while !rest.is_empty() {
            let (own, behind) = rest.split_at(word(rest).len());
            let upper = own.to_ascii_uppercase();
            if upper.starts_with("OFFSET") || upper.starts_with("TOOL_OFFSET") {
                let (by, behind) = self.shift(rest)?;
                if upper.starts_with('T') {
                    shift.tool = by;
                } else {
                    shift.frame = by;
                }
                rest = behind.trim_start();
            } else if let Some((action, behind)) = split_action(rest) {
                self.bends_path(line, action);
                actions.push(action);
                rest = behind.trim_start();
            } else if upper == "PSPD100" || HARMLESS.iter().any(|own| upper.starts_with(own)) {
                rest = behind.trim_start();
                if BY_REGISTER.contains(&upper.as_str())
                    && (starts_with(rest, "R[") || starts_with(rest, "AR["))
                {
                    rest = rest.get(word(rest).len()..).unwrap_or("").trim_start();
                }
            } else if upper.starts_with("PSPD") {
                return Err(format!("{own} changes the speed of the move and is not supported"));
            } else if upper == "INC" {
                return Err("INC counts from the position before and is not supported".to_owned());
            } else {
                return Err(format!("'{own}' behind the target is not understood"));
            }
        }
        Ok((shift, actions))
    }

    /// What `Offset,PR[1]` shifts by, m, and what follows.
    fn shift<'t>(&self, text: &'t str) -> Result<(Vector3<f64>, &'t str), String> {
        let shown = text.split([' ', '\t', ',']).next().unwrap_or("");
        let by = text.get(shown.len()..).unwrap_or("").trim_start().strip_prefix(',');
        let Some((number, behind)) = by.and_then(|by| register(by.trim_start(), "PR")) else {
            return Err(format!("{shown} shifts the target by what is not PR[n], and is not read"));
        };
        let name = format!("PR[{number}]");
        let group = match self.registers.position(number) {
            Some(Ok(group)) => group,
            // What the job assumes holds only before the program sets it.
            Some(Err(why))
                if self.registers.assumed(&name).is_some()
                    || !self.registers.is_set_in_part(number) =>
            {
                return Err(format!("{shown} shifts the target: {why}"));
            }
            _ => {
                return Err(format!(
                    "{shown} shifts the target by what is known only at run time; assume: \
                     {{\"{name}\": 0}} in the job says that it is 0 until the program sets it"
                ));
            }
        };
        let by = six(&group, POSE)?.ok_or("an offset by joints is not read")?;
        if by[3..].iter().any(|angle| *angle != 0.0) {
            return Err(format!("{shown} turns the target, which is not read"));
        }
        Ok((Vector3::new(by[0], by[1], by[2]).map(m_from_mm), behind))
    }

    /// `PR[1]=P[2]`, `PR[1,3]=R[4]+5`: what cannot be worked out is unknown.
    pub(super) fn assign_position(&mut self, text: &str) -> Result<(), String> {
        if text.starts_with("PR[GP") {
            return Err(OF_A_GROUP.to_owned());
        }
        let (number, rest) = register(text, "PR").ok_or("PR[ without a number")?;
        let value = rest.trim_start().strip_prefix('=').ok_or("expected '='")?.trim();
        let component = text.split_once(']').and_then(|(head, _)| head.split_once(','));
        let unknown = || Err(format!("PR[{number}] is known only at run time"));
        let Some((_, component)) = component else {
            let found = match self.place(value) {
                _ if self.registers.is_pose_less_itself(value) => Ok(no_shift()),
                Ok((group, rest)) if rest.trim().is_empty() => Ok(group),
                _ => unknown(),
            };
            self.registers.set_position(number, found);
            if value.eq_ignore_ascii_case("LPOS") {
                self.registers.poses.insert(number);
            }
            return Ok(());
        };
        // A comment may follow.
        let component = component.split(':').next().unwrap_or(component);
        let index = self.registers.value(component)?;
        let own = self.registers.position(number);
        let value = self.registers.value(value);
        let found = match (own, value) {
            (Some(Ok(mut group)), Ok(value)) if (1.0..=6.0).contains(&index) => {
                let names = if group.parts.contains_key("j1") { JOINTS } else { POSE };
                let name = names.get(index as usize - 1).copied().unwrap_or("x");
                group.parts.insert(name.to_owned(), value);
                Ok(group)
            }
            (_, Ok(value)) => {
                self.registers.set_component(number, index, value);
                self.registers.positions.insert(number, unknown());
                return Ok(());
            }
            _ => unknown(),
        };
        self.registers.set_position(number, found);
        Ok(())
    }
}

/// The first word of a text: `R[5:feed in]mm/sec` has blanks in its comment.
pub(super) fn word(text: &str) -> &str {
    let end = outside(text, |depth, at| depth == 0 && at.starts_with([' ', '\t']));
    text.get(..end.unwrap_or(text.len())).unwrap_or("")
}

/// `Arc Start[1,2]`, `Weave Figure 8[1]`, `TA .50sec,CALL W1(1, 2)` at the start of a text, and
/// what follows.
fn split_action(text: &str) -> Option<(&str, &str)> {
    const TIMED: [&str; 3] = ["TA", "TB", "DB"];
    const PLAIN: [&str; 5] = ["ARC", "WEAVE", "WELD", "SPRAY", "TRACK"];
    let letters = text.bytes().take_while(u8::is_ascii_alphabetic).count();
    let keyword = text.get(..letters)?.to_ascii_uppercase();
    let is_timed = TIMED.contains(&keyword.as_str());
    if !is_timed && !PLAIN.contains(&keyword.as_str()) {
        return None;
    }
    let (mut end, mut count) = (word(text).len(), 1);
    loop {
        let own = text.get(..end)?.trim_end();
        let rest = text.get(end..)?.trim_start();
        let next = word(rest);
        let behind = rest.get(next.len()..)?.trim_start();
        let is_open = own.ends_with([',', '=']) || own.to_ascii_uppercase().ends_with("CALL");
        let is_first = count == 1 && end == letters;
        let is_form = matches!(next.to_ascii_uppercase().as_str(), "START" | "END")
            || next.contains('[') && split_outside(next, ",").is_none()
            || behind.starts_with(|c: char| c.is_ascii_digit());
        let belongs = is_open
            || next.starts_with(['[', '(', '=', ','])
            || is_first && (is_timed || is_form)
            || count == 2 && !is_timed && next.starts_with(|c: char| c.is_ascii_digit());
        if next.is_empty() || !belongs {
            return Some(text.split_at(end));
        }
        end = text.len() - rest.len() + next.len();
        count += 1;
    }
}

/// Six components, if the first is there.
pub(super) fn six(group: &Group, names: [&str; 6]) -> Result<Option<[f64; 6]>, String> {
    if !group.parts.contains_key(names[0]) {
        return Ok(None);
    }
    let mut found = [0.0; 6];
    for (value, name) in found.iter_mut().zip(names) {
        let part = group.parts.get(name);
        *value = *part.ok_or_else(|| format!("the position has no {}", name.to_uppercase()))?;
    }
    Ok(Some(found))
}

/// X, Y, Z in mm; W, P, R about the fixed x, y and z axes in degrees.
pub(super) fn pose([x, y, z, w, p, r]: [f64; 6]) -> Isometry3<f64> {
    let at = Translation3::new(m_from_mm(x), m_from_mm(y), m_from_mm(z));
    let [w, p, r] = [w, p, r].map(rad_from_deg);
    Isometry3::from_parts(at, UnitQuaternion::from_euler_angles(w, p, r))
}
