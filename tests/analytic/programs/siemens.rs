//! Sinumerik's drilling cycles and helices of several turns.

use detune::motion::Timing;
use detune::notes::{Code, Note};
use detune::program::{Companion, Dialect, Program, RotaryAxis, Settings, read};

use super::support::{assert_ends, at, end, settings};

const HEAD: &str = "G710 G17 G90 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z50\nF120\n";

fn run(text: &str) -> Result<Program, Vec<Note>> {
    read(format!("{HEAD}{text}M30\n").as_bytes(), Dialect::Sinumerik, &settings())
}

fn refused(text: &str, said: &str) {
    let found = run(text).expect_err(text);
    assert!(found.iter().any(|note| note.what.contains(said)), "{text}: {found:?}");
}

/// Heights in mm of the moves behind the first.
fn heights(text: &str) -> Vec<f64> {
    let program = run(text).unwrap();
    program.moves[1..].iter().map(|each| end(each).1.translation.z * 1000.0).collect()
}

#[track_caller]
fn assert_heights(text: &str, expected: &[f64]) {
    let found = heights(text);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found}, expected {expected}: {text}");
    }
}

#[test]
fn a_cycle_drills_at_every_position_behind_mcall() {
    let program =
        run("MCALL CYCLE82(20,0,2,-8,,0.5)\nX10 Y5\nX20\nMCALL\nG0 X30\nCYCLE81(20,0,2,,4)\n")
            .unwrap();
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 50.0]),
            ('L', [10.0, 5.0, 50.0]),
            ('L', [10.0, 5.0, 2.0]),
            ('L', [10.0, 5.0, -8.0]),
            // A dwell.
            ('T', [10.0, 5.0, -8.0]),
            ('L', [10.0, 5.0, 2.0]),
            ('L', [10.0, 5.0, 20.0]),
            ('L', [20.0, 5.0, 20.0]),
            ('L', [20.0, 5.0, 2.0]),
            ('L', [20.0, 5.0, -8.0]),
            ('T', [20.0, 5.0, -8.0]),
            ('L', [20.0, 5.0, 2.0]),
            ('L', [20.0, 5.0, 20.0]),
            ('L', [30.0, 5.0, 20.0]),
            // DPR: 4 mm below the reference plane.
            ('L', [30.0, 5.0, 2.0]),
            ('L', [30.0, 5.0, -4.0]),
            ('L', [30.0, 5.0, 2.0]),
            ('L', [30.0, 5.0, 20.0]),
        ],
    );
    let feed = program.moves[3].feed_m_per_s * 6e4;
    assert!((feed - 120.0).abs() < 1e-9, "{feed}");
    // Parameters may be computed; a shift of the work moves the hole.
    assert_heights("R1=-8\nCYCLE81(R1+28,0,2,R1)\n", &[2.0, -8.0, 2.0, 20.0]);
}

/// CYCLE83 (Siemens, Fundamentals, "Deep-hole drilling").
#[test]
fn deep_holes() {
    // Chips out: back to the clearance, again to 0.6 mm over the last depth.
    assert_heights(
        "CYCLE83(20,0,2,-12,,-5,,0,0,0,1,1)\n",
        &[2.0, -5.0, 2.0, -4.4, -10.0, 2.0, -9.4, -12.0, 2.0, 20.0],
    );
    // Chips broken: 1 mm back.
    assert_heights(
        "CYCLE83(20,0,2,-12,,,5,0,0,0,1,0)\n",
        &[2.0, -5.0, -4.0, -10.0, -9.0, -12.0, 2.0, 20.0],
    );
    assert_heights(
        "CYCLE83(20,0,2,-20,,,8,2,0,0,1,0,,,1)\n",
        &[2.0, -8.0, -7.0, -14.0, -13.0, -18.0, -17.0, -20.0, 2.0, 20.0],
    );
    // Each stroke 2 mm less than the one before, down to 2 mm, the last two equal.
    assert_heights(
        "CYCLE83(20,0,2,-15,,-6,,2,0,0,1,0,,,0.5)\n",
        &[2.0, -6.0, -5.5, -10.0, -9.5, -12.0, -11.5, -13.5, -13.0, -15.0, 2.0, 20.0],
    );
    // As a post of Fusion writes it, with modes, and a dwell above the hole.
    assert_heights(
        "MCALL CYCLE83(20,0,2,-6,,-3,,0,,0.5,1,1,,3,1,0,0.5,0,0,1001110)\nX0\nMCALL\n",
        &[50.0, 2.0, -3.0, 2.0, 2.0, -2.5, -6.0, 2.0, 20.0],
    );
}

/// The sixth digit of `_AMODE` from the right has DAM in percent of the stroke before: 10, 8, and
/// instead of 6.4 the least stroke, 7, of which the last two are equal.
#[test]
fn strokes_of_deep_holes_in_percent() {
    let call = |words: &str| format!("CYCLE83(20,0,2,{words})\n");
    assert_heights(
        &call("-28,,,10,80,0,0,100,1,0,7,0,0,1,0,1,11211112"),
        &[2.0, -10.0, 2.0, -9.0, -18.0, 2.0, -17.0, -23.0, 2.0, -22.0, -28.0, 2.0, 20.0],
    );
    assert_heights(
        &call("-20,,,10,100,0,0,1,1,0,0,0,0,1,0,1,11211112"),
        &[2.0, -10.0, 2.0, -9.0, -20.0, 2.0, 20.0],
    );
    for (words, said) in [
        ("-28,,,10,80,0,0,1,1,0,7,0,0,1,0,1,11311112", "digit 6 from the right is 3"),
        ("-28,,,10,80,0,0,1,1,0,7,0,0,1,0,1,12211112", "digit 7 from the right is 2"),
        ("-28,,,10,0,0,0,1,1,0,7,0,0,1,0,1,11211112", "DAM is 0"),
        ("-28,,,10,80,0,0,1,1,0,0,0,0,1,0,1,11211112", "_MDEP"),
        ("-28,,,10,80,0,0,50,1,0,7,0,0,1,0,1,11211112", "FRF=50"),
        ("-28,,,10,2,0,0,100,1", "FRF=100"),
    ] {
        refused(&call(words), said);
    }
}

/// What 1 is beside `_AMODE`, the whole feed or one percent of it, is not known.
#[test]
fn a_feed_factor_of_one_beside_amode_is_a_doubt() {
    for (words, count) in
        [("1,1,0,0,0,0,1,0,1,11211112", 1), ("100,1,0,0,0,0,1,0,1,11211112", 0), ("1,1", 0)]
    {
        let program = run(&format!("CYCLE83(20,0,2,-20,,,10,100,0,0,{words})\n")).unwrap();
        let told = |note: &&Note| note.what.contains("FRF of CYCLE83");
        let told: Vec<_> = program.warnings.iter().filter(told).collect();
        assert_eq!(told.len(), count, "{words}: {told:?}");
        assert!(told.iter().all(|note| note.code == Code::ChangeIgnored));
    }
}

/// DTB and DTS are seconds where they are positive: at the bottom of both pecks, and once over the
/// hole. Nothing says a speed.
#[test]
fn dwells_of_deep_holes_need_a_speed_for_turns_alone() {
    let of = |call: &str| {
        let text = format!("{HEAD}{call}M30\n").replace("S3000 ", "");
        read(text.as_bytes(), Dialect::Sinumerik, &settings())
    };
    let program = of("CYCLE83(5,0,2,-10,,-5,,0,0.1,0.5,1,1)\n").unwrap();
    let dwells: Vec<Timing> = program.moves.iter().map(|each| each.timing).collect();
    let dwells: Vec<_> = dwells.into_iter().filter(|t| matches!(t, Timing::Seconds(_))).collect();
    assert_eq!(dwells, [0.1, 0.5, 0.1].map(Timing::Seconds));
    let turns = of("CYCLE83(5,0,2,-10,,-5,,0,-3,0.5,1,1)\n").unwrap_err();
    assert!(turns[0].what.contains("a dwell in turns"), "{turns:?}");
}

#[test]
fn synchronized_actions_are_refused_by_their_name() {
    for action in [
        "WHEN $A_IN[1]==1 DO M8",
        "WHENEVER $A_IN[1] DO $AC_OVR=0",
        "N7 ID=1 EVERY $A_IN[1]==1 DO M8",
        "IDS=2 DO $AC_OVR=50",
        "G1 X5 WHEN $A_IN[1] DO M8",
    ] {
        let found = run(&format!("{action}\nG1 X5\n")).unwrap_err();
        assert_eq!((found.len(), at(&found[0])), (1, 6), "{action}: {found:?}");
        assert!(found[0].what.contains("a synchronized action"), "{action}: {found:?}");
    }
    assert!(run("MSG(\"WHEN COLD DO WAIT\")\nG1 X5\n").is_ok());
}

#[test]
fn reaming_has_feeds_of_its_own() {
    let program = run("CYCLE85(20,0,2,-8,,0,80,200)\n").unwrap();
    let feeds: Vec<f64> = program.moves[2..4].iter().map(|each| each.feed_m_per_s * 6e4).collect();
    assert!((feeds[0] - 80.0).abs() < 1e-9 && (feeds[1] - 200.0).abs() < 1e-9, "{feeds:?}");
    // Under G70 lengths are inches, feeds stay as they are.
    let inches = run("G70\nCYCLE85(1,0,.1,-1,,0,80,200)\n").unwrap();
    let feed = inches.moves[2].feed_m_per_s * 6e4;
    assert!((feed - 80.0).abs() < 1e-9, "{feed}");
}

#[test]
fn what_is_not_clear_is_refused() {
    refused("G81 X8 Y0 R3=-.023 CR=3 R10=10.5\n", "840C");
    refused("MCALL CYCLE86(20,0,2,-8,,0,3,,1,0,200,200)\nX5\n", "CYCLE86");
    refused("MCALL POCKET3(20,0,2,-8)\nX5\n", "MCALL");
    refused("CYCLE81(20,0,2,-8,5)\n", "different depths");
    // No relative depth.
    assert_heights("CYCLE81(20,0,2,-8,0)\n", &[2.0, -8.0, 2.0, 20.0]);
    refused("CYCLE81(20,0,2)\n", "no DP and no DPR");
    refused("CYCLE81(20,0,2,8)\n", "below RFP");
    refused("CYCLE81(-20,0,2,-8)\n", "RTP");
    refused("CYCLE83(20,0,2,-8,,-3,,0,0,0,0.5,1)\n", "FRF");
    refused("CYCLE83(20,0,2,-8)\n", "no FDEP");
    refused("CYCLE83(20,0,2,-8,,-3,,-0.5)\n", "_MDEP");
    refused("CYCLE82(20,0,2,-8,,0,1,0,0)\n", "shank");
    refused("SUPA G0 X0\nCYCLE81(20,0,2,-8)\n", "X is not known before the cycle: program X");
    refused("CYCLE81(20,0,2,-8*)\n", "expression");
    refused("CYCLE83(20,0,2,-8,,-3,,0,0,0,1,1,1)\n", "_AXN");
    refused("CYCLE81(20,0,2,-8,,,0,2,0)\n", "_DMODE");
    assert_heights("CYCLE81(20,0,2,-8,,,0,1,0)\n", &[2.0, -8.0, 2.0, 20.0]);
    refused("CYCLE82(20,0,2,-8,,0,0,0,0,5)\n", "not supported");
    refused("CYCLE81(20,0,2,-8) F300\n", "block of its own");
    // A hole behind every block that moves, which turned work does not have.
    let turned = Settings {
        rotary_axes: vec![RotaryAxis {
            letter: b'A',
            axis: nalgebra::Vector3::x_axis(),
            turns_work: true,
            origin_mm: nalgebra::Vector3::zeros(),
        }],
        ..settings()
    };
    let text = format!("{HEAD}MCALL CYCLE81(20,0,2,-8)\nX10\nA90\nMCALL\nM30\n");
    let found = read(text.as_bytes(), Dialect::Sinumerik, &turned).unwrap_err();
    assert!(found[0].what.contains("turned work"), "{found:?}");
}

/// As G81 is.
#[test]
fn cycles_across_a_tilted_tool_are_refused() {
    let rotary_axes = vec![RotaryAxis {
        letter: b'A',
        axis: nalgebra::Vector3::x_axis(),
        turns_work: false,
        origin_mm: nalgebra::Vector3::zeros(),
    }];
    let tilted = Settings { rotary_axes, ..settings() };
    let of =
        |text: &str| read(format!("{HEAD}{text}M30\n").as_bytes(), Dialect::Sinumerik, &tilted);
    for text in [
        "G0 A30\nCYCLE81(20,0,2,-8)\n",
        "MCALL CYCLE81(20,0,2,-8)\nX10\nA30\nMCALL\n",
        "TRAORI\nG0 X5 A3=0.6 C3=0.8\nCYCLE84(20,0,2,-8,,0,3,,1,0,300,300)\n",
        "TRAORI\nG0 X5 A3=0.6 C3=0.8\nMCALL CYCLE82(20,0,2,-8,,0)\nX10\nMCALL\n",
    ] {
        let found = of(text).expect_err(text);
        assert!(found[0].what.contains("across the tool"), "{text}: {found:?}");
    }
    let straight = of("TRAORI\nG0 X5 C3=1\nG0 A30\nA0\nCYCLE81(20,0,2,-8)\n").unwrap();
    let last = end(&straight.moves[straight.moves.len() - 1]).1.translation.z;
    assert!((last - 0.02).abs() < 1e-9, "{last}");
}

/// A turn of the work carries the tool on an arc: the line that is read is one under TRAORI alone.
#[test]
fn turns_of_rotary_axes_in_one_move() {
    let turned = Settings {
        rotary_axes: vec![RotaryAxis {
            letter: b'C',
            axis: nalgebra::Vector3::z_axis(),
            turns_work: true,
            origin_mm: nalgebra::Vector3::zeros(),
        }],
        ..settings()
    };
    let told = |text: &str| -> Vec<usize> {
        let text = format!("{HEAD}G0 X40 Y0 Z0 C0\n{text}M30\n");
        let found = read(text.as_bytes(), Dialect::Sinumerik, &turned).unwrap();
        let doubts = found.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
        doubts.map(at).collect()
    };
    let first = HEAD.lines().count() + 2;
    for text in [
        "G1 C360 F720\n",
        "G1 C=IC(360) F720\n",
        "G1 C90 F720\n",
        "G1 X50 C-20 F300\n",
        "G0 C270\n",
    ] {
        assert_eq!(told(text), [first], "{text}");
    }
    for text in ["G0 C90\nG1 X50 F300\n", "G1 X41 C2 F300\nG1 X42 C4\n", "G0 C-180\n"] {
        assert_eq!(told(text), Vec::<usize>::new(), "{text}");
    }
}

/// Two whole turns beyond the quarter: so much longer than the quarter alone.
#[test]
fn helices_turn_as_often_as_they_say() {
    let turned = |text: &str| {
        let program = run(text).unwrap();
        let mut at = end(&program.moves[1]).1.translation.vector;
        let mut angle = 0.0;
        for each in &program.moves[2..] {
            let detune::motion::Target::Arc { via, end, .. } = &each.to else { panic!("{each:?}") };
            for to in [via, end] {
                let to = to.translation.vector;
                let [a, b] = [at, to].map(|v| v.y.atan2(v.x));
                angle += (b - a).rem_euclid(std::f64::consts::TAU);
                at = to;
            }
        }
        angle.to_degrees()
    };
    for (word, expected) in [("", 90.0), ("TURN=0", 90.0), ("TURN=2", 810.0)] {
        let found = turned(&format!("G0 X10 Y0\nG3 X0 Y10 Z40 I-10 J0 {word}\n"));
        assert!((found - expected).abs() < 1e-3, "{word}: {found}°");
    }
    refused("G0 X10\nG3 X0 Y10 I-10 J0 TURN=1.5\n", "whole number of turns");
}

/// Ends of lines in X alone, mm.
fn xs(text: &str) -> Vec<f64> {
    let program = run(text).unwrap();
    program.moves[1..].iter().map(|each| end(each).1.translation.x * 1000.0).collect()
}

#[track_caller]
fn assert_xs(text: &str, expected: &[f64]) {
    let found = xs(text);
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(found.len() == expected.len() && off < 1e-9, "{text}: {found:?}");
}

#[test]
fn jumps_conditions_and_loops() {
    assert_xs("R1=0\nLOOP1:\nR1=R1+1\nG1 X=R1*10\nIF R1<3 GOTOB LOOP1\n", &[10.0, 20.0, 30.0]);
    assert_xs("GOTOF N90\nG1 X1\nN90 G1 X2\n", &[2.0]);
    assert_xs("R1=1\nN10 G1 X=R1\nR1=R1+1\nIF (R1<=2) AND (R1<>5) GOTO N10\n", &[1.0, 2.0]);
    let branch =
        |r: f64| format!("R1={r}\nIF R1==1\nG1 X1\nELSE\nIF R1>4\nG1 X5\nENDIF\nENDIF\nX9\n");
    assert_xs(&branch(1.0), &[1.0, 9.0]);
    assert_xs(&branch(2.0).replace("X9", "G1 X9"), &[9.0]);
    assert_xs(&branch(7.0), &[5.0, 9.0]);
    assert_xs("DEF INT I\nFOR I = 1 TO 3\nG1 X=I*2\nENDFOR\nX9\n", &[2.0, 4.0, 6.0, 9.0]);
    assert_xs("FOR R1=3 TO 1\nG1 X5\nENDFOR\nG1 X9\n", &[9.0]);
    assert_xs("R1=2\nWHILE R1>0\nG1 X=R1\nR1=R1-1\nENDWHILE\n", &[2.0, 1.0]);
    assert_xs("R1=0\nREPEAT\nR1=R1+1\nG1 X=R1\nUNTIL R1>=2\n", &[1.0, 2.0]);
    assert_xs(
        "R1=0\nLOOP\nR1=R1+1\nG1 X=R1\nIF R1==2 GOTOF OUT\nENDLOOP\nOUT: X9\n",
        &[1.0, 2.0, 9.0],
    );
    // Once, and twice again.
    assert_xs("G91\nPART:\nG1 X1\nREPEAT PART P=2\n", &[1.0, 2.0, 3.0]);
    assert_xs("END: G1 X4\n", &[4.0]);
    // Of several jumps in a block, the first whose condition holds.
    for (r, expected) in [("1", &[5.0, 6.0][..]), ("2", &[6.0]), ("3", &[4.0, 5.0, 6.0])] {
        assert_xs(
            &format!("R1={r}\nG1\nIF R1==1 GOTOF LB IF R1==2 GOTOF LC\nX4\nLB: X5\nLC: X6\n"),
            expected,
        );
    }
    refused("R1=2\nIF R1==1 GOTOF LB GOTOF LC\nLB: G1 X1\nLC: X2\n", "'GOTOF LC' behind GOTOF LB");
    refused("R1=2\nIF R1==1 GOTOF N300 X99\nN300 G1 X1\n", "'X99' behind GOTOF N300 is not read");
    refused("GOTOF LB X50\nLB: G1 X1\n", "'X50' behind GOTOF LB is not read");
    // Exponents: 1.5·10¹, 0.25·10³ and -0.1·10⁻⁵ from 4.
    assert_xs("R1=1.5EX1\nG1 X=R1\nX=0.25ex+3\nR2=-0.1EX-5\nX=4+R2\n", &[15.0, 250.0, 3.999_999]);
    refused("MCALL L100\nG1 X1\n", "MCALL of a subprogram is not supported");
    // Whole numbers are rounded.
    assert_xs("DEF INT _n\n_n = 2.6\nG1 X=_n\n", &[3.0]);
    refused("LOOP\nENDLOOP\n", "too long");
    refused("IF R1>2\nG1 X1\nENDIF\n", "R1 is read");
    refused("R1=1\nIF R1>0\nG1 X1\n", "IF is not closed");
    refused("GOTOB NOWHERE\nG1 X1\n", "NOWHERE is not there");
    refused("G1 X1\nREPEAT PART P=2\n", "no label PART");
    refused("CASE R1 OF 1 GOTOF A\n", "R1 is read");
    refused("G1 X1\nPOCKET_A\n", "calls a subprogram");
}

/// GOTOF goes to the next of its places towards the end, GOTOB towards the beginning, GOTO and
/// GOTOC to either, the end first.
#[test]
fn labels_and_block_numbers_that_stand_more_than_once() {
    for [first, second] in [["MARK: ", "MARK"], ["N10 ", "N10"]] {
        let back = format!(
            "R1=0\n{first}G1 X=10+R1\nR1=R1+1\nIF R1<2 GOTOB {second}\nG0 X5\n\
             {first}G1 X=20+R1\nR1=R1+1\nIF R1<4 GOTOB {second}\n"
        );
        assert_xs(&back, &[10.0, 11.0, 5.0, 22.0, 23.0]);
        let ahead = format!("{first}G1 X1\nGOTOF {second}\nX2\n{first}X3\n{first}X4\n");
        assert_xs(&ahead, &[1.0, 3.0, 4.0]);
        for word in ["GOTO", "GOTOC"] {
            let either =
                format!("R1=0\n{first}R1=R1+1\nG1 X=R1\nIF R1<3 {word} {second}\nX7\n{first}X5\n");
            assert_xs(&either, &[1.0, 5.0]);
            let only = either.replace(&format!("{first}X5\n"), "");
            assert_xs(&only, &[1.0, 2.0, 3.0, 7.0]);
        }
    }
    assert_xs("GOTOC NOWHERE\nGOTOC N70\nG1 X1\n", &[1.0]);
    // What is worked out or malformed is not known to be absent.
    for target in ["\"N\"<<R1", "\"MARK\"", "R1", ""] {
        refused(&format!("R1=10\nGOTOC {target}\nG1 X1\nMARK: N10 X2\n"), "is not there");
    }
    refused("GOTOC N70 N80\nG1 X1\n", "'N80' behind GOTOC N70 is not read");
    refused("GOTOF NOWHERE\nG1 X1\n", "NOWHERE is not there");
    refused("MARK:\nG1 X1\nMARK:\nX2\nREPEAT MARK P=1\n", "more than once");
}

#[test]
fn a_case_jumps_by_its_value() {
    let places = "ZIEL8: X8\nZIEL9: X9\nZIEL0: X3\n";
    let all = [8.0, 9.0, 3.0];
    for (value, expected) in [("8", &all[..]), ("9", &all[1..]), ("-1", &all[2..])] {
        let text = format!(
            "R1={value}\nG1\nCASE(R1*2-R1) OF 8 GOTOF ZIEL8 9 GOTOF ZIEL9 DEFAULT GOTOF ZIEL0\n\
             X1\n{places}"
        );
        assert_xs(&text, expected);
    }
    let text = format!("R1=5\nG1\nCASE R1 OF 8 GOTOF ZIEL8\nX1\n{places}");
    assert_xs(&text, &[1.0, 8.0, 9.0, 3.0]);
    refused("R1=1\nCASE R1 OF\n", "CASE: expected");
    refused("R1=1\nCASE R1 OF 1 GOTOF\n", "CASE: expected");
    refused("R1=1\nCASE R1 OF DEFAULT GOTOF A 1 GOTOF B\n", "CASE: expected");
    refused("R1=1.5\nCASE R1 OF 1 GOTOF A\n", "whole number");
}

/// Values are handed over; what the subprogram does with them stays there.
#[test]
fn subprograms_have_parameters() {
    let with = |head: &str, text: &str| {
        let slot =
            format!("; A SLOT\n{head}\nIF COUNT>0\nG1 X=LONG Y=COUNT\nENDIF\nCOUNT=0\nRET\n");
        let slot = Companion { name: "SLOT.spf".to_owned(), text: slot };
        let text_of_l100 = "PROC L100(REAL DEEP)\nRET\n".to_owned();
        let l100 = Companion { name: "L100.spf".to_owned(), text: text_of_l100 };
        let companions = vec![slot, l100];
        let settings = Settings { companions, ..settings() };
        read(format!("{HEAD}{text}M30\n").as_bytes(), Dialect::Sinumerik, &settings)
    };
    let head = "PROC SLOT(REAL LONG, INT COUNT)";
    let text = "EXTERN SLOT(REAL, INT)\nDEF REAL COUNT\nR1=7\nCOUNT=1.5\nSLOT(R1+1.5, 2.6)\n\
                X=COUNT\nCOUNT=2.5\nX=COUNT\nSLOT(4,-1)\nSLOT(4,1)\n";
    assert_ends(
        &with(head, text).unwrap(),
        &[
            ('L', [0.0, 0.0, 50.0]),
            // The whole number is rounded, that of the caller is none.
            ('L', [8.5, 3.0, 50.0]),
            ('L', [1.5, 3.0, 50.0]),
            ('L', [2.5, 3.0, 50.0]),
            ('L', [4.0, 1.0, 50.0]),
        ],
    );
    // Of BOOL, any value but 0 is true, as an argument and by each assignment.
    let of_truths = "PROC SLOT(REAL LONG, BOOL COUNT)";
    let truths = "SLOT(1,5)\nSLOT(2,0.4)\nSLOT(3,0)\nDEF BOOL FLAG=0.4\nG1 X=4 Y=FLAG\n\
                  FLAG=-7\nX=5 Y=FLAG\n";
    assert_ends(
        &with(of_truths, truths).unwrap(),
        &[
            ('L', [0.0, 0.0, 50.0]),
            ('L', [1.0, 1.0, 50.0]),
            ('L', [2.0, 1.0, 50.0]),
            ('L', [4.0, 1.0, 50.0]),
            ('L', [5.0, 1.0, 50.0]),
        ],
    );
    for (head, text, said) in [
        (head, "SLOT(20)\n", "1 values for the 2 parameters"),
        (head, "SLOT\n", "0 values for the 2 parameters"),
        (head, "SLOT(20,)\n", "without a value"),
        (head, "SLOT(R5,1)\n", "R5 is read"),
        (head, "SLOT(20,1) P2\n", "P beside parameters"),
        ("PROC SLOT(VAR REAL LONG, INT COUNT)", "SLOT(20,1)\n", "called by value alone"),
        (head, "EXTERN L100(REAL)\nL100(5)\n", "a call by an L number with values"),
        ("PROC SLOT(STRING[5] LONG, INT COUNT)", "SLOT(20,1)\n", "called by value alone"),
    ] {
        let found = with(head, text).unwrap_err();
        assert!(found[0].what.contains(said), "{text}: {found:?}");
    }
}

/// ENDPROC ends what PROC begins.
#[test]
fn a_procedure_has_an_end() {
    let text = "PROC SLOT(REAL LONG)\nG1 X=LONG\nENDPROC\n".to_owned();
    let companions = vec![Companion { name: "SLOT.spf".to_owned(), text }];
    let settings = Settings { companions, ..settings() };
    let text = format!("{HEAD}SLOT(10)\nX20\nM30\n");
    let program = read(text.as_bytes(), Dialect::Sinumerik, &settings).unwrap();
    assert_ends(&program, &[0.0, 10.0, 20.0].map(|x| ('L', [x, 0.0, 50.0])));
}

/// It ends the subprogram alone, as M17 (Siemens, SINUMERIK 840D sl Job Planning, "Subprogram
/// call").
#[test]
fn m30_in_a_subprogram_goes_back() {
    for end in ["M30", "M2", "M17"] {
        let companions =
            vec![Companion { name: "L10.spf".into(), text: format!("G1 X10\n{end}\n") }];
        let settings = Settings { companions, ..settings() };
        let text = format!("{HEAD}L10\nX20\nM30\n");
        let program = read(text.as_bytes(), Dialect::Sinumerik, &settings).unwrap();
        assert_ends(&program, &[0.0, 10.0, 20.0].map(|x| ('L', [x, 0.0, 50.0])));
        let doubts = program.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
        assert_eq!(doubts.count(), usize::from(end != "M17"), "{:?}", program.warnings);
    }
}

#[test]
fn limits_of_an_axis_are_refused() {
    for word in ["FL[X]=500", "ACC[X]=50", "VELOLIM[X]=80"] {
        refused(&format!("{word}\nG1 X10\n"), "limits of an axis are not read");
    }
}

/// A file of several programs, as a control saves them.
#[test]
fn programs_in_one_file_are_to_be_split() {
    let text = format!("%_N_MAIN_MPF\n{HEAD}L10\nM30\n%_N_L10_SPF\nG1 X10\nM17\n");
    let found = read(text.as_bytes(), Dialect::Sinumerik, &settings()).unwrap_err();
    assert!(found[0].what.contains("a file of several programs"), "{found:?}");
    assert_eq!(at(&found[0]), 7);
}

#[test]
fn words_as_posts_write_them() {
    // NX has a mark of its own behind the header, Autodesk's post blanks round '='.
    let text = "%_N_PART_MPF\n%\nN10 G710 G90\nDEF REAL _ZHOME, _F\n_ZHOME = 20\n_F = 90\n\
                N20 G0 X0 Y0 Z = _ZHOME\nG1 X = 5 F = _F\nG0 SUPA Z=_Z_CHANGE D0\nM30\n";
    let program = read(text.as_bytes(), Dialect::Sinumerik, &settings()).unwrap();
    assert_ends(&program, &[('L', [0.0, 0.0, 20.0]), ('L', [5.0, 0.0, 20.0])]);
    assert!((program.moves[1].feed_m_per_s - 0.0015).abs() < 1e-12);
    refused("G0 Z=_Z_CHANGE\n", "'_z_change' is read");
    assert_xs("CTOL=0.01 DYNFINISH SPOS=90\nG1 X3 A=DC(0)\n", &[3.0]);
    // The zero is moved, and moved on, and back.
    assert_xs("TRANS X10\nG1 X1\nATRANS X5\nX1\nTRANS\nX1\n", &[11.0, 16.0, 1.0]);
    refused("TRANS X10 ROT Z5\nG1 X1\n", "shifts or turns");
    // What begins a frame anew ends the one before; what adds to it does not.
    assert_xs("TRANS X10\nROT\nG1 X1\nTRANS X5\nAROT Z0\nX1\n", &[1.0, 6.0]);
    assert_xs("R1=ATAN2(30,80)\nG1 X=R1\n", &[30.0_f64.atan2(80.0).to_degrees()]);
    // Arguments behind a blank are no comment.
    refused("CYCLE800 (0,\"TC1\",0,57,0,0,0,0,20,0,0,0,0,1)\n", "CYCLE800 shifts or turns");
    // The spindle stands at an angle.
    for block in ["SPOS=90", "M19"] {
        let program = run(&format!("G1 X1\n{block}\nX2\n")).unwrap();
        let last = program.moves.last().unwrap().stated.spindle;
        assert_eq!(last, Some(detune::program::Spindle::Stands), "{block}");
    }
    // Its fixed point: the values name axes alone.
    refused("G75 X0 Y0\nG1 Y5\n", "while X is not known");
    refused("R1=0\nR2=0\nIF R1 AND R2==1 GOTOF OUT\nOUT: X1\n", "put brackets");
    refused("A1: G1 X10\nENDLABEL:\nG1 X20\nREPEAT A1 P=2\n", "ENDLABEL");
    refused("G1 X10 RND=2 M5\nY10\n", "between two lines");
    // Skipped from a place in the block on, where the operator says so.
    let skipped = run("G1 X3 /M8\n").unwrap();
    assert!(skipped.warnings.iter().any(|note| note.code == Code::MotionLeftOut));
    // A chamfer of 4 mm at a right angle takes 2 √2 off each line.
    let program = run("G1 X10 CHF=4\nY10\n").unwrap();
    let off = 8.0_f64.sqrt();
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 50.0]),
            ('L', [10.0 - off, 0.0, 50.0]),
            ('L', [10.0, off, 50.0]),
            ('L', [10.0, 10.0, 50.0]),
        ],
    );
}

/// Setting data 42440 says whether a relative way takes a shift of the zero in.
#[test]
fn variables_and_modes_of_the_control() {
    // A timer runs by itself.
    assert_xs("$AC_TIMER[1]=0\nG1 X5\n", &[5.0]);
    for (text, said) in [
        ("$AC_TIMER[1]=0\nG1 X=$AC_TIMER[1]\n", "is read"),
        ("$P_UIFR[1,X,TR]=10\n", "$P_UIFR sets a work offset"),
        ("$P_PFRAME=CTRANS(X,10)\n", "$P_PFRAME sets a work offset"),
        ("$A_OUT[1]=1\n", "'$A_OUT' is a variable of the control"),
        ("DEFINE SPON AS S3000 M3\n", "DEFINE gives a text a name"),
        ("DIAMON\n", "DIAMON makes X a diameter"),
        ("BSPLINE\nX20 Y5\n", "BSPLINE begins a spline"),
        ("# TEXT\n", "'#' is no word of Sinumerik's"),
        ("G1 Z1=5\n", "'Z1=' is not understood"),
        ("SETMS(2)\n", "SETMS(2) makes another spindle the main one"),
        ("FXS[X]=0\n", "FXS[ ] is for the travel to a fixed stop"),
        ("PO[X]=(10,2)\n", "PO[ ] gives a polynomial"),
        ("OVRA[X]=50\n", "OVRA[X] is a word of the control for one axis"),
        ("SPOS[2]=90\n", "SPOS[2] is a word of the control for one axis or spindle"),
    ] {
        refused(text, said);
    }
    // No variable that the job could declare.
    let found = run("OVR=50\n").unwrap_err();
    assert!(found[0].what.ends_with("'OVR=' is not understood"), "{found:?}");
}

/// Siemens, SINUMERIK 840D sl/828D Fundamentals, "Contour accuracy": the control lowers the feed on
/// arcs.
#[test]
fn a_feed_that_the_contour_accuracy_lowers_is_a_doubt() {
    let doubts = |text: &str| {
        let notes = run(text).unwrap().warnings;
        let notes = notes.into_iter().filter(|note| note.code == Code::MotionLeftOut);
        notes.map(|note| at(&note)).collect::<Vec<_>>()
    };
    assert_eq!(doubts("CPRECON\nG1 X10\nCPRECOF\nX20\n"), [6]);
    assert!(doubts("CPRECOF\nG1 X10\n").is_empty());
}

/// The machine's own axes, and a fixed point by its number, as G74 and G75 name them.
#[test]
fn ways_to_reference_and_fixed_points() {
    for block in ["G74 Z=0", "G74 Z1=0", "G75 FP=1 Z1=0"] {
        let program = run(&format!("G1 X5\n{block}\n")).unwrap();
        assert_eq!(program.moves.len(), 2, "{block}");
        assert!(program.warnings.iter().any(|note| at(note) == 7), "{block}");
    }
}

#[test]
fn relative_ways_behind_a_shift_are_a_doubt() {
    let head = HEAD.lines().count();
    for (text, line) in [
        ("TRANS X10\nG91 G1 X5\n", Some(2)),
        ("TRANS X10\nG1 X=IC(5)\n", Some(2)),
        ("TRANS X10\nG1 X0\nATRANS X5\nX=IC(5)\nX=IC(5)\n", Some(4)),
        ("TRANS X10\nG1 X0 Y0\nTRANS\nG91 Y5\nX5\n", Some(5)),
        ("TRANS Z5\nG1 X3\nG91 X5\nG2 X4 Z1 I2 J0\n", Some(4)),
        ("TRANS X10\nG1 X0\nG91 X5\n", None),
        ("TRANS X10\nG91 G1 Y5\nG90 X5\nG91 X5\n", None),
        ("TRANS X10\nTRANS\nG91 G1 X5\n", None),
        ("TRANS X0 Y0 Z0\nG91 G1 X5\n", None),
        ("TRANS X10\nG111 X0 Y0\nG1 AP=0 RP=7\nG91 X5\n", None),
        ("TRANS Z5\nCYCLE81(20,0,2,-8)\nG91 G1 Z5\n", None),
        ("TRANS X5\nHOLES1(0,0,0,5,5,2)\nG91 G1 X5\n", None),
    ] {
        let program = run(text).unwrap();
        let told = program.warnings.iter().filter(|note| note.code == Code::ChangeIgnored);
        let told: Vec<usize> = told.map(at).collect();
        let expected: Vec<usize> = line.into_iter().map(|line| head + line).collect();
        assert_eq!(told, expected, "{text}");
    }
    assert_xs("TRANS X10\nG91 G1 X5\nG90 X5\n", &[5.0, 15.0]);
}

/// G97 is one of the kinds of feed, and has the effect of G95 (Siemens, Fundamentals, "Constant
/// cutting rate").
#[test]
fn a_fixed_speed_by_g97_makes_the_feed_one_per_revolution() {
    for (text, expected) in [
        ("G97\nG1 X5 F0.1\n", 300.0),
        ("G97 S1000\nG1 X5 F0.1\n", 100.0),
        ("G97 S1000\nG94\nG1 X5 F200\n", 200.0),
    ] {
        let feed = run(text).unwrap().moves[1].feed_m_per_s * 6e4;
        assert!((feed - expected).abs() < 1e-9, "{text}: {feed}");
    }
    refused("G96 S90\nG1 X5 F0.1\n", "G96 keeps the cutting speed");
    refused("G961 S90\nG1 X5 F100\n", "G961 keeps the cutting speed");
}

/// The call states all heights: from wherever the tool is, it goes to RFP and SDIS at rapid.
#[test]
fn a_cycle_needs_no_height_before_it() {
    let text = |cycle: &str| {
        format!(
            "G17 G71 G90 G94\nG0 G53 Y0 Z0 D0\nT1 M6\nD1\n\
             G0 G54 X10 Y20 S10900 F3000 M3\n{cycle}MCALL\nM30\n"
        )
    };
    let of = |cycle: &str| read(text(cycle).as_bytes(), Dialect::Sinumerik, &settings()).unwrap();
    let hole = |x: f64, y: f64| [5.0, -9.5, 5.0].map(|z| ('L', [x, y, z]));
    let one = of("MCALL CYCLE82(5,0,5,-9.5,,0)\nX10 Y20\n");
    assert_ends(&one, &hole(10.0, 20.0));
    let is_remark = |note: &Note| matches!(note.code, Code::LeftOut | Code::Assumed);
    assert!(one.warnings.iter().all(is_remark), "{:?}", one.warnings);
    let row = of("MCALL CYCLE82(5,0,5,-9.5,,0)\nHOLES1(0,0,0,10,10,2)\n");
    assert_ends(&row, &[hole(10.0, 0.0), hole(20.0, 0.0)].concat());
    // Behind moves, the way back is a doubt as that of any rapid move is.
    let back = run("SUPA G0 Z0\nCYCLE81(20,0,2,-8)\n").unwrap();
    let ends = [('L', 50.0), ('T', 2.0), ('L', -8.0), ('L', 2.0), ('L', 20.0)];
    assert_ends(&back, &ends.map(|(way, z)| (way, [0.0, 0.0, z])));
    let doubts = back.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
    assert_eq!(doubts.map(at).collect::<Vec<_>>(), [6]);
    // A cut does not begin there.
    let cut = text("MCALL CYCLE82(5,0,5,-9.5,,0)\nG1 X10 Y20\n");
    let found = read(cut.as_bytes(), Dialect::Sinumerik, &settings()).unwrap_err();
    assert!(found[0].what.contains("while Z is not known"), "{found:?}");
}

/// Siemens: LIMS= counts under G96 and under G97.
#[test]
fn a_speed_above_its_limit_is_a_doubt_where_the_limit_counts() {
    for (block, lines) in [
        ("G97 S3000 M3 LIMS=2000", vec![4]),
        ("LIMS=2000 G97 S3000 M3", vec![4]),
        ("G97 S3000 M3 LIMS=4000", vec![]),
        ("G94 S3000 M3 LIMS=2000", vec![]),
    ] {
        let text = format!("G710 G90 G17\nT1 M6\nG0 X0 Y0 Z5\n{block}\nG1 X9 F0.1\nM30\n");
        let program = read(text.as_bytes(), Dialect::Sinumerik, &settings()).unwrap();
        let doubts = program.warnings.iter().filter(|note| note.code == Code::SpindleCommand);
        assert_eq!(doubts.map(at).collect::<Vec<_>>(), lines, "{block}");
    }
}
