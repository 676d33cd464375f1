//! Of models that a table cannot tell apart, the one that promises least where it was not measured.

use super::models::Model;
use super::next_poses::anywhere;
use super::posterior::predicted;
use super::problem::Problem;
use crate::model::Robot;

/// Log evidence by which the best model may be ahead of one that is taken instead: a factor of
/// three, which noise makes.
const ALIKE: f64 = 1.0;

/// Share of the best one's change of the frequencies that is clearly less.
const CLEARLY_LESS: f64 = 0.8;

/// Poses at which models are compared.
const POSES: u32 = 32;

/// Of the models as good as `best` with as many causes, none of the instrument, the one that
/// changes the frequencies of the model without causes least over all poses, if that is clearly
/// less than `best` does.
pub(super) fn least_extrapolating<'m, 'c>(
    problem: &Problem<'_>,
    best: &Model<'c>,
    seen: &'m [Model<'c>],
) -> Option<&'m Model<'c>> {
    let is_of_arm = |model: &Model<'_>| {
        model.fit.hypothesis.effects.iter().all(|(c, _)| !c.cause.is_of_the_instrument())
    };
    let is_as_good = |model: &&Model<'c>| {
        model.causes() == best.causes()
            && model.log_evidence > best.log_evidence - ALIKE
            && model.shared(best) < best.causes()
            && is_of_arm(model)
    };
    let rivals: Vec<&Model<'c>> = seen.iter().filter(is_as_good).collect();
    if rivals.is_empty() || !is_of_arm(best) {
        return None;
    }
    let robot = Robot::new(problem.description).ok()?;
    let poses = anywhere(&robot, problem.data, POSES);
    let at = |corrections: &[_]| predicted(problem.description, corrections, &[], &poses);
    let without = at(&[])?;
    let change = |model: &Model<'_>| -> Option<f64> {
        let with = at(&model.fit.hypothesis.corrections())?;
        let square = |(with, without): (&Vec<f64>, &Vec<f64>)| -> f64 {
            let both = with.iter().zip(without).take(problem.data.columns);
            both.map(|(with, without)| (with - without).powi(2)).sum()
        };
        let sum: f64 = with.iter().zip(&without).map(square).sum();
        sum.is_finite().then_some(sum.sqrt())
    };
    let of_best = change(best)?;
    let rivals = rivals.into_iter().filter_map(|rival| Some((change(rival)?, rival)));
    let (least, rival) = rivals.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (least < CLEARLY_LESS * of_best).then_some(rival)
}

#[cfg(test)]
mod tests {
    use super::super::candidate::{Candidate, Parameter, Scale};
    use super::super::fit::tests::{arm, data};
    use super::super::hypothesis::Hypothesis;
    use super::*;
    use crate::model::Cause;

    fn candidate(at: &str, most: f64) -> Candidate {
        let offset = Parameter {
            name: "dx_m",
            scale: Scale::Linear(0.1),
            nominal: Some(0.0),
            bounds: [-most, most],
            starts: vec![],
            expected: None,
        };
        Candidate::new(Cause::ComOffset, at, vec![offset])
    }

    /// Two causes that a table is said to hold alike, whatever it holds; one of them may move its
    /// mass by no more than a centimetre.
    #[test]
    fn of_models_alike_the_one_that_changes_less_is_taken() {
        let description = arm();
        let data = data(12);
        let problem = Problem { description: &description, data: &data };
        let candidates = [candidate("l2", 0.01), candidate("l3", 1.0)];
        let model = |candidate| {
            let hypothesis = Hypothesis { effects: vec![(candidate, vec![0.1])] };
            Model { fit: problem.optimise(hypothesis).unwrap(), log_evidence: 0.0 }
        };
        let rows = &data.rows;
        let at = |corrections: &[_]| predicted(&description, corrections, &[], rows).unwrap();
        let change = |model: &Model<'_>| -> f64 {
            let with = at(&model.fit.hypothesis.corrections());
            let both = with.iter().flatten().zip(at(&[]).into_iter().flatten().collect::<Vec<_>>());
            both.map(|(a, b)| (a - b).powi(2)).sum::<f64>()
        };
        let [less, more] = candidates.each_ref().map(model);
        assert!(change(&less) < 0.5 * change(&more), "{} {}", change(&less), change(&more));
        let at = |model: &Model<'_>| model.fit.hypothesis.effects[0].0.at.clone();
        // The rival is behind by so much.
        let taken = |best: &Model<'_>, rival: &Model<'_>, by: f64| {
            let rival = [Model { fit: rival.fit.clone(), log_evidence: -by }];
            least_extrapolating(&problem, best, &rival).map(at)
        };
        assert_eq!(taken(&more, &less, 0.5), Some(at(&less)));
        assert_eq!(taken(&more, &less, 1.5), None);
        assert_eq!(taken(&less, &more, 0.0), None);
    }
}
