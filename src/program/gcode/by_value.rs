//! Parameters of Sinumerik's subprograms: `PROC SLOT(REAL LENGTH, INT COUNT)`, called by value
//! (Siemens, SINUMERIK 840D sl/828D Job Planning, "Subprograms").

use super::parameters::{Key, Parameters};
use super::siemens::arguments;
use super::structure::{code, stripped};

/// What a call gives the parameters that the head of a subprogram names; its lines begin with it.
pub(super) fn given(
    name: &str,
    inside: &str,
    lines: &[(usize, &str)],
    known: &Parameters,
) -> Result<Vec<(Key, f64)>, String> {
    let keys = head(name, lines)?;
    // What stands in parentheses behind a number is read as a comment.
    if !keys.is_empty() && name.strip_prefix('L').is_some_and(|own| own.parse::<f64>().is_ok()) {
        return Err(format!(
            "{name} has parameters in its PROC: a call by an L number with values is not \
             supported; give the subprogram a name without a number behind L"
        ));
    }
    let values = match inside.trim() {
        "" => Vec::new(),
        inside => arguments(name, inside, known)?,
    };
    let has_all = keys.iter().skip(values.len()).all(|(_, default)| default.is_some());
    if values.len() > keys.len() || !has_all {
        return Err(format!(
            "'{name}' calls a subprogram with {} values for the {} parameters of its PROC: have \
             all written",
            values.len(),
            keys.len()
        ));
    }
    let missing = || format!("{name}: a parameter without a value is not supported");
    let values = values.into_iter().chain(std::iter::repeat(None));
    let with_value = |((key, default), value): ((Key, Option<f64>), Option<f64>)| {
        Ok((key, value.or(default).ok_or_else(missing)?))
    };
    keys.into_iter().zip(values).map(with_value).collect()
}

/// The parameters that PROC names, in order, each with the number that it has where the call gives
/// none; nothing where the subprogram has no PROC.
fn head(name: &str, lines: &[(usize, &str)]) -> Result<Vec<(Key, Option<f64>)>, String> {
    let mut codes = lines.iter().map(|(_, line)| code(stripped(line)));
    let first = codes.find(|own| !(own.is_empty() || own.starts_with('%')));
    let Some((word, head)) = first.and_then(|own| own.split_once(char::is_whitespace)) else {
        return Ok(Vec::new());
    };
    let Some((_, behind)) = head.split_once('(').filter(|_| word.eq_ignore_ascii_case("PROC"))
    else {
        return Ok(Vec::new());
    };
    let (list, _) = behind.split_once(')').ok_or("a parenthesis is not closed")?;
    if list.trim().is_empty() {
        return Ok(Vec::new());
    }
    let key = |own: &str| {
        let (words, default) = own.split_once('=').map_or((own, None), |(a, b)| (a, Some(b)));
        let default = default.map(|own| match own.trim().to_ascii_uppercase().as_str() {
            "TRUE" => Ok(1.0),
            "FALSE" => Ok(0.0),
            number => number.parse::<f64>(),
        });
        let words: Vec<String> = words.split_whitespace().map(str::to_lowercase).collect();
        let is_name = |name: &str| name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
        let of = |key: Key| Ok((key, default.clone().and_then(Result::ok)));
        match words.as_slice() {
            _ if matches!(default, Some(Err(_))) => Err(format!(
                "{name}: what the parameter '{}' of PROC has without a value is not supported: a \
                 number, TRUE or FALSE alone",
                own.trim()
            )),
            [kind, own] if kind == "real" && is_name(own) => of(Key::Name(own.clone())),
            [kind, own] if kind == "int" && is_name(own) => of(Key::Whole(own.clone())),
            [kind, own] if kind == "bool" && is_name(own) => of(Key::Truth(own.clone())),
            _ => Err(format!(
                "{name}: the parameter '{}' of PROC is not supported: REAL, INT and BOOL that are \
                 called by value alone",
                own.trim()
            )),
        }
    };
    list.split(',').map(key).collect()
}
