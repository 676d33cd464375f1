//! Schedules against a scan at twenty times their density and against a fine dynamic programme, both from the
//! closed-form frequencies of a two-link arm (Pietruś & Gierlak 2023, Eq. 45) and sharing no code with the
//! crate.

use std::path::PathBuf;
use std::sync::Arc;

use detune::advice::{Coupling, FeedRule, Objective, Options, Remedy, Schedule, advise};
use detune::job::{Carried, Job, Levers, Operation, Policy, Review, Spindle, SpindleSpeed, Tool};
use detune::model::Robot;
use detune::motion::{Move, Target, Timing, Work};
use detune::progress::silent;
use detune::risk::{Verdict, assess};
use nalgebra::Isometry3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::planar_arm::{L1, L2, closed_form_hz, two_link};

/// Twenty for each of the 500 cells of a schedule.
const SAMPLES: usize = 10_000;

struct Case {
    job: Job,
    /// f1 and f2 at equal steps of time.
    frequencies: Vec<[f64; 2]>,
    duration_s: f64,
    orders: Vec<u32>,
}

/// A path under a spindle; `air` moves run at ten times the feed.
fn case(waypoints: &[[f64; 2]], rpm: f64, policy: Policy, spindle: Spindle, air: &[usize]) -> Case {
    let feed = |i: usize| if air.contains(&i) { 0.1 } else { 0.01 };
    let moves = waypoints.iter().enumerate().map(|(i, q)| Move {
        to: Target::Joints(q.to_vec()),
        feed_m_per_s: feed(i),
        tcp: Isometry3::identity(),
        work: Work::Stands,
        line: 10 + i,
        timing: Timing::Feed,
        spindle_turns: true,
        stated: Arc::default(),
    });
    let teeth = 2;
    let orders = (1..=policy.spindle_harmonics)
        .chain((1..=policy.tooth_passing_harmonics).map(|h| h * teeth))
        .collect();
    let (frequencies, duration_s) = along(waypoints, &feed);
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let job = Job {
        name: "held out".into(),
        file: PathBuf::from("job.yaml"),
        robot: robot.clone(),
        spindle,
        operations: vec![Operation::new(
            &robot,
            Carried::NOTHING,
            Tool { teeth, ..Tool::default() },
            SpindleSpeed::Constant(rpm),
            0.01,
            moves.collect(),
        )],
        policy,
        levers: Levers::default(),
        review: Review::default(),
    };
    Case { job, frequencies, duration_s, orders }
}

/// Frequencies at equal steps of time, with lengths summed from chords.
fn along(waypoints: &[[f64; 2]], feed: &dyn Fn(usize) -> f64) -> (Vec<[f64; 2]>, f64) {
    let tip = |q: [f64; 2]| {
        let (a, b) = (q[0], q[0] + q[1]);
        [L1 * a.cos() + L2 * b.cos(), L1 * a.sin() + L2 * b.sin()]
    };
    let lerp = |w: &[[f64; 2]], u: f64| [0, 1].map(|i| w[0][i] + (w[1][i] - w[0][i]) * u);
    let chords = 20_000;
    let times: Vec<f64> = waypoints
        .windows(2)
        .enumerate()
        .map(|(k, w)| {
            let length: f64 = (0..chords)
                .map(|i| {
                    let at = |i: usize| tip(lerp(w, i as f64 / chords as f64));
                    let (p, q) = (at(i), at(i + 1));
                    (p[0] - q[0]).hypot(p[1] - q[1])
                })
                .sum();
            length / feed(k + 1)
        })
        .collect();
    let total: f64 = times.iter().sum();
    let frequencies = (0..=SAMPLES)
        .map(|i| {
            let mut left = i as f64 / SAMPLES as f64 * total;
            let mut k = 0;
            while k + 1 < times.len() && left > times[k] {
                left -= times[k];
                k += 1;
            }
            closed_form_hz(lerp(&waypoints[k..], (left / times[k]).min(1.0))[1])
        })
        .collect();
    (frequencies, total)
}

impl Case {
    fn hits(&self, sample: usize, rpm: f64) -> bool {
        let wide = self.job.policy.separation + self.job.policy.model_uncertainty.unwrap();
        self.orders.iter().any(|&order| {
            let line = f64::from(order) * rpm / 60.0;
            let ignored = self.job.policy.ignore_hz.iter().any(|b| b[0] <= line && line <= b[1]);
            !ignored && self.frequencies[sample].iter().any(|f| (line - f).abs() < f * wide)
        })
    }

    /// No contact outside what is told; speed and acceleration within limits at either feed.
    fn holds(&self, plan: &Schedule, what: &str) {
        let spindle = &self.job.spindle;
        let limit = spindle.max_acceleration_rpm_per_s.unwrap();
        assert_eq!((plan.points[0].0, plan.points.last().unwrap().0), (0.0, 1.0), "{what}");
        for pair in plan.points.windows(2) {
            assert!(pair[0].0 < pair[1].0, "{what}");
            for duration_s in [self.duration_s, plan.duration_s] {
                let rate = (pair[1].1 - pair[0].1) / ((pair[1].0 - pair[0].0) * duration_s);
                assert!(rate.abs() <= limit, "{what}: {rate} rpm/s over {limit}");
            }
        }
        for &(_, rpm) in &plan.points {
            assert!((spindle.min_rpm..=spindle.max_rpm).contains(&rpm), "{what}: {rpm}");
        }
        for sample in 0..=SAMPLES {
            let s = sample as f64 / SAMPLES as f64;
            let after = plan.points.partition_point(|p| p.0 <= s).clamp(1, plan.points.len() - 1);
            let (a, b) = (plan.points[after - 1], plan.points[after]);
            let rpm = a.1 + (b.1 - a.1) * (s - a.0) / (b.0 - a.0);
            let told = plan.exposures.iter().any(|e| s > e.from_s - 2e-4 && s < e.to_s + 2e-4);
            assert!(told || !self.hits(sample, rpm), "{what}: {rpm} rpm at s = {s}");
        }
    }

    /// The least objective over a grid of speeds, by dynamic programming; infinite where there is no way.
    fn programme(&self, step_rpm: f64, cells: usize, solved_for_s: f64) -> f64 {
        let SpindleSpeed::Constant(p) = self.job.operations[0].speed else { unreachable!() };
        self.programme_towards(p, step_rpm, cells, solved_for_s)
    }

    /// The same with another speed to stay near to.
    fn programme_towards(
        &self,
        target_rpm: f64,
        step_rpm: f64,
        cells: usize,
        solved_for_s: f64,
    ) -> f64 {
        const SMOOTHING: f64 = 1e-3;
        let SpindleSpeed::Constant(p) = self.job.operations[0].speed else { unreachable!() };
        let Spindle { min_rpm, max_rpm, max_acceleration_rpm_per_s } = self.job.spindle;
        let levels = ((max_rpm - min_rpm) / step_rpm).floor() as usize + 1;
        let speed = |level: usize| min_rpm + level as f64 * step_rpm;
        let window = (max_acceleration_rpm_per_s.unwrap() * solved_for_s / cells as f64 / step_rpm
            + 1e-9)
            .floor() as usize;
        assert!(window >= 2, "the grid of speeds is too coarse for the acceleration");
        let per_cell = SAMPLES / cells;
        let near = |level: usize| ((speed(level) - target_rpm) / p).powi(2) / cells as f64;
        let half = |level: usize, i: usize| {
            if i == 0 || i == cells { 0.5 * near(level) } else { near(level) }
        };
        // The straight line between two levels is looked at where it is likely to touch: at every sample.
        let is_free = |i: usize, a: usize, b: usize| {
            (0..=per_cell).step_by(per_cell / 5).all(|j| {
                let u = j as f64 / per_cell as f64;
                !self.hits(i * per_cell + j, speed(a) + (speed(b) - speed(a)) * u)
            })
        };
        let mut cost: Vec<f64> = (0..levels)
            .map(|level| if self.hits(0, speed(level)) { f64::INFINITY } else { half(level, 0) })
            .collect();
        for i in 0..cells {
            let mut next = vec![f64::INFINITY; levels];
            for (a, &so_far) in cost.iter().enumerate().filter(|(_, c)| c.is_finite()) {
                let reach = next.iter_mut().enumerate().take(a + window + 1);
                for (b, least) in reach.skip(a.saturating_sub(window)) {
                    let change = (speed(b) - speed(a)) / p;
                    let total =
                        so_far + half(b, i + 1) + SMOOTHING * change * change * cells as f64;
                    if total < *least && is_free(i, a, b) {
                        *least = total;
                    }
                }
            }
            cost = next;
        }
        cost.into_iter().fold(f64::INFINITY, f64::min)
    }
}

fn policy(separation: f64, tooth_passing_harmonics: u32, spindle_harmonics: u32) -> Policy {
    Policy {
        tooth_passing_harmonics,
        spindle_harmonics,
        separation,
        model_uncertainty: Some(0.02),
        confidence: 0.95,
        ignore_hz: vec![],
        min_tip_response_m_per_n: Some(0.0),
        max_deflection_m: None,
        max_vibration_m: None,
    }
}

fn random_case(rng: &mut ChaCha8Rng) -> Case {
    let n = rng.random_range(2..5);
    let waypoints: Vec<[f64; 2]> =
        (0..n).map(|_| [rng.random_range(-1.0..2.5), rng.random_range(-2.6..2.6)]).collect();
    let min_rpm = rng.random_range(250.0..900.0);
    let spindle = Spindle {
        min_rpm,
        max_rpm: min_rpm * rng.random_range(1.15..1.6),
        max_acceleration_rpm_per_s: Some(rng.random_range(10.0..60.0)),
    };
    let rpm = rng.random_range(spindle.min_rpm..spindle.max_rpm);
    let mut policy =
        policy(rng.random_range(0.02..0.12), rng.random_range(1..4), rng.random_range(0..3));
    if rng.random_bool(0.3) {
        let f = rng.random_range(20.0..45.0);
        policy.ignore_hz.push([f, f * 1.05]);
    }
    case(&waypoints, rpm, policy, spindle, &[])
}

#[test]
fn schedules_keep_out_of_bands_and_within_limits() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let (mut clear, mut crossing, mut none) = (0, 0, 0);
    for index in 0..130 {
        let mut case = random_case(&mut rng);
        let options = Options { schedule: true, ..Options::default() };
        let advice = advise(&case.job, &options, &silent).unwrap();
        // A schedule that comes to one safe speed is that speed.
        if let Remedy::Constant(constant) = &advice.operations[0].remedy
            && advice.operations[0].no_schedule.is_none()
        {
            case.job.operations[0].speed = SpindleSpeed::Constant(constant.rpm);
            assert_eq!(assess(&case.job, &silent).unwrap().verdict, Verdict::Clear, "case {index}");
            clear += 1;
            continue;
        }
        let Remedy::Scheduled(plan) = &advice.operations[0].remedy else {
            none += 1;
            println!("case {index}: {:?}", advice.operations[0].no_schedule);
            continue;
        };
        case.holds(plan, &format!("case {index}"));
        // A check under the new speed and feed sees the same.
        case.job.operations[0].speed = SpindleSpeed::Schedule(plan.points.clone());
        let risk = assess(&case.job, &silent).unwrap();
        if plan.exposures.is_empty() {
            clear += 1;
            assert_eq!(risk.verdict, Verdict::Clear, "case {index}");
            assert!(advice.is_clear());
        } else {
            crossing += 1;
            assert_ne!(risk.verdict, Verdict::Clear, "case {index}");
            assert!(!advice.is_clear());
            assert!(plan.exposures.iter().all(|e| e.seconds > 0.0 && e.tooth_impacts > 0.0));
        }
        if let Coupling::MeanChipLoad = plan.coupling {
            let operation = &advice.operations[0];
            let mean: f64 =
                plan.points.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
            let chip = plan.feed_m_per_s / mean * operation.programmed_rpm / 0.01;
            assert!((chip - 1.0).abs() < 1e-6, "case {index}: {chip}");
            assert!(
                (plan.duration_s * plan.feed_m_per_s / 0.01 / case.duration_s - 1.0).abs() < 1e-6
            );
        }
    }
    println!("{clear} clear, {crossing} crossing, {none} none");
    assert!(clear > 100 && crossing > 2, "{clear} {crossing} {none}");
}

#[test]
fn schedules_are_as_good_as_a_fine_dynamic_programme() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let (mut compared, mut worst) = (0, 0.0_f64);
    for index in 0..40 {
        let case = random_case(&mut rng);
        let options = Options { schedule: true, feed: FeedRule::Programmed, ..Options::default() };
        let advice = advise(&case.job, &options, &silent).unwrap();
        let found = match &advice.operations[0].remedy {
            Remedy::Scheduled(plan) if plan.exposures.is_empty() => plan.objective,
            // One speed throughout: its distance from the programmed one, and no change.
            Remedy::Constant(constant) => {
                (constant.rpm / advice.operations[0].programmed_rpm - 1.0).powi(2)
            }
            _ => f64::INFINITY,
        };
        let best = case.programme(1.0, 100, case.duration_s);
        if best.is_infinite() {
            continue;
        }
        compared += 1;
        // A speed that may stay as programmed costs nothing.
        assert!(found <= 1.01 * best + 1e-9, "case {index}: {found}, the programme finds {best}");
        worst = worst.max(found / best.max(1e-9));
    }
    println!("{compared} compared, largest ratio {worst:.4}");
    assert!(compared > 15, "{compared}");
}

/// f1 rises along the path: the spindle must start above the band and end below it, so the band is crossed
/// once, and in the air where a move is.
#[test]
fn a_band_that_must_be_crossed_is_crossed_once_and_in_the_air() {
    // Out and back: the middle stretch, in the air, is short in time.
    let waypoints = [[0.0, 0.2], [0.0, 1.2], [0.5, 1.5], [0.5, 2.5]];
    // With bands of ±5 % about 30 f1: at the start all below is closed, at the end all above.
    let spindle =
        Spindle { min_rpm: 440.0, max_rpm: 540.0, max_acceleration_rpm_per_s: Some(400.0) };
    let case = case(&waypoints, 480.0, policy(0.03, 1, 0), spindle, &[2]);
    let f1: Vec<f64> = case.frequencies.iter().map(|f| f[0]).collect();
    let advice = advise(&case.job, &Options::default(), &silent).unwrap();
    let operation = &advice.operations[0];
    println!("f1 {:.2} to {:.2} Hz; {:?}", f1[0], f1[SAMPLES], operation.set.safe);
    let Remedy::Scheduled(plan) = &operation.remedy else { panic!("{:?}", operation.remedy) };
    case.holds(plan, "crossing");
    let stretches = plan.exposures.len();
    println!("{stretches} stretches: {:?}", plan.exposures);
    assert!(stretches > 0 && plan.exposures.iter().all(|e| e.is_in_air));
    // One passage: the stretches touch.
    let from = plan.exposures.iter().map(|e| e.from_s).fold(1.0, f64::min);
    let to = plan.exposures.iter().map(|e| e.to_s).fold(0.0, f64::max);
    let sum: f64 = plan.exposures.iter().map(|e| e.to_s - e.from_s).sum();
    assert!((to - from - sum).abs() < 1e-6);
}

/// One stay of a line in a band: from, to.
type Stay = [f64; 2];

impl Case {
    /// f1 and f2 at s, between samples.
    fn frequencies_at(&self, s: f64) -> [f64; 2] {
        let at = s * SAMPLES as f64;
        let i = (at as usize).min(SAMPLES - 1);
        let (a, b) = (self.frequencies[i], self.frequencies[i + 1]);
        [0, 1].map(|r| a[r] + (b[r] - a[r]) * (at - i as f64))
    }

    fn is_in_band(&self, plan: &Schedule, s: f64) -> bool {
        let wide = self.job.policy.separation + self.job.policy.model_uncertainty.unwrap();
        let rpm = SpindleSpeed::Schedule(plan.points.clone()).rpm_at(s);
        self.orders.iter().any(|&order| {
            let line = f64::from(order) * rpm / 60.0;
            self.frequencies_at(s).iter().any(|f| (line - f).abs() < f * wide)
        })
    }

    /// Every stay in a band, with ends by bisection: each piece of the schedule is scanned at 200 places, however
    /// short it is, and at all samples.
    fn stays(&self, plan: &Schedule) -> Vec<Stay> {
        let mut places: Vec<f64> = (0..=SAMPLES).map(|i| i as f64 / SAMPLES as f64).collect();
        for pair in plan.points.windows(2) {
            let step = (pair[1].0 - pair[0].0) / 200.0;
            places.extend((0..200).map(|i| pair[0].0 + step * f64::from(i)));
        }
        places.sort_by(f64::total_cmp);
        let end = |mut out: f64, mut within: f64| {
            for _ in 0..60 {
                let middle = 0.5 * (out + within);
                if self.is_in_band(plan, middle) { within = middle } else { out = middle }
            }
            within
        };
        let mut stays: Vec<Stay> = Vec::new();
        let mut is_inside = false;
        for pair in places.windows(2) {
            let next = self.is_in_band(plan, pair[1]);
            if next && !is_inside {
                stays.push([end(pair[0], pair[1]), pair[1]]);
            } else if let Some(stay) = stays.last_mut().filter(|_| is_inside) {
                stay[1] = if next { pair[1] } else { end(pair[1], pair[0]) };
            }
            is_inside = next;
        }
        stays
    }

    /// What is written of a crossing: the acceleration at twenty times the density of its own points, the stays in
    /// bands as they are told and as a check finds them, and each as short as the spindle can make it.
    fn crosses_fast(&self, plan: &Schedule, what: &str) -> f64 {
        let limit = self.job.spindle.max_acceleration_rpm_per_s.unwrap();
        for pair in plan.points.windows(2) {
            let speed = SpindleSpeed::Schedule(plan.points.clone());
            for i in 0..20 {
                let s = |i: i32| pair[0].0 + (pair[1].0 - pair[0].0) * f64::from(i) / 20.0;
                let change = (speed.rpm_at(s(i + 1)) - speed.rpm_at(s(i))).abs();
                let most = limit * (s(i + 1) - s(i)) * plan.duration_s;
                assert!(change <= most + 1e-9, "{what}: {change} over {most} at {}", s(i));
            }
        }
        let stays = self.stays(plan);
        assert_eq!(stays.len(), 1, "{what}: {stays:?}");
        let [from, to] = stays[0];
        let speed = SpindleSpeed::Schedule(plan.points.clone());
        let seconds = (to - from) * plan.duration_s;
        let least = (speed.rpm_at(to) - speed.rpm_at(from)).abs() / limit;
        assert!(seconds >= least * (1.0 - 1e-6), "{what}: {seconds} below {least}");
        assert!((plan.exposed_s / seconds - 1.0).abs() < 2e-3, "{what}: {seconds}");
        let passages = &plan.passages;
        let [passage] = passages.as_slice() else { panic!("{what}: {passages:?}") };
        assert!((passage.seconds / seconds - 1.0).abs() < 2e-3, "{what}: {seconds}");
        let mean_rpm = 0.5 * (speed.rpm_at(from) + speed.rpm_at(to));
        let impacts = seconds * mean_rpm / 60.0 * f64::from(self.job.operations[0].tool.teeth);
        assert!((passage.tooth_impacts / impacts - 1.0).abs() < 1e-2, "{what}: {impacts}");
        // A check of the schedule finds the same stay.
        let mut job = self.job.clone();
        job.operations[0].speed = speed;
        let checked = &assess(&job, &silent).unwrap().operations[0].crossings;
        let found = [
            checked.iter().map(|c| c.from_s).fold(1.0, f64::min),
            checked.iter().map(|c| c.to_s).fold(0.0, f64::max),
        ];
        for (found, own) in found.into_iter().zip([from, to]) {
            assert!((found - own).abs() < 1e-3 * (to - from) + 1e-12, "{what}: {found} {own}");
        }
        seconds / least
    }
}

/// The time in a band that is crossed is its width along the trajectory over the spindle's acceleration, for
/// spindles that take minutes and for ones that take microseconds; the feed settles where it is coupled.
#[test]
fn a_band_is_crossed_as_fast_as_the_spindle_can() {
    let waypoints = [[0.0, 0.2], [0.0, 1.2], [0.5, 1.5], [0.5, 2.5]];
    let (mut settled, mut held, mut worst) = (0, 0, 0.0_f64);
    for air in [&[2][..], &[]] {
        for acceleration in [4.0, 20.0, 400.0, 1e4, 1e6, 1e8] {
            for rpm in [441.0, 480.0, 539.0] {
                let spindle = Spindle {
                    min_rpm: 440.0,
                    max_rpm: 540.0,
                    max_acceleration_rpm_per_s: Some(acceleration),
                };
                let case = case(&waypoints, rpm, policy(0.03, 1, 0), spindle, air);
                let what = format!("{acceleration} rpm/s from {rpm} rpm, air {air:?}");
                let advice = advise(&case.job, &Options::default(), &silent).unwrap();
                let Remedy::Scheduled(plan) = &advice.operations[0].remedy else {
                    panic!("{what}: {:?}", advice.operations[0].no_schedule);
                };
                case.holds(plan, &what);
                let ratio = case.crosses_fast(plan, &what);
                println!("{what}: {ratio:.5}, {:?}, {:.3e} s", plan.coupling, plan.exposed_s);
                worst = worst.max(ratio);
                match plan.coupling {
                    Coupling::MeanChipLoad => {
                        settled += 1;
                        let share = plan.solved_for_s / plan.duration_s;
                        assert!((share - 1.0).abs() < 1.1e-4, "{what}: {share}");
                    }
                    Coupling::Crosses => {
                        held += 1;
                        assert_eq!(plan.solved_for_s, plan.duration_s, "{what}");
                    }
                    other => panic!("{what}: {other:?}"),
                }
            }
        }
    }
    println!("{settled} with the mean chip load, {held} at the programmed feed, worst {worst:.5}");
    assert!(worst < 1.005 && settled > 3 && held > 3, "{worst} {settled} {held}");
}

fn planned(case: &Case, objective: Objective) -> detune::advice::OperationAdvice {
    let options = Options { objective, schedule: true, feed: FeedRule::Programmed };
    advise(&case.job, &options, &silent).unwrap().operations.remove(0)
}

/// Towards the highest speed no schedule on a grid comes nearer to it; for the margin none keeps out of wider bands.
#[test]
fn schedules_follow_the_objective() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let (mut high, mut wide) = (0, 0);
    for index in 0..40 {
        let mut case = random_case(&mut rng);
        case.job.policy.ignore_hz.clear();
        let Spindle { min_rpm, max_rpm, .. } = case.job.spindle;
        let highest = planned(&case, Objective::Highest);
        if let Remedy::Scheduled(plan) = &highest.remedy
            && plan.exposures.is_empty()
        {
            assert_eq!((plan.follows, plan.target_rpm), (Objective::Highest, max_rpm));
            case.holds(plan, &format!("case {index}, highest"));
            let best = case.programme_towards(max_rpm, 1.0, 100, case.duration_s);
            assert!(
                plan.objective <= 1.01 * best + 1e-9,
                "case {index}: {} {best}",
                plan.objective
            );
            high += 1;
        }
        let margin = planned(&case, Objective::Margin);
        if let Remedy::Scheduled(plan) = &margin.remedy
            && plan.exposures.is_empty()
        {
            assert_eq!(plan.follows, Objective::Margin);
            case.holds(plan, &format!("case {index}, margin"));
            let kept = plan.separation.unwrap();
            assert!(kept >= plan.half_width * 0.999, "case {index}: {kept} {}", plan.half_width);
            let constant = margin.constant.and_then(|constant| constant.separation);
            assert!(constant.is_none_or(|constant| kept > constant), "case {index}: {constant:?}");
            // In wider bands a programme on a grid finds no way.
            case.job.policy.separation = 1.03 * plan.half_width - 0.02;
            let beyond =
                case.programme_towards(0.5 * (min_rpm + max_rpm), 1.0, 100, case.duration_s);
            assert!(beyond.is_infinite(), "case {index}: {beyond} beyond {}", plan.half_width);
            wide += 1;
        }
    }
    println!("{high} towards the highest, {wide} for the margin");
    assert!(high > 5 && wide > 5, "{high} {wide}");
}

/// Vibration is not convex, and what crosses keeps no margin: both are told.
#[test]
fn what_a_schedule_cannot_follow_is_told() {
    let waypoints = [[0.0, 0.2], [0.0, 1.2], [0.5, 1.5], [0.5, 2.5]];
    let spindle =
        Spindle { min_rpm: 440.0, max_rpm: 540.0, max_acceleration_rpm_per_s: Some(400.0) };
    let case = case(&waypoints, 480.0, policy(0.03, 1, 0), spindle, &[2]);
    for (objective, follows, told) in [
        (Objective::Nearest, Objective::Nearest, None),
        (Objective::Highest, Objective::Highest, None),
        (Objective::Margin, Objective::Nearest, Some("keeps no margin")),
        (Objective::Vibration, Objective::Nearest, Some("no convex function")),
    ] {
        let options = Options { objective, ..Options::default() };
        let advice = advise(&case.job, &options, &silent).unwrap();
        let Remedy::Scheduled(plan) = &advice.operations[0].remedy else { panic!("{objective:?}") };
        assert_eq!(plan.follows, follows);
        let notices: Vec<&str> = advice.warnings.iter().map(|n| n.what.as_str()).collect();
        match told {
            Some(told) => {
                assert!(notices[0].contains(told) && notices[0].contains("480 rpm"), "{notices:?}");
            }
            None => assert!(notices.is_empty(), "{notices:?}"),
        }
    }
}
