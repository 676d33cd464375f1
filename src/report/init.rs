//! What was written for a new robot, and what in it is a guess.

use std::path::Path;

use crate::report::layout::push_fact;
use crate::report::words;
use crate::study::check::CheckedJob;
use crate::study::init::NewRobot;

/// The files, the guesses, the first verdict and what to do next.
pub fn report(written: &[&Path], guessed: &NewRobot, jobs: &[CheckedJob]) -> String {
    let mut text = String::new();
    for file in written {
        text.push_str(&format!("written  {}\n", words::path(file)));
    }
    text.push('\n');
    for alike in guessed.springs.chunk_by(|a, b| a.is_same_guess(b)) {
        let [spring, ..] = alike else { continue };
        let joints: Vec<&str> = alike.iter().map(|spring| spring.joint.as_str()).collect();
        let (joints, k, std) = (joints.join(", "), spring.stiffness, spring.std_percent);
        let fact = format!("{joints}: {k} N·m/rad ± {std} %; {}", spring.source);
        push_fact(0, "guessed", &fact, &mut text);
    }
    for joint in &guessed.sliding {
        push_fact(0, "rigid", &format!("{joint} slides: no typical figure is known"), &mut text);
    }
    for joint in &guessed.massless {
        push_fact(0, "rigid", &format!("{joint}: nothing behind it has a mass"), &mut text);
    }
    match &guessed.arm_angles {
        Some([(one, ..), (two, ..)]) => {
            let fact = format!("arm angles: beta1 from {one}, beta2 from {two}; check the signs");
            push_fact(0, "guessed", &fact, &mut text);
        }
        None => push_fact(0, "left out", "arm angles: no two level, parallel axes", &mut text),
    }
    for job in jobs {
        let verdict = words::spelled(job.risk.verdict);
        push_fact(0, "check", &format!("{}: {verdict}", words::path(&job.file)), &mut text);
    }
    let next = "enter tool, payload, spindle and path in the job, and your springs in robot.yaml; \
                detune doctor shows the frequencies, detune check the verdict";
    push_fact(0, "next", next, &mut text);
    text
}
