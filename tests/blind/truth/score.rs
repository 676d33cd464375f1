//! What a diagnosis said against what was hidden.

use serde_json::Value;

use super::case::{Case, Hidden, Scenario};
use super::effects::{BEYOND, Known};

/// Largest group that still says something.
pub(crate) const LARGEST_GROUP: usize = 4;

/// Held-out error over noise that an extended model may have.
pub(crate) const MAX_HELD_OUT: f64 = 1.25;

/// A cause at a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Named {
    pub(crate) cause: String,
    pub(crate) at: String,
}

impl Named {
    /// As diagnoses write it where they say what poses separate.
    pub(crate) fn label(&self) -> String {
        if self.at.is_empty() {
            self.cause.clone()
        } else {
            format!("{} at {}", self.cause, self.at)
        }
    }
}

/// A pose that is suggested, and what it is to separate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NextPose {
    pub(crate) joints: Vec<f64>,
    pub(crate) separates: [String; 2],
}

/// An estimate with its interval.
#[derive(Debug, Clone)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    pub(crate) nominal: f64,
    pub(crate) ci95: [f64; 2],
}

/// A finding as read.
#[derive(Debug, Clone)]
pub(crate) struct Finding {
    pub(crate) named: Named,
    pub(crate) group: Vec<Named>,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) gain_percent_points: f64,
}

/// A diagnosis as read.
#[derive(Debug, Clone)]
pub(crate) struct Diagnosis {
    pub(crate) verdict: String,
    pub(crate) findings: Vec<Finding>,
    pub(crate) baseline_held_out_percent: f64,
    pub(crate) extended_held_out_percent: f64,
    pub(crate) noise_floor_percent: f64,
    /// Suggested poses, rad.
    pub(crate) next_poses: Vec<NextPose>,
}

/// How a hidden effect was met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Met {
    /// The finding itself.
    Found,
    /// In a finding's group.
    InGroup,
    Missed,
}

/// One hidden effect against a diagnosis.
#[derive(Debug, Clone)]
pub(crate) struct Answer {
    pub(crate) met: Met,
    /// The finding's group with the finding itself; 0 where missed.
    pub(crate) group: usize,
    /// By comparable parameter: whether its interval holds the truth.
    pub(crate) covered: Vec<bool>,
    /// Position of the finding that met it.
    pub(crate) finding: Option<usize>,
}

/// A whole case against a diagnosis.
#[derive(Debug, Clone)]
pub(crate) struct Score {
    pub(crate) verdict: String,
    pub(crate) answers: Vec<Answer>,
    /// Findings that meet no hidden effect.
    pub(crate) spurious: Vec<Named>,
    /// What was named first.
    pub(crate) first: Option<Named>,
    /// Every finding's gain is positive, and the held-out error shrank.
    pub(crate) gained: bool,
    /// Held-out error after extension over what noise and rounding made of this table, or were to make if that is more.
    pub(crate) held_out_over_noise: f64,
    pub(crate) split: Option<bool>,
}

impl Diagnosis {
    /// Reads the JSON of the contract; says what is missing.
    pub(crate) fn read(json: &Value) -> Result<Self, String> {
        let text = |v: &Value, key: &str| {
            v[key].as_str().map(str::to_owned).ok_or(format!("'{key}' is no text: {}", v[key]))
        };
        let number = |v: &Value, key: &str| {
            v[key].as_f64().ok_or(format!("'{key}' is no number: {}", v[key]))
        };
        let list = |v: &Value, key: &str| {
            v[key].as_array().cloned().ok_or(format!("'{key}' is no list: {}", v[key]))
        };
        let named = |v: &Value| -> Result<Named, String> {
            Ok(Named { cause: text(v, "cause")?, at: place(&v["at"]) })
        };
        if json["schema"] != "diagnosis/1" {
            return Err(format!("schema is {}", json["schema"]));
        }
        let verdict = text(json, "verdict")?;
        if !["explained", "partly_explained", "consistent", "unexplained"]
            .contains(&verdict.as_str())
        {
            return Err(format!("verdict is {verdict}"));
        }
        let mut findings = Vec::new();
        for finding in list(json, "findings")? {
            let mut parameters = Vec::new();
            for p in list(&finding, "parameters")? {
                let ci = list(&p, "ci95")?;
                let end = |i: usize| ci.get(i).and_then(Value::as_f64).unwrap_or(f64::NAN);
                parameters.push(Parameter {
                    name: text(&p, "name")?,
                    nominal: p["nominal"].as_f64().unwrap_or(f64::NAN),
                    ci95: [end(0), end(1)],
                });
            }
            let rivals = list(&finding, "indistinguishable_from")?;
            findings.push(Finding {
                named: named(&finding)?,
                group: rivals.iter().map(named).collect::<Result<_, _>>()?,
                parameters,
                gain_percent_points: number(&finding, "gain_percent_points")?,
            });
        }
        let poses = list(json, "next_poses")?;
        let next_pose = |v: &Value| -> Option<NextPose> {
            let label = |i: usize| v["separates"][i].as_str().map(str::to_owned);
            Some(NextPose {
                joints: v["joints_rad"]
                    .as_array()?
                    .iter()
                    .map(Value::as_f64)
                    .collect::<Option<_>>()?,
                separates: [label(0)?, label(1)?],
            })
        };
        Ok(Self {
            verdict,
            findings,
            baseline_held_out_percent: number(&json["baseline"], "heldout_rms_percent")?,
            extended_held_out_percent: number(&json["extended"], "heldout_rms_percent")?,
            noise_floor_percent: number(json, "noise_floor_percent")?,
            next_poses: poses.iter().filter_map(next_pose).collect(),
        })
    }
}

/// `at` as text: a name, a number, or nothing.
fn place(at: &Value) -> String {
    match at {
        Value::String(text) => text.clone(),
        Value::Null => String::new(),
        other => other.to_string(),
    }
}

/// Whether a named cause is a hidden effect. Modes go by their number, whatever surrounds it.
pub(crate) fn is(named: &Named, hidden: &Hidden) -> bool {
    let effect = &hidden.effect;
    if named.cause != effect.cause {
        return false;
    }
    match effect.cause {
        "gravity_stiffness" => true,
        "aliased_mode" | "missed_mode" => {
            let digits: String = named.at.chars().filter(char::is_ascii_digit).collect();
            effect.at[0] == digits
        }
        _ => effect.at.contains(&named.at),
    }
}

/// Whether each comparable parameter's interval holds the truth.
fn covered(finding: &Finding, known: &[Known]) -> Vec<bool> {
    let mut covered = Vec::new();
    for parameter in &finding.parameters {
        let fits = |k: &&Known| {
            let distance = (parameter.nominal - k.nominal).abs();
            parameter.name.ends_with(k.ending)
                // An elastic coordinate that the model lacks has no nominal stiffness worth comparing.
                && (!k.nominal.is_finite() || distance <= 1e-4 * k.nominal.abs() + 1e-9)
        };
        if let Some(truth) = known.iter().find(fits) {
            let [low, high] = parameter.ci95;
            covered.push(low <= truth.value && truth.value <= high);
        }
    }
    covered
}

/// Which finding meets each hidden effect: the one that is it; else one whose group holds it, and rather one that
/// meets no other.
fn answers(hidden: &[&Hidden], diagnosis: &Diagnosis) -> Vec<Answer> {
    let findings = &diagnosis.findings;
    let mut met: Vec<Option<(Met, usize)>> = hidden
        .iter()
        .map(|part| Some((Met::Found, findings.iter().position(|f| is(&f.named, part))?)))
        .collect();
    for (k, part) in hidden.iter().enumerate() {
        if met[k].is_some() {
            continue;
        }
        let holding: Vec<usize> = (0..findings.len())
            .filter(|&i| findings[i].group.iter().any(|named| is(named, part)))
            .collect();
        let is_free = |i: &&usize| !met.iter().flatten().any(|(_, other)| other == *i);
        let chosen = holding.iter().find(is_free).or(holding.first());
        met[k] = chosen.map(|&i| (Met::InGroup, i));
    }
    let answer = |(part, met): (&&Hidden, Option<(Met, usize)>)| match met {
        Some((met, i)) => Answer {
            met,
            group: 1 + findings[i].group.len(),
            covered: match met {
                Met::Found => covered(&findings[i], &part.known),
                Met::InGroup | Met::Missed => Vec::new(),
            },
            finding: Some(i),
        },
        None => Answer { met: Met::Missed, group: 0, covered: Vec::new(), finding: None },
    };
    hidden.iter().zip(met).map(answer).collect()
}

impl Score {
    pub(crate) fn of(case: &Case, diagnosis: &Diagnosis) -> Self {
        // What lies beyond the vocabulary cannot be named.
        let nameable = case.hidden.iter().filter(|part| !BEYOND.contains(&part.effect.cause));
        let answers = answers(&nameable.collect::<Vec<_>>(), diagnosis);
        let met: Vec<usize> = answers.iter().filter_map(|answer| answer.finding).collect();
        let findings = &diagnosis.findings;
        let gained = findings.iter().all(|finding| finding.gain_percent_points > 0.0)
            && (findings.is_empty()
                || diagnosis.extended_held_out_percent < diagnosis.baseline_held_out_percent);
        Self {
            verdict: diagnosis.verdict.clone(),
            spurious: findings
                .iter()
                .enumerate()
                .filter(|(i, _)| !met.contains(i))
                .map(|(_, finding)| finding.named.clone())
                .collect(),
            first: findings.first().map(|finding| finding.named.clone()),
            gained,
            held_out_over_noise: diagnosis.extended_held_out_percent / 100.0 / case.noise_to_beat(),
            answers,
            split: None,
        }
    }

    /// What a case asks for and this score lacks; the interval is judged over many cases.
    pub(crate) fn faults(&self, case: &Case) -> Vec<String> {
        let mut faults = Vec::new();
        let wanted = match case.order.scenario {
            Scenario::Nothing => "consistent",
            Scenario::Beyond(_) => "unexplained",
            Scenario::Single(_) | Scenario::Several(_) => "explained",
        };
        if self.verdict != wanted {
            faults.push(format!("verdict is {}, not {wanted}", self.verdict));
        }
        if case.is_beyond() {
            return faults;
        }
        for (part, answer) in case.hidden.iter().zip(&self.answers) {
            let name = format!("{} at {}", part.effect.cause, part.effect.at[0]);
            if answer.met == Met::Missed {
                faults.push(format!("{name} was missed"));
            } else if answer.group > LARGEST_GROUP {
                faults.push(format!("{name} is in a group of {}", answer.group));
            }
        }
        for spurious in &self.spurious {
            faults.push(format!("{} at {} is not there", spurious.cause, spurious.at));
        }
        if !self.gained {
            faults.push("nothing gained on poses left out".to_owned());
        }
        if self.held_out_over_noise > MAX_HELD_OUT {
            faults.push(format!("held-out error {:.2} of the noise", self.held_out_over_noise));
        }
        faults
    }

    /// Whether every hidden effect was met in a group that is small enough.
    pub(crate) fn is_right(&self) -> bool {
        self.answers.iter().all(|a| a.met != Met::Missed && a.group <= LARGEST_GROUP)
    }
}
