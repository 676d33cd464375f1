//! Sinumerik's other ways to say where a block goes: polar coordinates, arcs through a point and
//! on from the block before, lines by their angle, rows and circles of holes; and taps.

use detune::motion::{Target, Timing};
use detune::notes::Code;
use detune::program::{Dialect, NewSpeed, Program, Rewrite, Spindle, read, rewrite};
use nalgebra::Vector3;

use super::support::{Begun, assert_ends, end, settings};

const HEAD: &str = "G710 G17 G90 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z50\nF120\n";

const BEGUN: Begun = Begun { head: HEAD, at_mm: [0.0, 0.0, 50.0], dialect: Dialect::Sinumerik };

/// Points on the way of the arcs, mm.
fn on_the_way(program: &Program) -> Vec<Vector3<f64>> {
    let via = |each: &detune::motion::Move| match &each.to {
        Target::Arc { via, .. } => Some(via.translation.vector * 1000.0),
        _ => None,
    };
    program.moves.iter().filter_map(via).collect()
}

#[track_caller]
fn assert_on_the_way(program: &Program, expected: &[[f64; 3]]) {
    let found = on_the_way(program);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - Vector3::from(*expected)).norm() < 1e-6, "{found}, {expected:?}");
    }
}

#[test]
fn polar_coordinates_count_from_their_pole() {
    let half = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    let program = BEGUN.assert_way(
        "G111 X20 Y10\nG1 AP=0 RP=10\nG3 AP=90\nG1 AP=180 RP=5 Z40\n\
         G110 X5\nAP=270 RP=10\nG112 Y10\nAP=0 RP=1\n",
        &[
            ('L', [30.0, 10.0, 50.0]),
            ('A', [20.0, 20.0, 50.0]),
            ('L', [15.0, 10.0, 40.0]),
            // 5 mm beside where the tool was.
            ('L', [20.0, 0.0, 40.0]),
            // 10 mm beside the pole before.
            ('L', [21.0, 20.0, 40.0]),
        ],
    );
    assert_on_the_way(&program, &[[20.0 + half, 10.0 + half, 50.0]]);
    // Without a pole: from the zero of the work, which TRANS shifts.
    BEGUN.assert_way("G1 AP=90 RP=7\n", &[('L', [0.0, 7.0, 50.0])]);
    BEGUN.assert_way("TRANS X3\nG1 AP=90 RP=7\n", &[('L', [3.0, 7.0, 50.0])]);
    // In Z/X angles count from Z.
    BEGUN.assert_way("G18\nG111 Z40 X0\nG1 AP=90 RP=7\n", &[('L', [7.0, 0.0, 40.0])]);
    BEGUN.refused("G1 AP=IC(10) RP=5\n", "relative polar");
    BEGUN.refused("G91 G1 AP=10 RP=5\n", "relative polar");
    BEGUN.refused("G1 AP=10\n", "without a radius");
    BEGUN.refused("G1 AP=10 RP=5 X3\n", "beside an axis");
    BEGUN.refused("G111 AP=10 RP=5\n", "a pole in polar");
    // Another pole ends what holds of the one before.
    BEGUN.refused("G1 AP=10 RP=5\nG111 X5 Y5\nG1 AP=10\n", "without a radius");
}

/// AR=: the opening angle, with the centre or with the end.
#[test]
fn an_arc_by_its_opening_angle() {
    let off = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    let quarter = BEGUN.assert_way("G3 AR=90 I=AC(10) J=AC(0)\n", &[('A', [10.0, -10.0, 50.0])]);
    assert_on_the_way(&quarter, &[[10.0 - off, -off, 50.0]]);
    BEGUN.assert_way("G2 AR=90 I10\n", &[('A', [10.0, 10.0, 50.0])]);
    // A helix: the end along the axis of the plane stands beside the centre.
    let helix = BEGUN.run("G2 AR=90 I10 Z45\n").unwrap();
    let reached = end(helix.moves.last().unwrap()).1.translation.vector * 1000.0;
    assert!((reached - Vector3::new(10.0, 10.0, 45.0)).norm() < 1e-6, "{reached}");
    // About (0, 10), and the long way about (10, 0).
    let short = BEGUN.assert_way("G3 X10 Y10 AR=90\n", &[('A', [10.0, 10.0, 50.0])]);
    assert_on_the_way(&short, &[[off, 10.0 - off, 50.0]]);
    let long = BEGUN.run("G3 X10 Y10 AR=270\n").unwrap();
    let about = on_the_way(&long)[0] - Vector3::new(10.0, 0.0, 50.0);
    assert!((about.norm() - 10.0).abs() < 1e-6 && about.y < 1e-6, "{about}");
    BEGUN.refused("G3 AR=90\n", "one of the two");
    BEGUN.refused("G3 AR=90 X10 Y10 I10\n", "one of the two");
    BEGUN.refused("G3 AR=360 I10\n", "between 0 and 360");
    BEGUN.refused("G3 X5 AR=90 CR=9\n", "beside a radius");
    BEGUN.refused("G1 X5 AR=90\n", "write G2 or G3");
}

#[test]
fn an_arc_through_a_point() {
    // Half a circle about (10, 0), through its point at 120°.
    let y = 75.0_f64.sqrt();
    let program =
        BEGUN.assert_way(&format!("CIP X20 Y0 I1=5 J1={y}\n"), &[('A', [20.0, 0.0, 50.0])]);
    assert_on_the_way(&program, &[[10.0, 10.0, 50.0]]);
    let relative = BEGUN.run("G1 X0 Y0\nG91\nCIP X20 Y0 I1=10 J1=10\n").unwrap();
    assert_on_the_way(&relative, &[[10.0, 10.0, 50.0]]);
    // From above down, and up again, in the plane X = 0.
    let program = BEGUN.assert_way("CIP X0 Y10 I1=0 J1=5 K1=45\n", &[('A', [0.0, 10.0, 50.0])]);
    assert_on_the_way(&program, &[[0.0, 5.0, 45.0]]);
    BEGUN.refused("CIP X20 I1=10\n", "on one line");
    BEGUN.refused("CIP X20\n", "on one line");
}

#[test]
fn an_arc_goes_on_from_the_block_before() {
    // A quarter about (10, 10), then one the other way round about (30, 10).
    let off = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    let program = BEGUN.assert_way(
        "G1 X10\nCT X20 Y10\nX30 Y20\nG1 Y30\n",
        &[
            ('L', [10.0, 0.0, 50.0]),
            ('A', [20.0, 10.0, 50.0]),
            ('A', [30.0, 20.0, 50.0]),
            ('L', [30.0, 30.0, 50.0]),
        ],
    );
    let on_the_way = [[10.0 + off, 10.0 - off, 50.0], [30.0 - off, 10.0 + off, 50.0]];
    assert_on_the_way(&program, &on_the_way);
    // Behind three quarters of a circle about (0, 10), which end at (-10, 10) towards -y.
    let program = BEGUN.run("G3 X-10 Y10 I0 J10\nCT X0 Y0\n").unwrap();
    let last = on_the_way_of_last(&program);
    let off = Vector3::new(-off, 10.0 - off, 50.0) - last;
    assert!(off.norm() < 1e-6, "{last}");
    BEGUN.assert_way("G1 X10\nCT X20\n", &[('L', [10.0, 0.0, 50.0]), ('L', [20.0, 0.0, 50.0])]);
    BEGUN.refused("G1 X10\nCT X5\n", "straight behind");
    BEGUN.refused("CT X5 Y5\n", "behind no line");
}

fn on_the_way_of_last(program: &Program) -> Vector3<f64> {
    *on_the_way(program).last().unwrap()
}

#[test]
fn a_line_by_its_angle() {
    BEGUN.assert_way(
        "G1 ANG=30 X10\nANG=90 Y20\nANG=-135 Y10\n",
        &[
            // 10 / √3.
            ('L', [10.0, 100.0_f64.sqrt() / 3.0_f64.sqrt(), 50.0]),
            ('L', [10.0, 20.0, 50.0]),
            ('L', [0.0, 10.0, 50.0]),
        ],
    );
    BEGUN.refused("G1 ANG=30 X-10\n", "does not lead");
    BEGUN.refused("G1 ANG=90 X10\n", "does not lead");
    BEGUN.refused("G1 ANG=30\nX10 Y10 ANG=60\n", "with one axis");
}

/// Where holes are drilled, in order: X and Y of the moves down to Z = -8 mm.
fn holes(text: &str) -> Vec<[f64; 2]> {
    let program = BEGUN.run(text).unwrap();
    let ends = program.moves.iter().map(|each| end(each).1.translation.vector * 1000.0);
    ends.filter(|at| (at.z + 8.0).abs() < 1e-6).map(|at| [at.x, at.y]).collect()
}

#[track_caller]
fn assert_holes(text: &str, expected: &[[f64; 2]]) {
    let found = holes(text);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        assert!(off < 1e-6, "{text}: {found:?}, expected {expected:?}");
    }
}

#[test]
fn rows_and_circles_of_holes() {
    let cycle = "MCALL CYCLE81(20,0,2,-8)\n";
    // From (10, 5) on, the first 5 mm away.
    let row = format!("{cycle}HOLES1(10,5,0,5,10,3)\nMCALL\n");
    assert_holes(&row, &[[15.0, 5.0], [25.0, 5.0], [35.0, 5.0]]);
    // Begun at the end that is nearer.
    assert_holes(&format!("G0 X90\n{row}"), &[[35.0, 5.0], [25.0, 5.0], [15.0, 5.0]]);
    assert_holes(&format!("{cycle}HOLES1(10,5,90,5,10,2)\n"), &[[10.0, 10.0], [10.0, 20.0]]);
    let circle = [[40.0, 20.0], [30.0, 30.0], [20.0, 20.0], [30.0, 10.0]];
    assert_holes(&format!("{cycle}HOLES2(30,20,10,0,0,4)\n"), &circle);
    let off = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    let two = [[30.0, 30.0], [30.0 - off, 20.0 + off]];
    assert_holes(&format!("{cycle}HOLES2(30,20,10,90,45,2)\n"), &two);
    // Between holes the tool stays at RTP.
    let heights: Vec<f64> = BEGUN
        .run(&row)
        .unwrap()
        .moves
        .iter()
        .map(|each| end(each).1.translation.z * 1000.0)
        .collect();
    let hole = [2.0, -8.0, 2.0, 20.0];
    let expected = [&[50.0, 50.0][..], &hole, &[20.0], &hole, &[20.0], &hole].concat();
    assert!(heights.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{heights:?}");
    assert_eq!(heights.len(), expected.len());
    BEGUN.refused("HOLES1(10,5,0,5,10)\n", "six words");
    BEGUN.refused("HOLES2(10,5,5,0,0,2.5)\n", "whole number");
    BEGUN.refused("HOLES2(10,5,5,0,0,2,1)\n", "behind the 6th");
    BEGUN.refused("HOLES1(10,5,0,5,10,3) X5\n", "block of its own");
}

#[test]
fn a_tap_goes_in_and_out_by_its_pitch() {
    for pitch in [",1.25", "8,", "-8,-1.25"] {
        let text = format!("CYCLE84(20,0,2,-8,,0,3,{pitch},90,400,800)\nG1 X5 F100\n");
        let program = BEGUN.assert_way(
            &text,
            &[
                ('L', [0.0, 0.0, 2.0]),
                ('L', [0.0, 0.0, -8.0]),
                ('L', [0.0, 0.0, 2.0]),
                ('L', [0.0, 0.0, 20.0]),
                ('L', [5.0, 0.0, 20.0]),
            ],
        );
        // 1.25 mm in each of 400 and of 800 turns a minute.
        for (index, expected) in [(2, 500.0), (3, 1000.0)] {
            let feed = program.moves[index].feed_m_per_s * 6e4;
            assert!((feed - expected).abs() < 1e-9, "{pitch}: {feed}");
        }
        let spindle = |index: usize| program.moves[index].stated.spindle;
        let speeds = [(1, 3000.0), (2, 400.0), (3, 800.0)];
        for (index, rpm) in speeds {
            assert_eq!(spindle(index), Some(Spindle::Turns(Some(rpm))), "{pitch}: {index}");
        }
        assert_eq!(spindle(5), Some(Spindle::Turns(Some(3000.0))));
        let doubts = program.warnings.iter().filter(|note| note.code == Code::SpindleCommand);
        assert!(doubts.into_iter().any(|note| note.what.contains("tapping")), "{pitch}");
    }
    let stopped = BEGUN.run("CYCLE84(20,0,2,-8,,0,5,,1,0,200)\nG0 X5\n").unwrap();
    assert_eq!(stopped.moves.last().unwrap().stated.spindle, Some(Spindle::Stands));
    BEGUN.refused("CYCLE84(20,0,2,-8,,0,3,,,0,200)\n", "no MPIT and no PIT");
    BEGUN.refused("CYCLE84(20,0,2,-8,,0,3,8,1,0,200)\n", "different pitches");
    BEGUN.refused("CYCLE84(20,0,2,-8,,0,3,7,,0,200)\n", "no pitch of its own");
    BEGUN.refused("CYCLE84(20,0,2,-8,,0,3,,1)\n", "no SST");
    BEGUN.refused("CYCLE84(20,0,2,-8,,0,3,,1,0,200,200,,2)\n", "another unit");
    BEGUN.refused("CYCLE84(20,0,2,-8,,0,3,,1,0,200,200,,,,1)\n", "several strokes");
    BEGUN.refused("MCALL CYCLE840(20,0,2,-8)\n", "CYCLE840");
}

#[test]
fn the_retraction_plane_may_lie_below_the_clearance() {
    BEGUN.assert_way(
        "CYCLE81(1,0,2,-8)\n",
        &[('L', [0.0, 0.0, 2.0]), ('L', [0.0, 0.0, -8.0]), ('L', [0.0, 0.0, 1.0])],
    );
    // At the feed up to the clearance, and from there back.
    BEGUN.assert_way(
        "CYCLE85(1,0,2,-8,,0,80,200)\n",
        &[
            ('L', [0.0, 0.0, 2.0]),
            ('L', [0.0, 0.0, -8.0]),
            ('L', [0.0, 0.0, 2.0]),
            ('L', [0.0, 0.0, 1.0]),
        ],
    );
}

#[test]
fn chips_are_broken_at_the_feed() {
    let program = BEGUN.run("CYCLE83(20,0,2,-12,,,5,0,0,0,1,0)\n").unwrap();
    // To 2 mm, to -5 mm, 1 mm back.
    let back = &program.moves[3];
    assert!((end(back).1.translation.z * 1000.0 + 4.0).abs() < 1e-9);
    assert_eq!(back.timing, Timing::Feed);
    assert!((back.feed_m_per_s * 6e4 - 120.0).abs() < 1e-9);
    let out = BEGUN.run("CYCLE83(20,0,2,-12,,,5,0,0,0,1,1)\n").unwrap();
    assert_eq!(out.moves[3].timing, Timing::Rapid);
}

#[test]
fn what_a_block_sets_is_not_read_in_it() {
    BEGUN.refused("R1=10 R2=R1*2\nG1 X=R2\n", "R1 is read in the block that sets it");
    BEGUN.refused("R1=10 G1 X=R1\n", "R1 is read in the block that sets it");
    BEGUN.refused("DEF INT _n\n_n=3 G1 X=_n\n", "read in the block that sets it");
    let fifth = [('L', [5.0, 0.0, 50.0])];
    BEGUN.assert_way("R1=4\nR1=R1+1\nG1 X=R1\n", &fifth);
    BEGUN.assert_way("R1=5\nG1 X=R1 R1=7\n", &fifth);
    BEGUN.assert_way("R1=5 R2=7\nG1 X=R1\n", &fifth);
}

#[test]
fn moves_without_the_tools_length_are_a_doubt() {
    let doubts = |text: &str| {
        let program = BEGUN.run(text).unwrap();
        let told = program.warnings.into_iter().filter(|note| note.what.contains("under D0"));
        told.map(|note| (note.code, note.place.line)).collect::<Vec<_>>()
    };
    assert_eq!(doubts("D0\nG1 X5\n"), [(Code::ChangeIgnored, Some(7))]);
    assert_eq!(doubts("D0\nCYCLE81(20,0,2,-8)\n"), [(Code::ChangeIgnored, Some(7))]);
    assert_eq!(doubts("D0\nD1\nG1 X5\n"), []);
    // The way to the change, and the new tool, whose first length holds.
    assert_eq!(doubts("SUPA G0 Z500 D0\nT2 M6\nM3\nG0 X0 Y0 Z50\nG1 X5\n"), []);
}

/// The new forms state no speed of their own: the words of others are written anew around them.
#[test]
fn programs_with_patterns_are_rewritten() {
    let text = format!(
        "{HEAD}MCALL CYCLE81(20,0,2,-8)\nHOLES2(30,20,10,0,0,4)\nMCALL\nG111 X5\n\
         G1 AP=90 RP=4 F600\nCT X0 Y20\nCIP X9 Y9 I1=9 J1=30\nG1 ANG=0 X20\nM30\n"
    );
    let speeds = vec![NewSpeed { end: usize::MAX, rpm: 6000.0, job_rpm: None }];
    let to = Rewrite { speeds, keeps_chip_load: true };
    let found = rewrite(text.as_bytes(), Dialect::Sinumerik, &settings(), &to).unwrap();
    let expected = text.replace("S3000", "S6000").replace("F120", "F240").replace("F600", "F1200");
    assert_eq!(String::from_utf8(found.bytes).unwrap(), expected);
    // Of a tap, whose speed is an argument, nothing is.
    let tap = format!("{HEAD}CYCLE84(20,0,2,-8,,0,3,,1,0,200)\nM30\n");
    let speeds = vec![NewSpeed { end: usize::MAX, rpm: 6000.0, job_rpm: None }];
    let to = Rewrite { speeds, keeps_chip_load: true };
    assert!(rewrite(tap.as_bytes(), Dialect::Sinumerik, &settings(), &to).is_err());
}

/// A circle of holes states where it begins.
#[test]
fn holes2_needs_no_place_before_it() {
    let text = "G710 G17 G90 G94\nT1 M6\nS3000 M3 F200\nG0 Z50\nMCALL CYCLE81(50,0,2,-10)\n\
                HOLES2(100,100,30,0,0,2)\nMCALL\nM30\n";
    let program = read(text.as_bytes(), Dialect::Sinumerik, &settings()).unwrap();
    let hole = |x: f64| [50.0, 2.0, -10.0, 2.0, 50.0].map(|z| ('L', [x, 100.0, z]));
    assert_ends(&program, &[hole(130.0), hole(70.0)].concat());
    let row = text.replace("HOLES2(100,100,30,0,0,2)", "HOLES1(100,100,0,0,30,2)");
    let found = read(row.as_bytes(), Dialect::Sinumerik, &settings()).unwrap_err();
    assert!(found[0].what.contains("X is not known before the cycle"), "{found:?}");
}

#[test]
fn turns_labels_and_functions_that_are_not_read_are_named() {
    BEGUN.refused("AROT RPL=90\n", "AROT shifts or turns the work");
    BEGUN.refused("ROT RPL=90\n", "ROT shifts or turns the work");
    BEGUN.refused("G1 X5 RPL=9\n", "'RPL=' is not understood");
    BEGUN.refused("L1: G1 X5\n", "two letters or underscores");
    BEGUN.refused("@613 R304 R305\n", "older controls");
    BEGUN.assert_way("TRANS X3\nROT RPL=0\nG1 X5\n", &[('L', [5.0, 0.0, 50.0])]);
}

#[test]
fn a_feed_of_one_block() {
    let program = BEGUN.run("G1 X5 FB=600\nX10\nCIP X20 Y0 I1=15 J1=5 FB=300\n").unwrap();
    let feeds: Vec<f64> =
        program.moves[1..].iter().map(|each| (each.feed_m_per_s * 6e4).round()).collect();
    assert_eq!(feeds, [600.0, 120.0, 300.0]);
    let text = format!("{HEAD}G1 X5 FB=600\nX10\nM30\n");
    let speeds = vec![NewSpeed { end: usize::MAX, rpm: 6000.0, job_rpm: None }];
    let to = Rewrite { speeds, keeps_chip_load: true };
    let found = rewrite(text.as_bytes(), Dialect::Sinumerik, &settings(), &to).unwrap();
    let expected =
        text.replace("S3000", "S6000").replace("F120", "F240").replace("FB=600", "FB=1200");
    assert_eq!(String::from_utf8(found.bytes).unwrap(), expected);
}
