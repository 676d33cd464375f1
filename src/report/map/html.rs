//! A map as a page: frequencies over the pose, the shapes where they were asked for, the poses.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::plot::{abscissae, map_drawing, shape_plots};
use crate::map::{Block, Head, Reduced, Row};
use crate::report::json::NotFinite;
use crate::report::page::{self, Slider, Table, figure, text};
use crate::report::words::trimmed;
use crate::study::arm::{MovingArm, Surface};
use crate::units::deg_from_rad;

use super::reduced_plot::reduced_drawing;

/// More poses than this are not listed: some, evenly.
const MAX_ROWS: usize = 200;

/// The page of a map. `swept` is the joint (by place) that the poses sweep, if one does; `moving`
/// is the arm at some of the poses.
///
/// # Errors
/// If a number is not finite, which would be a fault of the program.
pub fn map_html(
    head: &Head,
    block: &Block,
    swept: Option<usize>,
    moving: &MovingArm,
) -> Result<String, NotFinite> {
    let is_nonlinear = block.rows().any(|row| row.nonlinear.is_some());
    let method = if is_nonlinear {
        "spectra of a free vibration, with the linear frequencies over them"
    } else {
        "natural frequencies"
    };
    let mut body = head_of(head, &format!("{} poses, {method}", block.count));
    let caption = if head.has_intervals {
        "Natural frequencies over the pose, with their 95 % intervals"
    } else if is_nonlinear {
        "Spectra of the free vibration over the pose"
    } else {
        "Natural frequencies over the pose"
    };
    body.push_str("<section data-job=\"0\">\n");
    body.push_str(&page::controls(&moving.arm, 0, Slider::Poses));
    body.push_str("<div data-operation=\"0\">\n");
    body.push_str(&figure(caption, &map_drawing(head, block, swept)));
    body.push_str("</div>\n</section>\n");
    let shapes = shape_plots(head, block, swept);
    if !shapes.is_empty() {
        body.push_str("<h2>Shapes</h2>\n");
    }
    for (caption, svg) in shapes {
        body.push_str(&figure(&caption, &svg));
    }
    body.push_str(&table(head, block));
    page::page(&title(head), &body, &data(head, block, swept, moving))
}

/// What the script of the page works with: as that of a job with one operation, but that its
/// places are poses, each with where it stands in the plot.
fn data(head: &Head, block: &Block, swept: Option<usize>, moving: &MovingArm) -> Value {
    let abscissae = abscissae(head, block, swept);
    let places = moving.places.iter().flatten().map(|place| {
        let mut value = json!(place);
        value["abscissa"] = json!(abscissae.get(place.line.saturating_sub(1)));
        value
    });
    let places: Vec<Value> = places.collect();
    let surfaces: BTreeMap<&str, &Surface> =
        moving.surfaces.iter().map(|surface| (surface.key.as_str(), &**surface)).collect();
    json!({
        "schema": "report/1",
        "jobs": [{
            "name": head.robot,
            "arm": moving.arm,
            "start": 0,
            "poses": block.count,
            "operations": [{ "name": head.robot, "mode": 1, "places": places }],
        }],
        "surfaces": surfaces,
    })
}

/// The page of the statistics of a map.
///
/// # Errors
/// As [`map_html`].
pub fn reduced_html(head: &Head, reduced: &Reduced) -> Result<String, NotFinite> {
    let mut body = head_of(head, &format!("{} poses", reduced.poses));
    let caption = "How often each mode is where, with its median and quantiles";
    body.push_str(&figure(caption, &reduced_drawing(head, reduced)));
    page::page(&title(head), &body, &json!({ "jobs": [] }))
}

fn title(head: &Head) -> String {
    format!("Map of {}", head.robot)
}

fn head_of(head: &Head, what: &str) -> String {
    format!("<header><h1>{}</h1>\n<p>{}</p></header>\n", text(&title(head)), text(what))
}

/// The poses with their frequencies.
fn table(head: &Head, block: &Block) -> String {
    let mut columns: Vec<(String, bool)> = head
        .joints
        .iter()
        .map(|joint| format!("{} {}", joint.name, if joint.turns { "°" } else { "m" }))
        .map(|name| (name, false))
        .collect();
    if head.has_beta2 {
        columns.push(("β2 °".to_owned(), false));
    }
    for mode in 1..=head.coordinates.len() {
        columns.push((format!("f{mode} Hz"), false));
        if head.has_intervals {
            columns.extend([(format!("f{mode} from"), false), (format!("f{mode} to"), false)]);
        }
    }
    let columns: Vec<(&str, bool)> = columns.iter().map(|(name, w)| (name.as_str(), *w)).collect();
    let mut table = Table::new("map", &columns);
    let step = block.count.div_ceil(MAX_ROWS).max(1);
    block.rows().step_by(step).for_each(|row| table.row(&cells(head, &row)));
    let which = if step == 1 {
        "Poses".to_owned()
    } else {
        format!("Poses: each {step}th of {}; CSV and JSON have all", block.count)
    };
    format!("<h2>{which}</h2>\n{}", table.finish())
}

fn cells(head: &Head, row: &Row) -> Vec<(String, Option<f64>)> {
    let shown = |value: f64, decimals: usize| match value.is_finite() {
        true => (trimmed(value, decimals), Some(value)),
        false => ("–".to_owned(), None),
    };
    let joint = |(q, joint): (&f64, &crate::map::JointColumn)| {
        if joint.turns { shown(deg_from_rad(*q), 2) } else { shown(*q, 4) }
    };
    let mut cells: Vec<(String, Option<f64>)> =
        row.joints.iter().zip(&head.joints).map(joint).collect();
    cells.extend(row.beta2_rad.first().map(|angle| shown(deg_from_rad(*angle), 2)));
    for (mode, hz) in row.frequencies_hz.iter().enumerate() {
        cells.push(shown(*hz, 2));
        let ends = row.intervals_hz.get(2 * mode..2 * mode + 2).unwrap_or_default();
        cells.extend(ends.iter().map(|end| shown(*end, 2)));
    }
    cells
}
