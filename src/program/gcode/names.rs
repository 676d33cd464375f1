//! Words of several letters, as Sinumerik and others have them: which may be left out.

use super::state::Machine;

/// Words without motion of their own and without effect on later motion.
const HARMLESS: [&str; 39] = [
    "FNORM",
    "DIAMOF",
    "MSG",
    "CYCLE832",
    "TRAFOOF",
    "FFWON",
    "FFWOF",
    "SOFT",
    "BRISK",
    "COMPOF",
    "COMPON",
    "COMPCAD",
    "COMPCURV",
    "STOPRE",
    "CUT2DF",
    "CUT2D",
    "ORIWKS",
    "ORIMKS",
    "ORIAXES",
    "ORIVECT",
    "WORKPIECE",
    "CFTCP",
    "CFC",
    "CFIN",
    "G0DIST",
    "SETAL",
    "DEF",
    "PROC",
    "EXTERN",
    "GROUP",
    "GROUP_BEGIN",
    "GROUP_END",
    "T=",
    "D=",
    "FGROUP",
    "RTLIOF",
    "RTLION",
    "UPATH",
    "SPOS",
];

/// Frames that end where they have no values.
const FRAMES: [&str; 11] = [
    "TRANS", "ATRANS", "ROT", "AROT", "SCALE", "ASCALE", "MIRROR", "AMIRROR", "CYCLE800", "ROTS",
    "AROTS",
];

/// What a name does to its block.
pub(super) enum Name {
    /// Nothing.
    None,
    /// The block's axes are those of the machine.
    Machine,
    /// The subprogram ends.
    Back,
}

impl Machine<'_> {
    pub(super) fn name(
        &mut self,
        line: usize,
        name: &str,
        inside: &str,
        has_axes: bool,
    ) -> Result<Name, String> {
        if name == "SUPA" {
            return Ok(Name::Machine);
        }
        if name == "RET" {
            return Ok(Name::Back);
        }
        if name == "TRAORI" {
            // Places are those of the tool tip; directions by A3 to C3 or the job's rotary axes.
            return Ok(Name::None);
        }
        if name == "T=" {
            self.cutter.named_tool(line, inside);
            return Ok(Name::None);
        }
        if name == "MCALL"
            || (name.starts_with("CYCLE") && !matches!(name, "CYCLE832" | "CYCLE800"))
        {
            return Err(format!("{name}: Sinumerik's cycles are not supported"));
        }
        if HARMLESS.contains(&name) {
            return Ok(Name::None);
        }
        if FRAMES.contains(&name) {
            let is_zero = inside.split(',').all(|part| {
                let part = part.trim();
                part.is_empty() || part.starts_with('"') || part.parse() == Ok(0.0)
            });
            // CYCLE800's first numbers are modes.
            let resets = inside.trim().is_empty() || (is_zero && name != "CYCLE800");
            if resets && !has_axes {
                return Ok(Name::None);
            }
            return Err(format!("{name} shifts or turns the work and is not supported"));
        }
        Err(format!("'{name}' is not understood, must be letters each with a number"))
    }
}
