//! A line of G-code → its words.

/// Words of the macro languages of controllers, which need what is known only at run time.
const KEYWORDS: [&str; 12] = [
    "IF", "THEN", "ELSE", "ENDIF", "WHILE", "DO", "END", "GOTO", "GOTOF", "GOTOB", "FOR", "REPEAT",
];

/// Longer words are shown in part.
const MAX_WORD_CHARS: usize = 20;

/// The words of a block in order: letter in upper case, number.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Block {
    pub(super) words: Vec<(char, f64)>,
    /// Began with `/`: left out where the operator says so.
    pub(super) optional: bool,
}

impl Block {
    pub(super) fn get(&self, letter: char) -> Option<f64> {
        self.words.iter().find(|(found, _)| *found == letter).map(|(_, number)| *number)
    }

    /// Codes of `letter` (G or M) in tenths, so that G91.1 is 911.
    pub(super) fn codes(&self, letter: char) -> impl Iterator<Item = i64> + '_ {
        // Saturates far beyond any code.
        self.words
            .iter()
            .filter(move |(found, _)| *found == letter)
            .map(|(_, number)| (number * 10.0).round() as i64)
    }
}

/// Parses one line, without its end.
///
/// # Errors
/// What is no word of a letter and a number: expressions, parameters, O-words.
pub(super) fn parse(line: &str) -> Result<Block, String> {
    let content = without_comments(line)?;
    if let Some(number) = with_exponent(&content) {
        return Err(format!(
            "'{number}' reads as a number with an exponent, which G-code does not have; write it \
             out, or put a space before an E word"
        ));
    }
    let content: String =
        content.chars().filter(|c| !c.is_whitespace() && !c.is_control()).collect();
    let content = content.to_ascii_uppercase();
    let mut block = Block::default();
    if content.starts_with('%') || content.starts_with(':') {
        return Ok(block);
    }
    let mut rest = content.as_str();
    if let Some(after) = rest.strip_prefix('/') {
        block.optional = true;
        rest = after.strip_prefix(|c: char| c.is_ascii_digit()).unwrap_or(after);
    }
    while let Some(letter) = rest.chars().next() {
        let tail = rest.get(letter.len_utf8()..).unwrap_or("");
        if matches!(letter, '#' | '[' | '=') || tail.starts_with(['#', '[', '<', '=']) {
            return Err("parameters and expressions are not supported".to_owned());
        }
        if letter == '$' || !letter.is_ascii_alphabetic() {
            return Err(format!("'{letter}' is not understood"));
        }
        let word: String =
            rest.chars().take_while(char::is_ascii_alphabetic).take(MAX_WORD_CHARS).collect();
        if KEYWORDS.contains(&word.as_str()) {
            return Err(format!("'{word}': conditions, jumps and loops are not supported"));
        }
        if word.len() > 1 {
            return Err(format!("'{word}' is not understood, must be letters each with a number"));
        }
        let (number, after) = number(tail).ok_or_else(|| format!("{letter} has no number"))?;
        if letter == 'O' && after.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return Err("O-words (subroutines, loops, conditions) are not supported".to_owned());
        }
        // Which of the two a controller takes differs.
        if !matches!(letter, 'G' | 'M') && block.get(letter).is_some() {
            return Err(format!("two {letter} words in one block"));
        }
        block.words.push((letter, number));
        rest = after;
    }
    Ok(block)
}

fn without_comments(line: &str) -> Result<String, String> {
    let mut out = String::with_capacity(line.len());
    let mut rest = line;
    loop {
        match rest.find(['(', ';']) {
            None => {
                out.push_str(rest);
                return Ok(out);
            }
            Some(at) => {
                let (before, comment) = rest.split_at_checked(at).unwrap_or((rest, ""));
                out.push_str(before);
                if comment.starts_with(';') {
                    return Ok(out);
                }
                match comment.split_once(')') {
                    Some((_, after)) => rest = after,
                    None => return Err("a comment is not closed".to_owned()),
                }
            }
        }
    }
}

/// The first number with an exponent that nothing parts from it, `X1e5`: no space, as before an E
/// word.
fn with_exponent(content: &str) -> Option<&str> {
    content.split_whitespace().find(|word| {
        let bytes = word.as_bytes();
        bytes.windows(3).any(|three| {
            (three[0].is_ascii_digit() || three[0] == b'.')
                && matches!(three[1], b'e' | b'E')
                && (three[2].is_ascii_digit() || matches!(three[2], b'+' | b'-'))
        })
    })
}

/// A number at the start of `text`, and what follows. G-code has no exponents.
fn number(text: &str) -> Option<(f64, &str)> {
    let signed = usize::from(text.starts_with(['+', '-']));
    let length =
        text.bytes().skip(signed).take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count()
            + signed;
    let (digits, after) = text.split_at_checked(length)?;
    let number = digits.parse::<f64>().ok().filter(|number| number.is_finite())?;
    Some((number, after))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_in_any_dress() {
        let block = parse("/1 n20 g1 x-1. 5 (a; b) Y+.5z2 ; end").unwrap();
        assert!(block.optional);
        assert_eq!(block.words, [('N', 20.0), ('G', 1.0), ('X', -1.5), ('Y', 0.5), ('Z', 2.0)]);
        assert_eq!(parse("G91.1").unwrap().codes('G').collect::<Vec<_>>(), [911]);
        assert_eq!(parse("%").unwrap(), Block::default());
        assert_eq!(parse("O1000 (NAME)").unwrap().words, [('O', 1000.0)]);
    }

    #[test]
    fn what_is_no_word_is_told() {
        assert!(parse("IF [#1 EQ 2] GOTO 5").unwrap_err().starts_with("'IF': conditions"));
        assert!(parse("N10 WHILE [1] DO1").unwrap_err().starts_with("'WHILE': conditions"));
        assert!(parse("G1 HELLO").unwrap_err().starts_with("'HELLO' is not understood"));
        assert!(parse("G1 X1e5").unwrap_err().starts_with("'X1e5' reads as a number with an exp"));
        assert_eq!(parse("G1 X1 E5").unwrap().get('E'), Some(5.0));
        for line in ["#1=5", "G1 X#1", "X[1+2]", "#<a>=1", "o<s> call", "G1 X[#2]"] {
            let fault = parse(line).unwrap_err();
            assert!(fault.contains("parameters and expressions"), "{line}: {fault}");
        }
        assert!(parse("o100 sub").unwrap_err().contains("O-words"));
        assert!(parse("G1 X").unwrap_err().contains("X has no number"));
        assert!(parse("G1 X1.2.3").unwrap_err().contains("X has no number"));
        assert!(parse("G1 (open").unwrap_err().contains("not closed"));
        assert!(parse("G1 \u{e4}1").unwrap_err().contains("not understood"));
    }
}
