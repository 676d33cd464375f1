//! Comments in parentheses.

/// Where the comment that begins at a place ends: behind the first `)`, or behind the `)` of a
/// comment that holds others.
pub(super) fn behind_comment(bytes: &[u8], from: usize) -> Result<usize, String> {
    let rest = bytes.get(from..).unwrap_or_default();
    let end = rest.iter().position(|&byte| byte == b')').ok_or("a comment is not closed")?;
    let opened = rest.iter().take(end).filter(|byte| **byte == b'(').count();
    let mut at = from + end + 1;
    for _ in 1..opened {
        let rest = bytes.get(at..).unwrap_or_default();
        let behind = rest.trim_ascii_start();
        match behind.first() {
            // No word depends on where it ends.
            None => break,
            Some(b';') if !behind.contains(&b')') => break,
            Some(b')') => at += rest.len() - behind.len() + 1,
            Some(_) => {
                return Err("a comment in a comment: controllers differ in where it ends".into());
            }
        }
    }
    Ok(at)
}
