//! The shell of all pages: one file that asks nobody for anything, with its own style and script,
//! which the browser accepts by their digests alone. Data stands in one block of JSON, text is
//! escaped.

mod arm;
mod digest;
mod table;

use serde::Serialize;

use super::drawing::{Canvas, dark_rules, escaped};
use super::json::{NotFinite, laid_out};
use crate::wording::printable;

pub(super) use arm::{Slider, controls};
pub(super) use table::Table;

const STYLE: &str = include_str!("page.css");

const SCRIPT: &str = concat!(
    "'use strict';\n(() => {\n",
    include_str!("kinematics.js"),
    include_str!("arm.js"),
    include_str!("plots.js"),
    include_str!("tables.js"),
    include_str!("job.js"),
    include_str!("main.js"),
    "})();\n"
);

/// Text of a file or a user, as it may stand in a page.
pub(super) fn text(text: &str) -> String {
    escaped(&printable(text))
}

/// The same, with its lines.
pub(super) fn text_lines(text: &str) -> String {
    let lines = text.lines().map(|line| escaped(&printable(line)) + "\n");
    lines.collect()
}

/// Facts with their names, one below the other.
pub(super) fn facts(facts: &[(&str, String)]) -> String {
    let one = |(name, fact): &(&str, String)| format!("<dt>{name}</dt><dd>{}</dd>\n", text(fact));
    format!("<dl>\n{}</dl>\n", facts.iter().map(one).collect::<String>())
}

/// A page with its title and its contents (HTML), and what its script works with.
///
/// # Errors
/// If a number is not finite, which would be a fault of the program.
pub(super) fn page(title: &str, body: &str, data: &impl Serialize) -> Result<String, NotFinite> {
    let title = text(title);
    // Within a script, only `<` could end or change it.
    let data = laid_out(data, 0)?.replace('<', "\\u003c");
    let style = format!("{STYLE}@media (prefers-color-scheme: dark) {{\n{}}}\n", dark_rules());
    let [style_digest, script_digest] = [&*style, SCRIPT].map(digest::sha256_base64);
    let version = env!("CARGO_PKG_VERSION");
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'sha256-{style_digest}'; script-src 'sha256-{script_digest}'; base-uri 'none'; \
         form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{style}</style>\n</head>\n<body>\n{body}\
         <footer>detune {version}</footer>\n\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>{SCRIPT}</script>\n</body>\n</html>\n"
    ))
}

/// A drawing with a caption, which may be wider than the screen.
pub(super) fn figure(caption: &str, drawing: &Canvas) -> String {
    let caption = text(caption);
    let svg = drawing.svg().replacen("<svg ", &format!("<svg aria-label=\"{caption}\" "), 1);
    format!(
        "<figure><figcaption>{caption}</figcaption><div class=\"scroll\">{svg}</div></figure>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_the_data_ends_the_script() {
        let hostile = "</script><script>alert(1)</script><!--<script>";
        let page = page(hostile, "", &[hostile]).unwrap();
        assert_eq!(page.matches("<script").count(), 2, "{page}");
        assert_eq!(page.matches("</script").count(), 2, "{page}");
        assert!(!page.contains("<!--"));
        let data = page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
        assert_eq!(serde_json::from_str::<Vec<String>>(data).unwrap(), [hostile]);
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        assert!(page("", "", &[f64::NAN]).is_err());
    }
}
