//! O-words of LinuxCNC's: `o100 sub`, `o<name> call [5]`, `o#1 call`.

use super::comments::behind_comment;
use super::expression::Reader;
use super::parameters::Parameters;

/// LinuxCNC takes a number that is so near to a whole one for it.
const ROUNDING: f64 = 1e-4;

/// `o100 sub`, `o<name> call [1]`: label, keyword in upper case, and where the rest begins.
pub(super) fn o_word(line: &str) -> Option<(String, String, usize)> {
    let behind = line.get(1..)?;
    let (label, length) = match behind.trim_start().strip_prefix('<') {
        Some(rest) => {
            let end = rest.find('>')?;
            let label: String = rest.get(..end)?.split_whitespace().collect();
            (label.to_lowercase(), behind.find('>')? + 1)
        }
        None => {
            let blank = behind.len() - behind.trim_start().len();
            let digits = behind.trim_start().bytes().take_while(u8::is_ascii_digit).count();
            let label = behind.get(blank..blank + digits).filter(|label| !label.is_empty())?;
            (label.trim_start_matches('0').to_owned(), blank + digits)
        }
    };
    let rest = line.get(1 + length..)?;
    let blank = rest.len() - rest.trim_start().len();
    let letters = rest.trim_start().bytes().take_while(u8::is_ascii_alphabetic).count();
    // `O8000 T4` is the head of a program with a word behind it.
    let letters = if letters > 1 { letters } else { 0 };
    let keyword = rest.get(blank..blank + letters).filter(|word| !word.is_empty())?;
    Some((label, keyword.to_ascii_uppercase(), 1 + length + blank + letters))
}

/// The same of a call by a computed number: `o#1 call`, `o[#1 + 2] call [5]` (LinuxCNC, O Codes,
/// "Indirection").
pub(super) fn computed(
    line: &str,
    parameters: &Parameters,
) -> Result<Option<(String, String, usize)>, String> {
    let mut reader = Reader::new(line.as_bytes(), 1, parameters).with_comments();
    if !matches!(reader.peek(), Some(b'#' | b'[')) {
        return Ok(None);
    }
    let number = reader.value()?;
    let keyword = reader.letters();
    if keyword != "CALL" {
        return Err(format!(
            "O{number} {keyword}: an O-word by a computed number is read with CALL alone"
        ));
    }
    let whole = number.round();
    if number < 0.0 || (number - whole).abs() > ROUNDING {
        return Err(format!("O{number} CALL: expected a whole number from 0"));
    }
    let label = format!("{whole}").trim_start_matches('0').to_owned();
    Ok(Some((label, keyword, reader.at)))
}

/// Whether nothing but conditions and values in brackets stands behind an O-word; REPEAT's number
/// is read without these, too.
pub(super) fn nothing_behind(keyword: &str, rest: &str) -> Result<(), String> {
    let is_number = |c: char| c == '#' || c.is_ascii_digit();
    let rest = match keyword {
        "REPEAT" => {
            let behind = rest.trim_start().trim_start_matches(is_number);
            let name = behind.strip_prefix('<').and_then(|name| name.split_once('>'));
            name.map_or(behind, |(_, behind)| behind)
        }
        _ => rest,
    };
    let (mut at, mut depth) = (0, 0_usize);
    while let Some(byte) = rest.as_bytes().get(at) {
        match byte {
            b'(' => {
                at = behind_comment(rest.as_bytes(), at)?;
                continue;
            }
            b'[' => depth += 1,
            b']' => depth = depth.saturating_sub(1),
            b';' => break,
            byte if depth > 0 || byte.is_ascii_whitespace() || byte.is_ascii_control() => {}
            _ => {
                let behind = rest.get(at..).unwrap_or("").trim();
                return Err(format!(
                    "'{behind}' behind {keyword} is not read; write it in a block of its own"
                ));
            }
        }
        at += 1;
    }
    Ok(())
}
