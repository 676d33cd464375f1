//! What messages have in common: misspellings, digits, and text that may hold anything.

/// A word is taken for a misspelling above this similarity (Jaro-Winkler).
const MIN_SIMILARITY: f64 = 0.8;

/// Nobody misspells a word into something longer than this.
pub const MAX_WORD_BYTES: usize = 100;

/// The candidate that `word` is most likely a misspelling of.
pub fn nearest<'c>(word: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    if word.len() > MAX_WORD_BYTES {
        return None;
    }
    candidates
        .into_iter()
        .map(|candidate| {
            (strsim::jaro_winkler(&word.to_lowercase(), &candidate.to_lowercase()), candidate)
        })
        .filter(|(similarity, _)| *similarity >= MIN_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// What a message adds where `word` is likely a misspelling of a candidate: `; did you mean 'x'?`.
pub fn hint<'c>(word: &str, candidates: impl IntoIterator<Item = &'c str>) -> String {
    nearest(word, candidates).map_or_else(String::new, |near| format!("; did you mean '{near}'?"))
}

/// A count with its noun: `1 row`, `2 rows`.
pub fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// Two numbers as text with at least `decimals` decimals, and as many more as they need to differ
/// where they are not the same.
pub fn distinguishable(a: f64, b: f64, decimals: usize) -> [String; 2] {
    /// Beyond it doubles of everyday size show their last digit.
    const MAX_DECIMALS: usize = 15;
    let with = |decimals: usize| [a, b].map(|value| format!("{value:.decimals$}"));
    if a == b {
        return with(decimals);
    }
    (decimals..=MAX_DECIMALS)
        .map(with)
        .find(|[a, b]| a != b)
        .unwrap_or_else(|| [a, b].map(|value| format!("{value:e}")))
}

/// A value for a message, with at most so many decimals and no zeros behind them.
pub fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    let scaled = value * scale;
    if scaled.is_finite() { scaled.round() / scale } else { value }
}

/// A number as people write it: with a power of ten where its zeros would have to be counted.
pub fn plain(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-5..1e15).contains(&size) || !size.is_finite() {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// Text of a user on one line: what would steer a terminal, turn the direction of writing or break
/// XML is spelt out as `\u{1b}`.
///
/// Build servers run lines of a log as commands: `::error …` at the start of a line, where a
/// wrapped text may put any word, `##vso[…` and `##[…` anywhere. So a word does not start with
/// `::`, and no `#` follows another.
pub fn printable(text: &str) -> String {
    spelled(text, true, escaped)
}

/// The same within a string of JSON, whose readers get every character back: `\u001b`.
pub fn printable_json(text: &str) -> String {
    let units = |c: char, out: &mut String| {
        let mut units = [0; 2];
        let units = c.encode_utf16(&mut units).iter();
        out.extend(units.map(|unit| format!("\\u{unit:04x}")));
    };
    spelled(text, true, units)
}

/// The same where no line can start with the text: what build servers take for a command stays.
pub fn visible(text: &str) -> String {
    spelled(text, false, escaped)
}

fn escaped(c: char, out: &mut String) {
    if c.is_control() { out.extend(c.escape_default()) } else { out.extend(c.escape_unicode()) }
}

fn spelled(text: &str, spells_commands: bool, spell: impl Fn(char, &mut String)) -> String {
    let mut out = String::with_capacity(text.len());
    let mut before = ' ';
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        let commands = match c {
            ':' => before.is_whitespace() && chars.peek() == Some(&':'),
            '#' => before == '#',
            _ => false,
        };
        before = c;
        match c {
            c if commands && spells_commands => spell(c, &mut out),
            c if is_printable(c) => out.push(c),
            c => spell(c, &mut out),
        }
    }
    out
}

fn is_printable(c: char) -> bool {
    let turns_direction =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    // Not in XML 1.0, with the control characters.
    let breaks_xml = matches!(c, '\u{fffe}' | '\u{ffff}');
    !(c.is_control() || turns_direction || breaks_xml || c == '\u{feff}')
}

/// Width of text output, in columns.
const WIDTH: usize = 100;

/// Writes `text`, as [`printable`], after `head`, wrapped to the width with further lines below the
/// start of the text.
pub fn wrapped(out: &mut String, head: &str, text: &str) {
    let indent = head.chars().count();
    let mut column = indent;
    out.push_str(head);
    for (i, word) in printable(text).split(' ').enumerate() {
        let width = word.chars().count();
        if i > 0 && column + 1 + width > WIDTH {
            out.push('\n');
            out.push_str(&" ".repeat(indent));
            column = indent;
        } else if i > 0 {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += width;
    }
    out.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_numbers_show_that_they_differ() {
        assert_eq!(distinguishable(65.0, 65.0, 3), ["65.000", "65.000"]);
        assert_eq!(distinguishable(190.0, 180.0, 3), ["190.000", "180.000"]);
        assert_eq!(distinguishable(65.000_02, 65.0, 3), ["65.00002", "65.00000"]);
        assert_eq!(distinguishable(1e-300, 0.0, 1), ["1e-300", "0e0"]);
    }

    #[test]
    fn nothing_reaches_the_terminal_but_text() {
        assert_eq!(printable("µ 'a' \u{1b}[31m\r\n\u{7}"), "µ 'a' \\u{1b}[31m\\r\\n\\u{7}");
        assert_eq!(printable("a\u{9b}\u{7f}\u{202e}\u{ffff}"), "a\\u{9b}\\u{7f}\\u{202e}\\u{ffff}");
        assert_eq!(printable("::error a::b ::c"), "\\u{3a}:error a::b \\u{3a}:c");
        assert_eq!(printable("##vso[x] # ###"), "#\\u{23}vso[x] # #\\u{23}\\u{23}");
        assert_eq!(printable("Tür 50 % ×2 — ok 日本"), "Tür 50 % ×2 — ok 日本");
    }

    #[test]
    fn json_gives_every_character_back() {
        let hostile = "a\u{85}::b ::c ##[d]\u{7f}\u{9b}\u{2028}\u{202e}\u{2066}\u{feff} Tür 日本";
        let spelled = printable_json(hostile);
        assert!(spelled.chars().all(is_printable) && !spelled.contains("##"), "{spelled}");
        assert!(!spelled.contains(" ::"), "{spelled}");
        let read: String = serde_json::from_str(&format!("\"{spelled}\"")).unwrap();
        assert_eq!(read, hostile);
    }

    #[test]
    fn a_misspelling_is_near_and_another_word_is_not() {
        assert_eq!(nearest("tool1", ["base", "tool0"]), Some("tool0"));
        assert_eq!(nearest("flange", ["base", "tool0"]), None);
    }
}
