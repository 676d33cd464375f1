//! Heidenhain's conversational language as milling posts write it.

use detune::motion::Timing;
use detune::notes::{Code, Note};
use detune::program::{
    Assumed, Dialect, NewSpeed, Program, Rewrite, Settings, Spindle, read, rewrite,
};

use super::support::{assert_ends, at, end, lines, settings};

fn conversational(text: &str) -> Result<Program, Vec<Note>> {
    read(text.as_bytes(), Dialect::Heidenhain, &settings())
}

const POCKET: &str = "0 BEGIN PGM POCKET MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 * - 12 MM MILL\n\
                      3 TOOL CALL 5 Z S8000 F500\n4 CYCL DEF 32.0 TOLERANCE\n\
                      5 CYCL DEF 32.1 T0.05\n6 L Z+50 R0 FMAX M3\n7 L X+10 Y+0 R0 FMAX\n\
                      8 L Z-2 F200\n9 CC X+0 Y+0\n10 C X+0 Y+10 DR+ F600\n\
                      11 CR X+10 Y+20 R+10 DR-\n12 LBL 1\n13 L IX+5 IZ+3 ; X99\n\
                      14 CALL LBL 1 REP 2\n15 CYCL DEF 200 DRILLING ~\n    Q200=+2 ;CLEARANCE ~\n    \
                      Q201=-6 ;DEPTH ~\n    Q206=+150 ~\n    Q202=+3 ~\n    Q203=+0 ~\n    Q204=+10\n\
                      16 L X+0 Y+0 FMAX M99\n17 L M140 MB MAX\n18 M5\n19 END PGM POCKET MM\n";

#[test]
fn a_pocket_with_arcs_a_repeat_and_a_hole() {
    let program = conversational(POCKET).unwrap();
    assert_ends(
        &program,
        &[
            ('L', [10.0, 0.0, 50.0]),
            ('L', [10.0, 0.0, -2.0]),
            ('A', [0.0, 10.0, -2.0]),
            ('A', [10.0, 20.0, -2.0]),
            ('L', [15.0, 20.0, 1.0]),
            ('L', [20.0, 20.0, 4.0]),
            ('L', [25.0, 20.0, 7.0]),
            ('L', [0.0, 0.0, 7.0]),
            // Two pecks of 3 mm from 2 mm above the surface, the second from 2 mm above the first,
            // out to 10 mm.
            ('L', [0.0, 0.0, 2.0]),
            ('L', [0.0, 0.0, -3.0]),
            ('L', [0.0, 0.0, 2.0]),
            ('L', [0.0, 0.0, -1.0]),
            ('L', [0.0, 0.0, -6.0]),
            ('L', [0.0, 0.0, 2.0]),
            ('L', [0.0, 0.0, 10.0]),
        ],
    );
    assert_eq!(lines(&program)[..8], [8, 9, 11, 12, 14, 14, 14, 23]);
    let feeds: Vec<f64> = program.moves.iter().map(|m| (m.feed_m_per_s * 6e4).round()).collect();
    assert_eq!(feeds[1..5], [200.0, 600.0, 600.0, 600.0]);
    assert_eq!(program.moves[9].feed_m_per_s, 0.0025);
    assert_eq!(program.moves[1].stated.spindle, Some(Spindle::Turns(Some(8000.0))));
    assert_eq!(program.moves[1].stated.tool, Some(5));
}

/// 4 inches are 101.6 mm, and 98 tenths of an inch a minute 248.92 mm.
#[test]
fn the_unit_is_the_last_word_of_the_head() {
    let of = |head: &str, tail: &str| {
        conversational(&format!(
            "0 BEGIN PGM {head}\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+0 R0 FMAX M3\nL X+4 F98 M30\n\
             END PGM {tail}\n"
        ))
    };
    for (head, [x, feed]) in [
        ("100 MM", [4.0, 98.0]),
        ("IN mm", [4.0, 98.0]),
        ("100 INCH", [101.6, 248.92]),
        ("100 IN", [101.6, 248.92]),
        ("MM inch ; MM", [101.6, 248.92]),
    ] {
        for tail in [head, "100", "PART"] {
            let program = of(head, tail).unwrap();
            assert_ends(&program, &[('L', [0.0; 3]), ('L', [x, 0.0, 0.0])]);
            assert!((program.moves[1].feed_m_per_s * 6e4 - feed).abs() < 1e-9, "{head}");
        }
    }
    for head in ["100 INCHES", "100 XYZ", "100", "1-INCH-FITTING"] {
        let found = of(head, head).unwrap_err();
        assert!(at(&found[0]) == 1 && found[0].what.contains("expected MM or INCH"), "{found:?}");
    }
    for (head, tail) in [("100 MM", "100 INCH"), ("100 IN", "100 mm")] {
        let found = of(head, tail).unwrap_err();
        assert_eq!((found.len(), at(&found[0])), (1, 1), "{found:?}");
        assert!(found[0].what.contains("END PGM (line 5) state different units"), "{found:?}");
    }
    const CUT: &str = "L X+0 Y+0 Z+0 FMAX\nL X+4 F98\n";
    for (text, said) in [
        (format!("{CUT}END PGM 100 INCH\n"), "write BEGIN PGM NAME MM, or INCH"),
        (format!("begin pgm 1 mm\n{CUT}END PGM 1 MM\n"), "in capital letters"),
        (
            format!("{CUT}BEGIN PGM A INCH\n{CUT}END PGM A INCH\n"),
            "take out what stands before line 3",
        ),
    ] {
        let found = conversational(&text).unwrap_err();
        assert_eq!((found.len(), at(&found[0])), (1, 1), "{found:?}");
        assert!(found[0].what.contains(said), "{found:?}");
    }
    let twice = format!("BEGIN PGM A MM\n{CUT}BEGIN PGM B INCH\n{CUT}END PGM B INCH\n");
    assert!(
        conversational(&twice).unwrap_err().iter().any(|note| note.what.contains("a second BEGIN"))
    );
}

/// M140 and M99 do the same in a block of their own as behind L.
#[test]
fn codes_that_move_in_blocks_of_their_own() {
    let of = |block: &str| {
        let text = format!(
            "BEGIN PGM A MM\n{block}\nTOOL CALL 1 Z S3000 F300\nL X+0 Y+0 Z+10 R0 FMAX M3\n\
             CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=99 Q203=0\nL X+5\n{block}\n\
             END PGM A MM\n"
        );
        conversational(&text)
    };
    let ways = |program: &Program| program.moves.iter().map(end).collect::<Vec<_>>();
    for block in ["M140 MB MAX", "STOP M5", "M8", "M138 C", "M120 LA5"] {
        let [alone, behind] = [block, &format!("L {block}").replace("L STOP", "L")];
        let [alone, behind] = [alone, behind].map(|block| of(block).unwrap());
        assert_eq!(ways(&alone), ways(&behind), "{block}");
        assert_eq!(alone.warnings.len(), behind.warnings.len(), "{block}");
    }
    let text = |call: &str| {
        format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S3000 F300\nL X+0 Y+0 Z+10 R0 FMAX M3\n\
             CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=99 Q203=0\nL X+5\n{call}\nEND PGM A MM\n"
        )
    };
    let [alone, called] = ["M99", "CYCL CALL"].map(|call| conversational(&text(call)).unwrap());
    assert_eq!(ways(&alone), ways(&called));
    assert_eq!(alone.moves.len(), 5);
}

/// What belongs to a code that is not there is not dropped.
#[test]
fn words_of_a_code_behind_a_line() {
    let of = |block: &str| {
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S3000 F300\nL X+0 Y+0 Z+10 R0 FMAX M3\n{block}\n\
             L X+20\nEND PGM A MM\n"
        );
        conversational(&text)
    };
    for (block, said) in [
        ("L X+5 LA5", "'LA' without M120"),
        ("L X+5 M121 LA5", "'LA' without M120"),
        ("L X+5 MB 10", "'MB' without M140"),
        ("L X+5 M120 MB 10", "'MB' without M140"),
        ("L Z+5 MB MAX FMAX", "'MB' without M140"),
    ] {
        let found = of(block).unwrap_err();
        assert_eq!(found.len(), 1, "{block}: {found:?}");
        assert!(at(&found[0]) == 4 && found[0].what.contains(said), "{block}: {found:?}");
    }
    assert!(of("L X+5 M120 LA5").is_ok());
}

/// M104, M142 and M143 before the path starts, where the job's work object says what holds, and
/// behind.
#[test]
fn codes_that_change_where_the_work_is() {
    let of = |head: &str, code: &str| {
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S3000 F300\n{head}\nL X+0 Y+0 Z+10 R0 FMAX M3\nL X+5\n\
             {code}\nL X+20\nEND PGM A MM\n"
        );
        conversational(&text)
    };
    for code in ["M104", "M142", "M143", "L X+9 M143"] {
        let program = of("M8", code).unwrap();
        let told = program.warnings.iter().filter(|note| note.code == Code::ChangeIgnored);
        assert_eq!(told.map(at).collect::<Vec<_>>(), [6], "{code}");
    }
    for code in ["M142", "M143"] {
        let before = of(code, "M9").unwrap();
        assert!(before.warnings.iter().all(|note| note.code != Code::ChangeIgnored), "{code}");
        let left_out = |note: &Note| note.code == Code::LeftOut && at(note) == 3;
        assert!(before.warnings.iter().any(left_out), "{code}");
    }
    let end = of("M8", "L X+9 R0 FMAX M142 M30").unwrap();
    assert!(end.warnings.iter().all(|note| note.code != Code::ChangeIgnored), "{end:?}");
    // Shifts of the work go.
    let found = of("TRANS DATUM AXIS X+5", "M142").unwrap_err();
    assert!(at(&found[0]) == 6 && found[0].what.contains("write cycle 7"), "{found:?}");
}

/// Told where it is defined, and not at every call.
#[test]
fn a_cycle_without_its_words_is_refused_where_it_is_defined() {
    let text = |words: &str| {
        format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S3000 F300\nL X+0 Y+0 Z+10 R0 FMAX M3\n\
             CYCL DEF 200 DRILLING\n{words}\nL X+5 M99\nL X+9 M99\nEND PGM A MM\n"
        )
    };
    let faults = |words: &str| {
        let found = conversational(&text(words)).unwrap_err();
        let lines = found.iter().map(|note| (at(note), note.what.contains("has no Q206")));
        lines.collect::<Vec<_>>()
    };
    assert_eq!(faults("Q200=2\nQ201=-3\nQ203=+0"), [(4, true)]);
    assert_eq!(faults("Q200=2\nQ201=-3\nQ206 FAUTO\nQ203=+0"), [(4, true), (7, false)]);
    assert!(conversational(&text("Q200=2\nQ201=-3\nQ206=90\nQ203=+0")).is_ok());
}

/// What is worked out between the lines of a corner moves nothing.
#[test]
fn a_corner_with_a_calculation_behind_it() {
    let text = |between: &str| {
        format!(
            "BEGIN PGM A MM\nTOOL CALL 5 Z S8000\nL X+0 Y+0 Z+5 R0 FMAX M3\nL X+50 F500\nRND R5\n{between}\
             L Y+40\nLBL 1\nEND PGM A MM\n"
        )
    };
    let plain = conversational(&text("")).unwrap();
    for between in [
        "Q1 = 50\n",
        "FN 0: Q1 = +50\n",
        "FN 9: IF +0 EQU +1 GOTO LBL 1\n",
        "FN 9: IF +0 EQU +0 GOTO LBL 2\nL X+99\nLBL 2\n",
        "LBL 3\n",
        "; why\n",
    ] {
        let found = conversational(&text(between)).unwrap();
        let ends = |own: &Program| own.moves.iter().map(end).collect::<Vec<_>>();
        assert_eq!(ends(&found), ends(&plain), "{between}");
        assert_eq!(found.moves.len(), 4, "{between}");
    }
}

#[test]
fn what_is_lost_or_shifted_is_refused_with_its_line() {
    for (block, said) in [
        ("L X+Q5", "Q parameters"),
        ("L X+5 F1.2.3", "'F1.2.3' is not understood"),
        ("L X+5 F 1.2.3", "'1.2.3' is not understood"),
        ("L X+10 - 3 Y+5", "'-' stands behind"),
        ("L X+10 -3", "-3 stands behind"),
        ("L X+10*2", "2 stands behind"),
        ("Q1 = 5\nL X + Q1 + 2", "'+' stands behind"),
        ("Q1 = 5\nL X+Q1 - 2", "'-' stands behind"),
        ("L X+5 Y -", "'Y -' has a sign and no number"),
        ("L X - Y+5", "'X -' has a sign and no number"),
        ("L X+10 Y", "'Y' has no number"),
        ("L IX Y+5 FMAX", "'IX' has no number"),
        ("L X F200", "'X' has no number"),
        ("C X+5 Y DR+", "'Y' has no number"),
        ("CC X+5 Y", "'Y' has no number"),
        ("LP PR+5 PA", "'PA' has no number"),
        ("L X+5 Y - Q 1", "'Y -' has a sign and no number"),
        ("L X+5 Y - - 3", "'Y -' has a sign and no number"),
        ("L X+5 Y- -3", "'Y -' has a sign and no number"),
        ("TOOL CALL 5 Z S1000 + 500", "'+' stands behind"),
        ("FUNCTION DWELL TIME5 M5", "'M' beside FUNCTION DWELL"),
        ("CYCL DEF 7.1 X+Q1", "shifts or turns"),
        ("CYCL DEF 7.1 #5", "shifts or turns"),
        ("CYCL DEF 10.1 ROT+Q5", "shifts or turns"),
        ("CYCL DEF 19.1 A+Q120 B+Q121", "shifts or turns"),
        ("CYCL DEF 8.1 X", "shifts or turns"),
        ("TRANS MIRROR AXIS X", "TRANS MIRROR turns, mirrors or scales"),
        ("CYCL DEF 10.0 ROTATION ROT+Q5", "shifts or turns"),
        ("CYCL DEF 8.0 MIRROR IMAGE X", "shifts or turns"),
        ("CYCL DEF 200 DRILLING Q200=2 Q202=+Q7", "Q202: a value from a Q parameter"),
        ("CYCL CALL POS X+10 Y+80 FMAX", "needs X, Y and Z"),
        ("CYCL CALL PAT FMAX", "'CYCL CALL PAT' is not supported"),
        ("CYCL DEF 208 BORE MILLING", "tool table"),
        ("CYCL DEF 252 CIRCULAR POCKET", "works out by itself"),
        ("SPL X+10 Y+5 K3X+1", "spline"),
        ("CYCL CALL PAT FMAX", "'CYCL CALL PAT' is not supported"),
        ("CYCL DEF 252 CIRCULAR POCKET", "cycle 252"),
        ("PLANE SPATIAL SPA+45", "PLANE tilts"),
        ("FN 9: IF +0 EQU +0 GOTO LBL 5", "LBL 5 is not in this program"),
        ("FN 9: IF +0 GOTO LBL 5", "a jump is IF"),
        ("FN 18: SYSREAD Q5 = ID20", "FN 0 to 13 and 16 alone"),
        ("Q5 = Q6 + 1", "Q6 is read"),
        ("QL1 = 10", "QL, QR and QS parameters are not read"),
        ("FN 0: QR2 = +5", "QL, QR and QS parameters are not read"),
        ("Q5 = QL1 + 1", "QL, QR and QS parameters are not read"),
        ("L X+QL1", "QL, QR and QS parameters are not read"),
        ("CYCL DEF 1.2 TIEFE -5", "without its beginning"),
        ("PLANE SPATIAL SPA+0 SPB+0 SPC+5", "PLANE tilts"),
        ("M3 S4000 F50", "'S4000' in a block that begins with M"),
        ("M8 X+50 F20", "'X50' in a block that begins with M"),
        ("STOP X+5", "'X5' in a block that begins with M or STOP"),
        ("34 X+5", "'34' in a block"),
        ("ERROR = L XQ102 + Q9", "marked this block as faulty"),
        ("L X+5 M89", "M89 changes motion"),
        ("L X+5 M128", "M128 moves with rotary axes"),
        ("TOOL CALL 5 Y S1000", "tool axis Y"),
        ("CC X+5 Y+0\nCP IPA-90 DR+", "opposite signs"),
        ("L X+5 A+30", "axis A"),
        ("C X+1 Y+1 DR+", "without CC"),
        ("CC X+5 Y+0\nRND R5", "RND must lie between two lines"),
        ("CALL PGM TNC:\\HOLE.H", "another program"),
        ("CALL LBL 7", "LBL 7 is not in this program"),
        ("CYCL CALL", "without a drilling cycle"),
    ] {
        let text = format!("0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n2 {block}\n3 END PGM A MM\n");
        let found = conversational(&text).unwrap_err();
        let line = 3 + block.matches('\n').count();
        assert_eq!(at(&found[0]), line, "{block}: {found:?}");
        assert!(found[0].what.contains(said), "{block}: {found:?}");
    }
    let found = conversational("0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n").unwrap_err();
    assert!(found[0].what.contains("is the file whole?"), "{found:?}");
}

#[test]
fn speeds_and_feeds_are_rewritten() {
    let speeds = vec![NewSpeed { end: usize::MAX, rpm: 10_000.0, job_rpm: None }];
    let to = Rewrite { speeds, keeps_chip_load: true };
    let found = rewrite(POCKET.as_bytes(), Dialect::Heidenhain, &settings(), &to).unwrap();
    let expected =
        POCKET.replace("S8000 F500", "S10000 F625").replace("F200", "F250").replace("F600", "F750");
    // The feed of a cycle stands in its definition.
    let expected = expected.replace("Q206=+150", "Q206=187.5");
    assert_eq!(String::from_utf8(found.bytes).unwrap(), expected);
}

const HOLE: &str =
    "CYCL DEF 200 DRILLING ~\nQ200=2 ~\nQ201=-20 ~\nQ206=150 ~\nQ202=20 ~\nQ203=+0 ~\nQ204=2\n";

/// The spindle that M3 starts in the block of a tool or of a cycle turns.
#[test]
fn the_spindle_starts_where_it_is_told_to() {
    let tool = "L Z+50 FMAX M5\nTOOL CALL 1 Z S3600";
    for text in [
        format!("{tool} M3\nL X+0 F500\n"),
        format!("{tool}\n{HOLE}L X+50 FMAX\nCYCL CALL M3\nL X+0 F500\n"),
    ] {
        let head = "BEGIN PGM A MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+0 R0 FMAX M3\nL X+100 F600\n";
        let program = conversational(&format!("{head}{text}END PGM A MM\n")).unwrap();
        let last = program.moves.last().unwrap();
        assert_eq!(last.stated.spindle, Some(Spindle::Turns(Some(3600.0))), "{text}");
    }
}

/// IPR adds to the radius that the tool has about the pole.
#[test]
fn a_radius_may_be_relative() {
    let head =
        "BEGIN PGM A MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+0 R0 FMAX M3\nL X+100 F600\nCC X+0 Y+0\n";
    for (block, end) in [("LP IPR+20 PA+90", [0.0, 120.0, 0.0]), ("LP IPR+20", [120.0, 0.0, 0.0])] {
        let program = conversational(&format!("{head}{block}\nEND PGM A MM\n")).unwrap();
        assert_ends(&program, &[('L', [0.0; 3]), ('L', [100.0, 0.0, 0.0]), ('L', end)]);
    }
}

/// The surface counts from Z of the block; the tool goes to the hole level at first.
#[test]
fn a_cycle_is_called_at_a_place() {
    let text = format!(
        "BEGIN PGM A MM\nTOOL CALL 1 Z S3600\nL X+0 Y+0 Z+50 FMAX M3\n{HOLE}\
         CYCL CALL POS X+10 Y+5 Z+3 FMAX\nCYCL CALL POS X+20 Y+5 Z+0 F500\nM30\nEND PGM A MM\n"
    );
    let program = conversational(&text).unwrap();
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 50.0]),
            ('L', [10.0, 5.0, 50.0]),
            ('L', [10.0, 5.0, 5.0]),
            ('L', [10.0, 5.0, -17.0]),
            ('L', [10.0, 5.0, 5.0]),
            ('L', [20.0, 5.0, 5.0]),
            ('L', [20.0, 5.0, 2.0]),
            ('L', [20.0, 5.0, -20.0]),
            ('L', [20.0, 5.0, 2.0]),
        ],
    );
    assert!((program.moves[5].feed_m_per_s * 6e4 - 500.0).abs() < 1e-9);
}

/// It may be where the path starts.
#[test]
fn a_place_of_a_cycle_is_a_start() {
    let text = format!(
        "BEGIN PGM A MM\nTOOL CALL 1 Z S3600\nL Z+50 FMAX M3\n{HOLE}\
         CYCL CALL POS X+10 Y+5 Z+0 FMAX\nM30\nEND PGM A MM\n"
    );
    let heights = [50.0, 2.0, -20.0, 2.0].map(|z| ('L', [10.0, 5.0, z]));
    assert_ends(&conversational(&text).unwrap(), &heights);
    let at_feed = conversational(&text.replace("Z+0 FMAX", "Z+0 F500")).unwrap_err();
    assert!(at_feed[0].what.contains("X and Y are not known"), "{at_feed:?}");
}

#[test]
fn blocks_may_be_numbered_with_n_and_iso_is_refused() {
    let text = "BEGIN PGM A MM\nN1 TOOL CALL 1 Z S3600\nN2 L X+0 Y+0 Z+5 FMAX M3\n\
                N3 L X+10 F200\nN4 END PGM A MM\n";
    let program = conversational(text).unwrap();
    assert_ends(&program, &[('L', [0.0, 0.0, 5.0]), ('L', [10.0, 0.0, 5.0])]);
    let iso = "%A G71 *\nN10 G00 G90 X+0 Y+0 *\nN99999999 %A G71 *\n";
    let found = conversational(iso).unwrap_err();
    assert!(found.len() == 1 && at(&found[0]) == 1, "{found:?}");
    assert!(found[0].what.contains("DIN/ISO"), "{found:?}");
    let found = conversational("BEGIN PGM A MM\nN10 G01 X+5 *\nEND PGM A MM\n").unwrap_err();
    assert!(found.len() == 1 && at(&found[0]) == 2, "{found:?}");
}

/// `~` behind a comment: the next line is comment, too, but for a block with its number.
#[test]
fn comments_go_on_in_the_next_line() {
    for text in [
        "3 L X+0 Y+0 Z+5 R0 FMAX M3 ; (half of key~\n width L X+99)~\n and more\n4 L Z-1\n",
        "3 L X+0 Y+0 Z+5 R0 FMAX M3 ; (half of key~\n - width)\n4 L Z-1\n",
        "3 L X+0 Y+0 Z+5 R0 FMAX M3\n4 ; first ~\n L X+99\n5 L Z-1\n",
        "3 L X+0 Y+0 Z+5 R0 FMAX M3\n4 * - first ~\n L X+99\n5 L Z-1\n",
        // Blocks without numbers are none of a comment.
        "L X+0 Y+0 Z+5 R0 FMAX M3\n; ~~~ first ~~~\nL Z-1\n",
        "L X+0 Y+0 Z+5 R0 FMAX M3\n* - first ~\nL Z-1\n",
        "3 L X+0 Y+0 Z+5 R0 FMAX M3 ; key ~\n4 L Z-1\n",
        // The block goes on.
        "L X+0 Y+0 ~ ; first ~\n Z+5 R0 FMAX M3\nL Z-1\n",
    ] {
        let text = format!("BEGIN PGM A MM\nTOOL CALL 1 Z S3000 F200\n{text}END PGM A MM\n");
        let program = conversational(&text).unwrap();
        assert_ends(&program, &[('L', [0.0, 0.0, 5.0]), ('L', [0.0, 0.0, -1.0])]);
    }
}

fn told(text: &str, code: Code) -> Vec<usize> {
    let head = "BEGIN PGM A MM\nTOOL CALL 1 Z S3000 F200\nL X+0 Y+0 Z+5 R0 FMAX M3\n";
    let program = conversational(&format!("{head}{text}END PGM A MM\n")).unwrap();
    program.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

#[test]
fn stops_that_may_be_skipped_are_no_doubt() {
    for (text, lines) in [
        ("/ STOP\nL X+10\n", vec![]),
        ("/ M1\nL X+10\n", vec![]),
        ("/5 STOP M8 ; look\nL X+10\n", vec![]),
        ("/ BLK FORM 0.1 Z X+0 Y+0 Z-20\nL X+10\n", vec![]),
        ("L X+10\nM30\n/ TOOL CALL 2 Z S900\n", vec![]),
        ("FN 9: IF +1 EQU +1 GOTO LBL 1\n/ CC X+0 Y+0\nLBL 1\nL X+10\n", vec![]),
        ("/ STOP\n/ STOP M5\nL X+10 FMAX\n", vec![5]),
        ("/ M3\nL X+10\n", vec![4]),
        ("/ CC X+0 Y+0\nL X+10\n", vec![4]),
        ("CALL LBL 1\n/ M30\nLBL 1\nL X+5\nLBL 0\n", vec![5]),
        ("LBL 1\nL X+5\n/ M30\nFN 9: IF +1 EQU +0 GOTO LBL 1\n", vec![6]),
        // Skipped or not, nothing moves behind it.
        ("L X+10\n/ M30\n", vec![]),
        ("CALL LBL 1\nL X+10\n/75 M30\nLBL 1\nCYCL DEF 7.1 X0\nLBL 0\n", vec![]),
        ("L X+10\n/ M30\nCYCL DEF 200 Q200=2\n", vec![]),
        // A pattern is drilled where it is defined.
        ("L X+10\n/ M30\nCYCL DEF 220 Q216=0\n", vec![5]),
        ("CALL LBL 1\nL X+10\nM30\n/ LBL 1\nL X+5\nLBL 0\n", vec![7]),
    ] {
        assert_eq!(told(text, Code::MotionLeftOut), lines, "{text}");
    }
}

/// Nothing follows that the spindle could cut in.
#[test]
fn a_code_that_is_not_known_before_the_end_is_no_doubt() {
    for end in ["", "M9\nSTOP\nM30\n"] {
        let text = format!("L X+10\nM5\nM36\n{end}");
        assert_eq!(told(&text, Code::SpindleCommand), Vec::<usize>::new(), "{end}");
        assert_eq!(told(&text, Code::LeftOut), [6], "{end}");
    }
    for end in ["L X+20 FMAX\n", "M3\nL X+20\n"] {
        let text = format!("L X+10\nM5\nM36\n{end}");
        assert_eq!(told(&text, Code::SpindleCommand), [6], "{end}");
    }
}

/// Older controls list words without a number where the dialogue was not answered.
#[test]
fn prompts_without_an_answer_leave_things_as_they_are() {
    let text = "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X0 Y0 Z+5 R0 FMAX M3\nL Z-1 F100\n\
                L X+10 R F M\nL X+20 RL F200 M\nRND R2 F\nL Y+20 R F M\nCALL LBL 1 REP\n\
                L Z+5 FMAX M2\nLBL 1\nL IX+1 F\nLBL 0\nEND PGM A MM\n";
    let program = conversational(text).unwrap();
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 5.0]),
            ('L', [0.0, 0.0, -1.0]),
            ('L', [10.0, 0.0, -1.0]),
            ('L', [18.0, 0.0, -1.0]),
            ('A', [20.0, 2.0, -1.0]),
            ('L', [20.0, 20.0, -1.0]),
            ('L', [21.0, 20.0, -1.0]),
            ('L', [21.0, 20.0, 5.0]),
        ],
    );
    let feeds: Vec<f64> = program.moves.iter().map(|m| (m.feed_m_per_s * 6e4).round()).collect();
    assert_eq!(feeds[1..7], [100.0, 100.0, 200.0, 200.0, 200.0, 200.0]);
    // Where no feed was ever stated, none is left as it is.
    let none = text.replace("F100", "F").replace("F200", "F");
    let job = Settings { feed_m_per_s: None, ..settings() };
    assert!(read(text.as_bytes(), Dialect::Heidenhain, &job).is_ok());
    assert!(read(none.as_bytes(), Dialect::Heidenhain, &job).is_err());
}

/// The cycle states its heights: from wherever the tool is, it goes to the clearance at rapid.
#[test]
fn a_cycle_needs_no_height_before_it() {
    let text = |calls: &str| {
        format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S3600\nL Z-1 R0 FMAX M91\n{HOLE}{calls}M30\n\
             END PGM A MM\n"
        )
    };
    let heights = [2.0, -20.0, 2.0].map(|z| ('L', [10.0, 5.0, z]));
    for calls in [
        "L X+10 Y+5 R0 FMAX M3\nCYCL CALL\n",
        "L X+10 Y+5 R0 FMAX M3 M99\n",
        "L X+0 Y+0 R0 FMAX M3\nCYCL CALL POS X+10 Y+5 Z+0 FMAX\n",
    ] {
        assert_ends(&conversational(&text(calls)).unwrap(), &heights);
    }
    let found = conversational(&text("L X+10 R0 FMAX M3\nCYCL CALL\n")).unwrap_err();
    assert!(found[0].what.contains("Y is not known before the cycle"), "{found:?}");
}

/// Another preset is a change, behind moves or behind places that count from the one before.
#[test]
fn the_preset_under_which_the_path_starts_is_the_job_s_work_object() {
    for (before, behind, lines) in [
        ("", "CYCL DEF 247 Q339=+1\n", vec![]),
        ("", "CYCL DEF 247 Q339=+2\n", vec![5]),
        ("CYCL DEF 247 Q339=+2\n", "CYCL DEF 247 Q339=+2\n", vec![]),
        ("L Z+50 FMAX\nCYCL DEF 247 Q339=+2\n", "", vec![4]),
    ] {
        let text = format!(
            "BEGIN PGM A MM\nCYCL DEF 247 Q339=+1\n{before}TOOL CALL 1 Z S3000 F200\n\
             L X+0 Y+0 Z+5 R0 FMAX M3\n{behind}L X+20\nEND PGM A MM\n"
        );
        let program = conversational(&text).unwrap();
        let told = program.warnings.iter().filter(|note| note.code == Code::ChangeIgnored);
        assert_eq!(told.map(at).collect::<Vec<_>>(), lines, "{text}");
    }
}

#[test]
fn a_parameter_gives_the_number_of_a_tool() {
    let text = |call: &str| {
        format!(
            "0 BEGIN PGM A MM\n1 FN 0: Q11 =+3\n2 TOOL CALL {call} Z S5504 F5500\n\
             3 L X+0 Y+0 Z+10 R0 FMAX M3\n4 L Z-5 F AUTO\n5 END PGM A MM\n"
        )
    };
    let program = conversational(&text("Q11")).unwrap();
    assert_ends(&program, &[('L', [0.0, 0.0, 10.0]), ('L', [0.0, 0.0, -5.0])]);
    assert_eq!(program.moves[1].stated.tool, Some(3));
    assert_eq!((program.moves[1].feed_m_per_s * 6e4).round(), 5500.0);
    let found = conversational(&text("Q12")).unwrap_err();
    assert!(found[0].what.contains("Q parameters") && at(&found[0]) == 3, "{found:?}");
}

#[test]
fn signs_may_stand_apart() {
    let program = conversational(
        "BEGIN PGM A MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+0 R0 FMAX\nQ13 = 5\n\
         L Z + Q13 F200\nL X - 10\nL Y - Q13 X + 2\nEND PGM A MM\n",
    )
    .unwrap();
    let ends = [[0.0; 3], [0.0, 0.0, 5.0], [-10.0, 0.0, 5.0], [2.0, -5.0, 5.0]];
    assert_ends(&program, &ends.map(|at| ('L', at)));
}

/// A parameter may stand apart, with a sign and without.
#[test]
fn parameters_apart_from_their_words() {
    let of = |blocks: &str| {
        conversational(&format!(
            "BEGIN PGM A MM\nQ1 = 7\nQ5 = 500\nTOOL CALL 1 Z S Q5\nL X+0 Y+0 Z+0 R0 FMAX M3\n{blocks}\
             END PGM A MM\n"
        ))
    };
    let program = of("L X Q1 F Q5\nL IY Q1\nCR X+14 Y+14 R Q1 DR+\n").unwrap();
    let ends = [('L', [0.0; 3]), ('L', [7.0, 0.0, 0.0]), ('L', [7.0, 7.0, 0.0])];
    assert_ends(&program, &[&ends[..], &[('A', [14.0, 14.0, 0.0])]].concat());
    let feeds: Vec<f64> =
        program.moves[1..].iter().map(|m| (m.feed_m_per_s * 6e4).round()).collect();
    assert_eq!(feeds, [500.0; 3]);
    assert_eq!(program.moves[1].stated.spindle, Some(Spindle::Turns(Some(500.0))));
    // From the corner at X 20 each line loses 7 mm.
    let program = of("BLK FORM CYLINDER Z R Q1 L Q5\nL X+20 F Q5\nCHF Q1\nL Y+20\n").unwrap();
    let ends = [[0.0; 3], [13.0, 0.0, 0.0], [20.0, 7.0, 0.0], [20.0, 20.0, 0.0]];
    assert_ends(&program, &ends.map(|at| ('L', at)));
    let program = of("FUNCTION DWELL TIME Q1\nL X+9 F Q5\n").unwrap();
    assert_eq!(program.moves[1].timing, Timing::Seconds(7.0));
    for (blocks, said) in [
        ("L X Q2\n", "Q parameters in words"),
        ("TOOL CALL 2 Z Q5\n", "Q5 stands apart"),
        ("L X+5 R0 M Q5\n", "Q5 stands apart"),
        ("Q1 Q5\n", "without '='"),
    ] {
        let found = of(blocks).unwrap_err();
        assert!(found[0].what.contains(said), "{blocks}: {found:?}");
    }
}

#[test]
fn what_a_refused_block_would_set_is_told_as_such() {
    let of = |blocks: &str| {
        let text = format!("BEGIN PGM A MM\nL X+0 Y+0 Z+5 FMAX\n{blocks}\nEND PGM A MM\n");
        conversational(&text).unwrap_err()
    };
    for reads in ["L X+Q5", "L X5 FQ5", "Q6 = Q5 + 1", "FN 9: IF +Q5 EQU +5 GOTO LBL 3"] {
        let found = of(&format!("FN 0: Q5 = +QL1\n{reads}"));
        let said = "Q5 is read, and the block that would set it is refused";
        assert!(at(&found[1]) == 4 && found[1].what.contains(said), "{reads}: {found:?}");
    }
    let again = of("Q5 = QL1\nQ5 = 2\nL X+Q5 F200");
    assert_eq!(again.len(), 1, "{again:?}");
}

/// TIME in seconds, REV in turns of the spindle: 15 at 3000 rpm are 0.3 s.
#[test]
fn the_arm_stands_for_a_time_or_for_turns() {
    let head = "BEGIN PGM A MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+5 R0 FMAX M3\nQ23 = 2\n";
    let of = |block: &str| conversational(&format!("{head}{block}\nL X+9 F100\nEND PGM A MM\n"));
    for (block, expected) in [
        ("FUNCTION DWELL TIME+Q23", 2.0),
        ("FUNCTION DWELL TIME10", 10.0),
        ("FUNCTION DWELL REV15", 0.3),
    ] {
        let program = of(block).unwrap();
        let Timing::Seconds(seconds) = program.moves[1].timing else { panic!("{block}") };
        assert!((seconds - expected).abs() < 1e-12, "{block}: {seconds}");
    }
    for (block, said) in [
        ("FUNCTION DWELL", "needs TIME or REV"),
        ("FUNCTION DWELL TIME+Q24", "Q parameters"),
        ("FUNCTION FEED DWELL D-TIME0.5 F-TIME5", "FUNCTION FEED is not supported"),
    ] {
        let found = of(block).unwrap_err();
        assert!(found[0].what.contains(said) && at(&found[0]) == 5, "{block}: {found:?}");
    }
}

#[test]
fn formulas_go_on_in_the_next_line() {
    let program = conversational(
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+10 R0 FMAX\n2 Q4 = 1 + ( 2 * ~\n    3 ) + 4 ; ELEVEN\n\
         Q5 = Q4 - ~\n  SQRT ~\n  4\n3 L X+Q4 F100\n4 L X+Q5\n5 END PGM A MM\n",
    )
    .unwrap();
    assert_ends(&program, &[0.0, 11.0, 9.0].map(|x| ('L', [x, 0.0, 10.0])));
}

/// Q108, the radius of the tool, is in the control's tool table.
#[test]
fn the_job_gives_the_radius_of_the_tool() {
    let assuming = |name: &str, text: &str| {
        let assume = [(name.to_owned(), Assumed::Number(5.0))].into();
        let settings = Settings { assume, ..settings() };
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 3 Z S5504 F500\nL X+0 Y+0 Z+10 R0 FMAX M3\n{text}\
             END PGM A MM\n"
        );
        read(text.as_bytes(), Dialect::Heidenhain, &settings)
    };
    let end_at = |program: &Program| end(program.moves.last().unwrap()).1.translation.x * 1e3;
    let told = |program: &Program| -> Vec<usize> {
        program.warnings.iter().filter(|note| note.code == Code::Unused).map(at).collect()
    };
    for (name, text, expected) in [
        ("q108", "L X+Q108\n", 5.0),
        ("q108", "Q1 = Q108 * 2\nL X+Q1\n", 10.0),
        ("q108", "TOOL CALL 3 S5000\nL X-Q108\n", -5.0),
        ("q7", "L X+Q7\n", 5.0),
    ] {
        let program = assuming(name, text).unwrap();
        assert!((end_at(&program) - expected).abs() < 1e-9, "{text}");
        assert!(told(&program).is_empty(), "{text}");
    }
    for (name, text) in [
        ("di_1", "L X+Q108\n"),
        ("di_1", "Q1 = Q108 + 1\n"),
        // Of another tool, or with another DR.
        ("q108", "TOOL CALL 4 Z S5000\nL X+Q108\n"),
        ("q108", "TOOL CALL 3 DR+0.1\nL X+Q108\n"),
        // TOOL CALL sets it anew.
        ("di_1", "Q108 = 3\nTOOL CALL 3 S5000\nL X+Q108\n"),
    ] {
        let found = assuming(name, text).unwrap_err();
        assert!(found[0].what.contains("tool table"), "{text}: {found:?}");
    }
    for (name, text, lines) in [
        ("q108", "Q108 = 3\nL X+Q108\n", vec![4]),
        ("q7", "L X+1\nFN 0: Q7 =+1\nL X+Q7\n", vec![5]),
        ("q108", "L X+1\n", vec![]),
        ("s5504", "L X+1\n", vec![2]),
    ] {
        assert_eq!(told(&assuming(name, text).unwrap()), lines, "{text}");
    }
}

/// Templates keep subprograms that a program does not call: behind its last end nothing runs them.
#[test]
fn labels_behind_the_end_that_nothing_calls_are_no_doubt() {
    let sub = "LBL 1\nL X+9 FMAX M99\nLBL 0\n";
    for (behind, line) in [
        (format!("L M30\n{sub}"), None),
        (format!("L M30\n* - LBL 1\n{sub}LBL \"A\"\nL Y+9\nLBL 0\n"), None),
        // Called where the run does not come, from beside it or by a label before it.
        (format!("FN 9: IF +1 EQU +0 GOTO LBL 1\nL M30\n{sub}"), Some(7)),
        (format!("L M30\n{sub}LBL 2\nCALL LBL 1\nLBL 0\n"), Some(6)),
        (format!("FN 9: IF +1 EQU +0 GOTO LBL 2\nL M30\nLBL 2\n{sub}"), Some(8)),
        // An end behind it, no end of it, and moves outside.
        (format!("L M30\n{sub}L M30\n"), Some(6)),
        ("L M30\nLBL 1\nL X+9\n".to_owned(), Some(6)),
        (format!("L M30\nL X+7\n{sub}"), Some(5)),
        (format!("L M30\n{sub}L X+7\n"), Some(8)),
    ] {
        let head = "BEGIN PGM A MM\nTOOL CALL 1 Z S3000 F200\nL X+0 Y+0 Z+5 R0 FMAX M3\n";
        let program = conversational(&format!("{head}{behind}END PGM A MM\n")).unwrap();
        let told = program.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
        let told: Vec<_> = told.filter_map(|note| note.place.line).collect();
        assert_eq!(told, line.into_iter().collect::<Vec<_>>(), "{behind}");
    }
}

/// Posts that name every program `.nc`.
#[test]
fn a_program_under_another_languages_name_is_told() {
    let text = "\n0 BEGIN PGM A MM\n1 L X+1 R0 F100\n2 END PGM A MM\n";
    for dialect in [Dialect::GCode, Dialect::Sinumerik] {
        let found = read(text.as_bytes(), dialect, &settings()).unwrap_err();
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].place.line, Some(2));
        assert!(found[0].what.contains("name its file .h"), "{found:?}");
    }
}
