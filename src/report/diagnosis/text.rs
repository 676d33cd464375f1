//! A diagnosis as a page for people.

use std::fmt::Write;

use super::words::{
    alternatives, estimate, finding, motion, notices, p_value, position, structure, symmetry,
    verdict,
};
use crate::diagnosis::{Diagnosis, Finding, LearnedDamping, NextPose, Verdict};
use crate::study::diagnose::Diagnosed;
use crate::units::percent_from_ratio;
use crate::wording::wrapped;

/// Verdict, findings with evidence and alternatives, errors, residual, what to measure next.
pub fn diagnosis(diagnosed: &Diagnosed) -> String {
    let d = &diagnosed.diagnosis;
    let mut out = String::new();
    let title = match d.verdict {
        Verdict::Explained => "EXPLAINED    ",
        Verdict::PartlyExplained => "PARTLY EXPLAINED  ",
        Verdict::Consistent => "CONSISTENT   ",
        Verdict::Unexplained => "UNEXPLAINED  ",
    };
    let about = format!(
        "{} against {}: {} frequencies at {} poses",
        diagnosed.robot,
        diagnosed.table.display(),
        d.residuals.len(),
        d.poses
    );
    wrapped(&mut out, title, &about);
    out.push('\n');
    wrapped(&mut out, "", &verdict(d));
    notices(diagnosed).for_each(|what| wrapped(&mut out, "", &format!("But {what}.")));
    out.push('\n');
    for (i, found) in d.findings.iter().enumerate() {
        one_finding(&mut out, i + 1, found);
    }
    if !d.findings.is_empty() {
        out.push('\n');
    }
    errors(d, &mut out);
    residual(d, &mut out);
    not_tested(d, &mut out);
    next(d, &mut out);
    out
}

fn one_finding(out: &mut String, number: usize, found: &Finding) {
    wrapped(out, &format!("{number}. "), &finding(found));
    for parameter in &found.parameters {
        wrapped(out, "     value         ", &estimate(parameter));
    }
    if let Some(motion) = motion(found) {
        wrapped(out, "     motion        ", &motion);
    }
    let evidence = format!(
        "p-value {}, ΔBIC {:+.1}",
        p_value(found.evidence.p_value),
        found.evidence.delta_bic
    );
    wrapped(out, "     evidence      ", &evidence);
    let gain = format!(
        "without it the error is {:.2} percentage points larger",
        found.gain_percent_points
    );
    wrapped(out, "     gain          ", &gain);
    let alternatives = alternatives(found).map_or_else(
        || "none: no other cause fits nearly as well".to_owned(),
        |all| format!("{all} (these data cannot separate them; the intervals include them)"),
    );
    wrapped(out, "     alternatives  ", &alternatives);
    let confounded = format!("often confounded with {}", found.text.confounded_with);
    wrapped(out, "     caution       ", &confounded);
}

fn errors(d: &Diagnosis, out: &mut String) {
    out.push_str("error, %           model   with findings\n");
    let mut row = |name: &str, before: f64, after: f64| {
        // Writing to a string does not fail.
        let _ = writeln!(out, "  {name:<14}{before:8.2}        {after:8.2}");
    };
    let (before, after) = (&d.baseline, &d.extended);
    row("all modes", before.rms_percent, after.rms_percent);
    let modes = before.per_mode_rms_percent.iter().zip(&after.per_mode_rms_percent);
    for (mode, (before, after)) in modes.enumerate() {
        row(&format!("mode {}", mode + 1), *before, *after);
    }
    row("held-out poses", before.heldout_rms_percent, after.heldout_rms_percent);
    row("model alone", before.model_error_percent, after.model_error_percent);
    let _ = writeln!(out, "  {:<14}{:8.2}", "noise floor", d.noise_floor_percent);
    if !d.findings.is_empty() && d.gain.percent_points != 0.0 {
        let [low, high] = d.gain.ci95;
        let _ = writeln!(
            out,
            "  gain at held-out poses: {:.2} percentage points (95 % interval {low:.2} to \
             {high:.2})",
            d.gain.percent_points
        );
    }
}

fn residual(d: &Diagnosis, out: &mut String) {
    let mirrors = d.symmetry.as_ref().and_then(symmetry);
    let has_structure = d.structure_before.is_some() || d.structure_after.is_some();
    if has_structure || mirrors.is_some() || !d.damping.is_empty() {
        out.push('\n');
    }
    let unexplained = d.verdict == Verdict::Unexplained;
    if let Some(before) = &d.structure_before {
        let head = if unexplained { "residual            " } else { "residual before     " };
        wrapped(out, head, &structure(before, d));
    }
    if let Some(after) = d.structure_after.as_ref().filter(|_| !unexplained) {
        wrapped(out, "remaining residual  ", &structure(after, d));
    }
    if let Some(mirrors) = mirrors {
        wrapped(out, "symmetry            ", &mirrors);
    }
    if !d.damping.is_empty() {
        let one = |own: &LearnedDamping| {
            let [zeta, std] = [own.damping_ratio, own.std].map(percent_from_ratio);
            format!("{} {zeta:.1} % ± {std:.1}", own.joint)
        };
        let own: Vec<String> = d.damping.iter().map(one).collect();
        wrapped(out, "damping             ", &own.join(", "));
    }
    if unexplained && !d.ranking.is_empty() {
        let nearest: Vec<String> = d.ranking.iter().take(3).map(|s| s.label()).collect();
        let nearest = format!("{} (each leaves more than noise)", nearest.join("; "));
        wrapped(out, "nearest causes      ", &nearest);
    }
    without_cause(d, out);
}

/// What a correction without a cause gains.
fn without_cause(d: &Diagnosis, out: &mut String) {
    let Some(found) = &d.without_cause else { return };
    let [low, high] = found.gain.ci95;
    let what = format!(
        "a Gaussian process of the residual over the joints takes the error at held-out poses from \
         {:.2} to {:.2} % (gain {:.2} percentage points, 95 % interval {low:.2} to {high:.2}). It \
         says nothing of why, holds among the poses of this table, and is not part of what --write \
         writes; --format json has its frequencies",
        d.baseline.heldout_rms_percent, found.heldout_rms_percent, found.gain.percent_points,
    );
    wrapped(out, "without a cause     ", &what);
}

fn not_tested(d: &Diagnosis, out: &mut String) {
    let mut groups: Vec<(&[String], Vec<String>)> = Vec::new();
    for untested in &d.untested {
        match groups.iter_mut().find(|(joints, _)| *joints == untested.joints) {
            Some((_, labels)) => labels.push(untested.label()),
            None => groups.push((&untested.joints, vec![untested.label()])),
        }
    }
    if !groups.is_empty() {
        out.push('\n');
    }
    for (joints, labels) in groups {
        let what = format!("{}: the table does not state {}", labels.join("; "), joints.join(", "));
        wrapped(out, "not tested          ", &what);
    }
}

/// Poses that separate the same causes, with the least and the most separation that each adds.
struct Suggested<'d> {
    pairs: Vec<&'d [String; 2]>,
    poses: Vec<(&'d [f64], f64, f64)>,
}

/// Suggested poses, those together that separate the same.
fn suggested(d: &Diagnosis) -> Vec<Suggested<'_>> {
    let mut groups: Vec<Suggested<'_>> = Vec::new();
    let mut known: Vec<&[f64]> = Vec::new();
    for next in &d.next_poses {
        if known.contains(&next.joints.as_slice()) {
            continue;
        }
        known.push(&next.joints);
        let here: Vec<&NextPose> =
            d.next_poses.iter().filter(|other| other.joints == next.joints).collect();
        let pairs: Vec<&[String; 2]> = here.iter().map(|next| &next.separates).collect();
        let apart = |start: f64, by: fn(f64, f64) -> f64| {
            here.iter().map(|next| next.apart_sigmas).fold(start, by)
        };
        let pose = (next.joints.as_slice(), apart(f64::INFINITY, f64::min), apart(0.0, f64::max));
        match groups.iter_mut().find(|group| group.pairs == pairs) {
            Some(group) => group.poses.push(pose),
            None => groups.push(Suggested { pairs, poses: vec![pose] }),
        }
    }
    groups
}

/// "payload at tool0 from link_inertia at link_2 or base_compliance at base_link", one a finding.
fn separated<'p>(pairs: impl Iterator<Item = &'p [String; 2]>) -> Vec<String> {
    let mut known: Vec<(&str, Vec<&str>)> = Vec::new();
    for [one, other] in pairs {
        match known.iter_mut().find(|(name, _)| name == one) {
            Some((_, others)) => others.push(other),
            None => known.push((one, vec![other])),
        }
    }
    known.iter().map(|(one, others)| format!("{one} from {}", others.join(" or "))).collect()
}

fn next(d: &Diagnosis, out: &mut String) {
    out.push_str("\nnext\n");
    for Suggested { pairs, poses } in suggested(d) {
        for pair in separated(pairs.into_iter()) {
            wrapped(out, "  to separate ", &format!("{pair},"));
        }
        out.push_str(
            "    measure these poses in this order (separation that each adds, standard \
             deviations)\n",
        );
        for (pose, low, high) in poses {
            let joints: Vec<String> =
                pose.iter().zip(&d.joints).map(|(q, (_, slides))| position(*q, *slides)).collect();
            let [low, high] = [low, high].map(|apart| format!("{apart:.1}"));
            let apart = if low == high { high } else { format!("{low} to {high}") };
            // Writing to a string does not fail.
            let _ = writeln!(out, "      [{}]  {apart}", joints.join(", "));
        }
    }
    let mut tests: Vec<&str> = d.next_tests.iter().map(|next| next.test.as_str()).collect();
    tests.dedup();
    for test in tests {
        let own = d.next_tests.iter().filter(|next| next.test == test);
        for pair in separated(own.map(|next| &next.separates)) {
            wrapped(out, "  no pose separates ", &format!("{pair}: {test}"));
        }
    }
    if let Some(first) = d.findings.first() {
        let test = format!("{}: {}", first.label(), first.text.test);
        wrapped(out, "  to confirm ", &test);
    }
    let suggests_nothing = d.next_poses.is_empty() && d.next_tests.is_empty();
    match d.verdict {
        Verdict::Explained | Verdict::PartlyExplained => {
            out.push_str(
                "  --write ROBOT2.yaml writes a robot file with these corrections for check\n",
            );
        }
        Verdict::Consistent => {
            out.push_str(
                "  --write ROBOT2.yaml writes a robot file with the calibration for check\n",
            );
        }
        Verdict::Unexplained if suggests_nothing => wrapped(
            out,
            "  ",
            "repeat some poses immediately and again on another day, at another excitation level \
             and temperature, with these columns in the table",
        ),
        Verdict::Unexplained => {}
    }
}
