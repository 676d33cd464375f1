//! G-code with subprograms in files of their own, which the job names beside the program.

use detune::notes::Note;
use detune::program::{Companion, Dialect, NewSpeed, Program, Rewrite, Settings, read, rewrite};

use super::support::{assert_ends, at, lines, settings};

const HEAD: &str = "G90 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z50\nF120\n";

fn job(files: &[(&str, &str)]) -> Settings {
    let companion =
        |(name, text): &(&str, &str)| Companion::new((*name).to_owned(), text.as_bytes()).unwrap();
    Settings { companions: files.iter().map(companion).collect(), ..settings() }
}

fn run(text: &str, dialect: Dialect, files: &[(&str, &str)]) -> Result<Program, Vec<Note>> {
    read(format!("{HEAD}{text}M30\n").as_bytes(), dialect, &job(files))
}

#[track_caller]
fn assert_way(text: &str, dialect: Dialect, files: &[(&str, &str)], expected: &[[f64; 3]]) {
    let program = run(text, dialect, files).unwrap();
    let start = [[0.0, 0.0, 50.0]];
    let ends: Vec<_> = start.iter().chain(expected).map(|at| ('L', *at)).collect();
    assert_ends(&program, &ends);
}

const STEP: (&str, &str) =
    ("L100.SPF", "%_N_L100_SPF\n;$PATH=/_N_SPF_DIR\nN5 G91 G1 X1\nG90\nRET\n");
const POCKET: (&str, &str) =
    ("sub/pocket_a.spf", "PROC POCKET_A\nDEF REAL _D=3\nG1 Y=_D\nR1=20\nM17\n");

#[test]
fn subprograms_of_sinumerik() {
    let text = "R1=7\nL100 P2\nPOCKET_A\nG1 X=R1\n";
    let program = run(text, Dialect::Sinumerik, &[STEP, POCKET]).unwrap();
    let ends = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 3.0], [20.0, 3.0]];
    assert_ends(&program, &ends.map(|[x, y]| ('L', [x, y, 50.0])));
    // Findings point at the lines of the program that call.
    assert_eq!(lines(&program), [4, 7, 7, 8, 9]);
    // Variables of a program are its own, R parameters are not.
    let own = "DEF REAL _D=9\nPOCKET_A\nG1 X=_D\n";
    assert_way(own, Dialect::Sinumerik, &[POCKET], &[[0.0, 3.0, 50.0], [9.0, 3.0, 50.0]]);
    // So are labels.
    let loops = ("LOOPS.SPF", "R2=0\nAGAIN: R2=R2+1\nG1 Z=R2\nIF R2<2 GOTOB AGAIN\nRET\n");
    let text = "AGAIN: G1 X1\nLOOPS\n";
    let expected = [[1.0, 0.0, 50.0], [1.0, 0.0, 1.0], [1.0, 0.0, 2.0]];
    assert_way(text, Dialect::Sinumerik, &[loops], &expected);
    let found = run("G1 X1\nBACK: X2\nJUMP\n", Dialect::Sinumerik, &[("JUMP.SPF", "GOTOB BACK\n")]);
    assert!(found.unwrap_err()[0].what.contains("JUMP.SPF:1: GOTOB: BACK is not there"));
}

#[test]
fn subprograms_by_their_number() {
    let step =
        ("O1234.nc", "%\nO1234\nN10 G91 G1 X1\nIF [#100 GT 1] GOTO 20\nX1\nN20 G90 M99\n%\n");
    let text = "#100=1\nM98 P1234\n#100=2\nM98 P1234 L2\nGOTO 20\nX99\nN20 G1 Y5\n";
    let xs = [1.0, 2.0, 3.0, 4.0];
    let expected: Vec<_> = xs.iter().map(|x| [*x, 0.0, 50.0]).chain([[4.0, 5.0, 50.0]]).collect();
    assert_way(text, Dialect::GCode, &[step], &expected);
    // By the name of the file alone, and with locals.
    let by_name = ("9010.nc", "G1 X#1\nM99\n");
    assert_way("G65 P9010 A7\n", Dialect::GCode, &[by_name], &[[7.0, 0.0, 50.0]]);
    let o_word = ("step.ngc", "o<step> sub\nG1 X#1\no<step> endsub\n");
    assert_way("o<step> call [3]\n", Dialect::GCode, &[o_word], &[[3.0, 0.0, 50.0]]);
}

#[test]
fn errors_beside_the_program_name_file_and_line() {
    let refused = |text: &str, dialect, files: &[(&str, &str)], said: &str| {
        let found = run(text, dialect, files).expect_err(text);
        assert!(found[0].what.contains(said) && at(&found[0]) == 6, "{text}: {found:?}");
    };
    let sinumerik = Dialect::Sinumerik;
    refused("L100\n", sinumerik, &[], "path.program.files");
    refused("POCKET_A\n", sinumerik, &[STEP], "path.program.files");
    refused("POCKET_A(1,2)\n", sinumerik, &[POCKET], "calls a subprogram");
    refused("M98 P7\n", Dialect::GCode, &[STEP], "path.program.files");
    refused("L7\n", sinumerik, &[("L7.SPF", "G1 X1\nG1 Q5 WHAT\nRET\n")], "L7.SPF:2: 'WHAT'");
    refused("L7\n", sinumerik, &[("L7.SPF", "PROC L7 SAVE\nRET\n")], "L7.SPF:1: PROC with SAVE");
    refused("L7\n", sinumerik, &[("L7.SPF", "G1 X1\n")], "ends without M99, M17 or RET");
    refused("L7\n", sinumerik, &[("L7.SPF", "L7\nRET\n")], "nested too deep");
}

/// The files beside the program stay as they are.
#[test]
fn the_program_alone_is_rewritten() {
    let text = format!("{HEAD}L100\nG1 X5 F600\nM30\n");
    let new = |files: &[(&str, &str)]| {
        let speeds = vec![NewSpeed { end: usize::MAX, rpm: 6000.0, job_rpm: None }];
        let to = Rewrite { speeds, keeps_chip_load: true };
        rewrite(text.as_bytes(), Dialect::Sinumerik, &job(files), &to)
    };
    let found = new(&[STEP]).unwrap();
    let expected = text.replace("S3000", "S6000").replace("F120", "F240").replace("F600", "F1200");
    assert_eq!(String::from_utf8(found.bytes).unwrap(), expected);
    assert!(new(&[("L100.SPF", "G1 X1 F90\nRET\n")]).is_err());
}
