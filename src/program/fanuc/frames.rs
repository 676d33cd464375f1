//! `UFRAME[9]=PR[9]`, `UTOOL[9]=PR[9]`: frames that the program sets itself.

use nalgebra::Isometry3;

use super::motion::{pose, six};
use super::registers::{JOINTS, POSE, register};
use super::run::Run;
use super::text::Group;
use crate::notes::Code;

impl Run<'_> {
    /// Sets a frame to a position register, where that is known.
    pub(super) fn set_frame(
        &mut self,
        line: usize,
        list: &'static str,
        text: &str,
    ) -> Result<(), String> {
        let (number, rest) = register(text, list).ok_or_else(|| format!("{list}[ and a number"))?;
        let number = u32::try_from(number).map_err(|_| format!("{list}[{number}]"))?;
        let from = rest.trim_start().strip_prefix('=').map(str::trim_start);
        let from = from.and_then(|value| register(value, "PR"));
        let Some((from, "")) = from.map(|(from, rest)| (from, rest.trim())) else {
            return Err(format!("{list}[{number}] is set to what is not PR[n]: not supported"));
        };
        let known = match self.registers.position(from) {
            Some(Ok(group)) => six(&group, POSE)?,
            _ => self.registers.all_components(from),
        };
        let known = known.ok_or_else(|| {
            format!("{list}[{number}] is set to PR[{from}], which is not known as a pose")
        })?;
        let of_job = match list {
            "UTOOL" => self.settings.tool_frames.contains_key(&number),
            _ => self.settings.base_frames.contains_key(&number),
        };
        if of_job {
            let what = format!("the program sets {list}[{number}]: the job's is not used there");
            self.log.warning(Code::FrameFromProgram, line, what);
        }
        self.frames.insert((list, number), pose(known));
        Ok(())
    }

    /// Whether a taught point is of the frames that the program has chosen: the controller stops
    /// where it is of others.
    pub(super) fn frames_agree(&self, text: &str, group: &Group) -> Result<(), String> {
        let Some((number, _)) = register(text, "P") else { return Ok(()) };
        // Joints need no frame.
        let frame = group.frame.filter(|_| !group.parts.contains_key(JOINTS[0]));
        for (short, of_point, long, chosen) in
            [("UF", frame, "UFRAME_NUM", self.frame), ("UT", group.tool, "UTOOL_NUM", self.tool)]
        {
            if let (Some(own), Some(chosen)) = (of_point, chosen)
                && own != chosen
            {
                return Err(format!(
                    "P[{number}] has {short} : {own}, and {long} is {chosen} here: the controller \
                     stops with an alarm"
                ));
            }
        }
        Ok(())
    }

    /// A frame that the program has set.
    pub(super) fn own_frame(&self, list: &'static str, number: u32) -> Option<Isometry3<f64>> {
        self.frames.get(&(list, number)).copied()
    }
}
