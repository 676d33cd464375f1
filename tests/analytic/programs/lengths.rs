//! Work offsets and lengths of tools that programs choose by numbers, and numbers without a decimal
//! point.

use detune::notes::{Code, Note};
use detune::program::{Dialect, Program, Settings, read};
use nalgebra::Isometry3;

use super::support::{at, ended, faults, settings};

const HEAD: &str = "G21 G17 G90 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F100\n";

fn of(text: &str, dialect: Dialect) -> Program {
    let program = read(ended(text, dialect).as_bytes(), dialect, &settings());
    program.unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

/// Lines of the notes that say so, all of one code, and of no others of that code where none does.
#[track_caller]
fn told(program: &Program, said: &str, code: Code) -> Vec<usize> {
    let notes = program.warnings.iter().filter(|note| note.what.contains(said));
    let notes = notes.inspect(|note| assert_eq!(note.code, code, "{note:?}"));
    let lines: Vec<usize> = notes.map(at).collect();
    // That two tools have one tcp is told elsewhere.
    let is_other = |note: &&Note| note.code == code && !note.what.contains("the same tcp as");
    let others = || program.warnings.iter().filter(is_other);
    assert!(!lines.is_empty() || others().next().is_none(), "{:?}", program.warnings);
    lines
}

fn offsets(text: &str) -> Vec<usize> {
    told(&of(text, Dialect::GCode), "work offset", Code::ChangeIgnored)
}

/// Fanuc: G54 P is G54.1 P, unless another code of the block takes the P.
#[test]
fn g54_with_a_number_chooses_another_offset() {
    for (blocks, lines) in [
        ("G54 P2\nG1 X5", vec![6]),
        ("G54\nG1 X5", vec![]),
        ("G54 G64 P0.03\nG1 X5", vec![]),
        ("G54 G4 P0.5\nG1 X5", vec![]),
        ("G54 M98 P7\nM30\nO7\nG1 X5\nM99", vec![]),
        ("G54 G82 X5 Z-2 R1 P0.5", vec![]),
        ("G54 G30 P2 Z0", vec![]),
        ("G54 M100 P1\nG1 X5", vec![]),
        ("G54 P2 M8\nG1 X5", vec![6]),
        ("G55 G2 X5 R5", vec![6]),
        ("G55\nG81 X5 Z-2 R1", vec![6]),
        // Nothing moves under it.
        ("G55", vec![]),
        ("G55\nG91 G28 Z0", vec![]),
        ("G55\nG54\nG1 X5", vec![]),
    ] {
        assert_eq!(offsets(&format!("{HEAD}{blocks}")), lines, "{blocks}");
    }
    for number in ["1.5", "-1", "99999999999999999999"] {
        let found = faults(&format!("{HEAD}G54.1 P{number}"), Dialect::GCode);
        assert!(at(&found[0]) == 6 && found[0].what.contains("no work offset"), "{found:?}");
    }
    // #2500 to #2506 and their like are work offsets, too.
    for (set, lines) in [("#2501=5", vec![6]), ("#2806=5", vec![6]), ("#2807=5", vec![])] {
        assert_eq!(offsets(&format!("{HEAD}{set}\nG54\nX9")), lines, "{set}");
        assert_eq!(offsets(&format!("{set}\n{HEAD}X9\n{set}")), [0; 0], "{set}");
    }
    let same = HEAD.replace("G94", "G94 G54 P2");
    assert_eq!(offsets(&format!("{same}G54.1 P2\nX5")), [0; 0]);
}

/// Okuma: G15 H chooses a work coordinate system, G16 H one for its block.
#[test]
fn work_coordinate_systems_of_okuma() {
    let head = HEAD.replace("G94", "G94 G15 H1");
    assert_eq!(offsets(&format!("{head}G15 H2\nX5")), [6]);
    assert_eq!(offsets(&format!("{head}G15 H1\nX5\nG15")), [0; 0]);
    // Under G43 its H is no length.
    let program = of(&format!("{head}G43 H1 X5\nG15 H2\nX9"), Dialect::GCode);
    let is_doubt = |note: &&Note| note.code == Code::ChangeIgnored;
    let doubts: Vec<_> = program.warnings.iter().filter(is_doubt).collect();
    assert!(doubts.len() == 1 && doubts[0].what.contains("work offset"), "{doubts:?}");
    let found = faults(&format!("{HEAD}G16 H2 X5 Y5"), Dialect::GCode);
    assert!(at(&found[0]) == 6 && found[0].what.contains("G16 with H"), "{found:?}");
}

#[test]
fn g43_and_g44_of_one_tool_are_a_doubt() {
    for (blocks, lines) in [
        ("G43 H1 Z5\nG1 Z-1\nG44 H1 Z5\nG1 Z-1", vec![8]),
        ("G43 H1 Z5\nG1 Z-1\nG49\nG0 Z9\nG44 H1\nG1 Z-1", vec![10]),
        ("G44 H1 Z5\nG1 Z-1\nG44 H1\nX5", vec![]),
        ("G0 G43 H1 Z5\nG44 H1 Z5\nG1 X5", vec![]),
        ("G0 G43 H1 Z5\nG44 H1\nG1 X5", vec![7]),
        ("G43 H1\nG1 X5\nT2 M6\nM3\nG44 H2\nG1 X9", vec![]),
        ("G43 H1\nX5\nT2 M6\nM3\nG43 H2\nX9\nT1 M6\nM3\nG44 H1\nX5", vec![14]),
    ] {
        let program = of(&format!("{HEAD}{blocks}"), Dialect::GCode);
        assert_eq!(told(&program, "G43 and G44", Code::ChangeIgnored), lines, "{blocks}");
    }
    let without = HEAD.replace("T1 M6\n", "");
    let program = of(&format!("{without}G43 H1\nG1 X5\nG44 H1\nX9"), Dialect::GCode);
    assert_eq!(told(&program, "G43 and G44", Code::ChangeIgnored), [7]);
    for both in ["G43 G44 H1 X5", "G49 G43 H1 X5"] {
        let found = faults(&format!("{HEAD}{both}"), Dialect::GCode);
        assert!(at(&found[0]) == 6 && found[0].what.contains("in one block"), "{found:?}");
    }
}

/// A tool that comes back has the length that it had.
#[test]
fn another_length_of_a_tool_that_returns_is_a_doubt() {
    for (last, lines) in [("H1", vec![]), ("H11", vec![14])] {
        let text = format!("{HEAD}G43 H1\nX5\nT2 M6\nM3\nG43 H2\nX9\nT1 M6\nM3\nG43 {last}\nX5");
        let program = of(&text, Dialect::GCode);
        assert_eq!(told(&program, "behind length", Code::ChangeIgnored), lines, "{last}");
    }
    // The cut is where Z was stated under the other length, unless it is stated again.
    for (blocks, lines) in [
        ("G43 H2\nG1 X9", vec![7]),
        ("H2\nG1 X9", vec![7]),
        ("G1 G43 H2 X9", vec![7]),
        ("X9\nG43 H2\nG81 X5 Z-1 R1", vec![8]),
        ("G43 H2\nG91 Z1\nG90 G1 X9", vec![7]),
        ("G43 H2\nG1 X9\nX5\nY5", vec![7]),
        ("G43 H2\nX5\nG43 H1\nG1 X9", vec![]),
        ("G43 H2 Z2\nG1 X9", vec![]),
        ("G43 H2\nZ2\nG1 X9", vec![]),
        ("G43 H2\nX9", vec![]),
    ] {
        let program = of(&format!("{HEAD}G0 G43 H1 Z5\n{blocks}"), Dialect::GCode);
        assert_eq!(told(&program, "behind length", Code::ChangeIgnored), lines, "{blocks}");
    }
    let away = of(&format!("{HEAD}G43 H1 Z5\nG1 X5\nG0 G43 H11 Z9"), Dialect::GCode);
    assert_eq!(told(&away, "behind length", Code::ChangeIgnored), [8]);
    for (last, lines) in [("D1", vec![]), ("D2", vec![11])] {
        let text = format!(
            "G710 G17 G90 G94 S3000\nT1 D1 M6\nM3\nG0 X0 Y0 Z5\nG1 X1 F100\nT2 D2\nM6\nM3\n\
             G1 X5\nT1\n{last} M6\nM3\nX9"
        );
        let program = of(&text, Dialect::Sinumerik);
        assert_eq!(told(&program, "behind length", Code::ChangeIgnored), lines, "{last}");
    }
}

/// While no tool has a number, a length or an edge that the job measures stands for its tool; a cut
/// with none of them has no tcp.
#[test]
fn edges_without_a_number_of_a_tool() {
    let frame = |z: f64| Isometry3::translation(0.0, 0.0, z);
    let end_at = |head: &str, tcp: Option<f64>| {
        let job =
            Settings { tcp: tcp.map(frame), tool_frames: [(1, frame(0.15))].into(), ..settings() };
        let text = format!("G710 G17 G90 G94 S3000\n{head}\nM3\nG0 X0 Y0 Z5\nG1 X9 F500");
        read(ended(&text, Dialect::Sinumerik).as_bytes(), Dialect::Sinumerik, &job)
    };
    for (head, tcp, z) in [
        ("T=\"MILL\"\nM6\nD1", None, 0.15),
        ("T=\"MILL\" D1\nM6", None, 0.15),
        ("D1", Some(0.1), 0.15),
        ("T=\"MILL\"\nM6", Some(0.1), 0.1),
        ("D2", Some(0.1), 0.1),
    ] {
        let program = end_at(head, tcp).unwrap();
        let found = program.moves[1].tcp.translation.z;
        assert!((found - z).abs() < 1e-12, "{head}: {found}");
    }
    for (head, line) in [("T=\"MILL\"\nM6", 6), ("D2", 5)] {
        let found = end_at(head, None).unwrap_err();
        assert!(at(&found[0]) == line && found[0].what.contains("tool_frames"), "{found:?}");
    }
}

/// G10 and the parameters of Fanuc and Haas: a doubt between two cuts with that tool, unless the
/// values stay.
#[test]
fn tool_data_that_change_behind_a_cut_are_a_doubt() {
    let lines = |blocks: &str| {
        let program = of(&format!("{HEAD}{blocks}"), Dialect::GCode);
        told(&program, "cut before", Code::ChangeIgnored)
    };
    for set in [
        "G10 L10 P1 R155",
        "G10 L11 P1 R1",
        "G10 L1 P1 Z155",
        "G10 L10 R155",
        "#2001=155",
        "#2201=1",
        "#10001=155",
        "#11001=5",
        "IF [1 EQ 1] THEN #2001=155",
    ] {
        assert_eq!(lines(&format!("G43 H1 Z5\nG1 X5\n{set}\nG43 H1 Z5\nX9")), [8], "{set}");
        assert_eq!(lines(&format!("{set}\nG43 H1 Z5\nG1 X5")), [0; 0], "{set}");
    }
    for set in ["G10 L10 P1 R155", "#2001=155"] {
        assert_eq!(lines(&format!("G43 H1\nX5\n{set}")), [0; 0], "{set}");
        assert_eq!(lines(&format!("G43 H1\nX5\n{set}\nT2 M6\nM3\nG43 H2\nX9")), [0; 0], "{set}");
        assert_eq!(lines(&format!("{set}\nG43 H1\nX5\n{set}\nX9")), [0; 0], "{set}");
        let other = set.replace("155", "160");
        assert_eq!(lines(&format!("{set}\nG43 H1\nX5\n{other}\nX9")), [9], "{set}");
    }
    let by = "G10 L10 P1 R1";
    assert_eq!(lines(&format!("{by}\nG43 H1\nX5\nG91\n{by}\nX9")), [10]);
    // Of another tool, no tool data, and radii.
    let others = ["G10 L10 P2 R155", "#2002=155", "#100=5", "#1001=5"];
    let radii = ["G10 L12 P1 R5", "G10 L13 P1 R5", "#2401=5", "#2611=5", "#12001=5", "#13001=5"];
    for other in others.into_iter().chain(radii) {
        assert_eq!(lines(&format!("G43 H1 Z5\nG1 X5\n{other}\nX9")), [0; 0], "{other}");
    }
    let found = faults(&format!("{HEAD}IF [1 EQ 1] THEN #5221=10"), Dialect::GCode);
    assert!(found[0].what.contains("sets a work offset"), "{found:?}");
}

/// Sinumerik: each D has its own length; behind M6 the first one counts.
#[test]
fn another_edge_of_one_tool_is_a_doubt() {
    const CUT: &str = "M3\nG0 X0 Y0 Z5\nG1 X1 F100\n";
    for (blocks, lines) in [
        (format!("T1 D1 M6\n{CUT}D2\nX5"), vec![6]),
        (format!("T1 D1 M6\n{CUT}D=2\nX5"), vec![6]),
        (format!("T1\nM6\n{CUT}D2\nX5"), vec![7]),
        (format!("T1 M6\nD2\n{CUT}X5"), vec![]),
        (format!("T1 D2 M6\n{CUT}D2\nX5"), vec![]),
        (format!("T1 D1 M6\n{CUT}T2 D2 M6\n{CUT}X5"), vec![]),
        // D beside a T that selects counts from M6 on.
        (format!("T1 D1 M6\n{CUT}T2 D2\nX5\nM6\n{CUT}X5"), vec![]),
        (format!("D1\nT1 D2\nM6\n{CUT}X5"), vec![]),
        (format!("T1 D1 M6\n{CUT}T2 D2\nM6\n{CUT}D1\nX5"), vec![11]),
        (format!("{CUT}D2\nX5"), vec![5]),
        (format!("T1 M6\n{CUT}T2 D2\nT1\nM6\nM3\nX5"), vec![]),
        ("T1 M6\nM3\nG0 X0 Y0 Z5\nCYCLE81(20,0,2,-8)\nD2\nX5".to_owned(), vec![6]),
        ("T1 D1 M6\nM3\nG0 X0 Y0 Z5\nD2\nG1 X5 F100".to_owned(), vec![5]),
        ("T1 D1 M6\nM3\nG0 X0 Y0 Z5\nG1 D2 X5 F100".to_owned(), vec![5]),
        ("T1 M6\nM3\nG0 X0 Y0 Z5\nD2\nG1 X5 F100".to_owned(), vec![5]),
        ("T1 D1 M6\nM3\nG0 X0 Y0 Z5\nD2 Z5\nG1 X5 F100".to_owned(), vec![]),
    ] {
        let program = of(&format!("G710 G17 G90 G94 S3000\n{blocks}"), Dialect::Sinumerik);
        assert_eq!(told(&program, "behind length", Code::ChangeIgnored), lines, "{blocks}");
    }
}

/// To Fanuc without decimal input of the calculator type, 5000 is 5 mm.
#[test]
fn long_whole_numbers_without_a_point_beside_others_with_one_are_a_doubt() {
    for (blocks, lines) in [
        ("G0 X0. Y0. Z5.\nG1 Y5000 F500", vec![3]),
        ("G0 X0. Y0. Z5.\nG1 Y5000. F500", vec![]),
        ("G0 X0. Y0. Z5.\nG1 Y500 F500", vec![]),
        ("G0 X0 Y0 Z5\nG1 X10.5 Y5000 F500", vec![]),
        ("G0 X0. Y0. Z5.\n#1=5000\nG1 Y#1 F500", vec![]),
        ("G0 X0. Y0. Z5.\nG1 Y[4000+1000] F500", vec![]),
    ] {
        let program = of(&format!("G21 G17 G90 G94\n{blocks}"), Dialect::GCode);
        assert_eq!(told(&program, "without a decimal", Code::UnitAssumed), lines, "{blocks}");
    }
}
