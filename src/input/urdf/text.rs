//! The text of a URDF before it is read as XML, and why it is none.

/// What to do with xacro.
pub(super) const XACRO_HINT: &str =
    "is unexpanded xacro; run 'xacro robot.xacro > robot.urdf' and name the result";

/// Attributes of one element, and namespaces of a file, at most: no file of an arm comes near, and
/// what reads them takes time with their square.
const MAX_ATTRIBUTES: usize = 200;
const MAX_NAMESPACES: usize = 100;

/// Why a text is not XML, and the line.
pub(super) fn not_xml(text: &str, error: &roxmltree::Error) -> (usize, String) {
    let line = error.pos().row as usize;
    if text.contains("<xacro:") {
        return (line, XACRO_HINT.to_owned());
    }
    let open = match error {
        roxmltree::Error::UnclosedRootNode => innermost_open(text),
        _ => None,
    };
    match open {
        Some((tag, start)) => {
            let what = "which starts here; is it cut off?";
            (start, format!("not valid XML: the file ends inside <{tag}>, {what}"))
        }
        None => (line, format!("not valid XML: {error}")),
    }
}

/// What is in a text more often than any file of an arm has it, and the line.
pub(super) fn too_many(text: &str) -> Option<(usize, String)> {
    let (mut found, mut namespaces) = (None, 0);
    // A fault of the text is told by its reader.
    let _ = each_tag(text, |start, inner| {
        namespaces += inner.matches("xmlns").count();
        let mut quote = None;
        let mut is_equals = |c: char| {
            match (quote, c) {
                (None, '"' | '\'') => quote = Some(c),
                (Some(open), c) if open == c => quote = None,
                _ => {}
            }
            quote.is_none() && c == '='
        };
        let what = match inner.chars().filter(|&c| is_equals(c)).count() {
            _ if namespaces > MAX_NAMESPACES => {
                format!("has more than {MAX_NAMESPACES} namespaces")
            }
            MAX_ATTRIBUTES.. if !inner.starts_with('!') => {
                format!("an element has {MAX_ATTRIBUTES} attributes or more")
            }
            _ => return Some(()),
        };
        let line = text.get(..start)?.matches('\n').count() + 1;
        found = Some((line, format!("{what}, no file of an arm has so many; is it one?")));
        None
    });
    found
}

/// The innermost element that a text without other faults leaves open, and the line where it
/// starts.
fn innermost_open(text: &str) -> Option<(&str, usize)> {
    let mut open: Vec<(&str, usize)> = Vec::new();
    // Lines are counted as they go by: counted from the start each time, a large file takes
    // minutes.
    let (mut line, mut counted) = (1, 0);
    each_tag(text, |start, inner| {
        if inner.starts_with('/') {
            open.pop();
        } else if !inner.starts_with('!') && !inner.ends_with('/') {
            let name = inner.split(|c: char| c.is_whitespace()).next()?;
            line += text.get(counted..start)?.matches('\n').count();
            counted = start;
            open.push((name, line));
        }
        Some(())
    })?;
    open.pop()
}

/// Hands on where each tag starts and what it holds, up to a fault of the text or of `act`.
fn each_tag<'t>(text: &'t str, mut act: impl FnMut(usize, &'t str) -> Option<()>) -> Option<()> {
    let mut at = 0;
    while let Some(next) = text.get(at..)?.find('<') {
        let start = at + next;
        let rest = text.get(start..)?;
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")]
            .into_iter()
            .find(|(begin, _)| rest.starts_with(begin));
        if let Some((_, end)) = skipped {
            at = start + rest.find(end)? + end.len();
            continue;
        }
        let length = tag_length(rest)?;
        act(start, rest.get(1..length - 1)?)?;
        at = start + length;
    }
    Some(())
}

/// Bytes from `<` to the `>` that ends the tag: not one inside quotes.
fn tag_length(tag: &str) -> Option<usize> {
    let mut quote = None;
    for (index, c) in tag.char_indices() {
        match (quote, c) {
            (None, '>') => return Some(index + 1),
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), c) if open == c => quote = None,
            _ => {}
        }
    }
    None
}
