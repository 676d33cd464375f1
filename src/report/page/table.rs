//! Tables of a page, which a reader can copy and take along as CSV.

use super::text;

/// A table with a head.
pub(in crate::report) struct Table {
    html: String,
    /// Per column, whether it holds words.
    words: Vec<bool>,
}

impl Table {
    /// Named as its file would be; columns with their names and whether they hold words.
    pub(in crate::report) fn new(name: &str, columns: &[(&str, bool)]) -> Self {
        let head = columns.iter().map(|(column, is_word)| {
            let class = if *is_word { " class=\"word\"" } else { "" };
            format!("<th scope=\"col\"{class}>{}</th>", text(column))
        });
        let html = format!(
            "<div class=\"scroll\"><table data-csv=\"{}\"><thead><tr>{}</tr></thead><tbody>\n",
            text(name),
            head.collect::<String>()
        );
        Self { html, words: columns.iter().map(|(_, is_word)| *is_word).collect() }
    }

    /// A row: each cell as it is shown and, where a number was rounded, with all its digits.
    pub(in crate::report) fn row(&mut self, cells: &[(String, Option<f64>)]) {
        self.html.push_str("<tr>");
        for ((shown, full), is_word) in cells.iter().zip(&self.words) {
            let class = if *is_word { " class=\"word\"" } else { "" };
            let value = full.map_or_else(String::new, |full| format!(" data-value=\"{full}\""));
            self.html.push_str(&format!("<td{class}{value}>{}</td>", text(shown)));
        }
        self.html.push_str("</tr>\n");
    }

    /// All of it.
    pub(in crate::report) fn finish(self) -> String {
        self.html + "</tbody></table></div>\n"
    }
}
