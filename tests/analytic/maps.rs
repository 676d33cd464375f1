//! Maps against single poses.

use std::path::Path;

use detune::free_vibration::{Sampling, measure};
use detune::model::Robot;
use detune::notes::Code;
use detune::progress::silent;
use detune::study::map::{
    Block, FrequencyMap, MapError, Method, Positions, Request, Source, Target, Unit, nonlinear,
    read_robot, run,
};

fn arm() -> Robot {
    read_robot(Path::new("robots/two-link/robot.yaml")).value.unwrap()
}

fn sweep(steps: usize) -> Request {
    let joint = "joint_2".to_owned();
    let axis = Positions { joint, from: -1.0, to: 1.5, steps, unit: Unit::RadOrM };
    Request::Grid { axes: vec![axis], at: vec![("joint_1".into(), 30.0)] }
}

/// Blocks of several batches are kept in order, with the frequencies that single poses have.
#[test]
fn a_nonlinear_map_is_what_its_poses_are() {
    let robot = arm();
    let sampling = Sampling::Fixed { sample_rate_hz: 140.0, duration_s: 0.5 };
    let method = nonlinear(Some(0.2), sampling).unwrap();
    let map = FrequencyMap::new(&robot, method);
    let source = Source::new(&sweep(70), &robot).unwrap();
    let mut block = Block::default();
    let target = Target::Kept { block: &mut block, max_poses: 70 };
    let summary = run(source, &map, target, &silent).unwrap();
    assert_eq!((summary.poses, block.count, block.nonlinear.len()), (70, 70, 70));
    let Method::Nonlinear(settings) = method else { panic!("{method:?}") };
    for (i, row) in block.rows().enumerate().step_by(23) {
        let alone = measure(&robot, row.joints, &settings).unwrap();
        assert_eq!(row.nonlinear, Some(&alone), "{i}");
        for (mapped, alone) in row.frequencies_hz.iter().zip(&alone.frequencies_hz) {
            assert_eq!((!mapped.is_nan()).then_some(*mapped), *alone, "{i}");
        }
    }
    // The second mode lies above half the sampling rate.
    assert!(summary.aliased > 0);
    let warnings = summary.warnings(&robot);
    assert!(warnings.iter().any(|warning| warning.code == Code::Folded), "{warnings:?}");
}

#[test]
fn more_poses_than_can_be_drawn_are_an_error() {
    let robot = arm();
    let map = FrequencyMap::new(&robot, Method::Linear);
    let mut block = Block::default();
    let target = Target::Kept { block: &mut block, max_poses: 9 };
    let source = Source::new(&sweep(10), &robot).unwrap();
    let Err(MapError::Input(errors)) = run(source, &map, target, &silent) else { panic!("drawn") };
    assert_eq!(errors[0].code, Code::TooLong);
}
