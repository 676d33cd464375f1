//! The modes of a session as a page: a table of all, then a sheet for each record with spectrum,
//! phase, coherence, stabilisation and shapes.

use serde_json::json;

use super::plots::{arrows, coherence, phase, shapes};
use super::svg::sheet;
use super::{kind_words, mode_name, pose_words, record_and_channel, shape_words};
use crate::identify::record_modes::IdentifiedRecord;
use crate::identify::session::IdentifiedSession;
use crate::report::Plot;
use crate::report::json::NotFinite;
use crate::report::page::{self, Table, figure, text};
use crate::report::words::{significant, trimmed};
use crate::units::percent_from_ratio;

/// The page of a session.
///
/// # Errors
/// If a number is not finite, which would be a fault of the program.
pub fn identification_html(found: &IdentifiedSession) -> Result<String, NotFinite> {
    let (poses, records) = (found.poses.len(), found.records.len());
    let modes: usize = found.poses.iter().map(|pose| pose.modes.len()).sum();
    let mut body = format!(
        "<header><h1>Modes of a session</h1>\n\
         <p>{modes} modes at {poses} poses from {records} records</p></header>\n"
    );
    body.push_str(&table(found));
    body.push_str(&warnings(found));
    for record in &found.records {
        body.push_str(&of_record(record));
    }
    page::page("Modes of a session", &body, &json!({ "jobs": [] }))
}

/// The plots of each record, with their names.
pub fn identification_plots(found: &IdentifiedSession) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (index, record) in found.records.iter().enumerate() {
        let name = |plot: &str| format!("{}-{}-{plot}", index + 1, record.name);
        plots.push((name("spectrum"), sheet(record)));
        for (what, svg) in [
            ("phase", phase(record)),
            ("coherence", coherence(record)),
            ("arrows", arrows(record)),
            ("shapes", shapes(record)),
        ] {
            plots.extend(svg.map(|svg| (name(what), svg)));
        }
    }
    plots
}

fn table(found: &IdentifiedSession) -> String {
    let columns = [
        ("pose", true),
        ("mode", true),
        ("Hz", false),
        ("± std", false),
        ("damping %", false),
        ("± std", false),
        ("shape", true),
    ];
    let mut table = Table::new("modes", &columns);
    for at in &found.poses {
        let id = at.id.as_ref().map_or_else(String::new, |id| format!("{id}: "));
        let pose = id + &pose_words(&at.pose, found.joint_columns.as_deref());
        for mode in &at.modes {
            let name = mode_name(mode);
            let first = mode.members.first();
            let of = first.and_then(|(record, index)| found.records[*record].modes.get(*index));
            let [zeta, zeta_std] = [mode.damping_ratio, mode.damping_std].map(percent_from_ratio);
            table.row(&[
                (pose.clone(), None),
                (name, None),
                (trimmed(mode.frequency_hz, 3), Some(mode.frequency_hz)),
                (significant(mode.frequency_std_hz), Some(mode.frequency_std_hz)),
                (trimmed(zeta, 3), Some(zeta)),
                (significant(zeta_std), Some(zeta_std)),
                (of.map_or_else(String::new, shape_words), None),
            ]);
        }
    }
    table.finish()
}

fn warnings(found: &IdentifiedSession) -> String {
    let all = found.records.iter().flat_map(|record| &record.warnings).chain(&found.warnings);
    let items = all.map(|note| {
        let (record, channel) = record_and_channel(note);
        let place: Vec<&str> = [record, channel].into_iter().flatten().collect();
        let place = if place.is_empty() { String::new() } else { place.join(", ") + ": " };
        format!("<li>{}</li>\n", text(&format!("{place}{} ({})", note.what, note.code)))
    });
    let items: String = items.collect();
    if items.is_empty() { items } else { format!("<h2>Warnings</h2>\n<ul>\n{items}</ul>\n") }
}

fn of_record(record: &IdentifiedRecord) -> String {
    let mut html = format!(
        "<h2>{}</h2>\n<p class=\"soft\">{}</p>\n",
        text(&record.name),
        kind_words(record.kind)
    );
    html.push_str(&figure("Spectrum, fit, and stabilisation diagram", &sheet(record)));
    for (caption, svg) in [
        ("Phase of the frequency response", phase(record)),
        ("Coherence of force and response", coherence(record)),
        ("Shapes on the marked points: at rest grey, displaced dashed", arrows(record)),
        ("Shapes: displacement of each response against the largest", shapes(record)),
    ] {
        html.extend(svg.map(|svg| figure(caption, &svg)));
    }
    html
}
