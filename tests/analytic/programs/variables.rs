//! Variables, arrays and R parameters of Sinumerik's, and parameters that the job assumes.

use detune::notes::Code;
use detune::program::{Assumed, Companion, Dialect, Program, Settings, read};

use super::support::{Begun, assert_ends, at, end, settings};

const BEGUN: Begun = Begun {
    head: "G710 G17 G90 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z5\nG1 F200\n",
    at_mm: [0.0, 0.0, 5.0],
    dialect: Dialect::Sinumerik,
};

#[track_caller]
fn assert_xs(text: &str, xs: &[f64]) {
    let ends: Vec<_> = xs.iter().map(|x| ('L', [*x, 0.0, 5.0])).collect();
    BEGUN.assert_way(text, &ends);
}

#[test]
fn arrays_and_indexed_parameters() {
    assert_xs("R[4]=5\nX=R[4]\nR[4]=R4+2\nX=R4\nR1=3\nX=R[R1+1]*2\n", &[5.0, 7.0, 14.0]);
    let arrays = "DEF REAL STATE[3], _d, _w[2]\nDEF INT N_UP[2]\nSTATE[2]=1.5\n_w[1]=STATE[2]*2\n\
                  N_UP[0]=2.6\nX=STATE[2]\nX=_w[1]\nX=N_UP[0]\nX=STATE[0]\n";
    assert_xs(arrays, &[1.5, 3.0, 3.0, 0.0]);
    assert_xs("DEF REAL TAB[5]\nDEF INT X1=2\nTAB[X1]=5\nX=TAB[2]\n", &[5.0]);
    assert_xs("X=10 DIV 4\nX=3 DIV 4\nX=7 MOD 4\n", &[2.0, 0.0, 3.0]);
    for (text, said) in [
        ("DEF REAL FIELD[2,3]\n", "one dimension"),
        ("DEF REAL FIELD[2]=(1,2)\n", "no values"),
        ("DEF REAL FIELD[2]\nFIELD[2]=1\n", "no element of an array"),
        ("DEF REAL FIELD[2]\nX=FIELD[2]\n", "'field[2]' is read"),
        ("R[1.5]=3\n", "whole number"),
        ("X=7.5 DIV 2\n", "whole numbers"),
        ("POS[X]=10\n", "beside the path"),
        ("EXTCALL \"SUB1\"\n", "EXTCALL runs a program"),
        ("EXTCALL(\"SUB1\")\n", "EXTCALL runs a program"),
        // The address or the variable.
        ("DEF INT I\nI=7\nX=I\n", "two letters"),
        ("DEF REAL S1\nS1=900\n", "two letters"),
    ] {
        BEGUN.refused(text, said);
    }
    assert_xs("DEF INT I\nFOR I=1 TO 2\nX=I\nENDFOR\n", &[1.0, 2.0]);
}

/// Siemens: ROUNDUP goes to the next larger whole number, BOUND keeps a value between two.
#[test]
fn bounds_of_sinumerik() {
    assert_xs("X=ROUNDUP(3.1)\nX=ROUNDUP(-3.6)\nX=ROUNDUP(6)\n", &[4.0, -3.0, 6.0]);
    assert_xs("R1=8\nX=MINVAL(3,R1)\nX=MAXVAL(3,R1+1)\n", &[3.0, 9.0]);
    assert_xs("X=BOUND(1,5,9)\nX=BOUND(1,5,-9)\nX=BOUND(1,5,2)*2\n", &[5.0, 1.0, 4.0]);
    BEGUN.refused("X=BOUND(5,1,3)\n", "the least is 5");
    BEGUN.refused("X=MINVAL(3)\n", "two values");
}

/// A block that is refused is not blamed on what it would have set.
#[test]
fn what_a_refused_block_would_have_set() {
    let said = |text: &str| {
        let found = BEGUN.run(text).expect_err(text);
        found.into_iter().map(|note| note.what).collect::<Vec<_>>().join("\n")
    };
    let lost = "R1 is read, and the block that would set it is refused";
    assert!(said("R1=5\nR1=FOO(2)\nX=R1\n").contains(lost));
    assert!(!said("R1=FOO(2)\nR1=5\nX=R1\n").contains("R1 is read"));
    let text = "G21 G90\nG0 X0 Y0 Z5\n#1=[10-#5041]\nX#1\nM30\n";
    let found = read(text.as_bytes(), Dialect::GCode, &settings()).unwrap_err();
    assert!(found.iter().any(|note| note.what.contains("#1 is read, and the block")), "{found:?}");
    assert!(said("DEF REAL _A=FOO(1)\nX=_A\n").contains("'_a' is read, and the block"));
    let of_macros = |text: &str| {
        let text = format!("G21 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        let found = read(text.as_bytes(), Dialect::GCode, &settings()).expect_err(&text);
        found.into_iter().map(|note| note.what).collect::<Vec<_>>().join("\n")
    };
    let behind_then = of_macros("#1=FOO[2]\nIF [#1 EQ 5] THEN #2=3\nX#2\n");
    assert!(behind_then.contains("#2 is read, and the block"), "{behind_then}");
    // A call has its own.
    let call = of_macros("#1=FOO[2]\nG65 P7 A5\nX#1\nM30\nO7\nX#1\nM99\n");
    assert_eq!(call.matches("#1 is read").count(), 1, "{call}");
}

/// Where X ends, in mm, behind the start at 0.
fn xs_of_macros(text: &str) -> Vec<f64> {
    let text = format!("G21 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
    let program = read(text.as_bytes(), Dialect::GCode, &settings());
    let program = program.unwrap_or_else(|found| panic!("{text}: {found:?}"));
    program.moves[1..].iter().map(|own| (end(own).1.translation.x * 1e3).round()).collect()
}

#[track_caller]
fn refused_macro(text: &str, said: &str) {
    let text = format!("G21 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
    let found = read(text.as_bytes(), Dialect::GCode, &settings()).expect_err(&text);
    assert!(found[0].what.contains(said), "{text}: {found:?}");
}

/// Fanuc: 22 is 16 in hexadecimal digits.
#[test]
fn decimal_digits_of_fanuc() {
    assert_eq!(xs_of_macros("#3=BIN[22]\nX#3\n#4=BCD[16]\nX#4\n"), [16.0, 22.0]);
    assert_eq!(xs_of_macros("X[BIN[4660]]\nX[BCD[1234]]\nX BIN[0]\n"), [1234.0, 4660.0, 0.0]);
    assert_eq!(xs_of_macros("X[BI[22]]\nX[BC[16]]\n"), [16.0, 22.0]);
    // 305419896 is 0x12345678.
    assert_eq!(xs_of_macros("X[BIN[305419896]/12345678]\n"), [1.0]);
    refused_macro("#3=BCD[100000000]\n", "from 0 to 99999999");
    refused_macro("#3=BIN[10]\n", "decimal ones");
    refused_macro("#3=BCD[1.5]\n", "whole number");
}

/// Fanuc: A B C I J K I J K … are #1 to #33 in order; of two that give one local the later counts.
#[test]
fn arguments_of_g65_that_repeat() {
    let of = |call: &str, reads: &str| {
        let reads: String = reads.split(' ').map(|own| format!("G1 X{own}\n")).collect();
        xs_of_macros(&format!("G65 P7 {call}\nM30\nO7\n{reads}M99\n"))
    };
    assert_eq!(of("I5. J6. I7. J8.", "#4 #5 #7 #8"), [5.0, 6.0, 7.0, 8.0]);
    assert_eq!(of("A1 B2 I-3 I4 D5", "#1 #2 #4 #7"), [1.0, 2.0, -3.0, 5.0]);
    assert_eq!(of("I1 J2 K3 I4 J5 K6 I7", "#6 #9 #10"), [3.0, 6.0, 7.0]);
    assert_eq!(of("I1 K3", "#4 #6"), [1.0, 3.0]);
    for call in ["I1 I2 J3", "K3 J2 I1", "J3 I1"] {
        refused_macro(&format!("G65 P7 {call}\n"), "whole sets");
    }
    refused_macro("G1 I1 I2\n", "two I words");
}

/// LinuxCNC: #5410 is the diameter of the tool in the spindle, in the unit of the program. 25.4 mm
/// are 1 inch.
#[test]
fn the_diameter_of_the_tool() {
    let of = |text: &str, diameters: &[(Option<u32>, f64)], assumed: Option<f64>| {
        let assume = assumed.map(|own| ("#5410".to_owned(), Assumed::Number(own)));
        let text = format!("G21 G90\nT1 M6\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        let job = Settings {
            assume: assume.into_iter().collect(),
            tool_diameters_mm: diameters.iter().copied().collect(),
            ..settings()
        };
        read(text.as_bytes(), Dialect::GCode, &job)
    };
    let assert_ends_at = |program: &Program, xs: &[f64]| {
        let ends: Vec<_> = xs.iter().map(|x| ('L', [*x, 0.0, 5.0])).collect();
        assert_ends(program, &ends);
    };
    let one = [(None, 6.0)];
    assert_ends_at(&of("#1=[10-#5410/2]\nX#1\n", &one, None).unwrap(), &[0.0, 7.0]);
    let program = of("G20\nG1 X[#5410*2] F10\n", &[(None, 25.4)], None).unwrap();
    assert_ends_at(&program, &[0.0, 50.8]);
    let set = "G10 L1 P1 R3\nG10 L1 P2 R5\nX#5410\n";
    assert_ends_at(&of(set, &one, None).unwrap(), &[0.0, 6.0]);
    let change = "X#5410\nT2 M6\nX#5410\n";
    let two = [(Some(1), 6.0), (Some(2), 8.0)];
    assert_ends_at(&of(change, &two, None).unwrap(), &[0.0, 6.0, 8.0]);
    for (text, diameters, assumed, line, said) in [
        ("X#5410\n", &[][..], None, 5, "tool.diameter_mm in the job gives"),
        (change, &one, None, 7, "tool.diameter_mm in the job gives"),
        ("X#5410\n", &one, Some(8.0), 5, "leave it out of assume"),
        ("G10 L1 P1 R4\nX#5410\n", &one, None, 6, "to 8.000 mm by G10, and the job has 6 mm"),
        ("G91 G10 L1 P1 R3\nG90 X#5410\n", &one, None, 6, "which is not known"),
    ] {
        let found = of(text, diameters, assumed).unwrap_err();
        assert!(found[0].what.contains(said) && at(&found[0]) == line, "{found:?}");
    }
}

/// TRUNC cuts, POT squares, NOT binds before all operators.
#[test]
fn functions_of_sinumerik() {
    assert_xs("X=TRUNC(3.7)\nX=TRUNC(-3.7)\nX=POT(1.5)\n", &[3.0, -3.0, 2.25]);
    let conditions = "R1=5\nIF NOT (R1==4)\nX=1\nENDIF\nIF NOT (R1==5)\nX=2\nENDIF\n\
                      DEF BOOL _ON\nIF NOT _ON\nX=3\nENDIF\n";
    assert_xs(conditions, &[1.0, 3.0]);
    BEGUN.refused("R1=5\nIF NOT R1\nX=1\nENDIF\n", "NOT 5: expected a condition");
}

/// Fanuc: words of macros may be cut down to two letters.
#[test]
fn words_of_macros_may_be_cut() {
    let of = |text: &str| {
        let text = format!("G21 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        let program = read(text.as_bytes(), Dialect::GCode, &settings()).unwrap();
        let moves = &program.moves[1..];
        moves.iter().map(|own| (end(own).1.translation.x * 1e3).round()).collect::<Vec<_>>()
    };
    assert_eq!(of("#1=0\nWH[#1LT3]DO1\n#1=#1+1\nX[#1*10]\nEN1\n"), [10.0, 20.0, 30.0]);
    assert_eq!(of("#1=1\nIF[#1EQ1]GO10\nX5\nN10 X8\nGOT20\nX9\nN20\n"), [8.0]);
    assert_eq!(of("#1=7\nIF[[#1MO4EQ3]AN[#1GT0]]TH#1=2\nX#1\n"), [2.0]);
    assert_eq!(of("X[SI[30]*10+CO[60]*2+SQ[9]+RO[1.6]+FI[1.9]]\n"), [12.0]);
    assert_eq!(of("X5\nGOTO 1 (on)\nX9\nN1 X6\n"), [5.0, 6.0]);
    assert_eq!(of("#1=1\nIF [#1 EQ 1] THEN GOTO 10\nX5\nN10 X8\n"), [8.0]);
    assert_eq!(of("#1=2\nIF [#1 EQ 1] THEN GOTO 10\nX5\nN10 X8\n"), [5.0, 8.0]);
    assert_eq!(of("#1=0\nWHILE [#1 LT 1] DO 1 (on)\n#1=#1+1\nX3\nEND 1 (off)\n"), [3.0]);
    // What stands behind a word that directs the flow is not lost.
    for (text, said) in [
        ("#1=0\nWHILE [#1 LT 1] DO1 X50\n#1=#1+1\nEND1\n", "'X50' behind DO is not read"),
        ("#1=3\n#2=0\nWHILE [#1 GT #2] DO1 #1=#1-1\nX9\nEND1\n", "'#1=#1-1' behind DO"),
        ("#1=0\nWHILE [#1 LT 1] DO1\n#1=#1+1\nEND1 Y10\n", "'Y10' behind END is not read"),
        ("#1=5\nIF [#1 EQ 0] GOTO 9 X99\nN9 X1\n", "'X99' behind the target of GOTO"),
        ("o100 sub\nX#1\no100 endsub\no100 call [30] y50\n", "'y50' behind CALL is not read"),
        ("#1=1\no101 if [#1 eq 1] x77\nX1\no101 endif\n", "'x77' behind IF is not read"),
        ("#1=1\no101 if [#1 eq 1]\nX1\no101 endif x88\n", "'x88' behind ENDIF is not read"),
        ("#1=1\no101 if [#1 eq 1] #1=5\nX#1\no101 endif\n", "'#1=5' behind IF is not read"),
        ("o100 sub\nX#1\no100 endsub\n#1=2\no100 call #1\n", "'#1' behind CALL is not read"),
        ("o1 if [1 gt 0]\nX1\no1 endif (a < b) x5\n", "'x5' behind ENDIF is not read"),
        ("o1 repeat #<n> x5\nX1\no1 endrepeat\n", "'x5' behind REPEAT is not read"),
        ("#1=1\nWHILE [#1 LT 1] X5 DO1\nX1\nEND1\n", "'X5 DO1' stands where DO is expected"),
    ] {
        let text = format!("G21 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        let found = read(text.as_bytes(), Dialect::GCode, &settings()).unwrap_err();
        assert!(found[0].what.contains(said), "{text}: {found:?}");
    }
    let commented = "o1 repeat [2] (twice)\nX4 (a)\no1 endrepeat ; b\n";
    assert_eq!(of(commented), [4.0, 4.0]);
    assert_eq!(
        of("#1=2\n#<n>=1\no1 repeat #1\no2 repeat #<n> (b)\nX4\no2 endrepeat\no1 endrepeat\n"),
        [4.0; 2]
    );
    // The letter instead of the digit.
    for text in ["GO1 X60.\nN1 X5\n", "GO X20.\n", "GOTO 1 X60.\nN1 X5\n"] {
        let text = format!("G21 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        let found = read(text.as_bytes(), Dialect::GCode, &settings()).unwrap_err();
        let said = if text.contains("GOTO") { "target of GOTO" } else { "for G0 write the digit" };
        assert!(found[0].what.contains(said), "{text}: {found:?}");
    }
}

/// What is in no file that is read, the job may say.
#[test]
fn what_the_job_assumes_of_parameters() {
    let of = |assume: &[(&str, Assumed)], text: &str, dialect| {
        let assume = assume.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let text = format!("G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        read(text.as_bytes(), dialect, &Settings { assume, ..settings() })
    };
    let five = Assumed::Number(5.0);
    for (name, value, text, dialect) in [
        ("#500", five, "X#500\n", Dialect::GCode),
        ("#500", five, "IF [#500 EQ 5] GOTO 1\nX9\nN1 X5\n", Dialect::GCode),
        ("r1", five, "X=R1\n", Dialect::Sinumerik),
        ("r1", five, "X=R[1]\n", Dialect::Sinumerik),
        ("spin_x_offset", five, "X=SPIN_X_OFFSET\n", Dialect::Sinumerik),
        ("offsets[2]", five, "X=OFFSETS[2]\n", Dialect::Sinumerik),
        ("has_probe", Assumed::Truth(true), "IF HAS_PROBE\nX5\nENDIF\n", Dialect::Sinumerik),
        (
            "$mn_user_data_int[1]",
            Assumed::Number(1.0),
            "IF $MN_USER_DATA_INT[1]==1\nX5\nENDIF\n",
            Dialect::Sinumerik,
        ),
    ] {
        let program = of(&[(name, value)], text, dialect).unwrap_or_else(|why| panic!("{why:?}"));
        assert_ends(&program, &[0.0, 5.0].map(|x| ('L', [x, 0.0, 5.0])));
        assert!(program.warnings.iter().all(|note| note.code != Code::Unused), "{text}");
        let found = of(&[], text, dialect).unwrap_err();
        assert!(found[0].what.contains(&format!("assume: {{\"{name}\": …}}")), "{found:?}");
    }
    // What the program sets counts, and behind a value that is none no other.
    let own = of(&[("r1", five)], "R1=7\nX=R1\n", Dialect::Sinumerik).unwrap();
    assert_ends(&own, &[0.0, 7.0].map(|x| ('L', [x, 0.0, 5.0])));
    let told = own.warnings.iter().filter(|note| note.code == Code::Unused);
    assert_eq!(told.map(at).collect::<Vec<_>>(), [4]);
    for assume in [&[("#500", five)][..], &[]] {
        let vacant = of(assume, "#500=#0\nX#500\n", Dialect::GCode).unwrap_err();
        assert!(vacant[0].what.ends_with("and the program has not set it"), "{vacant:?}");
    }
    // An index is worked out, or the name of an axis.
    let each = [("$mn_data[0]", five), ("$mn_data[1]", Assumed::Number(6.0))];
    let indexed = "R1=0\nX=$MN_DATA[R1]\nR1=1\nX=$MN_DATA[R1]\n";
    let read_each = of(&each, indexed, Dialect::Sinumerik).unwrap();
    assert_ends(&read_each, &[0.0, 5.0, 6.0].map(|x| ('L', [x, 0.0, 5.0])));
    let one = of(&each[..1], indexed, Dialect::Sinumerik).unwrap_err();
    assert!(one[0].what.contains("assume: {\"$mn_data[1]\": …}"), "{one:?}");
    let of_axis = of(&[("$ma_data[0,x1]", five)], "X=$MA_DATA[0, X1]\n", Dialect::Sinumerik);
    assert_ends(&of_axis.unwrap(), &[0.0, 5.0].map(|x| ('L', [x, 0.0, 5.0])));
    // Words of the language are no variables.
    let found = of(&[], "X=ENDPROC\n", Dialect::Sinumerik).unwrap_err();
    assert!(!found[0].what.contains("assume"), "{found:?}");
    // Locals of a call, and what the control changes by itself, are no such parameters.
    for (name, text, dialect) in [
        ("#1", "X#1\n", Dialect::GCode),
        ("#5041", "X#5041\n", Dialect::GCode),
        ("$aa_im[x]", "X=$AA_IM[X]\n", Dialect::Sinumerik),
    ] {
        let found = of(&[(name, five)], text, dialect).unwrap_err();
        assert!(found[0].what.ends_with("the program has not set it"), "{found:?}");
    }
}

/// What the control's own definitions declare (GUD), the job names, and the program may set it.
#[test]
fn the_job_declares_variables_of_the_control_s_definitions() {
    let of = |assume: &[&str], text: &str| {
        let five = |name: &&str| ((*name).to_owned(), Assumed::Number(5.0));
        let assume = assume.iter().map(five).collect();
        let text = format!("G710 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        read(text.as_bytes(), Dialect::Sinumerik, &Settings { assume, ..settings() })
    };
    for (name, text, x) in [
        ("work[1]", "WORK[1]=2\nX=WORK[1]+10\n", 12.0),
        ("mygud", "MYGUD=2\nX=MYGUD\n", 2.0),
        ("mygud", "R1=MYGUD\nMYGUD=2\nX=R1+MYGUD\n", 7.0),
    ] {
        let program = of(&[name], text).unwrap_or_else(|why| panic!("{why:?}"));
        assert_ends(&program, &[0.0, x].map(|x| ('L', [x, 0.0, 5.0])));
        assert!(program.warnings.iter().all(|note| note.code != Code::Unused), "{text}");
        let found = of(&[], text).unwrap_err();
        let said = found[0].what.contains(&format!("assume: {{\"{name}\": …}}"));
        assert!(said && at(&found[0]) == 4, "{found:?}");
    }
    // Words of the control are no variables.
    for (name, text) in [
        ("ovr", "OVR=50\n"),
        ("rndm", "RNDM=2\n"),
        ("frc", "X5 FRC=50 RND=1\n"),
        ("offn", "OFFN=3\n"),
        ("meas", "MEAS=1 X5\n"),
        ("spos[2]", "SPOS[2]=90\n"),
        ("toffl", "TOFFL=1\n"),
        ("tcarr", "TCARR=1\n"),
        ("disr", "DISR=5\n"),
    ] {
        for assume in [&[name][..], &[]] {
            let found = of(assume, text).unwrap_err();
            let says = found.iter().any(|note| note.what.contains("declare it"));
            assert!(at(&found[0]) == 4 && !says, "{text}: {found:?}");
        }
    }
    // Unless the program declares one, as an older control may have it.
    let own = of(&[], "DEF REAL DISR\nDISR=7\nX=DISR\n").unwrap();
    assert_ends(&own, &[0.0, 7.0].map(|x| ('L', [x, 0.0, 5.0])));
}

/// What is set and never read may be a word of the control, as is the name of an axis (`BZ=`).
#[test]
fn a_declared_variable_that_is_never_read_is_a_doubt() {
    let doubts = |name: &str, text: &str, companion: &str| {
        let companions = vec![Companion { name: "UP.SPF".to_owned(), text: companion.to_owned() }];
        let assume = [(name.to_owned(), Assumed::Number(5.0))].into_iter().collect();
        let text = format!("G710 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        let job = Settings { assume, companions, ..settings() };
        let program = read(text.as_bytes(), Dialect::Sinumerik, &job);
        let notes = program.unwrap_or_else(|why| panic!("{why:?}")).warnings;
        let doubts = notes.into_iter().filter(|note| note.code == Code::MotionLeftOut);
        doubts.map(|note| (at(&note), note.what)).collect::<Vec<_>>()
    };
    for (name, text) in
        [("bz", "X5\nBZ=3\n"), ("work[1]", "X5\nWORK[1]=2\n"), ("bz", "X5\nBZ=3\nBZ=4\n")]
    {
        let found = doubts(name, text, "");
        let said = format!("'{}' is set and never read", name.to_uppercase());
        assert!(found.len() == 1 && found[0].0 == 5, "{text}: {found:?}");
        assert!(found[0].1.starts_with(&said), "{text}: {found:?}");
    }
    let beside = doubts("bz", "UP\nX5\n", "PROC UP\nBZ=3\nRET\n");
    assert!(beside.len() == 1 && beside[0].1.starts_with("UP.SPF:2: 'BZ' is set"), "{beside:?}");
    for (text, companion) in [
        ("BZ=3\nX=BZ\n", ""),
        ("R1=BZ\nBZ=3\n", ""),
        ("BZ=3\nUP\n", "PROC UP\nX=BZ\nRET\n"),
        ("X5\n", ""),
    ] {
        assert!(doubts("bz", text, companion).is_empty(), "{text}");
    }
}

/// One value for all programs, whichever sets it.
#[test]
fn a_variable_that_the_job_declares_holds_in_subprograms() {
    let of = |text: &str, companion: &str| {
        let companions = vec![Companion { name: "UP.SPF".to_owned(), text: companion.to_owned() }];
        let assume = [("mygud".to_owned(), Assumed::Number(5.0))].into_iter().collect();
        let text = format!("G710 G90 G94\nG0 X0 Y0 Z5\nG1 F200\n{text}M30\n");
        read(text.as_bytes(), Dialect::Sinumerik, &Settings { assume, companions, ..settings() })
    };
    for (text, companion, xs) in [
        ("MYGUD=2\nUP\nX=MYGUD\n", "PROC UP\nMYGUD=30\nRET\n", &[30.0][..]),
        ("MYGUD=2\nUP\nX3\n", "X=MYGUD\nM17\n", &[2.0, 3.0]),
        ("UP\nX3\nUP\n", "MYGUD=MYGUD+1\nX=MYGUD\nM17\n", &[6.0, 3.0, 7.0]),
    ] {
        let program = of(text, companion).unwrap_or_else(|why| panic!("{text}: {why:?}"));
        let ends = [&[0.0][..], xs].concat();
        assert_ends(&program, &ends.iter().map(|x| ('L', [*x, 0.0, 5.0])).collect::<Vec<_>>());
    }
    // A subprogram with its own of that name: which one is meant is not followed.
    let found = of("MYGUD=2\nUP\n", "DEF REAL MYGUD\nMYGUD=30\nX=MYGUD\nM17\n").unwrap_err();
    assert!(found[0].what.contains("'MYGUD=' is not understood"), "{found:?}");
}

/// LinuxCNC: in the coordinates and the unit that hold where the block begins.
#[test]
fn parameters_of_linuxcnc_that_the_program_settles() {
    let of = |assume: &[(&str, f64)], text: &str| {
        let assume = assume.iter().map(|(name, x)| ((*name).to_owned(), Assumed::Number(*x)));
        let job = Settings { assume: assume.collect(), ..settings() };
        read(format!("{text}M2\n").as_bytes(), Dialect::GCode, &job)
    };
    let head = "G21 G90 G94\nS900 M3\nG0 X3 Y1 Z5\nG1 F200\n";
    for (text, end) in [
        ("#1=#<_z>\nZ[#1-6]\n", [3.0, 1.0, -1.0]),
        // 2 behind the shift, so 12, which is 13 without it.
        ("G52 X1\nX[#<_x>+10]\n", [13.0, 1.0, 5.0]),
        ("G91\nX[#<_incremental>+#<_z>]\n", [9.0, 1.0, 5.0]),
        ("G20\nX[#<_x>*2]\n", [6.0, 1.0, 5.0]),
        ("X[#<_feed>/100+#<_rpm>/900+#<_metric>]\n", [4.0, 1.0, 5.0]),
    ] {
        let program = of(&[], &format!("{head}{text}")).unwrap_or_else(|why| panic!("{why:?}"));
        assert_ends(&program, &[('L', [3.0, 1.0, 5.0]), ('L', end)]);
    }
    for (text, said) in [
        ("G90\nG0 X3 Y1 Z5\nX#<_metric>\n", "which nothing says: write G20 or G21"),
        ("G21\nG0 X3 Y1 Z5\nG53 Z0\nX#<_z>\n", "'_z' is the place of the tool"),
        ("G21\nG0 X3 Y1 Z5\nX#<_rpm>\n", "write S before"),
        ("G21\nG0 X3 Y1 Z5\nG68 X0 Y0 R90\nX[#<_x>+5] Y0\n", "not read under G68"),
        // On Haas a timer.
        ("G21\nG0 X3 Y1 Z5\nX#5420\n", "write #<_x>"),
        ("G21\nG0 X3 Y1 Z5\nIF [#5422 GT 100] GOTO 20\nX9\nN20 X5\n", "write #<_z>"),
        ("G21\nG0 X3 Y1 Z5\nX#<_vmajor>\n", "assume: {\"_vmajor\": …}"),
    ] {
        let found = of(&[], text).unwrap_err();
        assert!(found[0].what.contains(said), "{text}: {found:?}");
    }
    // The job may say the others, and these not.
    let text = format!("{head}X[#<_vmajor>+#<_z>]\n");
    let program = of(&[("_vmajor", 2.0), ("_z", 40.0)], &text).unwrap();
    assert_ends(&program, &[('L', [3.0, 1.0, 5.0]), ('L', [7.0, 1.0, 5.0])]);
    let told: Vec<&str> = program
        .warnings
        .iter()
        .filter(|note| note.code == Code::Unused)
        .map(|note| note.what.as_str())
        .collect();
    assert!(told.len() == 1 && told[0].contains("'_z'"), "{told:?}");
}
