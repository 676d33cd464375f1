//! Universal files: each mode's shape as data set 55 (complex modes) and, where a force was
//! measured, the frequency responses that the modes make as data set 58 (SDRC, Universal File
//! Datasets).

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write;

use nalgebra::Complex;

use super::pose_words;
use crate::identify::mode::{Mode, ShapePart};
use crate::identify::record_modes::IdentifiedRecord;
use crate::identify::session::{IdentifiedSession, PoseMode};
use crate::notes::Code;

/// Directions by number, from 1: of translation, then of rotation.
const AXES: [&str; 6] = ["X", "Y", "Z", "RX", "RY", "RZ"];

/// A part of a shape: node, direction (from 1) and the sign of the name's direction.
type Freedom = (usize, usize, f64);

/// The modes of all records, and what they make of a measured force. A response whose name is no
/// node with a direction (`12-Z`) gets the node of its place in the record, direction X.
pub fn identification_uff(found: &IdentifiedSession) -> String {
    let mut out = String::new();
    for pose in &found.poses {
        let at = pose_words(&pose.pose, found.joint_columns.as_deref());
        let mut records: Vec<usize> =
            pose.modes.iter().flat_map(|mode| &mode.members).map(|(record, _)| *record).collect();
        records.sort_unstable();
        records.dedup();
        for record in records.into_iter().filter_map(|index| found.records.get(index)) {
            for (index, mode) in record.modes.iter().enumerate() {
                let pole = (mode.frequency_hz, mode.damping_ratio);
                let title = [record.name.as_str(), &at, mode.suspicion.map_or("NONE", Code::name)];
                shape(&mut out, index + 1, pole, title, &mode.shape);
            }
            responses(&mut out, record, &at);
        }
        for mode in pose.modes.iter().filter(|mode| has_set_ups(found, mode)) {
            let pole = (mode.frequency_hz, mode.damping_ratio);
            let title = ["all records of the pose", at.as_str(), "NONE"];
            shape(&mut out, mode.number.unwrap_or(0), pole, title, &mode.shape);
        }
    }
    out
}

/// Whether its shape over all records of the pose has more responses than each record has.
fn has_set_ups(found: &IdentifiedSession, mode: &PoseMode) -> bool {
    let of = |&(record, own): &(usize, usize)| found.records[record].modes[own].shape.len();
    mode.number.is_some() && mode.members.iter().all(|member| of(member) < mode.shape.len())
}

fn freedom(name: &str, place: usize) -> Freedom {
    node_of(name).unwrap_or((place + 1, 1, 1.0))
}

fn node_of(name: &str) -> Option<Freedom> {
    let (node, direction) = name.split_at(name.rfind(['+', '-'])?);
    let axis = AXES.iter().position(|axis| *axis == &direction[1..])?;
    let sign = if direction.starts_with('-') { -1.0 } else { 1.0 };
    Some((node.parse().ok()?, axis + 1, sign))
}

/// A line of text as a data set may hold it.
fn line(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii() && !c.is_control() { c } else { '?' }).take(80).collect()
}

/// Data set 55: complex eigenvalue of first order, three or six directions of displacement a node.
/// Its title says where it comes from, at which pose, and what else it may be.
fn shape(
    out: &mut String,
    number: usize,
    (hz, ratio): (f64, f64),
    [name, at, suspicion]: [&str; 3],
    parts: &[ShapePart],
) {
    let mut nodes: BTreeMap<usize, [Complex<f64>; 6]> = BTreeMap::new();
    for (place, part) in parts.iter().enumerate() {
        let (node, axis, sign) = freedom(&part.response, place);
        nodes.entry(node).or_default()[axis - 1] = part.value * sign;
    }
    // Three translations a node, where nothing turns: readers of six complex values are rare.
    let turns = nodes.values().any(|values| values[3..].iter().any(|v| *v != Complex::default()));
    let (kind, count) = if turns { (3, 6) } else { (2, 3) };
    let omega = TAU * hz;
    let [re, im] = [-ratio * omega, omega * (1.0 - ratio * ratio).max(0.0).sqrt()];
    let _ = writeln!(
        out,
        "    -1\n    55\n{}\n{}\n{}\n{}\nNONE",
        line(&format!("Mode {number}: {hz:.6} Hz, damping ratio {ratio:.6}")),
        line(name),
        line(at),
        line(suspicion)
    );
    // Structural, complex eigenvalue, directions, displacement, complex, values a node.
    let _ = writeln!(out, "{:10}{:10}{kind:10}{:10}{:10}{count:10}", 1, 3, 8, 5);
    let _ = writeln!(out, "{:10}{:10}{:10}{number:10}", 2, 6, 1);
    [re, im, 0.0, 0.0, 0.0, 0.0].iter().for_each(|value| out.push_str(&number_of(*value)));
    out.push('\n');
    for (node, values) in nodes {
        let _ = writeln!(out, "{node:10}");
        for half in values[..count].chunks(3) {
            for value in half {
                let _ = write!(out, "{}{}", number_of(value.re), number_of(value.im));
            }
            out.push('\n');
        }
    }
    out.push_str("    -1\n");
}

/// A number in thirteen columns, its exponent in two digits, as FORTRAN reads it.
fn number_of(value: f64) -> String {
    let text = format!("{value:.5e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>13}", format!("{mantissa}e{sign}{:02}", exponent.abs()))
}

/// A receptance that is written: its name, its response and its reference, and by mode the modal
/// constant.
struct Receptance {
    name: String,
    response: Freedom,
    /// `None` where the record has one, which its shapes do not name.
    reference: Option<Freedom>,
    constants: Vec<Complex<f64>>,
}

/// Of each part of the shapes; of a record with several references, of each pair that was measured.
fn receptances(record: &IdentifiedRecord, modes: &[&Mode]) -> Option<Vec<Receptance>> {
    let first = modes.first()?;
    let of_pairs: Option<Vec<Receptance>> =
        record.spectra.iter().map(|own| of_pair(&own.response, modes)).collect();
    if let Some(of_pairs) = of_pairs.filter(|of_pairs| !of_pairs.is_empty()) {
        return Some(of_pairs);
    }
    // Where a name that is none of the shapes' was fitted, the constants of each mode are for
    // another force.
    let is_part = |name: &str| first.shape.iter().any(|part| part.response == name);
    let are_of_one = record.spectra.iter().all(|own| is_part(&own.response));
    let one = |(place, part): (usize, &ShapePart)| {
        let (node, axis, sign) = freedom(&part.response, place);
        let constant = |mode: &&Mode| {
            let own = mode.shape.iter().find(|own| own.response == part.response)?;
            Some(own.modal_constant? * sign)
        };
        let constants = modes.iter().map(constant).collect::<Option<_>>()?;
        let response = (node, axis, 1.0);
        Some(Receptance { name: part.response.clone(), response, reference: None, constants })
    };
    first.shape.iter().enumerate().map(one).collect::<Option<_>>().filter(|_| are_of_one)
}

/// The receptance of a response and a reference, as `3+Z/1-Z` names them, from shapes that hold
/// both: in positive directions, as theirs are.
fn of_pair(name: &str, modes: &[&Mode]) -> Option<Receptance> {
    let (response, reference) = name.rsplit_once('/')?;
    let place = |name: &str| {
        let parts = modes.first()?.shape.iter().enumerate();
        let own = node_of(name).map(|(node, axis, _)| (node, axis));
        let is_it = |part: &ShapePart| {
            part.response == name
                || own.is_some()
                    && node_of(&part.response).map(|(node, axis, _)| (node, axis)) == own
        };
        parts.into_iter().find(|(_, part)| is_it(part))
    };
    let (response, reference) = (place(response)?, place(reference)?);
    let constant = |mode: &&Mode| {
        let of = |name: &str| mode.shape.iter().find(|part| part.response == name)?.mass_normalised;
        Some(of(&response.1.response)? * of(&reference.1.response)?)
    };
    let at = |(place, part): (usize, &ShapePart)| freedom(&part.response, place);
    Some(Receptance {
        name: name.to_owned(),
        constants: modes.iter().map(constant).collect::<Option<_>>()?,
        response: at(response),
        reference: Some(at(reference)),
    })
}

/// Data set 58: receptances on the lines of the record's spectra.
fn responses(out: &mut String, record: &IdentifiedRecord, at: &str) {
    let modes: Vec<&Mode> = record.modes.iter().filter(|m| m.suspicion.is_none()).collect();
    let Some(lines) = record.spectra.first().map(|own| &own.frequencies_hz[..]) else { return };
    let ([first, second, ..], Some(all)) = (lines, receptances(record, &modes)) else { return };
    for Receptance { name, response: (node, axis, _), reference, constants } in all {
        let name = line(&format!("{name} of {}, {at}", record.name));
        let (from, along, _) = reference.unwrap_or((0, 0, 1.0));
        let _ = writeln!(
            out,
            "    -1\n    58\n{name}\nsynthesised from {} modes\nNONE\nNONE\nNONE",
            modes.len()
        );
        let _ = writeln!(
            out,
            "{:5}{:10}{:5}{:10} {:<10}{node:10}{axis:4} {:<10}{from:10}{along:4}",
            4, 0, 1, 0, "NONE", "NONE"
        );
        let _ = writeln!(
            out,
            "{:10}{:10}{:10}{}{}{}",
            6,
            lines.len(),
            1,
            number_of(*first),
            number_of(second - first),
            number_of(0.0)
        );
        for kind in [18, 8, 13, 0] {
            let _ = writeln!(out, "{kind:10}{:5}{:5}{:5} {:<20} {:<20}", 0, 0, 0, "NONE", "NONE");
        }
        for hz in lines {
            let omega = TAU * hz;
            let one = |(mode, constant): (&&Mode, &Complex<f64>)| {
                let own = TAU * mode.frequency_hz;
                let damping = 2.0 * mode.damping_ratio * own * omega;
                constant / Complex::new(own * own - omega * omega, damping)
            };
            let sum = modes.iter().zip(&constants).map(one).sum::<Complex<f64>>();
            let _ = writeln!(out, "{:20.11e}{:20.11e}", sum.re, sum.im);
        }
        out.push_str("    -1\n");
    }
}
