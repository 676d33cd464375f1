//! Causes fitted to a table: weighted least squares in a trust region (Levenberg–Marquardt) with the
//! weights of the noise, from several starts.

use nalgebra::{DMatrix, DVector};

use super::candidate::Candidate;
use super::data::Data;
use super::likelihood::{FINEST, Noise, noise};
use super::predict::{Frequency, Hypothesis, folded, predict};
use crate::model::{Cause, Description};

/// Rounds of a fit.
const MOST_ROUNDS: usize = 25;

/// A gain of ln likelihood below this ends a fit.
const SMALLEST_GAIN: f64 = 2e-3;

/// Scale of the noise with which missed modes are first told from seen ones.
const FIRST_SCALE: f64 = 0.01;

/// The problem: a robot's description and a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Problem<'p> {
    pub(super) description: &'p Description,
    pub(super) data: &'p Data,
}

/// A hypothesis held against the table.
#[derive(Debug, Clone)]
pub(super) struct Evaluation {
    /// ln(measured / predicted), one a point; `None` where the model has no such mode.
    pub(super) residuals: Vec<Option<f64>>,
    /// d ln(predicted) by each parameter, one row a point.
    pub(super) slopes: Vec<Vec<f64>>,
    pub(super) noise: Noise,
    /// ln likelihood, with what is expected of the parameters.
    pub(super) score: f64,
}

/// A fitted hypothesis.
#[derive(Debug, Clone)]
pub(super) struct Fit<'c> {
    pub(super) hypothesis: Hypothesis<'c>,
    pub(super) evaluation: Evaluation,
    /// Degrees of freedom that the parameters take: less than their number where the data say little.
    pub(super) freedom: f64,
}

impl Fit<'_> {
    /// Puts the cause that came last at place `i`, its parameters with it.
    pub(super) fn move_last_to(&mut self, i: usize) {
        let effects = &mut self.hypothesis.effects;
        let Some(last) = effects.pop() else { return };
        let at: usize = effects[..i].iter().map(|(_, inner)| inner.len()).sum();
        let count = last.1.len();
        effects.insert(i, last);
        // A point without prediction has no slopes.
        for slopes in self.evaluation.slopes.iter_mut().filter(|s| s.len() >= at + count) {
            slopes[at..].rotate_right(count);
        }
    }
}

impl<'p> Problem<'p> {
    /// Residuals and likelihood of a hypothesis; `None` if it is impossible.
    pub(super) fn evaluate(
        &self,
        hypothesis: &Hypothesis<'_>,
        with_slopes: bool,
    ) -> Option<Evaluation> {
        let rows = predict(self.description, hypothesis, self.data, with_slopes)?;
        let rows = self.seen(hypothesis, rows)?;
        let missed: Vec<usize> = hypothesis
            .effects
            .iter()
            .filter(|(candidate, _)| candidate.cause == Cause::MissedMode)
            .filter_map(|(candidate, _)| mode_of(candidate))
            .collect();
        let (residuals, slopes, prior) = if missed.is_empty() {
            let (residuals, slopes) = self.compared(&rows, with_slopes);
            (residuals, slopes, 0.0)
        } else {
            self.compared_with_misses(rows, &missed, with_slopes)
        };
        let noise = noise(&self.data.points, &residuals);
        let score = noise.ln_likelihood + prior + expectation(hypothesis);
        score.is_finite().then_some(Evaluation { residuals, slopes, noise, score })
    }

    /// Frequencies as the instrument shows them: folded where it folds.
    fn seen(
        &self,
        hypothesis: &Hypothesis<'_>,
        mut rows: Vec<Vec<Frequency>>,
    ) -> Option<Vec<Vec<Frequency>>> {
        let mut at = 0;
        for (candidate, inner) in &hypothesis.effects {
            let own = at;
            at += inner.len();
            if candidate.cause != Cause::AliasedMode {
                continue;
            }
            let mode = mode_of(candidate)?;
            let fitted = candidate.parameters.first().map(|p| p.value(inner[0]));
            for (frequencies, row) in rows.iter_mut().zip(&self.data.rows) {
                let Some(rate) = fitted.or(row.sample_rate_hz) else { continue };
                let Some(frequency) = frequencies.get_mut(mode) else { continue };
                let true_hz = frequency.ln_hz.exp();
                if true_hz <= 0.5 * rate {
                    continue;
                }
                let seen_hz = folded(true_hz, rate).max(1e-3);
                let turns = (true_hz / rate).round();
                let sign = if true_hz >= turns * rate { 1.0 } else { -1.0 };
                for slope in &mut frequency.slope {
                    *slope *= sign * true_hz / seen_hz;
                }
                if let (Some(_), Some(slope)) = (fitted, frequency.slope.get_mut(own)) {
                    // seen = ±(true − turns · rate), and the rate is measured by its logarithm.
                    *slope = -sign * turns * rate / seen_hz;
                }
                frequency.ln_hz = seen_hz.ln();
            }
        }
        for frequencies in &mut rows {
            frequencies.sort_by(|a, b| a.ln_hz.total_cmp(&b.ln_hz));
        }
        Some(rows)
    }

    fn compared(
        &self,
        rows: &[Vec<Frequency>],
        with_slopes: bool,
    ) -> (Vec<Option<f64>>, Vec<Vec<f64>>) {
        let mut residuals = Vec::with_capacity(self.data.points.len());
        let mut slopes = Vec::new();
        for point in &self.data.points {
            let predicted = rows[point.row].get(point.column);
            residuals.push(predicted.map(|predicted| point.ln_f - predicted.ln_hz));
            if with_slopes {
                slopes.push(predicted.map_or_else(Vec::new, |predicted| predicted.slope.clone()));
            }
        }
        (residuals, slopes)
    }

    /// Row by row, the likelier of a mode seen and a mode missed; with ln of how likely so many misses are.
    fn compared_with_misses(
        &self,
        mut rows: Vec<Vec<Frequency>>,
        missed: &[usize],
        with_slopes: bool,
    ) -> (Vec<Option<f64>>, Vec<Vec<f64>>, f64) {
        let mut prior = 0.0;
        for &mode in missed {
            let shifted: Vec<Vec<Frequency>> = rows
                .iter()
                .map(|row| {
                    let mut row = row.clone();
                    if mode < row.len() {
                        row.remove(mode);
                    }
                    row
                })
                .collect();
            let (as_seen, _) = self.compared(&rows, false);
            let (as_missed, _) = self.compared(&shifted, false);
            let mut scale = FIRST_SCALE;
            let mut is_missed = vec![false; rows.len()];
            for _ in 0..3 {
                let mut gain = vec![0.0; rows.len()];
                for (i, point) in self.data.points.iter().enumerate() {
                    let cost = |r: Option<f64>| match r {
                        Some(r) => 4.5 * (r * r / (8.0 * scale * scale)).ln_1p(),
                        None => -(scale.ln()) - 0.2,
                    };
                    gain[point.row] += cost(as_seen[i]) - cost(as_missed[i]);
                }
                let price = (rows.len() as f64).ln();
                is_missed = gain.iter().map(|&gain| gain > price).collect();
                let chosen: Vec<Option<f64>> = self
                    .data
                    .points
                    .iter()
                    .enumerate()
                    .map(|(i, p)| if is_missed[p.row] { as_missed[i] } else { as_seen[i] })
                    .collect();
                scale = noise(&self.data.points, &chosen).scale.max(FINEST);
            }
            let count = is_missed.iter().filter(|&&m| m).count();
            prior += binomial_ln(count, rows.len());
            for ((row, shifted), missed) in rows.iter_mut().zip(shifted).zip(is_missed) {
                if missed {
                    *row = shifted;
                }
            }
        }
        let (residuals, slopes) = self.compared(&rows, with_slopes);
        (residuals, slopes, prior)
    }

    /// The best fit of the causes of `given`, from their parameters, and of `added`, if given, from the most
    /// promising of its starts.
    pub(super) fn fit<'c>(
        &self,
        given: &Hypothesis<'c>,
        added: Option<&'c Candidate>,
        starts: usize,
    ) -> Option<Fit<'c>> {
        let hypotheses: Vec<Hypothesis<'c>> = match added {
            None => vec![given.clone()],
            Some(candidate) => candidate
                .starts()
                .into_iter()
                .map(|inner| {
                    let mut hypothesis = given.clone();
                    hypothesis.effects.push((candidate, inner));
                    hypothesis
                })
                .collect(),
        };
        let mut promising: Vec<(f64, Hypothesis<'c>)> = if hypotheses.len() == 1 {
            hypotheses.into_iter().map(|hypothesis| (0.0, hypothesis)).collect()
        } else {
            hypotheses
                .into_iter()
                .filter_map(|hypothesis| {
                    Some((self.evaluate(&hypothesis, false)?.score, hypothesis))
                })
                .collect()
        };
        promising.sort_by(|a, b| b.0.total_cmp(&a.0));
        promising
            .into_iter()
            .take(starts)
            .filter_map(|(_, hypothesis)| self.climb(hypothesis))
            .max_by(|a, b| a.evaluation.score.total_cmp(&b.evaluation.score))
    }

    /// Levenberg–Marquardt from a start.
    pub(super) fn climb<'c>(&self, start: Hypothesis<'c>) -> Option<Fit<'c>> {
        let mut hypothesis = start;
        let mut evaluation = self.evaluate(&hypothesis, true)?;
        let mut damping = 1e-3;
        for _ in 0..MOST_ROUNDS {
            let inner = hypothesis.inner();
            if inner.is_empty() {
                break;
            }
            let (information, gradient) = normal_equations(&hypothesis, &evaluation);
            let mut gained = None;
            for _ in 0..8 {
                let mut damped = information.clone();
                for i in 0..inner.len() {
                    damped[(i, i)] += damping * information[(i, i)].max(1e-12) + 1e-12;
                }
                let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else {
                    damping *= 10.0;
                    continue;
                };
                let next = within_bounds(&hypothesis, &inner, &step);
                match self.evaluate(&next, true) {
                    Some(better) if better.score > evaluation.score => {
                        gained = Some(better.score - evaluation.score);
                        hypothesis = next;
                        evaluation = better;
                        damping = (damping * 0.1).max(1e-9);
                        break;
                    }
                    _ => damping *= 10.0,
                }
            }
            match gained {
                Some(gain) if gain > SMALLEST_GAIN => {}
                _ => break,
            }
        }
        let freedom = freedom(&hypothesis, &evaluation);
        Some(Fit { hypothesis, evaluation, freedom })
    }
}

/// The mode, from 0, that a candidate of the instrument is about.
pub(super) fn mode_of(candidate: &Candidate) -> Option<usize> {
    candidate.at.as_deref()?.parse::<usize>().ok()?.checked_sub(1)
}

/// ln of the likeliest binomial probability of `count` in `of`, each row on its own.
fn binomial_ln(count: usize, of: usize) -> f64 {
    let share = |n: usize| {
        let p = n as f64 / of as f64;
        if n == 0 { 0.0 } else { n as f64 * p.ln() }
    };
    share(count) + share(of - count)
}

/// ln of how well the parameters agree with what is expected of them.
fn expectation(hypothesis: &Hypothesis<'_>) -> f64 {
    let mut sum = 0.0;
    for (candidate, inner) in &hypothesis.effects {
        for (parameter, &inner) in candidate.parameters.iter().zip(inner) {
            if let Some((nominal, precision)) = parameter.expectation() {
                sum -= 0.5 * precision * (inner - nominal).powi(2);
            }
        }
    }
    sum
}

/// Fisher information with what is expected, and the gradient of the score.
pub(super) fn normal_equations(
    hypothesis: &Hypothesis<'_>,
    evaluation: &Evaluation,
) -> (DMatrix<f64>, DVector<f64>) {
    let inner = hypothesis.inner();
    let p = inner.len();
    let mut information = DMatrix::zeros(p, p);
    let mut gradient = DVector::zeros(p);
    for ((residual, slope), weight) in
        evaluation.residuals.iter().zip(&evaluation.slopes).zip(&evaluation.noise.weights)
    {
        let Some(residual) = residual else { continue };
        for i in 0..p {
            gradient[i] += weight * slope[i] * residual;
            for j in 0..p {
                information[(i, j)] += weight * slope[i] * slope[j];
            }
        }
    }
    let parameters = hypothesis.effects.iter().flat_map(|(candidate, _)| &candidate.parameters);
    for (i, parameter) in parameters.enumerate() {
        if let Some((nominal, precision)) = parameter.expectation() {
            information[(i, i)] += precision;
            gradient[i] -= precision * (inner[i] - nominal);
        }
    }
    (information, gradient)
}

/// tr[J'WJ (J'WJ + P)⁻¹], with what hidden choices the candidates take.
fn freedom(hypothesis: &Hypothesis<'_>, evaluation: &Evaluation) -> f64 {
    let (information, _) = normal_equations(hypothesis, evaluation);
    let p = information.nrows();
    let mut freedom: f64 =
        hypothesis.effects.iter().map(|(candidate, _)| candidate.hidden_freedom).sum();
    freedom += p as f64;
    let parameters = hypothesis.effects.iter().flat_map(|(candidate, _)| &candidate.parameters);
    let precision: Vec<f64> =
        parameters.map(|parameter| parameter.expectation().map_or(0.0, |e| e.1)).collect();
    if let Some(inverse) = (information + DMatrix::from_diagonal_element(p, p, 1e-12)).try_inverse()
    {
        for (i, precision) in precision.iter().enumerate() {
            freedom -= (precision * inverse[(i, i)]).clamp(0.0, 1.0);
        }
    }
    freedom
}

fn within_bounds<'c>(
    hypothesis: &Hypothesis<'c>,
    inner: &[f64],
    step: &DVector<f64>,
) -> Hypothesis<'c> {
    /// No parameter moves further in one step: a factor of four, or four units.
    const LONGEST_STEP: f64 = 1.4;
    let parameters = hypothesis.effects.iter().flat_map(|(candidate, _)| &candidate.parameters);
    let next: Vec<f64> = parameters
        .zip(inner)
        .zip(step.iter())
        .map(|((parameter, &inner), &step)| {
            parameter.clamp(inner + step.clamp(-LONGEST_STEP, LONGEST_STEP))
        })
        .collect();
    hypothesis.with(&next)
}

#[cfg(test)]
mod tests {
    use super::super::candidate::{Parameter, Scale};
    use super::super::data::{Load, Point, Row};
    use super::*;
    use crate::model::{
        Conditions, CoordinateKind, ElasticJoint, Hinge, Inertial, Joint, JointKind, Link,
    };
    use nalgebra::{Isometry3, Matrix3, Vector3};

    /// A planar arm of three links.
    fn arm() -> Description {
        let link = |name: &str, mass_kg: f64| Link {
            name: name.into(),
            inertial: Some(Inertial {
                mass_kg,
                com_m: Vector3::new(0.25, 0.02, 0.03),
                inertia_kgm2: Matrix3::from_diagonal(&Vector3::new(0.3, 0.8, 0.7)),
            }),
            has_geometry: false,
        };
        let joint = |i: usize, x: f64| Joint {
            name: format!("j{i}"),
            kind: JointKind::Revolute,
            parent: if i == 1 { "base".into() } else { format!("l{}", i - 1) },
            child: format!("l{i}"),
            origin: Isometry3::translation(x, 0.0, 0.1),
            axis: if i == 1 { Vector3::z() } else { Vector3::y() },
            position_limit: None,
            velocity_limit: None,
            mimics: None,
        };
        let spring = |i: usize, stiffness: f64| ElasticJoint {
            joint: format!("j{i}"),
            stiffness,
            is_linear: false,
            damping: None,
        };
        Description {
            name: "arm".into(),
            links: vec![link("base", 50.0), link("l1", 30.0), link("l2", 20.0), link("l3", 8.0)],
            joints: vec![joint(1, 0.0), joint(2, 0.5), joint(3, 0.6)],
            base: None,
            tip: None,
            elastic_joints: vec![spring(1, 4e5), spring(2, 2e5), spring(3, 6e4)],
            extra: vec![],
            default_damping_ratio: 0.02,
            gravity_m_per_s2: Vector3::new(0.0, 0.0, -9.81),
            gravity_stiffness: false,
            drives: vec![],
            payload: None,
            beta1: None,
            beta2: None,
            calibration: None,
            corrections: vec![],
        }
    }

    fn data(rows: usize) -> Data {
        let rows: Vec<Row> = (0..rows)
            .map(|i| Row {
                q: (0..3).map(|j| (1.3 * (i + 1) as f64 * (j + 1) as f64).sin() * 2.0).collect(),
                conditions: Conditions {
                    temperature_c: Some(15.0 + i as f64),
                    amplitude_nm: Some(5.0 + 3.0 * i as f64),
                },
                load: Load::NOMINAL,
                sample_rate_hz: Some(40.0),
                index: i,
            })
            .collect();
        let points = (0..3 * rows.len())
            .map(|i| Point {
                row: i / 3,
                column: i % 3,
                ln_f: 3.0,
                unit: 1.0,
                rounding: 0.0,
                index: i,
            })
            .collect();
        Data { rows, points, columns: 3 }
    }

    fn parameter(name: &'static str, scale: Scale) -> Parameter {
        let bounds = [-1e9, 1e9];
        Parameter { name, scale, nominal: None, bounds, starts: vec![], spread: None }
    }

    /// d ln f by every kind of parameter, against differences of solved frequencies.
    #[test]
    fn sensitivities_are_the_differences_of_solved_frequencies() {
        let description = arm();
        let data = data(6);
        let problem = Problem { description: &description, data: &data };
        let log = |name| parameter(name, Scale::Log);
        let linear = |name| parameter(name, Scale::Linear(0.1));
        let hinge = Hinge {
            kind: CoordinateKind::Rotation,
            axes: vec![Vector3::y()],
            origin_m: Vector3::new(0.2, 0.0, 0.0),
            beyond: true,
        };
        let mut bends =
            Candidate::new(Cause::LinkFlexibility, "l1", vec![log("stiffness_nm_per_rad")]);
        bends.hinge = Some(hinge);
        let cases = [
            (
                Candidate::new(Cause::JointStiffness, "j2", vec![log("stiffness_nm_per_rad")]),
                vec![12.0],
            ),
            (Candidate::new(Cause::LinkInertia, "l2", vec![log("inertia_factor")]), vec![0.2]),
            (Candidate::new(Cause::LinkInertia, "l1", vec![log("mass_factor")]), vec![-0.2]),
            (
                Candidate::new(Cause::ComOffset, "l3", vec![linear("dx_m"), linear("dz_m")]),
                vec![0.3, -0.4],
            ),
            (Candidate::new(Cause::JointZeroOffset, "j3", vec![linear("offset_rad")]), vec![0.7]),
            (
                Candidate::new(Cause::Payload, "l3", vec![linear("mass_kg"), linear("com_x_m")]),
                vec![30.0, 1.0],
            ),
            (bends, vec![12.5]),
            (
                Candidate::new(Cause::DriveInertia, "j1", vec![linear("reflected_inertia_kgm2")]),
                vec![20.0],
            ),
            (
                Candidate::new(Cause::LoadDependentStiffness, "j2", vec![linear("change_per_nm")]),
                vec![0.02],
            ),
            (
                Candidate::new(
                    Cause::TemperatureDrift,
                    "j2",
                    vec![linear("change_per_k"), linear("factor")],
                ),
                vec![0.1, 9.0],
            ),
        ];
        for (candidate, inner) in &cases {
            let at = |inner: Vec<f64>| Hypothesis { effects: vec![(candidate, inner)] };
            let here = problem.evaluate(&at(inner.clone()), true).unwrap();
            for k in 0..inner.len() {
                let shifted = |by: f64| {
                    let mut inner = inner.clone();
                    inner[k] += by;
                    problem.evaluate(&at(inner), false).unwrap().residuals
                };
                let (below, above) = (shifted(-1e-5), shifted(1e-5));
                for i in 0..data.points.len() {
                    // The residual falls where the prediction rises.
                    let difference = (below[i].unwrap() - above[i].unwrap()) / 2e-5;
                    let slope = here.slopes[i][k];
                    let error = (slope - difference).abs();
                    assert!(
                        error < 1e-6 + 1e-4 * difference.abs(),
                        "{} {k} point {i}: {slope} {difference}",
                        candidate.cause
                    );
                }
            }
        }
    }

    /// A fit from afar finds what was put in, where nothing disturbs it.
    #[test]
    fn a_fit_finds_what_was_put_in() {
        let description = arm();
        let mut data = data(8);
        let log = parameter("stiffness_nm_per_rad", Scale::Log);
        let stiffness = Candidate::new(Cause::JointStiffness, "j2", vec![log]);
        let mass = parameter("mass_kg", Scale::Linear(1.0));
        let payload = Candidate::new(Cause::Payload, "l3", vec![mass]);
        let truth =
            Hypothesis { effects: vec![(&stiffness, vec![1.4e5_f64.ln()]), (&payload, vec![4.0])] };
        let residuals = Problem { description: &description, data: &data }
            .evaluate(&truth, false)
            .unwrap()
            .residuals;
        for (point, residual) in data.points.iter_mut().zip(residuals) {
            point.ln_f -= residual.unwrap();
        }
        let problem = Problem { description: &description, data: &data };
        let start =
            Hypothesis { effects: vec![(&stiffness, vec![2e5_f64.ln()]), (&payload, vec![0.5])] };
        let found = problem.climb(start).unwrap().hypothesis.inner();
        assert!(
            (found[0].exp() / 1.4e5 - 1.0).abs() < 1e-3 && (found[1] - 4.0).abs() < 1e-2,
            "{found:?}"
        );
    }

    /// A mode above half the rate shows folded, and sorted among the others.
    #[test]
    fn a_folded_mode_takes_its_place() {
        let description = arm();
        let data = data(4);
        let problem = Problem { description: &description, data: &data };
        let plain = problem.evaluate(&Hypothesis::default(), false).unwrap();
        let folds = Candidate::new(Cause::AliasedMode, "3", vec![]);
        let seen =
            problem.evaluate(&Hypothesis { effects: vec![(&folds, vec![])] }, false).unwrap();
        for row in 0..4 {
            let of = |e: &Evaluation| -> Vec<f64> {
                (0..3).map(|m| (3.0 - e.residuals[3 * row + m].unwrap()).exp()).collect()
            };
            let mut expected = of(&plain);
            assert!(expected[2] > 20.0, "{expected:?}");
            expected[2] = (expected[2] - 40.0 * (expected[2] / 40.0).round()).abs();
            expected.sort_by(f64::total_cmp);
            for (a, b) in of(&seen).iter().zip(&expected) {
                assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
            }
        }
    }
}
