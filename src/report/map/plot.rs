//! A map as a picture: natural frequencies over the pose (the paper's Fig. 3), and the spectra of a
//! nonlinear free vibration as heat maps with the linear frequencies over them (Fig. 5).

use crate::map::{Block, Head, Row};
use crate::report::svg::{Anchor, Axis, Frame, Panel, Sheet, Stroke, curve_style, heat};
use crate::units::deg_from_rad;

/// Frequencies that differ by more than this factor are drawn on a logarithmic scale.
const LINEAR_UP_TO: f64 = 8.0;

/// Cells of a heat map from bottom to top.
const CELLS: usize = 220;

/// What is drawn black in a heat map, dB below the panel's peak.
const FLOOR_DB: f64 = 60.0;

/// Shades of a heat map.
const SHADES: f64 = 48.0;

/// The linear frequencies over a heat map.
const LINEAR_MODES: Stroke = Stroke { colour: "#00e5ff", width: 1.4, dashes: "7 5" };

pub(super) const TITLE: &str = "font-size=\"16\" font-weight=\"bold\"";
pub(super) const PANEL_TITLE: &str = "font-size=\"14\" font-weight=\"bold\"";

/// Draws a map. `swept` is the joint (by place) that the poses sweep, if one does; poses from a
/// list are drawn as points over β2 or, without it, over their number.
pub fn map_svg(head: &Head, block: &Block, swept: Option<usize>) -> String {
    let rows: Vec<Row> = block.rows().collect();
    let rows = &rows[..];
    let abscissa = Abscissa::new(head, rows, swept);
    if rows.iter().any(|row| row.nonlinear.is_some()) {
        heat_maps(head, rows, &abscissa)
    } else {
        curves(head, rows, &abscissa)
    }
}

/// What is laid off to the right.
struct Abscissa {
    axis: Axis,
    values: Vec<f64>,
    /// Rows by ascending value.
    order: Vec<usize>,
    /// Whether neighbours belong together, so that a line may join them.
    is_continuous: bool,
}

impl Abscissa {
    fn new(head: &Head, rows: &[Row], swept: Option<usize>) -> Self {
        let varies = |values: &[f64]| values.iter().any(|v| Some(v) != values.first());
        let beta2: Option<Vec<f64>> =
            rows.iter().map(|row| row.beta2_rad.first().copied()).collect();
        let beta2 = beta2.filter(|values| varies(values));
        let (label, values) =
            match (beta2, swept.and_then(|joint| Some((joint, head.joints.get(joint)?)))) {
                (Some(values), _) => {
                    ("β2 [°]".to_owned(), values.iter().map(|v| deg_from_rad(*v)).collect())
                }
                (None, Some((index, joint))) => {
                    let scale = |v: f64| if joint.turns { deg_from_rad(v) } else { v };
                    let unit = if joint.turns { "°" } else { "m" };
                    let values = rows.iter().map(|row| scale(row.joints[index])).collect();
                    (format!("{} [{unit}]", joint.name), values)
                }
                (None, None) => ("pose".to_owned(), (1..=rows.len()).map(|i| i as f64).collect()),
            };
        let values: Vec<f64> = values;
        let (mut low, mut high) = bounds(values.iter().copied());
        if low >= high {
            (low, high) = (low - 0.5, high + 0.5);
        }
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let axis = Axis { label, low, high, is_logarithmic: false };
        Self { axis, values, order, is_continuous: swept.is_some() }
    }
}

fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// Hz for all of `values`, with room above and below.
fn frequency_axis(values: impl Iterator<Item = f64>, most: f64) -> Axis {
    let (low, high) = bounds(values);
    let (low, high) = if low <= high { (low, high) } else { (1.0, 10.0) };
    let is_logarithmic = high > LINEAR_UP_TO * low;
    let (low, high) = if is_logarithmic { (low / 1.25, high * 1.25) } else { (0.0, high * 1.12) };
    Axis { label: "frequency [Hz]".into(), low, high: high.min(most), is_logarithmic }
}

fn curves(head: &Head, rows: &[Row], abscissa: &Abscissa) -> String {
    let (width, height) = (860.0, 520.0);
    let mut sheet = Sheet::new(width, height);
    let frame = Frame { left: 80.0, top: 50.0, width: width - 160.0, height: height - 115.0 };
    let all = rows.iter().flat_map(|row| row.frequencies_hz.iter().copied());
    let y = frequency_axis(all, f64::INFINITY);
    let panel = Panel { frame, x: abscissa.axis.clone(), y };
    let title = format!("Natural frequencies: {}", head.robot);
    sheet.text(frame.left, 30.0, Anchor::Start, TITLE, &title);
    sheet.axes(&panel, true);
    let mut labels = Vec::new();
    for mode in 0..head.coordinates.len() {
        let (colour, dashes) = curve_style(mode);
        let points: Vec<(f64, f64)> = abscissa
            .order
            .iter()
            .map(|&i| (abscissa.values[i], rows[i].frequencies_hz[mode]))
            .collect();
        if abscissa.is_continuous && points.len() > 1 {
            sheet.curve(&panel, &points, Stroke { colour, width: 2.2, dashes });
        } else {
            points.iter().for_each(|&(x, f)| sheet.dot(&panel, x, f, 3.5, colour));
        }
        if let Some(&(_, f)) = points.last() {
            labels.push((panel.py(f) + 4.5, colour, format!("f{}", mode + 1)));
        }
    }
    sheet.border(frame);
    for (y, colour, text) in spread(labels) {
        let style = format!("font-weight=\"bold\" style=\"fill:{colour}\"");
        sheet.text(frame.left + frame.width + 9.0, y, Anchor::Start, &style, &text);
    }
    sheet.finish()
}

/// Moves labels apart that would lie on each other: from the lowest on the sheet upwards.
fn spread(mut labels: Vec<(f64, &str, String)>) -> Vec<(f64, &str, String)> {
    labels.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut last = f64::INFINITY;
    for label in &mut labels {
        label.0 = label.0.min(last - 15.0);
        last = label.0;
    }
    labels
}

fn heat_maps(head: &Head, rows: &[Row], abscissa: &Abscissa) -> String {
    let count = head.coordinates.len();
    let columns = count.clamp(1, 2);
    let lines = count.div_ceil(columns);
    let (cell_width, cell_height, margin) = (560.0, 400.0, 110.0);
    let width = columns as f64 * cell_width + margin;
    let mut sheet = Sheet::new(width, lines as f64 * cell_height + 60.0);
    let title = format!("Free vibration spectra: {}", head.robot);
    sheet.text(75.0, 30.0, Anchor::Start, TITLE, &title);
    let note = "dashed: linear natural frequencies";
    sheet.text(width - margin, 30.0, Anchor::End, "", note);

    let most = rows
        .iter()
        .filter_map(|row| row.nonlinear)
        .map(|n| n.spectrum.bin_hz * n.spectrum.amplitudes.first().map_or(0, Vec::len) as f64)
        .fold(0.0, f64::max);
    let all = rows.iter().filter_map(|row| row.nonlinear).flat_map(|n| &n.linear_hz);
    let y = frequency_axis(all.copied(), most);
    for coordinate in 0..count {
        let frame = Frame {
            left: 75.0 + (coordinate % columns) as f64 * cell_width,
            top: 80.0 + (coordinate / columns) as f64 * cell_height,
            width: cell_width - 90.0,
            height: cell_height - 95.0,
        };
        let panel = Panel { frame, x: abscissa.axis.clone(), y: y.clone() };
        let title = format!("Coordinate {}: {}", coordinate + 1, head.coordinates[coordinate]);
        sheet.text(frame.left, frame.top - 10.0, Anchor::Start, PANEL_TITLE, &title);
        cells(&mut sheet, &panel, rows, abscissa, coordinate);
        sheet.axes(&panel, false);
        for mode in 0..count {
            let points: Vec<(f64, f64)> = abscissa
                .order
                .iter()
                .filter_map(|&i| {
                    let linear = *rows[i].nonlinear?.linear_hz.get(mode)?;
                    Some((abscissa.values[i], linear))
                })
                .collect();
            sheet.curve(&panel, &points, LINEAR_MODES);
        }
        sheet.border(frame);
    }
    let bar = Frame { left: width - margin + 25.0, top: 80.0, width: 18.0, height: 305.0 };
    colour_bar(&mut sheet, bar);
    sheet.finish()
}

/// The spectra of one coordinate, a column of cells for each pose.
fn cells(sheet: &mut Sheet, panel: &Panel, rows: &[Row], abscissa: &Abscissa, coordinate: usize) {
    sheet.rect(panel.frame, &heat(0.0));
    let spectrum = |i: usize| {
        let nonlinear = rows[i].nonlinear?;
        Some((nonlinear.spectrum.bin_hz, nonlinear.spectrum.amplitudes.get(coordinate)?))
    };
    let peak = (0..rows.len())
        .filter_map(spectrum)
        .flat_map(|(_, amplitudes)| amplitudes.iter().copied())
        .fold(0.0, f64::max);
    let edge = |place: usize| {
        // Halfway to the neighbour.
        let at = |place: usize| abscissa.values[abscissa.order[place]];
        match place {
            0 => abscissa.axis.low,
            place if place == abscissa.order.len() => abscissa.axis.high,
            place => 0.5 * (at(place - 1) + at(place)),
        }
    };
    for (place, &row) in abscissa.order.iter().enumerate() {
        let Some((bin_hz, amplitudes)) = spectrum(row) else { continue };
        let (left, right) = (panel.px(edge(place)), panel.px(edge(place + 1)));
        let shades: Vec<u32> = (0..CELLS)
            .map(|cell| {
                let low = panel.y.value(cell as f64 / CELLS as f64);
                let high = panel.y.value((cell + 1) as f64 / CELLS as f64);
                let level = loudest(amplitudes, low / bin_hz, high / bin_hz) / peak;
                let share = 1.0 + 20.0 * level.log10() / FLOOR_DB;
                (share.clamp(0.0, 1.0) * SHADES).round() as u32
            })
            .collect();
        let step = panel.frame.height / CELLS as f64;
        let mut from = 0;
        while from < CELLS {
            let run = shades[from..].iter().take_while(|s| **s == shades[from]).count();
            if shades[from] > 0 {
                let frame = Frame {
                    left,
                    top: panel.frame.top + panel.frame.height - (from + run) as f64 * step,
                    // A hair more than the cell, so that no background shines through.
                    width: (right - left + 0.3).min(panel.frame.left + panel.frame.width - left),
                    height: run as f64 * step,
                };
                sheet.rect(frame, &heat(f64::from(shades[from]) / SHADES));
            }
            from += run;
        }
    }
}

/// The loudest line between two places on the scale of lines, or the interpolation at the middle
/// where no line lies between.
fn loudest(amplitudes: &[f64], low: f64, high: f64) -> f64 {
    let (first, last) = (low.ceil() as usize, high.floor() as usize);
    if first <= last {
        let within = amplitudes.iter().skip(first).take(last - first + 1);
        return within.fold(0.0, |a: f64, &b| a.max(b));
    }
    let middle = 0.5 * (low + high);
    let part = middle.fract();
    let at = |i: usize| amplitudes.get(i).copied().unwrap_or(0.0);
    (1.0 - part) * at(middle as usize) + part * at(middle as usize + 1)
}

fn colour_bar(sheet: &mut Sheet, frame: Frame) {
    let steps = SHADES as usize;
    let step = frame.height / SHADES;
    for i in 0..steps {
        let top = frame.top + frame.height - (i + 1) as f64 * step;
        let share = (i as f64 + 0.5) / SHADES;
        sheet.rect(Frame { top, height: step + 0.3, ..frame }, &heat(share));
    }
    sheet.border(frame);
    let right = frame.left + frame.width + 5.0;
    for part in 0..=3 {
        let share = f64::from(part) / 3.0;
        let y = frame.top + frame.height * (1.0 - share) + 4.5;
        let db = (FLOOR_DB * (share - 1.0)).round();
        let text = if db == 0.0 { "0 dB".to_owned() } else { format!("−{}", -db) };
        sheet.text(right, y, Anchor::Start, "", &text);
    }
}
