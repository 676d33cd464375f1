//! How the cost of a pose grows: with the number of poses from 10³ to 10⁸, with elastic coordinates from 2 to
//! 24, with threads. `cargo bench --bench growth` prints tables and draws them in benches/growth.svg.

#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::fmt::Write;
use std::hint::black_box;

use common::{chain, least_ns, poses, six_axes};
use detune::model::Robot;
use detune::modes::ModalSolver;
use detune::modes::batch::{Kernel, TipOut};
use nalgebra::Point3;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

mod common;

/// Poses whose results are not kept are solved so many at a time.
const PIECE: usize = 4096;

/// Most poses that are kept with their results: 96 bytes each.
const MAX_KEPT: usize = 10_000_000;

/// A line of the drawing: what it is, and (x, ns a pose).
type Curve = (String, Vec<(f64, f64)>);

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

fn repetitions(count: usize) -> usize {
    match count {
        0..=1_000_000 => 7,
        1_000_001..=10_000_000 => 3,
        _ => 1,
    }
}

/// ns a pose where poses and results lie in memory.
fn kept_ns(kernel: &Kernel, poses: &[f64], f: &mut [f64], count: usize, threads: usize) -> f64 {
    pool(threads).install(|| {
        least_ns(count, repetitions(count), || {
            kernel.par_frequencies_hz(poses, black_box(f)).unwrap()
        })
    })
}

/// ns a pose where one piece of poses is solved again and again, and of the results the highest is kept.
fn reduced_ns(kernel: &Kernel, piece: &[f64], n: usize, count: usize, threads: usize) -> f64 {
    let (pieces, joints) = (count.div_ceil(PIECE), piece.len() / PIECE);
    let highest = || {
        (0..pieces)
            .into_par_iter()
            .map_init(
                || vec![0.0; PIECE * n],
                |f, i| {
                    let here = PIECE.min(count - i * PIECE);
                    let f = &mut f[..here * n];
                    kernel.frequencies_hz(black_box(&piece[..here * joints]), f).unwrap();
                    f.iter().copied().fold(0.0, f64::max)
                },
            )
            .reduce(|| 0.0, f64::max)
    };
    pool(threads)
        .install(|| least_ns(count, repetitions(count), || assert!(black_box(highest()) > 0.0)))
}

fn over_poses(robot: &Robot) -> Vec<Curve> {
    let n = robot.coordinates().len();
    let kernel = Kernel::new(robot);
    let piece = poses(robot, PIECE);
    let threads = rayon::current_num_threads();
    let names = ["kept, 1 thread".to_owned(), format!("kept, {threads} threads")];
    let reduced = ["reduced, 1 thread".to_owned(), format!("reduced, {threads} threads")];
    let mut curves: Vec<Curve> =
        names.into_iter().chain(reduced).map(|name| (name, vec![])).collect();
    println!("six axes, frequencies, ns a pose");
    println!(
        "{:>11} {:>16} {:>16} {:>18} {:>18}",
        "poses", curves[0].0, curves[1].0, curves[2].0, curves[3].0
    );
    for decade in 3..=8 {
        let count = 10_usize.pow(decade);
        let mut row = [f64::NAN; 4];
        if count <= MAX_KEPT {
            let poses = piece
                .iter()
                .copied()
                .cycle()
                .take(count * robot.joints().len())
                .collect::<Vec<_>>();
            let mut f = vec![0.0; count * n];
            row[0] = kept_ns(&kernel, &poses, &mut f, count, 1);
            row[1] = kept_ns(&kernel, &poses, &mut f, count, threads);
        }
        row[2] = reduced_ns(&kernel, &piece, n, count, 1);
        row[3] = reduced_ns(&kernel, &piece, n, count, threads);
        println!("{count:>11} {:>16.1} {:>16.1} {:>18.1} {:>18.1}", row[0], row[1], row[2], row[3]);
        for (curve, ns) in curves.iter_mut().zip(row).filter(|(_, ns)| !ns.is_nan()) {
            curve.1.push((count as f64, ns));
        }
    }
    curves
}

fn over_coordinates() -> Vec<Curve> {
    let tcp_m = Point3::new(0.0, 0.0, 0.15);
    let names = ["scalar path", "batch, with tip participation", "batch, frequencies"];
    let mut curves: Vec<Curve> = names.map(|name| (name.to_owned(), Vec::new())).into();
    println!("\nchains of n elastic joints, one thread, ns a pose");
    println!("{:>3} {:>12} {:>12} {:>12}", "n", "scalar", "and tip", "frequencies");
    for n in [2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24] {
        let robot = chain(n);
        let count = if n < 10 { 20_000 } else { 4_000 };
        let poses = poses(&robot, count);
        let (mut f, mut c) = (vec![0.0; count * n], vec![0.0; count * n]);
        let (kernel, mut solver) = (Kernel::new(&robot), ModalSolver::new(&robot));
        let scalar = least_ns(count, 3, || {
            for q in poses.chunks_exact(n) {
                black_box(solver.frequencies_hz(q).unwrap());
            }
        });
        let tip = least_ns(count, 7, || {
            let out = TipOut { natural_frequencies_hz: &mut f, peak_compliances_m_per_n: &mut c };
            kernel.tip(&poses, &tcp_m, black_box(out)).unwrap();
        });
        let frequencies =
            least_ns(count, 7, || kernel.frequencies_hz(&poses, black_box(&mut f)).unwrap());
        println!("{n:>3} {scalar:>12.1} {tip:>12.1} {frequencies:>12.1}");
        for (curve, ns) in curves.iter_mut().zip([scalar, tip, frequencies]) {
            curve.1.push((n as f64, ns));
        }
    }
    curves
}

/// One panel with logarithmic axes, `left` of the drawing's left edge.
fn panel(
    svg: &mut String,
    left: f64,
    title: &str,
    x_ticks: &[(f64, &str)],
    y: [f64; 2],
    curves: &[Curve],
) {
    const SIZE: [f64; 2] = [360.0, 260.0];
    const INKS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
    let x = [x_ticks[0].0, x_ticks[x_ticks.len() - 1].0];
    let share = |v: f64, [low, high]: [f64; 2]| (v / low).ln() / (high / low).ln();
    let at =
        |px: f64, py: f64| (left + SIZE[0] * share(px, x), 40.0 + SIZE[1] * (1.0 - share(py, y)));
    writeln!(svg, r##"<text x="{left}" y="24" font-weight="bold">{title}</text>"##).unwrap();
    let grid = |svg: &mut String, (x1, y1), (x2, y2)| {
        writeln!(svg, r##"<path d="M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}" stroke="#ddd"/>"##).unwrap();
    };
    for (value, label) in x_ticks {
        let (px, py) = at(*value, y[0]);
        grid(svg, (px, py), at(*value, y[1]));
        writeln!(
            svg,
            r##"<text x="{px:.1}" y="{:.1}" text-anchor="middle">{label}</text>"##,
            py + 16.0
        )
        .unwrap();
    }
    for value in [10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4, 1e5] {
        if (y[0]..=y[1]).contains(&value) {
            let (px, py) = at(x[0], value);
            grid(svg, (px, py), at(x[1], value));
            let (px, py) = (px - 6.0, py + 4.0);
            writeln!(svg, r##"<text x="{px:.1}" y="{py:.1}" text-anchor="end">{value}</text>"##)
                .unwrap();
        }
    }
    for (i, ((name, points), ink)) in curves.iter().zip(INKS).enumerate() {
        let places: Vec<String> = points
            .iter()
            .map(|&(px, py)| at(px, py))
            .map(|(px, py)| format!("{px:.1},{py:.1}"))
            .collect();
        let places = places.join(" ");
        writeln!(
            svg,
            r##"<polyline points="{places}" fill="none" stroke="{ink}" stroke-width="2"/>"##
        )
        .unwrap();
        let py = 56.0 + 16.0 * i as f64;
        writeln!(svg, r##"<text x="{:.1}" y="{py}" fill="{ink}">{name}</text>"##, left + 10.0)
            .unwrap();
    }
}

fn main() {
    let over_poses = over_poses(&six_axes());
    let over_coordinates = over_coordinates();
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"900\" height=\"330\" font-family=\"sans-serif\" \
         font-size=\"12\">\n<rect width=\"900\" height=\"330\" fill=\"#fff\"/>\n",
    );
    let poses =
        [(1e3, "10³"), (1e4, "10⁴"), (1e5, "10⁵"), (1e6, "10⁶"), (1e7, "10⁷"), (1e8, "10⁸")];
    panel(
        &mut svg,
        55.0,
        "ns a pose over poses: six axes, frequencies",
        &poses,
        [20.0, 500.0],
        &over_poses,
    );
    let sizes = [(2.0, "2"), (4.0, "4"), (6.0, "6"), (8.0, "8"), (12.0, "12"), (24.0, "24")];
    panel(
        &mut svg,
        510.0,
        "ns a pose over elastic coordinates: one thread",
        &sizes,
        [10.0, 1e5],
        &over_coordinates,
    );
    svg.push_str("</svg>\n");
    std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/benches/growth.svg"), svg).unwrap();
}
