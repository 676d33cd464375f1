//! Diagnoses of arms drawn at random with an effect hidden in the data: is it found, and nothing else?
//! The effects are put in by hand here, in laws of their own where the contract leaves them open.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop where they fail"
)]

mod hidden;

use std::collections::BTreeMap;

use detune::diagnosis::{Settings, Verdict, diagnose};
use hidden::{Case, EFFECTS, Truth, case};
use rayon::prelude::*;

/// How a case ended.
#[derive(Debug, Clone)]
struct Ended {
    case_label: String,
    named: usize,
    hidden: usize,
    first: String,
    verdict: Verdict,
    spurious: bool,
    heldout_over_noise: f64,
    covered: Option<bool>,
    group: usize,
}

fn run(case: &Case) -> Ended {
    let diagnosis =
        diagnose(&case.description, &case.table, Settings { seed: case.seed }, &|_| {}).unwrap();
    let mut named = 0;
    let mut covered = None;
    let mut used = vec![false; diagnosis.findings.len()];
    for truth in &case.truths {
        let is = |cause: &str, at: Option<&str>| {
            cause == truth.cause && (truth.at.is_empty() || at == Some(&truth.at))
        };
        let at = diagnosis.findings.iter().position(|f| {
            is(f.cause.name(), f.at.as_deref())
                || f.indistinguishable_from.iter().any(|s| is(s.cause.name(), s.at.as_deref()))
        });
        if let Some(at) = at {
            named += 1;
            used[at] = true;
            let finding = &diagnosis.findings[at];
            if is(finding.cause.name(), finding.at.as_deref())
                && let Some((name, value)) = &truth.parameter
                && let Some(p) = finding.parameters.iter().find(|p| p.name == *name)
            {
                let inside = p.ci95[0] <= *value && *value <= p.ci95[1];
                covered = Some(covered.unwrap_or(true) && inside);
            }
        }
    }
    let groups = diagnosis.findings.iter().map(|f| 1 + f.indistinguishable_from.len()).max();
    let first = diagnosis.findings.first().map_or_else(
        || "-".to_owned(),
        |f| format!("{} at {}", f.cause, f.at.as_deref().unwrap_or("-")),
    );
    let all: Vec<String> = diagnosis
        .findings
        .iter()
        .map(|f| {
            let rivals: Vec<String> = f
                .indistinguishable_from
                .iter()
                .map(|s| format!("{} ({:.1})", s.label(), s.behind))
                .collect();
            let p: Vec<String> = f
                .parameters
                .iter()
                .map(|p| {
                    format!("{} {:.4} [{:.4} {:.4}]", p.name, p.estimate, p.ci95[0], p.ci95[1])
                })
                .collect();
            format!("{} at {} {p:?} or {rivals:?}", f.cause, f.at.as_deref().unwrap_or("-"))
        })
        .collect();
    let bad = named < case.truths.len()
        || (case.truths.is_empty() && diagnosis.verdict != case.verdict())
        || used.iter().any(|u| !u);
    if bad {
        println!(
            "seed {} {} {} n={} noise {:.2}%: {:?} {all:?} before {:?} after {:?} floor {:.2} rank {:?}",
            case.seed,
            case.arm,
            case.label,
            case.table.rows.len(),
            100.0 * case.noise,
            diagnosis.verdict,
            diagnosis
                .structure_before
                .as_ref()
                .map(|s| format!("{:?} p {:.1e} {:.2}", s.shape, s.p_value, s.share)),
            diagnosis
                .structure_after
                .as_ref()
                .map(|s| format!("{:?} p {:.1e} {:.2}", s.shape, s.p_value, s.share)),
            diagnosis.noise_floor_percent,
            diagnosis
                .ranking
                .iter()
                .take(4)
                .map(|s| format!("{} {:.1}", s.label(), s.behind))
                .collect::<Vec<_>>(),
        );
    }
    Ended {
        case_label: case.label.clone(),
        named,
        hidden: case.truths.len(),
        first,
        verdict: diagnosis.verdict,
        spurious: used.iter().any(|u| !u),
        heldout_over_noise: diagnosis.extended.heldout_rms_percent / (100.0 * case.noise),
        covered,
        group: groups.unwrap_or(0),
    }
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

/// The confusion matrix over many cases: `CASES=20 FIRST=0 ONLY=payload cargo test --release --test
/// diagnose_blind confusion -- --ignored --nocapture`.
#[test]
#[ignore = "minutes; prints the confusion matrix"]
fn confusion() {
    let (cases, first) = (number("CASES", 10), number("FIRST", 0));
    let only = std::env::var("ONLY").unwrap_or_default();
    let started = std::time::Instant::now();
    let mut work = Vec::new();
    for &effect in EFFECTS.iter().filter(|e| only.is_empty() || only.split(',').any(|o| o == **e)) {
        for seed in first..first + cases {
            work.extend(case(effect, seed));
        }
    }
    let count = work.len();
    let ended: Vec<Ended> = work.par_iter().map(run).collect();
    let mut by: BTreeMap<String, Vec<Ended>> = BTreeMap::new();
    for end in ended {
        by.entry(end.case_label.clone()).or_default().push(end);
    }
    println!("{count} cases, {:.1} s each", started.elapsed().as_secs_f64() / count as f64);
    println!(
        "{:28} {:>5} {:>6} {:>6} {:>7} {:>7} {:>7} {:>7} {:>6}",
        "hidden", "cases", "all", "half", "spur.", "unexpl", "ho>1.25", "cover", "group"
    );
    for (label, ends) in &by {
        let n = ends.len() as f64;
        let share = |f: &dyn Fn(&&Ended) -> bool| 100.0 * ends.iter().filter(f).count() as f64 / n;
        let told: Vec<bool> = ends.iter().filter_map(|e| e.covered).collect();
        let mut firsts: BTreeMap<&str, usize> = BTreeMap::new();
        for end in ends {
            let cause = end.first.split(" at ").next().unwrap();
            *firsts.entry(cause).or_default() += 1;
        }
        println!(
            "{label:28} {:5} {:6.1} {:6.1} {:7.1} {:7.1} {:7.1} {:3}/{:3} {:6.1}  {firsts:?}",
            ends.len(),
            share(&|e| e.named == e.hidden && !(e.hidden == 0 && e.verdict == Verdict::Explained)),
            share(&|e| e.named > 0),
            share(&|e| e.spurious),
            share(&|e| e.verdict == Verdict::Unexplained),
            share(&|e| e.heldout_over_noise > 1.25),
            told.iter().filter(|t| **t).count(),
            told.len(),
            ends.iter().map(|e| e.group as f64).sum::<f64>() / n,
        );
    }
}

#[test]
fn truths_have_names_of_the_vocabulary() {
    for effect in EFFECTS {
        for Truth { cause, .. } in case(effect, 3).into_iter().flat_map(|c| c.truths) {
            assert!(detune::model::Cause::named(&cause).is_some(), "{cause}");
        }
    }
}
