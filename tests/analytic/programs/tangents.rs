//! Heidenhain's corners, tangential arcs, ways onto a contour and off it, its cycles 1, 7 and 205 to 207, and Q
//! parameters.
//!
//! Where the figures are not plain they are not worked out as the reader does: arcs are held to lie
//! at their radius from their centre, to begin and end across it, and to go the right way round.

use detune::motion::Target;
use detune::notes::{Code, Note};
use detune::program::{Dialect, NewSpeed, Program, Rewrite, read, rewrite};
use nalgebra::{Vector2, Vector3};

use super::support::{assert_ends, at, settings};

const HEAD: &str = "BEGIN PGM A MM\nTOOL CALL 1 Z S3000 F400\nL X+0 Y+0 Z+10 R0 FMAX M3\n";

fn run(blocks: &str) -> Result<Program, Vec<Note>> {
    let text = format!("{HEAD}{blocks}END PGM A MM\n");
    read(text.as_bytes(), Dialect::Heidenhain, &settings())
}

fn refused(blocks: &str, said: &str) {
    let found = run(blocks).expect_err(blocks);
    assert!(found.iter().any(|note| note.what.contains(said)), "{blocks}: {found:?}");
}

/// mm.
fn places(program: &Program) -> Vec<(Option<Vector3<f64>>, Vector3<f64>)> {
    let mm = |pose: &nalgebra::Isometry3<f64>| pose.translation.vector * 1000.0;
    let of = |each: &detune::motion::Move| match &each.to {
        Target::Line(pose) => (None, mm(pose)),
        Target::Arc { via, end, .. } => (Some(mm(via)), mm(end)),
        other => panic!("{other:?}"),
    };
    program.moves.iter().map(of).collect()
}

/// The centre of the circle through three points in the plane, by their perpendicular bisectors.
fn centre(a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>) -> Vector2<f64> {
    let rows =
        nalgebra::Matrix2::from_rows(&[(b - a).transpose() * 2.0, (c - a).transpose() * 2.0]);
    let right =
        Vector2::new(b.norm_squared() - a.norm_squared(), c.norm_squared() - a.norm_squared());
    rows.lu().solve(&right).unwrap()
}

#[track_caller]
fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-6, "{found}, expected {expected}");
}

#[test]
fn corners_between_lines() {
    // A right angle: 5 mm before the corner and behind it, about (35, 5).
    let program = run("L X+40 F400\nRND R5 F100\nL Y+30\nCHF 2\nL X+10\n").unwrap();
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 10.0]),
            ('L', [35.0, 0.0, 10.0]),
            ('A', [40.0, 5.0, 10.0]),
            ('L', [40.0, 28.0, 10.0]),
            ('L', [38.0, 30.0, 10.0]),
            ('L', [10.0, 30.0, 10.0]),
        ],
    );
    let feeds: Vec<f64> = program.moves.iter().map(|each| each.feed_m_per_s * 6e4).collect();
    // F holds in the corner alone.
    for (found, expected) in feeds[1..].iter().zip([400.0, 100.0, 400.0, 400.0, 400.0]) {
        close(*found, expected);
    }
    let (via, _) = places(&program)[2];
    let off = (via.unwrap().xy() - Vector2::new(35.0, 5.0)).norm();
    close(off, 5.0);
    // Relative words count from the corner, not from where the line ends.
    let relative = run("L X+40 F400\nRND R5\nL IY+30\n").unwrap();
    assert_eq!(places(&relative).last().unwrap().1.y, 30.0);
    refused("RND R5\n", "the corner of line 4 must lie between two lines");
    refused("L X+40 F400\nRND R5\nCC X+40 Y+10\nC X+40 Y+20 DR+\n", "between two lines");
    refused("L X+40 F400\nRND R50\nL Y+30\n", "larger than its lines");
    refused("L X+40 F400\nRND R0\nL Y+30\n", "size above 0");
    refused("L X+40 F400\nRND R5\nL Z-5\n", "plane of X and Y");
    refused("L X+40 F400\nRND R5\nL Y+30 M5\n", "between two lines");
    refused("L X+40 F400\nRND R5\n", "between two lines");
}

#[test]
fn the_feed_of_a_corner_is_rewritten() {
    let text = format!("{HEAD}L X+40\nRND R5 F100\nL Y+30\nEND PGM A MM\n");
    let speeds = vec![NewSpeed { end: usize::MAX, rpm: 6000.0, job_rpm: None }];
    let to = Rewrite { speeds, keeps_chip_load: true };
    let found = rewrite(text.as_bytes(), Dialect::Heidenhain, &settings(), &to).unwrap();
    let expected = text.replace("S3000 F400", "S6000 F800").replace("F100", "F200");
    assert_eq!(String::from_utf8(found.bytes).unwrap(), expected);
}

#[test]
fn a_tangential_arc_goes_on_as_the_line_before() {
    // HEIDENHAIN's example: L (0, 25) to (25, 30), CT to (45, 20).
    let program = run("L X+0 Y+25 F300\nL X+25 Y+30\nCT X+45 Y+20\nL Y+0\n").unwrap();
    let places = places(&program);
    let [from, start] = [1, 2].map(|at| places[at].1.xy());
    let (via, end) = (places[3].0.unwrap().xy(), places[3].1.xy());
    assert_eq!(end, Vector2::new(45.0, 20.0));
    let about = centre(start, via, end);
    close((start - about).dot(&(start - from).normalize()), 0.0);
    // To the right of the line's way: clockwise, and by less than a turn.
    assert!((start - from).perp(&(via - start)) < 0.0);
    // Behind an arc: a half circle goes on into one to the other side.
    let s = run("L X+10 F300\nCC X+10 Y+5\nC X+10 Y+10 DR+\nCT X+10 Y+20\n").unwrap();
    let places = self::places(&s);
    close(places[3].0.unwrap().x, 5.0);
    refused("CT X+45 Y+20 F100\n", "no element of a contour");
    refused("L X+10 F300\nCT X+45\n", "straight ahead");
}

/// HEIDENHAIN's example of APPR: from (40, 10) onto (10, 20), where the contour goes to (20, 35).
#[test]
fn ways_onto_a_contour() {
    let first = Vector2::new(10.0, 20.0);
    let along = Vector2::new(10.0, 15.0).normalize();
    for (way, side) in [("RR", -1.0), ("RL", 1.0)] {
        let of = |approach: &str| {
            let text = format!(
                "L X+40 Y+10 R0 FMAX\nAPPR {approach} {way} F100\nL X+20 Y+35\nL X+30 F500\n"
            );
            places(&run(&text).unwrap())
        };
        let start = Vector2::new(40.0, 10.0);
        let left = Vector2::new(-along.y, along.x);

        let lct = of("LCT X+10 Y+20 Z-10 R10");
        // More than half a turn with RL, which is two arcs.
        let (above, on, via) = (lct[2].1, lct[3].1, lct[4].0.unwrap().xy());
        let end = lct[lct.len() - 3].1;
        assert_eq!((above.z, on.z, end), (10.0, -10.0, Vector3::new(10.0, 20.0, -10.0)));
        assert_eq!(lct.len(), if side > 0.0 { 8 } else { 7 });
        let about = centre(on.xy(), via, lct[4].1.xy());
        close((about - first - left * (side * 10.0)).norm(), 0.0);
        close((on.xy() - about).dot(&(on.xy() - start)), 0.0);
        // Round the centre as the line goes past it, and the same way into the contour.
        let turn = (on.xy() - start).perp(&(about - on.xy()));
        assert_eq!(turn.signum(), side);

        let ct = of("CT X+10 Y+20 Z-10 CCA180 R+10");
        let on = ct[3].1.xy();
        // A half turn: across the contour's first point, twice the radius away.
        close((on - first - left * (side * 20.0)).norm(), 0.0);
        let beside = ct[4].0.unwrap().xy() - first - left * (side * 10.0);
        close((beside + along * 10.0).norm(), 0.0);
        let other = of("CT X+10 Y+20 CCA90 R-10");
        close((other[2].1.xy() - first + left * (side * 10.0) + along * 10.0).norm(), 0.0);

        let lt = of("LT X+10 Y+20 Z-10 LEN15");
        close((lt[3].1.xy() - first + along * 15.0).norm(), 0.0);
        let ln = of("LN X+10 Y+20 Z-10 LEN15");
        close((ln[3].1.xy() - first - left * (side * 15.0)).norm(), 0.0);
    }
    // To the way at the pace of the block before, except LCT, then at its own feed.
    let feeds = |approach: &str| -> Vec<f64> {
        let text = format!("L X+40 F300\nAPPR {approach} RR F100\nL X+20 Y+35 F200\n");
        let program = run(&text).unwrap();
        program.moves[2..].iter().map(|each| (each.feed_m_per_s * 6e4).round()).collect()
    };
    assert_eq!(feeds("LT X+10 Y+20 LEN15"), [300.0, 100.0, 200.0]);
    assert_eq!(feeds("LCT X+10 Y+20 R5"), [100.0, 100.0, 200.0]);
    let arc = "L X+40 F300\nAPPR LT X+10 Y+20 LEN15 RR F100\n";
    // The contour begins with an arc about (20, 20): it heads down, clockwise up.
    for (block, y) in [("C X+20 Y+10 DR+", 35.0), ("C X+20 Y+30 DR-", 5.0)] {
        let found = places(&run(&format!("{arc}CC X+20 Y+20\n{block}\n")).unwrap());
        close((found[2].1.xy() - Vector2::new(10.0, y)).norm(), 0.0);
    }
    let found = places(&run(&format!("{arc}CR X+20 Y+10 R+10 DR+\n")).unwrap());
    close((found[2].1.xy() - Vector2::new(10.0, 35.0)).norm(), 0.0);
    let depth = run("L X+40 F300\nAPPR LT X+10 Y+20 Z-5 LEN15 RR F100\nL X+20 Y+35\n").unwrap();
    assert_eq!(doubts(&depth), [5]);
    let on = "\nL X+20 Y+35\n";
    refused(&format!("L X+40 F300\nAPPR LCT X+10 Y+20 R5 R0{on}"), "side is not stated");
    refused(&format!("L X+11 Y+20 F300\nAPPR LCT X+10 Y+20 R50 RR{on}"), "inside its arc");
    refused(&format!("L X+40 F300\nAPPR PLT PR+10 PA+5 LEN5 RL{on}"), "without CC");
    refused(&format!("CC X+0 Y+0\nL X+40 F300\nAPPR PLT PR+10 LEN5 RL{on}"), "needs PR and PA");
    refused("L X+40 F300\nAPPR LT X+10 Y+20 LEN15 RR\n", "must go on with L, LP, C, CP or CR");
    refused(&format!("L X+40 F300\nAPPR LT X+10 Y+20 RR{on}"), "without LEN");
}

/// Lines of doubts about the way.
fn doubts(program: &Program) -> Vec<usize> {
    let told = program.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
    told.map(at).collect()
}

/// The line is tangent to the contour: the arc of LCT turns by 0°.
#[test]
fn ways_that_are_in_line_with_the_contour_have_no_arc() {
    let along = |blocks: &str, steps: &[f64], way: [f64; 2]| {
        let program = run(blocks).unwrap();
        let ends: Vec<_> = steps.iter().map(|s| ('L', [s * way[0], s * way[1], 10.0])).collect();
        assert_ends(&program, &ends);
        assert!(doubts(&program).is_empty(), "{blocks}: {:?}", program.warnings);
    };
    for side in ["RL", "RR"] {
        let onto = format!("APPR LCT X+20 Y+0 R5 {side} F100\nL X+40\n");
        along(&onto, &[0.0, 20.0, 40.0], [1.0, 0.0]);
        let off = format!("L X+20 {side} F100\nL X+40\nDEP LCT X+60 Y+0 R5\n");
        along(&off, &[0.0, 20.0, 40.0, 60.0], [1.0, 0.0]);
        let polar = format!("CC X+0 Y+0\nL X+20 {side} F100\nL X+40 Y+0\nDEP PLCT PR+60 PA+0 R5\n");
        along(&polar, &[0.0, 20.0, 40.0, 60.0], [1.0, 0.0]);
        let slanted = format!("L X+10 Y+30 F200\nAPPR LCT X+20 Y+60 R5 {side}\nL X+40 Y+120\n");
        along(&slanted, &[0.0, 10.0, 20.0, 40.0], [1.0, 3.0]);
    }
    // Off by a micrometre to either side: on one of them the arc would be a whole circle but for
    // 0.00025 mm. Off by a millimetre, it is one but for 0.25 mm.
    let from =
        |y: f64| run(&format!("L Y{y:+} F200\nAPPR LCT X+20 Y+0 R5 RL F100\nL X+40\n")).unwrap();
    for (y, lines) in [(0.001, vec![]), (-0.001, vec![5])] {
        let program = from(y);
        let ends = [[0.0, 0.0], [0.0, y], [20.0, 0.0], [40.0, 0.0]];
        assert_ends(&program, &ends.map(|[x, y]| ('L', [x, y, 10.0])));
        assert_eq!(doubts(&program), lines, "{y}");
    }
    let arcs = places(&from(-1.0)).iter().filter(|(via, _)| via.is_some()).count();
    assert_eq!((arcs, doubts(&from(-1.0))), (2, vec![]));
}

#[track_caller]
fn same_places(found: &str, expected: &str) -> Vec<Vector3<f64>> {
    let [found, expected] = [found, expected].map(|blocks| places(&run(blocks).unwrap()));
    assert_eq!(found.len(), expected.len(), "{found:?}, expected {expected:?}");
    for ((via, end), (expected_via, expected_end)) in found.iter().zip(&expected) {
        close((end - expected_end).norm(), 0.0);
        assert_eq!(via.is_some(), expected_via.is_some());
        close((via.unwrap_or_default() - expected_via.unwrap_or_default()).norm(), 0.0);
    }
    found.into_iter().map(|(_, end)| end).collect()
}

/// A helix down a bore of 32 mm about (50, 50), begun and left on arcs of 2 mm inside of it.
#[test]
fn ways_onto_a_helix_and_by_polar_coordinates() {
    let helix = |approach: &str| {
        format!(
            "L X+50 Y+50 R0 FMAX\nCC\nL Z-12.75 F1000\nAPPR {approach} CCA180 R+2 RL F100\n\
             LBL 1\nCP IPA+360 IZ+1.5 DR+ F200\nCALL LBL 1 REP 1\nDEP CT CCA180 R+2\n\
             L Z+100 R0 FMAX\n"
        )
    };
    let found = same_places(&helix("PCT PR+32 PA-180"), &helix("CT X+18 Y+50"));
    close((found[3] - Vector3::new(22.0, 50.0, -12.75)).norm(), 0.0);
    for z in [-12.75, -11.25, -9.75] {
        let is_there = |at: &Vector3<f64>| (at - Vector3::new(18.0, 50.0, z)).norm() < 1e-6;
        assert!(found.iter().any(is_there), "{z}: {found:?}");
    }
    let [.., off, last] = found[..] else { panic!("{found:?}") };
    close((off - Vector3::new(22.0, 50.0, -9.75)).norm(), 0.0);
    close((last - Vector3::new(22.0, 50.0, 100.0)).norm(), 0.0);

    // Onto the line from (0, 10) to (-10, 0), which a pole behind the approach gives, too.
    for next in ["LP PR+10 PA+180", "CC X+0 Y+10\nLP PR+20 PA+225"] {
        let line = format!("L X+40 F300\nCC X+0 Y+0\nAPPR PLT PR+10 PA+90 LEN5 RL F100\n{next}\n");
        let found = places(&run(&line).unwrap());
        let half = 0.5_f64.sqrt() * 5.0;
        close((found[2].1 - Vector3::new(half, 10.0 + half, 10.0)).norm(), 0.0);
        close((found[3].1 - Vector3::new(0.0, 10.0, 10.0)).norm(), 0.0);
    }
    let off = |to: &str| format!("L X+20 Y+0 RR F300\nL Y+20 RR\nCC X+0 Y+0\nDEP {to} R+8 F100\n");
    let angle = 12.0_f64.atan2(35.0).to_degrees();
    let found = same_places(&off(&format!("PLCT PR+37 PA+{angle}")), &off("LCT X+35 Y+12"));
    close((found[found.len() - 1] - Vector3::new(35.0, 12.0, 10.0)).norm(), 0.0);
}

/// HEIDENHAIN's examples of DEP, behind a line up to (20, 20) with RR.
#[test]
fn ways_off_a_contour() {
    let of = |departure: &str, side: &str| {
        let text = format!("L X+20 Y+0 {side} F300\nL Y+20 {side}\nDEP {departure} F100\n");
        places(&run(&text).unwrap())
    };
    for (side, sign) in [("RR", 1.0), ("RL", -1.0)] {
        assert_eq!(of("LT LEN12.5", side)[3].1, Vector3::new(20.0, 32.5, 10.0));
        assert_eq!(of("LN LEN+20", side)[3].1, Vector3::new(20.0 + sign * 20.0, 20.0, 10.0));
        let ct = of("CT CCA 180 R+8", side);
        close((ct[3].1 - Vector3::new(20.0 + sign * 16.0, 20.0, 10.0)).norm(), 0.0);
        close((ct[3].0.unwrap() - Vector3::new(20.0 + sign * 8.0, 28.0, 10.0)).norm(), 0.0);
        let lct = of(&format!("LCT X+{} Y+12 Z+30 R+8", 20.0 + sign * 15.0), side);
        let about = Vector2::new(20.0 + sign * 8.0, 20.0);
        let last = lct.len() - 1;
        let (off, end) = (lct[last - 2].1.xy(), lct[last - 1].1);
        close((off - about).norm(), 8.0);
        close((off - about).dot(&(end.xy() - off)), 0.0);
        // The arc goes on into the line, not back.
        close((lct[last - 2].0.unwrap().xy() - about).norm(), 8.0);
        assert!((about - off).perp(&(end.xy() - off)) * sign > 0.0);
        assert_eq!(lct.last().unwrap().1, Vector3::new(20.0 + sign * 15.0, 12.0, 30.0));
    }
    // Newer controls move the tool axis together with the others.
    let of = |height: &str| {
        let text = format!("L X+20 RR F300\nL Y+20\nDEP LCT X+35 Y+12{height} R8 F100\n");
        doubts(&run(&text).unwrap())
    };
    assert_eq!((of(" Z+30"), of(" Z+10"), of("")), (vec![6], vec![], vec![]));
    refused("L X+20 F300\nDEP LN LEN5\n", "side is not stated");
    refused("DEP LT LEN5 F100\n", "no element of a contour");
}

#[test]
fn deep_holes_and_taps() {
    let of = |cycle: &str| run(&format!("CYCL DEF {cycle}\nL X+5 Y+5 FMAX M99\n"));
    let deep = "205 UNIVERSAL PECKING Q200=2 Q201=-12 Q206=150 Q202=5 Q203=0 Q204=10 Q212=1 Q205=2 \
                Q258=0.5 Q259=0.5 Q257=3 Q256=0.2 Q211=0 Q208=9999";
    let z: Vec<f64> = places(&of(deep).unwrap())[2..].iter().map(|(_, at)| at.z).collect();
    // Pecks of 5 and 4 mm and the rest, a chip broken each 3 mm, out between, again 0.5 mm above.
    let expected =
        [2.0, -3.0, -2.8, -5.0, 2.0, -4.5, -8.0, -7.8, -9.0, 2.0, -8.5, -12.0, 2.0, 10.0];
    assert_eq!(z.len(), expected.len(), "{z:?}");
    for (found, expected) in z.iter().zip(expected) {
        close(*found, expected);
    }
    let refused = |cycle: &str, said: &str| {
        let found = of(cycle).unwrap_err();
        assert!(found.iter().any(|note| note.what.contains(said)), "{cycle}: {found:?}");
    };
    refused(&deep.replace("Q259=0.5", "Q259=0.2"), "Q258 and Q259");
    refused(&format!("{deep} Q379=4"), "Q379");

    let rigid = "207 TAPPING Q200=2 Q201=-20 Q239=+1 Q203=0 Q204=10";
    let floating = "206 TAPPING Q200=2 Q201=-20 Q206=3000 Q211=0 Q203=0 Q204=10";
    for cycle in [rigid, floating] {
        let program = of(cycle).unwrap();
        // 1 mm a turn at 3000 rpm, in and out.
        let feeds: Vec<f64> = program.moves.iter().map(|each| each.feed_m_per_s * 6e4).collect();
        close(feeds[3], 3000.0);
        close(feeds[4], 3000.0);
        let told: Vec<Code> = program.warnings.iter().map(|note| note.code).collect();
        assert!(told.contains(&Code::SpindleCommand), "{told:?}");
        assert_eq!(at(&program.warnings[0]), 5);
    }
}

#[test]
fn inches_signs_and_polar_ways_behind_a_corner() {
    let inch = |blocks: &str| {
        let text = format!(
            "BEGIN PGM A INCH\nTOOL CALL 1 Z S3000 F40\nL X+1 Y+0 Z+1 FMAX M3\n{blocks}END PGM A INCH\n"
        );
        places(&read(text.as_bytes(), Dialect::Heidenhain, &settings()).unwrap())
    };
    let found = inch("APPR LT X+0 Y+0 LEN0.5 RL\nL X+0 Y+1\nDEP LT LEN1\n");
    close((found[1].1 - Vector3::new(0.0, -12.7, 25.4)).norm(), 0.0);
    close((found[4].1 - Vector3::new(0.0, 50.8, 25.4)).norm(), 0.0);
    // The program's name is no unit.
    let named = "BEGIN PGM 1-INCH-FITTING MM\nL X+0 Y+0 Z+10 FMAX\nL X+10 F200\nEND PGM 1-INCH-FITTING MM\n";
    let program = read(named.as_bytes(), Dialect::Heidenhain, &settings()).unwrap();
    assert_ends(&program, &[('L', [0.0, 0.0, 10.0]), ('L', [10.0, 0.0, 10.0])]);
    assert_ends(
        &run("L X+ 50 Y- 20\n").unwrap(),
        &[('L', [0.0, 0.0, 10.0]), ('L', [50.0, -20.0, 10.0])],
    );
    // From 60° on by 90°, at a radius of 40 mm, behind a corner that is not drawn yet.
    let polar = run("CC X+0 Y+0\nLP PR+40 PA+0\nLP PR+40 PA+60\nRND R2\nLP IPA+90\n").unwrap();
    let end = places(&polar).last().unwrap().1.xy();
    close((end - Vector2::new(-40.0 * 0.75_f64.sqrt(), 20.0)).norm(), 0.0);
}

/// What may stand beside a way back, and what ends a shift.
#[test]
fn a_way_back_and_the_ends_of_shifts() {
    refused("L X+5 F100 M140 MB 20\n", "M140 beside X, Y or Z");
    refused("L X+5 F100 M140 MB MAX\n", "M140 beside X, Y or Z");
    let program = run("L X+5 F100\nL M140 MB 20\nL M140 MB 5 F750\n").unwrap();
    let feeds: Vec<f64> = program.moves.iter().map(|each| each.feed_m_per_s * 6e4).collect();
    assert!(program.moves[2].timing == detune::motion::Timing::Rapid, "{feeds:?}");
    close(feeds[3], 750.0);
    close(places(&program)[3].1.z, 35.0);
    // The plane takes the tool away first: where to, is not known.
    refused("PLANE SPATIAL SPA+0 SPB+0 SPC+0 TURN MB+50 FMAX\nL X+5 F100\n", "Z is not known");
    let x = |between: &str| {
        let program = run(&format!("CYCL DEF 7.1 X+100\n{between}\nL X+1 F100\n")).unwrap();
        places(&program).last().unwrap().1.x
    };
    close(x("TRANS ROTATION RESET"), 101.0);
    close(x("TRANS DATUM RESET"), 1.0);
    close(x("CYCL DEF 247 Q339=+1"), 1.0);
    // A line that ends in a corner is drawn behind its own M codes.
    refused("L X+40 F400 M5\nRND R5\nL Y+30\n", "between two lines");
    refused(
        "CYCL DEF 200 Q200=2 Q201=-5 Q206=99 Q203=0\nL X+40 F400 M99\nRND R5\nL Y+30\n",
        "between two lines",
    );
    // Handwheel limits without end.
    assert!(run(&format!("L X+1 F100{}\n", " M118 X1".repeat(20_000))).is_ok());
}

/// The pecking of older controls: from where the tool is, 2 mm over the work.
#[test]
fn pecking_of_older_controls() {
    let cycle = "CYCL DEF 1.0 TIEFBOHREN\nCYCL DEF 1.1 ABST -2.000\nCYCL DEF 1.2 TIEFE -10.000\n\
                 CYCL DEF 1.3 ZUSTLG -4.000\nCYCL DEF 1.4 VZEIT 0,000\nCYCL DEF 1.5 F 100\n";
    let program = run(&format!("{cycle}L X+5.000 Y+5.000 Z+2 R0 FMAX M99\n")).unwrap();
    let z: Vec<f64> = places(&program)[1..].iter().map(|(_, at)| at.z).collect();
    let expected = [2.0, -4.0, 2.0, -3.4, -8.0, 2.0, -7.4, -10.0, 2.0];
    assert_eq!(z.len(), expected.len(), "{z:?}");
    z.iter().zip(expected).for_each(|(found, expected)| close(*found, expected));
    close(program.moves[2].feed_m_per_s * 6e4, 100.0);
    refused(&format!("{}CYCL CALL\n", cycle.replace("-10.000", "+10.000")), "below zero");
    // Of a cycle that is not read, one error.
    let slot = "CYCL DEF 3.0 SLOT\nCYCL DEF 3.1 SET UP -2\nCYCL DEF 3.2 DEPTH -20\nL X+5 F100\n";
    assert_eq!(run(slot).unwrap_err().len(), 1);
}

#[test]
fn the_work_may_be_shifted() {
    let program = run(
        "CYCL DEF 7.0 NULLPUNKT\nCYCL DEF 7.1 X+50\nCYCL DEF 7.2 Y-10\nL X+1 Y+1 F300\nL IX+5\n\
         CC X+0 Y+0\nLP PR+10 PA+0\nCYCL DEF 7.1 IX+5\nL X+0\nCYCL DEF 7.0 DATUM SHIFT X+0 Y+0\nL X+1 Y+1\n",
    )
    .unwrap();
    let expected: [[f64; 2]; 5] =
        [[51.0, -9.0], [56.0, -9.0], [60.0, -10.0], [55.0, -10.0], [1.0, 1.0]];
    for ((_, found), expected) in places(&program)[1..].iter().zip(expected) {
        close((found.xy() - Vector2::from(expected)).norm(), 0.0);
    }
    let program = run("TRANS DATUM AXIS X+50 Y-10\nL X+1 Y+1 F300\nTRANS DATUM AXIS IX+5\nL X+0\n\
         TRANS DATUM RESET\nL X+1 Y+1\n")
    .unwrap();
    let places = |[x, y]: [f64; 2]| ('L', [x, y, 10.0]);
    assert_ends(&program, &[[0.0, 0.0], [51.0, -9.0], [55.0, -9.0], [1.0, 1.0]].map(places));
    refused("TRANS DATUM TABLE TABLINE5\n", "from a table");
    refused("TRANS ROTATION ROT+30\n", "TRANS ROTATION turns");
    refused("TRANS DATUM AXIS C+30\n", "TRANS DATUM AXIS shifts or turns");
}

#[test]
fn parameters_are_computed_and_decide() {
    // Down by 3 mm a pass, three passes in all.
    let program = run("Q22 = - 3\nFN 1: Q1 = +Q22 + +1\nLBL 2\nL Z+Q22 F300\nQ22 = Q22 - 3\n\
         FN 11: IF +Q22 GT -10 GOTO LBL 2\nL Z+Q1\n")
    .unwrap();
    let z: Vec<f64> = places(&program)[1..].iter().map(|(_, at)| at.z).collect();
    assert_eq!(z.len(), 4, "{z:?}");
    z.iter().zip([-3.0, -6.0, -9.0, -2.0]).for_each(|(found, expected)| close(*found, expected));
    // What a formula that is not read would have set is not known.
    refused("Q1 = 5\nQ1 = FOO 5\nL X+Q1 F300\n", "the block that would set it is refused");
    refused("LBL 2\nL X+1 F300\nFN 9: IF +1 EQU +1 GOTO LBL 2\n", "too long");
}

#[test]
fn words_as_posts_write_them() {
    // Blanks before numbers, a plane that does not tilt, a way back of 20 mm, a cycle without `~`.
    let text = "BEGIN PGM A MM\nTOOL CALL 1 Z S 1500,000\nPLANE SPATIAL SPA+0 SPB+0 SPC+0 STAY\n\
                L A+Q120 C+Q122 FMAX\nL X+0 Y+0 Z+10 R0 FMAX M3\nCYCL DEF 200 DRILLING\n  Q200=2 ;SET-UP\n  Q201=-5\n  Q206=150\n\
                Q203=+0\n7 L X+15 R0 FMAX M99\nL M140 MB 20 FMAX\nL M140 MB MAX\nEND PGM A MM\n";
    let program = read(text.as_bytes(), Dialect::Heidenhain, &settings()).unwrap();
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 10.0]),
            ('L', [15.0, 0.0, 10.0]),
            ('L', [15.0, 0.0, 2.0]),
            ('L', [15.0, 0.0, -5.0]),
            ('L', [15.0, 0.0, 2.0]),
            ('L', [15.0, 0.0, 22.0]),
        ],
    );
    assert_eq!(program.spindle[0].spindle, detune::program::Spindle::Turns(Some(1500.0)));
}
