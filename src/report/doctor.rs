//! A robot model examined, as text.

use crate::notes::{Class, Note};
use crate::report::layout::push_fact;
use crate::report::words;
use crate::study::doctor::{Examined, ExaminedPose, MEASURED_ARMS, Which};
use crate::units::{deg_from_rad, mm_from_m, percent_from_ratio};
use crate::wording::{printable, wrapped};

/// Figures of the robot, its frequencies beside those of other arms, and what is doubtful.
pub fn examination(robot: &Examined) -> String {
    let mut text = format!("{}  {}\n", words::path(&robot.file), printable(&robot.name));
    let trust = if robot.calibrated { "calibrated" } else { "not calibrated" };
    let within = robot.within.map_or(String::new(), |share| {
        let percent = words::trimmed(percent_from_ratio(share), 1);
        format!("; frequencies within ± {percent} %")
    });
    let kg = words::number(robot.moving_mass_kg, 1);
    let mass = format!("{kg} kg move with the joints; {trust}{within}");
    push_fact(2, "model", &mass, &mut text);
    for spring in &robot.springs {
        let unit = if spring.shifts { "N/m" } else { "N·m/rad" };
        let assumed = if spring.is_assumed { " assumed" } else { "" };
        let off_by = spring.std.map_or(String::new(), |std| {
            format!(", ± {} %{assumed}", words::trimmed(percent_from_ratio(std), 1))
        });
        let k = words::number(spring.stiffness, 0);
        push_fact(2, "spring", &format!("{}: {k} {unit}{off_by}", spring.name), &mut text);
    }
    text.push_str("\n  natural frequencies, Hz\n");
    for pose in &robot.poses {
        let hz: Vec<String> = pose.frequencies_hz.iter().map(|f| words::hz(*f)).collect();
        wrapped(&mut text, &format!("    {:<9} ", which(pose.which)), &hz.join(", "));
        wrapped(&mut text, "              at ", &joints(robot, pose));
    }
    text.push_str("  measured arms, Hz\n");
    for (arm, hz) in MEASURED_ARMS {
        wrapped(&mut text, "    ", &format!("{arm}: {hz}"));
    }
    text.push('\n');
    let doubts = robot.warnings.iter().filter(|note| note.code.class() == Class::Doubt).count();
    for note in &robot.warnings {
        push_fact(2, label(note), &format!("{note} ({})", note.code), &mut text);
    }
    let next = match (doubts, robot.calibrated) {
        (1.., _) => "resolve the doubts: until then no verdict is better than uncertain",
        (0, false) => "measure natural frequencies at ten poses or more, then run detune diagnose",
        (0, true) => "run detune check on your jobs",
    };
    push_fact(2, "next", next, &mut text);
    text
}

fn label(note: &Note) -> &'static str {
    if note.code.class() == Class::Doubt { "doubt" } else { "note" }
}

fn which(which: Which) -> &'static str {
    match which {
        Which::Zero => "zero",
        Which::Middle => "middle",
        Which::Softest => "softest",
        Which::Stiffest => "stiffest",
    }
}

fn joints(robot: &Examined, pose: &ExaminedPose) -> String {
    let one = |((name, slides), value): (&(String, bool), &f64)| match slides {
        true => format!("{name} {} mm", words::number(mm_from_m(*value), 0)),
        false => format!("{name} {}°", words::number(deg_from_rad(*value), 0)),
    };
    robot.joints.iter().zip(&pose.joints).map(one).collect::<Vec<_>>().join(", ")
}
