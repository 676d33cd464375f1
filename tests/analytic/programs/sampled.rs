//! Constructs of public Heidenhain, Sinumerik and TP programs that were read wrongly without a word, or refused for a
//! wrong reason. Expected figures are worked out by hand from the controllers' manuals.

use detune::motion::{Move, Target, Timing};
use detune::notes::{Code, Note};
use detune::program::{Dialect, Program, Spindle, read};

use super::support::{assert_ends, at, end, ended, faults, settings};

/// Without the first move, which goes to where the path starts.
fn of(text: &str, dialect: Dialect) -> Program {
    let mut found = read(ended(text, dialect).as_bytes(), dialect, &settings()).unwrap();
    found.moves.remove(0);
    found
}

/// Blocks behind `L X+20 Y+0 Z+50`, from line 5 on.
fn conversational(body: &str) -> String {
    format!(
        "0 BEGIN PGM V MM\n1 TOOL CALL 1 Z S6000 F600\n2 L X+0 Y+0 Z+60 R0 FMAX M3\n\
         3 L X+20 Y+0 Z+50 R0 F600\n{body}\nL Z+60 R0 FMAX\nEND PGM V MM\n"
    )
}

fn heidenhain(body: &str) -> Program {
    of(&conversational(body), Dialect::Heidenhain)
}

#[track_caller]
fn refused(text: &str, dialect: Dialect, said: &str) {
    let found = faults(text, dialect);
    assert!(found.iter().any(|fault| fault.what.contains(said)), "{said}: {found:?}");
}

fn told(program: &Program, code: Code) -> Vec<usize> {
    program.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

fn mm_per_min(program: &Program) -> Vec<f64> {
    program.moves.iter().map(|each| (each.feed_m_per_s * 6e7).round() / 1e3).collect()
}

/// PA is the polar angle of the end (HEIDENHAIN iTNC 530, DIN/ISO programming, 6.5: "angular
/// position of the arc end point"), IPA how far the arc turns.
#[test]
fn an_arc_by_the_polar_angle_of_its_end() {
    let quarter = heidenhain("CC X+0 Y+0\nCP PA+90 DR+");
    assert_ends(
        &quarter,
        &[('L', [20.0, 0.0, 50.0]), ('A', [0.0, 20.0, 50.0]), ('L', [0.0, 20.0, 60.0])],
    );
    let whole = heidenhain("CC X+0 Y+0\nCP IPA+360 DR+");
    assert_ends(
        &whole,
        &[
            ('L', [20.0, 0.0, 50.0]),
            ('A', [-20.0, 0.0, 50.0]),
            ('A', [20.0, 0.0, 50.0]),
            ('L', [20.0, 0.0, 60.0]),
        ],
    );
    refused(&conversational("CC X+0 Y+0\nCP PA+450 DR+"), Dialect::Heidenhain, "PA is 450");
    refused(&conversational("CC X+0 Y+0\nCP DR+"), Dialect::Heidenhain, "without PA or IPA");
}

/// Angles count from Z towards X in Z/X, from Y towards Z in Y/Z (HEIDENHAIN, TNC 426 Pilot,
/// Fundamentals: reference axis and 0° direction), and DR+ is the positive turn.
#[test]
fn arcs_in_planes_with_the_tool_axis() {
    // From below the centre (−Z) by the positive turn about Y, z × x = y: to +Z by way of −X.
    let lead = heidenhain("CC X+20 Z+55\nC X+20 Z+60 DR+\nL X+0 F600");
    let [_, first, second, ..] = lead.moves.as_slice() else { panic!("{:?}", lead.moves) };
    let via = |each: &Move| match &each.to {
        Target::Arc { via, .. } => via.translation.vector * 1000.0,
        other => panic!("{other:?}"),
    };
    assert!((via(first).x - 15.0).abs() < 1e-6, "{:?}", via(first));
    assert!((via(first).z - 55.0).abs() < 1e-6 && second.line == 7);
    let side = heidenhain("CC Y+5 Z+50\nCP PA+90 DR-");
    // From −Y (180°) clockwise about X to +Z (90°).
    assert_ends(
        &side,
        &[('L', [20.0, 0.0, 50.0]), ('A', [20.0, 5.0, 55.0]), ('L', [20.0, 5.0, 60.0])],
    );
    refused(&conversational("CC Z+5\nCP PA+90 DR-"), Dialect::Heidenhain, "names no plane");
}

#[test]
fn the_blank_before_a_cycles_number_may_be_missing() {
    for shift in [
        "CYCL DEF 10.0 ROTATION\nCYCL DEF10.1 ROT+10",
        "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF8.1 X",
        "CYCL DEF7.0 DATUM SHIFT\nCYCL DEF7.1 #5",
        "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 #0",
    ] {
        refused(&conversational(shift), Dialect::Heidenhain, "shifts or turns the work");
    }
    assert_eq!(heidenhain("CYCL DEF7.0 DATUM SHIFT\nCYCL DEF7.1 X+0").moves.len(), 2);
    let shifted = heidenhain("CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF7.1 X+10\nL X+40");
    assert_eq!(end(shifted.moves.last().unwrap()).1.translation.x, 0.05);
    // A subprogram ends at LBL0, too.
    let text = conversational("CALL LBL1\nM30\nLBL1\nL X+5\nLBL0\nL X+99");
    assert_eq!(of(&text, Dialect::Heidenhain).moves.len(), 2);
}

#[test]
fn what_stands_behind_m118_is_no_place() {
    let found = heidenhain("L Y+38.5 R0 M118 X1 Z1\nL X+40");
    assert_ends(
        &found,
        &[
            ('L', [20.0, 0.0, 50.0]),
            ('L', [20.0, 38.5, 50.0]),
            ('L', [40.0, 38.5, 50.0]),
            ('L', [40.0, 38.5, 60.0]),
        ],
    );
    // Behind it, that rapid moves run at an assumed speed.
    assert_eq!(told(&found, Code::Assumed)[0], 5);
    let feed = heidenhain("L Y+5 M118 X1 Y1 F300");
    assert_eq!(mm_per_min(&feed)[1], 300.0);
}

#[test]
fn touch_probes_are_a_doubt_and_leave_the_place_unknown() {
    const CALIBRATES: &str = "TCH PROBE 31.0 CAL. TOOL LENGTH\nTCH PROBE 31.1 CHECK: 0\n\
                              TCH PROBE 31.2 HEIGHT: +120";
    let found = heidenhain(&format!("{CALIBRATES}\nL X+0 Y+0 Z+50 FMAX\nL X+20"));
    assert_eq!(told(&found, Code::MotionLeftOut), [5]);
    refused(&conversational(&format!("{CALIBRATES}\nL X+20")), Dialect::Heidenhain, "not known");
    let with_q =
        "TCH PROBE 412 DATUM INSIDE CIRCLE ~\n  Q321=+10 ~\n  Q322=Q5\nL X+0 Y+0 Z+50 FMAX";
    assert_eq!(told(&heidenhain(with_q), Code::MotionLeftOut), [5]);
}

/// F and the feeds of cycles are written alike: tenths of an inch a minute.
#[test]
fn feeds_of_cycles_in_inches() {
    let text = |q: &str| {
        format!(
            "0 BEGIN PGM I INCH\n1 TOOL CALL 1 Z S6000 F50\n2 L X+0 Y+0 Z+2 R0 FMAX M3\n\
             3 L X+1 F100\n4 CYCL DEF 200 DRILLING ~\n Q200=0.1 ~\n Q201=-1 ~\n Q206={q} ~\n \
             Q202=1 ~\n Q203=0 ~\n Q204=2\n5 L X+1 Y+0 R0 FMAX M99\n6 END PGM I INCH\n"
        )
    };
    let feeds = |q: &str| mm_per_min(&of(&text(q), Dialect::Heidenhain));
    // To the edge, over the hole, to the clearance, down.
    let plunge = |q: &str| feeds(q)[3];
    assert_eq!(feeds("100")[0], 254.0);
    assert_eq!(plunge("100"), 254.0);
    assert_eq!(plunge("AUTO"), 127.0);
}

#[test]
fn words_of_drilling_cycles() {
    let drill = |number: u32, more: &str| {
        format!(
            "CYCL DEF {number} DRILLING ~\n Q200=2 ~\n Q201=-10 ~\n Q206=300 ~\n Q202=4 ~\n {more} ~\n \
             Q203=40 ~\n Q204=10\nL X+20 Y+0 FMAX M99"
        )
    };
    // Three pecks: twice over the hole between them.
    let rests = |more: &str| -> Vec<f64> {
        let found = heidenhain(&drill(200, more));
        let rests = found.moves.iter().filter_map(|each| match each.timing {
            Timing::Seconds(seconds) => Some(seconds),
            _ => None,
        });
        rests.collect()
    };
    assert_eq!(rests("Q210=3"), [3.0, 3.0]);
    assert!(rests("Q210=0").is_empty());
    refused(&conversational(&drill(200, "Q395=1")), Dialect::Heidenhain, "Q395");
    refused(&conversational(&drill(203, "Q208=Q5")), Dialect::Heidenhain, "from a Q parameter");
    let plunge = drill(200, "Q210=0").replace("Q206=300", "Q206=MAX");
    refused(&conversational(&plunge), Dialect::Heidenhain, "feed of MAX into the work");
    // Out as fast as can be.
    let out = |more: &str| {
        let found = heidenhain(&drill(203, more));
        found.moves.iter().filter(|each| each.timing == Timing::Rapid).count()
    };
    assert_eq!(out("Q208= MAX"), out("Q208=99999"));
    assert!(out("Q208= MAX") > out("Q208=500"));
    let length = heidenhain("TOOL CALL 1 Z S6000 DL+5\nL X+30");
    assert_eq!(told(&length, Code::ChangeIgnored), [5]);
    // A label's name may hold the word for repeats.
    let named = heidenhain("LBL \"REPEAT\"\nL IX+5\nCALL LBL \"REPEAT\" REP 2");
    assert_eq!(named.moves.len(), 5);
}

/// A main block of Sinumerik begins with `:` for `N`.
#[test]
fn main_blocks_are_run() {
    for (text, dialect) in [
        (
            "G71 G90 G17 G94\nS6000 M3\nG0 X0 Y0 Z50\n:20 G1 X50 Y40 F300 S7100 M3\nN30 X60",
            Dialect::Sinumerik,
        ),
        (
            ":1234\nG21 G90 G94\nS6000 M3\nG0 X0 Y0 Z50\n:20 G1 X50 Y40 F300 S7100 M3\nX60",
            Dialect::GCode,
        ),
    ] {
        let found = of(text, dialect);
        assert_ends(&found, &[('L', [50.0, 40.0, 50.0]), ('L', [60.0, 40.0, 50.0])]);
        assert_eq!(mm_per_min(&found), [300.0, 300.0]);
        let speed = found.moves[0].stated.spindle;
        assert_eq!(speed, Some(Spindle::Turns(Some(7100.0))));
    }
}

/// A main block may be called, too, with the words on its line.
#[test]
fn a_main_block_is_called_whole() {
    let text = "%\n:1000\nG21 G90 G17 G94\nS6000 M3\nG0 X0 Y0 Z50\nG1 X5 F600\nM98 P20\nX30\nM30\n\
                :20 G1 Y10\nX20\nM99\n%\n";
    let found = read(text.as_bytes(), Dialect::GCode, &settings()).unwrap();
    assert_ends(
        &found,
        &[
            ('L', [0.0, 0.0, 50.0]),
            ('L', [5.0, 0.0, 50.0]),
            ('L', [5.0, 10.0, 50.0]),
            ('L', [20.0, 10.0, 50.0]),
            ('L', [30.0, 10.0, 50.0]),
        ],
    );
}

/// G70 and G71 take feeds in the basic system, whatever G700 said before (SINUMERIK 802D sl,
/// Programming and Operation, G70/G71/G700/G710).
#[test]
fn feeds_behind_g71_are_in_the_basic_system() {
    let text = "G700 G90 G17 G94\nS6000 M3\nG0 X0 Y0 Z2\nG1 X1 F10\nG71\nX60 F600";
    assert_eq!(mm_per_min(&of(text, Dialect::Sinumerik)), [254.0, 600.0]);
}

#[test]
fn words_of_sinumerik() {
    let text =
        |block: &str| format!("G71 G90 G17 G94\nS6000 M3\nG0 X0 Y0 Z50\n{block}\nG1 X10 F300");
    let reads = |block: &str| of(&text(block), Dialect::Sinumerik).moves.len();
    assert_eq!(reads("FGROUP()"), 1);
    assert_eq!(reads("FGROUP(x, y, z)"), 1);
    refused(&text("FGROUP(X,Y,Z,A)"), Dialect::Sinumerik, "FGROUP(X,Y,Z,A)");
    refused(&text("FGROUP(X,Y)"), Dialect::Sinumerik, "FGROUP(X,Y)");
    assert_eq!(reads("R1=2\nR4=(R1+5)*2\nG1 X=(R1+5)*3 F100"), 2);
    let zero = "0,\"TC1\",0,57,0,0,0,0,0,0,0,0,0,1";
    assert_eq!(reads(&format!("CYCLE800({zero})")), 1);
    // It takes the tool away first: where to, the program does not say.
    let away = text(&format!("G1 X5 F300\nCYCLE800({})", zero.replacen('0', "1", 1)));
    refused(&away, Dialect::Sinumerik, "not known");
    refused(&text("TRANS X0 Y0 WARM_UP"), Dialect::Sinumerik, "TRANS shifts or turns");
    let tilted = "CYCLE800(0,\"TC1\",0,57,0,0,0,0,20,0,0,0,0,1)";
    refused(&text(tilted), Dialect::Sinumerik, "CYCLE800 shifts or turns");
    refused(&text("CYCLE800(0,\"TC1\",0,57)"), Dialect::Sinumerik, "CYCLE800 shifts or turns");
    assert_eq!(reads("N40 PART_2:\nPART_3: G1 X5 F100"), 2);
    assert_eq!(reads("TRANS X0 Y0 Z0\nAROT Z0"), 1);
    assert_eq!(reads("TRANS X0 Y5"), 1);
    refused(&text("TRANS X0 Y0 G0"), Dialect::Sinumerik, "TRANS shifts or turns");
    refused(&text("TRANS X0 Y0 Z50 :"), Dialect::Sinumerik, "not understood");
    refused(&text("SCALE X0"), Dialect::Sinumerik, "SCALE shifts or turns");
    refused(&text("IF R1==0 GOTOF PART_2"), Dialect::Sinumerik, "R1 is read");
    refused(&text("REPEAT PART_2"), Dialect::Sinumerik, "no label PART_2");
}

const FRAME: &str = "UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',";

/// A TP program that starts at P[1], x = 0, with P[2] at x = 40; statements from line 6 on.
fn tp(body: &str) -> String {
    let position = |number: u32, x: u32| {
        format!(
            "P[{number}]{{\n   GP1:\n	{FRAME}\n	X = {x} mm,	Y = 0 mm,	Z = 60 mm,\n	\
             W = 180 deg,	P = 0 deg,	R = 0 deg\n}};\n"
        )
    };
    format!(
        "/PROG T\n/MN\nUFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 500mm/sec FINE ;\n{body}\n/POS\n{}{}/END\n",
        position(1, 0),
        position(2, 40)
    )
}

fn framed(text: &str) -> Result<Program, Vec<Note>> {
    let mut job = settings();
    job.tool_frames.insert(1, nalgebra::Isometry3::identity());
    job.base_frames.insert(1, nalgebra::Isometry3::identity());
    let mut found = read(text.as_bytes(), Dialect::Fanuc, &job)?;
    found.moves.remove(0);
    Ok(found)
}

#[test]
fn options_of_tp_motions() {
    let found = framed(&tp(
        "R[2]=50 ;\nL P[2] 10mm/sec CNT R[2] ACC R[2:share] ;\nL P[1] 10mm/sec CNT 50 EV 60% PSPD100 ;",
    ));
    assert_eq!(found.unwrap().moves.len(), 2);
    for (option, said) in [
        ("PSPD50", "changes the speed"),
        ("PSPD200", "changes the speed"),
        ("INC", "turns the tool"),
    ] {
        let found = framed(&tp(&format!("L P[2] 10mm/sec FINE {option} ;"))).unwrap_err();
        assert!(found[0].what.contains(said), "{found:?}");
    }
}

#[test]
fn jumps_back_that_are_no_endless_loop_are_run() {
    let xs = |text: &str| -> (Vec<f64>, usize) {
        let found = framed(&tp(text)).unwrap();
        let xs = found.moves.iter().map(|each| super::support::end(each).1.translation.x * 1000.0);
        (xs.map(f64::round).collect(), told(&found, Code::MotionLeftOut).len())
    };
    const OUT: &str = "L P[2] 10mm/sec FINE ;\nL P[1] 10mm/sec FINE ;";
    // Back to what has not run.
    let there = "JMP LBL[2] ;\nLBL[1] ;\nL P[1] 10mm/sec FINE ;\nJMP LBL[3] ;\nLBL[2] ;\n\
                 L P[2] 10mm/sec FINE ;\nJMP LBL[1] ;\nLBL[3] ;\nL P[2] 20mm/sec FINE ;";
    assert_eq!(xs(there).0, [40.0, 0.0, 40.0]);
    // Three passes, counted.
    let counted = format!(
        "R[1]=0 ;\nLBL[1] ;\n{OUT}\nR[1]=R[1]+1 ;\nIF R[1]>=3,JMP LBL[9] ;\nJMP LBL[1] ;\nLBL[9] ;"
    );
    assert_eq!(xs(&counted), ([40.0, 0.0].repeat(3), 0));
    // Parts that are counted in a loop that nothing leaves.
    let endless = format!("LBL[1] ;\n{OUT}\nR[1]=R[1]+1 ;\nJMP LBL[1] ;");
    assert_eq!(xs(&format!("R[1]=0 ;\n{endless}")), (vec![40.0, 0.0], 1));
    // Parts are counted, and what would end it does not come.
    let waits = format!(
        "R[1]=0 ;\nF[1]=(OFF) ;\nLBL[1] ;\nIF F[1]=ON,JMP LBL[9] ;\n{OUT}\nR[1]=R[1]+1 ;\nJMP LBL[1] ;\nLBL[9] ;"
    );
    assert_eq!(xs(&waits), (vec![40.0, 0.0], 1));
    // While a condition holds that stands around the jump.
    let holds = format!(
        "R[1]=0 ;\nLBL[1] ;\nIF (R[1]<3) THEN ;\n{OUT}\nR[1]=R[1]+1 ;\nJMP LBL[1] ;\nENDIF ;"
    );
    assert_eq!(xs(&holds), ([40.0, 0.0].repeat(3), 0));
    // A FOR that a jump leaves is over: the next ENDFOR is the outer one's.
    let nested = format!(
        "FOR R[1]=1 TO 2 ;\nFOR R[2]=1 TO 3 ;\n{OUT}\nIF R[2]=1,JMP LBL[5] ;\nENDFOR ;\nLBL[5] ;\nENDFOR ;"
    );
    assert_eq!(xs(&nested), ([40.0, 0.0].repeat(2), 0));
    // Nothing changes from pass to pass.
    let same = format!("R[1]=0 ;\nLBL[1] ;\n{OUT}\nIF R[1]=3,JMP LBL[9] ;\nJMP LBL[1] ;\nLBL[9] ;");
    assert_eq!(xs(&same), (vec![40.0, 0.0], 1));
}

/// MOTN-063 of a Fanuc R-30iB: a linear motion does not change wrist, elbow and shoulder.
#[test]
fn a_line_of_tp_to_another_configuration_is_refused() {
    let text = tp("L P[2] 10mm/sec FINE ;\nL P[1] 10mm/sec FINE ;");
    assert_eq!(framed(&text).unwrap().moves.len(), 2);
    let at = text.rfind("'N U T").unwrap();
    let over = format!("{}'F U T{}", &text[..at], &text[at + 6..]);
    let found = framed(&over).unwrap_err();
    assert!(found[0].what.contains("the controller stops there"), "{found:?}");
}

#[test]
fn tp_that_does_not_move_by_itself_is_read() {
    let body = "SKIP CONDITION DI[1]=ON ;\nVISION RUN_FIND 'A' ;\nL P[2] 10mm/sec FINE ;";
    assert_eq!(framed(&tp(body)).unwrap().moves.len(), 1);
    // The option under which the condition counts, and a macro.
    for (body, said) in [
        ("SKIP CONDITION DI[1]=ON ;\nL P[2] 10mm/sec FINE Skip,LBL[1] ;\nLBL[1] ;", "Skip"),
        ("MOVE TO HOME ;", "if it is a macro, write CALL"),
    ] {
        let found = framed(&tp(body)).unwrap_err();
        assert!(found[0].what.contains(said), "{found:?}");
    }
    // Where the only move goes is not in the program.
    let text = "/PROG A\n/MN\nUFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nJ PR[1] 10% FINE ;\n/POS\n/END\n";
    let found = framed(text).unwrap_err();
    assert!(found.iter().any(|fault| fault.what.contains("PR[1]")), "{found:?}");
}

fn krl(body: &str, files: &str) -> Result<Program, Vec<Note>> {
    let text = format!(
        "DEF p()\nDECL INT i\n$VEL.CP=0.1\nPTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{body}\n\
         LIN_REL {{X 1}}\nEND\n{files}"
    );
    let frame = |x: f64| nalgebra::Isometry3::translation(x, 0.0, 0.0);
    let base_frames = [(0, frame(0.0)), (1, frame(0.1)), (2, frame(0.2))].into();
    let tool_frames = [(1, frame(0.0)), (2, frame(0.0))].into();
    // What holds before the program chooses one.
    let (tcp, work_object) = (Some(frame(0.0)), Some(frame(0.0)));
    let job =
        detune::program::Settings { base_frames, tool_frames, tcp, work_object, ..settings() };
    read(ended(&text, Dialect::Krl).as_bytes(), Dialect::Krl, &job)
}

/// $VEL_AXIS[n] is of its axis alone (KUKA, KSS 8.3 System Variables).
#[test]
fn axes_of_krl_have_their_own_speeds() {
    const THERE: &str = "PTP {X 10,Y 0,Z 100,A 0,B 0,C 180}";
    let all = |share: u8| format!("FOR i=1 TO 6\n$VEL_AXIS[i]={share}\nENDFOR\n");
    for (set, share, is_told) in [
        (all(20), 0.2, false),
        (all(100) + &all(20), 0.2, false),
        (all(100) + "$VEL_AXIS[6]=20\n", 0.2, true),
        ("$VEL_AXIS[1]=30\n".to_owned(), 0.3, true),
        (all(20) + "BAS(#VEL_PTP,50)\n", 0.5, false),
        // External axes that the job has not count nothing.
        (all(20) + "$VEL_EXTAX[1]=10\n", 0.2, false),
    ] {
        let found = krl(&format!("{set}{THERE}"), "").unwrap();
        let doubt = told(&found, Code::ChangeIgnored);
        assert_eq!(!doubt.is_empty(), is_told, "{set}: {:?}", found.warnings);
        let timing = found.moves.iter().find_map(|each| match each.timing {
            Timing::Joints(share) => Some(share),
            _ => None,
        });
        assert!((timing.unwrap() - share).abs() < 1e-12, "{set}: {timing:?}");
    }
    // What a form writes for axis 1 is of all (SPTP … WITH $VEL_AXIS[1]).
    let form = krl(&format!("S{THERE} WITH $VEL_AXIS[1]=SVEL_JOINT(30.0)"), "").unwrap();
    assert!(told(&form, Code::ChangeIgnored).is_empty(), "{:?}", form.warnings);
    let faults = krl(&format!("$VEL_AXIS[7]=20\n{THERE}"), "").unwrap_err();
    assert!(faults[0].what.contains("no axis 7"), "{faults:?}");
}

/// BASE() and TOOL() of bas.src end with $ACT_BASE=BASE_NO and $ACT_TOOL=TOOL_NO.
#[test]
fn krl_knows_which_base_and_tool_it_has_chosen() {
    let x = |body: &str| {
        let found = krl(body, "").unwrap();
        let last = found.moves.len() - 2;
        (end(&found.moves[last]).1.translation.x * 1e3).round()
    };
    const ASKED: &str = "IF ($ACT_BASE==2) AND ($ACT_TOOL==1) THEN\n\
                         LIN {X 5,Y 0,Z 100,A 0,B 0,C 180}\nELSE\n\
                         LIN {X 7,Y 0,Z 100,A 0,B 0,C 180}\nENDIF";
    assert_eq!(x(&format!("BAS(#TOOL,1)\nBAS(#BASE,2)\n{ASKED}")), 205.0);
    assert_eq!(x(&format!("BAS(#TOOL,1)\nBAS(#BASE,1)\n{ASKED}")), 107.0);
    let of = "BAS(#BASE,2)\n$BASE=BASE_DATA[$ACT_BASE-1]\nLIN {X 5,Y 0,Z 100,A 0,B 0,C 180}";
    assert_eq!(x(of), 105.0);
    let unknown = krl(ASKED, "").unwrap_err();
    assert!(unknown[0].what.contains("run time"), "{unknown:?}");
}

#[test]
fn whole_tables_of_krl_are_handed_over() {
    let files = "DEF draw(b[,]:OUT)\nINT b[,]\nLIN {X 5,Y 0,Z 100,A 0,B 0,C 180}\nb[1,2]=4\nEND\n";
    let found = krl("draw(t[,])", files).unwrap();
    assert_eq!((end(&found.moves[found.moves.len() - 2]).1.translation.x * 1e3).round(), 5.0);
}
