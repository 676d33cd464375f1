//! Is what a model leaves mere noise? Residuals are held against many simple shapes that no cause
//! of the vocabulary needs to have: functions of a joint, of the frequency, of the order of the
//! rows, of a covariate, of a spring that varies with the pose or from pose to pose. Each is one F
//! test.

use rayon::prelude::*;

use super::data::{Data, Load};
use super::decorrelation::Decorrelation;
use super::fit::Fit;
use super::mechanics::Mechanics;
use super::outcome::{Shape, Structure};
use super::predict::participation;
use super::problem::Problem;
use super::statistics::p_value_of_gain;

/// Structure is significant if its p-value, corrected for the number of shapes, is below this.
pub(super) const SIGNIFICANCE: f64 = 0.005;

/// The shape that the residuals of `fit` follow most clearly, and the one that would be the best
/// explanation; `None` if there are too few points for any.
pub(super) fn structure(problem: &Problem<'_>, fit: &Fit<'_>) -> Option<Structures> {
    let of_all = Shapes::new(problem, fit)?;
    let mut shapes = of_all.smooth();
    let found = match problem.data.thinned() {
        None => {
            shapes.extend(of_all.by_pose());
            tested(problem.data, fit, &shapes, shapes.len())
        }
        Some(few) => {
            // A column a pose: a part of the poses shows it as well, in much less time and memory.
            let part = Problem { data: &few, ..*problem };
            let hypothesis = fit.hypothesis.clone();
            let evaluation = part.evaluate(&hypothesis)?;
            let of_part = Fit { hypothesis, evaluation, ..fit.clone() };
            let by_pose = Shapes::new(&part, &of_part)?.by_pose();
            let tries = shapes.len() + by_pose.len();
            let mut found = tested(problem.data, fit, &shapes, tries);
            found.extend(tested(&few, &of_part, &by_pose, tries));
            found
        }
    };
    let n = fit.evaluation.left.residuals.iter().flatten().count() as f64;
    let clearest = found
        .iter()
        .min_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.gain.total_cmp(&a.gain)))?;
    let log_evidence = |s: &Structure| s.gain - 0.5 * s.freedom as f64 * n.ln();
    let best = found.iter().max_by(|a, b| log_evidence(a).total_cmp(&log_evidence(b)))?;
    Some(Structures { clearest: clearest.clone(), best_log_evidence: log_evidence(best) })
}

/// The F tests of shapes, of which `tries` are tried in all.
fn tested(data: &Data, fit: &Fit<'_>, shapes: &[(Shape, Columns)], tries: usize) -> Vec<Structure> {
    let whitened = Whitened::of(data, fit);
    let n = whitened.count as f64;
    let test = |(shape, columns): &(Shape, Columns)| {
        let (gain, freedom) = whitened.gain(columns);
        let left = n - whitened.taken.len() as f64 - freedom as f64;
        if freedom == 0 || left < 4.0 {
            return None;
        }
        let p = whitened
            .p_value_in_mode(data, shape, columns)
            .unwrap_or_else(|| p_value_of_gain(gain, freedom as f64, left, n));
        let kept = (-2.0 * gain / n).exp();
        let share = 1.0 - kept * (left + freedom as f64) / left;
        let p_value = (p * tries as f64).min(1.0);
        Some(Structure { shape: shape.clone(), p_value, share, freedom, gain })
    };
    shapes.par_iter().filter_map(test).collect()
}

/// What [`structure`] finds.
#[derive(Debug, Clone)]
pub(super) struct Structures {
    pub(super) clearest: Structure,
    /// The gain of ln likelihood less what it costs, of the shape for which that is most.
    pub(super) best_log_evidence: f64,
}

/// Residuals, whitened and with what the fitted parameters take taken out.
struct Whitened<'d> {
    decorrelation: &'d Decorrelation,
    /// Square roots of the weights; 0 where there is no prediction.
    roots: Vec<f64>,
    /// Orthonormal columns that the parameters span.
    taken: Vec<Vec<f64>>,
    residual: Vec<f64>,
    square: f64,
    count: usize,
}

impl<'d> Whitened<'d> {
    fn of(data: &'d Data, fit: &Fit<'_>) -> Self {
        let evaluation = &fit.evaluation;
        let roots: Vec<f64> = evaluation.noise.weights.iter().map(|w| w.sqrt()).collect();
        let parameters = fit.hypothesis.inner().len();
        let mut taken: Vec<Vec<f64>> = Vec::new();
        for k in 0..parameters {
            let column = (0..data.points.len())
                .map(|i| evaluation.left.slopes[i].get(k).copied().unwrap_or(0.0) * roots[i])
                .collect();
            orthonormal(column, &mut taken);
        }
        let mut residual: Vec<f64> = evaluation
            .left
            .innovations
            .iter()
            .zip(&roots)
            .map(|(r, w)| r.unwrap_or(0.0) * w)
            .collect();
        for q in &taken {
            let along = dot(q, &residual);
            residual.iter_mut().zip(q).for_each(|(r, q)| *r -= along * q);
        }
        let square = dot(&residual, &residual);
        let count = evaluation.left.residuals.iter().flatten().count();
        let decorrelation = &data.decorrelation;
        Self { decorrelation, roots, taken, residual, square, count }
    }

    /// p-value of a shape that one mode alone follows, by the noise of that mode alone.
    fn p_value_in_mode(&self, data: &Data, shape: &Shape, columns: &[Vec<f64>]) -> Option<f64> {
        let (Shape::ModeOverJoint { mode, .. } | Shape::ModeOverPose { mode }) = *shape else {
            return None;
        };
        let own = data.points.iter().zip(&self.residual).zip(&self.roots);
        let own = own.filter(|((point, _), root)| point.column == mode && **root > 0.0);
        let squares: Vec<f64> = own.map(|((_, r), _)| r * r).collect();
        let n = squares.len() as f64;
        let (explained, freedom) = self.explained(columns);
        let taken = self.taken.len() as f64 * n / self.count.max(1) as f64;
        let left = n - taken - freedom as f64;
        if freedom == 0 || left < 4.0 {
            return None;
        }
        let total = squares.iter().sum::<f64>().max(n);
        let gain = -0.5 * n * (1.0 - explained / total).max(1e-12).ln();
        Some(p_value_of_gain(gain, freedom as f64, left, n))
    }

    /// Gain of ln likelihood and degrees of freedom of a shape.
    fn gain(&self, columns: &[Vec<f64>]) -> (f64, usize) {
        let (explained, freedom) = self.explained(columns);
        // Of a noise as fine as any instrument's the scale is known: what is below it shows
        // nothing.
        let total = self.square.max(self.count as f64);
        let kept = (1.0 - explained / total).max(1e-12);
        (-0.5 * self.count as f64 * kept.ln(), freedom)
    }

    /// The square that a shape takes off, and its degrees of freedom.
    fn explained(&self, columns: &[Vec<f64>]) -> (f64, usize) {
        let mut basis = self.taken.clone();
        let mut square = self.square;
        for column in columns {
            let mut column = column.clone();
            self.decorrelation.apply(&mut column);
            let whitened = column.iter().zip(&self.roots).map(|(c, w)| c * w).collect();
            if orthonormal(whitened, &mut basis)
                && let Some(new) = basis.last()
            {
                square -= dot(new, &self.residual).powi(2);
            }
        }
        (self.square - square, basis.len() - self.taken.len())
    }
}

/// Adds what is new in `column` to `basis`; `false` if nothing is.
pub(super) fn orthonormal(column: Vec<f64>, basis: &mut Vec<Vec<f64>>) -> bool {
    orthonormal_beyond(1e-8, column, basis)
}

/// The same where more than the share `least` of the column's square is new.
fn orthonormal_beyond(least: f64, mut column: Vec<f64>, basis: &mut Vec<Vec<f64>>) -> bool {
    let before = dot(&column, &column);
    for _ in 0..2 {
        for q in basis.iter() {
            let along = dot(q, &column);
            column.iter_mut().zip(q).for_each(|(c, q)| *c -= along * q);
        }
    }
    let square = dot(&column, &column);
    if square.is_nan() || square <= least * before || before == 0.0 {
        return false;
    }
    let norm = square.sqrt();
    column.iter_mut().for_each(|c| *c /= norm);
    basis.push(column);
    true
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

type Columns = Vec<Vec<f64>>;

/// Shapes with the columns that span them, one entry a point.
struct Shapes<'d> {
    data: &'d Data,
    /// Names of the elastic coordinates.
    coordinates: Vec<String>,
    /// See [`participation`].
    energies: Vec<Vec<Vec<[f64; 2]>>>,
}

impl<'d> Shapes<'d> {
    fn new(problem: &Problem<'d>, fit: &Fit<'_>) -> Option<Self> {
        let data = problem.data;
        let mut here =
            Mechanics::new(problem.description, &fit.hypothesis.corrections(), &data.rows)?;
        let coordinates = here.robot(data.rows.first()?)?.coordinates();
        let coordinates = coordinates.iter().map(|own| own.name.clone()).collect();
        let energies = participation(&mut here, data)?;
        Some(Self { data, coordinates, energies })
    }

    fn column(&self, of: &dyn Fn(usize) -> f64) -> Vec<f64> {
        (0..self.data.points.len()).map(of).collect()
    }

    fn of_mode(&self, mode: usize) -> impl Fn(usize) -> f64 + use<'_, 'd> {
        move |i| f64::from(u8::from(self.data.points[i].column == mode))
    }

    fn energy(&self, i: usize, coordinate: usize, kind: usize) -> f64 {
        let point = &self.data.points[i];
        self.energies[point.row].get(point.column).map_or(0.0, |mode| mode[coordinate][kind])
    }

    /// Sines and cosines of a joint's angle.
    fn harmonics(&self, base: &dyn Fn(usize) -> f64, joint: usize, most: i32) -> Columns {
        let angle = |i: usize| self.data.rows[self.data.points[i].row].q[joint];
        (1..=most)
            .map(f64::from)
            .flat_map(|k| {
                [
                    self.column(&|i| base(i) * (k * angle(i)).sin()),
                    self.column(&|i| base(i) * (k * angle(i)).cos()),
                ]
            })
            .collect()
    }

    /// A spring, an inertia, or all of an arm that is another at each pose: a column a row.
    fn by_pose(&self) -> Vec<(Shape, Columns)> {
        let data = self.data;
        let masked = |base: &dyn Fn(usize) -> f64| -> Columns {
            (0..data.rows.len())
                .map(|r| self.column(&|i| if data.points[i].row == r { base(i) } else { 0.0 }))
                .collect()
        };
        let mut shapes = vec![(Shape::PoseByPose, masked(&|_| 1.0))];
        for (c, coordinate) in self.coordinates.iter().cloned().enumerate() {
            let [spring, inertia] = [0, 1].map(|kind| masked(&|i| self.energy(i, c, kind)));
            shapes.push((Shape::SpringByPose { coordinate: coordinate.clone() }, spring));
            shapes.push((Shape::InertiaByPose { coordinate }, inertia));
        }
        shapes
    }

    /// An arm of which each inertia is another with each load; `None` where all rows have the same
    /// load, or hardly two have.
    fn by_load(&self) -> Option<Columns> {
        /// Most loads.
        const MOST: usize = 4;
        let rows = &self.data.rows;
        let mut loads: Vec<&Load> = Vec::new();
        for row in rows {
            if !loads.contains(&&row.load) {
                loads.push(&row.load);
            }
        }
        let of = |load: &Load, coordinate: usize| {
            self.column(&|i| {
                let is_own = rows[self.data.points[i].row].load == *load;
                if is_own { self.energy(i, coordinate, 1) } else { 0.0 }
            })
        };
        let columns =
            loads.iter().flat_map(|load| (0..self.coordinates.len()).map(|c| of(load, c)));
        (2..=MOST).contains(&loads.len()).then(|| columns.collect())
    }

    /// What varies smoothly.
    fn smooth(&self) -> Vec<(Shape, Columns)> {
        let data = self.data;
        // Nothing follows a joint that stands.
        let is_moved =
            |&joint: &usize| data.rows.iter().any(|r| r.q[joint] != data.rows[0].q[joint]);
        let joints = 0..data.rows.first().map_or(0, |row| row.q.len());
        let joints: Vec<usize> = joints.filter(is_moved).collect();
        let column = |of: &dyn Fn(usize) -> f64| self.column(of);
        let of_mode = |mode: usize| self.of_mode(mode);
        let mut shapes: Vec<(Shape, Columns)> = Vec::new();
        shapes.push((Shape::ModeByMode, (0..data.columns).map(|m| column(&of_mode(m))).collect()));
        for &joint in &joints {
            shapes.push((Shape::Joint { joint }, self.harmonics(&|_| 1.0, joint, 2)));
            for mode in 0..data.columns {
                let mut columns = vec![column(&of_mode(mode))];
                columns.extend(self.harmonics(&of_mode(mode), joint, 2));
                shapes.push((Shape::ModeOverJoint { mode, joint }, columns));
            }
        }
        for mode in 0..data.columns {
            let mut columns = vec![column(&of_mode(mode))];
            let of_joint = |&joint: &usize| self.harmonics(&of_mode(mode), joint, 1);
            columns.extend(joints.iter().flat_map(of_joint));
            shapes.push((Shape::ModeOverPose { mode }, columns));
        }
        for (c, coordinate) in self.coordinates.iter().enumerate() {
            let base = |i: usize| self.energy(i, c, 0);
            for &joint in &joints {
                let mut columns = vec![column(&base)];
                columns.extend(self.harmonics(&base, joint, 2));
                let coordinate = coordinate.clone();
                shapes.push((Shape::SpringOverJoint { coordinate, joint }, columns));
            }
        }
        shapes.extend(self.by_load().map(|columns| (Shape::Load, columns)));
        let powers = |of: &dyn Fn(usize) -> f64| -> Columns {
            vec![column(of), column(&|i| of(i).powi(2)), column(&|_| 1.0)]
        };
        let middle = 0.5 * data.rows.len() as f64;
        shapes.push((Shape::Order, powers(&|i| data.points[i].row as f64 / middle - 1.0)));
        for (shape, value) in [
            (Shape::Temperature, data.rows.iter().map(|r| r.conditions.temperature_c).collect()),
            (Shape::Amplitude, data.rows.iter().map(|r| r.conditions.amplitude_nm).collect()),
        ] {
            let value: Vec<Option<f64>> = value;
            let Some(values) = value.into_iter().collect::<Option<Vec<f64>>>() else { continue };
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>().sqrt();
            if spread <= 1e-9 * mean.abs() {
                continue;
            }
            let at = |i: usize| (values[data.points[i].row] - mean) / spread;
            let mut columns: Columns =
                (0..data.columns).map(|m| column(&|i| of_mode(m)(i) * at(i))).collect();
            columns.push(column(&|i| at(i).powi(2)));
            shapes.push((shape, columns));
        }
        // Of one mode the noise of a frequency would follow that frequency.
        if data.columns > 1 {
            shapes.push((Shape::Frequency, bumps(data)));
        }
        shapes
    }
}

/// Smooth bumps over ln f.
fn bumps(data: &Data) -> Columns {
    const BUMPS: i32 = 6;
    /// Of a few frequencies that were measured again and again, more bumps than frequencies would
    /// follow the noise.
    const LEAST: f64 = 1e-3;
    let low = data.points.iter().map(|p| p.ln_f).fold(f64::INFINITY, f64::min);
    let high = data.points.iter().map(|p| p.ln_f).fold(f64::NEG_INFINITY, f64::max);
    let width = (high - low).max(1e-9) / f64::from(BUMPS - 1);
    let mut bumps = Columns::new();
    for b in 0..BUMPS {
        let at = |ln_f: f64| (ln_f - low) / width - f64::from(b);
        let bump = data.points.iter().map(|p| (-0.5 * at(p.ln_f).powi(2)).exp()).collect();
        orthonormal_beyond(LEAST, bump, &mut bumps);
    }
    bumps
}

#[cfg(test)]
mod tests {
    use super::super::candidate::{Candidate, Parameter, Scale};
    use super::super::fit::tests::{arm, data};
    use super::super::hypothesis::Hypothesis;
    use super::*;
    use crate::model::{Cause, Hinge};
    use nalgebra::Vector3;

    /// A cause may add a coordinate before those of the file, which has no name for it.
    #[test]
    fn a_shape_names_a_coordinate_of_the_model_with_the_causes() {
        let description = arm();
        let data = data(8);
        let problem = Problem { description: &description, data: &data };
        let stiffness = Parameter {
            name: "stiffness_n_per_m",
            scale: Scale::Log,
            nominal: None,
            bounds: [1.0, 1e12],
            starts: vec![],
            expected: None,
        };
        let mut base = Candidate::new(Cause::BaseCompliance, "base", vec![stiffness]);
        base.hinge = Some(Hinge::shift(Vector3::x()));
        let names = |hypothesis: Hypothesis<'_>| {
            let fit = problem.optimise(hypothesis).unwrap();
            Shapes::new(&problem, &fit).unwrap().coordinates
        };
        let plain = names(Hypothesis::default());
        let with_base = names(Hypothesis { effects: vec![(&base, vec![20.0])] });
        assert_eq!(plain.len() + 1, with_base.len());
        assert!(with_base.contains(&"base_compliance at base".to_owned()), "{with_base:?}");
        assert!(plain.iter().all(|name| with_base.contains(name)), "{with_base:?}");
    }

    /// Noise of modes that do not move is all that their measured frequencies follow.
    #[test]
    fn noise_does_not_follow_its_own_frequency() {
        assert!(clearest_of_one_pose(1) > SIGNIFICANCE);
        assert!(clearest_of_one_pose(3) > SIGNIFICANCE);
    }

    /// p-value of what the noise of so many modes follows, measured at one pose again and again.
    fn clearest_of_one_pose(modes: usize) -> f64 {
        let description = arm();
        let mut data = data(24);
        data.points.retain(|point| point.column < modes);
        data.columns = modes;
        for row in &mut data.rows {
            row.q = vec![0.1; 3];
        }
        let problem = Problem { description: &description, data: &data };
        let exact = problem.optimise(Hypothesis::default()).unwrap();
        let mut noisy = data.clone();
        let points = noisy.points.iter_mut().zip(&exact.evaluation.left.residuals);
        for (i, (point, off)) in points.enumerate() {
            point.ln_f += 0.004 * (2.399 * (i + 1) as f64).sin() - off.unwrap();
        }
        let problem = Problem { description: &description, data: &noisy };
        let fit = problem.optimise(Hypothesis::default()).unwrap();
        structure(&problem, &fit).unwrap().clearest.p_value
    }
}
