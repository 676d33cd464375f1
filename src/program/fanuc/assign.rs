//! `PR[1]=P[2]+PR[3]`, `PR[1,3]=R[4]+5`, `PR[5]=LPOS`: what position registers are set to.

use super::expressions::OF_A_GROUP;
use super::position::{Held, JOINTS, element_of, elements, group_of, joints_by_job, places_by_job};
use super::run::Run;
use super::text::Group;
use super::vision::is_offset;
use super::words::{bare, brackets, name_length, split_outside, starts_with};

impl Run<'_> {
    /// Sets a position register or an element of one: what cannot be worked out is unknown.
    pub(super) fn assign_position(&mut self, line: usize, text: &str) -> Result<(), String> {
        if text.starts_with("PR[GP") {
            return Err(OF_A_GROUP.to_owned());
        }
        let (inside, rest) = brackets(text, "PR").ok_or("PR[ without a number")?;
        let value = rest.trim_start().strip_prefix('=').ok_or("expected '='")?;
        if value.contains("LPOS") {
            self.tell_of_flange(line, self.chosen("UTOOL").ok().flatten());
        }
        let Some((number, index)) = split_outside(inside, ",") else {
            let number = self.registers.whole(inside)?;
            let held = bare(value).and_then(|value| {
                let held = self.sum(value)?;
                let is_alone = name_length(value) == value.len();
                Ok(if is_alone { self.as_the_job_says(number, value, held) } else { held })
            });
            let held = held.unwrap_or_else(|why| Held::unknown(None, why));
            self.registers.set_position(number, held);
            return Ok(());
        };
        let (number, index) = (self.registers.whole(number)?, self.registers.whole(index)?);
        let value = self.registers.value(value);
        self.registers.set_element(number, index, value)
    }

    /// What an assignment would set is known no longer; false where it is not known which it is.
    pub(super) fn forget_position(&mut self, text: &str, why: &str) -> bool {
        let Some((inside, _)) = brackets(text, "PR") else { return false };
        let (number, index) = match split_outside(inside, ",") {
            Some((number, index)) => (number, Some(index)),
            None => (inside, None),
        };
        let Ok(number) = self.registers.whole(number) else { return false };
        match index.map(|index| self.registers.whole(index)) {
            Some(Ok(index)) => self.registers.set_element(number, index, Err(why.into())).is_ok(),
            Some(Err(_)) | None => {
                self.registers.set_position(number, Held::unknown(None, why));
                true
            }
        }
    }

    /// What only the run knows of vision, and of LPOS and JPOS before the first move, is what the
    /// job says of the register that is set to it. Behind a move the program says about where the
    /// arm is, and the job may mean another place.
    fn as_the_job_says(&self, number: i64, value: &str, held: Held) -> Held {
        let is_vision = starts_with(value, "VR[");
        let are_joints = starts_with(value, "JPOS");
        let is_start = (are_joints || starts_with(value, "LPOS")) && !self.log.has_moved();
        if held.is_known() || !(is_vision || is_start) {
            return held;
        }
        let name = format!("PR[{number}]");
        let given = |of: &str| self.registers.given(&of.to_lowercase());
        let all = self.registers.position_of_job(number, given);
        let once = |of: &str| self.registers.given_once(&of.to_lowercase());
        let left = self.registers.position_of_job(number, once);
        let hint = if left != all {
            format!(
                "; what assume: in the job gives of {name} has served before, and serves once: in \
                 the file that is checked set its elements to numbers here"
            )
        } else if is_vision && is_offset(value) {
            // Of an offset the register of vision says more.
            String::new()
        } else if are_joints {
            format!("; {}", joints_by_job(&name))
        } else {
            format!("; {}", places_by_job(&name))
        };
        held.completed(&left, &hint)
    }

    /// Positions added and subtracted: `LPOS-LPOS`, `PR[1]+P[R[2]]`.
    fn sum(&self, text: &str) -> Result<Held, String> {
        let (first, mut total, mut rest) = self.operand(text)?;
        let mut is_first = true;
        loop {
            rest = rest.trim_start();
            let sign = match rest.chars().next() {
                None => return Ok(total),
                Some('+') => 1.0,
                Some('-') => -1.0,
                Some(_) => return Err(format!("'{rest}' is not understood behind a position")),
            };
            let (name, next, behind) = self.operand(rest.get(1..).unwrap_or(""))?;
            total = total.plus(sign, &next, is_first && name == first);
            is_first = false;
            rest = behind;
        }
    }

    /// A position at the start of a text with its name, and what follows.
    fn operand<'t>(&self, text: &'t str) -> Result<(String, Held, &'t str), String> {
        let text = text.trim_start();
        if let Some((number, rest)) = self.registers.numbered(text, "PR")? {
            let name = format!("PR[{number}]");
            let hint = format!(
                "; assume: {{\"{name}\": 0}} in the job says that it is an offset of 0 until the \
                 program sets it, and {{\"{}\": …, …, \"{}\": …}} gives a place",
                element_of(&name, 1),
                element_of(&name, 6)
            );
            let held = self.registers.position(number).named(&name, &hint);
            return Ok((name, held, rest));
        }
        if let Some(found) = self.vision_position(text)? {
            return Ok(found);
        }
        if let Some((number, rest)) = self.registers.numbered(text, "P")? {
            return Ok((format!("P[{number}]"), Held::of(&self.taught(number)?), rest));
        }
        for list in ["UFRAME", "UTOOL"] {
            if let Some((number, rest)) = self.registers.numbered(text, list)? {
                let held = self.frame_given(list, number).map(|frame| {
                    let six = elements(&frame);
                    Held::of(&group_of(six))
                });
                let held = held.unwrap_or_else(|why| Held::unknown(Some(false), why));
                return Ok((format!("{list}[{number}]"), held, rest));
            }
        }
        for (name, are_joints) in [("LPOS", false), ("JPOS", true)] {
            if starts_with(text, name) {
                let behind = text.get(name.len()..).unwrap_or("");
                let found = if are_joints { self.joints_now() } else { self.pose_now() };
                let held = found.map(|group| Held::of(&group)).unwrap_or_else(|mut why| {
                    if !self.log.has_moved() && !behind.trim().is_empty() {
                        why.push_str(&format!(
                            "; in the file that is checked set a PR[n] to {name} alone and add to \
                             that: then assume: {{\"PR[n,1]\": …, …}} in the job can give it"
                        ));
                    }
                    Held::unknown(Some(are_joints), why)
                });
                return Ok((name.to_owned(), held, behind));
            }
        }
        Err(format!("'{}' is not read as a position", text.trim_end()))
    }

    /// LPOS: where the tool is, in the frames that are chosen.
    fn pose_now(&self) -> Result<Group, String> {
        self.is_at_target("LPOS")?;
        let last = self.log.last();
        let last = last.ok_or("LPOS behind a move to joints is known only at run time")?;
        let frame = self.base_of(self.chosen("UFRAME")?)?;
        let tcp = self.tcp(self.chosen("UTOOL")?.unwrap_or(0))?;
        let mut group = group_of(elements(&(frame.inverse() * last.with(&tcp))));
        group.config.clone_from(&self.config);
        group.parts.extend(self.axes.clone());
        Ok(group)
    }

    /// JPOS: where the joints are.
    fn joints_now(&self) -> Result<Group, String> {
        self.is_at_target("JPOS")?;
        let joints = self.joints.ok_or("JPOS behind a move to a pose is known only at run time")?;
        let mut group = Group::default();
        group.parts.extend(JOINTS.map(str::to_owned).into_iter().zip(joints));
        group.parts.extend(self.axes.clone());
        Ok(group)
    }

    /// Where the arm is is known behind a move that stops at its end.
    fn is_at_target(&self, name: &str) -> Result<(), String> {
        self.stands.clone().map_err(|why| format!("{name} {why}"))
    }
}
