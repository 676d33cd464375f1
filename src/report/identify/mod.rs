//! What `identify` found, as text, JSON, SVG, and as the table of modes that `diagnose` reads.

mod json;
mod svg;
mod table;
mod text;

pub(super) use json::Identification;
pub use json::identification_json;
pub use svg::identification_svg;
pub use table::measured_csv;
pub use text::identification_text;

use crate::identify::Kind;
use crate::identify::links::Sense;
use crate::identify::record::Pose;
use crate::identify::record_modes::Mode;

/// How a record was taken, in words.
fn kind_words(kind: Kind) -> &'static str {
    match kind {
        Kind::Hammer => "hammer test",
        Kind::Steady => "steady excitation",
        Kind::FreeDecay => "free decay",
        Kind::GivenResponses => "given frequency responses",
    }
}

/// A pose for people.
fn pose_words(pose: &Pose) -> String {
    match pose {
        Pose::Beta2Rad(beta2) => format!("beta2 {beta2} rad"),
        Pose::JointsDeg(joints) => {
            let values: Vec<String> = joints.iter().map(f64::to_string).collect();
            format!("joints [{}]°", values.join(", "))
        }
    }
}

fn sense_words(sense: Sense) -> &'static str {
    match sense {
        Sense::Together => "together",
        Sense::Against => "against",
        Sense::Unclear => "unclear",
    }
}

/// The shape of a mode in words: the links where points are marked, else the responses that move.
fn shape_words(mode: &Mode) -> String {
    /// Parts below this share of the largest are not worth a word.
    const LEAST: f64 = 0.05;
    if mode.links.len() > 1 {
        return links_words(mode);
    }
    let mut parts: Vec<_> = mode.shape.iter().filter(|part| part.value.norm() >= LEAST).collect();
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

fn links_words(mode: &Mode) -> String {
    let senses: Vec<Sense> = mode.links.iter().skip(1).map(|link| link.sense).collect();
    let together = if senses.iter().all(|sense| *sense == Sense::Together) {
        "links turn together".to_owned()
    } else if let (1, [Sense::Against]) = (senses.len(), senses.as_slice()) {
        "links turn against each other".to_owned()
    } else {
        let first = mode.links.first().map_or("", |link| link.link.as_str());
        let others: Vec<String> = mode
            .links
            .iter()
            .skip(1)
            .map(|link| format!("{} {}", link.link, sense_words(link.sense)))
            .collect();
        format!("against {first}: {}", others.join(", "))
    };
    let most = mode.links.iter().map(|link| link.rotation.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let sizes: Vec<String> = mode
        .links
        .iter()
        .map(|link| format!("{} {:.2}", link.link, link.rotation.norm() / most))
        .collect();
    format!("{together} ({})", sizes.join(", "))
}
