//! The table that `identify` reads, and one of what was seen in each frame.

use std::fmt::Write;

use crate::report::words::{number, trimmed};
use crate::study::trace::{Traced, TracedMark};
use crate::units::{mm_from_m, ms_from_s, percent_from_ratio, um_from_m};
use crate::wording::printable;

/// A box of which less moves with its mark is worth a word.
const MOVING: f64 = 0.9;

/// Times and displacements, with what is known of them as comments.
pub fn traces_csv(traced: &Traced) -> String {
    let mut out = String::new();
    let [width, height] = traced.size_px;
    let _ = writeln!(
        out,
        "# {} frames of {width} × {height} px, {} frames/s, {} mm/px; displacement from the first \
         frame, x to the right, y up",
        traced.frame_times_s.len(),
        trimmed(traced.rate_hz, 6),
        number(mm_from_m(traced.m_per_px), 5),
    );
    if let Some(found) = &traced.interpolation {
        let _ = writeln!(
            out,
            "# interpolated to even times from when the row of each mark was read (readout {} ms); \
             error at most {} % of the amplitude below {} Hz",
            trimmed(ms_from_s(traced.readout_s), 6),
            number(percent_from_ratio(found.error), 2),
            number(found.below_hz, 3),
        );
    }
    traced.marks.iter().for_each(|mark| comment(&mut out, mark));
    out.push_str("time_s");
    for mark in &traced.marks {
        let _ = write!(out, ",{0}_x_mm,{0}_y_mm", mark.name);
    }
    out.push('\n');
    for (row, time) in traced.times_s.iter().enumerate() {
        let _ = write!(out, "{time:.9}");
        for mark in &traced.marks {
            match mark.displacements_m.get(row).copied().flatten() {
                Some(moved) => {
                    let [x, y] = moved.map(mm_from_m);
                    let _ = write!(out, ",{x:.6},{y:.6}");
                }
                None => out.push_str(",,"),
            }
        }
        out.push('\n');
    }
    out
}

fn comment(out: &mut String, mark: &TracedMark) {
    let [x, y] = mark.at_m.map(mm_from_m);
    let _ = write!(out, "# {}: at_mm: [{x:.3}, {y:.3}]", printable(&mark.name));
    if let Some(deviation) = mark.deviation_m {
        let [x, y] = deviation.map(|m| number(um_from_m(m), 1));
        let _ = write!(out, "; ± {x} and {y} µm a frame");
    }
    if mark.moving < MOVING {
        let still = number(percent_from_ratio(1.0 - mark.moving), 2);
        let _ = write!(out, "; {still} % of its box does not move with it");
    }
    for (index, [from, to]) in mark.lost.iter().enumerate() {
        let head = if index == 0 { "; lost in frames " } else { ", " };
        let _ = write!(out, "{head}{from}");
        if to > from {
            let _ = write!(out, "-{to}");
        }
    }
    out.push('\n');
}

/// For each frame when and where marks were seen, px, with their standard deviations.
pub fn frames_csv(traced: &Traced) -> String {
    let mut out = String::from("frame,time_s");
    for mark in &traced.marks {
        let name = &mark.name;
        let _ = write!(out, ",{name}_time_s,{name}_x_px,{name}_y_px");
        let _ = write!(out, ",{name}_x_std_px,{name}_y_std_px");
    }
    out.push('\n');
    for (frame, time) in traced.frame_times_s.iter().enumerate() {
        let _ = write!(out, "{},{time:.9}", frame + 1);
        for mark in &traced.marks {
            let seen = mark.seen_s.get(frame).copied().flatten();
            match seen.zip(mark.positions.get(frame).copied().flatten()) {
                Some((seen, position)) => {
                    let ([x, y], [dx, dy]) = (position.at, position.deviation);
                    let _ = write!(out, ",{seen:.9},{x:.5},{y:.5},{dx:.5},{dy:.5}");
                }
                None => out.push_str(",,,,,"),
            }
        }
        out.push('\n');
    }
    out
}
