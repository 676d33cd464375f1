//! Intervals and probabilities after a calibration, against arms as they really are: springs off by 15 %, masses with
//! their inertias by 10 %, as the robot file states, and in half of the arms a foundation or a law of a spring that the
//! model lacks. Some of the modes are measured at a few poses of a part of the range; the intervals must hold the true
//! frequencies of fresh poses there, of modes that nobody measured, and of poses beyond that part, in 95 % of all cases.
//!
//! `DETUNE_ARMS` sets the number of arms: 200 for the figures of the guide.

use std::fs;
use std::path::Path;

use crate::truth::arm::{Arm, Extra, Kind};
use crate::truth::dice::Dice;
use crate::truth::robots::{Family, arm, row_at};
use crate::truth::run::detune;
use crate::truth::world::{Row, World};
use crate::truth::write::{self, Columns};

/// One standard deviation of ln of springs and of links, as the robot file states them.
const STD_OF_SPRINGS: f64 = 0.15;
const STD_OF_LINKS: f64 = 0.10;

/// Noise of a measured frequency, relative.
const NOISE: f64 = 0.002;

const MEASURED_POSES: usize = 14;
const FRESH_POSES: usize = 12;

/// How many intervals held, of how many.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    held: usize,
    all: usize,
}

impl Tally {
    fn add(&mut self, held: bool) {
        self.held += usize::from(held);
        self.all += 1;
    }

    fn share(self) -> f64 {
        self.held as f64 / self.all as f64
    }
}

/// Where the intervals were asked for.
#[derive(Debug, Clone, Copy, Default)]
struct Coverage {
    uncalibrated: Tally,
    measured: Tally,
    unmeasured: Tally,
    beyond: Tally,
}

/// An arm as it is, and what its file says.
struct Arms {
    nominal: Arm,
    world: World,
}

impl Arms {
    fn draw(family: Family, lacks: bool, dice: &mut Dice) -> Self {
        let nominal = arm(family, dice);
        let mut world = World::of(&nominal);
        for joint in &mut world.arm.joints {
            joint.stiffness_nm_per_rad *= (STD_OF_SPRINGS * dice.normal()).exp();
            let factor = (STD_OF_LINKS * dice.normal()).exp();
            joint.body.mass_kg *= factor;
            joint.body.inertia_kgm2 *= factor;
        }
        if lacks {
            // A foundation that takes some per cent off the lowest frequency.
            let softest = world.arm.joints.iter().map(|joint| joint.stiffness_nm_per_rad);
            let softest = softest.fold(f64::INFINITY, f64::min);
            world.arm.extras.push(Extra {
                name: "ground".to_owned(),
                link: 0,
                kind: Kind::Rotation,
                axis: nominal.joints[1].axis,
                origin_m: nalgebra::Vector3::zeros(),
                stiffness: softest * dice.log_even(8.0, 30.0),
            });
        }
        Self { nominal, world }
    }

    /// A pose in the middle half of every joint's range, or with one joint outside of it.
    fn pose(&self, outside: bool, dice: &mut Dice) -> Vec<f64> {
        let astray = dice.index(self.nominal.joints.len());
        let place = |(i, joint): (usize, &crate::truth::arm::Joint)| {
            let [from, to] = joint.limits_rad;
            let share = match outside && i == astray {
                true if dice.chance(0.5) => dice.even(0.0, 0.2),
                true => dice.even(0.8, 1.0),
                false => dice.even(0.25, 0.75),
            };
            ((from + share * (to - from)) * 1e4).round() / 1e4
        };
        self.nominal.joints.iter().enumerate().map(place).collect()
    }

    fn write(&self, folder: &Path) {
        write::robot(&self.nominal, folder);
        let file = folder.join("robot.yaml");
        let mut text = fs::read_to_string(&file).unwrap();
        for joint in &self.nominal.joints {
            let k = joint.stiffness_nm_per_rad;
            let stated = format!("{}: {{stiffness_nm_per_rad: {k}", joint.name);
            let percent = 100.0 * STD_OF_SPRINGS;
            text = text.replace(&stated, &format!("{stated}, std_percent: {percent}"));
        }
        text += "inertials:\n";
        for joint in &self.nominal.joints {
            text += &format!("  {}: {{std_percent: {}}}\n", joint.link, 100.0 * STD_OF_LINKS);
        }
        fs::write(file, text).unwrap();
    }
}

/// Lower and upper ends of the intervals of `detune map --intervals`, pose by pose and mode by mode.
fn intervals(folder: &Path, robot: &str, arm: &Arm, poses: &[Vec<f64>]) -> Vec<Vec<[f64; 2]>> {
    let names: Vec<String> = arm.joints.iter().map(|j| format!("{}_rad", j.name)).collect();
    let mut text = names.join(",") + "\n";
    for q in poses {
        let cells: Vec<String> = q.iter().map(f64::to_string).collect();
        text += &(cells.join(",") + "\n");
    }
    fs::write(folder.join("poses.csv"), text).unwrap();
    let csv = detune(folder, &["map", robot, "--poses", "poses.csv", "--intervals"], "map.csv");
    let csv = csv.unwrap();
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: String| head.iter().position(|h| *h == name).unwrap();
    let modes = arm.joints.len();
    let ends: Vec<[usize; 2]> = (1..=modes)
        .map(|r| [column(format!("f{r}_lo95_hz")), column(format!("f{r}_hi95_hz"))])
        .collect();
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            ends.iter().map(|end| end.map(|c| cells[c].parse().unwrap())).collect()
        })
        .collect()
}

/// One arm: calibrated by some modes at some poses, asked at fresh ones.
fn cover(family: Family, lacks: bool, seed: u64, into: &mut Coverage) {
    let dice = &mut Dice::new(seed);
    let arms = Arms::draw(family, lacks, dice);
    let modes = arms.nominal.joints.len();
    let measured = modes.div_ceil(2);
    let folder = tempfile::tempdir().unwrap();
    arms.write(folder.path());
    let rows: Vec<Row> = (0..MEASURED_POSES).map(|_| row_at(arms.pose(false, dice))).collect();
    let seen: Vec<Vec<Option<f64>>> = rows
        .iter()
        .map(|row| {
            let f = arms.world.frequencies_hz(row, measured);
            f.iter().map(|f| Some(f * (1.0 + NOISE * dice.normal()))).collect()
        })
        .collect();
    let columns = Columns { deviations: Some(NOISE), ..Columns::default() };
    let table = write::table(&arms.nominal, &rows, &seen, columns);
    fs::write(folder.path().join("measured.csv"), table).unwrap();
    let arguments = ["diagnose", "robot.yaml", "measured.csv", "--write", "calibrated.yaml"];
    detune(folder.path(), &arguments, "diagnosis.txt").unwrap();

    let inside: Vec<Vec<f64>> = (0..FRESH_POSES).map(|_| arms.pose(false, dice)).collect();
    let outside: Vec<Vec<f64>> = (0..FRESH_POSES).map(|_| arms.pose(true, dice)).collect();
    let holds = |robot: &str, poses: &[Vec<f64>], take: &mut dyn FnMut(usize, bool)| {
        let found = intervals(folder.path(), robot, &arms.nominal, poses);
        for (q, ends) in poses.iter().zip(found) {
            let truth = arms.world.frequencies_hz(&row_at(q.clone()), modes);
            for (r, ([low, high], f)) in ends.iter().zip(&truth).enumerate() {
                take(r, low < f && f < high);
            }
        }
    };
    if !lacks {
        holds("robot.yaml", &inside, &mut |_, held| into.uncalibrated.add(held));
    }
    holds("calibrated.yaml", &inside, &mut |r, held| {
        if r < measured { into.measured.add(held) } else { into.unmeasured.add(held) }
    });
    holds("calibrated.yaml", &outside, &mut |_, held| into.beyond.add(held));
}

const FAMILIES: [Family; 3] =
    [Family::Planar { links: 2 }, Family::Planar { links: 3 }, Family::SixAxis];

fn arms() -> usize {
    std::env::var("DETUNE_ARMS").ok().and_then(|text| text.parse().ok()).unwrap_or(12)
}

fn covered(lacks: bool) -> Coverage {
    let mut coverage = Coverage::default();
    for i in 0..arms() {
        cover(FAMILIES[i % 3], lacks, 4000 + i as u64, &mut coverage);
    }
    println!("{} arms, lacking an effect: {lacks}", arms());
    let Coverage { uncalibrated, measured, unmeasured, beyond } = coverage;
    for (what, tally) in [
        ("uncalibrated", uncalibrated),
        ("measured modes", measured),
        ("unmeasured modes", unmeasured),
        ("poses beyond", beyond),
    ] {
        println!("  {what:<17} {:.1} % of {}", 100.0 * tally.share(), tally.all);
    }
    coverage
}

/// With few arms the shares scatter: poses and modes of one arm are off together.
fn expect(what: &str, tally: Tally) {
    let [least, most] = if arms() >= 100 { [0.93, 0.985] } else { [0.85, 1.0] };
    let share = tally.share();
    assert!((least..=most).contains(&share), "{what}: {:.1} %", 100.0 * share);
}

#[test]
fn intervals_hold_what_they_say() {
    let found = covered(false);
    expect("uncalibrated", found.uncalibrated);
    expect("measured modes", found.measured);
    expect("unmeasured modes", found.unmeasured);
    expect("poses beyond", found.beyond);
}

#[test]
fn intervals_hold_where_the_model_lacks_an_effect() {
    let found = covered(true);
    expect("measured modes", found.measured);
    expect("unmeasured modes", found.unmeasured);
    expect("poses beyond", found.beyond);
}
