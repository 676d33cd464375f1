//! Explanations of codes, verdicts and causes, as text.

use crate::notes::Class;
use crate::report::layout::push_fact;
use crate::study::explain::{Explanation, Kind};
use crate::wording::wrapped;

/// One in full.
pub fn explanation(one: &Explanation) -> String {
    let mut text = format!("{}  {}\n", one.name, kind(one.kind));
    push_fact(2, "meaning", &plain(one.meaning), &mut text);
    if let Some(confounded) = one.confounded_with {
        push_fact(2, "like", confounded, &mut text);
    }
    let name = if one.kind == Kind::Cause { "test" } else { "do" };
    push_fact(2, name, &plain(one.what_to_do), &mut text);
    text
}

/// All, one a line or two, under a head for each kind.
pub fn list(all: &[Explanation]) -> String {
    let width = all.iter().map(|one| one.name.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for (i, one) in all.iter().enumerate() {
        if i == 0 || all[i - 1].kind != one.kind {
            let gap = if i == 0 { "" } else { "\n" };
            text.push_str(&format!("{gap}{}:\n", kind(one.kind)));
        }
        let head = format!("  {:width$}  ", one.name);
        wrapped(&mut text, &head, &plain(one.meaning));
    }
    text
}

fn kind(kind: Kind) -> &'static str {
    match kind {
        Kind::Message(Class::Error) => "error: the run stops",
        Kind::Message(Class::Remark) => "warning: the verdict stays",
        Kind::Message(Class::Doubt) => "warning: the verdict is at best uncertain",
        Kind::Message(Class::Breach) => "warning: the verdict is resonance",
        Kind::Verdict => "verdict",
        Kind::Cause => "cause that a diagnosis can find",
    }
}

/// Without the links of the guide: `[programs]` is its page.
fn plain(text: &str) -> String {
    let is_page = |name: &str| !name.is_empty() && name.bytes().all(|b| b.is_ascii_lowercase());
    let mut parts = text.split('[');
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once(']').filter(|(name, _)| is_page(name)) {
            Some((name, rest)) => out.push_str(&format!("the guide's page '{name}'{rest}")),
            None => out.push_str(&format!("[{part}")),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_named_and_other_brackets_stay() {
        assert_eq!(plain("see [programs]."), "see the guide's page 'programs'.");
        assert_eq!(plain("set `mains_hz: []`, [49, 51]"), "set `mains_hz: []`, [49, 51]");
    }
}
