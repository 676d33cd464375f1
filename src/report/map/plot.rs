//! A map as a picture: natural frequencies over the pose (the paper's Fig. 3), and the spectra of a
//! nonlinear free vibration as heat maps with the linear frequencies over them (Fig. 5).

use crate::map::{Block, Head, ModeShape, Row};
use crate::report::Plot;
use crate::report::drawing::{
    Anchor, Axis, Canvas, Entry, Face, Frame, Label, Panel, Scale, Stroke, Swatch, bounds,
    curve_style, heat, labels_beside, row,
};
use crate::units::deg_from_rad;

/// Frequencies that differ by more than this factor are drawn on a logarithmic scale.
const MAX_LINEAR_RATIO: f64 = 8.0;

/// How strong the colour of an interval is.
const INTERVAL_OPACITY: f64 = 0.18;

/// Cells of a heat map from bottom to top.
const CELLS: usize = 220;

/// What is drawn black in a heat map, dB below the panel's peak.
const FLOOR_DB: f64 = 60.0;

/// Shades of a heat map.
const SHADES: f64 = 48.0;

/// The linear frequencies over a heat map.
const LINEAR_MODES: Stroke = Stroke { colour: "#00e5ff", width: 1.4, dashes: "7 5" };

/// Draws a map. `swept` is the joint (by place) that the poses sweep, if one does; poses from a
/// list are drawn as points over β2 or, without it, over their number.
pub fn map_drawing(head: &Head, block: &Block, swept: Option<usize>) -> Canvas {
    let rows: Vec<Row> = block.rows().collect();
    let rows = &rows[..];
    let abscissa = Abscissa::new(head, rows, swept);
    if rows.iter().any(|row| row.nonlinear.is_some()) {
        heat_maps(head, rows, &abscissa)
    } else {
        curves(head, rows, &abscissa)
    }
}

/// What the plot lays off to the right, pose by pose.
pub(super) fn abscissae(head: &Head, block: &Block, swept: Option<usize>) -> Vec<f64> {
    let rows: Vec<Row> = block.rows().collect();
    Abscissa::new(head, &rows, swept).values
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
        let (low, high) = bounds(values.iter().copied());
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let axis = Axis::new(label, Scale::linear(low, high));
        Self { axis, values, order, is_continuous: swept.is_some() }
    }
}

/// Hz for all of `values`, with room above and below.
fn frequency_axis(values: impl Iterator<Item = f64>, most: f64) -> Axis {
    let (low, high) = bounds(values);
    let (low, high) = if low <= high { (low, high) } else { (1.0, 10.0) };
    let is_logarithmic = high > MAX_LINEAR_RATIO * low;
    let scale = if is_logarithmic {
        Scale::logarithmic(low / 1.25, (high * 1.25).min(most))
    } else {
        Scale::linear(0.0, (high * 1.12).min(most))
    };
    Axis::new("frequency [Hz]", scale)
}

fn curves(head: &Head, rows: &[Row], abscissa: &Abscissa) -> Canvas {
    let (width, height) = (860.0, 520.0);
    let mut canvas = Canvas::new(width, height);
    let frame = Frame { left: 85.0, top: 50.0, width: width - 165.0, height: height - 115.0 };
    let all = rows.iter().flat_map(|row| row.frequencies_hz.iter().chain(row.intervals_hz));
    let all = all.copied();
    let y = frequency_axis(all, f64::INFINITY);
    let panel = Panel { frame, x: abscissa.axis.clone(), y };
    let title = format!("Natural frequencies: {}", head.robot);
    canvas.text((frame.left, 30.0), Anchor::Start, Face::Title, &title);
    panel.axes(&mut canvas, true);
    let mut labels = Vec::new();
    for mode in 0..head.coordinates.len() {
        let (colour, dashes) = curve_style(mode);
        let points: Vec<(f64, f64)> = abscissa
            .order
            .iter()
            .map(|&i| (abscissa.values[i], rows[i].frequencies_hz[mode]))
            .collect();
        let interval = |i: usize| rows[i].intervals_hz.get(2 * mode..2 * mode + 2);
        if abscissa.is_continuous && points.len() > 1 {
            let side = |side: usize| {
                let end = move |&i: &usize| Some((abscissa.values[i], interval(i)?[side]));
                abscissa.order.iter().filter_map(end).collect::<Vec<_>>()
            };
            let outline = side(1).into_iter().chain(side(0).into_iter().rev());
            panel.area(&mut canvas, outline, colour, INTERVAL_OPACITY);
            panel.curve(&mut canvas, &points, Stroke { colour, width: 2.2, dashes });
        } else {
            let bar = Stroke { colour, width: 1.2, dashes: "" };
            for &i in &abscissa.order {
                let ends = interval(i).unwrap_or_default().iter();
                let ends: Vec<(f64, f64)> = ends.map(|hz| (abscissa.values[i], *hz)).collect();
                panel.curve(&mut canvas, &ends, bar);
            }
            points.iter().for_each(|&point| panel.dot(&mut canvas, point, 3.5, colour));
        }
        if let Some(&(_, f)) = points.iter().rfind(|(_, f)| f.is_finite()) {
            labels.push(Label { at: f, colour, text: format!("mode {}", mode + 1) });
        }
    }
    canvas.border(frame);
    labels_beside(&mut canvas, &panel, &labels);
    panel.sense(&mut canvas, "data-along");
    canvas
}

/// The shape of each mode over the pose, where shapes were asked for: the amplitudes of the elastic
/// coordinates against the largest, each with a caption.
pub(super) fn shape_plots(head: &Head, block: &Block, swept: Option<usize>) -> Vec<Plot> {
    let rows: Vec<Row> = block.rows().collect();
    let abscissa = Abscissa::new(head, &rows, swept);
    let shapes: Vec<Vec<ModeShape>> = rows.iter().map(|row| row.mode_shapes().collect()).collect();
    if shapes.first().is_none_or(Vec::is_empty) {
        return Vec::new();
    }
    let one = |mode: usize| {
        let (width, height) = (980.0, 300.0);
        let mut canvas = Canvas::new(width, height);
        let frame = Frame { left: 85.0, top: 20.0, width: 690.0, height: height - 80.0 };
        let y = Axis::new("amplitude, the largest as 1", Scale::linear(-1.05, 1.05));
        let panel = Panel { frame, x: abscissa.axis.clone(), y };
        panel.axes(&mut canvas, true);
        let mut labels = Vec::new();
        for (coordinate, name) in head.coordinates.iter().enumerate() {
            let (colour, dashes) = curve_style(coordinate);
            let point = |&i: &usize| {
                let phi = shapes[i].get(mode)?.phi;
                let largest = phi.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                Some((abscissa.values[i], phi.get(coordinate)? / largest))
            };
            let points: Vec<(f64, f64)> = abscissa.order.iter().filter_map(point).collect();
            if abscissa.is_continuous && points.len() > 1 {
                panel.curve(&mut canvas, &points, Stroke { colour, width: 2.0, dashes });
            } else {
                points.iter().for_each(|&point| panel.dot(&mut canvas, point, 3.0, colour));
            }
            let last = points.iter().rfind(|(_, value)| value.is_finite());
            labels.extend(last.map(|&(_, at)| Label { at, colour, text: name.clone() }));
        }
        canvas.border(frame);
        labels_beside(&mut canvas, &panel, &labels);
        (format!("Mode {}: amplitudes of the elastic coordinates", mode + 1), canvas)
    };
    (0..head.coordinates.len()).map(one).collect()
}

fn heat_maps(head: &Head, rows: &[Row], abscissa: &Abscissa) -> Canvas {
    let count = head.coordinates.len();
    let columns = count.clamp(1, 2);
    let lines = count.div_ceil(columns);
    let (cell_width, cell_height, margin) = (560.0, 400.0, 110.0);
    let width = columns as f64 * cell_width + margin;
    let mut canvas = Canvas::new(width, lines as f64 * cell_height + 60.0);
    let title = format!("Free vibration spectra: {}", head.robot);
    canvas.text((85.0, 30.0), Anchor::Start, Face::Title, &title);
    let linear = Entry::new(Swatch::Line(LINEAR_MODES), "linear natural frequencies");
    row(&mut canvas, (width - margin, 52.0), &[linear]);

    let most = rows
        .iter()
        .filter_map(|row| row.nonlinear)
        .map(|n| n.spectrum.bin_hz * n.spectrum.amplitudes.first().map_or(0, Vec::len) as f64)
        .fold(0.0, f64::max);
    let all = rows.iter().filter_map(|row| row.nonlinear).flat_map(|n| &n.linear_hz);
    let y = frequency_axis(all.copied(), most);
    for coordinate in 0..count {
        let frame = Frame {
            left: 85.0 + (coordinate % columns) as f64 * cell_width,
            top: 80.0 + (coordinate / columns) as f64 * cell_height,
            width: cell_width - 90.0,
            height: cell_height - 95.0,
        };
        let panel = Panel { frame, x: abscissa.axis.clone(), y: y.clone() };
        let title = format!("Coordinate {}: {}", coordinate + 1, head.coordinates[coordinate]);
        panel.title(&mut canvas, &title);
        cells(&mut canvas, &panel, rows, abscissa, coordinate);
        panel.axes(&mut canvas, false);
        for mode in 0..count {
            let points: Vec<(f64, f64)> = abscissa
                .order
                .iter()
                .filter_map(|&i| {
                    let linear = *rows[i].nonlinear?.linear_hz.get(mode)?;
                    Some((abscissa.values[i], linear))
                })
                .collect();
            panel.curve(&mut canvas, &points, LINEAR_MODES);
        }
        canvas.border(frame);
    }
    let bar = Frame { left: width - margin + 25.0, top: 80.0, width: 18.0, height: 305.0 };
    colour_bar(&mut canvas, bar);
    canvas
}

/// The spectra of one coordinate, a column of cells for each pose.
fn cells(canvas: &mut Canvas, panel: &Panel, rows: &[Row], abscissa: &Abscissa, coordinate: usize) {
    canvas.rect(panel.frame, &heat(0.0), 1.0);
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
            0 => abscissa.axis.scale.low(),
            place if place == abscissa.order.len() => abscissa.axis.scale.high(),
            place => 0.5 * (at(place - 1) + at(place)),
        }
    };
    for (place, &row) in abscissa.order.iter().enumerate() {
        let Some((bin_hz, amplitudes)) = spectrum(row) else { continue };
        let (left, right) = (panel.px(edge(place)), panel.px(edge(place + 1)));
        let shades: Vec<u32> = (0..CELLS)
            .map(|cell| {
                let low = panel.y.scale.value(cell as f64 / CELLS as f64);
                let high = panel.y.scale.value((cell + 1) as f64 / CELLS as f64);
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
                    width: (right - left + 0.3).min(panel.frame.right() - left),
                    height: run as f64 * step,
                };
                canvas.rect(frame, &heat(f64::from(shades[from]) / SHADES), 1.0);
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

fn colour_bar(canvas: &mut Canvas, frame: Frame) {
    let steps = SHADES as usize;
    let step = frame.height / SHADES;
    for i in 0..steps {
        let top = frame.top + frame.height - (i + 1) as f64 * step;
        let share = (i as f64 + 0.5) / SHADES;
        canvas.rect(Frame { top, height: step + 0.3, ..frame }, &heat(share), 1.0);
    }
    canvas.border(frame);
    let right = frame.right() + 5.0;
    for part in 0..=3 {
        let share = f64::from(part) / 3.0;
        let y = frame.top + frame.height * (1.0 - share) + 4.5;
        let db = (FLOOR_DB * (share - 1.0)).round();
        let text = if db == 0.0 { "0 dB".to_owned() } else { format!("−{}", -db) };
        canvas.text((right, y), Anchor::Start, Face::Plain, &text);
    }
}
