//! What stands in the statements of TP programs: names, brackets, parts between signs.

pub(super) fn starts_with(text: &str, word: &str) -> bool {
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// What stands in the parentheses that hold the whole text.
pub(super) fn bare(text: &str) -> Result<&str, String> {
    /// More is no program that a teach pendant writes.
    const MAX_NESTING: usize = 20;
    let mut text = text.trim();
    let mut brackets = 0_usize;
    let is_too_deep = text.bytes().any(|byte| {
        match byte {
            b'[' => brackets += 1,
            b']' => brackets = brackets.saturating_sub(1),
            _ => {}
        }
        brackets > MAX_NESTING
    });
    if is_too_deep || outside(text, |depth, _| depth > MAX_NESTING).is_some() {
        return Err("parentheses are nested too deep".to_owned());
    }
    while text.starts_with('(')
        && outside(text, |depth, rest| depth == 0 && rest.starts_with(')')) == Some(text.len() - 1)
    {
        text = text.get(1..text.len() - 1).unwrap_or("").trim();
    }
    Ok(text)
}

/// The first place at which a test of the parentheses that are open there, and of what follows,
/// holds; a closing one counts as behind them. What stands in brackets, comments in them, is passed
/// over.
pub(super) fn outside(text: &str, mut is_it: impl FnMut(usize, &str) -> bool) -> Option<usize> {
    let (mut depth, mut brackets) = (0_usize, 0_usize);
    for (at, c) in text.char_indices() {
        match c {
            '[' => brackets += 1,
            ']' => brackets = brackets.saturating_sub(1),
            '(' if brackets == 0 => depth += 1,
            ')' if brackets == 0 => depth = depth.saturating_sub(1),
            _ => {}
        }
        if brackets == 0 && is_it(depth, text.get(at..).unwrap_or("")) {
            return Some(at);
        }
    }
    None
}

/// The ';' behind a statement; one in brackets or quotes is none, `R[1:a;b]`, `MESSAGE[a;b]`,
/// `CALL A('b;c')`.
pub(super) fn end_of_statement(text: &str) -> Option<usize> {
    let (mut depth, mut is_comment) = (0_usize, false);
    // Behind the quote that closes a text.
    let mut from = 0;
    for (at, byte) in text.bytes().enumerate() {
        if at < from {
            continue;
        }
        match byte {
            b'\'' if depth == 0 => {
                let close = text.get(at + 1..).and_then(|rest| rest.find('\''));
                from = close.map_or(from, |close| at + 1 + close + 1);
            }
            b']' => (depth, is_comment) = (depth.saturating_sub(1), false),
            b'[' if !is_comment => depth += 1,
            b':' if depth > 0 => is_comment = true,
            b';' if depth == 0 => return Some(at),
            _ => {}
        }
    }
    // Of a bracket that does not close.
    text.find(';')
}

/// `DI[3:part here]` is DI[3].
pub(super) fn without_comment(name: &str) -> String {
    name.split_once(':').map_or_else(|| name.to_owned(), |(head, _)| format!("{head}]"))
}

/// The parts of a text between signs that stand in no parentheses and no brackets.
pub(super) fn parts_outside<'t>(text: &'t str, sign: &str) -> Vec<&'t str> {
    let mut cuts = Vec::new();
    // Never true: every place is looked at once.
    outside(text, |depth, rest| {
        if depth == 0 && rest.starts_with(sign) {
            cuts.push(text.len() - rest.len());
        }
        false
    });
    let ends = cuts.iter().copied().chain([text.len()]);
    let starts = [0].into_iter().chain(cuts.iter().map(|at| at + sign.len()));
    starts.zip(ends).filter_map(|(start, end)| text.get(start..end)).collect()
}

/// A text before and behind a sign that stands in no parentheses and no brackets.
pub(super) fn split_outside<'t>(text: &'t str, sign: &str) -> Option<(&'t str, &'t str)> {
    let at = outside(text, |depth, rest| depth == 0 && rest.starts_with(sign))?;
    Some((text.get(..at)?, text.get(at + sign.len()..)?))
}

/// `[R80]`: brackets without the name of a list, at the start of a value or behind an operator.
pub(super) fn nameless(text: &str) -> Option<&str> {
    const BEFORE: [char; 5] = ['+', '-', '*', '/', '('];
    let is_it = |rest: &str| rest.trim_start().starts_with('[');
    let start = match is_it(text) {
        true => 0,
        false => outside(text, |_, rest| rest.strip_prefix(BEFORE).is_some_and(is_it))? + 1,
    };
    let own = text.get(start..)?.trim_start();
    let (_, rest) = brackets(own, "")?;
    own.get(..own.len() - rest.len())
}

/// How long the name at the start of a text is: `GI[5:program]/10` has one of 13 signs.
pub(super) fn name_length(text: &str) -> usize {
    let is_of_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '$' | '.' | ']');
    let end = outside(text, |_, rest| rest.starts_with(|c: char| !is_of_name(c)));
    end.unwrap_or(text.len())
}

/// `F[1:comment]` or `F[R[1]]` as a whole: list and index.
pub(super) fn indexed(name: &str) -> Option<(&str, &str)> {
    let (list, _) = name.split_once('[')?;
    let (index, rest) = brackets(name, list)?;
    rest.trim().is_empty().then_some((list, index))
}

/// `R[5:comment]` or `PR[R[2:id],3]` at the start of a text: what stands in the brackets but for a
/// comment, and what follows.
pub(super) fn brackets<'t>(text: &'t str, name: &str) -> Option<(&'t str, &'t str)> {
    if !starts_with(text, name) {
        return None;
    }
    let rest = text.get(name.len()..)?.strip_prefix('[')?;
    let (mut depth, mut comment) = (0_usize, None);
    // A comment goes on to the next bracket that closes, whatever stands in it.
    let mut is_comment = false;
    for (at, byte) in rest.bytes().enumerate() {
        match byte {
            b']' if depth == 0 => {
                return Some((rest.get(..comment.unwrap_or(at))?, rest.get(at + 1..)?));
            }
            b']' => (depth, is_comment) = (depth - 1, false),
            b'[' if !is_comment => depth += 1,
            b':' if !is_comment => {
                is_comment = true;
                if depth == 0 {
                    comment = Some(at);
                }
            }
            _ => {}
        }
    }
    None
}

/// `R[5:comment]` at the start of a text: the number, where it is one, and what follows.
pub(super) fn register<'t>(text: &'t str, name: &str) -> Option<(i64, &'t str)> {
    let (inside, rest) = brackets(text, name)?;
    Some((inside.split(',').next()?.trim().parse().ok()?, rest))
}

/// Whether `UTOOL_NUM[GP1,GP2]=2` or `UTOOL_NUM=2` is of group 1, too, the arm: `[GP2]` is not.
pub(super) fn is_of_arm(text: &str, name: &str) -> Result<bool, String> {
    let rest = text.get(name.len()..).unwrap_or("").trim_start();
    let Some((group, _)) = brackets(rest, "") else { return Ok(true) };
    let group_of = |text: &str| -> Option<u32> {
        text.trim().to_ascii_uppercase().strip_prefix("GP")?.trim().parse().ok()
    };
    let groups: Option<Vec<u32>> = group.split(',').map(group_of).collect();
    groups.map(|groups| groups.contains(&1)).ok_or_else(|| {
        format!("{name}[{group}] is not understood: expected {name}=n, or {name}[GP1]=n")
    })
}

/// Whether an option stands behind a target: `INC`, `Wjnt`.
pub(super) fn has_option(text: &str, name: &str) -> bool {
    text.split([' ', '\t', ',']).any(|own| own.eq_ignore_ascii_case(name))
}

/// The first word of a text: `R[5:feed in]mm/sec` has blanks in its comment.
pub(super) fn word(text: &str) -> &str {
    let end = outside(text, |depth, at| depth == 0 && at.starts_with([' ', '\t']));
    text.get(..end.unwrap_or(text.len())).unwrap_or("")
}

/// `Arc Start[1,2]`, `Weave Figure 8[1]`, `TA .50sec,CALL W1(1, 2)` at the start of a text, and
/// what follows.
pub(super) fn split_action(text: &str) -> Option<(&str, &str)> {
    const TIMED: [&str; 3] = ["TA", "TB", "DB"];
    const PLAIN: [&str; 5] = ["ARC", "WEAVE", "WELD", "SPRAY", "TRACK"];
    let letters = text.bytes().take_while(u8::is_ascii_alphabetic).count();
    let keyword = text.get(..letters)?.to_ascii_uppercase();
    let is_timed = TIMED.contains(&keyword.as_str());
    if !is_timed && !PLAIN.contains(&keyword.as_str()) {
        return None;
    }
    let (mut end, mut count) = (word(text).len(), 1);
    loop {
        let own = text.get(..end)?.trim_end();
        let rest = text.get(end..)?.trim_start();
        let next = word(rest);
        let behind = rest.get(next.len()..)?.trim_start();
        let is_open = own.ends_with([',', '=']) || own.to_ascii_uppercase().ends_with("CALL");
        let is_first = count == 1 && end == letters;
        let is_form = matches!(next.to_ascii_uppercase().as_str(), "START" | "END")
            || next.contains('[') && split_outside(next, ",").is_none()
            || behind.starts_with(|c: char| c.is_ascii_digit());
        let belongs = is_open
            || next.starts_with(['[', '(', '=', ','])
            || is_first && (is_timed || is_form)
            || count == 2 && !is_timed && next.starts_with(|c: char| c.is_ascii_digit());
        if next.is_empty() || !belongs {
            return Some(text.split_at(end));
        }
        end = text.len() - rest.len() + next.len();
        count += 1;
    }
}

/// The names in a condition, of signals, registers and labels: `DI[1:part]=ON AND !DO[2]`.
pub(super) fn names_in(condition: &str) -> Vec<&str> {
    let (mut names, mut from) = (Vec::new(), 0);
    // Never true: every place is looked at once, but those within brackets.
    outside(condition, |_, rest| {
        let next = condition.len() - rest.len() + rest.chars().next().map_or(0, char::len_utf8);
        if rest.starts_with(']') {
            names.extend(condition.get(from..next));
        }
        if !rest.starts_with(|c: char| c.is_ascii_alphanumeric()) {
            from = next;
        }
        false
    });
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_hold_brackets_and_comments() {
        for (text, expected) in [
            ("PR[1,3:a [b]=2", Some(("1,3", "=2"))),
            ("PR[R[2:id],R[3:a:b]:c]+1", Some(("R[2:id],R[3:a:b]", "+1"))),
            ("PR[R[R[1]]]", Some(("R[R[1]]", ""))),
            ("PR[R[1]", None),
            ("R[1]", None),
        ] {
            assert_eq!(brackets(text, "PR"), expected, "{text}");
        }
    }
}
