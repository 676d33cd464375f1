//! Known masses that are added for a test are states: what the frequencies of one state leave open, they part.

use std::f64::consts::TAU;

use nalgebra::DMatrix;
use serde_json::Value;

use crate::program::{self, repository};

/// A frame of four storeys that shift against springs, by Newton's law for each floor: natural frequencies, Hz.
fn storeys_hz(masses_kg: &[f64; 4], springs: &[f64; 4]) -> Vec<f64> {
    let above = |i: usize| springs.get(i + 1).copied().unwrap_or(0.0);
    let scaled = DMatrix::from_fn(4, 4, |i, j| {
        let force = match (i, j) {
            _ if i == j => springs[i] + above(i),
            _ if i + 1 == j => -springs[j],
            _ if j + 1 == i => -springs[i],
            _ => 0.0,
        };
        force / (masses_kg[i] * masses_kg[j]).sqrt()
    });
    let mut hz: Vec<f64> =
        scaled.symmetric_eigenvalues().iter().map(|square| square.sqrt() / TAU).collect();
    hz.sort_by(f64::total_cmp);
    hz
}

/// At one pose, ten states with added masses part a storey that is softer from a floor that is heavier.
#[test]
fn added_masses_part_a_softer_storey_from_a_heavier_floor() {
    const MASSES_KG: [f64; 4] = [20.0, 18.0, 16.0, 14.0];
    const SPRINGS: [f64; 4] = [4.0e5, 3.2e5, 2.9e5, 2.1e5];
    let folder = tempfile::tempdir().unwrap();
    let (mut urdf, mut springs) =
        ("<robot name='frame'><link name='floor_0'/>".to_owned(), String::new());
    for i in 0..4 {
        let (n, mass, k) = (i + 1, MASSES_KG[i], SPRINGS[i]);
        urdf += &format!(
            "<link name='floor_{n}'><inertial><mass value='{mass}'/>\
             <inertia ixx='0.4' iyy='0.4' izz='0.6' ixy='0' ixz='0' iyz='0'/></inertial></link>\
             <joint name='storey_{n}' type='prismatic'><parent link='floor_{i}'/><child link='floor_{n}'/>\
             <origin xyz='0 0 0.4'/><axis xyz='1 0 0'/>\
             <limit lower='-0.1' upper='0.1' effort='1' velocity='1'/></joint>"
        );
        springs += &format!("    storey_{n}: {{stiffness_n_per_m: {k}}}\n");
    }
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("frame.urdf", &(urdf + "</robot>"));
    write(
        "robot.yaml",
        &format!("name: frame\nurdf: frame.urdf\nelasticity:\n  joints:\n{springs}"),
    );
    let one = |floor: usize, kg: f64| std::array::from_fn(|i| if i == floor { kg } else { 0.0 });
    let mut states: Vec<[f64; 4]> = vec![[0.0; 4], [3.0, 0.0, 0.0, 3.0], [0.0, 3.0, 3.0, 0.0]];
    states.extend((0..4).flat_map(|floor| [one(floor, 3.0), one(floor, 6.0)]));
    let robot = folder.path().join("robot.yaml");
    let diagnosed = |softer: f64, heavier: f64| -> Value {
        let mut table: String =
            (1..5).map(|n| format!("storey_{n}_m,mass_floor_{n}_kg,f{n}_hz,")).collect();
        table = table.trim_end_matches(',').to_owned() + "\n";
        let mut count = 0_u32;
        for added in &states {
            let mut masses: [f64; 4] = std::array::from_fn(|i| MASSES_KG[i] + added[i]);
            masses[3] += (heavier - 1.0) * MASSES_KG[3];
            let mut springs = SPRINGS;
            springs[0] *= softer;
            let cells = storeys_hz(&masses, &springs).into_iter().zip(added).map(|(hz, added)| {
                count += 1;
                format!("0,{added},{:.3}", hz * (1.0 + 0.003 * (2.399 * f64::from(count)).sin()))
            });
            table += &(cells.collect::<Vec<_>>().join(",") + "\n");
        }
        write("measured.csv", &table);
        let table = folder.path().join("measured.csv");
        let [robot, table] = [&robot, &table].map(|path| path.to_str().unwrap());
        let arguments = ["diagnose", robot, table, "--format", "json"];
        program::json(&program::run(repository(), &arguments))
    };
    for (softer, heavier, cause, at, estimate) in [
        (0.843, 1.0, "joint_stiffness", "storey_1", 0.843 * SPRINGS[0]),
        (1.0, 1.186, "link_inertia", "floor_4", 1.186),
    ] {
        let found = diagnosed(softer, heavier);
        assert_eq!(found["verdict"], "explained");
        let [first] = &found["findings"].as_array().unwrap()[..] else { panic!("{found}") };
        assert_eq!((first["cause"].as_str(), first["at"].as_str()), (Some(cause), Some(at)));
        let value = first["parameters"][0]["estimate"].as_f64().unwrap();
        assert!((value / estimate - 1.0).abs() < 0.015, "{value} for {estimate}");
        let others = first["indistinguishable_from"].as_array().unwrap();
        let other = if cause == "link_inertia" { "joint_stiffness" } else { "link_inertia" };
        assert!(others.iter().all(|one| one["cause"] != other), "{others:?}");
    }
}
