//! What stands before `=` in Sinumerik's blocks: addresses of several letters, elements of arrays,
//! variables of the control.

use super::block::{
    ANGLE, BLOCK_FEED, Block, CHAMFER_LENGTH, CHAMFERED, Counts, DIRECTION, LIMIT, Lexer,
    ON_THE_WAY, OPENING, PLANE_TURN, POLAR_ANGLE, POLAR_RADIUS, RADIUS, ROUNDED, TURNS, Word, add,
};
use super::expression::Reader;
use super::parameters::Key;
use super::variables;
use super::words::refuse_with_axis;

impl Lexer<'_> {
    /// `CR=5`, `X=IC(5)`, `R1=5`, `S1=900`, `T="MILL"`.
    pub(super) fn named(&mut self, name: &str, block: &mut Block) -> Result<(), String> {
        // Parentheses behind `=` are arithmetic.
        while matches!(self.byte(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
        let bytes = name.as_bytes();
        let digits =
            |from: usize| bytes.get(from..).is_some_and(|d| d.iter().all(u8::is_ascii_digit));
        if bytes.first() == Some(&b'R') && bytes.len() > 1 && digits(1) {
            let key = Key::Name(name.to_ascii_lowercase());
            return self.set(key, block);
        }
        let key = Key::Name(name.to_ascii_lowercase());
        let letter = match name {
            "CR" => RADIUS,
            "A3" => DIRECTION[0],
            "B3" => DIRECTION[1],
            "C3" => DIRECTION[2],
            "RND" => ROUNDED,
            "CHR" => CHAMFERED,
            "CHF" => CHAMFER_LENGTH,
            "TURN" => TURNS,
            "AP" => POLAR_ANGLE,
            "RP" => POLAR_RADIUS,
            "ANG" => ANGLE,
            "FB" => BLOCK_FEED,
            "RPL" if block.names.iter().any(|(own, _)| matches!(&own[..], "ROT" | "AROT")) => {
                PLANE_TURN
            }
            "LIMS" => LIMIT,
            "AR" => OPENING,
            "I1" => ON_THE_WAY[0],
            "J1" => ON_THE_WAY[1],
            "K1" => ON_THE_WAY[2],
            // The main spindle is the first.
            "S1" | "M1" => bytes[0],
            "SPOS" | "SPOSA" => {
                block.names.push(("SPOS".to_owned(), String::new()));
                return self.computed(block, Reader::expression).map(|_| ());
            }
            // Of the machine, as G74 and G75 name them, and which fixed point.
            "X1" | "Y1" | "Z1" | "A1" | "B1" | "C1" if is_to_machine(block) => bytes[0],
            "FP" if is_to_machine(block) => {
                return self.computed(block, Reader::expression).map(|_| ());
            }
            // How corners are smoothed.
            "ADIS" | "ADISPOS" | "CTOL" | "OTOL" | "ATOL" => {
                return self.computed(block, Reader::expression).map(|_| ());
            }
            _ if bytes.len() == 1 && bytes[0] != b'_' => bytes[0],
            _ if self.parameters.is_text(&key) => return self.left_out_text(name),
            _ => {
                if !name.starts_with('_') && !self.parameters.may_set(&key) {
                    let declared = self.parameters.declared_by_job(&key);
                    return Err(format!("'{name}=' is not understood{declared}"));
                }
                return self.set(key, block);
            }
        };
        if self.parameters.is_sinumerik() && self.parameters.held(&key).is_some() {
            return Err(format!(
                "'{name}=': {name} is an address of the control, and a variable has the same name: \
                 which is meant is not clear; a name of a variable begins with two letters or \
                 underscores"
            ));
        }
        if self.byte() == Some(b'"') {
            let text = self.text()?.to_owned();
            block.names.push((format!("{name}="), text));
            return Ok(());
        }
        let rest = self.line.get(self.at..).unwrap_or("");
        let start = rest.get(..3).map(str::to_ascii_uppercase);
        let counts = match start.as_deref() {
            Some("AC(") => Counts::Absolute,
            Some("IC(") => Counts::Relative,
            // The short way to an angle, or one way round.
            Some("DC(" | "ACP" | "ACN") => Counts::Absolute,
            _ => Counts::AsModal,
        };
        if counts != Counts::AsModal {
            self.at += rest.find('(').unwrap_or(2);
            let (value, _) = self.computed(block, Reader::primary)?;
            let word =
                Word { letter, value, span: None, counts, has_point: true, is_computed: true };
            return add(block, word);
        }
        let (value, span) = match self.computed(block, Reader::expression) {
            // Where the machine goes, the program does not say in any case.
            Err(_) if self.is_of_machine() => {
                self.at += rest.find([' ', '\t']).unwrap_or(rest.len());
                (0.0, None)
            }
            found => found?,
        };
        add(block, Word { letter, value, span, counts, has_point: true, is_computed: true })
    }

    /// A variable of the kind STRING is set, which matters where it is read alone.
    fn left_out_text(&mut self, name: &str) -> Result<(), String> {
        match self.byte() {
            Some(b'"') => self.text().map(|_| ()),
            _ => Err(format!("'{name}=' sets a text (STRING), which is read as \"…\" alone")),
        }
    }

    /// Whether the block's places are those of the machine.
    fn is_of_machine(&self) -> bool {
        let words = self.line.split_whitespace();
        words.map(str::to_ascii_uppercase).any(|word| matches!(&word[..], "SUPA" | "G53" | "G153"))
    }

    /// `R[4]=`, `FEEDS[2]=`: its name is so long.
    pub(super) fn element(
        &mut self,
        name: &str,
        length: usize,
        block: &mut Block,
    ) -> Result<(), String> {
        let at = self.at + length;
        let inside = self.line.get(at + 1..).and_then(|rest| rest.split(']').next());
        refuse_with_axis(name, inside.unwrap_or("").trim())?;
        let (key, at) = variables::element(name, self.bytes, at, self.parameters)?;
        self.at = at;
        self.set(key, block)
    }

    /// `$AC_TIMER[1]=0`: a variable of the control.
    pub(super) fn of_control(&mut self, block: &Block) -> Result<(), String> {
        let rest = self.line.get(self.at..).unwrap_or("");
        let is_part = |c: &char| c.is_ascii_alphanumeric() || *c == '_';
        let name: String = rest.chars().skip(1).take_while(is_part).collect();
        let name = name.to_ascii_uppercase();
        match (name.as_str(), rest.find('=')) {
            // Runs by itself: what reads it does not know it.
            ("AC_TIMER", Some(equals)) => {
                self.at += equals + 1;
                self.computed(block, Reader::expression).map(|_| ())
            }
            // $P_UIFR, $P_PFRAME and the like.
            (name, _) if name.starts_with("P_") && name.contains("FR") => Err(format!(
                "${name} sets a work offset or a frame, which is not supported: the job's \
                 work_object says where the work is"
            )),
            _ => Err(format!(
                "'${name}' is a variable of the control, and what setting it does is not read: \
                 leave the block out if it changes no motion, speed or tool"
            )),
        }
    }
}

/// Whether a block goes to the reference or the fixed point of the machine's own axes.
fn is_to_machine(block: &Block) -> bool {
    block.codes('G').any(|code| matches!(code, 740 | 750))
}
