//! How an operation cuts: what its keys lack, and what a drill was measured at.

use super::super::raw::job as raw;
use super::Reader;
use super::cutter::{
    coefficients, direction, drill_fault, needs_width, process_damping_n_per_m, undamped,
    undamped_without_diameter, unused_key,
};
use crate::formats::yaml::{Node, Step};
use crate::job::{Cutting, CuttingDirection, Drill, MeasuredAt, Operation, SpindleSpeed, Tool};
use crate::notes::Code;
use crate::units::{m_from_mm, mm_from_m};

impl Reader<'_> {
    /// All but a slot and a drill have a width, all but a drill a depth, and forces come from a
    /// material or from coefficients, or the thrust of a drill is given.
    pub(super) fn check_cutting(&mut self, raw: &raw::Operation, node: &Node, called: &str) {
        let Some(cutting) = &raw.cutting else { return };
        let line = node.line_at(&[Step::Key("cutting")]);
        // What is there and wrong was told.
        let lacks = |key| node.at(&[Step::Key("cutting"), Step::Key(key)]).is_none();
        let drills = matches!(cutting.direction, Some(raw::Direction::Drill));
        for (key, is_needed) in [
            ("radial_depth_mm", cutting.direction.is_none_or(needs_width)),
            ("axial_depth_mm", !drills),
        ] {
            if lacks(key) && is_needed {
                let what = format!("{called}: cutting: missing key '{key}'");
                self.notes.error(Code::MissingKey, line, what);
            }
        }
        if lacks("material") && lacks("coefficients") && (lacks("thrust_n") || !drills) {
            let what = match drills {
                true => "has none of 'material', 'coefficients' and 'thrust_n'",
                false => "has neither 'material' nor 'coefficients'",
            };
            let what = format!("{called}: cutting {what}, must have one");
            self.notes.error(Code::MissingKey, line, what);
        }
        let regenerates = cutting.regeneration.unwrap_or(true);
        let named = cutting.direction;
        if let Some(what) =
            named.and_then(|named| undamped(cutting.process_damping_n_per_mm, named, regenerates))
        {
            let at = [Step::Key("cutting"), Step::Key("process_damping_n_per_mm")];
            let what = format!("{called}: cutting.{what}");
            self.notes.warning(Code::Unused, node.line_at(&at), what);
        }
        let of_drill = ["pilot_diameter_mm", MEASURED[0], MEASURED[1], "measured_at_mm_per_rev"];
        let of_drill = of_drill.map(|key| (key, !drills));
        let of_mill = ["radial_depth_mm", "axial_depth_mm"].map(|key| (key, drills));
        for (key, is_unused) in of_drill.into_iter().chain(of_mill) {
            if is_unused && !lacks(key) {
                let what = format!("{called}: {}", unused_key(key, drills));
                let line = node.line_at(&[Step::Key("cutting"), Step::Key(key)]);
                self.notes.warning(Code::Unused, line, what);
            }
        }
        if drills && MEASURED.into_iter().all(lacks) && !lacks("measured_at_mm_per_rev") {
            let at = [Step::Key("cutting"), Step::Key("measured_at_mm_per_rev")];
            let what = "cutting.measured_at_mm_per_rev has no effect without thrust_n or torque_nm";
            self.notes.warning(Code::Unused, node.line_at(&at), format!("{called}: {what}"));
        }
    }

    /// What was measured of a drill says nothing of another one.
    pub(super) fn check_measured_of_one(
        &mut self,
        stretches: &[Operation],
        cutting: Option<&raw::Cutting>,
        node: &Node,
        called: &str,
    ) {
        let mut cutters = stretches.iter().map(|each| &each.tool);
        let first = cutters.next();
        let keys = MEASURED.map(|key| [Step::Key("cutting"), Step::Key(key)]);
        let raw = cutting.map(|cutting| [cutting.thrust_n, cutting.torque_nm]);
        let stated = keys.iter().zip(raw.into_iter().flatten()).find(|(_, value)| value.is_some());
        let drills =
            |each: &Operation| each.cutting.as_ref().is_some_and(|cut| cut.drill().is_some());
        if let Some((at, _)) = stated.filter(|_| stretches.iter().any(drills))
            && cutters.any(|other| Some(other) != first)
        {
            let what = format!(
                "{called}: cutting.{} was measured with one drill, but the program changes the \
                 cutter; give cutting.material or coefficients, or divide the program",
                if at == &keys[0] { MEASURED[0] } else { MEASURED[1] }
            );
            self.notes.error(Code::Conflict, node.line_at(at), what);
        }
    }

    /// A cutter cannot cut wider than it is, and a drill is wider than the hole before it.
    pub(super) fn check_diameter(
        &mut self,
        raw: &raw::Operation,
        node: &Node,
        called: &str,
        whose: &str,
        tool: &Tool,
    ) {
        let Some(cutting) = &raw.cutting else { return };
        let Some(named) = cutting.direction else { return };
        let fault = drill_fault(named, cutting.pilot_diameter_mm, whose, tool);
        if let Some((key, code, what)) = fault {
            let line = node.line_at(&[Step::Key("cutting"), Step::Key(key)]);
            self.notes.error(code, line, format!("{called}: {what}"));
        }
        let damping = cutting.process_damping_n_per_mm;
        if let Some(what) = undamped_without_diameter(damping, whose, tool) {
            let at = [Step::Key("cutting"), Step::Key("process_damping_n_per_mm")];
            self.notes.error(Code::MissingKey, node.line_at(&at), format!("{called}: {what}"));
        }
        let drills = matches!(named, raw::Direction::Drill);
        let depth_mm = cutting.radial_depth_mm.filter(|_| !drills);
        let (Some(depth_mm), Some(diameter_m)) = (depth_mm, tool.diameter_m) else { return };
        if m_from_mm(depth_mm) > diameter_m {
            let line = node.line_at(&[Step::Key("cutting"), Step::Key("radial_depth_mm")]);
            let what = format!(
                "{called}: cutting.radial_depth_mm is {depth_mm}, must not be above \
                    {whose}.diameter_mm, {}",
                mm_from_m(diameter_m)
            );
            self.notes.error(Code::Value, line, what);
        }
    }
}

pub(super) fn cutting(raw: &raw::Cutting) -> Option<Cutting> {
    let named = raw.direction?;
    let drills = matches!(named, raw::Direction::Drill);
    let depth_m = |mm: Option<f64>| mm.filter(|_| !drills).map(m_from_mm);
    let drill = Drill {
        pilot_diameter_m: raw.pilot_diameter_mm.map_or(0.0, m_from_mm),
        thrust_n: raw.thrust_n,
        torque_nm: raw.torque_nm,
        measured_at: raw.measured_at_mm_per_rev.map(m_from_mm).map(MeasuredAt::Stated),
    };
    Some(Cutting {
        radial_depth_m: depth_m(raw.radial_depth_mm).unwrap_or(0.0),
        axial_depth_m: depth_m(raw.axial_depth_mm).or(drills.then_some(0.0))?,
        direction: direction(named, drill),
        material: raw.material.clone().unwrap_or_default(),
        coefficients: match &raw.coefficients {
            Some(own) => Some(coefficients(own)?),
            None => None,
        },
        regenerates: raw.regeneration.unwrap_or(true),
        process_damping_n_per_m: process_damping_n_per_m(raw.process_damping_n_per_mm, named),
    })
}

/// The keys of what somebody measured of a drill.
const MEASURED: [&str; 2] = ["thrust_n", "torque_nm"];

/// Gives the stretches of an operation the feed at which thrust and torque were measured where
/// nobody says it: the least per revolution of theirs and of what the job says, so that none has a
/// thicker chip without its being known.
pub(super) fn with_measured_feed(
    stretches: &mut [Operation],
    (speed, feed_of_job_m_per_s): (Option<&SpindleSpeed>, Option<f64>),
) {
    let per_rev = |each: &Operation| {
        let feed_m_per_s = each.least_feed_m_per_s();
        let feed_m_per_s = feed_of_job_m_per_s.map_or(feed_m_per_s, |own| own.min(feed_m_per_s));
        let speeds = [Some(&each.speed), speed].into_iter().flatten();
        speeds.map(|speed| speed.feed_m_per_rev(feed_m_per_s)).fold(f64::INFINITY, f64::min)
    };
    let least = stretches.iter().map(per_rev).reduce(f64::min).map(MeasuredAt::Programmed);
    let cuts = stretches.iter_mut().filter_map(|each| each.cutting.as_mut());
    for cutting in cuts {
        if let CuttingDirection::Drill(drill) = &mut cutting.direction {
            drill.measured_at = drill.measured_at.or(least);
        }
    }
}
