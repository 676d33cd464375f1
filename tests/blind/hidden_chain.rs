//! The whole chain on a truth in the time domain: noisy hammer records of a damped, slightly nonlinear arm go
//! through `detune identify` and `detune diagnose`, and the effect that is hidden in the arm comes out.
//!
//! Nothing of the crate makes the records: see [`crate::truth::records`].

use std::fs;
use std::path::Path;

use crate::truth::arm::Arm;
use crate::truth::dice::Dice;
use crate::truth::effects::{Change, Effect};
use crate::truth::records::HammerTest;
use crate::truth::robots::{Family, arm, pose, row_at};
use crate::truth::run::{detune, diagnose};
use crate::truth::score::{Diagnosis, Named};
use crate::truth::world::{Row, World};
use crate::truth::write;

const POSES: usize = 14;

/// Of an identified frequency: noise, and springs that stiffen by some per mille while the arm still swings.
const IDENTIFIED_WITHIN: f64 = 0.004;

/// An arm, what is wrong with its model, and records of it.
struct Chain {
    folder: tempfile::TempDir,
    world: World,
    rows: Vec<Row>,
}

impl Chain {
    /// Records of a two-link arm with a change hidden in it, or none.
    fn new(seed: u64, change: impl Fn(&Arm) -> Option<(Change, f64)>) -> Self {
        let dice = &mut Dice::new(seed);
        let nominal = loop {
            let arm = arm(Family::Planar { links: 2 }, dice);
            // Well inside half of the sampling rate, and quiet again before the next blow.
            let fits = (0..6).all(|_| {
                let f = World::of(&arm).frequencies_hz(&row_at(pose(&arm, dice)), 2);
                f[0] > 12.0 && f[1] < 120.0
            });
            if fits {
                break arm;
            }
        };
        let mut world = World::of(&nominal);
        if let Some((change, size)) = change(&nominal) {
            change.apply(&mut world, size);
        }
        let rows: Vec<Row> = (0..POSES).map(|_| row_at(pose(&nominal, dice))).collect();
        let folder = tempfile::tempdir().unwrap();
        write::robot(&nominal, folder.path());
        HammerTest::default().session(&world, &rows, folder.path(), dice);
        Self { folder, world, rows }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Identifies and diagnoses; checks the frequencies on the way.
    fn run(&self) -> Diagnosis {
        let arguments = ["identify", "session.yaml", "--format", "json", "--write", "measured.csv"];
        detune(self.path(), &arguments, "identified.json").unwrap();
        let table = fs::read_to_string(self.path().join("measured.csv")).unwrap();
        let mut lines = table.lines().filter(|line| !line.starts_with('#'));
        let head: Vec<&str> = lines.next().unwrap().split(',').collect();
        let column = |name: &str| {
            head.iter().position(|h| *h == name).unwrap_or_else(|| panic!("no {name} in {head:?}"))
        };
        let joints = [1, 2].map(|i| {
            let name = format!("joint_{i}");
            let degrees = format!("{name}_deg");
            let in_degrees = head.contains(&degrees.as_str());
            (column(&if in_degrees { degrees } else { format!("{name}_rad") }), in_degrees)
        });
        let modes = [column("f1_hz"), column("f2_hz")];
        let lines: Vec<&str> = lines.collect();
        assert_eq!(lines.len(), POSES, "one row a pose");
        let mut seen = 0;
        for line in lines {
            let cells: Vec<&str> = line.split(',').collect();
            let q = joints.map(|(c, in_degrees)| {
                let q: f64 = cells[c].parse().unwrap();
                if in_degrees { q.to_radians() } else { q }
            });
            let near = |row: &&Row| row.joints_rad.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-5);
            let row = self.rows.iter().find(near).unwrap_or_else(|| panic!("no such pose: {q:?}"));
            let truth = self.world.frequencies_hz(row, 2);
            for (c, f) in modes.iter().zip(truth) {
                // A mode that the blow hardly moves may be blank.
                let Ok(identified) = cells[*c].parse::<f64>() else { continue };
                let off = (identified / f - 1.0).abs();
                assert!(
                    off < IDENTIFIED_WITHIN,
                    "{identified} Hz identified, {f} Hz true at {q:?}"
                );
                seen += 1;
            }
        }
        assert!(seen >= 2 * POSES - 3, "{seen} of {} modes identified", 2 * POSES);
        diagnose(self.path(), "diagnosis.json").unwrap()
    }
}

/// Whether a diagnosis names an effect as a finding or in a group of at most four.
fn names(diagnosis: &Diagnosis, effect: &Effect) -> bool {
    let is = |named: &Named| named.cause == effect.cause && effect.at.contains(&named.at);
    diagnosis.findings.iter().any(|finding| {
        finding.group.len() < 4 && (is(&finding.named) || finding.group.iter().any(is))
    })
}

#[test]
fn a_soft_joint_is_found_from_hammer_records() {
    let change = Change::JointStiffness { joint: 1, softer: true };
    let chain = Chain::new(21, |_| Some((change.clone(), 0.3)));
    let diagnosis = chain.run();
    let at = vec!["joint_2".to_owned()];
    let effect = Effect { cause: "joint_stiffness", at, change };
    assert!(names(&diagnosis, &effect), "{:?}", diagnosis.findings);
    assert_eq!(diagnosis.verdict, "explained");
    assert!(diagnosis.extended_held_out_percent < 0.3 * diagnosis.baseline_held_out_percent);
}

#[test]
fn a_spindle_that_nobody_mentioned_is_found_from_hammer_records() {
    let hidden =
        |arm: &Arm| Change::Payload { link: 2, com_m: arm.tip_m, gyration_m: 0.0, tool: true };
    let chain = Chain::new(22, |arm| Some((hidden(arm), 9.0)));
    let diagnosis = chain.run();
    let at = vec!["tool0".to_owned(), "link_2".to_owned()];
    let effect = Effect { cause: "payload", at, change: hidden(&chain.world.arm) };
    assert!(names(&diagnosis, &effect), "{:?}", diagnosis.findings);
    assert_eq!(diagnosis.verdict, "explained");
    assert!(diagnosis.extended_held_out_percent < 0.3 * diagnosis.baseline_held_out_percent);
}

/// The cubic springs move the frequencies by less than a measurement is worth: no cause is to be made of that.
#[test]
fn a_right_model_stays_nearly_right_through_the_chain() {
    let diagnosis = Chain::new(23, |_| None).run();
    assert!(diagnosis.baseline_held_out_percent < 100.0 * IDENTIFIED_WITHIN);
}
