//! Surveys of paths by the batch kernel: against the scalar path station by station, refinement in waves
//! against a recursion, the same bytes on any number of threads, faults in order, no allocation per pose.

use std::sync::Arc;

use std::path::Path as FilePath;
use std::sync::atomic::{AtomicUsize, Ordering};

use detune::model::{Placement, Robot, forward_kinematics};
use detune::motion::{Move, Target, Timing, Work};
use detune::notes::Code;
use detune::path::{Detail, Path, Station, Survey, Surveyor, grid};
use detune::progress::{Done, silent};
use nalgebra::{Isometry3, Translation3, Vector3};
use rayon::{ThreadPool, ThreadPoolBuilder};

const DETAILS: [Detail; 2] = [Detail::Frequencies, Detail::TipResponse];

/// A pose well inside the workspace, wrist bent.
const HOME: [f64; 6] = [0.2, 0.3, -0.2, 0.1, 0.9, -0.4];

fn irb1600() -> Robot {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    detune::input::read_robot(&file, &mut detune::input::Reading::default()).unwrap()
}

fn moves(targets: impl IntoIterator<Item = (Target, Isometry3<f64>)>) -> Vec<Move> {
    let targets = targets.into_iter().enumerate();
    targets
        .map(|(i, (to, tcp))| Move {
            to,
            feed_m_per_s: 0.02,
            tcp,
            work: Work::Stands,
            line: i + 1,
            timing: Timing::Feed,
            spindle_turns: true,
            stated: Arc::default(),
        })
        .collect()
}

/// Two tools that lie apart, the second longer.
fn tools() -> [Isometry3<f64>; 2] {
    [Isometry3::translation(0.03, -0.02, 0.15), Isometry3::translation(0.0, 0.01, 0.4)]
}

/// Joint moves there and back, the tool changed between them.
fn by_joints(robot: &Robot) -> Path<'_> {
    let [short, long] = tools();
    let mut to = HOME;
    (to[0], to[1], to[2], to[4]) = (0.9, -0.3, 0.4, -0.5);
    let row = |q: [f64; 6]| Target::Joints(q.into());
    let all = moves([(row(HOME), short), (row(to), short), (row(HOME), long), (row(to), short)]);
    Path::plan(robot, &all, None).unwrap()
}

/// Straight lines of the tool centre point.
fn by_lines(robot: &Robot) -> Path<'_> {
    let [tool, _] = tools();
    let mut placement = Placement::new(robot);
    placement.place(robot, &HOME);
    let start = forward_kinematics(robot, &placement) * tool;
    let line = |x: f64, y: f64, z: f64| {
        (Target::Line(Translation3::from(Vector3::new(x, y, z)) * start), tool)
    };
    let all = moves([line(0.0, 0.0, 0.0), line(0.15, 0.0, 0.0), line(0.15, 0.2, -0.1)]);
    Path::plan(robot, &all, Some(&HOME)).unwrap()
}

fn take(path: &Path, detail: Detail) -> Survey {
    Survey::take(path, grid(path, std::iter::empty()), detail, &silent).unwrap()
}

#[test]
fn stations_agree_with_the_scalar_path() {
    let robot = irb1600();
    for path in [by_joints(&robot), by_lines(&robot)] {
        let mut surveyor = Surveyor::new(&path);
        for detail in DETAILS {
            let survey = take(&path, detail);
            assert!(survey.len() > 2000);
            for station in survey.stations() {
                let modes = surveyor.modes(station.s).unwrap();
                for (f, e) in station.frequencies_hz.iter().zip(&modes.natural_frequencies_hz) {
                    assert!((f / e - 1.0).abs() < 1e-12, "s = {}: {f}, {e}", station.s);
                }
                let expected = surveyor.tip_response_m_per_n();
                let largest = expected.iter().copied().fold(0.0, f64::max);
                let wanted = if detail == Detail::TipResponse { expected.len() } else { 0 };
                assert_eq!(station.tip_m_per_n.len(), wanted);
                for (c, e) in station.tip_m_per_n.iter().zip(expected) {
                    assert!((c - e).abs() < 1e-11 * largest, "s = {}: {c}, {e}", station.s);
                }
            }
        }
    }
}

/// A station that stands by itself.
type Own = (f64, Vec<f64>, Vec<f64>);

fn view(own: &Own) -> Station<'_> {
    Station { s: own.0, frequencies_hz: &own.1, tip_m_per_n: &own.2 }
}

fn own(station: Station) -> Own {
    (station.s, station.frequencies_hz.to_vec(), station.tip_m_per_n.to_vec())
}

fn raise(a: &Station, b: &Station, factor: f64, rates: &mut [f64]) {
    for ((rate, fa), fb) in rates.iter_mut().zip(a.frequencies_hz).zip(b.frequencies_hz) {
        *rate = rate.max(factor * (fb - fa).abs() / (fa.min(*fb) * (b.s - a.s)));
    }
}

type Wants<'w> = &'w (dyn Fn(&Station, &Station, &[f64]) -> bool + Sync);

/// Stations strictly between two, ascending: each cell halved by itself, depth first.
fn halve(
    path: &Path,
    detail: Detail,
    left: &Own,
    right: &Own,
    rates: &[f64],
    wants: Wants,
) -> Vec<Own> {
    let middle_s = 0.5 * (left.0 + right.0);
    if middle_s <= left.0 || middle_s >= right.0 {
        return Vec::new();
    }
    let middle = own(Survey::take(path, vec![middle_s], detail, &silent).unwrap().station(0));
    let mut rates = rates.to_vec();
    raise(&view(left), &view(&middle), 1.0, &mut rates);
    raise(&view(&middle), &view(right), 1.0, &mut rates);
    let mut inside = Vec::new();
    if wants(&view(left), &view(&middle), &rates) {
        inside = halve(path, detail, left, &middle, &rates, wants);
    }
    inside.push(middle.clone());
    if wants(&view(&middle), &view(right), &rates) {
        inside.extend(halve(path, detail, &middle, right, &rates, wants));
    }
    inside
}

fn by_recursion(path: &Path, detail: Detail, survey: &Survey, wants: Wants) -> Vec<Own> {
    let last = survey.len() - 1;
    let mut all = Vec::new();
    for cell in 0..last {
        let mut rates = vec![0.0; survey.station(cell).frequencies_hz.len()];
        for i in cell.saturating_sub(1)..=(cell + 1).min(last - 1) {
            raise(&survey.station(i), &survey.station(i + 1), 2.0, &mut rates);
        }
        let (left, right) = (own(survey.station(cell)), own(survey.station(cell + 1)));
        all.push(left.clone());
        if wants(&view(&left), &view(&right), &rates) {
            all.extend(halve(path, detail, &left, &right, &rates, wants));
        }
    }
    all.push(own(survey.station(last)));
    all
}

/// Band edges that the modes pass or touch, narrowed down as a check does, with the bound on the slope.
fn near_edge(left: &Station, right: &Station, rates: &[f64]) -> bool {
    const EDGES_HZ: [f64; 4] = [23.0, 26.0, 41.0, 47.0];
    let width = right.s - left.s;
    EDGES_HZ.iter().any(|&edge| {
        (0..rates.len()).any(|r| {
            let (a, b) = (left.frequencies_hz[r], right.frequencies_hz[r]);
            let reach = 0.5 * rates[r] * width * a.max(b);
            let passes = (a > edge) != (b > edge);
            let touches = (0.5 * (a + b) - edge).abs() < reach + 0.5 * (a - b).abs();
            (passes && width > 1e-8) || (touches && width > 1e-6)
        })
    })
}

#[test]
fn waves_find_what_a_recursion_finds() {
    let robot = irb1600();
    for path in [by_joints(&robot), by_lines(&robot)] {
        for detail in DETAILS {
            let first = take(&path, detail);
            let expected = by_recursion(&path, detail, &first, &near_edge);
            let (looked_at, refined) = (first.len(), first.refine(&path, near_edge).unwrap());
            assert!(refined.len() > looked_at + 50, "{} of {looked_at}", refined.len());
            assert_eq!(refined.stations().map(own).collect::<Vec<_>>(), expected);
        }
    }
    // From few stations the slopes are learnt on the way: both halves of a cell must tell of theirs.
    for (path, ends) in [(by_joints(&robot), [0.0, 0.3, 1.0]), (by_lines(&robot), [0.0, 0.6, 1.0])]
    {
        let steep = |left: &Station, right: &Station, rates: &[f64]| {
            let width = right.s - left.s;
            width > 1e-3 && rates.iter().any(|rate| rate * width > 0.02)
        };
        let first = Survey::take(&path, ends.into(), Detail::Frequencies, &silent).unwrap();
        let expected = by_recursion(&path, Detail::Frequencies, &first, &steep);
        let refined = first.refine(&path, steep).unwrap();
        assert_eq!(refined.stations().map(own).collect::<Vec<_>>(), expected);
    }
    // Where everything is always wanted, halving ends where there is nothing between two numbers.
    let path = by_joints(&robot);
    let ends = vec![0.5, 0.5 + 4.0 * f64::EPSILON];
    let survey = Survey::take(&path, ends, Detail::Frequencies, &silent).unwrap();
    let whole = survey.refine(&path, |_, _, _| true).unwrap();
    assert_eq!(whole.len(), 9);
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

#[test]
fn threads_change_no_bit() {
    let robot = irb1600();
    for path in [by_joints(&robot), by_lines(&robot)] {
        for detail in DETAILS {
            let on = |threads| {
                pool(threads).install(|| take(&path, detail).refine(&path, near_edge).unwrap())
            };
            let one = on(1);
            for threads in [2, 3] {
                assert_eq!(on(threads), one, "{threads} threads, {detail:?}");
            }
        }
    }
}

#[test]
fn every_station_is_told_once() {
    let robot = irb1600();
    let path = by_joints(&robot);
    let stations = grid(&path, std::iter::empty());
    let (count, told) = (stations.len(), AtomicUsize::new(0));
    let tell = |done: Done| {
        let Done::More(more) = done else { panic!("{done:?}") };
        told.fetch_add(more, Ordering::Relaxed);
    };
    Survey::take(&path, stations, Detail::Frequencies, &tell).unwrap();
    assert_eq!(told.load(Ordering::Relaxed), count);
}

/// A spring that gravity overcomes along a part of the path.
#[test]
fn the_first_fault_in_order_is_the_one_that_is_told() {
    let mut description = crate::planar_arm::two_link();
    description.gravity_stiffness = true;
    description.elastic_joints[1].stiffness = 20.0;
    let robot = Robot::new(&description).unwrap();
    let tool = Isometry3::identity();
    let row = |q: [f64; 2]| (Target::Joints(q.into()), tool);
    let there_and_back = moves([row([0.0, -1.9]), row([0.0, 2.0]), row([0.0, -1.9])]);
    let path = Path::plan(&robot, &there_and_back, None).unwrap();
    let stations = grid(&path, std::iter::empty());
    let mut surveyor = Surveyor::new(&path);
    let first = stations.iter().find_map(|&s| surveyor.frequencies_hz(s).err()).unwrap();
    assert!(first.code == Code::Singular && !first.what.contains("s = 0.0000"), "{first:?}");
    for detail in DETAILS {
        for threads in [1, 2] {
            let found = pool(threads)
                .install(|| Survey::take(&path, stations.clone(), detail, &silent).unwrap_err());
            assert_eq!(found, first);
        }
    }
    // Behind a change of the tool it still has its own place.
    let mut two_tools = there_and_back.clone();
    two_tools.insert(1, Move { to: Target::Joints(vec![0.0, -1.85]), ..two_tools[0].clone() });
    two_tools[2].tcp = Isometry3::translation(0.1, 0.0, 0.0);
    let two_tools = Path::plan(&robot, &two_tools, None).unwrap();
    let mut slow = Surveyor::new(&two_tools);
    let stations = grid(&two_tools, std::iter::empty());
    let (s, fault) = stations.iter().find_map(|&s| Some((s, slow.modes(s).err()?))).unwrap();
    let found = Survey::take(&two_tools, vec![0.0, s], Detail::TipResponse, &silent);
    assert_eq!(found, Err(fault));
    // Only a refinement comes upon it: both ends stand firm.
    let firm: Vec<f64> = [0.0, 1.0].into_iter().filter(|&s| surveyor.modes(s).is_ok()).collect();
    assert_eq!(firm.len(), 2);
    let survey = Survey::take(&path, firm, Detail::Frequencies, &silent).unwrap();
    let found = survey.refine(&path, |_, _, _| true).unwrap_err();
    assert!(found.code == Code::Singular && found.what.contains("stiffness"), "{found}");
}

/// A place on a line that the arm does not get to, and a pose at fault, whichever comes first.
#[test]
fn a_way_that_ends_is_told_at_its_place() {
    let robot = irb1600();
    let path = by_lines(&robot);
    for before in [0, 1, 7, 300] {
        let mut stations: Vec<f64> = (0..before).map(|i| 1e-3 * f64::from(i)).collect();
        stations.extend([f64::NAN, 0.5, f64::NAN]);
        for detail in DETAILS {
            let fault = Survey::take(&path, stations.clone(), detail, &silent).unwrap_err();
            assert!(fault.code == Code::Unreachable && fault.what.contains("s = NaN"), "{fault}");
        }
    }
}

#[test]
fn surveys_do_not_allocate_per_pose() {
    let robot = irb1600();
    // The calling thread is the pool, as only its allocations are counted.
    let pool = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    let path = by_joints(&robot);
    for detail in DETAILS {
        let counted = |count: u32| {
            let s: Vec<f64> = (0..count).map(|i| f64::from(i) / f64::from(count)).collect();
            let take = || Survey::take(&path, s, detail, &silent).unwrap();
            let mut survey = None;
            let counted = allocation_counter::measure(|| survey = Some(pool.install(take)));
            assert_eq!(survey.unwrap().len(), count as usize);
            counted.count_total
        };
        let (few, many) = (counted(40_000), counted(80_000));
        assert!(few > 0, "the counter does not count");
        assert!(many - few < 40_000 / 10, "{few} allocations, {many} for twice as many poses");
    }
}

/// Stations that are known keep their bytes and are not solved again.
#[test]
fn known_stations_are_not_solved_again() {
    let robot = irb1600();
    let path = by_lines(&robot);
    let stations = grid(&path, std::iter::empty());
    for detail in DETAILS {
        let known: Vec<f64> = stations.iter().copied().step_by(3).collect();
        let first = Survey::take(&path, known.clone(), detail, &silent).unwrap();
        let solved = AtomicUsize::new(0);
        let count = |done: Done| {
            let Done::More(more) = done else { panic!("{done:?}") };
            solved.fetch_add(more, Ordering::Relaxed);
        };
        let found = first.at_stations(&path, &stations, &count).unwrap();
        assert_eq!(found, Survey::take(&path, stations.clone(), detail, &silent).unwrap());
        assert_eq!(solved.load(Ordering::Relaxed), stations.len() - known.len());
    }
}
