//! What the cut does at the tool tip, in words.

use crate::process::{Chatter, Seen};
use crate::report::words;
use crate::risk::{Drilling, OperationRisk, ToolTip};
use crate::units::{deg_from_rad, mm_from_m, percent_from_ratio, um_from_m};

/// Labels and sentences on the tool tip and on stability; none where the cut is not known.
pub(in crate::report) fn facts(risk: &OperationRisk) -> Vec<(&'static str, String)> {
    let tip = risk.tool_tip.as_ref().map(|tip| ("cut", of_tip(tip)));
    let stability = risk.stability.as_ref().map(|chatter| ("chatter", of_chatter(chatter)));
    tip.into_iter().chain(stability).collect()
}

/// Three digits.
fn um(m: f64) -> String {
    match um_from_m(m) {
        um if um < 99.95 => format!("{um:.1} µm"),
        um if um < 999.5 => format!("{um:.0} µm"),
        um if um < 9_995.0 => format!("{:.2} mm", mm_from_m(m)),
        um if um < 99_950.0 => format!("{:.1} mm", mm_from_m(m)),
        _ => format!("{:.0} mm", mm_from_m(m)),
    }
}

/// `319 N`, `4.25 N`.
fn newtons(n: f64) -> String {
    if n < 100.0 { format!("{n:.1} N") } else { format!("{n:.0} N") }
}

fn of_drilling(drilling: &Drilling) -> String {
    let torque = match drilling.torque_nm {
        Some(torque_nm) => format!("; torque {torque_nm:.2} N m"),
        None => "; torque not known, left out".to_owned(),
    };
    let at_least = match drilling.is_lower_bound {
        true => ", a lower bound without the chisel edge",
        false => "",
    };
    let point = match drilling.is_point_angle_assumed {
        true => {
            format!("; point angle {:.0}° assumed", 2.0 * deg_from_rad(drilling.half_point_rad))
        }
        false => String::new(),
    };
    format!(
        "to the side {} at {} %; thrust {} (perhaps {}){at_least}{torque}{point}",
        um(drilling.skid_m),
        words::trimmed(percent_from_ratio(drilling.skid_s), 1),
        newtons(drilling.thrust_n),
        newtons(drilling.thrust_up_to_n),
    )
}

fn of_tip(tip: &ToolTip) -> String {
    let at = |s: f64| format!("at {} %", words::trimmed(percent_from_ratio(s), 1));
    let surface = tip.surface_error.map(|surface| {
        let side = if surface.error_m < 0.0 { "too much" } else { "left" };
        format!("on the surface {} {side} {}", um(surface.error_m.abs()), at(surface.s))
    });
    let vibrates = match tip.harmonics.is_empty() {
        true => "nothing in the force makes it vibrate".to_owned(),
        false => format!(
            "it vibrates by {} {} (perhaps {})",
            um(tip.vibration.largest_m),
            at(tip.vibration.s),
            um(tip.vibration.up_to_m),
        ),
    };
    let of_drill = tip.drilling.as_ref().map(of_drilling);
    let further: Vec<String> = surface.into_iter().chain(of_drill).collect();
    let further = further.join("; ");
    let whose = match tip.modes {
        Seen::Arm => "; the arm alone (no tool.modes)",
        Seen::ArmAndTool => "",
    };
    format!(
        "the mean force moves the tool tip {} {} (perhaps {}); {vibrates}; {further}{whose}",
        um(tip.deflection.largest_m),
        at(tip.deflection.s),
        um(tip.deflection.up_to_m),
    )
}

fn of_chatter(chatter: &Chatter) -> String {
    let limit_of = chatter.limit_of.short_name();
    let depth = words::trimmed(mm_from_m(chatter.depth_m), 3);
    let whose = match chatter.modes {
        Seen::Arm => {
            "; the arm's modes alone (no tool.modes): at milling speeds the tool chatters first"
        }
        Seen::ArmAndTool => "",
    };
    let found = chatter.smallest.and_then(|at| Some((at, at.depth_m?, at.frequency_hz?, at.kind?)));
    let Some((at, limit_m, frequency_hz, kind)) = found else {
        return format!("no limit found below 1 m of {limit_of} at the programmed speed{whose}");
    };
    let mode = match at.mode {
        Some(mode) => format!("mode {mode}"),
        None => "a mode of the tool".to_owned(),
    };
    let cut = match chatter {
        Chatter { is_beyond: true, .. } => "is beyond it",
        Chatter { may_be_beyond: true, .. } => "may be beyond it",
        _ => "is below it",
    };
    let [low, high] = chatter.smallest_ci95_m.map(|end| {
        end.map_or_else(|| "1000".to_owned(), |end_m| format!("{:.3}", mm_from_m(end_m)))
    });
    format!(
        "from {:.3} mm of {limit_of} ({low} to {high} by the model's uncertainty) at {} % ({mode}, \
         {} Hz, {}); the cut of {depth} mm {cut}{whose}",
        mm_from_m(limit_m),
        words::trimmed(percent_from_ratio(at.s), 1),
        words::hz(frequency_hz),
        words::spelled(kind),
    )
}
