//! Chatter along a path: which places are solved exactly, and which mode is named.

use std::sync::Arc;

use detune::job::{Carried, Cutting, CuttingCoefficients, CuttingDirection, Operation};
use detune::job::{SpindleSpeed, Tool};
use detune::model::Robot;
use detune::process::{LimitAt, Owner, Spread, TipMode, TipPlace, chatter};
use detune::stability::{Chart, Cut, Method, ToolMode, milling_limit};
use detune::uncertainty::Draws;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::TAU;

use crate::planar_arm::two_link;

fn operation(cutting: Cutting) -> Operation {
    let robot = Arc::new(Robot::new(&two_link()).unwrap());
    let tool = Tool { teeth: 2, diameter_m: Some(0.012), ..Tool::default() };
    let speed = SpindleSpeed::Constant(6000.0);
    let path = Operation::new(&robot, Carried::NOTHING, tool, speed, 0.01, vec![]);
    Operation { cutting: Some(cutting), ..path }
}

fn cutting(radial_depth_m: f64, axial: Option<[f64; 2]>) -> Cutting {
    Cutting {
        radial_depth_m,
        axial_depth_m: 0.002,
        direction: CuttingDirection::Climb,
        material: String::new(),
        coefficients: Some(CuttingCoefficients {
            tangential_n_per_m2: 6e8,
            radial_n_per_m2: 2e8,
            tangential_edge_n_per_m: 0.0,
            radial_edge_n_per_m: 0.0,
            axial,
            exponents: [0.0; 3],
        }),
        regenerates: true,
        process_damping_n_per_m: 0.0,
    }
}

fn mode(of: Owner, hz: f64, damping_ratio: f64, mass_kg: f64, axis: [f64; 3]) -> TipMode {
    let motion = Vector3::from(axis).normalize() / mass_kg.sqrt();
    TipMode {
        of,
        mode: ToolMode { omega_rad_per_s: TAU * hz, damping_ratio, motion },
        turning: 0.0,
    }
}

fn place(s: f64, rpm: f64, modes: Vec<TipMode>) -> TipPlace {
    TipPlace { s, rpm, feed_per_tooth_m: 5e-5, modes, is_sure: true, leaves_axis: false }
}

fn along(operation: &Operation, places: &[TipPlace]) -> (LimitAt, Vec<LimitAt>) {
    let found = chatter(operation, places, |_| 1, Spread::NONE).unwrap();
    (found.smallest.unwrap(), found.along)
}

fn exact_m(operation: &Operation, place: &TipPlace) -> Option<f64> {
    let modes: Vec<ToolMode> = place.modes.iter().map(|one| one.mode).collect();
    let cut = Cut::new(&operation.tool, operation.cutting.as_ref().unwrap()).unwrap();
    let chart = Chart::new(&modes, &cut);
    milling_limit(&modes, &cut, &chart, place.rpm).unwrap().map(|limit| limit.depth_m)
}

/// Where the zeroth order is too low, the places that are solved exactly rise above those that are
/// not: further ones are solved until the smallest of all is exact.
#[test]
fn the_smallest_limit_is_exact() {
    let operation = operation(cutting(0.004, None));
    let (mut raised, mut more) = (0, 0);
    for rpm in [4000.0, 7000.0, 11_000.0, 15_000.0, 22_000.0] {
        let modes = |i: usize| {
            let mass_kg = 0.1 * (1.0 + 1e-3 * i as f64);
            vec![mode(Owner::Tool, 500.0, 0.5, mass_kg, [1.0, 0.4, 0.0])]
        };
        let places: Vec<TipPlace> =
            (0..12).map(|i| place(i as f64 / 11.0, rpm, modes(i))).collect();
        let (smallest, along) = along(&operation, &places);
        let solved = along.iter().filter(|at| at.method == Method::Exact).count();
        let all = places.iter().filter_map(|place| exact_m(&operation, place));
        let least = all.fold(f64::INFINITY, f64::min);
        let zeroth = Chart::new(
            &places[0].modes.iter().map(|one| one.mode).collect::<Vec<_>>(),
            &Cut::new(&operation.tool, operation.cutting.as_ref().unwrap()).unwrap(),
        );
        let zeroth_m = zeroth.limit(rpm).unwrap().depth_m;
        println!("{rpm} rpm: {solved} exact, {least} m, zeroth {zeroth_m} m");
        raised += usize::from(least > 1.001 * zeroth_m);
        more += usize::from(solved > 3);
        assert_eq!(smallest.method, Method::Exact, "{rpm} rpm");
        if least > zeroth_m {
            let off = smallest.depth_m.unwrap() / least - 1.0;
            assert!(off.abs() < 1e-6, "{rpm} rpm: {smallest:?}, exact {least}");
        }
    }
    assert!(raised > 0 && more > 0, "{raised} {more}");
}

/// A mode along the spindle does not change the chip: it has no part in chatter, however strongly it answers
/// at that frequency. The limit without it is the same; without the mode that is named it is another.
#[test]
fn the_mode_that_is_named_is_the_one_that_chatters() {
    let operation = operation(cutting(0.009, Some([3e8, 0.0])));
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for round in 0..20 {
        let mut of_arm = |number, hz: f64| {
            let axis = [0, 1, 2].map(|_| rng.random_range(-1.0..1.0));
            mode(Owner::Arm(number), hz, 0.03, 20.0, axis)
        };
        let mut modes = vec![of_arm(1, 40.0), of_arm(2, 160.0)];
        let (first, _) = along(&operation, &[place(0.0, 6000.0, modes.clone())]);
        let hz = first.frequency_hz.unwrap();
        modes.push(mode(Owner::Arm(3), hz, 0.01, 0.5, [0.0, 0.0, 1.0]));
        let (found, _) = along(&operation, &[place(0.0, 6000.0, modes.clone())]);
        let named = found.mode.unwrap();
        let same = found.depth_m.unwrap() / first.depth_m.unwrap() - 1.0;
        assert!(same.abs() < 1e-9, "{round}: {same}");
        assert_ne!(named, 3, "{round}: {found:?}");
        modes.remove(named - 1);
        let without =
            chatter(&operation, &[place(0.0, 6000.0, modes)], |_| 1, Spread::NONE).unwrap();
        let depth_m = without.smallest.and_then(|at| at.depth_m).unwrap_or(1.0);
        let off = (depth_m / found.depth_m.unwrap() - 1.0).abs();
        assert!(off > 0.05, "{round}: {found:?} {depth_m}");
    }
}

/// With one mode, ω → cω at the same shape is the same cut in another time and on a spring that is c² times as
/// stiff: b(n; cω) = c² b(n/c; ω). Solved so for every one of the 48 draws the ends are the same to the hundredth
/// that they are looked for with; and few of the whole distribution of c lie beyond either of them.
#[test]
fn the_interval_of_the_smallest_limit_holds_what_the_frequency_does() {
    let sigma = 0.06;
    for (radial_m, rpm) in [(0.012, 3000.0), (0.012, 5200.0), (0.0015, 4300.0)] {
        let operation = operation(cutting(radial_m, None));
        let mass_kg = if radial_m < 0.01 { 5.0 } else { 20.0 };
        let modes = vec![mode(Owner::Arm(1), 160.0, 0.03, mass_kg, [1.0, 0.4, 0.0])];
        let places = [place(0.0, rpm, modes.clone())];
        let std_ln = |_: f64, _: usize| sigma;
        let spread = Spread { confidence: 0.95, std_ln: &std_ln };
        let found = chatter(&operation, &places, |_| 1, spread).unwrap();
        let of_z = |z: f64| {
            let c = (sigma * z).exp();
            let slower = place(0.0, rpm / c, modes.clone());
            c * c * exact_m(&operation, &slower).unwrap_or(f64::INFINITY)
        };
        let sorted = |z: Vec<f64>| {
            let mut all: Vec<f64> = z.into_iter().map(of_z).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        let draws = Draws::new(1, 3, 1);
        let drawn = sorted((0..48).map(|i| draws.row(i)[0]).collect());
        let own = found.smallest_ci95_m.map(|end| end.unwrap_or(f64::INFINITY));
        for (own, expected) in own.into_iter().zip([drawn[1], drawn[46]]) {
            assert!((own / expected - 1.0).abs() < 0.015, "{rpm} rpm: {own} {expected}");
        }
        let normal = Normal::standard();
        let all = sorted((0..160).map(|i| normal.inverse_cdf((i as f64 + 0.5) / 160.0)).collect());
        let beyond = [
            all.iter().filter(|limit| **limit < own[0]).count(),
            all.iter().filter(|limit| **limit > own[1]).count(),
        ];
        println!("{rpm} rpm: {own:?}, {beyond:?} of 160 beyond, alone {:?}", found.smallest);
        assert!(beyond.iter().all(|count| *count <= 16), "{beyond:?}");
        let smallest = found.smallest.unwrap().depth_m.unwrap();
        assert!(own[0] <= smallest && smallest <= own[1], "{own:?} {smallest}");
        // Between the ends the cut may chatter, and below them it does not.
        for (depth_m, may) in [(0.5 * (own[0] + smallest), true), (0.9 * own[0], false)] {
            let cutting = Cutting { axial_depth_m: depth_m, ..cutting(radial_m, None) };
            let operation = self::operation(cutting);
            let found = chatter(&operation, &places, |_| 1, spread).unwrap();
            assert_eq!((found.is_beyond, found.may_be_beyond), (false, may), "{rpm} {depth_m}");
        }
        let sure = chatter(&operation, &places, |_| 1, Spread::NONE).unwrap();
        assert_eq!(sure.smallest_ci95_m, [Some(smallest); 2]);
    }
}
