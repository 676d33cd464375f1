//! Heidenhain's conversational language → its blocks, and their words.

use std::collections::BTreeMap;

use crate::program::span::{Held, Span};

/// Words whose number is one of its own: `CYCL DEF 7.1`, also as `CYCL DEF7.1`.
const NUMBERED_BEHIND: [&str; 5] = ["DEF", "CALL", "LBL", "PROBE", "FN"];

/// Cycles from this number on, and their parameters.
const FIRST_OF_CYCLES: u32 = 200;

/// A word: `X+10`, `IZ-2`, `FMAX`, `DR+`, `Q200=2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Word<'t> {
    /// Letters as they stand, without a sign.
    pub(super) name: &'t str,
    pub(super) value: Option<f64>,
    /// Place of the number in the text, there or where a parameter was set to it.
    pub(super) span: Option<Span>,
    /// `DR+`, `DR-`: a sign without a number.
    pub(super) sign: Option<bool>,
}

/// The words of a block behind its number; comments are gone.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Block<'t> {
    pub(super) words: Vec<Word<'t>>,
    /// The text between quotes, a tool's name.
    pub(super) quoted: Option<&'t str>,
}

impl<'t> Block<'t> {
    pub(super) fn name(&self, index: usize) -> &'t str {
        self.words.get(index).map_or("", |word| word.name)
    }

    pub(super) fn word(&self, name: &str) -> Option<&Word<'t>> {
        self.words.iter().find(|word| word.name == name)
    }

    pub(super) fn get(&self, name: &str) -> Option<f64> {
        self.word(name)?.value
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.word(name).is_some()
    }

    /// Whether a word stands right behind another: `F MAX`.
    pub(super) fn is_after(&self, first: &str, second: &str) -> bool {
        let is = |pair: &[Word<'_>]| {
            pair[0].name == first && pair[0].value.is_none() && pair[1].name == second
        };
        self.words.windows(2).any(is)
    }

    /// F without a number, MAX or AUTO, as older controls list it where the feed stays (HEIDENHAIN,
    /// TNC 406 User's Manual: `L Y+0 R F M`).
    pub(super) fn leaves_feed(&self) -> bool {
        let is_bare = |word: &Word<'_>| word.value.is_none() && word.sign.is_none();
        self.word("F").is_some_and(is_bare)
            && !(self.is_after("F", "MAX") || self.is_after("F", "AUTO"))
    }

    /// What is wrong with a sign or a number of a block of motion or the like: `X -`, `X+10 - 3`.
    pub(super) fn loose(&self) -> Option<String> {
        let from = match self.name(0) {
            "L" | "C" | "CR" | "CT" | "CP" | "LP" | "APPR" | "DEP" => 1,
            "CC" | "RND" | "CHF" => 1,
            // A mirror names axes alone.
            "TRANS" if self.name(1) == "DATUM" => 1,
            // Behind the number of the tool.
            "TOOL" | "CYCL" if self.name(1) == "CALL" => 3,
            _ => return None,
        };
        let is_loose = |word: &&Word<'_>| match (word.value, word.sign) {
            (Some(_), _) => word.name.is_empty(),
            (None, Some(_)) => word.name != "DR",
            // `TOOL CALL 5 Z` has the tool's axis.
            (None, None) => {
                is_of_place(word.name) && self.name(0) != "TOOL" && !self.is_of_tilt(word)
            }
        };
        let word = self.words.iter().skip(from).find(is_loose)?;
        let sign = word.sign.map_or("", |is_plus| if is_plus { "+" } else { "-" });
        Some(match (word.name, word.value) {
            ("", Some(value)) => format!(
                "{value} stands behind a word that has its number: work it out, or write a Q \
                 parameter"
            ),
            ("", None) => format!(
                "'{sign}' stands behind a number or another sign: a word has one sign and one \
                 number; work it out, or write a Q parameter"
            ),
            (name, _) if word.sign.is_some() => {
                format!("'{name} {sign}' has a sign and no number behind it")
            }
            (name, _) => format!(
                "'{name}' has no number behind it: write it, or leave the word out where the axis \
                 stays"
            ),
        })
    }

    /// `M138 C`: the axes that count for a tilt.
    pub(super) fn is_of_tilt(&self, word: &Word<'_>) -> bool {
        let is_bare = word.value.is_none() && word.sign.is_none();
        is_bare && matches!(word.name, "A" | "B" | "C") && self.all("M").any(|code| code == 138.0)
    }

    pub(super) fn all<'b>(&'b self, name: &'b str) -> impl Iterator<Item = f64> + 'b {
        self.words.iter().filter(move |word| word.name == name).filter_map(|word| word.value)
    }
}

/// Whether a Q parameter that stands apart behind a word is its number, by the first word of its
/// block: `TOOL CALL 5 Z` has an axis alone.
fn takes_parameter(name: &str, head: &str) -> bool {
    let is_of_place = is_of_place(name) && !matches!(head, "" | "TOOL");
    let others = ["F", "FU", "S", "R", "DL", "RND", "CHF", "LEN", "CCA", "MB", "TIME", "REV"];
    is_of_place || others.contains(&name)
}

/// Coordinates, which have numbers wherever they stand: `X`, `IZ`, `PA`.
fn is_of_place(name: &str) -> bool {
    let axis = name.strip_prefix('I').unwrap_or(name);
    matches!(axis, "X" | "Y" | "Z" | "A" | "B" | "C" | "U" | "V" | "W" | "PR" | "PA")
}

/// A block, its continued lines (`~`) joined.
pub(super) struct Text<'t> {
    pub(super) line: usize,
    /// It begins with `/`.
    pub(super) may_be_skipped: bool,
    pub(super) parts: Vec<(usize, &'t str)>,
}

/// A block without its number and its comment.
pub(super) fn content(line: &str) -> &str {
    let line = line.split(';').next().unwrap_or("").trim();
    line.get(head(line).0..).unwrap_or("").trim()
}

/// How long the number of a block is, with the `/` before or behind it of one that may be skipped;
/// and whether it has one.
fn head(line: &str) -> (usize, bool) {
    let rest = behind_number(line);
    match rest.trim_start().strip_prefix('/') {
        Some(behind) => (line.len() - behind_number(behind).len(), true),
        None => (line.len() - rest.len(), false),
    }
}

fn behind_number(text: &str) -> &str {
    let text = text.trim_start();
    // Some posts write `N10`.
    let text = match text.strip_prefix('N') {
        Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => rest,
        _ => text,
    };
    text.trim_start_matches(|c: char| c.is_ascii_digit())
}

/// Blocks with their lines; `~` at the end of a line continues it, or its comment, where blocks
/// have numbers: without them, what stands behind a comment may be a block.
pub(super) fn blocks(text: &str) -> Vec<Text<'_>> {
    let mut found: Vec<Text<'_>> = Vec::new();
    let mut offset = 0;
    let (mut continues, mut in_comment) = (false, false);
    for (index, whole) in text.split_inclusive('\n').enumerate() {
        let start = offset;
        offset += whole.len();
        let line = whole.trim_end();
        in_comment &= !(is_numbered(line) || is_of_cycle(line));
        if in_comment {
            in_comment = line.ends_with('~');
            continue;
        }
        let code = line.split(';').next().unwrap_or("").trim_end();
        let body = code.strip_suffix('~').unwrap_or(code);
        let blank = body.len() - body.trim_start().len();
        // Some posts leave the `~` out of the lines of a cycle.
        let goes_on = continues || is_of_cycle(body) && found.last().is_some_and(is_cycle);
        let (skip, may_be_skipped) = if goes_on { (blank, false) } else { head(body) };
        let part = (start + skip, body.get(skip..).unwrap_or(""));
        let words = part.1.trim_start();
        let is_divider = words.starts_with('*');
        // Cycles go on behind their comments.
        let is_of_cycle = goes_on || words.starts_with("CYCL") || words.starts_with("TCH");
        let is_open = line.ends_with('~') && (is_divider || !code.ends_with('~'));
        in_comment = is_open && !is_of_cycle && is_numbered(line);
        match found.last_mut().filter(|_| goes_on) {
            Some(open) => open.parts.push(part),
            // `* - …` divides the program for people.
            None if words.is_empty() || is_divider => {}
            None => found.push(Text { line: index + 1, may_be_skipped, parts: vec![part] }),
        }
        // Comments of cycles' lines stand before the next.
        continues = !(in_comment || is_divider)
            && (code.ends_with('~') || (continues && line.contains('~')));
    }
    found
}

/// A block's number stands at its beginning, not where a comment goes on.
fn is_numbered(line: &str) -> bool {
    behind_number(line).len() < line.trim_start().len()
}

/// `Q200=2`: below 1600 no parameter of the program's own has so high a number.
fn is_of_cycle(line: &str) -> bool {
    let rest = line.trim_start().strip_prefix('Q').unwrap_or("");
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let number = rest.get(..digits).and_then(|digits| digits.parse::<u32>().ok());
    number.is_some_and(|number| (FIRST_OF_CYCLES..1600).contains(&number))
        && rest.get(digits..).is_some_and(|rest| rest.trim_start().starts_with('='))
}

/// Whether a block defines a cycle that has Q parameters.
fn is_cycle(block: &Text<'_>) -> bool {
    let rest = block.parts[0].1.trim_start().strip_prefix("CYCL DEF").unwrap_or("");
    let number = rest.trim_start().split(|c: char| !c.is_ascii_digit()).next().unwrap_or("");
    number.parse::<u32>().is_ok_and(|number| number >= FIRST_OF_CYCLES)
}

/// Q parameters that the program sets, by number.
pub(super) type Parameters = BTreeMap<u32, Held>;

/// The words of a text that begins at `offset` of the program's. Decimal commas are points; a Q
/// parameter that is known stands for its number.
pub(super) fn parse<'t>(text: &'t str, offset: usize, parameters: &Parameters) -> Block<'t> {
    let content = text.split(';').next().unwrap_or("");
    let bytes = content.as_bytes();
    let (mut words, mut quoted) = (Vec::new(), None);
    let mut at = 0;
    while at < bytes.len() {
        if bytes[at] == b'"' {
            let rest = content.get(at + 1..).unwrap_or("");
            let end = rest.find('"').unwrap_or(rest.len());
            quoted = quoted.or(rest.get(..end));
            at += end + 2;
            continue;
        }
        if !bytes[at].is_ascii_alphabetic() {
            // A number of its own belongs to the word before: `TOOL CALL 5`, `LBL 1`.
            let length = number_length(bytes, at);
            let open = words.last_mut().filter(|before: &&mut Word<'t>| before.is_open());
            if length == 0 || !bytes[at..at + length].iter().any(u8::is_ascii_digit) {
                // `X - 50`, `Z + Q13`.
                let sign = sign_of(content.get(at..at + 1).unwrap_or(""));
                match open {
                    Some(before) if before.sign.is_none() => before.sign = sign,
                    // `X+10 - 3`, `X - - 3`: to no word.
                    open => {
                        let is_lost = open.is_some() || words.last().is_some_and(is_finished);
                        words.extend(sign.filter(|_| is_lost).map(Word::of_sign));
                    }
                }
                at += 1;
                continue;
            }
            let own = word(content, at, at, at + length, offset);
            // `S 1500`, `X+ 50`; the words before that take a number of their own do not.
            let is_signed = matches!(bytes[at], b'+' | b'-');
            let takes = |before: &&mut Word<'t>| !(is_signed && before.sign.is_some());
            match open.filter(takes).filter(|_| own.value.is_some()) {
                Some(before) => {
                    let is_negative = before.sign == Some(false);
                    let value = own.value.map(|value| if is_negative { -value } else { value });
                    *before = Word { name: before.name, value, ..own };
                }
                // `1.2.3` is no number, and no word.
                None if own.value.is_none() => words.push(own.named(content, at, at + length)),
                None => words.push(own),
            }
            at += length;
            continue;
        }
        let start = at;
        while at < bytes.len() && bytes[at].is_ascii_alphabetic() {
            at += 1;
        }
        let (name_end, whole_end) = (at, at);
        // Q200 is a name; X10 is a letter and a number.
        let is_parameter = content.get(start..name_end) == Some("Q");
        // `Z + Q13`, `F Q5`, `TOOL CALL Q11`.
        let is_call = |before: &Word<'_>| before.name == "CALL";
        let head = words.first().filter(|_| words.len() > 1).map_or("", |first| first.name);
        let awaits = |before: &Word<'_>| {
            before.is_open() && (before.sign.is_some() || takes_parameter(before.name, head))
        };
        if is_parameter
            && let Some(before) = words.last().copied().filter(|own| is_call(own) || awaits(own))
            && let (Some(held), length) = parameter(content, start, parameters)
        {
            let Held { value, span } = signed(held, before.sign == Some(false));
            let name = if is_call(&before) { "" } else { before.name };
            words.truncate(words.len() - usize::from(!is_call(&before)));
            words.push(Word { name, value: Some(value), span, sign: None });
            at = start + length;
            continue;
        }
        if is_parameter {
            while at < bytes.len() && bytes[at].is_ascii_digit() {
                at += 1;
            }
            let name_end = at;
            while at < bytes.len() && matches!(bytes[at], b' ' | b'=') {
                at += 1;
            }
            let length = number_length(bytes, at);
            let own = word(content, start, at, at + length, offset).named(content, start, name_end);
            at += length;
            // `Q206 = Q2`; `FN 0: Q2 = …` sets it.
            let (held, length) = parameter(content, at, parameters);
            at += length;
            let held = held.map(|held| signed(held, own.sign == Some(false)));
            let sign = own.sign.filter(|_| held.is_none());
            let span = own.span.or(held.and_then(|held| held.span));
            let value = own.value.or(held.map(|held| held.value));
            words.push(Word { value, span, sign, ..own });
            continue;
        }
        // `FQ2` is F with the value of Q2, `X-Q2` X with its negative.
        if content.get(name_end - 1..name_end) == Some("Q") && name_end - start > 1 {
            at = name_end - 1;
        }
        let name_end = at;
        let sign = usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));
        let (held, length) = parameter(content, at + sign, parameters);
        if let Some(held) = held {
            let Held { value, span } = signed(held, sign == 1 && bytes[at] == b'-');
            let own = word(content, start, at, at, offset).named(content, start, name_end);
            words.push(Word { value: Some(value), span, ..own });
            at += sign + length;
            continue;
        }
        at = whole_end;
        let name_end = whole_end;
        let length = number_length(bytes, at);
        let own = word(content, start, at, at + length, offset);
        // `F1.2.3` is no F without a number, which leaves the feed as it was.
        let is_no_number = own.value.is_none() && own.sign.is_none();
        let name_end = if is_no_number { at + length } else { name_end };
        let own = own.named(content, start, name_end);
        if own.value.is_some() && NUMBERED_BEHIND.contains(&own.name) {
            // Some posts leave out the blank.
            words.push(Word { value: None, span: None, ..own });
            words.push(Word { name: "", ..own });
        } else {
            words.push(own);
        }
        at += length;
    }
    Block { words, quoted }
}

/// The value of the Q parameter that stands at a place, if the program has set it, and how long its
/// name is.
fn parameter(content: &str, at: usize, parameters: &Parameters) -> (Option<Held>, usize) {
    let digits = content.get(at..).and_then(|rest| rest.strip_prefix('Q')).unwrap_or("");
    let length = digits.bytes().take_while(u8::is_ascii_digit).count();
    let number = digits.get(..length).and_then(|digits| digits.parse().ok());
    match number.and_then(|number: u32| parameters.get(&number)) {
        Some(held) => (Some(*held), 1 + length),
        None => (None, 0),
    }
}

/// With a minus before it, it is no number of the text.
fn signed(held: Held, is_negative: bool) -> Held {
    if is_negative { Held::worked_out(-held.value) } else { held }
}

impl<'t> Word<'t> {
    fn named(self, content: &'t str, start: usize, end: usize) -> Self {
        Self { name: content.get(start..end).unwrap_or(""), ..self }
    }

    /// The Q parameter without a value that stands in the word: `Q5`, `FQ5`.
    pub(super) fn parameter(&self) -> Option<u32> {
        let of_letter = || {
            let number = self.value.filter(|_| self.name.len() > 1 && self.name.ends_with('Q'))?;
            // The largest, which is no parameter, for what is too large.
            (number.fract() == 0.0).then_some(number.abs() as u32)
        };
        self.name.strip_prefix('Q').and_then(|own| own.parse().ok()).or_else(of_letter)
    }

    /// A sign that belongs to no word.
    fn of_sign(is_plus: bool) -> Self {
        Self { name: "", value: None, span: None, sign: Some(is_plus) }
    }

    /// Whether its number may stand apart behind it.
    fn is_open(&self) -> bool {
        self.value.is_none()
            && !self.name.is_empty()
            && self.name != "DR"
            && !NUMBERED_BEHIND.contains(&self.name)
    }
}

/// Whether a word has its number.
fn is_finished(word: &Word<'_>) -> bool {
    word.value.is_some()
}

/// A word whose number stands at `from..to`.
fn word(content: &str, start: usize, from: usize, to: usize, offset: usize) -> Word<'_> {
    let number = content.get(from..to).unwrap_or("");
    let sign = sign_of(number);
    let value = match number.contains(',') {
        true => number.replace(',', ".").parse::<f64>().ok(),
        false => number.parse::<f64>().ok(),
    };
    let value = value.filter(|value| value.is_finite());
    let span = value.map(|_| Span::new(offset + from, offset + to));
    Word { name: content.get(start..from).unwrap_or(""), value, span, sign }
}

/// Of a sign alone, whether it is a plus.
fn sign_of(text: &str) -> Option<bool> {
    match text {
        "+" => Some(true),
        "-" => Some(false),
        _ => None,
    }
}

fn number_length(bytes: &[u8], from: usize) -> usize {
    let rest = bytes.get(from..).unwrap_or_default();
    let sign = usize::from(matches!(rest.first(), Some(b'+' | b'-')));
    let digits = rest.iter().skip(sign);
    sign + digits.take_while(|b| b.is_ascii_digit() || matches!(b, b'.' | b',')).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blank_before_the_number_of_a_cycle_may_be_left_out() {
        let none = Parameters::new();
        for text in ["CYCL DEF 7.1 X+10", "CYCL DEF7.1 X+10", "LBL 3", "LBL3", "TOOL CALL5 Z"] {
            let own: Vec<_> =
                parse(text, 0, &none).words.iter().map(|word| (word.name, word.value)).collect();
            let spaced = text.replace("DEF7", "DEF 7").replace("LBL3", "LBL 3");
            let spaced = spaced.replace("CALL5", "CALL 5");
            let other = parse(&spaced, 0, &none);
            let other: Vec<_> = other.words.iter().map(|word| (word.name, word.value)).collect();
            assert_eq!(own, other, "{text}");
        }
    }

    #[test]
    fn words_of_blocks() {
        let none = Parameters::new();
        let text = "L  X+10.5 IZ-2 R0 FMAX M3 ; X1";
        let block = parse(text, 0, &none);
        let found: Vec<_> = block.words.iter().map(|word| (word.name, word.value)).collect();
        assert_eq!(
            found,
            [
                ("L", None),
                ("X", Some(10.5)),
                ("IZ", Some(-2.0)),
                ("R", Some(0.0)),
                ("FMAX", None),
                ("M", Some(3.0))
            ]
        );
        let block = parse("TOOL CALL 5 Z S1200 DL+0,5", 100, &none);
        assert_eq!((block.name(0), block.name(1)), ("TOOL", "CALL"));
        assert_eq!(block.words[2].value, Some(5.0));
        assert_eq!(block.word("S").unwrap().span, Some(Span::new(115, 119)));
        assert_eq!(block.get("DL"), Some(0.5));
        assert_eq!(parse("C X+1 DR-", 0, &none).word("DR").unwrap().sign, Some(false));
        assert_eq!(parse("Q201=-20 ;DEPTH", 0, &none).get("Q201"), Some(-20.0));
    }

    #[test]
    fn parameters_that_are_known_stand_for_their_numbers() {
        let known =
            [(2, 68.0), (30, -1.5)].map(|(number, value)| (number, Held::worked_out(value)));
        let known = Parameters::from(known);
        let values = |text| -> Vec<(&str, Option<f64>)> {
            let block = parse(text, 0, &known);
            block.words.iter().map(|word| (word.name, word.value)).collect()
        };
        assert_eq!(
            values("L X+Q30 Z-Q30 FQ2 M3"),
            [("L", None), ("X", Some(-1.5)), ("Z", Some(1.5)), ("F", Some(68.0)), ("M", Some(3.0))]
        );
        assert_eq!(values("Q206=Q2 Q201=-20"), [("Q206", Some(68.0)), ("Q201", Some(-20.0))]);
        assert_eq!(values("Q203=-Q2 Q201=+Q30"), [("Q203", Some(-68.0)), ("Q201", Some(-1.5))]);
        assert_eq!(
            values("L X - 5 Y+ Q2 Z - Q30"),
            [("L", None), ("X", Some(-5.0)), ("Y", Some(68.0)), ("Z", Some(1.5))]
        );
        assert_eq!(
            values("L X Q2 IZ Q30 F Q2"),
            [("L", None), ("X", Some(68.0)), ("IZ", Some(-1.5)), ("F", Some(68.0))]
        );
        assert_eq!(
            values("L X - .5 Y - ,25 Z + 0.5"),
            [("L", None), ("X", Some(-0.5)), ("Y", Some(-0.25)), ("Z", Some(0.5))]
        );
        // Q3 is not known, and Q2 no part of it.
        assert_eq!(values("L FQ3"), [("L", None), ("FQ", Some(3.0))]);
        assert!(parse("L FQ2", 0, &known).word("F").unwrap().span.is_none());
    }
}
