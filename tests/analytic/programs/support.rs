//! What the tests of programs share.

use detune::motion::{Move, Target};
use detune::notes::Note;
use detune::program::{Dialect, Program, Settings, read};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

/// Ten nanometres and ten nanoradians: the frames in the programs have seven digits.
pub(super) const CLOSE_M: f64 = 1e-8;
pub(super) const CLOSE_RAD: f64 = 1e-6;

pub(super) fn settings() -> Settings {
    Settings { feed_m_per_s: Some(0.01), joint_count: 6, ..Settings::default() }
}

/// A pose from mm and a quaternion, real part first.
pub(super) fn pose(at_mm: [f64; 3], quaternion: [f64; 4]) -> Isometry3<f64> {
    let [w, x, y, z] = quaternion;
    Isometry3::from_parts(
        Translation3::from(at_mm.map(|mm| mm / 1000.0)),
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
    )
}

pub(super) fn rapid(text: &str) -> Program {
    read(text.as_bytes(), Dialect::Rapid, &settings()).expect("the program is right")
}

/// A module around instructions, of which the first is on line 4, with the usual targets.
pub(super) fn module(instructions: &str) -> String {
    format!(
        "MODULE m\nCONST robtarget p:=[[100,200,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
         PROC main()\n{instructions}\nENDPROC\nENDMODULE\n"
    )
}

/// A program with the end that its dialect wants.
pub(super) fn ended(text: &str, dialect: Dialect) -> String {
    match dialect {
        Dialect::Rapid | Dialect::Krl | Dialect::Fanuc | Dialect::Heidenhain => text.to_owned(),
        Dialect::Apt => format!("{text}\nFINI\n"),
        Dialect::GCode | Dialect::Sinumerik => format!("{text}\nM2\n"),
    }
}

pub(super) fn faults(text: &str, dialect: Dialect) -> Vec<Note> {
    read(ended(text, dialect).as_bytes(), dialect, &settings()).expect_err("the program is wrong")
}

/// The line that a note stands at.
pub(super) fn at(note: &Note) -> usize {
    note.place.line.expect("a line")
}

pub(super) fn lines(program: &Program) -> Vec<usize> {
    program.moves.iter().map(|each| each.line).collect()
}

/// Where a move ends, and by what way: `J`oints, joints `T`o, `L`ine, `A`rc.
pub(super) fn end(each: &Move) -> (char, Isometry3<f64>) {
    match &each.to {
        Target::Joints(_) => ('J', Isometry3::identity()),
        Target::JointsTo(pose) => ('T', *pose),
        Target::Line(pose) => ('L', *pose),
        Target::Arc { end, .. } => ('A', *end),
    }
}

#[track_caller]
pub(super) fn assert_pose(found: &Isometry3<f64>, expected: &Isometry3<f64>) {
    let off = (found.translation.vector - expected.translation.vector).norm();
    assert!(off < CLOSE_M, "found {found}, expected {expected}");
    assert!(found.rotation.angle_to(&expected.rotation) < CLOSE_RAD, "{found} {expected}");
}

#[track_caller]
pub(super) fn assert_ends(program: &Program, expected: &[(char, [f64; 3])]) {
    let found: Vec<_> = program.moves.iter().map(end).collect();
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for ((way, pose), (expected_way, at_mm)) in found.iter().zip(expected) {
        assert_eq!(way, expected_way);
        let off = pose.translation.vector - nalgebra::Vector3::from(at_mm.map(|mm| mm / 1000.0));
        assert!(off.norm() < CLOSE_M, "found {pose}, expected {at_mm:?} mm");
    }
}

/// What stands before the blocks of a test, and where it leaves the tool, mm.
pub(super) struct Begun {
    pub(super) head: &'static str,
    pub(super) at_mm: [f64; 3],
    pub(super) dialect: Dialect,
}

impl Begun {
    pub(super) fn run(&self, text: &str) -> Result<Program, Vec<Note>> {
        read(format!("{}{text}M30\n", self.head).as_bytes(), self.dialect, &settings())
    }

    #[track_caller]
    pub(super) fn refused(&self, text: &str, said: &str) {
        let found = self.run(text).expect_err(text);
        assert!(found[0].what.contains(said), "{text}: {found:?}");
        assert!(at(&found[0]) > self.head.lines().count(), "{found:?}");
    }

    /// The ends of all moves behind the first.
    #[track_caller]
    pub(super) fn assert_way(&self, text: &str, expected: &[(char, [f64; 3])]) -> Program {
        let program = self.run(text).unwrap();
        assert_ends(&program, &[&[('L', self.at_mm)], expected].concat());
        program
    }
}
