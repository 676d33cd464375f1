//! What a calibration learned, as robot.yaml has it.

use std::fmt::Write as _;

use super::raw::robot as raw;
use crate::formats::yaml::{Node, Step};
use crate::model::{Fingerprint, LearnedParameter, ParameterKind, Posterior, Unexplained};
use crate::notes::{Code, Notes};

/// The posterior of a calibration; `None` behind the error that says why.
pub(super) fn posterior(
    raw: &raw::Posterior,
    joints: usize,
    tree: &Node,
    notes: &mut Notes,
) -> Option<Posterior> {
    let read = read(raw, joints);
    read.map_err(|what| {
        let line = tree.line_at(&[Step::Key("calibration"), Step::Key("posterior")]);
        let what = format!(
            "calibration.posterior {what}; it is written by detune diagnose --write, run it again"
        );
        notes.error(Code::Value, line, what);
    })
    .ok()
}

fn read(raw: &raw::Posterior, joints: usize) -> Result<Posterior, String> {
    let list = raw.parameters.as_deref().unwrap_or_default();
    let parameters: Vec<LearnedParameter> =
        list.iter().enumerate().map(|(i, one)| parameter(i, one)).collect::<Result<_, _>>()?;
    let correlation = raw.correlation.clone().unwrap_or_default();
    let is_triangle = correlation.len() == parameters.len()
        && correlation.iter().enumerate().all(|(i, row)| row.len() == i);
    if !is_triangle {
        let count = parameters.len();
        return Err(format!(
            "has {count} parameters, so its correlation must have {count} rows of 0, 1, 2, … \
             values"
        ));
    }
    if let Some(beyond) = correlation.iter().flatten().find(|c| !(-1.0..=1.0).contains(*c)) {
        return Err(format!("has a correlation of {beyond}, must lie between -1 and 1"));
    }
    let unexplained = Unexplained {
        near: raw.near_ln_std.clone().unwrap_or_default(),
        far: raw.far_ln_std.clone().unwrap_or_default(),
        poses: raw.joints.clone().unwrap_or_default(),
        reach: raw.reach.unwrap_or_default(),
    };
    let is_share = |share: &f64| (0.0..=10.0).contains(share);
    if !unexplained.near.iter().chain(&unexplained.far).all(is_share) {
        return Err("has a value of near_ln_std or far_ln_std outside 0 to 10".to_owned());
    }
    if unexplained.near.len() != unexplained.far.len() {
        return Err("must have as many values in near_ln_std as in far_ln_std".to_owned());
    }
    let is_pose = |q: &Vec<f64>| q.len() == joints && q.iter().all(|q| q.is_finite());
    if unexplained.poses.is_empty() || !unexplained.poses.iter().all(is_pose) {
        return Err(format!("must have poses of {joints} joint positions in joints"));
    }
    let fingerprint = match &raw.fingerprint {
        None => None,
        Some(raw) => {
            let known = raw.mass_diagonal.clone().zip(raw.stiffness_diagonal.clone());
            let (mass_diagonal, stiffness_diagonal) =
                known.ok_or("must have mass_diagonal and stiffness_diagonal in fingerprint")?;
            if mass_diagonal.len() != stiffness_diagonal.len()
                || !mass_diagonal.iter().chain(&stiffness_diagonal).all(|v| *v > 0.0)
            {
                return Err("must have as many positive values in mass_diagonal as in \
                            stiffness_diagonal"
                    .to_owned());
            }
            Some(Fingerprint { mass_diagonal, stiffness_diagonal })
        }
    };
    Ok(Posterior { parameters, correlation, unexplained, fingerprint })
}

fn parameter(i: usize, raw: &raw::LearnedParameter) -> Result<LearnedParameter, String> {
    let at = |kind: ParameterKind| match kind {
        ParameterKind::Spring => &raw.spring,
        ParameterKind::Link => &raw.link,
        ParameterKind::Drive => &raw.drive,
        ParameterKind::Foundation => &raw.foundation,
        ParameterKind::Bending => &raw.bending,
    };
    let mut named =
        ParameterKind::ALL.into_iter().filter_map(|kind| Some((kind, at(kind).clone()?)));
    let (Some((kind, at)), None) = (named.next(), named.next()) else {
        let keys = ParameterKind::ALL.map(ParameterKind::key).join(", ");
        return Err(format!("must name one of {keys} in parameters[{i}]"));
    };
    let (Some(ln), Some(std)) = (raw.ln, raw.ln_std) else {
        return Err(format!("must have ln and ln_std in parameters[{i}]"));
    };
    Ok(LearnedParameter { kind, at, ln, std })
}

/// The entry of a calibration in braces, behind what stands before it.
pub(super) fn write(out: &mut String, posterior: &Posterior, quoted: &dyn Fn(&str) -> String) {
    let Posterior { parameters, correlation, unexplained, fingerprint } = posterior;
    let parameters: Vec<String> = parameters
        .iter()
        .map(|LearnedParameter { kind, at, ln, std }| {
            let key = kind.key();
            format!("      {{{key}: {}, ln: {ln}, ln_std: {std}}}", quoted(at))
        })
        .collect();
    let rows = |rows: &[Vec<f64>]| {
        let rows: Vec<String> = rows.iter().map(|row| format!("      {row:?}")).collect();
        rows.join(",\n")
    };
    // Writing to a string does not fail.
    let _ = write!(
        out,
        ",\n  posterior: {{\n    parameters: [\n{}],\n    correlation: [\n{}],\n    near_ln_std: \
         {:?},\n    far_ln_std: {:?},\n    reach: {},\n    joints: [\n{}]",
        parameters.join(",\n"),
        rows(correlation),
        unexplained.near,
        unexplained.far,
        unexplained.reach,
        rows(&unexplained.poses),
    );
    if let Some(Fingerprint { mass_diagonal, stiffness_diagonal }) = fingerprint {
        let _ = write!(
            out,
            ",\n    fingerprint: {{mass_diagonal: {mass_diagonal:?}, stiffness_diagonal: \
             {stiffness_diagonal:?}}}"
        );
    }
    out.push('}');
}
