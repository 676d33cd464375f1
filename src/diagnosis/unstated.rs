//! Joints that the table does not state. Where they were taken to be says nothing of the arm, so a
//! cause whose effect depends on them is not tested.

use rayon::prelude::*;

use super::candidate::{Candidate, Scale};
use super::data::Data;
use super::hypothesis::Hypothesis;
use super::outcome::Untested;
use super::predict::predict;
use crate::model::{Description, Robot};
use crate::notes::{Code, Note, Place};

/// Where else an unstated joint may have stood, from where it was taken to be, rad or m.
const ELSEWHERE: [f64; 2] = [0.7, -1.5];

/// Rows that show whether a frequency depends on a joint.
const ROWS: usize = 6;

/// Frequencies that differ by less do so by rounding.
const ROUNDING: f64 = 1e-6;

/// What the unstated joints leave to test.
pub(super) struct Stated {
    pub(super) candidates: Vec<Candidate>,
    pub(super) untested: Vec<Untested>,
    /// If the model itself depends on them.
    pub(super) note: Option<Note>,
}

/// Sets candidates aside whose effect depends on a joint that the table does not state, although
/// the model without them does not.
pub(super) fn stated(
    description: &Description,
    robot: &Robot,
    data: &Data,
    unstated: &[String],
    candidates: Vec<Candidate>,
) -> Stated {
    let few = few(data);
    let depends = |hypothesis: &Hypothesis<'_>, joint: usize| {
        depends(description, hypothesis, &few, joint).unwrap_or(false)
    };
    let names = robot.joints().iter().enumerate().map(|(joint, own)| (joint, &own.name));
    let (of_model, free): (Vec<_>, Vec<_>) = names
        .filter(|(_, name)| unstated.contains(name))
        .partition(|&(joint, _)| depends(&Hypothesis::default(), joint));
    let on_which = |candidate: &Candidate| -> Vec<String> {
        let is_one = |joint: usize| {
            let mut inner = probes(candidate).into_iter();
            inner.any(|inner| depends(&Hypothesis { effects: vec![(candidate, inner)] }, joint))
        };
        free.iter().filter(|(joint, _)| is_one(*joint)).map(|(_, name)| (*name).clone()).collect()
    };
    let joints: Vec<Vec<String>> = candidates.par_iter().map(on_which).collect();
    let (kept, aside): (Vec<_>, Vec<_>) =
        candidates.into_iter().zip(joints).partition(|(_, joints)| joints.is_empty());
    let candidates: Vec<Candidate> = kept.into_iter().map(|(candidate, _)| candidate).collect();
    let mut untested: Vec<Untested> = Vec::new();
    for (candidate, joints) in aside {
        let known =
            untested.iter_mut().find(|u| u.cause == candidate.cause && u.at == candidate.at);
        match known {
            Some(known) => known.joints.extend(joints),
            None => untested.push(Untested {
                in_part: candidates.iter().any(|kept| kept.same_place(&candidate)),
                cause: candidate.cause,
                at: candidate.at,
                joints,
            }),
        }
    }
    for Untested { joints, .. } in &mut untested {
        joints.sort();
        joints.dedup();
    }
    let of_model: Vec<&str> = of_model.into_iter().map(|(_, name)| name.as_str()).collect();
    Stated { candidates, untested, note: assumed(&of_model) }
}

/// A few rows that show what frequencies depend on.
fn few(data: &Data) -> Data {
    let step = data.rows.len().div_ceil(ROWS).max(1);
    data.only(|row| row % step == 0)
}

/// Whether frequencies at rows of a table depend on a joint; `None` if the arm falls over.
fn depends(
    description: &Description,
    hypothesis: &Hypothesis<'_>,
    few: &Data,
    joint: usize,
) -> Option<bool> {
    let here = frequencies(description, hypothesis, few)?;
    Some(ELSEWHERE.iter().any(|by| {
        let mut moved = few.clone();
        moved.rows.iter_mut().for_each(|row| row.q[joint] += by);
        frequencies(description, hypothesis, &moved).is_none_or(|moved| differ(&here, &moved))
    }))
}

/// By joint, whether no frequency depends on it.
pub(super) fn inert(
    description: &Description,
    hypothesis: &Hypothesis<'_>,
    data: &Data,
) -> Vec<bool> {
    let few = few(data);
    let joints = data.rows.first().map_or(0, |row| row.q.len());
    let depends = |joint| depends(description, hypothesis, &few, joint).unwrap_or(true);
    (0..joints).map(|joint| !depends(joint)).collect()
}

fn assumed(joints: &[&str]) -> Option<Note> {
    let [_, others @ ..] = joints else { return None };
    let it = if others.is_empty() { "it" } else { "them" };
    let what = format!(
        "the model's own frequencies depend on {}, and the table does not state {it}: they are \
         predicted for another pose than the measured one, and errors and findings are those of \
         that pose",
        joints.join(", ")
    );
    Some(Note::warning(Code::AssumedPose, Place::default(), what))
}

/// Parameters at which a candidate shows what it depends on: where fits start, and away from there.
fn probes(candidate: &Candidate) -> Vec<Vec<f64>> {
    let starts = candidate.starts();
    let Some(start) = starts.last().filter(|_| !candidate.cause.is_of_the_instrument()) else {
        return Vec::new();
    };
    let away = candidate.parameters.iter().zip(start).map(|(parameter, &inner)| {
        let by = match parameter.scale {
            Scale::Log => 0.3,
            Scale::Linear(_) => 1.0,
        };
        parameter.clamp(inner + by)
    });
    vec![start.clone(), away.collect()]
}

/// ln of the frequencies of each row; `None` if the arm falls over.
fn frequencies(
    description: &Description,
    hypothesis: &Hypothesis<'_>,
    data: &Data,
) -> Option<Vec<Vec<f64>>> {
    let rows = predict(description, hypothesis, data)?;
    Some(rows.iter().map(|row| row.iter().map(|frequency| frequency.ln_hz).collect()).collect())
}

fn differ(here: &[Vec<f64>], there: &[Vec<f64>]) -> bool {
    here.iter().zip(there).any(|(here, there)| {
        here.len() != there.len()
            || here.iter().zip(there).any(|(here, there)| (here - there).abs() > ROUNDING)
    })
}
