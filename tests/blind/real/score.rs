//! What was said against what was hidden.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Instant;

use serde_json::Value;

use super::kinds::{Case, Hidden};
use crate::truth::run::{detune, map, map_columns};

#[derive(Debug, Clone, Default)]
pub(super) struct Score {
    pub(super) verdict: String,
    pub(super) findings: Vec<String>,
    /// Finding or its group names a hidden cause.
    first: bool,
    named: bool,
    spurious: usize,
    pub(super) held_out_over_noise: f64,
    /// Error of the written robot at fresh poses over the noise of the table.
    fresh_over_noise: f64,
    /// Fresh frequencies within twice the held-out error, of how many.
    covered: [usize; 2],
    /// Fresh frequencies within their 95 % intervals, of how many, by mode.
    pub(super) predicted: Vec<[usize; 2]>,
    /// The same of what the table's instrument would show there.
    measured: Vec<[usize; 2]>,
    /// Parameters of the hidden cause within their 95 % intervals, of how many.
    parameters: [usize; 2],
    suspects: Vec<u64>,
    seconds: f64,
}

fn is(hidden: &Hidden, suspect: &Value) -> bool {
    let at = suspect["at"].as_str().unwrap_or("");
    suspect["cause"] == hidden.cause && hidden.at.iter().any(|name| name == at)
}

fn meets(hidden: &[Hidden], finding: &Value) -> bool {
    let group = finding["indistinguishable_from"].as_array().unwrap();
    hidden.iter().any(|hidden| {
        is(hidden, finding) || group.len() < 4 && group.iter().any(|suspect| is(hidden, suspect))
    })
}

pub(super) fn judge(case: &Case, folder: &Path) -> Result<Score, String> {
    case.write(folder);
    let arguments = [
        "diagnose",
        "robot.yaml",
        "measured.csv",
        "--format",
        "json",
        "--seed",
        "1",
        "--write",
        "calibrated.yaml",
    ];
    let start = Instant::now();
    let text = detune(folder, &arguments, "diagnosis.json")?;
    let seconds = start.elapsed().as_secs_f64();
    let json: Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let findings = json["findings"].as_array().unwrap();
    let label = |finding: &Value| {
        let at = finding["at"].as_str().unwrap_or("");
        let parameters: Vec<String> = finding["parameters"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| format!("{}={:.4}", p["name"].as_str().unwrap(), p["estimate"]))
            .collect();
        format!("{} at {at} ({})", finding["cause"].as_str().unwrap(), parameters.join(" "))
    };
    let held_out = json["extended"]["heldout_rms_percent"].as_f64().unwrap() / 100.0;
    // The written robot at fresh poses.
    fs::rename(folder.join("robot.yaml"), folder.join("original.yaml")).unwrap();
    fs::copy(folder.join("calibrated.yaml"), folder.join("robot.yaml")).unwrap();
    let poses: Vec<Vec<f64>> = case.fresh.iter().map(|row| row.joints_rad.clone()).collect();
    let predicted = map(folder, &case.nominal, &poses);
    let is_end = |name: &str| name.ends_with("_lo95_hz") || name.ends_with("_hi95_hz");
    let arguments = ["robot.yaml", "--intervals"];
    let intervals = map_columns(folder, &arguments, &case.nominal, &poses, &is_end);
    fs::rename(folder.join("original.yaml"), folder.join("robot.yaml")).unwrap();
    let mut errors = Vec::new();
    let mut covered = [0, 0];
    let mut within = vec![[0, 0]; case.modes];
    let mut measured = within.clone();
    for (i, (predicted, ends)) in predicted.iter().zip(&intervals).enumerate() {
        let seen = case.real.frequencies_hz(&case.fresh[i], case.modes);
        for (mode, (seen, f)) in seen.iter().zip(predicted).enumerate() {
            let error = f / seen - 1.0;
            errors.push(error);
            covered[0] += usize::from(error.abs() < 2.0 * held_out);
            covered[1] += 1;
            let holds = (ends[2 * mode]..ends[2 * mode + 1]).contains(seen);
            within[mode][0] += usize::from(holds);
            within[mode][1] += 1;
            if let Some(hz) = case.fresh_measured_hz[i][mode] {
                let holds = (ends[2 * mode]..ends[2 * mode + 1]).contains(&hz);
                measured[mode][0] += usize::from(holds);
                measured[mode][1] += 1;
            }
        }
    }
    Ok(Score {
        verdict: json["verdict"].as_str().unwrap().to_owned(),
        findings: findings.iter().map(label).collect(),
        first: findings.first().is_some_and(|first| meets(&case.hidden, first)),
        named: findings.iter().any(|finding| meets(&case.hidden, finding)),
        spurious: findings.iter().filter(|finding| !meets(&case.hidden, finding)).count(),
        held_out_over_noise: held_out / case.noise,
        fresh_over_noise: crate::truth::case::rms(&errors) / case.noise,
        covered,
        predicted: within,
        measured,
        parameters: parameters(case, findings),
        suspects: json["suspect_rows"]
            .as_array()
            .map_or_else(Vec::new, |rows| rows.iter().filter_map(Value::as_u64).collect()),
        seconds,
    })
}

/// The narrowest interval, ln of its ends' ratio, of the first mode that nobody measured, over the fresh poses, behind
/// [`judge`]; and at how many of these the truth lies within.
pub(super) fn above_the_measured(case: &Case, folder: &Path) -> (f64, usize) {
    let poses: Vec<Vec<f64>> = case.fresh.iter().map(|row| row.joints_rad.clone()).collect();
    let is_end = |name: &str| name.ends_with("_lo95_hz") || name.ends_with("_hi95_hz");
    let arguments = ["calibrated.yaml", "--intervals"];
    let intervals = map_columns(folder, &arguments, &case.nominal, &poses, &is_end);
    let next = case.modes;
    let ends = |of: &Vec<f64>| [of[2 * next], of[2 * next + 1]];
    let width = |of: &Vec<f64>| (ends(of)[1] / ends(of)[0]).ln();
    let holds = |(of, row): &(&Vec<f64>, &_)| {
        let seen = case.real.frequencies_hz(row, next + 1)[next];
        (ends(of)[0]..ends(of)[1]).contains(&seen)
    };
    let narrowest = intervals.iter().map(width).fold(f64::INFINITY, f64::min);
    (narrowest, intervals.iter().zip(&case.fresh).filter(holds).count())
}

/// How many parameters of the hidden cause lie within the intervals of its finding, of how many.
fn parameters(case: &Case, findings: &[Value]) -> [usize; 2] {
    let own = findings.iter().filter(|finding| case.hidden.iter().any(|h| is(h, finding)));
    let mut counts = [0, 0];
    for finding in own {
        let found = finding["parameters"].as_array().unwrap();
        let names: Vec<&str> = found.iter().map(|p| p["name"].as_str().unwrap()).collect();
        for (name, value) in case.parameters(&names) {
            let Some(i) = names.iter().position(|own| *own == name) else { continue };
            let end = |k: usize| found[i]["ci95"][k].as_f64().unwrap();
            counts[0] += usize::from((end(0)..=end(1)).contains(&value));
            counts[1] += 1;
        }
    }
    counts
}

/// Of all modes together.
fn pooled(by_mode: &[[usize; 2]]) -> [usize; 2] {
    [0, 1].map(|k| by_mode.iter().map(|own| own[k]).sum())
}

/// Counts over all cases.
#[derive(Debug, Default)]
pub(super) struct Total {
    hidden: [usize; 5],
    calm: [usize; 3],
    typos: [usize; 2],
    wrong_suspects: usize,
    covered: [usize; 2],
    predicted: Vec<[usize; 2]>,
    measured: Vec<[usize; 2]>,
    parameters: [usize; 2],
    seconds: f64,
    longest: f64,
    by_kind: BTreeMap<&'static str, [usize; 4]>,
}

impl Total {
    /// Adds a case; what to say of it.
    pub(super) fn add(&mut self, case: &Case, score: &Score) -> String {
        let kind = self.by_kind.entry(case.kind).or_default();
        let good = if case.hidden.is_empty() {
            self.calm[0] += 1;
            self.calm[1] += usize::from(score.findings.is_empty());
            self.calm[2] += usize::from(score.verdict == "consistent");
            score.verdict == "consistent"
        } else {
            self.hidden[0] += 1;
            self.hidden[1] += usize::from(score.first);
            self.hidden[2] += usize::from(score.named);
            self.hidden[3] += usize::from(score.spurious > 0);
            self.hidden[4] += usize::from(score.held_out_over_noise <= 1.25);
            score.first && score.spurious == 0
        };
        kind[0] += 1;
        kind[1] += usize::from(good);
        kind[2] += usize::from(score.spurious > 0);
        kind[3] += usize::from(score.held_out_over_noise <= 1.25);
        match &case.typo {
            Some((row, _)) => {
                self.typos[0] += 1;
                self.typos[1] += usize::from(score.suspects == [*row as u64]);
            }
            None => self.wrong_suspects += usize::from(!score.suspects.is_empty()),
        }
        self.covered[0] += score.covered[0];
        self.covered[1] += score.covered[1];
        for (sums, own) in
            [(&mut self.predicted, &score.predicted), (&mut self.measured, &score.measured)]
        {
            sums.resize(sums.len().max(own.len()), [0, 0]);
            for (sum, own) in sums.iter_mut().zip(own) {
                (0..2).for_each(|k| sum[k] += own[k]);
            }
        }
        (0..2).for_each(|k| self.parameters[k] += score.parameters[k]);
        self.seconds += score.seconds;
        self.longest = self.longest.max(score.seconds);
        let [predicted, measured] = [&score.predicted, &score.measured].map(|own| pooled(own));
        format!(
            "{:<24} {} {:<16} held-out {:.2} fresh {:.2} of noise {:.2} %, \
             parameters {:?} predicted {predicted:?} {measured:?}, {:.0} s {:?} {}",
            case.name,
            if good { "ok  " } else { "WRONG" },
            score.verdict,
            score.held_out_over_noise,
            score.fresh_over_noise,
            100.0 * case.noise,
            score.parameters,
            score.seconds,
            score.suspects,
            score.findings.join("; ")
        )
    }

    /// What is asked for and was not reached.
    pub(super) fn shortfalls(&self) -> Vec<String> {
        let [all, first, _, spurious, _] = self.hidden.map(|count| count as f64);
        let [calm, none, consistent] = self.calm.map(|count| count as f64);
        let asked = [
            ("first finding right", first >= 0.9 * all),
            ("no spurious finding", spurious <= 0.05 * all),
            ("no cause where none is", none >= 0.95 * calm),
            ("consistent where nothing is", consistent >= 0.9 * calm),
        ];
        asked.iter().filter(|(_, held)| !held).map(|(what, _)| (*what).to_owned()).collect()
    }

    pub(super) fn summary(&self, cases: &[Case]) -> String {
        let share = |of: usize, all: usize| {
            format!("{:.0} % ({of}/{all})", 100.0 * of as f64 / all.max(1) as f64)
        };
        let [all, first, named, spurious, held_out] = self.hidden;
        let [calm, none, consistent] = self.calm;
        let by_mode = |counts: &[[usize; 2]]| {
            let modes = counts.iter().enumerate();
            let modes = modes
                .map(|(mode, [held, all])| format!("mode {}: {}", mode + 1, share(*held, *all)));
            let [held, all] = pooled(counts);
            format!("{} ({})", share(held, all), modes.collect::<Vec<_>>().join(", "))
        };
        let mut text = format!(
            "{} cases\nfirst finding right {}\nnamed anywhere {}\nspurious {}\nheld-out within 1.25 of noise {}\n\
             calm: no cause {}, consistent {}\ntypos named {}, wrong suspects {}\n\
             fresh within twice held-out {}\nparameters within their intervals {}\n\
             fresh within their intervals {}\nas measured {}\nseconds {:.0}, longest {:.0}\n",
            cases.len(),
            share(first, all),
            share(named, all),
            share(spurious, all),
            share(held_out, all),
            share(none, calm),
            share(consistent, calm),
            share(self.typos[1], self.typos[0]),
            self.wrong_suspects,
            share(self.covered[0], self.covered[1]),
            share(self.parameters[0], self.parameters[1]),
            by_mode(&self.predicted),
            by_mode(&self.measured),
            self.seconds,
            self.longest
        );
        for (kind, [all, good, spurious, held_out]) in &self.by_kind {
            text += &format!(
                "  {kind:<16} good {good}/{all}, spurious {spurious}, held-out {held_out}\n"
            );
        }
        text
    }
}
