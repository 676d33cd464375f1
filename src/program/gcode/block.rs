//! A line of G-code → its words, with the places of their numbers.

use super::abbreviated::output;
use super::comments::behind_comment;
use super::expression::{Reader, VACANT, not_vacant};
use super::parameters::{Key, NOT_SET, Parameters, Set};
use super::variables;
use crate::program::span::Span;

/// Sinumerik's words of several letters, as if each were one.
pub(super) const RADIUS: u8 = b'r';
pub(super) const DIRECTION: [u8; 3] = *b"abc";
/// Whole turns of a helix beyond the way to its end: TURN=.
pub(super) const TURNS: u8 = b'n';
/// Corners: `,R` or RND=, `,C` or CHR=.
pub(super) const ROUNDED: u8 = b'o';
pub(super) const CHAMFERED: u8 = b'h';
/// CHF=: the length of the chamfer itself.
pub(super) const CHAMFER_LENGTH: u8 = b'f';

/// AP=, RP=, ANG=, and the point on the way of CIP: I1=, J1=, K1=.
pub(super) const POLAR_ANGLE: u8 = b'p';
pub(super) const POLAR_RADIUS: u8 = b'q';
pub(super) const ANGLE: u8 = b'g';
/// LIMS=: the most that the spindle may turn.
pub(super) const LIMIT: u8 = b'l';
/// RPL=: how far ROT and AROT turn the work in the plane.
pub(super) const PLANE_TURN: u8 = b't';
/// FB=: the feed of this block alone.
pub(super) const BLOCK_FEED: u8 = b'e';
/// AR=: the opening angle of an arc.
pub(super) const OPENING: u8 = b'w';
pub(super) const ON_THE_WAY: [u8; 3] = *b"ijk";

/// Whether a number counts from where the axis is, whatever G90 and G91 say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Counts {
    AsModal,
    /// `X=AC(…)`.
    Absolute,
    /// `X=IC(…)`.
    Relative,
}

/// A letter and its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Word {
    /// In upper case; in lower case where it stands for several.
    pub(super) letter: u8,
    pub(super) value: f64,
    /// Where the number stands in the text; `None` where it is computed, or in another file.
    pub(super) span: Option<Span>,
    pub(super) counts: Counts,
    /// Written with a decimal point; what is computed has none.
    pub(super) has_point: bool,
    pub(super) is_computed: bool,
}

/// The words of a block in order.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Block {
    pub(super) words: Vec<Word>,
    /// Has a `/`: what stands behind it is left out where the operator says so.
    pub(super) optional: bool,
    /// A tape mark, `%`.
    pub(super) mark: bool,
    /// Names of Sinumerik and the like, with what stands in their parentheses.
    pub(super) names: Vec<(String, String)>,
    /// What is set when the block has been read; not a number where that is a vacant parameter, or
    /// what cannot be read.
    pub(super) sets: Vec<Set>,
    /// Names of variables that it declares as texts.
    pub(super) texts: Vec<String>,
    /// Why H, which gives a length beside G43 or G44, is not known.
    pub(super) unset_length: Option<String>,
    /// Left out a word whose parameter is vacant.
    leaves_out: bool,
}

impl Block {
    pub(super) fn word(&self, letter: u8) -> Option<Word> {
        self.words.iter().find(|word| word.letter == letter).copied()
    }

    pub(super) fn get(&self, letter: char) -> Option<f64> {
        self.word(letter as u8).map(|word| word.value)
    }

    pub(super) fn has_any(&self, letters: &[u8]) -> bool {
        self.words.iter().any(|word| letters.contains(&word.letter))
    }

    /// Whether it gives a place, or a part of one.
    pub(super) fn has_place(&self) -> bool {
        self.has_any(b"XYZ") || self.has_any(&[POLAR_ANGLE, POLAR_RADIUS, ANGLE])
    }

    /// Codes of `letter` (G or M) in tenths, so that G91.1 is 911.
    pub(super) fn codes(&self, letter: char) -> impl Iterator<Item = i64> + '_ {
        let letter = letter as u8;
        // Saturates far beyond any code.
        let codes = self.words.iter().filter(move |word| word.letter == letter);
        codes.map(|word| (word.value * 10.0).round() as i64)
    }

    /// Whether the length of a tool counts from here on.
    pub(super) fn compensates(&self) -> bool {
        self.codes('G').any(|code| matches!(code, 430 | 434 | 440))
    }

    /// Whether it holds one name so far, behind its number.
    fn is_label(&self) -> bool {
        self.names.len() == 1 && self.words.iter().all(|word| word.letter == b'N')
    }

    /// Whether it says without axes, too, what it says with them: G28 or G52 alone may not.
    fn is_plain(&self) -> bool {
        const PLAIN: [i64; 17] =
            [0, 10, 20, 30, 170, 180, 190, 400, 540, 550, 560, 570, 580, 590, 900, 910, 940];
        self.codes('G').all(|code| PLAIN.contains(&code))
    }

    /// `L1`, behind its number.
    fn is_short_label(&self, parameters: &Parameters) -> bool {
        let words = self.words.iter().filter(|word| word.letter != b'N').count();
        parameters.is_sinumerik() && words == 1 && self.names.is_empty() && self.sets.is_empty()
    }

    fn clear(&mut self) {
        self.words.clear();
        self.names.clear();
        self.sets.clear();
        self.texts.clear();
        (self.optional, self.mark, self.leaves_out, self.unset_length) = Default::default();
    }
}

/// Letters of words that are left out where their parameter is vacant.
const LEFT_OUT: &[u8] = b"ABCFIJKRSUVWXYZ";

/// Longer names are shown in part.
const MAX_NAME: usize = 20;

/// Parses one line, without its end, into `block`; `offset` is where it begins in the text of the
/// program, `None` where numbers shall have no place.
///
/// # Errors
/// What is no word of a letter and a number.
pub(super) fn parse(
    line: &str,
    offset: Option<usize>,
    block: &mut Block,
    parameters: &Parameters,
) -> Result<(), String> {
    block.clear();
    let mut lexer = Lexer { bytes: line.as_bytes(), line, offset, at: 0, parameters };
    lexer.skip()?;
    match lexer.byte() {
        Some(b'%') => {
            block.mark = true;
            return Ok(());
        }
        // A main block of Sinumerik (`:20 G1 X5`) or ISO, or a program's number of Fanuc's.
        Some(b':') => {
            lexer.at += 1;
            let digits = lexer.bytes.get(lexer.at..).unwrap_or_default();
            lexer.at += digits.iter().take_while(|byte| byte.is_ascii_digit()).count();
        }
        // A program's name, as newer Fanuc controls have it.
        Some(b'<') if line.trim_end().ends_with('>') => return Ok(()),
        Some(b'/') => {
            block.optional = true;
            lexer.at += 1;
            if lexer.byte().is_some_and(|byte| byte.is_ascii_digit()) {
                lexer.at += 1;
            }
        }
        _ => {}
    }
    loop {
        lexer.skip()?;
        let Some(byte) = lexer.byte() else {
            if block.leaves_out && !block.is_plain() {
                return Err(VACANT.to_owned());
            }
            let unset = block.unset_length.clone().filter(|_| !block.compensates());
            return unset.map_or(Ok(()), Err);
        };
        match byte {
            b'#' if !lexer.parameters.is_sinumerik() => lexer.assignment(block)?,
            b',' => lexer.corner(block)?,
            // What stands behind it may be skipped.
            b'/' if !block.words.is_empty() => {
                block.optional = true;
                lexer.at += 1;
            }
            // A label.
            b':' if lexer.is_behind_name() && block.is_label() => {
                block.names.clear();
                lexer.at += 1;
            }
            b'A'..=b'Z' | b'a'..=b'z' | b'_' => lexer.word(block)?,
            b'$' if lexer.parameters.is_sinumerik() => lexer.of_control(block)?,
            // LinuxCNC: which spindle.
            b'$' if lexer.is_before_number() => {
                lexer.at += 1;
                lexer.number(b'$', block)?;
            }
            b'#' => {
                return Err("'#' is no word of Sinumerik's: a comment begins with ';', and a \
                            parameter with R"
                    .to_owned());
            }
            b':' if lexer.is_behind_name() && block.is_short_label(lexer.parameters) => {
                return Err(
                    "a label begins with two letters or underscores (LA1:): rename it, and \
                            the jumps to it"
                        .to_owned(),
                );
            }
            b'@' if lexer.parameters.is_sinumerik() => {
                return Err("'@' with a number is a function of older controls (Sinumerik 800), \
                            which is not read: have the program written for 840D"
                    .to_owned());
            }
            b'@' | b'^' => {
                return Err("polar coordinates by @ and ^ are not supported: have X and Y written"
                    .to_owned());
            }
            _ => return Err(format!("'{}' is not understood", lexer.char())),
        }
    }
}

pub(super) struct Lexer<'t> {
    pub(super) bytes: &'t [u8],
    pub(super) line: &'t str,
    /// Where the line begins in the text.
    offset: Option<usize>,
    pub(super) at: usize,
    pub(super) parameters: &'t Parameters,
}

impl<'t> Lexer<'t> {
    pub(super) fn byte(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn is_behind_name(&self) -> bool {
        let before = self.at.checked_sub(1).and_then(|at| self.bytes.get(at));
        before.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_')
    }

    fn is_before_number(&self) -> bool {
        let behind = self.bytes.get(self.at + 1);
        behind.is_some_and(|byte| byte.is_ascii_digit() || matches!(byte, b'-' | b'#' | b'['))
    }

    fn char(&self) -> char {
        self.line.get(self.at..).and_then(|rest| rest.chars().next()).unwrap_or(' ')
    }

    /// Past blanks and comments; a semicolon ends the line.
    fn skip(&mut self) -> Result<(), String> {
        while let Some(byte) = self.byte() {
            match byte {
                b' ' | b'\t' => self.at += 1,
                b'(' => self.at = behind_comment(self.bytes, self.at)?,
                b';' => self.at = self.bytes.len(),
                byte if byte.is_ascii_control() => self.at += 1,
                _ => break,
            }
        }
        Ok(())
    }

    fn expression(
        &mut self,
        read: impl FnOnce(&mut Reader<'t>) -> Result<f64, String>,
    ) -> Result<(f64, Option<Span>), String> {
        let mut reader = Reader::new(self.bytes, self.at, self.parameters);
        let value = read(&mut reader)?;
        let span = reader.place(self.at, value, self.offset);
        self.at = reader.at;
        Ok((not_vacant(value)?, span))
    }

    /// Behind `=` in a block of Sinumerik's, in which nothing says when what it sets counts.
    pub(super) fn computed(
        &mut self,
        block: &Block,
        read: impl FnOnce(&mut Reader<'t>) -> Result<f64, String>,
    ) -> Result<(f64, Option<Span>), String> {
        let mut reader = Reader::new(self.bytes, self.at, self.parameters);
        let value = read(&mut reader);
        let is_set = |key: &&Key| block.sets.iter().any(|(set, ..)| set.name() == key.name());
        if let Some(key) = reader.read.iter().find(is_set) {
            return Err(format!(
                "{} is read in the block that sets it: whether the value before counts or the new \
                            one is not documented; write two blocks",
                self.parameters.shown(key)
            ));
        }
        let value = value?;
        let span = reader.place(self.at, value, self.offset);
        self.at = reader.at;
        Ok((not_vacant(value)?, span))
    }

    /// Sets a parameter of Sinumerik's to what stands behind `=`.
    pub(super) fn set(&mut self, key: Key, block: &mut Block) -> Result<(), String> {
        let found = self.computed(block, Reader::expression);
        let (value, span) = found.as_ref().copied().unwrap_or((f64::NAN, None));
        block.sets.push((key, value, span));
        found.map(|_| ())
    }

    /// `#1 = 5`: counts once the whole block is read.
    fn assignment(&mut self, block: &mut Block) -> Result<(), String> {
        let mut reader = Reader::new(self.bytes, self.at + 1, self.parameters).with_comments();
        let key = reader.key()?;
        if !reader.take(b'=') {
            return Err("a parameter stands where a word is expected".to_owned());
        }
        let from = reader.at;
        let value = reader.expression();
        let number = value.as_ref().copied().unwrap_or(f64::NAN);
        let span = reader.place(from, number, self.offset);
        self.at = reader.at;
        block.sets.push((key, number, span));
        value.map(|_| ())
    }

    /// `,R2` and `,C2`.
    fn corner(&mut self, block: &mut Block) -> Result<(), String> {
        self.at += 1;
        self.skip()?;
        let letter = match self.byte().map(|byte| byte.to_ascii_uppercase()) {
            Some(b'R') => ROUNDED,
            Some(b'C') => CHAMFERED,
            _ => return Err("',' is not understood".to_owned()),
        };
        self.at += 1;
        self.number(letter, block)
    }

    fn word(&mut self, block: &mut Block) -> Result<(), String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let first = rest.first().copied().unwrap_or_default();
        let behind = rest.get(1).copied().unwrap_or_default();
        if first != b'_' && (behind.is_ascii_digit() || matches!(behind, b'.' | b'-' | b'+')) {
            // The common word; A3=, S1= and R1= are told by what follows.
            let digits = rest.iter().skip(1).take_while(|byte| byte.is_ascii_digit()).count();
            if !is_set(rest.get(1 + digits..)) {
                self.at += 1;
                return self.number(first.to_ascii_uppercase(), block);
            }
        }
        let is_name = |byte: &&u8| byte.is_ascii_alphanumeric() || **byte == b'_';
        let length = if behind.is_ascii_alphabetic() || behind.is_ascii_digit() || behind == b'_' {
            rest.iter().take_while(is_name).count()
        } else {
            1
        };
        let name = self.line.get(self.at..self.at + length).unwrap_or_default();
        let name = name.to_ascii_uppercase();
        if name == "EXTCALL" {
            return Err("EXTCALL runs a program from outside the control's memory and is not \
                        supported: name its file under path.program.files, and call it by its name"
                .to_owned());
        }
        if name == "CALL" && self.parameters.is_sinumerik() && is_next(rest.get(length..), b'"') {
            self.at += length;
            let name = self.text()?.trim().to_ascii_uppercase();
            block.names.push((name, String::new()));
            return Ok(());
        }
        if !self.parameters.is_sinumerik()
            && let Some(name) = output(&name)
        {
            self.at += length;
            if matches!(name, "DPRNT" | "BPRNT") {
                self.skip_brackets(name)?;
            }
            block.names.push((name.to_owned(), String::new()));
            return Ok(());
        }
        match rest.get(length) {
            _ if is_set(rest.get(length..)) => {
                let equals = rest.iter().position(|byte| *byte == b'=');
                self.at += equals.unwrap_or(length) + 1;
                return self.named(&name, block);
            }
            // A name of several letters has arguments there, no comment.
            Some(_) if length > 1 && is_next(rest.get(length..), b'(') => {
                self.at += length;
                self.at += self.line.get(self.at..).and_then(|own| own.find('(')).unwrap_or(0);
                let inside = self.parenthesis()?;
                block.names.push((name, inside));
                return Ok(());
            }
            _ => {}
        }
        if name == "DEF" {
            let text = self.line.get(self.at + length..).unwrap_or("");
            self.at = self.bytes.len();
            let text = text.split(';').next().unwrap_or("").trim();
            if let Some(texts) = variables::texts(text) {
                block.texts.extend(texts);
                return Ok(());
            }
            return variables::define(text, self.parameters, &mut block.sets);
        }
        if self.parameters.is_sinumerik()
            && rest.get(length) == Some(&b'[')
            && (length > 1 || name == "R")
        {
            return self.element(&name, length, block);
        }
        if length == 1 && first != b'_' {
            self.at += 1;
            return self.number(first.to_ascii_uppercase(), block);
        }
        // Letters that run into a word: `TRAORI`, or `GX1`.
        self.at += length;
        block.names.push((name.chars().take(MAX_NAME).collect(), String::new()));
        Ok(())
    }

    /// What stands in the quotes that come next, and past them.
    pub(super) fn text(&mut self) -> Result<&'t str, String> {
        let rest = self.line.get(self.at..).unwrap_or("");
        let mut parts = rest.split('"');
        let (Some(before), Some(text), Some(_)) = (parts.next(), parts.next(), parts.next()) else {
            return Err("a text is not closed".to_owned());
        };
        self.at += before.len() + text.len() + 2;
        Ok(text)
    }

    /// What stands in parentheses, strings with parentheses of their own in it.
    fn parenthesis(&mut self) -> Result<String, String> {
        let start = self.at + 1;
        let (mut depth, mut in_string) = (0_usize, false);
        while let Some(byte) = self.byte() {
            self.at += 1;
            match byte {
                b'"' => in_string = !in_string,
                b'(' if !in_string => depth += 1,
                b')' if !in_string => {
                    depth -= 1;
                    if depth == 0 {
                        return Ok(self.line.get(start..self.at - 1).unwrap_or("").to_owned());
                    }
                }
                _ => {}
            }
        }
        Err("a parenthesis is not closed".to_owned())
    }

    /// The number behind a letter: digits, between which blanks and comments may stand, or an
    /// expression.
    fn number(&mut self, letter: u8, block: &mut Block) -> Result<(), String> {
        let start = self.at;
        let mut end = start;
        while self
            .bytes
            .get(end)
            .is_some_and(|&b| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+'))
        {
            end += 1;
        }
        let follows = self.bytes.get(end).copied().unwrap_or(b'X');
        if end > start && !matches!(follows, b' ' | b'\t' | b'(' | b'#' | b'[') {
            if matches!(follows, b'e' | b'E')
                && let Some(&behind) = self.bytes.get(end + 1)
                && (behind.is_ascii_digit() || matches!(behind, b'+' | b'-'))
            {
                return Err(self.exponent(start));
            }
            self.at = end;
            return self.literal(letter, start, end, None, block);
        }
        self.skip()?;
        if matches!(self.byte(), Some(b'#' | b'['))
            || (matches!(self.byte(), Some(b'-' | b'+')) && self.sign_of_expression())
            || self.byte().is_some_and(|b| b.is_ascii_alphabetic()) && self.starts_function()
        {
            let number = self.bytes.get(self.at + 1).filter(|_| self.byte() == Some(b'#'));
            let is_parameter = number.is_some_and(|byte| matches!(byte, b'1'..=b'9'));
            let (value, span) = match self.expression(Reader::primary) {
                // The number of a tool's length, which the controller may keep in a parameter.
                Err(why) if letter == b'H' && why.contains(NOT_SET) => {
                    self.skip_primary();
                    block.unset_length = Some(why);
                    return Ok(());
                }
                // Fanuc ignores an address whose parameter is vacant.
                Err(why) if why == VACANT && is_parameter && LEFT_OUT.contains(&letter) => {
                    block.leaves_out = true;
                    return Ok(());
                }
                found => found?,
            };
            let counts = Counts::AsModal;
            let word = Word { letter, value, span, counts, has_point: false, is_computed: true };
            return add(block, word);
        }
        self.scattered(letter, block)
    }

    /// Past `#5`, `#[…]` or `[…]`.
    fn skip_primary(&mut self) {
        let mut depth = 0_usize;
        while let Some(byte) = self.byte() {
            match byte {
                b'[' => depth += 1,
                b']' => depth = depth.saturating_sub(1),
                b'#' | b'0'..=b'9' => {}
                _ if depth == 0 => return,
                _ => {}
            }
            self.at += 1;
        }
    }

    /// Past `[X#1[53]*Y]` behind a name.
    fn skip_brackets(&mut self, name: &str) -> Result<(), String> {
        self.skip()?;
        let mut depth = 0_usize;
        while let Some(byte) = self.byte() {
            match byte {
                b'[' => depth += 1,
                b']' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 && byte != b']' {
                break;
            }
            self.at += 1;
            if depth == 0 {
                return Ok(());
            }
        }
        Err(match depth {
            0 => format!("{name} must have what it sends in [ ] behind it"),
            _ => format!("{name}: a bracket is not closed"),
        })
    }

    fn exponent(&self, start: usize) -> String {
        let word = self.line.get(start.saturating_sub(1)..).unwrap_or("");
        let word = word.split_whitespace().next().unwrap_or("");
        format!(
            "'{word}' reads as a number with an exponent, which G-code does not have; write it \
             out, or put a space before an E word"
        )
    }

    fn sign_of_expression(&self) -> bool {
        let rest = self.bytes.get(self.at + 1..).unwrap_or_default();
        let next = rest.iter().find(|byte| !byte.is_ascii_whitespace());
        matches!(next, Some(b'#' | b'['))
    }

    /// `XSIN[30]`.
    fn starts_function(&self) -> bool {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let letters = rest.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        letters > 1 && rest.get(letters) == Some(&b'[')
    }

    /// A number with blanks or comments in it, as RS-274 allows.
    fn scattered(&mut self, letter: u8, block: &mut Block) -> Result<(), String> {
        let mut digits = String::new();
        let (mut start, mut end) = (None, self.at);
        loop {
            let before = self.at;
            self.skip()?;
            match self.byte() {
                Some(b) if b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+') => {
                    start.get_or_insert(self.at);
                    digits.push(char::from(b));
                    self.at += 1;
                    end = self.at;
                }
                _ => {
                    self.at = if digits.is_empty() { before } else { self.at };
                    break;
                }
            }
        }
        match start {
            Some(start) => self.literal(letter, start, end, Some(&digits), block),
            None => Err(format!("{} has no number", char::from(letter))),
        }
    }

    fn literal(
        &self,
        letter: u8,
        start: usize,
        end: usize,
        digits: Option<&str>,
        block: &mut Block,
    ) -> Result<(), String> {
        let text = digits.or_else(|| self.line.get(start..end)).unwrap_or("");
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| format!("{} has no number", char::from(letter)))?;
        let span = self.offset.map(|offset| Span::new(start, end).behind(offset));
        let has_point = text.contains('.');
        let counts = Counts::AsModal;
        add(block, Word { letter, value, span, counts, has_point, is_computed: false })
    }
}

/// Whether a byte comes next, behind blanks.
fn is_next(rest: Option<&[u8]>, byte: u8) -> bool {
    let mut rest = rest.unwrap_or_default().iter();
    rest.find(|byte| !matches!(byte, b' ' | b'\t')) == Some(&byte)
}

/// Whether `=` comes next, behind blanks, and is no comparison.
fn is_set(rest: Option<&[u8]>) -> bool {
    let mut rest = rest.unwrap_or_default().iter().skip_while(|byte| matches!(byte, b' ' | b'\t'));
    rest.next() == Some(&b'=') && rest.next() != Some(&b'=')
}

pub(super) fn add(block: &mut Block, word: Word) -> Result<(), String> {
    // Which of the two a controller takes differs; to G65 they are arguments.
    let may_repeat = match word.letter {
        b'G' | b'M' => true,
        b'I' | b'J' | b'K' => block.codes('G').any(|code| code == 650),
        _ => false,
    };
    if !may_repeat && block.word(word.letter).is_some() {
        return Err(format!("two {} words in one block", char::from(word.letter)));
    }
    block.words.push(word);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(line: &str) -> Result<Block, String> {
        let mut block = Block::default();
        parse(line, Some(0), &mut block, &Parameters::default()).map(|()| block)
    }

    fn words(line: &str) -> Vec<(char, f64)> {
        let words = parsed(line).unwrap().words;
        words.iter().map(|word| (char::from(word.letter), word.value)).collect()
    }

    #[test]
    fn words_in_any_dress() {
        let block = parsed("/1 n20 g1 x-1. 5 (a; b) Y+.5z2 ; end").unwrap();
        assert!(block.optional);
        assert_eq!(
            words("/1 n20 g1 x-1. 5 (a; b) Y+.5z2 ; end"),
            [('N', 20.0), ('G', 1.0), ('X', -1.5), ('Y', 0.5), ('Z', 2.0)]
        );
        assert_eq!(parsed("G91.1").unwrap().codes('G').collect::<Vec<_>>(), [911]);
        assert!(parsed("%").unwrap().mark);
        assert_eq!(words("O1000 (NAME)"), [('O', 1000.0)]);
        assert_eq!(words("X[1+2]Y-[3]"), [('X', 3.0), ('Y', -3.0)]);
        assert_eq!(words("G1 X1,R2"), [('G', 1.0), ('X', 1.0), ('o', 2.0)]);
        assert_eq!(
            words("G2 X=AC(5) CR=2.5 A3=0.1"),
            [('G', 2.0), ('X', 5.0), ('r', 2.5), ('a', 0.1)]
        );
    }

    #[test]
    fn numbers_know_where_they_stand() {
        let line = "g1 s 1 (a) 100 F80.";
        let block = parsed(line).unwrap();
        let text = |letter| {
            let span = block.word(letter).unwrap().span.unwrap();
            &line[span.start..span.end]
        };
        assert_eq!((text(b'S'), text(b'F')), ("1 (a) 100", "80."));
    }

    #[test]
    fn what_is_no_word_is_told() {
        assert!(parsed("G1 X1e5").unwrap_err().starts_with("'X1e5' reads as a number with an exp"));
        assert_eq!(parsed("G1 X1 E5").unwrap().get('E'), Some(5.0));
        assert!(parsed("G1 X").unwrap_err().contains("X has no number"));
        assert!(parsed("G1 X1.2.3").unwrap_err().contains("X has no number"));
        assert!(parsed("G1 (open").unwrap_err().contains("not closed"));
        assert!(parsed("G1 \u{e4}1").unwrap_err().contains("not understood"));
        assert_eq!(parsed("G1 HELLO").unwrap().names[0].0, "HELLO");
    }
}
