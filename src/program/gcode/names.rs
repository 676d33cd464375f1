//! Words of several letters, as Sinumerik and others have them: which may be left out.

use super::abbreviated::output;
use super::block::{Block, PLANE_TURN, Word};
use super::parameters::Parameters;
use super::siemens::DrillingCall;
use super::state::{AXES, Machine, Motion};
use crate::notes::Code;

/// Words without motion of their own and without effect on later motion.
const HARMLESS: [&str; 43] = [
    "FNORM",
    "DIAMOF",
    "MSG",
    "CYCLE832",
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
    "CPRECOF",
    "G0DIST",
    "SETAL",
    "GROUP",
    "GROUP_BEGIN",
    "GROUP_END",
    "T=",
    "D=",
    "RTLIOF",
    "RTLION",
    "UPATH",
    "DYNNORM",
    "DYNPOS",
    "DYNROUGH",
    "DYNSEMIFIN",
    "DYNFINISH",
    "NORM",
    "CDOF",
    "ORISON",
    "ORISOF",
];

/// Words that change what later blocks mean, and why they are refused.
const REFUSED: [(&str, &str); 7] = [
    ("DEFINE", IS_TEXT),
    ("DIAMON", IS_DIAMETER),
    ("DIAM90", IS_DIAMETER),
    ("ASPLINE", IS_SPLINE),
    ("BSPLINE", IS_SPLINE),
    ("CSPLINE", IS_SPLINE),
    ("POLY", "moves by polynomials, which are not read: have lines and arcs written"),
];
const IS_TEXT: &str = "gives a text a name, which is not read: write the text where the name \
                       stands, and leave the DEFINE out";
const IS_DIAMETER: &str = "makes X a diameter, as in turning, which is not read: have DIAMOF and \
                           radii written";
const IS_SPLINE: &str = "begins a spline, which is not read: have lines and arcs written";

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
    /// A file of its own may have this name.
    Call,
    /// Done: its axes are those of a frame that shifts and turns nothing, or it is a head.
    Frame,
}

impl Machine<'_> {
    pub(super) fn name(
        &mut self,
        line: usize,
        name: &str,
        inside: &str,
        block: &Block,
        known: &Parameters,
    ) -> Result<Name, String> {
        if name == "SUPA" {
            return Ok(Name::Machine);
        }
        if matches!(name, "RET" | "ENDPROC") {
            return Ok(Name::Back);
        }
        if name == "EXTERN" && block.words.iter().all(|word| matches!(word.letter, b'N' | b'L')) {
            // The head of a subprogram of another file, which is called elsewhere.
            return Ok(Name::Frame);
        }
        if name == "PROC" {
            // The head of a subprogram, its name behind.
            return match block.names.iter().any(|(own, _)| own == "SAVE") {
                true => {
                    Err("PROC with SAVE, behind which modes go back, is not supported".to_owned())
                }
                false => Ok(Name::Frame),
            };
        }
        if name == "TRAORI" {
            // Directions by A3 to C3 or the job's rotary axes.
            self.follow_tip(true)?;
            return Ok(Name::None);
        }
        if name == "TRAFOOF" {
            self.follow_tip(false)?;
            return Ok(Name::None);
        }
        if name == "SETMS" && matches!(inside.trim(), "" | "1") {
            // The first spindle is the master, as it is read.
            return Ok(Name::None);
        }
        if name == "SETMS" {
            return Err(format!(
                "SETMS({inside}) makes another spindle the main one, and a program is read with \
                 the first alone: not supported"
            ));
        }
        if name == "CPRECON" && self.is_sinumerik {
            // Siemens, SINUMERIK 840D sl/828D Fundamentals, "Contour accuracy".
            let what = "CPRECON lowers the feed on bends to keep the contour, as far as setting \
                        data of the control say, which are not read: the feed is taken as F";
            self.cutter.log.warning(Code::MotionLeftOut, line, what);
            return Ok(Name::None);
        }
        if name == "T=" {
            match self.cutter.number_of(inside) {
                Some(number) => self.select_tool(f64::from(number))?,
                None => self.cutter.named_tool(line, inside),
            }
            return Ok(Name::None);
        }
        if name == "SPOS" {
            // The spindle stands at an angle until it is started anew.
            self.cutter.turn_spindle(line, false);
            return Ok(Name::None);
        }
        if name == "FGROUP" {
            // The axes whose way the feed is along; none: those of the machine.
            let mut axes: Vec<String> =
                inside.split(',').map(|own| own.trim().to_ascii_uppercase()).collect();
            axes.sort();
            let is_usual = inside.trim().is_empty() || axes == ["X", "Y", "Z"];
            let what = format!("FGROUP({inside}): the feed along other axes is not supported");
            return if is_usual { Ok(Name::None) } else { Err(what) };
        }
        if matches!(name, "TRANS" | "ATRANS") && block.names.len() == 1 {
            let given = AXES.map(|axis| block.word(axis).map(|word| self.mm(word.value)));
            let others = |word: &&Word| word.letter != b'N' && !AXES.contains(&word.letter);
            if inside.is_empty() && !block.words.iter().any(|word| others(&word)) {
                self.no_corner()?;
                self.shift.translate(given, name == "ATRANS");
                return Ok(Name::Frame);
            }
        }
        if name == "MCALL" {
            self.called = None;
            return match block.names.as_slice() {
                [_] => Ok(Name::None),
                [_, (cycle, _)] if is_drilling(cycle) => Ok(Name::None),
                _ => Err("MCALL: what it calls is not supported".to_owned()),
            };
        }
        if matches!(name, "CIP" | "CT") && self.is_sinumerik {
            self.keeps_frame(name)?;
            self.motion = if name == "CIP" { Motion::Through } else { Motion::Tangent };
            return Ok(Name::None);
        }
        if matches!(name, "HOLES1" | "HOLES2") && self.is_sinumerik {
            if block.names.len() > 1 || block.words.iter().any(|word| word.letter != b'N') {
                return Err(format!("{name} must stand in a block of its own"));
            }
            return self.pattern(line, name, inside, known).map(|()| Name::None);
        }
        if is_drilling(name) {
            let call = DrillingCall::read(name, inside, known)?;
            if block.names.first().is_some_and(|(first, _)| first == "MCALL") {
                self.called = Some(call);
                return Ok(Name::None);
            }
            if block.words.iter().any(|word| word.letter != b'N') {
                return Err(format!("{name}: the cycle must stand in a block of its own"));
            }
            return self.drill_call(line, &call).map(|()| Name::None);
        }
        if HARMLESS.contains(&name) {
            return Ok(Name::None);
        }
        if !self.is_sinumerik && output(name).is_some() {
            let what = format!("{name} only sends data to another device: it is left out");
            self.cutter.left_out(line, what);
            return Ok(Name::None);
        }
        if let Some((_, why)) = REFUSED.into_iter().find(|(own, _)| *own == name) {
            return Err(format!("{name} {why}"));
        }
        if FRAMES.contains(&name) {
            let is_zero = inside.split(',').all(|part| {
                let part = part.trim();
                part.is_empty() || part.starts_with('"') || part.parse() == Ok(0.0)
            });
            // CYCLE800 (_FR, _TC, _ST, _MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, …): modes apart,
            // zero turns back to the plane as it was.
            let resets = match name {
                "CYCLE800" => inside.trim().is_empty() || turns_nothing(inside),
                _ => is_zero,
            };
            // Factors are 1 where they change nothing, and a mirror names axes alone.
            let by_zero = ["ROT", "AROT"].contains(&name);
            let zeros = || {
                let is_zero = |word: &Word| AXES.contains(&word.letter) && word.value == 0.0;
                block.words.iter().all(|word| word.letter == b'N' || is_zero(word))
            };
            let turns = block.word(PLANE_TURN).is_some_and(|word| word.value != 0.0);
            match block.has_any(&AXES) {
                false if resets && !turns => {
                    // What begins anew ends TRANS, too.
                    if !name.starts_with('A') {
                        self.shift.translate([None; 3], false);
                    }
                    if name == "CYCLE800" && retracts(inside) {
                        self.cutter.leave(line, [true; 3], "CYCLE800");
                    }
                    return Ok(Name::None);
                }
                true if resets && by_zero && zeros() && block.names.len() == 1 => {
                    if !name.starts_with('A') {
                        self.shift.translate([None; 3], false);
                    }
                    return Ok(Name::Frame);
                }
                _ => {}
            }
            return Err(format!("{name} shifts or turns the work and is not supported"));
        }
        if self.is_sinumerik {
            let others = |word: &Word| !matches!(word.letter, b'N' | b'P');
            if block.names.len() > 1 || block.words.iter().any(others) {
                return Err(format!(
                    "'{name}' calls a subprogram or a cycle that is not read, or is not understood"
                ));
            }
            return Ok(Name::Call);
        }
        Err(format!("'{name}' is not understood, must be letters each with a number"))
    }
}

/// Cycles, but for those that set something.
fn is_drilling(name: &str) -> bool {
    name.starts_with("CYCLE") && !matches!(name, "CYCLE832" | "CYCLE800")
}

/// Whether CYCLE800 takes the tool away first: _FR is not 0.
fn retracts(inside: &str) -> bool {
    let first = inside.split(',').next().unwrap_or("").trim();
    !first.is_empty() && first.parse() != Ok(0.0)
}

/// Whether CYCLE800's shifts and angles are all stated, and zero.
fn turns_nothing(inside: &str) -> bool {
    let parts: Vec<&str> = inside.split(',').collect();
    parts.get(4..13).is_some_and(|own| own.iter().all(|part| part.trim().parse() == Ok(0.0)))
}
