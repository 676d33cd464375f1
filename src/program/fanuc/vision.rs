//! Offsets that vision finds: `VISION GET_OFFSET` fills VR[n], `VOFFSET,VR[n]` shifts a target by
//! it, `PR[1]=VR[n].OFFSET` takes it. They are read where the job says that they are zero.

use super::position::{Held, group_of};
use super::run::Run;
use super::words::{name_length, starts_with};
use crate::program::Assumed;

/// Whether a name is that of the offset of a VR[n].
pub(super) fn is_offset(name: &str) -> bool {
    name.to_ascii_uppercase().ends_with(".OFFSET")
}

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

    /// `VR[3].OFFSET` or `VR[3].FOUND_POS[1]` at the start of a text as a position with its name,
    /// and what follows.
    pub(super) fn vision_position<'t>(
        &self,
        text: &'t str,
    ) -> Result<Option<(String, Held, &'t str)>, String> {
        let Some((number, _)) = self.registers.numbered(text, "VR")? else { return Ok(None) };
        let (name, behind) = text.split_at(name_length(text));
        let register = format!("VR[{number}]");
        let held = match is_offset(name) {
            true if self.is_taught(&register) => Held::of(&group_of([0.0; 6])),
            true => {
                let hint = as_taught(&register);
                Held::unknown(Some(false), format!("{name} is what vision finds{hint}"))
            }
            false => Held::unknown(Some(false), format!("{name} is what vision finds")),
        };
        Ok(Some((name.to_owned(), held, behind)))
    }

    /// Whether vision finds the part where it was taught, by the job's word.
    fn is_taught(&self, register: &str) -> bool {
        self.registers.assumed(register) == Some(Assumed::Number(0.0))
    }

    /// What stands behind a VR[n] that is zero by the job's word.
    fn vision_offset<'t>(&self, by: &str, text: &'t str) -> Result<&'t str, String> {
        let found = self.registers.numbered(text, "VR")?;
        let (number, behind) = found.ok_or_else(|| format!("{by} without VR[n] is not read"))?;
        let name = format!("VR[{number}]");
        if self.is_taught(&name) {
            return Ok(behind);
        }
        Err(format!(
            "{by}: the offset that vision finds is known only at run time{}",
            as_taught(&name)
        ))
    }
}

/// What the job can say of what vision finds.
fn as_taught(register: &str) -> String {
    format!(
        "; assume: {{\"{register}\": 0}} in the job says that the part is found where it was taught"
    )
}
