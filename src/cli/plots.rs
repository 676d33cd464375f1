//! The plots of a verb: `--plots` as files of SVG in a folder, `--format plot` with characters.

use std::fs;
use std::path::PathBuf;

use clap::Args;

use super::output::Sink;
use crate::notes::{Code, Note, Place};
use crate::report::Plot;
use crate::wording::printable;

/// Where plots go.
#[derive(Debug, Default, Args)]
pub(super) struct PlotsArgs {
    /// Also write each plot as SVG to this folder, which is made where it is missing.
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
}

/// A plot's file and its contents.
pub(super) type PlotFile = (Sink, String);

impl PlotsArgs {
    /// Whether somebody asks for plots.
    pub(super) fn is_asked(&self) -> bool {
        self.plots.is_some()
    }

    /// The files for plots, each with its name without the ending; none where nobody asked.
    pub(super) fn files(
        &self,
        plots: impl FnOnce() -> Vec<Plot>,
    ) -> Result<Vec<PlotFile>, Vec<Note>> {
        let Some(folder) = &self.plots else { return Ok(Vec::new()) };
        fs::create_dir_all(folder).map_err(|error| {
            let what = format!("is not written: {error}");
            vec![Note::error(Code::Unwritable, Place::file(folder), what)]
        })?;
        let one = |(name, drawing): Plot| {
            Ok((Sink::open(Some(&folder.join(file_name(&name))))?, drawing.svg()))
        };
        plots().into_iter().map(one).collect()
    }
}

/// All plots with characters, each below its name; with colours where `sink` shows them.
pub(super) fn in_characters(plots: &[Plot], sink: &Sink) -> String {
    let colour = sink.shows_colour();
    let one =
        |(name, drawing): &Plot| format!("{}\n\n{}", printable(name), drawing.characters(colour));
    plots.iter().map(one).collect::<Vec<_>>().join("\n")
}

/// A name that every file system takes.
fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { '-' };
    name.chars().map(plain).collect::<String>() + ".svg"
}
