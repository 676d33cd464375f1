//! Programs with random damage are read or refused, never more; long ones are read fast.

use std::fmt::Write as _;
use std::time::Instant;

use detune::motion::{Move, Target};
use detune::notes::{Code, Note};
use detune::program::{Dialect, Program, read};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::support::{at, lines, settings};

#[path = "../../../fuzz/fuzz_targets/reader.rs"]
mod reader;

const PROGRAMS: [(Dialect, &[u8]); 7] = [
    (Dialect::Rapid, include_bytes!("../../data/programs/pocket_latin1_crlf.mod")),
    (Dialect::Rapid, include_bytes!("../../data/programs/carried.mod")),
    (Dialect::Apt, include_bytes!("../../data/programs/contour.apt")),
    (Dialect::GCode, include_bytes!("../../data/programs/pocket.ngc")),
    (Dialect::Krl, include_bytes!("../../data/programs/pocket.src")),
    (Dialect::Fanuc, include_bytes!("../../data/programs/pocket.ls")),
    (Dialect::Heidenhain, include_bytes!("../../data/programs/pocket.h")),
];

/// What grammars are made of, to be put where it does not belong.
const PIECES: [&str; 26] = [
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "\\",
    ":=",
    ";",
    "/",
    "$",
    "\n",
    "-",
    "9E99",
    "0",
    "1E308",
    "IF ",
    "ENDIF",
    "FOR i FROM 1 TO 9 DO ",
    "ENDPROC",
    "PROC main()",
    "main;",
    "G2 ",
    "R",
    "GOTO/",
    "CYCLE/",
];

fn damaged(rng: &mut ChaCha8Rng, program: &[u8]) -> Vec<u8> {
    let mut bytes = program.to_vec();
    for _ in 0..rng.random_range(1..6) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.random_range(0..bytes.len());
        let end = (at + rng.random_range(0..30)).min(bytes.len());
        match rng.random_range(0..5) {
            0 => bytes[at] = rng.random(),
            1 => drop(bytes.drain(at..end)),
            2 => {
                let part = bytes[at..end].to_vec();
                let to = rng.random_range(0..=bytes.len());
                drop(bytes.splice(to..to, part));
            }
            3 => bytes.truncate(at.max(1)),
            _ => {
                let piece = PIECES[rng.random_range(0..PIECES.len())];
                let repeated = piece.repeat(rng.random_range(1..4));
                drop(bytes.splice(at..at, repeated.into_bytes()));
            }
        }
    }
    bytes
}

fn assert_sound(read: &Result<Program, Vec<Note>>, line_count: usize) {
    let at_a_line = |line: usize| (1..=line_count).contains(&line);
    match read {
        Ok(program) => {
            assert!(!program.moves.is_empty());
            assert!(program.moves.iter().all(|each| at_a_line(each.line) && is_finite(each)));
            assert!(program.warnings.iter().all(|notice| at_a_line(at(notice))));
        }
        Err(faults) => {
            assert!(!faults.is_empty());
            assert!(
                faults.iter().all(|fault| fault.code == Code::More || at_a_line(at(fault))),
                "{faults:?}"
            );
        }
    }
}

fn is_finite(each: &Move) -> bool {
    let poses = match &each.to {
        Target::Joints(joints) => return joints.iter().all(|joint| joint.is_finite()),
        Target::JointsTo(pose) | Target::Line(pose) => vec![*pose],
        Target::Arc { via, end, .. } => vec![*via, *end],
    };
    each.feed_m_per_s > 0.0
        && each.feed_m_per_s.is_finite()
        && poses.iter().chain([&each.tcp]).all(|pose| {
            let turned = pose.rotation.coords;
            pose.translation.vector.iter().chain(turned.iter()).all(|number| number.is_finite())
        })
}

#[test]
fn damaged_programs_never_panic() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_121);
    let (mut understood, mut refused) = (0, 0);
    for (dialect, program) in PROGRAMS {
        for _ in 0..2500 {
            let bytes = damaged(&mut rng, program);
            let found = read(&bytes, dialect, &settings());
            let line_count = 1 + bytes.iter().filter(|&&b| matches!(b, b'\n' | b'\r')).count();
            assert_sound(&found, line_count);
            understood += usize::from(found.is_ok());
            refused += usize::from(found.is_err());
        }
    }
    // The damage is neither harmless nor total, so both ways are walked.
    assert!(understood > 500 && refused > 500, "{understood} {refused}");
}

/// The text without numbers and without what gives a named speed of RAPID another.
fn without_numbers(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text).replace("\\V:=", "");
    text.chars().filter(|c| !matches!(c, '0'..='9' | '.' | '-' | '+')).collect()
}

/// The fuzz targets, on damage that leaves most programs readable: what is read and can be written
/// with another speed reads back so (the target asserts it), and differs in numbers alone.
#[test]
fn programs_with_small_damage_are_rewritten_and_differ_in_numbers_alone() {
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    let mut written = [0; PROGRAMS.len()];
    for (count, (dialect, program)) in written.iter_mut().zip(PROGRAMS) {
        for _ in 0..400 {
            let mut bytes = program.to_vec();
            let digits: Vec<usize> =
                (0..bytes.len()).filter(|at| bytes[*at].is_ascii_digit()).collect();
            for _ in 0..rng.random_range(1..8) {
                bytes[digits[rng.random_range(0..digits.len())]] =
                    b'0' + rng.random_range(0..10_u8);
            }
            if let Some(new) = reader::run(dialect, &bytes) {
                assert_eq!(without_numbers(&new), without_numbers(&bytes), "{dialect:?}");
                *count += 1;
            }
            drop(reader::run(dialect, &damaged(&mut rng, program)));
        }
    }
    println!("rewritten, of 400 of each dialect: {written:?}");
    assert!(written.iter().sum::<usize>() >= 300, "{written:?}");
}

#[test]
fn deep_nesting_is_refused_and_not_followed() {
    let deep =
        |open: &str, close: &str| format!("{}1{}", open.repeat(50_000), close.repeat(50_000));
    let expressions =
        [deep("(", ")"), deep("[", "]"), deep("-(", ")"), deep("NOT ", ""), deep("Abs(", ")")];
    for expression in expressions {
        let text = super::support::module(&format!("MoveL {expression},v5,fine,tool0;"));
        let found = super::support::faults(&text, Dialect::Rapid);
        assert_eq!(at(&found[0]), 4);
    }
    let blocks = format!("{}{}", "IF TRUE THEN\n".repeat(50_000), "ENDIF\n".repeat(50_000));
    super::support::faults(&super::support::module(&blocks), Dialect::Rapid);
    let short = "IF TRUE ".repeat(50_000);
    super::support::faults(&super::support::module(&short), Dialect::Rapid);
    // A chain of constants, each by the next.
    let mut chain = String::new();
    for i in 0..50_000 {
        writeln!(chain, "CONST num c{i}:=c{};", i + 1).unwrap();
    }
    let text = format!(
        "MODULE m\n{chain}PROC main()\nMoveL Offs(p,c0,0,0),v5,fine,tool0;\nENDPROC\nENDMODULE"
    );
    super::support::faults(&text, Dialect::Rapid);
}

#[test]
fn procedures_that_call_each_other_many_times_end() {
    let mut text = String::from("MODULE m\nPROC main()\np0;\nENDPROC\n");
    for i in 0..60 {
        writeln!(text, "PROC p{i}()\np{};\np{};\nENDPROC", i + 1, i + 1).unwrap();
    }
    text.push_str("PROC p60()\nIF DInput(d)=1 p1;\nENDPROC\nENDMODULE");
    super::support::faults(&text, Dialect::Rapid);
}

/// The figures are printed, not asserted: `cargo test --test analytic long_programs -- --nocapture`.
#[test]
fn long_programs_keep_their_lines() {
    const LINES: usize = 100_000;
    let mut rapid = String::from("MODULE m\nPROC main()\n");
    let mut apt = String::from("FEDRAT/300,MMPM\n\n");
    let mut gcode = String::from("G1 F300\nG90\n");
    for i in 0..LINES {
        let x = i as f64 * 0.01;
        writeln!(rapid, "MoveL [[{x:.3},20.5,-3.25],[0,1,0,0],[0,-1,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]],v50,z1,tool0\\WObj:=wobj0;").unwrap();
        writeln!(apt, "GOTO/{x:.5},20.50000,-3.25000,0.0,0.0,1.0").unwrap();
        writeln!(gcode, "N{i} X{x:.3} Y20.5 Z-3.25").unwrap();
    }
    rapid.push_str("ENDPROC\nENDMODULE\n");
    apt.push_str("FINI\n");
    gcode.push_str("M30\n");
    for (dialect, text) in [(Dialect::Rapid, rapid), (Dialect::Apt, apt), (Dialect::GCode, gcode)] {
        let start = Instant::now();
        let program = read(text.as_bytes(), dialect, &settings()).unwrap();
        println!("{dialect:?}: {LINES} lines in {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
        assert_eq!(lines(&program), (3..LINES + 3).collect::<Vec<_>>());
    }
}
