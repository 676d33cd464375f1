//! Text that fits the width of all outputs.

use crate::wording::wrapped;

/// Appends a fact after its name; what does not fit on the line goes on below the fact's first
/// word.
pub(super) fn push_fact(indent: usize, name: &str, fact: &str, text: &mut String) {
    wrapped(text, &format!("{:indent$}{name:8} ", ""), fact);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_facts_go_on_below() {
        let mut text = String::new();
        push_fact(2, "why", "because", &mut text);
        assert_eq!(text, "  why      because\n");
        let fact = vec!["four"; 60].join(" ");
        text.clear();
        push_fact(4, "why", &fact, &mut text);
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
        assert!(text.lines().skip(1).all(|line| line.starts_with("             four")), "{text}");
        assert_eq!(text.split_whitespace().count(), 61);
    }
}
