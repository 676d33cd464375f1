//! Offsets that vision finds: `VISION GET_OFFSET` fills VR[n], `VOFFSET,VR[n]` shifts a target by
//! it. They are read where the job says that they are zero.

use super::run::Run;
use super::words::starts_with;
use crate::program::Assumed;

impl Run<'_> {
    /// `VISION GET_OFFSET 'A' VR[3] JMP LBL[9]`: an offset that the job gives has been found, and
    /// nothing is gone to.
    pub(super) fn vision(&self, text: &str) -> Result<(), String> {
        let rest = text.get("VISION".len()..).unwrap_or("").trim_start();
        let at = rest.find("VR[").filter(|_| starts_with(rest, "GET_OFFSET"));
        let Some(register) = at.and_then(|at| rest.get(at..)) else {
            return Err(format!(
                "'{text}': what vision gives is known only at run time; in the file that is \
                 checked write the line behind //, and give by assume: in the job what it sets"
            ));
        };
        self.vision_offset("VISION GET_OFFSET", register).map(drop)
    }

    /// `VOFFSET,VR[3]` behind a target, and what follows.
    pub(super) fn vision_shift<'t>(&self, text: &'t str) -> Result<&'t str, String> {
        let behind = text.get("VOFFSET".len()..).unwrap_or("").trim_start();
        self.vision_offset("VOFFSET", behind.strip_prefix(',').unwrap_or("").trim_start())
    }

    /// What stands behind a VR[n] that is zero by the job's word.
    fn vision_offset<'t>(&self, by: &str, text: &'t str) -> Result<&'t str, String> {
        let found = self.registers.numbered(text, "VR")?;
        let (number, behind) = found.ok_or_else(|| format!("{by} without VR[n] is not read"))?;
        let name = format!("VR[{number}]");
        if self.registers.assumed(&name) == Some(Assumed::Number(0.0)) {
            return Ok(behind);
        }
        Err(format!(
            "{by}: the offset that vision finds is known only at run time; assume: \
             {{\"{name}\": 0}} in the job says that the part is found where it was taught"
        ))
    }
}
