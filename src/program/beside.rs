//! What a number that is rewritten means beside the path that was read: data that stand at other
//! lines, too, and inline forms of KRL that still show the old speed.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::Dialect;
use super::log::Word;
use super::span::Span;
use super::unread::{code_of, is_definition};

/// A datum or a register that a number is given to.
struct Datum {
    shown: String,
    /// Where it is given.
    line: usize,
    /// There, and where it was read as a speed or a feed.
    known: HashSet<usize>,
}

/// The line of each such number, and what it means, in order.
pub(super) fn beside<'w>(
    text: &str,
    dialect: Dialect,
    words: impl Iterator<Item = &'w Word>,
    changed: &BTreeMap<Span, String>,
) -> Vec<(usize, String)> {
    if !matches!(dialect, Dialect::Rapid | Dialect::Krl | Dialect::Fanuc) {
        return Vec::new();
    }
    let mut read: BTreeMap<Span, Vec<usize>> = BTreeMap::new();
    for word in words {
        if let Some(span) = word.span {
            read.entry(span).or_default().push(word.line);
        }
    }
    let mut found = Vec::new();
    let mut data: HashMap<String, Datum> = HashMap::new();
    let mut spans = changed.keys().peekable();
    // Whether each form that is open shows a speed.
    let mut forms: Vec<bool> = Vec::new();
    let mut start = 0;
    for (index, whole) in text.split_inclusive('\n').enumerate() {
        let (line, end) = (index + 1, start + whole.len());
        match whole.trim_start().to_lowercase() {
            _ if dialect != Dialect::Krl => {}
            own if own.starts_with(";fold") => forms.push(own.contains("vel=")),
            own if own.starts_with(";endfold") => drop(forms.pop()),
            _ => {}
        }
        while let Some(span) = spans.next_if(|span| span.start < end) {
            let head = text.get(start..span.start).unwrap_or("");
            if let Some(shown) = datum_before(head, dialect) {
                let datum = data.entry(shown.to_lowercase());
                let datum = datum.or_insert_with(|| Datum { shown, line, known: HashSet::new() });
                datum.known.insert(line);
                datum.known.extend(read.get(span).into_iter().flatten());
            }
            if forms.contains(&true) {
                let what = "the inline form around it still shows the old speed, which the \
                            pendant writes back when the form is changed or the point taught";
                found.push((line, what.to_owned()));
            }
        }
        start = end;
    }
    for (index, whole) in text.lines().enumerate() {
        if data.is_empty() {
            break;
        }
        let (line, code) = (index + 1, code_of(whole, dialect, &[]));
        if is_definition(&code, dialect) {
            continue;
        }
        for name in names_in(&code, dialect) {
            if data.get(&name).is_some_and(|datum| !datum.known.contains(&line))
                && let Some(Datum { shown, line: given, .. }) = data.remove(&name)
            {
                let what = format!(
                    "'{shown}' changes for line {line}, too, where it is no speed that was read"
                );
                found.push((given, what));
            }
        }
    }
    found.sort();
    found.dedup();
    found
}

fn is_part(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '$')
}

/// Names in a line of code; of TP its registers, as `r[1]`.
fn names_in(code: &str, dialect: Dialect) -> Vec<String> {
    if dialect != Dialect::Fanuc {
        return code.split(|c| !is_part(c)).map(str::to_owned).collect();
    }
    let registers = code.match_indices("r[").filter_map(|(at, _)| {
        let (before, behind) = code.split_at(at);
        let number = behind.get(2..)?.split([':', ']']).next()?.trim();
        (!before.ends_with(is_part)).then(|| format!("r[{number}]"))
    });
    registers.collect()
}

/// The name of the datum or the register that what follows is given to.
fn datum_before(head: &str, dialect: Dialect) -> Option<String> {
    let sign = if dialect == Dialect::Rapid { ":=" } else { "=" };
    let (left, _) = head.split_once(sign)?;
    let left = left.trim_end();
    if dialect == Dialect::Fanuc {
        let register = left.rfind("R[").and_then(|at| left.get(at + 2..))?;
        let number = register.split([':', ']']).next()?;
        return Some(format!("R[{}]", number.trim()));
    }
    let name = left.rsplit(|c| !is_part(c)).next().filter(|name| !name.is_empty())?;
    let before = left.strip_suffix(name)?;
    // `v10\V:=9` and `$VEL.CP=0.1` are no data.
    let is_datum = !before.ends_with(['\\', '.']) && !name.starts_with('$');
    is_datum.then(|| name.to_owned())
}
