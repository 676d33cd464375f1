//! Effects as gears, bearings, foundations and beams have them: none has the form of a cause of the engine. A
//! diagnosis has to name the right cause all the same, and only that.
//!
//! | variable | meaning |
//! |---|---|
//! | `DETUNE_REAL_SEEDS=10` | so many seeds for each kind; where absent, one of some |
//! | `DETUNE_REAL_FIRST_SEED=100` | other seeds than those of the suite |
//! | `DETUNE_SHARE=3` | every third case |
//! | `DETUNE_ONLY=beam` | only cases whose name holds this |
//! | `DETUNE_CASES=folder` | keeps every case with its files |

mod kinds;
mod score;
mod world;

use std::env;
use std::fs;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use self::kinds::{Case, KINDS};
use self::score::{Score, Total, above_the_measured, judge};
use crate::share::one_in;

/// What the suite has time for.
const SUITE: [&str; 8] =
    ["base3", "bearing", "all", "warm_all", "payload_drift", "typo", "calm_drift", "hung"];

fn number(name: &str, default: u64) -> u64 {
    env::var(name).ok().map_or(default, |text| text.parse().unwrap())
}

fn cases() -> Vec<Case> {
    let (seeds, first) = (number("DETUNE_REAL_SEEDS", 1), number("DETUNE_REAL_FIRST_SEED", 1));
    let only = env::var("DETUNE_ONLY").ok();
    let kinds: &[&'static str] =
        if env::var("DETUNE_REAL_SEEDS").is_ok() { &KINDS } else { &SUITE };
    let all = (first..first + seeds).flat_map(|seed| kinds.iter().map(move |kind| (*kind, seed)));
    all.step_by(one_in())
        .filter_map(|(kind, seed)| Case::draw(kind, seed))
        .filter(|case| only.as_ref().is_none_or(|only| case.name.contains(only.as_str())))
        .collect()
}

fn judge_all(cases: &[Case]) -> Vec<Result<Score, String>> {
    let keep = env::var_os("DETUNE_CASES").map(PathBuf::from);
    let next = AtomicUsize::new(0);
    let scores = Mutex::new(Vec::new());
    let work = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(case) = cases.get(i) else { break };
            let score = match &keep {
                Some(keep) => {
                    let folder = keep.join(&case.name);
                    fs::create_dir_all(&folder).unwrap();
                    judge(case, &folder)
                }
                None => judge(case, tempfile::tempdir().unwrap().path()),
            };
            scores.lock().unwrap().push((i, score));
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(2, usize::from) {
            scope.spawn(work);
        }
    });
    let mut scores = scores.into_inner().unwrap();
    scores.sort_by_key(|(i, _)| *i);
    scores.into_iter().map(|(_, score)| score).collect()
}

#[test]
fn effects_of_real_form_are_named() {
    let cases = cases();
    let scores = judge_all(&cases);
    let mut total = Total::default();
    for (case, score) in cases.iter().zip(&scores) {
        match score {
            Ok(score) => println!("{}", total.add(case, score)),
            Err(fault) => println!("{:<28} FAILED {fault}", case.name),
        }
    }
    println!("{}", total.summary(&cases));
    assert!(scores.iter().all(Result::is_ok));
    if env::var("DETUNE_ONLY").is_err() {
        let short = total.shortfalls();
        assert!(short.is_empty(), "{}", short.join("; "));
    }
}

/// A link that bends is a hinge in the model, which has another mode above the measured ones than a beam: no such mode is
/// known to better than a factor of two either way, and of two beams the truth is within. Not of all: of seed 45 it is
/// not, at 10 of 10 poses.
#[test]
fn modes_above_the_measured_ones_are_not_known_of_a_beam() {
    for seed in [41, 44] {
        let case = Case::draw("beam", seed).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let score = judge(&case, folder.path()).unwrap();
        let bends = score.findings.iter().any(|finding| finding.starts_with("link_flexibility"));
        assert!(bends, "{seed}: {:?}", score.findings);
        let (narrowest, held) = above_the_measured(&case, folder.path());
        assert!(narrowest > 4f64.ln() * 0.98, "{seed}: {narrowest}");
        assert!(held >= 9, "{seed}: {held} of {}", case.fresh.len());
    }
}

/// The model is right at the first row, from which on the table drifts by 2 to 4 %: springs learned at its middle are
/// off there by more than the tests scatter, which the intervals hold.
#[test]
fn a_table_that_drifts_knows_no_mode_better_than_its_drift() {
    for seed in [1, 3, 7].into_iter().step_by(one_in()) {
        let case = Case::draw("calm_drift", seed).unwrap();
        let score = judge(&case, tempfile::tempdir().unwrap().path()).unwrap();
        assert_eq!(score.verdict, "consistent", "{seed}: {:?}", score.findings);
        let pooled = |which: usize| score.predicted.iter().map(|own| own[which]).sum::<usize>();
        let (held, all) = (pooled(0), pooled(1));
        assert!(20 * held >= 19 * all, "{seed}: {held} of {all}");
    }
}

/// A base that gives in six directions, and a part that the arm feels, are found though from none of its starts such
/// a form promises much, and though two causes fit with fewer parameters.
#[test]
fn forms_whose_starts_promise_little_are_found_alone() {
    for (kind, seed) in [("base6", 303), ("hung", 403)] {
        let case = Case::draw(kind, seed).unwrap();
        let score = judge(&case, tempfile::tempdir().unwrap().path()).unwrap();
        let [found] = &score.findings[..] else { panic!("{kind}: {:?}", score.findings) };
        assert!(found.starts_with(case.hidden[0].cause), "{kind}: {found}");
    }
}

/// A hall that warms up makes the drift of a day look like a law of temperature, and a drift that the model was right
/// before like springs that are all stiffer.
#[test]
fn a_drift_is_neither_a_law_of_temperature_nor_stiffer_springs() {
    for (kind, seed) in [("payload_drift", 205), ("calm_drift", 202)] {
        let case = Case::draw(kind, seed).unwrap();
        let score = judge(&case, tempfile::tempdir().unwrap().path()).unwrap();
        let hidden = |finding: &String| kind == "payload_drift" && finding.starts_with("payload");
        assert!(score.findings.iter().all(hidden), "{kind} {seed}: {:?}", score.findings);
    }
}

/// A base whose mode enters in four rows of a table, off by 11 % there, is found: its stiffness has to start near.
#[test]
fn a_base_whose_mode_enters_in_four_rows_is_found() {
    let case = Case::draw("base3", 42).unwrap();
    let score = judge(&case, tempfile::tempdir().unwrap().path()).unwrap();
    assert_eq!(score.verdict, "explained");
    assert!(score.held_out_over_noise < 1.25, "{}", score.held_out_over_noise);
    let [found] = &score.findings[..] else { panic!("{:?}", score.findings) };
    assert!(found.starts_with("base_compliance"), "{found}");
}
