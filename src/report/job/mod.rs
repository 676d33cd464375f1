//! The page of a job, or of several: verdicts and advice first, then the arm along each path with
//! all that happens there.

mod along;
mod plots;
mod summary;

use std::collections::BTreeMap;

use serde::Serialize;

use super::check::findings::findings;
use super::check::operation::CheckedOperation;
use super::json::{NotFinite, laid_out};
use super::page::{self, Slider};
use crate::report::{Plot, words};
use crate::risk::OperationRisk;
use crate::study::advise::AdvisedJob;
use crate::study::arm::{Arm, MovingArm, Place, Surface};
use crate::study::check::CheckedJob;
use crate::study::report::Reported;
use crate::units::written;

/// At most so many operations of a job are drawn.
const MAX_DRAWN: usize = 24;

/// What a page shows of a job.
#[derive(Debug, Clone, Copy)]
pub struct JobPage<'a> {
    /// What a check found.
    pub checked: &'a CheckedJob,
    /// What is advised, where that was asked for.
    pub advised: Option<&'a AdvisedJob>,
    /// The arm along the paths.
    pub moving: &'a MovingArm,
}

impl<'a> From<&'a Reported> for JobPage<'a> {
    fn from(reported: &'a Reported) -> Self {
        let Reported { checked, advised, moving } = reported;
        Self { checked, advised: Some(advised), moving }
    }
}

impl JobPage<'_> {
    /// Indices of the operations that are drawn: the worst, in the order of the job.
    fn drawn(&self) -> Vec<usize> {
        let operations = &self.checked.risk.operations;
        let mut worst: Vec<usize> = (0..operations.len()).collect();
        worst.sort_by(|&a, &b| {
            let [a, b] = [&operations[a], &operations[b]];
            b.verdict.cmp(&a.verdict).then(b.probability.total_cmp(&a.probability))
        });
        worst.truncate(MAX_DRAWN);
        worst.sort_unstable();
        worst
    }
}

/// The page of these jobs.
///
/// # Errors
/// If a number is not finite, which would be a fault of the program.
pub fn jobs(jobs: &[JobPage]) -> Result<String, NotFinite> {
    let title = match jobs {
        [only] => only.checked.name.clone(),
        _ => format!("{} jobs", jobs.len()),
    };
    let mut body = String::new();
    if jobs.len() > 1 {
        body.push_str(&summary::jobs(jobs));
    }
    for (index, job) in jobs.iter().enumerate() {
        let drawn = job.drawn();
        body.push_str(&format!("<section data-job=\"{index}\">\n"));
        body.push_str(&summary::job(job, &drawn));
        let names: Vec<&str> =
            drawn.iter().map(|&of| job.checked.risk.operations[of].name.as_str()).collect();
        body.push_str(&page::controls(&job.moving.arm, index, Slider::Paths(&names)));
        for (place, &operation) in drawn.iter().enumerate() {
            body.push_str(&format!("<div data-operation=\"{place}\">\n"));
            body.push_str(&along::operation(job, operation));
            body.push_str("</div>\n");
        }
        body.push_str("</section>\n");
    }
    body.push_str(
        "<p class=\"remark\">Verdicts are about resonance and limits; chatter is told beside them \
         where the cut is known.</p>\n",
    );
    page::page(&title, &body, &Data::of(jobs))
}

/// What the script of that page works with, beside what check and advice say: the arm, and the
/// places of each operation with their shapes.
///
/// # Errors
/// As [`jobs`].
pub fn jobs_json(jobs: &[JobPage]) -> Result<String, NotFinite> {
    laid_out(&Data::of(jobs), 4)
}

/// The plots of checked jobs, each with its name.
pub fn check_plots(jobs: &[CheckedJob]) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (j, job) in jobs.iter().enumerate() {
        for (o, risk) in job.risk.operations.iter().enumerate() {
            let name = |plot: &str| format!("{}-{}-{}-{plot}", j + 1, o + 1, risk.name);
            plots.push((name("frequencies"), plots::frequencies(risk)));
            let others = [
                ("tool-tip", plots::tool_tip(risk)),
                ("stability", plots::limit_of_depth(risk)),
                ("beta2", plots::beta2(risk)),
            ];
            plots.extend(others.into_iter().filter_map(|(of, drawn)| Some((name(of), drawn?))));
        }
    }
    plots
}

/// What a run sets of the policy, as a line above the plots; empty where it sets nothing.
pub fn head_of_plots(jobs: &[CheckedJob]) -> String {
    let given = jobs.iter().find_map(|job| words::overrides(&job.overrides));
    given.map_or_else(String::new, |given| format!("{given}\n\n"))
}

/// What the script of the page works with.
#[derive(Debug, Serialize)]
struct Data<'a> {
    schema: &'static str,
    jobs: Vec<JobData<'a>>,
    /// The surfaces of all arms, each once, by their keys.
    surfaces: BTreeMap<&'a str, &'a Surface>,
}

impl<'a> Data<'a> {
    fn of(jobs: &[JobPage<'a>]) -> Self {
        let surfaces = jobs.iter().flat_map(|job| &job.moving.surfaces);
        Self {
            schema: "report/1",
            jobs: jobs.iter().map(JobData::of).collect(),
            surfaces: surfaces.map(|surface| (surface.key.as_str(), &**surface)).collect(),
        }
    }
}

#[derive(Debug, Serialize)]
struct JobData<'a> {
    name: &'a str,
    arm: &'a Arm,
    /// The operation that is shown first: the worst.
    start: usize,
    operations: Vec<OperationData<'a>>,
}

#[derive(Debug, Serialize)]
struct OperationData<'a> {
    name: &'a str,
    duration_s: f64,
    /// The mode that is shown first, counted from 1: the one of the worst crossing.
    mode: usize,
    #[serde(rename = "separation_percent", serialize_with = "written::percent")]
    separation: f64,
    #[serde(rename = "uncertainty_percent", serialize_with = "written::percent")]
    uncertainty: f64,
    places: &'a [Place],
}

/// The mode of the worst crossing, else of the closest approach.
fn worst_mode(job: &CheckedJob, risk: &OperationRisk) -> usize {
    let found = findings(&CheckedOperation { job, risk });
    let crossing = found.first().map(|finding| finding.mode);
    crossing.or(risk.closest.map(|approach| approach.mode)).unwrap_or(1)
}

impl<'a> JobData<'a> {
    fn of(job: &JobPage<'a>) -> Self {
        let (checked, moving) = (job.checked, job.moving);
        let drawn = job.drawn();
        let all = &checked.risk.operations;
        let worst = |a: &usize, b: &usize| all[*a].verdict.cmp(&all[*b].verdict).then(b.cmp(a));
        let start = drawn.iter().copied().max_by(worst);
        let operation = |&index: &usize| {
            let risk: &'a OperationRisk = &all[index];
            OperationData {
                name: &risk.name,
                duration_s: risk.duration_s,
                mode: worst_mode(checked, risk),
                separation: checked.risk.separation,
                uncertainty: risk.model_uncertainty,
                places: moving.places.get(index).map_or(&[], Vec::as_slice),
            }
        };
        Self {
            name: &checked.name,
            arm: &moving.arm,
            start: drawn.iter().position(|index| Some(*index) == start).unwrap_or(0),
            operations: drawn.iter().map(operation).collect(),
        }
    }
}
