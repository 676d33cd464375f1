//! Safe speeds against a brute-force scan that shares no code with the crate: closed-form frequencies and
//! tip response of a two-link arm (Pietruś & Gierlak 2023, Eq. 45) at 20 000 points of the path, and every
//! tenth of a rev/min.

use std::path::PathBuf;
use std::sync::Arc;

use detune::advice::{Binding, Change, Objective, Options, Remedy, advise};
use detune::job::{Carried, Job, Levers, Operation, Policy, Review, Spindle, SpindleSpeed, Tool};
use detune::model::Robot;
use detune::motion::{Move, Target, Timing, Work};
use detune::progress::silent;
use detune::risk::{Verdict, assess};
use nalgebra::Isometry3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::planar_arm::{I_A, I_S2, K1, L1, L2, LC2, M2, closed_form_hz, two_link};

const POINTS: usize = 20_000;
const STEP_RPM: f64 = 0.1;

fn job(robot: &Arc<Robot>, waypoints: &[[f64; 2]], rpm: f64, teeth: u32, policy: Policy) -> Job {
    let moves = waypoints.iter().enumerate().map(|(i, q)| Move {
        to: Target::Joints(q.to_vec()),
        feed_m_per_s: 0.01,
        tcp: Isometry3::identity(),
        work: Work::Stands,
        line: 10 + i,
        timing: Timing::Feed,
        spindle_turns: true,
        stated: Arc::default(),
    });
    Job {
        name: "held out".into(),
        file: PathBuf::from("job.yaml"),
        robot: robot.clone(),
        spindle: Spindle { min_rpm: 400.0, max_rpm: 6000.0, max_acceleration_rpm_per_s: None },
        operations: vec![Operation::new(
            robot,
            Carried::NOTHING,
            Tool { teeth, ..Tool::default() },
            SpindleSpeed::Constant(rpm),
            0.01,
            moves.collect(),
        )],
        policy,
        levers: Levers::default(),
        review: Review::default(),
    }
}

/// What each mode alone moves the tip at resonance, m/N: shapes of the 2 × 2 problem by hand.
fn closed_form_tip(beta2: f64) -> [f64; 2] {
    let c = beta2.cos();
    let (a2, a3) = (M2 * L1 * LC2, I_S2 + M2 * LC2 * LC2);
    let m11 = I_A + M2 * L1 * L1 + a3 + 2.0 * a2 * c;
    let m12 = a3 + a2 * c;
    closed_form_hz(beta2).map(|f| {
        let square = (std::f64::consts::TAU * f).powi(2);
        let (u, v) = (square * m12, K1 - square * m11);
        let mass = m11 * u * u + 2.0 * m12 * u * v + a3 * v * v;
        // Across link 1 and across link 2, which stands at β2 to it.
        let (x, y) = (L1 * u + L2 * (u + v) * c, L2 * (u + v) * beta2.sin());
        (x * x + y * y) / mass / (2.0 * 0.02 * square)
    })
}

/// β2 at equal steps of each segment: which speeds are safe depends on the poses alone, not on when they
/// are passed.
fn scan_angles(waypoints: &[[f64; 2]]) -> Vec<f64> {
    let per_segment = POINTS / (waypoints.len() - 1);
    waypoints
        .windows(2)
        .flat_map(|w| {
            (0..=per_segment)
                .map(move |i| w[0][1] + (w[1][1] - w[0][1]) * i as f64 / per_segment as f64)
        })
        .collect()
}

/// Whether each speed of the scan is safe.
fn scan(angles: &[f64], orders: &[u32], policy: &Policy, spindle: &Spindle) -> Vec<(f64, bool)> {
    let wide = policy.separation + policy.model_uncertainty.unwrap();
    // Sorted, so that "some point has |f_exc − f| < f · wide" is one look.
    let sorted: Vec<Vec<f64>> = (0..2)
        .map(|mode| {
            let mut all: Vec<f64> = angles
                .iter()
                .filter(|&&b| closed_form_tip(b)[mode] >= policy.min_tip_response_m_per_n.unwrap())
                .map(|&b| closed_form_hz(b)[mode])
                .collect();
            all.sort_by(f64::total_cmp);
            all
        })
        .collect();
    let steps = ((spindle.max_rpm - spindle.min_rpm) / STEP_RPM).round() as usize;
    (0..=steps)
        .map(|i| {
            let rpm = spindle.min_rpm + i as f64 * STEP_RPM;
            let is_hit = orders.iter().any(|&order| {
                let line = f64::from(order) * rpm / 60.0;
                let ignored = is_ignored(policy, line);
                let hits = |f: &Vec<f64>| {
                    let first = f.partition_point(|&f| f <= line / (1.0 + wide));
                    f.get(first).is_some_and(|&f| wide >= 1.0 || f < line / (1.0 - wide))
                };
                !ignored && sorted.iter().any(hits)
            });
            // Where every line is ignored, nothing would be checked.
            (rpm, !is_hit && !all_ignored(orders, policy, rpm))
        })
        .collect()
}

fn is_ignored(policy: &Policy, line_hz: f64) -> bool {
    policy.ignore_hz.iter().any(|band| band[0] <= line_hz && line_hz <= band[1])
}

fn all_ignored(orders: &[u32], policy: &Policy, rpm: f64) -> bool {
    orders.iter().all(|&order| is_ignored(policy, f64::from(order) * rpm / 60.0))
}

fn random_case(rng: &mut ChaCha8Rng, masks: bool) -> (Vec<[f64; 2]>, u32, f64, Policy) {
    let n = rng.random_range(2..6);
    let waypoints: Vec<[f64; 2]> =
        (0..n).map(|_| [rng.random_range(-1.0..2.5), rng.random_range(-2.6..2.6)]).collect();
    let teeth = rng.random_range(1..5);
    let mut policy = Policy {
        tooth_passing_harmonics: rng.random_range(1..4),
        spindle_harmonics: rng.random_range(0..3),
        separation: rng.random_range(0.005..0.08),
        model_uncertainty: Some(rng.random_range(0.0..0.08)),
        confidence: 0.95,
        ignore_hz: vec![],
        min_tip_response_m_per_n: Some(0.0),
        max_deflection_m: None,
        max_vibration_m: None,
    };
    if masks {
        let f = rng.random_range(10.0..90.0);
        policy.ignore_hz.push([f, f * rng.random_range(1.0..1.3)]);
        policy.ignore_hz.push([f * 1.1, f * rng.random_range(1.1..1.6)]);
        let tips: Vec<f64> =
            scan_angles(&waypoints).iter().map(|&b| closed_form_tip(b)[1]).collect();
        let (low, high) = (
            tips.iter().copied().fold(f64::INFINITY, f64::min),
            tips.iter().copied().fold(0.0, f64::max),
        );
        policy.min_tip_response_m_per_n = Some(low + (high - low) * rng.random_range(0.1..0.9));
    }
    (waypoints, teeth, rng.random_range(400.0..6000.0), policy)
}

fn orders(teeth: u32, policy: &Policy) -> Vec<u32> {
    let teeth_lines = (1..=policy.tooth_passing_harmonics).map(|h| h * teeth);
    (1..=policy.spindle_harmonics).chain(teeth_lines).collect()
}

/// At every speed of the scan that lies more than 0.3 rev/min from an end of a told interval, scan and
/// intervals agree: so ends agree within 0.3, no gap wider than that is missed and none is made up.
#[test]
fn safe_speeds_agree_with_a_scan() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut gaps, mut masked_gaps, mut disagreements) = (0, 0, 0);
    for case in 0..60 {
        let (waypoints, teeth, rpm, policy) = random_case(&mut rng, case % 2 == 1);
        let job = job(&robot, &waypoints, rpm, teeth, policy.clone());
        let advice = advise(&job, &Options::default(), &silent).unwrap();
        let safe = &advice.operations[0].set.safe;
        assert!(safe.windows(2).all(|w| w[0].high_rpm < w[1].low_rpm), "{safe:?}");
        gaps += safe.len();
        masked_gaps += if case % 2 == 1 { safe.len() } else { 0 };
        let scanned =
            scan(&scan_angles(&waypoints), &orders(teeth, &policy), &policy, &job.spindle);
        for (rpm, expected) in scanned {
            let told = safe.iter().any(|gap| gap.contains(rpm));
            let near_end = safe
                .iter()
                .any(|gap| (gap.low_rpm - rpm).abs() <= 0.3 || (gap.high_rpm - rpm).abs() <= 0.3);
            if told != expected {
                disagreements += 1;
                assert!(
                    near_end,
                    "case {case}: {rpm} rpm: told {told}, scanned {expected}; {safe:?}"
                );
            }
        }
    }
    println!(
        "{gaps} gaps, {masked_gaps} of them under masks, {disagreements} speeds within 0.3 rpm of an end"
    );
    assert!(gaps > 150 && masked_gaps > 50);
}

/// What is recommended is clear in a check, lies inside the safe set, and is the nearest, the highest, or
/// keeps the largest separation that a scan of separations finds.
#[test]
fn recommended_speeds_are_clear_and_the_best() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut recommended = 0;
    for case in 0..40 {
        let (waypoints, teeth, rpm, policy) = random_case(&mut rng, case % 2 == 1);
        let mut job = job(&robot, &waypoints, rpm, teeth, policy.clone());
        for objective in [Objective::Nearest, Objective::Margin, Objective::Highest] {
            job.operations[0].speed = SpindleSpeed::Constant(rpm);
            let options = Options { objective, ..Options::default() };
            let advice = advise(&job, &options, &silent).unwrap();
            let operation = &advice.operations[0];
            let Remedy::Constant(constant) = &operation.remedy else {
                assert!(operation.set.safe.iter().all(|gap| gap.high_rpm - gap.low_rpm < 0.1));
                continue;
            };
            recommended += 1;
            assert!(operation.set.safe.iter().any(|gap| gap.contains(constant.rpm)));
            assert!(advice.is_clear());
            let chip = constant.feed_m_per_s / constant.rpm - 0.01 / rpm;
            assert!(chip.abs() < 1e-15);
            job.operations[0].speed = SpindleSpeed::Constant(constant.rpm);
            let risk = assess(&job, &silent).unwrap();
            // Where no mode moves the tip enough to count, there is nothing to check.
            let counts = risk.operations[0].closest.is_some();
            let clear = if counts { Verdict::Clear } else { Verdict::Unchecked };
            assert_eq!(risk.verdict, clear, "case {case}, {objective:?}");
            let ends = operation.set.safe.iter().flat_map(|gap| [gap.low_rpm, gap.high_rpm]);
            match objective {
                Objective::Nearest => {
                    let inside = operation.set.safe.iter().any(|gap| gap.contains(rpm));
                    let least = ends.map(|end| (end - rpm).abs()).fold(f64::INFINITY, f64::min);
                    let allowed = if inside { 0.1 } else { least + 1.1 };
                    assert!((constant.rpm - rpm).abs() <= allowed, "case {case}");
                }
                Objective::Highest => {
                    assert!(constant.rpm >= ends.fold(0.0, f64::max) - 1.1, "case {case}");
                }
                Objective::Margin => {
                    let separations = Separations::new(&waypoints, teeth, &policy);
                    let found = separations.least(constant.rpm);
                    if let (Some(found), Some(told)) = (found, constant.separation) {
                        // The scan's points are 1e-3 apart.
                        assert!(found > told - 1e-9, "case {case}: {found} {told}");
                        assert!(found - told < 1e-3 * (1.0 + told), "case {case}: {found} {told}");
                    }
                    let mut best: Option<f64> = Some(0.0);
                    for i in 0..=700 {
                        let rpm = 400.0 + 8.0 * f64::from(i);
                        if all_ignored(&orders(teeth, &policy), &policy, rpm) {
                            continue;
                        }
                        let at = separations.least(rpm);
                        best = best.and_then(|best| at.map(|at| best.max(at)));
                    }
                    match (found, best) {
                        (Some(found), Some(best)) => {
                            assert!(found > best - 2e-3, "case {case}: {found} {best}");
                        }
                        // No mode moves the tip enough to count.
                        (found, best) => {
                            assert!(found.is_none(), "case {case}: {found:?} {best:?}")
                        }
                    }
                }
                Objective::Vibration | Objective::Depth => unreachable!(),
            }
        }
    }
    assert!(recommended > 60, "{recommended}");
}

/// What a scan of separations looks at: of each mode the frequencies at 2000 points where it counts, ascending.
struct Separations<'a> {
    sorted: [Vec<f64>; 2],
    orders: Vec<u32>,
    policy: &'a Policy,
}

impl<'a> Separations<'a> {
    fn new(waypoints: &[[f64; 2]], teeth: u32, policy: &'a Policy) -> Self {
        let angles: Vec<f64> = scan_angles(waypoints).into_iter().step_by(POINTS / 2000).collect();
        let sorted = [0, 1].map(|mode| {
            let counts =
                |b: &f64| closed_form_tip(*b)[mode] >= policy.min_tip_response_m_per_n.unwrap();
            let counted = angles.iter().filter(|b| counts(b));
            let mut all: Vec<f64> = counted.map(|&b| closed_form_hz(b)[mode]).collect();
            all.sort_by(f64::total_cmp);
            all
        });
        Self { sorted, orders: orders(teeth, policy), policy }
    }

    /// The least |f_exc − f| / f; `None` where nothing counts.
    fn least(&self, rpm: f64) -> Option<f64> {
        let lines = self.orders.iter().map(|&order| f64::from(order) * rpm / 60.0);
        let lines = lines.filter(|&line| !is_ignored(self.policy, line));
        let apart = lines.flat_map(|line| {
            self.sorted.iter().flat_map(move |f| {
                // It grows with the distance on either side of the line: the two beside it decide.
                let above = f.partition_point(|&f| f < line);
                let beside = &f[above.saturating_sub(1)..(above + 1).min(f.len())];
                beside.iter().map(move |f| (line - f).abs() / f)
            })
        });
        apart.reduce(f64::min)
    }
}

/// Bands so wide that they close everything: no number, and the pair that would part last is the one that
/// a scan of separations finds.
#[test]
fn an_infeasible_job_names_what_binds_it() {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut seen, mut spindles) = (0, 0);
    for case in 0..30 {
        let (waypoints, teeth, rpm, mut policy) = random_case(&mut rng, false);
        (policy.separation, policy.model_uncertainty) = (0.5, Some(0.3));
        let mut job = job(&robot, &waypoints, rpm, teeth, policy.clone());
        job.spindle.max_rpm = 1500.0;
        let advice = advise(&job, &Options::default(), &silent).unwrap();
        let operation = &advice.operations[0];
        if operation.constant.is_some() {
            continue;
        }
        seen += 1;
        assert!(operation.set.safe.is_empty() && !matches!(operation.remedy, Remedy::Constant(_)));
        let Some(Binding { rpm, separation: told, below, above }) = operation.bind else {
            panic!("case {case}")
        };
        let separations = Separations::new(&waypoints, teeth, &policy);
        let best =
            (0..=1100).filter_map(|i| separations.least(400.0 + f64::from(i))).fold(0.0, f64::max);
        assert!((told.max(0.0) - best).abs() < 3e-3, "case {case}: {told} {best}");
        assert!(below.is_some() || rpm < 400.1, "case {case}");
        assert!(above.is_some() || rpm > 1499.9, "case {case}");
        // The pairs that are named are as near as told.
        for block in [below, above].into_iter().flatten() {
            let line = f64::from(block.line.order) * rpm / 60.0;
            let nearest = scan_angles(&waypoints)
                .into_iter()
                .map(|b| closed_form_hz(b)[block.mode - 1])
                .map(|f| (line - f).abs() / f)
                .fold(f64::INFINITY, f64::min);
            assert!((nearest - told.max(0.0)).abs() < 3e-3, "case {case}: {nearest} {told}");
        }
        // Another spindle is a way out where one can be bought that runs at that speed; what it must
        // run at keeps its distance.
        let lever = operation.levers.iter().find(|l| matches!(l.change, Change::Spindle { .. }));
        let Some(Change::Spindle { rpm }) = lever.map(|lever| &lever.change) else { continue };
        spindles += 1;
        assert!(!(400.0..=1500.0).contains(rpm) && (320.0..=3000.0).contains(rpm), "{rpm}");
        let apart = separations.least(*rpm).unwrap();
        assert!(apart >= 0.8 - 1e-9, "case {case}: {rpm} rpm keeps {apart}");
        assert!(operation.levers[0].rpm.is_some());
    }
    assert!(seen > 15 && spindles > 0, "{seen} {spindles}");
}
