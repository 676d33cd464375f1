//! Findings from a choice: how sure, what else it could be, what to measure next.

use super::candidate::{Candidate, Parameter, Scale};
use super::causes::cause_text;
use super::centred::centred;
use super::choose::Choice;
use super::data::Data;
use super::fit::Fit;
use super::hypothesis::Hypothesis;
use super::interval::{Certainty, averaged, certainties};
use super::models::{ALTERNATIVE_WITHIN, Model, p_value};
use super::next_poses::{mass_between, part, poses_between};
use super::outcome::{Estimate, Evidence, Finding, NextPose, NextTest, Suspect, label};
use super::problem::Problem;
use super::statistics::rms;
use crate::model::{Correction, Robot};
use crate::units::percent_from_ratio;

/// Alternatives that are reported with a finding.
const MAX_ALTERNATIVES: usize = 3;

/// The findings of a choice, the one that explains most first; values are those of `widest`, the
/// same causes in their widest form.
pub(super) fn findings(
    problem: &Problem<'_>,
    candidates: usize,
    choice: &Choice<'_>,
    widest: &Fit<'_>,
) -> Vec<Finding> {
    let best = &choice.best;
    let rms_with = rms(best.fit.evaluation.left.residuals.iter());
    let n = problem.data.points.len() as f64;
    let bic = |fit: &Fit<'_>| -2.0 * fit.evaluation.score + fit.freedom * n.ln();
    let mut certainties = averaged(problem, widest, &choice.seen, best.log_evidence).into_iter();
    let mut findings = Vec::new();
    for (i, (candidate, inner)) in widest.hypothesis.effects.iter().enumerate() {
        let parameters = candidate
            .parameters
            .iter()
            .zip(inner)
            .zip(certainties.by_ref())
            .filter(|(_, certainty)| certainty.is_informed)
            .map(|((parameter, &inner), certainty)| estimate(parameter, inner, certainty))
            .collect();
        let mut rest = best.fit.hypothesis.clone();
        rest.effects.remove(i);
        let without = problem.optimise(rest).unwrap_or_else(|| choice.baseline.clone());
        let (indistinguishable_from, further_alternatives) = group(choice, i, candidate);
        findings.push(Finding {
            cause: candidate.cause,
            at: candidate.at.clone(),
            indistinguishable_from,
            further_alternatives,
            parameters,
            hinge: candidate.hinge.clone(),
            text: cause_text(candidate.cause),
            evidence: Evidence {
                delta_bic: bic(&best.fit) - bic(&without),
                p_value: p_value(problem, candidates, &without, &best.fit),
            },
            gain_percent_points: percent_from_ratio(
                rms(without.evaluation.left.residuals.iter()) - rms_with,
            ),
        });
    }
    findings.sort_by(|a, b| b.gain_percent_points.total_cmp(&a.gain_percent_points));
    findings
}

fn estimate(parameter: &Parameter, inner: f64, certainty: Certainty) -> Estimate {
    /// Beyond this factor either way, as its logarithm, nothing is known.
    const FARTHEST: f64 = 14.0;
    // What was searched is no limit of what may be, but no mass is negative.
    let floor = if parameter.bounds[0] == 0.0 { 0.0 } else { f64::NEG_INFINITY };
    let ci95 = match (certainty.interval, parameter.scale) {
        (Some(interval), Scale::Log) => {
            interval.map(|end| parameter.value(end.clamp(inner - FARTHEST, inner + FARTHEST)))
        }
        (Some(interval), Scale::Linear(_)) => interval.map(|end| parameter.value(end).max(floor)),
        (None, _) => parameter.bounds,
    };
    Estimate {
        name: parameter.name.to_owned(),
        nominal: parameter.nominal,
        estimate: parameter.value(inner),
        ci95,
        at_bound: parameter.is_at_bound(inner),
    }
}

/// The same causes with everything free of which something is expected, so that intervals count it
/// in; fitted to the last digit.
pub(super) fn widened<'c>(
    problem: &Problem<'_>,
    candidates: &'c [Candidate],
    fit: &Fit<'c>,
) -> Fit<'c> {
    let effects = fit
        .hypothesis
        .effects
        .iter()
        .map(|(candidate, inner)| match candidates.iter().find(|other| other.widens(candidate)) {
            None => (*candidate, inner.clone()),
            Some(wider) => {
                let own = |name: &str| candidate.parameters.iter().position(|p| p.name == name);
                let start = |p: &Parameter| match own(p.name) {
                    Some(at) => candidate.parameters[at].value(inner[at]),
                    None => p.starts.first().copied().unwrap_or(0.0),
                };
                (wider, wider.parameters.iter().map(|p| p.inner(start(p))).collect())
            }
        })
        .collect();
    problem.converged(Hypothesis { effects }).unwrap_or_else(|| fit.clone())
}

/// What a robot's file needs to hold, without parameters that the data do not inform.
pub(super) fn corrections(data: &Data, fit: &Fit<'_>) -> Vec<Correction> {
    let mut certainties = certainties(data, fit).into_iter();
    let mut corrections = fit.hypothesis.corrections();
    for ((candidate, _), correction) in fit.hypothesis.effects.iter().zip(&mut corrections) {
        let informed: Vec<bool> = candidate
            .parameters
            .iter()
            .zip(certainties.by_ref())
            .map(|(parameter, certainty)| {
                let expects_none =
                    parameter.expected.is_some_and(|[mean, _]| parameter.nominal == Some(mean));
                certainty.is_informed || !expects_none
            })
            .collect();
        // A correction that says nothing would be refused.
        let says_nothing = !informed.contains(&true);
        let mut informed = informed.into_iter();
        correction.parameters.retain(|_| informed.next().unwrap_or(true) || says_nothing);
        centred(correction, data);
        ascending(correction);
    }
    corrections
}

/// The three slopes of a gear with their torques in ascending order: the same law, as the slope
/// between the torques is the sum of the outer ones less that of the file.
fn ascending(correction: &mut Correction) {
    /// The law itself takes no spring to zero.
    const LEAST: f64 = 0.02;
    let names = ["torque_1_nm", "torque_2_nm"];
    let [Some(first), Some(second)] = names.map(|name| correction.value(name)) else { return };
    if first <= second {
        return;
    }
    let own = |name: &str| correction.value(name).unwrap_or(1.0);
    let [factor, below, above] = ["factor", "ratio_1", "ratio_3"].map(own);
    let between = (below + above - 1.0).max(LEAST);
    let values = [
        ("factor", factor * between),
        ("ratio_1", below / between),
        ("ratio_3", above / between),
        ("torque_1_nm", second),
        ("torque_2_nm", first),
    ];
    correction.parameters.retain(|(name, _)| values.iter().all(|(of, _)| of != name));
    let values = values.into_iter().map(|(name, value)| (name.to_owned(), value));
    correction.parameters.extend(values);
}

/// A choice with those of its causes alone that `keep` marks, fitted again; `None` if none is.
pub(super) fn only<'c>(
    problem: &Problem<'_>,
    choice: &Choice<'c>,
    keep: &[bool],
) -> Option<Choice<'c>> {
    let mut order: Vec<usize> = (0..keep.len()).filter(|&i| keep[i]).collect();
    let count = order.len();
    if count == 0 || count == keep.len() {
        return (count > 0).then(|| choice.clone());
    }
    order.extend((0..keep.len()).filter(|&i| !keep[i]));
    let mut hypothesis = choice.best.fit.hypothesis.clone();
    let mut kept = keep.iter();
    hypothesis.effects.retain(|_| kept.next().copied().unwrap_or(false));
    let mut chosen = choice.clone();
    chosen.best.fit = problem.optimise(hypothesis)?;
    // Alternatives have the other causes beside, in the same order.
    let alternatives = order[..count].iter().map(|&i| {
        let models = choice.alternatives[i].iter().filter(|m| m.causes() >= keep.len());
        models
            .map(|model| {
                let mut model = model.clone();
                let rest = keep.len()..model.causes();
                let whole: Vec<usize> = order.iter().copied().chain(rest).collect();
                model.fit.arrange(&whole);
                model
            })
            .collect()
    });
    chosen.alternatives = alternatives.collect();
    Some(chosen)
}

/// The places of one cause that count as one suspect, best first.
fn suspects(models: &[Model<'_>], i: usize, best: f64) -> Vec<Suspect> {
    let mut suspects: Vec<Suspect> = Vec::new();
    let mut add = |suspect: Suspect| {
        if !suspects.iter().any(|s| s.cause == suspect.cause && s.at == suspect.at) {
            suspects.push(suspect);
        }
    };
    for model in models {
        let Some((candidate, _)) = model.fit.hypothesis.effects.get(i) else { continue };
        let behind_bic = 2.0 * (best - model.log_evidence);
        add(Suspect { cause: candidate.cause, at: candidate.at.clone(), behind_bic });
    }
    suspects
}

/// Alternatives of the finding `i` within reach, and how many more there are than these.
fn group(choice: &Choice<'_>, i: usize, finding: &Candidate) -> (Vec<Suspect>, usize) {
    let others: Vec<&Candidate> =
        choice.best.fit.hypothesis.effects.iter().map(|(candidate, _)| *candidate).collect();
    let mut group: Vec<Suspect> = suspects(&choice.alternatives[i], i, choice.best.log_evidence)
        .into_iter()
        .filter(|s| s.behind_bic < 2.0 * ALTERNATIVE_WITHIN)
        .filter(|s| !others.iter().any(|o| o.cause == s.cause && o.at == s.at))
        .collect();
    let further = group.len().saturating_sub(MAX_ALTERNATIVES);
    group.truncate(MAX_ALTERNATIVES);
    // Other names of the same body come last.
    for name in &finding.also {
        if group.len() < MAX_ALTERNATIVES {
            group.push(Suspect { cause: finding.cause, at: Some(name.clone()), behind_bic: 0.0 });
        }
    }
    (group, further)
}

/// The forms of a suspect that are within reach, each with what it is behind the finding `i` in
/// BIC, best first.
fn forms_within_reach<'m, 'c>(
    choice: &'m Choice<'c>,
    i: usize,
    suspect: &Suspect,
) -> Vec<(&'m Model<'c>, f64)> {
    let mut forms: Vec<(&Model<'_>, f64)> = Vec::new();
    for model in &choice.alternatives[i] {
        let Some((form, _)) = model.fit.hypothesis.effects.get(i) else { continue };
        let behind = 2.0 * (choice.best.log_evidence - model.log_evidence);
        let is_seen = forms.iter().any(|(seen, _)| {
            let own = seen.fit.hypothesis.effects.get(i);
            own.is_some_and(|(own, _)| std::ptr::eq(*own, *form))
        });
        let is_its = form.cause == suspect.cause && form.at == suspect.at;
        if is_its && !is_seen && behind < 2.0 * ALTERNATIVE_WITHIN {
            forms.push((model, behind));
        }
    }
    forms
}

/// Causes one by one, each in its best form, best first.
pub(super) fn ranking(choice: &Choice<'_>) -> Vec<Suspect> {
    let best = choice.singles.first().map_or(0.0, |model| model.log_evidence);
    let mut ranking = suspects(&choice.singles, 0, best);
    ranking.truncate(12);
    ranking
}

pub(super) fn next(
    problem: &Problem<'_>,
    robot: &Robot,
    choice: &Choice<'_>,
) -> (Vec<NextPose>, Vec<NextTest>) {
    let (mut poses, mut tests) = (Vec::new(), Vec::new());
    for (i, (candidate, _)) in choice.best.fit.hypothesis.effects.iter().enumerate() {
        let own = label(candidate.cause, candidate.at.as_deref());
        for suspect in group(choice, i, candidate).0 {
            let forms = forms_within_reach(choice, i, &suspect);
            let Some(((model, behind), others)) = forms.split_first() else { continue };
            let found = poses_between(
                problem.description,
                robot,
                problem.data,
                &choice.best.fit,
                &model.fit,
                *behind,
            );
            // Where nothing is known of the parameters, nothing is known of poses.
            let Some(mut found) = found else { continue };
            // What stays possible in another form is not parted: a law of no slope says what a
            // plain spring does.
            let parts = |(form, behind): &(&Model<'_>, f64)| {
                part(problem, robot, &found, &choice.best.fit, &form.fit, *behind)
            };
            if !others.iter().all(parts) {
                found.clear();
            }
            if found.is_empty() {
                let separates = [own.clone(), suspect.label()];
                let mass =
                    mass_between(problem, robot, &choice.best.fit, &model.fit, suspect.behind_bic);
                let test = mass.unwrap_or_else(|| cause_text(candidate.cause).test.to_owned());
                tests.push(NextTest { separates, test });
            }
            for (joints, square) in found {
                poses.push(NextPose {
                    joints,
                    separates: [own.clone(), suspect.label()],
                    apart_sigmas: square.sqrt(),
                });
            }
        }
    }
    (poses, tests)
}

#[cfg(test)]
mod tests {
    use super::super::fit::tests::arm;
    use super::*;
    use crate::model::{Cause, Robot};
    use crate::modes::Modes;

    /// A fit may end with the torques in either order; a file with the second below the first is
    /// refused. The frequencies are those of the law as it was fitted.
    #[test]
    fn torques_in_order_are_the_same_law() {
        let fitted = [
            ("factor", 0.9),
            ("ratio_1", 0.7),
            ("ratio_3", 1.4),
            ("torque_1_nm", 120.0),
            ("torque_2_nm", 60.0),
        ];
        let mut correction = Correction {
            cause: Cause::LoadDependentStiffness,
            at: Some("j2".to_owned()),
            parameters: fitted.map(|(name, value)| (name.to_owned(), value)).to_vec(),
            hinge: None,
        };
        let with = |correction: &Correction| {
            let mut description = arm();
            description.corrections.push(correction.clone());
            description
        };
        assert!(Robot::new(&with(&correction)).is_err());
        let before = Robot::of(with(&correction)).unwrap();
        ascending(&mut correction);
        let after = Robot::new(&with(&correction)).unwrap();
        for i in 0..13 {
            let q = [0.0, 0.25 * f64::from(i), 0.3];
            let [a, b] = [&before, &after].map(|robot| Modes::at(robot, &q).unwrap());
            for (a, b) in a.natural_frequencies_hz.iter().zip(&b.natural_frequencies_hz) {
                assert!((a / b - 1.0).abs() < 1e-9, "{i}: {a} {b}");
            }
        }
    }
}
