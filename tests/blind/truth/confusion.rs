//! Many scores as Markdown tables.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::case::{Case, Scenario, Strength};
use super::score::{LARGEST_GROUP, MAX_HELD_OUT, Met, Score};

/// Scores by what was hidden.
#[derive(Default)]
pub(crate) struct Confusion {
    rows: BTreeMap<(String, String), Row>,
    whole: Row,
    /// Hidden cause → named first instead → times.
    instead: BTreeMap<String, BTreeMap<String, usize>>,
    failures: Vec<String>,
    unjudged: usize,
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
        let within = self.held_out.iter().filter(|x| **x <= MAX_HELD_OUT).count();
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
        self.unjudged += 1;
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

    /// What falls short of `bar`, in words. Few cases cannot show a rate: one miss is always allowed.
    pub(crate) fn shortfalls(&self, bar: &Bar) -> Vec<String> {
        let row = &self.whole;
        let cases = row.cases + self.unjudged;
        let within = row.held_out.iter().filter(|x| **x <= MAX_HELD_OUT).count();
        let clean = row.cases - row.spurious;
        let asked = [
            ("all causes named, groups of at most four", row.all_right, cases, bar.named),
            ("the verdict", row.verdict_right, cases, bar.verdict),
            ("no spurious finding", clean, cases, bar.clean),
            ("a gain on poses left out", row.gained, cases, bar.gained),
            ("held-out error at most 1.25 of the noise", within, cases, bar.held_out),
            ("intervals that hold the truth", row.covered, row.intervals, bar.covered),
            ("groups split by the suggested poses", row.split, row.splittable, bar.split),
        ];
        let mut short = Vec::new();
        for (what, right, of, share) in asked {
            let Some(share) = share else { continue };
            let allowed = ((1.0 - share) * of as f64).max(1.0);
            if (of - right) as f64 > allowed {
                short.push(format!("{what}: {right} of {of}, asked are {:.0} %", 100.0 * share));
            }
        }
        // Intervals that always hold are too wide; that takes many to see.
        if bar.covered.is_some() && row.intervals >= 300 && row.covered * 100 > 99 * row.intervals {
            short.push(format!("intervals too wide: {} of {}", row.covered, row.intervals));
        }
        if self.unjudged > 0 {
            short.push(format!("no answer: {} of {cases}", self.unjudged));
        }
        short
    }
}

/// Shares that are asked for; `None` where nothing is.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Bar {
    pub(crate) named: Option<f64>,
    pub(crate) verdict: Option<f64>,
    pub(crate) clean: Option<f64>,
    pub(crate) gained: Option<f64>,
    pub(crate) held_out: Option<f64>,
    pub(crate) covered: Option<f64>,
    pub(crate) split: Option<f64>,
}
