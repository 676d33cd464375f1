//! How far a map has come.

use indicatif::{ProgressBar, ProgressStyle};

/// Counts poses on standard error while it is a terminal, and shows nothing elsewhere.
pub(super) fn bar(poses: Option<usize>) -> ProgressBar {
    let (bar, template) = match poses {
        Some(poses) => {
            (ProgressBar::new(poses as u64), "{bar:30} {human_pos} of {human_len} poses, {eta}")
        }
        None => (ProgressBar::new_spinner(), "{spinner} {human_pos} poses, {elapsed}"),
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}
