//! The speed within a corridor, by a convex quadratic programme.
//!
//! With x = n / n_programmed at the sides of the cells and x* the speed to stay near to,
//!
//! ```text
//! minimise   Σ w_i (x_i − x*)²  +  ρ Σ (x_{i+1} − x_i)² / Δs_i
//! so that    l_i ≤ x_i ≤ u_i,   |x_{i+1} − x_i| ≤ a T Δs_i
//! ```
//!
//! w_i are the weights of the trapezium rule over s; in the cost of changes no Δs_i is taken for
//! less than 1e-4. P is positive definite, so there is one minimum.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT,
    ZeroConeT,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::routes::Limits;
use crate::advice::speeds::Speeds;

/// ρ: changes within less than about √ρ, 3 % of the path, are smoothed.
pub(super) const SMOOTHING: f64 = 1e-3;

/// Cells narrower than this are smoothed as if they were as wide: where a ramp ends, slivers are
/// left over.
const MIN_WIDTH: f64 = 1e-4;

/// Bounds closer than this leave one speed, as a share of the programmed one.
const SINGLE: f64 = 1e-9;

/// How the solver ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub enum SolverEnd {
    /// To full accuracy.
    Solved,
    /// To reduced accuracy; what came out was moved into its bounds and checked like any other.
    AlmostSolved,
    /// There is no speed within the corridor and the acceleration.
    Infeasible,
    /// The steps allowed did not suffice.
    OutOfSteps,
    /// The solver gave up: numbers too far apart, or no progress.
    Stuck,
    /// What should not happen with this problem: an objective without bound, bad input, or an end
    /// that nobody asked for.
    Unexpected,
}

/// Speeds at the sides of the cells with the least objective within `bounds`, rev/min.
///
/// # Errors
/// How the solver ended, if without a result.
pub(super) fn solve(
    s: &[f64],
    bounds: &[Speeds],
    limits: &Limits,
) -> Result<(Vec<f64>, SolverEnd), SolverEnd> {
    let n = s.len();
    let scale = limits.programmed_rpm;
    if bounds.iter().all(|bound| bound.contains(limits.target_rpm)) {
        // The objective is zero there; a solver would stop a little short of a target on a bound.
        return Ok((vec![limits.target_rpm; n], SolverEnd::Solved));
    }
    let mut quadratic = Entries::default();
    let mut linear = vec![0.0; n];
    for (i, linear) in linear.iter_mut().enumerate() {
        let weight = weight(s, i);
        let bends = [i.checked_sub(1), (i + 1 < n).then_some(i)].into_iter().flatten();
        let stiff: f64 = bends.map(|k| stiffness(s, k)).sum();
        quadratic.push(i, i, 2.0 * (weight + stiff));
        if i + 1 < n {
            // The upper triangle alone.
            quadratic.push(i, i + 1, -2.0 * stiffness(s, i));
        }
        *linear = -2.0 * weight * limits.target_rpm / scale;
    }
    let mut fixed = Rows::default();
    let mut within = Rows::default();
    for (i, bound) in bounds.iter().enumerate() {
        let (low, high) = (bound.low_rpm / scale, bound.high_rpm / scale);
        if high - low < SINGLE {
            fixed.push(&[(i, 1.0)], 0.5 * (low + high));
        } else {
            within.push(&[(i, 1.0)], high);
            within.push(&[(i, -1.0)], -low);
        }
    }
    // On a ramp the speeds are given.
    let is_given = |i: usize| (bounds[i].high_rpm - bounds[i].low_rpm) / scale < SINGLE;
    for i in 0..n - 1 {
        if !(is_given(i) && is_given(i + 1)) {
            let step = limits.slope_rpm * (s[i + 1] - s[i]) / scale;
            within.push(&[(i + 1, 1.0), (i, -1.0)], step);
            within.push(&[(i, 1.0), (i + 1, -1.0)], step);
        }
    }
    let cones: [SupportedConeT<f64>; 2] =
        [ZeroConeT(fixed.sides.len()), NonnegativeConeT(within.sides.len())];
    let (constraints, sides) = fixed.above(within, n);
    let settings = DefaultSettings {
        verbose: false,
        // Tens are usual.
        max_iter: 200,
        ..DefaultSettings::default()
    };
    let quadratic = quadratic.matrix(n, n);
    let mut solver =
        DefaultSolver::new(&quadratic, &linear, &constraints, &sides, &cones, settings)
            .map_err(|_| SolverEnd::Unexpected)?;
    solver.solve();
    let end = match solver.solution.status {
        SolverStatus::Solved => SolverEnd::Solved,
        SolverStatus::AlmostSolved => SolverEnd::AlmostSolved,
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
            return Err(SolverEnd::Infeasible);
        }
        SolverStatus::MaxIterations | SolverStatus::MaxTime => return Err(SolverEnd::OutOfSteps),
        SolverStatus::NumericalError | SolverStatus::InsufficientProgress => {
            return Err(SolverEnd::Stuck);
        }
        SolverStatus::DualInfeasible
        | SolverStatus::AlmostDualInfeasible
        | SolverStatus::CallbackTerminated
        | SolverStatus::Unsolved => return Err(SolverEnd::Unexpected),
    };
    // The solver's results lie about 1e-8 inside or outside a bound.
    let speeds = solver.solution.x.iter().zip(bounds);
    let mut rpm: Vec<f64> = speeds.map(|(x, b)| (x * scale).clamp(b.low_rpm, b.high_rpm)).collect();
    hold_steps(s, limits.slope_rpm, &mut rpm, &is_given);
    Ok((rpm, end))
}

/// Moves speeds by what the solver leaves them beyond the acceleration, which in a narrow cell is
/// much; those that are given stay.
fn hold_steps(s: &[f64], slope_rpm: f64, rpm: &mut [f64], is_given: &dyn Fn(usize) -> bool) {
    let n = s.len();
    let held =
        |of: f64, by: f64, width: f64| of.clamp(by - slope_rpm * width, by + slope_rpm * width);
    for i in 1..n {
        if !is_given(i) {
            rpm[i] = held(rpm[i], rpm[i - 1], s[i] - s[i - 1]);
        }
    }
    for i in (1..n).rev() {
        if !is_given(i - 1) {
            rpm[i - 1] = held(rpm[i - 1], rpm[i], s[i] - s[i - 1]);
        }
    }
}

/// Weight of the squared change in cell `i`.
fn stiffness(s: &[f64], i: usize) -> f64 {
    SMOOTHING / (s[i + 1] - s[i]).max(MIN_WIDTH)
}

/// The objective of speeds at the sides of the cells.
pub(super) fn objective(s: &[f64], rpm: &[f64], limits: &Limits) -> f64 {
    let x = |i: usize| rpm[i] / limits.programmed_rpm;
    let target = limits.target_rpm / limits.programmed_rpm;
    let near: f64 = (0..s.len()).map(|i| weight(s, i) * (x(i) - target).powi(2)).sum();
    let smooth = |i: usize| stiffness(s, i) * (x(i + 1) - x(i)).powi(2);
    near + (0..s.len() - 1).map(smooth).sum::<f64>()
}

/// Weight of side `i` in the trapezium rule.
fn weight(s: &[f64], i: usize) -> f64 {
    let before = i.checked_sub(1).map_or(s[i], |k| s[k]);
    let after = s.get(i + 1).copied().unwrap_or(s[i]);
    0.5 * (after - before)
}

/// Rows of constraints a·x ≤ (or =) side.
#[derive(Debug, Default)]
struct Rows {
    entries: Entries,
    sides: Vec<f64>,
}

impl Rows {
    fn push(&mut self, row: &[(usize, f64)], side: f64) {
        for &(column, value) in row {
            self.entries.push(self.sides.len(), column, value);
        }
        self.sides.push(side);
    }

    /// These rows with `others` below them.
    fn above(mut self, others: Rows, columns: usize) -> (CscMatrix<f64>, Vec<f64>) {
        let offset = self.sides.len();
        for (row, column, value) in others.entries.0 {
            self.entries.push(row + offset, column, value);
        }
        self.sides.extend(others.sides);
        (self.entries.matrix(self.sides.len(), columns), self.sides)
    }
}

/// Entries (row, column, value) of a sparse matrix.
#[derive(Debug, Default)]
struct Entries(Vec<(usize, usize, f64)>);

impl Entries {
    fn push(&mut self, row: usize, column: usize, value: f64) {
        self.0.push((row, column, value));
    }

    fn matrix(self, rows: usize, columns: usize) -> CscMatrix<f64> {
        let mut at = (Vec::new(), Vec::new(), Vec::new());
        for (row, column, value) in self.0 {
            at.0.push(row);
            at.1.push(column);
            at.2.push(value);
        }
        CscMatrix::new_from_triplets(rows, columns, at.0, at.1, at.2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `step_rpm` in each of `cells` cells.
    fn limits(step_rpm: f64, cells: usize) -> Limits {
        Limits {
            programmed_rpm: 1000.0,
            target_rpm: 1000.0,
            slope_rpm: step_rpm * cells as f64,
            min_rpm: 100.0,
            max_rpm: 6000.0,
        }
    }

    fn sides(n: usize) -> Vec<f64> {
        (0..=n).map(|i| i as f64 / n as f64).collect()
    }

    #[test]
    fn without_bounds_the_programmed_speed_is_best() {
        let s = sides(50);
        let open = vec![Speeds { low_rpm: 500.0, high_rpm: 6000.0 }; s.len()];
        let (rpm, end) = solve(&s, &open, &limits(5.0, 50)).unwrap();
        assert_eq!(end, SolverEnd::Solved);
        assert!(rpm.iter().all(|rpm| (rpm - 1000.0).abs() < 1e-3), "{rpm:?}");
    }

    /// x'' ρ = x − 1 away from a side held at 1.5: x − 1 = 0.5 cosh((1 − s)/√ρ) / cosh(1/√ρ).
    #[test]
    fn a_speed_held_at_one_end_decays_as_the_equation_says() {
        let s = sides(500);
        let mut bounds = vec![Speeds { low_rpm: 100.0, high_rpm: 6000.0 }; s.len()];
        bounds[0] = Speeds { low_rpm: 1500.0, high_rpm: 1500.0 };
        let (rpm, _) = solve(&s, &bounds, &limits(1e6, 500)).unwrap();
        let root = SMOOTHING.sqrt();
        for (s, rpm) in s.iter().zip(&rpm) {
            let exact = 1000.0 + 500.0 * ((1.0 - s) / root).cosh() / (1.0 / root).cosh();
            assert!((rpm - exact).abs() < 0.5, "{s}: {rpm} {exact}");
        }
        let energy = 0.25 * root * (1.0 / root).tanh();
        let found = objective(&s, &rpm, &limits(1e6, 500));
        assert!((found / energy - 1.0).abs() < 2e-3, "{found} {energy}");
    }

    #[test]
    fn what_cannot_be_reached_is_infeasible() {
        let s = sides(10);
        let mut bounds = vec![Speeds { low_rpm: 500.0, high_rpm: 6000.0 }; s.len()];
        bounds[0] = Speeds { low_rpm: 500.0, high_rpm: 600.0 };
        bounds[10] = Speeds { low_rpm: 900.0, high_rpm: 950.0 };
        assert!(solve(&s, &bounds, &limits(31.0, 10)).is_ok());
        assert_eq!(solve(&s, &bounds, &limits(29.0, 10)).unwrap_err(), SolverEnd::Infeasible);
    }

    /// With bounds out of the way the least is reached at the target, whatever is programmed.
    #[test]
    fn a_target_draws_the_speed() {
        let s = sides(50);
        let open = vec![Speeds { low_rpm: 500.0, high_rpm: 1800.0 }; s.len()];
        let target = |target_rpm| Limits { target_rpm, ..limits(5.0, 50) };
        let (rpm, _) = solve(&s, &open, &target(1500.0)).unwrap();
        assert!(rpm.iter().all(|rpm| (rpm - 1500.0).abs() < 1e-3), "{rpm:?}");
        let (rpm, _) = solve(&s, &open, &target(6000.0)).unwrap();
        assert!(rpm.iter().all(|rpm| (rpm - 1800.0).abs() < 1e-2), "{rpm:?}");
        let (rpm, _) = solve(&s, &open, &target(1800.0)).unwrap();
        assert!(rpm.iter().all(|rpm| *rpm == 1800.0), "{rpm:?}");
    }

    /// Cells a billionth wide: what a solver leaves, 1e-8 of the speed, is many times what they
    /// allow.
    #[test]
    fn slivers_keep_the_acceleration() {
        let s = [0.0, 0.3, 0.3 + 1e-9, 0.3 + 3e-9, 0.6, 1.0];
        let solved = [990.0, 1000.0, 1000.00001, 999.99999, 1001.0, 1002.0];
        let slope_rpm = 1000.0;
        for given in 0..s.len() {
            let mut rpm = solved;
            hold_steps(&s, slope_rpm, &mut rpm, &|i| i == given);
            assert_eq!(rpm[given], solved[given]);
            for i in 1..s.len() {
                let most = slope_rpm * (s[i] - s[i - 1]);
                assert!(
                    (rpm[i] - rpm[i - 1]).abs() <= most + 1e-12 * rpm[i],
                    "{given} {i}: {most}"
                );
                assert!((rpm[i] - solved[i]).abs() < 3e-5, "{given} {i}: {}", rpm[i]);
            }
        }
    }
}
