//! Paths in time: where the tool centre point is at every s, how long moves take, and what is said about
//! paths that cannot be run.

use std::path::Path as FilePath;
use std::sync::Arc;

use detune::model::{InverseKinematics, Placement, Robot, forward_kinematics};
use detune::motion::{Configuration, Move, Sides, Stated, Target, Timing, Turning, Work};
use detune::notes::{Code, Note, Part};
use detune::path::{MAX_GAP, MAX_STEP, Path, grid};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

const FEED: f64 = 0.02;

fn irb1600() -> Robot {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    detune::input::read_robot(&file, &mut detune::input::Reading::default()).unwrap()
}

/// A tool that lies off the axis of joint 6.
fn tool() -> Isometry3<f64> {
    Isometry3::new(Vector3::new(0.03, -0.02, 0.15), Vector3::new(0.1, 0.5, 0.0))
}

fn tcp_pose(robot: &Robot, q: &[f64], tcp: &Isometry3<f64>) -> Isometry3<f64> {
    let mut placement = Placement::new(robot);
    placement.place(robot, q);
    forward_kinematics(robot, &placement) * tcp
}

fn moves(targets: Vec<Target>, tcp: Isometry3<f64>) -> Vec<Move> {
    targets
        .into_iter()
        .enumerate()
        .map(|(i, to)| Move {
            to,
            feed_m_per_s: FEED,
            tcp,
            work: Work::Stands,
            line: 20 + i,
            timing: Timing::Feed,
            spindle_turns: true,
            stated: Arc::default(),
        })
        .collect()
}

/// A pose well inside the workspace, wrist bent.
const HOME: [f64; 6] = [0.2, 0.3, -0.2, 0.1, 0.9, -0.4];

fn shifted(pose: &Isometry3<f64>, by: [f64; 3], turn: [f64; 3]) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::from(pose.translation.vector + Vector3::from(by)),
        UnitQuaternion::from_scaled_axis(turn.into()) * pose.rotation,
    )
}

/// Axis 4 of the wrist is at 0.1 rad, or turned over at 0.1 ± π with axis 5 the other way: the
/// program's quadrant chooses. Where none is in it, the nearest is taken and named; further off than
/// a quadrant, the target is refused.
#[test]
fn the_arm_configuration_of_a_program_is_kept_named_or_refused() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let robot = irb1600();
    let asked = |joint: usize, low: f64, high: f64| {
        // Not reaching over backwards.
        let joints = vec![(0, [0.0, FRAC_PI_2]), (joint, [low, high])];
        let configuration = Configuration { shown: "its quadrant".to_owned(), joints, sides: None };
        let mut moves = moves(
            vec![Target::Joints(vec![0.0; 6]), Target::JointsTo(tcp_pose(&robot, &HOME, &tool()))],
            tool(),
        );
        let configuration = Some(Arc::new(configuration));
        moves[1].stated = Arc::new(Stated { configuration, ..Stated::default() });
        moves
    };
    for (low, high, axis_4, axis_5, is_named) in [
        (0.0, FRAC_PI_2, 0.1, 0.9, false),
        (-PI, -FRAC_PI_2, 0.1 - PI, -0.9, false),
        (-FRAC_PI_2, 0.0, 0.1, 0.9, true),
        (FRAC_PI_2, PI, 0.1 + PI, -0.9, true),
    ] {
        let path = Path::plan(&robot, &asked(3, low, high), None).unwrap();
        let mut q = vec![0.0; 6];
        path.reader().at(1.0, &mut q).unwrap();
        assert!((q[3] - axis_4).abs() < 1e-9 && (q[4] - axis_5).abs() < 1e-9, "{low} {q:?}");
        match path.beside_configuration() {
            None => assert!(!is_named, "{low}"),
            Some((line, what, others)) => {
                assert!(is_named && line == 21 && others == 0, "{low} {line} {others}");
                assert!(what.starts_with("its quadrant: ["), "{what}");
            }
        }
    }
    // Axis 5 is at 0.9 rad. A controller keeps the sign or the turn of an axis, and of quadrants it
    // takes the nearest.
    for (low, high, is_missed) in [(1.0, 20.0, true), (1.0, 1.0 + FRAC_PI_2, false)] {
        let path = Path::plan(&robot, &asked(4, low, high), None).unwrap();
        assert!(path.beside_configuration().is_some());
        assert_eq!(path.misses_configuration(), is_missed);
    }
    let refused = Path::plan(&robot, &asked(2, 2.8, 3.0), None).unwrap_err();
    assert!(refused[0].what.contains("asks for its quadrant"), "{refused:?}");
}

fn named(moves: &mut [Move], names: &[(usize, &str)]) {
    for &(index, name) in names {
        let is = |one, other| match name {
            _ if name.contains(one) => Some(true),
            _ if name.contains(other) => Some(false),
            _ => None,
        };
        let sides =
            Sides { name: name.into(), as_at_zero: [is("front", "back"), is("up", "down")] };
        let asked = Configuration { shown: name.into(), joints: vec![], sides: Some(sides) };
        moves[index].stated =
            Arc::new(Stated { configuration: Some(asked.into()), ..Stated::default() });
    }
}

fn end(path: &Path) -> [f64; 6] {
    let mut q = [0.0; 6];
    path.reader().at(1.0, &mut q).unwrap();
    q
}

/// A target behind the arm is nearer over the back. Where the program has one name for the arm configurations, axis 1
/// turns there, also behind a position in joints; where nothing has told what the name means, the nearest is doubted.
#[test]
fn an_arm_that_keeps_its_configuration_does_not_reach_over_its_back() {
    let robot = irb1600();
    // By the inverse kinematics of its dimensions over the back at (0.84, -0.84, -0.11, -3.14, 1.89, 0): 1.7 rad away
    // and not 3.6.
    let (before, behind) = ([0.8, -0.8, -0.1, -1.5, 1.7, 0.0], [-2.3, -0.8, -0.1, 0.0, 0.6, 0.0]);
    // The wrist at its singularity, which says nothing of shoulder and elbow.
    let straight = [0.8, -0.8, -0.1, -1.5, 0.0, 0.0];
    let reaching = |q: &[f64]| Target::JointsTo(tcp_pose(&robot, q, &tool()));
    let joints = |q: [f64; 6]| Target::Joints(q.into());
    let plan = |targets: Vec<Target>, names: &[(usize, &str)], start: &[f64]| {
        let mut moves = moves(targets, tool());
        named(&mut moves, names);
        Path::plan(&robot, &moves, Some(start))
    };
    let is_behind = |path: &Path| {
        let off = end(path).iter().zip(behind).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        off < 1e-9
    };
    let other = |path: &Path| path.open_sides().map(|(line, name)| (line, name.to_owned()));
    let two = || vec![joints(before), reaching(&behind)];
    let free = plan(two(), &[], &before).unwrap();
    assert!(!is_behind(&free) && other(&free).is_none());
    let unknown = plan(two(), &[(1, "NUT")], &before).unwrap();
    assert!(!is_behind(&unknown));
    assert_eq!(other(&unknown), Some((21, "NUT".to_owned())));
    for start in [before, straight] {
        let from = [reaching(&start), joints(before), reaching(&behind)];
        let known = plan(from.to_vec(), &[(0, "NUT"), (2, "NUT")], &start).unwrap();
        assert!(is_behind(&known) && other(&known).is_none(), "{:?}", end(&known));
        // Another name is not known.
        let unknown = plan(from.to_vec(), &[(0, "NUT"), (2, "NUB")], &start).unwrap();
        assert_eq!(other(&unknown), Some((22, "NUB".to_owned())));
    }
    // Near by no other is meant, unless its name says so; at zero the wrist is in front and the elbow up.
    let near = [0.8, -0.7, -0.1, -1.5, 1.7, 0.0];
    for (name, is_open) in [
        ("NUT", false),
        ("up front", false),
        ("down front", true),
        ("up back", true),
        ("up", false),
    ] {
        let near = plan(vec![joints(before), reaching(&near)], &[(1, name)], &before).unwrap();
        assert_eq!(other(&near).is_some(), is_open, "{name}");
    }
    // The elbow of the arm before would need axis 2 beyond its limit, or the other shoulder.
    let over = reaching(&[0.8, -1.2, -0.4, 0.0, 1.1, 0.0]);
    let refused = plan(vec![reaching(&before), over], &[(0, "NUT"), (1, "NUT")], &before);
    let refused = refused.unwrap_err();
    let told = "asks for NUT here, and no joint positions in it reach the pose";
    assert!(refused[0].code == Code::Unreachable && refused[0].what.contains(told), "{refused:?}");
}

/// The track does not matter for shoulder and elbow.
#[test]
fn an_arm_on_a_track_keeps_its_configuration() {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/rail-mill/robot.yaml");
    let robot = detune::input::read_robot(&file, &mut detune::input::Reading::default()).unwrap();
    let kinematics = InverseKinematics::new(&robot);
    let arm = |q: &[f64]| kinematics.sides(q);
    let at: Vec<f64> = [vec![0.4], HOME.to_vec()].concat();
    let elsewhere: Vec<f64> = [vec![-1.0], HOME.to_vec()].concat();
    assert!(arm(&at).iter().all(Option::is_some) && arm(&at) == arm(&elsewhere));
}

/// A track has no turns: 0.3 m and 0.3 m − 2π are not the same place.
#[test]
fn a_sliding_axis_makes_no_whole_turn_into_a_configuration() {
    // Of 20 m, so that both are within its limits.
    let long = tempfile::tempdir().unwrap();
    for name in ["robot.yaml", "rail-mill.urdf"] {
        let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/rail-mill").join(name);
        let text = std::fs::read_to_string(file).unwrap();
        let text = text.replace("lower=\"-2.5\" upper=\"2.5\"", "lower=\"-10\" upper=\"10\"");
        std::fs::write(long.path().join(name), text).unwrap();
    }
    let file = long.path().join("robot.yaml");
    let robot = detune::input::read_robot(&file, &mut detune::input::Reading::default()).unwrap();
    let track = robot.joints().iter().position(|joint| joint.name == "track").unwrap();
    let mut at = vec![0.1; robot.joints().len()];
    at[track] = 0.3;
    let pose = tcp_pose(&robot, &at, &tool());
    let mut moves = moves(vec![Target::Joints(at), Target::JointsTo(pose)], tool());
    let shown = "its side of the track".to_owned();
    let configuration = Configuration { shown, joints: vec![(track, [-20.0, 0.0])], sides: None };
    let configuration = Some(Arc::new(configuration));
    moves[1].stated = Arc::new(Stated { configuration, ..Stated::default() });
    match Path::plan(&robot, &moves, None) {
        Err(refused) => assert!(refused[0].what.contains("asks for its side"), "{refused:?}"),
        Ok(path) => {
            let mut q = vec![0.0; robot.joints().len()];
            path.reader().at(1.0, &mut q).unwrap();
            let there = tcp_pose(&robot, &q, &tool());
            assert!((there.translation.vector - pose.translation.vector).norm() < 1e-6, "{q:?}");
            assert!(path.beside_configuration().is_some() || q[track] <= 0.0, "{q:?}");
        }
    }
}

/// A stretch of a path has the joints of the whole, knot by knot, and its share of the time.
#[test]
fn stretches_are_parts_of_the_whole_path() {
    let robot = irb1600();
    let home = tcp_pose(&robot, &HOME, &tool());
    let to = |x: f64, z: f64| shifted(&home, [x, 0.0, z], [0.0; 3]);
    let targets = vec![
        Target::Line(home),
        Target::Line(to(0.05, 0.0)),
        Target::Line(to(0.05, 0.0)),
        Target::JointsTo(to(0.0, 0.05)),
        Target::Line(to(-0.05, 0.02)),
    ];
    let moves = moves(targets, tool());
    let whole = Path::plan(&robot, &moves, Some(&HOME)).unwrap();
    let joints = |path: &Path, s: f64| {
        let mut q = vec![0.0; 6];
        path.reader().at(s, &mut q).unwrap();
        q
    };
    let of_whole: Vec<Vec<f64>> = whole.knots_s().iter().map(|&s| joints(&whole, s)).collect();
    let (mut until_s, mut knots) = (0.0, 0);
    for stretch in [0..2, 2..3, 3..4, 4..5] {
        let part = whole.stretch(&moves, stretch.clone(), &robot);
        for (i, &s) in part.knots_s().iter().enumerate() {
            assert_eq!(joints(&part, s), of_whole[knots + i], "{stretch:?} at {s}");
        }
        assert_eq!(part.line_at(0.5), moves[stretch.end - 1].line);
        let share = part.duration_s() / whole.duration_s();
        for i in 0..=10 {
            let s = f64::from(i) / 10.0;
            let (a, b) = (joints(&part, s), joints(&whole, (until_s + s * share).min(1.0)));
            assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9), "{stretch:?} {s}");
        }
        knots += part.knots_s().len() - 1;
        until_s += share;
    }
    assert_eq!(knots, of_whole.len() - 1);
    assert!((until_s - 1.0).abs() < 1e-12);
}

#[test]
fn a_line_is_straight_in_space_and_even_in_time() {
    let robot = irb1600();
    let a = tcp_pose(&robot, &HOME, &tool());
    let b = shifted(&a, [0.1, 0.0, 0.0], [0.0, 0.0, 0.3]);
    let c = shifted(&b, [0.0, 0.2, -0.2], [0.2, 0.0, 0.0]);
    let path = Path::plan(
        &robot,
        &moves(vec![Target::Line(a), Target::Line(b), Target::Line(c)], tool()),
        Some(&HOME),
    )
    .unwrap();
    let first = 0.1;
    let second = 0.2 * 2.0_f64.sqrt();
    assert!((path.duration_s() - (first + second) / FEED).abs() < 1e-9);
    let mut reader = path.reader();
    let mut q = [0.0; 6];
    let mut before: Option<[f64; 6]> = None;
    for i in 0..=400 {
        let s = f64::from(i) / 400.0;
        let way = s * (first + second);
        let (from, to, u) =
            if way <= first { (a, b, way / first) } else { (b, c, (way - first) / second) };
        let expected = from.translation.vector.lerp(&to.translation.vector, u);
        let turned = from.rotation.slerp(&to.rotation, u);
        reader.at(s, &mut q).unwrap();
        let found = tcp_pose(&robot, &q, &tool());
        assert!((found.translation.vector - expected).norm() < 1e-10, "at s = {s}");
        assert!(found.rotation.angle_to(&turned) < 1e-7, "at s = {s}");
        if let Some(before) = before {
            let jump = (0..6).map(|i| (q[i] - before[i]).abs()).fold(0.0, f64::max);
            assert!(jump < 0.02, "the branch jumps by {jump} at s = {s}");
        }
        before = Some(q);
    }
    assert_eq!((path.line_at(0.1), path.line_at(0.9)), (21, 22));
    let corner = first / (first + second);
    assert_eq!((path.line_at(corner - 1e-9), path.line_at(corner + 1e-9)), (21, 22));
    let knot = path.knots_s().iter().copied().find(|s| (s - corner).abs() < 1e-12).unwrap();
    assert_eq!(
        (path.lines_between(0.0, knot), path.lines_between(knot, 1.0)),
        ((21, 21), (22, 22))
    );
    assert_eq!(path.lines_between(0.1, 0.9), (21, 22));
    assert_eq!(path.lines_between(knot, knot), (21, 21));
}

#[test]
fn an_arc_stays_on_its_circle() {
    let robot = irb1600();
    let a = tcp_pose(&robot, &HOME, &tool());
    let (via, end) =
        (shifted(&a, [0.05, 0.05, 0.0], [0.0; 3]), shifted(&a, [0.1, 0.0, 0.0], [0.0; 3]));
    let path = Path::plan(
        &robot,
        &moves(vec![Target::Line(a), Target::Arc { via, end, turning: Turning::ByWay }], tool()),
        Some(&HOME),
    )
    .unwrap();
    assert!((path.duration_s() - std::f64::consts::PI * 0.05 / FEED).abs() < 1e-9);
    let centre = a.translation.vector + Vector3::new(0.05, 0.0, 0.0);
    let mut q = [0.0; 6];
    for i in 0..=50 {
        path.reader().at(f64::from(i) / 50.0, &mut q).unwrap();
        let radius = (tcp_pose(&robot, &q, &tool()).translation.vector - centre).norm();
        assert!((radius - 0.05).abs() < 1e-10);
    }
}

/// Joint moves take the way of the tool centre point over the feed; the way is summed here from chords.
#[test]
fn a_joint_move_takes_the_length_of_the_tools_way() {
    let robot = irb1600();
    let to = [0.9, -0.4, 0.3, 1.0, -0.7, 2.0];
    let path = Path::plan(
        &robot,
        &moves(vec![Target::Joints(HOME.into()), Target::Joints(to.into())], tool()),
        None,
    )
    .unwrap();
    let steps = 20_000;
    let point = |i: i32| {
        let u = f64::from(i) / f64::from(steps);
        let q: Vec<f64> = HOME.iter().zip(&to).map(|(a, b)| a + (b - a) * u).collect();
        tcp_pose(&robot, &q, &tool()).translation.vector
    };
    let way: f64 = (0..steps).map(|i| (point(i + 1) - point(i)).norm()).sum();
    assert!((path.duration_s() * FEED / way - 1.0).abs() < 1e-7);
    // Linear in time: halfway in s is halfway in every joint.
    let mut q = [0.0; 6];
    path.reader().at(0.5, &mut q).unwrap();
    for i in 0..6 {
        assert!((q[i] - 0.5 * (HOME[i] + to[i])).abs() < 1e-12);
    }
}

/// Where the tool centre point stands still, the slowest joint at its URDF velocity sets the time.
#[test]
fn a_turn_on_the_spot_takes_the_slowest_joints_time() {
    let robot = irb1600();
    let on_axis_6 = Isometry3::translation(0.0, 0.0, 0.15);
    let mut to = HOME;
    to[5] += 2.3;
    let path = Path::plan(
        &robot,
        &moves(vec![Target::Joints(HOME.into()), Target::Joints(to.into())], on_axis_6),
        None,
    )
    .unwrap();
    let speed = robot.joints()[5].velocity_limit.unwrap();
    assert!((path.duration_s() - 2.3 / speed).abs() < 1e-12);

    // The same turn asked for as a pose.
    let (a, b) = (tcp_pose(&robot, &HOME, &on_axis_6), tcp_pose(&robot, &to, &on_axis_6));
    let path =
        Path::plan(&robot, &moves(vec![Target::Line(a), Target::Line(b)], on_axis_6), Some(&HOME))
            .unwrap();
    assert!((path.duration_s() - 2.3 / speed).abs() < 1e-9, "{}", path.duration_s());
}

#[test]
fn the_start_may_be_sought_near_other_joint_positions() {
    let robot = irb1600();
    let a = tcp_pose(&robot, &HOME, &tool());
    let line = || {
        moves(vec![Target::Line(a), Target::Line(shifted(&a, [0.01, 0.0, 0.0], [0.0; 3]))], tool())
    };
    let start = |near: &[f64]| {
        let path = Path::plan(&robot, &line(), Some(near)).unwrap();
        let mut q = [0.0; 6];
        path.reader().at(0.0, &mut q).unwrap();
        q
    };
    let same = start(&HOME);
    // The wrist turned over: joints 4 and 6 by half a turn, joint 5 the other way.
    let flipped = [HOME[0], HOME[1], HOME[2], HOME[3] + 3.1, -HOME[4], HOME[5] - 3.1];
    let other = start(&flipped);
    assert!((same[4] - HOME[4]).abs() < 1e-9);
    assert!((other[4] + HOME[4]).abs() < 1e-9);
    // Without a wish: the solution nearest to zero.
    let plain = Path::plan(&robot, &line(), None).unwrap();
    let mut q = [0.0; 6];
    plain.reader().at(0.0, &mut q).unwrap();
    assert!((q[4] - HOME[4]).abs() < 1e-9);
}

/// What a program says of the arm configuration at its start may not say anything of joints: where another
/// shoulder or elbow reaches the first target, too, that is told. A wrist turned over always reaches it.
#[test]
fn a_start_that_other_arm_configurations_reach_is_told() {
    let robot = irb1600();
    let open = |q: &[f64], near: Option<&[f64]>| {
        let a = tcp_pose(&robot, q, &tool());
        let b = shifted(&a, [-0.01, 0.0, 0.0], [0.0; 3]);
        let mut line = moves(vec![Target::JointsTo(a), Target::Line(b)], tool());
        let uncompared = Some(Arc::from("N U T"));
        line[0].stated = Arc::new(Stated { uncompared, ..Stated::default() });
        let path = Path::plan(&robot, &line, near).unwrap();
        path.open_start().map(|(line, said, _)| (line, said.to_owned()))
    };
    // Over backwards the wrist is 1.26 m from axis 2, of 1.3 m, and axis 5 at 101°, of 115°.
    assert_eq!(open(&HOME, None), Some((20, "N U T".to_owned())));
    assert_eq!(open(&HOME, Some(&HOME)), None);
    // Backwards it is 1.42 m away; with the elbow down axis 5 had to be at 129°.
    assert_eq!(open(&[0.2, 0.6, -0.6, 0.1, 1.2, -0.4], None), None);

    // Nothing is said at the start, and something at the end of a line that keeps its configuration.
    let later = |to: fn(Isometry3<f64>) -> Target| {
        let a = tcp_pose(&robot, &HOME, &tool());
        let b = shifted(&a, [-0.01, 0.0, 0.0], [0.0; 3]);
        let mut line = moves(vec![Target::JointsTo(a), Target::Line(a), to(b)], tool());
        let sides = Sides { name: "F D B".to_owned(), as_at_zero: [Some(false); 2] };
        let (shown, joints) = ("F D B".to_owned(), Vec::new());
        let configuration = Configuration { shown, joints, sides: Some(sides) };
        let configuration = Some(Arc::new(configuration));
        line[2].stated = Arc::new(Stated { configuration, ..Stated::default() });
        let path = Path::plan(&robot, &line, None).unwrap();
        path.open_start().map(|(line, said, _)| (line, said.to_owned()))
    };
    assert_eq!(later(Target::Line), Some((22, "F D B".to_owned())));
    assert_eq!(later(Target::JointsTo), None);
}

/// Counted from 1.
fn waypoint(fault: &Note) -> usize {
    let Some(Part::Waypoint(index)) = fault.place.part else { panic!("{fault:?}") };
    index + 1
}

#[test]
fn what_cannot_be_run_is_told_with_its_waypoint() {
    let robot = irb1600();
    let a = tcp_pose(&robot, &HOME, &tool());
    let told = |targets: Vec<Target>, tcp: Isometry3<f64>| {
        let faults = Path::plan(&robot, &moves(targets, tcp), Some(&HOME)).unwrap_err();
        let of = |fault: &Note| (fault.place.line.unwrap(), waypoint(fault), fault.what.clone());
        faults.iter().map(of).collect::<Vec<_>>()
    };
    let far = shifted(&a, [1.5, 0.0, 0.0], [0.0; 3]);
    let faults = told(vec![Target::Line(a), Target::Line(far)], tool());
    assert_eq!((faults.len(), faults[0].0, faults[0].1), (1, 21, 2));
    assert!(faults[0].2.contains("reach"), "{}", faults[0].2);
    let absurd = shifted(&a, [1e160, 0.0, 0.0], [0.0; 3]);
    let faults = told(vec![Target::Line(a), Target::Line(absurd)], tool());
    assert!(faults[0].2.contains("finite"), "{}", faults[0].2);
    let absurd = shifted(&a, [1e100, 0.0, 0.0], [0.0; 3]);
    let faults = told(vec![Target::Line(a), Target::Line(absurd)], tool());
    assert!(faults[0].2.contains("reach"), "{}", faults[0].2);

    // Every joint target that is wrong in itself, not only the first.
    let over = |q2: f64| Target::Joints(vec![0.0, q2, 0.0, 0.0, 0.5, 0.0]);
    let faults =
        told(vec![over(0.1), over(2.5), over(0.0), over(-1.9), Target::Joints(vec![0.0])], tool());
    assert_eq!(faults.iter().map(|f| f.1).collect::<Vec<_>>(), [2, 4, 5]);
    assert!(
        faults[0].2.contains("joint_2") && faults[0].2.contains("143.239 deg"),
        "{}",
        faults[0].2
    );

    // Straight through a stretched wrist.
    let flange = Isometry3::identity();
    let bent = |q5: f64| vec![0.0, 0.3, -0.2, 0.0, q5, 0.0];
    let over = Target::Line(tcp_pose(&robot, &bent(-0.4), &flange));
    let faults = Path::plan(&robot, &moves(vec![Target::Joints(bent(0.4)), over], flange), None)
        .unwrap_err();
    assert!(faults[0].what.contains("singular"), "{}", faults[0].what);
    assert_eq!(waypoint(&faults[0]), 2);

    let faults = Path::plan(&robot, &[], None).unwrap_err();
    assert!(faults[0].what.contains("empty"));
}

/// One waypoint is a place to stay at; repeated waypoints take no time.
#[test]
fn a_path_may_stand_still() {
    let robot = irb1600();
    for targets in [1, 3] {
        let targets = vec![Target::Joints(HOME.into()); targets];
        let path = Path::plan(&robot, &moves(targets, tool()), None).unwrap();
        assert_eq!(path.duration_s(), 0.0);
        for s in [0.0, 0.5, 1.0] {
            let mut q = [0.0; 6];
            let tcp = path.reader().at(s, &mut q).unwrap();
            assert_eq!((q, tcp), (HOME, tool()));
        }
        let stations = grid(&path, std::iter::empty());
        assert_eq!((stations.first(), stations.last()), (Some(&0.0), Some(&1.0)));
    }
}

/// The bound that the coverage rests on.
#[test]
fn stations_are_close_in_time_and_in_the_joints() {
    let robot = irb1600();
    let mut to = HOME;
    to[0] += 1.7;
    to[5] += 2.0;
    let a = tcp_pose(&robot, &to, &tool());
    let path = Path::plan(
        &robot,
        &moves(
            vec![
                Target::Joints(HOME.into()),
                Target::Joints(to.into()),
                Target::Line(shifted(&a, [0.0, -0.1, 0.05], [0.3, 0.0, 0.0])),
            ],
            tool(),
        ),
        None,
    )
    .unwrap();
    let stations = grid(&path, [0.123_456_7].into_iter());
    assert!(stations.contains(&0.123_456_7));
    let mut reader = path.reader();
    let mut before = [0.0; 6];
    reader.at(0.0, &mut before).unwrap();
    for pair in stations.windows(2) {
        assert!(pair[1] > pair[0] && pair[1] - pair[0] <= MAX_GAP * (1.0 + 1e-9));
        let mut q = [0.0; 6];
        reader.at(pair[1], &mut q).unwrap();
        for i in 0..6 {
            assert!((q[i] - before[i]).abs() <= MAX_STEP * 1.2, "joint {i} at {}", pair[1]);
        }
        before = q;
    }
}

/// A redundant arm starts where it was asked to start, not at some other of its many solutions.
#[test]
fn a_redundant_arm_starts_where_it_was_asked_to() {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/rail-mill/robot.yaml");
    let robot = detune::input::read_robot(&file, &mut detune::input::Reading::default()).unwrap();
    let wished = [0.2, 0.0, -1.0, 1.4, 0.0, 1.2, 0.0];
    let a = tcp_pose(&robot, &wished, &tool());
    let targets = vec![Target::Line(a), Target::JointsTo(shifted(&a, [0.01, 0.0, 0.0], [0.0; 3]))];
    let path = Path::plan(&robot, &moves(targets, tool()), Some(&wished)).unwrap();
    let (mut q, mut end) = ([0.0; 7], [0.0; 7]);
    path.reader().at(0.0, &mut q).unwrap();
    path.reader().at(1.0, &mut end).unwrap();
    for i in 0..7 {
        assert!((q[i] - wished[i]).abs() < 1e-9, "joint {i} starts at {}", q[i]);
        assert!((end[i] - q[i]).abs() < 0.1, "joint {i} moves to {}", end[i]);
    }
}

/// A limit that a URDF printed with five digits is the limit for waypoints and for poses alike.
#[test]
fn a_rounded_limit_holds_for_poses_too() {
    let robot = irb1600();
    let at_limit = [std::f64::consts::PI, 0.3, 0.2, 0.1, 0.9, 0.0];
    let mut beyond = at_limit;
    beyond[0] += 5e-5;
    let a = tcp_pose(&robot, &beyond, &tool());
    let path = Path::plan(
        &robot,
        &moves(vec![Target::Joints(at_limit.into()), Target::Line(a)], tool()),
        None,
    )
    .unwrap();
    let mut q = [0.0; 6];
    path.reader().at(1.0, &mut q).unwrap();
    assert!((q[0] - beyond[0]).abs() < 1e-9);
}

/// A line that has to end in joint positions beyond a limit is refused for that joint, not for
/// another that the arm would meet on the way.
#[test]
fn the_end_of_a_line_is_beyond_its_own_limit() {
    let robot = irb1600();
    let a = tcp_pose(&robot, &HOME, &tool());
    let targets =
        vec![Target::Joints(HOME.into()), Target::Line(shifted(&a, [0.01, 0.0, 0.0], [0.0; 3]))];
    let mut line = moves(targets, tool());
    let upper = robot.joints()[1].limit.unwrap()[1];
    for (at, is_beyond) in [(upper + 1.0, true), (HOME[1] + 1.0, false)] {
        let configuration =
            Configuration { shown: "joints".into(), joints: vec![(1, [at, at])], sides: None };
        line[1].stated =
            Arc::new(Stated { configuration: Some(configuration.into()), ..Stated::default() });
        let faults = Path::plan(&robot, &line, None).unwrap_err();
        let code = if is_beyond { Code::JointLimit } else { Code::Unreachable };
        assert!(faults.len() == 1 && faults[0].code == code, "{faults:?}");
        assert!(faults[0].what.contains(&robot.joints()[1].name), "{faults:?}");
    }
}

#[test]
fn what_never_ends_is_refused() {
    let robot = irb1600();
    let mut to = HOME;
    to[0] += 0.5;
    let mut slow = moves(vec![Target::Joints(HOME.into()), Target::Joints(to.into())], tool());
    slow[1].feed_m_per_s = 1e-320;
    let faults = Path::plan(&robot, &slow, None).unwrap_err();
    assert!(faults[0].what.contains("more than can be counted"), "{}", faults[0].what);

    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("robots/two-link/robot.yaml");
    let continuous =
        detune::input::read_robot(&file, &mut detune::input::Reading::default()).unwrap();
    let far = vec![Target::Joints(vec![0.0, 0.0]), Target::Joints(vec![0.0, 1e12])];
    let faults = Path::plan(&continuous, &moves(far, tool()), None).unwrap_err();
    assert!(faults[0].what.contains("one move may have"), "{}", faults[0].what);
}

/// Steps of a micrometre and less take their way over the feed, and where the arm stands it takes
/// the time that is asked for.
#[test]
fn short_steps_and_dwells_take_their_time() {
    let robot = irb1600();
    let a = tcp_pose(&robot, &HOME, &tool());
    for step in [1e-6, 4e-7] {
        let ends = (0..=50).map(|i| shifted(&a, [f64::from(i) * step, 0.0, 0.0], [0.0; 3]));
        let short = moves(ends.map(Target::Line).collect(), tool());
        let path = Path::plan(&robot, &short, Some(&HOME)).unwrap();
        let expected = 50.0 * step / FEED;
        assert!((path.duration_s() - expected).abs() < 1e-4 * expected, "{}", path.duration_s());
    }
    let b = shifted(&a, [0.03, 0.0, 0.0], [0.0; 3]);
    let mut dwell = moves(vec![Target::Line(a), Target::JointsTo(a), Target::Line(b)], tool());
    dwell[1].timing = Timing::Seconds(2.5);
    let path = Path::plan(&robot, &dwell, Some(&HOME)).unwrap();
    assert!((path.duration_s() - 2.5 - 0.03 / FEED).abs() < 1e-9, "{}", path.duration_s());
    assert!((path.standing_s() - 2.5).abs() < 1e-12);
    let mut q = [0.0; 6];
    path.reader().at(2.0 / path.duration_s(), &mut q).unwrap();
    assert!(q.iter().zip(HOME).all(|(q, home)| (q - home).abs() < 1e-9), "{q:?}");
    assert_eq!(path.line_at(2.0 / path.duration_s()), 21);
    // At half of the joints' speed a turn takes twice as long.
    let mut to = HOME;
    to[5] += 2.3;
    let mut turn = moves(vec![Target::Joints(HOME.into()), Target::Joints(to.into())], tool());
    turn[1].timing = Timing::Joints(0.5);
    let path = Path::plan(&robot, &turn, None).unwrap();
    let speed = robot.joints()[5].velocity_limit.unwrap();
    assert!((path.duration_s() - 2.0 * 2.3 / speed).abs() < 1e-12);
}

/// MoveJ and MoveL turn the tool no faster than their speeddata says; the chip sees the feed that is
/// run.
#[test]
fn the_turn_of_the_tool_slows_lines_and_joint_moves() {
    let robot = irb1600();
    let mut to = HOME;
    // Axis 6 turns the tool about itself by a quarter turn; axis 1 carries it along.
    to[5] += std::f64::consts::FRAC_PI_2;
    to[0] += 0.01;
    let from = Target::Joints(HOME.into());
    let end = tcp_pose(&robot, &to, &tool());
    for (kind, target) in [("joints", Target::Joints(to.into())), ("line", Target::Line(end))] {
        let mut own = moves(vec![from.clone(), target], tool());
        let free_s = Path::plan(&robot, &own, None).unwrap().duration_s();
        Arc::make_mut(&mut own[1].stated).turning_rad_per_s = Some(0.1);
        let path = Path::plan(&robot, &own, None).unwrap();
        let turn_s = (end.rotation.angle_to(&tcp_pose(&robot, &HOME, &tool()).rotation)) / 0.1;
        assert!(path.duration_s() > 2.0 * free_s, "{kind}: {}", path.duration_s());
        // The turn of axis 1 beside it is about another axis.
        assert!((path.duration_s() / turn_s - 1.0).abs() < 1e-3, "{kind}: {}", path.duration_s());
        let run = own[1].feed_m_per_s * free_s / path.duration_s();
        let feed = path.feed_m_per_s_at(0.5);
        assert!((feed / run - 1.0).abs() < 1e-9, "{kind}: {feed} {run}");
    }
}
