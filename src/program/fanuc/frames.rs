//! `UFRAME[9]=PR[9]`, `UTOOL[9]=PR[9]`: frames that the program sets itself; those that are chosen.

use nalgebra::{Isometry3, UnitQuaternion};

use super::position::{JOINTS, POSE, pose, six};
use super::run::{BEHIND_ERROR, Run};
use super::text::Group;
use crate::notes::Code;
use crate::program::cell::{base_frame, tool_frame};

impl Run<'_> {
    /// Sets a frame to a position register, where that is known.
    pub(super) fn set_frame(
        &mut self,
        line: usize,
        list: &'static str,
        text: &str,
    ) -> Result<(), String> {
        let found = self.registers.numbered(text, list)?;
        let (number, rest) = found.ok_or_else(|| format!("{list}[ and a number"))?;
        let number = u32::try_from(number).map_err(|_| format!("{list}[{number}]"))?;
        if number == 0 {
            let fixed = if list == "UTOOL" { "the flange" } else { "the robot's base frame" };
            return Err(format!(
                "{list}[0] cannot be set: it is {fixed}, and the controller stops with an alarm; \
                 set {list}[1] or a later one, and choose that by {list}_NUM"
            ));
        }
        let known = self.frame_from(list, number, rest);
        let unread = |_| Err(format!("{list}[{number}] {BEHIND_ERROR}"));
        self.frames.insert((list, number), known.clone().or_else(unread));
        known?;
        // Which one a condition that names it takes is not known.
        self.offsets.retain(|own, condition| *own != list || condition.axes_of != Some(number));
        if self.frame_of_job(list, number).is_some() {
            let what = format!("the program sets {list}[{number}]: the job's is not used there");
            self.log.warning(Code::FrameFromProgram, line, what);
        }
        Ok(())
    }

    /// What a frame is set to: `=PR[9]`.
    fn frame_from(&self, list: &str, number: u32, text: &str) -> Result<Isometry3<f64>, String> {
        let from = text.trim_start().strip_prefix('=').map(str::trim_start).ok_or_else(|| {
            format!(
                "{list}[{number}] sets nothing: expected {list}[{number}]=PR[n], which sets it, or \
                 {list}_NUM={number}, which chooses it"
            )
        })?;
        let from = self.registers.numbered(from, "PR")?;
        let Some((from, "")) = from.map(|(from, rest)| (from, rest.trim())) else {
            return Err(format!("{list}[{number}] is set to what is not PR[n]: not supported"));
        };
        let group = self.registers.position(from).target(&format!("PR[{from}]"));
        let known = group
            .map_err(String::from)
            .and_then(|group| six(&group, POSE)?.ok_or_else(|| format!("PR[{from}] holds joints")));
        known.map(pose).map_err(|why| {
            format!("{list}[{number}] is set to PR[{from}], which is not known as a pose: {why}")
        })
    }

    /// Tells where another may have chosen the frame or the tool in which a target counts that has
    /// none of its own.
    pub(super) fn tell_chosen(
        &mut self,
        line: usize,
        name: &str,
        group: &Group,
        is_register: bool,
    ) {
        let are_joints = group.parts.contains_key(JOINTS[0]);
        let has_own = |own: Option<u32>| own.is_some() && !is_register;
        let lists = [
            ("UFRAME", has_own(group.frame) || are_joints, &self.chosen_by[0]),
            ("UTOOL", has_own(group.tool), &self.chosen_by[1]),
        ];
        for (list, has_own, by) in lists {
            let Some(who) = by.as_ref().filter(|_| !has_own) else { continue };
            let what = format!(
                "{who} may choose another {list}: {name} is read in the one that was chosen before"
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// Whether a taught point is of the frames that the program has chosen: the controller stops
    /// where it is of others.
    pub(super) fn frames_agree(&mut self, name: &str, group: &Group) -> Result<(), String> {
        // Joints need no frame.
        let frame = group.frame.filter(|_| !group.parts.contains_key(JOINTS[0]));
        let of_point = [frame, group.tool];
        for (at, short, long, chosen) in
            [(0, "UF", "UFRAME_NUM", self.frame), (1, "UT", "UTOOL_NUM", self.tool)]
        {
            let Some(own) = of_point[at] else { continue };
            let may_be_another = self.chosen_by[at].take().is_some();
            match chosen {
                Some(chosen) if chosen != own && !may_be_another => {
                    return Err(format!(
                        "{name} has {short} : {own}, and {long} is {chosen} here: the controller \
                         stops with an alarm unless $FRM_CHKTYP = -1 switches that check off; \
                         write {long}={own} before the move"
                    ));
                }
                // Under another than its own the controller would stop.
                Some(_) if at == 0 => self.frame = Some(own),
                Some(_) => self.tool = Some(own),
                None => match self.of_target[at] {
                    Some(before) if before != own && !may_be_another => {
                        return Err(format!(
                            "{name} has {short} : {own}, the target before has {short} : {before}, \
                             and no {long} stands between: the controller stops with an alarm at \
                             one of them unless $FRM_CHKTYP = -1 switches that check off; write \
                             {long}={own} before the move"
                        ));
                    }
                    _ => {}
                },
            }
        }
        self.of_target = [frame.or(self.of_target[0]), group.tool.or(self.of_target[1])];
        Ok(())
    }

    /// The number of the frame or tool in which position registers count: what the program says,
    /// else that of its positions, as the controller would stop at them under another.
    pub(super) fn chosen(&self, list: &'static str) -> Result<Option<u32>, String> {
        let (said, numbers) = match list {
            "UTOOL" => (self.tool.or(self.of_target[1]), &self.source.tools),
            _ => (self.frame.or(self.of_target[0]), &self.source.frames),
        };
        let mut of_positions = numbers.of_positions.iter().copied();
        match (said, of_positions.next(), of_positions.next()) {
            (Some(said), ..) => Ok(Some(said)),
            (None, only, None) if !numbers.are_chosen => Ok(only),
            _ => Err(format!(
                "{list}_NUM is not set before: in which a position register counts is known only \
                 at run time; write {list}_NUM=… before the move in the file that is checked"
            )),
        }
    }

    /// A frame that the program has set.
    fn own_frame(&self, list: &'static str, number: u32) -> Option<Result<Isometry3<f64>, String>> {
        self.frames.get(&(list, number)).cloned()
    }

    /// A frame that the job gives by its number.
    fn frame_of_job(&self, list: &str, number: u32) -> Option<Isometry3<f64>> {
        let frames = match list {
            "UTOOL" => &self.settings.tool_frames,
            _ => &self.settings.base_frames,
        };
        frames.get(&number).copied()
    }

    /// How the axes of the frame or tool that is named stand in the one that is chosen, `own`.
    pub(super) fn turned_from(
        &self,
        list: &'static str,
        named: Option<u32>,
        (own, chosen): (Option<u32>, &Isometry3<f64>),
    ) -> Result<UnitQuaternion<f64>, String> {
        let named = match named.filter(|_| named != own) {
            None => return Ok(UnitQuaternion::identity()),
            Some(0) if list == "UFRAME" => self.base_of(Some(0))?,
            Some(named) => self.frame_given(list, i64::from(named))?,
        };
        Ok(chosen.rotation.inverse() * named.rotation)
    }

    /// A frame that the program has set, or that the job gives by its number.
    pub(super) fn frame_given(
        &self,
        list: &'static str,
        number: i64,
    ) -> Result<Isometry3<f64>, String> {
        let known = u32::try_from(number).ok().and_then(|number| {
            self.own_frame(list, number).or_else(|| self.frame_of_job(list, number).map(Ok))
        });
        let key = if list == "UTOOL" { "tool_frames" } else { "base_frames" };
        known.unwrap_or_else(|| {
            Err(format!(
                "{list}[{number}] is in no file that is read; path.program.{key}: {{{number}: …}} \
                 in the job can give it"
            ))
        })
    }

    /// The tool centre point of a tool in the tip frame.
    pub(super) fn tcp(&self, tool: u32) -> Result<Isometry3<f64>, String> {
        let own = self.own_frame("UTOOL", tool);
        own.unwrap_or_else(|| tool_frame(self.settings, f64::from(tool), "UTOOL"))
    }

    /// To the controller tool 0 is the faceplate; a job may mean it by its tcp.
    pub(super) fn tell_of_flange(&mut self, line: usize, tool: Option<u32>) {
        let is_given = self.settings.tool_frames.contains_key(&0);
        let is_longer = self.settings.tcp.is_some_and(|tcp| tcp != Isometry3::identity());
        if tool == Some(0) && is_longer && !is_given {
            let what = "UTOOL 0 is the faceplate without a tool, and the job's tcp is taken for \
                        it: path.program.tool_frames: {0: …} in the job says where tool 0 is, \
                        {xyz_m: [0, 0, 0]} for the faceplate";
            self.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    /// Whether the program has set the tool itself.
    pub(super) fn is_own_tool(&self, tool: u32) -> bool {
        self.own_frame("UTOOL", tool).is_some()
    }

    /// A user frame in the base frame of the robot; the job's work object where none is chosen.
    pub(super) fn base_of(&self, frame: Option<u32>) -> Result<Isometry3<f64>, String> {
        let Some(frame) = frame else {
            return Ok(self.settings.work_object.unwrap_or_default());
        };
        let own = self.own_frame("UFRAME", frame);
        own.unwrap_or_else(|| base_frame(self.settings, f64::from(frame), "UFRAME"))
    }
}
