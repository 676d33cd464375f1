//! A diagnosis as a page for people.

use std::fmt::Write;
use std::path::Path;

use super::words::{estimate, finding, name, position, structure, verdict};
use crate::diagnosis::{Diagnosis, NextPose, Verdict, words};

/// What is wrong, by how much, because of what, how sure, what else it could be, what it gained, what next.
pub fn diagnosis(d: &Diagnosis, robot: &str, table: &Path) -> String {
    let mut out = String::new();
    let title = match d.verdict {
        Verdict::Explained => "EXPLAINED",
        Verdict::Consistent => "CONSISTENT",
        Verdict::Unexplained => "UNEXPLAINED",
    };
    // Writing to a string does not fail.
    let _ = writeln!(
        out,
        "{title}  {robot} against {}: {} frequencies at {} poses\n",
        table.display(),
        d.residuals.len(),
        d.poses
    );
    let _ = writeln!(out, "{}\n", verdict(d));
    for (i, found) in d.findings.iter().enumerate() {
        let _ = writeln!(out, "{}. {}", i + 1, finding(found));
        for parameter in &found.parameters {
            let _ = writeln!(out, "     value     {}", estimate(parameter));
        }
        let chance = match found.evidence.p_value {
            p if p < 1e-12 => "below 1e-12".to_owned(),
            p => format!("{p:.1e}"),
        };
        let _ = writeln!(
            out,
            "     how sure  chance does as well with a probability of {chance}; BIC {:+.1}",
            found.evidence.delta_bic
        );
        let _ = writeln!(
            out,
            "     gain      the error would be {:.2} percentage points more without it",
            found.gain_percent_points
        );
        if found.indistinguishable_from.is_empty() {
            let _ = writeln!(out, "     or else   nothing: no other cause fits nearly as well");
        } else {
            let rivals: Vec<String> =
                found.indistinguishable_from.iter().map(|suspect| suspect.label()).collect();
            let _ = writeln!(out, "     or else   {}", rivals.join("; "));
            let _ = writeln!(
                out,
                "               these data cannot tell them apart; the intervals allow for that"
            );
        }
        let _ = writeln!(out, "     beware    easily mistaken for {}", words(found.cause).rivals);
    }
    if !d.findings.is_empty() {
        out.push('\n');
    }
    errors(d, &mut out);
    match (&d.structure_before, &d.structure_after, d.verdict) {
        (Some(before), _, Verdict::Unexplained) => {
            let _ = writeln!(out, "\nthe residual    {}", structure(before, d));
        }
        (before, after, _) => {
            if let Some(before) = before {
                let _ = writeln!(out, "\nbefore          {}", structure(before, d));
            }
            if let Some(after) = after {
                let _ = writeln!(out, "what is left    {}", structure(after, d));
            }
        }
    }
    if d.verdict == Verdict::Unexplained && !d.ranking.is_empty() {
        let nearest: Vec<String> = d.ranking.iter().take(3).map(|s| s.label()).collect();
        let _ = writeln!(out, "nearest causes  {} (none leaves mere noise)", nearest.join("; "));
    }
    next(d, &mut out);
    out
}

fn errors(d: &Diagnosis, out: &mut String) {
    let _ = writeln!(out, "error, %           model   with findings");
    let _ = writeln!(
        out,
        "  all modes     {:8.2}        {:8.2}",
        d.baseline.rms_percent, d.extended.rms_percent
    );
    let pairs = d.baseline.per_mode_rms_percent.iter().zip(&d.extended.per_mode_rms_percent);
    for (mode, (before, after)) in pairs.enumerate() {
        let _ = writeln!(out, "  mode {:<3}      {before:8.2}        {after:8.2}", mode + 1);
    }
    let _ = writeln!(
        out,
        "  poses left out{:8.2}        {:8.2}",
        d.baseline.heldout_rms_percent, d.extended.heldout_rms_percent
    );
    let _ = writeln!(out, "  noise         {:8.2}", d.noise_floor_percent);
    if d.verdict == Verdict::Explained {
        let [low, high] = d.gain.ci95;
        let _ = writeln!(
            out,
            "  gained at poses left out: {:.2} percentage points (95 % interval {low:.2} to {high:.2})",
            d.gain.percent_points
        );
    }
}

/// Poses that separate the same causes, with the least and the most that each adds.
struct Suggested<'d> {
    pairs: Vec<&'d [String; 2]>,
    poses: Vec<(&'d [f64], f64, f64)>,
}

/// Suggested poses, those together that separate the same.
fn suggested(d: &Diagnosis) -> Vec<Suggested<'_>> {
    let mut groups: Vec<Suggested<'_>> = Vec::new();
    let mut told: Vec<&[f64]> = Vec::new();
    for next in &d.next_poses {
        if told.contains(&next.joints.as_slice()) {
            continue;
        }
        told.push(&next.joints);
        let here: Vec<&NextPose> =
            d.next_poses.iter().filter(|other| other.joints == next.joints).collect();
        let pairs: Vec<&[String; 2]> = here.iter().map(|next| &next.separates).collect();
        let apart = |start: f64, by: fn(f64, f64) -> f64| {
            here.iter().map(|next| next.apart).fold(start, by)
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
    let mut told: Vec<(&str, Vec<&str>)> = Vec::new();
    for [one, other] in pairs {
        match told.iter_mut().find(|(known, _)| known == one) {
            Some((_, others)) => others.push(other),
            None => told.push((one, vec![other])),
        }
    }
    told.iter().map(|(one, others)| format!("{one} from {}", others.join(" or "))).collect()
}

fn next(d: &Diagnosis, out: &mut String) {
    let _ = writeln!(out, "\nnext");
    for Suggested { pairs, poses } in suggested(d) {
        for pair in separated(pairs.into_iter()) {
            let _ = writeln!(out, "  to tell {pair}");
        }
        let _ =
            writeln!(out, "    measure at, in this order (what each adds, in units of the noise)");
        for (pose, least, most) in poses {
            let joints: Vec<String> =
                pose.iter().zip(&d.joints).map(|(q, (_, slides))| position(*q, *slides)).collect();
            let [least, most] = [least, most].map(|apart| format!("{apart:.1}"));
            let apart = if least == most { most } else { format!("{least} to {most}") };
            let _ = writeln!(out, "      [{}]  {apart}", joints.join(", "));
        }
    }
    let mut tests: Vec<&'static str> = d.next_tests.iter().map(|next| next.test).collect();
    tests.dedup();
    for test in tests {
        let own = d.next_tests.iter().filter(|next| next.test == test);
        for pair in separated(own.map(|next| &next.separates)) {
            let _ = writeln!(out, "  no pose tells {pair}: {test}");
        }
    }
    let told_nothing = d.next_poses.is_empty() && d.next_tests.is_empty();
    let _ = match d.verdict {
        Verdict::Explained => {
            writeln!(
                out,
                "  --write ROBOT2.yaml puts the findings into a robot file that check uses"
            )
        }
        Verdict::Consistent => {
            writeln!(out, "  --write ROBOT2.yaml puts the calibration into the robot file")
        }
        Verdict::Unexplained if told_nothing => writeln!(
            out,
            "  repeat some poses at once and on another day, at another level and temperature, with these \
             columns in the table"
        ),
        Verdict::Unexplained => Ok(()),
    };
    if let Some(first) = d.findings.first() {
        let _ = writeln!(out, "  to make sure of {}: {}", name(first), words(first.cause).test);
    }
}
