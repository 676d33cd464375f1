//! Blind cases: an effect is hidden in a table of measured frequencies by a truth that shares no code with the
//! crate ([`crate::truth`]), and `detune diagnose ROBOT MEASURED.csv --format json` has to find it.
//!
//! A case is right if every hidden cause is a finding at its place, or in a finding's group of at most four. Judged
//! besides: the verdict, findings of what is not there, the gain, the held-out error against noise and rounding,
//! and whether the 95 % intervals hold the true parameters. The shares asked for are those of [`bars`].
//!
//! The seeds are fixed. Variables of the environment:
//!
//! | variable | meaning |
//! |---|---|
//! | `DETUNE_SEEDS=200` | the long run: so many seeds for each cause (the arms take turns), four times as many without one, 16 to 44 poses, groups split by the suggested poses. `cargo test --release --test blind hidden_effects -- --nocapture` prints the confusion matrices as Markdown |
//! | `DETUNE_FIRST_SEED=1000` | other seeds than those of the suite |
//! | `DETUNE_SHARE=3` | every third case, in which all arms take their turns |
//! | `DETUNE_ONLY=payload` | only cases whose name (`six-axis-payload-weak-1`) holds this |
//! | `DETUNE_PROGRAM=path` | judges another build of the program |
//! | `DETUNE_CASES=folder` | keeps every case with truth.json, diagnosis.json, stderr.txt, and the tables |

use std::env;
use std::fs;
use std::path::PathBuf;

use crate::share::one_in;
use crate::truth::case::{Case, Order, Scenario, Strength};
use crate::truth::confusion::Bar;
use crate::truth::effects::{BEYOND, VOCABULARY};
use crate::truth::robots::Family;
use crate::truth::run::{Settings, judge, judge_all};
use crate::truth::score::Score;

const FAMILIES: [Family; 4] =
    [Family::SixAxis, Family::Planar { links: 2 }, Family::Planar { links: 3 }, Family::Sweep];

/// Causes that the suite hides at two to four times the noise; the long run hides all.
const WEAK: [&str; 5] =
    ["joint_stiffness", "payload", "joint_zero_offset", "com_offset", "temperature_drift"];

/// What the environment asks for.
struct Run {
    /// Seeds for each scenario; `None` is the suite.
    seeds: Option<u64>,
    first_seed: u64,
    only: Option<String>,
    keep: Option<PathBuf>,
}

impl Run {
    fn from_environment() -> Self {
        let number = |name: &str| {
            env::var(name).ok().map(|text| {
                text.parse().unwrap_or_else(|_| panic!("{name} is '{text}', must be a number"))
            })
        };
        // Tests run in the package's folder, wherever they were called from.
        Self {
            seeds: number("DETUNE_SEEDS"),
            first_seed: number("DETUNE_FIRST_SEED").unwrap_or(1),
            only: env::var("DETUNE_ONLY").ok(),
            keep: env::var_os("DETUNE_CASES").map(PathBuf::from),
        }
    }

    /// Orders for a scenario: in the suite one arm, in the long run the arms in turn.
    fn orders(&self, scenario: Scenario, strength: Strength, turn: usize) -> Vec<Order> {
        let order = |family, seed, poses| Order { family, scenario, strength, poses, seed };
        match self.seeds {
            Some(seeds) => (self.first_seed..self.first_seed + seeds)
                .map(|seed| order(FAMILIES[seed as usize % 4], seed, [16, 44]))
                .collect(),
            None => vec![order(FAMILIES[turn % 4], self.first_seed, [16, 24])],
        }
    }

    /// The same for a scenario that has no causes to go through: on every arm, in the long run four times each.
    fn orders_on_every_arm(&self, scenario: Scenario) -> Vec<Order> {
        let strength = Strength::Plain;
        let all = (0..4).flat_map(|turn| self.orders(scenario, strength, turn));
        all.enumerate()
            .map(|(i, order)| match self.seeds {
                // Seeds of their own, beyond those of the run.
                Some(seeds) => {
                    let seed = self.first_seed + i as u64;
                    let family = FAMILIES[(i as u64 / seeds) as usize];
                    Order { seed, family, ..order }
                }
                None => order,
            })
            .collect()
    }

    /// Judges the cases of some orders and holds them to a bar.
    fn judge(&self, title: &str, orders: Vec<Order>, bar: &Bar) {
        let wanted =
            |case: &Case| self.only.as_ref().is_none_or(|only| case.name().contains(only.as_str()));
        let orders: Vec<Order> = orders.into_iter().step_by(one_in()).collect();
        let count = orders.len();
        let drawn: Vec<Case> = orders.into_iter().filter_map(Case::draw).collect();
        // Not every arm has a place for every cause at every size.
        let impossible = count - drawn.len();
        assert!(10 * impossible <= count, "{impossible} of {count} cases could not be drawn");
        let cases: Vec<Case> = drawn.into_iter().filter(wanted).collect();
        let settings = Settings { keep: self.keep.clone(), split: self.seeds.is_some() };
        let confusion = judge_all(&cases, &settings);
        let mut report = format!("## {title}\n\n{}\n", confusion.markdown());
        for failure in confusion.failures() {
            report += &format!("- {failure}\n");
        }
        println!("{report}");
        if let Some(keep) = &self.keep {
            fs::create_dir_all(keep).unwrap();
            fs::write(keep.join(format!("{}.md", title.replace(' ', "-"))), &report).unwrap();
        }
        let short = confusion.shortfalls(bar);
        assert!(short.is_empty(), "{title}: {}", short.join("; "));
    }
}

/// What is asked of each kind of case.
mod bars {
    use crate::truth::confusion::Bar;

    pub(super) const SINGLE: Bar = Bar {
        named: Some(0.95),
        verdict: Some(0.95),
        clean: Some(0.95),
        gained: Some(0.95),
        held_out: Some(0.90),
        covered: Some(0.88),
        split: Some(0.80),
    };
    pub(super) const WEAK: Bar = Bar { named: Some(0.85), verdict: Some(0.85), ..SINGLE };
    pub(super) const PAIR: Bar =
        Bar { named: Some(0.80), gained: Some(0.90), held_out: None, split: None, ..SINGLE };
    pub(super) const TRIPLE: Bar = Bar { named: Some(0.60), ..PAIR };
    pub(super) const NOTHING: Bar = Bar {
        named: None,
        verdict: Some(0.95),
        clean: Some(0.95),
        gained: None,
        held_out: Some(0.90),
        covered: None,
        split: None,
    };
    pub(super) const BEYOND: Bar = Bar {
        named: None,
        verdict: Some(0.85),
        clean: None,
        gained: None,
        held_out: None,
        covered: None,
        split: None,
    };
}

fn singles(run: &Run, causes: &[&'static str], strength: Strength) -> Vec<Order> {
    let orders =
        |(turn, cause): (usize, &&'static str)| run.orders(Scenario::Single(cause), strength, turn);
    causes.iter().enumerate().flat_map(orders).collect()
}

/// Every cause of the vocabulary, at four to twelve times the noise.
#[test]
fn single_effects_are_named() {
    let run = Run::from_environment();
    run.judge("Single effects", singles(&run, &VOCABULARY, Strength::Plain), &bars::SINGLE);
}

/// Two to four times the noise.
#[test]
fn weak_effects_are_named() {
    let run = Run::from_environment();
    // Instruments and gravity have no size to choose.
    let sized: Vec<&'static str> = VOCABULARY[..12].to_vec();
    let causes = if run.seeds.is_some() { &sized[..] } else { &WEAK[..] };
    run.judge("Weak effects", singles(&run, causes, Strength::Weak), &bars::WEAK);
}

#[test]
fn two_effects_are_both_named() {
    let run = Run::from_environment();
    run.judge("Two effects", run.orders_on_every_arm(Scenario::Several(2)), &bars::PAIR);
}

#[test]
fn three_effects_are_all_named() {
    let run = Run::from_environment();
    run.judge("Three effects", run.orders_on_every_arm(Scenario::Several(3)), &bars::TRIPLE);
}

/// Data that the model explains give no finding.
#[test]
fn nothing_is_found_where_nothing_is() {
    let run = Run::from_environment();
    run.judge("No effect", run.orders_on_every_arm(Scenario::Nothing), &bars::NOTHING);
}

/// What the vocabulary lacks is called unexplained.
#[test]
fn effects_beyond_the_vocabulary_are_unexplained() {
    let run = Run::from_environment();
    let mut orders = Vec::new();
    for (turn, kind) in BEYOND.into_iter().enumerate() {
        orders.extend(run.orders(Scenario::Beyond(kind), Strength::Plain, turn));
    }
    run.judge("Effects beyond the vocabulary", orders, &bars::BEYOND);
}

/// The score of one case.
fn score_of(family: Family, scenario: Scenario, seed: u64) -> Score {
    let order = Order { family, scenario, strength: Strength::Plain, poses: [16, 44], seed };
    judge(&Case::draw(order).unwrap(), tempfile::tempdir().unwrap().path(), false).unwrap()
}

/// A cause that shows at one of twenty poses, in one frequency that is 16 % off, is no noise.
#[test]
fn one_frequency_that_is_far_off_is_not_consistent() {
    let arm = Family::Planar { links: 3 };
    assert_ne!(score_of(arm, Scenario::Single("transverse_compliance"), 6).verdict, "consistent");
}

/// A base that bends meets one mode at a third of the poses, where its mode crosses that one: no stiffness far from
/// the right one leads there.
#[test]
fn a_base_that_crosses_one_mode_is_found() {
    let score = score_of(Family::SixAxis, Scenario::Single("base_compliance"), 8);
    assert_eq!(score.verdict, "explained");
    assert!(score.is_right() && score.spurious.is_empty(), "{score:?}");
}

/// Causes may take a good part of what they have no word for; what they leave is still too large for
/// noise.
#[test]
fn what_causes_leave_is_not_explained_where_it_is_too_large_for_noise() {
    let score = score_of(Family::Planar { links: 2 }, Scenario::Beyond("hysteresis"), 5);
    assert!(score.held_out_over_noise > 2.0, "{}", score.held_out_over_noise);
    assert_ne!(score.verdict, "explained");
}
