//! What `identify` found, as text, JSON, SVG, and as the table of modes that `diagnose` reads.

mod html;
mod json;
mod plots;
mod svg;
mod table;
mod text;
mod uff;

pub use html::{identification_html, identification_plots};
pub(super) use json::Identification;
pub use json::identification_json;
pub use svg::identification_drawing;
pub use table::measured_csv;
pub use text::identification_text;
pub use uff::identification_uff;

use crate::identify::RecordKind;
use crate::identify::links::Sense;
use crate::identify::mode::Mode;
use crate::identify::pose::{JointColumn, Pose};
use crate::identify::session::PoseMode;
use crate::notes::{Note, Part};
use crate::report::words::spelled;

/// How a record was taken, in words.
fn kind_words(kind: RecordKind) -> &'static str {
    match kind {
        RecordKind::Hammer => "hammer test",
        RecordKind::Steady => "steady excitation",
        RecordKind::FreeDecay => "free decay",
        RecordKind::RandomResponse => "random response",
        RecordKind::GivenResponses => "given frequency responses",
    }
}

/// A pose for people.
fn pose_words(pose: &Pose, named: Option<&[JointColumn]>) -> String {
    match pose {
        Pose::Angles { beta1: Some(beta1), beta2 } => format!("beta1 {beta1}, beta2 {beta2} rad"),
        Pose::Angles { beta1: None, beta2 } => format!("beta2 {beta2} rad"),
        Pose::Joints(joints) => {
            let values = degrees_or_mm(joints, named);
            let values: Vec<String> = values.iter().map(f64::to_string).collect();
            format!("joints [{}]°", values.join(", "))
        }
    }
}

/// Joint positions as sessions have them: degrees, millimetres for a joint that slides.
fn degrees_or_mm(joints: &[f64], named: Option<&[JointColumn]>) -> Vec<f64> {
    let columns = JointColumn::list(named, joints.len());
    columns.iter().zip(joints).map(|(column, &si)| column.degrees_or_mm(si)).collect()
}

/// The record and the channel that a note is about.
fn record_and_channel(note: &Note) -> (Option<&str>, Option<&str>) {
    match &note.place.part {
        Some(Part::Record(record)) => (Some(record), None),
        Some(Part::Channel { record, channel }) => (record.as_deref(), Some(channel)),
        _ => (None, None),
    }
}

/// The shape of a mode in words: the links where points are marked, else the responses that move.
fn shape_words(mode: &Mode) -> String {
    /// Smaller parts of the shape, relative to the largest, are not named.
    const MIN_PART: f64 = 0.05;
    if mode.links.len() > 1 {
        return links_words(mode);
    }
    let mut parts: Vec<_> =
        mode.shape.iter().filter(|part| part.value.norm() >= MIN_PART).collect();
    parts.sort_by(|a, b| b.value.norm().total_cmp(&a.value.norm()));
    let words: Vec<String> = parts
        .iter()
        .map(|part| {
            let sign = if part.value.re < 0.0 { "−" } else { "+" };
            format!("{} {sign}{:.2}", part.response, part.value.norm())
        })
        .collect();
    words.join(", ")
}

/// The mode's column in the table, or why it stays out.
fn mode_name(mode: &PoseMode) -> String {
    let code = mode.suspicion.map(|code| code.name().to_owned());
    code.or(mode.number.map(|number| number.to_string())).unwrap_or_default()
}

fn links_words(mode: &Mode) -> String {
    let others: Vec<Sense> = mode.links.iter().skip(1).map(|link| link.sense).collect();
    let senses = if others.iter().all(|sense| *sense == Sense::Together) {
        "links turn together".to_owned()
    } else if let [Sense::Against] = others.as_slice() {
        "links turn against each other".to_owned()
    } else {
        let first = mode.links.first().map_or("", |link| link.link.as_str());
        let others: Vec<String> = mode
            .links
            .iter()
            .skip(1)
            .map(|link| format!("{} {}", link.link, spelled(link.sense)))
            .collect();
        format!("against {first}: {}", others.join(", "))
    };
    let most = mode.links.iter().map(|link| link.rotation.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let sizes: Vec<String> = mode
        .links
        .iter()
        .map(|link| format!("{} {:.2}", link.link, link.rotation.norm() / most))
        .collect();
    format!("{senses} ({})", sizes.join(", "))
}
