//! The modal kernel works in its own buffers: no allocation per pose.

use allocation_counter::measure;
use detune::model::Robot;
use detune::modes::ModalSolver;

#[test]
fn the_modal_kernel_does_not_allocate() {
    let mut description = crate::planar_arm::two_link();
    for gravity_stiffness in [false, true] {
        description.gravity_stiffness = gravity_stiffness;
        let robot = Robot::new(&description).unwrap();
        let mut solver = ModalSolver::new(&robot);
        let mut sum = 0.0;
        let counted = measure(|| {
            for i in 0..1000 {
                let q = [0.1, -2.0 + 0.004 * f64::from(i)];
                sum += solver.frequencies_hz(&q).unwrap()[0];
                sum += solver.solve(&q).unwrap().damping_ratios[0];
            }
        });
        assert!(sum > 0.0);
        assert_eq!(counted.count_total, 0, "allocations in 2000 solutions");
    }
}

/// The counter counts: a test that could not fail would prove nothing.
#[test]
fn the_counter_counts() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1);
}
