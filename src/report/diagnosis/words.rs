//! What is said in several formats.

use crate::diagnosis::{Diagnosis, Estimate, Finding, Shape, Structure, Symmetry, Verdict};
use crate::study::diagnose::Diagnosed;
use crate::units::{deg_from_rad, mm_from_m, percent_from_ratio, unit_of};

/// A number with the digits that a person wants: four significant ones.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..=9).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let decimals = usize::try_from(3 - magnitude).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// "45.0°" or "120.0 mm".
pub(super) fn position(q: f64, slides: bool) -> String {
    if slides { format!("{:.1} mm", mm_from_m(q)) } else { format!("{:.1}°", deg_from_rad(q)) }
}

/// "mass 4.9 kg (95 % interval 4.7 to 5.1), robot file 0".
pub(super) fn estimate(parameter: &Estimate) -> String {
    let (name, unit) = unit_of(&parameter.name);
    let name = name.replace('_', " ");
    let [low, high] = parameter.ci95.map(number);
    let space = if unit.is_empty() { "" } else { " " };
    let mut text = format!(
        "{name} {}{space}{unit} (95 % interval {low} to {high})",
        number(parameter.estimate)
    );
    if parameter.at_bound {
        text.push_str(", at the end of what was searched: the cause may be another");
    }
    if let Some(nominal) = parameter.nominal {
        text.push_str(&format!(", robot file {}", number(nominal)));
        let change = parameter.estimate / nominal - 1.0;
        // Beyond a factor of ten per cent say less than the two values do.
        if change.abs() < 10.0 {
            text.push_str(&format!(" ({:+.1} %)", percent_from_ratio(change)));
        }
    }
    text
}

/// "payload at tool0: the link carries mass that is not in the model".
pub(super) fn finding(finding: &Finding) -> String {
    format!("{}: {}", finding.label(), finding.text.description)
}

/// How a part with a frequency of its own moves; `None` of other causes, and of a part without a
/// place.
pub(super) fn motion(finding: &Finding) -> Option<String> {
    let (axis, from_m, is_counted) = finding.hangs()?;
    let vector = |v: [f64; 3]| format!("[{}]", v.map(number).join(", "));
    let (axis, from, at) = (vector(axis), vector(from_m), finding.at.as_deref()?);
    let mut text = format!("along {axis} from {from} m in the frame of {at}");
    if is_counted {
        text.push_str("; its mass is part of what the robot file has there");
    }
    Some(text)
}

/// "3.8e-12".
pub(super) fn p_value(p: f64) -> String {
    if p < 1e-12 { "< 1e-12".to_owned() } else { format!("{p:.1e}") }
}

/// What is to be known beside the verdict.
pub(super) fn notices(diagnosed: &Diagnosed) -> impl Iterator<Item = &str> {
    diagnosed.notes.iter().map(|note| note.what.as_str())
}

/// The verdict in a sentence.
pub(super) fn verdict(diagnosis: &Diagnosis) -> String {
    let error = diagnosis.baseline.rms_percent;
    match diagnosis.verdict {
        Verdict::Consistent => format!(
            "The model agrees with the measurement: its error of {error:.2} % is noise{}.",
            noise(diagnosis)
        ),
        Verdict::Unexplained if diagnosis.structure_before.is_none() => format!(
            "The error of the model, {error:.2} %, is larger than the noise of such tests{}. It \
             follows no quantity in the table, and no known cause explains it.",
            noise(diagnosis)
        ),
        Verdict::Unexplained => format!(
            "The error of the model, {error:.2} %, is more than noise, but no known cause explains \
             it."
        ),
        Verdict::PartlyExplained => {
            let causes = match diagnosis.findings.len() {
                1 => "one cause reduces".to_owned(),
                count => format!("{count} causes reduce"),
            };
            let remaining = diagnosis.extended.rms_percent;
            format!(
                "The model is off by {error:.2} %; {causes} the error to {remaining:.2} %, but \
                 something else is wrong, too.",
            )
        }
        Verdict::Explained => {
            let causes = match diagnosis.findings.len() {
                1 => "one cause reduces".to_owned(),
                count => format!("{count} causes reduce"),
            };
            let remaining = diagnosis.extended.rms_percent;
            format!("The model is off by {error:.2} %; {causes} the error to {remaining:.2} %.")
        }
    }
}

/// ": 1.2 % of it drifts over the rows", what most of the error is if rows are off as a whole, and
/// how much of it the table states.
fn noise(diagnosis: &Diagnosis) -> String {
    /// Share of the error that is most of it.
    const MOST: f64 = 0.7;
    /// Errors of so many stated deviations are more than these let expect.
    const MANY: f64 = 3.0;
    let (error, noise) = (diagnosis.baseline.rms_percent, &diagnosis.noise);
    let mut text = if noise.drift_percent > MOST * error {
        format!(
            ": {:.2} % of it drifts over the rows of the table, as with temperature or a support \
             that settles",
            noise.drift_percent
        )
    } else if noise.common_percent > MOST * error {
        format!(
            ": {:.2} % of it is common to all modes of a row, as where the pose or the clamping is \
             not repeated exactly",
            noise.common_percent
        )
    } else {
        String::new()
    };
    if let Some(stated) = noise.stated_percent.filter(|stated| error > MANY * stated) {
        let joint = if text.is_empty() { ":" } else { ";" };
        text.push_str(&format!(
            "{joint} the table states deviations of {stated:.2} %, and the calibration takes the \
             rest for an error of the model"
        ));
    }
    text
}

/// About which angles the frequencies mirror, where measured and predicted ones differ.
pub(super) fn symmetry(symmetry: &Symmetry) -> Option<String> {
    let model = symmetry.model.filter(|_| symmetry.differ)?;
    let degrees = |angle: f64| {
        let text = format!("{:.1}", deg_from_rad(angle));
        if text == "-0.0" { "0.0".to_owned() } else { text }
    };
    let [low, high] = symmetry.measured.ci95_rad.map(degrees);
    let mut text = format!(
        "the measured frequencies mirror about {} = {}° (95 % interval {low} to {high}), the \
         model's about {}°",
        symmetry.angle,
        degrees(symmetry.measured.centre_rad),
        degrees(model.centre_rad),
    );
    if let Some(offset) = symmetry.zero_offset_rad {
        text.push_str(&format!(
            ": a zero of {} that is off by {}° does that, or a centre of mass off its axis",
            symmetry.joint,
            degrees(offset)
        ));
    }
    Some(text)
}

/// What else a finding may be; `None` if nothing.
pub(super) fn alternatives(found: &Finding) -> Option<String> {
    let own = found.indistinguishable_from.iter().map(|suspect| suspect.label());
    let more = found.further_alternatives;
    let more = (more > 0).then(|| format!("and {more} more"));
    let all: Vec<String> = own.chain(more).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// What a residual follows, in words.
pub(super) fn structure(structure: &Structure, diagnosis: &Diagnosis) -> String {
    let joint = |joint: usize| diagnosis.joints.get(joint).map_or("?", |(name, _)| name.as_str());
    let what = match &structure.shape {
        Shape::ModeByMode => "each mode has a constant relative error".to_owned(),
        Shape::Joint { joint: j } => format!("all modes follow the position of {}", joint(*j)),
        Shape::ModeOverJoint { mode, joint: j } => {
            format!("mode {} follows the position of {}", mode + 1, joint(*j))
        }
        Shape::ModeOverPose { mode } => format!("mode {} follows the pose", mode + 1),
        Shape::SpringOverJoint { coordinate, joint: j } => {
            let joint = joint(*j);
            format!("as if the spring of {coordinate} varied with the position of {joint}")
        }
        Shape::SpringByPose { coordinate } => {
            format!("as if the spring of {coordinate} varied from pose to pose")
        }
        Shape::InertiaByPose { coordinate } => {
            format!("as if the inertia behind {coordinate} varied from pose to pose")
        }
        Shape::PoseByPose => "all modes of a pose are off together".to_owned(),
        Shape::Load => "as if the inertia of the arm were another with each load".to_owned(),
        Shape::Order => "it follows the order of the rows".to_owned(),
        Shape::Temperature => "it follows the temperature".to_owned(),
        Shape::Amplitude => "it follows the level of excitation".to_owned(),
        Shape::Frequency => "it follows the frequency".to_owned(),
    };
    format!(
        "{what} ({:.0} % of the squared residual, p-value {})",
        percent_from_ratio(structure.share.clamp(0.0, 1.0)),
        p_value(structure.p_value)
    )
}
