//! Many scores as Markdown tables.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::case::{Case, Scenario, Strength};
use super::score::{LARGEST_GROUP, MOST_HELD_OUT, Met, Score};

/// Scores by what was hidden.
#[derive(Default)]
pub(crate) struct Confusion {
    rows: BTreeMap<(String, String), Row>,
    whole: Row,
    /// Hidden cause → named first instead → times.
    instead: BTreeMap<String, BTreeMap<String, usize>>,
    failures: Vec<String>,
}

/// Counts over some cases.
#[derive(Default, Clone)]
struct Row {
    cases: usize,
    effects: usize,
    found: usize,
    in_group: usize,
    missed: usize,
    large_groups: usize,
    all_right: usize,
    spurious: usize,
    verdict_right: usize,
    gained: usize,
    held_out: Vec<f64>,
    intervals: usize,
    covered: usize,
    splittable: usize,
    split: usize,
}

impl Row {
    fn add(&mut self, case: &Case, score: &Score) {
        self.cases += 1;
        self.effects += score.answers.len();
        for answer in &score.answers {
            match answer.met {
                Met::Found => self.found += 1,
                Met::InGroup => self.in_group += 1,
                Met::Missed => self.missed += 1,
            }
            self.large_groups += usize::from(answer.group > LARGEST_GROUP);
            self.intervals += answer.covered.len();
            self.covered += answer.covered.iter().filter(|yes| **yes).count();
        }
        self.all_right += usize::from(score.is_right());
        self.spurious += usize::from(!score.spurious.is_empty());
        self.gained += usize::from(score.gained);
        let wanted = match case.order.scenario {
            Scenario::Nothing => "consistent",
            Scenario::Beyond(_) => "unexplained",
            Scenario::Single(_) | Scenario::Several(_) => "explained",
        };
        self.verdict_right += usize::from(score.verdict == wanted);
        self.held_out.push(score.held_out_over_noise);
        if let Some(split) = score.split {
            self.splittable += 1;
            self.split += usize::from(split);
        }
    }

    fn line(&self) -> String {
        let within = self.held_out.iter().filter(|x| **x <= MOST_HELD_OUT).count();
        format!(
            "{} | {} | {} | {} | {} | {} | {} | {} | {} | {}",
            self.cases,
            share(self.found, self.effects),
            share(self.in_group, self.effects),
            share(self.missed, self.effects),
            share(self.all_right, self.cases),
            share(self.verdict_right, self.cases),
            share(self.spurious, self.cases),
            share(self.covered, self.intervals),
            share(within, self.cases),
            share(self.split, self.splittable),
        )
    }
}

fn share(part: usize, whole: usize) -> String {
    if whole == 0 {
        return "–".to_owned();
    }
    format!("{:.0} % ({part}/{whole})", 100.0 * part as f64 / whole as f64)
}

impl Confusion {
    pub(crate) fn add(&mut self, case: &Case, score: &Score) {
        let strength = if case.order.strength == Strength::Weak { " (2–4 ×)" } else { "" };
        let key = (
            format!("{}{strength}", case.order.scenario.name()),
            case.order.family.name().to_owned(),
        );
        self.rows.entry(key).or_default().add(case, score);
        self.whole.add(case, score);
        let named = score.first.as_ref().map_or(score.verdict.as_str(), |named| &named.cause);
        for (part, answer) in case.hidden.iter().zip(&score.answers) {
            if answer.met != Met::Found {
                let row = self.instead.entry(part.effect.cause.to_owned()).or_default();
                *row.entry(named.to_owned()).or_default() += 1;
            }
        }
        if case.hidden.is_empty() && score.first.is_some() {
            let row = self.instead.entry("nothing".to_owned()).or_default();
            *row.entry(named.to_owned()).or_default() += 1;
        }
        let faults = score.faults(case);
        if !faults.is_empty() {
            self.failures.push(format!("{}: {}", case.name(), faults.join("; ")));
        }
    }

    /// A case that could not be judged.
    pub(crate) fn add_failure(&mut self, case: &Case, fault: &str) {
        self.failures.push(format!("{}: {fault}", case.name()));
    }

    pub(crate) fn markdown(&self) -> String {
        let mut text = String::from(
            "| hidden | arm | cases | found | in its group | missed | all named, groups ≤ 4 | verdict \
             right | spurious finding | interval holds | held-out ≤ 1.25 noise | group split |\n\
             |---|---|---|---|---|---|---|---|---|---|---|---|\n",
        );
        for ((hidden, arm), row) in &self.rows {
            let _ = writeln!(text, "| {hidden} | {arm} | {} |", row.line());
        }
        let _ = writeln!(text, "| all | | {} |", self.whole.line());
        text += "\n| hidden, not the finding | named first |\n|---|---|\n";
        for (hidden, instead) in &self.instead {
            let named: Vec<String> =
                instead.iter().map(|(cause, times)| format!("{cause} {times}")).collect();
            let _ = writeln!(text, "| {hidden} | {} |", named.join(", "));
        }
        text
    }

    /// One line a case that lacks something.
    pub(crate) fn failures(&self) -> &[String] {
        &self.failures
    }

    /// Parameters compared with the truth, and those whose interval holds it.
    pub(crate) fn coverage(&self) -> (usize, usize) {
        (self.whole.intervals, self.whole.covered)
    }
}
